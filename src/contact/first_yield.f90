!> The pressure at which the material of a scene first yields, from what the scene gives.
module asperity_first_yield
  use asperity_decimal, only: decimal_to_real64
  use asperity_kinds, only: real64
  use asperity_scene_values, only: criterion_greenwood_williamson, criterion_hardy, scene
  implicit none
  private

  public :: constraint_factor, yield_pressure

  ! Greatest over average pressure of Hertz.
  real(real64), parameter :: peak = 1.5_real64

contains

  !> C of Jackson and Green (2005): greatest pressure of Hertz over the yield stress in tension when
  !> the material first yields. Below 0 the value for 0: the fit was made for 0 to 0.5.
  pure real(real64) function constraint_factor(poisson_ratio)
    real(real64), intent(in) :: poisson_ratio  !! of the body that yields, -1 to 0.5

    constraint_factor = 1.295_real64 * exp(0.736_real64 * max(poisson_ratio, 0.0_real64))
  end function constraint_factor

  !> Average pressure of a contact at which the scene's material yields; huge: it gives neither a
  !> yield stress nor a hardness. A yield stress in tension counts first, of the body with the
  !> smaller Poisson's ratio; a hardness is the pressure itself; Hardy and others (1971): the
  !> greatest pressure is 2.76 times the yield stress in shear.
  pure real(real64) function yield_pressure(scene_in) result(pressure)
    type(scene), intent(in) :: scene_in  !! checked values
    real(real64) :: stress

    pressure = huge(pressure)
    stress = scene_in%effects%number('plastic_yield_stress')
    if (stress > 0.0_real64) then
      pressure = stress / peak * &
                 constraint_factor(min(decimal_to_real64(scene_in%upper%poisson_ratio), &
                                       decimal_to_real64(scene_in%lower%poisson_ratio)))
    else if (scene_in%limit%criterion == criterion_greenwood_williamson) then
      pressure = decimal_to_real64(scene_in%limit%hardness)
    else if (scene_in%limit%criterion == criterion_hardy) then
      pressure = 2.76_real64 / peak * decimal_to_real64(scene_in%limit%yield_stress)
    end if
  end function yield_pressure

end module asperity_first_yield
