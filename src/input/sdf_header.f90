!> The header of a surface data file (ISO 25178-71), as text or as bytes.
!>
!> ISO-1.0, ISO-2.0, and BCR-1.0, the proposal before them, which Gwyddion writes as BCR-0.0. A
!> binary header has 81 bytes; ISO-2.0 counts samples in 4 bytes in place of 2, which makes 85. That
!> of Olympus has 8 more, the whole numbers 5 and 1.
module asperity_sdf_header
  use asperity_byte_reader, only: whole_bits
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_delimited_text, only: line_reader
  use asperity_height_map, only: expected_length, is_length
  use asperity_input_text, only: lower_case, in_quotes, without_blanks
  use asperity_kinds, only: int64, real64
  use asperity_numeral, only: read_numeral, read_whole_number
  use asperity_problems, only: decimal_text, problem_list
  implicit none
  private

  public :: sdf_header, is_sdf, read_text_header, read_binary_header, add_at_record
  public :: iso_1, iso_2, bcr, magic_length, type_names, type_bytes

  !> Revisions.
  integer, parameter :: iso_1 = 1, iso_2 = 2, bcr = 3
  character(len=*), parameter :: revisions(4) = ['ISO-1.0', 'ISO-2.0', 'BCR-1.0', 'BCR-0.0']
  integer, parameter :: magic_length = 8  !! bytes that a file begins with
  !> Types of the samples, by their code.
  character(len=*), parameter :: type_names(0:7) = [character(len=8) :: 'UINT8', 'UINT16', &
    'UINT32', 'BINARY32', 'INT8', 'INT16', 'INT32', 'BINARY64']
  integer, parameter :: type_bytes(0:7) = [1, 2, 4, 4, 1, 2, 4, 8]  !! bytes of a sample
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
  integer(int64), parameter :: low_52 = int(z'FFFFFFFFFFFFF', int64)

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

  ! One value of the header.
  subroutine take_field(field, value, line, column, header, problems)
    integer, intent(in) :: field, line, column
    character(len=*), intent(in) :: value
    type(sdf_header), intent(inout) :: header
    type(problem_list), intent(inout) :: problems
    type(decimal_value) :: decimal
    character(len=:), allocatable :: expected
    integer :: whole
    logical :: good

    select case (field)
    case (1, 2)
      expected = 'a whole number from 1'
      call read_whole_number(value, whole, good)
      good = good .and. whole > 0
      if (field == 1) header%points = int(whole, int64)
      if (field == 2) header%profiles = int(whole, int64)
    case (3:5)
      expected = expected_length
      call read_numeral(value, decimal, good)
      header%scale_factor(field - 2) = decimal_to_real64(decimal)
      good = good .and. is_length(header%scale_factor(field - 2))
    case (type_field)
      call read_whole_number(value, whole, good)
      if (.not. good .and. header%revision == bcr) then
        whole = findloc(bcr_words == lower_case(value), .true., 1) - 1
        good = whole >= 0
      end if
      expected = expected_type(header)
      good = good .and. is_type(header, whole)
      if (good) header%data_type = whole
    case default
      expected = '0: neither compression nor checks are read'
      call read_whole_number(value, whole, good)
      if (good) good = whole == 0
      if (header%revision == bcr) &
        good = good .or. lower_case(value) == 'null' .or. lower_case(value) == 'none'
    end select
    if (.not. good) call problems%add_at(line, column, trim(fields(field)) // ': found ' // &
                                         in_quotes(value) // ', expected ' // expected)
  end subroutine take_field

  ! Whether a revision has a type of samples.
  pure logical function is_type(header, code)
    type(sdf_header), intent(in) :: header
    integer, intent(in) :: code

    is_type = code >= first_type(max(1, header%revision)) .and. code <= ubound(type_names, 1)
  end function is_type

  pure function expected_type(header) result(text)
    type(sdf_header), intent(in) :: header
    character(len=:), allocatable :: text
    integer :: i

    text = 'one of'
    do i = first_type(max(1, header%revision)), ubound(type_names, 1)
      text = text // ' ' // decimal_text(i) // ' (' // trim(type_names(i)) // ')'
    end do
  end function expected_type

  !> Reads the header of a binary file.
  subroutine read_binary_header(file, magic, header, problems)
    type(line_reader), intent(inout) :: file        !! behind the first 8 bytes; left at the data
    character(len=*), intent(in) :: magic            !! the first 8 bytes of the file
    type(sdf_header), intent(out) :: header          !! what it says
    type(problem_list), intent(inout) :: problems    !! what is wrong
    integer, parameter :: before_counts = 34, behind_counts = 35, more_bytes = 8
    character(len=:), allocatable :: bytes
    integer(int64) :: bits
    integer :: wide, at, i, code

    call read_magic(magic, header, problems)
    if (problems%count() > 0) return
    wide = merge(4, 2, header%revision == iso_2)
    at = before_counts + 2 * wide + behind_counts
    call file%take(at, bytes)
    if (len(bytes) < at) then
      call add_at_record(problems, int(magic_length + len(bytes) + 1, int64), 1, &
                         'the file ends in the header, expected ' // &
                         decimal_text(magic_length + at) // ' bytes of it')
      return
    end if
    at = before_counts
    do i = 1, 2
      bits = whole_bits(bytes(at + 1:at + wide))
      if (i == 1) header%points = bits
      if (i == 2) header%profiles = bits
      if (bits == 0_int64) call refuse_value(fields(i), '0', 'a whole number from 1')
      at = at + wide
    end do
    do i = 1, 3
      bits = whole_bits(bytes(at + 1:at + 8))
      ! Infinite numbers and those that are none stay 0.
      if (iand(shiftr(bits, 52), 2047_int64) < 2047_int64) &
        header%scale_factor(i) = transfer(bits, header%scale_factor(i))
      if (.not. is_length(header%scale_factor(i))) &
        call refuse_value(fields(i + 2), float_text(bits), expected_length)
      at = at + 8
    end do
    ! Zresolution is skipped: no result depends on it.
    at = at + 8
    do i = 1, 3
      code = iachar(bytes(at + 1:at + 1))
      if (i == 2) then
        header%data_type = code
        if (.not. is_type(header, code)) &
          call refuse_value('DataType', decimal_text(code), expected_type(header))
      else if (code /= 0) then
        call refuse_value(fields(merge(7, 8, i == 1)), decimal_text(code), &
                   '0: neither compression nor checks are read')
      end if
      at = at + 1
    end do
    if (problems%count() > 0) return
    ! So many bytes too many, and these: they are of the header.
    if (file%count_bytes() - (magic_length + at + more_bytes) /= &
        header%points * header%profiles * type_bytes(header%data_type)) return
    call file%take(more_bytes, bytes)
    if (whole_bits(bytes(:4)) == 5_int64 .and. whole_bits(bytes(5:)) == 1_int64) return
    call file%rewind()
    call file%take(magic_length + at, bytes)

  contains

    subroutine refuse_value(field, found, expected)
      character(len=*), intent(in) :: field, found, expected

      call add_at_record(problems, int(magic_length + at + 1, int64), 1, trim(field) // &
                         ': found ' // found // ', expected ' // expected)
    end subroutine refuse_value

  end subroutine read_binary_header

  ! A number for a message, by its bits.
  pure function float_text(bits) result(text)
    integer(int64), intent(in) :: bits
    character(len=:), allocatable :: text
    character(len=24) :: number_text

    if (iand(shiftr(bits, 52), 2047_int64) == 2047_int64) then
      text = 'NaN'
      if (iand(bits, low_52) == 0_int64) text = 'an infinite number'
    else
      write (number_text, '(es16.8e3)') transfer(bits, 1.0_real64)
      text = trim(adjustl(number_text))
    end if
  end function float_text

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
