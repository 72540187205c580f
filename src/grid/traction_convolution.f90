!> Displacements of all elements of a lattice by tangential tractions on all elements: a discrete
!> convolution of two components by fast Fourier transforms, beside `lattice_convolution`.
!>
!> Tractions are over the combined modulus E, displacements over the side of an element along x, as
!> of the pressures there. One number is left of the two bodies, nu = m/g with g = 1/G1 + 1/G2 and
!> m = nu1/G1 + nu2/G2, as g - m = 2/E: a wave of number q has the compliance
!>
!>   A_ij = 2/(1 - nu) (delta_ij - nu q_i q_j/q**2)/q
!>
!> (Westergaard 1939; Johnson, Contact Mechanics, 1985, chapter 13), and its inverse is
!> (1 - nu) q/2 (delta_ij + nu/(1 - nu) q_i q_j/q**2). On free lattices and strips Cerruti's
!> integrals over elements replace the waves (`traction_influence`), and the inverse is that of the
!> waves of the padded lattice. Unlike bodies with Dundurs' beta have normal displacements by
!> tractions, -2 i beta q_i/q**2, and tangential ones of the opposite sign by pressures.
!>
!> The off-diagonal compliance of a periodic lattice is odd in both directions: it is 0 at the
!> shortest wave of an even number of elements, which has no sign. Mirrored lattices have mirrored
!> solutions then.
module asperity_traction_convolution
  use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_loc
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  use asperity_lattice_convolution, only: padded_length
  use asperity_line_transform, only: line_transform, real_to_waves, waves_back, waves_forward, &
                                     waves_to_real
  use asperity_traction_influence, only: integral_over_element, of_x, of_xx, of_xy, of_y, of_yy
  implicit none
  private

  public :: element_set, list_elements, traction_convolution
  public :: by_tractions, inverse_of_tractions, normal_by_tractions, tangential_by_pressures

  !> Numbers of the operations of `apply` (chosen): tangential displacements by tractions; tractions
  !> by the approximate inverse; of unlike bodies, normal displacements by tractions, and tangential
  !> displacements by pressures.
  integer, parameter :: by_tractions = 1, inverse_of_tractions = 2
  !> Numbers of the operations of unlike bodies (chosen).
  integer, parameter :: normal_by_tractions = 3, tangential_by_pressures = 4

  !> Elements of a lattice, row by row.
  type :: element_set
    integer, allocatable :: column(:)  !! of each element
    integer, allocatable :: first(:)   !! index of the first one of each row, and of one row more
  end type element_set

  !> The convolution for one lattice. It owns its plans: it must not be copied.
  type :: traction_convolution
    private
    real(real64), public :: diagonal = 0.0_real64  !! displacement of an element by its own traction
    integer :: columns = 0  ! number of columns of the padded lattice
    integer :: rows = 0     ! number of rows of the padded lattice
    ! (wave number in y, in x, term): spectra over the number of padded elements. A term is even or
    ! odd along each axis: half of the wave numbers are kept in each direction.
    real(c_double), allocatable :: spectrum(:, :, :)
    complex(c_double_complex), allocatable :: transform(:, :, :)  ! (wave in x, row, component)
    type(line_transform) :: row_forward, column_forward, column_back, row_back
  contains
    procedure :: prepare => prepare_tractions
    procedure :: apply => apply_tractions
    procedure :: apply_at => apply_at_elements
  end type traction_convolution

  ! Numbers of the terms: compliance, its inverse, coupling of normal and tangential parts (chosen).
  integer, parameter :: xx = 1, xy = 2, yy = 3, inverse_xx = 4, inverse_xy = 5, inverse_yy = 6, &
                        normal_x = 7, normal_y = 8
  ! Parity of each term along x and y; 1: odd (derived from the formulas).
  integer, parameter :: odd(2, 8) = &
    reshape([0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0, 0, 1], [2, 8])
  complex(c_double_complex), parameter :: i_unit = cmplx(0, 1, c_double_complex)
  ! Number of columns that are copied together, as they share lines of the cache (chosen).
  integer, parameter :: block_columns = 8
  ! Size of a transform above which threads share it (chosen, as in `lattice_convolution`).
  integer, parameter :: thread_threshold = 30000

contains

  !> Prepares the convolution.
  subroutine prepare_tractions(self, elements, side_ratio, repeats, poisson_ratio, beta)
    class(traction_convolution), intent(inout) :: self  !! convolution without plans
    integer, intent(in) :: elements(2)       !! numbers of columns and rows
    real(real64), intent(in) :: side_ratio   !! side of an element along y over that along x
    logical, intent(in) :: repeats(2)        !! whether the lattice is periodic along x and y
    real(real64), intent(in) :: poisson_ratio  !! m/g of both bodies, -1 to 0.5
    real(real64), intent(in) :: beta         !! Dundurs' beta; 0: no coupling
    real(real64) :: g, m, q(2), shortest
    integer :: i, j, padded(2), terms

    padded = merge(elements, padded_length(2 * elements - 1), repeats)
    self%columns = padded(1)
    self%rows = padded(2)
    terms = merge(normal_y, inverse_yy, abs(beta) > 0.0_real64)
    allocate (self%transform(0:padded(1) / 2, 0:elements(2) - 1, 2), &
              self%spectrum(0:padded(2) / 2, 0:padded(1) / 2, terms))
    call self%row_forward%prepare(real_to_waves, padded(1))
    call self%column_forward%prepare(waves_forward, padded(2))
    call self%column_back%prepare(waves_back, padded(2))
    call self%row_back%prepare(waves_to_real, padded(1))
    g = 2.0_real64 / (1.0_real64 - poisson_ratio)
    m = poisson_ratio * g
    do i = 0, padded(1) / 2
      do j = 0, padded(2) / 2
        q = 2.0_real64 * pi * [i / real(padded(1), real64), j / (padded(2) * side_ratio)]
        shortest = merge(0.0_real64, 1.0_real64, 2 * i == padded(1) .or. 2 * j == padded(2))
        call set_wave(self%spectrum(j, i, :), q, shortest, g, m, beta)
      end do
    end do
    associate (lowest => 2.0_real64 * pi / max(real(padded(1), real64), padded(2) * side_ratio))
      self%spectrum(0, 0, :) = 0.0_real64
      self%spectrum(0, 0, [inverse_xx, inverse_yy]) = lowest / g
    end associate
    if (.not. all(repeats)) then
      call set_elements(self, elements, side_ratio, findloc(repeats, .true., 1), g, m, beta)
    end if
    self%spectrum = self%spectrum / (real(self%columns, c_double) * self%rows)
    self%diagonal = 0.0_real64
    do i = 0, padded(1) / 2
      do j = 0, padded(2) / 2
        self%diagonal = self%diagonal + 0.5_real64 * sum(self%spectrum(j, i, [xx, yy])) * &
          merge(1, 2, i == 0 .or. 2 * i == padded(1)) * merge(1, 2, j == 0 .or. 2 * j == padded(2))
      end do
    end do
  end subroutine prepare_tractions

  ! Sets the terms of one wave, which is not the mean.
  pure subroutine set_wave(term, q, shortest, g, m, beta)
    real(c_double), intent(out) :: term(:)
    real(real64), intent(in) :: q(2)      ! wave number over the side
    real(real64), intent(in) :: shortest  ! factor of terms that are odd along an axis: 0 or 1
    real(real64), intent(in) :: g, m, beta
    real(real64) :: c(2), number

    number = max(hypot(q(1), q(2)), tiny(number))
    c = q / number
    term(xx) = (g - m * c(1)**2) / number
    term(xy) = -shortest * m * c(1) * c(2) / number
    term(yy) = (g - m * c(2)**2) / number
    associate (of_along => m / (g * (g - m)))
      term(inverse_xx) = number * (1.0_real64 / g + of_along * c(1)**2)
      term(inverse_xy) = shortest * number * of_along * c(1) * c(2)
      term(inverse_yy) = number * (1.0_real64 / g + of_along * c(2)**2)
    end associate
    if (size(term) > inverse_yy) term([normal_x, normal_y]) = -shortest * 2.0_real64 * beta * &
                                                              c / number
  end subroutine set_wave

  ! Replaces the compliance by that of elements, transformed from all offsets.
  subroutine set_elements(self, elements, side_ratio, strip_axis, g, m, beta)
    class(traction_convolution), intent(inout) :: self
    integer, intent(in) :: elements(2), strip_axis
    real(real64), intent(in) :: side_ratio, g, m, beta
    real(real64), allocatable, dimension(:, :) :: half_x, half_y

    allocate (half_x, source=integral_over_element(of_xx, elements, side_ratio, strip_axis))
    allocate (half_y, source=integral_over_element(of_yy, elements, side_ratio, strip_axis))
    call take_table(self, xx, ((g - m) * half_y + g * half_x) / (2.0_real64 * pi))
    call take_table(self, yy, ((g - m) * half_x + g * half_y) / (2.0_real64 * pi))
    half_x = integral_over_element(of_xy, elements, side_ratio, strip_axis)
    call take_table(self, xy, m / (2.0_real64 * pi) * half_x)
    if (size(self%spectrum, 3) == inverse_yy) return
    half_x = integral_over_element(of_x, elements, side_ratio, strip_axis)
    call take_table(self, normal_x, beta / pi * half_x)
    half_x = integral_over_element(of_y, elements, side_ratio, strip_axis)
    call take_table(self, normal_y, beta / pi * half_x)
  end subroutine set_elements

  ! Transforms a table by offset, with its parity. A term that is odd along one axis has an
  ! imaginary transform, of which the factor of i is kept.
  subroutine take_table(self, term, table)
    class(traction_convolution), intent(inout) :: self
    integer, intent(in) :: term
    real(real64), intent(in) :: table(0:, 0:)
    real(c_double), allocatable, target :: row(:)
    complex(c_double_complex), allocatable, target :: column(:), other(:), waves(:, :)
    integer :: i, j, n(2)
    real(real64) :: sign_of(2)

    n = shape(table)
    sign_of = 1.0_real64 - 2.0_real64 * odd(:, term)
    allocate (row(0:self%columns - 1), column(0:self%rows - 1), other(0:self%rows - 1), &
              waves(0:self%columns / 2, 0:n(2) - 1))
    row = 0.0_c_double
    do j = 0, n(2) - 1
      row(:n(1) - 1) = table(:, j)
      if (self%columns > n(1)) row(self%columns - n(1) + 1:) = sign_of(1) * table(n(1) - 1:1:-1, j)
      call self%row_forward%apply(c_loc(row), c_loc(waves(0, j)))
    end do
    do i = 0, self%columns / 2
      column = (0.0_c_double, 0.0_c_double)
      column(:n(2) - 1) = waves(i, :)
      if (self%rows > n(2)) column(self%rows - n(2) + 1:) = sign_of(2) * column(n(2) - 1:1:-1)
      call self%column_forward%apply(c_loc(column), c_loc(other))
      if (sum(odd(:, term)) == 1) then
        self%spectrum(:, i, term) = aimag(other(:self%rows / 2))
      else
        self%spectrum(:, i, term) = real(other(:self%rows / 2), c_double)
      end if
    end do
  end subroutine take_table

  !> Convolves fields on the lattice of the preparation. Two components are those along x and y;
  !> pressures and normal displacements have one.
  subroutine apply_tractions(self, from, to, operation)
    class(traction_convolution), intent(inout), target :: self  !! convolution with its plans
    real(real64), intent(in) :: from(:, :, :)   !! (column, row, component)
    real(real64), intent(out) :: to(:, :, :)    !! (column, row, component)
    integer, intent(in) :: operation            !! what is computed
    real(c_double), allocatable, target :: row(:)
    integer :: c, j

    !$omp parallel private(row, c) if(size(self%transform) > thread_threshold)
    allocate (row(self%columns))
    do c = 1, size(from, 3)
      !$omp do schedule(static)
      do j = 1, size(from, 2)
        row(:size(from, 1)) = from(:, j, c)
        row(size(from, 1) + 1:) = 0.0_c_double
        call self%row_forward%apply(c_loc(row), c_loc(self%transform(0, j - 1, c)))
      end do
      !$omp end do
    end do
    !$omp end parallel
    call convolve_columns(self, size(from, 3), size(to, 3), operation)
    !$omp parallel private(row, c) if(size(self%transform) > thread_threshold)
    allocate (row(self%columns))
    do c = 1, size(to, 3)
      !$omp do schedule(static)
      do j = 1, size(to, 2)
        call self%row_back%apply(c_loc(self%transform(0, j - 1, c)), c_loc(row))
        to(:, j, c) = row(:size(to, 1))
      end do
      !$omp end do
    end do
    !$omp end parallel
  end subroutine apply_tractions

  !> The same for values on some elements, 0 on the others: rows without one are not transformed.
  subroutine apply_at_elements(self, set, from, to, operation)
    class(traction_convolution), intent(inout), target :: self  !! convolution with its plans
    type(element_set), intent(in) :: set        !! elements of the lattice
    real(real64), intent(in) :: from(:, :)      !! (element, component along x and y)
    real(real64), intent(out) :: to(:, :)       !! (element, component along x and y)
    integer, intent(in) :: operation            !! tractions or their inverse
    real(c_double), allocatable, target :: row(:)
    integer :: c, j, rows

    rows = size(set%first) - 1
    !$omp parallel private(row, c) if(size(self%transform) > thread_threshold)
    allocate (row(self%columns))
    do c = 1, 2
      !$omp do schedule(static)
      do j = 1, rows
        associate (first => set%first(j), last => set%first(j + 1) - 1)
          if (last < first) then
            self%transform(:, j - 1, c) = (0.0_c_double, 0.0_c_double)
          else
            row = 0.0_c_double
            row(set%column(first:last)) = from(first:last, c)
            call self%row_forward%apply(c_loc(row), c_loc(self%transform(0, j - 1, c)))
          end if
        end associate
      end do
      !$omp end do
    end do
    !$omp end parallel
    call convolve_columns(self, 2, 2, operation)
    !$omp parallel private(row, c) if(size(self%transform) > thread_threshold)
    allocate (row(self%columns))
    do c = 1, 2
      !$omp do schedule(static)
      do j = 1, rows
        associate (first => set%first(j), last => set%first(j + 1) - 1)
          if (last >= first) then
            call self%row_back%apply(c_loc(self%transform(0, j - 1, c)), c_loc(row))
            to(first:last, c) = row(set%column(first:last))
          end if
        end associate
      end do
      !$omp end do
    end do
    !$omp end parallel
  end subroutine apply_at_elements

  !> Lists the marked elements of a lattice.
  pure subroutine list_elements(marks, set)
    logical, intent(in) :: marks(:, :)       !! (column, row) of the lattice
    type(element_set), intent(out) :: set    !! the marked elements
    integer :: i, j, number

    allocate (set%column(count(marks)), set%first(size(marks, 2) + 1))
    number = 0
    do j = 1, size(marks, 2)
      set%first(j) = number + 1
      do i = 1, size(marks, 1)
        if (.not. marks(i, j)) cycle
        number = number + 1
        set%column(number) = i
      end do
    end do
    set%first(size(set%first)) = number + 1
  end subroutine list_elements

  ! Transforms the rows' waves along the columns, multiplies, and transforms them back. The bytes of
  ! the result do not depend on the number of threads: each column belongs to one of them.
  subroutine convolve_columns(self, components_from, components_to, operation)
    class(traction_convolution), intent(inout), target :: self
    integer, intent(in) :: components_from, components_to, operation
    complex(c_double_complex), allocatable, target :: column(:, :, :), waves(:, :), images(:, :)
    integer :: c, i, k, last, n

    n = size(self%transform, 2)
    !$omp parallel private(column, waves, images, c, k, last) &
    !$omp if(size(self%transform) > thread_threshold)
    allocate (column(0:self%rows - 1, 0:block_columns - 1, 2))
    allocate (waves(0:self%rows - 1, 2), images(0:self%rows - 1, 2))
    !$omp do schedule(static)
    do i = 0, self%columns / 2, block_columns
      last = min(block_columns - 1, self%columns / 2 - i)
      do c = 1, components_from
        column(:n - 1, :last, c) = transpose(self%transform(i:i + last, :, c))
      end do
      do k = 0, last
        do c = 1, components_from
          column(n:, k, c) = (0.0_c_double, 0.0_c_double)
          call self%column_forward%apply(c_loc(column(0, k, c)), c_loc(waves(0, c)))
        end do
        call multiply_waves(self, i + k, operation, waves, images)
        do c = 1, components_to
          call self%column_back%apply(c_loc(images(0, c)), c_loc(column(0, k, c)))
        end do
      end do
      do c = 1, components_to
        self%transform(i:i + last, :, c) = transpose(column(:n - 1, :last, c))
      end do
    end do
    !$omp end do
    !$omp end parallel
  end subroutine convolve_columns

  ! Multiplies the waves of one column: the upper half mirrors the lower one.
  pure subroutine multiply_waves(self, i, operation, waves, images)
    class(traction_convolution), intent(in) :: self
    integer, intent(in) :: i, operation
    complex(c_double_complex), intent(in) :: waves(0:, :)
    complex(c_double_complex), intent(out) :: images(0:, :)
    integer :: j, k, first

    first = merge(xx, inverse_xx, operation == by_tractions)
    select case (operation)
    case (normal_by_tractions)
      do j = 0, self%rows - 1
        k = min(j, self%rows - j)
        images(j, 1) = i_unit * (self%spectrum(k, i, normal_x) * waves(j, 1) + &
                                 sign(1, k - j) * self%spectrum(k, i, normal_y) * waves(j, 2))
      end do
    case (tangential_by_pressures)
      do j = 0, self%rows - 1
        k = min(j, self%rows - j)
        images(j, 1) = -i_unit * self%spectrum(k, i, normal_x) * waves(j, 1)
        images(j, 2) = -i_unit * sign(1, k - j) * self%spectrum(k, i, normal_y) * waves(j, 1)
      end do
    case default
      do j = 0, self%rows - 1
        k = min(j, self%rows - j)
        associate (cross => sign(1, k - j) * self%spectrum(k, i, first + 1))
          images(j, 1) = self%spectrum(k, i, first) * waves(j, 1) + cross * waves(j, 2)
          images(j, 2) = cross * waves(j, 1) + self%spectrum(k, i, first + 2) * waves(j, 2)
        end associate
      end do
    end select
  end subroutine multiply_waves

end module asperity_traction_convolution
