!> Height maps in group &surfaces of a scene.
module asperity_scene_maps
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_height_map, only: change_unit, height_map, length_units, number_text
  use asperity_height_map_reader, only: read_height_map
  use asperity_input_text, only: quoted
  use asperity_kinds, only: int64, real64
  use asperity_number_ranges, only: above_zero
  use asperity_problems, only: problem_list
  use asperity_scene_fields, only: scene_fields
  use asperity_scene_values, only: control_limit, effect_boundary, effect_off, scene
  use asperity_sdf_header, only: is_sdf, magic_length
  use asperity_token_reader, only: token_reader
  implicit none
  private

  public :: check_map_scene, is_map, read_maps

  character(len=*), parameter :: edge_words(2) = [character(len=8) :: 'free', 'periodic'], &
                                 despike_words(2) = [character(len=3) :: 'off', 'on']
  ! Bytes of a file that tell what it is: more than a line of four numbers.
  integer, parameter :: most_looked_at = 200
  ! Names of &surfaces that a map alone has.
  character(len=*), parameter :: own_names(4) = &
    [character(len=11) :: 'map_edge', 'map_unit', 'map_spacing', 'map_despike']

contains

  !> Whether a file is a height map: surface data, or numbers from the first line on, where a
  !> surface in CSV has names. Four numbers with commas are a surface whose names were forgotten,
  !> unless a spacing tells that they are heights.
  logical function is_map(path, has_spacing)
    character(len=*), intent(in) :: path    !! the file
    logical, intent(in) :: has_spacing      !! of a matrix of heights
    type(token_reader) :: file
    character(len=:), allocatable :: magic
    integer :: i, commas

    call file%open(path)
    call file%take(most_looked_at, magic)
    is_map = .not. allocated(file%failure)
    if (.not. is_map) return
    if (is_sdf(magic(:min(len(magic), magic_length)))) return
    is_map = scan(adjustl(magic), '+-.0123456789') == 1
    magic = magic(:index(magic // new_line('a'), new_line('a')) - 1)
    commas = count([(scan(magic(i:i), ',;') > 0, i=1, len(magic))])
    is_map = is_map .and. (has_spacing .or. commas /= 3)
  end function is_map

  !> Reads the maps that a scene names in the place of surfaces; '' is none.
  subroutine read_maps(upper, lower, fields, checked, other_files)
    character(len=*), intent(in) :: upper, lower      !! the files
    type(scene_fields), intent(inout) :: fields       !! the scene's text
    type(scene), intent(inout) :: checked             !! gets the maps
    type(problem_list), intent(inout) :: other_files  !! what is wrong with the files
    type(decimal_value) :: spacing(2)
    integer :: despike, edge, unit

    edge = 1
    despike = 1
    unit = 0
    call fields%take_word('surfaces', 'map_edge', edge_words, edge)
    call fields%take_word('surfaces', 'map_unit', length_units, unit)
    call fields%take_word('surfaces', 'map_despike', despike_words, despike)
    call fields%take_numbers('surfaces', 'map_spacing', above_zero, spacing)
    if (fields%has('surfaces', 'radius')) &
      call fields%complain_of('surfaces', 'radius', 'found beside a map, whose summits have ' // &
                              'radii of their own, expected none')
    allocate (checked%map)
    associate (maps => checked%map)
      maps%periodic = edge == 2
      maps%despike = despike == 2
      if (upper /= '') call read_one(upper, maps%upper)
      if (lower /= '') call read_one(lower, maps%lower)
      if (upper == '' .or. lower == '' .or. other_files%count() > 0) return
      if (any([maps%upper%columns, maps%upper%rows] /= [maps%lower%columns, maps%lower%rows]) .or. &
          any(abs(maps%upper%spacing / maps%lower%spacing - 1.0_real64) > 1.0e-9_real64)) &
        call fields%complain_of('surfaces', 'upper', 'two maps: found ' // grid(maps%upper) // &
             ' and ' // grid(maps%lower) // ' samples, expected the same grid: a plane ' // &
             'presses the sum of both')
    end associate

  contains

    subroutine read_one(file, map)
      character(len=*), intent(in) :: file
      type(height_map), intent(out) :: map
      type(problem_list) :: found
      character(len=:), allocatable :: failure

      call read_height_map(file, decimal_to_real64(spacing), .true., map, found, failure)
      if (allocated(failure)) call found%add(file // ': ' // failure)
      call other_files%append(found)
      if (found%count() > 0 .or. unit == 0) return
      if (map%unit == '') then
        call fields%complain_of('surfaces', 'map_unit', quoted(file) // ' has no unit, ' // &
                                'expected none: its lengths are taken as they are')
      else
        call change_unit(map, unit)
      end if
    end subroutine read_one

    function grid(map) result(text)
      type(height_map), intent(in) :: map
      character(len=:), allocatable :: text

      text = number_text(int(map%columns, int64)) // ' x ' // number_text(int(map%rows, int64))
    end function grid

  end subroutine read_maps

  !> What goes with a map, and what needs one.
  subroutine check_map_scene(fields, checked)
    type(scene_fields), intent(inout) :: fields  !! the scene's text
    type(scene), intent(in) :: checked           !! all groups are read
    integer :: i

    if (.not. allocated(checked%map)) then
      do i = 1, size(own_names)
        if (fields%has('surfaces', trim(own_names(i)))) &
          call fields%complain_of('surfaces', trim(own_names(i)), 'found without a map, ' // &
                                  'expected a map as upper or lower')
      end do
      return
    end if
    if (fields%has_group('motion')) &
      call fields%complain_of_group('motion', 'found beside a map, expected none: a plane is ' // &
                                    'the same everywhere, and two maps share a grid')
    if (fields%has_group('tilt')) &
      call fields%complain_of_group('tilt', 'found beside a map, expected none: it is levelled')
    if (checked%effects%mode('interaction') /= effect_boundary) return
    if (checked%loading%control == control_limit) &
      call fields%complain_of_group('loading', 'no control: the samples of a map have no ' // &
           'limit, expected control = ''approach'', ''load'', ''vertical_load'' or ''pressure''')
    if (count(checked%effects%modes /= effect_off) > 1) &
      call fields%complain_of_group('effects', 'found another effect beside interaction = ' // &
           '''boundary'', expected none: the samples of a map are elastic')
  end subroutine check_map_scene

end module asperity_scene_maps
