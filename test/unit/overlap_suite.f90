!> Tests of the overlap of two spheres: real64 against the definition in real128.
!>
!> The truth has no conjugate, no rest and no common line with the kernel: real128 has 34 digits,
!> so the plain difference s - sqrt(d**2 + z**2) serves down to overlaps of 1e-6 of s, and its
!> series from there on.
module asperity_overlap_suite
  use asperity_coupled_scenes, only: random
  use asperity_sphere_overlap, only: stable_overlap, touching_height
  use asperity_kinds, only: int64, real128, real64
  use asperity_testing, only: check, run_test
  implicit none
  private

  public :: run_overlap

  ! Inputs a kind, and the error allowed, in units of the last place of the result.
  integer, parameter :: inputs = 1000000
  real(real128), parameter :: ulps_allowed = 4.0_real128
  ! From there down the series' first term left out is below 1e-23 of the overlap.
  real(real128), parameter :: series_below = 1.0e-6_real128

  ! A generator of our own (Marsaglia's xorshift), so that every run sees the same inputs.
  integer(int64) :: seed = 1_int64

contains

  !> Runs the tests.
  subroutine run_overlap
    call run_test('a million overlaps in real64 within 4 units of the last place', million_64)
  end subroutine run_overlap

  subroutine million_64
    real(real64) :: s, d, p, zc, rest, w
    real(real128) :: worst, worst_at(3), off, truth
    real(real64) :: drawn(3)
    integer :: i, used

    seed = 2_int64
    worst = 0.0_real128
    worst_at = 0.0_real128
    used = 0
    do i = 1, inputs
      drawn = draw(i, real(epsilon(s), real64), 300.0_real64)
      s = real(drawn(1), real64)
      d = min(real(drawn(2), real64), nearest(s, -1.0_real64))
      call touching_height(s, d, zc, rest)
      p = min(zc * real(drawn(3), real64), zc)
      truth = overlap(real(s, real128), real(d, real128), real(p, real128))
      ! Below the smallest normal number there are no digits to lose.
      if (p < tiny(p) .or. truth < tiny(w)) cycle
      w = stable_overlap(s, d, zc, rest, p)
      off = abs(w - truth) / spacing(real(truth, real64))
      used = used + 1
      ! Written so that a NaN counts.
      if (off <= worst) cycle
      worst = off
      worst_at = real([s, d, p], real128)
    end do
    call check(used > inputs / 2, 'too few inputs in range')
    call check(worst <= ulps_allowed, shown(worst, worst_at))
  end subroutine million_64

  ! Sum of the radii, distance in plan, and penetration over the height zc. The kernel holds
  ! lengths in a unit near the largest radius, so that s is between 1/16 and 2.
  function draw(i, step, decades) result(drawn)
    integer, intent(in) :: i
    real(real64), intent(in) :: step     ! spacing of the kind's numbers near 1
    real(real64), intent(in) :: decades  ! magnitudes below 1 to go down to
    real(real64) :: drawn(3), s, d, share

    s = 2.0_real64**(5.0_real64 * random(seed) - 4.0_real64)
    select case (modulo(i, 7))
    case (0)  ! anywhere
      d = s * random(seed)
    case (1)  ! near the axis
      d = s * 10.0_real64**(-decades * random(seed))
    case (2)  ! a few units of the last place below s
      d = s - s * step * aint(8.0_real64 * random(seed))
    case (3)  ! grazing, at any magnitude
      d = s - s * 10.0_real64**(-15.0_real64 * random(seed))
    case (4)  ! within the candidate distance of the thesis, d**2 < 2 s * height
      d = s * sqrt(0.14_real64 * random(seed))
    case (5)  ! radii up to 1e6 apart, heights those of the smaller sphere
      d = s * sqrt(2.0_real64 * 10.0_real64**(-6.0_real64 * random(seed)) * random(seed))
    case default  ! on the axis
      d = 0.0_real64
    end select
    select case (modulo(i / 7, 4))
    case (0)  ! anywhere
      share = random(seed)
    case (1)  ! small, down to the smallest numbers
      share = 10.0_real64**(-decades * random(seed))
    case (2)  ! nearly level
      share = 1.0_real64 - 10.0_real64**(-16.0_real64 * random(seed))
    case default  ! where both terms of the numerator matter
      share = 0.5_real64 + 0.5_real64 * random(seed)
    end select
    drawn = [s, d, share]
  end function draw

  ! The overlap from its definition; by its series where the difference has too few digits left.
  pure function overlap(s, d, p) result(w)
    real(real128), intent(in) :: s, d, p
    real(real128) :: w, zc, a

    zc = sqrt((s - d) * (s + d))
    ! W = s - s sqrt(1 - 2 a).
    a = ((zc - p / 2) / s) * (p / s)
    if (a > series_below) then
      w = s - sqrt(d * d + (zc - p)**2)
    else
      w = s * a * (1 + a * (0.5_real128 + a * (0.5_real128 + 0.625_real128 * a)))
    end if
  end function overlap

  pure function shown(worst, at) result(text)
    real(real128), intent(in) :: worst, at(3)
    character(len=120) :: text

    write (text, '(a, f0.3, 3(a, es25.16e3))') 'worst error ', worst, ' ulp at s', at(1), &
      ', d', at(2), ', p', at(3)
  end function shown

end module asperity_overlap_suite
