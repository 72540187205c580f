!> The names of group &effects: the effects, how a scene may call for each, their numbers, and which
!> effects go together.
!>
!> The reader and its messages, the values of a scene and `asperity solve --help` use this table.
module asperity_effect_names
  use asperity_kinds, only: real64
  use asperity_numeral, only: above_zero, not_negative, share, share_or_all
  use asperity_scene_fields, only: known_name, most_words, one_word, whole_number, word_length
  implicit none
  private

  public :: effect_off, effect_on, effect_auto, effect_coupled, effect_boundary, effect_words
  public :: by_default, by_numbers, by_word
  public :: hold_load, hold_separation, hold_words
  public :: law_exponential, most_relaxations
  public :: known_effect, known_effects, effect_numbers
  public :: of_interaction, of_friction, of_plasticity, of_adhesion, of_creep
  public :: go_together, needed_for, why_not_together

  integer, parameter :: effect_off = 1       !! the effect is left out
  integer, parameter :: effect_on = 2        !! the effect is simulated
  integer, parameter :: effect_auto = 3      !! simulated where it matters more than the tolerance
  integer, parameter :: effect_coupled = 4   !! interaction only: contacts lower each other
  integer, parameter :: effect_boundary = 5  !! interaction only: boundary elements everywhere
  !> The words of a scene for them.
  character(len=*), parameter :: effect_words(5) = &
    [character(len=8) :: 'off', 'on', 'auto', 'coupled', 'boundary']

  integer, parameter :: by_default = 0  !! the scene does not mention the effect
  integer, parameter :: by_numbers = 1  !! the scene gives the effect's own numbers
  integer, parameter :: by_word = 2     !! the scene writes how the effect is simulated

  integer, parameter :: hold_load = 1        !! creep only: the load is held
  integer, parameter :: hold_separation = 2  !! creep only: the separation is held
  !> The words of a scene for them.
  character(len=*), parameter :: hold_words(3) = &
    [character(len=13) :: 'load', 'separation', 'approach']
  integer, parameter :: law_exponential = 1    !! adhesion on pixels: attraction w/rho exp(-g/rho)
  character(len=*), parameter :: none(most_words - 2) = ''  ! pads lists of words

  integer, parameter :: most_relaxations = 20  !! largest number of relaxation times

  !> An effect. Where a scene does not write how it is simulated, `asperity_scene_effects` does.
  type :: known_effect
    character(len=11) :: name = ''     !! in &effects
    integer :: modes(4) = 0            !! how it may be called for, `off` first; 0: no more
    character(len=72) :: meaning = ''  !! what it adds
    character(len=56) :: needs = ''    !! of the material, beside the combined modulus
    character(len=20) :: own(2) = ''   !! numbers that call for it where none of them is 0
    !> Why the pixels of a map do not have it; blank: they do. Plasticity needs a hardness there.
    character(len=88) :: not_on_pixels = ''
    character(len=88) :: not_on_asperities = ''  !! why asperities do not have it; blank: they do
  end type known_effect

  integer, parameter :: switch(4) = [effect_off, effect_on, effect_auto, 0]

  !> All effects.
  type(known_effect), parameter :: known_effects(*) = [ &
    known_effect('interaction', [effect_off, effect_auto, effect_coupled, effect_boundary], &
                 'elastic interaction between contacts'), &
    known_effect('friction', switch, &
                 'tangential forces of inclined contacts, lateral forces on the fixture', &
                 'shear moduli: elastic_modulus and poisson_ratio', &
                 [character(len=20) :: 'friction_coefficient', '']), &
    known_effect('plasticity', switch, 'plastic flow beyond first yield, residual flattening', &
                 'Poisson''s ratio of the body that yields: poisson_ratio', &
                 [character(len=20) :: 'plastic_yield_stress', ''], &
                 'without plastic_hardness it is computed for asperities, not for the pixels ' // &
                 'of a map'), &
    known_effect('adhesion', switch, 'attraction between the surfaces: snap-in, pull-off', &
                 own=[character(len=20) :: 'work_of_adhesion', '']), &
    known_effect('creep', switch, 'relaxation or creep during loading and a hold', &
                 own=[character(len=20) :: 'hold_time', ''])]

  integer, parameter :: of_interaction = 1  !! place of interaction among them
  integer, parameter :: of_friction = 2     !! place of friction
  integer, parameter :: of_plasticity = 3   !! place of plasticity
  integer, parameter :: of_adhesion = 4     !! place of adhesion
  integer, parameter :: of_creep = 5        !! place of creep

  !> All numbers, in the order in which messages list them.
  type(known_name), parameter :: effect_numbers(*) = [ &
    known_name('effects', 'tolerance', share, &
               'relative error that ''auto'' may leave, of all effects together', &
               default=1.0e-2_real64), known_name('effects', 'boundary_tolerance', share, &
               'relative change of the load by halving the grid spacing', &
               default=1.0e-3_real64, effect='interaction'), &
    known_name('effects', 'area_tolerance', share, &
               'relative error of the area that is always accepted', &
               default=5.0e-3_real64, effect='interaction'), &
    known_name('effects', 'friction_coefficient', not_negative, &
               'tangential over normal load of a sliding contact', &
               effect='friction', needed_with='on'), &
    known_name('effects', 'coupling', one_word, &
               'friction on pixels changes the pressures of unlike bodies', effect='friction', &
               default=real(effect_auto, real64), &
               words=[character(len=word_length) :: effect_words(:effect_auto), none(2:)]), &
    known_name('effects', 'loading_steps', whole_number, &
               'increments of the normal load of a state with coupling', default=9.0_real64, &
               least=1, most=1000, effect='friction'), &
    known_name('effects', 'plastic_yield_stress', above_zero, &
               'yield stress in tension; without it flow begins at the limit', &
               unit='modulus', effect='plasticity', needed_with='no limit'), &
    known_name('effects', 'plastic_hardness', above_zero, &
               'largest pressure on the pixels of a height map', &
               unit='modulus', effect='plasticity', needed_with='pixels'), &
    known_name('effects', 'plastic_body', one_word, &
               'the body that yields; without it the one of smaller modulus', &
               words=[character(len=word_length) :: 'upper', 'lower', none], effect='plasticity'), &
    known_name('effects', 'work_of_adhesion', not_negative, &
               'work to separate a unit area of the two surfaces', unit='modulus times length', &
               effect='adhesion', needed_with='on', in_words='a work of adhesion'), &
    known_name('effects', 'equilibrium_distance', above_zero, &
               'gap between surfaces in contact; sets the range of attraction', unit='length', &
               default=1.0_real64, effect='adhesion', needed_with='work_of_adhesion'), &
    known_name('effects', 'adhesion_law', one_word, &
               'attraction across the gap on the pixels of a height map', effect='adhesion', &
               default=real(law_exponential, real64), &
               words=[character(len=word_length) :: 'exponential', 'van_der_waals', none]), &
    known_name('effects', 'relaxation_time', not_negative, &
               'time after which 1/e of a relaxing part is left; several: ascending', &
               unit='time', effect='creep', needed_with='hold_time'), &
    known_name('effects', 'relaxed_modulus_ratio', share_or_all, &
               'relaxed over instantaneous modulus; several: after each time', &
               default=1.0_real64, effect='creep', needed_with='hold_time'), &
    known_name('effects', 'loading_time', not_negative, &
               'duration of loading or of a path, at a constant rate', unit='time', &
               effect='creep'), &
    known_name('effects', 'hold_time', not_negative, 'duration of the hold after loading', &
               unit='time', effect='creep', needed_with='on', in_words='a duration', &
               instead='loading_time'), &
    known_name('effects', 'hold', one_word, 'quantity held constant', effect='creep', &
               default=real(hold_load, real64), &
               words=[character(len=word_length) :: hold_words, none(2:)]), &
    known_name('effects', 'hold_points', whole_number, 'states of the hold', &
               default=20.0_real64, least=2, most=100000, effect='creep')]

  ! Two effects and why they are not computed together, on asperities and on the pixels of a map;
  ! blank: they are. What pixels do not have at all is in `known_effects`.
  type :: effect_pair
    character(len=11) :: one, other  ! as in &effects
    character(len=72) :: on_asperities
    character(len=72) :: on_pixels = ''
    character(len=8) :: mode = ''    ! only where `one` is simulated in this way; blank: in any
  end type effect_pair

  type(effect_pair), parameter :: pairs(*) = [ &
    effect_pair('adhesion', 'plasticity', 'the theories of adhesion are elastic'), &
    effect_pair('adhesion', 'creep', 'the theory of creep has no attraction'), &
    effect_pair('adhesion', 'interaction', &
                'displacements by neighbours assume Hertzian, not adhesive, pressures'), &
    effect_pair('adhesion', 'friction', &
                'shear changes adhesion, and Coulomb''s law has no attraction'), &
    effect_pair('creep', 'plasticity', 'the theory of creep is for elastic contacts'), &
    effect_pair('creep', 'friction', 'slip and creep together have no closed theory', &
                'slip and creep together have no closed theory'), &
    effect_pair('interaction', 'plasticity', &
                'boundary elements are elastic: use interaction = ''coupled''', mode='boundary')]

contains

  !> Returns what makes a number necessary: `friction = 'on'`, `creep and a hold`; empty: nothing.
  pure function needed_for(number) result(text)
    type(known_name), intent(in) :: number  !! entry of the number in `effect_numbers`
    character(len=:), allocatable :: text      !! for a message

    select case (number%needed_with)
    case ('')
      text = ''
    case ('on')
      text = trim(number%effect) // ' = ''on'''
    case ('no limit')
      text = trim(number%effect) // ' and no limit'
    case ('pixels')
      text = trim(number%effect) // ' on the pixels of a map'
    case default
      text = trim(number%effect) // ' and ' // &
             trim(effect_numbers(findloc(effect_numbers%name, number%needed_with, 1))%in_words)
    end select
  end function needed_for

  !> Why two effects are not computed together; empty when they are.
  pure function why_not_together(first, first_way, second, second_way, on_pixels) result(why)
    character(len=*), intent(in) :: first, second          !! two effects, as in &effects
    character(len=*), intent(in) :: first_way, second_way  !! how each is simulated
    logical, intent(in) :: on_pixels            !! on the pixels of a map; .false.: on asperities
    character(len=:), allocatable :: why        !! sentence for a message
    integer :: i

    why = ''
    i = conflict_of(first, first_way, second, second_way, on_pixels)
    if (i > 0) why = first // ' and ' // second // ' do not go together: ' // &
                     trim(merge(pairs(i)%on_pixels, pairs(i)%on_asperities, on_pixels))
  end function why_not_together

  !> Whether two effects are computed together on asperities.
  pure logical function go_together(first, first_way, second, second_way)
    character(len=*), intent(in) :: first, second          !! two effects, as in &effects
    character(len=*), intent(in) :: first_way, second_way  !! how each is simulated

    go_together = conflict_of(first, first_way, second, second_way, .false.) == 0
  end function go_together

  ! Entry of two effects that are not computed together; 0: they are.
  pure integer function conflict_of(first, first_way, second, second_way, on_pixels) result(found)
    character(len=*), intent(in) :: first, first_way, second, second_way
    logical, intent(in) :: on_pixels
    logical :: as_named(size(pairs)), reversed(size(pairs))

    as_named = pairs%one == first .and. pairs%other == second .and. &
               (pairs%mode == '' .or. pairs%mode == first_way)
    reversed = pairs%one == second .and. pairs%other == first .and. &
               (pairs%mode == '' .or. pairs%mode == second_way)
    found = findloc((as_named .or. reversed) .and. &
                    merge(pairs%on_pixels, pairs%on_asperities, on_pixels) /= '', .true., 1)
  end function conflict_of

end module asperity_effect_names
