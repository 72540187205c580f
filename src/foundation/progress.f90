!> Progress of long work, as one line on standard error.
!>
!> The line is shown only if requested and if standard error is a terminal. The amount of work is
!> shown at the start, as the first piece may take long; the rate after two seconds. A line belongs
!> to one work, whose threads call it one at a time.
module asperity_progress
  use, intrinsic :: iso_c_binding, only: c_int
  use asperity_files, only: standard_error, write_standard_error
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text
  use asperity_system_calls, only: posix_isatty
  implicit none
  private

  public :: duration_text, progress_line, progress_text

  ! Time before the first line with a rate, and between two lines [s].
  real(real64), parameter :: patience = 2.0_real64, pause = 0.25_real64

  !> The line of one work.
  type :: progress_line
    private
    logical :: requested = .false.
    character(len=:), allocatable :: pieces
    integer :: total = 0, done = 0, done_before = 0
    integer :: width = 0  ! width of the line on the terminal; 0: none
    integer(int64) :: began = 0_int64
    real(real64) :: shown = 0.0_real64
  contains
    procedure :: begin => progress_begin    !! starts the line
    procedure :: step => progress_step      !! counts one piece
    procedure :: reach => progress_reach    !! sets the number of pieces done
    procedure :: finish => progress_finish  !! erases the line
  end type progress_line

contains

  !> Starts the line of some work.
  subroutine progress_begin(self, requested, what, number, before)
    class(progress_line), intent(out) :: self  !! line of the work
    logical, intent(in) :: requested           !! whether it is shown on a terminal
    character(len=*), intent(in) :: what       !! name of the pieces, for instance `positions`
    integer, intent(in) :: number              !! number of all pieces
    integer, intent(in) :: before              !! number of pieces done before

    if (requested) self%requested = posix_isatty(int(standard_error, c_int)) == 1_c_int
    self%pieces = what
    self%total = number
    self%done = before
    self%done_before = before
    self%shown = patience - pause
    if (.not. self%requested) return
    call system_clock(self%began)
    call show_line(self, decimal_text(before) // ' of ' // decimal_text(number) // ' ' // what)
  end subroutine progress_begin

  !> Counts one piece.
  subroutine progress_step(self)
    class(progress_line), intent(inout) :: self  !! line of the work

    call self%reach(self%done + 1)
  end subroutine progress_step

  !> Sets the number of pieces done, and shows the line when the pause is over.
  subroutine progress_reach(self, by_now)
    class(progress_line), intent(inout) :: self  !! line of the work
    integer, intent(in) :: by_now                !! pieces done, including earlier ones
    character(len=:), allocatable :: line
    integer(int64) :: now, rate
    real(real64) :: seconds

    self%done = by_now
    if (.not. self%requested) return
    call system_clock(now, rate)
    seconds = real(now - self%began, real64) / real(rate, real64)
    if (seconds < self%shown + pause .or. self%done >= self%total .or. &
        self%done <= self%done_before) return
    self%shown = seconds
    line = progress_text(self%pieces, self%done, self%total, self%done_before, seconds)
    call show_line(self, line)
  end subroutine progress_reach

  ! Shows a line in place of the last one.
  subroutine show_line(self, line)
    class(progress_line), intent(inout) :: self
    character(len=*), intent(in) :: line

    call write_standard_error(line // repeat(' ', max(0, self%width - len(line))) // achar(13))
    self%width = len(line)
  end subroutine show_line

  !> Erases the line at the end of the work.
  subroutine progress_finish(self)
    class(progress_line), intent(inout) :: self  !! line of the work

    if (self%width > 0) call write_standard_error(repeat(' ', self%width) // achar(13))
    self%width = 0
  end subroutine progress_finish

  !> Text of the line: pieces done, rate and remaining time.
  pure function progress_text(what, finished, number, before, seconds) result(text)
    character(len=*), intent(in) :: what    !! name of the pieces
    integer, intent(in) :: finished         !! number done, more than `before`
    integer, intent(in) :: number           !! number of all pieces
    integer, intent(in) :: before           !! number done before the start
    real(real64), intent(in) :: seconds     !! time since the start, s, > 0
    character(len=:), allocatable :: text
    real(real64) :: rate

    rate = real(finished - before, real64) / seconds
    text = decimal_text(finished) // ' of ' // decimal_text(number) // ' ' // what // ', '
    if (rate >= 10.0_real64) then
      text = text // decimal_text(nint(min(rate, 1.0e9_real64))) // ' a second, '
    else
      text = text // decimal_text(nint(60.0_real64 * rate)) // ' a minute, '
    end if
    text = text // duration_text(real(number - finished, real64) / rate) // ' left'
  end function progress_text

  !> Text of a time, rounded up.
  pure function duration_text(seconds) result(text)
    real(real64), intent(in) :: seconds  !! time, s, 0 or more
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
  end function duration_text

end module asperity_progress
