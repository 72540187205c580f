!> Contacts that share a half-space: each is lowered by what its neighbours displace.
!>
!> For contact i: p_i = closing - gap_i - h_i - sum over j of M_ij V_j(p_j), with M_ij V_j the mean
!> of j's Hertz field over i's circle (see mutual_displacement) and V_j its vertical load, zero
!> where p_j is not positive: contacts may open again. On the tilted surface its neighbours leave,
!> a sphere finds its contact aside, where its gap and the surface together are least: its circle
!> moves by s_i = -R_i times the slope, which raises its gap by h_i = s_i**2/(2 R_i). This is the
!> largest of the second-order terms; without it neighbours that nearly touch lose half as much
!> again too much as they should. The whole follows from one potential: Hertz pressures with loads
!> and places that make the complementary energy least (Johnson 1985, section 5.9).
!>
!> Newton's method on the contacts that touch, open ones joining and leaving between its steps.
!> Its matrix, the derivative of M V by V, is the compliance between flat punches: symmetric. Of
!> many contacts, the field is found in single precision while the residual is large; penetrations
!> of open ones that are far from touching stay as exact as that.
module asperity_coupled_contacts
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_acceleration, only: accelerate, forget, step_memory
  use asperity_coupled_coarse, only: refine_start
  use asperity_coupled_estimate, only: estimate_of_interaction
  use asperity_coupled_field, only: spread_field
  use asperity_coupled_open, only: settle_open
  use asperity_coupled_start, only: start_at_closing, start_at_load
  use asperity_coupled_state, only: compare, gather, go_back, look_at_waiting, many, &
                                    mark_place, prepare, solve_state
  use asperity_coupled_step, only: propose, push_worst, take
  use asperity_kinds, only: real64
  use asperity_root_bracket_real64, only: guess_root, narrow_bracket, root_bracket
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: estimate_of_interaction, solve_coupled, solve_coupled_load

  ! The residual asked for, and the one that counts as converged where rounding allows no less.
  real(real64), parameter :: tolerance = 1.0e-12_real64, tolerance_rounded = 1.0e-10_real64
  real(real64), parameter :: tolerance_many = 5.0e-12_real64
  integer, parameter :: most_iterations = 120, most_with_load = 100, most_trials = 100
  integer, parameter :: most_cautious = 400, most_started_again = 500
  ! Below this residual the matrix of an earlier step serves, and a rough field no longer.
  real(real64), parameter :: rough = 1.0e-2_real64
  ! From this residual on the contacts that wait are worth a look.
  real(real64), parameter :: look_from = 0.1_real64
  ! Below this residual full steps are taken; after one that failed, so many careful ones.
  ! Of many contacts few fail: more is dared.
  real(real64), parameter :: full_from = 5.0e-2_real64, full_from_many = 0.2_real64
  real(real64), parameter :: full_gain = 0.7_real64, full_gain_many = 1.0_real64
  integer, parameter :: careful_few = 3, careful_many = 2
  ! After so many iterations without gain the worst contact is pushed, until it is worse by so much.
  integer, parameter :: long_stalled = 8
  real(real64), parameter :: passed = 30.0_real64
  integer, parameter :: steps_past = 10
  ! So many iterations are allowed whatever the work.
  integer, parameter :: least_bounded = 60
  ! Work allowed: pairs of loaded contacts times iterations.
  real(real64), parameter :: most_work = 4.0e8_real64
  ! Larger than any residual; may be doubled.
  real(real64), parameter :: unknown = 0.25_real64 * huge(1.0_real64)

contains

  !> Penetrations at a given closing.
  pure recursive subroutine solve_coupled(pairs, law, closing, penetration, ending, start)
    type(contact_pairs), intent(in) :: pairs         !! those that may touch, ascending gap
    class(contact_law), intent(in) :: law            !! of each contact
    real(real64), intent(in) :: closing              !! past first touch of all; below every zc
    real(real64), intent(out) :: penetration(:)      !! a pair; not positive where it is open
    type(solve_ending), intent(out) :: ending        !! residual over the largest penetration
    !> near the solution, from solve_coupled_load: penetration and shift along x and y of every pair
    real(real64), intent(in), optional :: start(:, :)
    type(solve_state) :: state

    call prepare(pairs, state)
    state%closing = closing
    if (present(start)) then
      state%near = .true.
      state%p = start(:, 1)
      state%shift_x = start(:, 2)
      state%shift_y = start(:, 3)
    else
      call start_at_closing(pairs, law, closing, state%p)
      call refine_start(pairs, law, state%target, closing, state%closing, state%p)
    end if
    call iterate(pairs, law, state, .false., ending)
    if (.not. ending%converged) then
      ! From a start that was none, from the beginning.
      if (present(start)) then
        call solve_coupled(pairs, law, closing, penetration, ending)
        return
      end if
      call start_again(pairs, law, closing, state, ending)
    end if
    penetration = state%p
  end subroutine solve_coupled

  ! From the deepest contact alone, the others joining as they must, with careful steps only: for
  ! contacts that nearly coincide, of which one or the other may carry.
  pure subroutine start_again(pairs, law, closing, state, ending)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    real(real64), intent(in) :: closing
    type(solve_state), intent(inout) :: state
    type(solve_ending), intent(inout) :: ending
    type(solve_state) :: again
    type(solve_ending) :: ending_again

    if (size(pairs%list) > most_started_again) return
    call prepare(pairs, again)
    again%closing = closing
    again%p = min(0.0_real64, closing - pairs%list%gap)
    again%p(1) = closing - pairs%list(1)%gap
    call iterate(pairs, law, again, .true., ending_again)
    ending_again%iterations = ending_again%iterations + ending%iterations
    ending%iterations = ending_again%iterations
    if (.not. ending_again%residual < ending%residual) return
    ending = ending_again
    state = again
  end subroutine start_again

  !> Closing and penetrations at which the loads normal to the contacts have a given sum.
  pure subroutine solve_coupled_load(pairs, law, target, closing, penetration, ending, &
                                     most_closing, failure, solution)
    type(contact_pairs), intent(in) :: pairs         !! those that may touch, ascending gap
    class(contact_law), intent(in) :: law            !! of each contact
    real(real64), intent(in) :: target               !! sum of the loads, more than 0
    real(real64), intent(out) :: closing             !! past first touch of all
    real(real64), intent(out) :: penetration(:)      !! a pair; not positive where it is open
    type(solve_ending), intent(out) :: ending        !! residual over the largest penetration
    real(real64), intent(in), optional :: most_closing  !! not to be passed
    character(:), allocatable, intent(out), optional :: failure  !! why the load is not reached
    !> penetration and shift along x and y of every pair, for solve_coupled at this closing
    real(real64), intent(out), optional :: solution(:, :)
    type(solve_state) :: state
    character(:), allocatable :: reason

    closing = 0.0_real64
    penetration = 0.0_real64
    if (present(solution)) solution = 0.0_real64
    if (size(pairs%list) == 0) then
      reason = 'no contact can carry the load'
    else if (.not. target > 0.0_real64) then
      reason = 'the load is not positive'
    else
      call prepare(pairs, state)
      state%target = target
      if (present(most_closing)) state%most_closing = most_closing
      call start_at_load(pairs, law, target, state%most_closing, state%closing, state%p)
      call refine_start(pairs, law, target, state%most_closing, state%closing, state%p)
      call iterate(pairs, law, state, .false., ending)
      closing = state%closing
      penetration = state%p
      if (present(solution)) then
        solution(:, 2) = state%shift_x
        solution(:, 3) = state%shift_y
      end if
      if (.not. ending%converged .and. closing < state%most_closing .and. &
          state%work < most_work) &
        call search(pairs, law, target, state%most_closing, closing, penetration, ending)
      if (.not. ending%converged) then
        reason = 'the load is not reached at the largest closing'
        if (closing < state%most_closing) reason = 'the iteration did not converge'
      end if
    end if
    if (present(solution)) solution(:, 1) = penetration
    if (present(failure) .and. allocated(reason)) failure = reason
  end subroutine solve_coupled_load

  ! The closing at a load by trial, each solved from the same start. Slow and safe: for contacts
  ! that lie so deep in each other that many share one place in turn, where Newton's method with the
  ! closing as one more unknown may circle.
  pure subroutine search(pairs, law, target, most_closing, closing, penetration, ending)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    real(real64), intent(in) :: target, most_closing
    real(real64), intent(inout) :: closing
    real(real64), intent(out) :: penetration(:)
    type(solve_ending), intent(inout) :: ending
    type(root_bracket) :: bracket
    real(real64) :: off, work
    integer :: spent, trial
    logical :: going_on, reached

    spent = ending%iterations
    work = 0.0_real64
    reached = .false.
    bracket = root_bracket(low=0.0_real64, high=most_closing, low_miss=-1.0_real64, &
                           high_miss=-1.0_real64, halving=8)
    do trial = 1, 2 * most_trials
      call attempt(pairs, law, target, closing, penetration, ending, off)
      spent = spent + ending%iterations
      work = work + ending%iterations * real(count(penetration > 0.0_real64), real64)**2
      reached = reached .or. .not. off < 0.0_real64
      if (abs(off) <= tolerance .or. work > most_work) exit
      call narrow_bracket(bracket, closing, off, off < 0.0_real64)
      if (reached) then
        call guess_root(bracket, closing, going_on)
      else
        going_on = closing < most_closing
        closing = min(1.5_real64 * closing, most_closing)
      end if
      if (.not. going_on) exit
    end do
    ending%iterations = spent
    ending%residual = max(ending%residual, abs(off))
    ending%converged = ending%converged .and. abs(off) <= tolerance_rounded
  end subroutine search

  ! What the load at a closing is off by, as a share of the target.
  pure subroutine attempt(pairs, law, target, closing, penetration, ending, off)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    real(real64), intent(in) :: target, closing
    real(real64), intent(out) :: penetration(:), off
    type(solve_ending), intent(out) :: ending
    type(contact_response) :: response
    integer :: i

    call solve_coupled(pairs, law, closing, penetration, ending)
    off = 0.0_real64
    do i = 1, size(pairs%list)
      if (.not. penetration(i) > 0.0_real64) cycle
      call law%respond(pairs%list(i), i, penetration(i), response)
      off = off + response%load
    end do
    off = off / target - 1.0_real64
  end subroutine attempt

  ! Newton's method until the residual is small and nobody who waits must wake.
  pure subroutine iterate(pairs, law, state, cautious, ending)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(solve_state), intent(inout) :: state
    logical, intent(in) :: cautious  ! no full steps
    type(solve_ending), intent(out) :: ending
    type(step_memory) :: memory
    real(real64), allocatable :: step(:), off(:), shift_x(:), shift_y(:)
    real(real64) :: residual, norm, norm_before, best
    integer :: i, k, n, most, stalled, halvings, careful
    logical :: woken, looked, same, done, full, was_full, pushed

    n = size(pairs%list)
    most = most_iterations
    if (cautious) most = most_cautious
    if (state%target > 0.0_real64) most = most_with_load
    allocate (off(n), shift_x(n), shift_y(n), step(0))
    norm_before = unknown
    best = unknown
    stalled = 0
    halvings = 0
    careful = 0
    looked = .false.
    full = .false.
    do
      ending%iterations = ending%iterations + 1
      call gather(pairs, law, state, best < rough .or. state%near, same)
      call spread_field(state%field, pairs%modulus)
      call settle_open(pairs, state)
      call compare(pairs, state, off, shift_x, shift_y, residual, norm)
      state%work = state%work + real(state%field%loaded, real64)**2
      if (.not. norm <= 2 * norm_before .and. halvings < 8) then
        ! Too far: back half of the way, or all of it to take a careful step, without memory.
        halvings = halvings + 1
        call go_back(state, merge(1.0_real64, 0.5_real64, full))
        full = .false.
        careful = merge(careful_many, careful_few, n > many)
        call forget(memory)
        cycle
      end if
      if (careful > 0) careful = careful - 1
      if (full .and. .not. norm <= merge(full_gain_many, full_gain, n > many) * norm_before) &
        careful = merge(careful_many, careful_few, n > many)
      halvings = 0
      norm_before = norm
      ending%residual = residual
      stalled = stalled + 1
      if (residual < 0.5_real64 * best) stalled = 0
      best = min(best, residual)
      pushed = stalled >= long_stalled .and. residual <= rough .and. n > many
      if (pushed .and. residual > passed * best) then
        stalled = 0
        best = residual
        pushed = .false.
        careful = steps_past
      end if
      done = .false.
      if (ending%iterations >= most) exit
      if (state%work > most_work .and. ending%iterations >= least_bounded) exit
      done = residual <= merge(tolerance_many, tolerance, n > many) .or. &
             (residual <= tolerance_rounded .and. stalled >= 2)
      done = done .and. .not. state%field%roughly
      if (done .or. (residual <= look_from .and. .not. looked)) then
        looked = .true.
        call look_at_waiting(pairs, state, woken)
        if (done .and. .not. woken) exit
        if (woken) then
          norm_before = unknown
          if (residual > rough) best = unknown
        end if
      end if
      was_full = full
      full = careful == 0 .and. residual <= merge(full_from_many, full_from, n > many) .and. &
             .not. (cautious .or. pushed)
      call propose(pairs, state, off, shift_x, shift_y, residual, .not. full, step)
      if (full .neqv. was_full) call forget(memory)
      if (same .and. residual < 0.1_real64 .and. (n > many .or. .not. full)) then
        call accelerate(memory, step)
      else
        call forget(memory)
      end if
      if (pushed) then
        call push_worst(state, off, 2.0_real64**min(stalled - long_stalled + 1, 6), step)
        norm_before = unknown
        call forget(memory)
      end if
      call mark_place(state)
      call take(state, step, off)
    end do
    do k = state%field%loaded + 1, state%awake
      i = state%order(k)
      state%p(i) = min(state%p(i) + off(k), 0.0_real64)
    end do
    ending%converged = ending%residual <= tolerance_rounded .and. .not. state%field%roughly
    if (ending%converged .and. .not. done) then
      call look_at_waiting(pairs, state, woken)
      ending%converged = .not. woken
    end if
  end subroutine iterate

end module asperity_coupled_contacts
