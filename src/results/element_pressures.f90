!> Pressures on boundary elements, kept for the fields of a state.
module asperity_element_pressures
  use asperity_kinds, only: real64
  implicit none
  private

  public :: element_pressures, join_elements

  !> Loaded square elements of contacts that are resolved, and shifts of all contacts. Lengths are
  !> in one unit; forces of one contact are proportional to its load, in any unit.
  type :: element_pressures
    logical :: of_all_states = .false.            !! every state is kept; else the last one only
    real(real64) :: compression = -1.0_real64     !! compression; less than 0: nothing is kept
    integer, allocatable :: pair(:)               !! place of its contact in the list of pairs
    real(real64), allocatable :: x(:), y(:)       !! centre of an element
    real(real64), allocatable :: side(:)          !! side of an element
    real(real64), allocatable :: force(:)         !! vertical force, more than 0
    !> Vector from first touch to the centre of pressure of a Hertzian contact, by pair; not
    !> allocated: 0.
    real(real64), allocatable :: shift(:, :)
  end type element_pressures

contains

  !> Joins the elements of several parts in one list, without shifts.
  pure subroutine join_elements(parts, joined)
    type(element_pressures), intent(in) :: parts(:)     !! parts with or without elements
    type(element_pressures), intent(inout) :: joined    !! gets the elements
    integer :: k, last, next, total

    total = 0
    do k = 1, size(parts)
      if (allocated(parts(k)%pair)) total = total + size(parts(k)%pair)
    end do
    if (allocated(joined%pair)) &
      deallocate (joined%pair, joined%x, joined%y, joined%side, joined%force)
    allocate (joined%pair(total), joined%x(total), joined%y(total), joined%side(total), &
              joined%force(total))
    last = 0
    do k = 1, size(parts)
      if (.not. allocated(parts(k)%pair)) cycle
      next = last + 1
      last = last + size(parts(k)%pair)
      joined%pair(next:last) = parts(k)%pair
      joined%x(next:last) = parts(k)%x
      joined%y(next:last) = parts(k)%y
      joined%side(next:last) = parts(k)%side
      joined%force(next:last) = parts(k)%force
    end do
  end subroutine join_elements

end module asperity_element_pressures
