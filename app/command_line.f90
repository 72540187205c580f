!> The command line: words in, checked choices or a list of problems out.
module asperity_command_line
  use asperity_arguments, only: argument, argument_list, read_arguments
  use asperity_input_text, only: quoted
  use asperity_kinds, only: real64
  use asperity_option_values, only: read_accuracy, read_count, read_tables
  use asperity_original, only: arithmetic_names
  use asperity_original_records, only: original_positions
  use asperity_output_files, only: same_file
  use asperity_problems, only: decimal_text, problem_list
  use asperity_system_calls, only: canonical_path
  implicit none
  private

  public :: command_line, is_shared, output_place, parse_command_line, refuse_input

  !> What the user asked for.
  type :: command_line
    character(len=:), allocatable :: command         !! empty, help, version, original, solve ...
    character(len=:), allocatable :: topic           !! command whose help is asked for, or empty
    character(len=:), allocatable :: input           !! path of the deck or scene
    character(len=:), allocatable :: arithmetic      !! one of `arithmetic_names`
    character(len=:), allocatable :: contacts_file   !! path of the contacts CSV, or empty
    character(len=:), allocatable :: positions_file  !! path of the positions CSV, or empty
    character(len=:), allocatable :: curve_file      !! path of the curve CSV, or empty
    character(len=:), allocatable :: csv_file        !! path of the study's CSV, or empty
    character(len=:), allocatable :: keep_file       !! path of the work kept, or empty
    character(len=:), allocatable :: output_file     !! path of the generated surface, or empty
    character(len=:), allocatable :: upper_file      !! path of the upper surface, or empty
    character(len=:), allocatable :: lower_file      !! path of the lower surface, or empty
    integer :: member = 0                            !! surface of the ensemble; 0 is all
    logical :: printed(original_positions) = .false. !! positions whose contact table is printed
    logical :: carriage_control = .false.            !! keep the printer's column one
    logical :: quiet = .false.                       !! no summary
    logical :: budget = .false.                      !! print the error budget
    integer :: threads = 0                           !! threads to use; 0: all cores
    real(real64) :: accuracy = 0.0_real64            !! accuracy asked for; 0 when not given
  end type command_line

  ! Positions whose tables the original prints.
  integer, parameter :: thesis_tables(3) = [13, 55, 56]
  ! Options of the commands, with a value and without.
  character(len=*), parameter :: original_valued(4) = &
    [character(len=18) :: '--arithmetic', '--tables', '--contacts', '--positions']
  character(len=*), parameter :: original_flags(1) = [character(len=18) :: '--carriage-control']
  character(len=*), parameter :: solve_valued(7) = &
    [character(len=18) :: '--contacts', '--positions', '--curve', '--arithmetic', '--accuracy', &
     '--threads', '--keep']
  character(len=*), parameter :: solve_flags(2) = [character(len=18) :: '--budget', '--quiet']
  character(len=*), parameter :: no_flags(0) = [character(len=18) ::]
  character(len=*), parameter :: study_valued(1) = [character(len=18) :: '--csv']
  character(len=*), parameter :: area_valued(2) = [character(len=18) :: '--csv', '--keep']
  character(len=*), parameter :: generate_valued(4) = &
    [character(len=18) :: '--output', '--upper', '--lower', '--surface']
  ! Options that name an output.
  character(len=*), parameter :: output_options(8) = &
    [character(len=11) :: '--contacts', '--positions', '--curve', '--csv', '--output', '--upper', &
     '--lower', '--keep']
  character(len=*), parameter :: study_flags(1) = [character(len=18) :: '--quiet']

contains

  !> Reads the process's own command line.
  subroutine parse_command_line(line, problems)
    type(command_line), intent(out) :: line      !! the choices
    type(problem_list), intent(out) :: problems  !! what is wrong
    type(argument_list) :: list
    integer :: i

    line%command = ''
    line%topic = ''
    line%input = ''
    line%arithmetic = ''
    line%contacts_file = ''
    line%positions_file = ''
    line%curve_file = ''
    line%csv_file = ''
    line%keep_file = ''
    line%output_file = ''
    line%upper_file = ''
    line%lower_file = ''
    line%printed(thesis_tables) = .true.
    if (command_argument_count() == 0) return
    do i = 1, command_argument_count()
      select case (argument(i))
      case ('--help', '-h')
        line%command = 'help'
        line%topic = argument(1)
        return
      case ('--version')
        line%command = 'version'
        return
      case default
        continue
      end select
    end do
    line%command = argument(1)
    select case (line%command)
    case ('solve')
      call read_arguments(2, solve_valued, solve_flags, 'scene', list, problems)
      if (list%operand == '') &
        call problems%add('no scene named, expected: asperity solve [OPTIONS] SCENE')
    case ('accuracy')
      call read_arguments(2, study_valued, study_flags, 'deck or scene', list, problems)
      if (list%operand == '') list%operand = 'data/thesis.deck'
    case ('generate')
      call read_arguments(2, generate_valued, no_flags, 'specification', list, problems)
      if (list%operand == '') &
        call problems%add('no specification named, expected: asperity generate [OPTIONS] SPEC')
    case ('study')
      call read_arguments(2, area_valued, study_flags, 'specification', list, problems)
      if (list%operand == '') &
        call problems%add('no specification named, expected: asperity study [OPTIONS] SPEC')
    case default
      line%command = 'original'
      line%arithmetic = trim(arithmetic_names(1))
      call read_arguments(1, original_valued, original_flags, 'deck', list, problems)
      if (list%operand == '' .and. problems%count() == 0) &
        call problems%add('no card deck named, expected: asperity [OPTIONS] DECK')
    end select
    line%input = list%operand
    do i = 1, size(list%options)
      call take_option(line, list%options(i)%name, list%options(i)%value, problems)
    end do
    if (line%accuracy > 0 .and. line%arithmetic /= '') &
      call problems%add('--accuracy chooses the arithmetic: leave out --arithmetic')
    if (line%accuracy > 0 .and. line%keep_file /= '') &
      call problems%add('--accuracy solves a sweep in several ways, --keep keeps one: ' // &
                        'expected one of both')
    if (line%output_file /= '' .and. line%upper_file /= '') &
      call problems%add('--output and --upper both name the upper surface, expected one of them')
    call check_files(line, problems)
  end subroutine parse_command_line

  !> Stores one option.
  subroutine take_option(line, name, value, problems)
    type(command_line), intent(inout) :: line
    character(len=*), intent(in) :: name, value
    type(problem_list), intent(inout) :: problems

    select case (name)
    case ('--arithmetic')
      if (any(value == arithmetic_names)) then
        line%arithmetic = value
      else
        call problems%add('--arithmetic: found ' // quoted(value) // &
                          ', expected ibm370, real32, real64 or real128')
      end if
    case ('--tables')
      call read_tables(value, line%printed, problems)
    case ('--contacts')
      line%contacts_file = value
    case ('--positions')
      line%positions_file = value
    case ('--curve')
      line%curve_file = value
    case ('--csv')
      line%csv_file = value
    case ('--keep')
      line%keep_file = value
    case ('--output')
      line%output_file = value
    case ('--upper')
      line%upper_file = value
    case ('--lower')
      line%lower_file = value
    case ('--surface')
      call read_count(name, value, 7, 'a number from 1', line%member, problems)
    case ('--carriage-control')
      line%carriage_control = .true.
    case ('--quiet')
      line%quiet = .true.
    case ('--budget')
      line%budget = .true.
    case ('--threads')
      call read_count(name, value, 4, 'a number from 1 to 9999', line%threads, problems)
    case default
      call read_accuracy(value, line%accuracy, problems)
    end select
  end subroutine take_option

  !> Whether all images work on a command, each on a part of its pieces.
  pure logical function is_shared(line)
    type(command_line), intent(in) :: line  !! the user's choices

    is_shared = line%command == 'study' .or. &
                (line%command == 'solve' .and. .not. line%accuracy > 0.0_real64)
  end function is_shared

  !> The path of an output of a member of an ensemble: `%` stands for its number.
  pure function output_place(pattern, member) result(path)
    character(len=*), intent(in) :: pattern  !! as the user gave it
    integer, intent(in) :: member            !! number in the ensemble
    character(len=:), allocatable :: path    !! the file
    integer :: i

    path = ''
    do i = 1, len(pattern)
      if (pattern(i:i) == '%') then
        path = path // decimal_text(member)
      else
        path = path // pattern(i:i)
      end if
    end do
  end function output_place

  !> No output may take the place of another file that was named, in whatever spelling.
  subroutine check_files(line, problems)
    type(command_line), intent(in) :: line
    type(problem_list), intent(inout) :: problems
    character(len=:), allocatable :: report
    integer :: i, j

    report = canonical_path('/dev/stdout')
    call refuse_input(line, line%input, problems)
    do i = 1, size(output_options)
      if (same_file(output_file(line, i), report)) &
        call problems%add(trim(output_options(i)) // ' names the file that standard output ' // &
                          'goes to, ' // output_file(line, i))
      do j = i + 1, size(output_options)
        if (same_file(output_file(line, i), output_file(line, j))) &
          call problems%add(trim(output_options(i)) // ' and ' // trim(output_options(j)) // &
                            ' both name ' // output_file(line, i))
      end do
    end do
  end subroutine check_files

  !> No output may take the place of an input, be it named here or in a scene.
  subroutine refuse_input(line, input, problems)
    type(command_line), intent(in) :: line         !! the user's choices
    character(len=*), intent(in) :: input          !! path of the input
    type(problem_list), intent(inout) :: problems  !! what is wrong
    integer :: i

    do i = 1, size(output_options)
      if (same_file(output_file(line, i), input)) &
        call problems%add(trim(output_options(i)) // ' names the input, ' // input)
    end do
  end subroutine refuse_input

  !> The path behind the i-th of `output_options`, or nothing.
  pure function output_file(line, i) result(path)
    type(command_line), intent(in) :: line
    integer, intent(in) :: i
    character(len=:), allocatable :: path

    select case (i)
    case (1)
      path = line%contacts_file
    case (2)
      path = line%positions_file
    case (3)
      path = line%curve_file
    case (4)
      path = line%csv_file
    case (5)
      path = line%output_file
    case (6)
      path = line%upper_file
    case (7)
      path = line%lower_file
    case default
      path = line%keep_file
    end select
  end function output_file

end module asperity_command_line
