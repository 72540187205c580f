!> Texts about the program: help, with the names of group &effects as the reader of a scene has
!> them, the manual page, the completion for a shell.
module asperity_help
  use asperity_arguments, only: joined_words
  use asperity_effect_names, only: effect_number, effect_numbers, effect_words, known_effects, &
                                   needed_for, one_word, whole_number
  use asperity_numeral, only: expected_numbers
  use asperity_option_table, only: call_of, command_at, commands, options
  use asperity_problems, only: decimal_text
  use asperity_text_buffer, only: text_buffer
  use asperity_version, only: version
  use asperity_word_hint, only: one_of
  use, intrinsic :: iso_fortran_env, only: compiler_options, compiler_version
  implicit none
  private

  public :: write_help, write_completion, write_manual_page

  ! The words after a bare `asperity`.
  character(len=*), parameter :: next_steps(*) = [character(len=82) :: &
    'asperity: contact between rough surfaces of spherical asperities', &
    '', &
    'Three commands to begin with:', &
    '  asperity data/thesis.deck     the printed report of the 1970s program', &
    '  asperity solve SCENE          contact of two surfaces: data/examples has scenes', &
    '  asperity summits MAP          a measured height map: statistics and summits', &
    'Then:', &
    '  asperity accuracy             run time and error of every method', &
    '  asperity --help               all commands and options', &
    'With fpm: fpm run -- data/thesis.deck']

  ! A help is so wide; the text of an option begins behind so many columns.
  integer, parameter :: widest = 80, margin = 22

contains

  !> The text of `asperity`, `asperity --version` or a help.
  subroutine write_help(command, topic, text)
    character(len=*), intent(in) :: command   !! empty, `help` or `version`
    character(len=*), intent(in) :: topic     !! the command whose help is asked for, or another
    type(text_buffer), intent(inout) :: text  !! text to which the lines are added
    integer :: i

    if (command == 'version') then
      call text%line('asperity ' // version)
      call text%line('built by ' // compiler_version() // ' with' // &
        digit_flags(compiler_options()))
      call text%line('arithmetics ibm370 (default for a deck), real32, real64 (solve), real128')
      return
    else if (command == '') then
      do i = 1, size(next_steps)
        call text%line(next_steps(i))
      end do
      return
    end if
    call add_usage(topic, text)
    if (topic == 'solve') then
      call text%line('')
      call describe_effects(text)
    end if
    call text%line('')
    call text%line('Exit status: 0 the chosen model was solved to the stated tolerance ' // &
                   '(warnings state where')
    call text%line('it does not apply), 1 could not be computed, 2 bad command line or bad input')
  end subroutine write_help

  ! How a command is called, what it does, its options.
  subroutine add_usage(topic, text)
    character(len=*), intent(in) :: topic
    type(text_buffer), intent(inout) :: text
    integer :: i, k

    k = command_at(topic)
    call text%line('Usage: ' // call_of(k))
    if (k == 1) then
      do i = 2, size(commands)
        call text%line('       ' // call_of(i))
      end do
      call text%line('       asperity COMMAND --help')
    end if
    call text%line('')
    call add_wrapped('', trim(commands(k)%text), 0, text)
    call text%line('')
    do i = 1, size(options)
      if (options(i)%command == commands(k)%name) &
        call add_wrapped('  ' // trim(options(i)%name) // ' ' // options(i)%value, &
                         trim(options(i)%text), margin, text)
    end do
    if (k > 1) return
    call text%line('  --help, -h, --version')
    call text%line('  --man, --completion   a manual page (troff), completion for bash')
  end subroutine add_usage

  ! A text in lines behind a margin; the first one begins with a head.
  subroutine add_wrapped(head, words, from, text)
    character(len=*), intent(in) :: head, words
    integer, intent(in) :: from
    type(text_buffer), intent(inout) :: text
    character(len=widest) :: line
    integer :: first, last

    line = head
    first = 1
    do while (first <= len(words))
      last = len(words)
      if (last - first >= widest - from) &
        last = first + index(words(first:first + widest - from), ' ', back=.true.) - 2
      line(from + 1:) = words(first:last)
      call text%line(trim(line))
      line = ''
      first = last + 2
    end do
  end subroutine add_wrapped

  ! The compiler options that may change a digit; options with a folder's name are left out.
  pure function digit_flags(options) result(text)
    character(len=*), intent(in) :: options
    character(len=:), allocatable :: text
    integer :: first, last

    text = ''
    first = 1
    do while (first <= len_trim(options))
      last = first + index(options(first:) // ' ', ' ') - 2
      if (index(options(first:last), '-') == 1 .and. index(options(first:last), '/') == 0 .and. &
          scan(options(min(first + 1, last):min(first + 1, last)), 'OfmDs') > 0) &
        text = text // ' ' // options(first:last)
      first = last + 2
    end do
  end function digit_flags

  ! Every effect with its numbers: values, default, meaning, and the unit between brackets.
  subroutine describe_effects(text)
    type(text_buffer), intent(inout) :: text
    integer :: i

    call text%line('Names of group &effects in a scene; [unit], in the units of the scene:')
    call text%line('')
    call describe_numbers('', text)
    do i = 1, size(known_effects)
      associate (effect => known_effects(i))
        call two_lines('  ' // effect%name, one_of(effect_words(pack(effect%modes, &
                       effect%modes > 0))) // '; default ' // &
                       trim(merge('''auto''                             ', &
                                  '''auto'' with its numbers, else ''off''', &
                                  effect%name == 'interaction')), effect%meaning, text)
        call describe_numbers(trim(effect%name), text)
      end associate
    end do
  end subroutine describe_effects

  ! The numbers of one effect, or those of all.
  subroutine describe_numbers(effect, text)
    character(len=*), intent(in) :: effect
    type(text_buffer), intent(inout) :: text
    character(len=:), allocatable :: values, unit
    integer :: i

    do i = 1, size(effect_numbers)
      associate (number => effect_numbers(i))
        if (number%effect /= effect) cycle
        values = values_of(number) // '; default ' // default_of(number)
        if (number%needed_with /= '') &
          values = values_of(number) // '; needed with ' // needed_for(number)
        unit = ''
        if (number%unit /= '') unit = ' [' // trim(number%unit) // ']'
        call two_lines('  ' // repeat(' ', min(2, len(effect))) // number%name, values, &
                       trim(number%meaning) // unit, text)
      end associate
    end do
  end subroutine describe_numbers

  ! Values that a number may have, in words.
  pure function values_of(number) result(values)
    type(effect_number), intent(in) :: number
    character(len=:), allocatable :: values

    select case (number%number_range)
    case (one_word)
      values = one_of(pack(number%words, number%words /= ''))
    case (whole_number)
      values = 'a whole number from ' // decimal_text(number%least) // ' to ' // &
               decimal_text(number%most)
    case default
      values = trim(expected_numbers(number%number_range))
    end select
  end function values_of

  ! Value of a number that a scene does not have, in words.
  pure function default_of(number) result(default)
    type(effect_number), intent(in) :: number
    character(len=:), allocatable :: default

    default = decimal_text(int(number%default%all_digits))
    if (number%number_range == one_word) then
      default = 'none'
      if (number%default%all_digits > 0) &
        default = '''' // trim(number%words(number%default%all_digits)) // ''''
    end if
    if (number%default%power_of_ten < 0) &
      default = '0.' // repeat('0', -number%default%power_of_ten - len(default)) // default
  end function default_of

  subroutine two_lines(name, values, meaning, text)
    character(len=*), intent(in) :: name, values, meaning
    type(text_buffer), intent(inout) :: text
    character(len=26) :: margin

    margin = name
    call text%line(margin // values)
    call text%line(repeat(' ', len(margin)) // trim(meaning))
  end subroutine two_lines

  !> A page for man(1), in troff.
  subroutine write_manual_page(text)
    type(text_buffer), intent(inout) :: text  !! text to which the lines are added
    integer :: i, k

    call text%line('.TH ASPERITY 1 "" "asperity ' // version // '" "User Commands"')
    call text%line('.SH NAME')
    call text%line('asperity \- contact between rough surfaces of spherical asperities')
    call text%line('.SH SYNOPSIS')
    do k = 1, size(commands)
      call text%line('.B ' // troff_text(call_of(k)))
      call text%line('.br')
    end do
    do k = 1, size(commands)
      call text%line('.SH ' // merge('REPORT  ', commands(k)%name, k == 1))
      call text%line(troff_text(trim(commands(k)%text)))
      do i = 1, size(options)
        if (options(i)%command /= commands(k)%name) cycle
        call text%line('.TP')
        call text%line('.B ' // troff_text(trim(options(i)%name) // ' ' // trim(options(i)%value)))
        call text%line(troff_text(trim(options(i)%text)))
      end do
    end do
    call text%line('.SH EXIT STATUS')
    call text%line('0 the chosen model was solved to the stated tolerance, 1 could not be ' // &
                   'computed, 2 bad command line or bad input.')
  end subroutine write_manual_page

  !> Words after a Tab in bash: `source <(asperity --completion)`.
  subroutine write_completion(text)
    type(text_buffer), intent(inout) :: text  !! text to which the lines are added
    integer :: k

    call text%line('_asperity() {')
    call text%line('  local words cur=${COMP_WORDS[COMP_CWORD]}')
    call text%line('  case ${COMP_WORDS[1]} in')
    do k = 2, size(commands)
      call text%line('    ' // trim(commands(k)%name) // ') words="--help' // &
                     joined_words(pack(options%name, options%command == commands(k)%name)) // &
                     '" ;;')
    end do
    call text%line('    *) words="--help --version --man --completion' // &
                   joined_words(pack(options%name, options%command == '')) // '" ;;')
    call text%line('  esac')
    call text%line('  COMPREPLY=()')
    call text%line('  if [[ $cur == -* ]]; then')
    call text%line('    COMPREPLY=($(compgen -W "$words" -- "$cur"))')
    call text%line('  elif [[ $COMP_CWORD -eq 1 ]]; then')
    call text%line('    COMPREPLY=($(compgen -W "' // joined_words(commands(2:)%name) // &
                   '" -- "$cur") $(compgen -f -- "$cur"))')
    call text%line('  else')
    call text%line('    COMPREPLY=($(compgen -f -- "$cur"))')
    call text%line('  fi')
    call text%line('}')
    call text%line('complete -o filenames -F _asperity asperity')
  end subroutine write_completion

  ! Text for troff, where a bare minus becomes a hyphen.
  pure function troff_text(words) result(text)
    character(len=*), intent(in) :: words
    character(len=:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, len(words)
      if (words(i:i) == '-') text = text // '\'
      text = text // words(i:i)
    end do
  end function troff_text

end module asperity_help
