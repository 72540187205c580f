!> Groups of things that pairs connect.
module asperity_index_groups
  implicit none
  private

  public :: gather_groups

contains

  !> Those that count, in the order of their groups; a group goes by its first member.
  subroutine gather_groups(one, other, joins, counts, most, member, first)
    integer, intent(in) :: one(:), other(:)         !! members of pairs
    logical, intent(in) :: joins(:)                 !! whether a pair connects them
    logical, intent(in) :: counts(:)                !! who is in a group at all
    integer, intent(in) :: most                     !! members of a group
    integer, allocatable, intent(out) :: member(:)  !! of all groups
    integer, allocatable, intent(out) :: first(:)   !! where each begins, and one more
    integer :: root(size(counts)), many(size(counts)), a, b, i, k

    root = [(i, i=1, size(root))]
    many = 1
    do k = 1, size(one)
      if (.not. joins(k)) cycle
      a = root_of(one(k))
      b = root_of(other(k))
      if (a == b .or. many(a) + many(b) > most) cycle
      root(max(a, b)) = min(a, b)
      many(min(a, b)) = many(a) + many(b)
    end do
    many = 0
    do i = 1, size(root)
      root(i) = root_of(i)
      if (counts(i)) many(root(i)) = many(root(i)) + 1
    end do
    allocate (first(count(many > 0) + 1), member(count(counts)))
    first(1) = 1
    k = 1
    do i = 1, size(many)
      if (many(i) == 0) cycle
      first(k + 1) = first(k) + many(i)
      many(i) = first(k)
      k = k + 1
    end do
    do i = 1, size(root)
      if (.not. counts(i)) cycle
      member(many(root(i))) = i
      many(root(i)) = many(root(i)) + 1
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
