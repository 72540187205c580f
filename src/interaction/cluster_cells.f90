!> Coupled contacts whose circles overlap, solved on cells, a cluster at a time.
!>
!> No displacement between two contacts is exact where their circles overlap. So the loads of such a
!> cluster become those of its law times the factor of the cells, load together over load alone, at
!> the penetrations that the contacts outside leave. The load alone is that of the law, so that the
!> inclination counts as it does elsewhere.
module asperity_cluster_cells
  use asperity_boundary_solver, only: boundary_outcome, solve_boundary
  use asperity_contact_clusters, only: cluster_of_each
  use asperity_contact_law, only: contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: contact_state
  use asperity_kinds, only: real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms
  implicit none
  private

  public :: solve_clusters, lowered_for

contains

  !> Solves every cluster of a state. Without overlap the state stays as it is.
  subroutine solve_clusters(pairs, tolerance, state, clusters, cells, residual, failure)
    type(contact_pairs), intent(in) :: pairs       !! the position
    real(real64), intent(in) :: tolerance          !! relative change by the last halving of cells
    type(contact_state), intent(inout) :: state    !! coupled; gets the loads of cells
    integer, intent(out) :: clusters               !! how many there are
    integer, intent(out) :: cells                  !! of all clusters
    real(real64), intent(out) :: residual          !! the largest of their solves
    character(len=:), allocatable, intent(inout) :: failure  !! why one could not be solved
    integer :: cluster(size(pairs%list)), c, i
    type(boundary_outcome) :: solved

    cells = 0
    residual = 0.0_real64
    call cluster_of_each(pairs%list%x, pairs%list%y, state%answers%contact_radius, cluster, &
                         clusters)
    do c = 1, clusters
      call solve_one(pairs, pack([(i, i=1, size(cluster))], cluster == c), tolerance, state, solved)
      residual = max(residual, solved%ending%residual)
      cells = cells + solved%cells
      if (.not. allocated(solved%failure)) cycle
      failure = solved%failure
      return
    end do
  end subroutine solve_clusters

  ! The contacts of one cluster.
  subroutine solve_one(pairs, members, tolerance, state, cells)
    type(contact_pairs), intent(in) :: pairs
    integer, intent(in) :: members(:)
    real(real64), intent(in) :: tolerance
    type(contact_state), intent(inout) :: state
    type(boundary_outcome), intent(out) :: cells
    type(contact_pairs) :: own
    type(contact_response) :: free
    real(real64) :: penetration(size(members)), share
    logical :: is_outside(size(pairs%list))
    integer :: i, k

    own%modulus = pairs%modulus
    own%modulus_power = pairs%modulus_power
    own%length_power = pairs%length_power
    own%list = pairs%list(members)
    is_outside = .true.
    is_outside(members) = .false.
    do k = 1, size(members)
      penetration(k) = state%closing - own%list(k)%gap
      do i = 1, size(pairs%list)
        if (is_outside(i)) penetration(k) = penetration(k) - displacement(members(k), i)
      end do
    end do
    call solve_boundary(own, penetration, tolerance, .true., cells)
    if (allocated(cells%failure)) return
    do k = 1, size(members)
      i = members(k)
      call state%law%respond(pairs%list(i), i, penetration(k), free)
      share = 0.0_real64
      if (cells%alone_load(k) > 0.0_real64) share = cells%vertical_load(k) / cells%alone_load(k)
      state%penetration(i) = lowered_for(share, penetration(k))
      call state%law%respond(pairs%list(i), i, state%penetration(i), state%answers(i))
      state%answers(i)%load = free%load * share
      state%answers(i)%vertical_load = free%vertical_load * share
    end do

  contains

    ! Displacement of contact `at` by contact `by`.
    real(real64) function displacement(at, by)
      integer, intent(in) :: at, by
      type(mutual_terms) :: terms

      displacement = 0.0_real64
      if (.not. state%answers(by)%vertical_load > 0.0_real64) return
      call mutual_displacement( &
        hypot(pairs%list(at)%x - pairs%list(by)%x, pairs%list(at)%y - pairs%list(by)%y), &
        state%answers(at)%contact_radius, state%answers(by)%contact_radius, terms)
      displacement = terms%on_first * state%answers(by)%vertical_load / pairs%modulus
    end function displacement

  end subroutine solve_one

  !> The penetration at which a contact has a share of its load: as far as neighbours would have to
  !> lower it for that. Not positive without load.
  pure real(real64) function lowered_for(share, penetration)
    real(real64), intent(in) :: share        !! of the load, 0 or more
    real(real64), intent(in) :: penetration  !! with the whole load

    lowered_for = -tiny(share)
    if (share > 0.0_real64) lowered_for = penetration * share**(2.0_real64 / 3.0_real64)
  end function lowered_for

end module asperity_cluster_cells
