!> What `asperity generate` shall make, as checked values.
!>
!> The first of two sides is the upper surface, the second the lower one.
module asperity_generation_values
  use asperity_decimal, only: decimal_value
  use asperity_kinds, only: int64, real128
  implicit none
  private

  public :: generation_spec, side_spec, gaussian_spec, deck_spec
  public :: most_asperities, exact_value, side_names

  !> Asperities of one surface: more would not fit into a file that the solver reads.
  integer, parameter :: most_asperities = 20000000

  !> The two sides, for messages.
  character(len=*), parameter :: side_names(2) = [character(len=5) :: 'upper', 'lower']

  !> A Gaussian between two cut-offs. Lengths.
  type :: gaussian_spec
    type(decimal_value) :: mean             !! mean before the cut
    type(decimal_value) :: deviation        !! standard deviation before the cut, 0 or more
    real(real128) :: lowest = 0.0_real128   !! nothing is below; the mean when all are equal
    real(real128) :: highest = 0.0_real128  !! nothing is above; the mean when all are equal
  end type gaussian_spec

  !> One surface.
  type :: side_spec
    integer :: number = 0                  !! asperities, 1 to `most_asperities`
    type(decimal_value) :: length          !! extent along x, more than 0
    type(decimal_value) :: width           !! extent along y, more than 0
    type(decimal_value) :: least_distance  !! between two summits in the plane, 0 or more
    type(gaussian_spec) :: height          !! heights of the summits
    type(gaussian_spec) :: radius          !! radii of the summits, all more than 0
  end type side_spec

  !> What the cards of a deck say beside the asperities: inches, psi, radians.
  type :: deck_spec
    type(decimal_value) :: elastic_modulus(2)  !! upper, lower
    type(decimal_value) :: poisson_ratio(2)    !! upper, lower
    type(decimal_value) :: allowed_stress(2)   !! upper, lower
    type(decimal_value) :: rotation(2)         !! upper, lower
    type(decimal_value) :: lower_width         !! the lower y is mirrored in half of it
    type(decimal_value) :: displacement(2)     !! along x and y
  end type deck_spec

  !> A whole specification.
  type :: generation_spec
    character(len=:), allocatable :: file      !! where it was read from
    type(side_spec) :: sides(2)                !! upper and lower surface
    integer :: seed = 1                        !! 0 or more
    integer :: ensemble = 1                    !! how many surfaces of each side there are
    integer :: tries = 10000                   !! places tried at most for one asperity
    logical :: is_deck = .false.               !! a card deck is wanted, not CSV
    type(deck_spec) :: deck                    !! only for a deck
  end type generation_spec

contains

  !> A decimal in 113 bits.
  elemental real(real128) function exact_value(value)
    type(decimal_value), intent(in) :: value  !! at most 18 digits
    integer :: power

    power = abs(value%exponent)
    if (value%exponent < 0) then
      exact_value = real(value%digits, real128) / 10.0_real128**power
    else
      exact_value = real(value%digits, real128) * 10.0_real128**power
    end if
    if (value%digits == 0_int64) exact_value = 0.0_real128
  end function exact_value

end module asperity_generation_values
