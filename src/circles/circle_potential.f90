!> Change of the potential energy of coupled contacts between two states.
!>
!> It is the mean of both gradients times the change of the state, exact to third order: near a
!> solution the difference of two potentials would be smaller than their rounding errors (as in the
!> approximate Wolfe conditions of Hager and Zhang, SIAM J. Optim. 16 (2005) 170). The energy of a
!> contact by its law is integrated.
!>
!> An open contact is at its largest penetration p0 without a load: 0, or that of the residual depth
!> after plastic flow. With dPhi/dV = p + w - c, a contact that opens or touches has the energy of
!> its law from p0 on, and the gradient p0 + w - c where it is open. With another penetration there
!> the change by a load V would be in error by p0 V, more than the decrease of a step that releases
!> a flattened contact: the trust region would shrink to nothing about a state that is no solution.
module asperity_circle_potential
  use asperity_circle_field, only: circle_set, inclination_factor, large_set, rounding_error, &
                                   sum_error
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_state, only: answer_at, coupled_solution, penetration_without_load, &
                                    solve_state
  use asperity_kinds, only: real64
  implicit none
  private

  public :: potential_change, potential_state, remember_state, restore_state

  !> Copy of a state with its circles, their field and the gradient of the potential.
  type :: potential_state
    real(real64), allocatable :: penetration(:)   !! by pair [length], > 0 where loaded
    logical, allocatable :: stays_open(:)         !! by pair: open at any compression
    real(real64), allocatable :: shift(:, :)      !! lateral shifts (2, pair) [length]
    real(real64) :: compression = 0.0_real64      !! compression [length]
    type(circle_set) :: set                       !! circles and their field
    type(solve_state) :: state                    !! gradient and residual
  end type potential_state

contains

  !> Copies a state.
  subroutine remember_state(solution, state, before)
    type(coupled_solution), intent(in) :: solution   !! loads, shifts and field are set
    type(solve_state), intent(in) :: state           !! gradient and residual of it
    type(potential_state), intent(out) :: before     !! copy of the state

    before%penetration = solution%penetration
    before%stays_open = solution%stays_open
    before%shift = solution%shift
    before%compression = solution%compression
    before%set = solution%set
    before%state = state
  end subroutine remember_state

  !> Goes back to a copied state.
  subroutine restore_state(before, solution, state)
    type(potential_state), intent(in) :: before        !! copy of the state
    type(coupled_solution), intent(inout) :: solution  !! gets all but its counts
    type(solve_state), intent(inout) :: state          !! gets its gradient

    solution%penetration = before%penetration
    solution%stays_open = before%stays_open
    solution%shift = before%shift
    solution%compression = before%compression
    solution%set = before%set
    state = before%state
  end subroutine restore_state

  !> Potential of a state less that of an earlier one, at the compression of the earlier one.
  subroutine potential_change(pairs, law, before, solution, state, change, noise)
    type(contact_pairs), intent(in) :: pairs           !! pairs of the position
    class(contact_law), intent(in) :: law              !! of each contact
    type(potential_state), intent(in) :: before        !! the earlier state
    type(coupled_solution), intent(in) :: solution     !! the state, evaluated
    type(solve_state), intent(in) :: state             !! gradient and residual of it
    real(real64), intent(out) :: change                !! of the potential
    real(real64), intent(out) :: noise                 !! rounding and summation error of the change
    integer :: circle(size(before%penetration), 2), i, k
    integer, allocatable :: loaded(:)   ! pairs with a circle in one of the states
    real(real64), allocatable :: load(:, :), part(:)
    real(real64) :: gradient(2), penetration(2), relative

    circle = 0
    circle(before%set%contact, 1) = [(k, k=1, size(before%set%contact))]
    circle(solution%set%contact, 2) = [(k, k=1, size(solution%set%contact))]
    loaded = pack([(i, i=1, size(circle, 1))], circle(:, 1) + circle(:, 2) > 0)
    allocate (load(2, size(loaded)), part(size(loaded)))
    load = 0.0_real64
    !$omp parallel do schedule(static) private(i, gradient, penetration) &
    !$omp   if(size(loaded) > large_set)
    do k = 1, size(loaded)
      i = loaded(k)
      gradient = 0.0_real64
      penetration = [before%penetration(i), solution%penetration(i)]
      if (circle(i, 1) > 0) then
        load(1, k) = before%set%load(circle(i, 1))
        gradient(1) = before%state%load_gradient(circle(i, 1))
      end if
      if (circle(i, 2) > 0) then
        load(2, k) = solution%set%load(circle(i, 2))
        gradient(2) = state%load_gradient(circle(i, 2)) + &
                      (solution%compression - before%compression)
      end if
      ! No field is known at an open contact: that of the other state is taken.
      if (circle(i, 1) == 0) then
        penetration(1) = penetration_without_load(pairs, law, i, penetration(2))
        gradient(1) = gradient(2) - penetration(2) + penetration(1)
      else if (circle(i, 2) == 0) then
        penetration(2) = penetration_without_load(pairs, law, i, penetration(1))
        gradient(2) = gradient(1) - penetration(1) + penetration(2)
      end if
      part(k) = 0.5_real64 * sum(gradient) * (load(2, k) - load(1, k)) + &
                excess_work(pairs, law, i, penetration(1), penetration(2))
      if (all(circle(i, :) > 0)) part(k) = part(k) + 0.5_real64 * dot_product( &
        load(1, k) * before%state%shift_gradient(:, circle(i, 1)) + &
        load(2, k) * state%shift_gradient(:, circle(i, 2)), solution%shift(:, i) - &
          before%shift(:, i))
    end do
    !$omp end parallel do
    change = sum(part)
    relative = merge(sum_error, rounding_error, size(before%set%x) > large_set)
    noise = relative * max(abs(before%compression), abs(solution%compression)) * &
            sum(abs(load(2, :) - load(1, :)))
  end subroutine potential_change

  ! Change of p times the mean load of both ends, less the integral of the load over p by Simpson's
  ! rule, which is exact to third order as the mean gradient is.
  real(real64) function excess_work(pairs, law, i, from, to)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    integer, intent(in) :: i
    real(real64), intent(in) :: from, to

    excess_work = (to - from) / 3 * (load_at(pairs, law, i, from) + load_at(pairs, law, i, to) - &
                                     2 * load_at(pairs, law, i, 0.5_real64 * (from + to)))
  end function excess_work

  ! Load V of the potential: over the modulus, times the factor of an inclined contact.
  real(real64) function load_at(pairs, law, i, p) result(load)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    integer, intent(in) :: i
    real(real64), intent(in) :: p
    type(contact_response) :: answer

    load = 0.0_real64
    if (.not. p > 0.0_real64) return
    answer = answer_at(pairs, law, i, p)
    load = answer%vertical_load * inclination_factor(answer%cosine) / pairs%modulus
  end function load_at

end module asperity_circle_potential
