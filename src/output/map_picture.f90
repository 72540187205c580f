!> A map and its summits as a drawing (SVG): heights as shades of grey, summits as dots.
module asperity_map_picture
  use asperity_height_map, only: height_map, is_measured
  use asperity_html_page, only: escaped
  use asperity_kinds, only: real64
  use asperity_map_summits, only: map_summits
  use asperity_png_image, only: base64, png_bytes
  use asperity_problems, only: real_text, text_of => decimal_text
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: draw_map

  ! The longer side has so many points, and the image no more of them.
  integer, parameter :: longest_side = 512, margin = 40, header = 48, footer = 72
  ! More dots than these say nothing, and make the file large: the highest are drawn.
  integer, parameter :: most_dots = 20000
  ! Black and white stand for heights so many deviations off the mean, and beyond.
  real(real64), parameter :: most_deviations = 3.0_real64

contains

  !> Draws a map. The first profile lies at the bottom.
  subroutine draw_map(title, map, summits, buffer)
    character(len=*), intent(in) :: title       !! what is drawn
    type(height_map), intent(in) :: map         !! levelled
    type(map_summits), intent(in) :: summits    !! of this map
    type(text_buffer), intent(inout) :: buffer  !! the drawing
    real(real64) :: side(2), scale, low, high
    integer :: width, height, step
    character(len=:), allocatable :: unit

    side = map%spacing * [map%columns, map%rows]
    scale = longest_side / maxval(side)
    width = max(1, nint(side(1) * scale))
    height = max(1, nint(side(2) * scale))
    step = (max(map%columns, map%rows) + longest_side - 1) / longest_side
    unit = ''
    if (map%unit /= '') unit = ' ' // map%unit
    call buffer%line('<svg xmlns="http://www.w3.org/2000/svg" width="' // &
                     text_of(max(width, 420) + 2 * margin) // '" height="' // &
                     text_of(height + header + footer) // '" font-family="sans-serif" ' // &
                     'font-size="13">')
    call buffer%line('<rect width="100%" height="100%" fill="white"/>')
    call buffer%line('<text x="' // text_of(margin) // '" y="20" font-weight="bold">' // &
                     escaped(title) // '</text>')
    call buffer%append('<image x="' // text_of(margin) // '" y="' // text_of(header) // &
                       '" width="' // text_of(width) // '" height="' // text_of(height) // &
                       '" preserveAspectRatio="none" style="image-rendering:pixelated" ' // &
                       'href="data:image/png;base64,')
    call buffer%line(base64(png_bytes(shades(map, step, low, high))) // '"/>')
    call buffer%line('<rect x="' // text_of(margin) // '" y="' // text_of(header) // &
                     '" width="' // text_of(width) // '" height="' // text_of(height) // &
                     '" fill="none" stroke="black"/>')
    call draw_dots(map, summits, scale, height, buffer)
    call buffer%line('<text x="' // text_of(margin) // '" y="' // text_of(header - 8) // '">' // &
                     short(side(1)) // ' x ' // short(side(2)) // unit // ', ' // &
                     text_of(size(summits%x)) // ' summits' // &
                     drawn_text(size(summits%x)) // '</text>')
    call draw_scale(short(low) // unit, short(high) // unit, header + height, buffer)
    call buffer%line('</svg>')
  end subroutine draw_map

  ! Mean heights of squares of samples as shades from 1 to 255; 0 where all are missing.
  function shades(map, step, low, high) result(shade)
    type(height_map), intent(in) :: map
    integer, intent(in) :: step
    real(real64), intent(out) :: low, high
    integer, allocatable :: shade(:, :)
    real(real64), allocatable :: mean(:, :)
    real(real64) :: total, middle, room
    integer :: i, j, k, m, number

    allocate (mean((map%columns + step - 1) / step, (map%rows + step - 1) / step))
    allocate (shade(size(mean, 1), size(mean, 2)))
    shade(:, :) = 0
    do j = 1, size(mean, 2)
      do i = 1, size(mean, 1)
        total = 0.0_real64
        number = 0
        do m = (j - 1) * step + 1, min(j * step, map%rows)
          do k = (i - 1) * step + 1, min(i * step, map%columns)
            if (.not. is_measured(map%height(k, m))) cycle
            total = total + map%height(k, m)
            number = number + 1
          end do
        end do
        mean(i, j) = 0.0_real64
        if (number == 0) cycle
        shade(i, j) = 1
        mean(i, j) = total / number
      end do
    end do
    number = count(shade > 0)
    middle = sum(mean, mask=shade > 0) / number
    room = most_deviations * sqrt(sum((mean - middle)**2, mask=shade > 0) / number)
    low = max(middle - room, minval(mean, mask=shade > 0))
    high = min(middle + room, maxval(mean, mask=shade > 0))
    where (shade > 0) shade = 1 + int(254.0_real64 * (min(max(mean, low), high) - low) / &
                                      max(high - low, tiny(high)))
    ! The first profile is the lowest row.
    shade = shade(:, size(shade, 2):1:-1)
  end function shades

  ! The highest summits as dots of one path.
  subroutine draw_dots(map, summits, scale, height, buffer)
    type(height_map), intent(in) :: map
    type(map_summits), intent(in) :: summits
    real(real64), intent(in) :: scale
    integer, intent(in) :: height
    type(text_buffer), intent(inout) :: buffer
    character(len=24) :: dot
    real(real64) :: least, above, below
    integer :: i, round

    ! The height above which so few stand, by halving.
    least = -huge(least)
    if (size(summits%x) > most_dots) then
      below = minval(summits%height)
      above = maxval(summits%height)
      do round = 1, 40
        least = 0.5_real64 * (below + above)
        if (count(summits%height > least) > most_dots) then
          below = least
        else
          above = least
        end if
      end do
      least = above
    end if
    call buffer%append('<path fill="none" stroke="#d02020" stroke-linecap="round" ' // &
                       'stroke-width="' // merge('2', '4', size(summits%x) > 2000) // '" d="')
    do i = 1, size(summits%x)
      if (.not. summits%height(i) > least) cycle
      write (dot, '("M", f0.1, " ", f0.1, "h0")') &
        margin + (summits%x(i) + 0.5_real64 * map%spacing(1)) * scale, &
        header + height - (summits%y(i) + 0.5_real64 * map%spacing(2)) * scale
      call buffer%append(trim(dot))
    end do
    call buffer%line('"/>')
  end subroutine draw_dots

  pure function drawn_text(number) result(text)
    integer, intent(in) :: number
    character(len=:), allocatable :: text

    text = ''
    if (number > most_dots) text = ', the highest ' // text_of(most_dots) // ' drawn'
  end function drawn_text

  ! What the shades mean.
  subroutine draw_scale(low, high, top, buffer)
    character(len=*), intent(in) :: low, high
    integer, intent(in) :: top
    type(text_buffer), intent(inout) :: buffer

    call buffer%line('<linearGradient id="grey"><stop offset="0" stop-color="black"/>' // &
                     '<stop offset="1" stop-color="white"/></linearGradient>')
    call buffer%line('<rect x="' // text_of(margin) // '" y="' // text_of(top + 16) // &
                     '" width="200" height="14" fill="url(#grey)" stroke="black"/>')
    call buffer%line('<text x="' // text_of(margin) // '" y="' // text_of(top + 48) // '">' // &
                     low // '</text>')
    call buffer%line('<text x="' // text_of(margin + 200) // '" y="' // text_of(top + 48) // &
                     '" text-anchor="middle">' // high // '</text>')
    call buffer%line('<circle cx="' // text_of(margin + 300) // '" cy="' // text_of(top + 23) // &
                     '" r="3" fill="#d02020"/><text x="' // text_of(margin + 310) // '" y="' // &
                     text_of(top + 28) // '">summit</text>')
  end subroutine draw_scale

  ! A length with four digits.
  function short(value) result(text)
    real(real64), intent(in) :: value
    character(len=:), allocatable :: text

    text = real_text(value, 'es16.3e3')
    if (abs(value) >= 0.01_real64 .and. abs(value) < 10000.0_real64) &
      text = real_text(value, 'f16.3')
  end function short

end module asperity_map_picture
