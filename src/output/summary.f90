!> What `asperity solve` prints: a short readable summary.
module asperity_summary
  use asperity_contact_records, only: state_row
  use asperity_corrected_table, only: corrected_table, stage_name
  use asperity_effect_names, only: known_effects
  use asperity_effects_summary, only: effects_in_words, write_effects
  use asperity_kinds, only: not_computed, real64
  use asperity_original_records, only: approach_row, individual_difference_row, points_row, &
                                       slope_row, total_area_row, total_difference_row, &
                                       total_load_row
  use asperity_position_lists, only: counted, percent, positions_listed
  use asperity_problems, only: decimal_text, real_text
  use asperity_scene_results, only: last_state, map_record, scene_results
  use asperity_scene_values, only: control_limit, control_words, criterion_none, criterion_words, &
                                   effect_off, scene, scene_map
  use asperity_text_buffer, only: text_buffer
  use asperity_totals_table, only: write_totals
  use asperity_unit_names, only: has_units, units_in_words
  implicit none
  private

  public :: write_summary, write_heading, write_remarks, write_corrected_table, write_choice, &
            write_map_table, uses_samples

contains

  !> The scene, how it was solved, and the totals over its positions.
  subroutine write_summary(scene_in, results, buffer)
    type(scene), intent(in) :: scene_in         !! what was solved
    type(scene_results), intent(in) :: results  !! its results
    type(text_buffer), intent(inout) :: buffer  !! the text

    call write_heading(scene_in, results, buffer)
    call buffer%line('')
    call write_totals(results, buffer)
    call buffer%line('')
    call write_remarks(scene_in, results, buffer)
    call write_effects(results, buffer)
    if (allocated(results%map)) call write_map_table(results%map, .not. uses_samples(results), &
                                                     buffer)
  end subroutine write_summary

  !> What was solved and how, in three lines, and the units where they have names.
  subroutine write_heading(scene_in, results, buffer)
    type(scene), intent(in) :: scene_in         !! what was solved
    type(scene_results), intent(in) :: results  !! its results
    type(text_buffer), intent(inout) :: buffer  !! the text

    call buffer%line(scene_in%file // ': ' // surfaces_in_words(scene_in) // ', ' // &
                     counted(size(results%positions), 'position'))
    call buffer%line('solved in ' // trim(results%arithmetic) // ', exact events, effects: ' // &
                     effects_in_words(results))
    call buffer%line('control: ' // trim(control_words(scene_in%loading%control)) // &
                     limit_text(scene_in))
    if (has_units(scene_in)) call buffer%line('units: ' // units_in_words(scene_in))
  end subroutine write_heading

  !> What the totals do not tell: limits reached, positions without contact, circles that overlap.
  subroutine write_remarks(scene_in, results, buffer)
    type(scene), intent(in) :: scene_in         !! what was solved
    type(scene_results), intent(in) :: results  !! its results
    type(text_buffer), intent(inout) :: buffer  !! the text
    type(state_row) :: last
    integer :: m, without

    without = 0
    do m = 1, size(results%positions)
      last = last_state(results%positions(m))
      if (last%contacts == 0) without = without + 1
    end do
    if (asks_for_limit(scene_in) .or. any(results%positions%limit_reached)) &
      call buffer%line('limit reached at ' // &
                       decimal_text(count(results%positions%limit_reached)) // ' of ' // &
                       counted(size(results%positions), 'position'))
    if (without > 0) call buffer%line('no contact at ' // counted(without, 'position'))
    if (any(results%positions%overlapping_circles > 0)) &
      call buffer%line(overlap_text(results%positions%overlapping_circles, &
                                    scene_in%effects%mode('interaction') == effect_off))
  end subroutine write_remarks

  ! How many asperities there are, or on what plane.
  function surfaces_in_words(scene_in) result(text)
    type(scene), intent(in) :: scene_in
    character(len=:), allocatable :: text

    if (allocated(scene_in%map)) then
      text = maps_in_words(scene_in%map)
    else if (scene_in%upper%is_plane) then
      text = 'upper plane on ' // decimal_text(size(scene_in%lower%x)) // ' lower asperities'
    else if (scene_in%lower%is_plane) then
      text = decimal_text(size(scene_in%upper%x)) // ' upper asperities on lower plane'
    else
      text = decimal_text(size(scene_in%upper%x)) // ' upper and ' // &
             decimal_text(size(scene_in%lower%x)) // ' lower asperities'
    end if
  end function surfaces_in_words

  ! The maps and their samples.
  pure function maps_in_words(maps) result(text)
    type(scene_map), intent(in) :: maps
    character(len=:), allocatable :: text

    associate (columns => max(maps%upper%columns, maps%lower%columns), &
               rows => max(maps%upper%rows, maps%lower%rows))
      text = decimal_text(columns) // ' x ' // decimal_text(rows) // ' samples'
    end associate
    if (min(maps%upper%columns, maps%lower%columns) > 0) then
      text = 'the sum of two maps of ' // text // ' under a plane'
    else
      text = 'a map of ' // text // ' and a plane'
    end if
    if (maps%periodic) text = text // ', repeated'
  end function maps_in_words

  !> Whether the results are those of the samples of a map.
  pure logical function uses_samples(results) result(uses)
    type(scene_results), intent(in) :: results  !! solved

    uses = .false.
    if (allocated(results%effects)) uses = any(results%effects%state_columns == 'sample_area')
  end function uses_samples

  !> Table VI before and after, one line a number, with what each correction adds.
  subroutine write_corrected_table(table, buffer)
    type(corrected_table), intent(in) :: table  !! both versions and the changes
    type(text_buffer), intent(inout) :: buffer  !! the text
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
      call buffer%line('no Table VI to correct: the original stops at ' // table%why_not)
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
      character(len=:), allocatable :: reason
      character(len=57) :: line
      integer :: places, stage

      places = decimals
      ! The original cuts the average number of points to a whole one.
      if (row == points_row .and. column == 3) places = 2
      before = fixed(table%historic(row, column), decimals)
      after = fixed(table%corrected(row, column), places)
      reason = ''
      if (abs(table%historic(row, column)) > after_division_by_zero) then
        reason = 'no contact at its limit: the original divided by zero'
      else if (fixed(table%historic(row, column), places) /= after) then
        do stage = 1, size(table%change, 3)
          if (abs(table%change(row, column, stage)) < 0.5_real64 * 10.0_real64**(-places)) cycle
          if (reason /= '') reason = reason // ', '
          reason = reason // stage_name(table, stage, row) // ' ' // &
                   signed(table%change(row, column, stage), places)
        end do
        if (reason == '') reason = 'changes below half a printed unit add up'
      end if
      write (line, '(2x, a20, 1x, a7, 3x, 2a11)') name, columns(column), &
        before, after
      call buffer%line(line // reason)
    end subroutine number_line

  end subroutine write_corrected_table

  !> Which way of computing was chosen for the accuracy asked for.
  subroutine write_choice(accuracy, results, buffer)
    real(real64), intent(in) :: accuracy        !! asked for, relative
    type(scene_results), intent(in) :: results  !! the way taken and its error bound
    type(text_buffer), intent(inout) :: buffer  !! the text
    character(len=9) :: asked, promised
    character(len=:), allocatable :: off
    real(real64) :: share
    integer :: e

    write (asked, '(es9.1e3)') accuracy
    write (promised, '(es9.1e3)') results%error_bound
    off = ''
    do e = 1, size(known_effects)
      share = maxval(results%positions%left_out(e))
      if (share > not_computed) off = off // ' (' // trim(known_effects(e)%name) // &
                                      ' off, estimated influence ' // percent(share) // ')'
    end do
    call buffer%line('accuracy' // asked // ' asked for: ' // results%way_taken // &
                     ' is the cheapest way that has it, ' // &
                     trim(merge('estimated error', 'error bound    ', &
                                allocated(results%effects))) // promised // off)
    call buffer%line(results%way_told)
  end subroutine write_choice

  !> A number with so many decimals, right-justified.
  pure function fixed(value, decimals) result(text)
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
  end function fixed

  !> A change with its sign.
  pure function signed(value, decimals) result(text)
    real(real64), intent(in) :: value
    integer, intent(in) :: decimals
    character(len=:), allocatable :: text

    text = real_text(value, 'sp, es24.3e3')
    if (abs(value) < 10.0_real64**(14 - max(decimals, 1))) &
      text = real_text(value, 'sp, f16.' // decimal_text(max(decimals, 1)))
  end function signed

  !> Where contact circles overlap, as a warning.
  pure function overlap_text(circles, independent) result(text)
    integer, intent(in) :: circles(:)
    logical, intent(in) :: independent  !! neighbours were not counted
    character(len=:), allocatable :: text

    text = counted(sum(circles), 'pair') // ' of contact circles overlap'
    if (sum(circles) == 1) text = text // 's'
    if (size(circles) > 1) text = text // ', at positions ' // positions_listed(circles > 0)
    if (independent) text = text // ': contacts there are not independent'
  end function overlap_text

  ! Whether the scene names a limit or goes to one. A deck brings one that may not be meant.
  pure logical function asks_for_limit(scene_in) result(asks)
    type(scene), intent(in) :: scene_in

    asks = scene_in%limit%criterion /= criterion_none .and. &
           (scene_in%loading%control == control_limit .or. .not. scene_in%limit%from_thesis)
  end function asks_for_limit

  !> The limit's criterion in words.
  pure function limit_text(scene_in) result(text)
    type(scene), intent(in) :: scene_in
    character(len=:), allocatable :: text

    text = ''
    if (asks_for_limit(scene_in)) &
      text = ', limit by ' // trim(criterion_words(scene_in%limit%criterion))
  end function limit_text

  !> Appends the comparison.
  subroutine write_map_table(record, used, buffer)
    type(map_record), intent(in) :: record      !! how they compare
    logical, intent(in) :: used                 !! the results are those of the summits
    type(text_buffer), intent(inout) :: buffer  !! the text

    call buffer%line('')
    call buffer%line('Summits against the map itself at this load, ' // resolution(record))
    call buffer%line('  summits            ' // decimal_text(record%summits))
    call buffer%line('  separation         ' // with_sign(record%difference) // ' rms heights off')
    if (record%coarser > 1) &
      call buffer%line('                     give or take ' // with_sign(record%uncertain))
    if (record%coarser == 1) &
      call buffer%line('  contact area       ' // with_sign(100 * record%area_difference) // &
                       ' % off')
    if (record%stiffness_difference > not_computed) &
      call buffer%line('  contact stiffness  ' // with_sign(100 * record%stiffness_difference) // &
                       ' % off')
    associate (shares => record%shares)
      call buffer%line('  load of the map on the edge ' // real_text(100 * shares%on_edge, 'f6.1') &
                       // ' %, on spots without a summit ' // &
                       real_text(100 * shares%without_summit, 'f6.1') // ' %')
      call buffer%line('  on scan lines ' // real_text(100 * shares%on_lines, 'f6.1') // &
                       ' %, on outliers ' // real_text(100 * shares%on_spikes, 'f6.1') // ' %')
    end associate
    if (.not. used) call buffer%line('  not good enough: the results are those of the samples')
  end subroutine write_map_table

  ! On how fine a map.
  pure function resolution(record) result(text)
    type(map_record), intent(in) :: record
    character(len=:), allocatable :: text

    text = 'all its samples'
    if (record%coarser > 1) text = 'one of ' // decimal_text(record%coarser) // ' x ' // &
                                   decimal_text(record%coarser) // ' samples'
  end function resolution

  pure function with_sign(number) result(text)
    real(real64), intent(in) :: number
    character(len=:), allocatable :: text

    text = real_text(number, 'sp, f10.3')
    if (abs(number) > 9.0e4_real64) text = real_text(number, 'es12.3e3')
  end function with_sign

end module asperity_summary
