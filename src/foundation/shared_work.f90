!> Work in pieces (positions, surfaces), done in rounds: in each round every image does some pieces,
!> and image 1 collects them and keeps them in a file. A run that is interrupted loses one round at
!> most.
!>
!> The result of a piece is sent and kept as words of 64 bits. Work of one image without a file is
!> one round, and no result is packed.
module asperity_shared_work
  use asperity_images, only: gather_words, image_count, image_number, take_from_first
  use asperity_kept_records, only: join_records, keep_records, kept_work, resume_records, &
                                   word_record
  use asperity_kinds, only: int64
  implicit none
  private

  public :: shared_work
  public :: begin_work, begin_round, is_own, add_failure, gather_round, end_round

  ! Largest number of bytes of a message; its length is sent before it.
  integer, parameter :: longest_message = 512
  integer, parameter :: message_words = 1 + longest_message / 8

  !> Work in progress. Its numbers are the same on all images; the results are on image 1.
  type :: shared_work
    integer :: total = 0                             !! number of all pieces
    integer :: done = 0                              !! number of pieces done, from the first
    integer :: first = 1                             !! first piece of this round
    integer :: last = 0                              !! last piece of this round
    logical :: packed = .false.                      !! whether results are words
    !> words of the pieces of an earlier run, then of those of the round; the thread that did a
    !> piece stores its words, when results are packed
    type(word_record), allocatable :: records(:)
    integer :: failed = huge(1)                      !! first piece that failed
    character(len=:), allocatable :: failure         !! reason of its failure
    character(len=:), allocatable :: ending          !! reason for the end, on all images
    integer, private :: each = 1                     ! pieces of an image in a round
    integer, private :: most_each = huge(1)          ! its largest number
    integer(int64), private :: start = 0_int64       ! clock at the start of the round
    type(kept_work), private :: kept                 ! work with its file
  end type shared_work

contains

  !> Starts work. On image 1 `records` has the pieces of an earlier run.
  subroutine begin_work(work, total, shared, kept, most_each)
    type(shared_work), intent(out) :: work      !! work, done as far as it is kept
    integer, intent(in) :: total                !! number of all pieces
    logical, intent(in) :: shared               !! whether all images share the work
    type(kept_work), intent(in) :: kept         !! work with its file; no path: no file
    integer, intent(in), optional :: most_each  !! largest number of pieces of an image in a round

    work%total = total
    work%kept = kept
    if (present(most_each)) work%most_each = most_each
    work%packed = is_kept(work) .or. (shared .and. image_count() > 1)
    allocate (work%records(0))
    if (.not. work%packed) return
    if (is_kept(work) .and. image_number() == 1) then
      if (allocated(kept%more)) then
        call join_records(kept, total, work%records, work%ending)
      else
        call resume_records(kept, total, work%records, work%ending)
      end if
      if (.not. allocated(work%ending)) work%done = size(work%records)
    end if
    call copy_state(work)
  end subroutine begin_work

  !> Starts a round with the next pieces.
  subroutine begin_round(work, continues)
    type(shared_work), intent(inout) :: work  !! work after begin_work
    logical, intent(out) :: continues         !! whether there are pieces to do

    continues = .not. allocated(work%ending) .and. work%done < work%total
    if (.not. continues) return
    work%first = work%done + 1
    work%last = work%total
    if (.not. work%packed) return
    work%last = int(min(int(work%total, int64), &
                        int(work%done, int64) + int(work%each, int64) * image_count()))
    deallocate (work%records)
    allocate (work%records(work%first:work%last))
    call system_clock(work%start)
  end subroutine begin_round

  !> Whether this image does a piece of the round. Pieces are distributed in turn.
  elemental logical function is_own(work, m)
    type(shared_work), intent(in) :: work  !! work in a round
    integer, intent(in) :: m               !! number of the piece

    is_own = .true.
    if (work%packed) is_own = image_of(work, m) == image_number()
  end function is_own

  ! The image that does a piece of the round.
  elemental integer function image_of(work, m)
    type(shared_work), intent(in) :: work
    integer, intent(in) :: m

    image_of = 1 + modulo(m - work%first, image_count())
  end function image_of

  !> Records the failure of a piece. The failure of the piece with the lowest number is kept.
  subroutine add_failure(work, m, failure)
    type(shared_work), intent(inout) :: work  !! work in a round
    integer, intent(in) :: m                  !! number of the piece
    character(len=*), intent(in) :: failure   !! reason of the failure

    if (m >= work%failed) return
    work%failed = m
    work%failure = failure
  end subroutine add_failure

  !> Collects the results of the round on image 1, in `records`, with the first failure of all
  !> images, and writes them to the file. To be called by all images when their pieces are done.
  subroutine gather_round(work)
    type(shared_work), intent(inout) :: work  !! work in a round
    integer(int64), allocatable :: own(:), all_words(:, :)
    integer :: i

    if (.not. work%packed) return
    if (image_count() > 1) then
      call pack_stream(work, own)
      if (allocated(work%ending)) return
      allocate (all_words(size(own), merge(image_count(), 0, image_number() == 1)))
      call gather_words(own, all_words, work%ending)
      if (allocated(work%ending) .or. image_number() > 1) return
      do i = 2, image_count()
        call take_stream(work, i, all_words(:, i))
      end do
    end if
    if (.not. is_kept(work) .or. allocated(work%failure)) return
    ! Pieces after the first missing one are not kept.
    i = work%first
    do while (i <= work%last)
      if (length_of(work%records(i)) == 0) exit
      i = i + 1
    end do
    call keep_records(work%kept, work%first, work%records(:i - 1), work%ending)
  end subroutine gather_round

  !> Ends a round and copies the state of image 1 to all images. The work continues unless a piece
  !> failed or `ending` is set. Rounds are adapted to take about a second; results do not depend on
  !> it.
  subroutine end_round(work)
    type(shared_work), intent(inout) :: work  !! work after gather_round
    integer(int64) :: now, rate

    work%done = work%last
    if (allocated(work%failure) .and. .not. allocated(work%ending)) work%ending = work%failure
    if (.not. work%packed) return
    call system_clock(now, rate)
    if (2 * (now - work%start) < rate) &
      work%each = int(min(2_int64 * int(work%each, int64), int(work%most_each, int64)))
    if (now - work%start > 2 * rate) work%each = max(work%each / 2, 1)
    call copy_state(work)
  end subroutine end_round

  ! Copies the state of image 1 to all images: the number of pieces done, the number for the next
  ! round and the reason for an end. The loss of an image is such a reason, too.
  subroutine copy_state(work)
    type(shared_work), intent(inout) :: work
    character(len=:), allocatable :: lost
    integer(int64) :: packet(2 + message_words)

    packet(:2) = int([work%done, work%each], int64)
    packet(3:) = words_of_message(work%ending)
    call take_from_first(packet, lost)
    work%done = int(packet(1))
    work%each = int(packet(2))
    call take_message(packet(3:), work%ending)
    if (allocated(lost)) call move_alloc(lost, work%ending)
  end subroutine copy_state

  ! Packs the results of this image into words, as many as those of each other image: the failed
  ! piece and its reason, then for every own piece of the round its number of words and its words.
  subroutine pack_stream(work, own)
    type(shared_work), intent(inout) :: work
    integer(int64), allocatable, intent(out) :: own(:)
    integer :: m, at, length

    at = 1 + message_words
    do m = work%first, work%last
      if (is_own(work, m)) at = at + 1 + length_of(work%records(m))
    end do
    call longest_of_all(at, work%ending)
    if (allocated(work%ending)) return
    allocate (own(at), source=0_int64)
    own(1) = int(work%failed, int64)
    own(2:1 + message_words) = words_of_message(work%failure)
    at = 1 + message_words
    do m = work%first, work%last
      if (.not. is_own(work, m)) cycle
      length = length_of(work%records(m))
      own(at + 1) = int(length, int64)
      if (length > 0) own(at + 2:at + 1 + length) = work%records(m)%words
      at = at + 1 + length
    end do
  end subroutine pack_stream

  ! Unpacks the words of another image.
  subroutine take_stream(work, image, words)
    type(shared_work), intent(inout) :: work
    integer, intent(in) :: image
    integer(int64), intent(in) :: words(:)
    character(len=:), allocatable :: failure
    integer :: m, at, length

    call take_message(words(2:1 + message_words), failure)
    if (allocated(failure)) call add_failure(work, int(words(1)), failure)
    at = 1 + message_words
    do m = work%first, work%last
      if (image_of(work, m) /= image) cycle
      length = int(words(at + 1))
      if (length > 0) work%records(m)%words = words(at + 2:at + 1 + length)
      at = at + 1 + length
    end do
  end subroutine take_stream

  ! Sets a length to the largest of all images.
  subroutine longest_of_all(length, failure)
    integer, intent(inout) :: length
    character(len=:), allocatable, intent(out) :: failure
    integer(int64) :: lengths(1, image_count()), longest(1)

    call gather_words([int(length, int64)], lengths, failure)
    if (allocated(failure)) return
    longest = maxval(lengths)
    call take_from_first(longest, failure)
    length = int(longest(1))
  end subroutine longest_of_all

  ! Number of words of a piece; 0 when it was not done.
  pure integer function length_of(record)
    type(word_record), intent(in) :: record

    length_of = 0
    if (allocated(record%words)) length_of = size(record%words)
  end function length_of

  pure logical function is_kept(work)
    type(shared_work), intent(in) :: work

    is_kept = .false.
    if (allocated(work%kept%path)) is_kept = work%kept%path /= ''
  end function is_kept

  ! Words of a message: its length, 0 for none, and its bytes.
  pure function words_of_message(message) result(words)
    character(len=:), allocatable, intent(in) :: message
    integer(int64) :: words(message_words)
    character(len=longest_message) :: text

    words = 0_int64
    if (.not. allocated(message)) return
    text = message
    words(1) = int(max(1, min(len(message), longest_message)), int64)
    words(2:) = transfer(text, words(2:))
  end function words_of_message

  ! Sets a message from its words; without one it is unchanged.
  pure subroutine take_message(words, message)
    integer(int64), intent(in) :: words(message_words)
    character(len=:), allocatable, intent(inout) :: message
    character(len=longest_message) :: text

    if (words(1) == 0_int64) return
    text = transfer(words(2:), text)
    message = text(:int(words(1)))
  end subroutine take_message

end module asperity_shared_work
