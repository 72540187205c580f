!> The effects of a run and the columns of their results.
module asperity_effect_header
  use asperity_kinds, only: real64
  implicit none
  private

  public :: add_columns, add_effect, begin_header, column_name, effect_column, effect_header
  public :: plain, length, force, moment, area, stiffness

  ! Powers of the modulus and of the length in the unit of a column, derived from the dimension.
  integer, parameter :: plain(2) = [0, 0]      !! of a number
  integer, parameter :: length(2) = [0, 1]     !! of a length
  integer, parameter :: area(2) = [0, 2]       !! of an area
  integer, parameter :: stiffness(2) = [1, 1]  !! of a force over a length
  integer, parameter :: force(2) = [1, 2]      !! of a force
  integer, parameter :: moment(2) = [1, 3]     !! of a moment or an energy

  !> The name of a column of a CSV file, and its unit.
  type :: column_name
    character(len=24) :: text = ''            !! name of the column in the header of the file
    integer :: modulus_power = 0              !! power of the modulus in its unit
    integer :: length_power = 0               !! power of the length in its unit
  end type column_name

  !> The effects of a scene that are not off, and their columns.
  type :: effect_header
    character(len=11), allocatable :: names(:)             !! names as in &effects
    integer, allocatable :: modes(:)                       !! modes as in &effects
    character(len=24), allocatable :: contact_columns(:)   !! columns of `contact_values`
    character(len=24), allocatable :: state_columns(:)     !! columns of `state_values`
    !> Powers of the modulus and of the length in the unit of each of these columns (2, column).
    integer, allocatable :: contact_powers(:, :), state_powers(:, :)
    real(real64) :: tolerance = 0.0_real64  !! tolerance of `auto`, relative to the load
    real(real64) :: plasticity_index = -1.0_real64  !! index of the surfaces; < 0: not computed
    character(len=5) :: plastic_body = ''                  !! body that yields: upper or lower
    real(real64) :: hardness = 0.0_real64  !! hardness of the pixels of a map; 0: none
  end type effect_header

contains

  !> Begins a header without effects.
  pure subroutine begin_header(header)
    type(effect_header), intent(out) :: header  !! header without columns

    allocate (header%names(0), header%modes(0), header%contact_columns(0), &
              header%state_columns(0), header%contact_powers(2, 0), header%state_powers(2, 0))
  end subroutine begin_header

  !> Adds an effect, before its columns.
  pure subroutine add_effect(header, name, mode)
    type(effect_header), intent(inout) :: header  !! gets the effect
    character(len=*), intent(in) :: name          !! name as in &effects
    integer, intent(in) :: mode                   !! mode as in &effects

    header%names = [character(len=11) :: header%names, name]
    header%modes = [header%modes, mode]
  end subroutine add_effect

  !> Column with a name and a unit.
  pure type(column_name) function effect_column(name, unit) result(column)
    character(len=*), intent(in) :: name  !! name in the header of the file
    integer, intent(in) :: unit(2)        !! `plain`, `length`, `force` ...

    column = column_name(name, unit(1), unit(2))
  end function effect_column

  !> Adds columns of states or of contacts.
  pure subroutine add_columns(columns, powers, added)
    character(len=24), allocatable, intent(inout) :: columns(:)  !! columns so far
    integer, allocatable, intent(inout) :: powers(:, :)          !! powers in their units
    type(column_name), intent(in) :: added(:)                    !! columns that are added
    integer :: i

    powers = reshape([powers, [(added(i)%modulus_power, added(i)%length_power, &
                                i=1, size(added))]], [2, size(columns) + size(added)])
    columns = [character(len=24) :: columns, added%text]
  end subroutine add_columns

end module asperity_effect_header
