!> Text as numbers: what travels between images, and into kept records, is numbers alone.
module asperity_letters
  use asperity_kinds, only: int64, real64
  implicit none
  private

  public :: message_numbers, message_to_numbers, numbers_for, numbers_to_message
  public :: text_in, text_to_numbers

  ! Bytes in a double: 48 bits are exact.
  integer, parameter :: bytes_each = 6
  integer(int64), parameter :: base = 256_int64

  ! Bytes of a message that travel; the rest of a longer one is cut.
  integer, parameter :: longest_message = 510

  !> So many numbers a message takes.
  integer, parameter :: message_numbers = 1 + longest_message / bytes_each

contains

  !> How many numbers a text takes.
  pure integer function numbers_for(length)
    integer, intent(in) :: length  !! bytes of the text

    numbers_for = (length + bytes_each - 1) / bytes_each
  end function numbers_for

  !> Six bytes a number. Behind the text there are blanks.
  pure subroutine text_to_numbers(text, numbers)
    character(len=*), intent(in) :: text      !! any bytes
    real(real64), intent(out) :: numbers(:)   !! at least `numbers_for(len(text))`
    integer(int64) :: packed
    integer :: i, k

    do i = 1, size(numbers)
      packed = 0_int64
      do k = bytes_each * (i - 1) + 1, bytes_each * i
        if (k <= len(text)) then
          packed = base * packed + int(iachar(text(k:k)), int64)
        else
          packed = base * packed + int(iachar(' '), int64)
        end if
      end do
      numbers(i) = real(packed, real64)
    end do
  end subroutine text_to_numbers

  !> The text in such numbers, with the blanks behind it.
  pure function text_in(numbers) result(text)
    real(real64), intent(in) :: numbers(:)                !! from text_to_numbers
    character(len=bytes_each * size(numbers)) :: text
    integer(int64) :: packed
    integer :: i, k

    do i = 1, size(numbers)
      packed = int(numbers(i), int64)
      do k = bytes_each * i, bytes_each * (i - 1) + 1, -1
        text(k:k) = achar(int(modulo(packed, base)))
        packed = packed / base
      end do
    end do
  end function text_in

  !> A message that may be there; without one the numbers are 0.
  pure subroutine message_to_numbers(message, numbers)
    character(len=:), allocatable, intent(in) :: message       !! not allocated: none
    real(real64), intent(out) :: numbers(message_numbers)
    integer :: length

    numbers = 0.0_real64
    if (.not. allocated(message)) return
    length = min(len(message), longest_message)
    numbers(1) = real(max(1, length), real64)
    call text_to_numbers(message(:length), numbers(2:))
  end subroutine message_to_numbers

  !> The message in such numbers; one that is known stays when they hold none.
  pure subroutine numbers_to_message(numbers, message)
    real(real64), intent(in) :: numbers(message_numbers)           !! from message_to_numbers
    character(len=:), allocatable, intent(inout) :: message  !! not allocated: none
    character(len=longest_message) :: text

    if (nint(numbers(1)) == 0) return
    text = text_in(numbers(2:))
    message = text(:nint(numbers(1)))
  end subroutine numbers_to_message

end module asperity_letters
