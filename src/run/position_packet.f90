!> The result of a position as words of 64 bits, for another image or a file.
!>
!> Numbers are copied bit by bit, so that the result is restored exactly. Only the version of the
!> program that wrote the words reads them.
module asperity_position_packet
  use asperity_contact_records, only: contact_row, effect_record, position_result, state_row
  use asperity_effect_header, only: column_name
  use asperity_effect_names, only: known_effects
  use asperity_kinds, only: int64
  use asperity_theory_warnings, only: theory_warning
  implicit none
  private

  public :: pack_position, unpack_position

  integer(int64), parameter :: word(1) = 0_int64  ! mold of `transfer` to words
  ! Numbers of words: a position without its lists, a state, a contact, an effect, a warning, a
  ! column. These records are copied whole.
  integer(int64), parameter :: of_head = 34 + size(known_effects), &
    of_state = storage_size(state_row()) / storage_size(word), &
    of_row = storage_size(contact_row()) / storage_size(word), &
    of_effect = storage_size(effect_record()) / storage_size(word), &
    of_warning = storage_size(theory_warning()) / storage_size(word), &
    of_column = storage_size(column_name()) / storage_size(word)

contains

  !> Converts a result to words.
  pure subroutine pack_position(result, words)
    type(position_result), intent(in) :: result             !! result of a position
    integer(int64), allocatable, intent(out) :: words(:)    !! words, at least those of the head
    integer(int64) :: values(2)
    integer :: effects, columns, of_contacts, warnings

    warnings = 0
    if (allocated(result%warnings)) warnings = size(result%warnings)
    effects = -1
    columns = 0
    of_contacts = 0
    values = 0_int64
    if (allocated(result%effects)) then
      effects = size(result%effects)
      columns = size(result%state_values)
      of_contacts = size(result%contact_columns)
      ! A list of contacts that is not kept has no columns.
      if (allocated(result%contact_values)) values = shape(result%contact_values)
    end if
    words = [transfer([result%x_displacement, result%y_displacement, result%error_estimate, &
                       result%nominal_area], word), &
             int([merge(1, 0, result%limit_reached), result%overlapping_circles, &
                  size(result%states), result%rows_used, effects, columns], int64), values, &
             int([warnings, of_contacts], int64), &
             transfer(result%no_estimate, word), &
             transfer(result%left_out, word), &
             transfer(result%states, word)]
    if (warnings > 0) words = [words, transfer(result%warnings, word)]
    if (result%rows_used > 0) words = [words, transfer(result%rows(:result%rows_used), word)]
    if (effects < 0) return
    words = [words, transfer(result%effects, word), transfer(result%state_values, word), &
             transfer(result%state_columns, word), transfer(result%contact_columns, word)]
    if (product(values) > 0_int64) &
      words = [words, transfer(pack(result%contact_values, .true.), word)]
  end subroutine pack_position

  !> Converts words to the result.
  pure subroutine unpack_position(words, result)
    integer(int64), intent(in) :: words(:)         !! words of pack_position
    type(position_result), intent(out) :: result   !! result of the position
    integer(int64) :: at, values(2)
    integer :: states, effects, columns, of_contacts, warnings

    result%x_displacement = transfer(words(1), result%x_displacement)
    result%y_displacement = transfer(words(2), result%y_displacement)
    result%error_estimate = transfer(words(3), result%error_estimate)
    result%nominal_area = transfer(words(4), result%nominal_area)
    result%limit_reached = words(5) == 1_int64
    result%overlapping_circles = int(words(6))
    states = int(words(7))
    result%rows_used = int(words(8))
    effects = int(words(9))
    columns = int(words(10))
    values = words(11:12)
    warnings = int(words(13))
    of_contacts = int(words(14))
    result%no_estimate = transfer(words(15:34), result%no_estimate)
    result%left_out = transfer(words(35:of_head), result%left_out, size(result%left_out))
    allocate (result%states(states), result%rows(result%rows_used))
    at = of_head
    result%states = transfer(words(at + 1:at + of_state * states), result%states, states)
    at = at + of_state * states
    if (warnings > 0) then
      allocate (result%warnings(warnings))
      result%warnings = transfer(words(at + 1:at + of_warning * warnings), result%warnings, &
                                 warnings)
      at = at + of_warning * warnings
    end if
    result%rows = transfer(words(at + 1:at + of_row * result%rows_used), result%rows, &
                           result%rows_used)
    at = at + of_row * result%rows_used
    if (effects < 0) return
    allocate (result%effects(effects), result%state_values(columns), &
              result%state_columns(columns), result%contact_columns(of_contacts), &
              result%contact_values(values(1), values(2)))
    result%effects = transfer(words(at + 1:at + of_effect * effects), result%effects, effects)
    at = at + of_effect * effects
    result%state_values = transfer(words(at + 1:at + columns), result%state_values, columns)
    at = at + columns
    result%state_columns = transfer(words(at + 1:at + of_column * columns), &
                                    result%state_columns, columns)
    at = at + of_column * columns
    result%contact_columns = transfer(words(at + 1:at + of_column * of_contacts), &
                                      result%contact_columns, of_contacts)
    at = at + of_column * of_contacts
    result%contact_values = reshape(transfer(words(at + 1:at + product(values)), &
                                             result%state_values, product(values)), values)
  end subroutine unpack_position

end module asperity_position_packet
