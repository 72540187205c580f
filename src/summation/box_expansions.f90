!> Sources of 1/r in a box as moments of Chebyshev polynomials, and fields in a box as sums of them.
!>
!> In a box of half width 1 about 0 the kernel between two boxes is a double sum of Chebyshev
!> polynomials T_a(x) T_b(y) with a**2 + b**2 <= order**2: a sum up to that degree, in the sense of
!> Euclid, is as good in all directions (Trefethen, Proc. AMS 145, 1837, 2017). The idea of
!> interpolation between boxes is that of Fong and Darve (J. Comput. Phys. 228, 8712, 2009).
module asperity_box_expansions
  use asperity_chebyshev_basis, only: chebyshev_nodes
  use asperity_kinds, only: real64
  implicit none
  private

  public :: expansion, expand, add_moments, add_field, multiply

  !> Greatest order.
  integer, parameter :: most = 12

  !> Moments of one order and the ways between them.
  type :: expansion
    !> greatest degree
    integer :: order = 0
    !> number of moments
    integer :: terms = 0
    !> where the moments of a degree in y begin, less one; they go on with the degree in x
    integer :: before(0:most + 1) = 0
    !> moments of a box into the field in another, that is shifted by -(7 row + column) boxes
    real(real64), allocatable :: across(:, :, :)
    !> moments of a child into those of the box around it, for four children
    real(real64), allocatable :: up(:, :, :)
    !> field of a box into those of its children
    real(real64), allocatable :: down(:, :, :)
  end type expansion

contains

  !> Prepares the moments of an order; the levels above and below have the same.
  subroutine expand(order, this, status)
    integer, intent(in) :: order          !! greatest degree, at most 12
    type(expansion), intent(out) :: this  !! what is prepared
    integer, intent(out) :: status        !! 0, or memory has run out
    real(real64), allocatable :: to_terms(:, :), kernel(:, :), half(:, :), from_nodes(:, :)
    real(real64) :: node(order + 3), t(0:order, order + 3), r(2), one(0:order, 0:order, 0:1)
    integer :: a, b, i, j, k, l, n, column, row

    n = size(node)
    node = chebyshev_nodes(n)
    do k = 1, n
      t(:, k) = chebyshev(order, node(k))
    end do
    this%order = order
    do b = 0, order
      this%before(b + 1) = this%before(b) + int(sqrt(real(order**2 - b**2, real64)) + 1e-9_real64) + 1
    end do
    this%terms = this%before(order + 1)
    allocate (this%across(this%terms, this%terms, -24:24), &
              this%up(this%terms, this%terms, 0:3), this%down(this%terms, this%terms, 0:3), &
              to_terms(this%terms, n * n), from_nodes(n * n, this%terms), kernel(n * n, n * n), &
              half(this%terms, n * n), stat=status)
    if (status /= 0) return
    do l = 1, n
      do k = 1, n
        do b = 0, order
          do a = 0, this%before(b + 1) - this%before(b) - 1
            to_terms(this%before(b) + a + 1, k + n * (l - 1)) = &
              t(a, k) * t(b, l) * merge(1, 2, a == 0) * merge(1, 2, b == 0) / real(n * n, real64)
          end do
        end do
      end do
    end do
    from_nodes = transpose(to_terms)
    this%across = 0.0_real64
    do row = -3, 3
      do column = -3, 3
        if (max(abs(row), abs(column)) < 2) cycle
        do l = 1, n * n
          do k = 1, n * n
            r(1) = node(mod(k - 1, n) + 1) - node(mod(l - 1, n) + 1) - 2.0_real64 * column
            r(2) = node((k - 1) / n + 1) - node((l - 1) / n + 1) - 2.0_real64 * row
            kernel(k, l) = 1.0_real64 / sqrt(r(1) * r(1) + r(2) * r(2))
          end do
        end do
        call multiply(to_terms, kernel, n * n, half)
        call multiply(half, from_nodes, this%terms, this%across(:, :, 7 * row + column))
      end do
    end do

    ! T_a((x -+ 1) / 2) as a sum of T_b(x), b <= a.
    do j = 0, 1
      one(:, :, j) = 0.0_real64
      do k = 1, n
        associate (half_way => chebyshev(order, 0.5_real64 * (node(k) + 2 * j - 1)))
          do b = 0, order
            one(:, b, j) = one(:, b, j) + half_way * t(b, k) * (merge(1, 2, b == 0) / real(n, real64))
          end do
        end associate
      end do
    end do
    this%up = 0.0_real64
    do j = 0, order
      do i = 0, this%before(j + 1) - this%before(j) - 1
        do b = j, order
          do a = i, this%before(b + 1) - this%before(b) - 1
            do k = 0, 3
              this%up(this%before(b) + a + 1, this%before(j) + i + 1, k) = &
                one(a, i, mod(k, 2)) * one(b, j, k / 2)
            end do
          end do
        end do
      end do
    end do
    do k = 0, 3
      this%down(:, :, k) = transpose(this%up(:, :, k))
    end do
  end subroutine expand

  ! Chebyshev's polynomials of degree 0 to n.
  pure function chebyshev(n, z) result(t)
    integer, intent(in) :: n
    real(real64), intent(in) :: z
    real(real64) :: t(0:n), d(0:n), dd(0:n)

    call polynomials(n, z, t, d, dd)
  end function chebyshev

  ! Chebyshev's polynomials of degree 0 to n, their slopes and second derivatives.
  pure subroutine polynomials(n, z, t, d, dd)
    integer, intent(in) :: n
    real(real64), intent(in) :: z
    real(real64), intent(out) :: t(0:n), d(0:n), dd(0:n)
    integer :: l

    t(0) = 1.0_real64
    d(0) = 0.0_real64
    dd(0) = 0.0_real64
    t(1) = z
    d(1) = 1.0_real64
    dd(1) = 0.0_real64
    do l = 2, n
      t(l) = 2.0_real64 * z * t(l - 1) - t(l - 2)
      d(l) = 2.0_real64 * (t(l - 1) + z * d(l - 1)) - d(l - 2)
      dd(l) = 4.0_real64 * d(l - 1) + 2.0_real64 * z * dd(l - 1) - dd(l - 2)
    end do
  end subroutine polynomials

  !> Adds the moments of a source and of its Laplacian.
  pure subroutine add_moments(this, x, y, half, charge, spread, moment)
    type(expansion), intent(in) :: this            !! the order
    real(real64), intent(in) :: x                  !! place from the middle of the box
    real(real64), intent(in) :: y                  !! place from the middle of the box
    real(real64), intent(in) :: half               !! half of the box's width
    real(real64), intent(in) :: charge             !! of 1/r
    real(real64), intent(in) :: spread             !! of its Laplacian: charge times a length squared
    real(real64), intent(inout) :: moment(:)       !! of the box
    real(real64), dimension(0:this%order) :: tx, ty, dx, dy, ddx, ddy
    real(real64) :: second, u, v
    integer :: a, b

    call polynomials(this%order, x / half, tx, dx, ddx)
    call polynomials(this%order, y / half, ty, dy, ddy)
    second = spread / (half * half)
    do b = 0, this%order
      u = charge * ty(b) + second * ddy(b)
      v = second * ty(b)
      do a = 0, this%before(b + 1) - this%before(b) - 1
        moment(this%before(b) + 1 + a) = moment(this%before(b) + 1 + a) + (u * tx(a) + v * ddx(a))
      end do
    end do
  end subroutine add_moments

  !> Adds a field at a place: its value, its Laplacian and its slopes.
  pure subroutine add_field(this, x, y, half, field, value)
    type(expansion), intent(in) :: this            !! the order
    real(real64), intent(in) :: x                  !! place from the middle of the box
    real(real64), intent(in) :: y                  !! place from the middle of the box
    real(real64), intent(in) :: half               !! half of the box's width
    real(real64), intent(in) :: field(:)           !! of the box
    real(real64), intent(inout) :: value(:)        !! value, Laplacian [, slope in x, slope in y]
    real(real64), dimension(0:this%order) :: tx, ty, dx, dy, ddx, ddy
    real(real64) :: s, s1, s2
    integer :: a, b

    call polynomials(this%order, x / half, tx, dx, ddx)
    call polynomials(this%order, y / half, ty, dy, ddy)
    do b = 0, this%order
      s = 0.0_real64
      s2 = 0.0_real64
      do a = 0, this%before(b + 1) - this%before(b) - 1
        s = s + field(this%before(b) + 1 + a) * tx(a)
        s2 = s2 + field(this%before(b) + 1 + a) * ddx(a)
      end do
      value(1) = value(1) + s * ty(b)
      value(2) = value(2) + (s2 * ty(b) + s * ddy(b)) / (half * half)
      if (size(value) == 2) cycle
      s1 = 0.0_real64
      do a = 0, this%before(b + 1) - this%before(b) - 1
        s1 = s1 + field(this%before(b) + 1 + a) * dx(a)
      end do
      value(3) = value(3) + s1 * ty(b) / half
      value(4) = value(4) + s * dy(b) / half
    end do
  end subroutine add_field

  !> A product of matrices, in an order that no library and no processor decides.
  pure subroutine multiply(left, right, columns, product)
    real(real64), contiguous, intent(in) :: left(:, :)      !! first factor
    real(real64), contiguous, intent(in) :: right(:, :)     !! second factor
    integer, intent(in) :: columns                          !! of the second factor that count
    real(real64), contiguous, intent(out) :: product(:, :)  !! these columns of the product
    integer :: j, k

    do j = 1, columns
      product(:, j) = 0.0_real64
      do k = 1, size(left, 2) - 3, 4
        product(:, j) = product(:, j) + (left(:, k) * right(k, j) + left(:, k + 1) * right(k + 1, j) &
                                         + left(:, k + 2) * right(k + 2, j) &
                                         + left(:, k + 3) * right(k + 3, j))
      end do
      do k = size(left, 2) - mod(size(left, 2), 4) + 1, size(left, 2)
        product(:, j) = product(:, j) + left(:, k) * right(k, j)
      end do
    end do
  end subroutine multiply

end module asperity_box_expansions
