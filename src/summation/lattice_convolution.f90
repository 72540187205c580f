!> Displacements of all elements of a rectangular lattice by forces on all elements: a discrete
!> convolution by fast Fourier transforms with FFTW 3 (Frigo and Johnson, Proc. IEEE 93, 2005).
!>
!> The influence of a force depends only on the offset of two elements. On a lattice that is padded
!> with zeros to twice its size the periodic images have no effect: the sum is exact to rounding. On
!> a periodic lattice the influence is given by its transform. Rows are transformed one by one,
!> without those of the padding; each column is transformed, multiplied and transformed back by one
!> thread: the bytes of the result do not depend on the number of threads.
module asperity_lattice_convolution
  use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_loc
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  use asperity_line_transform, only: line_transform, real_to_waves, waves_back, waves_forward, &
                                     waves_to_real
  implicit none
  private

  public :: lattice_convolution, padded_length

  !> The convolution for one lattice. It owns its plans: it must not be copied.
  type :: lattice_convolution
    private
    real(real64), public :: norm = 0.0_real64  !! upper bound of the eigenvalues of the matrix
    integer :: columns = 0  ! number of columns of the padded lattice
    integer :: rows = 0     ! number of rows of the padded lattice
    ! (wave number in y, wave number in x, operator): spectrum of the influence and of its
    ! approximate inverse over the number of padded elements. Half of the wave numbers are kept in
    ! each direction: the influence is the same at mirrored offsets.
    real(c_double), allocatable :: spectrum(:, :, :)
    complex(c_double_complex), allocatable :: transform(:, :)  ! (wave number in x, row)
    type(line_transform) :: row_forward, column_forward, column_back, row_back
  contains
    procedure :: prepare => prepare_plane
    procedure :: prepare_periodic
    procedure :: apply => apply_influence
  end type lattice_convolution

  ! Indices of the operators in the spectrum.
  integer, parameter :: of_influence = 1, of_inverse = 2

  ! Number of columns that are copied together, as they share lines of the cache (chosen).
  integer, parameter :: block_columns = 8
  ! Size of a transform above which threads share it (chosen).
  integer, parameter :: thread_threshold = 30000

contains

  !> Prepares the convolution with an influence that is the same at mirrored offsets.
  subroutine prepare_plane(self, influence, side_ratio, strip_axis)
    class(lattice_convolution), intent(inout), target :: self  !! convolution without plans
    !> (columns, rows): displacement at an offset by a unit force; of the size of the lattice
    real(real64), intent(in) :: influence(0:, 0:)
    real(real64), intent(in) :: side_ratio  !! side of an element along y over that along x
    !> axis along which the lattice is periodic, with the influence of a whole period; absent: none
    integer, intent(in), optional :: strip_axis
    real(c_double), allocatable, target :: row(:)
    complex(c_double_complex), allocatable, target :: column(:), other(:)
    integer :: i, j, n(2), padded(2)

    n = shape(influence)
    padded = padded_length(2 * n - 1)
    if (present(strip_axis)) padded(strip_axis) = n(strip_axis)
    call make_plans(self, padded(1), padded(2), n(2), side_ratio)
    allocate (row(0:self%columns - 1), column(0:self%rows - 1), other(0:self%rows - 1))
    row = 0.0_c_double
    do j = 0, ubound(influence, 2)
      row(:n(1) - 1) = influence(:, j)
      if (padded(1) > n(1)) row(padded(1) - n(1) + 1:) = influence(n(1) - 1:1:-1, j)
      call self%row_forward%apply(c_loc(row), c_loc(self%transform(0, j)))
    end do
    do i = 0, ubound(self%transform, 1)
      column = (0.0_c_double, 0.0_c_double)
      column(:n(2) - 1) = real(self%transform(i, :), c_double)
      if (padded(2) > n(2)) column(padded(2) - n(2) + 1:) = column(n(2) - 1:1:-1)
      call self%column_forward%apply(c_loc(column), c_loc(other))
      self%spectrum(:, i, of_influence) = real(other(:self%rows / 2), c_double)
    end do
    call scale_spectrum(self)
  end subroutine prepare_plane

  !> Prepares the convolution for displacements times the modulus by pressures on a periodic
  !> half-space: 2/q for a wave of number q (Johnson, Contact Mechanics, 1985, section 13.2), 0 for
  !> the mean pressure.
  subroutine prepare_periodic(self, columns, rows, side_ratio)
    class(lattice_convolution), intent(inout), target :: self  !! convolution without plans
    integer, intent(in) :: columns, rows     !! numbers of columns and rows
    real(real64), intent(in) :: side_ratio   !! side of an element along y over that along x

    call make_plans(self, columns, rows, rows, side_ratio)
    self%spectrum(:, :, of_influence) = 1.0_real64 / self%spectrum(:, :, of_inverse)
    self%spectrum(0, 0, of_influence) = 0.0_real64
    call scale_spectrum(self)
  end subroutine prepare_periodic

  ! Sets the norm, and divides both spectra by the number of padded elements, by which the
  ! transforms forward and back multiply.
  subroutine scale_spectrum(self)
    class(lattice_convolution), intent(inout) :: self

    ! The spectrum holds the eigenvalues of the padded matrix, of which that of the lattice is a
    ! principal submatrix.
    self%norm = maxval(abs(self%spectrum(:, :, of_influence)))
    self%spectrum = self%spectrum / (real(self%columns, c_double) * self%rows)
  end subroutine scale_spectrum

  ! Allocates the arrays, makes the plans and sets the spectrum of the approximate inverse for a
  ! lattice of `rows` rows that is padded to `padded_columns` by `padded_rows`.
  subroutine make_plans(self, padded_columns, padded_rows, rows, side_ratio)
    class(lattice_convolution), intent(inout), target :: self
    integer, intent(in) :: padded_columns, padded_rows, rows
    real(real64), intent(in) :: side_ratio
    integer :: i, j

    self%columns = padded_columns
    self%rows = padded_rows
    allocate (self%transform(0:padded_columns / 2, 0:rows - 1), &
              self%spectrum(0:padded_rows / 2, 0:padded_columns / 2, 2))
    call self%row_forward%prepare(real_to_waves, padded_columns)
    call self%column_forward%prepare(waves_forward, padded_rows)
    call self%column_back%prepare(waves_back, padded_rows)
    call self%row_back%prepare(waves_to_real, padded_columns)
    associate (side_x => real(padded_columns, real64), side_y => padded_rows * side_ratio)
      do i = 0, padded_columns / 2
        do j = 0, padded_rows / 2
          self%spectrum(j, i, of_inverse) = pi * hypot(i / side_x, j / side_y)
        end do
      end do
      self%spectrum(0, 0, of_inverse) = pi / max(side_x, side_y)
    end associate
  end subroutine make_plans

  !> Convolves forces with the influence, or displacements with its approximate inverse, on the
  !> lattice of the preparation.
  !>
  !> The displacement times the modulus by a pressure wave of number q is 2/q: the inverse is q/2,
  !> exact on a periodic lattice, but for the mean, which has the lowest q in place of 0. That makes
  !> the inverse positive definite, also on a part of the elements. The inverse of the padded matrix
  !> is not: a few of its eigenvalues are negative.
  subroutine apply_influence(self, force, displacement, inverse)
    class(lattice_convolution), intent(inout), target :: self  !! convolution with its plans
    real(real64), intent(in) :: force(:, :)                !! forces; if inverse, displacements
    real(real64), intent(out) :: displacement(:, :)        !! displacements; if inverse, forces
    logical, intent(in), optional :: inverse               !! whether the inverse is applied
    real(c_double), allocatable, target :: row(:)
    complex(c_double_complex), allocatable, target :: column(:, :), waves(:)
    integer :: i, j, k, m, n, last, operator_index

    operator_index = of_influence
    if (present(inverse)) operator_index = merge(of_inverse, of_influence, inverse)
    m = size(force, 1)
    n = size(force, 2)
    !$omp parallel private(row, column, waves, k, last) if(size(self%transform) > thread_threshold)
    allocate (row(self%columns), waves(0:self%rows - 1))
    allocate (column(0:self%rows - 1, 0:block_columns - 1))
    !$omp do schedule(static)
    do j = 1, n
      row(:m) = force(:, j)
      row(m + 1:) = 0.0_c_double
      call self%row_forward%apply(c_loc(row), &
                                c_loc(self%transform(0, j - 1)))
    end do
    !$omp end do
    !$omp do schedule(static)
    do i = 0, self%columns / 2, block_columns
      last = min(block_columns - 1, self%columns / 2 - i)
      column(:n - 1, :last) = transpose(self%transform(i:i + last, :n - 1))
      do k = 0, last
        column(n:, k) = (0.0_c_double, 0.0_c_double)
        call self%column_forward%apply(c_loc(column(0, k)), c_loc(waves))
        associate (spectrum => self%spectrum(:, i + k, operator_index), middle => self%rows / 2)
          waves(:middle) = waves(:middle) * spectrum
          waves(middle + 1:) = waves(middle + 1:) * &
                               self%spectrum((self%rows - 1) / 2:1:-1, i + k, operator_index)
        end associate
        call self%column_back%apply(c_loc(waves), c_loc(column(0, k)))
      end do
      self%transform(i:i + last, :n - 1) = transpose(column(:n - 1, :last))
    end do
    !$omp end do
    !$omp do schedule(static)
    do j = 1, n
      call self%row_back%apply(c_loc(self%transform(0, j - 1)), c_loc(row))
      displacement(:, j) = row(:m)
    end do
    !$omp end do
    !$omp end parallel
  end subroutine apply_influence

  !> Length of at least n and at most n plus an eighth that is at most 16 times a power of 2: FFTW
  !> is efficient for powers of 2, 3, 5 and 7 and one factor of 11 or 13.
  elemental integer function padded_length(n)
    integer, intent(in) :: n  !! least length, 1 or more
    integer :: step

    step = 2**max(0, exponent(real(n)) - 4)
    padded_length = step * ((n + step - 1) / step)
  end function padded_length

end module asperity_lattice_convolution
