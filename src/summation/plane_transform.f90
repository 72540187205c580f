!> Fourier transforms of real values on a lattice that is padded with zeros, with FFTW 3.
!>
!> Rows are transformed one by one, without those of the padding, then columns. The result does not
!> depend on the number of threads.
module asperity_plane_transform
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_double_complex, c_int, c_loc, &
                                         c_null_ptr, c_ptr
  use asperity_fftw_calls, only: fftw_backward, fftw_complex, fftw_complex_to_real, fftw_destroy, &
                                 fftw_estimate, fftw_forward, fftw_plan_complex, &
                                 fftw_plan_complex_to_real, fftw_plan_real_to_complex, &
                                 fftw_real_to_complex
  use asperity_kinds, only: real64
  implicit none
  private

  public :: plane_transform

  !> Transforms of one padded lattice. It owns its plans: it must not be copied.
  type :: plane_transform
    integer :: columns = 0  !! columns of the padded lattice
    integer :: rows = 0     !! rows of the padded lattice
    type(c_ptr), private :: plans(4) = c_null_ptr
  contains
    procedure :: prepare => prepare_transforms  !! makes the plans
    procedure :: make_waves                     !! values to waves
    procedure :: sum_waves                      !! waves to values
    final :: destroy_plans
  end type plane_transform

  ! Indices of the plans.
  integer, parameter :: row_forward = 1, column_forward = 2, column_back = 3, row_back = 4

contains

  !> Makes the plans.
  subroutine prepare_transforms(self, columns, rows)
    class(plane_transform), intent(inout) :: self  !! transforms without plans
    integer, intent(in) :: columns, rows           !! size of the padded lattice
    complex(c_double_complex), allocatable, target :: waves(:)
    real(c_double), allocatable, target :: values(:)

    self%columns = columns
    self%rows = rows
    allocate (waves(max(columns, rows) + 2), values(columns + 2))
    associate (to => c_loc(waves), from => c_loc(values))
      !$omp critical (fftw_plans)
      self%plans = [ &
        fftw_plan_real_to_complex(int(columns, c_int), from, to, fftw_estimate), &
        fftw_plan_complex(int(rows, c_int), to, to, fftw_forward, fftw_estimate), &
        fftw_plan_complex(int(rows, c_int), to, to, fftw_backward, fftw_estimate), &
        fftw_plan_complex_to_real(int(columns, c_int), to, from, fftw_estimate)]
      !$omp end critical (fftw_plans)
    end associate
  end subroutine prepare_transforms

  !> Transforms values, the first columns and rows of the lattice; the others are 0.
  subroutine make_waves(self, values, waves)
    class(plane_transform), intent(in) :: self  !! transforms with plans
    real(real64), intent(in) :: values(:, :)    !! (column, row), at most the lattice
    !> (wave number in y, wave number in x); half of the wave numbers in x
    complex(real64), intent(out), target :: waves(0:, 0:)
    complex(c_double_complex), allocatable, target :: of_rows(:, :), line(:)
    real(c_double), allocatable, target :: row(:)
    integer :: i, j, m, n

    m = size(values, 1)
    n = size(values, 2)
    allocate (of_rows(0:self%columns / 2, n))
    !$omp parallel private(row, line)
    allocate (row(self%columns), source=0.0_c_double)
    allocate (line(0:self%rows - 1))
    !$omp do schedule(static)
    do j = 1, n
      row(:m) = values(:, j)
      row(m + 1:) = 0.0_c_double
      call fftw_real_to_complex(self%plans(row_forward), c_loc(row), c_loc(of_rows(0, j)))
    end do
    !$omp end do
    !$omp do schedule(static)
    do i = 0, self%columns / 2
      line(:n - 1) = of_rows(i, :)
      line(n:) = (0.0_c_double, 0.0_c_double)
      call fftw_complex(self%plans(column_forward), c_loc(line), c_loc(line))
      waves(:, i) = line
    end do
    !$omp end do
    !$omp end parallel
  end subroutine make_waves

  !> Transforms waves back, to the first columns and rows of the lattice.
  subroutine sum_waves(self, waves, values)
    class(plane_transform), intent(in) :: self     !! transforms with plans
    complex(real64), intent(in) :: waves(0:, 0:)   !! as `make_waves` has them
    real(real64), intent(out) :: values(:, :)      !! (column, row), at most the lattice
    complex(c_double_complex), allocatable, target :: of_rows(:, :), line(:)
    real(c_double), allocatable, target :: row(:)
    integer :: i, j, m, n

    m = size(values, 1)
    n = size(values, 2)
    allocate (of_rows(0:self%columns / 2, n))
    !$omp parallel private(row, line)
    allocate (row(self%columns), line(0:self%rows - 1))
    !$omp do schedule(static)
    do i = 0, self%columns / 2
      line = waves(:, i)
      call fftw_complex(self%plans(column_back), c_loc(line), c_loc(line))
      of_rows(i, :) = line(:n - 1)
    end do
    !$omp end do
    !$omp do schedule(static)
    do j = 1, n
      call fftw_complex_to_real(self%plans(row_back), c_loc(of_rows(0, j)), c_loc(row))
      values(:, j) = row(:m) / (real(self%columns, real64) * self%rows)
    end do
    !$omp end do
    !$omp end parallel
  end subroutine sum_waves

  ! Releases the plans.
  subroutine destroy_plans(self)
    type(plane_transform), intent(inout) :: self
    integer :: i

    if (.not. c_associated(self%plans(1))) return
    !$omp critical (fftw_plans)
    do i = 1, size(self%plans)
      call fftw_destroy(self%plans(i))
    end do
    !$omp end critical (fftw_plans)
    self%plans = c_null_ptr
  end subroutine destroy_plans

end module asperity_plane_transform
