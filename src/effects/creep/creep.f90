!> Creep of both bodies, as an effect of a scene.
!>
!> Loading, a path and a hold of the load or the separation take their times; without a time of
!> loading that is instantaneous. In each state the elastic responses become those of a viscoelastic
!> solid with the memory of the states before (Lee and Radok 1960). The modulus of the scene is the
!> instantaneous one. The area of an isolated contact may shrink and grow again (`contact_rings`);
!> that of one with displacements by neighbours keeps tractions where it has opened. In a step a
!> contact has the law of the state before, so that its load is a continuous function of the
!> compression: a neighbour that touches in the step does not change the law of its load.
module asperity_creep
  use asperity_contact_effect, only: contact_effect, effect_outcome, force, plain
  use asperity_contact_law, only: contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_rings, only: contact_rings, has_shrunk, keep_rings, measure_rings
  use asperity_contact_state, only: contact_state
  use asperity_coupled_contacts, only: accepted_residual
  use asperity_creep_limits, only: creep_limits, creep_share, limits_of_scene, warn_of_strain, &
                                   warn_of_time
  use asperity_kinds, only: not_computed, real64
  use asperity_scene_values, only: effect_auto, effect_boundary, most_relaxations, scene
  use asperity_theory_warnings, only: add_warning, of_shrinking
  use asperity_viscoelastic_solid, only: creep_compliance, history_of, keep_load, solid_step, &
                                         step_over
  implicit none
  private

  public :: new_creep

  !> Memory of one contact at the last state kept: of its load and of its greatest pressure.
  type :: contact_memory
    real(real64) :: elastic(2) = 0.0_real64   !! without relaxation
    real(real64) :: relaxing(most_relaxations, 2) = 0.0_real64  !! parts that will relax
    logical :: is_loaded = .false.            !! the load is more than 0
    type(contact_rings) :: rings              !! of an isolated contact; else not allocated
    !> Load and pressure over those of the rings, from the state in which it began to shrink; 0: it
    !> has grown so far.
    real(real64) :: correction(2) = 0.0_real64
  end type contact_memory

  !> Creep with one viscoelastic solid for both bodies.
  type, extends(contact_effect) :: creep_effect
    type(creep_limits) :: limits                    !! material of both bodies, and the hold
    real(real64) :: may_fall = 0.0_real64           !! decrease of an elastic load over the total
    real(real64) :: time = 0.0_real64               !! time of the last state kept
    type(contact_memory), allocatable :: memory(:)  !! of each pair; allocated by `begin`
  contains
    procedure :: estimate => estimate_creep
    procedure :: apply => apply_creep
    procedure :: leave_out
    procedure :: begin => begin_creep
    procedure :: keep => keep_creep
    procedure :: held_share
  end type creep_effect

contains

  !> Makes the effect from its parameters in a scene.
  subroutine new_creep(scene_in, effect)
    type(scene), intent(in) :: scene_in                        !! scene with checked values
    class(contact_effect), allocatable, intent(out) :: effect  !! effect without history
    ! Decrease of an elastic load by rounding, over the total. Chosen.
    real(real64), parameter :: rounding = 1.0e-9_real64
    type(creep_effect) :: new

    associate (effects => scene_in%effects)
      call new%call_as('creep', effects)
      new%acts_in_time = .true.
      new%limits = limits_of_scene(scene_in)
      ! Boundary elements change the load of a contact by their tolerance, `auto` by its own.
      new%may_fall = rounding
      if (any(effects%mode('interaction') == [effect_auto, effect_boundary])) &
        new%may_fall = effects%number('boundary_tolerance')
      if (effects%mode('interaction') == effect_auto) &
        new%may_fall = max(new%may_fall, new%tolerance)
    end associate
    allocate (effect, source=new)
  end subroutine new_creep

  !> Decrease of the load at the end of a hold of the separation; in a hold of the load the
  !> compression changes by less. The estimate is equal for all states of a
  !> position, so that `auto` has one choice in a hold.
  function estimate_creep(self, pairs, state) result(share)
    class(creep_effect), intent(in) :: self   !! creep with its parameters
    type(contact_pairs), intent(in) :: pairs  !! pairs of the position
    type(contact_state), intent(in) :: state  !! contacts without creep
    real(real64) :: share

    share = 0.0_real64
    if (size(pairs%list) > 0 .and. allocated(state%answers)) share = creep_share(self%limits)
  end function estimate_creep

  !> Load in a hold of the load over the elastic load at the same compression: the inverse of the
  !> creep compliance.
  function held_share(self, time) result(share)
    class(creep_effect), intent(in) :: self  !! creep with its parameters
    real(real64), intent(in) :: time         !! time since the begin of loading
    real(real64) :: share

    share = 1.0_real64 / creep_compliance(self%limits%solid, time - &
                                           self%limits%solid%loading_time)
  end function held_share

  !> Turns the elastic responses at `state%time` into those after creep.
  subroutine apply_creep(self, pairs, state, outcome)
    class(creep_effect), intent(in) :: self         !! creep with its history
    type(contact_pairs), intent(in) :: pairs        !! pairs of the position
    type(contact_state), intent(inout) :: state     !! gets loads, pressures and stiffness
    type(effect_outcome), intent(inout) :: outcome  !! gets columns and warnings
    type(solid_step) :: step
    ! Load of an elastic contact at this compression, and its load over it.
    real(real64), allocatable :: values(:, :)
    real(real64) :: elastic, shrinking, total
    logical :: holds, isolated
    integer :: i, number

    outcome%simulated = 'on'
    allocate (values(size(pairs%list), 2), source=0.0_real64)
    total = sum(state%answers%load)
    ! Without time there is no creep, and a compression of any sign is valid.
    holds = state%time > 0.0_real64
    if (holds) step = step_over(self%limits%solid, self%time, state%time)
    shrinking = 0.0_real64
    number = 0
    do i = 1, size(pairs%list)
      elastic = state%answers(i)%load
      isolated = holds
      if (holds) isolated = allocated(self%memory(i)%rings%overlap)
      if (holds .and. .not. isolated .and. self%memory(i)%is_loaded .and. &
          self%memory(i)%elastic(1) - elastic > self%may_fall * total) then
        shrinking = shrinking + self%memory(i)%elastic(1)
        number = number + 1
      end if
      if (.not. state%penetration(i) > 0.0_real64) cycle
      values(i, :) = [elastic, 1.0_real64]
      if (.not. (holds .and. elastic > 0.0_real64)) cycle
      call relax_contact(step, self%memory(i), isolated, pairs%list(i)%s, state%answers(i))
      values(i, 2) = state%answers(i)%load / elastic
    end do
    call add_columns(outcome, values(:, 1), values(:, 2), state%time, total)
    if (number > 0) call add_warning(outcome%warnings, of_shrinking, shrinking / &
      sum(self%memory%elastic(1), self%memory%is_loaded), contacts=number)
    do i = 1, size(pairs%list)
      call warn_of_strain(self%limits, state%answers(i)%contact_radius, pairs%list(i)%radius, &
                          outcome%warnings)
    end do
    call warn_of_time(self%limits, state%time, outcome%warnings)
  end subroutine apply_creep

  !> Sets the columns where creep is left out: the contacts are elastic.
  subroutine leave_out(self, pairs, state, outcome)
    class(creep_effect), intent(in) :: self         !! creep with its parameters
    type(contact_pairs), intent(in) :: pairs        !! pairs of the position
    type(contact_state), intent(in) :: state        !! contacts without creep
    type(effect_outcome), intent(inout) :: outcome  !! gets the columns

    associate (unused => self)
    end associate
    call add_columns(outcome, state%answers%load, spread(not_computed, 1, size(pairs%list)), &
                     not_computed, sum(state%answers%load))
  end subroutine leave_out

  ! Adds the columns: elastic loads, loads over them, the time and the sum of the elastic loads.
  subroutine add_columns(outcome, elastic, shares, time, total)
    type(effect_outcome), intent(inout) :: outcome
    real(real64), intent(in) :: elastic(:), shares(:), time, total

    call outcome%of_contacts%add('elastic_load', force, elastic)
    call outcome%of_contacts%add('relaxed_share', plain, shares)
    call outcome%of_state%add('time', plain, time)
    call outcome%of_state%add('elastic_load', force, total)
  end subroutine add_columns

  ! Whether no neighbour displaces the surfaces of a contact, by more than the error of its
  ! penetration.
  elemental logical function is_isolated(pairs, state, i)
    type(contact_pairs), intent(in) :: pairs
    type(contact_state), intent(in) :: state
    integer, intent(in) :: i

    is_isolated = .not. abs(state%penetration(i) - (state%compression - pairs%list(i)%gap)) > &
                  accepted_residual * max(0.0_real64, state%penetration(i))
  end function is_isolated

  ! Turns the elastic response of a contact into that after a step. Where nothing is left of the
  ! load the surface has not recovered, and the contact is open.
  pure subroutine relax_contact(step, before, isolated, sum_of_radii, answer)
    type(solid_step), intent(in) :: step
    type(contact_memory), intent(in) :: before
    logical, intent(in) :: isolated
    real(real64), intent(in) :: sum_of_radii
    type(contact_response), intent(inout) :: answer
    real(real64) :: correction(2), elastic, gain, now(2), rim, turn

    elastic = answer%load
    gain = step%gain
    now = hereditary_values(step, before, [answer%load, answer%maximum_pressure])
    if (isolated) then
      if (before%correction(1) > 0.0_real64 .or. has_shrunk(before%rings, answer%overlap)) then
        call measure_rings(before%rings, step, answer%overlap, rim, now)
        correction = correction_of(step, before)
        now = correction * now * [answer%load, answer%maximum_pressure]
        gain = gain * sqrt(rim) * correction(1)
        answer%contact_radius = answer%contact_radius * sqrt(rim)
      end if
    end if
    if (.not. now(1) > 0.0_real64) then
      answer = contact_response()
      return
    end if
    answer%load = now(1)
    answer%maximum_pressure = max(now(2), 0.0_real64)
    answer%vertical_load = answer%vertical_load * (answer%load / elastic)
    ! The elastic stiffness is cosine dPe/dp + Pe d(cosine)/dp; creep reduces dPe/dp only.
    turn = (1.0_real64 - answer%cosine) * (1.0_real64 + answer%cosine) / &
           (sum_of_radii - answer%overlap)
    answer%stiffness = gain * answer%stiffness - (answer%load - gain * elastic) * turn
  end subroutine relax_contact

  ! Hereditary integrals of load and greatest pressure of a contact, from their elastic values.
  pure function hereditary_values(step, before, elastic) result(now)
    type(solid_step), intent(in) :: step
    type(contact_memory), intent(in) :: before
    real(real64), intent(in) :: elastic(2)
    real(real64) :: now(2)
    integer :: k

    do k = 1, 2
      now(k) = step%gain * elastic(k) + &
               history_of(step, before%elastic(k), before%relaxing(:step%terms, k))
    end do
  end function hereditary_values

  ! Load and pressure over those of the rings. Where the contact begins to shrink the loads of both
  ! sums are equal at the last overlap.
  pure function correction_of(step, before) result(correction)
    type(solid_step), intent(in) :: step
    type(contact_memory), intent(in) :: before
    real(real64) :: correction(2), rim, shares(2)

    correction = before%correction
    if (correction(1) > 0.0_real64) return
    correction = 1.0_real64
    call measure_rings(before%rings, step, before%rings%last, rim, shares)
    if (all(shares > 0.0_real64 .and. before%elastic > 0.0_real64)) &
      correction = hereditary_values(step, before, before%elastic) / (shares * before%elastic)
    if (.not. all(correction > 0.0_real64)) correction = 1.0_real64
  end function correction_of

  !> Begins a position without any contact so far.
  subroutine begin_creep(self, pairs)
    class(creep_effect), intent(inout) :: self  !! creep, whose memory is cleared
    type(contact_pairs), intent(in) :: pairs    !! pairs of the position

    if (allocated(self%memory)) deallocate (self%memory)
    allocate (self%memory(size(pairs%list)))
    self%time = 0.0_real64
  end subroutine begin_creep

  !> Keeps a state. Its loads and pressures are those after creep; the elastic ones follow from
  !> them. Friction, which acts later, changes neither.
  subroutine keep_creep(self, pairs, state)
    class(creep_effect), intent(inout) :: self  !! creep, gets the history
    type(contact_pairs), intent(in) :: pairs    !! pairs of the position
    type(contact_state), intent(in) :: state    !! contacts with all effects
    type(solid_step) :: step
    integer :: i

    if (.not. state%time > 0.0_real64) call self%begin(pairs)
    step = step_over(self%limits%solid, self%time, state%time)
    do i = 1, size(pairs%list)
      associate (memory => self%memory(i), answer => state%answers(i))
        if (.not. is_isolated(pairs, state, i)) then
          memory%rings = contact_rings()
          memory%correction = 0.0_real64
        else if (allocated(memory%rings%overlap) .or. .not. memory%is_loaded) then
          if (has_shrunk(memory%rings, answer%overlap)) &
            memory%correction = correction_of(step, memory)
          call keep_rings(memory%rings, step, answer%overlap)
        end if
        memory%is_loaded = answer%load > 0.0_real64
        call keep_load(step, answer%load, memory%elastic(1), memory%relaxing(:step%terms, 1))
        call keep_load(step, answer%maximum_pressure, memory%elastic(2), &
                       memory%relaxing(:step%terms, 2))
      end associate
    end do
    self%time = state%time
  end subroutine keep_creep

end module asperity_creep
