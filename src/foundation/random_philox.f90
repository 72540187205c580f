!> Random words by counting: Philox4x32-10.
!>
!> J. K. Salmon, M. A. Moraes, R. O. Dror, D. E. Shaw, "Parallel random numbers: as easy as 1, 2,
!> 3", SC11 (2011), section 3.3. A block of four words is a function of a counter and a key: there
!> is no state, so any block can be had at any time, in any order, on any thread. Only whole
!> numbers are used, so the words are the same on every machine.
!>
!> Fortran has no unsigned integers: a word of 32 bits is an int64 from 0 to 2**32 - 1.
module asperity_random_philox
  use asperity_kinds, only: int64
  implicit none
  private

  public :: philox_block, scaled_words

  integer(int64), parameter :: low_16 = int(z'FFFF', int64)
  integer(int64), parameter :: low_31 = int(z'7FFFFFFF', int64)
  integer(int64), parameter :: low_32 = int(z'FFFFFFFF', int64)
  ! Multipliers of the rounds, and the increments of the key after each, from the paper.
  integer(int64), parameter :: multiplier_1 = int(z'D2511F53', int64)
  integer(int64), parameter :: multiplier_2 = int(z'CD9E8D57', int64)
  integer(int64), parameter :: weyl_1 = int(z'9E3779B9', int64)
  integer(int64), parameter :: weyl_2 = int(z'BB67AE85', int64)
  integer, parameter :: rounds = 10

contains

  !> The block of four random words of a counter and a key.
  pure function philox_block(counter, key) result(words)
    integer(int64), intent(in) :: counter(4)  !! words, each from 0 to 2**32 - 1
    integer(int64), intent(in) :: key(2)      !! words, each from 0 to 2**32 - 1
    integer(int64) :: words(4)                !! words, each from 0 to 2**32 - 1
    integer(int64) :: key_1, key_2, high_1, low_1, high_2, low_2
    integer :: i

    words = counter
    key_1 = key(1)
    key_2 = key(2)
    do i = 1, rounds
      call multiply_words(words(1), multiplier_1, high_1, low_1)
      call multiply_words(words(3), multiplier_2, high_2, low_2)
      words(1) = ieor(ieor(high_2, words(2)), key_1)
      words(2) = low_2
      words(3) = ieor(ieor(high_1, words(4)), key_2)
      words(4) = low_1
      key_1 = iand(key_1 + weyl_1, low_32)
      key_2 = iand(key_2 + weyl_2, low_32)
    end do
  end function philox_block

  !> A whole number from 0 to `number` - 1 from two random words: floor(u * number), where u is the
  !> fraction of 62 bits from the upper 31 bits of each word. No number is more probable than
  !> another by more than number/2**62, relatively.
  pure integer(int64) function scaled_words(words, number)
    integer(int64), intent(in) :: words(2)  !! words, each from 0 to 2**32 - 1
    integer(int64), intent(in) :: number    !! number of the values, 1 to 2**61
    integer(int64) :: upper, lower, above, below

    upper = shiftr(words(1), 1)
    lower = shiftr(words(2), 1)
    above = shiftr(number, 31)
    below = iand(number, low_31)
    ! A product of 62 x 62 bits overflows: by halves, and the lower bits never carry.
    scaled_words = upper * above + &
                   shiftr(upper * below + lower * above + shiftr(lower * below, 31), 31)
  end function scaled_words

  !> Computes the upper and lower word of the product of two words. The product would overflow an
  !> int64, so that one factor is divided into halves.
  elemental subroutine multiply_words(a, b, high, low)
    integer(int64), intent(in) :: a, b
    integer(int64), intent(out) :: high, low
    integer(int64) :: lower, upper

    lower = a * iand(b, low_16)
    upper = a * shiftr(b, 16) + shiftr(lower, 16)
    high = shiftr(upper, 16)
    low = ior(shiftl(iand(upper, low_16), 16), iand(lower, low_16))
  end subroutine multiply_words

end module asperity_random_philox
