!> Names of columns in a line, each perhaps with a unit: `z [um]`, `z (um)`, `z/um`, `z_um`, `z um`.
module asperity_column_names
  use asperity_height_map, only: plain_unit, unit_number
  use asperity_input_text, only: lower_case, replaced_text
  implicit none
  private

  public :: split_name

contains

  !> A name in small letters without quotes, and the unit behind it.
  pure subroutine split_name(cell, name, unit)
    character(len=*), intent(in) :: cell                      !! name and unit as written
    character(len=:), allocatable, intent(out) :: name, unit  !! empty: there is none
    character(len=len(cell)) :: word
    integer :: at, i, used

    word = adjustl(replaced_text(replaced_text(cell, '"', ''), '''', ''))
    used = len_trim(word)
    unit = ''
    at = scan(word, '[(/')
    if (at > 1) then
      i = used
      if (word(at:at) /= '/') i = at + scan(word(at + 1:used), '])') - 1
      unit = plain_unit(word(at + 1:i))
      used = at - 1
    else
      at = scan(word(:used), '_ ', back=.true.)
      if (at > 1) unit = plain_unit(word(at + 1:used))
      if (unit_number(unit) == 0) unit = ''
      if (unit /= '') used = at - 1
    end if
    name = trim(lower_case(word(:used)))
  end subroutine split_name

end module asperity_column_names
