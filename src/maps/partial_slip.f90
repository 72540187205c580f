!> Partial slip of a height map under tangential loads at a constant normal load.
!>
!> Problem: on each pixel the traction is at most mu p, with the pressures p above 0 of the last
!> state. The tangential load goes from 0 to each point of its path, on straight lines. In each
!> increment `asperity_slip_solver` finds the tractions of least energy, from those before.
!>
!> An increment is exact while the load stays on a line through 0, also where it is reversed
!> (Mindlin and Deresiewicz 1953). A load that turns is followed in `turn_steps` increments for each
!> line. Their error is inverse to their number: the difference to half as many is the estimate.
module asperity_partial_slip
  use asperity_contact_field, only: contact_field
  use asperity_height_map, only: height_map, is_measured
  use asperity_interruption, only: interruption
  use asperity_kinds, only: not_computed, real64
  use asperity_map_contact, only: map_answer
  use asperity_map_patches, only: find_patches, map_patch
  use asperity_problems, only: not_enough_memory, real_text
  use asperity_process, only: has_memory
  use asperity_slip_solver, only: find_tractions, slip_problem, tangent_space
  use asperity_solve_ending, only: solve_ending
  use asperity_tangential_stiffness, only: prepare_for_map, room_for_tractions, stiffness_of
  use asperity_traction_convolution, only: by_tractions, traction_convolution
  implicit none
  private

  public :: slip_answer, slip_of_patches, slip_request, solve_partial_slip, take_traction

  !> Tangential loads or displacements of a map.
  type :: slip_request
    real(real64) :: coefficient = 0.0_real64    !! coefficient of friction mu, 0 or more
    real(real64) :: poisson_ratio = 0.0_real64  !! of both bodies
    real(real64) :: beta = 0.0_real64           !! Dundurs' number, > 0: the lower body is softer
    logical :: by_load = .true.                 !! whether loads are given, else displacements
    real(real64), allocatable :: path(:, :)     !! (x and y, point): load [force] or [length]
  end type slip_request

  !> Solution of partial slip. Vectors have components along x and y.
  type :: slip_answer
    logical :: slides = .false.                   !! complete sliding: q = mu p
    real(real64) :: load(2) = 0.0_real64          !! tangential load T [force]
    !> Tangential displacement of the bodies [length]; `not_computed` where they slide under a load.
    real(real64) :: displacement(2) = 0.0_real64
    real(real64) :: stiffness = 0.0_real64  !! dT/d displacement of the load going on [force/length]
    real(real64) :: stick_area = 0.0_real64       !! area that sticks [length**2]
    !> Work of friction on the whole path, and since its end was passed before [force length];
    !> `not_computed`: the path does not close.
    real(real64) :: energy = 0.0_real64, cycle_energy = not_computed
    real(real64) :: path_error = 0.0_real64       !! of the displacement, relative, by increments
    real(real64), allocatable :: traction(:, :, :)  !! q of each pixel on the lower body
    real(real64), allocatable :: slip(:, :, :)      !! of the upper body over the lower one
    logical, allocatable :: sticks(:, :)            !! pixels in contact that stick at the end
  end type slip_answer

  ! Increments of each line of a load that turns (measured: the displacement after a quarter of a
  ! circle is in error by 2 %; test: test/maps/test_partial_slip.py).
  integer, parameter :: turn_steps = 32
  ! Part of the load that a turn is, at least (chosen, for rounding).
  real(real64), parameter :: least_turn = 1.0e-12_real64

contains

  !> Solves partial slip of a map that is in contact.
  subroutine solve_partial_slip(map, modulus, request, loaded, slip, failure)
    type(height_map), intent(in) :: map        !! shape with its edges
    real(real64), intent(in) :: modulus        !! combined modulus, more than 0
    type(slip_request), intent(in) :: request  !! friction, and loads or displacements
    type(map_answer), intent(in) :: loaded     !! solution at the normal load
    type(slip_answer), intent(out) :: slip     !! tractions, displacement, area that sticks
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is not solved
    type(traction_convolution) :: operator
    type(slip_problem) :: problem
    type(slip_answer) :: coarser
    type(map_patch), allocatable :: patches(:)
    real(real64) :: most
    integer :: points

    if (.not. has_memory(room_for_tractions(map))) then
      failure = not_enough_memory // ' for the tractions of the map'
      return
    end if
    points = size(request%path, 2)
    allocate (problem%limit, source=request%coefficient * max(0.0_real64, loaded%pressure))
    most = sum(problem%limit) * product(map%pixel_spacing)
    if (request%by_load .and. norm2(request%path(:, points)) >= most .and. points == 1) then
      call slide_along(request%path(:, 1), most, problem%limit, slip)
      return
    end if
    if (request%by_load .and. .not. all(norm2(request%path, 1) < most)) then
      failure = 'tangential_path: found a load of ' // &
                real_text(maxval(norm2(request%path, 1))) // ', expected less than mu N = ' // &
                real_text(most) // ', where the bodies slide'
      return
    end if
    problem%limit = problem%limit / modulus
    problem%by_load = request%by_load
    call prepare_for_map(map, request%poisson_ratio, 0.0_real64, operator)
    call follow_path(map, modulus, request, turn_steps, loaded%interrupt, operator, problem, slip, &
                     failure)
    if (allocated(failure)) return
    if (count_straight(request%path) < points) then
      call follow_path(map, modulus, request, turn_steps / 2, loaded%interrupt, operator, problem, &
                       coarser, failure)
      if (allocated(failure)) return
      slip%path_error = norm2(coarser%displacement - slip%displacement) / &
                        max(norm2(slip%displacement), tiny(most))
      if (.not. request%by_load) slip%path_error = norm2(coarser%load - slip%load) / &
                                                   max(norm2(slip%load), tiny(most))
    end if
    call find_patches(map, merge(loaded%pressure, 0.0_real64, slip%sticks), patches)
    slip%stick_area = sum(patches%area)
  end subroutine solve_partial_slip

  ! Sets complete sliding under a load.
  subroutine slide_along(load, most, limit, slip)
    real(real64), intent(in) :: load(2)    ! tangential load, at least that of sliding
    real(real64), intent(in) :: most       ! load of sliding
    real(real64), intent(in) :: limit(:, :)  ! largest tractions
    type(slip_answer), intent(inout) :: slip
    real(real64) :: direction(2)

    direction = load / max(norm2(load), tiny(most))
    slip%slides = .true.
    slip%load = most * direction
    slip%displacement = not_computed
    slip%energy = not_computed
    allocate (slip%sticks(size(limit, 1), size(limit, 2)), source=.false.)
    allocate (slip%slip(size(limit, 1), size(limit, 2), 2), source=not_computed)
    slip%traction = reshape([direction(1) * limit, direction(2) * limit], shape(slip%slip))
  end subroutine slide_along

  ! Number of points up to which the path stays on one line through 0.
  pure integer function count_straight(path) result(number)
    real(real64), intent(in) :: path(:, :)
    real(real64) :: line(2)
    integer :: i

    line = 0.0_real64
    number = 0
    do i = 1, size(path, 2)
      if (.not. norm2(line) > 0.0_real64) line = path(:, i)
      if (abs(line(1) * path(2, i) - line(2) * path(1, i)) > &
          least_turn * norm2(line) * norm2(path(:, i))) return
      number = i
    end do
  end function count_straight

  ! Solves the increments of the path.
  subroutine follow_path(map, modulus, request, steps, interrupt, operator, problem, slip, failure)
    type(height_map), intent(in) :: map
    real(real64), intent(in) :: modulus
    type(slip_request), intent(in) :: request
    integer, intent(in) :: steps              ! increments of a line of a load that turns
    type(interruption), intent(in) :: interrupt
    type(traction_convolution), intent(inout) :: operator
    type(slip_problem), intent(inout) :: problem
    type(slip_answer), intent(out) :: slip
    character(len=:), allocatable, intent(out) :: failure
    type(tangent_space) :: space
    real(real64), allocatable :: moved(:, :, :)
    real(real64) :: change(2), energy_at(0:size(request%path, 2)), from(2), given(2), matrix(2, 2), &
                    step(2), unit
    integer :: i, k, parts, straight

    straight = count_straight(request%path)
    allocate (slip%traction(size(problem%limit, 1), size(problem%limit, 2), 2), source=0.0_real64)
    allocate (slip%slip, source=slip%traction)
    allocate (moved, mold=slip%traction)
    allocate (slip%sticks, source=problem%limit > 0.0_real64)
    if (allocated(problem%base)) deallocate (problem%base)
    allocate (problem%base, source=slip%traction)
    ! Tractions are over the modulus, displacements over the side along x.
    unit = map%pixel_spacing(1)
    if (request%by_load) unit = modulus * product(map%pixel_spacing)
    energy_at(0) = 0.0_real64
    from = 0.0_real64
    given = 0.0_real64
    change = [1.0_real64, 0.0_real64]
    do i = 1, size(request%path, 2)
      parts = merge(1, steps, i <= straight)
      do k = 1, parts
        step = (from + (request%path(:, i) - from) * k / parts) / unit - given
        given = given + step
        if (norm2(step) > 0.0_real64) then
          change = step
          call solve_increment(operator, problem, given, step, interrupt, slip, moved, space, &
                               failure)
          if (allocated(failure)) return
        end if
      end do
      energy_at(i) = slip%energy
      from = request%path(:, i)
    end do
    if (.not. allocated(space%weight)) then
      problem%given = 0.0_real64
      call solve_increment(operator, problem, given, given, interrupt, slip, moved, space, failure)
    end if
    slip%slides = .not. any(slip%sticks)
    if (map%strip_axis > 0) then
      slip%stiffness = not_computed
    else if (.not. slip%slides) then
      matrix = stiffness_of(map, modulus, operator, space)
      slip%stiffness = not_computed
      if (matrix(1, 1) > not_computed) slip%stiffness = along_load(matrix, change)
    end if
    do i = size(request%path, 2) - 1, 0, -1
      step = -request%path(:, size(request%path, 2))
      if (i > 0) step = step + request%path(:, i)
      if (norm2(step) > least_turn * maxval(abs(request%path))) cycle
      slip%cycle_energy = energy_at(size(request%path, 2)) - energy_at(i)
      exit
    end do
    associate (cell => product(map%pixel_spacing), side => map%pixel_spacing(1))
      slip%load = modulus * cell * [sum(slip%traction(:, :, 1)), sum(slip%traction(:, :, 2))]
      slip%displacement = side * slip%displacement
      slip%traction = modulus * slip%traction
      slip%slip = side * slip%slip
      slip%energy = modulus * cell * side * slip%energy
      if (slip%cycle_energy > not_computed) &
        slip%cycle_energy = modulus * cell * side * slip%cycle_energy
    end associate
  end subroutine follow_path

  ! Stiffness of a load that goes on: of displacements C t under a load along t, 1/(t.C t).
  pure real(real64) function along_load(matrix, change) result(stiffness)
    real(real64), intent(in) :: matrix(2, 2)  ! load by displacement
    real(real64), intent(in) :: change(2)     ! direction of the load
    real(real64) :: t(2)

    t = change / norm2(change)
    stiffness = (matrix(1, 1) * matrix(2, 2) - matrix(1, 2)**2) / &
                (matrix(2, 2) * t(1)**2 + matrix(1, 1) * t(2)**2 - 2 * matrix(1, 2) * t(1) * t(2))
  end function along_load

  ! Solves one increment, from tractions with their displacements.
  subroutine solve_increment(operator, problem, given, step, interrupt, slip, moved, space, failure)
    type(traction_convolution), intent(inout) :: operator
    type(slip_problem), intent(inout) :: problem
    real(real64), intent(in) :: given(2), step(2)  ! load at the end, or displacement; its change
    type(interruption), intent(in) :: interrupt
    type(slip_answer), intent(inout) :: slip       ! in the units of the solver
    real(real64), intent(inout) :: moved(:, :, :)
    type(tangent_space), intent(inout) :: space
    character(len=:), allocatable, intent(out) :: failure
    type(solve_ending) :: ending
    real(real64) :: displacement(2)
    integer :: k

    problem%given = merge(given, step, problem%by_load)
    if (problem%by_load) then
      do k = 1, 2
        slip%traction(:, :, k) = slip%traction(:, :, k) + problem%limit * &
                                 (step(k) / sum(problem%limit))
      end do
    end if
    call find_tractions(operator, problem, slip%traction, moved, displacement, space, ending, &
                        interrupt)
    if (.not. ending%converged) failure = 'partial slip: the tractions did not converge'
    if (interrupt%is_asked()) failure = 'interrupted'
    slip%displacement = slip%displacement + displacement
    slip%slip = slip%slip + moved
    slip%energy = slip%energy + sum(slip%traction * moved)
    slip%sticks = problem%limit > 0.0_real64 .and. .not. space%stiffening > 0.0_real64
    call operator%apply(slip%traction, problem%base, by_tractions)
  end subroutine solve_increment

  !> Tangential load and area that sticks of each contact patch.
  subroutine slip_of_patches(map, loaded, slip, load, stick_area)
    type(height_map), intent(in) :: map            !! shape of the solution
    type(map_answer), intent(in) :: loaded         !! solution at the normal load
    type(slip_answer), intent(in) :: slip          !! solution of partial slip
    !> of each patch, in the order of `find_patches`
    real(real64), allocatable, intent(out) :: load(:), stick_area(:)
    type(map_patch), allocatable :: patches(:), stuck(:)
    real(real64), allocatable :: total(:, :)
    integer, allocatable :: patch_of(:, :), stuck_of(:, :)
    integer :: i, j

    call find_patches(map, max(0.0_real64, loaded%pressure), patches, patch_of)
    allocate (total(2, size(patches)), stick_area(size(patches)), source=0.0_real64)
    call find_patches(map, merge(loaded%pressure, 0.0_real64, slip%sticks), stuck, stuck_of)
    ! Each patch that sticks is within one contact patch; its first pixel adds its area.
    do j = 1, map%rows
      do i = 1, map%columns
        if (patch_of(i, j) == 0) cycle
        total(:, patch_of(i, j)) = total(:, patch_of(i, j)) + slip%traction(i, j, :) * &
                                   product(map%pixel_spacing)
        if (stuck_of(i, j) == 0) cycle
        associate (area => stuck(stuck_of(i, j))%area)
          stick_area(patch_of(i, j)) = stick_area(patch_of(i, j)) + area
          area = 0.0_real64
        end associate
      end do
    end do
    load = norm2(total, 1)
  end subroutine slip_of_patches

  !> Adds tractions, slip and the pixels that stick to the fields of the state.
  pure subroutine take_traction(map, slip, field)
    type(height_map), intent(in) :: map          !! shape of the solution
    type(slip_answer), intent(in) :: slip        !! solution of partial slip
    type(contact_field), intent(inout) :: field  !! fields of the state
    logical, allocatable :: measured(:, :)

    allocate (measured, source=is_measured(map%height))
    field%traction = merge(slip%traction(:, :, 1), not_computed, measured)
    field%traction_y = merge(slip%traction(:, :, 2), not_computed, measured)
    field%slip_x = merge(slip%slip(:, :, 1), not_computed, measured)
    field%slip_y = merge(slip%slip(:, :, 2), not_computed, measured)
    field%sticks = slip%sticks
  end subroutine take_traction

end module asperity_partial_slip
