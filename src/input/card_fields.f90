!> Fields of a punched card, read by the rules of FORTRAN IV.
!>
!> Blanks after the first digit are zeros. A field without a decimal point has an implied one.
!> An exponent may follow, with `E`, `D` or its sign alone.
module asperity_card_fields
  use asperity_decimal, only: decimal_value
  use asperity_kinds, only: int64
  implicit none
  private

  public :: read_f_field, read_i_field

  integer, parameter :: most_digits = 18, largest_exponent = 9999
  character(len=*), parameter :: digit_characters = '0123456789'

contains

  !> Reads a field under `Fw.d`.
  pure subroutine read_f_field(field, implied_decimals, value, bad_at)
    character(len=*), intent(in) :: field        !! the w columns
    integer, intent(in) :: implied_decimals      !! d: digits behind the implied point
    type(decimal_value), intent(out) :: value    !! the number, exactly
    integer, intent(out) :: bad_at               !! 0, or the first column that is wrong
    integer :: i, digit, exponent, exponent_sign, behind_point, significant
    logical :: negative, after_point, started, digit_seen, in_exponent, exponent_digit

    value = decimal_value()
    bad_at = 0
    negative = .false.
    after_point = .false.
    started = .false.
    digit_seen = .false.
    in_exponent = .false.
    exponent_digit = .false.
    exponent = 0
    exponent_sign = 1
    behind_point = 0
    significant = 0
    do i = 1, len(field)
      digit = digit_of(field(i:i))
      if (field(i:i) == ' ') then
        if (.not. started) cycle
        ! A blank between the exponent's letter and its digits stands for nothing.
        if (in_exponent .and. .not. exponent_digit) cycle
        digit = 0
      end if
      if (digit >= 0) then
        started = .true.
        digit_seen = .true.
        if (in_exponent) then
          exponent = min(10 * exponent + digit, largest_exponent)
          exponent_digit = .true.
        else if (significant >= most_digits) then
          bad_at = i
          return
        else
          value%digits = 10_int64 * value%digits + int(digit, int64)
          if (value%digits > 0_int64) significant = significant + 1
          if (after_point) behind_point = behind_point + 1
        end if
      else
        select case (field(i:i))
        case ('.')
          if (after_point .or. in_exponent) bad_at = i
          after_point = .true.
          started = .true.
        case ('+', '-')
          if (.not. started) then
            negative = field(i:i) == '-'
            started = .true.
          else if (exponent_digit .or. .not. digit_seen .or. sign_before(field, i)) then
            bad_at = i
          else
            in_exponent = .true.
            exponent_sign = merge(-1, 1, field(i:i) == '-')
          end if
        case ('E', 'D', 'e', 'd')
          if (in_exponent .or. .not. digit_seen) bad_at = i
          in_exponent = .true.
        case default
          bad_at = i
        end select
        if (bad_at > 0) return
      end if
    end do
    if (in_exponent .and. .not. exponent_digit) bad_at = len(field)
    if (lone_sign_or_point(field)) bad_at = verify(field, ' ')
    if (negative) value%digits = -value%digits
    if (.not. after_point) behind_point = implied_decimals
    value%exponent = exponent_sign * exponent - behind_point
  end subroutine read_f_field

  !> Reads a field under `Iw`; the largest accepted magnitude is that of the default integer.
  pure subroutine read_i_field(field, value, bad_at)
    character(len=*), intent(in) :: field  !! the w columns
    integer, intent(out) :: value          !! the number
    integer, intent(out) :: bad_at         !! 0, or the first column that is wrong
    type(decimal_value) :: number
    integer :: first

    value = 0
    first = verify(field, ' ')
    if (first == 0) then
      bad_at = 0
      return
    end if
    bad_at = first
    if (scan(field(first:first), '+-' // digit_characters) == 0) return
    bad_at = verify(field(first + 1:), ' ' // digit_characters)
    if (bad_at > 0) then
      bad_at = bad_at + first
      return
    end if
    call read_f_field(field, 0, number, bad_at)
    if (abs(number%digits) > int(huge(value), int64)) bad_at = first
    if (bad_at == 0) value = int(number%digits)
  end subroutine read_i_field

  !> The digit's value, or -1.
  elemental integer function digit_of(letter)
    character(len=1), intent(in) :: letter

    digit_of = index(digit_characters, letter) - 1
  end function digit_of

  !> Whether the last character that is not blank before column `i` is a sign.
  pure logical function sign_before(field, i)
    character(len=*), intent(in) :: field
    integer, intent(in) :: i
    integer :: last

    last = len_trim(field(:i - 1))
    sign_before = .false.
    if (last > 0) sign_before = scan(field(last:last), '+-') > 0
  end function sign_before

  !> Whether the field has a sign or a point but no digit.
  pure logical function lone_sign_or_point(field)
    character(len=*), intent(in) :: field

    lone_sign_or_point = scan(field, digit_characters) == 0 .and. verify(field, ' ') > 0
  end function lone_sign_or_point

end module asperity_card_fields
