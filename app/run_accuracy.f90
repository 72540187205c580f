!> The command `asperity accuracy [DECK or SCENE]`: the study of what accuracy costs in time.
module asperity_run_accuracy
  use asperity_accuracy_study, only: accuracy_row, number_of_ways, run_accuracy_study
  use asperity_accuracy_table, only: write_accuracy_csv, write_accuracy_table
  use asperity_card_deck, only: card_deck
  use asperity_command_line, only: command_line, refuse_input
  use asperity_command_outcome, only: command_outcome
  use asperity_files, only: same_name
  use asperity_kinds, only: real64
  use asperity_model_rungs, only: model_rung, number_of_rungs, run_model_rungs
  use asperity_progress, only: progress_line
  use asperity_scene_reader, only: read_scene
  use asperity_scene_values, only: control_limit, criterion_load, is_thesis_sweep, scene
  use asperity_text_buffer, only: text_buffer
  use asperity_timing, only: time_allowance
  use asperity_work_cost, only: tell_cost, work_cost
  implicit none
  private

  public :: run_accuracy_command

  ! Time spent on every row at most, s: enough for a steady median; and what all of them may take
  ! when the user does not say.
  real(real64), parameter :: seconds_a_row = 0.2_real64, usual_seconds = 60.0_real64
  ! Time that is spent to tell what all of it would take.
  real(real64), parameter :: seconds_of_trial = 2.0_real64

contains

  !> Runs the command. All is computed before the first byte is written.
  subroutine run_accuracy_command(line, outcome)
    type(command_line), intent(in) :: line           !! the user's choices
    type(command_outcome), intent(inout) :: outcome  !! what to tell and write
    type(scene) :: scene_in
    type(card_deck), allocatable :: deck
    type(accuracy_row), allocatable :: rows(:)
    type(model_rung), allocatable :: rungs(:)
    type(text_buffer) :: csv
    character(len=:), allocatable :: left_out
    type(time_allowance) :: allowance
    type(progress_line) :: progress
    type(work_cost) :: cost
    real(real64) :: seconds, least_seconds
    integer :: ways_left_out, pieces

    call read_scene(line%input, scene_in, outcome%problems)
    if (outcome%problems%count() == 0) then
      call refuse_input(line, scene_in%upper%file, outcome%problems)
      if (.not. same_name(scene_in%lower%file, scene_in%upper%file)) &
        call refuse_input(line, scene_in%lower%file, outcome%problems)
      if (allocated(scene_in%map)) &
        call outcome%problems%add(line%input // ': the accuracy study takes no ' // &
                                  'map, expected surfaces of summits')
      if (scene_in%loading%control /= control_limit .or. &
          scene_in%limit%criterion /= criterion_load) &
        call outcome%problems%add(line%input // ': the accuracy study needs a scene that ends ' // &
                                  'at a limit load: control = ''limit'', criterion = ''load''')
    end if
    if (outcome%problems%count() > 0) return
    if (is_thesis_sweep(scene_in)) call move_alloc(scene_in%deck, deck)
    seconds = merge(line%seconds, usual_seconds, line%seconds > 0.0_real64)
    pieces = number_of_ways(allocated(deck)) + number_of_rungs
    if (line%cost) then
      cost%pieces = 'ways of computing'
      cost%total = pieces
      cost%most_seconds = seconds
      seconds = min(seconds, seconds_of_trial)
      call cpu_time(cost%begun)
    end if
    least_seconds = min(seconds_a_row, seconds / (2 * pieces))
    call allowance%begin(seconds)
    call progress%begin(.true., 'ways of computing', pieces, 0)
    call run_accuracy_study(scene_in, deck, least_seconds, allowance, progress, rows, &
                            ways_left_out, outcome%failure)
    if (.not. allocated(outcome%failure)) &
      call run_model_rungs(scene_in, least_seconds, allowance, progress, rungs, left_out, &
                           outcome%failure)
    call progress%finish()
    if (line%cost) then
      ! What takes longer than the trial may take is no failure of it.
      if (allocated(outcome%failure)) deallocate (outcome%failure)
      if (allocated(rows)) cost%tried = max(1, size(rows))
      if (allocated(rungs)) cost%tried = cost%tried + size(rungs)
      call tell_cost(cost, outcome%text)
      return
    end if
    if (allocated(outcome%failure)) then
      outcome%failure = line%input // ': ' // outcome%failure
      return
    end if
    call write_accuracy_csv(rows, rungs, csv)
    call outcome%stage(line%output('--csv'), csv)
    if (.not. line%quiet) &
      call write_accuracy_table(rows, ways_left_out, rungs, left_out, outcome%text)
  end subroutine run_accuracy_command

end module asperity_run_accuracy
