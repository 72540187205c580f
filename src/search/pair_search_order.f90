!> The pairs found, in the order in which they touch, all or the first of them.
!>
!> One pass puts pairs into buckets of equal width in touch; those that hold none of the first
!> `most` are left out before anything is sorted. Then each bucket is sorted for itself, where it
!> stays in the nearest memory.
module asperity_pair_search_order
  use, intrinsic :: iso_c_binding, only: c_loc
  use asperity_cell_grid, only: cell_grid
  use asperity_cell_sort, only: sort_keys
  use asperity_kinds, only: int32, int64, real64
  use asperity_large_pages, only: prefer_large_pages
  use asperity_pair_search_blocks, only: found_pair, found_pairs
  implicit none
  private

  public :: order_by_touch

  ! Pairs a bucket, on average, and the most buckets: each is written to in turn.
  integer, parameter :: bucket_size = 512
  integer, parameter :: most_buckets = 4096

contains

  !> Sorts pairs by the gap to the one that touches first; equal gaps as the solver does, by d, then
  !> s, then combined radius, then the indices. `failed` when there is no memory.
  subroutine order_by_touch(found, upper, lower, most, list, failed)
    type(found_pairs), intent(inout) :: found              !! pairs; on return none
    type(cell_grid), intent(in) :: upper                   !! the upper surface
    type(cell_grid), intent(in) :: lower                   !! the lower surface
    integer, intent(in) :: most                            !! keep so many; huge: all
    !> ascending gap, descending touch
    type(found_pair), allocatable, target, intent(out) :: list(:)
    logical, intent(out) :: failed                         !! no memory, or over 2**31 pairs
    type(found_pair), allocatable :: shorter(:)
    integer, allocatable :: ends(:)
    real(real64) :: first, scale
    integer :: buckets, kept, status

    failed = found%number > int(huge(0_int32) - 1, int64)
    if (failed) return
    if (found%number == 0_int64) then
      allocate (list(0))
      return
    end if
    first = found%first
    buckets = int(min(found%number / bucket_size + 1_int64, int(most_buckets, int64)))
    allocate (ends(buckets))
    scale = 0.0_real64
    if (first - found%last > tiny(first) * most_buckets) &
      scale = real(buckets, real64) / (first - found%last)
    call count_buckets(found, first, scale, most, ends, kept)
    allocate (list(kept), stat=status)
    failed = status /= 0
    if (failed) return
    if (kept > 0) &
      call prefer_large_pages(c_loc(list(1)), size(list, kind=int64) * storage_size(list) / 8)
    call fill_buckets(found, first, scale, ends, list)
    deallocate (found%block)
    found%blocks = 0
    found%number = 0_int64
    call sort_buckets(ends, list)
    call sort_equals(list, first, upper, lower)
    if (kept > most) then
      allocate (shorter(most))
      shorter(:) = list(:most)
      call move_alloc(shorter, list)
    end if
  end subroutine order_by_touch

  ! Which bucket a touch belongs to.
  elemental integer function bucket_of(touch, first, scale, buckets)
    real(real64), intent(in) :: touch, first, scale
    integer, intent(in) :: buckets

    bucket_of = min(int((first - touch) * scale) + 1, buckets)
  end function bucket_of

  ! Where every bucket begins, less one; `kept` pairs are in buckets that hold one of the first
  ! `most`. Buckets after these hold none.
  subroutine count_buckets(found, first, scale, most, ends, kept)
    type(found_pairs), intent(in) :: found
    real(real64), intent(in) :: first, scale
    integer, intent(in) :: most
    integer, allocatable, intent(inout) :: ends(:)
    integer, intent(out) :: kept
    integer :: i, k, b, own

    ends(:) = 0
    do k = 1, found%blocks
      associate (list => found%block(k)%list)
        do i = 1, found%block(k)%used
          b = bucket_of(list(i)%touch, first, scale, size(ends))
          ends(b) = ends(b) + 1
        end do
      end associate
    end do
    kept = 0
    do b = 1, size(ends)
      own = ends(b)
      ends(b) = kept
      if (kept >= most) then
        ends(b) = -1
      else
        kept = kept + own
      end if
    end do
  end subroutine count_buckets

  ! Puts the pairs of the buckets that are kept into the list. `ends`: the last of each bucket.
  subroutine fill_buckets(found, first, scale, ends, list)
    type(found_pairs), intent(in) :: found
    real(real64), intent(in) :: first, scale
    integer, intent(inout) :: ends(:)
    type(found_pair), contiguous, intent(inout) :: list(:)
    integer :: i, k, b

    do k = 1, found%blocks
      associate (from => found%block(k)%list)
        do i = 1, found%block(k)%used
          b = bucket_of(from(i)%touch, first, scale, size(ends))
          if (ends(b) < 0) cycle
          ends(b) = ends(b) + 1
          list(ends(b)) = from(i)
        end do
      end associate
    end do
  end subroutine fill_buckets

  ! Sorts every bucket.
  subroutine sort_buckets(ends, list)
    integer, intent(in) :: ends(:)
    type(found_pair), contiguous, intent(inout) :: list(:)
    type(found_pair), allocatable :: own(:)
    real(real64), allocatable :: key(:), spare_key(:)
    integer(int32), allocatable :: item(:), spare_item(:)
    integer :: b, begin, n, i, largest

    largest = 0
    begin = 0
    do b = 1, size(ends)
      if (ends(b) < 0) exit
      largest = max(largest, ends(b) - begin)
      begin = ends(b)
    end do
    allocate (own(largest), key(largest), item(largest), spare_key(largest), spare_item(largest))
    begin = 0
    do b = 1, size(ends)
      if (ends(b) < 0) exit
      n = ends(b) - begin
      do i = 1, n
        own(i) = list(begin + i)
        key(i) = -own(i)%touch
        item(i) = int(i, int32)
      end do
      call sort_keys(key(:n), item(:n), spare_key, spare_item)
      do i = 1, n
        list(begin + i) = own(item(i))
      end do
      begin = ends(b)
    end do
  end subroutine sort_buckets

  ! Puts runs of equal gaps in order.
  subroutine sort_equals(list, first, upper, lower)
    type(found_pair), contiguous, intent(inout) :: list(:)
    real(real64), intent(in) :: first
    type(cell_grid), intent(in) :: upper, lower
    integer :: i, begin

    begin = 1
    do i = 2, size(list)
      if (first - list(i)%touch > first - list(begin)%touch) then
        if (i - begin > 1) call sort_run(list(begin:i - 1), upper, lower)
        begin = i
      end if
    end do
    if (size(list) - begin > 0) call sort_run(list(begin:), upper, lower)
  end subroutine sort_equals

  ! Sorts pairs of one gap. Merge sort: whole surfaces can be of one height.
  recursive subroutine sort_run(run, upper, lower)
    type(found_pair), contiguous, intent(inout) :: run(:)
    type(cell_grid), intent(in) :: upper, lower
    type(found_pair), allocatable :: left(:)
    integer :: half, i, j, k

    if (size(run) < 2) return
    half = size(run) / 2
    call sort_run(run(:half), upper, lower)
    call sort_run(run(half + 1:), upper, lower)
    allocate (left(half))
    left(:) = run(:half)
    i = 1
    j = half + 1
    do k = 1, size(run)
      if (i > half) exit
      if (j <= size(run)) then
        if (before(run(j), left(i), upper, lower)) then
          run(k) = run(j)
          j = j + 1
          cycle
        end if
      end if
      run(k) = left(i)
      i = i + 1
    end do
  end subroutine sort_run

  ! Whether `a` comes before `b`, of one gap.
  pure logical function before(a, b, upper, lower)
    type(found_pair), intent(in) :: a, b
    type(cell_grid), intent(in) :: upper, lower
    real(real64) :: da, db, sa, sb, ra, rb

    da = sqrt(a%squared)
    db = sqrt(b%squared)
    sa = upper%radius(a%upper) + lower%radius(a%lower)
    sb = upper%radius(b%upper) + lower%radius(b%lower)
    ra = upper%radius(a%upper) * lower%radius(a%lower) / sa
    rb = upper%radius(b%upper) * lower%radius(b%lower) / sb
    if (da < db .or. db < da) then
      before = da < db
    else if (sa < sb .or. sb < sa) then
      before = sa < sb
    else if (ra < rb .or. rb < ra) then
      before = ra < rb
    else if (a%upper /= b%upper) then
      before = a%upper < b%upper
    else
      before = a%lower < b%lower
    end if
  end function before

end module asperity_pair_search_order
