!> The positions of a scene shared out to threads, with the same result for any number of them.
!>
!> Threads share a round of positions; a sweep is one round unless it is shared out over images or
!> kept (`asperity_position_rounds`). Positions know nothing of each other. What a run tells of a
!> failure is what a run with one thread tells: the first position in order that fails, or with
!> which there are too many contacts. Positions behind it are left out. Without OpenMP there is one
!> thread.
module asperity_position_loop
  use asperity_contact_records, only: most_rows, position_result
  use asperity_images, only: image_number
  use asperity_kinds, only: int64, real64
  use asperity_position_rounds, only: add_to_round, begin_rounds, is_own, next_round, &
                                      position_rounds
  use asperity_problems, only: decimal_text
  use asperity_progress, only: begin_progress, end_progress, show_progress, step_progress
  !$ use omp_lib, only: omp_get_max_threads
  implicit none
  private

  public :: position_watch
  public :: added_numbers, another_round, are_packed, begin_positions, end_positions, first_of_round
  public :: is_wanted, last_of_round, position_done, threads_for, use_threads

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
    type(position_rounds) :: sweep                ! over all images
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
    call begin_rounds(watch%sweep, positions)
  end subroutine begin_positions

  !> Whether there is another round of positions to solve; to be asked before each, by one thread.
  logical function another_round(watch, positions)
    type(position_watch), intent(inout) :: watch           !! shared by all threads
    type(position_result), intent(inout) :: positions(:)   !! of the sweep, in order
    logical :: first

    first = watch%sweep%rounds%last == 0
    call next_round(watch%sweep, positions, watch%failed, watch%failure, another_round)
    if (first) then
      call begin_progress('positions', watch%sweep%rounds%total, watch%sweep%rounds%done)
    else
      call show_progress(watch%sweep%rounds%done)
    end if
  end function another_round

  !> First position of the round.
  pure integer function first_of_round(watch)
    type(position_watch), intent(in) :: watch  !! shared by all threads

    first_of_round = watch%sweep%rounds%first
  end function first_of_round

  !> Last position of the round.
  pure integer function last_of_round(watch)
    type(position_watch), intent(in) :: watch  !! shared by all threads

    last_of_round = watch%sweep%rounds%last
  end function last_of_round

  !> Whether a position of the round need be solved, and here.
  logical function is_wanted(watch, m)
    type(position_watch), intent(in) :: watch  !! shared by all threads
    integer, intent(in) :: m                   !! position, from 1
    integer :: last

    !$omp atomic read
    last = watch%last
    is_wanted = m <= last .and. is_own(watch%sweep, m)
  end function is_wanted

  !> Whether results are packed as numbers.
  pure logical function are_packed(watch)
    type(position_watch), intent(in) :: watch  !! shared by all threads

    are_packed = watch%sweep%shared
  end function are_packed

  !> The numbers that went with a position solved elsewhere; none: it was solved here.
  pure function added_numbers(watch, m) result(numbers)
    type(position_watch), intent(in) :: watch  !! when all is solved
    integer, intent(in) :: m                   !! position
    real(real64), allocatable :: numbers(:)

    allocate (numbers(0))
    if (.not. allocated(watch%sweep%more)) return
    if (allocated(watch%sweep%more(m)%numbers)) numbers = watch%sweep%more(m)%numbers
  end function added_numbers

  !> To be called by a thread with each position that it has solved, or could not solve.
  subroutine position_done(watch, m, result, failure, more)
    type(position_watch), intent(inout) :: watch               !! shared by all threads
    integer, intent(in) :: m                                   !! position, from 1
    type(position_result), intent(in) :: result                !! of it
    character(len=:), allocatable, intent(in) :: failure       !! why it could not be solved
    real(real64), intent(in), optional :: more(:)              !! to go with it, when packed
    integer :: last

    !$omp critical (asperity_positions)
    last = watch%last
    watch%highest = max(watch%highest, m)
    watch%rows = watch%rows + int(result%rows_used, int64)
    if (allocated(failure) .and. m < watch%failed) then
      watch%failed = m
      watch%failure = failure
      last = min(last, m)
    end if
    ! One up to the highest is too much. All before it are still solved.
    if (watch%rows > int(most_rows, int64)) last = min(last, watch%highest)
    !$omp atomic write
    watch%last = last
    if (watch%sweep%shared .and. .not. allocated(failure)) then
      if (present(more)) then
        call add_to_round(watch%sweep, m, result, more)
      else
        call add_to_round(watch%sweep, m, result, [real(real64) ::])
      end if
    end if
    call step_progress()
    !$omp end critical (asperity_positions)
  end subroutine position_done

  !> To be called after the last round. `failure` tells of the first position at which there was
  !> one, or why the images cannot go on together.
  subroutine end_positions(watch, positions, failure)
    type(position_watch), intent(in) :: watch                !! of all threads
    type(position_result), intent(in) :: positions(:)        !! in order
    character(len=:), allocatable, intent(out) :: failure    !! why not all are solved
    integer(int64) :: rows
    integer :: m

    call end_progress()
    if (allocated(watch%sweep%failure)) failure = watch%sweep%failure
    if (allocated(failure) .or. image_number() > 1) return
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
