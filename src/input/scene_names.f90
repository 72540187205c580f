!> The names of a scene, one row each: group, name, values, meaning, default, unit. Reader,
!> messages, help and the tables of the pages take them from here, those of &effects from
!> `asperity_effect_names`.
!>
!> A new name is a row with `stored=.true.`; its value is `scene%number(group, name)`.
module asperity_scene_names
  use asperity_effect_names, only: effect_numbers, effect_words, known_effects
  use asperity_height_map, only: edge_names, length_units, level_names
  use asperity_kinds, only: real64
  use asperity_loading_controls, only: control_words
  use asperity_numeral, only: a_length, above_zero, any_number, not_negative, poisson_range
  use asperity_scene_fields, only: known_name, most_words, one_text, one_word, whole_number, &
                                   word_length
  implicit none
  private

  public :: scene_rows, scene_table, criterion_words, most_values

  !> The words of a scene for `criterion_load` and so on; `criterion_none` has none.
  character(len=*), parameter :: criterion_words(4) = &
    [character(len=20) :: 'load', 'pressure', 'greenwood_williamson', 'hardy']

  !> Room for results is bounded: a position takes 400 bytes, a state of a curve 100 in memory and
  !> 200 in a file.
  integer, parameter :: most_positions = 1000000, most_points = 100000, most_values = 100000

  character(len=*), parameter :: none(most_words - 2) = ''
  character(len=*), parameter :: of_deck = 'that of the deck; needed with CSV files'
  real(real64), parameter :: one = 1.0_real64  ! also: the first word

  !> The names of all groups but &effects.
  type(known_name), parameter :: scene_rows(*) = [ &
    known_name('surfaces', 'deck', one_text, 'a card deck with both surfaces'), &
    known_name('surfaces', 'upper', one_text, &
               'a CSV file, a height map, or ''plane'' for at most one of the surfaces'), &
    known_name('surfaces', 'lower', one_text, 'the same for the lower surface'), &
    known_name('surfaces', 'radius', above_zero, &
               'summit radii for CSV files without a radius column', 2, &
               otherwise='none', unit='length'), &
    known_name('surfaces', 'nominal_area', above_zero, &
               'area of the surfaces in plan, for nominal_pressure and area_fraction', &
               otherwise='that of a map', unit='length^2'), &
    known_name('surfaces', 'units', one_text, &
               'units of length and force, as ''mm'', ''N''; not beside a deck', 2), &
    known_name('surfaces', 'map_edge', one_word, &
               'beyond the edge of a map: no load, or the map again; two: x, y', [1, 2], one, &
               words=[character(len=word_length) :: edge_names, none]), &
    known_name('surfaces', 'map_level', one_word, &
               'subtracted from the heights: plane of least squares, mean, or nothing', &
               otherwise='''plane''; of a periodic map ''mean''', &
               words=[character(len=word_length) :: level_names, none(2:)]), &
    known_name('surfaces', 'map_unit', one_word, 'of all lengths of a map; two: upper, lower', &
               [1, 2], otherwise='that of its file', &
               words=[character(len=word_length) :: length_units, none(5:)]), &
    known_name('surfaces', 'map_spacing', a_length, &
               'of pixels, one or along x and y; of two maps the upper pair first', [1, 4], &
               otherwise='that of its file', unit='length'), &
    known_name('surfaces', 'map_despike', one_word, 'whether spikes of a map are removed', &
               default=one, words=[character(len=word_length) :: 'off', 'on', none]), &
    known_name('surfaces', 'form_radius', not_negative, &
               'radii of the form under the roughness, along x and y; 0: straight', [1, 2], &
               unit='length'), &
    known_name('surfaces', 'field_spacing', above_zero, &
               'side of the pixels for fields of asperities', unit='length', stored=.true.), &
    known_name('material', 'elastic_modulus', above_zero, 'Young''s moduli, upper and lower', 2, &
               otherwise=of_deck, unit='force/length^2', &
               synonyms=' e young youngs young_modulus youngs_modulus '), &
    known_name('material', 'poisson_ratio', poisson_range, 'Poisson''s ratios', 2, &
               otherwise=of_deck, synonyms=' nu poisson '), &
    known_name('material', 'contact_modulus', above_zero, &
               'combined modulus, in place of the two above', otherwise='none', &
               unit='force/length^2', &
               synonyms=' e_star estar reduced_modulus effective_modulus '), &
    known_name('material', 'layer_thickness', not_negative, 'of layers on the bodies of a map', 2, &
               otherwise='none', unit='length'), &
    known_name('material', 'layer_modulus', not_negative, 'their Young''s moduli', 2, &
               otherwise='none', unit='force/length^2'), &
    known_name('material', 'layer_poisson', poisson_range, 'their Poisson''s ratios', 2, &
               otherwise='none'), &
    known_name('material', 'electrical_conductivity', above_zero, &
               'of both bodies, for the conductance of pixels', 2, otherwise='none', &
               unit='siemens/length'), &
    known_name('material', 'thermal_conductivity', above_zero, 'the same for heat', 2, &
               otherwise='none', unit='watt/kelvin/length'), &
    known_name('motion', 'x_first', any_number, 'displacement at the first position, along x', &
               unit='length'), &
    known_name('motion', 'x_step', any_number, 'from one position to the next', unit='length'), &
    known_name('motion', 'y_first', any_number, 'the same along y', unit='length'), &
    known_name('motion', 'y_step', any_number, 'the same along y', unit='length'), &
    known_name('motion', 'positions', whole_number, 'number of positions', default=one, least=1, &
               most=most_positions), &
    known_name('tilt', 'upper_slope', any_number, 'rise of the upper plate along x and y', 2, &
               otherwise='0, 0; with a deck 0.004, -0.00058'), &
    known_name('tilt', 'lower_slope', any_number, 'rise of the lower plate along x and y', 2, &
               otherwise='0, 0; with a deck -0.00067, -0.00045'), &
    known_name('tilt', 'rotation', any_number, 'turn of each surface in the plane, radians', 2, &
               otherwise='0, 0; with a deck its THETAU and THETAL'), &
    known_name('loading', 'control', one_word, 'quantity that value sets', default=one, &
               words=[character(len=word_length) :: control_words, &
                                                    none(size(control_words) - 1:)]), &
    known_name('loading', 'value', any_number, &
               'of that quantity; several: a path', [1, most_values], &
               otherwise='needed for all but ''limit'', refused there'), &
    known_name('loading', 'points', whole_number, 'states after first contact', &
               least=0, most=most_points), &
    known_name('loading', 'events', one_word, 'whether each contact adds a state where it begins', &
               default=one, words=[character(len=word_length) :: 'off', 'on', none]), &
    known_name('loading', 'tangential_load', any_number, 'along x, y, at the last state', [1, 2], &
               unit='force'), &
    known_name('loading', 'tangential_displacement', any_number, &
               'of the bodies at the last state, in place of tangential_load', [1, 2], &
               unit='length'), &
    known_name('loading', 'tangential_path', any_number, &
               'on pixels: loads along x, y of one point after the other', [2, most_values], &
               otherwise='none', unit='force'), &
    known_name('limit', 'criterion', one_word, 'when a contact is at its limit', default=one, &
               words=[character(len=word_length) :: criterion_words, none(3:)]), &
    known_name('limit', 'value', above_zero, &
               'limit load of a contact, or its average pressure', &
               otherwise='288.888888888888889 with a deck; needed with CSV files', &
               unit='force, or modulus'), &
    known_name('limit', 'hardness', above_zero, 'for ''greenwood_williamson''', &
               otherwise='needed there', unit='modulus'), &
    known_name('limit', 'yield_stress', above_zero, 'in shear, for ''hardy''', &
               otherwise='needed there', unit='modulus')]

contains

  !> All names of a scene. Room for all at once: memory that does not grow can be refused.
  pure function scene_table() result(table)
    type(known_name), allocatable :: table(:)  !! a row each
    type(known_name) :: row
    integer :: i, k, rows

    allocate (table(size(scene_rows) + size(known_effects) + size(effect_numbers)))
    rows = size(scene_rows)
    table(:rows) = scene_rows
    do i = 0, size(known_effects)
      row = known_name()
      if (i > 0) then
        associate (effect => known_effects(i))
          row = known_name('effects', effect%name, one_word, effect%meaning, &
                           otherwise='''auto'' with its numbers, else ''off''', &
                           effect=effect%name)
          if (effect%own(1) == '') row%otherwise = '''auto'''
          row%words(:count(effect%modes > 0)) = effect_words(pack(effect%modes, effect%modes > 0))
        end associate
        rows = rows + 1
        table(rows) = row
      end if
      do k = 1, size(effect_numbers)
        if (effect_numbers(k)%effect /= row%effect) cycle
        rows = rows + 1
        table(rows) = effect_numbers(k)
      end do
    end do
  end function scene_table

end module asperity_scene_names
