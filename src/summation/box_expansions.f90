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
!> 12 products in place of 27 for one target box in a full plane. Entries of the matrices with high
!> degrees in both boxes are nearly zero and are left out.
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

  ! Least entry of a matrix that is kept, over its largest one (measured on 2000 and 20000 places:
  ! sums are in error by 6e-9 and 3e-9 in the root mean square, as without it; with 1e-7 by twice
  ! that).
  real(real64), parameter :: least_entry = 1.0e-8_real64

  !> Translations of expansions between boxes, matrices without entries that are nearly zero.
  type :: translations
    !> number of terms of an expansion, and of the first ones that are used in sums of low order
    integer :: terms = 0, low_order_terms = 0
    !> degrees in x and y of each term, ordered by the sum of their squares
    integer, allocatable :: degree_x(:), degree_y(:)
    !> (target term from 0, number of the translation): index of the last entry of a row, of all and
    !> of low order; for the quadrant 0 of the parent and for offsets of 0 or more
    integer, allocatable :: last(:, :), last_of_low_order(:, :)
    !> of each entry: 4 for each source term before its own, and the axes in which the parities of
    !> its source and target term differ: 1 if in x, plus 2 if in y
    integer, allocatable :: column(:)
    real(real64), allocatable :: entry(:)
  end type translations

contains

  !> Computes the terms and all translation matrices.
  subroutine prepare_translations(translation)
    type(translations), intent(out) :: translation  !! translations between boxes
    integer, parameter :: n = order + 1
    real(real64) :: t(0:order, 2, 0:2), node(n), matrix(n, n, n, n)
    real(real64), dimension(n, n) :: coefficients, parent_values, child_terms
    integer :: a, b, column, entries, i, row

    allocate (translation%degree_x(0), translation%degree_y(0))
    do i = 0, order**2
      do a = 0, order
        do b = 0, order
          if (a**2 + b**2 /= i) cycle
          translation%degree_x = [translation%degree_x, a]
          translation%degree_y = [translation%degree_y, b]
        end do
      end do
      if (i == low_order_square) translation%low_order_terms = size(translation%degree_x)
    end do
    translation%terms = size(translation%degree_x)
    allocate (translation%last(0:translation%terms, 0:15), source=0)
    allocate (translation%last_of_low_order(translation%terms, 0:15), source=0)
    i = 14 * translation%terms**2
    allocate (translation%column(i), translation%entry(i))
    entries = 0
    node = chebyshev_nodes(n)
    do i = 1, n
      t = chebyshev_values([node(i), 0.5_real64 * (node(i) - 1.0_real64)], order)
      ! The sum over the nodes of a function times these is its expansion.
      coefficients(:, i) = t(:, 1, 0) * [1, spread(2, 1, order)] / n
      parent_values(:, i) = t(:, 2, 0)
    end do
    child_terms = product_with_transpose(parent_values, coefficients)
    do i = 1, n
      do a = 1, n
        matrix(:, :, a, i) = spread(child_terms(:, a), 2, n) * spread(child_terms(:, i), 1, n)
      end do
    end do
    call add_matrix(translation, l2l, matrix, entries)
    call add_matrix(translation, m2m, reshape(matrix, shape(matrix), order=[3, 4, 1, 2]), entries)
    do column = 2, 3
      do row = 0, column
        do i = 1, n
          do a = 1, n
            do b = 1, n
              matrix(:, b, a, i) = 1.0_real64 / hypot(node - node(a) + 2 * column, &
                                                      node(b) - node(i) + 2 * row)
            end do
          end do
        end do
        ! From values at nodes to terms, axis by axis.
        do i = 1, 4
          matrix = reshape(product_with_transpose(coefficients, reshape(matrix, [n**3, n])), &
                           shape(matrix))
        end do
        call add_matrix(translation, 4 * row + column, matrix, entries)
        if (row < column) call add_matrix(translation, 4 * column + row, reshape( &
                                          matrix, shape(matrix), order=[2, 1, 4, 3]), entries)
      end do
    end do
    translation%column = translation%column(:entries)
    translation%entry = translation%entry(:entries)
  end subroutine prepare_translations

  ! Adds the entries of a matrix by the degrees of the source in x and in y, and of the target.
  pure subroutine add_matrix(translation, number, matrix, entries)
    type(translations), intent(inout) :: translation
    integer, intent(in) :: number
    real(real64), intent(in) :: matrix(0:, 0:, 0:, 0:)
    integer, intent(inout) :: entries   ! of all matrices so far
    real(real64) :: least
    integer :: i, k

    least = least_entry * maxval(abs(matrix))
    translation%last(0, number) = entries
    do i = 1, translation%terms
      do k = 1, translation%terms
        associate (x => translation%degree_x([k, i]), y => translation%degree_y([k, i]))
          if (abs(matrix(x(1), y(1), x(2), y(2))) > least) then
            entries = entries + 1
            translation%entry(entries) = matrix(x(1), y(1), x(2), y(2))
            translation%column(entries) = 4 * (k - 1) + mod(sum(x), 2) + 2 * mod(sum(y), 2)
          end if
        end associate
        if (k == translation%low_order_terms) translation%last_of_low_order(i, number) = entries
      end do
      translation%last(i, number) = entries
    end do
  end subroutine add_matrix

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
  ! first and their second derivatives, up to a degree of 1 or more; beyond it they are not set.
  pure function chebyshev_values(z, degree) result(t)
    real(real64), intent(in) :: z(2)
    integer, intent(in) :: degree   ! largest, up to `order`
    real(real64) :: t(0:order, 2, 0:2)
    integer :: l

    t(0, :, :) = 0.0_real64
    t(0, :, 0) = 1.0_real64
    t(1, :, 0) = z
    t(1, :, 1) = 1.0_real64
    t(1, :, 2) = 0.0_real64
    do l = 2, degree
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

    t = chebyshev_values(position, order)
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

    t = chebyshev_values(position, order)
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
    integer :: k, last

    last = merge(int(sqrt(real(low_order_square))), order, size(field) < translation%terms)
    t = chebyshev_values(position, last)
    in_y = 0.0_real64
    do k = 1, size(field)
      associate (a => translation%degree_x(k), b => translation%degree_y(k))
        in_y(a, :) = in_y(a, :) + field(k) * t(b, 2, :)
      end associate
    end do
    value(1) = value(1) + sum(in_y(:last, 0) * t(:last, 1, 0))
    value(3) = value(3) + sum(in_y(:last, 0) * t(:last, 1, 1)) / half_width
    value(4) = value(4) + sum(in_y(:last, 1) * t(:last, 1, 0)) / half_width
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
    ! Signed sums of the four boxes by the axes in which the parity of the target term differs.
    real(real64) :: combined(lanes, 0:4 * size(sums, 2) - 1), total(lanes)
    real(real64) :: part(size(sums, 2), 0:3), even(2), odd(2)
    integer :: i, k, l, lane, last, q

    do lane = 1, lanes
      if (.not. any(source_box(:, lane) > 0)) then
        combined(lane, :) = 0.0_real64
        cycle
      end if
      do q = 0, 3
        part(:, q) = 0.0_real64
        if (source_box(q, lane) > 0) part(:, q) = expansion(:size(part, 1), source_box(q, lane))
      end do
      do k = 1, size(part, 1)
        even = part(k, 0:2:2) + part(k, 1:3:2)
        odd = part(k, 0:2:2) - part(k, 1:3:2)
        combined(lane, 4 * k - 4) = even(1) + even(2)
        combined(lane, 4 * k - 3) = odd(1) + odd(2)
        combined(lane, 4 * k - 2) = even(1) - even(2)
        combined(lane, 4 * k - 1) = odd(1) - odd(2)
      end do
    end do
    do i = 1, size(sums, 2)
      total = sums(:, i)
      last = translation%last(i, matrix_number)
      if (size(sums, 2) < translation%terms) last = translation%last_of_low_order(i, matrix_number)
      do l = translation%last(i - 1, matrix_number) + 1, last
        associate (factor => translation%entry(l), k => translation%column(l))
          !$omp simd
          do lane = 1, lanes
            total(lane) = total(lane) + factor * combined(lane, k)
          end do
        end associate
      end do
      sums(:, i) = total
    end do
  end subroutine add_translated

end module asperity_box_expansions
