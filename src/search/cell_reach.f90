!> How near two asperities must be in plan to count as a pair.
module asperity_cell_reach
  use asperity_kinds, only: real64
  implicit none
  private

  public :: pair_reach, squared_reach

  !> Three bounds on the distance d of two summits in plan; the least holds. The sum of the radii
  !> s = RU + RL always bounds it: spheres farther apart cannot touch. The thesis bounds it by the
  !> largest height (Appendix 5): what is farther loses more than that to its offset in plan.
  type :: pair_reach
    real(real64) :: distance = huge(1.0_real64)  !! d < distance; huge: no such bound
    real(real64) :: height = huge(1.0_real64)    !! d**2 < 2 s height (Appendix 5)
  end type pair_reach

contains

  !> The bound on d**2 for a pair: d**2 must be less. Zero when no pair can count.
  elemental function squared_reach(reach, s) result(bound)
    type(pair_reach), intent(in) :: reach  !! the bounds
    real(real64), intent(in) :: s          !! sum of the radii, more than 0
    real(real64) :: bound

    bound = s * s
    ! Compared as ratios first, so that a huge bound overflows nothing.
    if (reach%distance < s) bound = max(reach%distance, 0.0_real64)**2
    if (reach%height < s) bound = min(bound, max((s + s) * reach%height, 0.0_real64))
  end function squared_reach

end module asperity_cell_reach
