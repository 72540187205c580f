!> The effects that a scene names, in the order in which they act.
!>
!> A new effect needs a line here, its file, its names in `asperity_effect_names`, a hard case and a
!> page.
module asperity_effect_list
  use asperity_adhesion, only: new_adhesion
  use asperity_contact_effect, only: effect_box
  use asperity_creep, only: new_creep
  use asperity_effect_names, only: known_effects
  use asperity_friction_effect, only: new_friction
  use asperity_interaction, only: new_interaction
  use asperity_plasticity, only: new_plasticity
  use asperity_scene_values, only: effect_off, scene
  implicit none
  private

  public :: list_effects

contains

  !> The effects that are not off.
  subroutine list_effects(scene_in, list)
    type(scene), intent(in) :: scene_in                  !! checked values
    type(effect_box), allocatable, intent(out) :: list(:)  !! in the order in which they act
    type(effect_box) :: known(size(known_effects))
    integer :: i, used

    ! Laws of a contact first, then what contacts do to each other, then what follows from loads.
    call new_plasticity(scene_in, known(1)%effect)
    call new_adhesion(scene_in, known(2)%effect)
    call new_interaction(scene_in, known(3)%effect)
    call new_creep(scene_in, known(4)%effect)
    call new_friction(scene_in, known(5)%effect)

    allocate (list(count(scene_in%effects%modes /= effect_off)))
    used = 0
    do i = 1, size(known)
      if (known(i)%effect%mode == effect_off) cycle
      used = used + 1
      call move_alloc(known(i)%effect, list(used)%effect)
    end do
  end subroutine list_effects

end module asperity_effect_list
