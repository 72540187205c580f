!> Which ways of computing are worth their time.
module asperity_front
  use asperity_kinds, only: real64
  implicit none
  private

  public :: on_front

  ! Two ways cost the same, or err the same, when they differ by less than this factor. It is wide
  ! on purpose: the front must not depend on the clock's mood.
  real(real64), parameter :: same_time = 1.5_real64, same_error = 1.1_real64

contains

  !> Those that no other beats: one clearly more accurate at no clearly higher cost, or as accurate
  !> and clearly cheaper. Of ways equal in both the first stands.
  pure function on_front(seconds, error) result(front)
    real(real64), intent(in) :: seconds(:)  !! what each costs
    real(real64), intent(in) :: error(:)    !! how far each is off, 0 or more; as many
    logical :: front(size(seconds))
    integer :: i, j
    logical :: beaten

    do i = 1, size(front)
      beaten = .false.
      do j = 1, size(front)
        if (j == i) cycle
        if (error(j) * same_error < error(i)) then
          beaten = beaten .or. seconds(j) < seconds(i) * same_time
        else if (error(j) <= error(i) * same_error) then
          beaten = beaten .or. seconds(j) * same_time < seconds(i) .or. &
                   (j < i .and. seconds(j) < seconds(i) * same_time)
        end if
      end do
      front(i) = .not. beaten
    end do
  end function on_front

end module asperity_front
