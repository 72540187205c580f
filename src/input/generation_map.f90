!> Reads group &map of a specification: the height map that `asperity generate` makes.
module asperity_generation_map
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_generation_values, only: below_none, below_words, exact_value, map_spec, period_of
  use asperity_height_map, only: expected_length, is_length, length_units, most_samples
  use asperity_kinds, only: int64, real128
  use asperity_numeral, only: above_zero, share_or_all
  use asperity_problems, only: decimal_text
  use asperity_scene_fields, only: scene_fields
  use asperity_scene_names, only: in_group, known_name
  implicit none
  private

  public :: map_table, take_map_spec

  ! Pixels along a side: more would leave too few bits for a wave number's square.
  integer, parameter :: most_pixels = 1048576
  integer, parameter :: fewest_pixels = 3  ! fewer have no summit

contains

  !> The names of the group.
  pure function map_table() result(table)
    type(known_name), allocatable :: table(:)  !! all names

    table = [in_group('map', [character(len=14) :: 'pixels', 'spacing', 'hurst', 'roll_off', &
                              'cut_off', 'rms_height', 'rms_slope', 'seed', 'periodic', &
                              'below_roll_off', 'unit'])]
  end function map_table

  !> Takes and checks the group.
  subroutine take_map_spec(fields, spec)
    type(scene_fields), intent(inout) :: fields  !! the text; problems are added
    type(map_spec), intent(inout) :: spec        !! its values, defaults filled in
    type(decimal_value) :: hurst
    integer :: before, switch
    logical :: good_pixels, good_spacing

    call take_pixels(fields, spec, good_pixels)
    call take_spacing(fields, spec, good_spacing)
    call fields%require_name('map', 'hurst', 'the Hurst exponent, more than 0 and at most 1')
    hurst = decimal_value(1_int64, 0)
    call fields%take_number('map', 'hurst', share_or_all, hurst)
    spec%hurst = exact_value(hurst)
    call take_rms(fields, spec)
    call fields%take_whole('map', 'seed', 0, huge(spec%seed), spec%seed)
    switch = 1
    call fields%take_word('map', 'periodic', [character(len=3) :: 'on', 'off'], switch)
    spec%periodic = switch /= 2
    call fields%take_word('map', 'below_roll_off', below_words, spec%below)
    call fields%take_word('map', 'unit', length_units, spec%unit)
    before = fields%problems%count()
    if (good_pixels .and. good_spacing) call take_waves(fields, spec)
    if (good_pixels .and. good_spacing .and. fields%problems%count() == before) &
      call check_waves(fields, spec)
  end subroutine take_map_spec

  ! Columns and rows.
  subroutine take_pixels(fields, spec, good)
    type(scene_fields), intent(inout) :: fields
    type(map_spec), intent(inout) :: spec
    logical, intent(out) :: good
    type(decimal_value) :: pixels(2)
    real(real128) :: numbers(2)
    integer :: before

    before = fields%problems%count()
    call fields%require_name('map', 'pixels', 'one number, or two: columns and rows')
    call fields%take_pair('map', 'pixels', above_zero, pixels)
    good = fields%problems%count() == before
    if (.not. good) return
    numbers = exact_value(pixels)
    good = all(numbers >= real(fewest_pixels, real128)) .and. &
           all(numbers <= real(most_pixels, real128))
    if (good) good = all(abs(numbers - anint(numbers)) <= 0.0_real128)
    if (.not. good) then
      call fields%complain_of('map', 'pixels', 'found other numbers, expected whole numbers ' // &
                              'from ' // decimal_text(fewest_pixels) // ' to ' // &
                              decimal_text(most_pixels))
      return
    end if
    spec%pixels = int(numbers)
    good = product(int(spec%pixels, int64)) <= most_samples
    if (.not. good) &
      call fields%complain_of('map', 'pixels', 'found ' // &
                              decimal_text(product(int(spec%pixels, int64))) // &
                              ' pixels, expected at most ' // decimal_text(most_samples))
  end subroutine take_pixels

  ! Spacing of the pixels.
  subroutine take_spacing(fields, spec, good)
    type(scene_fields), intent(inout) :: fields
    type(map_spec), intent(inout) :: spec
    logical, intent(out) :: good
    type(decimal_value) :: pixel_spacing(2)
    integer :: before

    before = fields%problems%count()
    call fields%require_name('map', 'spacing', 'one length, or two: along x and along y')
    call fields%take_pair('map', 'spacing', above_zero, pixel_spacing)
    good = fields%problems%count() == before
    if (.not. good) return
    good = all(is_length(decimal_to_real64(pixel_spacing)))
    if (good) spec%pixel_spacing = pixel_spacing
    if (.not. good) &
      call fields%complain_of('map', 'spacing', 'found a length beyond these, expected ' // &
                              expected_length)
  end subroutine take_spacing

  ! The height or the slope.
  subroutine take_rms(fields, spec)
    type(scene_fields), intent(inout) :: fields
    type(map_spec), intent(inout) :: spec
    type(decimal_value) :: rms
    character(len=:), allocatable :: name
    integer :: before

    spec%of_slope = fields%has_name('map', 'rms_slope')
    if (spec%of_slope .and. fields%has_name('map', 'rms_height')) then
      call fields%complain_of('map', 'rms_slope', 'found beside rms_height, expected one of them')
      return
    else if (.not. spec%of_slope .and. .not. fields%has_name('map', 'rms_height')) then
      call fields%complain_of_group('map', '&map needs rms_height or rms_slope: found none, ' // &
                                    'expected one of them')
      return
    end if
    name = 'rms_height'
    if (spec%of_slope) name = 'rms_slope'
    before = fields%problems%count()
    call fields%take_number('map', name, above_zero, rms)
    if (fields%problems%count() > before) return
    if (is_length(decimal_to_real64(rms))) then
      spec%rms = exact_value(rms)
    else
      call fields%complain_of('map', name, 'found a number beyond these, expected one from ' // &
                              '1e-30 to 1e30')
    end if
  end subroutine take_rms

  ! Roll-off and cut-off; needs pixels and spacing.
  subroutine take_waves(fields, spec)
    type(scene_fields), intent(inout) :: fields
    type(map_spec), intent(inout) :: spec
    type(decimal_value) :: wave
    real(real128) :: pixel_spacing(2)
    integer :: before

    before = fields%problems%count()
    pixel_spacing = exact_value(spec%pixel_spacing)
    spec%roll_off = minval(spec%pixels * pixel_spacing)
    spec%cut_off = 2 * maxval(pixel_spacing)
    call fields%take_number('map', 'roll_off', above_zero, wave)
    if (fields%has_name('map', 'roll_off')) spec%roll_off = exact_value(wave)
    call fields%take_number('map', 'cut_off', above_zero, wave)
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

end module asperity_generation_map
