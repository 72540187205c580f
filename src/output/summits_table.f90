!> The map and its summits as a table.
module asperity_summits_table
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use asperity_height_map, only: height_map, level_names
  use asperity_kinds, only: int64, real64
  use asperity_map_levelling, only: is_flat
  use asperity_map_statistics, only: map_statistics
  use asperity_map_summits, only: map_summits, rule_contact, rule_names
  use asperity_number_format, only: percent_text
  use asperity_printable, only: printable_text
  use asperity_problems, only: decimal_text, real_text
  use asperity_summit_spheres, only: radius_names
  use asperity_summits_of_file, only: summit_choices
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: write_summits_table

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
    call put_value('spacing along x', map%pixel_spacing(1), 1)
    call put_value('spacing along y', map%pixel_spacing(2), 1)
    call put_value('rms height', found%rms_height, 1)
    call put_value('rms slope', found%rms_slope, 0)
    call put_value('m0', found%m0, 2)
    call put_value('m2 along x', found%m2(1), 0)
    call put_value('m2 along y', found%m2(2), 0)
    call put_value('m4 along x', found%m4(1), -2)
    call put_value('m4 along y', found%m4(2), -2)
    call put_value('Nayak''s alpha', found%alpha, 0)
    call put_value('density of summits', found%density, -2, found%expected_density)
    call put_value('mean summit height', found%mean_height, 1, found%expected_height)
    call put_value('deviation of heights', found%height_deviation, 1, found%expected_deviation)
    call put_value('mean summit curvature', found%mean_curvature, -1, found%expected_curvature)
    call put_value('mean summit radius', found%mean_radius, 1)

  contains

    subroutine put_count(name, value)
      character(len=*), intent(in) :: name
      integer(int64), intent(in) :: value

      call put_line(name, decimal_text(value), '', '', buffer)
    end subroutine put_count

    ! A value in a power of the unit of length, and what theory expects.
    subroutine put_value(name, value, power, theory)
      character(len=*), intent(in) :: name
      real(real64), intent(in) :: value
      integer, intent(in) :: power
      real(real64), intent(in), optional :: theory
      character(len=:), allocatable :: expected, unit

      expected = ''
      if (present(theory) .and. .not. ieee_is_nan(found%alpha)) &
        expected = real_text(theory, 'es12.4e3')
      unit = map%unit
      if (power == 0) unit = ''
      if (abs(power) == 2 .and. unit /= '') unit = unit // '2'
      if (power < 0 .and. unit /= '') unit = '1/' // unit
      if (ieee_is_nan(value)) then
        call put_line(name, '-', unit, expected, buffer)
      else
        call put_line(name, real_text(value, 'es22.14e3'), unit, expected, buffer)
      end if
    end subroutine put_value

  end subroutine write_summits_table

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
