!> A line on standard error that tells how far a study is, when that is a terminal.
!>
!> Not `asperity_progress`: that one counts the positions of a scene, and every surface is one.
module asperity_area_study_progress
  use, intrinsic :: iso_c_binding, only: c_int
  use asperity_files, only: standard_error, write_standard_error
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text
  use asperity_system_calls, only: posix_isatty
  implicit none
  private

  public :: progress_line

  ! Work of less than this many seconds tells nothing; then a line comes so often.
  real(real64), parameter :: patience = 2.0_real64, interval = 0.2_real64
  character(len=*), parameter :: to_start = achar(13), clear_line = achar(27) // '[K'

  !> The progress of one piece of work.
  type :: progress_line
    private
    logical :: on = .false., shown = .false.
    integer :: first = 0, total = 0
    integer(int64) :: start = 0_int64, last = 0_int64
    character(len=:), allocatable :: what
  contains
    !> Begins to count.
    procedure :: begin
    !> Tells how much is done, when it is time to.
    procedure :: tell
    !> Takes the line away.
    procedure :: finish
  end type progress_line

contains

  !> Begins to count. Nothing is ever shown when standard error is no terminal.
  subroutine begin(self, what, done, total)
    class(progress_line), intent(out) :: self  !! the line
    character(len=*), intent(in) :: what       !! what is counted, as `surfaces`
    integer, intent(in) :: done                !! what was done before
    integer, intent(in) :: total               !! what there is to do, with that

    self%on = posix_isatty(int(standard_error, c_int)) == 1_c_int
    self%what = what
    self%first = done
    self%total = total
    call system_clock(self%start)
    self%last = self%start
  end subroutine begin

  !> Shows how much is done, how fast it goes and what time is left.
  subroutine tell(self, done)
    class(progress_line), intent(inout) :: self  !! the line
    integer, intent(in) :: done                  !! so much
    integer(int64) :: now, rate
    real(real64) :: seconds
    character(len=24) :: speed

    if (.not. self%on .or. done <= self%first) return
    call system_clock(now, rate)
    seconds = real(now - self%start, real64) / real(rate, real64)
    if (seconds < patience) return
    if (self%shown .and. real(now - self%last, real64) < interval * real(rate, real64)) return
    self%last = now
    self%shown = .true.
    ! No exponent, whatever the rate.
    write (speed, '(f24.2)') (done - self%first) / seconds
    speed = adjustl(speed)
    call write_standard_error(to_start // decimal_text(done) // ' of ' // &
                              decimal_text(self%total) // ' ' // self%what // ', ' // &
                              trim(speed) // ' a second, ' // &
                              time_text(seconds * (self%total - done) / (done - self%first)) // &
                              ' left' // clear_line)
  end subroutine tell

  !> Takes the line away, so that what follows stands alone.
  subroutine finish(self)
    class(progress_line), intent(inout) :: self  !! the line

    if (self%shown) call write_standard_error(to_start // clear_line)
    self%on = .false.
    self%shown = .false.
  end subroutine finish

  !> Hours, minutes and seconds.
  pure function time_text(seconds) result(text)
    real(real64), intent(in) :: seconds
    character(len=:), allocatable :: text
    character(len=20) :: digits
    integer(int64) :: whole

    whole = nint(min(seconds, 1.0e12_real64), int64)
    write (digits, '(i0, ":", i2.2, ":", i2.2)') whole / 3600, modulo(whole / 60, 60_int64), &
      modulo(whole, 60_int64)
    text = trim(digits)
  end function time_text

end module asperity_area_study_progress
