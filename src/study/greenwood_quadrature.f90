!> Integrals of smooth functions in 113 bits, by Gauss's rule on pieces that are halved until the
!> halves agree with the whole.
module asperity_greenwood_quadrature
  use asperity_gauss_rule, only: gauss_rule
  use asperity_kinds, only: real128
  implicit none
  private

  public :: integrand, integrate

  ! Points of the rule, and how far apart a piece and its halves may be, of the whole integral.
  integer, parameter :: points = 20
  real(real128), parameter :: tolerance = 1.0e-20_real128
  integer, parameter :: most_halvings = 40

  !> Several functions of one variable, integrated side by side.
  type, abstract :: integrand
  contains
    !> The functions at a place.
    procedure(values_interface), deferred :: values
  end type integrand

  abstract interface
    pure function values_interface(self, x, number) result(values)
      import :: integrand, real128
      implicit none
      class(integrand), intent(in) :: self  !! the functions
      real(real128), intent(in) :: x        !! the variable
      integer, intent(in) :: number         !! how many functions there are
      real(real128) :: values(number)
    end function values_interface
  end interface

contains

  !> Integrals between the first and the last of some places. The functions may have kinks at the
  !> places.
  pure subroutine integrate(functions, places, integrals)
    class(integrand), intent(in) :: functions      !! what to integrate, 0 or more everywhere
    real(real128), intent(in) :: places(:)         !! ascending, at least two
    real(real128), intent(out) :: integrals(:)     !! one a function
    real(real128) :: nodes(points), weights(points), scale(size(integrals))
    real(real128), allocatable :: pieces(:, :)
    integer :: i

    call gauss_rule(nodes, weights)
    allocate (pieces(size(integrals), size(places) - 1))
    do i = 1, size(pieces, 2)
      pieces(:, i) = by_rule(places(i), places(i + 1))
    end do
    scale = tolerance * sum(pieces, 2)
    integrals = 0.0_real128
    do i = 1, size(pieces, 2)
      call refine(places(i), places(i + 1), pieces(:, i), 0, integrals)
    end do

  contains

    pure function by_rule(from, to) result(values)
      real(real128), intent(in) :: from, to
      real(real128) :: values(size(integrals))
      integer :: k

      values = 0.0_real128
      do k = 1, points
        values = values + weights(k) * &
                 functions%values((from + to) / 2 + nodes(k) * (to - from) / 2, size(values))
      end do
      values = values * (to - from) / 2
    end function by_rule

    pure recursive subroutine refine(from, to, whole, halvings, total)
      real(real128), intent(in) :: from, to, whole(:)
      integer, intent(in) :: halvings
      real(real128), intent(inout) :: total(:)
      real(real128) :: left(size(integrals)), right(size(integrals)), middle

      middle = (from + to) / 2
      left = by_rule(from, middle)
      right = by_rule(middle, to)
      if (halvings == most_halvings .or. all(abs(left + right - whole) <= scale)) then
        total = total + left + right
      else
        call refine(from, middle, left, halvings + 1, total)
        call refine(middle, to, right, halvings + 1, total)
      end if
    end subroutine refine

  end subroutine integrate

end module asperity_greenwood_quadrature
