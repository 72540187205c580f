!> Random positions on a rectangle that keep a least distance: random sequential addition.
!>
!> An asperity is placed at random; where it is nearer than the least distance to an earlier one,
!> another place is drawn, until one is free or the tries are used up (B. Widom, "Random sequential
!> addition of hard spheres to a volume", Journal of Chemical Physics 44 (1966) 3888-3894). The
!> place of try t of asperity k is a function of k and t alone. Earlier asperities are looked up in
!> cells, so the time grows in proportion to their number; cells do not change the result.
module asperity_random_positions
  use asperity_constants, only: pi
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text, real_text
  use asperity_random_philox, only: philox_block, scaled_words
  implicit none
  private

  public :: place_at_random, position_bytes

  !> Share of the area that discs of the least distance cover when random sequential addition can
  !> add no more: 0.5470 (E. L. Hinrichsen, J. Feder, T. Jossang, "Geometry of random sequential
  !> adsorption", Journal of Statistical Physics 44 (1986) 793-827).
  real(real64), parameter :: jamming = 0.547_real64

  !> Memory of an asperity during the search for positions [bytes], the positions included.
  integer(int64), parameter :: position_bytes = 32_int64

  !> Linked lists of the placed asperities of each cell: `first` of the cell, then `next`; 0 ends.
  type :: occupied_cells
    integer(int64) :: side = 1_int64  ! units, at least the least distance
    integer :: columns = 1, rows = 1
    integer, allocatable :: first(:), next(:)
  end type occupied_cells

contains

  !> Draws the positions. `failure` is allocated, with the reason, when they cannot be packed.
  pure subroutine place_at_random(key, stream, extent, least, tries, x, y, failure)
    integer(int64), intent(in) :: key(2)     !! key of the generator
    integer(int64), intent(in) :: stream(2)  !! last two words of the counter
    integer(int64), intent(in) :: extent(2)  !! length and width, units; positions from 0 on
    integer(int64), intent(in) :: least      !! least distance, units, below 2**31
    integer, intent(in) :: tries             !! largest number of tries for one asperity
    integer(int64), intent(out) :: x(:)      !! units, from 0 to the length
    integer(int64), intent(out) :: y(:)      !! units, from 0 to the width; as many as x
    character(len=:), allocatable, intent(out) :: failure  !! reason, when they cannot be packed
    type(occupied_cells) :: grid
    integer(int64) :: words(4)
    integer :: i, attempt, cell
    logical :: is_free

    if (real(size(x), real64) > most_points(extent, least)) then
      failure = 'cannot be packed: found ' // decimal_text(size(x)) // ' asperities, expected ' // &
                'at most ' // decimal_text(int(most_points(extent, least))) // &
                ', as no arrangement with the least distance holds more'
      return
    end if
    call make_grid(extent, least, size(x), grid)
    do i = 1, size(x)
      do attempt = 1, tries
        words = philox_block([int(i, int64), int(attempt, int64), stream], key)
        x(i) = scaled_words(words(1:2), extent(1) + 1_int64)
        y(i) = scaled_words(words(3:4), extent(2) + 1_int64)
        is_free = least == 0_int64
        if (.not. is_free) is_free = has_room(grid, x, y, i, least)
        if (is_free) exit
      end do
      if (.not. is_free) then
        failure = 'cannot be packed: found room for ' // decimal_text(i - 1) // ' of ' // &
                  decimal_text(size(x)) // ' asperities, and none for the next in ' // &
                  decimal_text(tries) // ' tries, expected a smaller least distance, fewer ' // &
                  'asperities'
        call add_remedy(extent, least, size(x), failure)
        return
      end if
      if (least == 0_int64) cycle
      cell = 1 + int(x(i) / grid%side) + int(y(i) / grid%side) * grid%columns
      grid%next(i) = grid%first(cell)
      grid%first(cell) = i
    end do
  end subroutine place_at_random

  !> Divides the area into square cells, no smaller than the least distance and about as many as the
  !> asperities.
  pure subroutine make_grid(extent, least, number, grid)
    integer(int64), intent(in) :: extent(2), least
    integer, intent(in) :: number
    type(occupied_cells), intent(out) :: grid
    real(real64) :: mean_side

    if (least == 0_int64) then
      allocate (grid%first(0), grid%next(0))
      return
    end if
    mean_side = sqrt(real(extent(1), real64)) * sqrt(real(extent(2), real64) / real(number, real64))
    grid%side = max(least, int(mean_side, int64), maxval(extent) / int(number, int64)) + 1_int64
    grid%columns = int(extent(1) / grid%side) + 1
    grid%rows = int(extent(2) / grid%side) + 1
    allocate (grid%first(grid%columns * grid%rows), grid%next(number))
    grid%first = 0
  end subroutine make_grid

  !> Whether position `i` keeps the distance to all that are in the grid.
  pure logical function has_room(grid, x, y, i, least)
    type(occupied_cells), intent(in) :: grid
    integer(int64), intent(in) :: x(:), y(:), least
    integer, intent(in) :: i
    integer(int64) :: across, along
    integer :: column, row, other, from, to

    has_room = .false.
    along = x(i) / grid%side
    across = y(i) / grid%side
    from = max(0, int(along) - 1)
    to = min(grid%columns - 1, int(along) + 1)
    do row = max(0, int(across) - 1), min(grid%rows - 1, int(across) + 1)
      do column = from, to
        other = grid%first(1 + column + row * grid%columns)
        do while (other > 0)
          along = abs(x(other) - x(i))
          across = abs(y(other) - y(i))
          ! Larger differences need no square, which might overflow.
          if (max(along, across) < least) then
            if (along * along + across * across < least * least) return
          end if
          other = grid%next(other)
        end do
      end do
    end do
    has_room = .true.
  end function has_room

  !> Upper bound of the number of points that keep the distance d on a convex area A of perimeter P:
  !> 2 A/(sqrt(3) d**2) + P/(2 d) + 1 (N. Oler, "An inequality in the geometry of numbers", Acta
  !> Mathematica 105 (1961) 19-48).
  pure real(real64) function most_points(extent, least)
    integer(int64), intent(in) :: extent(2), least
    real(real64) :: sides(2)

    most_points = huge(1.0_real64)
    if (least == 0_int64) return
    sides = real(extent, real64) / real(least, real64)
    most_points = 2 / sqrt(3.0_real64) * sides(1) * sides(2) + sides(1) + sides(2) + 1
    ! Allowance for rounding.
    most_points = most_points * (1 + 1.0e-9_real64)
  end function most_points

  !> Remedy for the message: more tries, or the coverage where random placing nearly fills the
  !> surface.
  pure subroutine add_remedy(extent, least, number, failure)
    integer(int64), intent(in) :: extent(2), least
    integer, intent(in) :: number
    character(len=:), allocatable, intent(inout) :: failure
    real(real64) :: covered

    ! Discs extend beyond the edge, so a small area holds more than a large one in proportion.
    covered = pi / 4 * real(number, real64) / &
              ((real(extent(1), real64) / real(least, real64) + 1) * &
               (real(extent(2), real64) / real(least, real64) + 1))
    if (covered <= jamming .or. covered > 10) then
      failure = failure // ' or more tries'
    else
      failure = failure // ': their discs would cover ' // real_text(covered, 'f5.3') // &
                ' of the area, random placing ends near ' // real_text(jamming, 'f5.3')
    end if
  end subroutine add_remedy

end module asperity_random_positions
