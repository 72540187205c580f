!> Friction between two spheres, one above the other and offset in plan, compressed vertically.
!>
!> The upper body moves down without lateral motion or rotation, so a pair moves tangentially as
!> well as normally: with the height z between the centres, their distance in plan d and the overlap
!> W, the tangential displacement U obeys dU = tan(slope) dW, tan(slope) = d/z. The slope increases
!> slightly with the compression. Increments: dT = 8 G a dU, dN = 2 E a dW with
!> the contact radius a and 1/G = (2-nu1)/G1 + (2-nu2)/G2 (Mindlin and Deresiewicz 1953; Walton
!> 1978; Johnson, Contact Mechanics, 1985, chapter 7). So dT/dN = kappa d/z with kappa = 4 G/E.
!>
!> - kappa d/z <= mu: no slip anywhere, T is the integral of kappa d/z over N.
!> - kappa U > mu W: complete sliding, T = mu N.
!> - Between: stick within a radius c and slip outside. The traction, mu times the difference of
!>   the Hertz pressures of radii a and c, displaces the inside of c uniformly (Cattaneo, Mindlin;
!>   for paths Jaeger 1993, Ciavarella 1998). The stick part is that at the contact radius c:
!>   T = mu (N - N(c)) + T(c), where U - U(c) = (mu/kappa) (W - W(c)).
!>
!> Within the assumptions of Hertz and Mindlin this is exact for the actual path. N is taken as
!> proportional to W**1.5; for another law the shares of stick and slip are those of Hertz' law.
module asperity_friction
  use asperity_contact_law, only: contact_response
  use asperity_contact_pairs, only: contact_pair
  use asperity_effect_header, only: area, column_name, force, length, plain, stiffness
  use asperity_gauss_rule, only: gauss_node, gauss_points, gauss_weight
  use asperity_kinds, only: not_computed, real64
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: rubbing, shared_poisson_ratio, solve_friction, stiffness_ratio_of, &
            tangential_stiffness_ratio
  public :: slip_contact_columns, slip_state_columns

  !> Friction of one contact. Zeros where it does not touch.
  type :: rubbing
    real(real64) :: tangential_load = 0.0_real64  !! T >= 0; on the upper body up the slope
    logical :: sliding = .false.                  !! complete sliding, T = mu N
    real(real64) :: slip_annulus = 0.0_real64     !! its width over contact radius; 0 stick, 1 slide
    real(real64) :: stick_radius = 0.0_real64     !! radius c of the circle that sticks
    real(real64) :: lateral_x = 0.0_real64        !! force on the upper body in plan, of N and T
    real(real64) :: lateral_y = 0.0_real64        !! force on the upper body in plan, of N and T
    real(real64) :: vertical_load = 0.0_real64    !! N cos + T sin
    real(real64) :: stiffness = 0.0_real64        !! d vertical_load / d penetration
  end type rubbing

  ! Largest coefficient of friction that is used; above it all contacts stick. Chosen: products
  ! with it do not overflow.
  real(real64), parameter :: largest_coefficient = 1.0e100_real64

  !> Columns of a contact under a tangential load, the same for asperities and pixels: its share of
  !> the load, the area that sticks.
  type(column_name), parameter :: slip_contact_columns(2) = [ &
    column_name('shear_load', force(1), force(2)), column_name('stick_area', area(1), area(2))]
  !> Columns of the last state; `slides` is 1 in complete sliding.
  type(column_name), parameter :: slip_state_columns(5) = [ &
    column_name('tangential_load', force(1), force(2)), &
    column_name('tangential_displacement', length(1), length(2)), &
    column_name('tangential_stiffness', stiffness(1), stiffness(2)), &
    column_name('stick_area', area(1), area(2)), column_name('slides', plain(1), plain(2))]

contains

  !> Tangential over normal stiffness of a contact, kappa = 4 G/E with 1/G = (2-nu1)/G1 +
  !> (2-nu2)/G2 and 1/E = (1-nu1**2)/E1 + (1-nu2**2)/E2 (Johnson 1985, sections 7.2 and 4.2).
  !>
  !> 2 (1-nu)/(2-nu) for equal materials: from 2/3 at nu = 0.5 to 4/3 at nu = -1. Mindlin's value:
  !> for unlike materials it neglects the coupling of normal and tangential displacements.
  elemental function tangential_stiffness_ratio(e1, nu1, e2, nu2) result(kappa)
    real(real64), intent(in) :: e1   !! elastic modulus, more than 0
    real(real64), intent(in) :: nu1  !! Poisson's ratio, -1 to 0.5
    real(real64), intent(in) :: e2   !! elastic modulus, more than 0, in the unit of `e1`
    real(real64), intent(in) :: nu2  !! Poisson's ratio, -1 to 0.5
    real(real64) :: kappa            !! ratio of the stiffnesses, dimensionless
    real(real64) :: larger, c1, c2

    ! Shear compliances up to a common factor.
    larger = max(e1, e2)
    c1 = (1.0_real64 + nu1) * (e2 / larger)
    c2 = (1.0_real64 + nu2) * (e1 / larger)
    if (c1 + c2 > 0.0_real64) then
      kappa = 2.0_real64 * ((1.0_real64 - nu1) * c1 + (1.0_real64 - nu2) * c2) / &
              ((2.0_real64 - nu1) * c1 + (2.0_real64 - nu2) * c2)
    else
      ! Limit where both are -1 and the shear moduli are infinite.
      kappa = 4.0_real64 / 3.0_real64
    end if
  end function tangential_stiffness_ratio

  !> Tangential over normal stiffness of the two bodies of a scene, kappa.
  pure real(real64) function stiffness_ratio_of(scene_in)
    type(scene), intent(in) :: scene_in  !! scene with moduli and ratios of both bodies

    stiffness_ratio_of = tangential_stiffness_ratio(scene_in%upper%elastic_modulus, &
      scene_in%upper%poisson_ratio, scene_in%lower%elastic_modulus, scene_in%lower%poisson_ratio)
  end function stiffness_ratio_of

  !> Poisson's ratio of two equal bodies with the same tangential displacements, m/g with
  !> g = 1/G1 + 1/G2 and m = nu1/G1 + nu2/G2; `not_computed` where moduli are not given.
  pure real(real64) function shared_poisson_ratio(scene_in) result(ratio)
    type(scene), intent(in) :: scene_in  !! scene with moduli and ratios of both bodies
    real(real64) :: compliance(2)

    ratio = not_computed
    associate (a => scene_in%upper, b => scene_in%lower)
      if (scene_in%contact_modulus > 0.0_real64 .or. &
          .not. min(a%elastic_modulus, b%elastic_modulus) > 0.0_real64) return
      compliance = (1.0_real64 + [a%poisson_ratio, b%poisson_ratio]) * &
        ([b%elastic_modulus, a%elastic_modulus] / max(a%elastic_modulus, b%elastic_modulus))
      ratio = -1.0_real64
      if (sum(compliance) > 0.0_real64) &
        ratio = sum([a%poisson_ratio, b%poisson_ratio] * compliance) / sum(compliance)
    end associate
  end function shared_poisson_ratio

  !> Solves the friction of a contact that was compressed from first touch to a penetration.
  pure subroutine solve_friction(pair, penetration, response, kappa, coefficient, rubbed)
    type(contact_pair), intent(in) :: pair          !! geometry of the contact
    real(real64), intent(in) :: penetration         !! vertical, past first touch; less than zc
    type(contact_response), intent(in) :: response  !! frictionless response to this penetration
    real(real64), intent(in) :: kappa               !! tangential over normal stiffness
    real(real64), intent(in) :: coefficient         !! coefficient of friction mu >= 0
    type(rubbing), intent(out) :: rubbed            !! friction of the contact
    real(real64) :: mu, z, centres, sine, cosine, slope, share, stuck, load, outward, rate

    if (.not. (penetration > 0.0_real64 .and. response%load > 0.0_real64)) return
    mu = min(coefficient, largest_coefficient)
    z = pair%zc - penetration
    centres = sqrt(pair%d**2 + z**2)
    sine = pair%d / centres
    cosine = z / centres
    slope = pair%d / z

    stuck = stuck_penetration(pair, penetration, kappa, mu)
    if (stuck > 0.0_real64) then
      share = 1.0_real64
      ! Overlap at the stuck penetration over that at the whole one.
      if (stuck < penetration) share = min(share, &
        (stuck / penetration) * ((pair%zc + (pair%zc - stuck)) / (pair%zc + z)) * &
        ((pair%s + centres) / (pair%s + sqrt(pair%d**2 + (pair%zc - stuck)**2))))
      load = response%load * share * sqrt(share)
      rubbed%tangential_load = kappa * mean_slope(pair, stuck) * load
      ! Complete stick has no term with mu, which may be huge.
      if (share < 1.0_real64) rubbed%tangential_load = rubbed%tangential_load + &
                                                       mu * (response%load - load)
      share = sqrt(share)
    else
      share = 0.0_real64
      rubbed%sliding = .true.
      rubbed%tangential_load = mu * response%load
    end if
    rubbed%stick_radius = share * response%contact_radius
    rubbed%slip_annulus = 1.0_real64 - share

    rubbed%vertical_load = response%vertical_load + rubbed%tangential_load * sine
    ! The force in plan is > 0 from the lower centre to the upper one.
    outward = response%load * sine - rubbed%tangential_load * cosine
    if (pair%d > 0.0_real64) then
      rubbed%lateral_x = outward * ((pair%upper_x - pair%lower_x) / pair%d)
      rubbed%lateral_y = outward * ((pair%upper_y - pair%lower_y) / pair%d)
    end if
    ! Derivatives: dN/dp of the law, dT/dp = 8 G c dU/dp + mu (dN/dp - 2 E c dW/dp).
    rate = (response%stiffness + response%load * sine**2 / centres) / cosine
    rate = rate * share * kappa * slope + merge(rate * (1.0_real64 - share) * mu, 0.0_real64, &
                                               share < 1.0_real64)
    rubbed%stiffness = response%stiffness + rate * sine + &
                       rubbed%tangential_load * sine * cosine / centres
  end subroutine solve_friction

  ! The penetration at which the contact radius was the stick radius c at p: p with complete stick,
  ! 0 with complete sliding. Between two states of the path, exactly,
  !   U - U' = 2 d atanh(q), W - W' = (z' - z) (z + z') / (D + D'), q = (z' - z) / (D + D')
  ! with D the distance of the centres, so the secant U - U' = (mu/kappa) (W - W') is
  !   2 d atanh(q)/q = (mu/kappa) (z + z').
  ! It has no cancellation, and the fixed-point iteration for z' converges fast, as q is small.
  pure function stuck_penetration(pair, p, kappa, mu) result(stuck)
    type(contact_pair), intent(in) :: pair
    real(real64), intent(in) :: p, kappa, mu
    real(real64) :: stuck, z, centres, steepest, before, rise, q
    ! Chosen: bounds the iteration, which ends by its last test.
    integer, parameter :: most_turns = 100
    integer :: turn

    stuck = p
    z = pair%zc - p
    if (kappa * pair%d <= mu * z) return
    centres = sqrt(pair%d**2 + z**2)
    stuck = 0.0_real64
    if (2.0_real64 * kappa * pair%d * atanh_ratio(p / (pair%s + centres)) > &
        mu * (pair%zc + z)) return
    ! Here mu > 0. Below this height the slope exceeds the limit of stick.
    steepest = kappa * pair%d / mu
    stuck = min(max(2.0_real64 * (pair%zc - steepest) - p, 0.0_real64), p)
    do turn = 1, most_turns
      rise = p - stuck
      q = rise / (centres + sqrt(pair%d**2 + (pair%zc - stuck)**2))
      before = stuck
      stuck = 2.0_real64 * (pair%zc - steepest * atanh_ratio(q)) - p
      stuck = min(max(stuck, 0.0_real64), p)
      if (abs(stuck - before) <= 0.5_real64 * epsilon(stuck) * pair%zc) exit
    end do
  end function stuck_penetration

  ! atanh(q)/q.
  elemental function atanh_ratio(q) result(ratio)
    real(real64), intent(in) :: q
    real(real64) :: ratio

    if (q < 1.0e-3_real64) then
      ratio = 1.0_real64 + q**2 * (1.0_real64 / 3.0_real64 + q**2 * &
                                   (0.2_real64 + q**2 / 7.0_real64))
    else
      ratio = atanh(q) / q
    end if
  end function atanh_ratio

  ! Mean of d/z over the load, from first touch to P. With p = P t**2 and W = p (zc + z)/(s + D)
  ! the integrand is smooth. Error of ten points: 1e-14 for P up to zc/4, 2e-10 up to zc/2.
  pure function mean_slope(pair, p) result(mean)
    type(contact_pair), intent(in) :: pair
    real(real64), intent(in) :: p
    real(real64) :: mean
    real(real64), dimension(gauss_points) :: z, centres
    real(real64) :: last, total

    z = pair%zc - p * gauss_node**2
    centres = sqrt(pair%d**2 + z**2)
    total = sum(gauss_weight * gauss_node**2 * sqrt((pair%zc + z) / (pair%s + centres)) / centres)
    last = pair%zc - p
    last = (pair%s + sqrt(pair%d**2 + last**2)) / (pair%zc + last)
    mean = 3.0_real64 * pair%d * last * sqrt(last) * total
  end function mean_slope

end module asperity_friction
