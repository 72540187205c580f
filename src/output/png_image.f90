!> Pixels of one palette as the address of an image inside a text: a PNG (W3C, Portable Network
!> Graphics, 2nd ed., 2003) without compression in base64 (RFC 4648).
module asperity_png_image
  use asperity_byte_reader, only: bytes_of
  use asperity_kinds, only: int64, real64
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: image_address
  public :: blank_colour, missing_colour, first_colour, last_colour

  !> Places in the palette: white, grey, and the colours of the lowest and of the highest value.
  integer, parameter :: blank_colour = 0, missing_colour = 1, first_colour = 2, last_colour = 255
  ! Viridis (S. van der Walt and N. Smith, 2015) at equal steps; straight lines between.
  integer, parameter :: viridis(3, 9) = reshape( &
    [68, 1, 84, 71, 44, 122, 59, 81, 139, 44, 113, 142, 33, 144, 141, 39, 173, 129, 92, 200, 99, &
     170, 220, 50, 253, 231, 37], [3, 9])

contains

  !> The address of an image, a place in the palette a pixel.
  pure function image_address(colour) result(address)
    integer, intent(in) :: colour(:, :)       !! from 0 to 255; by column and row, the top row first
    character(len=:), allocatable :: address  !! without line ends
    type(text_buffer) :: bytes, rows
    integer :: i, j

    do j = 1, size(colour, 2)
      call rows%append(achar(0))
      do i = 1, size(colour, 1)
        call rows%append(char(colour(i, j)))
      end do
    end do
    call bytes%append(char(137) // 'PNG' // achar(13) // achar(10) // achar(26) // achar(10))
    ! Eight bits a pixel of a palette (type 3), neither filtered nor interlaced.
    call add_chunk('IHDR', big_bytes(size(colour, 1, int64)) // &
                   big_bytes(size(colour, 2, int64)) // achar(8) // achar(3) // &
                   repeat(achar(0), 3), bytes)
    call add_chunk('PLTE', palette_bytes(), bytes)
    call add_chunk('IDAT', stored_stream(rows%text()), bytes)
    call add_chunk('IEND', '', bytes)
    address = 'data:image/png;base64,' // base64_text(bytes%text())
  end function image_address

  ! Red, green and blue of all places of the palette.
  pure function palette_bytes() result(bytes)
    character(len=3 * (last_colour + 1)) :: bytes
    real(real64) :: at
    integer :: colours(3, 0:last_colour), i, k

    colours(:, blank_colour) = 255
    colours(:, missing_colour) = 160
    do i = first_colour, last_colour
      at = real((i - first_colour) * (size(viridis, 2) - 1), real64) / (last_colour - first_colour)
      k = min(int(at), size(viridis, 2) - 2)
      colours(:, i) = nint(viridis(:, k + 1) + (at - k) * (viridis(:, k + 2) - viridis(:, k + 1)))
    end do
    do i = 0, last_colour
      bytes(3 * i + 1:3 * i + 3) = char(colours(1, i)) // char(colours(2, i)) // char(colours(3, i))
    end do
  end function palette_bytes

  ! A chunk with its length and its cyclic redundancy check.
  pure subroutine add_chunk(name, content, bytes)
    character(len=*), intent(in) :: name, content
    type(text_buffer), intent(inout) :: bytes
    integer(int64), parameter :: polynomial = int(z'EDB88320', int64), all_32 = 2_int64**32 - 1
    character(len=len(name) + len(content)) :: named
    integer(int64) :: check
    integer :: i, k

    named = name // content
    check = all_32
    do i = 1, len(named)
      check = ieor(check, int(iachar(named(i:i)), int64))
      do k = 1, 8
        check = ieor(shiftr(check, 1), merge(polynomial, 0_int64, btest(check, 0)))
      end do
    end do
    call bytes%append(big_bytes(len(content, int64)) // named // big_bytes(ieor(check, all_32)))
  end subroutine add_chunk

  ! A zlib stream (RFC 1950) of stored blocks, with its check sum.
  pure function stored_stream(bytes) result(stream)
    character(len=*), intent(in) :: bytes
    character(len=:), allocatable :: stream
    integer, parameter :: longest_block = 65535
    integer(int64) :: a, b
    integer :: first, i, length

    stream = char(120) // achar(1)
    do first = 1, len(bytes), longest_block
      length = min(longest_block, len(bytes) - first + 1)
      stream = stream // char(merge(1, 0, first + length > len(bytes))) // &
               char(mod(length, 256)) // char(length / 256) // char(255 - mod(length, 256)) // &
               char(255 - length / 256) // bytes(first:first + length - 1)
    end do
    a = 1_int64
    b = 0_int64
    do i = 1, len(bytes)
      a = mod(a + iachar(bytes(i:i)), 65521_int64)
      b = mod(b + a, 65521_int64)
    end do
    stream = stream // big_bytes(65536_int64 * b + a)
  end function stored_stream

  ! 32 bits, the highest byte first.
  pure character(len=4) function big_bytes(value)
    integer(int64), intent(in) :: value

    big_bytes = bytes_of(value, 4, big_endian=.true.)
  end function big_bytes

  pure function base64_text(bytes) result(text)
    character(len=*), intent(in) :: bytes
    character(len=:), allocatable :: text
    character(len=*), parameter :: letters = &
      'ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/'
    character(len=3) :: three
    integer :: digit, i, k

    allocate (character(len=4 * ((len(bytes) + 2) / 3)) :: text)
    do i = 0, len(text) / 4 - 1
      three = bytes(3 * i + 1:min(3 * i + 3, len(bytes)))
      three(min(3, len(bytes) - 3 * i) + 1:) = repeat(achar(0), 2)
      do k = 1, 4
        digit = 1 + ibits(65536 * iachar(three(1:1)) + 256 * iachar(three(2:2)) + &
                          iachar(three(3:3)), 24 - 6 * k, 6)
        text(4 * i + k:4 * i + k) = letters(digit:digit)
      end do
    end do
    text(len(text) - modulo(-len(bytes), 3) + 1:) = '=='
  end function base64_text

end module asperity_png_image
