!> Expansions of the far field of 1/r in square boxes, and their translations between boxes.
!>
!> In coordinates over the half width of a box the kernel between two boxes is a double sum over
!> T_a(x) T_b(y), Chebyshev polynomials with a**2 + b**2 <= order**2: a Euclidean degree resolves
!> all directions equally (Trefethen, Proc. AMS 145, 1837, 2017). Method: the interpolating fast
!> multipole method of Fong and Darve (J. Comput. Phys. 228, 8712, 2009). Moments of sources are
!> translated to the parent box (M2M), to fields in boxes of the same level (M2L) and from there to
!> the children (L2L), as Greengard and Rokhlin name it (J. Comput. Phys. 73, 325, 1987).
!>
!> The translation from a mirrored offset differs by the signs of the odd terms only. Source boxes
!> at mirrored offsets are therefore combined by parity first and share one product with the matrix:
!> 12 products in place of 27 for one target box in a full plane.
module asperity_box_expansions
  use asperity_chebyshev_basis, only: chebyshev_nodes
  use asperity_kinds, only: real64
  implicit none
  private

  public :: translations, prepare_translations, add_dipole, add_moments, add_field, add_translated

  !> Largest Euclidean degree. Measured at order 8: 1.3e-5 is the largest relative error of one
  !> source, 1.5e-8 to 9e-8 that of sums over 1e4 to 1e6 places, uniform and in clusters (test:
  !> test/unit/summation_suite.f90). Each order less increases them by a factor of 3 to 6.
  integer, parameter :: order = 8
  ! Largest a**2 + b**2 in sums of low order (chosen).
  integer, parameter :: low_order_square = 18
  !> Number of target boxes that are translated to side by side, in vector registers.
  integer, parameter, public :: lanes = 16
  !> Numbers of the translations from children to their parent and back. The translation to fields
  !> over an offset of columns and rows, 0 to 3, at least one of both above 1, is 4 rows + columns.
  integer, parameter, public :: m2m = 0, l2l = 1

  !> Translations of expansions between boxes.
  type :: translations
    !> number of terms of an expansion, and of the first ones that are used in sums of low order
    integer :: terms = 0, low_order_terms = 0
    !> degrees in x and y of each term, ordered by the sum of their squares
    integer, allocatable :: degree_x(:), degree_y(:)
    !> axes in which each term is odd: 1 if in x, plus 2 if in y
    integer, allocatable :: odd_axes(:)
    !> (source term, target term, number of the translation), for the quadrant 0 of the parent and
    !> for offsets of 0 or more
    real(real64), allocatable :: matrix(:, :, :)
  end type translations

contains

  !> Computes the terms and all translation matrices.
  subroutine prepare_translations(translation)
    type(translations), intent(out) :: translation  !! translations between boxes
    integer, parameter :: n = (order + 1)**2
    real(real64) :: node(2, n), t(0:order, 2, 0:2), kernel(n, n)
    real(real64), allocatable :: coefficients(:, :), parent_values(:, :)
    integer :: term(0:order, 0:order), a, b, column, i, row

    translation%degree_x = [integer ::]
    translation%degree_y = [integer ::]
    do i = 0, order**2
      do a = 0, order
        do b = 0, order
          if (a**2 + b**2 /= i) cycle
          translation%degree_x = [translation%degree_x, a]
          translation%degree_y = [translation%degree_y, b]
          term(a, b) = size(translation%degree_x)
        end do
      end do
      if (i == low_order_square) translation%low_order_terms = size(translation%degree_x)
    end do
    translation%terms = size(translation%degree_x)
    translation%odd_axes = mod(translation%degree_x, 2) + 2 * mod(translation%degree_y, 2)
    allocate (translation%matrix(translation%terms, translation%terms, 0:15), source=0.0_real64)
    allocate (coefficients(translation%terms, n), parent_values(translation%terms, n))
    node(1, :) = [(chebyshev_nodes(order + 1), i=0, order)]
    node(2, :) = reshape(transpose(reshape(node(1, :), [order + 1, order + 1])), [n])
    ! The sum over the nodes of a function times `coefficients` is its expansion.
    do i = 1, n
      t = chebyshev_values(0.5_real64 * (node(:, i) - 1.0_real64))
      parent_values(:, i) = t(translation%degree_x, 1, 0) * t(translation%degree_y, 2, 0)
      t = chebyshev_values(node(:, i)) * 2.0_real64
      t(0, :, 0) = 1.0_real64
      coefficients(:, i) = t(translation%degree_x, 1, 0) * t(translation%degree_y, 2, 0) / n
    end do
    translation%matrix(:, :, l2l) = product_with_transpose(parent_values, coefficients)
    translation%matrix(:, :, m2m) = transpose(translation%matrix(:, :, l2l))
    !$omp parallel do private(kernel, i, row)
    do column = 2, 3
      do row = 0, column
        do i = 1, n
          kernel(:, i) = 1.0_real64 / hypot(node(1, :) - node(1, i) - 2 * column, &
                                            node(2, :) - node(2, i) - 2 * row)
        end do
        associate (m2l => translation%matrix(:, :, 4 * row + column), &
                   exchanged => [(term(translation%degree_y(i), translation%degree_x(i)), &
                                  i=1, translation%terms)])
          m2l = product_with_transpose(product_with_transpose(coefficients, kernel), coefficients)
          translation%matrix(:, :, 4 * column + row) = m2l(exchanged, exchanged)
        end associate
      end do
    end do
    !$omp end parallel do
  end subroutine prepare_translations

  ! Product of a matrix and the transpose of another one. The order of the additions is fixed, which
  ! makes the result independent of the library and of the processor.
  pure function product_with_transpose(left, right) result(matrix)
    real(real64), intent(in) :: left(:, :), right(:, :)
    real(real64) :: matrix(size(left, 1), size(right, 1))
    integer :: i, k

    do i = 1, size(matrix, 2)
      matrix(:, i) = 0.0_real64
      do k = 1, size(left, 2)
        matrix(:, i) = matrix(:, i) + left(:, k) * right(i, k)
      end do
    end do
  end function product_with_transpose

  ! Chebyshev polynomials of both coordinates (degree, coordinate, derivative): the values, their
  ! first and their second derivatives.
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

  !> Adds the moments of a source of 1/r and of its Laplacian to those of a box (P2M).
  pure subroutine add_moments(translation, position, charge, laplacian_charge, moment)
    type(translations), intent(in) :: translation  !! degrees of the terms
    real(real64), intent(in) :: position(2)        !! position from the centre, over the half width
    real(real64), intent(in) :: charge             !! factor of 1/r
    !> factor of the Laplacian of 1/r over the charge, in squares of the half width
    real(real64), intent(in) :: laplacian_charge
    real(real64), intent(inout) :: moment(:)       !! moments of the box, the first terms
    real(real64) :: t(0:order, 2, 0:2)
    integer :: k

    t = chebyshev_values(position)
    t(:, 2, :) = charge * t(:, 2, :)
    t(:, 2, 2) = t(:, 2, 0) + laplacian_charge * t(:, 2, 2)
    t(:, 2, 0) = laplacian_charge * t(:, 2, 0)
    do k = 1, size(moment)
      associate (a => translation%degree_x(k), b => translation%degree_y(k))
        moment(k) = moment(k) + (t(b, 2, 2) * t(a, 1, 0) + t(b, 2, 0) * t(a, 1, 2))
      end associate
    end do
  end subroutine add_moments

  !> Adds the moments of a dipole to those of a box (P2M).
  pure subroutine add_dipole(translation, position, dipole, moment)
    type(translations), intent(in) :: translation  !! degrees of the terms
    real(real64), intent(in) :: position(2)        !! position from the centre, over the half width
    real(real64), intent(in) :: dipole(2)          !! components over the half width
    real(real64), intent(inout) :: moment(:)       !! moments of the box, the first terms
    real(real64) :: t(0:order, 2, 0:2)
    integer :: k

    t = chebyshev_values(position)
    do k = 1, size(moment)
      associate (a => translation%degree_x(k), b => translation%degree_y(k))
        moment(k) = moment(k) + (dipole(1) * t(a, 1, 1) * t(b, 2, 0) + &
                                 dipole(2) * t(a, 1, 0) * t(b, 2, 1))
      end associate
    end do
  end subroutine add_dipole

  !> Adds the field of a box at a place in it to the values there (L2P).
  pure subroutine add_field(translation, position, half_width, field, value)
    type(translations), intent(in) :: translation  !! degrees of the terms
    real(real64), intent(in) :: position(2)        !! position from the centre, over the half width
    real(real64), intent(in) :: half_width         !! half of the width of the box
    real(real64), intent(in) :: field(:)           !! field of the box, the first terms
    real(real64), intent(inout) :: value(6)        !! values as `sum_sources` returns them
    real(real64) :: t(0:order, 2, 0:2), in_y(0:order, 0:2), xx, yy
    integer :: k

    t = chebyshev_values(position)
    in_y = 0.0_real64
    do k = 1, size(field)
      associate (a => translation%degree_x(k), b => translation%degree_y(k))
        in_y(a, :) = in_y(a, :) + field(k) * t(b, 2, :)
      end associate
    end do
    value(1) = value(1) + sum(in_y(:, 0) * t(:, 1, 0))
    value(3) = value(3) + sum(in_y(:, 0) * t(:, 1, 1)) / half_width
    value(4) = value(4) + sum(in_y(:, 1) * t(:, 1, 0)) / half_width
    if (size(field) < translation%terms) return
    xx = sum(in_y(:, 0) * t(:, 1, 2))
    yy = sum(in_y(:, 2) * t(:, 1, 0))
    value(2) = value(2) + (xx + yy) / half_width**2
    value(5:) = value(5:) + [0.5_real64 * (xx - yy), sum(in_y(:, 1) * t(:, 1, 1))] / half_width**2
  end subroutine add_field

  !> Translates expansions and adds them to those of several target boxes, one a lane.
  pure subroutine add_translated(translation, matrix_number, expansion, source_box, sums)
    type(translations), intent(in) :: translation  !! matrices of all translations
    integer, intent(in) :: matrix_number           !! `m2m`, `l2l` or 4 rows + columns
    real(real64), contiguous, intent(in) :: expansion(:, :)  !! expansions by term and source box
    !> source boxes of each lane: at the offset of the matrix, and at that offset mirrored in x, in
    !> y and in both; 0: none
    integer, intent(in) :: source_box(0:3, lanes)
    real(real64), contiguous, intent(inout) :: sums(:, :)    !! target expansions by lane and term
    real(real64) :: combined(lanes, size(sums, 2), 0:3), part(size(sums, 2), 0:3), total(lanes)
    real(real64) :: even_x(2), odd_x(2)
    integer :: i, k, lane, q

    do lane = 1, lanes
      do q = 0, 3
        part(:, q) = 0.0_real64
        if (source_box(q, lane) > 0) part(:, q) = expansion(:size(part, 1), source_box(q, lane))
      end do
      ! Signed sums of the four boxes by the parity of the target term.
      do k = 1, size(part, 1)
        even_x = part(k, 0:2:2) + part(k, 1:3:2)
        odd_x = part(k, 0:2:2) - part(k, 1:3:2)
        combined(lane, k, translation%odd_axes(k)) = even_x(1) + even_x(2)
        combined(lane, k, ieor(1, translation%odd_axes(k))) = odd_x(1) + odd_x(2)
        combined(lane, k, ieor(2, translation%odd_axes(k))) = even_x(1) - even_x(2)
        combined(lane, k, ieor(3, translation%odd_axes(k))) = odd_x(1) - odd_x(2)
      end do
    end do
    do i = 1, size(sums, 2)
      total = sums(:, i)
      associate (odd_axes => translation%odd_axes(i), &
                 factor => translation%matrix(:, i, matrix_number))
        ! The number of terms is even.
        do k = 1, size(sums, 2), 2
          total = total + (factor(k) * combined(:, k, odd_axes) + &
                           factor(k + 1) * combined(:, k + 1, odd_axes))
        end do
      end associate
      sums(:, i) = total
    end do
  end subroutine add_translated

end module asperity_box_expansions
