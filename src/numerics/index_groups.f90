!> Groups of members that are connected by pairs.
module asperity_index_groups
  implicit none
  private

  public :: gather_groups

contains

  !> Lists members in the order of their groups; groups are in the order of their first members.
  subroutine gather_groups(one, other, joins, counts, most, member, first)
    integer, intent(in) :: one(:), other(:)         !! members of each pair
    logical, intent(in) :: joins(:)                 !! whether a pair connects them
    logical, intent(in) :: counts(:)                !! whether a member is listed
    integer, intent(in) :: most                     !! largest number of members of a group
    integer, allocatable, intent(out) :: member(:)  !! members of all groups
    integer, allocatable, intent(out) :: first(:)  !! index of the first of each group; then the end
    integer :: root(size(counts)), members_of(size(counts)), a, b, i, k

    root = [(i, i=1, size(root))]
    members_of = 1
    do k = 1, size(one)
      if (.not. joins(k)) cycle
      a = root_of(one(k))
      b = root_of(other(k))
      if (a == b .or. members_of(a) + members_of(b) > most) cycle
      root(max(a, b)) = min(a, b)
      members_of(min(a, b)) = members_of(a) + members_of(b)
    end do
    members_of = 0
    do i = 1, size(root)
      root(i) = root_of(i)
      if (counts(i)) members_of(root(i)) = members_of(root(i)) + 1
    end do
    allocate (first(count(members_of > 0) + 1), member(count(counts)))
    first(1) = 1
    k = 1
    do i = 1, size(members_of)
      if (members_of(i) == 0) cycle
      first(k + 1) = first(k) + members_of(i)
      members_of(i) = first(k)
      k = k + 1
    end do
    do i = 1, size(root)
      if (.not. counts(i)) cycle
      member(members_of(root(i))) = i
      members_of(root(i)) = members_of(root(i)) + 1
    end do

  contains

    integer function root_of(a)
      integer, intent(in) :: a

      root_of = a
      do while (root(root_of) /= root_of)
        root(root_of) = root(root(root_of))
        root_of = root(root_of)
      end do
    end function root_of

  end subroutine gather_groups

end module asperity_index_groups
