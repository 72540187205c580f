!> Open contacts that touch on the surface which the loaded ones leave, and join them.
module asperity_coupled_joining
  use asperity_circle_field, only: circle_set, hertz_spread, many, near_factor
  use asperity_circle_products, only: shift_down
  use asperity_constants, only: pi
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_state, only: answer_at, coupled_solution, far_below, raise, &
                                    resolved_contacts, solve_state
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms
  use asperity_source_tree, only: plant_tree, sum_sources
  implicit none
  private

  public :: look, open_hidden, stand_apart, stand_out

  integer, parameter :: most_looks = 4, most_steps = 40, most_cuts = 40
  ! Of the closing: what sums over many are off by. Who touches by less stays open, as another sum
  ! would open it again.
  real(real64), parameter :: sum_error = 1.0e-7_real64
  ! A cap that stands out of a loaded circle's own surface by no more than this share of the
  ! penetration is a part of that contact: as one of its own it would bear less than its 3/2th power
  ! of the load, nearly all of it taken from the circle.
  real(real64), parameter :: out_of_host = 0.02_real64
  ! It is so, too, where it stands out by less than this share each time that it has joined, twice
  ! the penetration at most: that of an equal cap a third of a radius off. Nearer contacts have
  ! several solutions, and packed ones would join, slide and open without end.
  real(real64), parameter :: out_of_opened = 11.0_real64 / 18.0_real64, most_out = 2.0_real64
  ! Of two that begin together the one that stands out of the other by less than this share waits:
  ! contacts nearer than that have several solutions, and that with the deepest alone in its place
  ! has the least potential. With the share above 10,000 caps of one level take 13 steps, not 11.
  real(real64), parameter :: out_at_start = 0.2_real64
  ! Contacts that stand out of each other by this share have one solution (chosen: above
  ! `out_of_opened`, below which there are several).
  real(real64), parameter :: out_of_each_other = 1.0_real64

contains

  !> Where open contacts stand, and who of them joins.
  !>
  !> Of many, only those are looked at again that a change of the field twice as large as any at the
  !> loaded ones would let touch, unless `all`: outside the loads a field and its changes are
  !> nowhere larger than where loads are.
  subroutine look(pairs, law, accuracy, all, solution, state, resolved, joined)
    type(contact_pairs), intent(in) :: pairs               !! the position
    class(contact_law), intent(in) :: law                  !! of each contact
    real(real64), intent(in) :: accuracy                   !! over the deepest penetration
    logical, intent(in) :: all                             !! are looked at
    type(coupled_solution), intent(inout) :: solution      !! evaluated; gets who joins
    type(solve_state), intent(inout) :: state              !! counts who joins
    type(resolved_contacts), intent(in), optional :: resolved  !! those solved elsewhere
    integer, intent(out) :: joined                         !! how many
    logical, allocatable :: is_open(:), touches(:)
    integer, allocatable :: number(:), order(:)
    type(contact_response) :: answer
    real(real64) :: change, deepest, least, mean
    integer :: i, pass

    joined = 0
    deepest = max(0.0_real64, maxval(solution%penetration(solution%set%number)))
    least = accuracy * deepest
    if (size(solution%set%x) > many) least = max(least, sum_error * solution%closing)
    allocate (is_open(size(state%gap)), source=state%gap < solution%closing)
    is_open(solution%set%number) = .false.
    if (present(resolved)) is_open = is_open .and. .not. resolved%is_one
    if (allocated(state%stood) .and. .not. all .and. size(solution%set%x) > many) then
      associate (number => solution%set%number)
        change = 2 * maxval(abs(solution%penetration(number) - state%stood(number)))
      end associate
      is_open = is_open .and. state%stood > -change
    end if
    allocate (touches(size(is_open)), source=.false.)
    number = pack([(i, i=1, size(is_open))], is_open)
    do pass = 1, most_looks
      if (size(number) == 0) exit
      call look_around(pairs, number, state, least, solution, touches)
      if (allocated(solution%failure)) return
      number = pack(number, solution%penetration(number) > least .and. .not. touches(number))
    end do
    ! Many who would each touch may press each other open, again and again. So who has joined before
    ! joins with ever fewer at a time, the deepest: with half as many as are loaded, a quarter, one.
    number = pack([(i, i=1, size(is_open))], touches)
    if (any(state%joins(number) > 0)) then
      allocate (order(size(number)))
      call sort_keys(-solution%penetration(number), order)
      do i = 2, size(order)
        associate (k => number(order(i)))
          touches(k) = state%joins(k) == 0 .or. &
                       i <= scale(real(size(solution%set%x), real64), -state%joins(k))
        end associate
      end do
    end if
    where (is_open .and. .not. touches) &
      solution%penetration = min(solution%penetration, 0.0_real64)
    ! As deep as each would without the others that join, many would press all open. No deeper than
    ! the loaded ones are on the average, by load.
    mean = huge(mean)
    associate (set => solution%set)
      if (size(set%x) > 0) &
        mean = dot_product(set%load, solution%penetration(set%number)) / sum(set%load)
    end associate
    do i = 1, size(touches)
      if (.not. touches(i)) cycle
      solution%penetration(i) = min(mean, solution%penetration(i))
      answer = answer_at(pairs, law, i, solution%penetration(i))
      if (.not. answer%vertical_load > 0.0_real64) cycle
      state%joins(i) = state%joins(i) + 1
      joined = joined + 1
    end do
    if (joined > 0 .and. state%target > 0.0_real64) &
      call raise(pairs, law, state%target, solution%penetration)
    state%stood = solution%penetration
  end subroutine look

  !> Of those that begin together opens the ones that are as good as hidden in another; the next
  !> look finds where beside it they touch, if they do.
  subroutine open_hidden(pairs, law, target, solution)
    type(contact_pairs), intent(in) :: pairs               !! the position
    class(contact_law), intent(in) :: law                  !! of each contact
    real(real64), intent(in) :: target                     !! load over modulus; below 0: not asked
    type(coupled_solution), intent(inout) :: solution      !! circles are set out; penetrations then
    logical, allocatable :: opens(:)
    real(real64) :: over, under
    integer :: i, j, k

    if (allocated(solution%failure) .or. size(solution%set%x) == 0) return
    associate (set => solution%set)
      allocate (opens(size(set%x)), source=.false.)
      do k = 1, size(set%one)
        i = set%one(k)
        j = set%other(k)
        if (opens(i) .or. opens(j) .or. set%still(i) .or. set%still(j)) cycle
        ! The one that stands out less; of equals the one listed last.
        over = standing_share(pairs, set, i, set%number(j))
        under = standing_share(pairs, set, j, set%number(i))
        opens(j) = over <= out_at_start .and. .not. under < over
        opens(i) = under <= out_at_start .and. .not. opens(j)
      end do
      if (.not. any(opens)) return
      solution%penetration(pack(set%number, opens)) = far_below
    end associate
    if (target > 0.0_real64) call raise(pairs, law, target, solution%penetration)
  end subroutine open_hidden

  !> Whether no contact is hidden in another one, or nearly so: others have several solutions, and
  !> which of them is found depends on the start.
  pure logical function stand_apart(pairs, solution)
    type(contact_pairs), intent(in) :: pairs         !! the position
    type(coupled_solution), intent(in) :: solution   !! solved; below 0 by no number: hidden
    integer :: k

    stand_apart = .not. any(pairs%list%gap < solution%closing .and. &
                            abs(solution%penetration) <= tiny(1.0_real64))
    associate (set => solution%set)
      if (.not. allocated(set%one)) return
      do k = 1, size(set%one)
        stand_apart = stand_apart .and. &
          min(standing_share(pairs, set, set%one(k), set%number(set%other(k))), &
              standing_share(pairs, set, set%other(k), set%number(set%one(k)))) >= out_of_each_other
      end do
    end associate
  end function stand_apart

  !> How far the surface of a pair stands out of a loaded one's, its host, at most, and how far from
  !> the middle of the host's circle. Paraboloids.
  pure subroutine stand_out(pairs, set, host, i, reach, height, off, slope)
    type(contact_pairs), intent(in) :: pairs    !! the position
    type(circle_set), intent(in) :: set         !! places and shifts are set
    integer, intent(in) :: host                 !! circle of the host
    integer, intent(in) :: i                    !! the pair
    real(real64), intent(in) :: reach           !! from the middle of the circle, at most
    real(real64), intent(out) :: height         !! below 0: it stands out nowhere
    real(real64), intent(out) :: off            !! where
    real(real64), intent(out) :: slope          !! how fast it rises in the middle of the circle
    real(real64) :: along(2), sharper

    associate (own => pairs%list(set%number(host)), pair => pairs%list(i), &
               move => set%move(:, host))
      along = move + [own%x - pair%x, own%y - pair%y]
      ! Along its steepest line it stands out by a parabola: as far as its top, or to the end.
      sharper = 1.0_real64 / pair%radius - 1.0_real64 / own%radius
      slope = norm2(along / pair%radius - move / own%radius)
      off = reach
      if (sharper * off > slope) off = slope / sharper
      height = own%gap - pair%gap + off * (slope - 0.5_real64 * sharper * off) + &
               0.5_real64 * (dot_product(move, move) / own%radius - &
                             dot_product(along, along) / pair%radius)
    end associate
  end subroutine stand_out

  ! The same over the host's penetration, within twice its circle: farther off the surfaces part by
  ! more than it can stand out. The most where it is much blunter, or touches first beside it.
  pure real(real64) function standing_share(pairs, set, host, i) result(share)
    type(contact_pairs), intent(in) :: pairs
    type(circle_set), intent(in) :: set
    integer, intent(in) :: host, i
    real(real64) :: off, slope

    share = most_out
    associate (own => pairs%list(set%number(host)), pair => pairs%list(i), a => set%circle(host))
      if (pair%radius < 2 * own%radius .and. norm2(set%move(:, host) + &
          [set%x(host) - pair%x, set%y(host) - pair%y]) < a) then
        call stand_out(pairs, set, host, i, 2 * a, share, off, slope)
        share = share / a**2 * own%radius
      end if
    end associate
  end function standing_share

  ! For each open contact the shift at which it is lowest, s**2/(2 R) + u(x + s), and how far it
  ! penetrates there: near neighbours act exactly, the others by value and slope. The far field
  ! is curved, so its linear extrapolation holds only near the place of its evaluation: a contact
  ! that penetrates at its former shift keeps that shift, and so does one within another circle.
  subroutine look_around(pairs, number, state, least, solution, touches)
    type(contact_pairs), intent(in) :: pairs
    integer, intent(in) :: number(:)               ! places of the open ones in the list
    type(solve_state), intent(inout) :: state      ! gaps, who has joined how often; gets a tree
    real(real64), intent(in) :: least              ! penetration of one that touches
    type(coupled_solution), intent(inout) :: solution
    logical, intent(inout) :: touches(:)           ! of all pairs
    real(real64), allocatable :: field(:, :)
    real(real64) :: above, before, far(3), shift(2)
    integer :: i, k, n
    logical :: settled

    n = size(number)
    allocate (field(6, n))
    associate (set => solution%set, tree => state%open_tree)
      ! Near where they are: far off a tilted surface moves them past many a circle.
      call plant_tree(tree, &
                      [set%x + set%move(1, :), pairs%list(number)%x + solution%move(1, number)], &
                      [set%y + set%move(2, :), pairs%list(number)%y + solution%move(2, number)], &
                      [set%circle, spread(0.0_real64, 1, n)], near_factor, size(set%x))
      if (allocated(tree%failure)) then
        solution%failure = tree%failure
        return
      end if
      call sum_sources(tree, set%load / pi, hertz_spread * set%circle**2, field)
      !$omp parallel do schedule(dynamic, 64) private(i, above, before, far, shift, settled) &
      !$omp   if(n > many)
      do k = 1, n
        i = number(k)
        far = field([1, 3, 4], k)
        shift = solution%move(:, i)
        associate (near => tree%near(tree%first(k):tree%first(k + 1) - 1), &
                   p => solution%penetration(i), rise => solution%closing - state%gap(i), &
                   gain => 0.5_real64 * pairs%list(i)%radius * dot_product(far(2:), far(2:)))
          ! Near circles only push down: without them it would not touch, by a shift's worth.
          p = rise - far(1) + gain + dot_product(far(2:), shift)
          if (p + gain < 0.0_real64) cycle
          if (is_hidden(pairs, set, near, i, &
                        max(out_of_host, min(out_of_opened * state%joins(i), most_out)))) then
            p = far_below
            cycle
          end if
          call settle(pairs%list(i)%x, pairs%list(i)%y, pairs%list(i)%radius, set, near, far, &
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

  ! Whether a pair is a part of one of these loaded contacts.
  pure logical function is_hidden(pairs, set, near, i, out)
    type(contact_pairs), intent(in) :: pairs
    type(circle_set), intent(in) :: set
    integer, intent(in) :: near(:), i
    real(real64), intent(in) :: out
    integer :: k

    is_hidden = .true.
    do k = 1, size(near)
      if (set%still(near(k))) cycle
      if (standing_share(pairs, set, near(k), i) < out) return
    end do
    is_hidden = .false.
  end function is_hidden

  ! The lowest place of one contact, by Newton's method that only goes down.
  pure subroutine settle(x, y, radius, set, near, far, accuracy, shift, before, least)
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
    here = height(s)
    before = here(1)
    do step = 1, most_steps
      if (.not. radius * dot_product(here(2:3), here(2:3)) > accuracy) exit
      move = shift_down(here(4:), 1.0_real64 / radius, here(2:3))
      do cut = 1, most_cuts
        there = height(s + move)
        if (there(1) <= here(1) + 1.0e-4_real64 * dot_product(here(2:3), move)) exit
        move = move / 2
      end do
      if (cut > most_cuts) exit
      s = s + move
      here = there
    end do
    shift = s
    least = here(1)

  contains

    ! At a shift: value, slopes, second derivatives xx, xy, yy.
    pure function height(s)
      real(real64), intent(in) :: s(2)
      real(real64) :: height(6), dx, dy, r, turn, along
      type(mutual_terms) :: terms
      integer :: j, k

      height = [far(1) + dot_product(far(2:), s - first) + dot_product(s, s) / (2 * radius), &
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
        height = height + set%load(j) * [terms%on_first, turn * dx, turn * dy, &
                                         turn + along * dx**2, along * dx * dy, &
                                         turn + along * dy**2]
      end do
    end function height

  end subroutine settle

end module asperity_coupled_joining
