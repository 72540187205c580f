!> The names of group &effects: the effects, how a scene may call for each, their numbers, and which
!> effects go together.
!>
!> All that knows them takes them from here: the reader and its messages, the values of a scene,
!> `asperity solve --help`. The tables of the documents are tested against that help.
module asperity_effect_names
  use asperity_decimal, only: decimal_value
  use asperity_kinds, only: int64
  use asperity_numeral, only: above_zero, not_negative, share, share_or_all
  implicit none
  private

  public :: effect_off, effect_on, effect_auto, effect_coupled, effect_boundary, effect_words
  public :: by_default, by_numbers, by_word
  public :: hold_load, hold_separation, hold_words
  public :: law_exponential, law_van_der_waals, law_words
  public :: known_effect, known_effects, effect_number, effect_numbers
  public :: most_relaxations, one_word, whole_number, needed_for, why_not_together

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
  integer, parameter :: law_van_der_waals = 2  !! adhesion on pixels: 2 w/z0 (1 + g/z0)**-3
  !> The words of a scene for them; the third has none.
  character(len=*), parameter :: law_words(3) = &
    [character(len=13) :: 'exponential', 'van_der_waals', '']
  ! The words of a scene for the body that yields; the third has none.
  character(len=*), parameter :: plastic_bodies(3) = [character(len=13) :: 'upper', 'lower', '']

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
                 own=[character(len=20) :: 'hold_time', 'relaxation_time'])]

  integer, parameter :: one_word = -1  !! a number is one of `words`, by its place, and no range
  integer, parameter :: whole_number = -2  !! a number is a whole one from `least` to `most`

  !> A number of an effect.
  type :: effect_number
    character(len=21) :: name = ''         !! in &effects
    character(len=11) :: effect = ''       !! whose it is; blank: of all under `auto`
    integer :: number_range = not_negative  !! of `asperity_numeral`, or one of the two above
    type(decimal_value) :: default = decimal_value()  !! when the scene does not have it
    !> When the scene must have it. `on`: with its effect on; `no limit`: with its effect, on or
    !> auto, and no limit; `pixels`: with its effect on the pixels of a map; the name of a number:
    !> with its effect and that number not 0.
    character(len=21) :: needed_with = ''
    character(len=18) :: in_words = ''     !! what there is when it is not 0, where others need that
    character(len=12) :: instead = ''      !! another number that does for it
    character(len=20) :: unit = ''         !! in words; blank: none
    character(len=72) :: meaning = ''      !! in a line
    character(len=13) :: words(3) = ''      !! for `one_word`
    integer :: least = 0                   !! for `whole_number`
    integer :: most = 0                    !! for `whole_number`
  end type effect_number

  !> All numbers, in the order in which messages list them.
  type(effect_number), parameter :: effect_numbers(*) = [ &
    effect_number('tolerance', '', share, decimal_value(1_int64, -2), &
                  meaning='relative error that ''auto'' may leave, of all effects together'), &
    effect_number('boundary_tolerance', 'interaction', share, decimal_value(1_int64, -3), &
                  meaning='relative change of the load by halving the grid spacing'), &
    effect_number('area_tolerance', 'interaction', share, decimal_value(5_int64, -3), &
                  meaning='relative error of the area that is always accepted'), &
    effect_number('friction_coefficient', 'friction', not_negative, needed_with='on', &
                  meaning='tangential over normal load of a sliding contact'), &
    effect_number('plastic_yield_stress', 'plasticity', above_zero, needed_with='no limit', &
                  unit='modulus', &
                  meaning='yield stress in tension; without it flow begins at the limit'), &
    effect_number('plastic_hardness', 'plasticity', above_zero, needed_with='pixels', &
                  unit='modulus', meaning='largest pressure on the pixels of a height map'), &
    effect_number('plastic_body', 'plasticity', one_word, words=plastic_bodies, &
                  meaning='the body that yields; without it the one of smaller modulus'), &
    effect_number('work_of_adhesion', 'adhesion', not_negative, needed_with='on', &
                  in_words='a work of adhesion', unit='modulus times length', &
                  meaning='work to separate a unit area of the two surfaces'), &
    effect_number('equilibrium_distance', 'adhesion', above_zero, decimal_value(1_int64, 0), &
                  needed_with='work_of_adhesion', unit='length', &
                  meaning='gap between surfaces in contact; sets the range of attraction'), &
    effect_number('adhesion_law', 'adhesion', one_word, &
                  decimal_value(int(law_exponential, int64), 0), words=law_words, &
                  meaning='attraction across the gap on the pixels of a height map'), &
    effect_number('relaxation_time', 'creep', not_negative, needed_with='hold_time', unit='time', &
                  meaning='time after which 1/e of a relaxing part is left; several: ascending'), &
    effect_number('relaxed_modulus_ratio', 'creep', share_or_all, decimal_value(1_int64, 0), &
                  needed_with='hold_time', &
                  meaning='relaxed over instantaneous modulus; several: after each time'), &
    effect_number('loading_time', 'creep', not_negative, unit='time', &
                  meaning='duration of loading or of a path, at a constant rate'), &
    effect_number('hold_time', 'creep', not_negative, needed_with='on', in_words='a duration', &
                  instead='loading_time', unit='time', &
                  meaning='duration of the hold after loading'), &
    effect_number('hold', 'creep', one_word, decimal_value(int(hold_load, int64), 0), &
                  words=hold_words, meaning='quantity held constant'), &
    effect_number('hold_points', 'creep', whole_number, decimal_value(20_int64, 0), &
                  least=2, most=100000, meaning='states of the hold')]

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
                'shear changes adhesion, and Coulomb''s law has no attraction', &
                'shear changes adhesion, and Coulomb''s law has no attraction'), &
    effect_pair('creep', 'plasticity', 'the theory of creep is for elastic contacts'), &
    effect_pair('creep', 'friction', 'slip and creep together have no closed theory', &
                'slip and creep together have no closed theory'), &
    effect_pair('interaction', 'plasticity', &
                'boundary elements are elastic: use interaction = ''coupled''', mode='boundary')]

contains

  !> Returns what makes a number necessary: `friction = 'on'`, `creep and a hold`; empty: nothing.
  pure function needed_for(number) result(text)
    type(effect_number), intent(in) :: number  !! entry of the number in `effect_numbers`
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
    character(len=*), intent(in) :: first       !! an effect, as in &effects
    character(len=*), intent(in) :: first_way   !! how it is simulated
    character(len=*), intent(in) :: second      !! another effect, as in &effects
    character(len=*), intent(in) :: second_way  !! how it is simulated
    logical, intent(in), optional :: on_pixels  !! on the pixels of a map; absent: on asperities
    character(len=:), allocatable :: why
    logical :: of_map
    integer :: i

    of_map = .false.
    if (present(on_pixels)) of_map = on_pixels
    why = ''
    do i = 1, size(pairs)
      if (.not. (is_pair(pairs(i), first, first_way, second) .or. &
                 is_pair(pairs(i), second, second_way, first))) cycle
      why = trim(merge(pairs(i)%on_pixels, pairs(i)%on_asperities, of_map))
      if (why /= '') why = first // ' and ' // second // ' do not go together: ' // why
    end do
  end function why_not_together

  ! Whether an entry of the table is that of these two effects.
  pure logical function is_pair(pair, one, mode, other)
    type(effect_pair), intent(in) :: pair
    character(len=*), intent(in) :: one, mode, other

    is_pair = pair%one == one .and. pair%other == other .and. (pair%mode == '' .or. &
                                                               pair%mode == mode)
  end function is_pair

end module asperity_effect_names
