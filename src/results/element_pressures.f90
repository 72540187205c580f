!> Pressures on boundary elements, kept beside the totals of a state for its fields.
module asperity_element_pressures
  use asperity_kinds, only: real64
  implicit none
  private

  public :: element_pressures, join_elements

  !> Loaded square elements of contacts that are resolved, and shifts of all contacts. Lengths are
  !> in one unit; forces of one contact are proportional to its load, in any unit.
  type :: element_pressures
    logical :: of_all_states = .false.            !! every state is kept; else the last one alone
    real(real64) :: closing = -1.0_real64         !! past first touch; less than 0: nothing is kept
    integer, allocatable :: pair(:)               !! place of its contact in the list of pairs
    real(real64), allocatable :: x(:), y(:)       !! centre of an element
    real(real64), allocatable :: side(:)          !! of an element
    real(real64), allocatable :: force(:)         !! vertical, more than 0
    !> From first touch to the centre of the pressure of a Hertzian contact, by pair; not allocated:
    !> 0.
    real(real64), allocatable :: shift(:, :)
  end type element_pressures

contains

  !> Elements of several parts in one list, without shifts.
  pure subroutine join_elements(parts, all)
    type(element_pressures), intent(in) :: parts(:)     !! each with or without elements
    type(element_pressures), intent(inout) :: all       !! gets the elements
    integer :: k, last, next, total

    total = 0
    do k = 1, size(parts)
      if (allocated(parts(k)%pair)) total = total + size(parts(k)%pair)
    end do
    if (allocated(all%pair)) deallocate (all%pair, all%x, all%y, all%side, all%force)
    allocate (all%pair(total), all%x(total), all%y(total), all%side(total), all%force(total))
    last = 0
    do k = 1, size(parts)
      if (.not. allocated(parts(k)%pair)) cycle
      next = last + 1
      last = last + size(parts(k)%pair)
      all%pair(next:last) = parts(k)%pair
      all%x(next:last) = parts(k)%x
      all%y(next:last) = parts(k)%y
      all%side(next:last) = parts(k)%side
      all%force(next:last) = parts(k)%force
    end do
  end subroutine join_elements

end module asperity_element_pressures
