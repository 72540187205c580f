!> The totals of a run, one line each: over one position its values, over several their range.
module asperity_totals_table
  use asperity_contact_records, only: position_result, state_row
  use asperity_kinds, only: not_computed, real64
  use asperity_scene_results, only: last_state, nominal_values, scene_results
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: write_totals

  ! A load that is held is met to this share.
  real(real64), parameter :: load_is_met = 1.0e-6_real64

contains

  !> Totals of the last states, what was lost while they were held, what their effects tell.
  subroutine write_totals(results, buffer)
    type(scene_results), intent(in) :: results  !! solved
    type(text_buffer), intent(inout) :: buffer  !! the text
    character(len=*), parameter :: names(10) = [character(len=18) :: &
      'total load', 'vertical load', 'contact area', 'projected area', 'mean pressure', &
      'greatest pressure', 'approach', 'contacts', 'nominal pressure', 'area fraction']
    real(real64), allocatable :: values(:, :)
    type(state_row) :: last
    integer :: i, m, number

    number = size(results%positions)
    allocate (values(number, size(names) - merge(0, 2, results%nominal_area > 0.0_real64)))
    do m = 1, number
      last = last_state(results%positions(m))
      values(m, :) = [last%load, last%vertical_load, last%area, last%projected_area, &
                      not_computed, last%greatest_pressure, last%approach, &
                      real(last%contacts, real64), nominal_values(results, last)]
      if (last%area > 0.0_real64) values(m, 5) = last%load / last%area
    end do
    if (number == 1) then
      call buffer%line('                              value')
    else
      call buffer%line('                            maximum          minimum          average')
    end if
    do i = 1, size(values, 2)
      if (names(i) == 'approach') then
        call write_value(names(i), values(:, i), buffer, 'separation of the reference planes')
      else
        call write_value(names(i), values(:, i), buffer)
      end if
    end do
    call write_held(results, buffer)
    call write_told(results, buffer)
  end subroutine write_totals

  ! What became of a load or an approach while it was held.
  subroutine write_held(results, buffer)
    type(scene_results), intent(in) :: results
    type(text_buffer), intent(inout) :: buffer
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
      call write_value('lost while held', lost, buffer, 'share of the load')
    if (any(abs(sunk) > 0.0_real64)) call write_value('sunk while held', sunk, buffer)
  end subroutine write_held

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

  ! The columns of the effects, as they are named in --positions.
  subroutine write_told(results, buffer)
    type(scene_results), intent(in) :: results
    type(text_buffer), intent(inout) :: buffer
    real(real64) :: values(size(results%positions))
    character(len=:), allocatable :: name
    integer :: i, k, m

    if (.not. allocated(results%effects)) return
    if (size(results%effects%state_columns) == 0) return
    call buffer%line('')
    do k = 1, size(results%effects%state_columns)
      do m = 1, size(results%positions)
        values(m) = results%positions(m)%state_values(k)
      end do
      name = trim(results%effects%state_columns(k))
      do i = 1, len(name)
        if (name(i:i) == '_') name(i:i) = ' '
      end do
      call write_value(name, values, buffer)
    end do
  end subroutine write_told

  ! A name and a value, or their range; values that were not computed are left out.
  subroutine write_value(name, column, buffer, remark)
    character(len=*), intent(in) :: name
    real(real64), intent(in) :: column(:)
    type(text_buffer), intent(inout) :: buffer
    character(len=*), intent(in), optional :: remark
    real(real64), allocatable :: known(:)
    character(len=80) :: line

    known = pack(column, column > not_computed)
    if (size(known) == 0) return
    line = ''
    if (size(column) == 1) then
      write (line(19:), '(g17.7)') known
    else
      write (line(19:), '(3g17.7)') maxval(known), minval(known), average(known)
    end if
    ! A long name reaches into the blanks before its number.
    line(:max(18, len(name))) = name
    if (present(remark)) then
      call buffer%line(trim(line) // '   ' // remark)
    else
      call buffer%line(line)
    end if
  end subroutine write_value

  ! The average; a sum beyond the range of a double is not needed for it.
  pure real(real64) function average(column)
    real(real64), intent(in) :: column(:)

    if (maxval(abs(column)) > huge(column) / size(column)) then
      average = sum(column / size(column))
    else
      average = sum(column) / size(column)
    end if
  end function average

end module asperity_totals_table
