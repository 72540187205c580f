!> Group &surfaces of a scene: a card deck, or two CSV files, of which one may be a plane.
module asperity_scene_surfaces
  use asperity_delimited_text, only: line_reader
  use asperity_files, only: same_name
  use asperity_height_map, only: height_map, plain_unit
  use asperity_input_text, only: in_quotes
  use asperity_kinds, only: real64
  use asperity_library_turn, only: library_turn
  use asperity_problems, only: decimal_text, problem_list, real_text
  use asperity_scene_deck, only: surfaces_from_deck
  use asperity_scene_fields, only: scene_fields
  use asperity_scene_maps, only: checksum_of_pipe, is_map, read_maps
  use asperity_scene_values, only: has_caps, scene, scene_motion, scene_surface
  use asperity_surface_csv, only: read_surface_csv, surface_table
  use asperity_system_calls, only: canonical_path
  implicit none
  private

  public :: from_csv, read_surfaces, take_surface, plane_surface

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
    if (.not. any(fields%given)) call fields%take('surfaces', 'deck', deck)
    call fields%take('surfaces', 'upper', upper)
    call fields%take('surfaces', 'lower', lower)
    named = [fields%has_name('surfaces', 'upper'), fields%has_name('surfaces', 'lower')]
    if (all(fields%given .neqv. named) .and. .not. fields%has_name('surfaces', 'deck')) then
      call read_files(path, upper, lower, fields, checked, other_files)
    else if (any(fields%given)) then
      if (fields%has_name('surfaces', 'deck')) then
        call fields%complain_of('surfaces', 'deck', beside_array)
      else if (any(fields%given .and. named)) then
        if (fields%given(1)) call fields%refuse_name('surfaces', 'upper', beside_array)
        if (fields%given(2)) call fields%refuse_name('surfaces', 'lower', beside_array)
      else
        call fields%complain_of_group('surfaces', 'a surface is missing: found one as an ' // &
             'array, expected the other one as an array, too, or its file or ''plane'' as ' // &
             trim(merge('lower', 'upper', fields%given(1))) // ' in &surfaces')
      end if
    else if (.not. fields%has_group('surfaces')) then
      call fields%complain_of_group('surfaces', 'no surfaces: found no group &surfaces, ' // &
                                    'expected one with deck, or with upper and lower')
    else if (fields%has_name('surfaces', 'deck')) then
      call fields%refuse_name('surfaces', 'upper', beside_deck)
      call fields%refuse_name('surfaces', 'lower', beside_deck)
      call fields%refuse_name('surfaces', 'radius', beside_deck)
      call fields%refuse_name('surfaces', 'units', 'found beside deck, which brings cm and N, ' // &
                              'expected none')
      if (allocated(deck)) &
        call surfaces_from_deck(path_beside(path, deck), checked, not_asked_for, other_files)
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
    real(real64) :: radius(2)
    character(len=:), allocatable :: which, lower_unit
    integer :: i
    logical :: has_radius(2)

    radius = 0.0_real64
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
      call read_surface_csv(surface%file, table, found, radius(side), files(side))
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
    type(library_turn) :: turn

    call turn%begin()
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

end module asperity_scene_surfaces
