!> Errors of contacts that are solved as Hertzian contacts, by cause.
!>
!> That of the field of the neighbours is estimated by the size of its correction
!> (circle_correction). Those of caps that stand out of the contact that covers them are estimated
!> here, as indicators by the first neglected term, tested against boundary elements, not proved
!> bounds.
module asperity_circle_error
  use asperity_circle_correction, only: circle_correction, find_correction
  use asperity_circle_field, only: are_close
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_coupled_contacts, only: coupled_solution
  use asperity_hidden_contacts, only: find_protrusion
  use asperity_kinds, only: real64
  use asperity_source_tree, only: build_tree, source_tree
  implicit none
  private

  public :: circle_errors, find_errors, find_open_neighbours, sphere_share

  !> Errors by pair: first column of the load, over the modulus; second of the area, over that of
  !> all. They are 0 for open contacts that no circle covers.
  type :: circle_errors
    !> by the field of the neighbours; that of several contacts is the root of the sum of squares
    real(real64), allocatable :: of_field(:, :)
    real(real64), allocatable :: of_shape(:, :)  !! by all other causes; they add up
    integer, allocatable :: covering(:)        !! by open pair: contact that covers it, or 0
    !> by pair: overlaps a contact of at least `nested_ratio` times its radius, and its error may
    !> be larger than estimated
    logical, allocatable :: is_nested(:)
    !> relative error of the compression c at a prescribed load over that of the load L at a
    !> prescribed compression, L/(c dL/dc): 2/3 for an isolated Hertzian contact
    real(real64) :: compression_share = 1.0_real64
  end type circle_errors

  ! Factor of the load of a hidden cap by the pressure of the contact that covers it (measured: 1.33
  ! at most in the four scenes where no other error is larger; test: test_dense.py).
  real(real64), parameter :: hidden_factor = 4.0_real64 / 3.0_real64
  ! Least ratio of the radii of two overlapping contacts for which the sharper one is nested
  ! (chosen; test: nested contacts in test/contact/test_warnings_at_limits.py).
  real(real64), parameter :: nested_ratio = 3.0_real64

contains

  !> Finds the correction of the loads of elastic contacts and the errors that are left.
  subroutine find_errors(pairs, solution, keeps_load, correction, errors)
    type(contact_pairs), intent(in) :: pairs           !! pairs of the position
    type(coupled_solution), intent(inout) :: solution  !! solved contacts; work arrays change
    logical, intent(in) :: keeps_load                  !! the total load is given
    type(circle_correction), intent(out) :: correction  !! of the loads, by circle
    type(circle_errors), intent(out) :: errors         !! errors of the corrected contacts
    type(source_tree) :: tree
    integer, allocatable :: open_pairs(:)
    integer :: i, j, k, l

    allocate (errors%of_field(size(pairs%list), 2), source=0.0_real64)
    errors%of_shape = errors%of_field
    errors%covering = spread(0, 1, size(pairs%list))
    errors%is_nested = errors%covering > 0
    call find_correction(solution%set, keeps_load, pairs%interrupt, correction)
    errors%compression_share = sum(solution%set%load) / (solution%compression * correction%tangent)
    associate (set => solution%set)
      do k = 1, size(set%contact)
        i = set%contact(k)
        do l = set%tree%first(k), set%tree%first(k + 1) - 1
          j = set%tree%near(l)
          if (pairs%list(set%contact(j))%radius >= nested_ratio * pairs%list(i)%radius) &
            errors%is_nested(i) = errors%is_nested(i) .or. are_close(set, k, j, 1.0_real64)
        end do
      end do
      errors%of_field(set%contact, 1) = correction%load_error
      call find_open_neighbours(pairs, solution, 1.0_real64, tree, open_pairs)
      do l = 1, size(open_pairs)
        i = open_pairs(l)
        do k = tree%first(l), tree%first(l + 1) - 1
          j = set%contact(tree%near(k))
          if (errors%covering(i) == 0) errors%covering(i) = j
          errors%of_shape(i, 1) = errors%of_shape(i, 1) + 2 * hidden_factor * &
            set%radius(tree%near(k)) * mean_protrusion(pairs, solution, i, tree%near(k))
        end do
      end do
      ! The ellipticity of a contact increases its area by 4/3 of the increase of the load.
      errors%of_shape(:, 2) = 4.0_real64 / 3 * errors%of_shape(:, 1) / sum(set%load)
      errors%of_shape(set%contact, 2) = errors%of_shape(set%contact, 2) + &
                                        correction%shared_area_error
      errors%of_field(set%contact, 2) = correction%area_error
    end associate
  end subroutine find_errors

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

  !> Relative decrease of the load of a sphere from that of its paraboloid: p/(10 R) under a plane,
  !! to first order (the next term of the gap is r**4/(8 R**3)). A plane has the radius 0 and no
  !! term.
  elemental real(real64) function sphere_share(pair, p) result(share)
    type(contact_pair), intent(in) :: pair   !! pair of asperities, or one and a plane
    real(real64), intent(in) :: p            !! penetration of the pair, > 0

    share = 0.0_real64
    if (pair%upper_radius > 0.0_real64) share = 1.0_real64 / pair%upper_radius**3
    if (pair%lower_radius > 0.0_real64) share = share + 1.0_real64 / pair%lower_radius**3
    share = min(0.5_real64, share * pair%radius**2 * p / 10)
  end function sphere_share

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
