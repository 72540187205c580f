!> Number kinds, named once for the whole library.
module asperity_kinds
  use, intrinsic :: iso_fortran_env, only: int32, int64, int8, real32, real64, real128
  implicit none
  private

  public :: int8, int32, int64, real32, real64, real128
  public :: not_computed

  !> Value of a number that was not computed: every computed number is larger. Writers leave its
  !> cell empty.
  real(real64), parameter :: not_computed = -huge(1.0_real64)

end module asperity_kinds
