!> Errors of contacts as Hertzian contacts, contact by contact.
!>
!> Away from overlap the missing part is ellipticity: the harmonics n >= 2 of the neighbours' field
!> on the edge of a circle. The load gains E R/(2 a) (U0**2 + 1/2 sum U_n**2) to second order, and
!> the oval contact displaces its neighbours less. Of a point load V at r the harmonics from 2 on
!> are below B = 2 V a**2/(pi E r (r**2 - a**2)), and those above 2 add up to B**2/18 at most.
!> Beside a large circle B is 2/3 a**2 times what its field bends more along than across, if more.
!> Where circles overlap, one of the two takes from the other at most a share of the smaller load.
module asperity_circle_error
  use asperity_circle_field, only: are_close, hessian_anisotropy, relative_position, many
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

  ! Largest share of the smaller load that two overlapping contacts take from each other: all of it
  ! where one centre is inside the other circle, else this (measured on two to thirty caps against
  ! elements: 0.23 at most; test: circles in test/unit/joint_suite.f90).
  real(real64), parameter :: taken = 0.25_real64
  ! Factor of terms of first order: of the load that a hidden cap bears by the pressure of its host
  ! (measured: 1.33 at most in the four scenes where nothing else is larger), and of the load that
  ! neighbours gain by an oval contact over its own gain (chosen; test: circles in
  ! test/unit/joint_suite.f90).
  real(real64), parameter :: first_order = 4.0_real64 / 3.0_real64
  ! Slope times R over the radius of a contact beyond which it is on a flank and has lost half of
  ! this share of its rise (chosen; test: errors in test/regression/test_dense.py).
  real(real64), parameter :: steep = 0.6_real64
  ! Error of an inclined contact, an ellipse that neighbours see as a circle: share of the load that
  ! neighbours take, over the slope squared (measured: 0.054 at most on 33 scenes of slopes from
  ! 0.14 to 0.56 where nothing else is larger; test: steep scenes in test/regression/test_dense.py).
  real(real64), parameter :: inclined = 0.06_real64
  ! Error of a sphere as a paraboloid by the penetration that neighbours take: once as the ratio to
  ! the load of the isolated contact, 1.5 times as neighbours are displaced less (derived: 2.5;
  ! measured: 3.3 at most; test: errors in test/regression/test_dense.py).
  real(real64), parameter :: fourth_power = 3.5_real64
  ! Relative residual of the weights (chosen; test: errors of the compression in
  ! test/unit/joint_suite.f90), and their factor, as they are of first order (chosen; test: ibid.).
  real(real64), parameter :: weight_left = 0.03_real64, weight_factor = 2.0_real64
  ! Ratio of radii from which on a contact that overlaps the circle of a blunter one is nested
  ! (chosen; test: nested contacts in test/regression/test_warnings_at_limits.py).
  real(real64), parameter :: blunter = 3.0_real64

contains

  !> Errors of the loads of elastic contacts over the modulus: a bound that is observed, not proved.
  !> Zero where a contact is open and near to none.
  subroutine find_errors(pairs, solution, hosts, error, sphere_error, compression_share, nested)
    type(contact_pairs), intent(in) :: pairs           !! pairs of the position
    type(coupled_solution), intent(inout) :: solution  !! solved contacts, as they are
    integer, intent(out) :: hosts(:)                   !! circle that hides an open pair, else 0
    real(real64), intent(out) :: error(:)              !! errors by pair, with those at neighbours
    real(real64), intent(out) :: sphere_error(:)       !! errors of spheres as paraboloids, by pair
    !> relative error of the closing at a load over that of the load L at a closing c:
    !! L/(c dL/dc), 2/3 for a Hertz contact alone
    real(real64), intent(out) :: compression_share
    !> share of the load on contacts that overlap the circle of one at least `blunter` times
    !! blunter: their errors may be larger than indicated
    real(real64), intent(out) :: nested
    type(source_tree) :: tree
    integer, allocatable :: number(:)
    real(real64) :: weight(size(solution%set%contact)), tangent
    logical :: is_nested(size(weight))
    integer :: i, j, k, l

    error = 0.0_real64
    sphere_error = 0.0_real64
    hosts = 0
    call find_weights(pairs, solution, weight, tangent)
    compression_share = sum(solution%set%load) / (solution%closing * tangent)
    associate (set => solution%set)
      !$omp parallel do private(i) schedule(static) if(size(set%contact) > many)
      do k = 1, size(set%contact)
        i = set%contact(k)
        call estimate_contact_error(pairs, solution, k, error(i), sphere_error(i), is_nested(k))
        error(i) = weight(k) * error(i)
        sphere_error(i) = weight(k) * sphere_error(i)
      end do
      !$omp end parallel do
      nested = sum(set%load, mask=is_nested) / sum(set%load)
      call find_open_neighbours(pairs, solution, 1.0_real64, tree, number)
      do l = 1, size(number)
        i = number(l)
        do k = tree%first(l), tree%first(l + 1) - 1
          j = set%contact(tree%near(k))
          if (hosts(i) == 0) hosts(i) = j
          error(i) = error(i) + weight(tree%near(k)) * 2 * first_order * &
                     set%radius(tree%near(k)) * mean_protrusion(pairs, solution, i, tree%near(k))
        end do
      end do
    end associate
  end subroutine find_errors

  ! Gain of the total load over that of one contact: as it bears more, its neighbours bear less. To
  ! first order the total changes with the gap of contact i by x_i, where all gaps together change
  ! the loads by x.
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
    call find_step(solution%set, model, weight_left, radius, step, products, pairs%interrupt)
    ! Conjugate gradients come to it from below.
    tangent = sum(step%change(1, :))
    associate (set => solution%set)
      do k = 1, size(weight)
        weight(k) = step%change(1, k)
        ! Circles that overlap are one contact.
        do l = set%tree%first(k), set%tree%first(k + 1) - 1
          associate (j => set%tree%near(l))
            if (are_close(set, k, j, 1.0_real64)) weight(k) = weight(k) + step%change(1, j)
          end associate
        end do
      end do
      weight = min(1.0_real64, weight_factor * abs(weight) / set%stiffness)
    end associate
  end subroutine find_weights

  !> Finds the open pairs that could touch, and the circles near them.
  subroutine find_open_neighbours(pairs, solution, radii, tree, number)
    type(contact_pairs), intent(in) :: pairs        !! pairs of the position
    type(coupled_solution), intent(in) :: solution  !! solution of all contacts
    real(real64), intent(in) :: radii               !! radii of a circle that reach to its pairs
    type(source_tree), intent(inout) :: tree        !! circles of the solution; targets: open pairs
    integer, allocatable, intent(out) :: number(:)  !! places of the open pairs in the list
    logical :: is_open(size(pairs%list))
    integer :: i

    is_open = pairs%list%gap < solution%closing
    is_open(solution%set%contact) = .false.
    number = pack([(i, i=1, size(is_open))], is_open)
    associate (set => solution%set)
      call build_tree(tree, [set%x + set%shift(1, :), pairs%list(number)%x], &
                      [set%y + set%shift(2, :), pairs%list(number)%y], &
                      [set%radius, spread(0.0_real64, 1, size(number))], radii, size(set%x))
    end associate
  end subroutine find_open_neighbours

  ! Errors of one contact.
  subroutine estimate_contact_error(pairs, solution, k, error, sphere_error, is_nested)
    type(contact_pairs), intent(in) :: pairs
    type(coupled_solution), intent(in) :: solution
    integer, intent(in) :: k
    real(real64), intent(out) :: error, sphere_error
    logical, intent(out) :: is_nested
    real(real64) :: a, p, r, offset(2), apart, distance, emission, overlap, least_ratio, shift, &
      apart_emission
    integer :: l, j

    associate (set => solution%set)
      a = set%radius(k)
      p = solution%penetration(set%contact(k))
      r = pairs%list(set%contact(k))%radius
      overlap = 0.0_real64
      least_ratio = huge(1.0_real64)
      is_nested = .false.
      do l = set%tree%first(k), set%tree%first(k + 1) - 1
        j = set%tree%near(l)
        distance = norm2(relative_position(set, j, k))
        if (.not. distance < a + set%radius(j)) cycle
        least_ratio = min(least_ratio, distance / max(a, set%radius(j)))
        is_nested = is_nested .or. pairs%list(set%contact(j))%radius >= blunter * r
        ! Half of the error of both.
        overlap = overlap + 0.5_real64 * min(set%load(k), set%load(j)) * &
          merge(1.0_real64, taken, distance < max(a, set%radius(j)))
      end do
      call find_harmonics(.true., error, emission)
      if (overlap > 0.0_real64) then
        call find_harmonics(.false., apart, apart_emission)
        ! Where a centre is inside the other's circle harmonics mean nothing.
        if (least_ratio < 1.0_real64) error = huge(1.0_real64)
        error = min(error + emission, apart + apart_emission + overlap)
        emission = 0.0_real64
      end if
      shift = norm2(set%shift(:, k))
      if (shift > steep * a) error = max(error, load_gain(r, p, steep * shift**2 / (4 * r)))
      error = error + emission
      ! An inclined contact is an ellipse that neighbours see as a circle.
      associate (pair => pairs%list(set%contact(k)), &
                 displacement => max(0.0_real64, solution%closing - &
                                     pairs%list(set%contact(k))%gap - p))
        error = error + set%load(k) * inclined * displacement / (p + displacement) * &
                (pair%d / pair%zc)**2
        sphere_error = set%load(k) * fourth_power * sphere_share(pair, min(p, displacement))
      end associate
    end associate

  contains

    ! Own gain, and that of the neighbours. A second harmonic is a complex number: b at twice the
    ! angle of the neighbour.
    subroutine find_harmonics(with_overlapping, gain, neighbour_gain)
      logical, intent(in) :: with_overlapping
      real(real64), intent(out) :: gain, neighbour_gain
      real(real64) :: b(solution%set%tree%first(k):solution%set%tree%first(k + 1) - 1), square
      complex(real64) :: second(lbound(b, 1):ubound(b, 1))

      associate (set => solution%set, near => solution%set%tree%near)
        do l = lbound(b, 1), ubound(b, 1)
          j = near(l)
          offset = relative_position(set, j, k)
          ! In one place nothing is known: a large bound.
          square = max(sum(offset**2), 1.0e-6_real64 * a**2)
          b(l) = 1.0_real64 / (sqrt(square) * max(square - a**2, 0.1_real64 * square))
          if (square > (a + set%radius(j))**2) &
            b(l) = max(b(l), set%terms(hessian_anisotropy, set%pair(l)) * pi / 3)
          b(l) = 2 * set%load(j) * a**2 / pi * b(l)
          if (square < (a + set%radius(j))**2 .and. .not. with_overlapping) b(l) = 0.0_real64
          second(l) = b(l) * cmplx(offset(1), offset(2), real64)**2 / square
        end do
        gain = r / (4 * a) * (abs(sum(second))**2 + 1.0_real64 / 18 * sum(b)**2)
        neighbour_gain = first_order * r / (4 * a) * sum( &
          p / solution%penetration(set%contact(near(lbound(b, 1):ubound(b, 1)))) * &
          abs(real(second * conjg(sum(second))) + 1.0_real64 / 18 * b * sum(b)))
      end associate
    end subroutine find_harmonics

  end subroutine estimate_contact_error

  ! Relative loss of load of a sphere against its paraboloid: p/(10 R) under a flat, to first order
  ! (the next term of the gap is r**4/(8 R**3)). A plane has the radius 0, and no such term.
  pure real(real64) function sphere_share(pair, p) result(share)
    type(contact_pair), intent(in) :: pair
    real(real64), intent(in) :: p

    share = 0.0_real64
    if (pair%upper_radius > 0.0_real64) share = 1.0_real64 / pair%upper_radius**3
    if (pair%lower_radius > 0.0_real64) share = share + 1.0_real64 / pair%lower_radius**3
    share = min(0.5_real64, share * pair%radius**2 * p / 10)
  end function sphere_share

  ! Load that a contact gains by a rise of its penetration.
  pure real(real64) function load_gain(radius, p, rise)
    real(real64), intent(in) :: radius, p, rise

    ! Powers of ratios: the same digits in any unit.
    load_gain = 4.0_real64 / 3.0_real64 * radius**2 * &
             (max(0.0_real64, (p + rise) / radius)**1.5_real64 - &
              max(0.0_real64, p / radius)**1.5_real64)
  end function load_gain

  ! Mean over a circle, weighed as a flat punch, of how far the surface of an open pair stands above
  ! that of the circle's own: of a cap with its top in the circle the volume of its paraboloid, else
  ! of a plane (along a line all of the weight lies evenly). No more than at the highest place.
  pure real(real64) function mean_protrusion(pairs, solution, i, k) result(mean)
    type(contact_pairs), intent(in) :: pairs
    type(coupled_solution), intent(in) :: solution
    integer, intent(in) :: i, k
    real(real64) :: distance, slope, part

    associate (a => solution%set%radius(k), own => pairs%list(solution%set%contact(k)))
      call find_protrusion(pairs, solution%set, k, i, a, mean, distance, slope)
      mean = max(0.0_real64, mean)
      part = 4 * slope * a
      if (distance < a) part = 2 * (1.0_real64 / pairs%list(i)%radius - 1.0_real64 / own%radius) * &
                               a**2 * sqrt(1.0_real64 - (distance / a)**2)
      if (mean < part) mean = mean**2 / part
    end associate
  end function mean_protrusion

end module asperity_circle_error
