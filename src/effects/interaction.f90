!> Interaction of neighbouring contacts, as an effect of a scene.
!>
!> `coupled`: all contacts are Hertzian, in the surface displacement by their neighbours.
!> `boundary`: all are resolved by boundary elements. `auto`: as many as the tolerance requires.
module asperity_interaction
  use asperity_constants, only: pi
  use asperity_contact_effect, only: contact_effect, effect_outcome, force, length, plain
  use asperity_contact_law, only: contact_law
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: answer_all, contact_state, interaction_solution
  use asperity_hertz_law, only: hertz_law
  use asperity_interaction_estimate, only: estimate_of_interaction
  use asperity_joint_contacts, only: joint_solution, resolve_all, resolve_called_for, &
                                     resolve_none, solve_joint
  use asperity_kinds, only: not_computed, real64
  use asperity_scene_values, only: effect_auto, effect_boundary, scene
  use asperity_theory_warnings, only: add_warning, of_area, of_nested, warn_above
  implicit none
  private

  public :: interaction_effect, new_interaction

  !> Interaction of neighbouring contacts.
  type, extends(contact_effect) :: interaction_effect
    real(real64) :: boundary_tolerance = 0.0_real64  !! change of the load by halving the elements
    real(real64) :: area_tolerance = 0.0_real64      !! relative error of the areas
  contains
    procedure :: estimate => estimate_interaction
    procedure :: apply => apply_interaction
    procedure :: leave_out
    procedure :: solve_together
  end type interaction_effect

contains

  !> Makes the effect from its parameters in a scene.
  subroutine new_interaction(scene_in, effect)
    type(scene), intent(in) :: scene_in                        !! scene with checked values
    class(contact_effect), allocatable, intent(out) :: effect  !! effect of the scene
    type(interaction_effect) :: new

    call new%call_as('interaction', scene_in%effects)
    new%approximates = .true.
    new%boundary_tolerance = scene_in%effects%number('boundary_tolerance')
    new%area_tolerance = scene_in%effects%number('area_tolerance')
    allocate (effect, source=new)
  end subroutine new_interaction

  !> First-order estimate of the relative decrease of the load by neighbours.
  function estimate_interaction(self, pairs, state) result(share)
    class(interaction_effect), intent(in) :: self  !! interaction with its parameters
    type(contact_pairs), intent(in) :: pairs       !! pairs of the position
    type(contact_state), intent(in) :: state       !! contacts without interaction
    real(real64) :: share

    associate (unused => self)
    end associate
    share = estimate_of_interaction(pairs, state%law, state%compression)
  end function estimate_interaction

  !> Solves the interacting contacts at the compression of a state.
  subroutine apply_interaction(self, pairs, state, outcome)
    class(interaction_effect), intent(in) :: self   !! interaction with its parameters
    type(contact_pairs), intent(in) :: pairs        !! pairs of the position
    type(contact_state), intent(inout) :: state     !! gets the interacting contacts
    type(effect_outcome), intent(inout) :: outcome  !! gets columns, error and warnings
    real(real64) :: isolated(size(pairs%list)), factor

    isolated = state%answers%vertical_load
    outcome%simulated = 'coupled'
    if (self%mode == effect_boundary) outcome%simulated = 'boundary'
    ! `auto` may have begun to simulate plasticity, or ended, since the search for the load.
    if (allocated(state%solution)) then
      if (state%solution%is_elastic .neqv. same_type_as(state%law, hertz_law())) &
        deallocate (state%solution)
    end if
    if (.not. allocated(state%solution)) &
      call solve_together(self, pairs, state%law, state%tolerance, state%compression, &
                          state%solution, outcome%failure)
    if (allocated(outcome%failure)) return
    state%penetration = state%solution%penetration
    call answer_all(pairs, state)
    associate (solution => state%solution, answers => state%answers)
      ! The number of elements changes with the compression.
      if (solution%elements > 0) outcome%load_jump = 0.1_real64 * self%boundary_tolerance
      outcome%ending = solution%ending
      if (self%mode == effect_auto .and. solution%elements > 0) then
        outcome%simulated = 'coupled+boundary'
        outcome%why = 'Hertzian error, windows cost less'
        if (solution%clusters == 1 .and. &
            all(solution%is_resolved .or. .not. answers%load > 0.0_real64)) &
          outcome%why = 'Hertzian error, one grid costs less'
      end if
      where (answers%load > 0.0_real64)
        answers%contact_radius = sqrt(solution%area / pi)
        ! Where a few elements resolve a contact their greatest pressure may be below the mean.
        where (solution%pressure > 0.0_real64) &
          answers%maximum_pressure = max(solution%pressure, answers%load / solution%area)
      end where
      factor = 1.0_real64
      if (sum(isolated) > 0.0_real64) factor = sum(answers%vertical_load) / sum(isolated)
      call add_columns(outcome, isolated, max(0.0_real64, state%compression - pairs%list%gap - &
                       state%penetration), factor, real([solution%elements, count( &
                       solution%is_resolved .and. answers%load > 0.0_real64)], real64), &
                       solution%area_error)
      outcome%error = solution%error
      call warn_above(outcome%warnings, of_nested, solution%nested, &
                      whose=merge('other laws than Hertz', '                     ', &
                                  .not. same_type_as(state%law, hertz_law())))
      if (self%mode == effect_auto .and. solution%area_error > self%tolerance) &
        call add_warning(outcome%warnings, of_area, solution%area_error)
    end associate
    outcome%influence = factor - 1.0_real64
  end subroutine apply_interaction

  !> Sets the columns where interaction is left out: isolated loads and the estimate as error.
  subroutine leave_out(self, pairs, state, outcome)
    class(interaction_effect), intent(in) :: self   !! interaction with its parameters
    type(contact_pairs), intent(in) :: pairs        !! pairs of the position
    type(contact_state), intent(in) :: state        !! contacts without interaction
    type(effect_outcome), intent(inout) :: outcome  !! gets the columns

    associate (unused => self)
    end associate
    call add_columns(outcome, state%answers%vertical_load, &
                     spread(not_computed, 1, size(pairs%list)), not_computed, &
                     spread(0.0_real64, 1, 2), outcome%estimate)
  end subroutine leave_out

  ! Adds the columns.
  subroutine add_columns(outcome, isolated, lowered, factor, counts, area_error)
    type(effect_outcome), intent(inout) :: outcome
    real(real64), intent(in) :: isolated(:)    ! vertical loads of the isolated contacts
    real(real64), intent(in) :: lowered(:)  ! displacements by neighbours
    real(real64), intent(in) :: factor      ! load over that of the isolated contacts
    real(real64), intent(in) :: counts(2)   ! boundary elements, contacts on them
    real(real64), intent(in) :: area_error  ! estimated relative error of the area

    associate (of_contacts => outcome%of_contacts, of_state => outcome%of_state)
      call of_contacts%add('lowered', length, lowered)
      call of_contacts%add('alone_load', force, isolated)
      call of_state%add('alone_load', force, sum(isolated))
      call of_state%add('factor', plain, factor)
      call of_state%add('cells', plain, counts(1))
      call of_state%add('resolved', plain, counts(2))
      call of_state%add('area_error_estimate', plain, area_error)
    end associate
  end subroutine add_columns

  !> Solves the interacting contacts at a compression, or at that of the load `target`.
  subroutine solve_together(self, pairs, law, tolerance, compression, found, failure, target)
    class(interaction_effect), intent(in) :: self              !! interaction with its parameters
    type(contact_pairs), intent(in) :: pairs                   !! pairs of the position
    class(contact_law), intent(in) :: law                      !! law of each contact
    real(real64), intent(in) :: tolerance                      !! relative, of interaction
    real(real64), intent(inout) :: compression                 !! compression, start and result
    type(interaction_solution), allocatable, intent(out) :: found  !! solution found there
    character(len=:), allocatable, intent(inout) :: failure    !! set where it is impossible
    real(real64), intent(in), optional :: target               !! sum of the normal forces
    type(joint_solution) :: solution
    integer :: which

    ! Boundary elements are elastic: contacts of another law are coupled.
    which = resolve_none
    if (self%mode == effect_boundary) which = resolve_all
    if (self%mode == effect_auto .and. same_type_as(law, hertz_law())) which = resolve_called_for
    solution%coupled%compression = compression
    call solve_joint(pairs, law, which, min(self%tolerance, tolerance), &
                     self%boundary_tolerance, self%area_tolerance, solution, target)
    if (allocated(solution%failure)) then
      failure = solution%failure
      return
    end if
    compression = solution%coupled%compression
    allocate (found)
    found%is_elastic = same_type_as(law, hertz_law())
    found%elements = solution%elements
    found%clusters = solution%clusters
    found%error = solution%error
    found%area_error = solution%area_error
    if (which == resolve_none) found%nested = solution%nested
    found%ending = solution%coupled%ending
    found%ending%converged = .true.
    found%penetration = solution%coupled%penetration
    found%shift = solution%coupled%shift
    call move_alloc(solution%area, found%area)
    call move_alloc(solution%maximum_pressure, found%pressure)
    call move_alloc(solution%is_resolved, found%is_resolved)
  end subroutine solve_together

end module asperity_interaction
