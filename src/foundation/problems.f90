!> Problems found in a file or a command line: values that are carried to the edge of the program.
module asperity_problems
  use asperity_printable, only: printable
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: problem_list, decimal_text

  !> All that is wrong with one input, in the order found.
  type :: problem_list
    private
    type(text_buffer) :: lines
    integer :: number = 0
  contains
    !> Adds a problem at a place of a file.
    procedure :: add_at => problems_add_at
    !> Adds a problem that has no place.
    procedure :: add => problems_add
    !> How many problems there are.
    procedure :: count => problems_count
    !> One line a problem.
    procedure :: text => problems_text
  end type problem_list

contains

  !> Adds `FILE:LINE:COLUMN: MESSAGE`.
  pure subroutine problems_add_at(self, file, line, column, message)
    class(problem_list), intent(inout) :: self  !! the list
    character(len=*), intent(in) :: file        !! name of the file as the user gave it
    integer, intent(in) :: line                 !! line, from 1
    integer, intent(in) :: column               !! column, from 1
    character(len=*), intent(in) :: message     !! what is wrong, found, expected

    call self%add(file // ':' // decimal_text(line) // ':' // decimal_text(column) // ': ' // &
                  message)
  end subroutine problems_add_at

  !> Adds `MESSAGE`, made one printable line.
  pure subroutine problems_add(self, message)
    class(problem_list), intent(inout) :: self  !! the list
    character(len=*), intent(in) :: message     !! what is wrong, found, expected

    call self%lines%line(printable(message))
    self%number = self%number + 1
  end subroutine problems_add

  !> Number of problems; 0 means that the input is good.
  pure integer function problems_count(self)
    class(problem_list), intent(in) :: self  !! the list

    problems_count = self%number
  end function problems_count

  !> All problems, one a line, each with its line end.
  pure function problems_text(self) result(text)
    class(problem_list), intent(in) :: self  !! the list
    character(len=:), allocatable :: text    !! the lines

    text = self%lines%text()
  end function problems_text

  !> An integer as text without blanks.
  pure function decimal_text(value) result(text)
    integer, intent(in) :: value           !! any integer
    character(len=:), allocatable :: text  !! its decimal digits, with sign when negative
    character(len=12) :: digits

    write (digits, '(i0)') value
    text = trim(digits)
  end function decimal_text

end module asperity_problems
