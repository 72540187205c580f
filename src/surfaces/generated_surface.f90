!> Random surfaces from a specification.
!>
!> A number of a surface is a function of the seed, the surface's number in the ensemble, the side,
!> the asperity and, for a position, the try. So a surface needs no other one, and a height no
!> position. Counter of the generator: asperity, try (1 for heights and radii), surface, stream;
!> key: seed, 0. Streams 1, 2, 3 are positions, heights and radii of the upper surface, 4, 5, 6
!> those of the lower one.
!>
!> A coordinate is `value * 10**(-decimals)` with a whole number `value`, exactly. So a least
!> distance and cut-offs hold to the last digit written, and no rounding depends on a machine.
module asperity_generated_surface
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_generation_values, only: exact_value, gaussian_spec, generation_spec, side_names
  use asperity_kinds, only: int64, real128, real64
  use asperity_process, only: check_memory
  use asperity_random_philox, only: philox_block
  use asperity_random_positions, only: place_at_random, position_bytes
  use asperity_truncated_normal, only: draw_normal, prepare_normal, truncated_normal, whole_range
  implicit none
  private

  public :: generated_surface, surface_plan, plan_surface, generate_surface

  !> A surface in whole numbers of powers of ten: a coordinate is `x * 10**(-position_decimals)`.
  type :: generated_surface
    integer :: position_decimals = 0            !! for x and y
    integer :: height_decimals = 0              !! for heights
    integer :: radius_decimals = 0              !! for radii
    integer(int64), allocatable :: x(:)         !! from 0 to the length
    integer(int64), allocatable :: y(:)         !! from 0 to the width
    integer(int64), allocatable :: height(:)    !! between the cut-offs
    integer(int64), allocatable :: radius(:)    !! between the cut-offs; one number when all agree
  contains
    !> The numbers as a reader of the written surface gets them.
    procedure :: reals => convert_to_doubles
  end type generated_surface

  !> A Gaussian between cut-offs, in whole units.
  type :: lattice_gaussian
    integer :: decimals = 0                 !! a unit is 10**(-decimals)
    integer(int64) :: lowest = 0_int64      !! units
    integer(int64) :: highest = 0_int64     !! units; the same as `lowest` when all are equal
    type(truncated_normal) :: distribution  !! not used when all are equal
  end type lattice_gaussian

  !> Units and draws of one side, common to all members of an ensemble.
  type :: surface_plan
    private
    character(len=:), allocatable :: name
    integer :: number = 0, tries = 0, decimals = 0
    integer(int64) :: key(2) = 0_int64, stream = 0_int64
    integer(int64) :: extent(2) = 0_int64, least = 0_int64  ! units
    type(lattice_gaussian) :: height, radius
  end type surface_plan

  ! Digits of the longer side and of the least distance: the square of the latter is an int64.
  integer, parameter :: side_digits = 12, distance_digits = 9
  ! Digits behind the point on the cards of a deck: F6.3, F7.4, F5.3.
  integer, parameter :: card_decimals(3) = [3, 4, 3]
  ! Heights, radii and the text of an asperity take at most so much beside its position.
  integer(int64), parameter :: other_bytes = 96_int64

  ! Digits of a range, and of a number: a double holds 15.
  integer, parameter :: range_digits = 12, number_digits = 15
  integer(int64), parameter :: low_31 = int(z'7FFFFFFF', int64)
  integer(int64), parameter :: pieces = whole_range / (low_31 + 1_int64)
  ! Upper bound of the rounding of a number of units in real128 [units].
  real(real128), parameter :: slack = 1.0e-15_real128

contains

  !> Chooses the units of one side and prepares its draws.
  pure subroutine plan_surface(spec, side, plan)
    type(generation_spec), intent(in) :: spec   !! specification, checked for faults
    integer, intent(in) :: side                 !! 1 upper, 2 lower
    type(surface_plan), intent(out) :: plan     !! serves all members of the ensemble
    real(real128) :: extent(2), least

    plan%name = trim(side_names(side))
    plan%number = spec%sides(side)%number
    plan%tries = spec%tries
    plan%key = [int(spec%seed, int64), 0_int64]
    plan%stream = int(3 * side - 2, int64)
    extent = [exact_value(spec%sides(side)%length), exact_value(spec%sides(side)%width)]
    ! No two asperities are further apart than twice the sum of the sides.
    least = min(exact_value(spec%sides(side)%least_distance), 2 * sum(extent))
    plan%decimals = side_digits - order_of(maxval(extent))
    if (least > 0.0_real128) plan%decimals = min(plan%decimals, distance_digits - order_of(least))
    if (spec%is_deck) then
      plan%decimals = card_decimals(1)
      call set_gaussian(spec%sides(side)%height, plan%height, card_decimals(2))
      call set_gaussian(spec%sides(side)%radius, plan%radius, card_decimals(3))
    else
      call set_gaussian(spec%sides(side)%height, plan%height)
      call set_gaussian(spec%sides(side)%radius, plan%radius)
    end if
    plan%extent = [units_below(extent(1), plan%decimals), units_below(extent(2), plan%decimals)]
    plan%least = units_above(least, plan%decimals)
  end subroutine plan_surface

  !> Generates one surface. `failure` is allocated, with the reason, when that cannot be done.
  subroutine generate_surface(plan, member, surface, failure)
    type(surface_plan), intent(in) :: plan                 !! plan of the surface's side
    integer, intent(in) :: member                          !! number in the ensemble, from 1
    type(generated_surface), intent(out) :: surface        !! asperities in whole units
    character(len=:), allocatable, intent(out) :: failure  !! reason, when there is no surface
    integer :: i

    call check_memory('the ' // plan%name // ' surface', failure, &
                      bytes=(position_bytes + other_bytes) * int(plan%number, int64))
    if (allocated(failure)) return
    surface%position_decimals = plan%decimals
    surface%height_decimals = plan%height%decimals
    surface%radius_decimals = plan%radius%decimals
    allocate (surface%x(plan%number), surface%y(plan%number), surface%height(plan%number))
    allocate (surface%radius(merge(plan%number, 1, plan%radius%highest > plan%radius%lowest)))
    call place_at_random(plan%key, [int(member, int64), plan%stream], plan%extent, plan%least, &
                         plan%tries, surface%x, surface%y, failure)
    if (allocated(failure)) then
      failure = 'the ' // plan%name // ' surface ' // failure
      return
    end if
    do i = 1, plan%number
      surface%height(i) = drawn_value(plan%height, 1_int64)
    end do
    do i = 1, size(surface%radius)
      surface%radius(i) = drawn_value(plan%radius, 2_int64)
    end do

  contains

    !> Height or radius of asperity `i`, from a stream of the generator.
    pure integer(int64) function drawn_value(gaussian, which)
      type(lattice_gaussian), intent(in) :: gaussian
      integer(int64), intent(in) :: which
      integer(int64) :: words(4)

      words = philox_block([int(i, int64), 1_int64, int(member, int64), plan%stream + which], &
                           plan%key)
      drawn_value = draw_gaussian(gaussian, words(1:3))
    end function drawn_value

  end subroutine generate_surface

  !> The numbers of the asperities as the nearest doubles.
  pure subroutine convert_to_doubles(self, x, y, height, radius)
    class(generated_surface), intent(in) :: self          !! surface in whole units
    real(real64), allocatable, intent(out) :: x(:)        !! positions along the length, 0 or more
    real(real64), allocatable, intent(out) :: y(:)        !! positions along the width, 0 or more
    real(real64), allocatable, intent(out) :: height(:)   !! heights of the summits
    real(real64), allocatable, intent(out) :: radius(:)   !! radii of the summits, > 0
    integer :: number

    number = size(self%x)
    allocate (x(number), y(number), height(number), radius(number))
    call lattice_reals(self%x, self%position_decimals, x)
    call lattice_reals(self%y, self%position_decimals, y)
    call lattice_reals(self%height, self%height_decimals, height)
    call lattice_reals(self%radius, self%radius_decimals, radius(:size(self%radius)))
    if (size(self%radius) == 1) radius = radius(1)
  end subroutine convert_to_doubles

  !> Chooses the unit, unless it is given, and prepares the draws.
  pure subroutine set_gaussian(spec, gaussian, decimals)
    type(gaussian_spec), intent(in) :: spec          !! mean, deviation and cut-offs, checked
    type(lattice_gaussian), intent(out) :: gaussian  !! ready to draw from
    integer, intent(in), optional :: decimals        !! digits behind the point, when given
    real(real128) :: mean, deviation, unit

    mean = exact_value(spec%mean)
    deviation = exact_value(spec%deviation)
    if (present(decimals)) then
      gaussian%decimals = decimals
    else if (spec%highest > spec%lowest) then
      gaussian%decimals = min(range_digits - order_of(spec%highest - spec%lowest), &
           number_digits - order_of(max(abs(spec%lowest), abs(spec%highest))))
    else
      ! As many as the number has.
      if (abs(mean) > 0.0_real128) gaussian%decimals = max(0, number_digits - order_of(mean))
      do while (gaussian%decimals > 0 .and. &
                modulo(nearest_units(mean, gaussian%decimals), 10_int64) == 0_int64)
        gaussian%decimals = gaussian%decimals - 1
      end do
    end if
    if (.not. spec%highest > spec%lowest) then
      gaussian%lowest = nearest_units(mean, gaussian%decimals)
      gaussian%highest = gaussian%lowest
      return
    end if
    gaussian%lowest = units_above(spec%lowest, gaussian%decimals)
    gaussian%highest = units_below(spec%highest, gaussian%decimals)
    if (gaussian%highest <= gaussian%lowest) then
      ! Cut-offs between two neighbouring numbers of units: that next to the middle serves.
      gaussian%lowest = nearest_units((spec%lowest + spec%highest) / 2, gaussian%decimals)
      gaussian%highest = gaussian%lowest
      return
    end if
    unit = 10.0_real128**(-gaussian%decimals)
    call prepare_normal((real(gaussian%lowest, real128) * unit - mean) / deviation, &
                        (real(gaussian%highest, real128) * unit - mean) / deviation, &
                        gaussian%distribution)
  end subroutine set_gaussian

  !> A number of units from three random words, rounded to the nearest.
  pure integer(int64) function draw_gaussian(gaussian, words)
    type(lattice_gaussian), intent(in) :: gaussian  !! ready to draw from
    integer(int64), intent(in) :: words(3)          !! each from 0 to 2**32 - 1
    integer(int64) :: extent, place, whole, part, total

    draw_gaussian = gaussian%lowest
    extent = gaussian%highest - gaussian%lowest
    if (extent == 0_int64) return
    place = draw_normal(gaussian%distribution, words)
    ! extent * place / 2**41, rounded; the product itself has up to 91 bits.
    whole = shiftr(place, 31)
    part = iand(place, low_31)
    total = extent * whole + shiftr(extent, 31) * part + shiftr(iand(extent, low_31) * part, 31)
    draw_gaussian = gaussian%lowest + (total + pieces / 2_int64) / pieces
  end function draw_gaussian

  !> The largest number of units that is not above a value.
  pure integer(int64) function units_below(value, decimals)
    real(real128), intent(in) :: value  !! length in the unit of the specification
    integer, intent(in) :: decimals     !! a unit is 10**(-decimals)

    units_below = floor(in_units(value, decimals) + slack, int64)
  end function units_below

  !> The smallest number of units that is not below a value.
  pure integer(int64) function units_above(value, decimals)
    real(real128), intent(in) :: value  !! length in the unit of the specification
    integer, intent(in) :: decimals     !! a unit is 10**(-decimals)

    units_above = ceiling(in_units(value, decimals) - slack, int64)
  end function units_above

  !> The least n with |value| < 10**n.
  pure integer function order_of(value)
    real(real128), intent(in) :: value  !! any number except 0

    order_of = floor(log10(abs(value)))
    ! The last digit of the logarithm may be wrong.
    do while (10.0_real128**order_of <= abs(value))
      order_of = order_of + 1
    end do
  end function order_of

  !> Converts numbers of units to the nearest doubles, as a reader of their text does.
  pure subroutine lattice_reals(units, decimals, values)
    integer(int64), intent(in) :: units(:)  !! less than 2**53 each
    integer, intent(in) :: decimals         !! a unit is 10**(-decimals)
    real(real64), intent(out) :: values(:)  !! one for each number of units
    integer :: i

    do i = 1, size(units)
      values(i) = decimal_to_real64(decimal_value(units(i), -decimals))
    end do
  end subroutine lattice_reals

  pure integer(int64) function nearest_units(value, decimals)
    real(real128), intent(in) :: value
    integer, intent(in) :: decimals

    nearest_units = nint(in_units(value, decimals), int64)
  end function nearest_units

  pure real(real128) function in_units(value, decimals)
    real(real128), intent(in) :: value
    integer, intent(in) :: decimals

    if (decimals >= 0) then
      in_units = value * 10.0_real128**decimals
    else
      in_units = value / 10.0_real128**(-decimals)
    end if
  end function in_units

end module asperity_generated_surface
