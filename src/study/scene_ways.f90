!> The ways in which any scene can be computed, from the shortest arithmetic to neighbours resolved
!> on cells: what they are, and how one is run.
module asperity_scene_ways
  use asperity_arithmetics, only: solver_in
  use asperity_contact_records, only: by_marching, solve_method
  use asperity_decimal, only: decimal_value
  use asperity_effect_names, only: known_effects, why_not_together
  use asperity_height_map, only: height_map
  use asperity_interruption, only: interruption
  use asperity_kinds, only: int64, real64
  use asperity_map_scene, only: join_maps, summits_of_scene
  use asperity_map_summits, only: map_summits
  use asperity_position_solver, only: position_solver
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: control_compression, control_limit, control_separation, &
                                   effect_auto, effect_boundary, &
                                   effect_coupled, effect_off, has_hardness, is_thesis_sweep, &
                                   scene, scene_effects
  use asperity_solve, only: solve
  use asperity_surface_solve, only: solve_in_arithmetic
  implicit none
  private

  public :: as_the_scene_asks, list_ways, run_way, scene_way, simulated_effects, without_map
  public :: of_scene, of_arithmetic, of_steps, of_neighbours, of_effects, of_input, of_theory, &
            family_words

  ! What a way differs in.
  integer, parameter :: of_scene = 1       !! nothing: the scene as it asks
  integer, parameter :: of_arithmetic = 2  !! its arithmetic; no effects
  integer, parameter :: of_steps = 3       !! steps in place of exact events; no effects
  integer, parameter :: of_neighbours = 4  !! how neighbouring contacts are taken together
  integer, parameter :: of_effects = 5     !! an effect is left out
  integer, parameter :: of_input = 6       !! other last digits of the input
  integer, parameter :: of_theory = 7      !! a theory in closed form in place of the simulation
  !> Their words.
  character(len=*), parameter :: family_words(7) = [character(len=10) :: &
    'scene', 'arithmetic', 'steps', 'neighbours', 'effects', 'input', 'theory']

  integer, parameter :: as_it_is = -1  ! interaction as in the scene

  !> What `auto` may leave out of other effects beside a given way of taking neighbours.
  type(decimal_value), parameter :: hardly_anything = decimal_value(1_int64, -4)

  !> One way.
  type :: scene_way
    integer :: family = of_scene               !! one of the numbers above
    character(len=32) :: name = ''             !! in words
    character(len=7) :: arithmetic = 'real64'  !! one of `arithmetic_names`
    real(real64) :: step = 0.0_real64          !! of marching; 0: exact events
    integer :: interaction = as_it_is          !! one of the `effect_` numbers, or as it is
    type(decimal_value) :: tolerance = decimal_value()  !! of `auto` or of the cells
    character(len=11) :: without = ''          !! an effect that is left out
    logical :: is_original = .false.           !! the original program
  end type scene_way

contains

  !> The scene as it asks.
  pure function as_the_scene_asks() result(way)
    type(scene_way) :: way

    way%name = 'as in the scene'
  end function as_the_scene_asks

  !> Which effects were simulated at some position, or are on.
  pure function simulated_effects(scene_in, results) result(simulated)
    type(scene), intent(in) :: scene_in         !! checked values
    type(scene_results), intent(in) :: results  !! of the scene as it asks
    logical :: simulated(size(known_effects))   !! in the order of the list
    integer :: e, m, place

    simulated = scene_in%effects%modes /= effect_off .and. scene_in%effects%modes /= effect_auto
    if (.not. allocated(results%effects)) return
    do e = 1, size(results%effects%names)
      place = findloc(known_effects%name, results%effects%names(e), 1)
      if (place == 0) cycle
      do m = 1, size(results%positions)
        if (.not. allocated(results%positions(m)%effects)) cycle
        if (results%positions(m)%effects(e)%simulated /= 'off') simulated(place) = .true.
      end do
    end do
  end function simulated_effects

  !> All methods except that of the scene, by family, each from the fastest on. `left_out` is the
  !> reason in one line why no method includes interaction; empty: some do.
  subroutine list_ways(scene_in, simulated, closing, ways, left_out)
    type(scene), intent(in) :: scene_in                   !! checked values
    logical, intent(in) :: simulated(:)                   !! as `simulated_effects` has it
    real(real64), intent(in) :: closing                   !! the largest of the scene as it asks
    type(scene_way), allocatable, intent(out) :: ways(:)  !! at least one
    character(len=:), allocatable, intent(out) :: left_out
    integer :: e, k

    allocate (ways(0))
    call add_arithmetics(scene_in, closing, ways)
    do e = 1, size(known_effects)
      if (.not. simulated(e) .or. known_effects(e)%name == 'interaction') cycle
      k = size(ways) + 1
      ways = [ways, scene_way(family=of_effects, without=known_effects(e)%name)]
      ways(k)%name = 'without ' // known_effects(e)%name
    end do
    left_out = ''
    do e = 1, size(known_effects)
      if (simulated(e) .and. left_out == '') &
        left_out = why_not_together(trim(known_effects(e)%name), 'on', 'interaction', 'coupled')
    end do
    if (left_out == '') call add_neighbours(scene_in, simulated, ways)
  end subroutine list_ways

  ! Without effects: every arithmetic by exact events, the original program where the scene is its
  ! sweep, and steps of a tenth, a hundredth and a thousandth of the closing.
  subroutine add_arithmetics(scene_in, closing, ways)
    type(scene), intent(in) :: scene_in
    real(real64), intent(in) :: closing
    type(scene_way), allocatable, intent(inout) :: ways(:)
    character(len=7), parameter :: names(4) = [character(len=7) :: 'real64', 'real128', 'real32', &
                                               'ibm370']
    type(scene_way) :: way
    integer :: k

    do k = 1, size(names)
      way = scene_way(family=of_arithmetic, arithmetic=names(k))
      way%name = trim(names(k)) // ', exact events'
      ways = [ways, way]
    end do
    if (is_thesis_sweep(scene_in)) then
      way = scene_way(family=of_steps, arithmetic='ibm370', is_original=.true.)
      way%name = 'the original program, 1976'
      ways = [ways, way]
    end if
    if (any(scene_in%loading%control == [control_separation, control_compression]) .or. &
        .not. closing > 0.0_real64) return
    do k = 1, 3
      way = scene_way(family=of_steps)
      way%step = 10.0_real64**(floor(log10(closing)) - k)
      write (way%name, '("steps of ", es7.1e2)') way%step
      ways = [ways, way]
    end do
  end subroutine add_arithmetics

  ! Contacts each alone, as circles together, circles or cells by estimate, all on cells.
  subroutine add_neighbours(scene_in, simulated, ways)
    type(scene), intent(in) :: scene_in
    logical, intent(in) :: simulated(:)
    type(scene_way), allocatable, intent(inout) :: ways(:)
    type(decimal_value), parameter :: of_auto(3) = [decimal_value(1_int64, -2), &
                                                    decimal_value(3_int64, -3), &
                                                    decimal_value(1_int64, -3)]
    type(scene_way) :: way
    character(len=:), allocatable :: on_cells, unit
    integer :: e, k

    unit = 'contacts'
    if (allocated(scene_in%map)) unit = 'summits'
    way = scene_way(family=of_neighbours, interaction=effect_off)
    way%name = 'isolated ' // unit
    ways = [ways, way]
    way%interaction = effect_coupled
    way%name = unit // ' coupled'
    ways = [ways, way]
    if (scene_in%loading%control == control_limit .and. allocated(scene_in%map)) return
    ! A hardness is that of pixels: `auto` solves these alone.
    if (has_hardness(scene_in)) then
      call add_pixels(ways)
      return
    end if
    on_cells = ''
    do e = 1, size(simulated)
      if (simulated(e)) on_cells = on_cells // &
        why_not_together(trim(known_effects(e)%name), 'on', 'interaction', 'boundary')
    end do
    if (on_cells /= '') return
    way%interaction = effect_auto
    do k = 1, size(of_auto)
      way%tolerance = of_auto(k)
      way%name = 'auto, tolerance ' // share_text(of_auto(k))
      ways = [ways, way]
    end do
    if (allocated(scene_in%map)) then
      if (.not. any(simulated .and. known_effects%name /= 'interaction')) call add_pixels(ways)
      return
    end if
    way%interaction = effect_boundary
    do k = -2, -4, -1
      way%tolerance = decimal_value(1_int64, k)
      way%name = 'boundary elements, ' // share_text(way%tolerance)
      ways = [ways, way]
    end do
  end subroutine add_neighbours

  ! The pixels of a map.
  subroutine add_pixels(ways)
    type(scene_way), allocatable, intent(inout) :: ways(:)
    type(scene_way) :: way

    way = scene_way(family=of_neighbours, interaction=effect_boundary, tolerance=hardly_anything)
    way%name = 'pixels of the map'
    ways = [ways, way]
  end subroutine add_pixels

  ! A tolerance as .01.
  pure function share_text(share) result(text)
    type(decimal_value), intent(in) :: share
    character(len=:), allocatable :: text

    text = '0.' // repeat('0', -share%exponent - 1) // achar(iachar('0') + int(share%digits))
  end function share_text

  !> Runs a scene in a way, all positions, the ends of its path alone. The original program is not
  !> run here.
  subroutine run_way(scene_in, way, options, results, failure)
    type(scene), intent(in) :: scene_in                    !! checked values
    type(scene_way), intent(in) :: way                     !! one of its ways
    type(run_options), intent(in) :: options               !! threads, and when it shall end
    type(scene_results), intent(out) :: results            !! all positions
    character(len=:), allocatable, intent(out) :: failure  !! why not
    type(run_options) :: chosen
    type(scene) :: copy

    copy = scene_in
    copy%loading%points = 0
    chosen = options
    if (any(way%family == [of_arithmetic, of_steps])) then
      if (allocated(copy%map)) call without_map(scene_in, copy, failure)
      if (allocated(failure)) return
      call leave_effects_out(copy)
      copy%loading%points = 0
      chosen%arithmetic = way%arithmetic
      if (way%step > 0.0_real64) then
        call march(copy, way%step, options%interrupt, results, failure)
      else
        call solve_in_arithmetic(copy, solve_method(), chosen, results, failure)
      end if
      return
    end if
    if (way%without /= '') call copy%effects%call_for(trim(way%without), effect_off)
    if (way%interaction /= as_it_is) then
      call copy%effects%call_for('interaction', way%interaction)
      call copy%effects%set('tolerance', hardly_anything)
      if (way%interaction == effect_auto) call copy%effects%set('tolerance', way%tolerance)
      if (way%interaction == effect_boundary) &
        call copy%effects%set('boundary_tolerance', way%tolerance)
      ! Of a map the summits alone: the scene as it asks presses the map beside them.
      if (allocated(copy%map) .and. any(way%interaction == [effect_off, effect_coupled])) &
        call take_summits(failure)
      if (allocated(failure)) return
    end if
    call solve(copy, results, failure, chosen)

  contains

    subroutine take_summits(failure)
      character(len=:), allocatable, intent(out) :: failure
      type(scene) :: plain

      call without_map(copy, plain, failure)
      if (allocated(failure)) return
      ! Summits have no hardness: they are elastic.
      if (has_hardness(copy)) call plain%effects%call_for('plasticity', effect_off)
      copy = plain
    end subroutine take_summits

  end subroutine run_way

  ! In steps, all positions. A load that was asked for is overshot, as it is meant to be.
  subroutine march(scene_in, step, interrupt, results, failure)
    type(scene), intent(in) :: scene_in
    real(real64), intent(in) :: step
    type(interruption), intent(in) :: interrupt
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure
    class(position_solver), allocatable :: solver
    integer :: m

    call solver_in('real64', scene_in, solve_method(path=by_marching, step=step), solver, failure)
    if (allocated(failure)) return
    allocate (results%positions(solver%positions))
    do m = 1, solver%positions
      if (interrupt%is_asked()) failure = 'interrupted'
      if (.not. allocated(failure)) &
        call solver%solve(m, .false., results%positions(m), failure)
      if (allocated(failure)) return
    end do
  end subroutine march

  !> The summits of a map in its place.
  subroutine without_map(scene_in, plain, failure)
    type(scene), intent(in) :: scene_in                    !! with a map
    type(scene), intent(out) :: plain                      !! without one
    character(len=:), allocatable, intent(out) :: failure  !! why not
    type(height_map) :: map
    type(map_summits) :: summits

    call join_maps(scene_in, map, failure)
    if (.not. allocated(failure)) call summits_of_scene(scene_in, map, plain, summits, failure)
  end subroutine without_map

  ! Effects, and what several values lead up to: the deepest of them stays.
  subroutine leave_effects_out(copy)
    type(scene), intent(inout) :: copy
    type(scene_effects) :: none

    copy%effects = none
    if (allocated(copy%loading%path)) deallocate (copy%loading%path)
  end subroutine leave_effects_out

end module asperity_scene_ways
