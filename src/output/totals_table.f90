!> Totals of a run, one line a quantity: its value at a single position; largest, smallest and mean
!> value over several.
module asperity_totals_table
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use asperity_contact_field, only: parts_in_words
  use asperity_contact_records, only: state_row
  use asperity_effects_summary, only: load_is_met
  use asperity_kinds, only: not_computed, real64
  use asperity_number_format, only: number_text
  use asperity_result_table, only: add_reals, array_table, make_arrays, numbers_of, of_positions, &
                                   place_of
  use asperity_scene_results, only: last_state, scene_results
  use asperity_scene_values, only: scene
  use asperity_text_buffer, only: text_buffer
  use asperity_unit_names, only: is_length, is_pressure, unit_of, with_unit
  implicit none
  private

  public :: write_totals

  ! One quantity over all positions.
  type :: total_line
    character(len=40) :: name = ''            !! of the quantity, with its unit where that is known
    character(len=40) :: remark = ''       !! its reference; blank: the name is enough
    integer :: known = 0                      !! how many of `numbers` are used, 1 or 3
    real(real64) :: numbers(3) = 0.0_real64   !! the value; of several: largest, smallest, mean
  end type total_line

  ! A column of the positions in the summary: its name in words and its reference. A column that is
  ! not here is in the files alone.
  type :: column_words
    character(len=24) :: column
    character(len=24) :: words
    character(len=40) :: remark
  end type column_words

  ! Totals of every run, in the order of the summary; then those of effects, which have a line where
  ! they are not 0 everywhere, in the order of their columns.
  type(column_words), parameter :: own_totals(*) = [ &
    column_words('load', 'total load', ''), &
    column_words('vertical_load', 'vertical load', ''), &
    column_words('area', 'contact area', ''), &
    column_words('projected_area', 'projected area', ''), &
    column_words('mean_pressure', 'mean pressure', ''), &
    column_words('greatest_pressure', 'greatest pressure', ''), &
    column_words('mean_gap', 'mean gap', 'over the measured pixels'), &
    column_words('separation', 'separation', 'of the reference planes'), &
    column_words('compression', 'compression', 'since first contact'), &
    column_words('contacts', 'contacts', ''), &
    column_words('nominal_pressure', 'nominal pressure', ''), &
    column_words('area_fraction', 'area fraction', ''), &
    column_words('load_relaxation', 'load relaxation', 'load lost during the hold, relative'), &
    column_words('creep_displacement', 'creep displacement', 'compression during the hold')], &
    effect_totals(*) = [ &
    column_words('hertz_load', 'Hertzian load', 'elastic, at the same penetrations'), &
    column_words('contacts_flowing', 'yielding contacts', ''), &
    column_words('dissipated_work', 'dissipated work', 'since first contact'), &
    column_words('plastic_area', 'area at the hardness', 'of whole pixels'), &
    column_words('residual_flattening', 'residual flattening', 'largest of a contact'), &
    column_words('adhering_contacts', 'adhering contacts', ''), &
    column_words('pulling_contacts', 'contacts in tension', ''), &
    column_words('pull_off_sum', 'pull-off forces', 'sum over the contacts'), &
    column_words('alone_load', 'non-interacting load', 'the same contacts, isolated'), &
    column_words('cells', 'grid elements', ''), &
    column_words('resolved', 'contacts on grids', ''), &
    column_words('elastic_load', 'elastic load', 'without relaxation'), &
    column_words('frictionless_load', 'frictionless load', ''), &
    column_words('sliding_contacts', 'sliding contacts', ''), &
    column_words('rig_force_x', 'fixture force x', 'on the upper body'), &
    column_words('rig_force_y', 'fixture force y', 'on the upper body'), &
    column_words('rig_moment_x', 'fixture moment x', 'on the upper body'), &
    column_words('rig_moment_y', 'fixture moment y', 'on the upper body'), &
    column_words('rig_moment_z', 'fixture moment z', 'on the upper body'), &
    column_words('tangential_load', 'tangential load', ''), &
    column_words('tangential_displacement', 'tangential displacement', ''), &
    column_words('tangential_stiffness', 'tangential stiffness', ''), &
    column_words('stick_area', 'area that sticks', ''), &
    column_words('slides', 'complete sliding', '1: the traction is mu p everywhere'), &
    column_words('electrical_conductance', 'electrical conductance', 'of the interface'), &
    column_words('thermal_conductance', 'thermal conductance', 'of the interface'), &
    column_words('samples_in_contact', 'pixels in contact', '')]

contains

  !> The totals as a table: those of the last states, losses during a hold, totals of the effects.
  subroutine write_totals(scene_in, results, buffer)
    type(scene), intent(in) :: scene_in         !! the scene, for its units
    type(scene_results), intent(in) :: results  !! results of a run
    type(text_buffer), intent(inout) :: buffer  !! gets the lines
    type(total_line), allocatable :: lines(:)
    character(len=*), parameter :: heads(3) = [character(len=8) :: 'largest', 'smallest', 'mean']
    character(len=120) :: line
    character(len=14) :: cell
    integer :: i, k, widest

    call list_totals(scene_in, results, lines)
    if (size(lines) == 0) return
    widest = maxval(len_trim(lines%name))
    if (size(results%positions) > 1) then
      line = ''
      write (line(widest + 1:), '(3a14)') (adjustr('      ' // heads(k)), k = 1, size(heads))
      call buffer%line(trim(line))
    end if
    do i = 1, size(lines)
      line = lines(i)%name
      do k = 1, lines(i)%known
        cell = number_text(lines(i)%numbers(k))
        line(widest + 14 * (k - 1) + 1:) = adjustr(cell)
      end do
      if (lines(i)%remark /= '') line = trim(line) // '   ' // lines(i)%remark
      call buffer%line(trim(line))
    end do
  end subroutine write_totals

  ! The totals as values. A quantity that was computed at no position has no line, and none has one
  ! without memory for the table of positions.
  subroutine list_totals(scene_in, results, lines)
    type(scene), intent(in) :: scene_in
    type(scene_results), intent(in) :: results
    type(total_line), allocatable, intent(out) :: lines(:)  ! in the order of the summary
    type(array_table) :: table
    character(len=:), allocatable :: failure
    integer :: i

    allocate (lines(0))
    call make_arrays(of_positions, results, table, failure)
    if (allocated(failure)) return
    call add_pressures(results, table)
    call add_holds(scene_in%effects%number('loading_time'), results, table)
    do i = 1, size(own_totals)
      call list_column(place_of(table, own_totals(i)%column), own_totals(i), .true.)
    end do
    do i = 1, size(table%columns)
      associate (row => findloc(effect_totals%column == table%columns(i)%name, .true., 1))
        if (row > 0) call list_column(i, effect_totals(row), .false.)
      end associate
    end do

  contains

    ! Adds the line of a column, where it has one.
    subroutine list_column(i, total, is_own)
      integer, intent(in) :: i  ! place of the column; 0: there is none
      type(column_words), intent(in) :: total
      logical, intent(in) :: is_own
      character(len=len(total%remark)) :: remark
      real(real64) :: numbers(table%rows), other(table%rows), mean
      type(total_line) :: new
      integer :: known

      if (i == 0) return
      numbers = numbers_of(table, table%columns(i)%name)
      known = count(.not. ieee_is_nan(numbers))
      numbers(:known) = pack(numbers, .not. ieee_is_nan(numbers))
      if (known == 0 .or. .not. (is_own .or. any(abs(numbers(:known)) > 0.0_real64))) return
      ! Without inclined contacts both loads, and both areas, are equal.
      if (total%column == 'vertical_load' .or. total%column == 'projected_area') then
        other = numbers_of(table, trim(merge('load', 'area', total%column == 'vertical_load')))
        if (all(abs(numbers - other) <= 1.0e-12_real64 * abs(other))) return
      end if
      remark = total%remark
      ! The gap of asperities is that on the grid of their fields.
      if (total%column == 'mean_gap' .and. allocated(results%positions(1)%fields)) then
        if (parts_in_words(results%positions(1)%fields(1)) /= '') &
          remark = 'over the grid of the fields'
      end if
      new%name = with_unit(trim(total%words), unit_of(scene_in, table%columns(i)%dimension))
      new%remark = remark
      if (table%rows == 1) then
        new%known = 1
        new%numbers = numbers(1)
      else
        new%known = 3
        ! A sum beyond the range of a double is not needed for the average.
        mean = sum(numbers(:known) / known)
        if (maxval(abs(numbers(:known))) <= huge(mean) / known) mean = sum(numbers(:known)) / known
        new%numbers = [maxval(numbers(:known)), minval(numbers(:known)), mean]
      end if
      lines = [lines, new]
    end subroutine list_column

  end subroutine list_totals

  ! Adds pressures that no file has: the greatest one, and the load over the area, which is at most
  ! the greatest: the corrected area of a patch of few pixels is less than that of its pixels.
  subroutine add_pressures(results, table)
    type(scene_results), intent(in) :: results
    type(array_table), intent(inout) :: table
    real(real64), dimension(table%rows) :: greatest, mean
    type(state_row) :: last
    integer :: m

    mean = not_computed
    greatest = not_computed
    do m = 1, size(results%positions)
      last = last_state(results%positions(m))
      if (last%area > 0.0_real64) mean(m) = last%load / last%area
      if (last%greatest_pressure > not_computed) then
        greatest(m) = last%greatest_pressure
        mean(m) = min(mean(m), greatest(m))
      end if
    end do
    call add_reals(table, 'mean_pressure', mean, dimension=is_pressure)
    call add_reals(table, 'greatest_pressure', greatest, dimension=is_pressure)
  end subroutine add_pressures

  ! Adds the change of the load, or of the separation, during a hold of all positions.
  subroutine add_holds(loading_time, results, table)
    real(real64), intent(in) :: loading_time
    type(scene_results), intent(in) :: results
    type(array_table), intent(inout) :: table
    real(real64) :: lost(size(results%positions)), sunk(size(results%positions))
    integer :: m

    do m = 1, size(results%positions)
      associate (states => results%positions(m)%states, last => last_state(results%positions(m)))
        if (.not. last%time > loading_time) return
        ! The state in which the hold begins.
        associate (begin => states(max(1, findloc(states%time > loading_time, .false., 1, &
                                                  back=.true.))))
          lost(m) = not_computed
          if (abs(begin%load) > 0.0_real64) lost(m) = 1.0_real64 - last%load / begin%load
          sunk(m) = begin%approach - last%approach
        end associate
      end associate
    end do
    if (any(abs(lost) > load_is_met)) call add_reals(table, 'load_relaxation', lost)
    if (any(abs(sunk) > 0.0_real64)) &
      call add_reals(table, 'creep_displacement', sunk, dimension=is_length)
  end subroutine add_holds

end module asperity_totals_table
