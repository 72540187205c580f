!> Bytes of a file, block by block, so that a large file needs no more memory than a block.
!>
!> Every input can be read a second time. A pipe or a device, which gives its bytes once, is
!> therefore read to its end when it is opened, and may have 100000000 bytes.
module asperity_byte_reader
  use, intrinsic :: iso_c_binding, only: c_int, c_long, c_null_char, c_size_t
  use asperity_kinds, only: int32, int64, real32, real64
  use asperity_problems, only: decimal_text, not_enough_memory
  use asperity_system_calls, only: posix_close, posix_lseek, posix_open, posix_read, &
                                   system_error, system_reason
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: byte_reader, whole_bits, bytes_of
  public :: finite, not_a_number, above_all

  integer, parameter :: finite = 0                      !! a number
  integer, parameter :: not_a_number = 1                !! NaN of IEEE 754
  integer, parameter :: above_all = 2, below_all = 3    !! infinite, above and below

  integer(c_int), parameter :: read_only = 0_c_int, from_start = 0_c_int, from_end = 2_c_int
  integer, parameter :: block_size = 65536
  ! Largest number of bytes of a pipe or device, which may never end, and of a file read as a whole.
  integer, parameter :: longest_pipe = 100000000, longest_file = 1000000000
  integer, parameter :: interrupted = 4  ! EINTR: a signal arrived before the first byte

  !> A file that is being read. Its next bytes are `block(at:used)`.
  type :: byte_reader
    character(len=:), allocatable :: block     !! bytes of a block; all bytes of a pipe
    integer :: at = 1                          !! index of the next byte of the block
    integer :: used = 0                        !! number of bytes in the block
    integer(int64) :: before = 0_int64         !! number of bytes before the block
    integer(int64) :: length = -1_int64        !! number of bytes of the file; -1 for a pipe
    character(len=:), allocatable :: failure   !! reason, when it cannot be read
    integer(c_int), private :: descriptor = -1_c_int
  contains
    procedure :: open => open_file      !! opens a file at its first byte
    procedure :: more => read_block     !! reads the next block
    procedure :: take => take_bytes     !! takes the next bytes
    procedure :: take_line              !! takes the next line
    procedure :: take_whole             !! takes all bytes
    procedure :: take_numbers           !! takes the next numbers in binary form
    procedure :: count_bytes            !! number of bytes of the file
    procedure :: rewind => rewind_file  !! returns to the first byte
    procedure :: close => close_file    !! closes the file
  end type byte_reader

contains

  !> Opens a file; `failure` is allocated when that is not possible.
  subroutine open_file(self, path)
    class(byte_reader), intent(out) :: self  !! reader at the first byte
    character(len=*), intent(in) :: path     !! path of the file; `-` is standard input
    character(len=:), allocatable :: name
    integer(c_long) :: known, place
    integer :: status

    allocate (character(len=block_size) :: self%block, stat=status)
    if (status /= 0) then
      self%failure = 'cannot be opened: ' // not_enough_memory
      return
    end if
    name = path
    if (path == '-') name = '/dev/stdin'
    self%descriptor = posix_open(name // c_null_char, read_only)
    if (self%descriptor < 0) then
      self%failure = 'cannot be opened: ' // system_reason()
      return
    end if
    known = posix_lseek(self%descriptor, 0_c_long, from_end)
    place = posix_lseek(self%descriptor, 0_c_long, from_start)
    if (known > 0_c_long .and. place == 0_c_long) self%length = int(known, int64)
    if (self%length >= 0_int64) return
    do
      call self%more()
      if (self%at > self%used .or. allocated(self%failure)) exit
    end do
    self%at = 1
    call self%close()
  end subroutine open_file

  !> Reads the next block; at the end of the file `at > used`.
  subroutine read_block(self)
    class(byte_reader), intent(inout) :: self  !! reader whose block is used up
    character(len=:), allocatable :: larger
    integer(c_size_t) :: got
    integer :: kept, status

    kept = 0
    if (self%length < 0_int64) kept = self%used
    if (allocated(self%failure) .or. self%descriptor < 0_c_int) return
    if (kept > longest_pipe) then
      self%failure = 'cannot be read: more than ' // decimal_text(longest_pipe) // ' bytes'
      return
    end if
    if (kept + block_size > len(self%block)) then
      allocate (character(len=2 * kept + block_size) :: larger, stat=status)
      if (status /= 0) self%failure = 'cannot be read: ' // not_enough_memory
      if (status /= 0) return
      larger(:kept) = self%block(:kept)
      call move_alloc(larger, self%block)
    end if
    do
      got = posix_read(self%descriptor, self%block(kept + 1:), int(block_size, c_size_t))
      if (got >= 0_c_size_t .or. system_error() /= interrupted) exit
    end do
    if (got < 0_c_size_t) self%failure = 'cannot be read: ' // system_reason()
    self%before = self%before + int(self%used - kept, int64)
    self%at = kept + 1
    self%used = kept + max(0, int(got))
    if (got == 0_c_size_t .and. self%before < self%length) &
      self%failure = 'cannot be read whole: it became shorter while it was read'
  end subroutine read_block

  !> Takes the next bytes; fewer at the end of the file.
  subroutine take_bytes(self, number, bytes)
    class(byte_reader), intent(inout) :: self           !! reader of the file
    integer, intent(in) :: number                       !! number of bytes to take
    character(len=:), allocatable, intent(out) :: bytes !! bytes, `number` at most
    integer :: got, piece, status

    allocate (character(len=number) :: bytes, stat=status)
    if (status /= 0) self%failure = 'cannot be read: ' // not_enough_memory
    if (status /= 0) return
    got = 0
    do while (got < number)
      if (self%at > self%used) call self%more()
      if (self%at > self%used) exit
      piece = min(number - got, self%used - self%at + 1)
      bytes(got + 1:got + piece) = self%block(self%at:self%at + piece - 1)
      got = got + piece
      self%at = self%at + piece
    end do
    if (got < number) bytes = bytes(:got)
  end subroutine take_bytes

  !> Takes the bytes up to the next line feed.
  subroutine take_line(self, line, found)
    class(byte_reader), intent(inout) :: self           !! reader of the file
    character(len=:), allocatable, intent(out) :: line  !! the bytes, without the line feed
    logical, intent(out) :: found                       !! false behind the last line feed
    type(text_buffer) :: text
    integer :: length

    found = .false.
    do
      if (self%at > self%used) call self%more()
      if (self%at > self%used .or. allocated(self%failure)) exit
      length = scan(self%block(self%at:self%used), new_line('a'))
      call text%append(self%block(self%at:self%at - 1 + merge(length - 1, &
                                                            self%used - self%at + 1, length > 0)))
      self%at = merge(self%at + length, self%used + 1, length > 0)
      found = length > 0
      if (found) exit
    end do
    line = text%text()
  end subroutine take_line

  !> Takes all bytes, from the first; `failure` is allocated when they cannot be read.
  subroutine take_whole(self, bytes)
    class(byte_reader), intent(inout) :: self           !! reader at the first byte
    character(len=:), allocatable, intent(out) :: bytes !! all bytes of the file

    if (self%length < 0_int64) then
      call self%take(self%used, bytes)
      return
    end if
    ! A folder may have any length and cannot be read: the failure of reading is reported first.
    if (self%at > self%used) call self%more()
    if (self%length > int(longest_file, int64) .and. .not. allocated(self%failure)) &
      self%failure = 'cannot be read: more than ' // decimal_text(longest_file) // ' bytes'
    if (allocated(self%failure)) return
    call self%take(int(self%length), bytes)
    if (allocated(self%failure)) return
    if (self%at > self%used) call self%more()
    if (self%at <= self%used) &
      self%failure = 'cannot be read whole: it became longer while it was read'
  end subroutine take_whole

  !> Takes the next numbers, in binary form, block by block; fewer at the end of the file.
  subroutine take_numbers(self, number_kind, wide, values, classes, got, big_endian)
    class(byte_reader), intent(inout) :: self    !! reader of the file
    character(len=1), intent(in) :: number_kind  !! `f` of IEEE 754, `i` with sign, `u` without
    integer, intent(in) :: wide                  !! bytes of a number: 1, 2, 4 or 8; of `f` 4 or 8
    real(real64), intent(out) :: values(:)       !! nearest doubles; 0 where not finite
    integer, intent(out) :: classes(:)           !! `finite` or another class of each
    integer, intent(out) :: got                  !! how many there were
    logical, intent(in), optional :: big_endian  !! highest byte first; absent: lowest first
    character(len=:), allocatable :: bytes
    integer :: i, wanted

    got = 0
    do while (got < size(values))
      wanted = min(block_size / wide, size(values) - got)
      call self%take(wide * wanted, bytes)
      do i = 1, len(bytes) / wide
        call decode_number(whole_bits(bytes(wide * (i - 1) + 1:wide * i), big_endian), &
                           number_kind, 8 * wide, values(got + i), classes(got + i))
      end do
      got = got + len(bytes) / wide
      if (len(bytes) < wide * wanted) return
    end do
  end subroutine take_numbers

  !> Number of bytes of the file.
  pure integer(int64) function count_bytes(self)
    class(byte_reader), intent(in) :: self  !! reader of the file

    count_bytes = self%length
    if (self%length < 0_int64) count_bytes = int(self%used, int64)
  end function count_bytes

  !> Returns to the first byte.
  subroutine rewind_file(self)
    class(byte_reader), intent(inout) :: self  !! reader of the file
    integer(c_long) :: place

    self%at = 1
    if (self%length < 0_int64) return
    place = posix_lseek(self%descriptor, 0_c_long, from_start)
    self%used = 0
    self%before = 0_int64
  end subroutine rewind_file

  !> Closes the file.
  subroutine close_file(self)
    class(byte_reader), intent(inout) :: self  !! reader of the file
    integer(c_int) :: status

    if (self%descriptor >= 0_c_int) status = posix_close(self%descriptor)
    self%descriptor = -1_c_int
  end subroutine close_file

  !> The whole number without sign in some bytes.
  pure integer(int64) function whole_bits(bytes, big_endian)
    character(len=*), intent(in) :: bytes          !! 1 to 8 bytes of the number
    logical, intent(in), optional :: big_endian    !! highest byte first; absent: lowest first
    integer :: i, place

    whole_bits = 0_int64
    do i = 1, len(bytes)
      place = len(bytes) + 1 - i
      if (present(big_endian)) place = merge(i, place, big_endian)
      whole_bits = ior(shiftl(whole_bits, 8), int(iachar(bytes(place:place)), int64))
    end do
  end function whole_bits

  !> The bytes of a whole number without sign.
  pure function bytes_of(bits, wide) result(bytes)
    integer(int64), intent(in) :: bits           !! number below 2**(8 wide)
    integer, intent(in) :: wide                  !! number of bytes, 1 to 8
    character(len=wide) :: bytes                 !! lowest first: `whole_bits` gives the number back
    integer :: i

    do i = 1, wide
      bytes(i:i) = char(int(ibits(bits, 8 * (i - 1), 8)))
    end do
  end function bytes_of

  ! Bits as a whole number with sign, in two's complement.
  pure integer(int64) function signed_bits(bits, wide)
    integer(int64), intent(in) :: bits  ! number without sign
    integer, intent(in) :: wide         ! number of its bits, up to 64

    signed_bits = bits
    if (wide < 64 .and. btest(bits, wide - 1)) signed_bits = bits - shiftl(1_int64, wide)
  end function signed_bits

  ! The number that bits stand for. No NaN is copied: a signalling one would trap.
  pure subroutine decode_number(bits, number_kind, wide, value, class_of)
    integer(int64), intent(in) :: bits
    character(len=1), intent(in) :: number_kind
    integer, intent(in) :: wide  ! number of bits
    real(real64), intent(out) :: value
    integer, intent(out) :: class_of
    integer(int64) :: exponent_bits
    integer :: fraction_bits

    class_of = finite
    if (number_kind == 'f') then
      fraction_bits = merge(23, 52, wide == 32)
      exponent_bits = shiftl(1_int64, wide - 1 - fraction_bits) - 1_int64
      value = 0.0_real64
      if (iand(shiftr(bits, fraction_bits), exponent_bits) == exponent_bits) then
        class_of = merge(below_all, above_all, btest(bits, wide - 1))
        if (iand(bits, shiftl(1_int64, fraction_bits) - 1_int64) /= 0_int64) class_of = not_a_number
      else if (wide == 32) then
        value = real(transfer(int(signed_bits(bits, 32), int32), 1.0_real32), real64)
      else
        value = transfer(bits, value)
      end if
    else if (number_kind == 'i') then
      value = real(signed_bits(bits, wide), real64)
    else if (bits >= 0_int64) then
      value = real(bits, real64)
    else
      ! 2**63 or more: half the number; its last bit, kept, rounds as the number does.
      value = 2.0_real64 * real(ior(shiftr(bits, 1), iand(bits, 1_int64)), real64)
    end if
  end subroutine decode_number

end module asperity_byte_reader
