!> Contacts that are resolved on boundary elements from the start, chosen by geometry.
!>
!> Penetrations are estimated as those of isolated contacts times one factor t, which minimises the
!> potential: t + t**1.5 sum(V u)/sum(V p) = 1, with the loads V, penetrations p and displacements
!> by neighbours u of isolated contacts. Two contacts are resolved where the position of first touch
!> of one is within the larger of their circles. Up to 0.3 of its radius the potential of two
!> Hertzian contacts is not convex; from the radius on the harmonics of the field indicate their
!> error. A lower and sharper cap whose top is inside the sphere of the other is hidden and
!> excepted.
module asperity_near_tops
  use asperity_element_solver, only: is_radius_resolved
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

  !> Finds the contacts that are near another one by their positions of first touch, with all
  !> contacts whose circles are connected to theirs.
  subroutine find_near_tops(pairs, law, reach, compression, is_near, is_representative, radius, &
                            target)
    type(contact_pairs), intent(in) :: pairs         !! pairs of the position
    class(contact_law), intent(in) :: law            !! contact law of each pair
    real(real64), intent(in) :: reach                !! sums of radii below which circles connect
    real(real64), intent(inout) :: compression       !! compression; at a load set to a lower bound
    logical, intent(out) :: is_near(:)               !! by pair: near another one, or connected
    logical, intent(out) :: is_representative(:)     !! by pair: largest load of those near it
    real(real64), intent(out) :: radius(:)           !! by pair: estimated contact radius; 0: open
    real(real64), intent(in), optional :: target     !! normal load [force]
    type(circle_set) :: set
    type(source_tree) :: tree
    real(real64) :: penetration(size(pairs%list)), factor
    integer, allocatable :: loaded(:), first_circle(:), second_circle(:), member(:), first(:)
    logical, allocatable :: tops_are_near(:)
    integer :: k, l

    is_near = .false.
    is_representative = .false.
    radius = 0.0_real64
    call set_isolated_contacts(pairs, law, compression, penetration, set, target)
    if (.not. allocated(set%contact)) return
    allocate (loaded, source=set%contact)
    call build_tree(tree, set%x, set%y, set%radius, reach)
    if (allocated(tree%failure)) return
    first_circle = [((k, l=tree%first(k), tree%first(k + 1) - 1), k=1, size(loaded))]
    second_circle = tree%near(:size(first_circle))
    tops_are_near = [(are_near(pairs, set, penetration, first_circle(l), second_circle(l)), &
                      l=1, size(first_circle))]
    if (.not. any(tops_are_near)) return
    if (present(target)) then
      ! A lower bound of the compression, as neighbours reduce the loads. The radii are those of
      ! isolated contacts under the load.
      compression = pairs%list(loaded(1))%gap + penetration(loaded(1))
    else
      call find_factor(set, penetration(loaded), factor)
      if (allocated(set%tree%failure)) return
      set%radius = sqrt(factor) * set%radius
      tops_are_near = [(are_near(pairs, set, penetration, first_circle(l), second_circle(l)), &
                        l=1, size(first_circle))]
      if (.not. any(tops_are_near)) return
    end if
    call gather_groups(first_circle, second_circle, tops_are_near .or. &
                       hypot(set%x(first_circle) - set%x(second_circle), &
                             set%y(first_circle) - set%y(second_circle)) < &
                       reach * (set%radius(first_circle) + set%radius(second_circle)), &
                       spread(.true., 1, size(loaded)), size(loaded), member, first)
    is_near(loaded(pack(first_circle, tops_are_near))) = .true.
    is_near(loaded(pack(second_circle, tops_are_near))) = .true.
    do k = 1, size(first) - 1
      associate (group => loaded(member(first(k):first(k + 1) - 1)))
        if (any(is_near(group))) is_near(group) = .true.
      end associate
    end do
    radius(loaded) = set%radius
    call choose_representatives(set, tree, tops_are_near, is_near, is_representative)
  end subroutine find_near_tops

  ! Sets the isolated contacts at a compression, or at a load. There are none (`set%contact` is not
  ! allocated) if a contact radius exceeds that of its sphere or fewer than two contacts are loaded.
  subroutine set_isolated_contacts(pairs, law, compression, penetration, set, target)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    real(real64), intent(in) :: compression
    real(real64), intent(out) :: penetration(:)   ! penetration by pair
    type(circle_set), intent(out) :: set          ! isolated contacts: positions, radii, loads
    real(real64), intent(in), optional :: target
    type(contact_response) :: response
    integer, allocatable :: loaded(:)
    integer :: i, k

    penetration = compression - pairs%list%gap
    if (present(target)) then
      penetration = -pairs%list%gap
      call raise_to_load(pairs, law, target / pairs%modulus, penetration)
    end if
    loaded = pack([(i, i=1, size(penetration))], penetration > 0.0_real64)
    if (size(loaded) < 2) return
    call set%allocate_arrays(size(loaded))
    set%x = pairs%list(loaded)%x
    set%y = pairs%list(loaded)%y
    do k = 1, size(loaded)
      response = answer_at(pairs, law, loaded(k), penetration(loaded(k)))
      set%radius(k) = response%contact_radius
      set%load(k) = response%vertical_load * inclination_factor(response%cosine) / pairs%modulus
    end do
    set%contact = loaded
    ! Such penetrations are refused in the solve of the Hertzian contacts.
    if (any(set%radius > smaller_radius(pairs%list(loaded))) .or. &
        .not. sum(set%load) > 0.0_real64) deallocate (set%contact)
  end subroutine set_isolated_contacts

  ! Finds the factor t of the penetrations of isolated contacts that minimises the potential.
  ! Without memory for their field it is 1, with `set%tree%failure`.
  subroutine find_factor(set, penetration, factor)
    type(circle_set), intent(inout) :: set      ! isolated contacts; their field is set
    real(real64), intent(in) :: penetration(:)  ! penetrations
    real(real64), intent(out) :: factor
    real(real64) :: ratio, previous

    factor = 1.0_real64
    call list_near_circles(set)
    if (allocated(set%tree%failure)) return
    call find_field(set)
    ratio = dot_product(set%load, set%displacement) / dot_product(set%load, penetration)
    ! Newton's method on a convex function from above: monotonic up to rounding.
    do
      previous = factor
      factor = factor - (factor + ratio * factor**1.5_real64 - 1.0_real64) / &
               (1.0_real64 + 1.5_real64 * ratio * sqrt(factor))
      if (.not. factor < previous) exit
    end do
  end subroutine find_factor

  ! Chooses, by decreasing load, contacts that are not near each other to represent the others.
  subroutine choose_representatives(set, tree, tops_are_near, is_near, is_representative)
    type(circle_set), intent(in) :: set
    type(source_tree), intent(in) :: tree
    logical, intent(in) :: tops_are_near(:)     ! by pair of circles, in the order of `tree%near`
    logical, intent(in) :: is_near(:)
    logical, intent(inout) :: is_representative(:)
    integer :: order(size(set%contact)), i, l

    is_representative(set%contact) = is_near(set%contact)
    call sort_keys(-set%load, order)
    do i = 1, size(order)
      if (.not. is_representative(set%contact(order(i)))) cycle
      do l = tree%first(order(i)), tree%first(order(i) + 1) - 1
        if (tops_are_near(l)) is_representative(set%contact(tree%near(l))) = .false.
      end do
    end do
  end subroutine choose_representatives

  ! Whether the distance of the first touches of two contacts is below the larger contact radius and
  ! neither is hidden.
  pure logical function are_near(pairs, set, penetration, a, b)
    type(contact_pairs), intent(in) :: pairs
    type(circle_set), intent(in) :: set
    real(real64), intent(in) :: penetration(:)
    integer, intent(in) :: a, b
    real(real64) :: square

    square = (set%x(a) - set%x(b))**2 + (set%y(a) - set%y(b))**2
    are_near = square < max(set%radius(a), set%radius(b))**2 .and. &
               is_radius_resolved(set%x(a), set%y(a), max(set%radius(a), set%radius(b)))
    if (.not. are_near) return
    associate (i => set%contact(a), j => set%contact(b))
      are_near = .not. &
        (is_hidden(pairs%list(i), pairs%list(j), penetration(i), penetration(j), square) .or. &
         is_hidden(pairs%list(j), pairs%list(i), penetration(j), penetration(i), square))
    end associate
  end function are_near

  ! Whether the sharper cap of one pair is inside the paraboloid of another one at first touch.
  elemental logical function is_hidden(low, high, p_low, p_high, square)
    type(contact_pair), intent(in) :: low, high
    real(real64), intent(in) :: p_low, p_high     ! penetrations
    real(real64), intent(in) :: square            ! square of the distance of first touches

    is_hidden = low%radius <= high%radius .and. square > 0.0_real64 .and. &
                p_low < p_high - 0.5_real64 * square / high%radius
  end function is_hidden

  ! Radius of the smaller sphere of a pair; of the only one if the other surface is a plane.
  elemental real(real64) function smaller_radius(pair)
    type(contact_pair), intent(in) :: pair

    smaller_radius = min(pair%upper_radius, pair%lower_radius)
    if (.not. smaller_radius > 0.0_real64) smaller_radius = max(pair%upper_radius, &
                                                                pair%lower_radius)
  end function smaller_radius

end module asperity_near_tops
