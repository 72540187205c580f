!> A map of heights pressed by a rigid flat: every sample a square of uniform pressure.
!>
!> The half-space under the map has the combined modulus, displacements are taken at the samples:
!> Love's (1929) when the half-space goes on beyond the map, free of load there, or the sum of waves
!> when the map repeats itself. The pressures are those of least energy (see element_forces). A map
!> is first pressed at half its resolution, that one at half of that, and so on: each is the start
!> of the next.
module asperity_map_contact
  use asperity_constants, only: pi
  use asperity_lattice_convolution, only: lattice_convolution, padded_length
  use asperity_layer_compliance, only: add_layers, layer_factor, mean_displacement
  use asperity_element_influence, only: centre_influence
  use asperity_element_forces, only: find_forces, force_bounds, missing_gap
  use asperity_height_map, only: height_map, is_measured, no_height
  use asperity_interruption, only: interruption
  use asperity_kinds, only: int64, real32, real64
  use asperity_line_transform, only: bytes_of_plans
  use asperity_map_resolution, only: take_heights
  use asperity_process, only: check_memory
  use asperity_solve_ending, only: solve_ending
  use asperity_traction_influence, only: integral_over_element, of_xx, of_yy
  implicit none
  private

  public :: check_level, displacement_by, half_map, map_answer, most_load, prepare_influence, &
            press_map, reach_hardness, room_to_press, room_to_solve

  !> Request and solution of the contact of a map with a rigid flat.
  type :: map_answer
    real(real64) :: level = 0.0_real64            !! height of the flat
    real(real64) :: load = 0.0_real64             !! given, or found
    real(real64), allocatable :: pressure(:, :)   !! on every sample; given: a start
    real(real32), allocatable, private :: earlier(:, :)  !! pressures of the start before
    real(real64), private :: solved_level = 0.0_real64  !! level of the last solution
    !> Whether each pixel is in contact; not allocated: the pressure there is more than 0.
    logical, allocatable :: touches(:, :)
    !> Pressure in contact beside an attraction, 0 or more, and that attraction there; not
    !> allocated: the surfaces do not attract each other.
    real(real64), allocatable :: contact_pressure(:, :)
    real(real64) :: attraction = 0.0_real64
    !> Sum of the elastic displacements of both surfaces, > 0 apart from each other, on every pixel;
    !> on a periodic map its mean is 0.
    real(real64), allocatable :: displacement(:, :)
    type(solve_ending) :: ending                  !! residual: largest gap violated over the heights
    type(interruption) :: interrupt               !! given: who can end the solve, which fails
    character(len=:), allocatable :: failure      !! why there is none
  end type map_answer

  !> Largest gap left in contact, or overlap left beside it, over the range of heights under the
  !> flat. At 1e-10 pressures agree with exact ones to 2e-9 of the largest on maps up to 512 x 512,
  !> at 1e-9 to 1.3e-8 (measured; test: ten maps in test/maps/test_fields.py).
  real(real64), parameter, public :: closed_fully = 1.0e-10_real64
  ! The same of coarser maps, which are only a start. Derived: finer pixels have heights of their
  ! own, on rough maps a few percent of the range, which no pressures of coarser ones close.
  real(real64), parameter :: closed_start = 1.0e-2_real64

  ! Relative tolerance of a prescribed load (chosen; test: loads far beyond full contact in
  ! test/maps/test_map_edges.py).
  real(real64), parameter :: load_met = 1.0e-6_real64

  ! Error of a pressure over that which closes the residual gap of one pixel: pixels within it of
  ! the hardness are at the hardness. The waves of a map need at most pi/sqrt(2) of it (derived: 2/q
  ! of the shortest wave); the rest is for earlier states of a path and for free edges (chosen;
  ! test: load cycles in test/maps/test_plastic_pixels.py).
  real(real64), parameter :: error_of_residual = 100.0_real64
  ! The most of that, over the hardness (chosen: the share that a load gains is as small).
  real(real64), parameter :: hardness_rounding = 1.0e-4_real64

  ! Change of a load over the load, above which coarser maps are a better start than the last state
  ! (measured: 0.2 to 0.3 on random maps of 128 to 512 pixels a side; test: paths in
  ! test/maps/test_map_scene.py).
  real(real64), parameter :: far_load = 0.25_real64
  ! The same of a level below the top of the map, over its depth (measured: 0.01 to 0.05 there).
  real(real64), parameter :: far_level = 0.02_real64

  ! Number of pixels from which on a coarser map saves more time than it costs (chosen; test: large
  ! maps in test/maps/test_map_scene.py).
  integer, parameter :: worth_halving = 64 * 64

  ! Bound of the displacement by a load, over the load, modulus and side of a pixel. Derived: at the
  ! centre of one pixel of a x b it is (2/pi) (1 + ln(2 a/b)) at most, and on a strip of period l
  ! and width w (2/pi) ln(2 w/l) more: 28 where both ratios are 1e9 (test: a flat with missing
  ! pixels in test_creep_pixels.py).
  real(real64), parameter :: displacement_reach = 64.0_real64
  ! Bytes of the spectra for a padded pixel, of the transforms for one in the rows of the map,
  ! and of a plain one: pressures, gaps and the vectors of the method (derived; test: memory in
  ! test/contact/test_cost.py).
  real(real64), parameter :: bytes_padded = 4.0_real64, bytes_across = 12.0_real64, &
                             bytes_plain = 68.0_real64

contains

  !> Presses a map, to a level of the flat or to a load.
  recursive subroutine press_map(map, modulus, answer, load, tolerance, hardness)
    type(height_map), intent(in) :: map               !! at least one pixel measured
    real(real64), intent(in) :: modulus               !! combined modulus, more than 0
    type(map_answer), intent(inout) :: answer         !! level: given where there is no load
    real(real64), intent(in), optional :: load        !! normal load, more than 0
    !> Largest gap left over the heights; absent: `closed_fully`.
    real(real64), intent(in), optional :: tolerance
    !> Largest pressure of a perfectly plastic body, more than 0; absent: elastic. Surfaces may
    !> overlap where it is reached: the flat has then pressed them down by as much.
    real(real64), intent(in), optional :: hardness
    type(force_bounds) :: bounds
    real(real64), allocatable :: gap(:, :)
    real(real64) :: top, heights, unit

    call check_memory('the pixels of the map', answer%failure, bytes=room_to_press(map))
    if (allocated(answer%failure)) return
    if (allocated(answer%displacement)) deallocate (answer%displacement)
    top = maxval(map%height)
    heights = top - minval(map%height, mask=is_measured(map%height))
    if (.not. heights > 0.0_real64) heights = maxval(map%pixel_spacing)
    ! Heights of rounding alone must not make displacements reach the gap of missing pixels.
    if (present(load)) heights = max(heights, displacement_reach * epsilon(heights) * load / &
                                              (modulus * map%pixel_spacing(1)))
    if (.not. present(load)) then
      if (.not. answer%level < top) then
        answer%pressure = 0.0_real64 * map%height
        answer%displacement = answer%pressure
        answer%load = 0.0_real64
        answer%ending = solve_ending(converged=.true.)
        return
      end if
      if (.not. present(hardness)) &
        call check_level(map, answer%pressure, closed_fully * heights, answer)
      if (allocated(answer%failure)) return
      heights = min(heights, top - answer%level)
    end if
    ! Lengths across are over the side, heights over their range, pressures over that times modulus.
    unit = modulus * heights / map%pixel_spacing(1)
    allocate (gap, mold=map%height)
    where (map%height > 0.5_real64 * no_height)
      gap = (top - map%height) / heights
    else where
      gap = missing_gap
    end where
    if (.not. present(load)) gap = gap - (top - answer%level) / heights
    if (allocated(answer%pressure)) call move_start(top, answer, load)
    if (.not. allocated(answer%pressure)) then
      if (size(gap, kind=int64) >= worth_halving) then
        call start_from_half(map, modulus, answer, load, hardness)
        if (allocated(answer%failure)) return
      else
        answer%pressure = merge(unit, 0.0_real64, gap < 0.5_real64)
      end if
    end if
    bounds%tolerance = closed_fully
    if (present(tolerance)) bounds%tolerance = tolerance
    if (present(hardness)) bounds%limit = hardness / unit
    if (present(load)) bounds%load = load / (unit * product(map%pixel_spacing))
    call find_pressures(map, gap, bounds, unit, answer)
    if (present(hardness)) call reach_hardness(hardness, closed_fully * unit, answer%pressure)
    answer%displacement = answer%displacement * heights
    if (present(load)) then
      answer%level = top - heights * answer%level
      answer%load = load
    end if
    answer%solved_level = answer%level
    if (.not. (answer%ending%converged .or. allocated(answer%failure))) &
      answer%failure = 'the pressures on the map did not converge'
    if (allocated(answer%failure) .and. answer%interrupt%is_asked()) answer%failure = 'interrupted'
  end subroutine press_map

  !> Sets pressures that differ from the hardness by their error to the hardness.
  elemental subroutine reach_hardness(hardness, closing, pressure)
    real(real64), intent(in) :: hardness     !! largest pressure, > 0
    real(real64), intent(in) :: closing      !! pressure on a pixel that closes the residual gap
    real(real64), intent(inout) :: pressure  !! of a pixel

    if (.not. pressure < hardness - min(error_of_residual * closing, &
                                        hardness_rounding * hardness)) pressure = hardness
  end subroutine reach_hardness

  !> Sets the failure where an elastic map has no solution at the level of `answer`: the mean
  !> displacement of a periodic map is 0, but on a rigid base, so that its mean gap would be
  !> negative; at 0 it is in full contact at any load. Only surfaces that a load has brought into
  !> full contact stay in it, with their load, where that level is held. A flat that does not reach
  !> the map is above its mean.
  subroutine check_level(map, start, error, answer)
    type(height_map), intent(in) :: map                 !! at least one pixel measured
    real(real64), allocatable, intent(in) :: start(:, :)  !! contact pressures before, if any
    real(real64), intent(in) :: error                   !! of a level found [length], 0 or more
    type(map_answer), intent(inout) :: answer           !! level of the flat; gets the failure
    real(real64) :: lowered

    if (.not. (map%periodic .and. answer%level < maxval(map%height)) .or. &
        mean_displacement(map%bodies) > 0.0_real64) return
    lowered = 0.0_real64
    if (allocated(start)) then
      if (all(start > 0.0_real64 .or. .not. is_measured(map%height))) lowered = error
    end if
    if (.not. (answer%level + lowered) * count(is_measured(map%height), kind=int64) > &
        sum(map%height, mask=is_measured(map%height))) &
      answer%failure = 'the flat is not above the mean height of a map that repeats itself'
  end subroutine check_level

  ! Moves the pressures of the last state to a load, as a start: along the line from an earlier one,
  ! by at most twice its length. None are left far from it, where the flat begins to touch, or where
  ! the load changes by more than `far_load`, or the level by more than `far_level`. The solution is
  ! unique (`asperity_element_forces`): the start changes the number of steps alone.
  pure subroutine move_start(top, answer, load)
    real(real64), intent(in) :: top            ! of the map
    type(map_answer), intent(inout) :: answer  ! pressures, and their load if they are of a state
    real(real64), intent(in), optional :: load
    real(real32), allocatable :: pressure(:, :)
    real(real64) :: step, change
    logical :: is_far

    is_far = abs(answer%level - answer%solved_level) > far_level * (top - answer%level)
    if (present(load)) is_far = abs(load - answer%load) > far_load * load
    if (.not. any(answer%pressure > 0.0_real64) .or. answer%load > 0.0_real64 .and. is_far) &
      deallocate (answer%pressure)
    if (.not. (present(load) .and. allocated(answer%pressure) .and. answer%load > 0.0_real64)) &
      return
    change = load - answer%load
    allocate (pressure, source=real(answer%pressure, real32))
    if (allocated(answer%earlier)) then
      step = answer%load * (1.0_real64 - sum(real(answer%earlier, real64)) / sum(answer%pressure))
      if (2 * abs(step) > abs(change)) answer%pressure = &
        max(0.0_real64, answer%pressure + (change / step) * (answer%pressure - answer%earlier))
    end if
    call move_alloc(pressure, answer%earlier)
  end subroutine move_start

  ! Takes the pressures of the map at half its resolution, pressed in the same way, as a start.
  recursive subroutine start_from_half(map, modulus, answer, load, hardness)
    type(height_map), intent(in) :: map
    real(real64), intent(in) :: modulus
    type(map_answer), intent(inout) :: answer
    real(real64), intent(in), optional :: load, hardness
    type(height_map) :: half
    type(map_answer) :: start
    real(real64), allocatable :: load_of_half
    integer :: i

    half = half_map(map)
    start%level = answer%level
    start%interrupt = answer%interrupt
    if (present(load)) load_of_half = load
    if (present(load) .and. present(hardness)) load_of_half = min(load, most_load(half, hardness))
    call press_map(half, modulus, start, load_of_half, closed_start, hardness)
    if (allocated(start%failure)) then
      answer%failure = start%failure
      return
    end if
    answer%pressure = start%pressure([((i + 1) / 2, i=1, size(map%height, 1))], &
                                     [((i + 1) / 2, i=1, size(map%height, 2))])
    where (.not. is_measured(map%height)) answer%pressure = 0.0_real64
  end subroutine start_from_half

  ! Finds the pressures, and the load or the level (from the highest pixel, over the heights).
  subroutine find_pressures(map, gap, bounds, unit, answer)
    type(height_map), intent(in) :: map
    real(real64), intent(in) :: gap(:, :)        ! over the heights
    type(force_bounds), intent(in) :: bounds     ! pressures over `unit`
    real(real64), intent(in) :: unit
    type(map_answer), intent(inout) :: answer    ! pressures: start and result
    type(lattice_convolution) :: influence

    call prepare_influence(map, influence)
    answer%pressure = answer%pressure / unit
    if (bounds%load > 0.0_real64) then
      if (.not. sum(answer%pressure) > 0.0_real64) &
        answer%pressure = merge(1.0_real64, 0.0_real64, gap < 0.5_real64)
      answer%pressure = answer%pressure * (bounds%load / sum(answer%pressure))
      call find_forces(influence, gap, bounds, answer%pressure, answer%ending, answer%interrupt, &
                       answer%level, answer%displacement)
      ! Next to nothing is lost beside the gaps.
      if (.not. abs(sum(answer%pressure) - bounds%load) < load_met * bounds%load) answer%failure = &
        'the load is too small beside the modulus and the heights to be met on the pixels'
    else
      call find_forces(influence, gap, bounds, answer%pressure, answer%ending, answer%interrupt, &
                       displacement=answer%displacement)
      answer%load = sum(answer%pressure) * unit * product(map%pixel_spacing)
    end if
    answer%pressure = answer%pressure * unit
  end subroutine find_pressures

  !> Prepares the displacements, over the side of a pixel along x, by pressures over the modulus.
  subroutine prepare_influence(map, influence)
    type(height_map), intent(in) :: map                     !! map with its edges
    type(lattice_convolution), intent(inout) :: influence   !! convolution without plans
    real(real64), allocatable :: factor(:, :), table(:, :)
    integer :: i, j

    associate (gap => map%height, side_ratio => map%pixel_spacing(2) / map%pixel_spacing(1), &
               layered => any(map%bodies%thickness > 0.0_real64))
      if (map%periodic .and. layered) then
        allocate (factor(0:size(gap, 1) / 2, 0:size(gap, 2) / 2))
        do j = 0, ubound(factor, 2)
          do i = 0, ubound(factor, 1)
            factor(i, j) = layer_factor(map%bodies, 2.0_real64 * pi * norm2( &
                                        [i, j] / (map%pixel_spacing * shape(gap))))
          end do
        end do
        factor(0, 0) = mean_displacement(map%bodies) / map%pixel_spacing(1)
        call influence%prepare_periodic(size(gap, 1), size(gap, 2), side_ratio, factor)
      else if (map%periodic) then
        call influence%prepare_periodic(size(gap, 1), size(gap, 2), side_ratio)
      else if (map%strip_axis > 0) then
        ! Both halves of Love's integral.
        allocate (table, source=( &
          integral_over_element(of_xx, shape(gap), side_ratio, map%strip_axis) + &
          integral_over_element(of_yy, shape(gap), side_ratio, map%strip_axis)) / pi)
        call influence%prepare(table, side_ratio, map%strip_axis)
      else
        allocate (table, source=centre_influence(size(gap, 1), size(gap, 2), side_ratio))
        if (layered) call add_layers(map%bodies, map%pixel_spacing, table)
        call influence%prepare(table, side_ratio)
      end if
    end associate
  end subroutine prepare_influence

  !> Displacements of the pixels of a map by tractions on them; on a periodic map their mean is 0.
  function displacement_by(map, modulus, traction) result(displacement)
    type(height_map), intent(in) :: map              !! height map, periodic or free
    real(real64), intent(in) :: modulus              !! combined modulus, > 0
    real(real64), intent(in) :: traction(:, :)       !! traction of each pixel [pressure]
    real(real64), allocatable :: displacement(:, :)
    type(lattice_convolution) :: influence

    allocate (displacement, mold=traction)
    call prepare_influence(map, influence)
    call influence%apply(traction, displacement)
    displacement = displacement * (map%pixel_spacing(1) / modulus)
  end function displacement_by

  !> The largest load of a perfectly plastic map: the hardness on all measured pixels.
  pure real(real64) function most_load(map, hardness)
    type(height_map), intent(in) :: map    !! height map with at least one pixel measured
    real(real64), intent(in) :: hardness   !! hardness, largest pressure a body bears [pressure]

    most_load = hardness * product(map%pixel_spacing) * &
               count(is_measured(map%height), kind=int64)
  end function most_load

  !> Memory that `press_map` takes beside the map, bytes.
  pure integer(int64) function room_to_press(map) result(bytes)
    type(height_map), intent(in) :: map  !! height map, periodic or free
    real(real64) :: padded(2)

    padded = shape(map%height)
    where (.not. [map%repeats(1), map%repeats(2)]) padded = padded_length(2 * shape(map%height) - 1)
    bytes = nint(bytes_padded * product(padded) + bytes_across * padded(1) * &
                 size(map%height, 2) + bytes_plain * size(map%height, kind=int64), int64) + &
            bytes_of_plans
  end function room_to_press

  !> Memory of a solve of a map beside the map, bytes: that of `press_map`, the map of the sum, that
  !> of the state, and of a relaxing body its history.
  pure integer(int64) function room_to_solve(map, relaxations) result(bytes)
    type(height_map), intent(in) :: map  !! height map, periodic or free
    integer, intent(in) :: relaxations   !! relaxation times; 0: no creep
    ! Arrays of the map: both maps, and of creep (measured: 9 with one time; test: limits in
    ! test_outside_faults.py).
    integer, parameter :: arrays = 2, creep_arrays = 10

    bytes = room_to_press(map) + 8 * size(map%height, kind=int64) * &
            (arrays + merge(creep_arrays, 0, relaxations > 0) + 2 * relaxations)
  end function room_to_solve

  !> The map at half its resolution: of four pixels the mean of their mean and the highest, which
  !> presses most nearly as they do (measured; the mean alone is too low, the highest too high). A
  !> periodic map keeps its lengths: of an odd number of columns or rows the pixels of the half are
  !> a little less than twice as wide.
  pure type(height_map) function half_map(map) result(half)
    type(height_map), intent(in) :: map  !! any; a single row stays one
    real(real64) :: height((map%columns + 1) / 2, (map%rows + 1) / 2)
    integer :: i, j, n

    height = no_height
    do j = 1, size(height, 2)
      do i = 1, size(height, 1)
        associate (four => map%height(2 * i - 1:min(2 * i, size(map%height, 1)), &
                                      2 * j - 1:min(2 * j, size(map%height, 2))))
          n = count(is_measured(four))
          if (n > 0) height(i, j) = &
            0.5_real64 * (sum(four, mask=is_measured(four)) / n + maxval(four))
        end associate
      end do
    end do
    call take_heights(map, merge(2.0_real64, 1.0_real64, shape(map%height) > 1), height, half)
  end function half_map

end module asperity_map_contact
