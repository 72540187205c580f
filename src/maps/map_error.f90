!> Estimated error of the contact of a height map by the size of its pixels.
!>
!> The map is solved again on every second pixel along both sides: on the odd ones, and on the even
!> ones. With d the larger difference of a result from that on all pixels, the errors are 0.7 d of
!> the separation at a load and of the load at a separation, and the larger of d and half the
!> correction of the rim of the area (measured on balls, cones, waves and self-affine maps against
!> closed forms and grids 8 times finer: at least 95 % of 280 errors are below the estimate, whose
!> median is 5 times the error; test: test/regression/test_pixel_errors.py). Waves with crests along
!> the pixels have less accurate estimates of the area.
module asperity_map_error
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: not_computed, real64
  use asperity_map_contact, only: map_answer, most_load, press_map
  use asperity_map_patches, only: find_patches, map_patch
  implicit none
  private

  public :: estimate_pixel_errors, pixel_errors

  !> Estimated errors; `not_computed`: unknown.
  type :: pixel_errors
    real(real64) :: level = not_computed  !! of the separation at the load [length]
    real(real64) :: load = not_computed   !! of the load at the separation
    real(real64) :: area = not_computed   !! of the contact area
  end type pixel_errors

  ! Share of the difference by half the pixels that is the error (measured, see above).
  real(real64), parameter :: share_of_difference = 0.7_real64
  ! Tolerance of the gaps over the range of heights (chosen: the differences are larger by far).
  real(real64), parameter :: closed_halves = 1.0e-8_real64
  ! Least number of pixels along a side (chosen: halves of two are no maps).
  integer, parameter :: least_side = 4

contains

  !> Estimates the errors of a solution. Nothing is known of a map that is too small, or whose
  !> halves cannot be solved.
  subroutine estimate_pixel_errors(map, modulus, answer, patches, by_load, errors, hardness)
    type(height_map), intent(in) :: map         !! map without plastic deformation
    real(real64), intent(in) :: modulus         !! combined modulus, > 0
    type(map_answer), intent(in) :: answer      !! solution with pressures, under a load > 0
    type(map_patch), intent(in) :: patches(:)   !! patches of its pressures
    logical, intent(in) :: by_load              !! the load is prescribed, else the separation
    type(pixel_errors), intent(out) :: errors   !! errors of this solution
    real(real64), intent(in), optional :: hardness  !! largest pressure; absent: elastic
    type(map_answer) :: of_half, unsolved
    type(height_map) :: half
    type(map_patch), allocatable :: patches_of_half(:)
    real(real64), allocatable :: load
    real(real64) :: difference(3)
    integer :: first

    if (any(shape(map%height) < least_side)) return
    difference = 0.0_real64
    do first = 1, 2
      half = map
      half%height = map%height(first::2, first::2)
      if (.not. any(is_measured(half%height))) return
      half%columns = size(half%height, 1)
      half%rows = size(half%height, 2)
      half%pixel_spacing = 2 * map%pixel_spacing
      if (map%periodic) half%pixel_spacing = map%pixel_spacing * shape(map%height) / &
                                             real(shape(half%height), real64)
      of_half = unsolved
      of_half%level = answer%level
      of_half%interrupt = answer%interrupt
      of_half%pressure = answer%pressure(first::2, first::2)
      if (by_load) load = answer%load
      if (by_load .and. present(hardness)) load = min(load, most_load(half, hardness))
      call press_map(half, modulus, of_half, load, closed_halves, hardness)
      if (allocated(of_half%failure)) return
      call find_patches(half, of_half%pressure, patches_of_half, hardness=hardness)
      difference = max(difference, abs([of_half%level - answer%level, of_half%load - answer%load, &
                                        sum(patches_of_half%area) - sum(patches%area)]))
    end do
    errors%area = max(difference(3), 0.5_real64 * sum(patches%rim))
    if (by_load) errors%level = share_of_difference * difference(1)
    if (.not. by_load) errors%load = share_of_difference * difference(2)
  end subroutine estimate_pixel_errors

end module asperity_map_error
