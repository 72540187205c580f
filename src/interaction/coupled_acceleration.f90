!> Speeds up an iteration that converges steadily: Anderson mixing (Anderson 1965, J. ACM 12, 547;
!> type II of Fang and Saad 2009).
!>
!> From the last few steps proposed and taken it finds the combination that would have left least
!> to do. What a step's matrix leaves out, the coupling of few overlapping circles, is caught so.
module asperity_coupled_acceleration
  use asperity_kinds, only: real64
  implicit none
  private

  public :: step_memory, forget, accelerate

  integer, parameter :: most_kept = 6

  !> Steps of the past.
  type :: step_memory
    integer :: kept = 0                                  !! differences that are known
    logical :: has_last = .false.                        !! the last step is known
    real(real64), allocatable :: proposed(:)             !! last step proposed
    real(real64), allocatable :: taken(:)                !! last step taken
    real(real64), allocatable :: proposal_changes(:, :)  !! of the proposed steps
    real(real64), allocatable :: steps(:, :)             !! taken between them
  end type step_memory

contains

  !> Forgets all steps: what came before is another problem.
  pure subroutine forget(memory)
    type(step_memory), intent(inout) :: memory !! the steps

    memory%kept = 0
    memory%has_last = .false.
  end subroutine forget

  !> Turns a proposed step into a better one.
  pure subroutine accelerate(memory, step)
    type(step_memory), intent(inout) :: memory !! steps of the past; gets this one
    real(real64), intent(inout) :: step(:)     !! proposed; better. Its parts weigh as they are
    real(real64) :: matrix(most_kept, most_kept), weight(most_kept)
    real(real64), allocatable :: proposed(:)
    integer :: j, k, n
    logical :: solved

    n = size(step)
    allocate (proposed(n))
    proposed = step
    if (memory%has_last) then
      if (size(memory%taken) /= n) call forget(memory)
    end if
    if (memory%has_last) then
      if (memory%kept == most_kept) then
        memory%proposal_changes(:, :most_kept - 1) = memory%proposal_changes(:, 2:)
        memory%steps(:, :most_kept - 1) = memory%steps(:, 2:)
        memory%kept = most_kept - 1
      end if
      memory%kept = memory%kept + 1
      memory%proposal_changes(:, memory%kept) = proposed - memory%proposed
      memory%steps(:, memory%kept) = memory%taken
      do k = 1, memory%kept
        do j = 1, k
          matrix(j, k) = dot_product(memory%proposal_changes(:, j), memory%proposal_changes(:, k))
        end do
        weight(k) = dot_product(memory%proposal_changes(:, k), proposed)
      end do
      call solve_small(memory%kept, matrix, weight, solved)
      if (solved) then
        do k = 1, memory%kept
          step = step - weight(k) * (memory%steps(:, k) + memory%proposal_changes(:, k))
        end do
      else
        memory%kept = 0
      end if
    else if (.not. allocated(memory%taken)) then
      allocate (memory%taken(n), memory%proposed(n))
      allocate (memory%proposal_changes(n, most_kept), memory%steps(n, most_kept))
    else if (size(memory%taken) /= n) then
      deallocate (memory%taken, memory%proposed, memory%proposal_changes, memory%steps)
      allocate (memory%taken(n), memory%proposed(n))
      allocate (memory%proposal_changes(n, most_kept), memory%steps(n, most_kept))
    end if
    memory%proposed = proposed
    memory%taken = step
    memory%has_last = .true.
  end subroutine accelerate

  ! Least squares by Cholesky of the normal equations, slightly damped; the upper half is given.
  ! Not by LAPACK: for 6 unknowns dposv takes 4600 instructions, this 1000; for 3, 3000 and 300.
  pure subroutine solve_small(n, matrix, rhs, solved)
    integer, intent(in) :: n
    real(real64), intent(inout) :: matrix(:, :), rhs(:)
    logical, intent(out) :: solved
    real(real64) :: pivot
    integer :: j, k

    solved = .true.
    do k = 1, n
      pivot = matrix(k, k)
      do j = 1, k - 1
        matrix(j, k) = (matrix(j, k) - dot_product(matrix(:j - 1, j), matrix(:j - 1, k))) / &
                       matrix(j, j)
      end do
      matrix(k, k) = pivot * (1.0_real64 + 1.0e-13_real64) - &
                     dot_product(matrix(:k - 1, k), matrix(:k - 1, k))
      solved = matrix(k, k) > 0.0_real64
      if (.not. solved) return
      matrix(k, k) = sqrt(matrix(k, k))
      rhs(k) = (rhs(k) - dot_product(matrix(:k - 1, k), rhs(:k - 1))) / matrix(k, k)
    end do
    do k = n, 1, -1
      rhs(k) = rhs(k) / matrix(k, k)
      rhs(:k - 1) = rhs(:k - 1) - rhs(k) * matrix(:k - 1, k)
    end do
  end subroutine solve_small

end module asperity_coupled_acceleration
