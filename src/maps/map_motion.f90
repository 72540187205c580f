!> Two height maps, one displaced over the other: the sum of their heights in plan.
!>
!> Along a free axis they have a window in common, on the coarser grid of both: heights between
!> pixels are linear. Along an axis on which they repeat themselves they have the same length, and
!> the sum is on the grid of fewer pixels: heights between pixels are those of their waves
!> (trigonometric interpolation), or linear where pixels are missing. A displacement by whole pixels
!> is exact.
module asperity_map_motion
  use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_loc
  use asperity_constants, only: pi
  use asperity_height_map, only: height_map, is_measured, no_height
  use asperity_kinds, only: real64
  use asperity_line_transform, only: line_transform, real_to_waves, waves_to_real
  implicit none
  private

  public :: overlay_maps

  ! Distance from a pixel, in pixels, below which a place is that of the pixel (chosen: the rounding
  ! of displacements; test: whole pixels in test/maps/test_map_motion.py).
  real(real64), parameter :: at_pixel = 1.0e-9_real64
  ! Least number of pixels of a window along a side, as that of a map.
  integer, parameter :: least_side = 3

  ! Pixels of a map along one axis for the pixels of the sum: the one before and the share of the
  ! one after.
  type :: axis_places
    integer, allocatable :: before(:), after(:)
    real(real64), allocatable :: share(:)
  end type axis_places

contains

  !> Adds the heights of two maps, the upper one displaced. `failure` is allocated where free maps
  !> have no window in common.
  subroutine overlay_maps(lower, upper, displacement, map, origin, failure)
    type(height_map), intent(in) :: lower            !! levelled height map
    type(height_map), intent(in) :: upper            !! levelled map with the same edge
    real(real64), intent(in) :: displacement(2)      !! of the upper map along x and y [length]
    type(height_map), intent(out) :: map             !! sum of the heights
    real(real64), intent(out) :: origin(2)           !! its first pixel from that of the lower map
    character(len=:), allocatable, intent(out) :: failure
    type(axis_places) :: of_lower(2), of_upper(2)
    real(real64), allocatable :: higher(:, :)
    integer :: axis, number(2)

    map%periodic = lower%periodic
    map%strip_axis = lower%strip_axis
    map%unit = lower%unit
    do axis = 1, 2
      call find_places(lower, upper, axis, displacement(axis), of_lower(axis), of_upper(axis), &
                       map%pixel_spacing(axis), origin(axis))
      number(axis) = size(of_lower(axis)%share)
      map%is_between = map%is_between .or. (map%repeats(axis) .and. &
                                            any(of_upper(axis)%share > 0.0_real64))
    end do
    if (any(number < least_side)) then
      failure = 'the maps have fewer than 3 pixels in common along a side: expected a ' // &
                'smaller displacement'
      return
    end if
    map%columns = number(1)
    map%rows = number(2)
    call find_heights(lower, of_lower, [0.0_real64, 0.0_real64], map%height)
    call find_heights(upper, of_upper, displacement / upper%pixel_spacing, higher)
    where (is_measured(map%height) .and. is_measured(higher))
      map%height = map%height + higher
    else where
      map%height = no_height
    end where
  end subroutine overlay_maps

  ! Finds the pixels of the sum along an axis, and their places in both maps.
  subroutine find_places(lower, upper, axis, moved, of_lower, of_upper, pixel_side, origin)
    type(height_map), intent(in) :: lower, upper
    integer, intent(in) :: axis
    real(real64), intent(in) :: moved
    type(axis_places), intent(out) :: of_lower, of_upper
    real(real64), intent(out) :: pixel_side, origin
    real(real64), allocatable :: x(:)
    real(real64) :: last
    integer :: i, number(2)

    number = [size(lower%height, axis), size(upper%height, axis)]
    associate (below => lower%pixel_spacing(axis), above => upper%pixel_spacing(axis))
      pixel_side = max(below, above)
      origin = 0.0_real64
      if (lower%repeats(axis)) then
        pixel_side = below * number(1) / minval(number)
        x = [(i * pixel_side, i=0, minval(number) - 1)]
      else
        if (above > below) origin = moved
        last = min((number(1) - 1) * below, moved + (number(2) - 1) * above)
        x = origin + pixel_side * [(i, i=0, merge(number(2), number(1), above > below) - 1)]
        x = pack(x, x >= max(0.0_real64, moved) - at_pixel * pixel_side .and. &
                    x <= last + at_pixel * pixel_side)
        if (size(x) > 0) origin = x(1)
      end if
      call place_on(x / below, number(1), lower%repeats(axis), of_lower)
      call place_on((x - moved) / above, number(2), lower%repeats(axis), of_upper)
    end associate
  end subroutine find_places

  ! Places in pixels, from the first of an axis, between two of them.
  pure subroutine place_on(at, number, periodic, places)
    real(real64), intent(in) :: at(:)
    integer, intent(in) :: number
    logical, intent(in) :: periodic
    type(axis_places), intent(out) :: places

    allocate (places%before(size(at)), places%after(size(at)), places%share(size(at)))
    places%before = floor(at + at_pixel)
    places%share = max(0.0_real64, at - places%before)
    where (places%share <= at_pixel) places%share = 0.0_real64
    if (periodic) then
      places%before = modulo(places%before, number) + 1
      places%after = modulo(places%before, number) + 1
    else
      places%before = max(0, min(number - 1, places%before)) + 1
      places%after = min(number, places%before + 1)
    end if
  end subroutine place_on

  ! Bilinear heights; missing where one of the pixels is.
  subroutine interpolate_heights(map, places, height)
    type(height_map), intent(in) :: map
    type(axis_places), intent(in) :: places(2)
    real(real64), allocatable, intent(out) :: height(:, :)
    real(real64) :: corner, weight
    integer :: across, along, column(2), i, j, row(2)

    allocate (height(size(places(1)%share), size(places(2)%share)))
    do j = 1, size(height, 2)
      row = [places(2)%before(j), places(2)%after(j)]
      do i = 1, size(height, 1)
        column = [places(1)%before(i), places(1)%after(i)]
        height(i, j) = 0.0_real64
        do along = 1, 2
          do across = 1, 2
            weight = corner_weight(places(1)%share(i), across) * &
                     corner_weight(places(2)%share(j), along)
            if (.not. weight > 0.0_real64) cycle
            corner = map%height(column(across), row(along))
            if (is_measured(corner) .and. is_measured(height(i, j))) then
              height(i, j) = height(i, j) + weight * corner
            else
              height(i, j) = no_height
            end if
          end do
        end do
      end do
    end do

  contains

    ! Weight of the pixel before, or after.
    pure real(real64) function corner_weight(share, which)
      real(real64), intent(in) :: share
      integer, intent(in) :: which

      corner_weight = merge(1.0_real64 - share, share, which == 1)
    end function corner_weight

  end subroutine interpolate_heights

  ! Heights of a map at the pixels of the sum.
  subroutine find_heights(map, places, moved, height)
    type(height_map), intent(in) :: map
    type(axis_places), intent(in) :: places(2)
    real(real64), intent(in) :: moved(2)  ! displacement in pixels of the map
    real(real64), allocatable, intent(out) :: height(:, :)
    real(real64), allocatable :: lines(:, :)
    integer :: axis

    if (.not. all(is_measured(map%height))) then
      call interpolate_heights(map, places, height)
      return
    end if
    height = map%height
    do axis = 1, 2
      if (map%repeats(axis)) then
        call move_lines(height, moved(axis), size(places(axis)%share), lines)
      else
        associate (share => spread(places(axis)%share, 2, size(height, 2)))
          lines = (1.0_real64 - share) * height(places(axis)%before, :) + &
                  share * height(places(axis)%after, :)
        end associate
      end if
      height = transpose(lines)
    end do
  end subroutine find_heights

  ! Displaces the lines along the first axis.
  subroutine move_lines(lines, moved, number, others)
    real(real64), intent(in) :: lines(:, :)
    real(real64), intent(in) :: moved     ! in pixels
    integer, intent(in) :: number         ! of pixels of a displaced line
    real(real64), allocatable, intent(out) :: others(:, :)
    real(c_double), allocatable, target :: line(:), other(:)
    complex(c_double_complex), allocatable, target :: waves(:), fewer(:)
    complex(c_double_complex), allocatable :: turn(:)
    type(line_transform) :: forward, backward
    integer :: j, k, n

    n = size(lines, 1)
    if (number == n .and. abs(moved - anint(moved)) <= at_pixel) then
      others = cshift(lines, -modulo(nint(modulo(moved, real(n, real64))), n), 1)
      return
    end if
    allocate (others(number, size(lines, 2)), line(n), other(number), waves(0:n / 2), &
              fewer(0:number / 2), turn(0:number / 2))
    turn(:) = [(exp(cmplx(0.0_real64, -2 * pi * modulo(k * moved / n, 1.0_real64), real64)) / n, &
                k=0, number / 2)]
    call forward%prepare(real_to_waves, n)
    call backward%prepare(waves_to_real, number)
    do j = 1, size(lines, 2)
      line = lines(:, j)
      call forward%apply(c_loc(line), c_loc(waves))
      fewer = waves(0:number / 2) * turn
      ! The shortest wave of an even number is real; of more pixels it is the sum of two waves.
      if (modulo(number, 2) == 0) fewer(number / 2) = &
        merge(2, 1, number < n) * real(fewer(number / 2), real64)
      call backward%apply(c_loc(fewer), c_loc(other))
      others(:, j) = other
    end do
  end subroutine move_lines

end module asperity_map_motion
