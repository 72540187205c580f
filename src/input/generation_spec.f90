!> Reads what `asperity generate` shall make: text in, checked values or a list of problems out.
!> A card deck is checked for what its cards can hold.
module asperity_generation_spec
  use asperity_card_reader, only: angle_field, deck_fields, modulus_field, radius_field, &
                                  ratio_field, shift_field, stress_field, width_field, x_field
  use asperity_decimal, only: decimal_value
  use asperity_file_kind, only: a_specification
  use asperity_generation_map, only: map_table, take_map_spec
  use asperity_generation_values, only: exact_value, gaussian_spec, generation_spec, &
                                        most_asperities, side_names
  use asperity_input_text, only: read_text
  use asperity_kinds, only: int64, real128
  use asperity_numeral, only: above_zero, any_number, not_negative, poisson_range
  use asperity_problems, only: decimal_text, problem_list
  use asperity_scene_fields, only: read_fields, scene_fields
  use asperity_scene_names, only: in_group, known_name
  implicit none
  private

  public :: read_generation_spec, parse_generation_spec, generation_table, take_generation

  ! Without cut-offs a height is so near the mean, in deviations: what lies beyond has a chance of
  ! 2.4e-16. A range that begins further out than `farthest` has no chance worth the name.
  real(real128), parameter :: usual_cut = 8.2_real128, farthest = 30.0_real128
  integer, parameter :: most_members = 1000000, most_tries = 1000000

  integer, parameter :: most_cards = 99999  ! most asperities of a model: five columns

contains

  !> Reads and checks a specification. With problems it is not to be used.
  subroutine read_generation_spec(path, spec, problems)
    character(len=*), intent(in) :: path         !! path of the specification; `-` is standard input
    type(generation_spec), intent(out) :: spec   !! its values, defaults filled in
    type(problem_list), intent(out) :: problems  !! all that is wrong
    character(len=:), allocatable :: text

    call read_text(path, 'a specification', text, problems)
    if (problems%count() == 0) call parse_generation_spec(path, text, spec, problems)
  end subroutine read_generation_spec

  !> Checks the text of a specification; `path` serves the messages only.
  subroutine parse_generation_spec(path, text, spec, problems)
    character(len=*), intent(in) :: path         !! name for the messages
    character(len=*), intent(in) :: text         !! the whole file
    type(generation_spec), intent(out) :: spec   !! its values, defaults filled in
    type(problem_list), intent(out) :: problems  !! all that is wrong
    type(scene_fields) :: fields

    spec%file = path
    call read_fields(path, text, 'a specification', [a_specification], &
                     [generation_table(), map_table()], fields)
    if (fields%is_text) then
      spec%is_map = fields%has_group('map')
      if (spec%is_map) then
        call refuse_others(fields)
        call take_map_spec(fields, spec%map)
      else
        call take_generation(fields, spec)
      end if
    end if
    problems = fields%problems
    spec%notes = fields%notes
  end subroutine parse_generation_spec

  ! A height map has no group beside &map.
  subroutine refuse_others(fields)
    type(scene_fields), intent(inout) :: fields
    character(len=*), parameter :: others(*) = [character(len=8) :: 'surfaces', 'heights', &
      'radii', 'random', 'deck']
    integer :: i

    do i = 1, size(others)
      if (fields%has_group(trim(others(i)))) &
        call fields%complain_of_group(trim(others(i)), 'found &' // trim(others(i)) // &
                                      ' beside &map, expected one of them')
    end do
  end subroutine refuse_others

  !> The groups and names of a specification.
  pure function generation_table() result(table)
    type(known_name), allocatable :: table(:)  !! all names
    character(len=*), parameter :: gaussian(6) = [character(len=17) :: 'mean', 'deviation', &
      'lowest', 'highest', 'lowest_deviation', 'highest_deviation']

    table = [in_group('surfaces', [character(len=14) :: 'number', 'density', 'length', 'width', &
                                   'least_distance']), &
             in_group('heights', gaussian), in_group('radii', gaussian), &
             in_group('random', [character(len=8) :: 'seed', 'ensemble', 'tries']), &
             in_group('deck', [character(len=15) :: 'elastic_modulus', 'poisson_ratio', &
                               'allowed_stress', 'rotation', 'lower_width', 'x_displacement', &
                               'y_displacement'])]
  end function generation_table

  !> Takes the groups of a specification from a text that may hold other groups too.
  subroutine take_generation(fields, spec)
    type(scene_fields), intent(inout) :: fields   !! the text; problems are added
    type(generation_spec), intent(inout) :: spec  !! values of the groups, defaults filled in
    logical :: good_plane, good_heights, good_radii
    integer :: before

    before = fields%problems%count()
    call read_plane(fields, spec)
    good_plane = fields%problems%count() == before
    call read_gaussian(fields, 'heights', any_number, spec%sides%height, good_heights)
    call read_gaussian(fields, 'radii', above_zero, spec%sides%radius, good_radii)
    if (good_heights .and. good_radii) call check_spheres(fields, spec)
    call fields%take_whole('random', 'seed', 0, huge(spec%seed), spec%seed)
    call fields%take_whole('random', 'ensemble', 1, most_members, spec%ensemble)
    call fields%take_whole('random', 'tries', 1, most_tries, spec%tries)
    spec%is_deck = fields%has_group('deck')
    if (spec%is_deck) call check_deck(fields, good_plane, good_heights, good_radii, spec)
  end subroutine take_generation

  !> Group &surfaces.
  subroutine read_plane(fields, spec)
    type(scene_fields), intent(inout) :: fields
    type(generation_spec), intent(inout) :: spec
    type(decimal_value) :: wanted(2)
    real(real128) :: number
    integer :: side, before
    logical :: good_extent

    before = fields%problems%count()
    call fields%require_name('surfaces', 'length', 'one')
    call fields%take_pair('surfaces', 'length', above_zero, spec%sides%length)
    call fields%require_name('surfaces', 'width', 'one')
    call fields%take_pair('surfaces', 'width', above_zero, spec%sides%width)
    good_extent = fields%problems%count() == before
    call fields%take_pair('surfaces', 'least_distance', not_negative, spec%sides%least_distance)
    before = fields%problems%count()
    if (fields%has_name('surfaces', 'number') .and. fields%has_name('surfaces', 'density')) then
      call fields%complain_of('surfaces', 'density', 'found beside number, expected one of them')
    else if (fields%has_name('surfaces', 'density')) then
      call fields%take_pair('surfaces', 'density', above_zero, wanted)
    else
      call fields%require_name('surfaces', 'number', 'one')
      call fields%take_pair('surfaces', 'number', above_zero, wanted)
    end if
    if (fields%problems%count() > before) return
    do side = 1, 2
      number = exact_value(wanted(side))
      if (fields%has_name('surfaces', 'density')) then
        if (.not. good_extent) return
        number = anint(number * exact_value(spec%sides(side)%length) * &
                       exact_value(spec%sides(side)%width))
      end if
      if (number >= 1.0_real128 .and. number <= real(most_asperities, real128) .and. &
          abs(number - anint(number)) <= 0.0_real128) then
        spec%sides(side)%number = int(number)
      else if (fields%has_name('surfaces', 'density')) then
        call fields%complain_of('surfaces', 'density', 'found too few or too many ' // &
             'asperities on the ' // trim(side_names(side)) // ' surface, expected density ' // &
             '* length * width to be from 1 to ' // decimal_text(most_asperities))
      else
        call fields%complain_of('surfaces', 'number', 'no count of asperities given for ' // &
             'the ' // trim(side_names(side)) // ' surface, expected a whole number from 1 to ' // &
             decimal_text(most_asperities))
        ! One number for both surfaces: its problem is reported once.
        if (fields%value_count('surfaces', 'number') == 1) exit
      end if
    end do
  end subroutine read_plane

  !> Group &heights or &radii.
  subroutine read_gaussian(fields, group, number_range, gaussian, good)
    type(scene_fields), intent(inout) :: fields
    character(len=*), intent(in) :: group
    integer, intent(in) :: number_range
    type(gaussian_spec), intent(out) :: gaussian(2)
    logical, intent(out) :: good
    real(real128) :: means(2), deviations(2), low(2), high(2)
    integer :: before, side

    before = fields%problems%count()
    call fields%require_name(group, 'mean', 'one')
    if (group == 'heights') call fields%require_name(group, 'deviation', 'one, or 0')
    call fields%take_pair(group, 'mean', number_range, gaussian%mean)
    call fields%take_pair(group, 'deviation', not_negative, gaussian%deviation)
    means = exact_value(gaussian%mean)
    deviations = exact_value(gaussian%deviation)
    low = means - usual_cut * deviations
    high = means + usual_cut * deviations
    call take_cut('lowest', low)
    call take_cut('highest', high)
    good = fields%problems%count() == before
    if (.not. good) return
    do side = 1, 2
      call set_range(side)
    end do
    good = fields%problems%count() == before

  contains

    !> A cut-off as a length, or in deviations from the mean.
    subroutine take_cut(name, cut)
      character(len=*), intent(in) :: name
      real(real128), intent(inout) :: cut(2)
      type(decimal_value) :: values(2)

      if (fields%has_name(group, name) .and. fields%has_name(group, name // '_deviation')) then
        call fields%complain_of(group, name // '_deviation', 'found beside ' // name // &
                                ', expected one of them')
      else if (fields%has_name(group, name)) then
        call fields%take_pair(group, name, number_range, values)
        cut = exact_value(values)
      else if (fields%has_name(group, name // '_deviation')) then
        call fields%take_pair(group, name // '_deviation', any_number, values)
        cut = means + exact_value(values) * deviations
      end if
    end subroutine take_cut

    !> Checks the range of one side, and leaves out what no draw would reach.
    subroutine set_range(i)
      integer, intent(in) :: i
      real(real128) :: from, to

      if (deviations(i) <= 0.0_real128) then
        if (low(i) > means(i) .or. high(i) < means(i)) &
          call fields%complain_of_group(group, 'the ' // trim(side_names(i)) // ' mean is cut ' // &
                                        'off: found deviation 0, expected lowest <= mean <= ' // &
                                        'highest in &' // group)
        gaussian(i)%lowest = means(i)
        gaussian(i)%highest = means(i)
        return
      end if
      from = (low(i) - means(i)) / deviations(i)
      to = (high(i) - means(i)) / deviations(i)
      if (.not. from < to) then
        call fields%complain_of_group(group, 'nothing is left between the ' // &
             trim(side_names(i)) // ' cut-offs: expected lowest < highest in &' // group)
      else if (from > farthest .or. to < -farthest) then
        call fields%complain_of_group(group, 'the ' // trim(side_names(i)) // ' cut-offs ' // &
             'leave only what is more than 30 deviations from the mean: expected a range ' // &
             'nearer to it in &' // group)
      end if
      ! The chance has fallen by 1e-17 at 40/d deviations further out than d, 5 or more.
      gaussian(i)%lowest = means(i) + deviations(i) * &
        max(from, min(-usual_cut, to - 40.0_real128 / max(-to, 5.0_real128)))
      gaussian(i)%highest = means(i) + deviations(i) * &
        min(to, max(usual_cut, from + 40.0_real128 / max(from, 5.0_real128)))
    end subroutine set_range

  end subroutine read_gaussian

  !> A sphere has a size, and does not stand higher than its diameter.
  subroutine check_spheres(fields, spec)
    type(scene_fields), intent(inout) :: fields
    type(generation_spec), intent(in) :: spec
    integer :: side

    do side = 1, 2
      associate (radius => spec%sides(side)%radius, height => spec%sides(side)%height)
        if (radius%lowest <= 0.0_real128) then
          call fields%complain_of_group('radii', 'radii of the ' // trim(side_names(side)) // &
               ' surface may be 0 or less: expected lowest or lowest_deviation in &radii that ' // &
               'keeps them above 0')
        else if (height%highest >= 2 * radius%lowest) then
          call fields%complain_of_group('heights', 'heights of the ' // trim(side_names(side)) // &
               ' surface may reach twice the least radius: expected highest or ' // &
               'highest_deviation in &heights that keeps them below')
        end if
      end associate
    end do
  end subroutine check_spheres

  !> Takes group &deck and checks that all numbers fit onto their cards.
  subroutine check_deck(fields, good_plane, good_heights, good_radii, spec)
    type(scene_fields), intent(inout) :: fields   !! the text; problems are added
    logical, intent(in) :: good_plane             !! number, length and width are known
    logical, intent(in) :: good_heights           !! heights are known
    logical, intent(in) :: good_radii             !! radii are known
    type(generation_spec), intent(inout) :: spec  !! its deck is filled
    type(decimal_value) :: width(1)
    integer :: side

    associate (deck => spec%deck)
      call fields%require_name('deck', 'elastic_modulus', 'one')
      call take_card_number('elastic_modulus', above_zero, 999999999, modulus_field, &
        deck%elastic_modulus)
      call fields%require_name('deck', 'poisson_ratio', 'one')
      call take_card_number('poisson_ratio', poisson_range, 1, ratio_field, deck%poisson_ratio)
      call fields%require_name('deck', 'allowed_stress', 'one')
      call take_card_number('allowed_stress', not_negative, 999999999, stress_field, &
        deck%allowed_stress)
      call take_card_number('rotation', any_number, 99, angle_field(1), deck%rotation)
      width = spec%sides(2)%width
      call take_card_number('lower_width', above_zero, 99, width_field, width)
      deck%lower_width = width(1)
      call take_card_number('x_displacement', any_number, 99, shift_field(1), &
        deck%displacement(1:1))
      call take_card_number('y_displacement', any_number, 99, shift_field(2), &
        deck%displacement(2:2))
    end associate
    do side = 1, 2
      associate (wanted => spec%sides(side))
        if (good_plane) then
          call require_fit(wanted%number <= most_cards, 'at most ' // decimal_text(most_cards) // &
                    ' asperities')
          call require_fit(fits_card(wanted%length, 99, x_field) .and. fits_card(wanted%width, &
                    99, x_field), 'a length and a width from 0.001 to 99 in')
        end if
        if (good_radii) &
          call require_fit(wanted%radius%highest <= wanted%radius%lowest .and. &
                    fits_card(wanted%radius%mean, 9, radius_field), &
                    'one radius for all, from 0.001 to 9 in')
        if (good_heights) &
          call require_fit(abs(wanted%height%lowest) < 9.0_real128 .and. &
                    abs(wanted%height%highest) < 9.0_real128, 'heights between -9 and 9 in')
      end associate
    end do

  contains

    !> Takes one number, or one for each side.
    subroutine take_card_number(name, number_range, most, field, values)
      character(len=*), intent(in) :: name
      integer, intent(in) :: number_range, most, field
      type(decimal_value), intent(inout) :: values(:)
      integer :: before

      before = fields%problems%count()
      if (size(values) == 2) then
        call fields%take_pair('deck', name, number_range, values)
      else
        call fields%take_numbers('deck', name, number_range, values)
      end if
      if (.not. fields%has_name('deck', name) .or. fields%problems%count() > before) return
      ! Zero where zero is allowed always fits.
      if (.not. all(fits_card(values, most, field) .or. &
                    (number_range /= above_zero .and. values%all_digits == 0))) &
        call fields%complain_of('deck', name, 'found a number that its card cannot hold, ' // &
                                'expected fewer digits')
    end subroutine take_card_number

    subroutine require_fit(is_so, expected)
      logical, intent(in) :: is_so
      character(len=*), intent(in) :: expected

      if (.not. is_so) &
        call fields%complain_of_group('deck', 'the ' // trim(side_names(side)) // ' surface ' // &
             'does not fit onto cards, expected ' // expected)
    end subroutine require_fit

  end subroutine check_deck

  !> Whether a number is at most so large, and not lost behind the last decimal of its card.
  elemental logical function fits_card(value, most, field)
    type(decimal_value), intent(in) :: value
    integer, intent(in) :: most, field
    real(real128) :: size_of

    size_of = abs(exact_value(value))
    fits_card = size_of <= real(most, real128) .and. &
           2 * size_of * 10.0_real128**deck_fields(field)%decimals >= 1.0_real128
  end function fits_card

end module asperity_generation_spec
