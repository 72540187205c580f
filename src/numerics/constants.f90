!> Mathematical constants of several modules.
module asperity_constants
  use asperity_kinds, only: real128, real64
  implicit none
  private

  public :: pi, pi_128

  !> Circumference of a circle over its diameter.
  real(real128), parameter :: pi_128 = 3.14159265358979323846264338327950288_real128
  !> Circumference of a circle over its diameter, in doubles.
  real(real64), parameter :: pi = real(pi_128, real64)

end module asperity_constants
