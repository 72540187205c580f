!> How much interaction may lower the load, from contacts each solved alone.
module asperity_interaction_estimate
  use asperity_circle_field, only: circle_set, find_field, inclination_factor, list_near_circles
  use asperity_constants, only: pi
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_kinds, only: real64
  implicit none
  private

  public :: estimate_of_interaction

  ! Largest penetration over the height at which the centres are level, where laws end (chosen).
  real(real64), parameter :: deepest = 0.999999_real64

contains

  !> Share of the total vertical load, or of the area, that interaction takes away at most, 0 to 1.
  !>
  !> First order: sum over i and j of k_i M_ij V_j over the sum of V, all of contacts alone; an area
  !> falls by 2/3 of what its load does, and by how much faster neighbours press its edge. It is
  !> above the truth: together the contacts carry less than alone, so they displace each other
  !> less; a load that is convex in the penetration falls by less than its slope at the start
  !> says; and contacts that find their place aside on the tilted surface keep more still. A law
  !> that is not convex, or circles deep in each other, may leave the proof but not the size of the
  !> answer.
  function estimate_of_interaction(pairs, law, closing) result(share)
    type(contact_pairs), intent(in) :: pairs   !! those that may touch, ascending gap
    class(contact_law), intent(in) :: law      !! of each contact
    real(real64), intent(in) :: closing        !! past first touch of all
    real(real64) :: share, span
    type(circle_set) :: set
    type(contact_response) :: response
    integer :: i, n

    share = 0.0_real64
    n = count(pairs%list%gap < closing)
    if (n < 2) return
    call set%allocate_arrays(n)
    set%x = pairs%list(:n)%x
    set%y = pairs%list(:n)%y
    do i = 1, n
      call law%respond(pairs%list(i), i, min(closing - pairs%list(i)%gap, &
                       deepest * pairs%list(i)%zc), response)
      set%radius(i) = response%contact_radius
      set%load(i) = response%vertical_load * inclination_factor(response%cosine) / pairs%modulus
      set%stiffness(i) = response%stiffness * inclination_factor(response%cosine) / pairs%modulus
    end do
    if (.not. sum(set%load) > 0.0_real64) return
    ! Without the memory to ask, the answer is that it may be all.
    share = 1.0_real64
    ! It is if even the farthest were enough for that.
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
  end function estimate_of_interaction

end module asperity_interaction_estimate
