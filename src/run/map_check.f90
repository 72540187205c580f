!> Error of the summits of a map: comparison with the pixels of the map at the same load.
!>
!> The reference solution is computed at the full resolution when the map has few pixels, else at
!> half of it or less. The separation at full resolution and its uncertainty are then extrapolated
!> from the changes between resolutions. The reference comes first: where its contact area
!> percolates, summits are no separate contacts.
module asperity_map_check
  use asperity_contact_records, only: state_row
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: int64, real64
  use asperity_map_contact, only: closed_fully, closed_start, half_map, map_answer, press_map
  use asperity_map_patches, only: find_patches, map_patch
  use asperity_map_scene, only: area_of_map
  use asperity_map_shares, only: find_shares
  use asperity_map_summits, only: map_summits
  use asperity_problems, only: real_text
  use asperity_scene_results, only: map_record
  implicit none
  private

  public :: compare_with_map, map_reference, solve_reference, stiffness_step

  !> Reference solution: the map on its pixels, or on coarser ones.
  type :: map_reference
    type(height_map) :: map        !! the map, or a coarser one
    integer :: coarser = 1         !! number of pixels along the side of a coarser one
    logical :: by_load = .true.    !! whether the scene gives loads, else levels
    real(real64) :: closed = closed_fully  !! tolerance of gaps, relative to the range of heights
    type(map_answer) :: answer     !! last solution
    !> Largest number of pixels at full resolution: some seconds.
    integer(int64) :: most = 600000_int64
    !> Largest number of coarser pixels: half a minute. The median estimate is 3.2 times the error
    !> at a quarter of the resolution, 7 times at an eighth (measured).
    integer(int64) :: most_coarser = 4500000_int64
  end type map_reference

  !> Relative increase of the load for a stiffness (chosen).
  real(real64), parameter :: stiffness_step = 0.01_real64

  ! Contact area fraction at which the contact of a rough surface percolates, for any spectrum
  ! (Dapp, Luecke, Persson and Mueser, Phys. Rev. Lett. 108 (2012) 244301).
  real(real64), parameter :: percolation = 0.42_real64

contains

  !> Solves the reference at the last load or level of a scene. `failure` is allocated when it is
  !> not solved, or when its contact area percolates.
  subroutine solve_reference(map, modulus, last, reference, failure)
    type(height_map), intent(in) :: map                    !! levelled height map
    real(real64), intent(in) :: modulus                    !! combined modulus, > 0
    real(real64), intent(in) :: last                       !! last load or level of the scene
    type(map_reference), intent(inout) :: reference        !! control, interruption; the solution
    character(len=:), allocatable, intent(out) :: failure  !! reason, when summits are not valid
    type(map_patch), allocatable :: patches(:)
    real(real64) :: share

    reference%map = map
    do while (size(reference%map%height, kind=int64) > &
              merge(reference%most, reference%most_coarser, reference%coarser == 1))
      reference%map = half_map(reference%map)
      reference%coarser = 2 * reference%coarser
      reference%closed = closed_start
    end do
    if (.not. reference%by_load) then
      reference%answer%level = last
      call press_map(reference%map, modulus, reference%answer, tolerance=reference%closed)
    else if (last > 0.0_real64) then
      call press_map(reference%map, modulus, reference%answer, last, reference%closed)
    end if
    if (allocated(reference%answer%failure)) &
      failure = 'the comparison with the pixels of the map: ' // reference%answer%failure
    if (allocated(failure) .or. .not. allocated(reference%answer%pressure)) return
    call find_patches(reference%map, reference%answer%pressure, patches)
    share = sum(patches%area) / area_of_map(reference%map)
    if (share > percolation) then
      failure = 'the contact area fraction is ' // real_text(share, 'f4.2') // ', above the ' // &
                'percolation threshold 0.42: expected interaction = ''boundary'' or a smaller load'
    end if
  end subroutine solve_reference

  !> Compares the last state of the summits with the reference solution at the same load.
  subroutine compare_with_map(map, reference, modulus, summits, state, stiffness, check, failure)
    type(height_map), intent(in) :: map         !! levelled height map
    type(map_reference), intent(inout) :: reference  !! reference solution, solved to this load
    real(real64), intent(in) :: modulus         !! combined modulus, > 0
    type(map_summits), intent(in) :: summits    !! summits of this map
    type(state_row), intent(in) :: state        !! state of the summits with a load > 0
    real(real64), intent(in) :: stiffness       !! stiffness of the summits, or `not_computed`
    type(map_record), intent(out) :: check      !! differences of the summits
    character(len=:), allocatable, intent(out) :: failure  !! reason, when the map is not solved
    type(map_answer) :: at_level
    real(real64) :: beyond, candidate(3), change(2), halvings, load, level

    check%summits = size(summits%x)
    check%coarser = reference%coarser
    check%rms_height = sqrt(sum(map%height**2, mask=is_measured(map%height)) / &
                            count(is_measured(map%height), kind=int64))
    associate (answer => reference%answer)
      ! By load the map has been solved to this load. Otherwise it is solved again, from its coarser
      ! levels: their results estimate the error of discretisation.
      if (.not. (reference%by_load .and. allocated(answer%pressure))) then
        if (allocated(answer%pressure)) deallocate (answer%pressure)
        call press_map(reference%map, modulus, answer, state%vertical_load, reference%closed)
      end if
      if (allocated(answer%failure)) then
        failure = 'beside its summits: ' // answer%failure
        return
      end if
      beyond = 0.0_real64
      ! The level is extrapolated from coarser pixels to those of the map. A halving of the pixel
      ! changes it by half of the last change (smooth slopes), by the last change (the same
      ! roughness at each scale), or by a linear extrapolation of the changes. The result is the
      ! mean of the three, its uncertainty half of their range. On 36 generated maps of 512 x 512
      ! pixels, solved at half resolution with 0.3 to 10 % contact, the median error was 0.002 rms
      ! heights, the largest 0.009, and 34 errors were within the uncertainty (measured).
      if (reference%coarser > 1) then
        change = [answer%level, answer%coarser(1)] - answer%coarser
        halvings = log(real(reference%coarser, real64)) / log(2.0_real64)
        candidate = change(1) * [1.0_real64 - 1.0_real64 / reference%coarser, halvings, halvings]
        candidate(3) = candidate(2) + &
                       (change(1) - change(2)) * 0.5_real64 * halvings * (halvings + 1)
        beyond = sum(candidate) / 3
        check%uncertain = 0.5_real64 * (maxval(candidate) - minval(candidate))
      end if
      level = answer%level + beyond
      check%difference = (state%approach - level) / check%rms_height
      check%compression = maxval(map%height) - level
      call find_load_shares(map, reference, summits, state%area, check)
      if (.not. reference%by_load) then
        at_level%pressure = answer%pressure
        at_level%interrupt = answer%interrupt
        load = load_at(state%approach - beyond)
        if (load > 0.0_real64) check%load_difference = state%vertical_load / load - 1.0_real64
        if (load > 0.0_real64 .and. reference%coarser > 1) &
          check%load_uncertain = load_at(state%approach - beyond - check%uncertain) / load - &
                                 1.0_real64
      end if
      check%uncertain = check%uncertain / check%rms_height
      if (.not. stiffness > 0.0_real64) return
      call press_map(reference%map, modulus, answer, &
                     (1.0_real64 + stiffness_step) * state%vertical_load, reference%closed)
      if (allocated(answer%failure)) failure = 'beside its summits: ' // answer%failure
      check%stiffness_difference = stiffness * (level - beyond - answer%level) / &
                                   (stiffness_step * state%vertical_load) - 1.0_real64
    end associate

  contains

    ! Load of the reference map at a level.
    real(real64) function load_at(level) result(load)
      real(real64), intent(in) :: level

      at_level%level = level
      call press_map(reference%map, modulus, at_level, tolerance=reference%closed)
      load = at_level%load
    end function load_at

  end subroutine compare_with_map

  ! Finds the shares of the load without summits, and the difference of the area.
  subroutine find_load_shares(map, reference, summits, area, check)
    type(height_map), intent(in) :: map
    type(map_reference), intent(in) :: reference
    type(map_summits), intent(in) :: summits
    real(real64), intent(in) :: area
    type(map_record), intent(inout) :: check
    type(map_patch), allocatable :: patches(:)
    integer, allocatable :: patch_at(:, :)
    logical, allocatable :: has_summit(:)
    integer :: i, j, k
    real(real64) :: first, spike_limit

    ! Distance of the first pixel to the centre of the first coarser one [coarser pixels].
    first = 0.5_real64 * (1.0_real64 - 1.0_real64 / reference%coarser)
    call find_patches(reference%map, reference%answer%pressure, patches, patch_at)
    if (reference%coarser == 1) check%area_difference = area / sum(patches%area) - 1.0_real64
    allocate (has_summit(0:size(patches)), source=.false.)
    do k = 1, size(summits%x)
      i = 1 + nint(summits%x(k) / reference%map%pixel_spacing(1) - first)
      j = 1 + nint(summits%y(k) / reference%map%pixel_spacing(2) - first)
      if (reference%map%periodic) then
        i = 1 + modulo(i - 1, reference%map%columns)
        j = 1 + modulo(j - 1, reference%map%rows)
      end if
      has_summit(patch_at(min(max(i, 1), reference%map%columns), &
                          min(max(j, 1), reference%map%rows))) = .true.
    end do
    spike_limit = -1.0_real64
    call find_shares(map, reference%answer%pressure, patches, 0.0_real64, spike_limit, &
                     check%shares)
    check%shares%without_summit = sum(patches%load, mask=.not. has_summit(1:)) / sum(patches%load)
  end subroutine find_load_shares

end module asperity_map_check
