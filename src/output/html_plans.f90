!> Plans of contacts on a page: one drawing and one table a position, of its last state. Below the
!> contacts lie the outlines and summits of both surfaces.
module asperity_html_plans
  use asperity_contact_records, only: contact_radius, contact_row, position_result, state_row
  use asperity_decimal, only: decimal_to_real64
  use asperity_height_map, only: height_map
  use asperity_html_page, only: put_table
  use asperity_kinds, only: not_computed, real64
  use asperity_number_format, only: count_text, number_text
  use asperity_problems, only: decimal_text
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: scene, scene_surface
  use asperity_svg_plot, only: plot_axis, side_of_plan, svg_plot
  use asperity_text_buffer, only: text_buffer
  use asperity_unit_names, only: axis_unit, is_length
  implicit none
  private

  public :: put_plans

  ! A page stays below a megabyte: at most so many positions, contacts, contacts that the keyboard
  ! stops at, rows of tables, and summits of a surface.
  integer, parameter :: most_plans = 100, most_circles = 10000, most_rows = 500, most_stops = 100, &
    most_summits = 5000
  ! The frame is at least so many of the largest contact radii wide where no surface is drawn.
  real(real64), parameter :: least_width = 10.0_real64
  ! Least width and height of the frame, shares of its longer side: numbers need room.
  real(real64), parameter :: least_side(2) = [0.67_real64, 0.25_real64]

  !> All plans.
  type :: plan_frame
    type(plot_axis) :: axes(2)                   !! to the right and upwards
    real(real64), allocatable :: lower(:, :)     !! corners, then summits; without columns: none
    real(real64), allocatable :: upper(:, :)     !! the same at no displacement
    real(real64) :: first(2) = 0.0_real64        !! displacement in the first plan
    integer :: plans = 0                         !! so many are drawn
    logical :: has_patches = .false.             !! contacts are patches of pixels, without a radius
    !> Remainders of the `most_` numbers.
    integer :: circles = most_circles, rows = most_rows, stops = most_stops
  end type plan_frame

contains

  !> The plans of all positions in one scale, as far as there is room; a note states the limits.
  subroutine put_plans(scene_in, results, buffer)
    type(scene), intent(in) :: scene_in         !! what was solved
    type(scene_results), intent(in) :: results  !! with their contacts
    type(text_buffer), intent(inout) :: buffer  !! gets the page
    type(plan_frame) :: frame
    type(state_row) :: last
    integer :: m, plans

    if (allocated(results%effects)) &
      frame%has_patches = any(results%effects%contact_columns == 'samples')
    call find_surfaces(scene_in, frame)
    call find_frame(results, frame)
    frame%axes%name = ['x', 'y']
    frame%axes%unit = axis_unit(scene_in, is_length)
    plans = 0
    do m = 1, size(results%positions)
      last = state_in_plan(results, m)
      if (last%last_row < last%first_row) cycle
      plans = plans + 1
      if (plans > most_plans .or. frame%circles == 0) cycle
      if (plans == 1) call buffer%line('<p>' // trim(merge( &
        'Dots: centres of the pressure of contact patches.                 ', &
        'Circles: contacts, each with its area, or a dot for a smaller one.', &
        frame%has_patches)) // ' Solid outline, dots: lower surface and its summits; dashed, ' // &
        'crosses: the upper ones. Summits are drawn where a surface has at most ' // &
        decimal_text(most_summits) // '.</p>')
      call put_plan(results, m, frame, buffer)
    end do
    if (plans == 0) call buffer%line('<p>No contact.</p>')
    if (plans > most_plans .or. frame%circles == 0 .or. frame%rows == 0) &
      call buffer%line('<p>The page shows ' // decimal_text(most_plans) // ' positions, ' // &
                       decimal_text(most_circles) // ' contacts and ' // &
                       decimal_text(most_rows) // ' rows of contacts at most, in the order of ' // &
                       'first touch. <code>--contacts FILE</code> writes all.</p>')
  end subroutine put_plans

  ! Both surfaces in plan; a plane has no outline.
  subroutine find_surfaces(scene_in, frame)
    type(scene), intent(in) :: scene_in
    type(plan_frame), intent(inout) :: frame

    frame%upper = surface_in_plan(scene_in%upper)
    frame%lower = surface_in_plan(scene_in%lower)
    if (allocated(scene_in%map)) then
      if (scene_in%upper%is_plane) frame%upper = map_in_plan(scene_in%map%upper)
      if (scene_in%lower%is_plane) frame%lower = map_in_plan(scene_in%map%lower)
    else
      if (scene_in%lower_is_mirrored) &
        frame%lower(2, :) = decimal_to_real64(scene_in%lower_mirror_width) - frame%lower(2, :)
    end if
  end subroutine find_surfaces

  ! Corners of the pixels.
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

  ! A frame around the contacts and surfaces of all positions.
  subroutine find_frame(results, frame)
    type(scene_results), intent(in) :: results
    type(plan_frame), intent(inout) :: frame
    type(state_row) :: last
    real(real64) :: high(2), largest, low(2), radius, room
    integer :: i, m

    low = huge(low)
    high = -huge(high)
    largest = 0.0_real64
    do m = 1, size(results%positions)
      last = state_in_plan(results, m)
      if (last%last_row < last%first_row) cycle
      call enclose_points(frame%lower, [0.0_real64, 0.0_real64])
      call enclose_points(frame%upper, displacement_of(results, m))
      do i = last%first_row, last%last_row
        associate (row => results%positions(m)%rows(i))
          ! A patch that spans a periodic map has no centre, and no circle.
          if (.not. min(row%x, row%y) > not_computed) cycle
          radius = radius_in(frame, row)
          largest = max(largest, radius)
          low = min(low, [row%x, row%y] - radius)
          high = max(high, [row%x, row%y] + radius)
        end associate
      end do
    end do
    if (any(low > high)) return
    room = max(maxval(high - low), 1.0e-9_real64 * max(maxval(abs(low)), maxval(abs(high))))
    if (size(frame%lower, 2) + size(frame%upper, 2) == 0) room = max(room, least_width * largest)
    if (.not. room > 0.0_real64) room = 1.0_real64
    associate (more => max(0.0_real64, merge(room, least_side * room, &
                                             room > maxval(high - low)) - (high - low)) / 2 + &
               0.02_real64 * room)
      low = low - more
      high = high + more
    end associate
    frame%axes%low = low
    frame%axes%high = high

  contains

    subroutine enclose_points(points, shift)
      real(real64), intent(in) :: points(:, :), shift(2)

      if (size(points, 2) == 0) return
      low = min(low, minval(points(:, :4), 2) + shift)
      high = max(high, maxval(points(:, :4), 2) + shift)
    end subroutine enclose_points

  end subroutine find_frame

  ! The last state of a position; where that has no contact the one with the largest load.
  type(state_row) function state_in_plan(results, m, step) result(state)
    type(scene_results), intent(in) :: results
    integer, intent(in) :: m
    integer, intent(out), optional :: step
    integer :: i

    associate (states => results%positions(m)%states)
      i = size(states)
      if (.not. states(i)%area > 0.0_real64) i = maxloc(states%load, 1, states%contacts > 0)
      if (i == 0) i = size(states)
      state = states(i)
    end associate
    if (present(step)) step = i
  end function state_in_plan

  ! Displacement of the upper surface.
  pure function displacement_of(results, m) result(shift)
    type(scene_results), intent(in) :: results
    integer, intent(in) :: m
    real(real64) :: shift(2)

    shift = [results%positions(m)%x_displacement, results%positions(m)%y_displacement]
  end function displacement_of

  subroutine put_plan(results, m, frame, buffer)
    type(scene_results), intent(in) :: results
    integer, intent(in) :: m
    type(plan_frame), intent(inout) :: frame
    type(text_buffer), intent(inout) :: buffer
    type(svg_plot) :: plot
    type(state_row) :: last
    character(len=:), allocatable :: title
    character(len=24), allocatable :: cells(:, :)
    integer :: i, last_circle, last_in_table, step
    logical :: reached

    last = state_in_plan(results, m, step)
    last_circle = min(last%last_row, last%first_row + frame%circles - 1)
    last_in_table = min(last%last_row, last%first_row + frame%rows - 1)
    frame%circles = frame%circles - (last_circle - last%first_row + 1)
    frame%rows = frame%rows - (last_in_table - last%first_row + 1)
    reached = last%last_row - last%first_row < frame%stops
    if (reached) frame%stops = frame%stops - (last%last_row - last%first_row + 1)
    frame%plans = frame%plans + 1
    title = count_text(last%last_row - last%first_row + 1, 'contact') // ', load ' // &
            number_text(last%load)
    if (step < size(results%positions(m)%states)) &
      title = 'step ' // decimal_text(step) // ': ' // title
    if (size(results%positions) > 1) then
      title = 'position ' // decimal_text(m) // ': ' // title
      call buffer%line('<details' // &
                       trim(merge(' open="open"', '            ', frame%plans == 1)) // &
                       '><summary>' // title // '</summary>')
    else
      call buffer%line('<div>')
    end if
    plot%axes(:2) = frame%axes
    plot%longest = side_of_plan
    call plot%begin_plot('plan of contacts, ' // title, buffer, is_again=frame%plans > 1)
    if (frame%plans == 1) then
      frame%first = displacement_of(results, m)
      frame%upper = frame%upper + spread(frame%first, 2, size(frame%upper, 2))
      if (size(frame%lower) > 0) call plot%add_surface('lower', frame%lower, buffer)
      if (size(frame%upper) > 0) call plot%add_surface('upper', frame%upper, buffer)
    else
      if (size(frame%lower) > 0) call plot%repeat_surface('lower', [0.0_real64, 0.0_real64], buffer)
      if (size(frame%upper) > 0) &
        call plot%repeat_surface('upper', displacement_of(results, m) - frame%first, buffer)
    end if
    if (.not. reached) call buffer%line('<g class="patch many">')
    do i = last%first_row, last_circle
      associate (row => results%positions(m)%rows(i))
        if (min(row%x, row%y) > not_computed) &
          call plot%add_circle(row%x, row%y, radius_in(frame, row), &
                               text_of(row, reached, frame%has_patches), reached, buffer)
      end associate
    end do
    if (.not. reached) call buffer%line('</g>')
    call buffer%line('</svg>')
    if (last_in_table >= last%first_row) then
      allocate (cells(7, last%first_row:last_in_table))
      do i = last%first_row, last_in_table
        associate (row => results%positions(m)%rows(i))
          cells(:, i) = [character(len=24) :: decimal_text(row%area_no), number_text(row%x), &
                         number_text(row%y), number_text(merge(row%area, contact_radius(row), &
                                                               frame%has_patches)), &
                         number_text(row%load), number_text(row%average_pressure), &
                         number_text(row%maximum_pressure)]
        end associate
      end do
      call put_table('contacts, ' // title, [character(len=16) :: 'area_no', 'x', 'y', &
                     merge('area          ', 'contact_radius', frame%has_patches), 'load', &
                     'average_pressure', 'maximum_pressure'], cells, buffer)
    end if
    call buffer%line(trim(merge('</details>', '</div>    ', size(results%positions) > 1)))
  end subroutine put_plan

  ! Radius of a contact in plan; 0, a dot, for a patch of pixels.
  pure real(real64) function radius_in(frame, row)
    type(plan_frame), intent(in) :: frame
    type(contact_row), intent(in) :: row

    radius_in = 0.0_real64
    if (.not. frame%has_patches) radius_in = contact_radius(row)
  end function radius_in

  ! Number and values of a contact.
  function text_of(row, at_length, is_patch) result(text)
    type(contact_row), intent(in) :: row
    logical, intent(in) :: at_length, is_patch
    character(len=:), allocatable :: text

    text = decimal_text(row%area_no) // ': load ' // number_text(row%load, 4)
    if (.not. at_length) return
    text = text // trim(merge(', area  ', ', radius', is_patch)) // ' ' // &
           number_text(merge(row%area, contact_radius(row), is_patch), 4) // &
           ', pressure up to ' // number_text(row%maximum_pressure, 4)
  end function text_of

end module asperity_html_plans
