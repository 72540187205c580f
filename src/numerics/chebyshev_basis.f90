!> Interpolation from Chebyshev nodes to a line of grid elements.
!>
!> The nodes are the roots of the Chebyshev polynomial whose degree is their number (Trefethen,
!> Approximation Theory and Approximation Practice, 2013).
module asperity_chebyshev_basis
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  implicit none
  private

  public :: chebyshev_nodes, lagrange_at_cells

contains

  !> Positions of the nodes in (-1, 1), in descending order.
  pure function chebyshev_nodes(n) result(node)
    integer, intent(in) :: n   !! number of nodes
    real(real64) :: node(n)    !! positions of the nodes
    integer :: k

    do k = 1, n
      node(k) = cos((k - 0.5_real64) * pi / n)
    end do
  end function chebyshev_nodes

  !> Lagrange's polynomials at the centres of a line of grid elements, as sums of Chebyshev's.
  pure function lagrange_at_cells(n, cells, edge, step) result(values)
    integer, intent(in) :: n                  !! number of nodes
    integer, intent(in) :: cells              !! number of elements
    real(real64), intent(in) :: edge          !! start of the line, over the radius of the patch
    real(real64), intent(in) :: step          !! side of an element, over the radius of the patch
    real(real64) :: values(n, cells)          !! polynomials at each element
    real(real64) :: node(n), z, t(0:n), s(0:n)
    integer :: i, k, l

    node = chebyshev_nodes(n)
    do i = 1, cells
      z = edge + (i - 0.5_real64) * step
      t = chebyshev_values(n, z)
      do k = 1, n
        s = chebyshev_values(n, node(k))
        values(k, i) = 1.0_real64 / n
        do l = 1, n - 1
          values(k, i) = values(k, i) + 2.0_real64 / n * s(l) * t(l)
        end do
      end do
    end do
  end function lagrange_at_cells

  ! Chebyshev's polynomials of degree 0 to n.
  pure function chebyshev_values(n, z) result(t)
    integer, intent(in) :: n
    real(real64), intent(in) :: z
    real(real64) :: t(0:n)
    integer :: l

    t(0) = 1.0_real64
    t(1) = z
    do l = 2, n
      t(l) = 2.0_real64 * z * t(l - 1) - t(l - 2)
    end do
  end function chebyshev_values

end module asperity_chebyshev_basis
