!> A small test harness, in the manner of test-drive.
!>
!> A suite is a procedure that lists its tests by name. A test is a procedure that leaves `error`
!> unallocated when all is well; only the first failure of a test is kept.
module asperity_testing
  use, intrinsic :: iso_fortran_env, only: output_unit
  use asperity_kinds, only: int32, int64, real64
  implicit none
  private

  public :: error_type, unittest_type, tally_type
  public :: new_unittest, check, run_suite, finish

  !> Why a test failed; not allocated as long as it has not.
  type :: error_type
    !> what was checked, found and expected
    character(:), allocatable :: message
  end type error_type

  abstract interface
    !> A test.
    subroutine test_interface(error)
      import :: error_type
      implicit none
      !> allocated when the test has failed
      type(error_type), allocatable, intent(out) :: error
    end subroutine test_interface
  end interface

  !> Length of a test's name. It is fixed because gfortran 12 never frees names of any length in an
  !> array constructor, in which a suite lists its tests.
  integer, parameter :: name_length = 80

  !> A test with its name.
  type :: unittest_type
    !> what the test shows
    character(name_length) :: name = ''
    !> the test
    procedure(test_interface), pointer, nopass :: test => null()
  end type unittest_type

  abstract interface
    !> The procedure by which a suite lists its tests.
    subroutine collect_interface(suite)
      import :: unittest_type
      implicit none
      !> all tests of the suite
      type(unittest_type), allocatable, intent(out) :: suite(:)
    end subroutine collect_interface
  end interface

  !> Count of tests run.
  type :: tally_type
    !> tests without a failure
    integer :: passed = 0
    !> tests with a failure
    integer :: failed = 0
  end type tally_type

  !> Notes a failure unless a condition holds or a value is the one expected.
  !>
  !> `check(error, condition, message)`, `check(error, found, expected, message)` for integers and
  !> text (trailing blanks count), `check(error, found, expected, tolerance, message)` for reals.
  interface check
    module procedure check_condition
    module procedure check_int32
    module procedure check_int64
    module procedure check_text
    module procedure check_real64
  end interface check

contains

  !> A test under a name.
  function new_unittest(name, test) result(entry)
    !> what the test shows, in 80 characters
    character(*), intent(in) :: name
    !> the test
    procedure(test_interface) :: test
    type(unittest_type) :: entry

    entry%name = name
    entry%test => test
  end function new_unittest

  !> Runs the tests of a suite, prints those that fail and adds to the count.
  subroutine run_suite(name, collect, tally)
    !> the suite's name
    character(*), intent(in) :: name
    !> lists the tests
    procedure(collect_interface) :: collect
    !> count so far
    type(tally_type), intent(inout) :: tally
    type(unittest_type), allocatable :: suite(:)
    type(error_type), allocatable :: error
    integer :: i

    if (.not. is_chosen(name)) return
    ! gfortran 12 warns of bounds it thinks unset otherwise.
    allocate (suite(0))
    call collect(suite)
    ! A suite that lists nothing must not pass for one that is well.
    if (size(suite) == 0) then
      tally%failed = tally%failed + 1
      write (output_unit, '(a)') 'FAILED '//name//': the suite has no tests'
    end if
    do i = 1, size(suite)
      call suite(i)%test(error)
      if (allocated(error)) then
        tally%failed = tally%failed + 1
        write (output_unit, '(a)') 'FAILED '//name//': '//trim(suite(i)%name)//': '//error%message
      else
        tally%passed = tally%passed + 1
      end if
      ! Seen even when a later test brings the program down.
      flush (output_unit)
    end do
  end subroutine run_suite

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
  subroutine finish(tally)
    !> count of all suites
    type(tally_type), intent(in) :: tally

    write (output_unit, '(i0, a, i0, a)') tally%passed, ' passed, ', tally%failed, ' failed'
    flush (output_unit)
    if (tally%failed > 0) error stop 1
  end subroutine finish

  subroutine check_condition(error, condition, message)
    type(error_type), allocatable, intent(inout) :: error
    logical, intent(in) :: condition
    character(*), intent(in) :: message

    if (allocated(error) .or. condition) return
    allocate (error)
    error%message = message
  end subroutine check_condition

  subroutine check_int32(error, found, expected, message)
    type(error_type), allocatable, intent(inout) :: error
    integer(int32), intent(in) :: found, expected
    character(*), intent(in) :: message

    call check_int64(error, int(found, int64), int(expected, int64), message)
  end subroutine check_int32

  subroutine check_int64(error, found, expected, message)
    type(error_type), allocatable, intent(inout) :: error
    integer(int64), intent(in) :: found, expected
    character(*), intent(in) :: message
    character(80) :: values

    if (found == expected) return
    write (values, '(a, i0, a, i0)') ': found ', found, ', expected ', expected
    call check_condition(error, .false., message//trim(values))
  end subroutine check_int64

  subroutine check_text(error, found, expected, message)
    type(error_type), allocatable, intent(inout) :: error
    character(*), intent(in) :: found, expected
    character(*), intent(in) :: message

    call check_condition(error, found == expected .and. len(found) == len(expected), &
                         message//': found "'//found//'", expected "'//expected//'"')
  end subroutine check_text

  subroutine check_real64(error, found, expected, tolerance, message)
    type(error_type), allocatable, intent(inout) :: error
    real(real64), intent(in) :: found, expected
    !> largest difference allowed, in the unit of the values
    real(real64), intent(in) :: tolerance
    character(*), intent(in) :: message
    character(120) :: values

    ! Written so that a NaN fails.
    if (abs(found - expected) <= tolerance) return
    write (values, '(2(a, es24.16e3), a, es9.2)') ': found', found, ', expected', expected, &
      ' within', tolerance
    call check_condition(error, .false., message//trim(values))
  end subroutine check_real64

end module asperity_testing
