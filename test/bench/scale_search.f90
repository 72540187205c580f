!> Searches the pairs of two surfaces given in a file, times it and writes the pairs.
!>
!>     scale_search INPUT [OUTPUT [RUNS]]
!>
!> INPUT, all doubles as they stand in memory: number of upper asperities, of lower ones; distance
!> and height of the reach (huge: no such bound), dx, dy, margin, least touch, most pairs (0: all);
!> then x, y, height and radius of the upper asperities, one array after the other, and of the
!> lower ones. With a negative margin pairs are wanted in the order of touch, else candidates.
!> OUTPUT: upper and lower indices (4 bytes each), and without a margin touch and squared distance.
program scale_search
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use asperity_cell_grid, only: build_grid, cell_grid, grid_bytes
  use asperity_cell_reach, only: pair_reach
  use asperity_kinds, only: int32, int64, real64
  use asperity_pair_search, only: find_candidate_pairs, find_touching_pairs, found_pair
  implicit none

  integer, parameter :: phases = 3
  character(len=*), parameter :: names(phases) = ['order surfaces', 'search        ', &
                                                  'sort          ']
  real(real64) :: head(9), seconds(phases), best(phases), first(phases), best_sum
  real(real64), allocatable :: upper(:, :), lower(:, :)
  type(found_pair), allocatable :: list(:)
  integer(int32), allocatable :: uppers(:), lowers(:)
  type(pair_reach) :: reach
  integer(int64) :: bytes, pairs
  integer :: run, runs, i

  call read_input()
  best = huge(1.0_real64)
  best_sum = huge(1.0_real64)
  do run = 1, runs
    if (head(7) < 0.0_real64) then
      call time_touching()
    else
      call time_candidates()
    end if
    if (run == 1) first = seconds
    if (sum(seconds) < best_sum) then
      best = seconds
      best_sum = sum(seconds)
    end if
  end do
  do i = 1, phases
    write (output_unit, '(a, 2(1x, f12.6))') names(i), best(i), first(i)
  end do
  write (output_unit, '(a, 1x, i0)') 'pairs', pairs
  write (output_unit, '(a, 1x, i0)') 'bytes', bytes
  write (output_unit, '(a, 1x, i0)') 'peak', peak_memory()
  call write_output()
  ! A sanitizer takes what a main program holds at its end for lost.
  deallocate (upper, lower)
  if (allocated(list)) deallocate (list)
  if (allocated(uppers)) deallocate (uppers, lowers)

contains

  ! In the order of touch, phase by phase.
  subroutine time_touching()
    use asperity_pair_search_blocks, only: found_pairs
    use asperity_pair_search_layers, only: search_pairs
    use asperity_pair_search_order, only: order_by_touch
    type(cell_grid) :: above, below
    type(found_pairs) :: found
    integer(int64) :: clock(0:phases)
    integer :: most
    logical :: failed

    most = huge(most)
    if (head(9) > 0.0_real64) most = int(head(9))
    call system_clock(clock(0))
    call order_surfaces(above, below)
    call system_clock(clock(1))
    call search_pairs(above, below, head(5), head(6), reach, 0.0_real64, head(8), found, failed)
    call stop_when(failed)
    bytes = grid_bytes(above) + grid_bytes(below) + 24_int64 * 65536_int64 * found%blocks
    call system_clock(clock(2))
    call order_by_touch(found, above, below, most, list, failed)
    call stop_when(failed)
    call system_clock(clock(3))
    pairs = size(list, kind=int64)
    bytes = bytes + 24_int64 * pairs
    call take_times(clock)
  end subroutine time_touching

  ! As the solver asks for candidates; the sort is part of the search here.
  subroutine time_candidates()
    type(cell_grid) :: above, below
    character(len=:), allocatable :: failure
    integer(int64) :: clock(0:phases)

    call system_clock(clock(0))
    call order_surfaces(above, below)
    call system_clock(clock(1))
    call find_candidate_pairs(above, below, head(5), head(6), reach, head(7), head(8), uppers, &
                              lowers, failure)
    call stop_when(allocated(failure))
    call system_clock(clock(2))
    clock(3) = clock(2)
    pairs = size(uppers, kind=int64)
    bytes = grid_bytes(above) + grid_bytes(below) + 8_int64 * pairs
    call take_times(clock)
  end subroutine time_candidates

  subroutine order_surfaces(above, below)
    type(cell_grid), intent(out) :: above, below

    call build_grid(below, lower(:, 1), lower(:, 2), lower(:, 3), lower(:, 4), reach)
    call build_grid(above, upper(:, 1), upper(:, 2), upper(:, 3), upper(:, 4), reach)
  end subroutine order_surfaces

  subroutine take_times(clock)
    integer(int64), intent(in) :: clock(0:)
    integer(int64) :: rate

    call system_clock(count_rate=rate)
    seconds = real(clock(1:) - clock(:phases - 1), real64) / real(rate, real64)
  end subroutine take_times

  subroutine read_input()
    character(len=1000) :: name
    integer :: unit, status

    call get_command_argument(1, name)
    open (newunit=unit, file=trim(name), access='stream', form='unformatted', status='old', &
          action='read', iostat=status)
    call stop_when(status /= 0)
    read (unit, iostat=status) head
    call stop_when(status /= 0)
    reach%distance = head(3)
    reach%height = head(4)
    allocate (upper(int(head(1)), 4), lower(int(head(2)), 4))
    read (unit, iostat=status) upper, lower
    call stop_when(status /= 0)
    close (unit)
    runs = 1
    call get_command_argument(3, name)
    if (len_trim(name) > 0) read (name, *) runs
  end subroutine read_input

  subroutine write_output()
    character(len=1000) :: name
    integer :: unit

    call get_command_argument(2, name)
    if (len_trim(name) == 0 .or. name == '-') return
    open (newunit=unit, file=trim(name), access='stream', form='unformatted', status='replace', &
          action='write')
    if (head(7) < 0.0_real64) then
      write (unit) list%upper, list%lower, list%touch, list%squared
    else
      write (unit) uppers, lowers
    end if
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
