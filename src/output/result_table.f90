!> The results of a run as tables of columns: what every column is called, its unit and what it
!> holds stand here, once for all files, for the summary and for other languages.
!>
!> Tables: a row a position (its last state), a row a state, a row a contact.
module asperity_result_table
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_c_binding, only: c_null_char, c_size_t
  use asperity_contact_records, only: contact_radius, contact_row, effect_record, state_row
  use asperity_effect_names, only: known_effects
  use asperity_kinds, only: int32, int64, not_computed, real64
  use asperity_library_turn, only: library_turn
  use asperity_process, only: check_memory
  use asperity_scene_results, only: has_height_map, kinds_of_warnings, last_state, scene_results
  use asperity_scene_values, only: scene
  use asperity_system_calls, only: c_strfromd
  use asperity_text_buffer, only: text_buffer
  use asperity_unit_names, only: is_area, is_force, is_length, is_moment, is_pressure, &
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
    integer(int64) :: rows = 0_int64              !! length of every column
    type(array_column), allocatable :: columns(:) !! not allocated: there is no such table
  end type array_table

contains

  !> One of the tables of a run. `failure` is allocated when there is no memory for it. Contacts
  !> that were not kept have no rows.
  subroutine make_arrays(which, results, arrays, failure)
    integer, intent(in) :: which                           !! table, one of the `of_` numbers
    type(scene_results), intent(in) :: results             !! results of a run
    type(array_table), intent(out) :: arrays               !! table of columns
    character(len=:), allocatable, intent(out) :: failure  !! reason of a failure
    type(state_row), allocatable :: states(:)
    integer, allocatable :: position(:), step(:)  ! numbers of each state
    integer :: columns, i, m

    if (.not. results%are_solved) then
      failure = 'no results: the scene is not solved'
      return
    end if
    columns = most_own
    if (allocated(results%effects)) &
      columns = columns + columns_of_effect * size(results%effects%names) + &
                size(results%effects%state_columns) + size(results%effects%contact_columns)
    associate (positions => results%positions)
      arrays%rows = size(positions)
      if (which == of_states) arrays%rows = sum([(size(positions(m)%states), m=1, size(positions))])
      if (which == of_contacts) arrays%rows = &
        sum([(sum(positions(m)%states%last_row - positions(m)%states%first_row + 1), &
              m=1, size(positions))])
      ! The columns, and the records that they are taken from.
      call check_memory('the ' // trim(table_names(which)) // ' as arrays', failure, &
                        bytes=16_int64 * columns * arrays%rows)
      if (allocated(failure) .and. which == of_contacts) &
        failure = failure // ', expected fewer, or none kept'
      if (allocated(failure)) return
      if (which == of_positions) then
        states = [(last_state(positions(m)), m=1, size(positions))]
        position = [(m, m=1, size(positions))]
        call add_positions(results, states, position, arrays)
        return
      end if
      states = [(positions(m)%states, m=1, size(positions))]
      position = [(spread(m, 1, size(positions(m)%states)), m=1, size(positions))]
      step = [((i, i=1, size(positions(m)%states)), m=1, size(positions))]
    end associate
    if (which == of_states) call add_states(results, states, position, step, arrays)
    if (which == of_contacts) call add_contacts(results, states, position, step, arrays)
  end subroutine make_arrays

  ! Positions: the last state of each, and what the effects did.
  subroutine add_positions(results, last, position, table)
    type(scene_results), intent(in) :: results
    type(state_row), intent(in) :: last(:)
    integer, intent(in) :: position(:)
    type(array_table), intent(inout) :: table
    type(unit_powers) :: dimension
    integer :: i, m

    associate (positions => results%positions)
      call add_wholes(table, 'position', position)
      call add_reals(table, 'x_displacement', positions%x_displacement, dimension=is_length)
      call add_reals(table, 'y_displacement', positions%y_displacement, dimension=is_length)
      call add_wholes(table, 'steps', [(size(positions(m)%states), m=1, size(positions))])
      call add_reals(table, 'separation', last%approach, dimension=is_length)
      call add_wholes(table, 'contacts', last%contacts)
      call add_reals(table, 'load', last%load, dimension=is_force)
      call add_reals(table, 'area', last%area, dimension=is_area)
      call add_reals(table, 'projected_area', last%projected_area, dimension=is_area)
      call add_wholes(table, 'limit_reached', merge(1, 0, positions%limit_reached))
      call add_reals(table, 'vertical_load', last%vertical_load, dimension=is_force)
      call add_reals(table, 'compression', last%compression, dimension=is_length)
      if (positions(1)%overlapping_circles >= 0) then
        call add_wholes(table, 'overlapping_circles', positions%overlapping_circles)
      else
        call add_reals(table, 'overlapping_circles', &
                       merge(real(positions%overlapping_circles, real64), not_computed, &
                             positions%overlapping_circles >= 0), is_count=.true.)
      end if
      call add_nominal(results, last, position, table)
      if (allocated(results%effects)) then
        do i = 1, size(results%effects%names)
          call add_effect(trim(results%effects%names(i)), &
                          [(positions(m)%effects(i), m=1, size(positions))], table)
        end do
        do i = 1, size(results%effects%state_columns)
          dimension = powers_of(results%effects%state_powers(:, i))
          if (results%effects%state_words(i) /= '') dimension%word = results%effects%state_words(i)
          call add_reals(table, trim(results%effects%state_columns(i)), &
                         [(positions(m)%state_values(i), m=1, size(positions))], &
                         dimension=dimension)
        end do
      end if
      call add_wholes(table, 'warnings', [(kinds_of_warnings(positions(m)), m=1, size(positions))])
    end associate
    call add_estimates(results, position, results%positions%error_estimate, table)
  end subroutine add_positions

  ! Records of an effect: how it was simulated (off: left out), the share of the vertical load that
  ! was estimated and that measured, and how its solve ended.
  subroutine add_effect(name, effects, table)
    character(len=*), intent(in) :: name
    type(effect_record), intent(in) :: effects(:)  ! by position
    type(array_table), intent(inout) :: table
    logical :: has_ended(size(effects))

    has_ended = effects%simulated /= 'off' .and. effects%ending%residual > not_computed
    call add_words(table, name, [character(len=word_length) :: effects%simulated])
    call add_reals(table, name // '_estimate', effects%estimate)
    call add_reals(table, name // '_influence', effects%influence)
    call add_reals(table, name // '_residual', &
                   merge(effects%ending%residual, not_computed, has_ended))
    call add_reals(table, name // '_iterations', merge(real(effects%ending%iterations, real64), &
                                                       not_computed, has_ended), is_count=.true.)
  end subroutine add_effect

  ! States of all positions: the totals on the way to the end.
  subroutine add_states(results, states, position, step, table)
    type(scene_results), intent(in) :: results
    type(state_row), intent(in) :: states(:)
    integer, intent(in) :: position(:), step(:)
    type(array_table), intent(inout) :: table

    call add_wholes(table, 'position', position)
    call add_wholes(table, 'step', step)
    call add_reals(table, 'separation', states%approach, dimension=is_length)
    call add_reals(table, 'compression', states%compression, dimension=is_length)
    call add_wholes(table, 'contacts', states%contacts)
    call add_reals(table, 'load', states%load, dimension=is_force)
    call add_reals(table, 'area', states%area, dimension=is_area)
    call add_reals(table, 'projected_area', states%projected_area, dimension=is_area)
    call add_reals(table, 'vertical_load', states%vertical_load, dimension=is_force)
    call add_reals(table, 'time', states%time)
    if (allocated(results%effects)) then
      if (any(results%effects%state_columns == 'dissipated_work')) &
        call add_reals(table, 'dissipated_work', states%dissipated_work, dimension=is_moment)
      if (any(results%effects%state_columns == 'plastic_area')) &
        call add_reals(table, 'plastic_area', states%plastic_area, dimension=is_area)
    end if
    call add_nominal(results, states, position, table)
    if (has_height_map(results)) &
      call add_reals(table, 'greatest_pressure', states%greatest_pressure, dimension=is_pressure)
    call add_estimates(results, position, states%error_estimate, table)
    if (.not. allocated(results%effects)) return
    if (any(results%effects%state_columns == 'area_error_estimate')) &
      call add_reals(table, 'area_error_estimate', states%area_error)
    if (.not. has_height_map(results)) return
    call add_reals(table, 'gap_error_estimate', states%gap_error)
    call add_reals(table, 'pressure_error_estimate', states%pressure_error)
    call add_reals(table, 'separation_error_estimate', states%separation_error)
  end subroutine add_states

  ! States over the nominal area, where one is given; gap, rims and energy of a height map.
  subroutine add_nominal(results, states, position, table)
    type(scene_results), intent(in) :: results
    type(state_row), intent(in) :: states(:)
    integer, intent(in) :: position(:)
    type(array_table), intent(inout) :: table
    real(real64) :: nominal_area(size(states))

    nominal_area = results%positions(position)%nominal_area
    if (results%nominal_area > 0.0_real64) nominal_area = results%nominal_area
    if (all(nominal_area > 0.0_real64)) then
      call add_reals(table, 'nominal_pressure', states%vertical_load / nominal_area, &
                     dimension=is_pressure)
      call add_reals(table, 'area_fraction', states%projected_area / nominal_area)
    end if
    if (has_height_map(results)) then
      call add_reals(table, 'mean_gap', states%mean_gap, dimension=is_length)
      call add_reals(table, 'rms_gap', states%rms_gap, dimension=is_length)
      call add_reals(table, 'contact_perimeter', states%contact_perimeter, dimension=is_length)
      call add_reals(table, 'elastic_energy', states%elastic_energy, dimension=is_moment)
    end if
  end subroutine add_nominal

  ! Estimates: the influence of each effect that is off, by position, and the errors of the rows.
  subroutine add_estimates(results, position, errors, table)
    type(scene_results), intent(in) :: results
    integer, intent(in) :: position(:)
    real(real64), intent(in) :: errors(:)
    type(array_table), intent(inout) :: table
    integer :: e

    associate (positions => results%positions)
      do e = 1, size(known_effects)
        if (positions(1)%left_out(e) > not_computed) call add_reals(table, &
          trim(known_effects(e)%name) // '_estimate', positions(position)%left_out(e))
      end do
      call add_reals(table, 'error_estimate', errors)
    end associate
  end subroutine add_estimates

  ! The contacts of all states.
  subroutine add_contacts(results, states, position, step, table)
    type(scene_results), intent(in) :: results
    type(state_row), intent(in) :: states(:)
    integer, intent(in) :: position(:), step(:)
    type(array_table), intent(inout) :: table
    type(contact_row), allocatable :: rows(:)
    real(real64), allocatable :: values(:, :)
    integer, allocatable :: at(:)  ! state of each row
    integer :: effects, i, k, next

    effects = 0
    if (allocated(results%effects)) effects = size(results%effects%contact_columns)
    allocate (at(table%rows), rows(table%rows), values(table%rows, effects))
    next = 0
    do k = 1, size(states)
      associate (place => results%positions(position(k)), first => states(k)%first_row, &
                 last => states(k)%last_row)
        if (last < first) cycle
        at(next + 1:next + last - first + 1) = k
        rows(next + 1:next + last - first + 1) = place%rows(first:last)
        if (effects > 0) values(next + 1:next + last - first + 1, :) = &
          place%contact_values(first:last, :effects)
        next = next + last - first + 1
      end associate
    end do
    call add_wholes(table, 'position', position(at))
    associate (positions => results%positions)
      call add_reals(table, 'x_displacement', positions(position(at))%x_displacement, &
                     dimension=is_length)
      call add_reals(table, 'y_displacement', positions(position(at))%y_displacement, &
                     dimension=is_length)
    end associate
    call add_wholes(table, 'step', step(at))
    call add_reals(table, 'separation', states(at)%approach, dimension=is_length)
    call add_wholes(table, 'area_no', rows%area_no)
    call add_reals(table, 'x', rows%x, dimension=is_length)
    call add_reals(table, 'y', rows%y, dimension=is_length)
    call add_wholes(table, 'upper', rows%upper)
    call add_wholes(table, 'lower', rows%lower)
    call add_reals(table, 'area', rows%area, dimension=is_area)
    call add_reals(table, 'projected_area', rows%projected_area, dimension=is_area)
    call add_reals(table, 'slope', rows%slope)
    call add_reals(table, 'load', rows%load, dimension=is_force)
    call add_reals(table, 'average_pressure', rows%average_pressure, dimension=is_pressure)
    call add_reals(table, 'maximum_pressure', rows%maximum_pressure, dimension=is_pressure)
    call add_wholes(table, 'limit_exceeded', merge(1, 0, rows%limit_exceeded))
    call add_reals(table, 'vertical_load', rows%vertical_load, dimension=is_force)
    call add_reals(table, 'compression', states(at)%compression, dimension=is_length)
    call add_reals(table, 'penetration', rows%penetration, dimension=is_length)
    call add_reals(table, 'overlap', rows%overlap, dimension=is_length)
    do i = 1, effects
      call add_reals(table, trim(results%effects%contact_columns(i)), values(:, i), &
                     dimension=powers_of(results%effects%contact_powers(:, i)))
    end do
    call add_reals(table, 'contact_radius', [(contact_radius(rows(k)), k=1, size(rows))], &
                   dimension=is_length)
  end subroutine add_contacts

  !> The place of a column in its table; 0: there is none.
  pure integer function place_of(table, name)
    type(array_table), intent(in) :: table  !! table with columns
    character(len=*), intent(in) :: name    !! of a column

    place_of = 0
    if (.not. allocated(table%columns)) return
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
  subroutine put_cell(column, row, empty, buffer)
    type(array_column), intent(in) :: column    !! column of a table
    integer(int64), intent(in) :: row           !! row of the cell, from 1
    character(len=*), intent(in) :: empty       !! text of an empty cell
    type(text_buffer), intent(inout) :: buffer  !! gets the cell, without blanks around it
    character(len=25) :: cell
    integer :: last

    cell = empty
    if (allocated(column%wholes)) then
      write (cell, '(i0)') column%wholes(row)
    else if (allocated(column%letters)) then
      call buffer%append(trim(transfer(column%letters(:, row), &
                                       repeat('a', size(column%letters, 1)))))
      return
    else if (.not. ieee_is_nan(column%reals(row))) then
      if (column%is_count) write (cell, '(i0)') nint(column%reals(row), int64)
      if (.not. column%is_count) then
        last = c_strfromd(cell, len(cell, c_size_t), '%.16E' // c_null_char, column%reals(row))
        ! Exponents have three digits, as those of Fortran's formats.
        if (scan(cell(last - 2:last - 2), '+-') > 0) then
          cell(last - 1:) = '0' // cell(last - 1:last)
          last = last + 1
        end if
        cell(last + 1:) = ''
      end if
    end if
    call buffer%append(trim(adjustl(cell)))
  end subroutine put_cell

  !> Names the units of all columns of a table of a run.
  subroutine name_units(scene_in, arrays)
    type(scene), intent(in) :: scene_in            !! what was solved
    type(array_table), intent(inout) :: arrays     !! table by `make_arrays`
    integer :: i
    type(library_turn) :: turn

    call turn%begin()
    do i = 1, size(arrays%columns)
      arrays%columns(i)%unit = unit_of(scene_in, arrays%columns(i)%dimension)
    end do
  end subroutine name_units

  !> Adds a column of doubles to a table; one that was not computed is an empty cell.
  subroutine add_reals(table, name, values, unit, is_count, dimension)
    type(array_table), intent(inout) :: table  !! without columns, or with some as long
    character(len=*), intent(in) :: name       !! of the column
    real(real64), intent(in) :: values(:)      !! cells of the column
    character(len=*), intent(in), optional :: unit  !! its unit; absent: not known
    logical, intent(in), optional :: is_count       !! present: they are whole numbers
    type(unit_powers), intent(in), optional :: dimension  !! powers in its unit; absent: a number

    call add_column(table, name)
    table%rows = size(values, kind=int64)
    associate (new => table%columns(size(table%columns)))
      new%reals = values + 0.0_real64  ! no sign of 0
      where (.not. values > not_computed) new%reals = ieee_value(1.0_real64, ieee_quiet_nan)
      new%is_count = present(is_count)
      if (present(unit)) new%unit = trim(unit)
      if (present(dimension)) new%dimension = dimension
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
    type(array_table), intent(inout) :: table  !! without columns, or with some as long
    character(len=*), intent(in) :: name       !! of the column
    integer(int32), intent(in) :: values(:)    !! cells of the column

    call add_column(table, name)
    table%rows = size(values, kind=int64)
    table%columns(size(table%columns))%wholes = values
  end subroutine add_wholes

  !> Adds a column of words to a table.
  subroutine add_words(table, name, words)
    type(array_table), intent(inout) :: table  !! without columns, or with some as long
    character(len=*), intent(in) :: name       !! of the column
    character(len=*), intent(in) :: words(:)   !! cells of the column

    call add_column(table, name)
    table%rows = size(words, kind=int64)
    table%columns(size(table%columns))%letters = &
      reshape(transfer(words, ['a']), [len(words, int64), size(words, kind=int64)])
  end subroutine add_words

  ! Adds a column without cells.
  subroutine add_column(table, name)
    type(array_table), intent(inout) :: table
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
