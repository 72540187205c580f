!> Names of columns in a line, each perhaps with a unit: `z [um]`, `z (um)`, `z/um`, `z_um`, `z um`.
module asperity_column_names
  use asperity_delimited_text, only: cells_of, line_cells, separator_of
  use asperity_height_map, only: plain_unit, unit_number
  use asperity_input_text, only: lower_case, replaced_text
  use asperity_word_hint, only: nearest_word
  implicit none
  private

  public :: column_list, columns_named, is_height_name, split_name

  integer, parameter :: name_length = 32, unit_length = 16

  !> Names of columns in small letters, with their units.
  type :: column_list
    character(len=name_length), allocatable :: name(:)  !! empty: a column without a name
    character(len=unit_length), allocatable :: unit(:)  !! as written, `um` with u; empty: none
  contains
    procedure :: of_points   !! places of x, y and z
  end type column_list

contains

  !> The names in a line.
  pure function columns_named(text) result(found)
    character(len=*), intent(in) :: text  !! line of names
    type(column_list) :: found            !! names and units
    character(len=:), allocatable :: joined, name, unit
    character(len=1) :: separator
    type(line_cells) :: cells
    integer :: i, used

    separator = separator_of(text)
    ! Between blanks a unit belongs to the word before it.
    joined = text
    used = 0
    do i = 1, merge(len(text), 0, separator == ' ')
      if (scan(text(i:i), '[(/') == 1) used = len_trim(joined(:used))
      if (text(i:i) == ' ' .and. index(joined(max(1, used):used), '/') == 1) cycle
      used = used + 1
      joined(used:used) = text(i:i)
    end do
    if (separator == ' ') joined = joined(:used)
    cells = cells_of(joined, separator, separator /= ' ')
    allocate (found%name(cells%cell_count), found%unit(cells%cell_count))
    do i = 1, cells%cell_count
      call split_name(joined(cells%first(i):cells%last(i)), name, unit)
      found%name(i) = name
      found%unit(i) = unit
    end do
  end function columns_named

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

  !> Places of x, y and z among the names: in any order, z by one of its names, or the only other
  !> column; 0, 0, 0 where they are not there.
  pure function of_points(self) result(place)
    class(column_list), intent(in) :: self  !! names of a line
    integer :: place(3)                     !! which of the names are x, y and z
    integer :: i

    place = [findloc(self%name == 'x', .true., 1), findloc(self%name == 'y', .true., 1), 0]
    do i = size(self%name), 1, -1
      if (is_height_name(self%name(i))) place(3) = i
    end do
    if (all(place(:2) > 0) .and. place(3) == 0 .and. size(self%name) == 3) then
      place(3) = 6 - place(1) - place(2)
      if (nearest_word(self%name(place(3)), ['height']) > 0) place(3) = 0
    end if
    if (any(place == 0) .or. any(self%name == 'radius')) place = 0
  end function of_points

  !> Whether a column of this name has heights without doubt.
  pure logical function is_height_name(name)
    character(len=*), intent(in) :: name  !! in small letters

    is_height_name = any(name == [character(len=9) :: 'z', 'height', 'heights', 'value', &
                                  'values', 'elevation'])
  end function is_height_name

end module asperity_column_names
