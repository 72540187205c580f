!> How far summits stand above a plane, on the average: heights from a Gaussian with cut-offs, or
!> the sum of two such heights, one of each surface.
!>
!> The sum of two cut Gaussians has a closed density: that of the whole sum times the chance that
!> both parts lie between their cut-offs, given the sum.
module asperity_greenwood_heights
  use asperity_constants, only: pi_128
  use asperity_generation_values, only: exact_value, gaussian_spec
  use asperity_greenwood_quadrature, only: integrand, integrate
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int32, real128, real64
  implicit none
  private

  public :: height_law, law_of_heights, excess_moments

  ! One part of the sum that varies.
  type :: cut_gaussian
    real(real128) :: mean = 0.0_real128, deviation = 0.0_real128
    real(real128) :: lowest = 0.0_real128, highest = 0.0_real128
    real(real128) :: mass = 1.0_real128  ! what is between the cut-offs
  end type cut_gaussian

  !> The law of a height, or of a sum of heights.
  type :: height_law
    private
    integer :: parts = 0                     ! how many of them vary
    real(real128) :: fixed = 0.0_real128     ! sum of those that do not
    type(cut_gaussian) :: part(2)
    real(real128), public :: lowest = 0.0_real128   !! nothing is below
    real(real128), public :: highest = 0.0_real128  !! nothing is above
  end type height_law

  ! (u - separation)**power times the density, with u - separation = v**2: no root at the end.
  type, extends(integrand) :: excess_integrand
    type(height_law) :: law
    real(real128) :: separation = 0.0_real128
    integer, allocatable :: doubled_powers(:)
  contains
    procedure :: values => excess_values
  end type excess_integrand

contains

  !> The law of the sum of one or two heights.
  pure function law_of_heights(heights) result(law)
    type(gaussian_spec), intent(in) :: heights(:)  !! one or two
    type(height_law) :: law
    type(cut_gaussian) :: part
    integer :: i

    do i = 1, size(heights)
      law%lowest = law%lowest + heights(i)%lowest
      law%highest = law%highest + heights(i)%highest
      if (.not. heights(i)%highest > heights(i)%lowest) then
        law%fixed = law%fixed + heights(i)%lowest
        cycle
      end if
      part%mean = exact_value(heights(i)%mean)
      part%deviation = exact_value(heights(i)%deviation)
      part%lowest = heights(i)%lowest
      part%highest = heights(i)%highest
      part%mass = chance((part%lowest - part%mean) / part%deviation, &
                         (part%highest - part%mean) / part%deviation)
      law%parts = law%parts + 1
      law%part(law%parts) = part
    end do
  end function law_of_heights

  !> Mean of (u - separation)**power over the heights u above the separation; the others count as
  !> 0. Powers are given doubled, as 5 for 5/2.
  pure subroutine excess_moments(law, separation, doubled_powers, moments)
    type(height_law), intent(in) :: law            !! of u
    real(real128), intent(in) :: separation        !! length
    integer, intent(in) :: doubled_powers(:)       !! 0 or more
    real(real128), intent(out) :: moments(:)       !! as many, length**power
    type(excess_integrand) :: functions
    real(real128) :: places(14), near, kink
    integer(int32) :: order(size(places))
    integer :: used, i, j

    moments = 0.0_real128
    if (.not. law%highest > separation) return
    if (law%parts == 0) then
      moments = sqrt(law%fixed - separation)**doubled_powers
      return
    end if
    functions%law = law
    functions%separation = separation
    allocate (functions%doubled_powers(size(doubled_powers)))
    functions%doubled_powers = doubled_powers
    ! The density has kinks where a cut-off of one part meets one of the other, and is steep beside
    ! them when one part varies much less.
    near = 8 * minval(law%part(:law%parts)%deviation)
    places(1:2) = [max(law%lowest, separation), law%highest]
    used = 2
    if (law%parts == 2) then
      do i = 1, 4
        do j = -1, 1
          kink = law%fixed + merge(law%part(1)%lowest, law%part(1)%highest, i <= 2) + &
                 merge(law%part(2)%lowest, law%part(2)%highest, modulo(i, 2) == 0) + j * near
          if (kink <= places(1) .or. kink >= law%highest) cycle
          used = used + 1
          places(used) = kink
        end do
      end do
    end if
    call sort_keys(real(places(:used), real64), order(:used))
    places(:used) = sqrt(places(order(:used)) - separation)
    call integrate(functions, places(:used), moments)
  end subroutine excess_moments

  pure function excess_values(self, x, number) result(values)
    class(excess_integrand), intent(in) :: self
    real(real128), intent(in) :: x
    integer, intent(in) :: number
    real(real128) :: values(number)

    values = 2 * x**(self%doubled_powers + 1) * density(self%law, self%separation + x**2)
  end function excess_values

  !> Density of the heights at u.
  pure real(real128) function density(law, u)
    type(height_law), intent(in) :: law
    real(real128), intent(in) :: u
    real(real128) :: both, middle, spread, from, to

    density = 0.0_real128
    if (u < law%lowest .or. u > law%highest) return
    associate (first => law%part(1), second => law%part(2))
      if (law%parts == 1) then
        density = bell((u - law%fixed - first%mean) / first%deviation) / &
                  (first%deviation * first%mass)
        return
      end if
      both = hypot(first%deviation, second%deviation)
      spread = first%deviation * second%deviation / both
      ! Of the first part, given the sum.
      middle = first%mean + (u - first%mean - second%mean) * (first%deviation / both)**2
      from = max(first%lowest, u - second%highest)
      to = min(first%highest, u - second%lowest)
      if (.not. to > from) return
      density = bell((u - first%mean - second%mean) / both) / both * &
                chance((from - middle) / spread, (to - middle) / spread) / &
                (first%mass * second%mass)
    end associate
  end function density

  !> Density of the normal law.
  elemental real(real128) function bell(x)
    real(real128), intent(in) :: x

    bell = exp(-x**2 / 2) / sqrt(2 * pi_128)
  end function bell

  !> Chance of the normal law between two places; by the tails on the far side of 0, where a
  !> difference loses no digits.
  elemental real(real128) function chance(from, to)
    real(real128), intent(in) :: from, to
    real(real128), parameter :: root = sqrt(2.0_real128)

    if (from > 0) then
      chance = (erfc(from / root) - erfc(to / root)) / 2
    else if (to < 0) then
      chance = (erfc(-to / root) - erfc(-from / root)) / 2
    else
      chance = 1 - (erfc(-from / root) + erfc(to / root)) / 2
    end if
  end function chance

end module asperity_greenwood_heights
