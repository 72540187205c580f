!> Gauss's rule for integrals: nodes and weights of Legendre's polynomials.
module asperity_gauss_rule
  use asperity_kinds, only: real64
  implicit none
  private

  public :: gauss_node, gauss_points, gauss_weight

  !> Number of points of the rule, which is exact for polynomials up to degree 19.
  integer, parameter :: gauss_points = 10

  !> Nodes of the rule from 0 to 1, ascending.
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

end module asperity_gauss_rule
