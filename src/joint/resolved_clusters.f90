!> Clusters of contacts on boundary elements, each in the field of all others.
module asperity_resolved_clusters
  use asperity_element_answer, only: element_answer
  use asperity_outside_field, only: circle_displacement, outside_field
  use asperity_element_solver, only: cluster_lattice, cluster_extent, solve_elements
  use asperity_chebyshev_basis, only: chebyshev_nodes
  use asperity_circle_field, only: circle_set, hertz_spread, near_factor
  use asperity_constants, only: pi
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_contacts, only: coupled_solution
  use asperity_index_groups, only: gather_groups
  use asperity_kinds, only: real64
  use asperity_source_tree, only: build_tree, source_tree, sum_sources
  implicit none
  private

  public :: cluster, form_clusters, solve_clusters

  !> A cluster of resolved contacts.
  type :: cluster
    integer, allocatable :: members(:)              !! places in the list of pairs
    type(cluster_lattice) :: lattice                !! its elements
    type(element_answer) :: answer                  !! solution on its elements
    logical :: is_solved = .false.                  !! in the present field of the others
    real(real64), allocatable :: load(:)            !! vertical, by its law; 0: open
    integer, allocatable :: host(:)                 !! member that represents it among circles
    real(real64) :: displacement = 0.0_real64       !! displacement of the cluster by the others
    !> changes of the gaps of its circles required by its elements in the last round, and the share
    !! of them that was applied
    real(real64), allocatable :: change(:), taken(:)
    type(outside_field) :: outside                  !! field of the others
  end type cluster

  ! Sums of radii between members of two clusters at least, and half diagonals of a cluster from its
  ! middle to the circles whose field is interpolated. The change of another contact by the
  ! ellipticity of one falls with the sixth power of their distance, and is below 4e-6 of its load
  ! from there (derived; test: clusters far apart in test/unit/joint_suite.f90).
  real(real64), parameter :: far_off = 3.0_real64
  ! Chebyshev nodes along an axis of the interpolated field: its error is (3 + sqrt(8))**-8 = 1e-6
  ! of it (derived; test: fields at nodes in test/unit/elements_suite.f90).
  integer, parameter :: nodes = 8
  !> Relative error of an area over that of its load, as an error indicator, and as tolerances. For
  !! an ellipse the area gains 4/3 of what its load gains, and a load in error has the area in
  !! error by 2/3; twice their sum, as the field of contacts that nearly touch adds more (measured:
  !! 3.3 at most in 97 of 100 dense scenes; test: areas in test/regression/test_dense.py).
  real(real64), parameter, public :: area_per_load = 4.0_real64

contains

  !> Members nearer to each other than `far_off` sums of their radii share a lattice.
  subroutine form_clusters(pairs, coupled, is_resolved, radius, clusters)
    type(contact_pairs), intent(in) :: pairs                 !! pairs of the position
    type(coupled_solution), intent(in) :: coupled            !! solution of Hertzian contacts
    logical, intent(in) :: is_resolved(:)                    !! by pair: resolved
    real(real64), intent(in) :: radius(:)                    !! by pair: radius at least
    type(cluster), allocatable, intent(out) :: clusters(:)   !! clusters, not solved yet
    type(source_tree) :: tree
    integer, allocatable :: number(:), circle_of(:), member(:), first(:)
    real(real64), allocatable :: reach(:)
    integer :: i, k, l

    number = pack([(i, i=1, size(pairs%list))], is_resolved)
    allocate (circle_of(size(pairs%list)), source=0)
    circle_of(coupled%set%contact) = [(i, i=1, size(coupled%set%contact))]
    reach = radius(number)
    do i = 1, size(number)
      if (circle_of(number(i)) > 0) reach(i) = max(reach(i), &
                                                   coupled%set%radius(circle_of(number(i))))
    end do
    call build_tree(tree, pairs%list(number)%x, pairs%list(number)%y, reach, far_off)
    call gather_groups([((i, l=tree%first(i), tree%first(i + 1) - 1), i=1, size(number))], &
                       tree%near, spread(.true., 1, size(tree%near)), &
                       spread(.true., 1, size(number)), size(number), member, first)
    allocate (clusters(size(first) - 1))
    do k = 1, size(clusters)
      clusters(k)%members = number(member(first(k):first(k + 1) - 1))
    end do
  end subroutine form_clusters

  !> Solves all clusters, each in the field of the Hertzian contacts that are no members.
  subroutine solve_clusters(pairs, coupled, tolerance, area_tolerance, clusters, failure)
    type(contact_pairs), intent(in) :: pairs              !! pairs of the position
    type(coupled_solution), intent(in) :: coupled         !! solution of Hertzian contacts
    real(real64), intent(in) :: tolerance              !! share of the load that halving may change
    real(real64), intent(in) :: area_tolerance            !! share of the area, at least
    type(cluster), intent(inout) :: clusters(:)           !! get their answers
    character(len=:), allocatable, intent(inout) :: failure  !! no memory, or not converged
    integer, allocatable :: cluster_of(:)
    integer :: k, pass
    real(real64) :: reference(2)

    allocate (cluster_of(size(pairs%list)), source=0)
    do k = 1, size(clusters)
      cluster_of(clusters(k)%members) = k
    end do
    clusters%displacement = 0.0_real64
    if (size(clusters) > 1 .or. any(cluster_of(coupled%set%contact) == 0)) then
      ! The displacement of the whole cluster by the others makes its lattice smaller.
      do pass = 1, 3
        call find_outside_field(pairs, coupled, cluster_of(coupled%set%contact), clusters, failure)
        if (allocated(failure)) return
      end do
    else
      clusters(1)%outside = outside_field()
    end if
    ! Areas scatter: their squares add up.
    reference = [pairs%modulus * sum(coupled%set%load) / size(clusters), &
                 pi * sum(coupled%set%radius**2) / sqrt(real(size(clusters), real64))]
    !$omp parallel do schedule(dynamic) if(size(clusters) > 1)
    do k = 1, size(clusters)
      associate (one => clusters(k))
        if (allocated(one%outside%node_displacement)) &
          one%outside%node_displacement = one%outside%node_displacement - one%displacement
        if (one%is_solved) cycle
        call solve_elements(pairs, one%members, coupled%closing - one%displacement, one%outside, &
                         [tolerance, max(area_per_load * tolerance, area_tolerance)], reference, &
                         one%lattice, one%answer)
      end associate
    end do
    !$omp end parallel do
    do k = 1, size(clusters)
      if (allocated(clusters(k)%answer%failure)) failure = clusters(k)%answer%failure
      clusters(k)%is_solved = .true.
    end do
  end subroutine solve_clusters

  ! Finds the field of the other contacts on the rectangle of each cluster, and a bound that it is
  ! nowhere below.
  subroutine find_outside_field(pairs, coupled, cluster_of, clusters, failure)
    type(contact_pairs), intent(in) :: pairs
    type(coupled_solution), intent(in) :: coupled
    integer, intent(in) :: cluster_of(:)     ! cluster of each circle, 0: none
    type(cluster), intent(inout) :: clusters(:)
    character(len=:), allocatable, intent(inout) :: failure
    type(source_tree) :: tree
    real(real64), dimension(nodes**2 * size(clusters)) :: x, y, reach
    real(real64) :: field(6, size(x))
    integer :: k

    do k = 1, size(clusters)
      associate (last => nodes**2 * k)
        call place_nodes(pairs, coupled%closing, clusters(k), x(last - nodes**2 + 1:last), &
                         y(last - nodes**2 + 1:last), reach(last - nodes**2 + 1:last))
      end associate
    end do
    associate (set => coupled%set)
      call build_tree(tree, [set%x + set%shift(1, :), x], [set%y + set%shift(2, :), y], &
                      [near_factor * set%radius, reach], 1.0_real64, size(set%x))
      if (allocated(tree%failure)) then
        failure = tree%failure
        return
      end if
      call sum_sources(tree, set%load / pi, hertz_spread * set%radius**2, field)
    end associate
    do k = 1, size(clusters)
      call set_outside_field(pairs, coupled%set, cluster_of, tree, x, y, field(1, :), k, &
                             clusters(k))
    end do
  end subroutine find_outside_field

  ! Places the nodes of a cluster on its rectangle.
  subroutine place_nodes(pairs, closing, one, x, y, reach)
    type(contact_pairs), intent(in) :: pairs
    real(real64), intent(in) :: closing                    ! compression of the contacts
    type(cluster), intent(inout) :: one                    ! gets its rectangle
    real(real64), intent(out) :: x(:), y(:), reach(:)      ! by node; circles within it are near
    real(real64) :: node(nodes)

    node = chebyshev_nodes(nodes)
    associate (o => one%outside)
      call cluster_extent(pairs, one%members, closing - one%displacement, o%x0, o%x1, o%y0, o%y1)
      x = reshape(spread(0.5_real64 * (o%x0 + o%x1 + node * (o%x1 - o%x0)), 2, nodes), shape(x))
      y = reshape(spread(0.5_real64 * (o%y0 + o%y1 + node * (o%y1 - o%y0)), 1, nodes), shape(y))
      ! Members are near all nodes.
      associate (half => 0.5_real64 * hypot(o%x1 - o%x0, o%y1 - o%y0), &
                 list => pairs%list(one%members))
        reach = half + max(far_off * half, maxval(hypot(list%x - o%x0, list%y - o%y0)))
      end associate
    end associate
  end subroutine place_nodes

  ! Sets the field of the others at the nodes of a cluster: circles beside it by themselves, element
  ! by element, the others by interpolation. Long: circles, nodes and sums each are several arrays.
  subroutine set_outside_field(pairs, set, cluster_of, tree, x, y, far, k, one)
    type(contact_pairs), intent(in) :: pairs
    type(circle_set), intent(in) :: set
    integer, intent(in) :: cluster_of(:)        ! of each circle, 0: none
    type(source_tree), intent(in) :: tree       ! circles near each node
    real(real64), intent(in) :: x(:), y(:)      ! nodes of all clusters
    real(real64), intent(in) :: far(:)          ! field of the circles that are far, by node
    integer, intent(in) :: k                    ! number of the cluster
    type(cluster), intent(inout) :: one
    real(real64) :: half, middle(2), field(nodes**2)
    integer, allocatable :: beside(:)
    integer :: i, j, l, n

    n = nodes**2 * (k - 1)
    associate (o => one%outside)
      half = 0.5_real64 * hypot(o%x1 - o%x0, o%y1 - o%y0)
      if (.not. half > 0.0_real64) return
      middle = 0.5_real64 * [o%x0 + o%x1, o%y0 + o%y1]
      beside = tree%near(tree%first(n + 1):tree%first(n + 2) - 1)
      beside = pack(beside, cluster_of(beside) /= k .and. is_beside(beside))
      o%x = set%x(beside) + set%shift(1, beside)
      o%y = set%y(beside) + set%shift(2, beside)
      o%pair = set%contact(beside)
      o%radius = set%radius(beside)
      o%load = set%load(beside) * pairs%modulus
      field = far(n + 1:n + nodes**2)
      do i = 1, nodes**2
        do l = tree%first(n + i), tree%first(n + i + 1) - 1
          j = tree%near(l)
          if (cluster_of(j) == k .or. is_beside(j)) cycle
          field(i) = field(i) + set%load(j) * circle_displacement(set%radius(j), &
            hypot(x(n + i) - (set%x(j) + set%shift(1, j)), &
                  y(n + i) - (set%y(j) + set%shift(2, j))))
        end do
      end do
      o%node_displacement = reshape(field, [nodes, nodes])
      ! A lower bound of the field: it changes less between nodes than from node to node.
      one%displacement = &
        max(0.0_real64, minval(field) - (maxval(field) - minval(field)) / nodes) + &
        sum(set%load(beside) * circle_displacement(set%radius(beside), hypot( &
          abs(o%x - middle(1)) + 0.5_real64 * (o%x1 - o%x0), &
          abs(o%y - middle(2)) + 0.5_real64 * (o%y1 - o%y0))))
    end associate

  contains

    ! Whether a circle is so near to the cluster that its field is not interpolated.
    elemental logical function is_beside(circle)
      integer, intent(in) :: circle

      is_beside = hypot(set%x(circle) + set%shift(1, circle) - middle(1), &
                        set%y(circle) + set%shift(2, circle) - middle(2)) < &
                  far_off * half + set%radius(circle)
    end function is_beside

  end subroutine set_outside_field

end module asperity_resolved_clusters
