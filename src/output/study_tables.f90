!> Studies in print: the representative area as a table and as CSV; the error budget, plus-or-minus
!> of every total by source; Table VI of the thesis before and after its corrections.
module asperity_study_tables
  use asperity_area_study, only: area_study, size_result
  use asperity_corrected_table, only: corrected_table, stage_name
  use asperity_csv_tables, only: write_table
  use asperity_error_budget, only: budget_line, error_budget, of_approach, of_area, of_load, &
                                   share_given, share_measured, share_unknown
  use asperity_greenwood_integrals, only: quantities
  use asperity_kinds, only: real64
  use asperity_number_format, only: number_text
  use asperity_original_records, only: approach_row, individual_difference_row, points_row, &
                                       slope_row, total_area_row, total_difference_row, &
                                       total_load_row
  use asperity_problems, only: decimal_text, real_text
  use asperity_result_table, only: add_reals, add_wholes, add_words, array_table
  use asperity_scene_values, only: effect_boundary, effect_words
  use asperity_study_spec, only: against_plane, reference_integral, study_spec
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: write_area_csv, write_area_table, write_budget, write_corrected_table

  character(len=*), parameter :: names(quantities) = [character(len=13) :: &
    'contacts', 'area', 'load', 'vertical_load']
  character(len=*), parameter :: headings(quantities) = [character(len=13) :: &
    'contacts', 'contact area', 'load', 'vertical load']

contains

  !> The summary for a reader.
  subroutine write_area_table(spec, study, buffer)
    type(study_spec), intent(in) :: spec        !! specification of the study
    type(area_study), intent(in) :: study       !! results of the study
    type(text_buffer), intent(inout) :: buffer  !! gets the text
    character(len=:), allocatable :: against, integral, least, lower, reference
    character(len=160) :: line
    integer :: i, q

    against = 'pairs of rough surfaces'
    integral = 'Greenwood-Tripp'
    lower = ', lower ' // number_text(study%density(2)) // ' (' // &
            number_text(study%plan%law%density(2)) // ')'
    if (spec%against == against_plane) then
      against = 'rough surfaces against a plane'
      integral = 'Greenwood-Williamson'
      lower = ''
    end if
    call buffer%line(decimal_text(study%surfaces) // ' ' // against // ', separation ' // &
                     number_text(study%separation))
    call buffer%line('studied: x from ' // number_text(study%plan%corner(1)) // ' to ' // &
                     number_text(study%plan%corner(1) + study%plan%extent(1)) // ', y from ' // &
                     number_text(study%plan%corner(2)) // ' to ' // &
                     number_text(study%plan%corner(2) + study%plan%extent(2)))
    call buffer%line('asperities per area, found (design): upper ' // &
                     number_text(study%density(1)) // ' (' // &
                     number_text(study%plan%law%density(1)) // ')' // lower)
    do q = 1, quantities
      call buffer%line('')
      call buffer%line(trim(headings(q)) // ' per area')
      call buffer%line('       size  sections         mean  std error     from integral' // &
                       ' std deviation  within ' // two_decimals(spec%tolerance))
      do i = 1, size(study%sizes)
        associate (row => study%sizes(i))
          write (line, '(a12, i9, a13, a11, a18, a14, a12)') number_text(row%side), row%sections, &
            number_text(row%mean(q)), two_decimals(row%error(q) / row%mean(q)), &
            from_integral(study, row, q), two_decimals(row%deviation(q) / row%mean(q)), &
            two_decimals(row%within(q))
        end associate
        call buffer%line(line)
      end do
      write (line, '(a21, a13)') integral, number_text(study%integral(q))
      call buffer%line(line)
      if (spec%against /= against_plane) then
        write (line, '(a21, a13)') 'shallow contacts only', number_text(study%shallow(q))
        call buffer%line(line)
      end if
    end do
    call buffer%line('')
    reference = 'the integral'
    if (spec%reference /= reference_integral) reference = 'the mean of the largest size'
    call buffer%line('sections within ' // two_decimals(spec%tolerance) // ' of ' // reference // &
                     ' in everything:')
    do i = 1, size(study%sizes)
      call buffer%line('  size ' // number_text(study%sizes(i)%side) // '  ' // &
                       two_decimals(study%sizes(i)%all_within))
    end do
    least = 'none of these sizes'
    if (study%representative > 0) least = number_text(study%sizes(study%representative)%side)
    call buffer%line('representative size (' // two_decimals(spec%confidence) // &
                     ' of the sections): ' // least)
    call buffer%line('estimate by the spread: ' // number_text(study%estimated_side))
  end subroutine write_area_table

  !> How far a mean is from the integral, in percent and in standard errors.
  pure function from_integral(study, row, q) result(text)
    type(area_study), intent(in) :: study
    type(size_result), intent(in) :: row
    integer, intent(in) :: q
    character(len=18) :: text
    real(real64) :: away

    text = '-'
    away = row%mean(q) - study%integral(q)
    if (.not. (study%integral(q) > 0.0_real64 .and. row%error(q) > 0.0_real64)) return
    if (abs(away) < 10 * study%integral(q) .and. abs(away) < 1000 * row%error(q)) then
      write (text, '(sp, f8.3, "%", f6.1)') 100 * away / study%integral(q), away / row%error(q)
    else
      text = real_text(100 * (away / study%integral(q)), 'sp, es8.0e2') // '% ' // &
             real_text(away / row%error(q), 'sp, es7.0e2')
    end if
  end function from_integral

  !> All numbers, a line a size and quantity.
  subroutine write_area_csv(study, buffer)
    type(area_study), intent(in) :: study       !! results of the study
    type(text_buffer), intent(inout) :: buffer  !! gets the text
    type(array_table) :: table
    integer :: i, q, rows

    rows = quantities * size(study%sizes)
    associate (sizes => study%sizes)
      call add_reals(table, 'size', each_quantity(sizes%side))
      call add_words(table, 'quantity', [(names, i=1, size(sizes))])
      call add_wholes(table, 'surfaces', spread(study%surfaces, 1, rows))
      call add_wholes(table, 'sections', nint(each_quantity(real(sizes%sections, real64))))
      call add_reals(table, 'mean', [(sizes(i)%mean, i=1, size(sizes))])
      call add_reals(table, 'deviation', [(sizes(i)%deviation, i=1, size(sizes))])
      call add_reals(table, 'standard_error', [(sizes(i)%error, i=1, size(sizes))])
      call add_reals(table, 'integral', [(study%integral, i=1, size(sizes))])
      call add_reals(table, 'shallow_integral', [(study%shallow, i=1, size(sizes))])
      call add_reals(table, 'reference', [(study%reference, i=1, size(sizes))])
      call add_reals(table, 'within', [(sizes(i)%within, i=1, size(sizes))])
      call add_reals(table, 'all_within', each_quantity(sizes%all_within))
      call add_reals(table, 'separation', spread(study%separation, 1, rows))
      call add_reals(table, 'upper_density', spread(study%density(1), 1, rows))
      call add_reals(table, 'lower_density', spread(study%density(2), 1, rows))
      call add_wholes(table, 'representative', [((merge(1, 0, i == study%representative), &
                                                  q=1, quantities), i=1, size(sizes))])
      call add_reals(table, 'estimated_size', spread(study%estimated_side, 1, rows))
    end associate
    call write_table(table, buffer)

  contains

    ! A value of each size, for all its quantities.
    pure function each_quantity(values) result(repeated)
      real(real64), intent(in) :: values(:)
      real(real64) :: repeated(quantities * size(values))

      repeated = reshape(spread(values, 1, quantities), shape(repeated))
    end function each_quantity

  end subroutine write_area_csv

  !> A share in percent.
  pure function two_decimals(share) result(text)
    real(real64), intent(in) :: share
    character(len=:), allocatable :: text

    text = '-'
    if (abs(share) < 1.0e4_real64) text = real_text(100 * share, 'f12.2') // '%'
  end function two_decimals

  !> One line a total, and what the columns mean.
  subroutine write_budget(budget, positions, buffer)
    type(error_budget), intent(in) :: budget    !! what was measured
    integer, intent(in) :: positions            !! number of positions
    type(text_buffer), intent(inout) :: buffer  !! gets the text
    type(budget_line) :: total
    character(len=100) :: line
    character(len=:), allocatable :: reference, share
    integer :: i

    call buffer%line('')
    if (positions == 1) then
      call buffer%line('Error budget            value   arithmetic +-         step +-  model +-')
    else
      call buffer%line('Error budget          average   arithmetic +-         step +-  model +-')
    end if
    do i = 1, size(budget%lines)
      total = budget%lines(i)
      share = 'not estimated'
      if (budget%model%known(i) == share_measured) &
        share = ' ' // real_text(budget%model%error(i), 'es9.1e3')
      if (budget%model%known(i) == share_given) share = 'given'
      write (line, '(2x, a14, a15, es14.1e3, es16.1e3, 4x, a)') total%name, &
        real_text(total%value, 'g15.7') // '   ', total%arithmetic, total%step, share
      call buffer%line(line)
    end do
    if (positions > 1) call buffer%line('+- is the largest over the positions.')
    reference = 'bound of the rounding of real64'
    if (budget%without_effects) reference = reference // ', without effects'
    call buffer%line('Arithmetic: ' // reference // '.')
    call buffer%line('Step: none, as events are solved exactly.')
    ! The models that were compared, and the error of the reference.
    associate (model => budget%model)
      if (allocated(model%why_not)) then
        call buffer%line('Model: not estimated: ' // model%why_not // '.')
      else if (model%interaction == effect_boundary) then
        call buffer%line('Model: interaction ''boundary'' is the reference.')
      else
        call buffer%line('Model: interaction ''' // trim(effect_words(model%interaction)) // &
                         ''' against ''boundary'' at the same separation, by the load of')
        call buffer%line('all contacts over their load as isolated contacts, so that both ' // &
                         'include the inclination.')
      end if
      if (.not. allocated(model%why_not)) &
        call buffer%line('Load by boundary elements: relative error ' // &
                         real_text(model%cells_are_good_to, 'es9.1e3') // ' (boundary_tolerance).')
      if (model%known(of_area) == share_measured) &
        call buffer%line('Area: compared in plan; boundary elements with a rim correction, ' // &
                         'relative error about 0.3 %.')
      if (model%known(of_load) /= share_given .and. model%known(of_approach) == share_given) &
        call buffer%line('Separation: given, or that at which an isolated contact reaches ' // &
                         'its limit.')
      if (model%known(of_load) == share_given .and. model%known(of_approach) == share_measured) &
        call buffer%line('Separation: its change by the error of the model at the given load.')
      if (allocated(model%why_not) .or. all(model%known /= share_unknown)) return
      if (model%interaction == effect_boundary) then
        call buffer%line('Not estimated: no finer model to compare boundary elements with.')
      else
        call buffer%line('Not estimated: at a given load the areas of the two models belong ' // &
                         'to different separations.')
      end if
    end associate
  end subroutine write_budget

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

end module asperity_study_tables
