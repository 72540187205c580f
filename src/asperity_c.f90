!> The library for C, and for whatever calls C: `include/asperity.h` says what each procedure does.
!>
!> Every call here gives one outcome, a handle, that holds all it brought: a scene, tables as
!> arrays, texts, what went wrong; `asperity_c_answers` has what looks at it. Nothing stops the
!> process, prints, or is remembered between calls.
!>
!> The name of a procedure for C must not be that of a module, as `asperity_solve` is one.
module asperity_c
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_ptr
  use asperity, only: add_surface, arithmetic_names, build_scene, card_deck, check_field_request, &
                      check_options, decimal_text, fields_none, generate_surface, &
                      generated_surface, generation_spec, list_warning_kinds, list_warnings, &
                      make_arrays, name_units, of_contacts, original_records, &
                      original_request, parse_generation_spec, parse_scene, plan_surface, &
                      problem_list, read_card_deck, read_generation_spec, read_scene, &
                      run_in_arithmetic, run_options, scene_results, scene_surface, solve, &
                      surface_plan, text_buffer, thesis_tables, write_report, write_summary
  use asperity_c_arguments, only: require_text, take_asperities, take_word
  use asperity_c_outcome, only: begin_outcome, finish_outcome, finish_scene, look_at, outcome, &
                                set_text, table_upper, text_notes, text_of, &
                                text_report, text_warning_kinds, text_warnings
  use, intrinsic :: iso_fortran_env, only: real64
  implicit none
  private

  public :: c_read_scene, c_build_scene, c_solve, c_solve_again, c_solve_with_fields, &
            c_report, c_generate
  public :: c_options

  !> `asperity_options` of the header.
  type, bind(c) :: c_options
    type(c_ptr) :: arithmetic        !! 'real64' or null
    real(c_double) :: accuracy       !! asked for; 0: none
    integer(c_int) :: totals_only    !! not 0: contacts are not kept
    integer(c_int) :: threads        !! 0: as many as OpenMP gives
    type(c_ptr) :: interrupt         !! a number that is not 0 when the work shall end; may be null
    type(c_ptr) :: accuracy_of       !! 'all', 'load', 'area' or null
  end type c_options

contains

  !> `asperity_read_scene`.
  type(c_ptr) function c_read_scene(path) bind(c, name='asperity_read_scene') result(handle)
    type(c_ptr), value :: path  !! of a scene or a card deck
    type(outcome), pointer :: new

    call begin_outcome(new, handle)
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

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    allocate (new%scene_in)
    if (.not. c_associated(groups)) call new%problems%add('groups: found NULL, expected a text')
    if (.not. (c_associated(upper) .or. c_associated(lower))) then
      if (new%problems%count() == 0) &
        call parse_scene('scene', text_of(groups), new%scene_in, new%problems)
    else
      call take_asperities('surfaces.upper', upper, surfaces(1), new%problems)
      call take_asperities('surfaces.lower', lower, surfaces(2), new%problems)
      if (new%problems%count() == 0) &
        call build_scene(surfaces(1), surfaces(2), text_of(groups), new%scene_in, new%problems)
    end if
    call finish_scene(new)
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

    handle = c_solve_with_fields(of_scene, options, earlier, progress, 0_c_int)
  end function c_solve_again

  !> `asperity_solve_with_fields`.
  type(c_ptr) function c_solve_with_fields(of_scene, options, earlier, progress, fields) &
    bind(c, name='asperity_solve_with_fields') result(handle)
    type(c_ptr), value :: of_scene     !! outcome that has a scene
    type(c_ptr), value :: options      !! `c_options`; null: all defaults
    type(c_ptr), value :: earlier      !! outcome of a solve; or null
    type(c_ptr), value :: progress     !! two numbers; or null
    integer(c_int), value :: fields    !! 0: none are kept; 1: those of the last state; 2: all
    type(run_options) :: chosen
    type(outcome), pointer :: before

    chosen%fields = fields
    call look_at(earlier, before)
    if (associated(before)) then
      if (allocated(before%solutions)) chosen%reuse%earlier => before%solutions
    end if
    if (c_associated(progress)) call c_f_pointer(progress, chosen%counted_work%numbers, [2])
    handle = solve_chosen(of_scene, options, chosen)
  end function c_solve_with_fields

  ! Solves a scene; some choices of the run may be made already.
  type(c_ptr) function solve_chosen(of_scene, options, chosen) result(handle)
    type(c_ptr), intent(in) :: of_scene, options
    type(run_options), intent(inout) :: chosen
    type(outcome), pointer :: from, new
    type(scene_results) :: results
    type(problem_list) :: kinds, warnings
    type(text_buffer) :: summary
    integer :: which

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    call look_at(of_scene, from)
    if (associated(from)) call new%problems%append(from%problems)
    if (.not. associated(from)) then
      new%failure = 'no scene'
    else if (.not. allocated(from%scene_in)) then
      new%failure = 'no scene'
    else if (from%problems%count() == 0) then
      call set_options(options, chosen, new%problems)
      if (chosen%fields > fields_none) &
        call check_field_request(from%scene_in, 'fields', new%problems)
      chosen%reuse%keeps = .true.
      if (new%problems%count() == 0) call solve(from%scene_in, results, new%failure, chosen)
      if (allocated(new%failure)) new%failure = from%scene_in%file // ': ' // new%failure
      call set_text(new, text_notes, from%scene_in%notes%text())
    end if
    if (new%problems%count() == 0 .and. .not. allocated(new%failure)) then
      allocate (new%solutions(size(results%positions)))
      do which = 1, size(new%solutions)
        call move_alloc(results%positions(which)%start%solutions, new%solutions(which)%solutions)
        if (allocated(new%solutions(which)%solutions) .or. &
            .not. associated(chosen%reuse%earlier)) cycle
        if (which <= size(chosen%reuse%earlier)) &
          new%solutions(which) = chosen%reuse%earlier(which)
      end do
      call move_alloc(results%positions(1)%fields, new%fields)
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
    call finish_outcome(new)
  end function solve_chosen

  ! Reads the options of a run. A value out of its range is a problem.
  subroutine set_options(given, chosen, problems)
    type(c_ptr), intent(in) :: given
    type(run_options), intent(inout) :: chosen
    type(problem_list), intent(inout) :: problems
    type(c_options), pointer :: options

    if (.not. c_associated(given)) call check_options(chosen, problems)
    if (.not. c_associated(given)) return
    call c_f_pointer(given, options)
    if (c_associated(options%arithmetic)) then
      if (text_of(options%arithmetic) /= 'real64') &
        call problems%add('arithmetic: found ' // text_of(options%arithmetic) // ', expected ' // &
                          'real64: a scene is solved in real64 only; the report of a card ' // &
                          'deck has other arithmetics')
    end if
    chosen%accuracy = options%accuracy
    if (c_associated(options%accuracy_of)) chosen%accuracy_of = text_of(options%accuracy_of)
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

    call begin_outcome(new, handle)
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
    call finish_outcome(new)
  end function c_report

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

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    if (c_associated(groups)) then
      call parse_generation_spec('specification', text_of(groups), spec, new%problems)
    else
      call require_text('specification', path, new%problems)
      if (new%problems%count() == 0) &
        call read_generation_spec(text_of(path), spec, new%problems)
    end if
    if (new%problems%count() == 0 .and. spec%is_map) &
      call new%problems%add(spec%file // ': found a height map, expected surfaces: ' // &
                            'asperity_generate_map makes maps')
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
      call add_surface(x, y, height, radius, new%tables(table_upper + side - 1), '')
    end do
    call finish_outcome(new)
  end function c_generate

end module asperity_c
