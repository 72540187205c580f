!> The library for C: random height maps, and power spectra of height maps.
module asperity_c_made_maps
  use, intrinsic :: iso_c_binding, only: c_associated, c_null_ptr, c_ptr
  use asperity, only: add_reals, add_wholes, generate_map, generation_spec, height_map, level_map, &
                      level_names, measure_spectra, parse_generation_spec, periodic_edge, &
                      power_spectrum, read_generation_spec, usual_level
  use asperity_c_arguments, only: require_text, take_heights, take_word
  use asperity_c_maps, only: power_of, set_map
  use asperity_c_outcome, only: begin_outcome, finish_outcome, outcome, set_text, table_map, &
                                table_spectra, text_of, text_unit
  implicit none
  private

  public :: c_generate_map, c_power_spectrum, c_power_spectrum_at_level

contains

  !> `asperity_generate_map`.
  type(c_ptr) function c_generate_map(path, groups) bind(c, name='asperity_generate_map') &
    result(handle)
    type(c_ptr), value :: path    !! specification, where `groups` is null
    type(c_ptr), value :: groups  !! text of a specification; may be null
    type(outcome), pointer :: new
    type(generation_spec) :: spec
    type(height_map) :: map

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    if (c_associated(groups)) then
      call parse_generation_spec('specification', text_of(groups), spec, new%problems)
    else
      call require_text('specification', path, new%problems)
      if (new%problems%count() == 0) &
        call read_generation_spec(text_of(path), spec, new%problems)
    end if
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
  type(c_ptr) function c_power_spectrum(given) bind(c, name='asperity_power_spectrum') &
    result(handle)
    type(c_ptr), value :: given  !! `c_height_map`

    handle = c_power_spectrum_at_level(given, c_null_ptr)
  end function c_power_spectrum

  !> `asperity_power_spectrum_at_level`.
  type(c_ptr) function c_power_spectrum_at_level(given, level) &
    bind(c, name='asperity_power_spectrum_at_level') result(handle)
    type(c_ptr), value :: given  !! `c_height_map`
    type(c_ptr), value :: level  !! name; null: that of the edge of the map
    type(outcome), pointer :: new
    type(height_map) :: map
    type(power_spectrum) :: spectra(3)
    integer :: chosen, k

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    call take_heights('map', given, map, new%problems, new%failure)
    if (new%problems%count() == 0 .and. .not. all(map%pixel_spacing > 0.0)) &
      call new%problems%add('map.spacing: found 0, 0, expected the spacing of the pixels')
    map%periodic = map%edge == periodic_edge
    chosen = usual_level(map%periodic)
    call take_word('level', level, level_names, chosen, new%problems)
    if (new%problems%count() == 0 .and. .not. allocated(new%failure)) then
      call level_map(map, chosen)
      call measure_spectra('map', map, spectra, new%problems, new%failure)
    end if
    if (new%problems%count() == 0 .and. .not. allocated(new%failure)) then
      call set_text(new, text_unit, map%unit)
      do k = 1, size(spectra)
        associate (table => new%tables(table_spectra + k - 1), from => spectra(k))
          call add_reals(table, 'q', from%q, power_of(map%unit, -1))
          if (k == 1) call add_reals(table, 'c_iso', from%c, power_of(map%unit, 4))
          if (k > 1) call add_reals(table, 'c_1d', from%c, power_of(map%unit, 3))
          call add_wholes(table, 'number', from%number)
        end associate
      end do
    end if
    call finish_outcome(new)
  end function c_power_spectrum_at_level

end module asperity_c_made_maps
