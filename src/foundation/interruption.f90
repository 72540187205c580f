!> End of work by another thread, which sets a number in its memory to a value other than 0, or by a
!> limit of time.
!>
!> Progress in two numbers in the memory of a calling program: pieces of work done, and all pieces.
!> Any thread may read them at any time.
module asperity_interruption
  use, intrinsic :: iso_c_binding, only: c_int
  use asperity_kinds, only: int64, real64
  implicit none
  private

  public :: interruption, work_count

  !> Address of the number that ends the work. Null by default: no interruption is possible.
  type :: interruption
    integer(c_int), pointer :: number => null()  !! 0 while the work continues
    integer(int64) :: last_tick = huge(0_int64)  !! limit of the clock; huge: none
  contains
    procedure :: is_asked    !! whether the work is to end
    procedure :: end_within  !! sets the limit of time
  end type interruption

  !> Reference to the numbers. By default nothing is counted.
  type :: work_count
    integer(c_int), pointer :: numbers(:) => null()  !! pieces done; all pieces, 0: unknown
    integer :: of_position = 1                       !! number of pieces of a position of a sweep
  contains
    procedure :: begin_count  !! sets the number of pieces
    procedure :: add_work     !! counts pieces that are done
    procedure :: count_state  !! counts a state of a position
  end type work_count

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

  !> Sets the number of pieces, and of those that are already done.
  subroutine begin_count(self, number, before)
    class(work_count), intent(in) :: self  !! numbers of the work
    integer, intent(in) :: number          !! number of all pieces
    integer, intent(in) :: before          !! number of pieces already done

    if (.not. associated(self%numbers)) return
    !$omp atomic write
    self%numbers(1) = int(before, c_int)
    !$omp atomic write
    self%numbers(2) = int(number, c_int)
  end subroutine begin_count

  !> Counts pieces that are done.
  subroutine add_work(self, number)
    class(work_count), intent(in) :: self  !! numbers of the work
    integer, intent(in) :: number          !! number of pieces; < 0: to be repeated

    if (.not. associated(self%numbers)) return
    !$omp atomic update
    self%numbers(1) = self%numbers(1) + int(number, c_int)
  end subroutine add_work

  !> Counts a state of a position. The last one is counted with the position, whose number of states
  !> may differ from the one assumed.
  subroutine count_state(self, counted)
    class(work_count), intent(in) :: self  !! numbers of the work
    integer, intent(inout) :: counted      !! number of counted states of the position

    if (counted >= self%of_position - 1) return
    counted = counted + 1
    call self%add_work(1)
  end subroutine count_state

end module asperity_interruption
