!> End of work by another thread, which sets a number in its memory to a value other than 0, or by a
!> limit of time.
module asperity_interruption
  use, intrinsic :: iso_c_binding, only: c_int
  use asperity_kinds, only: int64, real64
  implicit none
  private

  public :: interruption

  !> Address of the number that ends the work. Null by default: no interruption is possible.
  type :: interruption
    integer(c_int), pointer :: number => null()  !! 0 while the work continues
    integer(int64) :: last_tick = huge(0_int64)  !! limit of the clock; huge: none
  contains
    procedure :: is_asked      !! whether the work is to end
    procedure :: end_within    !! sets the limit of time
    procedure :: seconds_left  !! time until the limit
  end type interruption

contains

  !> Whether the work is to end.
  logical function is_asked(self)
    class(interruption), intent(in) :: self  !! interruption of the work
    integer(c_int) :: number
    integer(int64) :: now

    number = 0_c_int
    if (associated(self%number)) then
      !$omp atomic read
      number = self%number
    end if
    is_asked = number /= 0_c_int
    if (self%last_tick == huge(0_int64)) return
    call system_clock(now)
    is_asked = is_asked .or. now > self%last_tick
  end function is_asked

  !> Sets the limit of time, from the current time on.
  subroutine end_within(self, seconds)
    class(interruption), intent(inout) :: self  !! interruption of the work
    real(real64), intent(in) :: seconds         !! time, s; limited to 1e9
    integer(int64) :: rate

    call system_clock(self%last_tick, rate)
    self%last_tick = self%last_tick + int(min(seconds, 1.0e9_real64) * real(rate, real64), int64)
  end subroutine end_within

  !> Seconds until the limit of time; less than 0 behind it.
  real(real64) function seconds_left(self) result(seconds)
    class(interruption), intent(in) :: self  !! interruption with a limit of time
    integer(int64) :: now, rate

    call system_clock(now, rate)
    seconds = real(self%last_tick - now, real64) / real(rate, real64)
  end function seconds_left

end module asperity_interruption
