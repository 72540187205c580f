!> Plastic flow beyond the elastic limit, as an effect of a scene.
!>
!> Each contact follows Hertz' law up to its onset, that of Jackson and Green beyond it. The largest
!> overlap of each contact is kept from one state of a position to the next.
module asperity_plasticity
  use asperity_constants, only: pi
  use asperity_contact_effect, only: contact_effect, effect_outcome, force, length, moment, &
                                     plain, relative_influence
  use asperity_contact_law, only: contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: answer_all, contact_state
  use asperity_first_yield, only: yielding_factor
  use asperity_hertz_law, only: hertz_law
  use asperity_sphere_overlap, only: stable_overlap
  use asperity_kinds, only: real64
  use asperity_plastic_curves, only: departure
  use asperity_plastic_law, only: past_of_contact, plastic_law, plastic_past
  use asperity_scene_values, only: criterion_hardy, scene
  use asperity_theory_warnings, only: of_flow_depth, of_unloading_depth, of_yield_strain, warn_above
  implicit none
  private

  public :: new_plasticity

  ! Overlaps of a contact in states of the same load differ by less, over the overlap (derived: a
  ! requested load is met to 1e-6, and it grows at least with the overlap; test: equal loads in
  ! test/effects/test_plasticity.py).
  real(real64), parameter :: of_equal_loads = 1.0e-6_real64

  !> Plastic flow.
  type, extends(contact_effect) :: plasticity_effect
    real(real64) :: yield_stress = 0.0_real64    !! in tension, in the scene's unit; 0: see limit
    logical :: limit_is_yield = .false.          !! the limit is the first yield, not the departure
    real(real64) :: before_hold = 0.0_real64     !! estimate at the last state kept
    type(plastic_law) :: law                     !! law of a position with the history
  contains
    procedure :: estimate => estimate_plasticity
    procedure :: apply => apply_plasticity
    procedure :: leave_out
    procedure :: begin => begin_plasticity
    procedure :: keep => keep_plasticity
    procedure :: finish => finish_plasticity
  end type plasticity_effect

contains

  !> Makes the effect from its parameters in a scene.
  subroutine new_plasticity(scene_in, effect)
    type(scene), intent(in) :: scene_in                         !! scene with checked values
    class(contact_effect), allocatable, intent(out) :: effect   !! effect without history
    type(plasticity_effect) :: new

    call new%call_as('plasticity', scene_in%effects)
    new%law%constraint = yielding_factor(scene_in)
    new%yield_stress = scene_in%effects%number('plastic_yield_stress')
    new%limit_is_yield = scene_in%limit%criterion == criterion_hardy
    allocate (effect, source=new)
  end subroutine new_plasticity

  !> Change of the total vertical load, or of the area if that is larger, by plastic flow
  !> and by residual deformation. The law is evaluated in full. The other effects reduce the loads,
  !> so this is an upper bound. Under a prescribed load the area is that after one Newton step of
  !> the compression; as the load is convex on loading, this is an upper bound too. In a hold
  !> pressures decrease and no further contact yields: the estimate is that of its begin.
  function estimate_plasticity(self, pairs, state) result(share)
    class(plasticity_effect), intent(in) :: self  !! plasticity with its history
    type(contact_pairs), intent(in) :: pairs      !! pairs of the position
    type(contact_state), intent(in) :: state      !! contacts without plasticity
    real(real64) :: share
    type(contact_response) :: answer
    real(real64) :: changed, lost, stiffness, area, changed_area, total, further
    integer :: i

    share = self%before_hold
    if (state%time > 0.0_real64) return
    share = 0.0_real64
    total = sum(state%answers%vertical_load)
    if (.not. total > 0.0_real64) return
    changed = 0.0_real64
    lost = 0.0_real64
    stiffness = 0.0_real64
    do i = 1, size(pairs%list)
      if (.not. state%penetration(i) > 0.0_real64) cycle
      call self%law%respond(pairs%list(i), i, state%penetration(i), answer)
      changed = changed + abs(answer%vertical_load - state%answers(i)%vertical_load)
      lost = lost + state%answers(i)%vertical_load - answer%vertical_load
      stiffness = stiffness + answer%stiffness
    end do
    further = 0.0_real64
    if (pairs%target > 0.0_real64 .and. lost > 0.0_real64 .and. stiffness > 0.0_real64) &
      further = min(lost / stiffness, state%compression)
    area = 0.0_real64
    changed_area = 0.0_real64
    do i = 1, size(pairs%list)
      if (.not. state%penetration(i) + further > 0.0_real64) cycle
      call self%law%respond(pairs%list(i), i, min(state%penetration(i) + further, &
                            0.999999_real64 * pairs%list(i)%zc), answer)
      area = area + answer%contact_radius**2
      changed_area = changed_area + abs(answer%contact_radius**2 - &
                                        state%answers(i)%contact_radius**2)
    end do
    share = max(relative_influence(changed, total, total - lost), &
                relative_influence(changed_area, sum(state%answers%contact_radius**2), area))
  end function estimate_plasticity

  !> Sets the plastic law in a state and evaluates it.
  subroutine apply_plasticity(self, pairs, state, outcome)
    class(plasticity_effect), intent(in) :: self    !! plasticity with its history
    type(contact_pairs), intent(in) :: pairs        !! pairs of the position
    type(contact_state), intent(inout) :: state     !! elastic contacts, then plastic ones
    type(effect_outcome), intent(inout) :: outcome  !! gets how it ended

    deallocate (state%law)
    allocate (state%law, source=self%law)
    call answer_all(pairs, state)
    outcome%simulated = 'on'
  end subroutine apply_plasticity

  !> Leaves the columns to the end.
  subroutine leave_out(self, pairs, state, outcome)
    class(plasticity_effect), intent(in) :: self    !! plasticity with its history
    type(contact_pairs), intent(in) :: pairs        !! pairs of the position
    type(contact_state), intent(in) :: state        !! contacts without plasticity
    type(effect_outcome), intent(inout) :: outcome  !! stays without columns

    associate (unused => self, unused_too => pairs, unused_also => state, as_it_is => outcome)
    end associate
  end subroutine leave_out

  !> Adds the columns at the end, as later effects may change the penetrations.
  subroutine finish_plasticity(self, pairs, state, outcome)
    class(plasticity_effect), intent(in) :: self    !! plasticity with its history
    type(contact_pairs), intent(in) :: pairs        !! pairs of the position
    type(contact_state), intent(in) :: state        !! contacts with all effects
    type(effect_outcome), intent(inout) :: outcome  !! gets columns and warnings
    type(plastic_past) :: past
    type(contact_response) :: answer
    ! Whether a contact has passed its onset, its largest overlap and that without load.
    real(real64), allocatable :: values(:, :)
    real(real64) :: elastic_load, overlap, strain, work
    integer :: flowing, i

    allocate (values(size(pairs%list), 3))
    elastic_load = 0.0_real64
    work = 0.0_real64
    flowing = 0
    do i = 1, size(pairs%list)
      call self%law%elastic%respond(pairs%list(i), i, state%penetration(i), answer)
      overlap = answer%overlap
      elastic_load = elastic_load + answer%vertical_load
      call past_of_contact(self%law, pairs%list(i), i, max(self%law%largest(i), overlap), past)
      values(i, :) = [merge(1.0_real64, 0.0_real64, past%flowed), past%largest, past%residual]
      work = work + past%work_lost
      ! The range of yield strains is one of the material, however small the flow is.
      if (.not. (past%flowed .or. (outcome%simulated /= 'off' .and. past%largest > 0.0_real64 &
                 .and. self%law%critical(i) < huge(strain)))) cycle
      ! w_c/R = (pi C Sy/(2 E))**2.
      strain = sqrt(self%law%critical(i) / pairs%list(i)%radius) / (0.5_real64 * pi * &
                                                                    self%law%constraint)
      call warn_above(outcome%warnings, of_yield_strain, strain, 1)
      if (.not. past%flowed) cycle
      if (overlap >= (1.0_real64 - of_equal_loads) * self%law%largest(i)) then
        flowing = flowing + 1
        call warn_above(outcome%warnings, of_flow_depth, overlap / self%law%critical(i), 1)
      else
        call warn_above(outcome%warnings, of_unloading_depth, &
                        self%law%largest(i) / self%law%critical(i), 1)
      end if
    end do
    associate (of_contacts => outcome%of_contacts, of_state => outcome%of_state)
      call of_contacts%add('plastic', plain, values(:, 1))
      call of_contacts%add('largest_overlap', length, values(:, 2))
      call of_contacts%add('residual_overlap', length, values(:, 3))
      call of_state%add('hertz_load', force, elastic_load)
      call of_state%add('contacts_flowing', plain, real(flowing, real64))
      call of_state%add('dissipated_work', moment, work)
      call of_state%add('residual_flattening', length, maxval([0.0_real64, values(:, 3)]))
    end associate
    outcome%dissipated_work = work
  end subroutine finish_plasticity

  !> Begins a position, whose contacts have not been loaded.
  subroutine begin_plasticity(self, pairs)
    class(plasticity_effect), intent(inout) :: self  !! plasticity, gets the law
    type(contact_pairs), intent(in) :: pairs         !! pairs of the position
    real(real64) :: critical, strain
    integer :: i

    if (allocated(self%law%largest)) deallocate (self%law%largest, self%law%critical)
    allocate (self%law%largest(size(pairs%list)), self%law%critical(size(pairs%list)))
    self%law%elastic = hertz_law(modulus=pairs%modulus)
    self%law%largest = 0.0_real64
    self%before_hold = 0.0_real64
    do i = 1, size(pairs%list)
      ! Overlap at which the material first yields; huge: it never yields.
      critical = huge(critical)
      associate (pair => pairs%list(i))
        if (self%yield_stress > 0.0_real64) then
          strain = 0.5_real64 * pi * self%law%constraint * &
                   (scale(self%yield_stress, -pairs%modulus_power) / pairs%modulus)
          if (strain < 1.0e150_real64) critical = pair%radius * strain**2
        else if (pair%limit < 0.5_real64 * huge(critical)) then
          critical = stable_overlap(pair%s, pair%d, pair%zc, pair%rest, pair%limit)
          if (.not. self%limit_is_yield) critical = critical / departure
        end if
      end associate
      self%law%critical(i) = max(critical, tiny(critical))
    end do
  end subroutine begin_plasticity

  !> Keeps the largest overlap of each contact.
  subroutine keep_plasticity(self, pairs, state)
    class(plasticity_effect), intent(inout) :: self  !! plasticity, gets the history
    type(contact_pairs), intent(in) :: pairs         !! pairs of the position
    type(contact_state), intent(in) :: state         !! contacts with all effects
    integer :: i

    self%before_hold = self%estimate(pairs, state)
    do i = 1, size(pairs%list)
      if (.not. state%penetration(i) > 0.0_real64) cycle
      self%law%largest(i) = max(self%law%largest(i), state%answers(i)%overlap)
    end do
  end subroutine keep_plasticity

end module asperity_plasticity
