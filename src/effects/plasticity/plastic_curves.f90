!> Curves of an elastic-plastic sphere, without units.
!>
!> Overlaps x are multiples of the critical one, w_c = (pi C Sy/(2 E))**2 R, at which the material
!> first yields below the surface. Loading: Jackson and Green 2005 (J. Tribology 127, 343), joined
!> to Hertz at x = 1.9. Unloading: Etsion, Kligerman and Kadin 2005 (Int. J. Solids Struct. 42,
!> 3716), from first yield on. docs/theory/plasticity.md says how.
module asperity_plastic_curves
  use asperity_constants, only: pi
  use asperity_gauss_rule, only: gauss_node, gauss_points, gauss_weight
  use asperity_kinds, only: real64
  implicit none
  private

  public :: plastic_scale, set_scale, loading_curve, unloading_shape
  public :: loading_work, plasticity_index, departure

  !> Overlap at which the load leaves that of Hertz (Jackson and Green 2005).
  real(real64), parameter :: departure = 1.9_real64

  !> Overlap from which the published fits hold as they are: where the plastic zone reaches the
  !> surface (Kogut and Etsion 2002, J. Appl. Mech. 69, 657).
  real(real64), parameter :: joined = 6.0_real64

  !> Largest Sy/E that the exponent of the area was fitted to: 1.619 GPa in a steel of 200 GPa with
  !> Poisson's ratio 0.32.
  real(real64), parameter :: largest_yield_strain = 1.619_real64 * (1.0_real64 - 0.32_real64**2) / &
                                                    200.0_real64

  !> What sets the curves of a contact apart.
  type :: plastic_scale
    real(real64) :: constraint = 1.6_real64   !! C: pressure over yield stress where it yields
    real(real64) :: strain = 0.0_real64       !! sqrt(w_c/R), contact radius over R at w_c
    real(real64) :: area_power = 0.14_real64  !! B
    real(real64) :: start = 1.0_real64        !! published load over that of Hertz at x = 1.9
    real(real64) :: start_share = 1.0_real64  !! share of its elastic term there
  end type plastic_scale

contains

  !> The scale of a contact. The yield strain Sy/E follows from C and the overlap; where it is
  !> larger than any that was fitted, B stays at the largest fitted value.
  pure subroutine set_scale(constraint, strain, scale)
    real(real64), intent(in) :: constraint     !! C, more than 0
    real(real64), intent(in) :: strain         !! sqrt(w_c/R), more than 0
    type(plastic_scale), intent(out) :: scale  !! of the contact
    real(real64) :: elastic, plastic, slope

    scale%constraint = constraint
    scale%strain = strain
    scale%area_power = 0.14_real64 * exp(23.0_real64 * &
                       min(2.0_real64 * strain / (pi * constraint), largest_yield_strain))
    call published_terms(scale, departure, elastic, plastic, slope)
    scale%start = elastic + plastic
    scale%start_share = elastic / scale%start
  end subroutine set_scale

  !> Load and contact radius on first loading past x = 1.9, as multiples of those of Hertz at the
  !> same overlap. All are 1 and flat at 1.9 and below.
  pure subroutine loading_curve(scale, x, ratio, slope, spread, peak)
    type(plastic_scale), intent(in) :: scale  !! of the contact
    real(real64), intent(in) :: x             !! overlap over the critical one
    real(real64), intent(out) :: ratio        !! load over that of Hertz
    real(real64), intent(out) :: slope        !! d ratio / d x
    real(real64), intent(out) :: spread       !! contact radius over that of Hertz
    real(real64), intent(out) :: peak         !! greatest pressure over the average one; estimate
    real(real64) :: elastic, plastic, step, step_slope, factor

    ratio = 1.0_real64
    slope = 0.0_real64
    spread = 1.0_real64
    peak = 1.5_real64
    if (.not. x > departure) return
    call published_terms(scale, x, elastic, plastic, slope)
    call smooth_step(x, step, step_slope)
    factor = (1.0_real64 - step) / scale%start + step
    ratio = (elastic + plastic) * factor
    slope = slope * factor + &
            (elastic + plastic) * step_slope * (1.0_real64 - 1.0_real64 / scale%start)
    spread = (x / departure)**(0.5_real64 * scale%area_power)
    peak = 1.0_real64 + 0.5_real64 * min(1.0_real64, elastic / (elastic + plastic) / &
                                         scale%start_share)
  end subroutine loading_curve

  !> Unloading from a largest overlap x, and loading again up to it: the load is
  !> P_x ((w - w_res)/(w_x - w_res))**load_power, the area likewise. The fit as published, from
  !> x = 1 on, where it is that of Hertz. It would give back more than was put in up to x = 1.2, by
  !> 0.002 in the power: there the power is the least one that does not, with which the load is
  !> never above that of loading.
  pure subroutine unloading_shape(x, residual, load_power, area_power)
    real(real64), intent(in) :: x            !! largest overlap over the critical one
    real(real64), intent(out) :: residual    !! overlap without load over the largest one, 0 to 1
    real(real64), intent(out) :: load_power  !! 1.5 or less
    real(real64), intent(out) :: area_power  !! 1 or less

    residual = 0.0_real64
    load_power = 1.5_real64
    area_power = 1.0_real64
    if (.not. x > 1.0_real64) return
    residual = (1.0_real64 - x**(-0.28_real64)) * (1.0_real64 - x**(-0.69_real64))
    load_power = 1.5_real64 * max(x**(-0.0331_real64), 1.0_real64 - residual)
    area_power = x**(-0.12_real64)
  end subroutine unloading_shape

  !> Work of first loading up to x, in units of the load times the overlap where x is 1.
  pure real(real64) function loading_work(scale, x)
    type(plastic_scale), intent(in) :: scale  !! of the contact
    real(real64), intent(in) :: x             !! overlap over the critical one, 0 to 1e100
    real(real64) :: low, high, last
    integer :: i, panels

    loading_work = 0.4_real64 * min(x, departure)**2.5_real64
    if (.not. x > departure) return
    loading_work = loading_work + panel(scale, log(departure), log(min(x, joined)))
    if (.not. x > joined) return
    last = log(x)
    panels = ceiling(last - log(joined))
    low = log(joined)
    do i = 1, panels
      high = log(joined) + (last - log(joined)) * i / panels
      loading_work = loading_work + panel(scale, low, high)
      low = high
    end do
  end function loading_work

  !> The plasticity index (E/H) sqrt(sigma/R) of Greenwood and Williamson 1966 (Proc. R. Soc. A
  !> 295, 300). Below 0.6 contacts stay elastic at all but very large pressures, above 1 some flow
  !> at any pressure.
  elemental real(real64) function plasticity_index(deviation, radius, modulus, hardness)
    real(real64), intent(in) :: deviation  !! standard deviation of the summit heights
    real(real64), intent(in) :: radius     !! of the summits, in the unit of the deviation
    real(real64), intent(in) :: modulus    !! combined modulus
    real(real64), intent(in) :: hardness   !! in the unit of the modulus

    plasticity_index = (modulus / hardness) * sqrt(deviation / radius)
  end function plasticity_index

  ! The two terms of the published load over that of Hertz, and the slope of their sum.
  pure subroutine published_terms(scale, x, elastic, plastic, slope)
    type(plastic_scale), intent(in) :: scale
    real(real64), intent(in) :: x
    real(real64), intent(out) :: elastic, plastic, slope
    real(real64) :: radius, exponent, hardness, hardness_slope, grown, growth, root

    root = sqrt(x)
    ! Contact radius over R, and the limit H/Sy of the average pressure that belongs to it.
    radius = scale%strain * root * (x / departure)**(0.5_real64 * scale%area_power)
    exponent = 0.82_real64 * radius**(-0.7_real64)
    hardness = 2.84_real64 * (1.0_real64 - exp(-exponent))
    hardness_slope = -2.84_real64 * exp(-exponent) * exponent * 0.35_real64 * &
                     (1.0_real64 + scale%area_power) / x
    elastic = exp(-0.25_real64 * x**(5.0_real64 / 12.0_real64))
    growth = x**(5.0_real64 / 9.0_real64) / 25.0_real64
    grown = 1.0_real64 - exp(-growth)
    plastic = 4.0_real64 / scale%constraint * hardness * grown / root
    slope = -elastic * (5.0_real64 / 48.0_real64) * x**(-7.0_real64 / 12.0_real64) + &
            4.0_real64 / scale%constraint / root * &
            (hardness_slope * grown + &
             hardness / x * (exp(-growth) * growth * (5.0_real64 / 9.0_real64) - &
                             0.5_real64 * grown))
  end subroutine published_terms

  ! From 0 at the departure to 1 where the fits are joined.
  pure subroutine smooth_step(x, step, slope)
    real(real64), intent(in) :: x
    real(real64), intent(out) :: step, slope
    real(real64) :: t

    t = min(1.0_real64, max(0.0_real64, (x - departure) / (joined - departure)))
    step = t * t * (3.0_real64 - 2.0_real64 * t)
    slope = 6.0_real64 * t * (1.0_real64 - t) / (joined - departure)
  end subroutine smooth_step

  ! Work between two logarithms of x, by ten Gauss points.
  pure real(real64) function panel(scale, low, high)
    type(plastic_scale), intent(in) :: scale
    real(real64), intent(in) :: low, high
    real(real64) :: ratio, slope, spread, peak, x
    integer :: i

    panel = 0.0_real64
    do i = 1, gauss_points
      x = exp(low + (high - low) * gauss_node(i))
      call loading_curve(scale, x, ratio, slope, spread, peak)
      panel = panel + (high - low) * gauss_weight(i) * ratio * x**2.5_real64
    end do
  end function panel

end module asperity_plastic_curves
