!> Searches the pairs of two surfaces given in a file as the solver does, times it and writes them.
!>
!>     scale_search INPUT [OUTPUT [RUNS]]
!>
!> INPUT, all doubles as they stand in memory: number of upper asperities, of lower ones; height
!> that bounds pairs (Appendix 5), 1 to bound them by the radii alone, dx, dy, spacing of the
!> arithmetic at 1, least touch; then x, y, height and radius of the upper asperities, one array
!> after the other, and of the lower ones. OUTPUT: upper and lower indices of 4 bytes, all pairs
!> that an arithmetic of this spacing may count, and few others. With a least touch the least level
!> is searched that holds all above it.
program scale_search
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use asperity_kinds, only: int64, real64
  use asperity_pair_search_layers, only: found_pairs
  use asperity_pair_search_levels, only: build_levels, last_level, pair_levels, search_level, &
                                         surface_points
  implicit none

  integer, parameter :: phases = 2
  character(len=*), parameter :: names(phases) = ['order surfaces', 'search        ']
  real(real64) :: head(8), seconds(phases), best(phases), first(phases), best_sum
  type(surface_points) :: upper, lower
  type(found_pairs) :: found
  integer :: run, runs, i

  call read_input()
  best = huge(1.0_real64)
  best_sum = huge(1.0_real64)
  do run = 1, runs
    call time_search()
    if (run == 1) first = seconds
    if (sum(seconds) < best_sum) then
      best = seconds
      best_sum = sum(seconds)
    end if
  end do
  do i = 1, phases
    write (output_unit, '(a, 2(1x, f12.6))') names(i), best(i), first(i)
  end do
  write (output_unit, '(a, 1x, i0)') 'pairs', found%number
  write (output_unit, '(a, 1x, i0)') 'peak', peak_memory()
  call write_output()
  ! A sanitizer takes what a main program holds at its end for lost.
  deallocate (upper%x, upper%y, upper%height, upper%radius)
  deallocate (lower%x, lower%y, lower%height, lower%radius)
  if (allocated(found%block)) deallocate (found%block)

contains

  ! Phase by phase.
  subroutine time_search()
    type(pair_levels) :: levels
    integer(int64) :: clock(0:phases), rate
    integer :: level
    logical :: failed

    call system_clock(clock(0), rate)
    call build_levels(levels, upper, lower, head(3), head(7))
    call system_clock(clock(1))
    level = 1
    do while (levels%complete_from(level) > head(8) .and. level < last_level(levels))
      level = level + 1
    end do
    call search_level(levels, level, head(5), head(6), head(4) > 0.0_real64, head(8), found, failed)
    call stop_when(failed)
    call system_clock(clock(2))
    seconds = real(clock(1:) - clock(:phases - 1), real64) / real(rate, real64)
  end subroutine time_search

  subroutine read_input()
    character(len=1000) :: name
    integer :: unit, status

    call get_command_argument(1, name)
    open (newunit=unit, file=trim(name), access='stream', form='unformatted', status='old', &
          action='read', iostat=status)
    call stop_when(status /= 0)
    read (unit, iostat=status) head
    call stop_when(status /= 0)
    call read_surface(unit, int(head(1)), upper)
    call read_surface(unit, int(head(2)), lower)
    close (unit)
    runs = 1
    call get_command_argument(3, name)
    if (len_trim(name) > 0) read (name, *) runs
  end subroutine read_input

  subroutine read_surface(unit, n, surface)
    integer, intent(in) :: unit, n
    type(surface_points), intent(out) :: surface
    integer :: status

    allocate (surface%x(n), surface%y(n), surface%height(n), surface%radius(n))
    read (unit, iostat=status) surface%x, surface%y, surface%height, surface%radius
    call stop_when(status /= 0)
  end subroutine read_surface

  subroutine write_output()
    character(len=1000) :: name
    integer :: unit, k

    call get_command_argument(2, name)
    if (len_trim(name) == 0 .or. name == '-') return
    open (newunit=unit, file=trim(name), access='stream', form='unformatted', status='replace', &
          action='write')
    do k = 1, found%blocks
      write (unit) found%block(k)%upper(:found%block(k)%used)
    end do
    do k = 1, found%blocks
      write (unit) found%block(k)%lower(:found%block(k)%used)
    end do
    close (unit)
  end subroutine write_output

  ! Bytes resident at most, where the system tells.
  function peak_memory() result(peak)
    integer(int64) :: peak
    character(len=200) :: line
    integer :: unit, status

    peak = 0_int64
    open (newunit=unit, file='/proc/self/status', status='old', action='read', iostat=status)
    do while (status == 0)
      read (unit, '(a)', iostat=status) line
      if (status == 0 .and. line(:6) == 'VmHWM:') read (line(7:), *) peak
    end do
    peak = 1024_int64 * peak
  end function peak_memory

  subroutine stop_when(failed)
    logical, intent(in) :: failed

    if (.not. failed) return
    write (error_unit, '(a)') 'scale_search: no such input, or not enough memory'
    error stop 1
  end subroutine stop_when

end program scale_search
