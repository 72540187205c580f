!> Partial slip of a height map under tangential loads at a constant normal load.
!>
!> Problem: on each pixel the traction is at most mu p, with the pressures p above 0 of the last
!> state. The tangential load goes from 0 to each point of its path, on straight lines. In each
!> increment `asperity_slip_increments` finds the tractions of least energy, from those before;
!> where the bodies are coupled the pressures change with them, at the same normal load.
!>
!> An increment is exact while the load stays on a line through 0, also where it is reversed
!> (Mindlin and Deresiewicz 1953). A load that turns is followed in `turn_steps` increments for each
!> line. Their error is inverse to their number: the difference to half as many is the estimate.
module asperity_partial_slip
  use asperity_contact_field, only: contact_field
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: int64, not_computed, real64
  use asperity_map_contact, only: map_answer
  use asperity_map_patches, only: find_patches, map_patch
  use asperity_problems, only: real_text
  use asperity_process, only: check_memory
  use asperity_slip_increments, only: begin_rubbing, forget_tractions, rubbed_map, slip_memory, &
                                      slip_request, take_increment
  use asperity_slip_solver, only: find_compliance, set_sticking
  use asperity_tangential_stiffness, only: room_for_tractions
  use asperity_traction_convolution, only: element_set, list_elements, traction_convolution
  implicit none
  private

  public :: slip_answer, slip_of_patches, solve_partial_slip, take_traction

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
  ! Largest residual of an increment of a load on a straight line (chosen), and of one that turns,
  ! whose number `turn_steps` leaves 1e-2 of the displacement (chosen: their sum is 1e-4 of it).
  real(real64), parameter :: direct_tolerance = 1.0e-7_real64, turn_tolerance = 2.0e-6_real64
  ! Part of the load that a turn is, at least (chosen, for rounding).
  real(real64), parameter :: least_turn = 1.0e-12_real64

contains

  !> Solves partial slip of a map that is in contact. Coupled, the pressures change.
  subroutine solve_partial_slip(map, modulus, request, pressed, loaded, slip, failure)
    type(height_map), intent(in) :: map        !! shape with its edges
    real(real64), intent(in) :: modulus        !! combined modulus, more than 0
    type(slip_request), intent(in) :: request  !! friction, and loads or displacements
    type(slip_memory), intent(in) :: pressed   !! tractions of the normal load; none: 0
    type(map_answer), intent(inout) :: loaded  !! solution at the normal load
    type(slip_answer), intent(out) :: slip     !! tractions, displacement, area that sticks
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is not solved
    type(traction_convolution), target :: operator
    type(rubbed_map) :: surface
    type(slip_answer) :: coarser
    type(map_patch), allocatable :: patches(:)
    type(map_answer) :: start
    type(slip_memory) :: memory, other
    real(real64), allocatable :: limit(:, :), size_of(:)
    real(real64) :: most
    integer :: points

    call check_memory('the tractions of the map', failure, bytes=room_for_tractions(map))
    if (allocated(failure)) return
    points = size(request%path, 2)
    allocate (limit, source=request%coefficient * max(0.0_real64, loaded%pressure))
    most = sum(limit) * product(map%pixel_spacing)
    allocate (size_of, source=hypot(request%path(1, :), request%path(2, :)))
    ! A sum is rounded by at most epsilon a term.
    if (request%by_load .and. points == 1 .and. size_of(points) >= most * &
        (1.0_real64 - count(limit > 0.0_real64, kind=int64) * epsilon(most))) then
      call slide_along(request%path(:, 1), most, limit, slip)
      return
    end if
    if (request%by_load .and. .not. all(size_of < most)) then
      failure = 'tangential_path: found a load of ' // real_text(maxval(size_of)) // &
                ', expected less than mu N = ' // real_text(most) // ', where the bodies slide'
      return
    end if
    memory = pressed
    start = loaded
    call begin_rubbing(map, modulus, request, operator, surface, memory)
    call follow_path(surface, request, turn_steps, memory, loaded, slip, failure)
    if (allocated(failure)) return
    if (count_straight(request%path) < points) then
      other = pressed
      if (.not. allocated(other%traction)) call forget_tractions(map, other)
      call follow_path(surface, request, turn_steps / 2, other, start, coarser, failure)
      if (allocated(failure)) return
      slip%path_error = relative_difference(coarser%displacement, slip%displacement)
      if (.not. request%by_load) slip%path_error = relative_difference(coarser%load, slip%load)
    end if
    call find_patches(map, merge(loaded%pressure, 0.0_real64, slip%sticks), patches)
    slip%stick_area = sum(patches%area)

  contains

    ! Difference of two vectors over the second one.
    pure real(real64) function relative_difference(one, other)
      real(real64), intent(in) :: one(2), other(2)

      relative_difference = hypot(one(1) - other(1), one(2) - other(2)) / &
                 max(hypot(other(1), other(2)), tiny(other))
    end function relative_difference

  end subroutine solve_partial_slip

  ! Sets complete sliding under a load.
  subroutine slide_along(load, most, limit, slip)
    real(real64), intent(in) :: load(2)    ! tangential load, at least that of sliding
    real(real64), intent(in) :: most       ! load of sliding
    real(real64), intent(in) :: limit(:, :)  ! largest tractions
    type(slip_answer), intent(inout) :: slip
    real(real64) :: direction(2)

    direction = load / max(hypot(load(1), load(2)), tiny(most))
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
      if (.not. maxval(abs(line)) > 0.0_real64) line = path(:, i)
      if (abs(line(1) * path(2, i) - line(2) * path(1, i)) > &
          least_turn * maxval(abs(line)) * maxval(abs(path(:, i)))) return
      number = i
    end do
  end function count_straight

  ! Solves the increments of the path.
  subroutine follow_path(surface, request, steps, memory, answer, slip, failure)
    type(rubbed_map), intent(inout) :: surface
    type(slip_request), intent(in) :: request
    integer, intent(in) :: steps              ! increments of a line of a load that turns
    type(slip_memory), intent(inout) :: memory
    type(map_answer), intent(inout) :: answer
    type(slip_answer), intent(out) :: slip
    character(len=:), allocatable, intent(out) :: failure
    real(real64) :: change(2), energy_at(0:size(request%path, 2)), from(2), given(2), &
                    compliance(1, 1), started(2), step(2), unit
    type(element_set) :: contact
    integer :: i, k, last, parts, straight

    straight = count_straight(request%path)
    last = size(request%path, 2)
    associate (cell => product(surface%map%pixel_spacing), side => surface%map%pixel_spacing(1), &
               modulus => surface%modulus)
      unit = merge(modulus * cell, side, request%by_load)
      energy_at(0) = memory%energy
      started = memory%displacement
      from = 0.0_real64
      given = 0.0_real64
      change = 0.0_real64
      do i = 1, last
        parts = merge(1, steps, i <= straight)
        do k = 1, parts
          step = (from + (request%path(:, i) - from) * k / parts) / unit - given
          given = given + step
          if (.not. maxval(abs(step)) > 0.0_real64) cycle
          change = step
          if (k == 1) memory%change = 0.0_real64
          surface%tolerance = merge(turn_tolerance, direct_tolerance, parts > 1)
          call take_increment(surface, request%by_load, merge(given, step, request%by_load), &
                              memory, answer, failure, answer%load)
          if (allocated(failure)) return
        end do
        energy_at(i) = memory%energy
        from = request%path(:, i)
      end do
      if (.not. maxval(abs(change)) > 0.0_real64) then
        call list_elements(answer%pressure > 0.0_real64, contact)
        call set_sticking(contact, surface%space)
        if (.not. surface%is_coupled) memory%sticks = answer%pressure > 0.0_real64
      end if
      do i = last - 1, 0, -1
        step = request%path(:, last)
        if (i > 0) step = step - request%path(:, i)
        if (.not. maxval(abs(change)) > 0.0_real64 .or. &
            maxval(abs(step)) > least_turn * maxval(abs(request%path))) cycle
        slip%cycle_energy = modulus * cell * side * (energy_at(last) - energy_at(i))
        exit
      end do
      allocate (slip%sticks, source=memory%sticks)
      slip%slides = .not. any(slip%sticks)
      slip%load = modulus * cell * [sum(memory%traction(:, :, 1)), sum(memory%traction(:, :, 2))]
      slip%displacement = side * (memory%displacement - started)
      slip%traction = modulus * memory%traction
      slip%slip = side * memory%slip
      slip%energy = modulus * cell * side * memory%energy
      if (surface%map%strip_axis > 0) slip%stiffness = not_computed
      if (surface%map%strip_axis > 0 .or. slip%slides) return
      ! That of the load going on.
      if (.not. maxval(abs(change)) > 0.0_real64) change(1) = 1.0_real64
      call find_compliance(surface%operator, surface%space, &
                           reshape(change / norm2(change), [2, 1]), compliance)
      slip%stiffness = not_computed
      if (compliance(1, 1) > 0.0_real64) &
        slip%stiffness = modulus * surface%map%pixel_spacing(2) / compliance(1, 1)
    end associate
  end subroutine follow_path

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

    ! The patches of the state: pixels that attract each other are in contact, too.
    if (allocated(loaded%contact_pressure)) then
      call find_patches(map, loaded%contact_pressure, patches, patch_of)
    else
      call find_patches(map, loaded%pressure, patches, patch_of)
    end if
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
    load = hypot(total(1, :), total(2, :))
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
