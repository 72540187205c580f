!> Whether another thread wants work to end: a number in its memory, which it makes other than 0.
module asperity_interruption
  use, intrinsic :: iso_c_binding, only: c_int
  implicit none
  private

  public :: interruption

  !> Where the number is. As it stands nobody can end the work.
  type :: interruption
    integer(c_int), pointer :: number => null()  !! 0 as long as the work may go on
  contains
    procedure :: is_asked  !! an end is wanted
  end type interruption

contains

  !> Whether an end is wanted.
  logical function is_asked(self)
    class(interruption), intent(in) :: self  !! of the work
    integer(c_int) :: number

    number = 0_c_int
    if (associated(self%number)) then
      !$omp atomic read
      number = self%number
    end if
    is_asked = number /= 0_c_int
  end function is_asked

end module asperity_interruption
