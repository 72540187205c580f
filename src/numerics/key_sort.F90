#define ITEM type(keyed)
!> The order of some numbers, in time proportional to their count unless they pile up.
!>
!> Buckets of equal width hold one number or none as a rule; a bucket that holds many is sorted by
!> merging. Equal numbers keep their order.
module asperity_key_sort
  use asperity_kinds, only: int32, real64
  implicit none
  private

  public :: sort_keys

  ! Fewer are not worth buckets; more buckets would not stay in the nearest memory.
  integer, parameter :: few = 12, most_buckets = 65536

  ! A number and its place among those given.
  type :: keyed
    real(real64) :: key
    integer(int32) :: place
  end type keyed

contains

  !> Finds the places of the numbers in ascending order.
  pure subroutine sort_keys(key, order)
    real(real64), contiguous, intent(in) :: key(:)        !! one at least; finite, below 1e300
    integer(int32), contiguous, intent(out) :: order(:)   !! as many: the least is key(order(1))
    type(keyed), allocatable :: list(:)
    type(keyed) :: moving
    integer, allocatable :: ends(:)
    real(real64) :: low, high, scale
    integer :: i, k, b, begin, buckets

    low = key(1)
    high = key(1)
    do i = 2, size(key)
      low = min(low, key(i))
      high = max(high, key(i))
    end do
    buckets = min(size(key), most_buckets)
    if (size(key) <= few .or. .not. high - low > tiny(high) * most_buckets) buckets = 1
    scale = 0.0_real64
    if (buckets > 1) scale = real(buckets, real64) / (high - low)
    allocate (list(size(key)), ends(buckets))
    ends(:) = 0
    do i = 1, size(key)
      b = min(int((key(i) - low) * scale) + 1, buckets)
      ends(b) = ends(b) + 1
    end do
    begin = 0
    do b = 1, buckets
      k = ends(b)
      ends(b) = begin
      begin = begin + k
    end do
    do i = 1, size(key)
      b = min(int((key(i) - low) * scale) + 1, buckets)
      k = ends(b) + 1
      ends(b) = k
      list(k)%key = key(i)
      list(k)%place = int(i, int32)
    end do
    begin = 0
    do b = 1, buckets
      if (ends(b) - begin > few) call merge_sort(list(begin + 1:ends(b)))
      begin = ends(b)
    end do
    ! No number leaves its bucket.
    do i = 2, size(list)
      moving = list(i)
      k = i - 1
      do while (k >= 1)
        if (.not. comes_before(moving, list(k))) exit
        list(k + 1) = list(k)
        k = k - 1
      end do
      list(k + 1) = moving
    end do
    order(:) = list%place
  end subroutine sort_keys

  pure logical function comes_before(a, b)
    type(keyed), intent(in) :: a, b

    comes_before = a%key < b%key
  end function comes_before

#include "merge_sort.inc"

end module asperity_key_sort
