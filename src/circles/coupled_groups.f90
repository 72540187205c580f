!> The few contacts that hold all others back, group by group, each as a scene of its own.
!>
!> One near pair far from its solution keeps the steps of all contacts short. So the contacts whose
!> equations are off by much more than the mean are solved by themselves, with those close by, under
!> the field that the others have now: its value, slope, bend and what a circle feels more of it as
!> it grows. (Nonlinear elimination: Cai and Li, SIAM J. Sci. Comput. 33, 746, 2011.) A slope t is
!> nothing but another place of first touch, s**2/(2 R) + t s = (s + R t)**2/(2 R) - R t**2/2; what
!> is felt of the square of a radius, nothing but a softer contact.
module asperity_coupled_groups
  use asperity_circle_field, only: are_close, circle_set, close_by, least_share, many
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_coupled_state, only: coupled_solution, evaluate_state, solve_state
  use asperity_index_groups, only: gather_groups
  use asperity_kinds, only: real64
  implicit none
  private

  public :: find_groups, group_law, lift_out, put_back

  !> The law of some contacts of a list by their places among themselves.
  type, extends(contact_law) :: group_law
    class(contact_law), pointer :: whole => null()  !! law of the list
    integer, allocatable :: number(:)               !! places in the list
    !> The field of the others on a circle falls or grows as its square, with its penetration: by
    !> this factor it must go deeper.
    real(real64), allocatable :: deeper(:)
  contains
    procedure :: respond
  end type group_law

  ! Share of the largest error of the equations [1] from which on a contact is eliminated; chosen;
  ! test: coupled_suite.f90.
  real(real64), parameter :: share_off = 0.05_real64
  !> Contacts of a group at most [1]; chosen: larger ones take longer than they save; test:
  !> coupled_suite.f90.
  integer, parameter, public :: most_in_group = 100

contains

  !> The answer of a contact of the group.
  pure subroutine respond(self, pair, number, penetration, response)
    class(group_law), intent(in) :: self             !! law of the group
    type(contact_pair), intent(in) :: pair           !! pair that touches
    integer, intent(in) :: number                    !! place in the group
    real(real64), intent(in) :: penetration          !! vertical, past first touch; less than zc
    type(contact_response), intent(out) :: response  !! load and stiffness

    associate (deeper => self%deeper(number))
      call self%whole%respond(pair, self%number(number), penetration / deeper, response)
      response%stiffness = response%stiffness / deeper
    end associate
  end subroutine respond

  !> Who is off by much, with those close by, as circles in the order of their groups.
  subroutine find_groups(set, miss, member, first)
    type(circle_set), intent(in) :: set             !! its field is known
    real(real64), intent(in) :: miss(:)             !! how far its equations are off, by circle
    integer, allocatable, intent(out) :: member(:)  !! numbers of the circles
    integer, allocatable, intent(out) :: first(:)   !! where a group begins; one more than groups
    logical :: is_off(size(miss)), is_one(size(miss)), joins(size(set%one))
    integer :: k

    is_off = miss > share_off * maxval(miss)
    is_one = is_off
    !$omp parallel do schedule(static) if(size(joins) > many)
    do k = 1, size(joins)
      associate (a => set%one(k), b => set%other(k))
        joins(k) = .not. (set%still(a) .or. set%still(b))
        if (joins(k)) joins(k) = are_close(set, a, b, close_by)
      end associate
    end do
    !$omp end parallel do
    do k = 1, size(joins)
      associate (a => set%one(k), b => set%other(k))
        if (.not. joins(k)) cycle
        if (is_off(a) .or. is_off(b)) is_one([a, b]) = .true.
      end associate
    end do
    joins = joins .and. is_one(set%one) .and. is_one(set%other)
    call gather_groups(set%one, set%other, joins, is_one, most_in_group, member, first)
  end subroutine find_groups

  !> A group as a scene of its own, in the field of all others as it is now.
  subroutine lift_out(pairs, law, solution, state, member, alone, alone_law, part)
    type(contact_pairs), intent(in) :: pairs          !! pairs of the position
    class(contact_law), intent(in), target :: law     !! of each contact
    type(coupled_solution), intent(in) :: solution    !! loads, shifts and field are set
    type(solve_state), intent(in) :: state            !! gaps of all pairs
    integer, intent(in) :: member(:)                  !! circles of the group
    type(contact_pairs), intent(out) :: alone         !! pairs of the group
    type(group_law), intent(out) :: alone_law         !! of its contacts
    type(coupled_solution), intent(out) :: part       !! start of the group
    type(solve_state) :: inside
    real(real64) :: away(2)
    integer :: i

    associate (number => solution%set%number(member), set => solution%set)
      alone%modulus = pairs%modulus
      alone%list = pairs%list(number)
      alone_law%whole => law
      alone_law%number = number
      alone_law%deeper = spread(1.0_real64, 1, size(number))
      part%closing = solution%closing
      part%penetration = solution%penetration(number)
      part%move = solution%move(:, number)
      inside%gap = state%gap(number)
      call evaluate_state(alone, alone_law, part, inside)
      allocate (part%outer(5, size(member)))
      do i = 1, size(member)
        associate (k => member(i), pair => alone%list(i), p => part%penetration(i))
          away = pair%radius * (set%tilt(:, k) - part%set%tilt(:, i))
          pair%x = pair%x - away(1)
          pair%y = pair%y - away(2)
          part%move(:, i) = part%move(:, i) + away
          part%outer(:, i) = [(set%bends(:, k) - part%set%bends(:, i)) / set%load(k), &
                              part%move(:, i)]
          ! d(lift)/d(log of the radius) is twice that by the log of the penetration.
          alone_law%deeper(i) = max(least_share, 1.0_real64 + 0.5_real64 * &
                                    (set%growth(k) - part%set%growth(i)) / p)
          pair%gap = state%gap(number(i)) + set%lift(k) - part%set%lift(i) - 0.5_real64 * &
                     set%curvature(k) * dot_product(away, part%move(:, i) + set%move(:, k)) - &
                     (alone_law%deeper(i) - 1.0_real64) * p
          p = p * alone_law%deeper(i)
        end associate
      end do
    end associate
  end subroutine lift_out

  !> Takes the solution of a group over.
  subroutine put_back(pairs, member, alone, alone_law, part, solution)
    type(contact_pairs), intent(in) :: pairs           !! pairs of the position
    integer, intent(in) :: member(:)                   !! circles of the group
    type(contact_pairs), intent(in) :: alone           !! pairs of the group
    type(group_law), intent(in) :: alone_law           !! of its contacts
    type(coupled_solution), intent(in) :: part         !! solution of the group
    type(coupled_solution), intent(inout) :: solution  !! solution of all, gets it
    integer :: i, k

    do k = 1, size(member)
      i = solution%set%number(member(k))
      solution%penetration(i) = part%penetration(k) / alone_law%deeper(k)
      solution%move(:, i) = part%move(:, k) + [alone%list(k)%x - pairs%list(i)%x, &
                                               alone%list(k)%y - pairs%list(i)%y]
    end do
  end subroutine put_back

end module asperity_coupled_groups
