!> Curves of an elastic-plastic sphere, without units.
!>
!> Overlaps x are multiples of the critical one, w_c = (pi C Sy/(2 E))**2 R, at which the material
!> first yields below the surface. Loading: Jackson and Green 2005 (J. Tribology 127, 343), joined
!> to Hertz at x = 1.9. Unloading: Etsion, Kligerman and Kadin 2005 (Int. J. Solids Struct. 42,
!> 3716), from first yield on. Derivations: docs/theory/plasticity.md.
module asperity_plastic_curves
  use asperity_constants, only: pi
  use asperity_gauss_rule, only: gauss_node, gauss_points, gauss_weight
  use asperity_kinds, only: real64
  implicit none
  private

  public :: plastic_scale, set_scale, loading_curve, unloading_shape
  public :: loading_work, departure

  !> Overlap x up to which the load is that of Hertz (Jackson and Green 2005). Test:
  !> plasticity_suite.
  real(real64), parameter :: departure = 1.9_real64

  !> Overlap x from which the published fits are used unchanged: the plastic zone reaches the
  !> surface there (Kogut and Etsion 2002, J. Appl. Mech. 69, 657). Test: plasticity_suite.
  real(real64), parameter :: joined = 6.0_real64

  !> Largest Sy/E of the fit of the area power B (Jackson and Green 2005): 1.619 GPa in a steel of
  !> 200 GPa with Poisson's ratio 0.32. Test: plasticity_suite.
  real(real64), parameter :: largest_yield_strain = 1.619_real64 * (1.0_real64 - 0.32_real64**2) / &
                                                    200.0_real64

  !> Parameters of the curves of one contact.
  type :: plastic_scale
    real(real64) :: constraint = 1.6_real64   !! C, greatest pressure over Sy at first yield
    real(real64) :: strain = 0.0_real64       !! sqrt(w_c/R), contact radius over R at w_c
    real(real64) :: area_power = 0.14_real64  !! power B of the contact area
    real(real64) :: start = 1.0_real64        !! published load over that of Hertz at x = 1.9
    real(real64) :: start_share = 1.0_real64  !! share of the elastic term in it
  end type plastic_scale

contains

  !> Sets the parameters of a contact. The yield strain Sy/E follows from C and the overlap; beyond
  !> the range of the fit, B has its value at the end of the range.
  pure subroutine set_scale(constraint, strain, curve)
    real(real64), intent(in) :: constraint     !! constraint factor C > 0
    real(real64), intent(in) :: strain         !! sqrt(w_c/R) > 0
    type(plastic_scale), intent(out) :: curve  !! parameters of the contact
    real(real64) :: elastic, plastic, slope

    curve%constraint = constraint
    curve%strain = strain
    curve%area_power = 0.14_real64 * exp(23.0_real64 * &
                       min(2.0_real64 * strain / (pi * constraint), largest_yield_strain))
    call published_terms(curve, departure, elastic, plastic, slope)
    curve%start = elastic + plastic
    curve%start_share = elastic / curve%start
  end subroutine set_scale

  !> Load and contact radius on first loading, over those of Hertz at the same overlap. Up to
  !> x = 1.9 both are 1 and their slopes 0.
  pure subroutine loading_curve(curve, x, ratio, slope, widening, peak)
    type(plastic_scale), intent(in) :: curve  !! parameters of the contact
    real(real64), intent(in) :: x             !! overlap over the critical one
    real(real64), intent(out) :: ratio        !! load over that of Hertz
    real(real64), intent(out) :: slope        !! slope d ratio/dx
    real(real64), intent(out) :: widening     !! contact radius over that of Hertz
    real(real64), intent(out) :: peak         !! greatest over average pressure, estimated
    real(real64) :: elastic, plastic, step, step_slope, t, factor

    ratio = 1.0_real64
    slope = 0.0_real64
    widening = 1.0_real64
    peak = 1.5_real64
    if (.not. x > departure) return
    call published_terms(curve, x, elastic, plastic, slope)
    ! Cubic step from 0 at the departure to 1 where the published fits begin.
    t = min(1.0_real64, max(0.0_real64, (x - departure) / (joined - departure)))
    step = t * t * (3.0_real64 - 2.0_real64 * t)
    step_slope = 6.0_real64 * t * (1.0_real64 - t) / (joined - departure)
    factor = (1.0_real64 - step) / curve%start + step
    ratio = (elastic + plastic) * factor
    slope = slope * factor + &
            (elastic + plastic) * step_slope * (1.0_real64 - 1.0_real64 / curve%start)
    widening = (x / departure)**(0.5_real64 * curve%area_power)
    peak = 1.0_real64 + 0.5_real64 * min(1.0_real64, elastic / (elastic + plastic) / &
                                         curve%start_share)
  end subroutine loading_curve

  !> Unloading from a largest overlap x, and reloading up to it: the load is
  !> P_x ((w - w_res)/(w_x - w_res))**load_power, the area has `area_power` instead. Published fit
  !> for x >= 1; at x = 1 it is Hertz' law. Up to x = 1.2 the published power returns more work than
  !> was done (it is too small by at most 0.002): there the least power is used with which the load
  !> does not exceed that of loading.
  pure subroutine unloading_shape(x, residual, load_power, area_power)
    real(real64), intent(in) :: x            !! largest overlap over the critical one
    real(real64), intent(out) :: residual    !! overlap without load over the largest one, 0 to 1
    real(real64), intent(out) :: load_power  !! power of the load, at most 1.5
    real(real64), intent(out) :: area_power  !! power of the area, at most 1

    residual = 0.0_real64
    load_power = 1.5_real64
    area_power = 1.0_real64
    if (.not. x > 1.0_real64) return
    residual = (1.0_real64 - x**(-0.28_real64)) * (1.0_real64 - x**(-0.69_real64))
    load_power = 1.5_real64 * max(x**(-0.0331_real64), 1.0_real64 - residual)
    area_power = x**(-0.12_real64)
  end subroutine unloading_shape

  !> Work of first loading up to x, in units of load times overlap at x = 1.
  pure real(real64) function loading_work(curve, x)
    type(plastic_scale), intent(in) :: curve  !! parameters of the contact
    real(real64), intent(in) :: x             !! overlap over the critical one, 0 to 1e100
    real(real64) :: low, high, last
    integer :: i, panels

    loading_work = 0.4_real64 * min(x, departure)**2.5_real64
    if (.not. x > departure) return
    loading_work = loading_work + panel_work(curve, log(departure), log(min(x, joined)))
    if (.not. x > joined) return
    last = log(x)
    panels = ceiling(last - log(joined))
    low = log(joined)
    do i = 1, panels
      high = log(joined) + (last - log(joined)) * i / panels
      loading_work = loading_work + panel_work(curve, low, high)
      low = high
    end do
  end function loading_work

  ! The two terms of the published load over that of Hertz, and the slope of their sum. `radius` is
  ! the contact radius over R, `hardness` the limit H/Sy of the average pressure for it.
  pure subroutine published_terms(curve, x, elastic, plastic, slope)
    type(plastic_scale), intent(in) :: curve
    real(real64), intent(in) :: x
    real(real64), intent(out) :: elastic, plastic, slope
    real(real64) :: radius, hardening, hardness, hardness_slope, grown, growth, root

    root = sqrt(x)
    radius = curve%strain * root * (x / departure)**(0.5_real64 * curve%area_power)
    hardening = 0.82_real64 * radius**(-0.7_real64)
    hardness = 2.84_real64 * (1.0_real64 - exp(-hardening))
    hardness_slope = -2.84_real64 * exp(-hardening) * hardening * 0.35_real64 * &
                     (1.0_real64 + curve%area_power) / x
    elastic = exp(-0.25_real64 * x**(5.0_real64 / 12.0_real64))
    growth = x**(5.0_real64 / 9.0_real64) / 25.0_real64
    grown = 1.0_real64 - exp(-growth)
    plastic = 4.0_real64 / curve%constraint * hardness * grown / root
    slope = -elastic * (5.0_real64 / 48.0_real64) * x**(-7.0_real64 / 12.0_real64) + &
            4.0_real64 / curve%constraint / root * &
            (hardness_slope * grown + &
             hardness / x * (exp(-growth) * growth * (5.0_real64 / 9.0_real64) - &
                             0.5_real64 * grown))
  end subroutine published_terms

  ! Work between two logarithms of x, by Gauss' rule.
  pure real(real64) function panel_work(curve, low, high)
    type(plastic_scale), intent(in) :: curve
    real(real64), intent(in) :: low, high
    real(real64) :: ratio, slope, widening, peak, x
    integer :: i

    panel_work = 0.0_real64
    do i = 1, gauss_points
      x = exp(low + (high - low) * gauss_node(i))
      call loading_curve(curve, x, ratio, slope, widening, peak)
      panel_work = panel_work + (high - low) * gauss_weight(i) * ratio * x**2.5_real64
    end do
  end function panel_work

end module asperity_plastic_curves
