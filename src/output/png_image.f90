!> Images as PNG (W3C, Portable Network Graphics, 2nd ed., 2003) without compression, and base64
!> (RFC 4648) for images inside a text.
module asperity_png_image
  use asperity_kinds, only: int64
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: base64_text, png_bytes

  character(len=*), parameter :: signature = char(137) // 'PNG' // achar(13) // achar(10) // &
    achar(26) // achar(10)
  character(len=*), parameter :: letters = &
    'ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/'
  ! Bytes of a block that is stored as it is.
  integer, parameter :: longest_block = 65535

contains

  !> An image of one byte a pixel, a place in a palette.
  pure function png_bytes(shade, palette) result(png)
    integer, intent(in) :: shade(:, :)     !! from 0 to 255; by column and row, the top row first
    integer, intent(in) :: palette(:, :)   !! red, green and blue of each shade, from 0 to 255
    character(len=:), allocatable :: png   !! bytes of the file
    type(text_buffer) :: bytes, colours, rows
    integer :: i, j

    do j = 1, size(shade, 2)
      call rows%append(achar(0))
      do i = 1, size(shade, 1)
        call rows%append(char(shade(i, j)))
      end do
    end do
    call bytes%append(signature)
    ! Eight bits a pixel of a palette (type 3), neither filtered nor interlaced.
    call add_chunk('IHDR', word_bytes(int(size(shade, 1), int64)) // word_bytes(int(size(shade, &
                                                                                    2), int64)) // &
                   achar(8) // achar(3) // repeat(achar(0), 3), bytes)
    do i = 1, size(palette, 2)
      call colours%append(char(palette(1, i)) // char(palette(2, i)) // char(palette(3, i)))
    end do
    call add_chunk('PLTE', colours%text(), bytes)
    call add_chunk('IDAT', stored_stream(rows%text()), bytes)
    call add_chunk('IEND', '', bytes)
    png = bytes%text()
  end function png_bytes

  ! A chunk with its length and its cyclic redundancy check.
  pure subroutine add_chunk(name, content, bytes)
    character(len=*), intent(in) :: name, content
    type(text_buffer), intent(inout) :: bytes
    integer(int64), parameter :: polynomial = int(z'EDB88320', int64), all_32 = 2_int64**32 - 1
    integer(int64) :: check
    character(len=:), allocatable :: named
    integer :: i, k

    named = name // content
    check = all_32
    do i = 1, len(named)
      check = ieor(check, int(iachar(named(i:i)), int64))
      do k = 1, 8
        check = ieor(shiftr(check, 1), merge(polynomial, 0_int64, btest(check, 0)))
      end do
    end do
    call bytes%append(word_bytes(int(len(content), int64)) // named // word_bytes(ieor(check, &
                                                                                       all_32)))
  end subroutine add_chunk

  ! A zlib stream (RFC 1950) of stored blocks, with its check sum.
  pure function stored_stream(bytes) result(stream)
    character(len=*), intent(in) :: bytes
    character(len=:), allocatable :: stream
    type(text_buffer) :: buffer
    integer(int64) :: a, b
    integer :: first, length, i

    call buffer%append(char(120) // achar(1))
    do first = 1, len(bytes), longest_block
      length = min(longest_block, len(bytes) - first + 1)
      call buffer%append(char(merge(1, 0, first + length > len(bytes))) // little_bytes(length) // &
                         little_bytes(longest_block - length) // bytes(first:first + length - 1))
    end do
    a = 1_int64
    b = 0_int64
    do i = 1, len(bytes)
      a = mod(a + iachar(bytes(i:i)), 65521_int64)
      b = mod(b + a, 65521_int64)
    end do
    call buffer%append(word_bytes(65536_int64 * b + a))
    stream = buffer%text()
  end function stored_stream

  ! 32 bits, the highest byte first.
  pure function word_bytes(value) result(bytes)
    integer(int64), intent(in) :: value
    character(len=4) :: bytes
    integer :: i

    do i = 1, 4
      bytes(i:i) = char(int(ibits(value, 32 - 8 * i, 8)))
    end do
  end function word_bytes

  ! 16 bits, the lowest byte first.
  pure function little_bytes(value) result(bytes)
    integer, intent(in) :: value
    character(len=2) :: bytes

    bytes = char(ibits(value, 0, 8)) // char(ibits(value, 8, 8))
  end function little_bytes

  !> Bytes as letters.
  pure function base64_text(bytes) result(text)
    character(len=*), intent(in) :: bytes                    !! text of any bytes
    character(len=:), allocatable :: text                    !! without line ends
    character(len=3) :: three
    integer :: i, k, bits, digit

    allocate (character(len=4 * ((len(bytes) + 2) / 3)) :: text)
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
  end function base64_text

end module asperity_png_image
