!> Options of a run that are not part of the scene.
module asperity_run_options
  use asperity_contact_field, only: fields_all, fields_none
  use asperity_interruption, only: interruption
  use asperity_kept_records, only: kept_file
  use asperity_kinds, only: real64
  use asperity_problems, only: decimal_text, problem_list, real_text
  use asperity_work_count, only: work_count
  implicit none
  private

  public :: check_options, run_options, totals_of_accuracy

  !> Results whose error an accuracy limits: load, or separation and compression under a load; area;
  !> greatest pressure, of maps; load and area.
  character(len=8), parameter :: totals_of_accuracy(4) = [character(len=8) :: &
    'load', 'area', 'pressure', 'all']

  integer, parameter :: most_threads = 9999  ! largest accepted number of threads

  !> The options. Defaults: exact events, contacts kept, all cores, no progress.
  type :: run_options
    !> Allowed relative error: the fastest method within it is used; 0: no limit.
    real(real64) :: accuracy = 0.0_real64
    character(len=8) :: accuracy_of = 'load'       !! of which totals, one of `totals_of_accuracy`
    !> Error of the load above which the results of a map on its pixels are not used; 0: all are.
    real(real64) :: largest_error = 0.0_real64
    logical :: keep_contacts = .true.              !! keep the contacts of every state
    integer :: threads = 0                         !! number of threads; 0: default of OpenMP
    logical :: progress = .false.                  !! print the progress on a terminal
    logical :: all_images = .false.                !! all images call and share the work
    character(len=:), allocatable :: keep_file     !! file in which solved positions are kept
    integer :: part = 1                            !! part of the positions to be solved, from 1
    integer :: parts = 1                           !! number of parts
    !> Files of further parts, which are combined; not allocated: the run combines none.
    type(kept_file), allocatable :: more_files(:)
    !> States of a height map solved on its pixels that keep pressure, gap and displacement:
    !> `fields_none`, `fields_last`, `fields_all`. Other scenes, and positions from a file of kept
    !> positions, have none.
    integer :: fields = fields_none
    type(interruption) :: interrupt = interruption()  !! ends the run from another thread
    type(work_count) :: counted_work = work_count()   !! progress of the run for another thread
  end type run_options

contains

  !> Reports numeric options that are out of range.
  subroutine check_options(options, problems)
    type(run_options), intent(in) :: options       !! options, not yet checked
    type(problem_list), intent(inout) :: problems  !! list; gets a line for each fault

    if (.not. (options%accuracy >= 0.0_real64 .and. options%accuracy < 1.0_real64)) &
      call problems%add('accuracy: found ' // real_text(options%accuracy) // ', expected a ' // &
                        'relative error of more than 0 and less than 1, or 0 for none')
    if (all(options%accuracy_of /= totals_of_accuracy)) &
      call problems%add('accuracy_of: found ' // trim(options%accuracy_of) // &
                        ', expected load, area, pressure or all')
    if (options%threads < 0 .or. options%threads > most_threads) &
      call problems%add('threads: found ' // decimal_text(options%threads) // ', expected a ' // &
                        'number from 1 to ' // decimal_text(most_threads) // ', or 0 for all cores')
    if (options%fields < fields_none .or. options%fields > fields_all) &
      call problems%add('fields: found ' // decimal_text(options%fields) // ', expected 0 for ' // &
                        'none, 1 for those of the last state or 2 for those of all states')
  end subroutine check_options

end module asperity_run_options
