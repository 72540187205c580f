!> The limits of the theories, in the units of the solver, and their check for a contact or a state.
!>
!> All solvers use them, with their results in doubles. Sources of the limits:
!> docs/reference/warnings.md.
module asperity_theory_limits
  use asperity_constants, only: pi
  use asperity_contact_records, only: contact_row
  use asperity_effect_names, only: effect_words, go_together, known_effects, of_interaction, &
                                   of_plasticity
  use asperity_first_yield, only: yield_pressure
  use asperity_kinds, only: real64
  use asperity_scene_values, only: criterion_greenwood_williamson, criterion_hardy, &
                                   criterion_load, criterion_pressure, effect_auto, &
                                   effect_boundary, effect_off, is_limit, scene, scene_limit
  use asperity_theory_warnings, only: add_warning, of_cap, of_contact_radius, of_crowding, &
                                      of_limit, of_overlapping, of_slope, of_yield, &
                                      theory_warning, warn_above
  implicit none
  private

  public :: theory_limits, seen_contact, is_patch_at_limit, set_theory_limits, look_at_contact, &
            look_at_state, look_at_pressure

  ! Tolerance for rounding of a contact at its limit.
  real(real64), parameter :: rounding = 1.0e-9_real64

  !> The limits of one scene.
  type :: theory_limits
    !> Average pressure at which the material yields; huge: unknown, or plasticity is not off.
    real(real64) :: yield_pressure = huge(1.0_real64)
    real(real64) :: load = huge(1.0_real64)       !! limit of a contact, plasticity off; huge: none
    real(real64) :: pressure = huge(1.0_real64)   !! limit of the average pressure, likewise
    real(real64) :: slope = 0.0_real64            !! of the steeper reference plane
    logical :: independent = .false.              !! interaction is off
    !> The effect or the name that excludes plasticity = 'auto'.
    character(len=32) :: forbids_plasticity = ''
    real(real64) :: area = 0.0_real64             !! nominal area; 0: unknown
  end type theory_limits

  !> One contact of a solution.
  type, extends(contact_row) :: seen_contact
    real(real64) :: cosine = 1.0_real64           !! of its inclination
    real(real64) :: upper_radius = 0.0_real64     !! of the sphere; 0: a plane
    real(real64) :: lower_radius = 0.0_real64     !! of the sphere; 0: a plane
    real(real64) :: upper_height = 0.0_real64     !! of the summit above its plane
    real(real64) :: lower_height = 0.0_real64     !! of the summit above its plane
    real(real64) :: contact_radius = 0.0_real64   !! of the contact circle
    real(real64) :: d = 0.0_real64                !! distance of the centres in plan
    real(real64) :: z = 0.0_real64                !! height between the centres
  end type seen_contact

contains

  !> Sets the limits of a scene in units of 2**length_power and 2**modulus_power of its own.
  pure subroutine set_theory_limits(scene_in, length_power, modulus_power, limits)
    type(scene), intent(in) :: scene_in          !! scene with checked values
    integer, intent(in) :: length_power          !! power of the unit of length
    integer, intent(in) :: modulus_power         !! power of the unit of the modulus
    type(theory_limits), intent(out) :: limits   !! limits in these units

    limits%independent = scene_in%effects%modes(of_interaction) == effect_off
    limits%area = scale(scale(scene_in%nominal_area, -length_power), -length_power)
    if (.not. (limits%area > 0.0_real64 .or. allocated(scene_in%map))) &
      limits%area = area_of_boxes(scene_in, length_power)
    limits%slope = max(norm2(scene_in%upper%slope), norm2(scene_in%lower%slope))
    limits%forbids_plasticity = ruling_out_plasticity(scene_in)
    if (scene_in%effects%modes(of_plasticity) /= effect_off) return
    if (.not. is_limit(scene_in%loading%control)) then
      if (scene_in%limit%criterion == criterion_load) &
        limits%load = scale(scale(scene_in%limit%value, -modulus_power), -2 * length_power)
      if (scene_in%limit%criterion == criterion_pressure) &
        limits%pressure = scale(scene_in%limit%value, -modulus_power)
    end if
    limits%yield_pressure = yield_pressure(scene_in)
    if (limits%yield_pressure < huge(1.0_real64)) &
      limits%yield_pressure = scale(limits%yield_pressure, -modulus_power)
  end subroutine set_theory_limits

  ! The effect or the name that excludes plasticity = 'auto'; empty: none.
  pure function ruling_out_plasticity(scene_in) result(name)
    type(scene), intent(in) :: scene_in
    character(len=32) :: name
    integer :: i

    name = ''
    associate (modes => scene_in%effects%modes)
      do i = 1, size(modes)
        if (any(modes(i) == [effect_off, effect_auto])) cycle
        if (.not. go_together(known_effects(of_plasticity)%name, 'on', known_effects(i)%name, &
                              effect_words(modes(i))) .or. &
            (allocated(scene_in%map) .and. modes(i) == effect_boundary)) &
          name = 'not with ' // known_effects(i)%name
      end do
    end associate
    if (scene_in%contact_modulus > 0.0_real64) name = 'not with contact_modulus'
  end function ruling_out_plasticity

  !> Adds a contact outside of the theories to the warnings of a state.
  pure subroutine look_at_contact(limits, contact, warnings)
    type(theory_limits), intent(in) :: limits            !! limits of the scene
    type(seen_contact), intent(in) :: contact            !! contact of the state
    type(theory_warning), allocatable, intent(inout) :: warnings(:)  !! warnings of a state
    real(real64) :: beyond, smaller

    smaller = min(contact%upper_radius, contact%lower_radius)
    if (.not. smaller > 0.0_real64) smaller = max(contact%upper_radius, contact%lower_radius)
    call warn_above(warnings, of_contact_radius, contact%contact_radius / smaller, 1)
    beyond = max(beyond_cap(contact, contact%upper_radius, contact%upper_height), &
                 beyond_cap(contact, contact%lower_radius, contact%lower_height), &
                 contact%overlap - max(contact%upper_height + contact%lower_height, 0.0_real64))
    if (beyond > 0.0_real64) call warn_above(warnings, of_cap, beyond / smaller, 1)
    call warn_above(warnings, of_slope, max(contact%d / contact%z, limits%slope), 1)
    associate (pressure => contact%average_pressure)
      call look_at_pressure(limits, pressure, pressure, pressure * pi * contact%contact_radius**2, &
                            warnings)
    end associate
  end subroutine look_at_contact

  !> Adds a contact beyond yield or beyond the limit of the scene to the warnings of a state.
  pure subroutine look_at_pressure(limits, average, greatest, load, warnings)
    type(theory_limits), intent(in) :: limits  !! limits of the scene
    real(real64), intent(in) :: average        !! average pressure of the contact
    real(real64), intent(in) :: greatest       !! average pressure of the Hertzian contact with
                                               !! its greatest pressure
    real(real64), intent(in) :: load           !! load of the contact
    type(theory_warning), allocatable, intent(inout) :: warnings(:)  !! warnings of a state

    call warn_above(warnings, of_yield, max(average, greatest) / limits%yield_pressure, 1, &
                    limits%forbids_plasticity)
    call warn_above(warnings, of_limit, max(average / limits%pressure, load / limits%load), 1, &
                    limits%forbids_plasticity)
  end subroutine look_at_pressure

  !> Whether a contact patch is at its limit: its load or average pressure is that of the limit, or
  !> its greatest pressure is that of a Hertzian contact at the limit, p0 = 2 E sqrt(W/R)/pi. For
  !> Greenwood and Williamson sqrt(W/R) is H/E, for Hardy p0 is 2.76 times the yield stress.
  pure logical function is_patch_at_limit(limit, load, average, greatest) result(at_limit)
    type(scene_limit), intent(in) :: limit    !! limit of the scene, in the units of the others
    real(real64), intent(in) :: load          !! load of the patch
    real(real64), intent(in) :: average       !! its average pressure
    real(real64), intent(in) :: greatest      !! its greatest pressure
    real(real64) :: share

    select case (limit%criterion)
    case (criterion_load)
      share = load / limit%value
    case (criterion_pressure)
      share = average / limit%value
    case (criterion_greenwood_williamson)
      share = greatest / (2 / pi * limit%hardness)
    case (criterion_hardy)
      share = greatest / (2.76_real64 * limit%yield_stress)
    case default
      share = 0.0_real64
    end select
    at_limit = share >= 1.0_real64 - rounding
  end function is_patch_at_limit

  !> Adds crowded or overlapping contacts of a state to its warnings.
  pure subroutine look_at_state(limits, projected_area, overlapping, warnings)
    type(theory_limits), intent(in) :: limits            !! limits of the scene
    real(real64), intent(in) :: projected_area           !! sum over all contacts
    integer, intent(in) :: overlapping                   !! pairs of overlapping circles, or 0
    type(theory_warning), allocatable, intent(inout) :: warnings(:)  !! warnings of a state

    if (.not. limits%independent) return
    if (overlapping > 0) call add_warning(warnings, of_overlapping, real(overlapping, real64))
    if (limits%area > 0.0_real64) &
      call warn_above(warnings, of_crowding, projected_area / limits%area)
  end subroutine look_at_state

  ! Distance of the lowest point of the edge of a contact circle below the base plane of a cap; not
  ! positive: the edge is on the cap. The polar angle of this point is the sum of the inclination
  ! and of the half angle of the circle.
  pure real(real64) function beyond_cap(contact, radius, height) result(beyond)
    type(seen_contact), intent(in) :: contact
    real(real64), intent(in) :: radius, height
    real(real64) :: centres, sine, cosine

    beyond = 0.0_real64
    if (.not. radius > 0.0_real64) return
    centres = hypot(contact%d, contact%z)
    sine = min(contact%contact_radius / radius, 1.0_real64)
    cosine = sqrt((1.0_real64 - sine) * (1.0_real64 + sine))
    beyond = radius * (1.0_real64 - (contact%z / centres) * cosine + &
                       (contact%d / centres) * sine) - height
  end function beyond_cap

  ! Area in plan of the summits of the smaller surface: their bounding box, extended by half of
  ! their mean distance on each side. 0: the box has no area.
  pure real(real64) function area_of_boxes(scene_in, length_power) result(area)
    type(scene), intent(in) :: scene_in
    integer, intent(in) :: length_power
    real(real64) :: boxes(2)

    boxes = [extended_box(scene_in%upper%x, scene_in%upper%y), &
             extended_box(scene_in%lower%x, scene_in%lower%y)]
    area = minval(boxes)
    if (.not. area > 0.0_real64) area = maxval(boxes)

  contains

    pure real(real64) function extended_box(x, y) result(box)
      real(real64), intent(in) :: x(:), y(:)
      real(real64) :: sides(2), distance

      box = 0.0_real64
      if (size(x) < 2) return
      sides = [maxval(scale(x, -length_power)) - minval(scale(x, -length_power)), &
               maxval(scale(y, -length_power)) - minval(scale(y, -length_power))]
      distance = sqrt(sides(1)) * sqrt(sides(2)) / sqrt(real(size(x), real64))
      if (distance > 0.0_real64) box = product(min(sides, 1.0e100_real64) + distance)
    end function extended_box

  end function area_of_boxes

end module asperity_theory_limits
