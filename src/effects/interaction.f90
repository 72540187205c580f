!> Interaction of neighbouring contacts, as an effect that a scene names.
!>
!> `coupled`: every contact is lowered by the surface displacement of its neighbours. `boundary`:
!> the pressure on cells of all contacts together. `auto`: coupled where the estimate asks for it;
!> contacts whose circles overlap are then solved on cells, a cluster at a time, as no pairwise
!> displacement is exact there.
module asperity_interaction
  use asperity_boundary_solver, only: boundary_outcome, solve_boundary
  use asperity_constants, only: pi
  use asperity_cluster_cells, only: lowered_for, solve_clusters
  use asperity_contact_effect, only: column, contact_effect, effect_outcome, force, length, plain
  use asperity_contact_law, only: contact_law
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: answer_all, contact_state
  use asperity_coupled_contacts, only: estimate_of_interaction, solve_coupled, solve_coupled_load
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
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
    procedure :: closing_at_load
  end type interaction_effect

contains

  !> Interaction as the scene names it.
  subroutine new_interaction(scene_in, effect)
    type(scene), intent(in) :: scene_in                        !! checked values
    class(contact_effect), allocatable, intent(out) :: effect  !! ready to act
    type(interaction_effect) :: new

    call new%call_as('interaction', scene_in%effects)
    new%boundary_tolerance = scene_in%effects%number('boundary_tolerance')
    ! Cells come and go with the closing, which moves the load a little.
    if (any(new%mode == [effect_auto, effect_boundary])) &
      new%load_tolerance = 0.1_real64 * new%boundary_tolerance
    new%contact_columns = [ &
      column('lowered', length), &                       ! how far by its neighbours
      column('alone_load', force, of_load=1.0_real64)]   ! vertical, without them
    new%state_columns = [ &
      column('alone_load', force, of_load=1.0_real64), & ! sum of those of the contacts
      column('factor', plain, otherwise=1.0_real64), &   ! load together over load alone
      column('cells', plain)]                            ! how many
    allocate (effect, source=new)
  end subroutine new_interaction

  !> First-order estimate of the share by which neighbours lower the load.
  function estimate(self, pairs, state) result(share)
    class(interaction_effect), intent(in) :: self  !! interaction
    type(contact_pairs), intent(in) :: pairs       !! the position
    type(contact_state), intent(in) :: state       !! contacts that know nothing of each other
    real(real64) :: share

    associate (unused => self)
    end associate
    share = estimate_of_interaction(pairs, state%law, state%closing)
  end function estimate

  !> Lets the contacts lower each other.
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
        call apply_to_clusters(self, pairs, state, outcome)
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
    ! What was not found is not there: an unallocated argument counts as absent.
    call solve_coupled(pairs, state%law, state%closing, state%penetration, outcome%ending, &
                       state%found)
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
        state%penetration(i) = lowered_for(cells%vertical_load(i) / cells%alone_load(i), &
                                           state%penetration(i))
      end associate
    end do
    outcome%of_state(3) = real(cells%cells, real64)
  end subroutine apply_boundary

  ! Contacts whose circles overlap, a cluster at a time on cells.
  subroutine apply_to_clusters(self, pairs, state, outcome)
    class(interaction_effect), intent(in) :: self
    type(contact_pairs), intent(in) :: pairs
    type(contact_state), intent(inout) :: state
    type(effect_outcome), intent(inout) :: outcome
    integer :: clusters, cells
    real(real64) :: residual

    ! Errors of the cells cancel in the ratio: half the tolerance on the load is ample.
    call solve_clusters(pairs, max(self%boundary_tolerance, self%tolerance / 2), state, clusters, &
                        cells, residual, outcome%failure)
    if (clusters == 0) return
    outcome%simulated = 'coupled+boundary'
    outcome%why = 'contact circles overlap'
    outcome%ending%residual = max(outcome%ending%residual, residual)
    outcome%of_state(3) = real(cells, real64)
  end subroutine apply_to_clusters

  !> Where the coupled contacts carry a load. `auto` that has no call for it leaves the closing.
  subroutine closing_at_load(self, pairs, law, target, closing, found, failure)
    class(interaction_effect), intent(in) :: self              !! interaction
    type(contact_pairs), intent(in) :: pairs                   !! the position
    class(contact_law), intent(in) :: law                      !! of every contact
    real(real64), intent(in) :: target                         !! sum of the normal forces
    real(real64), intent(inout) :: closing                     !! past first touch
    !> penetration and shift along x and y of every pair there; as it was where the search fails
    real(real64), allocatable, intent(inout) :: found(:, :)
    character(len=:), allocatable, intent(inout) :: failure    !! the search does not converge
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
  end subroutine closing_at_load

  ! Why a solve is not used.
  function not_converged(ending) result(text)
    type(solve_ending), intent(in) :: ending
    character(len=:), allocatable :: text
    character(len=40) :: digits

    write (digits, '(es9.1e3, ", iteration ", i0)') ending%residual, ending%iterations
    text = 'did not converge: residual ' // trim(adjustl(digits))
  end function not_converged

end module asperity_interaction
