!> Sorting of numbers with an item each, in time proportional to their count unless they pile up.
!>
!> Buckets of equal width hold one number or none, so that an insertion sort has next to nothing
!> left to do. A bucket that holds many is sorted the same way again, and by merging when that does
!> not part its numbers. Equal numbers keep their order.
module asperity_cell_sort
  use asperity_kinds, only: int32, real64
  implicit none
  private

  public :: sort_keys

  ! A bucket with more is sorted again; fewer are inserted one by one.
  integer, parameter :: few = 24
  integer, parameter :: most_buckets = 2048
  ! Buckets inside buckets, after which numbers are merged.
  integer, parameter :: deepest = 4

contains

  !> Sorts keys in ascending order, their items with them.
  recursive subroutine sort_keys(key, item, spare_key, spare_item, depth)
    real(real64), contiguous, intent(inout) :: key(:)        !! finite, below 1e300
    integer(int32), contiguous, intent(inout) :: item(:)     !! as many
    real(real64), contiguous, intent(inout) :: spare_key(:)  !! room for as many at least
    integer(int32), contiguous, intent(inout) :: spare_item(:)  !! room for as many at least
    integer, intent(in), optional :: depth                   !! for its own calls only
    integer :: begin(0:most_buckets)
    real(real64) :: low, high, scale
    integer :: n, buckets, i, j, b, level, largest, kept

    n = size(key)
    if (n <= few) then
      call insert_all(key, item)
      return
    end if
    level = 0
    if (present(depth)) level = depth
    low = key(1)
    high = key(1)
    do i = 2, n
      low = min(low, key(i))
      high = max(high, key(i))
    end do
    if (.not. high > low) return
    buckets = min(2 * n, most_buckets)
    if (level == deepest .or. high - low < tiny(high) * most_buckets) then
      call merge_halves(key, item, spare_key, spare_item)
      return
    end if
    scale = real(buckets, real64) / (high - low)

    begin(:buckets) = 0
    do i = 1, n
      b = min(int((key(i) - low) * scale), buckets - 1)
      begin(b) = begin(b) + 1
    end do
    largest = 0
    kept = 0
    do b = 0, buckets - 1
      j = begin(b)
      largest = max(largest, j)
      begin(b) = kept
      kept = kept + j
    end do
    do i = 1, n
      b = min(int((key(i) - low) * scale), buckets - 1)
      j = begin(b) + 1
      begin(b) = j
      spare_key(j) = key(i)
      spare_item(j) = item(i)
    end do
    key(:) = spare_key(:n)
    item(:) = spare_item(:n)
    if (largest > few) then
      i = 0
      do b = 0, buckets - 1
        j = begin(b)
        if (j - i > few) call sort_keys(key(i + 1:j), item(i + 1:j), spare_key(i + 1:j), &
                                        spare_item(i + 1:j), level + 1)
        i = j
      end do
    end if
    call insert_all(key, item)
  end subroutine sort_keys

  ! Insertion sort in place. What is less than all before goes to the front by itself, so that the
  ! inner loop needs no end.
  pure subroutine insert_all(key, item)
    real(real64), contiguous, intent(inout) :: key(:)
    integer(int32), contiguous, intent(inout) :: item(:)
    real(real64) :: moving
    integer(int32) :: moving_item
    integer :: i, j

    do i = 2, size(key)
      moving = key(i)
      if (.not. key(i - 1) > moving) cycle
      moving_item = item(i)
      j = i - 1
      if (moving < key(1)) then
        key(2:i) = key(:j)
        item(2:i) = item(:j)
        j = 0
      else
        do
          if (.not. key(j) > moving) exit
          key(j + 1) = key(j)
          item(j + 1) = item(j)
          j = j - 1
        end do
      end if
      key(j + 1) = moving
      item(j + 1) = moving_item
    end do
  end subroutine insert_all

  ! Merge sort.
  recursive subroutine merge_halves(key, item, spare_key, spare_item)
    real(real64), contiguous, intent(inout) :: key(:)
    integer(int32), contiguous, intent(inout) :: item(:)
    real(real64), contiguous, intent(inout) :: spare_key(:)
    integer(int32), contiguous, intent(inout) :: spare_item(:)
    integer :: n, half, i, j, k

    n = size(key)
    if (n <= few) then
      call insert_all(key, item)
      return
    end if
    half = n / 2
    call merge_halves(key(:half), item(:half), spare_key, spare_item)
    call merge_halves(key(half + 1:), item(half + 1:), spare_key, spare_item)
    spare_key(:half) = key(:half)
    spare_item(:half) = item(:half)
    i = 1
    j = half + 1
    do k = 1, n
      if (i > half) exit
      if (j <= n) then
        if (spare_key(i) > key(j)) then
          key(k) = key(j)
          item(k) = item(j)
          j = j + 1
          cycle
        end if
      end if
      key(k) = spare_key(i)
      item(k) = spare_item(i)
      i = i + 1
    end do
  end subroutine merge_halves

end module asperity_cell_sort
