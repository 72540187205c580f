!> Printable text of any bytes of a file or a command line, for a terminal.
module asperity_printable
  implicit none
  private

  public :: printable_text

contains

  !> Replaces each byte that is no part of printable UTF-8 by a question mark: control characters,
  !> broken sequences, and marks that change the direction of the text.
  pure function printable_text(text) result(shown)
    character(len=*), intent(in) :: text  !! text of any bytes
    character(len=len(text)) :: shown     !! printable text of the same length
    integer :: i, length

    i = 1
    do while (i <= len(text))
      length = letter_length(text(i:))
      if (length == 0) then
        shown(i:i) = '?'
        i = i + 1
      else
        shown(i:i + length - 1) = text(i:i + length - 1)
        i = i + length
      end if
    end do
  end function printable_text

  !> Bytes of the printable letter at the start of a text; 0 when there is none.
  pure integer function letter_length(text)
    character(len=*), intent(in) :: text
    ! Least code of each number of bytes: a longer encoding is not valid UTF-8.
    integer, parameter :: least(4) = [0, 128, 2048, 65536]
    integer :: code, first, i

    letter_length = 0
    first = iachar(text(1:1))
    select case (first)
    case (32:126)
      letter_length = 1
      return
    case (194:223)
      code = first - 192
      letter_length = 2
    case (224:239)
      code = first - 224
      letter_length = 3
    case (240:244)
      code = first - 240
      letter_length = 4
    case default
      return
    end select
    do i = 2, letter_length
      if (i > len(text)) then
        code = -1
      else if (iachar(text(i:i)) < 128 .or. iachar(text(i:i)) > 191) then
        code = -1
      else
        code = 64 * code + iachar(text(i:i)) - 128
      end if
      if (code < 0) exit
    end do
    if (code < 0 .or. code < least(letter_length) .or. is_hidden(code)) letter_length = 0
  end function letter_length

  !> Controls, halves of pairs, blanks other than the blank, marks of direction, private codes.
  pure logical function is_hidden(code)
    integer, intent(in) :: code

    select case (code)
    case (128:160, 173, 1564, 5760, 6158, 8192:8207, 8232:8239, 8287:8303, 12288, 55296:63743, &
          65024:65039, 65279, 65520:65535)
      is_hidden = .true.
    case default
      is_hidden = code > 917503
    end select
  end function is_hidden

end module asperity_printable
