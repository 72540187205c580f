!> Attraction of two surfaces across their gap, behind a hard wall: energy and traction.
!>
!> With the work of adhesion w and the distance z0 of surfaces in contact, per area,
!>
!>     exponential:    e(g) = -w exp(-g/rho),      s(g) = w/rho exp(-g/rho),   rho = 9 sqrt(3)/16 z0
!>     van der Waals:  e(g) = -w (1 + g/z0)**-2,   s(g) = 2 w/z0 (1 + g/z0)**-3
!>
!> s = de/dg is positive and decreases with the gap: e is concave. The range rho = 0.974 z0 gives
!> the exponential law the work and the greatest traction of the attraction between molecules, as
!> the constant traction of Maugis (1992) has them. The second law is that of Hamaker (1937) with
!> the constant 12 pi w z0**2.
module asperity_attraction_law
  use asperity_effect_names, only: law_exponential
  use asperity_kinds, only: real64
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: attraction_at, attraction_law, new_attraction, pixel_steepness, share_of_work

  ! rho over z0 (derived: greatest attraction of the potential of Lennard and Jones, Maugis 1992).
  real(real64), parameter :: exponential_range = 9.0_real64 * sqrt(3.0_real64) / 16.0_real64

  !> Attraction of one pair of surfaces.
  type :: attraction_law
    integer :: form = law_exponential     !! `law_exponential` or `law_van_der_waals`
    real(real64) :: work = 0.0_real64     !! work of adhesion w [force/length], > 0
    real(real64) :: reach = 1.0_real64    !! rho or z0 [length], > 0
  end type attraction_law

contains

  !> Makes the law of a scene with a work of adhesion > 0.
  type(attraction_law) function new_attraction(scene_in) result(law)
    type(scene), intent(in) :: scene_in  !! scene with checked values

    law%form = nint(scene_in%effects%number('adhesion_law'))
    law%work = scene_in%effects%number('work_of_adhesion')
    law%reach = scene_in%effects%number('equilibrium_distance')
    if (law%form == law_exponential) law%reach = exponential_range * law%reach
  end function new_attraction

  !> Attraction s [pressure] at a gap; at a gap below 0 that of contact.
  elemental real(real64) function attraction_at(law, gap) result(traction)
    type(attraction_law), intent(in) :: law  !! attraction of the surfaces
    real(real64), intent(in) :: gap          !! gap of the surfaces [length]

    associate (x => max(gap / law%reach, 0.0_real64))
      if (law%form == law_exponential) then
        traction = law%work / law%reach * exp(-min(x, 700.0_real64))
      else
        traction = 2.0_real64 * law%work / law%reach / (1.0_real64 + x)**3
      end if
    end associate
  end function attraction_at

  !> Work that is left to separate the surfaces from a gap, over the work of adhesion, from the
  !> attraction there.
  elemental real(real64) function share_of_work(law, traction) result(share)
    type(attraction_law), intent(in) :: law   !! attraction of the surfaces
    real(real64), intent(in) :: traction      !! attraction s at the gap [pressure]

    share = traction / attraction_at(law, 0.0_real64)
    if (law%form /= law_exponential) share = share**(2.0_real64 / 3.0_real64)
  end function share_of_work

  !> Greatest decrease of the attraction with the gap, times the pixel spacing over the modulus.
  !> Where it exceeds about 1 neighbouring pixels jump into contact one by one.
  pure real(real64) function pixel_steepness(law, pixel, modulus) result(steepness)
    type(attraction_law), intent(in) :: law  !! attraction of the surfaces
    real(real64), intent(in) :: pixel        !! spacing of the pixels [length]
    real(real64), intent(in) :: modulus      !! combined modulus [pressure]

    steepness = law%work / law%reach / modulus * (pixel / law%reach)
    if (law%form /= law_exponential) steepness = 6.0_real64 * steepness
  end function pixel_steepness

end module asperity_attraction_law
