!> The problems of one text file: placed, and cut off before they fill the screen.
module asperity_input_problems
  use asperity_problems, only: decimal_text, problem_list
  implicit none
  private

  public :: input_problems, add_lines, binary_byte, lower_case, quoted, text_start, &
            most_problems

  !> So many problems of a file are written out, the rest is counted: enough for any file that a
  !> person wrote, and no flood from one that is not of this kind at all.
  integer, parameter :: most_problems = 5000

  ! A longer piece of the file is not repeated in a message.
  integer, parameter :: most_repeated = 40

  !> Problems of one file, in the order found.
  type :: input_problems
    private
    character(len=:), allocatable :: file
    type(problem_list) :: list
    integer :: number = 0
  contains
    !> Names the file and forgets earlier problems.
    procedure :: start
    !> Adds a problem at a line and column.
    procedure :: add_at
    !> Adds a problem at a byte of the text.
    procedure :: add_at_byte
    !> How many problems there are, those not written out included.
    procedure :: count => problem_count
    !> Adds all of them to another list.
    procedure :: hand_over
  end type input_problems

contains

  !> Names the file and forgets earlier problems.
  pure subroutine start(self, file)
    class(input_problems), intent(inout) :: self  !! the problems
    character(len=*), intent(in) :: file          !! name of the file as the user gave it
    type(problem_list) :: empty

    self%file = file
    self%list = empty
    self%number = 0
  end subroutine start

  !> Adds a problem at a line and column, both from 1.
  pure subroutine add_at(self, line, column, message)
    class(input_problems), intent(inout) :: self  !! the problems
    integer, intent(in) :: line                   !! line, from 1
    integer, intent(in) :: column                 !! column, from 1
    character(len=*), intent(in) :: message       !! what is wrong, found, expected

    self%number = self%number + 1
    if (self%number <= most_problems) call self%list%add_at(self%file, line, column, message)
  end subroutine add_at

  !> Adds a problem at a byte of the file's text.
  pure subroutine add_at_byte(self, text, byte, message)
    class(input_problems), intent(inout) :: self  !! the problems
    character(len=*), intent(in) :: text          !! the whole file
    integer, intent(in) :: byte                   !! place, from 1
    character(len=*), intent(in) :: message       !! what is wrong, found, expected
    integer :: i, line, before

    line = 1
    before = 0
    if (self%number < most_problems) then
      do i = 1, min(byte - 1, len(text))
        if (text(i:i) /= achar(10)) cycle
        line = line + 1
        before = i
      end do
    end if
    call self%add_at(line, byte - before, message)
  end subroutine add_at_byte

  !> Number of problems; 0 means that the file is good.
  pure integer function problem_count(self)
    class(input_problems), intent(in) :: self  !! the problems

    problem_count = self%number
  end function problem_count

  !> Adds all problems to `problems`, and how many were left out.
  pure subroutine hand_over(self, problems)
    class(input_problems), intent(in) :: self      !! the problems
    type(problem_list), intent(inout) :: problems  !! where they go

    call add_lines(self%list, problems)
    if (self%number > most_problems) &
      call problems%add(self%file // ': and ' // decimal_text(self%number - most_problems) // &
                        ' more problems')
  end subroutine hand_over

  !> Adds the problems of one list to another.
  pure subroutine add_lines(from, to)
    type(problem_list), intent(in) :: from   !! these problems
    type(problem_list), intent(inout) :: to  !! get behind those
    character(len=:), allocatable :: text
    integer :: first, length

    text = from%text()
    first = 1
    do while (first <= len(text))
      length = index(text(first:), new_line('a')) - 1
      call to%add(text(first:first + length - 1))
      first = first + length + 1
    end do
  end subroutine add_lines

  !> Place of the first byte that no text has; 0 when there is none.
  pure integer function binary_byte(text)
    character(len=*), intent(in) :: text  !! the whole file
    integer :: i, code

    do i = 1, len(text)
      code = iachar(text(i:i))
      if (code >= 32 .and. code /= 127) cycle
      if (code == 9 .or. code == 10 .or. code == 13) cycle
      binary_byte = i
      return
    end do
    binary_byte = 0
  end function binary_byte

  !> First byte behind the byte order mark that some programs write before UTF-8.
  pure integer function text_start(text)
    character(len=*), intent(in) :: text  !! the whole file

    text_start = 1
    if (index(text, char(239) // char(187) // char(191)) == 1) text_start = 4
  end function text_start

  !> The text with its ASCII capitals made small.
  pure function lower_case(text) result(small)
    character(len=*), intent(in) :: text  !! any text
    character(len=len(text)) :: small     !! the same in small letters
    integer :: i, code

    do i = 1, len(text)
      code = iachar(text(i:i))
      if (code >= iachar('A') .and. code <= iachar('Z')) code = code + 32
      small(i:i) = achar(code)
    end do
  end function lower_case

  !> A piece of the file for a message: between quotes, cut when long.
  pure function quoted(piece) result(text)
    character(len=*), intent(in) :: piece  !! the piece as it was found
    character(len=:), allocatable :: text  !! for instance `'1.2.3'`

    if (len(piece) <= most_repeated) then
      text = '''' // piece // ''''
    else
      text = '''' // piece(:most_repeated) // '...'''
    end if
  end function quoted

end module asperity_input_problems
