!> Pieces of work done in rounds: in each round every image does some, image 1 gathers and keeps
!> them. So a run that ends in the middle loses a round at most.
module asperity_image_rounds
  use asperity_images, only: image_count, take_from_first
  use asperity_kinds, only: int64, real64
  use asperity_letters, only: message_numbers, message_to_numbers, numbers_to_message
  implicit none
  private

  public :: agree, begin_round, end_round, image_rounds

  !> Where the work is. The same on all images, once they have agreed.
  type :: image_rounds
    integer :: total = 0              !! pieces of work
    integer :: done = 0               !! so many are done, from the first on
    integer :: each = 1               !! pieces an image does in a round
    integer :: most_each = huge(1)    !! at most
    integer :: first = 1              !! piece of this round ...
    integer :: last = 0               !! ... to this
    integer(int64) :: start = 0_int64 !! clock at its begin
  end type image_rounds

contains

  !> The next pieces are under way.
  subroutine begin_round(rounds)
    type(image_rounds), intent(inout) :: rounds  !! the work

    rounds%first = rounds%done + 1
    rounds%last = int(min(int(rounds%total, int64), &
                          int(rounds%done, int64) + int(rounds%each, int64) * image_count()))
    call system_clock(rounds%start)
  end subroutine begin_round

  !> These pieces are done, or could not be. The next round shall take about a second; results do
  !> not depend on it.
  subroutine end_round(rounds, failure)
    type(image_rounds), intent(inout) :: rounds                  !! the work
    character(len=:), allocatable, intent(inout) :: failure      !! that of image 1, on all
    integer(int64) :: now, rate

    rounds%done = rounds%last
    call system_clock(now, rate)
    if (2 * (now - rounds%start) < rate) &
      rounds%each = int(min(2_int64 * int(rounds%each, int64), int(rounds%most_each, int64)))
    if (now - rounds%start > 2 * rate) rounds%each = max(rounds%each / 2, 1)
    call agree(rounds, failure)
  end subroutine end_round

  !> Brings what image 1 knows to all: how many pieces are done, how many an image shall do next, or
  !> why it cannot go on. `failure` tells of a lost image too.
  subroutine agree(rounds, failure)
    type(image_rounds), intent(inout) :: rounds                  !! the work
    character(len=:), allocatable, intent(inout) :: failure      !! that of image 1, on all
    character(len=:), allocatable :: lost
    real(real64) :: packet(2 + message_numbers)

    call message_to_numbers(failure, packet(3:))
    packet(:2) = real([rounds%done, rounds%each], real64)
    call take_from_first(packet, lost)
    rounds%done = nint(packet(1))
    rounds%each = nint(packet(2))
    call numbers_to_message(packet(3:), failure)
    if (allocated(lost)) call move_alloc(lost, failure)
  end subroutine agree

end module asperity_image_rounds
