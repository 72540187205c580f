!> Clusters of contacts whose circles overlap: the cost follows the contacts and the overlaps.
module asperity_contact_clusters
  use asperity_kinds, only: real64
  use asperity_overlapping_circles, only: circles_overlap, find_near_circles
  use asperity_pair_search_blocks, only: found_pairs
  implicit none
  private

  public :: cluster_of_each

contains

  !> The cluster of every contact, from 1 in the order of their first contacts; 0 for a contact
  !> whose circle overlaps no other. Circles that overlap directly or through others are one.
  subroutine cluster_of_each(x, y, radius, cluster, clusters)
    real(real64), intent(in) :: x(:), y(:)   !! centres
    real(real64), intent(in) :: radius(:)    !! of the contact circles, 0 or more
    integer, intent(out) :: cluster(:)       !! of every contact
    integer, intent(out) :: clusters         !! their number
    type(found_pairs) :: near
    integer, allocatable :: parent(:), members(:)
    logical :: each_with_each
    integer :: i, j, k

    allocate (parent(size(x)), members(size(x)))
    parent(:) = [(i, i=1, size(x))]
    call find_near_circles(x, y, radius, near, each_with_each)
    do k = 1, near%blocks
      do i = 1, near%block(k)%used
        call join_if_overlapping(near%block(k)%upper(i), near%block(k)%lower(i))
      end do
    end do
    if (each_with_each) then
      do i = 2, size(x)
        do j = 1, i - 1
          call join_if_overlapping(i, j)
        end do
      end do
    end if
    members(:) = 0
    do i = 1, size(x)
      j = root_of(i)
      members(j) = members(j) + 1
    end do
    cluster(:) = 0
    clusters = 0
    ! A root is the first of its contacts.
    do i = 1, size(x)
      j = root_of(i)
      if (members(j) < 2) cycle
      if (j == i) then
        clusters = clusters + 1
        cluster(i) = clusters
      else
        cluster(i) = cluster(j)
      end if
    end do

  contains

    subroutine join_if_overlapping(one, other)
      integer, intent(in) :: one, other
      integer :: first, second

      if (.not. circles_overlap(x(one) - x(other), y(one) - y(other), radius(one), &
                                radius(other))) return
      first = root_of(one)
      second = root_of(other)
      parent(max(first, second)) = min(first, second)
    end subroutine join_if_overlapping

    ! The first contact of the cluster of one. The way there is halved, so that the next is short.
    integer function root_of(contact)
      integer, intent(in) :: contact

      root_of = contact
      do while (parent(root_of) /= root_of)
        parent(root_of) = parent(parent(root_of))
        root_of = parent(root_of)
      end do
    end function root_of

  end subroutine cluster_of_each

end module asperity_contact_clusters
