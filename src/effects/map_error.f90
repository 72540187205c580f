!> Estimated error of the contact of a height map by the size of its pixels.
!>
!> The map is solved again on every m-th pixel along both sides, with adhesion from the attraction
!> of its pixels: for m = 2 from two first pixels along a diagonal through the highest pixel, and
!> from three for m = 3, 4 or 5, the first one with which the map keeps its lengths. The former
!> alone are mirror images of each other on a symmetric map. Let d be the root mean square of the
!> differences of a result. With the safety factor 3 of two grids (Roache, J. Fluids Eng. 116
!> (1994) 405) its error is 3 d/(m**p - 1), the larger of the two. The order p of separation, load
!> and gap is 2, on a smooth map without free edges 5/2 (measured on waves and random surfaces). On
!> a rough map it is 3/2: displacements by waves of heights h**H, H from 0 to 1, have errors of
!> h**(1 + H). The order of the area is 3/2: the pixels along a rim, 1/h of the spacing h, have
!> independent errors of h**2. That of the greatest pressure is 2.
!>
!> The error of first contact is that of a vertex (`map_top`) where the map is smooth. Where it is
!> not, it is that of the tops of every second, third and fourth pixel by the same formula, with
!> their observed order, 1 to 2. The compression has both errors, which are independent.
!>
!> The error of the area is at least half of the correction of the rim, and at least that of
!> straight rims: each straight piece of a rim along the pixels lies up to half a pixel from its
!> sides. The errors of pieces are independent, but those of grooves, which have no ends, add up.
!> On a map that is rough at the size of its pixels the slope grows on by the observed ratio to
!> pixels a quarter as wide, and the area is inverse to the slope (Persson, J. Chem. Phys. 115
!> (2001) 3840).
!>
!> The relative error of the greatest pressure is at least that of the area, as peaks lie between
!> the pixels of all grids. It has no estimate where no limit is in sight: on rough maps, and on
!> others that are not smooth, as at kinks, where pixels twice as wide have a pressure that is a
!> tenth less (measured: reference_output/bench/pixel_estimates.csv; test:
!> test/maps/test_pixel_errors.py).
!>
!> With creep they are those of the elastic state of the same displacements, with its own load (Lee
!> and Radok 1960), which holds as long as no pixel has left the contact.
module asperity_map_error
  use asperity_contact_records, only: state_row
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: not_computed, real64
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

  public :: error_request, estimate_pixel_errors, find_first_contact, share_at_ends

  ! Safety factor of the error of two grids (Roache 1994; test: rough maps in
  ! test/maps/test_pixel_errors.py).
  real(real64), parameter :: safety = 3.0_real64
  ! Halvings of the interval of the observed order (chosen: to 1e-3).
  integer, parameter :: digits_of_order = 11
  ! Tolerance of the gaps over the range of heights, or of the attraction (chosen: the differences
  ! are larger by far).
  real(real64), parameter :: closed_halves = 1.0e-4_real64
  ! Growth of the slope by the last halving of the pixel over that by the one before, above which a
  ! map is rough at the size of its pixels: 1/4 where it is smooth, 1/2 with kinks, 2**(1 - H) of a
  ! self-affine surface, at least 0.63 where that ends at two pixels (chosen; test: waves and random
  ! maps in test/maps/test_pixel_errors.py).
  real(real64), parameter :: rough_growth = 0.6_real64
  ! The same, below which it is smooth (derived: between 1/4 and 1/2; test: kinks there).
  real(real64), parameter :: smooth_growth = 1.0_real64 / 3.0_real64
  ! The same of independent heights (derived: their slope is inverse to the size of the pixel).
  real(real64), parameter :: fastest_growth = 2.0_real64
  ! Fall of the greatest pressure by pixels twice as wide, relative, below which it is resolved
  ! (chosen: the limit of the warning of resolution).
  real(real64), parameter :: resolved = 0.1_real64
  ! Least number of pixels along a side (chosen: halves of two are no maps).
  integer, parameter :: least_side = 4

  !> The map between its pixels, and the quantity that is prescribed.
  type :: error_request
    logical :: by_load = .false.               !! the load is prescribed, else the separation
    logical :: by_top = .false.                !! the compression is: the load has its error
    logical :: is_smooth = .true.              !! the map is smooth between its pixels
    real(real64) :: order = 2.0_real64         !! of the errors of level, load and gap
    real(real64) :: top_error = 0.0_real64     !! error of first contact [length]
    !> Relative growth of the slope to pixels a quarter as wide; 0: the map is not rough.
    real(real64) :: growth = 0.0_real64
    real(real64), private :: lowered = 0.0_real64  !! the flat below its level, unless by load
  end type error_request

contains

  !> Estimates the errors of a solution. They are unchanged where a map is too small, or its halves
  !> cannot be solved.
  subroutine estimate_pixel_errors(map, laws, state, request, row, unsolved)
    type(height_map), intent(in) :: map            !! map without plastic deformation
    type(pixel_law_box), intent(in) :: laws(:)     !! laws with the memory of this solution
    type(pixel_state), intent(in) :: state         !! solution; under a load: > 0
    type(error_request), intent(in) :: request     !! quantity that is prescribed
    type(state_row), intent(inout) :: row          !! totals of this solution; gets their errors
    !> Reason why a map of every second pixel could not be solved; not allocated: all were.
    character(len=:), allocatable, intent(out) :: unsolved
    type(pixel_state) :: elastic
    real(real64), allocatable :: error(:)
    real(real64) :: area, of_top, pressure

    elastic = state
    ! Coarser maps start from pressures alone.
    deallocate (elastic%deformed%height)
    if (allocated(elastic%answer%displacement)) deallocate (elastic%answer%displacement)
    call compare_coarser(map, laws, request, row, elastic, error, of_top, unsolved)
    if (.not. allocated(error)) return
    associate (answer => state%answer, patches => state%patches)
      area = max(error(3), 0.5_real64 * sum(patches%rim), request%growth * row%area)
      if (allocated(answer%contact_pressure)) then
        area = max(area, error_of_rims(map, answer%contact_pressure))
      else
        area = max(area, error_of_rims(map, answer%pressure))
      end if
      row%area_error = area / row%area
      if (request%growth > 0.0_real64) row%area_error = area / (row%area + area)
      row%gap_error = error(4) / max(row%mean_gap, error(4), tiny(area))
      if (error(5) > not_computed) then
        pressure = row%greatest_pressure * max(row%area_error, error(5) / &
                   max(maxval(elastic%answer%pressure), tiny(error)))
        row%pressure_error = max(0.0_real64, pressure) / &
                             max(row%greatest_pressure, pressure, tiny(area))
      end if
      if (request%by_load .and. row%compression > 0.0_real64) then
        row%separation_error = error(1) / row%compression
        row%error_estimate = hypot(error(1), request%top_error) / row%compression
      end if
      if (.not. request%by_load .and. abs(answer%load) > 0.0_real64) &
        row%error_estimate = hypot(error(2), of_top) * answer%load / elastic%answer%load / &
                             abs(answer%load)
    end associate
  end subroutine estimate_pixel_errors

  ! Solves the maps of every second and of fewer pixels of a map, and compares the totals: level,
  ! load, area, mean gap, greatest pressure.
  subroutine compare_coarser(map, laws, request, row, full, errors, of_top, unsolved)
    type(height_map), intent(in) :: map
    type(pixel_law_box), intent(in) :: laws(:)
    type(error_request), intent(in) :: request
    type(state_row), intent(in) :: row
    type(pixel_state), intent(inout) :: full       ! solution on all pixels; gets the elastic one
    ! Not allocated: the map is too small, or one of its halves is not solved. The last one is
    ! `not_computed` where the greatest pressure has no limit in sight.
    real(real64), allocatable, intent(out) :: errors(:)
    real(real64), intent(out) :: of_top            ! change of the load by that of first contact
    character(len=:), allocatable, intent(out) :: unsolved  ! why one is not
    type(error_request) :: lowering
    real(real64) :: fall, halves(5, 2), lower(5), order, total(5), wider(5, 3)
    integer :: i, k, place(2), step
    logical :: has_solver

    of_top = 0.0_real64
    if (any(shape(map%height) < least_side)) return
    place = maxloc(map%height)
    do k = 1, 2
      call solve_coarser(map, laws, request, 2, 1 + mod(place + k, 2), full, halves(:, k), unsolved)
      if (allocated(unsolved)) return
    end do
    if (request%by_top .and. request%top_error > 0.0_real64 .and. .not. request%by_load) then
      lowering = request
      lowering%lowered = request%top_error
      call solve_coarser(map, laws, lowering, 2, 1 + mod(place + 1, 2), full, lower, unsolved)
      if (allocated(unsolved)) return
      of_top = abs(lower(2) - halves(2, 1))
    end if
    total = [full%answer%level, full%answer%load, row%area, row%mean_gap, &
             maxval(full%answer%pressure)]
    order = request%order
    ! Attraction over the gaps is less smooth than the contact.
    has_solver = any([(laws(i)%law%solves .and. laws(i)%law%is_simulated, i=1, size(laws))])
    if (has_solver) order = min(order, 2.0_real64)
    errors = error_by(halves, 2)
    step = merge(0, step_beside_two(map), has_solver)
    do k = 1, merge(3, 0, step > 0)
      call solve_coarser(map, laws, request, step, 1 + mod(place + k, step), full, wider(:, k), &
                         unsolved)
      if (allocated(unsolved)) step = 0
      if (allocated(unsolved)) exit
    end do
    if (allocated(unsolved)) deallocate (unsolved)
    if (step > 0) errors = max(errors, error_by(wider, step))
    fall = total(5) - sum(halves(5, :)) / size(halves, 2)
    if (request%growth > 0.0_real64 .or. &
        (fall > resolved * total(5) .and. .not. request%is_smooth)) errors(5) = not_computed

  contains

    ! Errors by the differences from pixels that are `step` times as wide. No norm2: its last digit
    ! changes with the unit.
    pure function error_by(coarser, step) result(error)
      real(real64), intent(in) :: coarser(:, :)
      integer, intent(in) :: step
      real(real64) :: error(5)

      error = sqrt(sum((coarser - spread(total, 2, size(coarser, 2)))**2, 2) / size(coarser, 2))
      error = error * safety / (step**[order, order, 1.5_real64, order, 2.0_real64] - 1.0_real64)
    end function error_by

  end subroutine compare_coarser

  ! The first of the steps 3, 4 and 5 with which a map keeps its lengths; 0: none, or the map is too
  ! small.
  pure integer function step_beside_two(map) result(step)
    type(height_map), intent(in) :: map

    do step = 3, 5
      if (any(shape(map%height) < step * least_side / 2)) exit
      if (.not. any(mod(shape(map%height), step) > 0 .and. [map%repeats(1), map%repeats(2)])) return
    end do
    step = 0
  end function step_beside_two

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

  !> Finds first contact, its estimated error, and whether the map is smooth or rough at the size
  !> of its pixels.
  pure subroutine find_first_contact(map, top, request)
    type(height_map), intent(in) :: map            !! levelled height map
    real(real64), intent(out) :: top               !! height of the top [length]
    type(error_request), intent(out) :: request    !! gets the properties of the map
    real(real64), parameter :: wide(2:4) = [2.0_real64, 3.0_real64, 4.0_real64]
    real(real64) :: difference(2:4), highest, lower, lowest, order, ratio, unused
    type(height_map) :: coarse
    integer :: i, k, step

    call find_top(map, top, request%top_error)
    call measure_growth(map, ratio, request%growth)
    request%is_smooth = ratio < smooth_growth
    if (request%is_smooth .and. map%repeats(1) .and. map%repeats(2) .and. &
        all(is_measured(map%height))) request%order = 2.5_real64
    if (request%growth > 0.0_real64) request%order = 1.5_real64
    if (request%is_smooth .or. any(shape(map%height) < least_side)) return
    do step = 2, 4
      difference(step) = 0.0_real64
      do k = 0, step**2 - 1
        coarse = every_pixel(map, step, [1 + mod(k, step), 1 + k / step])
        if (.not. any(is_measured(coarse%height))) cycle
        call find_top(coarse, lower, unused)
        difference(step) = difference(step) + (lower - top)**2
      end do
      difference(step) = sqrt(difference(step)) / step
    end do
    ! The largest order with which the differences grow as much.
    lowest = 1.0_real64
    highest = 2.0_real64
    do i = 1, digits_of_order
      order = 0.5_real64 * (lowest + highest)
      if (all(difference(3:) * (wide(:3)**order - 1.0_real64) >= &
              difference(:3) * (wide(3:)**order - 1.0_real64))) then
        lowest = order
      else
        highest = order
      end if
    end do
    ! A quadratic has the same top on all pixels.
    request%is_smooth = .not. highest < 2.0_real64
    request%top_error = max(request%top_error, &
                            safety * maxval(difference / (wide**lowest - 1.0_real64)))
  end subroutine find_first_contact

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

  ! Finds the growth of the slope of a map from differences over 2 pixels to those over 1, over that
  ! from 4 to 2; at most `fastest_growth`.
  pure subroutine measure_growth(map, ratio, growth)
    type(height_map), intent(in) :: map       ! levelled
    real(real64), intent(out) :: ratio
    ! Relative, to pixels a quarter as wide; 0: the map is not rough at the size of its pixels.
    real(real64), intent(out) :: growth
    real(real64) :: slope(0:2)
    integer :: k

    growth = 0.0_real64
    ratio = fastest_growth
    if (any(shape(map%height) <= 4)) return
    slope = [(rms_slope_over(map, 2**k), k=0, 2)]
    if (slope(1) > slope(2)) &
      ratio = min(ratio, (slope(0) - slope(1)) / (slope(1) - slope(2)))
    if (slope(0) > slope(1) .and. ratio > rough_growth) &
      growth = (1.0_real64 - slope(1) / slope(0)) * (ratio + ratio**2)
  end subroutine measure_growth

end module asperity_map_error
