!> The command line: words in, checked choices or a list of problems out.
module asperity_command_line
  use asperity_arguments, only: count_of, given_option, positive_number, read_arguments, &
                                read_depths, read_share, read_spacing, read_tables, word_at
  use asperity_contact_field, only: fields_all
  use asperity_height_map, only: expected_length, plain_unit
  use asperity_input_text, only: lower_case, in_quotes
  use asperity_kept_records, only: kept_file
  use asperity_kinds, only: real64
  use asperity_option_table, only: call_of, command_at, commands, options
  use asperity_original_records, only: original_positions, thesis_tables
  use asperity_output_files, only: same_file
  use asperity_problems, only: decimal_text, problem_list
  use asperity_system_calls, only: canonical_path
  use asperity_word_hint, only: any_of, did_you_mean
  implicit none
  private

  public :: check_ending, command_line, is_shared, parse_command_line, refuse_input

  character(len=*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyz'

  !> The choices of the user.
  type :: command_line
    character(len=:), allocatable :: command         !! empty, help, version, original, solve ...
    character(len=:), allocatable :: topic           !! command whose help is asked for, or empty
    character(len=:), allocatable :: input           !! path of the deck or scene; group of a help
    type(given_option), allocatable :: given(:)      !! options in their order, `-` as /dev/stdout
    logical :: printed(original_positions) = .false. !! positions whose contact table is printed
    integer :: share(2) = [1, 1]                     !! part, and how many there are
    type(kept_file), allocatable :: parts(:)         !! of --keep, but for the first; none: no such
    real(real64), allocatable :: depths(:)           !! of --depths; not allocated: not given
    real(real64) :: pixel_spacing(2) = 0.0_real64    !! of a matrix; 0 when not given
  contains
    procedure :: has => has_option                   !! whether an option is given
    procedure :: output_path                         !! path of an output, by its option
    procedure :: number => number_of                 !! number in the value of an option
    procedure :: choice => choice_of                 !! whole number, or number of a word
  end type command_line

contains

  !> Reads the process's own command line.
  subroutine parse_command_line(line, problems)
    type(command_line), intent(out) :: line      !! choices of the user, with defaults where none is
                                                 !! made
    type(problem_list), intent(out) :: problems  !! what is wrong
    ! Options that need another one.
    character(len=*), parameter :: needs(2, 4) = reshape([character(len=16) :: &
      '--of', '--accuracy ERROR', '--stress', '--depths LIST', '--body', '--depths LIST', &
      '--fields-of', '--fields FILE'], [2, 4])
    integer, allocatable :: keeps(:)
    integer :: i, k

    line%command = ''
    line%topic = ''
    line%input = ''
    allocate (line%given(0))
    line%printed(thesis_tables) = .true.
    if (command_argument_count() == 0) return
    do i = 1, command_argument_count()
      select case (word_at(i))
      case ('--help', '-h')
        line%command = 'help'
        line%topic = word_at(1)
        if (i < command_argument_count()) line%input = word_at(i + 1)
        return
      case ('--version', '--man', '--completion')
        line%command = word_at(i)
        line%command = line%command(3:)
        return
      case default
        continue
      end select
    end do
    line%command = word_at(1)
    if (line%command == 'help' .and. command_argument_count() > 1) line%topic = word_at(2)
    if (line%command == 'help' .and. command_argument_count() > 2) line%input = word_at(3)
    if (line%command == 'help') return
    ! A word that ends with a blank is a file's name.
    if (len_trim(line%command) < len(line%command)) line%command = 'original'
    k = command_at(line%command)
    if (k == 1) then
      if (is_no_command(word_at(1), problems)) return
      line%command = 'original'
    end if
    call read_arguments(min(k, 2), k, line%input, line%given, problems)
    if (line%input == '' .and. line%command == 'accuracy') line%input = 'data/thesis.deck'
    if (line%input == '' .and. (k > 1 .or. problems%count() == 0)) &
      call problems%add('no ' // trim(commands(k)%called) // ' named, expected: ' // call_of(k))
    do i = 1, size(line%given)
      call take_option(line, i, problems)
    end do
    k = size(line%given)
    keeps = pack([(i, i=1, k)], [(line%given(i)%name == '--keep', i=1, k)])
    if (size(keeps) > 1) allocate (line%parts(size(keeps) - 1))
    do i = 2, size(keeps)
      line%parts(i - 1)%path = line%given(keeps(i))%value
    end do
    if (line%has('--accuracy') .and. line%has('--keep')) &
      call problems%add('--accuracy solves a sweep by several methods, --keep saves one: ' // &
                        'expected one of both')
    if (line%has('--output') .and. line%has('--upper')) &
      call problems%add('--output and --upper both name the upper surface, expected one of them')
    do i = 1, size(needs, 2)
      if (line%has(trim(needs(1, i))) .and. &
          .not. line%has(needs(2, i)(:index(needs(2, i), ' ') - 1))) &
        call problems%add(trim(needs(1, i)) // ': expected ' // trim(needs(2, i)) // ' beside it')
    end do
    if (line%choice('--fields-of') == fields_all .and. &
        line%output_path('--fields') == '/dev/stdout') &
      call problems%add('--fields-of all writes a file a state, expected no - after --fields')
    ! A part is kept in one file; several files are those of parts.
    if (line%share(2) > 1 .and. (.not. line%has('--keep') .or. allocated(line%parts))) &
      call problems%add('--share: expected one --keep with the file of this part')
    call check_files(line, problems)
    do i = 1, size(options)
      if (options(i)%command == commands(command_at(line%command))%name .and. &
          options(i)%value == 'FILE' .and. options(i)%format /= '') &
        call check_ending(line, trim(options(i)%name), trim(options(i)%format), problems)
    end do
  end subroutine parse_command_line

  ! Whether the first word was meant for a command, letters alone and no file's name, or is an
  ! option before a command.
  logical function is_no_command(word, problems)
    character(len=*), intent(in) :: word
    type(problem_list), intent(inout) :: problems
    integer :: i
    logical :: is_file

    inquire (file=word, exist=is_file)
    is_no_command = word /= '' .and. verify(lower_case(word), letters) == 0 .and. .not. is_file
    if (is_no_command) &
      call problems%add('found ' // in_quotes(word) // ', expected ' // &
                        any_of(commands(2:)%name) // ', or the file of a card deck' // &
                        did_you_mean(lower_case(word), commands(2:)%name))
    do i = 2, merge(command_argument_count(), 1, index(word, '-') == 1)
      if (is_no_command .or. command_at(word_at(i)) == 1) cycle
      is_no_command = .true.
      call problems%add('found ' // in_quotes(word) // ' before ' // word_at(i) // &
                        ', expected options after the command: ' // call_of(command_at(word_at(i))))
    end do
  end function is_no_command

  ! Takes the value of an option, by its kind in the table of options.
  subroutine take_option(line, number, problems)
    type(command_line), intent(inout) :: line
    integer, intent(in) :: number  ! place among those given
    type(problem_list), intent(inout) :: problems
    character(len=11), allocatable :: words(:)
    character(len=:), allocatable :: expected
    integer :: i
    logical :: good

    good = .true.
    associate (given => line%given(number), entry => line%given(number)%entry)
      select case (entry%value)
      case ('NAME', 'WORD')
        words = pack(entry%words, entry%words /= '')
        given%number = real(findloc(words == plain_unit(given%value), .true., 1), real64)
        expected = any_of(words) // did_you_mean(given%value, words)
      case ('N')
        given%number = real(count_of(given%value, len(decimal_text(entry%most))), real64)
        expected = 'a number from 1'
        if (entry%most < 1000000) expected = expected // ' to ' // decimal_text(entry%most)
      case ('S')
        given%number = positive_number(given%value, huge(given%number))
        expected = 'a number more than 0'
      case ('ERROR')
        given%number = positive_number(given%value, 1.0_real64)
        expected = 'a relative error between 0 and 1, for instance 1e-3'
      case ('I/N')
        call read_share(given%value, line%share, good)
        expected = 'I/N, part I of N, for instance 3/16'
      case ('X,Y')
        call read_spacing(given%value, line%pixel_spacing, good)
        expected = 'X or X,Y, each ' // expected_length
      case ('LIST')
        if (given%name == '--tables') call read_tables(given%value, line%printed, problems)
        if (given%name == '--depths') call read_depths(given%value, line%depths, good)
        expected = 'depths of 0 or more with commas, as 0,0.2, or FIRST:LAST:NUMBER, as 0.1:2:20'
      case default
        if (given%value /= '-') return
        ! Standard output holds one output, and no summary. What is kept needs a file.
        line%given(number)%value = '/dev/stdout'
        if (given%name == '--keep') &
          call problems%add('--keep: found -, expected a file, as a rerun reads it')
        do i = 1, merge(0, number - 1, given%name == '--keep')
          if (line%given(i)%value == '/dev/stdout') &
            call problems%add(line%given(i)%name // ' and ' // given%name // ' both go to ' // &
                              'standard output, expected one')
        end do
      end select
      if (any(entry%value == [character(len=5) :: 'NAME', 'WORD', 'N', 'S', 'ERROR'])) &
        good = given%number > 0.0_real64
      if (.not. good) call problems%add(given%name // ': found ' // in_quotes(given%value) // &
                                        ', expected ' // expected)
    end associate
  end subroutine take_option

  !> Whether all images work on a command, each on a part of its pieces.
  pure logical function is_shared(line)
    type(command_line), intent(in) :: line  !! the user's choices

    is_shared = line%command == 'solve' .and. .not. line%has('--accuracy')
  end function is_shared

  ! No output may take the place of another file that was named, in whatever spelling.
  subroutine check_files(line, problems)
    type(command_line), intent(in) :: line
    type(problem_list), intent(inout) :: problems
    character(len=:), allocatable :: report, option, path
    integer :: i, j

    report = canonical_path('/dev/stdout')
    call refuse_input(line, line%input, problems)
    do i = 1, size(line%given)
      if (line%given(i)%entry%value /= 'FILE') cycle
      option = line%given(i)%name
      path = line%given(i)%value
      if (same_file(path, report)) &
        call problems%add(option // ' names the file that standard output goes to, ' // path)
      do j = i + 1, size(line%given)
        if (line%given(j)%entry%value /= 'FILE') cycle
        if (same_file(path, line%given(j)%value)) call problems%add(option // ' and ' // &
            line%given(j)%name // ' both name ' // path)
      end do
    end do
  end subroutine check_files

  !> The ending of an output's name must not be that of another format than its own.
  subroutine check_ending(line, option, format, problems)
    type(command_line), intent(in) :: line          !! the user's choices
    character(len=*), intent(in) :: option          !! that names the output
    character(len=*), intent(in) :: format          !! endings of the output's formats
    type(problem_list), intent(inout) :: problems   !! what is wrong
    character(len=*), parameter :: known(*) = [character(len=4) :: 'csv', 'json', 'html', 'htm', &
      'svg', 'png', 'pdf', 'jpg', 'jpeg', 'gif', 'tif', 'tiff', 'eps', 'vtp', 'vtk', 'vtu', 'xls', &
      'xlsx', 'npy', 'h5', 'vti', 'vts']
    character(len=:), allocatable :: ending, path

    path = line%output_path(option)
    ending = lower_case(path(index(path, '.', back=.true.) + 1:))
    if (len(ending) == len(path)) return
    if (all(known /= ending) .or. &
        index('.' // format, '.' // ending(:min(3, len(ending)))) > 0) return
    call problems%add(option // ': found ' // in_quotes(path) // &
                      ', expected a name that ends with .' &
                      // trim(format) // ', as that is what is written')
  end subroutine check_ending

  !> No output may take the place of an input, be it named here or in a scene.
  subroutine refuse_input(line, input, problems)
    type(command_line), intent(in) :: line         !! the user's choices
    character(len=*), intent(in) :: input          !! path of the input
    type(problem_list), intent(inout) :: problems  !! what is wrong
    integer :: i

    ! A plane comes from no file.
    if (input == '') return
    do i = 1, size(line%given)
      ! Further files of --keep are read, too.
      if (line%given(i)%entry%value /= 'FILE' .or. &
          line%output_path(line%given(i)%name) /= line%given(i)%value) cycle
      if (same_file(line%given(i)%value, input)) &
        call problems%add(line%given(i)%name // ' names the input, ' // input)
    end do
  end subroutine refuse_input

  !> Whether an option is given. An output on standard output stands for --quiet, too.
  elemental logical function has_option(self, option)
    class(command_line), intent(in) :: self  !! the user's choices
    character(len=*), intent(in) :: option   !! with its two dashes
    integer :: i

    has_option = any([(self%given(i)%name == option .or. &
                       (option == '--quiet' .and. self%given(i)%value == '/dev/stdout'), &
                       i=1, size(self%given))])
  end function has_option

  !> The number in the value of an option, or that of its word; 0 when it was not given.
  pure real(real64) function number_of(self, option) result(number)
    class(command_line), intent(in) :: self  !! the user's choices
    character(len=*), intent(in) :: option   !! with its two dashes
    integer :: i

    number = 0.0_real64
    do i = 1, size(self%given)
      if (self%given(i)%name == option) number = self%given(i)%number
    end do
  end function number_of

  !> The same as a whole number.
  pure integer function choice_of(self, option) result(choice)
    class(command_line), intent(in) :: self  !! the user's choices
    character(len=*), intent(in) :: option   !! with its two dashes

    choice = nint(self%number(option))
  end function choice_of

  !> The path that an option names, the first one of --keep; empty when it was not given.
  pure function output_path(self, option) result(path)
    class(command_line), intent(in) :: self  !! the user's choices
    character(len=*), intent(in) :: option   !! one of those that name an output
    character(len=:), allocatable :: path    !! as the user gave it
    integer :: i

    path = ''
    do i = size(self%given), 1, -1
      if (self%given(i)%name == option) path = self%given(i)%value
    end do
  end function output_path

end module asperity_command_line
