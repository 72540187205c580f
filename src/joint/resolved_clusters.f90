!> Clusters of contacts on boundary elements, each in the field of all others.
module asperity_resolved_clusters
  use asperity_element_answer, only: element_answer
  use asperity_outside_field, only: beside_circle, outside_field
  use asperity_element_solver, only: cluster_lattice, reach_of_cluster, solve_elements
  use asperity_chebyshev_basis, only: chebyshev_nodes
  use asperity_circle_field, only: hertz_spread, near_factor
  use asperity_constants, only: pi
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_contacts, only: coupled_solution
  use asperity_index_groups, only: gather_groups
  use asperity_kinds, only: real64
  use asperity_source_tree, only: plant_tree, source_tree, sum_sources
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
    real(real64) :: lowered = 0.0_real64            !! displacement of the cluster by the others
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
  subroutine form_clusters(pairs, coupled, is_one, circle, clusters)
    type(contact_pairs), intent(in) :: pairs                 !! pairs of the position
    type(coupled_solution), intent(in) :: coupled            !! solution of Hertzian contacts
    logical, intent(in) :: is_one(:)                         !! by pair: resolved
    real(real64), intent(in) :: circle(:)                    !! by pair: radius at least
    type(cluster), allocatable, intent(out) :: clusters(:)   !! clusters, not solved yet
    type(source_tree) :: tree
    integer, allocatable :: number(:), row(:), member(:), first(:)
    real(real64), allocatable :: reach(:)
    integer :: i, k, l

    number = pack([(i, i=1, size(pairs%list))], is_one)
    allocate (row(size(pairs%list)), source=0)
    row(coupled%set%number) = [(i, i=1, size(coupled%set%number))]
    reach = circle(number)
    do i = 1, size(number)
      if (row(number(i)) > 0) reach(i) = max(reach(i), coupled%set%circle(row(number(i))))
    end do
    call plant_tree(tree, pairs%list(number)%x, pairs%list(number)%y, reach, far_off)
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
    integer, allocatable :: of(:)
    integer :: k, pass
    real(real64) :: worth(2)

    allocate (of(size(pairs%list)), source=0)
    do k = 1, size(clusters)
      of(clusters(k)%members) = k
    end do
    clusters%lowered = 0.0_real64
    if (size(clusters) > 1 .or. any(of(coupled%set%number) == 0)) then
      ! The displacement of the whole cluster by the others makes its lattice smaller.
      do pass = 1, 3
        call find_outside(pairs, coupled, of(coupled%set%number), clusters, failure)
        if (allocated(failure)) return
      end do
    else
      clusters(1)%outside = outside_field()
    end if
    ! Areas scatter: their squares add up.
    worth = [pairs%modulus * sum(coupled%set%load) / size(clusters), &
             pi * sum(coupled%set%circle**2) / sqrt(real(size(clusters), real64))]
    !$omp parallel do schedule(dynamic) if(size(clusters) > 1)
    do k = 1, size(clusters)
      associate (one => clusters(k))
        if (allocated(one%outside%at_nodes)) &
          one%outside%at_nodes = one%outside%at_nodes - one%lowered
        if (one%is_solved) cycle
        call solve_elements(pairs, one%members, coupled%closing - one%lowered, one%outside, &
                         [tolerance, max(area_per_load * tolerance, area_tolerance)], worth, &
                         one%lattice, one%answer)
      end associate
    end do
    !$omp end parallel do
    do k = 1, size(clusters)
      if (allocated(clusters(k)%answer%failure)) failure = clusters(k)%answer%failure
      clusters(k)%is_solved = .true.
    end do
  end subroutine solve_clusters

  ! The field of the others on the rectangle of each cluster, and a bound that it is nowhere below.
  subroutine find_outside(pairs, coupled, of, clusters, failure)
    type(contact_pairs), intent(in) :: pairs
    type(coupled_solution), intent(in) :: coupled
    integer, intent(in) :: of(:)             ! cluster of each circle, 0: none
    type(cluster), intent(inout) :: clusters(:)
    character(len=:), allocatable, intent(inout) :: failure
    type(source_tree) :: tree
    real(real64), allocatable :: x(:), y(:), reach(:), field(:, :), u(:), v(:)
    real(real64) :: node(nodes), half
    integer, allocatable :: beside(:)
    integer :: i, j, k, l, n

    node = chebyshev_nodes(nodes)
    allocate (x(nodes**2 * size(clusters)), y(nodes**2 * size(clusters)))
    allocate (reach(size(x)), field(6, size(x)))
    associate (set => coupled%set)
      allocate (u, source=set%x + set%move(1, :))
      allocate (v, source=set%y + set%move(2, :))
      n = 0
      do k = 1, size(clusters)
        associate (o => clusters(k)%outside)
          call reach_of_cluster(pairs, clusters(k)%members, coupled%closing - clusters(k)%lowered, &
                                o%x0, o%x1, o%y0, o%y1)
          half = 0.5_real64 * hypot(o%x1 - o%x0, o%y1 - o%y0)
          ! Members are near all nodes.
          reach(n + 1:n + nodes**2) = half + max(far_off * half, maxval(hypot( &
            pairs%list(clusters(k)%members)%x - o%x0, pairs%list(clusters(k)%members)%y - o%y0)))
          do j = 1, nodes
            do i = 1, nodes
              n = n + 1
              x(n) = 0.5_real64 * (o%x0 + o%x1 + node(i) * (o%x1 - o%x0))
              y(n) = 0.5_real64 * (o%y0 + o%y1 + node(j) * (o%y1 - o%y0))
            end do
          end do
        end associate
      end do
      call plant_tree(tree, [u, x], [v, y], [near_factor * set%circle, reach], 1.0_real64, size(u))
      if (allocated(tree%failure)) then
        failure = tree%failure
        return
      end if
      call sum_sources(tree, set%load / pi, hertz_spread * set%circle**2, field)
      do k = 1, size(clusters)
        n = nodes**2 * (k - 1)
        associate (o => clusters(k)%outside, middle_x => 0.5_real64 * &
                   (clusters(k)%outside%x0 + clusters(k)%outside%x1), middle_y => 0.5_real64 * &
                   (clusters(k)%outside%y0 + clusters(k)%outside%y1))
          half = 0.5_real64 * hypot(o%x1 - o%x0, o%y1 - o%y0)
          if (.not. half > 0.0_real64) cycle
          ! Beside the cluster: cell by cell.
          beside = tree%near(tree%first(n + 1):tree%first(n + 2) - 1)
          beside = pack(beside, of(beside) /= k)
          beside = pack(beside, hypot(u(beside) - middle_x, v(beside) - middle_y) < &
                       far_off * half + set%circle(beside))
          o%x = u(beside)
          o%y = v(beside)
          o%pair = set%number(beside)
          o%circle = set%circle(beside)
          o%load = set%load(beside) * pairs%modulus
          do i = n + 1, n + nodes**2
            do l = tree%first(i), tree%first(i + 1) - 1
              j = tree%near(l)
              if (of(j) == k) cycle
              if (hypot(u(j) - middle_x, v(j) - middle_y) < far_off * half + set%circle(j)) cycle
              field(1, i) = field(1, i) + set%load(j) * &
                            beside_circle(set%circle(j), hypot(x(i) - u(j), y(i) - v(j)))
            end do
          end do
          o%at_nodes = reshape(field(1, n + 1:n + nodes**2), [nodes, nodes])
          ! A lower bound of the field: it changes less between nodes than from node to node.
          clusters(k)%lowered = max(0.0_real64, minval(o%at_nodes) - (maxval(o%at_nodes) - &
            minval(o%at_nodes)) / nodes) + sum(set%load(beside) * &
            beside_circle(set%circle(beside), &
                          hypot(abs(o%x - middle_x) + 0.5_real64 * (o%x1 - o%x0), &
                                abs(o%y - middle_y) + 0.5_real64 * (o%y1 - o%y0))))
        end associate
      end do
    end associate
  end subroutine find_outside

end module asperity_resolved_clusters
