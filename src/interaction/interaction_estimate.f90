!> How much interaction may lower the load: a bound from contacts each solved alone.
module asperity_interaction_estimate
  use asperity_constants, only: pi
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_kinds, only: real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms
  implicit none
  private

  public :: estimate_of_interaction

  ! Sums of radii from which on the bound of the field serves in place of the field: 2 % above it.
  real(real64), parameter :: bound_from = 5.0_real64

contains

  !> Share of the total vertical load that interaction takes away at most, 0 to 1.
  !>
  !> First order: sum over i and j of k_i M_ij V_j over the sum of V, all of contacts alone. It is
  !> above the truth: together the contacts carry less than alone, so they displace each other
  !> less; a load that is convex in the penetration falls by less than its slope at the start
  !> says; and contacts that find their place aside on the tilted surface keep more still. Far
  !> apart 1/(pi E sqrt(r**2 - (a + b)**2)) stands for M, its largest value. A law that is not
  !> convex, or circles deep in each other, may leave the proof but not the size of the answer.
  !> Once the sum is past 1 nothing is added: thousands of close contacts cost little.
  pure function estimate_of_interaction(pairs, law, closing) result(share)
    type(contact_pairs), intent(in) :: pairs   !! those that may touch, ascending gap
    class(contact_law), intent(in) :: law      !! of each contact
    real(real64), intent(in) :: closing        !! past first touch of all
    real(real64) :: share
    real(real64), allocatable :: x(:), y(:), circle(:), load(:), stiffness(:)
    real(real64) :: total, lost, enough, lift, rr, reach, row
    type(contact_response) :: response
    type(mutual_terms) :: terms
    integer :: i, j, n

    share = 0.0_real64
    n = count(pairs%list%gap < closing)
    if (n < 2) return
    allocate (x(n), y(n), circle(n), load(n), stiffness(n))
    do i = 1, n
      x(i) = pairs%list(i)%x
      y(i) = pairs%list(i)%y
      call law%respond(pairs%list(i), i, min(closing - pairs%list(i)%gap, &
                       0.999999_real64 * pairs%list(i)%zc), response)
      circle(i) = response%contact_radius
      load(i) = response%vertical_load
      stiffness(i) = response%stiffness
    end do
    total = sum(load)
    if (.not. total > 0.0_real64) return
    enough = total * pairs%modulus
    lost = 0.0_real64
    do j = 2, n
      row = 0.0_real64
      do i = 1, j - 1
        rr = (x(i) - x(j))**2 + (y(i) - y(j))**2
        reach = (circle(i) + circle(j))**2
        if (rr > bound_from**2 * reach) then
          lift = 1.0_real64 / (pi * sqrt(rr - reach))
          row = row + lift * (stiffness(i) * load(j) + stiffness(j) * load(i))
        else if (max(circle(i), circle(j)) > 0.0_real64) then
          call mutual_displacement(sqrt(rr), circle(i), circle(j), terms)
          row = row + stiffness(i) * load(j) * terms%on_first + &
                stiffness(j) * load(i) * terms%on_second
        end if
      end do
      lost = lost + row
      if (lost >= enough) exit
    end do
    share = min(lost / enough, 1.0_real64)
  end function estimate_of_interaction

end module asperity_interaction_estimate
