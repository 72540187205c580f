!> Contact circles that overlap: where they do, contacts are not independent.
module asperity_overlapping_circles
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int32, real64
  implicit none
  private

  public :: count_overlapping, circles_overlap

  ! So many are compared each with each.
  integer, parameter :: few = 16

contains

  !> Number of pairs of circles that overlap. Circles without radius are left out.
  !> Costs n log n as long as few circles share an abscissa.
  integer function count_overlapping(x, y, radius) result(number)
    real(real64), intent(in) :: x(:), y(:)   !! centres
    real(real64), intent(in) :: radius(:)    !! 0 or more
    integer :: i, j

    number = 0
    if (size(x) > few) then
      number = count_along_x(x, y, radius)
      return
    end if
    do i = 2, size(x)
      do j = 1, i - 1
        if (circles_overlap(x(i) - x(j), y(i) - y(j), radius(i), radius(j))) number = number + 1
      end do
    end do
  end function count_overlapping

  ! The same for many circles: each is compared with those near it along x.
  integer function count_along_x(x, y, radius) result(number)
    real(real64), intent(in) :: x(:), y(:), radius(:)
    real(real64), allocatable :: along(:)
    integer(int32), allocatable :: order(:)
    real(real64) :: largest
    integer :: i, j

    allocate (along(size(x)), order(size(x)))
    call sort_keys(x, order)
    along(:) = x(order)
    largest = maxval(radius)
    number = 0
    do i = 2, size(x)
      do j = i - 1, 1, -1
        if (along(i) - along(j) > radius(order(i)) + largest) exit
        if (circles_overlap(along(i) - along(j), y(order(i)) - y(order(j)), &
                            radius(order(i)), radius(order(j)))) number = number + 1
      end do
    end do
  end function count_along_x

  !> Whether two circles overlap.
  pure logical function circles_overlap(dx, dy, first, second)
    real(real64), intent(in) :: dx, dy           !! from centre to centre
    real(real64), intent(in) :: first, second    !! radii

    circles_overlap = abs(dx) < first + second
    if (.not. circles_overlap) return
    circles_overlap = first > 0.0_real64 .and. second > 0.0_real64 .and. &
                      dx * dx + dy * dy < (first + second)**2
  end function circles_overlap

end module asperity_overlapping_circles
