!> Elevation of a surface of spherical asperities at the centres of the pixels of a grid.
!>
!> A surface between its summits is the highest of its spheres and, where all its summits are above
!> it, its reference plane. Beside all spheres of a surface without that plane there is no surface.
module asperity_surface_elevations
  use asperity_grid_pressures, only: field_grid
  use asperity_kinds, only: not_computed, real64
  use asperity_scene_values, only: scene_surface
  implicit none
  private

  public :: elevation_of, place_surface, placed_surface

  ! Pixels along the side of a block. For each block the spheres that can be highest are selected.
  integer, parameter :: block = 32

  !> One surface at its position. Elevations are from its reference plane towards the other surface.
  type :: placed_surface
    logical :: has_base = .false.                    !! whether its reference plane is a part of it
    real(real64), allocatable :: x(:), y(:)          !! positions of the summits
    real(real64), allocatable :: level(:)            !! elevation of the summits, tilt included
    real(real64), allocatable :: radius(:)           !! radius of the spheres
    real(real64), allocatable :: reach(:)            !! radius in plan of the spherical cap
    real(real64) :: slope(2) = 0.0_real64            !! slope of the reference plane
    real(real64) :: displacement(2) = 0.0_real64     !! displacement in plan
  end type placed_surface

contains

  !> Places a surface in the order of a scene: rotation, mirror, slope, displacement.
  type(placed_surface) function place_surface(surface, side, displacement, mirror) result(placed)
    type(scene_surface), intent(in) :: surface  !! surface of the scene
    integer, intent(in) :: side                 !! sign of the slope: 1 lower, -1 upper surface
    real(real64), intent(in), optional :: displacement(2)  !! displacement in plan [length]
    real(real64), intent(in), optional :: mirror  !! y becomes this number less y [length]
    real(real64) :: angle

    angle = surface%rotation
    allocate (placed%x, source=surface%x * cos(angle) - surface%y * sin(angle))
    allocate (placed%y, source=surface%x * sin(angle) + surface%y * cos(angle))
    if (present(mirror)) placed%y = mirror - placed%y
    placed%slope = side * surface%slope
    allocate (placed%level, source=surface%height + placed%slope(1) * placed%x + &
                                   placed%slope(2) * placed%y)
    allocate (placed%radius, source=surface%radius)
    allocate (placed%reach, source=surface%radius)
    placed%has_base = all(surface%height > 0.0_real64)
    if (placed%has_base) then
      associate (cap => min(surface%height, surface%radius))
        placed%reach = sqrt(cap) * sqrt(surface%radius + (surface%radius - cap))
      end associate
    end if
    if (present(displacement)) placed%displacement = displacement
    placed%x = placed%x + placed%displacement(1)
    placed%y = placed%y + placed%displacement(2)
  end function place_surface

  !> Elevation of a surface at the centres of the cells [length]; `not_computed` beside all of its
  !> spheres.
  function elevation_of(surface, grid) result(profile)
    type(placed_surface), intent(in) :: surface  !! surface at its position
    type(field_grid), intent(in) :: grid         !! grid of the pixels
    real(real64), allocatable :: profile(:, :)   !! elevation by column and row
    integer :: i, j

    allocate (profile(grid%elements(1), grid%elements(2)))
    !$omp parallel do schedule(dynamic) private(i)
    do j = 1, grid%elements(2), block
      do i = 1, grid%elements(1), block
        call fill_block([i, j], min([i, j] + block - 1, grid%elements))
      end do
    end do
    !$omp end parallel do

  contains

    ! Spheres that are everywhere below the lowest place of the others are left out.
    subroutine fill_block(first, last)
      integer, intent(in) :: first(2), last(2)
      real(real64) :: middle(2), half, lowest, x, y
      integer :: k, m, n

      middle = grid%low + 0.5_real64 * grid%side * (first + last - 1)
      half = 0.5_real64 * grid%side * norm2(real(last - first + 1, real64))
      lowest = not_computed
      do n = first(2), last(2)
        y = grid%low(2) + (n - 0.5_real64) * grid%side - surface%displacement(2)
        do m = first(1), last(1)
          x = grid%low(1) + (m - 0.5_real64) * grid%side - surface%displacement(1)
          profile(m, n) = not_computed
          if (surface%has_base) profile(m, n) = dot_product(surface%slope, [x, y])
        end do
      end do
      if (surface%has_base) lowest = minval(profile(first(1):last(1), first(2):last(2)))
      do k = 1, size(surface%x)
        lowest = max(lowest, sphere_elevation(k, plan_distance(k, middle) + half))
      end do
      do k = 1, size(surface%x)
        if (plan_distance(k, middle) - half >= surface%radius(k)) cycle
        if (sphere_elevation(k, max(0.0_real64, plan_distance(k, middle) - half)) < lowest) cycle
        do n = first(2), last(2)
          y = grid%low(2) + (n - 0.5_real64) * grid%side
          do m = first(1), last(1)
            x = grid%low(1) + (m - 0.5_real64) * grid%side
            profile(m, n) = max(profile(m, n), sphere_elevation(k, plan_distance(k, [x, y])))
          end do
        end do
      end do
    end subroutine fill_block

    pure real(real64) function plan_distance(k, place)
      integer, intent(in) :: k
      real(real64), intent(in) :: place(2)

      plan_distance = hypot(place(1) - surface%x(k), place(2) - surface%y(k))
    end function plan_distance

    ! Elevation of sphere k at a distance in plan; `not_computed` beyond its radius.
    pure real(real64) function sphere_elevation(k, from)
      integer, intent(in) :: k
      real(real64), intent(in) :: from

      sphere_elevation = not_computed
      associate (r => surface%radius(k))
        if (from < r) &
          sphere_elevation = surface%level(k) - from**2 / (r + sqrt((r - from) * (r + from)))
      end associate
    end function sphere_elevation

  end function elevation_of

end module asperity_surface_elevations
