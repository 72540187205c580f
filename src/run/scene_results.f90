!> What a run gives: all positions of a scene. Numbers are doubles in the units of the scene.
module asperity_scene_results
  use asperity_contact_records, only: position_result, state_row
  use asperity_kinds, only: real64
  implicit none
  private

  public :: effect_header, scene_results, last_state

  !> The effects of a scene that are not off, and the columns in which they tell what they did.
  type :: effect_header
    character(len=11), allocatable :: names(:)             !! as in &effects
    integer, allocatable :: modes(:)                       !! as in &effects
    character(len=20), allocatable :: contact_columns(:)   !! of `contact_values` of a position
    character(len=20), allocatable :: state_columns(:)     !! of `state_values` of a position
    real(real64) :: tolerance = 0.0_real64                 !! share of the load for `auto`
    real(real64) :: plasticity_index = -1.0_real64         !! of the surfaces; negative: not known
  end type effect_header

  !> All positions of a scene.
  type :: scene_results
    type(position_result), allocatable :: positions(:)     !! in order
    !> Its effects; not allocated: it has none.
    type(effect_header), allocatable :: effects
    character(len=7) :: arithmetic = ''                    !! in which it was solved
    real(real64) :: error_bound = 0.0_real64               !! where an accuracy was asked for
  end type scene_results

contains

  !> The last state of a position.
  pure type(state_row) function last_state(position)
    type(position_result), intent(in) :: position  !! solved

    last_state = position%states(size(position%states))
  end function last_state

end module asperity_scene_results
