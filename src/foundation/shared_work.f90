!> Work in pieces (positions, surfaces), done in rounds: in each round every image does some, and
!> image 1 gathers them and keeps them in a file. A run that ends in the middle loses a round at
!> most.
!>
!> The result of a piece travels and is kept as words of 64 bits. Work of one image that is not kept
!> is one round, and nothing becomes words.
module asperity_shared_work
  use asperity_images, only: gather_words, image_count, image_number, take_from_first
  use asperity_kept_records, only: join_records, keep_records, kept_work, resume_records, &
                                   word_record
  use asperity_kinds, only: int64
  implicit none
  private

  public :: shared_work
  public :: begin_work, begin_round, is_own, add_failure, gather_round, end_round

  ! A message travels with at most so many bytes, its length before it.
  integer, parameter :: longest_message = 512
  integer, parameter :: message_words = 1 + longest_message / 8

  !> Work under way. Where it is is the same on all images; the results are on image 1.
  type :: shared_work
    integer :: total = 0                             !! pieces
    integer :: done = 0                              !! so many are done, from the first on
    integer :: first = 1                             !! piece of this round ...
    integer :: last = 0                              !! ... to this
    logical :: packed = .false.                      !! results become words
    !> words of the pieces that an earlier run kept, then of those of the round; the thread that has
    !> done a piece stores its words, when results are packed
    type(word_record), allocatable :: records(:)
    integer :: failed = huge(1)                      !! first piece that failed
    character(len=:), allocatable :: failure         !! why
    character(len=:), allocatable :: ending          !! why the work cannot go on, on all images
    integer, private :: each = 1                     ! pieces an image does in a round
    integer, private :: most_each = huge(1)          ! at most
    integer(int64), private :: start = 0_int64       ! clock at the begin of the round
    type(kept_work), private :: kept                 ! the file
  end type shared_work

contains

  !> Work begins. What a former run kept is in `records` then, on image 1.
  subroutine begin_work(work, total, shared, kept, most_each)
    type(shared_work), intent(out) :: work    !! nothing is done but what is kept
    integer, intent(in) :: total              !! pieces
    logical, intent(in) :: shared             !! all images work on it, and call this
    type(kept_work), intent(in) :: kept       !! where results are kept; no path: nowhere
    integer, intent(in), optional :: most_each  !! pieces an image does in a round at most

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
    call agree(work)
  end subroutine begin_work

  !> The next pieces are under way, if there are any.
  subroutine begin_round(work, going_on)
    type(shared_work), intent(inout) :: work  !! begun
    logical, intent(out) :: going_on          !! there are pieces first to last to do

    going_on = .not. allocated(work%ending) .and. work%done < work%total
    if (.not. going_on) return
    work%first = work%done + 1
    work%last = work%total
    if (.not. work%packed) return
    work%last = int(min(int(work%total, int64), &
                        int(work%done, int64) + int(work%each, int64) * image_count()))
    deallocate (work%records)
    allocate (work%records(work%first:work%last))
    call system_clock(work%start)
  end subroutine begin_round

  !> Whether this image does a piece of the round. They are dealt in turn.
  elemental logical function is_own(work, m)
    type(shared_work), intent(in) :: work  !! in a round
    integer, intent(in) :: m               !! piece

    is_own = .true.
    if (work%packed) is_own = dealt_to(work, m) == image_number()
  end function is_own

  ! The image that does a piece of the round.
  elemental integer function dealt_to(work, m)
    type(shared_work), intent(in) :: work
    integer, intent(in) :: m

    dealt_to = 1 + modulo(m - work%first, image_count())
  end function dealt_to

  !> Records the failure of a piece. The failure of the piece with the lowest number is kept.
  subroutine add_failure(work, m, failure)
    type(shared_work), intent(inout) :: work  !! in a round
    integer, intent(in) :: m                  !! piece
    character(len=*), intent(in) :: failure   !! why

    if (m >= work%failed) return
    work%failed = m
    work%failure = failure
  end subroutine add_failure

  !> Brings the results of the round to image 1, in `records`, with the first failure of all images,
  !> and keeps them there. To be called by all images when theirs are done.
  subroutine gather_round(work)
    type(shared_work), intent(inout) :: work  !! in a round
    integer(int64), allocatable :: own(:), all_words(:, :)
    integer :: i

    if (.not. work%packed) return
    if (image_count() > 1) then
      call lay_out(work, own)
      if (allocated(work%ending)) return
      allocate (all_words(size(own), merge(image_count(), 0, image_number() == 1)))
      call gather_words(own, all_words, work%ending)
      if (allocated(work%ending) .or. image_number() > 1) return
      do i = 2, image_count()
        call take_stream(work, i, all_words(:, i))
      end do
    end if
    if (.not. is_kept(work) .or. allocated(work%failure)) return
    ! Behind the first one that is missing nothing was wanted.
    i = work%first
    do while (i <= work%last)
      if (length_of(work%records(i)) == 0) exit
      i = i + 1
    end do
    call keep_records(work%kept, work%first, work%records(:i - 1), work%ending)
  end subroutine gather_round

  !> Ends a round. The work goes on unless a piece failed or `ending` says why not; what image 1
  !> knows holds on all images then. A round shall take about a second; results do not depend on it.
  subroutine end_round(work)
    type(shared_work), intent(inout) :: work  !! after gather_round
    integer(int64) :: now, rate

    work%done = work%last
    if (allocated(work%failure) .and. .not. allocated(work%ending)) work%ending = work%failure
    if (.not. work%packed) return
    call system_clock(now, rate)
    if (2 * (now - work%start) < rate) &
      work%each = int(min(2_int64 * int(work%each, int64), int(work%most_each, int64)))
    if (now - work%start > 2 * rate) work%each = max(work%each / 2, 1)
    call agree(work)
  end subroutine end_round

  ! Brings what image 1 knows to all: how many pieces are done, how many an image shall do next, or
  ! why the work cannot go on. That an image is lost is such a reason too.
  subroutine agree(work)
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
  end subroutine agree

  ! One stream of words of this image, as long as that of all others: the piece that failed and why;
  ! then for every own piece of the round how many words, and these.
  subroutine lay_out(work, own)
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
  end subroutine lay_out

  ! The stream of another image.
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
      if (dealt_to(work, m) /= image) cycle
      length = int(words(at + 1))
      if (length > 0) work%records(m)%words = words(at + 2:at + 1 + length)
      at = at + 1 + length
    end do
  end subroutine take_stream

  ! Makes a length the longest of all images.
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

  ! Words of a piece; 0 when it was not done.
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

  ! A message that may be there: its length, 0 for none, and its bytes.
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

  ! The message in such words; one that is known stays when they hold none.
  pure subroutine take_message(words, message)
    integer(int64), intent(in) :: words(message_words)
    character(len=:), allocatable, intent(inout) :: message
    character(len=longest_message) :: text

    if (words(1) == 0_int64) return
    text = transfer(words(2:), text)
    message = text(:int(words(1)))
  end subroutine take_message

end module asperity_shared_work
