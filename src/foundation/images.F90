!> The images of a run: copies of the program that share the work (coarrays, Fortran 2008).
!>
!> Compiled as it stands there is one, and nothing is sent. Over MPI, with OpenCoarrays and
!> ASPERITY_COARRAYS defined, there are as many as the run was started with. Nothing else in the
!> project holds a coarray statement.
module asperity_images
  use asperity_kinds, only: int64
  implicit none
  private

  public :: image_number, image_count, gather_words, take_from_first, wait_for_images

#ifdef ASPERITY_COARRAYS
  ! What an image shows the others.
  integer(int64), allocatable :: shown(:)[:]
#else
  integer(int64), allocatable :: shown_alone(:)
#endif
  character(len=*), parameter :: lost = 'an image of the run is lost'

contains

  !> Which of the images this is, from 1.
  pure integer function image_number()
    image_number = 1
#ifdef ASPERITY_COARRAYS
    image_number = this_image()
#endif
  end function image_number

  !> How many images there are.
  pure integer function image_count()
    image_count = 1
#ifdef ASPERITY_COARRAYS
    image_count = num_images()
#endif
  end function image_count

  !> Brings the words of all images to image 1, in their order; on the others `all_words` is 0.
  !> Every image must call it with as many words.
  subroutine gather_words(own, all_words, failure)
    integer(int64), intent(in) :: own(:)                     !! of this image
    integer(int64), intent(out) :: all_words(:, :)         !! a column an image
    character(len=:), allocatable, intent(out) :: failure  !! an image is lost
    integer :: i, status

    all_words = 0_int64
    call show(own, status)
    if (status == 0 .and. image_number() == 1) then
      do i = 1, image_count()
        call look(i, all_words(:, i))
      end do
    end if
    call hide(status)
    if (status /= 0) failure = lost
  end subroutine gather_words

  !> Brings the words of image 1 to all. Every image must call it with as many words.
  subroutine take_from_first(words, failure)
    integer(int64), intent(inout) :: words(:)              !! of image 1, in the end
    character(len=:), allocatable, intent(out) :: failure  !! an image is lost
    integer :: status

    call show(words, status)
    if (status == 0) call look(1, words)
    call hide(status)
    if (status /= 0) failure = lost
  end subroutine take_from_first

  !> Waits until all images are here: to be called before a process ends.
  subroutine wait_for_images()
    integer :: status

    status = 0
#ifdef ASPERITY_COARRAYS
    sync all (stat=status)
#endif
    if (status /= 0) return
  end subroutine wait_for_images

#ifdef ASPERITY_COARRAYS

  ! Lets the others look, once all have come here.
  subroutine show(words, status)
    integer(int64), intent(in) :: words(:)
    integer, intent(out) :: status

    ! Made anew only when it must grow: that is what takes time over MPI.
    status = 0
    if (allocated(shown)) then
      if (size(shown) < size(words)) deallocate (shown, stat=status)
    end if
    if (status == 0 .and. .not. allocated(shown)) allocate (shown(size(words))[*], stat=status)
    if (status /= 0) return
    shown(:size(words)) = words
    sync all (stat=status)
  end subroutine show

  ! What an image shows.
  subroutine look(image, words)
    integer, intent(in) :: image
    integer(int64), intent(inout) :: words(:)

    words = shown(:size(words))[image]
  end subroutine look

  ! Waits until all have looked.
  subroutine hide(status)
    integer, intent(inout) :: status

    if (status == 0) sync all (stat=status)
  end subroutine hide

#else

  subroutine show(words, status)
    integer(int64), intent(in) :: words(:)
    integer, intent(out) :: status

    if (allocated(shown_alone)) deallocate (shown_alone)
    allocate (shown_alone(size(words)), stat=status)
    if (status == 0) shown_alone = words
  end subroutine show

  subroutine look(image, words)
    integer, intent(in) :: image
    integer(int64), intent(inout) :: words(:)

    if (image == 1) words = shown_alone
  end subroutine look

  subroutine hide(status)
    integer, intent(inout) :: status

    if (status == 0) shown_alone = [integer(int64) ::]
  end subroutine hide

#endif

end module asperity_images
