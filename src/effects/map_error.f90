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
  use asperity_map_contact, only: most_load
  use asperity_map_fields, only: measure_fields
  use asperity_map_patches, only: map_patch
  use asperity_map_resolution, only: every_pixel
  use asperity_map_statistics, only: rms_slope_over
  use asperity_pixel_law, only: patches_in_contact, pixel_law_box, pixel_state
  use asperity_pixel_sequence, only: solve_pixel_state
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

  !> Estimates the errors of a solution. Nothing is known, and both are unchanged, where a map is
  !> too small, or its halves cannot be solved.
  subroutine estimate_pixel_errors(map, laws, state, row, by_load, of_total, other_errors, &
                                   unsolved)
    type(height_map), intent(in) :: map            !! map without plastic deformation
    type(pixel_law_box), intent(in) :: laws(:)     !! laws with the memory of this solution
    type(pixel_state), intent(in) :: state         !! solution; under a load: > 0
    type(state_row), intent(in) :: row             !! totals of this solution
    logical, intent(in) :: by_load                 !! the load is prescribed, else the separation
    !> of the load over the load or, under a prescribed one, of the separation over the compression
    real(real64), intent(inout) :: of_total
    !> relative, of area, mean gap and greatest pressure; `not_computed`: unknown
    real(real64), intent(inout) :: other_errors(3)
    !> Reason why a map of every second pixel could not be solved; not allocated: all were.
    character(len=:), allocatable, intent(out) :: unsolved
    type(pixel_state) :: elastic
    real(real64), allocatable :: difference(:)
    real(real64) :: area, growth, pressure

    elastic = state
    call compare_halves(map, laws, by_load, row, elastic, difference, unsolved)
    if (.not. allocated(difference)) return
    growth = growth_of_slope(map)
    if (growth > 0.0_real64) difference = first_order * difference
    associate (answer => state%answer, patches => state%patches)
      area = max(difference(3), 0.5_real64 * sum(patches%rim), growth * row%area)
      if (allocated(answer%contact_pressure)) then
        area = max(area, error_of_rims(map, answer%contact_pressure))
      else
        area = max(area, error_of_rims(map, answer%pressure))
      end if
      other_errors(1) = area / row%area
      other_errors(2) = difference(4) / max(row%mean_gap, difference(4), tiny(area))
      if (.not. growth > 0.0_real64) then
        pressure = row%greatest_pressure * max(area / row%area, difference(5) / &
                   max(maxval(elastic%answer%pressure), tiny(difference)))
        other_errors(3) = max(0.0_real64, pressure) / &
                          max(row%greatest_pressure, pressure, tiny(area))
      end if
      if (by_load .and. row%compression > 0.0_real64) of_total = difference(1) / row%compression
      if (.not. by_load .and. abs(answer%load) > 0.0_real64) &
        of_total = difference(2) * answer%load / elastic%answer%load / abs(answer%load)
    end associate
  end subroutine estimate_pixel_errors

  ! Solves the four maps of every second pixel of a map, and compares the totals: level, load, area,
  ! mean gap, greatest pressure.
  subroutine compare_halves(map, laws, by_load, row, full, difference, unsolved)
    type(height_map), intent(in) :: map
    type(pixel_law_box), intent(in) :: laws(:)
    logical, intent(in) :: by_load
    type(state_row), intent(in) :: row
    type(pixel_state), intent(inout) :: full       ! solution on all pixels; gets the elastic one
    ! Root mean square of all four; not allocated: the map is too small, or one is not solved.
    real(real64), allocatable, intent(out) :: difference(:)
    character(len=:), allocatable, intent(out) :: unsolved  ! why one is not
    type(pixel_law_box) :: own(size(laws))
    type(pixel_state) :: half, no_state
    type(height_map) :: coarser
    type(map_patch), allocatable :: patches(:)
    type(state_row) :: found
    real(real64) :: root(5)
    integer :: first(2), i, k

    root = 0.0_real64
    if (any(shape(map%height) < least_side)) return
    do k = 1, 4
      first = [1 + mod(k, 2), 1 + k / 3]
      half = no_state
      coarser = every_pixel(map, 2, first)
      if (.not. any(is_measured(coarser%height))) return
      half%deformed = coarser
      do i = 1, size(laws)
        if (allocated(own(i)%law)) deallocate (own(i)%law)
        allocate (own(i)%law, source=laws(i)%law)
        if (own(i)%law%is_simulated) call own(i)%law%coarsen(first, full)
      end do
      half%modulus = full%modulus
      half%tolerance = closed_halves
      half%answer%level = full%answer%level
      half%answer%interrupt = full%answer%interrupt
      half%answer%pressure = full%answer%pressure(first(1)::2, first(2)::2)
      if (by_load) half%load = full%answer%load
      if (by_load .and. allocated(full%hardness)) &
        half%load = min(half%load, most_load(coarser, full%hardness))
      call solve_pixel_state(own, half)
      associate (answer => half%answer)
        if (allocated(answer%failure)) unsolved = answer%failure
        if (allocated(answer%failure)) return
        call patches_in_contact(coarser, answer, patches, half%hardness)
        call measure_fields(coarser, answer, found)
        ! No hypot: on vectors its last digit changes with the unit.
        root = sqrt(root**2 + &
          ([answer%level, answer%load, sum(patches%area), found%mean_gap, &
            maxval(answer%pressure)] - [full%answer%level, full%answer%load, row%area, &
            row%mean_gap, maxval(full%answer%pressure)])**2)
      end associate
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
