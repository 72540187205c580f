!> The input files of a scene, each with a checksum of its bytes.
module asperity_scene_inputs
  use asperity_files, only: read_whole_file, same_name
  use asperity_kept_records, only: checksum
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: input_file, keep_checksums, list_inputs

  !> One input file.
  type :: input_file
    character(len=:), allocatable :: path  !! path as given; empty: no file
    character(len=8) :: checksum = ''      !! FNV-1a of 32 bits, hexadecimal
  end type input_file

contains

  !> Lists the files. The scene has its text and the checksum of a surface that was read from a
  !> pipe; files of surfaces are read again.
  subroutine list_inputs(scene_in, inputs, failure)
    type(scene), intent(in) :: scene_in                     !! scene with its text
    type(input_file), intent(out) :: inputs(3)              !! files of the scene and its surfaces
    character(len=:), allocatable, intent(out) :: failure   !! reason, when one cannot be read
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

  !> Keeps the checksums of the files of surfaces in the scene: `list_inputs` does not read them
  !> again. A file that cannot be read has none.
  subroutine keep_checksums(scene_in)
    type(scene), intent(inout) :: scene_in  !! scene that was read from files
    type(input_file) :: inputs(3)
    character(len=:), allocatable :: failure
    integer :: i

    call list_inputs(scene_in, inputs, failure)
    do i = 2, size(inputs)
      if (inputs(i)%path == '') cycle
      if (scene_in%upper%file == inputs(i)%path) scene_in%upper%checksum = inputs(i)%checksum
      if (scene_in%lower%file == inputs(i)%path) scene_in%lower%checksum = inputs(i)%checksum
    end do
  end subroutine keep_checksums

end module asperity_scene_inputs
