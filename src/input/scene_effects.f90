!> Group &effects of a scene: which effects, their numbers, and which go together.
module asperity_scene_effects
  use asperity_decimal, only: decimal_value
  use asperity_effect_combinations, only: why_not_together
  use asperity_kinds, only: int64, real64
  use asperity_numeral, only: nearest_double
  use asperity_scene_fields, only: above_zero, not_negative, scene_fields, share, share_or_all
  use asperity_scene_values, only: control_approach, criterion_none, effect_auto, &
                                   effect_boundary, effect_coupled, effect_off, &
                                   effect_on, effect_words, hold_words, scene, scene_effects
  implicit none
  private

  public :: read_effects

  ! States of a hold are bounded, as those of a curve.
  integer, parameter :: most_hold_points = 100000

contains

  !> Reads the group. An effect's own numbers may stand there while it is off, so that it can be
  !> switched off with one word; with `auto` a number that is left out is none of its kind: no work
  !> of adhesion, no hold.
  subroutine read_effects(fields, checked)
    type(scene_fields), intent(inout) :: fields  !! the scene's text
    type(scene), intent(inout) :: checked        !! with material and limit; gets the effects
    integer, parameter :: interactions(4) = &
      [effect_off, effect_auto, effect_coupled, effect_boundary]
    integer, parameter :: switches(3) = [effect_off, effect_on, effect_auto]

    associate (effects => checked%effects)
      call take_effect(fields, 'interaction', interactions, effects%interaction)
      call take_effect(fields, 'friction', switches, effects%friction)
      call take_effect(fields, 'plasticity', switches, effects%plasticity)
      call take_effect(fields, 'adhesion', switches, effects%adhesion)
      call take_effect(fields, 'creep', switches, effects%creep)
      call take('tolerance', share, effects%tolerance)
      call take('boundary_tolerance', share, effects%boundary_tolerance)
      call take('friction_coefficient', not_negative, effects%friction_coefficient)
      call take('plastic_yield_stress', above_zero, effects%plastic_yield_stress)
      call take('work_of_adhesion', not_negative, effects%work_of_adhesion)
      call take('equilibrium_distance', above_zero, effects%equilibrium_distance)
      call take('relaxation_time', not_negative, effects%relaxation_time)
      call take('relaxed_modulus_ratio', share_or_all, effects%relaxed_modulus_ratio)
      call take('hold_time', not_negative, effects%hold_time)
      call fields%take_word('effects', 'hold', hold_words, effects%hold)
      call fields%take_whole('effects', 'hold_points', 2, most_hold_points, effects%hold_points)

      call require(fields, effects%friction == effect_on, 'friction_coefficient', &
                   'friction = ''on''')
      call require(fields, effects%adhesion == effect_on, 'work_of_adhesion', &
                   'adhesion = ''on''')
      call require(fields, effects%adhesion /= effect_off .and. &
                   effects%work_of_adhesion%digits /= 0_int64, 'equilibrium_distance', &
                   'adhesion and a work of adhesion')
      call require(fields, effects%creep == effect_on, 'hold_time', 'creep = ''on''')
      call require(fields, effects%creep /= effect_off .and. effects%hold_time%digits /= 0_int64, &
                   'relaxation_time', 'creep and a hold')
      call require(fields, effects%creep /= effect_off .and. effects%hold_time%digits /= 0_int64, &
                   'relaxed_modulus_ratio', 'creep and a hold')
      call require(fields, effects%plasticity /= effect_off .and. &
                   checked%limit%criterion == criterion_none, 'plastic_yield_stress', &
                   'plasticity and no limit')
      if (effects%friction /= effect_off .and. effects%friction_coefficient%digits /= 0_int64 &
          .and. goes_back(checked)) &
        call fields%complain_of('effects', 'friction', 'friction is computed for surfaces ' // &
                                'that close without going back: found a path in &loading ' // &
                                'that does, expected friction = ''off''')
      call check_together(fields, effects)
    end associate

  contains

    subroutine take(name, range, value)
      character(len=*), intent(in) :: name
      integer, intent(in) :: range
      type(decimal_value), intent(inout) :: value

      call fields%take_number('effects', name, range, value)
    end subroutine take

  end subroutine read_effects

  ! Whether the path of loads or approaches goes back anywhere.
  pure logical function goes_back(checked)
    type(scene), intent(in) :: checked
    real(real64), allocatable :: closing(:)
    integer :: last

    goes_back = .false.
    if (.not. allocated(checked%loading%path)) return
    last = size(checked%loading%path)
    allocate (closing(last))
    closing = nearest_double(checked%loading%path)
    if (checked%loading%control == control_approach) closing = -closing
    goes_back = any(closing(2:) < closing(:last - 1))
  end function goes_back

  ! One of the words that an effect knows.
  subroutine take_effect(fields, name, known, effect)
    type(scene_fields), intent(inout) :: fields
    character(len=*), intent(in) :: name
    integer, intent(in) :: known(:)
    integer, intent(inout) :: effect
    integer :: chosen

    chosen = 1
    call fields%take_word('effects', name, effect_words(known), chosen)
    effect = effect_off
    if (chosen > 0) effect = known(chosen)
  end subroutine take_effect

  ! A number that something needs.
  subroutine require(fields, is_needed, name, for_what)
    type(scene_fields), intent(inout) :: fields
    logical, intent(in) :: is_needed
    character(len=*), intent(in) :: name, for_what

    if (.not. is_needed .or. fields%has('effects', name)) return
    call fields%complain_of_group('effects', 'no ' // name // ' in &effects: expected one ' // &
                                  'with ' // for_what)
  end subroutine require

  ! Effects whose theories do not go together. With `auto` it shows only at a position whether both
  ! are called for.
  subroutine check_together(fields, effects)
    type(scene_fields), intent(inout) :: fields
    type(scene_effects), intent(in) :: effects
    character(len=11), parameter :: names(5) = &
      [character(len=11) :: 'interaction', 'friction', 'plasticity', 'adhesion', 'creep']
    character(len=8) :: words(5)
    character(len=:), allocatable :: why
    integer :: i, j, modes(5)

    modes = [effects%interaction, effects%friction, effects%plasticity, effects%adhesion, &
             effects%creep]
    words = effect_words(modes)
    do i = 1, size(names)
      do j = 1, i - 1
        if (any([modes(i), modes(j)] == effect_off) .or. &
            any([modes(i), modes(j)] == effect_auto)) cycle
        why = why_not_together(trim(names(i)), trim(words(i)), trim(names(j)), trim(words(j)))
        if (why /= '') call fields%complain_of('effects', trim(names(i)), why // &
                                               ', expected one of them off')
      end do
    end do
  end subroutine check_together

end module asperity_scene_effects
