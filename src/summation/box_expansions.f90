!> Sources of 1/r in a box as moments of Chebyshev polynomials, and fields as sums of them.
!>
!> In boxes of half width 1 about 0 the kernel is a double sum of T_a(x) T_b(y) with
!> a**2 + b**2 <= order**2: a degree in the sense of Euclid is as good in all directions
!> (Trefethen, Proc. AMS 145, 1837, 2017). Interpolation between boxes is that of Fong and Darve
!> (J. Comput. Phys. 228, 8712, 2009).
!>
!> A way from a box to another whose place is mirrored is the same but for the signs of what is
!> odd. So boxes that are images of each other are added and subtracted first, and go their way
!> together: 12 ways in place of 27 for the boxes that act on one in a full plane.
module asperity_box_expansions
  use asperity_chebyshev_basis, only: chebyshev_nodes
  use asperity_kinds, only: real64
  implicit none
  private

  public :: translations, prepare, add_moments, add_field, go

  !> Greatest degree. Measured, the largest error of what one source does, and of sums over 1e4 to
  !> 1e6 places by their mean, all over a square and in clusters: order 6: 2e-4, 5e-7, 2e-6;
  !> 7: 4e-5, 9e-8, 4e-7; 8: 1.3e-5, 1.5e-8, 9e-8, at a tenth more time than 7.
  integer, parameter :: order = 8
  ! Of rough sums: the most of a**2 + b**2.
  integer, parameter :: rough_square = 18
  !> Boxes whose ways are gone side by side.
  integer, parameter, public :: lanes = 16
  !> The ways from boxes to the one around them and back; others are 4 rows + columns.
  integer, parameter, public :: up = 0, down = 1

  !> Ways between the moments of boxes.
  type :: translations
    !> number of moments, and of those that rough sums take
    integer :: terms = 0, rough_terms = 0
    !> degrees in x and y of each, the sum of their squares ascending
    integer, allocatable :: in_x(:), in_y(:)
    !> what is odd: 1 in x, and 2 in y
    integer, allocatable :: odd(:)
    !> from terms to terms: to the box around from its first quarter, back, and to a box from
    !> those that are not before it in rows and columns
    real(real64), allocatable :: way(:, :, :)
  end type translations

contains

  !> Prepares the ways between boxes.
  subroutine prepare(ways)
    type(translations), intent(out) :: ways  !! the ways
    integer, parameter :: n = order + 1
    real(real64) :: node(n), basis(n, 0:order), half(0:order, 0:order)
    real(real64) :: kernel(n, n, n, n), t(0:order), d(0:order), dd(0:order)
    integer, dimension(n * n) :: in_x, in_y
    integer :: a, b, i, k, row, column

    node = chebyshev_nodes(n)
    k = 0
    do i = 0, order**2
      do a = 0, order
        do b = 0, order
          if (a**2 + b**2 /= i) cycle
          k = k + 1
          in_x(k) = a
          in_y(k) = b
        end do
      end do
      if (i == rough_square) ways%rough_terms = k
    end do
    ways%terms = k
    ways%in_x = in_x(:k)
    ways%in_y = in_y(:k)
    ways%odd = mod(ways%in_x, 2) + 2 * mod(ways%in_y, 2)
    allocate (ways%way(k, k, 0:15), source=0.0_real64)
    ! A sum over Chebyshev's nodes of a function times this is its coefficient.
    do i = 1, n
      call polynomials(node(i), t, d, dd)
      basis(i, :) = 2 * t / n
    end do
    basis(:, 0) = 0.5_real64 * basis(:, 0)
    half = 0.0_real64
    do i = 1, n
      call polynomials(0.5_real64 * (node(i) - 1.0_real64), t, d, dd)
      do a = 0, order
        half(:, a) = half(:, a) + basis(i, a) * t
      end do
    end do
    do i = 1, ways%terms
      ways%way(:, i, down) = half(ways%in_x, ways%in_x(i)) * half(ways%in_y, ways%in_y(i))
      ways%way(i, :, up) = ways%way(:, i, down)
    end do
    !$omp parallel do private(kernel, a, b, i, k, row)
    do column = 2, 3
      do row = 0, column
        do a = 1, n
          do b = 1, n
            do i = 1, n
              kernel(:, i, a, b) = 1.0_real64 / sqrt((node - node(a) - 2 * column)**2 + &
                                                     (node(i) - node(b) - 2 * row)**2)
            end do
          end do
        end do
        do i = 1, 4
          call turn(basis, kernel)
        end do
        do i = 1, ways%terms
          do k = 1, ways%terms
            associate (x => ways%in_x([i, k]) + 1, y => ways%in_y([i, k]) + 1)
              ways%way(k, i, 4 * row + column) = kernel(x(1), y(1), x(2), y(2))
              ways%way(k, i, 4 * column + row) = kernel(y(1), x(1), y(2), x(2))
            end associate
          end do
        end do
      end do
    end do
    !$omp end parallel do
  end subroutine prepare

  ! Coefficients of the last of four variables, which becomes the first.
  pure subroutine turn(basis, kernel)
    real(real64), intent(in) :: basis(order + 1, order + 1)
    real(real64), intent(inout) :: kernel((order + 1)**3, order + 1)
    real(real64) :: found(order + 1, (order + 1)**3), sums((order + 1)**3)
    integer :: a, k

    do a = 1, size(basis, 2)
      sums = 0.0_real64
      do k = 1, size(basis, 1)
        sums = sums + basis(k, a) * kernel(:, k)
      end do
      found(a, :) = sums
    end do
    kernel = reshape(found, shape(kernel))
  end subroutine turn

  ! Chebyshev's polynomials, their slopes and second derivatives.
  pure subroutine polynomials(z, t, d, dd)
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
  pure subroutine add_moments(ways, x, y, charge, spread, moment)
    type(translations), intent(in) :: ways    !! their degrees
    real(real64), intent(in) :: x             !! place from the middle of the box, over its half
    real(real64), intent(in) :: y             !! place from the middle of the box, over its half
    real(real64), intent(in) :: charge        !! of 1/r
    real(real64), intent(in) :: spread        !! of its Laplacian, over the half squared
    real(real64), intent(inout) :: moment(:)  !! of the box, as many as the sums take
    real(real64), dimension(0:order) :: tx, ty, dx, dy, ddx, ddy
    integer :: k

    call polynomials(x, tx, dx, ddx)
    call polynomials(y, ty, dy, ddy)
    ddy = charge * ty + spread * ddy
    ty = spread * ty
    do k = 1, size(moment)
      associate (a => ways%in_x(k), b => ways%in_y(k))
        moment(k) = moment(k) + (ddy(b) * tx(a) + ty(b) * ddx(a))
      end associate
    end do
  end subroutine add_moments

  !> Adds the field of a box at a place.
  pure subroutine add_field(ways, x, y, half, field, value)
    type(translations), intent(in) :: ways    !! their degrees
    real(real64), intent(in) :: x             !! place from the middle of the box, over its half
    real(real64), intent(in) :: y             !! place from the middle of the box, over its half
    real(real64), intent(in) :: half          !! half of the box's width
    real(real64), intent(in) :: field(:)      !! of the box, as many as the sums take
    real(real64), intent(inout) :: value(4)   !! potential, Laplacian, slopes in x and y
    real(real64), dimension(0:order) :: tx, ty, dx, dy, ddx, ddy
    real(real64) :: here(4)
    logical :: rough
    integer :: k

    rough = size(field) < ways%terms

    call polynomials(x, tx, dx, ddx)
    call polynomials(y, ty, dy, ddy)
    here = 0.0_real64
    do k = 1, size(field)
      associate (a => ways%in_x(k), b => ways%in_y(k))
        here(1) = here(1) + field(k) * tx(a) * ty(b)
        if (rough) cycle
        here(2) = here(2) + field(k) * (ddx(a) * ty(b) + tx(a) * ddy(b))
        here(3) = here(3) + field(k) * dx(a) * ty(b)
        here(4) = here(4) + field(k) * tx(a) * dy(b)
      end associate
    end do
    value = value + here / [1.0_real64, half * half, half, half]
  end subroutine add_field

  !> Adds what goes a way from boxes, in an order that neither library nor processor decides.
  pure subroutine go(ways, way, from, box, sums)
    type(translations), intent(in) :: ways             !! all
    integer, intent(in) :: way                         !! which
    real(real64), contiguous, intent(in) :: from(:, :) !! moments of boxes
    !> for each lane the box that it comes from, mirrored in x, in y, in both; or 0
    integer, intent(in) :: box(0:3, lanes)
    real(real64), contiguous, intent(inout) :: sums(:, :) !! by lane and term, as many as count
    real(real64) :: panel(lanes, size(sums, 2), 0:3), part(size(sums, 2), 0:3), total(lanes)
    real(real64) :: same(2), other(2)
    integer :: i, k, lane, q

    do lane = 1, lanes
      do q = 0, 3
        part(:, q) = 0.0_real64
        if (box(q, lane) > 0) part(:, q) = from(:size(part, 1), box(q, lane))
      end do
      do k = 1, size(part, 1)
        same = part(k, 0:2:2) + part(k, 1:3:2)
        other = part(k, 0:2:2) - part(k, 1:3:2)
        panel(lane, k, ways%odd(k)) = same(1) + same(2)
        panel(lane, k, ieor(1, ways%odd(k))) = other(1) + other(2)
        panel(lane, k, ieor(2, ways%odd(k))) = same(1) - same(2)
        panel(lane, k, ieor(3, ways%odd(k))) = other(1) - other(2)
      end do
    end do
    do i = 1, size(sums, 2)
      total = sums(:, i)
      associate (right => ways%odd(i), by => ways%way(:, i, way))
        ! Terms are even in number.
        do k = 1, size(sums, 2), 2
          total = total + (by(k) * panel(:, k, right) + by(k + 1) * panel(:, k + 1, right))
        end do
      end associate
      sums(:, i) = total
    end do
  end subroutine go

end module asperity_box_expansions
