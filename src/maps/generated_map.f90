!> Self-affine random height maps from a specification.
!>
!> The components of `asperity_map_waves` are transformed in whole numbers, first along y, then
!> along x, two rows as one complex row. A free map is a part of a periodic one of at least twice
!> its size along x and y: its edges do not fit, and it has waves longer than itself.
!>
!> The rms height or the rms slope is exact for the map that is made, not for the mean of all seeds:
!> all heights are multiplied by one number. The rms height is that of the pixels about their mean,
!> which is subtracted. The rms slope is the root of the mean of (dh/dx)**2 + (dh/dy)**2 over the
!> pixels, where h is the sum of waves: that of differences is smaller. On a periodic map its square
!> is the sum of q**2 |a(q)|**2 (Parseval).
module asperity_generated_map
  use asperity_constants, only: pi_128
  use asperity_decimal, only: decimal_to_real64
  use asperity_generation_values, only: map_spec
  use asperity_height_map, only: fault_of_map, free_edge, height_map, highest, largest_height, &
                                 length_units, periodic_edge
  use asperity_kinds, only: int128, int64, real128, real64
  use asperity_map_waves, only: draw_waves, map_waves, plan_waves
  use asperity_problems, only: decimal_text, not_enough_memory
  use asperity_process, only: has_memory
  use asperity_whole_fourier, only: imaginary_part, prepare_fourier, real_part, transform_wholes, &
                                    whole_fourier
  implicit none
  private

  public :: generate_map, try_map

  ! Quantity to sum: 0 the heights, 1 the slopes along x, 2 the slopes along y.
  integer, parameter :: of_heights = 0
  ! Heights are below 2**58: the sum of 2**8 of their squares is below 2**124.
  integer, parameter :: spare_bits = 8
  ! Rows that are copied together, an even number: they share lines of the cache.
  integer, parameter :: rows_together = 8

contains

  !> Makes a map. `failure` is allocated, with the reason, when that cannot be done.
  subroutine generate_map(spec, map, failure)
    type(map_spec), intent(in) :: spec                      !! specification, checked for faults
    type(height_map), intent(out) :: map                    !! its heights have the mean 0
    character(len=:), allocatable, intent(out) :: failure   !! why there is no map
    type(map_waves) :: waves
    type(whole_fourier) :: along(2)
    integer(int64), allocatable :: components(:, :, :)
    real(real128) :: mean, mean_square, square
    real(real64) :: factor, offset
    integer :: i

    call plan_waves(spec, waves)
    if (waves%empty) then
      failure = 'the map has no wave between the cut-off and the roll-off'
      return
    end if
    if (.not. has_memory(bytes_of_map(waves, spec))) then
      failure = not_enough_memory // ' for the map, ' // decimal_text(spec%pixels(1)) // ' x ' // &
                decimal_text(spec%pixels(2)) // ' pixels'
      return
    end if
    map%columns = spec%pixels(1)
    map%rows = spec%pixels(2)
    map%pixel_spacing = decimal_to_real64(spec%pixel_spacing)
    map%unit = ''
    if (spec%unit > 0) map%unit = trim(length_units(spec%unit))
    map%periodic = spec%periodic
    map%edge = merge(periodic_edge, free_edge, spec%periodic)
    allocate (map%height(map%columns, map%rows))
    allocate (components(2, 0:waves%period(2) - 1, 0:waves%most(1)))
    do i = 1, 2
      call prepare_fourier(waves%period(i), along(i))
    end do
    if (spec%of_slope) then
      mean_square = 0.0_real128
      do i = 1, 2
        call sum_waves(waves, along, i, components, map, mean, square)
        mean_square = mean_square + square * (2 * pi_128 / waves%side(i))**2
      end do
      call sum_waves(waves, along, of_heights, components, map, mean, square)
    else
      call sum_waves(waves, along, of_heights, components, map, mean, square)
      mean_square = square - mean**2
    end if
    if (.not. mean_square > 0.0_real128) then
      failure = 'the map is flat'
      return
    end if
    factor = real(spec%rms / sqrt(mean_square), real64)
    offset = real(mean, real64)
    map%height = (map%height - offset) * factor
    map%digit = spacing(largest_height(map))
    failure = fault_of_map(map)
    if (largest_height(map) > highest) failure = 'heights beyond 1e30, expected a lower rms value'
    if (failure == '') deallocate (failure)
  end subroutine generate_map

  !> Does a few equal pieces of the work of a map, for an estimate of its cost.
  subroutine try_map(spec, tried, total, begun, bytes)
    type(map_spec), intent(in) :: spec         !! specification, checked for faults
    integer, intent(inout) :: tried            !! pieces to be done; those that were done
    integer, intent(out) :: total              !! pieces of the whole map
    real(real64), intent(out) :: begun         !! processor time when the first piece begins, s
    integer(int64), intent(out) :: bytes       !! memory that the map takes
    type(map_waves) :: waves
    type(whole_fourier) :: along(2)
    integer(int64), allocatable :: components(:, :), row(:, :), work(:, :)
    integer :: i, j, k

    call plan_waves(spec, waves)
    do k = 1, 2
      call prepare_fourier(waves%period(k), along(k))
    end do
    allocate (components(2, 0:waves%period(2) - 1), row(2, 0:waves%period(1) - 1))
    allocate (work(2, 0:maxval(waves%period) - 1))
    row = 0_int64
    tried = min(tried, waves%most(1) + 1)
    call cpu_time(begun)
    do i = 1, tried
      ! The columns are spread evenly over the map; each has its share of the rows.
      call draw_waves(waves, waves%most(1) * (i - 1) / tried, components)
      call transform_wholes(along(2), components, work)
      do j = 1, spec%pixels(2) / (2 * waves%most(1) + 2)
        call transform_wholes(along(1), row, work)
      end do
    end do
    total = merge(3, 1, spec%of_slope) * (waves%most(1) + 1)
    bytes = bytes_of_map(waves, spec)
  end subroutine try_map

  ! Memory that a map takes while it is made, in bytes: components, heights and the rows of many
  ! threads.
  pure integer(int64) function bytes_of_map(waves, spec)
    type(map_waves), intent(in) :: waves
    type(map_spec), intent(in) :: spec

    bytes_of_map = 16_int64 * waves%period(2) * (waves%most(1) + 1_int64) + &
                   8_int64 * spec%pixels(1) * spec%pixels(2) + 4096_int64 * maxval(waves%period)
  end function bytes_of_map

  ! Sums the waves at all pixels: the heights of the map, or a slope of which only the sums are
  ! returned. A unit is that of the components.
  subroutine sum_waves(waves, along, which, components, map, mean, square)
    type(map_waves), intent(in) :: waves
    type(whole_fourier), intent(in) :: along(2)
    integer, intent(in) :: which
    integer(int64), intent(inout) :: components(:, 0:, 0:)
    type(height_map), intent(inout) :: map
    real(real128), intent(out) :: mean, square
    integer(int64), allocatable :: work(:, :), row(:, :), block(:, :, :)
    integer(int128) :: numbers, squares
    integer(int64) :: half, pixels
    integer :: i, j, k, first, lines, lost, order

    ! Number of bits of the largest wave number.
    order = 0
    if (which > of_heights) order = bit_size(order) - leadz(waves%most(which))
    ! Bits that a number loses before it is squared, so that the sum of all squares fits.
    pixels = size(map%height, kind=int64)
    lost = max(0, bit_size(lost) * 2 - leadz(pixels) - spare_bits + 1) / 2
    half = shiftr(shiftl(1_int64, lost), 1)
    numbers = 0_int128
    squares = 0_int128
    !$omp parallel private(work, row, block, lines, j, k) reduction(+:numbers, squares)
    allocate (work(2, 0:maxval(waves%period) - 1), row(2, 0:waves%period(1) - 1))
    allocate (block(2, 0:rows_together - 1, 0:waves%most(1)))
    !$omp do schedule(static)
    do i = 0, waves%most(1)
      call draw_waves(waves, i, components(:, :, i))
      if (which > of_heights) call derive_slope(components(:, :, i), i, which, order)
      call transform_wholes(along(2), components(:, :, i), work)
    end do
    !$omp end do
    !$omp do schedule(static)
    do first = 0, map%rows - 1, rows_together
      lines = min(rows_together, map%rows - first)
      block = 0_int64
      block(:, :lines - 1, :) = components(:, first:first + lines - 1, :)
      do j = 0, lines - 1, 2
        call pack_rows(block(:, j:j + 1, :), row)
        call transform_wholes(along(1), row, work)
        do k = 1, min(2, lines - j)
          associate (height => row(k, :map%columns - 1))
            numbers = numbers + sum(int(height, int128))
            squares = squares + sum(square_of(shifta(height + half, lost)))
            if (which == of_heights) map%height(:, first + j + k) = real(height, real64)
          end associate
        end do
      end do
    end do
    !$omp end do
    !$omp end parallel
    mean = real(numbers, real128) / pixels
    square = real(squares, real128) / pixels * 4.0_real128**(lost + order)
  end subroutine sum_waves

  ! A product: flang-19 has no powers of whole numbers of 128 bits.
  elemental integer(int128) function square_of(number)
    integer(int64), intent(in) :: number

    square_of = int(number, int128) * number
  end function square_of

  ! Turns the components a of heights into those of a slope, i k a, over 2**order.
  pure subroutine derive_slope(components, wave, which, order)
    integer(int64), intent(inout) :: components(:, 0:)  ! by wave number along y modulo the period
    integer, intent(in) :: wave, which, order           ! wave number along x; slope along x or y
    integer(int128) :: number, derivative(2)
    integer :: j

    do j = 0, ubound(components, 2)
      number = wave
      if (which == 2) number = merge(j, j - size(components, 2), 2 * j < size(components, 2))
      derivative = number * [-components(imaginary_part, j), components(real_part, j)]
      components(:, j) = int(shifta(derivative, order), int64)
    end do
  end subroutine derive_slope

  ! Combines two rows of real numbers into one of complex numbers, r_1 + i r_2. Half of the
  ! components of a row are the conjugates of the other half.
  pure subroutine pack_rows(rows, row)
    integer(int64), intent(in) :: rows(:, :, 0:)  ! part, which row, wave number along x
    integer(int64), intent(out) :: row(:, 0:)     ! part, wave number along x modulo the period
    integer :: i

    row = 0_int64
    row(:, 0) = rows(:, 1, 0) + [-rows(imaginary_part, 2, 0), rows(real_part, 2, 0)]
    do i = 1, ubound(rows, 3)
      row(:, i) = rows(:, 1, i) + [-rows(imaginary_part, 2, i), rows(real_part, 2, i)]
      row(:, size(row, 2) - i) = [rows(real_part, 1, i), -rows(imaginary_part, 1, i)] + &
                                 [rows(imaginary_part, 2, i), rows(real_part, 2, i)]
    end do
  end subroutine pack_rows

end module asperity_generated_map
