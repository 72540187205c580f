!> Gauss's rule for integrals: nodes and weights of Legendre's polynomials.
module asperity_gauss_rule
  use asperity_constants, only: pi_128
  use asperity_kinds, only: real128, real64
  implicit none
  private

  public :: gauss_node, gauss_points, gauss_rule, gauss_weight

  !> Number of points of the rule in doubles, which is exact for polynomials up to degree 19.
  integer, parameter :: gauss_points = 10

  !> Nodes of the rule from 0 to 1, ascending, by `gauss_rule`.
  real(real64), parameter :: gauss_node(gauss_points) = [ &
    0.013046735741414139961_real64, 0.067468316655507744634_real64, &
    0.16029521585048779688_real64, 0.28330230293537640460_real64, &
    0.42556283050918439456_real64, 0.57443716949081560544_real64, &
    0.71669769706462359540_real64, 0.83970478414951220312_real64, &
    0.93253168334449225537_real64, 0.98695326425858586004_real64]

  real(real64), parameter :: half_of_weights(gauss_points / 2) = [ &
    0.033335672154344068797_real64, 0.074725674575290296573_real64, &
    0.10954318125799102200_real64, 0.13463335965499817755_real64, &
    0.14776211235737643509_real64]

  !> Weights of the rule; their sum is 1.
  real(real64), parameter :: gauss_weight(gauss_points) = &
    [half_of_weights, half_of_weights(gauss_points / 2:1:-1)]

contains

  !> Computes nodes and weights of Gauss's rule from -1 to 1.
  pure subroutine gauss_rule(nodes, weights)
    real(real128), intent(out) :: nodes(:)    !! nodes, in descending order
    real(real128), intent(out) :: weights(:)  !! weights of the nodes; their sum is 2
    real(real128) :: x, before, value, next, slope
    integer :: i, k, step, n

    n = size(nodes)
    do i = 1, n
      ! Zeros of Legendre's polynomial by Newton's method; the error of the guess is about 1E-3.
      x = cos(pi_128 * (i - 0.25_real128) / (n + 0.5_real128))
      do step = 1, 8
        before = 1.0_real128
        value = x
        do k = 2, n
          next = ((2 * k - 1) * x * value - (k - 1) * before) / k
          before = value
          value = next
        end do
        slope = n * (before - x * value) / ((1.0_real128 - x) * (1.0_real128 + x))
        x = x - value / slope
      end do
      nodes(i) = x
      weights(i) = 2 / ((1.0_real128 - x) * (1.0_real128 + x) * slope**2)
    end do
  end subroutine gauss_rule

end module asperity_gauss_rule
