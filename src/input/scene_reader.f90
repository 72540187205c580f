!> Reads a scene, or a card deck in its place: text in, checked values or a list of problems out.
module asperity_scene_reader
  use asperity_card_deck, only: has_cards
  use asperity_constants, only: pi
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_file_kind, only: a_scene, group_start, other_kind
  use asperity_height_map, only: move_map
  use asperity_input_text, only: blanks, read_text
  use asperity_kinds, only: int64, real64
  use asperity_namelist_text, only: skip_blanks
  use asperity_numeral, only: above_zero, any_number, not_negative
  use asperity_problems, only: decimal_text, problem_list, real_text
  use asperity_scene_effects, only: read_effects
  use asperity_scene_fields, only: read_fields, scene_fields
  use asperity_scene_maps, only: check_map_scene
  use asperity_scene_names, only: most_values, scene_rows, scene_table
  use asperity_scene_surfaces, only: from_csv, read_surfaces, surfaces_from_deck
  use asperity_scene_values, only: by_word, control_compression, control_limit, control_pressure, &
                                   control_separation, control_words, &
                                   criterion_greenwood_williamson, criterion_hardy, &
                                   criterion_load, criterion_none, criterion_pressure, &
                                   criterion_words, dundurs_beta, effect_off, effect_on, is_load, &
                                   scene, scene_loading, scene_motion, scene_side, scene_surface
  implicit none
  private

  public :: read_scene, parse_scene, build_scene, build_scene_of, rebuild_scene

  integer, parameter :: most_states = 2000000  ! room for results is bounded

contains

  !> Reads and checks a scene or a card deck. With problems the scene is not to be used.
  subroutine read_scene(path, checked, problems)
    character(len=*), intent(in) :: path         !! path of the scene or deck; `-` is standard input
    type(scene), intent(out) :: checked          !! its values, defaults filled in
    type(problem_list), intent(out) :: problems  !! all that is wrong, in all files it names
    character(len=:), allocatable :: text

    call read_text(path, 'a scene or a card deck', text, problems)
    if (problems%count() > 0) return
    if (is_scene(path, text)) then
      call parse_scene(path, text, checked, problems)
    else
      call deck_as_scene(path, text, checked, problems)
    end if
  end subroutine read_scene

  !> Checks the text of a scene. `path` serves the messages, and files are named relative to it.
  subroutine parse_scene(path, text, checked, problems)
    character(len=*), intent(in) :: path         !! the scene's file
    character(len=*), intent(in) :: text         !! the whole scene
    type(scene), intent(out) :: checked          !! its values, defaults filled in
    type(problem_list), intent(out) :: problems  !! all that is wrong, in all files it names
    type(scene_fields) :: fields

    checked%file = path
    checked%text = text
    call read_fields(path, text, 'a scene', [a_scene], scene_table(), fields)
    call read_groups(fields, checked, problems)
  end subroutine parse_scene

  !> Makes a scene of two surfaces in memory. `text` has the groups of a scene, of `&surfaces` only
  !> what does not name them, for instance
  !> `&material ... / &loading control = 'load', value = 500. /`.
  subroutine build_scene(upper, lower, text, checked, problems)
    type(scene_surface), intent(in) :: upper, lower !! surfaces from `take_surface`
    character(len=*), intent(in) :: text            !! the other groups
    type(scene), intent(out) :: checked             !! its values, defaults filled in
    type(problem_list), intent(inout) :: problems   !! all that is wrong
    type(scene_side) :: sides(2)

    allocate (sides(1)%surface, source=upper)
    allocate (sides(2)%surface, source=lower)
    call build_scene_of(sides, text, checked, problems)
  end subroutine build_scene

  !> Makes a scene of its text and of surfaces or height maps in memory; a side that is not given is
  !> named in the text, as in a file.
  subroutine build_scene_of(sides, text, checked, problems)
    type(scene_side), intent(inout) :: sides(2)     !! upper, lower; heights of maps are moved away
    character(len=*), intent(in) :: text            !! text of all groups
    type(scene), intent(out) :: checked             !! its values, defaults filled in
    type(problem_list), intent(inout) :: problems   !! all that is wrong
    type(scene_fields) :: fields
    integer :: side

    checked%file = 'scene'
    checked%text = text
    call read_fields(checked%file, text, 'a scene', [a_scene], scene_table(), fields)
    do side = 1, 2
      fields%given(side) = allocated(sides(side)%surface) .or. allocated(sides(side)%map)
    end do
    if (allocated(sides(1)%map) .or. allocated(sides(2)%map)) allocate (checked%map)
    if (allocated(sides(1)%map)) call move_map(sides(1)%map, checked%map%upper)
    if (allocated(sides(2)%map)) call move_map(sides(2)%map, checked%map%lower)
    if (allocated(sides(1)%surface)) checked%upper = sides(1)%surface
    if (allocated(sides(2)%surface)) checked%lower = sides(2)%surface
    call read_groups(fields, checked, problems)
  end subroutine build_scene_of

  !> Makes a scene with the surfaces of another one, which are not read again, from the text of all
  !> its groups. &surfaces of the text is not looked at: that of the other scene stays. Surfaces of
  !> a deck are read anew, as the deck brings material and slopes, too.
  subroutine rebuild_scene(other, text, checked, problems)
    type(scene), intent(in) :: other              !! read or built without problems
    character(len=*), intent(in) :: text          !! text of all groups
    type(scene), intent(out) :: checked           !! its values, defaults filled in
    type(problem_list), intent(out) :: problems   !! all that is wrong with the text
    type(scene_fields) :: fields

    if (other%from_deck) then
      call parse_scene(other%file, text, checked, problems)
      return
    end if
    checked%file = other%file
    checked%text = text
    checked%upper = as_in_its_file(other%upper)
    checked%lower = as_in_its_file(other%lower)
    if (allocated(other%map)) checked%map = other%map
    checked%nominal_area = other%nominal_area
    checked%stored = other%stored
    checked%units = other%units
    call read_fields(checked%file, text, 'a scene', [a_scene], scene_table(), fields)
    fields%given = .true.
    fields%surfaces_kept = .true.
    call read_groups(fields, checked, problems)
  end subroutine rebuild_scene

  ! A surface without what other groups than &surfaces say of it.
  pure type(scene_surface) function as_in_its_file(surface) result(bare)
    type(scene_surface), intent(in) :: surface

    bare = surface
    bare%elastic_modulus = decimal_value()
    bare%poisson_ratio = decimal_value()
    bare%slope = decimal_value()
    bare%rotation = decimal_value()
  end function as_in_its_file

  !> All groups, in the order in which they need each other.
  subroutine read_groups(fields, checked, problems)
    type(scene_fields), intent(inout) :: fields
    type(scene), intent(inout) :: checked
    type(problem_list), intent(inout) :: problems
    real(real64), parameter :: most_unlike = 0.1_real64  ! a few percent of the load; chosen
    type(problem_list) :: other_files
    integer :: i

    if (fields%is_text) then
      call read_surfaces(checked%file, fields, checked, other_files)
      fields%lacks_file = other_files%count() > 0
      call read_material(fields, checked)
      call read_motion(fields, checked%motion)
      call read_tilt(fields, checked)
      call read_loading(fields, checked)
      call read_limit(fields, checked)
      call read_effects(fields, checked)
      do i = 1, size(scene_rows)
        associate (row => scene_rows(i))
          if (row%stored .and. .not. (fields%surfaces_kept .and. row%group == 'surfaces')) &
            call fields%take(trim(row%group), trim(row%name), checked%stored(i))
        end associate
      end do
      ! Friction at the interface of unlike bodies raises the pressure by a share of the order of
      ! beta.
      if (checked%effects%mode('friction') == effect_off .and. &
          abs(dundurs_beta(checked)) > most_unlike) &
        call checked%notes%add(checked%file // ': note: unlike bodies, Dundurs'' beta ' // &
                               real_text(abs(dundurs_beta(checked)), 'f6.3') // &
                               ': contacts are taken as frictionless')
      call check_states(fields, checked)
      call check_map_scene(fields, checked)
    end if
    call checked%notes%append(fields%notes)
    call problems%append(fields%problems)
    call problems%append(other_files)
  end subroutine read_groups

  !> A deck in the place of a scene is the thesis' sweep over it.
  subroutine deck_as_scene(path, text, checked, problems)
    character(len=*), intent(in) :: path, text
    type(scene), intent(inout) :: checked
    type(problem_list), intent(inout) :: problems
    type(scene_motion) :: sweep
    character(len=:), allocatable :: other

    checked%file = path
    checked%text = text
    other = other_kind(text, [a_scene])
    if (other /= '') then
      call problems%add_at(1, 1, other // '; expected a scene or a card deck')
      return
    end if
    if (verify(text, blanks) == 0) then
      call problems%add_at(1, 1, 'the file is empty, expected a scene or a card deck')
      return
    end if
    call surfaces_from_deck(path, checked, sweep, problems, text)
    checked%motion = sweep
    ! The thesis has no interaction.
    checked%effects%given = by_word
  end subroutine deck_as_scene

  !> Whether a file is meant as a scene: a group begins one of its lines, it is named so, or it is
  !> nothing but comments, or it has no card of numbers behind the first card, as a deck has, and is
  !> of no other kind.
  pure logical function is_scene(path, text)
    character(len=*), intent(in) :: path, text
    integer :: at

    at = 1
    call skip_blanks(text, at)
    is_scene = group_start(text) > 0 .or. (at > len(text) .and. index(text, '!') > 0)
    if (is_scene .or. verify(text, blanks) == 0) return
    is_scene = index(path, '.scene', back=.true.) == max(1, len(path) - 5) .or. &
               (other_kind(text, [a_scene]) == '' .and. .not. has_cards(text))
  end function is_scene

  !> Group &material. A deck brings its own; CSV files do not. The combined modulus may stand for
  !> the moduli and ratios of both surfaces.
  subroutine read_material(fields, checked)
    type(scene_fields), intent(inout) :: fields
    type(scene), intent(inout) :: checked
    character(len=*), parameter :: both_or_one = 'one for upper and lower, or contact_modulus'
    character(len=*), parameter :: beside_modulus = 'found beside contact_modulus, which ' // &
      'stands for the moduli and ratios of both surfaces, expected one or the other'
    type(decimal_value) :: pair(2)

    pair = [checked%upper%elastic_modulus, checked%lower%elastic_modulus]
    call fields%take('material', 'elastic_modulus', pair)
    checked%upper%elastic_modulus = pair(1)
    checked%lower%elastic_modulus = pair(2)
    pair = [checked%upper%poisson_ratio, checked%lower%poisson_ratio]
    call fields%take('material', 'poisson_ratio', pair)
    checked%upper%poisson_ratio = pair(1)
    checked%lower%poisson_ratio = pair(2)
    call fields%take('material', 'electrical_conductivity', checked%conductivity(:, 1))
    call fields%take('material', 'thermal_conductivity', checked%conductivity(:, 2))
    call fields%take('material', 'contact_modulus', checked%contact_modulus)
    if (fields%has_name('material', 'contact_modulus')) then
      call fields%refuse_name('material', 'elastic_modulus', beside_modulus)
      call fields%refuse_name('material', 'poisson_ratio', beside_modulus)
      return
    end if
    if (.not. from_csv(fields)) return
    call fields%require_name('material', 'elastic_modulus', both_or_one)
    call fields%require_name('material', 'poisson_ratio', both_or_one)
  end subroutine read_material

  !> Group &motion; without it one position at zero displacement.
  subroutine read_motion(fields, motion)
    type(scene_fields), intent(inout) :: fields
    type(scene_motion), intent(inout) :: motion

    call fields%take('motion', 'x_first', motion%x_first)
    call fields%take('motion', 'x_step', motion%x_step)
    call fields%take('motion', 'y_first', motion%y_first)
    call fields%take('motion', 'y_step', motion%y_step)
    call fields%take('motion', 'positions', motion%positions)
    if (.not. (ends_well(motion%x_first, motion%x_step) .and. &
               ends_well(motion%y_first, motion%y_step))) &
      call fields%complain_of_group('motion', 'the last position is beyond the range of a ' // &
                                    'double, expected a smaller step or fewer positions')

  contains

    pure logical function ends_well(first, step)
      type(decimal_value), intent(in) :: first, step
      real(real64) :: share_of_range, steps

      ! In units of the largest double, so that nothing overflows on the way.
      steps = real(motion%positions - 1, real64)
      share_of_range = decimal_to_real64(first) / huge(steps) + &
                       decimal_to_real64(step) / huge(steps) * steps
      ends_well = abs(share_of_range) < 1.0_real64
    end function ends_well

  end subroutine read_motion

  !> Group &tilt. A deck brings its angles and the thesis' slopes.
  subroutine read_tilt(fields, checked)
    type(scene_fields), intent(inout) :: fields
    type(scene), intent(inout) :: checked
    type(decimal_value) :: rotation(2)
    real(real64) :: largest

    call fields%take('tilt', 'upper_slope', checked%upper%slope)
    call fields%take('tilt', 'lower_slope', checked%lower%slope)
    rotation = [checked%upper%rotation, checked%lower%rotation]
    call fields%take('tilt', 'rotation', rotation)
    checked%upper%rotation = rotation(1)
    checked%lower%rotation = rotation(2)
    largest = maxval(abs(decimal_to_real64(rotation)))
    if (largest > 2 * pi) &
      call checked%notes%add(checked%file // ': note: rotation: ' // real_text(largest) // &
           ' radians are more than a whole turn; as degrees they would be ' // &
           real_text(largest * pi / 180) // ' radians')
  end subroutine read_tilt

  !> Group &loading.
  subroutine read_loading(fields, checked)
    type(scene_fields), intent(inout) :: fields  !! the scene's text
    type(scene), intent(inout) :: checked        !! its loading is filled
    integer :: events

    events = effect_off
    associate (loading => checked%loading)
      call fields%take('loading', 'control', loading%control)
      if (loading%control == size(control_words)) loading%control = control_separation
      call read_path(fields, loading)
      call fields%take('loading', 'points', loading%points)
      call fields%take('loading', 'events', events)
      loading%events = events == effect_on
      call fields%take('loading', 'tangential_load', loading%tangential_load)
      call fields%take('loading', 'tangential_displacement', loading%tangential_displacement)
      if (loading%tangential_load%all_digits > 0) &
        call fields%refuse_name('loading', 'tangential_displacement', 'found beside ' // &
                                'tangential_load, expected one of them')
      if (loading%events .and. allocated(loading%path)) &
        call fields%complain_of('loading', 'events', 'found beside several values, ' // &
                                'expected one value: a path has its points alone')
      ! It is not known what a refused control would need.
      if (loading%control == 0) return
      call check_need(fields, 'loading', 'value', loading%control /= control_limit, &
                'control = ''' // trim(control_words(loading%control)) // '''')
      if (loading%control == control_pressure .and. &
          .not. (allocated(checked%map) .or. fields%lacks_file) .and. &
          .not. checked%nominal_area%all_digits > 0_int64) &
        call fields%complain_of('loading', 'control', 'a pressure needs an area: found no ' // &
                                'nominal_area in &surfaces, expected one')
    end associate
  end subroutine read_loading

  !> One value, or several to go to one after the other. A load may go back to zero, and below where
  !> surfaces attract each other: `read_effects` sees to it that they do.
  subroutine read_path(fields, loading)
    type(scene_fields), intent(inout) :: fields
    type(scene_loading), intent(inout) :: loading
    integer :: number, problems
    logical :: pulls

    problems = fields%problems%count()
    pulls = fields%has_name('effects', 'adhesion') .or. &
            fields%has_name('effects', 'work_of_adhesion')
    number = fields%value_count('loading', 'value')
    if (number <= 1 .or. loading%control == control_limit) then
      call fields%take('loading', 'value', loading%value, &
           merge(not_negative, merge(above_zero, any_number, is_load(loading%control) .and. &
                 .not. pulls), loading%control == control_compression))
    else if (number > most_values) then
      call fields%complain_of('loading', 'value', 'too many values: found ' // &
                              decimal_text(number) // ', expected at most ' // &
                              decimal_text(most_values))
    else
      allocate (loading%path(number))
      call fields%take('loading', 'value', loading%path, &
           merge(not_negative, any_number, is_load(loading%control) .and. .not. pulls .or. &
                 loading%control == control_compression))
      ! The largest load or compression, or the least separation.
      associate (numbers => decimal_to_real64(loading%path))
        loading%value = loading%path(merge(minloc(numbers, 1), maxloc(numbers, 1), &
                                           loading%control == control_separation))
      end associate
      if (is_load(loading%control) .and. .not. pulls .and. &
          loading%value%all_digits == 0_int64 .and. fields%problems%count() == problems) &
        call fields%complain_of('loading', 'value', 'no load is more than 0, expected one')
    end if
  end subroutine read_path

  !> A curve at every position must have room.
  subroutine check_states(fields, checked)
    type(scene_fields), intent(inout) :: fields  !! the scene's text
    type(scene), intent(in) :: checked           !! motion, loading and effects are filled
    integer(int64) :: states

    states = int(checked%motion%positions, int64) * int(max(1, checked%loading%points), int64)
    if (allocated(checked%loading%path)) states = states * size(checked%loading%path)
    if (checked%effects%mode('creep') /= effect_off) states = states + &
      int(checked%motion%positions, int64) * nint(checked%effects%number('hold_points'), int64)
    if (states > int(most_states, int64)) &
      call fields%complain_of_group('loading', 'too many states: found ' // &
           decimal_text(checked%motion%positions) // ' positions with ' // &
           decimal_text(checked%loading%points) // ' points each, expected at most ' // &
           decimal_text(most_states) // ' states')
  end subroutine check_states

  !> Group &limit. A deck brings the thesis' limit load; for CSV files there is no default.
  subroutine read_limit(fields, checked)
    type(scene_fields), intent(inout) :: fields  !! the scene's text
    type(scene), intent(inout) :: checked        !! its limit is filled
    character(len=:), allocatable :: for_what
    logical :: has_value

    associate (limit => checked%limit)
      if (.not. fields%has_group('limit') .and. from_csv(fields) .and. &
          checked%loading%control /= control_limit) then
        limit%criterion = criterion_none
        return
      end if
      call fields%take('limit', 'criterion', limit%criterion)
      has_value = fields%has_name('limit', 'value')
      if (limit%criterion /= criterion_load .or. has_value) then
        limit%from_thesis = .false.
        limit%value = decimal_value()
      end if
      call fields%take('limit', 'value', limit%value)
      call fields%take('limit', 'hardness', limit%hardness)
      call fields%take('limit', 'yield_stress', limit%yield_stress)
      ! It is not known what a refused criterion would need.
      if (limit%criterion == 0) return
      for_what = 'criterion = ''' // trim(criterion_words(limit%criterion)) // ''''
      call check_need(fields, 'limit', 'value', limit%criterion == criterion_pressure .or. &
                (limit%criterion == criterion_load .and. (from_csv(fields) .or. has_value)), &
                for_what)
      call check_need(fields, 'limit', 'hardness', &
                limit%criterion == criterion_greenwood_williamson, for_what, &
                ', or criterion = ''greenwood_williamson''')
      call check_need(fields, 'limit', 'yield_stress', limit%criterion == criterion_hardy, &
                for_what, ', or criterion = ''hardy''')
    end associate
  end subroutine read_limit

  !> A name that something needs must stand there; one that nothing needs must not.
  subroutine check_need(fields, group, name, is_needed, for_what, or_else)
    type(scene_fields), intent(inout) :: fields
    character(len=*), intent(in) :: group, name, for_what
    logical, intent(in) :: is_needed
    character(len=*), intent(in), optional :: or_else  ! what would use the name
    character(len=:), allocatable :: expected

    if (is_needed .and. .not. fields%has_name(group, name)) then
      if (fields%has_group('loading') .or. fields%has_name('limit', 'criterion')) then
        call fields%complain_of_group(group, for_what // ' needs ' // name // ' in &' // group // &
                                      ': found none, expected one')
      else
        call fields%complain_of_group(group, 'no &loading, so control is ''limit'', which ' // &
                                      'needs ' // name // ' in &' // group // ': found none, ' // &
                                      'expected one')
      end if
    else if (fields%has_name(group, name) .and. .not. is_needed) then
      expected = ', expected none'
      if (present(or_else)) expected = expected // or_else
      call fields%complain_of(group, name, 'not used with ' // for_what // expected)
    end if
  end subroutine check_need

end module asperity_scene_reader
