!> Faults of the original that can be corrected one at a time, by name.
!> docs/theory/faults.md describes each fault and the effect of its correction; the code refers to
!> its number.
module asperity_original_faults
  implicit none
  private

  public :: fault_names, mend_fault, mended_faults

  !> In the order of their numbers.
  character(len=11), parameter :: fault_names(*) = [character(len=11) :: &
    'divisor', 'drift', 'overlap', 'overshoot', 'list', 'no-pair', 'reach', 'normal-load', &
    'shift', 'left-out', 'start-value', 'count']

  !> Which of them a run is free of; without any it is the original.
  type :: mended_faults
    logical :: divisor = .false.      !! 1: the difference of areas is divided by the positions
    logical :: drift = .false.        !! 2: every position begins with the first one's numbers
    logical :: overlap = .false.      !! 3: W from the penetration, without cancellation
    logical :: overshoot = .false.    !! 4: the last step ends at the limit
    logical :: list = .false.         !! 5: places and approaches do not run out
    logical :: no_pair = .false.      !! 6: a position without a pair bears nothing, and that is all
    logical :: reach = .false.        !! 7: every pair that can touch is a candidate
    logical :: normal_load = .false.  !! 8: the total load adds vertical parts
    logical :: shift = .false.        !! 11: the deck's displacement moves the upper model
    logical :: left_out = .false.     !! 13: every loaded contact enters slopes and differences
    logical :: start_value = .false.  !! 14: no start value of a maximum or minimum is printed
    logical :: count = .false.        !! 15: only loaded contacts count; the average is not cut
  end type mended_faults

contains

  !> Adds a fault to those that are mended.
  pure subroutine mend_fault(number, mended)
    integer, intent(in) :: number                !! place in `fault_names`
    type(mended_faults), intent(inout) :: mended !! of a run

    select case (number)
    case (1)
      mended%divisor = .true.
    case (2)
      mended%drift = .true.
    case (3)
      mended%overlap = .true.
    case (4)
      mended%overshoot = .true.
    case (5)
      mended%list = .true.
    case (6)
      mended%no_pair = .true.
    case (7)
      mended%reach = .true.
    case (8)
      mended%normal_load = .true.
    case (9)
      mended%shift = .true.
    case (10)
      mended%left_out = .true.
    case (11)
      mended%start_value = .true.
    case default
      mended%count = .true.
    end select
  end subroutine mend_fault

end module asperity_original_faults
