!> Outcome of a command: messages, printed text and staged files. The program prints and writes them
!> in one place for all commands.
module asperity_command_outcome
  use asperity_files, only: write_standard_error, write_standard_output
  use asperity_images, only: image_number
  use asperity_output_files, only: commit_files, discard_files, stage_file
  use asperity_printable, only: printable_text
  use asperity_problems, only: not_enough_memory, problem_list
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: command_outcome, finish_command

  !> The outcome of a command. Image 1 prints and writes for all images.
  type :: command_outcome
    type(problem_list) :: problems           !! what is wrong with the input
    type(problem_list) :: warnings           !! what of the results lies outside a theory
    character(len=:), allocatable :: failure !! why it could not be computed, or written
    type(text_buffer) :: text                !! for standard output
    logical :: is_partial = .false.          !! the text is what stands until a failure
  contains
    procedure :: stage_text                  !! a file that appears when all is written
  end type command_outcome

contains

  !> Writes a file beside its place, unless none is named or something has failed.
  subroutine stage_text(self, path, text)
    class(command_outcome), intent(inout) :: self  !! outcome whose failure is set when the file
                                                   !! cannot be written
    character(len=*), intent(in) :: path           !! as the user gave it, or empty
    type(text_buffer), intent(in) :: text          !! bytes of the file

    if (path == '' .or. allocated(self%failure)) return
    if (text%failed) self%failure = path // ': ' // not_enough_memory // ' for its text'
    if (allocated(self%failure) .or. .not. allocated(text%store)) return
    call stage_file(path, text%store(:text%used), self%failure)
  end subroutine stage_text

  !> Prints the problems, or prints the text and renames the staged files to their final names.
  subroutine finish_command(outcome, status)
    type(command_outcome), intent(inout) :: outcome  !! of the command
    integer, intent(out) :: status                   !! exit status of the process: 0, 1 or 2
    character(len=:), allocatable :: unwritten

    status = 0
    if (outcome%problems%count() > 0) then
      status = merge(1, 2, outcome%problems%lacks_memory)
      if (image_number() == 1) call write_standard_error(outcome%problems%text())
      return
    end if
    if (image_number() == 1) then
      if (outcome%text%failed .and. .not. allocated(outcome%failure)) &
        outcome%failure = 'standard output: ' // not_enough_memory // ' for its text'
      if ((.not. allocated(outcome%failure) .or. outcome%is_partial) .and. outcome%text%used > 0) &
        call write_standard_output(outcome%text%store(:outcome%text%used), unwritten)
      if (allocated(unwritten)) call move_alloc(unwritten, outcome%failure)
      if (.not. allocated(outcome%failure)) call commit_files(outcome%failure)
      if (allocated(outcome%failure)) then
        call discard_files()
        call write_standard_error(printable_text(outcome%failure) // new_line('a'))
      else
        call write_standard_error(outcome%warnings%text())
      end if
    end if
    if (allocated(outcome%failure)) status = 1
  end subroutine finish_command

end module asperity_command_outcome
