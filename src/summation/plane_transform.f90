!> Fourier transforms of real values on a lattice that is padded with zeros, with FFTW 3.
!>
!> Rows are transformed one by one, without those of the padding, then columns. The result does not
!> depend on the number of threads.
module asperity_plane_transform
  use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_loc
  use asperity_kinds, only: real64
  use asperity_line_transform, only: line_transform, real_to_waves, waves_back, waves_forward, &
                                     waves_to_real
  implicit none
  private

  public :: plane_transform

  !> Transforms of one padded lattice. It owns its plans: it must not be copied.
  type :: plane_transform
    integer :: columns = 0  !! columns of the padded lattice
    integer :: rows = 0     !! rows of the padded lattice
    type(line_transform), private :: row_forward, column_forward, column_back, row_back
  contains
    procedure :: prepare => prepare_transforms  !! makes the plans
    procedure :: make_waves                     !! values to waves
    procedure :: sum_waves                      !! waves to values
  end type plane_transform

contains

  !> Makes the plans.
  subroutine prepare_transforms(self, columns, rows)
    class(plane_transform), intent(inout) :: self  !! transforms without plans
    integer, intent(in) :: columns, rows           !! size of the padded lattice

    self%columns = columns
    self%rows = rows
    call self%row_forward%prepare(real_to_waves, columns)
    call self%column_forward%prepare(waves_forward, rows)
    call self%column_back%prepare(waves_back, rows)
    call self%row_back%prepare(waves_to_real, columns)
  end subroutine prepare_transforms

  !> Transforms values, the first columns and rows of the lattice; the others are 0.
  subroutine make_waves(self, values, waves)
    class(plane_transform), intent(in) :: self  !! transforms with plans
    real(real64), intent(in) :: values(:, :)    !! (column, row), at most the lattice
    !> (wave number in y, wave number in x); half of the wave numbers in x
    complex(real64), intent(out), target :: waves(0:, 0:)
    complex(c_double_complex), allocatable, target :: of_rows(:, :), line(:), other(:)
    real(c_double), allocatable, target :: row(:)
    integer :: i, j, m, n

    m = size(values, 1)
    n = size(values, 2)
    allocate (of_rows(0:self%columns / 2, n))
    !$omp parallel private(row, line, other)
    allocate (row(self%columns), source=0.0_c_double)
    allocate (line(0:self%rows - 1), other(0:self%rows - 1))
    !$omp do schedule(static)
    do j = 1, n
      row(:m) = values(:, j)
      row(m + 1:) = 0.0_c_double
      call self%row_forward%apply(c_loc(row), c_loc(of_rows(0, j)))
    end do
    !$omp end do
    !$omp do schedule(static)
    do i = 0, self%columns / 2
      line(:n - 1) = of_rows(i, :)
      line(n:) = (0.0_c_double, 0.0_c_double)
      call self%column_forward%apply(c_loc(line), c_loc(other))
      waves(:, i) = other
    end do
    !$omp end do nowait
    !$omp end parallel
  end subroutine make_waves

  !> Transforms waves back, to the first columns and rows of the lattice.
  subroutine sum_waves(self, waves, values)
    class(plane_transform), intent(in) :: self     !! transforms with plans
    complex(real64), intent(in) :: waves(0:, 0:)   !! as `make_waves` has them
    real(real64), intent(out) :: values(:, :)      !! (column, row), at most the lattice
    complex(c_double_complex), allocatable, target :: of_rows(:, :), line(:), other(:)
    real(c_double), allocatable, target :: row(:)
    integer :: i, j, m, n

    m = size(values, 1)
    n = size(values, 2)
    allocate (of_rows(0:self%columns / 2, n))
    !$omp parallel private(row, line, other)
    allocate (row(self%columns), line(0:self%rows - 1), other(0:self%rows - 1))
    !$omp do schedule(static)
    do i = 0, self%columns / 2
      line = waves(:, i)
      call self%column_back%apply(c_loc(line), c_loc(other))
      of_rows(i, :) = other(:n - 1)
    end do
    !$omp end do
    !$omp do schedule(static)
    do j = 1, n
      call self%row_back%apply(c_loc(of_rows(0, j)), c_loc(row))
      values(:, j) = row(:m) / (real(self%columns, real64) * self%rows)
    end do
    !$omp end do nowait
    !$omp end parallel
  end subroutine sum_waves

end module asperity_plane_transform
