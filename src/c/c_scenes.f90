!> The library for C: scenes and their solution; `include/asperity.h` has what each procedure does.
!>
!> Every call gives one outcome, a handle, that holds all it brought: a scene, tables as arrays,
!> texts, problems; `asperity_c_outcome` has what C reads of it. No call stops the process, prints,
!> or keeps anything for the next one.
!>
!> The name of a procedure for C must not be that of a module, as `asperity_solve` is one.
module asperity_c_scenes
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_ptr
  use asperity, only: build_scene_of, check_field_request, check_options, fields_none, &
                      input_file, keep_checksums, list_inputs, list_warnings, make_arrays, &
                      name_units, of_contacts, problem_list, read_scene, rebuild_scene, &
                      run_options, scene_results, scene_side, solve, text_buffer, write_summary
  use asperity_accuracy_table, only: write_accuracy_csv, write_accuracy_table
  use asperity_kinds, only: real64
  use asperity_method_study, only: method_table, study_scene
  use asperity_problems, only: real_text
  use asperity_c_arguments, only: require_text, take_asperities, take_heights
  use asperity_c_outcome, only: begin_outcome, finish_outcome, finish_scene, look_at, outcome, &
                                set_text, text_methods, text_notes, text_of, text_report, &
                                text_scene, text_warning_kinds, text_warnings
  use asperity_library_turn, only: library_turn
  use asperity_results_json, only: write_json_scene
  implicit none
  private

  public :: c_read_scene, c_build_scene, c_rebuild_scene, c_solve, c_study
  public :: c_options, c_side

  !> `asperity_options` of the header.
  type, bind(c) :: c_options
    type(c_ptr) :: arithmetic        !! 'real64' or null
    real(c_double) :: accuracy       !! asked for; 0: none
    integer(c_int) :: totals_only    !! not 0: contacts are not kept
    integer(c_int) :: threads        !! 0: as many as OpenMP gives
    type(c_ptr) :: interrupt         !! a number that is not 0 when the work shall end; may be null
    type(c_ptr) :: accuracy_of       !! one of `totals_of_accuracy` or null
    type(c_ptr) :: progress          !! two numbers; or null
    integer(c_int) :: fields         !! 0: none are kept; 1: those of the last state; 2: all
  end type c_options

  !> `asperity_side` of the header.
  type, bind(c) :: c_side
    type(c_ptr) :: asperities  !! `c_surface`, or null
    type(c_ptr) :: map         !! `c_height_map`, or null
  end type c_side

contains

  !> `asperity_read_scene`.
  type(c_ptr) function c_read_scene(path) bind(c, name='asperity_read_scene') result(handle)
    type(c_ptr), value :: path  !! of a scene or a card deck
    type(library_turn) :: turn
    type(outcome), pointer :: new

    call begin_outcome(new, handle, turn)
    if (.not. associated(new)) return
    allocate (new%scene_in)
    call require_text('scene', path, new%problems)
    if (new%problems%count() == 0) call read_scene(text_of(path), new%scene_in, new%problems)
    if (new%problems%count() == 0) call keep_checksums(new%scene_in)
    call finish_scene(new)
  end function c_read_scene

  !> `asperity_build_scene`.
  type(c_ptr) function c_build_scene(groups, upper, lower) bind(c, name='asperity_build_scene') &
    result(handle)
    type(c_ptr), value :: groups  !! text of the scene
    type(c_ptr), value :: upper, lower  !! `c_side`; null: the text names it
    type(library_turn) :: turn
    type(outcome), pointer :: new
    type(scene_side) :: sides(2)

    call begin_outcome(new, handle, turn)
    if (.not. associated(new)) return
    allocate (new%scene_in)
    if (.not. c_associated(groups)) call new%problems%add('groups: found NULL, expected a text')
    call take_side('surfaces.upper', upper, sides(1))
    call take_side('surfaces.lower', lower, sides(2))
    if (new%is_good()) call build_scene_of(sides, text_of(groups), new%scene_in, new%problems)
    call finish_scene(new)

  contains

    subroutine take_side(which, given, side)
      character(len=*), intent(in) :: which
      type(c_ptr), intent(in) :: given
      type(scene_side), intent(inout) :: side
      type(c_side), pointer :: numbers
      character(len=:), allocatable :: failure

      if (.not. c_associated(given)) return
      call c_f_pointer(given, numbers)
      if (c_associated(numbers%asperities) .and. c_associated(numbers%map)) then
        call new%problems%add(which // ': found asperities and a map, expected one of them')
      else if (c_associated(numbers%asperities)) then
        allocate (side%surface)
        call take_asperities(which, numbers%asperities, side%surface, new%problems)
      else if (c_associated(numbers%map)) then
        allocate (side%map)
        call take_heights(which, numbers%map, side%map, new%problems, failure)
        if (allocated(failure)) call move_alloc(failure, new%failure)
      end if
    end subroutine take_side

  end function c_build_scene

  !> `asperity_rebuild_scene`.
  type(c_ptr) function c_rebuild_scene(of_scene, groups) bind(c, name='asperity_rebuild_scene') &
    result(handle)
    type(c_ptr), value :: of_scene  !! outcome that has a scene
    type(c_ptr), value :: groups    !! text of all its groups
    type(library_turn) :: turn
    type(outcome), pointer :: from, new

    call begin_outcome(new, handle, turn)
    if (.not. associated(new)) return
    allocate (new%scene_in)
    call look_at(of_scene, from)
    if (associated(from)) call new%problems%append(from%problems)
    if (.not. associated(from)) then
      call new%problems%add('scene: found NULL, expected an outcome that has a scene')
    else if (.not. has_scene(from)) then
      call new%problems%add('scene: found an outcome without a scene, expected one that has it')
    end if
    if (.not. c_associated(groups)) call new%problems%add('groups: found NULL, expected a text')
    if (new%problems%count() == 0) &
      call rebuild_scene(from%scene_in, text_of(groups), new%scene_in, new%problems)
    call finish_scene(new)
  end function c_rebuild_scene

  !> `asperity_solve_scene`.
  type(c_ptr) function c_solve(of_scene, options) bind(c, name='asperity_solve_scene') &
    result(handle)
    type(c_ptr), value :: of_scene  !! outcome that has a scene
    type(c_ptr), value :: options   !! `c_options`; null: all defaults
    type(run_options) :: chosen
    type(library_turn) :: turn
    type(outcome), pointer :: from, new
    type(scene_results) :: results

    call begin_outcome(new, handle, turn)
    if (.not. associated(new)) return
    call look_at(of_scene, from)
    if (associated(from)) call new%problems%append(from%problems)
    if (.not. has_scene(from)) then
      new%failure = 'no scene'
    else if (from%problems%count() == 0) then
      call set_options(options, chosen, new%problems)
      if (chosen%fields > fields_none) &
        call check_field_request(from%scene_in, 'fields', new%problems)
    end if
    call turn%finish()
    if (new%is_good()) call solve(from%scene_in, results, new%failure, chosen)
    call turn%begin()
    if (associated(from)) call set_results(from, results, new)
    call finish_outcome(new)
  end function c_solve

  !> `asperity_study_scene`.
  type(c_ptr) function c_study(of_scene, seconds, finest) bind(c, name='asperity_study_scene') &
    result(handle)
    type(c_ptr), value :: of_scene        !! outcome that has a scene
    real(c_double), value :: seconds      !! time that may be spent, s
    integer(c_int), value :: finest       !! of a map: 1, or 2: pixels half as wide too
    type(library_turn) :: turn
    type(outcome), pointer :: from, new
    type(method_table) :: methods
    type(text_buffer) :: report, rows

    call begin_outcome(new, handle, turn)
    if (.not. associated(new)) return
    call look_at(of_scene, from)
    if (associated(from)) call new%problems%append(from%problems)
    if (.not. (seconds > 0 .and. seconds <= huge(seconds))) &
      call new%problems%add('seconds: found ' // real_text(real(seconds, real64)) // &
                            ', expected more than 0')
    if (.not. has_scene(from)) new%failure = 'no scene'
    call turn%finish()
    if (new%is_good()) &
      call study_scene(from%scene_in, real(seconds, real64), real(max(1, min(2, finest)), real64), &
                       .false., methods, new%failure)
    call turn%begin()
    if (new%is_good()) then
      call write_accuracy_table(from%scene_in, methods, report)
      call set_text(new, text_report, report%text())
      call write_accuracy_csv(methods, rows)
      call set_text(new, text_methods, rows%text())
    end if
    call finish_outcome(new)
  end function c_study

  ! Whether an outcome has a scene.
  logical function has_scene(from)
    type(outcome), pointer, intent(in) :: from

    has_scene = .false.
    if (associated(from)) has_scene = allocated(from%scene_in)
  end function has_scene

  ! Fills an outcome with the results of a solve, or with the place of its failure.
  subroutine set_results(from, results, new)
    type(outcome), intent(in) :: from
    type(scene_results), intent(inout) :: results
    type(outcome), intent(inout) :: new
    type(problem_list) :: kinds, warnings
    type(input_file) :: inputs(3)
    type(text_buffer) :: about, summary
    character(len=:), allocatable :: unread
    integer :: which

    if (.not. allocated(from%scene_in) .or. from%problems%count() > 0) return
    call set_text(new, text_notes, from%scene_in%notes%text())
    if (allocated(new%failure)) new%failure = from%scene_in%file // ': ' // new%failure
    if (.not. new%is_good()) return
    allocate (new%kept(size(results%positions)))
    do which = 1, size(new%kept)
      call move_alloc(results%positions(which)%fields, new%kept(which)%fields)
    end do
    call list_warnings(from%scene_in%file, results, warnings, kinds)
    call set_text(new, text_warnings, warnings%text())
    call set_text(new, text_warning_kinds, kinds%text())
    call write_summary(from%scene_in, results, summary)
    call set_text(new, text_report, summary%text())
    call list_inputs(from%scene_in, inputs, unread)
    call write_json_scene(from%scene_in, inputs, results, about)
    call set_text(new, text_scene, about%text())
    do which = 1, of_contacts
      if (.not. allocated(new%failure)) call make_arrays(which, results, new%tables(which), &
                                                         new%failure)
      if (.not. allocated(new%failure)) call name_units(from%scene_in, new%tables(which))
    end do
  end subroutine set_results

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
    chosen%fields = options%fields
    call check_options(chosen, problems)
    if (c_associated(options%progress)) &
      call c_f_pointer(options%progress, chosen%counted_work%numbers, [2])
    if (c_associated(options%interrupt)) &
      call c_f_pointer(options%interrupt, chosen%interrupt%number)
  end subroutine set_options

end module asperity_c_scenes
