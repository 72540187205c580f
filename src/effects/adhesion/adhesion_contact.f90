!> One adhering contact: its theory, the overlaps at which it snaps in and off, its load.
!>
!> The Tabor parameter mu = (R w**2/(E**2 z0**3))**(1/3) is the height of the neck that adhesion
!> draws out over the range z0 of the attraction (Tabor 1977). Above 5 the theory of Johnson,
!> Kendall and Roberts holds, below 0.1 that of Derjaguin, Muller and Toporov (Johnson and Greenwood
!> 1997); between them that of Maugis with lambda = 1.157 mu, whose limits both are. Without work of
!> adhesion the law is that of Hertz.
!>
!> A contact is separated, without load, or adheres. The range of the attraction is h0 = 0.974 z0
!> (Maugis: the constant stress has the strength and the work of the attraction between molecules).
!> A contact adheres from a gap of h0 on and separates where its curve turns back. Johnson, Kendall
!> and Roberts have no range: spheres adhere from first touch on. In the limit of Derjaguin, Muller
!> and Toporov nothing snaps: the load decreases linearly from 0 at h0 to -2 pi w R at first touch,
!> on separation along the same line.
!>
!> Johnson, Kendall and Roberts (1971), with the contact radius a, the combined modulus E and the
!> combined radius R (Johnson, Contact Mechanics, 1985, section 5.5):
!>
!>     load    = 4 E a**3/(3 R) - sqrt(8 pi w E a**3)
!>     overlap = a**2/R - sqrt(2 pi w a/E)
!>     p(r)    = 2 E sqrt(a**2 - r**2)/(pi R) - sqrt(2 E w/(pi a))/sqrt(1 - r**2/a**2)
!>
!> With a = L t**2, L**3 = 2 pi w R**2/E, the overlap is (L**2/R) (t**4 - t) and the load (E L**3/R)
!> (4/3 t**6 - 2 t**3): one curve for all contacts. The overlap is least at 4 t**3 = 1, with the
!> load -5/6 pi w R; the load is least at 4 t**3 = 3: -3/2 pi w R.
module asperity_adhesion_contact
  use asperity_adhesion_maugis, only: central_answer, follow_maugis, maugis_curve, new_maugis
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  implicit none
  private

  public :: adhesion_numbers, adhering_contact, central_answer
  public :: new_adhering_contact, adheres_at, answer_along_centres
  public :: model_hertz, model_jkr, model_maugis, model_dmt, range_of_attraction

  !> Theories: no work of adhesion; Johnson, Kendall and Roberts; Maugis; Derjaguin, Muller and
  !> Toporov.
  enum, bind(c)
    enumerator :: model_hertz, model_jkr, model_maugis, model_dmt
  end enum

  ! Limits of the Tabor parameter (Johnson and Greenwood 1997). Test: adhesion_suite.
  real(real64), parameter :: least_of_jkr = 5.0_real64, most_of_dmt = 0.1_real64
  !> Range of the constant stress over z0, w/(sigma0 z0) = 9 sqrt(3)/16. Derived (Maugis 1992).
  !> Test: test_adhesion.py.
  real(real64), parameter :: range_of_attraction = 0.97427857925749364_real64

  ! Least overlap of the curve of Johnson, Kendall and Roberts, from 4 t**3 = 1. Derived.
  real(real64), parameter :: last_t = 0.62996052494743658238_real64
  real(real64), parameter :: last_overlap = -0.75_real64 * last_t  ! derived

  !> Parameters of all contacts, in one set of units.
  type :: adhesion_numbers
    real(real64) :: modulus = 1.0_real64   !! combined modulus E > 0
    real(real64) :: work = 0.0_real64      !! of adhesion, w, modulus times length, 0 or more
    real(real64) :: distance = 1.0_real64  !! of equilibrium, z0, more than 0
  end type adhesion_numbers

  !> Parameters of one contact.
  type :: adhering_contact
    integer :: model = model_hertz          !! its theory, one of the `model_` numbers
    real(real64) :: radius = 0.0_real64     !! combined radius R
    real(real64) :: tabor = 0.0_real64      !! Tabor parameter mu
    real(real64) :: pull_off = 0.0_real64   !! largest tensile load, 0 or more
    real(real64) :: snap_in = 0.0_real64    !! overlap from which it adheres; 0 or less
    real(real64) :: snap_off = 0.0_real64   !! overlap below which it separates; <= snap_in
    type(maugis_curve) :: curve             !! curve of Maugis' theory
  end type adhering_contact

contains

  !> Sets the theory of a contact and the ends of its curve.
  pure subroutine new_adhering_contact(numbers, radius, contact)
    type(adhesion_numbers), intent(in) :: numbers   !! parameters of all contacts
    real(real64), intent(in) :: radius              !! combined radius, more than 0
    type(adhering_contact), intent(out) :: contact  !! parameters of the contact

    contact%radius = radius
    if (.not. numbers%work > 0.0_real64) return
    ! Roots of dimensionless ratios: the same digits in any unit.
    contact%tabor = (numbers%work / numbers%modulus / radius)**(2.0_real64 / 3.0_real64) * &
                    (radius / numbers%distance)
    if (contact%tabor > least_of_jkr) then
      contact%model = model_jkr
      contact%snap_off = last_overlap * jkr_unit(numbers, radius)**2 / radius
      contact%pull_off = 1.5_real64 * pi * numbers%work * radius
    else if (contact%tabor < most_of_dmt) then
      contact%model = model_dmt
      contact%snap_in = -range_of_attraction * numbers%distance
      contact%snap_off = contact%snap_in
      contact%pull_off = 2.0_real64 * pi * numbers%work * radius
    else
      contact%model = model_maugis
      ! 2 sigma0 (R/(pi w K**2))**(1/3), K = 4/3 E.
      call new_maugis(contact%tabor * (2.0_real64 / range_of_attraction) * &
                      (9.0_real64 / (16.0_real64 * pi))**(1.0_real64 / 3.0_real64), contact%curve)
      contact%snap_in = -range_of_attraction * numbers%distance
      contact%snap_off = min(contact%curve%snap_off * radius_unit(numbers, radius)**2 / radius, &
                             contact%snap_in)
      contact%pull_off = contact%curve%pull_off * pi * numbers%work * radius
    end if
  end subroutine new_adhering_contact

  !> Whether a contact adheres at an overlap that was reached monotonically.
  elemental logical function adheres_at(contact, overlap, adhered) result(adheres)
    type(adhering_contact), intent(in) :: contact  !! parameters of the contact
    real(real64), intent(in) :: overlap            !! overlap of the spheres; negative: a gap
    logical, intent(in) :: adhered                 !! whether it adhered before

    adheres = contact%model /= model_hertz .and. &
              (overlap >= contact%snap_in .or. (adhered .and. overlap >= contact%snap_off))
  end function adheres_at

  !> Response of an adhering contact along the line of centres.
  pure subroutine answer_along_centres(numbers, contact, overlap, answer)
    type(adhesion_numbers), intent(in) :: numbers  !! parameters of all contacts
    type(adhering_contact), intent(in) :: contact  !! parameters of the contact
    real(real64), intent(in) :: overlap            !! overlap of the spheres, >= snap_off
    type(central_answer), intent(out) :: answer    !! load, radius, stiffness, pressure
    real(real64) :: unit

    associate (modulus => numbers%modulus, radius => contact%radius)
      select case (contact%model)
      case (model_jkr)
        call answer_jkr(numbers, radius, overlap, answer)
      case (model_maugis)
        unit = radius_unit(numbers, radius)
        call follow_maugis(contact%curve, (overlap / unit) * (radius / unit), answer)
        answer%contact_radius = unit * answer%contact_radius
        answer%load = pi * numbers%work * radius * answer%load
        answer%stiffness = (4.0_real64 / 3.0_real64) * modulus * unit * answer%stiffness
        answer%pressure = modulus * (unit / radius) * answer%pressure / pi
      case default
        answer%contact_radius = sqrt(radius * max(overlap, 0.0_real64))
        answer%load = (4.0_real64 / 3.0_real64) * modulus * answer%contact_radius * overlap
        answer%stiffness = 2.0_real64 * modulus * answer%contact_radius
        answer%pressure = (2.0_real64 / pi) * modulus * sqrt(max(overlap, 0.0_real64) / radius)
        if (contact%model == model_hertz) return
        if (overlap < 0.0_real64) then
          answer%load = -contact%pull_off * (1.0_real64 - overlap / contact%snap_in)
          answer%stiffness = contact%pull_off / contact%snap_in
        else
          answer%load = answer%load - contact%pull_off
        end if
      end select
    end associate
  end subroutine answer_along_centres

  ! Response of an adhering contact by Johnson, Kendall and Roberts.
  pure subroutine answer_jkr(numbers, radius, overlap, answer)
    type(adhesion_numbers), intent(in) :: numbers
    real(real64), intent(in) :: radius, overlap
    type(central_answer), intent(out) :: answer
    real(real64) :: length, t, cube

    length = jkr_unit(numbers, radius)
    t = largest_root((overlap / length) * (radius / length))
    cube = t**3
    associate (modulus => numbers%modulus, contact_radius => answer%contact_radius)
      contact_radius = length * t**2
      answer%load = modulus * contact_radius * ((4.0_real64 / 3.0_real64) * &
                    contact_radius**2 / radius - 2.0_real64 * (length / radius) * length * t)
      answer%stiffness = 2.0_real64 * modulus * contact_radius * (4.0_real64 * cube - 3.0_real64) &
                         / max(4.0_real64 * cube - 1.0_real64, epsilon(cube))
      answer%pressure = modulus * (length / radius) * (2.0_real64 * t**2 - 1.0_real64 / t) / pi
    end associate
  end subroutine answer_jkr

  ! Largest root of t**4 - t = y by Newton's method. The left side is convex, so iterates that begin
  ! above the root decrease to it. Both starts are above: the parabola at the least overlap lies
  ! below the curve, and (s + 1)**4 - (s + 1) > s**4. The second is close for large y, the first
  ! near the least overlap.
  pure function largest_root(y) result(t)
    real(real64), intent(in) :: y
    real(real64) :: t, step
    ! Chosen: bounds the loop, which ends by its last test.
    integer, parameter :: most_turns = 100
    integer :: turn

    t = last_t + sqrt(max(y - last_overlap, 0.0_real64) / 6.0_real64) / last_t
    if (y > 0.0_real64) t = min(t, sqrt(sqrt(y)) + 1.0_real64)
    do turn = 1, most_turns
      step = (t * (t**3 - 1.0_real64) - y) / max(4.0_real64 * t**3 - 1.0_real64, epsilon(t))
      ! At the root a step changes sign by rounding.
      if (.not. step > 0.25_real64 * epsilon(t) * t) exit
      t = max(t - step, last_t)
    end do
  end function largest_root

  ! L, the unit of the contact radius of Johnson, Kendall and Roberts.
  pure real(real64) function jkr_unit(numbers, radius)
    type(adhesion_numbers), intent(in) :: numbers
    real(real64), intent(in) :: radius

    jkr_unit = radius * &
               (2.0_real64 * pi * (numbers%work / numbers%modulus / radius))**(1.0_real64 / 3)
  end function jkr_unit

  ! Maugis' unit of the contact radius, (pi w R**2/K)**(1/3).
  pure real(real64) function radius_unit(numbers, radius)
    type(adhesion_numbers), intent(in) :: numbers
    real(real64), intent(in) :: radius

    radius_unit = radius * &
                  (0.75_real64 * pi * (numbers%work / numbers%modulus / radius))**(1.0_real64 / 3)
  end function radius_unit

end module asperity_adhesion_contact
