!> Writes a height map as a file that is read again: surface data, an array, or a text matrix.
module asperity_map_file
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_c_binding, only: c_int
  use asperity_byte_reader, only: bytes_of
  use asperity_files, only: write_bytes
  use asperity_height_map, only: edge_names, height_map, is_measured, periodic_edge, unit_ratio
  use asperity_input_text, only: lower_case
  use asperity_kinds, only: int64, real64
  use asperity_library_turn, only: library_turn
  use asperity_npy_map, only: npy_magic
  use asperity_output_files, only: close_part, commit_files, open_part
  use asperity_problems, only: decimal_text, problem_list, real_text
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: write_map_file, stage_map_file, check_map_path, note_of_file

  integer(int64), parameter :: block_size = 65536_int64  ! bytes that are written at once
  ! More pixels a side have no place in the header of ISO-1.0.
  integer, parameter :: most_of_iso_1 = 65535

contains

  !> Writes a map beside its place, as `asperity_output_files` does; the ending of the path, .sdf,
  !> .npy or .txt, chooses the format. Heights keep all their bits. `failure` is allocated when the
  !> file cannot be written.
  subroutine stage_map_file(path, map, problems, failure)
    character(len=*), intent(in) :: path                    !! the file; empty: standard output
    type(height_map), intent(in) :: map                     !! checked height map
    type(problem_list), intent(inout) :: problems           !! what the format does not hold
    character(len=:), allocatable, intent(out) :: failure   !! why it was not written
    character(len=:), allocatable :: head, place
    integer(c_int) :: descriptor

    place = path
    if (place == '') place = '/dev/stdout'
    call make_header(path, map, head, problems)
    if (.not. allocated(head)) return
    call open_part(place, descriptor, failure)
    if (allocated(failure)) return
    call write_map(descriptor, ending_of(path), head, map, failure)
    call close_part(place, descriptor, failure)
  end subroutine stage_map_file

  !> The same, to its end.
  subroutine write_map_file(path, map, problems, failure)
    character(len=*), intent(in) :: path                    !! the file; empty: standard output
    type(height_map), intent(in) :: map                     !! checked height map
    type(problem_list), intent(inout) :: problems           !! what the format does not hold
    character(len=:), allocatable, intent(out) :: failure   !! why it was not written
    type(library_turn) :: turn

    call turn%begin()
    call stage_map_file(path, map, problems, failure)
    if (.not. allocated(failure)) call commit_files(failure)
  end subroutine write_map_file

  !> Checks that a map of a unit can be written, before it is made.
  subroutine check_map_path(path, unit, problems)
    character(len=*), intent(in) :: path            !! the file; empty: standard output
    character(len=*), intent(in) :: unit            !! of all lengths; empty: none
    type(problem_list), intent(inout) :: problems   !! what the format does not hold
    character(len=:), allocatable :: head
    type(height_map) :: map

    map%unit = unit
    map%pixel_spacing = 1.0_real64
    call make_header(path, map, head, problems)
  end subroutine check_map_path

  !> A note of what a file does not hold of a map; empty: it holds its edge.
  function note_of_file(path, map) result(note)
    character(len=*), intent(in) :: path    !! the file; empty: standard output
    type(height_map), intent(in) :: map     !! map that is written
    character(len=:), allocatable :: note   !! one line of text

    note = ''
    if (.not. is_periodic(map)) return
    if (ending_of(path) == 'npy') note = 'an array (.npy)'
    if (ending_of(path) == 'sdf') note = 'surface data (.sdf)'
    if (note /= '') &
      note = path // ': note: ' // note // ' has no edge: give it as periodic where it is read'
  end function note_of_file

  ! The ending behind the last point, in small letters; text for standard output.
  pure function ending_of(path) result(ending)
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: ending

    ending = lower_case(path(index(path, '.', back=.true.) + 1:))
    if (path == '' .or. path == '/dev/stdout') ending = 'txt'
  end function ending_of

  ! The header, or a problem.
  subroutine make_header(path, map, head, problems)
    character(len=*), intent(in) :: path
    type(height_map), intent(in) :: map
    character(len=:), allocatable, intent(out) :: head
    type(problem_list), intent(inout) :: problems
    integer, parameter :: binary64 = 7
    real(real64) :: metres
    integer :: wide

    select case (ending_of(path))
    case ('sdf')
      if (map%unit == '') then
        call problems%add(path // ': found a map without a unit, expected one: lengths of ' // &
                          'surface data are metres')
      else if (.not. all(map%pixel_spacing > 0.0_real64)) then
        call problems%add(path // ': found a map without a spacing, expected one')
      else
        ! ISO 25178-71, binary, heights in the unit of the map, whose metres are the scale.
        metres = unit_ratio(map%unit, 1)
        wide = merge(2, 4, max(map%columns, map%rows) <= most_of_iso_1)
        head = 'bISO-' // merge('1.0', '2.0', wide == 2) // 'asperity  ' // repeat('0', 24) // &
               bytes_of(int(map%columns, int64), wide) // bytes_of(int(map%rows, int64), wide) // &
               double_bytes(map%pixel_spacing(1) * metres) // &
               double_bytes(map%pixel_spacing(2) * metres) // double_bytes(metres) // &
               double_bytes(-1.0_real64) // char(0) // char(binary64) // char(0)
      end if
    case ('npy')
      ! Version 1 of the format; the pixels begin at a multiple of 64 bytes.
      head = '{''descr'': ''<f8'', ''fortran_order'': False, ''shape'': (' // &
             decimal_text(map%rows) // ', ' // decimal_text(map%columns) // '), }'
      head = head // repeat(' ', modulo(-(len(head) + 11), 64)) // new_line('a')
      head = npy_magic // char(1) // char(0) // bytes_of(len(head, int64), 2) // head
    case ('txt')
      head = text_header(map)
    case default
      call problems%add(path // ': found another ending, expected .sdf, .npy or .txt')
    end select
  end subroutine make_header

  ! Writes header and heights to an open file, block by block.
  subroutine write_map(descriptor, ending, head, map, failure)
    integer(c_int), intent(in) :: descriptor
    character(len=*), intent(in) :: ending, head
    type(height_map), intent(in) :: map
    character(len=:), allocatable, intent(out) :: failure
    type(text_buffer) :: block
    integer :: column, row

    call block%append(head)
    do row = 1, map%rows
      do column = 1, map%columns
        call block%append(pixel_bytes(map%height(column, row)))
      end do
      if (ending == 'txt') call block%append(new_line('a'))
      if (block%used < block_size .and. row < map%rows) cycle
      call write_bytes(descriptor, block%store(:block%used), failure)
      if (allocated(failure)) return
      block%used = 0_int64
    end do

  contains

    pure function pixel_bytes(height) result(bytes)
      real(real64), intent(in) :: height
      character(len=:), allocatable :: bytes

      ! A missing pixel of surface data is the lowest number, here as there.
      if (ending == 'sdf' .or. (ending == 'npy' .and. is_measured(height))) then
        bytes = double_bytes(height)
      else if (ending == 'npy') then
        bytes = double_bytes(ieee_value(height, ieee_quiet_nan))
      else if (is_measured(height)) then
        bytes = real_text(height, 'es24.16e3') // ' '
      else
        bytes = 'NaN '
      end if
    end function pixel_bytes

  end subroutine write_map

  ! Comments of a matrix: what is to be given beside it where it is read.
  function text_header(map) result(head)
    type(height_map), intent(in) :: map
    character(len=:), allocatable :: head

    head = ''
    if (all(map%pixel_spacing > 0.0_real64)) &
      head = '# Spacing: ' // real_text(map%pixel_spacing(1), 'es24.16e3') // ' ' // &
             real_text(map%pixel_spacing(2), 'es24.16e3') // new_line('a')
    if (map%unit /= '') head = head // '# Units: ' // map%unit // new_line('a')
    if (is_periodic(map)) head = head // '# Edge: ' // edge_names(periodic_edge) // new_line('a')
  end function text_header

  ! Whether a map repeats itself.
  pure logical function is_periodic(map)
    type(height_map), intent(in) :: map

    is_periodic = map%periodic .or. map%edge == periodic_edge
  end function is_periodic

  ! The lowest byte first.
  pure character(len=8) function double_bytes(number) result(bytes)
    real(real64), intent(in) :: number

    bytes = bytes_of(transfer(number, 0_int64), 8)
  end function double_bytes

end module asperity_map_file
