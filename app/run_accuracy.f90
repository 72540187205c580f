!> The command `asperity accuracy [DECK or SCENE]`: the study of what accuracy costs in time.
module asperity_run_accuracy
  use asperity_accuracy_page, only: write_accuracy_page
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
  use asperity_way_beside, only: add_exponent, add_input_error, add_theories
  use asperity_way_study, only: most_ways, run_way_study, way_table
  use asperity_way_table_text, only: write_way_table
  use asperity_work_cost, only: tell_cost, work_cost
  implicit none
  private

  public :: run_accuracy_command

  ! Time spent on every row at most, s: enough for a steady median; and what all of them may take
  ! when the user does not say.
  real(real64), parameter :: seconds_a_row = 0.2_real64, usual_seconds = 60.0_real64
  ! Of the time of a sweep, what the ways that serve any scene may take at most.
  real(real64), parameter :: share_of_ways = 1.0_real64 / 3.0_real64
  ! Time spent on estimating the run time of all methods.
  real(real64), parameter :: seconds_of_trial = 2.0_real64

contains

  !> Runs the command. All is computed before the first byte is written.
  subroutine run_accuracy_command(line, outcome)
    type(command_line), intent(in) :: line           !! the user's choices
    type(command_outcome), intent(inout) :: outcome  !! messages, text and files
    type(scene) :: scene_in
    type(card_deck), allocatable :: deck
    type(accuracy_row), allocatable :: rows(:)
    type(model_rung), allocatable :: rungs(:)
    type(way_table) :: table
    type(text_buffer) :: csv, page
    character(len=:), allocatable :: left_out, no_sweep
    type(time_allowance) :: allowance
    type(progress_line) :: progress
    type(work_cost) :: cost
    real(real64) :: seconds, least_seconds
    integer :: pieces, ways, ways_left_out
    logical :: is_sweep

    call read_scene(line%input, scene_in, outcome%problems)
    if (outcome%problems%count() == 0) then
      call refuse_input(line, scene_in%upper%file, outcome%problems)
      if (.not. same_name(scene_in%lower%file, scene_in%upper%file)) &
        call refuse_input(line, scene_in%lower%file, outcome%problems)
    end if
    if (outcome%problems%count() > 0) return
    is_sweep = scene_in%loading%control == control_limit .and. &
               scene_in%limit%criterion == criterion_load .and. .not. allocated(scene_in%map)
    seconds = merge(line%seconds, usual_seconds, line%seconds > 0.0_real64)
    pieces = most_ways
    if (is_sweep) pieces = pieces + number_of_ways(is_thesis_sweep(scene_in)) + number_of_rungs
    if (line%cost) then
      cost%pieces = 'methods'
      cost%total = pieces
      cost%most_seconds = seconds
      seconds = min(seconds, seconds_of_trial)
      call cpu_time(cost%begun)
    end if
    least_seconds = min(seconds_a_row, seconds / (2 * pieces))
    call progress%begin(.true., 'methods', pieces, 0)
    ! A sweep to the limit has a study of its own behind, which takes longer.
    call allowance%begin(merge(share_of_ways, 1.0_real64, is_sweep) * seconds)
    call run_way_study(scene_in, 0.25_real64 * least_seconds, allowance, progress, table, &
                       outcome%failure)
    ways = 0
    if (.not. allocated(outcome%failure)) then
      ways = size(table%rows)
      call add_input_error(scene_in, allowance, table)
      call add_theories(scene_in, table)
      call add_exponent(scene_in, table)
    end if
    call progress%reach(most_ways)
    allocate (rows(0), rungs(0))
    if (is_sweep .and. .not. allocated(outcome%failure)) then
      call allowance%begin((1.0_real64 - share_of_ways) * seconds + &
                           max(0.0_real64, allowance%left()))
      if (is_thesis_sweep(scene_in)) call move_alloc(scene_in%deck, deck)
      call run_accuracy_study(scene_in, deck, least_seconds, allowance, progress, rows, &
                              ways_left_out, no_sweep)
      if (.not. allocated(no_sweep)) &
        call run_model_rungs(scene_in, least_seconds, allowance, progress, rungs, left_out, &
                             no_sweep)
    end if
    call progress%finish()
    if (line%cost) then
      ! What takes longer than the trial may take is no failure of it.
      if (allocated(outcome%failure)) deallocate (outcome%failure)
      cost%tried = max(1, size(rows) + size(rungs) + ways)
      call tell_cost(cost, outcome%text)
      return
    end if
    if (allocated(outcome%failure)) then
      outcome%failure = line%input // ': ' // outcome%failure
      return
    end if
    if (allocated(no_sweep)) then
      rows = rows(:0)
      rungs = rungs(:0)
    end if
    call write_accuracy_csv(rows, rungs, table, csv)
    call outcome%stage(line%output('--csv'), csv)
    if (line%output('--html') /= '') then
      call write_accuracy_page(line%input, table, page)
      call outcome%stage(line%output('--html'), page)
    end if
    if (line%quiet) return
    if (allocated(no_sweep)) then
      call outcome%text%line('The sweep in every arithmetic and step is left out: ' // no_sweep)
      call outcome%text%line('')
    else if (is_sweep) then
      call write_accuracy_table(rows, ways_left_out, rungs, left_out, outcome%text)
      call outcome%text%line('')
    end if
    call write_way_table(table, outcome%text)
  end subroutine run_accuracy_command

end module asperity_run_accuracy
