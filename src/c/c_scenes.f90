!> The library for C: scenes, their solution, and fields on pixels; `include/asperity.h` has what
!> each procedure does.
!>
!> Every call gives one outcome, a handle, that holds all it brought: a scene, tables as arrays,
!> texts, problems; `asperity_c_answers` has what C reads of it. No call stops the process, prints,
!> or keeps anything for the next one.
!>
!> The name of a procedure for C must not be that of a module, as `asperity_solve` is one.
module asperity_c_scenes
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, &
                                          c_null_ptr, c_ptr
  use asperity, only: add_reals, add_wholes, array_table, build_scene, build_scene_of, &
                      check_field_request, check_options, contact_field, decimal_text, &
                      fields_none, list_warnings, make_arrays, name_units, &
                      of_contacts, of_positions, parse_scene, place_of, problem_list, &
                      read_scene, rebuild_scene, run_options, scene_results, scene_side, &
                      scene_surface, solve, text_buffer, write_summary
  use asperity_contact_field, only: contact_marks
  use asperity_decimal, only: decimal_to_real64
  use asperity_kinds, only: real64
  use asperity_map_stress, only: component_names, largest_shear, stress_solver, von_mises
  use asperity_c_arguments, only: require_text, take_asperities, take_heights
  use asperity_c_outcome, only: add_pixels, begin_outcome, finish_outcome, finish_scene, &
                                look_at, outcome, set_text, table_fields, table_map, text_notes, &
                                text_of, text_report, text_unit, text_warning_kinds, &
                                text_warnings
  use asperity_problems, only: real_text
  implicit none
  private

  public :: c_read_scene, c_build_scene, c_build_scene_of, c_rebuild_scene, c_solve, &
            c_solve_again, c_solve_with_fields, c_fields, c_stress
  public :: c_options, c_side

  !> `asperity_options` of the header.
  type, bind(c) :: c_options
    type(c_ptr) :: arithmetic        !! 'real64' or null
    real(c_double) :: accuracy       !! asked for; 0: none
    integer(c_int) :: totals_only    !! not 0: contacts are not kept
    integer(c_int) :: threads        !! 0: as many as OpenMP gives
    type(c_ptr) :: interrupt         !! a number that is not 0 when the work shall end; may be null
    type(c_ptr) :: accuracy_of       !! 'all', 'load', 'area' or null
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
    type(outcome), pointer :: new

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    !$omp critical (library_texts)
    allocate (new%scene_in)
    call require_text('scene', path, new%problems)
    if (new%problems%count() == 0) call read_scene(text_of(path), new%scene_in, new%problems)
    call finish_scene(new)
    !$omp end critical (library_texts)
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
    !$omp critical (library_texts)
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
    !$omp end critical (library_texts)
  end function c_build_scene

  !> `asperity_build_scene_of`.
  type(c_ptr) function c_build_scene_of(groups, upper, lower) &
    bind(c, name='asperity_build_scene_of') result(handle)
    type(c_ptr), value :: groups  !! text of the scene
    type(c_ptr), value :: upper   !! `c_side`; null: the text names it
    type(c_ptr), value :: lower   !! `c_side`; null: the text names it
    type(outcome), pointer :: new
    type(scene_side) :: sides(2)

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    !$omp critical (library_texts)
    allocate (new%scene_in)
    if (.not. c_associated(groups)) call new%problems%add('groups: found NULL, expected a text')
    call take_side('surfaces.upper', upper, sides(1))
    call take_side('surfaces.lower', lower, sides(2))
    if (new%problems%count() == 0 .and. .not. allocated(new%failure)) &
      call build_scene_of(sides, text_of(groups), new%scene_in, new%problems)
    call finish_scene(new)
    !$omp end critical (library_texts)

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

  end function c_build_scene_of

  !> `asperity_rebuild_scene`.
  type(c_ptr) function c_rebuild_scene(of_scene, groups) bind(c, name='asperity_rebuild_scene') &
    result(handle)
    type(c_ptr), value :: of_scene  !! outcome that has a scene
    type(c_ptr), value :: groups    !! text of all its groups
    type(outcome), pointer :: from, new

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    !$omp critical (library_texts)
    allocate (new%scene_in)
    call look_at(of_scene, from)
    if (associated(from)) call new%problems%append(from%problems)
    if (.not. associated(from)) then
      call new%problems%add('scene: found NULL, expected an outcome that has a scene')
    else if (.not. allocated(from%scene_in)) then
      call new%problems%add('scene: found an outcome without a scene, expected one that has it')
    end if
    if (.not. c_associated(groups)) call new%problems%add('groups: found NULL, expected a text')
    if (new%problems%count() == 0) &
      call rebuild_scene(from%scene_in, text_of(groups), new%scene_in, new%problems)
    call finish_scene(new)
    !$omp end critical (library_texts)
  end function c_rebuild_scene

  !> `asperity_solve_scene`.
  type(c_ptr) function c_solve(of_scene, options) bind(c, name='asperity_solve_scene') &
    result(handle)
    type(c_ptr), value :: of_scene  !! outcome that has a scene
    type(c_ptr), value :: options   !! `c_options`; null: all defaults

    handle = c_solve_with_fields(of_scene, options, c_null_ptr, c_null_ptr, 0_c_int)
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
    type(outcome), pointer :: before, from, new
    type(scene_results) :: results

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    chosen%fields = fields
    chosen%reuse%keeps = .true.
    call look_at(earlier, before)
    if (associated(before)) then
      if (allocated(before%solutions)) chosen%reuse%earlier => before%solutions
    end if
    if (c_associated(progress)) call c_f_pointer(progress, chosen%counted_work%numbers, [2])
    call look_at(of_scene, from)
    !$omp critical (library_texts)
    call check_request(from, options, chosen, new)
    !$omp end critical (library_texts)
    if (new%problems%count() == 0 .and. .not. allocated(new%failure)) &
      call solve(from%scene_in, results, new%failure, chosen)
    !$omp critical (library_texts)
    if (associated(from)) call set_results(from, chosen, results, new)
    call finish_outcome(new)
    !$omp end critical (library_texts)
  end function c_solve_with_fields

  ! Checks a scene and the options of its solve.
  subroutine check_request(from, options, chosen, new)
    type(outcome), pointer, intent(in) :: from
    type(c_ptr), intent(in) :: options
    type(run_options), intent(inout) :: chosen
    type(outcome), intent(inout) :: new

    if (associated(from)) call new%problems%append(from%problems)
    if (.not. associated(from)) then
      new%failure = 'no scene'
    else if (.not. allocated(from%scene_in)) then
      new%failure = 'no scene'
    else if (from%problems%count() == 0) then
      call set_options(options, chosen, new%problems)
      if (chosen%fields > fields_none) &
        call check_field_request(from%scene_in, 'fields', new%problems)
    end if
  end subroutine check_request

  ! Fills an outcome with the results of a solve, or with the place of its failure.
  subroutine set_results(from, chosen, results, new)
    type(outcome), intent(in) :: from
    type(run_options), intent(in) :: chosen
    type(scene_results), intent(inout) :: results
    type(outcome), intent(inout) :: new
    type(problem_list) :: kinds, warnings
    type(text_buffer) :: summary
    integer :: which

    if (.not. allocated(from%scene_in) .or. from%problems%count() > 0) return
    call set_text(new, text_notes, from%scene_in%notes%text())
    if (allocated(new%failure)) new%failure = from%scene_in%file // ': ' // new%failure
    if (new%problems%count() > 0 .or. allocated(new%failure)) return
    allocate (new%solutions(size(results%positions)))
    do which = 1, size(new%solutions)
      call move_alloc(results%positions(which)%start%solutions, new%solutions(which)%solutions)
      if (allocated(new%solutions(which)%solutions) .or. &
          .not. associated(chosen%reuse%earlier)) cycle
      if (which <= size(chosen%reuse%earlier)) &
        new%solutions(which) = chosen%reuse%earlier(which)
    end do
    call move_alloc(results%positions(1)%fields, new%fields)
    if (.not. decimal_to_real64(from%scene_in%contact_modulus) > 0.0_real64) &
      new%ratio = decimal_to_real64(from%scene_in%lower%poisson_ratio)
    call list_warnings(from%scene_in%file, results, warnings, kinds)
    call set_text(new, text_warnings, warnings%text())
    call set_text(new, text_warning_kinds, kinds%text())
    call write_summary(from%scene_in, results, summary)
    call set_text(new, text_report, summary%text())
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
    call check_options(chosen, problems)
    if (c_associated(options%interrupt)) &
      call c_f_pointer(options%interrupt, chosen%interrupt%number)
  end subroutine set_options

  !> `asperity_fields`.
  type(c_ptr) function c_fields(solved, position, state) bind(c, name='asperity_fields') &
    result(handle)
    type(c_ptr), value :: solved        !! outcome of a solve
    integer(c_int), value :: position   !! from 1
    integer(c_int), value :: state      !! from 1; -1: the last
    type(outcome), pointer :: from, new
    integer :: which

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    !$omp critical (library_texts)
    call choose_field(solved, position, state, from, new, which)
    if (which > 0) call set_field(new, from%fields(which), &
                                  unit_of_column(from%tables(of_positions), 'mean_gap'), &
                                  unit_of_column(from%tables(of_contacts), 'average_pressure'))
    call finish_outcome(new)
    !$omp end critical (library_texts)
  end function c_fields

  !> `asperity_stress`.
  type(c_ptr) function c_stress(solved, position, state, depth) bind(c, name='asperity_stress') &
    result(handle)
    type(c_ptr), value :: solved        !! outcome of a solve
    integer(c_int), value :: position   !! from 1
    integer(c_int), value :: state      !! from 1; -1: the last
    real(c_double), value :: depth      !! below the surface, more than 0
    type(outcome), pointer :: from, new
    type(stress_solver) :: solver
    real(real64), allocatable :: stress(:, :, :)
    integer :: which

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    !$omp critical (library_texts)
    call choose_field(solved, position, state, from, new, which)
    if (.not. (depth > 0.0_real64 .and. depth < huge(depth))) then
      call new%problems%add('depth: found ' // real_text(depth) // &
                            ', expected a number more than 0')
    else if (which > 0) then
      if (.not. allocated(from%ratio)) new%failure = &
        'stress needs poisson_ratio in &material: found contact_modulus in its place'
    end if
    !$omp end critical (library_texts)
    if (new%problems%count() == 0 .and. .not. allocated(new%failure)) then
      call solver%prepare(from%fields(which), from%ratio)
      call solver%solve(depth, stress)
    end if
    !$omp critical (library_texts)
    if (allocated(stress)) call set_stress(new, stress, unit_of_column(from%tables(of_contacts), &
                                                                     'average_pressure'))
    call finish_outcome(new)
    !$omp end critical (library_texts)
  end function c_stress

  ! Table of the stresses at one depth.
  subroutine set_stress(new, stress, unit)
    type(outcome), intent(inout) :: new
    real(real64), intent(in) :: stress(:, :, :)  ! (column, row, component)
    character(len=*), intent(in) :: unit
    real(real64), allocatable :: derived(:, :, :)
    integer :: i, j

    allocate (derived(size(stress, 1), size(stress, 2), 2))
    associate (table => new%tables(table_fields))
      do i = 1, size(component_names)
        call add_pixels(table, 'stress_' // component_names(i), stress(:, :, i), unit, new%failure)
      end do
      do j = 1, size(stress, 2)
        do i = 1, size(stress, 1)
          derived(i, j, :) = [von_mises(stress(i, j, :)), largest_shear(stress(i, j, :))]
        end do
      end do
      call add_pixels(table, 'von_mises', derived(:, :, 1), unit, new%failure)
      call add_pixels(table, 'largest_shear', derived(:, :, 2), unit, new%failure)
    end associate
  end subroutine set_stress

  ! Finds the fields of a state of an outcome; 0: there are none, and `new` has the reason.
  subroutine choose_field(solved, position, state, from, new, which)
    type(c_ptr), intent(in) :: solved
    integer, intent(in) :: position, state
    type(outcome), pointer, intent(out) :: from
    type(outcome), intent(inout) :: new
    integer, intent(out) :: which

    which = 0
    call look_at(solved, from)
    if (.not. associated(from)) then
      call new%problems%add('solved: found NULL, expected the outcome of a solve')
    else if (.not. allocated(from%fields)) then
      new%failure = 'no fields: expected a height map solved on its pixels, for instance ' // &
                    'with interaction = ''boundary'', or field_spacing in &surfaces for one ' // &
                    'position of asperities, and fields requested'
    else
      which = field_of(from%fields, position, state)
      if (which > 0) return
      if (position /= from%fields(1)%position) then
        call new%problems%add('position: found ' // decimal_text(position) // ', expected ' // &
                              decimal_text(from%fields(1)%position))
      else
        call new%problems%add('state: found ' // decimal_text(state) // ', expected ' // &
                              states_in_words(from%fields) // ', or -1 for the last')
      end if
    end if
  end subroutine choose_field

  ! The fields of a state; 0: there are none.
  pure integer function field_of(fields, position, state) result(which)
    type(contact_field), intent(in) :: fields(:)
    integer, intent(in) :: position, state

    which = size(fields)
    if (state == -1 .and. fields(which)%position == position) return
    do which = size(fields), 1, -1
      if (fields(which)%position == position .and. fields(which)%state == state) return
    end do
  end function field_of

  ! The numbers of the states.
  function states_in_words(fields) result(text)
    type(contact_field), intent(in) :: fields(:)
    character(len=:), allocatable :: text

    text = decimal_text(fields(1)%state)
    if (size(fields) > 1) text = 'a number from ' // text // ' to ' // &
                                 decimal_text(fields(size(fields))%state)
  end function states_in_words

  ! Tables and unit of one state.
  subroutine set_field(new, field, length, pressure)
    type(outcome), intent(inout) :: new
    type(contact_field), intent(in) :: field
    character(len=*), intent(in) :: length, pressure  ! units; empty: not known

    call set_text(new, text_unit, length)
    associate (table => new%tables(table_map))
      call add_wholes(table, 'columns', [field%columns])
      call add_wholes(table, 'rows', [field%rows])
      call add_reals(table, 'spacing_x', field%pixel_spacing(1:1), length)
      call add_reals(table, 'spacing_y', field%pixel_spacing(2:2), length)
      call add_reals(table, 'origin_x', field%origin(1:1), length)
      call add_reals(table, 'origin_y', field%origin(2:2), length)
      call add_wholes(table, 'boundary_contacts', [field%boundary_contacts])
      call add_wholes(table, 'hertz_contacts', [field%hertz_contacts])
    end associate
    associate (table => new%tables(table_fields))
      call add_pixels(table, 'pressure', field%pressure, pressure, new%failure)
      call add_pixels(table, 'gap', field%gap, length, new%failure)
      call add_pixels(table, 'displacement', field%displacement, length, new%failure)
      call add_marks('contact', contact_marks(field))
      if (allocated(field%traction)) then
        call add_pixels(table, 'traction', field%traction, pressure, new%failure)
        call add_marks('stick', field%sticks)
      end if
    end associate

  contains

    ! One column of 1 and 0, row by row of the map.
    subroutine add_marks(name, marks)
      character(len=*), intent(in) :: name
      logical, intent(in) :: marks(:, :)

      if (allocated(new%failure)) return
      call add_wholes(new%tables(table_fields), name, [merge(1, 0, marks)])
      new%tables(table_fields)%columns(size(new%tables(table_fields)%columns))%unit = ''
    end subroutine add_marks

  end subroutine set_field

  ! Unit of a column of a table; empty where it has none.
  pure function unit_of_column(table, name) result(unit)
    type(array_table), intent(in) :: table
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: unit
    integer :: i

    unit = ''
    if (.not. allocated(table%columns)) return
    i = place_of(table, name)
    if (i == 0) return
    if (allocated(table%columns(i)%unit)) unit = table%columns(i)%unit
  end function unit_of_column

end module asperity_c_scenes
