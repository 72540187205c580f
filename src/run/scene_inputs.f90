!> The files that a scene is made of, each with a checksum of its bytes.
module asperity_scene_inputs
  use asperity_files, only: read_whole_file, same_name
  use asperity_kept_records, only: checksum
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: input_file, list_inputs

  !> One file.
  type :: input_file
    character(len=:), allocatable :: path  !! as it was named; empty: there is none
    character(len=8) :: checksum = ''      !! FNV-1a of 32 bits, hexadecimal
  end type input_file

contains

  !> Lists the files. The text of the scene is known, and the checksum of a surface that came
  !> through a pipe; files of surfaces are read again: `failure` is allocated when one cannot be.
  subroutine list_inputs(scene_in, inputs, failure)
    type(scene), intent(in) :: scene_in                     !! read
    type(input_file), intent(out) :: inputs(3)              !! the scene, then its surfaces
    character(len=:), allocatable, intent(out) :: failure   !! why not
    integer :: used

    used = 1
    inputs(1)%path = scene_in%file
    inputs(1)%checksum = checksum(scene_in%text)
    inputs(2)%path = ''
    inputs(3)%path = ''
    call add_file(scene_in%upper%file, scene_in%upper%checksum)
    call add_file(scene_in%lower%file, scene_in%lower%checksum)

  contains

    subroutine add_file(path, known)
      character(len=*), intent(in) :: path, known
      character(len=:), allocatable :: text
      integer :: i

      if (allocated(failure) .or. path == '') return
      do i = 1, used
        if (same_name(path, inputs(i)%path)) return
      end do
      used = used + 1
      inputs(used)%path = path
      inputs(used)%checksum = known
      if (known /= '') return
      call read_whole_file(path, text, failure)
      if (.not. allocated(failure)) inputs(used)%checksum = checksum(text)
    end subroutine add_file

  end subroutine list_inputs

end module asperity_scene_inputs
