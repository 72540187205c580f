!> A drawing with two axes inside a page (SVG): curves, dots, circles. Colours are those of the
!> page's style (`asperity_html_page`).
module asperity_svg_plot
  use asperity_html_page, only: escaped, readable
  use asperity_kinds, only: real64
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: plot_axis, svg_plot, axis_over

  ! Frame and room around it in points. A letter has 13 of them: on the narrowest screens a drawing
  ! is as wide as a page, 360 points, and its letters are of the size of others.
  integer, parameter :: width = 300, height = 200
  integer, parameter :: left = 74, right = 14, above = 44, below = 42
  ! A span of values that are equal but for rounding shows no more of them than this share.
  real(real64), parameter :: least_span = 1.0e-3_real64
  ! Numbers beyond that have no room for a span.
  real(real64), parameter :: largest = huge(1.0_real64) / 8
  ! At most so many marks along an axis: wider apart than their numbers.
  integer, parameter :: marks = 5

  !> What stands along an edge of the frame.
  type :: plot_axis
    character(len=60) :: name = ''           !! quantity and unit
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
    procedure :: begin    !! frame and axes
    procedure :: curve    !! points joined by straight lines
    procedure :: dot      !! one point, with what it says
    procedure :: circle   !! a circle of a true size
    procedure :: finish   !! the end
  end type svg_plot

contains

  !> An axis over values, with some room at both ends.
  pure type(plot_axis) function axis_over(name, values, is_log) result(axis)
    character(len=*), intent(in) :: name      !! quantity and unit
    real(real64), intent(in) :: values(:)     !! finite, at least one; more than 0 for decades
    logical, intent(in) :: is_log             !! decades are equally long
    real(real64) :: room

    axis%name = name
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
  subroutine begin(self, label, across, up, buffer, is_true, is_again)
    class(svg_plot), intent(out) :: self          !! the drawing
    character(len=*), intent(in) :: label         !! what it shows, for who cannot see it
    type(plot_axis), intent(in) :: across         !! to the right
    type(plot_axis), intent(in) :: up             !! upwards
    type(text_buffer), intent(inout) :: buffer    !! the page
    logical, intent(in), optional :: is_true      !! a unit is as long upwards as to the right
    logical, intent(in), optional :: is_again     !! the axes are those of the first true drawing
    logical :: again

    again = .false.
    if (present(is_again)) again = is_again

    self%across = across
    self%up = up
    self%frame = [width, height]
    if (present(is_true)) &
      self%frame = [across%high - across%low, up%high - up%low] * &
                   (width / max(across%high - across%low, up%high - up%low))
    call buffer%line('<svg viewBox="' // number(-real(left, real64)) // ' ' // &
                     number(-real(above, real64)) // ' ' // &
                     number(real(left + right + width, real64)) // ' ' // &
                     number(self%frame(2) + above + below) // '" role="' // &
                     trim(merge('group', 'img  ', present(is_true))) // '" aria-label="' // &
                     escaped(label) // '">')
    if (again) then
      call buffer%line('<use href="#axes" aria-hidden="true"/>')
      return
    end if
    call buffer%line('<g' // trim(merge(' id="axes"', '          ', present(is_true))) // &
                     ' aria-hidden="true">')
    call put_marks(self, 1, buffer)
    call put_marks(self, 2, buffer)
    call buffer%line('<rect class="grid" x="0" y="0" width="' // number(self%frame(1)) // &
                     '" height="' // number(self%frame(2)) // '"/>')
    call buffer%line('<text x="' // number(self%frame(1)) // '" y="' // &
                     number(self%frame(2) + 36) // '" text-anchor="end">' // &
                     escaped(trim(across%name)) // '</text>')
    call buffer%line('<text x="' // number(8.0_real64 - left) // '" y="-10">' // &
                     escaped(trim(up%name)) // '</text>')
    call buffer%line('</g>')
  end subroutine begin

  ! Marks along one axis: multiples of 1, 2 or 5 times a power of ten.
  subroutine put_marks(self, which, buffer)
    class(svg_plot), intent(in) :: self
    integer, intent(in) :: which
    type(text_buffer), intent(inout) :: buffer
    integer, parameter :: steps(4) = [1, 2, 5, 10]
    type(plot_axis) :: axis
    real(real64) :: step, value
    integer :: digits, k, last

    axis = self%across
    if (which == 2) axis = self%up
    step = 0.0_real64
    if (axis%is_log) then
      last = floor(log10(axis%high))
      do k = ceiling(log10(axis%low)), last, 1 + int(log10(axis%high / axis%low)) / (marks + 2)
        call put_mark(10.0_real64**k, 1)
      end do
      return
    end if
    step = 10.0_real64**floor(log10((axis%high - axis%low) / marks))
    do k = 1, size(steps)
      if ((axis%high - axis%low) / step <= steps(k) * marks) exit
    end do
    step = step * steps(min(k, size(steps)))
    value = step * aint(axis%low / step)
    if (value < axis%low) value = value + step
    digits = 2 + int(max(0.0_real64, log10(max(abs(axis%low), abs(axis%high)) / step)))
    k = 0
    do while (value + k * step <= axis%high .and. k <= marks + 1)
      call put_mark(value + k * step, min(digits, 15))
      k = k + 1
    end do

  contains

    subroutine put_mark(at, digits)
      real(real64), intent(in) :: at
      integer, intent(in) :: digits
      real(real64) :: shown
      character(len=:), allocatable :: place

      ! Zero, but for rounding.
      shown = at
      if (.not. axis%is_log .and. abs(at) < 0.5_real64 * step) shown = 0.0_real64
      if (which == 1) then
        place = number(place_of(self, 1, at))
        call buffer%line('<path class="grid" d="M' // place // ' 0V' // number(self%frame(2)) // &
                         '"/><text x="' // place // '" y="' // number(self%frame(2) + 17) // &
                         '" text-anchor="middle">' // readable(shown, digits) // '</text>')
      else
        place = number(place_of(self, 2, at))
        call buffer%line('<path class="grid" d="M0 ' // place // 'H' // number(self%frame(1)) // &
                         '"/><text x="-6" y="' // number(place_of(self, 2, at) + 4.5_real64) // &
                         '" text-anchor="end">' // readable(shown, digits) // '</text>')
      end if
    end subroutine put_mark

  end subroutine put_marks

  !> Points joined by straight lines.
  subroutine curve(self, x, y, buffer)
    class(svg_plot), intent(in) :: self          !! begun
    real(real64), intent(in) :: x(:)             !! across
    real(real64), intent(in) :: y(:)             !! up, as many
    type(text_buffer), intent(inout) :: buffer   !! the page
    integer :: i

    call buffer%append('<path class="curve" d="')
    do i = 1, size(x)
      call buffer%append(merge('M', 'L', i == 1) // number(place_of(self, 1, x(i))) // ' ' // &
                         number(place_of(self, 2, y(i))))
    end do
    call buffer%line('"/>')
  end subroutine curve

  !> One point.
  subroutine dot(self, x, y, says, buffer)
    class(svg_plot), intent(in) :: self         !! begun
    real(real64), intent(in) :: x               !! across
    real(real64), intent(in) :: y               !! up
    character(len=*), intent(in) :: says        !! what it is
    type(text_buffer), intent(inout) :: buffer  !! the page

    call buffer%line('<circle class="dot" cx="' // number(place_of(self, 1, x)) // '" cy="' // &
                     number(place_of(self, 2, y)) // '" r="3"><title>' // escaped(says) // &
                     '</title></circle>')
  end subroutine dot

  !> A circle at its place and of its size. `stops`: it can be reached with the keyboard, and what
  !> it says is written above the frame then; the others say it to the mouse alone.
  subroutine circle(self, x, y, radius, says, stops, buffer)
    class(svg_plot), intent(in) :: self         !! begun, `is_true`
    real(real64), intent(in) :: x               !! across
    real(real64), intent(in) :: y               !! up
    real(real64), intent(in) :: radius          !! in the unit of the axes
    character(len=*), intent(in) :: says        !! what it is
    logical, intent(in) :: stops                !! with the keyboard, too
    type(text_buffer), intent(inout) :: buffer  !! the page
    character(len=:), allocatable :: drawn

    drawn = 'cx="' // number(place_of(self, 1, x)) // '" cy="' // &
            number(place_of(self, 2, y)) // '" r="' // &
            readable(radius * (self%frame(1) / (self%across%high - self%across%low)), 3) // '"'
    if (stops) then
      call buffer%line('<g class="spot" tabindex="0" role="img" aria-label="' // escaped(says) // &
                       '"><circle ' // drawn // '><title>' // escaped(says) // &
                       '</title></circle><text class="tip" x="' // &
                       number(8.0_real64 - left) // '" y="-28">' // escaped(says) // &
                       '</text></g>')
    else
      call buffer%line('<circle ' // drawn // '><title>' // escaped(says) // '</title></circle>')
    end if
  end subroutine circle

  !> The end of a drawing.
  subroutine finish(self, buffer)
    class(svg_plot), intent(in) :: self         !! begun
    type(text_buffer), intent(inout) :: buffer  !! the page

    if (self%frame(1) > 0.0_real64) call buffer%line('</svg>')
  end subroutine finish

  ! Where a value stands in the drawing; its y grows downwards.
  pure real(real64) function place_of(self, which, value) result(place)
    class(svg_plot), intent(in) :: self
    integer, intent(in) :: which
    real(real64), intent(in) :: value
    type(plot_axis) :: axis

    axis = self%across
    if (which == 2) axis = self%up
    place = min(max(value, axis%low), axis%high)
    if (axis%is_log) then
      place = log(place / axis%low) / log(axis%high / axis%low)
    else
      place = (place - axis%low) / (axis%high - axis%low)
    end if
    place = place * self%frame(which)
    if (which == 2) place = self%frame(2) - place
  end function place_of

  ! A place with two decimals.
  pure function number(value) result(text)
    real(real64), intent(in) :: value
    character(len=:), allocatable :: text

    text = readable(anint(100 * value) / 100, 6)
  end function number

end module asperity_svg_plot
