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
  !> dearer; of ways equal in both the one whose gain, over what counts as equal, is larger. So none
  !> beats one that beats it by way of others, and the cheapest of ways that each cost a little more
  !> may be on the front.
  pure function on_front(seconds, error) result(front)
    real(real64), intent(in) :: seconds(:)  !! what each costs, more than 0
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
      front = front .or. new
      do i = 1, size(rest)
        rest(i) = rest(i) .and. .not. new(i) .and. &
                  .not. any([(new(j) .and. beats(j, i), j=1, size(new))])
      end do
    end do

  contains

    pure logical function beats(one, other)
      integer, intent(in) :: one, other
      real(real64) :: more(2)  ! error and time, of what counts as equal: up to 1

      if (min(error(one), error(other)) > 0.0_real64) then
        more(1) = log(error(one) / error(other)) / log(same_error)
      else
        more(1) = sign(2.0_real64, error(one) - error(other))
        if (max(error(one), error(other)) <= 0.0_real64) more(1) = 0.0_real64
      end if
      more(2) = log(seconds(one) / seconds(other)) / log(same_time)
      beats = any(more < -1.0_real64) .and. all(more < 1.0_real64)
      if (all(abs(more) <= 1.0_real64)) &
        beats = sum(more) < 0.0_real64 .or. (.not. sum(more) > 0.0_real64 .and. one < other)
    end function beats

  end function on_front

end module asperity_front
