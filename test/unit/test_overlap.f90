!> Tests of the overlap of two spheres: real32 and real64 against the definition in real128.
!>
!> The truth has no conjugate, no rest and no common line with the kernel: real128 has 34 digits,
!> so the plain difference s - sqrt(d**2 + z**2) serves down to overlaps of 1e-8 of the radius, and
!> its series in p from there on.
module asperity_test_overlap
  use asperity_kernel_real32, only: overlap_32 => stable_overlap, height_32 => touching_height
  use asperity_kernel_real64, only: overlap_64 => stable_overlap, height_64 => touching_height
  use asperity_kinds, only: int64, real128, real32, real64
  use asperity_testing, only: check, error_type, new_unittest, unittest_type
  implicit none
  private

  public :: collect_overlap

  ! Inputs a kind, and the error allowed, in units of the last place of the result.
  integer, parameter :: inputs = 1000000
  real(real128), parameter :: ulps_allowed = 4.0_real128
  ! The series is used where its first term left out is below 1e-22 of the overlap.
  real(real128), parameter :: series_below = 1.0e-8_real128

  ! A generator of our own (Knuth's MMIX constants), so that every run sees the same inputs.
  integer(int64) :: seed = 1_int64

contains

  !> Lists the tests.
  subroutine collect_overlap(suite)
    !> all tests
    type(unittest_type), allocatable, intent(out) :: suite(:)

    suite = [ &
      new_unittest('a million overlaps in real32 within 4 units of the last place', million_32), &
      new_unittest('a million overlaps in real64 within 4 units of the last place', million_64), &
      new_unittest('the truth is right where a triangle is 3, 4, 5', truth_is_right)]
  end subroutine collect_overlap

  subroutine million_32(error)
    type(error_type), allocatable, intent(out) :: error
    real(real128) :: worst, worst_at(3), off, s, d, p, truth
    real(real32) :: zc, rest, w
    integer :: i, used

    seed = 1_int64
    worst = 0.0_real128
    used = 0
    do i = 1, inputs
      call draw(i, epsilon(1.0_real32) + 0.0_real128, 37.0_real128, s, d, p)
      s = real(s, real32)
      d = real(d, real32)
      if (d >= s) d = nearest(real(s, real32), -1.0_real32)
      call height_32(real(s, real32), real(d, real32), zc, rest)
      p = real(zc * p, real32)
      if (p < tiny(zc) .or. p > zc) cycle
      truth = overlap(s, d, p)
      ! Below the smallest normal number there are no digits to lose.
      if (truth < tiny(zc)) cycle
      w = overlap_32(real(s, real32), real(d, real32), zc, rest, real(p, real32))
      off = abs(w - truth) / spacing(real(truth, real32))
      used = used + 1
      if (off <= worst) cycle
      worst = off
      worst_at = [s, d, p]
    end do
    call check(error, used > inputs / 2, 'too few inputs in range')
    call check(error, worst <= ulps_allowed, 'real32: ' // told(worst, worst_at))
    write (*, '(a, i0, a)') 'overlap in real32: ', used, ' inputs, ' // told(worst, worst_at)
  end subroutine million_32

  subroutine million_64(error)
    type(error_type), allocatable, intent(out) :: error
    real(real128) :: worst, worst_at(3), off, s, d, p, truth
    real(real64) :: zc, rest, w
    integer :: i, used

    seed = 2_int64
    worst = 0.0_real128
    used = 0
    do i = 1, inputs
      call draw(i, epsilon(1.0_real64) + 0.0_real128, 300.0_real128, s, d, p)
      s = real(s, real64)
      d = real(d, real64)
      if (d >= s) d = nearest(real(s, real64), -1.0_real64)
      call height_64(real(s, real64), real(d, real64), zc, rest)
      p = real(zc * p, real64)
      if (p < tiny(zc) .or. p > zc) cycle
      truth = overlap(s, d, p)
      w = overlap_64(real(s, real64), real(d, real64), zc, rest, real(p, real64))
      off = abs(w - truth) / spacing(real(truth, real64))
      used = used + 1
      if (off <= worst) cycle
      worst = off
      worst_at = [s, d, p]
    end do
    call check(error, used > inputs / 2, 'too few inputs in range')
    call check(error, worst <= ulps_allowed, 'real64: ' // told(worst, worst_at))
    write (*, '(a, i0, a)') 'overlap in real64: ', used, ' inputs, ' // told(worst, worst_at)
  end subroutine million_64

  ! Sum of the radii, distance in plan, and penetration over the height zc. The kernel holds
  ! lengths in a unit near the largest radius, so s is in [1/16, 2]; radii 1e6 apart change the
  ! candidate distance, which is in the draws of d.
  subroutine draw(i, step, decades, s, d, share)
    integer, intent(in) :: i
    real(real128), intent(in) :: step     ! spacing of the kind's numbers near 1
    real(real128), intent(in) :: decades  ! magnitudes below 1 to go down to
    real(real128), intent(out) :: s, d, share

    s = 2.0_real128**(5.0_real128 * random() - 4.0_real128)
    select case (modulo(i, 7))
    case (0)  ! anywhere
      d = s * random()
    case (1)  ! near the axis
      d = s * 10.0_real128**(-decades * random())
    case (2)  ! a few units of the last place below s
      d = s - s * step * aint(8.0_real128 * random())
    case (3)  ! grazing, at any magnitude
      d = s - s * 10.0_real128**(-7.0_real128 * random())
    case (4)  ! within the candidate distance of the thesis, d**2 < 2 s * height
      d = s * sqrt(0.14_real128 * random())
    case (5)  ! radii up to 1e6 apart: the heights are those of the smaller sphere
      d = s * sqrt(2.0_real128 * 10.0_real128**(-6.0_real128 * random()) * random())
    case default  ! on the axis
      d = 0.0_real128
    end select
    select case (modulo(i / 7, 4))
    case (0)  ! anywhere
      share = random()
    case (1)  ! small, down to the smallest numbers
      share = 10.0_real128**(-decades * random())
    case (2)  ! nearly level
      share = 1.0_real128 - 10.0_real128**(-16.0_real128 * random())
    case default  ! about half, where terms begin to matter
      share = 0.5_real128 + 0.1_real128 * random()
    end select
  end subroutine draw

  ! The overlap from its definition; by its series where the difference has too few digits left.
  pure function overlap(s, d, p) result(w)
    real(real128), intent(in) :: s, d, p
    real(real128) :: w, zc, a, b

    zc = sqrt((s - d) * (s + d))
    if (p > series_below * zc * (zc / s)) then
      w = s - sqrt(d * d + (zc - p)**2)
    else
      ! sqrt(s**2 - 2 zc p + p**2) = s sqrt(1 - 2 a), a = (zc p - p**2/2)/s**2, to order a**3.
      a = (zc - p / 2) * (p / s) / s
      b = a * (1 + a * (0.5_real128 + a * (0.5_real128 + 0.625_real128 * a)))
      w = s * b
    end if
  end function overlap

  ! A number from 0 to 1.
  function random() result(number)
    real(real128) :: number
    integer(int64), parameter :: low = 2_int64**32 - 1_int64

    ! Two halves of 32 bits by xorshift, which cannot overflow.
    seed = ieor(seed, shiftl(seed, 13))
    seed = ieor(seed, shiftr(seed, 7))
    seed = ieor(seed, shiftl(seed, 17))
    number = (iand(seed, low) + iand(shiftr(seed, 32), low) * 2.0_real128**(-32)) / &
             2.0_real128**32
  end function random

  pure function told(worst, at) result(text)
    real(real128), intent(in) :: worst, at(3)
    character(len=120) :: text

    write (text, '(a, f0.3, 3(a, es24.16))') 'worst error ', worst, ' ulp at s', at(1), &
      ', d', at(2), ', p', at(3)
  end function told

  subroutine truth_is_right(error)
    type(error_type), allocatable, intent(out) :: error
    real(real128) :: off

    ! Sides 3, 4, 5: p = 4 leaves the centres level, W = 2; p = 4 - 4/3 leaves z = 4/3 and
    ! sqrt(9 + 16/9) = sqrt(97)/3.
    off = abs(overlap(5.0_real128, 3.0_real128, 4.0_real128) - 2) + &
          abs(overlap(5.0_real128, 0.0_real128, 1.0e-20_real128) * 1e20_real128 - 1)
    call check(error, off < 1.0e-19_real128, 'the truth is off')
    ! Both ways agree where they meet.
    off = overlap(5.0_real128, 3.0_real128, 4 * 0.8_real128 * 1.0001_real128 * series_below) / &
          overlap(5.0_real128, 3.0_real128, 4 * 0.8_real128 * 0.9999_real128 * series_below) / &
          (1.0001_real128 / 0.9999_real128) - 1
    call check(error, abs(off) < 1.0e-11_real128, 'the series and the difference do not meet')
  end subroutine truth_is_right

end module asperity_test_overlap
