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
!> Its matrix, the derivative of M V by V, is the compliance between flat punches: symmetric.
module asperity_coupled_contacts
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_equations, only: solve_equations
  use asperity_coupled_estimate, only: estimate_of_interaction
  use asperity_coupled_field, only: contact_field, spread_field
  use asperity_coupled_start, only: start_at_closing, start_at_load
  use asperity_kinds, only: real64
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: estimate_of_interaction, solve_coupled, solve_coupled_load

  !> Where the iteration stands. The first `awake` of `order` are followed, the others wait.
  type :: solve_state
    real(real64) :: closing = 0.0_real64
    real(real64) :: target = -1.0_real64           !! sum of the normal loads; below 0: not asked
    real(real64) :: most_closing = huge(1.0_real64)
    integer :: awake = 0
    integer, allocatable :: order(:)               !! pairs; loaded ones first, then open ones
    real(real64), allocatable :: p(:)              !! penetration, by pair
    real(real64), allocatable :: shift_x(:)        !! of the circle, by pair
    real(real64), allocatable :: shift_y(:)        !! of the circle, by pair
    real(real64), allocatable :: normal(:)         !! load, by place in the order
    real(real64), allocatable :: stiffness(:)      !! by place in the order
    type(contact_field) :: field                   !! by place in the order
  end type solve_state

  ! The residual asked for, and the one that counts as converged where rounding allows no less.
  real(real64), parameter :: tolerance = 1.0e-12_real64, tolerance_rounded = 1.0e-10_real64
  integer, parameter :: most_iterations = 200
  ! Open contacts that lie deeper than this share of the largest penetration wait.
  real(real64), parameter :: margin = 0.2_real64

contains

  !> Penetrations at a given closing.
  pure subroutine solve_coupled(pairs, law, closing, penetration, ending, start)
    type(contact_pairs), intent(in) :: pairs         !! those that may touch, ascending gap
    class(contact_law), intent(in) :: law            !! of each contact
    real(real64), intent(in) :: closing              !! past first touch of all; below every zc
    real(real64), intent(out) :: penetration(:)      !! a pair; not positive where it is open
    type(solve_ending), intent(out) :: ending        !! residual over the largest penetration
    real(real64), intent(in), optional :: start(:)   !! penetrations near the solution
    type(solve_state) :: state

    call prepare(pairs, state)
    state%closing = closing
    if (present(start)) then
      state%p = start
    else
      call start_at_closing(pairs, law, closing, state%p)
    end if
    call iterate(pairs, law, state, ending)
    penetration = state%p
  end subroutine solve_coupled

  !> Closing and penetrations at which the loads normal to the contacts have a given sum.
  pure subroutine solve_coupled_load(pairs, law, target, closing, penetration, ending, &
                                     most_closing, start, failure)
    type(contact_pairs), intent(in) :: pairs         !! those that may touch, ascending gap
    class(contact_law), intent(in) :: law            !! of each contact
    real(real64), intent(in) :: target               !! sum of the loads, more than 0
    real(real64), intent(out) :: closing             !! past first touch of all
    real(real64), intent(out) :: penetration(:)      !! a pair; not positive where it is open
    type(solve_ending), intent(out) :: ending        !! residual over the largest penetration
    real(real64), intent(in), optional :: most_closing  !! not to be passed
    real(real64), intent(in), optional :: start(:)   !! penetrations near the solution
    character(:), allocatable, intent(out), optional :: failure  !! why the load is not reached
    type(solve_state) :: state
    character(:), allocatable :: reason

    closing = 0.0_real64
    penetration = 0.0_real64
    if (size(pairs%list) == 0) then
      reason = 'no contact can carry the load'
    else if (.not. target > 0.0_real64) then
      reason = 'the load is not positive'
    else
      call prepare(pairs, state)
      state%target = target
      if (present(most_closing)) state%most_closing = most_closing
      call start_at_load(pairs, law, target, state%most_closing, state%closing, state%p)
      if (present(start)) state%p = start
      call iterate(pairs, law, state, ending)
      closing = state%closing
      penetration = state%p
      if (.not. ending%converged) then
        if (closing < state%most_closing) then
          reason = 'the iteration did not converge'
        else
          reason = 'the load is not reached at the largest closing'
        end if
      end if
    end if
    if (present(failure) .and. allocated(reason)) failure = reason
  end subroutine solve_coupled_load

  ! Room for all pairs.
  pure subroutine prepare(pairs, state)
    type(contact_pairs), intent(in) :: pairs
    type(solve_state), intent(out) :: state
    integer :: n

    n = size(pairs%list)
    allocate (state%order(n), state%p(n), state%normal(n), state%stiffness(n))
    allocate (state%shift_x(n), source=0.0_real64)
    allocate (state%shift_y(n), source=0.0_real64)
    allocate (state%field%x(n), state%field%y(n), state%field%circle(n), state%field%load(n))
    allocate (state%field%lift(n), state%field%growth(n))
    allocate (state%field%tilt_x(n), state%field%tilt_y(n))
  end subroutine prepare

  ! Newton's method until the residual is small and nobody who waits must wake.
  pure subroutine iterate(pairs, law, state, ending)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(solve_state), intent(inout) :: state
    type(solve_ending), intent(out) :: ending
    real(real64), allocatable :: step(:), off(:), shift_x(:), shift_y(:)
    logical, allocatable :: awake(:)
    real(real64) :: residual, norm, norm_before, best, share, deepest, closing_step
    integer :: n, stalled, halvings
    logical :: woken

    n = size(pairs%list)
    allocate (step(n), off(n), shift_x(n), shift_y(n))
    deepest = maxval([state%p, 0.0_real64])
    allocate (awake(n))
    awake = state%p > -margin * deepest .or. n <= 64
    step = 0.0_real64
    closing_step = 0.0_real64
    norm_before = huge(1.0_real64)
    best = huge(1.0_real64)
    stalled = 0
    halvings = 0
    do
      ending%iterations = ending%iterations + 1
      call gather(pairs, law, state, awake)
      call spread_field(state%field, pairs%modulus)
      call compare(pairs, state, off, shift_x, shift_y, residual, norm)
      ending%residual = residual
      if (norm > 2 * norm_before .and. halvings < 8) then
        ! Too far: back half of the way.
        halvings = halvings + 1
        step = 0.5_real64 * step
        closing_step = 0.5_real64 * closing_step
        state%p = state%p - step
        state%closing = state%closing - closing_step
        cycle
      end if
      halvings = 0
      norm_before = norm
      stalled = stalled + 1
      if (residual < 0.5_real64 * best) stalled = 0
      best = min(best, residual)
      if (residual <= tolerance .or. (residual <= tolerance_rounded .and. stalled >= 3) .or. &
          ending%iterations >= most_iterations) then
        call look_at_waiting(pairs, state, awake, woken)
        if (.not. woken .or. ending%iterations >= most_iterations) exit
        norm_before = huge(1.0_real64)
        best = huge(1.0_real64)
        cycle
      end if
      share = 1.0_real64
      if (ending%iterations > 20) share = 0.5_real64
      call improve(pairs, state, off, shift_x, shift_y, share, residual, step, closing_step)
    end do
    ending%converged = residual <= tolerance_rounded .and. .not. woken
  end subroutine iterate

  ! Sets out the contacts that are awake, those with load first.
  pure subroutine gather(pairs, law, state, awake)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(solve_state), intent(inout) :: state
    logical, intent(in) :: awake(:)
    type(contact_response) :: response
    integer :: i, k, n
    real(real64) :: p

    n = 0
    do i = 1, size(pairs%list)
      if (.not. (awake(i) .and. state%p(i) > 0.0_real64)) cycle
      n = n + 1
      state%order(n) = i
    end do
    state%field%loaded = n
    do i = 1, size(pairs%list)
      if (.not. awake(i) .or. state%p(i) > 0.0_real64) cycle
      n = n + 1
      state%order(n) = i
    end do
    state%awake = n
    state%field%count = n
    do k = 1, n
      i = state%order(k)
      state%field%x(k) = pairs%list(i)%x + state%shift_x(i)
      state%field%y(k) = pairs%list(i)%y + state%shift_y(i)
      p = min(state%p(i), 0.999999_real64 * pairs%list(i)%zc)
      call law%respond(pairs%list(i), i, p, response)
      state%field%circle(k) = response%contact_radius
      state%field%load(k) = response%vertical_load
      state%stiffness(k) = response%stiffness
      state%normal(k) = response%load
    end do
    n = state%field%loaded
    if (allocated(state%field%compliance)) then
      if (size(state%field%compliance, 1) == n) return
      deallocate (state%field%compliance)
    end if
    allocate (state%field%compliance(n, n))
  end subroutine gather

  ! What the equations leave over, by place in the order, and where the circles should be.
  pure subroutine compare(pairs, state, off, shift_x, shift_y, residual, norm)
    type(contact_pairs), intent(in) :: pairs
    type(solve_state), intent(in) :: state
    real(real64), intent(out) :: off(:), shift_x(:), shift_y(:), residual, norm
    real(real64) :: deepest, moved
    integer :: i, k

    residual = 0.0_real64
    norm = 0.0_real64
    deepest = tiny(1.0_real64)
    do k = 1, state%awake
      i = state%order(k)
      shift_x(k) = -pairs%list(i)%radius * state%field%tilt_x(k)
      shift_y(k) = -pairs%list(i)%radius * state%field%tilt_y(k)
      off(k) = (state%closing - pairs%list(i)%gap - state%field%lift(k) - &
                0.5_real64 * (state%shift_x(i)**2 + state%shift_y(i)**2) / &
                pairs%list(i)%radius) - state%p(i)
      if (k <= state%field%loaded) then
        deepest = max(deepest, state%p(i))
        moved = hypot(shift_x(k) - state%shift_x(i), shift_y(k) - state%shift_y(i)) * &
                hypot(state%field%tilt_x(k), state%field%tilt_y(k))
        residual = max(residual, abs(off(k)), moved)
        norm = norm + off(k)**2 + moved**2
      else if (off(k) + state%p(i) > 0.0_real64) then
        residual = max(residual, off(k) + state%p(i))
        norm = norm + (off(k) + state%p(i))**2
      end if
    end do
    residual = residual / deepest
    norm = sqrt(norm)
    if (state%target > 0.0_real64) then
      moved = sum(state%normal(:state%field%loaded)) / state%target - 1.0_real64
      residual = max(residual, abs(moved))
    end if
  end subroutine compare

  ! One step of Newton's method.
  pure subroutine improve(pairs, state, off, shift_x, shift_y, share, residual, step, closing_step)
    type(contact_pairs), intent(in) :: pairs
    type(solve_state), intent(inout) :: state
    real(real64), intent(in) :: off(:), shift_x(:), shift_y(:), share, residual
    real(real64), intent(out) :: step(:), closing_step
    real(real64), allocatable :: diagonal(:), change(:), reply(:), ones(:)
    real(real64) :: accuracy, grown, lacking, wanted
    integer :: i, k, m

    m = state%field%loaded
    allocate (diagonal(m), change(m))
    do k = 1, m
      ! A wider circle means the neighbours' field over a wider one: d(radius)/dp = R/(2 radius).
      ! Where circles overlap this may fall; without it the matrix stays positive.
      grown = 0.5_real64 * pairs%list(state%order(k))%radius / state%field%circle(k)**2 * &
              state%field%growth(k)
      diagonal(k) = (1.0_real64 + max(grown, 0.0_real64)) / state%stiffness(k)
    end do
    accuracy = max(1.0e-9_real64, min(1.0e-3_real64, 0.01_real64 * residual))
    call solve_equations(diagonal, state%field%compliance, off(:m), accuracy, change)
    closing_step = 0.0_real64
    if (state%target > 0.0_real64) then
      allocate (reply(m), ones(m))
      ones = 1.0_real64
      call solve_equations(diagonal, state%field%compliance, ones, accuracy, reply)
      lacking = state%target - sum(state%normal(:m))
      wanted = lacking - sum(change * state%normal(:m) / state%field%load(:m))
      closing_step = wanted / sum(reply * state%normal(:m) / state%field%load(:m))
      closing_step = min(closing_step, state%most_closing - state%closing)
      change = change + closing_step * reply
    end if
    state%closing = state%closing + closing_step
    step = 0.0_real64
    do k = 1, state%awake
      i = state%order(k)
      if (k <= m) then
        step(i) = change(k) / state%stiffness(k)
      else
        step(i) = off(k) + closing_step
      end if
      state%shift_x(i) = state%shift_x(i) + share * (shift_x(k) - state%shift_x(i))
      state%shift_y(i) = state%shift_y(i) + share * (shift_y(k) - state%shift_y(i))
    end do
    state%p = state%p + step
  end subroutine improve

  ! Finds the penetrations of those that wait, and wakes whom the others no longer keep open.
  pure subroutine look_at_waiting(pairs, state, awake, woken)
    type(contact_pairs), intent(in) :: pairs
    type(solve_state), intent(inout) :: state
    logical, intent(inout) :: awake(:)
    logical, intent(out) :: woken
    type(contact_field) :: all
    real(real64) :: deepest
    integer :: i, k, m, n

    woken = .false.
    if (state%awake == size(awake)) return
    m = state%field%loaded
    all%loaded = m
    n = size(awake)
    allocate (all%x(n), all%y(n), all%circle(n), all%load(n), all%lift(n), all%growth(n))
    allocate (all%tilt_x(n), all%tilt_y(n), all%compliance(m, m))
    all%x(:m) = state%field%x(:m)
    all%y(:m) = state%field%y(:m)
    all%circle(:m) = state%field%circle(:m)
    all%load(:m) = state%field%load(:m)
    deepest = maxval(state%p)
    k = m
    do i = 1, n
      if (awake(i)) cycle
      if (pairs%list(i)%gap >= state%closing) then
        state%p(i) = state%closing - pairs%list(i)%gap
        cycle
      end if
      k = k + 1
      state%order(k) = i
      all%x(k) = pairs%list(i)%x
      all%y(k) = pairs%list(i)%y
      all%circle(k) = 0.0_real64
      all%load(k) = 0.0_real64
    end do
    all%count = k
    call spread_field(all, pairs%modulus)
    do k = m + 1, all%count
      i = state%order(k)
      ! The sphere may touch aside, where the tilted surface is closer.
      state%p(i) = state%closing - pairs%list(i)%gap - all%lift(k) + &
                   0.5_real64 * pairs%list(i)%radius * (all%tilt_x(k)**2 + all%tilt_y(k)**2)
      if (state%p(i) > 0.0_real64) woken = .true.
    end do
    if (.not. woken) return
    do i = 1, n
      if (state%p(i) > -margin * deepest) awake(i) = .true.
    end do
  end subroutine look_at_waiting

end module asperity_coupled_contacts
