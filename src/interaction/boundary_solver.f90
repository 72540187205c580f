!> Interaction of contacts solved on cells: the truth that cheaper ways are measured against.
!>
!> The two bodies are one half-space of the combined modulus under a rigid surface, the sum of both
!> profiles; the gap is vertical, also where a pair is inclined. Pressures are found on square
!> cells around the contacts, the cells halved until the total load settles. There are no periodic
!> images and no end of the half-space. The load is that of the finest cells; it is not
!> extrapolated, since the cells' edges make its error uneven.
module asperity_boundary_solver
  use asperity_boundary_far, only: far_memory
  use asperity_boundary_gap, only: gap_shape, shape_of_gap
  use asperity_boundary_iteration, only: relax
  use asperity_boundary_patches, only: expected_cells, form_clusters, patch
  use asperity_boundary_products, only: expected_work, half_space, prepare_half_space
  use asperity_boundary_start, only: refine_forces, start_forces
  use asperity_contact_pairs, only: contact_pairs
  use asperity_kinds, only: real64
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: boundary_outcome, solve_boundary

  !> Cells per radius of a cluster's largest contact, before any halving. For a pair without slope
  !> the load is then right within 5e-4, on halved cells within 1.5e-4, on quartered within 4e-5.
  real(real64), parameter :: coarse_cells = 6.0_real64

  !> Doubles that may be held: 2 GiB.
  real(real64), parameter :: doubles_allowed = 2.0_real64**28

  !> Multiplications allowed for one displacement of all cells.
  real(real64), parameter :: work_allowed = 2.0e9_real64

  !> Doubles held for every cell.
  real(real64), parameter :: doubles_per_cell = 10.0_real64

  !> A penetration below this, over the radius, is not solved: its squares leave the range.
  real(real64), parameter :: shallowest = 1.0e-60_real64

  !> What the cells answer. Loads, lengths and pressures in the units of the pairs.
  type :: boundary_outcome
    real(real64), allocatable :: vertical_load(:)     !! of every pair, all contacts together
    real(real64), allocatable :: alone_load(:)        !! of every pair alone, on the same cells
    real(real64), allocatable :: area(:)              !! of the cells under pressure
    real(real64), allocatable :: maximum_pressure(:)  !! mean over a cell
    real(real64) :: total = 0.0_real64                !! sum of vertical_load
    real(real64) :: alone_total = 0.0_real64          !! sum of alone_load
    integer :: cells = 0                              !! on which pressure could be
    integer :: halvings = 0                           !! of the cells, from the coarsest
    real(real64) :: change = huge(1.0_real64)         !! relative, of total by the last halving
    !> converged: every solve was, and the change is within the tolerance; residual: largest
    !> violation of the gap over the penetration
    type(solve_ending) :: ending
    character(:), allocatable :: failure              !! why it did not converge
  end type boundary_outcome

contains

  !> Loads of contacts that act on each other, at given penetrations.
  !>
  !> Pairs that touch at the same place share one contact: its load is told under the pair that
  !> comes first in the list.
  subroutine solve_boundary(pairs, penetration, tolerance, with_alone, outcome, estimated_loads)
    type(contact_pairs), intent(in) :: pairs          !! who may touch
    !> vertical, past first touch, of every pair, less than its zc; 0 or less: does not touch
    real(real64), intent(in) :: penetration(:)
    real(real64), intent(in) :: tolerance             !! relative change by the last halving
    logical, intent(in) :: with_alone                 !! find alone_load too
    type(boundary_outcome), intent(out) :: outcome    !! the answer
    !> vertical loads to start from, of every pair; without them from each contact alone
    real(real64), intent(in), optional :: estimated_loads(:)
    type(gap_shape), allocatable :: shapes(:)
    type(patch), allocatable :: lattices(:)

    allocate (outcome%vertical_load(size(penetration)), outcome%area(size(penetration)), &
              outcome%maximum_pressure(size(penetration)))
    outcome%vertical_load = 0.0_real64
    outcome%area = 0.0_real64
    outcome%maximum_pressure = 0.0_real64
    if (with_alone) then
      allocate (outcome%alone_load(size(penetration)))
      outcome%alone_load = 0.0_real64
    end if
    call find_shapes(pairs, penetration, shapes, outcome%failure)
    if (allocated(outcome%failure)) return
    if (size(shapes) == 0) then
      outcome%change = 0.0_real64
      outcome%ending = solve_ending(.true., 0.0_real64, 0)
      return
    end if
    call form_clusters(shapes, coarse_cells, lattices)
    call halve_until_settled(pairs%modulus, lattices, tolerance, outcome, estimated_loads)
    if (with_alone .and. outcome%cells > 0) &
      call solve_alone(pairs%modulus, lattices, tolerance, outcome)
  end subroutine solve_boundary

  ! The contacts: pairs whose penetration is more than 0.
  subroutine find_shapes(pairs, penetration, shapes, failure)
    type(contact_pairs), intent(in) :: pairs
    real(real64), intent(in) :: penetration(:)
    type(gap_shape), allocatable, intent(out) :: shapes(:)
    character(:), allocatable, intent(out) :: failure
    integer :: i, n

    allocate (shapes(count(penetration > 0.0_real64)))
    n = 0
    do i = 1, size(penetration)
      if (.not. penetration(i) > 0.0_real64) cycle
      n = n + 1
      shapes(n) = shape_of_gap(pairs%list(i), i, penetration(i))
      if (.not. penetration(i) < pairs%list(i)%zc) &
        failure = 'a penetration reaches the level of the centres'
    end do
    if (n == 0) return
    if (.not. maxval(shapes%penetration / shapes%curvature_radius) > shallowest) &
      failure = 'contacts too shallow for cells'
  end subroutine find_shapes

  subroutine halve_until_settled(modulus, lattices, tolerance, outcome, estimated_loads)
    real(real64), intent(in) :: modulus, tolerance
    type(patch), intent(in) :: lattices(:)
    type(boundary_outcome), intent(inout) :: outcome
    real(real64), intent(in), optional :: estimated_loads(:)
    type(half_space) :: space, finer
    real(real64), allocatable :: force(:), finer_force(:)
    real(real64) :: before
    integer :: halvings

    halvings = 0
    do
      call check_size(lattices, halvings, outcome%failure)
      if (allocated(outcome%failure)) exit
      call prepare_half_space(lattices, halvings, finer)
      if (halvings == 0) then
        call start_forces(finer%cells, modulus, finer_force, estimated_loads)
      else
        call refine_forces(space%cells, force, finer%cells, finer_force)
      end if
      call relax(finer, inner_tolerance(tolerance), finer_force, outcome%ending)
      space = finer
      call move_alloc(finer_force, force)
      before = outcome%total
      call tell_loads(modulus, space, force, outcome)
      outcome%halvings = halvings
      if (halvings > 0 .and. outcome%total > 0.0_real64) &
        outcome%change = abs(outcome%total - before) / outcome%total
      if (.not. outcome%ending%converged) then
        outcome%failure = 'the pressures on the cells did not converge'
        exit
      end if
      if (outcome%change <= tolerance .and. expected_error(halvings) <= tolerance) exit
      halvings = halvings + 1
    end do
    if (allocated(outcome%failure)) outcome%ending%converged = .false.
  end subroutine halve_until_settled

  ! What the cells may be off in the load: 5e-4 at 6 cells per radius, 1e-4 at 12, 3e-5 at 24 for
  ! a contact of Hertz. A small change alone may be luck.
  pure real(real64) function expected_error(halvings)
    integer, intent(in) :: halvings

    expected_error = 0.0144_real64 / (coarse_cells * 2.0_real64**halvings)**2
  end function expected_error

  ! The cells' equations are solved far better than the cells are fine.
  pure function inner_tolerance(tolerance) result(inner)
    real(real64), intent(in) :: tolerance
    real(real64) :: inner

    inner = min(1.0e-6_real64, max(1.0e-10_real64, 1.0e-3_real64 * tolerance))
  end function inner_tolerance

  subroutine check_size(lattices, halvings, failure)
    type(patch), intent(in) :: lattices(:)
    integer, intent(in) :: halvings
    character(:), allocatable, intent(inout) :: failure

    if (doubles_per_cell * expected_cells(lattices, halvings) + far_memory(lattices) > &
        doubles_allowed) then
      failure = 'cells fine enough would need more than 2 GiB of memory'
    else if (expected_work(lattices, halvings) > work_allowed) then
      failure = 'cells fine enough would be too many to solve in minutes'
    end if
  end subroutine check_size

  subroutine tell_loads(modulus, space, force, outcome)
    real(real64), intent(in) :: modulus
    type(half_space), intent(in) :: space
    real(real64), intent(in) :: force(:)
    type(boundary_outcome), intent(inout) :: outcome
    integer :: i

    do i = 1, size(space%cells%patches)
      associate (p => space%cells%patches(i))
        associate (f => force(p%before + 1:p%before + p%columns * p%rows))
          outcome%vertical_load(p%shape%pair) = modulus * sum(f)
          outcome%area(p%shape%pair) = p%cell**2 * count(f > 0.0_real64)
          outcome%maximum_pressure(p%shape%pair) = 0.0_real64
          if (size(f) > 0) &
            outcome%maximum_pressure(p%shape%pair) = modulus * (maxval(f) / p%cell**2)
        end associate
      end associate
    end do
    outcome%total = sum(outcome%vertical_load)
    outcome%cells = sum(max(0, space%cells%last - space%cells%first + 1))
  end subroutine tell_loads

  ! Every contact by itself, on the finest lattice of its cluster.
  subroutine solve_alone(modulus, lattices, tolerance, outcome)
    real(real64), intent(in) :: modulus, tolerance
    type(patch), intent(in) :: lattices(:)
    type(boundary_outcome), intent(inout) :: outcome
    type(half_space) :: space
    real(real64), allocatable :: force(:)
    type(solve_ending) :: ending
    integer :: i

    do i = 1, size(lattices)
      call prepare_half_space(lattices(i:i), outcome%halvings, space)
      call start_forces(space%cells, modulus, force)
      call relax(space, inner_tolerance(tolerance), force, ending)
      outcome%alone_load(lattices(i)%shape%pair) = modulus * sum(force)
      if (ending%converged) cycle
      outcome%ending%converged = .false.
      outcome%failure = 'the pressures on the cells of a contact alone did not converge'
    end do
    outcome%alone_total = sum(outcome%alone_load)
  end subroutine solve_alone

end module asperity_boundary_solver
