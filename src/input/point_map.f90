!> Height maps as x,y,z lines: one pixel a line behind the header `x,y,z`, or `x,y,height` as that
!> of a surface, between commas, semicolons, tabulators or blanks.
!>
!> The lines follow a full regular grid along x or along y first, from either end of both. The
!> first line that does not is a problem.
module asperity_point_map
  use asperity_delimited_text, only: cells_of, line_cells, line_reader, separator_of
  use asperity_height_map, only: digit_of, expected_length, height_map, highest, is_length, &
                                 is_measured, longest_side, make_room, map_request, no_power, &
                                 read_height
  use asperity_input_text, only: in_quotes, lower_case
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text, real_text
  use asperity_progress, only: progress_line
  implicit none
  private

  public :: is_point_header, read_height_cell, read_point_map

  ! A coordinate may be off its place by so much of the spacing: it was written with few digits, or
  ! measured (chosen; test: places beside the grid in test/maps/test_summits.py).
  real(real64), parameter :: most_off = 0.1_real64
  character(len=1), parameter :: axis_names(2) = ['x', 'y']

  ! A grid of points in the order of the file.
  type :: point_grid
    integer(int64) :: points = 0_int64        ! lines of the file
    integer(int64) :: turn = 0_int64          ! points until the first axis begins again; 0: never
    integer :: fast = 1                       ! axis along which the file runs first; 1: x, 2: y
    real(real64) :: origin(2) = 0.0_real64    ! first point
    real(real64) :: step(2) = 0.0_real64      ! spacing with its sign
    integer(int64) :: counts(2) = 0_int64     ! columns and rows
  end type point_grid

contains

  !> Whether a line is the header x,y,z, or x,y,height.
  pure logical function is_point_header(line)
    character(len=*), intent(in) :: line  !! line without its end and blanks around it
    type(line_cells) :: cells
    character(len=6) :: names(3)
    integer :: i

    cells = cells_of(line, separator_of(line), .false.)
    is_point_header = cells%cell_count == 3
    if (.not. is_point_header) return
    is_point_header = all(cells%last(:3) - cells%first(:3) < len(names))
    do i = 1, 3
      names(i) = lower_case(line(cells%first(i):cells%last(i)))
    end do
    is_point_header = is_point_header .and. all(names(:2) == axis_names) .and. &
                      any(names(3) == [character(len=6) :: 'z', 'height'])
  end function is_point_header

  !> Reads the points behind the header, unless there is no memory for them.
  subroutine read_point_map(file, request, map)
    type(line_reader), intent(inout) :: file   !! at the cells of its header; gets what is wrong
    type(map_request), intent(in) :: request   !! what is given beside the map
    type(height_map), intent(inout) :: map     !! gets the pixels
    type(point_grid) :: grid

    if (all(request%pixel_spacing > 0.0_real64) .and. .not. request%shared) &
      call file%refuse_cell(1, request%option // ' given, but x,y,z lines have their own ' // &
                            'spacing, expected none')
    if (file%problems%count() > 0) return
    call measure_grid(file, grid)
    call file%problems%shorten(int(min(grid%points, int(huge(1), int64))))
    if (file%problems%count() > 0) return
    map%columns = int(grid%counts(1))
    map%rows = int(grid%counts(2))
    map%pixel_spacing = abs(grid%step)
    call make_room(map, file%lack)
    if (.not. allocated(file%lack)) call fill_map(file, request%progress, grid, map)
  end subroutine read_point_map

  ! Finds the size of the grid from its first point, its last one, and where its first line ends.
  subroutine measure_grid(file, grid)
    type(line_reader), intent(inout) :: file
    type(point_grid), intent(out) :: grid
    real(real64) :: before(2), first_turn(2), second(2), values(3)
    integer :: power, slow
    logical :: good

    before = 0.0_real64
    first_turn = 0.0_real64
    second = 0.0_real64
    power = no_power
    call file%begin_text()
    call file%next_cells()
    do
      call read_point(file, values, good, power)
      if (file%cells%cell_count == 0) exit
      grid%points = grid%points + 1_int64
      if (.not. good) cycle
      associate (place => values(:2), fast => grid%fast)
        if (grid%points == 1_int64) grid%origin = place
        if (grid%points == 2_int64) then
          second = place
          if (abs(place(2) - grid%origin(2)) > abs(place(1) - grid%origin(1))) fast = 2
        end if
        if (grid%turn == 0_int64 .and. grid%points > 1_int64) then
          ! The first line ends where its axis goes back.
          if ((place(fast) - before(fast)) * (second(fast) - grid%origin(fast)) <= 0.0_real64) then
            grid%turn = grid%points - 1_int64
            grid%step(fast) = (before(fast) - grid%origin(fast)) / max(1_int64, grid%turn - 1_int64)
            first_turn = place
          end if
        end if
        before = place
      end associate
    end do
    if (file%problems%count() > 0) return
    slow = 3 - grid%fast
    if (grid%turn > 0_int64) then
      grid%counts(grid%fast) = grid%turn
      grid%counts(slow) = (grid%points + grid%turn - 1_int64) / grid%turn
      ! Where points are missing or twice, the second line finds the place.
      grid%step(slow) = first_turn(slow) - grid%origin(slow)
      if (modulo(grid%points, grid%turn) == 0_int64) &
        grid%step(slow) = (before(slow) - grid%origin(slow)) / &
                          max(1_int64, grid%counts(slow) - 1_int64)
    end if
    if (.not. all(is_length(abs(grid%step))) .or. any(grid%counts > longest_side)) &
      call file%refuse_cell(1, 'found ' // decimal_text(grid%points) // ' points in no order of ' &
           // 'columns and rows, expected a full regular grid, each spacing ' // expected_length &
           // ', of at most ' // decimal_text(longest_side) // ' pixels a side')
  end subroutine measure_grid

  ! Reads all points into their pixels, up to the first one that is not at its place.
  subroutine fill_map(file, progress, grid, map)
    type(line_reader), intent(inout) :: file
    logical, intent(in) :: progress
    type(point_grid), intent(in) :: grid
    type(height_map), intent(inout) :: map
    type(progress_line) :: shown
    real(real64) :: expected(2), values(3)
    integer(int64) :: done
    integer :: along(2), axis, place(2), power
    logical :: good

    power = no_power
    call shown%begin(progress, 'profiles read', int(grid%counts(3 - grid%fast)), 0)
    call file%begin_text()
    call file%next_cells()
    do done = 0_int64, product(grid%counts) - 1_int64
      call read_point(file, values, good, power)
      along(grid%fast) = int(modulo(done, grid%turn))
      along(3 - grid%fast) = int(done / grid%turn)
      expected = grid%origin + along * grid%step
      axis = findloc(abs(values(:2) - expected) > most_off * abs(grid%step), .true., 1)
      if (file%cells%cell_count == 0 .or. axis > 0) then
        call file%refuse_cell(max(1, axis), 'found ' // found_text() // ', expected x = ' // &
             real_text(expected(1)) // ', y = ' // real_text(expected(2)) // &
             ': the points of a full regular grid of ' // decimal_text(map%columns) // ' x ' // &
             decimal_text(map%rows) // ', each once, in the order of the first ones')
        return
      end if
      place = merge(along + 1, int(grid%counts) - along, grid%step > 0.0_real64)
      map%height(place(1), place(2)) = values(3)
      call shown%reach(along(3 - grid%fast))
    end do
    call shown%finish()
    map%digit = digit_of(power)

  contains

    function found_text() result(text)
      character(len=:), allocatable :: text

      text = 'the end of the file'
      if (axis > 0 .and. file%cells%cell_count > 0) &
        text = axis_names(axis) // ' = ' // in_quotes(file%cell_text(axis))
    end function found_text

  end subroutine fill_map

  ! Reads the next line; it has no cells at the end of the file.
  subroutine read_point(file, values, good, power)
    type(line_reader), intent(inout) :: file
    real(real64), intent(out) :: values(3)
    logical, intent(out) :: good
    integer, intent(inout) :: power  ! of the last digit of the heights
    integer :: i, any_power

    values = 0.0_real64
    call file%next_cells()
    good = file%cells%cell_count == 3
    if (file%cells%cell_count == 0) return
    if (.not. good) &
      call file%refuse_cell(1, 'found ' // decimal_text(file%cells%cell_count) // &
                            ' cells, expected 3 as in the header')
    do i = 1, merge(3, 0, good)
      any_power = no_power
      call read_height_cell(file, i, values(i), good, any_power)
      if (i == 3) power = min(power, any_power)
      if (good .and. i < 3 .and. .not. is_measured(values(i))) then
        good = .false.
        call file%refuse_cell(i, 'found ' // in_quotes(file%cell_text(i)) // ', expected a number')
      end if
      if (.not. good) return
    end do
  end subroutine read_point

  !> Reads a cell of the line at hand as a height. One that is none is a problem.
  subroutine read_height_cell(file, i, height, good, power)
    type(line_reader), intent(inout) :: file  !! gets the problem
    integer, intent(in) :: i                  !! number of the cell
    real(real64), intent(out) :: height       !! `no_height` where missing
    logical, intent(out) :: good              !! whether it is a height
    integer, intent(inout) :: power           !! as of `read_height`

    call read_height(file%lines(file%cells%first(i):file%cells%last(i)), height, good, power)
    good = good .and. (abs(height) <= highest .or. .not. is_measured(height))
    if (.not. good) &
      call file%refuse_cell(i, 'found ' // in_quotes(file%cell_text(i)) // ', expected a height ' &
                            // 'of at most 1e30, or NaN or BAD for a missing one')
  end subroutine read_height_cell

end module asperity_point_map
