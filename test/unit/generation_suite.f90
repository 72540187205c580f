!> Tests of random surfaces: draws, numbers as text.
module asperity_generation_suite
  use asperity_kinds, only: int64, real128, real64
  use asperity_random_philox, only: philox_block
  use asperity_surface_text, only: field_length, write_decimal
  use asperity_testing, only: check, has_failed, run_test
  use asperity_truncated_normal, only: draw_normal, prepare_normal, truncated_normal, whole_range
  implicit none
  private

  public :: run_generation

  integer(int64), parameter :: ones = int(z'FFFFFFFF', int64), piece = 2_int64**31

contains

  !> Runs the tests.
  subroutine run_generation
    call run_test('draws from Gaussians, cut or not, are the inverse', gaussians)
    call run_test('the ends of the range are met', range_ends)
    call run_test('numbers of units as text', numbers)
  end subroutine run_generation

  subroutine gaussians
    ! The whole Gaussian, cut ones, far tails.
    real(real128), parameter :: cuts(2, 5) = reshape([-8.2_real128, 8.2_real128, -1.0_real128, &
      1.9_real128, 0.1_real128, 0.1001_real128, 25.0_real128, 26.6_real128, -12.0_real128, &
      -4.0_real128], [2, 5])
    integer :: i

    do i = 1, size(cuts, 2)
      if (.not. has_failed()) call compare_draws(cuts(1, i), cuts(2, i))
    end do
  end subroutine gaussians

  !> Compares draws with the definition. The piece must be the one whose probability holds the
  !> first 52 bits, and the place in it must split the probability of the piece at the other bits,
  !> to 1e-11 of the range.
  subroutine compare_draws(lowest, highest)
    real(real128), intent(in) :: lowest, highest
    real(real128), parameter :: root_two_pi = sqrt(8 * atan(1.0_real128))
    type(truncated_normal) :: distribution
    integer(int64) :: words(4), place
    real(real128) :: step, left, z, wanted, share, total, off, worst
    integer :: i

    call prepare_normal(lowest, highest, distribution)
    step = (highest - lowest) / 1024
    total = mass(lowest, highest)
    worst = 0.0_real128
    do i = 1, 2000
      words = philox_block([int(i, int64), 0_int64, 0_int64, 0_int64], [7_int64, 0_int64])
      place = draw_normal(distribution, words(:3))
      left = lowest + step * real(place / piece, real128)
      z = lowest + (highest - lowest) * real(place, real128) / real(whole_range, real128)
      wanted = real(words(1) * 2_int64**20 + words(2) / 2_int64**12, real128) / 2.0_real128**52
      share = real(words(3) / 2_int64, real128) / 2.0_real128**31
      ! Half a unit of the table's rounding on either side.
      call check(mass(lowest, left) / total <= wanted + 2.0_real128**(-53) .and. &
                 mass(lowest, left + step) / total >= wanted - 2.0_real128**(-53), 'wrong piece')
      if (has_failed()) return
      off = abs(mass(left, z) - share * mass(left, left + step)) * root_two_pi * exp(z * z / 2)
      worst = max(worst, off / (highest - lowest))
    end do
    call check(real(worst, real64), 0.0_real64, 1.0e-11_real64, 'error by the range')
  end subroutine compare_draws

  !> Probability of the Gaussian between two places, by the library.
  pure real(real128) function mass(from, to)
    real(real128), intent(in) :: from, to
    real(real128), parameter :: root = sqrt(2.0_real128)

    mass = (erfc(from / root) - erfc(to / root)) / 2
    if (from + to < 0.0_real128) mass = (erfc(-to / root) - erfc(-from / root)) / 2
  end function mass

  subroutine range_ends
    type(truncated_normal) :: distribution
    integer(int64) :: top

    call prepare_normal(-1.0_real128, 2.0_real128, distribution)
    call check(draw_normal(distribution, [0_int64, 0_int64, 0_int64]), 0_int64, 'lower end')
    top = draw_normal(distribution, [ones, ones, ones])
    call check(top > whole_range - 20_int64 .and. top <= whole_range, 'upper end')
  end subroutine range_ends

  subroutine numbers
    call compare_number(0_int64, 0, '0')
    call compare_number(0_int64, 3, '0.000')
    call compare_number(-123_int64, 4, '-0.0123')
    call compare_number(123456_int64, 3, '123.456')
    call compare_number(100_int64, 2, '1.00')
    call compare_number(-7_int64, 0, '-7')
    call compare_number(5_int64, -3, '5E3')
    call compare_number(-12_int64, 20, '-12E-20')
    call compare_number(999999999999999999_int64, 17, '9.99999999999999999')

  contains

    subroutine compare_number(value, decimals, expected)
      integer(int64), intent(in) :: value
      integer, intent(in) :: decimals
      character(*), intent(in) :: expected
      character(field_length) :: field
      integer :: first

      field = ''
      call write_decimal(value, decimals, field, first)
      call check(field(first:), expected, 'number')
    end subroutine compare_number

  end subroutine numbers

end module asperity_generation_suite
