!> Tests of the short hexadecimal arithmetic: what a System/370 left, powers, conversions, angles.
!>
!> Numbers are written as machine words in hexadecimal: `C276A000` is -118.625. Random operands are
!> compared with exact results in test/hard/test_hex32_machine.py.
module asperity_hex32_suite
  use asperity_hex32, only: hex32, hex32_huge, hex32_tiny, hex32_from_binary, hex32_from_decimal
  use asperity_hex32, only: hex32_from_integer, hex32_from_real64, hex32_from_word
  use asperity_hex32, only: hex32_to_integer, hex32_to_real64, hex32_word
  use asperity_hex32, only: cos, sin, sqrt, three_halves_power
  use asperity_hex32, only: operator(+), operator(-), operator(*), operator(/)
  use asperity_hex32, only: operator(<), operator(<=), operator(>), operator(>=)
  use asperity_hex32, only: operator(==), operator(/=)
  use asperity_kinds, only: int64, real64
  use asperity_testing, only: check, run_test
  implicit none
  private

  public :: run_hex32

contains

  !> Runs the tests.
  subroutine run_hex32
    call run_test('zero, largest and smallest', test_constants)
    call run_test('operations of a System/370, archived', test_machine)
    call run_test('x**1.5 at the ends of the range', test_power_ends)
    call run_test('decimals far beyond the range', test_decimal_ends)
    call run_test('from digits and a power of two', test_binary)
    call run_test('from and to double precision', test_real64)
    call run_test('sine and cosine next to ties', test_circular_ties)
  end subroutine run_hex32

  subroutine test_constants
    type(hex32) :: untouched

    call check_word(untouched, '00000000', 'start value')
    call check_word(hex32_huge(), '7FFFFFFF', 'largest')
    call check_word(hex32_tiny(), '00100000', 'smallest')
    call check_word(-untouched, '00000000', 'zero has no sign')
    call check_word(-x('41100000'), 'C1100000', 'negative of one')
    call check_word(+x('C1100000'), 'C1100000', 'unary plus')
  end subroutine test_constants

  ! Results of a System/370 for 200 pairs of each kind of operation, with its condition codes
  ! (reference_output/hex32/README.md). In the place of an interrupted result the FORTRAN library
  ! put the largest number, or zero for 0/0.
  subroutine test_machine
    character(80) :: line
    character(12) :: cells(6)
    type(hex32) :: a, b, z
    integer :: unit, status, rows, below

    open (newunit=unit, file='reference_output/hex32/pairs.csv', status='old', action='read')
    read (unit, '(a)') line
    rows = 0
    do
      read (unit, '(a)', iostat=status) line
      if (status /= 0) exit
      ! The arithmetic holds no number with zeros before its digits.
      if (index(line, 'unnormalised') > 0) cycle
      read (line, *) cells
      rows = rows + 1
      a = x(cells(2))
      b = x(cells(3))
      select case (cells(1))
      case ('AE'); z = a + b
      case ('SE'); z = a - b
      case ('ME'); z = a * b
      case ('DE'); z = a / b
      case ('LTER'); z = +a
      case ('LCER'); z = -a
      case ('HER'); z = x('40800000') * a
      case ('SQRT'); z = sqrt(a)
      case ('FLOAT'); z = hex32_from_integer(signed(cells(2)))
      case ('FIX', 'FIX-AU')
        call check(hex32_to_integer(a), signed(cells(4)), line)
        cycle
      case ('CE')
        below = index('021', cells(5)(1:1)) - 2
        call check(((a < b) .eqv. below > 0) .and. ((a > b) .eqv. below == 0) .and. &
                   ((a == b) .eqv. below < 0) .and. ((a <= b) .neqv. a > b) .and. &
                   ((a >= b) .neqv. a < b) .and. ((a /= b) .neqv. a == b), line)
        cycle
      case default
        call check(.false., 'an operation without a test: ' // line)
      end select
      if (cells(6) == 'C') then
        call check_word(z, merge('F', '7', signed(cells(4)) < 0) // 'FFFFFFF', line)
      else if (cells(6) == 'F') then
        call check_word(z, merge('00000000', merge('F', '7', signed(cells(2)) < 0) // &
                                        'FFFFFFF', a == x('00000000')), line)
      else
        ! The arithmetic has one zero.
        call check_word(z, merge('00000000', cells(4)(:8), cells(4)(3:8) == '000000'), line)
        if (cells(1) == 'AE' .or. cells(1) == 'SE') &
          call check(cells(5) == trim(merge('1', merge('2', '0', z > x('00000000')), &
                                                   z < x('00000000'))), line)
      end if
      ! Each operand is a double, and what lies below the next number is cut.
      if (scan(cells(1), 'F') > 0) cycle
      call check_word(hex32_from_real64(hex32_to_real64(a)), text_of(a), line)
      call check_word(hex32_from_real64(hex32_to_real64(a) * (1 + 2.0_real64**(-25))), &
                      text_of(a), line)
    end do
    close (unit)
    call check(rows, 2400, 'rows')
  end subroutine test_machine

  subroutine test_power_ends
    call check_word(three_halves_power(x('00000000')), '00000000', '0')
    call check_word(three_halves_power(x('C1400000')), '41800000', '-4, the power of the magnitude')
    call check_word(three_halves_power(x('7F100000')), '7FFFFFFF', 'overflow')
    call check_word(three_halves_power(x('00100000')), '00000000', 'underflow')
    ! (1 - e)**1.5 = 1 - 1.5*e + 0.375*e**2 lies just above the tie.
    call check_word(three_halves_power(x('16FFFFFF')), '01FFFFFF', &
                    '16**(-42)*(1 - e), e = 2**(-24)')
  end subroutine test_power_ends

  subroutine test_decimal_ends
    call check_word(hex32_from_decimal(1_int64, 2000000000), '7FFFFFFF', 'overflow, any exponent')
    call check_word(hex32_from_decimal(-1_int64, -2000000000), '00000000', &
                    'underflow, any exponent')
    call check_word(hex32_from_decimal(huge(1_int64), 0), '507FFFFF', 'largest digits')
    call check_word(hex32_from_decimal(-huge(1_int64) - 1_int64, 0), 'D0800000', 'smallest digits')
    call check_word(hex32_from_decimal(-huge(1_int64) - 1_int64, -120), '00000000', &
                    'smallest digits, underflow')
  end subroutine test_decimal_ends

  subroutine test_binary
    call check_word(hex32_from_binary(0_int64, 5), '00000000', '0')
    call check_word(hex32_from_binary(1_int64, 0), '41100000', '1')
    call check_word(hex32_from_binary(-1_int64, -1), 'C0800000', '-1/2')
    call check_word(hex32_from_binary(1_int64, 3), '41800000', '8')
    call check_word(hex32_from_binary(1_int64, -260), '00100000', 'the smallest')
    call check_word(hex32_from_binary(1_int64, -261), '00000000', 'underflow')
    call check_word(hex32_from_binary(-1_int64, 252), 'FFFFFFFF', 'overflow')
    call check_word(hex32_from_binary(huge(1_int64), 0), '507FFFFF', 'largest digits')
    call check_word(hex32_from_binary(-huge(1_int64) - 1_int64, 3), 'D1400000', 'smallest digits')
  end subroutine test_binary

  subroutine test_real64
    real(real64) :: value

    call check_word(hex32_from_real64(0.0_real64), '00000000', '0')
    call check_word(hex32_from_real64(-118.625_real64), 'C276A000', '-118.625')
    call check_word(hex32_from_real64(0.1_real64), '40199999', '0.1, cut')
    call check_word(hex32_from_real64(1.0e76_real64), '7FFFFFFF', 'overflow')
    call check_word(hex32_from_real64(-1.0e300_real64), 'FFFFFFFF', 'overflow below zero')
    call check_word(hex32_from_real64(5.0e-79_real64), '00000000', 'underflow')
    call check_word(hex32_from_real64(scale(1.0_real64, -260)), '00100000', 'the smallest')
    call check_word(hex32_from_real64(transfer(1_int64, value)), '00000000', 'subnormal')
    call check_word(hex32_from_real64(transfer(9218868437227405312_int64, value)), &
                    '7FFFFFFF', 'infinity')
    call check_word(hex32_from_real64(transfer(-4503599627370496_int64, value)), &
                    'FFFFFFFF', '-infinity')
    call check_word(hex32_from_real64(transfer(9221120237041090560_int64, value)), &
                    '00000000', 'not a number')
    call check(hex32_to_real64(x('C276A000')), -118.625_real64, 0.0_real64, '-118.625')
    call check(hex32_to_real64(x('00000000')), 0.0_real64, 0.0_real64, '0')
    call check(hex32_to_real64(x('00100000')), scale(1.0_real64, -260), 0.0_real64, 'the smallest')
    call check(hex32_to_real64(x('7FFFFFFF')), scale(16777215.0_real64, 228), &
               0.0_real64, 'the largest')
  end subroutine test_real64

  subroutine test_circular_ties
    ! Sines and cosines from mpmath with 600 bits, rounded to the nearest number.
    call both_are('00000000', '00000000', '41100000', '0')
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
    call both_are('7FFFFFFF', '4049E0BE', '40F51BB6', 'the largest')

  contains

    subroutine both_are(a, sine, cosine, message)
      character(*), intent(in) :: a, sine, cosine, message

      call check_word(sin(x(a)), sine, 'sine of '//message)
      call check_word(cos(x(a)), cosine, 'cosine of '//message)
    end subroutine both_are

  end subroutine test_circular_ties

  ! --- what the tests state about a number ---

  subroutine check_word(found, expected, message)
    type(hex32), intent(in) :: found
    character(*), intent(in) :: expected, message

    call check(text_of(found), expected, message)
  end subroutine check_word

  function text_of(number) result(digits)
    type(hex32), intent(in) :: number
    character(8) :: digits

    write (digits, '(z8.8)') hex32_word(number)
  end function text_of

  ! The whole number with the bits of a word.
  function signed(digits) result(number)
    character(*), intent(in) :: digits
    integer :: number

    read (digits, '(z8)') number
  end function signed

  function x(digits) result(number)
    character(*), intent(in) :: digits
    type(hex32) :: number

    number = hex32_from_word(signed(digits))
  end function x

end module asperity_hex32_suite
