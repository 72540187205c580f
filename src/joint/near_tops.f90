!> Contacts that boundary elements resolve from the start, chosen by geometry.
!>
!> The penetrations are those of isolated contacts times one factor t, which minimises the
!> potential: with the loads V, penetrations p and displacements by neighbours u of isolated
!> contacts, t + t**1.5 sum(V u)/sum(V p) = 1. Where the first touch of a contact lies within the
!> larger of two such circles, both are resolved: up to 0.3 of the radius the potential of two
!> contacts is not convex, from the radius on the harmonics of a field indicate the error of a
!> Hertzian contact. A lower and sharper cap whose top is inside the
!> other's sphere does not count.
module asperity_near_tops
  use asperity_cells_solver, only: is_resolved
  use asperity_circle_field, only: circle_set, find_field, inclination, plant_circles
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_coupled_state, only: answer_at, raise
  use asperity_index_groups, only: gather_groups
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: real64
  use asperity_source_tree, only: plant_tree, source_tree
  implicit none
  private

  public :: find_near_tops

contains

  !> Finds the contacts whose first touches are near, with all contacts that their circles touch.
  subroutine find_near_tops(pairs, law, along, closing, is_near, is_host, circle, target)
    type(contact_pairs), intent(in) :: pairs         !! the position
    class(contact_law), intent(in) :: law            !! of each contact
    real(real64), intent(in) :: along                !! sums of radii below which circles touch
    real(real64), intent(inout) :: closing           !! past first touch; at a load: its lower bound
    logical, intent(out) :: is_near(:)               !! by pair
    logical, intent(out) :: is_host(:)               !! of those near to each other: largest load
    real(real64), intent(out) :: circle(:)           !! radius of the start by pair; 0: open
    real(real64), intent(in), optional :: target     !! normal load
    type(circle_set) :: set
    type(source_tree) :: tree
    type(contact_response) :: answer
    real(real64) :: p(size(pairs%list)), t, ratio, before
    integer, allocatable :: number(:), one(:), other(:), member(:), first(:)
    integer :: i, k, l
    integer, allocatable :: order(:)
    logical, allocatable :: tops(:)

    is_near = .false.
    is_host = .false.
    circle = 0.0_real64
    p = closing - pairs%list%gap
    if (present(target)) then
      p = -pairs%list%gap
      call raise(pairs, law, target / pairs%modulus, p)
    end if
    number = pack([(i, i=1, size(p))], p > 0.0_real64)
    if (size(number) < 2) return
    call set%make_room(size(number))
    set%number = number
    set%x = pairs%list(number)%x
    set%y = pairs%list(number)%y
    do k = 1, size(number)
      answer = answer_at(pairs, law, number(k), p(number(k)))
      set%circle(k) = answer%contact_radius
      set%load(k) = answer%vertical_load * inclination(answer%cosine) / pairs%modulus
    end do
    if (.not. sum(set%load) > 0.0_real64) return
    ! Penetrations beyond a sphere are refused of Hertzian contacts.
    if (any(set%circle > smaller_radius(pairs%list(number)))) return
    call plant_tree(tree, set%x, set%y, set%circle, along)
    if (allocated(tree%failure)) return
    one = [((k, l=tree%first(k), tree%first(k + 1) - 1), k=1, size(number))]
    other = tree%near(:size(one))
    allocate (tops(size(one)))
    do l = 1, size(one)
      tops(l) = has_near_tops(one(l), other(l))
    end do
    if (.not. any(tops)) return
    t = 1.0_real64
    if (present(target)) then
      ! Neighbours only reduce loads: a lower bound. The radii are those of the load.
      closing = pairs%list(number(1))%gap + p(number(1))
    else
      call plant_circles(set)
      if (allocated(set%tree%failure)) return
      call find_field(set)
      ratio = dot_product(set%load, set%lift) / dot_product(set%load, p(number))
      ! Newton's method from above on a convex function falls to the root, up to rounding.
      do
        before = t
        t = t - (t + ratio * t**1.5_real64 - 1.0_real64) / &
            (1.0_real64 + 1.5_real64 * ratio * sqrt(t))
        if (.not. t < before) exit
      end do
    end if
    set%circle = sqrt(t) * set%circle
    do l = 1, size(one)
      tops(l) = has_near_tops(one(l), other(l))
    end do
    if (.not. any(tops)) return
    call gather_groups(one, other, tops .or. &
                       hypot(set%x(one) - set%x(other), set%y(one) - set%y(other)) < &
                       along * (set%circle(one) + set%circle(other)), &
                       spread(.true., 1, size(number)), size(number), member, first)
    do l = 1, size(one)
      if (tops(l)) is_near(number([one(l), other(l)])) = .true.
    end do
    do k = 1, size(first) - 1
      associate (group => member(first(k):first(k + 1) - 1))
        if (.not. any(is_near(number(group)))) cycle
        is_near(number(group)) = .true.
      end associate
    end do
    circle(number) = set%circle
    ! Of first touches that are near to each other only one is a host, by falling load.
    is_host(number) = is_near(number)
    allocate (order(size(number)))
    call sort_keys(-set%load, order)
    do i = 1, size(order)
      k = order(i)
      if (.not. is_host(number(k))) cycle
      do l = tree%first(k), tree%first(k + 1) - 1
        if (tops(l)) is_host(number(tree%near(l))) = .false.
      end do
    end do

  contains

    ! Whether the first touches of two contacts are within the larger circle, neither hidden.
    logical function has_near_tops(a, b) result(has)
      integer, intent(in) :: a, b
      real(real64) :: square

      square = (set%x(a) - set%x(b))**2 + (set%y(a) - set%y(b))**2
      has = square < max(set%circle(a), set%circle(b))**2 .and. &
            is_resolved(set%x(a), set%y(a), max(set%circle(a), set%circle(b)))
      if (has) has = .not. (is_hidden(number(a), number(b), square) .or. &
                            is_hidden(number(b), number(a), square))
    end function has_near_tops

    ! Whether the top of the sharper cap i is inside the paraboloid of j.
    logical function is_hidden(i, j, square)
      integer, intent(in) :: i, j
      real(real64), intent(in) :: square

      associate (low => pairs%list(i), high => pairs%list(j))
        is_hidden = low%radius <= high%radius .and. square > 0.0_real64 .and. &
                    p(i) < p(j) - 0.5_real64 * square / high%radius
      end associate
    end function is_hidden

  end subroutine find_near_tops

  ! The smaller radius of the two spheres of a pair; of one on a plane, its radius.
  elemental real(real64) function smaller_radius(pair)
    type(contact_pair), intent(in) :: pair

    smaller_radius = min(pair%upper_radius, pair%lower_radius)
    if (.not. smaller_radius > 0.0_real64) smaller_radius = max(pair%upper_radius, &
                                                                pair%lower_radius)
  end function smaller_radius

end module asperity_near_tops
