!> The pairs found, in the order of a search that compares all with all.
module asperity_pair_search_index
  use asperity_kinds, only: int32, int64
  use asperity_pair_search_blocks, only: found_pairs
  implicit none
  private

  public :: order_by_index

contains

  !> Sorts pairs by upper, then by lower index: the order of a search that compares all with all.
  subroutine order_by_index(found, uppers, upper, lower, failed)
    type(found_pairs), intent(inout) :: found                !! pairs; on return none
    integer, intent(in) :: uppers                            !! asperities of the upper surface
    integer(int32), allocatable, intent(out) :: upper(:)     !! ascending
    integer(int32), allocatable, intent(out) :: lower(:)     !! as many, ascending for one upper
    logical, intent(out) :: failed                           !! no memory, or over 2**31 pairs
    integer, allocatable :: ends(:)
    integer :: i, j, k, n, own, status

    failed = found%number > int(huge(0_int32) - 1, int64)
    if (failed) return
    n = int(found%number)
    allocate (upper(n), stat=status)
    if (status == 0) allocate (lower(n), stat=status)
    if (status == 0) allocate (ends(0:uppers), stat=status)
    failed = status /= 0
    if (failed) return
    ends(:) = 0
    do k = 1, found%blocks
      do i = 1, found%block(k)%used
        j = found%block(k)%list(i)%upper
        ends(j) = ends(j) + 1
      end do
    end do
    n = 0
    do j = 1, uppers
      own = ends(j)
      upper(n + 1:n + own) = int(j, int32)
      ends(j) = n
      n = n + own
    end do
    do k = 1, found%blocks
      do i = 1, found%block(k)%used
        j = found%block(k)%list(i)%upper
        ends(j) = ends(j) + 1
        lower(ends(j)) = found%block(k)%list(i)%lower
      end do
    end do
    if (allocated(found%block)) deallocate (found%block)
    found%blocks = 0
    found%number = 0_int64
    do j = 1, uppers
      call sort_indices(lower(ends(j - 1) + 1:ends(j)))
    end do
  end subroutine order_by_index

  ! Heap sort would be out of place for a few, insertion for many: shell sort serves both.
  pure subroutine sort_indices(list)
    integer(int32), contiguous, intent(inout) :: list(:)
    integer(int32) :: moving
    integer :: gap, i, j

    gap = 1
    do while (gap < size(list) / 3)
      gap = 3 * gap + 1
    end do
    do while (gap >= 1)
      do i = gap + 1, size(list)
        moving = list(i)
        j = i - gap
        do while (j >= 1)
          if (list(j) <= moving) exit
          list(j + gap) = list(j)
          j = j - gap
        end do
        list(j + gap) = moving
      end do
      gap = gap / 3
    end do
  end subroutine sort_indices

end module asperity_pair_search_index
