!> Texts about the program: help, with the names of scenes and specifications as their readers have
!> them, the manual page, the completion for a shell.
module asperity_help
  use asperity_arguments, only: joined_words
  use asperity_effect_names, only: needed_for
  use asperity_input_text, only: replaced_text
  use asperity_number_format, only: number_text
  use asperity_numeral, only: any_number, in_range
  use asperity_option_table, only: call_of, command_at, commands, options
  use asperity_problems, only: decimal_text
  use asperity_scene_fields, only: known_name, one_word, values_in_words, whole_number
  use asperity_scene_names, only: scene_table
  use asperity_spec_names, only: spec_table
  use asperity_text_buffer, only: text_buffer
  use asperity_version, only: version
  use asperity_word_hint, only: one_of
  use, intrinsic :: iso_fortran_env, only: compiler_options, compiler_version
  implicit none
  private

  public :: write_help, write_completion, write_manual_page

  ! The words after a bare `asperity`.
  character(len=*), parameter :: next_steps(*) = [character(len=82) :: &
    'asperity: contact between rough surfaces of spherical asperities', '', &
    'Three commands to begin with:', &
    '  asperity data/thesis.deck     the printed report of the 1970s program', &
    '  asperity solve SCENE          contact of two surfaces: data/examples has scenes', &
    '  asperity summits MAP          a measured height map: statistics and summits', 'Then:', &
    '  asperity accuracy             run time and error of every method', &
    '  asperity --help               all commands and options', &
    'With fpm: fpm run -- data/thesis.deck']

  ! A help is so wide; the text of an option begins behind so many columns.
  integer, parameter :: widest = 80, margin = 22

contains

  !> The text of `asperity`, `asperity --version` or a help.
  subroutine write_help(command, topic, group, text)
    character(len=*), intent(in) :: command   !! empty, `help` or `version`
    character(len=*), intent(in) :: topic     !! the command whose help is asked for, or another
    character(len=*), intent(in) :: group     !! group of its file whose names are asked for
    type(text_buffer), intent(inout) :: text  !! text to which the lines are added
    type(known_name), allocatable :: rows(:)
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
    allocate (rows(0))
    if (topic == 'solve') rows = scene_table()
    if (topic == 'generate') rows = spec_table
    if (any(rows%group == group)) then
      call describe_names(pack(rows, rows%group == group), text)
      return
    end if
    call add_usage(topic, text)
    call text%line('')
    if (size(rows) > 0) then
      call text%line('Names, values and units of a group: asperity ' // topic // ' --help GROUP')
      call text%line('Groups:' // joined_words(pack(rows%group, rows%group /= &
                                                    eoshift(rows%group, -1))))
      call text%line('')
    end if
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
      call text%line('       asperity COMMAND --help, or asperity help COMMAND')
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

  ! Names of a group of a scene or specification: values, default, meaning, and the unit between
  ! brackets. Numbers of one effect are indented.
  subroutine describe_names(rows, text)
    type(known_name), intent(in) :: rows(:)
    type(text_buffer), intent(inout) :: text
    character(len=:), allocatable :: values, unit
    character(len=27) :: name
    integer :: i

    call text%line('Names of group &' // trim(rows(1)%group) // '; [unit]:')
    call text%line('')
    do i = 1, size(rows)
      associate (row => rows(i))
        name = '  ' // row%name
        if (row%effect /= '' .and. row%effect /= row%name) name = '    ' // row%name
        values = values_in_words(row)
        if (row%value_kind == any_number) values = 'a number'
        if (row%counts(2) > 1) values = values // ', ' // decimal_text(row%counts(1))
        if (row%counts(2) == 4) values = values // ', 2'
        if (row%counts(2) > row%counts(1)) &
          values = values // merge(' or ', ' to ', row%counts(2) < 5) // decimal_text(row%counts(2))
        values = values // trim(merge(' values; ', ';        ', row%counts(2) > 1)) // ' '
        if (row%needed_with /= '') then
          values = values // 'needed with ' // needed_for(row)
        else if (index(row%otherwise, 'needed') == 1) then
          values = values // trim(row%otherwise)
        else
          values = values // 'default ' // default_of(row)
        end if
        unit = ''
        if (row%unit /= '') unit = ' [' // trim(row%unit) // ']'
        call text%line(name(:26) // values)
        call text%line(repeat(' ', 26) // trim(row%meaning) // unit)
      end associate
    end do
  end subroutine describe_names

  ! Value of a name that does not occur, in words.
  pure function default_of(row) result(default)
    type(known_name), intent(in) :: row
    character(len=:), allocatable :: default
    integer :: number

    number = int(row%default)
    default = number_text(row%default)
    if (row%value_kind == one_word .and. number > 0) default = one_of(row%words(number:number))
    if (row%value_kind > 0) then
      if (.not. in_range(row%default, row%value_kind)) default = 'none'
    else if (row%value_kind /= whole_number .and. number == 0) then
      default = 'none'
    end if
    if (row%otherwise /= '') default = trim(row%otherwise)
  end function default_of

  !> A page for man(1), in troff.
  subroutine write_manual_page(text)
    type(text_buffer), intent(inout) :: text  !! text to which the lines are added
    integer :: i, k

    ! In troff a bare minus becomes a hyphen.
    call text%line('.TH ASPERITY 1 "" "asperity ' // version // '" "User Commands"')
    call text%line('.SH NAME')
    call text%line('asperity \- contact between rough surfaces of spherical asperities')
    call text%line('.SH SYNOPSIS')
    do k = 1, size(commands)
      call text%line('.B ' // replaced_text(call_of(k), '-', '\-'))
      call text%line('.br')
    end do
    do k = 1, size(commands)
      call text%line('.SH ' // merge('REPORT  ', commands(k)%name, k == 1))
      call text%line(replaced_text(trim(commands(k)%text), '-', '\-'))
      do i = 1, size(options)
        if (options(i)%command /= commands(k)%name) cycle
        call text%line('.TP')
        call text%line('.B ' // replaced_text(trim(options(i)%name) // ' ' // &
                                              trim(options(i)%value), '-', '\-'))
        call text%line(replaced_text(trim(options(i)%text), '-', '\-'))
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
    call text%line('  case ${COMP_WORDS[COMP_CWORD-1]} in')
    do k = 1, size(options)
      if (all(options(k)%words == '')) cycle
      call text%line('    ' // trim(options(k)%name) // ') words="' // &
                     trim(joined_words(options(k)%words)) // '"')
      call text%line('      mapfile -t COMPREPLY < <(compgen -W "$words" -- "$cur")')
      call text%line('      return ;;')
    end do
    call text%line('  esac')
    call text%line('  case ${COMP_WORDS[1]} in')
    do k = 2, size(commands)
      call text%line('    ' // trim(commands(k)%name) // ') words="--help' // &
                     joined_words(pack(options%name, options%command == commands(k)%name)) // &
                     '" ;;')
    end do
    call text%line('    *) words="--help --version --man --completion' // &
                   joined_words(pack(options%name, options%command == '')) // '" ;;')
    call text%line('  esac')
    call text%line('  [[ $cur == -* ]] || words=')
    call text%line('  [[ $COMP_CWORD -gt 1 || $cur == -* ]] || words="help' // &
                   joined_words(commands(2:)%name) // '"')
    ! A line a word: names of files may contain blanks.
    call text%line('  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$cur"; ' // &
                   '[[ $cur == -* ]] || compgen -f -- "$cur")')
    call text%line('}')
    call text%line('complete -o filenames -F _asperity asperity')
  end subroutine write_completion

end module asperity_help
