!> Power spectral densities of a height map.
!>
!> With h(q) = sum over pixels of h w exp(-i q.(x, y)) dx dy on a map of sides L_x, L_y
!>
!>   C(q)     = |h(q_x, q_y)|**2/(L_x L_y)     two-dimensional, averaged over rings of |q|
!>   C_1D(q)  = |h(q)|**2/L                    of a line along x or y, averaged over all lines
!>
!> (T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5 (2017) 013001). So the
!> mean square of h is the sum of C over all q, over L_x L_y, and that of a line is twice the sum of
!> C_1D over q > 0, over L.
!>
!> A periodic map has w = 1. A free map has a Hann window, whose mean square is 1: of lines w in
!> proportion to 1 - cos(2 pi i/n), on the heights less the mean of their line; of the area w in
!> proportion to 1 + cos(pi r/R) within the circle of radius R, half of the shorter side, about
!> pixel (n_x/2, n_y/2).
!>
!> Rings are those of SurfaceTopography 1.27: their edges, 10 for each decade and 10 more, are
!> equally spaced in the logarithm of q from the smallest wave number of the map to the lower one of
!> its two Nyquist wave numbers, pi over the spacing, and 0.01 decades beyond both. Corners of the
!> (q_x, q_y) plane are left out. Lines have the wave numbers below the Nyquist wave number.
module asperity_map_spectrum
  use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_loc
  use asperity_constants, only: pi
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: int64, real64
  use asperity_line_transform, only: line_transform, real_to_waves, waves_forward
  use asperity_problems, only: decimal_text, problem_list
  use asperity_process, only: check_memory
  implicit none
  private

  public :: power_spectrum, measure_spectra, spectrum_names

  !> Names of the spectra: of the area, averaged over rings; of lines along x; along y.
  character(len=*), parameter :: spectrum_names(3) = [character(len=3) :: 'iso', 'x', 'y']

  !> One spectrum.
  type :: power_spectrum
    real(real64), allocatable :: q(:)  !! wave number, 2 pi over the wavelength; mean of a ring
    real(real64), allocatable :: c(:)  !! density, length**4 of the area, length**3 of lines
    !> how many values were averaged: wave vectors, or lines; 2147483647: so many, or more
    integer, allocatable :: number(:)
  end type power_spectrum

  ! Edges for each decade, and decades beyond the ends (SurfaceTopography 1.27, make_grid).
  integer, parameter :: edges_of_decade = 10
  real(real64), parameter :: decades_beyond = 0.01_real64
  real(real64), parameter :: slack = 1.0e-6_real64  ! rounding of a number of edges

contains

  !> Measures the three spectra of a map as it is: levelled, if it has to be.
  subroutine measure_spectra(name, map, spectra, problems, failure)
    character(len=*), intent(in) :: name                    !! name of the map, for a message
    type(height_map), intent(in) :: map                     !! no pixel may be missing
    type(power_spectrum), intent(out) :: spectra(3)  !! spectra in the order of `spectrum_names`
    type(problem_list), intent(inout) :: problems           !! what is wrong
    character(len=:), allocatable, intent(out) :: failure   !! why there are none
    integer(int64) :: missing
    integer :: row

    missing = 0_int64
    do row = 1, map%rows
      missing = missing + count(.not. is_measured(map%height(:, row)), kind=int64)
    end do
    if (missing > 0_int64) then
      call problems%add(name // ': found ' // decimal_text(missing) // ' missing pixels, ' // &
                        'expected none, as a power spectrum needs all heights')
      return
    end if
    call check_memory('the power spectrum', failure, &
                      bytes=16_int64 * (map%columns / 2 + 1) * map%rows)
    if (allocated(failure)) then
      failure = name // ': ' // failure
      return
    end if
    call measure_area(map, spectra(1))
    call measure_lines(map, 1, spectra(2))
    call measure_lines(map, 2, spectra(3))
  end subroutine measure_spectra

  ! Spectrum of lines along x or y, with the window 1 or Hann's with the mean square 1.
  subroutine measure_lines(map, along, spectrum)
    type(height_map), intent(in) :: map
    integer, intent(in) :: along
    type(power_spectrum), intent(out) :: spectrum
    real(c_double), allocatable, target :: line(:)
    complex(c_double_complex), allocatable, target :: waves(:)
    real(real64), allocatable :: window(:)
    type(line_transform) :: transform
    integer :: i, k, n, lines, last

    n = merge(map%columns, map%rows, along == 1)
    lines = merge(map%rows, map%columns, along == 1)
    last = (n - 1) / 2
    allocate (line(n), waves(0:n / 2), window(n))
    allocate (spectrum%q(last), spectrum%c(last), spectrum%number(last))
    window(:) = 1.0_real64
    if (.not. map%periodic) then
      window(:) = [(1.0_real64 - cos(2 * pi * i / n), i=0, n - 1)]
      window(:) = window * sqrt(n / sum(window**2))
    end if
    call transform%prepare(real_to_waves, n)
    spectrum%q(:) = [(2 * pi * k / (n * map%pixel_spacing(along)), k=1, last)]
    spectrum%c(:) = 0.0_real64
    do i = 1, lines
      if (along == 1) then
        line = map%height(:, i)
      else
        line = map%height(i, :)
      end if
      line = (line - sum(line) / n) * window
      call transform%apply(c_loc(line), c_loc(waves))
      spectrum%c = spectrum%c + real(waves(1:last))**2 + aimag(waves(1:last))**2
    end do
    spectrum%c = spectrum%c * map%pixel_spacing(along) / n / lines
    spectrum%number(:) = lines
  end subroutine measure_lines

  ! Spectrum of the area, averaged over rings.
  subroutine measure_area(map, spectrum)
    type(height_map), intent(in) :: map
    type(power_spectrum), intent(out) :: spectrum
    real(c_double), allocatable, target :: row(:)
    complex(c_double_complex), allocatable, target :: waves(:, :), column(:), other(:)
    type(line_transform) :: columns, rows
    real(real64) :: mean_square
    integer :: i, j

    allocate (waves(0:map%columns / 2, 0:map%rows - 1))
    call rows%prepare(real_to_waves, map%columns)
    call columns%prepare(waves_forward, map%rows)
    mean_square = 1.0_real64
    if (.not. map%periodic) then
      mean_square = 0.0_real64
      do j = 1, map%rows
        mean_square = mean_square + sum(area_window(map, j)**2)
      end do
      mean_square = mean_square / map%columns / map%rows
    end if
    !$omp parallel private(row, column, other)
    allocate (row(map%columns), column(0:map%rows - 1), other(0:map%rows - 1))
    !$omp do schedule(static)
    do j = 1, map%rows
      row = map%height(:, j)
      if (.not. map%periodic) row = row * area_window(map, j)
      call rows%apply(c_loc(row), c_loc(waves(0, j - 1)))
    end do
    !$omp end do
    !$omp do schedule(static)
    do i = 0, map%columns / 2
      column = waves(i, :)
      call columns%apply(c_loc(column), c_loc(other))
      waves(i, :) = other
    end do
    !$omp end do nowait
    !$omp end parallel
    call average_rings(map, waves, spectrum)
    spectrum%c = spectrum%c * &
      map%pixel_spacing(1) * map%pixel_spacing(2) / mean_square / map%columns / map%rows
  end subroutine measure_area

  ! Hann's window of one row of the area.
  pure function area_window(map, row) result(window)
    type(height_map), intent(in) :: map
    integer, intent(in) :: row
    real(real64) :: window(map%columns)
    real(real64) :: radius, r
    integer :: i

    radius = minval(map%pixel_spacing * [map%columns, map%rows]) / 2
    do i = 1, map%columns
      r = hypot(map%pixel_spacing(1) * (i - 1 - map%columns / 2), &
                map%pixel_spacing(2) * (row - 1 - map%rows / 2))
      window(i) = 0.0_real64
      if (r <= radius) window(i) = 1.0_real64 + cos(pi * r / radius)
    end do
  end function area_window

  ! Means of |h(q)|**2 over rings; half of the plane stands for the other half.
  subroutine average_rings(map, waves, spectrum)
    type(height_map), intent(in) :: map
    complex(real64), intent(in) :: waves(0:, 0:)
    type(power_spectrum), intent(out) :: spectrum
    real(real64), allocatable :: edges(:), places(:), squares(:)
    integer(int64), allocatable :: numbers(:)
    real(real64) :: step(2), low, width, q
    integer :: i, j, k, number, twice

    step = 2 * pi / (map%pixel_spacing * [map%columns, map%rows])
    low = log10(minval(step))
    width = log10(pi / maxval(map%pixel_spacing)) - low
    number = ceiling((width + 1.0_real64) * edges_of_decade - slack) - 1
    low = low - decades_beyond
    width = (width + 2.0_real64 * decades_beyond) / number
    allocate (edges(number + 1), places(number), squares(number), numbers(number))
    edges(:) = [(10.0_real64**(low + k * width), k=0, number)]
    places = 0.0_real64
    squares = 0.0_real64
    numbers = 0_int64
    do j = 0, map%rows - 1
      do i = merge(1, 0, j == 0), map%columns / 2
        q = hypot(step(1) * i, step(2) * min(j, map%rows - j))
        if (q > edges(number + 1)) cycle
        ! The ring between edges k and k + 1, the upper one included.
        k = max(1, min(number, 1 + int((log10(q) - low) / width)))
        if (q > edges(k + 1)) k = k + 1
        if (q <= edges(k)) k = k - 1
        twice = merge(1, 2, i == 0 .or. 2 * i == map%columns)
        numbers(k) = numbers(k) + twice
        places(k) = places(k) + twice * q
        squares(k) = squares(k) + twice * (real(waves(i, j))**2 + aimag(waves(i, j))**2)
      end do
    end do
    associate (filled => numbers > 0_int64)
      spectrum%number = int(min(pack(numbers, filled), int(huge(1), int64)))
      spectrum%q = pack(places / max(1_int64, numbers), filled)
      spectrum%c = pack(squares / max(1_int64, numbers), filled)
    end associate
  end subroutine average_rings

end module asperity_map_spectrum
