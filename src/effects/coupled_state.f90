!> Where the solve of coupled contacts stands, and what its equations leave over.
module asperity_coupled_state
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_field, only: contact_field, make_room, spread_field
  use asperity_kinds, only: real64
  implicit none
  private

  public :: solve_state, prepare, gather, compare, look_at_waiting, share_of_shift
  public :: mark_place, go_back_half

  !> Where the iteration stands. The first `awake` of `order` are followed, the others wait.
  type :: solve_state
    real(real64) :: closing = 0.0_real64
    real(real64) :: target = -1.0_real64           !! sum of the normal loads; below 0: not asked
    real(real64) :: most_closing = huge(1.0_real64)
    integer :: awake = 0
    logical, allocatable :: is_awake(:)            !! followed, by pair
    integer, allocatable :: order(:)               !! pairs; loaded ones first, then open ones
    real(real64), allocatable :: p(:)              !! penetration, by pair
    real(real64), allocatable :: shift_x(:)        !! of the circle, by pair
    real(real64), allocatable :: shift_y(:)        !! of the circle, by pair
    real(real64), allocatable :: normal(:)         !! load, by place in the order
    real(real64), allocatable :: stiffness(:)      !! by place in the order
    logical :: has_reply = .false.                 !! the reply below still serves
    real(real64), allocatable :: reply(:)          !! of the loads to a unit of closing
    real(real64), allocatable :: marked(:, :)      !! p, shift_x, shift_y where it last stood well
    real(real64) :: marked_closing = 0.0_real64    !! closing there
    type(contact_field) :: field                   !! by place in the order
  end type solve_state

  !> Open contacts that lie deeper than this share of the largest penetration wait.
  real(real64), parameter, public :: margin = 0.2_real64

contains

  ! Room for all pairs.
  pure subroutine prepare(pairs, state)
    type(contact_pairs), intent(in) :: pairs
    type(solve_state), intent(out) :: state
    integer :: n

    n = size(pairs%list)
    allocate (state%order(n), source=0)
    allocate (state%p(n), state%normal(n), state%stiffness(n))
    allocate (state%shift_x(n), source=0.0_real64)
    allocate (state%shift_y(n), source=0.0_real64)
    allocate (state%marked(n, 3), source=0.0_real64)
    allocate (state%reply(n))
    call make_room(state%field, n)
  end subroutine prepare

  ! Sets out the contacts that are awake, those with load first.
  pure subroutine gather(pairs, law, state, roughly, same)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(solve_state), intent(inout) :: state
    logical, intent(in) :: roughly  ! the matrix of the last step will do for the same contacts
    logical, intent(out) :: same    ! as many and the same carry load as the last time
    type(contact_response) :: response
    integer :: i, k, n
    real(real64) :: p

    if (.not. allocated(state%is_awake)) then
      allocate (state%is_awake(size(pairs%list)))
      state%is_awake = state%p > -margin * maxval(state%p) .or. size(pairs%list) <= 64
    end if
    n = 0
    same = .true.
    do i = 1, size(pairs%list)
      if (.not. (state%is_awake(i) .and. state%p(i) > 0.0_real64)) cycle
      n = n + 1
      same = same .and. state%order(n) == i
      state%order(n) = i
    end do
    same = same .and. state%field%loaded == n
    state%field%loaded = n
    do i = 1, size(pairs%list)
      if (.not. state%is_awake(i) .or. state%p(i) > 0.0_real64) cycle
      n = n + 1
      state%order(n) = i
    end do
    state%awake = n
    state%field%count = n
    do k = 1, n
      i = state%order(k)
      state%field%x(k) = pairs%list(i)%x + state%shift_x(i)
      state%field%y(k) = pairs%list(i)%y + state%shift_y(i)
      state%field%radius(k) = pairs%list(i)%radius
      p = min(state%p(i), 0.999999_real64 * pairs%list(i)%zc)
      call law%respond(pairs%list(i), i, p, response)
      state%field%circle(k) = response%contact_radius
      state%field%load(k) = response%vertical_load
      state%stiffness(k) = response%stiffness
      state%normal(k) = response%load
    end do
    n = state%field%loaded
    state%field%keep_compliance = roughly .and. same
    state%has_reply = state%has_reply .and. same
    if (size(state%field%compliance, 1) == n) return
    deallocate (state%field%compliance)
    allocate (state%field%compliance(n, n))
  end subroutine gather

  ! What the equations leave over, by place in the order, and where the circles should be.
  pure subroutine compare(pairs, state, off, shift_x, shift_y, residual, norm)
    type(contact_pairs), intent(in) :: pairs
    type(solve_state), intent(in) :: state
    real(real64), intent(out) :: off(:), shift_x(:), shift_y(:), residual, norm
    real(real64) :: deepest, held, moved
    integer :: i, k

    residual = 0.0_real64
    norm = 0.0_real64
    deepest = tiny(1.0_real64)
    do k = 1, state%awake
      i = state%order(k)
      held = share_of_shift(pairs%list(i)%radius * hypot(state%field%tilt_x(k), &
                            state%field%tilt_y(k)), state%field%circle(k))
      shift_x(k) = -held * pairs%list(i)%radius * state%field%tilt_x(k)
      shift_y(k) = -held * pairs%list(i)%radius * state%field%tilt_y(k)
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

  ! Share of a shift that counts. Shifts of more than half the circle's radius occur only where a
  ! small circle lies on the flank of a large one; there the tilt is no small change any more.
  pure function share_of_shift(shift, circle) result(share)
    real(real64), intent(in) :: shift, circle
    real(real64) :: share, cap

    cap = 0.5_real64 * circle
    share = 0.0_real64
    if (cap > 0.0_real64) &
      share = 1.0_real64 / sqrt(sqrt(1.0_real64 + min(shift / cap, 1.0e9_real64)**4))
  end function share_of_shift

  ! Finds the penetrations of those that wait, and wakes whom the others no longer keep open.
  pure subroutine look_at_waiting(pairs, state, woken)
    type(contact_pairs), intent(in) :: pairs
    type(solve_state), intent(inout) :: state
    logical, intent(out) :: woken
    type(contact_field) :: all
    real(real64) :: deepest
    integer, allocatable :: order(:)
    integer :: i, k, m, n

    woken = .false.
    if (state%awake == size(pairs%list)) return
    m = state%field%loaded
    n = size(pairs%list)
    call make_room(all, n)
    allocate (order(n))
    all%loaded = m
    all%keep_compliance = .true.
    all%x(:m) = state%field%x(:m)
    all%radius(:m) = state%field%radius(:m)
    all%y(:m) = state%field%y(:m)
    all%circle(:m) = state%field%circle(:m)
    all%load(:m) = state%field%load(:m)
    deepest = maxval(state%p)
    k = m
    do i = 1, n
      if (state%is_awake(i)) cycle
      if (pairs%list(i)%gap >= state%closing) then
        state%p(i) = state%closing - pairs%list(i)%gap
        cycle
      end if
      k = k + 1
      order(k) = i
      all%x(k) = pairs%list(i)%x
      all%radius(k) = pairs%list(i)%radius
      all%y(k) = pairs%list(i)%y
      all%circle(k) = 0.0_real64
      all%load(k) = 0.0_real64
    end do
    all%count = k
    call spread_field(all, pairs%modulus, .true.)
    do k = m + 1, all%count
      i = order(k)
      state%p(i) = state%closing - pairs%list(i)%gap - all%lift(k)
      if (state%p(i) > 0.0_real64) woken = .true.
    end do
    if (.not. woken) return
    do i = 1, n
      if (state%p(i) > -margin * deepest) state%is_awake(i) = .true.
    end do
  end subroutine look_at_waiting

  !> Remembers a place to go back to.
  pure subroutine mark_place(state)
    type(solve_state), intent(inout) :: state !! where it stands

    state%marked(:, 1) = state%p
    state%marked(:, 2) = state%shift_x
    state%marked(:, 3) = state%shift_y
    state%marked_closing = state%closing
  end subroutine mark_place

  !> Goes back half of the way to that place.
  pure subroutine go_back_half(state)
    type(solve_state), intent(inout) :: state !! where it stands

    state%p = 0.5_real64 * (state%p + state%marked(:, 1))
    state%shift_x = 0.5_real64 * (state%shift_x + state%marked(:, 2))
    state%shift_y = 0.5_real64 * (state%shift_y + state%marked(:, 3))
    state%closing = 0.5_real64 * (state%closing + state%marked_closing)
  end subroutine go_back_half

end module asperity_coupled_state
