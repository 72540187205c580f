!> Adhesion on the pixels of a height map: the surfaces attract each other across their gap.
!>
!> Problem: at a level of the flat, or under a load, find a stationary point of the energy
!>
!>     u.Ku/2 + sum of e(g) + load * level,   g = g0 + level + u >= 0,
!>
!> where u are the elastic displacements, K is the inverse of the matrix A of displacements and g0
!> is the undeformed gap. The attraction e'(g) = s(g) >= 0 does not increase with the gap, so that e
!> is concave. The net traction is t = p - s(g) with the contact pressure p >= 0, which is 0 where
!> g > 0. With a hardness H, p <= H + s(0): the limit holds for the net traction.
!>
!> Method: difference-of-convex algorithm (Tao and An, Acta Math. Vietnam. 22 (1997) 289;
!> concave-convex procedure, Yuille and Rangarajan, Neural Comput. 15 (2003) 915). The attraction of
!> the last gaps is a known traction: each step is the contact problem of `element_forces` with the
!> gaps g0 - A s and, under a load, the load + sum of s. The energy does not increase. Near the
!> solution the next s is extrapolated by the secant of the last two steps (Anderson, J. ACM 12
!> (1965) 547, with one earlier step, in the norm of A): onwards only, by a bounded change of the
!> gaps. As the attraction is convex, a secant falls short of the solution that loading leads to.
!>
!> Convergence: steps from exact solutions of their contact problems reduce the energy and converge
!> (Tao and An 1997). Extrapolated steps, predicted forces and loose tolerances save time, without a
!> proof. Where the attraction is nearly as steep as the solid is stiff, the changes of the gaps
!> decrease slowly, and an error of the contact problem of a small part of a change lets them
!> alternate: after `usual_steps` these problems are solved to less.
!>
!> Stop: the changes of the gaps decrease as a geometric series, whose remainder is the error. Its
!> ratio is that of the last two changes, as long as these are larger than the rounding error of
!> the displacements. As the energy falls the changes tend to 0, and so become as small; then they
!> have no ratio (in full contact two of 1e-16 may be equal), and the state is a fixed point of the
!> steps to all digits of the displacements.
!>
!> History: a half-space has no negative stiffness between two pixels, so that from open surfaces
!> the steps lead to the stationary point with the largest gaps, and on unloading to the one with
!> the least gaps above those of the earlier state (monotone iteration, Amann, SIAM Rev. 18 (1976)
!> 620; no passing, Middleton, Phys. Rev. Lett. 68 (1992) 670). The state depends on the turning
!> points of the path, not on the number of its states. This does not hold on a periodic map at a
!> prescribed level, where the mean gap is constant and pixels repel each other.
!>
!> Exits: solved; `is_separated`, where the load is more tensile than the surfaces carry; `failure`.
module asperity_map_adhesion
  use asperity_attraction_law, only: attraction_at, attraction_law, share_of_work
  use asperity_element_forces, only: displacement_error, find_forces, force_bounds, missing_gap
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: int64, real64
  use asperity_lattice_convolution, only: lattice_convolution
  use asperity_map_contact, only: check_level, map_answer, prepare_influence, press_map, &
                                  reach_hardness, room_to_press
  use asperity_process, only: check_memory
  implicit none
  private

  public :: adhere_map, adhesion_history, find_pull_off, work_at_edge

  !> State of the surfaces that the next state starts from; not allocated: open.
  type :: adhesion_history
    real(real64), allocatable :: contact_pressure(:, :)  !! p [pressure], 0 or more
    real(real64), allocatable :: attraction(:, :)        !! s [pressure], 0 or more
    logical :: is_separated = .false.                    !! the load was not carried
  end type adhesion_history

  ! The step before, from which the next one is extrapolated.
  type :: earlier_step
    !> attraction s(g) that it found, A times it; change of s to it; forces of its contact problem
    real(real64), allocatable, dimension(:, :) :: found, image, change, force
    real(real64) :: square = 0.0_real64      ! change times A change
    real(real64) :: gap_change = 0.0_real64  ! largest change of a gap
    real(real64) :: total = 0.0_real64       ! sum of the change of s that was taken
    real(real64) :: remainder = 0.0_real64   ! estimated error of s over its change by a step
  end type earlier_step

  ! Estimated error of the gaps over the range of the attraction (chosen; test: states of one and
  ! of eight steps in test/maps/test_adhesive_pixels.py).
  real(real64), parameter :: gap_error = 1.0e-8_real64
  ! Tolerance of a contact problem over the last change of the gaps: 0.3 stagnates, 0.03 needs no
  ! more steps than 0.01 up to a Tabor parameter of 2 (measured).
  real(real64), parameter :: share_of_change = 0.03_real64
  ! Tolerance of the first contact problem over the range of the attraction, and of the start over
  ! the range of heights (chosen).
  real(real64), parameter :: first_tolerance = 1.0e-2_real64, start_tolerance = 1.0e-3_real64
  ! Error of displacements by rounding over the largest one (derived: see element_forces).
  real(real64), parameter :: rounding = 1.0e-11_real64
  ! Largest change of gaps with an extrapolation over the range of the attraction (chosen; no test
  ! fails without it).
  real(real64), parameter :: largest_extrapolation = 0.1_real64
  ! Largest number of contact problems for a state (chosen: near the largest tensile load it grows
  ! without bound).
  integer, parameter :: steps_allowed = 3000
  ! Number of steps after which contact problems are solved to `exact_share` of the last change of
  ! the gaps (chosen: most states need fewer steps, and those at a steepness of 0.9 to 1.2 about
  ! 150; test: steep attraction in test/maps/test_adhesive_pixels.py).
  integer, parameter :: usual_steps = 50
  ! The same (chosen: a tenth of `share_of_change`).
  real(real64), parameter :: exact_share = 0.1_real64 * share_of_change
  ! Relative error of the largest tensile load (chosen).
  real(real64), parameter :: pull_off_error = 1.0e-4_real64
  ! Number of bisections (chosen: a load relative to its rounding).
  integer, parameter :: most_bisections = 60

contains

  !> Solves a state of a map with adhesion from an earlier state.
  recursive subroutine adhere_map(map, modulus, law, history, answer, load, hardness, tolerance)
    type(height_map), intent(in) :: map               !! at least one pixel measured
    real(real64), intent(in) :: modulus               !! combined modulus, > 0
    type(attraction_law), intent(in) :: law           !! attraction, its work > 0
    type(adhesion_history), intent(inout) :: history  !! earlier state; becomes this state
    !> level: given where there is no load; gets net tractions, displacements, load and level
    type(map_answer), intent(inout) :: answer
    real(real64), intent(in), optional :: load        !! normal load, below 0: tensile
    real(real64), intent(in), optional :: hardness    !! largest net traction; absent: elastic
    !> error of the gaps over the range of the attraction; absent: `gap_error`
    real(real64), intent(in), optional :: tolerance
    type(lattice_convolution) :: influence
    type(force_bounds) :: bounds
    type(earlier_step) :: last
    real(real64), allocatable, dimension(:, :) :: force, gap, moved, next, pull, pulled, &
                                                  displacement
    real(real64) :: allowed, change, error, level, noise, pixels, top, unit
    integer :: steps
    logical :: is_solved

    call start_history(map, modulus, law, history, answer, load, hardness)
    if (allocated(answer%failure)) return
    allowed = gap_error
    if (present(tolerance)) allowed = tolerance
    top = merge(maxval(map%height), answer%level, present(load))
    ! Lengths across are over the side, gaps over the range, tractions over `unit`.
    unit = modulus * law%reach / map%pixel_spacing(1)
    call prepare_influence(map, influence)
    allocate (gap(map%columns, map%rows), source=missing_gap)
    where (is_measured(map%height)) gap = (top - map%height) / law%reach
    force = history%contact_pressure / unit
    pull = history%attraction / unit
    allocate (pulled, moved, next, mold=gap)
    call influence%apply(pull, pulled)
    bounds%tolerance = first_tolerance
    if (present(hardness)) bounds%limit = (hardness + attraction_at(law, 0.0_real64)) / unit
    level = 0.0_real64
    pixels = real(size(gap, kind=int64), real64)
    is_solved = .false.
    do steps = 1, steps_allowed
      if (present(load)) then
        bounds%load = load / (unit * product(map%pixel_spacing)) + sum(pull)
        history%is_separated = .not. bounds%load > 0.0_real64
        if (history%is_separated) return
        call scale_forces(gap - pulled, bounds%load, force)
      end if
      call find_forces(influence, gap - pulled, bounds, force, answer%ending, answer%interrupt, &
                       level, displacement)
      if (.not. answer%ending%converged) exit
      if (.not. present(load)) level = 0.0_real64
      displacement = displacement - pulled
      next = merge(attraction_at(law, law%reach * (gap + displacement - level)) / unit, &
                   0.0_real64, is_measured(map%height))
      call influence%apply(next, moved)
      moved = moved - pulled
      change = maxval(abs(moved - merge(sum(moved) / pixels, 0.0_real64, present(load))))
      noise = displacement_error(influence%norm, sum(next**2) / pixels, maxval(abs(pulled + moved)))
      call extrapolate_step(pull, pulled, change, last, next, moved, error)
      if (change <= noise) error = 0.0_real64
      is_solved = max(error, bounds%tolerance) <= &
                  max(allowed, rounding * maxval(abs(displacement)))
      if (is_solved) exit
      call predict_forces(sum(next - pull), bounds%limit, last, force)
      pull = next
      pulled = pulled + moved
      bounds%tolerance = max(0.1_real64 * allowed, share_of_change * min(change, 1.0_real64))
      if (steps > usual_steps) bounds%tolerance = exact_share * min(change, 1.0_real64)
    end do
    answer%ending%iterations = steps
    if (.not. is_solved) answer%failure = 'the tractions with adhesion on the map did not converge'
    if (.not. is_solved .and. answer%interrupt%is_asked()) answer%failure = 'interrupted'
    if (.not. is_solved) return
    history%contact_pressure = force * unit
    history%attraction = pull * unit
    answer%displacement = displacement * law%reach
    if (present(load)) answer%level = top - law%reach * level
    call take_pressures(history, allowed * unit, product(map%pixel_spacing), answer, load, hardness)
  end subroutine adhere_map

  ! Takes net pressures and their load from a solution.
  subroutine take_pressures(history, closing, area, answer, load, hardness)
    type(adhesion_history), intent(in) :: history  ! pressures of contact and attraction
    real(real64), intent(in) :: closing            ! pressure on a pixel for the residual gap
    real(real64), intent(in) :: area               ! of a pixel
    type(map_answer), intent(inout) :: answer      ! gets pressures, contact and load
    real(real64), intent(in), optional :: load, hardness  ! as in adhere_map

    answer%pressure = history%contact_pressure - history%attraction
    if (present(hardness)) call reach_hardness(hardness, closing, answer%pressure)
    answer%touches = history%contact_pressure > 0.0_real64
    answer%load = sum(answer%pressure) * area
    if (present(load)) answer%load = load
  end subroutine take_pressures

  ! Extrapolates a step of the attraction by that before, where the residual of the secant is least,
  ! and estimates the error of the gaps before it.
  subroutine extrapolate_step(pull, pulled, gap_change, last, next, moved, error)
    real(real64), intent(in) :: pull(:, :), pulled(:, :)    ! s, A s
    real(real64), intent(in) :: gap_change                  ! largest change of a gap by the step
    type(earlier_step), intent(inout) :: last               ! step before; becomes this one
    real(real64), intent(inout) :: next(:, :), moved(:, :)  ! s by the step, A times its change
    real(real64), intent(out) :: error                      ! of a gap
    real(real64), allocatable, dimension(:, :) :: change, found, image
    real(real64) :: both, now, share

    allocate (found, source=next)
    allocate (change, source=next - pull)
    allocate (image, source=pulled + moved)
    now = sum(change * moved)
    share = 0.0_real64
    error = gap_change
    if (allocated(last%change)) then
      ! The changes decrease as a geometric series: the error is its remainder.
      if (gap_change > 0.0_real64) &
        error = gap_change / max(last%gap_change / gap_change - 1.0_real64, rounding)
      both = sum(last%change * moved)
      if (both > now .and. last%square - both > both - now) &
        share = (both - now) / (last%square - 2.0_real64 * both + now)
      if ((1.0_real64 + share) * gap_change > largest_extrapolation) share = 0.0_real64
      if (share > 0.0_real64) then
        if (any(next + share * (next - last%found) < 0.0_real64)) share = 0.0_real64
      end if
      if (share > 0.0_real64) then
        next = next + share * (next - last%found)
        moved = moved + share * (image - last%image)
      end if
    end if
    last%remainder = max(0.5_real64 * last%remainder, merge(1.0_real64 + share, 0.0_real64, &
                                                            share > 0.0_real64))
    error = max(error, last%remainder * gap_change)
    last%square = now
    last%gap_change = gap_change
    call move_alloc(found, last%found)
    call move_alloc(change, last%change)
    call move_alloc(image, last%image)
  end subroutine extrapolate_step

  ! Predicts the forces of the next contact problem: they change in proportion to the attraction.
  subroutine predict_forces(total, limit, last, force)
    real(real64), intent(in) :: total              ! sum of the change of s
    real(real64), intent(in) :: limit              ! largest force
    type(earlier_step), intent(inout) :: last      ! gets these forces and the sum
    real(real64), allocatable, intent(inout) :: force(:, :)  ! forces of this problem, of the next
    real(real64), allocatable :: found(:, :)
    real(real64) :: ratio

    allocate (found, source=force)
    ratio = 0.0_real64
    if (abs(last%total) > 0.0_real64) &
      ratio = min(1.0_real64, max(0.0_real64, total / last%total))
    if (ratio > 0.0_real64) &
      force = min(limit, max(0.0_real64, force + ratio * (force - last%force)))
    last%total = total
    call move_alloc(found, last%force)
  end subroutine predict_forces

  ! Scales forces to a sum; where there are none, lowest gaps get them.
  subroutine scale_forces(gap, total, force)
    real(real64), intent(in) :: gap(:, :), total
    real(real64), intent(inout) :: force(:, :)

    if (.not. sum(force) > 0.0_real64) &
      force = merge(1.0_real64, 0.0_real64, gap < minval(gap) + 1.0_real64)
    force = force * (total / sum(force))
  end subroutine scale_forces

  ! Opens the surfaces where there is no earlier state. The start is the state without attraction,
  ! or under a tensile load the state with attraction at first touch.
  recursive subroutine start_history(map, modulus, law, history, answer, load, hardness)
    type(height_map), intent(in) :: map
    real(real64), intent(in) :: modulus
    type(attraction_law), intent(in) :: law
    type(adhesion_history), intent(inout) :: history
    type(map_answer), intent(inout) :: answer
    real(real64), intent(in), optional :: load, hardness

    history%is_separated = .false.
    if (.not. (present(load) .or. present(hardness))) &
      call check_level(map, history%contact_pressure, gap_error * law%reach, answer)
    if (allocated(answer%failure)) return
    call check_memory('the pixels of the map', answer%failure, bytes=2 * room_to_press(map))
    if (allocated(history%attraction) .or. allocated(answer%failure)) return
    if (present(load)) then
      if (.not. load > 0.0_real64) then
        answer%level = maxval(map%height)
        call adhere_map(map, modulus, law, history, answer, hardness=hardness)
        return
      end if
    end if
    call press_map(map, modulus, answer, load, start_tolerance, hardness)
    if (.not. allocated(answer%pressure)) return
    history%contact_pressure = answer%pressure
    history%attraction = 0.0_real64 * answer%pressure
  end subroutine start_history

  !> Finds the largest tensile load that the surfaces carry, by bisection between a load that they
  !> carry and one that they do not. By the history (see above) each state that carries a load may
  !> be the start of the next.
  subroutine find_pull_off(map, modulus, law, history, answer, carried, beyond, hardness)
    type(height_map), intent(in) :: map               !! at least one pixel measured
    real(real64), intent(in) :: modulus               !! combined modulus, > 0
    type(attraction_law), intent(in) :: law           !! attraction, its work > 0
    type(adhesion_history), intent(inout) :: history  !! state under the load carried
    type(map_answer), intent(inout) :: answer         !! gets the state under the load found
    real(real64), intent(inout) :: carried            !! load carried, then the least one
    real(real64), intent(in) :: beyond                !! load below it that is not carried
    real(real64), intent(in), optional :: hardness    !! largest net traction; absent: elastic
    type(adhesion_history) :: trial
    real(real64) :: high, low, middle
    integer :: cut

    low = beyond
    high = carried
    do cut = 1, most_bisections
      if (high - low <= pull_off_error * abs(high)) exit
      middle = high + 0.5_real64 * (low - high)
      trial = history
      call adhere_map(map, modulus, law, trial, answer, middle, hardness)
      if (answer%interrupt%is_asked()) return
      if (trial%is_separated .or. allocated(answer%failure)) then
        if (allocated(answer%failure)) deallocate (answer%failure)
        low = middle
      else
        history = trial
        high = middle
      end if
    end do
    carried = high
  end subroutine find_pull_off

  !> Share of the work of adhesion in the gap at the free edges of a hill: the mean over the first
  !> and last pixels of its rows and columns. By Derjaguin's approximation it is the share of the
  !> largest pull of a ball that the map cuts off. 0 without free edges, and where edges are not
  !> lower than the map by its standard deviation: a map of many hills is a sample of its surface,
  !> whose attraction is that per area. A paraboloid has 1.6 deviations on a square, 1.7 on a disc.
  real(real64) function work_at_edge(map, law, attraction) result(share)
    type(height_map), intent(in) :: map            !! at least one pixel measured
    type(attraction_law), intent(in) :: law        !! attraction of the surfaces
    real(real64), intent(in) :: attraction(:, :)   !! attraction of each pixel [pressure]
    logical, dimension(map%columns, map%rows) :: at_edge, measured
    real(real64) :: above(map%columns, map%rows)  ! the mean height
    integer(int64) :: number
    integer :: i, j, last

    share = 0.0_real64
    at_edge = .false.
    measured = is_measured(map%height)
    do last = 1, 2
      do j = 1, merge(0, map%rows, map%repeats(1))
        i = findloc(measured(:, j), .true., 1, back=last == 2)
        if (i > 0) at_edge(i, j) = .true.
      end do
      do i = 1, merge(0, map%columns, map%repeats(2))
        j = findloc(measured(i, :), .true., 1, back=last == 2)
        if (j > 0) at_edge(i, j) = .true.
      end do
    end do
    if (.not. any(at_edge)) return
    above = merge(map%height, 0.0_real64, measured)
    number = count(measured, kind=int64)
    above = merge(above - sum(above) / number, 0.0_real64, measured)
    if (-sum(above, at_edge) > count(at_edge) * sqrt(sum(above**2) / number)) &
      share = sum(share_of_work(law, attraction), at_edge) / count(at_edge)
  end function work_at_edge

end module asperity_map_adhesion
