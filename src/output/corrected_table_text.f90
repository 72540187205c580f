!> Table VI of the thesis before and after its corrections, as `asperity solve DECK` prints it.
module asperity_corrected_table_text
  use asperity_corrected_table, only: corrected_table, stage_name
  use asperity_kinds, only: real64
  use asperity_original_records, only: approach_row, individual_difference_row, points_row, &
                                       slope_row, total_area_row, total_difference_row, &
                                       total_load_row
  use asperity_problems, only: decimal_text, real_text
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: write_corrected_table

contains

  !> Table VI before and after, one line a number, with what each correction adds.
  subroutine write_corrected_table(table, buffer)
    type(corrected_table), intent(in) :: table  !! both versions and the changes
    type(text_buffer), intent(inout) :: buffer  !! gets the text
    character(len=*), parameter :: columns(3) = &
      [character(len=7) :: 'maximum', 'minimum', 'average']
    ! The port's word for the machine's result of x/0 is 1e27.
    real(real64), parameter :: after_division_by_zero = 1.0e26_real64
    integer, parameter :: rows(7) = [total_load_row, total_area_row, points_row, approach_row, &
                                     slope_row, total_difference_row, individual_difference_row]
    character(len=*), parameter :: names(7) = [character(len=20) :: 'total load', &
      'total contact area', 'contact points', 'approach', 'slope of areas', 'area difference, %', &
      'individual, %']
    integer, parameter :: decimals(7) = [0, 4, 0, 4, 3, 1, 1]
    integer :: i, column

    call buffer%line('')
    if (allocated(table%why_not)) then
      call buffer%line('no Table VI to correct: the original program stops at ' // table%why_not)
      return
    end if
    call buffer%line('Table VI, corrected                 historic corrected  reason')
    do i = 1, size(rows)
      do column = 1, size(columns)
        call number_line(names(i), rows(i), column, decimals(i))
      end do
    end do

  contains

    subroutine number_line(name, row, column, decimals)
      character(len=*), intent(in) :: name
      integer, intent(in) :: row, column, decimals
      character(len=11) :: before, after
      character(len=:), allocatable :: change, reason
      character(len=57) :: line
      integer :: places, stage

      places = decimals
      ! The original cuts the average number of points to a whole one.
      if (row == points_row .and. column == 3) places = 2
      before = fixed_text(table%historic(row, column), decimals)
      after = fixed_text(table%corrected(row, column), places)
      reason = ''
      if (abs(table%historic(row, column)) > after_division_by_zero) then
        reason = 'no contact at its limit: the original divided by zero'
      else if (fixed_text(table%historic(row, column), places) /= after) then
        do stage = 1, size(table%change, 3)
          associate (by_stage => table%change(row, column, stage))
            if (abs(by_stage) < 0.5_real64 * 10.0_real64**(-places)) cycle
            if (reason /= '') reason = reason // ', '
            change = real_text(by_stage, 'sp, es24.3e3')
            if (abs(by_stage) < 10.0_real64**(14 - max(places, 1))) &
              change = real_text(by_stage, 'sp, f16.' // decimal_text(max(places, 1)))
            reason = reason // stage_name(table, stage, row) // ' ' // change
          end associate
        end do
        if (reason == '') reason = 'changes below half a printed unit add up'
      end if
      write (line, '(2x, a20, 1x, a7, 3x, 2a11)') name, columns(column), before, after
      call buffer%line(line // reason)
    end subroutine number_line

  end subroutine write_corrected_table

  ! A number with so many decimals, right-justified.
  pure function fixed_text(value, decimals) result(text)
    real(real64), intent(in) :: value
    integer, intent(in) :: decimals
    character(len=11) :: text
    character(len=12) :: format

    if (abs(value) >= 10.0_real64**(9 - decimals)) then
      write (text, '(es11.3e3)') value
      return
    end if
    write (format, '("(f11.", i0, ")")') decimals
    write (text, format) value
    if (decimals == 0) text = ' ' // text(:10)
  end function fixed_text

end module asperity_corrected_table_text
