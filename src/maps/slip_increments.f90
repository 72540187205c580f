!> Increments of the loads on a height map with friction.
!>
!> From the tractions and displacements of the state before, `asperity_slip_solver` finds those of
!> the next load, with |q| <= mu p on each pixel. Bodies of unlike materials, whose Dundurs' number
!> beta is not 0, couple both problems: tractions q displace the surfaces apart by u(q), and
!> pressures displace them tangentially. The normal problem, on the heights less u(q), and the
!> tangential one are then solved in turns (Panagiotopoulos, Ing.-Arch. 44 (1975) 421; Kalker 1990)
!> until the pressures settle. Each turn leaves 0.2 to 0.3 of the change (measured, beta = 0.5).
!> With complete stick the set of pixels in contact can alternate: the increment is refused then.
module asperity_slip_increments
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: int64, real64
  use asperity_map_contact, only: map_answer, press_map
  use asperity_problems, only: real_text
  use asperity_slip_solver, only: find_tractions, slip_problem, tangent_space
  use asperity_solve_ending, only: solve_ending
  use asperity_tangential_stiffness, only: prepare_for_map
  use asperity_traction_convolution, only: by_tractions, list_elements, normal_by_tractions, &
                                           tangential_by_pressures, traction_convolution
  implicit none
  private

  public :: begin_rubbing, forget_tractions, rubbed_map, slip_memory, slip_request, take_increment

  !> Friction of a map, and its tangential loads or displacements.
  type :: slip_request
    real(real64) :: coefficient = 0.0_real64    !! coefficient of friction mu, 0 or more
    real(real64) :: poisson_ratio = 0.0_real64  !! of both bodies
    real(real64) :: beta = 0.0_real64           !! > 0: the lower body is softer; 0: no coupling
    logical :: by_load = .true.                 !! whether loads are given, else displacements
    real(real64), allocatable :: path(:, :)     !! (x and y, point): load [force] or [length]
  end type slip_request

  !> State that the next increment starts from. Tractions are over the modulus, lengths over the
  !> side of a pixel along x.
  type :: slip_memory
    real(real64), allocatable :: traction(:, :, :)  !! q on the lower body
    real(real64), allocatable :: change(:, :, :)    !! of q by the increment before, to begin with
    real(real64), allocatable :: moved(:, :, :)     !! elastic displacement by tractions, pressures
    real(real64), allocatable :: slip(:, :, :)      !! of the upper body over the lower one
    real(real64), allocatable :: uplift(:, :)         !! u(q) apart from each other [length]
    logical, allocatable :: sticks(:, :)            !! pixels in contact that stick
    real(real64) :: displacement(2) = 0.0_real64    !! of the bodies
    real(real64) :: energy = 0.0_real64             !! work of friction
  end type slip_memory

  !> Map of the increments. It must not outlive its operator, which would not be freed with it.
  type :: rubbed_map
    type(height_map) :: map                  !! heights less the uplift
    real(real64), allocatable :: height(:, :)  !! heights
    real(real64) :: modulus = 0.0_real64     !! combined modulus, more than 0
    real(real64) :: coefficient = 0.0_real64  !! coefficient of friction
    logical :: is_coupled = .false.          !! unlike bodies
    real(real64) :: tolerance = 1.0e-7_real64  !! largest residual of an increment
    type(traction_convolution), pointer :: operator => null()  !! displacements by tractions
    type(tangent_space) :: space             !! pixels that stick and slide
  end type rubbed_map

  ! Largest change of a pressure by the last turn over the greatest (chosen), and number of turns
  ! (chosen: with 0.3 a turn leaves 1e-15 of the change).
  real(real64), parameter :: settled = 1.0e-6_real64
  integer, parameter :: turns_allowed = 30

contains

  !> Prepares the operator of a map, and a memory without tractions where there is none.
  subroutine begin_rubbing(map, modulus, request, operator, surface, memory)
    type(height_map), intent(in) :: map            !! map with its edges
    real(real64), intent(in) :: modulus            !! combined modulus, more than 0
    type(slip_request), intent(in) :: request      !! friction, and the materials
    type(traction_convolution), intent(inout), target :: operator  !! without plans; gets them
    type(rubbed_map), intent(inout) :: surface     !! gets the map and the operator
    type(slip_memory), intent(inout) :: memory     !! state before this one

    surface%map = map
    surface%height = map%height
    surface%modulus = modulus
    surface%coefficient = request%coefficient
    surface%is_coupled = abs(request%beta) > 0.0_real64
    call prepare_for_map(map, request%poisson_ratio, request%beta, operator)
    surface%operator => operator
    if (.not. allocated(memory%traction)) call forget_tractions(map, memory)
  end subroutine begin_rubbing

  !> Makes a memory without tractions.
  subroutine forget_tractions(map, memory)
    type(height_map), intent(in) :: map          !! map with its edges
    type(slip_memory), intent(out) :: memory     !! state without a tangential load

    allocate (memory%traction(size(map%height, 1), size(map%height, 2), 2), source=0.0_real64)
    allocate (memory%change, memory%moved, memory%slip, source=memory%traction)
    allocate (memory%uplift, source=memory%traction(:, :, 1))
    allocate (memory%sticks(size(map%height, 1), size(map%height, 2)), source=.false.)
  end subroutine forget_tractions

  !> Solves one increment. Coupled, `answer` gets the pressures of the map, at `load` or its level.
  subroutine take_increment(surface, by_load, given, memory, answer, failure, load)
    type(rubbed_map), intent(inout) :: surface     !! map with its operator; gets what slides
    logical, intent(in) :: by_load                 !! whether the tangential load is given
    real(real64), intent(in) :: given(2)           !! that load, or the change of displacement
    type(slip_memory), intent(inout) :: memory     !! state before; becomes this state
    type(map_answer), intent(inout) :: answer      !! pressures; coupled: start and result
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is not solved
    real(real64), intent(in), optional :: load     !! normal load; absent: the level of `answer`
    type(slip_problem) :: problem
    type(solve_ending) :: ending
    real(real64), allocatable :: by_pressure(:, :, :), pressure(:, :), q(:, :), slip(:, :), &
                                 u(:, :, :)
    logical, allocatable :: in_contact(:, :)
    real(real64) :: change, displacement(2)
    integer :: turn

    problem%by_load = by_load
    problem%given = given
    problem%tolerance = surface%tolerance
    problem%reference = maxval(abs(memory%displacement))
    allocate (by_pressure(size(surface%height, 1), size(surface%height, 2), 2), &
              u(size(surface%height, 1), size(surface%height, 2), 1), &
              pressure(size(surface%height, 1), size(surface%height, 2)), source=0.0_real64)
    allocate (in_contact(size(pressure, 1), size(pressure, 2)))
    do turn = 1, turns_allowed
      if (surface%is_coupled) then
        surface%map%height = merge(surface%height - memory%uplift, surface%height, &
                                   is_measured(surface%height))
        call press_map(surface%map, surface%modulus, answer, load)
        if (allocated(answer%failure)) then
          failure = answer%failure
          return
        end if
        u(:, :, 1) = answer%pressure / surface%modulus
        call surface%operator%apply(u, by_pressure, tangential_by_pressures)
        problem%reference = max(problem%reference, maxval(abs(by_pressure)))
      end if
      in_contact = answer%pressure > 0.0_real64 .and. surface%coefficient > 0.0_real64
      if (.not. any(in_contact)) then
        memory%traction = 0.0_real64
        memory%moved = by_pressure
        memory%uplift = 0.0_real64
        memory%sticks = .false.
        return
      end if
      call list_elements(in_contact, problem%set)
      problem%limit = surface%coefficient / surface%modulus * pack(answer%pressure, in_contact)
      problem%base = pack_components(memory%moved - by_pressure, in_contact)
      q = pack_components(memory%traction + memory%change, in_contact)
      memory%change = -memory%traction
      slip = q
      call find_tractions(surface%operator, problem, q, slip, displacement, surface%space, ending, &
                          answer%interrupt)
      if (.not. ending%converged) failure = 'partial slip: the tractions did not converge'
      if (answer%interrupt%is_asked()) failure = 'interrupted'
      if (allocated(failure)) return
      memory%traction = unpack_components(q, in_contact)
      memory%change = memory%change + memory%traction
      if (.not. surface%is_coupled) exit
      change = maxval(abs(answer%pressure - pressure)) / maxval(answer%pressure)
      if (turn > 1 .and. change <= settled) exit
      pressure = answer%pressure
      call surface%operator%apply(memory%traction, u, normal_by_tractions)
      memory%uplift = surface%map%pixel_spacing(1) * u(:, :, 1)
    end do
    if (turn > turns_allowed) then
      failure = 'coupling: the pressures still change by ' // real_text(change) // ' of the ' // &
                'greatest after the last turn, expected more loading_steps, a smaller ' // &
                'friction_coefficient or coupling = ''off'''
      return
    end if
    if (surface%is_coupled) answer%displacement = answer%displacement + memory%uplift
    call surface%operator%apply(memory%traction, memory%moved, by_tractions)
    memory%moved = memory%moved + by_pressure
    memory%displacement = memory%displacement + displacement
    memory%slip = memory%slip + unpack_components(slip, in_contact)
    memory%energy = memory%energy + sum(q * slip)
    memory%sticks = unpack(.not. surface%space%stiffening > 0.0_real64, in_contact, .false.)
  end subroutine take_increment

  ! Both components of a field on the pixels in contact.
  pure function pack_components(field, in_contact) result(values)
    real(real64), intent(in) :: field(:, :, :)
    logical, intent(in) :: in_contact(:, :)
    real(real64), allocatable :: values(:, :)

    allocate (values(count(in_contact, kind=int64), 2))
    values(:, 1) = pack(field(:, :, 1), in_contact)
    values(:, 2) = pack(field(:, :, 2), in_contact)
  end function pack_components

  ! The same on all pixels, 0 out of contact.
  pure function unpack_components(values, in_contact) result(field)
    real(real64), intent(in) :: values(:, :)
    logical, intent(in) :: in_contact(:, :)
    real(real64), allocatable :: field(:, :, :)

    allocate (field(size(in_contact, 1), size(in_contact, 2), 2))
    field(:, :, 1) = unpack(values(:, 1), in_contact, 0.0_real64)
    field(:, :, 2) = unpack(values(:, 2), in_contact, 0.0_real64)
  end function unpack_components

end module asperity_slip_increments
