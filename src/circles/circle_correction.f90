!> Correction of the loads of Hertzian contacts by the curvature of the field of their neighbours.
!>
!> The potential of circle_field has each contact in the displacement and the slope of the others,
!> and no curvature: its errors are of the order (a/d)**6, a radius and d distance. To second order
!> in a field a contact responds as a flat punch, whose eigenfunctions on the disc are known. The
!> energy over the modulus decreases by two terms a contact,
!>
!>     axial: 5 a q**2,          q = sum (M_ij - G_ij) V_j
!>     oval:  2/45 a**5 |D|**2,  D = sum V_j d_ij exp(2 i phi_ij)
!>
!> where q is the flat mean of the field less its Hertz mean, and d the oval field (oval_field) at
!> the azimuth phi. With x = 7.5 q/p, the mean curvature of the field over that of the contact, both
!> are taken at the curvature (1 + x)/R: axial = 3/5 p V (1 + x/3 - (1 + x)**(1/3)), and oval is
!> multiplied by (1 + x)**(-5/3). With y = R D/2 a contact of inclination m is an ellipse without a
!> field, of y0 = m**2/(2 + m**2) along its slope: |y|**2 in the oval term is |y + y0|**2 - |y0|**2.
!> The loads change by the one linear step
!>
!>     (diag(1/k + max(growth, 0)/(3 V)) + C) dV = c - d,   d = -d(axial + oval)/dV
!>
!> with k stiffness, C the compliances of flat punches, and c the change of the compression that
!> keeps a given load. Left out are terms of the order (a/d)**7 and the oval field of far circles.
!>
!> The area is that of Hertz' ellipse: it has the mean curvature (1 + x)/R, of which y + y0 is half
!> of the difference of the principal ones, and its area is that of the isolated contact times
!> (1 + x)**(-2/3) (1 + 2/9 (|y + y0|**2 - |y0|**2)/(1 + x)**2), to the second order (Johnson,
!> Contact Mechanics, 1985, eq. 4.25 and 4.28).
!>
!> The expansion about the centre of a circle holds up to the next rim, at the distance r from it.
!> Where a circle reaches over that rim, a > r, the terms of its area, which are of second order,
!> count with (r/a)**2. What two circles share counts once. A circle inside another one, r < -a,
!> keeps its load. Where caps stand on caps, a linear step may take more load than there is, or give
!> more than neighbours had taken. As pressures of neighbours lower the surface and pull nothing, a
!> corrected load is at least 0 and at most that of the isolated contact at the compression: the
!> step is limited to this range, and its whole size counts in the error.
module asperity_circle_correction
  use asperity_circle_field, only: are_close, circle_set, compliance, direction_x, direction_y, &
                                   first_slope, hessian_anisotropy, large_set, &
                                   least_curvature_share, linear_residual, relative_position, &
                                   second_slope, sum_error
  use asperity_circle_step, only: circle_model, find_step, prepare_model, trust_step
  use asperity_constants, only: pi
  use asperity_interruption, only: interruption
  use asperity_kinds, only: real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms, oval_field
  use asperity_source_tree, only: sum_sources
  implicit none
  private

  public :: circle_correction, find_correction, find_curvature_terms

  !> The correction of a solution; arrays have one element a circle.
  type :: circle_correction
    real(real64), allocatable :: load_change(:)   !! dV, over the modulus
    !> area in plan over that of the isolated contact of the same load; an area that belongs to two
    !> circles counts once
    real(real64), allocatable :: area_ratio(:)
    real(real64) :: compression_change = 0.0_real64  !! c, 0 at a given compression [length]
    real(real64) :: tangent = 0.0_real64          !! change of the total load by the compression
    !> errors of the corrected load by circle, over the modulus, and of the area, over that of all;
    !> those of many are the root of the sum of their squares
    real(real64), allocatable :: load_error(:), area_error(:)
    real(real64), allocatable :: shared_area_error(:)  !! further errors of the area, which add up
  end type circle_correction

  ! Sums of radii [1] below which circles are close, and factor of the error of their loads over
  ! those of others; measured on 306 scenes against boundary elements, kept by 155 of 156 others;
  ! test: test_dense.py.
  real(real64), parameter :: close_share = 0.9_real64, close_factor = 3.0_real64
  ! Error of the area of a circle over its change by curvature [1]; measured on the 401 scenes of
  ! reference_output/interaction/dense.csv, of which 99 % keep the estimate; test: test_dense.py.
  real(real64), parameter :: curvature_share = 0.25_real64
  ! The same of all circles in common over their change by overlap [1]; measured, up to 0.145 on the
  ! caps of reference_output/interaction/rough.csv; test: test_dense.py.
  real(real64), parameter :: common_share = 0.15_real64

contains

  !> Finds the correction of solved contacts, and the errors that are left, estimated by its size:
  !> sqrt(sum dV**2) (1 + 3 U)/sum V of the load, with the share U of the load on close circles.
  !> Circles whose place is fixed respond to the others, and have no terms and no errors of their
  !> own.
  subroutine find_correction(set, keeps_load, interrupt, correction)
    type(circle_set), intent(inout) :: set           !! solved circles; its work arrays change
    logical, intent(in) :: keeps_load                !! the total load is given, not the compression
    type(interruption), intent(in) :: interrupt      !! of the run
    type(circle_correction), intent(out) :: correction  !! changes of the loads, and errors
    type(circle_model) :: model
    type(trust_step) :: by_compression, by_curvature
    real(real64), dimension(size(set%x)) :: gain, gradient, lowering, reach
    real(real64) :: curvature(2, size(set%x))
    logical :: is_close(size(set%x))
    real(real64) :: excess, factor
    integer :: k, try

    call find_curvature_terms(set, curvature, gain, gradient)
    reach = distance_to_rim(set)
    allocate (model%gradient(3, size(set%x)), source=0.0_real64)
    model%convex = .true.
    call prepare_model(set, model)
    call find_response(spread(-1.0_real64, 1, size(set%x)), by_compression)
    call find_response(gradient, by_curvature)
    correction%tangent = sum(by_compression%change(1, :))
    lowering = set%displacement + 0.5_real64 * set%curvature * sum(set%shift**2, dim=1)
    ! The load is linear in the compression but for the limits: few iterations.
    do try = 1, digits(excess)
      correction%load_change = limited_changes()
      excess = sum(set%load_share * correction%load_change)
      if (.not. keeps_load .or. abs(excess) <= sum_error * &
          sum(set%load_share * set%load)) exit
      correction%compression_change = correction%compression_change - &
        excess / sum(set%load_share * by_compression%change(1, :))
    end do
    is_close = .false.
    do k = 1, size(set%one)
      if (are_close(set, set%one(k), set%other(k), close_share)) &
        is_close([set%one(k), set%other(k)]) = .true.
    end do
    factor = 1 + close_factor * sum(set%load, is_close .and. .not. set%shift_fixed) / sum(set%load)
    correction%load_error = merge(0.0_real64, factor * abs(by_curvature%change(1, :)), &
                                  set%shift_fixed)
    call correct_areas(set, curvature, reach, correction)

  contains

    ! Changes of the loads from none to the isolated contact.
    pure function limited_changes() result(change)
      real(real64) :: change(size(set%x))

      change = merge(0.0_real64, by_curvature%change(1, :), reach < -1) + &
               correction%compression_change * by_compression%change(1, :)
      where (.not. set%shift_fixed) change = min(change, set%load * (max(0.0_real64, 1 + &
        (lowering + correction%compression_change) * set%radius / &
        (0.75_real64 * set%load))**1.5_real64 - 1))
      change = max(-set%load, change)
    end function limited_changes

    ! Finds the changes of the loads by a gradient.
    subroutine find_response(by_load, response)
      real(real64), intent(in) :: by_load(:)
      type(trust_step), intent(out) :: response
      real(real64) :: radius
      integer :: products

      products = 0
      radius = huge(radius)**0.25_real64
      model%gradient(1, :) = by_load
      call find_step(set, model, linear_residual, radius, response, products, interrupt)
    end subroutine find_response

  end subroutine find_correction

  ! Distance from the centre of each circle to the next rim of another one, over its radius: below 0
  ! where the centre is inside the other one, below -1 where all of the circle is.
  pure function distance_to_rim(set) result(reach)
    type(circle_set), intent(in) :: set
    real(real64) :: reach(size(set%x)), distance
    integer :: k

    reach = huge(reach)
    do k = 1, size(set%one)
      associate (i => set%one(k), j => set%other(k), a => set%radius)
        distance = norm2(relative_position(set, i, j))
        reach(i) = min(reach(i), (distance - a(j)) / a(i))
        reach(j) = min(reach(j), (distance - a(i)) / a(j))
      end associate
    end do
  end function distance_to_rim

  ! Finds the areas of the corrected loads, and their errors. The second order of the ellipse, and a
  ! share of what overlaps change, have the same sign in all circles.
  pure subroutine correct_areas(set, curvature, reach, correction)
    type(circle_set), intent(in) :: set
    real(real64), intent(in) :: curvature(:, :), reach(:)
    type(circle_correction), intent(inout) :: correction
    real(real64), dimension(size(set%x)) :: circle, change, lost, oval, radius, uncovered, weight
    real(real64) :: distance
    integer :: k

    radius = set%radius * (1 + correction%load_change / set%load)**(1.0_real64 / 3)
    uncovered = 1.0_real64
    do k = 1, size(set%one)
      associate (i => set%one(k), j => set%other(k))
        if (any(set%shift_fixed([i, j])) .or. .not. min(radius(i), radius(j)) > 0.0_real64) cycle
        distance = norm2(relative_position(set, i, j))
        uncovered(i) = uncovered(i) * (1 - ceded_share(distance / radius(i), radius(j) / radius(i)))
        uncovered(j) = uncovered(j) * (1 - ceded_share(distance / radius(j), radius(i) / radius(j)))
      end associate
    end do
    change = max(1 + curvature(1, :), least_curvature_share)**(-2.0_real64 / 3)
    oval = change * 2.0_real64 / 9 * min(1.0_real64, curvature(2, :))
    change = merge(0.0_real64, change + oval - 1, set%shift_fixed)
    weight = min(1.0_real64, max(0.0_real64, reach))**2
    correction%area_ratio = (1 + weight * change) * uncovered
    circle = (radius / maxval(radius))**2
    circle = circle / sum(circle * correction%area_ratio)
    ! The true area is between those with and without what overlaps change: midway at best.
    lost = circle * (uncovered * (1 - weight) * abs(change) + 1 - uncovered)
    correction%area_error = circle * uncovered * weight * curvature_share * abs(change) + &
                            0.5_real64 * lost
    correction%shared_area_error = circle * uncovered * weight * abs(oval) + common_share * lost
  end subroutine correct_areas

  ! Share of a circle of radius 1 that is counted with another one: the part beyond the chord of
  ! both, or all of a smaller circle inside it.
  pure real(real64) function ceded_share(distance, radius) result(share)
    real(real64), intent(in) :: distance, radius   ! of the other circle
    real(real64) :: cosine

    share = 0.0_real64
    if (.not. distance < 1 + radius) return
    if (distance > abs(1 - radius)) then
      cosine = 0.5_real64 * (distance + (1 - radius) * ((1 + radius) / distance))
      cosine = max(-1.0_real64, min(1.0_real64, cosine))
      share = (acos(cosine) - cosine * sqrt(1 - cosine**2)) / pi
    else if (radius < 1.0_real64) then
      share = radius**2
    else if (.not. radius > 1.0_real64) then
      share = 0.5_real64
    end if
  end function ceded_share

  !> Finds the curvature of the field at each circle, its two terms, and the derivative of minus the
  !> sum of the terms by each load.
  subroutine find_curvature_terms(set, curvature, gain, gradient)
    type(circle_set), intent(inout) :: set     !! solved circles; only its tree changes
    !> x and (|y + y0|**2 - |y0|**2)/(1 + x)**2 by circle [1], 0 where the place is fixed
    real(real64), intent(out) :: curvature(:, :)
    real(real64), intent(out) :: gain(:)       !! axial and oval term by circle
    real(real64), intent(out) :: gradient(:)   !! derivative of -sum(gain) by the load
    real(real64), allocatable :: terms(:, :), far(:, :)
    ! Derivatives of the terms of a circle by its q and D.
    real(real64) :: by_axial(size(set%x))
    complex(real64) :: by_oval(size(set%x))
    integer :: i, j, k, l, n

    n = size(set%x)
    allocate (terms(7, size(set%one)), far(6, n))
    call find_pair_terms(set, terms)
    !$omp parallel do schedule(static) if(n > large_set)
    do i = 1, n
      call find_own_terms(set, terms, i, curvature(:, i), gain(i), gradient(i), by_axial(i), &
                          by_oval(i))
    end do
    !$omp end parallel do
    ! Far circles: C - M is the Laplacian of 1/r times a**2/15.
    call sum_sources(set%tree, by_axial * set%radius**2 / 15, spread(0.0_real64, 1, n), far, &
                     set%shift_since)
    !$omp parallel do schedule(static) private(j, k, l) if(n > large_set)
    do i = 1, n
      gradient(i) = gradient(i) - far(2, i) / pi
      do l = set%tree%first(i), set%tree%first(i + 1) - 1
        j = set%tree%near(l)
        k = set%pair(l)
        gradient(i) = gradient(i) - &
          by_axial(j) * (set%terms(compliance, k) - terms(merge(1, 2, i < j), k)) - &
          terms(merge(6, 4, i < j), k) * real(conjg(by_oval(j)) * double_angle(set, k), real64)
      end do
    end do
    !$omp end parallel do
  end subroutine find_curvature_terms

  ! Finds by near pair, with unit loads: the displacements of the first and the second circle; the
  ! oval field by Hertz' pressure and by that of a flat punch on the first, then on the second; the
  ! Hertz mean.
  subroutine find_pair_terms(set, terms)
    type(circle_set), intent(in) :: set
    real(real64), intent(out) :: terms(:, :)
    type(mutual_terms) :: mutual
    real(real64) :: r
    integer :: k

    !$omp parallel do schedule(static) private(r, mutual) if(size(set%one) > large_set)
    do k = 1, size(set%one)
      associate (a => set%radius(set%one(k)), b => set%radius(set%other(k)))
        r = norm2(relative_position(set, set%one(k), set%other(k)))
        call mutual_displacement(r, a, b, mutual)
        terms(:, k) = [mutual%on_first, mutual%on_second, oval_field(r, a, b), &
                       oval_field(r, b, a), mutual%mean]
      end associate
    end do
    !$omp end parallel do
  end subroutine find_pair_terms

  ! Finds the terms of one circle, their derivatives by its q and D, and by its load through q, D
  ! and its size.
  pure subroutine find_own_terms(set, terms, i, curvature, gain, gradient, by_axial, by_oval)
    type(circle_set), intent(in) :: set
    real(real64), intent(in) :: terms(:, :)
    integer, intent(in) :: i
    real(real64), intent(out) :: curvature(2), gain, gradient, by_axial
    complex(real64), intent(out) :: by_oval
    complex(real64) :: oval, hertz_oval, half_difference, turn
    real(real64) :: axial_gain, bend, by_bend, displacement, near_growth, oval_gain, p, q
    integer :: j, k, l

    curvature = 0.0_real64
    gain = 0.0_real64
    gradient = 0.0_real64
    by_axial = 0.0_real64
    by_oval = 0.0_real64
    if (set%shift_fixed(i)) return
    ! The growth of the field of far circles is 5 q.
    q = 0.2_real64 * set%growth(i)
    oval = 0.0_real64
    hertz_oval = 0.0_real64
    do l = set%tree%first(i), set%tree%first(i + 1) - 1
      j = set%tree%near(l)
      k = set%pair(l)
      turn = set%load(j) * double_angle(set, k)
      displacement = terms(merge(1, 2, i < j), k)
      near_growth = 2 * displacement - 3 * set%terms(compliance, k) - &
                    norm2(relative_position(set, i, j)) * &
                    set%terms(merge(first_slope, second_slope, i < j), k)
      q = q + set%load(j) * (displacement - terms(7, k) - 0.2_real64 * near_growth)
      oval = oval + terms(merge(3, 5, i < j), k) * turn
      hertz_oval = hertz_oval + set%terms(hessian_anisotropy, k) * turn
    end do
    associate (load => set%load(i), a => set%radius(i), own_oval => set%own_oval(i))
      p = 0.75_real64 * load / a
      curvature(1) = 7.5_real64 * q / p
      bend = max(1 + curvature(1), least_curvature_share)
      axial_gain = 0.6_real64 * p * load * (1 + curvature(1) / 3 - bend**(1.0_real64 / 3))
      ! R D/2, as products of radii would underflow: a**5 D**2 is 3 p V (R D/2)**2.
      half_difference = a**2 / (2 * p) * oval
      curvature(2) = real(conjg(half_difference) * (half_difference + 2 * own_oval), real64)
      oval_gain = 2.0_real64 / 15 * p * load * curvature(2) * bend**(-5.0_real64 / 3)
      curvature(2) = curvature(2) / bend**2
      by_bend = 12.5_real64 * oval_gain / (bend * p)
      by_axial = 1.5_real64 * load * (1 - bend**(-2.0_real64 / 3))
      by_oval = 2.0_real64 / 15 * a**2 * load * bend**(-5.0_real64 / 3) * &
                (half_difference + own_oval)
      gain = axial_gain + oval_gain
      gradient = -5.0_real64 / 3 * gain + q * (by_axial - by_bend) * 2 / 3
      by_axial = by_axial - by_bend
      gradient = (gradient - by_axial * (set%growth(i) / 3 - q) - 5.0_real64 / 3 * &
                  real(conjg(by_oval) * (hertz_oval - oval), real64)) / load
    end associate
  end subroutine find_own_terms

  ! exp(2 i phi) of the line of centres of a near pair; 0 where they coincide.
  pure complex(real64) function double_angle(set, k)
    type(circle_set), intent(in) :: set
    integer, intent(in) :: k

    double_angle = cmplx(set%terms(direction_x, k), set%terms(direction_y, k), real64)**2
  end function double_angle

end module asperity_circle_correction
