!> The vertical gap between two spheres near the place where they touch first.
!>
!> Written from that place, with the square roots through their conjugates: a penetration of 1e-12
!> of the radius keeps its digits.
module asperity_cells_gap
  use asperity_contact_pairs, only: contact_pair
  use asperity_kinds, only: real64
  implicit none
  private

  public :: gap_shape, shape_of_gap, gap_at, gap_nowhere

  !> Gap beside the spheres. Far more than any height.
  real(real64), parameter :: gap_nowhere = 1.0e6_real64

  ! Height of a centre over a plane: nothing curves.
  real(real64), parameter :: far_above = 1.0e150_real64

  !> The gap of one pair. Lengths in the unit of the pairs.
  type :: gap_shape
    integer :: pair = 0                             !! place in the list of pairs
    real(real64) :: x = 0.0_real64                  !! place in plan of first touch
    real(real64) :: y = 0.0_real64                  !! place in plan of first touch
    real(real64) :: penetration = 0.0_real64        !! vertical, past first touch; more than 0
    real(real64) :: reach = 0.0_real64              !! no gap is below 0 farther than that from it
    real(real64) :: contact_radius = 0.0_real64     !! of Hertz, the slope left out
    real(real64) :: cosine = 1.0_real64             !! of the slope at first touch
    real(real64) :: curvature_radius = 0.0_real64   !! 1/R = 1/RU + 1/RL
    real(real64) :: upper(2) = 0.0_real64           !! from the upper centre to the touch, in plan
    real(real64) :: lower(2) = 0.0_real64           !! from the lower centre to the touch, in plan
    real(real64) :: upper_height = 0.0_real64       !! from the upper centre to the touch
    real(real64) :: lower_height = 0.0_real64       !! from the lower centre to the touch
  end type gap_shape

contains

  !> The shape of a pair's gap at a penetration.
  pure function shape_of_gap(pair, number, penetration) result(shape)
    type(contact_pair), intent(in) :: pair        !! who touches
    integer, intent(in) :: number                 !! its place in the list of pairs
    real(real64), intent(in) :: penetration       !! more than 0, less than the pair's zc
    type(gap_shape) :: shape
    real(real64) :: apart(2), share

    apart = [pair%lower_x - pair%upper_x, pair%lower_y - pair%upper_y]
    share = pair%upper_radius / pair%s
    shape%pair = number
    shape%penetration = penetration
    shape%cosine = pair%zc / pair%s
    shape%upper = share * apart
    shape%lower = -(pair%lower_radius / pair%s) * apart
    shape%x = pair%upper_x + shape%upper(1)
    shape%y = pair%upper_y + shape%upper(2)
    shape%upper_height = pair%upper_radius * shape%cosine
    shape%lower_height = pair%lower_radius * shape%cosine
    shape%curvature_radius = share * pair%lower_radius
    if (.not. min(pair%upper_radius, pair%lower_radius) > 0.0_real64) then
      shape%curvature_radius = pair%radius
      if (.not. pair%upper_radius > 0.0_real64) shape%upper_height = far_above
      if (.not. pair%lower_radius > 0.0_real64) shape%lower_height = far_above
    end if
    ! Both spheres curve by 1/radius at least everywhere: gap >= s**2/(2 R) - penetration.
    shape%contact_radius = sqrt(shape%curvature_radius * penetration)
    shape%reach = sqrt(2.0_real64) * shape%contact_radius
  end function shape_of_gap

  !> The gap before any deformation; less than 0 where the undeformed spheres overlap.
  pure function gap_at(shape, x, y) result(gap)
    type(gap_shape), intent(in) :: shape  !! whose gap
    real(real64), intent(in) :: x         !! from the place of first touch
    real(real64), intent(in) :: y         !! from the place of first touch
    real(real64) :: gap, square, upper, lower

    gap = gap_nowhere
    square = x * x + y * y
    upper = 2.0_real64 * (shape%upper(1) * x + shape%upper(2) * y) + square
    lower = 2.0_real64 * (shape%lower(1) * x + shape%lower(2) * y) + square
    ! Beside one of the spheres.
    if (upper >= shape%upper_height**2 .or. lower >= shape%lower_height**2) return
    gap = upper / (shape%upper_height + sqrt(shape%upper_height**2 - upper)) + &
          lower / (shape%lower_height + sqrt(shape%lower_height**2 - lower)) - shape%penetration
  end function gap_at

end module asperity_cells_gap
