#define ITEM type(keyed)
!> The order of numbers, in time proportional to their number unless they are concentrated.
!>
!> Buckets of equal width have one number each on average; a bucket with many numbers is sorted by
!> merging. Equal numbers keep their order.
module asperity_key_sort
  use asperity_kinds, only: int32, real64
  implicit none
  private

  public :: sort_keys

  ! Largest number that is sorted without buckets; largest number of buckets, which fit in the
  ! cache.
  integer, parameter :: few = 12, most_buckets = 65536

  ! A number and its place in the input.
  type :: keyed
    real(real64) :: key
    integer(int32) :: place
  end type keyed

contains

  !> Finds the order of numbers, ascending.
  pure subroutine sort_keys(key, order)
    real(real64), contiguous, intent(in) :: key(:)  !! numbers, at least one; finite, below 1e300
    integer(int32), contiguous, intent(out) :: order(:)   !! indices: the least is key(order(1))
    type(keyed), allocatable :: list(:)
    integer, allocatable :: ends(:)
    real(real64) :: low, high, buckets_per_length
    integer :: i, k, b, begin, buckets

    low = key(1)
    high = key(1)
    do i = 2, size(key)
      low = min(low, key(i))
      high = max(high, key(i))
    end do
    buckets = min(size(key), most_buckets)
    if (size(key) <= few .or. .not. high - low > tiny(high) * most_buckets) buckets = 1
    buckets_per_length = 0.0_real64
    if (buckets > 1) buckets_per_length = real(buckets, real64) / (high - low)
    allocate (list(size(key)), ends(buckets))
    ends(:) = 0
    do i = 1, size(key)
      b = min(int((key(i) - low) * buckets_per_length) + 1, buckets)
      ends(b) = ends(b) + 1
    end do
    begin = 0
    do b = 1, buckets
      k = ends(b)
      ends(b) = begin
      begin = begin + k
    end do
    do i = 1, size(key)
      b = min(int((key(i) - low) * buckets_per_length) + 1, buckets)
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
    call insertion_sort(list)
    order(:) = list%place
  end subroutine sort_keys

  pure logical function comes_before(a, b)
    type(keyed), intent(in) :: a, b

    comes_before = a%key < b%key
  end function comes_before

#include "merge_sort.inc"

end module asperity_key_sort
