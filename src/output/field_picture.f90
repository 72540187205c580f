!> Plans of a contact field, pressure or gap, and of a height map with its summits: values as
!> colours, with axes, colour bar and scale bar.
module asperity_field_picture
  use asperity_contact_field, only: contact_field
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: not_computed, real64
  use asperity_map_summits, only: map_summits
  use asperity_number_format, only: count_text, number_text
  use asperity_plan_drawing, only: add_dots, add_frame, add_image, add_line, add_text, at_begin, &
                                   at_end, at_middle, colour_blank, colour_missing, first_colour, &
                                   last_colour, plan_drawing, write_svg
  use asperity_problems, only: decimal_text
  use asperity_svg_plot, only: round_step
  use asperity_text_buffer, only: text_buffer
  use asperity_unit_names, only: with_unit
  implicit none
  private

  public :: draw_map, draw_plan
  public :: plan_of_gap, plan_of_pressure
  public :: width_of_page, width_of_picture

  !> Quantities shown as colours.
  integer, parameter :: plan_of_pressure = 1, plan_of_gap = 2

  !> Longer side of the map in points: on a page, where letters must be legible on a phone, and in a
  !> picture.
  integer, parameter :: width_of_page = 250, width_of_picture = 512

  ! Points: least side of the map, room around it, colour bar and what is beside it.
  integer, parameter :: least = 64
  integer, parameter :: left = 76, top = 58, below = 96, beside = 18, bar = 16, numbers = 92
  ! Lines of text below the map, and a mark of an axis, points.
  integer, parameter :: first_line = 19, second_line = 38, third_line = 66, fourth_line = 86, &
                        fifth_line = 106, mark = 5
  ! Distance of the numbers along an axis, points: more than they take.
  integer, parameter :: distance(2) = [100, 40]
  ! Significant digits of the numbers along an axis.
  integer, parameter :: digits_of_axis = 4
  ! The first and the last colour of heights are so many deviations from the mean.
  real(real64), parameter :: most_deviations = 3.0_real64
  ! More dots make the file large: the highest summits are drawn.
  integer, parameter :: most_dots = 20000

  ! Content and place of a plan.
  type :: plan_frame
    real(real64) :: low(2) = 0.0_real64        ! coordinates of the lower left corner [length]
    real(real64) :: side(2) = 0.0_real64       ! sides along x and y [length]
    real(real64) :: limits(2) = 0.0_real64     ! values of the first and of the last colour
    character(len=:), allocatable :: name      ! of the values, with their unit
    character(len=:), allocatable :: unit      ! of length; empty: not known
    character(len=:), allocatable :: blank     ! what a value of 0 is; not allocated: a value
    character(len=:), allocatable :: note      ! what a colour is the mean of; empty: of a pixel
    logical :: is_missing = .false.            ! some pixels were not measured
    integer :: points(2) = 0                   ! sides in the drawing, points
  end type plan_frame

contains

  !> Draws the pressure or the gap of a field in plan, in the coordinates of the field.
  subroutine draw_plan(field, quantity, title, units, longest, most_pixels, drawing)
    type(contact_field), intent(in) :: field      !! of one state
    integer, intent(in) :: quantity               !! `plan_of_pressure` or `plan_of_gap`
    character(len=*), intent(in) :: title         !! first line; a long one is cut; empty: none
    character(len=*), intent(in) :: units(2)      !! of length and pressure; blank: not known
    integer, intent(in) :: longest                !! longer side of the map, points
    integer, intent(in) :: most_pixels            !! of the image along its longer side
    type(plan_drawing), intent(out) :: drawing    !! gets the plan drawn
    real(real64), allocatable :: mean(:, :)
    type(plan_frame) :: frame

    frame%low = field%origin - 0.5_real64 * field%pixel_spacing
    frame%side = field%pixel_spacing * [field%columns, field%rows]
    frame%unit = units(1)
    if (quantity == plan_of_pressure) then
      call average_squares(field%pressure, most_pixels, mean, frame%note)
      frame%name = with_unit('pressure', trim(units(2)))
      frame%blank = 'no contact'
    else
      call average_squares(field%gap, most_pixels, mean, frame%note)
      frame%name = with_unit('gap', trim(units(1)))
      frame%blank = 'contact'
    end if
    frame%limits(2) = maxval([0.0_real64, maxval(mean)])
    frame%is_missing = .not. all(field%pressure > not_computed)
    call draw_pixels(mean, frame, title, longest, drawing)
  end subroutine draw_plan

  !> Draws the heights of a map and its summits in plan, from the centre of the first pixel on.
  subroutine draw_map(title, map, summits, buffer)
    character(len=*), intent(in) :: title       !! first line; a long one is cut
    type(height_map), intent(in) :: map         !! levelled height map
    type(map_summits), intent(in) :: summits    !! of this map
    type(text_buffer), intent(inout) :: buffer  !! gets the drawing, an SVG
    type(plan_drawing) :: drawing
    type(plan_frame) :: frame
    real(real64), allocatable :: mean(:, :)
    logical, allocatable :: drawn(:)
    real(real64) :: middle, deviation
    character(len=:), allocatable :: text
    integer :: number

    call average_squares(map%height, width_of_picture, mean, frame%note)
    associate (is_known => mean > not_computed)
      middle = sum(mean, is_known) / count(is_known)
      deviation = sqrt(sum((mean - middle)**2, is_known) / count(is_known))
      frame%limits = [max(middle - most_deviations * deviation, minval(mean, is_known)), &
                     min(middle + most_deviations * deviation, maxval(mean, is_known))]
    end associate
    frame%low = -0.5_real64 * map%pixel_spacing
    frame%side = map%pixel_spacing * [map%columns, map%rows]
    frame%unit = map%unit
    frame%name = with_unit('height', map%unit)
    frame%is_missing = .not. all(is_measured(map%height))
    call draw_pixels(mean, frame, title, width_of_picture, drawing)
    number = size(summits%x)
    drawn = highest_of(summits%height)
    call add_dots(drawing, place_across(frame, 1, pack(summits%x, drawn)), &
                  place_across(frame, 2, pack(summits%y, drawn)), merge(2, 4, number > 2000))
    text = count_text(number, 'summit') // ' (dots)'
    if (number > most_dots) text = text // ', the highest ' // decimal_text(most_dots) // ' drawn'
    call add_text(drawing, [left, top + frame%points(2) + fourth_line], at_begin, text)
    call write_svg(drawing, title, .false., buffer)
  end subroutine draw_map

  ! Which heights are the highest, at most so many as are drawn; the least one by bisection.
  pure function highest_of(height) result(chosen)
    real(real64), intent(in) :: height(:)
    logical :: chosen(size(height))
    real(real64) :: above, below, middle
    integer :: round

    chosen = .true.
    if (size(height) <= most_dots) return
    below = minval(height)
    above = maxval(height)
    do round = 1, 40
      middle = 0.5_real64 * (below + above)
      if (count(height > middle) > most_dots) then
        below = middle
      else
        above = middle
      end if
    end do
    chosen = height > above
  end function highest_of

  ! Points from the left, or from the top, of the drawing to a coordinate.
  elemental real(real64) function place_across(frame, axis, value) result(place)
    type(plan_frame), intent(in) :: frame
    integer, intent(in) :: axis
    real(real64), intent(in) :: value

    place = (value - frame%low(axis)) / frame%side(axis) * frame%points(axis)
    if (axis == 2) place = frame%points(axis) - place
    place = merge(left, top, axis == 1) + place
  end function place_across

  ! Draws values as colours, with axes, colour bar and scale bar.
  subroutine draw_pixels(mean, frame, title, longest, drawing)
    real(real64), intent(in) :: mean(:, :)
    type(plan_frame), intent(inout) :: frame
    character(len=*), intent(in) :: title
    integer, intent(in) :: longest
    type(plan_drawing), intent(out) :: drawing
    integer :: from, i, points(2), room

    points = max(least, nint(longest * frame%side / maxval(frame%side)))
    frame%points = points
    room = max(points(2), 2 * least)
    drawing%width = left + points(1) + beside + bar + numbers
    drawing%height = top + max(points(2) + below, room + third_line) + &
                     merge(0, fifth_line - fourth_line, frame%note == '')
    if (title /= '') call add_text(drawing, [8, 18], at_begin, cut_text(title, drawing%width), &
                                   is_bold=.true.)
    call add_image(drawing, left, top, points(1), points(2), colours_of(mean, frame))
    call add_frame(drawing, left, top, points(1), points(2))
    associate (high => frame%low + frame%side, foot => top + points(2))
      call put_marks(drawing, 1, [left, foot], points(1), [frame%low(1), high(1)])
      call put_marks(drawing, 2, [left, foot], points(2), [frame%low(2), high(2)])
    end associate
    call add_text(drawing, [left + points(1), top + points(2) + second_line], at_end, &
                  with_unit('x', frame%unit))
    call add_text(drawing, [left - 8, top - 12], at_end, with_unit('y', frame%unit))
    from = left + points(1) + beside
    call add_text(drawing, [drawing%width - 8, top - 12], at_end, frame%name)
    call add_image(drawing, from, top, bar, room, &
                   reshape([(i, i = last_colour, first_colour, -1)], &
                           [1, last_colour - first_colour + 1]))
    call add_frame(drawing, from, top, bar, room)
    call put_marks(drawing, 3, [from + bar, top + room], room, frame%limits)
    call put_scale_bar(drawing, frame)
    if (allocated(frame%blank)) call put_swatch(drawing, frame, left, colour_blank, frame%blank)
    if (frame%note /= '') &
      call add_text(drawing, [left, top + points(2) + fifth_line], at_begin, frame%note)
    if (frame%is_missing) &
      call put_swatch(drawing, frame, left + merge(120, 240, allocated(frame%blank)), &
                      colour_missing, 'not measured')
  end subroutine draw_pixels

  ! Marks and numbers along an edge from its lower left end on: 1 below the map, 2 left of it, 3
  ! right of the colour bar.
  subroutine put_marks(drawing, edge, corner, length, ends)
    type(plan_drawing), intent(inout) :: drawing
    integer, intent(in) :: edge, corner(2), length
    real(real64), intent(in) :: ends(2)
    integer, parameter :: anchors(3) = [at_middle, at_end, at_begin]
    integer, parameter :: outward(2, 3) = reshape([0, mark, -mark, 0, mark, 0], [2, 3])
    integer, parameter :: to_text(2, 3) = &
      reshape([0, first_line, -mark - 4, 4, mark + 4, 4], [2, 3])
    integer :: at, k, place(2)
    real(real64) :: step

    if (.not. ends(2) > ends(1)) then
      call add_text(drawing, corner + to_text(:, edge), anchors(edge), &
                    number_text(ends(1), digits_of_axis))
      return
    end if
    step = round_step((ends(2) - ends(1)) / max(1, min(6, length / distance(min(edge, 2)))))
    do k = ceiling(ends(1) / step), floor(ends(2) / step)
      at = nint((k * step - ends(1)) / (ends(2) - ends(1)) * length)
      place = corner + merge([at, 0], [0, -at], edge == 1)
      call add_line(drawing, place + min(outward(:, edge), 0), place + max(outward(:, edge), 0))
      call add_text(drawing, place + to_text(:, edge), anchors(edge), &
                    number_text(k * step, digits_of_axis))
    end do
  end subroutine put_marks

  ! A length below the map: a sixth of its width, or somewhat more.
  subroutine put_scale_bar(drawing, frame)
    type(plan_drawing), intent(inout) :: drawing
    type(plan_frame), intent(in) :: frame
    real(real64) :: length
    integer :: foot, to

    length = round_step(frame%side(1) / 6)
    to = left + min(frame%points(1), nint(length / frame%side(1) * frame%points(1)))
    foot = top + frame%points(2) + third_line - 10
    call add_line(drawing, [left, foot - 4], [left, foot + 4])
    call add_line(drawing, [to, foot - 4], [to, foot + 4])
    call add_line(drawing, [left, foot], [to, foot])
    call add_text(drawing, [to + 8, foot + 4], at_begin, &
                  trim(number_text(length, 1) // ' ' // frame%unit))
  end subroutine put_scale_bar

  ! A colour that stands beside the colour bar, and its meaning.
  subroutine put_swatch(drawing, frame, from, which, meaning)
    type(plan_drawing), intent(inout) :: drawing
    type(plan_frame), intent(in) :: frame
    integer, intent(in) :: from, which
    character(len=*), intent(in) :: meaning
    integer, parameter :: swatch = 12
    integer :: foot

    foot = top + frame%points(2) + fourth_line
    call add_image(drawing, from, foot - swatch + 1, swatch, swatch, reshape([which], [1, 1]))
    call add_frame(drawing, from, foot - swatch + 1, swatch, swatch)
    call add_text(drawing, [from + swatch + 6, foot], at_begin, meaning)
  end subroutine put_swatch

  ! A text in a room of so many points.
  pure function cut_text(text, room) result(line)
    character(len=*), intent(in) :: text
    integer, intent(in) :: room
    character(len=:), allocatable :: line
    integer, parameter :: widest_letter = 8

    line = text
    if (len(line) > room / widest_letter) line = line(:room / widest_letter - 3) // '...'
  end function cut_text

  ! Mean values of squares of measured pixels, with a note on them; `not_computed` where none was
  ! measured.
  pure subroutine average_squares(values, most_pixels, mean, note)
    real(real64), intent(in) :: values(:, :)
    integer, intent(in) :: most_pixels
    real(real64), allocatable, intent(out) :: mean(:, :)
    character(len=:), allocatable, intent(out) :: note
    integer :: i, j, step

    note = ''
    step = (maxval(shape(values)) + most_pixels - 1) / most_pixels
    allocate (mean((size(values, 1) + step - 1) / step, (size(values, 2) + step - 1) / step))
    do j = 1, size(mean, 2)
      do i = 1, size(mean, 1)
        associate (square => values((i - 1) * step + 1:min(i * step, size(values, 1)), &
                                    (j - 1) * step + 1:min(j * step, size(values, 2))))
          mean(i, j) = not_computed
          if (any(is_measured(square))) &
            mean(i, j) = sum(square, is_measured(square)) / count(is_measured(square))
        end associate
      end do
    end do
    if (step > 1) note = 'colours: means of ' // decimal_text(step) // ' x ' // &
                         decimal_text(step) // ' pixels; greatest pixel ' // &
                         number_text(maxval(values, is_measured(values)), digits_of_axis)
  end subroutine average_squares

  ! Values as colours of the range, the last row at the top; a 0 is blank where that has a meaning.
  pure function colours_of(mean, frame) result(colour)
    real(real64), intent(in) :: mean(:, :)
    type(plan_frame), intent(in) :: frame
    integer :: colour(size(mean, 1), size(mean, 2))
    integer :: i, j

    do j = 1, size(mean, 2)
      do i = 1, size(mean, 1)
        associate (at => colour(i, size(mean, 2) + 1 - j), value => mean(i, j))
          at = first_colour
          if (frame%limits(2) > frame%limits(1)) &
            at = first_colour + nint((last_colour - first_colour) * &
                                     ((min(max(value, frame%limits(1)), frame%limits(2)) - &
                                       frame%limits(1)) / (frame%limits(2) - frame%limits(1))))
          if (allocated(frame%blank) .and. .not. abs(value) > 0.0_real64) at = colour_blank
          if (.not. value > not_computed) at = colour_missing
        end associate
      end do
    end do
  end function colours_of

end module asperity_field_picture
