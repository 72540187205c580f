!> Tests of the report's number field: `Fw.d` as the line printer showed it.
!>
!> Every expected field is worked out by hand. Ties are numbers that a double holds exactly.
module asperity_report_fields_suite
  use asperity_kinds, only: real64
  use asperity_line_printer, only: fixed_field
  use asperity_testing, only: check, run_test
  implicit none
  private

  public :: run_report_fields

contains

  !> Runs the tests.
  subroutine run_report_fields
    call run_test('rounding, zeros, signs, asterisks', test_fields)
    call run_test('keeps to the width', test_width)
  end subroutine run_report_fields

  subroutine test_fields
    call check(fixed_field(0.33529_real64, 7, 4), ' 0.3353', 'up')
    call check(fixed_field(0.33524_real64, 7, 4), ' 0.3352', 'down')
    call check(fixed_field(1438.3_real64, 6, 0), ' 1438.', 'no decimals')
    call check(fixed_field(9.9996_real64, 8, 3), '  10.000', 'carry')
    call check(fixed_field(275760.0_real64, 11, 0), '    275760.', 'modulus')
    call check(fixed_field(0.125_real64, 6, 2), '  0.13', '0.125')
    call check(fixed_field(-0.125_real64, 6, 2), ' -0.13', '-0.125')
    call check(fixed_field(0.375_real64, 6, 2), '  0.38', '0.375')
    call check(fixed_field(0.5_real64, 6, 0), '    1.', '0.5')
    call check(fixed_field(1.5_real64, 6, 0), '    2.', '1.5')
    call check(fixed_field(2.5_real64, 6, 0), '    3.', '2.5')
    call check(fixed_field(-2.5_real64, 6, 0), '   -3.', '-2.5')
    call check(fixed_field(0.0625_real64, 7, 3), '  0.063', '0.0625')
    call check(fixed_field(0.0_real64, 8, 5), ' 0.0    ', 'F8.5')
    call check(fixed_field(0.0_real64, 7, 4), ' 0.0   ', 'F7.4')
    call check(fixed_field(0.0_real64, 6, 3), ' 0.0  ', 'F6.3')
    call check(fixed_field(0.0_real64, 5, 3), '0.0  ', 'F5.3')
    call check(fixed_field(0.0_real64, 10, 1), '       0.0', 'F10.1')
    call check(fixed_field(0.0_real64, 6, 0), '    0.', 'F6.0')
    call check(fixed_field(0.0_real64, 12, 0), '          0.', 'F12.0')
    call check(fixed_field(-0.0_real64, 6, 3), ' 0.0  ', 'negative zero')
    call check(index(fixed_field(0.0_real64, 8, 5), '.'), &
               index(fixed_field(0.01996_real64, 8, 5), '.'), 'column of the point')
    call check(fixed_field(0.0004_real64, 6, 3), ' 0.000', 'F6.3')
    call check(fixed_field(0.4_real64, 6, 0), '    0.', 'F6.0')
    call check(fixed_field(tiny(1.0_real64), 8, 5), ' 0.00000', 'smallest double')
    call check(fixed_field(-0.5_real64, 7, 3), ' -0.500', 'F7.3')
    call check(fixed_field(-12.34_real64, 6, 2), '-12.34', 'whole field')
    ! The zero before the point gives way to the sign.
    call check(fixed_field(-0.02_real64, 5, 3), '-.020', 'F5.3')
    call check(fixed_field(10.0_real64, 5, 3), '*****', 'too large')
    call check(fixed_field(9.9996_real64, 5, 3), '*****', 'too large when rounded')
    call check(fixed_field(9.9994_real64, 5, 3), '9.999', 'just small enough')
    call check(fixed_field(-1.0_real64, 5, 3), '*****', 'no room for the sign')
    call check(fixed_field(1.0e27_real64, 8, 0), '********', 'far too large')
  end subroutine test_fields

  subroutine test_width
    integer :: width, decimals

    do width = 5, 14
      do decimals = 0, width - 3
        call check(len(fixed_field(1.25_real64, width, decimals)), width, 'number')
        call check(len(fixed_field(0.0_real64, width, decimals)), width, 'zero')
        call check(index(fixed_field(1.25_real64, width, decimals), '.'), &
                   width - decimals, 'column of the point')
        call check(index(fixed_field(0.0_real64, width, decimals), '.'), &
                   width - decimals, 'column of the zero''s point')
      end do
    end do
  end subroutine test_width

end module asperity_report_fields_suite
