!> What the program says of itself.
module asperity_help
  use asperity_effect_help, only: describe_effects
  use asperity_option_table, only: call_of, command_at, commands, options
  use asperity_text_buffer, only: text_buffer
  use asperity_version, only: version
  use, intrinsic :: iso_fortran_env, only: compiler_options, compiler_version
  implicit none
  private

  public :: describe

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
  subroutine describe(command, topic, text)
    character(len=*), intent(in) :: command   !! empty, `help` or `version`
    character(len=*), intent(in) :: topic     !! the command whose help is asked for, or another
    type(text_buffer), intent(inout) :: text  !! gets it

    if (command == 'version') then
      call text%line('asperity ' // version)
      call text%line('built by ' // compiler_version() // ' with' // flags(compiler_options()))
      call text%line('arithmetics ibm370 (default for a deck), real32, real64 (default of ' // &
                     'solve), real128')
      return
    else if (command == '') then
      call add(next_steps)
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

  contains

    subroutine add(lines)
      character(len=*), intent(in) :: lines(:)
      integer :: i

      do i = 1, size(lines)
        call text%line(lines(i))
      end do
    end subroutine add

  end subroutine describe

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

  ! Of the compiler's options those that may change a digit; no folder's name.
  pure function flags(options) result(text)
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
  end function flags

end module asperity_help
