!> Clusters of contacts whose circles overlap.
module asperity_contact_clusters
  use asperity_kinds, only: real64
  use asperity_overlapping_circles, only: circles_overlap
  implicit none
  private

  public :: cluster_of_each

contains

  !> The cluster of every contact, from 1 in the order of their first contacts; 0 for a contact
  !> whose circle overlaps no other. Circles that overlap directly or through others are one.
  pure subroutine cluster_of_each(x, y, radius, cluster, clusters)
    real(real64), intent(in) :: x(:), y(:)   !! centres
    real(real64), intent(in) :: radius(:)    !! of the contact circles, 0 or more
    integer, intent(out) :: cluster(:)       !! of every contact
    integer, intent(out) :: clusters         !! their number
    integer :: parent(size(x)), members(size(x)), first, i, j

    parent = [(i, i=1, size(x))]
    do i = 2, size(x)
      do j = 1, i - 1
        if (.not. circles_overlap(x(i) - x(j), y(i) - y(j), radius(i), radius(j))) cycle
        first = min(root_of(i, parent), root_of(j, parent))
        parent(max(root_of(i, parent), root_of(j, parent))) = first
      end do
    end do
    members = 0
    do i = 1, size(x)
      j = root_of(i, parent)
      members(j) = members(j) + 1
    end do
    cluster = 0
    clusters = 0
    ! A root is the first of its contacts.
    do i = 1, size(x)
      j = root_of(i, parent)
      if (members(j) < 2) cycle
      if (j == i) then
        clusters = clusters + 1
        cluster(i) = clusters
      else
        cluster(i) = cluster(j)
      end if
    end do
  end subroutine cluster_of_each

  ! The first contact of the cluster of one.
  pure integer function root_of(contact, parent)
    integer, intent(in) :: contact, parent(:)

    root_of = contact
    do while (parent(root_of) /= root_of)
      root_of = parent(root_of)
    end do
  end function root_of

end module asperity_contact_clusters
