!> One Newton step of coupled contacts, careful or full.
!>
!> The careful one leaves out how shifts and loads change each other and keeps every pair of
!> circles from trading places: it finds the solution that is stable. The full one has all first
!> derivatives of what is near, and ends it in a few steps.
module asperity_coupled_step
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_equations, only: solve_equations
  use asperity_coupled_shift, only: moved_by
  use asperity_coupled_newton, only: full_step
  use asperity_coupled_state, only: many, solve_state
  use asperity_kinds, only: real64
  implicit none
  private

  public :: propose, push_worst, take

  ! From this residual on a full step is taken as it is: it is near the solution.
  real(real64), parameter :: small = 1.0e-3_real64

contains

  !> Finds a step: penetrations and weighted shifts of the loaded, then the closing.
  pure subroutine propose(pairs, state, off, shift_x, shift_y, residual, careful, step)
    type(contact_pairs), intent(in) :: pairs         !! the contacts
    type(solve_state), intent(inout) :: state        !! where it stands
    real(real64), intent(in) :: off(:)               !! what the penetrations are off
    real(real64), intent(in) :: shift_x(:)           !! where the circles should be
    real(real64), intent(in) :: shift_y(:)           !! where the circles should be
    real(real64), intent(in) :: residual             !! of all
    logical, intent(in) :: careful                   !! no full step
    real(real64), allocatable, intent(out) :: step(:)  !! the step
    real(real64), allocatable :: diagonal(:), change(:)
    real(real64) :: grown, weight, closing_step, accuracy
    logical, allocatable :: is_wild(:)
    integer :: i, k, m

    m = state%field%loaded
    allocate (diagonal(m), change(m), is_wild(m), step(3 * m + 1))
    is_wild = .true.
    weight = weight_of_shift(state)
    do k = 1, m
      ! A wider circle means the neighbours' field over a wider one: d(radius)/dp = R/(2 radius).
      grown = 0.0_real64
      ! A contact that was flattened may touch without a circle.
      if (state%field%circle(k) > 0.0_real64) &
        grown = 0.5_real64 * pairs%list(state%order(k))%radius / state%field%circle(k)**2 * &
                state%field%growth(k)
      diagonal(k) = (1.0_real64 + max(grown, -0.7_real64)) / state%stiffness(k)
    end do
    if (.not. careful) then
      accuracy = max(1.0e-3_real64, min(1.0e-2_real64, 0.3_real64 * residual))
      call full_step(state, off, shift_x, shift_y, diagonal, weight, accuracy, step)
      if (size(pairs%list) <= many) return
      call find_wild(state, weight, step, is_wild)
      if (.not. any(is_wild) .or. residual < small) return
    end if
    call simple_step(state, off, diagonal, residual, change, closing_step)
    do k = 1, m
      if (.not. is_wild(k)) cycle
      i = state%order(k)
      step(k) = change(k) / state%stiffness(k)
      ! Neighbours move the other way: twice the bend.
      call moved_by(state%law(k), 2 * state%field%bend_xx(k), 2 * state%field%bend_xy(k), &
                    2 * state%field%bend_yy(k), shift_x(k) - state%shift_x(i), &
                    shift_y(k) - state%shift_y(i), step(m + k), step(2 * m + k))
      step(m + k) = weight * step(m + k)
      step(2 * m + k) = weight * step(2 * m + k)
    end do
    if (careful) step(3 * m + 1) = closing_step
  end subroutine propose

  ! Contacts that a full step throws about, and who is near to them: there its matrix is as good as
  ! singular, as two circles trade places.
  pure subroutine find_wild(state, weight, step, is_wild)
    type(solve_state), intent(in) :: state
    real(real64), intent(in) :: weight, step(:)
    logical, intent(out) :: is_wild(:)
    real(real64), parameter :: most_of_deepest = 0.1_real64, most_of_own = 0.3_real64
    logical :: is_first(size(is_wild))
    real(real64) :: deepest, own
    integer :: k, m

    m = size(is_wild)
    deepest = maxval(state%p)
    do k = 1, m
      own = state%p(state%order(k))
      is_first(k) = abs(step(k)) > most_of_deepest * deepest + most_of_own * own .or. &
                    hypot(step(m + k), step(2 * m + k)) > weight * state%field%circle(k)
    end do
    call with_neighbours(state, is_first, is_wild)
  end subroutine find_wild

  ! Some contacts and those with load that are near to them.
  pure subroutine with_neighbours(state, some, more)
    type(solve_state), intent(in) :: state
    logical, intent(in) :: some(:)
    logical, intent(out) :: more(:)
    integer :: i, j, k

    more = some
    if (.not. any(some)) return
    do k = 1, state%field%near_pairs
      i = state%field%near(k)%first
      j = state%field%near(k)%second
      if (i > size(some)) cycle
      if (.not. (some(i) .or. some(j))) cycle
      more(i) = .true.
      more(j) = .true.
    end do
  end subroutine with_neighbours

  ! Loads alone: symmetric, made definite.
  pure subroutine simple_step(state, off, diagonal, residual, change, closing_step)
    type(solve_state), intent(in) :: state
    real(real64), intent(in) :: off(:), residual
    real(real64), intent(inout) :: diagonal(:)
    real(real64), intent(out) :: change(:), closing_step
    real(real64) :: reply(size(change)), ones(size(change)), accuracy, lacking, wanted
    logical :: definite
    integer :: m

    m = size(change)
    ! Where circles overlap the diagonal falls. Two contacts stay definite with this.
    diagonal = max(diagonal, 1.05_real64 * state%field%strongest(:m))
    ! The matrix leaves out second-order terms: a finer solution would not be a better step.
    accuracy = max(1.0e-6_real64, min(3.0e-2_real64, 0.05_real64 * residual))
    call solve_equations(diagonal, state%field%compliance, off(:m), accuracy, change, definite)
    if (.not. definite) then
      diagonal = max(diagonal, 1.05_real64 / state%stiffness(:m))
      call solve_equations(diagonal, state%field%compliance, off(:m), accuracy, change, definite)
    end if
    closing_step = 0.0_real64
    if (.not. state%target > 0.0_real64) return
    ones = 1.0_real64
    call solve_equations(diagonal, state%field%compliance, ones, accuracy, reply, definite)
    lacking = state%target - sum(state%normal(:m))
    wanted = lacking - sum(change * state%normal(:m) / state%field%load(:m))
    closing_step = wanted / sum(reply * state%normal(:m) / state%field%load(:m))
    closing_step = min(closing_step, state%most_closing - state%closing)
    change = change + closing_step * reply
  end subroutine simple_step

  !> Lets the contact that is worst off go farther than a careful step says.
  !>
  !> Beside a fold, where two solutions have met and vanished, careful steps creep through a narrow
  !> pass.
  pure subroutine push_worst(state, off, factor, step)
    type(solve_state), intent(in) :: state    !! where it stands
    real(real64), intent(in) :: off(:)        !! what the penetrations are off
    real(real64), intent(in) :: factor        !! how much farther at most
    real(real64), intent(inout) :: step(:)    !! a careful step
    real(real64) :: own, share
    integer :: k, m

    m = state%field%loaded
    if (m == 0) return
    k = maxloc(abs(off(:m)), dim=1)
    own = state%p(state%order(k))
    share = factor
    if (abs(step(k)) * factor > 0.1_real64 * own) &
      share = max(1.0_real64, 0.1_real64 * own / abs(step(k)))
    step(k) = share * step(k)
    step(m + k) = share * step(m + k)
    step(2 * m + k) = share * step(2 * m + k)
  end subroutine push_worst

  !> Takes a step.
  pure subroutine take(state, step, off)
    type(solve_state), intent(inout) :: state  !! as it was when the step was proposed
    real(real64), intent(in) :: step(:)        !! from propose
    real(real64), intent(in) :: off(:)         !! what open contacts are off
    real(real64) :: weight
    integer :: i, k, m

    m = state%field%loaded
    weight = 1.0_real64 / weight_of_shift(state)
    do k = 1, m
      i = state%order(k)
      state%p(i) = state%p(i) + step(k)
      state%shift_x(i) = state%shift_x(i) + weight * step(m + k)
      state%shift_y(i) = state%shift_y(i) + weight * step(2 * m + k)
    end do
    do k = m + 1, state%awake
      i = state%order(k)
      state%p(i) = state%p(i) + off(k) + step(3 * m + 1)
    end do
    state%closing = min(state%closing + step(3 * m + 1), state%most_closing)
  end subroutine take

  ! Makes shifts as large as penetrations.
  pure function weight_of_shift(state) result(weight)
    type(solve_state), intent(in) :: state
    real(real64) :: weight, deepest, widest
    integer :: k

    deepest = 0.0_real64
    widest = 0.0_real64
    do k = 1, state%field%loaded
      if (state%field%circle(k) <= widest) cycle
      widest = state%field%circle(k)
      deepest = state%field%load(k) / state%stiffness(k)
    end do
    weight = 1.0_real64
    if (deepest > 0.0_real64) weight = deepest / widest
  end function weight_of_shift

end module asperity_coupled_step
