!> Who is near, from flags that say who is far: neighbours in order of place are near in runs.
module asperity_coupled_near
  use asperity_kinds, only: real32, real64
  implicit none
  private

  public :: list_near

  integer, parameter :: block = 16

  !> Lists the places of flags that are 0. All are 0 or 1.
  interface list_near
    module procedure list_near_real32, list_near_real64
  end interface list_near

contains

  !> Single precision.
  pure subroutine list_near_real32(is_far, near, number)
    real(real32), contiguous, intent(in) :: is_far(:)  !! flags
#include "near.inc"
  end subroutine list_near_real32

  !> Double precision.
  pure subroutine list_near_real64(is_far, near, number)
    real(real64), contiguous, intent(in) :: is_far(:)  !! flags
#include "near.inc"
  end subroutine list_near_real64

end module asperity_coupled_near
