!> The command `asperity study SPEC`: the study of the representative area.
module asperity_run_study
  use asperity_area_study, only: run_area_study
  use asperity_area_study_plan, only: plan_study, study_plan
  use asperity_area_study_statistics, only: area_study
  use asperity_area_study_table, only: write_area_csv, write_area_table
  use asperity_complaints, only: complained
  use asperity_command_line, only: command_line
  use asperity_files, only: write_standard_error, write_standard_output
  use asperity_images, only: image_number
  use asperity_output_files, only: commit_files, stage_file
  use asperity_problems, only: problem_list
  use asperity_run_options, only: run_options
  use asperity_study_spec, only: read_study_spec, study_spec
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: run_study_command

contains

  !> Runs the command on every image. All is computed before the first byte is written, beside the
  !> surfaces that are kept. Image 1 writes and complains for all.
  subroutine run_study_command(line, status)
    type(command_line), intent(in) :: line  !! the user's choices
    integer, intent(out) :: status          !! exit status
    type(study_spec) :: spec
    type(study_plan) :: plan
    type(area_study) :: study
    type(run_options) :: options
    type(problem_list) :: problems
    type(text_buffer) :: table, csv
    character(len=:), allocatable :: failure

    call read_study_spec(line%input, spec, problems)
    if (problems%count() == 0) then
      call plan_study(spec, plan, failure)
      if (allocated(failure)) call problems%add(line%input // ': ' // failure)
    end if
    if (problems%count() > 0) then
      if (image_number() == 1) call write_standard_error(problems%text())
      status = 2
      return
    end if
    status = 1
    options%progress = image_number() == 1
    options%all_images = .true.
    options%keep_file = line%keep_file
    call run_area_study(spec, plan, options, study, failure)
    if (allocated(failure)) failure = line%input // ': ' // failure
    if (image_number() > 1) then
      if (.not. allocated(failure)) status = 0
      return
    end if
    if (complained(failure)) return
    if (line%csv_file /= '') then
      call write_area_csv(study, csv)
      call stage_file(line%csv_file, csv%text(), failure)
      if (complained(failure)) return
    end if
    if (.not. line%quiet) call write_area_table(spec, study, table)
    call write_standard_output(table%text(), failure)
    if (complained(failure)) return
    call commit_files(failure)
    if (complained(failure)) return
    status = 0
  end subroutine run_study_command

end module asperity_run_study
