!> Group &surfaces of a scene: a card deck, or two CSV files, of which one may be a plane.
module asperity_scene_surfaces
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_height_map, only: plain_unit
  use asperity_input_text, only: quoted
  use asperity_kinds, only: int64, real64
  use asperity_number_ranges, only: above_zero
  use asperity_problems, only: decimal_text, problem_list
  use asperity_scene_deck, only: surfaces_from_deck
  use asperity_scene_fields, only: scene_fields
  use asperity_scene_maps, only: is_map, read_maps
  use asperity_scene_values, only: scene, scene_motion, scene_surface
  use asperity_surface_csv, only: read_surface_csv, surface_table
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

    call fields%take_number('surfaces', 'nominal_area', above_zero, checked%nominal_area)
    call fields%take_names('surfaces', 'units', checked%units)
    if (fields%surfaces_given) then
      if (any([fields%has('surfaces', 'deck'), fields%has('surfaces', 'upper'), &
               fields%has('surfaces', 'lower'), fields%has('surfaces', 'radius')])) &
        call fields%complain_of_group('surfaces', 'found &surfaces beside surfaces that are ' // &
                                      'given as arrays, expected none, or nominal_area and ' // &
                                      'units alone')
      return
    end if
    if (.not. fields%has_group('surfaces')) then
      call fields%complain_of_group('surfaces', 'no surfaces: found no group &surfaces, ' // &
                                    'expected one with deck, or with upper and lower')
      return
    end if
    call fields%take_text('surfaces', 'deck', deck)
    call fields%take_text('surfaces', 'upper', upper)
    call fields%take_text('surfaces', 'lower', lower)
    if (fields%has('surfaces', 'deck')) then
      call refuse_beside_deck(fields, 'upper')
      call refuse_beside_deck(fields, 'lower')
      call refuse_beside_deck(fields, 'radius')
      if (fields%has('surfaces', 'units')) &
        call fields%complain_of('surfaces', 'units', 'found beside deck, which brings cm and ' // &
                                'N, expected none')
      if (allocated(deck)) &
        call surfaces_from_deck(beside(path, deck), checked, not_asked_for, other_files)
    else if (fields%has('surfaces', 'upper') .and. fields%has('surfaces', 'lower')) then
      call read_csv_files(path, upper, lower, fields, checked, other_files)
    else
      call fields%complain_of_group('surfaces', 'a surface is missing: expected deck, or both ' // &
                                    'upper and lower, in &surfaces')
    end if
  end subroutine read_surfaces

  !> The two CSV files, or one and a plane; the scene's radius serves those that have no radius
  !> column.
  subroutine read_csv_files(path, upper, lower, fields, checked, other_files)
    character(len=*), intent(in) :: path
    character(len=:), allocatable, intent(in) :: upper, lower
    type(scene_fields), intent(inout) :: fields
    type(scene), intent(inout) :: checked
    type(problem_list), intent(inout) :: other_files
    type(decimal_value) :: radius(2)
    character(len=:), allocatable :: which
    character(len=:), allocatable :: upper_unit, lower_unit
    logical :: upper_has_radius, lower_has_radius

    upper_unit = ''
    lower_unit = ''
    upper_has_radius = .true.
    lower_has_radius = .true.
    checked%upper%is_plane = is_plane(upper)
    checked%lower%is_plane = is_plane(lower)
    if (checked%upper%is_plane .and. checked%lower%is_plane) then
      call fields%complain_of('surfaces', 'lower', 'found two planes, expected one at most')
      return
    end if
    if (names_map(path, upper, fields) .or. names_map(path, lower, fields)) then
      call take_maps(path, upper, lower, fields, checked, other_files)
      return
    end if
    if (checked%upper%is_plane .or. checked%lower%is_plane) then
      call fields%take_pair('surfaces', 'radius', above_zero, radius)
    else
      call fields%take_numbers('surfaces', 'radius', above_zero, radius)
    end if
    if (checked%upper%is_plane) then
      checked%upper = plane_surface()
    else if (allocated(upper)) then
      call surface_from_csv(beside(path, upper), radius(1), checked%upper, upper_has_radius, &
                            upper_unit, checked%notes, other_files)
    end if
    if (checked%lower%is_plane) then
      checked%lower = plane_surface()
    else if (allocated(lower)) then
      call surface_from_csv(beside(path, lower), radius(2), checked%lower, lower_has_radius, &
                            lower_unit, checked%notes, other_files)
    end if
    if (upper_unit /= '' .and. lower_unit /= '' .and. upper_unit /= lower_unit) &
      call fields%complain_of('surfaces', 'lower', 'found unit ' // quoted(lower_unit) // &
                              ' in its header beside ' // quoted(upper_unit) // ' of upper, ' // &
                              'expected all lengths in one unit')
    if (upper_unit == '') upper_unit = lower_unit
    if (upper_unit /= '' .and. checked%units(1) /= '' .and. &
        upper_unit /= plain_unit(checked%units(1))) &
      call fields%complain_of('surfaces', 'units', 'found length ' // &
                              quoted(trim(checked%units(1))) // ' beside ' // &
                              quoted(upper_unit) // ' in the header of a surface, expected ' // &
                              'the same: nothing is converted')
    if (.not. fields%has('surfaces', 'radius')) then
      which = 'upper and the lower'
      if (upper_has_radius) which = 'lower'
      if (lower_has_radius) which = 'upper'
      if (.not. (upper_has_radius .and. lower_has_radius)) &
        call fields%complain_of_group('surfaces', 'no radius: found no radius column in the ' // &
             which // ' surface''s file, expected radius = upper, lower in &surfaces')
    else if (upper_has_radius .and. lower_has_radius .and. other_files%count() == 0 .and. &
             allocated(upper) .and. allocated(lower)) then
      call fields%complain_of('surfaces', 'radius', 'found although both files have a radius ' // &
                              'column, expected only where one has none')
    end if
  end subroutine read_csv_files

  ! Maps of one or both surfaces; the other one is a plane.
  subroutine take_maps(path, upper, lower, fields, checked, other_files)
    character(len=*), intent(in) :: path
    character(len=:), allocatable, intent(in) :: upper, lower
    type(scene_fields), intent(inout) :: fields
    type(scene), intent(inout) :: checked
    type(problem_list), intent(inout) :: other_files

    checked%upper = plane_surface()
    checked%lower = plane_surface()
    if (names_map(path, upper, fields)) checked%upper%file = beside(path, upper)
    if (names_map(path, lower, fields)) checked%lower%file = beside(path, lower)
    call refuse_summits('upper', upper, checked%upper%file)
    call refuse_summits('lower', lower, checked%lower%file)
    call read_maps(checked%upper%file, checked%lower%file, fields, checked, other_files)

  contains

    subroutine refuse_summits(which, name, file)
      character(len=*), intent(in) :: which, file
      character(len=:), allocatable, intent(in) :: name

      if (file == '' .and. .not. is_plane(name)) &
        call fields%complain_of('surfaces', which, 'found no map beside a map, expected ' // &
                                '''plane'' or a map on the same grid')
    end subroutine refuse_summits

  end subroutine take_maps

  ! Whether a name is that of a height map.
  logical function names_map(path, name, fields)
    character(len=*), intent(in) :: path
    character(len=:), allocatable, intent(in) :: name
    type(scene_fields), intent(in) :: fields

    names_map = .false.
    if (allocated(name)) names_map = name /= 'plane'
    if (names_map) names_map = is_map(beside(path, name), fields%has('surfaces', 'map_spacing'))
  end function names_map

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

  !> A deck brings both surfaces and their radii.
  subroutine refuse_beside_deck(fields, name)
    type(scene_fields), intent(inout) :: fields
    character(len=*), intent(in) :: name

    if (fields%has('surfaces', name)) &
      call fields%complain_of('surfaces', name, 'found beside deck, expected only with ' // &
                              'surfaces from CSV files')
  end subroutine refuse_beside_deck

  !> Fills the numbers of one surface from a CSV file; a common radius of 0 is none.
  subroutine surface_from_csv(path, common_radius, surface, has_radius, unit, notes, problems)
    character(len=*), intent(in) :: path
    type(decimal_value), intent(in) :: common_radius
    type(scene_surface), intent(inout) :: surface
    logical, intent(out) :: has_radius
    character(len=:), allocatable, intent(inout) :: unit  ! that its header tells
    type(problem_list), intent(inout) :: notes, problems
    type(surface_table) :: table
    type(problem_list) :: found

    if (common_radius%digits > 0_int64) then
      call read_surface_csv(path, table, found, decimal_to_real64(common_radius))
    else
      call read_surface_csv(path, table, found)
    end if
    call problems%append(found)
    surface%file = path
    ! A file that could not be read shall not be blamed for a missing radius too.
    has_radius = table%has_radius .or. found%count() > 0
    if (found%count() == 0) then
      unit = table%unit
      if (table%others /= '') &
        call notes%add(path // ': note: columns that are not read: ' // table%others)
      if (all(table%height < 0.0_real64)) &
        call notes%add(path // ': note: every summit lies below the reference plane: heights ' // &
                       'count upwards; is the surface upside down?')
    end if
    if (allocated(table%x)) call move_alloc(table%x, surface%x)
    if (allocated(table%y)) call move_alloc(table%y, surface%y)
    if (allocated(table%height)) call move_alloc(table%height, surface%height)
    if (allocated(table%radius)) call move_alloc(table%radius, surface%radius)
  end subroutine surface_from_csv

  !> Whether the surfaces come from CSV files, or are given: they bring neither material nor limit.
  pure logical function from_csv(fields)
    type(scene_fields), intent(in) :: fields  !! the scene's text

    from_csv = fields%surfaces_given .or. (.not. fields%has('surfaces', 'deck') .and. &
               (fields%has('surfaces', 'upper') .or. fields%has('surfaces', 'lower')))
  end function from_csv

  !> A surface from numbers in memory. What is wrong with them is told.
  subroutine take_surface(which, x, y, height, radius, surface, problems)
    character(len=*), intent(in) :: which          !! `upper` or `lower`, for the messages
    real(real64), intent(in) :: x(:), y(:)         !! summits on the reference plane
    real(real64), intent(in) :: height(:)          !! summits above it, as many
    real(real64), intent(in) :: radius(:)          !! as many, more than 0; or one for all
    type(scene_surface), intent(out) :: surface    !! the same
    type(problem_list), intent(inout) :: problems  !! what is wrong

    surface%file = ''
    if (any([size(y), size(height)] /= size(x)) .or. all(size(radius) /= [1, size(x)]) .or. &
        size(x) == 0) then
      call problems%add(which // ' surface: found ' // decimal_text(size(x)) // ' x, ' // &
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
    if (.not. all(abs([x, y, height, radius]) <= huge(x))) &
      call problems%add(which // ' surface: found a number that is not finite')
    if (.not. all(radius > 0.0_real64)) &
      call problems%add(which // ' surface: found radius(' // &
                        decimal_text(findloc(radius > 0.0_real64, .false., 1)) // &
                        '), expected more than 0')
  end subroutine take_surface

  !> The path of a file that a scene names: as it is, or beside the scene.
  pure function beside(scene_path, name) result(path)
    character(len=*), intent(in) :: scene_path, name
    character(len=:), allocatable :: path

    path = name
    if (name(1:1) /= '/') path = scene_path(:index(scene_path, '/', back=.true.)) // name
    ! Standard input is the scene's.
    if (path == '-') path = './-'
  end function beside

end module asperity_scene_surfaces
