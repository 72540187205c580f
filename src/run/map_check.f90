!> What the summits of a map cost: they are held against the map itself at the same load.
!>
!> The map is pressed at its full resolution when it has few enough samples, else at a half of it,
!> or what memory and patience allow: what its separation changes by from still coarser ones, which
!> it starts from, says what that of all samples is, and how sure. It is pressed before they are:
!> where it is one contact with holes in it, summits are no contacts of their own.
module asperity_map_check
  use asperity_contact_records, only: state_row
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: int64, not_computed, real64
  use asperity_map_contact, only: closed_fully, closed_start, half_map, map_answer, press_map
  use asperity_map_despiking, only: limit_of_spikes
  use asperity_map_patches, only: find_patches, map_patch
  use asperity_map_scene, only: area_of_map, map_loading
  use asperity_map_shares, only: find_shares
  use asperity_map_summits, only: map_summits
  use asperity_numeral, only: read_numeral
  use asperity_scene_results, only: map_record
  use asperity_scene_values, only: control_load, scene_loading
  implicit none
  private

  public :: a_little_more, hold_against_map, map_seen, see_map, stiffness_between

  !> A map as it is pressed beside its summits.
  type :: map_seen
    type(height_map) :: map        !! it, or coarser
    integer :: coarser = 1         !! samples in one of those, a side
    logical :: by_load = .true.    !! the scene gives loads, else levels
    real(real64) :: closed = closed_fully  !! what gaps are closed to, of the range of heights
    type(map_answer) :: answer     !! how it was pressed last
    !> Samples up to which it is pressed as it is: some seconds.
    integer(int64) :: most = 600000_int64
    !> Samples up to which a coarser one is: half a minute. At a quarter of the resolution what is
    !> claimed is 3.2 times the error in the middle, at an eighth 7 times (measured).
    integer(int64) :: most_coarser = 4500000_int64
  end type map_seen

  ! Share of the load by which a stiffness is measured.
  real(real64), parameter :: stiffness_step = 0.01_real64

  ! Share of the area from which on what touches hangs together across a rough surface, whatever
  ! its spectrum (Dapp, Luecke, Persson and Mueser, Phys. Rev. Lett. 108 (2012) 244301).
  real(real64), parameter :: percolation = 0.42_real64

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

  !> Presses a map as far as a scene does at last, and says whether its summits can stand for it.
  subroutine see_map(map, loading, seen, failure)
    type(height_map), intent(in) :: map                    !! levelled
    type(map_loading), intent(in) :: loading               !! how far it is pressed
    type(map_seen), intent(inout) :: seen                  !! nothing but who can end it; pressed
    character(len=:), allocatable, intent(out) :: failure  !! why they cannot, or it cannot be
    type(map_patch), allocatable :: patches(:)
    real(real64) :: last, share
    character(len=4) :: digits

    seen%by_load = loading%by_load
    seen%map = map
    do while (size(seen%map%height, kind=int64) > merge(seen%most, seen%most_coarser, &
                                                        seen%coarser == 1))
      seen%map = half_map(seen%map)
      seen%coarser = 2 * seen%coarser
      seen%closed = closed_start
    end do
    last = loading%values(size(loading%values))
    if (.not. seen%by_load) then
      seen%answer%level = last
      call press_map(seen%map, loading%modulus, seen%answer, tolerance=seen%closed)
    else if (last > 0.0_real64) then
      call press_map(seen%map, loading%modulus, seen%answer, last, seen%closed)
    end if
    if (allocated(seen%answer%failure)) &
      failure = 'the comparison with the pixels of the map: ' // seen%answer%failure
    if (allocated(failure) .or. .not. allocated(seen%answer%pressure)) return
    call find_patches(seen%map, seen%answer%pressure, patches)
    share = sum(patches%area) / area_of_map(seen%map)
    if (share > percolation) then
      write (digits, '(f4.2)') share
      failure = 'the contact area fraction is ' // digits // ', above the percolation ' // &
                'threshold 0.42: expected interaction = ''boundary'' or a smaller load'
    end if
  end subroutine see_map

  !> Holds the last state of the summits against the map at the same load.
  subroutine hold_against_map(map, seen, modulus, summits, state, stiffness, check, failure)
    type(height_map), intent(in) :: map         !! levelled
    type(map_seen), intent(inout) :: seen       !! it as it is pressed
    real(real64), intent(in) :: modulus         !! combined
    type(map_summits), intent(in) :: summits    !! of this map
    type(state_row), intent(in) :: state        !! of the summits, its load more than 0
    real(real64), intent(in) :: stiffness       !! of them: load over approach; or `not_computed`
    type(map_record), intent(out) :: check      !! how they compare
    character(len=:), allocatable, intent(out) :: failure  !! why not
    type(map_answer) :: at_level
    real(real64) :: beyond, bears, level

    check%summits = size(summits%x)
    check%coarser = seen%coarser
    check%rms_height = sqrt(sum(map%height**2, mask=is_measured(map%height)) / &
                            count(is_measured(map%height), kind=int64))
    associate (answer => seen%answer)
      ! By load the map has been solved to this load. Otherwise it is solved again, from its coarser
      ! levels: their results estimate the error of discretisation.
      if (.not. (seen%by_load .and. allocated(answer%pressure))) then
        if (allocated(answer%pressure)) deallocate (answer%pressure)
        call press_map(seen%map, modulus, answer, state%vertical_load, seen%closed)
      end if
      if (allocated(answer%failure)) then
        failure = 'beside its summits: ' // answer%failure
        return
      end if
      beyond = 0.0_real64
      if (seen%coarser > 1) call look_beyond(seen, beyond, check%uncertain)
      level = answer%level + beyond
      check%difference = (state%approach - level) / check%rms_height
      check%closing = maxval(map%height) - level
      call share_out(map, seen, summits, state%area, check)
      if (.not. seen%by_load) then
        at_level%pressure = answer%pressure
        at_level%interrupt = answer%interrupt
        bears = load_at(state%approach - beyond)
        if (bears > 0.0_real64) check%load_difference = state%vertical_load / bears - 1.0_real64
        if (bears > 0.0_real64 .and. seen%coarser > 1) &
          check%load_uncertain = load_at(state%approach - beyond - check%uncertain) / bears - &
                                 1.0_real64
      end if
      check%uncertain = check%uncertain / check%rms_height
      if (.not. stiffness > 0.0_real64) return
      call press_map(seen%map, modulus, answer, &
                     (1.0_real64 + stiffness_step) * state%vertical_load, seen%closed)
      if (allocated(answer%failure)) failure = 'beside its summits: ' // answer%failure
      check%stiffness_difference = stiffness * (level - beyond - answer%level) / &
                                   (stiffness_step * state%vertical_load) - 1.0_real64
    end associate

  contains

    ! What the map as it is pressed bears at a level.
    real(real64) function load_at(level) result(load)
      real(real64), intent(in) :: level

      at_level%level = level
      call press_map(seen%map, modulus, at_level, tolerance=seen%closed)
      load = at_level%load
    end function load_at

  end subroutine hold_against_map

  ! What the separation of all samples is above that of squares of them, by how it changes with the
  ! side of a square. Each halving may change it by half the change before, as a square's value
  ! differs from its samples by their slope times its side; by as much, were heights as rough at
  ! every size; or as the changes themselves change. The mean of the three, give or take half their
  ! range: on 36 made maps of 512 x 512 pressed at half resolution, 0.3 to 10 % contact, 0.002 rms
  ! heights off in the middle, 0.009 at most, and within what is given or taken in 34.
  pure subroutine look_beyond(seen, beyond, uncertain)
    type(map_seen), intent(in) :: seen            ! pressed by the load
    real(real64), intent(out) :: beyond, uncertain
    real(real64) :: change(2), may_be(3), halvings

    change = [seen%answer%level, seen%answer%coarser(1)] - seen%answer%coarser
    halvings = log(real(seen%coarser, real64)) / log(2.0_real64)
    may_be(1) = change(1) * (1.0_real64 - 1.0_real64 / seen%coarser)
    may_be(2) = change(1) * halvings
    may_be(3) = may_be(2) + (change(1) - change(2)) * 0.5_real64 * halvings * (halvings + 1)
    beyond = sum(may_be) / 3
    uncertain = 0.5_real64 * (maxval(may_be) - minval(may_be))
  end subroutine look_beyond

  ! Shares of the load that summits cannot stand for, and what their area is off by.
  subroutine share_out(map, seen, summits, area, check)
    type(height_map), intent(in) :: map
    type(map_seen), intent(in) :: seen
    type(map_summits), intent(in) :: summits
    real(real64), intent(in) :: area
    type(map_record), intent(inout) :: check
    type(map_patch), allocatable :: patches(:)
    integer, allocatable :: spot(:, :)
    logical, allocatable :: has_summit(:)
    integer :: i, j, k
    real(real64) :: first

    ! From the first sample to the middle of the first of those that are coarser.
    first = 0.5_real64 * (1.0_real64 - 1.0_real64 / seen%coarser)
    call find_patches(seen%map, seen%answer%pressure, patches, spot)
    if (seen%coarser == 1) check%area_difference = area / sum(patches%area) - 1.0_real64
    allocate (has_summit(0:size(patches)), source=.false.)
    do k = 1, size(summits%x)
      i = 1 + nint(summits%x(k) / seen%map%spacing(1) - first)
      j = 1 + nint(summits%y(k) / seen%map%spacing(2) - first)
      if (seen%map%periodic) then
        i = 1 + modulo(i - 1, seen%map%columns)
        j = 1 + modulo(j - 1, seen%map%rows)
      end if
      has_summit(spot(min(max(i, 1), seen%map%columns), min(max(j, 1), seen%map%rows))) = .true.
    end do
    call find_shares(map, seen%answer%pressure, patches, &
                     limit_of_spikes(map, seen%coarser), check%shares)
    check%shares%without_summit = sum(patches%load, mask=.not. has_summit(1:)) / sum(patches%load)
  end subroutine share_out

end module asperity_map_check
