!> One surface sorted by x, for the search of neighbours among few asperities.
module asperity_pair_search_row
  use asperity_key_sort, only: sort_keys
  use asperity_kinds, only: int32, real64
  implicit none
  private

  public :: summit_row
  public :: build_row, first_from

  !> Asperities in the order of x.
  type :: summit_row
    real(real64), allocatable :: x(:)           !! positions along x, ascending
    real(real64), allocatable :: y(:)           !! positions along y
    integer(int32), allocatable :: asperity(:)  !! number of the asperity in its surface, from 1
  end type summit_row

contains

  !> Sorts a surface by x.
  subroutine build_row(row, x, y)
    type(summit_row), intent(out) :: row          !! the sorted surface
    real(real64), contiguous, intent(in) :: x(:)  !! positions along x, finite
    real(real64), contiguous, intent(in) :: y(:)  !! positions along y, as many as x

    allocate (row%x(size(x)), row%y(size(x)), row%asperity(size(x)))
    call sort_keys(x, row%asperity)
    row%x(:) = x(row%asperity)
    row%y(:) = y(row%asperity)
  end subroutine build_row

  !> Index of the first asperity of the row that is not left of `x`; size + 1 when there is none.
  pure integer function first_from(row, x) result(low)
    type(summit_row), intent(in) :: row  !! the sorted surface
    real(real64), intent(in) :: x        !! position along x, length
    integer :: high, middle

    low = 1
    high = size(row%x) + 1
    do while (low < high)
      middle = (low + high) / 2
      if (row%x(middle) < x) then
        low = middle + 1
      else
        high = middle
      end if
    end do
  end function first_from

end module asperity_pair_search_row
