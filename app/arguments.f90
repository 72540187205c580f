!> Words of the command line, sorted into options and operand by what a command accepts.
module asperity_arguments
  use asperity_input_text, only: in_quotes
  use asperity_kinds, only: real64
  use asperity_problems, only: problem_list
  use asperity_word_hint, only: did_you_mean, nearest_word
  implicit none
  private

  public :: word_at, argument_list, given_option, joined_words, read_arguments

  !> An option that is given.
  type :: given_option
    character(len=:), allocatable :: name   !! with its two dashes
    character(len=:), allocatable :: value  !! empty for an option without value
    real(real64) :: number = 0.0_real64     !! the number in the value, or that of its word
  end type given_option

  !> The words of the command line behind the command.
  type :: argument_list
    character(len=:), allocatable :: operand        !! the file; empty when none was named
    type(given_option), allocatable :: options(:)   !! in the order given
  end type argument_list

contains

  !> Reads the words from number `first` on. `operand` is what the other word is called.
  subroutine read_arguments(first, known, operand, list, problems)
    integer, intent(in) :: first                    !! number of the first word
    character(len=*), intent(in) :: known(:)        !! the options; `=` ends one with a value
    character(len=*), intent(in) :: operand         !! name of the operand in messages
    type(argument_list), intent(out) :: list        !! what was given
    type(problem_list), intent(inout) :: problems   !! what is wrong
    type(given_option) :: given
    character(len=:), allocatable :: word, name, value
    integer :: equals, i, k, near

    list%operand = ''
    allocate (list%options(0))
    i = first - 1
    do while (i < command_argument_count())
      i = i + 1
      word = word_at(i)
      if (len_trim(word) == 0) then
        call problems%add('the name of the ' // operand // ' is empty')
      else if (len(word) == 1 .or. index(word, '-') /= 1) then
        if (list%operand == '') then
          list%operand = word
        else
          call problems%add('unexpected argument ' // in_quotes(word) // ' after the ' // &
                            operand // ' ' // in_quotes(list%operand))
        end if
      else
        equals = index(word, '=')
        name = word
        value = ''
        if (equals > 0) then
          name = word(:equals - 1)
          value = word(equals + 1:)
        end if
        if (all(known /= name .and. known /= trim(name) // '=')) then
          if (name == '--arithmetic') then
            call problems%add('--arithmetic: a scene is solved in real64 only; `asperity DECK ' // &
                              '--arithmetic NAME` runs the original program in another arithmetic')
            if (equals == 0) i = i + 1
            cycle
          end if
          call problems%add('unknown option ' // in_quotes(name) // ', expected one of' // &
                            joined_words(option_name(known)) // did_you_mean(name, &
                            option_name(known)))
          ! It is taken for what was meant, so that its value is not taken for a file.
          near = nearest_word(name, option_name(known))
          if (near == 0) cycle
          name = trim(option_name(known(near)))
        end if
        if (any(name == known)) then
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
        if (any(trim(name) // '=' == known) .and. len_trim(value) == 0) then
          call problems%add('option ' // name // ' has an empty value')
          cycle
        end if
        ! Only --keep names several files: of any other option the last value would win.
        if (any([(list%options(k)%name == name, k=1, size(list%options))]) .and. &
            name /= '--keep' .and. all(name /= known)) &
          call problems%add('option ' // name // ' is given twice, expected once')
        given%name = name
        given%value = value
        list%options = [list%options, given]
      end if
    end do
  end subroutine read_arguments

  !> The i-th word of the command line, whole.
  function word_at(i) result(word)
    integer, intent(in) :: i               !! place of the word on the command line, from 1
    character(len=:), allocatable :: word  !! as given
    integer :: length

    call get_command_argument(i, length=length)
    allocate (character(len=length) :: word)
    call get_command_argument(i, word)
  end function word_at

  ! Options as a user writes them.
  elemental function option_name(option) result(name)
    character(len=*), intent(in) :: option
    character(len=len(option)) :: name

    name = option(:scan(option // ' ', ' =') - 1)
  end function option_name

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

end module asperity_arguments
