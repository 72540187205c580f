!> Reads what `asperity generate` shall make: text in, checked values or a list of problems out.
!> A card deck is checked for what its cards can hold.
module asperity_generation_spec
  use asperity_card_reader, only: angle_field, deck_fields, modulus_field, radius_field, &
                                  ratio_field, shift_field, stress_field, width_field, x_field
  use asperity_file_kind, only: a_specification
  use asperity_generation_values, only: below_none, exact_value, gaussian_spec, generation_spec, &
                                        map_spec, most_asperities, period_of, side_names
  use asperity_input_text, only: read_text
  use asperity_kinds, only: real128, real64
  use asperity_library_turn, only: library_turn
  use asperity_problems, only: decimal_text, problem_list
  use asperity_scene_fields, only: read_fields, scene_fields
  use asperity_spec_names, only: spec_table
  implicit none
  private

  public :: read_generation_spec, parse_generation_spec

  ! Without cut-offs a height is so near the mean, in deviations: what lies beyond has a chance of
  ! 2.4e-16. A range that begins further out than `farthest` has no chance worth the name.
  real(real128), parameter :: usual_cut = 8.2_real128, farthest = 30.0_real128
  integer, parameter :: most_cards = 99999  ! most asperities of a model: five columns

contains

  !> Reads and checks a specification. With problems it is not to be used.
  subroutine read_generation_spec(path, spec, problems)
    character(len=*), intent(in) :: path         !! path of the specification; `-` is standard input
    type(generation_spec), intent(out) :: spec   !! its values, defaults filled in
    type(problem_list), intent(out) :: problems  !! all that is wrong
    character(len=:), allocatable :: text
    type(library_turn) :: turn

    call turn%begin()
    call read_text(path, 'a specification', text, problems)
    if (problems%count() == 0) call parse_generation_spec(path, text, spec, problems)
  end subroutine read_generation_spec

  !> Checks the text of a specification; `path` serves the messages only.
  subroutine parse_generation_spec(path, text, spec, problems)
    character(len=*), intent(in) :: path         !! name for the messages
    character(len=*), intent(in) :: text         !! the whole file
    type(generation_spec), intent(out) :: spec   !! its values, defaults filled in
    type(problem_list), intent(out) :: problems  !! all that is wrong
    character(len=*), parameter :: others(*) = [character(len=8) :: 'surfaces', 'heights', &
      'radii', 'random', 'deck']
    type(scene_fields) :: fields
    integer :: i
    type(library_turn) :: turn

    call turn%begin()
    spec%file = path
    call read_fields(path, text, 'a specification', [a_specification], &
                     spec_table, fields)
    if (fields%is_text) then
      spec%is_map = fields%has_group('map')
      if (spec%is_map) then
        do i = 1, size(others)
          if (fields%has_group(trim(others(i)))) &
            call fields%complain_of_group(trim(others(i)), 'found &' // trim(others(i)) // &
                                          ' beside &map, expected one of them')
        end do
        call take_map_spec(fields, spec%map)
      else
        call take_generation(fields, spec)
      end if
    end if
    problems = fields%problems
    spec%notes = fields%notes
  end subroutine parse_generation_spec

  !> Takes the groups of a specification from a text that may hold other groups too.
  subroutine take_generation(fields, spec)
    type(scene_fields), intent(inout) :: fields   !! the text; problems are added
    type(generation_spec), intent(inout) :: spec  !! values of the groups, defaults filled in
    logical :: good_plane, good_heights, good_radii
    integer :: before

    before = fields%problems%count()
    call read_plane(fields, spec)
    good_plane = fields%problems%count() == before
    call read_gaussian(fields, 'heights', spec%sides%height, good_heights)
    call read_gaussian(fields, 'radii', spec%sides%radius, good_radii)
    if (good_heights .and. good_radii) call check_spheres(fields, spec)
    call fields%take('random', 'seed', spec%seed)
    call fields%take('random', 'ensemble', spec%ensemble)
    call fields%take('random', 'tries', spec%tries)
    spec%is_deck = fields%has_group('deck')
    if (spec%is_deck) call check_deck(fields, good_plane, good_heights, good_radii, spec)
  end subroutine take_generation

  !> Group &surfaces.
  subroutine read_plane(fields, spec)
    type(scene_fields), intent(inout) :: fields
    type(generation_spec), intent(inout) :: spec
    real(real64) :: density(2)
    real(real128) :: number
    integer :: side, before

    before = fields%problems%count()
    density = 0.0_real64
    call fields%take('surfaces', 'length', spec%sides%length)
    call fields%take('surfaces', 'width', spec%sides%width)
    call fields%take('surfaces', 'density', density)
    if (.not. fields%has_name('surfaces', 'density')) &
      call fields%take('surfaces', 'number', spec%sides%number)
    do side = 1, merge(2, 0, fields%has_name('surfaces', 'density') .and. &
                             fields%problems%count() == before)
      number = anint(exact_value(density(side)) * exact_value(spec%sides(side)%length) * &
                     exact_value(spec%sides(side)%width))
      if (number >= 1.0_real128 .and. number <= real(most_asperities, real128)) then
        spec%sides(side)%number = int(number)
      else
        call fields%complain_of('surfaces', 'density', 'found too few or too many ' // &
             'asperities on the ' // trim(side_names(side)) // ' surface, expected density ' // &
             '* length * width to be from 1 to ' // decimal_text(most_asperities))
      end if
    end do
    call fields%take('surfaces', 'least_distance', spec%sides%least_distance)
  end subroutine read_plane

  !> Group &heights or &radii.
  subroutine read_gaussian(fields, group, gaussian, good)
    type(scene_fields), intent(inout) :: fields
    character(len=*), intent(in) :: group
    type(gaussian_spec), intent(out) :: gaussian(2)
    logical, intent(out) :: good
    real(real128) :: means(2), deviations(2), low(2), high(2)
    integer :: before, side

    before = fields%problems%count()
    call fields%take(group, 'mean', gaussian%mean)
    call fields%take(group, 'deviation', gaussian%deviation)
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
      real(real64) :: values(2)

      values = 0.0_real64
      if (fields%has_name(group, name // '_deviation')) then
        call fields%take(group, name // '_deviation', values)
        cut = means + exact_value(values) * deviations
      else if (fields%has_name(group, name)) then
        call fields%take(group, name, values)
        cut = exact_value(values)
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
    real(real64) :: width(1)
    integer :: side

    associate (deck => spec%deck)
      call take_card_number('elastic_modulus', 999999999, modulus_field, deck%elastic_modulus)
      call take_card_number('poisson_ratio', 1, ratio_field, deck%poisson_ratio)
      call take_card_number('allowed_stress', 999999999, stress_field, deck%allowed_stress)
      call take_card_number('rotation', 99, angle_field(1), deck%rotation)
      width = spec%sides(2)%width
      call take_card_number('lower_width', 99, width_field, width)
      deck%lower_width = width(1)
      call take_card_number('x_displacement', 99, shift_field(1), deck%displacement(1:1))
      call take_card_number('y_displacement', 99, shift_field(2), deck%displacement(2:2))
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
    subroutine take_card_number(name, most, field, values)
      character(len=*), intent(in) :: name
      integer, intent(in) :: most, field
      real(real64), intent(inout) :: values(:)
      integer :: before

      before = fields%problems%count()
      call fields%take('deck', name, values)
      if (.not. fields%has_name('deck', name) .or. fields%problems%count() > before) return
      ! Zero where zero is allowed always fits.
      if (.not. all(fits_card(values, most, field) .or. abs(values) <= 0.0_real64)) &
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
    real(real64), intent(in) :: value
    integer, intent(in) :: most, field
    real(real128) :: size_of

    size_of = abs(exact_value(value))
    fits_card = size_of <= real(most, real128) .and. &
           2 * size_of * 10.0_real128**deck_fields(field)%decimals >= 1.0_real128
  end function fits_card

  ! Takes and checks group &map: the height map that `asperity generate` makes.
  subroutine take_map_spec(fields, spec)
    type(scene_fields), intent(inout) :: fields
    type(map_spec), intent(inout) :: spec
    real(real64) :: hurst, rms
    character(len=:), allocatable :: name
    integer :: before, switch
    logical :: good

    before = fields%problems%count()
    hurst = 0.0_real64
    rms = 0.0_real64
    call fields%take('map', 'pixels', spec%pixels)
    call fields%take('map', 'spacing', spec%pixel_spacing)
    good = fields%problems%count() == before
    call fields%take('map', 'hurst', hurst)
    spec%hurst = exact_value(hurst)
    spec%of_slope = fields%has_name('map', 'rms_slope')
    name = 'rms_height'
    if (spec%of_slope) name = 'rms_slope'
    call fields%take('map', name, rms)
    spec%rms = exact_value(rms)
    if (.not. fields%has_name('map', name)) &
      call fields%complain_of_group('map', '&map needs rms_height or rms_slope: found none, ' // &
                                    'expected one of them')
    call fields%take('map', 'seed', spec%seed)
    switch = 1
    call fields%take('map', 'periodic', switch)
    spec%periodic = switch /= 2
    call fields%take('map', 'below_roll_off', spec%below)
    call fields%take('map', 'unit', spec%unit)
    before = fields%problems%count()
    if (good) call take_waves(fields, spec)
    if (good .and. fields%problems%count() == before) call check_waves(fields, spec)
  end subroutine take_map_spec

  ! Roll-off and cut-off; needs pixels and spacing.
  subroutine take_waves(fields, spec)
    type(scene_fields), intent(inout) :: fields
    type(map_spec), intent(inout) :: spec
    real(real64) :: wave
    real(real128) :: pixel_spacing(2)
    integer :: before

    before = fields%problems%count()
    wave = 0.0_real64
    pixel_spacing = exact_value(spec%pixel_spacing)
    spec%roll_off = minval(spec%pixels * pixel_spacing)
    spec%cut_off = 2 * maxval(pixel_spacing)
    call fields%take('map', 'roll_off', wave)
    if (fields%has_name('map', 'roll_off')) spec%roll_off = exact_value(wave)
    call fields%take('map', 'cut_off', wave)
    if (fields%has_name('map', 'cut_off')) spec%cut_off = exact_value(wave)
    if (fields%problems%count() > before) return
    if (spec%cut_off < 2 * maxval(pixel_spacing)) then
      call fields%complain_of('map', 'cut_off', 'found less than two pixels, expected at ' // &
                              'least two spacings')
    else if (spec%roll_off > spec%cut_off) then
      return
    else if (fields%has_name('map', 'cut_off')) then
      call fields%complain_of('map', 'cut_off', 'found at least the roll-off, expected a ' // &
                              'wavelength below roll_off, by default the shorter side of the map')
    else if (fields%has_name('map', 'roll_off')) then
      call fields%complain_of('map', 'roll_off', 'found at most the cut-off, expected a ' // &
                              'wavelength above cut_off, by default two spacings')
    else
      call fields%complain_of('map', 'pixels', 'found a shorter side of at most two of the ' // &
                              'larger spacings, expected more')
    end if
  end subroutine take_waves

  ! That the periodic map has a wave in the band.
  subroutine check_waves(fields, spec)
    type(scene_fields), intent(inout) :: fields
    type(map_spec), intent(in) :: spec
    real(real128) :: side(2), least, most, rest
    integer :: i

    side = period_of(spec%pixels, spec%periodic) * exact_value(spec%pixel_spacing)
    most = 1 / spec%cut_off
    least = 0.0_real128
    if (spec%below == below_none) least = 1 / spec%roll_off
    do i = 0, int(most * side(1))
      ! The wave number along y at the upper end of the band, rounded down.
      rest = side(2) * sqrt(max(0.0_real128, most**2 - (i / side(1))**2))
      rest = aint(rest) / side(2)
      if (i + rest > 0.0_real128 .and. hypot(i / side(1), rest) >= least) return
    end do
    call fields%complain_of_group('map', 'found no wave of the map between cut_off and ' // &
                                  'roll_off, expected wavelengths further apart, or a larger map')
  end subroutine check_waves

end module asperity_generation_spec
