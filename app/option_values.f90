!> The values of options: words in, checked values or problems out.
module asperity_option_values
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_height_map, only: expected_length, is_length, plain_unit
  use asperity_input_text, only: in_quotes
  use asperity_kinds, only: real64
  use asperity_numeral, only: read_numeral
  use asperity_problems, only: decimal_text, problem_list
  use asperity_word_hint, only: any_of, did_you_mean
  implicit none
  private

  public :: read_count, read_depths, read_positive, read_share, read_spacing, read_tables, read_word

contains

  !> A whole number from 1 to a largest one, whose digits are nines.
  subroutine read_count(option, value, most, number, problems)
    character(len=*), intent(in) :: option         !! whose value it is
    character(len=*), intent(in) :: value          !! value of the option, as given
    integer, intent(in) :: most                    !! largest number, for a message below a million
    real(real64), intent(inout) :: number          !! 0 when the word is no such number
    type(problem_list), intent(inout) :: problems  !! what is wrong
    character(len=:), allocatable :: range_text

    number = real(count_of(value, len(decimal_text(most))), real64)
    range_text = ''
    if (most < 1000000) range_text = ' to ' // decimal_text(most)
    if (.not. number > 0.0_real64) call problems%add(option // ': found ' // in_quotes(value) // &
                                                     ', expected a number from 1' // range_text)
  end subroutine read_count

  ! The whole number from 1 on that a word is, of so many digits at most; 0 when it is none.
  integer function count_of(word, most_digits)
    character(len=*), intent(in) :: word
    integer, intent(in) :: most_digits

    count_of = 0
    if (len(word) > 0 .and. len(word) <= most_digits .and. verify(word, '0123456789') == 0) &
      read (word, '(i9)') count_of
  end function count_of

  !> A part and how many there are: `I/N`.
  subroutine read_share(value, share, problems)
    character(len=*), intent(in) :: value          !! value of the option, as given
    integer, intent(inout) :: share(2)             !! as it was when the word is no such pair
    type(problem_list), intent(inout) :: problems  !! what is wrong
    integer :: found(2), slash

    slash = index(value, '/')
    found = [count_of(value(:slash - 1), 6), count_of(value(slash + 1:), 6)]
    if (found(1) >= 1 .and. found(1) <= found(2)) then
      share = found
      return
    end if
    call problems%add('--share: found ' // in_quotes(value) // &
                      ', expected I/N, part I of N, for instance 3/16')
  end subroutine read_share

  !> A number more than 0 and below a limit.
  subroutine read_positive(option, value, limit, expected, number, problems)
    character(len=*), intent(in) :: option         !! whose value it is
    character(len=*), intent(in) :: value          !! value of the option, as given
    real(real64), intent(in) :: limit              !! the number is less
    character(len=*), intent(in) :: expected       !! what is expected, for a message
    real(real64), intent(inout) :: number          !! 0 when the word is no such number
    type(problem_list), intent(inout) :: problems  !! what is wrong
    type(decimal_value) :: decimal
    logical :: good

    call read_numeral(value, decimal, good)
    number = decimal_to_real64(decimal)
    if (good .and. number > 0.0_real64 .and. number < limit) return
    number = 0.0_real64
    call problems%add(option // ': found ' // in_quotes(value) // ', expected ' // expected)
  end subroutine read_positive

  !> Depths more than 0: a list with commas, or the first, the last and the number of equal steps.
  subroutine read_depths(value, depths, problems)
    character(len=*), intent(in) :: value                     !! value of the option, as given
    real(real64), allocatable, intent(out) :: depths(:)       !! not allocated where they are not
    type(problem_list), intent(inout) :: problems             !! what is wrong
    type(decimal_value) :: decimal
    real(real64), allocatable :: numbers(:)
    character(len=1) :: mark
    integer :: end_of, from, i, number
    logical :: good

    mark = merge(':', ',', index(value, ':') > 0)
    allocate (numbers(0))
    from = 1
    good = .true.
    do while (good .and. from <= len(value) + 1)
      end_of = index(value(from:) // mark, mark) + from - 2
      call read_numeral(value(from:end_of), decimal, good)
      numbers = [numbers, decimal_to_real64(decimal)]
      good = good .and. numbers(size(numbers)) > 0.0_real64 .and. &
             numbers(size(numbers)) <= huge(1.0_real64)
      from = end_of + 2
    end do
    if (good .and. mark == ':') then
      good = size(numbers) == 3
      if (good) then
        number = count_of(value(index(value, ':', back=.true.) + 1:), 4)
        good = number >= 2 .and. numbers(1) < numbers(2)
        if (good) numbers = [(numbers(1) + (numbers(2) - numbers(1)) * i / (number - 1), &
                              i=0, number - 1)]
      end if
    end if
    if (good) call move_alloc(numbers, depths)
    if (.not. good) call problems%add('--depths: found ' // in_quotes(value) // &
      ', expected depths more than 0 with commas, as 0.1,0.2, or FIRST:LAST:NUMBER, as 0.1:2:20')
  end subroutine read_depths

  !> One word of a list.
  subroutine read_word(option, value, words, choice, problems)
    character(len=*), intent(in) :: option         !! whose value it is
    character(len=*), intent(in) :: value          !! value of the option, as given
    character(len=*), intent(in) :: words(:)       !! those that are known
    real(real64), intent(inout) :: choice          !! number of the word, when it is one of them
    type(problem_list), intent(inout) :: problems  !! what is wrong

    integer :: found

    found = findloc(words == plain_unit(value), .true., 1)
    if (found > 0) choice = real(found, real64)
    if (found > 0) return
    call problems%add(option // ': found ' // in_quotes(value) // ', expected ' // &
                      any_of(words) // did_you_mean(value, words))
  end subroutine read_word

  !> A length, or two with a comma between them.
  subroutine read_spacing(value, pixel_spacing, problems)
    character(len=*), intent(in) :: value          !! value of the option, as given
    real(real64), intent(inout) :: pixel_spacing(2)  !! distance of pixels along x and y, length
    type(problem_list), intent(inout) :: problems  !! what is wrong
    type(decimal_value) :: decimal(2)
    logical :: good(2)
    integer :: comma

    comma = index(value, ',')
    call read_numeral(value(comma + 1:), decimal(2), good(2))
    decimal(1) = decimal(2)
    good(1) = good(2)
    if (comma > 0) call read_numeral(value(:comma - 1), decimal(1), good(1))
    if (all(good)) good = is_length(decimal_to_real64(decimal))
    if (all(good)) then
      pixel_spacing = decimal_to_real64(decimal)
    else
      call problems%add('--spacing: found ' // in_quotes(value) // ', expected X or X,Y, each ' // &
                        expected_length)
    end if
  end subroutine read_spacing

  !> `none`, `all`, or positions separated by commas.
  subroutine read_tables(list, printed, problems)
    character(len=*), intent(in) :: list           !! value of the option, as given
    logical, intent(out) :: printed(:)             !! whether the contact table of each position is
                                                   !! printed
    type(problem_list), intent(inout) :: problems  !! what is wrong
    integer :: first, last, position

    printed = list == 'all'
    if (list == 'all' .or. list == 'none') return
    first = 1
    do while (first <= len(list) + 1)
      last = first + index(list(first:) // ',', ',') - 2
      position = count_of(list(first:last), 4)
      if (position >= 1 .and. position <= size(printed)) then
        printed(position) = .true.
      else
        call problems%add('--tables: found ' // in_quotes(list(first:last)) // ' in ' // &
                          in_quotes(list) // ', expected none, all, or positions from 1 to ' // &
                          decimal_text(size(printed)) // ' separated by commas')
      end if
      first = last + 2
    end do
  end subroutine read_tables

end module asperity_option_values
