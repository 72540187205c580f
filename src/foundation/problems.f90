!> Problems found in a file or a command line: values that are carried to the edge of the program.
module asperity_problems
  use asperity_kinds, only: int64, real64
  use asperity_printable, only: printable
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: problem_list, problem_place, decimal_text, not_enough_memory, real_text

  !> Beginning of a message where memory ends.
  character(len=*), parameter :: not_enough_memory = 'not enough memory'

  !> An integer as text without blanks.
  interface decimal_text
    module procedure :: short_decimal, long_decimal
  end interface decimal_text

  ! So many problems of a file are written out, and so many in a row that say the same of other
  ! lines; the rest is counted. Enough to see what is wrong everywhere, and no flood from a file
  ! that is not of this kind at all, or has one slip in every line.
  integer, parameter :: most_placed = 5000, most_alike = 20

  !> Where a problem is.
  type :: problem_place
    integer :: line = 0         !! line of the file, from 1; 0: the problem has none
    integer :: column = 0       !! column, from 1; 0: none
    integer :: file_length = 0  !! the problem's text begins with the file's name, so long; 0: none
    integer :: prefix = 0       !! and the message with the character after so many
  end type problem_place

  !> All that is wrong with one input, in the order found.
  type :: problem_list
    private
    type(text_buffer) :: lines
    type(problem_place), allocatable :: places(:)  ! of each line
    character(len=:), allocatable :: file  ! to which the places of `add_at` refer
    integer :: placed = 0, others = 0      ! problems with a place in it, and without
    integer :: beyond = 0                  ! those that came after `most_placed` had been written
    integer :: alike = 0                   ! in a row that say the same as the last one
    character(len=80) :: last = ''         ! the last one, without what was found
    !> Memory ended while the input was read: nothing is known to be wrong with it.
    logical, public :: lacks_memory = .false.
  contains
    procedure :: start                   !! names the file that the next problems have places in
    procedure :: add_at                  !! adds a problem at a line and column of the file
    procedure :: add_at_byte             !! adds a problem at a byte of the file's text
    procedure :: add_in_file             !! adds a problem of the file with a place of its own kind
    procedure :: add                     !! adds a problem that has no place
    procedure :: append                  !! adds all problems of another list
    procedure :: count => problem_count  !! how many there are, those not written out included
    procedure :: place => place_of_line  !! where the problem of a line is
    procedure :: text => problem_text    !! one line a problem
    procedure, private :: add_placed
    procedure, private :: uncounted
  end type problem_list

contains

  !> Names the file, before problems with a place are added.
  pure subroutine start(self, file)
    class(problem_list), intent(inout) :: self  !! the list
    character(len=*), intent(in) :: file        !! name of the file as the user gave it

    self%file = file
  end subroutine start

  !> Adds `FILE: MESSAGE`, for a file where lines and columns mean nothing.
  pure subroutine add_in_file(self, message)
    class(problem_list), intent(inout) :: self  !! the list
    character(len=*), intent(in) :: message     !! place, what is wrong, found, expected

    call self%add_placed(': ', message, 0, 0)
  end subroutine add_in_file

  !> Adds `FILE:LINE:COLUMN: MESSAGE`.
  pure subroutine add_at(self, line, column, message)
    class(problem_list), intent(inout) :: self  !! the list
    integer, intent(in) :: line                 !! line, from 1
    integer, intent(in) :: column               !! column, from 1
    character(len=*), intent(in) :: message     !! what is wrong, found, expected

    call self%add_placed(':' // decimal_text(line) // ':' // decimal_text(column) // ': ', &
                         message, line, column)
  end subroutine add_at

  ! Adds a problem of the file, or counts it.
  pure subroutine add_placed(self, place, message, line, column)
    class(problem_list), intent(inout) :: self
    character(len=*), intent(in) :: place, message
    integer, intent(in) :: line, column
    character(len=len(self%last)) :: kind
    integer :: found, expected

    found = index(message, ' found ')
    expected = index(message, ', expected ', back=.true.)
    kind = message
    if (found > 0 .and. expected > found) kind = message(:found) // message(expected:)
    if (self%last == kind) then
      self%alike = self%alike + 1
    else
      if (self%alike > most_alike) call add_line(self, self%file, ': ', self%uncounted(), 0, 0)
      self%alike = 1
      self%last = kind
    end if
    self%placed = self%placed + 1
    if (self%alike > most_alike) return
    if (self%placed > most_placed) self%beyond = self%beyond + 1
    if (self%beyond == 0) call add_line(self, self%file, place, message, line, column)
  end subroutine add_placed

  ! Text with the number of problems like the last one that are not printed.
  pure function uncounted(self) result(text)
    class(problem_list), intent(in) :: self
    character(len=:), allocatable :: text

    text = 'and ' // decimal_text(self%alike - most_alike) // ' more like that'
  end function uncounted

  !> Adds a problem at a byte of the file's text.
  pure subroutine add_at_byte(self, text, byte, message)
    class(problem_list), intent(inout) :: self  !! the list
    character(len=*), intent(in) :: text        !! the whole file
    integer, intent(in) :: byte                 !! place, from 1
    character(len=*), intent(in) :: message     !! what is wrong, found, expected
    integer :: i, line, before

    line = 1
    before = 0
    if (self%placed < most_placed) then
      do i = 1, min(byte - 1, len(text))
        if (text(i:i) /= achar(10)) cycle
        line = line + 1
        before = i
      end do
    end if
    call self%add_at(line, byte - before, message)
  end subroutine add_at_byte

  !> Adds `MESSAGE`, made one printable line.
  pure subroutine add(self, message)
    class(problem_list), intent(inout) :: self  !! the list
    character(len=*), intent(in) :: message     !! what is wrong, found, expected

    call add_line(self, '', '', message, 0, 0)
    self%others = self%others + 1
  end subroutine add

  ! Adds a line, and where its problem is.
  pure subroutine add_line(self, file, after_file, message, line, column)
    class(problem_list), intent(inout) :: self
    character(len=*), intent(in) :: file, after_file, message
    integer, intent(in) :: line, column

    call self%lines%line(printable(file // after_file // message))
    call add_places(self, [problem_place(line, column, len(file), len(file // after_file))])
  end subroutine add_line

  ! Adds places of further lines.
  pure subroutine add_places(self, places)
    class(problem_list), intent(inout) :: self
    type(problem_place), intent(in) :: places(:)

    if (.not. allocated(self%places)) allocate (self%places(0))
    self%places = [self%places, places]
  end subroutine add_places

  !> Adds all problems of another list, each with the place that it has.
  pure subroutine append(self, other)
    class(problem_list), intent(inout) :: self  !! the list
    type(problem_list), intent(in) :: other     !! what follows

    call self%lines%append(other%text())
    if (allocated(other%places)) call add_places(self, other%places)
    if (other%alike > most_alike) call add_places(self, [problem_place()])
    if (other%beyond > 0) call add_places(self, [problem_place()])
    self%others = self%others + other%count()
    self%lacks_memory = self%lacks_memory .or. other%lacks_memory
  end subroutine append

  !> Where the problem of a line of `text` is; a line that only counts others has no place.
  pure type(problem_place) function place_of_line(self, number)
    class(problem_list), intent(in) :: self  !! the list
    integer, intent(in) :: number            !! of the line, from 1

    if (.not. allocated(self%places)) return
    if (number <= size(self%places)) place_of_line = self%places(number)
  end function place_of_line

  !> Number of problems; 0 means that the input is good.
  pure integer function problem_count(self)
    class(problem_list), intent(in) :: self  !! the list

    problem_count = self%placed + self%others
  end function problem_count

  !> All problems, one a line, each with its line end.
  pure function problem_text(self) result(text)
    class(problem_list), intent(in) :: self  !! the list
    character(len=:), allocatable :: text    !! the lines

    text = self%lines%text()
    if (self%alike > most_alike) &
      text = text // printable(self%file // ': ' // self%uncounted()) // new_line('a')
    if (self%beyond > 0) &
      text = text // printable(self%file // ': and ' // decimal_text(self%beyond) // &
                               ' more problems') // new_line('a')
  end function problem_text

  !> An integer as text without blanks.
  pure function short_decimal(value) result(text)
    integer, intent(in) :: value           !! any integer
    character(len=:), allocatable :: text  !! its decimal digits, with sign when negative

    text = long_decimal(int(value, int64))
  end function short_decimal

  !> The same for any integer of 64 bits.
  pure function long_decimal(value) result(text)
    integer(int64), intent(in) :: value    !! any integer
    character(len=:), allocatable :: text  !! its decimal digits, with sign when negative
    character(len=20) :: digits

    write (digits, '(i0)') value
    text = trim(digits)
  end function long_decimal

  !> A number as text without blanks: of seven digits, or as an edit descriptor has it.
  pure function real_text(value, form) result(text)
    real(real64), intent(in) :: value              !! any number
    character(len=*), intent(in), optional :: form  !! edit descriptor, of a width up to 32
    character(len=:), allocatable :: text          !! as `1.234567E+005` without `form`
    character(len=32) :: digits

    if (present(form)) then
      write (digits, '(' // form // ')') value
    else
      write (digits, '(es16.6e3)') value
    end if
    text = trim(adjustl(digits))
  end function real_text

end module asperity_problems
