!> Steps of the path of a position, for any model: values up and down, and a hold.
module asperity_path_steps
  use asperity_contact_model, only: at_distance, at_load, held_distance, held_load, path_step
  use asperity_kinds, only: real64
  use asperity_scene_values, only: hold_load, scene
  use asperity_viscoelastic_solid, only: hold_times, relaxing_solid, solid_of_scene
  implicit none
  private

  public :: plan_hold, plan_path

contains

  !> Plans the states between values of a path: equal parts lie between two of them. The path begins
  !> with its first contact where there are several parts. In time it has a constant rate.
  pure subroutine plan_path(from, ends, points, by_load, duration, steps)
    real(real64), intent(in) :: from       !! value of first contact
    real(real64), intent(in) :: ends(:)    !! values of the path, in units of the model
    integer, intent(in) :: points          !! parts between two values; 0: one, several in time
    logical, intent(in) :: by_load         !! whether values are loads
    real(real64), intent(in) :: duration   !! time of the path; 0: it is instantaneous
    type(path_step), allocatable, intent(out) :: steps(:)
    ! Parts of loading in time (chosen: those of a hold; test: Ting in test_creep_pixels.py).
    integer, parameter :: parts_in_time = 20
    real(real64) :: before, length
    integer :: i, j, parts, used

    parts = max(1, points)
    if (duration > 0.0_real64 .and. points == 0) parts = parts_in_time
    allocate (steps(merge(1, 0, parts > 1) + parts * size(ends)))
    steps%control = merge(at_load, at_distance, by_load)
    used = size(steps) - parts * size(ends)
    if (used > 0) steps(1)%value = from
    before = from
    length = 0.0_real64
    do i = 1, size(ends)
      do j = 1, parts
        used = used + 1
        steps(used)%value = before + (ends(i) - before) * (real(j, real64) / real(parts, real64))
        steps(used)%time = length + abs(ends(i) - before) * (real(j, real64) / real(parts, real64))
      end do
      steps(used)%value = ends(i)
      length = length + abs(ends(i) - before)
      before = ends(i)
    end do
    if (length > 0.0_real64) steps%time = duration * (steps%time / length)
    if (by_load) steps%load = steps%value
  end subroutine plan_path

  !> Plans the states of a hold after the last state of loading.
  subroutine plan_hold(scene_in, steps)
    type(scene), intent(in) :: scene_in                     !! scene, checked for faults
    type(path_step), allocatable, intent(out) :: steps(:)   !! states; without a hold none
    type(relaxing_solid) :: solid

    solid = solid_of_scene(scene_in)
    associate (effects => scene_in%effects)
      associate (times => hold_times(effects%number('hold_time'), solid%time(1), &
                                     nint(effects%number('hold_points'))))
        allocate (steps(size(times) - 1))
        steps%time = solid%loading_time + times(2:)
      end associate
      steps%control = merge(held_load, held_distance, nint(effects%number('hold')) == hold_load)
    end associate
  end subroutine plan_hold

end module asperity_path_steps
