!> Group &effects of a scene: which effects, their numbers, and which go together.
module asperity_scene_effects
  use asperity_effect_names, only: effect_numbers, known_effect, known_effects, needed_for, &
                                   of_creep, of_plasticity, why_not_together
  use asperity_kinds, only: real64
  use asperity_loading_controls, only: depth_of
  use asperity_numeral, only: above_zero, share_or_all
  use asperity_problems, only: decimal_text
  use asperity_scene_fields, only: known_name, scene_fields
  use asperity_scene_values, only: by_default, by_numbers, by_word, criterion_none, effect_auto, &
                                   effect_off, effect_on, effect_words, has_tangential, &
                                   is_limit, is_load, most_relaxations, scene, scene_effects, &
                                   scene_loading
  implicit none
  private

  public :: read_effects

  character(len=*), parameter :: no_way_back = 'friction is computed for surfaces that close ' // &
    'without going back: found a path in &loading that does'

  ! Numbers of creep that may be several.
  character(len=*), parameter :: relaxing(2) = &
    [character(len=21) :: 'relaxation_time', 'relaxed_modulus_ratio']

contains

  !> Reads the group. `interaction` is `auto` by default, every other effect where its own numbers
  !> are given; a default that is written out changes nothing. Numbers of an effect that is `off`
  !> may stay. With `auto` a number that is left out is none of its kind: no work of adhesion, no
  !> hold.
  subroutine read_effects(fields, checked)
    type(scene_fields), intent(inout) :: fields  !! the scene's text
    type(scene), intent(inout) :: checked        !! with material and limit; gets the effects
    character(len=:), allocatable :: why
    integer :: written(size(known_effects)), i

    associate (effects => checked%effects)
      do i = 1, size(known_effects)
        associate (effect => known_effects(i))
          written(i) = 1
          call fields%take('effects', trim(effect%name), written(i))
          if (written(i) > 0) written(i) = effect%modes(written(i))
        end associate
      end do
      call take_relaxation(fields, effects)
      do i = 1, size(effect_numbers)
        if (allocated(effects%relaxation) .and. any(effect_numbers(i)%name == relaxing)) cycle
        call fields%take('effects', trim(effect_numbers(i)%name), effects%numbers(i))
      end do
      do i = 1, size(known_effects)
        ! A group &limit says where flow begins, if loading goes on beyond it.
        if (effects%has_numbers(i) .or. (known_effects(i)%name == 'plasticity' .and. &
            (names_hardness(checked) .or. (fields%has_group('limit') .and. &
             .not. is_limit(checked%loading%control))))) effects%given(i) = by_numbers
        if (.not. fields%has_name('effects', trim(known_effects(i)%name)) .or. &
            written(i) == default_mode(effects, i)) cycle
        effects%given(i) = by_word
        if (written(i) > 0) effects%modes(i) = written(i)
      end do
      ! An effect that cannot be computed with the rest of the scene is left out with a note.
      ! Interaction comes last: it yields to what is asked for.
      do i = size(known_effects), 1, -1
        if (default_mode(effects, i) /= effect_auto) cycle
        why = why_not(fields, checked, trim(known_effects(i)%name))
        if (why == '') effects%modes(i) = effect_auto
        if (why /= '') &
          call checked%notes%add(checked%file // ': note: ' // trim(known_effects(i)%name) // &
                                 ' is left out: ' // why)
      end do
      call check_hardness(fields, checked)
      call require_numbers(fields, checked)
      if (effects%mode('creep') /= effect_off .and. effects%is_there('loading_time') .and. &
          checked%loading%events) &
        call fields%complain_of('loading', 'events', 'found beside loading_time in &effects, ' // &
                                'expected points: loading in time has states at equal distances')
      if (effects%mode('friction') /= effect_off .and. rubs_back(checked)) &
        call fields%complain_of('effects', 'friction', no_way_back // &
                                ', expected friction = ''off''')
      if (has_tangential(checked%loading)) call check_tangential(fields, checked)
      if (fields%has_name('effects', 'coupling') .and. &
          nint(effects%number('coupling')) == effect_on) call check_coupling(fields, checked)
      if (effects%mode('adhesion') == effect_off) call refuse_pulls(fields, checked%loading)
      call check_together(fields, checked)
      ! A combined modulus says nothing of the two bodies that it stands for.
      do i = 1, merge(size(known_effects), 0, checked%contact_modulus > 0.0_real64)
        if (effects%modes(i) == effect_off .or. known_effects(i)%needs == '') cycle
        if (known_effects(i)%name == 'plasticity' .and. flows_on_pixels(checked)) cycle
        call fields%complain_of('effects', trim(known_effects(i)%name), &
                                needs_both(known_effects(i)))
      end do
    end associate
  end subroutine read_effects

  ! The mode of an effect that the scene does not write; `effect_off` for one that it writes.
  pure integer function default_mode(effects, i) result(mode)
    type(scene_effects), intent(in) :: effects
    integer, intent(in) :: i

    mode = merge(effect_auto, effect_off, effects%given(i) == by_numbers .or. &
                 (effects%given(i) == by_default .and. known_effects(i)%name == 'interaction'))
  end function default_mode

  ! Why an effect that is not written cannot be computed with the rest of the scene; empty: it can.
  function why_not(fields, checked, name) result(why)
    type(scene_fields), intent(in) :: fields
    type(scene), intent(in) :: checked
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: why
    integer :: i

    why = ''
    do i = 1, size(effect_numbers)
      associate (number => effect_numbers(i))
        if (number%effect /= name .or. fields%has_name('effects', trim(number%name))) cycle
        if (all(effect_numbers%name /= number%needed_with)) cycle
        if (checked%effects%is_there(number%needed_with)) &
          why = 'it needs ' // trim(number%name) // ' in &effects'
      end associate
    end do
    associate (effect => known_effects(findloc(known_effects%name, name, 1)), &
               has_hardness_alone => name == 'plasticity' .and. names_hardness(checked))
      if (checked%contact_modulus > 0.0_real64 .and. effect%needs /= '' .and. &
          .not. has_hardness_alone) why = needs_both(effect)
      if (name == 'friction' .and. rubs_back(checked)) why = no_way_back
      if (.not. allocated(checked%map)) then
        if (why == '') why = trim(effect%not_on_asperities)
        return
      end if
      if (name /= 'interaction') then
        if (effect%not_on_pixels /= '' .and. .not. has_hardness_alone) &
          why = trim(effect%not_on_pixels)
        return
      end if
    end associate
  end function why_not

  ! Takes several relaxation times, ascending, with the modulus after each, descending.
  subroutine take_relaxation(fields, effects)
    type(scene_fields), intent(inout) :: fields
    type(scene_effects), intent(inout) :: effects
    integer :: i, number
    logical :: in_order

    number = max(fields%value_count('effects', trim(relaxing(1))), &
                 fields%value_count('effects', trim(relaxing(2))))
    if (number <= 1) return
    if (number > most_relaxations) then
      call fields%complain_of('effects', trim(relaxing(1)), 'too many values: found ' // &
             decimal_text(number) // ', expected at most ' // decimal_text(most_relaxations))
      return
    end if
    allocate (effects%relaxation(number, 2), source=0.0_real64)
    do i = 1, 2
      associate (values => effects%relaxation(:, i))
        call fields%take('effects', trim(relaxing(i)), values, &
                         merge(above_zero, share_or_all, i == 1))
        in_order = all(merge(1, -1, i == 1) * (values(2:) - values(:number - 1)) > 0.0_real64)
        if (fields%problems%count() == 0 .and. .not. in_order) &
          call fields%complain_of('effects', trim(relaxing(i)), 'the values are not ' // &
                 trim(merge('ascending ', 'descending', i == 1)) // ', expected relaxation ' // &
                 'times that rise and the modulus after each, which falls')
        effects%numbers(findloc(effect_numbers%name, relaxing(i), 1)) = values(number)
      end associate
    end do
  end subroutine take_relaxation

  ! Numbers that something else needs: another choice in &effects, or that there is no limit.
  subroutine require_numbers(fields, checked)
    type(scene_fields), intent(inout) :: fields
    type(scene), intent(in) :: checked
    integer :: i

    do i = 1, size(effect_numbers)
      associate (number => effect_numbers(i))
        if (number%needed_with == '' .or. fields%has_name('effects', trim(number%name))) cycle
        if (.not. is_needed(checked, number)) cycle
        if (number%needed_with == 'no limit') then
          call fields%complain_of_group('effects', trim(number%effect) // ' needs ' // &
                 trim(number%name) // ' in &effects, or a &limit: found neither, expected one')
        else
          call fields%complain_of_group('effects', trim(number%name) // ' is missing in ' // &
                 '&effects: found none, expected one with ' // needed_for(number))
        end if
      end associate
    end do
  end subroutine require_numbers

  ! Whether a scene must have a number.
  pure logical function is_needed(checked, number)
    type(scene), intent(in) :: checked
    type(known_name), intent(in) :: number
    integer :: mode

    mode = checked%effects%mode(number%effect)
    select case (number%needed_with)
    case ('on')
      is_needed = mode == effect_on .and. .not. checked%effects%is_there(trim(number%name))
    case ('no limit')
      is_needed = mode /= effect_off .and. checked%limit%criterion == criterion_none .and. &
                  .not. flows_on_pixels(checked)
    case ('pixels')
      is_needed = flows_on_pixels(checked)
    case default
      is_needed = mode /= effect_off .and. checked%effects%is_there(number%needed_with)
    end select
  end function is_needed

  ! A hardness is that of pixels, which have no yield stress; nothing else has it.
  subroutine check_hardness(fields, checked)
    type(scene_fields), intent(inout) :: fields
    type(scene), intent(in) :: checked
    character(len=*), parameter :: name = 'plastic_hardness'
    integer :: given

    given = checked%effects%given(findloc(known_effects%name, 'plasticity', 1))
    if (flows_on_pixels(checked)) then
      call fields%refuse_name('effects', 'plastic_yield_stress', 'the pixels of a map yield ' // &
                              'at a pressure: found a stress, expected ' // name // ' in its place')
    else if (fields%has_name('effects', name) .and. &
             (checked%effects%mode('plasticity') /= effect_off .or. given < by_word)) then
      call fields%complain_of('effects', name, 'it limits the pressures on the pixels of a map: ' &
           // 'found no pixels that are solved, expected plastic_yield_stress in its place, or ' &
           // 'a map and interaction = ''boundary''')
    end if
  end subroutine check_hardness

  ! Whether plasticity is called for on the pixels of a map.
  pure logical function flows_on_pixels(checked)
    type(scene), intent(in) :: checked

    flows_on_pixels = checked%effects%mode('plasticity') /= effect_off .and. allocated(checked%map)
  end function flows_on_pixels

  ! Whether a scene with a map names a hardness.
  pure logical function names_hardness(checked)
    type(scene), intent(in) :: checked

    names_hardness = allocated(checked%map) .and. checked%effects%is_there('plastic_hardness')
  end function names_hardness

  ! Only surfaces that attract each other bear a load of 0 or less by itself.
  subroutine refuse_pulls(fields, loading)
    type(scene_fields), intent(inout) :: fields
    type(scene_loading), intent(in) :: loading
    logical :: bad

    if (.not. is_load(loading%control) .or. .not. fields%has_name('loading', 'value')) return
    bad = .not. loading%value > 0.0_real64
    if (allocated(loading%path)) bad = bad .or. any(loading%path < 0.0_real64)
    if (bad .and. (fields%has_name('effects', 'adhesion') .or. &
                   fields%has_name('effects', 'work_of_adhesion'))) &
      call fields%complain_of('loading', 'value', 'a load of 0 or less needs adhesion: found ' // &
                              'adhesion = ''off'', expected loads above 0, or ''on'' or ''auto''')
  end subroutine refuse_pulls

  ! `friction needs shear moduli ... of both surfaces`.
  pure function needs_both(effect) result(text)
    type(known_effect), intent(in) :: effect
    character(len=:), allocatable :: text

    text = trim(effect%name) // ' needs ' // trim(effect%needs) // ' of both surfaces in ' // &
           '&material: found contact_modulus in their place'
  end function needs_both

  ! Pressures that friction changes are elastic pressures of a map.
  subroutine check_coupling(fields, checked)
    type(scene_fields), intent(inout) :: fields
    type(scene), intent(in) :: checked
    integer :: i

    if (.not. allocated(checked%map)) call fields%complain_of('effects', 'coupling', &
      'it needs the pixels of a map, expected ''off''')
    do i = of_plasticity, of_creep
      if (checked%effects%modes(i) /= effect_off) call fields%complain_of('effects', 'coupling', &
        'its theory has no ' // trim(known_effects(i)%name) // ', expected ''off''')
    end do
  end subroutine check_coupling

  ! A tangential load needs friction, and normal contacts without attraction or a hold.
  subroutine check_tangential(fields, checked)
    type(scene_fields), intent(inout) :: fields
    type(scene), intent(in) :: checked
    character(len=:), allocatable :: name
    integer :: i

    name = 'tangential_load'
    if (fields%has_name('loading', 'tangential_path')) name = 'tangential_path'
    if (name == 'tangential_path' .and. .not. allocated(checked%map)) &
      call fields%complain_of('loading', name, 'it needs the pixels of a map, expected ' // &
                              'tangential_load')
    if (fields%has_name('loading', 'tangential_displacement')) name = 'tangential_displacement'
    if (checked%effects%mode('friction') == effect_off) &
      call fields%complain_of('loading', name, 'it needs friction: found friction = ''off'', ' // &
                              'expected friction_coefficient in &effects and both ' // &
                              'elastic_modulus and poisson_ratio in &material')
    do i = 1, size(known_effects)
      if (checked%effects%modes(i) /= effect_off .and. (known_effects(i)%name == 'creep' .or. &
          (known_effects(i)%name == 'adhesion' .and. .not. allocated(checked%map)))) &
        call fields%complain_of('loading', name, 'its theory has no ' // &
                                trim(known_effects(i)%name) // ': found ' // &
                                trim(effect_words(checked%effects%modes(i))) // ', expected off')
    end do
  end subroutine check_tangential

  ! Whether friction would have to follow a path of loads or separations back. On the pixels of a
  ! map it has no history.
  pure logical function rubs_back(checked)
    type(scene), intent(in) :: checked
    real(real64), allocatable :: depth(:)

    rubs_back = checked%effects%is_there('friction_coefficient') .and. &
                allocated(checked%loading%path)
    rubs_back = rubs_back .and. .not. allocated(checked%map)
    if (.not. rubs_back) return
    allocate (depth, source=depth_of(checked%loading%control, checked%loading%path))
    rubs_back = any(depth(2:) < depth(:size(depth) - 1))
  end function rubs_back

  ! Effects whose theories do not go together. On asperities it shows with `auto` only at a position
  ! whether both are called for; on pixels one of `auto` is left out with a note.
  subroutine check_together(fields, checked)
    type(scene_fields), intent(inout) :: fields
    type(scene), intent(inout) :: checked
    character(len=:), allocatable :: why
    logical :: on_pixels
    integer :: automatic, i, j

    on_pixels = allocated(checked%map)
    associate (modes => checked%effects%modes)
      do i = 1, size(modes)
        do j = 1, i - 1
          if (any([modes(i), modes(j)] == effect_off)) cycle
          automatic = merge(j, merge(i, 0, modes(i) == effect_auto), modes(j) == effect_auto)
          if (automatic > 0 .and. .not. on_pixels) cycle
          why = why_not_together(trim(known_effects(i)%name), trim(effect_words(modes(i))), &
                                 trim(known_effects(j)%name), trim(effect_words(modes(j))), &
                                 on_pixels)
          if (why == '') cycle
          if (automatic > 0) then
            modes(automatic) = effect_off
            call checked%notes%add(checked%file // ': note: ' // &
                                   trim(known_effects(automatic)%name) // ' is left out: ' // why)
          else
            call fields%complain_of('effects', trim(known_effects(i)%name), why // &
                                    ', expected one of them off')
          end if
        end do
      end do
    end associate
  end subroutine check_together

end module asperity_scene_effects
