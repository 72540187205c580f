!> Fourier transforms of lines, by FFTW 3 (Frigo and Johnson, Proc. IEEE 93, 2005).
!>
!> Plans are made without measuring: the same length gives the same plan, and so the same bytes.
!> Threads may apply a transform at the same time, to all arrays of `allocate`, whose addresses are
!> multiples of 16 bytes.
module asperity_line_transform
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_double_complex, c_int, c_loc, &
                                         c_null_ptr, c_ptr
  use asperity_kinds, only: int64
  implicit none
  private

  public :: line_transform, real_to_waves, waves_to_real, waves_forward, waves_back, &
            back_in_place, bytes_of_plans, thread_threshold

  !> Directions: of `length` doubles to length/2 + 1 waves; the inverse, which overwrites the waves
  !> and multiplies by the length; of complex numbers to another place, and their inverse.
  integer, parameter :: real_to_waves = 1, waves_to_real = 2, waves_forward = 3, waves_back = 4
  integer, parameter :: back_in_place = 5  !! inverse in the place of the waves
  !> Bytes besides the values, to be available before plans are made (chosen, a small plan takes
  !> some kilobytes): FFTW ends the process where it gets none.
  integer(int64), parameter :: bytes_of_plans = 131072_int64
  !> Number of values above which threads share a loop over them (chosen).
  integer, parameter :: thread_threshold = 30000

  !> Transform of lines of one length. It owns its plan: it must not be copied.
  type :: line_transform
    private
    integer :: direction = 0
    type(c_ptr) :: plan = c_null_ptr
  contains
    procedure :: prepare => prepare_transform  !! makes the plan
    procedure :: apply => transform_line       !! transforms a line
    final :: destroy_plan
  end type line_transform

  integer(c_int), parameter :: without_measuring = 64_c_int

  abstract interface
    subroutine execute_plan(plan, from, to) bind(c)
      import :: c_ptr
      implicit none
      type(c_ptr), value :: plan, from, to
    end subroutine execute_plan
  end interface

  procedure(execute_plan), bind(c, name='fftw_execute_dft_r2c') :: execute_real_to_complex
  procedure(execute_plan), bind(c, name='fftw_execute_dft_c2r') :: execute_complex_to_real
  procedure(execute_plan), bind(c, name='fftw_execute_dft') :: execute_complex

  interface
    type(c_ptr) function plan_real_to_complex(length, from, to, flags) &
      bind(c, name='fftw_plan_dft_r2c_1d')
      import :: c_int, c_ptr
      implicit none
      integer(c_int), value :: length, flags
      type(c_ptr), value :: from, to
    end function plan_real_to_complex

    type(c_ptr) function plan_complex_to_real(length, from, to, flags) &
      bind(c, name='fftw_plan_dft_c2r_1d')
      import :: c_int, c_ptr
      implicit none
      integer(c_int), value :: length, flags
      type(c_ptr), value :: from, to
    end function plan_complex_to_real

    type(c_ptr) function plan_complex(length, from, to, direction, flags) &
      bind(c, name='fftw_plan_dft_1d')
      import :: c_int, c_ptr
      implicit none
      integer(c_int), value :: length, direction, flags
      type(c_ptr), value :: from, to
    end function plan_complex

    subroutine destroy(plan) bind(c, name='fftw_destroy_plan')
      import :: c_ptr
      implicit none
      type(c_ptr), value :: plan
    end subroutine destroy
  end interface

contains

  !> Makes the plan.
  subroutine prepare_transform(self, direction, length)
    class(line_transform), intent(inout) :: self  !! transform without a plan
    integer, intent(in) :: direction              !! one of those above
    integer, intent(in) :: length                 !! number of values of a line, 1 or more
    real(c_double), allocatable, target :: values(:)
    complex(c_double_complex), allocatable, target :: waves(:), others(:)

    self%direction = direction
    allocate (values(length + 2), waves(length + 2), others(length))
    associate (line => c_loc(values), to => c_loc(waves), n => int(length, c_int))
      !$omp critical (fftw_plans)
      select case (direction)
      case (real_to_waves)
        self%plan = plan_real_to_complex(n, line, to, without_measuring)
      case (waves_to_real)
        self%plan = plan_complex_to_real(n, to, line, without_measuring)
      case (back_in_place)
        self%plan = plan_complex(n, to, to, 1_c_int, without_measuring)
      case default
        self%plan = plan_complex(n, to, c_loc(others), merge(-1_c_int, 1_c_int, &
                                 direction == waves_forward), without_measuring)
      end select
      !$omp end critical (fftw_plans)
    end associate
  end subroutine prepare_transform

  !> Transforms a line.
  subroutine transform_line(self, from, to)
    class(line_transform), intent(in) :: self  !! transform with its plan
    type(c_ptr), intent(in) :: from            !! address of the values
    type(c_ptr), intent(in) :: to              !! address of their transform

    select case (self%direction)
    case (real_to_waves)
      call execute_real_to_complex(self%plan, from, to)
    case (waves_to_real)
      call execute_complex_to_real(self%plan, from, to)
    case default
      call execute_complex(self%plan, from, to)
    end select
  end subroutine transform_line

  ! Releases the plan.
  impure elemental subroutine destroy_plan(self)
    type(line_transform), intent(inout) :: self

    if (.not. c_associated(self%plan)) return
    !$omp critical (fftw_plans)
    call destroy(self%plan)
    !$omp end critical (fftw_plans)
    self%plan = c_null_ptr
  end subroutine destroy_plan

end module asperity_line_transform
