!> The pairs of two surfaces at one position, at a cost in proportion to asperities and pairs.
!>
!> Both surfaces are put in order once (`build_grid`); every position is then searched as it is.
!> See docs/large-surfaces.md.
module asperity_pair_search
  use asperity_cell_grid, only: cell_grid
  use asperity_cell_reach, only: pair_reach
  use asperity_kinds, only: int32, real64
  use asperity_pair_search_blocks, only: found_pair, found_pairs
  use asperity_pair_search_index, only: order_by_index
  use asperity_pair_search_layers, only: search_pairs
  use asperity_pair_search_order, only: order_by_touch
  implicit none
  private

  public :: found_pair
  public :: find_candidate_pairs, find_touching_pairs, margin_of_arithmetic

  character(len=*), parameter :: no_memory = 'not enough memory for the pairs of a position'

contains

  !> Pairs in the order in which they touch: by gap, and equal gaps as the solver has it (d, s,
  !> combined radius, upper, lower). All in doubles, by the solver's formulas.
  subroutine find_touching_pairs(upper, lower, dx, dy, reach, floor, most, list, failure)
    type(cell_grid), intent(in) :: upper                   !! the surface displaced
    type(cell_grid), intent(in) :: lower                   !! the other surface
    real(real64), intent(in) :: dx                         !! displacement, unit of the surfaces
    real(real64), intent(in) :: dy                         !! displacement, unit of the surfaces
    type(pair_reach), intent(in) :: reach                  !! how near pairs are
    real(real64), intent(in) :: floor                      !! least touch; -huge: any
    integer, intent(in) :: most                            !! the first so many; huge: all
    type(found_pair), allocatable, intent(out) :: list(:)  !! ascending gap, descending touch
    character(len=:), allocatable, intent(out) :: failure  !! allocated when memory ran out
    type(found_pairs) :: found
    logical :: failed

    call search_pairs(upper, lower, dx, dy, reach, 0.0_real64, floor, found, failed)
    if (.not. failed) call order_by_touch(found, upper, lower, most, list, failed)
    if (failed) failure = no_memory
  end subroutine find_touching_pairs

  !> Pairs that another arithmetic may count as near enough and as touching above the floor, and
  !> few others, in the order of a search that compares all with all: by upper, then lower index.
  subroutine find_candidate_pairs(upper, lower, dx, dy, reach, margin, floor, uppers, lowers, &
                                  failure)
    type(cell_grid), intent(in) :: upper                   !! the surface displaced
    type(cell_grid), intent(in) :: lower                   !! the other surface
    real(real64), intent(in) :: dx                         !! displacement, unit of the surfaces
    real(real64), intent(in) :: dy                         !! displacement, unit of the surfaces
    type(pair_reach), intent(in) :: reach                  !! how near pairs are
    real(real64), intent(in) :: margin                     !! `margin_of_arithmetic`
    real(real64), intent(in) :: floor                      !! least touch, less what the heights'
                                                           !! rounding may add; -huge: any
    integer(int32), allocatable, intent(out) :: uppers(:)  !! indices from 1, ascending
    integer(int32), allocatable, intent(out) :: lowers(:)  !! as many, ascending for one upper
    character(len=:), allocatable, intent(out) :: failure  !! allocated when memory ran out
    type(found_pairs) :: found
    logical :: failed

    call search_pairs(upper, lower, dx, dy, reach, margin, floor, found, failed)
    if (.not. failed) call order_by_index(found, size(upper%radius), uppers, lowers, failed)
    if (failed) failure = no_memory
  end subroutine find_candidate_pairs

  !> How much farther apart than in doubles an arithmetic may let a pair be.
  !>
  !> It rounds displaced places (once each axis), their difference, the square of the distance and
  !> the bound (a few times each): less than 8 units of the last place of the largest length.
  elemental function margin_of_arithmetic(unit, extent) result(margin)
    real(real64), intent(in) :: unit    !! spacing at 1 of its numbers: 2**-23, 16**-5, ...
    real(real64), intent(in) :: extent  !! largest |x| + |y| + |dx| + |dy| + sum of radii, at least
    real(real64) :: margin

    margin = 8.0_real64 * max(unit, epsilon(unit)) * extent
  end function margin_of_arithmetic

end module asperity_pair_search
