!> The plotter: a drawing with two axes as SVG, inside a page or as a file of its own. It has
!> curves, arrows, dots, circles, surfaces in plan, and values of pixels as colours.
!> In a page colours are those of the page's style (`asperity_html_page`).
module asperity_svg_plot
  use asperity_html_page, only: escaped_text
  use asperity_kinds, only: not_computed, real64
  use asperity_number_format, only: number_text
  use asperity_png_image, only: blank_colour, first_colour, image_address, last_colour, &
                                missing_colour
  use asperity_text_buffer, only: text_buffer
  use asperity_unit_names, only: with_unit
  implicit none
  private

  public :: plot_axis, svg_plot, axis_over, side_of_plan

  !> Longer side of a plan on a page, points.
  integer, parameter :: side_of_plan = 300
  ! Frame and room around it in points. A letter has 13 of them: on the narrowest screens a drawing
  ! is as wide as a page, 360 points, and its letters are of the size of others.
  real(real64), parameter :: diagram(2) = [300.0_real64, 200.0_real64]
  integer, parameter :: left = 74, right = 26, above = 44, below = 42, line = 15
  ! Least sides of a plan of pixels; room right of it, before, in and beside the colour bar.
  real(real64), parameter :: least_side(2) = [200.0_real64, 76.0_real64]
  integer, parameter :: beside = 18, bar = 16, numbers = 92, least_bar = 128
  ! Line below a plan with its scale bar and each line of notes, points.
  integer, parameter :: bar_line = 24, note_line = 20
  ! A longer name of an axis takes two lines, the second one with its unit; a note breaks there.
  integer, parameter :: longest_name = 26, longest_note = 40
  ! A longer unit has no room beside the scale bar: it stands at the axes.
  integer, parameter :: longest_unit = 8
  ! A span of values that are equal but for rounding shows no more of them than this share.
  real(real64), parameter :: least_span = 1.0e-3_real64
  ! Numbers beyond that have no room for a span.
  real(real64), parameter :: largest = huge(1.0_real64) / 8
  ! Distance of the numbers along both axes, points: more than the numbers take.
  integer, parameter :: distance(2) = [66, 38]
  ! Longer numbers get a power of ten, those with more digits an offset, in the name of the axis.
  integer, parameter :: longest_number = 7, most_digits = 6
  real(real64), parameter :: degrees = 57.29577951308232_real64
  ! Steps of a path below this share of its range are rounding.
  real(real64), parameter :: rounding = 1.0e-9_real64
  ! Smaller circles are drawn as dots, points.
  real(real64), parameter :: least_radius = 0.5_real64
  ! An arrow needs a branch of this length, points; a curve has no more arrows.
  real(real64), parameter :: shortest_branch = 12.0_real64
  integer, parameter :: most_arrows = 24

  !> Axis along an edge of the frame.
  type :: plot_axis
    character(len=60) :: name = ''           !! quantity
    character(len=20) :: unit = ''           !! of the quantity; blank: a plain number
    real(real64) :: low = 0.0_real64         !! at the left, or at the foot
    real(real64) :: high = 1.0_real64        !! at the other end, more than `low`
    logical :: is_log = .false.              !! decades are equally long; `low` is more than 0
  end type plot_axis

  !> A drawing: its axes and sizes are set, then it begins.
  type :: svg_plot
    type(plot_axis) :: axes(3)               !! to the right, upwards, of the colour bar
    character(len=:), allocatable :: title   !! of a file of its own; not allocated: in a page
    integer :: longest = 0                   !! longer side of a plan, points; 0: a diagram
    integer :: notes = 0                     !! lines of notes below a plan
    logical :: has_colours = .false.         !! it has pixels and a colour bar
    real(real64) :: frame(2) = diagram       !! its size in the drawing's points
  contains
    procedure :: begin_plot      !! frame and axes
    procedure :: add_curve       !! points joined by straight lines
    procedure :: add_arrows      !! direction of a curve that turns back
    procedure :: add_dot         !! one point, with what it says
    procedure :: add_circle      !! a circle of a true size
    procedure :: add_pixels      !! values as colours, with their colour bar
    procedure :: add_marks       !! small dots of one path
    procedure :: add_note        !! a line below a plan
    procedure :: add_surface     !! outline and summits of a surface in plan
    procedure :: repeat_surface  !! the same surface, displaced
  end type svg_plot

contains

  !> An axis over values, with some room at both ends.
  pure type(plot_axis) function axis_over(name, unit, values, is_log) result(axis)
    character(len=*), intent(in) :: name      !! name of the quantity
    character(len=*), intent(in) :: unit      !! of the quantity; blank: a plain number
    real(real64), intent(in) :: values(:)     !! finite, at least one; more than 0 for decades
    logical, intent(in) :: is_log             !! decades are equally long
    real(real64) :: room

    axis%name = name
    axis%unit = unit
    axis%is_log = is_log
    axis%low = max(minval(values), -largest)
    axis%high = min(maxval(values), largest)
    if (is_log) then
      room = max((axis%high / axis%low)**0.05_real64, 1.2_real64)
      axis%low = axis%low / room
      axis%high = axis%high * room
    else
      room = max(0.05_real64 * (axis%high - axis%low), &
                 0.5_real64 * (least_span * max(abs(axis%low), abs(axis%high)) - &
                               (axis%high - axis%low)))
      if (.not. room > 0.0_real64) room = 1.0_real64
      axis%low = axis%low - room
      axis%high = axis%high + room
    end if
  end function axis_over

  !> Begins a drawing: frame, marks, names of the axes, a plan with a scale bar. Its axes, sizes and
  !> title are set.
  subroutine begin_plot(self, label, buffer, is_again)
    class(svg_plot), intent(inout) :: self        !! drawing that begins
    character(len=*), intent(in) :: label         !! what it shows, for screen readers
    type(text_buffer), intent(inout) :: buffer    !! gets the page
    logical, intent(in), optional :: is_again     !! the axes are those of the first plan of a page
    type(text_buffer) :: marks
    integer, parameter :: widest_letter = 8  ! points of a title
    character(len=:), allocatable :: names, sizes, title
    real(real64) :: corner(2), room(2)
    integer :: axis, letters

    associate (spans => self%axes(:2)%high - self%axes(:2)%low)
      if (self%longest > 0) self%frame = spans * (self%longest / maxval(spans))
      if (self%has_colours) self%frame = max(self%frame, least_side)
    end associate
    corner = -real([left, above], real64)
    room = self%frame + [left + right, above + below]
    if (self%longest > 0) then
      corner(2) = corner(2) - line
      room(2) = room(2) + line + bar_line + note_line * self%notes
    end if
    if (self%has_colours) room = max(room + [beside + bar + numbers - right, 0], &
                                     [0.0_real64, real(above + least_bar + below, real64)])
    do axis = 1, 2
      call put_marks(self, axis, names, marks)
      ! A name of two lines.
      if (len(names) > longest_name) room(2) = room(2) + line
      if (len(names) > longest_name .and. axis == 2) corner(2) = corner(2) - line
      if (axis == 1) call put_name(names, self%frame + [0, 36], 'end', marks)
      if (axis == 2) call put_name(names, [8.0_real64 - left, -16.0_real64 - &
                                   merge(line, 0, len(names) > longest_name)], 'start', marks)
    end do
    sizes = point_text(room(1)) // ' ' // point_text(room(2))
    call buffer%append('<svg viewBox="' // point_text(corner(1)) // ' ' // &
                       point_text(corner(2)) // ' ' // sizes // '" role="' // &
                       trim(merge('group', 'img  ', self%longest > 0)) // '" aria-label="' // &
                       escaped_text(label) // '"')
    if (allocated(self%title)) then
      call buffer%line(' xmlns="http://www.w3.org/2000/svg" width="' // point_text(room(1)) // &
                       '" height="' // point_text(room(2)) // '">')
      call buffer%line('<style>text{font:13px sans-serif}.bar{stroke:black;fill:none}' // &
                       '.grid{stroke:#ccc;fill:none}</style>')
      call buffer%line('<rect' // place_attributes(corner) // &
                       ' width="100%" height="100%" fill="white"/>')
      title = self%title
      letters = int(room(1)) / widest_letter
      if (len(title) > letters) title = title(:letters - 3) // '...'
      call put_text(corner + [8, 18], 'start" style="font-weight:bold', title, buffer)
    else
      call buffer%line('>')
    end if
    if (present(is_again)) then
      if (is_again) then
        call buffer%line('<use href="#axes" aria-hidden="true"/>')
        return
      end if
    end if
    call buffer%line('<g' // trim(merge(' id="axes"', '          ', self%longest > 0 .and. &
                                        .not. self%has_colours)) // ' aria-hidden="true">')
    call buffer%append_text(marks)
    call put_frame([0.0_real64, 0.0_real64], self%frame, 'grid', buffer)
    if (self%longest > 0) call put_bar(self, buffer)
    call buffer%line('</g>')
  end subroutine begin_plot

  ! A text; what follows its anchor may be further attributes.
  subroutine put_text(place, anchor, text, buffer)
    real(real64), intent(in) :: place(2)
    character(len=*), intent(in) :: anchor, text
    type(text_buffer), intent(inout) :: buffer

    call buffer%line('<text' // place_attributes(place) // ' text-anchor="' // anchor // '">' // &
                     escaped_text(text) // '</text>')
  end subroutine put_text

  ! The name of an axis: a long one has its unit in a second line.
  subroutine put_name(name, place, anchor, buffer)
    character(len=*), intent(in) :: name, anchor
    real(real64), intent(in) :: place(2)
    type(text_buffer), intent(inout) :: buffer
    integer :: last

    last = len(name)
    if (last > longest_name .and. index(name, ' (') > 0) last = index(name, ' (')
    call put_text(place, anchor, name(:last), buffer)
    if (last < len(name)) call put_text(place + [0, line], anchor, name(last + 1:), buffer)
  end subroutine put_name

  ! The sides of a rectangle.
  subroutine put_frame(corner, sides, style, buffer)
    real(real64), intent(in) :: corner(2), sides(2)
    character(len=*), intent(in) :: style
    type(text_buffer), intent(inout) :: buffer

    call buffer%line('<rect class="' // style // '"' // place_attributes(corner) // ' width="' // &
                     point_text(sides(1)) // '" height="' // point_text(sides(2)) // '"/>')
  end subroutine put_frame

  ! Numbers along one axis or the colour bar: decades, or multiples of 1, 2 or 5 times a power of
  ! ten. `name` gets the quantity, an offset and a power of ten where the numbers would be long, and
  ! the unit.
  subroutine put_marks(self, which, name, buffer)
    class(svg_plot), intent(in) :: self
    integer, intent(in) :: which
    character(len=:), allocatable, intent(out) :: name
    type(text_buffer), intent(inout) :: buffer
    integer, parameter :: most = 16
    character(len=:), allocatable :: at, number, unit
    type(plot_axis) :: axis
    integer, parameter :: edges(3) = [1, 2, 2]
    real(real64) :: values(most), shown(most), offset, place, step
    integer :: number_of_digits, k, marks, power

    axis = self%axes(which)
    offset = 0.0_real64
    marks = 0
    number_of_digits = 1
    if (axis%is_log) call list_decades(axis, values, marks)
    if (.not. axis%high > axis%low) then
      marks = 1
      values(1) = axis%low
    else if (marks < 2) then
      step = round_step((axis%high - axis%low) / max(3, min(8, int(self%frame(edges(which))) / &
                                                               distance(edges(which)))))
      number_of_digits = 2 + int(max(0.0_real64, log10(max(abs(axis%low), abs(axis%high)) / step)))
      marks = 0
      do k = 0, most - 1
        ! Zero, but for rounding.
        values(marks + 1) = step * (anint(axis%low / step) + k)
        if (abs(values(marks + 1)) < 0.5_real64 * step) values(marks + 1) = 0.0_real64
        if (values(marks + 1) >= axis%low .and. values(marks + 1) <= axis%high) marks = marks + 1
      end do
      if (number_of_digits > most_digits) then
        offset = values(1)
        number_of_digits = 2
      end if
    end if
    shown = 0.0_real64
    shown(:marks) = values(:marks) - offset
    power = 0
    do k = 1, marks
      if (len(number_text(shown(k), number_of_digits)) > longest_number .and. .not. axis%is_log) &
        power = max(-300, floor(log10(maxval(abs(shown(:marks))))))
    end do
    do k = 1, marks
      number = number_text(shown(k) / 10.0_real64**power, number_of_digits)
      place = place_of(self, which, values(k))
      at = point_text(place)
      select case (which)
      case (1)
        call buffer%append('<path class="grid" d="M' // at // ' 0V' // &
                           point_text(self%frame(2)) // '"/>')
        call put_text([place, self%frame(2) + 17], 'middle', number, buffer)
      case (2)
        call buffer%append('<path class="grid" d="M0 ' // at // 'H' // &
                           point_text(self%frame(1)) // '"/>')
        call put_text([-6.0_real64, place + 4.5_real64], 'end', number, buffer)
      case default
        call put_text([self%frame(1) + beside + bar + 6, place + 4.5_real64], 'start', number, &
                      buffer)
      end select
    end do
    name = trim(axis%name)
    if (abs(offset) > 0.0_real64) name = name // merge(' - ', ' + ', offset > 0.0_real64) // &
                                         number_text(abs(offset), 15)
    unit = trim(axis%unit)
    if (power /= 0) unit = trim(number_text(10.0_real64**power, 1) // ' ' // unit)
    name = with_unit(name, unit)
  end subroutine put_marks

  ! Powers of ten within an axis; for less than two decades their doubles and fives, too.
  pure subroutine list_decades(axis, values, marks)
    type(plot_axis), intent(in) :: axis
    real(real64), intent(inout) :: values(:)
    integer, intent(inout) :: marks
    integer, parameter :: parts(3) = [1, 2, 5]
    real(real64) :: decades, value
    integer :: part, power

    decades = log10(axis%high / axis%low)
    do power = floor(log10(axis%low)), floor(log10(axis%high)), 1 + int(decades / 7.0_real64)
      do part = 1, merge(size(parts), 1, decades < 2.0_real64)
        value = parts(part) * 10.0_real64**power
        if (value < axis%low .or. value > axis%high) cycle
        marks = marks + 1
        values(marks) = value
      end do
    end do
  end subroutine list_decades

  ! The least of 1, 2, 5 times a power of ten that is not below a length.
  pure real(real64) function round_step(length) result(step)
    real(real64), intent(in) :: length
    integer, parameter :: steps(4) = [1, 2, 5, 10]
    integer :: k

    step = 10.0_real64**floor(log10(length))
    do k = 1, size(steps) - 1
      if (length / step <= steps(k)) exit
    end do
    step = step * steps(k)
  end function round_step

  ! A length below a plan: a sixth of its width, or somewhat more.
  subroutine put_bar(self, buffer)
    class(svg_plot), intent(in) :: self
    type(text_buffer), intent(inout) :: buffer
    character(len=:), allocatable :: name
    real(real64) :: foot, length, points

    associate (axis => self%axes(1))
      length = round_step((axis%high - axis%low) / 6)
      points = length * (self%frame(1) / (axis%high - axis%low))
      foot = self%frame(2) + below + 8
      name = number_text(length, 1)
      if (axis%unit /= 'length' .and. len_trim(axis%unit) <= longest_unit) &
        name = trim(name // ' ' // axis%unit)
    end associate
    call buffer%line('<path class="bar" d="M0 ' // point_text(foot) // 'v6m0-3h' // &
                     point_text(points) // 'm0-3v6"/>')
    call put_text([points + 8, foot + 7], 'start', name, buffer)
  end subroutine put_bar

  !> Points joined by straight lines.
  subroutine add_curve(self, x, y, buffer)
    class(svg_plot), intent(in) :: self          !! plot that has axes
    real(real64), intent(in) :: x(:), y(:)       !! values across, and as many up
    type(text_buffer), intent(inout) :: buffer   !! gets the page
    integer :: i

    call buffer%append('<path class="curve" d="')
    do i = 1, size(x)
      call buffer%append(merge('M', 'L', i == 1) // point_text(place_of(self, 1, x(i))) // ' ' // &
                         point_text(place_of(self, 2, y(i))))
    end do
    call buffer%line('"/>')
  end subroutine add_curve

  !> Arrows along the curve of a path that turns back, one between two reversals.
  subroutine add_arrows(self, x, y, path, buffer)
    class(svg_plot), intent(in) :: self          !! plot that has axes
    real(real64), intent(in) :: x(:), y(:)       !! values across, and as many up
    real(real64), intent(in) :: path(:)          !! rises and falls between the reversals, as many
    type(text_buffer), intent(inout) :: buffer   !! gets the page
    real(real64) :: at(2, size(x)), length(size(x)), move(2), step
    integer :: drawn, i, k, turn
    logical :: rises, rose

    drawn = 0
    turn = 1
    rose = .true.
    at(1, :) = [(place_of(self, 1, x(i)), i = 1, size(x))]
    at(2, :) = [(place_of(self, 2, y(i)), i = 1, size(x))]
    length(1) = 0.0_real64
    do i = 2, size(x)
      length(i) = length(i - 1) + norm2(at(:, i) - at(:, i - 1))
      step = path(i) - path(i - 1)
      rises = merge(step > 0.0_real64, rose, abs(step) > rounding * (maxval(path) - minval(path)))
      if (i > 2 .and. (rises .neqv. rose)) call put_arrow(i - 1)
      rose = rises
    end do
    if (turn > 1) call put_arrow(size(x))

  contains

    subroutine put_arrow(last)
      integer, intent(in) :: last

      if (length(last) - length(turn) > shortest_branch .and. drawn < most_arrows) then
        ! Nearer to the beginning: those of the same line in both directions lie apart.
        k = turn + count(length(turn + 1:last - 1) < 0.6_real64 * length(turn) + &
                         0.4_real64 * length(last)) + 1
        move = at(:, k) - at(:, k - 1)
        call buffer%line('<path class="arrow" d="M7 0L-5 4.5V-4.5z" transform="translate(' // &
                         point_text(sum(at(1, k - 1:k)) / 2) // ' ' // &
                         point_text(sum(at(2, k - 1:k)) / 2) // ')rotate(' // &
                         point_text(atan2(move(2), move(1)) * degrees) // ')"/>')
        drawn = drawn + 1
      end if
      turn = last
    end subroutine put_arrow

  end subroutine add_arrows

  !> One point.
  subroutine add_dot(self, x, y, text, buffer)
    class(svg_plot), intent(in) :: self         !! plot that has axes
    real(real64), intent(in) :: x, y            !! values across and up, units of the axes
    character(len=*), intent(in) :: text        !! text that names it
    type(text_buffer), intent(inout) :: buffer  !! gets the page

    call buffer%line('<circle class="dot" cx="' // point_text(place_of(self, 1, x)) // '" cy="' // &
                     point_text(place_of(self, 2, y)) // '" r="3"><title>' // &
                     escaped_text(text) // '</title></circle>')
  end subroutine add_dot

  !> A circle at its place and of its size, but no smaller than a dot. `stops`: it can be reached
  !> with the keyboard, and its text appears above the frame then; the others show theirs to the
  !> mouse alone.
  subroutine add_circle(self, x, y, radius, text, stops, buffer)
    class(svg_plot), intent(in) :: self         !! plot with equal scales
    real(real64), intent(in) :: x, y            !! values across and up, units of the axes
    real(real64), intent(in) :: radius          !! in the unit of the axes
    character(len=*), intent(in) :: text        !! text that names it
    logical, intent(in) :: stops                !! with the keyboard, too
    type(text_buffer), intent(inout) :: buffer  !! gets the page
    integer :: last

    if (stops) call buffer%append('<g class="patch" tabindex="0" role="img" aria-label="' // &
                                  escaped_text(text) // '">')
    call buffer%line('<circle cx="' // point_text(place_of(self, 1, x)) // '" cy="' // &
                     point_text(place_of(self, 2, y)) // '" r="' // &
                     number_text(max(least_radius, radius * self%frame(1) / &
                                     (self%axes(1)%high - self%axes(1)%low)), 3) // &
                     '"><title>' // escaped_text(text) // '</title></circle>')
    if (.not. stops) return
    last = len(text)
    if (last > longest_note) last = index(text(:longest_note), ', ', back=.true.)
    call put_text(real([8 - left, -31 - line], real64), 'start" class="note', text(:last), buffer)
    if (last < len(text)) &
      call put_text(real([8 - left, -31], real64), 'start" class="note', text(last + 2:), buffer)
    call buffer%line('</g>')
  end subroutine add_circle

  !> Values of pixels as colours over the whole frame, and the colour bar with its numbers.
  subroutine add_pixels(self, values, has_blank, buffer)
    class(svg_plot), intent(in) :: self         !! plan with a third axis
    real(real64), intent(in) :: values(:, :)    !! by x and y; `not_computed` where not measured
    logical, intent(in) :: has_blank            !! a value of 0 has no colour
    type(text_buffer), intent(inout) :: buffer  !! gets the drawing
    character(len=:), allocatable :: name
    integer :: colour(size(values, 1), size(values, 2)), i, j

    associate (low => self%axes(3)%low, high => self%axes(3)%high)
      do j = 1, size(values, 2)
        do i = 1, size(values, 1)
          associate (at => colour(i, size(values, 2) + 1 - j), value => values(i, j))
            at = first_colour
            if (high > low) at = first_colour + nint((last_colour - first_colour) * &
                                                     ((min(max(value, low), high) - low) / &
                                                      (high - low)))
            if (has_blank .and. .not. abs(value) > 0.0_real64) at = blank_colour
            if (.not. value > not_computed) at = missing_colour
          end associate
        end do
      end do
    end associate
    call put_image([0.0_real64, 0.0_real64], self%frame, colour, buffer)
    associate (corner => [self%frame(1) + beside, 0.0_real64], &
               sides => [real(bar, real64), bar_height(self)])
      call put_image(corner, sides, reshape([(i, i=last_colour, first_colour, -1)], &
                                            [1, last_colour - first_colour + 1]), buffer)
      call put_marks(self, 3, name, buffer)
      call put_name(name, [self%frame(1) + beside + bar + numbers - 8, -16.0_real64 - &
                           merge(line, 0, len(name) > longest_name)], 'end', buffer)
    end associate
  end subroutine add_pixels

  ! An image with a frame; each of its pixels is a rectangle of one colour.
  subroutine put_image(corner, sides, colour, buffer)
    real(real64), intent(in) :: corner(2), sides(2)
    integer, intent(in) :: colour(:, :)
    type(text_buffer), intent(inout) :: buffer

    call buffer%append('<image' // place_attributes(corner) // ' width="' // &
                       point_text(sides(1)) // '" height="' // point_text(sides(2)) // &
                       '" preserveAspectRatio="none" style="image-rendering:pixelated" href="')
    call buffer%append(image_address(colour))
    call buffer%line('"/>')
    call put_frame(corner, sides, 'bar', buffer)
  end subroutine put_image

  ! Height of the colour bar, points.
  pure real(real64) function bar_height(self)
    class(svg_plot), intent(in) :: self

    bar_height = max(self%frame(2), real(least_bar, real64))
  end function bar_height

  !> Small dots of one path.
  subroutine add_marks(self, x, y, diameter, buffer)
    class(svg_plot), intent(in) :: self         !! plot that has axes
    real(real64), intent(in) :: x(:), y(:)      !! values across, and as many up
    integer, intent(in) :: diameter             !! of a dot, points
    type(text_buffer), intent(inout) :: buffer  !! gets the drawing
    integer :: i

    call buffer%append('<path fill="none" stroke="#d02020" stroke-linecap="round" ' // &
                       'stroke-width="' // number_text(real(diameter, real64)) // '" d="')
    do i = 1, size(x)
      call buffer%append('M' // point_text(place_of(self, 1, x(i))) // ' ' // &
                         point_text(place_of(self, 2, y(i))) // 'h0')
    end do
    call buffer%line('"/>')
  end subroutine add_marks

  !> A line below a plan, behind a square of its colour where it explains one.
  subroutine add_note(self, number, text, buffer, colour)
    class(svg_plot), intent(in) :: self               !! plan with such lines
    integer, intent(in) :: number                     !! of the line, from 1
    character(len=*), intent(in) :: text              !! text of one line
    type(text_buffer), intent(inout) :: buffer        !! gets the drawing
    character(len=*), intent(in), optional :: colour  !! name of the colour
    real(real64) :: place(2)

    place = [0.0_real64, self%frame(2) + below + bar_line + note_line * number - 8]
    if (present(colour)) then
      call buffer%append('<rect stroke="black" fill="' // colour // '"' // &
                         place_attributes(place - [0, 11]) // ' width="12" height="12"/>')
      place(1) = place(1) + 18
    end if
    call put_text(place, 'start', text, buffer)
  end subroutine add_note

  !> Outline and summits of a surface in plan.
  subroutine add_surface(self, name, points, buffer)
    class(svg_plot), intent(in) :: self         !! plot with equal scales
    character(len=*), intent(in) :: name        !! `upper` or `lower` surface
    real(real64), intent(in) :: points(:, :)    !! x and y of four corners, then of the summits
    type(text_buffer), intent(inout) :: buffer  !! gets the page
    integer :: i

    call buffer%line('<g id="' // name // '" aria-hidden="true"><path class="' // name // &
                     ' outline" d="M' // place_text(1) // 'L' // place_text(2) // 'L' // &
                     place_text(3) // 'L' // place_text(4) // 'z"/>')
    if (size(points, 2) > 4) call buffer%append('<path class="' // name // ' summits" d="')
    do i = 5, size(points, 2)
      call buffer%append('M' // place_text(i) // trim(merge('h0            ', 'm-3 0h6m-3-3v6', &
                                                       name == 'lower')))
    end do
    if (size(points, 2) > 4) call buffer%line('"/>')
    call buffer%line('</g>')

  contains

    function place_text(i) result(text)
      integer, intent(in) :: i
      character(len=:), allocatable :: text

      text = point_text(place_of(self, 1, points(1, i))) // ' ' // &
             point_text(place_of(self, 2, points(2, i)))
    end function place_text

  end subroutine add_surface

  !> A surface that an earlier drawing has, displaced from its place there.
  subroutine repeat_surface(self, name, shift, buffer)
    class(svg_plot), intent(in) :: self         !! plot with equal scales
    character(len=*), intent(in) :: name        !! `upper` or `lower` surface
    real(real64), intent(in) :: shift(2)        !! along x and y, in the unit of the axes
    type(text_buffer), intent(inout) :: buffer  !! gets the page
    real(real64) :: points(2)

    points = shift * self%frame / (self%axes(:2)%high - self%axes(:2)%low)
    call buffer%line('<use href="#' // name // '" transform="translate(' // &
                     point_text(points(1)) // &
                     ' ' // point_text(-points(2)) // ')" aria-hidden="true"/>')
  end subroutine repeat_surface

  ! Where a value stands in the drawing; its y grows downwards.
  pure real(real64) function place_of(self, which, value) result(place)
    class(svg_plot), intent(in) :: self
    integer, intent(in) :: which
    real(real64), intent(in) :: value

    associate (low => self%axes(which)%low, high => self%axes(which)%high, &
               sides => [self%frame, bar_height(self)])
      place = min(max(value, low), high)
      if (self%axes(which)%is_log) then
        place = log(place / low) / log(high / low)
      else if (high > low) then
        place = (place - low) / (high - low)
      end if
      place = place * sides(which)
      if (which > 1) place = sides(which) - place
    end associate
  end function place_of

  ! A place with two decimals.
  pure function point_text(value) result(text)
    real(real64), intent(in) :: value
    character(len=:), allocatable :: text

    text = number_text(anint(100 * value) / 100, 6)
  end function point_text

  pure function place_attributes(place) result(text)
    real(real64), intent(in) :: place(2)
    character(len=:), allocatable :: text

    text = ' x="' // point_text(place(1)) // '" y="' // point_text(place(2)) // '"'
  end function place_attributes

end module asperity_svg_plot
