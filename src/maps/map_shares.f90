!> Shares of the load of a map on its edge, on spikes, on scan lines and on contact patches without
!> a summit, and the warnings of them.
module asperity_map_shares
  use asperity_constants, only: pi
  use asperity_height_map, only: height_map, is_measured, no_height
  use asperity_kinds, only: int64, real64
  use asperity_map_despiking, only: is_spike, limit_of_spikes
  use asperity_map_patches, only: map_patch
  use asperity_map_statistics, only: rms_slope_over
  use asperity_theory_warnings, only: add_warning, of_border, of_map_edge, of_map_slope, &
                                      of_missing, of_scan_lines, of_spikes, theory_warning, &
                                      warn_above
  implicit none
  private

  public :: find_shares, map_shares, warn_of_map, warn_of_shares

  !> Shares of the load of a map.
  type :: map_shares
    real(real64) :: on_edge = 0.0_real64         !! share on two rows and columns along the edge
    real(real64) :: edge_of_punch = 1.0_real64   !! share of a flat punch on the edge
    real(real64) :: on_lines = 0.0_real64        !! share on patches that are single scan lines
    real(real64) :: on_spikes = 0.0_real64       !! share on single outliers
  end type map_shares

  integer, parameter :: edge = 2  ! width of the edge [pixels]

  ! Least length of a scan line, a contact patch of one row [pixels].
  integer, parameter :: long_line = 8

contains

  !> Finds the shares of the load of a map.
  subroutine find_shares(map, pressure, patches, least_spikes, spike_limit, shares)
    type(height_map), intent(in) :: map         !! map that is in contact
    real(real64), intent(in) :: pressure(:, :)  !! pressure on its pixels
    type(map_patch), intent(in) :: patches(:)   !! contact patches of the pressure
    !> share of the load on outliers of their surroundings, up to which the limit is not computed
    real(real64), intent(in) :: least_spikes
    real(real64), intent(inout) :: spike_limit  !! `limit_of_spikes` of the map; below 0: unknown
    type(map_shares), intent(out) :: shares     !! shares of the load
    real(real64) :: inner, total
    integer :: first(2)

    total = sum(pressure)
    if (.not. total > 0.0_real64) return
    shares%on_lines = sum(patches%load, mask=patches%along(1) == patches%along(2) .and. &
                          patches%across(2) - patches%across(1) >= long_line - 1) / &
                      sum(patches%load)
    ! The limit takes the medians around all pixels: most maps have too few outliers for it.
    shares%on_spikes = share_on_spikes(max(0.0_real64, spike_limit))
    if (spike_limit < 0.0_real64 .and. shares%on_spikes > least_spikes) then
      spike_limit = limit_of_spikes(map)
      shares%on_spikes = share_on_spikes(spike_limit)
    end if
    if (map%periodic) return
    associate (n => size(pressure, 1), m => size(pressure, 2))
      first = merge(1, 1 + edge, [map%repeats(1), map%repeats(2)])
      shares%on_edge = 1.0_real64 - sum(pressure(first(1):n + 1 - first(1), &
                                                 first(2):m + 1 - first(2))) / total
      ! Beyond the radius r of a round punch of radius 1: sqrt(1 - r**2) (Johnson, eq. 3.34). On a
      ! strip beyond the distance r from the middle of a long one: 1 - 2/pi asin(r) (eq. 2.64).
      inner = max(0.0_real64, 1.0_real64 - 2.0_real64 * edge / &
                  minval([n, m], mask=first > 1))
      shares%edge_of_punch = sqrt(1.0_real64 - inner**2)
      if (map%strip_axis > 0) shares%edge_of_punch = 1.0_real64 - 2.0_real64 / pi * asin(inner)
    end associate

  contains

    ! Share of the load on outliers by more than a limit.
    real(real64) function share_on_spikes(limit) result(share)
      real(real64), intent(in) :: limit
      integer :: i, j

      share = 0.0_real64
      do j = 1, size(pressure, 2)
        do i = 1, size(pressure, 1)
          if (.not. pressure(i, j) > 0.0_real64) cycle
          if (is_spike(map, i, j, limit)) share = share + pressure(i, j) / total
        end do
      end do
    end function share_on_spikes

  end subroutine find_shares

  !> Warns of shares of the load on artefacts of the map.
  pure subroutine warn_of_shares(map, shares, tolerance, warnings)
    type(height_map), intent(in) :: map     !! that is in contact
    type(map_shares), intent(in) :: shares  !! shares of one state
    real(real64), intent(in) :: tolerance   !! largest share without a warning
    type(theory_warning), allocatable, intent(inout) :: warnings(:)  !! warnings of the state
    character(len=36) :: whose

    whose = ''
    if (map%is_between) whose = 'moved steps ring between the pixels'
    if (shares%on_edge > shares%edge_of_punch) &
      call add_warning(warnings, of_map_edge, shares%on_edge)
    if (shares%on_lines > tolerance) call add_warning(warnings, of_scan_lines, shares%on_lines)
    if (shares%on_spikes > tolerance) call add_warning(warnings, of_spikes, shares%on_spikes, &
                                                       whose=whose)
  end subroutine warn_of_shares

  !> Warns of a map with missing pixels, of a steep map, and of a periodic one with a jump at its
  !> border.
  pure subroutine warn_of_map(map, tolerance, has_form, has_caps, warnings)
    type(height_map), intent(in) :: map     !! levelled height map
    real(real64), intent(in) :: tolerance   !! largest share without a warning
    logical, intent(in) :: has_form         !! its form has slopes, and a bend at the border
    logical, intent(in) :: has_caps         !! spheres of a table are part of it
    type(theory_warning), allocatable, intent(inout) :: warnings(:)  !! warnings of the state
    real(real64) :: missing
    integer :: axis

    missing = count(.not. is_measured(map%height), kind=int64) / &
              real(size(map%height, kind=int64), real64)
    if (missing > tolerance) call add_warning(warnings, of_missing, missing)
    if (has_form) return
    if (.not. has_caps) call warn_above(warnings, of_map_slope, rms_slope_over(map, 1))
    do axis = 1, 2
      if (map%repeats(axis)) call warn_above(warnings, of_border, border_ratio(map%height, axis))
    end do
  end subroutine warn_of_map

  ! Second differences across the border lines of a periodic map, root of their mean square along a
  ! line, over those of the roughest inner line. In a periodic map the border is a line as any
  ! other; a jump or a bend there gives a large ratio.
  pure real(real64) function border_ratio(height, axis) result(ratio)
    real(real64), intent(in) :: height(:, :)
    integer, intent(in) :: axis  ! across which lines: 1 or 2
    real(real64), allocatable :: before(:, :), after(:, :), line(:)
    integer :: last

    last = size(height, axis)
    ratio = 0.0_real64
    if (last < 4) return
    before = cshift(height, -1, axis)
    after = cshift(height, 1, axis)
    where (min(height, before, after) > 0.5_real64 * no_height)
      before = (before - height) + (after - height)
    else where
      before = 0.0_real64
    end where
    line = norm2(before, 3 - axis)
    associate (border => max(line(1), line(last)), inner => maxval(line(2:last - 1)))
      if (border > 0.0_real64) ratio = border / max(inner, 1.0e-9_real64 * border)
    end associate
  end function border_ratio

end module asperity_map_shares
