!> The sphere that represents a summit of a map: its radius and its top, from nine pixels.
module asperity_summit_spheres
  use asperity_height_map, only: height_map, index_beside, is_measured
  use asperity_kinds, only: real64
  implicit none
  private

  public :: heights_around, mean_curvature, find_top, radius_names, radius_neighbours, &
            radius_geometric, radius_paraboloid

  !> Rules for the radius: 1 over the mean, or over the geometric mean, of the two central second
  !> differences; 1 over the mean curvature of the paraboloid of least squares over nine pixels.
  integer, parameter :: radius_neighbours = 1, radius_geometric = 2, radius_paraboloid = 3
  !> Names of the rules for the radius in input.
  character(len=*), parameter :: radius_names(3) = [character(len=10) :: 'neighbours', &
    'geometric', 'paraboloid']

contains

  !> Heights of a pixel and its neighbours; `near(0, 0)` is the pixel itself.
  !>
  !> Beyond the edge of a free map, and where a pixel is missing, the pixel on the opposite side is
  !> used: the edge is a mirror. Heights missing on both sides stay missing.
  pure function heights_around(map, column, row) result(near)
    type(height_map), intent(in) :: map  !! height map, levelled
    integer, intent(in) :: column, row   !! column and row of the pixel, from 1
    real(real64) :: near(-1:1, -1:1)     !! heights; `no_height` where missing
    integer :: i, j

    do j = -1, 1
      do i = -1, 1
        near(i, j) = mirrored_height(i, j)
        if (.not. is_measured(near(i, j))) near(i, j) = mirrored_height(-i, -j)
      end do
    end do

  contains

    pure real(real64) function mirrored_height(i, j)
      integer, intent(in) :: i, j

      mirrored_height = map%height(index_inside(column, i, map%columns), &
                                   index_inside(row, j, map%rows))
    end function mirrored_height

    pure integer function index_inside(place, step, number)
      integer, intent(in) :: place, step, number

      index_inside = place + step
      if (index_inside >= 1 .and. index_inside <= number) return
      index_inside = index_beside(index_inside, number, map%periodic)
      if (index_inside == 0) index_inside = place - step
    end function index_inside

  end function heights_around

  !> Curvature of the sphere, 1/radius; 0 or less where the pixels have no such sphere. Where one
  !> direction has no neighbours the curvature of the other one is used for both.
  pure real(real64) function mean_curvature(near, distances, rule) result(curvature)
    real(real64), intent(in) :: near(-1:1, -1:1)  !! heights of the summit and its neighbours
    real(real64), intent(in) :: distances(2)      !! distances of pixels along x and y
    integer, intent(in) :: rule                   !! rule for the radius, one of the three
    real(real64) :: along(2)

    if (rule == radius_paraboloid) then
      along(1) = mean_of_lines(near)
      along(2) = mean_of_lines(transpose(near))
    else
      along(1) = second_fall(near(:, 0))
      along(2) = second_fall(near(0, :))
    end if
    along = along / distances**2
    if (.not. has_line(near(:, 0))) along(1) = along(2)
    if (.not. has_line(near(0, :))) along(2) = along(1)
    if (rule == radius_geometric) then
      curvature = 0.0_real64
      if (minval(along) > 0.0_real64) curvature = along(1) * sqrt(along(2) / along(1))
    else
      curvature = 0.5_real64 * (along(1) + along(2))
    end if
  end function mean_curvature

  !> Finds the vertex of the parabolas through the summit and its neighbours along x and y: its
  !> offset from the summit in pixels and its height above it. A vertex more than half a pixel away
  !> belongs to another summit and is ignored. Beside a cliff a parabola is meaningless: the rise of
  !> one with a larger second difference than `most` is that of one with `most`.
  pure subroutine find_top(near, most, step, rise)
    real(real64), intent(in) :: near(-1:1, -1:1)  !! heights of the summit and its neighbours
    real(real64), intent(in) :: most(2)           !! limits of the second differences along x and y
    real(real64), intent(out) :: step(2)          !! offset along x and y [pixels], -1/2 to 1/2
    real(real64), intent(out) :: rise             !! height of the vertex above the pixel, 0 or more

    real(real64) :: rises(2)

    call find_vertex(near(:, 0), most(1), step(1), rises(1))
    call find_vertex(near(0, :), most(2), step(2), rises(2))
    rise = sum(rises)
  end subroutine find_top

  ! Finds the vertex of the parabola through three pixels.
  pure subroutine find_vertex(line, most, step, rise)
    real(real64), intent(in) :: line(-1:1), most
    real(real64), intent(out) :: step, rise
    real(real64) :: difference, down

    step = 0.0_real64
    rise = 0.0_real64
    difference = 0.0_real64
    if (has_line(line)) difference = line(1) - line(-1)
    down = second_fall(line)
    if (.not. (abs(difference) <= down .and. down > 0.0_real64)) return
    step = 0.5_real64 * difference / down
    rise = 0.125_real64 * difference * (difference / down) * min(1.0_real64, most / down)
  end subroutine find_vertex

  ! Minus the second difference of a line of three heights, 0 where one is missing.
  pure real(real64) function second_fall(line)
    real(real64), intent(in) :: line(-1:1)

    second_fall = 0.0_real64
    if (has_line(line)) second_fall = (line(0) - line(-1)) + (line(0) - line(1))
  end function second_fall

  pure logical function has_line(line)
    real(real64), intent(in) :: line(-1:1)

    has_line = all(is_measured(line))
  end function has_line

  ! The second difference by least squares over nine pixels: the mean of the three lines. A line
  ! with a missing pixel is left out.
  pure real(real64) function mean_of_lines(near)
    real(real64), intent(in) :: near(-1:1, -1:1)
    integer :: j, lines

    mean_of_lines = 0.0_real64
    lines = 0
    do j = -1, 1
      if (.not. has_line(near(:, j))) cycle
      lines = lines + 1
      mean_of_lines = mean_of_lines + second_fall(near(:, j))
    end do
    if (lines > 0) mean_of_lines = mean_of_lines / lines
  end function mean_of_lines

end module asperity_summit_spheres
