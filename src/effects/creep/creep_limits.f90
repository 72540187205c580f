!> The limits of the theory of creep, for asperities and for pixels.
module asperity_creep_limits
  use asperity_kinds, only: real64
  use asperity_scene_values, only: body_compliance, hold_load, scene
  use asperity_theory_warnings, only: add_warning, of_creep_strain, of_relaxing, of_unlike_bodies, &
                                      theory_warning, warn_above
  use asperity_viscoelastic_solid, only: creep_compliance, relaxation_ratio, relaxing_solid, &
                                         solid_of_scene
  implicit none
  private

  public :: creep_limits, creep_share, limits_of_scene, warn_of_strain, warn_of_time

  ! Representative strain over contact radius by combined radius (Tabor 1951). Test:
  ! test_creep_strain of test_warnings.py.
  real(real64), parameter :: strain_per_radius = 0.2_real64
  ! Power of the load in the compression of a contact. Derived (Hertz). Test: test_relaxing of
  ! test_warnings.py.
  real(real64), parameter :: two_thirds = 2.0_real64 / 3.0_real64

  !> Material, hold and tolerance of a scene.
  type :: creep_limits
    type(relaxing_solid) :: solid                   !! material of both bodies
    real(real64) :: hold_time = 0.0_real64          !! duration of the hold, 0 or more
    logical :: holds_load = .true.                  !! the load is held; else the separation
    real(real64) :: softer_share = 1.0_real64       !! share of the softer body in the compliance
    real(real64) :: unlike = 0.0_real64             !! share of the compliance with another solid
    real(real64) :: tolerance = 0.0_real64          !! of the scene, relative
  end type creep_limits

contains

  !> The limits of a scene.
  pure type(creep_limits) function limits_of_scene(scene_in) result(limits)
    type(scene), intent(in) :: scene_in  !! scene with checked values
    real(real64) :: compliances(2)

    associate (effects => scene_in%effects)
      limits%solid = solid_of_scene(scene_in)
      limits%hold_time = effects%number('hold_time')
      limits%holds_load = nint(effects%number('hold')) == hold_load
      limits%tolerance = effects%number('tolerance')
    end associate
    if (abs(scene_in%contact_modulus) > 0.0_real64 .or. &
        .not. min(scene_in%upper%elastic_modulus, scene_in%lower%elastic_modulus) > 0.0_real64) &
      return
    compliances = body_compliance([scene_in%upper%elastic_modulus, &
                                   scene_in%lower%elastic_modulus], &
                                  [scene_in%upper%poisson_ratio, scene_in%lower%poisson_ratio])
    limits%softer_share = maxval(compliances) / sum(compliances)
    ! It is 0 for equal bodies and for a rigid one.
    limits%unlike = minval(compliances) / sum(compliances) * &
                    (1.0_real64 - minval(compliances) / maxval(compliances))
  end function limits_of_scene

  !> Decrease of the load at the end of a hold of the separation over the load there, as
  !> `relative_influence` has it; in a hold of the load the compression changes by less.
  pure real(real64) function creep_share(limits) result(share)
    type(creep_limits), intent(in) :: limits  !! of the scene

    associate (ratio => relaxation_ratio(limits%solid, limits%solid%loading_time + &
                                         limits%hold_time))
      share = (1.0_real64 - ratio) / max(ratio, 0.5_real64)
    end associate
  end function creep_share

  !> Warns of a contact with a strain beyond the linear range.
  pure subroutine warn_of_strain(limits, contact_radius, radius, warnings)
    type(creep_limits), intent(in) :: limits        !! of the scene
    real(real64), intent(in) :: contact_radius      !! of the contact, 0 or more
    real(real64), intent(in) :: radius              !! combined radius, more than 0
    type(theory_warning), allocatable, intent(inout) :: warnings(:)  !! of the state

    call warn_above(warnings, of_creep_strain, strain_per_radius * limits%softer_share * &
                    contact_radius / radius, 1)
  end subroutine warn_of_strain

  !> Warns of unlike bodies, and at the end of a hold that ends before relaxation does. In a hold of
  !> the load the compression of one contact still increases by the power 2/3 of the compliance.
  pure subroutine warn_of_time(limits, time, warnings)
    type(creep_limits), intent(in) :: limits        !! of the scene
    real(real64), intent(in) :: time                !! time since the begin of loading
    type(theory_warning), allocatable, intent(inout) :: warnings(:)  !! of the state
    real(real64) :: to_come

    associate (solid => limits%solid, hold_time => limits%hold_time)
      if (time > 0.0_real64 .and. limits%unlike > limits%tolerance) &
        call add_warning(warnings, of_unlike_bodies, limits%unlike)
      if (time < solid%loading_time + hold_time .or. .not. hold_time > 0.0_real64) return
      if (limits%holds_load) then
        to_come = (1.0_real64 / (solid%relaxed_ratio * &
                   creep_compliance(solid, hold_time)))**two_thirds - 1.0_real64
      else
        to_come = 1.0_real64 - solid%relaxed_ratio / relaxation_ratio(solid, hold_time)
      end if
    end associate
    if (to_come > limits%tolerance) call add_warning(warnings, of_relaxing, to_come)
  end subroutine warn_of_time

end module asperity_creep_limits
