!> Self-affine random height maps from a specification.
!>
!> The components of `asperity_map_waves` are transformed with FFTW, first along y, then along x:
!> two machines differ by rounding. A free map is a part of a periodic one of at least twice
!> its size along x and y: its edges do not fit, and it has waves longer than itself.
!>
!> The rms height or the rms slope is exact for the map that is made, not for the mean of all seeds:
!> all heights are multiplied by one number. The rms height is that of the pixels about their mean,
!> which is subtracted. The rms slope is the root of the mean of (dh/dx)**2 + (dh/dy)**2 over the
!> pixels, where h is the sum of waves: that of differences is smaller. On a periodic map its square
!> is the sum of q**2 |a(q)|**2 (Parseval).
module asperity_generated_map
  use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_loc
  use asperity_constants, only: pi
  use asperity_generation_values, only: map_spec
  use asperity_height_map, only: check_heights, free_edge, height_map, highest, largest_height, &
                                 length_units, periodic_edge
  use asperity_kinds, only: int64, real64
  use asperity_line_transform, only: back_in_place, line_transform, waves_to_real
  use asperity_map_waves, only: draw_waves, map_waves, plan_waves
  use asperity_problems, only: decimal_text
  use asperity_process, only: check_memory
  implicit none
  private

  public :: generate_map

  ! Quantity to sum: 0 the heights, 1 the slopes along x, 2 the slopes along y.
  integer, parameter :: of_heights = 0
  ! Rows that are copied together: they share lines of the cache (chosen).
  integer, parameter :: rows_together = 8

contains

  !> Makes a map. `failure` is allocated, with the reason, when that cannot be done.
  subroutine generate_map(spec, map, failure)
    type(map_spec), intent(in) :: spec                      !! specification, checked for faults
    type(height_map), intent(out) :: map                    !! its heights have the mean 0
    character(len=:), allocatable, intent(out) :: failure   !! why there is no map
    type(map_waves) :: waves
    real(real64) :: mean, mean_square, square
    integer :: i

    call plan_waves(spec, waves)
    if (waves%empty) then
      failure = 'the map has no wave between the cut-off and the roll-off'
      return
    end if
    call check_memory('the map, ' // decimal_text(spec%pixels(1)) // ' x ' // &
                      decimal_text(spec%pixels(2)) // ' pixels', failure, &
                      bytes=bytes_of_map(waves, spec))
    if (allocated(failure)) return
    map%columns = spec%pixels(1)
    map%rows = spec%pixels(2)
    map%pixel_spacing = spec%pixel_spacing
    map%unit = ''
    if (spec%unit > 0) map%unit = trim(length_units(spec%unit))
    map%periodic = spec%periodic
    map%edge = merge(periodic_edge, free_edge, spec%periodic)
    allocate (map%height(map%columns, map%rows))
    mean_square = 0.0_real64
    if (spec%of_slope) then
      do i = 1, 2
        call sum_waves(waves, i, map, mean, square)
        mean_square = mean_square + square * real((2 * pi / waves%side(i))**2, real64)
      end do
    end if
    call sum_waves(waves, of_heights, map, mean, square)
    if (.not. spec%of_slope) mean_square = square - mean**2
    if (.not. mean_square > 0.0_real64) then
      failure = 'the map is flat'
      return
    end if
    map%height = (map%height - mean) * real(spec%rms / sqrt(mean_square), real64)
    map%digit = spacing(largest_height(map))
    call check_heights(map, failure)
    if (largest_height(map) > highest) failure = 'heights beyond 1e30, expected a lower rms value'
    if (failure == '') deallocate (failure)
  end subroutine generate_map

  ! Memory that a map takes while it is made, in bytes: components, heights and the rows of many
  ! threads.
  pure integer(int64) function bytes_of_map(waves, spec)
    type(map_waves), intent(in) :: waves
    type(map_spec), intent(in) :: spec

    bytes_of_map = 16_int64 * waves%period(2) * (waves%most(1) + 1_int64) + &
                   8_int64 * spec%pixels(1) * spec%pixels(2) + 4096_int64 * maxval(waves%period)
  end function bytes_of_map

  ! Sums the waves at all pixels: the heights of the map, or a slope of which only mean and mean
  ! square are returned, over 2 pi/side. Sums are made row by row: threads do not change them.
  subroutine sum_waves(waves, which, map, mean, square)
    type(map_waves), intent(in) :: waves
    integer, intent(in) :: which
    type(height_map), intent(inout) :: map
    real(real64), intent(out) :: mean, square
    complex(c_double_complex), allocatable, target :: components(:, :), rows(:, :)
    real(c_double), allocatable, target :: heights(:)
    real(real64) :: row_means(map%rows), row_squares(map%rows)
    type(line_transform) :: columns, rows_to_pixels
    integer :: first, i, j

    allocate (components(0:waves%period(2) - 1, 0:waves%most(1)))
    call columns%prepare(back_in_place, waves%period(2))
    call rows_to_pixels%prepare(waves_to_real, waves%period(1))
    !$omp parallel private(rows, heights, j)
    allocate (rows(0:waves%period(1) / 2, rows_together), heights(waves%period(1)))
    !$omp do schedule(static)
    do i = 0, waves%most(1)
      call draw_waves(waves, i, components(:, i))
      ! The components a of heights become those of a slope, i k a.
      if (which == 1) components(:, i) = cmplx(0, i, real64) * components(:, i)
      do j = 0, merge(waves%period(2), 0, which == 2) - 1
        components(j, i) = components(j, i) * &
          cmplx(0, merge(j, j - waves%period(2), 2 * j < waves%period(2)), real64)
      end do
      call columns%apply(c_loc(components(0, i)), c_loc(components(0, i)))
    end do
    !$omp end do
    !$omp do schedule(static)
    do first = 1, map%rows, rows_together
      rows = (0.0_real64, 0.0_real64)
      do i = 0, waves%most(1)
        do j = 1, min(rows_together, map%rows - first + 1)
          rows(i, j) = components(first + j - 2, i)
        end do
      end do
      do j = 1, min(rows_together, map%rows - first + 1)
        call rows_to_pixels%apply(c_loc(rows(0, j)), c_loc(heights))
        associate (row => heights(:map%columns))
          row_means(first + j - 1) = sum(row) / map%columns
          row_squares(first + j - 1) = sum(row**2) / map%columns
          if (which == of_heights) map%height(:, first + j - 1) = row
        end associate
      end do
    end do
    !$omp end do nowait
    !$omp end parallel
    mean = sum(row_means) / map%rows
    square = sum(row_squares) / map%rows
  end subroutine sum_waves

end module asperity_generated_map
