!> The command `asperity solve SCENE`: scene, present-day solver, summary and CSV files.
module asperity_run_solve
  use asperity_accuracy_choice, only: solve_to_accuracy
  use asperity_budget_table, only: write_budget
  use asperity_complaints, only: complained
  use asperity_command_line, only: command_line, is_shared, refuse_input
  use asperity_contact_records, only: scene_results, solve_method
  use asperity_corrected_table, only: correct_table
  use asperity_card_deck, only: card_deck
  use asperity_effect_report, only: effect_report
  use asperity_effect_solver, only: solve_with_effects
  use asperity_error_budget, only: error_budget, measure_budget
  use asperity_files, only: read_whole_file, write_message, write_standard_error, &
                            write_standard_output
  use asperity_images, only: image_number
  use asperity_kept_records, only: checksum, kept_work
  use asperity_kinds, only: real64
  use asperity_original, only: run_in_arithmetic
  use asperity_original_records, only: original_records, original_request
  use asperity_output_files, only: commit_files, stage_file
  use asperity_position_loop, only: use_threads
  use asperity_position_rounds, only: share_next_sweep
  use asperity_problems, only: problem_list
  use asperity_progress, only: allow_progress
  use asperity_results_csv, only: write_contacts, write_curve, write_positions
  use asperity_scene_reader, only: read_scene
  use asperity_scene_values, only: is_thesis_sweep, scene
  use asperity_solver, only: solve_in_arithmetic
  use asperity_summary, only: write_choice, write_corrected_table, write_summary
  use asperity_text_buffer, only: text_buffer
  use asperity_version, only: version
  implicit none
  private

  public :: run_solve_command

contains

  !> Runs the command. All is computed before the first byte is written, beside the positions that
  !> are kept, and files appear when all is written. Image 1 writes and complains for all.
  subroutine run_solve_command(line, status)
    type(command_line), intent(in) :: line  !! the user's choices
    integer, intent(out) :: status          !! exit status
    type(scene) :: scene_in
    type(problem_list) :: problems
    type(scene_results) :: results
    type(effect_report) :: effects
    type(text_buffer) :: summary, contacts, positions, curve
    character(len=:), allocatable :: arithmetic, failure
    type(error_budget) :: budget
    type(kept_work) :: work
    real(real64) :: bound
    logical :: keep_rows, thesis_sweep, with_effects

    call read_scene(line%input, scene_in, problems)
    if (problems%count() == 0) then
      call refuse_input(line, scene_in%upper%file, problems)
      if (scene_in%lower%file /= scene_in%upper%file) &
        call refuse_input(line, scene_in%lower%file, problems)
    end if
    with_effects = scene_in%effects%any_on() .or. allocated(scene_in%loading%path)
    if (problems%count() == 0 .and. with_effects) call refuse_precision(line, problems)
    if (problems%count() > 0) then
      if (image_number() == 1) call write_standard_error(problems%text())
      status = 2
      return
    end if
    status = 1
    if (image_number() == 1) then
      call write_standard_error(scene_in%notes%text())
      call allow_progress()
    end if
    call use_threads(line%threads)
    arithmetic = 'real64'
    if (line%arithmetic /= '') arithmetic = line%arithmetic
    thesis_sweep = is_thesis_sweep(scene_in)
    keep_rows = line%contacts_file /= '' .or. thesis_sweep
    if (is_shared(line)) then
      call name_work(line, scene_in, arithmetic, keep_rows, work, failure)
      if (allocated(failure)) then
        if (image_number() == 1) call write_message(failure)
        return
      end if
      call share_next_sweep(work)
    end if
    if (with_effects) then
      call solve_with_effects(scene_in, keep_rows, results, effects, failure)
    else if (line%accuracy > 0.0_real64) then
      call solve_to_accuracy(scene_in, line%accuracy, keep_rows, results, arithmetic, bound, &
                             failure)
    else
      call solve_in_arithmetic(arithmetic, scene_in, solve_method(), keep_rows, results, failure)
    end if
    if (image_number() > 1) then
      ! Image 1 has all results.
      if (.not. allocated(failure)) status = 0
      return
    end if
    if (.not. allocated(failure) .and. line%budget) &
      call measure_budget(scene_in, arithmetic, results, budget, failure)
    if (allocated(failure)) failure = line%input // ': ' // failure
    if (complained(failure)) return

    if (.not. line%quiet) then
      call write_summary(scene_in, arithmetic // ', exact events', results, effects, summary)
      if (line%accuracy > 0.0_real64) &
        call write_choice(line%accuracy, arithmetic // ', exact events', bound, summary)
      if (line%budget) call write_budget(budget, size(results%positions), summary)
      if (thesis_sweep) call add_corrected_table(scene_in%deck, results, summary)
    end if
    if (line%contacts_file /= '') then
      call write_contacts(results, effects, contacts)
      call stage_file(line%contacts_file, contacts%text(), failure)
      if (complained(failure)) return
    end if
    if (line%positions_file /= '') then
      call write_positions(results, effects, positions)
      call stage_file(line%positions_file, positions%text(), failure)
      if (complained(failure)) return
    end if
    if (line%curve_file /= '') then
      call write_curve(results, curve)
      call stage_file(line%curve_file, curve%text(), failure)
      if (complained(failure)) return
    end if
    call write_standard_output(summary%text(), failure)
    if (complained(failure)) return
    call commit_files(failure)
    if (complained(failure)) return
    status = 0
  end subroutine run_solve_command

  ! What a file of kept positions is for: all files that the scene is made of, and what else the
  ! results depend on.
  subroutine name_work(line, scene_in, arithmetic, keep_rows, work, failure)
    type(command_line), intent(in) :: line
    type(scene), intent(in) :: scene_in
    character(len=*), intent(in) :: arithmetic
    logical, intent(in) :: keep_rows
    type(kept_work), intent(out) :: work
    character(len=:), allocatable, intent(out) :: failure

    work%path = line%keep_file
    work%piece = 'position'
    work%of_what = 'this scene, arithmetic and list of contacts'
    work%heading = 'asperity ' // version // ' solve, ' // arithmetic // ', contacts ' // &
                   trim(merge('kept  ', 'summed', keep_rows)) // ', input'
    if (work%path == '') return
    ! Every image reads them: what fails on one fails on all, and nobody waits for the others.
    call add_file(line%input)
    call add_file(scene_in%upper%file)
    if (scene_in%lower%file /= scene_in%upper%file) call add_file(scene_in%lower%file)

  contains

    subroutine add_file(path)
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: text, why

      if (allocated(failure)) return
      call read_whole_file(path, text, why)
      if (.not. allocated(why)) then
        work%heading = work%heading // ' ' // checksum(text)
        if (len(text) == 0) why = path // ': cannot be read again, as --keep needs it'
      end if
      if (allocated(why)) failure = why
    end subroutine add_file

  end subroutine name_work

  ! Effects and paths are computed in doubles only.
  subroutine refuse_precision(line, problems)
    type(command_line), intent(in) :: line
    type(problem_list), intent(inout) :: problems

    if (line%arithmetic /= '' .and. line%arithmetic /= 'real64') &
      call problems%add('--arithmetic ' // line%arithmetic // ': effects and paths of several ' // &
                        'values are computed in real64, expected that or none')
    if (line%accuracy > 0.0_real64) &
      call problems%add('--accuracy: effects and paths of several values are computed in ' // &
                        'real64 only, expected none')
  end subroutine refuse_precision

  !> Runs the original beside, and prints Table VI before and after. A deck on which the original
  !> goes astray has no such table.
  subroutine add_corrected_table(deck, results, summary)
    type(card_deck), intent(in) :: deck
    type(scene_results), intent(in) :: results
    type(text_buffer), intent(inout) :: summary
    type(original_records) :: historic, exact_arithmetic
    character(len=:), allocatable :: failure

    call run_in_arithmetic('ibm370', deck, original_request(), historic, failure)
    if (.not. allocated(failure)) &
      call run_in_arithmetic('real128', deck, original_request(), exact_arithmetic, failure)
    if (allocated(failure)) then
      call summary%line('')
      call summary%line('no Table VI to correct: the original stops at ' // failure)
    else
      call write_corrected_table(correct_table(historic, exact_arithmetic, results), summary)
    end if
  end subroutine add_corrected_table

end module asperity_run_solve
