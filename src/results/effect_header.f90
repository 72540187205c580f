!> The effects of a run and the columns of their results.
module asperity_effect_header
  use asperity_kinds, only: real64
  implicit none
  private

  public :: effect_header

  !> The effects of a scene that are not off, and their columns.
  type :: effect_header
    character(len=11), allocatable :: names(:)             !! names as in &effects
    integer, allocatable :: modes(:)                       !! modes as in &effects
    character(len=20), allocatable :: contact_columns(:)   !! columns of `contact_values`
    character(len=24), allocatable :: state_columns(:)     !! columns of `state_values`
    !> Powers of the modulus and of the length in the unit of each of these columns (2, column).
    integer, allocatable :: contact_powers(:, :), state_powers(:, :)
    real(real64) :: tolerance = 0.0_real64  !! tolerance of `auto`, relative to the load
    real(real64) :: plasticity_index = -1.0_real64  !! index of the surfaces; < 0: not computed
    character(len=5) :: plastic_body = ''                  !! body that yields: upper or lower
    real(real64) :: hardness = 0.0_real64  !! hardness of the pixels of a map; 0: none
  end type effect_header

end module asperity_effect_header
