!> First contact of a height map with a flat: the top of the surface between its pixels.
!>
!> With the heights f(x, y) in pixels from a local maximum, the top is the vertex of the quadratic
!> by central differences of nine pixels. Where these have no vertex within one pixel it is the
!> highest vertex of the lines along x, along y and along the diagonals. Beside local maxima it is
!> that of the former two: the top of a ridge may be far from each pixel along its crest. Of the
!> pixels within half an rms height of the highest one the highest vertex counts: a lower pixel may
!> be nearer to its top. Along a plateau of three equal pixels or more, and where a neighbour is
!> missing, the surface has no vertex: the pixel is the top.
!>
!> The error of a vertex at (x, y) is the next terms of the expansion there, in absolute values: of
!> Stirling's formula (Abramowitz and Stegun 1964, 25.2.22) x (x**2 - 1)/6 and x**2 (x**2 - 1)/24
!> times the third and the fourth difference along each axis, and x**2 y/2, x y**2/2 and
!> x**2 y**2/4 times the mixed ones.
!>
!> A map that is not smooth may have a kink at its top, where a vertex is no limit. Along a line a
!> concave top lies below the chords of the pixels on both sides, which meet above it; a top between
!> flanks of the same slope is half the difference of its neighbours above its pixel. Along both
!> lines the former add up as of a separable surface, the latter by their squares, as flanks of a
!> rough map are independent. The larger is the bound of the top; a vertex above the chords is none.
!> Beside a cliff both may be too large: of N heights the greatest, which is above their mean as
!> (2 ln N)**(1/2) standard deviations (Gumbel), grows to 16 N independent ones by the share
!> ln 4/ln N, and has itself a standard deviation of pi/6**(1/2)/(2 ln N).
module asperity_map_top
  use asperity_constants, only: pi
  use asperity_height_map, only: height_map, is_measured, no_height
  use asperity_kinds, only: int64, real64
  use asperity_map_statistics, only: rms_slope_over
  implicit none
  private

  public :: find_top, first_contact

  ! Depth below the highest pixel of the pixels that are looked at, in rms heights (measured
  ! on random surfaces: the top is 0.13 above the highest pixel at most where the shortest wave has
  ! 4 pixels; test: random surfaces in test/maps/test_pixel_errors.py).
  real(real64), parameter :: search_depth = 0.5_real64
  ! Second difference over two pixels by that over one, above which a top is no kink: 4 of a
  ! quadratic, 2 to 3 of a tent, up to 3.1 of a cone (chosen between; test: kinks there).
  real(real64), parameter :: even_bend = 3.5_real64
  ! Standard deviation of the greatest of many heights, over their scale.
  real(real64), parameter :: gumbel = pi / sqrt(6.0_real64)

  ! Growth of the slope by the last halving of the pixel over that by the one before, above which a
  ! map is rough at the size of its pixels: 1/4 where it is smooth, 1/2 with kinks, 2**(1 - H) of a
  ! self-affine surface, at least 0.63 where that ends at two pixels (chosen; test: waves and random
  ! maps in test/maps/test_pixel_errors.py).
  real(real64), parameter :: rough_growth = 0.6_real64
  ! The same, below which it is smooth (derived: between 1/4 and 1/2; test: kinks there).
  real(real64), parameter :: smooth_growth = 1.0_real64 / 3.0_real64
  ! The same of independent heights (derived: their slope is inverse to the size of the pixel).
  real(real64), parameter :: fastest_growth = 2.0_real64

  !> First contact of a map.
  type :: first_contact
    real(real64) :: height = 0.0_real64   !! of the top [length]
    real(real64) :: error = 0.0_real64    !! estimated error of it, 0 or more [length]
    logical :: is_smooth = .false.        !! the map is smooth between its pixels
    logical :: is_vertex = .false.        !! the top is a vertex without kinks
    !> Relative growth of the slope to pixels a quarter as wide; 0: the map is not rough.
    real(real64) :: growth = 0.0_real64
  end type first_contact

contains

  !> Finds the top of a map and its estimated error.
  pure type(first_contact) function find_top(map) result(found)
    type(height_map), intent(in) :: map  !! height map with at least one pixel measured
    real(real64) :: chords, rounding, highest, largest, least, mean, near(-2:2, -2:2), ratio
    real(real64) :: rise, step, top
    logical :: has_kink
    integer(int64) :: n
    integer :: i, j

    top = maxval(map%height)
    n = count(is_measured(map%height), kind=int64)
    mean = sum(map%height, mask=is_measured(map%height)) / n
    least = top - search_depth * sqrt(sum((map%height - mean)**2, is_measured(map%height)) / n)
    highest = top
    call measure_growth(map, ratio, found%growth)
    found%is_smooth = ratio < smooth_growth
    found%is_vertex = .true.
    ! Tops that are equal but for rounding.
    rounding = sqrt(epsilon(rounding)) * (top - mean)
    largest = (top - mean) * (2.0_real64 * log(4.0_real64) + gumbel) / &
              (2.0_real64 * log(max(2.0_real64, real(n, real64))))
    do j = 1, size(map%height, 2)
      do i = 1, size(map%height, 1)
        if (map%height(i, j) < least) cycle
        near = heights_around(map, i, j)
        step = 0.0_real64
        rise = 0.0_real64
        if (all(is_measured(near(-1:1, -1:1)))) call find_vertex(near, step, rise)
        has_kink = .not. found%is_smooth
        if (has_kink .and. .not. ratio > rough_growth) has_kink = .not. bends_evenly(near)
        if (has_kink) then
          call find_bound(near, rounding, chords, rise)
          step = min(step, chords)
          rise = min(rise, largest) - step
        end if
        if (near(0, 0) + step > top + rounding) found%is_vertex = .true.
        if (has_kink .and. near(0, 0) + step >= top - rounding) found%is_vertex = .false.
        top = max(top, near(0, 0) + step)
        highest = max(highest, near(0, 0) + step + rise)
      end do
    end do
    found%height = top
    found%error = highest - top
    if (.not. (found%is_smooth .or. found%is_vertex)) &
      found%error = max(found%error, top - maxval(map%height))
  end function find_top

  ! Heights of 5 x 5 pixels around one; `no_height` beyond a free edge.
  pure function heights_around(map, i, j) result(near)
    type(height_map), intent(in) :: map
    integer, intent(in) :: i, j
    real(real64) :: near(-2:2, -2:2)
    integer :: a, at(2), b

    near = no_height
    do b = -2, 2
      do a = -2, 2
        at = [i + a, j + b]
        where ([map%repeats(1), map%repeats(2)]) at = modulo(at - 1, shape(map%height)) + 1
        if (all(at >= 1 .and. at <= shape(map%height))) near(a, b) = map%height(at(1), at(2))
      end do
    end do
  end function heights_around

  ! Finds the height of the vertex above a pixel, and its error; 0: there is none.
  pure subroutine find_vertex(near, step, error)
    real(real64), intent(in) :: near(-2:2, -2:2)  ! heights, those of nine pixels measured
    real(real64), intent(out) :: step, error
    real(real64) :: bend(2), det, line(-2:2, 4), mixed(3), place(2), slope(2), twist
    logical :: is_plateau(2)
    integer :: k, lines

    line(:, 1) = near(:, 0)
    line(:, 2) = near(0, :)
    line(:, 3) = [(near(k, k), k=-2, 2)]
    line(:, 4) = [(near(k, -k), k=-2, 2)]
    is_plateau = [(has_plateau(line(:, k)), k=1, 2)]
    slope = 0.5_real64 * (line(1, :2) - line(-1, :2))
    bend = [(bend_of(line(:, k)), k=1, 2)]
    twist = 0.25_real64 * (near(1, 1) - near(-1, 1) - near(1, -1) + near(-1, -1))
    det = product(bend) - twist**2
    if (det > 0.0_real64 .and. bend(1) < 0.0_real64 .and. .not. any(is_plateau) .and. &
        .not. any(near(-1:1, -1:1) > near(0, 0))) then
      place = (twist * slope([2, 1]) - bend([2, 1]) * slope) / det
      if (maxval(abs(place)) <= 1.0_real64) then
        step = 0.5_real64 * dot_product(slope, place)
        ! Differences of the second ones along x and y across their line, and of both.
        mixed(:2) = 0.5_real64 * [bend_of(near(:, 1)) - bend_of(near(:, -1)), &
                                  bend_of(near(1, :)) - bend_of(near(-1, :))]
        mixed(3) = bend_of(near(:, 1)) + bend_of(near(:, -1)) - 2.0_real64 * bend(1)
        error = 0.5_real64 * dot_product(place**2, abs(place([2, 1]) * mixed(:2))) + &
                0.25_real64 * product(place**2) * abs(mixed(3)) + &
                next_terms(line(:, 1), place(1)) + next_terms(line(:, 2), place(2))
        return
      end if
    end if
    step = 0.0_real64
    error = 0.0_real64
    lines = merge(2, 4, any(is_plateau) .or. any(near(-1:1, -1:1) > near(0, 0)))
    do k = 1, lines
      if (has_plateau(line(:, k)) .or. .not. bend_of(line(:, k)) < 0.0_real64 .or. &
          max(line(-1, k), line(1, k)) > line(0, k)) cycle
      place(1) = 0.5_real64 * (line(-1, k) - line(1, k)) / bend_of(line(:, k))
      if (.not. 0.25_real64 * place(1) * (line(1, k) - line(-1, k)) > step) cycle
      step = 0.25_real64 * place(1) * (line(1, k) - line(-1, k))
      error = next_terms(line(:, k), place(1))
    end do
  end subroutine find_vertex

  ! Whether the heights along both lines bend as a vertex, not as a kink.
  pure logical function bends_evenly(near)
    real(real64), intent(in) :: near(-2:2, -2:2)
    real(real64) :: over_one(2), over_two(2)

    bends_evenly = all(is_measured(near(:, 0))) .and. all(is_measured(near(0, :)))
    if (.not. bends_evenly) return
    over_one = [bend_of(near(:, 0)), bend_of(near(0, :))]
    over_two = [near(2, 0) + near(-2, 0), near(0, 2) + near(0, -2)] - 2.0_real64 * near(0, 0)
    bends_evenly = all(over_one < 0.0_real64 .and. over_two < even_bend * over_one)
  end function bends_evenly

  ! Finds how far a top with kinks lies above its pixel: below the chords, and a bound.
  pure subroutine find_bound(near, rounding, chords, bound)
    real(real64), intent(in) :: near(-2:2, -2:2)
    real(real64), intent(in) :: rounding  ! difference of equal heights
    real(real64), intent(out) :: chords, bound
    real(real64) :: flanks, line(-2:2)
    integer :: k

    chords = 0.0_real64
    flanks = 0.0_real64
    do k = 1, 2
      if (k == 1) line = near(:, 0)
      if (k == 2) line = near(0, :)
      if (max(line(-1), line(1)) > line(0) + rounding .or. &
          .not. all(is_measured(line(-1:1)))) cycle
      chords = chords + max(chord_of(line(-1:2)), chord_of(line(1:-2:-1)))
      flanks = hypot(flanks, 0.5_real64 * (line(1) - line(-1)))
    end do
    bound = max(chords, flanks)
  end subroutine find_bound

  ! Height above the second of four pixels where the chords of the outer two meet; 0: not between
  ! the inner two.
  pure real(real64) function chord_of(line) result(height)
    real(real64), intent(in) :: line(4)
    real(real64) :: above, slopes(2)

    height = 0.0_real64
    if (.not. all(is_measured(line))) return
    slopes = [line(2) - line(1), line(3) - line(4)]
    above = line(3) + slopes(2) - line(2)
    if (above > 0.0_real64 .and. above <= sum(slopes)) height = slopes(1) * above / sum(slopes)
  end function chord_of

  ! Second difference of the middle of five heights.
  pure real(real64) function bend_of(line)
    real(real64), intent(in) :: line(-2:2)

    bend_of = (line(1) - line(0)) + (line(-1) - line(0))
  end function bend_of

  ! Whether the middle of five heights is one of three equal ones.
  pure logical function has_plateau(line)
    real(real64), intent(in) :: line(-2:2)
    integer :: k

    has_plateau = any([(maxval(line(k:k + 2)) <= minval(line(k:k + 2)), k=-2, 0)])
  end function has_plateau

  ! Next terms of the parabola through the middle three of five heights at a place. Where one of the
  ! outer two is missing they are unknown: at most the parabola itself.
  pure real(real64) function next_terms(line, place)
    real(real64), intent(in) :: line(-2:2), place
    real(real64) :: third, fourth

    if (all(is_measured(line))) then
      third = 0.5_real64 * (line(2) - line(-2)) - (line(1) - line(-1))
      fourth = (line(2) + line(-2)) - 4.0_real64 * (line(1) + line(-1)) + 6.0_real64 * line(0)
      next_terms = abs(place * (place**2 - 1.0_real64)) * &
                   (abs(third) / 6.0_real64 + abs(place * fourth) / 24.0_real64)
    else
      next_terms = 0.5_real64 * abs(bend_of(line)) * place**2
    end if
  end function next_terms

  ! Finds the growth of the slope of a map from differences over 2 pixels to those over 1, over that
  ! from 4 to 2; at most `fastest_growth`.
  pure subroutine measure_growth(map, ratio, growth)
    type(height_map), intent(in) :: map
    real(real64), intent(out) :: ratio
    ! Relative, to pixels a quarter as wide; 0: the map is not rough at the size of its pixels.
    real(real64), intent(out) :: growth
    real(real64) :: slope(0:2)
    integer :: k

    growth = 0.0_real64
    ratio = fastest_growth
    if (any(shape(map%height) <= 4)) return
    slope = [(rms_slope_over(map, 2**k), k=0, 2)]
    if (slope(1) > slope(2)) &
      ratio = min(ratio, (slope(0) - slope(1)) / (slope(1) - slope(2)))
    if (slope(0) > slope(1) .and. ratio > rough_growth) &
      growth = (1.0_real64 - slope(1) / slope(0)) * (ratio + ratio**2)
  end subroutine measure_growth

end module asperity_map_top
