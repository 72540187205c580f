!> Times of repeated work: median and spread, within a time that may be spent.
module asperity_timing
  use asperity_contact_records, only: position_result
  use asperity_kinds, only: int64, real64
  use asperity_position_solver, only: position_solver
  use asperity_problems, only: decimal_text
  implicit none
  private

  public :: time_allowance, time_solver, timing_samples

  ! So often at least everything is run, unless a pass takes so many times the time to spend.
  integer, parameter :: least_passes = 3
  real(real64), parameter :: long = 3.0_real64
  ! A median is steady when twice the spread over the root of the number of samples, some 1.1 of its
  ! standard errors, is less than this, and there are so many samples.
  real(real64), parameter :: steady = 0.01_real64
  integer, parameter :: many_passes = 9
  ! Short passes make one sample together, of this share of the time to spend: the clock counts in
  ! microseconds, and sorting samples must not take the time.
  real(real64), parameter :: share_of_a_sample = 0.02_real64

  !> Time that may be spent on work of several pieces. No piece takes more than a quarter of what
  !> is left, so that one that is slow leaves time for those behind it.
  type :: time_allowance
    private
    real(real64) :: seconds = 0.0_real64
    integer(int64) :: began = 0_int64
  contains
    procedure :: begin => allowance_begin  !! the time begins
    procedure :: left => allowance_left    !! seconds that are left
    procedure :: next => allowance_next    !! seconds that the next piece may take
  end type time_allowance

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
    !> Whether there are enough for a time to spend.
    procedure :: are_enough => samples_are_enough
    !> Median of the samples, s a position.
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
    class(time_allowance), intent(in) :: self  !! begun
    integer(int64) :: now, rate

    call system_clock(now, rate)
    seconds = self%seconds - real(now - self%began, real64) / real(rate, real64)
  end function allowance_left

  real(real64) function allowance_next(self) result(seconds)
    class(time_allowance), intent(in) :: self  !! begun

    seconds = 0.25_real64 * self%left()
  end function allowance_next

  !> Solves all positions again and again on the clock, on one thread, until the median is steady or
  !> the time is spent. Where `most_seconds` are over before all positions are solved once, there
  !> are no passes, and no results.
  subroutine time_solver(solver, least_seconds, most_seconds, positions, timing, failure)
    class(position_solver), intent(in) :: solver           !! a scene made ready
    real(real64), intent(in) :: least_seconds              !! time to spend, s
    real(real64), intent(in) :: most_seconds               !! time that is left, s
    type(position_result), allocatable, intent(out) :: positions(:)  !! of the last pass
    type(timing_samples), intent(out) :: timing            !! seconds a position, by pass
    character(len=:), allocatable, intent(out) :: failure  !! why a position cannot be solved
    type(time_allowance) :: allowance
    integer(int64) :: from, until, rate
    integer :: m, pass, passes

    allocate (positions(solver%positions))
    call allowance%begin(most_seconds)
    passes = 1
    do while (.not. timing%are_enough(least_seconds))
      call system_clock(from, rate)
      do pass = 1, passes
        do m = 1, solver%positions
          call solver%solve(m, .false., positions(m), failure)
          if (allocated(failure)) then
            failure = 'position ' // decimal_text(m) // ': ' // failure
            return
          end if
          if (allowance%left() < 0.0_real64 .and. m < solver%positions) return
        end do
      end do
      call system_clock(until)
      call timing%add(real(until - from, real64) / real(rate, real64), passes * solver%positions)
      if (allowance%left() < 0.0_real64) return
      if (timing%passes() == 1) &
        passes = max(1, int(min(share_of_a_sample * least_seconds / &
                                max(timing%total(), 1.0e-6_real64), 1.0e6_real64)))
    end do
  end subroutine time_solver

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

  pure logical function samples_are_enough(self, seconds)
    class(timing_samples), intent(in) :: self  !! the samples
    real(real64), intent(in) :: seconds        !! time to spend

    samples_are_enough = self%total() >= seconds .and. self%passes() >= least_passes .or. &
                         self%total() > long * seconds
    if (samples_are_enough .or. self%passes() < many_passes) return
    samples_are_enough = 2 * self%spread() < steady * sqrt(real(self%passes(), real64))
  end function samples_are_enough

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
