!> Height maps as arrays of NumPy (.npy, versions 1 to 3): heights [row][column], x along a row.
!>
!> The header is a dictionary of Python with the type, the order and the shape of the array. An
!> array in Fortran order has its columns one behind the other; its indices mean the same. Format:
!> numpy.org/doc/stable/reference/generated/numpy.lib.format.html.
module asperity_npy_map
  use asperity_byte_reader, only: finite, not_a_number, whole_bits
  use asperity_delimited_text, only: cells_of, line_cells, line_reader
  use asperity_height_map, only: expected_height, height_map, highest, largest_height, &
                                 longest_side, make_room, no_height
  use asperity_input_text, only: in_quotes, without_blanks
  use asperity_kinds, only: int64, real32, real64
  use asperity_numeral, only: read_number
  use asperity_problems, only: decimal_text, problem_list
  use asperity_progress, only: progress_line
  implicit none
  private

  public :: npy_magic, read_npy_map

  character(len=*), parameter :: npy_magic = char(147) // 'NUMPY'  !! bytes that a file begins with
  ! NumPy reads no longer header either.
  integer, parameter :: longest_header = 10000
  character(len=*), parameter :: expected_types = &
    'float64 or float32 (f8, f4) or whole numbers (i1 to i8, u1 to u8)'

  !> Values of the header.
  type :: npy_header
    character(len=1) :: sample_kind = ' '  ! f, i or u
    integer :: wide = 0                   ! bytes of a pixel
    logical :: big_endian = .false.       ! the first byte is the most significant
    logical :: by_columns = .false.       ! Fortran order
    integer(int64) :: rows_columns(2) = 0_int64  ! rows, columns
  end type npy_header

contains

  !> Reads all pixels, unless there is no memory for them.
  subroutine read_npy_map(file, magic, progress, map)
    type(line_reader), intent(inout) :: file   !! behind its first 8 bytes; gets what is wrong
    character(len=*), intent(in) :: magic      !! the first 8 bytes of the file
    logical, intent(in) :: progress            !! report the progress
    type(height_map), intent(inout) :: map     !! gets the pixels
    type(npy_header) :: header
    character(len=:), allocatable :: text
    integer(int64) :: needed, found

    call take_header(file, magic, text)
    if (file%problems%count() == 0) call read_header(text, header, file%problems)
    if (file%problems%count() > 0) return
    if (any(header%rows_columns > longest_side)) then
      call file%problems%add_in_file('header: found ' // shape_text(header) // ', expected at ' // &
                                     'most ' // decimal_text(longest_side) // ' pixels a side')
      return
    end if
    needed = product(header%rows_columns) * header%wide
    found = file%length - file%next_byte() + 1_int64
    if (file%length >= 0_int64 .and. found /= needed) then
      call file%problems%add_in_file('found ' // decimal_text(found) // ' bytes behind the ' // &
           'header, expected ' // decimal_text(needed) // ' for ' // shape_text(header) // ' of ' &
           // decimal_text(header%wide) // ' bytes a pixel')
      return
    end if
    map%rows = int(header%rows_columns(1))
    map%columns = int(header%rows_columns(2))
    call make_room(map, file%lack)
    if (.not. allocated(file%lack)) call read_pixels(file, header, progress, map)
    if (file%is_refused()) return
    ! A whole number counts; a real one is as good as its format.
    map%digit = 1.0_real64
    if (header%sample_kind == 'f') map%digit = spacing(largest_height(map))
    if (header%sample_kind == 'f' .and. header%wide == 4) &
      map%digit = real(spacing(real(largest_height(map), real32)), real64)
  end subroutine read_npy_map

  pure function shape_text(header) result(text)
    type(npy_header), intent(in) :: header
    character(len=:), allocatable :: text

    text = 'shape (' // decimal_text(header%rows_columns(1)) // ', ' // &
           decimal_text(header%rows_columns(2)) // ')'
  end function shape_text

  ! The text of the header, whose length is stated in two bytes of version 1, and in four later on.
  subroutine take_header(file, magic, text)
    type(line_reader), intent(inout) :: file
    character(len=*), intent(in) :: magic
    character(len=:), allocatable, intent(out) :: text
    character(len=:), allocatable :: bytes
    integer(int64) :: length
    integer :: version

    version = 0
    if (len(magic) == 8) version = iachar(magic(7:7))
    if (version < 1 .or. version > 3) then
      call file%problems%add_in_file('byte 7, version of the array format: found ' // &
                                     decimal_text(version) // ', expected 1, 2 or 3')
      return
    end if
    call file%take(merge(2, 4, version == 1), bytes)
    length = whole_bits(bytes)
    if (length > longest_header) then
      call file%problems%add_in_file('byte 9, length of the header: found ' // &
           decimal_text(length) // ', expected at most ' // decimal_text(longest_header))
      return
    end if
    call file%take(int(length), text)
    if (len(text) < length .or. len(bytes) < merge(2, 4, version == 1)) &
      call file%refuse_byte(file%next_byte(), ': the file ends in the header, expected ' // &
                            decimal_text(length) // ' bytes of it')
  end subroutine take_header

  ! Takes the dictionary apart: {'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }
  subroutine read_header(text, header, problems)
    character(len=*), intent(in) :: text
    type(npy_header), intent(out) :: header
    type(problem_list), intent(inout) :: problems
    character(len=*), parameter :: names(3) = [character(len=13) :: 'descr', 'fortran_order', &
                                               'shape']
    character(len=:), allocatable :: rest, word
    integer :: i, before, name
    logical :: seen(0:3), good

    before = problems%count()
    rest = without_blanks(text)
    good = index(rest, '{') == 1
    seen = .false.
    do i = 1, size(names)
      call take_word(':', word)
      name = findloc(names == word, .true., 1)
      if (name == 0 .or. seen(name)) good = .false.
      call take_word(',}', word)
      if (.not. good) exit
      seen(name) = .true.
      select case (name)
      case (1)
        call take_type(word, header, problems)
      case (2)
        good = word == 'True' .or. word == 'False'
        header%by_columns = word == 'True'
      case default
        call take_shape(word, header, problems)
      end select
      if (problems%count() > before) return
    end do
    if (index(rest, ',') == 1) rest = without_blanks(rest(2:))
    if (good .and. rest == '}') return
    call problems%add_in_file('header: found ' // in_quotes(text(:min(len(text), 100))) // &
                              ', expected {''descr'': TYPE, ''fortran_order'': False or True, ' // &
                              '''shape'': (ROWS, COLUMNS)}')

  contains

    ! Takes what stands between the sign at hand and the next of some signs, without its quotes;
    ! from a bracket on all to the last one that closes.
    subroutine take_word(ends, found)
      character(len=*), intent(in) :: ends
      character(len=:), allocatable, intent(out) :: found
      integer :: last

      rest = without_blanks(rest(2:))
      last = max(0, scan(rest, ends) - 1)
      if (scan(rest, '([') == 1) last = scan(rest, ')]', back=.true.)
      found = without_blanks(rest(:last))
      rest = without_blanks(rest(last + 1:))
      good = good .and. scan(rest, ends) == 1
      if (len(found) > 1 .and. scan(found, '''"') == 1) found = found(2:len(found) - 1)
    end subroutine take_word

  end subroutine read_header

  ! The type of a pixel, for instance <f8: order of the bytes, kind, bytes.
  subroutine take_type(word, header, problems)
    character(len=*), intent(in) :: word
    type(npy_header), intent(inout) :: header
    type(problem_list), intent(inout) :: problems
    logical :: good

    good = len(word) == 3
    if (good) good = any(word(2:3) == ['f8', 'f4', 'i1', 'i2', 'i4', 'i8', 'u1', 'u2', 'u4', 'u8'])
    if (good) good = scan(word(1:1), '<>') == 1 .or. (word(1:1) == '|' .and. word(3:3) == '1')
    if (.not. good) then
      call problems%add_in_file('header: type of the array: found ' // in_quotes(word) // &
                                ', expected ' // expected_types)
      return
    end if
    header%big_endian = word(1:1) == '>'
    header%sample_kind = word(2:2)
    header%wide = iachar(word(3:3)) - iachar('0')
  end subroutine take_type

  ! The shape: two whole numbers in brackets, with L behind them in old files.
  subroutine take_shape(word, header, problems)
    character(len=*), intent(in) :: word
    type(npy_header), intent(inout) :: header
    type(problem_list), intent(inout) :: problems
    type(line_cells) :: cells
    real(real64) :: number
    integer :: i
    logical :: good

    cells = cells_of(' ' // word(2:len(word) - 1), ',', .false.)
    good = index(word, '(') == 1 .and. index(word, ')') == len(word) .and. cells%cell_count == 2
    do i = 1, 2
      if (.not. good) exit
      associate (last => cells%last(i))
        if (word(last:last) == 'L') last = last - 1
        good = verify(word(cells%first(i):last), '0123456789') == 0
        if (good) call read_number(word(cells%first(i):last), number, good)
      end associate
      header%rows_columns(i) = nint(min(number, 1.0e18_real64), int64)
    end do
    if (.not. good) &
      call problems%add_in_file('header: shape of the array: found ' // in_quotes(word) // &
                                ', expected (ROWS, COLUMNS)')
  end subroutine take_shape

  ! The pixels in the order of the file; NaN is a missing one.
  subroutine read_pixels(file, header, progress, map)
    type(line_reader), intent(inout) :: file
    type(npy_header), intent(in) :: header
    logical, intent(in) :: progress
    type(height_map), intent(inout) :: map
    type(progress_line) :: shown
    character(len=:), allocatable :: bytes
    real(real64), allocatable :: values(:)
    integer, allocatable :: classes(:)
    integer(int64) :: byte
    integer :: lines, pixels, line, i, got, place(2)

    lines = merge(map%columns, map%rows, header%by_columns)
    pixels = merge(map%rows, map%columns, header%by_columns)
    allocate (values(pixels), classes(pixels))
    call shown%begin(progress, 'lines read', lines, 0)
    do line = 1, lines
      byte = file%next_byte()
      call file%take_numbers(header%sample_kind, header%wide, values, classes, got, &
                             header%big_endian)
      if (got < pixels) then
        call file%refuse_byte(file%next_byte(), ': the file ends, expected ' // shape_text(header))
        return
      end if
      where (classes == not_a_number) values = no_height
      do i = 1, pixels
        place = merge([line, i], [i, line], header%by_columns)
        map%height(place(1), place(2)) = values(i)
        if (classes(i) == not_a_number .or. &
            (classes(i) == finite .and. abs(values(i)) <= highest)) cycle
        call file%refuse_byte(byte + int(header%wide, int64) * (i - 1), ', pixel [' // &
             decimal_text(place(2) - 1) // '][' // decimal_text(place(1) - 1) // &
             ']: found an infinite or too large height, expected ' // expected_height)
      end do
      call shown%reach(line)
    end do
    call shown%finish()
    byte = file%next_byte()
    call file%take(1, bytes)
    if (len(bytes) > 0) &
      call file%refuse_byte(byte, ': found bytes behind ' // shape_text(header) // &
           ', expected none')
  end subroutine read_pixels

end module asperity_npy_map
