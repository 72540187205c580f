!> One operation of the short hexadecimal arithmetic on pairs of machine words.
!>
!>     hex32_words KIND INPUT OUTPUT
!>
!> INPUT: pairs of integers of 4 bytes, the operands' words. OUTPUT: for each pair the word of the
!> result and the condition code that the machine would set: 0 for zero or equal, 1 for below zero
!> or low, 2 for above zero or high. test/support/hex32_against_machine.py has the kinds; POWER is
!> x**1.5, DECIMAL the first word times 10 to the power of the second.
program hex32_words
  use, intrinsic :: iso_fortran_env, only: error_unit
  use asperity_hex32, only: hex32, hex32_from_integer, hex32_from_word, hex32_to_integer, &
                            hex32_word, operator(*), operator(+), operator(-), operator(/), &
                            operator(<), operator(>), cos, hex32_from_decimal, sin, sqrt, &
                            three_halves_power
  use asperity_kinds, only: int32, int64
  implicit none

  character(len=4096) :: kind, names(2)
  integer(int32) :: words(2), results(2)
  integer :: input, output, status

  call get_command_argument(1, kind)
  call get_command_argument(2, names(1))
  call get_command_argument(3, names(2))
  open (newunit=input, file=trim(names(1)), access='stream', form='unformatted', status='old', &
        action='read')
  open (newunit=output, file=trim(names(2)), access='stream', form='unformatted', &
        status='replace', action='write')
  do
    read (input, iostat=status) words
    if (status /= 0) exit
    results = operation(hex32_from_word(words(1)), hex32_from_word(words(2)), words)
    write (output) results
  end do
  close (input)
  close (output)

contains

  !> Word and condition code. `whole` are the operands where they are no short numbers.
  function operation(x, y, whole) result(answer)
    type(hex32), intent(in) :: x, y
    integer(int32), intent(in) :: whole(2)
    integer(int32) :: answer(2)
    type(hex32) :: z

    select case (kind)
    case ('AE')
      z = x + y
    case ('SE')
      z = x - y
    case ('ME')
      z = x * y
    case ('DE')
      z = x / y
    case ('CE')
      answer = [hex32_word(x), merge(1_int32, merge(2_int32, 0_int32, x > y), x < y)]
      return
    case ('LTER')
      z = x
    case ('LCER')
      z = -x
    case ('HER')
      z = hex32_from_word(1082130432_int32) * x
    case ('FLOAT')
      z = hex32_from_integer(int(whole(1)))
    case ('FIX')
      answer = [int(hex32_to_integer(x), int32), 0_int32]
      return
    case ('SQRT')
      z = sqrt(x)
    case ('POWER')
      z = three_halves_power(x)
    case ('SIN')
      z = sin(x)
    case ('COS')
      z = cos(x)
    case ('DECIMAL')
      z = hex32_from_decimal(int(whole(1), int64), int(whole(2)))
    case default
      write (error_unit, '(a)') 'unknown kind ' // trim(kind)
      error stop
    end select
    answer = [hex32_word(z), merge(1_int32, merge(2_int32, 0_int32, hex32_word(z) > 0_int32), &
                                   hex32_word(z) < 0_int32)]
  end function operation

end program hex32_words
