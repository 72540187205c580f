!> The Pareto front of run time and error.
module asperity_pareto_front
  use asperity_kinds, only: real64
  implicit none
  private

  public :: on_front

  ! Two methods cost the same, or err the same, when they differ by less than this factor. It is
  ! wide so that the front does not depend on the noise of the clock.
  real(real64), parameter :: same_time = 1.5_real64, same_error = 1.1_real64

contains

  !> The methods that no other method of the front excels; each of the rest is excelled by one of
  !> the front. A method excels another that is clearly less accurate at no clearly higher cost, or
  !> as accurate at a clearly higher cost; of two that are equal in both, the one whose gain,
  !> relative to what counts as equal, is larger. So no method of the front excels another through a
  !> third. Methods of one error and equal times have the least of these times, and the first of
  !> them is taken: the clock does not choose between methods that are the same.
  pure function on_front(seconds, error) result(front)
    real(real64), intent(in) :: seconds(:)  !! run times [s], more than 0
    real(real64), intent(in) :: error(:)    !! relative errors, 0 or more; as many
    logical :: front(size(seconds))
    logical, dimension(size(seconds)) :: rest, new
    real(real64) :: least(size(seconds))
    integer :: i, j

    do i = 1, size(seconds)
      least(i) = minval(seconds, abs(error - error(i)) <= 0.0_real64 .and. &
                                 seconds(i) <= same_time * seconds)
    end do
    front = .false.
    rest = .true.
    do while (any(rest))
      do i = 1, size(rest)
        new(i) = rest(i) .and. .not. any([(rest(j) .and. is_better(j, i), j=1, size(rest))])
      end do
      front = front .or. new
      do i = 1, size(rest)
        rest(i) = rest(i) .and. .not. new(i) .and. &
                  .not. any([(new(j) .and. is_better(j, i), j=1, size(new))])
      end do
    end do

  contains

    pure logical function is_better(one, other)
      integer, intent(in) :: one, other
      real(real64) :: more(2)  ! error and time, of what counts as equal: up to 1

      if (min(error(one), error(other)) > 0.0_real64) then
        more(1) = log(error(one) / error(other)) / log(same_error)
      else
        more(1) = sign(2.0_real64, error(one) - error(other))
        if (max(error(one), error(other)) <= 0.0_real64) more(1) = 0.0_real64
      end if
      more(2) = log(least(one) / least(other)) / log(same_time)
      is_better = any(more < -1.0_real64) .and. all(more < 1.0_real64)
      if (all(abs(more) <= 1.0_real64)) &
        is_better = sum(more) < 0.0_real64 .or. (.not. sum(more) > 0.0_real64 .and. one < other)
    end function is_better

  end function on_front

end module asperity_pareto_front
