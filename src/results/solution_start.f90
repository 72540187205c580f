!> Earlier solutions of coupled contacts, as starts of further ones.
module asperity_solution_start
  use asperity_kinds, only: real64
  implicit none
  private

  public :: contact_solution, solution_reuse, solution_start

  !> One solution of a position. Lengths are in the unit of its pairs, loads over their modulus.
  type :: contact_solution
    real(real64) :: compression = 0.0_real64       !! compression
    real(real64) :: load(2) = 0.0_real64           !! sum of the normal and of the vertical loads
    !> Pairs that may touch at this compression, in order of gap: indices of asperities, gaps,
    !> penetrations, shifts (2, pair).
    integer, allocatable :: upper(:), lower(:)
    real(real64), allocatable :: gap(:), penetration(:), shift(:, :)
  end type contact_solution

  !> Solutions of one position.
  type :: solution_start
    type(contact_solution), allocatable :: solutions(:)  !! the latest first; not allocated: none
    !> Least compression, and its load over the modulus, at which a contact was inside the contact
    !> circle of another: from there on solutions depend on their start.
    real(real64) :: crowded_compression = huge(1.0_real64), crowded_load = huge(1.0_real64)
  end type solution_start

  !> Solutions with which a run starts, and whether it keeps its own.
  type :: solution_reuse
    logical :: keeps = .false.                               !! the results have solutions
    type(solution_start), pointer :: earlier(:) => null()    !! by position; or none
  end type solution_reuse

end module asperity_solution_start
