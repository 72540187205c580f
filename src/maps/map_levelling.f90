!> The plane from which the heights of a map are measured.
module asperity_map_levelling
  use asperity_height_map, only: height_map, is_measured, level_none, level_plane, no_height
  use asperity_kinds, only: int64, real64
  implicit none
  private

  public :: is_flat, level_map

  ! A tilt that raises an edge by less than this part of the range of heights is rounding. It is not
  ! subtracted, so that equal pixels of a level map stay equal.
  real(real64), parameter :: rounding = 1.0e-13_real64

  ! Heights whose range is less than so many units of rounding of the largest height before
  ! levelling are rounding. Levelling leaves up to 4 units of a plane in doubles (measured: 240
  ! planes of 4 x 4 to 3000 x 4500 pixels); the rest is room for heights that were computed before
  ! they were written (chosen; test: flat maps of test/maps/test_map_edges.py).
  real(real64), parameter :: flat_units = 1.0e3_real64

contains

  !> Whether all measured heights of a levelled map are equal.
  pure logical function is_flat(map)
    type(height_map), intent(in) :: map  !! levelled height map

    associate (measured => is_measured(map%height))
      is_flat = .not. maxval(map%height, mask=measured) > minval(map%height, mask=measured)
    end associate
  end function is_flat

  !> Subtracts the plane or the mean. Pixels that all lie in a line have a mean only. Heights that
  !> differ by rounding alone become equal: the map is flat.
  pure subroutine level_map(map, how)
    type(height_map), intent(inout) :: map  !! height map, at least one pixel measured
    integer, intent(in) :: how              !! one of `level_plane`, `level_mean`, `level_none`
    real(real64) :: largest, mean
    integer :: pass

    largest = maxval(abs(map%height), mask=is_measured(map%height))
    ! The mean comes first: near it the subtraction is exact, and differences of neighbours keep all
    ! their digits. The last pass subtracts the rounding of a large offset or tilt.
    do pass = 1, merge(0, 3, how == level_none)
      call take_plane(map, tilted=pass > 1 .and. how == level_plane)
    end do
    associate (measured => is_measured(map%height))
      if (maxval(map%height, mask=measured) - minval(map%height, mask=measured) > &
          flat_units * epsilon(largest) * largest) return
      mean = 0.0_real64
      if (how == level_none) mean = sum(map%height, mask=measured) / &
                                               count(measured, kind=int64)
      where (measured) map%height = mean
    end associate
  end subroutine level_map

  ! Subtracts the mean or the plane of least squares once.
  pure subroutine take_plane(map, tilted)
    type(height_map), intent(inout) :: map
    logical, intent(in) :: tilted
    real(real64) :: mean(3), moments(5), sums(5), low, high, u, v, z, slope(2), determinant
    integer(int64) :: number
    integer :: i, j

    number = 0_int64
    mean = 0.0_real64
    low = huge(low)
    high = -huge(high)
    do j = 1, map%rows
      sums = 0.0_real64
      do i = 1, map%columns
        z = map%height(i, j)
        if (.not. z > 0.5_real64 * no_height) cycle
        sums(1:3) = sums(1:3) + [1.0_real64, real(i, real64), z]
        low = min(low, z)
        high = max(high, z)
      end do
      number = number + nint(sums(1), int64)
      mean = mean + [sums(2), real(j, real64) * sums(1), sums(3)]
    end do
    mean = mean / real(number, real64)
    slope = 0.0_real64
    if (tilted) then
      moments = 0.0_real64
      do j = 1, map%rows
        v = j - mean(2)
        sums = 0.0_real64
        do i = 1, map%columns
          if (.not. map%height(i, j) > 0.5_real64 * no_height) cycle
          u = i - mean(1)
          z = map%height(i, j) - mean(3)
          sums = sums + [u * u, u * v, v * v, u * z, v * z]
        end do
        moments = moments + sums
      end do
      determinant = moments(1) * moments(3) - moments(2)**2
      if (determinant > 1.0e-12_real64 * moments(1) * moments(3)) &
        slope = [moments(3) * moments(4) - moments(2) * moments(5), &
                 moments(1) * moments(5) - moments(2) * moments(4)] / determinant
      where (abs(slope) * [map%columns, map%rows] < rounding * (high - low)) slope = 0.0_real64
    end if
    do j = 1, map%rows
      do i = 1, map%columns
        if (map%height(i, j) > 0.5_real64 * no_height) map%height(i, j) = map%height(i, j) - &
          (mean(3) + slope(1) * (i - mean(1)) + slope(2) * (j - mean(2)))
      end do
    end do
  end subroutine take_plane

end module asperity_map_levelling
