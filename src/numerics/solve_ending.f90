!> Result of the iteration of a solver.
module asperity_solve_ending
  use asperity_kinds, only: real64
  implicit none
  private

  public :: solve_ending

  !> End of one iteration; by default not converged. It has no gaps.
  type :: solve_ending
    real(real64) :: residual = 0.0_real64   !! relative residual as the solver defines it
    integer :: iterations = 0               !! number of outer iterations
    logical :: converged = .false.          !! whether the residual is below the tolerance
  end type solve_ending

end module asperity_solve_ending
