!> Open contacts that touch on the surface which the loaded ones leave, and join them.
module asperity_coupled_joining
  use asperity_circle_field, only: many
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_open, only: look_around, open_places, stands_out
  use asperity_coupled_state, only: answer_at, coupled_solution, evaluate, raise, &
                                    resolved_contacts, solve_state
  use asperity_kinds, only: real64
  implicit none
  private

  public :: look, open_hidden

  integer, parameter :: most_looks = 4
  ! Of the closing: what sums over many are off by. Who touches by less stays open, as another sum
  ! would open it again.
  real(real64), parameter :: sum_error = 1.0e-7_real64
  ! Of the deepest penetration, how far from touch an open contact is nearly in touch.
  real(real64), parameter :: nearly = 0.25_real64
  ! Where open contacts are one in so many of the loaded, all are looked at.
  integer, parameter :: few_open = 10
  ! A contact that joins once more begins with this share of its penetration.
  real(real64), parameter :: share_of_rejoined = 0.25_real64
  ! Of two that begin together the one that stands out of the other by less than this share of its
  ! penetration waits: contacts nearer than that have several solutions, and that with the deepest
  ! alone in its place has the least potential.
  real(real64), parameter :: out_at_start = 0.2_real64
  ! Deepest penetrations by which what is hidden stays open: no step raises all by so much.
  real(real64), parameter :: out_of_reach = 10.0_real64

contains

  !> Where open contacts stand, and who of them joins.
  subroutine look(pairs, law, accuracy, everywhere, solution, state, resolved, joined)
    type(contact_pairs), intent(in) :: pairs               !! the position
    class(contact_law), intent(in) :: law                  !! of each contact
    real(real64), intent(in) :: accuracy                   !! over the deepest penetration
    logical, intent(in) :: everywhere                      !! else at those nearly in touch before
    type(coupled_solution), intent(inout) :: solution      !! evaluated; gets who joins
    type(solve_state), intent(inout) :: state              !! counts who joins
    type(resolved_contacts), intent(in), optional :: resolved  !! those solved elsewhere
    integer, intent(out) :: joined                         !! how many
    type(open_places) :: places
    logical, allocatable :: is_open(:), touches(:)
    integer, allocatable :: number(:)
    ! Of those looked at: the deepest they were found at, and there.
    real(real64), allocatable :: found(:), x(:), y(:), depth(:)
    integer :: i, k, pass
    real(real64) :: deepest, least, most, load

    joined = 0
    if (size(solution%set%x) == 0) then
      ! A step may have opened all of them: then the one that would bear most begins again.
      i = 0
      most = 0.0_real64
      do k = 1, size(state%gap)
        if (.not. state%gap(k) < solution%closing) cycle
        load = load_at(solution%closing - state%gap(k), k)
        if (.not. load > most) cycle
        most = load
        i = k
      end do
      if (i == 0) return
      solution%penetration(i) = start_of_rejoined(solution%closing - state%gap(i), i)
      solution%move_x(i) = 0.0_real64
      solution%move_y(i) = 0.0_real64
      state%joins(i) = state%joins(i) + 1
      joined = 1
      return
    end if
    deepest = maxval(solution%penetration(solution%set%number))
    least = accuracy * deepest
    if (size(solution%set%x) > many) least = max(least, sum_error * solution%closing)
    allocate (is_open(size(state%gap)), source=state%gap < solution%closing)
    is_open(solution%set%number) = .false.
    if (present(resolved)) is_open = is_open .and. .not. resolved%is_one
    if (.not. everywhere .and. few_open * count(is_open) > size(solution%set%x)) &
      is_open = is_open .and. solution%penetration > -nearly * deepest
    number = pack([(i, i=1, size(is_open))], is_open)
    do i = 1, size(number)
      ! From farther than it can be it starts at home.
      associate (x => solution%move_x(number(i)), y => solution%move_y(number(i)))
        if (x**2 + y**2 < 2 * pairs%list(number(i))%radius * &
            (solution%closing - state%gap(number(i)))) cycle
        x = 0.0_real64
        y = 0.0_real64
      end associate
    end do
    allocate (found(size(number)), x(size(number)), y(size(number)), source=0.0_real64)
    do pass = 1, most_looks
      if (size(number) == 0) exit
      places%x = pairs%list(number)%x
      places%y = pairs%list(number)%y
      places%radius = pairs%list(number)%radius
      places%move_x = solution%move_x(number)
      places%move_y = solution%move_y(number)
      places%gap = state%gap(number)
      places%lift = places%x
      call look_around(solution%set, solution%closing, state%gap(solution%set%number), &
                       places, 0.1_real64 * least, solution%failure)
      if (allocated(solution%failure)) return
      ! The far field bends: what is told of a place from another one is so only near by.
      depth = solution%closing - places%gap - places%start
      x = merge(solution%move_x(number), x, depth > found)
      y = merge(solution%move_y(number), y, depth > found)
      found = max(found, depth)
      depth = solution%closing - places%gap - places%lift
      solution%penetration(number) = max(depth, -out_of_reach * deepest)
      solution%move_x(number) = places%move_x
      solution%move_y(number) = places%move_y
      ! Those that would join are looked at from where they would.
      touches = depth > least
      number = pack(number, touches)
      found = pack(found, touches)
      x = pack(x, touches)
      y = pack(y, touches)
    end do
    touches = found > least
    solution%penetration(number) = found
    solution%move_x(number) = merge(x, solution%move_x(number), touches)
    solution%move_y(number) = merge(y, solution%move_y(number), touches)
    number = pack(number, touches)
    where (is_open .and. .not. solution%penetration > least) &
      solution%penetration = min(solution%penetration, 0.0_real64)
    do k = 1, size(number)
      i = number(k)
      if (.not. load_at(solution%penetration(i), i) > 0.0_real64) cycle
      ! Who has opened again had more than its place can bear.
      solution%penetration(i) = start_of_rejoined(solution%penetration(i), i)
      state%joins(i) = state%joins(i) + 1
      state%is_new(i) = .true.
      joined = joined + 1
    end do
    if (joined > 0 .and. state%target > 0.0_real64) &
      call raise(pairs, law, state%target, solution%penetration)

  contains

    real(real64) function load_at(p, i)
      real(real64), intent(in) :: p
      integer, intent(in) :: i
      type(contact_response) :: answer

      answer = answer_at(pairs, law, i, p)
      load_at = answer%vertical_load
    end function load_at

    ! A share of what lies between the penetration at which a contact begins to carry, which is more
    ! than 0 once it has been flattened, and one at which it carries.
    real(real64) function start_of_rejoined(most, i) result(p)
      real(real64), intent(in) :: most
      integer, intent(in) :: i
      real(real64) :: low, high
      integer :: step

      associate (share => share_of_rejoined**state%joins(i))
        p = share * most
        if (load_at(p, i) > 0.0_real64) return
        low = p
        high = most
        do step = 1, digits(p)
          p = 0.5_real64 * (low + high)
          if (load_at(p, i) > 0.0_real64) then
            high = p
          else
            low = p
          end if
        end do
        p = high + share * (most - high)
      end associate
    end function start_of_rejoined

  end subroutine look

  !> Of those that begin together opens the ones that are as good as hidden in another; the next
  !> look finds where beside it they touch, if they do.
  subroutine open_hidden(pairs, law, solution, state, resolved)
    type(contact_pairs), intent(in) :: pairs               !! the position
    class(contact_law), intent(in) :: law                  !! of each contact
    type(coupled_solution), intent(inout) :: solution      !! evaluated; again at the end
    type(solve_state), intent(inout) :: state              !! knows who is new
    type(resolved_contacts), intent(in), optional :: resolved  !! those solved elsewhere
    logical, allocatable :: opens(:)
    real(real64) :: over, under
    integer :: i, j, k

    if (allocated(solution%failure) .or. .not. any(state%is_new)) return
    if (size(solution%set%x) == 0) return
    associate (set => solution%set, p => solution%penetration)
      allocate (opens(size(set%x)), source=.false.)
      do k = 1, size(set%one)
        i = set%one(k)
        j = set%other(k)
        if (opens(i) .or. opens(j) .or. set%still(i) .or. set%still(j)) cycle
        if (.not. (state%is_new(set%number(i)) .and. state%is_new(set%number(j)))) cycle
        ! The one that stands out less waits; of equals the one listed last.
        over = out_of(host=i, one=j)
        under = out_of(host=j, one=i)
        opens(j) = over <= out_at_start .and. .not. under < over
        opens(i) = under <= out_at_start .and. .not. opens(j)
      end do
      state%is_new = .false.
      if (.not. any(opens)) return
      p(pack(set%number, opens)) = -out_of_reach * maxval(p(set%number))
    end associate
    if (state%target > 0.0_real64) call raise(pairs, law, state%target, solution%penetration)
    call evaluate(pairs, law, solution, state, resolved)

  contains

    real(real64) function out_of(host, one)
      integer, intent(in) :: host, one

      associate (set => solution%set)
        out_of = stands_out(state%gap(set%number(one)), set%x(one), set%y(one), &
                            set%curvature(one), state%gap(set%number(host)), set%x(host), &
                            set%y(host), set%curvature(host), set%circle(host), &
                            set%move_x(host), set%move_y(host))
      end associate
    end function out_of

  end subroutine open_hidden

end module asperity_coupled_joining
