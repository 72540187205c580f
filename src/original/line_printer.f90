!> The line printer of the original program: number fields, page control, letters of tables.
module asperity_line_printer
  use asperity_kinds, only: real64
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: fixed_field, table_letters, new_page, skip_lines, apply_carriage_control

contains

  !> A number under `Fw.d`: rounded to nearest, ties away from zero; an exact zero is `0.0` (`0.`
  !> when d is 0) with its point where the other numbers have theirs; asterisks when it is too long.
  pure function fixed_field(value, width, decimals) result(field)
    real(real64), intent(in) :: value      !! number to be printed
    integer, intent(in) :: width           !! width w, columns of the field
    integer, intent(in) :: decimals        !! digits d behind the point
    character(len=width) :: field          !! the w columns
    character(len=20) :: format

    if (abs(value) > 0.0_real64) then
      write (format, '("(rc, f", i0, ".", i0, ")")') width, decimals
      write (field, format) value
    else
      field = ''
      field(width - decimals - 1:min(width, width - decimals + 1)) = '0.0'
    end if
  end function fixed_field

  !> A form: carriage control `1`, then the slashes of a FORMAT that begins with `1H1`.
  subroutine new_page(lines, slashes)
    type(text_buffer), intent(inout) :: lines  !! lines of the report
    integer, intent(in) :: slashes             !! slashes of the FORMAT, 1 or more

    call lines%line('1')
    call skip_lines(lines, slashes - 1)
  end subroutine new_page

  !> Empty lines.
  subroutine skip_lines(lines, number)
    type(text_buffer), intent(inout) :: lines  !! lines of the report
    integer, intent(in) :: number              !! number of empty lines; none from 0 down
    integer :: i

    do i = 1, number
      call lines%line('')
    end do
  end subroutine skip_lines

  !> Turns column one into what it does on a page: a form feed, or an empty line before.
  subroutine apply_carriage_control(text, buffer)
    character(len=*), intent(in) :: text         !! lines with column one
    type(text_buffer), intent(inout) :: buffer   !! gets them without
    integer :: first, last

    first = 1
    do while (first <= len(text))
      last = first + index(text(first:), new_line('a')) - 2
      if (last >= first) then
        select case (text(first:first))
        case ('1')
          call buffer%append(achar(12))
        case ('0')
          call buffer%line('')
        case default
          continue
        end select
      end if
      call buffer%line(text(min(first + 1, last + 1):last))
      first = last + 2
    end do
  end subroutine apply_carriage_control

  !> A, B ... Z, AA, AB ...: the letter behind a table's number.
  pure function table_letters(number) result(name)
    integer, intent(in) :: number          !! number of the table, from 1
    character(len=:), allocatable :: name  !! its letters
    integer :: rest

    name = ''
    rest = number
    do while (rest > 0)
      name = achar(iachar('A') + modulo(rest - 1, 26)) // name
      rest = (rest - 1) / 26
    end do
  end function table_letters

end module asperity_line_printer
