!> The positions of a sweep shared out over the images of a run, and kept in a file as they are
!> solved.
!>
!> A sweep that is neither shared nor kept is one round of one image, and nothing is packed. Else
!> image 1 has all results in the end, in order; the other images have their own only.
module asperity_position_rounds
  use asperity_contact_records, only: most_rows, position_result
  use asperity_image_rounds, only: agree, begin_round, end_round, image_rounds
  use asperity_images, only: gather_numbers, image_count, image_number, take_from_first
  use asperity_kept_records, only: keep_records, kept_work, number_record, resume_records
  use asperity_kinds, only: int64, real64
  use asperity_letters, only: message_numbers, message_to_numbers, numbers_to_message
  use asperity_position_packet, only: pack_position, unpack_position
  implicit none
  private

  public :: position_rounds
  public :: add_to_round, begin_rounds, is_own, next_round, share_next_sweep

  !> A sweep under way.
  type :: position_rounds
    private
    logical, public :: shared = .false.       !! over images, or kept: results are packed
    logical :: begun = .false.
    logical :: kept = .false.                  ! in a file
    type(kept_work) :: work                    ! that file
    type(image_rounds), public :: rounds       !! positions first to last are under way
    type(number_record), allocatable :: records(:)         ! of this round, by this image
    !> What was added to the results that came from elsewhere, by position; not allocated: nothing.
    type(number_record), allocatable, public :: more(:)
    character(len=:), allocatable, public :: failure       !! why the sweep cannot go on
  end type position_rounds

  ! What the next sweep shall be.
  logical :: share_next = .false.
  type(kept_work) :: keep_next

contains

  !> The next sweep, and no other, is shared out over all images, each of which must solve it.
  subroutine share_next_sweep(work)
    type(kept_work), intent(in) :: work  !! where positions are kept; no path: nowhere

    share_next = .true.
    keep_next = work
  end subroutine share_next_sweep

  !> A sweep begins.
  subroutine begin_rounds(sweep, positions)
    type(position_rounds), intent(out) :: sweep  !! nothing is solved yet
    integer, intent(in) :: positions             !! of the sweep

    sweep%rounds%total = positions
    if (.not. share_next) return
    share_next = .false.
    sweep%kept = keep_next%path /= ''
    sweep%shared = sweep%kept .or. image_count() > 1
    sweep%work = keep_next
    if (sweep%shared) allocate (sweep%more(positions))
  end subroutine begin_rounds

  !> Ends a round, when there was one, and begins the next. On image 1 `positions` has the results
  !> of all rounds then. `failed` and `failure` are of this image in the round that ends; on image
  !> 1 they become those of the first position of all images that failed.
  subroutine next_round(sweep, positions, failed, failure, going_on)
    type(position_rounds), intent(inout) :: sweep                !! of this image
    type(position_result), intent(inout) :: positions(:)         !! of the whole sweep
    integer, intent(inout) :: failed                             !! position; huge: none
    character(len=:), allocatable, intent(inout) :: failure      !! why
    logical, intent(out) :: going_on                             !! there are positions to solve
    character(len=:), allocatable :: ending
    logical :: told

    if (.not. sweep%shared) then
      going_on = .not. sweep%begun
      sweep%rounds%last = sweep%rounds%total
      sweep%begun = .true.
      return
    end if
    ! Image 1 tells of a position that failed, or has too many contacts, when it has seen them all.
    told = .false.
    if (sweep%begun) then
      call exchange(sweep, positions, failed, failure, ending)
      if (image_number() == 1 .and. .not. allocated(ending)) then
        told = allocated(failure) .or. &
               sum(int(positions(:sweep%rounds%last)%rows_used, int64)) > int(most_rows, int64)
        if (told) ending = 'a position failed'
      end if
      call end_round(sweep%rounds, ending)
    else
      call resume(sweep, positions, ending)
      call agree(sweep%rounds, ending)
    end if
    sweep%begun = .true.
    if (allocated(ending) .and. .not. told) sweep%failure = ending
    going_on = .not. allocated(ending) .and. sweep%rounds%done < sweep%rounds%total
    if (.not. going_on) return
    call begin_round(sweep%rounds)
    if (allocated(sweep%records)) deallocate (sweep%records)
    allocate (sweep%records(sweep%rounds%first:sweep%rounds%last))
  end subroutine next_round

  !> Whether this image solves a position of the round. They are dealt in turn.
  elemental logical function is_own(sweep, m)
    type(position_rounds), intent(in) :: sweep  !! of this image
    integer, intent(in) :: m                    !! position

    is_own = .true.
    if (sweep%shared) is_own = dealt_to(sweep%rounds, m) == image_number()
  end function is_own

  ! The image that solves a position of the round.
  elemental integer function dealt_to(rounds, m)
    type(image_rounds), intent(in) :: rounds
    integer, intent(in) :: m

    dealt_to = 1 + modulo(m - rounds%first, image_count())
  end function dealt_to

  !> Packs a position that this image has solved.
  subroutine add_to_round(sweep, m, result, more)
    type(position_rounds), intent(inout) :: sweep   !! of this image
    integer, intent(in) :: m                        !! position
    type(position_result), intent(in) :: result     !! its result
    real(real64), intent(in) :: more(:)             !! what goes with it

    call pack_position(result, more, sweep%records(m)%numbers)
  end subroutine add_to_round

  ! What a former run kept comes to image 1.
  subroutine resume(sweep, positions, failure)
    type(position_rounds), intent(inout) :: sweep
    type(position_result), intent(inout) :: positions(:)
    character(len=:), allocatable, intent(inout) :: failure
    type(number_record), allocatable :: records(:)
    integer :: m

    allocate (records(0))
    if (.not. sweep%kept .or. image_number() > 1) return
    call resume_records(sweep%work, sweep%rounds%total, records, failure)
    if (allocated(failure)) return
    do m = 1, size(records)
      call take_result(sweep, m, records(m)%numbers, positions(m))
    end do
    sweep%rounds%done = size(records)
  end subroutine resume

  subroutine take_result(sweep, m, numbers, position)
    type(position_rounds), intent(inout) :: sweep
    integer, intent(in) :: m
    real(real64), intent(in) :: numbers(:)
    type(position_result), intent(inout) :: position
    integer :: used

    call unpack_position(numbers, position, used)
    sweep%more(m)%numbers = numbers(used + 1:)
  end subroutine take_result

  ! Brings the results of the round to image 1 and keeps them.
  subroutine exchange(sweep, positions, failed, failure, trouble)
    type(position_rounds), intent(inout) :: sweep
    type(position_result), intent(inout) :: positions(:)
    integer, intent(inout) :: failed
    character(len=:), allocatable, intent(inout) :: failure
    character(len=:), allocatable, intent(out) :: trouble  ! results cannot be gathered or kept
    real(real64), allocatable :: own(:), all_numbers(:, :)
    integer :: i

    if (image_count() > 1) then
      call lay_out(sweep, failed, failure, own, trouble)
      if (allocated(trouble)) return
      allocate (all_numbers(size(own), merge(image_count(), 0, image_number() == 1)))
      call gather_numbers(own, all_numbers, trouble)
      if (allocated(trouble) .or. image_number() > 1) return
      do i = 2, image_count()
        call take_round(sweep, i, all_numbers(:, i), positions, failed, failure)
      end do
    end if
    if (sweep%kept .and. .not. allocated(failure)) then
      ! Behind the first one that is missing there are too many contacts.
      i = 0
      do while (i < size(sweep%records))
        if (length_of(sweep%records(sweep%rounds%first + i)) == 0) exit
        i = i + 1
      end do
      call keep_records(sweep%work, sweep%rounds%first, &
                        sweep%records(:sweep%rounds%first + i - 1), trouble)
    end if
  end subroutine exchange

  ! One stream of numbers of this image, as long as that of all others: the position that failed
  ! and why; then for every own position of the round how many numbers, and these.
  subroutine lay_out(sweep, failed, failure, own, trouble)
    type(position_rounds), intent(in) :: sweep
    integer, intent(in) :: failed
    character(len=:), allocatable, intent(in) :: failure
    real(real64), allocatable, intent(out) :: own(:)
    character(len=:), allocatable, intent(out) :: trouble
    integer :: m, at, length

    at = 1 + message_numbers
    do m = sweep%rounds%first, sweep%rounds%last
      if (is_own(sweep, m)) at = at + 1 + length_of(sweep%records(m))
    end do
    call longest_of_all(at, trouble)
    if (allocated(trouble)) return
    allocate (own(at), source=0.0_real64)
    own(1) = real(failed, real64)
    call message_to_numbers(failure, own(2:1 + message_numbers))
    at = 1 + message_numbers
    do m = sweep%rounds%first, sweep%rounds%last
      if (.not. is_own(sweep, m)) cycle
      length = length_of(sweep%records(m))
      own(at + 1) = real(length, real64)
      if (length > 0) own(at + 2:at + 1 + length) = sweep%records(m)%numbers
      at = at + 1 + length
    end do
  end subroutine lay_out

  ! Numbers of a position; 0 when it was not solved.
  pure integer function length_of(record)
    type(number_record), intent(in) :: record

    length_of = 0
    if (allocated(record%numbers)) length_of = size(record%numbers)
  end function length_of

  ! Makes a length the longest of all images.
  subroutine longest_of_all(length, trouble)
    integer, intent(inout) :: length
    character(len=:), allocatable, intent(out) :: trouble
    real(real64) :: lengths(1, image_count()), longest(1)

    call gather_numbers([real(length, real64)], lengths, trouble)
    if (allocated(trouble)) return
    longest = maxval(lengths)
    call take_from_first(longest, trouble)
    length = nint(longest(1))
  end subroutine longest_of_all

  ! The stream of another image.
  subroutine take_round(sweep, image, numbers, positions, failed, failure)
    type(position_rounds), intent(inout) :: sweep
    integer, intent(in) :: image
    real(real64), intent(in) :: numbers(:)
    type(position_result), intent(inout) :: positions(:)
    integer, intent(inout) :: failed
    character(len=:), allocatable, intent(inout) :: failure
    integer :: m, at, length

    if (nint(numbers(1)) < failed) then
      failed = nint(numbers(1))
      call numbers_to_message(numbers(2:1 + message_numbers), failure)
    end if
    at = 1 + message_numbers
    do m = sweep%rounds%first, sweep%rounds%last
      if (dealt_to(sweep%rounds, m) /= image) cycle
      length = nint(numbers(at + 1))
      if (length > 0) then
        sweep%records(m)%numbers = numbers(at + 2:at + 1 + length)
        call take_result(sweep, m, sweep%records(m)%numbers, positions(m))
      end if
      at = at + 1 + length
    end do
  end subroutine take_round

end module asperity_position_rounds
