!> Tests of random surfaces: draws, positions, numbers as text, specifications.
module asperity_generation_suite
  use asperity_generation_spec, only: parse_generation_spec
  use asperity_generation_values, only: generation_spec
  use asperity_kinds, only: int64, real128, real64
  use asperity_problems, only: problem_list
  use asperity_random_philox, only: philox_block, scaled_words
  use asperity_random_positions, only: place_at_random
  use asperity_surface_text, only: field_length, write_decimal
  use asperity_testing, only: check, error_type, new_unittest, unittest_type
  use asperity_truncated_normal, only: draw_normal, prepare_normal, truncated_normal, whole_range
  implicit none
  private

  public :: collect_generation

  integer(int64), parameter :: ones = int(z'FFFFFFFF', int64), piece = 2_int64**31
  character(*), parameter :: nl = new_line('a')

contains

  !> Lists the tests.
  subroutine collect_generation(suite)
    !> all tests
    type(unittest_type), allocatable, intent(out) :: suite(:)

    suite = [ &
      new_unittest('draws from the whole Gaussian are its inverse', whole_gaussian), &
      new_unittest('draws between cut-offs are the inverse', cut_gaussian), &
      new_unittest('draws from far tails are the inverse', tails), &
      new_unittest('the ends of the range are met', range_ends), &
      new_unittest('positions are those of the definition, without cells', positions), &
      new_unittest('too many asperities are told', too_many), &
      new_unittest('numbers of units as text', numbers), &
      new_unittest('a specification is read', good_spec), &
      new_unittest('all problems of a specification are told', bad_spec)]
  end subroutine collect_generation

  subroutine whole_gaussian(error)
    type(error_type), allocatable, intent(out) :: error

    call compare_draws(error, -8.2_real128, 8.2_real128)
  end subroutine whole_gaussian

  subroutine cut_gaussian(error)
    type(error_type), allocatable, intent(out) :: error

    call compare_draws(error, -1.0_real128, 1.9_real128)
    if (.not. allocated(error)) call compare_draws(error, 0.1_real128, 0.1001_real128)
  end subroutine cut_gaussian

  subroutine tails(error)
    type(error_type), allocatable, intent(out) :: error

    call compare_draws(error, 25.0_real128, 26.6_real128)
    if (.not. allocated(error)) call compare_draws(error, -12.0_real128, -4.0_real128)
  end subroutine tails

  !> Compares draws with the definition. The piece must be the one whose probability holds the
  !> first 52 bits, and the place in it must split the probability of the piece at the other bits,
  !> to 1e-11 of the range.
  subroutine compare_draws(error, lowest, highest)
    type(error_type), allocatable, intent(out) :: error
    real(real128), intent(in) :: lowest, highest
    real(real128), parameter :: root_two_pi = sqrt(8 * atan(1.0_real128))
    type(truncated_normal) :: distribution
    integer(int64) :: words(4), place
    real(real128) :: step, left, z, wanted, share, total, off, worst
    integer :: i

    call prepare_normal(lowest, highest, distribution)
    step = (highest - lowest) / 1024
    total = mass(lowest, highest)
    worst = 0.0_real128
    do i = 1, 2000
      words = philox_block([int(i, int64), 0_int64, 0_int64, 0_int64], [7_int64, 0_int64])
      place = draw_normal(distribution, words(:3))
      left = lowest + step * real(place / piece, real128)
      z = lowest + (highest - lowest) * real(place, real128) / real(whole_range, real128)
      wanted = real(words(1) * 2_int64**20 + words(2) / 2_int64**12, real128) / 2.0_real128**52
      share = real(words(3) / 2_int64, real128) / 2.0_real128**31
      ! Half a unit of the table's rounding on either side.
      call check(error, mass(lowest, left) / total <= wanted + 2.0_real128**(-53) .and. &
                 mass(lowest, left + step) / total >= wanted - 2.0_real128**(-53), 'wrong piece')
      if (allocated(error)) return
      off = abs(mass(left, z) - share * mass(left, left + step)) * root_two_pi * exp(z * z / 2)
      worst = max(worst, off / (highest - lowest))
    end do
    call check(error, real(worst, real64), 0.0_real64, 1.0e-11_real64, 'error by the range')
  end subroutine compare_draws

  !> Probability of the Gaussian between two places, by the library.
  pure real(real128) function mass(from, to)
    real(real128), intent(in) :: from, to
    real(real128), parameter :: root = sqrt(2.0_real128)

    mass = (erfc(from / root) - erfc(to / root)) / 2
    if (from + to < 0.0_real128) mass = (erfc(-to / root) - erfc(-from / root)) / 2
  end function mass

  subroutine range_ends(error)
    type(error_type), allocatable, intent(out) :: error
    type(truncated_normal) :: distribution
    integer(int64) :: top

    call prepare_normal(-1.0_real128, 2.0_real128, distribution)
    call check(error, draw_normal(distribution, [0_int64, 0_int64, 0_int64]), 0_int64, 'lower end')
    top = draw_normal(distribution, [ones, ones, ones])
    call check(error, top > whole_range - 20_int64 .and. top <= whole_range, 'upper end')
  end subroutine range_ends

  !> Against the definition: all earlier asperities are asked, in numbers that cannot overflow.
  subroutine positions(error)
    type(error_type), allocatable, intent(out) :: error
    integer, parameter :: number = 300
    integer(int64), parameter :: key(2) = [11_int64, 0_int64], stream(2) = [4_int64, 1_int64]
    integer(int64), parameter :: extent(2) = [40000_int64, 9000_int64], least = 900_int64
    integer(int64) :: x(number), y(number), a(number), b(number), words(4)
    character(:), allocatable :: failure
    integer :: i, attempt, most

    call place_at_random(key, stream, extent, least, 10000, x, y, failure)
    call check(error, .not. allocated(failure), 'not packed')
    most = 0
    do i = 1, number
      do attempt = 1, 10000
        words = philox_block([int(i, int64), int(attempt, int64), stream], key)
        a(i) = scaled_words(words(1:2), extent(1) + 1_int64)
        b(i) = scaled_words(words(3:4), extent(2) + 1_int64)
        if (all((a(:i - 1) - a(i))**2 + (b(:i - 1) - b(i))**2 >= least**2)) exit
      end do
      most = max(most, attempt)
    end do
    call check(error, all(x == a) .and. all(y == b), 'other positions')
    call check(error, most > 5, 'too easy a case')
  end subroutine positions

  subroutine too_many(error)
    type(error_type), allocatable, intent(out) :: error
    integer(int64), parameter :: key(2) = 0_int64, extent(2) = 1000_int64
    integer(int64) :: x(100), y(100)
    character(:), allocatable :: failure

    ! 100 points on a square of 10 least distances: between random placing and the densest one.
    call place_at_random(key, key, extent, 100_int64, 50, x, y, failure)
    call check(error, allocated(failure), 'random placing packed too many')
    if (allocated(error)) return
    call check(error, index(failure, 'found room for ') > 0 .and. index(failure, ' 50 tries') > 0, &
               failure)
    ! 100 points 130 apart: 2/sqrt(3) 7.69**2 + 2 7.69 + 1 = 84.7.
    call place_at_random(key, key, extent, 130_int64, 50, x, y, failure)
    call check(error, allocated(failure), 'packed the impossible')
    if (allocated(error)) return
    call check(error, index(failure, 'at most 84,') > 0, failure)
  end subroutine too_many

  subroutine numbers(error)
    type(error_type), allocatable, intent(out) :: error

    call compare_number(0_int64, 0, '0')
    call compare_number(0_int64, 3, '0.000')
    call compare_number(-123_int64, 4, '-0.0123')
    call compare_number(123456_int64, 3, '123.456')
    call compare_number(100_int64, 2, '1.00')
    call compare_number(-7_int64, 0, '-7')
    call compare_number(5_int64, -3, '5E3')
    call compare_number(-12_int64, 20, '-12E-20')
    call compare_number(999999999999999999_int64, 17, '9.99999999999999999')

  contains

    subroutine compare_number(value, decimals, expected)
      integer(int64), intent(in) :: value
      integer, intent(in) :: decimals
      character(*), intent(in) :: expected
      character(field_length) :: field
      integer :: first

      field = ''
      call write_decimal(value, decimals, field, first)
      call check(error, field(first:), expected, 'number')
    end subroutine compare_number

  end subroutine numbers

  subroutine good_spec(error)
    type(error_type), allocatable, intent(out) :: error
    type(generation_spec) :: spec
    type(problem_list) :: problems

    call parse_generation_spec('s', '&surfaces density = 2., 3., length = 4, width = 3 /' // nl // &
         '&heights mean = 0.05, deviation = 0.01, lowest_deviation = -1.5, highest = 0.07 /' // &
         nl // '&radii mean = 0.5 /', spec, problems)
    call check(error, problems%text(), '', 'problems')
    call check(error, spec%sides(1)%number, 24, 'upper number')
    call check(error, spec%sides(2)%number, 36, 'lower number')
    call check(error, real(spec%sides(1)%height%lowest, real64), 0.035_real64, 1.0e-17_real64, &
               'lowest')
    call check(error, real(spec%sides(2)%height%highest, real64), 0.07_real64, 1.0e-17_real64, &
               'highest')
    call check(error, .not. spec%is_deck, 'a deck')
    call check(error, spec%tries, 10000, 'tries')
  end subroutine good_spec

  subroutine bad_spec(error)
    type(error_type), allocatable, intent(out) :: error
    type(generation_spec) :: spec
    type(problem_list) :: problems

    call parse_generation_spec('s', '&surfaces number = 2.5, length = -4., colour = 3 /' // nl // &
         '&heights mean = a, lowest = 1., lowest_deviation = -1. /' // nl // &
         '&random seed = -1 /' // nl // '&tilt /', spec, problems)
    call check(error, problems%text(), &
      's:4:1: unknown group: found ''&tilt'', expected &surfaces, &heights, ' // &
      '&radii, &random, &deck or &map' // nl // &
      's:1:39: unknown name in &surfaces: found ''colour'', expected number, density, ' // &
      'length, width or least_distance' // nl // &
      's:1:34: length: found ''-4.'', expected a number more than 0' // nl // &
      's:1:1: &surfaces needs width: found none, expected one' // nl // &
      's:1:11: number: no count of asperities given for the upper surface, expected a whole ' // &
      'number from 1 to 20000000' // nl // &
      's:2:1: &heights needs deviation: found none, expected one, or 0' // nl // &
      's:2:17: mean: found ''a'', expected a finite number within the range of a double' // &
      nl // &
      's:2:33: lowest_deviation: found beside lowest, expected one of them' // nl // &
      's:1:1: &radii needs mean: found none, expected one' // nl // &
      's:3:16: seed: found ''-1'', expected a whole number from 0 to 2147483647' // nl, 'problems')
  end subroutine bad_spec

end module asperity_generation_suite
