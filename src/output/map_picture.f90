!> A map and its summits as a drawing (SVG): heights as shades of grey, summits as dots.
!>
!> The shades are a PNG (W3C, Portable Network Graphics, 2nd ed., 2003) without compression, in
!> base64 (RFC 4648).
module asperity_map_picture
  use asperity_height_map, only: height_map, is_measured
  use asperity_html_page, only: escaped
  use asperity_kinds, only: int64, real64
  use asperity_map_summits, only: map_summits
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

  character(len=*), parameter :: signature = char(137) // 'PNG' // achar(13) // achar(10) // &
    achar(26) // achar(10)
  character(len=*), parameter :: letters = &
    'ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/'
  ! Bytes of a block that is stored as it is.
  integer, parameter :: longest_block = 65535

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
    call buffer%line(png_as_base64(shades(map, step, low, high)) // '"/>')
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

  !> The picture as base64. Shade 0 is transparent.
  pure function png_as_base64(shade) result(text)
    integer, intent(in) :: shade(:, :)     !! from 0 to 255; by column and row, the top row first
    character(len=:), allocatable :: text  !! for a `data:image/png;base64,` address
    type(text_buffer) :: bytes, rows
    integer :: i, j

    do j = 1, size(shade, 2)
      call rows%append(achar(0))
      do i = 1, size(shade, 1)
        call rows%append(char(shade(i, j)))
      end do
    end do
    call bytes%append(signature)
    ! Eight bits of grey, neither filtered nor interlaced.
    call add_chunk('IHDR', word(int(size(shade, 1), int64)) // word(int(size(shade, 2), int64)) // &
                   achar(8) // repeat(achar(0), 4), bytes)
    call add_chunk('tRNS', repeat(achar(0), 2), bytes)
    call add_chunk('IDAT', stored(rows%text()), bytes)
    call add_chunk('IEND', '', bytes)
    text = base64(bytes%text())
  end function png_as_base64

  ! A chunk with its length and its cyclic redundancy check.
  pure subroutine add_chunk(name, content, bytes)
    character(len=*), intent(in) :: name, content
    type(text_buffer), intent(inout) :: bytes
    integer(int64), parameter :: polynomial = int(z'EDB88320', int64), all_32 = 2_int64**32 - 1
    integer(int64) :: check
    character(len=len(name) + len(content)) :: named
    integer :: i, k

    named = name // content
    check = all_32
    do i = 1, len(named)
      check = ieor(check, int(iachar(named(i:i)), int64))
      do k = 1, 8
        check = ieor(shiftr(check, 1), merge(polynomial, 0_int64, btest(check, 0)))
      end do
    end do
    call bytes%append(word(int(len(content), int64)) // named // word(ieor(check, all_32)))
  end subroutine add_chunk

  ! A zlib stream (RFC 1950) of stored blocks, with its check sum.
  pure function stored(bytes) result(stream)
    character(len=*), intent(in) :: bytes
    character(len=:), allocatable :: stream
    type(text_buffer) :: buffer
    integer(int64) :: a, b
    integer :: first, length, i

    call buffer%append(char(120) // achar(1))
    do first = 1, len(bytes), longest_block
      length = min(longest_block, len(bytes) - first + 1)
      call buffer%append(char(merge(1, 0, first + length > len(bytes))) // little(length) // &
                         little(longest_block - length) // bytes(first:first + length - 1))
    end do
    a = 1_int64
    b = 0_int64
    do i = 1, len(bytes)
      a = mod(a + iachar(bytes(i:i)), 65521_int64)
      b = mod(b + a, 65521_int64)
    end do
    call buffer%append(word(65536_int64 * b + a))
    stream = buffer%text()
  end function stored

  ! 32 bits, the highest byte first.
  pure function word(value) result(bytes)
    integer(int64), intent(in) :: value
    character(len=4) :: bytes
    integer :: i

    do i = 1, 4
      bytes(i:i) = char(int(ibits(value, 32 - 8 * i, 8)))
    end do
  end function word

  ! 16 bits, the lowest byte first.
  pure function little(value) result(bytes)
    integer, intent(in) :: value
    character(len=2) :: bytes

    bytes = char(ibits(value, 0, 8)) // char(ibits(value, 8, 8))
  end function little

  pure function base64(bytes) result(text)
    character(len=*), intent(in) :: bytes
    character(len=4 * ((len(bytes) + 2) / 3)) :: text
    character(len=3) :: three
    integer :: i, k, bits, digit

    do i = 0, len(text) / 4 - 1
      three = bytes(3 * i + 1:min(3 * i + 3, len(bytes)))
      k = min(3, len(bytes) - 3 * i)
      three(k + 1:) = repeat(achar(0), 3 - k)
      bits = 65536 * iachar(three(1:1)) + 256 * iachar(three(2:2)) + iachar(three(3:3))
      do k = 1, 4
        digit = ibits(bits, 24 - 6 * k, 6) + 1
        text(4 * i + k:4 * i + k) = letters(digit:digit)
      end do
    end do
    text(len(text) - modulo(-len(bytes), 3) + 1:) = '=='
  end function base64

end module asperity_map_picture
