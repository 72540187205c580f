!> A drawing with two axes inside a page (SVG): curves, arrows, dots, circles, surfaces in plan.
!> Colours are those of the page's style (`asperity_html_page`).
module asperity_svg_plot
  use asperity_html_page, only: escaped_text
  use asperity_kinds, only: real64
  use asperity_number_format, only: number_text
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: plot_axis, svg_plot, axis_over, round_step

  ! Frame and room around it in points. A letter has 13 of them: on the narrowest screens a drawing
  ! is as wide as a page, 360 points, and its letters are of the size of others.
  integer, parameter :: width = 300, height = 200
  integer, parameter :: left = 74, right = 26, above = 44, below = 42
  ! Line below a plan with its scale bar, points.
  integer, parameter :: bar_line = 24
  ! Widths of letters and of the widest ones, points: a longer text is condensed to its room.
  real(real64), parameter :: letter = 8.0_real64, wide_letter = 13.0_real64
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

  !> A drawing that is begun.
  type :: svg_plot
    type(plot_axis) :: across                !! to the right
    type(plot_axis) :: up                    !! upwards
    real(real64) :: frame(2) = 0.0_real64    !! its size in the drawing's points
  contains
    procedure :: begin_plot    !! frame and axes
    procedure :: add_curve    !! points joined by straight lines
    procedure :: add_arrows   !! direction of a curve that turns back
    procedure :: add_dot      !! one point, with what it says
    procedure :: add_circle   !! a circle of a true size
    procedure :: add_surface  !! outline and summits of a surface in plan
    procedure :: repeat_surface    !! the same surface, displaced
    procedure :: end_plot   !! the end
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

  !> Begins a drawing: frame, marks, names of the axes.
  subroutine begin_plot(self, label, across, up, buffer, is_true, is_again)
    class(svg_plot), intent(out) :: self          !! drawing that begins
    character(len=*), intent(in) :: label         !! what it shows, for screen readers
    type(plot_axis), intent(in) :: across         !! axis to the right
    type(plot_axis), intent(in) :: up             !! the axis upwards
    type(text_buffer), intent(inout) :: buffer    !! gets the page
    logical, intent(in), optional :: is_true      !! equal scales, with a scale bar
    logical, intent(in), optional :: is_again     !! the axes are those of the first true drawing
    character(len=:), allocatable :: name
    integer :: foot

    self%across = across
    self%up = up
    self%frame = [width, height]
    foot = below
    if (present(is_true)) then
      self%frame = [across%high - across%low, up%high - up%low] * &
                   (width / max(across%high - across%low, up%high - up%low))
      foot = below + bar_line
    end if
    call buffer%line('<svg viewBox="' // point_text(-real(left, real64)) // ' ' // &
                     point_text(-real(above, real64)) // ' ' // &
                     point_text(real(left + right + width, real64)) // ' ' // &
                     point_text(self%frame(2) + above + foot) // '" role="' // &
                     trim(merge('group', 'img  ', present(is_true))) // '" aria-label="' // &
                     escaped_text(label) // '">')
    if (present(is_again)) then
      if (is_again) then
        call buffer%line('<use href="#axes" aria-hidden="true"/>')
        return
      end if
    end if
    call buffer%line('<g' // trim(merge(' id="axes"', '          ', present(is_true))) // &
                     ' aria-hidden="true">')
    call put_marks(self, 1, name, buffer)
    call buffer%line('<text x="' // point_text(self%frame(1)) // '" y="' // &
                     point_text(self%frame(2) + 36) // '" text-anchor="end"' // &
                     fitted_length(name, self%frame(1) + left - 8) // '>' // escaped_text(name) // &
                     '</text>')
    call put_marks(self, 2, name, buffer)
    call buffer%line('<text x="' // point_text(8.0_real64 - left) // '" y="-16"' // &
                     fitted_length(name, real(left + right + width - 16, real64)) // '>' // &
                     escaped_text(name) // '</text>')
    call buffer%line('<rect class="grid" x="0" y="0" width="' // point_text(self%frame(1)) // &
                     '" height="' // point_text(self%frame(2)) // '"/>')
    if (present(is_true)) call put_bar(self, buffer)
    call buffer%line('</g>')
  end subroutine begin_plot

  ! Numbers along one axis: decades, or multiples of 1, 2 or 5 times a power of ten. `name` gets
  ! the quantity, an offset and a power of ten where the numbers would be long, and the unit.
  subroutine put_marks(self, which, name, buffer)
    class(svg_plot), intent(in) :: self
    integer, intent(in) :: which
    character(len=:), allocatable, intent(out) :: name
    type(text_buffer), intent(inout) :: buffer
    integer, parameter :: most = 16
    character(len=:), allocatable :: at, unit
    type(plot_axis) :: axis
    real(real64) :: values(most), shown(most), step, offset
    integer :: number_of_digits, k, marks, power

    axis = self%across
    if (which == 2) axis = self%up
    offset = 0.0_real64
    marks = 0
    number_of_digits = 1
    if (axis%is_log) call list_decades(axis, values, marks)
    if (marks < 2) then
      step = round_step((axis%high - axis%low) / max(3, min(8, int(self%frame(which)) / &
                                                               distance(which))))
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
      at = point_text(place_of(self, which, values(k)))
      if (which == 1) then
        call buffer%append('<path class="grid" d="M' // at // ' 0V' // &
                           point_text(self%frame(2)) // &
                           '"/><text x="' // at // '" y="' // point_text(self%frame(2) + 17) // &
                           '" text-anchor="middle">')
      else
        call buffer%append('<path class="grid" d="M0 ' // at // 'H' // &
                           point_text(self%frame(1)) // &
                           '"/><text x="-6" y="' // &
                           point_text(place_of(self, 2, values(k)) + 4.5_real64) // &
                           '" text-anchor="end">')
      end if
      call buffer%line(number_text(shown(k) / 10.0_real64**power, number_of_digits) // '</text>')
    end do
    name = trim(axis%name)
    if (abs(offset) > 0.0_real64) name = name // merge(' - ', ' + ', offset > 0.0_real64) // &
                                         number_text(abs(offset), 15)
    unit = trim(axis%unit)
    if (power /= 0) unit = trim(number_text(10.0_real64**power, 1) // ' ' // unit)
    if (unit /= '') name = name // ' (' // unit // ')'
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

  !> The least of 1, 2, 5 times a power of ten that is not below a length.
  pure real(real64) function round_step(length) result(step)
    real(real64), intent(in) :: length  !! more than 0
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
    character(len=:), allocatable :: foot, name
    real(real64) :: length, points

    length = round_step((self%across%high - self%across%low) / 6)
    points = length * (self%frame(1) / (self%across%high - self%across%low))
    foot = point_text(self%frame(2) + below + 8)
    name = trim(number_text(length, 1) // ' ' // self%across%unit)
    if (self%across%unit == 'length') name = number_text(length, 1)
    call buffer%line('<path class="bar" d="M0 ' // foot // 'v6m0-3h' // point_text(points) // &
                     'm0-3v6"/><text x="' // point_text(points + 8) // '" y="' // &
                     point_text(self%frame(2) + below + 15) // '"' // &
                     fitted_length(name, width + right - points - 16) // '>' // &
                     escaped_text(name) // '</text>')
  end subroutine put_bar

  ! Condenses a text that may be wider than its room.
  pure function fitted_length(text, room) result(attribute)
    character(len=*), intent(in) :: text
    real(real64), intent(in) :: room
    character(len=:), allocatable :: attribute
    real(real64) :: needed
    integer :: i

    needed = 0.0_real64
    do i = 1, len(text)
      ! A letter has one byte that does not continue it (UTF-8).
      if (iachar(text(i:i)) < 128 .or. iachar(text(i:i)) > 191) &
        needed = needed + merge(wide_letter, letter, scan(text(i:i), 'MWmw%@') > 0)
    end do
    attribute = ''
    if (needed > room) &
      attribute = ' textLength="' // point_text(room) // '" lengthAdjust="spacingAndGlyphs"'
  end function fitted_length

  !> Points joined by straight lines.
  subroutine add_curve(self, x, y, buffer)
    class(svg_plot), intent(in) :: self          !! plot that has axes
    real(real64), intent(in) :: x(:)             !! values across, any number
    real(real64), intent(in) :: y(:)             !! up, as many
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
    real(real64), intent(in) :: x(:)             !! values across, any number
    real(real64), intent(in) :: y(:)             !! up, as many
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
    real(real64), intent(in) :: x               !! value across, unit of the axis
    real(real64), intent(in) :: y               !! value upwards, unit of the axis
    character(len=*), intent(in) :: text        !! text that names it
    type(text_buffer), intent(inout) :: buffer  !! gets the page

    call buffer%line('<circle class="dot" cx="' // point_text(place_of(self, 1, x)) // '" cy="' // &
                     point_text(place_of(self, 2, y)) // '" r="3"><title>' // &
                     escaped_text(text) // &
                     '</title></circle>')
  end subroutine add_dot

  !> A circle at its place and of its size, but no smaller than a dot. `stops`: it can be reached
  !> with the keyboard, and its text appears above the frame then; the others show theirs to the
  !> mouse alone.
  subroutine add_circle(self, x, y, radius, text, stops, buffer)
    class(svg_plot), intent(in) :: self         !! plot with equal scales
    real(real64), intent(in) :: x               !! value across, unit of the axis
    real(real64), intent(in) :: y               !! value upwards, unit of the axis
    real(real64), intent(in) :: radius          !! in the unit of the axes
    character(len=*), intent(in) :: text        !! text that names it
    logical, intent(in) :: stops                !! with the keyboard, too
    type(text_buffer), intent(inout) :: buffer  !! gets the page
    character(len=:), allocatable :: drawn

    drawn = '<circle cx="' // point_text(place_of(self, 1, x)) // '" cy="' // &
            point_text(place_of(self, 2, y)) // '" r="' // &
            number_text(max(least_radius, radius * &
                         (self%frame(1) / (self%across%high - self%across%low))), 3) // &
            '"><title>' // escaped_text(text) // '</title></circle>'
    if (stops) then
      call buffer%line('<g class="patch" tabindex="0" role="img" aria-label="' // &
                       escaped_text(text) // &
                       '">' // drawn // '<text class="note" x="' // &
                       point_text(8.0_real64 - left) // &
                       '" y="-31"' // fitted_length(text, real(left + right + width - 16, &
                                                               real64)) // &
                       '>' // escaped_text(text) // '</text></g>')
    else
      call buffer%line(drawn)
    end if
  end subroutine add_circle

  !> Outline and summits of a surface in plan.
  subroutine add_surface(self, name, points, buffer)
    class(svg_plot), intent(in) :: self         !! plot with equal scales
    character(len=*), intent(in) :: name        !! `upper` or `lower` surface
    real(real64), intent(in) :: points(:, :)    !! x and y of four corners, then of the summits
    type(text_buffer), intent(inout) :: buffer  !! gets the page
    integer :: i

    call buffer%line('<g id="' // name // '" aria-hidden="true"><path class="' // name // &
                     ' outline" d="M' // place_text(1) // 'L' // place_text(2) // 'L' // &
                     place_text(3) // 'L' // &
                     place_text(4) // 'z"/>')
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

    points = shift * self%frame / [self%across%high - self%across%low, self%up%high - self%up%low]
    call buffer%line('<use href="#' // name // '" transform="translate(' // &
                     point_text(points(1)) // &
                     ' ' // point_text(-points(2)) // ')" aria-hidden="true"/>')
  end subroutine repeat_surface

  !> The end of a drawing.
  subroutine end_plot(self, buffer)
    class(svg_plot), intent(in) :: self         !! plot that has axes
    type(text_buffer), intent(inout) :: buffer  !! gets the page

    if (self%frame(1) > 0.0_real64) call buffer%line('</svg>')
  end subroutine end_plot

  ! Where a value stands in the drawing; its y grows downwards.
  pure real(real64) function place_of(self, which, value) result(place_text)
    class(svg_plot), intent(in) :: self
    integer, intent(in) :: which
    real(real64), intent(in) :: value
    type(plot_axis) :: axis

    axis = self%across
    if (which == 2) axis = self%up
    place_text = min(max(value, axis%low), axis%high)
    if (axis%is_log) then
      place_text = log(place_text / axis%low) / log(axis%high / axis%low)
    else
      place_text = (place_text - axis%low) / (axis%high - axis%low)
    end if
    place_text = place_text * self%frame(which)
    if (which == 2) place_text = self%frame(2) - place_text
  end function place_of

  ! A place with two decimals.
  pure function point_text(value) result(text)
    real(real64), intent(in) :: value
    character(len=:), allocatable :: text

    text = number_text(anint(100 * value) / 100, 6)
  end function point_text

end module asperity_svg_plot
