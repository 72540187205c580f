!> Clusters of contacts on boundary elements, each in the field of the contacts outside it.
!>
!> The field of near contacts is computed element by element, that of far ones is interpolated
!> between Chebyshev nodes on the rectangle of the cluster, with fast multipole sums at the nodes.
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
  use asperity_problems, only: not_enough_memory
  use asperity_source_tree, only: build_tree, source_tree, sum_sources
  implicit none
  private

  public :: cluster, form_clusters, solve_clusters

  !> A cluster of resolved contacts.
  type :: cluster
    integer, allocatable :: members(:)              !! contacts, indices in the list of pairs
    type(cluster_lattice) :: lattice                !! lattice of its elements
    type(element_answer) :: answer                  !! solution on its elements
    logical :: is_solved = .false.                  !! solved in the present field of the others
    real(real64), allocatable :: load(:)            !! by member: vertical load by its law; 0: open
    integer, allocatable :: representative(:)       !! by member: member that carries its load
    real(real64) :: displacement = 0.0_real64       !! lower bound of the displacement by the others
    !> by member: number of successive iterations that have ended with a gap of its representative,
    !> the undeformed gap counted as the first
    integer, allocatable :: known_gaps(:)
    !> by member: change of its gap that the elements required in the last iteration, and the share
    !> of it that was applied
    real(real64), allocatable :: change(:), applied_share(:)
    type(outside_field) :: outside                  !! field of the contacts outside
  end type cluster

  ! Least distance of members of two clusters in sums of radii, and of interpolated circles from the
  ! centre of a cluster in half diagonals. The change of the load of a contact by the ellipticity of
  ! another one decreases with the sixth power of their distance, and is below 4e-6 of the load from
  ! this distance on (derived).
  real(real64), parameter :: separate_distance = 3.0_real64
  ! Chebyshev nodes along an axis of the interpolated field: its error is (3 + sqrt(8))**-8 = 1e-6
  ! of it (derived).
  integer, parameter :: nodes = 8

contains

  !> Groups resolved contacts: those nearer than `separate_distance` sums of their radii share a
  !> cluster.
  subroutine form_clusters(pairs, coupled, is_resolved, clusters, failure)
    type(contact_pairs), intent(in) :: pairs                 !! pairs of the position
    type(coupled_solution), intent(in) :: coupled            !! solution of Hertzian contacts
    logical, intent(in) :: is_resolved(:)                    !! by pair: whether it is resolved
    type(cluster), allocatable, intent(out) :: clusters(:)   !! clusters with their members
    character(len=:), allocatable, intent(inout) :: failure  !! reason, when memory is short
    type(source_tree) :: tree
    integer, allocatable :: resolved_pairs(:), circle_index(:), member(:), first(:)
    real(real64), allocatable :: reach(:), x(:), y(:)
    integer :: i, k, l

    resolved_pairs = pack([(i, i=1, size(pairs%list))], is_resolved)
    allocate (circle_index(size(pairs%list)), source=0)
    circle_index(coupled%set%contact) = [(i, i=1, size(coupled%set%contact))]
    allocate (reach(size(resolved_pairs)), source=0.0_real64)
    do i = 1, size(resolved_pairs)
      k = circle_index(resolved_pairs(i))
      if (k > 0) reach(i) = coupled%set%radius(k)
    end do
    x = pairs%list(resolved_pairs)%x
    y = pairs%list(resolved_pairs)%y
    call build_tree(tree, x, y, reach, separate_distance)
    if (allocated(tree%failure)) then
      failure = tree%failure
      return
    end if
    call gather_groups([((i, l=tree%first(i), tree%first(i + 1) - 1), i=1, size(resolved_pairs))], &
                       tree%near, spread(.true., 1, size(tree%near)), &
                       spread(.true., 1, size(resolved_pairs)), size(resolved_pairs), member, first)
    allocate (clusters(size(first) - 1))
    do k = 1, size(clusters)
      associate (n => first(k + 1) - first(k))
        clusters(k)%members = resolved_pairs(member(first(k):first(k + 1) - 1))
        clusters(k)%known_gaps = spread(1, 1, n)
        clusters(k)%change = spread(0.0_real64, 1, n)
        clusters(k)%applied_share = spread(1.0_real64, 1, n)
      end associate
    end do
  end subroutine form_clusters

  !> Solves all clusters, each in the field of the Hertzian contacts outside it.
  subroutine solve_clusters(pairs, coupled, tolerance, area_tolerance, clusters, failure)
    type(contact_pairs), intent(in) :: pairs              !! pairs of the position
    type(coupled_solution), intent(in) :: coupled         !! solution of Hertzian contacts
    real(real64), intent(in) :: tolerance                 !! relative error of the load of a cluster
    real(real64), intent(in) :: area_tolerance            !! relative error of its area
    type(cluster), intent(inout) :: clusters(:)           !! lattices, answers, fields are set
    character(len=:), allocatable, intent(inout) :: failure  !! error message if it did not converge
    integer, allocatable :: cluster_of(:)
    integer :: k, iteration
    real(real64) :: reference(2)

    allocate (cluster_of(size(pairs%list)), source=0)
    do k = 1, size(clusters)
      cluster_of(clusters(k)%members) = k
    end do
    clusters%displacement = 0.0_real64
    if (size(clusters) > 1 .or. any(cluster_of(coupled%set%contact) == 0)) then
      ! The rectangle of a cluster depends on its displacement by the others, and that on the
      ! rectangle: a fixed-point iteration.
      do iteration = 1, 3
        call find_outside_field(pairs, coupled, cluster_of(coupled%set%contact), clusters, failure)
        if (allocated(failure)) return
      end do
    else
      clusters(1)%outside = outside_field()
    end if
    ! The errors of areas are independent: their squares add up.
    reference = [pairs%modulus * sum(coupled%set%load) / size(clusters), &
                 pi * sum(coupled%set%radius**2) / sqrt(real(size(clusters), real64))]
    !$omp parallel do schedule(dynamic) if(size(clusters) > 1)
    do k = 1, size(clusters)
      associate (this_cluster => clusters(k))
        if (allocated(this_cluster%outside%node_displacement)) &
          this_cluster%outside%node_displacement = &
            this_cluster%outside%node_displacement - this_cluster%displacement
        if (this_cluster%is_solved) cycle
        call solve_elements(pairs, this_cluster%members, &
                            coupled%compression - this_cluster%displacement, this_cluster%outside, &
                            reshape([tolerance, area_tolerance, reference], [2, 2]), &
                            this_cluster%lattice, this_cluster%answer)
      end associate
    end do
    !$omp end parallel do
    do k = 1, size(clusters)
      if (allocated(clusters(k)%answer%failure)) failure = clusters(k)%answer%failure
      clusters(k)%is_solved = .true.
    end do
  end subroutine solve_clusters

  ! Finds the field of the contacts outside on the rectangle of each cluster, and its lower bound.
  subroutine find_outside_field(pairs, coupled, cluster_of, clusters, failure)
    type(contact_pairs), intent(in) :: pairs
    type(coupled_solution), intent(in) :: coupled
    integer, intent(in) :: cluster_of(:)     ! by circle: index of its cluster; 0: none
    type(cluster), intent(inout) :: clusters(:)
    character(len=:), allocatable, intent(inout) :: failure
    type(source_tree) :: tree
    ! Places and reach of circles, then of nodes; field at the nodes.
    real(real64), allocatable :: points(:, :), field(:, :)
    integer :: k, status

    associate (set => coupled%set, circles => size(coupled%set%x), &
               number => nodes**2 * size(clusters))
      allocate (points(circles + number, 3), stat=status)
      if (status == 0) allocate (field(6, number), stat=status)
      if (status /= 0) failure = not_enough_memory // ' for the displacement of resolved contacts'
      if (status /= 0) return
      points(:circles, 1) = set%x + set%shift(1, :)
      points(:circles, 2) = set%y + set%shift(2, :)
      points(:circles, 3) = near_factor * set%radius
      do k = 1, size(clusters)
        associate (at => points(circles + nodes**2 * (k - 1) + 1:circles + nodes**2 * k, :))
          call place_nodes(pairs, coupled%compression, clusters(k), at(:, 1), at(:, 2), at(:, 3))
        end associate
      end do
      call build_tree(tree, points(:, 1), points(:, 2), points(:, 3), 1.0_real64, circles)
      if (allocated(tree%failure)) then
        failure = tree%failure
        return
      end if
      call sum_sources(tree, set%load / pi, hertz_spread(set%radius), field)
      do k = 1, size(clusters)
        call set_outside_field(pairs, set, cluster_of, tree, points(circles + 1:, 1), &
                               points(circles + 1:, 2), field(1, :), k, clusters(k))
      end do
    end associate
  end subroutine find_outside_field

  ! Places the nodes of a cluster on its rectangle.
  subroutine place_nodes(pairs, compression, this_cluster, x, y, reach)
    type(contact_pairs), intent(in) :: pairs
    real(real64), intent(in) :: compression                ! compression of the contacts
    type(cluster), intent(inout) :: this_cluster           ! its rectangle is set
    real(real64), intent(out) :: x(:), y(:)                ! positions of the nodes
    real(real64), intent(out) :: reach(:)                  ! of a node: circles within it are near
    real(real64) :: node(nodes)

    node = chebyshev_nodes(nodes)
    associate (outside => this_cluster%outside)
      call cluster_extent(pairs, this_cluster%members, compression - this_cluster%displacement, &
                          outside%x0, outside%x1, outside%y0, outside%y1)
      x = reshape(spread(0.5_real64 * (outside%x0 + outside%x1 + &
                                       node * (outside%x1 - outside%x0)), 2, nodes), shape(x))
      y = reshape(spread(0.5_real64 * (outside%y0 + outside%y1 + &
                                       node * (outside%y1 - outside%y0)), 1, nodes), shape(y))
      ! Members are near all nodes.
      associate (half_diagonal => 0.5_real64 * hypot(outside%x1 - outside%x0, &
                                                     outside%y1 - outside%y0), &
                 list => pairs%list(this_cluster%members))
        reach = half_diagonal + max(separate_distance * half_diagonal, &
                                    maxval(hypot(list%x - outside%x0, list%y - outside%y0)))
      end associate
    end associate
  end subroutine place_nodes

  ! Sets the field of the contacts outside a cluster: the list of near circles, and the displacement
  ! by all others at the nodes. Long: circles, nodes and sums are several arrays each.
  subroutine set_outside_field(pairs, set, cluster_of, tree, x, y, far_field, k, this_cluster)
    type(contact_pairs), intent(in) :: pairs
    type(circle_set), intent(in) :: set
    integer, intent(in) :: cluster_of(:)        ! by circle: index of its cluster; 0: none
    type(source_tree), intent(in) :: tree       ! circles near each node
    real(real64), intent(in) :: x(:), y(:)      ! nodes of all clusters
    real(real64), intent(in) :: far_field(:)    ! by node: displacement by circles that are not near
    integer, intent(in) :: k                    ! index of the cluster
    type(cluster), intent(inout) :: this_cluster
    real(real64) :: half_diagonal, centre(2), field(nodes**2)
    integer, allocatable :: near_circles(:)
    integer :: i, j, l, n

    n = nodes**2 * (k - 1)
    associate (outside => this_cluster%outside)
      half_diagonal = 0.5_real64 * hypot(outside%x1 - outside%x0, outside%y1 - outside%y0)
      if (.not. half_diagonal > 0.0_real64) return
      centre = 0.5_real64 * [outside%x0 + outside%x1, outside%y0 + outside%y1]
      near_circles = tree%near(tree%first(n + 1):tree%first(n + 2) - 1)
      near_circles = pack(near_circles, cluster_of(near_circles) /= k .and. &
                          is_near_cluster(near_circles))
      outside%x = set%x(near_circles) + set%shift(1, near_circles)
      outside%y = set%y(near_circles) + set%shift(2, near_circles)
      outside%pair = set%contact(near_circles)
      outside%radius = set%radius(near_circles)
      outside%load = set%load(near_circles) * pairs%modulus
      field = far_field(n + 1:n + nodes**2)
      do i = 1, nodes**2
        do l = tree%first(n + i), tree%first(n + i + 1) - 1
          j = tree%near(l)
          if (cluster_of(j) == k .or. is_near_cluster(j)) cycle
          field(i) = field(i) + set%load(j) * circle_displacement(set%radius(j), &
            hypot(x(n + i) - (set%x(j) + set%shift(1, j)), &
                  y(n + i) - (set%y(j) + set%shift(2, j))))
        end do
      end do
      outside%node_displacement = reshape(field, [nodes, nodes])
      ! A lower bound of the field: its variation between nodes is below 1/nodes of its range.
      this_cluster%displacement = &
        max(0.0_real64, minval(field) - (maxval(field) - minval(field)) / nodes) + &
        sum(set%load(near_circles) * circle_displacement(set%radius(near_circles), hypot( &
          abs(outside%x - centre(1)) + 0.5_real64 * (outside%x1 - outside%x0), &
          abs(outside%y - centre(2)) + 0.5_real64 * (outside%y1 - outside%y0))))
    end associate

  contains

    ! Whether a circle is too near to the cluster for the interpolation of its field.
    elemental logical function is_near_cluster(circle)
      integer, intent(in) :: circle

      is_near_cluster = hypot(set%x(circle) + set%shift(1, circle) - centre(1), &
                              set%y(circle) + set%shift(2, circle) - centre(2)) < &
                        separate_distance * half_diagonal + set%radius(circle)
    end function is_near_cluster

  end subroutine set_outside_field

end module asperity_resolved_clusters
