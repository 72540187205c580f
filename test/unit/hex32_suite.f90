!> Tests of the short hexadecimal arithmetic: cases worked out by hand, and conversions.
!>
!> Numbers are written as machine words in hexadecimal: `C276A000` is -118.625. Random operands are
!> compared with a System/370 and with exact whole numbers in test/hard/test_hex32_machine.py. Sine
!> and cosine are compared with 128-bit reals.
module asperity_hex32_suite
  use asperity_hex32, only: hex32, hex32_huge, hex32_tiny, hex32_from_binary, hex32_from_decimal
  use asperity_hex32, only: hex32_from_integer, hex32_from_real64, hex32_from_word
  use asperity_hex32, only: hex32_to_integer, hex32_to_real64, hex32_word
  use asperity_hex32, only: cos, sin, sqrt, three_halves_power
  use asperity_hex32, only: operator(+), operator(-), operator(*), operator(/)
  use asperity_hex32, only: operator(<), operator(<=), operator(>), operator(>=)
  use asperity_hex32, only: operator(==), operator(/=)
  use asperity_kinds, only: int32, int64, real128, real64
  use asperity_testing, only: check, error_type, new_unittest, unittest_type
  implicit none
  private

  public :: collect_hex32

  !> Exact integers for products of fractions.
  integer, parameter :: wide = selected_int_kind(38)
  integer(wide), parameter :: fraction_end = 16_wide**6
  !> Pairs tried for each operation.
  integer, parameter :: trials = 100000

  !> A word taken apart; the value is fraction * 16**(characteristic - 70).
  type :: parts_type
    logical :: below_zero
    integer :: characteristic
    integer(wide) :: fraction
  end type parts_type

  !> Pseudo-random numbers, the same in every run.
  type :: random_type
    integer(wide) :: state = 20261121_wide
  end type random_type

contains

  !> Lists the tests.
  subroutine collect_hex32(suite)
    !> all tests of this module
    type(unittest_type), allocatable, intent(out) :: suite(:)

    suite = [ &
            new_unittest('zero, largest and smallest', test_constants), &
            new_unittest('add and subtract, worked by hand', test_add_by_hand), &
            new_unittest('multiply, worked by hand', test_multiply_by_hand), &
            new_unittest('divide, worked by hand', test_divide_by_hand), &
            new_unittest('compare, worked by hand', test_compare_by_hand), &
            new_unittest('root, known values', test_root_known), &
            new_unittest('x**1.5, known values', test_power_known), &
            new_unittest('from and to machine words', test_words), &
            new_unittest('from integers', test_from_integer), &
            new_unittest('to integers', test_to_integer), &
            new_unittest('from decimals, known values', test_decimal_known), &
            new_unittest('from digits and a power of two', test_binary), &
            new_unittest('from and to double precision', test_real64), &
            new_unittest('sine and cosine, known values', test_circular_known), &
            new_unittest('sine and cosine, random angles', test_circular_random), &
            new_unittest('whole arrays', test_arrays)]
  end subroutine collect_hex32

  subroutine test_constants(error)
    type(error_type), allocatable, intent(out) :: error
    type(hex32) :: untouched

    call check_word(error, untouched, '00000000', 'start value')
    call check_word(error, hex32_huge(), '7FFFFFFF', 'largest')
    call check_word(error, hex32_tiny(), '00100000', 'smallest')
    call check_word(error, -untouched, '00000000', 'zero has no sign')
    call check_word(error, -x('41100000'), 'C1100000', 'negative of one')
    call check_word(error, +x('C1100000'), 'C1100000', 'unary plus')
  end subroutine test_constants

  subroutine test_add_by_hand(error)
    type(error_type), allocatable, intent(out) :: error

    call sum_is('41100000', '41100000', '41200000', '1 + 1')
    call sum_is('40199999', '40199999', '40333332', '0.1 + 0.1')
    call sum_is('C276A000', '4128A3D7', 'C27415C2', '-118.625 + 2.54')
    call sum_is('00000000', 'C1100000', 'C1100000', '0 - 1')
    call sum_is('00000000', '00000000', '00000000', '0 + 0')
    call sum_is('41123456', 'C1123456', '00000000', 'cancellation to zero')
    call sum_is('41123456', 'C1123455', '3C100000', 'all but the last digit cancels')
    call sum_is('40FFFFFF', '3B100000', '41100000', 'carry to the next power of 16')
    call sum_is('40FFFFFF', '40FFFFFF', '411FFFFF', 'carry drops the last digit')
    call sum_is('41FFFFFF', '40FFFFFF', '4210FFFF', 'carry drops last digit and guard')
    ! 1.00000|0 - 0.FFFFF|F leaves the guard place alone; without it 3C100000.
    call sum_is('41100000', 'C0FFFFFF', '3B100000', 'guard digit kept')
    ! 1.00000|0 - 0.0FFFF|F loses one digit; exact and cut it would be 40F00000.
    call sum_is('41100000', 'BFFFFFFF', '40F00001', 'a digit beyond the guard is lost')
    call sum_is('41800000', '40FFFFFF', '418FFFFF', 'the guard digit does not round')
    call sum_is('41100000', 'BB100000', '40FFFFFF', 'six places apart, the guard counts')
    call sum_is('41200000', 'BBF00000', '411FFFFF', 'six places apart, the guard borrows')
    call sum_is('41100000', 'BAFFFFFF', '41100000', 'seven places apart, nothing is left')
    call sum_is('7F100000', '80100000', '7F100000', 'as far apart as can be')
    call sum_is('7FFFFFFF', '7F100000', '7FFFFFFF', 'overflow')
    call sum_is('FFFFFFFF', 'FFFFFFFF', 'FFFFFFFF', 'overflow below zero')
    call sum_is('7FFFFFFF', '79100000', '7FFFFFFF', 'nothing beyond the largest')
    call sum_is('00110000', '80100000', '00000000', 'underflow')
    call sum_is('80200000', '00100000', '80100000', 'the smallest is no underflow')

  contains

    ! Both orders, both signs, and as a difference.
    subroutine sum_is(a, b, total, message)
      character(*), intent(in) :: a, b, total, message

      call check_word(error, x(a) + x(b), total, message)
      call check_word(error, x(b) + x(a), total, message//', exchanged')
      call check_word(error, x(a) - (-x(b)), total, message//', as a difference')
      call check_word(error, -((-x(a)) - x(b)), total, message//', negated')
    end subroutine sum_is

  end subroutine test_add_by_hand

  subroutine test_multiply_by_hand(error)
    type(error_type), allocatable, intent(out) :: error

    call product_is('41100000', '41FFFFFF', '41FFFFFF', '1 * x')
    call product_is('40199999', '40199999', '3F28F5C0', '0.1 * 0.1, normalised by a digit')
    call product_is('41FFFFFF', '41FFFFFF', '42FFFFFE', 'all ones, cut')
    call product_is('C276A000', '4128A3D7', 'C312D4EB', '-118.625 * 2.54')
    call product_is('C1200000', 'C1300000', '41600000', '-2 * -3')
    call product_is('00000000', 'C1300000', '00000000', '0 * -3')
    call product_is('60100000', '60100000', '7F100000', 'largest exponent')
    call product_is('60400000', '61400000', '7FFFFFFF', 'overflow')
    call product_is('E0400000', '61400000', 'FFFFFFFF', 'overflow below zero')
    call product_is('7F800000', '41200000', '7FFFFFFF', 'overflow by one digit')
    call product_is('00100000', '41100000', '00100000', 'the smallest * 1')
    call product_is('00100000', '40FFFFFF', '00000000', 'underflow by one digit')
    call product_is('80100000', '00100000', '00000000', 'underflow')

  contains

    subroutine product_is(a, b, product, message)
      character(*), intent(in) :: a, b, product, message

      call check_word(error, x(a)*x(b), product, message)
      call check_word(error, x(b)*x(a), product, message//', exchanged')
    end subroutine product_is

  end subroutine test_multiply_by_hand

  subroutine test_divide_by_hand(error)
    type(error_type), allocatable, intent(out) :: error

    call quotient_is('41100000', '41300000', '40555555', '1/3')
    call quotient_is('41200000', '41300000', '40AAAAAA', '2/3, cut')
    call quotient_is('C1A00000', '41300000', 'C1355555', '-10/3')
    call quotient_is('40199999', '40199999', '41100000', 'x/x')
    call quotient_is('C276A000', '4128A3D7', 'C22EB3E7', '-118.625/2.54')
    call quotient_is('41100000', '41FFFFFF', '40100000', '1/15.99')
    call quotient_is('41FFFFFF', '41100000', '41FFFFFF', 'x/1')
    call quotient_is('00000000', 'C1100000', '00000000', '0/x')
    call quotient_is('41100000', '00000000', '7FFFFFFF', '1/0')
    call quotient_is('C1100000', '00000000', 'FFFFFFFF', '-1/0')
    call quotient_is('00000000', '00000000', '00000000', '0/0')
    call quotient_is('7FFFFFFF', '00100000', '7FFFFFFF', 'overflow')
    call quotient_is('7F800000', 'C0800000', 'FFFFFFFF', 'overflow by one digit')
    call quotient_is('00100000', '7FFFFFFF', '00000000', 'underflow')
    call quotient_is('00100000', '41100001', '00000000', 'underflow by one digit')
    call quotient_is('00100000', '40100000', '01100000', 'the smallest / 16**(-1)')

  contains

    subroutine quotient_is(a, b, quotient, message)
      character(*), intent(in) :: a, b, quotient, message

      call check_word(error, x(a)/x(b), quotient, message)
    end subroutine quotient_is

  end subroutine test_divide_by_hand

  subroutine test_compare_by_hand(error)
    type(error_type), allocatable, intent(out) :: error
    ! In ascending order.
    character(8), parameter :: ladder(*) = [ &
                               'FFFFFFFF', 'C2100000', 'C1FFFFFF', 'C1100000', 'C0FFFFFF', &
                               '80100000', '00000000', '00100000', '00100001', '01100000', &
                               '40FFFFFF', '41100000', '41100001', '42100000', '7FFFFFFF']
    integer :: i, k

    do i = 1, size(ladder)
      do k = 1, size(ladder)
        call check_order(error, x(ladder(i)), x(ladder(k)), i - k, ladder(i)//' '//ladder(k))
      end do
    end do
  end subroutine test_compare_by_hand

  subroutine test_root_known(error)
    type(error_type), allocatable, intent(out) :: error

    call root_is('00000000', '00000000', '0')
    call root_is('41100000', '41100000', '1')
    call root_is('41200000', '4116A09E', '2')
    call root_is('41900000', '41300000', '9')
    call root_is('42640000', '41A00000', '100')
    call root_is('40100000', '40400000', '1/16')
    call root_is('4128A3D7', '41197FF3', '2.54')
    call root_is('00100000', '20400000', 'the smallest')
    call root_is('7FFFFFFF', '60400000', 'the largest')
    call root_is('C1900000', '41300000', '-9, the root of the magnitude')
    ! Here the method does not give the nearest number, which is one unit lower.
    call root_is('421A0000', '41519596', '26; the nearest is 41519595')
    call root_is('42630000', '419F32B0', '99; the nearest is 419F32AF')
    call root_is('4316B000', '42130D75', '363; the nearest is 42130D74')
    call root_is('4167450E', '4128A611', '6.454359; the nearest is 4128A610')

  contains

    subroutine root_is(a, root, message)
      character(*), intent(in) :: a, root, message

      call check_word(error, sqrt(x(a)), root, 'root of '//message)
    end subroutine root_is

  end subroutine test_root_known

  subroutine test_power_known(error)
    type(error_type), allocatable, intent(out) :: error

    call power_is('00000000', '00000000', '0')
    call power_is('41100000', '41100000', '1')
    call power_is('41400000', '41800000', '4')
    call power_is('41900000', '421B0000', '9')
    call power_is('40400000', '40200000', '1/4')
    ! 2.8284271247 = 2.D413CCCF.. in hexadecimal digits, cut 2D413C, nearest 2D413D.
    call power_is('41200000', '412D413D', '2, rounded up')
    ! 129**2/2**14: the exact power is 1073344.5 units of the last place.
    call power_is('41104040', '411060C1', 'a tie, upwards')
    call power_is('C1400000', '41800000', '-4, the power of the magnitude')
    call power_is('7F100000', '7FFFFFFF', 'overflow')
    call power_is('00100000', '00000000', 'underflow')
    ! (1 - e)**1.5 = 1 - 1.5*e + 0.375*e**2 lies just above the tie.
    call power_is('16FFFFFF', '01FFFFFF', '16**(-42)*(1 - e), e = 2**(-24)')

  contains

    subroutine power_is(a, power, message)
      character(*), intent(in) :: a, power, message

      call check_word(error, three_halves_power(x(a)), power, 'x**1.5 of '//message)
    end subroutine power_is

  end subroutine test_power_known

  subroutine test_words(error)
    type(error_type), allocatable, intent(out) :: error
    type(random_type) :: random
    integer(int64) :: a, b
    integer :: i

    call check_word(error, x('40199999'), '40199999', '0.1')
    call check_word(error, x('41010000'), '40100000', 'unnormalised')
    call check_word(error, x('C2000001'), 'BD100000', 'unnormalised by five digits')
    call check_word(error, x('00000001'), '00000000', 'unnormalised and too small')
    call check_word(error, x('41000000'), '00000000', 'a zero with an exponent')
    call check_word(error, x('80000000'), '00000000', 'a zero with a sign')
    do i = 1, trials
      call random_pair(random, i, a, b)
      call check_word(error, from(a), text(a), 'there and back')
    end do
  end subroutine test_words

  subroutine test_from_integer(error)
    type(error_type), allocatable, intent(out) :: error
    type(random_type) :: random
    integer(wide) :: magnitude
    integer :: i, k, digits

    call check_word(error, hex32_from_integer(0), '00000000', '0')
    call check_word(error, hex32_from_integer(1), '41100000', '1')
    call check_word(error, hex32_from_integer(-1), 'C1100000', '-1')
    call check_word(error, hex32_from_integer(16777215), '46FFFFFF', '2**24 - 1')
    call check_word(error, hex32_from_integer(16777217), '47100000', '2**24 + 1, cut')
    call check_word(error, hex32_from_integer(-16777231), 'C7100000', '-2**24 - 15, cut')
    call check_word(error, hex32_from_integer(2147483647), '487FFFFF', 'largest integer')
    call check_word(error, hex32_from_integer(-2147483647 - 1), 'C8800000', 'smallest integer')
    do i = 1, trials
      k = int(shiftr(next(random), modulo(i, 32)) - 2_wide**31/2_wide**modulo(i, 32))
      magnitude = abs(int(k, wide))
      digits = 6
      do while (magnitude >= fraction_end)
        magnitude = magnitude/16
        digits = digits + 1
      end do
      call check_word(error, hex32_from_integer(k), text(word_of(k < 0, 64 + digits, magnitude)), &
                      'an integer')
    end do
  end subroutine test_from_integer

  subroutine test_to_integer(error)
    type(error_type), allocatable, intent(out) :: error
    type(random_type) :: random
    integer :: i, k

    call check(error, hex32_to_integer(x('00000000')), 0, '0')
    call check(error, hex32_to_integer(x('40FFFFFF')), 0, '0.99')
    call check(error, hex32_to_integer(x('C11FFFFF')), -1, '-1.99')
    call check(error, hex32_to_integer(x('C276A000')), -118, '-118.625')
    call check(error, hex32_to_integer(x('4612345F')), 1193055, 'six digits')
    call check(error, hex32_to_integer(x('47123456')), 19088736, 'seven digits')
    call check(error, hex32_to_integer(x('487FFFFF')), 2147483392, 'near the largest integer')
    call check(error, hex32_to_integer(x('48800000')), 2147483647, 'above the largest integer')
    call check(error, hex32_to_integer(x('C8800000')), -2147483647, 'below it, negative')
    call check(error, hex32_to_integer(x('FFFFFFFF')), -2147483647, 'far below')
    call check(error, hex32_to_integer(x('00100000')), 0, 'the smallest')
    do i = 1, trials
      k = int(modulo(next(random), 2_wide**25) - 2_wide**24)
      call check(error, hex32_to_integer(hex32_from_integer(k)), k, 'there and back')
    end do
  end subroutine test_to_integer

  subroutine test_decimal_known(error)
    type(error_type), allocatable, intent(out) :: error

    call decimal_is(1_int64, -1, '40199999', '0.1')
    call decimal_is(1_int64, 0, '41100000', '1')
    call decimal_is(254_int64, -2, '4128A3D7', '2.54')
    call decimal_is(-118625_int64, -3, 'C276A000', '-118.625')
    call decimal_is(1_int64, -3, '3E418937', '0.001')
    call decimal_is(31416_int64, -4, '413243FE', '3.1416')
    call decimal_is(6894_int64, -4, '40B07C84', '0.6894')
    call decimal_is(3_int64, -1, '404CCCCC', '0.3')
    call decimal_is(1681595_int64, -6, '411AE7D0', 'first constant of the root')
    call decimal_is(1288973_int64, -6, '41149FA2', 'second constant of the root')
    call decimal_is(8408065_int64, -7, '40D73F18', 'third constant of the root')
    call decimal_is(1000_int64, -3, '41100000', '1 with trailing zeros')
    call decimal_is(0_int64, 99, '00000000', '0')
    call decimal_is(1_int64, -20, '302F3942', '1e-20')
    call decimal_is(1_int64, 75, '7F235FAD', '1e75')
    call decimal_is(72_int64, 74, '7FFEB0E3', '7.2e75')
    call decimal_is(-73_int64, 74, 'FFFFFFFF', '-7.3e75, overflow')
    call decimal_is(1_int64, 2000000000, '7FFFFFFF', 'overflow, any exponent')
    call decimal_is(54_int64, -80, '001001D1', '5.4e-79')
    call decimal_is(539_int64, -81, '00000000', '5.39e-79, underflow')
    call decimal_is(-1_int64, -2000000000, '00000000', 'underflow, any exponent')
    call decimal_is(huge(1_int64), 0, '507FFFFF', 'largest digits')
    call decimal_is(-huge(1_int64) - 1_int64, 0, 'D0800000', 'smallest digits')
    call decimal_is(-huge(1_int64) - 1_int64, -120, '00000000', 'smallest digits, underflow')

  contains

    subroutine decimal_is(digits, exponent10, word, message)
      integer(int64), intent(in) :: digits
      integer, intent(in) :: exponent10
      character(*), intent(in) :: word, message

      call check_word(error, hex32_from_decimal(digits, exponent10), word, message)
    end subroutine decimal_is

  end subroutine test_decimal_known

  subroutine test_binary(error)
    type(error_type), allocatable, intent(out) :: error

    call check_word(error, hex32_from_binary(0_int64, 5), '00000000', '0')
    call check_word(error, hex32_from_binary(1_int64, 0), '41100000', '1')
    call check_word(error, hex32_from_binary(-1_int64, -1), 'C0800000', '-1/2')
    call check_word(error, hex32_from_binary(1_int64, 3), '41800000', '8')
    call check_word(error, hex32_from_binary(1_int64, -260), '00100000', 'the smallest')
    call check_word(error, hex32_from_binary(1_int64, -261), '00000000', 'underflow')
    call check_word(error, hex32_from_binary(-1_int64, 252), 'FFFFFFFF', 'overflow')
    call check_word(error, hex32_from_binary(huge(1_int64), 0), '507FFFFF', 'largest digits')
    call check_word(error, hex32_from_binary(-huge(1_int64) - 1_int64, 3), 'D1400000', &
                    'smallest digits')
  end subroutine test_binary

  subroutine test_real64(error)
    type(error_type), allocatable, intent(out) :: error
    type(random_type) :: random
    type(parts_type) :: y
    type(hex32) :: number
    real(real64) :: value, lower, upper
    integer(int64) :: a, b
    integer :: i

    call check_word(error, hex32_from_real64(0.0_real64), '00000000', '0')
    call check_word(error, hex32_from_real64(-118.625_real64), 'C276A000', '-118.625')
    call check_word(error, hex32_from_real64(0.1_real64), '40199999', '0.1, cut')
    call check_word(error, hex32_from_real64(1.0e76_real64), '7FFFFFFF', 'overflow')
    call check_word(error, hex32_from_real64(-1.0e300_real64), 'FFFFFFFF', 'overflow below zero')
    call check_word(error, hex32_from_real64(5.0e-79_real64), '00000000', 'underflow')
    call check_word(error, hex32_from_real64(scale(1.0_real64, -260)), '00100000', 'the smallest')
    call check_word(error, hex32_from_real64(transfer(1_int64, value)), '00000000', 'subnormal')
    call check_word(error, hex32_from_real64(transfer(9218868437227405312_int64, value)), &
                    '7FFFFFFF', 'infinity')
    call check_word(error, hex32_from_real64(transfer(-4503599627370496_int64, value)), &
                    'FFFFFFFF', '-infinity')
    call check_word(error, hex32_from_real64(transfer(9221120237041090560_int64, value)), &
                    '00000000', 'not a number')
    call check(error, hex32_to_real64(x('C276A000')), -118.625_real64, 0.0_real64, '-118.625')
    call check(error, hex32_to_real64(x('00000000')), 0.0_real64, 0.0_real64, '0')
    call check(error, hex32_to_real64(x('00100000')), scale(1.0_real64, -260), 0.0_real64, &
               'the smallest')
    call check(error, hex32_to_real64(x('7FFFFFFF')), scale(16777215.0_real64, 228), &
               0.0_real64, 'the largest')
    do i = 1, trials
      call random_pair(random, i, a, b)
      call check_word(error, hex32_from_real64(hex32_to_real64(from(a))), text(a), &
                      'there and back')
      ! 53 bits between two neighbours: lower <= value < upper.
      value = scale(real(modulo(next(random)*2_wide**31 + next(random), 2_wide**53), real64), &
                    modulo(i, 300) - 180)
      number = hex32_from_real64(value)
      if (number == x('00000000')) cycle
      y = parts(iand(int(hex32_word(number), int64), 4294967295_int64))
      lower = scale(real(y%fraction, real64), 4*(y%characteristic - 70))
      upper = scale(real(y%fraction + 1, real64), 4*(y%characteristic - 70))
      call check(error, hex32_to_real64(number), lower, 0.0_real64, 'to double precision')
      call check(error, lower <= value .and. value < upper, 'cut from double precision')
    end do
  end subroutine test_real64

  subroutine test_circular_known(error)
    type(error_type), allocatable, intent(out) :: error

    ! Sines and cosines from mpmath with 600 bits, rounded to the nearest number.
    call both_are('00000000', '00000000', '41100000', '0')
    call both_are('41100000', '40D76AA4', '408A5140', '1')
    call both_are('40800000', '407ABBA2', '40E0A940', '1/2')
    call both_are('411921FB', '41100000', '3B54442D', 'pi/2, cut')
    call both_are('413243F6', '3BA8885A', 'C1100000', 'pi, cut')
    call both_are('416487ED', 'BB5110B4', '41100000', '2 pi, cut')
    call both_are('C12A0000', 'C07E7190', 'C0DE9806', '-2.625')
    call both_are('44271000', 'C04E3CBF', 'C0F3C074', '10000')
    call both_are('C4270FFF', '404D48D7', 'C0F40E37', '-9999.9')
    call both_are('3DFFFFFF', '3DFFFFFF', '41100000', 'below 2**(-12)')
    call both_are('3E100000', '3E100000', '41100000', '2**(-12)')
    call both_are('3E100001', '3E100001', '40FFFFFF', 'above 2**(-12)')
    call both_are('80100000', '80100000', '41100000', 'the smallest')
    ! Found by search: within 1e-7 units of a tie, and the nearest to whole quarter turns.
    call both_are('407EF259', '4079CEBA', '40E12A0B', 'sine near a tie')
    call both_are('401589F8', '40158377', '40FF182D', 'cosine near a tie')
    call both_are('4127C840', '409BFC6F', 'C0CAFD10', 'sine near a tie from below')
    call both_are('412967DF', '40869F30', 'C0D9BEC4', 'cosine near a tie from below')
    call both_are('43109E25', '40E9CEC8', 'C0684250', 'sine near a tie, large angle')
    call both_are('43ADB0B2', '40F43423', 'C04CD0B2', 'cosine near a tie, large angle')
    call both_are('42FCE5F1', '41100000', 'BA11FA3C', '161 quarter turns')
    call both_are('414B65F2', 'C1100000', '3A33378B', '3 quarter turns')
    call both_are('4196CBE4', 'BA666F17', 'C1100000', '6 quarter turns')
    call both_are('489E3779', '40EC7022', 'C06225EF', '0.618 * 16**8')
    call both_are('4F9E3779', 'C0FDB813', 'C02218FC', '0.618 * 16**15')
    call both_are('569E3779', '40F7908E', '40412CB7', '0.618 * 16**22')
    call both_are('5D9E3779', '40EDA60D', '405F2DF0', '0.618 * 16**29')
    call both_are('649E3779', 'C03555A1', 'C0FA61F0', '0.618 * 16**36')
    call both_are('6B9E3779', '40F46D82', 'C04C195C', '0.618 * 16**43')
    call both_are('729E3779', '407CE650', '40DF76BC', '0.618 * 16**50')
    call both_are('799E3779', 'C0DB8775', '4083B153', '0.618 * 16**57')
    call both_are('45C45A10', '4024C2E4', 'C0FD58C9', '804257')
    call both_are('7F123456', '40B44074', 'C0B5C89E', 'very large')
    call both_are('7FFFFFFF', '4049E0BE', '40F51BB6', 'the largest')

  contains

    subroutine both_are(a, sine, cosine, message)
      character(*), intent(in) :: a, sine, cosine, message

      call check_word(error, sin(x(a)), sine, 'sine of '//message)
      call check_word(error, cos(x(a)), cosine, 'cosine of '//message)
    end subroutine both_are

  end subroutine test_circular_known

  subroutine test_circular_random(error)
    type(error_type), allocatable, intent(out) :: error
    type(random_type) :: random
    type(parts_type) :: y
    integer(int64) :: a, b
    integer :: i
    real(real128) :: angle

    do i = 1, trials/10
      call random_pair(random, i, a, b)
      ! Characteristics 60 to 68: from 10**(-6) to 65535 rad.
      a = ior(shiftl(int(60 + modulo(i, 9), int64), 24), ibits(a, 0, 24))
      if (modulo(i, 2) == 0) a = opposite(a)
      if (ibits(a, 0, 24) == 0_int64) cycle
      y = parts(a)
      angle = scale(real(y%fraction, real128), 4*(y%characteristic - 70))
      if (y%below_zero) angle = -angle
      call check_word(error, sin(from(a)), text(nearest_word(sin(angle))), 'sine of '//text(a))
      call check_word(error, cos(from(a)), text(nearest_word(cos(angle))), 'cosine of '//text(a))
    end do
  end subroutine test_circular_random

  subroutine test_arrays(error)
    type(error_type), allocatable, intent(out) :: error
    type(hex32) :: numbers(3)

    numbers = hex32_from_integer([1, 2, 3])
    numbers = sqrt(numbers*numbers) - numbers/x('41200000')
    call check_word(error, numbers(1), '40800000', 'first')
    call check_word(error, numbers(2), '41100000', 'second')
    call check_word(error, numbers(3), '41180000', 'third')
    call check(error, all(numbers > x('00000000')), 'all above zero')
  end subroutine test_arrays

  ! --- what the tests say about a number ---

  subroutine check_word(error, found, expected, message)
    type(error_type), allocatable, intent(inout) :: error
    type(hex32), intent(in) :: found
    character(*), intent(in) :: expected, message
    character(8) :: word

    write (word, '(z8.8)') hex32_word(found)
    call check(error, word, expected, message)
  end subroutine check_word

  ! All six relations; order is below, at or above 0 as a is below, at or above b.
  subroutine check_order(error, a, b, order, message)
    type(error_type), allocatable, intent(inout) :: error
    type(hex32), intent(in) :: a, b
    integer, intent(in) :: order
    character(*), intent(in) :: message

    call check(error, (a < b) .eqv. (order < 0), message//' <')
    call check(error, (a <= b) .eqv. (order <= 0), message//' <=')
    call check(error, (a > b) .eqv. (order > 0), message//' >')
    call check(error, (a >= b) .eqv. (order >= 0), message//' >=')
    call check(error, (a == b) .eqv. (order == 0), message//' ==')
    call check(error, (a /= b) .eqv. (order /= 0), message//' /=')
  end subroutine check_order

  ! --- words: here a word is the whole number in [0, 2**32) with its bits ---

  function text(word) result(digits)
    integer(int64), intent(in) :: word
    character(8) :: digits

    write (digits, '(z8.8)') word
  end function text

  function x(digits) result(number)
    character(*), intent(in) :: digits
    type(hex32) :: number
    integer(int64) :: word

    read (digits, '(z8)') word
    number = from(word)
  end function x

  pure function from(word) result(number)
    integer(int64), intent(in) :: word
    type(hex32) :: number

    if (word >= 2_int64**31) then
      number = hex32_from_word(int(word - 2_int64**32, int32))
    else
      number = hex32_from_word(int(word, int32))
    end if
  end function from

  pure function opposite(word) result(changed)
    integer(int64), intent(in) :: word
    integer(int64) :: changed

    changed = word
    if (word /= 0_int64) changed = ieor(word, 2_int64**31)
  end function opposite

  pure function parts(word) result(p)
    integer(int64), intent(in) :: word
    type(parts_type) :: p

    p%below_zero = word >= 2_int64**31
    p%characteristic = int(modulo(word/2_int64**24, 128_int64))
    p%fraction = int(modulo(word, 2_int64**24), wide)
  end function parts

  ! The word of a fraction with at most six digits, with its over- and underflow.
  pure function word_of(below_zero, characteristic, fraction) result(word)
    logical, intent(in) :: below_zero
    integer, intent(in) :: characteristic
    integer(wide), intent(in) :: fraction
    integer(int64) :: word
    integer(wide) :: f
    integer :: c

    word = 0_int64
    if (fraction == 0_wide) return
    f = fraction
    c = characteristic
    do while (f < fraction_end/16)
      f = f*16
      c = c - 1
    end do
    if (c < 0) return
    if (c > 127) then
      word = 2147483647_int64
    else
      word = int(f, int64) + c*2_int64**24
    end if
    if (below_zero) word = word + 2_int64**31
  end function word_of

  ! --- pseudo-random numbers ---

  ! The next one, in [0, 2**31).
  function next(random) result(number)
    type(random_type), intent(inout) :: random
    integer(wide) :: number

    random%state = modulo(random%state*6364136223846793005_wide + 1442695040888963407_wide, &
                          2_wide**64)
    number = random%state/2_wide**33
  end function next

  ! Two words. Their exponents are mostly near each other, now and then at the ends of the range,
  ! and some fractions differ little or are all zeros or all ones.
  subroutine random_pair(random, i, a, b)
    type(random_type), intent(inout) :: random
    integer, intent(in) :: i
    integer(int64), intent(out) :: a, b
    integer :: c

    c = int(modulo(next(random), 128_wide))
    a = random_word(random, c)
    select case (modulo(i, 8))
    case (0)
      b = random_word(random, int(modulo(next(random), 128_wide)))
    case (1)
      b = max(0_int64, min(4294967295_int64, a + int(modulo(next(random), 33_wide), int64) - 16))
      if (modulo(b, 2_int64**24) < 2_int64**20) b = a
      b = opposite(b)
    case default
      b = random_word(random, max(0, min(127, c + int(modulo(next(random), 18_wide)) - 9)))
    end select
  end subroutine random_pair

  function random_word(random, characteristic) result(word)
    type(random_type), intent(inout) :: random
    integer, intent(in) :: characteristic
    integer(int64) :: word
    integer(wide) :: fraction, kind_of

    kind_of = modulo(next(random), 16_wide)
    fraction = 2_wide**20 + modulo(next(random), 15*2_wide**20)
    if (kind_of == 0) fraction = 2_wide**20 + modulo(fraction, 4_wide)
    if (kind_of == 1) fraction = fraction_end - 1 - modulo(fraction, 4_wide)
    if (kind_of == 2) fraction = fraction - modulo(fraction, 2_wide**12)
    word = word_of(modulo(next(random), 2_wide) == 1_wide, characteristic, fraction)
    if (modulo(next(random), 256_wide) == 0_wide) word = 0_int64
  end function random_word

  ! The nearest word to a real that is not zero.
  function nearest_word(value) result(word)
    real(real128), intent(in) :: value
    integer(int64) :: word
    integer :: characteristic
    real(real128) :: magnitude
    integer(wide) :: fraction

    magnitude = abs(value)
    characteristic = 64
    do while (magnitude < 1.0_real128/16.0_real128)
      magnitude = magnitude*16.0_real128
      characteristic = characteristic - 1
    end do
    do while (magnitude >= 1.0_real128)
      magnitude = magnitude/16.0_real128
      characteristic = characteristic + 1
    end do
    fraction = int(nint(magnitude*16.0_real128**6, int64), wide)
    if (fraction == fraction_end) then
      fraction = fraction/16
      characteristic = characteristic + 1
    end if
    word = word_of(value < 0.0_real128, characteristic, fraction)
  end function nearest_word

end module asperity_hex32_suite
