!> Conversion of a scene to the units of the solver.
module asperity_scene_placing
  use asperity_constants, only: pi
  use asperity_contact_records, only: all_finite
  use asperity_kinds, only: int64, real64
  use asperity_loading_controls, only: in_model_units
  use asperity_pair_finding, only: prepare_search
  use asperity_placed_scene, only: largest_value, load_unit, placed_scene
  use asperity_problems, only: decimal_text
  use asperity_process, only: check_memory
  use asperity_scene_values, only: criterion_greenwood_williamson, criterion_hardy, &
                                   criterion_load, criterion_none, criterion_pressure, is_load, &
                                   scene, scene_limit, scene_surface
  use asperity_theory_limits, only: set_theory_limits
  implicit none
  private

  public :: place_scene

  character(len=*), parameter :: out_of_range = &
    'a number of the scene is out of the range of this arithmetic'

contains

  !> Converts a scene to the units of the solver. `failure` is allocated when a number is out of
  !> range.
  subroutine place_scene(scene_in, placed, failure)
    type(scene), intent(in) :: scene_in                    !! scene with checked values
    type(placed_scene), intent(out) :: placed              !! scene in the units of the solver
    character(len=:), allocatable, intent(out) :: failure  !! set where it cannot be converted
    ! Bytes of the numbers of each asperity, with temporary copies, and of those in the search,
    ! whose higher levels repeat an eighth of them.
    integer(int64), parameter :: bytes_each = 128
    real(real64) :: moduli(2), nu(2)
    integer :: asperities

    asperities = size(scene_in%upper%x) + size(scene_in%lower%x)
    call check_memory(decimal_text(asperities) // ' asperities', failure, &
                      bytes=bytes_each * asperities)
    if (allocated(failure)) return
    call place_surfaces(scene_in, placed)
    ! The combined modulus: that of the scene, or from the moduli of both surfaces.
    placed%modulus = scene_in%contact_modulus
    if (.not. placed%modulus > 0.0_real64) then
      moduli = [scene_in%upper%elastic_modulus, scene_in%lower%elastic_modulus]
      nu = [scene_in%upper%poisson_ratio, scene_in%lower%poisson_ratio]
      ! Smaller moduli have a compliance that overflows.
      if (.not. all(moduli > 4 * tiny(nu))) failure = out_of_range
      if (allocated(failure)) return
      placed%modulus = 1.0_real64 / sum((1.0_real64 - nu) * (1.0_real64 + nu) / moduli)
    end if
    placed%modulus_power = exponent(placed%modulus)
    placed%modulus = scale(placed%modulus, -placed%modulus_power)
    call place_loading(scene_in, placed)
    call place_limit(scene_in%limit, placed)
    call check_range(placed, abs(scene_in%loading%value) > 0.0_real64, failure)
    if (allocated(failure)) return
    call set_theory_limits(scene_in, placed%length_power, placed%modulus_power, placed%limits)
    placed%cap_u = scale(scene_in%upper%height, -placed%length_power)
    placed%cap_l = scale(scene_in%lower%height, -placed%length_power)
    call prepare_search(placed)
  end subroutine place_scene

  ! Places, summit levels and radii of both surfaces in the unit of length, which this sets.
  subroutine place_surfaces(scene_in, placed)
    type(scene), intent(in) :: scene_in
    type(placed_scene), intent(inout) :: placed
    real(real64) :: largest

    largest = max(largest_value(scene_in%upper%radius), largest_value(scene_in%lower%radius))
    placed%length_power = exponent(largest)
    placed%ru = scale(scene_in%upper%radius, -placed%length_power)
    placed%rl = scale(scene_in%lower%radius, -placed%length_power)
    placed%out_of_reach = scale(largest, 20 - placed%length_power)

    call place_surface(scene_in%upper, -placed%length_power, placed%xu, placed%yu, placed%hu)
    call level_surface(scene_in%upper, .true., placed%xu, placed%yu, placed%hu)
    call place_surface(scene_in%lower, -placed%length_power, placed%xl, placed%yl, placed%hl)
    placed%height_max = scale(max(largest_value(scene_in%upper%height), &
                                  largest_value(scene_in%lower%height)), -placed%length_power)
    if (scene_in%lower_is_mirrored) &
      placed%yl = length_of(scene_in%lower_mirror_width, placed) - placed%yl
    call level_surface(scene_in%lower, .false., placed%xl, placed%yl, placed%hl)
    placed%plane_slope = 0.0_real64
    if (scene_in%upper%is_plane) then
      call level_surface(scene_in%upper, .true., placed%xl, placed%yl, placed%hl)
      placed%plane_slope = scene_in%upper%slope
    else if (scene_in%lower%is_plane) then
      call level_surface(scene_in%lower, .false., placed%xu, placed%yu, placed%hu)
      placed%plane_slope = scene_in%lower%slope
    end if
    placed%is_deck = scene_in%from_deck
    placed%on_plane = scene_in%upper%is_plane .or. scene_in%lower%is_plane
    placed%complete_above = largest_value(placed%hu) + largest_value(placed%hl) - placed%height_max
  end subroutine place_surfaces

  ! Displacements and the quantity that ends a position.
  subroutine place_loading(scene_in, placed)
    type(scene), intent(in) :: scene_in
    type(placed_scene), intent(inout) :: placed

    placed%x_first = length_of(scene_in%motion%x_first, placed)
    placed%x_step = length_of(scene_in%motion%x_step, placed)
    placed%y_first = length_of(scene_in%motion%y_first, placed)
    placed%y_step = length_of(scene_in%motion%y_step, placed)

    placed%points = scene_in%loading%points
    placed%events = scene_in%loading%events
    placed%control = scene_in%loading%control
    placed%target = in_model_units(placed%control, scene_in%loading%value, scene_in%nominal_area, &
                                   placed%modulus_power, placed%length_power)
  end subroutine place_loading

  ! Places and heights of one surface, rotated in plan.
  subroutine place_surface(surface, power, x, y, h)
    type(scene_surface), intent(in) :: surface
    integer, intent(in) :: power
    real(real64), allocatable, intent(out) :: x(:), y(:), h(:)
    real(real64) :: angle, turned
    integer :: i

    x = scale(surface%x, power)
    y = scale(surface%y, power)
    h = scale(surface%height, power)
    if (.not. abs(surface%rotation) > 0.0_real64) return
    angle = surface%rotation
    do i = 1, size(x)
      turned = x(i) * cos(angle) - y(i) * sin(angle)
      y(i) = x(i) * sin(angle) + y(i) * cos(angle)
      x(i) = turned
    end do
  end subroutine place_surface

  ! Turns heights into summit levels: where the tilt raises the plate, it lowers an upper summit and
  ! raises a lower one.
  subroutine level_surface(surface, upper, x, y, h)
    type(scene_surface), intent(in) :: surface
    logical, intent(in) :: upper
    real(real64), intent(in) :: x(:), y(:)
    real(real64), intent(inout) :: h(:)
    real(real64) :: slope(2)

    slope = surface%slope
    if (upper) slope = -slope
    h = h + (x * slope(1) + y * slope(2))
  end subroutine level_surface

  ! A length of the scene in the unit of length.
  real(real64) function length_of(value, placed) result(length)
    real(real64), intent(in) :: value
    type(placed_scene), intent(in) :: placed

    length = scale(value, -placed%length_power)
  end function length_of

  ! A force of the scene in the unit of modulus times length squared.
  real(real64) function load_of(value, placed) result(load)
    real(real64), intent(in) :: value
    type(placed_scene), intent(in) :: placed

    load = scale(value, -load_unit(placed))
  end function load_of

  ! The limit, as a load or as a ratio of overlap to combined radius.
  subroutine place_limit(limit, placed)
    type(scene_limit), intent(in) :: limit
    type(placed_scene), intent(inout) :: placed
    real(real64) :: strain

    placed%criterion = limit%criterion
    placed%limit = 0.0_real64
    select case (limit%criterion)
    case (criterion_load)
      if (limit%from_thesis) then
        ! 65*9.8/2.205 N, exactly 2600/9.
        placed%limit = load_of(2600.0_real64 / 9.0_real64, placed)
      else
        placed%limit = load_of(limit%value, placed)
      end if
      return
    case (criterion_pressure)
      ! The average pressure is 4 E sqrt(W/R)/(3 pi).
      strain = 3.0_real64 * pi * modulus_ratio(limit%value, placed) / 4.0_real64
    case (criterion_greenwood_williamson)
      ! Greenwood and Williamson 1966: W = R (H/E)**2.
      strain = modulus_ratio(limit%hardness, placed)
    case (criterion_hardy)
      ! Hardy and others 1971: maximum pressure 2.76 tau; maximum pressure 2 E sqrt(W/R)/pi.
      strain = 276.0e-2_real64 * modulus_ratio(limit%yield_stress, placed) * pi / 2.0_real64
    case default
      return
    end select
    ! A limit beyond reach is reduced to one beyond reach whose square does not overflow.
    if (exponent(strain) > 56) strain = scale(1.0_real64, 56)
    placed%limit = strain * strain
  end subroutine place_limit

  ! A stress over the combined modulus.
  real(real64) function modulus_ratio(value, placed) result(ratio)
    real(real64), intent(in) :: value
    type(placed_scene), intent(in) :: placed

    ratio = scale(value, -placed%modulus_power) / placed%modulus
  end function modulus_ratio

  ! Sets `failure` where numbers of the scene are not finite or vanish in these units.
  subroutine check_range(placed, has_load, failure)
    type(placed_scene), intent(in) :: placed
    logical, intent(in) :: has_load    ! the value of the loading is not 0
    character(len=:), allocatable, intent(out) :: failure
    logical :: vanished

    if (.not. (all_finite([placed%modulus, placed%target, placed%limit, placed%x_first, &
                           placed%x_step, placed%y_first, placed%y_step]) .and. &
               all_finite(placed%xu) .and. all_finite(placed%yu) .and. all_finite(placed%hu) .and. &
               all_finite(placed%ru) .and. all_finite(placed%xl) .and. all_finite(placed%yl) .and. &
               all_finite(placed%hl) .and. all_finite(placed%rl))) &
      failure = out_of_range
    ! A load or limit that is subnormal in these units has lost digits, or is reached at first
    ! touch.
    vanished = is_load(placed%control) .and. has_load .and. &
               .not. abs(placed%target) >= tiny(placed%target)
    if (vanished .or. &
        (placed%criterion /= criterion_none .and. .not. placed%limit >= tiny(placed%limit))) &
      failure = 'the load or the limit of the scene is too small for this arithmetic'
  end subroutine check_range

end module asperity_scene_placing
