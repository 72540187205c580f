!> The result of a position as numbers, to be sent to another image or kept in a file.
!>
!> Every number is a double, so that the result that comes back is the one that went, bit for bit.
module asperity_position_packet
  use asperity_contact_records, only: contact_row, position_result, state_row
  use asperity_kinds, only: real64
  implicit none
  private

  public :: pack_position, unpack_position

  ! Numbers of a position without its states, of a state, of a contact.
  integer, parameter :: of_head = 7, of_state = 10, of_row = 15

contains

  !> The numbers of a result, with those that somebody adds.
  pure subroutine pack_position(result, more, numbers)
    type(position_result), intent(in) :: result               !! a position that is solved
    real(real64), intent(in) :: more(:)                       !! what comes behind
    real(real64), allocatable, intent(out) :: numbers(:)      !! both
    integer :: i, at, states

    states = size(result%states)
    allocate (numbers(of_head + of_state * states + of_row * result%rows_used + size(more)))
    numbers(:of_head) = [result%x_displacement, result%y_displacement, &
                         merge(1.0_real64, 0.0_real64, result%limit_reached), &
                         real(result%overlapping_circles, real64), result%first_step_pressure, &
                         real(states, real64), real(result%rows_used, real64)]
    at = of_head
    do i = 1, states
      associate (state => result%states(i))
        numbers(at + 1:at + of_state) = &
          [state%approach, state%closing, state%time, real(state%contacts, real64), state%load, &
           state%vertical_load, state%area, state%projected_area, &
           real(state%first_row, real64), real(state%last_row, real64)]
      end associate
      at = at + of_state
    end do
    do i = 1, result%rows_used
      associate (row => result%rows(i))
        numbers(at + 1:at + of_row) = &
          [real(row%area_no, real64), real(row%upper, real64), real(row%lower, real64), &
           merge(1.0_real64, 0.0_real64, row%limit_exceeded), row%x, row%y, row%penetration, &
           row%overlap, row%area, row%projected_area, row%slope, row%load, row%vertical_load, &
           row%average_pressure, row%maximum_pressure]
      end associate
      at = at + of_row
    end do
    numbers(at + 1:) = more
  end subroutine pack_position

  !> The result in such numbers; `used` of them are its own.
  pure subroutine unpack_position(numbers, result, used)
    real(real64), intent(in) :: numbers(:)         !! from pack_position
    type(position_result), intent(out) :: result   !! the position
    integer, intent(out) :: used                   !! what was added begins behind them
    integer :: i

    result%x_displacement = numbers(1)
    result%y_displacement = numbers(2)
    result%limit_reached = nint(numbers(3)) == 1
    result%overlapping_circles = nint(numbers(4))
    result%first_step_pressure = numbers(5)
    result%rows_used = nint(numbers(7))
    allocate (result%states(nint(numbers(6))), result%rows(result%rows_used))
    used = of_head
    do i = 1, size(result%states)
      result%states(i) = state_of(numbers(used + 1:used + of_state))
      used = used + of_state
    end do
    do i = 1, result%rows_used
      result%rows(i) = row_of(numbers(used + 1:used + of_row))
      used = used + of_row
    end do
  end subroutine unpack_position

  pure function state_of(numbers) result(state)
    real(real64), intent(in) :: numbers(of_state)
    type(state_row) :: state

    state = state_row(approach=numbers(1), closing=numbers(2), time=numbers(3), &
                      contacts=nint(numbers(4)), load=numbers(5), vertical_load=numbers(6), &
                      area=numbers(7), projected_area=numbers(8), first_row=nint(numbers(9)), &
                      last_row=nint(numbers(10)))
  end function state_of

  pure function row_of(numbers) result(row)
    real(real64), intent(in) :: numbers(of_row)
    type(contact_row) :: row

    row = contact_row(area_no=nint(numbers(1)), upper=nint(numbers(2)), lower=nint(numbers(3)), &
                      limit_exceeded=nint(numbers(4)) == 1, x=numbers(5), y=numbers(6), &
                      penetration=numbers(7), overlap=numbers(8), area=numbers(9), &
                      projected_area=numbers(10), slope=numbers(11), load=numbers(12), &
                      vertical_load=numbers(13), average_pressure=numbers(14), &
                      maximum_pressure=numbers(15))
  end function row_of

end module asperity_position_packet
