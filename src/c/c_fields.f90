!> The library for C: fields on pixels; `include/asperity.h` has what each
!> procedure does.
module asperity_c_fields
  use, intrinsic :: iso_c_binding, only: c_int, c_ptr
  use asperity, only: add_reals, add_wholes, array_table, contact_field, decimal_text, &
                      of_contacts, of_positions, place_of
  use asperity_contact_field, only: contact_marks
  use asperity_library_turn, only: library_turn
  use asperity_c_outcome, only: add_pixels, begin_outcome, finish_outcome, look_at, outcome, &
                                set_text, table_fields, table_map, text_unit
  implicit none
  private

  public :: c_fields

contains

  !> `asperity_fields`.
  type(c_ptr) function c_fields(solved, position, state) bind(c, name='asperity_fields') &
    result(handle)
    type(c_ptr), value :: solved        !! outcome of a solve
    integer(c_int), value :: position, state  !! from 1; -1: the last state
    type(library_turn) :: turn
    type(outcome), pointer :: from, new
    type(contact_field), pointer :: field

    call begin_outcome(new, handle, turn)
    if (.not. associated(new)) return
    call choose_field(solved, position, state, from, new, field)
    if (associated(field)) &
      call set_field(new, field, unit_of_column(from%tables(of_positions), 'mean_gap'), &
                     unit_of_column(from%tables(of_contacts), 'average_pressure'))
    call finish_outcome(new)
  end function c_fields

  ! Finds the fields of a state of an outcome, or the reason why there are none.
  subroutine choose_field(solved, position, state, from, new, field)
    type(c_ptr), intent(in) :: solved
    integer, intent(in) :: position, state
    type(outcome), pointer, intent(out) :: from
    type(outcome), intent(inout) :: new
    type(contact_field), pointer, intent(out) :: field  ! not associated: none
    logical :: has_fields
    integer :: which

    nullify (field)
    call look_at(solved, from)
    has_fields = .false.
    if (.not. associated(from)) then
      call new%problems%add('solved: found NULL, expected the outcome of a solve')
      return
    end if
    if (allocated(from%kept)) has_fields = allocated(from%kept(1)%fields)
    if (.not. has_fields) then
      new%failure = 'no fields: expected a height map solved on its pixels, for instance ' // &
                    'with interaction = ''boundary'', or field_spacing in &surfaces for one ' // &
                    'position of asperities, and fields requested (fields=True in Python)'
    else if (position < 1 .or. position > size(from%kept)) then
      call new%problems%add('position: found ' // decimal_text(position) // ', expected ' // &
                            numbers_in_words(1, size(from%kept)))
    else
      associate (fields => from%kept(position)%fields)
        which = findloc(fields%state, state, 1)
        if (state == -1) which = size(fields)
        if (which > 0) field => from%kept(position)%fields(which)
        if (which > 0) return
        call new%problems%add('state: found ' // decimal_text(state) // ', expected ' // &
          numbers_in_words(fields(1)%state, fields(size(fields))%state) // ', or -1 for the last')
      end associate
    end if

  contains

    pure function numbers_in_words(first, last) result(text)
      integer, intent(in) :: first, last
      character(len=:), allocatable :: text

      text = decimal_text(first)
      if (last > first) text = 'a number from ' // text // ' to ' // decimal_text(last)
    end function numbers_in_words

  end subroutine choose_field

  ! Tables and unit of one state.
  subroutine set_field(new, field, length, pressure)
    type(outcome), intent(inout) :: new
    type(contact_field), intent(in) :: field
    character(len=*), intent(in) :: length, pressure  ! units; empty: not known

    call set_text(new, text_unit, length)
    associate (table => new%tables(table_map))
      call add_wholes(table, 'columns', [field%columns])
      call add_wholes(table, 'rows', [field%rows])
      call add_reals(table, 'spacing_x', field%pixel_spacing(1:1), length)
      call add_reals(table, 'spacing_y', field%pixel_spacing(2:2), length)
      call add_reals(table, 'origin_x', field%origin(1:1), length)
      call add_reals(table, 'origin_y', field%origin(2:2), length)
      call add_wholes(table, 'periodic_x', [merge(1, 0, field%periodic .or. field%strip_axis == 1)])
      call add_wholes(table, 'periodic_y', [merge(1, 0, field%periodic .or. field%strip_axis == 2)])
      call add_wholes(table, 'boundary_contacts', [field%boundary_contacts])
      call add_wholes(table, 'hertz_contacts', [field%hertz_contacts])
    end associate
    associate (table => new%tables(table_fields))
      call add_pixels(table, 'pressure', field%pressure, pressure, new%failure)
      call add_pixels(table, 'gap', field%gap, length, new%failure)
      call add_pixels(table, 'displacement', field%displacement, length, new%failure)
      call add_marks('contact', contact_marks(field))
      if (allocated(field%traction)) then
        call add_pixels(table, 'traction_x', field%traction, pressure, new%failure)
        call add_pixels(table, 'traction_y', field%traction_y, pressure, new%failure)
        call add_pixels(table, 'slip_x', field%slip_x, length, new%failure)
        call add_pixels(table, 'slip_y', field%slip_y, length, new%failure)
        call add_marks('stick', field%sticks)
      end if
    end associate

  contains

    ! One column of 1 and 0, row by row of the map.
    subroutine add_marks(name, marks)
      character(len=*), intent(in) :: name
      logical, intent(in) :: marks(:, :)

      if (allocated(new%failure)) return
      call add_wholes(new%tables(table_fields), name, [merge(1, 0, marks)])
      new%tables(table_fields)%columns(size(new%tables(table_fields)%columns))%unit = ''
    end subroutine add_marks

  end subroutine set_field

  ! Unit of a column of a table; empty where it has none.
  pure function unit_of_column(table, name) result(unit)
    type(array_table), intent(in) :: table
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: unit
    integer :: i

    unit = ''
    i = place_of(table, name)
    if (i == 0) return
    if (allocated(table%columns(i)%unit)) unit = table%columns(i)%unit
  end function unit_of_column

end module asperity_c_fields
