!> The solver's search for pairs, by row and by level, against a comparison of all with all.
module asperity_kernel_search_suite
  use asperity_all_pairs, only: all_pairs, check_list, check_states, first_limit, pair_named
  use asperity_compare_all, only: compare_all
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_records, only: position_result, solve_method
  use asperity_decimal, only: decimal_value
  use asperity_isolated_contacts, only: list_pairs, solve_position
  use asperity_kinds, only: int64, real64
  use asperity_placed_scene, only: placed_scene
  use asperity_problems, only: decimal_text
  use asperity_random_philox, only: philox_block
  use asperity_scene_placing, only: place_scene
  use asperity_scene_values, only: control_separation, control_limit, control_load, &
                                   criterion_load, criterion_pressure, scene, scene_surface
  use asperity_testing, only: check, error_type, new_unittest, unittest_type
  implicit none
  private

  public :: collect_kernel_search

  ! Kinds of surfaces.
  integer, parameter :: even = 1, clustered = 2, mixed = 3, lattice = 4, tower = 5, far = 6
  integer, parameter :: positions = 2

contains

  !> Lists the tests.
  subroutine collect_kernel_search(suite)
    !> all tests
    type(unittest_type), allocatable, intent(out) :: suite(:)

    suite = [ &
      new_unittest('a row and levels find what all with all finds', by_row_and_level), &
      new_unittest('gaps that rounding makes equal: pairs in order', rounded_gaps), &
      new_unittest('centres that come level: the same pair is named', level_centres)]
  end subroutine collect_kernel_search

  ! Few asperities are in a row, many on levels.
  subroutine by_row_and_level(error)
    type(error_type), allocatable, intent(out) :: error
    integer :: kind

    do kind = even, far
      call compare_controls(error, kind, 60)
      call compare_controls(error, kind, 320)
    end do
  end subroutine by_row_and_level

  subroutine level_centres(error)
    type(error_type), allocatable, intent(out) :: error
    type(scene) :: scene_in
    integer :: n, failures

    do n = 60, 320, 260
      call make_scene(mixed, n, scene_in)
      scene_in%loading%control = control_separation
      scene_in%loading%value = decimal_value(-3_int64, -1)
      call compare(error, scene_in, 'level, ' // decimal_text(n), failures)
      call check(error, failures > 0, 'no centres come level')
    end do
  end subroutine level_centres

  ! Beside a summit as high as this gaps round to a few numbers: other things decide.
  subroutine rounded_gaps(error)
    type(error_type), allocatable, intent(out) :: error
    type(scene) :: scene_in
    type(placed_scene) :: placed
    type(all_pairs) :: truth
    type(contact_pairs) :: listed
    character(len=:), allocatable :: failure

    call make_scene(even, 60, scene_in)
    scene_in%upper%height(1) = 1.0e15_real64
    scene_in%loading%control = control_load
    scene_in%loading%value = decimal_value(1_int64, 0)
    call place_scene(scene_in, placed, failure)
    call list_pairs(placed, 1, .true., listed, failure)
    call check(error, .not. allocated(failure), 'the load is not borne')
    call compare_all(scene_in, 1, listed%length_power, truth)
    call check_list(error, truth, listed, huge(1.0_real64) / 2, .true., 'a high summit')
    call check(error, size(listed%list) > 20 .and. listed%list(1)%upper == 1, 'too few pairs')
  end subroutine rounded_gaps

  ! All ways to end a position.
  subroutine compare_controls(error, kind, n)
    type(error_type), allocatable, intent(inout) :: error
    integer, intent(in) :: kind, n
    type(scene) :: scene_in
    character(len=:), allocatable :: what
    integer :: failures, i

    what = 'kind ' // decimal_text(kind) // ', ' // decimal_text(n)
    call make_scene(kind, n, scene_in)
    call compare(error, scene_in, what // ': limit', failures)
    scene_in%loading%points = 2
    scene_in%limit%criterion = criterion_pressure
    scene_in%limit%value = decimal_value(20000_int64, 0)
    call compare(error, scene_in, what // ': pressure', failures)
    ! None reaches it before centres are level.
    scene_in%limit%value = decimal_value(1_int64, 12)
    call compare(error, scene_in, what // ': no limit', failures)
    ! Every contact that begins would be a state.
    scene_in%loading%points = 0
    scene_in%loading%control = control_separation
    do i = 0, 3
      scene_in%loading%value = decimal_value(int(12 * i, int64), -2)
      call compare(error, scene_in, what // ': approach', failures)
    end do
    scene_in%loading%control = control_load
    ! One level holds the contacts of the first, or all asperities must.
    do i = 0, 3, 3
      scene_in%loading%value = decimal_value(3_int64, i)
      call compare(error, scene_in, what // ': load', failures)
    end do
  end subroutine compare_controls

  ! The positions of a scene; `failures` counts those that cannot be solved.
  subroutine compare(error, scene_in, what, failures)
    type(error_type), allocatable, intent(inout) :: error
    type(scene), intent(in) :: scene_in
    character(len=*), intent(in) :: what
    integer, intent(out) :: failures
    type(placed_scene) :: placed, placed_for_load
    type(scene) :: for_load
    type(all_pairs) :: truth
    type(contact_pairs) :: every, listed
    type(position_result) :: result
    character(len=:), allocatable :: failure, list_failure
    integer :: m

    ! Under load control all pairs are listed, with the penetration of each at its limit.
    for_load = scene_in
    for_load%loading%control = control_load
    for_load%loading%value = decimal_value(1_int64, 0)
    failures = 0
    call place_scene(scene_in, placed, failure)
    call place_scene(for_load, placed_for_load, failure)
    do m = 1, positions
      call list_pairs(placed_for_load, m, .true., every, list_failure)
      call compare_all(scene_in, m, every%length_power, truth)
      call check_list(error, truth, every, huge(1.0_real64) / 2, .true., what // ', every pair')
      call list_pairs(placed, m, .false., listed, list_failure)
      call solve_position(placed, m, solve_method(), .true., result, failure)
      call judge(error, scene_in, truth, every, listed, list_failure, result, failure, &
                 epsilon(1.0_real64), what)
      if (allocated(failure)) failures = failures + 1
    end do
  end subroutine compare

  ! The pairs, the end and the contacts of one position against all pairs.
  subroutine judge(error, scene_in, truth, every, listed, list_failure, result, failure, unit, what)
    type(error_type), allocatable, intent(inout) :: error
    type(scene), intent(in) :: scene_in
    type(all_pairs), intent(in) :: truth
    type(contact_pairs), intent(in) :: every, listed
    character(len=:), allocatable, intent(in) :: list_failure, failure
    type(position_result), intent(in) :: result
    real(real64), intent(in) :: unit
    character(len=*), intent(in) :: what
    real(real64) :: compression
    character(len=:), allocatable :: level

    if (.not. any(truth%can_touch)) then
      call check(error, size(listed%list), 0, what // ': a pair of spheres that cannot touch')
      call check(error, allocated(failure) .eqv. scene_in%loading%control == control_load, &
                 what // ': they carry no load')
      return
    end if
    call check(error, allocated(failure) .eqv. allocated(list_failure), what // ': one fails')
    if (allocated(error)) return
    select case (scene_in%loading%control)
    case (control_limit)
      compression = first_limit(every)
      level = pair_named(truth, compression)
      if (.not. compression < huge(compression)) then
        level = 'no pair of asperities reaches the limit before its centres are level'
      else if (level /= '') then
        level = 'before the limit is reached ' // level
      end if
    case (control_separation)
      compression = truth%compression
      level = pair_named(truth, compression)
      if (level /= '') level = 'at this separation ' // level
    case default
      level = ''
      compression = listed%compression
    end select
    call check(error, allocated(failure) .eqv. level /= '', what // ': fails or not, ' // level)
    if (allocated(error)) return
    if (allocated(failure)) then
      call check(error, failure, level, what)
      return
    end if
    if (compression < 0.0_real64) then
      call check(error, size(listed%list) == 0 .and. result%states(1)%contacts == 0, &
                 what // ': a contact before the first touch')
      return
    end if
    call check(error, abs(listed%compression - compression) <= 2 * unit * compression, &
               what // ': another end')
    if (scene_in%loading%control == control_load) then
      call check(error, listed%complete_to >= compression, what // ': pairs may be missing')
      call check_list(error, truth, listed, &
                      min(listed%complete_to, huge(1.0_real64) / 2), .false., what)
      call check(error, abs(load_at(truth, compression) / listed%target * listed%modulus - 1) <= &
                        100 * unit, what // ': another load')
    else
      call check_list(error, truth, listed, listed%compression, .true., what)
    end if
    call check_states(error, truth, result, listed%compression, &
                      16.0_real64**listed%length_power, what)
  end subroutine judge

  ! Sum of the loads of all pairs over the modulus, by Hertz' law.
  pure real(real64) function load_at(truth, compression) result(load)
    type(all_pairs), intent(in) :: truth
    real(real64), intent(in) :: compression
    real(real64) :: p, z
    integer :: i, k

    load = 0.0_real64
    do k = 1, size(truth%gap, 2)
      do i = 1, size(truth%gap, 1)
        if (.not. truth%gap(i, k) < compression) cycle
        p = compression - truth%gap(i, k)
        z = truth%zc(i, k) - p
        p = p * (truth%zc(i, k) + z) / (truth%s(i, k) + sqrt(truth%d(i, k)**2 + z**2))
        load = load + 4.0_real64 / 3.0_real64 * sqrt(truth%radius(i, k)) * p**1.5_real64
      end do
    end do
  end function load_at

  ! Two surfaces of one kind in the thesis' material, to its limit load.
  subroutine make_scene(kind, n, scene_in)
    integer, intent(in) :: kind, n
    type(scene), intent(out) :: scene_in

    call make_surface(kind, n, 1_int64, scene_in%upper)
    call make_surface(kind, n + 7, 2_int64, scene_in%lower)
    if (kind == clustered) then
      ! Where the one has asperities the other has some.
      scene_in%upper%x(:) = scene_in%lower%x(:n) + 0.3_real64
      scene_in%upper%y(:) = scene_in%lower%y(:n) - 0.2_real64
    end if
    ! The tallest summit stands over nothing.
    if (kind == tower) scene_in%upper%height(3) = 0.9_real64
    if (kind == tower) scene_in%upper%x(3) = -500.0_real64
    scene_in%motion%positions = positions
    scene_in%motion%x_step = decimal_value(17_int64, -2)
    scene_in%motion%y_first = decimal_value(-5_int64, -2)
    if (kind == far) scene_in%motion%x_step = decimal_value(1_int64, 5)
    scene_in%loading%control = control_limit
    scene_in%limit%criterion = criterion_load
    scene_in%limit%value = decimal_value(28889_int64, -2)
  end subroutine make_scene

  subroutine make_surface(kind, n, key, surface)
    integer, intent(in) :: kind, n
    integer(int64), intent(in) :: key
    type(scene_surface), intent(inout) :: surface
    real(real64) :: side, u(4)
    integer :: i

    allocate (surface%x(n), surface%y(n), surface%height(n), surface%radius(n))
    surface%elastic_modulus = decimal_value(275760_int64, 0)
    surface%poisson_ratio = decimal_value(42_int64, -2)
    side = sqrt(n / 0.48_real64)
    surface%radius = 1.27_real64
    do i = 1, n
      u = real(philox_block([int(i, int64), 0_int64, 0_int64, 0_int64], [key, 7_int64]), real64) / &
          2.0_real64**32
      surface%x(i) = side * u(1)
      surface%y(i) = side * u(2)
      surface%height(i) = 0.03_real64 + 0.1_real64 * (u(3) + u(4))
      select case (kind)
      case (clustered)
        surface%x(i) = 3.0_real64 * u(1) + 1.0e4_real64 * modulo(i, 5)
        surface%y(i) = 3.0_real64 * u(2) - 1.0e3_real64 * modulo(i, 3)
      case (mixed)
        surface%radius(i) = 0.05_real64 * 40.0_real64**u(3)
        surface%height(i) = 0.1_real64 * u(4) * surface%radius(i)
      case (lattice)
        surface%x(i) = 0.75_real64 * modulo(i, 25)
        surface%y(i) = 0.75_real64 * (i / 25)
        surface%height(i) = 0.0625_real64 * (1 + modulo(i, 3))
      case default
        continue
      end select
    end do
  end subroutine make_surface

end module asperity_kernel_search_suite
