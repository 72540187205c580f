!> The results of a run as tables of columns: what every column is called, its unit and what it
!> holds stand here, once for all files, for the summary and for other languages.
!>
!> Tables: a row a position (its last state), a row a state, a row a contact.
module asperity_result_table
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
  use asperity_contact_records, only: contact_radius, contact_row, effect_record, &
                                      position_result, state_row
  use asperity_effect_names, only: known_effects
  use asperity_kinds, only: int32, int64, not_computed, real64
  use asperity_map_interface, only: conductance_columns, conductance_units
  use asperity_process, only: has_memory
  use asperity_scene_results, only: has_height_map, kinds_of_warnings, last_state, scene_results
  use asperity_scene_values, only: scene
  use asperity_text_buffer, only: text_buffer
  use asperity_unit_names, only: is_area, is_force, is_length, is_moment, is_number, is_pressure, &
                                 powers_of, unit_of, unit_powers
  implicit none
  private

  public :: array_column, array_table, make_arrays, add_reals, add_surface, add_wholes, &
            name_units, numbers_of, place_of
  public :: add_words, put_cell
  public :: of_positions, of_states, of_contacts, table_names

  !> The tables.
  integer, parameter :: of_positions = 1, of_states = 2, of_contacts = 3
  !> Their names.
  character(len=*), parameter :: table_names(3) = [character(len=9) :: 'positions', 'states', &
    'contacts']

  ! Columns that a table has without effects, and that it has for each, at most.
  integer, parameter :: most_own = 30, columns_of_effect = 5
  ! Letters of a word.
  integer, parameter :: word_length = 16

  !> One column. One of the three arrays is allocated.
  type :: array_column
    character(len=:), allocatable :: name                    !! as in the files
    type(unit_powers) :: dimension                           !! powers in its unit
    character(len=:), allocatable :: unit                    !! `N/mm2`; not allocated: not known
    real(real64), allocatable :: reals(:)                    !! NaN where a cell is empty
    logical :: is_count = .false.                            !! its reals are whole numbers
    integer(int32), allocatable :: wholes(:)                 !! whole numbers; yes and no: 1 and 0
    character(len=1), allocatable :: letters(:, :)           !! words (letter, row), blanks behind
  end type array_column

  !> A table.
  type :: array_table
    integer :: rows = 0                           !! length of every column
    type(array_column), allocatable :: columns(:) !! not allocated: there is no such table
  end type array_table

  ! A table of a run, filled block by block. The first block has no rows and adds the columns.
  type, extends(array_table) :: growing_table
    logical :: is_named = .false.    ! it has all columns
    integer :: before = 0            ! rows of earlier blocks
    integer :: at = 0                ! column of the block filled last
  contains
    procedure :: put_reals
    procedure :: put_wholes
    procedure :: put_words
    generic :: put => put_reals, put_wholes, put_words
    procedure :: end_block
  end type growing_table

contains

  !> One of the tables of a run. `failure` is allocated when there is no memory for it. Contacts
  !> that were not kept have no rows.
  subroutine make_arrays(which, results, arrays, failure)
    integer, intent(in) :: which                           !! table, one of the `of_` numbers
    type(scene_results), intent(in) :: results             !! results of a run
    type(array_table), intent(out) :: arrays               !! table of columns
    character(len=:), allocatable, intent(out) :: failure  !! reason of a failure
    type(growing_table) :: table
    integer :: columns, m, step

    columns = most_own
    if (allocated(results%effects)) &
      columns = columns + columns_of_effect * size(results%effects%names) + &
                size(results%effects%state_columns) + size(results%effects%contact_columns)
    do m = 1, size(results%positions)
      associate (states => results%positions(m)%states)
        table%rows = table%rows + merge(1, size(states), which == of_positions)
        if (which == of_contacts) table%rows = table%rows - size(states) + &
          sum(states%last_row - states%first_row + 1)
      end associate
    end do
    arrays%rows = table%rows
    if (.not. has_memory(8_int64 * columns * table%rows)) then
      failure = 'not enough memory for the ' // trim(table_names(which)) // ' as arrays'
      if (which == of_contacts) failure = failure // ', expected fewer, or none kept'
      return
    end if
    select case (which)
    case (of_positions)
      call fill_positions(table, results, results%positions(:0))
      call fill_positions(table, results, results%positions)
    case (of_states)
      call fill_states(table, results, 1, [state_row ::])
      do m = 1, size(results%positions)
        call fill_states(table, results, m, results%positions(m)%states)
      end do
    case default
      call fill_contacts(table, results, 1, 1, [contact_row ::])
      do m = 1, size(results%positions)
        associate (position => results%positions(m))
          do step = 1, size(position%states)
            associate (state => position%states(step))
              if (state%first_row <= state%last_row) &
                call fill_contacts(table, results, m, step, &
                                   position%rows(state%first_row:state%last_row))
            end associate
          end do
        end associate
      end do
    end select
    call move_alloc(table%columns, arrays%columns)
  end subroutine make_arrays

  ! Positions: the last state of each, and what the effects did.
  subroutine fill_positions(table, results, positions)
    type(growing_table), intent(inout) :: table
    type(scene_results), intent(in) :: results
    type(position_result), intent(in) :: positions(:)
    type(state_row) :: last(size(positions))
    real(real64), dimension(size(positions)) :: circles, one
    type(unit_powers) :: dimension
    integer :: i, k, m

    do m = 1, size(positions)
      last(m) = last_state(positions(m))
    end do
    one = 1.0_real64
    call table%put('position', [(m, m=1, size(positions))])
    call table%put('x_displacement', positions%x_displacement, is_length)
    call table%put('y_displacement', positions%y_displacement, is_length)
    call table%put('steps', [(size(positions(m)%states), m=1, size(positions))])
    call table%put('separation', last%approach, is_length)
    call table%put('contacts', last%contacts)
    call table%put('load', last%load, is_force)
    call table%put('area', last%area, is_area)
    call table%put('projected_area', last%projected_area, is_area)
    call table%put('limit_reached', merge(1, 0, positions%limit_reached))
    call table%put('vertical_load', last%vertical_load, is_force)
    call table%put('compression', last%compression, is_length)
    circles = merge(real(positions%overlapping_circles, real64), not_computed, &
                    positions%overlapping_circles >= 0)
    if (results%positions(1)%overlapping_circles >= 0) then
      call table%put('overlapping_circles', positions%overlapping_circles)
    else
      call table%put('overlapping_circles', circles, is_count=.true.)
    end if
    call fill_nominal(table, results, last)
    call fill_gap(table, results, last)
    if (allocated(results%effects)) then
      do i = 1, size(results%effects%names)
        call fill_effect(table, trim(results%effects%names(i)), positions, i)
      end do
      do i = 1, size(results%effects%state_columns)
        dimension = powers_of(results%effects%state_powers(:, i))
        k = findloc(conductance_columns == results%effects%state_columns(i), .true., 1)
        if (k > 0) dimension%word = conductance_units(k)
        call table%put(trim(results%effects%state_columns(i)), &
                       [(positions(m)%state_values(i), m=1, size(positions))], dimension)
      end do
    end if
    if (allocated(results%map)) then
      call table%put('summit_separation_error', one * results%map%difference)
      call table%put('summit_area_error', one * results%map%area_difference)
      call table%put('summit_load_error', one * merge(results%map%load_difference, not_computed, &
                     results%map%load_difference < huge(1.0_real64)))
      call table%put('summit_stiffness_error', one * results%map%stiffness_difference)
    end if
    call table%put('warnings', [(kinds_of_warnings(positions(m)), m=1, size(positions))])
    call fill_estimates(table, results, [(m, m=1, size(positions))])
    call table%end_block(size(positions))
  end subroutine fill_positions

  ! Estimates of positions: the influence of each effect that is off, the error.
  subroutine fill_estimates(table, results, at)
    type(growing_table), intent(inout) :: table
    type(scene_results), intent(in) :: results
    integer, intent(in) :: at(:)  ! numbers of the positions
    integer :: e

    associate (positions => results%positions)
      do e = 1, size(known_effects)
        if (positions(1)%left_out(e) > not_computed) &
          call table%put(trim(known_effects(e)%name) // '_estimate', positions(at)%left_out(e))
      end do
      call table%put('error_estimate', positions(at)%error_estimate)
    end associate
  end subroutine fill_estimates

  ! Records of an effect: how it was simulated (off: left out), the share of the vertical load that
  ! was estimated and that measured, and how its solve ended.
  subroutine fill_effect(table, name, positions, i)
    type(growing_table), intent(inout) :: table
    character(len=*), intent(in) :: name
    type(position_result), intent(in) :: positions(:)
    integer, intent(in) :: i
    type(effect_record) :: effects(size(positions))
    logical :: has_ended(size(positions))
    integer :: m

    effects = [(positions(m)%effects(i), m=1, size(positions))]
    has_ended = effects%simulated /= 'off' .and. effects%ending%residual > not_computed
    call table%put(name, [character(len=word_length) :: effects%simulated])
    call table%put(name // '_estimate', effects%estimate)
    call table%put(name // '_influence', effects%influence)
    call table%put(name // '_residual', merge(effects%ending%residual, not_computed, has_ended))
    call table%put(name // '_iterations', merge(real(effects%ending%iterations, real64), &
                                                not_computed, has_ended), is_count=.true.)
  end subroutine fill_effect

  ! States of a position: the totals on the way to the end.
  subroutine fill_states(table, results, m, states)
    type(growing_table), intent(inout) :: table
    type(scene_results), intent(in) :: results
    integer, intent(in) :: m
    type(state_row), intent(in) :: states(:)
    integer :: i

    call table%put('position', spread(m, 1, size(states)))
    call table%put('step', [(i, i=1, size(states))])
    call table%put('separation', states%approach, is_length)
    call table%put('compression', states%compression, is_length)
    call table%put('contacts', states%contacts)
    call table%put('load', states%load, is_force)
    call table%put('area', states%area, is_area)
    call table%put('projected_area', states%projected_area, is_area)
    call table%put('vertical_load', states%vertical_load, is_force)
    call table%put('time', states%time)
    if (allocated(results%effects)) then
      if (any(results%effects%names == 'plasticity')) &
        call table%put('dissipated_work', states%dissipated_work, is_moment)
      if (any(results%effects%state_columns == 'plastic_area')) &
        call table%put('plastic_area', states%plastic_area, is_area)
    end if
    call fill_nominal(table, results, states)
    call fill_gap(table, results, states)
    call fill_estimates(table, results, spread(m, 1, size(states)))
    call table%end_block(size(states))
  end subroutine fill_states

  ! States over the nominal area, where one is given.
  subroutine fill_nominal(table, results, states)
    type(growing_table), intent(inout) :: table
    type(scene_results), intent(in) :: results
    type(state_row), intent(in) :: states(:)

    if (.not. results%nominal_area > 0.0_real64) return
    call table%put('nominal_pressure', states%vertical_load / results%nominal_area, is_pressure)
    call table%put('area_fraction', states%projected_area / results%nominal_area)
  end subroutine fill_nominal

  ! Gap, rims and energy of states of a height map.
  subroutine fill_gap(table, results, states)
    type(growing_table), intent(inout) :: table
    type(scene_results), intent(in) :: results
    type(state_row), intent(in) :: states(:)

    if (.not. has_height_map(results)) return
    call table%put('mean_gap', states%mean_gap, is_length)
    call table%put('rms_gap', states%rms_gap, is_length)
    call table%put('contact_perimeter', states%contact_perimeter, is_length)
    call table%put('elastic_energy', states%elastic_energy, is_moment)
  end subroutine fill_gap

  ! The contacts of one state.
  subroutine fill_contacts(table, results, m, step, rows)
    type(growing_table), intent(inout) :: table
    type(scene_results), intent(in) :: results
    integer, intent(in) :: m, step
    type(contact_row), intent(in) :: rows(:)
    real(real64), dimension(size(rows)) :: one, values
    integer :: i

    one = 1.0_real64
    associate (position => results%positions(m), state => results%positions(m)%states(step))
      call table%put('position', spread(m, 1, size(rows)))
      call table%put('x_displacement', one * position%x_displacement, is_length)
      call table%put('y_displacement', one * position%y_displacement, is_length)
      call table%put('step', spread(step, 1, size(rows)))
      call table%put('separation', one * state%approach, is_length)
      call table%put('area_no', rows%area_no)
      call table%put('x', rows%x, is_length)
      call table%put('y', rows%y, is_length)
      call table%put('upper', rows%upper)
      call table%put('lower', rows%lower)
      call table%put('area', rows%area, is_area)
      call table%put('projected_area', rows%projected_area, is_area)
      call table%put('slope', rows%slope)
      call table%put('load', rows%load, is_force)
      call table%put('average_pressure', rows%average_pressure, is_pressure)
      call table%put('maximum_pressure', rows%maximum_pressure, is_pressure)
      call table%put('limit_exceeded', merge(1, 0, rows%limit_exceeded))
      call table%put('vertical_load', rows%vertical_load, is_force)
      call table%put('compression', one * state%compression, is_length)
      call table%put('penetration', rows%penetration, is_length)
      call table%put('overlap', rows%overlap, is_length)
      if (allocated(results%effects)) then
        do i = 1, size(results%effects%contact_columns)
          if (size(rows) > 0) values = position%contact_values(state%first_row:state%last_row, i)
          call table%put(trim(results%effects%contact_columns(i)), values, &
                         powers_of(results%effects%contact_powers(:, i)))
        end do
      end if
      do i = 1, size(rows)
        values(i) = contact_radius(rows(i))
      end do
      call table%put('contact_radius', values, is_length)
    end associate
    call table%end_block(size(rows))
  end subroutine fill_contacts

  ! Numbers of a block, NaN where one was not computed. In the first block they add a column.
  subroutine put_reals(self, name, values, dimension, is_count)
    class(growing_table), intent(inout) :: self
    character(len=*), intent(in) :: name
    real(real64), intent(in) :: values(:)
    type(unit_powers), intent(in), optional :: dimension  ! absent: a plain number
    logical, intent(in), optional :: is_count             ! present: they are whole numbers

    self%at = self%at + 1
    if (.not. self%is_named) &
      call add_reals(self, name, spread(0.0_real64, 1, self%rows), is_count=is_count)
    if (present(dimension)) self%columns(self%at)%dimension = dimension
    associate (cells => self%columns(self%at)%reals(self%before + 1:self%before + size(values)))
      cells = values
      where (.not. cells > not_computed) cells = ieee_value(1.0_real64, ieee_quiet_nan)
    end associate
  end subroutine put_reals

  subroutine put_wholes(self, name, values)
    class(growing_table), intent(inout) :: self
    character(len=*), intent(in) :: name
    integer, intent(in) :: values(:)

    self%at = self%at + 1
    if (.not. self%is_named) call add_wholes(self, name, spread(0_int32, 1, self%rows))
    self%columns(self%at)%wholes(self%before + 1:self%before + size(values)) = int(values, int32)
  end subroutine put_wholes

  subroutine put_words(self, name, values)
    class(growing_table), intent(inout) :: self
    character(len=*), intent(in) :: name
    character(len=word_length), intent(in) :: values(:)

    self%at = self%at + 1
    if (.not. self%is_named) &
      call add_words(self, name, spread(repeat(' ', word_length), 1, self%rows))
    self%columns(self%at)%letters(:, self%before + 1:self%before + size(values)) = &
      reshape(transfer(values, ['a']), [word_length, size(values)])
  end subroutine put_words

  subroutine end_block(self, rows)
    class(growing_table), intent(inout) :: self
    integer, intent(in) :: rows  ! rows of the block

    self%is_named = .true.
    self%before = self%before + rows
    self%at = 0
  end subroutine end_block

  !> The place of a column in its table; 0: there is none.
  pure integer function place_of(table, name)
    type(array_table), intent(in) :: table  !! table with columns
    character(len=*), intent(in) :: name    !! of a column

    do place_of = size(table%columns), 1, -1
      if (table%columns(place_of)%name == name) return
    end do
  end function place_of

  !> The numbers of a column; NaN where a cell is empty.
  pure function numbers_of(table, name) result(numbers)
    type(array_table), intent(in) :: table       !! table that has the column
    character(len=*), intent(in) :: name         !! of a column of numbers
    real(real64), allocatable :: numbers(:)

    associate (column => table%columns(place_of(table, name)))
      if (allocated(column%reals)) numbers = column%reals
      if (allocated(column%wholes)) numbers = column%wholes
    end associate
  end function numbers_of

  !> Appends a cell as files have it: a number with 17 digits, a whole number, a word.
  pure subroutine put_cell(column, row, empty, buffer)
    type(array_column), intent(in) :: column    !! column of a table
    integer, intent(in) :: row                  !! row of the cell, from 1
    character(len=*), intent(in) :: empty       !! text of an empty cell
    type(text_buffer), intent(inout) :: buffer  !! gets the cell, without blanks around it
    character(len=25) :: cell

    cell = empty
    if (allocated(column%wholes)) then
      write (cell, '(i0)') column%wholes(row)
    else if (allocated(column%letters)) then
      call buffer%append(trim(transfer(column%letters(:, row), &
                                       repeat('a', size(column%letters, 1)))))
      return
    else if (.not. ieee_is_nan(column%reals(row))) then
      if (column%is_count) write (cell, '(i0)') nint(column%reals(row))
      if (.not. column%is_count) write (cell, '(es25.16e3)') column%reals(row)
    end if
    call buffer%append(trim(adjustl(cell)))
  end subroutine put_cell

  !> Names the units of all columns of a table of a run.
  subroutine name_units(scene_in, arrays)
    type(scene), intent(in) :: scene_in            !! what was solved
    type(array_table), intent(inout) :: arrays     !! table by `make_arrays`
    integer :: i

    do i = 1, size(arrays%columns)
      arrays%columns(i)%unit = unit_of(scene_in, arrays%columns(i)%dimension)
    end do
  end subroutine name_units

  !> Adds a column of doubles to a table; one that was not computed is an empty cell.
  subroutine add_reals(table, name, values, unit, is_count)
    class(array_table), intent(inout) :: table  !! without columns, or with some as long
    character(len=*), intent(in) :: name       !! of the column
    real(real64), intent(in) :: values(:)      !! cells of the column
    character(len=*), intent(in), optional :: unit  !! its unit; absent: not known
    logical, intent(in), optional :: is_count       !! present: they are whole numbers

    call add_column(table, name)
    table%rows = size(values)
    associate (new => table%columns(size(table%columns)))
      new%reals = values
      where (.not. values > not_computed) new%reals = ieee_value(1.0_real64, ieee_quiet_nan)
      new%is_count = present(is_count)
      if (present(unit)) new%unit = trim(unit)
    end associate
  end subroutine add_reals

  !> Adds the columns of a surface: summits of a map, or asperities.
  subroutine add_surface(x, y, height, radius, table, unit)
    real(real64), intent(in) :: x(:), y(:)             !! positions in plan
    real(real64), intent(in) :: height(:), radius(:)   !! heights and radii, as many
    type(array_table), intent(inout) :: table          !! table without columns
    character(len=*), intent(in) :: unit               !! unit of length; empty: unknown

    call add_reals(table, 'x', x, unit)
    call add_reals(table, 'y', y, unit)
    call add_reals(table, 'height', height, unit)
    call add_reals(table, 'radius', radius, unit)
  end subroutine add_surface

  !> Adds a column of whole numbers to a table.
  subroutine add_wholes(table, name, values)
    class(array_table), intent(inout) :: table  !! without columns, or with some as long
    character(len=*), intent(in) :: name       !! of the column
    integer(int32), intent(in) :: values(:)    !! cells of the column

    call add_column(table, name)
    table%rows = size(values)
    table%columns(size(table%columns))%wholes = values
  end subroutine add_wholes

  !> Adds a column of words to a table.
  subroutine add_words(table, name, words)
    class(array_table), intent(inout) :: table  !! without columns, or with some as long
    character(len=*), intent(in) :: name       !! of the column
    character(len=*), intent(in) :: words(:)   !! cells of the column

    call add_column(table, name)
    table%rows = size(words)
    table%columns(size(table%columns))%letters = &
      reshape(transfer(words, ['a']), [len(words), size(words)])
  end subroutine add_words

  ! Adds a column without cells.
  subroutine add_column(table, name)
    class(array_table), intent(inout) :: table
    character(len=*), intent(in) :: name
    type(array_column), allocatable :: more(:)
    integer :: i

    if (.not. allocated(table%columns)) allocate (table%columns(0))
    allocate (more(size(table%columns) + 1))
    do i = 1, size(table%columns)
      more(i)%dimension = table%columns(i)%dimension
      more(i)%is_count = table%columns(i)%is_count
      call move_alloc(table%columns(i)%name, more(i)%name)
      call move_alloc(table%columns(i)%unit, more(i)%unit)
      call move_alloc(table%columns(i)%reals, more(i)%reals)
      call move_alloc(table%columns(i)%wholes, more(i)%wholes)
      call move_alloc(table%columns(i)%letters, more(i)%letters)
    end do
    more(size(more))%name = name
    call move_alloc(more, table%columns)
  end subroutine add_column

end module asperity_result_table
