!> Large arrays in large pages, where the system has them: a first use then costs a few page faults
!> in place of thousands, and a search finds its places sooner.
!>
!> It is a wish. A system that knows no such pages, or does not lend them, changes nothing but time.
module asperity_large_pages
  use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t, c_null_ptr, c_ptr, c_size_t
  use asperity_kinds, only: int64
  use asperity_system_calls, only: linux_madvise
  implicit none
  private

  public :: prefer_large_pages

  ! Less is not worth a call. Bytes.
  integer(int64), parameter :: least = 4194304_int64
  ! The system's smallest page, and MADV_HUGEPAGE of Linux.
  integer(c_intptr_t), parameter :: page = 4096_c_intptr_t
  integer(c_int), parameter :: large_pages = 14_c_int

contains

  !> To be called between the allocation of an array and its first use.
  subroutine prefer_large_pages(place, bytes)
    type(c_ptr), intent(in) :: place      !! where the array begins
    integer(int64), intent(in) :: bytes   !! its length
    integer(c_intptr_t) :: first, last
    integer(c_int) :: status

    if (bytes < least) return
    first = transfer(place, first)
    last = first + int(bytes, c_intptr_t)
    ! Whole pages of the array alone.
    first = (first + page - 1_c_intptr_t) / page * page
    last = last / page * page
    status = linux_madvise(transfer(first, c_null_ptr), int(last - first, c_size_t), large_pages)
    ! What the system says changes nothing.
    if (status /= 0) return
  end subroutine prefer_large_pages

end module asperity_large_pages
