!> The pixels of a surface data file (ISO 25178-71).
!>
!> A missing sample is the word `BAD` or the number that its type reserves: the lowest, in BCR-1.0
!> the highest (for a float all from 3.4E38 or 1.7E308 on). In BCR-1.0, which fixes no direction,
!> the first profile is that of the largest y, as other programs have it. Bytes behind the pixels
!> are text of the maker, which is noted, or refused: the header may be longer than it should be.
module asperity_sdf_samples
  use asperity_byte_reader, only: above_all, finite, not_a_number
  use asperity_delimited_text, only: column_of, line_cells, line_reader
  use asperity_height_map, only: digit_of, height_map, highest, is_measured, largest_height, &
                                 length_units, make_room, most_samples, &
                                 no_height, no_power, read_height, unit_ratio
  use asperity_input_text, only: blanks, lower_case, in_quotes
  use asperity_kinds, only: int64, real32, real64
  use asperity_problems, only: decimal_text, problem_list
  use asperity_progress, only: progress_line
  use asperity_sdf_header, only: add_at_record, bcr, sdf_header, type_bytes, type_kinds, &
                                 type_names
  use asperity_text_header, only: read_header, text_header
  implicit none
  private

  public :: read_sdf_samples

  integer, parameter :: binary32 = 3, binary64 = 7
  ! Text behind the pixels of a binary file has fewer bytes.
  integer, parameter :: longest_text = 1000000

contains

  !> Reads all pixels. `failure` is allocated when there is no memory for them.
  subroutine read_sdf_samples(file, header, progress, map, problems, failure)
    type(line_reader), intent(inout) :: file               !! behind the header
    type(sdf_header), intent(inout) :: header               !! what it says
    logical, intent(in) :: progress                         !! print the progress
    type(height_map), intent(inout) :: map                  !! gets the pixels
    type(problem_list), intent(inout) :: problems           !! what is wrong
    character(len=:), allocatable, intent(out) :: failure   !! reason that there is no memory; not
                                                            !! allocated: there is
    type(progress_line) :: shown
    integer(int64) :: least, others
    integer :: i, unit

    ! Here every count has at most 32 bits.
    least = header%points * header%profiles
    if (least > most_samples .or. least / header%points /= header%profiles) then
      call problems%add_in_file('found ' // decimal_text(header%points) // ' x ' // &
                                decimal_text(header%profiles) // ' pixels, expected at most ' // &
                                decimal_text(most_samples))
      return
    end if
    ! A sample of a text takes two bytes at least.
    least = least * merge(int(type_bytes(header%data_type), int64), 2_int64, header%binary)
    if (file%length >= 0_int64 .and. least > file%length - file%next_byte() + 1_int64) then
      call problems%add_in_file('found ' // decimal_text(file%length) // ' bytes, expected ' // &
                                decimal_text(header%points) // ' x ' // &
                                decimal_text(header%profiles) // ' pixels of ' // &
                                trim(type_names(header%data_type)) // &
                                ' as in the header, at least ' // decimal_text(least) // &
                                ' bytes behind it')
      return
    end if
    others = 0_int64
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
    call make_room(map, failure)
    if (allocated(failure)) return
    call shown%begin(progress, 'profiles read', map%rows, 0)
    if (header%binary) then
      call read_bytes(file, header, map, shown, others, problems)
    else
      call read_words(file, header, map, shown, others, problems)
    end if
    call shown%finish()
    if (others > 0_int64) &
      call map%notes%add_in_file('note: ' // decimal_text(others) // ' pixels are ' // &
           decimal_text(nint(other_limit(header), int64)) // ', which other programs take for ' // &
           'missing; here they are heights')
    map%digit = map%digit * header%scale_factor(3)
  end subroutine read_sdf_samples

  ! The row of a map where a profile of the file goes.
  pure integer function row_of(header, profile)
    type(sdf_header), intent(in) :: header
    integer, intent(in) :: profile

    row_of = profile
    if (header%revision == bcr) row_of = int(header%profiles) - profile + 1
  end function row_of

  ! Samples as bytes.
  subroutine read_bytes(file, header, map, shown, others, problems)
    type(line_reader), intent(inout) :: file
    type(sdf_header), intent(in) :: header
    type(height_map), intent(inout) :: map
    type(progress_line), intent(inout) :: shown
    integer(int64), intent(inout) :: others  ! pixels at the other limit of their type
    type(problem_list), intent(inout) :: problems
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
        call add_at_record(problems, file%next_byte(), 2, 'the file ends in profile ' // &
                           decimal_text(profile) // ', expected ' // decimal_text(map%rows) // &
                           ' profiles of ' // decimal_text(map%columns) // ' pixels')
        return
      end if
      do i = 1, map%columns
        call take_sample(header, values(i), others, good)
        if (classes(i) /= finite) then
          values(i) = no_height
          good = classes(i) == not_a_number .or. &
                 (classes(i) == above_all .and. header%revision == bcr)
        end if
        if (.not. good) &
          call add_at_record(problems, place + int(wide, int64) * (i - 1), 2, 'pixel ' // &
                             decimal_text(i) // ' of profile ' // decimal_text(profile) // &
                             ': found an infinite or too large height, expected one up to 1e30')
      end do
      map%height(:, row_of(header, profile)) = values
      call shown%reach(profile)
    end do
    ! A whole number counts; a real one is as good as its format.
    map%digit = 1.0_real64
    largest = 0.0_real64
    if (problems%count() == 0) largest = largest_height(map) / header%scale_factor(3)
    if (header%data_type == binary32) map%digit = real(spacing(real(largest, real32)), real64)
    if (header%data_type == binary64) map%digit = spacing(largest)
    place = file%next_byte()
    call file%take(longest_text, bytes)
    if (len(bytes) == 0) return
    if (is_own_text(bytes, map)) return
    if (len(bytes) < longest_text .and. is_text(bytes)) then
      call map%notes%add_in_file('note: ' // decimal_text(len(bytes)) // ' bytes of text behind ' &
                                 // 'the pixels are not read')
    else
      call add_at_record(problems, place, 2, 'bytes beyond header and pixels: found ' // &
                         decimal_text(file%count_bytes() - place + 1_int64) // ', expected none, ' &
                         // 'or text; the header may be longer than the standard header')
    end if
  end subroutine read_bytes

  ! Whether text behind the pixels is that of this program, as before a matrix: it keeps all bits of
  ! the spacing in the unit of the heights, and the edge.
  logical function is_own_text(bytes, map)
    character(len=*), intent(in) :: bytes
    type(height_map), intent(inout) :: map
    type(text_header) :: own
    type(problem_list) :: problems, notes
    character(len=:), allocatable :: line

    is_own_text = .false.
    if (index(bytes, '# Spacing:') /= 1) return
    call problems%start('')
    call notes%start('')
    call read_header(bytes, own, line, problems, notes)
    is_own_text = problems%count() + notes%count() + len(line) == 0 .and. &
      all(own%unit == map%unit) .and. &
      all(abs(own%pixel_spacing - map%pixel_spacing) <= 1.0e-12_real64 * map%pixel_spacing)
    if (.not. is_own_text) return
    map%pixel_spacing = own%pixel_spacing
    map%edge = own%edge
  end function is_own_text

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

  ! The least number of a whole type with sign where the largest is reserved, or the other way;
  ! others have a number that is no sample.
  pure real(real64) function other_limit(header)
    type(sdf_header), intent(in) :: header

    other_limit = huge(other_limit)
    if (all(type_names(header%data_type) /= ['INT8 ', 'INT16', 'INT32'])) return
    other_limit = 2.0_real64**(8 * type_bytes(header%data_type) - 1)
    other_limit = merge(-other_limit, other_limit - 1.0_real64, header%revision == bcr)
  end function other_limit

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

  ! The number of a sample becomes its height; `others` counts those at the other limit of their
  ! type.
  pure subroutine take_sample(header, height, others, good)
    type(sdf_header), intent(in) :: header
    real(real64), intent(inout) :: height
    integer(int64), intent(inout) :: others
    logical, intent(out) :: good

    good = .true.
    if (height <= other_limit(header) .and. height >= other_limit(header)) &
      others = others + 1_int64
    if (is_reserved(header, height)) then
      height = no_height
    else
      good = abs(height) <= highest / max(1.0_real64, header%scale_factor(3))
      if (good) height = height * header%scale_factor(3)
    end if
  end subroutine take_sample

  ! Long: all stages take words from the same line. Reads samples as words.
  subroutine read_words(file, header, map, shown, others, problems)
    type(line_reader), intent(inout) :: file
    type(sdf_header), intent(in) :: header
    type(height_map), intent(inout) :: map
    type(progress_line), intent(inout) :: shown
    integer(int64), intent(inout) :: others  ! pixels at the other limit of their type
    type(problem_list), intent(inout) :: problems
    type(line_cells) :: cells
    character(len=:), allocatable :: expected, grid, word
    real(real64) :: height
    integer :: i, power, profile
    logical :: good, whole

    whole = header%data_type /= binary32 .and. header%data_type /= binary64
    expected = merge('a whole number', 'a number      ', whole)
    expected = trim(expected) // ', at most 1e30 as a height, or BAD'
    grid = decimal_text(header%points) // ' x ' // decimal_text(header%profiles)
    power = no_power
    cells%separator = ' '
    cells%line_comments = ''
    cells%keep_empty = .false.
    if (header%revision == bcr) cells%comment = ';'
    do profile = 1, map%rows
      do i = 1, map%columns
        call file%next_word(cells, word)
        if (word == '' .or. word == '*') then
          call refuse_word('the pixels end behind ' // &
                      decimal_text(int(profile - 1, int64) * map%columns + i - 1) // &
                      ', expected ' // grid)
          return
        end if
        call read_height(word, height, good, power)
        if (whole .and. is_measured(height)) good = good .and. verify(word, '+-0123456789') == 0
        if (good .and. is_measured(height)) call take_sample(header, height, others, good)
        if (.not. good) call refuse_word('found ' // in_quotes(word) // ', expected ' // expected)
        map%height(i, row_of(header, profile)) = height
      end do
      call shown%reach(profile)
    end do
    map%digit = digit_of(power)
    if (whole) map%digit = 1.0_real64
    if (cells%last(cells%word) == len(file%lines) .and. problems%count() == 0) &
      call map%notes%add_at(cells%line, column_of(cells, cells%word), 'note: the file ends ' // &
                            'right behind ' // in_quotes(word) // ', without a line end or an ' // &
                            'asterisk: is the number whole?')
    call file%next_word(cells, word)
    if (word == '') return
    good = .false.
    ! Behind the asterisk stands text of the maker, no number.
    do while (.not. good .and. word == '*')
      call file%next_word(cells, word)
      if (word == '') return
      call read_height(word, height, good, power)
      if (good .or. word == '*') cycle
      call map%notes%add_at(cells%line, column_of(cells, cells%word), &
                            'note: text behind the pixels is not read')
      return
    end do
    call refuse_word('found ' // in_quotes(word) // ' behind ' // grid // &
                ' pixels, expected an asterisk, and no value behind it')

  contains

    ! Reports a problem at the word, or at the end of the file.
    subroutine refuse_word(message)
      character(len=*), intent(in) :: message

      call problems%add_at(cells%line, column_of(cells, cells%word), message)
    end subroutine refuse_word

  end subroutine read_words

end module asperity_sdf_samples
