!> Friction on inclined contacts, as an effect that a scene names.
module asperity_friction_effect
  use asperity_contact_effect, only: column, contact_effect, effect_outcome, force, moment, plain
  use asperity_contact_law, only: contact_response
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_contact_state, only: contact_state
  use asperity_decimal, only: decimal_to_real64
  use asperity_friction, only: estimate_of_friction, rub, rubbing, tangential_stiffness_ratio
  use asperity_kinds, only: real64
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: new_friction

  !> Friction with one coefficient for all contacts.
  type, extends(contact_effect) :: friction_effect
    real(real64) :: coefficient = 0.0_real64  !! 0 or more
    real(real64) :: kappa = 1.0_real64        !! tangential over normal stiffness
  contains
    procedure :: estimate
    procedure :: apply
    procedure :: leave_out
  end type friction_effect

contains

  !> Friction as the scene names it.
  subroutine new_friction(scene_in, effect)
    type(scene), intent(in) :: scene_in                             !! checked values
    class(contact_effect), allocatable, intent(out) :: effect       !! ready to act
    type(friction_effect) :: new

    call new%call_as('friction', scene_in%effects)
    new%coefficient = scene_in%effects%number('friction_coefficient')
    new%kappa = tangential_stiffness_ratio( &
      decimal_to_real64(scene_in%upper%elastic_modulus), &
      decimal_to_real64(scene_in%upper%poisson_ratio), &
      decimal_to_real64(scene_in%lower%elastic_modulus), &
      decimal_to_real64(scene_in%lower%poisson_ratio))
    new%contact_columns = [ &
      column('tangential_load', force), &                       ! up the slope
      column('sliding', plain), &                               ! 1: slips all over
      column('slip_annulus', plain), &                          ! its width over contact radius
      column('lateral_x', force), column('lateral_y', force)]   ! on the upper body, in plan
    new%state_columns = [ &
      column('frictionless_load', force), & ! vertical, without friction
      column('sliding_contacts', plain), &                      ! how many slip all over
      column('rig_force_x', force), column('rig_force_y', force), &
      column('rig_moment_x', moment), column('rig_moment_y', moment), &
      column('rig_moment_z', moment)]
    allocate (effect, source=new)
  end subroutine new_friction

  !> Upper bound of the share by which friction raises the vertical load.
  function estimate(self, pairs, state) result(share)
    class(friction_effect), intent(in) :: self  !! friction
    type(contact_pairs), intent(in) :: pairs    !! the position
    type(contact_state), intent(in) :: state    !! without friction
    real(real64) :: share

    share = estimate_of_friction(pairs, state%law, state%closing, self%kappa, self%coefficient)
  end function estimate

  !> Adds the tangential force of every contact.
  subroutine apply(self, pairs, state, outcome)
    class(friction_effect), intent(in) :: self      !! friction
    type(contact_pairs), intent(in) :: pairs        !! the position
    type(contact_state), intent(inout) :: state     !! gets the vertical loads with friction
    type(effect_outcome), intent(inout) :: outcome  !! what it did

    call rub_all(self, pairs, state%penetration, state%answers, outcome)
    outcome%simulated = 'on'
    outcome%ending%converged = .true.
    outcome%ending%residual = 0.0_real64
  end subroutine apply

  !> Left out of the vertical load, it is known all the same: forces in plan need not be small.
  subroutine leave_out(self, pairs, state, outcome)
    class(friction_effect), intent(in) :: self      !! friction
    type(contact_pairs), intent(in) :: pairs        !! the position
    type(contact_state), intent(in) :: state        !! without friction
    type(effect_outcome), intent(inout) :: outcome  !! gets the columns
    type(contact_response) :: answers(size(pairs%list))

    answers = state%answers
    call rub_all(self, pairs, state%penetration, answers, outcome)
  end subroutine leave_out

  ! Adds friction to all answers and sets the columns. The rig holds the upper body with the
  ! opposite of what the contacts do to it. The moments are about the origin of the plan; those
  ! about x and y are of the vertical loads alone: heights count from the plane of the contacts.
  subroutine rub_all(self, pairs, penetration, answers, outcome)
    class(friction_effect), intent(in) :: self
    type(contact_pairs), intent(in) :: pairs
    real(real64), intent(in) :: penetration(:)
    type(contact_response), intent(inout) :: answers(:)
    type(effect_outcome), intent(inout) :: outcome
    type(rubbing) :: rubbed
    type(contact_response) :: pressed
    real(real64) :: frictionless, rig(5)
    integer :: i, sliding

    allocate (outcome%of_contacts(size(pairs%list), 5), source=0.0_real64)
    frictionless = sum(answers%vertical_load)
    rig = 0.0_real64
    sliding = 0
    do i = 1, size(pairs%list)
      if (.not. penetration(i) > 0.0_real64) cycle
      call along_normal(pairs%list(i), penetration(i), answers(i), pressed)
      call rub(pairs%list(i), penetration(i), pressed, self%kappa, self%coefficient, rubbed)
      associate (pair => pairs%list(i))
        rig(:2) = rig(:2) + [rubbed%lateral_x, rubbed%lateral_y]
        rig(3:4) = rig(3:4) + [pair%y, -pair%x] * rubbed%vertical_load
        rig(5) = rig(5) + pair%x * rubbed%lateral_y - pair%y * rubbed%lateral_x
      end associate
      answers(i)%vertical_load = rubbed%vertical_load
      answers(i)%stiffness = rubbed%stiffness
      if (rubbed%sliding) sliding = sliding + 1
      outcome%of_contacts(i, :) = [rubbed%tangential_load, &
                                   merge(1.0_real64, 0.0_real64, rubbed%sliding), &
                                   rubbed%slip_annulus, rubbed%lateral_x, rubbed%lateral_y]
    end do
    outcome%of_state = [frictionless, real(sliding, real64), -rig]
  end subroutine rub_all

  ! The answer with the load that is normal to the contact. Cells know vertical loads only.
  pure subroutine along_normal(pair, penetration, answer, pressed)
    type(contact_pair), intent(in) :: pair
    real(real64), intent(in) :: penetration
    type(contact_response), intent(in) :: answer
    type(contact_response), intent(out) :: pressed
    real(real64) :: centres, cosine

    pressed = answer
    if (answer%cosine < 1.0_real64) return
    centres = sqrt(pair%d**2 + (pair%zc - penetration)**2)
    cosine = (pair%zc - penetration) / centres
    pressed%cosine = cosine
    pressed%load = answer%vertical_load / cosine
  end subroutine along_normal

end module asperity_friction_effect
