!> Tests of the random words: the published vectors, and whole numbers made of them.
!>
!> Vectors: file `tests/kat_vectors` of Random123 1.14.0 (D. E. Shaw Research), lines
!> `philox4x32 10`: counter, key, expected words.
module asperity_philox_suite
  use asperity_kinds, only: int64
  use asperity_random_philox, only: philox_block, scaled_words
  use asperity_testing, only: check, error_type, new_unittest, unittest_type
  implicit none
  private

  public :: collect_philox

  integer(int64), parameter :: ones = int(z'FFFFFFFF', int64)

contains

  !> Lists the tests.
  subroutine collect_philox(suite)
    !> all tests
    type(unittest_type), allocatable, intent(out) :: suite(:)

    suite = [ &
      new_unittest('counter and key zero', zero_vector), &
      new_unittest('counter and key all ones', ones_vector), &
      new_unittest('counter and key from the digits of pi', pi_vector), &
      new_unittest('whole numbers from words: ends and thirds', whole_numbers)]
  end subroutine collect_philox

  subroutine zero_vector(error)
    type(error_type), allocatable, intent(out) :: error

    call compare(error, [0_int64, 0_int64, 0_int64, 0_int64], [0_int64, 0_int64], &
                 '6627E8D5 E169C58D BC57AC4C 9B00DBD8')
  end subroutine zero_vector

  subroutine ones_vector(error)
    type(error_type), allocatable, intent(out) :: error

    call compare(error, [ones, ones, ones, ones], [ones, ones], &
                 '408F276D 41C83B0E A20BC7C6 6D5451FD')
  end subroutine ones_vector

  subroutine pi_vector(error)
    type(error_type), allocatable, intent(out) :: error

    call compare(error, &
                 [int(z'243F6A88', int64), int(z'85A308D3', int64), int(z'13198A2E', int64), &
                  int(z'03707344', int64)], &
                 [int(z'A4093822', int64), int(z'299F31D0', int64)], &
                 'D16CFE09 94FDCCEB 5001E420 24126EA1')
  end subroutine pi_vector

  subroutine compare(error, counter, key, expected)
    type(error_type), allocatable, intent(out) :: error
    integer(int64), intent(in) :: counter(4), key(2)
    character(*), intent(in) :: expected
    character(35) :: found

    write (found, '(z8.8, 3(1x, z8.8))') philox_block(counter, key)
    call check(error, found, expected, 'words')
  end subroutine compare

  !> The least u of 62 bits with floor(3 u / 2**62) = 1 is (2**62 + 2) / 3 = 5555... in hexadecimal
  !> and one more.
  subroutine whole_numbers(error)
    type(error_type), allocatable, intent(out) :: error
    integer(int64), parameter :: third = (2_int64**62 + 2_int64) / 3_int64
    integer(int64), parameter :: many = 2_int64**61

    call check(error, scaled_words([0_int64, 0_int64], 10_int64), 0_int64, 'least of 10')
    call check(error, scaled_words([ones, ones], 10_int64), 9_int64, 'greatest of 10')
    call check(error, scaled_words([ones, ones], 1_int64), 0_int64, 'the only one')
    call check(error, scaled_words([ones, ones], many), many - 1_int64, 'greatest of 2**61')
    call check(error, scaled_words(halves(third), 3_int64), 1_int64, 'one third')
    call check(error, scaled_words(halves(third - 1_int64), 3_int64), 0_int64, 'below one third')
    call check(error, scaled_words(halves(third), many), third / 2_int64, 'half of a third')
  end subroutine whole_numbers

  !> The words whose upper 31 bits each are the halves of a number of 62 bits.
  pure function halves(number) result(words)
    integer(int64), intent(in) :: number
    integer(int64) :: words(2)

    words = 2_int64 * [shiftr(number, 31), iand(number, 2_int64**31 - 1_int64)]
  end function halves

end module asperity_philox_suite
