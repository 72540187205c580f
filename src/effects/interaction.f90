!> Interaction of neighbouring contacts, as an effect that a scene names.
!>
!> `coupled`: every contact is lowered by the surface displacement of its neighbours, as circles.
!> `boundary`: all are resolved on cells. `auto`: as many as the tolerance calls for.
module asperity_interaction
  use asperity_constants, only: pi
  use asperity_contact_effect, only: column, contact_effect, effect_outcome, force, length, plain
  use asperity_contact_law, only: contact_law
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: answer_all, contact_state
  use asperity_hertz_law, only: hertz_law
  use asperity_interaction_estimate, only: estimate_of_interaction
  use asperity_joint_contacts, only: joint_solution, resolve_all, resolve_called_for, &
                                     resolve_none, solve_joint
  use asperity_kinds, only: not_computed, real64
  use asperity_scene_values, only: effect_auto, effect_boundary, scene
  use asperity_theory_warnings, only: of_area, warn
  implicit none
  private

  public :: new_interaction

  !> Interaction of neighbouring contacts.
  type, extends(contact_effect) :: interaction_effect
    real(real64) :: boundary_tolerance = 0.0_real64  !! what halving the cells may change
    real(real64) :: area_tolerance = 0.0_real64      !! what areas may be off by at least
  contains
    procedure :: estimate
    procedure :: apply
    procedure :: leave_out
    procedure :: closing_at_load
  end type interaction_effect

contains

  !> Interaction as the scene names it.
  subroutine new_interaction(scene_in, effect)
    type(scene), intent(in) :: scene_in                        !! checked values
    class(contact_effect), allocatable, intent(out) :: effect  !! ready to act
    type(interaction_effect) :: new

    call new%call_as('interaction', scene_in%effects)
    new%approximates = .true.
    new%boundary_tolerance = scene_in%effects%number('boundary_tolerance')
    new%area_tolerance = scene_in%effects%number('area_tolerance')
    ! Cells come and go with the closing, which moves the load a little.
    if (any(new%mode == [effect_auto, effect_boundary])) &
      new%load_tolerance = 0.1_real64 * new%boundary_tolerance
    new%contact_columns = [ &
      column('lowered', length), &                       ! how far by its neighbours
      column('alone_load', force)]   ! vertical, without them
    new%state_columns = [ &
      column('alone_load', force), & ! sum of those of the contacts
      column('factor', plain), &   ! load together over load alone
      column('cells', plain), &                          ! how many
      column('resolved', plain), &                       ! contacts on cells
      ! left out: as much as neighbours may change
      column('area_error_estimate', plain)]
    allocate (effect, source=new)
  end subroutine new_interaction

  !> First-order estimate of the share by which neighbours lower the load.
  function estimate(self, pairs, state) result(share)
    class(interaction_effect), intent(in) :: self  !! interaction
    type(contact_pairs), intent(in) :: pairs       !! the position
    type(contact_state), intent(in) :: state       !! contacts that know nothing of each other
    real(real64) :: share

    associate (unused => self)
    end associate
    share = estimate_of_interaction(pairs, state%law, state%closing)
  end function estimate

  !> Lets the contacts lower each other.
  subroutine apply(self, pairs, state, outcome)
    class(interaction_effect), intent(in) :: self   !! interaction
    type(contact_pairs), intent(in) :: pairs        !! the position
    type(contact_state), intent(inout) :: state     !! gets the answers of contacts together
    type(effect_outcome), intent(inout) :: outcome  !! what it did
    type(joint_solution) :: solution
    real(real64) :: together, alone

    allocate (outcome%of_contacts(size(pairs%list), 2), outcome%of_state(5))
    outcome%of_state = 0.0_real64
    outcome%of_contacts(:, 2) = state%answers%vertical_load
    outcome%simulated = 'coupled'
    if (self%mode == effect_boundary) outcome%simulated = 'boundary'
    if (allocated(state%found)) then
      call unpack_solution(state%found, solution)
    else
      solution%coupled%closing = state%closing
      call solve_joint(pairs, state%law, what_to_resolve(self, state%law), &
                       min(self%tolerance, state%left), self%boundary_tolerance, solution, &
                       area_tolerance=self%area_tolerance)
    end if
    outcome%ending = solution%coupled%ending
    if (allocated(solution%failure)) then
      outcome%failure = solution%failure
      return
    end if
    if (self%mode == effect_auto .and. solution%cells > 0) then
      outcome%simulated = 'coupled+boundary'
      outcome%why = 'circles alone are not good enough'
    end if
    state%penetration = solution%coupled%penetration
    call answer_all(pairs, state)
    where (state%answers%load > 0.0_real64)
      state%answers%contact_radius = sqrt(solution%area / pi)
      where (solution%maximum_pressure > 0.0_real64) &
        state%answers%maximum_pressure = solution%maximum_pressure
    end where
    outcome%of_contacts(:, 1) = max(0.0_real64, &
                                    state%closing - pairs%list%gap - state%penetration)
    alone = sum(outcome%of_contacts(:, 2))
    together = sum(state%answers%vertical_load)
    outcome%of_state(1) = alone
    outcome%of_state(2) = 1.0_real64
    if (alone > 0.0_real64) outcome%of_state(2) = together / alone
    outcome%of_state(3) = solution%cells
    outcome%of_state(4) = count(solution%is_resolved .and. state%answers%load > 0.0_real64)
    outcome%of_state(5) = solution%area_error
    outcome%error = solution%error
    outcome%influence = outcome%of_state(2) - 1.0_real64
    outcome%influence_known = .true.
    if (self%mode == effect_auto .and. solution%area_error > self%tolerance) &
      call warn(outcome%warnings, of_area, solution%area_error)
  end subroutine apply

  !> Left out: what the contacts carry alone is known, and what they may change at most.
  subroutine leave_out(self, pairs, state, outcome)
    class(interaction_effect), intent(in) :: self   !! interaction
    type(contact_pairs), intent(in) :: pairs        !! the position
    type(contact_state), intent(in) :: state        !! contacts that know nothing of each other
    type(effect_outcome), intent(inout) :: outcome  !! gets the columns

    associate (unused => self)
    end associate
    allocate (outcome%of_contacts(size(pairs%list), 2), source=not_computed)
    outcome%of_contacts(:, 2) = state%answers%vertical_load
    outcome%of_state = [sum(state%answers%vertical_load), not_computed, 0.0_real64, 0.0_real64, &
                        outcome%estimate]
  end subroutine leave_out

  !> Where the contacts together carry a load.
  subroutine closing_at_load(self, pairs, law, target, left, closing, found, failure)
    class(interaction_effect), intent(in) :: self              !! interaction
    type(contact_pairs), intent(in) :: pairs                   !! the position
    class(contact_law), intent(in) :: law                      !! of every contact
    real(real64), intent(in) :: target                         !! sum of the normal forces
    real(real64), intent(in) :: left                           !! of the tolerance
    real(real64), intent(inout) :: closing                     !! past first touch
    real(real64), allocatable, intent(inout) :: found(:, :)    !! the solution there
    character(len=:), allocatable, intent(inout) :: failure    !! why there is none
    type(joint_solution) :: solution

    call solve_joint(pairs, law, what_to_resolve(self, law), min(self%tolerance, left), &
                     self%boundary_tolerance, solution, target, self%area_tolerance)
    if (allocated(solution%failure)) then
      failure = 'interaction: ' // solution%failure
      return
    end if
    closing = solution%coupled%closing
    call pack_solution(solution, found)
  end subroutine closing_at_load

  ! Cells are elastic: contacts of another law stay circles.
  integer function what_to_resolve(self, law)
    class(interaction_effect), intent(in) :: self
    class(contact_law), intent(in) :: law

    what_to_resolve = resolve_none
    if (self%mode == effect_boundary) what_to_resolve = resolve_all
    if (self%mode == effect_auto .and. same_type_as(law, hertz_law())) &
      what_to_resolve = resolve_called_for
  end function what_to_resolve

  ! A solution as numbers: by pair, then what is of all.
  subroutine pack_solution(solution, found)
    type(joint_solution), intent(in) :: solution
    real(real64), allocatable, intent(out) :: found(:, :)

    allocate (found(size(solution%area), 9))
    found(:, 1) = solution%coupled%penetration
    found(:, 2) = solution%area
    found(:, 3) = solution%maximum_pressure
    found(:, 4) = merge(1.0_real64, 0.0_real64, solution%is_resolved)
    found(:, 5) = solution%cells
    found(:, 6) = solution%error
    found(:, 7) = solution%area_error
    found(:, 8) = solution%coupled%ending%residual
    found(:, 9) = solution%coupled%ending%iterations
  end subroutine pack_solution

  subroutine unpack_solution(found, solution)
    real(real64), intent(in) :: found(:, :)
    type(joint_solution), intent(out) :: solution

    solution%coupled%penetration = found(:, 1)
    solution%area = found(:, 2)
    solution%maximum_pressure = found(:, 3)
    solution%is_resolved = found(:, 4) > 0.5_real64
    solution%cells = nint(found(1, 5))
    solution%error = found(1, 6)
    solution%area_error = found(1, 7)
    solution%coupled%ending%residual = found(1, 8)
    solution%coupled%ending%iterations = nint(found(1, 9))
    solution%coupled%ending%converged = .true.
  end subroutine unpack_solution

end module asperity_interaction
