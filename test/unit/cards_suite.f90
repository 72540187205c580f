!> Tests of the card fields: FORTRAN IV's rules for F and I fields, column by column.
!>
!> Expected values are worked out by hand from the rules: blanks are zeros, a missing point is
!> implied, an exponent has a letter or only its sign. A number is given as digits and a power of
!> ten, so nothing is rounded here.
module asperity_cards_suite
  use asperity_card_reader, only: read_f_field, read_i_field
  use asperity_decimal, only: decimal_value
  use asperity_kinds, only: int64
  use asperity_testing, only: check, run_test
  implicit none
  private

  public :: run_cards

contains

  !> Runs the tests.
  subroutine run_cards
    call run_test('F field: point, blanks, sign, exponent', test_f)
    call run_test('F field, column of what is wrong', test_bad_f)
    call run_test('I field', test_i)
    call run_test('I field, column of what is wrong', test_bad_i)
  end subroutine run_cards

  subroutine test_f
    call check_f('  500', 3, 500_int64, -3)
    call check_f('    1', 3, 1_int64, -3)
    call check_f('12345', 3, 12345_int64, -3)
    call check_f('12345', 0, 12345_int64, 0)
    call check_f('   34550', 4, 34550_int64, -4)
    call check_f('0000000001', 0, 1_int64, 0)
    call check_f('9999999999', 3, 9999999999_int64, -3)
    call check_f('5    ', 3, 50000_int64, -3)
    call check_f(' 5 1 ', 3, 5010_int64, -3)
    call check_f('1.5  ', 3, 15000_int64, -4)
    call check_f('1. 5 ', 3, 1050_int64, -3)
    call check_f('- 5', 1, -5_int64, -1)
    call check_f('     ', 3, 0_int64, 0)
    call check_f(' 0   ', 3, 0_int64, 0)
    call check_f('0.500', 3, 500_int64, -3)
    call check_f('0.500', 1, 500_int64, -3)
    call check_f('   .5', 3, 5_int64, -1)
    call check_f('   5.', 3, 5_int64, 0)
    call check_f('  400000.', 0, 400000_int64, 0)
    call check_f(' .0001', 3, 1_int64, -4)
    call check_f(' -500', 3, -500_int64, -3)
    call check_f(' +500', 3, 500_int64, -3)
    call check_f('-.5', 3, -5_int64, -1)
    call check_f('-0.02', 3, -2_int64, -2)
    call check_f('   -0', 3, 0_int64, -3)
    call check_f(' 4.E5', 0, 4_int64, 5)
    call check_f(' 4.D5', 0, 4_int64, 5)
    call check_f(' 4.e5', 0, 4_int64, 5)
    call check_f(' 4.d5', 0, 4_int64, 5)
    call check_f('4.E+5', 0, 4_int64, 5)
    call check_f('5.E-1', 3, 5_int64, -1)
    call check_f(' 4.+5', 0, 4_int64, 5)
    call check_f('  5-1', 0, 5_int64, -1)
    call check_f('-5.-1', 0, -5_int64, -1)
    call check_f('4.E 5', 0, 4_int64, 5)
    ! The implied point stands before the exponent applies.
    call check_f('500E1', 3, 500_int64, -2)
    ! Blanks behind an exponent are zeros as well.
    call check_f('1.E1 ', 3, 1_int64, 10)
  end subroutine test_f

  subroutine test_bad_f
    call check_bad_f('0.5X0', 4)
    call check_bad_f('X0.50', 1)
    call check_bad_f('  X  ', 3)
    call check_bad_f('0..50', 3)
    call check_bad_f('0.5.0', 4)
    call check_bad_f('1,500', 2)
    call check_bad_f('--500', 2)
    call check_bad_f('+ -50', 3)
    call check_bad_f('   E5', 4)
    call check_bad_f('  .E5', 4)
    call check_bad_f('1.EE5', 4)
    call check_bad_f('1.+E5', 4)
    call check_bad_f('1E+-5', 4)
    call check_bad_f('1E5+3', 4)
    call check_bad_f('1.E5.', 5)
    call check_bad_f(' 1E5.', 5)
    call check_bad_f(' 1.5E', 5)
    call check_bad_f('  1.-', 5)
    call check_bad_f('    -', 5)
    call check_bad_f('  .  ', 3)
    call check_bad_f('  NaN', 3)
    call check_bad_f('  Inf', 3)
    call check_bad_f('0x1.5', 2)
    call check_bad_f('0.5'//achar(9)//' ', 4)
  end subroutine test_bad_f

  subroutine test_i
    call check_i('   37', 37)
    call check_i('37   ', 37000)
    call check_i(' 3 7 ', 3070)
    call check_i('  -37', -37)
    call check_i('- 37 ', -370)
    call check_i('  +37', 37)
    call check_i('99999', 99999)
    call check_i('00007', 7)
    call check_i('     ', 0)
    call check_i('2147483647', 2147483647)
  end subroutine test_i

  subroutine test_bad_i
    call check_bad_i('  37.', 5)
    call check_bad_i('   3A', 5)
    call check_bad_i('  A37', 3)
    call check_bad_i(' 3E01', 3)
    call check_bad_i('   3-', 5)
    call check_bad_i('  --3', 4)
    call check_bad_i('    -', 5)
    call check_bad_i(' .5  ', 2)
    call check_bad_i('2147483648', 1)
  end subroutine test_bad_i

  subroutine check_f(field, decimals, digits, exponent)
    character(*), intent(in) :: field
    integer, intent(in) :: decimals
    integer(int64), intent(in) :: digits
    integer, intent(in) :: exponent
    type(decimal_value) :: value
    integer :: bad_at

    call read_f_field(field, decimals, value, bad_at)
    call check(bad_at, 0, 'wrong column of "'//field//'"')
    call check_number(value, digits, exponent, '"'//field//'"')
  end subroutine check_f

  !> Equal as numbers: digits and exponent may be split in another way.
  subroutine check_number(value, digits, exponent, name)
    type(decimal_value), intent(in) :: value
    integer(int64), intent(in) :: digits
    integer, intent(in) :: exponent
    character(*), intent(in) :: name
    integer(int64) :: found, expected
    integer :: least

    if (digits == 0_int64) then
      call check(value%all_digits, 0_int64, name//', zero')
      return
    end if
    least = min(value%power_of_ten, exponent)
    if (max(value%power_of_ten, exponent) - least > 5) then
      call check(value%power_of_ten, exponent, name//', power of ten')
      return
    end if
    found = value%all_digits*10_int64**(value%power_of_ten - least)
    expected = digits*10_int64**(exponent - least)
    call check(found, expected, name)
  end subroutine check_number

  subroutine check_bad_f(field, column)
    character(*), intent(in) :: field
    integer, intent(in) :: column
    type(decimal_value) :: value
    integer :: bad_at

    call read_f_field(field, 3, value, bad_at)
    call check(bad_at, column, 'wrong column of "'//field//'"')
  end subroutine check_bad_f

  subroutine check_i(field, expected)
    character(*), intent(in) :: field
    integer, intent(in) :: expected
    integer :: value, bad_at

    call read_i_field(field, value, bad_at)
    call check(bad_at, 0, 'wrong column of "'//field//'"')
    call check(value, expected, '"'//field//'"')
  end subroutine check_i

  subroutine check_bad_i(field, column)
    character(*), intent(in) :: field
    integer, intent(in) :: column
    integer :: value, bad_at

    call read_i_field(field, value, bad_at)
    call check(bad_at, column, 'wrong column of "'//field//'"')
  end subroutine check_bad_i

end module asperity_cards_suite
