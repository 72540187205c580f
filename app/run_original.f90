!> The command `asperity DECK`: deck, original program, report and CSV files.
module asperity_run_original
  use asperity_card_deck, only: card_deck, read_card_deck
  use asperity_command_line, only: command_line
  use asperity_complaints, only: complained
  use asperity_files, only: write_message, write_standard_error, write_standard_output
  use asperity_original, only: run_in_arithmetic
  use asperity_original_csv, only: write_original_contacts, write_original_positions
  use asperity_original_records, only: original_records, original_request
  use asperity_output_files, only: commit_files, stage_file
  use asperity_problems, only: problem_list
  use asperity_report, only: write_report
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: run_original_command

contains

  !> Runs the command. All is computed before the first byte is written,
  !> and files appear when all is written.
  subroutine run_original_command(line, status)
    type(command_line), intent(in) :: line  !! the user's choices
    integer, intent(out) :: status          !! exit status
    type(card_deck) :: deck
    type(problem_list) :: problems
    type(original_request) :: request
    type(original_records) :: records
    character(len=:), allocatable :: failure
    type(text_buffer) :: report, contacts, positions

    call read_card_deck(line%input, deck, problems)
    if (problems%count() > 0) then
      call write_standard_error(problems%text())
      status = 2
      return
    end if
    call write_standard_error(deck%notes%text())

    request%keep_contacts = line%printed .or. len(line%contacts_file) > 0
    call run_in_arithmetic(line%arithmetic, deck, request, records, failure)
    status = 1
    if (allocated(failure)) then
      call write_message(line%input // ': ' // failure)
      return
    end if
    call write_standard_error(records%notes%text())

    if (len(line%contacts_file) > 0) then
      call write_original_contacts(records, contacts)
      call stage_file(line%contacts_file, contacts%text(), failure)
      if (complained(failure)) return
    end if
    if (len(line%positions_file) > 0) then
      call write_original_positions(records, positions)
      call stage_file(line%positions_file, positions%text(), failure)
      if (complained(failure)) return
    end if
    call write_report(records, line%printed, line%carriage_control, report)
    call write_standard_output(report%text(), failure)
    if (complained(failure)) return
    call commit_files(failure)
    if (complained(failure)) return
    status = 0
  end subroutine run_original_command

end module asperity_run_original
