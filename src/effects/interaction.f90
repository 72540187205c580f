!> Interaction of neighbouring contacts, as an effect that a scene names.
!>
!> `coupled`: every contact is lowered by the surface displacement of its neighbours. `boundary`:
!> the pressure on cells of all contacts together. `auto`: coupled where the estimate asks for it;
!> contacts whose circles overlap are then solved on cells, a cluster at a time, as no pairwise
!> displacement is exact there.
module asperity_interaction
  use asperity_boundary_solver, only: boundary_outcome, solve_boundary
  use asperity_constants, only: pi
  use asperity_contact_clusters, only: cluster_of_each
  use asperity_contact_effect, only: contact_effect, effect_outcome, set_columns
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: answer_all, contact_state
  use asperity_coupled_contacts, only: estimate_of_interaction, solve_coupled, solve_coupled_load
  use asperity_decimal, only: decimal_to_real64
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms
  use asperity_scene_values, only: effect_auto, effect_boundary, scene
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: new_interaction

  !> How far `coupled` may be off where contact circles overlap, as a share of the total load: at
  !> most 0.02 at the positions of the thesis, against cells.
  real(real64), parameter :: coupled_error = 0.02_real64

  ! So many contacts can be solved often.
  integer, parameter :: few = 100

  !> Interaction of neighbouring contacts.
  type, extends(contact_effect) :: interaction_effect
    real(real64) :: boundary_tolerance = 0.0_real64  !! what the last halving of cells may change
  contains
    procedure :: estimate
    procedure :: apply
  end type interaction_effect

contains

  !> Interaction as the scene names it.
  subroutine new_interaction(scene_in, effect)
    type(scene), intent(in) :: scene_in                        !! checked values
    class(contact_effect), allocatable, intent(out) :: effect  !! ready to act
    type(interaction_effect) :: new

    new%name = 'interaction'
    new%mode = scene_in%effects%interaction
    new%boundary_tolerance = decimal_to_real64(scene_in%effects%boundary_tolerance)
    ! Cells come and go with the closing, which moves the load a little.
    if (any(new%mode == [effect_auto, effect_boundary])) &
      new%load_tolerance = 0.1_real64 * new%boundary_tolerance
    new%closing_at_load => closing_of_coupled
    call set_columns(new%contact_columns, [character(len=20) :: 'lowered', 'alone_load'], &
                     reshape([0, 1, 1, 2], [2, 2]))
    call set_columns(new%state_columns, &
                     [character(len=20) :: 'alone_load', 'factor', 'cells'], &
                     reshape([1, 2, 0, 0, 0, 0], [2, 3]))
    new%contact_columns(2)%of_load = 1.0_real64
    new%state_columns(1)%of_load = 1.0_real64
    new%state_columns(2)%otherwise = 1.0_real64
    allocate (effect, source=new)
  end subroutine new_interaction

  !> First-order estimate of the share by which neighbours lower the load.
  function estimate(self, pairs, state) result(share)
    class(interaction_effect), intent(in) :: self  !! interaction
    type(contact_pairs), intent(in) :: pairs       !! the position
    type(contact_state), intent(in) :: state       !! contacts that know nothing of each other
    real(real64) :: share

    share = 0.0_real64
    if (self%tolerance < 1.0_real64) &
      share = estimate_of_interaction(pairs, state%law, state%closing)
  end function estimate

  !> Lets the contacts lower each other. Columns: how far each is lowered, its load alone; the sum
  !> of the loads alone, load together over load alone, number of cells.
  subroutine apply(self, pairs, state, outcome)
    class(interaction_effect), intent(in) :: self   !! interaction
    type(contact_pairs), intent(in) :: pairs        !! the position
    type(contact_state), intent(inout) :: state     !! gets the answers of contacts together
    type(effect_outcome), intent(inout) :: outcome  !! what it did
    real(real64) :: together, alone

    allocate (outcome%of_contacts(size(pairs%list), 2), outcome%of_state(3))
    outcome%of_state = 0.0_real64
    outcome%of_contacts(:, 2) = state%answers%vertical_load
    if (self%mode == effect_boundary) then
      call apply_boundary(self, pairs, state, outcome)
    else
      call apply_coupled(pairs, state, outcome)
      if (allocated(outcome%failure)) return
      ! Cells are elastic: contacts of another law stay coupled.
      if (self%mode == effect_auto .and. self%tolerance < coupled_error .and. &
          same_type_as(state%law, hertz_law())) &
        call mend_clusters(self, pairs, state, outcome)
    end if
    if (allocated(outcome%failure)) return
    outcome%of_contacts(:, 1) = max(0.0_real64, &
                                    state%closing - pairs%list%gap - state%penetration)
    alone = sum(outcome%of_contacts(:, 2))
    together = sum(state%answers%vertical_load)
    outcome%of_state(1) = alone
    outcome%of_state(2) = 1.0_real64
    if (alone > 0.0_real64) outcome%of_state(2) = together / alone
    outcome%influence = outcome%of_state(2) - 1.0_real64
    outcome%influence_known = .true.
  end subroutine apply

  ! Every contact lowered by its neighbours.
  subroutine apply_coupled(pairs, state, outcome)
    type(contact_pairs), intent(in) :: pairs
    type(contact_state), intent(inout) :: state
    type(effect_outcome), intent(inout) :: outcome

    outcome%simulated = 'coupled'
    if (allocated(state%found)) then
      call solve_coupled(pairs, state%law, state%closing, state%penetration, outcome%ending, &
                         state%found)
    else
      call solve_coupled(pairs, state%law, state%closing, state%penetration, outcome%ending)
    end if
    if (.not. outcome%ending%converged) then
      outcome%failure = not_converged(outcome%ending)
      return
    end if
    call answer_all(pairs, state)
  end subroutine apply_coupled

  ! All contacts on cells. Cells know vertical gaps only: load and area are those in plan.
  subroutine apply_boundary(self, pairs, state, outcome)
    class(interaction_effect), intent(in) :: self
    type(contact_pairs), intent(in) :: pairs
    type(contact_state), intent(inout) :: state
    type(effect_outcome), intent(inout) :: outcome
    type(boundary_outcome) :: cells
    real(real64) :: share
    integer :: i

    outcome%simulated = 'boundary'
    call solve_boundary(pairs, state%penetration, self%boundary_tolerance, .true., cells)
    outcome%ending = cells%ending
    if (allocated(cells%failure)) then
      outcome%failure = cells%failure
      return
    end if
    do i = 1, size(pairs%list)
      associate (answer => state%answers(i))
        outcome%of_contacts(i, 2) = cells%alone_load(i)
        answer%load = cells%vertical_load(i)
        answer%vertical_load = cells%vertical_load(i)
        answer%cosine = 1.0_real64
        answer%contact_radius = sqrt(cells%area(i) / pi)
        answer%maximum_pressure = cells%maximum_pressure(i)
        if (.not. cells%alone_load(i) > 0.0_real64) cycle
        ! As far as neighbours would have to lower it for this load.
        share = (cells%vertical_load(i) / cells%alone_load(i))**(2.0_real64 / 3.0_real64)
        if (share > 0.0_real64) then
          state%penetration(i) = state%penetration(i) * share
        else
          state%penetration(i) = -tiny(share)
        end if
      end associate
    end do
    outcome%of_state(3) = real(cells%cells, real64)
  end subroutine apply_boundary

  ! Contacts whose circles overlap, a cluster at a time on cells: load together over load alone, at
  ! the penetrations that the contacts outside leave. The load alone is that of the law, so that
  ! the inclination counts as it does elsewhere.
  subroutine mend_clusters(self, pairs, state, outcome)
    class(interaction_effect), intent(in) :: self
    type(contact_pairs), intent(in) :: pairs
    type(contact_state), intent(inout) :: state
    type(effect_outcome), intent(inout) :: outcome
    integer :: cluster(size(pairs%list)), clusters, c
    integer, allocatable :: members(:)

    call cluster_of_each(pairs%list%x, pairs%list%y, state%answers%contact_radius, cluster, &
                         clusters)
    if (clusters == 0) return
    outcome%simulated = 'coupled+boundary'
    outcome%why = 'contact circles overlap'
    do c = 1, clusters
      call find_members(cluster, c, members)
      call mend_one(self, pairs, cluster == c, members, state, outcome)
      if (allocated(outcome%failure)) return
    end do
  end subroutine mend_clusters

  ! The contacts of one cluster.
  pure subroutine find_members(cluster, number, members)
    integer, intent(in) :: cluster(:), number
    integer, allocatable, intent(out) :: members(:)
    integer :: i, used

    allocate (members(count(cluster == number)))
    used = 0
    do i = 1, size(cluster)
      if (cluster(i) /= number) cycle
      used = used + 1
      members(used) = i
    end do
  end subroutine find_members

  ! One cluster on cells.
  subroutine mend_one(self, pairs, is_member, members, state, outcome)
    class(interaction_effect), intent(in) :: self
    type(contact_pairs), intent(in) :: pairs
    logical, intent(in) :: is_member(:)
    integer, intent(in) :: members(:)
    type(contact_state), intent(inout) :: state
    type(effect_outcome), intent(inout) :: outcome
    type(contact_pairs) :: own
    type(boundary_outcome) :: cells
    type(contact_response) :: free
    real(real64) :: penetration(size(members)), share
    integer :: i, k

    own%modulus = pairs%modulus
    own%modulus_power = pairs%modulus_power
    own%length_power = pairs%length_power
    allocate (own%list(size(members)))
    own%list = pairs%list(members)
    do k = 1, size(members)
      penetration(k) = state%closing - pairs%list(members(k))%gap
      do i = 1, size(pairs%list)
        if (.not. is_member(i)) &
          penetration(k) = penetration(k) - displacement(members(k), i)
      end do
    end do
    ! Errors of the cells cancel in the ratio: half the tolerance on the load is ample.
    call solve_boundary(own, penetration, max(self%boundary_tolerance, self%tolerance / 2), &
                        .true., cells)
    outcome%ending%residual = max(outcome%ending%residual, cells%ending%residual)
    outcome%of_state(3) = outcome%of_state(3) + real(cells%cells, real64)
    if (allocated(cells%failure)) then
      outcome%failure = cells%failure
      return
    end if
    do k = 1, size(members)
      i = members(k)
      call state%law%respond(pairs%list(i), i, penetration(k), free)
      share = 0.0_real64
      if (cells%alone_load(k) > 0.0_real64) share = cells%vertical_load(k) / cells%alone_load(k)
      if (share > 0.0_real64) then
        state%penetration(i) = penetration(k) * share**(2.0_real64 / 3.0_real64)
      else
        state%penetration(i) = -tiny(share)
      end if
      call state%law%respond(pairs%list(i), i, state%penetration(i), state%answers(i))
      state%answers(i)%load = free%load * share
      state%answers(i)%vertical_load = free%vertical_load * share
    end do

  contains

    ! Displacement of contact `at` by contact `by`.
    real(real64) function displacement(at, by)
      integer, intent(in) :: at, by
      type(mutual_terms) :: terms

      displacement = 0.0_real64
      if (.not. state%answers(by)%vertical_load > 0.0_real64) return
      call mutual_displacement( &
        hypot(pairs%list(at)%x - pairs%list(by)%x, pairs%list(at)%y - pairs%list(by)%y), &
        state%answers(at)%contact_radius, state%answers(by)%contact_radius, terms)
      displacement = terms%on_first * state%answers(by)%vertical_load / pairs%modulus
    end function displacement

  end subroutine mend_one

  ! Where the coupled contacts carry a load. `auto` that has no call for it leaves the closing.
  subroutine closing_of_coupled(self, pairs, law, target, closing, found, failure)
    class(contact_effect), intent(in) :: self
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    real(real64), intent(in) :: target
    real(real64), intent(inout) :: closing
    real(real64), allocatable, intent(inout) :: found(:, :)
    character(len=:), allocatable, intent(inout) :: failure
    type(solve_ending) :: ending
    real(real64) :: penetration(size(pairs%list)), solution(size(pairs%list), 3), before

    if (self%mode == effect_auto) then
      if (.not. estimate_of_interaction(pairs, law, closing) > self%tolerance) return
    end if
    before = closing
    call solve_coupled_load(pairs, law, target, closing, penetration, ending, solution=solution)
    if (ending%converged) then
      found = solution
      return
    end if
    ! Few contacts: the search by closings alone may still find it, as on steep slopes.
    closing = before
    if (size(pairs%list) > few) failure = 'interaction: ' // not_converged(ending)
  end subroutine closing_of_coupled

  ! Why a solve is not used.
  function not_converged(ending) result(text)
    type(solve_ending), intent(in) :: ending
    character(len=:), allocatable :: text
    character(len=40) :: digits

    write (digits, '(es9.1e3, ", iteration ", i0)') ending%residual, ending%iterations
    text = 'did not converge: residual ' // trim(adjustl(digits))
  end function not_converged

end module asperity_interaction
