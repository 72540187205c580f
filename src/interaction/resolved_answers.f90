!> What the cells of clusters answer, told to the circles.
module asperity_resolved_answers
  use asperity_circle_field, only: circle_set
  use asperity_cells_outside, only: beside_circle
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_contacts, only: adopt, coupled_solution, resolved_contacts
  use asperity_kinds, only: real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms
  use asperity_resolved_clusters, only: cluster
  implicit none
  private

  public :: answer_with

  !> Penetration of a resolved contact that the cells leave open: it joins no more.
  real(real64), parameter, public :: far_below = -1.0e-3_real64 * huge(1.0_real64)

contains

  !> The answers of the cells, as contacts that carry their loads where their pressures are.
  subroutine answer_with(pairs, law, clusters, coupled, resolved)
    type(contact_pairs), intent(in) :: pairs            !! the position
    class(contact_law), intent(in) :: law               !! of each contact
    type(cluster), intent(in) :: clusters(:)            !! solved
    type(coupled_solution), intent(inout) :: coupled    !! gets their penetrations
    type(resolved_contacts), intent(inout) :: resolved  !! those on cells: all but places and gaps
    type(contact_response) :: free
    type(circle_set) :: old
    integer, dimension(size(pairs%list)) :: before, now
    real(real64), allocatable :: circle(:)
    real(real64) :: share
    integer :: i, k, m

    old = coupled%set
    do k = 1, size(clusters)
      associate (answer => clusters(k)%answer)
        do m = 1, size(clusters(k)%members)
          i = clusters(k)%members(m)
          resolved%x(i) = answer%centre_x(m)
          resolved%y(i) = answer%centre_y(m)
          coupled%penetration(i) = far_below
          coupled%move_x(i) = 0.0_real64
          coupled%move_y(i) = 0.0_real64
          if (.not. (answer%vertical_load(m) > 0.0_real64 .and. &
                     answer%alone_load(m) > 0.0_real64)) cycle
          ! Together over alone: how a pair is inclined counts as it does in its law. Neighbours
          ! never raise a load: more than 1 is what the cells are not solved to.
          share = min(1.0_real64, answer%vertical_load(m) / answer%alone_load(m))
          call law%respond(pairs%list(i), i, &
                           coupled%closing - clusters(k)%lowered - pairs%list(i)%gap, free)
          coupled%penetration(i) = penetration_at(pairs, law, i, share * free%vertical_load, &
                                                  coupled%closing - pairs%list(i)%gap)
        end do
      end associate
    end do
    call adopt(pairs, law, coupled, resolved)
    if (allocated(coupled%failure)) return
    before = 0
    now = 0
    before(old%number) = [(i, i=1, size(old%number))]
    now(coupled%set%number) = [(i, i=1, size(coupled%set%number))]
    where (.not. resolved%is_one) resolved%gap = pairs%list%gap
    do k = 1, size(clusters)
      call lift_by_others(old, coupled, before, now, clusters(k)%members, resolved%gap)
      allocate (circle(size(clusters(k)%members)), source=0.0_real64)
      do m = 1, size(circle)
        i = now(clusters(k)%members(m))
        if (i > 0) circle(m) = coupled%set%circle(i)
      end do
      call lift_others(pairs%modulus, clusters(k), circle, resolved)
      deallocate (circle)
    end do
  end subroutine answer_with

  ! What the pressures on cells do to circles beside them, and circles in their places do not.
  subroutine lift_others(modulus, one, circle, resolved)
    real(real64), intent(in) :: modulus
    type(cluster), intent(in) :: one
    real(real64), intent(in) :: circle(:)    ! radii of the members
    type(resolved_contacts), intent(inout) :: resolved
    integer :: l

    if (.not. allocated(one%answer%beside)) return
    do l = 1, size(one%answer%beside)
      associate (n => one%outside%pair(l), answer => one%answer)
        if (.not. resolved%is_one(n)) resolved%gap(n) = resolved%gap(n) + answer%beside(l) - &
          sum(answer%vertical_load * beside_circle(circle, hypot( &
            answer%centre_x - one%outside%x(l), answer%centre_y - one%outside%y(l)))) / modulus
      end associate
    end do
  end subroutine lift_others

  ! The cells were solved under the others' old loads. With these the equations shall hold, so that
  ! the coupling lets each cluster respond to what the others have become since.
  subroutine lift_by_others(old, coupled, before, now, members, gap)
    type(circle_set), intent(in) :: old
    type(coupled_solution), intent(in) :: coupled
    integer, intent(in) :: before(:), now(:)  ! circle of a pair, 0: none
    integer, intent(in) :: members(:)
    real(real64), intent(inout) :: gap(:)
    integer :: i, j, m, n

    do m = 1, size(members)
      i = members(m)
      if (before(i) == 0 .or. now(i) == 0) cycle
      ! The field of the others alone: first as it is, then as it was.
      gap(i) = gap(i) + coupled%set%lift(now(i)) - old%lift(before(i))
      do n = 1, size(members)
        j = members(n)
        if (n == m) cycle
        if (now(j) > 0) gap(i) = gap(i) - lift(coupled%set, now(i), now(j))
        if (before(j) > 0) gap(i) = gap(i) + lift(old, before(i), before(j))
      end do
    end do

  contains

    real(real64) function lift(set, on, by)
      type(circle_set), intent(in) :: set
      integer, intent(in) :: on, by
      type(mutual_terms) :: terms

      call mutual_displacement(hypot(set%x(on) + set%move_x(on) - set%x(by) - set%move_x(by), &
                                     set%y(on) + set%move_y(on) - set%y(by) - set%move_y(by)), &
                               set%circle(on), set%circle(by), terms)
      lift = set%load(by) * terms%on_first
    end function lift

  end subroutine lift_by_others

  ! Where a law has a vertical load.
  real(real64) function penetration_at(pairs, law, i, load, most) result(p)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    integer, intent(in) :: i
    real(real64), intent(in) :: load, most
    type(contact_response) :: response
    real(real64) :: before
    integer :: step

    p = most
    ! Newton's method on load**(2/3), nearly straight.
    do step = 1, 50
      call law%respond(pairs%list(i), i, p, response)
      if (.not. response%stiffness > 0.0_real64) exit
      before = p
      p = p + 1.5_real64 * response%vertical_load / response%stiffness * &
          ((load / response%vertical_load)**(2.0_real64 / 3.0_real64) - 1.0_real64)
      p = min(max(p, 0.1_real64 * before), 2 * before)
      if (abs(p - before) <= 1.0e-14_real64 * p) exit
    end do
  end function penetration_at

end module asperity_resolved_answers
