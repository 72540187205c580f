!> Surface data files (ISO 25178-71), as text or as bytes.
!>
!> ISO-1.0, ISO-2.0, and BCR-1.0, the proposal before them, which Gwyddion writes as BCR-0.0. A
!> binary header has 81 bytes; ISO-2.0 counts samples in 4 bytes in place of 2, which makes 85. That
!> of Olympus has 8 more, the whole numbers 5 and 1.
!>
!> A missing sample is the word `BAD` or the number that its type reserves: the lowest, in BCR-1.0
!> the highest (for a float all from 3.4E38 or 1.7E308 on). In BCR-1.0, which fixes no direction,
!> the first profile is that of the largest y, as other programs have it. Bytes behind the pixels
!> are text of the maker, which is noted, or refused: the header may be longer than it should be.
module asperity_sdf_map
  use asperity_byte_reader, only: above_all, finite, not_a_number, whole_bits
  use asperity_delimited_text, only: column_of, line_cells, line_reader
  use asperity_height_map, only: digit_of, expected_length, height_map, highest, is_length, &
                                 is_measured, largest_height, length_units, longest_side, &
                                 make_room, no_height, no_power, read_height, unit_ratio
  use asperity_input_text, only: blanks, in_quotes, lower_case, without_blanks
  use asperity_kinds, only: int64, real32, real64
  use asperity_numeral, only: read_number, read_whole_number
  use asperity_problems, only: decimal_text, problem_list, real_text
  use asperity_progress, only: progress_line
  implicit none
  private

  public :: sdf_header, is_sdf, read_sdf_header, read_sdf_samples, magic_length

  !> Revisions, from ISO-1.0 on.
  integer, parameter :: iso_2 = 2, bcr = 3
  character(len=*), parameter :: revisions(4) = ['ISO-1.0', 'ISO-2.0', 'BCR-1.0', 'BCR-0.0']
  integer, parameter :: magic_length = 8  !! bytes that a file begins with
  !> Types of the samples, by their code.
  character(len=*), parameter :: type_names(0:7) = [character(len=8) :: 'UINT8', 'UINT16', &
    'UINT32', 'BINARY32', 'INT8', 'INT16', 'INT32', 'BINARY64']
  integer, parameter :: type_bytes(0:7) = [1, 2, 4, 4, 1, 2, 4, 8]  !! bytes of a sample
  character(len=*), parameter :: type_kinds(0:7) = ['u', 'u', 'u', 'f', 'i', 'i', 'i', 'f'] !! signs
  ! The words that BCR-1.0 allows in their place.
  character(len=*), parameter :: bcr_words(0:7) = [character(len=8) :: 'uchar', 'uinteger', &
    'ulongint', 'float', 'char', 'integer', 'longint', 'double']
  ! The first type of each revision; it has all from there on.
  integer, parameter :: first_type(3) = [5, 3, 0]

  !> Values of the header.
  type :: sdf_header
    logical :: binary = .false.                !! samples are bytes, not words
    integer :: revision = 0                    !! 1, `iso_2` or `bcr`
    integer(int64) :: points = 0_int64         !! samples of a profile
    integer(int64) :: profiles = 0_int64       !! profiles
    real(real64) :: scale_factor(3) = 0.0_real64  !! metres: spacing along x and y; unit of height
    integer :: data_type = 0                   !! from 0 to 7
  end type sdf_header

  ! Fields that are read; ManufacID, dates and Zresolution do not matter to heights.
  character(len=*), parameter :: fields(8) = [character(len=11) :: 'NumPoints', 'NumProfiles', &
    'Xscale', 'Yscale', 'Zscale', 'DataType', 'Compression', 'CheckType']
  integer, parameter :: needed_fields = 6, type_field = 6

  integer, parameter :: binary32 = 3, binary64 = 7
  ! Text behind the pixels of a binary file has fewer bytes.
  integer, parameter :: longest_text = 1000000

contains

  !> Whether a file begins like one of this kind.
  pure logical function is_sdf(magic)
    character(len=*), intent(in) :: magic  !! its first 8 bytes

    is_sdf = .false.
    if (len(magic) < magic_length) return
    is_sdf = scan(magic(1:1), 'abAB') == 1 .and. magic(5:5) == '-' .and. &
             (magic(2:4) == 'ISO' .or. magic(2:4) == 'BCR')
  end function is_sdf

  !> Reads the header of a text or of a binary file.
  subroutine read_sdf_header(file, magic, header)
    type(line_reader), intent(inout) :: file   !! behind the first 8 bytes; left at the data
    character(len=*), intent(in) :: magic      !! the first 8 bytes of the file
    type(sdf_header), intent(out) :: header    !! what it says

    header%binary = lower_case(magic(1:1)) == 'b'
    header%revision = min(bcr, findloc(revisions == magic(2:magic_length), .true., 1))
    if (header%revision == 0) &
      call file%problems%add_at(1, 1, 'unknown revision: found ' // in_quotes(magic) // &
                                ', expected ISO-1.0, ISO-2.0, BCR-1.0 or BCR-0.0 behind a or b')
    if (.not. header%binary) call read_text_header(file, header)
    if (header%binary .and. header%revision > 0) call read_binary_header(file, header)
  end subroutine read_sdf_header

  ! Reads the header of a text, up to the line of one asterisk.
  subroutine read_text_header(file, header)
    type(line_reader), intent(inout) :: file
    type(sdf_header), intent(inout) :: header
    character(len=*), parameter :: gaps = ' ' // achar(9)
    character(len=:), allocatable :: text
    integer :: line, column, equals, first, last, i
    logical :: seen(size(fields))

    seen = .false.
    call file%begin_lines()
    call file%next_line(text, line, column)
    if (allocated(text)) then
      call cut_comment(header, text)
      if (len_trim(text) > 0) &
        call file%problems%add_at(1, magic_length + 1, 'found ' // in_quotes(trim(text)) // &
                                  ', expected the end of the line')
    end if
    do
      call file%next_line(text, line, column)
      if (.not. allocated(text)) then
        call file%problems%add_at(line, column, 'the file ends in the header, expected a line ' // &
                                  'with one asterisk, and pixels')
        return
      end if
      call cut_comment(header, text)
      first = verify(text, gaps)
      if (first == 0) cycle
      last = verify(text, gaps, back=.true.)
      if (text(first:last) == '*') exit
      equals = index(text, '=')
      ! Some write a blank in its place.
      if (equals == 0 .and. lower_case(text(first:first)) >= 'a' .and. &
          lower_case(text(first:first)) <= 'z' .and. scan(text(first:last), gaps) > 0) &
        equals = first + scan(text(first:last), gaps) - 1
      if (equals == 0) then
        call file%problems%add_at(line, first, 'found ' // in_quotes(text(first:last)) // &
                                  ', expected NAME = VALUE, or one asterisk')
        cycle
      end if
      do i = size(fields), 1, -1
        if (lower_case(fields(i)) == lower_case(without_blanks(text(:equals - 1)))) exit
      end do
      if (i == 0) cycle
      if (seen(i)) &
        call file%problems%add_at(line, first, trim(fields(i)) // ' occurs twice, expected once')
      seen(i) = .true.
      first = equals + verify(text(equals + 1:) // '.', gaps)
      call take_field(i, text(first:max(last, first - 1)), line, first, header, file%problems)
    end do
    do i = 1, needed_fields
      if (.not. seen(i)) &
        call file%problems%add_at(line, 1, 'the header ends without ' // trim(fields(i)) // &
                                  ', expected it')
    end do
  end subroutine read_text_header

  ! In BCR-1.0 a semicolon begins a comment.
  pure subroutine cut_comment(header, text)
    type(sdf_header), intent(in) :: header
    character(len=:), allocatable, intent(inout) :: text

    if (header%revision == bcr .and. index(text, ';') > 0) text = text(:index(text, ';') - 1)
  end subroutine cut_comment

  ! One value of the header of a text.
  subroutine take_field(field, text, line, column, header, problems)
    integer, intent(in) :: field, line, column
    character(len=*), intent(in) :: text
    type(sdf_header), intent(inout) :: header
    type(problem_list), intent(inout) :: problems
    real(real64) :: value
    integer :: whole
    logical :: good

    if (field >= 3 .and. field < type_field) then
      call read_number(text, value, good)
    else
      call read_whole_number(text, whole, good)
      if (header%revision == bcr .and. .not. good) then
        if (field == type_field) whole = findloc(bcr_words == lower_case(text), .true., 1) - 1
        good = whole >= 0 .and. (field == type_field .or. any(lower_case(text) == ['null', 'none']))
      end if
      value = real(whole, real64)
    end if
    if (good) call set_field(header, field, value, good)
    if (.not. good) call problems%add_at(line, column, trim(fields(field)) // ': found ' // &
                                         in_quotes(text) // ', expected ' // &
                                         expected_value(header, field))
  end subroutine take_field

  ! Sets a value of the header, unless it is not a good one.
  pure subroutine set_field(header, field, value, good)
    type(sdf_header), intent(inout) :: header
    integer, intent(in) :: field
    real(real64), intent(in) :: value
    logical, intent(out) :: good

    select case (field)
    case (1, 2)
      good = value >= 1.0_real64 .and. value <= real(longest_side, real64)
      if (field == 1) header%points = nint(value, int64)
      if (field == 2) header%profiles = nint(value, int64)
    case (3:5)
      good = is_length(value)
      header%scale_factor(field - 2) = value
    case (type_field)
      good = nint(value) >= first_type(max(1, header%revision)) .and. &
             nint(value) <= ubound(type_names, 1)
      if (good) header%data_type = nint(value)
    case default
      good = abs(value) <= 0.0_real64
    end select
  end subroutine set_field

  ! Values that a field may have, for a message.
  pure function expected_value(header, field) result(text)
    type(sdf_header), intent(in) :: header
    integer, intent(in) :: field
    character(len=:), allocatable :: text
    integer :: i

    text = '0: neither compression nor checks are read'
    if (field < type_field) text = expected_length
    if (field < 3) text = 'a whole number from 1 to ' // decimal_text(longest_side)
    if (field /= type_field) return
    text = 'one of'
    do i = first_type(max(1, header%revision)), ubound(type_names, 1)
      text = text // ' ' // decimal_text(i) // ' (' // trim(type_names(i)) // ')'
    end do
  end function expected_value

  ! Reads the header of a binary file.
  subroutine read_binary_header(file, header)
    type(line_reader), intent(inout) :: file
    type(sdf_header), intent(inout) :: header
    integer, parameter :: before_counts = 34, more_bytes = 8
    ! Fields in their order; 0 is Zresolution, which no result depends on.
    integer, parameter :: order(9) = [1, 2, 3, 4, 5, 0, 7, type_field, 8]
    character(len=:), allocatable :: bytes, found
    integer(int64) :: place
    real(real64) :: value(1)
    integer :: wide(9), class_of(1), got, i
    logical :: good

    wide = [2, 2, 8, 8, 8, 8, 1, 1, 1]
    if (header%revision == iso_2) wide(:2) = 4
    call file%take(before_counts, bytes)
    do i = 1, size(order)
      place = file%next_byte()
      call file%take_numbers(merge('f', 'u', wide(i) == 8), wide(i), value, class_of, got)
      if (got == 0) then
        call file%refuse_byte(file%next_byte(), ', record 1: the file ends in the header, ' // &
             'expected ' // decimal_text(magic_length + before_counts + sum(wide)) // &
             ' bytes of it')
        return
      end if
      if (order(i) == 0) cycle
      call set_field(header, order(i), value(1), good)
      if (good) cycle
      found = decimal_text(nint(value(1)))
      if (wide(i) == 8) found = real_text(value(1))
      if (class_of(1) /= finite) found = 'an infinite number'
      if (class_of(1) == not_a_number) found = 'NaN'
      call file%refuse_byte(place, ', record 1: ' // trim(fields(order(i))) // ': found ' // &
                            found // ', expected ' // expected_value(header, order(i)))
    end do
    if (file%problems%count() > 0) return
    ! So many bytes too many, and these: they are of the header.
    place = file%next_byte()
    if (file%count_bytes() - place + 1_int64 - more_bytes /= &
        header%points * header%profiles * type_bytes(header%data_type)) return
    call file%take(more_bytes, bytes)
    if (whole_bits(bytes(:4)) == 5_int64 .and. whole_bits(bytes(5:)) == 1_int64) return
    call file%rewind()
    call file%take(int(place) - 1, bytes)
  end subroutine read_binary_header

  !> Reads all pixels, unless there is no memory for them.
  subroutine read_sdf_samples(file, header, progress, map)
    type(line_reader), intent(inout) :: file      !! behind the header; gets what is wrong
    type(sdf_header), intent(inout) :: header     !! what it says
    logical, intent(in) :: progress               !! print the progress
    type(height_map), intent(inout) :: map        !! gets the pixels
    type(progress_line) :: shown
    real(real64) :: limit
    integer(int64) :: least, others
    integer :: i, unit

    ! A sample of a text takes two bytes at least.
    least = header%points * header%profiles * &
            merge(int(type_bytes(header%data_type), int64), 2_int64, header%binary)
    if (file%length >= 0_int64 .and. least > file%length - file%next_byte() + 1_int64) then
      call file%problems%add_in_file('found ' // decimal_text(file%length) // ' bytes, expected ' &
           // grid_text(header) // ' pixels of ' // trim(type_names(header%data_type)) // &
           ' as in the header, at least ' // decimal_text(least) // ' bytes behind it')
      return
    end if
    map%columns = int(header%points)
    map%rows = int(header%profiles)
    map%unit = 'm'
    map%metre_spacing = map%pixel_spacing
    ! Heights in a unit stay so: a conversion to metres would cost their last bit.
    unit = findloc([(abs(unit_ratio(length_units(i), 1) - header%scale_factor(3)) <= 0.0_real64, &
                     i=1, size(length_units))], .true., 1)
    if (unit > 1) then
      map%pixel_spacing = map%pixel_spacing * unit_ratio('m', unit)
      map%unit = trim(length_units(unit))
      header%scale_factor(3) = 1.0_real64
    end if
    call make_room(map, file%lack)
    if (allocated(file%lack)) return
    call shown%begin(progress, 'profiles read', map%rows, 0)
    if (header%binary) then
      call read_bytes(file, header, map, shown)
    else
      call read_words(file, header, map, shown)
    end if
    call shown%finish()
    map%digit = map%digit * header%scale_factor(3)
    if (file%problems%count() > 0 .or. scan(type_names(header%data_type), 'I') /= 1) return
    ! The least number of a whole type with sign where the largest is reserved, or the other way.
    limit = 2.0_real64**(8 * type_bytes(header%data_type) - 1)
    limit = merge(-limit, limit - 1.0_real64, header%revision == bcr)
    others = count(abs(map%height - limit * header%scale_factor(3)) <= 0.0_real64, kind=int64)
    if (others > 0_int64) &
      call map%notes%add_in_file('note: ' // decimal_text(others) // ' pixels are ' // &
           decimal_text(nint(limit, int64)) // ', which other programs take for missing; here ' // &
           'they are heights')
  end subroutine read_sdf_samples

  ! Points and profiles for a message.
  pure function grid_text(header) result(text)
    type(sdf_header), intent(in) :: header
    character(len=:), allocatable :: text

    text = decimal_text(header%points) // ' x ' // decimal_text(header%profiles)
  end function grid_text

  ! The row of a map where a profile of the file goes.
  pure integer function row_of(header, profile)
    type(sdf_header), intent(in) :: header
    integer, intent(in) :: profile

    row_of = profile
    if (header%revision == bcr) row_of = int(header%profiles) - profile + 1
  end function row_of

  ! Samples as bytes.
  subroutine read_bytes(file, header, map, shown)
    type(line_reader), intent(inout) :: file
    type(sdf_header), intent(in) :: header
    type(height_map), intent(inout) :: map
    type(progress_line), intent(inout) :: shown
    character(len=:), allocatable :: bytes
    integer(int64) :: place
    real(real64) :: values(map%columns), largest
    integer :: classes(map%columns), i, got, profile, wide
    logical :: good

    wide = type_bytes(header%data_type)
    do profile = 1, map%rows
      place = file%next_byte()
      call file%take_numbers(type_kinds(header%data_type), wide, values, classes, got)
      if (got < map%columns) then
        call file%refuse_byte(file%next_byte(), ', record 2: the file ends in profile ' // &
                              decimal_text(profile) // ', expected ' // decimal_text(map%rows) // &
                              ' profiles of ' // decimal_text(map%columns) // ' pixels')
        return
      end if
      do i = 1, map%columns
        call take_sample(header, values(i), good)
        if (classes(i) /= finite) then
          values(i) = no_height
          good = classes(i) == not_a_number .or. &
                 (classes(i) == above_all .and. header%revision == bcr)
        end if
        if (.not. good) &
          call file%refuse_byte(place + int(wide, int64) * (i - 1), ', record 2: pixel ' // &
                                decimal_text(i) // ' of profile ' // decimal_text(profile) // &
                                ': found an infinite or too large height, expected one up to 1e30')
      end do
      map%height(:, row_of(header, profile)) = values
      call shown%reach(profile)
    end do
    ! A whole number counts; a real one is as good as its format.
    map%digit = 1.0_real64
    largest = 0.0_real64
    if (file%problems%count() == 0) largest = largest_height(map) / header%scale_factor(3)
    if (header%data_type == binary32) map%digit = real(spacing(real(largest, real32)), real64)
    if (header%data_type == binary64) map%digit = spacing(largest)
    place = file%next_byte()
    call file%take(longest_text, bytes)
    if (len(bytes) == 0) return
    if (len(bytes) < longest_text .and. is_text(bytes)) then
      call map%notes%add_in_file('note: ' // decimal_text(len(bytes)) // ' bytes of text behind ' &
                                 // 'the pixels are not read')
    else
      call file%refuse_byte(place, ', record 2: bytes beyond header and pixels: found ' // &
                            decimal_text(file%count_bytes() - place + 1_int64) // ', expected ' // &
                            'none, or text; the header may be longer than the standard header')
    end if
  end subroutine read_bytes

  ! Whether bytes are text and no pixels: printable, a word of three letters, a line end behind the
  ! last one unless they are many.
  pure logical function is_text(bytes)
    character(len=*), intent(in) :: bytes
    integer, parameter :: many = 16
    integer :: i, letters
    logical :: word

    is_text = len(bytes) >= many .or. scan(bytes(len(bytes):), achar(10) // achar(13)) > 0
    word = .false.
    letters = 0
    do i = 1, len(bytes)
      is_text = is_text .and. iachar(bytes(i:i)) < 127 .and. &
                (iachar(bytes(i:i)) >= 32 .or. scan(bytes(i:i), blanks) > 0)
      letters = letters + 1
      if (lower_case(bytes(i:i)) < 'a' .or. lower_case(bytes(i:i)) > 'z') letters = 0
      word = word .or. letters == 3
    end do
    is_text = is_text .and. word
  end function is_text

  ! Whether a number stands for a missing sample. No sample of a text comes as near to it.
  pure logical function is_reserved(header, number)
    type(sdf_header), intent(in) :: header
    real(real64), intent(in) :: number
    real(real64), parameter :: lowest(0:7) = [0.0_real64, 0.0_real64, 0.0_real64, &
      -3.402823e38_real64, -128.0_real64, -32768.0_real64, -2147483648.0_real64, &
      -1.79769313486231e308_real64]
    real(real64), parameter :: highest_of(0:7) = [255.0_real64, 65535.0_real64, &
      4294967295.0_real64, 3.4e38_real64, 127.0_real64, 32767.0_real64, 2147483647.0_real64, &
      1.7e308_real64]
    real(real64) :: limit

    is_reserved = number <= lowest(header%data_type)
    if (header%revision /= bcr) return
    ! 3.4E38 as the bytes of a sample have it.
    limit = highest_of(header%data_type)
    if (header%data_type == binary32) limit = min(limit, real(real(limit, real32), real64))
    is_reserved = number >= limit
  end function is_reserved

  ! The number of a sample becomes its height.
  pure subroutine take_sample(header, height, good)
    type(sdf_header), intent(in) :: header
    real(real64), intent(inout) :: height
    logical, intent(out) :: good

    good = .true.
    if (is_reserved(header, height)) then
      height = no_height
    else
      good = abs(height) <= highest / max(1.0_real64, header%scale_factor(3))
      if (good) height = height * header%scale_factor(3)
    end if
  end subroutine take_sample

  ! Reads samples as words.
  subroutine read_words(file, header, map, shown)
    type(line_reader), intent(inout) :: file
    type(sdf_header), intent(in) :: header
    type(height_map), intent(inout) :: map
    type(progress_line), intent(inout) :: shown
    character(len=:), allocatable :: expected, word
    real(real64) :: height
    integer :: i, power, profile
    logical :: good, whole

    whole = header%data_type /= binary32 .and. header%data_type /= binary64
    expected = trim(merge('a whole number', 'a number      ', whole)) // &
               ', at most 1e30 as a height, or BAD'
    power = no_power
    file%cells = line_cells(' ', '', keep_empty=.false.)
    if (header%revision == bcr) file%cells%comment = ';'
    do profile = 1, map%rows
      do i = 1, map%columns
        call file%next_word(word)
        if (word == '' .or. word == '*') then
          call file%refuse_cell(file%cells%word, 'the pixels end behind ' // &
               decimal_text(int(profile - 1, int64) * map%columns + i - 1) // ', expected ' // &
               grid_text(header))
          return
        end if
        call read_height(word, height, good, power)
        if (whole .and. is_measured(height)) good = good .and. verify(word, '+-0123456789') == 0
        if (good .and. is_measured(height)) call take_sample(header, height, good)
        if (.not. good) &
          call file%refuse_cell(file%cells%word, 'found ' // in_quotes(word) // ', expected ' // &
                                expected)
        map%height(i, row_of(header, profile)) = height
      end do
      call shown%reach(profile)
    end do
    map%digit = digit_of(power)
    if (whole) map%digit = 1.0_real64
    call check_rest(file, header, map, word)
  end subroutine read_words

  ! Behind the last word of the pixels an asterisk may stand, and behind it text of the maker, no
  ! number.
  subroutine check_rest(file, header, map, last)
    type(line_reader), intent(inout) :: file
    type(sdf_header), intent(in) :: header
    type(height_map), intent(inout) :: map
    character(len=*), intent(in) :: last
    character(len=:), allocatable :: word
    real(real64) :: height
    integer :: power
    logical :: good

    associate (cells => file%cells)
      if (cells%last(cells%word) == len(file%lines) .and. file%problems%count() == 0) &
        call map%notes%add_at(cells%line, column_of(cells, cells%word), 'note: the file ends ' // &
             'right behind ' // in_quotes(last) // ', without a line end or an asterisk: is the ' &
             // 'number whole?')
      call file%next_word(word)
      if (word == '') return
      good = .false.
      do while (.not. good .and. word == '*')
        call file%next_word(word)
        if (word == '') return
        call read_height(word, height, good, power)
        if (good .or. word == '*') cycle
        call map%notes%add_at(cells%line, column_of(cells, cells%word), &
                              'note: text behind the pixels is not read')
        return
      end do
      call file%refuse_cell(cells%word, 'found ' // in_quotes(word) // ' behind ' // &
                            grid_text(header) // ' pixels, expected an asterisk, and no value ' // &
                            'behind it')
    end associate
  end subroutine check_rest

end module asperity_sdf_map
