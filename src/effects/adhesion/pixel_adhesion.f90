!> Adhesion on the pixels of a height map, as an effect of a scene.
!>
!> Estimate, from the gaps g of a solution without adhesion: the attraction s(g) of the open pixels
!> pulls with S0, the sum of s(g) over them. It lowers the flat by at most S0 c/P under a prescribed
!> load P, where c is the compression, as the load is a convex function of the compression; and it
!> draws pixels together by the displacements A s. The gaps are then smaller by d, and the pull is
!> S0 exp(y) with y = ln(sum of s(g - d)/S0). For the exponential law and equal d the pull S with
!> the displacements that belong to it solves
!>
!>     S = S0 exp(y S/S0),
!>
!> which has a solution for y <= 1/e; beyond it surfaces jump together, and there is no estimate.
!> Pixels with g < d S/S0 close. In a solid the contact gives way to less than this: both are
!> upper bounds while they are small (test: test/effects/test_left_out.py).
module asperity_pixel_adhesion
  use asperity_attraction_law, only: attraction_at, attraction_law, new_attraction, pixel_steepness
  use asperity_contact_effect, only: relative_influence
  use asperity_effect_header, only: column_list, force, plain
  use asperity_height_map, only: is_measured
  use asperity_kinds, only: int64, real64
  use asperity_map_adhesion, only: adhere_map, adhesion_history, find_pull_off, work_at_edge
  use asperity_map_contact, only: displacement_by
  use asperity_pixel_law, only: pixel_law, pixel_state, unknown_influence
  use asperity_problems, only: real_text
  use asperity_scene_values, only: combined_modulus, scene
  use asperity_theory_warnings, only: add_warning, of_attraction, of_cut_range, of_held_gap, &
                                      theory_warning
  implicit none
  private

  public :: new_pixel_adhesion

  ! Steepness of the attraction without a warning, and the largest (measured on a ball: up to 1.0
  ! states of open and of adhering surfaces agree to 1e-8 pi w R, at 1.2 they differ by 1e-2; test:
  ! wide pixels in test/maps/test_adhesive_pixels.py).
  real(real64), parameter :: resolved_steepness = 0.7_real64, steepest = 1.2_real64

  !> Adhesion with one attraction for all pixels.
  type, extends(pixel_law) :: pixel_adhesion
    type(attraction_law) :: attraction          !! across the gap; its work is more than 0
    real(real64) :: steepness = 0.0_real64      !! of the attraction over a pixel
    type(adhesion_history) :: history           !! of the last state
  contains
    procedure :: estimate => estimate_adhesion
    procedure :: add_columns => add_adhesion_columns
    procedure :: act => adhere_state
    procedure :: add_warnings => warn_of_adhesion
    procedure :: coarsen => coarsen_adhesion
    procedure :: why_unknown
  end type pixel_adhesion

contains

  !> Makes the law of a scene. It has an obstacle where the pixels are too wide for the attraction.
  subroutine new_pixel_adhesion(scene_in, pixel, law)
    type(scene), intent(in) :: scene_in                !! scene with checked values
    real(real64), intent(in) :: pixel                  !! largest spacing of the pixels [length]
    class(pixel_law), allocatable, intent(out) :: law  !! law without history
    type(pixel_adhesion) :: new

    if (scene_in%effects%number('work_of_adhesion') > 0.0_real64) then
      new%solves = .true.
      new%attraction = new_attraction(scene_in)
      new%steepness = pixel_steepness(new%attraction, pixel, combined_modulus(scene_in))
      if (new%steepness > steepest) &
        new%obstacle = 'the pixels are too wide for the range of adhesion: found a spacing of ' // &
                       real_text(pixel) // ', expected at most ' // &
                       real_text(pixel * resolved_steepness / new%steepness) // &
                       ', or a larger equilibrium_distance'
    end if
    call new%call_as('adhesion', scene_in%effects)
    allocate (law, source=new)
  end subroutine new_pixel_adhesion

  !> Pull of the open gaps over the load, or the pixels that close by it over those in contact.
  function estimate_adhesion(self, state) result(share)
    class(pixel_adhesion), intent(in) :: self  !! law with its parameters
    type(pixel_state), intent(in) :: state     !! solution without adhesion
    real(real64) :: share
    real(real64), allocatable, dimension(:, :) :: closer, gap, pull
    logical, allocatable :: is_open(:, :)
    real(real64) :: begin, growth, load, lowered, rate, total
    integer(int64) :: closed
    integer :: turn
    integer, parameter :: turns = 60  ! S/S0 to a rounding error below y = 0.36 (derived: y S < 1)
    ! Displacement of the middle of a square by a uniform traction, over the side and the traction
    ! over the modulus (derived: Love 1929).
    real(real64), parameter :: of_square = 1.1221997046783603_real64

    share = 0.0_real64
    if (.not. self%solves) return
    share = unknown_influence
    load = merge(state%answer%load, state%largest_load, state%answer%load > 0.0_real64)
    associate (map => state%deformed, answer => state%answer)
      allocate (is_open(map%columns, map%rows), &
                source=is_measured(map%height) .and. .not. answer%pressure > 0.0_real64)
      allocate (gap(map%columns, map%rows), source=0.0_real64)
      where (is_open) gap = answer%level - map%height + answer%displacement
      allocate (pull(map%columns, map%rows), &
                source=merge(attraction_at(self%attraction, gap), 0.0_real64, is_open))
      begin = sum(pull) * product(map%pixel_spacing)
      if (.not. begin > 0.0_real64) share = 0.0_real64
      if (.not. (begin > 0.0_real64 .and. load > 0.0_real64)) return
      lowered = 0.0_real64
      if (allocated(state%load)) &
        lowered = begin / load * max(0.0_real64, maxval(map%height) - answer%level)
      ! The largest pull on all of a square moves its middle by no less than A s.
      allocate (closer, mold=gap)
      closer = lowered + of_square * maxval(pull) / state%modulus * &
                         maxval(map%pixel_spacing * shape(map%height))
      call follow_pull()
      if (share <= self%tolerance) return
      closer = lowered + displacement_by(map, state%modulus, pull)
      call follow_pull()
    end associate

  contains

    ! Estimates the influence by a displacement of each pixel.
    subroutine follow_pull()
      total = sum(attraction_at(self%attraction, gap - max(0.0_real64, closer)), is_open) * &
              product(state%deformed%pixel_spacing)
      share = unknown_influence
      rate = log(total / begin)
      if (rate > exp(-1.0_real64)) return
      growth = 1.0_real64
      do turn = 1, turns
        growth = exp(rate * growth)
      end do
      share = relative_influence(growth * begin, load, load - growth * begin)
      closed = count(is_open .and. gap < growth * closer, kind=int64)
      share = max(share, real(closed, real64) / &
                  max(1_int64, closed + count(state%answer%pressure > 0.0_real64, kind=int64)))
    end subroutine follow_pull

  end function estimate_adhesion

  !> Adds the patches that adhere and those in tension, and the pull of the open gaps.
  subroutine add_adhesion_columns(self, state, columns)
    class(pixel_adhesion), intent(in) :: self
    type(pixel_state), intent(in) :: state
    type(column_list), intent(inout) :: columns

    associate (unused => self, patches => state%patches)
      call columns%add('adhering_contacts', plain, real(size(patches), real64))
      call columns%add('pulling_contacts', plain, &
                       real(count(patches%load < 0.0_real64), real64))
      call columns%add('gap_attraction', force, &
                       max(0.0_real64, sum(patches%load) - state%answer%load))
    end associate
  end subroutine add_adhesion_columns

  !> Solves a state with adhesion. A load that is not carried is a failure with the largest one.
  subroutine adhere_state(self, state)
    class(pixel_adhesion), intent(inout) :: self
    type(pixel_state), intent(inout) :: state
    type(adhesion_history) :: before
    real(real64) :: carried
    logical :: begins_open

    associate (map => state%problem_map, modulus => state%problem_modulus, &
               law => self%attraction, history => self%history, answer => state%answer)
      begins_open = .not. allocated(history%attraction)
      carried = answer%load
      before = history
      call adhere_map(map, modulus, law, history, answer, state%load, state%hardness, &
                      state%tolerance)
      if (allocated(answer%failure)) return
      answer%contact_pressure = history%contact_pressure
      answer%attraction = attraction_at(law, 0.0_real64)
      if (.not. (allocated(state%load) .and. history%is_separated)) return
      ! From open surfaces the first state is that at first touch.
      if (begins_open) then
        answer%level = maxval(map%height)
        call adhere_map(map, modulus, law, before, answer, hardness=state%hardness)
        carried = answer%load
      end if
      if (.not. allocated(answer%failure)) call find_pull_off(map, modulus, law, before, answer, &
                                                    carried, state%load, state%hardness)
      if (allocated(answer%failure)) return
      answer%failure = 'the pull is larger than the contacts carry: ' // real_text(-carried) // &
                       ' at most, a nominal pressure of ' // real_text(-carried / &
                       (count(is_measured(map%height), kind=int64) * product(map%pixel_spacing)))
      if (begins_open) answer%failure = answer%failure // ' from first contact; after loading ' // &
                       'they may carry more: expected a path, value = LOAD, PULL'
    end associate
  end subroutine adhere_state

  !> Warns of pixels that are wide for the attraction, of a mean gap that is held, and of a map that
  !> ends within the attraction.
  subroutine warn_of_adhesion(self, state, warnings)
    class(pixel_adhesion), intent(in) :: self
    type(pixel_state), intent(in) :: state
    type(theory_warning), allocatable, intent(inout) :: warnings(:)
    real(real64) :: cut

    if (self%steepness > resolved_steepness) &
      call add_warning(warnings, of_attraction, self%steepness / resolved_steepness)
    if (.not. self%solves) return
    if (state%deformed%periodic .and. state%number > 1 .and. .not. allocated(state%load)) &
      call add_warning(warnings, of_held_gap, real(state%number, real64))
    cut = work_at_edge(state%deformed, self%attraction, self%history%attraction)
    if (cut > self%tolerance) call add_warning(warnings, of_cut_range, cut)
  end subroutine warn_of_adhesion

  !> Keeps the attraction of every second pixel.
  subroutine coarsen_adhesion(self, columns, rows, state)
    class(pixel_adhesion), intent(inout) :: self
    integer, intent(in) :: columns(:), rows(:)
    type(pixel_state), intent(inout) :: state

    associate (unused => state)
    end associate
    if (.not. self%solves) return
    self%history%attraction = self%history%attraction(columns, rows)
    self%history%contact_pressure = self%history%contact_pressure(columns, rows)
  end subroutine coarsen_adhesion

  !> Pixels twice as wide must resolve the attraction and carry the load: not a pull that is
  !> prescribed.
  function why_unknown(self, state, is_alone) result(reason)
    class(pixel_adhesion), intent(in) :: self
    type(pixel_state), intent(in) :: state
    logical, intent(in) :: is_alone
    character(len=48) :: reason

    associate (unused => is_alone)
    end associate
    reason = ''
    if (.not. self%solves) return
    if (2.0_real64 * self%steepness > steepest) reason = 'adhesion on pixels twice as wide'
    if (allocated(state%load) .and. .not. state%answer%load > 0.0_real64) &
      reason = 'adhesion that carries the load'
  end function why_unknown

end module asperity_pixel_adhesion
