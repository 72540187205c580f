!> The effects of a scene, in the order in which they act. CONTRIBUTING.md lists the parts of a new
!> effect.
module asperity_effect_list
  use asperity_adhesion, only: new_adhesion
  use asperity_contact_effect, only: effect_box
  use asperity_creep, only: new_creep
  use asperity_effect_names, only: known_effects
  use asperity_friction_effect, only: new_friction
  use asperity_interaction, only: new_interaction
  use asperity_kinds, only: real64
  use asperity_plasticity, only: new_plasticity
  use asperity_scene_values, only: effect_off, scene
  implicit none
  private

  public :: list_effects, list_left_out

contains

  !> The effects that are not off.
  subroutine list_effects(scene_in, list)
    type(scene), intent(in) :: scene_in                    !! scene with checked values
    type(effect_box), allocatable, intent(out) :: list(:)  !! in the order in which they act

    call list_some(scene_in, scene_in%effects%modes /= effect_off, list)
  end subroutine list_effects

  !> The effects that are off and whose influence can be estimated: interaction, and those with all
  !> parameters in the scene.
  subroutine list_left_out(scene_in, list)
    type(scene), intent(in) :: scene_in                    !! scene with checked values
    type(effect_box), allocatable, intent(out) :: list(:)  !! in the order in which they act
    logical :: some(size(known_effects))
    integer :: i

    associate (effects => scene_in%effects)
      some = effects%modes == effect_off .and. &
             (.not. abs(scene_in%contact_modulus) > 0.0_real64 .or. &
              known_effects%needs == '') .and. &
             [(known_effects(i)%own(1) == '' .or. effects%has_numbers(i), i=1, size(some))]
    end associate
    call list_some(scene_in, some, list)
  end subroutine list_left_out

  subroutine list_some(scene_in, some, list)
    type(scene), intent(in) :: scene_in
    logical, intent(in) :: some(:)
    type(effect_box), allocatable, intent(out) :: list(:)
    integer :: used

    allocate (list(count(some)))
    used = 0
    ! Laws of a contact first, then interaction, then effects on the loads.
    if (is_next('plasticity')) call new_plasticity(scene_in, list(used)%effect)
    if (is_next('adhesion')) call new_adhesion(scene_in, list(used)%effect)
    if (is_next('interaction')) call new_interaction(scene_in, list(used)%effect)
    if (is_next('creep')) call new_creep(scene_in, list(used)%effect)
    if (is_next('friction')) call new_friction(scene_in, list(used)%effect)

  contains

    ! Whether an effect is selected; if so, `used` is its place.
    logical function is_next(name)
      character(len=*), intent(in) :: name

      is_next = some(findloc(known_effects%name, name, 1))
      if (is_next) used = used + 1
    end function is_next

  end subroutine list_some

end module asperity_effect_list
