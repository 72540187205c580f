!> Tests of the interface of effects: one that no release has, run through a position with the
!> others.
!>
!> Truths are its own closed forms over the loads of Hertz.
module asperity_new_effect_suite
  use asperity_asperity_position, only: asperity_bodies, begin_asperities
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_records, only: position_result
  use asperity_contact_state, only: contact_state, start_state, total_load, total_vertical_load
  use asperity_effect_helpers, only: near, pair_of
  use asperity_effect_list, only: list_effects
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: not_computed, real64
  use asperity_made_up_effect, only: made_up_effect, make_up
  use asperity_position_path, only: follow_path
  use asperity_scene_values, only: control_separation, control_load, effect_auto, effect_on, scene
  use asperity_testing, only: check, has_failed, run_test
  use asperity_work_count, only: work_count
  implicit none
  private

  public :: run_new_effect

  ! Factors, shares and what follows from them.
  real(real64), parameter :: rounding = 1.0e-13_real64
  ! A load asked for is met within 1e-11.
  real(real64), parameter :: met = 1.0e-10_real64

  ! What a run of a position has beside its results.
  type :: position_run
    logical :: keep_rows = .true.
    logical :: simulated = .false.
    logical :: too_far = .false.
  end type position_run

  ! Displaces the second pair by neighbours whose load alternates, and attracts it across its gap.
  type, extends(made_up_effect) :: jumping_effect
    integer, pointer :: solves => null()  ! number of states
  contains
    procedure :: apply => apply_jumping
  end type jumping_effect

contains

  !> Runs the tests.
  subroutine run_new_effect
    call run_test('columns, units and influence, before another effect', columns)
    call run_test('auto: estimate, left out, called for', by_auto)
    call run_test('states are kept, and forgotten with the position', states_kept)
    call run_test('a load is met with an effect that knows no short way to it', to_loads)
    call run_test('a first contact is found within the jump of the displacement', jumps)
  end subroutine run_new_effect

  ! Follows the path of a position with its effects.
  subroutine run_position(scene_in, pairs, effects, result, run, failure)
    type(scene), intent(in), target :: scene_in
    type(contact_pairs), intent(in) :: pairs
    type(effect_box), intent(in) :: effects(:)
    type(position_result), intent(out) :: result
    type(position_run), intent(inout) :: run
    character(len=:), allocatable, intent(out) :: failure
    type(asperity_bodies), target :: bodies
    integer :: i

    bodies%scene_in => scene_in
    bodies%pairs = pairs
    allocate (bodies%effects(size(effects)), bodies%left_out(0))
    do i = 1, size(effects)
      allocate (bodies%effects(i)%effect, source=effects(i)%effect)
    end do
    call begin_asperities(bodies)
    bodies%keep_rows = run%keep_rows
    call follow_path(bodies, work_count(), result, run%too_far, failure)
    run%simulated = bodies%simulated
  end subroutine run_position

  ! In front of friction, which finds its loads.
  subroutine columns
    type(effect_box), allocatable :: listed(:)
    type(effect_box) :: effects(2)
    type(scene) :: scene_in
    type(contact_pairs) :: pairs
    type(contact_state) :: hertz
    type(position_result) :: result
    type(position_run) :: run
    character(len=:), allocatable :: failure
    ! The unit of force is 1/16 of the scene's, that of length 1/16, too.
    real(real64), parameter :: unit = 0.0625_real64
    integer :: i

    call two_pairs(pairs, hertz)
    call scene_in%effects%call_for('friction', effect_on)
    call scene_in%effects%set('friction_coefficient', 0.1_real64)
    scene_in%upper%elastic_modulus = 1.0_real64
    scene_in%lower%elastic_modulus = 1.0_real64
    scene_in%loading%control = control_separation
    call list_effects(scene_in, listed)
    call make_up(effect_on, 0.25_real64, 0.0_real64, effects(1)%effect)
    call move_alloc(listed(1)%effect, effects(2)%effect)
    call run_position(scene_in, pairs, effects, result, run, failure)
    call check(run%simulated .and. .not. run%too_far .and. .not. allocated(failure), 'simulated')
    if (has_failed()) return
    call check(result%rows_used, 2, 'contacts')
    do i = 1, 2
      call near(result%contact_values(i, 1), 0.25_real64 * unit * hertz%answers(i)%load, &
                rounding, 'its first column')
      call near(result%contact_values(i, 2), unit * hertz%penetration(i), rounding, &
                'its second column')
      call near(result%rows(i)%load, 1.25_real64 * unit * hertz%answers(i)%load, rounding, 'load')
    end do
    call near(result%state_values(1), unit * total_vertical_load(hertz), rounding, 'sum')
    call check(nint(result%state_values(2)), 0, 'nothing was kept before')
    call near(result%state_values(3), 1.25_real64 * unit * total_vertical_load(hertz), &
              rounding, 'what friction finds')
    call check(trim(result%effects(1)%simulated), 'on', 'how')
    call near(result%effects(1)%influence, 0.25_real64, rounding, 'its influence')
    call near(result%effects(2)%influence, result%states(1)%vertical_load / &
              result%state_values(3) - 1.0_real64, 1.0e-9_real64, 'that of friction')
    call check(result%effects(2)%influence > 0.01_real64, 'friction acts')
  end subroutine columns

  subroutine by_auto
    type(contact_pairs) :: pairs
    type(contact_state) :: hertz
    type(position_result) :: result
    logical :: simulated
    integer :: i

    call two_pairs(pairs, hertz)
    do i = 1, 2
      call run_one(pairs, effect_auto, 0.02_real64 * i, 0.03_real64, by_approach(), &
                   result, simulated)
      if (has_failed()) return
      call check(simulated .eqv. i == 2, 'called for')
      call near(result%effects(1)%estimate, 0.02_real64 * i, rounding, 'estimate')
      call check(trim(result%effects(1)%simulated), trim(merge('off', 'on ', i == 1)), 'how')
      call check(trim(result%effects(1)%why), &
                 trim(merge('                        ', 'estimate above tolerance', i == 1)), 'why')
      call near(result%states(1)%vertical_load * 16.0_real64, &
                total_vertical_load(hertz) * merge(1.0_real64, 1.04_real64, i == 1), rounding, &
                'load')
      ! Left out, a column is not computed.
      if (i == 1) then
        call check(.not. any(result%state_values > not_computed), 'columns left out')
        cycle
      end if
      call near(result%state_values(1) * 16.0_real64, total_vertical_load(hertz), rounding, &
                'the load without it')
      call check(nint(result%state_values(2)), 0, 'the other column')
    end do
  end subroutine by_auto

  ! Compressions 0.05, 0.02 and 0.05 again; the next position has nothing of them.
  subroutine states_kept
    type(effect_box) :: effects(1)
    type(contact_pairs) :: pairs
    type(contact_state) :: hertz, less
    type(position_result) :: result
    type(scene) :: scene_in
    type(position_run) :: run
    character(len=:), allocatable :: failure
    integer :: i, turn

    call two_pairs(pairs, hertz)
    call start_state(pairs, hertz_law(modulus=pairs%modulus), 0.02_real64, less)
    scene_in%loading%control = control_separation
    ! The first touch is at 1, in units of 1/16.
    allocate (scene_in%loading%path(3))
    do i = 1, 3
      scene_in%loading%path(i) = (1.0_real64 - merge(0.02_real64, 0.05_real64, i == 2)) / &
                                   16.0_real64
    end do
    call make_up(effect_on, 0.1_real64, 0.0_real64, effects(1)%effect)
    do turn = 1, 2
      run%keep_rows = .false.
      call run_position(scene_in, pairs, effects, result, run, failure)
      call check(run%simulated .and. .not. allocated(failure), 'simulated')
      call check(size(result%states), 3, 'states')
      if (has_failed()) return
      do i = 1, 3
        call near(result%states(i)%load * 16.0_real64, (1.0_real64 + 0.1_real64 * i) * &
                  merge(total_load(less), total_load(hertz), i == 2), rounding * 100, 'load')
      end do
      call check(nint(result%state_values(2)), 2, 'states kept before the last')
    end do
  end subroutine states_kept

  subroutine to_loads
    type(contact_pairs) :: pairs
    type(contact_state) :: hertz
    type(position_result) :: result
    type(scene) :: scene_in
    logical :: simulated
    integer :: i

    call two_pairs(pairs, hertz)
    scene_in%loading%control = control_load
    allocate (scene_in%loading%path(2))
    do i = 1, 2
      scene_in%loading%path(i) = total_load(hertz) / 16.0_real64
    end do
    call run_one(pairs, effect_on, 0.1_real64, 0.0_real64, scene_in, result, simulated)
    if (has_failed()) return
    do i = 1, 2
      call near(result%states(i)%load * 16.0_real64, total_load(hertz), met, 'load')
    end do
    ! The same load with a larger share needs less compression.
    call check(result%states(2)%compression < result%states(1)%compression, 'compression')
    call check(result%states(1)%compression < 0.05_real64 / 16.0_real64, 'below that of Hertz')
  end subroutine to_loads

  ! The second pair begins where compression - 0.4 compression (1 -+ jump) is its gap of 0.01.
  subroutine jumps
    type(effect_box) :: effects(1)
    type(jumping_effect) :: effect
    type(contact_pairs) :: pairs
    type(contact_state) :: hertz
    type(position_result) :: result
    type(position_run) :: run
    type(scene) :: scene_in
    character(len=:), allocatable :: failure
    integer, target :: solves

    call two_pairs(pairs, hertz)
    scene_in = by_approach()
    call scene_in%effects%call_for('interaction', effect_on)
    scene_in%loading%events = .true.
    solves = 0
    effect%mode = effect_on
    effect%solves => solves
    allocate (effects(1)%effect, source=effect)
    call run_position(scene_in, pairs, effects, result, run, failure)
    call check(size(result%states), 3, 'first touch, first contact, last state')
    if (has_failed()) return
    call near(result%states(2)%compression, 0.01_real64 / 0.6_real64 / 16.0_real64, &
              1.0e-4_real64, 'the first contact')
    ! Halvings of 0.05 to 1e-4 of a displacement of 0.0067: 17; to 1e-10 of the last state: 34.
    call check(solves < 25, 'states of the search')
  end subroutine jumps

  subroutine apply_jumping(self, pairs, state, outcome)
    class(jumping_effect), intent(in) :: self
    type(contact_pairs), intent(in) :: pairs
    type(contact_state), intent(inout) :: state
    type(effect_outcome), intent(inout) :: outcome
    real(real64), parameter :: jump = 1.0e-4_real64

    self%solves = self%solves + 1
    call self%leave_out(pairs, state, outcome)
    outcome%simulated = 'on'
    outcome%load_jump = jump
    state%penetration(2) = state%compression - pairs%list(2)%gap - &
                           0.4_real64 * state%compression * &
                           (1.0_real64 + jump * (modulo(self%solves, 2) - 0.5_real64))
    if (state%penetration(2) < 0.0_real64) state%answers(2)%load = -1.0e-9_real64
  end subroutine apply_jumping

  ! A position with the made-up effect alone.
  subroutine run_one(pairs, mode, share, tolerance, scene_in, result, simulated)
    type(contact_pairs), intent(in) :: pairs
    integer, intent(in) :: mode
    real(real64), intent(in) :: share, tolerance
    type(scene), intent(in) :: scene_in
    type(position_result), intent(out) :: result
    logical, intent(out) :: simulated
    type(effect_box) :: effects(1)
    type(position_run) :: run
    character(len=:), allocatable :: failure

    call make_up(mode, share, tolerance, effects(1)%effect)
    call run_position(scene_in, pairs, effects, result, run, failure)
    simulated = run%simulated
    call check(.not. (run%too_far .or. allocated(failure)), 'a position with the effect alone')
  end subroutine run_one

  ! A scene that ends where independent contacts do.
  function by_approach() result(scene_in)
    type(scene) :: scene_in

    scene_in%loading%control = control_separation
  end function by_approach

  ! Two inclined pairs in units of their own, and their loads by Hertz at the end.
  subroutine two_pairs(pairs, hertz)
    type(contact_pairs), intent(out) :: pairs
    type(contact_state), intent(out) :: hertz

    pairs%modulus = 0.5_real64
    pairs%modulus_power = 4
    pairs%length_power = -4
    pairs%first_touch = 1.0_real64
    pairs%complete_to = 1.0_real64
    pairs%compression = 0.05_real64
    allocate (pairs%list(2))
    pairs%list = [pair_of(1.0_real64, 1.0_real64, 0.5_real64), &
                  pair_of(1.0_real64, 2.0_real64, 0.9_real64)]
    pairs%list(2)%gap = 0.01_real64
    pairs%list(2)%x = 5.0_real64
    call start_state(pairs, hertz_law(modulus=pairs%modulus), pairs%compression, hertz)
  end subroutine two_pairs

end module asperity_new_effect_suite
