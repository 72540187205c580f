!> The present-day solver in the arithmetic asked for.
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

  !> Makes a scene ready to be solved. `failure` is allocated when a number is out of the range of
  !> the arithmetic, or the arithmetic is not known.
  subroutine solver_in(arithmetic, scene_in, method, solver, failure)
    character(len=*), intent(in) :: arithmetic             !! ibm370, real32, real64 or real128
    type(scene), intent(in) :: scene_in                    !! checked values
    type(solve_method), intent(in) :: method               !! how to compute
    class(position_solver), allocatable, intent(out) :: solver
    character(len=:), allocatable, intent(out) :: failure  !! why not

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
