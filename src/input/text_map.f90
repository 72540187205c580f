!> Height maps as plain text: a matrix of heights, or `x,y,z` lines of a full regular grid.
!>
!> Cells are separated by blanks, commas or semicolons; a number sign makes the rest of a line a
!> comment. Each is read twice: to find its size, and to fill the map.
module asperity_text_map
  use asperity_height_map, only: digit_of, expected_length, height_map, is_length, is_measured, &
                                 make_room, most_samples, no_power, number_text, read_height
  use asperity_input_text, only: lower_case, quoted
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text, problem_list
  use asperity_progress, only: progress_line
  use asperity_token_reader, only: token, token_reader
  implicit none
  private

  public :: read_matrix, read_points

  ! Coordinates nearer than this, relative to their size, are written for the same column or row.
  real(real64), parameter :: same = 1.0e-12_real64
  ! A coordinate may be off its place by so much of the spacing: it was written with few digits.
  real(real64), parameter :: most_off = 0.1_real64
  real(real64), parameter :: highest = 1.0e30_real64
  character(len=*), parameter :: expected_height = &
    'a height of at most 1e30, or NaN or BAD for a missing one'

  ! The least and the largest coordinate, and how many samples share the least.
  type :: extent
    real(real64) :: first = huge(1.0_real64), last = -huge(1.0_real64)
    integer(int64) :: sharing = 0_int64
  end type extent

contains

  !> Reads a matrix, a profile a line. `failure` is allocated when there is no memory for it.
  subroutine read_matrix(file, progress, map, problems, failure)
    type(token_reader), intent(inout) :: file               !! at its first byte
    logical, intent(in) :: progress                         !! tell how far it has come
    type(height_map), intent(inout) :: map                  !! gets the samples; its spacing is set
    type(problem_list), intent(inout) :: problems           !! what is wrong
    character(len=:), allocatable, intent(out) :: failure   !! why not
    type(token) :: word
    type(progress_line) :: shown
    integer(int64) :: samples
    integer :: i, row, line, end_line, power
    logical :: good

    call file%next(word)
    line = word%line
    samples = 0_int64
    map%rows = 0
    end_line = 0
    do while (word%length > 0)
      if (word%line == line) map%columns = map%columns + 1
      if (word%line /= end_line) map%rows = map%rows + 1
      end_line = word%line
      samples = samples + 1_int64
      if (samples == most_samples) exit
      call file%next(word)
    end do
    ! Rows of another length are told when they are read.
    if (int(map%columns, int64) * map%rows > most_samples) then
      call problems%add_in_file('found more than ' // number_text(most_samples) // &
                                ' samples, expected at most so many')
      return
    end if
    if (samples == 0_int64) then
      call problems%add_at(1, 1, 'found no sample, expected a matrix of heights')
      return
    end if
    call make_room(map, failure)
    if (allocated(failure)) return
    call shown%begin(progress, 'profiles read', map%rows, 0)
    call file%again()
    call file%next(word)
    power = no_power
    do row = 1, map%rows
      line = word%line
      i = 0
      do while (word%length > 0 .and. word%line == line)
        i = i + 1
        if (word%cell_missing) &
          call problems%add_at(line, word%column, 'an empty cell before this one, expected ' // &
                               expected_height)
        if (i <= map%columns) then
          call read_cell(word, map%height(i, row), good, power)
          if (.not. good) call refuse(word, problems)
        end if
        end_line = word%column + word%length
        call file%next(word)
      end do
      if (i /= map%columns) &
        call problems%add_at(line, end_line, 'found ' // decimal_text(i) // ' samples, ' // &
                             'expected ' // decimal_text(map%columns) // ' as in the first profile')
      call shown%reach(row)
    end do
    call shown%finish()
    map%digit = digit_of(power)
  end subroutine read_matrix

  !> Reads `x,y,z` lines, in any order. `failure` is allocated when there is no memory for them.
  subroutine read_points(file, progress, map, problems, failure)
    type(token_reader), intent(inout) :: file               !! at its first byte
    logical, intent(in) :: progress                         !! tell how far it has come
    type(height_map), intent(inout) :: map                  !! gets the samples
    type(problem_list), intent(inout) :: problems           !! what is wrong
    character(len=:), allocatable, intent(out) :: failure   !! why not
    type(token) :: words(3), ahead
    type(extent) :: along(2)
    type(progress_line) :: shown
    real(real64) :: values(3)
    integer(int64) :: lines, done
    integer :: place(2), i, cells, power
    logical :: good, grid

    lines = 0_int64
    power = no_power
    call first_point(file, ahead)
    do while (ahead%length > 0)
      call next_point(file, ahead, words, cells, values, good, power, problems)
      ! Where the first line is none the file is of another kind: that is one mistake, not many.
      if (cells /= 3 .and. lines == 0_int64) return
      if (.not. good) cycle
      lines = lines + 1_int64
      do i = 1, 2
        call take_coordinate(values(i), along(i))
      end do
    end do
    if (problems%count() > 0) return
    map%columns = int(min(along(2)%sharing, most_samples))
    map%rows = int(min(along(1)%sharing, most_samples))
    grid = lines > 0_int64 .and. int(map%columns, int64) * map%rows == lines .and. &
           min(map%columns, map%rows) > 1
    if (grid) then
      map%spacing = (along%last - along%first) / real([map%columns - 1, map%rows - 1], real64)
      grid = all(is_length(map%spacing)) .and. lines <= most_samples
    end if
    if (.not. grid) then
      call problems%add_at(ahead%line, ahead%column, 'found ' // number_text(lines) // &
                           ' lines x,y,z, of them ' // number_text(along(2)%sharing) // &
                           ' with the least y and ' // number_text(along(1)%sharing) // &
                           ' with the least x, expected a full regular grid')
      return
    end if
    call make_room(map, failure)
    if (allocated(failure)) return
    ! Every sample is there once when none is there twice. So high no height is.
    map%height(:, :) = huge(1.0_real64)
    call shown%begin(progress, 'lines read', int(lines), 0)
    call file%again()
    call first_point(file, ahead)
    do done = 1_int64, lines
      call next_point(file, ahead, words, cells, values, good, power, problems)
      do i = 1, 2
        place(i) = 1 + nint((values(i) - along(i)%first) / map%spacing(i))
        if (abs(values(i) - along(i)%first - (place(i) - 1) * map%spacing(i)) > &
            most_off * map%spacing(i)) good = .false.
        if (good) cycle
        call problems%add_at(words(i)%line, words(i)%column, 'found ' // &
                             quoted(words(i)%text(:words(i)%length)) // ', expected a ' // &
                             merge('column', 'row   ', i == 1) // ' of a regular grid of ' // &
                             decimal_text(map%columns) // ' x ' // decimal_text(map%rows))
        exit
      end do
      if (.not. good) cycle
      if (map%height(place(1), place(2)) < 0.5_real64 * huge(1.0_real64)) &
        call problems%add_at(words(1)%line, words(1)%column, 'found a sample of column ' // &
                             decimal_text(place(1)) // ', row ' // decimal_text(place(2)) // &
                             ' for the second time, expected it once')
      map%height(place(1), place(2)) = values(3)
      call shown%reach(int(done))
    end do
    call shown%finish()
    map%digit = digit_of(power)
  end subroutine read_points

  ! The line that begins with the word ahead, which becomes the first of the next line.
  subroutine next_point(file, ahead, words, cells, values, good, power, problems)
    type(token_reader), intent(inout) :: file
    type(token), intent(inout) :: ahead
    type(token), intent(out) :: words(3)
    integer, intent(out) :: cells
    real(real64), intent(out) :: values(3)
    logical, intent(out) :: good
    integer, intent(inout) :: power  ! of the last digit of the heights
    type(problem_list), intent(inout) :: problems
    integer :: i, line, any_power

    values = 0.0_real64
    line = ahead%line
    cells = 0
    good = .true.
    do while (ahead%length > 0 .and. ahead%line == line)
      cells = cells + 1
      if (ahead%cell_missing) good = .false.
      if (cells <= 3) words(cells) = ahead
      call file%next(ahead)
    end do
    if (cells /= 3 .or. .not. good) then
      good = .false.
      call problems%add_at(line, words(1)%column, 'found ' // decimal_text(cells) // &
                           ' cells or an empty one, expected x,y,z; a matrix of heights needs ' // &
                           'its spacing: --spacing X,Y, in a scene map_spacing')
      return
    end if
    do i = 1, 3
      any_power = no_power
      call read_cell(words(i), values(i), good, any_power)
      if (i == 3) power = min(power, any_power)
      if (i < 3 .and. .not. is_measured(values(i))) good = .false.
      if (good) cycle
      call refuse(words(i), problems)
      return
    end do
  end subroutine next_point

  ! The first word of the first line of numbers: a line of the names may stand before it.
  subroutine first_point(file, ahead)
    type(token_reader), intent(inout) :: file
    type(token), intent(out) :: ahead
    integer :: line

    call file%next(ahead)
    if (lower_case(ahead%text) /= 'x') return
    line = ahead%line
    do while (ahead%length > 0 .and. ahead%line == line)
      call file%next(ahead)
    end do
  end subroutine first_point

  ! A coordinate more.
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

  ! A cell as a height.
  subroutine read_cell(word, height, good, power)
    type(token), intent(in) :: word
    real(real64), intent(out) :: height
    logical, intent(out) :: good
    integer, intent(inout) :: power

    call read_height(word%text(:word%length), height, good, power)
    good = good .and. .not. word%is_cut
    if (is_measured(height)) good = good .and. abs(height) <= highest
  end subroutine read_cell

  subroutine refuse(word, problems)
    type(token), intent(in) :: word
    type(problem_list), intent(inout) :: problems

    call problems%add_at(word%line, word%column, 'found ' // quoted(word%text(:word%length)) // &
                         ', expected ' // expected_height)
  end subroutine refuse

end module asperity_text_map
