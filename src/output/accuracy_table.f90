!> The accuracy study as a table and as CSV.
module asperity_accuracy_table
  use asperity_accuracy_study, only: accuracy_row, approach_error, area_error, count_error, &
                                     load_error, pressure_error, way_events, way_marching
  use asperity_contact_records, only: overlap_stable
  use asperity_csv, only: csv_line
  use asperity_kinds, only: real64
  use asperity_model_rungs, only: model_rung
  use asperity_problems, only: decimal_text
  use asperity_scene_values, only: effect_off, effect_words
  use asperity_text_buffer, only: text_buffer
  use asperity_way_study, only: way_table
  use asperity_way_table_text, only: number_of_way_columns, put_way_rows, way_columns
  implicit none
  private

  public :: write_accuracy_table, write_accuracy_csv

  ! Quantities in the order of the columns.
  integer, parameter :: shown(5) = &
    [load_error, area_error, pressure_error, approach_error, count_error]
  character(len=*), parameter :: row_format = &
    '(a1, 1x, a10, 1x, a8, 1x, a7, 1x, a8, 1x, f13.2, f7.0, "%", f9.1, 5(2x, a16))'
  character(len=*), parameter :: rung_format = &
    '(2x, a11, 1x, a9, 11x, f13.2, f7.0, "%", f9.1, 2x, a, 2x, a)'

contains

  !> One line a way of computing; the front carries a star.
  subroutine write_accuracy_table(rows, ways_left_out, rungs, left_out, buffer)
    type(accuracy_row), intent(in) :: rows(:)   !! all ways that there was time for
    integer, intent(in) :: ways_left_out        !! how many there was none for
    type(model_rung), intent(in) :: rungs(:)    !! the model's ladder
    character(len=*), intent(in) :: left_out    !! why its end is missing; empty: it is not
    type(text_buffer), intent(inout) :: buffer  !! the text
    character(len=170) :: line
    integer :: i, k

    call buffer%line('Time per position, and largest (mean) relative error over all ' // &
                     'positions. Reference: exact events in real128.')
    call buffer%line('* Pareto front: no other method is faster and more accurate')
    call buffer%line('')
    call buffer%line('  arithmetic method   step    overlap    us/position  spread    ratio  ' // &
                     'load              area              pressure          separation' // &
                     '        contacts')
    do i = 1, size(rows)
      write (line, row_format) &
        merge('*', ' ', rows(i)%on_front), rows(i)%arithmetic // '   ', way_name(rows(i)), &
        step_text(rows(i)%step), overlap_name(rows(i)), 1.0e6_real64 * rows(i)%seconds, &
        100 * rows(i)%spread, rows(i)%ratio, &
        (both(rows(i)%largest(shown(k)), rows(i)%mean(shown(k))), k = 1, size(shown))
      call buffer%line(line)
    end do
    if (ways_left_out > 0) &
      call buffer%line('left out: ' // decimal_text(ways_left_out) // ' methods that take ' // &
                       'longer than --seconds allow')
    call write_rungs(rungs, minval(rows%seconds), left_out, buffer)
  end subroutine write_accuracy_table

  ! One line a rung of the model.
  subroutine write_rungs(rungs, fastest, left_out, buffer)
    type(model_rung), intent(in) :: rungs(:)
    real(real64), intent(in) :: fastest
    character(len=*), intent(in) :: left_out
    type(text_buffer), intent(inout) :: buffer
    character(len=120) :: line
    character(len=18) :: tolerance, error
    character(len=:), allocatable :: position
    integer :: i

    call buffer%line('')
    call buffer%line('Model: cost of elastic interaction. Largest (mean) error of the ' // &
                     'ratio of the load to that of the same contacts as')
    call buffer%line('isolated contacts; reference: the finest boundary elements.')
    call buffer%line('')
    call buffer%line('  interaction tolerance             us/position  spread    ratio  ' // &
                     'load ratio          at position')
    do i = 1, size(rungs)
      tolerance = '-'
      if (rungs(i)%tolerance > 0.0_real64) write (tolerance, '(es7.0e2)') rungs(i)%tolerance
      if (rungs(i)%error_known) then
        error = both(rungs(i)%largest, rungs(i)%mean)
        position = decimal_text(rungs(i)%worst_position)
      else
        error = 'not estimated'
        if (left_out == '' .and. i == size(rungs)) error = 'the reference'
        position = ''
      end if
      write (line, rung_format) name_of_model(rungs(i)), adjustl(tolerance), &
        1.0e6_real64 * rungs(i)%seconds, 100 * rungs(i)%spread, rungs(i)%seconds / fastest, error, &
        position
      call buffer%line(line)
    end do
    if (left_out /= '') call buffer%line('no finer level: ' // left_out)
  end subroutine write_rungs

  !> The same with all digits. Rungs of the model follow the ways; what does not apply to a row is
  !> empty.
  subroutine write_accuracy_csv(rows, rungs, table, buffer)
    type(accuracy_row), intent(in) :: rows(:)   !! all ways
    type(model_rung), intent(in) :: rungs(:)    !! the model's ladder
    type(way_table), intent(in) :: table        !! what serves any scene
    type(text_buffer), intent(inout) :: buffer  !! the text
    type(csv_line) :: line
    integer :: i, k

    call buffer%line('arithmetic,method,step,overlap,seconds_per_position,spread,ratio,' // &
                     'load_max,load_mean,area_max,area_mean,pressure_max,pressure_mean,' // &
                     'separation_max,separation_mean,contacts_max,contacts_mean,worst,front,' // &
                     'interaction,tolerance,factor_max,factor_mean,factor_worst_position,' // &
                     way_columns)
    do i = 1, size(rows)
      call line%put(trim(rows(i)%arithmetic))
      call line%put(trim(way_name(rows(i))))
      call line%put(rows(i)%step)
      call line%put(trim(overlap_name(rows(i))))
      call line%put([rows(i)%seconds, rows(i)%spread, rows(i)%ratio])
      do k = 1, size(shown)
        call line%put([rows(i)%largest(shown(k)), rows(i)%mean(shown(k))])
      end do
      call line%put(rows(i)%worst)
      call line%put(rows(i)%on_front)
      call put_factor(line, rungs, effect_off)
      call put_nothing(line, number_of_way_columns)
      call line%finish(buffer)
    end do
    do i = 1, size(rungs)
      call line%put('real64')
      call line%put('model')
      call line%put(0.0_real64)
      call line%put('stable')
      call line%put([rungs(i)%seconds, rungs(i)%spread, rungs(i)%seconds / minval(rows%seconds)])
      ! Two for each quantity, the worst, the front.
      call put_nothing(line, 2 * size(shown) + 2)
      call put_factor(line, rungs(i:i), rungs(i)%interaction)
      call put_nothing(line, number_of_way_columns)
      call line%finish(buffer)
    end do
    call put_way_rows(table, buffer)
  end subroutine write_accuracy_csv

  subroutine put_nothing(line, cells)
    type(csv_line), intent(inout) :: line
    integer, intent(in) :: cells
    integer :: k

    do k = 1, cells
      call line%put('')
    end do
  end subroutine put_nothing

  ! The model's cells: those of the first rung that takes contacts together in this way.
  subroutine put_factor(line, rungs, interaction)
    type(csv_line), intent(inout) :: line
    type(model_rung), intent(in) :: rungs(:)
    integer, intent(in) :: interaction
    integer :: i

    call line%put(trim(effect_words(interaction)))
    do i = 1, size(rungs)
      if (rungs(i)%interaction == interaction) exit
    end do
    if (i > size(rungs)) then
      call line%put('')
    else
      call line%put(rungs(i)%tolerance)
      if (rungs(i)%error_known) then
        call line%put([rungs(i)%largest, rungs(i)%mean])
        call line%put(rungs(i)%worst_position)
        return
      end if
    end if
    call put_nothing(line, 3)
  end subroutine put_factor

  pure function name_of_model(rung) result(name)
    type(model_rung), intent(in) :: rung
    character(len=11) :: name

    name = effect_words(rung%interaction)
    if (rung%interaction == effect_off) name = 'independent'
  end function name_of_model

  pure function way_name(row) result(name)
    type(accuracy_row), intent(in) :: row
    character(len=8) :: name

    select case (row%way)
    case (way_events)
      name = 'events'
    case (way_marching)
      name = 'marching'
    case default
      name = 'original'
    end select
  end function way_name

  pure function overlap_name(row) result(name)
    type(accuracy_row), intent(in) :: row
    character(len=8) :: name

    name = merge('stable  ', 'original', row%overlap == overlap_stable)
  end function overlap_name

  pure function step_text(step) result(text)
    real(real64), intent(in) :: step
    character(len=7) :: text

    text = '-'
    if (step > 0.0_real64) write (text, '(es7.0e2)') step
    if (step > 0.0_real64 .and. exponent(step) < -328) write (text, '(es7.0e3)') step
  end function step_text

  !> `largest (mean)`.
  pure function both(largest, mean) result(text)
    real(real64), intent(in) :: largest, mean
    character(len=16) :: text

    write (text, '(es7.1e2, " (", es6.0e2, ")")') largest, mean
  end function both

end module asperity_accuracy_table
