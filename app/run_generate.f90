!> The command `asperity generate SPEC`: random surfaces as CSV files or as a card deck, or a random
!> height map.
module asperity_run_generate
  use asperity_command_line, only: check_ending, command_line, refuse_input
  use asperity_command_outcome, only: command_outcome
  use asperity_files, only: write_standard_error, write_standard_output
  use asperity_generated_map, only: generate_map
  use asperity_generated_surface, only: generate_surface, generated_surface, plan_surface, &
                                         surface_plan
  use asperity_generation_spec, only: read_generation_spec
  use asperity_generation_values, only: generation_spec
  use asperity_height_map, only: height_map, length_units
  use asperity_input_text, only: replaced_text
  use asperity_kinds, only: int64
  use asperity_map_file, only: check_map_path, note_of_file, stage_map_file
  use asperity_output_files, only: commit_files, discard_files, same_file, stage_file
  use asperity_problems, only: decimal_text, problem_list
  use asperity_surface_text, only: surface_as_csv, surfaces_as_deck
  implicit none
  private

  public :: run_generate_command

contains

  !> Runs the command. The files of one member of the ensemble appear together.
  subroutine run_generate_command(line, outcome)
    type(command_line), intent(in) :: line           !! the user's choices
    type(command_outcome), intent(inout) :: outcome  !! messages, text and files
    type(generation_spec) :: spec
    type(surface_plan) :: plans(2)
    ! Members whose files appear together: two files each, below the number that can be staged.
    integer, parameter :: members_at_once = 500
    integer :: last, member

    call read_generation_spec(line%input, spec, outcome%problems)
    call outcome%warnings%append(spec%notes)
    if (spec%is_map) then
      call make_map(line, spec, outcome)
      return
    end if
    if (outcome%problems%count() == 0) call check_outputs(line, spec, outcome%problems)
    if (outcome%problems%count() > 0) return
    call plan_surface(spec, 1, plans(1))
    call plan_surface(spec, 2, plans(2))
    last = merge(line%choice('--surface'), spec%ensemble, line%has('--surface'))
    do member = max(1, line%choice('--surface')), last
      call make_member(line, spec, plans, member, outcome%failure)
      if (allocated(outcome%failure)) then
        call discard_files()
        return
      end if
      if (mod(member, members_at_once) == 0 .or. member == last) &
        call commit_files(outcome%failure)
      if (allocated(outcome%failure)) return
    end do
  end subroutine run_generate_command

  !> Makes a height map and stages its file, or prints it as text.
  subroutine make_map(line, spec, outcome)
    type(command_line), intent(in) :: line
    type(generation_spec), intent(in) :: spec
    type(command_outcome), intent(inout) :: outcome
    type(height_map) :: map
    character(len=:), allocatable :: note
    character(len=2) :: unit

    if (outcome%problems%count() > 0) return
    unit = ''
    if (spec%map%unit > 0) unit = length_units(spec%map%unit)
    if (line%has('--surface')) &
      call outcome%problems%add('--surface: found for a height map, expected none')
    if (line%has('--upper') .or. line%has('--lower')) &
      call outcome%problems%add('--upper and --lower: found for a height map, expected --output')
    call check_map_path(line%output_path('--output'), trim(unit), outcome%problems)
    if (outcome%problems%count() > 0) return
    call generate_map(spec%map, map, outcome%failure)
    if (allocated(outcome%failure)) then
      outcome%failure = spec%file // ': ' // outcome%failure
      return
    end if
    call stage_map_file(line%output_path('--output'), map, outcome%problems, outcome%failure)
    note = note_of_file(line%output_path('--output'), map)
    if (note /= '') call outcome%warnings%add(note)
  end subroutine make_map

  !> Checks that the outputs named on the command line fit the specification.
  subroutine check_outputs(line, spec, problems)
    type(command_line), intent(in) :: line
    type(generation_spec), intent(in) :: spec
    type(problem_list), intent(inout) :: problems
    character(len=*), parameter :: options(3) = [character(len=8) :: '--output', '--upper', &
      '--lower']
    character(len=:), allocatable :: pattern
    integer :: i, member

    call check_ending(line, '--output', 'csv', problems)
    if (line%choice('--surface') > spec%ensemble) &
      call problems%add('--surface: found ' // decimal_text(line%choice('--surface')) // &
                        ', expected at most ' // decimal_text(spec%ensemble) // &
                        ', the ensemble of ' // spec%file)
    if (spec%is_deck .and. (line%has('--upper') .or. line%has('--lower'))) &
      call problems%add('--upper and --lower: found for a deck, expected --output, as a deck ' // &
                        'holds both surfaces')
    do i = 1, size(options)
      pattern = line%output_path(options(i))
      if (pattern == '') cycle
      if (spec%ensemble > 1 .and. .not. line%has('--surface') .and. index(pattern, '%') == 0) &
        call problems%add(trim(options(i)) // ': found ' // pattern // ' for ' // &
                          decimal_text(spec%ensemble) // ' surfaces, expected % in it for ' // &
                          'their numbers, or --surface N')
      do member = 1, spec%ensemble
        if (index(pattern, '%') == 0) exit
        if (same_file(replaced_text(pattern, '%', decimal_text(member)), spec%file)) &
          call problems%add(trim(options(i)) // ' names the input, ' // spec%file)
      end do
    end do
    if (spec%ensemble > 1 .and. .not. any(line%has([character(len=9) :: '--surface', options]))) &
      call problems%add('standard output holds one surface, found an ensemble of ' // &
                        decimal_text(spec%ensemble) // ', expected --surface N, or files with ' // &
                        '% in their names')
    call refuse_input(line, spec%file, problems)
  end subroutine check_outputs

  ! Makes the surfaces of a member of the ensemble and stages their files, or that of the deck; the
  ! upper surface, or the deck, goes to standard output when no file is named.
  subroutine make_member(line, spec, plans, member, failure)
    type(command_line), intent(in) :: line
    type(generation_spec), intent(in) :: spec
    type(surface_plan), intent(in) :: plans(2)
    integer, intent(in) :: member
    character(len=:), allocatable, intent(out) :: failure
    type(generated_surface) :: surface(2)
    type(problem_list) :: notes
    character(len=:), allocatable :: upper, lower, text
    integer(int64) :: used
    integer :: i, side

    upper = line%output_path('--output') // line%output_path('--upper')
    lower = line%output_path('--lower')
    do side = 1, 2
      if (.not. spec%is_deck .and. (side == 1 .and. upper == '' .and. lower /= '' .or. &
                                    side == 2 .and. lower == '')) cycle
      i = merge(side, 1, spec%is_deck)
      call generate_surface(plans(side), member, surface(i), failure)
      if (allocated(failure)) failure = spec%file // ': ' // failure
      if (allocated(failure)) return
      if (spec%is_deck) cycle
      call surface_as_csv(surface(1), text, used)
      if (side == 1) call send_text(upper, member, text(:used), failure)
      if (side == 2) call send_text(lower, member, text(:used), failure)
      if (allocated(failure)) return
    end do
    if (.not. spec%is_deck) return
    call surfaces_as_deck(spec, surface(1), surface(2), text, notes)
    call write_standard_error(notes%text())
    call send_text(upper, member, text, failure)
  end subroutine make_member

  !> Stages a file, or prints its text when none is named.
  subroutine send_text(pattern, member, text, failure)
    character(len=*), intent(in) :: pattern
    integer, intent(in) :: member
    character(len=*), intent(in) :: text
    character(len=:), allocatable, intent(out) :: failure

    if (pattern == '') then
      call write_standard_output(text, failure)
    else
      call stage_file(replaced_text(pattern, '%', decimal_text(member)), text, failure)
    end if
  end subroutine send_text

end module asperity_run_generate
