!> Estimated error of the contact of a height map by the size of its pixels.
!>
!> The map is solved again on every second pixel along both sides, from each of the first four
!> pixels, with adhesion from the attraction of its pixels. Let d be the root mean square of the
!> four differences of a result. With the safety factor 3 of two grids (Roache, J. Fluids Eng. 116
!> (1994) 405) its error is 3 d/(2**p - 1), where p is the order: 2 on a surface that is smooth
!> between the pixels, so that it is d. That of the area is at least half of the correction of the
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
  use asperity_map_adhesion, only: adhesion_history
  use asperity_map_contact, only: map_answer, most_load
  use asperity_map_fields, only: measure_fields
  use asperity_map_patches, only: find_patches, map_patch
  use asperity_map_resolution, only: every_pixel
  use asperity_map_statistics, only: rms_slope_over
  use asperity_map_state, only: map_history, map_laws, solve_map_state
  implicit none
  private

  public :: estimate_pixel_errors, growth_of_slope

  ! Error over the difference by half the pixels at first order, with the factor 3 of Roache (1994);
  ! 1 at second order (derived; test: rough maps in test/maps/test_pixel_errors.py).
  real(real64), parameter :: first_order = 3.0_real64
  ! Tolerance of the gaps over the range of heights, or of the attraction (chosen: the differences
  ! are larger by far).
  real(real64), parameter :: closed_halves = 1.0e-6_real64
  ! Growth of the slope by the last halving of the pixel over that by the one before, above which a
  ! map is rough at the size of its pixels: 1/4 where it is smooth, 1/2 with kinks, 2**(1 - H) of a
  ! self-affine surface, at least 0.63 where that ends at two pixels (chosen; test: waves and random
  ! maps in test/maps/test_pixel_errors.py).
  real(real64), parameter :: rough_growth = 0.6_real64
  ! The same of independent heights (derived: their slope is inverse to the size of the pixel).
  real(real64), parameter :: fastest_growth = 2.0_real64
  ! Least number of pixels along a side (chosen: halves of two are no maps).
  integer, parameter :: least_side = 4

contains

  ! Long: the errors have one argument each.
  !> Estimates the errors of a solution. Nothing is known, and both are unchanged, where a map is
  !> too small, or its halves cannot be solved.
  subroutine estimate_pixel_errors(map, laws, history, answer, patches, state, by_load, of_total, &
                                   other_errors, unsolved)
    type(height_map), intent(in) :: map         !! map without plastic deformation
    type(map_laws), intent(in) :: laws          !! what acts on the pixels
    type(map_history), intent(in) :: history    !! attraction or memory of this solution
    type(map_answer), intent(in) :: answer      !! solution with pressures; under a load: > 0
    type(map_patch), intent(in) :: patches(:)   !! patches of its pressures
    type(state_row), intent(in) :: state        !! totals of this solution
    logical, intent(in) :: by_load              !! the load is prescribed, else the separation
    !> of the load over the load or, under a prescribed one, of the separation over the compression
    real(real64), intent(inout) :: of_total
    !> relative, of area, mean gap and greatest pressure; `not_computed`: unknown
    real(real64), intent(inout) :: other_errors(3)
    !> Reason why a map of every second pixel could not be solved; not allocated: all were.
    character(len=:), allocatable, intent(out) :: unsolved
    type(map_answer) :: elastic
    type(map_laws) :: its_laws
    real(real64), allocatable :: difference(:)
    real(real64) :: area, growth, pressure

    elastic = answer
    its_laws = laws
    if (allocated(laws%solid)) then
      deallocate (its_laws%solid)
      elastic%pressure = history%creep%elastic
      elastic%load = sum(history%creep%elastic) * product(map%pixel_spacing)
      ! Where a pixel has left the contact the surface has not recovered.
      if (.not. sum(abs(history%creep%elastic), mask=.not. answer%pressure > 0.0_real64) <= &
          closed_halves * sum(abs(history%creep%elastic))) return
    end if
    call compare_halves(map, elastic, history%adhesion, its_laws, by_load, [answer%level, &
      elastic%load, state%area, state%mean_gap, maxval(elastic%pressure)], difference, unsolved)
    if (.not. allocated(difference)) return
    growth = growth_of_slope(map)
    if (growth > 0.0_real64) difference = first_order * difference
    area = max(difference(3), 0.5_real64 * sum(patches%rim), growth * state%area)
    if (allocated(laws%attraction)) then
      area = max(area, error_of_rims(map, history%adhesion%contact_pressure))
    else
      area = max(area, error_of_rims(map, answer%pressure))
    end if
    other_errors(1) = area / state%area
    other_errors(2) = difference(4) / max(state%mean_gap, difference(4), tiny(area))
    if (.not. growth > 0.0_real64) then
      pressure = state%greatest_pressure * max( &
        area / state%area, difference(5) / max(maxval(elastic%pressure), tiny(difference)))
      other_errors(3) = max(0.0_real64, pressure) / &
                        max(state%greatest_pressure, pressure, tiny(area))
    end if
    if (by_load .and. state%compression > 0.0_real64) of_total = difference(1) / state%compression
    if (.not. by_load .and. abs(answer%load) > 0.0_real64) &
      of_total = difference(2) * answer%load / elastic%load / abs(answer%load)
  end subroutine estimate_pixel_errors

  ! Solves the four maps of every second pixel of a map, and compares the totals: level, load, area,
  ! mean gap, greatest pressure.
  subroutine compare_halves(map, full, adhesion, laws, by_load, totals, difference, unsolved)
    type(height_map), intent(in) :: map
    type(map_answer), intent(in) :: full           ! solution on all pixels
    type(adhesion_history), intent(in) :: adhesion
    type(map_laws), intent(in) :: laws
    logical, intent(in) :: by_load
    real(real64), intent(in) :: totals(5)          ! of the solution
    ! Root mean square over all four; not allocated: the map is too small, or one is not solved.
    real(real64), allocatable, intent(out) :: difference(:)
    character(len=:), allocatable, intent(out) :: unsolved  ! why one is not
    type(height_map) :: half
    type(map_answer) :: answer, no_answer
    type(map_history) :: history, no_history
    type(map_patch), allocatable :: patches(:)
    real(real64), allocatable :: load
    real(real64) :: root(5)
    type(state_row) :: state
    integer :: first(2), k

    root = 0.0_real64
    if (any(shape(map%height) < least_side)) return
    do k = 1, 4
      first = [1 + mod(k, 2), 1 + k / 3]
      half = every_pixel(map, 2, first)
      if (.not. any(is_measured(half%height))) return
      answer = no_answer
      answer%level = full%level
      answer%interrupt = full%interrupt
      answer%pressure = full%pressure(first(1)::2, first(2)::2)
      if (by_load) load = full%load
      if (by_load .and. allocated(laws%hardness)) load = min(load, most_load(half, laws%hardness))
      history = no_history
      history%deformed = half
      if (allocated(laws%attraction)) then
        history%adhesion%attraction = adhesion%attraction(first(1)::2, first(2)::2)
        history%adhesion%contact_pressure = &
          adhesion%contact_pressure(first(1)::2, first(2)::2)
      end if
      call solve_map_state(laws, 0.0_real64, history, answer, load, closed_halves)
      if (allocated(answer%failure)) unsolved = answer%failure
      if (allocated(answer%failure)) return
      if (allocated(laws%attraction)) then
        call find_patches(half, history%adhesion%contact_pressure, patches)
      else
        call find_patches(half, answer%pressure, patches, hardness=laws%hardness)
      end if
      call measure_fields(half, answer, state)
      ! No hypot: on vectors its last digit changes with the unit.
      root = sqrt(root**2 + ([answer%level, answer%load, sum(patches%area), state%mean_gap, &
                              maxval(answer%pressure)] - totals)**2)
    end do
    difference = 0.5_real64 * root
  end subroutine compare_halves

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
