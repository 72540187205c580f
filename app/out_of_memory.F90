! A sanitizer brings procedures of its own, and must keep them.
#ifdef ASPERITY_SANITIZED
#define MALLOC 'asperity_malloc'
#define MEMALIGN 'asperity_memalign'
#define REALLOC 'asperity_realloc'
#else
#define MALLOC 'malloc'
#define MEMALIGN 'memalign'
#define REALLOC 'realloc'
#endif
!> What the program does when memory ends where nobody asked for it beforehand: it says so, leaves
!> no file that is not whole, and ends with status 1.
!>
!> gfortran's code takes memory in many places that no `stat=` reaches: a left side that grows, a
!> copy of a derived type, an array that an expression makes. It looks at none of these answers,
!> and the run-time library and FFTW have words of their own for the rest. So the program takes the
!> place of the procedures of the C library through which all of them go; what they do is what the
!> library does. The library's `allocate` with `stat=` serves programs that link to it.
module asperity_out_of_memory
  use, intrinsic :: iso_c_binding, only: c_associated, c_int, c_null_ptr, c_ptr, c_size_t
  use asperity_output_files, only: end_without_output
  implicit none
  private

  public :: memory, memory_again, memory_at

  ! As the C library's own memory is aligned.
  integer(c_size_t), parameter :: alignment = 16_c_size_t

  character(len=*), parameter :: sentence = 'not enough memory, no output written: expected ' // &
    'fewer asperities, positions or states, coarser cells, or more memory'

  interface
    integer(c_int) function aligned_memory(block, boundary, bytes) bind(c, name='posix_memalign')
      import :: c_int, c_ptr, c_size_t
      implicit none
      type(c_ptr), intent(out) :: block
      integer(c_size_t), value :: boundary, bytes
    end function aligned_memory

    integer(c_size_t) function usable_size(block) bind(c, name='malloc_usable_size')
      import :: c_ptr, c_size_t
      implicit none
      type(c_ptr), value :: block
    end function usable_size

    type(c_ptr) function copy(to, from, bytes) bind(c, name='memcpy')
      import :: c_ptr, c_size_t
      implicit none
      type(c_ptr), value :: to, from
      integer(c_size_t), value :: bytes
    end function copy

    subroutine give_back(block) bind(c, name='free')
      import :: c_ptr
      implicit none
      type(c_ptr), value :: block
    end subroutine give_back
  end interface

contains

  !> The C library's `malloc`, which does not return without memory.
  type(c_ptr) function memory(bytes) bind(c, name=MALLOC)
    integer(c_size_t), value :: bytes  !! so many

    memory = memory_at(alignment, bytes)
  end function memory

  !> The C library's `memalign`, which FFTW calls, likewise.
  type(c_ptr) function memory_at(boundary, bytes) bind(c, name=MEMALIGN)
    integer(c_size_t), value :: boundary  !! a power of two: the place is a multiple of it
    integer(c_size_t), value :: bytes     !! so many

    if (aligned_memory(memory_at, boundary, bytes) == 0_c_int) return
    ! The first thread tells it for all.
    !$omp critical (asperity_out_of_memory)
    call end_without_output(sentence)
    !$omp end critical (asperity_out_of_memory)
  end function memory_at

  !> The C library's `realloc`, likewise.
  type(c_ptr) function memory_again(block, bytes) bind(c, name=REALLOC)
    type(c_ptr), value :: block        !! given before, or null
    integer(c_size_t), value :: bytes  !! so many
    type(c_ptr) :: same

    if (c_associated(block) .and. bytes == 0_c_size_t) then
      call give_back(block)
      memory_again = c_null_ptr
      return
    end if
    memory_again = memory(bytes)
    if (.not. c_associated(block)) return
    same = copy(memory_again, block, min(bytes, usable_size(block)))
    call give_back(block)
  end function memory_again

end module asperity_out_of_memory
