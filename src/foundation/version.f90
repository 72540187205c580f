!> Which asperity this is: told by `--version`, and kept with unfinished work, which another version
!> might finish otherwise.
module asperity_version
  implicit none
  private

  public :: version

  !> As in fpm.toml.
  character(len=*), parameter :: version = '0.2.0'

end module asperity_version
