!> Tests of the search for roots: it ends at neighbouring numbers, in few guesses, in every case.
module asperity_bracket_suite
  use asperity_kinds, only: real64
  use asperity_root_bracket, only: guess_root, narrow_bracket, root_bracket
  use asperity_testing, only: check, run_test
  implicit none
  private

  public :: run_brackets

  ! Functions that rise from below zero at 0.
  integer, parameter :: square = 1, steep = 2, jump = 3, flat = 4, small = 5, straight = 6, &
                        small_jump = 7
  real(real64), parameter :: places(7) = [sqrt(2.0_real64), 0.001_real64, 0.7_real64, &
                                          0.5_real64, 1.0e-200_real64, 1.0_real64 / 3, &
                                          1.0e-200_real64]
  integer, parameter :: most_guesses(7) = [30, 80, 75, 145, 65, 65, 120]

contains

  !> Runs the tests.
  subroutine run_brackets
    call run_test('a root is found to the last digit, whatever the function is', all_functions)
    call run_test('the same with nothing known of the upper end', unknown_end)
  end subroutine run_brackets

  subroutine all_functions
    integer :: which

    do which = 1, size(places)
      call search(which, value_of(which, 4.0_real64), most_guesses(which))
    end do
  end subroutine all_functions

  subroutine unknown_end
    integer :: which

    do which = 1, size(places)
      call search(which, -1.0_real64, most_guesses(which) + 5)
    end do
  end subroutine unknown_end

  subroutine search(which, high_miss, most)
    integer, intent(in) :: which, most
    real(real64), intent(in) :: high_miss
    type(root_bracket) :: bracket
    real(real64) :: guess, value
    logical :: inside

    bracket = root_bracket(low=0.0_real64, high=4.0_real64, low_miss=value_of(which, 0.0_real64), &
                           high_miss=high_miss)
    do
      call guess_root(bracket, guess, inside)
      if (.not. inside .or. bracket%guesses > 1000) exit
      value = value_of(which, guess)
      call narrow_bracket(bracket, guess, value, value < 0.0_real64)
    end do
    call check(bracket%high <= nearest(bracket%low, 1.0_real64), 'numbers lie between')
    call check(value_of(which, bracket%low) < 0.0_real64 .and. &
                      .not. value_of(which, bracket%high) < 0.0_real64, 'no root between')
    ! The tenth root is as uncertain as ten units of the last place.
    call check(abs(bracket%high - places(which)) <= 20 * spacing(places(which)), 'another root')
    call check(bracket%guesses <= most, 'too many guesses')
  end subroutine search

  elemental real(real64) function value_of(which, x)
    integer, intent(in) :: which
    real(real64), intent(in) :: x

    select case (which)
    case (square)
      value_of = x * x - 2.0_real64
    case (steep)
      value_of = max(x, 0.0_real64)**0.1_real64 - places(which)**0.1_real64
    case (jump, small_jump)
      value_of = merge(-1.0_real64, 1.0_real64, x < places(which))
    case (flat)
      value_of = (x - places(which))**9
    case (small)
      value_of = x - places(which)
    case default
      value_of = 3.0_real64 * x - 1.0_real64
    end select
  end function value_of

end module asperity_bracket_suite
