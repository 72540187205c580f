!> Contact circles that overlap: where they do, contacts are not independent.
module asperity_overlapping_circles
  use asperity_cell_grid, only: build_grid, cell_grid
  use asperity_cell_reach, only: any_height, margin_of_arithmetic
  use asperity_kinds, only: real64
  use asperity_pair_search_blocks, only: found_pairs
  use asperity_pair_search_layers, only: search_pairs
  implicit none
  private

  public :: count_overlapping, circles_overlap

  ! So many are compared each with each.
  integer, parameter :: few = 64

contains

  !> Number of pairs of circles that overlap. Circles without radius are left out. Many are searched
  !> for as pairs of asperities are: the cost follows their number and that of the pairs found.
  !> Few, or when there is no memory for the pairs, are compared each with each.
  integer function count_overlapping(x, y, radius) result(number)
    real(real64), intent(in) :: x(:), y(:)   !! centres
    real(real64), intent(in) :: radius(:)    !! 0 or more
    logical :: failed
    integer :: i, j

    if (size(x) > few) then
      call count_many(pack(x, radius > 0.0_real64), pack(y, radius > 0.0_real64), &
                      pack(radius, radius > 0.0_real64), number, failed)
      if (.not. failed) return
    end if
    number = 0
    do i = 2, size(x)
      do j = 1, i - 1
        if (circles_overlap(x(i) - x(j), y(i) - y(j), radius(i), radius(j))) number = number + 1
      end do
    end do
  end function count_overlapping

  ! The same for many circles: those that are near each other, looked at again. Lengths are those
  ! over the largest radius, as the search squares them.
  subroutine count_many(x, y, radius, number, failed)
    real(real64), intent(in) :: x(:), y(:), radius(:)
    integer, intent(out) :: number
    logical, intent(out) :: failed
    type(cell_grid) :: grid
    type(found_pairs) :: near
    real(real64) :: unit
    integer :: i, k

    number = 0
    failed = .false.
    if (size(x) == 0) return
    unit = maxval(radius)
    call build_grid(grid, x / unit, y / unit, spread(0.0_real64, 1, size(x)), radius / unit, &
                    any_height)
    call search_pairs(grid, grid, 0.0_real64, 0.0_real64, any_height, &
                      margin_of_arithmetic(epsilon(unit), 2 * maxval(abs(x) + abs(y)) / unit + 2), &
                      -huge(unit), near, failed)
    if (failed) return
    do k = 1, near%blocks
      associate (block => near%block(k))
        do i = 1, block%used
          associate (one => block%upper(i), other => block%lower(i))
            if (one >= other) cycle
            if (circles_overlap(x(one) - x(other), y(one) - y(other), radius(one), radius(other))) &
              number = number + 1
          end associate
        end do
      end associate
    end do
  end subroutine count_many

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
