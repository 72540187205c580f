!> Replaces single outliers of a map: spikes that are not summits.
!>
!> The deviation of a pixel is its distance from the median of the 5 x 5 pixels around it. The
!> deviation of an outlier is more than eight times the median deviation of the map, and more than
!> eight times the median of that over the 5 x 5 pixels, which keeps steep flanks. For Gaussian
!> deviations eight medians are 5.4 standard deviations. An outlier is replaced by the median. The
!> map is levelled and searched again until no outlier is found.
module asperity_map_despiking
  use asperity_height_map, only: height_map, index_beside, is_measured, no_height
  use asperity_kinds, only: int64, real64
  use asperity_map_levelling, only: level_map
  use asperity_process, only: check_memory
  use asperity_progress, only: progress_line
  implicit none
  private

  public :: despike_map, is_spike, limit_of_spikes

  integer, parameter :: reach = 2, lower_half = 2 * reach * (reach + 1) + 1
  real(real64), parameter :: most_deviations = 8.0_real64
  ! Each round changes the medians of the next; a map that still changes then is all spikes.
  integer, parameter :: most_rounds = 20

contains

  !> Replaces the outliers of a levelled map. `failure` is allocated when memory is short.
  subroutine despike_map(map, level, progress, spikes, failure)
    type(height_map), intent(inout) :: map  !! levelled map; on exit without outliers
    integer, intent(in) :: level  !! rule for levelling of `asperity_height_map`
    logical, intent(in) :: progress                         !! print the progress
    integer(int64), intent(out) :: spikes                   !! number of pixels that were replaced
    character(len=:), allocatable, intent(out) :: failure   !! reason, when memory is short
    real(real64), allocatable :: deviation(:, :)
    type(progress_line) :: shown
    real(real64) :: limit
    integer(int64) :: found
    integer :: round, i, j, status

    spikes = 0_int64
    allocate (deviation(map%columns, map%rows), stat=status)
    call check_memory('the spikes of the map', failure, status)
    if (allocated(failure)) return
    do round = 1, most_rounds
      call shown%begin(progress, 'profiles looked at for spikes', map%rows, 0)
      do j = 1, map%rows
        do i = 1, map%columns
          deviation(i, j) = no_height
          if (is_measured(map%height(i, j))) &
            deviation(i, j) = map%height(i, j) - median_near(map, i, j)
        end do
        call shown%reach(j)
      end do
      call shown%finish()
      limit = limit_of(deviation)
      do j = 1, map%rows
        do i = 1, map%columns
          if (.not. (is_measured(deviation(i, j)) .and. abs(deviation(i, j)) > limit)) cycle
          ! A pixel whose surroundings deviate as much is no outlier.
          if (abs(deviation(i, j)) <= most_deviations * &
              median_near(map, i, j, map%height(i, j) - deviation(i, j))) &
            deviation(i, j) = 0.0_real64
        end do
      end do
      found = count(is_measured(deviation) .and. abs(deviation) > limit, kind=int64)
      if (found == 0_int64) exit
      where (is_measured(deviation) .and. abs(deviation) > limit) &
        map%height = map%height - deviation
      spikes = spikes + found
      call level_map(map, level)
    end do
  end subroutine despike_map

  !> Deviation from the median around it above which a pixel of a map is an outlier.
  real(real64) function limit_of_spikes(map) result(limit)
    type(height_map), intent(in) :: map   !! levelled height map
    real(real64), allocatable :: deviation(:, :)
    integer :: i, j

    allocate (deviation(map%columns, map%rows), source=no_height)
    do j = 1, map%rows
      do i = 1, map%columns
        if (is_measured(map%height(i, j))) &
          deviation(i, j) = map%height(i, j) - median_near(map, i, j)
      end do
    end do
    limit = limit_of(deviation)
  end function limit_of_spikes

  !> Whether a pixel is an outlier above its surroundings.
  pure logical function is_spike(map, i, j, limit)
    type(height_map), intent(in) :: map   !! levelled height map
    integer, intent(in) :: i, j           !! column and row of a measured pixel
    real(real64), intent(in) :: limit     !! `limit_of_spikes` of the map
    real(real64) :: median, rise

    is_spike = .not. all([i, j] > reach .and. [i, j] <= [map%columns, map%rows] - reach)
    if (.not. is_spike) &
      is_spike = may_be_spike(map%height(i - reach:i + reach, j - reach:j + reach))
    if (.not. is_spike) return
    median = median_near(map, i, j)
    rise = map%height(i, j) - median
    is_spike = rise > limit
    if (is_spike) is_spike = rise > most_deviations * median_near(map, i, j, median)
  end function is_spike

  ! Whether the middle of 5 x 5 pixels may be an outlier. More than half of the 24 others are then
  ! within an eighth of its rise from their median, so three of the four in one of six rings: the
  ! middle is above these by 3.5 times their range or more (3: room for rounding).
  pure logical function may_be_spike(near)
    real(real64), intent(in) :: near(-reach:reach, -reach:reach)
    integer, parameter :: ring(2, 6) = reshape([1, 0, 1, 1, 2, 0, 2, 1, 1, 2, 2, 2], [2, 6])
    real(real64) :: a, b, c, d, second, third
    integer :: k

    do k = 1, size(ring, 2)
      a = min(near(ring(1, k), ring(2, k)), near(-ring(1, k), -ring(2, k)))
      b = max(near(ring(1, k), ring(2, k)), near(-ring(1, k), -ring(2, k)))
      c = min(near(ring(2, k), -ring(1, k)), near(-ring(2, k), ring(1, k)))
      d = max(near(ring(2, k), -ring(1, k)), near(-ring(2, k), ring(1, k)))
      second = min(max(a, c), min(b, d))
      third = max(max(a, c), min(b, d))
      may_be_spike = .not. min(a, c) > 0.5_real64 * no_height
      if (.not. may_be_spike) &
        may_be_spike = near(0, 0) - third > 3.0_real64 * (third - min(a, c)) .or. &
                       near(0, 0) - max(b, d) > 3.0_real64 * (max(b, d) - second)
      if (may_be_spike) return
    end do
  end function may_be_spike

  ! Eight times the median of the absolute deviations.
  pure real(real64) function limit_of(deviation) result(limit)
    real(real64), intent(in) :: deviation(:, :)

    limit = median_size(deviation)
    ! Most pixels of a coarsely quantised map are their own medians.
    if (.not. limit > 0.0_real64) &
      limit = sum(abs(deviation), mask=is_measured(deviation)) / &
              count(is_measured(deviation), kind=int64)
    limit = most_deviations * limit
  end function limit_of

  ! The median of the pixels around one, itself included, or of their distances from a height.
  pure real(real64) function median_near(map, column, row, from) result(median)
    type(height_map), intent(in) :: map
    integer, intent(in) :: column, row
    real(real64), intent(in), optional :: from
    real(real64) :: sorted(lower_half), z  ! the lower half alone
    integer :: across, along, columns(-reach:reach), k, number, rows(-reach:reach)

    number = 0
    columns = index_beside([(column + k, k=-reach, reach)], map%columns, map%periodic)
    rows = index_beside([(row + k, k=-reach, reach)], map%rows, map%periodic)
    do along = -reach, reach
      if (rows(along) == 0) cycle
      do across = -reach, reach
        if (columns(across) == 0) cycle
        z = map%height(columns(across), rows(along))
        if (.not. z > 0.5_real64 * no_height) cycle
        if (present(from)) z = abs(z - from)
        number = number + 1
        if (number > size(sorted)) then
          if (sorted(size(sorted)) <= z) cycle
        end if
        do k = min(number, size(sorted)) - 1, 1, -1
          if (sorted(k) <= z) exit
          sorted(k + 1) = sorted(k)
        end do
        sorted(k + 1) = z
      end do
    end do
    median = 0.5_real64 * (sorted((number + 1) / 2) + sorted(number / 2 + 1))
  end function median_near

  ! The median of the absolute values, by bisection on the bits of the result: positive doubles and
  ! their bits, read as integers, have the same order.
  pure real(real64) function median_size(values)
    real(real64), intent(in) :: values(:, :)
    integer(int64) :: number

    number = count(is_measured(values), kind=int64)
    median_size = 0.5_real64 * (at_rank((number + 1_int64) / 2_int64) + &
                                at_rank(number / 2_int64 + 1_int64))

  contains

    pure real(real64) function at_rank(rank)
      integer(int64), intent(in) :: rank
      integer(int64) :: low, high, middle, below
      integer :: j

      low = 0_int64
      high = transfer(0.5_real64 * huge(1.0_real64), high)
      do while (low < high)
        middle = low + (high - low) / 2_int64
        at_rank = transfer(middle, at_rank)
        below = 0_int64
        do j = 1, size(values, 2)
          below = below + count(abs(values(:, j)) <= at_rank)
        end do
        if (below >= rank) then
          high = middle
        else
          low = middle + 1_int64
        end if
      end do
      at_rank = transfer(low, at_rank)
    end function at_rank

  end function median_size

end module asperity_map_despiking
