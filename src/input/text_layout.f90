!> Layout of the numbers of a height map written as text, found before one of them is read: what
!> separates cells, and how many lines and columns there are.
!>
!> The layout is refused where it can be read in two ways.
module asperity_text_layout
  use asperity_delimited_text, only: begins_comment, line_cells, line_reader
  use asperity_input_text, only: in_quotes
  use asperity_kinds, only: int64
  use asperity_problems, only: decimal_text, problem_list
  use asperity_text_header, only: head_length, is_numeric_line, is_surface_header, &
                                  read_header, text_header
  implicit none
  private

  public :: text_layout, find_layout

  !> Header and layout of the text.
  type, extends(text_header) :: text_layout
    integer(int64) :: lines = 0_int64           !! lines of numbers
    integer :: columns = 0                      !! cells of the first line of numbers
    integer(int64) :: like_second = 0_int64     !! lines of numbers with as many as the second
    integer :: second = 0                       !! cells of the second line of numbers
    integer :: gap_line = 0                     !! empty, or a comment, between numbers; 0: none
    !> Signs that separate the cells.
    type(line_cells) :: cells = line_cells(' ', '#%', '#', .false.)
  end type text_layout

  ! Kinds of gaps between two cells; the first four with their signs.
  integer, parameter :: a_blank = 1, a_tab = 2, a_comma = 3, a_semicolon = 4, a_decimal_comma = 5
  character(len=1), parameter :: tabulator = achar(9)
  character(len=*), parameter :: separators = ' ' // tabulator // ',;', digit_signs = '0123456789'
  character(len=*), parameter :: gap_names(4) = [character(len=11) :: 'a blank', 'a tabulator', &
    'a comma', 'a semicolon']

  !> Counts over the cells of the whole text.
  type :: cell_counts
    integer(int64) :: gaps(5) = 0_int64       ! of each kind
    integer :: line(5) = 0, column(5) = 0     ! the first of each
    integer(int64) :: ended(5) = 0_int64      ! lines that end with a separator
    logical :: point = .false.                ! there is a decimal point
    logical :: spaced_comma = .false.         ! blanks stand beside a comma
    logical :: two_commas = .false.           ! digits,digits,digits
    logical :: surely_decimal = .false.       ! no thousands: 0,25 or 12,3456
    integer :: least(0:1) = huge(0), most(0:1) = 0  ! digits of even and odd cells
    logical :: signed(0:1) = .false., zero_first(0:1) = .false.
    integer :: commas = 0                     ! between digits, in the first line of numbers
  end type cell_counts

contains

  !> Finds the layout. What is not understood of the header is noted.
  subroutine find_layout(file, layout, problems, notes)
    type(line_reader), intent(inout) :: file      !! file that is open
    type(text_layout), intent(out) :: layout       !! what was found
    type(problem_list), intent(inout) :: problems  !! what can be read in two ways
    type(problem_list), intent(inout) :: notes     !! names the same file
    type(cell_counts) :: counts
    character(len=:), allocatable :: head, text

    call file%begin_text(1)
    call file%take(head_length, head)
    call read_header(head, layout%text_header, text, problems, notes)
    if (layout%first_line == 0) return
    if (is_surface_header(text)) then
      call problems%add_at(layout%first_line, 1, 'found a surface: name it in &surfaces of a ' // &
                           'scene; expected a height map, with z for height if this is one')
    else if (.not. has_number(text)) then
      call problems%add_at(layout%first_line, 1, 'found ' // in_quotes(text) // ', expected ' // &
                           'heights, or the names x, y and z of columns')
    else if (any(layout%stated > 0) .and. &
             .not. all(layout%stated > 0 .and. layout%has_spacing())) then
      call problems%add_at(layout%first_line, 1, 'the header of a grid ends here, expected ' // &
                           'ncols, nrows and cellsize in it')
    end if
    if (problems%count() > 0) return
    call file%begin_text(layout%first_line)
    call count_cells(file, layout, counts, problems)
    call choose_separator(layout, counts, problems, notes)
  end subroutine find_layout

  ! Whether one of the cells of a line is a number, or a word for a height.
  pure logical function has_number(text)
    character(len=*), intent(in) :: text
    integer :: at

    has_number = is_numeric_line(text)
    do at = 2, len(text)
      if (has_number) exit
      if (scan(text(at - 1:at - 1), ' ,;' // achar(9)) == 1) has_number = is_numeric_line(text(at:))
    end do
  end function has_number

  ! Long: procedures share the cells of a line. Counts lines, cells and what stands between them.
  subroutine count_cells(file, layout, counts, problems)
    type(line_reader), intent(inout) :: file
    type(text_layout), intent(inout) :: layout
    type(cell_counts), intent(out) :: counts
    type(problem_list), intent(inout) :: problems
    integer :: line, first, last, at, length, cells, gap_line, digits_before
    logical :: is_fraction, zero_before, digit_before

    gap_line = 0
    do
      call file%find_line(first, last, line)
      if (first == 0) exit
      call cut_comment()
      cells = 0
      is_fraction = .false.
      at = first
      do
        length = verify(file%lines(at:last), separators) - 1
        if (length < 0) exit
        if (cells > 0) call take_gap(file%lines(at:at + length - 1), file%lines(at + length:last))
        at = at + length
        length = scan(file%lines(at:last), separators) - 1
        if (length < 0) length = last - at + 1
        call take_cell(file%lines(at:at + length - 1))
        at = at + length
      end do
      call end_line(file%lines(at:last))
    end do

  contains

    ! A per cent sign begins a comment at the beginning of a line alone.
    subroutine cut_comment()
      integer :: i

      i = verify(file%lines(first:last), separators)
      if (i > 0) then
        if (file%lines(first + i - 1:first + i - 1) == '%') last = first + i - 2
      end if
      i = first
      do while (index(file%lines(i:last), '#') > 0)
        i = i + index(file%lines(i:last), '#')
        if (begins_comment(file%lines, first, i - 1)) last = i - 2
      end do
    end subroutine cut_comment

    ! Counts the gap before a cell.
    subroutine take_gap(gap, rest)
      character(len=*), intent(in) :: gap, rest
      logical :: was_fraction

      was_fraction = is_fraction
      is_fraction = len(gap) == 1 .and. gap == ',' .and. digit_before .and. &
                    scan(rest(1:1), digit_signs) == 1
      if (is_fraction) then
        call count_gap(a_decimal_comma)
        if (was_fraction) counts%two_commas = .true.
      else if (index(gap, ';') > 0) then
        call count_gap(a_semicolon)
        if (index(gap, ',') > 0) call count_gap(a_comma)
      else if (index(gap, ',') > 0) then
        call count_gap(a_comma)
        if (verify(gap, ',') > 0) counts%spaced_comma = .true.
      else
        call count_gap(merge(a_tab, a_blank, index(gap, tabulator) > 0))
      end if
    end subroutine take_gap

    subroutine count_gap(gap_kind)
      integer, intent(in) :: gap_kind

      if (counts%gaps(gap_kind) == 0_int64) then
        counts%line(gap_kind) = line
        counts%column(gap_kind) = at - first + 1
      end if
      counts%gaps(gap_kind) = counts%gaps(gap_kind) + 1_int64
    end subroutine count_gap

    subroutine take_cell(cell)
      character(len=*), intent(in) :: cell
      integer :: begin, digit_count, side

      if (layout%lines == 1_int64) layout%second = layout%second + 1
      if (layout%lines == 0_int64) then
        if (is_fraction) counts%commas = counts%commas + 1
        if (.not. is_fraction) layout%columns = layout%columns + 1
      end if
      cells = cells + 1
      begin = verify(cell, '+-')
      if (begin == 0) begin = len(cell) + 1
      digit_count = verify(cell(begin:), digit_signs) - 1
      if (digit_count < 0) digit_count = len(cell) - begin + 1
      side = modulo(cells, 2)
      counts%least(side) = min(counts%least(side), digit_count)
      counts%most(side) = max(counts%most(side), digit_count)
      if (index(cell, '.') > 0) counts%point = .true.
      if (begin > 1) counts%signed(side) = .true.
      if (is_fraction .and. (digit_count /= 3 .or. digits_before > 3 .or. zero_before)) &
        counts%surely_decimal = .true.
      zero_before = index(cell(begin:), '0') == 1
      if (zero_before .and. digit_count > 1) counts%zero_first(side) = .true.
      digits_before = digit_count
      digit_before = scan(cell(len(cell):), digit_signs) == 1
    end subroutine take_cell

    ! Counts a line with what stands behind its last cell.
    subroutine end_line(gap)
      character(len=*), intent(in) :: gap
      integer :: i

      if (cells == 0 .and. scan(gap, ',;') == 0) then
        if (layout%lines > 0_int64 .and. gap_line == 0) gap_line = line
        return
      end if
      if (cells == 0) &
        call problems%add_at(line, 1, 'found a line of empty cells, expected heights, or NaN ' // &
                             'for a missing one')
      if (layout%gap_line == 0) layout%gap_line = gap_line
      layout%lines = layout%lines + 1_int64
      if (layout%lines > 1_int64 .and. cells == layout%second) &
        layout%like_second = layout%like_second + 1_int64
      do i = a_tab, a_semicolon
        if (index(gap, separators(i:i)) > 0) counts%ended(i) = counts%ended(i) + 1_int64
      end do
    end subroutine end_line

  end subroutine count_cells

  ! Chooses the separator of cells from what stands between them, unless there are two choices.
  subroutine choose_separator(layout, counts, problems, notes)
    type(text_layout), intent(inout) :: layout
    type(cell_counts), intent(in) :: counts
    type(problem_list), intent(inout) :: problems, notes
    logical :: used(5)
    integer :: i, first, second, separator

    used = counts%gaps > 0_int64
    first = findloc(used(:a_semicolon), .true., 1)
    if (used(a_decimal_comma) .and. count(used) == 2 .and. .not. used(a_comma) .and. &
        .not. (counts%point .or. counts%two_commas)) then
      layout%cells%decimal_comma = .true.
      layout%cells%separator = separators(first:first)
      if (.not. counts%surely_decimal) &
        call refuse_gaps([a_decimal_comma], &
                    'found a comma before three digits in every number with ' &
                    // 'one: thousands or decimals')
    else
      layout%columns = layout%columns + counts%commas
      used(a_comma) = used(a_comma) .or. used(a_decimal_comma)
      first = max(1, findloc(used(:a_semicolon), .true., 1))
      second = max(1, findloc(used(:a_semicolon), .true., 1, back=.true.))
      layout%cells%separator = separators(first:first)
      if (first /= second) then
        call refuse_gaps([first, second, a_decimal_comma], 'found ' // trim(gap_names(first)) // &
                    ' and ' // trim(gap_names(second)) // ' between cells')
      else if (used(a_decimal_comma) .and. .not. counts%point) then
        if (counts%spaced_comma) then
          call refuse_gaps([a_comma, a_decimal_comma], &
                      'found commas with and without a blank, and ' // &
                      'no point in the file: separators or decimals')
        else if (modulo(layout%columns, 2) == 0) then
          if (may_be_decimals(counts)) &
            call refuse_gaps([a_decimal_comma], &
                        'found commas alone, no point in the file, and ' // &
                        'second numbers of a pair that look like decimals of the first')
          if (problems%count() == 0) &
            call notes%add_at(counts%line(a_decimal_comma), counts%column(a_decimal_comma), &
                              'note: commas without a decimal point in the file are taken as ' // &
                              'separators of whole numbers')
        end if
      end if
    end if
    separator = index(separators, layout%cells%separator)
    do i = a_tab, a_semicolon
      if (counts%ended(i) == 0_int64 .or. (i == a_tab .and. i /= separator) .or. &
          (i == separator .and. counts%ended(i) == layout%lines)) cycle
      call problems%add_in_file('found ' // decimal_text(counts%ended(i)) // ' of ' // &
                                decimal_text(layout%lines) // ' lines that end with ' // &
                                trim(gap_names(i)) // ', expected all, between cells too, or none')
    end do

  contains

    ! Reports the problem at the kind of gap whose first occurrence comes last.
    subroutine refuse_gaps(kinds, found)
      integer, intent(in) :: kinds(:)
      character(len=*), intent(in) :: found
      integer :: k, place

      place = kinds(1)
      do k = 2, size(kinds)
        if (counts%line(kinds(k)) > counts%line(place) .or. &
            (counts%line(kinds(k)) == counts%line(place) .and. &
             counts%column(kinds(k)) > counts%column(place))) place = kinds(k)
      end do
      call problems%add_at(counts%line(place), counts%column(place), found // ', expected ' // &
                           'decimal points and one separator, for instance blanks')
    end subroutine refuse_gaps

  end subroutine choose_separator

  ! Whether of all whole numbers between commas every second one may be the decimals of the one
  ! before it: all have as many digits, without a sign. A tenth of decimals begins with 0, so of
  ! `many` numbers as long as the others, of which none does, none is a fraction: by chance that is
  ! so of 0.9**200 = 7e-10 of such files.
  pure logical function may_be_decimals(counts)
    type(cell_counts), intent(in) :: counts
    integer(int64), parameter :: many = 200_int64
    logical :: alike

    alike = all([counts%least(1), counts%most(1)] == counts%least(0)) .and. .not. counts%signed(1)
    may_be_decimals = counts%least(0) == counts%most(0) .and. .not. counts%signed(0) .and. &
      (.not. alike .or. counts%least(0) == 1 .or. counts%gaps(a_decimal_comma) < many)
    may_be_decimals = may_be_decimals .or. (counts%zero_first(0) .and. .not. counts%zero_first(1))
  end function may_be_decimals

end module asperity_text_layout
