!> Largest distance in plan at which two asperities count as a pair.
module asperity_cell_reach
  use asperity_kinds, only: real64
  implicit none
  private

  public :: any_height, margin_of_arithmetic, squared_reach

  !> No bound by height: every pair whose spheres can touch counts.
  real(real64), parameter :: any_height = huge(1.0_real64)

contains

  !> Upper bound of d**2, where d is the distance of two summits in plan. The sum of the radii
  !> s = RU + RL always bounds d: spheres farther apart cannot touch. The thesis bounds it by the
  !> largest height (Appendix 5), d**2 < 2 s height: a larger offset in plan reduces the height of
  !> contact by more than that. Zero when no pair can count.
  elemental real(real64) function squared_reach(height, s) result(bound)
    real(real64), intent(in) :: height  !! largest height; `any_height`: no such bound
    real(real64), intent(in) :: s       !! sum of the radii, more than 0

    bound = s * s
    ! The comparison comes first, so that a huge height does not overflow.
    if (height < s) bound = min(bound, max((s + s) * height, 0.0_real64))
  end function squared_reach

  !> Bound of the rounding of a distance in an arithmetic [length].
  !>
  !> An arithmetic rounds displaced positions (once each axis), their difference, the square of the
  !> distance and the bound (a few times each): less than 8 units of the last place of the largest
  !> length.
  elemental real(real64) function margin_of_arithmetic(unit, extent) result(margin)
    real(real64), intent(in) :: unit    !! spacing at 1 of its numbers: 2**-23, 16**-5, ...
    real(real64), intent(in) :: extent  !! upper bound of |x| + |y| + |dx| + |dy| + s

    margin = 8.0_real64 * max(unit, epsilon(unit)) * extent
  end function margin_of_arithmetic

end module asperity_cell_reach
