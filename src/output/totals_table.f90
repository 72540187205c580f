!> The totals of a run, one line each: over one position its values, over several their range.
module asperity_totals_table
  use asperity_contact_records, only: position_result, state_row
  use asperity_kinds, only: not_computed, real64
  use asperity_scene_results, only: last_state, nominal_values, scene_results
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: load_is_met, total_line, list_totals, write_totals

  !> A load that is asked for or held is met to this share.
  real(real64), parameter :: load_is_met = 1.0e-6_real64

  !> One quantity over all positions.
  type :: total_line
    character(len=40) :: name = ''            !! in words
    character(len=40) :: remark = ''          !! what it is; blank: the name says it
    logical :: is_told = .false.              !! by an effect
    integer :: known = 0                      !! so many of the next are meant
    real(real64) :: numbers(3) = 0.0_real64   !! the value; of several: greatest, least, average
  end type total_line

contains

  !> Totals of the last states, what was lost while they were held, what their effects tell.
  subroutine write_totals(results, buffer)
    type(scene_results), intent(in) :: results  !! solved
    type(text_buffer), intent(inout) :: buffer  !! the text
    type(total_line), allocatable :: lines(:)
    integer :: i

    if (size(results%positions) == 1) then
      call buffer%line('                              value')
    else
      call buffer%line('                            maximum          minimum          average')
    end if
    call list_totals(results, lines)
    do i = 1, size(lines)
      if (i > 1) then
        if (lines(i)%is_told .and. .not. lines(i - 1)%is_told) call buffer%line('')
      end if
      call write_line(lines(i), buffer)
    end do
  end subroutine write_totals

  !> The same as values. What was computed at no position has no line.
  subroutine list_totals(results, lines)
    type(scene_results), intent(in) :: results                !! solved
    type(total_line), allocatable, intent(out) :: lines(:)    !! in order
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
    allocate (lines(0))
    do i = 1, size(values, 2)
      if (names(i) == 'approach') then
        call add_line(names(i), values(:, i), lines, 'separation of the reference planes')
      else
        call add_line(names(i), values(:, i), lines)
      end if
    end do
    call list_held(results, lines)
    call list_told(results, lines)
  end subroutine list_totals

  ! What became of a load or an approach while it was held.
  subroutine list_held(results, lines)
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
      call add_line('lost while held', lost, lines, 'share of the load')
    if (any(abs(sunk) > 0.0_real64)) call add_line('sunk while held', sunk, lines)
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

  ! The columns of the effects, as they are named in --positions.
  subroutine list_told(results, lines)
    type(scene_results), intent(in) :: results
    type(total_line), allocatable, intent(inout) :: lines(:)
    real(real64) :: values(size(results%positions))
    character(len=:), allocatable :: name
    integer :: before, i, k, m

    if (.not. allocated(results%effects)) return
    if (size(results%effects%state_columns) == 0) return
    do k = 1, size(results%effects%state_columns)
      do m = 1, size(results%positions)
        values(m) = results%positions(m)%state_values(k)
      end do
      before = size(lines)
      name = trim(results%effects%state_columns(k))
      do i = 1, len(name)
        if (name(i:i) == '_') name(i:i) = ' '
      end do
      call add_line(name, values, lines)
      if (size(lines) > before) lines(size(lines))%is_told = .true.
    end do
  end subroutine list_told

  ! A value, or a range; values that were not computed are left out.
  subroutine add_line(name, column, lines, remark)
    character(len=*), intent(in) :: name
    real(real64), intent(in) :: column(:)
    type(total_line), allocatable, intent(inout) :: lines(:)
    character(len=*), intent(in), optional :: remark
    real(real64), allocatable :: known(:)
    type(total_line) :: new

    known = pack(column, column > not_computed)
    if (size(known) == 0) return
    new%name = name
    if (present(remark)) new%remark = remark
    if (size(column) == 1) then
      new%known = 1
      new%numbers = known(1)
    else
      new%known = 3
      new%numbers = [maxval(known), minval(known), average(known)]
    end if
    lines = [lines, new]
  end subroutine add_line

  ! A name and its numbers.
  subroutine write_line(total, buffer)
    type(total_line), intent(in) :: total
    type(text_buffer), intent(inout) :: buffer
    character(len=80) :: line

    line = ''
    write (line(19:), '(3g17.7)') total%numbers(:total%known)
    ! A long name reaches into the blanks before its number.
    line(:max(18, len_trim(total%name))) = total%name
    if (total%remark == '') then
      call buffer%line(line)
    else
      call buffer%line(trim(line) // '   ' // total%remark)
    end if
  end subroutine write_line

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
