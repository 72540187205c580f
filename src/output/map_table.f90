!> What `asperity solve` prints of a map: how its summits compare with the map itself.
module asperity_map_table
  use asperity_kinds, only: not_computed, real64
  use asperity_problems, only: decimal_text
  use asperity_scene_results, only: map_record
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: write_map_table

contains

  !> Appends the comparison.
  subroutine write_map_table(record, used, buffer)
    type(map_record), intent(in) :: record      !! how they compare
    logical, intent(in) :: used                 !! the results are those of the summits
    type(text_buffer), intent(inout) :: buffer  !! the text

    call buffer%line('')
    call buffer%line('Summits against the map itself at this load, ' // resolution(record))
    call buffer%line('  summits            ' // decimal_text(record%summits))
    call buffer%line('  separation         ' // signed(record%difference) // ' rms heights off')
    if (record%coarser > 1) &
      call buffer%line('                     give or take ' // signed(record%uncertain))
    if (record%coarser == 1) &
      call buffer%line('  contact area       ' // signed(100 * record%area_difference) // ' % off')
    if (record%stiffness_difference > not_computed) &
      call buffer%line('  contact stiffness  ' // signed(100 * record%stiffness_difference) // &
                       ' % off')
    call buffer%line('  load of the map on the edge ' // share(record%shares%on_edge) // &
                     ', on spots without a summit ' // share(record%shares%without_summit))
    call buffer%line('  on scan lines ' // share(record%shares%on_lines) // ', on outliers ' // &
                     share(record%shares%on_spikes))
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

  pure function signed(number) result(text)
    real(real64), intent(in) :: number
    character(len=:), allocatable :: text
    character(len=12) :: digits

    write (digits, '(sp, f10.3)') number
    if (abs(number) > 9.0e4_real64) write (digits, '(es12.3e3)') number
    text = trim(adjustl(digits))
  end function signed

  pure function share(part) result(text)
    real(real64), intent(in) :: part
    character(len=:), allocatable :: text
    character(len=8) :: digits

    write (digits, '(f6.1, " %")') 100 * part
    text = trim(adjustl(digits))
  end function share

end module asperity_map_table
