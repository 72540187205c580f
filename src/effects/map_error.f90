!> Estimated error of the contact of a height map by the size of its pixels.
!>
!> The map is solved again on every m-th pixel along both sides, from each of four first pixels,
!> with adhesion from the attraction of its pixels: m is 2 and, where the map keeps its lengths, 3,
!> as halves of a symmetric map are mirror images of each other. Let d be the root mean square of
!> the four differences of a result. With the safety factor 3 of two grids (Roache, J. Fluids Eng.
!> 116 (1994) 405) its error is 3 d/(m**p - 1), the larger of the two, where p is the order: 2 on a
!> surface that is smooth between the pixels. The compression has the error of first contact
!> besides (`map_top`). That of the area is at least half of the correction of the
!> rim, and at least that of straight rims: each straight piece of a rim along the pixels lies up to
!> half a pixel from its sides. The errors of pieces are independent, but those of grooves, which
!> have no ends, add up. The relative error of the greatest pressure is at least that of the area,
!> as peaks lie between the pixels of all grids (measured:
!> reference_output/bench/pixel_estimates.csv; test: test/maps/test_pixel_errors.py).
!>
!> On a map that is rough at the size of its pixels p is 1, and the errors are those of pixels a
!> quarter as wide. Its slope grows on by the observed ratio, and the area is inverse to the slope
!> (Persson, J. Chem. Phys. 115 (2001) 3840): its error is at least the growth. The greatest
!> pressure has no estimate, as it grows with the slope and with the number of peaks.
!>
!> With creep they are those of the elastic state of the same displacements, with its own load (Lee
!> and Radok 1960), which holds as long as no pixel has left the contact.
module asperity_map_error
  use asperity_contact_records, only: state_row
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: real64
  use asperity_map_contact, only: most_load
  use asperity_map_fields, only: measure_fields
  use asperity_map_patches, only: map_patch
  use asperity_map_resolution, only: every_pixel
  use asperity_map_statistics, only: rms_slope_over
  use asperity_map_top, only: find_top
  use asperity_pixel_law, only: patches_in_contact, pixel_law_box, pixel_state
  use asperity_pixel_sequence, only: solve_pixel_state
  implicit none
  private

  public :: error_request, estimate_pixel_errors, growth_of_slope, share_at_ends

  ! Safety factor of the error of two grids (Roache 1994; test: rough maps in
  ! test/maps/test_pixel_errors.py).
  real(real64), parameter :: safety = 3.0_real64
  ! Tolerance of the gaps over the range of heights, or of the attraction (chosen: the differences
  ! are larger by far).
  real(real64), parameter :: closed_halves = 1.0e-4_real64
  ! Growth of the slope by the last halving of the pixel over that by the one before, above which a
  ! map is rough at the size of its pixels: 1/4 where it is smooth, 1/2 with kinks, 2**(1 - H) of a
  ! self-affine surface, at least 0.63 where that ends at two pixels (chosen; test: waves and random
  ! maps in test/maps/test_pixel_errors.py).
  real(real64), parameter :: rough_growth = 0.6_real64
  ! The same of independent heights (derived: their slope is inverse to the size of the pixel).
  real(real64), parameter :: fastest_growth = 2.0_real64
  ! Least number of pixels along a side (chosen: halves of two are no maps).
  integer, parameter :: least_side = 4

  !> The quantity that is prescribed, and the error of first contact.
  type :: error_request
    logical :: by_load                         !! the load is prescribed, else the separation
    logical :: by_top                          !! the compression is: the load has its error
    real(real64) :: top_error                  !! error of first contact [length]
    logical, private :: is_rough = .false.     !! the map is rough at the size of its pixels
    real(real64), private :: lowered = 0.0_real64  !! the flat below its level, unless by load
  end type error_request

contains

  !> Estimates the errors of a solution. Nothing is known, and both are unchanged, where a map is
  !> too small, or its halves cannot be solved.
  subroutine estimate_pixel_errors(map, laws, state, row, given, of_total, other_errors, unsolved)
    type(height_map), intent(in) :: map            !! map without plastic deformation
    type(pixel_law_box), intent(in) :: laws(:)     !! laws with the memory of this solution
    type(pixel_state), intent(in) :: state         !! solution; under a load: > 0
    type(state_row), intent(in) :: row             !! totals of this solution
    type(error_request), intent(in) :: given       !! quantity that is prescribed
    !> relative, of the load or, under a prescribed one, of the compression
    real(real64), intent(inout) :: of_total
    !> Relative, of area, mean gap and greatest pressure and, under a prescribed load, of the
    !> separation over the compression; `not_computed`: unknown.
    real(real64), intent(inout) :: other_errors(4)
    !> Reason why a map of every second pixel could not be solved; not allocated: all were.
    character(len=:), allocatable, intent(out) :: unsolved
    type(pixel_state) :: elastic
    type(error_request) :: request
    real(real64), allocatable :: error(:)
    real(real64) :: area, growth, of_top, pressure

    elastic = state
    ! Coarser maps start from pressures alone.
    deallocate (elastic%deformed%height)
    if (allocated(elastic%answer%displacement)) deallocate (elastic%answer%displacement)
    growth = growth_of_slope(map)
    request = given
    request%is_rough = growth > 0.0_real64
    if (request%is_rough) request%top_error = max(given%top_error, safety * difference_of_tops( &
                                                  map, row%approach + row%compression))
    call compare_coarser(map, laws, request, row, elastic, error, of_top, unsolved)
    if (.not. allocated(error)) return
    associate (answer => state%answer, patches => state%patches)
      area = max(error(3), 0.5_real64 * sum(patches%rim), growth * row%area)
      if (allocated(answer%contact_pressure)) then
        area = max(area, error_of_rims(map, answer%contact_pressure))
      else
        area = max(area, error_of_rims(map, answer%pressure))
      end if
      other_errors(1) = area / row%area
      other_errors(2) = error(4) / max(row%mean_gap, error(4), tiny(area))
      if (.not. growth > 0.0_real64) then
        pressure = row%greatest_pressure * max(area / row%area, error(5) / &
                   max(maxval(elastic%answer%pressure), tiny(error)))
        other_errors(3) = max(0.0_real64, pressure) / &
                          max(row%greatest_pressure, pressure, tiny(area))
      end if
      if (given%by_load .and. row%compression > 0.0_real64) then
        other_errors(4) = error(1) / row%compression
        of_total = (error(1) + request%top_error) / row%compression
      end if
      if (.not. given%by_load .and. abs(answer%load) > 0.0_real64) &
        of_total = (error(2) + of_top) * answer%load / elastic%answer%load / abs(answer%load)
    end associate
  end subroutine estimate_pixel_errors

  ! Solves the maps of every second and, where they keep their lengths, every third pixel of a map,
  ! and compares the totals: level, load, area, mean gap, greatest pressure.
  subroutine compare_coarser(map, laws, request, row, full, errors, of_top, unsolved)
    type(height_map), intent(in) :: map
    type(pixel_law_box), intent(in) :: laws(:)
    type(error_request), intent(in) :: request
    type(state_row), intent(in) :: row
    type(pixel_state), intent(inout) :: full       ! solution on all pixels; gets the elastic one
    ! Not allocated: the map is too small, or one of its halves is not solved.
    real(real64), allocatable, intent(out) :: errors(:)
    real(real64), intent(out) :: of_top            ! change of the load by that of first contact
    character(len=:), allocatable, intent(out) :: unsolved  ! why one is not
    ! First columns of maps of every third pixel: mirror images of each other on no even map.
    integer, parameter :: column_of_third(4) = [1, 2, 3, 2], row_of_third(4) = [1, 3, 2, 2]
    type(error_request) :: lowering
    real(real64) :: halves(5, 4), lower(5), thirds(5, 4), total(5)
    integer :: i, k

    of_top = 0.0_real64
    if (any(shape(map%height) < least_side)) return
    do k = 1, 4
      call solve_coarser(map, laws, request, 2, [1 + mod(k, 2), 1 + k / 3], full, halves(:, k), &
                         unsolved)
      if (allocated(unsolved)) return
    end do
    if (request%by_top .and. request%top_error > 0.0_real64 .and. .not. request%by_load) then
      lowering = request
      lowering%lowered = request%top_error
      call solve_coarser(map, laws, lowering, 2, [2, 1], full, lower, unsolved)
      if (allocated(unsolved)) return
      of_top = abs(lower(2) - halves(2, 1))
    end if
    total = [full%answer%level, full%answer%load, row%area, row%mean_gap, &
             maxval(full%answer%pressure)]
    errors = error_of_ratio(2) * root_mean(halves)
    if (any([(laws(i)%law%solves .and. laws(i)%law%is_simulated, i=1, size(laws))]) .or. &
        any(shape(map%height) < 3 * least_side / 2) .or. any(mod(shape(map%height), 3) > 0 .and. &
            [map%repeats(1), map%repeats(2)])) return
    do k = 1, 4
      call solve_coarser(map, laws, request, 3, [column_of_third(k), row_of_third(k)], full, &
                         thirds(:, k), unsolved)
      if (allocated(unsolved)) exit
    end do
    if (.not. allocated(unsolved)) errors = max(errors, error_of_ratio(3) * root_mean(thirds))
    if (allocated(unsolved)) deallocate (unsolved)

  contains

    ! Root of the mean square of the differences. No norm2: its last digit changes with the unit.
    function root_mean(coarser)
      real(real64), intent(in) :: coarser(5, 4)
      real(real64) :: root_mean(5)

      root_mean = 0.5_real64 * sqrt(sum((coarser - spread(total, 2, 4))**2, 2))
    end function root_mean

    ! Error over the difference by pixels that are `ratio` times as wide.
    pure real(real64) function error_of_ratio(ratio)
      integer, intent(in) :: ratio

      error_of_ratio = safety / (ratio**merge(1, 2, request%is_rough) - 1)
    end function error_of_ratio

  end subroutine compare_coarser

  ! Solves the map on every `step`th pixel.
  subroutine solve_coarser(map, laws, request, step, first, full, total, unsolved)
    type(height_map), intent(in) :: map
    type(pixel_law_box), intent(in) :: laws(:)
    type(error_request), intent(in) :: request
    integer, intent(in) :: step, first(2)       ! first column and row
    type(pixel_state), intent(inout) :: full    ! solution on all pixels; gets the elastic one
    real(real64), intent(out) :: total(5)       ! level, load, area, mean gap, greatest pressure
    character(len=:), allocatable, intent(out) :: unsolved  ! why there is none
    type(pixel_law_box) :: own(size(laws))
    type(pixel_state) :: coarse
    type(map_patch), allocatable :: patches(:)
    type(state_row) :: found
    integer :: i

    total = 0.0_real64
    coarse%deformed = every_pixel(map, step, first)
    if (.not. any(is_measured(coarse%deformed%height))) then
      unsolved = 'it has no measured pixel'
      return
    end if
    do i = 1, size(laws)
      allocate (own(i)%law, source=laws(i)%law)
      if (own(i)%law%is_simulated) call own(i)%law%coarsen(first, full)
    end do
    coarse%modulus = full%modulus
    coarse%tolerance = closed_halves
    coarse%answer%level = full%answer%level - request%lowered
    coarse%answer%interrupt = full%answer%interrupt
    coarse%answer%pressure = full%answer%pressure(first(1)::step, first(2)::step)
    if (request%by_load) coarse%load = full%answer%load
    if (request%by_load .and. allocated(full%hardness)) &
      coarse%load = min(coarse%load, most_load(coarse%deformed, full%hardness))
    call solve_pixel_state(own, coarse)
    associate (answer => coarse%answer)
      if (allocated(answer%failure)) then
        unsolved = answer%failure
        return
      end if
      call patches_in_contact(coarse%deformed, answer, patches, coarse%hardness)
      call measure_fields(coarse%deformed, answer, found)
      total = [answer%level, answer%load, sum(patches%area), found%mean_gap, &
               maxval(answer%pressure)]
    end associate
  end subroutine solve_coarser

  ! Root mean square difference of first contact of the four maps of every second pixel.
  pure real(real64) function difference_of_tops(map, top) result(difference)
    type(height_map), intent(in) :: map
    real(real64), intent(in) :: top  ! first contact of all pixels
    real(real64) :: error, half
    type(height_map) :: coarse
    integer :: k

    difference = 0.0_real64
    do k = 0, 3
      coarse = every_pixel(map, 2, [1 + mod(k, 2), 1 + k / 2])
      if (.not. any(is_measured(coarse%height))) cycle
      call find_top(coarse, half, error)
      difference = hypot(difference, 0.5_real64 * (half - top))
    end do
  end function difference_of_tops

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

  ! Error of the area by the straight pieces of rims: of each half a pixel over its length; the
  ! root of the sum of squares, and the sum of those from end to end of the map, as grooves at
  ! equal distances have the same error. Where the body ends, at an edge or a missing pixel, is no
  ! rim.
  pure real(real64) function error_of_rims(map, pressure) result(error)
    type(height_map), intent(in) :: map
    real(real64), intent(in) :: pressure(:, :)
    logical, allocatable :: beyond(:, :), rim(:, :), line(:)
    integer :: along, grooves, i, length, side

    error = 0.0_real64
    grooves = 0
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

  !> Relative growth of the slope of a map that is rough at the size of its pixels, by differences
  !> over 1, 2 and 4 of them, to pixels a quarter as wide; 0: it is not rough.
  pure real(real64) function growth_of_slope(map) result(growth)
    type(height_map), intent(in) :: map  !! levelled height map
    real(real64) :: ratio, slope(0:2)
    integer :: k

    growth = 0.0_real64
    if (any(shape(map%height) <= 4)) return
    slope = [(rms_slope_over(map, 2**k), k=0, 2)]
    ratio = fastest_growth
    if (slope(1) > slope(2)) &
      ratio = min(ratio, (slope(0) - slope(1)) / (slope(1) - slope(2)))
    if (slope(0) > slope(1) .and. ratio > rough_growth) &
      growth = (1.0_real64 - slope(1) / slope(0)) * (ratio + ratio**2)
  end function growth_of_slope

end module asperity_map_error
