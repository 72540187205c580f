!> A small picture in shades of grey as the text that a page or a drawing holds.
!>
!> PNG (W3C, Portable Network Graphics, 2nd ed., 2003) without compression, in base64 (RFC 4648).
module asperity_png_image
  use asperity_kinds, only: int64
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: png_as_base64

  character(len=*), parameter :: signature = char(137) // 'PNG' // achar(13) // achar(10) // &
    achar(26) // achar(10)
  character(len=*), parameter :: letters = &
    'ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/'
  ! The polynomial of the check sum, its bits in reverse, and 32 bits set.
  integer(int64), parameter :: polynomial = int(z'EDB88320', int64)
  integer(int64), parameter :: all_32 = int(z'FFFFFFFF', int64)
  ! Bytes of a block that is stored as it is.
  integer, parameter :: longest_block = 65535

contains

  !> The picture as base64. Shade 0 is transparent.
  function png_as_base64(shade) result(text)
    integer, intent(in) :: shade(:, :)     !! from 0 to 255; by column and row, the top row first
    character(len=:), allocatable :: text  !! for a `data:image/png;base64,` address
    type(text_buffer) :: bytes
    character(len=:), allocatable :: rows
    integer :: i, j, at

    allocate (character(len=(size(shade, 1) + 1) * size(shade, 2)) :: rows)
    at = 0
    do j = 1, size(shade, 2)
      at = at + 1
      rows(at:at) = achar(0)
      do i = 1, size(shade, 1)
        at = at + 1
        rows(at:at) = char(shade(i, j))
      end do
    end do
    call bytes%append(signature)
    ! Eight bits of grey, neither filtered nor interlaced.
    call add_chunk('IHDR', number(size(shade, 1)) // number(size(shade, 2)) // achar(8) // &
                   repeat(achar(0), 4), bytes)
    call add_chunk('tRNS', repeat(achar(0), 2), bytes)
    call add_chunk('IDAT', stored(rows), bytes)
    call add_chunk('IEND', '', bytes)
    text = base64(bytes%text())
  end function png_as_base64

  ! A chunk with its length and check sum.
  pure subroutine add_chunk(name, content, bytes)
    character(len=*), intent(in) :: name, content
    type(text_buffer), intent(inout) :: bytes

    call bytes%append(number(len(content)) // name // content // &
                      number32(cyclic_sum(name // content)))
  end subroutine add_chunk

  ! A zlib stream (RFC 1950) of stored blocks.
  pure function stored(bytes) result(stream)
    character(len=*), intent(in) :: bytes
    character(len=:), allocatable :: stream
    type(text_buffer) :: buffer
    integer(int64) :: a, b
    integer :: first, length, i

    call buffer%append(char(120) // achar(1))
    do first = 1, len(bytes), longest_block
      length = min(longest_block, len(bytes) - first + 1)
      call buffer%append(char(merge(1, 0, first + length > len(bytes))) // &
                         little(length) // little(longest_block - length) // &
                         bytes(first:first + length - 1))
    end do
    a = 1_int64
    b = 0_int64
    do i = 1, len(bytes)
      a = mod(a + iachar(bytes(i:i)), 65521_int64)
      b = mod(b + a, 65521_int64)
    end do
    call buffer%append(number32(65536_int64 * b + a))
    stream = buffer%text()
  end function stored

  ! The cyclic redundancy check of the format.
  pure integer(int64) function cyclic_sum(bytes) result(total)
    character(len=*), intent(in) :: bytes
    integer(int64) :: table(0:255)
    integer :: i, k

    do i = 0, 255
      table(i) = int(i, int64)
      do k = 1, 8
        if (btest(table(i), 0)) then
          table(i) = ieor(polynomial, shiftr(table(i), 1))
        else
          table(i) = shiftr(table(i), 1)
        end if
      end do
    end do
    total = all_32
    do i = 1, len(bytes)
      total = ieor(table(iand(ieor(total, int(iachar(bytes(i:i)), int64)), 255_int64)), &
                   shiftr(total, 8))
    end do
    total = ieor(total, all_32)
  end function cyclic_sum

  pure function number(value) result(bytes)
    integer, intent(in) :: value
    character(len=4) :: bytes

    bytes = number32(int(value, int64))
  end function number

  ! 32 bits, the highest byte first.
  pure function number32(value) result(bytes)
    integer(int64), intent(in) :: value
    character(len=4) :: bytes
    integer :: i

    do i = 1, 4
      bytes(i:i) = char(int(ibits(value, 32 - 8 * i, 8)))
    end do
  end function number32

  ! 16 bits, the lowest byte first.
  pure function little(value) result(bytes)
    integer, intent(in) :: value
    character(len=2) :: bytes

    bytes = char(ibits(value, 0, 8)) // char(ibits(value, 8, 8))
  end function little

  pure function base64(bytes) result(text)
    character(len=*), intent(in) :: bytes
    character(len=4 * ((len(bytes) + 2) / 3)) :: text
    integer :: i, k, bits, digit, given

    do i = 0, len(text) / 4 - 1
      bits = 0
      given = min(3, len(bytes) - 3 * i)
      do k = 1, 3
        bits = 256 * bits
        if (k <= given) bits = bits + iachar(bytes(3 * i + k:3 * i + k))
      end do
      do k = 1, 4
        digit = ibits(bits, 24 - 6 * k, 6) + 1
        text(4 * i + k:4 * i + k) = letters(digit:digit)
        if (k > given + 1) text(4 * i + k:4 * i + k) = '='
      end do
    end do
  end function base64

end module asperity_png_image
