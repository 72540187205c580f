!> Problems found in a file or a command line, as values that the program prints at its end.
module asperity_problems
  use asperity_kinds, only: int64, real64
  use asperity_printable, only: printable_text
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: problem_list, problem_place, decimal_text, not_enough_memory, real_text

  !> Beginning of a message when memory is short.
  character(len=*), parameter :: not_enough_memory = 'not enough memory'

  !> An integer as text without blanks.
  interface decimal_text
    module procedure :: short_decimal, long_decimal
  end interface decimal_text

  !> A number as text without blanks.
  interface real_text
    module procedure :: plain_real, formed_real
  end interface real_text

  ! Largest numbers of problems of a file, and of successive equal problems, that are printed;
  ! others are counted. They limit the output for a file of another kind, or with a fault in every
  ! line.
  integer, parameter :: most_placed = 5000, most_alike = 20

  !> Place of a problem.
  type :: problem_place
    integer :: line = 0, column = 0  !! of the file, from 1; 0: none
    integer :: file_length = 0  !! length of the file's name at its beginning; 0: none
    integer :: prefix = 0       !! number of characters before the message
  end type problem_place

  !> All problems of one input, in the order found.
  type :: problem_list
    private
    type(text_buffer) :: lines
    type(problem_place), allocatable :: places(:)  ! place of each line
    character(len=:), allocatable :: file  ! file of the places of `add_at`
    integer :: placed = 0, others = 0      ! numbers of problems with a place, and without
    integer :: beyond = 0                  ! number of problems after `most_placed`
    integer :: alike = 0                   ! number of successive problems like the last one
    character(len=80) :: last = ''         ! the last problem, without the text found
    !> Memory was short while the input was read: its problems are unknown.
    logical, public :: lacks_memory = .false.
  contains
    procedure :: start => start_file     !! sets the file of the places of the next problems
    procedure :: add_at                  !! adds a problem at a line and column of the file
    procedure :: add_at_byte             !! adds a problem at a byte of the file's text
    procedure :: add_in_file             !! adds a problem of the file with a place of its own kind
    procedure :: add => add_problem      !! adds a problem without a place
    procedure :: append => append_list   !! adds all problems of another list
    procedure :: clear => clear_list     !! removes all problems
    procedure :: count => problem_count  !! number of problems, including those not printed
    procedure :: shorten => shorten_list !! keeps two problems of a file of another kind
    procedure :: place => place_of_line  !! place of the problem of a line
    procedure :: text => problem_text    !! text with one line for each problem
    procedure :: write_text              !! the same, where several threads write
    procedure, private :: count_text
  end type problem_list

contains

  !> Sets the file, before problems with a place are added.
  pure subroutine start_file(self, file)
    class(problem_list), intent(inout) :: self  !! list of problems
    character(len=*), intent(in) :: file        !! name of the file as the user gave it

    self%file = file
  end subroutine start_file

  !> Adds `FILE: MESSAGE`, for a file without lines and columns.
  pure subroutine add_in_file(self, message)
    class(problem_list), intent(inout) :: self  !! list of problems
    character(len=*), intent(in) :: message     !! place, fault, text found and expected

    call self%add_at(0, 0, message)
  end subroutine add_in_file

  !> Adds `FILE:LINE:COLUMN: MESSAGE`, or counts it.
  pure subroutine add_at(self, line, column, message)
    class(problem_list), intent(inout) :: self  !! list of problems
    integer, intent(in) :: line                 !! line of the problem, from 1; 0: it has none
    integer, intent(in) :: column               !! column of the problem, from 1
    character(len=*), intent(in) :: message     !! fault, text found and expected
    character(len=len(self%last)) :: message_kind
    integer :: found, expected

    found = index(message, ' found ')
    expected = index(message, ', expected ', back=.true.)
    message_kind = message
    if (found > 0 .and. expected > found) message_kind = message(:found) // message(expected:)
    if (self%last == message_kind) then
      self%alike = self%alike + 1
    else
      if (self%alike > most_alike) call add_line(self, .true., self%count_text(), 0, 0)
      self%alike = 1
      self%last = message_kind
    end if
    self%placed = self%placed + 1
    if (self%alike > most_alike) return
    if (self%placed > most_placed) self%beyond = self%beyond + 1
    if (self%beyond == 0) call add_line(self, .true., message, line, column)
  end subroutine add_at

  ! Text with the number of problems like the last one that are not printed.
  pure function count_text(self) result(text)
    class(problem_list), intent(in) :: self
    character(len=:), allocatable :: text

    text = 'and ' // decimal_text(self%alike - most_alike) // ' more like that'
  end function count_text

  !> Keeps the first two of more than three problems that stand in more than half of the lines of a
  !> file, which is of another kind then; the others are counted.
  pure subroutine shorten_list(self, lines)
    class(problem_list), intent(inout) :: self  !! problems of one file
    integer, intent(in) :: lines                !! number of its lines
    character(len=:), allocatable :: text
    type(problem_place) :: third
    integer :: i, bad, first, second

    if (.not. allocated(self%places)) return
    if (size(self%places) < 4) return
    associate (line => self%places%line)
      bad = count([(all(line(:i - 1) /= line(i)), i=1, size(line))]) + &
            max(0, self%alike - most_alike)
    end associate
    if (bad <= lines / 2) return
    text = self%lines%text()
    first = index(text, new_line('a'))
    second = first + index(text(first + 1:), new_line('a'))
    self%lines = text_buffer()
    call self%lines%append(text(:second))
    third = self%places(3)
    self%places = self%places(:2)
    call add_line(self, .true., 'and ' // decimal_text(self%count() - 2) // ' more problems, ' // &
                  'in most of its lines: is it a file of another kind?', third%line, third%column)
    self%others = self%count()
    self%placed = 0
    self%beyond = 0
    self%alike = 0
    self%last = ''
  end subroutine shorten_list

  !> Adds a problem at a byte of the file's text.
  pure subroutine add_at_byte(self, text, byte, message)
    class(problem_list), intent(inout) :: self  !! list of problems
    character(len=*), intent(in) :: text        !! text of the whole file
    integer, intent(in) :: byte                 !! position of the byte, from 1
    character(len=*), intent(in) :: message     !! fault, text found and expected
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

  !> Adds `MESSAGE` as one printable line.
  pure subroutine add_problem(self, message)
    class(problem_list), intent(inout) :: self  !! list of problems
    character(len=*), intent(in) :: message     !! fault, text found and expected

    call add_line(self, .false., message, 0, 0)
    self%others = self%others + 1
  end subroutine add_problem

  ! Adds a line, with the name of the file and a place in it that is not 0, and its place.
  pure subroutine add_line(self, is_of_file, message, line, column)
    class(problem_list), intent(inout) :: self
    logical, intent(in) :: is_of_file
    character(len=*), intent(in) :: message
    integer, intent(in) :: line, column
    type(problem_place) :: place
    character(len=:), allocatable :: head

    head = ''
    if (is_of_file) head = self%file // ': '
    if (line > 0) &
      head = self%file // ':' // decimal_text(line) // ':' // decimal_text(column) // ': '
    place = problem_place(line=line, column=column, prefix=len(head))
    if (is_of_file) place%file_length = len(self%file)
    call self%lines%line(printable_text(head // message))
    call add_places(self, [place])
  end subroutine add_line

  ! Adds places of further lines.
  pure subroutine add_places(self, places)
    class(problem_list), intent(inout) :: self
    type(problem_place), intent(in) :: places(:)

    if (.not. allocated(self%places)) allocate (self%places(0))
    self%places = [self%places, places]
  end subroutine add_places

  !> Adds all problems of another list, each with its place.
  pure subroutine append_list(self, other)
    class(problem_list), intent(inout) :: self  !! list of problems
    type(problem_list), intent(in) :: other     !! list to be appended

    call self%lines%append(other%text())
    if (allocated(other%places)) call add_places(self, other%places)
    if (other%alike > most_alike) call add_places(self, [problem_place()])
    if (other%beyond > 0) call add_places(self, [problem_place()])
    self%others = self%others + other%count()
    self%lacks_memory = self%lacks_memory .or. other%lacks_memory
  end subroutine append_list

  !> Removes all problems.
  subroutine clear_list(self)
    class(problem_list), intent(out) :: self  !! list of problems, empty on exit
  end subroutine clear_list

  !> Place of the problem of a line of `text`; a line that only counts others has no place.
  pure type(problem_place) function place_of_line(self, number)
    class(problem_list), intent(in) :: self  !! list of problems
    integer, intent(in) :: number            !! number of the line, from 1

    if (.not. allocated(self%places)) return
    if (number <= size(self%places)) place_of_line = self%places(number)
  end function place_of_line

  !> Number of problems; 0: the input is correct.
  pure integer function problem_count(self)
    class(problem_list), intent(in) :: self  !! list of problems

    problem_count = self%placed + self%others
  end function problem_count

  !> Text of all problems, one line for each, with line ends.
  pure function problem_text(self) result(text)
    class(problem_list), intent(in) :: self  !! list of problems
    character(len=:), allocatable :: text    !! lines with their ends

    call self%write_text(text)
  end function problem_text

  !> Writes the text of all problems, one line for each, with line ends.
  pure subroutine write_text(self, text)
    class(problem_list), intent(in) :: self              !! list of problems
    character(len=:), allocatable, intent(out) :: text  !! lines with their ends

    text = ''
    if (allocated(self%lines%store)) text = self%lines%store(:self%lines%used)
    if (self%alike > most_alike) &
      text = text // printable_text(self%file // ': ' // self%count_text()) // new_line('a')
    if (self%beyond > 0) &
      text = text // printable_text(self%file // ': and ' // decimal_text(self%beyond) // &
                               ' more problems') // new_line('a')
  end subroutine write_text

  ! Length of an integer as text. (gfortran wants it before its use in a length.)
  pure integer function long_length(value) result(length)
    integer(int64), intent(in) :: value
    character(len=20) :: written

    write (written, '(i0)') value
    length = len_trim(written)
  end function long_length

  !> An integer as text without blanks.
  !>
  !> The length of such a result is computed, not deferred: gfortran keeps the deferred length of a
  !> function in static memory, one for all threads.
  pure function short_decimal(value) result(text)
    integer, intent(in) :: value                          !! integer of any size
    character(len=long_length(int(value, int64))) :: text  !! its digits, with sign when negative

    write (text, '(i0)') value
  end function short_decimal

  !> An integer of 64 bits as text without blanks.
  pure function long_decimal(value) result(text)
    integer(int64), intent(in) :: value          !! integer of any size
    character(len=long_length(value)) :: text    !! its digits, with sign when negative

    write (text, '(i0)') value
  end function long_decimal

  ! A number at the left of a field of blanks.
  pure character(len=32) function written_real(value, form) result(written)
    real(real64), intent(in) :: value
    character(len=*), intent(in) :: form

    write (written, '(' // form // ')') value
    written = adjustl(written)
    ! Stars, or an exponent of three digits without its letter: as many digits in a wider form.
    if (scan(written, '*') == 0 .and. &
        (scan(written(2:), '+-') == 0 .or. scan(written, 'E') > 0)) return
    write (written, '(es25.' // form(index(form, '.') + 1:index(form, '.') + 1) // 'e3)') value
    written = adjustl(written)
  end function written_real

  !> A number as text of seven digits, for instance `1.234567E+005`, without blanks.
  pure function plain_real(value) result(text)
    real(real64), intent(in) :: value                      !! number of any size
    character(len=len_trim(written_real(value, 'es16.6e3'))) :: text

    text = written_real(value, 'es16.6e3')
  end function plain_real

  !> A number in the form of an edit descriptor, without blanks.
  pure function formed_real(value, form) result(text)
    real(real64), intent(in) :: value                      !! number of any size
    character(len=*), intent(in) :: form                   !! edit descriptor, of a width up to 32
    character(len=len_trim(written_real(value, form))) :: text

    text = written_real(value, form)
  end function formed_real

end module asperity_problems
