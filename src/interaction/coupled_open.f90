!> Finds where open contacts would touch first on the surface that the others leave.
!>
!> Open contacts only feel, so each stands alone. At the rim of a neighbour the slope goes as a
!> root, where Newton's method swings: here its steps are cut until they help, and no one else
!> waits for it.
module asperity_coupled_open
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_shift, only: moved_by, shift_by_tilt, shift_law
  use asperity_coupled_state, only: solve_state
  use asperity_kinds, only: real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms
  implicit none
  private

  public :: settle_open

  !> What near neighbours do at one place.
  type :: near_field
    real(real64) :: lift = 0.0_real64     !! of the surface
    real(real64) :: tilt_x = 0.0_real64   !! its slope
    real(real64) :: tilt_y = 0.0_real64   !! its slope
    real(real64) :: bend_xx = 0.0_real64  !! its second derivatives
    real(real64) :: bend_xy = 0.0_real64  !! the same
    real(real64) :: bend_yy = 0.0_real64  !! the same
  end type near_field

  integer, parameter :: most_steps = 30
  ! Of many, contacts that lie deeper than this share of the largest penetration are left.
  real(real64), parameter :: looked_at = 0.1_real64
  integer, parameter :: few = 64

contains

  !> Moves open contacts to their places, where lift and tilt are found again.
  pure subroutine settle_open(pairs, state)
    type(contact_pairs), intent(in) :: pairs   !! the contacts
    type(solve_state), intent(inout) :: state  !! its field is known
    integer, allocatable :: first(:), source(:)
    real(real64) :: deepest, nearest
    integer :: i, k, m

    m = state%field%loaded
    if (state%awake == m) return
    call sort_sources(state, first, source)
    deepest = maxval(state%p)
    do k = m + 1, state%awake
      i = state%order(k)
      nearest = state%closing - pairs%list(i)%gap - state%field%lift(k) + &
                0.5_real64 * state%field%radius(k) * &
                (state%field%tilt_x(k)**2 + state%field%tilt_y(k)**2)
      if (nearest > -looked_at * deepest .or. state%awake <= few) &
        call settle(state, pairs%modulus, k, i, source(first(k):first(k + 1) - 1))
    end do
  end subroutine settle_open

  ! The near neighbours of each open contact: those of k begin at first(k).
  pure subroutine sort_sources(state, first, source)
    type(solve_state), intent(in) :: state
    integer, allocatable, intent(out) :: first(:), source(:)
    integer :: k, i, m, n

    m = state%field%loaded
    n = state%awake
    allocate (first(m + 1:n + 2), source(state%field%near_pairs))
    first = 0
    do k = 1, state%field%near_pairs
      i = state%field%near(k)%first
      if (i > m) first(i + 2) = first(i + 2) + 1
    end do
    first(m + 1) = 1
    first(m + 2) = 1
    do i = m + 3, n + 2
      first(i) = first(i) + first(i - 1)
    end do
    do k = 1, state%field%near_pairs
      i = state%field%near(k)%first
      if (i <= m) cycle
      source(first(i + 1)) = state%field%near(k)%second
      first(i + 1) = first(i + 1) + 1
    end do
  end subroutine sort_sources

  ! One contact.
  pure subroutine settle(state, modulus, k, i, source)
    type(solve_state), intent(inout) :: state
    real(real64), intent(in) :: modulus
    integer, intent(in) :: k, i, source(:)
    type(near_field) :: here, there
    type(shift_law) :: law
    real(real64) :: x, y, far_lift, far_x, far_y, off, off_before, move_x, move_y, part, trial_x
    real(real64) :: trial_y, root_x, root_y, most
    integer :: step, cut

    root_x = state%field%x(k) - state%shift_x(i)
    root_y = state%field%y(k) - state%shift_y(i)
    x = state%shift_x(i)
    y = state%shift_y(i)
    call feel(state, modulus, source, root_x + x, root_y + y, here)
    far_lift = state%field%lift(k) - here%lift
    far_x = state%field%tilt_x(k) - here%tilt_x
    far_y = state%field%tilt_y(k) - here%tilt_y
    call shift_by_tilt(state%field%radius(k), 0.0_real64, far_x + here%tilt_x, &
                       far_y + here%tilt_y, law)
    most = 1.0e-13_real64 * state%field%radius(k)
    do step = 1, most_steps
      off_before = hypot(law%x - x, law%y - y)
      if (.not. off_before > most * hypot(far_x + here%tilt_x, far_y + here%tilt_y)) exit
      call moved_by(law, here%bend_xx, here%bend_xy, here%bend_yy, law%x - x, law%y - y, &
                    move_x, move_y)
      part = 1.0_real64
      do cut = 1, 12
        trial_x = x + part * move_x
        trial_y = y + part * move_y
        call feel(state, modulus, source, root_x + trial_x, root_y + trial_y, there)
        call shift_by_tilt(state%field%radius(k), 0.0_real64, far_x + there%tilt_x, &
                           far_y + there%tilt_y, law)
        off = hypot(law%x - trial_x, law%y - trial_y)
        if (off <= (1.0_real64 - 0.3_real64 * part) * off_before) exit
        part = 0.4_real64 * part
      end do
      x = trial_x
      y = trial_y
      here = there
    end do
    state%field%lift(k) = far_lift + here%lift + far_x * (x - state%shift_x(i)) + &
                          far_y * (y - state%shift_y(i))
    state%field%tilt_x(k) = far_x + here%tilt_x
    state%field%tilt_y(k) = far_y + here%tilt_y
    state%field%x(k) = root_x + x
    state%field%y(k) = root_y + y
    state%shift_x(i) = x
    state%shift_y(i) = y
  end subroutine settle

  ! The field of some contacts at a place.
  pure subroutine feel(state, modulus, source, x, y, here)
    type(solve_state), intent(in) :: state
    real(real64), intent(in) :: modulus, x, y
    integer, intent(in) :: source(:)
    type(near_field), intent(out) :: here
    type(mutual_terms) :: terms
    real(real64) :: dx, dy, r, load, slope, along
    integer :: j, k

    do k = 1, size(source)
      j = source(k)
      dx = x - state%field%x(j)
      dy = y - state%field%y(j)
      r = hypot(dx, dy)
      call mutual_displacement(r, 0.0_real64, state%field%circle(j), terms)
      load = state%field%load(j) / modulus
      here%lift = here%lift + load * terms%on_first
      slope = load * terms%bend
      along = 0.0_real64
      if (r > 0.0_real64) then
        slope = load * (terms%slope / r)
        along = (load * terms%bend - slope) / r**2
        here%tilt_x = here%tilt_x + slope * dx
        here%tilt_y = here%tilt_y + slope * dy
      end if
      here%bend_xx = here%bend_xx + slope + along * dx * dx
      here%bend_xy = here%bend_xy + along * dx * dy
      here%bend_yy = here%bend_yy + slope + along * dy * dy
    end do
  end subroutine feel

end module asperity_coupled_open
