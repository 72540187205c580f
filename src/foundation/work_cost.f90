!> Estimate of run time and memory of work: some of its pieces are run, and the others are assumed
!> to cost as much.
module asperity_work_cost
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text, real_text
  use asperity_process, only: number_in_file
  use asperity_progress, only: duration_text
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: pieces_tried, tell_cost, work_cost

  integer, parameter :: pieces_tried = 3  !! number of pieces that are tried, evenly spread

  !> Work of which a few pieces are tried.
  type :: work_cost
    character(len=:), allocatable :: pieces  !! name of the pieces, for instance `positions`
    integer :: total = 1                     !! number of all pieces
    integer :: tried = 1                     !! number of tried pieces
    real(real64) :: bytes_each = 0.0_real64  !! memory that a piece keeps until the end
    real(real64) :: most_seconds = huge(1.0_real64)  !! limit of time, s; huge: none
    !> processor time of this process at the start of the first tried piece, s: earlier work is done
    !> once
    real(real64) :: begun = 0.0_real64
    !> processor time at the end of the last one, s: later work is done once; < 0: the time of the
    !> estimate
    real(real64) :: ended = -1.0_real64
  end type work_cost

contains

  !> Appends three lines with the estimate: pieces, time and memory.
  subroutine tell_cost(cost, text)
    type(work_cost), intent(in) :: cost       !! work with its tried pieces
    type(text_buffer), intent(inout) :: text  !! text that is extended
    integer(int64) :: kilobytes
    real(real64) :: bytes, now, seconds

    call cpu_time(now)
    seconds = max(0.0_real64, merge(now, cost%ended, cost%ended < 0.0_real64) - cost%begun)
    call text%line('work: ' // decimal_text(cost%total) // ' ' // &
                   cost%pieces(:len(cost%pieces) - merge(1, 0, cost%total == 1)) // ', tried ' // &
                   decimal_text(cost%tried) // ' in ' // real_text(seconds, 'f20.3') // ' s')
    if (cost%most_seconds < huge(seconds)) then
      call text%line('time: at most ' // duration_text(cost%most_seconds) // &
                     ' and the rest of the piece in progress')
    else
      call text%line('time: about ' // &
                     duration_text(now - seconds + seconds / cost%tried * cost%total) // &
                     ' of one core')
    end if
    ! Linux reports the most memory that the process has held; getrusage counts its caller's, too.
    kilobytes = number_in_file('/proc/self/status', 'VmHWM:')
    if (kilobytes == huge(kilobytes)) kilobytes = 0_int64
    bytes = 1024.0_real64 * real(kilobytes, real64) + &
            cost%bytes_each * real(cost%total - cost%tried, real64)
    call text%line('memory: about ' // decimal_text(ceiling(min(1.0e-6_real64 * bytes, &
                   1.0e9_real64))) // ' MB')
  end subroutine tell_cost

end module asperity_work_cost
