!> Interfaces to FFTW 3 (Frigo and Johnson, Proc. IEEE 93, 2005).
!>
!> Arrays are passed as addresses. Threads may execute plans at the same time; plans are made and
!> destroyed within `critical (fftw_plans)`. A plan may be executed on all arrays of `allocate`,
!> whose addresses are multiples of 16 bytes.
module asperity_fftw_calls
  use, intrinsic :: iso_c_binding, only: c_int, c_ptr
  implicit none
  private

  public :: fftw_estimate, fftw_forward, fftw_backward
  public :: fftw_plan_real_to_complex, fftw_plan_complex_to_real, fftw_plan_complex
  public :: fftw_real_to_complex, fftw_complex_to_real, fftw_complex, fftw_destroy

  !> A plan made without measuring: the same length gives the same plan, and so the same bytes.
  integer(c_int), parameter :: fftw_estimate = 64_c_int

  !> Signs of the exponent.
  integer(c_int), parameter :: fftw_forward = -1_c_int, fftw_backward = 1_c_int

  interface
    !> Plans a transform of `length` doubles to `length/2 + 1` numbers.
    type(c_ptr) function fftw_plan_real_to_complex(length, values, transform, flags) &
      bind(c, name='fftw_plan_dft_r2c_1d')
      import :: c_int, c_ptr
      implicit none
      integer(c_int), value :: length  !! length of the transform
      type(c_ptr), value :: values     !! address of doubles
      type(c_ptr), value :: transform  !! address of complex numbers
      integer(c_int), value :: flags   !! `fftw_estimate`
    end function fftw_plan_real_to_complex

    !> Plans the inverse transform. It overwrites the transform, and multiplies by `length`.
    type(c_ptr) function fftw_plan_complex_to_real(length, transform, values, flags) &
      bind(c, name='fftw_plan_dft_c2r_1d')
      import :: c_int, c_ptr
      implicit none
      integer(c_int), value :: length  !! length of the transform
      type(c_ptr), value :: transform  !! address of complex numbers
      type(c_ptr), value :: values     !! address of doubles
      integer(c_int), value :: flags   !! `fftw_estimate`
    end function fftw_plan_complex_to_real

    !> Plans a transform of `length` complex numbers; where `from` is `to`, in their place.
    type(c_ptr) function fftw_plan_complex(length, from, to, direction, flags) &
      bind(c, name='fftw_plan_dft_1d')
      import :: c_int, c_ptr
      implicit none
      integer(c_int), value :: length  !! length of the transform
      type(c_ptr), value :: from  !! address of complex numbers
      type(c_ptr), value :: to  !! address of complex numbers
      integer(c_int), value :: direction  !! `fftw_forward` or `fftw_backward`
      integer(c_int), value :: flags  !! `fftw_estimate`
    end function fftw_plan_complex

    !> Executes the transform of a plan.
    subroutine fftw_real_to_complex(plan, values, transform) bind(c, name='fftw_execute_dft_r2c')
      import :: c_ptr
      implicit none
      type(c_ptr), value :: plan  !! plan of one of the above
      type(c_ptr), value :: values  !! address of doubles
      type(c_ptr), value :: transform  !! address of complex numbers
    end subroutine fftw_real_to_complex

    !> Executes the inverse transform of a plan.
    subroutine fftw_complex_to_real(plan, transform, values) bind(c, name='fftw_execute_dft_c2r')
      import :: c_ptr
      implicit none
      type(c_ptr), value :: plan  !! plan of one of the above
      type(c_ptr), value :: transform  !! address of complex numbers
      type(c_ptr), value :: values  !! address of doubles
    end subroutine fftw_complex_to_real

    !> Executes the transform of a plan.
    subroutine fftw_complex(plan, from, to) bind(c, name='fftw_execute_dft')
      import :: c_ptr
      implicit none
      type(c_ptr), value :: plan  !! plan of one of the above
      type(c_ptr), value :: from  !! address of complex numbers
      type(c_ptr), value :: to    !! address of complex numbers
    end subroutine fftw_complex

    !> Frees a plan.
    subroutine fftw_destroy(plan) bind(c, name='fftw_destroy_plan')
      import :: c_ptr
      implicit none
      type(c_ptr), value :: plan  !! plan of one of the above
    end subroutine fftw_destroy
  end interface

end module asperity_fftw_calls
