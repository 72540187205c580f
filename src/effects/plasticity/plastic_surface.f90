!> The plasticity index of the surfaces of a scene (Greenwood and Williamson 1966, Proc. R. Soc. A
!> 295, 300): below 0.6 contacts are elastic but at very large pressures; above 1 some contacts are
!> plastic at any pressure.
module asperity_plastic_surface
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  use asperity_plastic_curves, only: departure
  use asperity_scene_values, only: combined_modulus, criterion_greenwood_williamson, &
                                   criterion_hardy, criterion_load, criterion_pressure, scene
  implicit none
  private

  public :: surface_index, surface_hardness, combined_radius, height_deviation

contains

  !> The index (E/H) sqrt(sigma/R). The standard deviation sigma is that of the sum of both
  !> surfaces' heights; R is combined from the mean radii, or on a plane the mean radius. The
  !> hardness H is that of the limit, else 2.84 times the yield stress, else E sqrt(w/R) with the
  !> overlap w at the onset. Negative: the scene has neither a limit nor a yield stress, or a number
  !> is out of range.
  pure real(real64) function surface_index(scene_in) result(found)
    type(scene), intent(in) :: scene_in  !! scene with checked values
    real(real64) :: deviation, hardness, radius

    found = -1.0_real64
    deviation = hypot(height_deviation(scene_in%upper%height), &
                      height_deviation(scene_in%lower%height))
    radius = combined_radius(scene_in)
    hardness = surface_hardness(scene_in)
    if (.not. (hardness > 0.0_real64 .and. radius > 0.0_real64)) return
    found = (combined_modulus(scene_in) / hardness) * sqrt(deviation / radius)
    if (.not. found <= huge(found)) found = -1.0_real64
  end function surface_index

  !> Standard deviation of the heights of all summits (of the population); 0 for a plane.
  pure real(real64) function height_deviation(height)
    real(real64), intent(in) :: height(:)  !! height of each summit

    height_deviation = 0.0_real64
    if (size(height) == 0) return
    height_deviation = norm2(height - mean_value(height)) / sqrt(real(size(height), real64))
  end function height_deviation

  !> Radius of two spheres of the mean radii together, or on a plane the mean radius.
  pure real(real64) function combined_radius(scene_in) result(radius)
    type(scene), intent(in) :: scene_in  !! scene with checked values

    associate (upper => scene_in%upper, lower => scene_in%lower)
      if (upper%is_plane) then
        radius = mean_value(lower%radius)
      else if (lower%is_plane) then
        radius = mean_value(upper%radius)
      else
        radius = 1.0_real64 / (1.0_real64 / mean_value(upper%radius) + &
                               1.0_real64 / mean_value(lower%radius))
      end if
    end associate
  end function combined_radius

  !> Hardness of a scene [modulus], from its limit or its yield stress; 0: it has neither.
  pure real(real64) function surface_hardness(scene_in) result(hardness)
    type(scene), intent(in) :: scene_in  !! scene with checked values
    real(real64) :: load_share, modulus, radius

    hardness = 0.0_real64
    modulus = combined_modulus(scene_in)
    radius = combined_radius(scene_in)
    associate (limit => scene_in%limit, effects => scene_in%effects)
      if (limit%criterion == criterion_greenwood_williamson) then
        hardness = limit%hardness
      else if (effects%number('plastic_yield_stress') > 0.0_real64) then
        hardness = 2.84_real64 * effects%number('plastic_yield_stress')
      else if (limit%criterion == criterion_load) then
        ! (w/R)**1.5 of Hertz' law.
        load_share = 0.75_real64 * (limit%value / modulus / radius) / radius
        hardness = modulus * load_share**(1.0_real64 / 3.0_real64)
      else if (limit%criterion == criterion_pressure) then
        hardness = 0.75_real64 * pi * limit%value
      else if (limit%criterion == criterion_hardy) then
        ! The greatest pressure at first yield is 2.76 times the shear stress.
        hardness = 0.5_real64 * pi * 2.76_real64 * limit%yield_stress * sqrt(departure)
      end if
    end associate
  end function surface_hardness

  pure real(real64) function mean_value(values)
    real(real64), intent(in) :: values(:)

    mean_value = sum(values / size(values))
  end function mean_value

end module asperity_plastic_surface
