!> Contacts in plan on a page: one drawing and one table a position, of its last state.
module asperity_html_plans
  use asperity_contact_records, only: contact_radius, contact_row, position_result, state_row
  use asperity_html_page, only: begin_table, end_table, escaped, put_row, readable
  use asperity_kinds, only: real64
  use asperity_position_lists, only: counted
  use asperity_problems, only: decimal_text
  use asperity_scene_results, only: last_state, scene_results
  use asperity_svg_plot, only: plot_axis, svg_plot
  use asperity_text_buffer, only: text_buffer
  use asperity_unit_names, only: with_unit
  implicit none
  private

  public :: put_plans

  ! A page stays below a megabyte: so many positions, circles, circles that the keyboard stops at,
  ! and rows of tables at most.
  integer, parameter :: most_plans = 100, most_circles = 10000, most_rows = 500, most_stops = 100
  ! The frame is wider than so many of the largest radii.
  real(real64), parameter :: least_width = 10.0_real64
  ! Significant digits of the tables.
  integer, parameter :: digits = 6

contains

  !> The plans of all positions in one scale, as far as there is room; the rest is told.
  subroutine put_plans(results, units, buffer)
    type(scene_results), intent(in) :: results  !! with their contacts
    character(len=*), intent(in) :: units(2)    !! names of length and force, or blank
    type(text_buffer), intent(inout) :: buffer  !! the page
    type(plot_axis) :: across, up
    type(state_row) :: last
    integer :: circles, m, plans, rows, stops

    call find_frame(results, across, up)
    across%name = with_unit('x', units(1))
    up%name = with_unit('y', units(1))
    circles = most_circles
    rows = most_rows
    stops = most_stops
    plans = 0
    do m = 1, size(results%positions)
      last = last_state(results%positions(m))
      if (last%last_row < last%first_row) cycle
      plans = plans + 1
      if (plans > most_plans .or. circles == 0) cycle
      call put_plan(results, m, plans == 1, across, up, circles, rows, stops, buffer)
    end do
    if (plans == 0) call buffer%line('<p>No contact.</p>')
    if (plans > most_plans .or. circles == 0 .or. rows == 0) &
      call buffer%line('<p>The page shows ' // decimal_text(most_plans) // ' positions, ' // &
                       decimal_text(most_circles) // ' contacts and ' // &
                       decimal_text(most_rows) // ' rows of contacts at most, first touched ' // &
                       'first. <code>--contacts FILE</code> writes all.</p>')
  end subroutine put_plans

  ! A frame around the circles of all positions.
  subroutine find_frame(results, across, up)
    type(scene_results), intent(in) :: results
    type(plot_axis), intent(out) :: across, up
    type(state_row) :: last
    real(real64) :: high(2), largest, low(2), radius, room
    integer :: i, m

    low = huge(low)
    high = -huge(high)
    largest = 0.0_real64
    do m = 1, size(results%positions)
      last = last_state(results%positions(m))
      do i = last%first_row, last%last_row
        associate (row => results%positions(m)%rows(i))
          radius = contact_radius(row)
          largest = max(largest, radius)
          low = min(low, [row%x, row%y] - radius)
          high = max(high, [row%x, row%y] + radius)
        end associate
      end do
    end do
    if (any(low > high)) return
    room = max(maxval(high - low), least_width * largest, &
               1.0e-9_real64 * max(maxval(abs(low)), maxval(abs(high))))
    if (.not. room > 0.0_real64) room = 1.0_real64
    do i = 1, 2
      ! A strip, where all stand in a line.
      radius = max(0.0_real64, 0.25_real64 * room - (high(i) - low(i)))
      if (room > high(i) - low(i) .and. least_width * largest >= room) &
        radius = room - (high(i) - low(i))
      low(i) = low(i) - 0.5_real64 * radius - 0.02_real64 * room
      high(i) = high(i) + 0.5_real64 * radius + 0.02_real64 * room
    end do
    across = plot_axis(low=low(1), high=high(1))
    up = plot_axis(low=low(2), high=high(2))
  end subroutine find_frame

  subroutine put_plan(results, m, is_first, across, up, circles, rows, stops, buffer)
    type(scene_results), intent(in) :: results
    integer, intent(in) :: m
    logical, intent(in) :: is_first
    type(plot_axis), intent(in) :: across, up
    integer, intent(inout) :: circles, rows, stops
    type(text_buffer), intent(inout) :: buffer
    type(svg_plot) :: plot
    type(state_row) :: last
    character(len=:), allocatable :: title
    integer :: i, last_circle, last_in_table
    logical :: reached

    last = last_state(results%positions(m))
    last_circle = min(last%last_row, last%first_row + circles - 1)
    last_in_table = min(last%last_row, last%first_row + rows - 1)
    circles = circles - (last_circle - last%first_row + 1)
    rows = rows - (last_in_table - last%first_row + 1)
    reached = last%last_row - last%first_row < stops
    if (reached) stops = stops - (last%last_row - last%first_row + 1)
    title = counted(last%last_row - last%first_row + 1, 'contact') // ', load ' // &
            readable(last%load, digits)
    if (size(results%positions) > 1) title = 'position ' // decimal_text(m) // ': ' // title
    if (size(results%positions) > 1) then
      call buffer%line('<details' // trim(merge(' open="open"', '            ', is_first)) // &
                       '><summary>' // title // '</summary>')
    else
      call buffer%line('<div>')
    end if
    call plot%begin('contacts in plan, ' // title, across, up, buffer, is_true=.true., &
                    is_again=.not. is_first)
    if (.not. reached) call buffer%line('<g class="spot many">')
    do i = last%first_row, last_circle
      associate (row => results%positions(m)%rows(i))
        call plot%circle(row%x, row%y, contact_radius(row), says(row, reached), reached, &
                         buffer)
      end associate
    end do
    if (.not. reached) call buffer%line('</g>')
    call plot%finish(buffer)
    if (last_in_table >= last%first_row) then
      call begin_table('contacts, ' // title, [character(len=16) :: 'area_no', 'x', 'y', &
                       'contact_radius', 'load', 'average_pressure', 'maximum_pressure'], buffer)
      do i = last%first_row, last_in_table
        call put_contact(results%positions(m)%rows(i))
      end do
      call end_table(buffer)
    end if
    call buffer%line(trim(merge('</details>', '</div>    ', size(results%positions) > 1)))

  contains

    subroutine put_contact(row)
      type(contact_row), intent(in) :: row
      real(real64) :: values(6)
      character(len=24) :: cells(7)
      integer :: k

      values = [row%x, row%y, contact_radius(row), row%load, row%average_pressure, &
                row%maximum_pressure]
      cells(1) = decimal_text(row%area_no)
      do k = 1, size(values)
        cells(k + 1) = readable(values(k), digits)
      end do
      call put_row(cells, buffer)
    end subroutine put_contact

  end subroutine put_plan

  ! What a circle says.
  function says(row, at_length) result(text)
    type(contact_row), intent(in) :: row
    logical, intent(in) :: at_length
    character(len=:), allocatable :: text

    text = decimal_text(row%area_no) // ': load ' // readable(row%load, 4)
    if (at_length) text = text // ', radius ' // readable(contact_radius(row), 4) // &
                          ', pressure up to ' // readable(row%maximum_pressure, 4)
  end function says

end module asperity_html_plans
