#define ITEM type(candidate)
!> The order of pairs that may touch, and the law of one pair.
module asperity_candidate_pairs
  use asperity_contact_records, only: overlap_stable, solve_method
  use asperity_kinds, only: real64
  use asperity_placed_scene, only: candidate, is_on_plane, placed_scene
  use asperity_scene_values, only: criterion_load
  use asperity_sphere_overlap, only: stable_overlap, touching_height
  implicit none
  private

  public :: cube_root, four_thirds, keep_within, largest_rise, limit_penetration, load_of_overlap, &
            overlap_of, refine_heights, set_gaps, sort_by_gap

  !> Factor of Hertz' law.
  real(real64), parameter :: four_thirds = 4.0_real64 / 3.0_real64

contains

  !> Sets height and rounding error at first touch, for the pairs whose overlap is evaluated.
  subroutine refine_heights(found)
    type(candidate), intent(inout) :: found(:)  !! pairs of a position
    integer :: i

    do i = 1, size(found)
      call touching_height(found(i)%s, found(i)%d, found(i)%zc, found(i)%rest)
    end do
  end subroutine refine_heights

  !> Sets all gaps, relative to the pair that touches first.
  subroutine set_gaps(found, first_touch)
    type(candidate), intent(inout) :: found(:)  !! pairs of a position
    real(real64), intent(out) :: first_touch  !! separation at which the first pair touches

    first_touch = maxval(found%touch)
    found%gap = first_touch - found%touch
  end subroutine set_gaps

  !> Sorts pairs in the order of touch.
  pure subroutine sort_by_gap(found)
    type(candidate), contiguous, intent(inout) :: found(:)  !! pairs of a position

    call merge_sort(found)
  end subroutine sort_by_gap

  !> Keeps the pairs that touch or attract at the compression `compression`, in the order of touch.
  subroutine keep_within(placed, method, found, number, compression)
    type(placed_scene), intent(in) :: placed  !! scene in solver units
    type(solve_method), intent(in) :: method  !! range of attraction
    type(candidate), contiguous, intent(inout) :: found(:)  !! pairs of a position
    integer, intent(inout) :: number  !! number of pairs
    real(real64), intent(in) :: compression  !! compression at the end
    real(real64) :: centres, reach, rise
    integer :: i, kept

    reach = scale(method%reach, -placed%length_power)
    kept = 0
    do i = 1, number
      rise = reach
      ! From attraction along the line of centres to first touch: sqrt((s + reach)**2 - d**2) - zc.
      if (reach > 0.0_real64 .and. .not. is_on_plane(found(i))) then
        centres = found(i)%s + reach
        rise = reach * ((found(i)%s + centres) / &
          (found(i)%zc + sqrt((centres - found(i)%d) * (centres + found(i)%d))))
      end if
      if (found(i)%gap - rise > compression .and. .not. &
          (method%keeps_first .and. .not. found(i)%gap > 0.0_real64)) cycle
      kept = kept + 1
      if (kept < i) found(kept) = found(i)
    end do
    number = kept
    call merge_sort(found(:number))
  end subroutine keep_within

  !> The largest compression, over all pairs of a scene, from attraction to first touch.
  pure real(real64) function largest_rise(placed, method) result(rise)
    type(placed_scene), intent(in) :: placed  !! scene in solver units
    type(solve_method), intent(in) :: method  !! range of attraction

    rise = scale(method%reach, -placed%length_power)
    if (.not. placed%on_plane) rise = sqrt(rise * (2.0_real64 * placed%far_reach + rise))
  end function largest_rise

  ! Order by gap, then by the quantities that determine the load, then by index: totals do not
  ! depend on the order of the asperities in the scene.
  pure logical function comes_before(a, b)
    type(candidate), intent(in) :: a, b

    if (a%gap < b%gap .or. b%gap < a%gap) then
      comes_before = a%gap < b%gap
    else if (a%d < b%d .or. b%d < a%d) then
      comes_before = a%d < b%d
    else if (a%s < b%s .or. b%s < a%s) then
      comes_before = a%s < b%s
    else if (a%radius < b%radius .or. b%radius < a%radius) then
      comes_before = a%radius < b%radius
    else if (a%upper /= b%upper) then
      comes_before = a%upper < b%upper
    else
      comes_before = a%lower < b%lower
    end if
  end function comes_before

  !> Overlap W of a pair at penetration p: the decrease of the distance of its centres.
  pure function overlap_of(pair, p, overlap) result(w)
    type(candidate), intent(in) :: pair  !! pair of asperities
    real(real64), intent(in) :: p  !! penetration of the pair
    integer, intent(in) :: overlap  !! `overlap_stable` or `overlap_original`
    real(real64) :: w, z

    if (overlap == overlap_stable) then
      w = stable_overlap(pair%s, pair%d, pair%zc, pair%rest, p)
    else if (is_on_plane(pair)) then
      ! The radius less the height of the centre over the plane.
      w = pair%radius - (pair%radius - p)
    else
      z = pair%zc - p
      w = pair%s - sqrt(pair%d * pair%d + z * z)
      if (w < 0.0_real64) w = 0.0_real64
    end if
  end function overlap_of

  !> Load of an overlap over the combined modulus: 4/3 sqrt(R) W**1.5 (Hertz), in a form in
  !> which lengths times 2**k give loads times exactly 4**k.
  pure function load_of_overlap(radius, w) result(load)
    real(real64), intent(in) :: radius  !! combined radius of the pair
    real(real64), intent(in) :: w       !! overlap of the pair
    real(real64) :: load

    load = four_thirds * (w * sqrt(w * radius))
  end function load_of_overlap

  !> Penetration at which a pair reaches the limit; `reachable` is false when its centres are level
  !> first.
  pure subroutine limit_penetration(placed, pair, p, reachable)
    type(placed_scene), intent(in) :: placed  !! scene in solver units
    type(candidate), intent(in) :: pair  !! pair of asperities
    real(real64), intent(out) :: p  !! penetration of the pair
    logical, intent(out) :: reachable  !! false when the centres are level first
    real(real64) :: root, w, left, beyond

    if (placed%criterion == criterion_load) then
      ! W/R = (3 P/(4 E R**2))**(2/3): the ratio has no unit, so its root stays in range.
      root = cube_root(placed%limit / (placed%modulus * four_thirds) / &
                       (pair%radius * pair%radius))
      w = pair%radius * (root * root)
    else
      w = pair%radius * placed%limit
    end if
    p = 0.0_real64
    left = pair%s - w
    ! This order avoids the rounding of `left` in a small difference.
    beyond = (pair%s - pair%d) - w
    reachable = beyond > 0.0_real64
    if (.not. reachable) return
    if (is_on_plane(pair)) then
      p = w
      return
    end if
    p = w * ((pair%s + left) / (pair%zc + sqrt(beyond * (left + pair%d))))
  end subroutine limit_penetration

  !> The cube root, for number >= 0; that of 8 times a number is exactly twice as much.
  elemental function cube_root(number) result(root)
    real(real64), intent(in) :: number  !! number, 0 or more
    real(real64) :: root, near_one
    integer :: power

    root = 0.0_real64
    if (.not. number > root) return
    power = floor(exponent(number) / 3.0)
    near_one = scale(number, -3 * power)
    root = near_one**(1.0_real64 / 3.0_real64)
    ! One Newton step: the exponent 1/3 is rounded.
    root = scale(root - (root - near_one / (root * root)) / 3, power)
  end function cube_root

#include "../numerics/merge_sort.inc"

end module asperity_candidate_pairs
