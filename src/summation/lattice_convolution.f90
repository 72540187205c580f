!> Displacements of all elements of a rectangular lattice by forces on all elements: a discrete
!> convolution by fast Fourier transforms with FFTW 3 (Frigo and Johnson, Proc. IEEE 93, 2005).
!>
!> The influence of a force depends only on the offset of two elements. On a lattice that is padded
!> with zeros to twice its size the periodic images have no effect: the sum is exact to rounding. On
!> a periodic lattice the influence is given by its transform. Rows are transformed one by one,
!> without those of the padding; each column is transformed, multiplied and transformed back by one
!> thread: the bytes of the result do not depend on the number of threads.
module asperity_lattice_convolution
  use, intrinsic :: iso_c_binding, only: c_loc
  use asperity_constants, only: pi
  use asperity_double_transform, only: double_transform => padded_transform
  use asperity_kinds, only: int64, real32, real64
  use asperity_line_transform, only: line_transform, real_to_waves, thread_threshold, waves_forward
  use asperity_single_transform, only: single_transform => padded_transform
  implicit none
  private

  public :: lattice_convolution, padded_length

  !> The convolution for one lattice. It owns its plans: it must not be copied.
  type :: lattice_convolution
    private
    real(real64), public :: norm = 0.0_real64  !! upper bound of the eigenvalues of the matrix
    logical :: repeats(2) = .false.  ! the lattice is periodic along x, y
    real(real64) :: shares(2) = 0.0_real64  ! `rim_share` of neighbours along x, y
    ! (wave number in y, wave number in x): spectrum of the influence, and of its approximate
    ! inverse, over the number of padded elements. Half of the wave numbers are kept in each
    ! direction: the influence is the same at mirrored offsets.
    real(real64), allocatable :: spectrum(:, :)
    real(real32), allocatable :: single_spectrum(:, :), inverse(:, :)
    type(double_transform) :: exact
    type(single_transform) :: single
  contains
    procedure :: prepare => prepare_plane
    procedure :: prepare_periodic
    generic :: apply => apply_influence, apply_single
    procedure, private :: apply_influence
    procedure, private :: apply_single
    procedure :: invert_on
  end type lattice_convolution

  ! Number of rows whose shares are found together: two more are transformed for them (chosen).
  integer, parameter :: block_rows = 16
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
    type(line_transform) :: along_columns, along_rows
    real(real64), allocatable, target :: row(:)
    complex(real64), allocatable, target :: column(:), of_row(:), other(:)
    complex(real64), allocatable :: of_rows(:, :)
    integer :: i, j, n(2), padded(2)

    n = shape(influence)
    padded = padded_length(2 * n - 1)
    if (present(strip_axis)) then
      padded(strip_axis) = n(strip_axis)
      self%repeats(strip_axis) = .true.
    end if
    call make_plans(self, padded, n(2), side_ratio)
    call along_rows%prepare(real_to_waves, padded(1))
    call along_columns%prepare(waves_forward, padded(2))
    allocate (row(0:padded(1) - 1), source=0.0_real64)
    allocate (of_row(0:padded(1) / 2), column(0:padded(2) - 1), other(0:padded(2) - 1))
    allocate (of_rows(0:n(2) - 1, 0:padded(1) / 2))
    do j = 0, n(2) - 1
      row(:n(1) - 1) = influence(:, j)
      if (padded(1) > n(1)) row(padded(1) - n(1) + 1:) = influence(n(1) - 1:1:-1, j)
      call along_rows%apply(c_loc(row), c_loc(of_row))
      of_rows(j, :) = of_row
    end do
    do i = 0, padded(1) / 2
      column = (0.0_real64, 0.0_real64)
      column(:n(2) - 1) = real(of_rows(:, i), real64)
      if (padded(2) > n(2)) column(padded(2) - n(2) + 1:) = column(n(2) - 1:1:-1)
      call along_columns%apply(c_loc(column), c_loc(other))
      self%spectrum(:, i) = real(other(:padded(2) / 2), real64)
    end do
    call scale_spectrum(self, product(real(padded, real64)))
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


    call make_plans(self, [columns, rows], rows, side_ratio)
    self%repeats = .true.
    self%spectrum = 1.0_real64 / self%spectrum
    self%spectrum(0, 0) = merge(1.0_real64, 0.0_real64, present(factor))
    if (present(factor)) then
      self%spectrum = self%spectrum * transpose(factor)
      where (self%spectrum > 0.0_real64) self%inverse = real(1.0_real64 / self%spectrum, real32)
    end if
    call scale_spectrum(self, real(columns, real64) * rows)
  end subroutine prepare_periodic

  ! Sets the norm, and divides both spectra by the number of padded elements, by which the
  ! transforms forward and back multiply.
  subroutine scale_spectrum(self, number)
    class(lattice_convolution), intent(inout) :: self
    real(real64), intent(in) :: number

    ! The spectrum holds the eigenvalues of the padded matrix, of which that of the lattice is a
    ! principal submatrix.
    self%norm = maxval(abs(self%spectrum))
    self%spectrum = self%spectrum / number
    self%inverse = real(self%inverse / number, real32)
    self%single_spectrum = real(self%spectrum, real32)
  end subroutine scale_spectrum

  ! Allocates the arrays, makes the plans and sets both spectra to that of the approximate inverse
  ! for a lattice of `rows` rows that is padded.
  subroutine make_plans(self, padded, rows, side_ratio)
    class(lattice_convolution), intent(inout) :: self
    integer, intent(in) :: padded(2)  ! numbers of columns and rows
    integer, intent(in) :: rows
    real(real64), intent(in) :: side_ratio
    real(real64) :: sides(2)
    integer :: i, j

    self%shares = [rim_share(side_ratio), rim_share(1.0_real64 / side_ratio)]
    call self%exact%prepare(padded(1), padded(2), rows)
    call self%single%prepare(padded(1), padded(2), rows)
    allocate (self%spectrum(0:padded(2) / 2, 0:padded(1) / 2))
    allocate (self%inverse(0:padded(2) / 2, 0:padded(1) / 2))
    sides = padded * [1.0_real64, side_ratio]
    do i = 0, padded(1) / 2
      do j = 0, padded(2) / 2
        self%spectrum(j, i) = pi * hypot(i / sides(1), j / sides(2))
      end do
    end do
    self%spectrum(0, 0) = pi / maxval(sides)
    self%inverse = real(self%spectrum, real32)
  end subroutine make_plans

  !> Convolves forces with the influence on the lattice of the preparation.
  subroutine apply_influence(self, force, displacement)
    class(lattice_convolution), intent(inout) :: self    !! convolution with its plans
    real(real64), intent(in) :: force(:, :)              !! forces on the elements
    real(real64), intent(out) :: displacement(:, :)      !! displacements of the elements

    call self%exact%convolve_values(self%spectrum, force, displacement)
  end subroutine apply_influence

  !> The same with numbers and transforms of single precision.
  subroutine apply_single(self, force, displacement)
    class(lattice_convolution), intent(inout) :: self    !! convolution with its plans
    real(real32), intent(in) :: force(:, :)              !! forces on the elements
    real(real32), intent(out) :: displacement(:, :)      !! displacements of the elements

    call self%single%convolve_values(self%single_spectrum, force, displacement)
  end subroutine apply_single

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
    real(real32), intent(in), contiguous :: displacement(:, :)  !! displacements w of W
    real(real32), intent(out), contiguous :: force(:, :)  !! E^T B E w in W; elsewhere undefined
    real(real32), allocatable :: across(:), beside(:, :), line(:)
    real(real64), allocatable :: row(:)
    complex(real64), allocatable :: scratch(:)
    integer :: first, j, k, m, n

    m = size(force, 1)
    n = size(force, 2)
    !$omp parallel private(across, j, line, row, scratch) &
    !$omp if(size(force, kind=int64) > thread_threshold)
    allocate (across(0:m + 1), line(m))
    allocate (row(self%single%columns), source=0.0_real64)
    !$omp do schedule(static)
    do j = 1, n
      call share_row(self, j, n, displacement(:, 1 + modulo(j - 2, n)), displacement(:, j), &
                     displacement(:, 1 + modulo(j, n)), across, line)
      row(:m) = displacement(:, j) + one_beside(displacement(:, j)) * line
      call self%single%put_row(j, row, scratch)
    end do
    !$omp end do nowait
    !$omp end parallel
    call self%single%multiply_waves(self%inverse)
    ! The forces beside W, which do not change, are shared by their neighbours in W.
    !$omp parallel private(across, beside, first, j, k, line, row, scratch) &
    !$omp if(size(force, kind=int64) > thread_threshold)
    allocate (across(0:m + 1), beside(m, 0:block_rows + 1), line(m), row(self%single%columns))
    !$omp do schedule(static)
    do first = 0, n - 1, block_rows
      do j = 0, min(block_rows, n - first) + 1
        k = 1 + modulo(first + j - 1, n)
        call self%single%get_row(k, scratch, row)
        beside(:, j) = one_beside(displacement(:, k)) * real(row(:m), real32)
        if (k == first + j .and. j > 0 .and. j <= block_rows) force(:, k) = real(row(:m), real32)
      end do
      do j = 1, min(block_rows, n - first)
        k = first + j
        call share_row(self, k, n, beside(:, j - 1), beside(:, j), beside(:, j + 1), across, line)
        force(:, k) = force(:, k) + (1.0_real32 - one_beside(displacement(:, k))) * line
      end do
    end do
    !$omp end do nowait
    !$omp end parallel
  end subroutine invert_on

  ! Shares of the elements of a row in the values of their neighbours, in three rows.
  pure subroutine share_row(self, j, n, below, values, above, across, line)
    class(lattice_convolution), intent(in) :: self
    integer, intent(in) :: j, n                          ! number of the row, and of all rows
    real(real32), intent(in), contiguous :: below(:), values(:), above(:)
    real(real32), intent(inout), contiguous :: across(0:)  ! two more: overwritten
    real(real32), intent(out), contiguous :: line(:)
    real(real32) :: diagonal, weight(2)
    integer :: i, m

    m = size(values)
    weight = real(self%shares(2), real32)
    if (.not. self%repeats(2)) weight = weight * merge(1.0_real32, 0.0_real32, [j > 1, j < n])
    diagonal = real(self%shares(1) / share, real32)
    across([0, m + 1]) = 0.0_real32
    !$omp simd
    do i = 1, m
      across(i) = real(share, real32) * values(i) + weight(1) * below(i) + weight(2) * above(i)
    end do
    if (self%repeats(1)) across([0, m + 1]) = across([m, 1])
    !$omp simd
    do i = 1, m
      line(i) = across(i) + diagonal * (across(i - 1) + across(i + 1))
    end do
  end subroutine share_row

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
  elemental real(real32) function one_beside(displacement)
    real(real32), intent(in) :: displacement

    one_beside = merge(0.0_real32, 1.0_real32, abs(displacement) > 0.0_real32)
  end function one_beside

  !> Length of at least n and at most n plus an eighth that is at most 16 times a power of 2: FFTW
  !> is efficient for powers of 2, 3, 5 and 7 and one factor of 11 or 13.
  elemental integer function padded_length(n)
    integer, intent(in) :: n  !! least length, 1 or more
    integer :: step

    step = 2**max(0, exponent(real(n)) - 4)
    padded_length = step * ((n + step - 1) / step)
  end function padded_length

end module asperity_lattice_convolution
