!> The command line: words in, checked choices or a list of problems out.
module asperity_command_line
  use asperity_original, only: arithmetic_names
  use asperity_original_records, only: original_positions
  use asperity_problems, only: decimal_text, problem_list
  implicit none
  private

  public :: command_line, parse_command_line

  !> What the user asked for.
  type :: command_line
    character(len=:), allocatable :: command         !! empty, help, version or original
    character(len=:), allocatable :: deck            !! path of the card deck
    character(len=:), allocatable :: arithmetic      !! one of `arithmetic_names`
    character(len=:), allocatable :: contacts_file   !! path of the contacts CSV, or empty
    character(len=:), allocatable :: positions_file  !! path of the positions CSV, or empty
    logical :: printed(original_positions) = .false. !! positions whose contact table is printed
    logical :: carriage_control = .false.            !! keep the printer's column one
  end type command_line

  ! Positions whose tables the original prints.
  integer, parameter :: thesis_tables(3) = [13, 55, 56]

contains

  !> Reads the process's own command line.
  subroutine parse_command_line(line, problems)
    type(command_line), intent(out) :: line      !! the choices
    type(problem_list), intent(out) :: problems  !! what is wrong
    character(len=:), allocatable :: word, name, value
    integer :: i
    logical :: inline_value

    line%command = ''
    line%deck = ''
    line%arithmetic = trim(arithmetic_names(1))
    line%contacts_file = ''
    line%positions_file = ''
    line%printed(thesis_tables) = .true.
    i = 0
    do while (i < command_argument_count())
      i = i + 1
      word = argument(i)
      if (word == '--help' .or. word == '-h') then
        line%command = 'help'
        return
      else if (word == '--version') then
        line%command = 'version'
        return
      else if (word == '--carriage-control') then
        line%carriage_control = .true.
      else if (len(word) > 1 .and. index(word, '-') == 1) then
        call split_option(word, name, value, inline_value)
        if (name == '--carriage-control') then
          call problems%add('option ' // name // ' takes no value, found ''' // value // '''')
          cycle
        else if (all(name /= [character(len=12) :: '--arithmetic', '--tables', '--contacts', &
                         '--positions'])) then
          call problems%add('unknown option ' // name // ', expected one of --arithmetic, ' // &
                            '--tables, --contacts, --positions, --carriage-control')
          cycle
        end if
        if (.not. inline_value) then
          if (i < command_argument_count()) value = argument(i + 1)
          ! A value that begins like an option is written --name=value.
          if (i == command_argument_count() .or. index(value, '--') == 1) then
            call problems%add('option ' // name // ' has no value')
            cycle
          end if
          i = i + 1
        end if
        call take_option(line, name, value, problems)
      else if (len(word) == 0) then
        call problems%add('the name of the deck is empty')
      else if (line%command == '') then
        line%command = 'original'
        line%deck = word
      else
        call problems%add('unexpected argument ''' // word // ''' after the deck ' // line%deck)
      end if
    end do
    if (line%command == '' .and. command_argument_count() > 0) &
      call problems%add('no card deck named, expected: asperity [OPTIONS] DECK')
    call check_files(line, problems)
  end subroutine parse_command_line

  !> Stores the value of one option.
  subroutine take_option(line, name, value, problems)
    type(command_line), intent(inout) :: line
    character(len=*), intent(in) :: name, value
    type(problem_list), intent(inout) :: problems

    if (len(value) == 0) then
      call problems%add('option ' // name // ' has an empty value')
      return
    end if
    select case (name)
    case ('--arithmetic')
      if (any(value == arithmetic_names)) then
        line%arithmetic = value
      else
        call problems%add('--arithmetic: found ''' // value // &
                          ''', expected ibm370, real32, real64 or real128')
      end if
    case ('--tables')
      call read_tables(value, line%printed, problems)
    case ('--contacts')
      line%contacts_file = value
    case default
      line%positions_file = value
    end select
  end subroutine take_option

  !> No output may take the place of another file that was named.
  subroutine check_files(line, problems)
    type(command_line), intent(in) :: line
    type(problem_list), intent(inout) :: problems

    if (line%contacts_file /= '' .and. line%contacts_file == line%positions_file .and. &
        index(line%contacts_file, '/dev/') /= 1) &
      call problems%add('--contacts and --positions both name ' // line%contacts_file)
    if (line%command /= 'original') return
    if (line%contacts_file == line%deck) &
      call problems%add('--contacts names the deck, ' // line%deck)
    if (line%positions_file == line%deck) &
      call problems%add('--positions names the deck, ' // line%deck)
  end subroutine check_files

  !> `none`, `all`, or positions separated by commas.
  subroutine read_tables(list, printed, problems)
    character(len=*), intent(in) :: list
    logical, intent(out) :: printed(:)
    type(problem_list), intent(inout) :: problems
    integer :: first, last, position, status

    printed = list == 'all'
    if (list == 'all' .or. list == 'none') return
    first = 1
    do while (first <= len(list) + 1)
      last = first + index(list(first:) // ',', ',') - 2
      status = 1
      if (last >= first .and. last - first < 4) then
        if (verify(list(first:last), '0123456789') == 0) &
          read (list(first:last), '(i4)', iostat=status) position
      end if
      if (status == 0) then
        if (position < 1 .or. position > size(printed)) status = 1
      end if
      if (status == 0) then
        printed(position) = .true.
      else
        call problems%add('--tables: found ''' // list(first:last) // ''' in ''' // list // &
                          ''', expected none, all, or positions from 1 to ' // &
                          decimal_text(size(printed)) // ' separated by commas')
      end if
      first = last + 2
    end do
  end subroutine read_tables

  !> Splits `--name=value`; `inline_value` is false when there is no `=`.
  subroutine split_option(word, name, value, inline_value)
    character(len=*), intent(in) :: word
    character(len=:), allocatable, intent(out) :: name, value
    logical, intent(out) :: inline_value
    integer :: equals

    equals = index(word, '=')
    inline_value = equals > 0
    if (inline_value) then
      name = word(:equals - 1)
      value = word(equals + 1:)
    else
      name = word
      value = ''
    end if
  end subroutine split_option

  !> The i-th argument, whole.
  function argument(i) result(word)
    integer, intent(in) :: i
    character(len=:), allocatable :: word
    integer :: length

    call get_command_argument(i, length=length)
    allocate (character(len=length) :: word)
    call get_command_argument(i, word)
  end function argument

end module asperity_command_line
