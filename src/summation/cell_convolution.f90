!> Displacements at all cells of a rectangular lattice by forces on all its cells, through FFTW 3
!> (Frigo and Johnson, Proc. IEEE 93, 2005).
!>
!> The influence depends on the offset of two cells alone. On a lattice padded with zeros to twice
!> its size the periodic images do not reach it: the sum is exact but for rounding. On a periodic
!> lattice the influence is known by its transform. Rows are transformed one by one, those of zeros
!> not at all, then columns, which go forward and back at once: bytes do not depend on the number of
!> threads.
module asperity_cell_convolution
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_double_complex, c_int, c_loc, &
                                         c_null_ptr, c_ptr
  use asperity_constants, only: pi
  use asperity_fftw_calls, only: fftw_backward, fftw_complex, fftw_complex_to_real, fftw_destroy, &
                                 fftw_estimate, fftw_forward, fftw_plan_complex, &
                                 fftw_plan_complex_to_real, fftw_plan_real_to_complex, &
                                 fftw_real_to_complex
  use asperity_kinds, only: real64
  implicit none
  private

  public :: cell_convolution, padded_length

  !> A sum over one lattice. It owns its plans: it must not be copied.
  type :: cell_convolution
    private
    real(real64), public :: norm = 0.0_real64  !! the matrix of the sum has no larger eigenvalue
    integer :: wide = 0  ! padded
    integer :: high = 0
    ! By wave number along and across, half of them: it is the same at the mirror images. Of the
    ! influence and of its rough inverse.
    real(c_double), allocatable :: spectrum(:, :, :)
    complex(c_double_complex), allocatable :: transform(:, :)  ! by wave number across and row
    type(c_ptr) :: plans(4) = c_null_ptr
  contains
    procedure :: prepare => prepare_plane
    procedure :: prepare_periodic
    procedure :: apply => apply_influence
    final :: destroy_plans
  end type cell_convolution

  ! The plans: of a row, of a column, of a column back, of a row back.
  integer, parameter :: of_row = 1, of_column = 2, column_back = 3, row_back = 4

  ! Columns that are gathered at once, which share lines of the cache; numbers of a transform from
  ! which on threads are worth it.
  integer, parameter :: at_once = 8, many = 30000

contains

  !> Prepares the sum for an influence that is the same at an offset and at its mirror images.
  subroutine prepare_plane(self, influence)
    class(cell_convolution), intent(inout), target :: self  !! not prepared before
    real(real64), intent(in) :: influence(0:, 0:)          !! by offset, of the lattice's size
    real(c_double), allocatable, target :: row(:)
    complex(c_double_complex), allocatable, target :: column(:)
    integer :: i, j, n

    call make_plans(self, padded_length(2 * size(influence, 1) - 1), &
                    padded_length(2 * size(influence, 2) - 1), size(influence, 2))
    allocate (row(0:self%wide - 1), column(0:self%high - 1))
    n = size(influence, 1)
    row = 0.0_c_double
    do j = 0, ubound(influence, 2)
      row(:n - 1) = influence(:, j)
      row(self%wide - n + 1:) = influence(n - 1:1:-1, j)
      call fftw_real_to_complex(self%plans(of_row), c_loc(row), c_loc(self%transform(0, j)))
    end do
    n = size(influence, 2)
    do i = 0, ubound(self%transform, 1)
      column = (0.0_c_double, 0.0_c_double)
      column(:n - 1) = real(self%transform(i, :), c_double)
      column(self%high - n + 1:) = column(n - 1:1:-1)
      call fftw_complex(self%plans(of_column), c_loc(column), c_loc(column))
      self%spectrum(:, i, 1) = real(column(:self%high / 2), c_double)
    end do
    call scale_spectrum(self)
  end subroutine prepare_plane

  !> Prepares the sum for displacements by pressures on a periodic half-space, over the modulus: a
  !> wave of number q has 2/q (Johnson, Contact Mechanics, 1985, section 13.2). The mean has 0.
  subroutine prepare_periodic(self, columns, rows, side_x, side_y)
    class(cell_convolution), intent(inout), target :: self  !! not prepared before
    integer, intent(in) :: columns, rows                   !! of the lattice
    real(real64), intent(in) :: side_x, side_y             !! of a cell
    integer :: i, j

    call make_plans(self, columns, rows, rows)
    do i = 0, columns / 2
      do j = 0, rows / 2
        self%spectrum(j, i, 1) = 0.0_real64
        if (i + j > 0) self%spectrum(j, i, 1) = 1.0_real64 / &
          (pi * hypot(i / (columns * side_x), j / (rows * side_y)))
      end do
    end do
    call scale_spectrum(self)
  end subroutine prepare_periodic

  ! There and back the transforms multiply by the size.
  subroutine scale_spectrum(self)
    class(cell_convolution), intent(inout) :: self
    real(c_double) :: across(0:self%wide / 2), along(0:self%high / 2)
    integer :: i

    ! The lattice's matrix is a part of the padded one, whose eigenvalues these are.
    self%norm = maxval(abs(self%spectrum(:, :, 1)))
    across = [(sin(i * pi / self%wide)**2, i=0, self%wide / 2)]
    along = [(sin(i * pi / self%high)**2 + sin(pi / self%wide)**2 + sin(pi / self%high)**2, &
              i=0, self%high / 2)]
    do i = 0, self%wide / 2
      self%spectrum(:, i, 2) = sqrt(across(i) + along)
    end do
    self%spectrum = self%spectrum / (real(self%wide, c_double) * self%high)
  end subroutine scale_spectrum

  ! Room and plans for a lattice of so many rows that is padded to `wide` by `high`.
  subroutine make_plans(self, wide, high, rows)
    class(cell_convolution), intent(inout), target :: self
    integer, intent(in) :: wide, high, rows

    self%wide = wide
    self%high = high
    allocate (self%transform(0:wide / 2, 0:rows - 1), self%spectrum(0:high / 2, 0:wide / 2, 2))
    ! Planning without measuring touches no array.
    associate (row => c_loc(self%spectrum), waves => c_loc(self%transform))
      !$omp critical (fftw_plans)
      self%plans = [ &
        fftw_plan_real_to_complex(int(wide, c_int), row, waves, fftw_estimate), &
        fftw_plan_complex(int(high, c_int), waves, waves, fftw_forward, fftw_estimate), &
        fftw_plan_complex(int(high, c_int), waves, waves, fftw_backward, fftw_estimate), &
        fftw_plan_complex_to_real(int(wide, c_int), waves, row, fftw_estimate)]
      !$omp end critical (fftw_plans)
    end associate
  end subroutine make_plans

  !> Sums influence times force, on the lattice that it was prepared for; or nearly the inverse.
  !>
  !> The inverse is, but for a factor, that of an influence like 1/r, with a transform as 1/k, of
  !> wave number k. On a lattice k is as the root of the sum of the squares of sin(pi i/n), as for
  !> the second difference. The lowest k there is added: none is 0. So it is symmetric and positive
  !> definite, also on a part of the cells.
  subroutine apply_influence(self, from, to, inverse)
    class(cell_convolution), intent(inout), target :: self  !! convolution with influence and
                                                                   !! plans
    real(real64), intent(in) :: from(:, :)                 !! forces on all cells; or displacements
    real(real64), intent(out) :: to(:, :)                  !! displacements at all; or forces
    logical, intent(in), optional :: inverse               !! from displacements to forces
    real(c_double), allocatable, target :: row(:)
    complex(c_double_complex), allocatable, target :: column(:, :)
    integer :: i, j, k, m, n, last, which

    which = 1
    if (present(inverse)) which = merge(2, 1, inverse)
    m = size(from, 1)
    n = size(from, 2)
    !$omp parallel private(row, column, k, last) if(size(self%transform) > many)
    allocate (row(self%wide), column(0:self%high - 1, 0:at_once - 1))
    !$omp do schedule(static)
    do j = 1, n
      row(:m) = from(:, j)
      row(m + 1:) = 0.0_c_double
      call fftw_real_to_complex(self%plans(of_row), c_loc(row), c_loc(self%transform(0, j - 1)))
    end do
    !$omp end do
    !$omp do schedule(static)
    do i = 0, self%wide / 2, at_once
      last = min(at_once - 1, self%wide / 2 - i)
      column(:n - 1, :last) = transpose(self%transform(i:i + last, :n - 1))
      do k = 0, last
        column(n:, k) = (0.0_c_double, 0.0_c_double)
        call fftw_complex(self%plans(of_column), c_loc(column(0, k)), c_loc(column(0, k)))
        column(:self%high / 2, k) = column(:self%high / 2, k) * self%spectrum(:, i + k, which)
        column(self%high / 2 + 1:, k) = column(self%high / 2 + 1:, k) * &
                                       self%spectrum((self%high - 1) / 2:1:-1, i + k, which)
        call fftw_complex(self%plans(column_back), c_loc(column(0, k)), c_loc(column(0, k)))
      end do
      self%transform(i:i + last, :n - 1) = transpose(column(:n - 1, :last))
    end do
    !$omp end do
    !$omp do schedule(static)
    do j = 1, n
      call fftw_complex_to_real(self%plans(row_back), c_loc(self%transform(0, j - 1)), c_loc(row))
      to(:, j) = row(:m)
    end do
    !$omp end do
    !$omp end parallel
  end subroutine apply_influence

  subroutine destroy_plans(self)
    type(cell_convolution), intent(inout) :: self
    integer :: i

    if (.not. c_associated(self%plans(1))) return
    !$omp critical (fftw_plans)
    do i = 1, size(self%plans)
      call fftw_destroy(self%plans(i))
    end do
    !$omp end critical (fftw_plans)
    self%plans = c_null_ptr
  end subroutine destroy_plans

  !> A length from n on, an eighth more at most, that is a power of 2 times 16 at most: FFTW is
  !> quick with powers of 2, 3, 5 and 7 and one factor of 11 or 13.
  pure integer function padded_length(n)
    integer, intent(in) :: n  !! 1 or more
    integer :: step

    step = 2**max(0, exponent(real(n)) - 4)
    padded_length = step * ((n + step - 1) / step)
  end function padded_length

end module asperity_cell_convolution
