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

  !> Those that no other of them beats, while each of the rest is beaten by one of them. One beats
  !> another that is clearly less accurate at no clearly higher cost, or as accurate and clearly
  !> dearer; of ways equal in both the first. So the cheapest of ways that each cost a little more
  !> may be on it.
  pure function on_front(seconds, error) result(front)
    real(real64), intent(in) :: seconds(:)  !! what each costs
    real(real64), intent(in) :: error(:)    !! how far each is off, 0 or more; as many
    logical :: front(size(seconds))
    logical, dimension(size(seconds)) :: rest, new
    integer :: i, j

    front = .false.
    rest = .true.
    do while (any(rest))
      do i = 1, size(rest)
        new(i) = rest(i) .and. .not. any([(rest(j) .and. beats(j, i), j=1, size(rest))])
      end do
      ! Of ways that beat each other in a ring the first.
      if (.not. any(new)) new(findloc(rest, .true., 1)) = .true.
      front = front .or. new
      do i = 1, size(rest)
        rest(i) = rest(i) .and. .not. new(i) .and. &
                  .not. any([(new(j) .and. beats(j, i), j=1, size(new))])
      end do
    end do

  contains

    pure logical function beats(one, other)
      integer, intent(in) :: one, other

      associate (no_dearer => seconds(one) < seconds(other) * same_time)
        if (error(one) * same_error < error(other)) then
          beats = no_dearer
        else
          beats = error(one) <= error(other) * same_error .and. &
                  (seconds(one) * same_time < seconds(other) .or. (one < other .and. no_dearer))
        end if
      end associate
    end function beats

  end function on_front

end module asperity_front
