!> Estimated error of the contact of a height map by the size of its pixels.
!>
!> The map is solved again on every second pixel along both sides: on the odd ones, and on the even
!> ones, with adhesion from the attraction of its pixels. With d the larger difference of a result
!> from that on all pixels, the errors are 0.85 d of the separation at a load, of the load at a
!> separation and of the mean gap, and the larger of d and half the correction of the rim of the
!> area. The relative error of the greatest pressure is that of d, or that of the area where it is
!> larger, as peaks lie between the pixels of all grids
!> (fitted on balls, waves and self-affine maps at 6 pressures, against closed forms and pixels a
!> quarter as wide; measured on other kinds: 95 to 98 % of the errors are below the estimate,
!> reference_output/bench/pixel_estimates.csv; test: test/regression/test_pixel_errors.py). Waves
!> with crests along the pixels have less accurate estimates.
!>
!> With creep they are those of the elastic state of the same displacements, with its own load (Lee
!> and Radok 1960), which holds as long as no pixel has left the contact.
!>
!> They are errors of a surface that is smooth between the pixels. Of a map that is rough at their
!> size finer pixels would show more, which no coarser ones tell.
!>
!> A height map on fewer or more pixels.
module asperity_map_error
  use asperity_contact_records, only: state_row
  use asperity_height_map, only: height_map, index_beside, is_measured, no_height
  use asperity_kinds, only: not_computed, real64
  use asperity_map_contact, only: map_answer, most_load
  use asperity_map_fields, only: measure_fields
  use asperity_map_patches, only: find_patches, map_patch
  use asperity_map_state, only: map_history, map_laws, solve_map_state
  implicit none
  private

  public :: estimate_pixel_errors, is_rough_at_pixels, pixel_errors, doubled_map, every_pixel

  !> Estimated errors; `not_computed`: unknown.
  type :: pixel_errors
    real(real64) :: level = not_computed  !! of the separation at the load [length]
    real(real64) :: load = not_computed   !! of the load at the separation
    real(real64) :: area = not_computed   !! of the contact area
    real(real64) :: gap = not_computed       !! of the mean gap [length]
    real(real64) :: pressure = not_computed  !! of the greatest pressure
  end type pixel_errors

  ! Share of the difference by half the pixels that is the error (measured, see above).
  real(real64), parameter :: share_of_difference = 0.85_real64
  ! Tolerance of the gaps over the range of heights (chosen: the differences are larger by far).
  real(real64), parameter :: closed_halves = 1.0e-6_real64
  ! Growth of the slope by the last halving of the pixel over that by the one before, above which a
  ! map is rough at the size of its pixels: 1/4 where it is smooth, 1/2 with kinks, 2**(1 - H) of a
  ! self-affine surface, at least 0.63 where that ends at two pixels (chosen; test: waves and random
  ! maps in test/regression/test_pixel_errors.py).
  real(real64), parameter :: rough_growth = 0.6_real64
  ! Least number of pixels along a side (chosen: halves of two are no maps).
  integer, parameter :: least_side = 4

contains

  !> Estimates the errors of a solution. Nothing is known of a map that is too small, or whose
  !> halves cannot be solved.
  subroutine estimate_pixel_errors(map, laws, history, answer, patches, state, by_load, errors)
    type(height_map), intent(in) :: map         !! map without plastic deformation
    type(map_laws), intent(in) :: laws          !! what acts on the pixels
    type(map_history), intent(in) :: history    !! attraction or memory of this solution
    type(map_answer), intent(in) :: answer      !! solution with pressures; under a load: > 0
    type(map_patch), intent(in) :: patches(:)   !! patches of its pressures
    type(state_row), intent(in) :: state        !! totals of this solution
    logical, intent(in) :: by_load              !! the load is prescribed, else the separation
    type(pixel_errors), intent(out) :: errors   !! errors of this solution
    type(map_answer) :: elastic, of_half, unsolved
    type(map_history) :: its_history, no_history
    type(map_laws) :: its_laws
    type(height_map) :: half
    type(map_patch), allocatable :: patches_of_half(:)
    real(real64), allocatable :: load
    type(state_row) :: state_of_half
    real(real64) :: difference(5)
    integer :: first

    if (any(shape(map%height) < least_side)) return
    elastic = answer
    its_laws = laws
    if (allocated(laws%solid)) then
      deallocate (its_laws%solid)
      elastic%pressure = history%creep%elastic
      elastic%load = sum(elastic%pressure) * product(map%pixel_spacing)
      ! Where a pixel has left the contact the surface has not recovered.
      if (.not. sum(abs(elastic%pressure), mask=.not. answer%pressure > 0.0_real64) <= &
          closed_halves * sum(abs(elastic%pressure))) return
    end if
    difference = 0.0_real64
    do first = 1, 2
      half = every_pixel(map, 2, first)
      if (.not. any(is_measured(half%height))) return
      of_half = unsolved
      of_half%level = answer%level
      of_half%interrupt = answer%interrupt
      of_half%pressure = elastic%pressure(first::2, first::2)
      if (by_load) load = elastic%load
      if (by_load .and. allocated(laws%hardness)) load = min(load, most_load(half, laws%hardness))
      its_history = no_history
      its_history%deformed = half
      if (allocated(laws%attraction)) then
        its_history%adhesion%attraction = history%adhesion%attraction(first::2, first::2)
        its_history%adhesion%contact_pressure = &
          history%adhesion%contact_pressure(first::2, first::2)
      end if
      call solve_map_state(its_laws, 0.0_real64, its_history, of_half, load, closed_halves)
      if (allocated(of_half%failure)) return
      if (allocated(laws%attraction)) then
        call find_patches(half, its_history%adhesion%contact_pressure, patches_of_half)
      else
        call find_patches(half, of_half%pressure, patches_of_half, hardness=laws%hardness)
      end if
      call measure_fields(half, of_half, state_of_half)
      difference = max(difference, abs( &
        [of_half%level, of_half%load, sum(patches_of_half%area), state_of_half%mean_gap, &
         maxval(of_half%pressure)] - &
        [answer%level, elastic%load, state%area, state%mean_gap, maxval(elastic%pressure)]))
    end do
    errors%area = max(difference(3), 0.5_real64 * sum(patches%rim))
    errors%gap = share_of_difference * difference(4)
    errors%pressure = state%greatest_pressure * max(errors%area / state%area, &
      difference(5) / max(maxval(elastic%pressure), tiny(difference)))
    if (by_load) errors%level = share_of_difference * difference(1)
    if (.not. by_load) &
      errors%load = share_of_difference * difference(2) * answer%load / elastic%load
  end subroutine estimate_pixel_errors

  !> Whether a map is rough at the size of its pixels: its slope by differences over 1, 2 and 4
  !> pixels does not converge.
  pure logical function is_rough_at_pixels(map)
    type(height_map), intent(in) :: map  !! levelled height map
    real(real64) :: slope(0:2)
    integer :: k

    is_rough_at_pixels = .false.
    if (any(shape(map%height) <= 4)) return
    slope = [(norm2([slope_over(2**k, 1), slope_over(2**k, 2)]), k=0, 2)]
    is_rough_at_pixels = slope(0) - slope(1) > rough_growth * max(0.0_real64, slope(1) - slope(2))

  contains

    ! Root mean square of the slope by measured pixels at a distance along an axis.
    pure real(real64) function slope_over(distance, axis) result(slope)
      integer, intent(in) :: distance, axis
      integer :: i, j, number, other(2)

      slope = 0.0_real64
      number = 0
      do j = 1, map%rows
        do i = 1, map%columns
          other = [i, j]
          other(axis) = index_beside(other(axis) + distance, size(map%height, axis), &
                                     map%repeats(axis))
          if (other(axis) == 0) cycle
          if (.not. (is_measured(map%height(i, j)) .and. &
                     is_measured(map%height(other(1), other(2))))) cycle
          number = number + 1
          slope = slope + (map%height(other(1), other(2)) - map%height(i, j))**2
        end do
      end do
      slope = sqrt(slope / max(1, number)) / (distance * map%pixel_spacing(axis))
    end function slope_over

  end function is_rough_at_pixels

  !> The map on every second pixel or fewer. A periodic map keeps its lengths: where the step does
  !> not divide its number of pixels, they are a little narrower.
  pure type(height_map) function every_pixel(map, step, first) result(coarse)
    type(height_map), intent(in) :: map       !! map of any size
    integer, intent(in) :: step               !! pixels along both sides to the next one
    integer, intent(in), optional :: first    !! column and row of the first; absent: 1
    integer :: begin

    begin = 1
    if (present(first)) begin = first
    call take_heights(map, real(step, real64), map%height(begin::step, begin::step), coarse)
  end function every_pixel

  !> The map on pixels half as wide along both sides: between two pixels the cubic through the four
  !> nearest, the line where one of the outer two is missing.
  pure type(height_map) function doubled_map(map) result(fine)
    type(height_map), intent(in) :: map  !! map of any size

    call take_heights(map, 0.5_real64, doubled_lines(transpose(doubled_lines( &
      transpose(map%height), map%repeats(2))), map%repeats(1)), fine)
  end function doubled_map

  ! Makes a map with other heights, at a ratio of its spacing to that of the map they are from.
  pure subroutine take_heights(map, ratio, height, changed)
    type(height_map), intent(in) :: map
    real(real64), intent(in) :: ratio, height(:, :)
    type(height_map), intent(out) :: changed

    allocate (changed%height, source=height)
    changed%columns = size(height, 1)
    changed%rows = size(height, 2)
    changed%periodic = map%periodic
    changed%strip_axis = map%strip_axis
    changed%pixel_spacing = ratio * map%pixel_spacing
    where ([map%repeats(1), map%repeats(2)]) changed%pixel_spacing = map%pixel_spacing * &
      shape(map%height) / real(shape(height), real64)
    if (allocated(map%unit)) changed%unit = map%unit
  end subroutine take_heights

  ! Heights with one more between any two along the first index.
  pure function doubled_lines(height, periodic) result(doubled)
    real(real64), intent(in) :: height(:, :)
    logical, intent(in) :: periodic
    real(real64), allocatable :: after(:, :), before(:, :), doubled(:, :), middle(:, :), next(:, :)
    integer :: last

    next = cshift(height, 1)
    before = cshift(height, -1)
    after = cshift(height, 2)
    last = size(height, 1)
    if (.not. periodic) then
      before(1, :) = no_height
      after(max(1, last - 1):, :) = no_height
      last = last - 1
    end if
    allocate (middle, mold=height)
    where (is_measured(height) .and. is_measured(next))
      where (is_measured(before) .and. is_measured(after))
        middle = (9.0_real64 * (height + next) - (before + after)) / 16.0_real64
      else where
        middle = 0.5_real64 * (height + next)
      end where
    else where
      middle = no_height
    end where
    allocate (doubled(size(height, 1) + last, size(height, 2)))
    doubled(1::2, :) = height
    doubled(2::2, :) = middle(:last, :)
  end function doubled_lines

end module asperity_map_error
