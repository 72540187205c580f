!> Square boundary elements of one lattice under all contacts of a cluster, and their gaps.
!>
!> Pressures only increase the gap: where the undeformed gap is 0 or more there is no pressure. The
!> undeformed gap is negative only within sqrt(2) contact radii of first touch. Where such discs of
!> several contacts overlap, an element has the least of their gaps and belongs to the contact of
!> that gap, the first of equal ones. The vertical gap of two spheres is written from the position
!> of first touch, and differences of square roots by their conjugates: no digits are lost at a
!> penetration of 1e-12 of the radius.
module asperity_element_lattice
  use asperity_constants, only: pi
  use asperity_contact_pairs, only: contact_pair
  use asperity_element_forces, only: missing_gap
  use asperity_kinds, only: real64
  implicit none
  private

  public :: bounding_box, element_lattice, gap_at, gap_of_pair, gap_shape, lay_elements

  !> A rectangle of square elements. The lower left corner of element (1, 1) is `left` and `bottom`
  !> sides from the origin. Lengths in the unit of the pairs.
  type :: element_lattice
    real(real64) :: x = 0.0_real64            !! origin in plan
    real(real64) :: y = 0.0_real64            !! origin in plan
    real(real64) :: side = 0.0_real64         !! side of an element
    real(real64) :: depth = 0.0_real64        !! largest penetration, the unit of the gaps
    integer :: left = 0                       !! columns from the origin to the first one
    integer :: bottom = 0                     !! rows from the origin to the first one
    real(real64), allocatable :: gap(:, :)    !! undeformed gap, mean over the element, over depth
    integer, allocatable :: owner(:, :)       !! index of its contact; 0: no pressure possible
    real(real64), allocatable :: force(:, :)  !! force over modulus, depth and side
  end type element_lattice

  !> Undeformed gap of one pair, two spheres or a sphere and a plane. Lengths in the unit of the
  !> pairs.
  type :: gap_shape
    integer :: pair = 0                             !! index in the list of pairs
    real(real64) :: x = 0.0_real64                  !! position of first touch in plan
    real(real64) :: y = 0.0_real64                  !! position of first touch in plan
    real(real64) :: penetration = 0.0_real64        !! vertical penetration, > 0
    real(real64) :: reach = 0.0_real64              !! the gap is positive farther from first touch
    real(real64) :: contact_radius = 0.0_real64     !! radius by Hertz' law without the inclination
    real(real64) :: cosine = 1.0_real64             !! cosine of the inclination at first touch
    real(real64) :: curvature_radius = 0.0_real64   !! R, 1/R = 1/R_upper + 1/R_lower
    real(real64) :: upper_offset(2) = 0.0_real64    !! from the upper centre to first touch, in plan
    real(real64) :: lower_offset(2) = 0.0_real64    !! from the lower centre to first touch, in plan
    real(real64) :: slope(2) = 0.0_real64           !! slope of the common tangent plane
    real(real64) :: upper_height = 0.0_real64       !! height of the upper centre over first touch
    real(real64) :: lower_height = 0.0_real64       !! depth of the lower centre under first touch
  end type gap_shape

contains

  !> Rectangle in plan outside which there is no pressure.
  pure subroutine bounding_box(shapes, x, y, low, high)
    type(gap_shape), intent(in) :: shapes(:)       !! gaps of the contacts, at least one
    real(real64), intent(in) :: x, y               !! origin of the corners, in plan
    real(real64), intent(out) :: low(2), high(2)   !! x, y of the lower and the upper corner

    low = [minval(shapes%x - x - shapes%reach), minval(shapes%y - y - shapes%reach)]
    high = [maxval(shapes%x - x + shapes%reach), maxval(shapes%y - y + shapes%reach)]
  end subroutine bounding_box

  !> Lays a lattice under contacts, with the gaps and the starting forces of its elements. The start
  !> is the pressure of the isolated Hertzian contact, 2/pi E (a/R) sqrt(1 - (r/a)**2), with the
  !> undeformed gap p (r**2/(2 a**2) - 1).
  subroutine lay_elements(shapes, x0, y0, side, window, lattice)
    type(gap_shape), intent(in) :: shapes(:)       !! gaps of the contacts, at least one
    real(real64), intent(in) :: x0, y0             !! origin in plan
    real(real64), intent(in) :: side               !! side of an element
    real(real64), intent(in) :: window(4)          !! limits: x, y of two corners from the origin
    type(element_lattice), intent(out) :: lattice  !! elements with gaps and starting forces
    real(real64), allocatable :: least_gaps(:, :)
    real(real64) :: low(2), high(2), gaps(4), mean, x, y, step
    integer :: columns, rows, i, j, k, first, last

    call bounding_box(shapes, x0, y0, low, high)
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
    allocate (lattice%force(columns, rows), least_gaps(4, columns))
    lattice%gap = missing_gap
    lattice%owner = 0
    lattice%force = 0.0_real64
    ! Distance of Gauss' two points from the centre of an element.
    step = 0.5_real64 / sqrt(3.0_real64) * side
    do j = 1, rows
      least_gaps = missing_gap
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
            if (minval(gaps) < min(0.0_real64, minval(least_gaps(:, i)))) lattice%owner(i, j) = k
            least_gaps(:, i) = min(least_gaps(:, i), gaps)
          end do
        end associate
      end do
      do i = 1, columns
        ! Gauss' rule, exact for polynomials of degree 3.
        mean = 0.25_real64 * sum(least_gaps(:, i))
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

  !> Undeformed gap of a pair at a penetration.
  pure function gap_of_pair(pair, number, penetration) result(profile)
    type(contact_pair), intent(in) :: pair        !! pair of asperities, or one and a plane
    integer, intent(in) :: number                 !! index in the list of pairs
    real(real64), intent(in) :: penetration       !! vertical, > 0, less than zc of the pair
    type(gap_shape) :: profile
    real(real64) :: centre_offset(2), share, plane_height

    ! Height of the centre that stands for a plane: as large as its square is finite.
    plane_height = 0.5_real64 * sqrt(huge(plane_height))
    centre_offset = [pair%lower_x - pair%upper_x, pair%lower_y - pair%upper_y]
    share = pair%upper_radius / pair%s
    profile%pair = number
    profile%penetration = penetration
    profile%cosine = pair%zc / pair%s
    profile%slope = centre_offset / pair%zc
    profile%upper_offset = share * centre_offset
    profile%lower_offset = -(pair%lower_radius / pair%s) * centre_offset
    profile%x = pair%upper_x + profile%upper_offset(1)
    profile%y = pair%upper_y + profile%upper_offset(2)
    profile%upper_height = pair%upper_radius * profile%cosine
    profile%lower_height = pair%lower_radius * profile%cosine
    profile%curvature_radius = share * pair%lower_radius
    if (.not. min(pair%upper_radius, pair%lower_radius) > 0.0_real64) then
      profile%curvature_radius = pair%radius
      if (.not. pair%upper_radius > 0.0_real64) profile%upper_height = plane_height
      if (.not. pair%lower_radius > 0.0_real64) profile%lower_height = plane_height
    end if
    ! The curvature of both spheres is at least 1/radius: gap >= r**2/(2 R) - penetration.
    profile%contact_radius = sqrt(profile%curvature_radius * penetration)
    profile%reach = sqrt(2.0_real64) * profile%contact_radius
  end function gap_of_pair

  !> Undeformed vertical gap at a position; negative where the undeformed spheres overlap.
  pure function gap_at(profile, x, y) result(gap)
    type(gap_shape), intent(in) :: profile  !! gap of the pair, with its penetration
    real(real64), intent(in) :: x           !! position from first touch
    real(real64), intent(in) :: y           !! position from first touch
    real(real64) :: gap, slope, square, upper_difference, lower_difference

    gap = missing_gap
    square = x * x + y * y
    slope = profile%slope(1) * x + profile%slope(2) * y
    upper_difference = &
      2.0_real64 * (profile%upper_offset(1) * x + profile%upper_offset(2) * y) + square
    lower_difference = &
      2.0_real64 * (profile%lower_offset(1) * x + profile%lower_offset(2) * y) + square
    ! The position is outside one of the spheres, in plan.
    if (upper_difference >= profile%upper_height**2 .or. &
        lower_difference >= profile%lower_height**2) return
    gap = above_plane(profile%upper_height, upper_difference, slope, square) + &
          above_plane(profile%lower_height, lower_difference, -slope, square) - profile%penetration
  end function gap_at

  ! Vertical distance of a sphere from its tangent plane at first touch. Heights over a horizontal
  ! plane would contain the slopes of both spheres, whose sum is 0 but for rounding.
  elemental real(real64) function above_plane(height, square_difference, slope, square)
    real(real64), intent(in) :: height             ! height of the centre over first touch
    real(real64), intent(in) :: square_difference  ! its square less that over the sphere here
    real(real64), intent(in) :: slope              ! height of the plane here over first touch
    real(real64), intent(in) :: square             ! square of the distance in plan

    associate (denominator => height + sqrt(height**2 - square_difference))
      above_plane = (square + slope * (square_difference / denominator)) / denominator
    end associate
  end function above_plane

end module asperity_element_lattice
