!> The command `asperity DECK`: deck, original program, report and CSV files.
module asperity_run_original
  use asperity_card_deck, only: card_deck, notes_of_deck, read_card_deck
  use asperity_command_line, only: command_line
  use asperity_command_outcome, only: command_outcome
  use asperity_csv_tables, only: write_original_contacts, write_original_positions, &
                                 write_original_variance
  use asperity_files, only: write_standard_error
  use asperity_original, only: arithmetic_names, run_in_arithmetic
  use asperity_original_records, only: original_records, original_request
  use asperity_report, only: write_report
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: run_original_command

contains

  !> Runs the command. All is computed before the first byte is written. Where the original program
  !> stopped, what it had printed is printed, and no file is written.
  subroutine run_original_command(line, outcome)
    type(command_line), intent(in) :: line           !! the user's choices
    type(command_outcome), intent(inout) :: outcome  !! messages, text and files
    type(card_deck) :: deck
    type(original_request) :: request
    type(original_records) :: records
    type(text_buffer) :: contacts, positions, variance
    character(len=:), allocatable :: notes

    call read_card_deck(line%input, deck, outcome%problems)
    if (outcome%problems%count() > 0) return
    call notes_of_deck(line%input, deck, notes)
    call write_standard_error(notes)
    request%keep_contacts = line%printed .or. line%has('--contacts')
    call run_in_arithmetic(trim(arithmetic_names(max(1, line%choice('--arithmetic')))), deck, &
                           request, records, outcome%failure)
    call write_standard_error(records%notes%text())
    if (allocated(outcome%failure)) then
      outcome%failure = line%input // ': ' // outcome%failure // &
                        '; the present-day solver: asperity solve ' // line%input
      outcome%is_partial = .true.
    end if
    if (line%has('--contacts')) call write_original_contacts(records, contacts)
    call outcome%stage_text(line%output_path('--contacts'), contacts)
    if (line%has('--positions')) call write_original_positions(records, positions)
    call outcome%stage_text(line%output_path('--positions'), positions)
    if (line%has('--variance')) call write_original_variance(records, variance)
    call outcome%stage_text(line%output_path('--variance'), variance)
    if (.not. line%has('--quiet') .and. allocated(records%upper%x)) &
      call write_report(records, line%printed, line%has('--carriage-control'), outcome%text)
  end subroutine run_original_command

end module asperity_run_original
