!> How near two asperities must be in plan to count as a pair.
module asperity_cell_reach
  use asperity_kinds, only: real64
  implicit none
  private

  public :: any_height, margin_of_arithmetic, squared_reach

  !> No bound by height: every pair whose spheres can touch counts.
  real(real64), parameter :: any_height = huge(1.0_real64)

contains

  !> The bound on d**2, d the distance of two summits in plan: d**2 must be less. The sum of the
  !> radii s = RU + RL always bounds d: spheres farther apart cannot touch. The thesis bounds it by
  !> the largest height (Appendix 5), d**2 < 2 s height: what is farther loses more than that to its
  !> offset in plan. Zero when no pair can count.
  elemental function squared_reach(height, s) result(bound)
    real(real64), intent(in) :: height  !! `any_height`: no such bound
    real(real64), intent(in) :: s       !! sum of the radii, more than 0
    real(real64) :: bound

    bound = s * s
    ! Compared as a ratio first, so that a huge bound overflows nothing.
    if (height < s) bound = min(bound, max((s + s) * height, 0.0_real64))
  end function squared_reach

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

end module asperity_cell_reach
