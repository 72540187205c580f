!> A run as one page that opens anywhere: totals, load against approach, contacts in plan, what the
!> effects did and why, warnings, the scene's text. It loads nothing and runs nothing.
module asperity_results_html
  use asperity_contact_records, only: state_row
  use asperity_effects_summary, only: list_effects, told_line
  use asperity_effect_names, only: known_effects
  use asperity_html_page, only: begin_page, begin_section, begin_table, end_page, end_section, &
                                end_table, escaped, put_lines, put_row, readable
  use asperity_html_plans, only: put_plans
  use asperity_kinds, only: real64
  use asperity_problems, only: decimal_text, problem_list
  use asperity_scene_inputs, only: input_file
  use asperity_scene_results, only: kinds_of_warnings, last_state, scene_results
  use asperity_scene_values, only: scene
  use asperity_summary, only: uses_samples, write_heading, write_map_table, write_remarks
  use asperity_svg_plot, only: axis_over, svg_plot
  use asperity_text_buffer, only: text_buffer
  use asperity_totals_table, only: list_totals, total_line
  use asperity_unit_names, only: with_unit
  use asperity_version, only: version
  implicit none
  private

  public :: write_html

  ! A page stays below a megabyte: so many rows of a table, curves, and points of all of them.
  integer, parameter :: most_rows = 500, most_curves = 100, most_points = 4000
  ! Points of a drawing that say what they are.
  integer, parameter :: most_dots = 200
  ! Significant digits of the tables.
  integer, parameter :: digits = 6

contains

  !> The whole page.
  subroutine write_html(scene_in, inputs, results, warnings, buffer)
    type(scene), intent(in) :: scene_in          !! what was solved
    type(input_file), intent(in) :: inputs(3)    !! the files that it is made of
    type(scene_results), intent(in) :: results   !! with their contacts
    type(problem_list), intent(in) :: warnings   !! a line a kind
    type(text_buffer), intent(inout) :: buffer   !! the page
    type(text_buffer) :: text, map_text

    call begin_page(scene_in%file, buffer)
    call write_heading(scene_in, results, text)
    call put_paragraphs(text%text(), '', buffer)
    if (warnings%count() > 0) then
      call begin_section('warnings', 'Warnings', buffer)
      call put_paragraphs(warnings%text(), ' class="warn"', buffer)
      call end_section(buffer)
    end if
    call begin_section('summary', 'Summary', buffer)
    call put_totals(scene_in, results, buffer)
    call end_section(buffer)
    call begin_section('effects', 'Effects', buffer)
    call put_effects(results, buffer)
    if (allocated(results%map)) then
      call write_map_table(results%map, .not. uses_samples(results), map_text)
      call put_lines('summits against the map', map_text%text(), buffer)
    end if
    call end_section(buffer)
    call begin_section('load', 'Load against approach', buffer)
    call put_curves(results, scene_in%units, buffer)
    call end_section(buffer)
    if (size(results%positions) > 1) then
      call begin_section('positions', 'Positions', buffer)
      call put_positions(results, scene_in%units(2), buffer)
      call end_section(buffer)
    end if
    call begin_section('contacts', 'Contacts in plan', buffer)
    call put_plans(results, scene_in%units, buffer)
    call end_section(buffer)
    call begin_section('origin', 'Where this comes from', buffer)
    call put_origin(scene_in, inputs, results, buffer)
    call end_section(buffer)
    call end_page(buffer)
  end subroutine write_html

  ! A paragraph a line.
  subroutine put_paragraphs(lines, attributes, buffer)
    character(len=*), intent(in) :: lines, attributes
    type(text_buffer), intent(inout) :: buffer
    integer :: first, last

    first = 1
    do while (first <= len(lines))
      last = first + index(lines(first:), new_line('a')) - 2
      call buffer%line('<p' // attributes // '>' // escaped(lines(first:last)) // '</p>')
      first = last + 2
    end do
  end subroutine put_paragraphs

  subroutine put_totals(scene_in, results, buffer)
    type(scene), intent(in) :: scene_in
    type(scene_results), intent(in) :: results
    type(text_buffer), intent(inout) :: buffer
    type(total_line), allocatable :: lines(:)
    type(text_buffer) :: remarks
    character(len=82) :: cells(4)
    integer :: i, k

    call list_totals(results, lines)
    if (lines(1)%known == 1) then
      call begin_table('totals at the end', [character(len=8) :: 'total', 'value'], buffer)
    else
      call begin_table('totals at the ends of all positions', &
                       [character(len=8) :: 'total', 'maximum', 'minimum', 'average'], buffer)
    end if
    do i = 1, size(lines)
      cells(1) = lines(i)%name
      if (lines(i)%remark /= '') cells(1) = trim(lines(i)%name) // ', ' // lines(i)%remark
      do k = 1, lines(i)%known
        cells(k + 1) = readable(lines(i)%numbers(k), digits)
      end do
      call put_row(cells(:lines(i)%known + 1), buffer)
    end do
    call end_table(buffer)
    call write_remarks(scene_in, results, remarks)
    call put_paragraphs(remarks%text(), '', buffer)
  end subroutine put_totals

  subroutine put_effects(results, buffer)
    type(scene_results), intent(in) :: results
    type(text_buffer), intent(inout) :: buffer
    type(told_line), allocatable :: lines(:)
    integer :: i

    call list_effects(results, lines)
    if (size(lines) == 0) then
      call buffer%line('<p>None: the contacts are elastic, smooth and feel nothing of each ' // &
                       'other.</p>')
      return
    end if
    call buffer%line('<p>Influences and estimates are shares of the vertical load without ' // &
                     'them.</p>')
    call buffer%line('<dl>')
    do i = 1, size(lines)
      if (lines(i)%effect /= '') &
        call buffer%line('<dt>' // escaped(trim(lines(i)%effect)) // '</dt>')
      call buffer%line('<dd>' // escaped(trim(lines(i)%text)) // '</dd>')
    end do
    call buffer%line('</dl>')
  end subroutine put_effects

  ! A curve a position over its states, and the states of the only one as a table.
  subroutine put_curves(results, units, buffer)
    type(scene_results), intent(in) :: results
    character(len=*), intent(in) :: units(2)
    type(text_buffer), intent(inout) :: buffer
    real(real64), allocatable :: x(:), y(:)
    integer, allocatable :: first(:)
    integer :: curves, m, states

    states = 0
    curves = min(size(results%positions), most_curves)
    allocate (first(curves + 1))
    do m = 1, curves
      first(m) = states + 1
      states = states + size(results%positions(m)%states)
    end do
    first(curves + 1) = states + 1
    allocate (x(states), y(states))
    do m = 1, curves
      x(first(m):first(m + 1) - 1) = results%positions(m)%states%approach
      y(first(m):first(m + 1) - 1) = results%positions(m)%states%load
    end do
    if (states > 1) call draw()
    if (states == size(results%positions)) &
      call buffer%line('<p>One state a position; <code>points = 20</code> in ' // &
                       '<code>&amp;loading</code> draws the way there.</p>')
    if (curves < size(results%positions)) &
      call buffer%line('<p>The first ' // decimal_text(curves) // ' positions are drawn.</p>')
    if (size(results%positions) == 1) call put_states(results, buffer)

  contains

    subroutine draw()
      type(svg_plot) :: plot
      integer :: every, i, m

      call plot%begin('load against approach, ' // decimal_text(states) // ' states', &
                      axis_over(with_unit('approach, separation of planes', units(1)), x, &
                                .false.), &
                      axis_over(with_unit('load', units(2)), y, .false.), buffer)
      every = max(1, states / most_points)
      do m = 1, curves
        if (first(m + 1) - first(m) < 2) cycle
        associate (chosen => [(i, i = first(m), first(m + 1) - 2, every), first(m + 1) - 1])
          call plot%curve(x(chosen), y(chosen), buffer)
        end associate
      end do
      do m = 1, curves
        do i = first(m), first(m + 1) - 1
          if (states > most_dots .and. i < first(m + 1) - 1) cycle
          call plot%dot(x(i), y(i), says(x(i), y(i), m), buffer)
        end do
      end do
      call plot%finish(buffer)
    end subroutine draw

    function says(approach, load, position) result(text)
      real(real64), intent(in) :: approach, load
      integer, intent(in) :: position
      character(len=:), allocatable :: text

      text = 'approach ' // readable(approach, digits) // ', load ' // readable(load, digits)
      if (curves > 1) text = 'position ' // decimal_text(position) // ', ' // text
    end function says

  end subroutine put_curves

  subroutine put_states(results, buffer)
    type(scene_results), intent(in) :: results
    type(text_buffer), intent(inout) :: buffer
    character(len=24) :: cells(6)
    integer :: i

    associate (states => results%positions(1)%states)
      call begin_table('states', [character(len=16) :: 'step', 'approach', 'contacts', 'load', &
                                  'vertical_load', 'area'], buffer)
      do i = 1, min(size(states), most_rows)
        cells(1) = decimal_text(i)
        cells(2) = readable(states(i)%approach, digits)
        cells(3) = decimal_text(states(i)%contacts)
        cells(4) = readable(states(i)%load, digits)
        cells(5) = readable(states(i)%vertical_load, digits)
        cells(6) = readable(states(i)%area, digits)
        call put_row(cells, buffer)
      end do
      call end_table(buffer)
      call tell_cut(size(states), 'states', '--curve', buffer)
    end associate
  end subroutine put_states

  subroutine put_positions(results, force, buffer)
    type(scene_results), intent(in) :: results
    character(len=*), intent(in) :: force
    type(text_buffer), intent(inout) :: buffer
    integer, parameter :: own = 10
    type(svg_plot) :: plot
    type(state_row) :: last
    real(real64) :: load(size(results%positions))
    character(len=16) :: names(own + size(known_effects))
    character(len=24) :: cells(size(names))
    integer :: columns, i, m

    names(:own) = [character(len=16) :: 'position', 'x_displacement', 'y_displacement', &
                   'approach', 'contacts', 'load', 'vertical_load', 'area', 'limit_reached', &
                   'warnings']
    columns = own
    if (allocated(results%effects)) then
      columns = own + size(results%effects%names)
      names(own + 1:columns) = results%effects%names
    end if
    do m = 1, size(results%positions)
      last = last_state(results%positions(m))
      load(m) = last%load
    end do
    call plot%begin('load at every position', &
                    axis_over('position', real([1, size(load)], real64), .false.), &
                    axis_over(with_unit('load', force), load, .false.), buffer)
    associate (every => 1 + size(load) / most_points)
      call plot%curve(real([(m, m = 1, size(load), every)], real64), load(::every), buffer)
    end associate
    call plot%finish(buffer)
    call begin_table('positions, each at its last state', names(:columns), buffer)
    do m = 1, min(size(results%positions), most_rows)
      associate (position => results%positions(m))
        last = last_state(position)
        cells(1) = decimal_text(m)
        cells(2) = readable(position%x_displacement, digits)
        cells(3) = readable(position%y_displacement, digits)
        cells(4) = readable(last%approach, digits)
        cells(5) = decimal_text(last%contacts)
        cells(6) = readable(last%load, digits)
        cells(7) = readable(last%vertical_load, digits)
        cells(8) = readable(last%area, digits)
        cells(9) = merge('yes', 'no ', position%limit_reached)
        cells(10) = decimal_text(kinds_of_warnings(position))
        do i = 1, columns - own
          cells(own + i) = position%effects(i)%simulated
        end do
      end associate
      call put_row(cells(:columns), buffer)
    end do
    call end_table(buffer)
    call tell_cut(size(results%positions), 'positions', '--positions', buffer)
  end subroutine put_positions

  ! Where a table ends early, and what has the rest.
  subroutine tell_cut(rows, what, option, buffer)
    integer, intent(in) :: rows
    character(len=*), intent(in) :: what, option
    type(text_buffer), intent(inout) :: buffer

    if (rows > most_rows) &
      call buffer%line('<p>The first ' // decimal_text(most_rows) // ' of ' // &
                       decimal_text(rows) // ' ' // what // '; <code>' // option // &
                       ' FILE</code> writes all.</p>')
  end subroutine tell_cut

  subroutine put_origin(scene_in, inputs, results, buffer)
    type(scene), intent(in) :: scene_in
    type(input_file), intent(in) :: inputs(3)
    type(scene_results), intent(in) :: results
    type(text_buffer), intent(inout) :: buffer
    integer :: i

    call buffer%line('<p>asperity ' // version // ', solved in ' // trim(results%arithmetic) // &
                     '.</p>')
    call begin_table('files read', [character(len=20) :: 'file', 'checksum (FNV-1a)'], buffer)
    do i = 1, size(inputs)
      if (inputs(i)%path == '') cycle
      call buffer%line('<tr><th scope="row">' // escaped(inputs(i)%path) // '</th><td>' // &
                       inputs(i)%checksum // '</td></tr>')
    end do
    call end_table(buffer)
    call put_paragraphs(scene_in%notes%text(), '', buffer)
    call put_lines('the scene', scene_in%text, buffer)
  end subroutine put_origin

end module asperity_results_html
