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
    integer, intent(inout) :: near(:)                  !! the first so many: places that are near
    integer, intent(out) :: number                     !! how many
    real(real32) :: four(4)
    integer :: i, k

    number = 0
    do k = 0, size(is_far) - block, block
      four = (is_far(k + 1:k + 4) + is_far(k + 5:k + 8)) + &
             (is_far(k + 9:k + 12) + is_far(k + 13:k + 16))
      if ((four(1) + four(2)) + (four(3) + four(4)) > block - 0.5_real32) cycle
      do i = k + 1, k + block
        if (is_far(i) > 0.5_real32) cycle
        number = number + 1
        near(number) = i
      end do
    end do
    do i = size(is_far) - modulo(size(is_far), block) + 1, size(is_far)
      if (is_far(i) > 0.5_real32) cycle
      number = number + 1
      near(number) = i
    end do
  end subroutine list_near_real32

  !> Double precision.
  pure subroutine list_near_real64(is_far, near, number)
    real(real64), contiguous, intent(in) :: is_far(:)  !! flags
    integer, intent(inout) :: near(:)                  !! the first so many: places that are near
    integer, intent(out) :: number                     !! how many
    real(real64) :: four(4)
    integer :: i, k

    number = 0
    do k = 0, size(is_far) - block, block
      four = (is_far(k + 1:k + 4) + is_far(k + 5:k + 8)) + &
             (is_far(k + 9:k + 12) + is_far(k + 13:k + 16))
      if ((four(1) + four(2)) + (four(3) + four(4)) > block - 0.5_real64) cycle
      do i = k + 1, k + block
        if (is_far(i) > 0.5_real64) cycle
        number = number + 1
        near(number) = i
      end do
    end do
    do i = size(is_far) - modulo(size(is_far), block) + 1, size(is_far)
      if (is_far(i) > 0.5_real64) cycle
      number = number + 1
      near(number) = i
    end do
  end subroutine list_near_real64

end module asperity_coupled_near
