!> Group &surfaces of a scene: a card deck, from inches and psi to cm and N, or two CSV files, of
!> which one may be a plane.
module asperity_scene_surfaces
  use asperity_card_deck, only: card_deck, model_cards, parse_card_deck
  use asperity_card_reader, only: deck_fields, modulus_field, radius_field, shift_field, &
                                  width_field, x_field, y_field, z_field
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_delimited_text, only: line_reader
  use asperity_files, only: same_name
  use asperity_height_map, only: height_map, plain_unit
  use asperity_input_text, only: in_quotes, read_text
  use asperity_kept_records, only: checksum
  use asperity_kinds, only: int64, real64
  use asperity_numeral, only: is_a_double, rounded_decimal
  use asperity_problems, only: decimal_text, problem_list, real_text
  use asperity_scene_fields, only: scene_fields
  use asperity_scene_maps, only: checksum_of_pipe, is_map, read_maps
  use asperity_scene_values, only: has_caps, scene, scene_motion, scene_surface, thesis_limit_load
  use asperity_surface_csv, only: read_surface_csv, surface_table
  use asperity_system_calls, only: canonical_path
  implicit none
  private

  public :: from_csv, plane_surface, read_surfaces, surfaces_from_deck, take_surface

  ! 2.54 cm in an inch, 0.6894 N/cm2 in a psi, as in the thesis.
  type(decimal_value), parameter :: inch = decimal_value(254_int64, -2)
  type(decimal_value), parameter :: psi = decimal_value(6894_int64, -4)

  ! Gap of 0.5 in before the models close; slopes of the support plates along x and y.
  type(decimal_value), parameter :: thesis_gap = decimal_value(127_int64, -2)
  type(decimal_value), parameter :: upper_slope(2) = &
    [decimal_value(400_int64, -5), decimal_value(-58_int64, -5)]
  type(decimal_value), parameter :: lower_slope(2) = &
    [decimal_value(-67_int64, -5), decimal_value(-45_int64, -5)]

  ! The thesis' sweep: 100 positions, 0.1 cm apart in x.
  integer, parameter :: thesis_positions = 100
  type(decimal_value), parameter :: thesis_step = decimal_value(1_int64, -1)

  integer, parameter :: header_cards = 4  ! cards before the first asperity

contains

  !> Group &surfaces and the files that it names.
  subroutine read_surfaces(path, fields, checked, other_files)
    character(len=*), intent(in) :: path              !! the scene's file
    type(scene_fields), intent(inout) :: fields       !! the scene's text
    type(scene), intent(inout) :: checked             !! its surfaces are filled
    type(problem_list), intent(inout) :: other_files  !! what is wrong with the files it names
    character(len=:), allocatable :: deck, upper, lower
    type(scene_motion) :: not_asked_for
    character(len=*), parameter :: beside_deck = 'found beside deck, expected only with ' // &
      'surfaces from CSV files'
    character(len=*), parameter :: beside_array = 'found beside a surface that is given as an ' // &
      'array, expected none'
    logical :: named(2)

    if (fields%surfaces_kept) return
    call fields%take('surfaces', 'nominal_area', checked%nominal_area)
    call fields%take('surfaces', 'units', checked%units)
    named = [fields%has_name('surfaces', 'upper'), fields%has_name('surfaces', 'lower')]
    if (any(fields%given)) then
      call fields%take('surfaces', 'upper', upper)
      call fields%take('surfaces', 'lower', lower)
      if (fields%has_name('surfaces', 'deck')) then
        call fields%complain_of('surfaces', 'deck', beside_array)
      else if (any(fields%given .and. named)) then
        if (fields%given(1)) call fields%refuse_name('surfaces', 'upper', beside_array)
        if (fields%given(2)) call fields%refuse_name('surfaces', 'lower', beside_array)
      else if (.not. all(fields%given .or. named)) then
        call fields%complain_of_group('surfaces', 'a surface is missing: found one as an ' // &
             'array, expected the other one as an array, too, or its file or ''plane'' as ' // &
             trim(merge('lower', 'upper', fields%given(1))) // ' in &surfaces')
      else
        call read_files(path, upper, lower, fields, checked, other_files)
      end if
      return
    end if
    if (.not. fields%has_group('surfaces')) then
      call fields%complain_of_group('surfaces', 'no surfaces: found no group &surfaces, ' // &
                                    'expected one with deck, or with upper and lower')
      return
    end if
    call fields%take('surfaces', 'deck', deck)
    call fields%take('surfaces', 'upper', upper)
    call fields%take('surfaces', 'lower', lower)
    if (fields%has_name('surfaces', 'deck')) then
      call fields%refuse_name('surfaces', 'upper', beside_deck)
      call fields%refuse_name('surfaces', 'lower', beside_deck)
      call fields%refuse_name('surfaces', 'radius', beside_deck)
      call fields%refuse_name('surfaces', 'units', 'found beside deck, which brings cm and N, ' // &
                              'expected none')
      if (allocated(deck)) &
        call surfaces_from_deck(path_beside(path, deck), checked, not_asked_for, other_files)
    else if (all(named)) then
      call read_files(path, upper, lower, fields, checked, other_files)
    else
      call fields%complain_of_group('surfaces', 'a surface is missing: expected deck, or both ' // &
                                    'upper and lower, in &surfaces')
    end if
  end subroutine read_surfaces

  !> Two files, or one and a plane: maps or CSV files, by their first bytes. Each is opened
  !> once, as a pipe gives its bytes once.
  subroutine read_files(path, upper, lower, fields, checked, other_files)
    character(len=*), intent(in) :: path
    character(len=:), allocatable, intent(in) :: upper, lower
    type(scene_fields), intent(inout) :: fields
    type(scene), intent(inout) :: checked
    type(problem_list), intent(inout) :: other_files
    type(line_reader) :: files(2)
    character(len=:), allocatable :: unit
    logical :: maps(2)

    if (.not. fields%given(1)) checked%upper%is_plane = is_plane(upper)
    if (.not. fields%given(2)) checked%lower%is_plane = is_plane(lower)
    if (checked%upper%is_plane .and. checked%lower%is_plane) then
      call fields%complain_of('surfaces', 'lower', 'found two planes, expected one at most')
      return
    end if
    call look_at(upper, files(1), maps(1))
    if (allocated(upper) .and. allocated(lower) .and. files(1)%length < 0 .and. &
        files(1)%used > 0) then
      if (same_name(canonical_path(path_beside(path, upper)), canonical_path(path_beside(path, &
        lower)))) then
        call fields%complain_of('surfaces', 'lower', 'found ' // in_quotes(lower) // &
                                ', the pipe ' // &
                                'of upper, expected another file: a pipe can be read only once')
        return
      end if
    end if
    call look_at(lower, files(2), maps(2))
    if (allocated(checked%map)) then
      if (fields%given(1)) maps(1) = checked%map%upper%columns > 0
      if (fields%given(2)) maps(2) = checked%map%lower%columns > 0
    end if
    call read_csv_files(path, upper, lower, files, maps, unit, fields, checked, other_files)
    if (any(maps)) then
      if (.not. allocated(checked%map)) allocate (checked%map)
      call read_maps(files, fields, checked, other_files)
      if (has_caps(checked)) call compare_with_map(unit, fields, checked)
    end if
    call files(1)%close()
    call files(2)%close()

  contains

    ! Opens the file of a surface, and finds out whether it is a map.
    subroutine look_at(name, file, names_map)
      character(len=:), allocatable, intent(in) :: name
      type(line_reader), intent(inout) :: file
      logical, intent(out) :: names_map

      names_map = .false.
      if (.not. allocated(name)) return
      if (is_plane(name)) return
      call file%open(path_beside(path, name))
      names_map = is_map(file, fields%has_name('surfaces', 'map_spacing'))
    end subroutine look_at

  end subroutine read_files

  ! Long: the reading of a side shares files and radii with the checks of both.
  !> The CSV files of the sides that are neither planes nor maps; the scene's radius serves those
  !> that have no radius column.
  subroutine read_csv_files(path, upper, lower, files, maps, unit, fields, checked, other_files)
    character(len=*), intent(in) :: path
    character(len=:), allocatable, intent(in) :: upper, lower
    type(line_reader), intent(inout) :: files(2)
    logical, intent(in) :: maps(2)  ! sides that are maps, which are planes here
    character(len=:), allocatable, intent(out) :: unit  ! of lengths, from a header
    type(scene_fields), intent(inout) :: fields
    type(scene), intent(inout) :: checked
    type(problem_list), intent(inout) :: other_files
    type(decimal_value) :: radius(2)
    character(len=:), allocatable :: which, lower_unit
    integer :: i
    logical :: has_radius(2)

    checked%upper%is_plane = checked%upper%is_plane .or. maps(1)
    checked%lower%is_plane = checked%lower%is_plane .or. maps(2)
    i = merge(1, 2, fields%value_count('surfaces', 'radius') == 1 .and. &
              (checked%upper%is_plane .or. checked%lower%is_plane))
    if (.not. (checked%upper%is_plane .and. checked%lower%is_plane)) &
      call fields%take('surfaces', 'radius', radius(:i))
    radius(2) = radius(i)
    call read_side(1, upper, checked%upper, unit)
    call read_side(2, lower, checked%lower, lower_unit)
    if (unit /= '' .and. lower_unit /= '' .and. unit /= lower_unit) &
      call fields%complain_of('surfaces', 'lower', 'found unit ' // in_quotes(lower_unit) // &
                              ' in its header beside ' // in_quotes(unit) // &
                              ' of upper, expected all lengths in one unit')
    if (unit == '') unit = lower_unit
    if (unit /= '' .and. checked%units(1) /= '' .and. unit /= plain_unit(checked%units(1))) &
      call fields%complain_of('surfaces', 'units', 'found length ' // &
                              in_quotes(trim(checked%units(1))) // ' beside ' // &
                              in_quotes(unit) // ' in the header of a surface, expected ' // &
                              'the same: nothing is converted')
    if (checked%upper%is_plane .and. checked%lower%is_plane) return
    if (.not. fields%has_name('surfaces', 'radius')) then
      which = 'upper and the lower'
      if (has_radius(1)) which = 'lower'
      if (has_radius(2)) which = 'upper'
      if (.not. all(has_radius)) &
        call fields%complain_of_group('surfaces', 'no radius: found no radius column in the ' // &
             which // ' surface''s file, expected radius = upper, lower in &surfaces')
    else if (all(has_radius) .and. other_files%count() == 0 .and. &
             all(fields%given .or. [allocated(upper), allocated(lower)])) then
      call fields%complain_of('surfaces', 'radius', 'found although both surfaces have radii ' // &
                              'of their own, expected only where a file has none')
    end if

  contains

    ! Reads the surface of one side, unless it is given; a common radius of 0 is none.
    subroutine read_side(side, name, surface, unit)
      integer, intent(in) :: side
      character(len=:), allocatable, intent(in) :: name
      type(scene_surface), intent(inout) :: surface
      character(len=:), allocatable, intent(out) :: unit  ! of lengths, from its header
      type(surface_table) :: table
      type(problem_list) :: found

      unit = ''
      has_radius(side) = .true.
      if (surface%is_plane) surface = plane_surface()
      if (.not. allocated(name)) return
      if (.not. is_plane(name)) surface%file = path_beside(path, name)
      if (surface%is_plane) return
      if (any(maps) .and. allocated(files(side)%failure)) then
        call other_files%start(surface%file)
        call other_files%add_at(1, 1, files(side)%failure // ', expected a map')
        return
      end if
      call read_surface_csv(surface%file, table, found, decimal_to_real64(radius(side)), &
                            opened=files(side))
      surface%checksum = checksum_of_pipe(files(side))
      call other_files%append(found)
      ! A file that could not be read is not reported for a missing radius too.
      has_radius(side) = table%has_radius .or. found%count() > 0
      if (found%count() == 0) then
        unit = table%unit
        if (table%others /= '') call checked%notes%add(surface%file // &
            ': note: columns that are not read: ' // table%others)
        if (all(table%height < 0.0_real64)) &
          call checked%notes%add(surface%file // ': note: every summit lies below the ' // &
               'reference plane: heights count upwards; is the surface upside down?')
      end if
      if (allocated(table%x)) call move_alloc(table%x, surface%x)
      if (allocated(table%y)) call move_alloc(table%y, surface%y)
      if (allocated(table%height)) call move_alloc(table%height, surface%height)
      if (allocated(table%radius)) call move_alloc(table%radius, surface%radius)
    end subroutine read_side

  end subroutine read_csv_files

  ! Compares a table of asperities with the map that it lies on: its unit, '' for none, and places.
  subroutine compare_with_map(unit, fields, checked)
    character(len=*), intent(in) :: unit
    type(scene_fields), intent(inout) :: fields
    type(scene), intent(inout) :: checked
    logical, allocatable :: is_beside(:)
    character(len=:), allocatable :: of_map

    of_map = ''
    if (checked%map%upper%columns > 0) of_map = plain_unit(checked%map%upper%unit)
    if (checked%map%lower%columns > 0) of_map = plain_unit(checked%map%lower%unit)
    if (unit /= '' .and. of_map /= '' .and. of_map /= unit) &
      call fields%complain_of('surfaces', trim(merge('lower', 'upper', checked%upper%is_plane)), &
                              'found unit ' // in_quotes(unit) // ' in its header beside ' // &
                              in_quotes(of_map) // ' of the map, expected the same, or map_unit')
    if (checked%lower%is_plane) then
      call find_places(checked%upper, checked%map%lower)
    else
      call find_places(checked%lower, checked%map%upper)
    end if
    if (any(is_beside)) call checked%notes%add(checked%file // ': note: ' // &
      decimal_text(count(is_beside)) // ' of ' // decimal_text(size(is_beside)) // &
      ' summits lie beside the map, on which places count from its first pixel')

  contains

    subroutine find_places(caps, map)
      type(scene_surface), intent(in) :: caps
      type(height_map), intent(in) :: map

      allocate (is_beside(0))
      if (map%columns == 0 .or. .not. allocated(caps%x)) return
      is_beside = is_off(caps%x, map%repeats(1), map%columns * map%pixel_spacing(1)) .or. &
                  is_off(caps%y, map%repeats(2), map%rows * map%pixel_spacing(2))
    end subroutine find_places

    ! Whether a place is beyond an end of an axis, whose first pixel is at 0.
    elemental logical function is_off(place, repeats, length)
      real(real64), intent(in) :: place, length
      logical, intent(in) :: repeats

      is_off = .not. (repeats .or. (place >= 0.0_real64 .and. place <= length))
    end function is_off

  end subroutine compare_with_map

  ! Whether the word for a plane stands in the place of a file. A file of that name is ./plane.
  pure logical function is_plane(name)
    character(len=:), allocatable, intent(in) :: name

    is_plane = .false.
    if (allocated(name)) is_plane = name == 'plane'
  end function is_plane

  !> A plane: a surface without asperities.
  pure function plane_surface() result(surface)
    type(scene_surface) :: surface  !! for build_scene

    surface%file = ''
    surface%is_plane = .true.
    allocate (surface%x(0), surface%y(0), surface%height(0), surface%radius(0))
  end function plane_surface

  !> Whether the surfaces come from CSV files, or are given: they bring neither material nor limit.
  pure logical function from_csv(fields)
    type(scene_fields), intent(in) :: fields  !! the scene's text

    from_csv = any(fields%given) .or. (.not. fields%has_name('surfaces', 'deck') .and. &
               (fields%has_name('surfaces', 'upper') .or. fields%has_name('surfaces', 'lower')))
  end function from_csv

  !> A surface from numbers in memory. Invalid numbers are reported as problems.
  subroutine take_surface(which, x, y, height, radius, surface, problems)
    character(len=*), intent(in) :: which          !! the name of the surface, for the messages
    real(real64), intent(in) :: x(:), y(:)         !! summits on the reference plane
    real(real64), intent(in) :: height(:)          !! summits above it, as many
    real(real64), intent(in) :: radius(:)          !! as many, more than 0; or one for all
    type(scene_surface), intent(out) :: surface    !! surface with copies of the numbers
    type(problem_list), intent(inout) :: problems  !! what is wrong
    integer :: before

    surface%file = ''
    if (any([size(y), size(height)] /= size(x)) .or. all(size(radius) /= [1, size(x)]) .or. &
        size(x) == 0) then
      call problems%add(which // ': found ' // decimal_text(size(x)) // ' x, ' // &
                        decimal_text(size(y)) // ' y, ' // decimal_text(size(height)) // &
                        ' heights and ' // decimal_text(size(radius)) // ' radii, expected ' // &
                        'as many of each, or one radius, and at least one asperity')
      return
    end if
    surface%x = x
    surface%y = y
    surface%height = height
    surface%radius = spread(radius(1), 1, size(x))
    if (size(radius) == size(x)) surface%radius = radius
    before = problems%count()
    call check_numbers('x', x, abs(x) <= huge(x), 'a finite number')
    call check_numbers('y', y, abs(y) <= huge(y), 'a finite number')
    call check_numbers('height', height, abs(height) <= huge(height), 'a finite number')
    call check_numbers('radius', radius, radius > 0.0_real64 .and. radius <= huge(radius), &
               'a finite number more than 0')
    ! A sphere does not stand higher than its diameter.
    if (problems%count() == before) &
      call check_numbers('height', height, height / 2 < surface%radius, &
      'less than twice the radius')

  contains

    ! Adds the first number of an array that is not good.
    subroutine check_numbers(name, numbers, good, expected)
      character(len=*), intent(in) :: name, expected
      real(real64), intent(in) :: numbers(:)
      logical, intent(in) :: good(:)
      integer :: i

      i = findloc(good, .false., 1)
      if (i > 0) &
        call problems%add(which // '.' // name // ': found ' // real_text(numbers(i)) // &
                          ' as number ' // decimal_text(i) // ' of ' // &
                          decimal_text(size(numbers)) // ', expected ' // expected)
    end subroutine check_numbers

  end subroutine take_surface

  !> The path of a file that a scene names: as it is, or beside the scene.
  pure function path_beside(scene_path, name) result(path)
    character(len=*), intent(in) :: scene_path, name
    character(len=:), allocatable :: path

    path = name
    if (name(1:1) /= '/') path = scene_path(:index(scene_path, '/', back=.true.)) // name
    ! Standard input is the scene's.
    if (path == '-') path = './-'
  end function path_beside

  !> Fills a scene from a deck: surfaces, material, angles, slopes, gap and limit load, all in
  !> cm and N. `sweep` is the motion that the bare deck stands for.
  subroutine surfaces_from_deck(path, target_scene, sweep, problems, text)
    character(len=*), intent(in) :: path           !! path of the deck
    type(scene), intent(inout) :: target_scene     !! the scene to fill
    type(scene_motion), intent(out) :: sweep       !! the thesis' sweep, XDISPL and YDISPL added
    type(problem_list), intent(inout) :: problems  !! all that is wrong with the deck
    character(len=*), intent(in), optional :: text !! the deck, when it has been read already
    type(card_deck) :: deck
    type(problem_list) :: found
    type(decimal_value) :: shift
    character(len=:), allocatable :: own_text

    if (present(text)) then
      call parse_card_deck(path, text, deck, found)
    else
      call read_text(path, 'a card deck', own_text, found)
      if (found%count() == 0) call parse_card_deck(path, own_text, deck, found)
      target_scene%upper%checksum = checksum(own_text)
      target_scene%lower%checksum = target_scene%upper%checksum
    end if
    if (found%count() == 0) then
      target_scene%from_deck = .true.
      target_scene%deck = deck
      target_scene%notes = deck%notes
      target_scene%lower_is_mirrored = .true.
      target_scene%starting_gap = thesis_gap
      target_scene%units = [character(len=16) :: 'cm', 'N']
      target_scene%limit%value = thesis_limit_load
      target_scene%limit%from_thesis = .true.
      call convert_model(path, 2, header_cards, deck%upper, target_scene%upper, found)
      call convert_model(path, 3, header_cards + deck%upper%number, deck%lower, &
                         target_scene%lower, found)
      target_scene%upper%slope = upper_slope
      target_scene%lower%slope = lower_slope
      call convert_number(3, width_field, deck%lower_width, inch, &
                          target_scene%lower_mirror_width, found)
      ! XDISPL and YDISPL are added, as the original's print says.
      call convert_number(header_cards, shift_field(1), deck%x_displacement, inch, shift, found)
      sweep%x_first = rounded_decimal(decimal_to_real64(thesis_step) + decimal_to_real64(shift), 17)
      if (shift%power_of_ten >= -17 .and. shift%power_of_ten <= -1) sweep%x_first = decimal_value( &
        10_int64**(-1 - shift%power_of_ten) + shift%all_digits, shift%power_of_ten)
      if (shift%all_digits == 0_int64) sweep%x_first = thesis_step
      sweep%x_step = thesis_step
      call convert_number(header_cards, shift_field(2), deck%y_displacement, inch, sweep%y_first, &
                          found)
      sweep%positions = thesis_positions
    end if
    call problems%append(found)
  end subroutine surfaces_from_deck

  !> One model in cm and N/cm2. Card `header` holds its numbers; its asperities follow `before`.
  subroutine convert_model(path, header, before, model, surface, problems)
    character(len=*), intent(in) :: path
    integer, intent(in) :: header, before
    type(model_cards), intent(in) :: model
    type(scene_surface), intent(inout) :: surface
    type(problem_list), intent(inout) :: problems
    type(decimal_value) :: radius
    type(decimal_value), dimension(model%number) :: x, y, z
    integer :: i

    surface%file = path
    call convert_number(header, radius_field, model%radius, inch, radius, problems)
    call convert_number(header, modulus_field, model%elastic_modulus, psi, &
                 surface%elastic_modulus, problems)
    surface%poisson_ratio = model%poisson_ratio
    surface%rotation = model%angle
    do i = 1, model%number
      call convert_number(before + i, x_field, model%x(i), inch, x(i), problems)
      call convert_number(before + i, y_field, model%y(i), inch, y(i), problems)
      call convert_number(before + i, z_field, model%z(i), inch, z(i), problems)
    end do
    surface%x = decimal_to_real64(x)
    surface%y = decimal_to_real64(y)
    surface%height = decimal_to_real64(z)
    surface%radius = spread(decimal_to_real64(radius), 1, model%number)
  end subroutine convert_model

  !> Multiplies by a unit, exactly. A card's field has at most 10 digits, so nothing overflows.
  subroutine convert_number(line, field, value, unit, converted, problems)
    integer, intent(in) :: line, field
    type(decimal_value), intent(in) :: value, unit
    type(decimal_value), intent(out) :: converted
    type(problem_list), intent(inout) :: problems

    converted = decimal_value(value%all_digits * unit%all_digits, value%power_of_ten + &
      unit%power_of_ten)
    if (is_a_double(converted)) return
    call problems%add_at(line, deck_fields(field)%first, 'a number beyond the range of a ' // &
                         'double when converted: found exponent ' // &
                         decimal_text(value%power_of_ten) // ', expected a number of ordinary size')
    converted = decimal_value()
  end subroutine convert_number

end module asperity_scene_surfaces
