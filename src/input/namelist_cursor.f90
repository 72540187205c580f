!> Steps through the text of a namelist file: blanks and comments, names, words, quoted texts.
module asperity_namelist_cursor
  use asperity_input_text, only: blanks, line_end
  implicit none
  private

  public :: skip_blanks, skip_item, next_character, name_end, word_end, digits_end, quote_end

  character(len=*), parameter :: digits = '0123456789'
  character(len=*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ'
  character(len=*), parameter :: word_ends = blanks // ',/=!&''"'

contains

  !> Steps over blanks, line ends and comments.
  pure subroutine skip_blanks(text, at)
    character(len=*), intent(in) :: text  !! the whole file
    integer, intent(inout) :: at          !! place; left behind what is stepped over

    do while (at <= len(text))
      if (text(at:at) == '!') then
        at = line_end(text, at) + 1
      else if (scan(text(at:at), blanks) > 0) then
        at = at + 1
      else
        return
      end if
    end do
  end subroutine skip_blanks

  !> Steps over one character or word or quoted text that has no place where it stands.
  pure subroutine skip_item(text, at)
    character(len=*), intent(in) :: text  !! the whole file
    integer, intent(inout) :: at          !! place; left behind what is stepped over
    integer :: last

    if (scan(text(at:at), '''"') > 0) then
      last = quote_end(text, at)
      at = merge(last + 2, line_end(text, at) + 1, last >= at)
    else
      at = max(at, word_end(text, at)) + 1
    end if
  end subroutine skip_item

  !> The character at a place, or a blank behind the end.
  pure character(len=1) function next_character(text, at)
    character(len=*), intent(in) :: text  !! the whole file
    integer, intent(in) :: at             !! place

    next_character = ' '
    if (at <= len(text)) next_character = text(at:at)
  end function next_character

  !> Last letter of the name that begins at `first`; `first - 1` when none does.
  pure integer function name_end(text, first)
    character(len=*), intent(in) :: text  !! the whole file
    integer, intent(in) :: first          !! place where it begins

    name_end = first - 1
    if (scan(next_character(text, first), letters) > 0) &
      name_end = before(text, first, verify(text(first:), letters // digits // '_'))
  end function name_end

  !> Last character of the word that begins at `first`; `first - 1` when none does.
  pure integer function word_end(text, first)
    character(len=*), intent(in) :: text  !! the whole file
    integer, intent(in) :: first          !! place where it begins

    word_end = before(text, first, scan(text(first:), word_ends))
  end function word_end

  !> Last of the digits that begin at `first`; `first - 1` when none do.
  pure integer function digits_end(text, first)
    character(len=*), intent(in) :: text  !! the whole file
    integer, intent(in) :: first          !! place where they begin

    digits_end = before(text, first, verify(text(first:), digits))
  end function digits_end

  !> Last character inside the quotes that open at `first`; `first - 1` when the line ends before.
  pure integer function quote_end(text, first)
    character(len=*), intent(in) :: text  !! the whole file
    integer, intent(in) :: first          !! place where it begins
    integer :: at

    quote_end = first - 1
    at = first + 1
    do while (at <= len(text))
      if (text(at:at) == achar(10)) return
      if (text(at:at) == text(first:first)) then
        if (next_character(text, at + 1) /= text(first:first)) then
          quote_end = at - 1
          return
        end if
        at = at + 1
      end if
      at = at + 1
    end do
  end function quote_end

  ! The place before the `found`-th character from `first` on; the last of the text when 0.
  pure integer function before(text, first, found)
    character(len=*), intent(in) :: text
    integer, intent(in) :: first, found

    before = merge(first + found - 2, len(text), found > 0)
  end function before

end module asperity_namelist_cursor
