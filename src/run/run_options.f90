!> How a run is done: all that is not in the scene.
module asperity_run_options
  use asperity_contact_field, only: fields_all, fields_none
  use asperity_interruption, only: interruption
  use asperity_kept_records, only: kept_file
  use asperity_kinds, only: real64
  use asperity_problems, only: decimal_text, problem_list, real_text
  use asperity_solution_start, only: solution_reuse
  use asperity_work_count, only: work_count
  implicit none
  private

  public :: check_options, run_options

  ! More threads than this are a slip.
  integer, parameter :: most_threads = 9999

  !> The choices. As they stand: exact events in doubles, contacts kept, all cores, nothing shown.
  type :: run_options
    character(len=7) :: arithmetic = 'real64'      !! ibm370, real32, real64 or real128
    !> Relative error of every total that is allowed: the cheapest arithmetic that has it is taken.
    !> 0: none is asked for.
    real(real64) :: accuracy = 0.0_real64
    logical :: keep_contacts = .true.              !! keep the contacts of every state
    integer :: threads = 0                         !! 0: as many as OpenMP gives
    logical :: progress = .false.                  !! print the progress on a terminal
    integer :: sample = 0                          !! solve so many positions, spread; 0: all
    logical :: all_images = .false.                !! all images of the run call, and share the work
    character(len=:), allocatable :: keep_file     !! positions are kept there as they are solved
    integer :: part = 1                            !! of the positions, to be solved and kept alone
    integer :: parts = 1                           !! so many there are
    !> Files of further parts: all are there, and are joined; not allocated: this is no such run.
    type(kept_file), allocatable :: more_files(:)
    !> States of a height map solved on its pixels that keep pressure, gap and displacement:
    !> `fields_none`, `fields_last`, `fields_all`. Other scenes, and positions from a file of kept
    !> positions, have none.
    integer :: fields = fields_none
    type(interruption) :: interrupt = interruption()  !! another thread can end the run, which fails
    type(work_count) :: count = work_count()          !! another thread can see how far the run is
    type(solution_reuse) :: reuse = solution_reuse()  !! solutions of an earlier run
  end type run_options

contains

  !> Adds what is wrong with the choices that are numbers.
  subroutine check_options(options, problems)
    type(run_options), intent(in) :: options       !! any
    type(problem_list), intent(inout) :: problems  !! a line for each

    if (.not. (options%accuracy >= 0.0_real64 .and. options%accuracy < 1.0_real64)) &
      call problems%add('accuracy: found ' // real_text(options%accuracy) // ', expected a ' // &
                        'relative error of more than 0 and less than 1, or 0 for none')
    if (options%threads < 0 .or. options%threads > most_threads) &
      call problems%add('threads: found ' // decimal_text(options%threads) // ', expected a ' // &
                        'number from 1 to ' // decimal_text(most_threads) // ', or 0 for all cores')
    if (options%fields < fields_none .or. options%fields > fields_all) &
      call problems%add('fields: found ' // decimal_text(options%fields) // ', expected 0 for ' // &
                        'none, 1 for those of the last state or 2 for those of all states')
  end subroutine check_options

end module asperity_run_options
