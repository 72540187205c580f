!> The pairs that a search has found, in blocks: nothing is copied when their number grows.
module asperity_pair_search_blocks
  use asperity_kinds, only: int32, int64
  implicit none
  private

  public :: found_pairs
  public :: reserve_room

  ! Number of pairs of a block.
  integer, parameter :: block_size = 65536

  !> A block of pairs.
  type :: pair_block
    integer :: used = 0                      !! number of pairs in the block
    integer(int32), allocatable :: upper(:)  !! indices of the upper asperities, from 1
    integer(int32), allocatable :: lower(:)  !! indices of the lower asperities, from 1
  end type pair_block

  !> All pairs found, in the order of the search, which is the same in every run.
  type :: found_pairs
    integer(int64) :: number = 0_int64         !! pairs in all blocks
    integer :: blocks = 0                      !! blocks in use
    type(pair_block), allocatable :: block(:)  !! the first `blocks` are in use
  end type found_pairs

contains

  !> Adds a block when the last one has too little room.
  subroutine reserve_room(found, needed, failed)
    type(found_pairs), intent(inout) :: found  !! pairs so far
    integer, intent(in) :: needed              !! number of pairs to be added, 65536 at most
    logical, intent(out) :: failed             !! whether memory is short
    type(pair_block), allocatable :: larger(:)
    integer :: i, status

    failed = .false.
    if (found%blocks > 0) then
      if (found%block(found%blocks)%used + needed <= block_size) return
    end if
    if (.not. allocated(found%block)) allocate (found%block(64))
    if (found%blocks == size(found%block)) then
      allocate (larger(2 * found%blocks))
      do i = 1, found%blocks
        larger(i)%used = found%block(i)%used
        call move_alloc(found%block(i)%upper, larger(i)%upper)
        call move_alloc(found%block(i)%lower, larger(i)%lower)
      end do
      call move_alloc(larger, found%block)
    end if
    associate (next => found%block(found%blocks + 1))
      allocate (next%upper(block_size), stat=status)
      failed = status /= 0
      if (failed) return
      allocate (next%lower(block_size), stat=status)
    end associate
    failed = status /= 0
    if (.not. failed) found%blocks = found%blocks + 1
  end subroutine reserve_room

end module asperity_pair_search_blocks
