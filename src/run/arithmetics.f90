!> The solver without effects in each arithmetic.
module asperity_arithmetics
  use asperity_contact_records, only: solve_method
  use asperity_kernel_ibm370, only: place_ibm370 => make_solver
  use asperity_kernel_real128, only: place_real128 => make_solver
  use asperity_kernel_real32, only: place_real32 => make_solver
  use asperity_kernel_real64, only: place_real64 => make_solver
  use asperity_position_solver, only: position_solver
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: solver_in

contains

  !> Makes the solver of a scene. `failure` is allocated when a number is out of the range of the
  !> arithmetic, or the arithmetic does not exist.
  subroutine solver_in(arithmetic, scene_in, method, solver, failure)
    character(len=*), intent(in) :: arithmetic             !! ibm370, real32, real64 or real128
    type(scene), intent(in) :: scene_in                    !! scene, checked for faults
    type(solve_method), intent(in) :: method               !! method of the solver
    class(position_solver), allocatable, intent(out) :: solver
    character(len=:), allocatable, intent(out) :: failure  !! reason, when there is no solver

    select case (arithmetic)
    case ('ibm370')
      call place_ibm370(scene_in, method, solver, failure)
    case ('real32')
      call place_real32(scene_in, method, solver, failure)
    case ('real64')
      call place_real64(scene_in, method, solver, failure)
    case ('real128')
      call place_real128(scene_in, method, solver, failure)
    case default
      failure = 'unknown arithmetic ' // arithmetic
    end select
  end subroutine solver_in

end module asperity_arithmetics
