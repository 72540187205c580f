!> The ways in which any scene can be computed, from the shortest arithmetic to neighbours resolved
!> on cells: what they are, and how one is run.
module asperity_scene_ways
  use asperity_arithmetics, only: solver_in
  use asperity_contact_records, only: by_events, by_marching, overlap_original, overlap_stable, &
                                      solve_method
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
                                   criterion_load, effect_auto, effect_boundary, &
                                   effect_coupled, effect_off, has_hardness, is_thesis_sweep, &
                                   scene, scene_effects
  use asperity_solve, only: solve
  use asperity_surface_solve, only: solve_in_arithmetic
  implicit none
  private

  public :: as_the_scene_asks, list_ways, most_ways, run_way, scene_way, simulated_effects, &
            without_map
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

  ! Step of the original program, cm.
  real(real64), parameter :: original_step = 1.0e-3_real64

  !> What `auto` may leave out of other effects beside a given way of taking neighbours.
  type(decimal_value), parameter :: hardly_anything = decimal_value(1_int64, -4)

  !> One way.
  type :: scene_way
    integer :: family = of_scene               !! one of the numbers above
    character(len=40) :: name = ''             !! in words
    character(len=7) :: arithmetic = 'real64'  !! one of `arithmetic_names`
    integer :: path = by_events                !! `by_events` or `by_marching`
    integer :: overlap = overlap_stable        !! `overlap_stable` or `overlap_original`
    !> Step of the separation [length]: of marching, or past first touch for the pressure there; 0:
    !> no step.
    real(real64) :: step = 0.0_real64
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

  ! Whether a scene goes to a limit load: all its methods without effects are compared.
  pure logical function is_sweep(scene_in)
    type(scene), intent(in) :: scene_in

    is_sweep = scene_in%loading%control == control_limit .and. &
               scene_in%limit%criterion == criterion_load .and. .not. allocated(scene_in%map)
  end function is_sweep

  !> So many ways there are at most: the scene, 8 of arithmetic and steps, 44 of a sweep, 8 of
  !> neighbours, 4 of effects.
  pure integer function most_ways(scene_in)
    type(scene), intent(in) :: scene_in  !! checked values

    most_ways = merge(57, 21, is_sweep(scene_in))
  end function most_ways

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

  ! Without effects: every arithmetic by exact events, and steps of a tenth, a hundredth and a
  ! thousandth of the closing. Of a sweep to a limit load besides steps of about the closing, all of
  ! them in every arithmetic and with both overlaps, and the original program where it can be run.
  subroutine add_arithmetics(scene_in, closing, ways)
    type(scene), intent(in) :: scene_in
    real(real64), intent(in) :: closing
    type(scene_way), allocatable, intent(inout) :: ways(:)
    character(len=7), parameter :: names(4) = [character(len=7) :: 'real64', 'real128', 'real32', &
                                               'ibm370']
    character(len=24) :: steps
    real(real64) :: step
    integer :: k
    logical :: sweep

    sweep = is_sweep(scene_in)
    step = 0.0_real64
    if (sweep .and. closing > 0.0_real64) step = 10.0_real64**(floor(log10(closing)) - 1)
    call add(of_arithmetic, by_events, size(names), ', exact events')
    if (is_thesis_sweep(scene_in)) then
      step = original_step
      call add(of_steps, by_marching, size(names), ', original program, 1976')
    end if
    if (any(scene_in%loading%control == [control_separation, control_compression]) .or. &
        .not. closing > 0.0_real64) return
    do k = merge(0, 1, sweep), 3
      step = 10.0_real64**(floor(log10(closing)) - k)
      write (steps, '(", steps ", es7.1e2)') step
      call add(of_steps, by_marching, merge(size(names), 1, sweep), trim(steps))
    end do

  contains

    ! Adds a way in arithmetics; in a sweep also with the overlap of the original.
    subroutine add(family, path, arithmetics, words)
      integer, intent(in) :: family, path, arithmetics
      character(len=*), intent(in) :: words
      type(scene_way) :: way
      integer :: a, overlap
      logical :: is_original

      is_original = index(words, 'original program') > 0
      do a = 1, arithmetics
        do overlap = merge(overlap_original, overlap_stable, is_original), &
                     merge(overlap_original, overlap_stable, sweep)
          way = scene_way(family=family, arithmetic=names(a), path=path, overlap=overlap, &
                          step=step, is_original=is_original)
          way%name = trim(names(a)) // words
          if (overlap == overlap_original .and. .not. is_original) &
            way%name = trim(way%name) // ', original overlap'
          ways = [ways, way]
        end do
      end do
    end subroutine add

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
      if (way%path == by_marching) then
        call march(copy, way, options%interrupt, results, failure)
      else
        call solve_in_arithmetic(copy, solve_method(overlap=way%overlap, step=way%step), chosen, &
                                 results, failure)
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
  subroutine march(scene_in, way, interrupt, results, failure)
    type(scene), intent(in) :: scene_in
    type(scene_way), intent(in) :: way
    type(interruption), intent(in) :: interrupt
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure
    class(position_solver), allocatable :: solver
    integer :: m

    call solver_in(way%arithmetic, scene_in, solve_method(way%path, way%overlap, way%step), &
                   solver, failure)
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
