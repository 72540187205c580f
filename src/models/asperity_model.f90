!> Two bodies with spherical asperities, and their effects.
!>
!> A position at which `auto` leaves out all effects has the result
!> of the solver without effects, byte for byte. The influence on the load is estimated for every
!> effect that is off.
module asperity_asperity_model
  use asperity_asperity_position, only: asperity_bodies, begin_asperities, estimate_shares
  use asperity_asperity_records, only: add_nothing, add_without_effects, error_of_share, &
                                       name_effects
  use asperity_contact_effect, only: effect_box
  use asperity_contact_field, only: fields_all, fields_none
  use asperity_contact_model, only: contact_model, path_step, placed_bodies
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_records, only: position_result, prescribed_nothing, solve_method
  use asperity_contact_state, only: contact_state, start_state
  use asperity_effect_list, only: list_effects, list_left_out
  use asperity_effect_names, only: effect_on, effect_words, go_together, known_effects, &
                                   of_plasticity
  use asperity_effect_sequence, only: choose_effects, effect_choice
  use asperity_element_pressures, only: element_pressures
  use asperity_first_yield, only: yielding_body
  use asperity_hertz_law, only: hertz_law
  use asperity_isolated_contacts, only: empty_state, list_pairs, solve_position
  use asperity_kinds, only: real64
  use asperity_placed_scene, only: placed_scene
  use asperity_plastic_surface, only: surface_index
  use asperity_scene_placing, only: place_scene
  use asperity_effect_header, only: effect_header
  use asperity_scene_values, only: effect_auto, is_load, scene
  use asperity_theory_warnings, only: add_warning, of_barred, of_excluded, of_off, take_worse, &
                                      theory_warning
  implicit none
  private

  public :: make_asperity_model

  !> Asperities with the effects of a scene.
  type, extends(contact_model) :: asperity_model
    private
    type(scene), pointer :: scene_in => null()
    type(placed_scene) :: placed
    logical :: isolated = .false.                ! no effect is simulated or estimated
    logical :: by_estimate = .false.             ! all effects may turn out to be negligible
    integer :: fields = fields_none              ! states whose pressures are kept
    type(solve_method) :: method                 ! which pairs are listed
    type(effect_box), allocatable :: effects(:)  ! initial state for a position
    type(effect_box), allocatable :: left_out(:) ! effects that are off, to be estimated
  contains
    procedure :: place => place_asperities  !! places the asperities at a position
  end type asperity_model

  ! Asperities at one position, with the model that placed them.
  type, extends(asperity_bodies) :: placed_asperities
    class(asperity_model), pointer :: model => null()
    integer :: m = 0                                         ! position
    type(element_pressures), pointer :: pressures => null()  ! on boundary elements, where kept
  contains
    procedure :: add_totals => add_left_out
    final :: free_pressures
  end type placed_asperities

contains

  !> Makes the model of a scene with its effects. `failure` is allocated when a number is out of
  !> range.
  subroutine make_asperity_model(scene_in, model, header, failure, fields, method)
    type(scene), intent(in), target :: scene_in  !! scene, checked; must outlive the model
    class(contact_model), allocatable, intent(out) :: model
    type(effect_header), intent(out) :: header             !! columns of the effects
    character(len=:), allocatable, intent(out) :: failure  !! reason, when there is no model
    integer, intent(in) :: fields  !! states whose pressures on elements are kept: `fields_last` ...
    !> Method without any effect, for the accuracy study; absent: with the effects of the scene.
    type(solve_method), intent(in), optional :: method
    type(asperity_model), allocatable :: new
    integer :: i

    allocate (new)
    new%scene_in => scene_in
    new%fields = fields
    if (present(method)) then
      new%isolated = .true.
      new%method = method
      allocate (new%effects(0), new%left_out(0))
    else
      call list_effects(scene_in, new%effects)
      call list_left_out(scene_in, new%left_out)
    end if
    call name_effects(new%effects, header)
    header%tolerance = scene_in%effects%number('tolerance')
    if (any(header%names == known_effects(of_plasticity)%name)) then
      header%plasticity_index = surface_index(scene_in)
      header%plastic_body = merge('upper', 'lower', yielding_body(scene_in) == 1)
    end if
    call place_scene(scene_in, new%placed, failure)
    if (allocated(failure)) return
    new%positions = scene_in%motion%positions
    new%states = max(1, scene_in%loading%points)
    if (allocated(scene_in%loading%path)) new%states = new%states * size(scene_in%loading%path)
    new%work = size(scene_in%upper%x) + size(scene_in%lower%x)
    if (.not. scene_in%loading%control%is_vertical) new%loads_differ = header%tolerance
    new%by_estimate = .not. allocated(scene_in%loading%path) .and. &
                      all(header%modes == effect_auto) .and. .not. &
                      (is_load(scene_in%loading%control) .and. &
                       .not. scene_in%loading%value > 0.0_real64)
    new%method%keeps_first = allocated(scene_in%loading%path) .and. .not. new%isolated
    do i = 1, size(new%effects)
      new%method%reach = max(new%method%reach, new%effects(i)%effect%reach)
    end do
    ! Effects take long: threads are started for a few positions.
    if (size(new%effects) > 0) new%work = huge(new%work)
    call move_alloc(new, model)
  end subroutine make_asperity_model

  ! Places the asperities at a position. Where no effect is simulated the results are complete.
  subroutine place_asperities(self, m, is_repeat, bodies, result, failure)
    class(asperity_model), intent(in), target :: self
    integer, intent(in) :: m
    logical, intent(in) :: is_repeat
    class(placed_bodies), allocatable, intent(inout) :: bodies
    type(position_result), intent(out) :: result
    character(len=:), allocatable, intent(out) :: failure
    type(placed_asperities), allocatable :: placed
    real(real64) :: shares(size(self%left_out), 1)
    logical :: is_needed

    if (allocated(bodies)) deallocate (bodies)
    if (self%isolated) then
      call solve_position(self%placed, m, self%method, self%keep_rows, result, failure)
      return
    end if
    if (self%by_estimate .and. .not. is_repeat) then
      call solve_without(self, m, result, is_needed, failure)
      if (allocated(failure) .or. .not. is_needed) return
    end if
    allocate (placed)
    result = position_result()
    placed%model => self
    placed%m = m
    placed%scene_in => self%scene_in
    call list_pairs(self%placed, m, is_repeat, placed%pairs, failure, self%method)
    if (allocated(failure)) return
    call copy_effects(self%effects, placed%effects)
    call copy_effects(self%left_out, placed%left_out)
    result%x_displacement = placed%pairs%x_displacement
    result%y_displacement = placed%pairs%y_displacement
    if (size(placed%pairs%list) == 0) then
      call empty_state(self%placed, result, failure)
      if (allocated(failure)) return
      call add_nothing(self%scene_in, placed%pairs, placed%effects, result)
      shares = 0.0_real64
      call estimate_left_out(self, shares, result)
      return
    end if
    placed%pairs%interrupt = self%interrupt
    placed%pairs%progress_count = self%progress_count
    if (self%fields /= fields_none) then
      allocate (placed%pressures)
      placed%pressures%of_all_states = self%fields == fields_all
      placed%pairs%pressures => placed%pressures
    end if
    call begin_asperities(placed)
    call move_alloc(placed, bodies)
  end subroutine place_asperities

  ! Completes the results: by the solver without effects where none was simulated.
  subroutine add_left_out(self, steps, result, failure)
    class(placed_asperities), intent(inout), target :: self
    type(path_step), intent(in) :: steps(:)
    type(position_result), intent(inout) :: result
    character(len=:), allocatable, intent(out) :: failure
    type(position_result) :: columns

    call self%asperity_bodies%add_totals(steps, result, failure)
    if (allocated(failure)) return
    if (.not. self%simulated) then
      columns = result
      call solve_position(self%model%placed, self%m, solve_method(), self%keep_rows, result, &
                          failure)
      if (allocated(failure)) return
      call move_values(columns, result)
    end if
    call estimate_left_out(self%model, self%shares, result)
  end subroutine add_left_out

  ! Frees the pressures on boundary elements.
  impure elemental subroutine free_pressures(self)
    type(placed_asperities), intent(inout) :: self

    if (associated(self%pressures)) deallocate (self%pressures)
  end subroutine free_pressures

  ! Solves one position without effects, unless one is to be simulated in one of its states.
  subroutine solve_without(self, m, result, is_needed, failure)
    class(asperity_model), intent(in) :: self
    integer, intent(in) :: m
    type(position_result), intent(out) :: result
    logical, intent(out) :: is_needed  ! an effect is to be simulated
    character(len=:), allocatable, intent(out) :: failure
    type(contact_pairs) :: pairs
    type(position_result) :: columns
    type(effect_box), allocatable :: effects(:)
    type(contact_state) :: state
    type(effect_choice), allocatable :: choices(:)
    real(real64), allocatable :: shares(:, :)
    integer :: i, number

    is_needed = .false.
    call solve_position(self%placed, m, solve_method(reach=self%method%reach), self%keep_rows, &
                        result, failure, pairs)
    if (allocated(failure)) return
    if (size(self%effects) > 0) then
      call copy_effects(self%effects, effects)
      do i = 1, size(effects)
        call effects(i)%effect%begin(pairs)
      end do
      number = size(result%states)
      allocate (columns%states(number), choices(merge(number, 0, size(pairs%list) > 0)))
      columns%states%prescribed = result%states%prescribed
      if (size(pairs%list) == 0) call add_nothing(self%scene_in, pairs, effects, columns)
      ! The last state comes first: most effects are simulated there.
      do i = size(choices), 1, -1
        call start_at(i)
        call choose_effects(pairs, effects, state, choices(i))
        is_needed = any(choices(i)%is_simulated)
        if (is_needed) return
      end do
      do i = 1, size(choices)
        call start_at(i)
        call add_without_effects(self%scene_in, pairs, effects, state, choices(i)%outcomes, i, &
                                 self%keep_rows, columns)
      end do
      call move_values(columns, result)
    end if
    allocate (shares(size(self%left_out), size(result%states)))
    call copy_effects(self%left_out, effects)
    do i = 1, size(effects)
      call effects(i)%effect%begin(pairs)
    end do
    do i = 1, size(result%states)
      call estimate_shares(pairs, effects, hertz_law(modulus=pairs%modulus), &
                           scale(result%states(i)%compression, -pairs%length_power), shares(:, i))
    end do
    call estimate_left_out(self, shares, result)
    result%error_estimate = result%states(size(result%states))%error_estimate

  contains

    ! Starts a state of isolated contacts.
    subroutine start_at(number)
      integer, intent(in) :: number

      call start_state(pairs, hertz_law(modulus=pairs%modulus), &
                       scale(result%states(number)%compression, -pairs%length_power), state)
    end subroutine start_at

  end subroutine solve_without

  ! Moves the results of the effects to a position that was solved without them.
  subroutine move_values(columns, result)
    type(position_result), intent(inout) :: columns, result

    result%counted = columns%counted
    call move_alloc(columns%effects, result%effects)
    call move_alloc(columns%contact_values, result%contact_values)
    call move_alloc(columns%state_values, result%state_values)
    call move_alloc(columns%contact_columns, result%contact_columns)
    call move_alloc(columns%state_columns, result%state_columns)
    result%states%dissipated_work = columns%states%dissipated_work
    result%states%error_estimate = columns%states%error_estimate
    result%states%area_error = columns%states%area_error
  end subroutine move_values

  ! Adds the influence of every effect that is off to the error of each state. That in the state of
  ! the largest compression is reported.
  subroutine estimate_left_out(self, shares, result)
    class(asperity_model), intent(in) :: self
    real(real64), intent(in) :: shares(:, :)  ! of the load, by effect and state
    type(position_result), intent(inout) :: result
    type(theory_warning), allocatable :: warnings(:)
    real(real64) :: share
    integer :: deepest, i, k, warned

    if (size(self%left_out) == 0) return
    associate (states => result%states)
      states%error_estimate = max(states%error_estimate, 0.0_real64)
      ! Without a load there is no share; contacts in tension have that of the deepest state.
      deepest = maxloc(states%compression, 1)
      where (abs(states%load) > 0.0_real64) states%error_estimate = states%error_estimate + &
        error_of_share(states%prescribed /= prescribed_nothing, &
                       merge(sum(shares, 1), sum(shares(:, deepest)), states%load > 0.0_real64))
    end associate
    do i = 1, size(self%left_out)
      associate (effect => self%left_out(i)%effect, effects_of_scene => self%scene_in%effects)
        share = shares(i, deepest)
        result%left_out(findloc(known_effects%name, effect%name, 1)) = share
        if (.not. share > effect%tolerance) cycle
        warned = of_off
        ! It has no common theory with an effect that is on, or `auto`.
        do k = 1, size(self%effects)
          associate (other => self%effects(k)%effect)
            if (.not. go_together(effect%name, 'on', other%name, effect_words( &
                merge(effect_on, other%mode, other%mode == effect_auto)))) warned = of_excluded
          end associate
        end do
        if (effects_of_scene%is_barred(effect%name)) warned = of_barred
        call add_warning(warnings, warned, share, whose=effect%name)
      end associate
    end do
    call take_worse(result%warnings, warnings, deepest)
  end subroutine estimate_left_out

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

end module asperity_asperity_model
