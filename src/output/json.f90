!> Pieces of JSON (RFC 8259): texts, numbers, lists of them.
module asperity_json
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use asperity_kinds, only: int32, real64
  use asperity_printable, only: printable
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: json_text, put_reals, put_wholes, put_words

contains

  !> A text in quotes. Bytes that are no UTF-8 become question marks.
  pure function json_text(text) result(quoted)
    character(len=*), intent(in) :: text    !! any bytes
    character(len=:), allocatable :: quoted !! with its quotes
    type(text_buffer) :: buffer
    character(len=6) :: escape
    integer :: first, i

    call buffer%append('"')
    first = 1
    do i = 1, len(text)
      select case (iachar(text(i:i)))
      case (10)
        escape = '\n'
      case (0:9, 11:31)
        write (escape, '("\u", z4.4)') iachar(text(i:i))
      case (34, 92)
        escape = '\' // text(i:i)
      case default
        cycle
      end select
      call buffer%append(printable(text(first:i - 1)) // trim(escape))
      first = i + 1
    end do
    call buffer%append(printable(text(first:)) // '"')
    quoted = buffer%text()
  end function json_text

  !> A list of doubles with 17 digits; NaN is null.
  pure subroutine put_reals(values, buffer)
    real(real64), intent(in) :: values(:)       !! finite, or NaN
    type(text_buffer), intent(inout) :: buffer  !! the text
    character(len=25) :: cell
    integer :: i

    call buffer%append('[')
    do i = 1, size(values)
      cell = 'null'
      if (.not. ieee_is_nan(values(i))) write (cell, '(es25.16e3)') values(i)
      call put_item(i, cell, buffer)
    end do
    call buffer%append(']')
  end subroutine put_reals

  !> A list of whole numbers.
  pure subroutine put_wholes(values, buffer)
    integer(int32), intent(in) :: values(:)     !! any
    type(text_buffer), intent(inout) :: buffer  !! the text
    character(len=12) :: cell
    integer :: i

    call buffer%append('[')
    do i = 1, size(values)
      write (cell, '(i0)') values(i)
      call put_item(i, cell, buffer)
    end do
    call buffer%append(']')
  end subroutine put_wholes

  !> A list of words.
  pure subroutine put_words(letters, buffer)
    character(len=1), intent(in) :: letters(:, :)  !! (letter, word), blanks behind
    type(text_buffer), intent(inout) :: buffer     !! the text
    character(len=size(letters, 1)) :: word
    integer :: i, k

    call buffer%append('[')
    do i = 1, size(letters, 2)
      do k = 1, len(word)
        word(k:k) = letters(k, i)
      end do
      call put_item(i, json_text(trim(word)), buffer)
    end do
    call buffer%append(']')
  end subroutine put_words

  ! One item, with what stands between it and the one before.
  pure subroutine put_item(number, item, buffer)
    integer, intent(in) :: number
    character(len=*), intent(in) :: item
    type(text_buffer), intent(inout) :: buffer

    if (number > 1) call buffer%append(',')
    ! A line of bearable length, for editors.
    if (number > 1 .and. mod(number, 8) == 1) call buffer%append(new_line('a'))
    call buffer%append(trim(adjustl(item)))
  end subroutine put_item

end module asperity_json
