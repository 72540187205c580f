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
  use asperity_kinds, only: int64, real64
  use asperity_line_transform, only: line_transform, real_to_waves, waves_back, waves_forward, &
                                     waves_to_real
  implicit none
  private

  public :: lattice_convolution, padded_length, thread_threshold

  !> The convolution for one lattice. It owns its plans: it must not be copied.
  type :: lattice_convolution
    private
    real(real64), public :: norm = 0.0_real64  !! upper bound of the eigenvalues of the matrix
    logical :: repeats(2) = .false.  ! the lattice is periodic along x, y
    real(real64) :: shares(2) = 0.0_real64  ! `rim_share` of neighbours along x, y
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
    procedure :: invert_on
  end type lattice_convolution

  ! Indices of the operators in the spectrum.
  integer, parameter :: of_influence = 1, of_inverse = 2

  ! Number of columns that are copied together, as they share lines of the cache (chosen).
  integer, parameter :: block_columns = 8
  !> Number of values above which threads share a loop over them (chosen).
  integer, parameter :: thread_threshold = 30000
  ! An element beside W gets a share of the displacement of each neighbour in W: `rim_share` of one
  ! along a row or column, and the product of both over this of a diagonal one. Derived: of a square
  ! a diagonal one has 0.096 by the same integral.
  real(real64), parameter :: share = 0.62_real64

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
    if (present(strip_axis)) then
      padded(strip_axis) = n(strip_axis)
      self%repeats(strip_axis) = .true.
    end if
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
  !> the mean pressure; times a factor of each wave under layers.
  subroutine prepare_periodic(self, columns, rows, side_ratio, factor)
    class(lattice_convolution), intent(inout), target :: self  !! convolution without plans
    integer, intent(in) :: columns, rows     !! numbers of columns and rows
    real(real64), intent(in) :: side_ratio   !! side of an element along y over that along x
    !> (wave number in x, in y): of half of the numbers; the first: displacement by a mean pressure
    real(real64), intent(in), optional :: factor(0:, 0:)

    call make_plans(self, columns, rows, rows, side_ratio)
    self%repeats = .true.
    self%spectrum(:, :, of_influence) = 1.0_real64 / self%spectrum(:, :, of_inverse)
    self%spectrum(0, 0, of_influence) = merge(1.0_real64, 0.0_real64, present(factor))
    if (present(factor)) then
      self%spectrum(:, :, of_influence) = self%spectrum(:, :, of_influence) * transpose(factor)
      where (self%spectrum(:, :, of_influence) > 0.0_real64) &
        self%spectrum(:, :, of_inverse) = 1.0_real64 / self%spectrum(:, :, of_influence)
    end if
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

    self%shares = [rim_share(side_ratio), rim_share(1.0_real64 / side_ratio)]
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

  !> Convolves forces with the influence on the lattice of the preparation.
  subroutine apply_influence(self, force, displacement)
    class(lattice_convolution), intent(inout) :: self    !! convolution with its plans
    real(real64), intent(in) :: force(:, :)              !! forces on the elements
    real(real64), intent(out) :: displacement(:, :)      !! displacements of the elements

    call transform_rows(self, force)
    call multiply_waves(self, of_influence)
    call transform_back(self, displacement)
  end subroutine apply_influence

  !> Applies an approximate inverse of the influence on a part W of the elements: where the
  !> displacement is not 0.
  !>
  !> The displacement times the modulus by a pressure wave of number q is 2/q: its inverse B is q/2,
  !> exact on a periodic lattice, but for the mean, which has the lowest q in place of 0. That makes
  !> it positive definite, also on a part of the elements. (The inverse of the padded matrix is not:
  !> a few of its eigenvalues are negative.) The inverse of the influence on W has w.Bw less than
  !> that, the least over all extensions of w from W. So an element beside W gets shares of its
  !> neighbours in W: E w has them, and the forces are E^T B E w. This matrix is symmetric and
  !> positive definite for any shares.
  subroutine invert_on(self, displacement, force)
    class(lattice_convolution), intent(inout) :: self  !! convolution with its plans
    real(real64), intent(in), contiguous :: displacement(:, :)  !! displacements w of W
    real(real64), intent(out), contiguous :: force(:, :)  !! E^T B E w in W; elsewhere undefined
    real(real64) :: line(size(force, 1))
    integer :: i, j

    !$omp parallel do private(line) if(size(force, kind=int64) > thread_threshold)
    do j = 1, size(force, 2)
      call share_line(self, displacement, j, line)
      !$omp simd
      do i = 1, size(force, 1)
        force(i, j) = displacement(i, j) + one_beside(displacement(i, j)) * line(i)
      end do
    end do
    call transform_rows(self, force)
    call multiply_waves(self, of_inverse)
    call transform_back(self, force)
    ! The forces beside W, which do not change, are shared by their neighbours in W.
    !$omp parallel do private(line) if(size(force, kind=int64) > thread_threshold)
    do j = 1, size(force, 2)
      call share_line(self, force, j, line, displacement)
      !$omp simd
      do i = 1, size(force, 1)
        force(i, j) = force(i, j) + (1.0_real64 - one_beside(displacement(i, j))) * line(i)
      end do
    end do
  end subroutine invert_on

  ! Shares of the elements of a line in the values of their neighbours, of those outside of W alone
  ! where that is given.
  pure subroutine share_line(self, values, j, line, in_w)
    class(lattice_convolution), intent(in) :: self
    real(real64), intent(in), contiguous :: values(:, :)
    integer, intent(in) :: j                             ! the line
    real(real64), intent(out) :: line(size(values, 1))
    real(real64), intent(in), contiguous, optional :: in_w(:, :)  ! not 0 in W
    real(real64) :: across(0:size(values, 1) + 1), diagonal, weight(2)
    integer :: i, m, row(2)

    m = size(values, 1)
    row = 1 + modulo([j - 2, j], size(values, 2))
    weight = self%shares(2) * merge(1.0_real64, 0.0_real64, self%repeats(2) .or. &
                                    row == [j - 1, j + 1])
    diagonal = self%shares(1) / share
    across([0, m + 1]) = 0.0_real64
    if (present(in_w)) then
      !$omp simd
      do i = 1, m
        across(i) = one_beside(in_w(i, j)) * (share * values(i, j)) + &
                    one_beside(in_w(i, row(1))) * (weight(1) * values(i, row(1))) + &
                    one_beside(in_w(i, row(2))) * (weight(2) * values(i, row(2)))
      end do
    else
      !$omp simd
      do i = 1, m
        across(i) = share * values(i, j) + weight(1) * values(i, row(1)) + &
                    weight(2) * values(i, row(2))
      end do
    end if
    if (self%repeats(1)) across([0, m + 1]) = across([m, 1])
    !$omp simd
    do i = 1, m
      line(i) = across(i) + diagonal * (across(i - 1) + across(i + 1))
    end do
  end subroutine share_line

  ! Share of an element in the displacement of the next one outside a straight rim of W. There is no
  ! force: its displacement is the integral over W of that in W and the Poisson kernel
  ! sqrt(x/y)/(pi**2 ((x + y)**2 + z**2)), x outside, y inside, z along the rim (Riesz, Acta Sci.
  ! Math. 9 (1938) 1). The share is the integral over the element, for x in the middle of the next:
  ! 0.243 of a square, with y = t**2.
  pure real(real64) function rim_share(length)
    real(real64), intent(in) :: length  ! side of an element along the rim over that across
    integer, parameter :: points = 64
    real(real64) :: distance
    integer :: i

    rim_share = 0.0_real64
    do i = 1, points
      distance = 0.5_real64 + ((i - 0.5_real64) / points)**2
      rim_share = rim_share + atan(0.5_real64 * length / distance) / distance
    end do
    rim_share = rim_share * (2.0_real64 * sqrt(2.0_real64) / (pi**2 * points))
  end function rim_share

  ! 1 for an element beside W, else 0: loops that multiply by it have no branches.
  elemental real(real64) function one_beside(displacement)
    real(real64), intent(in) :: displacement

    one_beside = merge(0.0_real64, 1.0_real64, abs(displacement) > 0.0_real64)
  end function one_beside

  ! Transforms the rows of the values.
  subroutine transform_rows(self, values)
    class(lattice_convolution), intent(inout), target :: self
    real(real64), intent(in) :: values(:, :)
    real(c_double), allocatable, target :: row(:)
    integer :: j

    !$omp parallel private(row) if(size(self%transform, kind=int64) > thread_threshold)
    allocate (row(self%columns), source=0.0_c_double)
    !$omp do schedule(static)
    do j = 1, size(values, 2)
      row(:size(values, 1)) = values(:, j)
      call self%row_forward%apply(c_loc(row), c_loc(self%transform(0, j - 1)))
    end do
    !$omp end do
    !$omp end parallel
  end subroutine transform_rows

  ! Transforms the columns, multiplies their waves by an operator, and transforms them back.
  subroutine multiply_waves(self, operator_index)
    class(lattice_convolution), intent(inout), target :: self
    integer, intent(in) :: operator_index
    complex(c_double_complex), allocatable, target :: column(:, :), waves(:)
    integer :: i, j, k, n, last

    n = size(self%transform, 2)
    !$omp parallel private(column, waves, j, k, last) &
    !$omp if(size(self%transform, kind=int64) > thread_threshold)
    allocate (column(0:self%rows - 1, 0:block_columns - 1), waves(0:self%rows - 1))
    !$omp do schedule(static)
    do i = 0, self%columns / 2, block_columns
      last = min(block_columns - 1, self%columns / 2 - i)
      do j = 0, n - 1
        column(j, :last) = self%transform(i:i + last, j)
      end do
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
      do j = 0, n - 1
        self%transform(i:i + last, j) = column(j, :last)
      end do
    end do
    !$omp end do
    !$omp end parallel
  end subroutine multiply_waves

  ! Transforms the rows of waves back. The waves are overwritten.
  subroutine transform_back(self, values)
    class(lattice_convolution), intent(inout), target :: self
    real(real64), intent(out) :: values(:, :)
    real(c_double), allocatable, target :: row(:)
    integer :: j

    !$omp parallel private(row) if(size(self%transform, kind=int64) > thread_threshold)
    allocate (row(self%columns))
    !$omp do schedule(static)
    do j = 1, size(values, 2)
      call self%row_back%apply(c_loc(self%transform(0, j - 1)), c_loc(row))
      values(:, j) = row(:size(values, 1))
    end do
    !$omp end do
    !$omp end parallel
  end subroutine transform_back

  !> Length of at least n and at most n plus an eighth that is at most 16 times a power of 2: FFTW
  !> is efficient for powers of 2, 3, 5 and 7 and one factor of 11 or 13.
  elemental integer function padded_length(n)
    integer, intent(in) :: n  !! least length, 1 or more
    integer :: step

    step = 2**max(0, exponent(real(n)) - 4)
    padded_length = step * ((n + step - 1) / step)
  end function padded_length

end module asperity_lattice_convolution
