!> The adhering contact of soft spheres: Johnson, Kendall and Roberts (1971).
!>
!> With the contact radius a, the combined modulus E, the combined radius R and the work of adhesion
!> w (Johnson, Contact Mechanics, 1985, section 5.5)
!>
!>     load    = 4 E a**3/(3 R) - sqrt(8 pi w E a**3)
!>     overlap = a**2/R - sqrt(2 pi w a/E)
!>     p(r)    = 2 E sqrt(a**2 - r**2)/(pi R) - sqrt(2 E w/(pi a))/sqrt(1 - r**2/a**2)
!>
!> With a = L t**2, L**3 = 2 pi w R**2/E, the overlap is (L**2/R) (t**4 - t) and the load (E L**3/R)
!> (4/3 t**6 - 2 t**3): one curve for all contacts. The overlap is least at 4 t**3 = 1, with the
!> load -5/6 pi w R; the load is least at 4 t**3 = 3: -3/2 pi w R.
module asperity_adhesion_jkr
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  implicit none
  private

  public :: answer_jkr, snap_off_jkr

  ! Least overlap of the curve, derived: t from 4 t**3 = 1.
  real(real64), parameter :: last_t = 0.62996052494743658238_real64
  ! Least overlap of the curve, derived: t**4 - t there.
  real(real64), parameter :: last_overlap = -0.75_real64 * last_t

contains

  !> Response of an adhering contact along the line of centres.
  pure subroutine answer_jkr(modulus, radius, work, overlap, load, contact_radius, stiffness, &
                             pressure)
    real(real64), intent(in) :: modulus          !! combined modulus, more than 0
    real(real64), intent(in) :: radius           !! combined radius, more than 0
    real(real64), intent(in) :: work             !! work of adhesion, more than 0
    real(real64), intent(in) :: overlap          !! overlap, not below `snap_off_jkr`
    real(real64), intent(out) :: load            !! normal force, < 0 in tension
    real(real64), intent(out) :: contact_radius  !! contact radius, more than 0
    real(real64), intent(out) :: stiffness       !! d load/d overlap; huge at the snap
    real(real64), intent(out) :: pressure        !! at the centre, the largest; < 0 in tension
    real(real64) :: length, t, cube

    length = length_of(modulus, radius, work)
    t = largest_root((overlap / length) * (radius / length))
    cube = t**3
    contact_radius = length * t**2
    load = modulus * contact_radius * ((4.0_real64 / 3.0_real64) * contact_radius**2 / radius - &
                                       2.0_real64 * (length / radius) * length * t)
    stiffness = 2.0_real64 * modulus * contact_radius * (4.0_real64 * cube - 3.0_real64) / &
                max(4.0_real64 * cube - 1.0_real64, epsilon(cube))
    pressure = modulus * (length / radius) * (2.0_real64 * t**2 - 1.0_real64 / t) / pi
  end subroutine answer_jkr

  !> Overlap at which a contact separates at a prescribed overlap: the least of the curve.
  pure real(real64) function snap_off_jkr(modulus, radius, work)
    real(real64), intent(in) :: modulus  !! combined modulus, more than 0
    real(real64), intent(in) :: radius   !! combined radius, more than 0
    real(real64), intent(in) :: work     !! work of adhesion, 0 or more

    snap_off_jkr = last_overlap * length_of(modulus, radius, work)**2 / radius
  end function snap_off_jkr

  ! L, the unit of the contact radius.
  pure real(real64) function length_of(modulus, radius, work) result(length)
    real(real64), intent(in) :: modulus, radius, work

    ! The root of a ratio without unit: the same digits in any unit.
    length = radius * (2.0_real64 * pi * (work / modulus / radius))**(1.0_real64 / 3.0_real64)
  end function length_of

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

end module asperity_adhesion_jkr
