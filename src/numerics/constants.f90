!> Numbers of mathematics that more than one module needs.
module asperity_constants
  use asperity_kinds, only: real64
  implicit none
  private

  public :: pi

  !> Circumference of a circle over its diameter.
  real(real64), parameter :: pi = acos(-1.0_real64)

end module asperity_constants
