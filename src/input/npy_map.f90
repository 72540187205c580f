!> Height maps as arrays of NumPy (.npy, versions 1 to 3): heights [row][column], x along a row.
!>
!> The header is a dictionary of Python with the type, the order and the shape of the array. An
!> array in Fortran order has its columns one behind the other; its indices mean the same. Format:
!> numpy.org/doc/stable/reference/generated/numpy.lib.format.html.
module asperity_npy_map
  use asperity_byte_reader, only: byte_reader, signed_bits, whole_bits
  use asperity_height_map, only: expected_height, height_map, highest, largest_height, make_room, &
                                 most_samples, no_height
  use asperity_input_text, only: blanks, in_quotes
  use asperity_kinds, only: int32, int64, real32, real64
  use asperity_problems, only: decimal_text, problem_list
  use asperity_progress, only: progress_line
  implicit none
  private

  public :: is_npy, npy_magic, read_npy_map

  character(len=*), parameter :: npy_magic = char(147) // 'NUMPY'  !! bytes that a file begins with
  ! NumPy reads no longer header either.
  integer, parameter :: longest_header = 10000
  integer, parameter :: block_pixels = 4096
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

  !> Whether a file begins like an array.
  pure logical function is_npy(head)
    character(len=*), intent(in) :: head  !! its first 8 bytes, or more

    is_npy = index(head, npy_magic) == 1
  end function is_npy

  !> Reads all pixels. `failure` is allocated when there is no memory for them.
  subroutine read_npy_map(file, magic, progress, map, problems, failure)
    class(byte_reader), intent(inout) :: file               !! behind its first 8 bytes
    character(len=*), intent(in) :: magic                   !! the first 8 bytes of the file
    logical, intent(in) :: progress                         !! report the progress
    type(height_map), intent(inout) :: map                  !! gets the pixels
    type(problem_list), intent(inout) :: problems           !! what is wrong
    character(len=:), allocatable, intent(out) :: failure   !! why there is no map
    type(npy_header) :: header
    character(len=:), allocatable :: text
    integer(int64) :: needed
    integer :: before

    before = problems%count()
    call take_header(file, magic, text, problems)
    if (problems%count() == before) call read_header(text, header, problems)
    if (problems%count() > before) return
    if (any(header%rows_columns > most_samples) .or. &
        product(min(header%rows_columns, most_samples)) > most_samples) then
      call problems%add_in_file('header: found ' // shape_text(header) // ', expected at most ' // &
                                decimal_text(most_samples) // ' pixels')
      return
    end if
    needed = product(header%rows_columns) * header%wide
    if (file%length >= 0_int64 .and. file%length - bytes_read(file) /= needed) then
      call problems%add_in_file('found ' // decimal_text(file%length - bytes_read(file)) // &
                                ' bytes behind the header, expected ' // decimal_text(needed) // &
                                ' for ' // shape_text(header) // ' of ' // &
                                decimal_text(header%wide) // ' bytes a pixel')
      return
    end if
    map%rows = int(header%rows_columns(1))
    map%columns = int(header%rows_columns(2))
    call make_room(map, failure)
    if (.not. allocated(failure)) call read_pixels(file, header, progress, map, problems)
    if (problems%count() > before .or. allocated(failure)) return
    ! A whole number counts; a real one is as good as its format.
    map%digit = 1.0_real64
    if (header%sample_kind == 'f') map%digit = spacing(largest_height(map))
    if (header%sample_kind == 'f' .and. header%wide == 4) &
      map%digit = real(spacing(real(largest_height(map), real32)), real64)
  end subroutine read_npy_map

  ! Bytes before the next one.
  pure integer(int64) function bytes_read(file)
    class(byte_reader), intent(in) :: file

    bytes_read = file%before + int(file%at, int64) - 1_int64
  end function bytes_read

  pure function shape_text(header) result(text)
    type(npy_header), intent(in) :: header
    character(len=:), allocatable :: text

    text = 'shape (' // decimal_text(header%rows_columns(1)) // ', ' // &
           decimal_text(header%rows_columns(2)) // ')'
  end function shape_text

  ! The text of the header, whose length is stated in two bytes of version 1, and in four later on.
  subroutine take_header(file, magic, text, problems)
    class(byte_reader), intent(inout) :: file
    character(len=*), intent(in) :: magic
    character(len=:), allocatable, intent(out) :: text
    type(problem_list), intent(inout) :: problems
    character(len=:), allocatable :: bytes
    integer(int64) :: length
    integer :: version

    version = 0
    if (len(magic) == 8) version = iachar(magic(7:7))
    if (version < 1 .or. version > 3) then
      call problems%add_in_file('byte 7, version of the array format: found ' // &
                                decimal_text(version) // ', expected 1, 2 or 3')
      return
    end if
    call file%take(merge(2, 4, version == 1), bytes)
    length = whole_bits(bytes)
    if (length > longest_header) then
      call problems%add_in_file('byte 9, length of the header: found ' // decimal_text(length) // &
                                ', expected at most ' // decimal_text(longest_header))
      return
    end if
    call file%take(int(length), text)
    if (len(text) < length .or. len(bytes) < merge(2, 4, version == 1)) &
      call problems%add_in_file('byte ' // decimal_text(bytes_read(file) + 1_int64) // &
                                ': the file ends in the header, expected ' // &
                                decimal_text(length) // ' bytes of it')
  end subroutine take_header

  ! Takes the dictionary apart: {'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }
  subroutine read_header(text, header, problems)
    character(len=*), intent(in) :: text
    type(npy_header), intent(out) :: header
    type(problem_list), intent(inout) :: problems
    character(len=*), parameter :: names(3) = [character(len=13) :: 'descr', 'fortran_order', &
                                               'shape']
    character(len=:), allocatable :: word
    integer :: at, before, name
    logical :: seen(3), good

    before = problems%count()
    seen = .false.
    at = 1
    call take_token(word)
    good = word == '{'
    do while (good)
      call take_token(word)
      if (word == '}') exit
      name = findloc(names == without_quotes(word), .true., 1)
      call take_token(word)
      good = name > 0 .and. word == ':'
      if (good) good = .not. seen(name)
      if (.not. good) exit
      seen(name) = .true.
      call take_token(word)
      select case (name)
      case (1)
        call take_type(without_quotes(word), header, problems)
      case (2)
        good = word == 'True' .or. word == 'False'
        header%by_columns = word == 'True'
      case default
        call take_shape(word, header, problems)
      end select
      if (problems%count() > before) return
      call take_token(word)
      if (word == '}') exit
      good = good .and. word == ','
    end do
    call take_token(word)
    if (good .and. all(seen) .and. word == '') return
    call problems%add_in_file('header: found ' // in_quotes(text(:min(len(text), 100))) // &
                              ', expected {''descr'': TYPE, ''fortran_order'': False or True, ' // &
                              '''shape'': (ROWS, COLUMNS)}')

  contains

    ! A sign, a text with its quotes, a word, or all from a bracket to the last one that closes.
    subroutine take_token(found)
      character(len=:), allocatable, intent(out) :: found
      character(len=*), parameter :: signs = '{}:,'
      integer :: last

      found = ''
      at = at - 1 + verify(text(at:) // '.', blanks)
      if (at > len(text)) return
      if (scan(text(at:at), '''"') == 1) then
        last = index(text(at + 1:), text(at:at)) + at
      else if (scan(text(at:at), '([') == 1) then
        last = scan(text(at:), ')]', back=.true.) + at - 1
      else if (scan(text(at:at), signs) == 1) then
        last = at
      else
        last = scan(text(at:) // ' ', blanks // signs) + at - 2
      end if
      last = max(last, at)
      found = text(at:last)
      at = last + 1
    end subroutine take_token

    pure function without_quotes(word) result(inner)
      character(len=*), intent(in) :: word
      character(len=:), allocatable :: inner

      inner = word
      if (len(word) < 2) return
      if (scan(word(1:1), '''"') == 1) inner = word(2:len(word) - 1)
    end function without_quotes

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

  ! The shape: two whole numbers in brackets.
  subroutine take_shape(word, header, problems)
    character(len=*), intent(in) :: word
    type(npy_header), intent(inout) :: header
    type(problem_list), intent(inout) :: problems
    character(len=*), parameter :: figures = '0123456789'
    integer :: at, digit_count, found

    found = 0
    at = scan(word, figures)
    do while (at > 0)
      digit_count = verify(word(at:) // '.', figures) - 1
      found = found + 1
      if (found <= 2) read (word(at:at + min(digit_count, 18) - 1), *) header%rows_columns(found)
      if (found <= 2 .and. digit_count > 18) header%rows_columns(found) = huge(header%rows_columns)
      at = at + digit_count
      if (scan(word(at:), figures) == 0) exit
      at = at - 1 + scan(word(at:), figures)
    end do
    if (found /= 2 .or. verify(word, figures // '(), L') > 0) &
      call problems%add_in_file('header: shape of the array: found ' // in_quotes(word) // &
                                ', expected (ROWS, COLUMNS)')
  end subroutine take_shape

  ! The pixels in the order of the file.
  subroutine read_pixels(file, header, progress, map, problems)
    class(byte_reader), intent(inout) :: file
    type(npy_header), intent(in) :: header
    logical, intent(in) :: progress
    type(height_map), intent(inout) :: map
    type(problem_list), intent(inout) :: problems
    type(progress_line) :: shown
    character(len=:), allocatable :: bytes
    real(real64) :: height
    integer :: lines, pixels, line, first, last, i, at, place(2)
    logical :: good

    lines = merge(map%columns, map%rows, header%by_columns)
    pixels = merge(map%rows, map%columns, header%by_columns)
    call shown%begin(progress, 'lines read', lines, 0)
    do line = 1, lines
      do first = 1, pixels, block_pixels
        last = min(pixels, first + block_pixels - 1)
        call file%take(header%wide * (last - first + 1), bytes)
        if (len(bytes) < header%wide * (last - first + 1)) then
          call problems%add_in_file('byte ' // decimal_text(bytes_read(file) + 1_int64) // &
                                    ': the file ends, expected ' // shape_text(header))
          return
        end if
        do i = first, last
          at = header%wide * (i - first)
          place = merge([line, i], [i, line], header%by_columns)
          call decode_pixel(bytes(at + 1:at + header%wide), header, height, good)
          map%height(place(1), place(2)) = height
          if (.not. good) &
            call problems%add_in_file('byte ' // &
                 decimal_text(bytes_read(file) - len(bytes, int64) + at + 1_int64) // &
                 ', pixel [' // decimal_text(place(2) - 1) // '][' // &
                 decimal_text(place(1) - 1) // ']: found an infinite or too large height, ' // &
                 'expected ' // expected_height)
        end do
      end do
      call shown%reach(line)
    end do
    call shown%finish()
    call file%take(1, bytes)
    if (len(bytes) > 0) &
      call problems%add_in_file('byte ' // decimal_text(bytes_read(file)) // &
                                ': found bytes behind ' // shape_text(header) // ', expected none')
  end subroutine read_pixels

  ! The height in the bytes of a pixel. NaN is a missing one.
  pure subroutine decode_pixel(bytes, header, height, good)
    character(len=*), intent(in) :: bytes
    type(npy_header), intent(in) :: header
    real(real64), intent(out) :: height
    logical, intent(out) :: good
    integer(int64) :: bits, top
    integer :: fraction_bits

    bits = whole_bits(bytes, header%big_endian)
    good = .true.
    height = no_height
    if (header%sample_kind == 'f') then
      fraction_bits = merge(23, 52, header%wide == 4)
      top = shiftl(1_int64, 8 * header%wide - 1 - fraction_bits) - 1_int64
      if (iand(shiftr(bits, fraction_bits), top) == top) then
        good = iand(bits, shiftl(1_int64, fraction_bits) - 1_int64) /= 0_int64
        return
      end if
      if (header%wide == 4) &
        height = real(transfer(int(signed_bits(bits, 32), int32), 1.0_real32), real64)
      if (header%wide == 8) height = transfer(bits, height)
    else if (header%sample_kind == 'i') then
      height = real(signed_bits(bits, 8 * header%wide), real64)
    else if (bits >= 0_int64) then
      height = real(bits, real64)
    else
      ! 2**63 or more: half the number; its last bit, kept, rounds as the number does.
      height = 2.0_real64 * real(ior(shiftr(bits, 1), iand(bits, 1_int64)), real64)
    end if
    good = abs(height) <= highest
  end subroutine decode_pixel

end module asperity_npy_map
