!> A scene in the units of the solver, and the pairs of its positions.
!>
!> Lengths are held in a unit of 2**n near the largest radius and the combined modulus in a unit of
!> 2**m, so that no scale of the scene can overflow or underflow; changing units is exact.
!>
!> A position is described by its compression c, the decrease of the separation since its first pair
!> touched. A pair touches at the separation `touch`; its gap at first touch is
!> g = max(touch) - touch and its penetration p = c - g. Positions are independent.
module asperity_placed_scene
  use asperity_kinds, only: int32, real64
  use asperity_loading_controls, only: control_limit, loading_control
  use asperity_pair_search_levels, only: pair_levels
  use asperity_scene_values, only: criterion_none
  use asperity_theory_limits, only: theory_limits
  implicit none
  private

  public :: candidate, placed_scene, position_pairs
  public :: is_on_plane, largest_value, load_unit, place_of_touch

  !> A scene in the units of the solver.
  type :: placed_scene
    type(theory_limits) :: limits                  !! limits of the theories
    real(real64), allocatable :: cap_u(:), cap_l(:)  !! heights of summits above their planes
    integer :: length_power = 0                    !! unit of length is 2**length_power
    real(real64) :: out_of_reach                   !! height of a plane: 2**20 largest radii
    integer :: modulus_power = 0                   !! unit of the combined modulus
    real(real64) :: modulus                        !! combined modulus
    real(real64), allocatable :: xu(:), yu(:), hu(:), ru(:)  !! upper: place, summit level, radius
    real(real64), allocatable :: xl(:), yl(:), hl(:), rl(:)  !! lower, mirrored on request
    logical :: is_deck = .false.                   !! the surfaces are those of a card deck
    logical :: on_plane = .false.                  !! one surface is a plane without asperities
    real(real64) :: plane_slope(2)                 !! of that plane
    real(real64), allocatable :: level(:)          !! summits of the caps on a plane
    integer(int32), allocatable :: order(:)        !! these caps, the highest first
    real(real64) :: height_max                     !! largest height of both surfaces
    ! Pairs outside the candidate distance touch below this separation only: their offset in plan
    ! reduces the separation of first touch by more than the largest height.
    real(real64) :: complete_above
    real(real64) :: x_first, x_step, y_first, y_step     !! displacement of the upper surface
    type(loading_control) :: control = control_limit  !! quantity that ends a position
    real(real64) :: target                         !! its value: separation, compression or load
    integer :: points = 0                          !! equal parts of the compression; 0, 1: its end
    logical :: events = .false.                    !! a state at each first touch as well
    integer :: criterion = criterion_none
    real(real64) :: limit                          !! load, or overlap over radius
    ! Search for pairs: all with all in small scenes, else level by level.
    type(pair_levels) :: levels                    !! both surfaces; empty in a small scene
    real(real64) :: far_reach = 0.0_real64         !! largest distance in plan of spheres that touch
    real(real64) :: rise = 0.0_real64              !! largest |heights| and sum of radii
  end type placed_scene

  !> A pair of asperities that may touch. Not initialised: a large array would be written twice.
  type :: candidate
    integer :: upper, lower
    real(real64) :: touch   !! separation at which it touches first
    real(real64) :: d       !! distance of the centres in plan
    real(real64) :: s       !! sum of the radii: distance of the centres at first touch
    real(real64) :: zc      !! height between the centres at first touch
    real(real64) :: rest    !! rounding error of zc
    real(real64) :: radius  !! combined radius of the pair
    real(real64) :: gap     !! compression at which it touches
  end type candidate

  !> One position: the pairs that may touch, and its end.
  type :: position_pairs
    real(real64) :: dx, dy       !! displacement of the upper surface
    real(real64) :: first_touch  !! separation at which the first pair touches
    real(real64) :: compression      !! compression at its end
    integer :: number = 0  !! pairs in `found`, which may be larger
    type(candidate), allocatable :: found(:)
  end type position_pairs

contains

  !> The power of 2 that is the unit of scaled loads.
  pure integer function load_unit(placed)
    type(placed_scene), intent(in) :: placed  !! scene in solver units

    load_unit = placed%modulus_power + 2 * placed%length_power
  end function load_unit

  !> Whether one of a pair is the plane.
  pure logical function is_on_plane(pair)
    type(candidate), intent(in) :: pair  !! pair of asperities

    is_on_plane = pair%upper == 0 .or. pair%lower == 0
  end function is_on_plane

  !> Point of first touch in plan: on the line between the centres, or at the summit of a cap.
  pure subroutine place_of_touch(placed, pair, dx, dy, x, y)
    type(placed_scene), intent(in) :: placed  !! scene in solver units
    type(candidate), intent(in) :: pair  !! pair of asperities
    real(real64), intent(in) :: dx, dy  !! displacement of the upper surface
    real(real64), intent(out) :: x, y  !! place in plan
    real(real64) :: share

    if (pair%upper == 0) then
      x = placed%xl(pair%lower)
      y = placed%yl(pair%lower)
      return
    end if
    x = placed%xu(pair%upper) + dx
    y = placed%yu(pair%upper) + dy
    if (pair%lower == 0) return
    share = placed%ru(pair%upper) / pair%s
    x = x + share * (placed%xl(pair%lower) - x)
    y = y + share * (placed%yl(pair%lower) - y)
  end subroutine place_of_touch

  !> The largest of some numbers; 0 without numbers.
  pure real(real64) function largest_value(h)
    real(real64), intent(in) :: h(:)  !! numbers of any sign

    largest_value = 0.0_real64
    if (size(h) > 0) largest_value = maxval(h)
  end function largest_value

end module asperity_placed_scene
