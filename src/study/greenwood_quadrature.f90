!> Integrals of smooth functions in 113 bits, by Gauss's rule on pieces that are halved until the
!> halves agree with the whole.
module asperity_greenwood_quadrature
  use asperity_kinds, only: real128
  implicit none
  private

  public :: gauss_rule, integrand, integrate

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

  !> Nodes and weights of Gauss's rule from -1 to 1.
  pure subroutine gauss_rule(nodes, weights)
    real(real128), intent(out) :: nodes(:)    !! descending
    real(real128), intent(out) :: weights(:)  !! as many; their sum is 2
    real(real128) :: x, before, here, next, slope
    real(real128), parameter :: pi = 3.14159265358979323846264338327950288_real128
    integer :: i, k, step, n

    n = size(nodes)
    do i = 1, n
      ! Zeros of Legendre's polynomial by Newton's method, from a guess good to some 1E-3.
      x = cos(pi * (i - 0.25_real128) / (n + 0.5_real128))
      do step = 1, 8
        before = 1.0_real128
        here = x
        do k = 2, n
          next = ((2 * k - 1) * x * here - (k - 1) * before) / k
          before = here
          here = next
        end do
        slope = n * (before - x * here) / ((1.0_real128 - x) * (1.0_real128 + x))
        x = x - here / slope
      end do
      nodes(i) = x
      weights(i) = 2 / ((1.0_real128 - x) * (1.0_real128 + x) * slope**2)
    end do
  end subroutine gauss_rule

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
