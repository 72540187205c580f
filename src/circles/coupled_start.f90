!> Start of the iteration of coupled contacts.
module asperity_coupled_start
  use asperity_circle_field, only: inclination_factor
  use asperity_coarse_circles, only: circles_per_square, coarse_circles, gather_squares, &
                                     pressed_displacement, shared_change, sum_of_squares
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_state, only: answer_at, coupled_solution, evaluate_state, raise_to_load, &
                                    resolved_contacts, solve_state
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: real64
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: prepare_start, scale_start

  !> Contacts up to which squares are of no use [1]; derived: four squares.
  integer, parameter, public :: few_contacts = 4 * int(circles_per_square)

contains

  !> Prepares a start: given penetrations, or those of isolated contacts, at the compression or the
  !> load; of more than `few_contacts`, with their coupling on the coarse level of squares.
  subroutine prepare_start(pairs, law, solution, state, target, resolved)
    type(contact_pairs), intent(in) :: pairs               !! pairs of the position
    class(contact_law), intent(in) :: law                  !! of each contact
    type(coupled_solution), intent(inout) :: solution      !! gets what is not allocated
    type(solve_state), intent(out) :: state                !! gaps, target and order of pairs
    real(real64), intent(in), optional :: target           !! given total load [force]
    type(resolved_contacts), intent(in), optional :: resolved  !! contacts on boundary elements
    type(coarse_circles) :: coarse
    real(real64), allocatable :: x(:), y(:)
    logical :: is_isolated
    integer :: n

    n = size(pairs%list)
    solution%ending = solve_ending()
    state%gap = pairs%list%gap
    if (present(resolved)) state%gap = resolved%gap
    if (n > few_contacts) then
      ! In the order of squares neighbours are near in memory.
      x = pairs%list%x
      y = pairs%list%y
      call gather_squares(x, y, coarse)
      allocate (state%order(n))
      call sort_keys(real(coarse%square, real64), state%order)
    end if
    is_isolated = .not. allocated(solution%penetration)
    if (is_isolated) then
      solution%penetration = solution%compression - state%gap
      if (present(target)) solution%penetration = -state%gap
      allocate (solution%shift(2, n), source=0.0_real64)
    end if
    if (is_isolated .or. .not. allocated(solution%stays_open)) &
      solution%stays_open = spread(.false., 1, n)
    if (present(target)) then
      state%target = target / pairs%modulus
      call raise_to_load(pairs, law, state%target, solution)
    end if
    if (is_isolated .and. count(solution%penetration > 0.0_real64) > few_contacts) &
      call displace_squares(pairs, law, state%target, coarse, solution)
  end subroutine prepare_start

  !> Scales the penetrations of isolated contacts by the factor t that minimises the potential: its
  !> parts are proportional to t**(5/2) (contacts), t**3 (interaction) and -t**(3/2) (work). Without
  !> it deep scenes end after two steps (test: a load beyond the centres in
  !> test/effects/test_effects.py).
  subroutine scale_start(pairs, law, solution, state)
    type(contact_pairs), intent(in) :: pairs           !! pairs of the position
    class(contact_law), intent(in) :: law              !! of each contact
    type(coupled_solution), intent(inout) :: solution  !! isolated contacts, evaluated; then scaled
    type(solve_state), intent(inout) :: state          !! gets its gradient
    real(real64) :: ratio, t, work
    integer :: i

    work = dot_product(solution%set%load, solution%penetration(solution%set%contact))
    if (.not. work > 0.0_real64) return
    ! t + ratio t**(3/2) = 1, by Newton's method from above.
    ratio = 2 * solution%set%energy / work
    t = 1.0_real64
    do i = 1, digits(t)
      t = t - (t + ratio * t**1.5_real64 - 1.0_real64) / (1.0_real64 + 1.5_real64 * ratio * sqrt(t))
    end do
    where (solution%penetration > 0.0_real64) solution%penetration = t * solution%penetration
    call evaluate_state(pairs, law, solution, state)
  end subroutine scale_start

  ! Reduces penetrations by the displacements of squares, each one contact with the laws of its
  ! members at one common displacement, by Newton's method.
  subroutine displace_squares(pairs, law, target, coarse, solution)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    real(real64), intent(in) :: target
    type(coarse_circles), intent(inout) :: coarse  ! gathered
    type(coupled_solution), intent(inout) :: solution  ! penetrations are changed
    type(contact_response) :: answer
    real(real64), allocatable :: load(:), stiffness(:)
    real(real64), allocatable, dimension(:) :: loads, displacement, residual, change, uniform
    integer :: i, step

    allocate (load(size(pairs%list)), stiffness(size(pairs%list)))
    coarse%stiffness = spread(0.0_real64, 1, coarse%columns * coarse%rows)
    allocate (displacement(coarse%columns * coarse%rows), source=0.0_real64)
    do step = 1, digits(target)
      if (pairs%interrupt%is_asked()) return
      load = 0.0_real64
      stiffness = 0.0_real64
      !$omp parallel do schedule(static) private(answer)
      do i = 1, size(load)
        if (.not. solution%penetration(i) > 0.0_real64) cycle
        answer = answer_at(pairs, law, i, solution%penetration(i))
        load(i) = answer%vertical_load * inclination_factor(answer%cosine) / pairs%modulus
        stiffness(i) = answer%stiffness * inclination_factor(answer%cosine) / pairs%modulus
      end do
      !$omp end parallel do
      coarse%stiffness = max(0.5_real64 * coarse%stiffness, sum_of_squares(coarse, stiffness))
      loads = sum_of_squares(coarse, load)
      residual = displacement - pressed_displacement(coarse, loads)
      ! The common part is the compression, far more than the differences.
      if (target > 0.0_real64) &
        residual = residual - dot_product(coarse%stiffness, residual) / sum(coarse%stiffness)
      change = change_everywhere(residual)
      if (target > 0.0_real64) then
        uniform = change_everywhere(spread(1.0_real64, 1, size(loads)))
        change = change - uniform * (sum(coarse%stiffness * change) / &
                                     sum(coarse%stiffness * uniform))
      end if
      ! A load is convex in its penetration: it decreases by less than its tangent.
      where (loads > 0.0_real64) change = max(change, -0.9_real64 * loads / coarse%stiffness)
      ! The displacement is changed, not computed from the new loads: it may be a hundred times a
      ! penetration, and 1 % of it all of one.
      solution%penetration = solution%penetration + change(coarse%square)
      displacement = displacement - change
      if (target > 0.0_real64) call raise_to_load(pairs, law, target, solution)
      if (maxval(change) - minval(change) < 0.01_real64 * maxval(solution%penetration)) exit
    end do

  contains

    ! Change of the displacement of all squares, also those without load.
    function change_everywhere(residual) result(change)
      real(real64), intent(in) :: residual(:)
      real(real64) :: change(size(residual))

      change = shared_change(coarse, residual)
      change = merge(change, residual - pressed_displacement(coarse, coarse%stiffness * change), &
                     coarse%stiffness > 0.0_real64)
    end function change_everywhere

  end subroutine displace_squares

end module asperity_coupled_start
