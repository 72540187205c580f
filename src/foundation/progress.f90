!> How far long work has come, as one line on standard error.
!>
!> Nothing is shown unless the caller wants it and standard error is a terminal. How much work there
!> is is shown at once, as its first piece may take long; how fast it goes after two seconds. A line
!> belongs to one piece of work; the threads of that work call it one at a time.
module asperity_progress
  use, intrinsic :: iso_c_binding, only: c_int
  use asperity_files, only: standard_error, write_standard_error
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text
  use asperity_system_calls, only: posix_isatty
  implicit none
  private

  public :: duration, progress_line, progress_text

  ! Seconds before the first line, and from line to line.
  real(real64), parameter :: patience = 2.0_real64, pause = 0.25_real64

  !> The line of some work under way.
  type :: progress_line
    private
    logical :: wanted = .false.
    character(len=:), allocatable :: pieces
    integer :: total = 0, done = 0, done_before = 0
    integer :: width = 0  ! of the line that is shown; 0: none
    integer(int64) :: began = 0_int64
    real(real64) :: shown = 0.0_real64
  contains
    procedure :: begin => progress_begin    !! work begins
    procedure :: step => progress_step      !! one more piece is done
    procedure :: reach => progress_reach    !! so many pieces are done
    procedure :: finish => progress_finish  !! the line goes
  end type progress_line

contains

  !> Work begins.
  subroutine progress_begin(self, wanted, what, number, before)
    class(progress_line), intent(out) :: self  !! nothing is shown yet
    logical, intent(in) :: wanted              !! show it, if standard error is a terminal
    character(len=*), intent(in) :: what       !! its pieces, for instance `positions`
    integer, intent(in) :: number              !! of them
    integer, intent(in) :: before              !! so many were done before

    if (wanted) self%wanted = posix_isatty(int(standard_error, c_int)) == 1_c_int
    self%pieces = what
    self%total = number
    self%done = before
    self%done_before = before
    self%shown = patience - pause
    if (.not. self%wanted) return
    call system_clock(self%began)
    call show(self, decimal_text(before) // ' of ' // decimal_text(number) // ' ' // what)
  end subroutine progress_begin

  !> One more piece is done.
  subroutine progress_step(self)
    class(progress_line), intent(inout) :: self  !! begun

    call self%reach(self%done + 1)
  end subroutine progress_step

  !> So many pieces are done by now. Shows the line when it is time to.
  subroutine progress_reach(self, by_now)
    class(progress_line), intent(inout) :: self  !! begun
    integer, intent(in) :: by_now                !! those done before included
    character(len=:), allocatable :: line
    real(real64) :: seconds

    self%done = by_now
    if (.not. self%wanted) return
    seconds = seconds_since(self%began)
    if (seconds < self%shown + pause .or. self%done >= self%total .or. &
        self%done <= self%done_before) return
    self%shown = seconds
    line = progress_text(self%pieces, self%done, self%total, self%done_before, seconds)
    call show(self, line)
  end subroutine progress_reach

  ! Shows a line in place of the one before.
  subroutine show(self, line)
    class(progress_line), intent(inout) :: self
    character(len=*), intent(in) :: line

    call write_standard_error(line // repeat(' ', max(0, self%width - len(line))) // achar(13))
    self%width = len(line)
  end subroutine show

  !> Work is at its end: the line goes.
  subroutine progress_finish(self)
    class(progress_line), intent(inout) :: self  !! begun

    if (self%width > 0) call write_standard_error(repeat(' ', self%width) // achar(13))
    self%width = 0
  end subroutine progress_finish

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

  !> A time in words, rounded up.
  pure function duration(seconds) result(text)
    real(real64), intent(in) :: seconds  !! 0 or more
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
