!> The few procedures of FFTW 3 that are called here (Frigo and Johnson, Proc. IEEE 93, 2005).
!>
!> Arrays are handed over as addresses. FFTW counts their dimensions as C does, the slowest first.
!> Executing is safe in threads, making and destroying plans is not: that is done within
!> `critical (fftw_plans)`.
module asperity_fftw
  use, intrinsic :: iso_c_binding, only: c_int, c_ptr
  implicit none
  private

  public :: fftw_estimate, fftw_plan_real_to_complex, fftw_plan_complex_to_real
  public :: fftw_real_to_complex, fftw_complex_to_real, fftw_destroy

  !> A plan made without measuring, for arrays that lie anywhere (FFTW_ESTIMATE, FFTW_UNALIGNED):
  !> the same lengths give the same plan, and so the same bytes.
  integer(c_int), parameter :: fftw_estimate = 64_c_int + 2_c_int

  interface
    !> Plans a transform of `slow` rows of `fast` doubles to `slow` rows of `fast/2 + 1` numbers.
    type(c_ptr) function fftw_plan_real_to_complex(slow, fast, values, transform, flags) &
      bind(c, name='fftw_plan_dft_r2c_2d')
      import :: c_int, c_ptr
      implicit none
      integer(c_int), value :: slow, fast
      type(c_ptr), value :: values, transform
      integer(c_int), value :: flags
    end function fftw_plan_real_to_complex

    !> Plans the way back. It overwrites the transform, and multiplies by `slow * fast`.
    type(c_ptr) function fftw_plan_complex_to_real(slow, fast, transform, values, flags) &
      bind(c, name='fftw_plan_dft_c2r_2d')
      import :: c_int, c_ptr
      implicit none
      integer(c_int), value :: slow, fast
      type(c_ptr), value :: transform, values
      integer(c_int), value :: flags
    end function fftw_plan_complex_to_real

    !> Transforms as planned.
    subroutine fftw_real_to_complex(plan, values, transform) bind(c, name='fftw_execute_dft_r2c')
      import :: c_ptr
      implicit none
      type(c_ptr), value :: plan, values, transform
    end subroutine fftw_real_to_complex

    !> Transforms back as planned.
    subroutine fftw_complex_to_real(plan, transform, values) bind(c, name='fftw_execute_dft_c2r')
      import :: c_ptr
      implicit none
      type(c_ptr), value :: plan, transform, values
    end subroutine fftw_complex_to_real

    !> Frees a plan.
    subroutine fftw_destroy(plan) bind(c, name='fftw_destroy_plan')
      import :: c_ptr
      implicit none
      type(c_ptr), value :: plan
    end subroutine fftw_destroy
  end interface

end module asperity_fftw
