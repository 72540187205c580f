!> Plastic flow past the elastic limit, as an effect that a scene names.
!>
!> It gives every contact the law of Hertz up to its onset, of Jackson and Green past it, and
!> remembers through the states of a position how far each was pressed.
module asperity_plasticity
  use asperity_constants, only: pi
  use asperity_contact_effect, only: column, contact_effect, effect_outcome, force, length, &
                                     moment, plain
  use asperity_contact_law, only: contact_response
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_contact_state, only: answer_all, contact_state
  use asperity_first_yield, only: yielding_factor
  use asperity_hertz_law, only: hertz_law
  use asperity_kernel_real64, only: stable_overlap
  use asperity_kinds, only: real64
  use asperity_plastic_curves, only: departure
  use asperity_plastic_law, only: past_of_contact, plastic_law, plastic_past
  use asperity_scene_values, only: criterion_hardy, scene
  use asperity_theory_warnings, only: of_flow_depth, of_unloading_depth, of_yield_strain, warn, &
                                      warning_kinds
  implicit none
  private

  public :: new_plasticity

  !> Plastic flow.
  type, extends(contact_effect) :: plasticity_effect
    real(real64) :: yield_stress = 0.0_real64    !! in tension, in the scene's unit; 0: see limit
    logical :: limit_is_yield = .false.          !! the limit is the first yield, not the departure
    real(real64) :: before_hold = 0.0_real64     !! estimate at the last state kept
    type(plastic_law) :: law                     !! of a position, with what its contacts remember
  contains
    procedure :: estimate
    procedure :: apply
    procedure :: begin
    procedure :: keep
    procedure :: finish
  end type plasticity_effect

contains

  !> Plasticity as the scene names it.
  subroutine new_plasticity(scene_in, effect)
    type(scene), intent(in) :: scene_in                         !! checked values
    class(contact_effect), allocatable, intent(out) :: effect   !! ready to act
    type(plasticity_effect) :: new

    call new%call_as('plasticity', scene_in%effects)
    new%law%constraint = yielding_factor(scene_in)
    new%yield_stress = scene_in%effects%number('plastic_yield_stress')
    new%limit_is_yield = scene_in%limit%criterion == criterion_hardy
    new%contact_columns = [ &
      column('plastic', plain), &                           ! 1: has passed its onset
      column('largest_overlap', length), &                  ! so far
      column('residual_overlap', length)]                   ! without load
    new%state_columns = [ &
      column('hertz_load', force), &  ! of Hertz at the same penetrations
      column('contacts_flowing', plain), &                  ! how many flow now
      column('dissipated_work', moment), &                  ! lost since first touch
      column('residual_flattening', length)]                ! greatest residual overlap
    allocate (effect, source=new)
  end subroutine new_plasticity

  !> Change of the total vertical load, or of the area if that is more, by flow and by what is left
  !> of earlier flow, in full: the law answers for itself. The others only see less load, so it is
  !> not below the truth. Under a load the surfaces close until it is borne, and the area is that
  !> of one Newton step on: as the load is convex on loading, not below the truth either. In a hold
  !> pressures fall while the surfaces close: what has not flowed at its begin does not flow later,
  !> so that state's estimate stays.
  function estimate(self, pairs, state) result(share)
    class(plasticity_effect), intent(in) :: self  !! plasticity
    type(contact_pairs), intent(in) :: pairs      !! the position
    type(contact_state), intent(in) :: state      !! without plasticity
    real(real64) :: share
    type(contact_response) :: answer
    real(real64) :: changed, lost, stiffness, area, total, further
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
      further = min(lost / stiffness, state%closing)
    area = 0.0_real64
    do i = 1, size(pairs%list)
      if (.not. state%penetration(i) + further > 0.0_real64) cycle
      call self%law%respond(pairs%list(i), i, min(state%penetration(i) + further, &
                            0.999999_real64 * pairs%list(i)%zc), answer)
      area = area + abs(answer%contact_radius**2 - state%answers(i)%contact_radius**2)
    end do
    share = max(changed / total, area / sum(state%answers%contact_radius**2))
  end function estimate

  !> Gives the state the plastic law and asks again.
  subroutine apply(self, pairs, state, outcome)
    class(plasticity_effect), intent(in) :: self    !! plasticity
    type(contact_pairs), intent(in) :: pairs        !! the position
    type(contact_state), intent(inout) :: state     !! elastic, then with plastic flow
    type(effect_outcome), intent(inout) :: outcome  !! what it did

    deallocate (state%law)
    allocate (state%law, source=self%law)
    call answer_all(pairs, state)
    outcome%simulated = 'on'
    outcome%ending%converged = .true.
    outcome%ending%residual = 0.0_real64
  end subroutine apply

  !> Fills the columns from a state: later effects may have moved the contacts.
  subroutine finish(self, pairs, state, outcome)
    class(plasticity_effect), intent(in) :: self    !! plasticity
    type(contact_pairs), intent(in) :: pairs        !! the position
    type(contact_state), intent(in) :: state        !! with plastic flow
    type(effect_outcome), intent(inout) :: outcome  !! gets the columns
    type(plastic_past) :: past
    type(contact_response) :: answer
    real(real64) :: elastic_load, flattening, overlap, strain, work
    integer :: flowing, i

    allocate (outcome%of_contacts(size(pairs%list), 3))
    elastic_load = 0.0_real64
    work = 0.0_real64
    flattening = 0.0_real64
    flowing = 0
    do i = 1, size(pairs%list)
      call self%law%elastic%respond(pairs%list(i), i, state%penetration(i), answer)
      overlap = answer%overlap
      elastic_load = elastic_load + answer%vertical_load
      call past_of_contact(self%law, pairs%list(i), i, max(self%law%largest(i), overlap), past)
      outcome%of_contacts(i, :) = [merge(1.0_real64, 0.0_real64, past%flowed), past%largest, &
                                   past%residual]
      work = work + past%work_lost
      flattening = max(flattening, past%residual)
      if (.not. past%flowed) cycle
      ! w_c/R = (pi C Sy/(2 E))**2.
      strain = sqrt(self%law%critical(i) / pairs%list(i)%radius) / (0.5_real64 * pi * &
                                                                    self%law%constraint)
      call hold_against(of_yield_strain, strain)
      if (overlap >= self%law%largest(i)) then
        flowing = flowing + 1
        call hold_against(of_flow_depth, overlap / self%law%critical(i))
      else
        call hold_against(of_unloading_depth, self%law%largest(i) / self%law%critical(i))
      end if
    end do
    outcome%of_state = [elastic_load, real(flowing, real64), work, flattening]

  contains

    ! The range of the fits, but for rounding.
    subroutine hold_against(kind, found)
      integer, intent(in) :: kind
      real(real64), intent(in) :: found

      if (found > warning_kinds(kind)%limit * (1.0_real64 + 1.0e-9_real64)) &
        call warn(outcome%warnings, kind, found, contacts=1)
    end subroutine hold_against

  end subroutine finish

  ! Overlap at which the material of a contact first yields; huge: it never does.
  pure real(real64) function critical_overlap(self, pairs, pair)
    class(plasticity_effect), intent(in) :: self
    type(contact_pairs), intent(in) :: pairs
    type(contact_pair), intent(in) :: pair
    real(real64) :: strain

    critical_overlap = huge(1.0_real64)
    if (self%yield_stress > 0.0_real64) then
      strain = 0.5_real64 * pi * self%law%constraint * &
               (scale(self%yield_stress, -4 * pairs%modulus_power) / pairs%modulus)
      if (strain < 1.0e150_real64) critical_overlap = pair%radius * strain**2
    else if (pair%limit < 0.5_real64 * huge(1.0_real64)) then
      critical_overlap = stable_overlap(pair%s, pair%d, pair%zc, pair%rest, pair%limit)
      if (.not. self%limit_is_yield) critical_overlap = critical_overlap / departure
    end if
    critical_overlap = max(critical_overlap, tiny(1.0_real64))
  end function critical_overlap

  !> A position begins: its law, of contacts that were not pressed yet.
  subroutine begin(self, pairs)
    class(plasticity_effect), intent(inout) :: self  !! plasticity
    type(contact_pairs), intent(in) :: pairs         !! the position
    integer :: i

    if (allocated(self%law%largest)) deallocate (self%law%largest, self%law%critical)
    allocate (self%law%largest(size(pairs%list)), self%law%critical(size(pairs%list)))
    self%law%elastic = hertz_law(modulus=pairs%modulus)
    self%law%largest = 0.0_real64
    self%before_hold = 0.0_real64
    do i = 1, size(pairs%list)
      self%law%critical(i) = critical_overlap(self, pairs, pairs%list(i))
    end do
  end subroutine begin

  !> Keeps how far every contact was pressed.
  subroutine keep(self, pairs, state)
    class(plasticity_effect), intent(inout) :: self  !! plasticity
    type(contact_pairs), intent(in) :: pairs         !! the position
    type(contact_state), intent(in) :: state         !! all effects applied
    integer :: i

    self%before_hold = self%estimate(pairs, state)
    do i = 1, size(pairs%list)
      if (.not. state%penetration(i) > 0.0_real64) cycle
      self%law%largest(i) = max(self%law%largest(i), state%answers(i)%overlap)
    end do
  end subroutine keep

end module asperity_plasticity
