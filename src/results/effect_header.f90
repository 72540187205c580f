!> The effects of a run and the columns of their results.
module asperity_effect_header
  use asperity_kinds, only: not_computed, real64
  implicit none
  private

  public :: add_effect, begin_header, column_list, column_name, effect_header, take_columns
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
    character(len=32) :: text = ''            !! name of the column in the header of the file
    integer :: modulus_power = 0              !! power of the modulus in its unit
    integer :: length_power = 0               !! power of the length in its unit
    character(len=8) :: word = ''             !! unit of its own, in place of the powers
  end type column_name

  !> Columns with their names, units and values, of one state or of contacts.
  type :: column_list
    integer :: rows = 0                                  !! length of each column; 0: of the first
    logical :: is_left_out = .false.                     !! columns that are added get no values
    type(column_name), allocatable :: names(:)           !! names and units
    real(real64), allocatable :: values(:, :)            !! (row, column)
  contains
    procedure :: add_value
    procedure :: add_values
    generic :: add => add_value, add_values
  end type column_list

  !> The effects of a scene that are not off, and their columns.
  type :: effect_header
    character(len=11), allocatable :: names(:)             !! names as in &effects
    integer, allocatable :: modes(:)                       !! modes as in &effects
    character(len=32), allocatable :: contact_columns(:)   !! columns of `contact_values`
    character(len=32), allocatable :: state_columns(:)     !! columns of `state_values`
    !> Powers of the modulus and of the length in the unit of each of these columns (2, column).
    integer, allocatable :: contact_powers(:, :), state_powers(:, :)
    character(len=8), allocatable :: state_words(:)        !! units in place of these powers
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
              header%state_columns(0), header%contact_powers(2, 0), header%state_powers(2, 0), &
              header%state_words(0))
  end subroutine begin_header

  !> Adds an effect, before its columns.
  pure subroutine add_effect(header, name, mode)
    type(effect_header), intent(inout) :: header  !! gets the effect
    character(len=*), intent(in) :: name          !! name as in &effects
    integer, intent(in) :: mode                   !! mode as in &effects

    header%names = [character(len=11) :: header%names, name]
    header%modes = [header%modes, mode]
  end subroutine add_effect

  !> Sets the columns of a header.
  pure subroutine take_columns(header, of_states, of_contacts)
    type(effect_header), intent(inout) :: header         !! gets the columns
    type(column_name), intent(in) :: of_states(:)        !! columns of `state_values`
    type(column_name), intent(in) :: of_contacts(:)      !! columns of `contact_values`

    header%state_columns = of_states%text
    header%state_words = of_states%word
    header%contact_columns = of_contacts%text
    header%state_powers = reshape([of_states%modulus_power, of_states%length_power], &
                                  [2, size(of_states)], order=[2, 1])
    header%contact_powers = reshape([of_contacts%modulus_power, of_contacts%length_power], &
                                    [2, size(of_contacts)], order=[2, 1])
  end subroutine take_columns

  !> Adds a column with the value of a single row.
  pure subroutine add_value(self, name, unit, value, word)
    class(column_list), intent(inout) :: self  !! list of one row
    character(len=*), intent(in) :: name       !! name in the header of the file
    integer, intent(in) :: unit(2)             !! `plain`, `length`, `force` ...
    real(real64), intent(in) :: value          !! value; `not_computed`: it is empty
    character(len=*), intent(in), optional :: word  !! unit in place of that of the scene

    call self%add_values(name, unit, [value])
    if (present(word)) self%names(size(self%names))%word = word
  end subroutine add_value

  !> Adds a column with the values of the last rows; the rows before them are empty.
  pure subroutine add_values(self, name, unit, values)
    class(column_list), intent(inout) :: self  !! list of rows
    character(len=*), intent(in) :: name       !! name in the header of the file
    integer, intent(in) :: unit(2)             !! `plain`, `length`, `force` ...
    real(real64), intent(in) :: values(:)      !! at most as many as rows
    real(real64) :: column(merge(size(values), self%rows, self%rows == 0))

    self%rows = size(column)
    column = not_computed
    if (.not. self%is_left_out) column(self%rows - size(values) + 1:) = values
    if (.not. allocated(self%names)) allocate (self%names(0), self%values(self%rows, 0))
    self%names = [self%names, column_name(name, unit(1), unit(2))]
    self%values = reshape([self%values, column], [self%rows, size(self%names)])
  end subroutine add_values

end module asperity_effect_header
