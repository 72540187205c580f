!> What accuracy costs for any scene, as a table with a diagram, and as lines of the study's CSV.
module asperity_way_table_text
  use asperity_csv, only: csv_line
  use asperity_kinds, only: not_computed, real64
  use asperity_scene_ways, only: family_words, of_arithmetic
  use asperity_text_buffer, only: text_buffer
  use asperity_way_study, only: way_row, way_table
  implicit none
  private

  public :: number_of_way_columns, put_way_rows, write_way_table, way_columns

  !> Columns of the CSV that these lines alone fill.
  character(len=*), parameter :: way_columns = &
    'family,way,seconds,error_max,error_mean,error_position,area_error_max,own_error_max,' // &
    'error_estimate,load,separation,area,reference,left_out'
  !> How many.
  integer, parameter :: number_of_way_columns = 14

  ! Columns of the study of a sweep, and the front's among them.
  integer, parameter :: columns_before = 24, front_column = 19

  ! The diagram: from 1 on the right to 1e-16 on the left, two characters a decade.
  integer, parameter :: decades = 16

contains

  !> One line a way; the front carries a star.
  subroutine write_way_table(table, buffer)
    type(way_table), intent(in) :: table        !! all ways
    type(text_buffer), intent(inout) :: buffer  !! the text
    character(len=160) :: line
    integer :: i

    call buffer%line('All methods on one axis. Error: largest relative error over the ' // &
                     'positions, of the load or, under load control, of')
    call buffer%line('the compression, against the reference (+), and against the same model ' // &
                     'without the approximation of this method (o):')
    call buffer%line('arithmetic against real128, steps against exact events, effects against ' // &
                     'the effects of the scene.')
    call buffer%line('* Pareto front: no other method is faster and more accurate')
    call buffer%line('')
    call buffer%line('  family     method                           seconds    error  of ' // &
                     'area   method 1e-16    1e-12    1e-8    1e-4     1')
    do i = 1, size(table%rows)
      associate (row => table%rows(i))
        if (allocated(row%left_out)) then
          call buffer%line('  ' // family_words(row%way%family) // ' ' // row%way%name // &
                           ' left out: ' // row%left_out)
          cycle
        end if
        write (line, '(a1, 1x, a10, 1x, a32, 1x, a8, 3(2x, a7), 2x, "|", a, "|")') &
          merge('*', ' ', row%on_front), family_words(row%way%family), row%way%name, &
          number(row%seconds), error_text(row, row%total%largest), &
          error_text(row, row%total%area), number(row%own%largest), &
          axis(row)
        call buffer%line(line)
      end associate
    end do
    if (table%no_theories /= '') call buffer%line('  theories left out: ' // table%no_theories)
    if (table%no_neighbours /= '') &
      call buffer%line('  neighbours left out: ' // table%no_neighbours)
    associate (best => table%rows(table%reference))
      call buffer%line('')
      call buffer%line('Reference: ' // trim(best%way%name) // ', ' // good_to(best) // '.')
      if (table%next_best > 0) &
        call buffer%line('The next most accurate, ' // &
            trim(table%rows(table%next_best)%way%name) // &
                         ', differs from it by ' // trim(adjustl(number(table%next_best_differs))) &
                         // '.')
    end associate
    if (table%exponent > not_computed) then
      write (line, '(a, f6.3, a)') 'Area grows as the load to the power', table%exponent, &
        ' at the end, for isolated contacts. Archard: 2/3 for a sphere, 4/5 with'
      call buffer%line('')
      call buffer%line(line)
      call buffer%line('smaller hemispheres on it, 14/15 with smaller ones on those.')
    end if
    if (.not. allocated(table%criteria)) return
    if (size(table%criteria) == 0) return
    call buffer%line('')
    call buffer%line('Smallest hardness for elastic contact, by the criteria that the thesis ' // &
                     'reviews')
    do i = 1, size(table%criteria)
      write (line, '(2x, a32, 1x, es10.3e2)') table%criteria(i)%name, table%criteria(i)%hardness
      call buffer%line(line)
    end do
  end subroutine write_way_table

  ! What a reference says of itself.
  pure function good_to(row) result(text)
    type(way_row), intent(in) :: row
    character(len=:), allocatable :: text

    text = 'exact to rounding'
    if (row%own_estimate > 0.0_real64) &
      text = 'estimated error ' // trim(adjustl(number(row%own_estimate)))
    if (row%way%family /= of_arithmetic .and. .not. row%own_estimate > not_computed) &
      text = 'without an error estimate'
  end function good_to

  pure function error_text(row, error) result(text)
    type(way_row), intent(in) :: row
    real(real64), intent(in) :: error
    character(len=7) :: text

    text = number(error)
    if (row%is_reference) text = '      -'
  end function error_text

  pure function number(value) result(text)
    real(real64), intent(in) :: value
    character(len=7) :: text

    text = ''
    if (value > not_computed) write (text, '(es7.1e2)') value
    if (.not. abs(value) > 0.0_real64) text = '      0'
  end function number

  ! Own error o, error against the reference +, both in one place *.
  pure function axis(row) result(text)
    type(way_row), intent(in) :: row
    character(len=2 * decades + 1) :: text
    integer :: own, total

    text = repeat(' ', len(text))
    total = place(row%total%largest)
    own = place(row%own%largest)
    if (own > 0) text(own:own) = 'o'
    if (total > 0 .and. .not. row%is_reference) text(total:total) = '+'
    if (own == total .and. own > 0 .and. .not. row%is_reference) text(own:own) = '*'
  end function axis

  pure integer function place(error)
    real(real64), intent(in) :: error

    place = 0
    if (.not. error > not_computed) return
    place = 1
    if (error > 0.0_real64) &
      place = min(2 * decades + 1, max(1, nint(2 * (decades + log10(error))) + 1))
  end function place

  !> The lines of the CSV: of the columns before they fill arithmetic, method, step and front.
  subroutine put_way_rows(table, buffer)
    type(way_table), intent(in) :: table        !! all ways
    type(text_buffer), intent(inout) :: buffer  !! the text
    type(csv_line) :: line
    integer :: i, k

    do i = 1, size(table%rows)
      associate (row => table%rows(i))
        call line%put(trim(row%way%arithmetic))
        call line%put('total')
        call line%put(row%way%step)
        do k = 4, columns_before
          if (k == front_column) then
            call line%put(row%on_front)
          else
            call line%put('')
          end if
        end do
        call line%put(trim(family_words(row%way%family)))
        call line%put(without_commas(trim(row%way%name)))
        call line%put([row%seconds, row%total%largest, row%total%mean])
        if (row%total%worst > 0) then
          call line%put(row%total%worst)
        else
          call line%put('')
        end if
        call line%put([row%total%area, row%own%largest, row%own_estimate, row%ends])
        call line%put(row%is_reference)
        if (allocated(row%left_out)) then
          call line%put(without_commas(row%left_out))
        else
          call line%put('')
        end if
        call line%finish(buffer)
      end associate
    end do
  end subroutine put_way_rows

  pure function without_commas(text) result(words)
    character(len=*), intent(in) :: text
    character(len=len(text)) :: words
    integer :: i

    words = text
    do i = 1, len(text)
      if (text(i:i) == ',') words(i:i) = ';'
    end do
  end function without_commas

end module asperity_way_table_text
