!> Totals of a run, one line a quantity: its value at a single position; largest, smallest and mean
!> value over several.
module asperity_totals_table
  use asperity_contact_field, only: parts_in_words
  use asperity_contact_records, only: position_result, state_row
  use asperity_kinds, only: not_computed, real64
  use asperity_number_format, only: number_text
  use asperity_scene_results, only: last_state, nominal_values, scene_results
  use asperity_scene_values, only: scene
  use asperity_text_buffer, only: text_buffer
  use asperity_unit_names, only: is_area, is_force, is_length, is_moment, is_number, is_pressure, &
                                 is_stiffness, unit_of, unit_powers, with_unit
  implicit none
  private

  public :: load_is_met, total_line, list_totals, write_totals

  !> A prescribed load is met to this relative error.
  real(real64), parameter :: load_is_met = 1.0e-6_real64

  !> One quantity over all positions.
  type :: total_line
    character(len=40) :: name = ''            !! of the quantity, with its unit where that is known
    character(len=40) :: remark = ''       !! its reference; blank: the name is enough
    integer :: known = 0                      !! how many of `numbers` are used, 1 or 3
    real(real64) :: numbers(3) = 0.0_real64   !! the value; of several: largest, smallest, mean
  end type total_line

  ! Columns of the effects in the summary: name of the column, name in words, dimension, reference.
  ! A column that is not here is in the files alone.
  type :: effect_total
    character(len=24) :: column
    character(len=24) :: name
    type(unit_powers) :: dimension
    character(len=40) :: remark
  end type effect_total

  type(effect_total), parameter :: effect_totals(*) = [ &
    effect_total('hertz_load', 'Hertzian load', is_force, 'elastic, at the same penetrations'), &
    effect_total('contacts_flowing', 'yielding contacts', is_number, ''), &
    effect_total('dissipated_work', 'dissipated work', is_moment, 'since first contact'), &
    effect_total('plastic_area', 'area at the hardness', is_area, 'of whole pixels'), &
    effect_total('residual_flattening', 'residual flattening', is_length, 'largest of a contact'), &
    effect_total('adhering_contacts', 'adhering contacts', is_number, ''), &
    effect_total('pulling_contacts', 'contacts in tension', is_number, ''), &
    effect_total('pull_off_sum', 'pull-off forces', is_force, 'sum over the contacts'), &
    effect_total('alone_load', 'non-interacting load', is_force, 'the same contacts, isolated'), &
    effect_total('cells', 'grid elements', is_number, ''), &
    effect_total('resolved', 'contacts on grids', is_number, ''), &
    effect_total('elastic_load', 'elastic load', is_force, 'without relaxation'), &
    effect_total('frictionless_load', 'frictionless load', is_force, ''), &
    effect_total('sliding_contacts', 'sliding contacts', is_number, ''), &
    effect_total('rig_force_x', 'fixture force x', is_force, 'on the upper body'), &
    effect_total('rig_force_y', 'fixture force y', is_force, 'on the upper body'), &
    effect_total('rig_moment_x', 'fixture moment x', is_moment, 'on the upper body'), &
    effect_total('rig_moment_y', 'fixture moment y', is_moment, 'on the upper body'), &
    effect_total('rig_moment_z', 'fixture moment z', is_moment, 'on the upper body'), &
    effect_total('tangential_load', 'tangential load', is_force, ''), &
    effect_total('tangential_displacement', 'tangential displacement', is_length, ''), &
    effect_total('tangential_stiffness', 'tangential stiffness', is_stiffness, ''), &
    effect_total('stick_area', 'area that sticks', is_area, ''), &
    effect_total('slides', 'complete sliding', is_number, '1: the traction is mu p everywhere'), &
    effect_total('samples_in_contact', 'pixels in contact', is_number, '')]

contains

  !> Totals of the last states, losses during a hold, totals of the effects.
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

  !> The same as values. A quantity that was computed at no position has no line.
  subroutine list_totals(scene_in, results, lines)
    type(scene), intent(in) :: scene_in                       !! the scene, for its units
    type(scene_results), intent(in) :: results                !! results of a run
    type(total_line), allocatable, intent(out) :: lines(:)    !! in the order of the summary
    character(len=*), parameter :: names(12) = [character(len=18) :: &
      'total load', 'vertical load', 'contact area', 'projected area', 'mean pressure', &
      'greatest pressure', 'mean gap', 'separation', 'compression', 'contacts', &
      'nominal pressure', 'area fraction']
    character(len=*), parameter :: remarks(12) = [character(len=28) :: '', '', '', '', '', '', &
      'over the measured pixels', 'of the reference planes', 'since first contact', '', '', '']
    type(unit_powers), parameter :: dimensions(12) = [is_force, is_force, is_area, is_area, &
      is_pressure, is_pressure, is_length, is_length, is_length, is_number, is_pressure, is_number]
    real(real64), allocatable :: values(:, :)
    type(state_row) :: last
    integer :: i, m, number

    number = size(results%positions)
    allocate (values(number, size(names) - merge(0, 2, results%nominal_area > 0.0_real64)))
    do m = 1, number
      last = last_state(results%positions(m))
      values(m, :) = [last%load, last%vertical_load, last%area, last%projected_area, &
                      not_computed, last%greatest_pressure, last%mean_gap, last%approach, &
                      last%closing, real(last%contacts, real64), nominal_values(results, last)]
      if (last%area > 0.0_real64) values(m, 5) = last%load / last%area
    end do
    allocate (lines(0))
    do i = 1, size(values, 2)
      ! Without inclined contacts both loads, and both areas, are equal.
      if (i == 2 .or. i == 4) then
        if (all(abs(values(:, i) - values(:, i - 1)) <= &
                1.0e-12_real64 * abs(values(:, i - 1)))) cycle
      end if
      call add_line(with_unit(trim(names(i)), unit_of(scene_in, dimensions(i))), values(:, i), &
                    remark_of(i), lines)
    end do
    call list_held(scene_in, results, lines)
    call list_effect_totals(scene_in, results, lines)

  contains

    ! The gap of asperities is that on the grid of their fields.
    pure function remark_of(i) result(text)
      integer, intent(in) :: i
      character(len=len(remarks)) :: text

      text = remarks(i)
      if (i /= 7 .or. .not. allocated(results%positions(1)%fields)) return
      if (parts_in_words(results%positions(1)%fields(1)) /= '') text = 'over the grid of the fields'
    end function remark_of

  end subroutine list_totals

  ! Change of the load, or of the separation, during a hold.
  subroutine list_held(scene_in, results, lines)
    type(scene), intent(in) :: scene_in
    type(scene_results), intent(in) :: results
    type(total_line), allocatable, intent(inout) :: lines(:)
    real(real64) :: lost(size(results%positions)), sunk(size(results%positions))
    type(state_row) :: begin, last
    integer :: m

    do m = 1, size(results%positions)
      last = last_state(results%positions(m))
      if (.not. last%time > 0.0_real64) return
      begin = begin_of_hold(results%positions(m))
      lost(m) = not_computed
      if (abs(begin%load) > 0.0_real64) lost(m) = 1.0_real64 - last%load / begin%load
      sunk(m) = begin%approach - last%approach
    end do
    if (any(abs(lost) > load_is_met)) &
      call add_line('load relaxation', lost, 'load lost during the hold, relative', lines)
    if (any(abs(sunk) > 0.0_real64)) &
      call add_line(with_unit('creep displacement', unit_of(scene_in, is_length)), sunk, &
                    'compression during the hold', lines)
  end subroutine list_held

  ! The state in which the last hold begins.
  pure type(state_row) function begin_of_hold(position)
    type(position_result), intent(in) :: position
    integer :: i

    i = size(position%states)
    do while (i > 1 .and. position%states(i)%time > 0.0_real64)
      i = i - 1
    end do
    begin_of_hold = position%states(i)
  end function begin_of_hold

  ! Totals of the effects that are not 0 everywhere.
  subroutine list_effect_totals(scene_in, results, lines)
    type(scene), intent(in) :: scene_in
    type(scene_results), intent(in) :: results
    type(total_line), allocatable, intent(inout) :: lines(:)
    real(real64) :: values(size(results%positions))
    type(effect_total) :: total
    integer :: k, m, row

    if (.not. allocated(results%effects)) return
    do k = 1, size(results%effects%state_columns)
      row = findloc(effect_totals%column, results%effects%state_columns(k), 1)
      if (row == 0) cycle
      do m = 1, size(results%positions)
        values(m) = results%positions(m)%state_values(k)
      end do
      if (all(.not. (abs(values) > 0.0_real64 .and. values > not_computed))) cycle
      total = effect_totals(row)
      call add_line(with_unit(trim(total%name), unit_of(scene_in, total%dimension)), values, &
                    total%remark, lines)
    end do
  end subroutine list_effect_totals

  ! Adds a quantity; values that were not computed are left out.
  subroutine add_line(name, column, remark, lines)
    character(len=*), intent(in) :: name, remark
    real(real64), intent(in) :: column(:)
    type(total_line), allocatable, intent(inout) :: lines(:)
    real(real64), allocatable :: known(:)
    type(total_line) :: new

    known = pack(column, column > not_computed)
    if (size(known) == 0) return
    new%name = name
    new%remark = remark
    if (size(column) == 1) then
      new%known = 1
      new%numbers = known(1)
    else
      new%known = 3
      new%numbers = [maxval(known), minval(known), mean_value(known)]
    end if
    lines = [lines, new]
  end subroutine add_line

  ! The average; a sum beyond the range of a double is not needed for it.
  pure real(real64) function mean_value(column)
    real(real64), intent(in) :: column(:)

    if (maxval(abs(column)) > huge(column) / size(column)) then
      mean_value = sum(column / size(column))
    else
      mean_value = sum(column) / size(column)
    end if
  end function mean_value

end module asperity_totals_table
