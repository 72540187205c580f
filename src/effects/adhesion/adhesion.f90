!> Adhesion between asperities, as an effect that a scene names.
!>
!> It replaces the law of every contact and asks it anew for each penetration. What a contact
!> answers across a gap depends on whether it adhered before, so the effect keeps this from one
!> state of a position to the next.
module asperity_adhesion
  use asperity_adhesion_contact, only: adhesion_numbers
  use asperity_adhesion_law, only: adhesion_law, new_adhesion_law
  use asperity_contact_effect, only: contact_effect, effect_outcome, set_columns
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: answer_all, contact_state
  use asperity_decimal, only: decimal_to_real64
  use asperity_kinds, only: int64, real64
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: new_adhesion, adhesion_of

  !> Adhesion with one work of adhesion for all contacts, in the units of the scene.
  type, extends(contact_effect) :: adhesion_effect
    real(real64) :: work = 0.0_real64      !! of adhesion, modulus times length, 0 or more
    real(real64) :: distance = 1.0_real64  !! of equilibrium, length, more than 0
    logical, allocatable :: adhered(:)     !! by the number of the contact, at the state before
  contains
    procedure :: estimate
    procedure :: apply
  end type adhesion_effect

contains

  !> Adhesion as the scene names it.
  subroutine new_adhesion(scene_in, effect)
    type(scene), intent(in) :: scene_in                        !! checked values
    class(contact_effect), allocatable, intent(out) :: effect  !! ready to act
    real(real64) :: distance

    distance = 1.0_real64
    ! Without work of adhesion no distance is needed.
    if (scene_in%effects%equilibrium_distance%digits /= 0_int64) &
      distance = decimal_to_real64(scene_in%effects%equilibrium_distance)
    call adhesion_of(scene_in%effects%adhesion, &
                     decimal_to_real64(scene_in%effects%work_of_adhesion), distance, effect)
  end subroutine new_adhesion

  !> Adhesion with explicit numbers.
  subroutine adhesion_of(mode, work, distance, effect)
    integer, intent(in) :: mode            !! `effect_off`, `effect_on` or `effect_auto`
    real(real64), intent(in) :: work       !! of adhesion, in the scene's units, 0 or more
    real(real64), intent(in) :: distance   !! of equilibrium, in the scene's units, more than 0
    class(contact_effect), allocatable, intent(out) :: effect  !! ready to act
    type(adhesion_effect) :: new

    new%name = 'adhesion'
    new%mode = mode
    new%work = work
    new%distance = distance
    new%begin => begin_position
    new%keep => keep_state
    call set_columns(new%contact_columns, &
                     [character(len=20) :: 'adhering', 'pull_off_force', 'tabor_parameter'], &
                     reshape([0, 0, 1, 2, 0, 0], [2, 3]))
    call set_columns(new%state_columns, &
                     [character(len=20) :: 'adhering_contacts', 'pulling_contacts', &
                      'pull_off_sum'], reshape([0, 0, 0, 0, 1, 2], [2, 3]))
    allocate (effect, source=new)
  end subroutine adhesion_of

  !> Sum of the largest pulls of the contacts that adhere, over the total vertical load. Adhesion
  !> takes no more than that from the load of a contact that is pressed.
  function estimate(self, pairs, state) result(share)
    class(adhesion_effect), intent(in) :: self  !! adhesion
    type(contact_pairs), intent(in) :: pairs    !! the position
    type(contact_state), intent(in) :: state    !! without adhesion
    real(real64) :: share
    type(adhesion_law) :: law
    real(real64) :: load, pull
    integer :: i

    share = 0.0_real64
    if (.not. self%work > 0.0_real64) return
    call make_law(self, pairs, law)
    pull = 0.0_real64
    do i = 1, size(pairs%list)
      if (law%holds(pairs%list(i), i, state%penetration(i))) pull = pull + law%known(i)%pull_off
    end do
    load = sum(state%answers%vertical_load)
    if (.not. pull > 0.0_real64) return
    share = huge(share)
    if (load > 0.0_real64) share = pull / load
  end function estimate

  !> Answers the penetrations of the state with adhesion.
  subroutine apply(self, pairs, state, outcome)
    class(adhesion_effect), intent(in) :: self      !! adhesion
    type(contact_pairs), intent(in) :: pairs        !! the position
    type(contact_state), intent(inout) :: state     !! gets law and answers with adhesion
    type(effect_outcome), intent(inout) :: outcome  !! what it did
    type(adhesion_law) :: law
    real(real64) :: pull
    integer :: adhering, i

    call make_law(self, pairs, law)
    if (allocated(state%law)) deallocate (state%law)
    allocate (state%law, source=law)
    call answer_all(pairs, state)
    allocate (outcome%of_contacts(size(pairs%list), 3), outcome%of_state(3))
    outcome%of_contacts = 0.0_real64
    pull = 0.0_real64
    adhering = 0
    do i = 1, size(pairs%list)
      outcome%of_contacts(i, 2:) = [law%known(i)%pull_off, law%known(i)%tabor]
      if (.not. law%holds(pairs%list(i), i, state%penetration(i))) cycle
      outcome%of_contacts(i, 1) = 1.0_real64
      adhering = adhering + 1
      pull = pull + law%known(i)%pull_off
    end do
    outcome%of_state = [real(adhering, real64), &
                        real(count(state%answers%load < 0.0_real64), real64), pull]
    outcome%simulated = 'on'
  end subroutine apply

  ! Nothing adheres where nothing has touched yet.
  subroutine begin_position(self, pairs)
    class(contact_effect), intent(inout) :: self
    type(contact_pairs), intent(in) :: pairs

    select type (self)
    type is (adhesion_effect)
      if (allocated(self%adhered)) deallocate (self%adhered)
      allocate (self%adhered(size(pairs%list)))
      self%adhered = .false.
    end select
  end subroutine begin_position

  ! Remembers which contacts adhere.
  subroutine keep_state(self, pairs, state)
    class(contact_effect), intent(inout) :: self
    type(contact_pairs), intent(in) :: pairs
    type(contact_state), intent(in) :: state
    type(adhesion_law) :: law
    integer :: i

    select type (self)
    type is (adhesion_effect)
      call make_law(self, pairs, law)
      if (allocated(self%adhered)) deallocate (self%adhered)
      allocate (self%adhered(size(pairs%list)))
      do i = 1, size(pairs%list)
        self%adhered(i) = law%holds(pairs%list(i), i, state%penetration(i))
      end do
    end select
  end subroutine keep_state

  ! The law in the units of the pairs, with what the effect remembers.
  subroutine make_law(self, pairs, law)
    class(adhesion_effect), intent(in) :: self
    type(contact_pairs), intent(in) :: pairs
    type(adhesion_law), intent(out) :: law
    type(adhesion_numbers) :: numbers

    numbers%modulus = pairs%modulus
    numbers%work = scale(self%work, -4 * (pairs%modulus_power + pairs%length_power))
    numbers%distance = scale(self%distance, -4 * pairs%length_power)
    call new_adhesion_law(numbers, pairs, law)
    if (.not. allocated(self%adhered)) return
    if (size(self%adhered) == size(pairs%list)) law%adhered = self%adhered
  end subroutine make_law

end module asperity_adhesion
