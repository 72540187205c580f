!> The header of a surface data file (ISO 25178-71), as text or as bytes.
!>
!> ISO-1.0, ISO-2.0, and BCR-1.0, the proposal before them, which Gwyddion writes as BCR-0.0. A
!> binary header has 81 bytes; ISO-2.0 counts samples in 4 bytes in place of 2, which makes 85. That
!> of Olympus has 8 more, the whole numbers 5 and 1.
module asperity_sdf_header
  use asperity_byte_reader, only: finite, not_a_number, whole_bits
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_delimited_text, only: line_reader
  use asperity_height_map, only: expected_length, is_length
  use asperity_input_text, only: lower_case, in_quotes, without_blanks
  use asperity_kinds, only: int64, real64
  use asperity_numeral, only: read_numeral, read_whole_number
  use asperity_problems, only: decimal_text, problem_list, real_text
  implicit none
  private

  public :: sdf_header, is_sdf, read_text_header, read_binary_header, add_at_record
  public :: bcr, magic_length, type_names, type_bytes, type_kinds

  !> Revisions.
  integer, parameter :: iso_1 = 1, iso_2 = 2, bcr = 3
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
    integer :: revision = 0                    !! one of `iso_1`, `iso_2`, `bcr`
    integer(int64) :: points = 0_int64         !! samples of a profile
    integer(int64) :: profiles = 0_int64       !! profiles
    real(real64) :: scale_factor(3) = 0.0_real64  !! metres: spacing along x and y; unit of height
    integer :: data_type = 0                   !! from 0 to 7
  end type sdf_header

  ! Fields that are read; ManufacID, dates and Zresolution do not matter to heights.
  character(len=*), parameter :: fields(8) = [character(len=11) :: 'NumPoints', 'NumProfiles', &
    'Xscale', 'Yscale', 'Zscale', 'DataType', 'Compression', 'CheckType']
  integer, parameter :: needed_fields = 6, type_field = 6

contains

  !> Whether a file begins like one of this kind.
  pure logical function is_sdf(magic)
    character(len=*), intent(in) :: magic  !! its first 8 bytes

    is_sdf = .false.
    if (len(magic) < magic_length) return
    is_sdf = scan(magic(1:1), 'abAB') == 1 .and. magic(5:5) == '-' .and. &
             (magic(2:4) == 'ISO' .or. magic(2:4) == 'BCR')
  end function is_sdf

  !> Takes the first bytes apart.
  subroutine read_magic(magic, header, problems)
    character(len=*), intent(in) :: magic
    type(sdf_header), intent(out) :: header
    type(problem_list), intent(inout) :: problems

    header%binary = lower_case(magic(1:1)) == 'b'
    header%revision = min(bcr, findloc(revisions == magic(2:magic_length), .true., 1))
    if (header%revision == 0) &
      call problems%add_at(1, 1, 'unknown revision: found ' // in_quotes(magic) // &
                           ', expected ISO-1.0, ISO-2.0, BCR-1.0 or BCR-0.0 behind a or b')
  end subroutine read_magic

  !> Reads the header of a text, up to the line of one asterisk.
  subroutine read_text_header(file, magic, header, problems)
    type(line_reader), intent(inout) :: file        !! behind the first 8 bytes; left at the data
    character(len=*), intent(in) :: magic            !! the first 8 bytes of the file
    type(sdf_header), intent(out) :: header          !! what it says
    type(problem_list), intent(inout) :: problems    !! what is wrong
    character(len=:), allocatable :: text
    integer :: line, column, equals, first, last, i
    logical :: seen(size(fields))

    call read_magic(magic, header, problems)
    seen = .false.
    call file%begin_lines()
    call file%next_line(text, line, column)
    if (allocated(text)) then
      call cut_comment(header, text)
      if (len_trim(text) > 0) &
        call problems%add_at(1, magic_length + 1, 'found ' // in_quotes(trim(text)) // &
                             ', expected the end of the line')
    end if
    do
      call file%next_line(text, line, column)
      if (.not. allocated(text)) then
        call problems%add_at(line, column, 'the file ends in the header, expected a line with ' // &
                             'one asterisk, and pixels')
        return
      end if
      call cut_comment(header, text)
      first = verify(text, ' ' // achar(9))
      if (first == 0) cycle
      last = verify(text, ' ' // achar(9), back=.true.)
      if (text(first:last) == '*') exit
      equals = index(text, '=')
      ! Some write a blank in its place.
      if (equals == 0 .and. lower_case(text(first:first)) >= 'a' .and. &
          lower_case(text(first:first)) <= 'z' .and. scan(text(first:last), ' ' // achar(9)) > 0) &
        equals = first + scan(text(first:last), ' ' // achar(9)) - 1
      if (equals == 0) then
        call problems%add_at(line, first, 'found ' // in_quotes(text(first:last)) // &
                             ', expected NAME = VALUE, or one asterisk')
        cycle
      end if
      do i = size(fields), 1, -1
        if (lower_case(fields(i)) == lower_case(without_blanks(text(:equals - 1)))) exit
      end do
      if (i == 0) cycle
      if (seen(i)) call problems%add_at(line, first, trim(fields(i)) // &
                                        ' occurs twice, expected once')
      seen(i) = .true.
      first = equals + verify(text(equals + 1:) // '.', ' ' // achar(9))
      call take_field(i, text(first:max(last, first - 1)), line, first, header, problems)
    end do
    do i = 1, needed_fields
      if (.not. seen(i)) call problems%add_at(line, 1, 'the header ends without ' // &
                                              trim(fields(i)) // ', expected it')
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
    type(decimal_value) :: decimal
    real(real64) :: value
    integer :: whole
    logical :: good

    if (field >= 3 .and. field < type_field) then
      call read_numeral(text, decimal, good)
      value = decimal_to_real64(decimal)
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
      good = value >= 1.0_real64
      if (field == 1) header%points = nint(value, int64)
      if (field == 2) header%profiles = nint(value, int64)
    case (3:5)
      good = is_length(value)
      header%scale_factor(field - 2) = value
    case (type_field)
      good = is_type(header, nint(value))
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
    if (field < 3) text = 'a whole number from 1'
    if (field /= type_field) return
    text = 'one of'
    do i = first_type(max(1, header%revision)), ubound(type_names, 1)
      text = text // ' ' // decimal_text(i) // ' (' // trim(type_names(i)) // ')'
    end do
  end function expected_value

  ! Whether a revision has a type of samples.
  pure logical function is_type(header, code)
    type(sdf_header), intent(in) :: header
    integer, intent(in) :: code

    is_type = code >= first_type(max(1, header%revision)) .and. code <= ubound(type_names, 1)
  end function is_type

  !> Reads the header of a binary file.
  subroutine read_binary_header(file, magic, header, problems)
    type(line_reader), intent(inout) :: file        !! behind the first 8 bytes; left at the data
    character(len=*), intent(in) :: magic            !! the first 8 bytes of the file
    type(sdf_header), intent(out) :: header          !! what it says
    type(problem_list), intent(inout) :: problems    !! what is wrong
    integer, parameter :: before_counts = 34, more_bytes = 8
    ! Fields in their order; 0 is Zresolution, which no result depends on.
    integer, parameter :: order(9) = [1, 2, 3, 4, 5, 0, 7, type_field, 8]
    character(len=:), allocatable :: bytes, found
    integer(int64) :: place
    real(real64) :: value(1)
    integer :: wide(9), class_of(1), got, i
    logical :: good

    call read_magic(magic, header, problems)
    if (problems%count() > 0) return
    wide = [2, 2, 8, 8, 8, 8, 1, 1, 1]
    if (header%revision == iso_2) wide(:2) = 4
    call file%take(before_counts, bytes)
    do i = 1, size(order)
      place = file%next_byte()
      call file%take_numbers(merge('f', 'u', wide(i) == 8), wide(i), value, class_of, got)
      if (got == 0) then
        call add_at_record(problems, file%next_byte(), 1, 'the file ends in the header, ' // &
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
      call add_at_record(problems, place, 1, trim(fields(order(i))) // ': found ' // found // &
                         ', expected ' // expected_value(header, order(i)))
    end do
    if (problems%count() > 0) return
    ! So many bytes too many, and these: they are of the header.
    place = file%next_byte()
    if (file%count_bytes() - place + 1_int64 - more_bytes /= &
        header%points * header%profiles * type_bytes(header%data_type)) return
    call file%take(more_bytes, bytes)
    if (whole_bits(bytes(:4)) == 5_int64 .and. whole_bits(bytes(5:)) == 1_int64) return
    call file%rewind()
    call file%take(int(place) - 1, bytes)
  end subroutine read_binary_header

  !> Adds a problem at a byte of a binary file.
  pure subroutine add_at_record(problems, byte, record, message)
    type(problem_list), intent(inout) :: problems  !! list that gets the problem
    integer(int64), intent(in) :: byte             !! number of the byte, from 1
    integer, intent(in) :: record                  !! 1 the header, 2 the data
    character(len=*), intent(in) :: message        !! what is wrong, found, expected

    call problems%add_in_file('byte ' // decimal_text(byte) // ', record ' // &
                              decimal_text(record) // ': ' // message)
  end subroutine add_at_record

end module asperity_sdf_header
