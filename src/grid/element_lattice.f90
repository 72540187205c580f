!> Square boundary elements of one lattice under all contacts of a cluster, and their gaps.
!>
!> Pressures only increase the gap: where the undeformed gap is 0 or more there is no pressure. The
!> undeformed gap is negative only within sqrt(2) contact radii of first touch. Where such discs of
!> several contacts overlap, an element has the least of their gaps and belongs to the contact of
!> that gap, the first of equal ones.
!>
!> The bodies are those of Hertz' law: the gap of a pair is the paraboloid of its combined radius R.
!> Measured vertically, it is (r**2 + (m.r)**2)/(2 R cos) at the offset r in plan from first touch,
!> with the slope m and the cosine of the inclination. Its isolated contact is the ellipse of Hertz,
!> with curvatures in the ratio 1 + m**2 and the geometric mean 1/(R cos**2) (Johnson 1985, eq. 4.25
!> to 4.28).
module asperity_element_lattice
  use asperity_constants, only: pi
  use asperity_contact_pairs, only: contact_pair
  use asperity_element_forces, only: missing_gap
  use asperity_kinds, only: real64
  implicit none
  private

  public :: bounding_box, element_lattice, gap_at, gap_of_pair, gap_shape, lay_elements, &
            penetration_of_load, radius_of_load

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

  !> Undeformed gap of one pair. Lengths in the unit of the pairs.
  type :: gap_shape
    integer :: pair = 0                             !! index in the list of pairs
    real(real64) :: x = 0.0_real64                  !! position of first touch in plan
    real(real64) :: y = 0.0_real64                  !! position of first touch in plan
    real(real64) :: penetration = 0.0_real64        !! vertical penetration, > 0
    real(real64) :: reach = 0.0_real64              !! the gap is positive farther from first touch
    real(real64) :: contact_radius = 0.0_real64     !! radius in plan of the isolated contact
    real(real64) :: curvature = 0.0_real64          !! of the gap across the slope
    real(real64) :: slope(2) = 0.0_real64           !! slope of the common tangent plane
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
    real(real64), intent(in) :: penetration       !! vertical penetration, > 0
    type(gap_shape) :: profile
    real(real64) :: cosine

    cosine = pair%zc / pair%s
    profile%pair = number
    profile%penetration = penetration
    profile%slope = [pair%lower_x - pair%upper_x, pair%lower_y - pair%upper_y] / pair%zc
    profile%x = pair%x
    profile%y = pair%y
    profile%curvature = 1.0_real64 / (pair%radius * cosine)
    profile%contact_radius = cosine * sqrt(pair%radius * penetration)
    profile%reach = sqrt(2.0_real64 * penetration / profile%curvature)
  end function gap_of_pair

  !> Undeformed vertical gap at a position; negative where the undeformed bodies overlap.
  pure real(real64) function gap_at(profile, x, y) result(gap)
    type(gap_shape), intent(in) :: profile  !! gap of the pair, with its penetration
    real(real64), intent(in) :: x           !! position from first touch
    real(real64), intent(in) :: y           !! position from first touch

    gap = 0.5_real64 * profile%curvature * &
          (x**2 + y**2 + (profile%slope(1) * x + profile%slope(2) * y)**2) - profile%penetration
  end function gap_at

  !> Penetration of the isolated contact of a pair that carries a load (see the module).
  elemental real(real64) function penetration_of_load(pair, load) result(penetration)
    type(contact_pair), intent(in) :: pair    !! pair of asperities, or one and a plane
    real(real64), intent(in) :: load          !! vertical load on elements over the modulus, >= 0
    real(real64) :: factor(2)

    factor = ellipse_factors((pair%d / pair%zc)**2)
    ! The power of a number without unit: a power of two as unit of length changes no digit.
    penetration = factor(2) * pair%radius * &
                  (0.75_real64 * (load / pair%radius) / (pair%radius * (pair%zc / pair%s)))** &
                  (2.0_real64 / 3.0_real64)
  end function penetration_of_load

  !> Geometric mean of the semi-axes in plan of the isolated contact of a pair that carries a load.
  elemental real(real64) function radius_of_load(pair, load) result(radius)
    type(contact_pair), intent(in) :: pair    !! pair of asperities, or one and a plane
    real(real64), intent(in) :: load          !! vertical load on elements over the modulus, >= 0
    real(real64) :: factor(2)

    factor = ellipse_factors((pair%d / pair%zc)**2)
    radius = factor(1) * pair%radius * (0.75_real64 * (load / pair%radius) / pair%radius * &
                                        (pair%zc / pair%s)**2)**(1.0_real64 / 3.0_real64)
  end function radius_of_load

  ! Ratios of radius and penetration of an elliptical contact to those of the circular one of equal
  ! load and geometric mean curvature: F1 and F2 of Johnson 1985, eq. 4.26 and 4.28. With b/a the
  ! ratio of the axes and s = 1 - E/K by the arithmetic-geometric mean of 1 and b/a, the ratio of
  ! curvatures is (1 - (b/a)**2 - s)/((b/a)**2 s), which is solved for b/a by substitution.
  pure function ellipse_factors(square) result(factor)
    real(real64), intent(in) :: square  ! of the slope: ratio of curvatures less 1
    real(real64) :: factor(2), ratio, previous, eccentricity, mean, other, half, s, weight
    integer :: i

    factor = 1.0_real64
    if (.not. square > sqrt(epsilon(square))) return
    ratio = (1.0_real64 + square)**(-2.0_real64 / 3.0_real64)
    ! Each substitution leaves at most half of the error.
    do i = 1, digits(ratio)
      previous = ratio
      eccentricity = (1.0_real64 - ratio) * (1.0_real64 + ratio)  ! squared
      s = 0.5_real64 * eccentricity
      weight = 1.0_real64
      mean = 1.0_real64
      other = ratio
      do while (mean - other > sqrt(epsilon(mean)) * mean)
        half = 0.5_real64 * (mean - other)
        other = sqrt(mean * other)
        mean = mean - half
        s = s + weight * half**2
        weight = 2 * weight
      end do
      mean = 0.5_real64 * (mean + other)
      ratio = sqrt((eccentricity - s) / (s * (1.0_real64 + square)))
      if (abs(ratio - previous) < 8 * epsilon(ratio) * ratio) exit
    end do
    factor(1) = (2 * sqrt(ratio) * sqrt((eccentricity - s) * s) / (mean * eccentricity))** &
                (1.0_real64 / 3.0_real64)
    factor(2) = sqrt(ratio) / (mean * factor(1))
  end function ellipse_factors

end module asperity_element_lattice
