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
!> integrals over elements replace the waves (`traction_influence`), on a lattice that is padded to
!> twice its size. The inverse, which only preconditions, stays that of waves: its tractions fall as
!> r**-3, so that a period longer by an eighth separates the edges of a free lattice. Unlike bodies
!> with Dundurs' beta have normal displacements by tractions, -2 i beta q_i/q**2, and tangential
!> ones of the opposite sign by pressures.
!>
!> The off-diagonal compliance of a periodic lattice is odd in both directions: it is 0 at the
!> shortest wave of an even number of elements, which has no sign. Mirrored lattices have mirrored
!> solutions then.
module asperity_traction_convolution
  use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_loc
  use asperity_constants, only: pi
  use asperity_kinds, only: int64, real64
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
    !> index of the first one of each row, and of one row more
    integer(int64), allocatable :: first(:)
  end type element_set

  ! A padded lattice, and the plans of its lines.
  type :: wave_lattice
    integer :: columns = 0, rows = 0
    type(line_transform) :: row_forward, column_forward, column_back, row_back
  end type wave_lattice

  !> The convolution for one lattice. It owns its plans: it must not be copied.
  type :: traction_convolution
    private
    real(real64), public :: diagonal = 0.0_real64  !! displacement of an element by its own traction
    type(wave_lattice) :: compliance, inverse
    ! Spectra of both over their numbers of elements, (wave number in y, in x, term). A term is even
    ! or odd along each axis: half of the wave numbers are kept in each direction.
    real(c_double), allocatable, dimension(:, :, :) :: compliances, inverses
    complex(c_double_complex), allocatable :: transform(:, :, :)  ! (wave in x, row, component)
  contains
    procedure :: prepare => prepare_tractions
    procedure :: apply => apply_tractions
    procedure :: apply_at => apply_at_elements
  end type traction_convolution

  ! Numbers of the terms: compliance or its inverse, coupling of normal and tangential parts
  ! (chosen), and their parity along x and y; 1: odd (derived from the formulas).
  integer, parameter :: xx = 1, xy = 2, yy = 3, normal_x = 4, normal_y = 5
  integer, parameter :: odd(2, 5) = reshape([0, 0, 1, 1, 0, 0, 1, 0, 0, 1], [2, 5])
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
    real(real64) :: of_bodies(3)
    integer :: i, j, padded(2)

    associate (g => 2.0_real64 / (1.0_real64 - poisson_ratio), lattice => self%compliance)
      of_bodies = [g, poisson_ratio * g, beta]
      padded = merge(elements, padded_length(2 * elements - 1), repeats)
      call prepare_lattice(lattice, self%compliances, padded, side_ratio, by_tractions, of_bodies)
      if (.not. all(repeats)) call set_elements(lattice, self%compliances, elements, side_ratio, &
                                                findloc(repeats, .true., 1), of_bodies)
      self%diagonal = 0.0_real64
      do i = 0, lattice%columns / 2
        do j = 0, lattice%rows / 2
          self%diagonal = self%diagonal + 0.5_real64 * sum(self%compliances(j, i, [xx, yy])) * &
                          merge(1, 2, i == 0 .or. 2 * i == lattice%columns) * &
                          merge(1, 2, j == 0 .or. 2 * j == lattice%rows)
        end do
      end do
    end associate
    padded = merge(elements, inverse_length(elements + elements / 8), repeats)
    call prepare_lattice(self%inverse, self%inverses, padded, side_ratio, inverse_of_tractions, &
                         of_bodies)
    allocate (self%transform(0:max(self%compliance%columns, self%inverse%columns) / 2, &
                             elements(2), 2))
  end subroutine prepare_tractions

  ! Least length from n on that is 5, 7 or 8 times a power of 2 (measured: with factors of 3, plans
  ! of FFTW that are not measured take twice the time).
  elemental integer function inverse_length(n)
    integer, intent(in) :: n
    integer :: step

    step = 2**max(0, exponent(real(n - 1)) - 3)
    inverse_length = max(5, (n + step - 1) / step)
    inverse_length = step * (inverse_length + merge(1, 0, inverse_length == 6))
  end function inverse_length

  ! Makes the plans of a lattice, and its spectrum of waves.
  subroutine prepare_lattice(lattice, spectrum, padded, side_ratio, operation, of_bodies)
    type(wave_lattice), intent(inout) :: lattice
    real(c_double), allocatable, intent(out) :: spectrum(:, :, :)
    integer, intent(in) :: padded(2), operation   ! numbers of elements; displacements or inverse
    real(real64), intent(in) :: side_ratio, of_bodies(3)  ! sides; g, m and beta
    real(real64) :: q(2), shortest
    integer :: i, j

    lattice%columns = padded(1)
    lattice%rows = padded(2)
    allocate (spectrum(0:padded(2) / 2, 0:padded(1) / 2, merge( &
      normal_y, yy, abs(of_bodies(3)) > 0.0_real64 .and. operation == by_tractions)))
    call lattice%row_forward%prepare(real_to_waves, padded(1))
    call lattice%column_forward%prepare(waves_forward, padded(2))
    call lattice%column_back%prepare(waves_back, padded(2))
    call lattice%row_back%prepare(waves_to_real, padded(1))
    do i = 0, padded(1) / 2
      do j = 0, padded(2) / 2
        q = 2.0_real64 * pi * [i / real(padded(1), real64), j / (padded(2) * side_ratio)]
        shortest = merge(0.0_real64, 1.0_real64, 2 * i == padded(1) .or. 2 * j == padded(2))
        call set_wave(spectrum(j, i, :), operation, q, shortest, of_bodies)
      end do
    end do
    spectrum(0, 0, :) = 0.0_real64
    if (operation == inverse_of_tractions) spectrum(0, 0, [xx, yy]) = 2.0_real64 * pi / &
      (max(real(padded(1), real64), padded(2) * side_ratio) * of_bodies(1))
    spectrum = spectrum / (real(padded(1), c_double) * padded(2))
  end subroutine prepare_lattice

  ! Sets the terms of one wave, which is not the mean.
  pure subroutine set_wave(term, operation, q, shortest, of_bodies)
    real(c_double), intent(out) :: term(:)
    integer, intent(in) :: operation      ! displacements or their inverse
    real(real64), intent(in) :: q(2)      ! wave number over the side
    real(real64), intent(in) :: shortest  ! factor of terms that are odd along an axis: 0 or 1
    real(real64), intent(in) :: of_bodies(3)  ! g, m and beta
    real(real64) :: c(2), even, number, of_along

    associate (g => of_bodies(1), m => of_bodies(2), beta => of_bodies(3))
      number = max(hypot(q(1), q(2)), tiny(number))
      c = q / number
      even = g / number
      of_along = -m / number
      if (operation == inverse_of_tractions) then
        even = number / g
        of_along = number * m / (g * (g - m))
      end if
      term(xx) = even + of_along * c(1)**2
      term(xy) = shortest * of_along * c(1) * c(2)
      term(yy) = even + of_along * c(2)**2
      if (size(term) > yy) term([normal_x, normal_y]) = -shortest * 2.0_real64 * beta * c / number
    end associate
  end subroutine set_wave

  ! Sets the compliance to that of elements, transformed from all offsets.
  subroutine set_elements(lattice, spectrum, elements, side_ratio, strip_axis, of_bodies)
    type(wave_lattice), intent(inout) :: lattice
    real(c_double), intent(inout) :: spectrum(0:, 0:, :)
    integer, intent(in) :: elements(2), strip_axis
    real(real64), intent(in) :: side_ratio, of_bodies(3)  ! g, m and beta
    real(real64), allocatable, dimension(:, :) :: half_x, half_y

    associate (g => of_bodies(1), m => of_bodies(2), beta => of_bodies(3))
      allocate (half_x, source=integral_over_element(of_xx, elements, side_ratio, strip_axis))
      allocate (half_y, source=integral_over_element(of_yy, elements, side_ratio, strip_axis))
      call take_table(lattice, spectrum(:, :, xx), xx, &
                      ((g - m) * half_y + g * half_x) / (2.0_real64 * pi))
      call take_table(lattice, spectrum(:, :, yy), yy, &
                      ((g - m) * half_x + g * half_y) / (2.0_real64 * pi))
      half_x = integral_over_element(of_xy, elements, side_ratio, strip_axis)
      call take_table(lattice, spectrum(:, :, xy), xy, m / (2.0_real64 * pi) * half_x)
      if (size(spectrum, 3) == yy) return
      half_x = integral_over_element(of_x, elements, side_ratio, strip_axis)
      call take_table(lattice, spectrum(:, :, normal_x), normal_x, beta / pi * half_x)
      half_x = integral_over_element(of_y, elements, side_ratio, strip_axis)
      call take_table(lattice, spectrum(:, :, normal_y), normal_y, beta / pi * half_x)
    end associate
  end subroutine set_elements

  ! Transforms a table by offset, with its parity. A term that is odd along one axis has an
  ! imaginary transform, of which the factor of i is kept.
  subroutine take_table(lattice, spectrum, term, table)
    type(wave_lattice), intent(inout) :: lattice
    real(c_double), intent(inout) :: spectrum(0:, 0:)
    integer, intent(in) :: term
    real(real64), intent(in) :: table(0:, 0:)
    real(c_double), allocatable, target :: row(:)
    complex(c_double_complex), allocatable, target :: column(:), other(:), waves(:, :)
    integer :: i, j, n(2), sign_of(2)

    n = shape(table)
    sign_of = 1 - 2 * odd(:, term)
    allocate (row(0:lattice%columns - 1), source=0.0_c_double)
    allocate (column(0:lattice%rows - 1), other(0:lattice%rows - 1), &
              waves(0:lattice%columns / 2, 0:n(2) - 1))
    do j = 0, n(2) - 1
      row(:n(1) - 1) = table(:, j)
      if (lattice%columns > n(1)) row(lattice%columns - n(1) + 1:) = sign_of(1) * &
                                                                     table(n(1) - 1:1:-1, j)
      call lattice%row_forward%apply(c_loc(row), c_loc(waves(0, j)))
    end do
    do i = 0, lattice%columns / 2
      column = (0.0_c_double, 0.0_c_double)
      column(:n(2) - 1) = waves(i, :)
      if (lattice%rows > n(2)) column(lattice%rows - n(2) + 1:) = sign_of(2) * column(n(2) - 1:1:-1)
      call lattice%column_forward%apply(c_loc(column), c_loc(other))
      if (sum(odd(:, term)) == 1) other = -i_unit * other
      spectrum(:, i) = real(other(:lattice%rows / 2), c_double) / &
                       (real(lattice%columns, c_double) * lattice%rows)
    end do
  end subroutine take_table

  !> Convolves fields on the lattice of the preparation. Two components are those along x and y;
  !> pressures and normal displacements have one.
  subroutine apply_tractions(self, from, to, operation)
    class(traction_convolution), intent(inout) :: self  !! convolution with its plans
    real(real64), intent(in) :: from(:, :, :)   !! (column, row, component)
    real(real64), intent(out) :: to(:, :, :)    !! (column, row, component)
    integer, intent(in) :: operation            !! what is computed
    type(element_set) :: every
    logical, allocatable :: marks(:, :)
    real(real64), allocatable :: values(:, :), given(:, :)
    integer :: c

    allocate (marks(size(to, 1), size(to, 2)), source=.true.)
    call list_elements(marks, every)
    allocate (values(size(marks, kind=int64), size(to, 3)), &
              given(size(marks, kind=int64), size(from, 3)))
    do c = 1, size(from, 3)
      given(:, c) = pack(from(:, :, c), marks)
    end do
    call self%apply_at(every, given, values, operation)
    do c = 1, size(to, 3)
      to(:, :, c) = unpack(values(:, c), marks, 0.0_real64)
    end do
  end subroutine apply_tractions

  !> The same for values on some elements, 0 on the others: rows without one are not transformed.
  subroutine apply_at_elements(self, set, from, to, operation)
    class(traction_convolution), intent(inout), target :: self  !! convolution with its plans
    type(element_set), intent(in) :: set        !! elements of the lattice
    real(real64), intent(in) :: from(:, :)      !! (element, component along x and y)
    real(real64), intent(out) :: to(:, :)       !! (element, component along x and y)
    integer, intent(in) :: operation            !! what is computed

    if (operation == inverse_of_tractions) then
      call convolve_elements(self%inverse, self%inverses, self%transform, set, from, to, operation)
    else
      call convolve_elements(self%compliance, self%compliances, self%transform, set, from, to, &
                             operation)
    end if
  end subroutine apply_at_elements

  ! Convolves values on some elements with a spectrum.
  subroutine convolve_elements(lattice, spectrum, transform, set, from, to, operation)
    type(wave_lattice), intent(in) :: lattice
    real(c_double), intent(in) :: spectrum(0:, 0:, :)
    complex(c_double_complex), intent(inout), target :: transform(0:, :, :)
    type(element_set), intent(in) :: set
    real(real64), intent(in) :: from(:, :)
    real(real64), intent(out) :: to(:, :)
    integer, intent(in) :: operation
    real(c_double), allocatable, target :: row(:)
    integer :: c, j, rows

    rows = size(set%first) - 1
    !$omp parallel private(row, c) if(size(transform, kind=int64) > thread_threshold)
    allocate (row(lattice%columns))
    do c = 1, size(from, 2)
      !$omp do schedule(static)
      do j = 1, rows
        associate (first => set%first(j), last => set%first(j + 1) - 1)
          if (last < first) then
            transform(:, j, c) = (0.0_c_double, 0.0_c_double)
          else
            row = 0.0_c_double
            row(set%column(first:last)) = from(first:last, c)
            call lattice%row_forward%apply(c_loc(row), c_loc(transform(0, j, c)))
          end if
        end associate
      end do
      !$omp end do
    end do
    !$omp end parallel
    call convolve_columns(lattice, spectrum, transform, size(from, 2), size(to, 2), operation)
    !$omp parallel private(row, c) if(size(transform, kind=int64) > thread_threshold)
    allocate (row(lattice%columns))
    do c = 1, size(to, 2)
      !$omp do schedule(static)
      do j = 1, rows
        associate (first => set%first(j), last => set%first(j + 1) - 1)
          if (last >= first) then
            call lattice%row_back%apply(c_loc(transform(0, j, c)), c_loc(row))
            to(first:last, c) = row(set%column(first:last))
          end if
        end associate
      end do
      !$omp end do
    end do
    !$omp end parallel
  end subroutine convolve_elements

  !> Lists the marked elements of a lattice.
  pure subroutine list_elements(marks, set)
    logical, intent(in) :: marks(:, :)       !! (column, row) of the lattice
    type(element_set), intent(out) :: set    !! the marked elements
    integer(int64) :: number
    integer :: i, j

    allocate (set%column(count(marks, kind=int64)), set%first(size(marks, 2) + 1))
    number = 0_int64
    do j = 1, size(marks, 2)
      set%first(j) = number + 1_int64
      do i = 1, size(marks, 1)
        if (.not. marks(i, j)) cycle
        number = number + 1_int64
        set%column(number) = i
      end do
    end do
    set%first(size(set%first)) = number + 1_int64
  end subroutine list_elements

  ! Transforms the rows' waves along the columns, multiplies, and transforms them back. The bytes of
  ! the result do not depend on the number of threads: each column belongs to one of them.
  subroutine convolve_columns(lattice, spectrum, transform, components_from, components_to, &
                              operation)
    type(wave_lattice), intent(in) :: lattice
    real(c_double), intent(in) :: spectrum(0:, 0:, :)
    complex(c_double_complex), intent(inout) :: transform(0:, :, :)  ! (wave in x, row, component)
    integer, intent(in) :: components_from, components_to, operation
    complex(c_double_complex), allocatable, target :: column(:, :, :), waves(:, :)
    integer :: c, i, j, k, last, n

    n = size(transform, 2)
    !$omp parallel private(column, waves, c, j, k, last) &
    !$omp if(size(transform, kind=int64) > thread_threshold)
    allocate (column(0:lattice%rows - 1, 0:block_columns - 1, 2), waves(0:lattice%rows - 1, 2))
    !$omp do schedule(static)
    do i = 0, lattice%columns / 2, block_columns
      last = min(block_columns - 1, lattice%columns / 2 - i)
      do c = 1, components_from
        do j = 1, n
          column(j - 1, :last, c) = transform(i:i + last, j, c)
        end do
      end do
      do k = 0, last
        do c = 1, components_from
          column(n:, k, c) = (0.0_c_double, 0.0_c_double)
          call lattice%column_forward%apply(c_loc(column(0, k, c)), c_loc(waves(0, c)))
        end do
        call multiply_waves(spectrum, i + k, operation, waves)
        do c = 1, components_to
          call lattice%column_back%apply(c_loc(waves(0, c)), c_loc(column(0, k, c)))
        end do
      end do
      do c = 1, components_to
        do j = 1, n
          transform(i:i + last, j, c) = column(j - 1, :last, c)
        end do
      end do
    end do
    !$omp end do nowait
    !$omp end parallel
  end subroutine convolve_columns

  ! Multiplies the waves of one column: the upper half mirrors the lower one.
  pure subroutine multiply_waves(term, i, operation, waves)
    real(c_double), intent(in) :: term(0:, 0:, :)
    integer, intent(in) :: i, operation
    complex(c_double_complex), intent(inout), contiguous :: waves(0:, :)
    complex(c_double_complex) :: first
    integer :: j, k, rows

    rows = size(waves, 1)
    select case (operation)
    case (normal_by_tractions)
      do j = 0, rows - 1
        k = min(j, rows - j)
        waves(j, 1) = i_unit * (term(k, i, normal_x) * waves(j, 1) + &
                                sign(1, k - j) * term(k, i, normal_y) * waves(j, 2))
      end do
    case (tangential_by_pressures)
      do j = 0, rows - 1
        k = min(j, rows - j)
        waves(j, 2) = -i_unit * (sign(1, k - j) * term(k, i, normal_y)) * waves(j, 1)
        waves(j, 1) = -i_unit * term(k, i, normal_x) * waves(j, 1)
      end do
    case default
      do k = 0, rows / 2
        first = waves(k, 1)
        waves(k, 1) = term(k, i, xx) * first + term(k, i, xy) * waves(k, 2)
        waves(k, 2) = term(k, i, xy) * first + term(k, i, yy) * waves(k, 2)
      end do
      do k = 1, (rows - 1) / 2
        j = rows - k
        first = waves(j, 1)
        waves(j, 1) = term(k, i, xx) * first - term(k, i, xy) * waves(j, 2)
        waves(j, 2) = term(k, i, yy) * waves(j, 2) - term(k, i, xy) * first
      end do
    end select
  end subroutine multiply_waves

end module asperity_traction_convolution
