!> The map and its summits as a table.
module asperity_summits_table
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use asperity_height_map, only: height_map, level_names
  use asperity_kinds, only: int64, real64
  use asperity_library_turn, only: library_turn
  use asperity_map_levelling, only: is_flat
  use asperity_map_statistics, only: map_statistics
  use asperity_map_summits, only: map_summits, rule_contact, rule_names
  use asperity_number_format, only: percent_text
  use asperity_printable, only: printable_text
  use asperity_problems, only: decimal_text, real_text
  use asperity_result_table, only: add_reals, array_table
  use asperity_summit_spheres, only: radius_names
  use asperity_summits_of_file, only: summit_choices
  use asperity_text_buffer, only: text_buffer
  use asperity_unit_names, only: length_power
  implicit none
  private

  public :: add_statistics, write_summits_table

  ! A statistic of a map: its column, its name in the table, its unit as a power of the length, its
  ! value, and column and value of what theory expects of it.
  type :: statistic
    character(len=16) :: column
    character(len=21) :: words
    integer :: power
    real(real64) :: value
    character(len=18) :: expected_column = ''
    real(real64) :: expected = 0.0_real64
  end type statistic

  ! Where the columns begin.
  integer, parameter :: value_column = 25, unit_column = 50, theory_column = 58

contains

  !> The map, its statistics and those of its summits, beside what theory expects.
  subroutine write_summits_table(path, choices, spikes, map, summits, found, buffer)
    character(len=*), intent(in) :: path          !! the file of the map
    type(summit_choices), intent(in) :: choices   !! how it was done
    integer(int64), intent(in) :: spikes          !! removed; less than 0: not searched for
    type(height_map), intent(in) :: map           !! levelled height map
    type(map_summits), intent(in) :: summits      !! of this map
    type(map_statistics), intent(in) :: found     !! statistics of both
    type(text_buffer), intent(inout) :: buffer    !! gets the text
    character(len=:), allocatable :: of_theory, value
    type(statistic) :: rows(15)
    integer :: i
    type(library_turn) :: turn

    call turn%begin()
    call buffer%line(printable_text(path) // ': ' // decimal_text(map%columns) // ' x ' // &
                     decimal_text(map%rows) // ' pixels, level: ' // &
                     trim(level_names(choices%level)) // ', rule: ' // &
                     trim(rule_names(choices%rule)) // ', radius: ' // &
                     trim(radius_names(choices%radius)) // &
                     trim(merge(', edge: periodic', '                ', map%periodic)))
    if (is_flat(map)) call buffer%line('The map is flat: its heights differ by rounding alone.')
    call buffer%line('')
    call put_count('samples', found%samples)
    call put_count('missing', found%missing)
    if (found%missing > 0_int64) &
      call put_line('slopes left out', percent_text(found%slopes_left_out), '', '', buffer)
    if (spikes >= 0_int64) call put_count('spikes removed', spikes)
    call put_count('summits', size(summits%x, kind=int64))
    if (choices%rule == rule_contact) call put_count('  on ridges', int(summits%on_ridges, int64))
    call buffer%line('')
    call put_line('', '', '', 'Nayak expects', buffer)
    rows = statistics_of(map, found)
    do i = 1, size(rows)
      value = '-'
      if (.not. ieee_is_nan(rows(i)%value)) value = real_text(rows(i)%value, 'es22.14e3')
      of_theory = ''
      if (rows(i)%expected_column /= '' .and. .not. ieee_is_nan(found%alpha)) &
        of_theory = real_text(rows(i)%expected, 'es12.4e3')
      call put_line(trim(rows(i)%words), value, length_power(map%unit, rows(i)%power), of_theory, &
                    buffer)
    end do

  contains

    subroutine put_count(name, value)
      character(len=*), intent(in) :: name
      integer(int64), intent(in) :: value

      call put_line(name, decimal_text(value), '', '', buffer)
    end subroutine put_count

  end subroutine write_summits_table

  !> Adds the statistics of a map to a table, a column each.
  subroutine add_statistics(map, found, table)
    type(height_map), intent(in) :: map        !! levelled height map
    type(map_statistics), intent(in) :: found  !! statistics of map and summits
    type(array_table), intent(inout) :: table  !! table without columns
    type(statistic) :: rows(15)
    integer :: i

    rows = statistics_of(map, found)
    call add_reals(table, 'samples', [real(found%samples, real64)])
    call add_reals(table, 'missing', [real(found%missing, real64)])
    call add_reals(table, 'slopes_left_out', [found%slopes_left_out])
    do i = 1, size(rows)
      call add_reals(table, trim(rows(i)%column), [rows(i)%value], &
                     length_power(map%unit, rows(i)%power))
    end do
    do i = 1, size(rows)
      if (rows(i)%expected_column /= '') &
        call add_reals(table, trim(rows(i)%expected_column), [rows(i)%expected], &
                       length_power(map%unit, rows(i)%power))
    end do
  end subroutine add_statistics

  ! All statistics, in the order of the table.
  function statistics_of(map, found) result(rows)
    type(height_map), intent(in) :: map
    type(map_statistics), intent(in) :: found
    type(statistic) :: rows(15)

    rows = [statistic('spacing_x', 'spacing along x', 1, map%pixel_spacing(1)), &
            statistic('spacing_y', 'spacing along y', 1, map%pixel_spacing(2)), &
            statistic('rms_height', 'rms height', 1, found%rms_height), &
            statistic('rms_slope', 'rms slope', 0, found%rms_slope), &
            statistic('m0', 'm0', 2, found%m0), &
            statistic('m2_x', 'm2 along x', 0, found%m2(1)), &
            statistic('m2_y', 'm2 along y', 0, found%m2(2)), &
            statistic('m4_x', 'm4 along x', -2, found%m4(1)), &
            statistic('m4_y', 'm4 along y', -2, found%m4(2)), &
            statistic('alpha', 'Nayak''s alpha', 0, found%alpha), &
            statistic('density', 'density of summits', -2, found%density, &
                      'expected_density', found%expected_density), &
            statistic('mean_height', 'mean summit height', 1, found%mean_height, &
                      'expected_height', found%expected_height), &
            statistic('height_deviation', 'deviation of heights', 1, found%height_deviation, &
                      'expected_deviation', found%expected_deviation), &
            statistic('mean_curvature', 'mean summit curvature', -1, found%mean_curvature, &
                      'expected_curvature', found%expected_curvature), &
            statistic('mean_radius', 'mean summit radius', 1, found%mean_radius)]
  end function statistics_of

  ! A line of the table; numbers with a sign begin one column earlier.
  subroutine put_line(name, value, unit, theory, buffer)
    character(len=*), intent(in) :: name, value, unit, theory
    type(text_buffer), intent(inout) :: buffer
    character(len=80) :: line

    line = name
    line(value_column + merge(0, 1, index(value, '-') == 1):) = value
    line(unit_column:) = unit
    line(theory_column + merge(0, 1, index(theory, '-') == 1):) = theory
    call buffer%line(line)
  end subroutine put_line

end module asperity_summits_table
