!> Results of a run: all positions of a scene. Numbers are doubles in the units of the scene.
module asperity_scene_results
  use asperity_contact_records, only: position_result, state_row
  use asperity_effect_header, only: effect_header
  use asperity_kinds, only: not_computed, real64
  use asperity_map_shares, only: map_shares
  implicit none
  private

  public :: map_record, scene_results, kinds_of_warnings, last_state, &
            has_height_map

  !> Comparison of the summits of a map with the map itself at the same load.
  type :: map_record
    integer :: summits = 0                              !! number of summits
    integer :: coarser = 1  !! pixels along the side of one that was solved
    real(real64) :: rms_height = 0.0_real64             !! rms height of the map
    real(real64) :: compression = 0.0_real64  !! compression of the map, from its highest pixel
    real(real64) :: difference = 0.0_real64  !! separation less that of the map [rms heights]
    real(real64) :: uncertain = 0.0_real64              !! uncertainty of it by coarser pixels
    real(real64) :: area_difference = not_computed      !! relative to the area of the map
    real(real64) :: load_difference = huge(1.0_real64)  !! relative, at the same separation
    real(real64) :: load_uncertain = 0.0_real64         !! uncertainty of it by coarser pixels
    real(real64) :: stiffness_difference = not_computed  !! relative to that of the map
    type(map_shares) :: shares                          !! shares of the load on artefacts
  end type map_record

  !> All positions of a scene.
  type :: scene_results
    logical :: are_solved = .false.  !! whether all positions are solved; else there are no results
    type(position_result), allocatable :: positions(:)     !! positions in their order
    !> effects of the scene; not allocated: none
    type(effect_header), allocatable :: effects
    character(len=7) :: arithmetic = 'real64'              !! arithmetic of the solution
    real(real64) :: nominal_area = 0.0_real64              !! nominal area; 0: not given
    type(map_record), allocatable :: map                   !! comparison of the summits of a map
    real(real64) :: error_bound = 0.0_real64               !! relative, with a requested accuracy
    character(len=:), allocatable :: way_taken             !! fastest method with this accuracy
    character(len=:), allocatable :: way_told              !! cost of a higher accuracy
    !> processor time of this process at the start of its first position, s; < 0: none started
    real(real64) :: begun = -1.0_real64
  end type scene_results

contains

  !> Last state of a position.
  pure type(state_row) function last_state(position)
    type(position_result), intent(in) :: position  !! result of the position

    last_state = position%states(size(position%states))
  end function last_state

  !> Whether the scene is a height map, solved on its pixels or by its summits.
  pure logical function has_height_map(results)
    type(scene_results), intent(in) :: results  !! results of the scene

    has_height_map = allocated(results%map)
    if (.not. has_height_map .and. allocated(results%positions)) has_height_map = &
      any(results%positions(1)%states%mean_gap > not_computed)
  end function has_height_map

  !> Number of kinds of warnings at a position.
  pure integer function kinds_of_warnings(position)
    type(position_result), intent(in) :: position  !! result of the position

    kinds_of_warnings = 0
    if (allocated(position%warnings)) kinds_of_warnings = size(position%warnings)
  end function kinds_of_warnings

end module asperity_scene_results
