!> A drawing of images, lines and texts: as SVG, of its own or inside a page, and as PNG.
!>
!> Lengths are in points, from the upper left corner to the right and down. All images share one
!> palette, of which the PNG is made as well.
module asperity_plan_drawing
  use asperity_html_page, only: escaped_text
  use asperity_kinds, only: real64
  use asperity_png_image, only: base64_text, png_bytes
  use asperity_problems, only: decimal_text
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: plan_drawing, add_dots, add_frame, add_image, add_line, add_text, write_svg, png_of
  public :: at_begin, at_middle, at_end
  public :: colour_paper, colour_ink, colour_blank, colour_missing, first_colour, last_colour

  !> Where a text stands beside its place: it begins there, is centred, or ends there.
  integer, parameter :: at_begin = 1, at_middle = 2, at_end = 3
  !> Places in the palette: background, lines and texts, pixels that are left white, pixels without
  !> a value.
  integer, parameter :: colour_paper = 0, colour_ink = 1, colour_blank = 2, colour_missing = 3
  !> Colours of the lowest and of the highest value.
  integer, parameter :: first_colour = 4, last_colour = 255
  character(len=*), parameter :: anchors(3) = [character(len=6) :: 'start', 'middle', 'end']

  ! Letters of a text at most: a title is cut to the width of its drawing before.
  integer, parameter :: longest_text = 200
  ! Dots of a PNG for a point, and dots of a PNG for a dot of a letter.
  integer, parameter :: dots = 2
  ! Viridis (S. van der Walt and N. Smith, 2015) at equal steps; straight lines between.
  integer, parameter :: viridis(3, 9) = reshape( &
    [68, 1, 84, 71, 44, 122, 59, 81, 139, 44, 113, 142, 33, 144, 141, 39, 173, 129, 92, 200, 99, &
     170, 220, 50, 253, 231, 37], [3, 9])

  ! Letters of a PNG as dots, 5 x 7 each: the printable characters of ASCII, in the shapes of
  ! dot-matrix displays. Dots of a letter down and across.
  integer, parameter :: glyph_height = 7, glyph_width = 5

  ! Two hexadecimal digits a column of dots, the lowest bit at the top; from blank to tilde.
  character(len=*), parameter :: glyphs = &
    '000000000000005F00000007000700147F147F14242A7F2A12231308646236495620500008070300' // &
    '001C2241000041221C0014083E081408083E08080050300000080808080800606000002010080402' // &
    '3E5149453E00427F400042615149462141454B311814127F1027454545393C4A4949300171090503' // &
    '3649494936064949291E003636000000563600000814224100141414141400412214080201510906' // &
    '324979413E7E1111117E7F494949363E414141227F4141221C7F494949417F090909013E4149497A' // &
    '7F0808087F00417F41002040413F017F081422417F404040407F020C027F7F0408107F3E4141413E' // &
    '7F090909063E4151215E7F09192946464949493101017F01013F4040403F1F2040201F3F4038403F' // &
    '631408146307087008076151494543007F41410002040810200041417F0004020102044040404040' // &
    '000102040020545454787F484444383844444420384444487F3854545418087E0901020C5252523E' // &
    '7F0804047800447D40002040443D007F1028440000417F40007C041804787C080404783844444438' // &
    '7C14141408081414187C7C080404084854545420043F4440203C4040207C1C2040201C3C4030403C' // &
    '44281028440C5050503C4464544C44000836410000007F000000413608000804081008'

  type :: drawn_image
    integer :: left, top, width, height      ! in the drawing
    integer, allocatable :: colour(:, :)     ! by column and row, the top row first
  end type drawn_image

  type :: drawn_line
    integer :: from(2), to(2)                ! across or down
  end type drawn_line

  type :: drawn_text
    integer :: at(2), anchor                 ! foot of the letters
    logical :: is_bold
    character(len=longest_text) :: text
  end type drawn_text

  !> The drawing.
  type :: plan_drawing
    integer :: width = 0    !! points
    integer :: height = 0   !! points
    type(drawn_image), allocatable, private :: images(:)
    type(drawn_line), allocatable, private :: lines(:)
    type(drawn_text), allocatable, private :: texts(:)
    real(real64), allocatable, private :: dots(:, :)   ! places of the dots
    integer, private :: diameter = 0                   ! of the dots
  end type plan_drawing

contains

  !> Adds an image, each of its pixels a rectangle of one colour.
  subroutine add_image(drawing, left, top, width, height, colour)
    type(plan_drawing), intent(inout) :: drawing  !! gets the new part
    integer, intent(in) :: left                   !! place of its corner [points]
    integer, intent(in) :: top                    !! place of its corner [points]
    integer, intent(in) :: width                  !! size, 1 or more [points]
    integer, intent(in) :: height                 !! size, 1 or more [points]
    integer, intent(in) :: colour(:, :)           !! places in the palette, the top row first
    type(drawn_image), allocatable :: more(:)
    integer :: i, number

    number = 0
    if (allocated(drawing%images)) number = size(drawing%images)
    allocate (more(number + 1))
    do i = 1, number
      more(i) = drawing%images(i)
    end do
    more(number + 1) = drawn_image(left, top, width, height, colour)
    call move_alloc(more, drawing%images)
  end subroutine add_image

  !> Adds a line across or down.
  subroutine add_line(drawing, from, to)
    type(plan_drawing), intent(inout) :: drawing  !! gets the new part
    integer, intent(in) :: from(2)                !! across and down, one end [points]
    integer, intent(in) :: to(2)                  !! across and down, other end [points]

    if (.not. allocated(drawing%lines)) allocate (drawing%lines(0))
    drawing%lines = [drawing%lines, drawn_line(from, to)]
  end subroutine add_line

  !> Adds dots, once for a drawing. A PNG has none.
  subroutine add_dots(drawing, across, down, diameter)
    type(plan_drawing), intent(inout) :: drawing  !! gets the new part
    real(real64), intent(in) :: across(:)         !! distance from the left, points
    real(real64), intent(in) :: down(:)           !! distance from the top, points; as many
    integer, intent(in) :: diameter               !! of a dot, points

    drawing%dots = reshape([across, down], [size(across), 2])
    drawing%diameter = diameter
  end subroutine add_dots

  !> Adds the four sides of a rectangle.
  subroutine add_frame(drawing, left, top, width, height)
    type(plan_drawing), intent(inout) :: drawing  !! gets the new part
    integer, intent(in) :: left                   !! place of its corner [points]
    integer, intent(in) :: top                    !! place of its corner [points]
    integer, intent(in) :: width                  !! size of the rectangle [points]
    integer, intent(in) :: height                 !! size of the rectangle [points]

    call add_line(drawing, [left, top], [left + width, top])
    call add_line(drawing, [left, top + height], [left + width, top + height])
    call add_line(drawing, [left, top], [left, top + height])
    call add_line(drawing, [left + width, top], [left + width, top + height])
  end subroutine add_frame

  !> Adds a text of one line.
  subroutine add_text(drawing, at, anchor, text, is_bold)
    type(plan_drawing), intent(inout) :: drawing   !! gets the new part
    integer, intent(in) :: at(2)                   !! foot of the letters [points]
    integer, intent(in) :: anchor                  !! `at_begin`, `at_middle` or `at_end`
    character(len=*), intent(in) :: text           !! at most `longest_text` letters
    logical, intent(in), optional :: is_bold       !! present: letters are bold

    if (.not. allocated(drawing%texts)) allocate (drawing%texts(0))
    drawing%texts = [drawing%texts, drawn_text(at, anchor, present(is_bold), text)]
  end subroutine add_text

  !> The drawing as SVG. Inside a page it has the colours of the page's style and no background.
  subroutine write_svg(drawing, label, in_page, buffer)
    type(plan_drawing), intent(in) :: drawing    !! drawing with all parts
    character(len=*), intent(in) :: label        !! what it shows, for screen readers
    logical, intent(in) :: in_page               !! whether the text is a part of a page
    type(text_buffer), intent(inout) :: buffer   !! gets the text
    character(len=24) :: dot
    integer :: i

    call buffer%append('<svg viewBox="0 0 ' // decimal_text(drawing%width) // ' ' // &
                       decimal_text(drawing%height) // '" role="img" aria-label="' // &
                       escaped_text(label) // '"')
    if (.not. in_page) call buffer%append(' xmlns="http://www.w3.org/2000/svg" width="' // &
                                          decimal_text(drawing%width) // '" height="' // &
                                          decimal_text(drawing%height) // '"')
    call buffer%line('>')
    if (.not. in_page) then
      call buffer%line('<style>text{font:13px sans-serif}.bar{stroke:black;fill:none}</style>')
      call buffer%line('<rect width="100%" height="100%" fill="white"/>')
    end if
    do i = 1, size(drawing%images)
      associate (image => drawing%images(i))
        call buffer%append('<image' // attribute_text('x', image%left) // attribute_text('y', &
                                                                                     image%top) // &
                           attribute_text('width', image%width) // attribute_text('height', &
                                                                                  image%height) // &
                           ' preserveAspectRatio="none" style="image-rendering:pixelated" ' // &
                           'href="data:image/png;base64,')
        call buffer%append(base64_text(png_bytes(image%colour, colour_palette())))
        call buffer%line('"/>')
      end associate
    end do
    call buffer%append('<path class="bar" d="')
    do i = 1, size(drawing%lines)
      associate (line => drawing%lines(i))
        call buffer%append('M' // decimal_text(line%from(1)) // ' ' // &
                           decimal_text(line%from(2)) // 'L' // decimal_text(line%to(1)) // ' ' // &
                           decimal_text(line%to(2)))
      end associate
    end do
    call buffer%line('"/>')
    if (allocated(drawing%dots)) then
      call buffer%append('<path fill="none" stroke="#d02020" stroke-linecap="round" ' // &
                         'stroke-width="' // decimal_text(drawing%diameter) // '" d="')
      do i = 1, size(drawing%dots, 1)
        write (dot, '("M", f0.1, " ", f0.1, "h0")') drawing%dots(i, :)
        call buffer%append(trim(dot))
      end do
      call buffer%line('"/>')
    end if
    do i = 1, size(drawing%texts)
      associate (text => drawing%texts(i))
        call buffer%append('<text' // attribute_text('x', text%at(1)) // attribute_text('y', &
                                                                                    text%at(2)) // &
                           ' text-anchor="' // trim(anchors(text%anchor)) // '"')
        if (text%is_bold) call buffer%append(' style="font-weight:bold"')
        call buffer%line('>' // escaped_text(trim(text%text)) // '</text>')
      end associate
    end do
    call buffer%line('</svg>')
  end subroutine write_svg

  pure function attribute_text(name, value) result(attribute)
    character(len=*), intent(in) :: name
    integer, intent(in) :: value
    character(len=:), allocatable :: attribute

    attribute = ' ' // name // '="' // decimal_text(value) // '"'
  end function attribute_text

  !> The drawing as a PNG of two pixels a point.
  function png_of(drawing) result(png)
    type(plan_drawing), intent(in) :: drawing   !! drawing with all parts
    character(len=:), allocatable :: png        !! bytes of the file
    integer, allocatable :: canvas(:, :)
    integer :: i, j, k

    allocate (canvas(dots * drawing%width, dots * drawing%height), source=colour_paper)
    do k = 1, size(drawing%images)
      associate (image => drawing%images(k))
        do j = 0, dots * image%height - 1
          do i = 0, dots * image%width - 1
            call put_dot(dots * image%left + i, dots * image%top + j, &
                         image%colour(1 + i * size(image%colour, 1) / (dots * image%width), &
                                      1 + j * size(image%colour, 2) / (dots * image%height)))
          end do
        end do
      end associate
    end do
    do k = 1, size(drawing%lines)
      associate (from => dots * drawing%lines(k)%from, to => dots * drawing%lines(k)%to)
        do j = min(from(2), to(2)), max(from(2), to(2)) + 1
          do i = min(from(1), to(1)), max(from(1), to(1)) + 1
            call put_dot(i, j, colour_ink)
          end do
        end do
      end associate
    end do
    do k = 1, size(drawing%texts)
      call put_text(drawing%texts(k))
    end do
    png = png_bytes(canvas, colour_palette())

  contains

    subroutine put_dot(across, down, colour)
      integer, intent(in) :: across, down, colour

      if (across >= 0 .and. down >= 0 .and. across < size(canvas, 1) .and. &
          down < size(canvas, 2)) canvas(across + 1, down + 1) = colour
    end subroutine put_dot

    subroutine put_text(text)
      type(drawn_text), intent(in) :: text
      integer :: column, letter, left, row, x, y

      left = dots * text%at(1)
      associate (length => dots * ((glyph_width + 1) * len_trim(text%text) - 1))
        if (text%anchor == at_middle) left = left - length / 2
        if (text%anchor == at_end) left = left - length
      end associate
      do letter = 1, len_trim(text%text)
        do column = 1, glyph_width
          do row = 1, glyph_height
            if (.not. has_dot(text%text(letter:letter), column, row)) cycle
            x = left + dots * ((glyph_width + 1) * (letter - 1) + column - 1)
            y = dots * (text%at(2) - glyph_height + row - 1)
            ! These reach below the line.
            if (scan(text%text(letter:letter), 'gjpqy') > 0) y = y + 2 * dots
            do j = y, y + dots - 1
              do i = x, x + dots - 1 + merge(1, 0, text%is_bold)
                call put_dot(i, j, colour_ink)
              end do
            end do
          end do
        end do
      end do
    end subroutine put_text

  end function png_of

  ! Whether a letter has a dot at a place; letters outside of ASCII are question marks.
  pure logical function has_dot(letter, column, row)
    character(len=1), intent(in) :: letter
    integer, intent(in) :: column, row
    integer :: at, bits, number

    number = iachar(letter)
    if (number < 32 .or. number > 126) number = iachar('?')
    at = 2 * (glyph_width * (number - 32) + column) - 1
    bits = 16 * hexadecimal_digit(glyphs(at:at)) + hexadecimal_digit(glyphs(at + 1:at + 1))
    has_dot = btest(bits, row - 1)
  end function has_dot

  pure integer function hexadecimal_digit(letter)
    character(len=1), intent(in) :: letter

    hexadecimal_digit = index('0123456789ABCDEF', letter) - 1
  end function hexadecimal_digit

  ! Red, green and blue of all places of the palette.
  pure function colour_palette() result(colours)
    integer :: colours(3, 0:last_colour)
    real(real64) :: at
    integer :: i, k

    colours(:, colour_paper) = 255
    colours(:, colour_ink) = 0
    colours(:, colour_blank) = 255
    colours(:, colour_missing) = 160
    do i = first_colour, last_colour
      at = real((i - first_colour) * (size(viridis, 2) - 1), real64) / (last_colour - first_colour)
      k = min(int(at), size(viridis, 2) - 2)
      colours(:, i) = nint(viridis(:, k + 1) + (at - k) * (viridis(:, k + 2) - viridis(:, k + 1)))
    end do
  end function colour_palette

end module asperity_plan_drawing
