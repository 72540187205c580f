!> Contacts that share a half-space, coupled: loads and shifts that make one potential stationary.
!>
!> For contact i: p_i = closing - gap_i - h_i - u_i, with u_i the displacement by its neighbours as
!> i feels it and h_i = s_i**2/(2 R_i) for its shift s_i = -R_i times their slope (see
!> circle_field). Newton's method on the contacts that carry load; between its steps contacts open
!> and others join. Where a load is asked for, every state on the way carries it: all penetrations
!> are raised alike until it does, and the closing follows.
!>
!> A step is cut until the slope of the potential along it has fallen, in size, to a share of what
!> it was at the start.
module asperity_coupled_contacts
  use asperity_circle_field, only: circle_set, find_field, inclination, many, &
                                   plant_circles
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs, in_scene_units
  use asperity_coupled_open, only: look_around, open_places, stands_out
  use asperity_coupled_step, only: newton_step
  use asperity_kinds, only: real64
  use asperity_problems, only: real_text
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: adopt, coupled_solution, resolved_contacts, solve_coupled

  !> Contacts that are solved elsewhere: their answer to what is around them, by pair of all.
  type :: resolved_contacts
    logical, allocatable :: is_one(:)       !! this pair is
    real(real64), allocatable :: x(:), y(:) !! centre of its pressure
    !> that makes its law answer with its load; huge: open. Of others: their own, with what they
    !> feel of pressures that are not those of circles
    real(real64), allocatable :: gap(:)
  end type resolved_contacts

  !> Coupled contacts, by pair.
  type :: coupled_solution
    real(real64) :: closing = 0.0_real64            !! past first touch of all
    real(real64), allocatable :: penetration(:)     !! not positive where open
    real(real64), allocatable :: move_x(:), move_y(:)  !! shifts
    type(circle_set) :: set                         !! those that carry load, with their field
    type(solve_ending) :: ending                    !! residual over the largest penetration
    integer :: products = 0                         !! of the matrix, in all steps
    integer :: fields = 0                           !! found in all steps
    character(len=:), allocatable :: failure        !! why there is none
  end type coupled_solution

  ! What the solver carries from step to step.
  type :: solve_state
    integer, allocatable :: order(:)                ! candidates: pairs that may touch, by place
    real(real64), allocatable :: gap(:)             ! of every pair
    real(real64), allocatable :: along(:)           ! the step's change of p, by pair
    real(real64), allocatable :: off(:)             ! gradient by load, by circle
    real(real64), allocatable :: off_x(:), off_y(:) ! gradient by shift over load, by circle
    real(real64) :: target = -1.0_real64            ! load over modulus; below 0: not asked
    real(real64) :: residual = 0.0_real64
    integer, allocatable :: joins(:)                ! how often a pair has joined
    logical, allocatable :: is_new(:)               ! joined since the last look, or at the start
  end type solve_state

  ! Residuals: asked for; accepted where rounding allows no less.
  real(real64), parameter :: asked = 1.0e-11_real64, accepted = 1.0e-9_real64
  integer, parameter :: most_iterations = 200, most_trials = 12
  ! A step is taken when the slope of the potential has fallen to this share in size.
  real(real64), parameter :: slope_left = 0.8_real64
  ! Shares of the gradient that a step may leave. Of many contacts less would cost more products
  ! than it saves steps; of few the last step is as good as rounding lets it be.
  real(real64), parameter :: most_left = 0.1_real64, least_left = 0.01_real64
  ! Open contacts are looked at again when the residual has fallen to this share.
  real(real64), parameter :: look_again = 0.1_real64
  ! A circle that has grown by this factor, or shrunk as much, has other near neighbours.
  real(real64), parameter :: outgrown = 1.2_real64
  integer, parameter :: most_looks = 4
  ! A contact that joins once more begins with this share of its penetration.
  real(real64), parameter :: share_of_rejoined = 0.25_real64
  ! Of two that begin together the one that stands out of the other by less than this share of its
  ! penetration waits: contacts nearer than that have several solutions, and that with the deepest
  ! alone in its place has the least potential.
  real(real64), parameter :: out_at_start = 0.2_real64
  ! Deepest penetrations by which what is hidden stays open: no step raises all by so much.
  real(real64), parameter :: out_of_reach = 10.0_real64
  ! A penetration stays below this share of the height between centres.
  real(real64), parameter :: level = 0.999999_real64

contains

  !> Solves at a given closing, or, where `target` is present, at a sum of the normal loads, or of
  !> the vertical ones, as the pairs have it.
  subroutine solve_coupled(pairs, law, solution, target, resolved)
    type(contact_pairs), intent(in) :: pairs           !! those that may touch, ascending gap
    class(contact_law), intent(in) :: law              !! of each contact
    !> closing: given, or found where there is a target; penetrations and shifts: a start when
    !> allocated
    type(coupled_solution), intent(inout) :: solution
    real(real64), intent(in), optional :: target       !! more than 0
    type(resolved_contacts), intent(in), optional :: resolved
    type(solve_state) :: state
    real(real64) :: looked, before
    integer :: iteration, joined
    logical :: done

    call prepare(pairs, law, solution, state, target, resolved)
    if (allocated(solution%failure)) return
    call evaluate(pairs, law, solution, state, resolved)
    call open_hidden(pairs, law, solution, state, resolved)
    looked = 1.0_real64
    before = huge(before)
    joined = 0
    do iteration = 0, most_iterations
      if (allocated(solution%failure)) return
      ! Or as small as rounding lets it be: it falls no more.
      done = state%residual <= asked .or. &
             (state%residual <= accepted .and. state%residual > 0.5_real64 * before)
      before = state%residual
      ! Pairs that were not listed may touch: whoever asked must come again with all.
      if (solution%closing > pairs%complete_to .and. state%residual < look_again) exit
      if (done .or. state%residual <= look_again * looked) then
        call look(pairs, law, solution, state, resolved, joined)
        looked = state%residual
        if (allocated(solution%failure)) return
        if (done .and. joined == 0) exit
        if (joined > 0) then
          call evaluate(pairs, law, solution, state, resolved)
          call open_hidden(pairs, law, solution, state, resolved)
        end if
      end if
      call take_step(pairs, law, solution, state, resolved)
      solution%ending%iterations = iteration + 1
    end do
    solution%ending%residual = state%residual
    solution%ending%converged = state%residual <= accepted .and. joined == 0
    if (solution%closing > pairs%complete_to) solution%ending%converged = .true.
    if (.not. present(target)) return
    before = load_borne(pairs, law, solution)
    if (.not. before >= (1.0_real64 - accepted) * target) solution%failure = &
      'the load is more than the surfaces can bear before the centres of two asperities are ' // &
      'level: ' // real_text(in_scene_units(pairs, before, 1, 2)) // ' at most'
  end subroutine solve_coupled

  ! Sum of the loads along the normals, or of the vertical ones.
  real(real64) function load_borne(pairs, law, solution) result(total)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(coupled_solution), intent(in) :: solution
    type(contact_response) :: answer
    integer :: k

    total = 0.0_real64
    do k = 1, size(solution%set%number)
      associate (i => solution%set%number(k))
        call law%respond(pairs%list(i), i, min(solution%penetration(i), &
                                               level * pairs%list(i)%zc), answer)
      end associate
      total = total + merge(answer%vertical_load, answer%load, pairs%vertical)
    end do
  end function load_borne

  !> Takes the penetrations as they are: finds their circles and field, and the gaps of resolved
  !> contacts with which the equations hold for them.
  subroutine adopt(pairs, law, solution, resolved)
    type(contact_pairs), intent(in) :: pairs               !! the position
    class(contact_law), intent(in) :: law                  !! of each contact
    type(coupled_solution), intent(inout) :: solution      !! all but its circles is set
    type(resolved_contacts), intent(inout) :: resolved     !! gets its gaps
    type(solve_state) :: state
    integer :: i, k

    allocate (state%joins(0))
    state%gap = pairs%list%gap
    state%order = [(i, i=1, size(pairs%list))]
    call evaluate(pairs, law, solution, state, resolved)
    where (resolved%is_one) resolved%gap = huge(1.0_real64)
    do k = 1, size(solution%set%number)
      i = solution%set%number(k)
      if (resolved%is_one(i)) resolved%gap(i) = solution%closing - solution%set%lift(k) - &
                                                solution%penetration(i)
    end do
  end subroutine adopt

  ! A start: contacts alone, at a load or at the closing less a mean displacement.
  subroutine prepare(pairs, law, solution, state, target, resolved)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(coupled_solution), intent(inout) :: solution
    type(solve_state), intent(out) :: state
    real(real64), intent(in), optional :: target
    type(resolved_contacts), intent(in), optional :: resolved
    integer :: i, n

    n = size(pairs%list)
    solution%ending = solve_ending()
    state%gap = pairs%list%gap
    if (present(resolved)) state%gap = resolved%gap
    state%order = [(i, i=1, n)]
    allocate (state%joins(n), source=0)
    allocate (state%is_new(n), source=.not. allocated(solution%penetration))
    if (.not. allocated(solution%penetration)) then
      solution%penetration = solution%closing - state%gap
      allocate (solution%move_x(n), source=0.0_real64)
      allocate (solution%move_y(n), source=0.0_real64)
      if (present(target)) solution%penetration = -state%gap
    end if
    if (present(target)) then
      state%target = target / pairs%modulus
      call raise(pairs, law, solution, state)
    end if
  end subroutine prepare

  ! Raises all penetrations alike until the contacts carry the target.
  subroutine raise(pairs, law, solution, state)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(coupled_solution), intent(inout) :: solution
    type(solve_state), intent(in) :: state
    real(real64) :: low, high, by, total, slope, most, before
    integer :: k, i, try

    ! No more than until the first centres are level.
    most = minval(level * pairs%list%zc - solution%penetration)
    low = -maxval(solution%penetration)
    high = most
    by = min(max(0.0_real64, low), most)
    before = by
    do try = 1, 200
      call total_at(by, total, slope)
      if (abs(total - state%target) <= 1.0e-13_real64 * state%target) exit
      if (total < state%target) then
        low = by
      else
        high = by
      end if
      if (.not. high - low > epsilon(high) * max(abs(low), abs(high))) exit
      before = by
      by = 0.5_real64 * (low + high)
      ! Newton's method on load**(2/3), nearly straight.
      if (total > 0.0_real64 .and. slope > 0.0_real64) &
        by = before + 1.5_real64 * total / slope * &
             ((state%target / total)**(2.0_real64 / 3.0_real64) - 1.0_real64)
      if (by <= low .or. by >= high) then
        by = 0.5_real64 * (low + high)
        if (high >= most .and. total < state%target) by = max(by, most - 0.1_real64 * (most - low))
      end if
    end do
    do k = 1, size(state%order)
      i = state%order(k)
      solution%penetration(i) = solution%penetration(i) + by
    end do

  contains

    subroutine total_at(by, total, slope)
      real(real64), intent(in) :: by
      real(real64), intent(out) :: total, slope
      type(contact_response) :: response

      total = 0.0_real64
      slope = 0.0_real64
      do k = 1, size(state%order)
        i = state%order(k)
        if (.not. solution%penetration(i) + by > 0.0_real64) cycle
        call law%respond(pairs%list(i), i, solution%penetration(i) + by, response)
        total = total + merge(response%vertical_load, response%load, pairs%vertical)
        slope = slope + response%stiffness / merge(1.0_real64, response%cosine, pairs%vertical)
      end do
      total = total / pairs%modulus
      slope = slope / pairs%modulus
    end subroutine total_at

  end subroutine raise

  ! The circles of the present penetrations, their field, and what the equations leave over.
  subroutine evaluate(pairs, law, solution, state, resolved)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(coupled_solution), intent(inout) :: solution
    type(solve_state), intent(inout) :: state
    type(resolved_contacts), intent(in), optional :: resolved
    real(real64) :: deepest, aside
    integer :: i, k
    logical :: same

    call gather(pairs, law, solution, state, resolved, same)
    associate (set => solution%set)
      if (size(set%x) == 0) then
        state%residual = 0.0_real64
        return
      end if
      if (same) same = all(set%circle < outgrown * set%planted .and. &
                           set%planted < outgrown * set%circle)
      if (.not. same) call plant_circles(set)
      if (allocated(set%tree%failure)) then
        solution%failure = set%tree%failure
        return
      end if
      call find_field(set)
      solution%fields = solution%fields + 1
      deepest = 0.0_real64
      do k = 1, size(set%x)
        i = set%number(k)
        deepest = max(deepest, solution%penetration(i))
        state%off(k) = solution%penetration(i) + state%gap(i) + set%lift(k) + &
                       0.5_real64 * set%curvature(k) * (set%move_x(k)**2 + set%move_y(k)**2)
        state%off_x(k) = set%curvature(k) * set%move_x(k) + set%tilt_x(k)
        state%off_y(k) = set%curvature(k) * set%move_y(k) + set%tilt_y(k)
        if (set%still(k)) then
          state%off_x(k) = 0.0_real64
          state%off_y(k) = 0.0_real64
        end if
      end do
      if (state%target > 0.0_real64) &
        solution%closing = dot_product(set%stiffness, state%off) / sum(set%stiffness)
      state%residual = 0.0_real64
      do k = 1, size(set%x)
        state%off(k) = state%off(k) - solution%closing
        ! A shift that is off changes the penetration by no more than this times the slopes.
        aside = 0.0_real64
        if (.not. set%still(k)) aside = hypot(state%off_x(k), state%off_y(k)) / set%curvature(k) * &
                                        (hypot(set%tilt_x(k), set%tilt_y(k)) + &
                                         set%curvature(k) * hypot(set%move_x(k), set%move_y(k)))
        state%residual = max(state%residual, abs(state%off(k)), aside)
      end do
      state%residual = state%residual / deepest
    end associate
  end subroutine evaluate

  ! Of those that begin together opens the ones that are as good as hidden in another; the next look
  ! finds where beside it they touch, if they do.
  subroutine open_hidden(pairs, law, solution, state, resolved)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(coupled_solution), intent(inout) :: solution
    type(solve_state), intent(inout) :: state
    type(resolved_contacts), intent(in), optional :: resolved
    logical, allocatable :: opens(:)
    real(real64) :: over, under
    integer :: i, j, k

    if (allocated(solution%failure) .or. .not. any(state%is_new)) return
    if (size(solution%set%x) == 0) return
    associate (set => solution%set, p => solution%penetration)
      allocate (opens(size(set%x)), source=.false.)
      do k = 1, size(set%one)
        i = set%one(k)
        j = set%other(k)
        if (opens(i) .or. opens(j) .or. set%still(i) .or. set%still(j)) cycle
        if (.not. (state%is_new(set%number(i)) .and. state%is_new(set%number(j)))) cycle
        ! The one that stands out less waits; of equals the one listed last.
        over = out_of(host=i, one=j)
        under = out_of(host=j, one=i)
        opens(j) = over <= out_at_start .and. .not. under < over
        opens(i) = under <= out_at_start .and. .not. opens(j)
      end do
      state%is_new = .false.
      if (.not. any(opens)) return
      p(pack(set%number, opens)) = -out_of_reach * maxval(p(set%number))
    end associate
    if (state%target > 0.0_real64) call raise(pairs, law, solution, state)
    call evaluate(pairs, law, solution, state, resolved)

  contains

    real(real64) function out_of(host, one)
      integer, intent(in) :: host, one

      associate (set => solution%set)
        out_of = stands_out(state%gap(set%number(one)), set%x(one), set%y(one), &
                            set%curvature(one), state%gap(set%number(host)), set%x(host), &
                            set%y(host), set%curvature(host), set%circle(host), &
                            set%move_x(host), set%move_y(host))
      end associate
    end function out_of

  end subroutine open_hidden

  ! Sets out the circles of those that carry load.
  subroutine gather(pairs, law, solution, state, resolved, same)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(coupled_solution), intent(inout) :: solution
    type(solve_state), intent(inout) :: state
    type(resolved_contacts), intent(in), optional :: resolved
    logical, intent(out) :: same  ! the same contacts as before
    type(contact_response), allocatable :: answer(:)
    integer, allocatable :: number(:)
    real(real64) :: inclined, place(2)
    integer :: i, k, n

    allocate (answer(size(state%order)), number(size(state%order)))
    !$omp parallel do schedule(static) private(i) if(size(state%order) > many)
    do k = 1, size(state%order)
      i = state%order(k)
      if (.not. solution%penetration(i) > 0.0_real64) cycle
      call law%respond(pairs%list(i), i, &
                       min(solution%penetration(i), level * pairs%list(i)%zc), answer(k))
    end do
    !$omp end parallel do
    n = 0
    do k = 1, size(state%order)
      if (.not. answer(k)%vertical_load > 0.0_real64) cycle
      n = n + 1
      number(n) = state%order(k)
      answer(n) = answer(k)
    end do
    associate (set => solution%set)
      same = .false.
      if (allocated(set%number)) then
        if (size(set%number) == n) same = all(set%number == number(:n))
      end if
      if (.not. same) call set%make_room(n)
      if (allocated(state%off)) deallocate (state%off, state%off_x, state%off_y)
      allocate (state%off(n), state%off_x(n), state%off_y(n))
      set%number = number(:n)
      do k = 1, n
        i = number(k)
        place = [pairs%list(i)%x, pairs%list(i)%y]
        set%still(k) = .false.
        if (present(resolved)) set%still(k) = resolved%is_one(i)
        if (set%still(k)) place = [resolved%x(i), resolved%y(i)]
        ! Whoever stands elsewhere is to be planted there.
        if (any(abs(place - [set%x(k), set%y(k)]) > 0.0_real64)) same = .false.
        set%x(k) = place(1)
        set%y(k) = place(2)
        set%curvature(k) = 1.0_real64 / pairs%list(i)%radius
        set%move_x(k) = solution%move_x(i)
        set%move_y(k) = solution%move_y(i)
        if (set%still(k)) then
          set%curvature(k) = 0.0_real64
          set%move_x(k) = 0.0_real64
          set%move_y(k) = 0.0_real64
        end if
        inclined = inclination(answer(k)%cosine) / pairs%modulus
        set%load(k) = answer(k)%vertical_load * inclined
        set%stiffness(k) = answer(k)%stiffness * inclined
        set%circle(k) = answer(k)%contact_radius
      end do
    end associate
  end subroutine gather

  ! One step of Newton's method, cut until it helps.
  subroutine take_step(pairs, law, solution, state, resolved)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(coupled_solution), intent(inout) :: solution
    type(solve_state), intent(inout) :: state
    type(resolved_contacts), intent(in), optional :: resolved
    real(real64), allocatable :: gradient(:, :), step(:, :), dp(:), dx(:), dy(:), p(:), x(:), y(:)
    real(real64) :: left, slope, slope_first, slope_low, slope_high, low, high, t
    integer :: k, n, trial

    n = size(solution%set%x)
    if (n == 0) return
    left = merge(least_left, 0.0_real64, n > many)
    allocate (gradient(3, n), step(3, n))
    gradient(1, :) = state%off
    gradient(2, :) = solution%set%load * state%off_x
    gradient(3, :) = solution%set%load * state%off_y
    call newton_step(solution%set, gradient, state%target > 0.0_real64, &
                     min(most_left, max(left, state%residual)), step, solution%products)
    allocate (p, source=solution%penetration)
    allocate (x, source=solution%move_x)
    allocate (y, source=solution%move_y)
    allocate (dp(size(p)), dx(size(p)), dy(size(p)), source=0.0_real64)
    do k = 1, n
      associate (i => solution%set%number(k))
        dp(i) = step(1, k) / solution%set%stiffness(k)
        dx(i) = step(2, k)
        dy(i) = step(3, k)
      end associate
    end do
    slope_first = sum(gradient * step)
    low = 0.0_real64
    slope_low = slope_first
    slope_high = 0.0_real64
    high = 0.0_real64
    ! Where the potential curves down the step's length means nothing: no farther than the deepest.
    t = min(1.0_real64, maxval(p(solution%set%number)) / max(maxval(abs(dp)), tiny(t)))
    do trial = 1, most_trials
      solution%penetration = p + t * dp
      solution%move_x = x + t * dx
      solution%move_y = y + t * dy
      call hold_shifts(pairs, solution)
      ! Nor does anything penetrate by more than alone; a law with a kink sends steps far off.
      if (.not. state%target > 0.0_real64) then
        where (state%gap < solution%closing) solution%penetration = &
          min(solution%penetration, 2 * (solution%closing - state%gap))
      end if
      if (state%target > 0.0_real64) call raise(pairs, law, solution, state)
      call evaluate(pairs, law, solution, state, resolved)
      if (allocated(solution%failure)) return
      slope = slope_along()
      if (abs(slope) <= slope_left * abs(slope_first)) exit
      if (slope > 0.0_real64) then
        high = t
        slope_high = slope
      else
        ! Still going down: as far as it was tried.
        if (.not. high > 0.0_real64) exit
        low = t
        slope_low = slope
      end if
      t = low + (high - low) * min(max(slope_low / (slope_low - slope_high), 0.1_real64), &
                                   0.5_real64)
    end do

  contains

    ! Change of the potential with t.
    real(real64) function slope_along()
      real(real64) :: raised
      integer :: j

      associate (set => solution%set)
        raised = 0.0_real64
        if (state%target > 0.0_real64) &
          raised = -sum(set%stiffness * dp(set%number)) / sum(set%stiffness)
        slope_along = 0.0_real64
        do j = 1, size(set%x)
          associate (i => set%number(j))
            slope_along = slope_along + state%off(j) * set%stiffness(j) * (dp(i) + raised) + &
                          set%load(j) * (state%off_x(j) * dx(i) + state%off_y(j) * dy(i))
          end associate
        end do
      end associate
    end function slope_along

  end subroutine take_step

  ! Surfaces are only pushed down: who carries load has s**2/(2 R) below the closing. On the way to
  ! the solution twice the shift is let pass; what is farther off has lost its way.
  subroutine hold_shifts(pairs, solution)
    type(contact_pairs), intent(in) :: pairs
    type(coupled_solution), intent(inout) :: solution
    real(real64) :: most, moved
    integer :: i

    do i = 1, size(pairs%list)
      moved = solution%move_x(i)**2 + solution%move_y(i)**2
      most = 8 * pairs%list(i)%radius * solution%closing
      if (.not. moved > most) cycle
      solution%move_x(i) = solution%move_x(i) * sqrt(most / moved)
      solution%move_y(i) = solution%move_y(i) * sqrt(most / moved)
    end do
  end subroutine hold_shifts

  ! Where open contacts stand, and who of them joins.
  subroutine look(pairs, law, solution, state, resolved, joined)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(coupled_solution), intent(inout) :: solution
    type(solve_state), intent(inout) :: state
    type(resolved_contacts), intent(in), optional :: resolved
    integer, intent(out) :: joined
    type(open_places) :: places
    logical, allocatable :: is_open(:)
    integer, allocatable :: number(:)
    integer :: i, k, pass
    real(real64) :: deepest, most, load

    joined = 0
    if (size(solution%set%x) == 0) then
      ! A step may have opened all of them: then the one that would bear most begins again.
      i = 0
      most = 0.0_real64
      do k = 1, size(state%gap)
        if (.not. state%gap(k) < solution%closing) cycle
        load = load_at(solution%closing - state%gap(k), k)
        if (.not. load > most) cycle
        most = load
        i = k
      end do
      if (i == 0) return
      solution%penetration(i) = start_of_rejoined(solution%closing - state%gap(i), i)
      solution%move_x(i) = 0.0_real64
      solution%move_y(i) = 0.0_real64
      state%joins(i) = state%joins(i) + 1
      joined = 1
      return
    end if
    deepest = maxval(solution%penetration(solution%set%number))
    allocate (is_open(size(state%gap)), source=state%gap < solution%closing)
    is_open(solution%set%number) = .false.
    if (present(resolved)) is_open = is_open .and. .not. resolved%is_one
    number = pack(state%order, is_open(state%order))
    do i = 1, size(number)
      ! From farther than it can be it starts at home.
      associate (x => solution%move_x(number(i)), y => solution%move_y(number(i)))
        if (x**2 + y**2 < 2 * pairs%list(number(i))%radius * &
            (solution%closing - state%gap(number(i)))) cycle
        x = 0.0_real64
        y = 0.0_real64
      end associate
    end do
    do pass = 1, most_looks
      if (size(number) == 0) exit
      places%x = pairs%list(number)%x
      places%y = pairs%list(number)%y
      places%radius = pairs%list(number)%radius
      places%move_x = solution%move_x(number)
      places%move_y = solution%move_y(number)
      places%gap = state%gap(number)
      places%lift = places%x
      call look_around(solution%set, state%gap(solution%set%number), places, &
                       0.1_real64 * asked * deepest, solution%failure)
      if (allocated(solution%failure)) return
      solution%penetration(number) = max(solution%closing - state%gap(number) - places%lift, &
                                         -out_of_reach * deepest)
      solution%move_x(number) = places%move_x
      solution%move_y(number) = places%move_y
      ! Those that would join are looked at from where they would: the far field bends.
      number = pack(number, solution%penetration(number) > asked * deepest)
    end do
    where (is_open .and. .not. solution%penetration > asked * deepest) &
      solution%penetration = min(solution%penetration, 0.0_real64)
    do k = 1, size(number)
      i = number(k)
      if (.not. load_at(solution%penetration(i), i) > 0.0_real64) cycle
      ! Who has opened again had more than its place can bear.
      solution%penetration(i) = start_of_rejoined(solution%penetration(i), i)
      state%joins(i) = state%joins(i) + 1
      state%is_new(i) = .true.
      joined = joined + 1
    end do
    if (joined > 0 .and. state%target > 0.0_real64) call raise(pairs, law, solution, state)

  contains

    real(real64) function load_at(p, i)
      real(real64), intent(in) :: p
      integer, intent(in) :: i
      type(contact_response) :: answer

      call law%respond(pairs%list(i), i, min(p, level * pairs%list(i)%zc), answer)
      load_at = answer%vertical_load
    end function load_at

    ! A share of what lies between the penetration at which a contact begins to carry, which is more
    ! than 0 once it has been flattened, and one at which it carries.
    real(real64) function start_of_rejoined(most, i) result(p)
      real(real64), intent(in) :: most
      integer, intent(in) :: i
      real(real64) :: low, high
      integer :: step

      associate (share => share_of_rejoined**state%joins(i))
        p = share * most
        if (load_at(p, i) > 0.0_real64) return
        low = p
        high = most
        do step = 1, digits(p)
          p = 0.5_real64 * (low + high)
          if (load_at(p, i) > 0.0_real64) then
            high = p
          else
            low = p
          end if
        end do
        p = high + share * (most - high)
      end associate
    end function start_of_rejoined

  end subroutine look

end module asperity_coupled_contacts
