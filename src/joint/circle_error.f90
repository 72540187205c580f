!> Errors of contacts that are solved as Hertzian contacts, contact by contact: indicators by the
!> first neglected terms, tested against boundary elements, not proved bounds.
!>
!> Separate contacts: the neglected part is ellipticity, by the harmonics n >= 2 of the field of the
!> neighbours on the edge of the circle. The load increases by E R/(2 a) (U0**2 + 1/2 sum U_n**2) to
!> second order, and the elliptic contact displaces its neighbours less. For a point load V at the
!> distance r the harmonic 2 is at most B = 2 V a**2/(pi E r (r**2 - a**2)), and those above 2 add
!> at most B**2/18. For a large circle nearby B is 2/3 a**2 times the difference of the second
!> derivatives of its field along and across the line of centres, if that is larger.
!>
!> Overlapping circles: one contact takes at most a share of the smaller of the two loads from the
!> other.
module asperity_circle_error
  use asperity_circle_field, only: are_close, hessian_anisotropy, relative_position, &
                                   thread_threshold
  use asperity_constants, only: pi
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_coupled_contacts, only: coupled_solution
  use asperity_circle_step, only: circle_model, find_step, prepare_model, trust_step
  use asperity_hidden_contacts, only: find_protrusion
  use asperity_kinds, only: real64
  use asperity_source_tree, only: build_tree, source_tree
  implicit none
  private

  public :: find_errors, find_open_neighbours

  ! Largest error of the load of two overlapping contacts, as a share of the smaller load, where no
  ! centre is inside the other circle; else it is 1 (measured on two to thirty caps against
  ! elements: 0.23 at most).
  real(real64), parameter :: overlap_share = 0.25_real64
  ! Factor of two terms of first order: the load of a hidden cap by the pressure of the contact that
  ! covers it (measured: 1.33 at most in the four scenes where no other error is larger), and the
  ! load that neighbours gain by the ellipticity of a contact over its own gain (chosen).
  real(real64), parameter :: first_order_factor = 4.0_real64 / 3.0_real64
  ! Shift of a contact over its radius above which it is on a steep flank: the error of its
  ! penetration is then this share of half the height that the shift has changed (chosen).
  real(real64), parameter :: flank_slope = 0.6_real64
  ! Error of an inclined contact, whose elliptic field is computed as that of a circle: share of the
  ! decrease of its load by neighbours, over the slope squared (measured: 0.054 at most on 33 scenes
  ! of slopes from 0.14 to 0.56 where no other error is larger).
  real(real64), parameter :: inclination_share = 0.06_real64
  ! Factor of the error of a sphere as a paraboloid, by the displacement by neighbours: 1 for the
  ! ratio to the load of the isolated contact, 1.5 as its neighbours are displaced less (derived:
  ! 2.5; measured: 3.3 at most).
  real(real64), parameter :: sphere_factor = 3.5_real64
  ! Relative residual of the weights, and their factor, as they are of first order (chosen).
  real(real64), parameter :: weight_residual = 0.03_real64, weight_factor = 2.0_real64
  ! Least ratio of the radii of two overlapping contacts for which the sharper one is nested
  ! (chosen; test: nested contacts in test/regression/test_warnings_at_limits.py).
  real(real64), parameter :: nested_ratio = 3.0_real64

contains

  !> Estimates the errors of the loads of elastic contacts, over the modulus. They are 0 for open
  !> contacts that no circle covers.
  subroutine find_errors(pairs, solution, covering, error, sphere_error, compression_share, nested)
    type(contact_pairs), intent(in) :: pairs           !! pairs of the position
    type(coupled_solution), intent(inout) :: solution  !! solved contacts; work arrays change
    integer, intent(out) :: covering(:)                !! by open pair: contact that covers it, or 0
    real(real64), intent(out) :: error(:)              !! by pair, including those of neighbours
    real(real64), intent(out) :: sphere_error(:)       !! by pair, of spheres as paraboloids
    !> relative error of the compression c at a prescribed load over that of the load L at a
    !! prescribed compression, L/(c dL/dc): 2/3 for an isolated Hertzian contact
    real(real64), intent(out) :: compression_share
    !> share of the load on contacts that overlap a contact of at least `nested_ratio` times their
    !! radius: their errors may be larger than estimated
    real(real64), intent(out) :: nested
    type(source_tree) :: tree
    integer, allocatable :: open_pairs(:)
    real(real64) :: weight(size(solution%set%contact)), tangent
    logical :: is_nested(size(weight))
    integer :: i, j, k, l

    error = 0.0_real64
    sphere_error = 0.0_real64
    covering = 0
    call find_weights(pairs, solution, weight, tangent)
    compression_share = sum(solution%set%load) / (solution%compression * tangent)
    associate (set => solution%set)
      !$omp parallel do private(i) schedule(static) if(size(set%contact) > thread_threshold)
      do k = 1, size(set%contact)
        i = set%contact(k)
        call estimate_contact_error(pairs, solution, k, error(i), sphere_error(i), is_nested(k))
        error(i) = weight(k) * error(i)
        sphere_error(i) = weight(k) * sphere_error(i)
      end do
      !$omp end parallel do
      nested = sum(set%load, mask=is_nested) / sum(set%load)
      call find_open_neighbours(pairs, solution, 1.0_real64, tree, open_pairs)
      do l = 1, size(open_pairs)
        i = open_pairs(l)
        do k = tree%first(l), tree%first(l + 1) - 1
          j = set%contact(tree%near(k))
          if (covering(i) == 0) covering(i) = j
          error(i) = error(i) + weight(tree%near(k)) * 2 * first_order_factor * &
                     set%radius(tree%near(k)) * mean_protrusion(pairs, solution, i, tree%near(k))
        end do
      end do
    end associate
  end subroutine find_errors

  ! Finds the change of the total load over that of the load of one contact, as the loads of its
  ! neighbours then decrease. To first order the total load changes with the gap of contact i by
  ! x_i, where x are the changes of the loads by an equal change of all gaps. `tangent` is the sum
  ! of x.
  subroutine find_weights(pairs, solution, weight, tangent)
    type(contact_pairs), intent(in) :: pairs
    type(coupled_solution), intent(inout) :: solution
    real(real64), intent(out) :: weight(:), tangent
    type(circle_model) :: model
    type(trust_step) :: step
    real(real64) :: radius
    integer :: products, k, l

    allocate (model%gradient(3, size(weight)), source=0.0_real64)
    model%gradient(1, :) = -1.0_real64
    products = 0
    radius = huge(radius)**0.25_real64
    call prepare_model(solution%set, model)
    call find_step(solution%set, model, weight_residual, radius, step, products, pairs%interrupt)
    ! A lower bound, as conjugate gradients increase it in each iteration.
    tangent = sum(step%change(1, :))
    associate (set => solution%set)
      do k = 1, size(weight)
        weight(k) = step%change(1, k)
        ! Overlapping circles count as one contact.
        do l = set%tree%first(k), set%tree%first(k + 1) - 1
          associate (j => set%tree%near(l))
            if (are_close(set, k, j, 1.0_real64)) weight(k) = weight(k) + step%change(1, j)
          end associate
        end do
      end do
      weight = min(1.0_real64, weight_factor * abs(weight) / set%stiffness)
    end associate
  end subroutine find_weights

  !> Finds the open pairs of negative undeformed gap, and the circles near them.
  subroutine find_open_neighbours(pairs, solution, radii, tree, open_pairs)
    type(contact_pairs), intent(in) :: pairs        !! pairs of the position
    type(coupled_solution), intent(in) :: solution  !! solution of all contacts
    real(real64), intent(in) :: radii               !! distance up to which circles are near, radii
    type(source_tree), intent(inout) :: tree        !! sources: loaded circles; targets: open pairs
    integer, allocatable, intent(out) :: open_pairs(:)  !! indices in the list of pairs
    logical :: is_open(size(pairs%list))
    integer :: i

    is_open = pairs%list%gap < solution%compression
    is_open(solution%set%contact) = .false.
    open_pairs = pack([(i, i=1, size(is_open))], is_open)
    associate (set => solution%set)
      call build_tree(tree, [set%x + set%shift(1, :), pairs%list(open_pairs)%x], &
                      [set%y + set%shift(2, :), pairs%list(open_pairs)%y], &
                      [set%radius, spread(0.0_real64, 1, size(open_pairs))], radii, size(set%x))
    end associate
  end subroutine find_open_neighbours

  ! Estimates the errors of the load of one contact, and whether it is nested (see `find_errors`).
  subroutine estimate_contact_error(pairs, solution, k, error, sphere_error, is_nested)
    type(contact_pairs), intent(in) :: pairs
    type(coupled_solution), intent(in) :: solution
    integer, intent(in) :: k
    real(real64), intent(out) :: error, sphere_error
    logical, intent(out) :: is_nested
    real(real64) :: a, p, r, offset(2), distance, least_ratio, shift
    real(real64) :: neighbour_gain, overlap_error, separate_error, separate_gain
    integer :: l, j

    associate (set => solution%set)
      a = set%radius(k)
      p = solution%penetration(set%contact(k))
      r = pairs%list(set%contact(k))%radius
      overlap_error = 0.0_real64
      least_ratio = huge(1.0_real64)
      is_nested = .false.
      do l = set%tree%first(k), set%tree%first(k + 1) - 1
        j = set%tree%near(l)
        distance = norm2(relative_position(set, j, k))
        if (.not. distance < a + set%radius(j)) cycle
        least_ratio = min(least_ratio, distance / max(a, set%radius(j)))
        is_nested = is_nested .or. pairs%list(set%contact(j))%radius >= nested_ratio * r
        ! Each of the two contacts gets half of their error.
        overlap_error = overlap_error + 0.5_real64 * min(set%load(k), set%load(j)) * &
          merge(1.0_real64, overlap_share, distance < max(a, set%radius(j)))
      end do
      call find_harmonics(.true., error, neighbour_gain)
      if (overlap_error > 0.0_real64) then
        call find_harmonics(.false., separate_error, separate_gain)
        ! Harmonics are no estimate where the centre of one contact is inside the other.
        if (least_ratio < 1.0_real64) error = huge(1.0_real64)
        error = min(error + neighbour_gain, separate_error + separate_gain + overlap_error)
        neighbour_gain = 0.0_real64
      end if
      shift = norm2(set%shift(:, k))
      if (shift > flank_slope * a) &
        error = max(error, load_gain(r, p, flank_slope * shift**2 / (4 * r)))
      error = error + neighbour_gain
      ! An inclined contact is an ellipse, and its field is computed as that of a circle.
      associate (pair => pairs%list(set%contact(k)), &
                 displacement => max(0.0_real64, solution%compression - &
                                     pairs%list(set%contact(k))%gap - p))
        error = error + set%load(k) * inclination_share * displacement / (p + displacement) * &
                (pair%d / pair%zc)**2
        sphere_error = set%load(k) * sphere_factor * sphere_share(pair, min(p, displacement))
      end associate
    end associate

  contains

    ! Finds the gain of the contact's own load by ellipticity, and that of its neighbours. The
    ! second harmonic of a neighbour is a complex number with the modulus b and twice its azimuth.
    subroutine find_harmonics(with_overlapping, gain, gain_of_neighbours)
      logical, intent(in) :: with_overlapping
      real(real64), intent(out) :: gain, gain_of_neighbours
      real(real64) :: b(solution%set%tree%first(k):solution%set%tree%first(k + 1) - 1), square
      complex(real64) :: second_harmonic(lbound(b, 1):ubound(b, 1))

      associate (set => solution%set, near => solution%set%tree%near)
        do l = lbound(b, 1), ubound(b, 1)
          j = near(l)
          offset = relative_position(set, j, k)
          ! Coincident centres: a large bound.
          square = max(sum(offset**2), 1.0e-6_real64 * a**2)
          b(l) = 1.0_real64 / (sqrt(square) * max(square - a**2, 0.1_real64 * square))
          if (square > (a + set%radius(j))**2) &
            b(l) = max(b(l), set%terms(hessian_anisotropy, set%pair(l)) * pi / 3)
          b(l) = 2 * set%load(j) * a**2 / pi * b(l)
          if (square < (a + set%radius(j))**2 .and. .not. with_overlapping) b(l) = 0.0_real64
          second_harmonic(l) = b(l) * cmplx(offset(1), offset(2), real64)**2 / square
        end do
        gain = r / (4 * a) * (abs(sum(second_harmonic))**2 + 1.0_real64 / 18 * sum(b)**2)
        gain_of_neighbours = first_order_factor * r / (4 * a) * sum( &
          p / solution%penetration(set%contact(near(lbound(b, 1):ubound(b, 1)))) * &
          abs(real(second_harmonic * conjg(sum(second_harmonic))) + 1.0_real64 / 18 * b * sum(b)))
      end associate
    end subroutine find_harmonics

  end subroutine estimate_contact_error

  ! Relative decrease of the load of a sphere from that of its paraboloid: p/(10 R) under a plane,
  ! to first order (the next term of the gap is r**4/(8 R**3)). A plane has the radius 0 and no
  ! term.
  pure real(real64) function sphere_share(pair, p) result(share)
    type(contact_pair), intent(in) :: pair
    real(real64), intent(in) :: p

    share = 0.0_real64
    if (pair%upper_radius > 0.0_real64) share = 1.0_real64 / pair%upper_radius**3
    if (pair%lower_radius > 0.0_real64) share = share + 1.0_real64 / pair%lower_radius**3
    share = min(0.5_real64, share * pair%radius**2 * p / 10)
  end function sphere_share

  ! Increase of the load of a contact over the modulus by an increase of its penetration.
  pure real(real64) function load_gain(radius, p, increase)
    real(real64), intent(in) :: radius, p, increase

    ! Powers of ratios: the digits do not depend on the unit.
    load_gain = 4.0_real64 / 3.0_real64 * radius**2 * &
                (max(0.0_real64, (p + increase) / radius)**1.5_real64 - &
                 max(0.0_real64, p / radius)**1.5_real64)
  end function load_gain

  ! Mean over a circle, with the pressure of a flat punch as weight, of the height of the surface of
  ! an open pair above the surface of the contact itself: of a paraboloid if its top is in the
  ! circle, else of a plane (in one direction the weight is uniform).
  pure real(real64) function mean_protrusion(pairs, solution, i, k) result(mean)
    type(contact_pairs), intent(in) :: pairs
    type(coupled_solution), intent(in) :: solution
    integer, intent(in) :: i, k
    real(real64) :: distance, slope, protrusion_range

    associate (a => solution%set%radius(k), own => pairs%list(solution%set%contact(k)))
      call find_protrusion(pairs, solution%set, k, i, a, mean, distance, slope)
      mean = max(0.0_real64, mean)
      protrusion_range = 4 * slope * a
      if (distance < a) protrusion_range = &
        2 * (1.0_real64 / pairs%list(i)%radius - 1.0_real64 / own%radius) * &
        a**2 * sqrt(1.0_real64 - (distance / a)**2)
      if (mean < protrusion_range) mean = mean**2 / protrusion_range
    end associate
  end function mean_protrusion

end module asperity_circle_error
