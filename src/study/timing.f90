!> Times of repeated work: enough of them, their median, and a time that may be spent.
module asperity_timing
  use asperity_kinds, only: int64, real64
  implicit none
  private

  public :: time_allowance, add_sample, are_enough, sample_quantile

  ! At least so many passes are run, unless they take so many times the time to spend.
  integer, parameter :: least_passes = 3
  real(real64), parameter :: most_times = 3.0_real64
  ! A median is steady when the distance of the quartiles over the root of the number of samples,
  ! some 1.1 of its standard errors, is less than this share of it, and there are so many samples.
  real(real64), parameter :: steady_median = 0.01_real64
  integer, parameter :: many_passes = 9

  !> Time that may be spent on work of several pieces.
  type :: time_allowance
    private
    real(real64) :: seconds = 0.0_real64
    integer(int64) :: began = 0_int64
  contains
    procedure :: begin => begin_allowance  !! the time begins
    procedure :: left => seconds_left      !! seconds that are left
  end type time_allowance

contains

  !> Begins the time.
  subroutine begin_allowance(self, seconds)
    class(time_allowance), intent(inout) :: self  !! gets the time
    real(real64), intent(in) :: seconds           !! time that may be spent from now on [s]

    self%seconds = seconds
    call system_clock(self%began)
  end subroutine begin_allowance

  !> Seconds that are left; less than 0 where they are spent.
  real(real64) function seconds_left(self) result(seconds)
    class(time_allowance), intent(in) :: self  !! time that has begun
    integer(int64) :: now, rate

    call system_clock(now, rate)
    seconds = self%seconds - real(now - self%began, real64) / real(rate, real64)
  end function seconds_left

  !> Adds the time of a pass to sorted samples.
  pure subroutine add_sample(samples, seconds)
    real(real64), allocatable, intent(inout) :: samples(:)  !! times of passes [s], ascending
    real(real64), intent(in) :: seconds                     !! time of one more pass [s]
    integer :: place

    place = count(samples <= seconds)
    samples = [samples(:place), seconds, samples(place + 1:)]
  end subroutine add_sample

  !> Whether there are enough samples for a time to spend.
  pure logical function are_enough(samples, seconds)
    real(real64), intent(in) :: samples(:)  !! times of passes [s], ascending
    real(real64), intent(in) :: seconds     !! time to spend [s]

    are_enough = sum(samples) >= seconds .and. size(samples) >= least_passes .or. &
                 sum(samples) > most_times * seconds
    if (are_enough .or. size(samples) < many_passes) return
    are_enough = sample_quantile(samples, 0.75_real64) - sample_quantile(samples, 0.25_real64) < &
                 steady_median * sqrt(real(size(samples), real64)) * &
                 sample_quantile(samples, 0.5_real64)
  end function are_enough

  !> The value below which a share of sorted samples lies.
  pure real(real64) function sample_quantile(samples, share)
    real(real64), intent(in) :: samples(:)  !! at least one, ascending
    real(real64), intent(in) :: share       !! share from 0 to 1; 0.5: the median
    real(real64) :: place
    integer :: below

    place = 1.0_real64 + share * (size(samples) - 1)
    below = min(int(place), size(samples))
    sample_quantile = samples(below) + (place - below) * &
                      (samples(min(below + 1, size(samples))) - samples(below))
  end function sample_quantile

end module asperity_timing
