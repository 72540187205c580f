!> Times of repeated work: median and spread, within a time that may be spent.
module asperity_timing
  use asperity_kinds, only: int64, real64
  implicit none
  private

  public :: time_allowance, timing_samples

  ! So often at least everything is run, unless a pass takes so many times the time to spend.
  integer, parameter :: least_passes = 3
  real(real64), parameter :: most_times = 3.0_real64
  ! A median is steady when twice the spread over the root of the number of samples, some 1.1 of its
  ! standard errors, is less than this, and there are so many samples.
  real(real64), parameter :: steady_median = 0.01_real64
  integer, parameter :: many_passes = 9

  !> Time that may be spent on work of several pieces.
  type :: time_allowance
    private
    real(real64) :: seconds = 0.0_real64
    integer(int64) :: began = 0_int64
  contains
    procedure :: begin => allowance_begin  !! the time begins
    procedure :: left => allowance_left    !! seconds that are left
  end type time_allowance

  !> Seconds, one sample a pass.
  type :: timing_samples
    private
    real(real64), allocatable :: samples(:)
    real(real64) :: seconds = 0.0_real64
  contains
    !> Adds a pass.
    procedure :: add => samples_add
    !> Seconds measured so far.
    procedure :: total => samples_total
    !> Passes so far.
    procedure :: passes => samples_passes
    !> Whether there are enough for a time to spend.
    procedure :: are_enough => samples_are_enough
    !> Median of the samples, s.
    procedure :: median => samples_median
    !> Half the distance between the quartiles, over the median.
    procedure :: spread => samples_spread
  end type timing_samples

contains

  !> The time begins.
  subroutine allowance_begin(self, seconds)
    class(time_allowance), intent(inout) :: self  !! the time
    real(real64), intent(in) :: seconds           !! that may be spent from now on

    self%seconds = seconds
    call system_clock(self%began)
  end subroutine allowance_begin

  real(real64) function allowance_left(self) result(seconds)
    class(time_allowance), intent(in) :: self  !! time that has begun
    integer(int64) :: now, rate

    call system_clock(now, rate)
    seconds = self%seconds - real(now - self%began, real64) / real(rate, real64)
  end function allowance_left

  pure subroutine samples_add(self, seconds)
    class(timing_samples), intent(inout) :: self  !! the samples
    real(real64), intent(in) :: seconds           !! time of the pass
    integer :: place

    if (.not. allocated(self%samples)) allocate (self%samples(0))
    place = count(self%samples <= seconds)
    self%samples = [self%samples(:place), seconds, self%samples(place + 1:)]
    self%seconds = self%seconds + seconds
  end subroutine samples_add

  pure real(real64) function samples_total(self)
    class(timing_samples), intent(in) :: self  !! the samples

    samples_total = self%seconds
  end function samples_total

  pure integer function samples_passes(self)
    class(timing_samples), intent(in) :: self  !! the samples

    samples_passes = 0
    if (allocated(self%samples)) samples_passes = size(self%samples)
  end function samples_passes

  pure logical function samples_are_enough(self, seconds)
    class(timing_samples), intent(in) :: self  !! the samples
    real(real64), intent(in) :: seconds        !! time to spend

    samples_are_enough = self%total() >= seconds .and. self%passes() >= least_passes .or. &
                         self%total() > most_times * seconds
    if (samples_are_enough .or. self%passes() < many_passes) return
    samples_are_enough = 2 * self%spread() < steady_median * sqrt(real(self%passes(), real64))
  end function samples_are_enough

  pure real(real64) function samples_median(self)
    class(timing_samples), intent(in) :: self  !! at least one sample

    samples_median = sample_quantile(self%samples, 0.5_real64)
  end function samples_median

  pure real(real64) function samples_spread(self)
    class(timing_samples), intent(in) :: self  !! at least one sample

    samples_spread = 0.5_real64 * (sample_quantile(self%samples, 0.75_real64) - &
                                   sample_quantile(self%samples, 0.25_real64)) / self%median()
  end function samples_spread

  !> The value below which a share of sorted samples lies.
  pure real(real64) function sample_quantile(sorted, share)
    real(real64), intent(in) :: sorted(:), share
    real(real64) :: place
    integer :: below

    place = 1.0_real64 + share * (size(sorted) - 1)
    below = min(int(place), size(sorted))
    sample_quantile = sorted(below) + (place - below) * &
               (sorted(min(below + 1, size(sorted))) - sorted(below))
  end function sample_quantile

end module asperity_timing
