!> The command `asperity accuracy [DECK or SCENE]`: the study of what accuracy costs in time.
module asperity_run_accuracy
  use asperity_accuracy_table, only: write_accuracy_csv, write_accuracy_table
  use asperity_command_line, only: command_line, refuse_input
  use asperity_command_outcome, only: command_outcome
  use asperity_files, only: same_name
  use asperity_kinds, only: real64
  use asperity_method_study, only: method_table, study_scene
  use asperity_scene_reader, only: read_scene
  use asperity_scene_values, only: scene
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: run_accuracy_command

  ! Time that all methods may take when the user does not say, s.
  real(real64), parameter :: usual_seconds = 60.0_real64

contains

  !> Runs the command. All is computed before the first byte is written.
  subroutine run_accuracy_command(line, outcome)
    type(command_line), intent(in) :: line           !! the user's choices
    type(command_outcome), intent(inout) :: outcome  !! messages, text and files
    type(scene) :: scene_in
    type(method_table) :: table
    type(text_buffer) :: csv
    real(real64) :: seconds

    call read_scene(line%input, scene_in, outcome%problems)
    if (outcome%problems%count() == 0) then
      call refuse_input(line, scene_in%upper%file, outcome%problems)
      if (.not. same_name(scene_in%lower%file, scene_in%upper%file)) &
        call refuse_input(line, scene_in%lower%file, outcome%problems)
    end if
    if (outcome%problems%count() > 0) return
    seconds = merge(line%number('--seconds'), usual_seconds, line%has('--seconds'))
    call study_scene(scene_in, seconds, merge(2.0_real64, 1.0_real64, line%has('--finer')), &
                     .true., table, outcome%failure)
    if (allocated(outcome%failure)) then
      outcome%failure = line%input // ': ' // outcome%failure
      return
    end if
    call write_accuracy_csv(table, csv)
    call outcome%stage_text(line%output_path('--csv'), csv)
    if (.not. line%has('--quiet')) call write_accuracy_table(scene_in, table, outcome%text)
  end subroutine run_accuracy_command

end module asperity_run_accuracy
