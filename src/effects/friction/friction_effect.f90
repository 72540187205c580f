!> Friction on inclined contacts, as an effect of a scene.
module asperity_friction_effect
  use asperity_contact_effect, only: contact_effect, effect_outcome, force, moment, plain
  use asperity_contact_law, only: contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: contact_state
  use asperity_friction, only: rubbing, solve_friction, stiffness_ratio_of
  use asperity_kinds, only: real64
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: new_friction

  !> Friction with one coefficient for all contacts.
  type, extends(contact_effect) :: friction_effect
    real(real64) :: coefficient = 0.0_real64  !! coefficient of friction, 0 or more
    real(real64) :: kappa = 1.0_real64        !! tangential over normal stiffness
  contains
    procedure :: estimate => estimate_by_friction
    procedure :: apply => apply_friction
    procedure :: leave_out
  end type friction_effect

contains

  !> Makes the effect from its parameters in a scene.
  subroutine new_friction(scene_in, effect)
    type(scene), intent(in) :: scene_in                             !! scene with checked values
    class(contact_effect), allocatable, intent(out) :: effect       !! effect of the scene
    type(friction_effect) :: new

    call new%call_as('friction', scene_in%effects)
    new%coefficient = scene_in%effects%number('friction_coefficient')
    new%kappa = stiffness_ratio_of(scene_in)
    allocate (effect, source=new)
  end subroutine new_friction

  !> Upper bound of the relative increase of the vertical load at the compression: the sum of T sin
  !> over that of N cos, with T at most mu N and at most kappa d/z N.
  function estimate_by_friction(self, pairs, state) result(share)
    class(friction_effect), intent(in) :: self  !! friction with its parameters
    type(contact_pairs), intent(in) :: pairs    !! pairs of the position
    type(contact_state), intent(in) :: state    !! contacts without friction
    real(real64) :: share
    type(contact_response) :: response
    real(real64) :: total, z
    integer :: i

    share = 0.0_real64
    total = 0.0_real64
    do i = 1, size(pairs%list)
      associate (pair => pairs%list(i))
        if (pair%gap >= state%compression) exit
        call state%law%respond(pair, i, state%compression - pair%gap, response)
        z = pair%zc - (state%compression - pair%gap)
        total = total + response%vertical_load
        share = share + min(self%coefficient, self%kappa * (pair%d / z)) * response%load * &
                (pair%d / sqrt(pair%d**2 + z**2))
      end associate
    end do
    if (total > 0.0_real64) share = share / total
  end function estimate_by_friction

  !> Adds the tangential force of each contact.
  subroutine apply_friction(self, pairs, state, outcome)
    class(friction_effect), intent(in) :: self      !! friction with its parameters
    type(contact_pairs), intent(in) :: pairs        !! pairs of the position
    type(contact_state), intent(inout) :: state     !! gets the vertical loads with friction
    type(effect_outcome), intent(inout) :: outcome  !! gets the columns

    call add_friction(self, pairs, state%penetration, state%answers, outcome)
    outcome%simulated = 'on'
  end subroutine apply_friction

  !> Sets the columns where friction is left out of the vertical loads: forces in plan may be large.
  subroutine leave_out(self, pairs, state, outcome)
    class(friction_effect), intent(in) :: self      !! friction with its parameters
    type(contact_pairs), intent(in) :: pairs        !! pairs of the position
    type(contact_state), intent(in) :: state        !! contacts without friction
    type(effect_outcome), intent(inout) :: outcome  !! gets the columns
    type(contact_response) :: answers(size(pairs%list))

    answers = state%answers
    call add_friction(self, pairs, state%penetration, answers, outcome)
  end subroutine leave_out

  ! Adds friction to all responses and sets the columns. The forces and moments of the rig balance
  ! those of the contacts on the upper body. Moments are about the origin of the plan; those about
  ! x and y are of the vertical loads alone, with all contacts in one plane.
  subroutine add_friction(self, pairs, penetration, answers, outcome)
    class(friction_effect), intent(in) :: self
    type(contact_pairs), intent(in) :: pairs
    real(real64), intent(in) :: penetration(:)
    type(contact_response), intent(inout) :: answers(:)
    type(effect_outcome), intent(inout) :: outcome
    type(rubbing) :: rubbed
    type(contact_response) :: pressed
    ! Tangential load, complete sliding, width of the slip annulus over the contact radius, lateral
    ! forces.
    real(real64), allocatable :: values(:, :)
    real(real64) :: frictionless, rig(5)
    integer :: i

    allocate (values(size(pairs%list), 5), source=0.0_real64)
    frictionless = sum(answers%vertical_load)
    rig = 0.0_real64
    do i = 1, size(pairs%list)
      if (.not. penetration(i) > 0.0_real64) cycle
      pressed = answers(i)
      ! Boundary elements have vertical loads only.
      if (.not. pressed%cosine < 1.0_real64) then
        pressed%cosine = (pairs%list(i)%zc - penetration(i)) / &
                         sqrt(pairs%list(i)%d**2 + (pairs%list(i)%zc - penetration(i))**2)
        pressed%load = pressed%vertical_load / pressed%cosine
      end if
      call solve_friction(pairs%list(i), penetration(i), pressed, self%kappa, self%coefficient, &
                          rubbed)
      associate (pair => pairs%list(i))
        rig(:2) = rig(:2) + [rubbed%lateral_x, rubbed%lateral_y]
        rig(3:4) = rig(3:4) + [pair%y, -pair%x] * rubbed%vertical_load
        rig(5) = rig(5) + pair%x * rubbed%lateral_y - pair%y * rubbed%lateral_x
      end associate
      answers(i)%vertical_load = rubbed%vertical_load
      answers(i)%stiffness = rubbed%stiffness
      values(i, :) = [rubbed%tangential_load, merge(1.0_real64, 0.0_real64, rubbed%sliding), &
                      rubbed%slip_annulus, rubbed%lateral_x, rubbed%lateral_y]
    end do
    associate (of_contacts => outcome%of_contacts, of_state => outcome%of_state)
      call of_contacts%add('tangential_load', force, values(:, 1))
      call of_contacts%add('sliding', plain, values(:, 2))
      call of_contacts%add('slip_annulus', plain, values(:, 3))
      call of_contacts%add('lateral_x', force, values(:, 4))
      call of_contacts%add('lateral_y', force, values(:, 5))
      call of_state%add('frictionless_load', force, frictionless)
      call of_state%add('sliding_contacts', plain, sum(values(:, 2)))
      call of_state%add('rig_force_x', force, -rig(1))
      call of_state%add('rig_force_y', force, -rig(2))
      call of_state%add('rig_moment_x', moment, -rig(3))
      call of_state%add('rig_moment_y', moment, -rig(4))
      call of_state%add('rig_moment_z', moment, -rig(5))
    end associate
  end subroutine add_friction

end module asperity_friction_effect
