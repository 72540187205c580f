!> The images of a run: copies of the program that share the work (coarrays, Fortran 2008).
!>
!> By default there is one image, and nothing is sent. With OpenCoarrays over MPI and
!> ASPERITY_COARRAYS defined, the number of images is that of the run. All coarray statements of the
!> project are in this module.
module asperity_images
  use asperity_kinds, only: int64
  implicit none
  private

  public :: image_number, image_count, gather_words, take_from_first, wait_for_images

#ifdef ASPERITY_COARRAYS
  ! Words of an image that others read.
  integer(int64), allocatable :: shown(:)[:]
#else
  integer(int64), allocatable :: shown_alone(:)
#endif
  character(len=*), parameter :: lost = 'an image of the run is lost'

contains

  !> Number of this image, from 1.
  pure integer function image_number()
    image_number = 1
#ifdef ASPERITY_COARRAYS
    image_number = this_image()
#endif
  end function image_number

  !> Number of images.
  pure integer function image_count()
    image_count = 1
#ifdef ASPERITY_COARRAYS
    image_count = num_images()
#endif
  end function image_count

  !> Collects the words of all images on image 1, in their order; on the others `all_words` is 0.
  !> Every image must call it with the same number of words.
  subroutine gather_words(own, all_words, failure)
    integer(int64), intent(in) :: own(:)                   !! words of this image
    integer(int64), intent(out) :: all_words(:, :)         !! words, a column for each image
    character(len=:), allocatable, intent(out) :: failure  !! reason: an image is lost
    integer :: i, status

    all_words = 0_int64
    call share_words(own, status)
    if (status == 0 .and. image_number() == 1) then
      do i = 1, image_count()
        call read_words(i, all_words(:, i))
      end do
    end if
    call end_sharing(status)
    if (status /= 0) failure = lost
  end subroutine gather_words

  !> Copies the words of image 1 to all images. Every image must call it with the same number.
  subroutine take_from_first(words, failure)
    integer(int64), intent(inout) :: words(:)              !! words; on exit those of image 1
    character(len=:), allocatable, intent(out) :: failure  !! reason: an image is lost
    integer :: status

    call share_words(words, status)
    if (status == 0) call read_words(1, words)
    call end_sharing(status)
    if (status /= 0) failure = lost
  end subroutine take_from_first

  !> Synchronises all images: to be called before a process ends.
  subroutine wait_for_images()
    integer :: status

    status = 0
#ifdef ASPERITY_COARRAYS
    sync all (stat=status)
#endif
    if (status /= 0) return
  end subroutine wait_for_images

#ifdef ASPERITY_COARRAYS

  ! Makes words readable by other images, and synchronises all images.
  subroutine share_words(words, status)
    integer(int64), intent(in) :: words(:)
    integer, intent(out) :: status

    ! It is allocated again only when it must grow, as an allocation is slow over MPI.
    status = 0
    if (allocated(shown)) then
      if (size(shown) < size(words)) deallocate (shown, stat=status)
    end if
    if (status == 0 .and. .not. allocated(shown)) allocate (shown(size(words))[*], stat=status)
    if (status /= 0) return
    shown(:size(words)) = words
    sync all (stat=status)
  end subroutine share_words

  ! Reads the words of an image.
  subroutine read_words(image, words)
    integer, intent(in) :: image
    integer(int64), intent(inout) :: words(:)

    words = shown(:size(words))[image]
  end subroutine read_words

  ! Synchronises all images after they have read.
  subroutine end_sharing(status)
    integer, intent(inout) :: status

    if (status == 0) sync all (stat=status)
  end subroutine end_sharing

#else

  subroutine share_words(words, status)
    integer(int64), intent(in) :: words(:)
    integer, intent(out) :: status

    if (allocated(shown_alone)) deallocate (shown_alone)
    allocate (shown_alone(size(words)), stat=status)
    if (status == 0) shown_alone = words
  end subroutine share_words

  subroutine read_words(image, words)
    integer, intent(in) :: image
    integer(int64), intent(inout) :: words(:)

    if (image == 1) words = shown_alone
  end subroutine read_words

  subroutine end_sharing(status)
    integer, intent(inout) :: status

    if (status == 0) shown_alone = [integer(int64) ::]
  end subroutine end_sharing

#endif

end module asperity_images
