!> Whether work shall end: another thread wants it, by a number in its memory, which it makes other
!> than 0; or its time is over.
module asperity_interruption
  use, intrinsic :: iso_c_binding, only: c_int
  use asperity_kinds, only: int64, real64
  implicit none
  private

  public :: interruption

  !> Address of the number that ends the work. Null by default: no interruption is possible.
  type :: interruption
    integer(c_int), pointer :: number => null()  !! 0 as long as the work may go on
    integer(int64) :: last_tick = huge(0_int64)  !! of the clock; huge: there is time
  contains
    procedure :: is_asked    !! an end is wanted
    procedure :: end_within  !! its time is over after so many seconds
  end type interruption

contains

  !> Whether an end is wanted.
  logical function is_asked(self)
    class(interruption), intent(in) :: self  !! of the work
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

  !> Work ends after so many seconds from now, at the next place where it looks.
  subroutine end_within(self, seconds)
    class(interruption), intent(inout) :: self  !! of the work
    real(real64), intent(in) :: seconds         !! from now on; at most 1e9 count
    integer(int64) :: rate

    call system_clock(self%last_tick, rate)
    self%last_tick = self%last_tick + int(min(seconds, 1.0e9_real64) * real(rate, real64), int64)
  end subroutine end_within

end module asperity_interruption
