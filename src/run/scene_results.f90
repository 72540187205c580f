!> Results of a run: all positions of a scene. Numbers are doubles in the units of the scene.
module asperity_scene_results
  use asperity_contact_records, only: position_result, state_row
  use asperity_effect_header, only: effect_header, take_columns
  use asperity_kinds, only: not_computed, real64
  implicit none
  private

  public :: scene_results, kinds_of_warnings, last_state, has_height_map, name_columns

  !> All positions of a scene.
  type :: scene_results
    logical :: are_solved = .false.  !! whether all positions are solved; else there are no results
    type(position_result), allocatable :: positions(:)     !! positions in their order
    !> effects of the scene; not allocated: none
    type(effect_header), allocatable :: effects
    character(len=7) :: arithmetic = 'real64'              !! arithmetic of the solution
    real(real64) :: nominal_area = 0.0_real64              !! nominal area; 0: not given
    real(real64) :: error_bound = 0.0_real64               !! relative, with a requested accuracy
    character(len=:), allocatable :: way_taken             !! fastest method with this accuracy
  end type scene_results

contains

  !> Sets the columns of the effects, which all positions have in the same order.
  pure subroutine name_columns(results)
    type(scene_results), intent(inout) :: results  !! results of the scene with all positions
    integer :: m

    if (.not. allocated(results%effects)) return
    do m = 1, size(results%positions)
      associate (position => results%positions(m))
        if (.not. allocated(position%state_columns)) cycle
        call take_columns(results%effects, position%state_columns, position%contact_columns)
        return
      end associate
    end do
  end subroutine name_columns

  !> Last state of a position.
  pure type(state_row) function last_state(position)
    type(position_result), intent(in) :: position  !! result of the position

    last_state = position%states(size(position%states))
  end function last_state

  !> Whether the scene is a height map.
  pure logical function has_height_map(results)
    type(scene_results), intent(in) :: results  !! results of the scene

    has_height_map = allocated(results%positions)
    if (has_height_map) has_height_map = &
      any(results%positions(1)%states%mean_gap > not_computed)
  end function has_height_map

  !> Number of kinds of warnings at a position.
  pure integer function kinds_of_warnings(position)
    type(position_result), intent(in) :: position  !! result of the position

    kinds_of_warnings = 0
    if (allocated(position%warnings)) kinds_of_warnings = size(position%warnings)
  end function kinds_of_warnings

end module asperity_scene_results
