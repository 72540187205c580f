!> Turns of threads in the procedures of the library that compose texts.
!>
!> gfortran keeps the length of a function's `character(len=:)` result in static memory at each
!> call, and threads overwrite it. Such procedures of the library therefore take turns. A solve
!> calls no such function and takes none. A thread that has the turn may begin further ones.
module asperity_library_turn
  !$ use omp_lib, only: omp_init_nest_lock, omp_nest_lock_kind, omp_set_nest_lock, &
  !$                    omp_unset_nest_lock
  implicit none
  private

  public :: library_turn

  !> A turn of a thread. It ends with the procedure that declares it.
  type :: library_turn
    private
    logical :: has_begun = .false.
  contains
    procedure :: begin => begin_turn  !! waits until no other thread has the turn
    procedure :: finish => finish_turn  !! ends the turn, where it has begun
    final :: finish_at_return
  end type library_turn

  ! The lock, and whether it is initialized.
  !$ integer(omp_nest_lock_kind) :: lock
  logical :: is_initialized = .false.

contains

  !> Waits until no other thread has the turn.
  subroutine begin_turn(self)
    class(library_turn), intent(inout) :: self  !! turn that has not begun

    !$omp critical (library_lock)
    !$ if (.not. is_initialized) call omp_init_nest_lock(lock)
    is_initialized = .true.
    !$omp end critical (library_lock)
    !$ call omp_set_nest_lock(lock)
    self%has_begun = .true.
  end subroutine begin_turn

  !> Ends the turn, where it has begun.
  subroutine finish_turn(self)
    class(library_turn), intent(inout) :: self  !! turn that may have begun

    if (.not. self%has_begun) return
    self%has_begun = .false.
    !$ call omp_unset_nest_lock(lock)
  end subroutine finish_turn

  ! Ends the turn of a procedure that returns.
  subroutine finish_at_return(self)
    type(library_turn), intent(inout) :: self

    call self%finish()
  end subroutine finish_at_return

end module asperity_library_turn
