!> Steps of the path of a position, for any model: values up and down, and a hold.
module asperity_path_steps
  use asperity_contact_model, only: at_distance, at_load, held_distance, held_load, path_step
  use asperity_kinds, only: real64
  use asperity_scene_values, only: hold_load, scene
  use asperity_viscoelastic_solid, only: hold_times
  implicit none
  private

  public :: plan_hold, plan_path

contains

  !> Plans the states between values of a path: equal parts lie between two of them. The path begins
  !> with its first contact where there are several parts.
  pure subroutine plan_path(from, ends, parts, by_load, steps)
    real(real64), intent(in) :: from       !! value of first contact
    real(real64), intent(in) :: ends(:)    !! values of the path, in units of the model
    integer, intent(in) :: parts           !! parts between two values, 1 or more
    logical, intent(in) :: by_load         !! whether values are loads
    type(path_step), allocatable, intent(out) :: steps(:)
    real(real64) :: before
    integer :: i, j, used

    allocate (steps(merge(1, 0, parts > 1) + parts * size(ends)))
    steps%control = merge(at_load, at_distance, by_load)
    used = size(steps) - parts * size(ends)
    if (used > 0) steps(1)%value = from
    before = from
    do i = 1, size(ends)
      do j = 1, parts
        used = used + 1
        steps(used)%value = before + (ends(i) - before) * (real(j, real64) / real(parts, real64))
      end do
      steps(used)%value = ends(i)
      before = ends(i)
    end do
    if (by_load) steps%load = steps%value
  end subroutine plan_path

  !> Plans the states of a hold after the last state of loading.
  subroutine plan_hold(scene_in, steps)
    type(scene), intent(in) :: scene_in                     !! scene, checked for faults
    type(path_step), allocatable, intent(out) :: steps(:)   !! states; without a hold none
    real(real64), allocatable :: times(:)

    associate (effects => scene_in%effects)
      call hold_times(effects%number('hold_time'), effects%number('relaxation_time'), &
                      nint(effects%number('hold_points')), times)
      allocate (steps(size(times) - 1))
      steps%time = times(2:)
      steps%control = merge(held_load, held_distance, nint(effects%number('hold')) == hold_load)
    end associate
  end subroutine plan_hold

end module asperity_path_steps
