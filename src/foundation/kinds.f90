!> Number kinds, named once for the whole library.
module asperity_kinds
  use, intrinsic :: iso_fortran_env, only: int32, int64, real32, real64, real128
  implicit none
  private

  public :: int32, int64, real32, real64, real128

end module asperity_kinds
