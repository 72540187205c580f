!> Interacting Hertzian contacts: the loads and lateral shifts that minimise one potential.
!>
!> Problem: minimise Phi(V, s) of circle_field over loads V >= 0 and shifts s. For a loaded contact
!> i this is p_i = c - g_i - h_i - u_i, with c the compression, g gap, u_i the displacement by its
!> neighbours and h_i = s_i**2/(2 R_i) at its shift s_i = -R_i times the slope of the field. A given
!> load is a constraint that every state meets: all penetrations change by one amount until it is
!> met (a retraction; Absil, Mahony and Sepulchre, Optimization Algorithms on Matrix Manifolds,
!> 2008, chapter 7), and c is the mean of the equations, weighted by the stiffness.
!>
!> Method: trust region with truncated conjugate gradients (circle_step; Nocedal and Wright,
!> Numerical Optimization, 2006, algorithm 4.1). Far from the solution the model is convex: every
!> bounded model converges (Conn, Gould and Toint, Trust-Region Methods, 2000, theorem 6.4.6). Where
!> a step has left more than a share of the residual, or contacts are activated, the contacts with
!> the largest residuals are first solved in the field of the others (nonlinear elimination; Cai and
!> Li, SIAM J. Sci. Comput. 33 (2011) 746). Active set: a contact is released where its penetration
!> falls to 0; open contacts that touch are activated with the largest share 1, 1/2, 1/4, ... of
!> their penetration with which the potential does not increase (Armijo's backtracking).
!>
!> Exits: the residual is small enough and no open contact touches (converged); compression beyond
!> the complete pair list (the caller repeats); two steps without a decrease, or too many steps (not
!> converged); no memory, interrupted (failure).
module asperity_coupled_contacts
  use asperity_circle_field, only: bytes_of_circle, large_set, least_curvature_share, &
                                   linear_residual, rounding_error, sum_error
  use asperity_circle_potential, only: potential_change, potential_state, remember_state, &
                                       restore_state
  use asperity_circle_step, only: circle_model, find_step, prepare_model, trust_step
  use asperity_contact_law, only: contact_law
  use asperity_contact_pairs, only: contact_pairs, in_scene_units
  use asperity_coupled_groups, only: extract_group, find_groups, group_law, insert_group, &
                                     solve_single
  use asperity_coupled_start, only: few_contacts, prepare_start, scale_start
  use asperity_coupled_state, only: coupled_solution, evaluate_state, find_carried_load, &
                                    penetration_without_load, raise_to_load, resolved_contacts, &
                                    solve_state, update_circles
  use asperity_element_forces, only: iterations_allowed
  use asperity_hidden_contacts, only: release_hidden
  use asperity_kinds, only: real64
  use asperity_open_contacts, only: find_touching, may_touch
  use asperity_problems, only: real_text
  use asperity_process, only: check_memory
  implicit none
  private

  public :: adopt_penetrations, coupled_solution, resolved_contacts, solve_coupled

  ! Residual over the largest penetration [1] of a solution; derived: the displacements of hundreds
  ! of circles are in error by so much.
  real(real64), parameter :: target_residual = 100 * rounding_error
  !> The same where the residual stagnates, and of a large set [1]; derived from the error of sums.
  real(real64), parameter, public :: accepted_residual = sum_error / 10
  ! Largest forcing term [1] of a step; Eisenstat and Walker 1996.
  real(real64), parameter :: largest_forcing = 0.9_real64
  ! Share of a residual [1] that is small beside it: where a step leaves more, or activation, the
  ! contacts with larger errors are eliminated, their groups are solved to so much of it, and after
  ! such a decrease open contacts are examined again; measured: with 1 for the last of these 1e5
  ! caps take 7 % longer; test: coupled_suite.f90.
  real(real64), parameter :: residual_share = 0.1_real64
  ! Ratios of the actual to the predicted decrease [1]: above the first a step is accepted, below
  ! the second the region shrinks to a quarter of the step, above the third it grows to twice the
  ! step; Nocedal and Wright 2006, algorithm 4.1.
  real(real64), parameter :: trust_ratios(3) = [0.1_real64, 0.25_real64, 0.75_real64]

contains

  ! Long: one iteration with all its exits.

  !> Solves at a given compression or, where `target` is present, at a total load: the normal or the
  !> vertical one, by `pairs%vertical`.
  recursive subroutine solve_coupled(pairs, law, solution, target, resolved, group_residual)
    type(contact_pairs), intent(in) :: pairs           !! those that may touch, ascending gap
    class(contact_law), intent(in), target :: law      !! of each contact
    !> compression: given, or found where there is a target; penetrations and shifts: a start where
    !> allocated
    type(coupled_solution), intent(inout) :: solution
    real(real64), intent(in), optional :: target       !! total load [force], more than 0
    type(resolved_contacts), intent(in), optional :: resolved
    !> the contacts are a group in the field of others: residual that suffices
    real(real64), intent(in), optional :: group_residual
    type(solve_state) :: state
    type(potential_state) :: before
    real(real64) :: attainable, carried, examined_residual, last_residual, radius, required, slope
    integer :: failed_steps, loaded, step_limit
    ! The decisions of an iteration.
    logical :: is_solved       ! the equations of the loaded contacts hold
    logical :: examines_open   ! open contacts are examined: they may touch
    logical :: none_touches    ! no open contact touched at the last examination
    logical :: eliminates      ! contacts with large residuals are solved before the step
    logical :: is_taken        ! the step has reduced the potential
    logical :: was_complete    ! all open contacts were examined in a solved state
    logical :: has_final_lists ! the near pairs are those of the solution
    logical :: any_released, is_start

    call check_memory('the contacts', solution%failure, bytes=bytes_of_circle * size(pairs%list))
    if (allocated(solution%failure)) return
    is_start = .not. (allocated(solution%penetration) .or. present(resolved))
    call prepare_start(pairs, law, solution, state, target, resolved)
    if (pairs%interrupt%is_asked()) solution%failure = 'interrupted'
    if (allocated(solution%failure)) return
    if (is_start) then
      call update_circles(pairs, law, solution, state)
      if (allocated(solution%failure)) return
      call release_hidden(pairs, solution, any_released)
      if (any_released .and. present(target)) &
        call raise_to_load(pairs, law, state%target, solution)
    end if
    call evaluate_state(pairs, law, solution, state, resolved)
    if (is_start .and. .not. present(target) .and. size(solution%set%x) <= few_contacts) &
      call scale_start(pairs, law, solution, state)
    step_limit = iterations_allowed
    if (present(group_residual)) step_limit = digits(radius)
    none_touches = .false.
    eliminates = .false.
    has_final_lists = .false.
    was_complete = .false.
    failed_steps = 0
    examined_residual = huge(examined_residual)
    last_residual = huge(last_residual)
    radius = 0.0_real64
    do
      if (pairs%interrupt%is_asked()) solution%failure = 'interrupted'
      if (allocated(solution%failure)) return
      attainable = merge(accepted_residual, target_residual, failed_steps > 0 .or. &
                         .not. state%residual < last_residual)
      required = merge(accepted_residual, attainable, size(solution%set%x) > large_set)
      if (present(group_residual)) required = max(required, group_residual)
      ! The pair list is complete only up to this compression. Beyond it the solution is invalid;
      ! the caller repeats the solve with all pairs.
      if (solution%compression > pairs%complete_to .and. state%residual < linear_residual) exit
      is_solved = state%residual <= required
      examines_open = is_solved
      if (state%residual < residual_share * examined_residual) &
        examines_open = is_solved .or. .not. none_touches .or. may_touch(solution, state)
      if (examines_open) then
        examined_residual = state%residual
        call activate_touching(pairs, law, attainable, is_solved .and. .not. was_complete, &
                               solution, state, resolved, none_touches)
        if (allocated(solution%failure)) return
        was_complete = was_complete .or. is_solved
        if (is_solved .and. none_touches) exit
        ! Activated contacts are far from their loads: elimination finds these first.
        if (state%residual > residual_share * examined_residual .and. .not. none_touches) &
          eliminates = .not. present(group_residual)
      end if
      if (failed_steps > 1 .or. solution%ending%iterations >= step_limit) exit
      loaded = size(solution%set%x)
      if (eliminates) call eliminate_contacts(pairs, law, solution, state, resolved)
      if (allocated(solution%failure)) return
      none_touches = none_touches .and. size(solution%set%x) >= loaded
      call remember_state(solution, state, before)
      call take_step(pairs, law, before, radius, solution, state, resolved, is_taken)
      if (allocated(solution%failure)) return
      failed_steps = merge(0, failed_steps + 1, is_taken)
      last_residual = before%state%residual
      solution%ending%iterations = solution%ending%iterations + 1
      none_touches = none_touches .and. size(solution%set%x) >= size(before%set%x)
      ! At the end the near pairs are those of the solution, whatever the start (test: loads in
      ! random order in test/contact/test_solve_again.py). Once only: a pair on the border may
      ! enter and leave the lists.
      if (state%residual < linear_residual .and. .not. has_final_lists) then
        has_final_lists = .true.
        state%rebuilds_lists = size(solution%set%x) <= large_set
      end if
      eliminates = .not. present(group_residual) .and. &
                   state%residual > max(residual_share * last_residual, accepted_residual)
    end do
    solution%ending%residual = state%residual
    solution%ending%converged = state%residual <= max(accepted_residual, required) .and. &
      none_touches
    if (solution%compression > pairs%complete_to) solution%ending%converged = .true.
    if (.not. present(target)) return
    call find_carried_load(pairs, law, solution, 0.0_real64, carried, slope)
    if (.not. carried >= (1.0_real64 - accepted_residual) * state%target) solution%failure = &
      'the load is larger than the surfaces carry before the centres of two asperities are ' // &
      'level: ' // real_text(in_scene_units(pairs, carried * pairs%modulus, 1, 2)) // ' at most'
  end subroutine solve_coupled

  !> Finds circles and field of given penetrations, and the gaps of resolved contacts with which
  !> the equations hold for them.
  subroutine adopt_penetrations(pairs, law, solution, resolved)
    type(contact_pairs), intent(in) :: pairs               !! pairs of the position
    class(contact_law), intent(in) :: law                  !! of each contact
    type(coupled_solution), intent(inout) :: solution      !! penetrations; gets circles and field
    type(resolved_contacts), intent(inout) :: resolved     !! gets its gaps
    type(solve_state) :: state
    integer :: i, k

    state%gap = pairs%list%gap
    call evaluate_state(pairs, law, solution, state, resolved)
    do k = 1, size(solution%set%contact)
      i = solution%set%contact(k)
      if (resolved%is_resolved(i)) resolved%gap(i) = &
        solution%compression - solution%set%displacement(k) - solution%penetration(i)
    end do
  end subroutine adopt_penetrations

  ! Activates open contacts that touch, as far as the potential does not increase.
  subroutine activate_touching(pairs, law, accuracy, is_complete, solution, state, resolved, &
                               none_touches)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    real(real64), intent(in) :: accuracy
    logical, intent(in) :: is_complete
    type(coupled_solution), intent(inout) :: solution
    type(solve_state), intent(inout) :: state
    type(resolved_contacts), intent(in), optional :: resolved
    logical, intent(out) :: none_touches
    type(potential_state) :: before
    integer, allocatable :: contact(:)
    real(real64), allocatable :: deep(:), unloaded(:)
    integer :: halving
    real(real64) :: change, noise

    call find_touching(pairs, law, accuracy, is_complete, solution, state, resolved, contact)
    none_touches = size(contact) == 0
    if (allocated(solution%failure) .or. none_touches) return
    allocate (deep, source=solution%penetration(contact))
    allocate (unloaded(size(contact)))
    unloaded = penetration_without_load(pairs, law, contact, deep)
    solution%penetration(contact) = 0.0_real64
    call remember_state(solution, state, before)
    do halving = 0, digits(change)
      solution%penetration = before%penetration
      solution%penetration(contact) = unloaded + (deep - unloaded) * 0.5_real64**halving
      if (state%target > 0.0_real64) &
        call raise_to_load(pairs, law, state%target, solution)
      call evaluate_state(pairs, law, solution, state, resolved)
      if (allocated(solution%failure)) return
      if (size(before%set%x) == 0) return
      call potential_change(pairs, law, before, solution, state, change, noise)
      if (change <= noise) return
    end do
    call restore_state(before, solution, state)
    none_touches = .true.
  end subroutine activate_touching

  ! Nonlinear elimination: solves contacts with large residuals in the field of the others, group by
  ! group. The result is kept where the potential does not increase: a residual alone may decrease
  ! because contacts have opened.
  recursive subroutine eliminate_contacts(pairs, law, solution, state, resolved)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in), target :: law
    type(coupled_solution), intent(inout) :: solution
    type(solve_state), intent(inout) :: state
    type(resolved_contacts), intent(in), optional :: resolved
    type(potential_state) :: before
    integer, allocatable :: member(:), first(:)
    real(real64) :: change, noise
    integer :: k

    call find_groups(solution%set, state%contact_residual, residual_share, member, first)
    if (size(member) == 0) return
    ! Where most of many contacts have large residuals, a step of all needs fewer fields.
    if (size(state%contact_residual) > large_set .and. &
        2 * size(member) > size(state%contact_residual)) return
    call remember_state(solution, state, before)
    !$omp parallel do schedule(dynamic)
    do k = 1, size(first) - 1
      call solve_group(pairs, law, before%state, member(first(k):first(k + 1) - 1), solution)
    end do
    !$omp end parallel do
    if (state%target > 0.0_real64) &
      call raise_to_load(pairs, law, state%target, solution)
    call evaluate_state(pairs, law, solution, state, resolved)
    if (allocated(solution%failure)) return
    call potential_change(pairs, law, before, solution, state, change, noise)
    if (change <= noise) return
    call restore_state(before, solution, state)
  end subroutine eliminate_contacts

  ! Solves one group in the field of all other contacts.
  recursive subroutine solve_group(pairs, law, state, member, solution)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in), target :: law
    type(solve_state), intent(in) :: state
    integer, intent(in) :: member(:)
    type(coupled_solution), intent(inout) :: solution
    type(contact_pairs) :: group_pairs
    type(group_law) :: law_of_group
    type(coupled_solution) :: group

    if (size(member) == 1) then
      call solve_single(state, member(1), solution)
      return
    end if
    call extract_group(pairs, law, solution, state, member, group_pairs, law_of_group, group)
    call solve_coupled(group_pairs, law_of_group, group, group_residual= &
                       residual_share * state%residual)
    if (.not. allocated(group%failure)) &
      call insert_group(pairs, member, group_pairs, law_of_group, group, solution)
  end subroutine solve_group

  ! Takes one step. The region shrinks until the decrease of the potential is a share of the
  ! predicted one, or less than its rounding error.
  subroutine take_step(pairs, law, before, radius, solution, state, resolved, is_taken)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(potential_state), intent(in) :: before
    real(real64), intent(inout) :: radius
    type(coupled_solution), intent(inout) :: solution
    type(solve_state), intent(inout) :: state
    type(resolved_contacts), intent(in), optional :: resolved
    logical, intent(out) :: is_taken
    type(circle_model) :: model
    type(trust_step) :: step
    real(real64) :: change, forcing, noise, ratio
    integer :: n

    n = size(before%set%x)
    is_taken = .false.
    if (n == 0) return
    allocate (model%gradient(3, n))
    model%gradient(1, :) = before%state%load_gradient
    model%gradient(2:, :) = spread(before%set%load, 1, 2) * before%state%shift_gradient
    model%keep_sum = state%target > 0.0_real64
    forcing = forcing_term(before%state%residual)
    model%convex = forcing > least_curvature_share
    call prepare_model(solution%set, model)
    ! The last step of a large set need not go below the accepted residual.
    if (n > large_set) &
      forcing = max(forcing, trust_ratios(1) * accepted_residual / before%state%residual)
    do
      call find_step(solution%set, model, forcing, radius, step, solution%products, pairs%interrupt)
      if (.not. step%decrease > 0.0_real64 .or. pairs%interrupt%is_asked()) return
      associate (contact => before%set%contact)
        solution%penetration = before%penetration
        solution%penetration(contact) = penetration_after(before%penetration(contact), &
          before%set%load, before%set%stiffness, step%change(1, :))
        solution%shift(:, contact) = before%shift(:, contact) + step%change(2:, :)
      end associate
      if (state%target > 0.0_real64) &
        call raise_to_load(pairs, law, state%target, solution)
      call evaluate_state(pairs, law, solution, state, resolved)
      if (allocated(solution%failure)) return
      call potential_change(pairs, law, before, solution, state, change, noise)
      ratio = -change / step%decrease
      if (.not. ratio >= trust_ratios(2)) then
        radius = 0.25_real64 * step%length
      else if (ratio > trust_ratios(3) .and. step%at_border) then
        radius = 2 * step%length
      end if
      is_taken = ratio > trust_ratios(1)
      if (is_taken) return
      call restore_state(before, solution, state)
      state%rebuilds_lists = .false.
      if (before%state%residual <= accepted_residual) return
      if (.not. step%decrease > noise) return
      if (.not. model%convex) then
        model%convex = .true.
        call prepare_model(solution%set, model)
      end if
    end do
  end subroutine take_step

  ! Share of the equations that a step leaves (Eisenstat and Walker, SIAM J. Sci. Comput. 17 (1996)
  ! 16): the root of the residual, for a rate of 3/2.
  pure real(real64) function forcing_term(residual) result(share)
    real(real64), intent(in) :: residual

    share = min(largest_forcing, max(linear_residual, sqrt(residual)))
  end function forcing_term

  ! Penetration at a changed load, to first order p + dV/k, k stiffness. Where the load increases it
  ! follows a power law, V ~ p**(k p/V), exact for Hertz' law: along the tangent small loads would
  ! become far too large. Where the load decreases the tangent is above the law.
  elemental real(real64) function penetration_after(p, load, stiffness, change) result(after)
    real(real64), intent(in) :: p, load, stiffness, change

    after = p + change / stiffness
    if (change > 0.0_real64) after = p * (1.0_real64 + change / load)**(load / (stiffness * p))
  end function penetration_after

end module asperity_coupled_contacts
