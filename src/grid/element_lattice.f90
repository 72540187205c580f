!> Square boundary elements of one lattice under all contacts of a cluster, and their gaps.
!>
!> Pressure only opens the gap, so that there is none where the undeformed gap is not below zero:
!> outside discs of radius sqrt(2) times the contact radius. An element on which several discs lie
!> has the least gap and belongs to the contact of the deepest gap, of equals to the first. The
!> vertical gap between two spheres is written from the place where they touch first, with the
!> square roots through their conjugates: a penetration of 1e-12 of the radius keeps its digits.
module asperity_element_lattice
  use asperity_constants, only: pi
  use asperity_contact_pairs, only: contact_pair
  use asperity_element_forces, only: missing_gap
  use asperity_kinds, only: real64
  implicit none
  private

  public :: box_of, element_lattice, gap_at, gap_shape, lay_elements, gap_of_pair

  !> A rectangle of elements. Element (1, 1) has its lower left corner at (left, bottom) elements
  !> from the origin. Lengths in the unit of the pairs.
  type :: element_lattice
    real(real64) :: x = 0.0_real64         !! origin, in plan
    real(real64) :: y = 0.0_real64         !! origin, in plan
    real(real64) :: side = 0.0_real64      !! side of an element
    real(real64) :: depth = 0.0_real64     !! deepest penetration, unit of the gaps
    integer :: left = 0                    !! columns between the origin and the first
    integer :: bottom = 0                  !! rows between the origin and the first
    real(real64), allocatable :: gap(:, :) !! mean over the element, over the depth
    integer, allocatable :: owner(:, :)    !! place of its contact in the list; 0: no pressure here
    real(real64), allocatable :: force(:, :) !! over modulus, depth and side
  end type element_lattice

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
    real(real64) :: slope(2) = 0.0_real64           !! of the plane that both touch
    real(real64) :: upper_height = 0.0_real64       !! from the upper centre to the touch
    real(real64) :: lower_height = 0.0_real64       !! from the lower centre to the touch
  end type gap_shape

contains

  !> The rectangle in plan outside which there is no pressure.
  pure subroutine box_of(shapes, x, y, low, high)
    type(gap_shape), intent(in) :: shapes(:)       !! the contacts, at least one
    real(real64), intent(in) :: x, y               !! a place in plan
    real(real64), intent(out) :: low(2), high(2)   !! x, y of two corners, from that place

    low = [minval(shapes%x - x - shapes%reach), minval(shapes%y - y - shapes%reach)]
    high = [maxval(shapes%x - x + shapes%reach), maxval(shapes%y - y + shapes%reach)]
  end subroutine box_of

  !> Lays the elements under some contacts. Each begins with the pressure of Hertz as if alone: 2/pi
  !> E (a/R) sqrt(1 - (r/a)**2), and its undeformed gap is p (r**2/(2 a**2) - 1).
  subroutine lay_elements(shapes, x0, y0, side, window, lattice)
    type(gap_shape), intent(in) :: shapes(:)      !! the contacts, at least one
    real(real64), intent(in) :: x0, y0            !! origin, in plan
    real(real64), intent(in) :: side              !! side of an element
    real(real64), intent(in) :: window(4)         !! x, y of two corners from the origin: limits
    type(element_lattice), intent(out) :: lattice    !! elements, gaps and first forces
    real(real64), allocatable :: least(:, :)
    real(real64) :: low(2), high(2), gaps(4), mean, x, y, step
    integer :: columns, rows, i, j, k, first, last

    call box_of(shapes, x0, y0, low, high)
    low = max(low, window(:2))
    high = max(low, min(high, window(3:)))
    lattice%x = x0
    lattice%y = y0
    lattice%side = side
    lattice%depth = maxval(shapes%penetration)
    lattice%left = floor(low(1) / side)
    lattice%bottom = floor(low(2) / side)
    columns = floor(high(1) / side) - lattice%left + 1
    rows = floor(high(2) / side) - lattice%bottom + 1
    allocate (lattice%gap(columns, rows), lattice%owner(columns, rows))
    allocate (lattice%force(columns, rows), least(4, columns))
    lattice%gap = missing_gap
    lattice%owner = 0
    lattice%force = 0.0_real64
    ! Gauss' two points in an element, from its centre.
    step = 0.5_real64 / sqrt(3.0_real64) * side
    do j = 1, rows
      least = missing_gap
      do k = 1, size(shapes)
        associate (s => shapes(k))
          y = y0 - s%y + (lattice%bottom + j - 0.5_real64) * side
          if (abs(y) > s%reach + side) cycle
          x = x0 - s%x + lattice%left * side
          first = max(1, floor((-s%reach - x) / side) + 1)
          last = min(columns, floor((s%reach - x) / side) + 1)
          do i = first, last
            associate (c => x + (i - 0.5_real64) * side)
              gaps = [gap_at(s, c - step, y - step), gap_at(s, c + step, y - step), &
                      gap_at(s, c - step, y + step), gap_at(s, c + step, y + step)]
            end associate
            if (minval(gaps) < min(0.0_real64, minval(least(:, i)))) lattice%owner(i, j) = k
            least(:, i) = min(least(:, i), gaps)
          end do
        end associate
      end do
      do i = 1, columns
        ! Exact for a cubic.
        mean = 0.25_real64 * sum(least(:, i))
        if (.not. mean < 0.0_real64) lattice%owner(i, j) = 0
        if (lattice%owner(i, j) == 0) cycle
        lattice%gap(i, j) = mean / lattice%depth
        associate (s => shapes(lattice%owner(i, j)))
          lattice%force(i, j) = 2.0_real64 / pi * side / s%contact_radius * sqrt(max( &
            0.0_real64, -1.0_real64 - 2.0_real64 * mean / s%penetration)) * &
            (s%penetration / lattice%depth)
        end associate
      end do
    end do
  end subroutine lay_elements

  !> Gap of a pair at a penetration.
  pure function gap_of_pair(pair, number, penetration) result(profile)
    type(contact_pair), intent(in) :: pair        !! pair of asperities, or one and a plane
    integer, intent(in) :: number                 !! its place in the list of pairs
    real(real64), intent(in) :: penetration       !! more than 0, less than the pair's zc
    type(gap_shape) :: profile
    real(real64) :: apart(2), share, far_above

    ! Height of a centre over a plane, the largest whose square is a number: nothing curves.
    far_above = 0.5_real64 * sqrt(huge(far_above))
    apart = [pair%lower_x - pair%upper_x, pair%lower_y - pair%upper_y]
    share = pair%upper_radius / pair%s
    profile%pair = number
    profile%penetration = penetration
    profile%cosine = pair%zc / pair%s
    profile%slope = apart / pair%zc
    profile%upper = share * apart
    profile%lower = -(pair%lower_radius / pair%s) * apart
    profile%x = pair%upper_x + profile%upper(1)
    profile%y = pair%upper_y + profile%upper(2)
    profile%upper_height = pair%upper_radius * profile%cosine
    profile%lower_height = pair%lower_radius * profile%cosine
    profile%curvature_radius = share * pair%lower_radius
    if (.not. min(pair%upper_radius, pair%lower_radius) > 0.0_real64) then
      profile%curvature_radius = pair%radius
      if (.not. pair%upper_radius > 0.0_real64) profile%upper_height = far_above
      if (.not. pair%lower_radius > 0.0_real64) profile%lower_height = far_above
    end if
    ! Both spheres curve by 1/radius at least everywhere: gap >= s**2/(2 R) - penetration.
    profile%contact_radius = sqrt(profile%curvature_radius * penetration)
    profile%reach = sqrt(2.0_real64) * profile%contact_radius
  end function gap_of_pair

  !> The gap before any deformation; less than 0 where the undeformed spheres overlap.
  pure function gap_at(profile, x, y) result(gap)
    type(gap_shape), intent(in) :: profile  !! gap of the pair, with its penetration
    real(real64), intent(in) :: x         !! from the place of first touch
    real(real64), intent(in) :: y         !! from the place of first touch
    real(real64) :: gap, slope, square, upper, lower

    gap = missing_gap
    square = x * x + y * y
    slope = profile%slope(1) * x + profile%slope(2) * y
    upper = 2.0_real64 * (profile%upper(1) * x + profile%upper(2) * y) + square
    lower = 2.0_real64 * (profile%lower(1) * x + profile%lower(2) * y) + square
    ! Beside one of the spheres.
    if (upper >= profile%upper_height**2 .or. lower >= profile%lower_height**2) return
    gap = above_plane(profile%upper_height, upper, slope, square) + &
          above_plane(profile%lower_height, lower, -slope, square) - profile%penetration
  end function gap_at

  ! Distance of a sphere from its tangent plane at first touch, along the vertical. The slopes of
  ! both spheres cancel, and would leave their rounding in the gap.
  elemental real(real64) function above_plane(height, fall, slope, square)
    real(real64), intent(in) :: height   ! from its centre to the touch
    real(real64), intent(in) :: fall     ! square of `height` less that at this place
    real(real64), intent(in) :: slope    ! height of the plane at this place over the touch
    real(real64), intent(in) :: square   ! of the distance in plan from the touch

    associate (both => height + sqrt(height**2 - fall))
      above_plane = (square + slope * (fall / both)) / both
    end associate
  end function above_plane

end module asperity_element_lattice
