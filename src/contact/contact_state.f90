!> The contacts of one position at one compression, which effects change.
module asperity_contact_state
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_kinds, only: real64
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: contact_state, interaction_solution, start_state, answer_all, in_contact
  public :: total_load, total_vertical_load, controlled_load, load_rounding

  integer, parameter :: thread_threshold = 1000  ! number of pairs from which threads are started

  ! Error of a load by rounding, over the stiffness times the compression. Derived: the compression
  ! is in error by one epsilon, and the elastic and adhesive terms whose difference the load is by a
  ! few. Test: test_loads_near_zero of test_adhesion.py.
  real(real64), parameter :: rounding = 16 * epsilon(1.0_real64)

  !> Solution of interacting contacts at one compression.
  type :: interaction_solution
    integer :: elements = 0                        !! number of boundary elements
    integer :: clusters = 0                        !! number of their grids
    real(real64) :: error = 0.0_real64             !! estimated relative error of the load
    real(real64) :: area_error = 0.0_real64        !! estimated relative error of the area
    real(real64) :: nested = 0.0_real64            !! load share of contacts inside others
    type(solve_ending) :: ending                   !! residual and iterations
    real(real64), allocatable :: penetration(:)    !! of each pair
    real(real64), allocatable :: area(:)           !! of each pair
    real(real64), allocatable :: pressure(:)       !! greatest, on boundary elements; else 0
    logical, allocatable :: is_resolved(:)         !! by boundary elements
    logical :: is_elastic = .true.                 !! of contacts with Hertz' law
    real(real64), allocatable :: shift(:, :)       !! of Hertzian contacts, along x and y (2, pair)
  end type interaction_solution

  !> All contacts at one compression, in the units of their pairs.
  type :: contact_state
    real(real64) :: compression = 0.0_real64             !! compression of the position
    real(real64) :: time = 0.0_real64                !! time since the begin of loading
    real(real64) :: tolerance = 1.0_real64           !! relative, of a simulated effect
    class(contact_law), allocatable :: law           !! law of each contact
    real(real64), allocatable :: penetration(:)      !! of each pair; not positive where open
    type(contact_response), allocatable :: answers(:)  !! response of each pair
    !> law of an effect, prepared for all states of the position; not allocated: none yet
    class(contact_law), allocatable :: prepared
    !> solution of interacting contacts; not allocated: none at this compression
    type(interaction_solution), allocatable :: solution
  end type contact_state

contains

  !> Starts with non-interacting contacts, whose penetration is the compression less the gap.
  subroutine start_state(pairs, law, compression, state)
    type(contact_pairs), intent(in) :: pairs  !! pairs of the position
    class(contact_law), intent(in) :: law     !! law of each contact
    real(real64), intent(in) :: compression       !! compression, length, 0 or more
    type(contact_state), intent(inout) :: state  !! contacts at this compression

    state%compression = compression
    state%time = 0.0_real64
    state%tolerance = 1.0_real64
    if (allocated(state%solution)) deallocate (state%solution)
    if (allocated(state%law)) deallocate (state%law)
    allocate (state%law, source=law)
    state%penetration = compression - pairs%list%gap
    if (allocated(state%answers)) deallocate (state%answers)
    allocate (state%answers(size(pairs%list)))
    call answer_all(pairs, state)
  end subroutine start_state

  !> Evaluates the law of each contact at its penetration.
  subroutine answer_all(pairs, state)
    type(contact_pairs), intent(in) :: pairs     !! pairs of the position
    type(contact_state), intent(inout) :: state  !! gets the responses
    integer :: i

    !$omp parallel do schedule(static) if(size(pairs%list) > thread_threshold)
    do i = 1, size(pairs%list)
      call state%law%respond(pairs%list(i), i, state%penetration(i), state%answers(i))
    end do
    !$omp end parallel do
  end subroutine answer_all

  !> Whether a pair is in contact: it has a contact circle or a load, or is at first touch.
  elemental logical function in_contact(state, i)
    type(contact_state), intent(in) :: state  !! contacts of the position
    integer, intent(in) :: i                  !! place of the pair

    in_contact = state%answers(i)%contact_radius > 0.0_real64 .or. &
                 abs(state%answers(i)%load) > 0.0_real64 .or. &
                 .not. (state%penetration(i) < 0.0_real64 .or. state%penetration(i) > 0.0_real64)
  end function in_contact

  !> Sum of the forces normal to the contacts.
  pure real(real64) function total_load(state)
    type(contact_state), intent(in) :: state  !! contacts of the position

    total_load = sum(state%answers%load)
  end function total_load

  !> Sum of the vertical loads.
  pure real(real64) function total_vertical_load(state)
    type(contact_state), intent(in) :: state  !! contacts of the position

    total_vertical_load = sum(state%answers%vertical_load)
  end function total_vertical_load

  !> The total load that is prescribed: vertical loads or normal forces.
  pure real(real64) function controlled_load(pairs, state)
    type(contact_pairs), intent(in) :: pairs  !! pairs of the position
    type(contact_state), intent(in) :: state  !! contacts of the position

    if (pairs%vertical) then
      controlled_load = total_vertical_load(state)
    else
      controlled_load = total_load(state)
    end if
  end function controlled_load

  !> Rounding error of the total load: what neighbouring numbers of the compression change it by. It
  !> is more than a share of the load where the load is the small difference of large forces.
  pure real(real64) function load_rounding(state) result(error)
    type(contact_state), intent(in) :: state  !! contacts of the position

    error = rounding * state%compression * sum(abs(state%answers%stiffness))
  end function load_rounding

end module asperity_contact_state
