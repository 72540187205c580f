!> Contact circles that overlap, whose contacts are not independent.
module asperity_overlapping_circles
  use asperity_cell_grid, only: build_grid, cell_grid
  use asperity_cell_layer, only: any_height, margin_of_arithmetic
  use asperity_kinds, only: real64
  use asperity_pair_search_layers, only: found_pairs, search_pairs
  implicit none
  private

  public :: count_overlapping

  integer, parameter :: few = 64  ! number of circles up to which all pairs are compared

contains

  !> Number of pairs of circles that overlap. Circles without radius are left out. In large sets
  !> they are found by the search for pairs of asperities, at a cost proportional to the numbers of
  !> circles and of pairs; in small sets, without memory for the search, or with centres too far
  !> apart to be squared, all pairs are compared.
  integer function count_overlapping(x, y, radius) result(number)
    real(real64), intent(in) :: x(:), y(:)   !! centres of the circles
    real(real64), intent(in) :: radius(:)    !! radius of each circle, 0 or more
    type(found_pairs) :: near                ! each pair twice, as upper and lower
    integer, allocatable :: members(:)
    type(cell_grid) :: grid
    real(real64) :: unit, margin
    logical :: each_with_each
    integer :: i, j, k

    number = 0
    members = pack([(i, i=1, size(x))], radius > 0.0_real64)
    if (size(members) == 0) return
    ! The search squares lengths over the largest radius.
    unit = maxval(radius)
    each_with_each = size(x) <= few .or. &
                     max(maxval(abs(x(members))), maxval(abs(y(members)))) / sqrt(huge(unit)) > unit
    if (.not. each_with_each) then
      margin = margin_of_arithmetic(epsilon(unit), &
                                    2 * maxval(abs(x(members)) + abs(y(members))) / unit + 2)
      call build_grid(grid, x(members) / unit, y(members) / unit, &
                      spread(0.0_real64, 1, size(members)), radius(members) / unit, any_height)
      call search_pairs(grid, grid, 0.0_real64, 0.0_real64, any_height, margin, -huge(unit), near, &
                        each_with_each)
    end if
    if (each_with_each) then
      do i = 2, size(members)
        do j = 1, i - 1
          if (do_overlap(members(i), members(j))) number = number + 1
        end do
      end do
      return
    end if
    do k = 1, near%blocks
      associate (block => near%block(k))
        do i = 1, block%used
          if (block%upper(i) >= block%lower(i)) cycle
          if (do_overlap(members(block%upper(i)), members(block%lower(i)))) number = number + 1
        end do
      end associate
    end do

  contains

    pure logical function do_overlap(one, other)
      integer, intent(in) :: one, other

      associate (dx => x(one) - x(other), dy => y(one) - y(other), &
                 reach => radius(one) + radius(other))
        do_overlap = abs(dx) < reach .and. abs(dy) < reach
        if (do_overlap) do_overlap = dx * dx + dy * dy < reach**2
      end associate
    end function do_overlap

  end function count_overlapping

end module asperity_overlapping_circles
