!> What forces on all cells of a rectangular lattice do at all its cells, through FFTW.
!>
!> The influence depends on the offset of two cells alone. On a lattice padded with zeros to twice
!> its size the periodic images do not reach it: the sum is exact but for rounding. On a periodic
!> lattice the influence is known by its transform.
module asperity_cell_convolution
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_double_complex, c_int, c_loc, &
                                         c_null_ptr, c_ptr
  use asperity_constants, only: pi
  use asperity_fftw, only: fftw_complex_to_real, fftw_destroy, fftw_estimate, &
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
    real(c_double), allocatable :: spectrum(:, :)
    real(c_double), allocatable :: values(:, :)
    complex(c_double_complex), allocatable :: transform(:, :)
    real(c_double), allocatable :: wave_across(:)
    real(c_double), allocatable :: wave_along(:)
    type(c_ptr) :: forward = c_null_ptr
    type(c_ptr) :: backward = c_null_ptr
  contains
    procedure :: prepare
    procedure :: serves
    procedure :: prepare_periodic
    procedure :: apply
    procedure :: apply_inverse
    final :: destroy
  end type cell_convolution

contains

  !> Prepares the sum for an influence that is the same at an offset and at its mirror images.
  subroutine prepare(sum, influence)
    class(cell_convolution), intent(inout), target :: sum  !! not prepared before
    real(real64), intent(in) :: influence(0:, 0:)          !! by offset, of the lattice's size
    integer :: i, j, wide, high

    wide = padded_length(2 * size(influence, 1) - 1)
    high = padded_length(2 * size(influence, 2) - 1)
    call make_plans(sum, wide, high)
    sum%values = 0.0_c_double
    do j = 0, ubound(influence, 2)
      do i = 0, ubound(influence, 1)
        sum%values(i, j) = influence(i, j)
        sum%values(modulo(-i, wide), j) = influence(i, j)
        sum%values(i, modulo(-j, high)) = influence(i, j)
        sum%values(modulo(-i, wide), modulo(-j, high)) = influence(i, j)
      end do
    end do
    call fftw_real_to_complex(sum%forward, c_loc(sum%values), c_loc(sum%transform))
    sum%spectrum = real(sum%transform, c_double)
    ! The lattice's matrix is a part of the padded one, whose eigenvalues these are.
    sum%norm = maxval(abs(sum%spectrum))
    sum%spectrum = sum%spectrum / (real(wide, c_double) * high)
  end subroutine prepare

  !> Prepares the sum for displacements by pressures on a periodic half-space, over the modulus: a
  !> wave of number q has 2/q (Johnson, Contact Mechanics, 1985, section 13.2). The mean has 0.
  subroutine prepare_periodic(sum, columns, rows, side_x, side_y)
    class(cell_convolution), intent(inout), target :: sum  !! not prepared before
    integer, intent(in) :: columns, rows                   !! of the lattice
    real(real64), intent(in) :: side_x, side_y             !! of a cell
    integer :: i, j

    call make_plans(sum, columns, rows)
    do j = 0, rows - 1
      do i = 0, columns / 2
        sum%spectrum(i + 1, j + 1) = 0.0_real64
        if (i + j > 0) sum%spectrum(i + 1, j + 1) = 1.0_real64 / &
          (pi * hypot(i / (columns * side_x), min(j, rows - j) / (rows * side_y)))
      end do
    end do
    sum%norm = maxval(sum%spectrum)
    sum%spectrum = sum%spectrum / (real(columns, c_double) * rows)
  end subroutine prepare_periodic

  ! Room and plans for a lattice that is padded to `wide` by `high`.
  subroutine make_plans(sum, wide, high)
    class(cell_convolution), intent(inout), target :: sum
    integer, intent(in) :: wide, high
    integer :: i, j

    allocate (sum%values(0:wide - 1, 0:high - 1), sum%transform(wide / 2 + 1, high))
    allocate (sum%spectrum(wide / 2 + 1, high))
    !$omp critical (fftw_plans)
    sum%forward = fftw_plan_real_to_complex(int(high, c_int), int(wide, c_int), &
                                            c_loc(sum%values), c_loc(sum%transform), fftw_estimate)
    sum%backward = fftw_plan_complex_to_real(int(high, c_int), int(wide, c_int), &
                                             c_loc(sum%transform), c_loc(sum%values), fftw_estimate)
    !$omp end critical (fftw_plans)
    sum%wave_across = [(sin(i * pi / wide)**2, i=0, wide / 2)]
    sum%wave_along = [(sin(j * pi / high)**2, j=0, high - 1)]
  end subroutine make_plans

  !> Whether what was prepared suits a lattice: holds it, in at most one and a half times its size.
  pure logical function serves(sum, cells)
    class(cell_convolution), intent(in) :: sum  !! prepared by an influence
    integer, intent(in) :: cells(2)             !! of the lattice

    serves = all(2 * cells - 1 <= shape(sum%values)) .and. &
             real(size(sum%values), real64) <= 1.5_real64 * product(2.0_real64 * cells)
  end function serves

  !> Sums influence times force, on the lattice that it was prepared for or a smaller one.
  subroutine apply(sum, force, displacement)
    class(cell_convolution), intent(inout), target :: sum  !! prepared
    real(real64), intent(in) :: force(:, :)                !! on every cell
    real(real64), intent(out) :: displacement(:, :)        !! at every cell

    sum%values = 0.0_c_double
    sum%values(:size(force, 1) - 1, :size(force, 2) - 1) = force
    call fftw_real_to_complex(sum%forward, c_loc(sum%values), c_loc(sum%transform))
    sum%transform = sum%transform * sum%spectrum
    call fftw_complex_to_real(sum%backward, c_loc(sum%transform), c_loc(sum%values))
    displacement = sum%values(:size(force, 1) - 1, :size(force, 2) - 1)
  end subroutine apply

  !> Nearly the forces, but for a factor, that cause a displacement, for an influence like 1/r.
  !>
  !> The transform of 1/r is as 1/k, of wave number k. On a lattice k is as the root of the sum of
  !> the squares of sin(pi i/n), as for the second difference. The lowest k on the lattice is added:
  !> none is 0. So this is symmetric and positive definite, also on a part of the cells.
  subroutine apply_inverse(sum, displacement, force)
    class(cell_convolution), intent(inout), target :: sum  !! prepared
    real(real64), intent(in) :: displacement(:, :)         !! at every cell
    real(real64), intent(out) :: force(:, :)               !! on every cell
    real(real64) :: least, scale
    integer :: i, j

    sum%values = 0.0_c_double
    sum%values(:size(force, 1) - 1, :size(force, 2) - 1) = displacement
    call fftw_real_to_complex(sum%forward, c_loc(sum%values), c_loc(sum%transform))
    least = sin(pi / size(sum%values, 1))**2 + sin(pi / size(sum%values, 2))**2
    scale = 1.0_real64 / size(sum%values)
    do j = 1, size(sum%transform, 2)
      do i = 1, size(sum%transform, 1)
        sum%transform(i, j) = sum%transform(i, j) * &
          (scale * sqrt(sum%wave_across(i) + sum%wave_along(j) + least))
      end do
    end do
    call fftw_complex_to_real(sum%backward, c_loc(sum%transform), c_loc(sum%values))
    force = sum%values(:size(force, 1) - 1, :size(force, 2) - 1)
  end subroutine apply_inverse

  subroutine destroy(sum)
    type(cell_convolution), intent(inout) :: sum

    if (.not. c_associated(sum%forward)) return
    !$omp critical (fftw_plans)
    call fftw_destroy(sum%forward)
    call fftw_destroy(sum%backward)
    !$omp end critical (fftw_plans)
    sum%forward = c_null_ptr
  end subroutine destroy

  !> The least length from n on without other factors than 2, 3 and 5: FFTW is quick with those.
  pure integer function padded_length(n)
    integer, intent(in) :: n  !! 1 or more
    integer :: rest, k
    integer, parameter :: factors(3) = [2, 3, 5]

    padded_length = n
    do
      rest = padded_length
      do k = 1, size(factors)
        do while (modulo(rest, factors(k)) == 0)
          rest = rest / factors(k)
        end do
      end do
      if (rest == 1) return
      padded_length = padded_length + 1
    end do
  end function padded_length

end module asperity_cell_convolution
