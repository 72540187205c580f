!> Height maps as plain text: a matrix of heights, one profile a line, whose spacing is given beside
!> it, or x,y,z lines (`point_map`).
!>
!> Cells stand between blanks, tabulators, commas or semicolons: the sign of the first line. Lines
!> that begin with `#` or `%` are comments. Other text is refused: `asperity.read_map` in Python,
!> with SurfaceTopography, reads the formats of instruments. So is a matrix that could be read in
!> two ways: numbers of columns or rows beside heights, commas that may stand before decimals.
module asperity_text_map
  use asperity_delimited_text, only: cells_of, line_cells, line_reader, separator_of
  use asperity_height_map, only: digit_of, height_map, is_measured, longest_side, &
                                 make_room, map_request, no_power, read_height
  use asperity_input_text, only: blanks, in_quotes, lower_case, without_blanks
  use asperity_kinds, only: int64, real64
  use asperity_point_map, only: is_point_header, read_height_cell, read_point_map
  use asperity_problems, only: decimal_text, real_text
  use asperity_progress, only: progress_line
  implicit none
  private

  public :: is_text_map, read_text_map

  character(len=*), parameter :: comment_signs = '#%', line_ends = achar(10) // achar(13)
  character(len=*), parameter :: python_reads = '; asperity.read_map in Python reads the formats ' &
                                                // 'of instruments'

contains

  !> Whether a text in the place of a surface is a map: it has the names x, y, z, begins with a
  !> height, or is no surface. Four numbers are a surface without its header, unless a spacing is
  !> given.
  pure logical function is_text_map(head, has_spacing)
    character(len=*), intent(in) :: head  !! beginning of the file, or all of it
    logical, intent(in) :: has_spacing    !! a spacing is given
    character(len=:), allocatable :: line
    type(line_cells) :: cells
    integer :: at, length

    at = 1
    line = ''
    do while (at <= len(head) .and. (line == '' .or. scan(line, comment_signs) == 1))
      length = scan(head(at:) // line_ends, line_ends) - 1
      line = without_blanks(head(at:at + length - 1))
      at = at + length + 1
    end do
    cells = cells_of(line, separator_of(line), .false.)
    if (begins_with_height(line)) then
      is_text_map = has_spacing .or. cells%cell_count /= 4
    else
      ! The header of a surface has no blanks alone between its names.
      is_text_map = (is_point_header(line) .and. scan(line, 'zZ') > 0) .or. (line /= '' .and. &
                    separator_of(line) == ' ' .and. index(lower_case(line), 'height') == 0)
    end if
  end function is_text_map

  !> Reads a map, unless there is no memory for it.
  subroutine read_text_map(file, request, map)
    type(line_reader), intent(inout) :: file   !! open; gets what is wrong
    type(map_request), intent(in) :: request   !! what is given beside the map
    type(height_map), intent(inout) :: map     !! gets the pixels
    character(len=:), allocatable :: line

    file%cells = line_cells(' ', comment_signs, '#', .false.)
    call file%begin_text()
    call file%next_cells()
    if (file%cells%cell_count == 0) then
      if (.not. allocated(file%failure)) &
        call file%problems%add_at(1, 1, 'found no pixel, expected a matrix of heights')
      return
    end if
    if (scan(file%lines(:file%cells%start - 1), comment_signs) > 0) &
      call map%notes%add_at(1, 1, 'note: comments are not read: spacing and heights are taken ' // &
                            'in one unit')
    line = file%lines(file%cells%first(1):file%cells%last(file%cells%cell_count))
    file%cells%separator = separator_of(line)
    file%cells%keep_empty = file%cells%separator /= ' '
    if (is_point_header(line)) then
      call read_point_map(file, request, map)
    else if (.not. begins_with_height(line)) then
      call file%refuse_cell(1, 'found ' // in_quotes(line) // ', expected a matrix of heights, ' &
                            // 'or x,y,z lines below these names' // python_reads)
    else if (.not. all(request%pixel_spacing > 0.0_real64)) then
      call file%refuse_cell(1, 'a matrix of heights has no spacing: found no ' // &
           request%option // ', expected one, or x,y,z lines below these names' // python_reads)
    else
      call read_matrix(file, request, map)
    end if
  end subroutine read_text_map

  ! Whether the first cell of a line is a height, or empty before another cell.
  pure logical function begins_with_height(line)
    character(len=*), intent(in) :: line
    real(real64) :: height
    integer :: power

    power = no_power
    call read_height(line(:scan(line // ' ', blanks // ',;') - 1), height, begins_with_height, &
                     power)
    begins_with_height = begins_with_height .or. scan(line, ',;') == 1
  end function begins_with_height

  ! Reads the profiles from the line at hand on.
  subroutine read_matrix(file, request, map)
    type(line_reader), intent(inout) :: file
    type(map_request), intent(in) :: request
    type(height_map), intent(inout) :: map
    type(progress_line) :: shown
    integer(int64) :: rows
    integer :: first_line, j, line, power
    logical :: may_be_pairs

    map%pixel_spacing = request%pixel_spacing
    map%own_spacing = .false.
    first_line = file%cells%line
    rows = 0_int64
    do while (file%cells%cell_count > 0)
      rows = rows + 1_int64
      call file%next_cells()
    end do
    if (allocated(file%failure)) return
    call file%begin_text()
    call file%next_cells()
    map%columns = pixel_count(file%cells)
    if (rows > longest_side) then
      call file%problems%add_in_file('found ' // decimal_text(rows) // ' profiles, expected at ' &
                                     // 'most ' // decimal_text(longest_side))
      return
    end if
    map%rows = int(rows)
    call make_room(map, file%lack)
    if (allocated(file%lack)) return
    power = no_power
    may_be_pairs = file%cells%separator == ',' .and. modulo(map%columns, 2) == 0
    call shown%begin(request%progress, 'profiles read', map%rows, 0)
    do j = 1, map%rows
      call read_profile(file, map%height(:, j), power, may_be_pairs)
      ! Where the first profile is none the file is of another kind: that is one mistake.
      if (j == 1 .and. file%problems%count() > 0) return
      call shown%reach(j)
      line = file%cells%line + 1
      call file%next_cells()
      if (j < map%rows .and. file%cells%line > line) &
        call file%problems%add_at(line, 1, 'found an empty line or a comment between ' // &
             'profiles, expected one block: take the line out, or make a file of each block')
    end do
    call shown%finish()
    map%digit = digit_of(power)
    call file%problems%shorten(map%rows)
    if (file%problems%count() > 0) return
    if (may_be_pairs) &
      call file%problems%add_at(first_line, 1, 'found commas and no decimal point in the file: ' &
           // 'separators or decimals, expected decimal points and one separator, for instance ' &
           // 'blanks')
    if (begins_with_places(map%height(1, :), map%height(2, :)) .or. &
        begins_with_places(map%height(2, :), map%height(1, :))) &
      call file%problems%add_at(first_line, 1, 'found places on a grid in the first two columns, ' &
           // 'expected heights, or the names x,y,z above them without ' // request%option)
    if (min(map%columns, map%rows) < 4) return
    call check_axis(file, map, first_line, 'line', map%height(:, 1), map%height(:, 2))
    call check_axis(file, map, first_line, 'column', map%height(1, :), map%height(2, :))
  end subroutine read_matrix

  ! Cells of a line without the empty one behind a separator at its end.
  pure integer function pixel_count(cells)
    type(line_cells), intent(in) :: cells

    pixel_count = cells%cell_count
    if (cells%last(pixel_count) < cells%first(pixel_count)) pixel_count = pixel_count - 1
  end function pixel_count

  ! Reads the line at hand up to its first fault.
  subroutine read_profile(file, heights, power, may_be_pairs)
    type(line_reader), intent(inout) :: file
    real(real64), intent(out) :: heights(:)
    integer, intent(inout) :: power           ! of the last digit of the heights
    logical, intent(inout) :: may_be_pairs    ! second cells may be decimals of the first ones
    integer :: i
    logical :: good

    heights = 0.0_real64
    associate (cells => file%cells)
      do i = 1, min(pixel_count(cells), size(heights))
        call read_height_cell(file, i, heights(i), good, power)
        if (.not. good) return
      end do
      if (pixel_count(cells) /= size(heights)) &
        call file%problems%add_at(cells%line, cells%last(pixel_count(cells)) - cells%start + 2, &
             'found ' // decimal_text(pixel_count(cells)) // ' pixels, expected ' // &
             decimal_text(size(heights)) // ' as in the first profile')
      if (may_be_pairs) then
        do i = 1, cells%cell_count
          if (scan(file%cell_text(i), '.eE') > 0 .or. &
              (modulo(i, 2) == 0 .and. scan(file%cell_text(i), '+-') == 1)) may_be_pairs = .false.
        end do
      end if
    end associate
  end subroutine read_profile

  ! A first line, or column, of equal steps over heights that have none numbers the columns or rows
  ! where it is 0, 1, 2, ... or 1, 2, 3, ...; otherwise it may be their places.
  subroutine check_axis(file, map, line, name, axis, next)
    type(line_reader), intent(inout) :: file
    type(height_map), intent(inout) :: map
    integer, intent(in) :: line              ! the first of the matrix
    character(len=*), intent(in) :: name
    real(real64), intent(in) :: axis(:), next(:)
    character(len=:), allocatable :: found

    if (.not. has_equal_steps(axis(2:)) .or. has_equal_steps(next(2:))) return
    found = 'equal steps in the first ' // name // ' (' // real_text(axis(2), 'f0.3') // ', ' // &
            real_text(axis(3), 'f0.3') // ', ...)'
    if (abs(axis(3) - axis(2) - 1.0_real64) <= 0.0_real64 .and. &
        any(abs(axis(2) - [0, 1, 2]) <= 0.0_real64)) then
      call file%problems%add_at(line, 1, 'found ' // found // ', which are numbers of ' // &
           'columns or rows, expected heights: take them out, in pandas with ' // &
           'to_csv(header=False, index=False)')
    else
      call map%notes%add_at(line, 1, 'note: ' // found // ' are taken as heights: take ' // &
                            'them out if they are places or numbers')
    end if
  end subroutine check_axis

  ! Whether two columns begin with the places of a grid: equal steps of the first one at one value
  ! of the other, and the same steps at the next value.
  pure logical function begins_with_places(fast, slow)
    real(real64), intent(in) :: fast(:), slow(:)
    integer :: turn

    turn = findloc(abs(slow - slow(1)) > 0.0_real64, .true., 1) - 1
    begins_with_places = turn > 1 .and. size(fast) > turn + 1
    if (begins_with_places) &
      begins_with_places = has_equal_steps(fast(:turn)) .and. &
        all(abs(fast(turn + 1:turn + 2) - fast(:2)) <= 0.0_real64) .and. &
        abs(slow(turn + 2) - slow(turn + 1)) <= 0.0_real64
  end function begins_with_places

  ! Whether numbers differ by one step, but for what their digits leave out.
  pure logical function has_equal_steps(numbers)
    real(real64), intent(in) :: numbers(:)
    ! Rounding of numbers with 15 digits, added up over a profile (derived).
    real(real64), parameter :: same = 1.0e-12_real64
    real(real64) :: step
    integer :: i

    has_equal_steps = all(is_measured(numbers))
    if (.not. has_equal_steps) return
    step = (numbers(size(numbers)) - numbers(1)) / (size(numbers) - 1)
    has_equal_steps = abs(step) > 0.0_real64 .and. &
      all(abs(numbers - numbers(1) - step * [(i, i=0, size(numbers) - 1)]) <= &
          same * maxval(abs(numbers)))
  end function has_equal_steps

end module asperity_text_map
