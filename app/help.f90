!> What the program says of itself.
module asperity_help
  use asperity_files, only: write_standard_error, write_standard_output
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: show_help, show_next_steps, show_version

  character(len=*), parameter :: version = '0.1.0'

contains

  !> The words after a bare `asperity`.
  subroutine show_next_steps(status)
    integer, intent(out) :: status  !! exit status
    type(text_buffer) :: text

    call text%line('asperity: contact between rough surfaces of spherical asperities')
    call text%line('')
    call text%line('Type next:')
    call text%line('  asperity data/thesis.deck      print the report of the original program')
    call text%line('  asperity --help                all commands and options')
    call text%line('With fpm: fpm run -- data/thesis.deck')
    call print_text(text, status)
  end subroutine show_next_steps

  !> All commands and options.
  subroutine show_help(status)
    integer, intent(out) :: status  !! exit status
    type(text_buffer) :: text

    call text%line('Usage: asperity [OPTIONS] DECK')
    call text%line('')
    call text%line('Runs the original program on a card deck and prints its report.')
    call text%line('')
    call text%line('Options')
    call text%line('  --arithmetic NAME   ibm370 (default), real32, real64 or real128')
    call text%line('  --tables LIST       positions whose contact table is printed: none, all, or')
    call text%line('                      numbers from 1 to 100 with commas (default 13,55,56)')
    call text%line('  --contacts FILE     write every contact of every approach as CSV')
    call text%line('  --positions FILE    write the last approach of every position as CSV')
    call text%line('  --carriage-control  keep the line printer''s column one (1, 0, blank)')
    call text%line('  --help, --version')
    call text%line('')
    call text%line('Exit status: 0 done, 1 could not be computed, 2 bad command line or bad input')
    call print_text(text, status)
  end subroutine show_help

  !> Name and version.
  subroutine show_version(status)
    integer, intent(out) :: status  !! exit status
    type(text_buffer) :: text

    call text%line('asperity ' // version)
    call print_text(text, status)
  end subroutine show_version

  subroutine print_text(text, status)
    type(text_buffer), intent(in) :: text
    integer, intent(out) :: status
    character(len=:), allocatable :: failure

    status = 0
    call write_standard_output(text%text(), failure)
    if (.not. allocated(failure)) return
    call write_standard_error(failure // new_line('a'))
    status = 1
  end subroutine print_text

end module asperity_help
