!> Specifications of `asperity generate` as checked values.
!>
!> The first of two sides is the upper surface, the second the lower one.
module asperity_generation_values
  use asperity_kinds, only: real128, real64
  use asperity_problems, only: problem_list
  implicit none
  private

  public :: generation_spec, gaussian_spec, map_spec
  public :: below_none, below_words, period_of
  public :: most_asperities, exact_value, side_names

  !> Asperities of one surface: more would not fit into a file that the solver reads.
  integer, parameter :: most_asperities = 20000000

  !> The two sides, for messages.
  character(len=*), parameter :: side_names(2) = [character(len=5) :: 'upper', 'lower']

  !> A Gaussian between two cut-offs. Lengths.
  type :: gaussian_spec
    real(real64) :: mean = 0.0_real64  !! mean before the cut
    real(real64) :: deviation = 0.0_real64  !! standard deviation before the cut, 0 or more
    real(real128) :: lowest = 0.0_real128   !! nothing is below; the mean when all are equal
    real(real128) :: highest = 0.0_real128  !! nothing is above; the mean when all are equal
  end type gaussian_spec

  !> One surface.
  type :: side_spec
    integer :: number = 0                  !! asperities, 1 to `most_asperities`
    real(real64) :: length = 0.0_real64  !! extent along x, more than 0
    real(real64) :: width = 0.0_real64  !! extent along y, more than 0
    real(real64) :: least_distance = 0.0_real64  !! between two summits in the plane, 0 or more
    type(gaussian_spec) :: height          !! heights of the summits
    type(gaussian_spec) :: radius          !! radii of the summits, all more than 0
  end type side_spec

  !> Values of the cards of a deck beside the asperities: inches, psi, radians.
  type :: deck_spec
    real(real64) :: elastic_modulus(2) = 0.0_real64  !! upper, lower
    real(real64) :: poisson_ratio(2) = 0.0_real64  !! upper, lower
    real(real64) :: allowed_stress(2) = 0.0_real64  !! upper, lower
    real(real64) :: rotation(2) = 0.0_real64  !! upper, lower
    real(real64) :: lower_width = 0.0_real64  !! the lower y is mirrored in half of it
    real(real64) :: displacement(2) = 0.0_real64  !! along x and y
  end type deck_spec

  integer, parameter :: below_flat = 1  !! the spectrum of a map is constant below the roll-off
  integer, parameter :: below_none = 2  !! it is 0 there
  !> Their words.
  character(len=*), parameter :: below_words(2) = [character(len=4) :: 'flat', 'none']

  !> A self-affine random height map. Lengths are in one unit.
  type :: map_spec
    integer :: pixels(2) = 0                !! columns and rows
    real(real64) :: pixel_spacing(2) = 0.0_real64  !! of pixels along x and y, more than 0
    real(real128) :: hurst = 1.0_real128    !! Hurst exponent, more than 0, at most 1
    real(real128) :: roll_off = 0.0_real128 !! wavelength beyond which `below` holds
    real(real128) :: cut_off = 0.0_real128  !! shortest wavelength, at least 2 spacings
    integer :: below = below_flat           !! spectrum at wavelengths beyond the roll-off
    logical :: of_slope = .false.           !! the rms slope is given, not the rms height
    real(real128) :: rms = 0.0_real128      !! rms height, or rms slope, of the map; more than 0
    integer :: seed = 1                     !! 0 or more
    logical :: periodic = .true.            !! the map repeats itself along x and y
    integer :: unit = 0                     !! which of `length_units`; 0: none
  end type map_spec

  !> A whole specification: of a height map, or of two surfaces.
  type :: generation_spec
    character(len=:), allocatable :: file      !! where it was read from
    type(side_spec) :: sides(2)                !! upper and lower surface
    integer :: seed = 1                        !! 0 or more
    integer :: ensemble = 1                    !! how many surfaces of each side there are
    integer :: tries = 10000                   !! places tried at most for one asperity
    logical :: is_deck = .false.               !! a card deck is wanted, not CSV
    type(deck_spec) :: deck                    !! only for a deck
    logical :: is_map = .false.                !! a height map is wanted: only `map` is filled
    type(map_spec) :: map                      !! only for a height map
    type(problem_list) :: notes                !! what may be meant otherwise
  end type generation_spec

contains

  !> Pixels along a side of the periodic map, of which a free map is a part.
  elemental integer function period_of(pixels, periodic) result(period)
    integer, intent(in) :: pixels    !! of the map
    logical, intent(in) :: periodic  !! the map itself repeats

    period = pixels
    if (.not. periodic) period = smooth_length(2 * pixels)
  end function period_of

  ! Least length, n or more, without a prime factor above 5.
  pure integer function smooth_length(n) result(length)
    integer, intent(in) :: n
    integer, parameter :: primes(3) = [2, 3, 5]
    integer :: rest, i

    length = n
    do
      rest = length
      do i = 1, size(primes)
        do while (modulo(rest, primes(i)) == 0)
          rest = rest / primes(i)
        end do
      end do
      if (rest == 1) return
      length = length + 1
    end do
  end function smooth_length

  !> The decimal of at most 15 digits that a double was read from, in 113 bits.
  elemental real(real128) function exact_value(number)
    real(real64), intent(in) :: number  !! any finite number
    character(len=24) :: text

    write (text, '(es24.14e3)') number
    read (text, *) exact_value
  end function exact_value

end module asperity_generation_values
