!> What the summits of a map cost: they are held against the map itself at the same load.
!>
!> The map is pressed at its full resolution when it has few enough samples, else at a half, a
!> quarter and so on of it, and once more at half of that: the difference says how good the
!> comparison is.
module asperity_map_check
  use asperity_contact_records, only: state_row
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: int64, not_computed, real64
  use asperity_map_contact, only: half_map, map_answer, press_map
  use asperity_map_patches, only: find_patches, map_patch
  use asperity_map_summits, only: map_summits
  use asperity_numeral, only: read_numeral
  use asperity_scene_results, only: map_record
  use asperity_scene_values, only: control_load, scene_loading
  implicit none
  private

  public :: a_little_more, hold_against_map, stiffness_between

  !> Samples up to which the map is pressed as it is: some seconds.
  integer(int64), parameter, public :: full_samples = 600000_int64

  ! Share of the load by which a stiffness is measured.
  real(real64), parameter :: stiffness_step = 0.01_real64

  ! Rows and columns that count as the edge.
  integer, parameter :: edge = 2

  ! A spot of one row, at least so many samples long, is a scan line.
  integer, parameter :: long_line = 8

contains

  !> A load a little more than that of a state.
  type(scene_loading) function a_little_more(state) result(loading)
    type(state_row), intent(in) :: state  !! its load more than 0
    character(len=24) :: digits
    logical :: good

    write (digits, '(es24.16e3)') (1.0_real64 + stiffness_step) * state%load
    loading%control = control_load
    call read_numeral(trim(adjustl(digits)), loading%value, good)
  end function a_little_more

  !> Load over approach between two states.
  pure real(real64) function stiffness_between(state, more) result(stiffness)
    type(state_row), intent(in) :: state  !! at a load
    type(state_row), intent(in) :: more   !! at a little more

    stiffness = not_computed
    if (more%closing > state%closing) &
      stiffness = (more%vertical_load - state%vertical_load) / (more%closing - state%closing)
  end function stiffness_between

  !> Holds the last state of the summits against the map at the same load.
  subroutine hold_against_map(map, periodic, modulus, summits, state, stiffness, check, failure)
    type(height_map), intent(in) :: map         !! levelled
    logical, intent(in) :: periodic             !! it repeats itself
    real(real64), intent(in) :: modulus         !! combined
    type(map_summits), intent(in) :: summits    !! of this map
    type(state_row), intent(in) :: state        !! of the summits, its load more than 0
    real(real64), intent(in) :: stiffness       !! of them: load over approach; or `not_computed`
    type(map_record), intent(out) :: check      !! how they compare
    character(len=:), allocatable, intent(out) :: failure  !! why not
    type(height_map) :: seen, half
    type(map_answer) :: answer, at_level, coarse
    real(real64) :: level

    seen = map
    check%summits = size(summits%x)
    check%coarser = 1
    do while (size(seen%height, kind=int64) > full_samples)
      seen = half_map(seen)
      check%coarser = 2 * check%coarser
    end do
    check%rms_height = rms_of(map)
    call press_map(seen, periodic, modulus, answer, state%vertical_load)
    if (.not. allocated(answer%failure) .and. check%coarser > 1) then
      half = half_map(seen)
      call press_map(half, periodic, modulus, coarse, state%vertical_load)
      check%uncertain = abs(coarse%level - answer%level) / check%rms_height
      if (allocated(coarse%failure)) answer%failure = coarse%failure
    end if
    level = answer%level
    check%level = level
    check%difference = (state%approach - level) / check%rms_height
    if (check%coarser == 1) then
      check%area = answer%area
      check%area_difference = state%area / answer%area - 1.0_real64
    end if
    check%closing = maxval(map%height) - level
    at_level%level = state%approach
    if (.not. allocated(answer%failure)) &
      call press_map(seen, periodic, modulus, at_level)
    if (at_level%load > 0.0_real64) &
      check%load_difference = state%vertical_load / at_level%load - 1.0_real64
    if (.not. allocated(answer%failure)) call share_out(seen, periodic, answer, summits, &
                                                        check%coarser, check)
    if (.not. allocated(answer%failure) .and. stiffness > 0.0_real64) then
      call press_map(seen, periodic, modulus, answer, &
                     (1.0_real64 + stiffness_step) * state%vertical_load)
      check%stiffness = stiffness_step * state%vertical_load / (level - answer%level)
      check%stiffness_difference = stiffness / check%stiffness - 1.0_real64
    end if
    if (allocated(answer%failure)) failure = 'beside its summits: ' // answer%failure
  end subroutine hold_against_map

  ! Shares of the load that summits cannot stand for.
  subroutine share_out(map, periodic, answer, summits, coarser, check)
    type(height_map), intent(in) :: map
    logical, intent(in) :: periodic
    type(map_answer), intent(in) :: answer
    type(map_summits), intent(in) :: summits
    integer, intent(in) :: coarser
    type(map_record), intent(inout) :: check
    type(map_patch), allocatable :: patches(:)
    integer, allocatable :: spot(:, :)
    logical, allocatable :: has_summit(:)
    integer :: i, j, k
    real(real64) :: first, total

    ! From the first sample to the middle of the first of those that are coarser.
    first = 0.5_real64 * (1.0_real64 - 1.0_real64 / coarser)
    call find_patches(map, periodic, answer%pressure, patches, spot)
    allocate (has_summit(0:size(patches)), source=.false.)
    do k = 1, size(summits%x)
      i = 1 + nint(summits%x(k) / map%spacing(1) - first)
      j = 1 + nint(summits%y(k) / map%spacing(2) - first)
      has_summit(spot(min(max(i, 1), map%columns), min(max(j, 1), map%rows))) = .true.
    end do
    total = sum(patches%load)
    check%without_summit = sum(patches%load, mask=.not. has_summit(1:)) / total
    check%on_lines = sum(patches%load, mask=patches%along(1) == patches%along(2) .and. &
                         patches%across(2) - patches%across(1) >= long_line - 1) / total
    if (periodic) return
    associate (p => answer%pressure, n => map%columns, m => map%rows)
      check%on_edge = 1.0_real64 - sum(p(1 + edge:n - edge, 1 + edge:m - edge)) / sum(p)
    end associate
  end subroutine share_out

  ! Root of the mean square of the heights about their mean.
  pure real(real64) function rms_of(map) result(rms)
    type(height_map), intent(in) :: map
    real(real64) :: mean
    integer(int64) :: n

    n = count(is_measured(map%height), kind=int64)
    mean = sum(map%height, mask=is_measured(map%height)) / n
    rms = sqrt(sum((map%height - mean)**2, mask=is_measured(map%height)) / n)
  end function rms_of

end module asperity_map_check
