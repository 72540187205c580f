!> The positions of a scene shared out to threads, with the same result for any number of them.
!>
!> Positions know nothing of each other. What a run tells of a failure is what a run with one thread
!> tells: the first position in order that fails, or with which there are too many contacts.
!> Positions behind it are left out. Without OpenMP there is one thread.
module asperity_position_loop
  use asperity_contact_records, only: most_rows, position_result
  use asperity_kinds, only: int64
  use asperity_problems, only: decimal_text
  use asperity_progress, only: begin_progress, end_progress, step_progress
  !$ use omp_lib, only: omp_get_max_threads
  implicit none
  private

  public :: position_watch
  public :: begin_positions, end_positions, is_wanted, position_done, threads_for, use_threads

  ! Less work than this is done before threads have begun: positions times asperities.
  integer(int64), parameter :: least_work = 30000_int64

  ! Threads asked for; 0: as many as OpenMP gives.
  integer :: threads_wanted = 0

  !> What the threads know of each other's positions.
  type :: position_watch
    private
    integer :: last = huge(1)                     ! no position behind it is wanted
    integer :: highest = 0                        ! of those solved
    integer :: failed = huge(1)                   ! first one that failed
    integer(int64) :: rows = 0_int64              ! contacts kept so far
    character(len=:), allocatable :: failure      ! why
  end type position_watch

contains

  !> Sets the number of threads for all scenes from now on.
  subroutine use_threads(threads)
    integer, intent(in) :: threads  !! 1 or more; 0: as many as OpenMP gives, fewer for little work

    threads_wanted = threads
  end subroutine use_threads

  !> Threads for the positions of a scene, at least one.
  integer function threads_for(positions, work) result(threads)
    integer, intent(in) :: positions      !! of the scene
    integer(int64), intent(in) :: work    !! asperities that each position looks at, at most

    threads = 1
    if (threads_wanted > 0) then
      threads = threads_wanted
    else
      !$ if (work >= least_work / positions) threads = omp_get_max_threads()
    end if
    threads = max(1, min(threads, positions))
  end function threads_for

  !> To be called before the threads begin.
  subroutine begin_positions(watch, positions)
    type(position_watch), intent(out) :: watch  !! nothing is solved yet
    integer, intent(in) :: positions            !! of the scene

    watch%last = positions
    call begin_progress(positions)
  end subroutine begin_positions

  !> Whether a position need be solved.
  logical function is_wanted(watch, m)
    type(position_watch), intent(in) :: watch  !! shared by all threads
    integer, intent(in) :: m                   !! position, from 1
    integer :: last

    !$omp atomic read
    last = watch%last
    is_wanted = m <= last
  end function is_wanted

  !> To be called by a thread with each position that it has solved, or could not solve.
  subroutine position_done(watch, m, rows, failure)
    type(position_watch), intent(inout) :: watch               !! shared by all threads
    integer, intent(in) :: m                                   !! position, from 1
    integer, intent(in) :: rows                                !! contacts that it keeps
    character(len=:), allocatable, intent(in) :: failure       !! why it could not be solved
    integer :: last

    !$omp critical (asperity_positions)
    last = watch%last
    watch%highest = max(watch%highest, m)
    watch%rows = watch%rows + int(rows, int64)
    if (allocated(failure) .and. m < watch%failed) then
      watch%failed = m
      watch%failure = failure
      last = min(last, m)
    end if
    ! One up to the highest is too much. All before it are still solved.
    if (watch%rows > int(most_rows, int64)) last = min(last, watch%highest)
    !$omp atomic write
    watch%last = last
    call step_progress()
    !$omp end critical (asperity_positions)
  end subroutine position_done

  !> To be called when the threads have ended. `failure` tells of the first position at which there
  !> was one.
  subroutine end_positions(watch, positions, failure)
    type(position_watch), intent(in) :: watch                !! of all threads
    type(position_result), intent(in) :: positions(:)        !! in order
    character(len=:), allocatable, intent(out) :: failure    !! why not all are solved
    integer(int64) :: rows
    integer :: m

    call end_progress()
    rows = 0_int64
    do m = 1, watch%last
      rows = rows + int(positions(m)%rows_used, int64)
      if (m == watch%failed) failure = watch%failure
      if (rows > int(most_rows, int64)) &
        failure = 'more than ' // decimal_text(most_rows) // ' contacts to keep: expected ' // &
                  'fewer positions or points, or no list of contacts'
      if (.not. allocated(failure)) cycle
      failure = 'position ' // decimal_text(m) // ': ' // failure
      return
    end do
  end subroutine end_positions

end module asperity_position_loop
