!> Steps through the text of a namelist file: blanks and comments, names, words, quoted texts.
module asperity_namelist_cursor
  implicit none
  private

  public :: blanks
  public :: skip_blanks, skip_item, next_character, name_end, word_end, quote_end, line_end

  !> Characters that only separate.
  character(len=*), parameter :: blanks = ' ' // achar(9) // achar(10) // achar(13)

  character(len=*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ'
  character(len=*), parameter :: name_characters = letters // '0123456789_'
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
    if (first > len(text)) return
    if (scan(text(first:first), letters) == 0) return
    do while (name_end < len(text))
      if (scan(text(name_end + 1:name_end + 1), name_characters) == 0) exit
      name_end = name_end + 1
    end do
  end function name_end

  !> Last character of the word that begins at `first`; `first - 1` when none does.
  pure integer function word_end(text, first)
    character(len=*), intent(in) :: text  !! the whole file
    integer, intent(in) :: first          !! place where it begins

    word_end = first - 1
    do while (word_end < len(text))
      if (scan(text(word_end + 1:word_end + 1), word_ends) > 0) exit
      word_end = word_end + 1
    end do
  end function word_end

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

  !> Last character of the line, its line feed left out.
  pure integer function line_end(text, at)
    character(len=*), intent(in) :: text  !! the whole file
    integer, intent(in) :: at             !! place

    line_end = index(text(at:), achar(10)) + at - 2
    if (line_end < at - 1) line_end = len(text)
  end function line_end

end module asperity_namelist_cursor
