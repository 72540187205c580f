!> Preparation of a scene with a map: one levelled map, its summits as a surface, its loading.
module asperity_map_scene
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_effect_names, only: effect_on, known_effects, why_not_together
  use asperity_height_map, only: height_map, is_measured, no_height
  use asperity_kinds, only: int64, real64
  use asperity_map_despiking, only: despike_map
  use asperity_map_form, only: add_form
  use asperity_map_levelling, only: level_map
  use asperity_map_summits, only: find_summits, map_summits, rule_contact, usual_radius
  use asperity_numeral, only: rounded_decimal
  use asperity_scene_values, only: combined_modulus, control_compression, control_pressure, &
                                   effect_auto, effect_coupled, is_load, scene
  implicit none
  private

  public :: area_of_map, join_maps, list_map_loads, map_loading, summits_of_scene

  !> Loads or levels of a map.
  type :: map_loading
    real(real64) :: modulus = 0.0_real64          !! combined modulus, > 0
    logical :: by_load = .true.                   !! whether values are loads, else levels
    real(real64), allocatable :: values(:)        !! loads or levels, at least one
  end type map_loading

contains

  !> Makes the map that is in contact with a rigid plane: levelled, without outliers when chosen;
  !> the sum of two maps, and its form.
  subroutine join_maps(scene_in, map, failure)
    type(scene), intent(in) :: scene_in    !! scene with a map, or two on the same grid
    type(height_map), intent(out) :: map   !! map; pixels missing in one of two maps are missing
    character(len=:), allocatable, intent(out) :: failure  !! reason, when memory is short
    type(height_map) :: other

    associate (maps => scene_in%map)
      if (maps%lower%columns > 0) map = maps%lower
      if (maps%lower%columns == 0) map = maps%upper
      call make_level(map)
      if (maps%lower%columns > 0 .and. maps%upper%columns > 0) then
        other = maps%upper
        call make_level(other)
        where (is_measured(map%height) .and. is_measured(other%height))
          map%height = map%height + other%height
        else where
          map%height = no_height
        end where
        ! A pixel may be missing in one of the maps only.
        call level_map(map, maps%level)
      end if
      call add_form(map, maps%form_radius)
    end associate

  contains

    subroutine make_level(one)
      type(height_map), intent(inout) :: one
      integer(int64) :: spikes

      call level_map(one, scene_in%map%level)
      if (scene_in%map%despike .and. .not. allocated(failure)) &
        call despike_map(one, scene_in%map%level, .false., spikes, failure)
    end subroutine make_level

  end subroutine join_maps

  !> Area of the measured pixels, length squared.
  pure real(real64) function area_of_map(map) result(area)
    type(height_map), intent(in) :: map  !! height map, levelled or not

    area = product(map%pixel_spacing) * count(is_measured(map%height))
  end function area_of_map

  !> Makes the scene with the summits of the map as its lower surface, under a plane.
  subroutine summits_of_scene(scene_in, map, plain, summits, failure)
    type(scene), intent(in) :: scene_in                     !! scene with a map
    type(height_map), intent(in) :: map                     !! map of `join_maps`
    type(scene), intent(out) :: plain                       !! scene of summits, without a map
    type(map_summits), intent(out) :: summits               !! summits of the map
    character(len=:), allocatable, intent(out) :: failure   !! reason, when there are none
    integer :: i

    call find_summits(map, rule_contact, usual_radius(rule_contact), summits, failure)
    if (allocated(failure)) return
    if (size(summits%x) == 0) then
      failure = 'the map has no summit: expected interaction = ''boundary'', which solves ' // &
                'its pixels'
      return
    end if
    plain = scene_in
    deallocate (plain%map)
    if (plain%nominal_area%all_digits == 0_int64) &
      plain%nominal_area = rounded_decimal(area_of_map(map), 17)
    ! The error of Hertzian contacts, which `auto` would avoid, is less than that of summits. Beside
    ! an effect without a common theory `auto` leaves interaction out.
    if (plain%effects%mode('interaction') == effect_auto .and. .not. any([( &
        plain%effects%modes(i) == effect_on .and. why_not_together(trim(known_effects(i)%name), &
        'on', 'interaction', 'coupled') /= '', i=1, size(known_effects))])) &
      call plain%effects%call_for('interaction', effect_coupled)
    associate (upper => plain%upper, lower => plain%lower)
      upper%is_plane = .true.
      upper%x = [real(real64) ::]
      upper%y = upper%x
      upper%height = upper%x
      upper%radius = upper%x
      lower%is_plane = .false.
      lower%x = summits%x
      lower%y = summits%y
      lower%height = summits%height
      lower%radius = summits%radius
    end associate
  end subroutine summits_of_scene

  !> Lists the loads or levels of a scene; a curve begins at first contact.
  subroutine list_map_loads(scene_in, map, loading, failure)
    type(scene), intent(in) :: scene_in           !! scene, not under control of a limit
    type(height_map), intent(in) :: map           !! map of `join_maps`
    type(map_loading), intent(out) :: loading     !! loads or levels of the map
    character(len=:), allocatable, intent(out) :: failure  !! reason, when a load underflows
    type(decimal_value), allocatable :: ends(:)
    real(real64) :: from, to, unit
    integer :: i, j, parts

    loading%modulus = combined_modulus(scene_in)
    loading%by_load = is_load(scene_in%loading%control)
    if (allocated(scene_in%loading%path)) then
      allocate (ends, source=scene_in%loading%path)
    else
      allocate (ends(1), source=scene_in%loading%value)
    end if
    unit = 1.0_real64
    if (scene_in%loading%control == control_pressure) then
      unit = decimal_to_real64(scene_in%nominal_area)
      if (.not. unit > 0.0_real64) unit = area_of_map(map)
    end if
    parts = max(1, scene_in%loading%points)
    from = 0.0_real64
    if (.not. loading%by_load) from = maxval(map%height)
    allocate (loading%values(merge(1, 0, parts > 1)), source=from)
    do i = 1, size(ends)
      to = unit * decimal_to_real64(ends(i))
      if (scene_in%loading%control == control_compression) to = maxval(map%height) - to
      if (loading%by_load .and. ends(i)%all_digits > 0 .and. &
          .not. to / real(parts, real64) > 0.0_real64) then
        failure = 'a load of the map is too small for a double, expected other units'
        return
      end if
      do j = 1, parts
        loading%values = [loading%values, from + (to - from) * j / parts]
      end do
      loading%values(size(loading%values)) = to
      from = to
    end do
  end subroutine list_map_loads

end module asperity_map_scene
