!> Law of an elastic-plastic contact with permanent flattening.
!>
!> Up to the onset, loading follows Hertz' law, bit for bit. Beyond it the load along the line of
!> centres follows the loading curve; below the largest overlap so far, if that is beyond first
!> yield, the unloading curve, which ends at the residual overlap. Reloading follows the unloading
!> curve up to the largest overlap, then the loading curve. The geometry of an inclined contact is
!> that of the elastic one.
module asperity_plastic_law
  use asperity_constants, only: pi
  use asperity_contact_law, only: contact_law, contact_response, set_vertical_parts
  use asperity_contact_pairs, only: contact_pair
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_plastic_curves, only: departure, loading_curve, loading_work, plastic_scale, &
                                     set_scale, unloading_shape
  implicit none
  private

  public :: plastic_law, plastic_past, past_of_contact

  ! Tolerance of the onset and of first yield, as a factor on the critical overlap: a contact at
  ! the limit of its scene is not plastic by rounding of its penetration. Chosen: 450 units of the
  ! last place; the load is in error by less than 1e-14 there.
  real(real64), parameter :: margin = 1.0_real64 + 1.0e-13_real64
  ! Onset of the plastic loading curve, in critical overlaps. Derived. Test: plasticity_suite.
  real(real64), parameter :: onset = departure * margin

  !> The law, with the history of each contact.
  type, extends(contact_law) :: plastic_law
    type(hertz_law) :: elastic                  !! law up to the onset
    real(real64) :: constraint = 1.6_real64     !! constraint factor C of the body that yields
    real(real64), allocatable :: critical(:)    !! overlap at first yield; huge: it never yields
    real(real64), allocatable :: largest(:)     !! largest overlap so far, 0 at first
  contains
    procedure :: respond => respond_plastic
  end type plastic_law

  !> History of a contact, in the units of its pair.
  type :: plastic_past
    logical :: flowed = .false.                 !! has passed the onset
    real(real64) :: largest = 0.0_real64        !! largest overlap
    real(real64) :: residual = 0.0_real64       !! overlap without load
    real(real64) :: work_lost = 0.0_real64      !! work dissipated in a cycle, 0 or more
  end type plastic_past

contains

  !> Response of a contact. On unloading, the load ends at the residual overlap, before the
  !> undeformed spheres separate; `overlap` is that of the undeformed spheres.
  pure subroutine respond_plastic(self, pair, number, penetration, response)
    class(plastic_law), intent(in) :: self          !! law with the history
    type(contact_pair), intent(in) :: pair          !! geometry of the contact
    integer, intent(in) :: number                   !! place of the pair in its list
    real(real64), intent(in) :: penetration         !! vertical, past first touch; less than zc
    type(contact_response), intent(out) :: response !! loads, radius, pressure, stiffness
    type(plastic_scale) :: curve
    real(real64) :: along, critical, largest, peak, ratio, slope, widening

    call self%elastic%respond(pair, number, penetration, response)
    if (.not. response%overlap > 0.0_real64) return
    if (number < 1 .or. number > size(self%critical)) return
    critical = self%critical(number)
    largest = max(self%largest(number), response%overlap)
    ! The quotient cannot overflow: critical is huge where the contact never yields.
    if (.not. largest / merge(margin, onset, response%overlap < largest) > critical) return
    call set_scale(self%constraint, sqrt(critical / pair%radius), curve)
    if (response%overlap < largest) then
      call unload_contact(self%elastic%modulus, pair, curve, critical, largest, penetration, &
                          response)
    else
      call loading_curve(curve, response%overlap / critical, ratio, slope, widening, peak)
      along = response%load * (1.5_real64 * ratio / response%overlap + slope / critical)
      response%load = response%load * ratio
      response%contact_radius = response%contact_radius * widening
      response%maximum_pressure = response%maximum_pressure * &
                                  (peak / 1.5_real64) * ratio / widening**2
      call set_vertical_parts(pair, penetration, along, response)
    end if
  end subroutine respond_plastic

  !> History of a contact from its largest overlap.
  pure subroutine past_of_contact(self, pair, number, largest, past)
    type(plastic_law), intent(in) :: self   !! law with critical overlaps
    type(contact_pair), intent(in) :: pair  !! geometry of the contact
    integer, intent(in) :: number           !! place of the pair in its list
    real(real64), intent(in) :: largest     !! its largest overlap, 0 or more
    type(plastic_past), intent(out) :: past !! residual overlap and dissipated work
    type(plastic_scale) :: curve
    real(real64) :: critical, load_power, area_power, ratio, slope, widening, peak, unit, x

    past%largest = largest
    critical = self%critical(number)
    past%flowed = largest / onset > critical
    if (.not. largest / margin > critical) return
    ! Bounded, as powers would overflow; there the elastic part is negligible.
    x = min(largest / critical, 1.0e100_real64)
    call set_scale(self%constraint, sqrt(critical / pair%radius), curve)
    call loading_curve(curve, x, ratio, slope, widening, peak)
    call unloading_shape(x, past%residual, load_power, area_power)
    ! Load times overlap of Hertz' law at the critical overlap.
    unit = 4.0_real64 / 3.0_real64 * self%elastic%modulus * sqrt(pair%radius * critical) * &
           critical**2
    past%work_lost = unit * max(0.0_real64, loading_work(curve, x) - ratio * x**2.5_real64 * &
                                (1.0_real64 - past%residual) / (load_power + 1.0_real64))
    past%residual = past%residual * largest
  end subroutine past_of_contact

  ! Turns the response of Hertz' law into that of unloading from the largest overlap.
  pure subroutine unload_contact(modulus, pair, curve, critical, largest, penetration, response)
    real(real64), intent(in) :: modulus, critical, largest, penetration
    type(contact_pair), intent(in) :: pair
    type(plastic_scale), intent(in) :: curve
    type(contact_response), intent(inout) :: response
    real(real64) :: ratio, slope, widening, peak, residual, load_power, area_power
    real(real64) :: along, recovery, full, radius

    call loading_curve(curve, largest / critical, ratio, slope, widening, peak)
    call unloading_shape(largest / critical, residual, load_power, area_power)
    radius = sqrt(pair%radius * largest)
    full = 4.0_real64 / 3.0_real64 * modulus * radius * largest * ratio
    radius = radius * widening
    recovery = response%overlap / largest - residual
    ! Where the residual overlap is the largest one, the contact has no load.
    if (recovery > 0.0_real64) then
      recovery = recovery / (1.0_real64 - residual)
      response%load = full * recovery**load_power
      along = full * load_power * recovery**(load_power - 1.0_real64) / &
              ((1.0_real64 - residual) * largest)
      response%contact_radius = radius * recovery**(0.5_real64 * area_power)
      response%maximum_pressure = peak * (full / (pi * radius**2)) * &
                                  recovery**(load_power - area_power)
    else
      along = 0.0_real64
      response%load = 0.0_real64
      response%contact_radius = 0.0_real64
      response%maximum_pressure = 0.0_real64
    end if
    call set_vertical_parts(pair, penetration, along, response)
  end subroutine unload_contact

end module asperity_plastic_law
