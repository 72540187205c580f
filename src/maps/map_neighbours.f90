!> A sample of a map with its eight neighbours.
module asperity_map_neighbours
  use asperity_height_map, only: height_map, index_beside, is_measured
  use asperity_kinds, only: real64
  implicit none
  private

  public :: neighbourhood

contains

  !> The sample and its neighbours, `near(0, 0)` the sample itself.
  !>
  !> Beyond the edge of a free map, and where a pixel is missing, the pixel on the opposite side is
  !> used: the edge is a mirror. What is missing on both sides stays missing.
  pure function neighbourhood(map, column, row) result(near)
    type(height_map), intent(in) :: map  !! the map
    integer, intent(in) :: column, row   !! of the sample
    real(real64) :: near(-1:1, -1:1)     !! `no_height` where missing
    integer :: i, j

    do j = -1, 1
      do i = -1, 1
        near(i, j) = mirrored(i, j)
        if (.not. is_measured(near(i, j))) near(i, j) = mirrored(-i, -j)
      end do
    end do

  contains

    pure real(real64) function mirrored(i, j)
      integer, intent(in) :: i, j

      mirrored = map%height(inside(column, i, map%columns), inside(row, j, map%rows))
    end function mirrored

    pure integer function inside(place, step, number)
      integer, intent(in) :: place, step, number

      inside = place + step
      if (inside >= 1 .and. inside <= number) return
      inside = index_beside(inside, number, map%periodic)
      if (inside == 0) inside = place - step
    end function inside

  end function neighbourhood

end module asperity_map_neighbours
