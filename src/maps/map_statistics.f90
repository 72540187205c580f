!> Statistics of a map and of its summits, and their expected values for a random surface.
!>
!> Spectral moments by differences: m0 the mean square of the heights about their mean, m2 of the
!> first differences over the spacing, m4 of the second differences over its square, along x and y.
!> Differences underestimate derivatives: m2 lacks m4 d^2/12, m4 lacks m6 d^2/6 to first order in
!> the square of the spacing d. Beside missing pixels a difference counts by the share of its
!> neighbouring lines on which the same pixels are measured: for slopes these are cells of four
!> measured pixels.
!>
!> Theory: P. R. Nayak, Random process model of rough surfaces, J. Lubr. Technol. 93 (1971) 398;
!> the summits' means as in A. W. Bush, R. D. Gibson, G. P. Keogh, Mech. Res. Commun. 3 (1976) 169
!> and J. I. McCool, Wear 107 (1986) 37. It holds for an isotropic Gaussian surface.
module asperity_map_statistics
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
  use asperity_constants, only: pi
  use asperity_height_map, only: height_map, index_beside, is_measured, no_height
  use asperity_kinds, only: int64, real64
  use asperity_map_summits, only: map_summits
  implicit none
  private

  public :: map_statistics, measure_map, rms_slope_over

  !> Statistics of a map. Lengths are in the unit of the map. Once the map is measured, quantities
  !> of summits or slopes are NaN where it has none.
  type :: map_statistics
    integer(int64) :: samples = 0_int64         !! number of pixels
    integer(int64) :: missing = 0_int64         !! pixels that were not measured
    real(real64) :: slopes_left_out = 0.0_real64  !! share of first differences, at missing pixels
    real(real64) :: rms_height = 0.0_real64     !! root mean square about the mean
    real(real64) :: rms_slope = 0.0_real64      !! root mean square of the gradient
    real(real64) :: m0 = 0.0_real64             !! spectral moments: length squared
    real(real64) :: m2(2) = 0.0_real64          !! along x and y: of the slope
    real(real64) :: m4(2) = 0.0_real64          !! along x and y: of the curvature, 1/length squared
    real(real64) :: alpha = 0.0_real64          !! Nayak's m0 m4/m2^2, of the means of both
    real(real64) :: density = 0.0_real64  !! summits over the area of the pixels that can be one
    real(real64) :: mean_height = 0.0_real64    !! mean height of summits
    real(real64) :: height_deviation = 0.0_real64  !! standard deviation of summits
    real(real64) :: mean_curvature = 0.0_real64    !! mean of 1/radius of summits
    real(real64) :: mean_radius = 0.0_real64    !! mean radius of summits
    real(real64) :: expected_density = 0.0_real64    !! m4/(6 pi sqrt(3) m2)
    real(real64) :: expected_height = 0.0_real64     !! 4 sqrt(m0/(pi alpha))
    real(real64) :: expected_deviation = 0.0_real64  !! sqrt((1 - 0.8968/alpha) m0)
    real(real64) :: expected_curvature = 0.0_real64  !! 8/3 sqrt(m4/pi)
  end type map_statistics

contains

  !> Measures a map and its summits.
  subroutine measure_map(map, summits, found)
    type(height_map), intent(in) :: map          !! levelled height map
    type(map_summits), intent(in) :: summits     !! summits of this map
    type(map_statistics), intent(out) :: found   !! statistics of both
    real(real64) :: m2, m4
    integer :: number

    associate (nan => ieee_value(0.0_real64, ieee_quiet_nan))
      found = map_statistics(alpha=nan, density=nan, mean_height=nan, height_deviation=nan, &
                             mean_curvature=nan, mean_radius=nan, expected_density=nan, &
                             expected_height=nan, expected_deviation=nan, expected_curvature=nan, &
                             m2=nan, m4=nan)
    end associate
    call measure_moments(map, found)
    found%rms_height = sqrt(found%m0)
    found%rms_slope = sqrt(sum(found%m2))
    number = size(summits%x)
    if (number > 0) then
      found%density = number / (real(summits%possible, &
        real64) * map%pixel_spacing(1) * map%pixel_spacing(2))
      found%mean_height = sum(summits%height) / number
      found%height_deviation = sqrt(sum((summits%height - found%mean_height)**2) / number)
      found%mean_curvature = sum(1.0_real64 / summits%radius) / number
      found%mean_radius = sum(summits%radius) / number
    end if
    if (any(ieee_is_nan([found%m2, found%m4]))) return
    m2 = 0.5_real64 * sum(found%m2)
    m4 = 0.5_real64 * sum(found%m4)
    if (.not. (m2 > 0.0_real64 .and. m4 > 0.0_real64)) return
    found%alpha = (found%m0 / m2) * (m4 / m2)
    found%expected_density = m4 / (6.0_real64 * pi * sqrt(3.0_real64) * m2)
    found%expected_height = 4.0_real64 * sqrt(found%m0 / (pi * found%alpha))
    found%expected_deviation = sqrt(max(0.0_real64, 1.0_real64 - 0.8968_real64 / found%alpha) * &
                                    found%m0)
    found%expected_curvature = 8.0_real64 / 3.0_real64 * sqrt(m4 / pi)
  end subroutine measure_map

  ! Spectral moments; sums go row by row, which keeps their rounding small.
  subroutine measure_moments(map, found)
    type(height_map), intent(in) :: map
    type(map_statistics), intent(inout) :: found
    real(real64) :: numbers(4), sums(4), row_sums(4), mean, row_sum
    integer(int64) :: measured, slopes
    integer :: across(-2:0), along(-2:0), i, j

    found%samples = int(map%columns, int64) * map%rows
    measured = 0_int64
    mean = 0.0_real64
    do j = 1, map%rows
      measured = measured + count(is_measured(map%height(:, j)))
      mean = mean + sum(map%height(:, j), is_measured(map%height(:, j)))
    end do
    mean = mean / real(measured, real64)
    found%missing = found%samples - measured
    slopes = 0_int64
    numbers = 0.0_real64
    sums = 0.0_real64
    do j = 1, map%rows
      row_sums = 0.0_real64
      row_sum = 0.0_real64
      do i = 1, map%columns
        if (is_measured(map%height(i, j))) row_sum = row_sum + (map%height(i, j) - mean)**2
        across = index_beside([i - 2, i - 1, i], map%columns, map%periodic)
        along = index_beside([j - 2, j - 1, j], map%rows, map%periodic)
        if (across(-1) > 0) call add_difference(1, map%height(across(-1:), j), across(-1:), j)
        if (along(-1) > 0) call add_difference(2, map%height(i, along(-1:)), along(-1:), i)
        if (across(-2) > 0) call add_difference(3, map%height(across, j), across, j)
        if (along(-2) > 0) call add_difference(4, map%height(i, along), along, i)
      end do
      sums = sums + row_sums
      found%m0 = found%m0 + row_sum
    end do
    found%m0 = found%m0 / real(measured, real64)
    where (numbers(1:2) > 0.0_real64) found%m2 = sums(1:2) / numbers(1:2) / map%pixel_spacing**2
    where (numbers(3:4) > 0.0_real64) found%m4 = sums(3:4) / numbers(3:4) / map%pixel_spacing**4
    if (slopes > 0_int64) found%slopes_left_out = 1.0_real64 - sum(numbers(1:2)) / slopes

  contains

    ! Adds the first or second difference of heights along x (1, 3) or y (2, 4).
    subroutine add_difference(which, z, place, line)
      integer, intent(in) :: which, place(:), line  ! indices along the axis, and across it
      real(real64), intent(in) :: z(:)
      real(real64) :: share, square
      integer :: beside(2), k
      logical :: is_complete(2)

      if (.not. all(is_measured(z))) return
      share = 1.0_real64
      if (found%missing > 0_int64) then
        beside = index_beside([line - 1, line + 1], merge(map%rows, map%columns, &
                                                          mod(which, 2) == 1), map%periodic)
        is_complete = .false.
        do k = 1, 2
          if (beside(k) == 0) cycle
          if (mod(which, 2) == 1) is_complete(k) = all(is_measured(map%height(place, beside(k))))
          if (mod(which, 2) == 0) is_complete(k) = all(is_measured(map%height(beside(k), place)))
        end do
        share = count(is_complete) / real(count(beside > 0), real64)
      end if
      if (size(z) == 2) slopes = slopes + 1_int64
      square = (z(2) - z(1))**2
      if (size(z) == 3) square = ((z(3) - z(2)) - (z(2) - z(1)))**2
      row_sums(which) = row_sums(which) + share * square
      numbers(which) = numbers(which) + share
    end subroutine add_difference

  end subroutine measure_moments

  !> Root mean square of the gradient by measured pixels at a distance along each axis.
  pure real(real64) function rms_slope_over(map, distance) result(slope)
    type(height_map), intent(in) :: map  !! levelled height map
    integer, intent(in) :: distance      !! of two pixels, in pixels
    integer(int64) :: number
    integer :: axis, i, j, k, n
    real(real64) :: line(map%columns), square

    slope = 0.0_real64
    do axis = 1, 2
      square = 0.0_real64
      number = 0_int64
      do j = 1, map%rows
        n = map%columns
        if (axis == 1) then
          if (.not. map%repeats(1)) n = max(0, n - distance)
          line = cshift(map%height(:, j), distance)
        else
          k = index_beside(j + distance, map%rows, map%repeats(2))
          if (k == 0) exit
          line = map%height(:, k)
        end if
        do i = 1, n
          if (.not. min(map%height(i, j), line(i)) > 0.5_real64 * no_height) cycle
          number = number + 1_int64
          square = square + (line(i) - map%height(i, j))**2
        end do
      end do
      slope = hypot(slope, sqrt(square / max(1_int64, number)) / &
                    (distance * map%pixel_spacing(axis)))
    end do
  end function rms_slope_over

end module asperity_map_statistics
