!> Error bound of real64 for a scene without effects, computed from its results.
module asperity_accuracy_bound
  use asperity_constants, only: pi
  use asperity_contact_records, only: position_result, state_row
  use asperity_decimal, only: decimal_to_real64
  use asperity_kinds, only: real64
  use asperity_scene_results, only: last_state
  use asperity_scene_values, only: combined_modulus, is_load, scene
  use asperity_theory_warnings, only: of_slope, warning_kinds
  implicit none
  private

  public :: error_bound

  ! Smallest error bound: results are stored as doubles.
  real(real64), parameter :: finest_accuracy = 4 * epsilon(1.0_real64)

  ! Rounding errors of a position's coordinates and separations, in units of roundoff: placing (3),
  ! the difference in plan, its square and root, the separation and the gap, each at most 1.
  real(real64), parameter :: roundings = 12.0_real64

contains

  !> Bound of the relative error of every total of the last state: load, vertical load, area,
  !> separation.
  !>
  !> Rounded heights e_z and plan coordinates e_d move an overlap by e_z + e_d sin(theta) and the
  !> separation of first touch by e_z + e_d tan(theta), tan(theta) the slope of the contact. The
  !> stiffness of N contacts of Hertz of total area A is 2 E sum(a) <= 2 E sqrt(N A/pi), and an area
  !> grows by pi R per overlap. The slope of every contact is below the limit of its warning, or
  !> that of the warning.
  real(real64) function error_bound(scene_in, positions) result(bound)
    type(scene), intent(in) :: scene_in                !! scene that was solved
    type(position_result), intent(in) :: positions(:)  !! results of all positions
    real(real64) :: roundoff, in_plan, in_height, tilt, least, widest, distance, slope, of_overlap
    real(real64) :: of_touch, per_overlap, modulus
    type(state_row) :: last
    integer :: m

    bound = finest_accuracy
    ! A map has no asperities to be rounded.
    if (allocated(scene_in%map)) return
    roundoff = 0.5_real64 * epsilon(1.0_real64)
    modulus = combined_modulus(scene_in)
    associate (upper => scene_in%upper, lower => scene_in%lower, motion => scene_in%motion)
      least = min(minval(upper%radius), minval(lower%radius))
      ! The effective radius of a pair is at most the smaller radius.
      widest = min(maxval(upper%radius), maxval(lower%radius))
      tilt = max(norm2(decimal_to_real64(upper%slope)), norm2(decimal_to_real64(lower%slope)))
      in_plan = max(maxval(abs(upper%x)), maxval(abs(upper%y)), maxval(abs(lower%x)), &
                    maxval(abs(lower%y)), abs(decimal_to_real64(scene_in%lower_mirror_width)), &
                    maxval(abs(decimal_to_real64([motion%x_first, motion%y_first]))) + &
                    (motion%positions - 1) * &
                    maxval(abs(decimal_to_real64([motion%x_step, motion%y_step]))))
      in_height = max(maxval(abs(upper%height)), maxval(abs(lower%height))) + 2 * tilt * in_plan
    end associate
    ! The distance of the summits of a pair in plan is less than the sum of their radii, and less
    ! than twice the largest coordinate along x and along y.
    distance = min(maxval(scene_in%upper%radius) + maxval(scene_in%lower%radius), 3 * in_plan)
    do m = 1, size(positions)
      last = last_state(positions(m))
      if (.not. (last%compression > 0.0_real64 .and. last%load > 0.0_real64)) cycle
      ! The offset in plan of a contact reduces its height by less than the summits exceed.
      slope = min(warning_kinds(of_slope)%limit, &
                  sqrt(4 * max(2 * in_height - last%approach, last%compression) / least))
      if (allocated(positions(m)%warnings)) &
        slope = max(slope, maxval(positions(m)%warnings%magnitude, &
                                  positions(m)%warnings%number == of_slope))
      of_overlap = roundings * roundoff * (in_height + min(slope, 1.0_real64) * &
                                           (in_plan + distance))
      of_touch = roundings * roundoff * (in_height + slope * (in_plan + distance))
      per_overlap = max(2 * modulus * sqrt(last%contacts / pi) * sqrt(last%area) / last%load, &
                        pi * last%contacts * widest / last%area)
      ! Under a load the error of the overlaps is added to the separation.
      if (is_load(scene_in%loading%control)) per_overlap = 2 * per_overlap
      bound = max(bound, finest_accuracy + of_overlap * per_overlap + of_touch * &
                         max(1.0_real64 / last%compression, 2 * hypot(1.0_real64, slope) / least))
      if (abs(last%approach) > 0.0_real64) &
        bound = max(bound, of_touch / abs(last%approach) + finest_accuracy)
    end do
  end function error_bound

end module asperity_accuracy_bound
