!> What every command does with a failure.
module asperity_complaints
  use asperity_files, only: write_message
  use asperity_output_files, only: discard_files
  implicit none
  private

  public :: complained

contains

  !> Whether there is a failure. If so, it is printed and no file that was begun is kept.
  logical function complained(failure)
    character(len=:), allocatable, intent(in) :: failure  !! the reason, or not allocated

    complained = allocated(failure)
    if (.not. complained) return
    call discard_files()
    call write_message(failure)
  end function complained

end module asperity_complaints
