!> Interaction of neighbouring contacts, as an effect that a scene names.
!>
!> `coupled`: every contact is lowered by the surface displacement of its neighbours, as circles.
!> `boundary`: all are resolved on cells. `auto`: as many as the tolerance calls for.
module asperity_interaction
  use asperity_constants, only: pi
  use asperity_contact_effect, only: column, contact_effect, effect_outcome, force, length, plain
  use asperity_contact_law, only: contact_law
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: answer_all, apart, contact_state, move_x, move_y
  use asperity_coupled_joining, only: stand_apart
  use asperity_earlier_solutions, only: start_from_earlier
  use asperity_hertz_law, only: hertz_law
  use asperity_interaction_estimate, only: estimate_of_interaction
  use asperity_joint_contacts, only: joint_solution, resolve_all, resolve_called_for, &
                                     resolve_none, solve_joint
  use asperity_kinds, only: not_computed, real64
  use asperity_scene_values, only: effect_auto, effect_boundary, scene
  use asperity_solve_ending, only: solve_ending
  use asperity_theory_warnings, only: of_area, of_nested, warn, warning_kinds
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

  ! What a solve has found is kept as numbers: a row of what is of all, then a row by pair.
  integer, parameter :: cells = 1, error = 2, area_error = 3, residual = 4, iterations = 5, &
                        nested = 6  ! then apart
  integer, parameter :: penetration = 1, area = 2, pressure = 3, resolved = 4  ! then move_x, move_y

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
    real(real64) :: together, alone

    allocate (outcome%of_contacts(size(pairs%list), 2), outcome%of_state(5))
    outcome%of_contacts(:, 2) = state%answers%vertical_load
    outcome%simulated = 'coupled'
    if (self%mode == effect_boundary) outcome%simulated = 'boundary'
    if (.not. allocated(state%found)) &
      call solve_together(self, pairs, state%law, state%left, state%closing, state%found, &
                          outcome%failure)
    if (allocated(outcome%failure)) return
    state%penetration = state%found(2:, penetration)
    call answer_all(pairs, state)
    associate (of_all => state%found(1, :), found => state%found(2:, :), answers => state%answers)
      outcome%ending = solve_ending(.true., of_all(residual), nint(of_all(iterations)))
      if (self%mode == effect_auto .and. of_all(cells) > 0.0_real64) then
        outcome%simulated = 'coupled+boundary'
        outcome%why = 'contacts of other shape than circles'
      end if
      where (answers%load > 0.0_real64)
        answers%contact_radius = sqrt(found(:, area) / pi)
        where (found(:, pressure) > 0.0_real64) answers%maximum_pressure = found(:, pressure)
      end where
      outcome%of_contacts(:, 1) = max(0.0_real64, &
                                      state%closing - pairs%list%gap - state%penetration)
      alone = sum(outcome%of_contacts(:, 2))
      together = sum(answers%vertical_load)
      outcome%of_state = [alone, 1.0_real64, of_all(cells), &
                          sum(found(:, resolved), mask=answers%load > 0.0_real64), &
                          of_all(area_error)]
      if (alone > 0.0_real64) outcome%of_state(2) = together / alone
      outcome%error = of_all(error)
      if (of_all(nested) > warning_kinds(of_nested)%limit) &
        call warn(outcome%warnings, of_nested, of_all(nested), &
                  whose=merge('other laws than Hertz', '                     ', &
                              .not. same_type_as(state%law, hertz_law())))
    end associate
    outcome%influence = outcome%of_state(2) - 1.0_real64
    outcome%influence_known = .true.
    if (self%mode == effect_auto .and. outcome%of_state(5) > self%tolerance) &
      call warn(outcome%warnings, of_area, outcome%of_state(5))
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

    call solve_together(self, pairs, law, left, closing, found, failure, target)
    if (allocated(failure)) failure = 'interaction: ' // failure
  end subroutine closing_at_load

  ! The contacts together at a closing, or at the one at which they carry a load, as numbers.
  subroutine solve_together(self, pairs, law, left, closing, found, failure, target)
    class(interaction_effect), intent(in) :: self
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    real(real64), intent(in) :: left
    real(real64), intent(inout) :: closing
    real(real64), allocatable, intent(out) :: found(:, :)
    character(len=:), allocatable, intent(inout) :: failure
    real(real64), intent(in), optional :: target
    type(joint_solution) :: solution, fresh
    integer :: which
    logical :: has_start

    ! Cells are elastic: contacts of another law stay circles.
    which = resolve_none
    if (self%mode == effect_boundary) which = resolve_all
    if (self%mode == effect_auto .and. same_type_as(law, hertz_law())) which = resolve_called_for
    solution%coupled%closing = closing
    if (which /= resolve_all .and. same_type_as(law, hertz_law())) &
      call start_from_earlier(pairs, solution%coupled, target)
    has_start = allocated(solution%coupled%penetration)
    call solve_now()
    if (has_start .and. .not. pairs%interrupt%is_asked()) then
      if (.not. is_one_solution(pairs, solution)) then
        solution = fresh
        solution%coupled%closing = closing
        call solve_now()
      end if
    end if
    if (allocated(solution%failure)) then
      failure = solution%failure
      return
    end if
    closing = solution%coupled%closing
    allocate (found(1 + size(solution%area), apart), source=0.0_real64)
    associate (coupled => solution%coupled)
      found(1, :) = [real(solution%cells, real64), solution%error, solution%area_error, &
                     coupled%ending%residual, real(coupled%ending%iterations, real64), &
                     merge(solution%nested, 0.0_real64, which == resolve_none), &
                     merge(1.0_real64, 0.0_real64, is_one_solution(pairs, solution))]
      found(2:, penetration) = coupled%penetration
    end associate
    found(2:, area) = solution%area
    found(2:, pressure) = solution%maximum_pressure
    found(2:, resolved) = merge(1.0_real64, 0.0_real64, solution%is_resolved)
    found(2:, move_x) = solution%coupled%move(1, :)
    found(2:, move_y) = solution%coupled%move(2, :)

  contains

    subroutine solve_now()
      call solve_joint(pairs, law, which, min(self%tolerance, left), self%boundary_tolerance, &
                       self%area_tolerance, solution, target)
    end subroutine solve_now

  end subroutine solve_together

  ! Whether a solution does not depend on its start.
  logical function is_one_solution(pairs, solution)
    type(contact_pairs), intent(in) :: pairs
    type(joint_solution), intent(in) :: solution

    is_one_solution = .not. allocated(solution%failure) .and. solution%cells == 0
    if (is_one_solution) is_one_solution = stand_apart(pairs, solution%coupled)
  end function is_one_solution

end module asperity_interaction
