!> Plans of a contact field: pressure or gap as colours, with axes, colour bar and scale bar.
module asperity_field_picture
  use asperity_contact_field, only: contact_field
  use asperity_kinds, only: not_computed, real64
  use asperity_plan_drawing, only: add_frame, add_image, add_line, add_text, at_begin, at_end, &
                                   at_middle, colour_blank, colour_missing, first_colour, &
                                   last_colour, plan_drawing
  use asperity_position_lists, only: readable
  use asperity_svg_plot, only: round_step
  use asperity_unit_names, only: with_unit
  implicit none
  private

  public :: draw_plan
  public :: plan_of_gap, plan_of_pressure
  public :: width_of_page, width_of_picture

  !> What the colours are.
  integer, parameter :: plan_of_pressure = 1, plan_of_gap = 2

  !> Longer side of the map in points: on a page, where letters must be legible on a phone, and in a
  !> picture.
  integer, parameter :: width_of_page = 250, width_of_picture = 512

  ! Points: least side of the map, room around it, colour bar and what is beside it.
  integer, parameter :: least = 64
  integer, parameter :: left = 76, top = 58, below = 96, beside = 18, bar = 16, numbers = 92
  ! Lines of text below the map, and a mark of an axis, points.
  integer, parameter :: first_line = 19, second_line = 38, third_line = 66, fourth_line = 86, &
                        mark = 5
  ! Distance of the numbers along an axis, points: more than they take.
  integer, parameter :: distance(2) = [100, 40]
  ! Significant digits of the numbers along an axis.
  integer, parameter :: digits = 4

contains

  !> Draws a plan: x to the right, y upwards, in the coordinates of the field.
  subroutine draw_plan(field, quantity, title, units, longest, most_pixels, drawing)
    type(contact_field), intent(in) :: field      !! of one state
    integer, intent(in) :: quantity               !! `plan_of_pressure` or `plan_of_gap`
    character(len=*), intent(in) :: title         !! first line; a long one is cut; empty: none
    character(len=*), intent(in) :: units(2)      !! of length and pressure; blank: not known
    integer, intent(in) :: longest                !! longer side of the map, points
    integer, intent(in) :: most_pixels            !! of the image along its longer side
    type(plan_drawing), intent(out) :: drawing    !! the drawing
    integer, allocatable :: colour(:, :)
    real(real64) :: highest, low(2), side(2)
    integer :: i, points(2), room
    character(len=:), allocatable :: name

    side = field%spacing * [field%columns, field%rows]
    points = max(least, nint(longest * side / maxval(side)))
    room = max(points(2), 2 * least)
    drawing%width = left + points(1) + beside + bar + numbers
    drawing%height = top + max(points(2) + below, room + third_line)
    call colour_pixels(field, quantity, most_pixels, colour, highest)
    if (title /= '') call add_text(drawing, [8, 18], at_begin, cut(title, drawing%width), &
                                   is_bold=.true.)
    call add_image(drawing, left, top, points(1), points(2), colour)
    call add_frame(drawing, left, top, points(1), points(2))
    low = field%origin - 0.5_real64 * field%spacing
    call put_axis(1, low(1), low(1) + side(1))
    call put_axis(2, low(2), low(2) + side(2))
    call add_text(drawing, [left + points(1), top + points(2) + second_line], at_end, &
                  with_unit('x', trim(units(1))))
    call add_text(drawing, [left - 8, top - 12], at_end, with_unit('y', trim(units(1))))
    call put_colour_bar()
    call put_scale_bar()
    call put_swatch(left, colour_blank, trim(merge('contact   ', 'no contact', &
                                                   quantity == plan_of_gap)))
    if (.not. all(field%pressure > not_computed)) &
      call put_swatch(left + 120, colour_missing, 'not measured')

  contains

    ! Marks and numbers along an edge of the map.
    subroutine put_axis(axis, low, high)
      integer, intent(in) :: axis
      real(real64), intent(in) :: low, high
      real(real64) :: step, value
      integer :: at, k

      step = round_step((high - low) / max(1, min(6, points(axis) / distance(axis))))
      do k = ceiling(low / step), floor(high / step)
        value = k * step
        at = nint((value - low) / (high - low) * points(axis))
        if (axis == 1) then
          call add_line(drawing, [left + at, top + points(2)], [left + at, top + points(2) + mark])
          call add_text(drawing, [left + at, top + points(2) + first_line], at_middle, &
                        readable(value, digits))
        else
          call add_line(drawing, [left - mark, top + points(2) - at], [left, top + points(2) - at])
          call add_text(drawing, [left - mark - 4, top + points(2) - at + 4], at_end, &
                        readable(value, digits))
        end if
      end do
    end subroutine put_axis

    ! The colours from 0 to the highest value, beside the map.
    subroutine put_colour_bar()
      integer :: at, from, k
      real(real64) :: step

      from = left + points(1) + beside
      name = with_unit('pressure', trim(units(2)))
      if (quantity == plan_of_gap) name = with_unit('gap', trim(units(1)))
      call add_text(drawing, [drawing%width - 8, top - 12], at_end, name)
      call add_image(drawing, from, top, bar, room, &
                     reshape([(i, i = last_colour, first_colour, -1)], &
                             [1, last_colour - first_colour + 1]))
      call add_frame(drawing, from, top, bar, room)
      if (.not. highest > 0.0_real64) then
        call add_text(drawing, [from + bar + mark + 4, top + room + 4], at_begin, '0')
        return
      end if
      step = round_step(highest / max(1, min(6, room / distance(2))))
      do k = 0, floor(highest / step)
        at = top + room - nint(k * step / highest * room)
        call add_line(drawing, [from + bar, at], [from + bar + mark, at])
        call add_text(drawing, [from + bar + mark + 4, at + 4], at_begin, &
                      readable(k * step, digits))
      end do
    end subroutine put_colour_bar

    ! A length below the map: a sixth of its width, or somewhat more.
    subroutine put_scale_bar()
      real(real64) :: length
      integer :: foot, to

      length = round_step(side(1) / 6)
      to = left + min(points(1), nint(length / side(1) * points(1)))
      foot = top + points(2) + third_line - 10
      call add_line(drawing, [left, foot - 4], [left, foot + 4])
      call add_line(drawing, [to, foot - 4], [to, foot + 4])
      call add_line(drawing, [left, foot], [to, foot])
      call add_text(drawing, [to + 8, foot + 4], at_begin, &
                    trim(readable(length, 1) // ' ' // units(1)))
    end subroutine put_scale_bar

    ! A colour that stands beside the colour bar, and what it means.
    subroutine put_swatch(from, which, meaning)
      integer, intent(in) :: from, which
      character(len=*), intent(in) :: meaning
      integer, parameter :: swatch = 12

      call add_image(drawing, from, top + points(2) + fourth_line - swatch + 1, swatch, swatch, &
                     reshape([which], [1, 1]))
      call add_frame(drawing, from, top + points(2) + fourth_line - swatch + 1, swatch, swatch)
      call add_text(drawing, [from + swatch + 6, top + points(2) + fourth_line], at_begin, meaning)
    end subroutine put_swatch

  end subroutine draw_plan

  ! A text in a room of so many points.
  pure function cut(text, room) result(line)
    character(len=*), intent(in) :: text
    integer, intent(in) :: room
    character(len=:), allocatable :: line
    integer, parameter :: widest_letter = 8

    line = text
    if (len(line) > room / widest_letter) line = line(:room / widest_letter - 3) // '...'
  end function cut

  ! Mean values of squares of measured pixels as colours, the last row at the top.
  subroutine colour_pixels(field, quantity, most_pixels, colour, highest)
    type(contact_field), intent(in) :: field
    integer, intent(in) :: quantity, most_pixels
    integer, allocatable, intent(out) :: colour(:, :)
    real(real64), intent(out) :: highest     ! value of the last colour
    real(real64), allocatable :: mean(:, :)
    real(real64) :: total
    integer :: i, j, k, m, measured, pressed, step

    step = (max(field%columns, field%rows) + most_pixels - 1) / most_pixels
    allocate (mean((field%columns + step - 1) / step, (field%rows + step - 1) / step))
    allocate (colour(size(mean, 1), size(mean, 2)))
    do j = 1, size(mean, 2)
      do i = 1, size(mean, 1)
        total = 0.0_real64
        measured = 0
        pressed = 0
        do m = (j - 1) * step + 1, min(j * step, field%rows)
          do k = (i - 1) * step + 1, min(i * step, field%columns)
            if (.not. field%pressure(k, m) > not_computed) cycle
            measured = measured + 1
            if (field%pressure(k, m) > 0.0_real64) pressed = pressed + 1
            if (quantity == plan_of_pressure) total = total + field%pressure(k, m)
            if (quantity == plan_of_gap) total = total + field%gap(k, m)
          end do
        end do
        mean(i, j) = total / max(1, measured)
        colour(i, j) = first_colour
        if (quantity == plan_of_pressure .and. pressed == 0) colour(i, j) = colour_blank
        if (quantity == plan_of_gap .and. pressed == measured) colour(i, j) = colour_blank
        if (measured == 0) colour(i, j) = colour_missing
      end do
    end do
    highest = maxval([0.0_real64, maxval(mean)])
    if (highest > 0.0_real64) where (colour == first_colour) &
      colour = first_colour + nint((last_colour - first_colour) * (mean / highest))
    colour = colour(:, size(colour, 2):1:-1)
  end subroutine colour_pixels

end module asperity_field_picture
