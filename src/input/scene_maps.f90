!> Height maps in group &surfaces of a scene.
module asperity_scene_maps
  use asperity_byte_reader, only: byte_reader
  use asperity_delimited_text, only: line_reader
  use asperity_effect_names, only: known_effects
  use asperity_height_map, only: change_unit, expected_length, give_spacing, height_map, &
                                 is_length, is_measured, length_units, level_plane, map_request, &
                                 note_repeated_line, periodic_edge, plain_unit, put_in_unit, &
                                 unit_number, usual_level
  use asperity_height_map_reader, only: head_length, is_height_map, take_height_map
  use asperity_input_text, only: in_quotes, skip_mark
  use asperity_kept_records, only: checksum
  use asperity_kinds, only: int64, real64
  use asperity_loading_controls, only: bodies_asperities, bodies_flowing_map, bodies_free_map, &
                                       bodies_incomplete_map, bodies_periodic_map, bodies_strip, &
                                       refusal_of
  use asperity_problems, only: decimal_text, problem_list, real_text
  use asperity_scene_fields, only: scene_fields
  use asperity_scene_values, only: effect_auto, effect_boundary, effect_off, effect_words, &
                                   has_caps, has_hardness, scene, scene_surface
  implicit none
  private

  public :: check_map_scene, checksum_of_pipe, is_map, read_maps

  ! Names of &surfaces that a map alone has.
  character(len=*), parameter :: own_names(6) = &
    [character(len=11) :: 'map_edge', 'map_level', 'map_unit', 'map_spacing', 'map_despike', &
                          'form_radius']

contains

  !> Whether a file is a height map, as `read_height_map` takes it.
  logical function is_map(file, has_spacing)
    class(byte_reader), intent(inout) :: file  !! open, at its first byte; afterwards, too
    logical, intent(in) :: has_spacing         !! of a matrix of heights
    character(len=:), allocatable :: head

    call skip_mark(file)
    call file%take(head_length, head)
    is_map = .not. allocated(file%failure)
    if (is_map) is_map = is_height_map(head, has_spacing)
    call file%rewind()
  end function is_map

  !> Checksum of what a pipe gave, which cannot be read again; blank for a file.
  function checksum_of_pipe(file) result(word)
    class(byte_reader), intent(in) :: file  !! that was read
    character(len=8) :: word                !! hexadecimal

    word = ''
    if (file%length < 0_int64) word = checksum(file%block(:file%used))
  end function checksum_of_pipe

  ! Long: its stages share spacings, units and edge of both maps.
  !> Makes the maps of a scene: those that it names in the place of surfaces, whose files are set
  !> ('' is none), and those that are given as arrays.
  subroutine read_maps(files, fields, checked, other_files)
    type(line_reader), intent(inout) :: files(2)     !! of both, open
    type(scene_fields), intent(inout) :: fields       !! the scene's text
    type(scene), intent(inout) :: checked             !! gets the maps; has those that are given
    type(problem_list), intent(inout) :: other_files  !! what is wrong with the files
    real(real64) :: form(2), pixel_spacing(2, 2)
    integer :: despike, edges(2), sides, unit(2)
    logical :: good, is_given(2)

    form = 0.0_real64
    despike = 1
    unit = 0
    call fields%take('surfaces', 'map_despike', despike)
    ! A side with asperities is no plane.
    is_given = [checked%upper%is_plane .and. &
                (checked%upper%file /= '' .or. checked%map%upper%columns > 0), &
                checked%lower%is_plane .and. &
                (checked%lower%file /= '' .or. checked%map%lower%columns > 0)]
    sides = count(is_given)
    call take_spacing()
    call fields%take('surfaces', 'form_radius', form)
    checked%map%form_radius = form
    if (any(checked%map%form_radius > 0.0_real64 .and. &
            .not. is_length(checked%map%form_radius))) &
      call fields%complain_of('surfaces', 'form_radius', 'expected ' // expected_length // &
                              ', or 0 for a straight axis')
    call fields%take('surfaces', 'map_unit', unit(:max(1, sides)))
    unit(2) = unit(max(1, sides))
    if (.not. has_caps(checked)) &
      call fields%refuse_name('surfaces', 'radius', 'found beside a map, whose summits have ' // &
                              'radii of their own, expected none')
    associate (maps => checked%map)
      ! A refused spacing hides whether a map needs one.
      good = .not. fields%has_name('surfaces', 'map_spacing') .or. all(is_length(pixel_spacing))
      if (is_given(1) .and. good) call make_one(checked%upper, 1, maps%upper)
      if (is_given(2) .and. good) call make_one(checked%lower, 2, maps%lower)
      call take_edge()
      maps%periodic = any(edges == periodic_edge)
      maps%upper%periodic = all(edges == periodic_edge)
      maps%lower%periodic = maps%upper%periodic
      if (maps%periodic .and. .not. maps%upper%periodic) then
        maps%upper%strip_axis = findloc(edges, periodic_edge, 1)
        maps%lower%strip_axis = maps%upper%strip_axis
      end if
      if (other_files%count() == 0 .and. good) then
        if (is_given(1)) call note_repeated_line(maps%upper)
        if (is_given(2)) call note_repeated_line(maps%lower)
      end if
      call checked%notes%append(maps%upper%notes)
      call checked%notes%append(maps%lower%notes)
      maps%despike = despike == 2
      maps%level = usual_level(maps%periodic)
      call fields%take('surfaces', 'map_level', maps%level)
      if (maps%periodic .and. maps%level == level_plane) &
        call fields%complain_of('surfaces', 'map_level', 'a periodic map without its plane ' // &
             'would not be periodic: found ''plane'', expected ''mean'' or ''none''')
      if (other_files%count() > 0 .or. .not. good) return
      if (fields%has_name('surfaces', 'map_spacing') .and. sides == 2 .and. &
          maps%upper%own_spacing .and. maps%lower%own_spacing) &
        call fields%complain_of('surfaces', 'map_spacing', 'found although both maps have ' // &
                                'their own, expected none')
      if (fields%has_name('surfaces', 'map_unit') .and. any(unit == 0)) return
      if (is_given(1)) call convert_map(1, maps%upper, maps%lower)
      if (is_given(2)) call convert_map(2, maps%lower, maps%upper)
      if (sides == 2) call compare_grids(checked, fields)
    end associate

  contains

    ! The edge that is named, one for both axes or one each; else that of the arrays and files.
    subroutine take_edge()
      integer :: of_arrays(2)

      of_arrays = [checked%map%upper%edge, checked%map%lower%edge]
      edges = max(1, maxval(of_arrays))
      if (fields%has_name('surfaces', 'map_edge')) then
        call fields%take('surfaces', 'map_edge', edges)
      else if (all(of_arrays > 0) .and. of_arrays(1) /= of_arrays(2)) then
        call fields%complain_of('surfaces', 'upper', 'two maps: found one that is free and one ' &
                                // 'that is periodic, expected both alike, or map_edge')
      end if
    end subroutine take_edge

    ! One number or a pair for all maps, or a pair for each.
    subroutine take_spacing()
      real(real64) :: values(4)

      values = 0.0_real64
      if (sides == 2 .and. fields%value_count('surfaces', 'map_spacing') == 4) then
        call fields%take('surfaces', 'map_spacing', values)
      else
        call fields%take('surfaces', 'map_spacing', values(:2))
        values(3:) = values(:2)
      end if
      pixel_spacing = reshape(values, [2, 2])
    end subroutine take_spacing

    subroutine make_one(surface, side, map)
      type(scene_surface), intent(inout) :: surface
      integer, intent(in) :: side
      type(height_map), intent(inout) :: map
      type(map_request) :: request
      character(len=:), allocatable :: fault

      ! One spacing beside two maps is that of the one that has none.
      request = map_request(pixel_spacing(:, side), unit(side), 'map_spacing', &
        sides == 2 .and. any(fields%value_count('surfaces', 'map_spacing') == [1, 2]), .true.)
      if (fields%given(side)) then
        call give_spacing(map, request%pixel_spacing, request%option, request%shared, fault)
        if (fault /= '') call other_files%add('surfaces.' // &
          trim(merge('upper', 'lower', side == 1)) // ': ' // fault)
      else
        call take_height_map(surface%file, files(side), request, map)
        surface%checksum = checksum_of_pipe(files(side))
        if (allocated(files(side)%lack)) call files(side)%problems%add(files(side)%lack)
        files(side)%problems%lacks_memory = allocated(files(side)%lack)
        call other_files%append(files(side)%problems)
      end if
    end subroutine make_one

    ! Puts a map in the unit of the scene: `map_unit`, `units`, or that of the first map. One
    ! without a unit has its numbers in the unit that is named for its side.
    subroutine convert_map(side, map, other)
      integer, intent(in) :: side
      type(height_map), intent(inout) :: map
      type(height_map), intent(in) :: other
      integer :: other_unit

      if (unit(side) > 0) then
        if (map%unit == '') map%unit = trim(length_units(unit(side)))
        call change_unit(map, unit(1))
      else if (map%unit /= '' .and. unit_number(plain_unit(checked%units(1))) > 0) then
        call change_unit(map, unit_number(plain_unit(checked%units(1))))
      else
        other_unit = 0
        if (side == 2 .and. sides == 2 .and. map%unit /= '') other_unit = unit_number(other%unit)
        if (other_unit > 0) call change_unit(map, other_unit)
        if (other_unit == 0) call put_in_unit(map, 0)
      end if
      if (checked%units(1) /= '' .and. map%unit /= '' .and. &
          plain_unit(checked%units(1)) /= map%unit) &
        call fields%complain_of('surfaces', 'units', 'found length ' // &
                                in_quotes(trim(checked%units(1))) // ' beside ' // &
                                in_quotes(map%unit) // &
                                ' of the map, expected the same, or map_unit')
    end subroutine convert_map

  end subroutine read_maps

  ! Two periodic maps must have the same lengths; free maps have a window in common. A note names
  ! unlike grids.
  subroutine compare_grids(checked, fields)
    type(scene), intent(inout) :: checked
    type(scene_fields), intent(inout) :: fields
    real(real64), parameter :: most_off = 1.0e-6_real64
    real(real64) :: lengths(2, 2)
    logical :: are_alike

    associate (upper => checked%map%upper, lower => checked%map%lower)
      are_alike = all([upper%columns, upper%rows] == [lower%columns, lower%rows])
      are_alike = are_alike .and. all(abs(upper%pixel_spacing - lower%pixel_spacing) <= &
                                      most_off * upper%pixel_spacing)
      if (are_alike) then
        upper%pixel_spacing = lower%pixel_spacing
        return
      end if
      lengths(:, 1) = upper%pixel_spacing * [upper%columns, upper%rows]
      lengths(:, 2) = lower%pixel_spacing * [lower%columns, lower%rows]
      if (upper%unit == '' .neqv. lower%unit == '') then
        call fields%complain_of('surfaces', 'upper', 'two maps: found ' // grid_text(upper) // &
               ' and ' // grid_text(lower) // ', expected lengths in one unit')
      else if (any(abs(lengths(:, 1) - lengths(:, 2)) > most_off * lengths(:, 1) .and. &
                   [upper%repeats(1), upper%repeats(2)])) then
        call fields%complain_of('surfaces', 'upper', 'two periodic maps: found ' // &
               grid_text(upper) // ' and ' // grid_text(lower) // ', expected the same lengths')
      else
        call checked%notes%add(checked%file // ': note: upper map of ' // grid_text(upper) // &
               ', lower map of ' // grid_text(lower) // ': their common area is solved on the ' // &
               'coarser pixels')
      end if
    end associate

  contains

    function grid_text(map) result(text)
      type(height_map), intent(in) :: map
      character(len=:), allocatable :: text

      text = decimal_text(map%columns) // ' x ' // decimal_text(map%rows) // ' pixels of ' // &
             real_text(map%pixel_spacing(1)) // ' x ' // real_text(map%pixel_spacing(2)) // ' ' // &
             map%unit
      if (map%unit == '') text = text // '(no unit: name it in map_unit)'
    end function grid_text

  end subroutine compare_grids

  !> Checks the names that go with a map or need one.
  subroutine check_map_scene(fields, checked)
    type(scene_fields), intent(inout) :: fields  !! the scene's text
    type(scene), intent(inout) :: checked        !! all groups are read; gets a note
    character(len=*), parameter :: conductivities(2) = [character(len=23) :: &
      'electrical_conductivity', 'thermal_conductivity']
    character(len=:), allocatable :: refusal
    integer :: i, mode
    logical :: others(size(known_effects))

    if (.not. fields%lacks_file) then
      refusal = refusal_of(checked%loading%control, bodies_of(checked))
      if (refusal /= '') call fields%complain_of_group('loading', refusal)
    end if
    if (.not. allocated(checked%map)) then
      do i = 1, 2
        call fields%refuse_name('material', trim(conductivities(i)), 'conductance is that of ' // &
                                'pixels: found no map, expected one')
      end do
      do i = 1, merge(0, size(own_names), fields%lacks_file)
        call fields%refuse_name('surfaces', trim(own_names(i)), 'found without a map, ' // &
                                'expected a map as upper or lower')
      end do
      others = checked%effects%modes /= effect_off .and. known_effects%not_on_asperities /= ''
      if (any(others)) call fields%complain_of_group('effects', &
        trim(known_effects(findloc(others, .true., 1))%not_on_asperities))
      return
    end if
    if (fields%has_group('motion') .and. .not. has_caps(checked) .and. &
        min(checked%map%upper%columns, checked%map%lower%columns) == 0) &
      call fields%complain_of_group('motion', 'found beside a map and a plane, expected ' // &
                                    'none: a plane is the same everywhere')
    if (fields%has_group('tilt')) &
      call fields%complain_of_group('tilt', 'found beside a map, expected none: it is levelled')
    mode = checked%effects%mode('interaction')
    if (all(mode /= [effect_auto, effect_boundary])) &
      call fields%complain_of('effects', 'interaction', 'a map is solved on its pixels: found ' // &
           trim(effect_words(mode)) // ', expected ''auto'' or ''boundary''; its summits are ' // &
           'asperities: asperity summits MAP --rule contact --output FILE')
    if (checked%loading%events) &
      call fields%complain_of('loading', 'events', 'found beside a map, expected none')
    others = checked%effects%modes /= effect_off .and. known_effects%not_on_pixels /= ''
    if (has_hardness(checked)) others = others .and. known_effects%name /= 'plasticity'
    call fields%refuse_name('surfaces', 'field_spacing', 'found beside a map that is solved ' // &
                            'on its pixels, expected none: the fields are on the pixels')
    if (any(others)) &
      call fields%complain_of_group('effects', 'found another effect beside interaction = ''' // &
           trim(effect_words(mode)) // ''', expected none: ' // &
           trim(known_effects(findloc(others, .true., 1))%not_on_pixels))
  end subroutine check_map_scene

  ! The bodies of a scene as controls distinguish them.
  pure integer function bodies_of(checked) result(bodies)
    type(scene), intent(in) :: checked

    bodies = bodies_asperities
    if (.not. allocated(checked%map)) return
    associate (upper => checked%map%upper, lower => checked%map%lower)
      bodies = bodies_free_map
      ! Displacements of a strip are known up to the logarithm of a distance (Johnson, section 2.3).
      if (max(upper%strip_axis, lower%strip_axis) > 0) bodies = bodies_strip
      if (.not. (upper%periodic .or. lower%periodic)) return
      bodies = bodies_periodic_map
      if (.not. (all_measured(upper) .and. all_measured(lower))) bodies = bodies_incomplete_map
      if (has_hardness(checked)) bodies = bodies_flowing_map
    end associate
  end function bodies_of

  ! Whether a map has all its heights; also one that is not there.
  pure logical function all_measured(map)
    type(height_map), intent(in) :: map

    all_measured = .true.
    if (allocated(map%height)) all_measured = all(is_measured(map%height))
  end function all_measured

end module asperity_scene_maps
