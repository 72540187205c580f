!> The library for C: height maps, as files and as arrays, in scenes and by their summits.
module asperity_c_maps
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_ptr
  use, intrinsic :: iso_fortran_env, only: int64, real64
  use asperity, only: add_reals, add_surface, add_wholes, build_scene_of, decimal_text, height_map, &
                      is_measured, length_units, level_names, map_statistics, map_summits, &
                      measure_map, not_enough_memory, note_of_file, periodic_edge, &
                      problem_list, put_in_unit, &
                      radius_names, read_height_map, rule_names, scene_side, summit_choices, &
                      summits_of_array, summits_of_file, text_buffer, write_map_file, &
                      write_summits_table
  use asperity_c_arguments, only: require_text, take_asperities, take_heights, take_word
  use asperity_c_outcome, only: begin_outcome, finish_outcome, finish_scene, outcome, &
                                set_text, table_map, table_pixels, table_statistics, &
                                table_summits, text_notes, text_of, text_report, text_unit
  implicit none
  private

  public :: c_build_scene_of, c_summits, c_periodic_summits, c_summits_of_map, c_read_map, &
            c_write_map
  public :: c_side, c_summits_options, power_of, set_map

  !> `asperity_side` of the header.
  type, bind(c) :: c_side
    type(c_ptr) :: asperities  !! `c_surface`, or null
    type(c_ptr) :: map         !! `c_height_map`, or null
  end type c_side

  !> `asperity_summits_options` of the header.
  type, bind(c) :: c_summits_options
    type(c_ptr) :: rule, level, radius, unit  !! names; null: the default
    real(c_double) :: pixel_spacing(2)        !! distances of a matrix; 0 elsewhere
    integer(c_int) :: despike                 !! not 0: single outliers are removed
  end type c_summits_options

contains

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
    allocate (new%scene_in)
    if (.not. c_associated(groups)) call new%problems%add('groups: found NULL, expected a text')
    call take_side('surfaces.upper', upper, sides(1))
    call take_side('surfaces.lower', lower, sides(2))
    if (new%problems%count() == 0 .and. .not. allocated(new%failure)) &
      call build_scene_of(sides, text_of(groups), new%scene_in, new%problems)
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

  end function c_build_scene_of

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
    type(summit_choices) :: chosen
    type(height_map) :: map
    type(map_summits) :: summits
    integer(int64) :: spikes

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    chosen%periodic = periodic
    chosen%edge_of_file = .true.
    call set_choices(choices, chosen, new%problems)
    call require_text('map', path, new%problems)
    if (new%problems%count() == 0) &
      call summits_of_file(text_of(path), chosen, map, summits, spikes, new%problems, new%failure)
    call finish_summits(new, text_of(path), chosen, spikes, map, summits)
  end function summits_with_edge

  !> `asperity_summits_of_map`.
  type(c_ptr) function c_summits_of_map(given, choices) bind(c, name='asperity_summits_of_map') &
    result(handle)
    type(c_ptr), value :: given    !! `c_height_map`
    type(c_ptr), value :: choices  !! `c_summits_options`; null: all defaults
    type(outcome), pointer :: new
    type(summit_choices) :: chosen
    type(height_map) :: map
    type(map_summits) :: summits
    integer(int64) :: spikes

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    call set_choices(choices, chosen, new%problems)
    call take_heights('map', given, map, new%problems, new%failure)
    if (new%problems%count() == 0 .and. .not. allocated(new%failure)) &
      call summits_of_array(map, chosen, summits, spikes, new%problems, new%failure)
    call finish_summits(new, 'map', chosen, spikes, map, summits)
  end function c_summits_of_map

  ! The choices for summits.
  subroutine set_choices(given, chosen, problems)
    type(c_ptr), intent(in) :: given
    type(summit_choices), intent(inout) :: chosen
    type(problem_list), intent(inout) :: problems
    type(c_summits_options), pointer :: options

    if (.not. c_associated(given)) return
    call c_f_pointer(given, options)
    call take_word('rule', options%rule, rule_names, chosen%rule, problems)
    call take_word('level', options%level, level_names, chosen%level, problems)
    call take_word('radius', options%radius, radius_names, chosen%radius, problems)
    call take_word('unit', options%unit, length_units, chosen%unit, problems)
    chosen%pixel_spacing = options%pixel_spacing
    chosen%despike = options%despike /= 0_c_int
  end subroutine set_choices

  ! The tables and texts of summits that were found.
  subroutine finish_summits(new, name, chosen, spikes, map, summits)
    type(outcome), intent(inout) :: new
    character(len=*), intent(in) :: name
    type(summit_choices), intent(in) :: chosen
    integer(int64), intent(in) :: spikes
    type(height_map), intent(in) :: map
    type(map_summits), intent(in) :: summits
    type(map_statistics) :: found
    type(text_buffer) :: summary

    if (new%problems%count() == 0 .and. .not. allocated(new%failure)) then
      call measure_map(map, summits, found)
      call write_summits_table(name, chosen, spikes, map, summits, found, summary)
      call set_text(new, text_report, summary%text())
      call set_text(new, text_notes, map%notes%text())
      associate (table => new%tables(table_summits))
        call add_surface(summits%x, summits%y, summits%height, summits%radius, table, map%unit)
      end associate
      associate (table => new%tables(table_statistics))
        call add_reals(table, 'samples', [real(found%samples, real64)])
        call add_reals(table, 'missing', [real(found%missing, real64)])
        call add_reals(table, 'slopes_left_out', [found%slopes_left_out])
        call add_reals(table, 'spacing_x', map%pixel_spacing(1:1), map%unit)
        call add_reals(table, 'spacing_y', map%pixel_spacing(2:2), map%unit)
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
    call finish_outcome(new)
  end subroutine finish_summits

  !> A power of a unit of length; empty where the unit is not known.
  pure function power_of(unit, power) result(text)
    character(len=*), intent(in) :: unit     !! name of the unit
    integer, intent(in) :: power             !! exponent, not 0
    character(len=:), allocatable :: text    !! for instance `1/um2`

    text = trim(unit)
    if (text == '') return
    if (abs(power) > 1) text = text // decimal_text(abs(power))
    if (power < 0) text = '1/' // text
  end function power_of

  !> `asperity_read_map`.
  type(c_ptr) function c_read_map(path, along, unit) bind(c, name='asperity_read_map') &
    result(handle)
    type(c_ptr), value :: path   !! height map
    type(c_ptr), value :: along  !! spacing along x and y; null: that of the file
    type(c_ptr), value :: unit   !! name; null: that of the file
    type(outcome), pointer :: new
    type(height_map) :: map
    real(c_double), pointer :: given(:)
    real(real64) :: pixel_spacing(2)
    integer :: which

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    call require_text('map', path, new%problems)
    which = 0
    call take_word('unit', unit, length_units, which, new%problems)
    pixel_spacing = 0.0_real64
    if (c_associated(along)) then
      call c_f_pointer(along, given, [2])
      pixel_spacing = given
    end if
    if (new%problems%count() == 0) &
      call read_height_map(text_of(path), pixel_spacing, .false., map, new%problems, &
                           new%failure)
    if (new%problems%count() == 0 .and. .not. allocated(new%failure)) then
      call put_in_unit(map, which)
      call set_map(new, text_of(path), map)
    end if
    call finish_outcome(new)
  end function c_read_map

  !> Fills the tables and texts of a map. Missing pixels are NaN there.
  subroutine set_map(new, name, map)
    type(outcome), intent(inout) :: new    !! outcome with them, or with a failure
    character(len=*), intent(in) :: name   !! name of the map, for a message
    type(height_map), intent(in) :: map    !! map that is returned
    integer :: row, status

    call set_text(new, text_unit, map%unit)
    call set_text(new, text_notes, map%notes%text())
    associate (table => new%tables(table_map))
      call add_wholes(table, 'columns', [map%columns])
      call add_wholes(table, 'rows', [map%rows])
      call add_reals(table, 'spacing_x', map%pixel_spacing(1:1), map%unit)
      call add_reals(table, 'spacing_y', map%pixel_spacing(2:2), map%unit)
      call add_wholes(table, 'periodic', [merge(1, 0, map%edge == periodic_edge)])
    end associate
    associate (table => new%tables(table_pixels))
      allocate (table%columns(1))
      table%columns(1)%name = 'height'
      table%columns(1)%unit = map%unit
      allocate (table%columns(1)%reals(size(map%height)), stat=status)
      if (status /= 0) then
        new%failure = name // ': ' // not_enough_memory // ' for the heights as an array'
        deallocate (table%columns)
        return
      end if
      table%rows = size(map%height)
      do row = 1, map%rows
        table%columns(1)%reals((row - 1) * map%columns + 1:row * map%columns) = &
          merge(map%height(:, row), ieee_value(0.0_real64, ieee_quiet_nan), &
                is_measured(map%height(:, row)))
      end do
    end associate
  end subroutine set_map

  !> `asperity_write_map`.
  type(c_ptr) function c_write_map(given, path) bind(c, name='asperity_write_map') result(handle)
    type(c_ptr), value :: given  !! `c_height_map`
    type(c_ptr), value :: path   !! the file
    type(outcome), pointer :: new
    type(height_map) :: map

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    call require_text('path', path, new%problems)
    call take_heights('map', given, map, new%problems, new%failure)
    if (new%problems%count() == 0 .and. .not. allocated(new%failure)) &
      call write_map_file(text_of(path), map, new%problems, new%failure)
    call set_text(new, text_notes, note_of_file(text_of(path), map))
    call finish_outcome(new)
  end function c_write_map

end module asperity_c_maps
