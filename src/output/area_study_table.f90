!> The study of the representative area as a table and as CSV.
module asperity_area_study_table
  use asperity_area_study, only: area_study, size_result
  use asperity_csv_tables, only: write_table
  use asperity_greenwood_integrals, only: quantities
  use asperity_kinds, only: real64
  use asperity_number_format, only: number_text
  use asperity_problems, only: decimal_text, real_text
  use asperity_result_table, only: add_reals, add_wholes, add_words, array_table
  use asperity_study_spec, only: against_plane, reference_integral, study_spec
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: write_area_table, write_area_csv

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
    character(len=:), allocatable :: against, integral, lower
    character(len=160) :: line
    integer :: i, q

    against = 'pairs of rough surfaces'
    integral = 'Greenwood-Tripp'
    lower = ', lower ' // number_text(study%density(2)) // ' (' // &
            number_text(study%design_density(2)) // ')'
    if (spec%against == against_plane) then
      against = 'rough surfaces against a plane'
      integral = 'Greenwood-Williamson'
      lower = ''
    end if
    call buffer%line(decimal_text(study%surfaces) // ' ' // against // ', separation ' // &
                     number_text(study%separation))
    call buffer%line('studied: x from ' // number_text(study%corner(1)) // ' to ' // &
                     number_text(study%corner(1) + study%extent(1)) // ', y from ' // &
                     number_text(study%corner(2)) // ' to ' // &
                     number_text(study%corner(2) + study%extent(2)))
    call buffer%line('asperities per area, found (design): upper ' // &
                     number_text(study%density(1)) // ' (' // &
                     number_text(study%design_density(1)) // ')' // lower)
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
    call write_verdict(spec, study, buffer)

  end subroutine write_area_table

  !> The representative size.
  subroutine write_verdict(spec, study, buffer)
    type(study_spec), intent(in) :: spec
    type(area_study), intent(in) :: study
    type(text_buffer), intent(inout) :: buffer
    character(len=:), allocatable :: reference, least
    integer :: i

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
  end subroutine write_verdict

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

end module asperity_area_study_table
