!> The full Newton step of coupled contacts: loads, shifts and closing at once.
!>
!> Unknowns are the loads V, times the diagonal d so that they count as penetrations, the shifts s,
!> times a weight, and the closing. With t the tilt, l the slope of the lift, G the mutual energy of
!> two contacts for unit loads, primes for derivatives by place:
!>   d_i dV_i + sum C_ij dV_j + (l_i + s_i/R_i) ds_i - sum V_j M'_ij ds_j - d closing = off_i
!>   ds_i + Q_i dt_i - (own circle) = shift_i - s_i
!>   dt_i = sum V_j G''_ij (ds_i - ds_j) + sum (dt_i/dV_j) dV_j + 3 (l_i - t_i) d(log a_i).
!> The last holds as V_i M_ij is the derivative of V_i V_j G_ij, with V as the cube of a.
module asperity_coupled_newton
  use asperity_coupled_equations, only: add_image, begin, end_of_space, krylov_space, make_room, &
                                        multiply, next_direction
  use asperity_coupled_state, only: solve_state
  use asperity_kinds, only: real64
  implicit none
  private

  public :: full_step

  integer, parameter :: most_directions = 60

contains

  !> Finds the step.
  pure subroutine full_step(state, off, shift_x, shift_y, diagonal, weight, accuracy, step)
    type(solve_state), intent(in) :: state       !! where it stands
    real(real64), intent(in) :: off(:)           !! what the penetrations are off
    real(real64), intent(in) :: shift_x(:)       !! where the circles should be
    real(real64), intent(in) :: shift_y(:)       !! where the circles should be
    real(real64), intent(in) :: diagonal(:)      !! d, by place in the order
    real(real64), intent(in) :: weight           !! of the shifts
    real(real64), intent(in) :: accuracy         !! of the equations, relative
    real(real64), intent(out) :: step(:)         !! penetrations, weighted shifts, closing
    type(krylov_space) :: space
    real(real64) :: rhs(size(step)), direction(size(step)), left, softness
    logical :: with_load
    integer :: i, k, m

    m = state%field%loaded
    with_load = state%target > 0.0_real64
    softness = sum(1.0_real64 / diagonal)
    rhs = 0.0_real64
    do k = 1, m
      i = state%order(k)
      rhs(k) = off(k)
      rhs(m + k) = weight * (shift_x(k) - state%shift_x(i))
      rhs(2 * m + k) = weight * (shift_y(k) - state%shift_y(i))
    end do
    if (with_load) rhs(3 * m + 1) = (state%target - sum(state%normal(:m))) / softness
    call make_room(space, size(step), min(most_directions, 3 * m + 1))
    call begin(space, rhs, accuracy)
    do while (.not. space%done)
      call next_direction(space, direction)
      call apply(state, diagonal, weight, softness, direction, rhs)
      call add_image(space, rhs)
    end do
    call end_of_space(space, step, left)
    step(:m) = step(:m) / (diagonal * state%stiffness(:m))
    if (.not. with_load) step(3 * m + 1) = 0.0_real64
  end subroutine full_step

  ! The matrix times a direction.
  pure subroutine apply(state, diagonal, weight, softness, direction, image)
    type(solve_state), intent(in) :: state
    real(real64), intent(in) :: diagonal(:), weight, softness, direction(:)
    real(real64), intent(out) :: image(:)
    real(real64), dimension(state%field%loaded) :: load, lift, move_x, move_y, turn_x, turn_y
    real(real64) :: widened, x, y
    integer :: i, j, k, m

    m = state%field%loaded
    load = direction(:m) / diagonal
    move_x = direction(m + 1:2 * m) / weight
    move_y = direction(2 * m + 1:3 * m) / weight
    call multiply(state%field%compliance, load, lift)
    associate (field => state%field, law => state%law)
      do k = 1, m
        i = state%order(k)
        lift(k) = lift(k) + direction(k) - direction(3 * m + 1) + &
                  (field%tilt_x(k) + field%lean_x(k) + state%shift_x(i) / field%radius(k)) * &
                  move_x(k) + &
                  (field%tilt_y(k) + field%lean_y(k) + state%shift_y(i) / field%radius(k)) * &
                  move_y(k)
        widened = 0.5_real64 * field%radius(k) / field%circle(k)**2 * load(k) / state%stiffness(k)
        turn_x(k) = field%bend_xx(k) * move_x(k) + field%bend_xy(k) * move_y(k) + &
                    3 * field%lean_x(k) * widened
        turn_y(k) = field%bend_xy(k) * move_x(k) + field%bend_yy(k) * move_y(k) + &
                    3 * field%lean_y(k) * widened
      end do
      do k = 1, field%near_pairs
        i = field%near(k)%first
        if (i > m) cycle
        j = field%near(k)%second
        associate (pair => field%near(k))
          lift(i) = lift(i) - field%load(j) * (pair%first_x * move_x(j) + pair%first_y * move_y(j))
          lift(j) = lift(j) + field%load(i) * (pair%second_x * move_x(i) + &
                                               pair%second_y * move_y(i))
          turn_x(i) = turn_x(i) + pair%second_x * load(j) - &
                      field%load(j) * (pair%bend_xx * move_x(j) + pair%bend_xy * move_y(j))
          turn_y(i) = turn_y(i) + pair%second_y * load(j) - &
                      field%load(j) * (pair%bend_xy * move_x(j) + pair%bend_yy * move_y(j))
          turn_x(j) = turn_x(j) - pair%first_x * load(i) - &
                      field%load(i) * (pair%bend_xx * move_x(i) + pair%bend_xy * move_y(i))
          turn_y(j) = turn_y(j) - pair%first_y * load(i) - &
                      field%load(i) * (pair%bend_xy * move_x(i) + pair%bend_yy * move_y(i))
        end associate
      end do
      do k = 1, m
        widened = 0.5_real64 * field%radius(k) / field%circle(k)**2 * load(k) / state%stiffness(k)
        x = move_x(k) + law(k)%turn_xx * turn_x(k) + law(k)%turn_xy * turn_y(k) - &
            law(k)%grown_x * widened
        y = move_y(k) + law(k)%turn_xy * turn_x(k) + law(k)%turn_yy * turn_y(k) - &
            law(k)%grown_y * widened
        image(k) = lift(k)
        image(m + k) = weight * x
        image(2 * m + k) = weight * y
      end do
      image(3 * m + 1) = 0.0_real64
      if (state%target > 0.0_real64) &
        image(3 * m + 1) = sum(load * (state%normal(:m) / field%load(:m))) / softness
    end associate
  end subroutine apply

end module asperity_coupled_newton
