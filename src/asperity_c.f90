!> The library for C, and for whatever calls C: `include/asperity.h` says what each procedure does.
!>
!> Every call here gives one outcome, a handle, that holds all it brought: a scene, tables as
!> arrays, texts, what went wrong; `asperity_c_answers` has what looks at it. Nothing stops the
!> process, prints, or is remembered between calls.
!>
!> The name of a procedure for C must not be that of a module, as `asperity_solve` is one.
module asperity_c
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_ptr
  use asperity, only: add_reals, arithmetic_names, array_table, build_scene, card_deck, &
                      check_options, decimal_text, &
                      generate_surface, generated_surface, generation_spec, height_map, &
                      length_units, level_names, list_warning_kinds, list_warnings, &
                      make_arrays, map_statistics, map_summits, measure_map, name_units, &
                      of_contacts, original_records, original_request, parse_generation_spec, &
                      parse_scene, plan_surface, plane_surface, &
                      plain_unit, problem_list, radius_names, read_card_deck, &
                      read_generation_spec, read_scene, rule_names, run_in_arithmetic, &
                      run_options, scene, scene_results, scene_surface, solve, summit_choices, &
                      summits_of_file, surface_plan, take_surface, text_buffer, thesis_tables, &
                      write_report, write_summary, write_summits_table
  use asperity_c_outcome, only: begin, finish, finish_scene, look_at, outcome, set_text, &
                                table_statistics, table_summits, table_upper, text_notes, text_of, &
                                text_report, text_warning_kinds, text_warnings
  use, intrinsic :: iso_fortran_env, only: int64, real64
  implicit none
  private

  public :: c_read_scene, c_build_scene, c_solve, c_solve_again, c_report, c_summits, &
            c_periodic_summits, c_generate
  public :: c_surface, c_options, c_summits_options

  !> `asperity_surface` of the header.
  type, bind(c) :: c_surface
    integer(c_int) :: count             !! asperities; 0: a plane
    integer(c_int) :: radii             !! 1, or as many
    type(c_ptr) :: x, y, height, radius !! their numbers
  end type c_surface

  !> `asperity_options` of the header.
  type, bind(c) :: c_options
    type(c_ptr) :: arithmetic        !! name; null: real64
    real(c_double) :: accuracy       !! asked for; 0: none
    integer(c_int) :: totals_only    !! not 0: contacts are not kept
    integer(c_int) :: threads        !! 0: as many as OpenMP gives
    type(c_ptr) :: interrupt         !! a number that is not 0 when the work shall end; may be null
  end type c_options

  !> `asperity_summits_options` of the header.
  type, bind(c) :: c_summits_options
    type(c_ptr) :: rule, level, radius, unit  !! names; null: the default
    real(c_double) :: spacing(2)              !! of a matrix; 0 elsewhere
    integer(c_int) :: despike                 !! not 0: single outliers are removed
  end type c_summits_options

contains

  !> `asperity_read_scene`.
  type(c_ptr) function c_read_scene(path) bind(c, name='asperity_read_scene') result(handle)
    type(c_ptr), value :: path  !! of a scene or a card deck
    type(outcome), pointer :: new

    call begin(new, handle)
    if (.not. associated(new)) return
    allocate (new%scene_in)
    call require_text('scene', path, new%problems)
    if (new%problems%count() == 0) call read_scene(text_of(path), new%scene_in, new%problems)
    call finish_scene(new)
  end function c_read_scene

  !> `asperity_build_scene`.
  type(c_ptr) function c_build_scene(groups, upper, lower) bind(c, name='asperity_build_scene') &
    result(handle)
    type(c_ptr), value :: groups   !! text of the scene
    type(c_ptr), value :: upper    !! `c_surface`; null for both: the text names files
    type(c_ptr), value :: lower    !! `c_surface`
    type(outcome), pointer :: new
    type(scene_surface) :: surfaces(2)

    call begin(new, handle)
    if (.not. associated(new)) return
    allocate (new%scene_in)
    if (.not. c_associated(groups)) call new%problems%add('groups: found NULL, expected a text')
    if (.not. (c_associated(upper) .or. c_associated(lower))) then
      if (new%problems%count() == 0) &
        call parse_scene('scene', text_of(groups), new%scene_in, new%problems)
    else
      call take('surfaces.upper', upper, surfaces(1), new%problems)
      call take('surfaces.lower', lower, surfaces(2), new%problems)
      if (new%problems%count() == 0) &
        call build_scene(surfaces(1), surfaces(2), text_of(groups), new%scene_in, new%problems)
    end if
    call finish_scene(new)

  contains

    subroutine take(which, given, surface, problems)
      character(len=*), intent(in) :: which
      type(c_ptr), intent(in) :: given
      type(scene_surface), intent(out) :: surface
      type(problem_list), intent(inout) :: problems
      type(c_surface), pointer :: numbers
      real(c_double), pointer :: x(:), y(:), height(:), radius(:)
      integer :: before

      if (.not. c_associated(given)) then
        call problems%add(which // ': found NULL beside a surface that is given as arrays, ' // &
                          'expected both, or a plane')
        return
      end if
      call c_f_pointer(given, numbers)
      if (numbers%count == 0_c_int) then
        surface = plane_surface()
        return
      end if
      before = problems%count()
      if (numbers%count < 0_c_int) then
        call problems%add(which // '.count: found ' // decimal_text(numbers%count) // &
                          ', expected 0 for a plane, or more')
      else if (all(numbers%radii /= [1_c_int, numbers%count])) then
        call problems%add(which // '.radii: found ' // decimal_text(numbers%radii) // &
                          ', expected 1 or ' // decimal_text(numbers%count) // ', as many as x')
      end if
      call require_numbers(which // '.x', numbers%x, problems)
      call require_numbers(which // '.y', numbers%y, problems)
      call require_numbers(which // '.height', numbers%height, problems)
      call require_numbers(which // '.radius', numbers%radius, problems)
      if (problems%count() == before) then
        call c_f_pointer(numbers%x, x, [numbers%count])
        call c_f_pointer(numbers%y, y, [numbers%count])
        call c_f_pointer(numbers%height, height, [numbers%count])
        call c_f_pointer(numbers%radius, radius, [numbers%radii])
        call take_surface(which, x, y, height, radius, surface, problems)
      end if
    end subroutine take

  end function c_build_scene

  !> `asperity_solve_scene`.
  type(c_ptr) function c_solve(of_scene, options) bind(c, name='asperity_solve_scene') &
    result(handle)
    type(c_ptr), value :: of_scene  !! outcome that has a scene
    type(c_ptr), value :: options   !! `c_options`; null: all defaults
    type(run_options) :: chosen

    handle = solve_chosen(of_scene, options, chosen)
  end function c_solve

  !> `asperity_solve_again`.
  type(c_ptr) function c_solve_again(of_scene, options, earlier, progress) &
    bind(c, name='asperity_solve_again') result(handle)
    type(c_ptr), value :: of_scene  !! outcome that has a scene
    type(c_ptr), value :: options   !! `c_options`; null: all defaults
    type(c_ptr), value :: earlier   !! outcome of a solve; or null
    type(c_ptr), value :: progress  !! two numbers; or null
    type(run_options) :: chosen
    type(outcome), pointer :: before

    call look_at(earlier, before)
    if (c_associated(progress)) call c_f_pointer(progress, chosen%count%numbers, [2])
    handle = solve_chosen(of_scene, options, chosen)
  end function c_solve_again

  ! Solves a scene; some choices of the run may be made already.
  type(c_ptr) function solve_chosen(of_scene, options, chosen) result(handle)
    type(c_ptr), intent(in) :: of_scene, options
    type(run_options), intent(inout) :: chosen
    type(outcome), pointer :: from, new
    type(scene_results) :: results
    type(problem_list) :: kinds, warnings
    type(text_buffer) :: summary
    integer :: which

    call begin(new, handle)
    if (.not. associated(new)) return
    call look_at(of_scene, from)
    if (associated(from)) call new%problems%append(from%problems)
    if (.not. associated(from)) then
      new%failure = 'no scene'
    else if (.not. allocated(from%scene_in)) then
      new%failure = 'no scene'
    else if (from%problems%count() == 0) then
      call set_options(options, chosen, new%problems)
      if (new%problems%count() == 0) call solve(from%scene_in, results, new%failure, chosen)
      if (allocated(new%failure)) new%failure = from%scene_in%file // ': ' // new%failure
      call set_text(new, text_notes, from%scene_in%notes%text())
    end if
    if (new%problems%count() == 0 .and. .not. allocated(new%failure)) then
      call list_warnings(from%scene_in%file, results, warnings)
      call set_text(new, text_warnings, warnings%text())
      call list_warning_kinds(results, kinds)
      call set_text(new, text_warning_kinds, kinds%text())
      call write_summary(from%scene_in, results, summary)
      call set_text(new, text_report, summary%text())
      do which = 1, of_contacts
        if (.not. allocated(new%failure)) &
          call make_arrays(which, results, new%tables(which), new%failure)
        if (.not. allocated(new%failure)) call name_units(from%scene_in, new%tables(which))
      end do
    end if
    call finish(new)
  end function solve_chosen

  ! The choices of a run. What is no choice is told.
  subroutine set_options(given, chosen, problems)
    type(c_ptr), intent(in) :: given
    type(run_options), intent(inout) :: chosen
    type(problem_list), intent(inout) :: problems
    type(c_options), pointer :: options
    integer :: which

    if (.not. c_associated(given)) return
    call c_f_pointer(given, options)
    which = findloc(arithmetic_names, 'real64', 1)
    call take_word('arithmetic', options%arithmetic, arithmetic_names, which, problems)
    if (which > 0) chosen%arithmetic = arithmetic_names(which)
    chosen%accuracy = options%accuracy
    chosen%keep_contacts = options%totals_only == 0_c_int
    chosen%threads = options%threads
    call check_options(chosen, problems)
    if (c_associated(options%interrupt)) &
      call c_f_pointer(options%interrupt, chosen%interrupt%number)
  end subroutine set_options

  !> `asperity_make_report`.
  type(c_ptr) function c_report(path, arithmetic, tables, number) &
    bind(c, name='asperity_make_report') result(handle)
    type(c_ptr), value :: path         !! card deck
    type(c_ptr), value :: arithmetic   !! name; null: ibm370
    type(c_ptr), value :: tables       !! positions whose are printed; null: as in the thesis
    integer(c_int), value :: number    !! of them
    type(outcome), pointer :: new
    type(card_deck) :: deck
    type(original_request) :: request
    type(original_records) :: records
    type(text_buffer) :: report
    integer(c_int), pointer :: printed(:)
    integer :: i, which

    call begin(new, handle)
    if (.not. associated(new)) return
    call require_text('deck', path, new%problems)
    if (new%problems%count() == 0) call read_card_deck(text_of(path), deck, new%problems)
    which = 1
    call take_word('arithmetic', arithmetic, arithmetic_names, which, new%problems)
    request%keep_contacts(thesis_tables) = .not. c_associated(tables)
    if (c_associated(tables) .and. number < 0_c_int) then
      call new%problems%add('number: found ' // decimal_text(number) // ', expected 0 or more')
    else if (c_associated(tables)) then
      call c_f_pointer(tables, printed, [number])
      do i = 1, size(printed)
        if (printed(i) < 1 .or. printed(i) > size(request%keep_contacts)) then
          call new%problems%add('tables: found ' // decimal_text(printed(i)) // &
                                ', expected positions from 1 to 100')
        else
          request%keep_contacts(printed(i)) = .true.
        end if
      end do
    end if
    if (new%problems%count() == 0) then
      call run_in_arithmetic(trim(arithmetic_names(which)), deck, request, records, new%failure)
      if (allocated(new%failure)) then
        new%failure = text_of(path) // ': ' // new%failure
      else
        call write_report(records, request%keep_contacts, .false., report)
        call set_text(new, text_report, report%text())
      end if
      call set_text(new, text_notes, deck%notes%text() // records%notes%text())
    end if
    call finish(new)
  end function c_report

  !> `asperity_summits`.
  type(c_ptr) function c_summits(path, choices) bind(c, name='asperity_summits') result(handle)
    type(c_ptr), value :: path     !! height map
    type(c_ptr), value :: choices  !! `c_summits_options`; null: all defaults

    handle = summits_with_edge(path, choices, .false.)
  end function c_summits

  !> `asperity_periodic_summits`.
  type(c_ptr) function c_periodic_summits(path, choices) &
    bind(c, name='asperity_periodic_summits') result(handle)
    type(c_ptr), value :: path     !! height map that repeats itself
    type(c_ptr), value :: choices  !! `c_summits_options`; null: all defaults

    handle = summits_with_edge(path, choices, .true.)
  end function c_periodic_summits

  ! Summits of a map with a free or periodic edge.
  type(c_ptr) function summits_with_edge(path, choices, periodic) result(handle)
    type(c_ptr), intent(in) :: path, choices
    logical, intent(in) :: periodic
    type(outcome), pointer :: new
    type(c_summits_options), pointer :: options
    type(summit_choices) :: chosen
    type(height_map) :: map
    type(map_summits) :: summits
    type(map_statistics) :: found
    type(text_buffer) :: summary
    integer(int64) :: spikes

    call begin(new, handle)
    if (.not. associated(new)) return
    chosen%periodic = periodic
    if (c_associated(choices)) then
      call c_f_pointer(choices, options)
      call take_word('rule', options%rule, rule_names, chosen%rule, new%problems)
      call take_word('level', options%level, level_names, chosen%level, new%problems)
      call take_word('radius', options%radius, radius_names, chosen%radius, new%problems)
      call take_word('unit', options%unit, length_units, chosen%unit, new%problems)
      chosen%spacing = options%spacing
      chosen%despike = options%despike /= 0_c_int
    end if
    call require_text('map', path, new%problems)
    if (new%problems%count() == 0) &
      call summits_of_file(text_of(path), chosen, map, summits, spikes, new%problems, new%failure)
    if (new%problems%count() == 0 .and. .not. allocated(new%failure)) then
      call measure_map(map, summits, found)
      call write_summits_table(text_of(path), chosen, spikes, map, summits, found, summary)
      call set_text(new, text_report, summary%text())
      call set_text(new, text_notes, map%notes%text())
      associate (table => new%tables(table_summits))
        call set_surface(summits%x, summits%y, summits%height, summits%radius, table, map%unit)
      end associate
      associate (table => new%tables(table_statistics))
        call add_reals(table, 'samples', [real(found%samples, real64)])
        call add_reals(table, 'missing', [real(found%missing, real64)])
        call add_reals(table, 'spacing_x', map%spacing(1:1), map%unit)
        call add_reals(table, 'spacing_y', map%spacing(2:2), map%unit)
        call add_reals(table, 'rms_height', [found%rms_height], map%unit)
        call add_reals(table, 'rms_slope', [found%rms_slope])
        call add_reals(table, 'm0', [found%m0], power_of(map%unit, 2))
        call add_reals(table, 'm2_x', found%m2(1:1))
        call add_reals(table, 'm2_y', found%m2(2:2))
        call add_reals(table, 'm4_x', found%m4(1:1), power_of(map%unit, -2))
        call add_reals(table, 'm4_y', found%m4(2:2), power_of(map%unit, -2))
        call add_reals(table, 'alpha', [found%alpha])
        call add_reals(table, 'density', [found%density], power_of(map%unit, -2))
        call add_reals(table, 'mean_height', [found%mean_height], map%unit)
        call add_reals(table, 'height_deviation', [found%height_deviation], map%unit)
        call add_reals(table, 'mean_curvature', [found%mean_curvature], power_of(map%unit, -1))
        call add_reals(table, 'mean_radius', [found%mean_radius], map%unit)
        call add_reals(table, 'expected_density', [found%expected_density], power_of(map%unit, -2))
        call add_reals(table, 'expected_height', [found%expected_height], map%unit)
        call add_reals(table, 'expected_deviation', [found%expected_deviation], map%unit)
        call add_reals(table, 'expected_curvature', [found%expected_curvature], &
                       power_of(map%unit, -1))
      end associate
    end if
    call finish(new)
  end function summits_with_edge

  !> `asperity_generate`.
  type(c_ptr) function c_generate(path, groups, member) bind(c, name='asperity_generate') &
    result(handle)
    type(c_ptr), value :: path        !! specification, where `groups` is null
    type(c_ptr), value :: groups      !! text of a specification; may be null
    integer(c_int), value :: member   !! number in the ensemble, from 1
    type(outcome), pointer :: new
    type(generation_spec) :: spec
    type(surface_plan) :: plan
    type(generated_surface) :: surface
    real(real64), allocatable :: x(:), y(:), height(:), radius(:)
    integer :: side

    call begin(new, handle)
    if (.not. associated(new)) return
    if (c_associated(groups)) then
      call parse_generation_spec('specification', text_of(groups), spec, new%problems)
    else
      call require_text('specification', path, new%problems)
      if (new%problems%count() == 0) &
        call read_generation_spec(text_of(path), spec, new%problems)
    end if
    if (new%problems%count() == 0 .and. (member < 1 .or. member > spec%ensemble)) &
      call new%problems%add('surface: found ' // decimal_text(member) // &
                            ', which is not in the ' // &
                            'ensemble of ' // spec%file // ', expected a number from 1 to ' // &
                            decimal_text(spec%ensemble))
    do side = 1, 2
      if (new%problems%count() > 0 .or. allocated(new%failure)) exit
      call plan_surface(spec, side, plan)
      call generate_surface(plan, member, surface, new%failure)
      if (allocated(new%failure)) exit
      call surface%reals(x, y, height, radius)
      call set_surface(x, y, height, radius, new%tables(table_upper + side - 1), '')
    end do
    call finish(new)
  end function c_generate

  ! A power of a unit of length; empty where the unit is not known.
  pure function power_of(unit, power) result(text)
    character(len=*), intent(in) :: unit
    integer, intent(in) :: power
    character(len=:), allocatable :: text

    text = trim(unit)
    if (text == '') return
    if (abs(power) > 1) text = text // decimal_text(abs(power))
    if (power < 0) text = '1/' // text
  end function power_of

  subroutine set_surface(x, y, height, radius, table, unit)
    real(real64), intent(in) :: x(:), y(:), height(:), radius(:)
    type(array_table), intent(inout) :: table
    character(len=*), intent(in) :: unit  ! empty: not known

    call add_reals(table, 'x', x, trim(unit))
    call add_reals(table, 'y', y, trim(unit))
    call add_reals(table, 'height', height, trim(unit))
    call add_reals(table, 'radius', radius, trim(unit))
  end subroutine set_surface

  ! That an array is there.
  subroutine require_numbers(name, address, problems)
    character(len=*), intent(in) :: name
    type(c_ptr), intent(in) :: address
    type(problem_list), intent(inout) :: problems

    if (.not. c_associated(address)) call problems%add(name // ': found NULL, expected numbers')
  end subroutine require_numbers

  ! That the name of a file is there.
  subroutine require_text(name, address, problems)
    character(len=*), intent(in) :: name
    type(c_ptr), intent(in) :: address
    type(problem_list), intent(inout) :: problems

    if (.not. c_associated(address)) then
      call problems%add(name // ': found NULL, expected a path')
    else if (text_of(address) == '') then
      call problems%add(name // ': found an empty text, expected a path')
    end if
  end subroutine require_text

  ! A word of a list; a null pointer leaves the choice as it is.
  subroutine take_word(name, word, known, choice, problems)
    character(len=*), intent(in) :: name
    type(c_ptr), intent(in) :: word
    character(len=*), intent(in) :: known(:)
    integer, intent(inout) :: choice
    type(problem_list), intent(inout) :: problems
    character(len=:), allocatable :: list
    integer :: i

    if (.not. c_associated(word)) return
    choice = findloc(known == plain_unit(text_of(word)), .true., 1)
    if (choice > 0) return
    list = trim(known(1))
    do i = 2, size(known)
      list = list // ', ' // trim(known(i))
    end do
    call problems%add(name // ': found ' // text_of(word) // ', expected one of ' // list)
  end subroutine take_word

end module asperity_c
