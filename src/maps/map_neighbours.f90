!> A pixel of a map with its eight neighbours.
module asperity_map_neighbours
  use asperity_height_map, only: height_map, index_beside, is_measured
  use asperity_kinds, only: real64
  implicit none
  private

  public :: heights_around

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

end module asperity_map_neighbours
