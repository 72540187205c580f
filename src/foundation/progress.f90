!> How far long work has come, as one line on standard error.
!>
!> Nothing is shown unless the program has asked for it (`allow_progress`), standard error is a
!> terminal and the work takes over two seconds. Whoever computes only counts what is done; work
!> within work counts nothing. Threads take turns in calling this (`asperity_position_loop`).
module asperity_progress
  use, intrinsic :: iso_c_binding, only: c_int
  use asperity_files, only: standard_error, write_standard_error
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text
  use asperity_system_calls, only: posix_isatty
  implicit none
  private

  public :: allow_progress, begin_progress, end_progress, progress_text, show_progress
  public :: step_progress

  ! Seconds before the first line, and from line to line.
  real(real64), parameter :: patience = 2.0_real64, pause = 0.25_real64

  ! What is under way.
  logical :: allowed = .false.
  integer :: depth = 0  ! of work within work
  character(len=:), allocatable :: pieces
  integer :: total = 0, done = 0, done_before = 0
  integer :: width = 0  ! of the line that is shown; 0: none
  integer(int64) :: began = 0_int64
  real(real64) :: shown = 0.0_real64

contains

  !> From now on long work is shown, if standard error is a terminal.
  subroutine allow_progress()
    allowed = posix_isatty(int(standard_error, c_int)) == 1_c_int
  end subroutine allow_progress

  !> Work begins.
  subroutine begin_progress(what, number, before)
    character(len=*), intent(in) :: what  !! its pieces, for instance `positions`
    integer, intent(in) :: number         !! of them
    integer, intent(in) :: before         !! so many were done before

    depth = depth + 1
    if (depth > 1) return
    pieces = what
    total = number
    done = before
    done_before = before
    width = 0
    shown = patience - pause
    if (allowed) call system_clock(began)
  end subroutine begin_progress

  !> One more piece is done.
  subroutine step_progress()
    if (depth == 1) call tell(done + 1)
  end subroutine step_progress

  !> So many pieces are done by now.
  subroutine show_progress(by_now)
    integer, intent(in) :: by_now  !! those done before included

    if (depth == 1) call tell(by_now)
  end subroutine show_progress

  !> Work is at its end: the line goes.
  subroutine end_progress()
    depth = depth - 1
    if (depth > 0) return
    if (width > 0) call write_standard_error(repeat(' ', width) // achar(13))
    width = 0
  end subroutine end_progress

  ! Counts, and shows the line when it is time to.
  subroutine tell(by_now)
    integer, intent(in) :: by_now
    character(len=:), allocatable :: line
    real(real64) :: seconds

    done = by_now
    if (.not. allowed) return
    seconds = seconds_since(began)
    if (seconds < shown + pause .or. done >= total .or. done <= done_before) return
    shown = seconds
    line = progress_text(pieces, done, total, done_before, seconds)
    call write_standard_error(line // repeat(' ', max(0, width - len(line))) // achar(13))
    width = len(line)
  end subroutine tell

  !> The line: how much is done, how fast, how long it will go on.
  pure function progress_text(what, finished, number, before, seconds) result(text)
    character(len=*), intent(in) :: what    !! the pieces of the work
    integer, intent(in) :: finished         !! of them, more than `before`
    integer, intent(in) :: number           !! all of them
    integer, intent(in) :: before           !! done before the beginning
    real(real64), intent(in) :: seconds     !! since the beginning, more than 0
    character(len=:), allocatable :: text
    real(real64) :: rate

    rate = real(finished - before, real64) / seconds
    text = decimal_text(finished) // ' of ' // decimal_text(number) // ' ' // what // ', '
    if (rate >= 10.0_real64) then
      text = text // decimal_text(nint(min(rate, 1.0e9_real64))) // ' a second, '
    else
      text = text // decimal_text(nint(60.0_real64 * rate)) // ' a minute, '
    end if
    text = text // duration(real(number - finished, real64) / rate) // ' left'
  end function progress_text

  ! A time in words, rounded up.
  pure function duration(seconds) result(text)
    real(real64), intent(in) :: seconds
    character(len=:), allocatable :: text
    integer :: whole

    whole = ceiling(min(seconds, 1.0e9_real64))
    if (whole < 100) then
      text = decimal_text(whole) // ' s'
    else if (whole < 6000) then
      text = decimal_text((whole + 59) / 60) // ' min'
    else
      text = decimal_text((whole + 3599) / 3600) // ' h'
    end if
  end function duration

  ! Seconds since a reading of the clock.
  real(real64) function seconds_since(reading) result(seconds)
    integer(int64), intent(in) :: reading
    integer(int64) :: now, rate

    call system_clock(now, rate)
    seconds = real(now - reading, real64) / real(rate, real64)
  end function seconds_since

end module asperity_progress
