!> A contact that flows past its onset and is flattened for good.
!>
!> Up to the onset the answer on loading is that of Hertz, bit for bit. Past it the overlap along
!> the line of centres goes with the loading curve; below the largest overlap so far, if that is
!> past first yield, with the unloading curve that ends at the residual overlap. Loading again goes
!> up the same curve, then on with the loading curve. The geometry of an inclined contact is that
!> of the elastic one.
module asperity_plastic_law
  use asperity_constants, only: pi
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pair
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_plastic_curves, only: departure, loading_curve, loading_work, plastic_scale, &
                                     set_scale, unloading_shape
  implicit none
  private

  public :: plastic_law, plastic_past, past_of_contact

  ! The onset of loading and first yield in critical overlaps. The margin is for the rounding of
  ! penetrations: a contact at the limit of its scene has not passed it. The load is off by less
  ! than 1e-14 there.
  real(real64), parameter :: margin = 1.0_real64 + 1.0e-13_real64
  real(real64), parameter :: onset = departure * margin

  !> The law, with what it remembers of every contact.
  type, extends(contact_law) :: plastic_law
    type(hertz_law) :: elastic                  !! up to the onset
    real(real64) :: constraint = 1.6_real64     !! C of the body that yields
    real(real64), allocatable :: critical(:)    !! overlap at first yield; huge: it never yields
    real(real64), allocatable :: largest(:)     !! largest overlap so far, 0 at first
  contains
    procedure :: respond
  end type plastic_law

  !> What a contact has been through, in the units of its pair.
  type :: plastic_past
    logical :: flowed = .false.                 !! its load has left that of Hertz
    real(real64) :: largest = 0.0_real64        !! largest overlap
    real(real64) :: residual = 0.0_real64       !! overlap at which its load is gone
    real(real64) :: work_lost = 0.0_real64      !! not given back on unloading, 0 or more
  end type plastic_past

contains

  !> The answer of a contact. `largest` is not changed. On unloading, the load ends at the residual
  !> overlap, before the undeformed spheres are apart; `overlap` stays that of the spheres.
  pure subroutine respond(self, pair, number, penetration, response)
    class(plastic_law), intent(in) :: self          !! the law
    type(contact_pair), intent(in) :: pair          !! who touches
    integer, intent(in) :: number                   !! place of the pair in its list
    real(real64), intent(in) :: penetration         !! vertical, past first touch; less than zc
    type(contact_response), intent(out) :: response !! the answer
    type(plastic_scale) :: scale
    real(real64) :: critical, largest

    call self%elastic%respond(pair, number, penetration, response)
    if (.not. response%overlap > 0.0_real64) return
    if (number < 1 .or. number > size(self%critical)) return
    critical = self%critical(number)
    largest = max(self%largest(number), response%overlap)
    ! Divided: an onset that is never reached has no room for a product.
    if (.not. largest / merge(margin, onset, response%overlap < largest) > critical) return
    call set_scale(self%constraint, sqrt(critical / pair%radius), scale)
    if (response%overlap < largest) then
      call unload(self%elastic%modulus, pair, scale, critical, largest, penetration, response)
    else
      call load_first(pair, scale, critical, penetration, response)
    end if
  end subroutine respond

  !> What a contact with a largest overlap has been through.
  pure subroutine past_of_contact(self, pair, number, largest, past)
    type(plastic_law), intent(in) :: self   !! the law
    type(contact_pair), intent(in) :: pair  !! the contact
    integer, intent(in) :: number           !! place of the pair in its list
    real(real64), intent(in) :: largest     !! its largest overlap, 0 or more
    type(plastic_past), intent(out) :: past !! what it has been through
    type(plastic_scale) :: scale
    real(real64) :: critical, load_power, area_power, ratio, slope, spread, peak, unit, x

    past%largest = largest
    critical = self%critical(number)
    past%flowed = largest / onset > critical
    if (.not. largest / margin > critical) return
    ! Beyond, a contact has as good as no elastic part, and powers leave the range.
    x = min(largest / critical, 1.0e100_real64)
    call set_scale(self%constraint, sqrt(critical / pair%radius), scale)
    call loading_curve(scale, x, ratio, slope, spread, peak)
    call unloading_shape(x, past%residual, load_power, area_power)
    ! Load times overlap of Hertz at the critical overlap.
    unit = 4.0_real64 / 3.0_real64 * self%elastic%modulus * sqrt(pair%radius * critical) * &
           critical**2
    past%work_lost = unit * max(0.0_real64, loading_work(scale, x) - ratio * x**2.5_real64 * &
                                (1.0_real64 - past%residual) / (load_power + 1.0_real64))
    past%residual = past%residual * largest
  end subroutine past_of_contact

  ! Turns the answer of Hertz into that of the first loading past the onset.
  pure subroutine load_first(pair, scale, critical, penetration, response)
    type(contact_pair), intent(in) :: pair
    type(plastic_scale), intent(in) :: scale
    real(real64), intent(in) :: critical, penetration
    type(contact_response), intent(inout) :: response
    real(real64) :: ratio, slope, spread, peak, along

    call loading_curve(scale, response%overlap / critical, ratio, slope, spread, peak)
    along = response%load * (1.5_real64 * ratio / response%overlap + slope / critical)
    response%load = response%load * ratio
    response%contact_radius = response%contact_radius * spread
    response%maximum_pressure = response%maximum_pressure * &
                                (peak / 1.5_real64) * ratio / spread**2
    call tilt(pair, penetration, along, response)
  end subroutine load_first

  ! Turns the answer of Hertz into that below the largest overlap.
  pure subroutine unload(modulus, pair, scale, critical, largest, penetration, response)
    real(real64), intent(in) :: modulus, critical, largest, penetration
    type(contact_pair), intent(in) :: pair
    type(plastic_scale), intent(in) :: scale
    type(contact_response), intent(inout) :: response
    real(real64) :: ratio, slope, spread, peak, residual, load_power, area_power
    real(real64) :: along, fraction, full, radius

    call loading_curve(scale, largest / critical, ratio, slope, spread, peak)
    call unloading_shape(largest / critical, residual, load_power, area_power)
    radius = sqrt(pair%radius * largest)
    full = 4.0_real64 / 3.0_real64 * modulus * radius * largest * ratio
    radius = radius * spread
    fraction = response%overlap / largest - residual
    ! A contact that was flattened for good all the way has nothing to come back to.
    if (fraction > 0.0_real64) then
      fraction = fraction / (1.0_real64 - residual)
      response%load = full * fraction**load_power
      along = full * load_power * fraction**(load_power - 1.0_real64) / &
              ((1.0_real64 - residual) * largest)
      response%contact_radius = radius * fraction**(0.5_real64 * area_power)
      response%maximum_pressure = peak * (full / (pi * radius**2)) * &
                                  fraction**(load_power - area_power)
    else
      along = 0.0_real64
      response%load = 0.0_real64
      response%contact_radius = 0.0_real64
      response%maximum_pressure = 0.0_real64
    end if
    call tilt(pair, penetration, along, response)
  end subroutine unload

  ! Vertical load and stiffness from the load and its slope along the line of centres. The overlap
  ! grows by the cosine of the penetration, the cosine falls by sine squared over the distance.
  pure subroutine tilt(pair, penetration, along, response)
    type(contact_pair), intent(in) :: pair
    real(real64), intent(in) :: penetration, along
    type(contact_response), intent(inout) :: response
    real(real64) :: centres

    centres = pair%s - response%overlap
    response%cosine = (pair%zc - penetration) / centres
    response%vertical_load = response%load * response%cosine
    response%stiffness = along * response%cosine**2 - &
                         response%load * (pair%d / centres)**2 / centres
  end subroutine tilt

end module asperity_plastic_law
