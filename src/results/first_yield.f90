!> The pressure at which the material of a scene first yields.
module asperity_first_yield
  use asperity_kinds, only: real64
  use asperity_scene_values, only: criterion_greenwood_williamson, criterion_hardy, scene
  implicit none
  private

  public :: constraint_factor, yield_pressure, yielding_body, yielding_factor

  ! Greatest over average pressure of a Hertzian contact.
  real(real64), parameter :: peak = 1.5_real64

contains

  !> Factor C of Jackson and Green (2005): greatest pressure of Hertz over the yield stress in
  !> tension at first yield. The fit is for 0 to 0.5; below 0 it is the value for 0.
  pure real(real64) function constraint_factor(poisson_ratio)
    real(real64), intent(in) :: poisson_ratio  !! Poisson's ratio of the body that yields, -1 to 0.5

    constraint_factor = 1.295_real64 * exp(0.736_real64 * max(poisson_ratio, 0.0_real64))
  end function constraint_factor

  !> The body that yields, 1: upper, 2: lower. That of `plastic_body`, else the one with the smaller
  !> elastic modulus; with equal moduli the one with the smaller Poisson's ratio, whose C is
  !> smaller.
  pure integer function yielding_body(scene_in) result(body)
    type(scene), intent(in) :: scene_in  !! scene with checked values
    real(real64) :: modulus(2), ratio(2)

    body = nint(scene_in%effects%number('plastic_body'))
    if (body > 0) return
    associate (upper => scene_in%upper, lower => scene_in%lower)
      modulus = [upper%elastic_modulus, lower%elastic_modulus]
      ratio = [upper%poisson_ratio, lower%poisson_ratio]
    end associate
    body = minloc(modulus, 1)
    if (.not. abs(modulus(1) - modulus(2)) > 0.0_real64) body = minloc(ratio, 1)
  end function yielding_body

  !> Factor C of the body that yields.
  pure real(real64) function yielding_factor(scene_in) result(factor)
    type(scene), intent(in) :: scene_in  !! scene with checked values

    factor = constraint_factor(merge(scene_in%upper%poisson_ratio, &
                               scene_in%lower%poisson_ratio, yielding_body(scene_in) == 1))
  end function yielding_factor

  !> Average pressure of a contact at which the material of a scene yields; huge: the scene has
  !> neither a yield stress nor a hardness. It is from the yield stress in tension of the body that
  !> yields; else it is the hardness; else the greatest pressure is 2.76 times the yield stress in
  !> shear (Hardy and others 1971).
  pure real(real64) function yield_pressure(scene_in) result(pressure)
    type(scene), intent(in) :: scene_in  !! scene with checked values
    real(real64) :: stress

    pressure = huge(pressure)
    stress = scene_in%effects%number('plastic_yield_stress')
    if (stress > 0.0_real64) then
      pressure = stress / peak * yielding_factor(scene_in)
    else if (scene_in%limit%criterion == criterion_greenwood_williamson) then
      pressure = scene_in%limit%hardness
    else if (scene_in%limit%criterion == criterion_hardy) then
      pressure = 2.76_real64 / peak * scene_in%limit%yield_stress
    end if
  end function yield_pressure

end module asperity_first_yield
