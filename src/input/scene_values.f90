!> A scene: two surfaces, how they move and what stops them, as checked values.
!>
!> Numbers are the doubles nearest to what is written. Units are those of the input, one
!> consistent set; a deck brings cm, N and rad.
module asperity_scene_values
  use asperity_card_deck, only: card_deck
  use asperity_effect_names, only: by_default, by_numbers, by_word, effect_auto, effect_boundary, &
                                   effect_coupled, effect_numbers, effect_off, effect_on, &
                                   effect_words, hold_separation, hold_load, hold_words, &
                                   known_effects, most_relaxations
  use asperity_files, only: same_name
  use asperity_height_map, only: height_map, layered_body, level_plane
  use asperity_kinds, only: real64
  use asperity_loading_controls, only: control_limit, control_load, control_separation, &
                                       is_compression, is_distance, is_limit, is_load, &
                                       loading_control
  use asperity_problems, only: problem_list
  use asperity_scene_names, only: criterion_words, scene_rows
  implicit none
  private

  public :: scene_map, scene, scene_side, scene_surface, scene_motion, scene_loading, scene_limit, &
            scene_effects
  public :: control_limit, control_load, control_separation, is_compression, is_distance, &
            is_limit, is_load
  public :: criterion_none, criterion_load, criterion_pressure, criterion_greenwood_williamson, &
            criterion_hardy, criterion_words
  public :: hold_load, hold_separation, hold_words, most_relaxations
  public :: by_default, by_numbers, by_word
  public :: effect_off, effect_on, effect_auto, effect_coupled, effect_boundary, effect_words
  public :: thesis_limit_load, is_thesis_sweep, body_compliance, combined_modulus, has_hardness, &
            coupling_influence, dundurs_beta, has_caps, has_tangential, is_coupled, thesis_positions

  !> No limit is looked for. Only with surfaces from CSV files and a control other than the limit.
  integer, parameter :: criterion_none = 0
  integer, parameter :: criterion_load = 1      !! the load of a contact
  integer, parameter :: criterion_pressure = 2  !! the average pressure of a contact
  !> Greenwood and Williamson: the penetration at which plastic flow begins, from the hardness.
  integer, parameter :: criterion_greenwood_williamson = 3
  integer, parameter :: criterion_hardy = 4     !! greatest pressure at first yield (Hardy)

  !> Limit load of the thesis, 65*9.8/2.205 = 288.888... N, to 18 digits.
  real(real64), parameter :: thesis_limit_load = 288.888888888888889_real64

  integer, parameter :: thesis_positions = 100  !! positions of the original's sweep

  !> One surface, as it lies in its file: not rotated, mirrored, tilted or moved.
  type :: scene_surface
    character(len=:), allocatable :: file                     !! where it was read from; '': nowhere
    character(len=8) :: checksum = ''                         !! of a pipe's bytes; blank: of none
    logical :: is_plane = .false.                             !! a flat: it has no asperity
    real(real64), allocatable :: x(:), y(:)                   !! summits on the reference plane
    real(real64), allocatable :: height(:)                    !! summits above the reference plane
    real(real64), allocatable :: radius(:)                    !! summit radii, more than 0
    real(real64) :: elastic_modulus = 0.0_real64  !! more than 0
    real(real64) :: poisson_ratio = 0.0_real64  !! more than -1, at most 0.5
    real(real64) :: slope(2) = 0.0_real64  !! rise of the plate along x and y
    real(real64) :: rotation = 0.0_real64  !! turn in the plane, rad
  end type scene_surface

  !> Displacement of the upper surface: position m = 1, 2, ... stands at first + (m - 1) * step.
  type :: scene_motion
    real(real64) :: x_first = 0.0_real64, x_step = 0.0_real64  !! along x
    real(real64) :: y_first = 0.0_real64, y_step = 0.0_real64  !! along y
    integer :: positions = 1                 !! number of positions, at least 1
  end type scene_motion

  !> How far the surfaces close.
  type :: scene_loading
    type(loading_control) :: control = control_limit  !! the quantity of the values
    !> Value of the control at the end, or the deepest of the path; unused for the limit.
    real(real64) :: value = 0.0_real64
    !> Values of the control, one after the other, up and down; allocated when there are several.
    real(real64), allocatable :: path(:)
    integer :: points = 0               !! states after first touch; 0 or 1: the end state only
    logical :: events = .false.         !! also a state wherever a contact begins
    !> At the last state and its normal load, along x and y: tangential load, or displacement of the
    !> bodies by it, or the loads (x and y, point) of a path.
    real(real64) :: tangential_load(2) = 0.0_real64, tangential_displacement(2) = 0.0_real64
    real(real64), allocatable :: tangential_path(:, :)
  end type scene_loading

  !> When a contact is at its limit.
  type :: scene_limit
    integer :: criterion = criterion_load  !! one of the `criterion_` numbers
    logical :: from_thesis = .false.       !! `value` is the thesis' 65*9.8/2.205 N by default
    real(real64) :: value = 0.0_real64  !! load or average pressure, more than 0
    real(real64) :: hardness = 0.0_real64  !! for Greenwood and Williamson, more than 0
    real(real64) :: yield_stress = 0.0_real64  !! in shear, for Hardy, more than 0
  end type scene_limit

  !> Effects that are simulated beyond independent elastic contacts. The names are those of
  !> &effects, as
  !> `asperity_effect_names` lists them.
  type :: scene_effects
    integer :: modes(size(known_effects)) = effect_off  !! of each effect, an `effect_` number
    integer :: given(size(known_effects)) = by_default  !! by what: one of the `by_` numbers
    real(real64) :: numbers(size(effect_numbers)) = effect_numbers%default  !! of all
    !> (term, quantity): several relaxation times, ascending, and the relaxed modulus after each;
    !> `numbers` has the last ones. Not allocated: one.
    real(real64), allocatable :: relaxation(:, :)
  contains
    procedure :: mode => mode_of_effect      !! how an effect is called for
    procedure :: number => number_of_effect  !! a number, or the place of a word, as a double
    procedure :: call_for => call_for_effect !! sets how an effect is called for
    procedure :: set => set_number           !! sets a number
    procedure :: is_there                    !! whether a number is not 0, or one instead of it
    procedure :: has_numbers               !! whether the numbers that call for an effect are given
    procedure :: is_barred                   !! off because something else in the scene rules it out
  end type scene_effects

  !> Height maps in the place of surfaces: one beside a plane or asperities, or two.
  type :: scene_map
    type(height_map) :: upper, lower  !! as they were read; without columns: there is none
    logical :: periodic = .false.  !! they repeat themselves along an axis or both
    integer :: level = level_plane !! from which heights are measured
    logical :: despike = .false.   !! single outliers are taken out of them
    real(real64) :: form_radius(2) = 0.0_real64  !! of the form, along x and y; 0: straight
  end type scene_map

  !> One side of a scene that is given beside its text; where neither is allocated, the text names a
  !> file or a plane.
  type :: scene_side
    type(scene_surface), allocatable :: surface  !! asperities or a plane
    type(height_map), allocatable :: map         !! a height map
  end type scene_side

  !> A whole scene, resolved: defaults and the deck's own values are filled in.
  !>
  !> Placing, with A the approach (separation of the reference planes), i one asperity:
  !>
  !> 1. both surfaces: rotate (x, y) by `rotation` about the origin, X = x cos - y sin;
  !> 2. lower surface, when `lower_is_mirrored`: Y = `lower_mirror_width` - Y;
  !> 3. centre of an upper sphere: z = A + radius - height + slope(1) X + slope(2) Y;
  !>    of a lower sphere: z = height - radius + slope(1) X + slope(2) Y;
  !> 4. upper surface: add the displacement to X and Y; z keeps the value of step 3.
  type :: scene
    logical :: is_checked = .false.               !! read or built without problems
    character(len=:), allocatable :: file         !! the scene or deck, for messages
    character(len=:), allocatable :: text         !! all that it says, as it was written
    logical :: from_deck = .false.                !! surfaces from a deck: cm, N, N/cm2
    type(card_deck), allocatable :: deck          !! the deck itself; not allocated without one
    type(scene_surface) :: upper, lower           !! both surfaces
    !> Maps in the place of the surfaces; not allocated: none. Summits are found when it is solved.
    type(scene_map), allocatable :: map
    logical :: lower_is_mirrored = .false.        !! a deck's lower surface is
    real(real64) :: lower_mirror_width = 0.0_real64  !! the deck's WIDTHL, when mirrored
    !> Combined modulus itself, in place of those of both surfaces; 0: it follows from them.
    real(real64) :: contact_modulus = 0.0_real64
    type(layered_body) :: bodies(2)               !! upper and lower: their materials, and layers
    !> (body, kind): electrical and thermal conductivities of upper and lower body; 0: not given.
    real(real64) :: conductivity(2, 2) = 0.0_real64
    real(real64) :: nominal_area = 0.0_real64  !! of the surfaces in plan; 0: not given
    character(len=16) :: units(2) = ''            !! names of length and force; blank: not given
    type(scene_motion) :: motion                  !! where the upper surface stands
    type(scene_loading) :: loading                !! how far the surfaces close
    type(scene_limit) :: limit                    !! when a contact is at its limit
    type(scene_effects) :: effects                !! what else is simulated
    real(real64) :: stored(size(scene_rows)) = 0.0_real64  !! of rows of `scene_rows` with `stored`
    type(problem_list) :: notes                   !! oddities of a deck that are no errors
  contains
    procedure :: number => number_of_scene        !! value of a row with `stored`
  end type scene

contains

  !> How a scene calls for an effect.
  pure integer function mode_of_effect(effects, name) result(mode)
    class(scene_effects), intent(in) :: effects  !! of a scene
    character(len=*), intent(in) :: name         !! a known effect

    mode = effects%modes(findloc(known_effects%name, name, 1))
  end function mode_of_effect

  !> A number of an effect as the nearest double; a word by its place among those that are known.
  pure real(real64) function number_of_effect(effects, name) result(number)
    class(scene_effects), intent(in) :: effects  !! of a scene
    character(len=*), intent(in) :: name         !! a known number

    number = effects%numbers(findloc(effect_numbers%name, name, 1))
  end function number_of_effect

  !> A number of a scene that its row alone describes, as the nearest double.
  pure real(real64) function number_of_scene(self, group, name) result(number)
    class(scene), intent(in) :: self             !! scene with checked values
    character(len=*), intent(in) :: group, name  !! of a row of `scene_rows` with `stored`

    number = self%stored(findloc(scene_rows%group == group .and. &
                                                   scene_rows%name == name, .true., 1))
  end function number_of_scene

  !> Sets how a scene calls for an effect.
  pure subroutine call_for_effect(effects, name, mode)
    class(scene_effects), intent(inout) :: effects  !! of a scene
    character(len=*), intent(in) :: name            !! a known effect
    integer, intent(in) :: mode                     !! one of its `effect_` numbers

    effects%modes(findloc(known_effects%name, name, 1)) = mode
  end subroutine call_for_effect

  !> Sets a number of an effect.
  pure subroutine set_number(effects, name, value)
    class(scene_effects), intent(inout) :: effects  !! of a scene
    character(len=*), intent(in) :: name            !! a known number
    real(real64), intent(in) :: value        !! in its range

    effects%numbers(findloc(effect_numbers%name, name, 1)) = value
  end subroutine set_number

  !> Whether a number, or the one that does for it, is not 0.
  pure logical function is_there(effects, name)
    class(scene_effects), intent(in) :: effects  !! of a scene
    character(len=*), intent(in) :: name         !! a known number

    is_there = abs(effects%numbers(findloc(effect_numbers%name, name, 1))) > 0.0_real64 .or. &
      any(effect_numbers%name == effect_numbers(findloc(effect_numbers%name, name, 1))%instead &
          .and. abs(effects%numbers) > 0.0_real64)
  end function is_there

  !> Whether the numbers that call for an effect are given and not 0; false where it has none.
  pure logical function has_numbers(effects, effect)
    class(scene_effects), intent(in) :: effects  !! of a scene
    integer, intent(in) :: effect                !! number of a known effect
    integer :: i

    associate (own => known_effects(effect)%own)
      has_numbers = own(1) /= ''
      do i = 1, count(own /= '')
        has_numbers = has_numbers .and. effects%is_there(trim(own(i)))
      end do
    end associate
  end function has_numbers

  !> Whether an effect is off although the scene does not write that: what the scene asks for by
  !> word cannot be computed with it.
  pure logical function is_barred(effects, name)
    class(scene_effects), intent(in) :: effects  !! of a scene
    character(len=*), intent(in) :: name         !! a known effect
    integer :: given

    given = effects%given(findloc(known_effects%name, name, 1))
    is_barred = effects%mode(name) == effect_off .and. given < by_word .and. &
                (given == by_numbers .or. name == 'interaction')
  end function is_barred

  !> Whether the scene is a bare deck: the sweep that the original program computes.
  pure logical function is_thesis_sweep(scene_in)
    type(scene), intent(in) :: scene_in  !! scene with checked values

    is_thesis_sweep = scene_in%from_deck .and. scene_in%limit%from_thesis .and. &
                      scene_in%motion%positions == thesis_positions .and. &
                      is_limit(scene_in%loading%control) .and. &
                      same_name(scene_in%upper%file, scene_in%file)
  end function is_thesis_sweep

  !> (1 - nu**2)/E of a body; their sum for both is one over the combined modulus.
  elemental real(real64) function body_compliance(elastic_modulus, poisson_ratio)
    real(real64), intent(in) :: elastic_modulus  !! more than 0
    real(real64), intent(in) :: poisson_ratio    !! more than -1, at most 0.5
    real(real64) :: ratio

    ratio = poisson_ratio
    body_compliance = (1 - ratio) * (1 + ratio) / elastic_modulus
  end function body_compliance

  !> The combined modulus, 1/E = (1 - nu1**2)/E1 + (1 - nu2**2)/E2.
  pure real(real64) function combined_modulus(scene_in)
    type(scene), intent(in) :: scene_in  !! scene with checked values

    combined_modulus = scene_in%contact_modulus
    if (combined_modulus > 0.0_real64) return
    associate (upper => scene_in%upper, lower => scene_in%lower)
      combined_modulus = 1.0_real64 / (body_compliance(upper%elastic_modulus, &
                                       upper%poisson_ratio) + &
                                       body_compliance(lower%elastic_modulus, lower%poisson_ratio))
    end associate
  end function combined_modulus

  !> Second parameter of Dundurs (1969), beta = E/2 [(1 - 2 nu)(1 + nu)/E_body], upper less lower:
  !> the tangential displacement of unlike bodies under pressure; 0 where moduli are not known.
  pure real(real64) function dundurs_beta(scene_in)
    type(scene), intent(in) :: scene_in  !! scene with checked values
    real(real64) :: ratio(2), modulus(2)

    dundurs_beta = 0.0_real64
    ratio = [scene_in%upper%poisson_ratio, scene_in%lower%poisson_ratio]
    modulus = [scene_in%upper%elastic_modulus, scene_in%lower%elastic_modulus]
    if (.not. all(modulus > 0.0_real64) .or. scene_in%contact_modulus > 0.0_real64) return
    ratio = (1 - 2 * ratio) * (1 + ratio) / modulus
    dundurs_beta = 0.5_real64 * combined_modulus(scene_in) * (ratio(1) - ratio(2))
  end function dundurs_beta

  !> Relative change of the contact area by friction between unlike bodies: tractions are at most
  !> mu p, about beta p where nothing slips, and displace the surfaces by beta times as much
  !> as pressures do (measured on spheres, rough maps: 0.3 to 0.61 of the product at beta 0.29 and
  !> 0.5, mu 0.1 to 1).
  pure real(real64) function coupling_influence(scene_in)
    type(scene), intent(in) :: scene_in  !! scene with checked values

    associate (beta => abs(dundurs_beta(scene_in)))
      coupling_influence = 0.6_real64 * beta * &
                           min(beta, scene_in%effects%number('friction_coefficient'))
    end associate
  end function coupling_influence

  !> Whether friction on the pixels of a map changes the pressures.
  pure logical function is_coupled(scene_in)
    type(scene), intent(in) :: scene_in  !! scene with checked values

    is_coupled = .false.
    associate (effects => scene_in%effects)
      if (.not. allocated(scene_in%map) .or. effects%mode('friction') == effect_off .or. &
          any([effects%mode('plasticity'), effects%mode('adhesion'), effects%mode('creep')] /= &
              effect_off)) return
      select case (nint(effects%number('coupling')))
      case (effect_on)
        is_coupled = coupling_influence(scene_in) > 0.0_real64
      case (effect_auto)
        is_coupled = coupling_influence(scene_in) > effects%number('tolerance')
      case default
        is_coupled = .false.
      end select
    end associate
  end function is_coupled

  !> Whether the bodies are loaded or displaced tangentially after the normal load.
  pure logical function has_tangential(loading)
    type(scene_loading), intent(in) :: loading  !! loading of a scene

    has_tangential = allocated(loading%tangential_path) .or. &
      any(abs([loading%tangential_load, loading%tangential_displacement]) > 0.0_real64)
  end function has_tangential

  !> Whether the other body of a scene with a map is a table of asperities.
  pure logical function has_caps(scene_in)
    type(scene), intent(in) :: scene_in  !! checked values, with a map

    has_caps = .not. (scene_in%upper%is_plane .and. scene_in%lower%is_plane)
  end function has_caps

  !> Whether the pressures of a scene are limited by a hardness.
  pure logical function has_hardness(scene_in)
    type(scene), intent(in) :: scene_in  !! scene with checked values

    has_hardness = scene_in%effects%mode('plasticity') /= effect_off .and. &
                   scene_in%effects%number('plastic_hardness') > 0.0_real64
  end function has_hardness

end module asperity_scene_values
