!> What the effects of a scene did, as records: the solver fills them, the writers read them.
module asperity_effect_report
  use asperity_contact_effect, only: effect_outcome
  use asperity_kinds, only: real64
  implicit none
  private

  public :: effect_report, effects_at_position

  !> One position: every effect, at its last state.
  type :: effects_at_position
    type(effect_outcome), allocatable :: outcomes(:)    !! one an effect
    real(real64), allocatable :: contact_values(:, :)   !! (row of the position, column)
    real(real64), allocatable :: state_values(:)        !! (column), of the last state
  end type effects_at_position

  !> A whole scene. The names and columns are those of the effects that are not off.
  type :: effect_report
    character(len=11), allocatable :: names(:)             !! as in &effects
    integer, allocatable :: modes(:)                       !! as in &effects
    character(len=20), allocatable :: contact_columns(:)   !! header of the columns of a contact
    character(len=20), allocatable :: state_columns(:)     !! header of the columns of a position
    real(real64) :: tolerance = 0.0_real64                 !! share of the load for `auto`
    real(real64) :: plasticity_index = -1.0_real64         !! of the surfaces; negative: not known
    type(effects_at_position), allocatable :: positions(:) !! in order; not allocated: no effects
  end type effect_report

end module asperity_effect_report
