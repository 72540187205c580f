!> Rims of contact patches on pixels, and patches that an edge cuts.
module asperity_map_rims
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: int64, real64
  implicit none
  private

  public :: error_of_rims, share_at_ends

contains

  !> Share of the load on pixels of contact patches that a free edge or a missing pixel cuts. Their
  !> pressure grows without limit with finer pixels, as at the edge of a punch.
  pure real(real64) function share_at_ends(map, pressure) result(share)
    type(height_map), intent(in) :: map           !! height map that is pressed
    real(real64), intent(in) :: pressure(:, :)    !! contact pressure, its sum > 0
    logical, allocatable :: ends(:, :)
    integer :: side

    allocate (ends, source=.not. is_measured(map%height))
    do side = -2, 2
      if (side == 0) cycle
      if (map%repeats(abs(side))) then
        ends = ends .or. cshift(.not. is_measured(map%height), sign(1, side), abs(side))
      else
        ends = ends .or. eoshift(.not. is_measured(map%height), sign(1, side), .true., abs(side))
      end if
    end do
    share = sum(pressure, mask=ends) / sum(pressure)
  end function share_at_ends

  !> Error of the area by the straight pieces of rims: of each half a pixel over its length; the
  !> root of the sum of squares, and the sum of those from end to end of the map, as grooves at
  !> equal distances have the same error. Where the body ends, at an edge or a missing pixel, is no
  !> rim.
  pure real(real64) function error_of_rims(map, pressure) result(error)
    type(height_map), intent(in) :: map           !! height map that is pressed
    real(real64), intent(in) :: pressure(:, :)    !! contact pressure of each pixel
    logical, allocatable :: beyond(:, :), rim(:, :), line(:)
    integer(int64) :: grooves
    integer :: along, i, length, side

    error = 0.0_real64
    grooves = 0_int64
    do side = -2, 2
      if (side == 0) cycle
      beyond = pressure > 0.0_real64 .or. .not. is_measured(map%height)
      if (map%repeats(abs(side))) then
        beyond = cshift(beyond, sign(1, side), abs(side))
      else
        beyond = eoshift(beyond, sign(1, side), .true., abs(side))
      end if
      rim = pressure > 0.0_real64 .and. .not. beyond
      if (abs(side) == 1) rim = transpose(rim)
      do i = 1, size(rim, 2)
        line = rim(:, i)
        if (all(line)) then
          grooves = grooves + size(line)
          cycle
        end if
        ! A piece that goes on beyond the end of a periodic map is in one piece.
        if (map%repeats(3 - abs(side))) line = cshift(line, findloc(line, .false., 1))
        length = 0
        do along = 1, size(line)
          length = merge(length + 1, 0, line(along))
          ! The squares 1, 3, 5, ... of a piece add up to that of its length.
          if (length > 0) error = error + 2 * length - 1
        end do
      end do
    end do
    error = 0.5_real64 * (sqrt(error) + grooves) * product(map%pixel_spacing)
  end function error_of_rims

end module asperity_map_rims
