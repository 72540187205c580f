!> A height map as plain text: a matrix of heights, one profile a line, a spacing given beside it.
!>
!> Cells stand between blanks, tabulators, commas or semicolons: the sign of the first line. Lines
!> that begin with `#` or `%` are comments. Other text formats: `asperity.read_map` in Python, by
!> SurfaceTopography.
module asperity_text_map
  use asperity_delimited_text, only: line_cells, line_reader, separator_of
  use asperity_height_map, only: digit_of, height_map, highest, is_measured, make_room, map_request, &
                                 most_samples, no_power, read_height
  use asperity_input_text, only: in_quotes
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text
  use asperity_progress, only: progress_line
  implicit none
  private

  public :: read_text_map

contains

  !> Reads a map, unless there is no memory for it.
  subroutine read_text_map(file, request, map)
    type(line_reader), intent(inout) :: file   !! open; gets what is wrong
    type(map_request), intent(in) :: request   !! what is given beside the map
    type(height_map), intent(inout) :: map     !! gets the pixels
    type(progress_line) :: shown
    integer(int64) :: rows
    integer :: i, j, power
    logical :: good

    if (.not. all(request%pixel_spacing > 0.0_real64)) &
      call file%problems%add_in_file('a matrix of heights has no spacing: found no ' // &
        request%option // ', expected one; the Python package reads formats that have their own')
    if (file%problems%count() > 0) return
    map%pixel_spacing = request%pixel_spacing
    map%own_spacing = .false.
    call begin_cells()
    map%columns = file%cells%cell_count
    rows = 0_int64
    do while (file%cells%cell_count > 0)
      rows = rows + 1_int64
      call file%next_cells()
    end do
    if (rows == 0_int64) call file%problems%add_at(1, 1, 'found no pixel, expected a matrix')
    if (rows * map%columns > most_samples) &
      call file%problems%add_in_file('found more than ' // decimal_text(most_samples) // &
                                     ' pixels, expected at most so many')
    if (file%problems%count() > 0) return
    map%rows = int(rows)
    call make_room(map, file%lack)
    if (allocated(file%lack)) return
    power = no_power
    call shown%begin(request%progress, 'profiles read', map%rows, 0)
    call begin_cells()
    do j = 1, map%rows
      associate (cells => file%cells)
        if (cells%cell_count /= map%columns .or. cells%missing > 0) &
          call file%refuse_cell(1, 'found ' // decimal_text(cells%cell_count) // ' pixels or an ' &
            // 'empty one, expected ' // decimal_text(map%columns) // ' as in the first profile')
        do i = 1, min(cells%cell_count, map%columns)
          call read_height(file%lines(cells%first(i):cells%last(i)), map%height(i, j), good, power)
          if (.not. good .or. (is_measured(map%height(i, j)) .and. &
                               abs(map%height(i, j)) > highest)) &
            call file%refuse_cell(i, 'found ' // in_quotes(file%cell_text(i)) // &
              ', expected a height of at most 1e30, or NaN or BAD for a missing one')
        end do
      end associate
      call shown%reach(j)
      call file%next_cells()
    end do
    call shown%finish()
    map%digit = digit_of(power)
    ! Faults in most lines: the file is of another kind, which is one mistake.
    call file%problems%shorten(map%rows)

  contains

    ! Goes to the first profile; its separator is that of all.
    subroutine begin_cells()
      integer :: first, last

      call file%begin_text(1)
      file%cells = line_cells(' ', '#%', '#', .false.)
      ! The first line that is no comment.
      call file%next_cells()
      if (file%cells%cell_count > 0) then
        first = file%cells%first(1)
        last = file%cells%last(file%cells%cell_count)
        file%cells%separator = separator_of(file%lines(first:last))
      end if
      call file%begin_text(1)
      call file%next_cells()
    end subroutine begin_cells

  end subroutine read_text_map

end module asperity_text_map
