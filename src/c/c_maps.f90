!> The library for C: height maps, as files and as arrays, their spectra and summits.
module asperity_c_maps
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, &
                                          c_ptr
  use, intrinsic :: iso_fortran_env, only: int64, real64
  use asperity, only: add_reals, add_statistics, add_surface, add_wholes, generate_map, &
                      generation_spec, height_map, length_power, length_units, level_map, &
                      level_names, map_statistics, map_summits, measure_map, measure_spectra, &
                      note_of_file, periodic_edge, power_spectrum, problem_list, put_in_unit, &
                      radius_names, read_height_map, rule_names, summit_choices, &
                      summits_of_array, summits_of_file, text_buffer, usual_level, &
                      write_map_file, write_summits_table
  use asperity_c_arguments, only: require_text, take_heights, take_spec, take_word
  use asperity_c_outcome, only: add_pixels, begin_outcome, finish_outcome, outcome, set_text, &
                                table_map, table_pixels, table_spectra, table_statistics, &
                                table_summits, text_notes, text_of, text_report, text_unit
  use asperity_library_turn, only: library_turn
  implicit none
  private

  public :: c_generate_map, c_power_spectrum, c_read_map, c_write_map
  public :: c_summits, c_summits_options

  !> `asperity_summits_options` of the header.
  type, bind(c) :: c_summits_options
    type(c_ptr) :: rule, level, radius, unit  !! names; null: the default
    real(c_double) :: pixel_spacing(2)        !! distances of a matrix; 0 elsewhere
    integer(c_int) :: despike                 !! not 0: single outliers are removed
    integer(c_int) :: periodic                !! not 0: the map of a file repeats itself
  end type c_summits_options

contains

  !> `asperity_read_map`.
  type(c_ptr) function c_read_map(path, along, unit) bind(c, name='asperity_read_map') &
    result(handle)
    type(c_ptr), value :: path   !! height map
    type(c_ptr), value :: along  !! spacing along x and y; null: that of the file
    type(c_ptr), value :: unit   !! name; null: that of the file
    type(library_turn) :: turn
    type(outcome), pointer :: new
    type(height_map) :: map
    real(c_double), pointer :: given(:)
    real(real64) :: pixel_spacing(2)
    integer :: which

    call begin_outcome(new, handle, turn)
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
                           new%failure, unit=which)
    if (new%is_good()) then
      call put_in_unit(map, which)
      call set_map(new, text_of(path), map)
    end if
    call finish_outcome(new)
  end function c_read_map

  ! Fills the tables and texts of a map. Missing pixels are NaN there.
  subroutine set_map(new, name, map)
    type(outcome), intent(inout) :: new
    character(len=*), intent(in) :: name
    type(height_map), intent(in) :: map

    call set_text(new, text_unit, map%unit)
    call set_text(new, text_notes, map%notes%text())
    associate (table => new%tables(table_map))
      call add_wholes(table, 'columns', [map%columns])
      call add_wholes(table, 'rows', [map%rows])
      call add_reals(table, 'spacing_x', map%pixel_spacing(1:1), map%unit)
      call add_reals(table, 'spacing_y', map%pixel_spacing(2:2), map%unit)
      call add_wholes(table, 'periodic', [merge(1, 0, map%edge == periodic_edge)])
    end associate
    call add_pixels(new%tables(table_pixels), 'height', map%height, map%unit, new%failure)
    if (allocated(new%failure)) new%failure = name // ': ' // new%failure
  end subroutine set_map

  !> `asperity_write_map`.
  type(c_ptr) function c_write_map(given, path) bind(c, name='asperity_write_map') result(handle)
    type(c_ptr), value :: given  !! `c_height_map`
    type(c_ptr), value :: path   !! the file
    type(library_turn) :: turn
    type(outcome), pointer :: new
    type(height_map) :: map

    call begin_outcome(new, handle, turn)
    if (.not. associated(new)) return
    call require_text('path', path, new%problems)
    call take_heights('map', given, map, new%problems, new%failure)
    if (new%is_good()) call write_map_file(text_of(path), map, new%problems, new%failure)
    call set_text(new, text_notes, note_of_file(text_of(path), map))
    call finish_outcome(new)
  end function c_write_map

  !> `asperity_generate_map`.
  type(c_ptr) function c_generate_map(path, groups) bind(c, name='asperity_generate_map') &
    result(handle)
    type(c_ptr), value :: path    !! specification, where `groups` is null
    type(c_ptr), value :: groups  !! text of a specification; may be null
    type(library_turn) :: turn
    type(outcome), pointer :: new
    type(generation_spec) :: spec
    type(height_map) :: map

    call begin_outcome(new, handle, turn)
    if (.not. associated(new)) return
    call take_spec(path, groups, spec, new%problems)
    if (new%problems%count() == 0 .and. .not. spec%is_map) &
      call new%problems%add(spec%file // ': found surfaces, expected a group &map')
    if (new%problems%count() == 0) then
      call generate_map(spec%map, map, new%failure)
      if (allocated(new%failure)) then
        new%failure = spec%file // ': ' // new%failure
      else
        call set_map(new, spec%file, map)
      end if
    end if
    call finish_outcome(new)
  end function c_generate_map

  !> `asperity_power_spectrum`.
  type(c_ptr) function c_power_spectrum(given, level) bind(c, name='asperity_power_spectrum') &
    result(handle)
    type(c_ptr), value :: given  !! `c_height_map`
    type(c_ptr), value :: level  !! name; null: that of the edge of the map
    type(library_turn) :: turn
    type(outcome), pointer :: new
    type(height_map) :: map
    type(power_spectrum) :: spectra(3)
    integer :: chosen, k

    call begin_outcome(new, handle, turn)
    if (.not. associated(new)) return
    call take_heights('map', given, map, new%problems, new%failure)
    if (new%problems%count() == 0 .and. .not. all(map%pixel_spacing > 0.0)) &
      call new%problems%add('map.spacing: found 0, 0, expected the spacing of the pixels')
    map%periodic = map%edge == periodic_edge
    chosen = usual_level(map%periodic)
    call take_word('level', level, level_names, chosen, new%problems)
    if (new%is_good()) then
      call level_map(map, chosen)
      call measure_spectra('map', map, spectra, new%problems, new%failure)
    end if
    if (new%is_good()) then
      call set_text(new, text_unit, map%unit)
      do k = 1, size(spectra)
        associate (table => new%tables(table_spectra + k - 1), from => spectra(k))
          call add_reals(table, 'q', from%q, length_power(map%unit, -1))
          if (k == 1) call add_reals(table, 'c_iso', from%c, length_power(map%unit, 4))
          if (k > 1) call add_reals(table, 'c_1d', from%c, length_power(map%unit, 3))
          call add_wholes(table, 'number', from%number)
        end associate
      end do
    end if
    call finish_outcome(new)
  end function c_power_spectrum

  !> `asperity_summits`.
  type(c_ptr) function c_summits(path, given, choices) bind(c, name='asperity_summits') &
    result(handle)
    type(c_ptr), value :: path     !! of a height map
    type(c_ptr), value :: given    !! `c_height_map` in its place; null: that of the file
    type(c_ptr), value :: choices  !! `c_summits_options`; null: all defaults
    type(library_turn) :: turn
    type(outcome), pointer :: new
    type(summit_choices) :: chosen
    type(height_map) :: map
    type(map_summits) :: summits
    type(map_statistics) :: found
    type(text_buffer) :: summary
    character(len=:), allocatable :: name
    integer(int64) :: spikes

    call begin_outcome(new, handle, turn)
    if (.not. associated(new)) return
    name = 'map'
    chosen%edge_of_file = .not. c_associated(given)
    call set_choices(choices, chosen, new%problems)
    if (chosen%edge_of_file) then
      call require_text('map', path, new%problems)
      name = text_of(path)
      if (new%problems%count() == 0) &
        call summits_of_file(name, chosen, map, summits, spikes, new%problems, new%failure)
    else
      call take_heights('map', given, map, new%problems, new%failure)
      if (new%is_good()) &
        call summits_of_array(map, chosen, summits, spikes, new%problems, new%failure)
    end if
    if (new%is_good()) then
      call measure_map(map, summits, found)
      call write_summits_table(name, chosen, spikes, map, summits, found, summary)
      call set_text(new, text_report, summary%text())
      call set_text(new, text_notes, map%notes%text())
      call add_surface(summits%x, summits%y, summits%height, summits%radius, &
                       new%tables(table_summits), map%unit)
      call add_statistics(map, found, new%tables(table_statistics))
    end if
    call finish_outcome(new)
  end function c_summits

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
    chosen%periodic = chosen%edge_of_file .and. options%periodic /= 0_c_int
  end subroutine set_choices

end module asperity_c_maps
