!> The library for C: pressure, gap and displacement on the pixels of a height map, or on the grid
!> of a scene of asperities.
module asperity_c_fields
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_c_binding, only: c_int, c_ptr
  use, intrinsic :: iso_fortran_env, only: real64
  use asperity, only: add_reals, add_wholes, array_table, contact_field, decimal_text, &
                      not_computed, not_enough_memory, of_contacts, of_positions
  use asperity_contact_field, only: contact_marks
  use asperity_c_outcome, only: begin_outcome, finish_outcome, look_at, outcome, set_text, &
                                table_fields, table_map, text_unit
  implicit none
  private

  public :: c_fields

contains

  !> `asperity_fields`.
  type(c_ptr) function c_fields(solved, position, state) bind(c, name='asperity_fields') &
    result(handle)
    type(c_ptr), value :: solved        !! outcome of a solve
    integer(c_int), value :: position   !! from 1
    integer(c_int), value :: state      !! from 1; -1: the last
    type(outcome), pointer :: from, new
    integer :: which

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    call look_at(solved, from)
    if (.not. associated(from)) then
      call new%problems%add('solved: found NULL, expected the outcome of a solve')
    else if (.not. allocated(from%fields)) then
      new%failure = 'no fields: expected a height map solved on its pixels, for instance ' // &
                    'with interaction = ''boundary'', or field_spacing in &surfaces for one ' // &
                    'position of asperities, and fields requested'
    else
      which = field_of(from%fields, position, state)
      if (which > 0) then
        call set_field(new, from%fields(which), unit_of_column(from%tables(of_positions), &
                                                               'mean_gap'), &
                       unit_of_column(from%tables(of_contacts), 'average_pressure'))
      else if (position /= from%fields(1)%position) then
        call new%problems%add('position: found ' // decimal_text(position) // ', expected ' // &
                              decimal_text(from%fields(1)%position))
      else
        call new%problems%add('state: found ' // decimal_text(state) // ', expected ' // &
                              states_in_words(from%fields) // ', or -1 for the last')
      end if
    end if
    call finish_outcome(new)
  end function c_fields

  ! The fields of a state; 0: there are none.
  pure integer function field_of(fields, position, state) result(which)
    type(contact_field), intent(in) :: fields(:)
    integer, intent(in) :: position, state

    which = size(fields)
    if (state == -1 .and. fields(which)%position == position) return
    do which = size(fields), 1, -1
      if (fields(which)%position == position .and. fields(which)%state == state) return
    end do
  end function field_of

  ! The numbers of the states.
  function states_in_words(fields) result(text)
    type(contact_field), intent(in) :: fields(:)
    character(len=:), allocatable :: text

    text = decimal_text(fields(1)%state)
    if (size(fields) > 1) text = 'a number from ' // text // ' to ' // &
                                 decimal_text(fields(size(fields))%state)
  end function states_in_words

  ! Tables and unit of one state.
  subroutine set_field(new, field, length, pressure)
    type(outcome), intent(inout) :: new
    type(contact_field), intent(in) :: field
    character(len=*), intent(in) :: length, pressure  ! units; empty: not known
    integer :: status

    call set_text(new, text_unit, length)
    associate (table => new%tables(table_map))
      call add_wholes(table, 'columns', [field%columns])
      call add_wholes(table, 'rows', [field%rows])
      call add_reals(table, 'spacing_x', field%pixel_spacing(1:1), length)
      call add_reals(table, 'spacing_y', field%pixel_spacing(2:2), length)
      call add_reals(table, 'origin_x', field%origin(1:1), length)
      call add_reals(table, 'origin_y', field%origin(2:2), length)
      call add_wholes(table, 'boundary_contacts', [field%boundary_contacts])
      call add_wholes(table, 'hertz_contacts', [field%hertz_contacts])
    end associate
    associate (table => new%tables(table_fields))
      table%rows = size(field%pressure)
      allocate (table%columns(merge(6, 4, allocated(field%traction))))
      call set_marks(4, 'contact', contact_marks(field))
      if (allocated(field%traction)) then
        if (status == 0) call set_values(5, 'traction', field%traction, pressure)
        if (status == 0) call set_marks(6, 'stick', field%sticks)
      end if
      if (status == 0) call set_values(1, 'pressure', field%pressure, pressure)
      if (status == 0) call set_values(2, 'gap', field%gap, length)
      if (status == 0) call set_values(3, 'displacement', field%displacement, length)
      if (status /= 0) then
        new%failure = not_enough_memory // ' for the fields as arrays'
        deallocate (table%columns)
        table%rows = 0
        return
      end if
    end associate

  contains

    ! One column, row by row of the map.
    subroutine set_values(number, name, values, unit)
      integer, intent(in) :: number
      character(len=*), intent(in) :: name, unit
      real(real64), intent(in) :: values(:, :)
      integer :: j

      associate (column => new%tables(table_fields)%columns(number))
        column%name = name
        column%unit = unit
        allocate (column%reals(size(values)), stat=status)
        if (status /= 0) return
        do j = 1, size(values, 2)
          column%reals((j - 1) * size(values, 1) + 1:j * size(values, 1)) = &
            merge(values(:, j), ieee_value(0.0_real64, ieee_quiet_nan), &
                  values(:, j) > not_computed)
        end do
      end associate
    end subroutine set_values

    ! One column of 1 and 0, row by row of the map.
    subroutine set_marks(number, name, marks)
      integer, intent(in) :: number
      character(len=*), intent(in) :: name
      logical, intent(in) :: marks(:, :)
      integer :: j

      associate (column => new%tables(table_fields)%columns(number))
        column%name = name
        column%unit = ''
        allocate (column%wholes(size(marks)), stat=status)
        if (status /= 0) return
        do j = 1, size(marks, 2)
          column%wholes((j - 1) * size(marks, 1) + 1:j * size(marks, 1)) = merge(1, 0, marks(:, j))
        end do
      end associate
    end subroutine set_marks

  end subroutine set_field

  ! Unit of a column of a table; empty where it has none.
  pure function unit_of_column(table, name) result(unit)
    type(array_table), intent(in) :: table
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: unit
    integer :: i

    unit = ''
    if (.not. allocated(table%columns)) return
    do i = 1, size(table%columns)
      if (table%columns(i)%name == name .and. allocated(table%columns(i)%unit)) &
        unit = table%columns(i)%unit
    end do
  end function unit_of_column

end module asperity_c_fields
