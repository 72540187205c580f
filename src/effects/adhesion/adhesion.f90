!> Adhesion between asperities, as an effect of a scene.
!>
!> It replaces the law of each contact and evaluates it. The load across a gap depends on whether
!> the contact adhered before, so this is kept from one state of a position to the next.
module asperity_adhesion
  use asperity_adhesion_law, only: adhering_contact, adhesion_law, adhesion_numbers, begin_law, &
                                   complete_contact, complete_law, model_dmt, &
                                   range_of_attraction, respond_along_centres
  use asperity_contact_effect, only: contact_effect, effect_outcome, force, plain, &
                                     relative_influence
  use asperity_contact_law, only: contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: answer_all, contact_state
  use asperity_kinds, only: real64
  use asperity_scene_values, only: scene
  use asperity_theory_warnings, only: of_range, of_tabor, warn_above
  implicit none
  private

  public :: adhesion_effect, new_adhesion

  !> Adhesion with one work of adhesion for all contacts, in the units of the scene.
  type, extends(contact_effect) :: adhesion_effect
    real(real64) :: work = 0.0_real64      !! of adhesion, modulus times length, 0 or more
    real(real64) :: distance = 1.0_real64  !! of equilibrium, length, more than 0
    !> of a position with the state of its contacts; complete for those that adhere
    type(adhesion_law) :: law
  contains
    procedure :: estimate => estimate_adhesion
    procedure :: apply => apply_adhesion
    procedure :: leave_out
    procedure :: begin => begin_adhesion
    procedure :: keep => keep_adhesion
  end type adhesion_effect

contains

  !> Makes the effect from its parameters in a scene.
  subroutine new_adhesion(scene_in, effect)
    type(scene), intent(in) :: scene_in                        !! scene with checked values
    class(contact_effect), allocatable, intent(out) :: effect  !! effect without history
    type(adhesion_effect) :: new

    call new%call_as('adhesion', scene_in%effects)
    new%work = scene_in%effects%number('work_of_adhesion')
    new%distance = scene_in%effects%number('equilibrium_distance')
    if (new%work > 0.0_real64) new%reach = range_of_attraction * new%distance
    allocate (effect, source=new)
  end subroutine new_adhesion

  !> Sum of the pull-off forces of the contacts that adhere: an upper bound of the change of the
  !> load. The growth of the area, if that is larger: at the compression, and under a prescribed
  !> load by the further compression as well.
  function estimate_adhesion(self, pairs, state) result(share)
    class(adhesion_effect), intent(in) :: self  !! adhesion with its history
    type(contact_pairs), intent(in) :: pairs    !! pairs of the position
    type(contact_state), intent(in) :: state    !! contacts without adhesion
    real(real64) :: share
    type(adhering_contact) :: contact
    type(contact_response) :: answer
    real(real64) :: area, added, load, pull
    integer :: i

    share = 0.0_real64
    if (.not. self%work > 0.0_real64) return
    added = 0.0_real64
    pull = 0.0_real64
    do i = 1, pairs_within(self, pairs, state)
      if (.not. self%law%is_adhering(pairs%list(i), i, state%penetration(i))) cycle
      contact = self%law%known(i)
      call complete_contact(self%law%numbers, contact)
      pull = pull + contact%pull_off
      call respond_along_centres(self%law%numbers, contact, self%law%adhered(i), pairs%list(i), &
                                 state%penetration(i), answer)
      added = added + abs(answer%contact_radius**2 - state%answers(i)%contact_radius**2)
    end do
    load = sum(state%answers%vertical_load)
    if (.not. pull > 0.0_real64) return
    share = huge(share)
    if (.not. load > 0.0_real64) return
    share = relative_influence(pull, load, load - pull)
    area = sum(state%answers%contact_radius**2)
    added = relative_influence(added, area, area + added)
    ! Hertz: the contact area is proportional to the power 2/3 of the load.
    if (pairs%target > 0.0_real64) added = added + 2.0_real64 / 3.0_real64 * share
    share = max(share, added)
  end function estimate_adhesion

  !> Sets the law with adhesion in a state and evaluates it.
  subroutine apply_adhesion(self, pairs, state, outcome)
    class(adhesion_effect), intent(in) :: self      !! adhesion with its history
    type(contact_pairs), intent(in) :: pairs        !! pairs of the position
    type(contact_state), intent(inout) :: state     !! gets the law and the loads with adhesion
    type(effect_outcome), intent(inout) :: outcome  !! gets columns and warnings
    type(adhesion_law) :: law
    real(real64) :: distance, smaller
    integer :: i

    if (.not. is_prepared(self, state)) then
      law = self%law
      if (allocated(state%prepared)) deallocate (state%prepared)
      call complete_law(law)
      allocate (state%prepared, source=law)
    end if
    if (allocated(state%law)) deallocate (state%law)
    allocate (state%law, source=state%prepared)
    select type (its_law => state%law)
    type is (adhesion_law)
      its_law%adhered = self%law%adhered
    end select
    call answer_all(pairs, state)
    call self%leave_out(pairs, state, outcome)
    outcome%simulated = 'on'
    ! The pull-off force of Derjaguin, Muller and Toporov exceeds that of Maugis near its limit.
    ! Attraction over a gap of 0.045 R acts up to 0.3 R from the axis, where a sphere deviates from
    ! a paraboloid.
    distance = scale(self%distance, -pairs%length_power)
    do i = 1, size(pairs%list)
      if (.not. outcome%of_contacts%values(i, 1) > 0.0_real64) cycle
      associate (known => self%law%known(i), pair => pairs%list(i))
        smaller = min(pair%upper_radius, pair%lower_radius)
        if (.not. smaller > 0.0_real64) smaller = max(pair%upper_radius, pair%lower_radius)
        call warn_above(outcome%warnings, of_range, distance / smaller, 1)
        if (known%model == model_dmt) &
          call warn_above(outcome%warnings, of_tabor, outcome%of_contacts%values(i, 3), 1)
      end associate
    end do
  end subroutine apply_adhesion

  ! Whether the law that a state has prepared is that of the same contacts.
  logical function is_prepared(self, state)
    class(adhesion_effect), intent(in) :: self
    type(contact_state), intent(in) :: state

    is_prepared = .false.
    if (.not. allocated(state%prepared)) return
    select type (law => state%prepared)
    type is (adhesion_law)
      if (size(law%known) /= size(self%law%known)) return
      is_prepared = .not. (any(abs(law%known%radius - self%law%known%radius) > 0.0_real64) .or. &
                           abs(law%numbers%work - self%law%numbers%work) > 0.0_real64 .or. &
                           abs(law%numbers%distance - self%law%numbers%distance) > 0.0_real64)
    end select
  end function is_prepared

  !> Sets the columns, also where adhesion is left out: they need the penetrations only.
  subroutine leave_out(self, pairs, state, outcome)
    class(adhesion_effect), intent(in) :: self      !! adhesion with its history
    type(contact_pairs), intent(in) :: pairs        !! pairs of the position
    type(contact_state), intent(in) :: state        !! contacts without adhesion
    type(effect_outcome), intent(inout) :: outcome  !! gets the columns
    type(adhering_contact) :: contact
    ! Whether a contact adheres, its largest tensile load and its Tabor parameter.
    real(real64), allocatable :: values(:, :)
    integer :: i

    allocate (values(size(pairs%list), 3), source=0.0_real64)
    do i = 1, pairs_within(self, pairs, state)
      contact = self%law%known(i)
      if (.not. self%law%is_adhering(pairs%list(i), i, state%penetration(i))) cycle
      call complete_contact(self%law%numbers, contact)
      values(i, :) = [1.0_real64, contact%pull_off, contact%tabor]
    end do
    associate (of_contacts => outcome%of_contacts, of_state => outcome%of_state)
      call of_contacts%add('adhering', plain, values(:, 1))
      call of_contacts%add('pull_off_force', force, values(:, 2))
      call of_contacts%add('tabor_parameter', plain, values(:, 3))
      call of_state%add('adhering_contacts', plain, sum(values(:, 1)))
      call of_state%add('pulling_contacts', plain, &
                        real(count(state%answers%load < 0.0_real64), real64))
      call of_state%add('pull_off_sum', force, sum(values(:, 2)))
    end associate
  end subroutine leave_out

  ! Number of the first pairs that may adhere: from open surfaces those within the range of the
  ! attraction. Pairs are sorted by their gap.
  pure integer function pairs_within(self, pairs, state) result(number)
    class(adhesion_effect), intent(in) :: self
    type(contact_pairs), intent(in) :: pairs
    type(contact_state), intent(in) :: state
    real(real64) :: range_of_pull

    number = size(pairs%list)
    if (any(self%law%adhered)) return
    range_of_pull = range_of_attraction * scale(self%distance, -pairs%length_power)
    do while (number > 0)
      if (pairs%list(number)%gap <= state%compression + 2.0_real64 * range_of_pull) return
      number = number - 1
    end do
  end function pairs_within

  !> Begins a position without adhering contacts.
  subroutine begin_adhesion(self, pairs)
    class(adhesion_effect), intent(inout) :: self  !! adhesion, gets the law
    type(contact_pairs), intent(in) :: pairs       !! pairs of the position
    type(adhesion_numbers) :: numbers

    numbers%modulus = pairs%modulus
    numbers%work = scale(self%work, -(pairs%modulus_power + pairs%length_power))
    numbers%distance = scale(self%distance, -pairs%length_power)
    call begin_law(numbers, pairs, self%law)
  end subroutine begin_adhesion

  !> Keeps which contacts adhere.
  subroutine keep_adhesion(self, pairs, state)
    class(adhesion_effect), intent(inout) :: self  !! adhesion, gets the history
    type(contact_pairs), intent(in) :: pairs       !! pairs of the position
    type(contact_state), intent(in) :: state       !! contacts with all effects
    integer :: i

    do i = 1, size(pairs%list)
      self%law%adhered(i) = self%law%is_adhering(pairs%list(i), i, state%penetration(i))
      ! Where it separates follows from its curve.
      if (self%law%adhered(i)) call complete_contact(self%law%numbers, self%law%known(i))
    end do
  end subroutine keep_adhesion

end module asperity_adhesion
