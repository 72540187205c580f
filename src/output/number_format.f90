!> Numbers, counts, shares and lists of positions in words.
module asperity_number_format
  use asperity_kinds, only: not_computed, real64
  use asperity_problems, only: decimal_text, real_text
  implicit none
  private

  public :: count_text, percent_text, positions_listed, number_text

  ! A longer list is in the CSV file.
  integer, parameter :: most_characters = 400

  ! Significant digits of a number in tables and sentences.
  integer, parameter :: usual_digits = 6
  character(len=*), parameter :: usual_format = &
    '(es32.' // achar(iachar('0') + usual_digits - 1) // 'e3)'

contains

  !> `1 position`, `2 positions`.
  pure function count_text(number, noun) result(text)
    integer, intent(in) :: number          !! how many there are
    character(len=*), intent(in) :: noun   !! of one of them
    character(len=:), allocatable :: text  !! number and noun

    text = decimal_text(number) // ' ' // noun
    if (number /= 1) text = text // 's'
  end function count_text

  !> `18, 56-58`; a long list ends with `...`.
  pure function positions_listed(chosen) result(text)
    logical, intent(in) :: chosen(:)         !! of every position
    character(len=:), allocatable :: text    !! which they are
    integer :: first, last

    text = ''
    last = 0
    do
      first = last + findloc(chosen(last + 1:), .true., 1)
      if (first == last) return
      last = first - 2 + findloc([chosen(first:), .false.], .false., 1)
      if (text /= '') text = text // ', '
      if (len(text) > most_characters) then
        text = text // '...'
        return
      end if
      text = text // decimal_text(first)
      if (last == first + 1) text = text // ', ' // decimal_text(last)
      if (last > first + 1) text = text // '-' // decimal_text(last)
    end do
  end function positions_listed

  !> A share as a percentage with three digits.
  pure function percent_text(share) result(text)
    real(real64), intent(in) :: share      !! 1: all of it
    character(len=:), allocatable :: text  !! with its sign
    integer :: decimals

    if (abs(share) >= 1.0e4_real64) then
      text = real_text(share, 'es12.1e3') // ' times'
    else if (abs(share) >= 0.0001_real64) then
      decimals = 3 - count(abs(share) >= [0.01_real64, 0.1_real64])
      text = real_text(100.0_real64 * share, 'f12.' // decimal_text(decimals)) // ' %'
    else
      text = '0 %'
      if (abs(share) > 0.0_real64) text = real_text(100.0_real64 * share, 'es12.1e3') // ' %'
    end if
  end function percent_text

  !> A number for reading: so many significant digits at most, no zeros behind the last. A number
  !> that was not computed is blank.
  pure function number_text(value, most_digits) result(text)
    real(real64), intent(in) :: value       !! a finite number, or `not_computed`
    integer, intent(in), optional :: most_digits  !! from 1 to 15; absent: 6
    character(len=:), allocatable :: text   !! text without blanks
    character(len=32) :: cell, format
    integer :: number_of_digits, last, power

    text = ''
    if (.not. value > not_computed) return
    number_of_digits = usual_digits
    if (present(most_digits)) number_of_digits = most_digits
    format = usual_format
    if (present(most_digits)) write (format, '("(es32.", i0, "e3)")') number_of_digits - 1
    write (cell, format) value
    ! After rounding. Digits are decoded here: `read` takes as long as `write`.
    power = sum((iachar([cell(30:30), cell(31:31), cell(32:32)]) - iachar('0')) * [100, 10, 1])
    if (cell(29:29) == '-') power = -power
    if (power >= number_of_digits .and. power < 6) then
      write (cell, '(f32.0)') value
      cell = adjustl(cell)
      text = cell(:index(cell, '.') - 1)
      return
    end if
    ! The digits without point and last zeros, from that of the highest power.
    cell = adjustl(cell)
    last = index(cell, 'E') - 1
    if (number_of_digits > 1) last = verify(cell(:last), '0', back=.true.)
    text = cell(scan(cell, '0123456789'):last)
    if (len(text) > 1) text = text(:1) // text(3:)
    if (power >= max(number_of_digits, 6) .or. power < -4) then
      if (len(text) > 1) text = text(:1) // '.' // text(2:)
      text = text // 'e' // decimal_text(power)
    else if (power < 0) then
      text = '0.' // repeat('0', -power - 1) // text
    else
      text = text // repeat('0', max(0, power + 1 - len(text)))
      if (len(text) > power + 1) text = text(:power + 1) // '.' // text(power + 2:)
    end if
    if (cell(1:1) == '-' .and. text /= '0') text = '-' // text
  end function number_text

end module asperity_number_format
