!> The images of a run: copies of the program that share the work (coarrays, Fortran 2008).
!>
!> Compiled as it stands there is one, and nothing is sent. Over MPI, with OpenCoarrays and
!> ASPERITY_COARRAYS defined, there are as many as the run was started with. Nothing else in the
!> project holds a coarray statement.
module asperity_images
  use asperity_kinds, only: real64
  implicit none
  private

  public :: image_number, image_count, gather_numbers, take_from_first, wait_for_images

#ifdef ASPERITY_COARRAYS
  ! What an image shows the others.
  real(real64), allocatable :: shown(:)[:]
#else
  real(real64), allocatable :: shown_alone(:)
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

  !> Brings the numbers of all images to image 1, in their order; on the others `all_numbers` is 0.
  !> Every image must call it with as many numbers.
  subroutine gather_numbers(own, all_numbers, failure)
    real(real64), intent(in) :: own(:)                     !! of this image
    real(real64), intent(out) :: all_numbers(:, :)         !! a column an image
    character(len=:), allocatable, intent(out) :: failure  !! an image is lost
    integer :: i, status

    all_numbers = 0.0_real64
    call show(own, status)
    if (status == 0 .and. image_number() == 1) then
      do i = 1, image_count()
        call look(i, all_numbers(:, i))
      end do
    end if
    call hide(status)
    if (status /= 0) failure = lost
  end subroutine gather_numbers

  !> Brings the numbers of image 1 to all. Every image must call it with as many numbers.
  subroutine take_from_first(numbers, failure)
    real(real64), intent(inout) :: numbers(:)              !! of image 1, in the end
    character(len=:), allocatable, intent(out) :: failure  !! an image is lost
    integer :: status

    call show(numbers, status)
    if (status == 0) call look(1, numbers)
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
  subroutine show(numbers, status)
    real(real64), intent(in) :: numbers(:)
    integer, intent(out) :: status

    ! Made anew only when it must grow: that is what takes time over MPI.
    status = 0
    if (allocated(shown)) then
      if (size(shown) < size(numbers)) deallocate (shown, stat=status)
    end if
    if (status == 0 .and. .not. allocated(shown)) allocate (shown(size(numbers))[*], stat=status)
    if (status /= 0) return
    shown(:size(numbers)) = numbers
    sync all (stat=status)
  end subroutine show

  ! What an image shows.
  subroutine look(image, numbers)
    integer, intent(in) :: image
    real(real64), intent(inout) :: numbers(:)

    numbers = shown(:size(numbers))[image]
  end subroutine look

  ! Waits until all have looked.
  subroutine hide(status)
    integer, intent(inout) :: status

    if (status == 0) sync all (stat=status)
  end subroutine hide

#else

  subroutine show(numbers, status)
    real(real64), intent(in) :: numbers(:)
    integer, intent(out) :: status

    if (allocated(shown_alone)) deallocate (shown_alone)
    allocate (shown_alone(size(numbers)), stat=status)
    if (status == 0) shown_alone = numbers
  end subroutine show

  subroutine look(image, numbers)
    integer, intent(in) :: image
    real(real64), intent(inout) :: numbers(:)

    if (image == 1) numbers = shown_alone
  end subroutine look

  subroutine hide(status)
    integer, intent(inout) :: status

    if (status == 0) shown_alone = [real(real64) ::]
  end subroutine hide

#endif

end module asperity_images
