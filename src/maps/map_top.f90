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
module asperity_map_top
  use asperity_height_map, only: height_map, is_measured, no_height
  use asperity_kinds, only: int64, real64
  implicit none
  private

  public :: find_top

  ! Depth below the highest pixel of the pixels that are looked at, in rms heights (measured
  ! on random surfaces: the top is 0.13 above the highest pixel at most where the shortest wave has
  ! 4 pixels; test: random surfaces in test/maps/test_pixel_errors.py).
  real(real64), parameter :: search_depth = 0.5_real64

contains

  !> Finds the top of a map and its estimated error.
  pure subroutine find_top(map, top, error)
    type(height_map), intent(in) :: map       !! height map with at least one pixel measured
    real(real64), intent(out) :: top          !! height of the top [length]
    real(real64), intent(out) :: error        !! estimated error of it, 0 or more [length]
    real(real64) :: least, mean, near(-2:2, -2:2), highest, step, vertex_error
    integer(int64) :: n
    integer :: i, j

    top = maxval(map%height)
    n = count(is_measured(map%height), kind=int64)
    mean = sum(map%height, mask=is_measured(map%height)) / n
    least = top - search_depth * sqrt(sum((map%height - mean)**2, is_measured(map%height)) / n)
    highest = top
    do j = 1, size(map%height, 2)
      do i = 1, size(map%height, 1)
        if (map%height(i, j) < least) cycle
        near = heights_around(map, i, j)
        if (.not. all(is_measured(near(-1:1, -1:1)))) cycle
        call find_vertex(near, step, vertex_error)
        top = max(top, near(0, 0) + step)
        highest = max(highest, near(0, 0) + step + vertex_error)
      end do
    end do
    error = highest - top
  end subroutine find_top

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

end module asperity_map_top
