!> A table of the results as CSV.
module asperity_results_csv
  use asperity_csv, only: csv_line
  use asperity_kinds, only: not_computed
  use asperity_result_table, only: cell_real, cell_word, result_table
  use asperity_scene_results, only: scene_results
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: write_results

contains

  !> One line a row, under the names of the columns.
  subroutine write_results(which, results, buffer, comment)
    integer, intent(in) :: which                !! table, of `asperity_result_table`
    type(scene_results), intent(in) :: results  !! solved; contacts need them kept
    type(text_buffer), intent(inout) :: buffer  !! the text
    character(len=*), intent(in), optional :: comment  !! a line before the names
    type(result_table) :: table
    type(csv_line) :: line
    integer :: column
    logical :: found

    if (present(comment)) call buffer%line('# ' // comment)
    call table%begin(which, results)
    do column = 1, size(table%names)
      call line%put(table%names(column))
    end do
    do
      call line%finish(buffer)
      call table%next(results, found)
      if (.not. found) exit
      do column = 1, size(table%names)
        associate (number => table%numbers(column))
          if (table%kinds(column) == cell_word) then
            call line%put(table%words(column))
          else if (table%kinds(column) == cell_real .or. .not. number > not_computed) then
            call line%put(number)
          else
            call line%put(nint(number))
          end if
        end associate
      end do
    end do
  end subroutine write_results

end module asperity_results_csv
