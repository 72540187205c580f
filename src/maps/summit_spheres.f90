!> The sphere that stands for a summit of a map: its radius and its top, from nine samples.
module asperity_summit_spheres
  use asperity_height_map, only: is_measured
  use asperity_kinds, only: real64
  implicit none
  private

  public :: mean_curvature, top_of, radius_names, radius_neighbours, radius_geometric, &
            radius_paraboloid

  !> Rules for the radius: 1 over the mean, or over the geometric mean, of the two central second
  !> differences; 1 over the mean curvature of the paraboloid of least squares over nine samples.
  integer, parameter :: radius_neighbours = 1, radius_geometric = 2, radius_paraboloid = 3
  !> What the user calls them.
  character(len=*), parameter :: radius_names(3) = [character(len=10) :: 'neighbours', &
    'geometric', 'paraboloid']

contains

  !> The curvature that the radius is 1 over; 0 or less where the samples have no such sphere.
  !> Where one of both directions has no neighbours the other serves for both.
  pure real(real64) function mean_curvature(near, spacing, rule) result(curvature)
    real(real64), intent(in) :: near(-1:1, -1:1)  !! the summit and its neighbours
    real(real64), intent(in) :: spacing(2)        !! of the samples along x and y
    integer, intent(in) :: rule                   !! one of the rules
    real(real64) :: along(2)

    if (rule == radius_paraboloid) then
      along(1) = mean_of_lines(near)
      along(2) = mean_of_lines(transpose(near))
    else
      along(1) = bend(near(:, 0))
      along(2) = bend(near(0, :))
    end if
    along = along / spacing**2
    if (.not. has_line(near(:, 0))) along(1) = along(2)
    if (.not. has_line(near(0, :))) along(2) = along(1)
    if (rule == radius_geometric) then
      curvature = 0.0_real64
      if (minval(along) > 0.0_real64) &
        curvature = along(1) * sqrt(along(2) / along(1))
    else
      curvature = 0.5_real64 * (along(1) + along(2))
    end if
  end function mean_curvature

  !> Where the parabolas through the summit and its neighbours along x and y have their vertex, as
  !> a step from the summit in samples, and how much higher that is. A vertex more than half a
  !> sample away is that of something else. Beside a cliff there is no parabola: one that is bent
  !> more than given rises as one that is bent so much.
  pure subroutine top_of(near, most, step, rise)
    real(real64), intent(in) :: near(-1:1, -1:1)  !! the summit and its neighbours
    real(real64), intent(in) :: most(2)           !! second differences along x and y at most
    real(real64), intent(out) :: step(2)          !! along x and y, from -1/2 to 1/2
    real(real64), intent(out) :: rise             !! of the vertex above the sample, 0 or more

    real(real64) :: rises(2)

    call vertex(near(:, 0), most(1), step(1), rises(1))
    call vertex(near(0, :), most(2), step(2), rises(2))
    rise = sum(rises)
  end subroutine top_of

  ! The vertex of the parabola through three samples.
  pure subroutine vertex(line, most, step, rise)
    real(real64), intent(in) :: line(-1:1), most
    real(real64), intent(out) :: step, rise
    real(real64) :: difference, down

    step = 0.0_real64
    rise = 0.0_real64
    difference = 0.0_real64
    if (has_line(line)) difference = line(1) - line(-1)
    down = bend(line)
    if (.not. (abs(difference) <= down .and. down > 0.0_real64)) return
    step = 0.5_real64 * difference / down
    rise = 0.125_real64 * difference * (difference / down) * min(1.0_real64, most / down)
  end subroutine vertex

  ! Minus the second difference.
  pure real(real64) function bend(line)
    real(real64), intent(in) :: line(-1:1)

    bend = 0.0_real64
    if (has_line(line)) bend = (line(0) - line(-1)) + (line(0) - line(1))
  end function bend

  pure logical function has_line(line)
    real(real64), intent(in) :: line(-1:1)

    has_line = all(is_measured(line))
  end function has_line

  ! Least squares over nine samples is the mean over the lines; a line that lacks one is left out.
  pure real(real64) function mean_of_lines(near)
    real(real64), intent(in) :: near(-1:1, -1:1)
    integer :: j, lines

    mean_of_lines = 0.0_real64
    lines = 0
    do j = -1, 1
      if (.not. has_line(near(:, j))) cycle
      lines = lines + 1
      mean_of_lines = mean_of_lines + bend(near(:, j))
    end do
    if (lines > 0) mean_of_lines = mean_of_lines / lines
  end function mean_of_lines

end module asperity_summit_spheres
