!> One Newton step of coupled contacts.
module asperity_coupled_step
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_equations, only: solve_equations
  use asperity_coupled_field, only: contact_field
  use asperity_coupled_state, only: share_of_shift, solve_state
  use asperity_kinds, only: real64
  implicit none
  private

  public :: propose, take

contains

  ! One step of Newton's method.
  pure subroutine propose(pairs, state, off, shift_x, shift_y, residual, step)
    type(contact_pairs), intent(in) :: pairs
    type(solve_state), intent(inout) :: state
    real(real64), intent(in) :: off(:), shift_x(:), shift_y(:), residual
    real(real64), allocatable, intent(out) :: step(:)
    real(real64), allocatable :: diagonal(:), safe(:), change(:), reply(:), ones(:)
    real(real64) :: accuracy, grown, lacking, wanted, weight, closing_step
    logical :: definite
    integer :: i, k, m

    m = state%field%loaded
    allocate (diagonal(m), safe(m), change(m), reply(m), ones(m))
    do k = 1, m
      ! A wider circle means the neighbours' field over a wider one: d(radius)/dp = R/(2 radius).
      grown = 0.5_real64 * pairs%list(state%order(k))%radius / state%field%circle(k)**2 * &
              state%field%growth(k)
      ! Where circles overlap it falls. Two contacts stay definite with the last of these.
      diagonal(k) = max((1.0_real64 + max(grown, -0.7_real64)) / state%stiffness(k), &
                        1.05_real64 * state%field%strongest(k))
      safe(k) = (1.0_real64 + max(grown, 0.05_real64)) / state%stiffness(k)
    end do
    ! The matrix leaves out second-order terms: a finer solution would not be a better step.
    accuracy = max(1.0e-6_real64, min(1.0e-3_real64, 0.01_real64 * residual))
    call solve_equations(diagonal, state%field%compliance, off(:m), accuracy, change, definite)
    if (.not. definite) then
      diagonal = safe
      call solve_equations(diagonal, state%field%compliance, off(:m), accuracy, change, definite)
    end if
    closing_step = 0.0_real64
    if (state%target > 0.0_real64) then
      if (.not. state%has_reply) then
        ones = [(1.0_real64, k=1, m)]
        call solve_equations(diagonal, state%field%compliance, ones, accuracy, reply, definite)
        state%reply(:m) = reply
        state%has_reply = residual < 0.05_real64 .and. state%awake > 64
      end if
      reply = state%reply(:m)
      lacking = state%target - sum(state%normal(:m))
      wanted = lacking - sum(change * state%normal(:m) / state%field%load(:m))
      closing_step = wanted / sum(reply * state%normal(:m) / state%field%load(:m))
      closing_step = min(closing_step, state%most_closing - state%closing)
      change = change + closing_step * reply
    end if
    weight = weight_of_shift(state)
    allocate (step(3 * m + 1))
    do k = 1, m
      i = state%order(k)
      step(k) = change(k) / state%stiffness(k)
      call shift_step(pairs%list(i)%radius, state%field, k, shift_x(k) - state%shift_x(i), &
                      shift_y(k) - state%shift_y(i), step(m + k), step(2 * m + k))
    end do
    step(m + 1:3 * m) = weight * step(m + 1:3 * m)
    step(3 * m + 1) = closing_step
  end subroutine propose

  ! How far a circle moves when it is off by (x, y): Newton's method with the bend of the
  ! neighbours' surface. The bend holds what the neighbour moves the other way.
  pure subroutine shift_step(radius, field, k, x, y, move_x, move_y)
    real(real64), intent(in) :: radius, x, y
    type(contact_field), intent(in) :: field
    integer, intent(in) :: k
    real(real64), intent(out) :: move_x, move_y
    real(real64) :: xx, xy, yy, mean, half, most, scale

    scale = share_of_shift(hypot(field%tilt_x(k), field%tilt_y(k)) * radius, field%circle(k))
    scale = radius * scale
    xx = 1.0_real64 + scale * field%bend_xx(k)
    xy = scale * field%bend_xy(k)
    yy = 1.0_real64 + scale * field%bend_yy(k)
    mean = 0.5_real64 * (xx + yy)
    half = hypot(0.5_real64 * (xx - yy), xy)
    ! The lesser eigenvalue is kept away from zero.
    scale = max(0.0_real64, 0.3_real64 - (mean - half))
    xx = xx + scale
    yy = yy + scale
    most = xx * yy - xy * xy
    move_x = (yy * x - xy * y) / most
    move_y = (xx * y - xy * x) / most
  end subroutine shift_step

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
      state%shift_x(i) = 0.0_real64
      state%shift_y(i) = 0.0_real64
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
