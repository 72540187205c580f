!> A run as one page that opens anywhere: totals, error estimate and warnings; curves; the effects;
!> plans of contacts over the outlines and summits of both surfaces, one a position; the scene's
!> text. It loads nothing and runs nothing.
module asperity_results_html
  use asperity_contact_field, only: contact_field, parts_in_words
  use asperity_contact_records, only: contact_radius, state_row
  use asperity_decimal, only: decimal_to_real64
  use asperity_effect_names, only: known_effects
  use asperity_effects_summary, only: list_effects, effect_sentence
  use asperity_field_picture, only: draw_plan, plan_of_gap, plan_of_pressure, plan_of_traction
  use asperity_height_map, only: height_map
  use asperity_html_page, only: begin_page, begin_section, end_page, escaped_text, put_each_line, &
                                put_lines, put_table
  use asperity_kinds, only: not_computed, real64
  use asperity_number_format, only: count_text, number_text
  use asperity_problems, only: decimal_text, problem_list
  use asperity_result_table, only: add_reals, add_wholes, add_words, array_table, numbers_of, &
                                   of_positions, of_states, place_of
  use asperity_scene_inputs, only: input_file
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: scene, scene_surface
  use asperity_summary, only: errors_in_words, uses_samples, write_heading, write_map_table, &
                              write_path, write_remarks
  use asperity_svg_plot, only: axis_over, plot_axis, side_of_plan, svg_plot
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
  ! The same for plans: positions, contacts, contacts that the keyboard stops at, rows of their
  ! tables, and summits of a surface.
  integer, parameter :: most_plans = 100, most_circles = 10000, most_stops = 100, &
    most_listed = 500, most_summits = 5000
  ! The frame is at least so many of the largest contact radii wide where no surface is drawn.
  real(real64), parameter :: least_width = 10.0_real64
  ! Least width and height of the frame, shares of its longer side: numbers need room.
  real(real64), parameter :: least_side(2) = [0.67_real64, 0.25_real64]

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
    call put_each_line(text%text(), '<p>', '</p>', buffer)
    call begin_section('summary', 'Summary', buffer, .true.)
    call put_totals()
    if (size(results%positions) > 1) call begin_section('positions', 'Positions', buffer)
    if (size(results%positions) == 1) &
      call begin_section('curves', 'Load and contact area', buffer)
    call put_curves()
    if (allocated(results%positions(1)%fields)) then
      call begin_section('fields', 'Pressure and gap', buffer)
      call put_fields(results%positions(1)%fields(size(results%positions(1)%fields)))
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
    subroutine put_fields(field)
      type(contact_field), intent(in) :: field
      character(len=20) :: units(2)

      units = [character(len=20) :: unit_of(scene_in, is_length), unit_of(scene_in, is_pressure)]
      call buffer%line('<p>Pressure and gap of the deformed surfaces on the pixels, at the ' // &
                       'last state. <code>--fields FILE</code> writes them.</p>')
      if (parts_in_words(field) /= '') &
        call buffer%line('<p>The pixels have the sides <code>field_spacing</code>; ' // &
                         'pressures of contacts: ' // &
                         escaped_text(parts_in_words(field)) // '.</p>')
      call buffer%line('<div class="plots">')
      call draw_plan(field, plan_of_pressure, 'pressure in plan', units, .false., buffer)
      call draw_plan(field, plan_of_gap, 'gap in plan', units, .false., buffer)
      if (allocated(field%traction)) call draw_plan(field, plan_of_traction, &
                                             'tangential traction in plan', units, .false., buffer)
      call buffer%line('</div>')
    end subroutine put_fields

    subroutine put_totals()
      type(total_line), allocatable :: lines(:)
      type(text_buffer) :: path, remarks
      type(array_table) :: totals
      character(len=:), allocatable :: text
      character(len=82), allocatable :: names(:)
      integer :: i

      call list_totals(scene_in, results, lines)
      allocate (names(size(lines)))
      do i = 1, size(lines)
        names(i) = lines(i)%name
        if (lines(i)%remark /= '') names(i) = trim(lines(i)%name) // ', ' // lines(i)%remark
      end do
      call add_words(totals, 'total', names)
      if (size(results%positions) == 1) then
        call add_reals(totals, 'value', lines%numbers(1))
        call put_table('totals at the end', totals, buffer)
      else
        call add_reals(totals, 'largest', lines%numbers(1))
        call add_reals(totals, 'smallest', lines%numbers(2))
        call add_reals(totals, 'mean', lines%numbers(3))
        call put_table('totals at the ends of all positions', totals, buffer)
      end if
      if (errors_in_words(results) /= '') &
        call buffer%line('<p>' // errors_in_words(results) // '</p>')
      call write_remarks(scene_in, results, remarks)
      call put_each_line(warnings%text(), '<p class="warn">', '</p>', buffer)
      call put_each_line(remarks%text(), '<p>', '</p>', buffer)
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

      call put_table(caption, table, buffer, wanted, most_rows)
      if (table%rows > most_rows) call buffer%line('<p>The first ' // decimal_text(most_rows) // &
        ' of ' // decimal_text(table%rows) // ' ' // caption(:scan(caption // ',', ',') - 1) // &
        '; <code>' // option // ' FILE</code> writes all.</p>')
    end subroutine put_result_table

    subroutine put_origin()
      integer :: i
      type(array_table) :: files
      character(len=maxval([(len(inputs(i)%path), i=1, size(inputs))])) :: paths(size(inputs))
      logical :: is_read(size(inputs))

      call buffer%line('<p>asperity ' // version // ', solved in ' // trim(results%arithmetic) // &
                       '.</p>')
      do i = 1, size(inputs)
        paths(i) = inputs(i)%path
      end do
      is_read = paths /= ''
      call add_words(files, 'file', pack(paths, is_read))
      call add_words(files, 'checksum (FNV-1a)', pack(inputs%checksum, is_read))
      call put_table('files read', files, buffer)
      call put_each_line(scene_in%notes%text(), '<p>', '</p>', buffer)
      call put_lines('the scene', scene_in%text, buffer)
    end subroutine put_origin

  end subroutine write_html

  ! Long: the plans share the frame and the limits of the page.
  ! The plans of all positions in one scale, as far as there is room; a note states the limits.
  subroutine put_plans(scene_in, results, buffer)
    type(scene), intent(in) :: scene_in
    type(scene_results), intent(in) :: results
    type(text_buffer), intent(inout) :: buffer
    type(svg_plot) :: plot
    ! Corners, then summits of the surfaces, the upper one at no displacement; no columns: none.
    real(real64), allocatable :: lower(:, :), upper(:, :)
    real(real64) :: shifts(2, size(results%positions))  ! displacements of the upper surface
    integer :: first         ! position of the first plan
    logical :: has_patches   ! contacts are patches of pixels, which are drawn as dots
    integer :: plans, circles, rows, stops  ! plans so far, and what is left of the other limits
    integer :: at(size(results%positions))  ! state of each position that is drawn; 0: no contact
    integer :: m

    has_patches = .false.
    if (allocated(results%effects)) &
      has_patches = any(results%effects%contact_columns == 'samples')
    allocate (lower(2, 0), upper(2, 0))
    lower = surface_in_plan(scene_in%lower)
    upper = surface_in_plan(scene_in%upper)
    if (allocated(scene_in%map)) then
      if (scene_in%upper%is_plane) upper = map_in_plan(scene_in%map%upper)
      if (scene_in%lower%is_plane) lower = map_in_plan(scene_in%map%lower)
    else if (scene_in%lower_is_mirrored) then
      lower(2, :) = decimal_to_real64(scene_in%lower_mirror_width) - lower(2, :)
    end if
    at = [(state_in_plan(m), m=1, size(at))]
    shifts(1, :) = results%positions%x_displacement
    shifts(2, :) = results%positions%y_displacement
    plot%longest = side_of_plan
    plot%axes(:2)%name = ['x', 'y']
    plot%axes(:2)%unit = axis_unit(scene_in, is_length)
    call find_frame()
    circles = most_circles
    rows = most_listed
    stops = most_stops
    plans = 0
    do m = 1, size(at)
      if (at(m) == 0) cycle
      plans = plans + 1
      if (plans > most_plans .or. circles == 0) cycle
      if (plans == 1) call buffer%line('<p>' // trim(merge( &
        'Dots: centres of the pressure of contact patches.                 ', &
        'Circles: contacts, each with its area, or a dot for a smaller one.', &
        has_patches)) // ' Solid outline, dots: lower surface and its summits; dashed, ' // &
        'crosses: the upper ones. Summits are drawn where a surface has at most ' // &
        decimal_text(most_summits) // '.</p>')
      call put_plan(results%positions(m)%states(at(m)))
    end do
    if (plans == 0) call buffer%line('<p>No contact.</p>')
    if (plans > most_plans .or. circles == 0 .or. rows == 0) &
      call buffer%line('<p>The page shows ' // decimal_text(most_plans) // ' positions, ' // &
                       decimal_text(most_circles) // ' contacts and ' // &
                       decimal_text(most_listed) // ' rows of contacts at most, in the order ' // &
                       'of first touch. <code>--contacts FILE</code> writes all.</p>')

  contains

    ! The last state of a position; where that has no contact the one with the largest load; 0
    ! where it has no contacts.
    integer function state_in_plan(m) result(step)
      integer, intent(in) :: m

      associate (states => results%positions(m)%states)
        step = size(states)
        if (.not. states(step)%area > 0.0_real64) &
          step = maxloc(states%load, 1, states%contacts > 0)
        if (step == 0) step = size(states)
        if (states(step)%last_row < states(step)%first_row) step = 0
      end associate
    end function state_in_plan

    ! A frame around the contacts and surfaces of all positions.
    subroutine find_frame()
      real(real64) :: high(2), largest, low(2), radius, room
      integer :: i

      low = huge(low)
      high = -huge(high)
      largest = 0.0_real64
      do m = 1, size(at)
        if (at(m) == 0) cycle
        if (size(lower, 2) > 0) low = min(low, minval(lower(:, :4), 2))
        if (size(lower, 2) > 0) high = max(high, maxval(lower(:, :4), 2))
        if (size(upper, 2) > 0) low = min(low, minval(upper(:, :4), 2) + shifts(:, m))
        if (size(upper, 2) > 0) high = max(high, maxval(upper(:, :4), 2) + shifts(:, m))
        associate (state => results%positions(m)%states(at(m)))
          do i = state%first_row, state%last_row
            associate (row => results%positions(m)%rows(i))
              ! A patch that spans a periodic map has no centre, and no circle.
              if (.not. min(row%x, row%y) > not_computed) cycle
              radius = merge(0.0_real64, contact_radius(row), has_patches)
              largest = max(largest, radius)
              low = min(low, [row%x, row%y] - radius)
              high = max(high, [row%x, row%y] + radius)
            end associate
          end do
        end associate
      end do
      if (any(low > high)) return
      room = max(maxval(high - low), 1.0e-9_real64 * max(maxval(abs(low)), maxval(abs(high))))
      if (size(lower, 2) + size(upper, 2) == 0) room = max(room, least_width * largest)
      if (.not. room > 0.0_real64) room = 1.0_real64
      associate (more => max(0.0_real64, merge(room, least_side * room, &
                                               room > maxval(high - low)) - (high - low)) / 2 + &
                 0.02_real64 * room)
        plot%axes(:2)%low = low - more
        plot%axes(:2)%high = high + more
      end associate
    end subroutine find_frame

    ! The plan of a state, and the table of its contacts.
    subroutine put_plan(state)
      type(state_row), intent(in) :: state
      character(len=:), allocatable :: text, title
      type(array_table) :: table
      integer :: drawn, i, listed, number
      logical :: with_stops

      number = state%last_row - state%first_row + 1
      drawn = min(number, circles)
      listed = min(number, rows)
      with_stops = number <= stops
      circles = circles - drawn
      rows = rows - listed
      if (with_stops) stops = stops - number
      title = count_text(number, 'contact') // ', load ' // number_text(state%load)
      if (at(m) < size(results%positions(m)%states)) &
        title = 'step ' // decimal_text(at(m)) // ': ' // title
      if (size(at) > 1) then
        title = 'position ' // decimal_text(m) // ': ' // title
        call buffer%line('<details' // trim(merge(' open="open"', '            ', plans == 1)) // &
                         '><summary>' // title // '</summary>')
      else
        call buffer%line('<div>')
      end if
      call plot%begin_plot('plan of contacts, ' // title, buffer, is_again=plans > 1)
      if (plans == 1) then
        first = m
        upper = upper + spread(shifts(:, m), 2, size(upper, 2))
        if (size(lower) > 0) call plot%add_surface('lower', lower, buffer)
        if (size(upper) > 0) call plot%add_surface('upper', upper, buffer)
      else
        if (size(lower) > 0) call plot%repeat_surface('lower', [0.0_real64, 0.0_real64], buffer)
        if (size(upper) > 0) &
          call plot%repeat_surface('upper', shifts(:, m) - shifts(:, first), buffer)
      end if
      if (.not. with_stops) call buffer%line('<g class="patch many">')
      do i = state%first_row, state%first_row + drawn - 1
        associate (contact => results%positions(m)%rows(i))
          if (.not. min(contact%x, contact%y) > not_computed) cycle
          text = decimal_text(contact%area_no) // ': load ' // number_text(contact%load, 4)
          if (with_stops) text = text // trim(merge(', area  ', ', radius', has_patches)) // &
            ' ' // number_text(merge(contact%area, contact_radius(contact), has_patches), 4) // &
            ', pressure up to ' // number_text(contact%maximum_pressure, 4)
          call plot%add_circle(contact%x, contact%y, &
                               merge(0.0_real64, contact_radius(contact), has_patches), text, &
                               with_stops, buffer)
        end associate
      end do
      if (.not. with_stops) call buffer%line('</g>')
      call buffer%line('</svg>')
      if (listed > 0) then
        associate (part => results%positions(m)%rows(state%first_row:state%first_row + listed - 1))
          call add_wholes(table, 'area_no', part%area_no)
          call add_reals(table, 'x', part%x)
          call add_reals(table, 'y', part%y)
          if (has_patches) then
            call add_reals(table, 'area', part%area)
          else
            call add_reals(table, 'contact_radius', [(contact_radius(part(i)), i=1, listed)])
          end if
          call add_reals(table, 'load', part%load)
          call add_reals(table, 'average_pressure', part%average_pressure)
          call add_reals(table, 'maximum_pressure', part%maximum_pressure)
        end associate
        call put_table('contacts, ' // title, table, buffer)
      end if
      call buffer%line(trim(merge('</details>', '</div>    ', size(at) > 1)))
    end subroutine put_plan

  end subroutine put_plans

  ! Corners of the pixels of a map; no columns where there is none.
  pure function map_in_plan(map) result(points)
    type(height_map), intent(in) :: map
    real(real64), allocatable :: points(:, :)

    allocate (points(2, 0))
    if (map%columns > 0) points = rectangle_corners(-0.5_real64 * map%pixel_spacing, &
      map%pixel_spacing * ([map%columns, map%rows] - 0.5_real64))
  end function map_in_plan

  ! Corners of the rectangle around the spherical caps, and the summits, rotated.
  function surface_in_plan(surface) result(points)
    type(scene_surface), intent(in) :: surface
    real(real64), allocatable :: base(:), points(:, :)
    real(real64) :: angle

    allocate (points(2, 0))
    if (size(surface%x) == 0) return
    ! Radius of a cap in its base plane; of a full hemisphere at most.
    allocate (base(size(surface%x)))
    base = min(max(surface%height, 0.0_real64), surface%radius)
    base = sqrt(base) * sqrt(surface%radius + (surface%radius - base))
    associate (x => surface%x, y => surface%y)
      points = rectangle_corners([minval(x - base), minval(y - base)], [maxval(x + base), &
                                                                        maxval(y + base)])
      if (size(x) <= most_summits) points = reshape([points, transpose(reshape([x, y], &
                                                    [size(x), 2]))], [2, 4 + size(x)])
    end associate
    angle = decimal_to_real64(surface%rotation)
    points = matmul(reshape([cos(angle), sin(angle), -sin(angle), cos(angle)], [2, 2]), points)
  end function surface_in_plan

  ! Four corners, one after the other around.
  pure function rectangle_corners(low, high) result(corners)
    real(real64), intent(in) :: low(2), high(2)
    real(real64) :: corners(2, 4)

    corners = reshape([low, high(1), low(2), high, low(1), high(2)], [2, 4])
  end function rectangle_corners

end module asperity_results_html
