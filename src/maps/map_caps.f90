!> A table of asperities on the pixels of a height map.
!>
!> Each asperity is the paraboloid of Hertz' theory, height - r**2/(2 radius). Between them the
!> surface is its reference plane, or the plane of its lowest summit where that is below. On a
!> periodic axis each period has the same asperities.
module asperity_map_caps
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: real64
  use asperity_scene_values, only: scene_surface
  implicit none
  private

  public :: add_caps, placed_caps

  !> Asperities on the pixels of a map.
  type :: placed_caps
    real(real64), allocatable :: rise(:, :)   !! above their base plane [length]
    real(real64), allocatable :: slope(:, :)  !! distance from the summit over the radius
    real(real64) :: radius = 0.0_real64       !! smallest radius [length]
  end type placed_caps

contains

  !> Adds the asperities of a table to the heights of a map. `failure` is allocated where none of
  !> them rises above a pixel.
  subroutine add_caps(caps, displacement, map, placed, failure)
    type(scene_surface), intent(in) :: caps      !! table with at least one asperity
    real(real64), intent(in) :: displacement(2)  !! of the table from the map along x and y [length]
    type(height_map), intent(inout) :: map       !! levelled height map; sum of both surfaces
    type(placed_caps), intent(out) :: placed
    character(len=:), allocatable, intent(out) :: failure
    real(real64) :: distance, ends(2, 2), level, period(2), reach, summit(2), top
    integer :: first(2), i, j, k, last(2), place(2)
    logical :: repeats(2)

    level = min(0.0_real64, minval(caps%height))
    placed%rise = 0.0_real64 * map%height
    placed%slope = placed%rise
    placed%radius = minval(caps%radius)
    period = shape(map%height) * map%pixel_spacing
    repeats = [map%repeats(1), map%repeats(2)]
    do k = 1, size(caps%x)
      summit = [caps%x(k), caps%y(k)] + displacement
      where (repeats) summit = modulo(summit, period)
      ! Along a periodic axis at most the period around the summit, along a free one the map.
      ends = 0.0_real64
      ends(:, 2) = period - 0.5_real64 * map%pixel_spacing
      where (repeats)
        ends(:, 1) = summit - 0.5_real64 * period
        ends(:, 2) = summit + 0.5_real64 * period
      end where
      reach = sqrt(caps%radius(k)) * sqrt(2 * (caps%height(k) - level))
      first = ceiling(min(max(summit - reach, ends(:, 1)), ends(:, 2)) / map%pixel_spacing)
      last = floor(max(min(summit + reach, ends(:, 2)), ends(:, 1)) / map%pixel_spacing)
      do j = first(2), last(2)
        do i = first(1), last(1)
          distance = norm2([i, j] * map%pixel_spacing - summit)
          top = caps%height(k) - level - distance**2 / (2 * caps%radius(k))
          place = 1 + modulo([i, j], shape(map%height))
          if (.not. top > placed%rise(place(1), place(2))) cycle
          placed%rise(place(1), place(2)) = top
          placed%slope(place(1), place(2)) = distance / caps%radius(k)
        end do
      end do
    end do
    if (.not. any(placed%rise > 0.0_real64)) failure = 'no asperity of the table lies over the ' &
      // 'map: expected its places from the first pixel of the map'
    where (is_measured(map%height)) map%height = map%height + (level + placed%rise)
  end subroutine add_caps

end module asperity_map_caps
