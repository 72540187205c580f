!> The law of adhering contacts, inclined by the offset of the pair in plan.
!>
!> Load and contact radius are functions of the overlap of the spheres along the line of their
!> centres, as in Hertz' law; a negative overlap is a gap. Over a range of gaps a contact adheres
!> only if it adhered before: the law has a hysteresis and keeps which contacts adhered.
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
module asperity_adhesion_law
  use asperity_adhesion_maugis, only: central_answer, follow_maugis, maugis_curve, new_maugis
  use asperity_constants, only: pi
  use asperity_contact_law, only: contact_law, contact_response, set_vertical_parts
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_sphere_overlap, only: stable_overlap
  implicit none
  private

  public :: adhering_contact, adheres_at, adhesion_law, adhesion_numbers, answer_along_centres, &
            begin_law, central_answer, complete_contact, complete_law, new_adhering_contact, &
            new_adhesion_law, range_of_attraction, respond_along_centres
  public :: model_hertz, model_jkr, model_maugis, model_dmt

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

  ! Factors of the units of the contact radius: L of Johnson, Kendall and Roberts, that of Maugis
  ! with K = 4/3 E. Derived.
  real(real64), parameter :: of_jkr = 2.0_real64, of_maugis = 0.75_real64

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
    logical :: is_complete = .true.         !! pull-off, snap-off and curve are known
  end type adhering_contact

  !> The law with the parameters and the state of each contact.
  type, extends(contact_law) :: adhesion_law
    type(adhesion_numbers) :: numbers                 !! in the units of the pairs
    type(adhering_contact), allocatable :: known(:)   !! by the number of the contact
    logical, allocatable :: adhered(:)                !! by the number: at the last state
  contains
    procedure :: respond => respond_adhering
    procedure :: is_adhering
    procedure :: least_load
  end type adhesion_law

contains

  !> Makes the law of a position without adhering contacts.
  subroutine new_adhesion_law(numbers, pairs, law)
    type(adhesion_numbers), intent(in) :: numbers  !! in the units of the pairs
    type(contact_pairs), intent(in) :: pairs       !! pairs of the position
    type(adhesion_law), intent(out) :: law         !! law of the position

    call begin_law(numbers, pairs, law)
    call complete_law(law)
  end subroutine new_adhesion_law

  !> Makes the law of a position that knows where contacts begin to adhere; it is not complete.
  subroutine begin_law(numbers, pairs, law)
    type(adhesion_numbers), intent(in) :: numbers  !! in the units of the pairs
    type(contact_pairs), intent(in) :: pairs       !! pairs of the position
    type(adhesion_law), intent(out) :: law         !! law of the position
    integer :: i

    law%numbers = numbers
    allocate (law%known(size(pairs%list)), law%adhered(size(pairs%list)))
    law%adhered = .false.
    do i = 1, size(pairs%list)
      call begin_contact(numbers, pairs%list(i)%radius, law%known(i))
    end do
  end subroutine begin_law

  !> Completes the parameters of all contacts, which takes long with Maugis' theory.
  subroutine complete_law(law)
    type(adhesion_law), intent(inout) :: law  !! law of a position
    integer :: i
    logical :: same

    do i = 1, size(law%known)
      ! Many scenes have one radius: its curve is computed once.
      same = .false.
      if (i > 1) same = .not. abs(law%known(i)%radius - law%known(i - 1)%radius) > 0.0_real64
      if (same) then
        law%known(i) = law%known(i - 1)
      else
        call complete_contact(law%numbers, law%known(i))
      end if
    end do
  end subroutine complete_law

  !> Response of a contact. Continuous in the penetration except where the contact snaps. The
  !> pressure is that at the centre of the contact circle, the largest.
  pure subroutine respond_adhering(self, pair, number, penetration, response)
    class(adhesion_law), intent(in) :: self         !! complete law with its history
    type(contact_pair), intent(in) :: pair          !! geometry of the contact
    integer, intent(in) :: number                   !! place of the pair in its list
    real(real64), intent(in) :: penetration         !! vertical, less than zc; negative: a gap
    type(contact_response), intent(out) :: response !! loads, radius, pressure, stiffness

    call respond_along_centres(self%numbers, self%known(number), self%adhered(number), pair, &
                               penetration, response)
  end subroutine respond_adhering

  !> Response of a contact by its own parameters.
  pure subroutine respond_along_centres(numbers, contact, adhered, pair, penetration, response)
    type(adhesion_numbers), intent(in) :: numbers   !! parameters of all contacts
    type(adhering_contact), intent(in) :: contact   !! complete parameters of the contact
    logical, intent(in) :: adhered                  !! whether it adhered before
    type(contact_pair), intent(in) :: pair          !! geometry of the contact
    real(real64), intent(in) :: penetration         !! vertical, less than zc; negative: a gap
    type(contact_response), intent(out) :: response !! loads, radius, pressure, stiffness
    type(hertz_law) :: hertz
    type(central_answer) :: answer
    real(real64) :: overlap

    if (contact%model == model_hertz) then
      hertz%modulus = numbers%modulus
      call hertz%respond(pair, 1, penetration, response)
      return
    end if
    overlap = stable_overlap(pair%s, pair%d, pair%zc, pair%rest, penetration)
    if (.not. adheres_at(contact, overlap, adhered)) return
    call answer_along_centres(numbers, contact, overlap, answer)
    response%overlap = overlap
    response%contact_radius = answer%contact_radius
    response%load = answer%load
    call set_vertical_parts(pair, penetration, answer%stiffness, response)
    response%maximum_pressure = answer%pressure
  end subroutine respond_along_centres

  !> Whether a contact adheres at a penetration.
  pure logical function is_adhering(self, pair, number, penetration)
    class(adhesion_law), intent(in) :: self  !! law with its history
    type(contact_pair), intent(in) :: pair   !! geometry of the contact
    integer, intent(in) :: number            !! place of the pair in its list
    real(real64), intent(in) :: penetration  !! vertical, less than zc; negative: a gap

    is_adhering = adheres_at(self%known(number), stable_overlap(pair%s, pair%d, pair%zc, &
                             pair%rest, penetration), self%adhered(number))
  end function is_adhering

  !> Lower bound of the load of a contact that unloads between two penetrations. The load along the
  !> line of centres is a convex function of the overlap: its least value is at the lower end where
  !> the stiffness is positive there, at the upper end where it is negative there, else the pull-off
  !> force.
  pure real(real64) function least_load(self, pair, number, low, high, vertical) result(load)
    class(adhesion_law), intent(in) :: self  !! law with its history
    type(contact_pair), intent(in) :: pair   !! geometry of the contact
    integer, intent(in) :: number            !! place of the pair in its list
    real(real64), intent(in) :: low, high    !! penetrations, low <= high < zc
    logical, intent(in) :: vertical          !! whether the vertical part of the load is meant
    type(central_answer) :: lower, upper
    real(real64) :: cosines(2), overlaps(2), part

    load = 0.0_real64
    associate (contact => self%known(number))
      overlaps = [stable_overlap(pair%s, pair%d, pair%zc, pair%rest, low), &
                  stable_overlap(pair%s, pair%d, pair%zc, pair%rest, high)]
      cosines = (pair%zc - [low, high]) / (pair%s - overlaps)
      part = merge(contact%snap_off, contact%snap_in, self%adhered(number))
      if (overlaps(2) < part) return
      call answer_along_centres(self%numbers, contact, max(overlaps(1), part), lower)
      load = lower%load
      if (lower%stiffness < 0.0_real64) then
        call answer_along_centres(self%numbers, contact, overlaps(2), upper)
        load = merge(-contact%pull_off, upper%load, upper%stiffness > 0.0_real64)
      end if
      if (overlaps(1) < part) load = min(load, 0.0_real64)
    end associate
    if (vertical) load = min(load * cosines(1), load * cosines(2))
  end function least_load

  !> Sets the theory of a contact and the ends of its curve.
  pure subroutine new_adhering_contact(numbers, radius, contact)
    type(adhesion_numbers), intent(in) :: numbers   !! parameters of all contacts
    real(real64), intent(in) :: radius              !! combined radius, more than 0
    type(adhering_contact), intent(out) :: contact  !! parameters of the contact

    call begin_contact(numbers, radius, contact)
    call complete_contact(numbers, contact)
  end subroutine new_adhering_contact

  ! Sets the theory of a contact, and where it begins to adhere: of most of many contacts nothing
  ! else is used.
  pure subroutine begin_contact(numbers, radius, contact)
    type(adhesion_numbers), intent(in) :: numbers
    real(real64), intent(in) :: radius
    type(adhering_contact), intent(out) :: contact
    real(real64) :: ratio, root  ! the Tabor parameter to the power 3/2 is ratio/root

    contact%radius = radius
    if (.not. numbers%work > 0.0_real64) return
    contact%is_complete = .false.
    ratio = numbers%work / numbers%modulus / numbers%distance
    root = sqrt(numbers%distance / radius)
    if (ratio > root * least_of_jkr**1.5_real64) then
      contact%model = model_jkr
      return
    end if
    contact%model = merge(model_dmt, model_maugis, ratio < root * most_of_dmt**1.5_real64)
    contact%snap_in = -range_of_attraction * numbers%distance
  end subroutine begin_contact

  !> Completes the parameters of a contact: its Tabor parameter and the ends of its curve.
  pure subroutine complete_contact(numbers, contact)
    type(adhesion_numbers), intent(in) :: numbers     !! parameters of all contacts
    type(adhering_contact), intent(inout) :: contact  !! parameters of the contact

    if (contact%is_complete) return
    contact%is_complete = .true.
    associate (radius => contact%radius)
      ! Roots of dimensionless ratios: the same digits in any unit.
      contact%tabor = (numbers%work / numbers%modulus / radius)**(2.0_real64 / 3.0_real64) * &
                      (radius / numbers%distance)
      select case (contact%model)
      case (model_jkr)
        contact%snap_off = last_overlap * radius_unit(numbers, radius, of_jkr)**2 / radius
        contact%pull_off = 1.5_real64 * pi * numbers%work * radius
      case (model_dmt)
        contact%snap_off = contact%snap_in
        contact%pull_off = 2.0_real64 * pi * numbers%work * radius
      case default
        ! 2 sigma0 (R/(pi w K**2))**(1/3), K = 4/3 E.
        call new_maugis(contact%tabor * (2.0_real64 / range_of_attraction) * &
                        (9.0_real64 / (16.0_real64 * pi))**(1.0_real64 / 3.0_real64), contact%curve)
        contact%snap_off = min(contact%curve%snap_off * radius_unit(numbers, radius, of_maugis)**2 &
                               / radius, contact%snap_in)
        contact%pull_off = contact%curve%pull_off * pi * numbers%work * radius
      end select
    end associate
  end subroutine complete_contact

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
        unit = radius_unit(numbers, radius, of_maugis)
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

    length = radius_unit(numbers, radius, of_jkr)
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

  ! Unit of the contact radius, R (factor pi w/(E R))**(1/3).
  pure real(real64) function radius_unit(numbers, radius, factor)
    type(adhesion_numbers), intent(in) :: numbers
    real(real64), intent(in) :: radius, factor

    radius_unit = radius * &
                  (factor * pi * (numbers%work / numbers%modulus / radius))**(1.0_real64 / 3)
  end function radius_unit

end module asperity_adhesion_law
