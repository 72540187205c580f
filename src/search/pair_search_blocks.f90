!> The pairs that a search has found, in blocks: nothing is copied when there are more.
module asperity_pair_search_blocks
  use asperity_kinds, only: int32, int64, real64
  implicit none
  private

  public :: found_pair, found_pairs, pair_block
  public :: room_in_block

  !> One pair. Not initialised: a large array of these would be written twice.
  type :: found_pair
    real(real64) :: touch     !! approach at which the pair touches first, unit of the surfaces
    real(real64) :: squared   !! square of the distance of the summits in plan
    integer(int32) :: upper   !! index of the upper asperity, from 1
    integer(int32) :: lower   !! index of the lower asperity, from 1
  end type found_pair

  !> Some of the pairs found.
  type :: pair_block
    integer :: used = 0                       !! pairs in the list
    type(found_pair), allocatable :: list(:)  !! the first `used` of them
  end type pair_block

  !> All pairs found, in the order of the search, which is the same in every run.
  type :: found_pairs
    integer(int64) :: number = 0_int64         !! pairs in all blocks
    real(real64) :: first = -huge(1.0_real64)  !! largest touch
    real(real64) :: last = huge(1.0_real64)    !! least touch
    integer :: blocks = 0                      !! blocks in use
    type(pair_block), allocatable :: block(:)  !! the first `blocks` of them
  end type found_pairs

  ! Pairs a block.
  integer, parameter :: block_size = 65536

contains

  !> Sees to it that the last block in use has room. `failed` when there is no memory.
  subroutine room_in_block(found, needed, failed)
    type(found_pairs), intent(inout) :: found  !! pairs so far
    integer, intent(in) :: needed              !! room for so many, 65536 at most
    logical, intent(out) :: failed             !! no memory
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
        call move_alloc(found%block(i)%list, larger(i)%list)
      end do
      call move_alloc(larger, found%block)
    end if
    allocate (found%block(found%blocks + 1)%list(block_size), stat=status)
    failed = status /= 0
    if (.not. failed) found%blocks = found%blocks + 1
  end subroutine room_in_block

end module asperity_pair_search_blocks
