!> Creep of both bodies, as an effect that a scene names.
!>
!> Loading takes no time. Then the load or the approach is held; the states of the hold come at
!> rising times. In each, the elastic answers become those of a standard linear solid with the
!> memory of the states before (Lee and Radok 1960). The scene's modulus is the instantaneous one.
module asperity_creep
  use asperity_contact_effect, only: column, contact_effect, effect_outcome, force, plain
  use asperity_contact_law, only: contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: contact_state
  use asperity_kinds, only: int64, not_computed, real64
  use asperity_problems, only: decimal_text
  use asperity_scene_values, only: compliance, effect_auto, effect_boundary, hold_load, scene
  use asperity_theory_warnings, only: of_creep_strain, of_relaxing, of_unlike_bodies, warn, &
                                      warning_kinds
  use asperity_viscoelastic_solid, only: creep_compliance, elastic_load_of, loaded, relaxation, &
                                         solid_step, standard_linear_solid, step_over
  implicit none
  private

  public :: new_creep

  ! Representative strain over contact radius by combined radius (Tabor 1951).
  real(real64), parameter :: strain_per_radius = 0.2_real64
  real(real64), parameter :: two_thirds = 2.0_real64 / 3.0_real64

  !> What one contact remembers of the last state kept: of its load and of its greatest pressure.
  type :: contact_memory
    real(real64) :: elastic(2) = 0.0_real64   !! without relaxation
    real(real64) :: relaxing(2) = 0.0_real64  !! the part of it that will relax
  end type contact_memory

  !> Creep with one standard linear solid for both bodies.
  type, extends(contact_effect) :: creep_effect
    type(standard_linear_solid) :: solid            !! of both bodies
    real(real64) :: hold_time = 0.0_real64          !! how long the last state is held, 0 or more
    logical :: holds_load = .true.                  !! not the approach
    real(real64) :: softer_share = 1.0_real64       !! of the combined compliance, the softer body's
    real(real64) :: unlike = 0.0_real64             !! of the compliance, relaxes by another solid
    real(real64) :: may_fall = 0.0_real64           !! elastic load that may go, share of the total
    real(real64) :: time = 0.0_real64               !! of the last state kept
    type(contact_memory), allocatable :: memory(:)  !! of each pair; allocated by `begin`
  contains
    procedure :: estimate
    procedure :: apply
    procedure :: leave_out
    procedure :: begin
    procedure :: keep
    procedure :: held_share
  end type creep_effect

contains

  !> Creep as the scene names it.
  subroutine new_creep(scene_in, effect)
    type(scene), intent(in) :: scene_in                        !! checked values
    class(contact_effect), allocatable, intent(out) :: effect  !! ready to act
    real(real64), parameter :: rounding = 1.0e-9_real64
    type(creep_effect) :: new
    real(real64) :: compliances(2)

    associate (effects => scene_in%effects)
      call new%call_as('creep', effects)
      new%acts_in_time = .true.
      new%solid%relaxed_ratio = effects%number('relaxed_modulus_ratio')
      new%solid%relaxation_time = effects%number('relaxation_time')
      new%hold_time = effects%number('hold_time')
      new%holds_load = nint(effects%number('hold')) == hold_load
      ! Cells move the load of a contact by their tolerance, `auto` by its own where it sets in.
      new%may_fall = rounding
      if (any(effects%mode('interaction') == [effect_auto, effect_boundary])) &
        new%may_fall = effects%number('boundary_tolerance')
      if (effects%mode('interaction') == effect_auto) &
        new%may_fall = max(new%may_fall, new%tolerance)
    end associate
    if (scene_in%contact_modulus%digits == 0_int64 .and. &
        min(scene_in%upper%elastic_modulus%digits, &
            scene_in%lower%elastic_modulus%digits) > 0_int64) then
      compliances = compliance([scene_in%upper%elastic_modulus, scene_in%lower%elastic_modulus], &
                               [scene_in%upper%poisson_ratio, scene_in%lower%poisson_ratio])
      new%softer_share = maxval(compliances) / sum(compliances)
      ! 0 for equal bodies and for a rigid one.
      new%unlike = minval(compliances) / sum(compliances) * &
                   (1.0_real64 - minval(compliances) / maxval(compliances))
    end if
    new%contact_columns = [ &
      column('elastic_load', force), &     ! of an elastic one of this closing
      column('relaxed_share', plain)]    ! load over that
    new%state_columns = [ &
      column('time', plain), &                                 ! since the end of loading
      column('elastic_load', force)]       ! sum of those of the contacts
    allocate (effect, source=new)
  end subroutine new_creep

  !> Share of the load that is gone at the end of a hold of the approach. While a load is held, load
  !> over elastic load is nearer to one. The same for all states of a position, so that `auto` does
  !> not change its mind on the way.
  function estimate(self, pairs, state) result(share)
    class(creep_effect), intent(in) :: self   !! creep
    type(contact_pairs), intent(in) :: pairs  !! the position
    type(contact_state), intent(in) :: state  !! before creep
    real(real64) :: share

    share = 0.0_real64
    if (size(pairs%list) > 0 .and. allocated(state%answers)) &
      share = 1.0_real64 - relaxation(self%solid, self%hold_time)
  end function estimate

  !> What is left of a load that is held, over the elastic load of the same closing: one over the
  !> creep compliance.
  function held_share(self, time) result(share)
    class(creep_effect), intent(in) :: self  !! creep
    real(real64), intent(in) :: time         !! since the end of loading
    real(real64) :: share

    share = 1.0_real64 / creep_compliance(self%solid, time)
  end function held_share

  !> Turns the elastic answers at `state%time` into those after creep. Columns: load that an elastic
  !> contact of this closing carries, load over that; the time, the sum of the elastic loads.
  subroutine apply(self, pairs, state, outcome)
    class(creep_effect), intent(in) :: self         !! creep
    type(contact_pairs), intent(in) :: pairs        !! the position
    type(contact_state), intent(inout) :: state     !! gets loads, pressures and stiffness
    type(effect_outcome), intent(inout) :: outcome  !! what it did
    type(solid_step) :: step
    real(real64) :: elastic, fall
    logical :: holds
    integer :: i, worst

    outcome%simulated = 'on'
    outcome%ending%converged = .true.
    allocate (outcome%of_contacts(size(pairs%list), 2), source=0.0_real64)
    outcome%of_state = [state%time, sum(state%answers%load)]
    ! At the end of loading nothing has crept, and closings may still go anywhere.
    holds = state%time > 0.0_real64
    if (holds) step = step_over(self%solid, self%time, state%time)
    fall = 0.0_real64
    worst = 0
    do i = 1, size(pairs%list)
      elastic = state%answers(i)%load
      if (holds .and. self%memory(i)%elastic(1) - elastic > fall) then
        fall = self%memory(i)%elastic(1) - elastic
        worst = i
      end if
      if (.not. state%penetration(i) > 0.0_real64) cycle
      outcome%of_contacts(i, :) = [elastic, 1.0_real64]
      if (.not. (holds .and. elastic > 0.0_real64)) cycle
      call relax(step, self%memory(i), pairs%list(i)%s, state%answers(i))
      outcome%of_contacts(i, 2) = state%answers(i)%load / elastic
    end do
    call warn_of_limits(self, pairs, state, outcome)
    if (fall > self%may_fall * outcome%of_state(2)) outcome%failure = &
      'the area of contact ' // decimal_text(worst) // ' shrinks during the hold, which the ' // &
      'theory of Lee and Radok does not cover'
  end subroutine apply

  !> Left out: all is elastic.
  subroutine leave_out(self, pairs, state, outcome)
    class(creep_effect), intent(in) :: self         !! creep
    type(contact_pairs), intent(in) :: pairs        !! the position
    type(contact_state), intent(in) :: state        !! without creep
    type(effect_outcome), intent(inout) :: outcome  !! gets the columns

    associate (unused => self)
    end associate
    allocate (outcome%of_contacts(size(pairs%list), 2), source=not_computed)
    outcome%of_contacts(:, 1) = state%answers%load
    outcome%of_state = [not_computed, sum(state%answers%load)]
  end subroutine leave_out

  ! Strains beyond the linear range, and a hold that ends early: held, the approach still loses
  ! load; under a held load one contact still closes by the power 2/3 of the compliance.
  subroutine warn_of_limits(self, pairs, state, outcome)
    class(creep_effect), intent(in) :: self
    type(contact_pairs), intent(in) :: pairs
    type(contact_state), intent(in) :: state
    type(effect_outcome), intent(inout) :: outcome
    real(real64) :: strain, to_come
    integer :: i

    do i = 1, size(pairs%list)
      strain = strain_per_radius * self%softer_share * &
               state%answers(i)%contact_radius / pairs%list(i)%radius
      if (strain > warning_kinds(of_creep_strain)%limit) &
        call warn(outcome%warnings, of_creep_strain, strain, contacts=1)
    end do
    if (state%time > 0.0_real64 .and. self%unlike > self%tolerance) &
      call warn(outcome%warnings, of_unlike_bodies, self%unlike)
    if (state%time < self%hold_time .or. .not. state%time > 0.0_real64) return
    if (self%holds_load) then
      to_come = (1.0_real64 / (self%solid%relaxed_ratio * &
                               creep_compliance(self%solid, state%time)))**two_thirds - 1.0_real64
    else
      to_come = 1.0_real64 - self%solid%relaxed_ratio / relaxation(self%solid, state%time)
    end if
    if (to_come > self%tolerance) call warn(outcome%warnings, of_relaxing, to_come)
  end subroutine warn_of_limits

  ! One contact: the elastic answer becomes that after a step.
  pure subroutine relax(step, before, sum_of_radii, answer)
    type(solid_step), intent(in) :: step
    type(contact_memory), intent(in) :: before
    real(real64), intent(in) :: sum_of_radii
    type(contact_response), intent(inout) :: answer
    real(real64) :: elastic, relaxing(2), now(2), turn, gain

    elastic = answer%load
    relaxing = before%relaxing
    call loaded(step, before%elastic, [answer%load, answer%maximum_pressure], relaxing, now)
    answer%load = now(1)
    answer%maximum_pressure = now(2)
    answer%vertical_load = answer%vertical_load * (answer%load / elastic)
    ! The elastic stiffness is cosine dPe/dp + Pe d(cosine)/dp; only dPe/dp becomes less.
    turn = (1.0_real64 - answer%cosine) * (1.0_real64 + answer%cosine) / &
           (sum_of_radii - answer%overlap)
    gain = step%relaxed_ratio + step%growth
    answer%stiffness = gain * answer%stiffness - (answer%load - gain * elastic) * turn
  end subroutine relax

  !> Nothing has touched yet.
  subroutine begin(self, pairs)
    class(creep_effect), intent(inout) :: self  !! creep
    type(contact_pairs), intent(in) :: pairs    !! the position

    if (allocated(self%memory)) deallocate (self%memory)
    allocate (self%memory(size(pairs%list)))
    self%time = 0.0_real64
  end subroutine begin

  !> Remembers a state. Its loads and pressures are those after creep; the elastic ones follow from
  !> them. Friction, which acts later, leaves both as they are.
  subroutine keep(self, pairs, state)
    class(creep_effect), intent(inout) :: self  !! creep
    type(contact_pairs), intent(in) :: pairs    !! the position
    type(contact_state), intent(in) :: state    !! all effects applied

    if (.not. state%time > 0.0_real64) call self%begin(pairs)
    call remember(step_over(self%solid, self%time, state%time), state%answers, self%memory)
    self%time = state%time
  end subroutine keep

  ! What a contact keeps of a step.
  elemental subroutine remember(step, answer, memory)
    type(solid_step), intent(in) :: step
    type(contact_response), intent(in) :: answer
    type(contact_memory), intent(inout) :: memory
    real(real64) :: now(2)

    if (answer%load > 0.0_real64) then
      now = [answer%load, answer%maximum_pressure]
      memory%elastic = elastic_load_of(step, memory%elastic, memory%relaxing, now)
      memory%relaxing = now - step%relaxed_ratio * memory%elastic
    else
      memory = contact_memory()
    end if
  end subroutine remember

end module asperity_creep
