!> Solves the positions of a scene with its effects.
!>
!> A position at which `auto` leaves out all effects has the result
!> of the solver without effects, byte for byte. The influence on the load is estimated for every
!> effect that is off.
module asperity_effect_solver
  use asperity_contact_effect, only: effect_box, effect_outcome
  use asperity_contact_field, only: fields_all, fields_none
  use asperity_contact_law, only: contact_law
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_records, only: position_result, solve_method
  use asperity_contact_state, only: contact_state, start_state
  use asperity_earlier_solutions, only: expected_compression
  use asperity_effect_choice, only: choose_effects
  use asperity_effect_list, only: list_effects, list_left_out
  use asperity_effect_names, only: effect_on, effect_words, known_effects, why_not_together
  use asperity_effect_position, only: position_run, run_position
  use asperity_effect_rows, only: add_nothing, add_without_effects, name_columns, of_compression
  use asperity_element_pressures, only: element_pressures
  use asperity_first_yield, only: yielding_body
  use asperity_hertz_law, only: hertz_law
  use asperity_isolated_contacts, only: empty_state, list_pairs, solve_position
  use asperity_kinds, only: int64, real64
  use asperity_placed_scene, only: placed_scene
  use asperity_plastic_surface, only: surface_index
  use asperity_position_solver, only: position_solver
  use asperity_scene_placing, only: place_scene
  use asperity_scene_results, only: effect_header
  use asperity_scene_values, only: effect_auto, is_load, is_vertical_load, scene
  use asperity_theory_warnings, only: add_warning, of_barred, of_excluded, of_off, take_worse, &
                                      theory_warning
  implicit none
  private

  public :: make_effect_solver

  !> Solver of a scene with effects.
  type, extends(position_solver) :: effect_solver
    private
    type(scene), pointer :: scene_in => null()
    type(placed_scene) :: placed
    logical :: isolated = .false.                ! no effect is simulated or estimated
    logical :: by_estimate = .false.             ! all effects may turn out to be negligible
    integer :: fields = fields_none              ! states whose pressures are kept
    logical :: remembers = .true.                ! a path, or effects other than interaction
    type(solve_method) :: method                 ! which pairs are listed
    type(effect_box), allocatable :: effects(:)  ! initial state for a position
    type(effect_box), allocatable :: left_out(:) ! effects that are off, to be estimated
  contains
    procedure :: solve => solve_with_effects  !! solves one position
  end type effect_solver

contains

  !> Makes the solver of a scene with its effects. `failure` is allocated when a number is out of
  !> range.
  subroutine make_effect_solver(scene_in, solver, header, failure, fields, method)
    type(scene), intent(in), target :: scene_in  !! scene, checked; must outlive the solver
    class(position_solver), allocatable, intent(out) :: solver
    type(effect_header), intent(out) :: header             !! columns of the effects
    character(len=:), allocatable, intent(out) :: failure  !! reason, when there is no solver
    !> States whose pressures on boundary elements are kept: `fields_last` ...; absent: none.
    integer, intent(in), optional :: fields
    !> Method without any effect, for the accuracy study; absent: with the effects of the scene.
    type(solve_method), intent(in), optional :: method
    type(effect_solver), allocatable :: new
    integer :: i

    allocate (new)
    new%scene_in => scene_in
    if (present(fields)) new%fields = fields
    if (present(method)) then
      new%isolated = .true.
      new%method = method
      allocate (new%effects(0), new%left_out(0))
    else
      call list_effects(scene_in, new%effects)
      call list_left_out(scene_in, new%left_out)
    end if
    call name_columns(new%effects, header)
    header%tolerance = scene_in%effects%number('tolerance')
    if (any(header%names == 'plasticity')) then
      header%plasticity_index = surface_index(scene_in)
      header%plastic_body = merge('upper', 'lower', yielding_body(scene_in) == 1)
    end if
    call place_scene(scene_in, new%placed, failure)
    if (allocated(failure)) return
    new%positions = scene_in%motion%positions
    new%states = max(1, scene_in%loading%points)
    if (allocated(scene_in%loading%path)) new%states = new%states * size(scene_in%loading%path)
    new%work = size(scene_in%upper%x) + size(scene_in%lower%x)
    if (.not. is_vertical_load(scene_in%loading%control)) new%loads_differ = header%tolerance
    new%by_estimate = .not. allocated(scene_in%loading%path) .and. &
                      all(header%names == 'interaction') .and. all(header%modes == effect_auto)
    new%remembers = allocated(scene_in%loading%path) .or. any(header%names /= 'interaction')
    new%method%keeps_first = allocated(scene_in%loading%path) .and. .not. new%isolated
    do i = 1, size(new%effects)
      new%method%reach = max(new%method%reach, new%effects(i)%effect%reach)
    end do
    ! Effects take long: threads are started for a few positions.
    if (size(new%effects) > 0) new%work = huge(new%work)
    call move_alloc(new, solver)
  end subroutine make_effect_solver

  ! Solves one position, without effects where none is simulated.
  subroutine solve_with_effects(self, m, keep_rows, result, failure)
    class(effect_solver), intent(in) :: self
    integer, intent(in) :: m
    logical, intent(in) :: keep_rows
    type(position_result), intent(out) :: result
    character(len=:), allocatable, intent(out) :: failure
    type(contact_pairs) :: pairs
    type(position_result) :: columns
    type(effect_box), allocatable :: effects(:)
    type(position_run) :: run
    type(element_pressures), target :: pressures

    if (self%isolated) then
      call solve_position(self%placed, m, self%method, keep_rows, result, failure)
      return
    end if
    if (self%by_estimate) then
      call solve_without(self, m, keep_rows, result, run%simulated, failure)
      if (allocated(failure) .or. .not. run%simulated) return
    end if
    call list_pairs(self%placed, m, .false., pairs, failure, self%method)
    if (allocated(failure)) return
    call take_start()
    if (expected_compression(pairs) > pairs%complete_to) then
      call list_pairs(self%placed, m, .true., pairs, failure, self%method)
      if (allocated(failure)) return
    end if
    if (size(pairs%list) == 0) then
      result = position_result()
      call copy_effects(self%effects, effects)
      call add_nothing(pairs, effects, result)
      result%x_displacement = pairs%x_displacement
      result%y_displacement = pairs%y_displacement
      call empty_state(self%placed, result, failure)
      if (.not. allocated(failure)) call estimate_left_out(self, pairs, run%law, result)
      return
    end if
    call run_effects()
    if (run%too_far) then
      call self%progress_count%add_work(-result%counted)
      ! Pairs beyond the candidate distance may touch: all that can touch are listed.
      call list_pairs(self%placed, m, .true., pairs, failure, self%method)
      if (.not. allocated(failure)) call run_effects()
    end if
    if (allocated(failure)) return
    if (.not. run%simulated) then
      columns = result
      call solve_position(self%placed, m, solve_method(), keep_rows, result, failure)
      if (allocated(failure)) return
      call move_values(columns, result)
    end if
    call estimate_left_out(self, pairs, run%law, result)

  contains

    ! Takes the solution of an earlier run, where effects have no memory.
    subroutine take_start()
      if (self%remembers) return
      pairs%keeps_solution = self%reuse%keeps
      if (.not. associated(self%reuse%earlier)) return
      if (m <= size(self%reuse%earlier)) pairs%start => self%reuse%earlier(m)
    end subroutine take_start

    ! Computes the position with a copy of the effects.
    subroutine run_effects()
      call copy_effects(self%effects, effects)
      pairs%interrupt = self%interrupt
      pairs%progress_count = self%progress_count
      if (self%fields /= fields_none) then
        pressures%of_all_states = self%fields == fields_all
        pairs%pressures => pressures
      end if
      call take_start()
      run%keep_rows = keep_rows
      call run_position(self%scene_in, pairs, effects, result, run, failure)
    end subroutine run_effects

  end subroutine solve_with_effects

  ! Solves one position without effects, unless one is to be simulated in one of its states.
  subroutine solve_without(self, m, keep_rows, result, called_for, failure)
    class(effect_solver), intent(in) :: self
    integer, intent(in) :: m
    logical, intent(in) :: keep_rows
    type(position_result), intent(out) :: result
    logical, intent(out) :: called_for
    character(len=:), allocatable, intent(out) :: failure
    type(contact_pairs) :: pairs
    type(position_result) :: columns
    type(effect_box), allocatable :: effects(:)
    type(contact_state) :: state
    type(effect_outcome), allocatable :: outcomes(:)
    class(contact_law), allocatable :: law
    logical, allocatable :: called(:)
    real(real64) :: left
    integer :: i

    called_for = .false.
    call solve_position(self%placed, m, solve_method(), keep_rows, result, failure, pairs)
    if (allocated(failure)) return
    if (size(self%effects) > 0) then
      call copy_effects(self%effects, effects)
      allocate (columns%states(size(result%states)))
      if (size(pairs%list) == 0) call add_nothing(pairs, effects, columns)
      ! The last state comes first: most effects are simulated there.
      do i = size(result%states), 1, -1
        if (size(pairs%list) == 0) exit
        call choose_in(i)
        called_for = any(called)
        if (called_for) return
      end do
      do i = 1, size(result%states)
        if (size(pairs%list) == 0) exit
        if (size(result%states) > 1) call choose_in(i)
        call add_without_effects(self%scene_in, pairs, effects, state, outcomes, i, keep_rows, &
                                 columns)
      end do
      call move_values(columns, result)
    end if
    call estimate_left_out(self, pairs, law, result)

  contains

    ! Chooses the effects of a state.
    subroutine choose_in(number)
      integer, intent(in) :: number

      if (allocated(outcomes)) deallocate (outcomes)
      allocate (outcomes(size(effects)))
      call start_state(pairs, hertz_law(modulus=pairs%modulus), &
                       scale(result%states(number)%closing, -4 * pairs%length_power), state)
      call choose_effects(pairs, effects, state, outcomes, called, left)
    end subroutine choose_in

  end subroutine solve_without

  ! Moves the results of the effects to a position that was solved without them.
  subroutine move_values(columns, result)
    type(position_result), intent(inout) :: columns, result

    result%counted = columns%counted
    call move_alloc(columns%effects, result%effects)
    call move_alloc(columns%contact_values, result%contact_values)
    call move_alloc(columns%state_values, result%state_values)
    result%error_estimate = columns%error_estimate
  end subroutine move_values

  ! Estimates the influence of every effect that is off, in the state of the largest compression.
  subroutine estimate_left_out(self, pairs, law, result)
    class(effect_solver), intent(in) :: self
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), allocatable, intent(inout) :: law  ! contact law there; not allocated: Hertz
    type(position_result), intent(inout) :: result
    type(effect_box), allocatable :: effects(:)
    type(contact_state) :: state
    type(theory_warning), allocatable :: warnings(:)
    real(real64) :: share
    integer :: deepest, i, warned

    if (size(self%left_out) == 0) return
    result%error_estimate = max(result%error_estimate, 0.0_real64)
    call copy_effects(self%left_out, effects)
    if (.not. allocated(law)) allocate (law, source=hertz_law(modulus=pairs%modulus))
    deepest = maxloc(result%states%closing, 1)
    call start_state(pairs, law, scale(result%states(deepest)%closing, -4 * pairs%length_power), &
                     state)
    do i = 1, size(effects)
      associate (effect => effects(i)%effect, effects_of_scene => self%scene_in%effects)
        call effect%begin(pairs)
        share = 0.0_real64
        if (size(pairs%list) > 0) share = effect%estimate(pairs, state)
        result%left_out(findloc(known_effects%name, effect%name, 1)) = share
        result%error_estimate = result%error_estimate + &
          merge(of_compression, 1.0_real64, is_load(self%scene_in%loading%control)) * share
        if (.not. share > effect%tolerance) cycle
        warned = merge(of_excluded, of_off, is_ruled_out(self, effect%name))
        if (effects_of_scene%is_barred(effect%name)) warned = of_barred
        call add_warning(warnings, warned, share, whose=effect%name)
      end associate
    end do
    call take_worse(result%warnings, warnings, deepest)
  end subroutine estimate_left_out

  ! Whether an effect has no common theory with one that is on, or `auto`.
  logical function is_ruled_out(self, name)
    class(effect_solver), intent(in) :: self
    character(len=*), intent(in) :: name
    integer :: i

    is_ruled_out = .false.
    do i = 1, size(self%effects)
      associate (effect => self%effects(i)%effect)
        is_ruled_out = is_ruled_out .or. why_not_together(trim(name), 'on', trim(effect%name), &
          trim(effect_words(merge(effect_on, effect%mode, effect%mode == effect_auto)))) /= ''
      end associate
    end do
  end function is_ruled_out

  ! Copies effects, which keep a memory during a position.
  subroutine copy_effects(from, effects)
    type(effect_box), intent(in) :: from(:)
    type(effect_box), allocatable, intent(out) :: effects(:)
    integer :: i

    allocate (effects(size(from)))
    do i = 1, size(effects)
      allocate (effects(i)%effect, source=from(i)%effect)
    end do
  end subroutine copy_effects

end module asperity_effect_solver
