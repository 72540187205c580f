!> The accuracy study as a table and as CSV.
module asperity_accuracy_table
  use asperity_accuracy_study, only: accuracy_row, approach_error, area_error, count_error, &
                                     load_error, pressure_error, way_events, way_marching
  use asperity_contact_records, only: overlap_stable
  use asperity_csv, only: csv_line
  use asperity_kinds, only: real64
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: write_accuracy_table, write_accuracy_csv

  character(len=*), parameter :: row_format = &
    '(a1, 1x, a10, 1x, a8, 1x, a6, 1x, a8, 1x, f13.2, f7.0, "%", f7.1, 5(2x, a16))'

contains

  !> One line a way of computing; the front carries a star.
  subroutine write_accuracy_table(rows, buffer)
    type(accuracy_row), intent(in) :: rows(:)   !! all ways
    type(text_buffer), intent(inout) :: buffer  !! the text
    character(len=170) :: line
    integer :: i

    call buffer%line('Time a position, and largest (mean) relative error over all positions. ' // &
                     'Reference: exact events in real128.')
    call buffer%line('* the cheapest way for its accuracy')
    call buffer%line('')
    call buffer%line('  arithmetic way      step   overlap    us/position  spread  ratio  load' // &
                     '              area              pressure          approach          contacts')
    do i = 1, size(rows)
      write (line, row_format) &
        merge('*', ' ', rows(i)%on_front), rows(i)%arithmetic // '   ', way_name(rows(i)), &
        step_text(rows(i)%step), overlap_name(rows(i)), 1.0e6_real64 * rows(i)%seconds, &
        100 * rows(i)%spread, rows(i)%ratio, both(rows(i), load_error), &
        both(rows(i), area_error), both(rows(i), pressure_error), both(rows(i), approach_error), &
        both(rows(i), count_error)
      call buffer%line(line)
    end do
  end subroutine write_accuracy_table

  !> The same with all digits.
  subroutine write_accuracy_csv(rows, buffer)
    type(accuracy_row), intent(in) :: rows(:)   !! all ways
    type(text_buffer), intent(inout) :: buffer  !! the text
    integer, parameter :: quantities(5) = &
      [load_error, area_error, pressure_error, approach_error, count_error]
    type(csv_line) :: line
    integer :: i, k

    call buffer%line('arithmetic,method,step,overlap,seconds_per_position,spread,ratio,' // &
                     'load_max,load_mean,area_max,area_mean,pressure_max,pressure_mean,' // &
                     'approach_max,approach_mean,contacts_max,contacts_mean,worst,front')
    do i = 1, size(rows)
      call line%put(trim(rows(i)%arithmetic))
      call line%put(trim(way_name(rows(i))))
      call line%put(rows(i)%step)
      call line%put(trim(overlap_name(rows(i))))
      call line%put(rows(i)%seconds)
      call line%put(rows(i)%spread)
      call line%put(rows(i)%ratio)
      do k = 1, size(quantities)
        call line%put(rows(i)%largest(quantities(k)))
        call line%put(rows(i)%mean(quantities(k)))
      end do
      call line%put(rows(i)%worst)
      call line%put(rows(i)%on_front)
      call line%finish(buffer)
    end do
  end subroutine write_accuracy_csv

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
    character(len=6) :: text

    text = '-'
    if (step > 0.0_real64) write (text, '(es6.0e1)') step
  end function step_text

  !> `largest (mean)`.
  pure function both(row, quantity) result(text)
    type(accuracy_row), intent(in) :: row
    integer, intent(in) :: quantity
    character(len=16) :: text

    write (text, '(es7.1e2, " (", es6.0e2, ")")') row%largest(quantity), row%mean(quantity)
  end function both

end module asperity_accuracy_table
