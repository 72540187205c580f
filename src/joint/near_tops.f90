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
  use asperity_element_solver, only: is_resolved
  use asperity_circle_field, only: circle_set, find_field, inclination_factor, list_near_circles
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_coupled_state, only: answer_at, raise_to_load
  use asperity_index_groups, only: gather_groups
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: real64
  use asperity_source_tree, only: build_tree, source_tree
  implicit none
  private

  public :: find_near_tops

contains

  !> Finds the contacts whose first touches are near, with all contacts that their circles touch.
  subroutine find_near_tops(pairs, law, reach, closing, is_near, is_host, radius, target)
    type(contact_pairs), intent(in) :: pairs         !! pairs of the position
    class(contact_law), intent(in) :: law            !! contact law of each pair
    real(real64), intent(in) :: reach                !! sums of radii below which circles touch
    real(real64), intent(inout) :: closing           !! compression; at a load: its lower bound
    logical, intent(out) :: is_near(:)               !! by pair: is near to another, or touches one
    logical, intent(out) :: is_host(:)               !! of those near to each other: largest load
    real(real64), intent(out) :: radius(:)           !! contact radius by pair; 0: open
    real(real64), intent(in), optional :: target     !! normal load [force]
    type(circle_set) :: set
    type(source_tree) :: tree
    real(real64) :: p(size(pairs%list)), factor
    integer, allocatable :: number(:), one(:), other(:), member(:), first(:)
    logical, allocatable :: tops(:)
    integer :: k, l

    is_near = .false.
    is_host = .false.
    radius = 0.0_real64
    call isolate_contacts(pairs, law, closing, p, set, target)
    if (.not. allocated(set%contact)) return
    allocate (number, source=set%contact)
    call build_tree(tree, set%x, set%y, set%radius, reach)
    if (allocated(tree%failure)) return
    one = [((k, l=tree%first(k), tree%first(k + 1) - 1), k=1, size(number))]
    other = tree%near(:size(one))
    tops = [(are_near(pairs, set, p, one(l), other(l)), l=1, size(one))]
    if (.not. any(tops)) return
    if (present(target)) then
      ! Neighbours only reduce loads: a lower bound. The radii are those of the load.
      closing = pairs%list(number(1))%gap + p(number(1))
    else
      call find_factor(set, p(number), factor)
      if (allocated(set%tree%failure)) return
      set%radius = sqrt(factor) * set%radius
      tops = [(are_near(pairs, set, p, one(l), other(l)), l=1, size(one))]
      if (.not. any(tops)) return
    end if
    call gather_groups(one, other, tops .or. &
                       hypot(set%x(one) - set%x(other), set%y(one) - set%y(other)) < &
                       reach * (set%radius(one) + set%radius(other)), &
                       spread(.true., 1, size(number)), size(number), member, first)
    is_near(number(pack(one, tops))) = .true.
    is_near(number(pack(other, tops))) = .true.
    do k = 1, size(first) - 1
      associate (group => number(member(first(k):first(k + 1) - 1)))
        if (any(is_near(group))) is_near(group) = .true.
      end associate
    end do
    radius(number) = set%radius
    call choose_hosts(set, tree, tops, is_near, is_host)
  end subroutine find_near_tops

  ! Sets out isolated contacts at a compression, or at a load; none where their penetrations are
  ! beyond a sphere or fewer than two are loaded.
  subroutine isolate_contacts(pairs, law, closing, p, set, target)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    real(real64), intent(in) :: closing
    real(real64), intent(out) :: p(:)             ! penetration by pair
    type(circle_set), intent(out) :: set          ! without `number`: none
    real(real64), intent(in), optional :: target
    type(contact_response) :: answer
    integer, allocatable :: number(:)
    integer :: i, k

    p = closing - pairs%list%gap
    if (present(target)) then
      p = -pairs%list%gap
      call raise_to_load(pairs, law, target / pairs%modulus, p)
    end if
    number = pack([(i, i=1, size(p))], p > 0.0_real64)
    if (size(number) < 2) return
    call set%allocate_arrays(size(number))
    set%x = pairs%list(number)%x
    set%y = pairs%list(number)%y
    do k = 1, size(number)
      answer = answer_at(pairs, law, number(k), p(number(k)))
      set%radius(k) = answer%contact_radius
      set%load(k) = answer%vertical_load * inclination_factor(answer%cosine) / pairs%modulus
    end do
    set%contact = number
    ! Penetrations beyond a sphere are refused of Hertzian contacts.
    if (any(set%radius > smaller_radius(pairs%list(number))) .or. &
        .not. sum(set%load) > 0.0_real64) deallocate (set%contact)
  end subroutine isolate_contacts

  ! Finds the factor of the penetrations of isolated contacts that minimises the potential.
  subroutine find_factor(set, p, factor)
    type(circle_set), intent(inout) :: set      ! isolated contacts; gets their field
    real(real64), intent(in) :: p(:)            ! penetrations
    real(real64), intent(out) :: factor
    real(real64) :: ratio, before

    factor = 1.0_real64
    call list_near_circles(set)
    if (allocated(set%tree%failure)) return
    call find_field(set)
    ratio = dot_product(set%load, set%displacement) / dot_product(set%load, p)
    ! Newton's method from above on a convex function falls to the root, up to rounding.
    do
      before = factor
      factor = factor - (factor + ratio * factor**1.5_real64 - 1.0_real64) / &
               (1.0_real64 + 1.5_real64 * ratio * sqrt(factor))
      if (.not. factor < before) exit
    end do
  end subroutine find_factor

  ! Chooses one host of first touches that are near to each other, by falling load.
  subroutine choose_hosts(set, tree, tops, is_near, is_host)
    type(circle_set), intent(in) :: set
    type(source_tree), intent(in) :: tree
    logical, intent(in) :: tops(:)              ! by pair of circles, as `tree` lists them
    logical, intent(in) :: is_near(:)
    logical, intent(inout) :: is_host(:)
    integer :: order(size(set%contact)), i, l

    is_host(set%contact) = is_near(set%contact)
    call sort_keys(-set%load, order)
    do i = 1, size(order)
      if (.not. is_host(set%contact(order(i)))) cycle
      do l = tree%first(order(i)), tree%first(order(i) + 1) - 1
        if (tops(l)) is_host(set%contact(tree%near(l))) = .false.
      end do
    end do
  end subroutine choose_hosts

  ! Whether the first touches of two contacts are within the larger circle, neither hidden.
  pure logical function are_near(pairs, set, p, a, b)
    type(contact_pairs), intent(in) :: pairs
    type(circle_set), intent(in) :: set
    real(real64), intent(in) :: p(:)
    integer, intent(in) :: a, b
    real(real64) :: square

    square = (set%x(a) - set%x(b))**2 + (set%y(a) - set%y(b))**2
    are_near = square < max(set%radius(a), set%radius(b))**2 .and. &
               is_resolved(set%x(a), set%y(a), max(set%radius(a), set%radius(b)))
    if (.not. are_near) return
    associate (i => set%contact(a), j => set%contact(b))
      are_near = .not. (is_hidden(pairs%list(i), pairs%list(j), p(i), p(j), square) .or. &
                        is_hidden(pairs%list(j), pairs%list(i), p(j), p(i), square))
    end associate
  end function are_near

  ! Whether the top of the sharper cap of a pair is inside the paraboloid of another.
  elemental logical function is_hidden(low, high, p_low, p_high, square)
    type(contact_pair), intent(in) :: low, high
    real(real64), intent(in) :: p_low, p_high     ! penetrations
    real(real64), intent(in) :: square            ! of the distance of the first touches

    is_hidden = low%radius <= high%radius .and. square > 0.0_real64 .and. &
                p_low < p_high - 0.5_real64 * square / high%radius
  end function is_hidden

  ! The smaller radius of the two spheres of a pair; of one on a plane, its radius.
  elemental real(real64) function smaller_radius(pair)
    type(contact_pair), intent(in) :: pair

    smaller_radius = min(pair%upper_radius, pair%lower_radius)
    if (.not. smaller_radius > 0.0_real64) smaller_radius = max(pair%upper_radius, &
                                                                pair%lower_radius)
  end function smaller_radius

end module asperity_near_tops
