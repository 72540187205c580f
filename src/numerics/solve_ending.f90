!> How an iterative solve ended.
module asperity_solve_ending
  use asperity_kinds, only: real64
  implicit none
  private

  public :: solve_ending

  !> The ending of one solve. Not converged unless it says so.
  type :: solve_ending
    logical :: converged = .false.          !! the residual is below what was asked for
    real(real64) :: residual = 0.0_real64   !! relative; of what, see the solver
    integer :: iterations = 0               !! outer ones
  end type solve_ending

end module asperity_solve_ending
