!> Groups of contacts with large residuals, each a small problem in the field of all others.
!>
!> One near pair far from its solution shortens the steps of all contacts. Nonlinear elimination
!> (Cai and Li, SIAM J. Sci. Comput. 33 (2011) 746): the contacts with large residuals and those
!> close to them are solved first, in a fixed field of the others: value, slope, second derivatives
!> and growth with the radius. A slope t moves the first touch, s**2/(2 R) + t s = (s + R t)**2/(2
!> R) - R t**2/2. Growth with the square of the radius makes a contact softer. Without groups the
!> scenes of test_found_steps in test/hard/test_everything_solved.py take up to 258 steps, not 28.
module asperity_coupled_groups
  use asperity_circle_field, only: are_close, circle_set, close_distance, large_set, &
                                   least_curvature_share
  use asperity_circle_products, only: lowest_shift
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_coupled_state, only: coupled_solution, evaluate_state, plan_radius, solve_state
  use asperity_index_groups, only: gather_groups
  use asperity_kinds, only: real64
  implicit none
  private

  public :: find_groups, group_law, extract_group, insert_group, solve_single

  !> Contact law of a group, by the indices of its members in the group.
  type, extends(contact_law) :: group_law
    class(contact_law), pointer :: whole => null()  !! law of the list
    integer, allocatable :: contact(:)              !! index of each member in the list
    !> penetration over that without growth of the field with the radius
    real(real64), allocatable :: softening(:)
  contains
    procedure :: respond
  end type group_law

contains

  !> Response of a contact of the group.
  pure subroutine respond(self, pair, number, penetration, response)
    class(group_law), intent(in) :: self             !! law of the group
    type(contact_pair), intent(in) :: pair           !! pair that touches
    integer, intent(in) :: number                    !! index in the group
    real(real64), intent(in) :: penetration          !! vertical, past first touch; less than zc
    type(contact_response), intent(out) :: response  !! load and stiffness

    associate (softening => self%softening(number))
      call self%whole%respond(pair, self%contact(number), penetration / softening, response)
      response%stiffness = response%stiffness / softening
    end associate
  end subroutine respond

  !> Finds contacts with large residuals, with those close to them, in groups.
  subroutine find_groups(set, contact_residual, share, member, first)
    type(circle_set), intent(in) :: set              !! circles with their near pairs
    real(real64), intent(in) :: contact_residual(:)  !! error of the equations, by circle [length]
    real(real64), intent(in) :: share                !! of the largest error that is left
    integer, allocatable, intent(out) :: member(:)   !! indices of circles, group by group
    integer, allocatable, intent(out) :: first(:)    !! first member of each group, and one more
    logical, dimension(size(contact_residual)) :: has_large_residual, is_member
    logical :: is_linked(size(set%one))
    integer :: k

    has_large_residual = contact_residual > share * maxval(contact_residual)
    is_member = has_large_residual
    !$omp parallel do schedule(static) if(size(is_linked) > large_set)
    do k = 1, size(is_linked)
      associate (a => set%one(k), b => set%other(k))
        is_linked(k) = .not. (set%shift_fixed(a) .or. set%shift_fixed(b))
        if (is_linked(k)) is_linked(k) = are_close(set, a, b, close_distance)
      end associate
    end do
    !$omp end parallel do
    do k = 1, size(is_linked)
      associate (a => set%one(k), b => set%other(k))
        if (.not. is_linked(k)) cycle
        if (has_large_residual(a) .or. has_large_residual(b)) is_member([a, b]) = .true.
      end associate
    end do
    is_linked = is_linked .and. is_member(set%one) .and. is_member(set%other)
    call gather_groups(set%one, set%other, is_linked, is_member, large_set, member, first)
  end subroutine find_groups

  !> Solves one contact in the field of all others, with a shift by Newton's step, which is exact
  !> where the field bends the right way.
  subroutine solve_single(state, k, solution)
    type(solve_state), intent(in) :: state             !! gradient of all contacts
    integer, intent(in) :: k                           !! circle of the contact
    type(coupled_solution), intent(inout) :: solution  !! of all; gets its penetration and shift
    real(real64) :: bend(2), step(2)

    step = 0.0_real64
    associate (set => solution%set, i => solution%set%contact(k), slope => &
               state%shift_gradient(:, k), hessian => solution%set%hessian(:, k) / &
               solution%set%load(k), p => solution%penetration(solution%set%contact(k)))
      if (.not. set%shift_fixed(k)) step = lowest_shift(hessian, set%curvature(k), slope)
      bend = [dot_product(hessian(1:2), step), dot_product(hessian(2:3), step)]
      ! du/d(log a) is twice du/d(log p).
      p = p - (state%load_gradient(k) + dot_product(slope + 0.5_real64 * bend, step)) / &
          max(least_curvature_share, 1.0_real64 + 0.5_real64 * set%growth(k) / p)
      solution%shift(:, i) = solution%shift(:, i) + step
    end associate
  end subroutine solve_single

  !> Sets up a group as contacts of its own, in the field of all others.
  subroutine extract_group(pairs, law, solution, state, member, group_pairs, law_of_group, group)
    type(contact_pairs), intent(in) :: pairs          !! pairs of the position
    class(contact_law), intent(in), target :: law     !! of each contact
    type(coupled_solution), intent(in) :: solution    !! loads, shifts and field of all contacts
    type(solve_state), intent(in) :: state            !! gaps of all pairs
    integer, intent(in) :: member(:)                  !! circles of the group
    type(contact_pairs), intent(out) :: group_pairs   !! pairs of the group
    type(group_law), intent(out) :: law_of_group      !! of its contacts
    type(coupled_solution), intent(out) :: group      !! start of the group
    type(solve_state) :: group_state
    real(real64) :: offset(2)
    integer :: i

    associate (contact => solution%set%contact(member), set => solution%set)
      group_pairs%modulus = pairs%modulus
      group_pairs%list = pairs%list(contact)
      law_of_group%whole => law
      law_of_group%contact = contact
      law_of_group%softening = spread(1.0_real64, 1, size(contact))
      group%compression = solution%compression
      group%penetration = solution%penetration(contact)
      group%shift = solution%shift(:, contact)
      group_state%gap = state%gap(contact)
      call evaluate_state(group_pairs, law_of_group, group, group_state)
      allocate (group%outer_field(5, size(member)))
      do i = 1, size(member)
        associate (k => member(i), pair => group_pairs%list(i), p => group%penetration(i))
          offset = plan_radius(pair) * (set%slope(:, k) - group%set%slope(:, i))
          pair%x = pair%x - offset(1)
          pair%y = pair%y - offset(2)
          group%shift(:, i) = group%shift(:, i) + offset
          group%outer_field(:, i) = [(set%hessian(:, k) - group%set%hessian(:, i)) / set%load(k), &
                                     group%shift(:, i)]
          ! du/d(log a) is twice du/d(log p).
          law_of_group%softening(i) = max(least_curvature_share, 1.0_real64 + 0.5_real64 * &
                                          (set%growth(k) - group%set%growth(i)) / p)
          pair%gap = state%gap(contact(i)) + set%displacement(k) - group%set%displacement(i) - &
                     0.5_real64 * set%curvature(k) * &
                     dot_product(offset, group%shift(:, i) + set%shift(:, k)) - &
                     (law_of_group%softening(i) - 1.0_real64) * p
          p = p * law_of_group%softening(i)
        end associate
      end do
    end associate
  end subroutine extract_group

  !> Copies the solution of a group into that of all contacts.
  subroutine insert_group(pairs, member, group_pairs, law_of_group, group, solution)
    type(contact_pairs), intent(in) :: pairs           !! pairs of the position
    integer, intent(in) :: member(:)                   !! circles of the group
    type(contact_pairs), intent(in) :: group_pairs     !! pairs of the group
    type(group_law), intent(in) :: law_of_group        !! of its contacts
    type(coupled_solution), intent(in) :: group        !! solution of the group
    type(coupled_solution), intent(inout) :: solution  !! of all; gets penetrations and shifts
    integer :: i, k

    do k = 1, size(member)
      i = solution%set%contact(member(k))
      solution%penetration(i) = group%penetration(k) / law_of_group%softening(k)
      solution%stays_open(i) = group%stays_open(k)
      solution%shift(:, i) = group%shift(:, k) + [group_pairs%list(k)%x - pairs%list(i)%x, &
                                                  group_pairs%list(k)%y - pairs%list(i)%y]
    end do
  end subroutine insert_group

end module asperity_coupled_groups
