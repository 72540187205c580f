!> Preparation of a scene with a map: one levelled map, its summits as a surface, its loading.
module asperity_map_scene
  use asperity_contact_model, only: path_step
  use asperity_height_map, only: height_map, is_measured, level_none, move_map
  use asperity_kinds, only: int64, real64
  use asperity_loading_controls, only: in_model_units, separation_of
  use asperity_map_caps, only: add_caps, placed_caps
  use asperity_map_despiking, only: despike_map
  use asperity_map_form, only: add_form
  use asperity_map_levelling, only: level_map
  use asperity_map_motion, only: overlay_maps
  use asperity_map_resolution, only: doubled_map, every_pixel, refine_waves
  use asperity_map_top, only: find_top, first_contact
  use asperity_path_steps, only: plan_path
  use asperity_problems, only: decimal_text
  use asperity_scene_values, only: is_load, scene, scene_map, scene_motion
  implicit none
  private

  public :: area_of_map, change_resolution, displacement_of, finest_resolution, join_maps, &
            plan_map_path

  ! Pixels along a side of a map on fewer pixels (chosen: its own error is estimated on a third).
  integer, parameter :: fewest_pixels = 16
  ! Least resolution with all waves of a map that has none below 3 pixels.
  real(real64), parameter :: least_of_waves = 2.0_real64 / 3.0_real64
  ! Most pixels along a side over those of the map (chosen: 16 times the time of the map).
  real(real64), parameter :: most_pixels = 4.0_real64

contains

  !> Makes the map that is in contact with a rigid plane at a position: levelled, without outliers
  !> when chosen; the sum of two maps, or of a map and asperities, the upper body displaced; with
  !> its form.
  subroutine join_maps(scene_in, m, map, origin, failure, placed)
    type(scene), intent(in) :: scene_in       !! scene with one map or two
    integer, intent(in) :: m                  !! position, from 1
    type(height_map), intent(out) :: map      !! pixels missing in one of two maps are missing
    real(real64), intent(out) :: origin(2)    !! its first pixel from that of the lower map [length]
    character(len=:), allocatable, intent(out) :: failure  !! reason, when there is none
    type(placed_caps), intent(out), optional :: placed  !! asperities on the map, if there are any
    type(height_map) :: lower, upper
    type(placed_caps) :: caps

    origin = 0.0_real64
    associate (maps => scene_in%map)
      if (maps%lower%columns > 0) lower = maps%lower
      if (maps%lower%columns == 0) lower = maps%upper
      call make_level(lower)
      if (maps%lower%columns > 0 .and. maps%upper%columns > 0) then
        upper = maps%upper
        call make_level(upper)
        call overlay_maps(lower, upper, displacement_of(scene_in%motion, m), map, origin, failure)
        if (allocated(failure)) return
        ! A pixel may be missing in one of the maps only.
        if (all([map%columns, map%rows] == [lower%columns, lower%rows]) .and. &
            .not. any(abs(displacement_of(scene_in%motion, m)) > 0.0_real64)) &
          call level_map(map, maps%level)
      else
        call move_map(lower, map)
        if (.not. scene_in%upper%is_plane) call add_caps( &
          scene_in%upper, displacement_of(scene_in%motion, m), map, caps, failure)
        if (maps%lower%columns == 0) origin = displacement_of(scene_in%motion, m)
        if (.not. scene_in%lower%is_plane) call add_caps( &
          scene_in%lower, -displacement_of(scene_in%motion, m), map, caps, failure)
        if (allocated(failure)) return
        if (present(placed)) placed = caps
      end if
      call add_form(map, maps%form_radius)
      map%bodies = scene_in%bodies
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

  !> Largest resolution for `change_resolution`: 1 where the map is known on its pixels alone.
  real(real64) function finest_resolution(scene_in) result(finest)
    type(scene), intent(in) :: scene_in  !! scene with a map and one position
    character(len=:), allocatable :: failure
    type(height_map) :: fine, map
    real(real64) :: origin(2)
    logical :: is_known

    finest = 1.0_real64
    call join_maps(scene_in, 1, map, origin, failure)
    if (allocated(failure)) return
    call refine_waves(map, 1.0_real64, fine, is_known)
    if (is_known) finest = most_pixels
  end function finest_resolution

  !> Changes the pixels of a scene with one position, under the same loads: the map of `join_maps`
  !> against a plane, on every second or fourth pixel, or on more pixels: from the waves of the map
  !> where it is known between its pixels, else on pixels half as wide by cubics.
  subroutine change_resolution(changed, resolution, failure)
    type(scene), intent(inout) :: changed    !! scene with a map
    real(real64), intent(in) :: resolution   !! pixels along a side over those of the map
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is impossible
    type(height_map) :: map
    real(real64) :: origin(2)
    type(scene_map) :: new
    logical :: is_known
    integer :: step

    call join_maps(changed, 1, map, origin, failure)
    if (allocated(failure)) return
    if (.not. abs(changed%nominal_area) > 0.0_real64) changed%nominal_area = area_of_map(map)
    new%periodic = changed%map%periodic
    new%level = level_none
    step = nint(1.0_real64 / resolution)
    is_known = .false.
    if (resolution > least_of_waves) call refine_waves(map, resolution, new%lower, is_known)
    if (is_known) then
      continue
    else if (resolution > 1.0_real64) then
      new%lower = doubled_map(map)
    else
      new%lower = every_pixel(map, step)
      if (any(shape(new%lower%height) < fewest_pixels)) failure = 'the map has too few pixels'
      ! Pixels of another width would be another surface.
      if (any([map%repeats(1), map%repeats(2)] .and. mod(shape(map%height), step) /= 0)) &
        failure = decimal_text(step) // ' does not divide the number of pixels of a period'
    end if
    changed%map = new
    ! Asperities are in the map.
    changed%upper%is_plane = .true.
    changed%lower%is_plane = .true.
  end subroutine change_resolution

  !> Displacement of the upper body along x and y at a position.
  pure function displacement_of(motion, m) result(displacement)
    type(scene_motion), intent(in) :: motion  !! motion of the scene
    integer, intent(in) :: m                  !! position, from 1
    real(real64) :: displacement(2)

    displacement = [motion%x_first, motion%y_first] + (m - 1) * [motion%x_step, motion%y_step]
  end function displacement_of

  !> Area of the measured pixels, length squared.
  pure real(real64) function area_of_map(map) result(area)
    type(height_map), intent(in) :: map  !! height map, levelled or not

    area = product(map%pixel_spacing) * count(is_measured(map%height), kind=int64)
  end function area_of_map

  !> Plans the states of a map: loads, or levels of the plane above the mean plane.
  subroutine plan_map_path(scene_in, map, in_time, steps, failure)
    type(scene), intent(in) :: scene_in           !! scene, not under control of a limit
    type(height_map), intent(in) :: map           !! map of `join_maps`
    logical, intent(in) :: in_time                !! loading takes its time
    type(path_step), allocatable, intent(out) :: steps(:)
    character(len=:), allocatable, intent(out) :: failure  !! reason, when a load underflows
    real(real64), allocatable :: given(:)
    real(real64), allocatable :: ends(:)
    real(real64) :: area, duration, from
    type(first_contact) :: found

    if (allocated(scene_in%loading%path)) then
      allocate (given, source=scene_in%loading%path)
    else
      allocate (given(1), source=scene_in%loading%value)
    end if
    area = scene_in%nominal_area
    if (.not. area > 0.0_real64) area = area_of_map(map)
    ends = in_model_units(scene_in%loading%control, given, area, 0, 0)
    from = 0.0_real64
    duration = merge(scene_in%effects%number('loading_time'), 0.0_real64, in_time)
    if (is_load(scene_in%loading%control)) then
      if (any(given > 0.0_real64 .and. &
              .not. ends / max(1, scene_in%loading%points) > 0.0_real64)) then
        failure = 'a load of the map is too small for a double, expected other units'
        return
      end if
    else
      found = find_top(map)
      from = found%height
      ends = separation_of(scene_in%loading%control, ends, from, &
                           sum(map%height) / size(map%height, kind=int64))
    end if
    call plan_path(from, ends, scene_in%loading%points, is_load(scene_in%loading%control), &
                   duration, steps)
  end subroutine plan_map_path

end module asperity_map_scene
