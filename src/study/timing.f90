!> Samples of a repeated measurement of time: median and spread.
module asperity_timing
  use asperity_kinds, only: real64
  implicit none
  private

  public :: timing_samples

  !> Seconds a position, one sample a pass.
  type :: timing_samples
    private
    real(real64), allocatable :: samples(:)
    real(real64) :: seconds = 0.0_real64
  contains
    !> Adds a pass over a number of positions.
    procedure :: add => samples_add
    !> Seconds measured so far.
    procedure :: total => samples_total
    !> Passes so far.
    procedure :: passes => samples_passes
    !> Median of the samples, s a position.
    procedure :: median => samples_median
    !> Half the distance between the quartiles, over the median.
    procedure :: spread => samples_spread
  end type timing_samples

contains

  pure subroutine samples_add(self, seconds, positions)
    class(timing_samples), intent(inout) :: self  !! the samples
    real(real64), intent(in) :: seconds           !! time of the pass
    integer, intent(in) :: positions              !! positions solved in it
    integer :: place

    if (.not. allocated(self%samples)) allocate (self%samples(0))
    place = count(self%samples <= seconds / positions)
    self%samples = [self%samples(:place), seconds / positions, self%samples(place + 1:)]
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

  pure real(real64) function samples_median(self)
    class(timing_samples), intent(in) :: self  !! at least one sample

    samples_median = quantile(self%samples, 0.5_real64)
  end function samples_median

  pure real(real64) function samples_spread(self)
    class(timing_samples), intent(in) :: self  !! at least one sample

    samples_spread = 0.5_real64 * (quantile(self%samples, 0.75_real64) - &
                                   quantile(self%samples, 0.25_real64)) / self%median()
  end function samples_spread

  !> The value below which a share of sorted samples lies.
  pure real(real64) function quantile(sorted, share)
    real(real64), intent(in) :: sorted(:), share
    real(real64) :: place
    integer :: below

    place = 1.0_real64 + share * (size(sorted) - 1)
    below = min(int(place), size(sorted))
    quantile = sorted(below) + (place - below) * &
               (sorted(min(below + 1, size(sorted))) - sorted(below))
  end function quantile

end module asperity_timing
