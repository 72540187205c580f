!> Tests of a map of heights under a rigid flat, against closed forms: Hertz' ball (1882) and
!> Westergaard's wave (1939).
module asperity_map_suite
  use asperity_height_map, only: height_map, no_height
  use asperity_kinds, only: real64
  use asperity_map_contact, only: half_map, map_answer, press_map
  use asperity_map_patches, only: find_patches, map_patch
  use asperity_testing, only: check, has_failed, run_test
  implicit none
  private

  public :: run_maps

  real(real64), parameter :: pi = acos(-1.0_real64)

  ! The ball: contact radius 1, radius 10.
  real(real64), parameter :: ball_load = 4.0_real64 / 3.0_real64 * 100.0_real64
  real(real64), parameter :: ball_level = -0.1_real64, ball_modulus = 1000.0_real64

contains

  !> Runs the tests.
  subroutine run_maps
    call run_test('a ball on a grid converges to Hertz', ball_converges)
    call run_test('unequal sides, missing samples, one sample alone', odd_maps)
    call run_test('far beyond full contact load adds a punch', far_beyond_full_contact)
  end subroutine run_maps

  ! The ball's cap, on a square a little wider than its contact.
  function ball(n, m) result(map)
    integer, intent(in) :: n, m
    type(height_map) :: map
    real(real64), parameter :: across = 2.2_real64, radius = 10.0_real64
    integer :: i, j

    map%columns = n
    map%rows = m
    map%pixel_spacing = across / [n, m]
    allocate (map%height(n, m))
    do j = 1, m
      do i = 1, n
        map%height(i, j) = -(((i - 0.5_real64) * map%pixel_spacing(1) - across / 2)**2 + &
                             ((j - 0.5_real64) * map%pixel_spacing(2) - &
                             across / 2)**2) / (2 * radius)
      end do
    end do
  end function ball

  ! Hills of short waves across and along, on one long wave: radians a pixel.
  function waves(n, across, along, long_across, long_along) result(map)
    integer, intent(in) :: n
    real(real64), intent(in) :: across, along, long_across, long_along
    type(height_map) :: map
    integer :: i, j

    map = ball(n, n)
    do j = 1, n
      do i = 1, n
        map%height(i, j) = 0.02_real64 * (sin(across * i) * cos(along * j) + &
                                          sin(long_across * i + long_along * j))
      end do
    end do
  end function waves

  ! Displacements at the centres of uniform squares under a pressure with a vertical edge of slope:
  ! the order is 3/2 or better.
  subroutine ball_converges
    type(map_answer) :: answer
    type(map_patch), allocatable :: patches(:)
    real(real64) :: off, before
    integer :: n

    before = 1.0_real64
    n = 24
    do while (n <= 192)
      answer = map_answer(level=ball_level)
      call press_map(ball(n, n), ball_modulus, answer)
      off = abs(answer%load / ball_load - 1.0_real64)
      call check(.not. allocated(answer%failure), 'a ball is solved')
      call check(off < 0.5_real64 * before, 'the load converges')
      call find_patches(ball(n, n), answer%pressure, patches)
      call check(size(patches), 1, 'a ball is one spot')
      call check(abs(sum(patches%area) / pi - 1.0_real64) < 0.3_real64 / n, 'the area converges')
      before = off
      n = 2 * n
    end do
    call check(off < 2.0e-5_real64, 'the load is that of Hertz')
    ! The greatest pressure is a mean over one square.
    call check(abs(maxval(answer%pressure) / (2 * ball_modulus / (10 * pi)) - 1.0_real64) < &
               1.0e-3_real64, 'the greatest pressure is that of Hertz')
  end subroutine ball_converges

  subroutine odd_maps
    type(height_map) :: map, half
    type(map_answer) :: answer
    real(real64) :: before

    answer = map_answer()
    call press_map(ball(96, 31), ball_modulus, answer, ball_load)
    call check(abs(answer%level / ball_level - 1.0_real64) < 1.0e-3_real64, &
               'sides of 1 to 3 are Hertz'' ball')
    ! A hole where nothing would touch changes nothing.
    map = ball(96, 31)
    map%height(:7, :3) = no_height
    answer = map_answer()
    call press_map(map, ball_modulus, answer, ball_load)
    call check(abs(answer%level / ball_level - 1.0_real64) < 1.0e-3_real64, &
               'a hole beside the contact changes nothing')
    ! One where it is highest takes the pressure away.
    map%height(48:49, 16) = no_height
    before = answer%level
    answer = map_answer()
    call press_map(map, ball_modulus, answer, ball_load)
    call check(.not. maxval(answer%pressure(48:49, 16)) > 0.0_real64, 'nor is it pressed')
    call check(answer%level < before, 'the rest comes deeper')
    half = half_map(map)
    call check(all(shape(half%height) == [48, 16]), 'half the samples, rounded up')
    map%periodic = .true.
    half = half_map(map)
    call check(half%periodic, 'the half of a periodic map is periodic')
    call check(all(abs(half%pixel_spacing * shape(half%height) / (map%pixel_spacing * &
                                                                   shape(map%height)) - 1) < &
                          1.0e-14_real64), 'of the same lengths')
    map%periodic = .false.
    ! One pixel alone is Love's square: 4 asinh(1) p s/(pi E) at its centre.
    map = height_map(columns=1, rows=1, pixel_spacing=[0.1_real64, 0.1_real64])
    map%height = reshape([0.5_real64], [1, 1])
    answer = map_answer()
    call press_map(map, ball_modulus, answer, 3.0_real64)
    call check(abs((0.5_real64 - answer%level) / (4 * log(1.0_real64 + sqrt(2.0_real64)) * &
               3.0_real64 / (pi * ball_modulus * 0.1_real64)) - 1.0_real64) < 1.0e-12_real64, &
               'one sample is Love''s square')
  end subroutine odd_maps

  ! In full contact pressures are linear in the load: more load adds that of a flat punch. The
  ! displacements are 1e6 times the heights, whose share of a gap is near rounding.
  subroutine far_beyond_full_contact
    type(height_map) :: map, flat
    type(map_answer) :: answers(2), punch
    real(real64), parameter :: load = 1.0e10_real64
    integer :: i

    map = waves(64, 0.9_real64, 0.7_real64, 0.23_real64, 0.41_real64)
    flat = map
    flat%height(:, :) = 0.0_real64
    call press_map(flat, ball_modulus, punch, load)
    call check(.not. allocated(punch%failure), 'a punch is solved')
    do i = 1, 2
      call press_map(map, ball_modulus, answers(i), i * load)
      call check(.not. allocated(answers(i)%failure), 'a load far beyond is solved')
      if (has_failed()) return
      call check(all(answers(i)%pressure > 0.0_real64), 'all pixels are in contact')
    end do
    call check(maxval(abs(answers(2)%pressure - answers(1)%pressure - punch%pressure)) < &
               1.0e-8_real64 * maxval(punch%pressure), 'more load is that of a punch')
  end subroutine far_beyond_full_contact

end module asperity_map_suite
