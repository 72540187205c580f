!> The methods in which any scene can be computed, from the original program to neighbours resolved
!> on cells: what they are, and how one is run.
module asperity_study_methods
  use asperity_accuracy_choice, only: typed_number
  use asperity_contact_records, only: by_events, by_marching, overlap_original, overlap_stable, &
                                      solve_method
  use asperity_decimal, only: decimal_value
  use asperity_effect_names, only: effect_words, go_together, known_effects, of_interaction, &
                                   why_not_together
  use asperity_interruption, only: interruption
  use asperity_isolated_contacts, only: solve_position
  use asperity_kinds, only: int64, real64
  use asperity_map_scene, only: change_resolution
  use asperity_original, only: arithmetic_names
  use asperity_original_records, only: original_request
  use asperity_placed_scene, only: placed_scene
  use asperity_problems, only: real_text
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: scene_results
  use asperity_scene_placing, only: place_scene
  use asperity_scene_values, only: criterion_load, effect_auto, effect_boundary, effect_coupled, &
                                   effect_off, is_limit, is_thesis_sweep, scene, scene_effects
  use asperity_solve, only: solve
  use asperity_model_solve, only: solve_effects
  implicit none
  private

  public :: list_methods, most_methods, run_method, study_method, simulated_effects, &
            request_of
  public :: of_scene, of_arithmetic, of_steps, of_neighbours, of_effects, family_words

  ! Families: the approximation of a method.
  integer, parameter :: of_scene = 1       !! nothing: the scene as it asks
  integer, parameter :: of_arithmetic = 2  !! its arithmetic; no effects
  integer, parameter :: of_steps = 3       !! steps in place of exact events; no effects
  integer, parameter :: of_neighbours = 4  !! how neighbouring contacts are taken together
  integer, parameter :: of_effects = 5     !! an effect is left out
  !> Their words.
  character(len=*), parameter :: family_words(5) = [character(len=10) :: &
    'scene', 'arithmetic', 'steps', 'neighbours', 'effects']

  integer, parameter :: as_it_is = -1  ! interaction as in the scene

  ! The step of the original program is 10**original_order cm.
  integer, parameter :: original_order = -3

  !> Largest estimated influence of an effect that `auto` leaves out, relative to the load, beside a
  !> given method of taking neighbours.
  real(real64), parameter :: tolerance_of_others = 1.0e-4_real64
  ! Tolerance of areas beside equal and finer ones of loads (chosen: to 1e-4 an area of dense
  ! contacts takes 80 times as long).
  real(real64), parameter :: finest_areas = 1.0e-3_real64

  !> One method.
  type :: study_method
    integer :: family = of_scene               !! one of the numbers above
    character(len=40) :: name = ''             !! in words
    character(len=96) :: typed = ''            !! what to type for it; blank: it is no choice
    character(len=7) :: arithmetic = 'real64'  !! one of `arithmetic_names`
    integer :: path = by_events                !! `by_events` or `by_marching`
    integer :: overlap = overlap_stable        !! `overlap_stable` or `overlap_original`
    real(real64) :: step = 0.0_real64          !! of marching, of the separation [length]; 0: none
    integer :: interaction = as_it_is          !! one of the `effect_` numbers, or as it is
    real(real64) :: tolerance = 0.0_real64  !! of `auto` or of the cells
    !> Pixels along a side over those of the map, a power of two.
    real(real64) :: resolution = 1.0_real64
    real(real64) :: accuracy = 0.0_real64      !! requested accuracy; 0: none
    character(len=11) :: without = ''          !! an effect that is left out
    logical :: is_original = .false.           !! the original program
  end type study_method

contains

  ! Whether a scene goes to a limit load: all its methods without effects are compared.
  pure logical function is_sweep(scene_in)
    type(scene), intent(in) :: scene_in

    is_sweep = is_limit(scene_in%loading%control) .and. &
               scene_in%limit%criterion == criterion_load .and. .not. allocated(scene_in%map)
  end function is_sweep

  !> So many methods there are at most: the scene, 4 of arithmetic and steps or 30 of a sweep, 9 of
  !> neighbours, 4 of effects.
  pure integer function most_methods(scene_in)
    type(scene), intent(in) :: scene_in  !! scene with checked values

    most_methods = merge(44, 18, is_sweep(scene_in))
  end function most_methods

  !> Which effects were simulated at some position, or are on.
  pure function simulated_effects(scene_in, results) result(simulated)
    type(scene), intent(in) :: scene_in         !! scene with checked values
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
  subroutine list_methods(scene_in, simulated, compression, finest, methods, left_out)
    type(scene), intent(in) :: scene_in                   !! scene with checked values
    logical, intent(in) :: simulated(:)                   !! as `simulated_effects` has it
    real(real64), intent(in) :: compression                   !! the largest of the scene as it asks
    real(real64), intent(in) :: finest                    !! resolution of a map: 1 or 2
    type(study_method), allocatable, intent(out) :: methods(:)  !! at least one
    character(len=:), allocatable, intent(out) :: left_out
    integer :: e, k

    allocate (methods(0))
    if (.not. allocated(scene_in%map)) call add_arithmetics(scene_in, compression, methods)
    do e = 1, size(known_effects)
      if (.not. simulated(e) .or. e == of_interaction) cycle
      k = size(methods) + 1
      methods = [methods, study_method(family=of_effects, without=known_effects(e)%name)]
      methods(k)%name = 'without ' // known_effects(e)%name
      methods(k)%typed = trim(known_effects(e)%name) // ' = ''off'''
    end do
    left_out = ''
    do e = 1, size(known_effects)
      if (simulated(e) .and. left_out == '') &
        left_out = why_not_together(trim(known_effects(e)%name), 'on', &
                                    trim(known_effects(of_interaction)%name), 'coupled', .false.)
    end do
    if (left_out == '') call add_neighbours(scene_in, simulated, finest, methods)
  end subroutine list_methods

  ! Without effects: exact events. Of a sweep to a limit load besides steps of about the
  ! compression, a tenth, a hundredth and a thousandth of it, and both overlaps.
  ! Of the thesis' sweep the original program, in each arithmetic and with these steps and its own.
  subroutine add_arithmetics(scene_in, compression, methods)
    type(scene), intent(in) :: scene_in
    real(real64), intent(in) :: compression
    type(study_method), allocatable, intent(inout) :: methods(:)
    integer :: k, order
    logical :: sweep

    sweep = is_sweep(scene_in)
    order = 0
    if (compression > 0.0_real64) order = floor(log10(compression))
    call add_overlaps(study_method(family=of_arithmetic, name='real64, exact events'))
    if (is_thesis_sweep(scene_in)) call add_original(original_order, ', original program, 1976')
    if (.not. (sweep .and. compression > 0.0_real64)) return
    do k = order, order - 3, -1
      if (is_thesis_sweep(scene_in) .and. k /= original_order) &
        call add_original(k, ', original program, steps ' // real_text(10.0_real64**k, 'es7.1e2'))
      call add_overlaps(study_method(family=of_steps, path=by_marching, step=10.0_real64**k, &
                                     name='real64, steps ' // &
                                     real_text(10.0_real64**k, 'es7.1e2')))
    end do

  contains

    ! Adds a method; in a sweep also with the overlap of the original.
    subroutine add_overlaps(method)
      type(study_method), intent(in) :: method
      integer :: last

      methods = [methods, method]
      if (.not. sweep) return
      last = size(methods) + 1
      methods = [methods, method]
      methods(last)%overlap = overlap_original
      methods(last)%name = trim(method%name) // ', original overlap'
    end subroutine add_overlaps

    ! Adds the original program in each arithmetic, with steps of 10**order.
    subroutine add_original(order, label)
      integer, intent(in) :: order
      character(len=*), intent(in) :: label
      integer :: a

      do a = 1, size(arithmetic_names)
        methods = [methods, study_method( &
          family=of_steps, name=trim(arithmetic_names(a)) // label, path=by_marching, &
          arithmetic=arithmetic_names(a), overlap=overlap_original, step=10.0_real64**order, &
          is_original=.true.)]
      end do
    end subroutine add_original

  end subroutine add_arithmetics

  !> The request of the original program with the steps of a method: as many approaches more as the
  !> steps are shorter.
  pure type(original_request) function request_of(method, keep_contacts) result(request)
    type(study_method), intent(in) :: method   !! a run of the original program
    logical, intent(in) :: keep_contacts       !! keep all contacts
    integer :: order

    order = nint(log10(method%step))
    request%keep_contacts = keep_contacts
    request%approach_step = decimal_value(1_int64, order)
    request%napmx = max(request%napmx, nint(request%napmx * 10.0_real64**(original_order - order)))
  end function request_of

  ! Contacts each alone, as circles together, circles or cells by estimate, all on cells.
  subroutine add_neighbours(scene_in, simulated, finest, methods)
    type(scene), intent(in) :: scene_in
    logical, intent(in) :: simulated(:)
    real(real64), intent(in) :: finest
    type(study_method), allocatable, intent(inout) :: methods(:)
    real(real64), parameter :: of_auto(3) = [1.0e-2_real64, 3.0e-3_real64, 1.0e-3_real64]
    type(study_method) :: method
    integer :: e, k

    if (allocated(scene_in%map)) then
      ! `auto` is the pixels at any tolerance.
      call add_pixel_methods(merge(1.0_real64, 0.25_real64, scene_in%motion%positions > 1), &
                             merge(1.0_real64, finest, scene_in%motion%positions > 1), methods)
      return
    end if
    method = study_method(family=of_neighbours, interaction=effect_off)
    method%name = 'isolated contacts'
    call add_method()
    method%interaction = effect_coupled
    method%name = 'contacts coupled'
    call add_method()
    if (any([(simulated(e) .and. .not. go_together( &
      known_effects(e)%name, 'on', known_effects(of_interaction)%name, 'boundary'), &
      e=1, size(simulated))])) return
    method%interaction = effect_auto
    do k = 1, size(of_auto)
      method%tolerance = of_auto(k)
      method%name = 'auto, tolerance ' // trim(typed_number(of_auto(k)))
      call add_method(', tolerance = ' // trim(typed_number(of_auto(k))))
    end do
    method%interaction = effect_boundary
    do k = -2, -4, -1
      method%tolerance = 10.0_real64**k
      method%name = 'boundary elements, ' // trim(typed_number(method%tolerance))
      call add_method(', boundary_tolerance = ' // trim(typed_number(method%tolerance)) // &
                      merge(', area_tolerance = 0.001', repeat(' ', 24), k < -2))
    end do

  contains

    ! Adds a method; beside other effects the tolerance of theirs is typed, too.
    subroutine add_method(numbers)
      character(len=*), intent(in), optional :: numbers

      method%typed = 'interaction = ''' // trim(effect_words(method%interaction)) // ''''
      if (present(numbers)) method%typed = trim(method%typed) // numbers
      if (method%interaction /= effect_auto .and. count(simulated) > 1) &
        method%typed = trim(method%typed) // ', tolerance = ' // &
                       trim(typed_number(tolerance_of_others))
      methods = [methods, method]
    end subroutine add_method

  end subroutine add_neighbours

  ! The pixels of a map, from a coarsest resolution to a finest one, and those for an accuracy.
  subroutine add_pixel_methods(coarsest, finest, methods)
    real(real64), intent(in) :: coarsest, finest
    type(study_method), allocatable, intent(inout) :: methods(:)
    character(len=*), parameter :: names(4) = [character(len=24) :: 'pixels, every fourth', &
      'pixels, every second', 'pixels of the map', 'pixels half as wide'], &
      goals(3) = [character(len=4) :: '1e-2', '1e-3', '1e-4']
    type(study_method) :: method
    integer :: k

    method = study_method(family=of_neighbours, interaction=effect_boundary, &
                          tolerance=tolerance_of_others)
    do k = 1, size(names)
      method%resolution = 2.0_real64**(k - 3)
      if (method%resolution < coarsest .or. method%resolution > finest) cycle
      method%name = names(k)
      methods = [methods, method]
    end do
    do k = 1, size(goals)
      method = study_method(family=of_neighbours, accuracy=10.0_real64**(-k - 1))
      method%name = 'pixels by --accuracy ' // goals(k)
      method%typed = '--accuracy ' // goals(k)
      methods = [methods, method]
    end do
  end subroutine add_pixel_methods

  !> Runs a scene in a method, all positions. The original program is
  !> not run here.
  subroutine run_method(scene_in, method, options, results, failure)
    type(scene), intent(in) :: scene_in                    !! scene with checked values
    type(study_method), intent(in) :: method                     !! one of its methods
    type(run_options), intent(in) :: options               !! threads, and when it shall end
    type(scene_results), intent(out) :: results            !! results, all positions
    character(len=:), allocatable, intent(out) :: failure  !! reason of a failure
    type(scene) :: copy
    type(run_options) :: own
    type(scene_effects) :: none

    copy = scene_in
    if (any(method%family == [of_arithmetic, of_steps])) then
      ! No effects, and of several values the deepest.
      copy%effects = none
      if (allocated(copy%loading%path)) deallocate (copy%loading%path)
      copy%loading%points = 0
      if (method%path == by_marching) then
        call march_positions(copy, method, options%interrupt, results, failure)
      else
        call solve_effects(copy, options, results, failure, &
                           solve_method(overlap=method%overlap, step=method%step))
      end if
      return
    end if
    if (method%without /= '') call copy%effects%call_for(trim(method%without), effect_off)
    if (method%interaction /= as_it_is) then
      copy%effects%modes(of_interaction) = method%interaction
      call copy%effects%set('tolerance', tolerance_of_others)
      if (method%interaction == effect_auto) call copy%effects%set('tolerance', method%tolerance)
      if (method%interaction == effect_boundary) then
        call copy%effects%set('boundary_tolerance', method%tolerance)
        if (method%tolerance <= finest_areas .and. &
            copy%effects%number('area_tolerance') > finest_areas) &
          call copy%effects%set('area_tolerance', finest_areas)
      end if
    end if
    if (abs(method%resolution - 1.0_real64) > 0.0_real64) then
      call change_resolution(copy, method%resolution, failure)
      if (allocated(failure)) return
    end if
    own = options
    own%accuracy = method%accuracy
    call solve(copy, results, failure, own)
  end subroutine run_method

  ! In steps, all positions. A load that was asked for is overshot, as it is meant to be.
  subroutine march_positions(scene_in, method, interrupt, results, failure)
    type(scene), intent(in) :: scene_in
    type(study_method), intent(in) :: method
    type(interruption), intent(in) :: interrupt
    type(scene_results), intent(inout) :: results
    character(len=:), allocatable, intent(out) :: failure
    type(placed_scene) :: placed
    integer :: m

    call place_scene(scene_in, placed, failure)
    if (allocated(failure)) return
    allocate (results%positions(scene_in%motion%positions))
    do m = 1, scene_in%motion%positions
      if (interrupt%is_asked()) failure = 'interrupted'
      if (.not. allocated(failure)) &
        call solve_position(placed, m, solve_method(method%path, method%overlap, method%step), &
                            .false., results%positions(m), failure)
      if (allocated(failure)) return
    end do
  end subroutine march_positions

end module asperity_study_methods
