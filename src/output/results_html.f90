!> A run as one page that opens anywhere: totals, error estimate and warnings; curves; the effects;
!> the plan of contacts; the scene's text. It loads nothing and runs nothing.
module asperity_results_html
  use asperity_contact_field, only: contact_field, parts_in_words
  use asperity_effect_names, only: known_effects
  use asperity_effects_summary, only: list_effects, effect_sentence
  use asperity_field_picture, only: draw_plan, plan_of_gap, plan_of_pressure, plan_of_traction
  use asperity_html_page, only: begin_page, begin_section, end_page, escaped_text, put_lines, &
                                put_paragraphs, put_table
  use asperity_html_plans, only: put_plans
  use asperity_kinds, only: real64
  use asperity_number_format, only: number_text
  use asperity_problems, only: decimal_text, problem_list
  use asperity_result_table, only: array_table, numbers_of, of_positions, of_states, place_of
  use asperity_scene_inputs, only: input_file
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: scene
  use asperity_summary, only: errors_in_words, uses_samples, write_heading, write_map_table, &
                              write_path, write_remarks
  use asperity_svg_plot, only: axis_over, plot_axis, svg_plot
  use asperity_text_buffer, only: text_buffer
  use asperity_totals_table, only: list_totals, total_line
  use asperity_unit_names, only: axis_unit, is_length, is_pressure, unit_of
  use asperity_version, only: version
  implicit none
  private

  public :: write_html

  ! A page stays below a megabyte: so many rows of a table, and points of a curve.
  integer, parameter :: most_rows = 500, most_points = 4000
  ! Curves of at most so many points show the values of each.
  integer, parameter :: most_dots = 200

contains

  ! Long: its sections share the scene, its results and the page.
  !> The whole page.
  subroutine write_html(scene_in, inputs, results, tables, warnings, buffer)
    type(scene), intent(in) :: scene_in          !! what was solved
    type(input_file), intent(in) :: inputs(3)    !! the files that it is made of
    type(scene_results), intent(in) :: results   !! with their contacts
    type(array_table), intent(in) :: tables(3)   !! positions, states, contacts of them
    type(problem_list), intent(in) :: warnings   !! a line a kind
    type(text_buffer), intent(inout) :: buffer   !! gets the page
    type(text_buffer) :: text, map_text

    call begin_page(scene_in%file, buffer)
    call write_heading(scene_in, results, text)
    call put_paragraphs(text%text(), '', buffer)
    call begin_section('summary', 'Summary', buffer, .true.)
    call put_totals()
    if (size(results%positions) > 1) call begin_section('positions', 'Positions', buffer)
    if (size(results%positions) == 1) &
      call begin_section('curves', 'Load and contact area', buffer)
    call put_curves()
    if (allocated(results%positions(1)%fields)) then
      call begin_section('fields', 'Pressure and gap', buffer)
      call put_fields(results%positions(1)%fields)
    end if
    call begin_section('contacts', 'Plan of contacts', buffer)
    call put_plans(scene_in, results, buffer)
    call begin_section('effects', 'Effects', buffer)
    call put_effects()
    if (allocated(results%map)) then
      call write_map_table(results%map, map_text)
      call put_lines('summits against the map', map_text%text(), buffer)
    end if
    call begin_section('origin', 'Input', buffer)
    call put_origin()
    call end_page(buffer)

  contains

    ! Plans of pressure and gap on the pixels at the last state.
    subroutine put_fields(fields)
      type(contact_field), intent(in) :: fields(:)
      character(len=20) :: units(2)

      units = [character(len=20) :: unit_of(scene_in, is_length), unit_of(scene_in, is_pressure)]
      call buffer%line('<p>Pressure and gap of the deformed surfaces on the pixels, at the ' // &
                       'last state. <code>--fields FILE</code> writes them.</p>')
      if (parts_in_words(fields(size(fields))) /= '') &
        call buffer%line('<p>The pixels have the sides <code>field_spacing</code>; ' // &
                         'pressures of contacts: ' // &
                         escaped_text(parts_in_words(fields(size(fields)))) // '.</p>')
      call buffer%line('<div class="plots">')
      call draw_plan(fields(size(fields)), plan_of_pressure, 'pressure in plan', units, .false., &
                     buffer)
      call draw_plan(fields(size(fields)), plan_of_gap, 'gap in plan', units, .false., buffer)
      if (allocated(fields(size(fields))%traction)) call draw_plan(fields(size(fields)), &
        plan_of_traction, 'tangential traction in plan', units, .false., buffer)
      call buffer%line('</div>')
    end subroutine put_fields

    subroutine put_totals()
      type(total_line), allocatable :: lines(:)
      type(text_buffer) :: path, remarks
      character(len=:), allocatable :: text
      character(len=82), allocatable :: cells(:, :)
      integer :: i, k

      call list_totals(scene_in, results, lines)
      allocate (cells(merge(2, 4, size(results%positions) == 1), size(lines)))
      do i = 1, size(lines)
        cells(1, i) = lines(i)%name
        if (lines(i)%remark /= '') cells(1, i) = trim(lines(i)%name) // ', ' // lines(i)%remark
        do k = 1, lines(i)%known
          cells(k + 1, i) = number_text(lines(i)%numbers(k))
        end do
      end do
      if (size(results%positions) == 1) then
        call put_table('totals at the end', [character(len=8) :: 'total', 'value'], cells, buffer)
      else
        call put_table('totals at the ends of all positions', [character(len=8) :: 'total', &
                       'largest', 'smallest', 'mean'], cells, buffer)
      end if
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

    subroutine put_effects()
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

    ! Curves and table of the states of the only position, or of the last states of all positions.
    subroutine put_curves()
      character(len=16) :: effects(size(known_effects)), across
      logical :: varies(2)

      if (size(results%positions) > 1) then
        effects = ''
        if (allocated(results%effects)) &
          effects(:size(results%effects%names)) = results%effects%names
        associate (x => results%positions%x_displacement, y => results%positions%y_displacement)
          varies = [abs(x(2) - x(1)) > 0.0_real64, abs(y(2) - y(1)) > 0.0_real64]
        end associate
        across = 'position'
        if (varies(1) .neqv. varies(2)) across = merge('x_displacement', 'y_displacement', &
            varies(1))
        call put_plots(tables(of_positions), [across, across, across], &
                       [character(len=16) :: 'load', 'area', 'separation'])
        call put_result_table(tables(of_positions), 'positions, each at its last state', &
                              '--positions', [character(len=16) :: 'position', 'x_displacement', &
                              'y_displacement', 'separation', 'contacts', 'load', 'vertical_load', &
                              'area', 'limit_reached', 'warnings', effects])
        return
      end if
      associate (table => tables(of_states))
        if (table%rows == 1) then
          call buffer%line('<p>One state: <code>points = 20</code> in ' // &
                           '<code>&amp;loading</code> gives the load curve.</p>')
        else if (uses_samples(results)) then
          call put_plots(table, [character(len=16) :: 'compression', 'nominal_pressure', &
                         'nominal_pressure', 'nominal_pressure'], [character(len=16) :: 'load', &
                         'area_fraction', 'mean_gap', 'separation'])
        else
          call put_plots(table, [character(len=16) :: 'compression', 'load'], &
                         [character(len=16) :: 'load', 'area'])
        end if
        call put_result_table(table, 'states', '--curve', [character(len=16) :: 'step', &
                              'separation', 'compression', 'contacts', 'load', 'vertical_load', &
                              'area', merge('mean_gap', '        ', uses_samples(results))])
      end associate
    end subroutine put_curves

    ! Columns over others; each point shows both values. Arrows show the direction where the
    ! compression of the states turns back.
    subroutine put_plots(table, across, up)
      type(array_table), intent(in) :: table
      character(len=*), intent(in) :: across(:), up(:)
      type(svg_plot) :: plot
      real(real64), allocatable :: x(:), y(:), path(:)
      integer :: i, k

      call buffer%line('<div class="plots">')
      do k = 1, size(up)
        x = numbers_of(table, across(k))
        y = numbers_of(table, up(k))
        plot%axes(:2) = [axis_of(table, across(k), x), axis_of(table, up(k), y)]
        call plot%begin_plot(trim(plot%axes(2)%name) // ' against ' // trim(plot%axes(1)%name), &
                             buffer)
        associate (chosen => [(i, i=1, size(x) - 1, 1 + (size(x) - 1) / most_points), size(x)])
          call plot%add_curve(x(chosen), y(chosen), buffer)
          path = numbers_of(table, 'compression')
          if (table%columns(2)%name == 'step') &
            call plot%add_arrows(x(chosen), y(chosen), path(chosen), buffer)
        end associate
        do i = 1, merge(size(x), 0, size(x) <= most_dots)
          call plot%add_dot(x(i), y(i), trim(plot%axes(1)%name) // ' ' // number_text(x(i)) // &
                            ', ' // trim(plot%axes(2)%name) // ' ' // number_text(y(i)), buffer)
        end do
        call buffer%line('</svg>')
      end do
      call buffer%line('</div>')
    end subroutine put_plots

    ! An axis over a column, with its name in words.
    pure type(plot_axis) function axis_of(table, name, values) result(axis)
      type(array_table), intent(in) :: table
      character(len=*), intent(in) :: name
      real(real64), intent(in) :: values(:)

      axis = axis_over(name, axis_unit(scene_in, table%columns(place_of(table, name))%dimension), &
                       values, .false.)
      if (name == 'area') axis%name = 'contact area'
      if (index(name, '_') > 0) axis%name(index(name, '_'):index(name, '_')) = ' '
    end function axis_of

    ! Some columns of a table of the results, those that it has; an option writes all rows.
    subroutine put_result_table(table, caption, option, wanted)
      type(array_table), intent(in) :: table
      character(len=*), intent(in) :: caption, option, wanted(:)
      character(len=24), allocatable :: cells(:, :)
      integer :: columns(size(wanted)), i, k, row

      columns = [(place_of(table, wanted(i)), i=1, size(wanted))]
      allocate (cells(count(columns > 0), min(table%rows, most_rows)))
      columns = pack(columns, columns > 0, columns)
      do row = 1, size(cells, 2)
        do i = 1, size(cells, 1)
          associate (column => table%columns(columns(i)), cell => cells(i, row))
            if (allocated(column%reals)) cell = number_text(column%reals(row))
            if (allocated(column%wholes)) cell = decimal_text(column%wholes(row))
            if (allocated(column%letters)) &
              write (cell, '(*(a))') (column%letters(k, row), k=1, size(column%letters, 1))
            if (column%name == 'limit_reached') cell = merge('yes', 'no ', column%wholes(row) > 0)
          end associate
        end do
      end do
      call put_table(caption, pack(wanted, [(place_of(table, wanted(i)) > 0, i=1, size(wanted))]), &
                     cells, buffer)
      if (table%rows > most_rows) call buffer%line('<p>The first ' // decimal_text(most_rows) // &
        ' of ' // decimal_text(table%rows) // ' ' // caption(:scan(caption // ',', ',') - 1) // &
        '; <code>' // option // ' FILE</code> writes all.</p>')
    end subroutine put_result_table

    subroutine put_origin()
      integer :: i, longest

      call buffer%line('<p>asperity ' // version // ', solved in ' // trim(results%arithmetic) // &
                       '.</p>')
      longest = max(8, maxval([(len(inputs(i)%path), i=1, size(inputs))]))
      block
        character(len=longest) :: cells(2, count([(inputs(i)%path /= '', i=1, size(inputs))]))

        do i = 1, size(cells, 2)
          cells(:, i) = [character(len=longest) :: inputs(i)%path, inputs(i)%checksum]
        end do
        call put_table('files read', [character(len=20) :: 'file', 'checksum (FNV-1a)'], cells, &
                       buffer)
      end block
      call put_paragraphs(scene_in%notes%text(), '', buffer)
      call put_lines('the scene', scene_in%text, buffer)
    end subroutine put_origin

  end subroutine write_html

end module asperity_results_html
