!> Version of asperity: printed by `--version`, and stored with unfinished work, because another
!> version may give other results.
module asperity_version
  implicit none
  private

  public :: version

  character(len=*), parameter :: version = '0.4.0'  !! version number, the same as in fpm.toml

end module asperity_version
