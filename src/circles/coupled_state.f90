!> State of the solver of coupled contacts, and the residual of its equations.
!>
!> With penetrations p and shifts s given, the equations of loaded contacts are r_i = p_i + g_i +
!> u_i + s_i**2/(2 R_i) - c = 0 and s_i/R_i + slope_i = 0 (circle_field). The residual is the
!> largest error of them, as a penetration, over the largest penetration.
module asperity_coupled_state
  use asperity_circle_field, only: circle_set, find_field, inclination_factor, large_set, &
                                   list_near_circles, rounding_error
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_kinds, only: real64
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: answer_at, correct_to_load, coupled_solution, evaluate_state, find_carried_load, &
            gather_circles, penetration_without_load, plan_radius, raise_to_load, &
            resolved_contacts, solve_state, update_circles

  !> Contacts that boundary elements resolve, as the Hertzian contacts see them; arrays by pair.
  type :: resolved_contacts
    logical, allocatable :: is_resolved(:)   !! the pair is one of them
    real(real64), allocatable :: x(:), y(:)  !! centre of its pressure [length]
    !> gap with which its law has the load on elements, without meaning where there is none; for a
    !> Hertzian contact its own gap, with the difference of displacements by elements and by circles
    !> [length]
    real(real64), allocatable :: gap(:)
  end type resolved_contacts

  !> Solution of coupled contacts.
  type :: coupled_solution
    real(real64) :: compression = 0.0_real64        !! compression c since first touch [length]
    real(real64), allocatable :: penetration(:)     !! by pair [length], 0 or less where open
    !> by pair: open at any compression, as it is hidden in another cap or has no load of its own on
    !> boundary elements; its penetration is 0
    logical, allocatable :: stays_open(:)
    real(real64), allocatable :: shift(:, :)        !! lateral shifts (2, pair) [length]
    real(real64), allocatable :: outer_field(:, :)  !! field from outside, as in `circle_set`
    type(circle_set) :: set                         !! loaded contacts and their field
    type(solve_ending) :: ending                    !! convergence, iterations, residual
    integer :: products = 0                         !! products with the Hessian, all steps
    integer :: fields = 0                           !! evaluations of the field, all steps
    character(len=:), allocatable :: failure        !! message, where there is no solution
  end type coupled_solution

  !> State of the solver between two steps.
  type :: solve_state
    real(real64), allocatable :: gap(:)             !! first touch of every pair [length]
    real(real64), allocatable :: load_gradient(:)   !! dPhi/dV by circle [length]
    real(real64), allocatable :: shift_gradient(:, :)  !! dPhi/ds over V (2, circle) [1]
    real(real64), allocatable :: contact_residual(:)   !! error of the equations, by circle [length]
    real(real64) :: target = -1.0_real64            !! given load over modulus; below 0: none
    real(real64) :: residual = 0.0_real64           !! largest error over the largest penetration
    logical :: rebuilds_lists = .false.             !! the next field has new neighbour lists
    integer, allocatable :: order(:)                !! order of pairs, square by square
    real(real64), allocatable :: examined(:)        !! penetrations when open contacts were examined
  end type solve_state

  ! Growth of a circle [1] from which on it has other near neighbours, as has one that has moved by
  ! its radius; derived: the error of sums, of the fourth power, at most doubles. Until then near
  ! pairs are kept: if they were found at each field, the potential would jump by the error of the
  ! sums where a pair is on the border.
  real(real64), parameter :: list_growth = 2.0_real64**0.25_real64
  ! Share of the height between centres [1] below which a penetration stays; chosen, eps**(1/3);
  ! test: coupled_suite.f90.
  real(real64), parameter, public :: level_share = 0.999999_real64

contains

  !> Response of a contact to a penetration, at most that at which the centres are level.
  pure function answer_at(pairs, law, i, penetration) result(answer)
    type(contact_pairs), intent(in) :: pairs     !! pairs of the position
    class(contact_law), intent(in) :: law        !! of each contact
    integer, intent(in) :: i                     !! number of the pair
    real(real64), intent(in) :: penetration      !! penetration of the pair
    type(contact_response) :: answer

    call law%respond(pairs%list(i), i, min(penetration, level_share * pairs%list(i)%zc), answer)
  end function answer_at

  !> The largest penetration of a contact without a load, by bisection: 0 by Hertz' law, that of the
  !> residual depth after plastic flow.
  impure elemental real(real64) function penetration_without_load(pairs, law, i, deep) result(low)
    type(contact_pairs), intent(in) :: pairs     !! pairs of the position
    class(contact_law), intent(in) :: law        !! of each contact
    integer, intent(in) :: i                     !! number of the pair
    real(real64), intent(in) :: deep             !! penetration with a load
    type(contact_response) :: answer
    real(real64) :: high, middle
    integer :: halving

    low = 0.0_real64
    high = deep
    do halving = 1, digits(low)
      middle = 0.5_real64 * (low + high)
      answer = answer_at(pairs, law, i, middle)
      if (answer%vertical_load > 0.0_real64) then
        high = middle
      else
        low = middle
      end if
    end do
  end function penetration_without_load

  !> Adds one number to the penetrations of all but those that stay open, so that the contacts carry
  !> a given load.
  !>
  !> Newton's method on load**(2/3), nearly linear, in a bracket; bisection where a step leaves it.
  !> Exits: the load is met to `rounding_error`; the bracket is as narrow as rounding allows.
  subroutine raise_to_load(pairs, law, target, solution)
    type(contact_pairs), intent(in) :: pairs              !! pairs of the position
    class(contact_law), intent(in) :: law                 !! of each contact
    real(real64), intent(in) :: target                    !! load over modulus
    type(coupled_solution), intent(inout) :: solution     !! penetrations are changed
    real(real64) :: low, high, rise, total, slope, most, last_rise
    integer :: i, try

    ! At most until the centres of one contact are level.
    most = huge(most)
    !$omp parallel do schedule(static) reduction(min:most) if(size(pairs%list) > large_set)
    do i = 1, size(pairs%list)
      if (.not. solution%stays_open(i)) &
        most = min(most, level_share * pairs%list(i)%zc - solution%penetration(i))
    end do
    !$omp end parallel do
    low = -maxval(solution%penetration, .not. solution%stays_open)
    high = most
    rise = min(max(0.0_real64, low), most)
    last_rise = rise
    do try = 1, 200
      call find_carried_load(pairs, law, solution, rise, total, slope)
      if (abs(total - target) <= rounding_error * target) exit
      if (total < target) then
        low = rise
      else
        high = rise
      end if
      if (.not. high - low > epsilon(high) * max(abs(low), abs(high))) exit
      last_rise = rise
      rise = 0.5_real64 * (low + high)
      if (total > 0.0_real64 .and. slope > 0.0_real64) &
        rise = last_rise + 1.5_real64 * total / slope * &
             ((target / total)**(2.0_real64 / 3.0_real64) - 1.0_real64)
      if (rise <= low .or. rise >= high) then
        rise = 0.5_real64 * (low + high)
        if (high >= most .and. total < target) rise = max(rise, most - 0.1_real64 * (most - low))
      end if
    end do
    where (.not. solution%stays_open) solution%penetration = solution%penetration + rise
  end subroutine raise_to_load

  !> Corrects a solution to a given load: the compression changes with the penetrations.
  subroutine correct_to_load(pairs, law, target, solution)
    type(contact_pairs), intent(in) :: pairs              !! pairs of the position
    class(contact_law), intent(in) :: law                 !! of each contact
    real(real64), intent(in) :: target                    !! load over modulus
    type(coupled_solution), intent(inout) :: solution     !! penetrations and compression change
    real(real64) :: before
    integer :: first

    first = solution%set%contact(1)
    before = solution%penetration(first)
    call raise_to_load(pairs, law, target, solution)
    solution%compression = solution%compression + (solution%penetration(first) - before)
  end subroutine correct_to_load

  !> Total load of all contacts with a common rise of their penetrations.
  subroutine find_carried_load(pairs, law, solution, rise, total, slope)
    type(contact_pairs), intent(in) :: pairs              !! pairs of the position
    class(contact_law), intent(in) :: law                 !! of each contact
    type(coupled_solution), intent(in) :: solution        !! penetrations, and which stay open
    real(real64), intent(in) :: rise                      !! penetration added to each
    real(real64), intent(out) :: total                    !! load over modulus, or the vertical one
    real(real64), intent(out) :: slope                    !! derivative by the penetration
    type(contact_response) :: response
    ! Partial sums, in an order that does not depend on the number of threads.
    real(real64), dimension(1 + size(pairs%list) / large_set) :: load, stiffness
    real(real64) :: penetration
    integer :: i, part

    load = 0.0_real64
    stiffness = 0.0_real64
    !$omp parallel do schedule(static) private(i, penetration, response) if(size(load) > 1)
    do part = 1, size(load)
      do i = large_set * (part - 1) + 1, min(large_set * part, size(pairs%list))
        penetration = solution%penetration(i) + rise
        if (solution%stays_open(i) .or. .not. penetration > 0.0_real64) cycle
        call law%respond(pairs%list(i), i, penetration, response)
        load(part) = load(part) + merge(response%vertical_load, response%load, pairs%vertical)
        stiffness(part) = stiffness(part) + &
                          response%stiffness / merge(1.0_real64, response%cosine, pairs%vertical)
      end do
    end do
    !$omp end parallel do
    total = sum(load) / pairs%modulus
    slope = sum(stiffness) / pairs%modulus
  end subroutine find_carried_load

  !> Updates the circles of loaded contacts, and rebuilds their neighbour lists where needed.
  subroutine update_circles(pairs, law, solution, state, resolved)
    type(contact_pairs), intent(in) :: pairs               !! pairs of the position
    class(contact_law), intent(in) :: law                  !! of each contact
    type(coupled_solution), intent(inout) :: solution      !! penetrations, shifts; gets circles
    type(solve_state), intent(inout) :: state              !! gets room for gradient and residual
    type(resolved_contacts), intent(in), optional :: resolved  !! those solved elsewhere
    logical :: is_same

    call gather_circles(pairs, law, solution, state, resolved, is_same)
    associate (set => solution%set)
      if (size(set%x) == 0) return
      if (is_same) is_same = all(set%radius < list_growth * set%listed(1, :) .and. &
                                 set%listed(1, :) < list_growth * set%radius .and. &
                                 norm2(set%shift - set%listed(2:, :), 1) < set%listed(1, :))
      if (is_same .and. .not. state%rebuilds_lists) return
      call list_near_circles(set)
      state%rebuilds_lists = .false.
      if (allocated(set%tree%failure)) solution%failure = set%tree%failure
    end associate
  end subroutine update_circles

  !> Updates circles and field, and finds gradient and residual.
  subroutine evaluate_state(pairs, law, solution, state, resolved)
    type(contact_pairs), intent(in) :: pairs               !! pairs of the position
    class(contact_law), intent(in) :: law                  !! of each contact
    !> penetrations and shifts; gets circles, field and, under a target, the compression
    type(coupled_solution), intent(inout) :: solution
    type(solve_state), intent(inout) :: state              !! gets gradient and residual
    type(resolved_contacts), intent(in), optional :: resolved  !! those solved elsewhere
    real(real64) :: largest
    integer :: k

    call update_circles(pairs, law, solution, state, resolved)
    state%residual = 0.0_real64
    associate (set => solution%set)
      if (size(set%x) == 0 .or. allocated(solution%failure)) return
      call find_field(set)
      solution%fields = solution%fields + 1
      largest = maxval(solution%penetration(set%contact))
      !$omp parallel do schedule(static) if(size(set%x) > large_set)
      do k = 1, size(set%x)
        call set_gradient(k)
      end do
      !$omp end parallel do
      if (state%target > 0.0_real64) &
        solution%compression = dot_product(set%stiffness, state%load_gradient) / sum(set%stiffness)
      !$omp parallel do schedule(static) if(size(set%x) > large_set)
      do k = 1, size(set%x)
        call set_residual(k)
      end do
      !$omp end parallel do
      state%residual = maxval(state%contact_residual) / largest
      ! NaN or infinity in the gradient is no solution.
      if (.not. sum(abs(state%load_gradient)) <= huge(largest)) state%residual = huge(largest)
    end associate

  contains

    ! Sets the gradient of one circle, without the compression.
    subroutine set_gradient(k)
      integer, intent(in) :: k

      associate (set => solution%set, i => solution%set%contact(k))
        state%load_gradient(k) = solution%penetration(i) + state%gap(i) + set%displacement(k) + &
                                 0.5_real64 * set%curvature(k) * sum(set%shift(:, k)**2)
        state%shift_gradient(:, k) = set%curvature(k) * set%shift(:, k) + set%slope(:, k)
        if (set%shift_fixed(k)) state%shift_gradient(:, k) = 0.0_real64
      end associate
    end subroutine set_gradient

    ! Subtracts the compression, and sets the error of the equations of one circle.
    subroutine set_residual(k)
      integer, intent(in) :: k
      real(real64) :: shift_residual

      associate (set => solution%set)
        state%load_gradient(k) = state%load_gradient(k) - solution%compression
        ! Change of the penetration by the error of the shift, to first order.
        shift_residual = 0.0_real64
        if (.not. set%shift_fixed(k)) shift_residual = norm2(state%shift_gradient(:, k)) / &
          set%curvature(k) * &
          (norm2(set%slope(:, k)) + set%curvature(k) * norm2(set%shift(:, k)))
        state%contact_residual(k) = max(abs(state%load_gradient(k)), shift_residual)
      end associate
    end subroutine set_residual

  end subroutine evaluate_state

  !> Sets the circles of the contacts that carry load.
  subroutine gather_circles(pairs, law, solution, state, resolved, is_same)
    type(contact_pairs), intent(in) :: pairs               !! pairs of the position
    class(contact_law), intent(in) :: law                  !! of each contact
    type(coupled_solution), intent(inout) :: solution      !! penetrations, shifts; gets circles
    type(solve_state), intent(inout) :: state              !! gets room for gradient and residual
    type(resolved_contacts), intent(in), optional :: resolved  !! those solved elsewhere
    logical, intent(out) :: is_same                        !! the contacts are those of the circles
    type(contact_response), allocatable :: answer(:)
    integer, allocatable :: contact(:)
    logical, allocatable :: is_loaded(:)
    integer :: i, k, n

    if (allocated(state%order)) then
      contact = pack(state%order, solution%penetration(state%order) > 0.0_real64)
    else
      contact = pack([(i, i=1, size(state%gap))], solution%penetration > 0.0_real64)
    end if
    allocate (answer(size(contact)), is_loaded(size(contact)))
    !$omp parallel do schedule(static) if(size(contact) > large_set)
    do k = 1, size(contact)
      call find_answer(k)
    end do
    !$omp end parallel do
    n = count(is_loaded)
    if (n < size(contact)) then
      contact = pack(contact, is_loaded)
      answer = pack(answer, is_loaded)
    end if
    associate (set => solution%set)
      is_same = .false.
      if (allocated(set%contact)) then
        if (size(set%contact) == n) is_same = all(set%contact == contact)
      end if
      if (.not. is_same) call set%allocate_arrays(n)
      if (allocated(state%load_gradient)) deallocate (state%load_gradient, state%shift_gradient, &
                                                      state%contact_residual)
      allocate (state%load_gradient(n), state%shift_gradient(2, n), state%contact_residual(n))
      set%contact = contact
      if (allocated(solution%outer_field)) set%outer_field = solution%outer_field(:, set%contact)
      !$omp parallel do schedule(static) reduction(.and.:is_same) if(n > large_set)
      do k = 1, n
        call set_circle(pairs, answer(k), solution, k, resolved, is_same)
      end do
      !$omp end parallel do
    end associate

  contains

    ! Finds the response of one contact. A load that underflows over the modulus is none.
    subroutine find_answer(k)
      integer, intent(in) :: k

      answer(k) = answer_at(pairs, law, contact(k), solution%penetration(contact(k)))
      is_loaded(k) = answer(k)%vertical_load / max(1.0_real64, pairs%modulus) > 0.0_real64
    end subroutine find_answer

  end subroutine gather_circles

  !> Radius of curvature of the vertical gap of a pair, geometric mean of the principal ones.
  elemental real(real64) function plan_radius(pair) result(radius)
    type(contact_pair), intent(in) :: pair   !! pair of asperities, or one and a plane

    radius = pair%radius * (pair%zc / pair%s)**2
  end function plan_radius

  ! Sets the circle of a response to its contact. `is_kept` becomes false where its centre of
  ! pressure has moved.
  subroutine set_circle(pairs, answer, solution, k, resolved, is_kept)
    type(contact_pairs), intent(in) :: pairs
    type(contact_response), intent(in) :: answer
    type(coupled_solution), intent(inout) :: solution
    integer, intent(in) :: k
    type(resolved_contacts), intent(in), optional :: resolved
    logical, intent(inout) :: is_kept
    real(real64) :: factor, place(2)

    associate (set => solution%set, i => solution%set%contact(k))
      place = [pairs%list(i)%x, pairs%list(i)%y]
      associate (pair => pairs%list(i))
        set%curvature(k) = 1.0_real64 / plan_radius(pair)
        ! The curvatures of the vertical gap are in the ratio 1 + slope**2.
        set%own_oval(k) = cmplx(pair%lower_x - pair%upper_x, pair%lower_y - pair%upper_y, &
                                real64)**2 / (2 * pair%zc**2 + pair%d**2)
      end associate
      set%shift(:, k) = solution%shift(:, i)
      set%shift_fixed(k) = .false.
      if (present(resolved)) set%shift_fixed(k) = resolved%is_resolved(i)
      if (set%shift_fixed(k)) then
        place = [resolved%x(i), resolved%y(i)]
        set%curvature(k) = 0.0_real64
        set%own_oval(k) = 0.0_real64
        set%shift(:, k) = 0.0_real64
      end if
      ! A centre of pressure has moved: the neighbour lists must be rebuilt.
      if (any(abs(place - [set%x(k), set%y(k)]) > 0.0_real64)) is_kept = .false.
      set%x(k) = place(1)
      set%y(k) = place(2)
      factor = inclination_factor(answer%cosine) / pairs%modulus
      set%load(k) = answer%vertical_load * factor
      set%stiffness(k) = answer%stiffness * factor
      set%load_share(k) = 1.0_real64 / inclination_factor(answer%cosine)
      if (.not. pairs%vertical) set%load_share(k) = set%load_share(k) / answer%cosine
      set%radius(k) = answer%contact_radius * sqrt(answer%cosine)
    end associate
  end subroutine set_circle

end module asperity_coupled_state
