!> What a run gives: all positions of a scene. Numbers are doubles in the units of the scene.
module asperity_scene_results
  use asperity_contact_records, only: position_result, state_row
  use asperity_kinds, only: not_computed, real64
  use asperity_map_shares, only: map_shares
  implicit none
  private

  public :: effect_header, map_record, scene_results, kinds_of_warnings, last_state, &
            has_height_map, nominal_values, nominal_names

  !> Quantities over the nominal area: vertical load, projected area of the contacts.
  character(len=*), parameter :: nominal_names(2) = &
    [character(len=16) :: 'nominal_pressure', 'area_fraction']

  !> The effects of a scene that are not off, and their columns.
  type :: effect_header
    character(len=11), allocatable :: names(:)             !! as in &effects
    integer, allocatable :: modes(:)                       !! as in &effects
    character(len=20), allocatable :: contact_columns(:)   !! of `contact_values` of a position
    character(len=20), allocatable :: state_columns(:)     !! of `state_values` of a position
    !> Powers of the modulus and of the length in the unit of each of these columns (2, column).
    integer, allocatable :: contact_powers(:, :), state_powers(:, :)
    real(real64) :: tolerance = 0.0_real64                 !! share of the load for `auto`
    real(real64) :: plasticity_index = -1.0_real64         !! of the surfaces; negative: not known
    character(len=5) :: plastic_body = ''                  !! that yields: upper or lower
    real(real64) :: hardness = 0.0_real64                  !! of the pixels of a map; 0: none
  end type effect_header

  !> How the summits of a map compare with the map itself at the same load.
  type :: map_record
    integer :: summits = 0                              !! how many
    integer :: coarser = 1                              !! samples in one of those pressed, a side
    real(real64) :: rms_height = 0.0_real64             !! of the map
    real(real64) :: closing = 0.0_real64                !! of the map, from its highest sample
    real(real64) :: difference = 0.0_real64             !! separation less that, in rms heights
    real(real64) :: uncertain = 0.0_real64              !! of that, for the coarser map
    real(real64) :: area_difference = not_computed      !! share of that of the map
    real(real64) :: load_difference = huge(1.0_real64)  !! at the same separation, share
    real(real64) :: load_uncertain = 0.0_real64         !! of that, for the coarser map
    real(real64) :: stiffness_difference = not_computed !! share of that of the map
    type(map_shares) :: shares                          !! of the load, where it is
  end type map_record

  !> All positions of a scene.
  type :: scene_results
    type(position_result), allocatable :: positions(:)     !! in order
    !> Its effects; not allocated: it has none.
    type(effect_header), allocatable :: effects
    character(len=7) :: arithmetic = ''                    !! in which it was solved
    real(real64) :: nominal_area = 0.0_real64              !! of the surfaces in plan; 0: not given
    type(map_record), allocatable :: map                   !! summits for a map
    real(real64) :: error_bound = 0.0_real64               !! where an accuracy was asked for
    character(len=:), allocatable :: way_taken             !! there: the cheapest that has it
    character(len=:), allocatable :: way_told              !! there: what else is to be said of it
    !> Processor time of this process when its first position begins, s; negative: none did.
    real(real64) :: begun = -1.0_real64
  end type scene_results

contains

  !> The last state of a position.
  pure type(state_row) function last_state(position)
    type(position_result), intent(in) :: position  !! solved

    last_state = position%states(size(position%states))
  end function last_state

  !> Whether the scene is a height map, solved on its pixels or by its summits.
  pure logical function has_height_map(results)
    type(scene_results), intent(in) :: results  !! solved

    has_height_map = allocated(results%map)
    if (.not. has_height_map .and. allocated(results%positions)) has_height_map = &
      any(results%positions(1)%states%mean_gap > not_computed)
  end function has_height_map

  !> A state over the nominal area, as `nominal_names` has it; none where no area is given.
  pure function nominal_values(results, state) result(values)
    type(scene_results), intent(in) :: results  !! with the area
    type(state_row), intent(in) :: state        !! one of its states
    real(real64), allocatable :: values(:)

    allocate (values(0))
    if (results%nominal_area > 0.0_real64) &
      values = [state%vertical_load, state%projected_area] / results%nominal_area
  end function nominal_values

  !> How many kinds of warnings apply at a position.
  pure integer function kinds_of_warnings(position)
    type(position_result), intent(in) :: position  !! solved

    kinds_of_warnings = 0
    if (allocated(position%warnings)) kinds_of_warnings = size(position%warnings)
  end function kinds_of_warnings

end module asperity_scene_results
