!> Contact circles that overlap: where they do, contacts are not independent.
module asperity_overlapping_circles
  use asperity_kinds, only: real64
  implicit none
  private

  public :: count_overlapping, circles_overlap

contains

  !> Number of pairs of circles that overlap. Circles without radius are left out.
  !> Costs n log n as long as few circles share an abscissa.
  pure integer function count_overlapping(x, y, radius) result(number)
    real(real64), intent(in) :: x(:), y(:)   !! centres
    real(real64), intent(in) :: radius(:)    !! 0 or more
    integer :: order(size(x)), i, j, used
    real(real64) :: largest

    number = 0
    used = 0
    largest = 0.0_real64
    do i = 1, size(x)
      if (.not. radius(i) > 0.0_real64) cycle
      used = used + 1
      order(used) = i
      largest = max(largest, radius(i))
    end do
    if (used > 16) call sort_by(x, order(:used))
    do i = 2, used
      do j = i - 1, 1, -1
        if (used > 16) then
          if (x(order(i)) - x(order(j)) > radius(order(i)) + largest) exit
        end if
        if (circles_overlap(x(order(i)) - x(order(j)), y(order(i)) - y(order(j)), &
                            radius(order(i)), radius(order(j)))) number = number + 1
      end do
    end do
  end function count_overlapping

  !> Whether two circles overlap.
  pure logical function circles_overlap(dx, dy, first, second)
    real(real64), intent(in) :: dx, dy           !! from centre to centre
    real(real64), intent(in) :: first, second    !! radii

    circles_overlap = first > 0.0_real64 .and. second > 0.0_real64 .and. &
                      abs(dx) < first + second .and. abs(dy) < first + second
    if (circles_overlap) circles_overlap = dx * dx + dy * dy < (first + second)**2
  end function circles_overlap

  ! Sorts indices by the value they point at. Merge sort.
  pure recursive subroutine sort_by(value, order)
    real(real64), intent(in) :: value(:)
    integer, intent(inout) :: order(:)
    integer :: left((size(order) + 1) / 2), i, j, k

    if (size(order) < 2) return
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
