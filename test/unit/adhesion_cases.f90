!> The contact that the suites of adhesion test, and how near its numbers must be.
module asperity_adhesion_cases
  use asperity_adhesion_contact, only: adhering_contact, adhesion_numbers, answer_along_centres, &
                                       central_answer, new_adhering_contact
  use asperity_kinds, only: real64
  use asperity_testing, only: check, error_type
  implicit none
  private

  public :: pi, modulus, radius, work
  public :: distance_of, numbers_of, contact_of, contact_at, contact_with, answer_of, near

  real(real64), parameter :: pi = acos(-1.0_real64)
  !> The contact of the cases: E, R, w.
  real(real64), parameter :: modulus = 1.5_real64, radius = 0.5_real64, work = 0.01_real64
  ! Some units of the last place, and what the slope of a curve makes of those of its argument.
  real(real64), parameter :: tolerance = 2.0e-13_real64

contains

  !> The equilibrium distance at which the contact of the cases has a Tabor parameter.
  pure real(real64) function distance_of(tabor)
    !> the Tabor parameter
    real(real64), intent(in) :: tabor

    distance_of = ((work / modulus)**2 * radius)**(1.0_real64 / 3.0_real64) / tabor
  end function distance_of

  !> The material at which the contact of the cases has a Tabor parameter.
  pure function numbers_of(tabor) result(numbers)
    !> the Tabor parameter
    real(real64), intent(in) :: tabor
    type(adhesion_numbers) :: numbers

    numbers = adhesion_numbers(modulus, work, distance_of(tabor))
  end function numbers_of

  !> The contact of the cases with a Tabor parameter.
  function contact_of(tabor) result(contact)
    !> the Tabor parameter
    real(real64), intent(in) :: tabor
    type(adhering_contact) :: contact

    contact = contact_at(distance_of(tabor))
  end function contact_of

  !> The contact of the cases with an equilibrium distance.
  function contact_at(distance) result(contact)
    !> the equilibrium distance
    real(real64), intent(in) :: distance
    type(adhering_contact) :: contact

    contact = contact_with(work, distance)
  end function contact_at

  !> The contact of the cases with other numbers of adhesion.
  function contact_with(adhesion, distance) result(contact)
    !> work of adhesion and equilibrium distance
    real(real64), intent(in) :: adhesion, distance
    type(adhering_contact) :: contact

    call new_adhering_contact(adhesion_numbers(modulus, adhesion, distance), radius, contact)
  end function contact_with

  !> What a contact answers along its line of centres.
  function answer_of(contact, overlap) result(answer)
    !> the contact
    type(adhering_contact), intent(in) :: contact
    !> its overlap, negative across a gap
    real(real64), intent(in) :: overlap
    type(central_answer) :: answer

    ! The distance matters to the contact alone.
    call answer_along_centres(adhesion_numbers(modulus, work, 1.0_real64), contact, overlap, answer)
  end function answer_of

  !> Notes a failure unless a number is the expected one to rounding, as a share of a scale.
  subroutine near(error, found, expected, scale, message)
    !> the test's failure
    type(error_type), allocatable, intent(inout) :: error
    !> the two numbers, and what the difference is compared with
    real(real64), intent(in) :: found, expected, scale
    !> what is compared
    character(*), intent(in) :: message

    call check(error, found, expected, tolerance * abs(scale), message)
  end subroutine near

end module asperity_adhesion_cases
