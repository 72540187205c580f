!> Sources of 1/r in a box as moments of Chebyshev polynomials, and fields as sums of them.
!>
!> In boxes of half width 1 about 0 the kernel is a double sum of T_a(x) T_b(y) with
!> a**2 + b**2 <= order**2: a degree in the sense of Euclid is as good in all directions
!> (Trefethen, Proc. AMS 145, 1837, 2017). Interpolation between boxes is that of Fong and Darve
!> (J. Comput. Phys. 228, 8712, 2009).
!>
!> A way from a box to another whose place is mirrored is the same but for the signs of what is
!> odd. So boxes that are images of each other are added and subtracted first, and go their way
!> together: 12 ways in place of 27 for the boxes that act on one in a full plane. One by one a sum
!> over 1e5 circles takes 1.5 times as long, a rough one 1.15 times (measured).
module asperity_box_expansions
  use asperity_chebyshev_basis, only: chebyshev_nodes
  use asperity_kinds, only: real64
  implicit none
  private

  public :: translations, prepare_translations, add_dipole, add_moments, add_field, add_translated

  !> Greatest degree. Measured, the largest error of what one source does, and of sums over 1e4 to
  !> 1e6 places by their mean, all over a square and in clusters: order 6: 2e-4, 5e-7, 2e-6;
  !> 7: 4e-5, 9e-8, 4e-7; 8: 1.3e-5, 1.5e-8, 9e-8, at a tenth more time than 7.
  integer, parameter :: order = 8
  ! Rough sums: the most of a**2 + b**2.
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
  subroutine prepare_translations(ways)
    type(translations), intent(out) :: ways  !! translations between boxes
    integer, parameter :: n = (order + 1)**2
    real(real64) :: node(2, n), t(0:order, 2, 0:2), kernel(n, n)
    real(real64), allocatable :: basis(:, :), half(:, :)
    integer :: number(0:order, 0:order), a, b, column, i, row

    ways%in_x = [integer ::]
    ways%in_y = [integer ::]
    do i = 0, order**2
      do a = 0, order
        do b = 0, order
          if (a**2 + b**2 /= i) cycle
          ways%in_x = [ways%in_x, a]
          ways%in_y = [ways%in_y, b]
          number(a, b) = size(ways%in_x)
        end do
      end do
      if (i == rough_square) ways%rough_terms = size(ways%in_x)
    end do
    ways%terms = size(ways%in_x)
    ways%odd = mod(ways%in_x, 2) + 2 * mod(ways%in_y, 2)
    allocate (ways%way(ways%terms, ways%terms, 0:15), source=0.0_real64)
    allocate (basis(ways%terms, n), half(ways%terms, n))
    node(1, :) = [(chebyshev_nodes(order + 1), i=0, order)]
    node(2, :) = reshape(transpose(reshape(node(1, :), [order + 1, order + 1])), [n])
    ! A sum over the nodes of a function times `basis` is its coefficient.
    do i = 1, n
      t = chebyshev_values(0.5_real64 * (node(:, i) - 1.0_real64))
      half(:, i) = t(ways%in_x, 1, 0) * t(ways%in_y, 2, 0)
      t = chebyshev_values(node(:, i)) * 2.0_real64
      t(0, :, 0) = 1.0_real64
      basis(:, i) = t(ways%in_x, 1, 0) * t(ways%in_y, 2, 0) / n
    end do
    ways%way(:, :, down) = product_of(half, basis)
    ways%way(:, :, up) = transpose(ways%way(:, :, down))
    !$omp parallel do private(kernel, i, row)
    do column = 2, 3
      do row = 0, column
        do i = 1, n
          kernel(:, i) = 1.0_real64 / hypot(node(1, :) - node(1, i) - 2 * column, &
                                            node(2, :) - node(2, i) - 2 * row)
        end do
        associate (way => ways%way(:, :, 4 * row + column), &
                   swap => [(number(ways%in_y(i), ways%in_x(i)), i=1, ways%terms)])
          way = product_of(product_of(basis, kernel), basis)
          ways%way(:, :, 4 * column + row) = way(swap, swap)
        end associate
      end do
    end do
    !$omp end parallel do
  end subroutine prepare_translations

  ! One matrix times the other, transposed, in an order that neither library nor processor decides.
  pure function product_of(one, other) result(image)
    real(real64), intent(in) :: one(:, :), other(:, :)
    real(real64) :: image(size(one, 1), size(other, 1))
    integer :: i, k

    do i = 1, size(image, 2)
      image(:, i) = 0.0_real64
      do k = 1, size(one, 2)
        image(:, i) = image(:, i) + one(:, k) * other(i, k)
      end do
    end do
  end function product_of

  ! Chebyshev's polynomials of two numbers, their slopes and second derivatives.
  pure function chebyshev_values(z) result(t)
    real(real64), intent(in) :: z(2)
    real(real64) :: t(0:order, 2, 0:2)
    integer :: l

    t(0, :, :) = 0.0_real64
    t(0, :, 0) = 1.0_real64
    t(1, :, 0) = z
    t(1, :, 1) = 1.0_real64
    t(1, :, 2) = 0.0_real64
    do l = 2, order
      t(l, :, 0) = 2 * z * t(l - 1, :, 0) - t(l - 2, :, 0)
      t(l, :, 1) = 2 * (t(l - 1, :, 0) + z * t(l - 1, :, 1)) - t(l - 2, :, 1)
      t(l, :, 2) = 4 * t(l - 1, :, 1) + 2 * z * t(l - 1, :, 2) - t(l - 2, :, 2)
    end do
  end function chebyshev_values

  !> Adds the moments of a source and of its Laplacian.
  pure subroutine add_moments(ways, place, charge, spreading, moment)
    type(translations), intent(in) :: ways    !! degrees of the terms
    real(real64), intent(in) :: place(2)      !! from the middle of the box, over its half
    real(real64), intent(in) :: charge        !! of 1/r
    real(real64), intent(in) :: spreading        !! over the half squared
    real(real64), intent(inout) :: moment(:)  !! of the box, as many as the sums take
    real(real64) :: t(0:order, 2, 0:2)
    integer :: k

    t = chebyshev_values(place)
    t(:, 2, :) = charge * t(:, 2, :)
    t(:, 2, 2) = t(:, 2, 0) + spreading * t(:, 2, 2)
    t(:, 2, 0) = spreading * t(:, 2, 0)
    do k = 1, size(moment)
      associate (a => ways%in_x(k), b => ways%in_y(k))
        moment(k) = moment(k) + (t(b, 2, 2) * t(a, 1, 0) + t(b, 2, 0) * t(a, 1, 2))
      end associate
    end do
  end subroutine add_moments

  !> Adds the moments of a dipole.
  pure subroutine add_dipole(ways, place, dipole, moment)
    type(translations), intent(in) :: ways    !! degrees of the terms
    real(real64), intent(in) :: place(2)      !! from the middle of the box, over its half
    real(real64), intent(in) :: dipole(2)     !! over the half
    real(real64), intent(inout) :: moment(:)  !! of the box, as many as the sums take
    real(real64) :: t(0:order, 2, 0:2)
    integer :: k

    t = chebyshev_values(place)
    do k = 1, size(moment)
      associate (a => ways%in_x(k), b => ways%in_y(k))
        moment(k) = moment(k) + (dipole(1) * t(a, 1, 1) * t(b, 2, 0) + &
                                 dipole(2) * t(a, 1, 0) * t(b, 2, 1))
      end associate
    end do
  end subroutine add_dipole

  !> Adds the field of a box at a place.
  pure subroutine add_field(ways, place, half, field, with_slopes, value)
    type(translations), intent(in) :: ways    !! degrees of the terms
    real(real64), intent(in) :: place(2)      !! from the middle of the box, over its half
    real(real64), intent(in) :: half          !! half of the box's width
    real(real64), intent(in) :: field(:)      !! of the box, as many as the sums take
    logical, intent(in) :: with_slopes        !! of a rough sum, too
    real(real64), intent(inout) :: value(6)   !! as `sum_sources` returns it
    real(real64) :: t(0:order, 2, 0:2), along_y(0:order, 0:2), xx, yy
    integer :: k

    t = chebyshev_values(place)
    along_y = 0.0_real64
    do k = 1, size(field)
      associate (a => ways%in_x(k), b => ways%in_y(k))
        along_y(a, :) = along_y(a, :) + field(k) * t(b, 2, :)
      end associate
    end do
    value(1) = value(1) + sum(along_y(:, 0) * t(:, 1, 0))
    if (size(field) < ways%terms .and. .not. with_slopes) return
    value(3) = value(3) + sum(along_y(:, 0) * t(:, 1, 1)) / half
    value(4) = value(4) + sum(along_y(:, 1) * t(:, 1, 0)) / half
    if (size(field) < ways%terms) return
    xx = sum(along_y(:, 0) * t(:, 1, 2))
    yy = sum(along_y(:, 2) * t(:, 1, 0))
    value(2) = value(2) + (xx + yy) / half**2
    value(5:) = value(5:) + [0.5_real64 * (xx - yy), sum(along_y(:, 1) * t(:, 1, 1))] / half**2
  end subroutine add_field

  !> Adds what goes a way from boxes.
  pure subroutine add_translated(ways, way, from, box, sums)
    type(translations), intent(in) :: ways             !! translations of all ways
    integer, intent(in) :: way                         !! number of the way
    real(real64), contiguous, intent(in) :: from(:, :)  !! moments of boxes
    !> for each lane the box that it comes from, mirrored in x, in y, in both; or 0
    integer, intent(in) :: box(0:3, lanes)
    real(real64), contiguous, intent(inout) :: sums(:, :)  !! by lane and term, as many as count
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
  end subroutine add_translated

end module asperity_box_expansions
