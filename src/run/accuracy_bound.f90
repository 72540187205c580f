!> How accurate a way of computing is on a scene.
!>
!> The ways are the front of the accuracy study, cheapest first: exact events with the stable
!> overlap, in real64 and in real128. Shorter arithmetics and marching are not on it: they are no
!> cheaper, or not clearly. Each way's error is bounded from what was solved, not from a table, so
!> that the promise holds on scenes the study has never seen.
module asperity_accuracy_bound
  use asperity_contact_records, only: position_result, state_row
  use asperity_kinds, only: real64
  use asperity_scene_results, only: last_state
  use asperity_scene_values, only: scene
  use asperity_decimal, only: decimal_to_real64
  implicit none
  private

  public :: front_arithmetics, error_bound

  !> The front of the accuracy study, cheapest first.
  character(len=7), parameter :: front_arithmetics(2) = [character(len=7) :: 'real64', 'real128']

  ! Results are handed over as doubles: nothing finer can be promised.
  real(real64), parameter :: finest_accuracy = 4 * epsilon(1.0_real64)

  ! Rounding errors of a position's coordinates and separations, in units of roundoff: placing (3),
  ! the difference in plan, its square and root, the separation and the gap, each at most 1.
  real(real64), parameter :: roundings = 12.0_real64

contains

  !> Bound of the relative error of every total: load, vertical load, area, approach.
  !>
  !> Coordinates are rounded, so penetrations are uncertain by some roundoffs of the coordinates'
  !> size. The total load of independent contacts changes by at most 3/2 of that over the closing,
  !> because load grows at least as the power 3/2 of the closing.
  function error_bound(arithmetic, scene_in, positions) result(bound)
    character(len=*), intent(in) :: arithmetic      !! a name of `front_arithmetics`
    type(scene), intent(in) :: scene_in             !! what was solved
    type(position_result), intent(in) :: positions(:)  !! solved
    real(real64) :: bound
    real(real64) :: roundoff, in_plan, in_height, radius, uncertainty, steepest
    type(state_row) :: last
    integer :: m

    roundoff = 0.5_real64 * epsilon(1.0_real64)
    if (arithmetic == 'real128') roundoff = roundoff * 2.0_real64**(53 - 113)
    radius = min(minval(scene_in%upper%radius), minval(scene_in%lower%radius))
    in_height = max(maxval(abs(scene_in%upper%height)), maxval(abs(scene_in%lower%height)))
    associate (upper => scene_in%upper, lower => scene_in%lower, motion => scene_in%motion)
      in_plan = max(maxval(abs(upper%x)), maxval(abs(upper%y)), maxval(abs(lower%x)), &
                    maxval(abs(lower%y)), abs(decimal_to_real64(scene_in%lower_mirror_width)), &
                    maxval(abs(decimal_to_real64([motion%x_first, motion%y_first]))) + &
                    (motion%positions - 1) * &
                    maxval(abs(decimal_to_real64([motion%x_step, motion%y_step]))))
    end associate
    bound = finest_accuracy
    do m = 1, size(positions)
      last = last_state(positions(m))
      if (.not. last%closing > 0.0_real64) cycle
      ! An error in plan tilts into height by the slope of the contact, d/z of at most
      ! sqrt(2 (RU + RL) H) over the radius' size.
      steepest = min(1.0_real64, sqrt(4 * max(in_height, last%closing) / radius))
      uncertainty = roundings * roundoff * (in_height + steepest * in_plan)
      bound = max(bound, 1.5_real64 * uncertainty / last%closing + finest_accuracy)
      if (abs(last%approach) > 0.0_real64) &
        bound = max(bound, uncertainty / abs(last%approach) + finest_accuracy)
    end do
  end function error_bound

end module asperity_accuracy_bound
