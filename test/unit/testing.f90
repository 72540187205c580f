!> A small test harness: a suite is a procedure that runs its tests by name, a test is a procedure
!> without arguments. A test fails by its first `check` that does not hold.
module asperity_testing
  use, intrinsic :: iso_fortran_env, only: output_unit
  use asperity_kinds, only: int32, int64, real64
  implicit none
  private

  public :: check, finish, has_failed, run_suite, run_test

  abstract interface
    !> A suite, or a test.
    subroutine test_interface
      implicit none
    end subroutine test_interface
  end interface

  !> Notes a failure unless a condition holds or a value is the one expected.
  !>
  !> `check(condition, message)`, `check(found, expected, message)` for integers and text (trailing
  !> blanks count), `check(found, expected, tolerance, message)` for reals.
  interface check
    module procedure check_condition
    module procedure check_int32
    module procedure check_int64
    module procedure check_text
    module procedure check_real64
  end interface check

  ! The suite that runs, why its test has failed, and the count of tests.
  character(:), allocatable :: suite_name, failure
  integer :: passed = 0, failed = 0

contains

  !> Runs the tests of a suite, if it is named on the command line or none is named there.
  subroutine run_suite(name, suite)
    character(*), intent(in) :: name    !! the suite's name
    procedure(test_interface) :: suite  !! runs its tests
    integer :: before

    if (.not. is_chosen(name)) return
    suite_name = name
    before = passed + failed
    call suite
    ! A suite that runs nothing must not pass for one that is well.
    if (passed + failed > before) return
    failed = failed + 1
    write (output_unit, '(a)') 'FAILED '//name//': the suite has no tests'
  end subroutine run_suite

  !> Runs a test, prints its first failure and adds to the count.
  subroutine run_test(name, test)
    character(*), intent(in) :: name  !! what the test shows
    procedure(test_interface) :: test

    if (allocated(failure)) deallocate (failure)
    call test
    if (has_failed()) then
      failed = failed + 1
      write (output_unit, '(a)') 'FAILED '//suite_name//': '//name//': '//failure
    else
      passed = passed + 1
    end if
    ! Seen even when a later test brings the program down.
    flush (output_unit)
  end subroutine run_test

  !> Whether a check of the present test has failed.
  logical function has_failed()
    has_failed = allocated(failure)
  end function has_failed

  ! Whether a suite is named on the command line, or none is named there.
  logical function is_chosen(name)
    character(*), intent(in) :: name
    character(len=len(name) + 1) :: word
    integer :: i

    is_chosen = command_argument_count() == 0
    do i = 1, command_argument_count()
      call get_command_argument(i, word)
      is_chosen = is_chosen .or. word == name
    end do
  end function is_chosen

  !> Prints the count as the last line and stops with an error when a test has failed.
  subroutine finish()
    write (output_unit, '(i0, a, i0, a)') passed, ' passed, ', failed, ' failed'
    flush (output_unit)
    if (failed > 0) error stop 1
  end subroutine finish

  subroutine check_condition(condition, message)
    logical, intent(in) :: condition
    character(*), intent(in) :: message

    if (.not. (condition .or. has_failed())) failure = message
  end subroutine check_condition

  subroutine check_int32(found, expected, message)
    integer(int32), intent(in) :: found, expected
    character(*), intent(in) :: message

    call check_int64(int(found, int64), int(expected, int64), message)
  end subroutine check_int32

  subroutine check_int64(found, expected, message)
    integer(int64), intent(in) :: found, expected
    character(*), intent(in) :: message
    character(80) :: values

    if (found == expected) return
    write (values, '(a, i0, a, i0)') ': found ', found, ', expected ', expected
    call check_condition(.false., message//trim(values))
  end subroutine check_int64

  subroutine check_text(found, expected, message)
    character(*), intent(in) :: found, expected, message

    call check_condition(found == expected .and. len(found) == len(expected), &
                         message//': found "'//found//'", expected "'//expected//'"')
  end subroutine check_text

  subroutine check_real64(found, expected, tolerance, message)
    real(real64), intent(in) :: found, expected
    real(real64), intent(in) :: tolerance  !! largest difference allowed, in the unit of the values
    character(*), intent(in) :: message
    character(120) :: values

    ! Written so that a NaN fails.
    if (abs(found - expected) <= tolerance) return
    write (values, '(2(a, es24.16e3), a, es9.2)') ': found', found, ', expected', expected, &
      ' within', tolerance
    call check_condition(.false., message//trim(values))
  end subroutine check_real64

end module asperity_testing
