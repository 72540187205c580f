!> Contacts that share a half-space, coupled: loads and shifts that make one potential stationary.
!>
!> For contact i: p_i = closing - gap_i - h_i - u_i, with u_i the displacement by its neighbours as
!> i feels it and h_i = s_i**2/(2 R_i) for its shift s_i = -R_i times their slope (see
!> circle_field). Newton's method on the contacts that carry load; between its steps contacts open
!> and others join. Where a load is asked for, every state on the way carries it: all penetrations
!> are raised alike until it does, and the closing follows.
!>
!> A step is cut until the slope of the potential along it has fallen, in size, to a share of what
!> it was at the start.
module asperity_coupled_contacts
  use asperity_circle_field, only: circle_set, many
  use asperity_contact_law, only: contact_law
  use asperity_contact_pairs, only: contact_pairs, in_scene_units
  use asperity_coupled_groups, only: find_groups, group_law, lift_out, put_back, share_off
  use asperity_coupled_joining, only: look, open_hidden
  use asperity_coupled_start, only: prepare
  use asperity_coupled_state, only: bear, coupled_solution, evaluate, raise, resolved_contacts, &
                                    set_out, solve_state
  use asperity_coupled_step, only: newton_step
  use asperity_coupled_turns, only: find_large, length_of, turn_shift
  use asperity_kinds, only: real64
  use asperity_problems, only: real_text
  implicit none
  private

  public :: adopt, coupled_solution, resolved_contacts, solve_coupled

  ! Residuals: asked for; accepted where rounding allows no less, and of many, sums over whom are
  ! good to 1e-8 only. From a start nearby the last step is not worth its cost (measured).
  real(real64), parameter :: asked = 1.0e-11_real64, accepted = 1.0e-9_real64
  ! Of a group what all are off by, and steps: one that takes more is left to the others.
  real(real64), parameter :: group_left = 0.01_real64
  integer, parameter :: most_of_group = 40, most_iterations = 400, most_trials = 12
  ! A step is taken when the slope of the potential has fallen to this share in size. Of many it
  ! may grow: what made it grow is solved by itself. So may what that leaves of their residual: the
  ! next step makes up for it, and to go back costs half a step. 2, 4 and 8 do alike (measured).
  real(real64), parameter :: slope_left = 0.8_real64, growth_of_many = 4.0_real64
  ! So long as they have come nearer than ever before in so many steps. After more a step may not
  ! go far past the least: one scene of 4,000 went to and fro between two places of one circle.
  integer, parameter :: patience = 3, stuck = 10
  real(real64), parameter :: slope_of_stuck = 0.1_real64
  real(real64), parameter :: share_cut = 0.1_real64
  ! Shares of the gradient that a step may leave: at most; at least, of few and of many contacts.
  ! Products are rough and leave out derivatives by shifts of far circles, so that of many a step
  ! leaves .05 in any case (measured).
  real(real64), parameter :: most_left = 0.1_real64, least_left(2) = [0.01_real64, 0.05_real64]
  ! From a start nearby: share of the residual that will do that the last step aims at (chosen).
  real(real64), parameter :: left_at_end = 0.1_real64
  ! Open contacts are looked at when the residual has fallen to this share, as long as any joins;
  ! groups are solved again as long as that brings it there.
  real(real64), parameter :: look_again = 0.5_real64
  ! A residual that has come down well: to this share.
  real(real64), parameter :: much_less = 0.1_real64

contains

  !> Solves at a given closing, or, where `target` is present, at a sum of the normal loads, or of
  !> the vertical ones, as the pairs have it.
  recursive subroutine solve_coupled(pairs, law, solution, target, resolved, share)
    type(contact_pairs), intent(in) :: pairs           !! those that may touch, ascending gap
    class(contact_law), intent(in), target :: law      !! of each contact
    !> closing: given, or found where there is a target; penetrations and shifts: a start when
    !> allocated
    type(coupled_solution), intent(inout) :: solution
    real(real64), intent(in), optional :: target       !! more than 0
    type(resolved_contacts), intent(in), optional :: resolved
    real(real64), intent(in), optional :: share        !! of a group: residual that will do
    type(solve_state) :: state
    real(real64) :: looked, before, enough, borne, slope
    integer :: iteration, joined
    logical :: done, far

    call prepare(pairs, law, solution, state, target, resolved)
    if (pairs%interrupt%is_asked()) solution%failure = 'interrupted'
    if (allocated(solution%failure)) return
    call set_out(pairs, law, solution, state, resolved)
    ! None has been looked at yet.
    joined = -1
    state%is_near = solution%is_near
    solution%is_near = .false.
    if (state%is_near) then
      ! Its closing is near, too: contacts that are new join before the first step.
      call look(pairs, law, asked, .true., solution, state, resolved, joined)
      joined = 0
    else if (.not. (present(share) .or. present(resolved))) then
      ! Circles with cells begin with what they were.
      call open_hidden(pairs, law, state%target, solution)
    end if
    call evaluate(pairs, law, solution, state, resolved)
    looked = 1.0_real64
    before = huge(before)
    do iteration = 0, merge(most_of_group, most_iterations, present(share))
      if (pairs%interrupt%is_asked()) solution%failure = 'interrupted'
      if (allocated(solution%failure)) return
      ! Or as small as rounding lets it be: it falls no more.
      enough = merge(accepted, asked, state%is_near .or. size(solution%set%x) > many)
      if (present(share)) enough = max(enough, share)
      done = state%residual <= enough .or. &
             (state%residual <= accepted .and. .not. state%residual < before)
      ! The pair list is complete only up to this compression. Beyond it the solution is invalid;
      ! the caller repeats the solve with all pairs.
      if (solution%closing > pairs%complete_to .and. state%residual < much_less) exit
      if (done .or. (joined /= 0 .and. state%residual <= look_again * looked)) then
        call look(pairs, law, asked, done, solution, state, resolved, joined)
        looked = state%residual
        if (allocated(solution%failure)) return
        if (done .and. joined == 0) exit
        if (joined > 0) call evaluate(pairs, law, solution, state, resolved)
      end if
      if (state%residual > look_again * before) then
        ! As long as that halves what is left: a step of all costs more. Once more where it leaves
        ! much more and goes down all the same, for those around the few that went far.
        far = .false.
        do
          before = state%residual
          call relax(pairs, law, solution, state, resolved)
          if (state%residual < look_again * before) cycle
          if (far .or. state%residual <= growth_of_many * before) exit
          far = .true.
        end do
      end if
      before = state%residual
      state%since = state%since + 1
      if (before < state%least) state%since = 0
      state%least = min(before, state%least)
      call take_step(pairs, law, solution, state, resolved)
      solution%ending%iterations = iteration + 1
    end do
    solution%ending%residual = state%residual
    solution%ending%converged = state%residual <= max(accepted, enough) .and. joined == 0
    if (solution%closing > pairs%complete_to) solution%ending%converged = .true.
    if (.not. present(target)) return
    call bear(pairs, law, solution%penetration, 0.0_real64, borne, slope)
    if (.not. borne >= (1.0_real64 - accepted) * state%target) solution%failure = &
      'the load is larger than the surfaces carry before the centres of two asperities are ' // &
      'level: ' // real_text(in_scene_units(pairs, borne * pairs%modulus, 1, 2)) // ' at most'
  end subroutine solve_coupled

  !> Takes the penetrations as they are: finds their circles and field, and the gaps of resolved
  !> contacts with which the equations hold for them.
  subroutine adopt(pairs, law, solution, resolved)
    type(contact_pairs), intent(in) :: pairs               !! the position
    class(contact_law), intent(in) :: law                  !! of each contact
    type(coupled_solution), intent(inout) :: solution      !! all but its circles is set
    type(resolved_contacts), intent(inout) :: resolved     !! gets its gaps
    type(solve_state) :: state
    integer :: i, k

    allocate (state%joins(0))
    state%gap = pairs%list%gap
    call evaluate(pairs, law, solution, state, resolved)
    where (resolved%is_one) resolved%gap = huge(1.0_real64)
    do k = 1, size(solution%set%number)
      i = solution%set%number(k)
      if (resolved%is_one(i)) resolved%gap(i) = solution%closing - solution%set%lift(k) - &
                                                solution%penetration(i)
    end do
  end subroutine adopt

  ! Solves the few contacts that hold all others back by themselves, if that brings all nearer.
  recursive subroutine relax(pairs, law, solution, state, resolved)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in), target :: law
    type(coupled_solution), intent(inout) :: solution
    type(solve_state), intent(inout) :: state
    type(resolved_contacts), intent(in), optional :: resolved
    real(real64), allocatable :: p(:), move(:, :), gradient(:, :), load(:)
    integer, allocatable :: member(:), first(:), number(:)
    real(real64) :: before, way
    integer :: k

    if (allocated(solution%failure)) return
    call find_groups(solution%set, state%miss, member, first)
    ! Many are no few; and where all of many are off, no few hold them back.
    if (size(member) == 0 .or. 4 * size(member) > size(state%miss)) return
    if (size(state%miss) > many .and. &
        sum(state%miss) > share_off * size(state%miss) * maxval(state%miss)) return
    before = state%residual
    allocate (p, source=solution%penetration)
    allocate (move, source=solution%move)
    allocate (number, source=solution%set%number)
    allocate (load(size(p)), source=0.0_real64)
    load(number) = solution%set%load
    gradient = gradient_of(solution%set, state)
    !$omp parallel do schedule(dynamic)
    do k = 1, size(first) - 1
      call solve_group(pairs, law, state, member(first(k):first(k + 1) - 1), solution)
    end do
    !$omp end parallel do
    if (state%target > 0.0_real64) call raise(pairs, law, state%target, solution%penetration)
    call evaluate(pairs, law, solution, state, resolved)
    if (state%since < patience .and. size(state%miss) > many) before = growth_of_many * before
    if (allocated(solution%failure) .or. state%residual < before) return
    ! Otherwise the step is accepted when the potential decreases, by its slopes at both ends of the
    ! step: a contact whose centre moves far raises the residual of its neighbours.
    load = -load
    load(solution%set%number) = load(solution%set%number) + solution%set%load
    way = slope_along(number, gradient, load, solution%move - move)
    if (way + slope_along(solution%set%number, gradient_of(solution%set, state), load, &
                          solution%move - move) < 0.0_real64) return
    solution%penetration = p
    solution%move = move
    call evaluate(pairs, law, solution, state, resolved)
  end subroutine relax

  ! Gradient of the potential: by load, by shift.
  function gradient_of(set, state) result(gradient)
    type(circle_set), intent(in) :: set
    type(solve_state), intent(in) :: state
    real(real64) :: gradient(3, size(set%x))

    gradient(1, :) = state%off
    gradient(2:, :) = spread(set%load, 1, 2) * state%aside
  end function gradient_of

  ! Change of the potential along changes of loads and shifts, by pair.
  pure real(real64) function slope_along(number, gradient, load, move) result(slope)
    integer, intent(in) :: number(:)             ! pairs of circles
    real(real64), intent(in) :: gradient(:, :)   ! of the circles
    real(real64), intent(in) :: load(:), move(:, :)

    slope = sum(gradient(1, :) * load(number)) + sum(gradient(2:, :) * move(:, number))
  end function slope_along

  ! Solves some contacts under the field of all others; those of other groups stay as they are.
  recursive subroutine solve_group(pairs, law, state, member, solution)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in), target :: law
    type(solve_state), intent(in) :: state
    integer, intent(in) :: member(:)
    type(coupled_solution), intent(inout) :: solution
    type(contact_pairs) :: alone
    type(group_law) :: alone_law
    type(coupled_solution) :: part

    call lift_out(pairs, law, solution, state, member, alone, alone_law, part)
    call solve_coupled(alone, alone_law, part, share=group_left * state%residual)
    if (part%ending%converged .and. .not. allocated(part%failure)) &
      call put_back(pairs, member, alone, alone_law, part, solution)
  end subroutine solve_group

  ! One step of Newton's method, cut where it goes too far.
  subroutine take_step(pairs, law, solution, state, resolved)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    type(coupled_solution), intent(inout) :: solution
    type(solve_state), intent(inout) :: state
    type(resolved_contacts), intent(in), optional :: resolved
    real(real64), allocatable :: step(:, :), dp(:), p(:), move(:, :)
    real(real64), allocatable :: first(:), now(:), part(:), reach(:)
    complex(real64), allocatable :: shift(:), to(:), way(:), from(:)
    integer, allocatable :: number(:), place(:)   ! pairs of circles; circles of pairs, or n + 1
    real(real64) :: left, deepest, allowed
    integer :: k, n, trial

    n = size(solution%set%x)
    if (n == 0) return
    left = least_left(merge(2, 1, n > many))
    allocate (step(3, n))
    ! No more than the end takes.
    if (state%is_near) left = max(left, left_at_end * accepted / state%residual)
    call newton_step(solution%set, gradient_of(solution%set, state), state%target > 0.0_real64, &
                     min(most_left, max(left, state%residual)), &
                     min(most_left, state%residual), step, solution%products, pairs%interrupt)
    if (pairs%interrupt%is_asked()) return
    allocate (number, source=solution%set%number)
    allocate (p, source=solution%penetration)
    allocate (move(2, n), to(n), way(n + 1), from(n))
    move = solution%move(:, number)
    allocate (place(size(p)), source=n + 1)
    place(number) = [(k, k=1, n)]
    allocate (part(n), source=1.0_real64)
    from = find_large(solution%set)
    deepest = maxval(p(number))
    ! No farther than the field is known: the deepest penetration, and the own circle. Cut each for
    ! itself a step need not go down, as where two slide together; the whole one does.
    reach = 1.0_real64 / max(1.0_real64, abs(step(1, :)) / (deepest * solution%set%stiffness), &
                             length_of(cmplx(step(2, :), step(3, :), real64), from, &
                                       solution%set%circle))
    call aim()
    if (sum(first) >= 0.0_real64) then
      reach = minval(reach)
      call aim()
    end if
    allowed = slope_left
    if (n > many .and. state%since < patience) allowed = growth_of_many
    if (state%since >= stuck) allowed = slope_of_stuck
    do trial = 1, most_trials
      solution%penetration = p
      solution%penetration(number) = p(number) + part * dp(:n)
      call turn_shift(part, shift, from, to, way(:n))
      solution%move(1, number) = move(1, :) + real(to, real64)
      solution%move(2, number) = move(2, :) + aimag(to)
      ! Nor does anything penetrate by more than alone; a law with a kink sends steps far off.
      if (state%target > 0.0_real64) then
        call raise(pairs, law, state%target, solution%penetration)
      else
        where (state%gap < solution%closing) solution%penetration = &
          min(solution%penetration, 2 * (solution%closing - state%gap))
      end if
      call evaluate(pairs, law, solution, state, resolved)
      if (allocated(solution%failure)) return
      now = slopes()
      if (sum(now) <= allowed * abs(sum(first)) .or. pairs%interrupt%is_asked()) exit
      now = now(:n)
      where (now > share_cut * maxval(now)) &
        part = part * max(0.1_real64, min(abs(first(:n)) / (abs(first(:n)) + now), 0.5_real64))
    end do

  contains

    ! The step, each contact as far as it may go.
    subroutine aim()
      dp = [reach * step(1, :) / solution%set%stiffness, 0.0_real64]
      shift = reach * cmplx(step(2, :), step(3, :), real64)
      way = [shift, (0.0_real64, 0.0_real64)]
      first = slopes()
    end subroutine aim

    ! Change of the potential by going on, by circle at the start; by others in n + 1.
    function slopes()
      real(real64) :: slopes(n + 1)
      real(real64) :: raised
      integer :: j

      slopes = 0.0_real64
      associate (set => solution%set)
        raised = 0.0_real64
        if (state%target > 0.0_real64) &
          raised = -sum(set%stiffness * dp(place(set%number))) / sum(set%stiffness)
        do j = 1, size(set%x)
          associate (i => place(set%number(j)))
            slopes(i) = slopes(i) + state%off(j) * set%stiffness(j) * (dp(i) + raised) + &
                        set%load(j) * (state%aside(1, j) * real(way(i), real64) + &
                                       state%aside(2, j) * aimag(way(i)))
          end associate
        end do
      end associate
    end function slopes

  end subroutine take_step

end module asperity_coupled_contacts
