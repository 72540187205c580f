!> The present-day solver in the arithmetic asked for.
module asperity_solver
  use asperity_contact_records, only: scene_results, solve_method
  use asperity_kernel_ibm370, only: solve_ibm370 => solve_scene
  use asperity_kernel_real128, only: solve_real128 => solve_scene
  use asperity_kernel_real32, only: solve_real32 => solve_scene
  use asperity_kernel_real64, only: solve_real64 => solve_scene
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: solve_in_arithmetic

contains

  !> Solves a scene. `failure` is allocated when a position cannot be solved or the arithmetic is
  !> not known.
  subroutine solve_in_arithmetic(arithmetic, scene_in, method, keep_rows, results, failure)
    character(len=*), intent(in) :: arithmetic             !! ibm370, real32, real64 or real128
    type(scene), intent(in) :: scene_in                    !! checked values
    type(solve_method), intent(in) :: method               !! how to compute
    logical, intent(in) :: keep_rows                       !! keep the contacts of every state
    type(scene_results), intent(out) :: results            !! all positions
    character(len=:), allocatable, intent(out) :: failure  !! why not

    select case (arithmetic)
    case ('ibm370')
      call solve_ibm370(scene_in, method, keep_rows, results, failure)
    case ('real32')
      call solve_real32(scene_in, method, keep_rows, results, failure)
    case ('real64')
      call solve_real64(scene_in, method, keep_rows, results, failure)
    case ('real128')
      call solve_real128(scene_in, method, keep_rows, results, failure)
    case default
      failure = 'unknown arithmetic ' // arithmetic
    end select
  end subroutine solve_in_arithmetic

end module asperity_solver
