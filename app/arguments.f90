!> Words of the command line, sorted into options and operand by what a command accepts, and the
!> values of options.
module asperity_arguments
  use asperity_height_map, only: is_length
  use asperity_input_text, only: in_quotes
  use asperity_kinds, only: real64
  use asperity_numeral, only: read_number
  use asperity_option_table, only: commands, option_entry, options
  use asperity_problems, only: decimal_text, problem_list
  use asperity_word_hint, only: did_you_mean, nearest_word
  implicit none
  private

  public :: count_of, given_option, joined_words, positive_number, read_arguments, read_depths, &
            read_share, read_spacing, read_tables, word_at

  !> An option that is given.
  type :: given_option
    character(len=:), allocatable :: name   !! with its two dashes
    character(len=:), allocatable :: value  !! empty for an option without value
    real(real64) :: number = 0.0_real64     !! the number in the value, or that of its word
    type(option_entry) :: entry             !! its row of the table of options
  end type given_option

contains

  !> Reads the words from number `first` on.
  subroutine read_arguments(first, command, file, given, problems)
    integer, intent(in) :: first                    !! number of the first word
    integer, intent(in) :: command                  !! place of the command in `commands`
    character(len=:), allocatable, intent(out) :: file        !! the operand; empty: none is named
    type(given_option), allocatable, intent(out) :: given(:)  !! options in the order given
    type(problem_list), intent(inout) :: problems   !! what is wrong
    type(given_option) :: new
    type(option_entry), allocatable :: known(:)
    character(len=:), allocatable :: operand, word, name, value
    integer :: at, equals, i, k

    known = pack(options, options%command == commands(command)%name)
    operand = trim(commands(command)%called)
    file = ''
    allocate (given(0))
    i = first - 1
    do while (i < command_argument_count())
      i = i + 1
      word = word_at(i)
      if (len_trim(word) == 0) then
        call problems%add('the name of the ' // operand // ' is empty')
      else if (len(word) == 1 .or. index(word, '-') /= 1) then
        if (file == '') then
          file = word
        else
          call problems%add('unexpected argument ' // in_quotes(word) // ' after the ' // &
                            operand // ' ' // in_quotes(file))
        end if
      else
        equals = index(word, '=')
        name = word
        value = ''
        if (equals > 0) then
          name = word(:equals - 1)
          value = word(equals + 1:)
        end if
        at = findloc(known%name == name, .true., 1)
        if (at == 0) then
          call add_unknown(name, known%name, problems)
          if (name == '--arithmetic' .and. equals == 0) i = i + 1
          if (name == '--arithmetic' .or. name == '--') cycle
          ! It is taken for what was meant, so that its value is not taken for a file.
          at = nearest_word(name, known%name)
          if (at == 0) cycle
          name = trim(known(at)%name)
        end if
        if (known(at)%value == '') then
          if (equals > 0) &
            call problems%add('option ' // name // ' takes no value, found ' // in_quotes(value))
        else if (equals == 0) then
          if (i < command_argument_count()) value = word_at(i + 1)
          ! A value that begins like an option is written --name=value.
          if (i == command_argument_count() .or. index(value, '--') == 1) then
            call problems%add('option ' // name // ' has no value')
            cycle
          end if
          i = i + 1
        end if
        ! A blank name would pass for none later on.
        if (known(at)%value /= '' .and. len_trim(value) == 0) then
          call problems%add('option ' // name // ' has an empty value')
          cycle
        end if
        ! Only --keep names several files: of any other option the last value would win.
        if (any([(given(k)%name == name, k=1, size(given))]) .and. &
            name /= '--keep' .and. known(at)%value /= '') &
          call problems%add('option ' // name // ' is given twice, expected once')
        new%name = name
        new%value = value
        new%entry = known(at)
        given = [given, new]
      end if
    end do
  end subroutine read_arguments

  ! Adds the problem of an option that the command does not have.
  subroutine add_unknown(name, known, problems)
    character(len=*), intent(in) :: name, known(:)
    type(problem_list), intent(inout) :: problems

    if (name == '--arithmetic') then
      call problems%add('--arithmetic: a scene is solved in real64 only; `asperity DECK ' // &
                        '--arithmetic NAME` runs the original program in another arithmetic')
    else if (name == '--') then
      call problems%add('found ''--'', expected an option or a file: a file whose name begins ' // &
                        'with - is named ./-NAME')
    else
      call problems%add('unknown option ' // in_quotes(name) // ', expected one of' // &
                        joined_words(known) // did_you_mean(name, known))
    end if
  end subroutine add_unknown

  !> The i-th word of the command line, whole.
  function word_at(i) result(word)
    integer, intent(in) :: i               !! place of the word on the command line; 0: the program
    character(len=:), allocatable :: word  !! as given
    integer :: length

    call get_command_argument(i, length=length)
    allocate (character(len=length) :: word)
    call get_command_argument(i, word)
  end function word_at

  !> Words with a blank before each.
  pure function joined_words(words) result(text)
    character(len=*), intent(in) :: words(:)  !! trailing blanks are left out
    character(len=:), allocatable :: text     !! one line
    integer :: i

    text = ''
    do i = 1, size(words)
      text = text // ' ' // trim(words(i))
    end do
  end function joined_words

  !> The whole number from 1 on that a word is; 0 when it is none.
  integer function count_of(word, most_digits)
    character(len=*), intent(in) :: word  !! value of an option, as given
    integer, intent(in) :: most_digits    !! of the number, at most

    count_of = 0
    if (len(word) > 0 .and. len(word) <= most_digits .and. verify(word, '0123456789') == 0) &
      read (word, '(i9)') count_of
  end function count_of

  !> A part and how many there are: `I/N`.
  subroutine read_share(value, share, good)
    character(len=*), intent(in) :: value  !! value of the option, as given
    integer, intent(inout) :: share(2)     !! as it was when the word is no such pair
    logical, intent(out) :: good           !! whether it is one
    integer :: found(2), slash

    slash = index(value, '/')
    found = [count_of(value(:slash - 1), 6), count_of(value(slash + 1:), 6)]
    good = found(1) >= 1 .and. found(1) <= found(2)
    if (good) share = found
  end subroutine read_share

  !> A number more than 0 and below a limit; 0 when a word is none.
  real(real64) function positive_number(value, limit) result(number)
    character(len=*), intent(in) :: value  !! value of the option, as given
    real(real64), intent(in) :: limit      !! the number is less
    logical :: good

    call read_number(value, number, good)
    if (.not. (good .and. number > 0.0_real64 .and. number < limit)) number = 0.0_real64
  end function positive_number

  !> Depths of 0 or more: a list with commas, or the first, the last and the number of equal steps.
  subroutine read_depths(value, depths, good)
    character(len=*), intent(in) :: value                !! value of the option, as given
    real(real64), allocatable, intent(out) :: depths(:)  !! not allocated where they are not
    logical, intent(out) :: good                         !! whether they are depths
    real(real64), allocatable :: numbers(:)
    character(len=1) :: mark
    real(real64) :: number
    integer :: end_of, from, i, steps

    mark = merge(':', ',', index(value, ':') > 0)
    allocate (numbers(0))
    from = 1
    good = .true.
    do while (good .and. from <= len(value) + 1)
      end_of = index(value(from:) // mark, mark) + from - 2
      call read_number(value(from:end_of), number, good)
      numbers = [numbers, number]
      good = good .and. number >= 0.0_real64
      from = end_of + 2
    end do
    if (good .and. mark == ':') then
      good = size(numbers) == 3
      if (good) then
        steps = count_of(value(index(value, ':', back=.true.) + 1:), 4) - 1
        good = steps >= 1 .and. numbers(1) < numbers(2)
        if (good) numbers = [(numbers(1) + (numbers(2) - numbers(1)) * i / steps, i=0, steps)]
      end if
    end if
    if (good) call move_alloc(numbers, depths)
  end subroutine read_depths

  !> A length, or two with a comma between them.
  subroutine read_spacing(value, pixel_spacing, good)
    character(len=*), intent(in) :: value            !! value of the option, as given
    real(real64), intent(inout) :: pixel_spacing(2)  !! distance of pixels along x and y, length
    logical, intent(out) :: good                     !! whether they are lengths
    real(real64) :: lengths(2)
    integer :: comma

    comma = index(value, ',')
    lengths = positive_number(value(comma + 1:), huge(lengths))
    if (comma > 0) lengths(1) = positive_number(value(:comma - 1), huge(lengths))
    good = all(is_length(lengths))
    if (good) pixel_spacing = lengths
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

end module asperity_arguments
