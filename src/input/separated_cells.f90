!> Lines of values between separators: cut into cells, without the blanks around them.
!>
!> Blank lines, and comments, which begin with `#`, are stepped over.
module asperity_separated_cells
  use asperity_input_text, only: blanks, line_end
  implicit none
  private

  public :: line_cells, cut_line, separator_of, skip_to_line

  !> One line, cut at its separators.
  type :: line_cells
    character(len=1) :: separator = ','         !! comma, semicolon or tabulator
    integer :: count = 0                        !! cells found, those without a place included
    integer, allocatable :: first(:), last(:)   !! places of so many cells at most in the text
  end type line_cells

contains

  !> What separates the cells of a line: semicolons, else tabulators, else commas.
  pure character(len=1) function separator_of(line)
    character(len=*), intent(in) :: line  !! a header, where no number has a decimal comma

    separator_of = ','
    if (index(line, achar(9)) > 0 .and. index(line, ',') == 0) separator_of = achar(9)
    if (index(line, ';') > 0) separator_of = ';'
  end function separator_of

  !> Cuts the line at `first` at its separators; `first` is left at the next line.
  pure subroutine cut_line(text, first, cells)
    character(len=*), intent(in) :: text       !! the whole file
    integer, intent(inout) :: first            !! place where the line begins
    type(line_cells), intent(inout) :: cells   !! with separator and room for places
    integer :: at, from

    cells%count = 0
    from = first
    do at = first, len(text)
      if (text(at:at) == achar(10)) exit
      if (text(at:at) /= cells%separator) cycle
      call add_cell(text, from, at - 1, cells)
      from = at + 1
    end do
    call add_cell(text, from, at - 1, cells)
    first = at + 1
  end subroutine cut_line

  ! Adds the cell `from:to`, without the blanks around it.
  pure subroutine add_cell(text, from, to, cells)
    character(len=*), intent(in) :: text
    integer, intent(in) :: from, to
    type(line_cells), intent(inout) :: cells

    cells%count = cells%count + 1
    if (cells%count > size(cells%first)) return
    cells%first(cells%count) = from
    cells%last(cells%count) = to
    if (to < from) return
    ! As a rule there are none.
    if (iachar(text(from:from)) <= iachar(' ')) &
      cells%first(cells%count) = from + max(0, verify(text(from:to), blanks) - 1)
    if (iachar(text(to:to)) <= iachar(' ')) &
      cells%last(cells%count) = from + verify(text(from:to), blanks, back=.true.) - 1
  end subroutine add_cell

  !> Steps over blank lines and comments; `first` is left at the first byte of a line, or behind
  !> the text.
  pure subroutine skip_to_line(text, first, line)
    character(len=*), intent(in) :: text  !! the whole file
    integer, intent(inout) :: first       !! first byte of a line
    integer, intent(inout) :: line        !! its number
    integer :: last, at

    do while (first <= len(text))
      if (verify(text(first:first), blanks // '#') > 0) return
      last = line_end(text, first)
      at = verify(text(first:last), blanks)
      if (at > 0) then
        if (text(first + at - 1:first + at - 1) /= '#') return
      end if
      if (last < len(text)) line = line + 1
      first = last + 2
    end do
  end subroutine skip_to_line

end module asperity_separated_cells
