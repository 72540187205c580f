!> Contact circles that overlap: where they do, contacts are not independent.
module asperity_overlapping_circles
  use asperity_kinds, only: real64
  implicit none
  private

  public :: count_overlapping, circles_overlap

  ! So many are compared each with each.
  integer, parameter :: few = 16

contains

  !> Number of pairs of circles that overlap. Circles without radius are left out.
  !> Costs n log n as long as few circles share an abscissa.
  pure integer function count_overlapping(x, y, radius) result(number)
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
  pure integer function count_along_x(x, y, radius) result(number)
    real(real64), intent(in) :: x(:), y(:), radius(:)
    integer, allocatable :: order(:)
    real(real64) :: largest
    integer :: i, j

    allocate (order(size(x)))
    order = [(i, i=1, size(x))]
    call sort_by(x, order)
    largest = maxval(radius)
    number = 0
    do i = 2, size(x)
      do j = i - 1, 1, -1
        if (x(order(i)) - x(order(j)) > radius(order(i)) + largest) exit
        if (circles_overlap(x(order(i)) - x(order(j)), y(order(i)) - y(order(j)), &
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

  ! Sorts indices by the value they point at. Merge sort.
  pure recursive subroutine sort_by(value, order)
    real(real64), intent(in) :: value(:)
    integer, intent(inout) :: order(:)
    integer, allocatable :: left(:)
    integer :: i, j, k

    if (size(order) < 2) return
    allocate (left((size(order) + 1) / 2))
    call sort_by(value, order(:size(left)))
    call sort_by(value, order(size(left) + 1:))
    left = order(:size(left))
    i = 1
    j = size(left) + 1
    do k = 1, size(order)
      if (i > size(left)) exit
      if (j <= size(order)) then
        if (value(order(j)) < value(left(i))) then
          order(k) = order(j)
          j = j + 1
          cycle
        end if
      end if
      order(k) = left(i)
      i = i + 1
    end do
  end subroutine sort_by

end module asperity_overlapping_circles
