!> The results of a run as tables, row by row: what every column is called and what it holds stands
!> here, once for all files and for the arrays that other languages see.
!>
!> Tables: a row a position (its last state), a row a state, a row a contact.
module asperity_result_table
  use asperity_contact_records, only: contact_radius, contact_row, effect_record, position_result, &
                                      state_row
  use asperity_effect_names, only: known_effects
  use asperity_kinds, only: not_computed, real64
  use asperity_scene_results, only: has_height_map, kinds_of_warnings, last_state, nominal_names, &
                                    nominal_values, scene_results
  use asperity_unit_names, only: is_area, is_force, is_length, is_moment, is_number, is_pressure, &
                                 powers_of, unit_powers
  implicit none
  private

  public :: result_table, word_length
  public :: of_positions, of_states, of_contacts, table_names
  public :: cell_real, cell_whole, cell_count, cell_word

  !> The tables.
  integer, parameter :: of_positions = 1, of_states = 2, of_contacts = 3
  !> Their names.
  character(len=*), parameter :: table_names(3) = [character(len=9) :: 'positions', 'states', &
    'contacts']

  !> Kinds of columns: doubles, which may be `not_computed`; whole numbers, or 1 and 0 for yes
  !> and no; whole numbers that may be `not_computed`; words.
  integer, parameter :: cell_real = 1, cell_whole = 2, cell_count = 3, cell_word = 4

  ! Dimensions of `nominal_names`.
  type(unit_powers), parameter :: nominal_dimensions(2) = [is_pressure, is_number]

  ! Columns that a table has without effects, at most, and that it has for each.
  integer, parameter :: most_own = 30, columns_of_effect = 5

  !> Letters of a word at most, and of the name of a column.
  integer, parameter :: word_length = 16, name_length = 32

  !> One table, at one of its rows.
  type :: result_table
    integer :: rows = 0                                      !! all of them
    character(len=name_length), allocatable :: names(:)      !! of the columns
    integer, allocatable :: kinds(:)                         !! of each, one of the `cell_` numbers
    type(unit_powers), allocatable :: dimensions(:)          !! of each, powers in its unit
    real(real64), allocatable :: numbers(:)                  !! of this row, by column
    character(len=word_length), allocatable :: words(:)      !! of this row, by column
    integer, private :: which = of_positions
    integer, private :: at = 0                               ! column filled last
    integer, private :: position = 0, state = 0, contact = 0 ! of this row
  contains
    procedure :: begin_rows       !! names the columns, before the first row
    procedure :: next_row         !! goes to the next row
    procedure, private :: put_number
    procedure, private :: put_whole
    procedure, private :: put_word
    generic, private :: put => put_number, put_whole, put_word
  end type result_table

contains

  !> Stands before the first row.
  subroutine begin_rows(self, which, results)
    class(result_table), intent(out) :: self    !! gets the columns
    integer, intent(in) :: which                !! one of the `of_` numbers
    type(scene_results), intent(in) :: results  !! results of a run; contacts need their rows
    integer :: m, most

    self%which = which
    most = most_own
    if (allocated(results%effects)) &
      most = most + columns_of_effect * size(results%effects%names) + &
             size(results%effects%state_columns) + size(results%effects%contact_columns)
    allocate (self%names(most), self%kinds(most), self%dimensions(most), self%numbers(most), &
              self%words(most))
    self%words = ''
    do m = 1, size(results%positions)
      associate (position => results%positions(m))
        select case (which)
        case (of_positions)
          self%rows = self%rows + 1
        case (of_states)
          self%rows = self%rows + size(position%states)
        case default
          self%rows = self%rows + sum(position%states%last_row - position%states%first_row + 1)
        end select
      end associate
    end do
    ! A row that is thrown away names the columns.
    select case (which)
    case (of_positions)
      call fill_position(self, results, 1, results%positions(1))
    case (of_states)
      call fill_state(self, results, 1, 1, results%positions(1)%states(1))
    case default
      call fill_contact(self, results, 1, 1, contact_row())
    end select
    self%names = self%names(:self%at)
    self%kinds = self%kinds(:self%at)
    self%dimensions = self%dimensions(:self%at)
  end subroutine begin_rows

  !> Goes to the next row. `found` is false behind the last.
  subroutine next_row(self, results, found)
    class(result_table), intent(inout) :: self  !! table with named columns
    type(scene_results), intent(in) :: results  !! the results of `begin_rows`
    logical, intent(out) :: found               !! there is one

    self%at = 0
    found = .false.
    if (self%which == of_contacts .and. self%position > 0) then
      self%contact = self%contact + 1
      found = self%contact <= results%positions(self%position)%states(self%state)%last_row
    end if
    do while (.not. found)
      if (self%which /= of_positions .and. self%position > 0) self%state = self%state + 1
      if (self%which == of_positions .or. self%position == 0) then
        call next_position()
      else if (self%state > size(results%positions(self%position)%states)) then
        call next_position()
      end if
      if (self%position > size(results%positions)) return
      found = .true.
      if (self%which /= of_contacts) exit
      associate (state => results%positions(self%position)%states(self%state))
        self%contact = state%first_row
        found = state%first_row <= state%last_row
      end associate
    end do
    associate (position => results%positions(self%position))
      select case (self%which)
      case (of_positions)
        call fill_position(self, results, self%position, position)
      case (of_states)
        call fill_state(self, results, self%position, self%state, position%states(self%state))
      case default
        call fill_contact(self, results, self%position, self%state, position%rows(self%contact))
      end select
    end associate

  contains

    subroutine next_position()
      self%position = self%position + 1
      self%state = 1
    end subroutine next_position

  end subroutine next_row

  ! One position: its last state, and what the effects did.
  subroutine fill_position(self, results, m, position)
    class(result_table), intent(inout) :: self
    type(scene_results), intent(in) :: results
    integer, intent(in) :: m
    type(position_result), intent(in) :: position
    type(state_row) :: last
    integer :: i

    last = last_state(position)
    call self%put('position', m)
    call self%put('x_displacement', position%x_displacement, is_length)
    call self%put('y_displacement', position%y_displacement, is_length)
    call self%put('steps', size(position%states))
    call self%put('separation', last%approach, is_length)
    call self%put('contacts', last%contacts)
    call self%put('load', last%load, is_force)
    call self%put('area', last%area, is_area)
    call self%put('projected_area', last%projected_area, is_area)
    call self%put('limit_reached', merge(1, 0, position%limit_reached))
    call self%put('vertical_load', last%vertical_load, is_force)
    call self%put('compression', last%closing, is_length)
    call self%put('overlapping_circles', merge(real(position%overlapping_circles, real64), &
                                               not_computed, position%overlapping_circles >= 0), &
                  cell=merge(cell_whole, cell_count, position%overlapping_circles >= 0))
    call fill_nominal(self, results, last)
    call fill_gap(self, results, last)
    if (allocated(results%effects)) then
      do i = 1, size(position%effects)
        call fill_effect(self, trim(results%effects%names(i)), position%effects(i))
      end do
      do i = 1, size(position%state_values)
        call self%put(results%effects%state_columns(i), position%state_values(i), &
                      powers_of(results%effects%state_powers(:, i)))
      end do
    end if
    if (allocated(results%map)) then
      call self%put('summit_separation_error', results%map%difference)
      call self%put('summit_area_error', results%map%area_difference)
      call self%put('summit_load_error', merge(results%map%load_difference, not_computed, &
                                               results%map%load_difference < huge(1.0_real64)))
      call self%put('summit_stiffness_error', results%map%stiffness_difference)
    end if
    call self%put('warnings', kinds_of_warnings(position))
    call fill_estimates(self, results, position)
  end subroutine fill_position

  ! Estimates of a position: the influence of each effect that is off, the error.
  subroutine fill_estimates(self, results, position)
    class(result_table), intent(inout) :: self
    type(scene_results), intent(in) :: results
    type(position_result), intent(in) :: position
    integer :: e

    do e = 1, size(known_effects)
      if (results%positions(1)%left_out(e) > not_computed) &
        call self%put(trim(known_effects(e)%name) // '_estimate', position%left_out(e))
    end do
    call self%put('error_estimate', position%error_estimate)
  end subroutine fill_estimates

  ! Record of an effect at a position: how it was simulated (off: left out), the share of the
  ! vertical load that was estimated and that measured, and how its solve ended.
  subroutine fill_effect(self, name, effect)
    class(result_table), intent(inout) :: self
    character(len=*), intent(in) :: name
    type(effect_record), intent(in) :: effect
    real(real64) :: ending(2)

    ending = not_computed
    if (effect%simulated /= 'off' .and. effect%ending%residual > not_computed) &
      ending = [effect%ending%residual, real(effect%ending%iterations, real64)]
    call self%put(name, effect%simulated)
    call self%put(name // '_estimate', effect%estimate)
    call self%put(name // '_influence', effect%influence)
    call self%put(name // '_residual', ending(1))
    call self%put(name // '_iterations', ending(2), cell=cell_count)
  end subroutine fill_effect

  ! One state: the totals on the way to the end.
  subroutine fill_state(self, results, m, step, state)
    class(result_table), intent(inout) :: self
    type(scene_results), intent(in) :: results
    integer, intent(in) :: m, step
    type(state_row), intent(in) :: state

    call self%put('position', m)
    call self%put('step', step)
    call self%put('separation', state%approach, is_length)
    call self%put('compression', state%closing, is_length)
    call self%put('contacts', state%contacts)
    call self%put('load', state%load, is_force)
    call self%put('area', state%area, is_area)
    call self%put('projected_area', state%projected_area, is_area)
    call self%put('vertical_load', state%vertical_load, is_force)
    call self%put('time', state%time)
    if (allocated(results%effects)) then
      if (any(results%effects%names == 'plasticity')) &
        call self%put('dissipated_work', state%dissipated_work, is_moment)
      if (any(results%effects%state_columns == 'plastic_area')) &
        call self%put('plastic_area', state%plastic_area, is_area)
    end if
    call fill_nominal(self, results, state)
    call fill_gap(self, results, state)
    call fill_estimates(self, results, results%positions(m))
  end subroutine fill_state

  ! A state over the nominal area, where one is given.
  subroutine fill_nominal(self, results, state)
    class(result_table), intent(inout) :: self
    type(scene_results), intent(in) :: results
    type(state_row), intent(in) :: state
    integer :: i

    associate (values => nominal_values(results, state))
      do i = 1, size(values)
        call self%put(nominal_names(i), values(i), nominal_dimensions(i))
      end do
    end associate
  end subroutine fill_nominal

  ! Gap, rims and energy of a state of a height map.
  subroutine fill_gap(self, results, state)
    class(result_table), intent(inout) :: self
    type(scene_results), intent(in) :: results
    type(state_row), intent(in) :: state

    if (.not. has_height_map(results)) return
    call self%put('mean_gap', state%mean_gap, is_length)
    call self%put('rms_gap', state%rms_gap, is_length)
    call self%put('contact_perimeter', state%contact_perimeter, is_length)
    call self%put('elastic_energy', state%elastic_energy, is_moment)
  end subroutine fill_gap

  ! One contact in one state.
  subroutine fill_contact(self, results, m, step, row)
    class(result_table), intent(inout) :: self
    type(scene_results), intent(in) :: results
    integer, intent(in) :: m, step
    type(contact_row), intent(in) :: row
    real(real64) :: value
    integer :: i

    associate (position => results%positions(m))
      call self%put('position', m)
      call self%put('x_displacement', position%x_displacement, is_length)
      call self%put('y_displacement', position%y_displacement, is_length)
      call self%put('step', step)
      call self%put('separation', position%states(step)%approach, is_length)
      call self%put('area_no', row%area_no)
      call self%put('x', row%x, is_length)
      call self%put('y', row%y, is_length)
      call self%put('upper', row%upper)
      call self%put('lower', row%lower)
      call self%put('area', row%area, is_area)
      call self%put('projected_area', row%projected_area, is_area)
      call self%put('slope', row%slope)
      call self%put('load', row%load, is_force)
      call self%put('average_pressure', row%average_pressure, is_pressure)
      call self%put('maximum_pressure', row%maximum_pressure, is_pressure)
      call self%put('limit_exceeded', merge(1, 0, row%limit_exceeded))
      call self%put('vertical_load', row%vertical_load, is_force)
      call self%put('compression', position%states(step)%closing, is_length)
      call self%put('penetration', row%penetration, is_length)
      call self%put('overlap', row%overlap, is_length)
      if (allocated(results%effects)) then
        value = not_computed
        do i = 1, size(results%effects%contact_columns)
          if (self%contact > 0) value = position%contact_values(self%contact, i)
          call self%put(results%effects%contact_columns(i), value, &
                        powers_of(results%effects%contact_powers(:, i)))
        end do
      end if
      call self%put('contact_radius', contact_radius(row), is_length)
    end associate
  end subroutine fill_contact

  subroutine put_number(self, name, value, dimension, cell)
    class(result_table), intent(inout) :: self
    character(len=*), intent(in) :: name
    real(real64), intent(in) :: value
    type(unit_powers), intent(in), optional :: dimension
    integer, intent(in), optional :: cell

    self%at = self%at + 1
    if (self%position == 0) then
      self%names(self%at) = name
      self%kinds(self%at) = cell_real
      self%dimensions(self%at) = is_number
      if (present(dimension)) self%dimensions(self%at) = dimension
      if (present(cell)) self%kinds(self%at) = cell
    end if
    self%numbers(self%at) = value
  end subroutine put_number

  subroutine put_whole(self, name, value)
    class(result_table), intent(inout) :: self
    character(len=*), intent(in) :: name
    integer, intent(in) :: value

    call self%put_number(name, real(value, real64), cell=cell_whole)
  end subroutine put_whole

  subroutine put_word(self, name, value)
    class(result_table), intent(inout) :: self
    character(len=*), intent(in) :: name, value

    call self%put_number(name, not_computed, cell=cell_word)
    self%words(self%at) = value
  end subroutine put_word

end module asperity_result_table
