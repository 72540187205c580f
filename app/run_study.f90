!> The command `asperity study SPEC`: the study of the representative area.
module asperity_run_study
  use asperity_area_study, only: area_study, plan_study, run_area_study, study_plan
  use asperity_command_line, only: command_line, tell_part
  use asperity_command_outcome, only: command_outcome
  use asperity_images, only: image_number
  use asperity_kept_records, only: pieces_of_part
  use asperity_kinds, only: real64
  use asperity_output_files, only: note_kept
  use asperity_problems, only: decimal_text
  use asperity_run_options, only: run_options
  use asperity_study_spec, only: read_study_spec, study_spec
  use asperity_study_tables, only: write_area_csv, write_area_table
  use asperity_text_buffer, only: text_buffer
  use asperity_work_cost, only: pieces_tried, tell_cost, work_cost
  implicit none
  private

  public :: run_study_command

contains

  !> Runs the command on every image. All is computed before the first byte is written, beside the
  !> surfaces that are kept. Image 1 has the study.
  subroutine run_study_command(line, outcome)
    type(command_line), intent(in) :: line           !! the user's choices
    type(command_outcome), intent(inout) :: outcome  !! messages, text and files
    type(study_spec) :: spec
    type(study_plan) :: plan
    type(area_study) :: study
    type(run_options) :: options
    type(text_buffer) :: csv
    type(work_cost) :: cost
    character(len=:), allocatable :: failure

    call read_study_spec(line%input, spec, outcome%problems)
    call outcome%warnings%append(spec%surfaces%notes)
    if (outcome%problems%count() == 0) then
      call plan_study(spec, plan, failure)
      if (allocated(failure)) call outcome%problems%add(line%input // ': ' // failure)
      if (line%share(2) > spec%surfaces%ensemble) &
        call outcome%problems%add('--share: found ' // decimal_text(line%share(2)) // &
                                  ' parts of ' // decimal_text(spec%surfaces%ensemble) // &
                                  ' surfaces, expected at most as many parts as surfaces')
    end if
    if (outcome%problems%count() > 0) return
    options%progress = image_number() == 1
    options%all_images = .true.
    options%keep_file = line%output_path('--keep')
    options%part = line%share(1)
    options%parts = line%share(2)
    if (allocated(line%parts)) options%more_files = line%parts
    if (line%has('--cost')) then
      cost%pieces = 'surfaces'
      cost%total = spec%surfaces%ensemble
      cost%tried = min(pieces_tried, cost%total)
      cost%bytes_each = 8.0_real64 * plan%numbers
      spec%surfaces%ensemble = cost%tried
      options%all_images = .false.
      options%keep_file = ''
    end if
    if (options%keep_file == '') call note_kept('; --keep FILE would keep what is done')
    call run_area_study(spec, plan, options, study, failure)
    if (allocated(failure)) then
      outcome%failure = line%input // ': ' // failure
    else if (line%has('--cost')) then
      cost%begun = study%begun
      cost%ended = study%ended
      call tell_cost(cost, outcome%text)
    else if (image_number() == 1 .and. options%parts > 1) then
      if (.not. line%has('--quiet')) &
        call tell_part(line, 'surfaces', pieces_of_part(spec%surfaces%ensemble, options%part, &
                                                        options%parts), outcome%text)
    else if (image_number() == 1) then
      call write_area_csv(study, csv)
      call outcome%stage_text(line%output_path('--csv'), csv)
      if (.not. line%has('--quiet')) call write_area_table(spec, study, outcome%text)
    end if
  end subroutine run_study_command

end module asperity_run_study
