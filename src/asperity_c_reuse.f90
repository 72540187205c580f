!> The library for C: scenes that are changed and solved again.
module asperity_c_reuse
  use, intrinsic :: iso_c_binding, only: c_associated, c_ptr
  use asperity, only: rebuild_scene
  use asperity_c_outcome, only: begin_outcome, finish_scene, look_at, outcome, text_of
  implicit none
  private

  public :: c_rebuild_scene

contains

  !> `asperity_rebuild_scene`.
  type(c_ptr) function c_rebuild_scene(of_scene, groups) bind(c, name='asperity_rebuild_scene') &
    result(handle)
    type(c_ptr), value :: of_scene  !! outcome that has a scene
    type(c_ptr), value :: groups    !! text of all its groups
    type(outcome), pointer :: from, new

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    allocate (new%scene_in)
    call look_at(of_scene, from)
    if (associated(from)) call new%problems%append(from%problems)
    if (.not. associated(from)) then
      call new%problems%add('scene: found NULL, expected an outcome that has a scene')
    else if (.not. allocated(from%scene_in)) then
      call new%problems%add('scene: found an outcome without a scene, expected one that has it')
    end if
    if (.not. c_associated(groups)) call new%problems%add('groups: found NULL, expected a text')
    if (new%problems%count() == 0) &
      call rebuild_scene(from%scene_in, text_of(groups), new%scene_in, new%problems)
    call finish_scene(new)
  end function c_rebuild_scene

end module asperity_c_reuse
