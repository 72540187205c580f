!> Open contacts that touch on the surface which the loaded ones leave.
!>
!> An open contact stands at the shift s at which s**2/(2 R) + u(x + s) is least; it touches where
!> that and its gap are less than the compression.
module asperity_open_contacts
  use asperity_circle_field, only: circle_set, hertz_spread, many, most_repeats, near_factor, &
                                   sum_error
  use asperity_circle_products, only: lowest_shift
  use asperity_constants, only: pi
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_state, only: answer_at, coupled_solution, far_below, resolved_contacts, &
                                    solve_state
  use asperity_hidden_contacts, only: is_hidden
  use asperity_kinds, only: real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms
  use asperity_source_tree, only: plant_tree, sum_sources
  implicit none
  private

  public :: find_touching, may_touch, stand_apart

  !> Searches with the field about a new place [1], halvings of the penetrations of contacts that
  !> begin to touch, and steps of the largest group that is eliminated, at most; chosen, 3 are
  !> needed, and a group need not be solved; test: coupled_suite.f90.
  integer, parameter, public :: most_looks = 8

contains

  !> Places of the open contacts that touch, with their penetrations and shifts.
  !>
  !> Of many only those are examined again, unless `is_complete`, that a change of the field twice
  !> as large as any at the loaded ones would let touch: outside the loads a field and its changes
  !> are nowhere larger than where loads are.
  subroutine find_touching(pairs, law, accuracy, is_complete, solution, state, resolved, number)
    type(contact_pairs), intent(in) :: pairs               !! pairs of the position
    class(contact_law), intent(in) :: law                  !! of each contact
    real(real64), intent(in) :: accuracy                   !! over the largest penetration
    logical, intent(in) :: is_complete                     !! all open contacts are examined
    type(coupled_solution), intent(inout) :: solution      !! evaluated; gets penetrations, shifts
    type(solve_state), intent(inout) :: state              !! gets what it examined
    type(resolved_contacts), intent(in), optional :: resolved  !! those solved elsewhere
    integer, allocatable, intent(out) :: number(:)         !! places in the list
    logical, allocatable :: is_open(:), touches(:)
    type(contact_response) :: answer
    real(real64) :: least
    integer :: i, pass

    least = accuracy * max(0.0_real64, maxval(solution%penetration(solution%set%number)))
    if (size(solution%set%x) > many) least = max(least, sum_error * solution%closing)
    allocate (is_open(size(state%gap)), source=state%gap < solution%closing)
    is_open(solution%set%number) = .false.
    if (present(resolved)) is_open = is_open .and. .not. resolved%is_one
    if (allocated(state%stood) .and. .not. is_complete .and. size(solution%set%x) > many) then
      is_open = is_open .and. state%stood > -largest_change(solution, state)
    end if
    allocate (touches(size(is_open)), source=.false.)
    number = pack([(i, i=1, size(is_open))], is_open)
    do pass = 1, most_looks
      if (size(number) == 0) exit
      call look_around(pairs, number, state, least, solution, touches)
      if (allocated(solution%failure)) return
      number = pack(number, solution%penetration(number) > least .and. .not. touches(number))
    end do
    where (is_open .and. .not. touches) &
      solution%penetration = min(solution%penetration, 0.0_real64)
    number = pack([(i, i=1, size(touches))], touches)
    ! A load that underflows is none.
    do i = 1, size(number)
      answer = answer_at(pairs, law, number(i), solution%penetration(number(i)))
      touches(number(i)) = answer%vertical_load > 0.0_real64
    end do
    number = pack(number, touches(number))
    state%stood = solution%penetration
  end subroutine find_touching

  !> Whether an open contact may touch after the changes since the open ones were examined.
  pure logical function may_touch(solution, state)
    type(coupled_solution), intent(in) :: solution         !! loads, shifts and field are set
    type(solve_state), intent(in) :: state                 !! what was examined

    may_touch = .true.
    if (allocated(state%stood)) may_touch = any(solution%penetration <= 0.0_real64 .and. &
      state%gap < solution%closing .and. state%stood > -largest_change(solution, state))
  end function may_touch

  ! Twice the largest change of a penetration since the open contacts were examined: outside the
  ! loads a field and its changes are nowhere larger than where loads are.
  pure real(real64) function largest_change(solution, state)
    type(coupled_solution), intent(in) :: solution
    type(solve_state), intent(in) :: state

    associate (loaded => solution%set%number)
      largest_change = 2 * max(0.0_real64, maxval(abs(solution%penetration(loaded) - &
                                                      state%stood(loaded))))
    end associate
  end function largest_change

  !> Whether the tops of all near pairs of loaded contacts are farther apart than the larger circle
  !> radius: the potential of a pair has one minimum then (its least scaled eigenvalue is 0.35 for
  !> radii from 1:1 to 1:20). Which of several minima is found depends on the start.
  pure logical function stand_apart(solution)
    type(coupled_solution), intent(in) :: solution   !! solution of the position
    integer :: i, j, k

    stand_apart = .true.
    associate (set => solution%set)
      if (.not. allocated(set%one)) return
      do k = 1, size(set%one)
        i = set%one(k)
        j = set%other(k)
        stand_apart = stand_apart .and. hypot(set%x(i) - set%x(j), set%y(i) - set%y(j)) >= &
                      max(set%circle(i), set%circle(j))
      end do
    end associate
  end function stand_apart

  ! For each open contact the shift at which it is lowest, s**2/(2 R) + u(x + s), and how far it
  ! penetrates there: near neighbours act exactly, the others by value and slope. The far field
  ! is curved, so its linear extrapolation holds only near the place of its evaluation: a contact
  ! that penetrates at its former shift keeps that shift.
  subroutine look_around(pairs, number, state, least, solution, touches)
    type(contact_pairs), intent(in) :: pairs
    integer, intent(in) :: number(:)               ! places of the open ones in the list
    type(solve_state), intent(inout) :: state      ! gaps; gets its tree
    real(real64), intent(in) :: least              ! penetration of one that touches
    type(coupled_solution), intent(inout) :: solution
    logical, intent(inout) :: touches(:)           ! of all pairs
    real(real64), allocatable :: field(:, :)
    real(real64) :: above, before, far(3), shift(2)
    integer :: i, k, n
    logical :: settled

    n = size(number)
    allocate (field(6, n))
    associate (set => solution%set)
      ! Near where they are: far off a tilted surface moves them past many a circle.
      call plant_tree(state%open_tree, &
                      [set%x + set%move(1, :), pairs%list(number)%x + solution%move(1, number)], &
                      [set%y + set%move(2, :), pairs%list(number)%y + solution%move(2, number)], &
                      [set%circle, spread(0.0_real64, 1, n)], near_factor, size(set%x))
      if (allocated(state%open_tree%failure)) then
        solution%failure = state%open_tree%failure
        return
      end if
      call sum_sources(state%open_tree, set%load / pi, hertz_spread * set%circle**2, field)
      !$omp parallel do schedule(dynamic, 64) private(i, above, before, far, shift, settled) &
      !$omp   if(n > many)
      do k = 1, n
        i = number(k)
        far = field([1, 3, 4], k)
        shift = solution%move(:, i)
        associate (near => state%open_tree%near(state%open_tree%first(k): &
                                             state%open_tree%first(k + 1) - 1), &
                   p => solution%penetration(i), rise => solution%closing - state%gap(i), &
                   gain => 0.5_real64 * pairs%list(i)%radius * dot_product(far(2:), far(2:)))
          ! Near circles only push down: without them it would not touch, by a shift's worth.
          p = rise - far(1) + gain + dot_product(far(2:), shift)
          if (p + gain < 0.0_real64) cycle
          if (is_hidden(pairs, set, near, i)) then
            p = far_below
            cycle
          end if
          call find_lowest_place(pairs%list(i)%x, pairs%list(i)%y, pairs%list(i)%radius, set, &
                                 near, far, &
                      0.1_real64 * least, shift, before, above)
          touches(i) = rise - before > least
          settled = state%is_near .or. .not. touches(i)
          p = rise - merge(above, before, settled)
          if (settled) solution%move(:, i) = shift
        end associate
      end do
      !$omp end parallel do
    end associate
  end subroutine look_around

  ! The lowest place of one contact, by Newton's method that only goes down. Long: a place, a field
  ! and a start each are several values.
  pure subroutine find_lowest_place(x, y, radius, set, near, far, accuracy, shift, before, least)
    real(real64), intent(in) :: x, y, radius
    type(circle_set), intent(in) :: set
    integer, intent(in) :: near(:)
    real(real64), intent(in) :: far(3)                ! at the start: field, slopes
    real(real64), intent(in) :: accuracy
    real(real64), intent(inout) :: shift(2)
    real(real64), intent(out) :: before, least        ! height at the start, at the end
    real(real64) :: first(2), s(2), move(2), here(6), there(6)
    integer :: step, cut

    first = shift
    s = first
    here = height_at(s)
    before = here(1)
    do step = 1, most_repeats
      if (.not. radius * dot_product(here(2:3), here(2:3)) > accuracy) exit
      move = lowest_shift(here(4:), 1.0_real64 / radius, here(2:3))
      do cut = 1, most_repeats
        there = height_at(s + move)
        if (there(1) <= here(1) + 1.0e-4_real64 * dot_product(here(2:3), move)) exit
        move = move / 2
      end do
      if (cut > most_repeats) exit
      s = s + move
      here = there
    end do
    shift = s
    least = here(1)

  contains

    ! At a shift: value, slopes, second derivatives xx, xy, yy.
    pure function height_at(s)
      real(real64), intent(in) :: s(2)
      real(real64) :: height_at(6), dx, dy, r, turn, along
      type(mutual_terms) :: terms
      integer :: j, k

      height_at = [far(1) + dot_product(far(2:), s - first) + dot_product(s, s) / (2 * radius), &
                far(2:) + s / radius, [1, 0, 1] / radius]
      do k = 1, size(near)
        j = near(k)
        dx = x + s(1) - (set%x(j) + set%move(1, j))
        dy = y + s(2) - (set%y(j) + set%move(2, j))
        r = hypot(dx, dy)
        call mutual_displacement(r, 0.0_real64, set%circle(j), terms)
        turn = terms%bend
        along = 0.0_real64
        if (r > 0.0_real64) then
          turn = terms%slope / r
          along = (terms%bend - turn) / r**2
        end if
        height_at = height_at + set%load(j) * [terms%on_first, turn * dx, turn * dy, &
                                         turn + along * dx**2, along * dx * dy, &
                                         turn + along * dy**2]
      end do
    end function height_at

  end subroutine find_lowest_place

end module asperity_open_contacts
