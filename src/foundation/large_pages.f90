!> Large pages for large arrays.
!>
!> The system hands memory out when it is first written, by pages of 4 KiB, at a microsecond each:
!> more than the work on it takes. Pages of 2 MiB cost a tenth of that by the byte.
module asperity_large_pages
  use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t, c_null_ptr, c_ptr, c_size_t
  use asperity_kinds, only: int64
  use asperity_system_calls, only: posix_madvise
  implicit none
  private

  public :: ask_for_large_pages, bounds_for_large_pages

  ! Bytes of a large page. To get one takes as long as to get 26 to 56 small ones, 220 KiB: an array
  ! of more than twice that is worth one, though it does not fill it.
  integer(int64), parameter :: large = 2097152_int64, least = large / 4

contains

  !> The bounds with which to allocate an array whose items 1 to `items` shall lie in large pages.
  !> Linux places memory of so many whole pages at the begin of one; the C library writes into the
  !> first before it can be asked for, so that none is used. What is never written takes no memory.
  pure subroutine bounds_for_large_pages(items, bytes, first, last)
    integer, intent(in) :: items   !! wanted
    integer, intent(in) :: bytes   !! of each
    integer, intent(out) :: first  !! 1 where large pages are not worth it, or less
    integer, intent(out) :: last   !! `items` at least
    ! What the C library keeps before an array, at most.
    integer(int64), parameter :: head = 64_int64
    integer(int64) :: pages, more

    first = 1
    last = items
    pages = (int(items, int64) * bytes + head + large - 1) / large
    more = (pages * large - head) / bytes
    if (int(items, int64) * bytes < least .or. more > huge(items)) return
    first = 1 - int((large + bytes - 1) / bytes)
    last = int(more)
  end subroutine bounds_for_large_pages

  !> Asks for large pages where an array lies that is not yet written. A system without them refuses
  !> and nothing changes.
  subroutine ask_for_large_pages(array, bytes)
    type(c_ptr), intent(in) :: array        !! its item 1
    integer(int64), intent(in) :: bytes     !! from there on
    integer(c_intptr_t), parameter :: page = 4096_c_intptr_t
    integer(c_int), parameter :: advice = 14_c_int
    integer(c_intptr_t) :: from, to
    integer(c_int) :: status

    if (bytes < least) return
    from = transfer(array, from)
    to = from + int(bytes, c_intptr_t)
    from = from - modulo(from, page)
    to = to + modulo(-to, page)
    status = posix_madvise(transfer(from, c_null_ptr), int(to - from, c_size_t), advice)
  end subroutine ask_for_large_pages

end module asperity_large_pages
