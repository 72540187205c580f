!> The images of a run: copies of the program that share the work (coarrays, Fortran 2008) by a file
!> of records (`asperity_kept_records`).
!>
!> By default there is one image. With OpenCoarrays over MPI and ASPERITY_COARRAYS defined, the
!> number of images is that of the run. All coarray statements of the project are in this module.
module asperity_images
  implicit none
  private

  public :: image_number, image_count, is_image_build, read_mark, set_mark, wait_for_images
  public :: mark_of_failure, mark_of_run

  !> Marks on image 1 that all images read and write: the first piece of work that failed, and the
  !> number of the process of image 1.
  integer, parameter :: mark_of_failure = 1, mark_of_run = 2
#ifdef ASPERITY_COARRAYS
  integer :: marks(2)[*] = 0
#else
  integer :: marks(2) = 0
#endif

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

  !> Whether this is the build for several images, which a launcher has connected before the start.
  pure logical function is_image_build()
    is_image_build = .false.
#ifdef ASPERITY_COARRAYS
    is_image_build = .true.
#endif
  end function is_image_build

  !> Sets a mark. To be called outside of parallel regions.
  subroutine set_mark(which, value)
    integer, intent(in) :: which  !! one of the `mark_` numbers
    integer, intent(in) :: value  !! number of the piece or process

#ifdef ASPERITY_COARRAYS
    marks(which)[1] = value
#else
    marks(which) = value
#endif
  end subroutine set_mark

  !> The value of a mark. To be called outside of parallel regions.
  integer function read_mark(which)
    integer, intent(in) :: which  !! one of the `mark_` numbers

#ifdef ASPERITY_COARRAYS
    read_mark = marks(which)[1]
#else
    read_mark = marks(which)
#endif
  end function read_mark

  !> Synchronises all images.
  subroutine wait_for_images(is_lost)
    logical, intent(out), optional :: is_lost  !! an image has ended before
    integer :: status

    status = 0
#ifdef ASPERITY_COARRAYS
    sync all (stat=status)
#endif
    if (present(is_lost)) is_lost = status /= 0
  end subroutine wait_for_images

end module asperity_images
