!> Sources of 1/r in a box as moments of Chebyshev polynomials, and fields as sums of them.
!>
!> In boxes of half width 1 about 0 the kernel is a double sum of T_a(x) T_b(y) with
!> a**2 + b**2 <= order**2: a degree in the sense of Euclid is as good in all directions
!> (Trefethen, Proc. AMS 145, 1837, 2017). Interpolation between boxes is that of Fong and Darve
!> (J. Comput. Phys. 228, 8712, 2009).
module asperity_box_expansions
  use asperity_chebyshev_basis, only: chebyshev_nodes
  use asperity_kinds, only: real64
  implicit none
  private

  public :: translations, prepare, add_moments, add_field, multiply

  !> Greatest degree. Measured, the largest error of what one source does, and of sums over 1e4 to
  !> 1e6 places by their mean, all over a square and in clusters: order 6: 2e-4, 5e-7, 2e-6;
  !> 7: 4e-5, 9e-8, 4e-7; 8: 1.3e-5, 1.5e-8, 9e-8, at a tenth more time than 7.
  integer, parameter, public :: full_order = 8
  !> Greatest degree of rough sums.
  integer, parameter, public :: rough_order = 4

  !> Ways between the moments of boxes; those of a parent and its four children by quarter.
  type :: translations
    !> greatest degree, and number of moments
    integer :: order = 0, terms = 0
    !> degrees in x and y of each, the sum of their squares ascending
    integer, allocatable :: in_x(:), in_y(:)
    !> moments of a box to the field in a box 7 rows + columns before it
    real(real64), allocatable :: across(:, :, :)
    !> moments of a child to its parent's, and field of a parent to its child's
    real(real64), allocatable :: up(:, :, :), down(:, :, :)
  end type translations

contains

  !> Prepares the ways between boxes.
  pure subroutine prepare(order, ways)
    integer, intent(in) :: order             !! greatest degree, no more than the full one
    type(translations), intent(out) :: ways  !! the ways
    real(real64) :: node(order + 1), x((order + 1)**2), y((order + 1)**2)
    real(real64), allocatable :: value(:, :), to_terms(:, :), from_nodes(:, :), kernel(:, :), &
                                 half(:, :)
    integer :: i, k, row, column, terms, nodes, in_x(size(x)), in_y(size(x))

    ways%order = order
    terms = 0
    nodes = size(x)
    node = chebyshev_nodes(size(node))
    x = [(node, i=1, size(node))]
    y = [(spread(node(i), 1, size(node)), i=1, size(node))]
    do k = 0, order**2
      do i = 0, order
        do row = 0, order
          if (i**2 + row**2 /= k) cycle
          terms = terms + 1
          in_x(terms) = i
          in_y(terms) = row
        end do
      end do
    end do
    ways%in_x = in_x(:terms)
    ways%in_y = in_y(:terms)
    ways%terms = terms
    allocate (value(terms, nodes), to_terms(terms, nodes), from_nodes(nodes, terms), &
              kernel(nodes, nodes), half(terms, nodes), ways%across(terms, terms, -24:24), &
              ways%up(terms, terms, 0:3), ways%down(terms, terms, 0:3))
    ways%across = 0.0_real64
    ! A sum over Chebyshev's nodes of a function times T_a is its coefficient.
    do k = 1, nodes
      to_terms(:, k) = 0.0_real64
      call add_moments(ways, x(k), y(k), 1.0_real64, 1.0_real64, 0.0_real64, to_terms(:, k))
    end do
    do i = 1, terms
      to_terms(i, :) = to_terms(i, :) / sum(to_terms(i, :)**2)
    end do
    from_nodes = transpose(to_terms)
    do row = 0, 3
      do column = -3, 3
        if (max(row, abs(column)) < 2 .or. 7 * row + column < 0) cycle
        do k = 1, nodes
          kernel(:, k) = 1.0_real64 / sqrt((x - x(k) - 2 * column)**2 + (y - y(k) - 2 * row)**2)
        end do
        call multiply(to_terms, kernel, terms, nodes, half)
        call multiply(half, from_nodes, terms, terms, ways%across(:, :, 7 * row + column))
        ways%across(:, :, -7 * row - column) = transpose(ways%across(:, :, 7 * row + column))
      end do
    end do
    do i = 0, 3
      do k = 1, nodes
        value(:, k) = 0.0_real64
        call add_moments(ways, x(k) + (2 * mod(i, 2) - 1), y(k) + (2 * (i / 2) - 1), 2.0_real64, &
                         1.0_real64, 0.0_real64, value(:, k))
      end do
      call multiply(value, from_nodes, terms, terms, ways%up(:, :, i))
      ways%down(:, :, i) = transpose(ways%up(:, :, i))
    end do
  end subroutine prepare

  ! Chebyshev's polynomials, their slopes and second derivatives.
  pure subroutine polynomials(order, z, t, d, dd)
    integer, intent(in) :: order
    real(real64), intent(in) :: z
    real(real64), dimension(0:order), intent(out) :: t, d, dd
    integer :: l

    t(:1) = [1.0_real64, z]
    d(:1) = [0.0_real64, 1.0_real64]
    dd(:1) = 0.0_real64
    do l = 2, order
      t(l) = 2.0_real64 * z * t(l - 1) - t(l - 2)
      d(l) = 2.0_real64 * (t(l - 1) + z * d(l - 1)) - d(l - 2)
      dd(l) = 4.0_real64 * d(l - 1) + 2.0_real64 * z * dd(l - 1) - dd(l - 2)
    end do
  end subroutine polynomials

  !> Adds the moments of a source and of its Laplacian.
  pure subroutine add_moments(ways, x, y, half, charge, spread, moment)
    type(translations), intent(in) :: ways    !! their degrees
    real(real64), intent(in) :: x             !! place from the middle of the box
    real(real64), intent(in) :: y             !! place from the middle of the box
    real(real64), intent(in) :: half          !! half of the box's width
    real(real64), intent(in) :: charge        !! of 1/r
    real(real64), intent(in) :: spread        !! of its Laplacian: charge times a length squared
    real(real64), intent(inout) :: moment(:)  !! of the box
    real(real64), dimension(0:ways%order) :: tx, ty, dx, dy, ddx, ddy
    real(real64) :: second
    integer :: k

    call polynomials(ways%order, x / half, tx, dx, ddx)
    call polynomials(ways%order, y / half, ty, dy, ddy)
    second = spread / (half * half)
    ddy = charge * ty + second * ddy
    ty = second * ty
    do k = 1, size(moment)
      associate (a => ways%in_x(k), b => ways%in_y(k))
        moment(k) = moment(k) + (ddy(b) * tx(a) + ty(b) * ddx(a))
      end associate
    end do
  end subroutine add_moments

  !> Adds the field of a box at a place.
  pure subroutine add_field(ways, x, y, half, field, value)
    type(translations), intent(in) :: ways    !! their degrees
    real(real64), intent(in) :: x             !! place from the middle of the box
    real(real64), intent(in) :: y             !! place from the middle of the box
    real(real64), intent(in) :: half          !! half of the box's width
    real(real64), intent(in) :: field(:)      !! of the box
    real(real64), intent(inout) :: value(4)   !! potential, Laplacian, slopes in x and y
    real(real64), dimension(0:ways%order) :: tx, ty, dx, dy, ddx, ddy
    integer :: k

    call polynomials(ways%order, x / half, tx, dx, ddx)
    call polynomials(ways%order, y / half, ty, dy, ddy)
    dx = dx / half
    dy = dy / half
    ddx = ddx / (half * half)
    ddy = ddy / (half * half)
    do k = 1, size(field)
      associate (a => ways%in_x(k), b => ways%in_y(k))
        value = value + field(k) * [tx(a) * ty(b), ddx(a) * ty(b) + tx(a) * ddy(b), &
                                    dx(a) * ty(b), tx(a) * dy(b)]
      end associate
    end do
  end subroutine add_field

  !> A product of matrices, in an order that neither library nor processor decides.
  pure subroutine multiply(left, right, rows, columns, product)
    real(real64), contiguous, intent(in) :: left(:, :)        !! first factor
    real(real64), contiguous, intent(in) :: right(:, :)       !! second factor
    integer, intent(in) :: rows                               !! of the first factor that count
    integer, intent(in) :: columns                            !! of the second factor that count
    real(real64), contiguous, intent(inout) :: product(:, :)  !! gets these rows and columns
    integer :: inner, j, k, whole

    ! A square matrix is cut on both sides.
    inner = size(left, 2)
    if (size(left, 1) == inner) inner = rows
    whole = inner - mod(inner, 4)
    do j = 1, columns
      product(:rows, j) = 0.0_real64
      do k = 1, whole, 4
        product(:rows, j) = product(:rows, j) + (left(:rows, k) * right(k, j) &
                                                 + left(:rows, k + 1) * right(k + 1, j) &
                                                 + left(:rows, k + 2) * right(k + 2, j) &
                                                 + left(:rows, k + 3) * right(k + 3, j))
      end do
      do k = whole + 1, inner
        product(:rows, j) = product(:rows, j) + left(:rows, k) * right(k, j)
      end do
    end do
  end subroutine multiply

end module asperity_box_expansions
