!> What work will cost, told beforehand: some of its pieces are tried, the others are taken to be
!> like them.
module asperity_work_cost
  use asperity_files, only: read_whole_file
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text, real_text
  use asperity_progress, only: duration
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: pieces_tried, tell_cost, work_cost

  !> So many pieces are tried, spread over all of them.
  integer, parameter :: pieces_tried = 3

  !> Work of which a few pieces are tried.
  type :: work_cost
    character(len=:), allocatable :: pieces  !! what they are, many: for instance `positions`
    integer :: total = 1                     !! of them
    integer :: tried = 1                     !! of them
    real(real64) :: bytes_each = 0.0_real64  !! of memory that a piece keeps until the end
    real(real64) :: most_seconds = huge(1.0_real64)  !! that may be spent; huge: any
    !> Processor time of this process when the first piece that is tried begins, s: what comes
    !> before is done once.
    real(real64) :: begun = 0.0_real64
    !> The same when the last of them is done, and what follows is done once; negative: when it is
    !> told.
    real(real64) :: ended = -1.0_real64
  end type work_cost

contains

  !> What was tried: three lines, pieces, time and memory.
  subroutine tell_cost(cost, text)
    type(work_cost), intent(in) :: cost       !! what was tried
    type(text_buffer), intent(inout) :: text  !! gets the lines
    real(real64) :: bytes, now, seconds

    call cpu_time(now)
    seconds = max(0.0_real64, merge(now, cost%ended, cost%ended < 0.0_real64) - cost%begun)
    call text%line('work: ' // decimal_text(cost%total) // ' ' // &
                   cost%pieces(:len(cost%pieces) - merge(1, 0, cost%total == 1)) // ', tried ' // &
                   decimal_text(cost%tried) // ' in ' // real_text(seconds, 'f20.3') // ' s')
    if (cost%most_seconds < huge(seconds)) then
      call text%line('time: at most ' // duration(cost%most_seconds) // &
                     ' and the end of what is under way then')
    else
      call text%line('time: about ' // duration(now - seconds + seconds / cost%tried * cost%total) &
                     // ' of one core')
    end if
    bytes = 1024.0_real64 * kilobytes_so_far() + &
            cost%bytes_each * real(cost%total - cost%tried, real64)
    call text%line('memory: about ' // decimal_text(ceiling(min(1.0e-6_real64 * bytes, &
                   1.0e9_real64))) // ' MB')
  end subroutine tell_cost

  ! The most memory that the process has held, as Linux tells it; 0 where nobody tells. Not by
  ! getrusage, which counts what the caller held before it became this process.
  real(real64) function kilobytes_so_far() result(kilobytes)
    character(len=*), parameter :: name = 'VmHWM:'
    character(len=:), allocatable :: text, failure
    integer :: at, status
    integer(int64) :: number

    kilobytes = 0.0_real64
    call read_whole_file('/proc/self/status', text, failure)
    if (allocated(failure)) return
    at = index(text, name)
    if (at == 0) return
    at = at + len(name)
    read (text(at:at + index(text(at:), 'kB') - 2), *, iostat=status) number
    if (status == 0) kilobytes = real(number, real64)
  end function kilobytes_so_far

end module asperity_work_cost
