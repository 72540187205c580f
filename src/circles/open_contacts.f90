!> Open contacts that touch the surface deformed by the loaded ones.
!>
!> An open contact is at the shift s that minimises s**2/(2 R) + u(x + s), with u the displacement
!> by the loaded contacts. It touches where this minimum and its gap are less than the compression.
module asperity_open_contacts
  use asperity_circle_field, only: circle_set, hertz_spread, large_set, linear_residual, &
                                   near_factor, sum_error
  use asperity_circle_products, only: lowest_shift
  use asperity_constants, only: pi
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_state, only: answer_at, coupled_solution, plan_radius, &
                                    resolved_contacts, solve_state
  use asperity_hidden_contacts, only: is_hidden
  use asperity_kinds, only: real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms
  use asperity_source_tree, only: build_tree, source_tree, sum_sources
  implicit none
  private

  public :: find_touching, may_touch

contains

  !> Finds the open contacts that touch, with their penetrations and shifts.
  !>
  !> In a large set, unless `is_complete`, only those are examined again that would touch by a
  !> change of the field twice as large as any at the loaded contacts, or may no longer be hidden:
  !> outside the loads a field and its changes are nowhere larger.
  subroutine find_touching(pairs, law, accuracy, is_complete, solution, state, resolved, number)
    type(contact_pairs), intent(in) :: pairs               !! pairs of the position
    class(contact_law), intent(in) :: law                  !! of each contact
    real(real64), intent(in) :: accuracy                   !! least penetration over the largest
    logical, intent(in) :: is_complete                     !! all open contacts are examined
    type(coupled_solution), intent(inout) :: solution      !! evaluated; gets penetrations, shifts
    type(solve_state), intent(inout) :: state              !! gets the examined penetrations
    type(resolved_contacts), intent(in), optional :: resolved  !! contacts on boundary elements
    integer, allocatable, intent(out) :: number(:)         !! indices of those that touch
    logical, allocatable :: is_open(:), touches(:)
    type(contact_response) :: answer
    real(real64) :: lowest
    integer :: i, pass

    lowest = accuracy * max(0.0_real64, maxval(solution%penetration(solution%set%contact)))
    if (size(solution%set%x) > large_set) lowest = max(lowest, sum_error * solution%compression)
    allocate (is_open(size(state%gap)), source=state%gap < solution%compression)
    is_open(solution%set%contact) = .false.
    if (present(resolved)) is_open = is_open .and. .not. resolved%is_resolved
    if (allocated(state%examined) .and. .not. is_complete .and. size(solution%set%x) > large_set) &
      is_open = is_open .and. (solution%stays_open .or. &
                               state%examined > -largest_change(solution, state))
    allocate (touches(size(is_open)), source=.false.)
    if (size(solution%set%x) > large_set) then
      number = pack(state%order, is_open(state%order))
      call leave_out_far(pairs, state, solution, number)
    else
      number = pack([(i, i=1, size(is_open))], is_open)
    end if
    do pass = 1, digits(lowest)
      if (size(number) == 0) exit
      call minimise_gaps(pairs, number, state, lowest, solution, touches)
      if (allocated(solution%failure)) return
      number = pack(number, solution%penetration(number) > lowest .and. .not. touches(number))
    end do
    where (is_open .and. .not. touches) &
      solution%penetration = min(solution%penetration, 0.0_real64)
    number = pack([(i, i=1, size(touches))], touches)
    ! A contact whose load underflows stays open, and one at its residual depth after plastic flow.
    do i = 1, size(number)
      answer = answer_at(pairs, law, number(i), solution%penetration(number(i)) - lowest)
      touches(number(i)) = answer%vertical_load > 0.0_real64
    end do
    number = pack(number, touches(number))
    ! No change of the field activates a contact that stays open.
    state%examined = merge(-huge(lowest), solution%penetration, solution%stays_open)
  end subroutine find_touching

  !> Whether an open contact may touch after the changes since the open ones were examined.
  pure logical function may_touch(solution, state)
    type(coupled_solution), intent(in) :: solution         !! loads, shifts and field are set
    type(solve_state), intent(in) :: state                 !! with the examined penetrations

    may_touch = .true.
    if (allocated(state%examined)) may_touch = any(solution%penetration <= 0.0_real64 .and. &
      state%gap < solution%compression .and. state%examined > -largest_change(solution, state))
  end function may_touch

  ! Twice the largest change of a penetration since the open contacts were examined.
  pure real(real64) function largest_change(solution, state)
    type(coupled_solution), intent(in) :: solution
    type(solve_state), intent(in) :: state

    associate (loaded => solution%set%contact)
      largest_change = 2 * max(0.0_real64, maxval(abs(solution%penetration(loaded) - &
                                                      state%examined(loaded))))
    end associate
  end function largest_change

  ! Sets the penetrations of open contacts to upper bounds, by sums of low order over circles that
  ! are not near, and leaves out the indices of those that do not touch by more than the error of
  ! the sums, 1e-4: ten times that is kept.
  subroutine leave_out_far(pairs, state, solution, number)
    type(contact_pairs), intent(in) :: pairs
    type(solve_state), intent(in) :: state
    type(coupled_solution), intent(inout) :: solution
    integer, allocatable, intent(inout) :: number(:)
    real(real64), allocatable :: field(:, :), places(:, :), most(:)
    integer :: i, k

    allocate (field(6, size(number)), places(2, size(number)), most(size(number)))
    do k = 1, size(number)
      places(:, k) = [pairs%list(number(k))%x, pairs%list(number(k))%y] + &
                     solution%shift(:, number(k))
    end do
    associate (set => solution%set)
      call sum_sources(set%tree, set%load / pi, hertz_spread(set%radius), field, set%shift_since, &
                       low_order=.true., places=places)
    end associate
    !$omp parallel do schedule(static) private(i)
    do k = 1, size(number)
      i = number(k)
      call bound_penetration(pairs, state, field([1, 3, 4], k), solution, i, most(k))
    end do
    !$omp end parallel do
    number = pack(number, most > -linear_residual * solution%compression)
  end subroutine leave_out_far

  ! Bounds the penetration of an open contact by the field of the circles that are not near: near
  ! circles only displace the surface downwards.
  pure subroutine bound_penetration(pairs, state, far, solution, i, most)
    type(contact_pairs), intent(in) :: pairs
    type(solve_state), intent(in) :: state
    real(real64), intent(in) :: far(3)             ! field and slopes at the present shift
    type(coupled_solution), intent(inout) :: solution  ! gets the penetration
    integer, intent(in) :: i
    real(real64), intent(out) :: most              ! bound of the penetration at any shift

    associate (gain => 0.5_real64 * plan_radius(pairs%list(i)) * sum(far(2:)**2))
      solution%penetration(i) = solution%compression - state%gap(i) - far(1) + gain + &
                                dot_product(far(2:), solution%shift(:, i))
      solution%stays_open(i) = .false.
      most = solution%penetration(i) + gain
    end associate
  end subroutine bound_penetration

  ! Finds for each open contact the shift that minimises s**2/(2 R) + u(x + s), and its penetration
  ! there: near circles act exactly, the others by value and slope. The far field is curved, so its
  ! linear extrapolation holds only near the place of its evaluation: a contact that penetrates at
  ! its former shift keeps that shift.
  subroutine minimise_gaps(pairs, number, state, lowest, solution, touches)
    type(contact_pairs), intent(in) :: pairs
    integer, intent(in) :: number(:)               ! indices of open contacts in the list
    type(solve_state), intent(in) :: state         ! gaps
    real(real64), intent(in) :: lowest             ! penetration of one that touches
    type(coupled_solution), intent(inout) :: solution
    logical, intent(inout) :: touches(:)           ! by pair
    type(source_tree) :: tree                      ! circles, and open contacts as targets
    real(real64), allocatable :: field(:, :)
    real(real64) :: height_after, height_before, far(3), most, shift(2)
    integer :: i, k, n

    n = size(number)
    allocate (field(6, n))
    associate (set => solution%set)
      ! The lists are at the shifted places: an inclined surface moves contacts past circles.
      call build_tree(tree, &
                      [set%x + set%shift(1, :), pairs%list(number)%x + solution%shift(1, number)], &
                      [set%y + set%shift(2, :), pairs%list(number)%y + solution%shift(2, number)], &
                      [set%radius, spread(0.0_real64, 1, n)], near_factor, size(set%x))
      if (allocated(tree%failure)) then
        solution%failure = tree%failure
        return
      end if
      tree%translation = set%tree%translation
      call sum_sources(tree, set%load / pi, hertz_spread(set%radius), field)
      !$omp parallel do schedule(dynamic, 64) if(n > large_set) &
      !$omp   private(i, height_after, height_before, far, most, shift)
      do k = 1, n
        i = number(k)
        far = field([1, 3, 4], k)
        shift = solution%shift(:, i)
        associate (near => tree%near(tree%first(k):tree%first(k + 1) - 1), &
                   p => solution%penetration(i), reach => solution%compression - state%gap(i))
          call bound_penetration(pairs, state, far, solution, i, most)
          if (most < 0.0_real64) cycle
          solution%stays_open(i) = is_hidden(pairs, set, near, i)
          if (solution%stays_open(i)) then
            p = 0.0_real64
            cycle
          end if
          call find_lowest_place(pairs%list(i)%x, pairs%list(i)%y, plan_radius(pairs%list(i)), &
                                 set, near, far, 0.1_real64 * lowest, shift, height_before, &
                                 height_after)
          touches(i) = reach - height_before > lowest
          p = reach - height_after
          solution%shift(:, i) = shift
        end associate
      end do
      !$omp end parallel do
    end associate
  end subroutine minimise_gaps

  ! Minimises the height of one contact over its shift, by Newton's method with backtracking. Long:
  ! a place, a field and a start each are several values.
  pure subroutine find_lowest_place(x, y, radius, set, near, far, accuracy, shift, height_before, &
                                    lowest)
    real(real64), intent(in) :: x, y, radius
    type(circle_set), intent(in) :: set
    integer, intent(in) :: near(:)
    real(real64), intent(in) :: far(3)                ! at the start: field, slopes
    real(real64), intent(in) :: accuracy
    real(real64), intent(inout) :: shift(2)
    real(real64), intent(out) :: height_before, lowest ! height at the start, at the end
    real(real64) :: first_shift(2), s(2), newton_step(2), current(6), trial(6)
    integer :: step, halving

    first_shift = shift
    s = first_shift
    current = height_at(s)
    height_before = current(1)
    do step = 1, digits(radius)
      if (.not. radius * dot_product(current(2:3), current(2:3)) > accuracy) exit
      newton_step = lowest_shift(current(4:), 1.0_real64 / radius, current(2:3))
      do halving = 1, digits(radius)
        trial = height_at(s + newton_step)
        if (trial(1) <= current(1) + 1.0e-4_real64 * dot_product(current(2:3), newton_step)) exit
        newton_step = newton_step / 2
      end do
      if (halving > digits(radius)) exit
      s = s + newton_step
      current = trial
    end do
    shift = s
    lowest = current(1)

  contains

    ! Height at a shift: value, slopes, second derivatives xx, xy, yy.
    pure function height_at(s)
      real(real64), intent(in) :: s(2)
      real(real64) :: height_at(6), dx, dy, r, slope_over_distance, anisotropy
      type(mutual_terms) :: terms
      integer :: j, k

      height_at = [far(1) + dot_product(far(2:), s - first_shift) + dot_product(s, s) / &
                   (2 * radius), &
                far(2:) + s / radius, [1, 0, 1] / radius]
      do k = 1, size(near)
        j = near(k)
        dx = x + s(1) - (set%x(j) + set%shift(1, j))
        dy = y + s(2) - (set%y(j) + set%shift(2, j))
        r = hypot(dx, dy)
        call mutual_displacement(r, 0.0_real64, set%radius(j), terms)
        slope_over_distance = terms%bend
        anisotropy = 0.0_real64
        if (r > 0.0_real64) then
          slope_over_distance = terms%slope / r
          anisotropy = (terms%bend - slope_over_distance) / r**2
        end if
        height_at = height_at + set%load(j) * [terms%on_first, slope_over_distance * dx, &
                                               slope_over_distance * dy, &
                                         slope_over_distance + anisotropy * dx**2, anisotropy * &
                                           dx * dy, &
                                         slope_over_distance + anisotropy * dy**2]
      end do
    end function height_at

  end subroutine find_lowest_place

end module asperity_open_contacts
