!> Height maps as plain text: a matrix of heights, or `x,y,z` lines of a full regular grid.
!>
!> The layout is found before a number is read: lines, columns, separator and units. It is refused
!> where it can be read in two ways.
module asperity_text_map
  use asperity_delimited_text, only: begins_comment, line_cells, line_reader
  use asperity_height_map, only: change_unit, digit_of, height_map, highest, is_length, &
                                 is_measured, known_units, length_units, make_room, map_request, &
                                 most_samples, no_height, no_power, read_height, unit_number, &
                                 unit_ratio
  use asperity_input_text, only: in_quotes
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text, problem_list, real_text
  use asperity_progress, only: progress_line
  use asperity_text_header, only: head_length, is_numeric_line, is_surface_header, read_header, &
                                  text_header
  implicit none
  private

  public :: read_text_map

  ! Header and layout of the text.
  type, extends(text_header) :: text_layout
    integer(int64) :: lines = 0_int64           !! lines of numbers
    integer :: columns = 0                      !! cells of the first line of numbers
    integer(int64) :: like_second = 0_int64     !! lines of numbers with as many as the second
    integer :: second = 0                       !! cells of the second line of numbers
    integer :: gap_line = 0                     !! empty, or a comment, between numbers; 0: none
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

  ! Coordinates nearer than this, relative to their size, are written for the same column or row.
  real(real64), parameter :: same = 1.0e-12_real64
  ! A coordinate may be off its place by so much of the spacing: it was written with few digits.
  real(real64), parameter :: most_off = 0.1_real64
  character(len=*), parameter :: expected_cell = &
    'a height of at most 1e30, or NaN or BAD for a missing one'

  ! The least and the largest coordinate, and how many pixels share the least.
  type :: extent
    real(real64) :: first = huge(1.0_real64), last = -huge(1.0_real64)
    integer(int64) :: sharing = 0_int64
  end type extent

contains

  !> Reads a map, unless there is no memory for it.
  subroutine read_text_map(file, request, map)
    type(line_reader), intent(inout) :: file   !! open; gets what is wrong
    type(map_request), intent(in) :: request   !! what is given beside the map
    type(height_map), intent(inout) :: map     !! gets the pixels
    type(text_layout) :: layout
    logical :: given, has_own, points

    call find_layout(file, layout, map%notes)
    if (file%problems%count() > 0) return
    if (layout%first_line == 0) then
      call file%problems%add_at(1, 1, 'found no pixel, expected a matrix of heights')
      return
    end if
    has_own = layout%names_line > 0 .or. layout%has_spacing()
    map%pixel_spacing = request%pixel_spacing
    given = all(map%pixel_spacing > 0.0_real64) .and. .not. (request%shared .and. has_own)
    if (given .and. layout%names_line > 0) then
      call file%problems%add_at(layout%names_line, 1, request%option // ' given, but x,y,z ' // &
                                'lines have their own, expected none')
    else if (given .and. all(layout%pixel_spacing > 0.0_real64) .and. &
             any(abs(map%pixel_spacing - layout%pixel_spacing) > &
                 1.0e-6_real64 * map%pixel_spacing)) then
      call file%problems%add_in_file(request%option // ' contradicts the spacing of the map in ' &
                                     // 'its header, expected the same, or none')
    end if
    if (file%problems%count() > 0) return
    points = .not. given .and. (layout%names_line > 0 .or. .not. has_own)
    if (.not. points) then
      call read_matrix(file, layout, request%progress, map)
      if (file%is_refused()) return
      if (.not. given) then
        map%pixel_spacing = layout%pixel_spacing
        if (.not. all(map%pixel_spacing > 0.0_real64)) &
          map%pixel_spacing = layout%extent / real([map%columns, map%rows], real64)
      else if (all(layout%stated == 0) .and. is_list_of_points(map%height)) then
        if (.not. request%shared) then
          call file%problems%add_at(layout%first_line, 1, request%option // ' given, but the ' // &
               'first two columns are places on a grid: x,y,z lines have their own spacing, ' // &
               'expected none')
          return
        end if
        deallocate (map%height)
        points = .true.
      end if
    end if
    if (points) call read_points(file, layout, request, map)
    map%own_spacing = points .or. .not. given
    if (file%is_refused()) return
    if (given .and. any(layout%extent > 0.0_real64)) call compare_extent(file, layout, request, map)
    if (file%problems%count() == 0) call set_unit(file, layout, request, map)
  end subroutine read_text_map

  ! The spacing that is given, in one of the units of length, must be that of the header.
  subroutine compare_extent(file, layout, request, map)
    type(line_reader), intent(inout) :: file
    type(text_layout), intent(inout) :: layout
    type(map_request), intent(in) :: request
    type(height_map), intent(in) :: map
    real(real64) :: width
    integer :: i, k
    logical :: same(2)

    do k = 1, size(length_units)
      same = .true.
      do i = 1, 2
        if (layout%extent(i) <= 0.0_real64) cycle
        width = request%pixel_spacing(i) * size(map%height, i) / unit_ratio(layout%unit(i), k)
        same(i) = abs(width - layout%extent(i)) <= layout%extent_error(i) + &
                                                   1.0e-6_real64 * layout%extent(i)
      end do
      if (all(same)) layout%unit(:2) = length_units(k)
      if (all(same)) return
    end do
    call file%problems%add_in_file(request%option // ' contradicts the width or height of the ' // &
         'map in its header, found another one in every unit of length, expected the same, or none')
  end subroutine compare_extent

  ! The unit of the map: that of all lengths, or metres where each has one of its own. Where the
  ! header has that of the heights alone, or of x and y alone, the others are in the unit that is
  ! named for the map.
  subroutine set_unit(file, layout, request, map)
    type(line_reader), intent(inout) :: file
    type(text_layout), intent(in) :: layout
    type(map_request), intent(in) :: request
    type(height_map), intent(inout) :: map
    character(len=:), allocatable :: found
    integer :: i, numbers(3)

    map%edge = layout%edge
    found = ''
    do i = 1, 3
      if (layout%unit(i) /= '') found = found // ', ' // 'xyz'(i:i) // ' ' // trim(layout%unit(i))
    end do
    if (found == '') return
    found = found(3:)
    numbers = [(unit_number(layout%unit(i)), i=1, 3)]
    where (layout%unit == '') numbers = request%unit
    if (all(layout%unit == layout%unit(1)) .and. numbers(1) == 0) then
      call map%notes%add_in_file('note: units of its header: ' // found // '; not used, as they ' &
           // 'are none of ' // known_units // ': lengths are taken as they are')
    else if (any(numbers == 0)) then
      call file%problems%add_in_file('units of its header: found ' // found // ', expected ' // &
           'one of ' // known_units // ' for each of x, y and z, or ' // &
           request%option(:len(request%option) - len('spacing')) // 'unit')
    else if (all(numbers == numbers(1))) then
      map%unit = trim(length_units(numbers(1)))
    else
      map%unit = trim(length_units(numbers(3)))
      do i = 1, 2
        map%pixel_spacing(i) = map%pixel_spacing(i) * unit_ratio(length_units(numbers(i)), 1) / &
                               unit_ratio(map%unit, 1)
      end do
      call change_unit(map, max(1, request%unit))
      call map%notes%add_in_file('note: units of its header: ' // found // '; lengths are in ' // &
                                 map%unit)
    end if
  end subroutine set_unit

  ! Whether the first two columns of a matrix are the places of a grid, each once, or half of them
  ! or more: x,y,z lines.
  pure logical function is_list_of_points(height)
    real(real64), intent(in) :: height(:, :)
    integer, parameter :: most_columns = 6
    integer, allocatable :: place(:, :)
    integer :: levels(2), i
    integer(int64) :: lines  ! of a full grid
    logical, allocatable :: taken(:, :)

    is_list_of_points = .false.
    if (size(height, 1) < 3 .or. size(height, 1) > most_columns) return
    if (.not. all(is_measured(height(:2, :)))) return
    allocate (place(size(height, 2), 2))
    do i = 1, 2
      call count_levels(height(i, :), place(:, i), levels(i))
    end do
    lines = product(int(levels, int64))
    if (lines /= size(height, 2) .and. &
        (minval(levels) < 3 .or. lines > 2_int64 * size(height, 2))) return
    allocate (taken(levels(1), levels(2)))
    taken(:, :) = .false.
    do i = 1, size(height, 2)
      if (taken(place(i, 1), place(i, 2))) return
      taken(place(i, 1), place(i, 2)) = .true.
    end do
    is_list_of_points = .true.
  end function is_list_of_points

  ! Numbers the different values, the least first.
  pure subroutine count_levels(value, place, levels)
    real(real64), intent(in) :: value(:)
    integer, intent(out) :: place(:), levels
    integer, allocatable :: order(:)
    integer :: i

    allocate (order(size(value)))
    call sort_keys(value, order)
    levels = 1
    place(order(1)) = 1
    do i = 2, size(value)
      if (value(order(i)) > value(order(i - 1))) levels = levels + 1
      place(order(i)) = levels
    end do
  end subroutine count_levels

  ! Reads a matrix, a profile a line, or the pixels of a grid whose header states their number.
  subroutine read_matrix(file, layout, progress, map)
    type(line_reader), intent(inout) :: file
    type(text_layout), intent(in) :: layout
    logical, intent(in) :: progress
    type(height_map), intent(inout) :: map
    character(len=:), allocatable :: word
    type(progress_line) :: shown
    integer :: power, profile

    call check_layout(file, layout, map)
    if (file%problems%count() > 0) return
    call make_room(map, file%lack)
    if (allocated(file%lack)) return
    call shown%begin(progress, 'profiles read', map%rows, 0)
    call file%begin_text(layout%first_line)
    power = no_power
    do profile = 1, map%rows
      if (all(layout%stated > 0)) then
        call read_stated(file, layout, map, &
                         merge(map%rows - profile + 1, profile, layout%from_top), power)
      else
        call read_profile(file, map%height(:, profile), power)
      end if
      if (file%cells%cell_count == 0) exit
      call shown%reach(profile)
    end do
    call shown%finish()
    map%digit = digit_of(power)
    ! Faults in most lines: the file is of another kind, which is one mistake.
    call file%problems%shorten(map%rows)
    if (file%problems%count() > 0) return
    if (all(layout%stated > 0)) then
      call file%next_word(word)
      if (word /= '') call file%refuse_cell(file%cells%word, 'found ' // in_quotes(word) // &
        ' behind ' // decimal_text(map%columns) // ' x ' // decimal_text(map%rows) // &
        ' pixels, expected none')
    else
      call check_axes(file, map, layout%first_line)
    end if
  end subroutine read_matrix

  ! Reads a line as a profile.
  subroutine read_profile(file, heights, power)
    type(line_reader), intent(inout) :: file
    real(real64), intent(out) :: heights(:)
    integer, intent(inout) :: power  ! of the last digit of the heights
    integer :: i
    logical :: good

    call file%next_cells()
    associate (cells => file%cells)
      if (cells%missing > 0) &
        call file%refuse_cell(min(cells%missing, cells%cell_count), 'an empty cell ' // &
             merge('before', 'behind', cells%missing <= cells%cell_count) // ' this one, ' // &
             'expected ' // expected_cell)
      do i = 1, min(cells%cell_count, size(heights))
        call read_cell(file, i, .false., heights(i), good, power)
      end do
      if (cells%cell_count /= size(heights)) &
        call file%problems%add_at(cells%line, cells%last(cells%cell_count) - cells%start + 2, &
                                  'found ' // decimal_text(cells%cell_count) // &
                                  ' pixels, expected ' // decimal_text(size(heights)) // &
                                  ' as in the first profile')
    end associate
  end subroutine read_profile

  ! Reads a profile wherever its lines end. A missing height need not be one that is accepted.
  subroutine read_stated(file, layout, map, row, power)
    type(line_reader), intent(inout) :: file
    type(text_layout), intent(in) :: layout
    type(height_map), intent(inout) :: map
    integer, intent(in) :: row
    integer, intent(inout) :: power  ! of the last digit of the heights
    character(len=:), allocatable :: word
    integer :: i, any_power
    logical :: good

    do i = 1, map%columns
      call file%next_word(word)
      if (word == '') then
        call file%refuse_cell(1, 'the pixels end, expected ' // decimal_text(map%columns) // &
                              ' x ' // decimal_text(map%rows))
        return
      end if
      any_power = power
      call read_height(word, map%height(i, row), good, any_power)
      if (good .and. map%height(i, row) >= layout%missing(1) .and. &
          map%height(i, row) <= layout%missing(2)) then
        map%height(i, row) = no_height
      else
        call read_cell(file, file%cells%word, .false., map%height(i, row), good, power)
      end if
    end do
  end subroutine read_stated

  ! Sets the size of a matrix, unless its lines are none of one.
  subroutine check_layout(file, layout, map)
    type(line_reader), intent(inout) :: file
    type(text_layout), intent(in) :: layout
    type(height_map), intent(inout) :: map
    integer(int64) :: sides(2)
    logical :: stated

    stated = all(layout%stated > 0)
    sides = [int(layout%columns, int64), layout%lines]
    if (stated) sides = layout%stated
    if (any(sides > most_samples) .or. product(min(sides, most_samples)) > most_samples) then
      call file%problems%add_in_file('found more than ' // decimal_text(most_samples) // &
                                     ' pixels, expected at most so many')
    else if (layout%gap_line > 0 .and. .not. stated) then
      call file%problems%add_at(layout%gap_line, 1, 'found an empty line or a comment between ' // &
           'profiles, expected one block: take the line out, or make a file of each block')
    else if (.not. (stated .or. file%cells%decimal_comma) .and. &
             layout%columns /= layout%second .and. &
             layout%like_second > max(1_int64, layout%lines / 2_int64)) then
      call file%problems%add_at(layout%first_line, 1, 'found ' // decimal_text(layout%columns) // &
           ' cells before lines of ' // decimal_text(layout%second) // &
           ', expected heights alone: take the line out')
    else if (stated .and. file%count_bytes() < 2_int64 * product(sides)) then
      call file%problems%add_in_file('found ' // decimal_text(file%count_bytes()) // ' bytes, ' // &
           'expected ' // decimal_text(sides(1)) // ' x ' // decimal_text(sides(2)) // &
           ' pixels as in the header')
    else
      map%columns = int(sides(1))
      map%rows = int(sides(2))
    end if
  end subroutine check_layout

  ! A first line, or column, of equal steps over heights that have none numbers the columns or
  ! names their places. Whole numbers from 0 or 1 before other heights are surely no profile.
  subroutine check_axes(file, map, line)
    type(line_reader), intent(inout) :: file
    type(height_map), intent(inout) :: map
    integer, intent(in) :: line  ! the first of the matrix

    if (min(map%columns, map%rows) < 4) return
    call check_axis('line', map%height(:, 1), map%height(:, 2))
    call check_axis('column', map%height(1, :), map%height(2, :))

  contains

    subroutine check_axis(name, axis, next)
      character(len=*), intent(in) :: name
      real(real64), intent(in) :: axis(:), next(:)
      character(len=:), allocatable :: found

      if (.not. has_equal_steps(axis(2:)) .or. has_equal_steps(next(2:))) return
      found = 'equal steps in the first ' // name // ' (' // real_text(axis(2), 'f0.3') // &
              ', ' // real_text(axis(3), 'f0.3') // ', ...)'
      if (abs(axis(2) - axis(1) - 1.0_real64) <= 0.0_real64 .and. &
          any(abs(axis(1) - [0, 1]) <= 0.0_real64) .and. &
          any(abs(next(2:) - anint(next(2:))) > 0.0_real64)) then
        call file%problems%add_at(line, 1, 'found ' // found // ', which are numbers of ' // &
             'columns or rows, expected heights: take them out, in pandas with ' // &
             'to_csv(header=False, index=False)')
      else
        call map%notes%add_at(line, 1, 'note: ' // found // ' are taken as heights: take ' // &
                              'them out if they are places or numbers')
      end if
    end subroutine check_axis

  end subroutine check_axes

  ! Whether numbers differ by one step, but for what their digits leave out.
  pure logical function has_equal_steps(numbers)
    real(real64), intent(in) :: numbers(:)
    real(real64) :: step
    integer :: i

    has_equal_steps = all(is_measured(numbers))
    if (.not. has_equal_steps) return
    step = (numbers(size(numbers)) - numbers(1)) / (size(numbers) - 1)
    has_equal_steps = abs(step) > 0.0_real64 .and. &
      all(abs(numbers - numbers(1) - step * [(i, i=0, size(numbers) - 1)]) <= &
          same * maxval(abs(numbers)))
  end function has_equal_steps

  ! Reads `x,y,z` lines, in any order.
  subroutine read_points(file, layout, request, map)
    type(line_reader), intent(inout) :: file
    type(text_layout), intent(in) :: layout
    type(map_request), intent(in) :: request
    type(height_map), intent(inout) :: map
    type(extent) :: along(2)
    type(progress_line) :: shown
    real(real64) :: values(3)
    integer(int64) :: lines, done
    integer :: place(2), i, power
    logical :: good, grid

    lines = 0_int64
    power = no_power
    call file%begin_text(layout%first_line)
    do
      call next_point(file, layout, request%option, values, good, power)
      if (file%cells%cell_count == 0) exit
      ! Where the first line is none the file is of another kind: that is one mistake, not many.
      if (file%cells%cell_count /= layout%cell_count .and. lines == 0_int64) return
      if (.not. good) cycle
      lines = lines + 1_int64
      do i = 1, 2
        call take_coordinate(values(i), along(i))
      end do
    end do
    if (layout%names_line == 0) call file%problems%shorten(int(min(layout%lines, most_samples)))
    if (file%problems%count() > 0) return
    map%columns = int(min(along(2)%sharing, most_samples))
    map%rows = int(min(along(1)%sharing, most_samples))
    grid = lines > 0_int64 .and. int(map%columns, int64) * map%rows == lines .and. &
           min(map%columns, map%rows) > 1
    if (grid) then
      map%pixel_spacing = (along%last - along%first) / real([map%columns - 1, map%rows - 1], real64)
      grid = all(is_length(map%pixel_spacing)) .and. lines <= most_samples
    end if
    if (.not. grid) then
      call file%refuse_cell(1, 'found ' // decimal_text(lines) // ' lines x,y,z, of them ' // &
                            decimal_text(along(2)%sharing) // ' with the least y and ' // &
                            decimal_text(along(1)%sharing) // ' with the least x, expected a ' // &
                            'full regular grid')
      return
    end if
    call make_room(map, file%lack)
    if (allocated(file%lack)) return
    ! Every sample is there once when none is there twice. So high no height is.
    map%height(:, :) = huge(1.0_real64)
    call shown%begin(request%progress, 'lines read', int(lines), 0)
    call file%begin_text(layout%first_line)
    do done = 1_int64, lines
      call next_point(file, layout, request%option, values, good, power)
      place = 1 + nint((values(:2) - along%first) / map%pixel_spacing)
      i = findloc(abs(values(:2) - along%first - (place - 1) * map%pixel_spacing) > &
                  most_off * map%pixel_spacing, .true., 1)
      if (i > 0) then
        call file%refuse_cell(layout%place(i), 'found ' // &
                              in_quotes(file%cell_text(layout%place(i))) // ', expected a ' // &
                              merge('column', 'row   ', i == 1) // ' of a regular grid of ' &
                              // decimal_text(map%columns) // ' x ' // decimal_text(map%rows))
        cycle
      end if
      if (map%height(place(1), place(2)) < 0.5_real64 * huge(1.0_real64)) &
        call file%refuse_cell(1, 'found a pixel of column ' // decimal_text(place(1)) // ', row ' &
                              // decimal_text(place(2)) // ' for the second time, expected it once')
      map%height(place(1), place(2)) = values(3)
      call shown%reach(int(done))
    end do
    call shown%finish()
    map%digit = digit_of(power)
  end subroutine read_points

  ! Reads the next line of three cells; there is none at the end of the file.
  subroutine next_point(file, layout, option, values, good, power)
    type(line_reader), intent(inout) :: file
    type(text_layout), intent(in) :: layout
    character(len=*), intent(in) :: option
    real(real64), intent(out) :: values(3)
    logical, intent(out) :: good
    integer, intent(inout) :: power  ! of the last digit of the heights
    character(len=:), allocatable :: expected
    integer :: i, any_power

    values = 0.0_real64
    good = .true.
    call file%next_cells()
    if (file%cells%cell_count == 0) return
    if (file%cells%cell_count /= layout%cell_count .or. file%cells%missing > 0) then
      good = .false.
      expected = option // ' along x and y for a matrix of heights, or three: x,y,z'
      if (layout%names_line > 0) expected = decimal_text(layout%cell_count) // ' as there are names'
      call file%refuse_cell(1, 'found ' // decimal_text(file%cells%cell_count) // &
                            ' cells or an empty one, expected ' // expected)
      return
    end if
    do i = 1, 3
      any_power = no_power
      call read_cell(file, layout%place(i), i < 3, values(i), good, any_power)
      if (i == 3) power = min(power, any_power)
      if (.not. good) return
    end do
  end subroutine next_point

  ! Takes one more coordinate into the range of all.
  pure subroutine take_coordinate(value, along)
    real(real64), intent(in) :: value
    type(extent), intent(inout) :: along
    real(real64) :: room

    room = same * max(abs(value), min(abs(along%first), highest))
    along%last = max(along%last, value)
    if (value < along%first - room) then
      along%first = value
      along%sharing = 1_int64
    else if (value <= along%first + room) then
      along%sharing = along%sharing + 1_int64
    end if
  end subroutine take_coordinate

  ! Reads a cell of a line as a height, which is no missing one where it must be measured.
  subroutine read_cell(file, i, must_be_measured, height, good, power)
    type(line_reader), intent(inout) :: file
    integer, intent(in) :: i
    logical, intent(in) :: must_be_measured
    real(real64), intent(out) :: height
    logical, intent(out) :: good
    integer, intent(inout) :: power
    character(len=:), allocatable :: text
    integer :: comma

    if (file%cells%decimal_comma) then
      text = file%cell_text(i)
      comma = index(text, ',')
      if (comma > 0) text(comma:comma) = '.'
      call read_height(text, height, good, power)
    else
      call read_height(file%lines(file%cells%first(i):file%cells%last(i)), height, good, power)
    end if
    good = good .and. merge(abs(height) <= highest, .not. must_be_measured, is_measured(height))
    if (.not. good) call file%refuse_cell(i, 'found ' // in_quotes(file%cell_text(i)) // &
                                          ', expected ' // expected_cell)
  end subroutine read_cell

  ! Finds the layout. What is not understood of the header is noted.
  subroutine find_layout(file, layout, notes)
    type(line_reader), intent(inout) :: file
    type(text_layout), intent(out) :: layout
    type(problem_list), intent(inout) :: notes
    type(cell_counts) :: counts
    character(len=:), allocatable :: head, text

    call file%begin_text(1)
    call file%take(head_length, head)
    layout%problems = file%problems
    layout%notes = notes
    call read_header(head, layout%text_header, text)
    file%problems = layout%problems
    notes = layout%notes
    if (layout%first_line == 0) return
    if (is_surface_header(text)) then
      call file%problems%add_at(layout%first_line, 1, 'found a surface: name it in &surfaces ' // &
           'of a scene; expected a height map, with z for height if this is one')
    else if (.not. has_number(text)) then
      call file%problems%add_at(layout%first_line, 1, 'found ' // in_quotes(text) // &
                                ', expected heights, or the names x, y and z of columns')
    else if (any(layout%stated > 0) .and. &
             .not. all(layout%stated > 0 .and. layout%has_spacing())) then
      call file%problems%add_at(layout%first_line, 1, 'the header of a grid ends here, expected ' &
                                // 'ncols, nrows and cellsize in it')
    end if
    if (file%problems%count() > 0) return
    call file%begin_text(layout%first_line)
    call count_cells(file, layout, counts)
    file%cells = line_cells(' ', '#%', '#', .false.)
    call choose_separator(file, layout, counts, notes)
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
  subroutine count_cells(file, layout, counts)
    type(line_reader), intent(inout) :: file
    type(text_layout), intent(inout) :: layout
    type(cell_counts), intent(out) :: counts
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
        call file%problems%add_at(line, 1, 'found a line of empty cells, expected heights, or ' // &
                                  'NaN for a missing one')
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
  subroutine choose_separator(file, layout, counts, notes)
    type(line_reader), intent(inout) :: file
    type(text_layout), intent(inout) :: layout
    type(cell_counts), intent(in) :: counts
    type(problem_list), intent(inout) :: notes
    logical :: used(5)
    integer :: i, first, second

    used = counts%gaps > 0_int64
    first = findloc(used(:a_semicolon), .true., 1)
    if (used(a_decimal_comma) .and. count(used) == 2 .and. .not. used(a_comma) .and. &
        .not. (counts%point .or. counts%two_commas)) then
      file%cells%decimal_comma = .true.
      if (.not. counts%surely_decimal) &
        call refuse_gaps([a_decimal_comma], 'found a comma before three digits in every ' // &
             'number with one: thousands or decimals')
    else
      layout%columns = layout%columns + counts%commas
      used(a_comma) = used(a_comma) .or. used(a_decimal_comma)
      first = max(1, findloc(used(:a_semicolon), .true., 1))
      second = max(1, findloc(used(:a_semicolon), .true., 1, back=.true.))
      if (first /= second) then
        call refuse_gaps([first, second, a_decimal_comma], 'found ' // trim(gap_names(first)) // &
                         ' and ' // trim(gap_names(second)) // ' between cells')
      else if (used(a_decimal_comma) .and. .not. counts%point .and. counts%spaced_comma) then
        call refuse_gaps([a_comma, a_decimal_comma], 'found commas with and without a blank, and ' &
                         // 'no point in the file: separators or decimals')
      else if (used(a_decimal_comma) .and. .not. counts%point .and. &
               modulo(layout%columns, 2) == 0) then
        if (may_be_decimals(counts)) &
          call refuse_gaps([a_decimal_comma], 'found commas alone, no point in the file, and ' // &
                           'second numbers of a pair that look like decimals of the first')
        if (file%problems%count() == 0) &
          call notes%add_at(counts%line(a_decimal_comma), counts%column(a_decimal_comma), &
                            'note: commas without a decimal point in the file are taken as ' // &
                            'separators of whole numbers')
      end if
    end if
    file%cells%separator = separators(first:first)
    do i = a_tab, a_semicolon
      if (counts%ended(i) == 0_int64 .or. (i == a_tab .and. i /= first) .or. &
          (i == first .and. counts%ended(i) == layout%lines)) cycle
      call file%problems%add_in_file('found ' // decimal_text(counts%ended(i)) // ' of ' // &
           decimal_text(layout%lines) // ' lines that end with ' // trim(gap_names(i)) // &
           ', expected all, between cells too, or none')
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
      call file%problems%add_at(counts%line(place), counts%column(place), found // ', expected ' &
                                // 'decimal points and one separator, for instance blanks')
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

end module asperity_text_map
