!> Grids of fewer pixels of a height map, which show the error by their size.
module asperity_coarse_grid
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: real64
  implicit none
  private

  public :: coarse_grid, find_centre, grid_around, least_side, step_beside_two

  !> Least number of pixels along a side (chosen: halves of two are no maps).
  integer, parameter :: least_side = 4
  ! Relative difference of tops that count as equal (chosen: coarser maps are solved to this).
  real(real64), parameter :: of_equals = 1.0e-4_real64

  !> Every `step`th pixel of a map.
  type :: coarse_grid
    integer :: step                              !! width of its pixels in those of the map
    integer, allocatable :: columns(:), rows(:)  !! its pixels
  end type coarse_grid

contains

  !> Finds the pixel and the diagonal that coarser grids follow: the same ones on maps that are
  !> mirrored, transposed, in other units, or begin elsewhere. Equal tops differ by their pressures,
  !> or by their distance from the middle between free edges; both diagonals by the twist of squared
  !> heights about the top, as a sum of lines along both sides has no twist. Where rounding decides
  !> the map is symmetric, and so are its grids.
  pure subroutine find_centre(map, pressure, place, turn)
    type(height_map), intent(in) :: map           !! height map that is pressed
    real(real64), intent(in) :: pressure(:, :)    !! contact pressure, with a value above 0
    integer, intent(out) :: place(2)              !! column and row of the top
    integer, intent(out) :: turn                  !! 1 or -1: columns over rows of the diagonal
    type(coarse_grid) :: whole
    real(real64) :: along(size(pressure, 1)), across(size(pressure, 2))
    real(real64) :: from_middle(2), greatest, highest, lowest, most, rank
    integer :: i, j

    highest = maxval(map%height)
    lowest = minval(map%height, is_measured(map%height))
    greatest = maxval(pressure)
    most = -huge(most)
    do j = 1, size(pressure, 2)
      do i = 1, size(pressure, 1)
        from_middle = abs(2 * [i, j] - 1 - shape(pressure)) / real(shape(pressure), real64)
        rank = pressure(i, j) / greatest + &
               (max(map%height(i, j), lowest) - highest) / max(highest - lowest, tiny(highest)) - &
               of_equals * sum(from_middle**2, .not. [map%repeats(1), map%repeats(2)])
        if (.not. rank > most) cycle
        place = [i, j]
        most = rank
      end do
    end do
    whole = grid_around(map, place, 1, [0, 0])
    along = pixel_distances(place(1), size(pressure, 1), map%repeats(1))
    across = pixel_distances(place(2), size(pressure, 2), map%repeats(2))
    ! Half a period away is on both sides.
    where (abs(2 * along) >= size(along)) along = 0.0_real64
    where (abs(2 * across) >= size(across)) across = 0.0_real64
    turn = 1
    if (dot_product(along, matmul((max(map%height(whole%columns, whole%rows), lowest) - &
                                   lowest)**2, across)) < 0.0_real64) turn = -1
  end subroutine find_centre

  ! Distances of the pixels along a side from one of them, the nearer way round.
  pure function pixel_distances(place, number, repeats) result(away)
    integer, intent(in) :: place, number
    logical, intent(in) :: repeats
    integer :: away(number), i

    away = [(i, i=1, number)] - merge((number + 1) / 2, place, repeats)
  end function pixel_distances

  !> The grid of every `step`th pixel at an offset from a place. On a side that repeats itself, and
  !> that the step does not divide, it ends where it is farthest from the place.
  pure type(coarse_grid) function grid_around(map, place, step, offset) result(grid)
    type(height_map), intent(in) :: map   !! map of any size
    integer, intent(in) :: place(2)       !! column and row
    integer, intent(in) :: step           !! pixels to the next one
    integer, intent(in) :: offset(2)      !! of one pixel of the grid from the place

    grid%step = step
    allocate (grid%columns, source=pixels_at(1))
    allocate (grid%rows, source=pixels_at(2))

  contains

    pure function pixels_at(side) result(pixels)
      integer, intent(in) :: side
      integer, allocatable :: pixels(:)
      integer :: away(size(map%height, side))

      away = pixel_distances(place(side), size(away), map%repeats(side))
      allocate (pixels, source=1 + modulo(place(side) - 1 + pack(away, modulo( &
                                          away - offset(side), step) == 0), size(away)))
    end function pixels_at

  end function grid_around

  !> The first of the steps 3, 4 and 5 with which a map keeps its lengths; 0: none, or the map is
  !> too small.
  pure integer function step_beside_two(map) result(step)
    type(height_map), intent(in) :: map  !! map of any size

    do step = 3, 5
      if (any(shape(map%height) < step * least_side / 2)) exit
      if (.not. any(mod(shape(map%height), step) > 0 .and. [map%repeats(1), map%repeats(2)])) return
    end do
    step = 0
  end function step_beside_two

end module asperity_coarse_grid
