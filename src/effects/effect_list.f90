!> The effects that a scene names, in the order in which they act.
!>
!> A new effect needs a line here, its file, a name in the scene, a hard case and a page.
module asperity_effect_list
  use asperity_contact_effect, only: effect_box
  use asperity_decimal, only: decimal_to_real64
  use asperity_friction_effect, only: new_friction
  use asperity_interaction, only: new_interaction
  use asperity_scene_values, only: effect_off, scene
  implicit none
  private

  public :: list_effects

contains

  !> The effects that are not off.
  subroutine list_effects(scene_in, list)
    type(scene), intent(in) :: scene_in                  !! checked values
    type(effect_box), allocatable, intent(out) :: list(:)  !! in the order in which they act
    type(effect_box) :: known(2)
    integer :: i, used

    call new_interaction(scene_in, known(1)%effect)
    call new_friction(scene_in, known(2)%effect)

    used = 0
    do i = 1, size(known)
      if (known(i)%effect%mode /= effect_off) used = used + 1
    end do
    allocate (list(used))
    used = 0
    do i = 1, size(known)
      if (known(i)%effect%mode == effect_off) cycle
      used = used + 1
      call move_alloc(known(i)%effect, list(used)%effect)
      list(used)%effect%tolerance = decimal_to_real64(scene_in%effects%tolerance)
    end do
  end subroutine list_effects

end module asperity_effect_list
