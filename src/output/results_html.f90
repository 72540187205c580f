!> A run as one page that opens anywhere: totals, error estimate and warnings; curves; the effects;
!> the plan of contacts; the scene's text. It loads nothing and runs nothing.
module asperity_results_html
  use asperity_contact_field, only: contact_field, parts_in_words
  use asperity_contact_records, only: state_row
  use asperity_effect_names, only: known_effects
  use asperity_effects_summary, only: list_effects, effect_sentence
  use asperity_field_picture, only: draw_plan, plan_of_gap, plan_of_pressure
  use asperity_html_page, only: begin_page, begin_section, begin_table, end_of_section, &
                                end_of_table, end_page, escaped_text, put_lines, &
                                put_paragraphs, put_row
  use asperity_html_plans, only: put_plans
  use asperity_kinds, only: real64
  use asperity_number_format, only: number_text
  use asperity_problems, only: decimal_text, problem_list
  use asperity_result_table, only: cell_whole, cell_word, of_positions, of_states, result_table
  use asperity_scene_inputs, only: input_file
  use asperity_scene_results, only: last_state, scene_results
  use asperity_scene_values, only: scene
  use asperity_summary, only: errors_in_words, uses_samples, write_heading, write_map_table, &
                              write_path, write_remarks
  use asperity_svg_plot, only: axis_over, svg_plot
  use asperity_text_buffer, only: text_buffer
  use asperity_totals_table, only: list_totals, total_line
  use asperity_unit_names, only: axis_units, is_length, is_pressure, unit_of
  use asperity_version, only: version
  implicit none
  private

  public :: write_html

  ! A page stays below a megabyte: so many rows of a table, and points of a curve.
  integer, parameter :: most_rows = 500, most_points = 4000
  ! Curves of at most so many points show the values of each.
  integer, parameter :: most_dots = 200

contains

  !> The whole page.
  subroutine write_html(scene_in, inputs, results, warnings, buffer)
    type(scene), intent(in) :: scene_in          !! what was solved
    type(input_file), intent(in) :: inputs(3)    !! the files that it is made of
    type(scene_results), intent(in) :: results   !! with their contacts
    type(problem_list), intent(in) :: warnings   !! a line a kind
    type(text_buffer), intent(inout) :: buffer   !! gets the page
    type(text_buffer) :: text, map_text

    call begin_page(scene_in%file, buffer)
    call write_heading(scene_in, results, text)
    call put_paragraphs(text%text(), '', buffer)
    call begin_section('summary', 'Summary', buffer)
    call put_totals(scene_in, results, warnings, buffer)
    call buffer%line(end_of_section)
    if (size(results%positions) > 1) then
      call begin_section('positions', 'Positions', buffer)
      call put_positions(scene_in, results, buffer)
    else
      call begin_section('curves', 'Load and contact area', buffer)
      call put_states(scene_in, results, buffer)
    end if
    call buffer%line(end_of_section)
    if (allocated(results%positions(1)%fields)) then
      call begin_section('fields', 'Pressure and gap', buffer)
      call put_fields(scene_in, results%positions(1)%fields, buffer)
      call buffer%line(end_of_section)
    end if
    call begin_section('contacts', 'Plan of contacts', buffer)
    call put_plans(scene_in, results, buffer)
    call buffer%line(end_of_section)
    call begin_section('effects', 'Effects', buffer)
    call put_effects(results, buffer)
    if (allocated(results%map)) then
      call write_map_table(results%map, .not. uses_samples(results), map_text)
      call put_lines('summits against the map', map_text%text(), buffer)
    end if
    call buffer%line(end_of_section)
    call begin_section('origin', 'Input', buffer)
    call put_origin(scene_in, inputs, results, buffer)
    call buffer%line(end_of_section)
    call end_page(buffer)
  end subroutine write_html

  ! Plans of pressure and gap on the pixels at the last state.
  subroutine put_fields(scene_in, fields, buffer)
    type(scene), intent(in) :: scene_in
    type(contact_field), intent(in) :: fields(:)
    type(text_buffer), intent(inout) :: buffer
    character(len=20) :: units(2)

    units = [character(len=20) :: unit_of(scene_in, is_length), unit_of(scene_in, is_pressure)]
    call buffer%line('<p>Pressure and gap of the deformed surfaces on the pixels, at the last ' // &
                     'state. <code>--fields FILE</code> writes them.</p>')
    if (parts_in_words(fields(size(fields))) /= '') &
      call buffer%line('<p>The pixels have the sides <code>field_spacing</code>; ' // &
                       'pressures of contacts: ' // &
                       escaped_text(parts_in_words(fields(size(fields)))) // '.</p>')
    call buffer%line('<div class="plots">')
    call draw_plan(fields(size(fields)), plan_of_pressure, 'pressure in plan', units, .false., &
                   buffer)
    call draw_plan(fields(size(fields)), plan_of_gap, 'gap in plan', units, .false., buffer)
    call buffer%line('</div>')
  end subroutine put_fields

  subroutine put_totals(scene_in, results, warnings, buffer)
    type(scene), intent(in) :: scene_in
    type(scene_results), intent(in) :: results
    type(problem_list), intent(in) :: warnings
    type(text_buffer), intent(inout) :: buffer
    type(total_line), allocatable :: lines(:)
    type(text_buffer) :: path, remarks
    character(len=:), allocatable :: text
    character(len=82) :: cells(4)
    integer :: i, k

    call list_totals(scene_in, results, lines)
    if (lines(1)%known == 1) then
      call begin_table('totals at the end', [character(len=8) :: 'total', 'value'], buffer)
    else
      call begin_table('totals at the ends of all positions', &
                       [character(len=8) :: 'total', 'largest', 'smallest', 'mean'], buffer)
    end if
    do i = 1, size(lines)
      cells(1) = lines(i)%name
      if (lines(i)%remark /= '') cells(1) = trim(lines(i)%name) // ', ' // lines(i)%remark
      do k = 1, lines(i)%known
        cells(k + 1) = number_text(lines(i)%numbers(k))
      end do
      call put_row(cells(:lines(i)%known + 1), buffer)
    end do
    call buffer%line(end_of_table)
    if (errors_in_words(results) /= '') &
      call buffer%line('<p>' // errors_in_words(results) // '</p>')
    call write_remarks(scene_in, results, remarks)
    call put_paragraphs(warnings%text(), ' class="warn"', buffer)
    call put_paragraphs(remarks%text(), '', buffer)
    call write_path(scene_in, results, path)
    text = path%text()
    ! The lines begin with an empty one.
    if (len(text) > 0) call put_lines('load path', text(2:), buffer)
  end subroutine put_totals

  subroutine put_effects(results, buffer)
    type(scene_results), intent(in) :: results
    type(text_buffer), intent(inout) :: buffer
    type(effect_sentence), allocatable :: lines(:)
    integer :: i

    call list_effects(results, lines)
    if (size(lines) == 0) then
      call buffer%line('<p>None: elastic, frictionless, non-interacting contacts (Hertz).</p>')
      return
    end if
    call buffer%line('<p>Influences and estimates are shares of the vertical load without ' // &
                     'them.</p>')
    call buffer%line('<dl>')
    do i = 1, size(lines)
      if (lines(i)%effect /= '') &
        call buffer%line('<dt>' // escaped_text(trim(lines(i)%effect)) // '</dt>')
      call buffer%line('<dd>' // escaped_text(trim(lines(i)%text)) // '</dd>')
    end do
    call buffer%line('</dl>')
  end subroutine put_effects

  ! Curves and table of the states of the only position.
  subroutine put_states(scene_in, results, buffer)
    type(scene), intent(in) :: scene_in
    type(scene_results), intent(in) :: results
    type(text_buffer), intent(inout) :: buffer
    character(len=20) :: units(3)
    character(len=:), allocatable :: pressure

    units = axis_units(scene_in)
    associate (states => results%positions(1)%states)
      if (size(states) > 1) then
        call buffer%line('<div class="plots">')
        call put_plot('compression', units(1), states%closing, 'load', units(3), states%load, &
                      buffer, states%closing)
        if (uses_samples(results)) then
          pressure = unit_of(scene_in, is_pressure)
          call put_plot('nominal pressure', pressure, states%load / results%nominal_area, &
                        'area fraction', '', states%area / results%nominal_area, buffer, &
                        states%closing)
          call put_plot('nominal pressure', pressure, states%load / results%nominal_area, &
                        'mean gap', units(1), states%mean_gap, buffer, states%closing)
          call put_plot('nominal pressure', pressure, states%load / results%nominal_area, &
                        'separation', units(1), states%approach, buffer, states%closing)
        else
          call put_plot('load', units(3), states%load, 'contact area', units(2), states%area, &
                        buffer, states%closing)
        end if
        call buffer%line('</div>')
      else
        call buffer%line('<p>One state: <code>points = 20</code> in <code>&amp;loading</code> ' // &
                         'gives the load curve.</p>')
      end if
    end associate
    call put_result_table(of_states, 'states', '--curve', [character(len=16) :: 'step', &
                          'separation', 'compression', 'contacts', 'load', 'vertical_load', &
                          'area', merge('mean_gap', '        ', uses_samples(results))], &
                          results, buffer)
  end subroutine put_states

  ! One quantity over another; each point shows both. Arrows show the direction where `path`, the
  ! compression, turns back.
  subroutine put_plot(name_x, unit_x, x, name_y, unit_y, y, buffer, path)
    character(len=*), intent(in) :: name_x, unit_x, name_y, unit_y
    real(real64), intent(in) :: x(:), y(:)
    type(text_buffer), intent(inout) :: buffer
    real(real64), intent(in), optional :: path(:)
    type(svg_plot) :: plot
    integer :: every, i

    plot%axes(:2) = [axis_over(name_x, unit_x, x, .false.), axis_over(name_y, unit_y, y, .false.)]
    call plot%begin_plot(name_y // ' against ' // name_x, buffer)
    every = 1 + (size(x) - 1) / most_points
    associate (chosen => [(i, i = 1, size(x) - 1, every), size(x)])
      call plot%add_curve(x(chosen), y(chosen), buffer)
      if (present(path)) call plot%add_arrows(x(chosen), y(chosen), path(chosen), buffer)
    end associate
    if (size(x) <= most_dots) then
      do i = 1, size(x)
        call plot%add_dot(x(i), y(i), name_x // ' ' // number_text(x(i)) // ', ' // name_y // &
                      ' ' // number_text(y(i)), buffer)
      end do
    end if
    call buffer%line('</svg>')
  end subroutine put_plot

  ! Curves and table of the last states of all positions.
  subroutine put_positions(scene_in, results, buffer)
    type(scene), intent(in) :: scene_in
    type(scene_results), intent(in) :: results
    type(text_buffer), intent(inout) :: buffer
    character(len=16) :: effects(size(known_effects))
    type(state_row) :: ends(size(results%positions))
    real(real64) :: place(size(ends))
    character(len=24) :: across
    character(len=20) :: units(3), unit
    integer :: m

    effects = ''
    if (allocated(results%effects)) &
      effects(:size(results%effects%names)) = results%effects%names
    ends = [(last_state(results%positions(m)), m = 1, size(ends))]
    units = axis_units(scene_in)
    across = 'position'
    unit = ''
    place = [(real(m, real64), m = 1, size(ends))]
    associate (x => results%positions%x_displacement, y => results%positions%y_displacement)
      if (abs(x(2) - x(1)) > 0.0_real64 .neqv. abs(y(2) - y(1)) > 0.0_real64) then
        across = trim(merge('x', 'y', abs(x(2) - x(1)) > 0.0_real64)) // ' displacement'
        unit = units(1)
        place = merge(x, y, abs(x(2) - x(1)) > 0.0_real64)
      end if
    end associate
    call buffer%line('<div class="plots">')
    call put_plot(trim(across), unit, place, 'load', units(3), ends%load, buffer)
    call put_plot(trim(across), unit, place, 'contact area', units(2), ends%area, buffer)
    call put_plot(trim(across), unit, place, 'separation', units(1), ends%approach, buffer)
    call buffer%line('</div>')
    call put_result_table(of_positions, 'positions, each at its last state', '--positions', &
                          [character(len=16) :: 'position', 'x_displacement', 'y_displacement', &
                           'separation', 'contacts', 'load', 'vertical_load', 'area', &
                           'limit_reached', 'warnings', effects], results, buffer)
  end subroutine put_positions

  ! Some columns of a table of the results, those that it has; an option writes all rows.
  subroutine put_result_table(which, caption, option, wanted, results, buffer)
    integer, intent(in) :: which
    character(len=*), intent(in) :: caption, option, wanted(:)
    type(scene_results), intent(in) :: results
    type(text_buffer), intent(inout) :: buffer
    type(result_table) :: table
    integer, allocatable :: columns(:)
    character(len=24) :: cells(size(wanted))
    integer :: i, row
    logical :: found

    call table%begin_rows(which, results)
    columns = [(findloc(table%names, wanted(i), 1), i=1, size(wanted))]
    columns = pack(columns, columns > 0)
    call begin_table(caption, table%names(columns), buffer)
    do row = 1, min(table%rows, most_rows)
      call table%next_row(results, found)
      do i = 1, size(columns)
        associate (k => columns(i))
          cells(i) = number_text(table%numbers(k))
          if (table%kinds(k) == cell_whole) cells(i) = decimal_text(nint(table%numbers(k)))
          if (table%kinds(k) == cell_word) cells(i) = table%words(k)
          if (table%names(k) == 'limit_reached') &
            cells(i) = merge('yes', 'no ', table%numbers(k) > 0.0_real64)
        end associate
      end do
      call put_row(cells(:size(columns)), buffer)
    end do
    call buffer%line(end_of_table)
    if (table%rows > most_rows) &
      call buffer%line('<p>The first ' // decimal_text(most_rows) // ' of ' // &
                       decimal_text(table%rows) // ' ' // caption(:scan(caption // ',', ',') - 1) &
                       // '; <code>' // option // ' FILE</code> writes all.</p>')
  end subroutine put_result_table

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
      call buffer%line('<tr><th scope="row">' // escaped_text(inputs(i)%path) // '</th><td>' // &
                       inputs(i)%checksum // '</td></tr>')
    end do
    call buffer%line(end_of_table)
    call put_paragraphs(scene_in%notes%text(), '', buffer)
    call put_lines('the scene', scene_in%text, buffer)
  end subroutine put_origin

end module asperity_results_html
