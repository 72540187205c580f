!> Upper estimate of the effect of interaction on load and area, from isolated contacts.
module asperity_interaction_estimate
  use asperity_circle_field, only: find_field, list_near_circles
  use asperity_constants, only: pi
  use asperity_contact_law, only: contact_law
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_state, only: coupled_solution, gather_circles, solve_state
  use asperity_kinds, only: real64
  implicit none
  private

  public :: estimate_of_interaction

contains

  !> Share of the total vertical load, or of the area, by which interaction reduces it at most, 0 to
  !> 1.
  !>
  !> First order: the sum over i and j of k_i M_ij V_j over the sum of V, with the loads V and
  !> stiffnesses k of isolated contacts and the displacements M_ij by unit loads. An area decreases
  !> by 2/3 of the relative decrease of its load and by the faster displacement at its edge. It is
  !> an upper bound: interacting contacts carry smaller loads and displace each other less; a load
  !> that is convex in the penetration decreases by less than its tangent indicates; and shifts of
  !> the contacts on the sloping surface reduce the effect. For laws that are not convex and circles
  !> that overlap deeply the bound is not proved; its order of magnitude holds.
  function estimate_of_interaction(pairs, law, compression) result(share)
    type(contact_pairs), intent(in) :: pairs   !! pairs that may touch, ascending gap
    class(contact_law), intent(in) :: law      !! contact law of each pair
    real(real64), intent(in) :: compression    !! compression from first touch [length]
    real(real64) :: share, span
    type(coupled_solution) :: solution
    type(solve_state) :: state
    logical :: is_same

    share = 0.0_real64
    if (count(pairs%list%gap < compression) < 2) return
    state%gap = pairs%list%gap
    solution%penetration = compression - state%gap
    allocate (solution%shift(2, size(state%gap)), source=0.0_real64)
    call gather_circles(pairs, law, solution, state, is_same=is_same)
    if (size(solution%set%x) == 0) return
    ! The result where there is no memory for the field.
    share = 1.0_real64
    associate (set => solution%set)
      ! It is also 1 if the first-order sum reaches it with all contacts at the largest distance.
      span = hypot(maxval(set%x) - minval(set%x), maxval(set%y) - minval(set%y)) + &
             2 * maxval(set%radius)
      if (sum(set%stiffness) - dot_product(set%stiffness, set%load) / sum(set%load) > pi * span) &
        return
      call list_near_circles(set)
      if (allocated(set%tree%failure)) return
      call find_field(set)
      share = min(1.0_real64, max(dot_product(set%stiffness, set%displacement) / sum(set%load), &
                  sum(set%stiffness / set%load * set%radius**2 * &
                      (set%displacement + set%growth)) / &
                  (1.5_real64 * sum(set%radius**2))))
    end associate
  end function estimate_of_interaction

end module asperity_interaction_estimate
