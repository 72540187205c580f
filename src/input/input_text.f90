!> Text files that a user writes: read whole, and what their readers share.
module asperity_input_text
  use asperity_byte_reader, only: byte_reader
  use asperity_file_beginning, only: begin_file, first_control, plain_text
  use asperity_problems, only: not_enough_memory, problem_list
  implicit none
  private

  public :: blanks, read_text, check_text, line_end, lower_case, in_quotes, &
            without_blanks

  !> Characters that only separate.
  character(len=*), parameter :: blanks = ' ' // achar(9) // achar(10) // achar(13)

  ! A longer piece of the file is not repeated in a message.
  integer, parameter :: most_repeated = 40

contains

  !> Reads a whole file; a file that cannot be read is a problem at its first byte.
  recursive subroutine read_text(path, expected_kind, text, problems, opened)
    character(len=*), intent(in) :: path                !! the file; `-` is standard input
    character(len=*), intent(in) :: expected_kind       !! what it should be, for the message
    character(len=:), allocatable, intent(out) :: text  !! its lines, as `plain_text` has them
    type(problem_list), intent(inout) :: problems       !! names this file from now on
    class(byte_reader), intent(inout), optional :: opened  !! the file, at its first byte
    type(byte_reader) :: file
    integer :: before

    if (.not. present(opened)) then
      if (path == '-') then
        call file%open('/dev/stdin')
      else
        call file%open(path)
      end if
      call read_text(path, expected_kind, text, problems, file)
      call file%close()
      return
    end if
    call problems%start(path)
    before = problems%count()
    call begin_file(opened, expected_kind, problems)
    text = ''
    if (.not. allocated(opened%failure)) call opened%take_whole(text)
    if (.not. allocated(opened%failure)) then
      text = plain_text(text)
      return
    end if
    problems%lacks_memory = index(opened%failure, not_enough_memory) > 0
    if (problems%count() == before) &
      call problems%add_at(1, 1, opened%failure // ', expected ' // expected_kind)
    text = ''
  end subroutine read_text

  !> Reports the first byte that is no text.
  pure subroutine check_text(text, expected_kind, problems)
    character(len=*), intent(in) :: text           !! the whole file
    character(len=*), intent(in) :: expected_kind  !! what it should be, for the message
    type(problem_list), intent(inout) :: problems  !! gets a problem when there is such a byte
    integer :: place

    place = first_control(text)
    if (place > 0) call problems%add_at_byte(text, place, 'not a text file: found a control ' // &
                                             'character, expected ' // expected_kind)
  end subroutine check_text

  !> Last character of the line, its line feed left out; `at - 1` when nothing is there.
  pure integer function line_end(text, at)
    character(len=*), intent(in) :: text  !! the whole file
    integer, intent(in) :: at             !! place in the line, at most one behind the text

    line_end = index(text(at:), achar(10)) + at - 2
    if (line_end < at - 1) line_end = len(text)
  end function line_end

  !> The text with its ASCII capitals made small.
  pure function lower_case(text) result(small)
    character(len=*), intent(in) :: text  !! text of any bytes
    character(len=len(text)) :: small     !! the same in small letters
    integer :: i, code

    do i = 1, len(text)
      code = iachar(text(i:i))
      if (code >= iachar('A') .and. code <= iachar('Z')) code = code + 32
      small(i:i) = achar(code)
    end do
  end function lower_case

  !> Text without blanks and tabulators around it.
  pure function without_blanks(text) result(inner)
    character(len=*), intent(in) :: text    !! text with or without them
    character(len=:), allocatable :: inner  !! the same, or empty
    integer :: first

    first = verify(text, blanks)
    inner = ''
    if (first > 0) inner = text(first:verify(text, blanks, back=.true.))
  end function without_blanks

  !> A piece of the file for a message: between quotes, cut when long.
  pure function in_quotes(piece) result(text)
    character(len=*), intent(in) :: piece  !! the piece as it was found
    character(len=:), allocatable :: text  !! for instance `'1.2.3'`

    if (len(piece) <= most_repeated) then
      text = '''' // piece // ''''
    else
      text = '''' // piece(:most_repeated) // '...'''
    end if
  end function in_quotes

end module asperity_input_text
