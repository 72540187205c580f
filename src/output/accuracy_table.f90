!> Run time and error of all methods of a scene, as a table with a diagram and as CSV.
module asperity_accuracy_table
  use asperity_contact_records, only: by_marching, overlap_original
  use asperity_csv_tables, only: write_table
  use asperity_input_text, only: replaced_text
  use asperity_kinds, only: not_computed, real64
  use asperity_method_study, only: error_against, fastest_within, method_row, method_table
  use asperity_method_totals, only: error_of_area, error_of_greatest_pressure, error_of_load, &
                                    error_of_separation, quantity_names
  use asperity_number_format, only: number_text, percent_text
  use asperity_problems, only: decimal_text, real_text
  use asperity_result_table, only: add_reals, add_wholes, add_words, array_table
  use asperity_scene_values, only: is_load, is_thesis_sweep, scene
  use asperity_study_methods, only: family_words, of_arithmetic, of_neighbours, of_scene, of_steps
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: write_accuracy_table, write_accuracy_csv

  ! The diagram: from 1 on the right to 1e-16 on the left, two characters a decade.
  integer, parameter :: decades = 16
  ! Shortest time of what is typed, s (chosen: to start the program and read the scene takes some
  ! milliseconds, which are not measured).
  real(real64), parameter :: shortest = 0.01_real64

contains

  !> One line a method; the front carries a star. The last lines are what to type.
  subroutine write_accuracy_table(scene_in, table, buffer)
    type(scene), intent(in) :: scene_in            !! scene that was studied
    type(method_table), intent(in) :: table        !! all methods of a scene
    type(text_buffer), intent(inout) :: buffer  !! gets the text
    character(len=160) :: line
    character(len=:), allocatable :: quality
    real(real64) :: own_floor  ! error of the reference where the own error is that against it
    integer :: i

    call buffer%line('All methods on one axis. Error: largest relative error over the ' // &
                     'positions, of the load or, under load control, of')
    call buffer%line('the compression, against the reference (+), and against the same model ' // &
                     'without the approximation of this method (o):')
    call buffer%line('steps and arithmetics against exact events in real64, effects against ' // &
                     'the effects of the scene.')
    call buffer%line('<: the difference is below the estimated error of the reference, ' // &
                     'which is printed')
    call buffer%line('* Pareto front: no other method is faster and more accurate')
    call buffer%line('')
    call buffer%line('  family     method' // repeat(' ', 35) // 'seconds    error  of ' // &
                     'area   method 1e-16    1e-12    1e-8    1e-4     1')
    do i = 1, size(table%rows)
      associate (row => table%rows(i), best => table%rows(table%reference))
        if (allocated(row%left_out)) then
          call buffer%line('  ' // family_words(row%method%family) // ' ' // row%method%name // &
                           ' left out: ' // row%left_out)
          cycle
        end if
        own_floor = merge(best%own_estimate, not_computed, .not. row%is_reference .and. &
                          any(row%method%family == [of_scene, of_neighbours]))
        write (line, '(a1, 1x, a10, 1x, a40, 1x, a8, 3(1x, a8), 2x, "|", a, "|")') &
          merge('*', ' ', row%on_front), family_words(row%method%family), row%method%name, &
          short_number(row%seconds), error_text(row, row%total%largest, best%own_estimate), &
          error_text(row, row%total%quantity(error_of_area), best%estimates(1)), &
          merge(short_number(row%own%largest), error_text(row, row%own%largest, own_floor), &
                row%is_reference), error_axis(row, best%own_estimate, own_floor)
        call buffer%line(line)
      end associate
    end do
    if (table%no_neighbours /= '') &
      call buffer%line('  neighbours left out: ' // table%no_neighbours)
    associate (best => table%rows(table%reference))
      call buffer%line('')
      quality = 'exact to rounding'
      if (best%own_estimate > 0.0_real64) &
        quality = 'estimated error ' // trim(adjustl(short_number(best%own_estimate)))
      if ((best%method%family /= of_arithmetic .and. .not. best%own_estimate > not_computed) .or. &
          best%own_estimate >= huge(best%own_estimate)) quality = 'without an error estimate'
      call buffer%line('Reference: ' // trim(best%method%name) // ', ' // quality // '.')
      if (table%next_best > 0) call buffer%line('The next most accurate, ' // &
        trim(table%rows(table%next_best)%method%name) // ', differs from it by ' // &
        trim(adjustl(short_number(table%next_best_differs))) // '.')
    end associate
    call write_answers(scene_in, table, buffer)
  end subroutine write_accuracy_table

  ! Adds lines with what to type for an error of 1 %, 0.1 % and 0.01 %, and the time it takes.
  subroutine write_answers(scene_in, table, buffer)
    type(scene), intent(in) :: scene_in
    type(method_table), intent(in) :: table
    type(text_buffer), intent(inout) :: buffer
    character(len=*), parameter :: goals(3) = [character(len=6) :: '1 %', '0.1 %', '0.01 %']
    real(real64), parameter :: errors(3) = [1.0e-2_real64, 1.0e-3_real64, 1.0e-4_real64]
    character(len=:), allocatable :: text
    integer :: best, k

    call buffer%line('')
    text = 'Error of the ' // trim(merge('compression', 'load       ', &
                                         is_load(scene_in%loading%control)))
    if (is_thesis_sweep(scene_in)) then
      call buffer%line(text // ', and what to type into a scene with &surfaces deck = ''' // &
        scene_in%file // ''' / &motion x_first = ' // number_text(scene_in%motion%x_first) // &
        ', x_step = ' // number_text(scene_in%motion%x_step) // ', positions = ' // &
        decimal_text(scene_in%motion%positions) // ' /:')
    else
      call buffer%line(text // ', and what to type:')
    end if
    do k = 1, size(goals)
      best = fastest_within(table, errors(k))
      text = repeat(' ', 8 - len_trim(goals(k))) // trim(goals(k)) // ':  '
      if (best == 0) then
        text = text // 'not reached, '
        ! A map has a row for each goal, with the reason and the accuracy that it has.
        best = findloc(abs(table%rows%method%accuracy / errors(k) - 1.0_real64) < 0.5_real64, &
                       .true., 1)
        if (best > 0) then
          call buffer%line(text // table%rows(best)%left_out)
          cycle
        end if
        best = table%reference
        text = text // 'the least: '
      end if
      associate (row => table%rows(best), typed => table%rows(best)%method%typed)
        if (row%method%accuracy > 0.0_real64) then
          text = text // 'asperity solve ' // scene_in%file // ' ' // trim(typed)
        else if (typed == '') then
          text = text // trim(row%method%name)
        else if (index(typed, '=') > 0) then
          text = text // '&effects ' // trim(typed) // ' /'
        else
          text = text // trim(typed)
        end if
        text = text // ', '
        if (row%seconds < shortest) text = text // 'below '
        text = text // number_text(max(row%seconds, shortest), 2) // ' s, error '
        if (.not. row%total%largest > table%rows(table%reference)%own_estimate) &
          text = text // 'below '
        call buffer%line(text // percent_text(error_against(table, best)))
      end associate
    end do
  end subroutine write_answers

  ! An error against the reference; below the error of the reference itself that one, as a bound.
  pure function error_text(row, error, of_reference) result(text)
    type(method_row), intent(in) :: row
    real(real64), intent(in) :: error, of_reference
    character(len=8) :: text

    text = short_number(error)
    if (error > not_computed .and. error < of_reference .and. of_reference < 1.0_real64) &
      text = '<' // real_text(of_reference, 'es7.1e2')
    if (row%is_reference) text = '       -'
  end function error_text

  ! A number at the right end of eight characters; blank where it was not computed.
  pure function short_number(value) result(text)
    real(real64), intent(in) :: value
    character(len=8) :: text

    text = ''
    if (value > not_computed) text = real_text(value, 'es7.1e2')
    if (.not. abs(value) > 0.0_real64) text = '0'
    text = adjustr(text)
  end function short_number

  ! Own error o, error against the reference +, both in one place *.
  pure function error_axis(row, floor_of_total, floor_of_own) result(text)
    type(method_row), intent(in) :: row
    real(real64), intent(in) :: floor_of_total, floor_of_own
    character(len=2 * decades + 1) :: text
    integer :: own, total

    text = repeat(' ', len(text))
    total = axis_place(row%total%largest, floor_of_total)
    own = axis_place(row%own%largest, floor_of_own)
    if (own > 0) text(own:own) = 'o'
    if (total > 0 .and. .not. row%is_reference) text(total:total) = '+'
    if (own == total .and. own > 0 .and. .not. row%is_reference) text(own:own) = '*'
  end function error_axis

  pure integer function axis_place(error, least)
    real(real64), intent(in) :: error, least

    axis_place = 0
    if (.not. error > not_computed) return
    axis_place = 1
    if (max(error, least) > 0.0_real64) axis_place = &
      min(2 * decades + 1, max(1, nint(2 * (decades + log10(max(error, least)))) + 1))
  end function axis_place

  !> The same with all digits. What does not apply to a row is empty.
  subroutine write_accuracy_csv(table, buffer)
    type(method_table), intent(in) :: table        !! all methods of a scene
    type(text_buffer), intent(inout) :: buffer  !! gets the text
    type(array_table) :: columns
    type(method_row), allocatable :: rows(:)
    ! Quantities with a column of the error against the reference.
    integer, parameter :: named(4) = [error_of_area, error_of_load, error_of_separation, &
                                      error_of_greatest_pressure]
    character(len=400) :: left_out(size(table%rows))
    character(len=96) :: typed(size(table%rows))
    integer :: i, k

    allocate (rows, source=table%rows)
    left_out = ''
    do i = 1, size(rows)
      ! A comma would end a cell.
      rows(i)%method%name = replaced_text(rows(i)%method%name, ',', ';')
      typed(i) = replaced_text(rows(i)%method%typed, ',', ';')
      if (allocated(rows(i)%left_out)) left_out(i) = replaced_text(rows(i)%left_out, ',', ';')
    end do
    call add_words(columns, 'family', family_words(rows%method%family))
    call add_words(columns, 'method', rows%method%name)
    call add_words(columns, 'arithmetic', rows%method%arithmetic)
    call add_reals(columns, 'step', merge(rows%method%step, 0.0_real64, &
                                          rows%method%path == by_marching))
    call add_words(columns, 'overlap', merge('original', 'stable  ', &
                                             rows%method%overlap == overlap_original))
    call add_reals(columns, 'seconds', rows%seconds)
    call add_reals(columns, 'error_max', rows%total%largest)
    call add_reals(columns, 'error_mean', rows%total%mean)
    call add_reals(columns, 'error_position', merge(real(rows%total%worst, real64), not_computed, &
                                                    rows%total%worst > 0), is_count=.true.)
    do k = 1, size(named)
      call add_reals(columns, trim(quantity_names(named(k))) // '_error_max', &
                     rows%total%quantity(named(k)))
    end do
    call add_reals(columns, 'own_error_max', rows%own%largest)
    do k = 1, size(quantity_names)
      call add_reals(columns, trim(quantity_names(k)) // '_max', rows%own%quantity(k))
      call add_reals(columns, trim(quantity_names(k)) // '_mean', rows%own%quantity_mean(k))
    end do
    call add_reals(columns, 'error_estimate', rows%own_estimate)
    call add_reals(columns, 'area_error_estimate', rows%estimates(1))
    call add_reals(columns, 'separation_error_estimate', rows%estimates(2))
    call add_reals(columns, 'pressure_error_estimate', rows%estimates(3))
    call add_reals(columns, 'load', rows%ends(1))
    call add_reals(columns, 'separation', rows%ends(2))
    call add_reals(columns, 'area', rows%ends(3))
    call add_reals(columns, 'greatest_pressure', rows%ends(4))
    call add_wholes(columns, 'front', merge(1, 0, rows%on_front))
    call add_wholes(columns, 'reference', merge(1, 0, rows%is_reference))
    call add_words(columns, 'typed', typed)
    call add_words(columns, 'left_out', left_out)
    call write_table(columns, buffer)
  end subroutine write_accuracy_csv

end module asperity_accuracy_table
