!> Where the solve of coupled contacts stands, and what its equations leave over.
module asperity_coupled_state
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_field, only: contact_field, make_room, spread_field
  use asperity_coupled_shift, only: shift_by_tilt, shift_law
  use asperity_kinds, only: real64
  implicit none
  private

  public :: solve_state, prepare, gather, compare, look_at_waiting
  public :: mark_place, go_back

  !> Where the iteration stands. The first `awake` of `order` are followed, the others wait.
  type :: solve_state
    real(real64) :: closing = 0.0_real64
    real(real64) :: target = -1.0_real64           !! sum of the normal loads; below 0: not asked
    real(real64) :: most_closing = huge(1.0_real64)
    integer :: awake = 0
    logical, allocatable :: is_awake(:)            !! followed, by pair
    integer, allocatable :: order(:)               !! pairs; loaded ones first, then open ones
    integer, allocatable :: row(:)                 !! all pairs, those beside each other in runs
    real(real64), allocatable :: p(:)              !! penetration, by pair
    real(real64), allocatable :: shift_x(:)        !! of the circle, by pair
    real(real64), allocatable :: shift_y(:)        !! of the circle, by pair
    real(real64), allocatable :: normal(:)         !! load, by place in the order
    real(real64), allocatable :: stiffness(:)      !! by place in the order
    type(shift_law), allocatable :: law(:)         !! of the shifts, by place in the order
    real(real64), allocatable :: marked(:, :)      !! p, shift_x, shift_y where it last stood well
    real(real64) :: marked_closing = 0.0_real64    !! closing there
    logical :: near = .false.                      !! it begins near the solution
    real(real64) :: work = 0.0_real64              !! pairs of loaded contacts looked at
    type(contact_field) :: field                   !! by place in the order
  end type solve_state

  !> More contacts than these are looked at in part, and first in single precision.
  integer, parameter, public :: many = 64

  ! What a rough field may be off by, as a share of the largest penetration.
  real(real64), parameter :: rough_error = 3.0e-4_real64

  !> Open contacts that lie deeper than this share of the largest penetration wait.
  real(real64), parameter, public :: margin = 0.1_real64

contains

  !> Room for all pairs.
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
    allocate (state%law(n))
    call row_by_place(pairs, state%row)
    call make_room(state%field, n)
  end subroutine prepare

  ! Cells of a few contacts each, up one column of cells and down the next. Few stay as they are.
  pure subroutine row_by_place(pairs, row)
    type(contact_pairs), intent(in) :: pairs
    integer, allocatable, intent(out) :: row(:)
    integer, parameter :: a_cell = 4
    integer, allocatable :: cell(:), place(:)
    real(real64) :: low_x, low_y, wide, high
    integer :: i, cells, column, n, step

    n = size(pairs%list)
    row = [(i, i=1, n)]
    if (n <= many) return
    low_x = minval(pairs%list%x)
    low_y = minval(pairs%list%y)
    wide = maxval(pairs%list%x) - low_x
    high = maxval(pairs%list%y) - low_y
    cells = int(sqrt(real(n, real64) / a_cell)) + 1
    if (.not. (wide > 0.0_real64 .or. high > 0.0_real64)) return
    allocate (cell(n), place(0:cells**2))
    place = 0
    do i = 1, n
      column = 0
      if (wide > 0.0_real64) &
        column = min(int(cells * ((pairs%list(i)%x - low_x) / wide)), cells - 1)
      step = 0
      if (high > 0.0_real64) step = min(int(cells * ((pairs%list(i)%y - low_y) / high)), cells - 1)
      if (modulo(column, 2) == 1) step = cells - 1 - step
      cell(i) = column * cells + step
      place(cell(i) + 1) = place(cell(i) + 1) + 1
    end do
    do i = 1, cells**2
      place(i) = place(i) + place(i - 1)
    end do
    do i = 1, n
      place(cell(i)) = place(cell(i)) + 1
      row(place(cell(i))) = i
    end do
  end subroutine row_by_place

  !> Sets out the contacts that are awake, those with load first.
  pure subroutine gather(pairs, law, state, keep, same)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(solve_state), intent(inout) :: state
    logical, intent(in) :: keep   ! the matrix of the last step will do for the same contacts
    logical, intent(out) :: same  ! as many and the same carry load as the last time
    type(contact_response) :: response
    integer :: i, k, n
    real(real64) :: p

    if (.not. allocated(state%is_awake)) then
      allocate (state%is_awake(size(pairs%list)))
      state%is_awake = state%p > -margin * maxval(state%p) .or. size(pairs%list) <= many
    end if
    n = 0
    same = .true.
    do k = 1, size(pairs%list)
      i = state%row(k)
      if (.not. (state%is_awake(i) .and. state%p(i) > 0.0_real64)) cycle
      n = n + 1
      same = same .and. state%order(n) == i
      state%order(n) = i
    end do
    same = same .and. state%field%loaded == n
    state%field%loaded = n
    do k = 1, size(pairs%list)
      i = state%row(k)
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
      if (p > 0.0_real64 .and. .not. response%vertical_load > 0.0_real64) &
        call soften(pairs, i, p, k, state)
    end do
    n = state%field%loaded
    state%field%keep_compliance = keep .and. same
    state%field%roughly = n > many .and. .not. keep
    if (size(state%field%compliance, 1) == n) return
    deallocate (state%field%compliance)
    allocate (state%field%compliance(n, n))
  end subroutine gather

  ! A contact that was flattened touches nothing although it is below first touch. It gets a spring
  ! that is as good as none, so that its equation has a solution: nothing is divided by zero.
  pure subroutine soften(pairs, i, penetration, k, state)
    type(contact_pairs), intent(in) :: pairs
    integer, intent(in) :: i, k
    real(real64), intent(in) :: penetration
    type(solve_state), intent(inout) :: state
    real(real64), parameter :: share = 1.0e-6_real64

    state%field%circle(k) = share * sqrt(pairs%list(i)%radius * penetration)
    state%stiffness(k) = 2.0_real64 * pairs%modulus * state%field%circle(k)
    state%normal(k) = 1.0e-30_real64 * pairs%modulus * penetration**2
    state%field%load(k) = state%normal(k)
  end subroutine soften

  !> What the equations leave over, by place in the order, and where the circles should be.
  pure subroutine compare(pairs, state, off, shift_x, shift_y, residual, norm)
    type(contact_pairs), intent(in) :: pairs
    type(solve_state), intent(inout) :: state
    real(real64), intent(out) :: off(:), shift_x(:), shift_y(:), residual, norm
    real(real64) :: deepest, moved
    integer :: i, k

    residual = 0.0_real64
    norm = 0.0_real64
    deepest = tiny(1.0_real64)
    do k = 1, state%awake
      i = state%order(k)
      call shift_by_tilt(pairs%list(i)%radius, state%field%circle(k), state%field%tilt_x(k), &
                         state%field%tilt_y(k), state%law(k))
      shift_x(k) = state%law(k)%x
      shift_y(k) = state%law(k)%y
      moved = hypot(shift_x(k) - state%shift_x(i), shift_y(k) - state%shift_y(i)) * &
              hypot(state%field%tilt_x(k), state%field%tilt_y(k))
      off(k) = (state%closing - pairs%list(i)%gap - state%field%lift(k) - &
                0.5_real64 * (state%shift_x(i)**2 + state%shift_y(i)**2) / &
                pairs%list(i)%radius) - state%p(i)
      if (k <= state%field%loaded) then
        deepest = max(deepest, state%p(i))
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

  !> Finds the penetrations of those that wait, and wakes whom the others no longer keep open.
  pure subroutine look_at_waiting(pairs, state, woken)
    type(contact_pairs), intent(in) :: pairs
    type(solve_state), intent(inout) :: state
    logical, intent(out) :: woken
    type(contact_field) :: all
    real(real64) :: deepest, aside, touching
    integer, allocatable :: order(:)
    integer :: i, k, l, m, n

    woken = .false.
    if (state%awake == size(pairs%list)) return
    m = state%field%loaded
    n = size(pairs%list)
    call make_room(all, n)
    allocate (order(n))
    all%loaded = m
    all%keep_compliance = .true.
    all%only_open = .true.
    all%roughly = n > many
    ! Who is as good as touching is woken too, and then looked at exactly.
    touching = merge(-rough_error * maxval(state%p), 0.0_real64, all%roughly)
    all%x(:m) = state%field%x(:m)
    all%radius(:m) = state%field%radius(:m)
    all%y(:m) = state%field%y(:m)
    all%circle(:m) = state%field%circle(:m)
    all%load(:m) = state%field%load(:m)
    deepest = maxval(state%p)
    k = m
    do l = 1, n
      i = state%row(l)
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
    call spread_field(all, pairs%modulus)
    do k = m + 1, all%count
      i = order(k)
      state%p(i) = state%closing - pairs%list(i)%gap - all%lift(k)
      ! Its place aside is nearer by no more than this.
      aside = 0.5_real64 * pairs%list(i)%radius * (all%tilt_x(k)**2 + all%tilt_y(k)**2)
      if (state%p(i) + aside > touching) woken = .true.
    end do
    if (.not. woken) return
    do i = 1, n
      if (state%p(i) > -margin * deepest) state%is_awake(i) = .true.
    end do
    do k = m + 1, all%count
      i = order(k)
      aside = 0.5_real64 * pairs%list(i)%radius * (all%tilt_x(k)**2 + all%tilt_y(k)**2)
      if (state%p(i) + aside > touching) state%is_awake(i) = .true.
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

  !> Goes back to that place, or part of the way.
  pure subroutine go_back(state, share)
    type(solve_state), intent(inout) :: state !! where it stands
    real(real64), intent(in) :: share         !! of the way

    state%p = state%p + share * (state%marked(:, 1) - state%p)
    state%shift_x = state%shift_x + share * (state%marked(:, 2) - state%shift_x)
    state%shift_y = state%shift_y + share * (state%marked(:, 3) - state%shift_y)
    state%closing = state%closing + share * (state%marked_closing - state%closing)
  end subroutine go_back

end module asperity_coupled_state
