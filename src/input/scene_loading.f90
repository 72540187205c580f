!> Groups &loading and &limit of a scene: how far the surfaces close, and when a contact is at its
!> limit.
module asperity_scene_loading
  use asperity_kinds, only: int64, real64
  use asperity_loading_controls, only: accepted_values, control_of, depth_of
  use asperity_problems, only: decimal_text
  use asperity_scene_fields, only: scene_fields
  use asperity_scene_names, only: most_values
  use asperity_scene_surfaces, only: from_csv
  use asperity_scene_values, only: criterion_greenwood_williamson, criterion_hardy, &
                                   criterion_load, criterion_none, criterion_pressure, &
                                   criterion_words, effect_off, effect_on, has_tangential, &
                                   is_limit, is_load, scene, scene_loading
  implicit none
  private

  public :: read_loading, check_states, read_limit

  integer, parameter :: most_states = 2000000  ! room for results is bounded

contains

  !> Group &loading.
  subroutine read_loading(fields, checked)
    type(scene_fields), intent(inout) :: fields  !! the scene's text
    type(scene), intent(inout) :: checked        !! its loading is filled
    integer :: control, events

    control = 1
    events = effect_off
    associate (loading => checked%loading)
      call fields%take('loading', 'control', control)
      loading%control = control_of(control)
      call read_path(fields, loading)
      call fields%take('loading', 'points', loading%points)
      call fields%take('loading', 'events', events)
      loading%events = events == effect_on
      call fields%take('loading', 'tangential_load', loading%tangential_load)
      call fields%take('loading', 'tangential_displacement', loading%tangential_displacement)
      ! One value is that along x.
      if (fields%value_count('loading', 'tangential_load') == 1) loading%tangential_load(2) = 0
      if (fields%value_count('loading', 'tangential_displacement') == 1) &
        loading%tangential_displacement(2) = 0
      if (any(abs(loading%tangential_load) > 0.0_real64)) &
        call fields%refuse_name('loading', 'tangential_displacement', 'found beside ' // &
                                'tangential_load, expected one of them')
      call read_tangential_path(fields, loading)
      if (loading%events .and. allocated(loading%path)) &
        call fields%complain_of('loading', 'events', 'found beside several values, ' // &
                                'expected one value: a path has its points alone')
      ! It is not known what a refused control would need.
      if (control == 0) return
      call check_need(fields, 'loading', 'value', .not. is_limit(loading%control), &
                'control = ''' // trim(loading%control%word) // '''')
      if (loading%control%is_per_area .and. &
          .not. (allocated(checked%map) .or. fields%lacks_file) .and. &
          .not. checked%nominal_area > 0.0_real64) &
        call fields%complain_of('loading', 'control', 'a pressure needs an area: found no ' // &
                                'nominal_area in &surfaces, expected one')
    end associate
  end subroutine read_loading

  !> One value, or several to go to one after the other. A load may go back to zero, and below where
  !> surfaces attract each other: `read_effects` sees to it that they do.
  subroutine read_path(fields, loading)
    type(scene_fields), intent(inout) :: fields
    type(scene_loading), intent(inout) :: loading
    integer :: number, problems
    logical :: pulls

    problems = fields%problems%count()
    pulls = fields%has_name('effects', 'adhesion') .or. &
            fields%has_name('effects', 'work_of_adhesion')
    number = fields%value_count('loading', 'value')
    if (number <= 1 .or. is_limit(loading%control)) then
      call fields%take('loading', 'value', loading%value, &
                       accepted_values(loading%control, .false., pulls))
    else if (number > most_values) then
      call fields%complain_of('loading', 'value', 'too many values: found ' // &
                              decimal_text(number) // ', expected at most ' // &
                              decimal_text(most_values))
    else
      allocate (loading%path(number))
      call fields%take('loading', 'value', loading%path, &
                       accepted_values(loading%control, .true., pulls))
      loading%value = loading%path(maxloc(depth_of(loading%control, loading%path), 1))
      if (is_load(loading%control) .and. .not. pulls .and. &
          .not. abs(loading%value) > 0.0_real64 .and. fields%problems%count() == problems) &
        call fields%complain_of('loading', 'value', 'no load is more than 0, expected one')
    end if
  end subroutine read_path

  !> Pairs of a tangential load along x and y.
  subroutine read_tangential_path(fields, loading)
    type(scene_fields), intent(inout) :: fields
    type(scene_loading), intent(inout) :: loading
    real(real64), allocatable :: loads(:)
    integer :: number

    if (has_tangential(loading)) call fields%refuse_name('loading', 'tangential_path', &
      'found beside another tangential load, expected one of them')
    number = fields%value_count('loading', 'tangential_path')
    if (number == 0) return
    if (mod(number, 2) > 0 .or. number > most_values) then
      call fields%complain_of('loading', 'tangential_path', 'found ' // decimal_text(number) // &
                              ' values, expected x and y of each point, at most ' // &
                              decimal_text(most_values) // ' values')
      return
    end if
    allocate (loads(number))
    call fields%take('loading', 'tangential_path', loads)
    loading%tangential_path = reshape(loads, [2, number / 2])
  end subroutine read_tangential_path

  !> A curve at every position must have room.
  subroutine check_states(fields, checked)
    type(scene_fields), intent(inout) :: fields  !! the scene's text
    type(scene), intent(in) :: checked           !! motion, loading and effects are filled
    integer(int64) :: states

    states = int(checked%motion%positions, int64) * int(max(1, checked%loading%points), int64)
    if (allocated(checked%loading%path)) states = states * size(checked%loading%path)
    if (checked%effects%mode('creep') /= effect_off) states = states + &
      int(checked%motion%positions, int64) * nint(checked%effects%number('hold_points'), int64)
    if (states > int(most_states, int64)) &
      call fields%complain_of_group('loading', 'too many states: found ' // &
           decimal_text(checked%motion%positions) // ' positions with ' // &
           decimal_text(checked%loading%points) // ' points each, expected at most ' // &
           decimal_text(most_states) // ' states')
  end subroutine check_states

  !> Group &limit. A deck brings the thesis' limit load; for CSV files there is no default.
  subroutine read_limit(fields, checked)
    type(scene_fields), intent(inout) :: fields  !! the scene's text
    type(scene), intent(inout) :: checked        !! its limit is filled
    character(len=:), allocatable :: for_what
    logical :: has_value

    associate (limit => checked%limit)
      if (.not. fields%has_group('limit') .and. from_csv(fields) .and. &
          .not. is_limit(checked%loading%control)) then
        limit%criterion = criterion_none
        return
      end if
      call fields%take('limit', 'criterion', limit%criterion)
      has_value = fields%has_name('limit', 'value')
      if (limit%criterion /= criterion_load .or. has_value) then
        limit%from_thesis = .false.
        limit%value = 0.0_real64
      end if
      call fields%take('limit', 'value', limit%value)
      call fields%take('limit', 'hardness', limit%hardness)
      call fields%take('limit', 'yield_stress', limit%yield_stress)
      ! It is not known what a refused criterion would need.
      if (limit%criterion == 0) return
      for_what = 'criterion = ''' // trim(criterion_words(limit%criterion)) // ''''
      call check_need(fields, 'limit', 'value', limit%criterion == criterion_pressure .or. &
                (limit%criterion == criterion_load .and. (from_csv(fields) .or. has_value)), &
                for_what)
      call check_need(fields, 'limit', 'hardness', &
                limit%criterion == criterion_greenwood_williamson, for_what, &
                ', or criterion = ''greenwood_williamson''')
      call check_need(fields, 'limit', 'yield_stress', limit%criterion == criterion_hardy, &
                for_what, ', or criterion = ''hardy''')
    end associate
  end subroutine read_limit

  !> A name that something needs must stand there; one that nothing needs must not.
  subroutine check_need(fields, group, name, is_needed, for_what, or_else)
    type(scene_fields), intent(inout) :: fields
    character(len=*), intent(in) :: group, name, for_what
    logical, intent(in) :: is_needed
    character(len=*), intent(in), optional :: or_else  ! what would use the name
    character(len=:), allocatable :: text

    if (is_needed .and. .not. fields%has_name(group, name)) then
      text = for_what // ' needs '
      if (.not. (fields%has_group('loading') .or. fields%has_name('limit', 'criterion'))) &
        text = 'no control and value in &loading; without them control is ''limit'', which needs '
      call fields%complain_of_group(group, text // name // ' in &' // group // ': found none, ' // &
                                    'expected one')
    else if (.not. is_needed) then
      text = 'not used with ' // for_what // ', expected none'
      if (present(or_else)) text = text // or_else
      call fields%refuse_name(group, name, text)
    end if
  end subroutine check_need

end module asperity_scene_loading
