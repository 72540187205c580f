!> What forces on all cells of a rectangular lattice do at all its cells, through FFTW 3
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
    procedure :: prepare
    procedure :: prepare_periodic
    procedure :: apply
    final :: destroy
  end type cell_convolution

  ! The plans: of a row, of a column, of a column back, of a row back.
  integer, parameter :: of_row = 1, of_column = 2, column_back = 3, row_back = 4

  ! Columns that are gathered at once, which share lines of the cache; numbers of a transform from
  ! which on threads are worth it.
  integer, parameter :: at_once = 8, many = 30000

contains

  !> Prepares the sum for an influence that is the same at an offset and at its mirror images.
  subroutine prepare(sum, influence)
    class(cell_convolution), intent(inout), target :: sum  !! not prepared before
    real(real64), intent(in) :: influence(0:, 0:)          !! by offset, of the lattice's size
    real(c_double), allocatable, target :: row(:)
    complex(c_double_complex), allocatable, target :: column(:)
    integer :: i, j, n

    call make_plans(sum, padded_length(2 * size(influence, 1) - 1), &
                    padded_length(2 * size(influence, 2) - 1), size(influence, 2))
    allocate (row(0:sum%wide - 1), column(0:sum%high - 1))
    n = size(influence, 1)
    row = 0.0_c_double
    do j = 0, ubound(influence, 2)
      row(:n - 1) = influence(:, j)
      row(sum%wide - n + 1:) = influence(n - 1:1:-1, j)
      call fftw_real_to_complex(sum%plans(of_row), c_loc(row), c_loc(sum%transform(0, j)))
    end do
    n = size(influence, 2)
    do i = 0, ubound(sum%transform, 1)
      column = (0.0_c_double, 0.0_c_double)
      column(:n - 1) = real(sum%transform(i, :), c_double)
      column(sum%high - n + 1:) = column(n - 1:1:-1)
      call fftw_complex(sum%plans(of_column), c_loc(column), c_loc(column))
      sum%spectrum(:, i, 1) = real(column(:sum%high / 2), c_double)
    end do
    call scale_spectrum(sum)
  end subroutine prepare

  !> Prepares the sum for displacements by pressures on a periodic half-space, over the modulus: a
  !> wave of number q has 2/q (Johnson, Contact Mechanics, 1985, section 13.2). The mean has 0.
  subroutine prepare_periodic(sum, columns, rows, side_x, side_y)
    class(cell_convolution), intent(inout), target :: sum  !! not prepared before
    integer, intent(in) :: columns, rows                   !! of the lattice
    real(real64), intent(in) :: side_x, side_y             !! of a cell
    integer :: i, j

    call make_plans(sum, columns, rows, rows)
    do i = 0, columns / 2
      do j = 0, rows / 2
        sum%spectrum(j, i, 1) = 0.0_real64
        if (i + j > 0) sum%spectrum(j, i, 1) = 1.0_real64 / &
          (pi * hypot(i / (columns * side_x), j / (rows * side_y)))
      end do
    end do
    call scale_spectrum(sum)
  end subroutine prepare_periodic

  ! There and back the transforms multiply by the size.
  subroutine scale_spectrum(sum)
    class(cell_convolution), intent(inout) :: sum
    real(c_double) :: across(0:sum%wide / 2), along(0:sum%high / 2)
    integer :: i

    ! The lattice's matrix is a part of the padded one, whose eigenvalues these are.
    sum%norm = maxval(abs(sum%spectrum(:, :, 1)))
    across = [(sin(i * pi / sum%wide)**2, i=0, sum%wide / 2)]
    along = [(sin(i * pi / sum%high)**2 + sin(pi / sum%wide)**2 + sin(pi / sum%high)**2, &
              i=0, sum%high / 2)]
    do i = 0, sum%wide / 2
      sum%spectrum(:, i, 2) = sqrt(across(i) + along)
    end do
    sum%spectrum = sum%spectrum / (real(sum%wide, c_double) * sum%high)
  end subroutine scale_spectrum

  ! Room and plans for a lattice of so many rows that is padded to `wide` by `high`.
  subroutine make_plans(sum, wide, high, rows)
    class(cell_convolution), intent(inout), target :: sum
    integer, intent(in) :: wide, high, rows

    sum%wide = wide
    sum%high = high
    allocate (sum%transform(0:wide / 2, 0:rows - 1), sum%spectrum(0:high / 2, 0:wide / 2, 2))
    ! Planning without measuring touches no array.
    associate (row => c_loc(sum%spectrum), waves => c_loc(sum%transform))
      !$omp critical (fftw_plans)
      sum%plans = [ &
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
  subroutine apply(sum, from, to, inverse)
    class(cell_convolution), intent(inout), target :: sum  !! prepared
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
    !$omp parallel private(row, column, k, last) if(size(sum%transform) > many)
    allocate (row(sum%wide), column(0:sum%high - 1, 0:at_once - 1))
    !$omp do schedule(static)
    do j = 1, n
      row(:m) = from(:, j)
      row(m + 1:) = 0.0_c_double
      call fftw_real_to_complex(sum%plans(of_row), c_loc(row), c_loc(sum%transform(0, j - 1)))
    end do
    !$omp end do
    !$omp do schedule(static)
    do i = 0, sum%wide / 2, at_once
      last = min(at_once - 1, sum%wide / 2 - i)
      column(:n - 1, :last) = transpose(sum%transform(i:i + last, :n - 1))
      do k = 0, last
        column(n:, k) = (0.0_c_double, 0.0_c_double)
        call fftw_complex(sum%plans(of_column), c_loc(column(0, k)), c_loc(column(0, k)))
        column(:sum%high / 2, k) = column(:sum%high / 2, k) * sum%spectrum(:, i + k, which)
        column(sum%high / 2 + 1:, k) = column(sum%high / 2 + 1:, k) * &
                                       sum%spectrum((sum%high - 1) / 2:1:-1, i + k, which)
        call fftw_complex(sum%plans(column_back), c_loc(column(0, k)), c_loc(column(0, k)))
      end do
      sum%transform(i:i + last, :n - 1) = transpose(column(:n - 1, :last))
    end do
    !$omp end do
    !$omp do schedule(static)
    do j = 1, n
      call fftw_complex_to_real(sum%plans(row_back), c_loc(sum%transform(0, j - 1)), c_loc(row))
      to(:, j) = row(:m)
    end do
    !$omp end do
    !$omp end parallel
  end subroutine apply

  subroutine destroy(sum)
    type(cell_convolution), intent(inout) :: sum
    integer :: i

    if (.not. c_associated(sum%plans(1))) return
    !$omp critical (fftw_plans)
    do i = 1, size(sum%plans)
      call fftw_destroy(sum%plans(i))
    end do
    !$omp end critical (fftw_plans)
    sum%plans = c_null_ptr
  end subroutine destroy

  !> A length from n on, an eighth more at most, that is a power of 2 times 16 at most: FFTW is
  !> quick with powers of 2, 3, 5 and 7 and one factor of 11 or 13.
  pure integer function padded_length(n)
    integer, intent(in) :: n  !! 1 or more
    integer :: step

    step = 2**max(0, exponent(real(n)) - 4)
    padded_length = step * ((n + step - 1) / step)
  end function padded_length

end module asperity_cell_convolution
