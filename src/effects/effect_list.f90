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
  use asperity_pixel_adhesion, only: new_pixel_adhesion
  use asperity_pixel_creep, only: new_pixel_creep
  use asperity_pixel_friction, only: new_pixel_friction
  use asperity_pixel_law, only: pixel_law_box
  use asperity_pixel_plasticity, only: new_pixel_plasticity
  use asperity_plasticity, only: new_plasticity
  use asperity_scene_values, only: effect_off, scene
  implicit none
  private

  public :: list_effects, list_left_out, list_pixel_laws

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
      some = effects%modes == effect_off .and. known_effects%not_on_asperities == '' .and. &
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

  !> The laws of a map on its pixels, in the order of their columns: those that are not off, and
  !> those that are off and have numbers. Interaction of pixels is the half-space itself.
  subroutine list_pixel_laws(scene_in, pixel, laws, left_out)
    type(scene), intent(in) :: scene_in                        !! scene with a map
    real(real64), intent(in) :: pixel                          !! largest spacing of the pixels
    type(pixel_law_box), allocatable, intent(out) :: laws(:)      !! those that are not off
    type(pixel_law_box), allocatable, intent(out) :: left_out(:)  !! off, to be estimated
    character(len=*), parameter :: names(4) = &
      [character(len=11) :: 'friction', 'plasticity', 'adhesion', 'creep']
    type(pixel_law_box) :: all_laws(size(names))
    logical, dimension(size(names)) :: is_off, has_numbers
    integer :: i, places(size(names))

    call new_pixel_friction(scene_in, all_laws(1)%law)
    call new_pixel_plasticity(scene_in, all_laws(2)%law)
    call new_pixel_adhesion(scene_in, pixel, all_laws(3)%law)
    call new_pixel_creep(scene_in, all_laws(4)%law)
    associate (effects => scene_in%effects)
      places = [(findloc(known_effects%name, names(i), 1), i=1, size(names))]
      is_off = effects%modes(places) == effect_off
      has_numbers = [(effects%has_numbers(places(i)), i=1, size(names))]
      has_numbers(2) = has_numbers(2) .or. effects%number('plastic_hardness') > 0.0_real64
      has_numbers(1) = has_numbers(1) .and. .not. scene_in%contact_modulus > 0.0_real64
    end associate
    allocate (laws(count(.not. is_off)), left_out(count(is_off .and. has_numbers)))
    do i = 1, size(names)
      if (.not. is_off(i)) &
        allocate (laws(count(.not. is_off(:i)))%law, source=all_laws(i)%law)
      if (is_off(i) .and. has_numbers(i)) &
        allocate (left_out(count(is_off(:i) .and. has_numbers(:i)))%law, source=all_laws(i)%law)
    end do
  end subroutine list_pixel_laws

end module asperity_effect_list
