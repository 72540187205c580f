!> Hertzian contacts on one half-space: their potential energy and the field of their pressures.
!>
!> The potential has loads V and lateral shifts s as its variables; g gap, R radius, c compression,
!> p(V) penetration:
!>
!>     Phi = sum W(V_i) + 1/2 sum V_i V_j G_ij + sum V_i (g_i + s_i**2/(2 R_i)) - c sum V_i
!>
!> W' = p, and G_ij is the displacement by a unit load with Hertz' pressure on circle j, mean with
!> Hertz' pressure on circle i, at the shifted places. As a circle grows with the third root of its
!> load, d(V_i V_j G_ij)/dV_i = V_j M_ij, the mean with the pressure of a flat punch on i, which is
!> the exact displacement u of contact i to first order (reciprocal theorem). So dPhi/dV = p + u + g
!> + s**2/(2 R) - c, and dPhi/ds = V (s/R + slope of the field): Phi is stationary at equilibrium.
!>
!> Loads are over the combined modulus. The field of near pairs is in closed form, that of all
!> others two terms of a series, summed by a tree: from `near_factor` sums of radii on, the
!> remainder over the penetration is below 7e-5 times the share of the area in contact.
module asperity_circle_field
  use asperity_constants, only: pi
  use asperity_kinds, only: int64, real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms
  use asperity_process, only: check_memory
  use asperity_source_tree, only: build_tree, source_tree, sum_sources
  implicit none
  private

  public :: are_close, circle_set, find_field, flat_spread, hertz_spread, inclination_factor, &
            list_near_circles, pair_hessian, relative_position

  !> Sums of radii [1] below which a pair is near: farther off sums are by a tree; derived, the
  !> error of the Laplacian of 1/r there is 1e-4; test: coupled_suite.f90.
  real(real64), parameter, public :: near_factor = 5.0_real64

  !> Sums of radii [1] up to which circles are in one block or group; chosen: farther off a field
  !> bends little; with 1.5 dense caps take as many steps.
  real(real64), parameter, public :: close_distance = 2.0_real64

  !> Share of a second derivative of a circle without neighbours [1] that is left of it at least, so
  !> that a model is convex; chosen, scenes need as many steps with 0.03 and 0.3.
  real(real64), parameter, public :: least_curvature_share = 0.1_real64

  !> Error of a sum over many circles [1], a share of the largest displacement; measured in
  !> summation_suite.
  real(real64), parameter, public :: sum_error = 1.0e-8_real64
  !> The same over few circles [1], and error of a given load; measured in mutual_suite.
  real(real64), parameter, public :: rounding_error = 1.0e-13_real64

  !> Least share of linear equations that a solve leaves [1]; derived: the sums of a product are in
  !> error by 2e-4.
  real(real64), parameter, public :: linear_residual = 1.0e-3_real64

  !> Circles [1] above which a set is large: sums have the error `sum_error`, the residual of a
  !> solution is larger, neighbour lists are kept to the end, total loads are sums of partial sums
  !> of so many, a group has no more, and threads share the work; chosen; test: coupled_suite.f90.
  integer, parameter, public :: large_set = 1000

  ! Memory of a near pair, bytes, derived: 56 of its terms, 24 of its circles and places in lists,
  ! both twice, as a step keeps the state before it, 56 of the lists that blocks are made from.
  integer(int64), parameter :: bytes_of_pair = 216_int64
  !> The same of a circle, derived: 1152 of a full block of 16, 440 of set, solution and step, 308
  !> of the tree, both again for the state before.
  integer(int64), parameter, public :: bytes_of_circle = 2648_int64

  !> Loaded contacts, one a circle, and their field. Arrays have one element, or column, a circle.
  type :: circle_set
    integer, allocatable :: contact(:)           !! index in the list of pairs
    real(real64), allocatable :: x(:), y(:)      !! first touches [length]
    real(real64), allocatable :: curvature(:)    !! 1/R [1/length]; 0 where the shift is fixed
    !> half of the difference of the principal curvatures over their mean, with twice the azimuth of
    !> the larger one [1]
    complex(real64), allocatable :: own_oval(:)
    logical, allocatable :: shift_fixed(:)       !! the centre of pressure stays at x, y
    real(real64), allocatable :: shift(:, :)     !! lateral shift s of the centre (2, circle)
    real(real64), allocatable :: load(:)         !! V: load over the modulus, more than 0
    real(real64), allocatable :: load_share(:)   !! part in the prescribed total load, over `load`
    real(real64), allocatable :: radius(:)       !! contact radius a [length]
    real(real64), allocatable :: stiffness(:)    !! dV/dp, p penetration
    real(real64), allocatable :: displacement(:)  !! u: displacement by neighbours [length]
    real(real64), allocatable :: growth(:)       !! du/d(log a) [length]
    !> slope of the field, mean with Hertz' pressure and with that of a flat punch (2, circle)
    real(real64), allocatable :: slope(:, :), flat_slope(:, :)
    real(real64), allocatable :: hessian(:, :)   !! second derivatives of Phi by s: xx, xy, yy
    !> the same over V, without near circles
    real(real64), allocatable :: far_hessian(:, :)
    !> field from outside: second derivatives xx, xy, yy, and the shift where its slope is zero
    real(real64), allocatable :: outer_field(:, :)
    real(real64) :: energy = 0.0_real64          !! 1/2 sum V V G
    type(source_tree) :: tree                    !! of the centres
    real(real64), allocatable :: listed(:, :)    !! radii, shifts of the neighbour lists (3, circle)
    real(real64), allocatable :: shift_since(:, :)  !! shifts less those, at the last field
    integer, allocatable :: pair(:)              !! near pair of each entry of the neighbour lists
    integer, allocatable :: one(:), other(:)     !! circles of each near pair
    real(real64), allocatable :: terms(:, :)     !! (quantity, near pair): indices below
  contains
    procedure :: allocate_arrays
  end type circle_set

  !> Indices, chosen, of the quantities of a near pair: compliance M; slope of the displacement of
  !> the first and of the second circle; second derivatives of G across the line of centres, and
  !> along it less across; direction from the second circle to the first.
  integer, parameter, public :: compliance = 1, first_slope = 2, second_slope = 3, &
                                slope_over_distance = 4, hessian_anisotropy = 5, &
                                direction_x = 6, direction_y = 7

contains

  !> Allocates the arrays, filled with zeros. The tree keeps its expansions.
  subroutine allocate_arrays(self, n)
    class(circle_set), intent(inout) :: self  !! gets new arrays, all zero
    integer, intent(in) :: n                  !! number of circles

    if (allocated(self%outer_field)) deallocate (self%outer_field)
    if (allocated(self%one)) deallocate (self%pair, self%one, self%other, self%terms)
    self%contact = spread(0, 1, n)
    self%shift_fixed = spread(.false., 1, n)
    self%x = spread(0.0_real64, 1, n)
    self%y = self%x
    self%own_oval = spread((0.0_real64, 0.0_real64), 1, n)
    self%curvature = self%x
    self%load = self%x
    self%load_share = self%x
    self%radius = self%x
    self%stiffness = self%x
    self%displacement = self%x
    self%growth = self%x
    self%shift = spread(self%x, 1, 2)
    self%slope = self%shift
    self%flat_slope = self%shift
    self%hessian = spread(self%x, 1, 3)
    self%far_hessian = self%hessian
  end subroutine allocate_arrays

  !> Factor with which an inclined contact presses the surface down, over its vertical load.
  !>
  !> With its vertical gap on a level half-space, as boundary elements have it, a shallow pair of
  !> slope m carries (1 + m**2)**(1/4) of Hertz' load along the line of centres, which is
  !> (1 + m**2)**(3/4) of its vertical part. The factor makes the field of a Hertzian contact that
  !> of elements; both are exact to the order m**2.
  elemental real(real64) function inclination_factor(cosine)
    real(real64), intent(in) :: cosine  !! of the contact's inclination, more than 0

    inclination_factor = 1.0_real64 / (cosine * sqrt(cosine))
  end function inclination_factor

  !> Half of the mean square of a row with Hertz' weight: what widens 1/r by its Laplacian.
  elemental real(real64) function hertz_spread(radius)
    real(real64), intent(in) :: radius  !! of the circle [length]

    hertz_spread = radius**2 / 10
  end function hertz_spread

  !> Half of the mean square of a flat row: what widens 1/r by its Laplacian.
  elemental real(real64) function flat_spread(radius)
    real(real64), intent(in) :: radius  !! of the circle [length]

    flat_spread = radius**2 / 6
  end function flat_spread

  !> Builds the tree and the neighbour lists. They are valid for these circles as long as radii and
  !> shifts change little.
  subroutine list_near_circles(set)
    type(circle_set), intent(inout) :: set  !! centres and radii; gets tree, lists and pairs
    integer, allocatable :: cursor(:), near(:)
    integer :: i, j, k, pairs

    if (allocated(set%listed)) deallocate (set%listed)
    allocate (set%listed(3, size(set%x)))
    set%listed(1, :) = set%radius
    set%listed(2:, :) = set%shift
    call build_tree(set%tree, set%x + set%shift(1, :), set%y + set%shift(2, :), set%radius, &
                    near_factor)
    if (allocated(set%tree%failure)) return
    pairs = size(set%tree%near) / 2
    if (allocated(set%pair)) deallocate (set%pair, set%one, set%other, set%terms)
    call check_memory('the near pairs of contacts', set%tree%failure, &
                      bytes=bytes_of_pair * pairs)
    if (allocated(set%tree%failure)) return
    allocate (set%pair(2 * pairs), set%one(pairs), set%other(pairs), set%terms(direction_y, pairs))
    allocate (cursor(size(set%x)), source=set%tree%first(:size(set%x)))
    allocate (near, source=set%tree%near)
    pairs = 0
    do i = 1, size(set%x)
      do k = set%tree%first(i), set%tree%first(i + 1) - 1
        j = near(k)
        if (j < i) cycle
        pairs = pairs + 1
        set%one(pairs) = i
        set%other(pairs) = j
        ! Neighbours of lower index come first in each list.
        set%pair(cursor([i, j])) = pairs
        set%tree%near(cursor([i, j])) = [j, i]
        cursor([i, j]) = cursor([i, j]) + 1
      end do
    end do
  end subroutine list_near_circles

  !> Finds the field of all other circles at each circle.
  subroutine find_field(set)
    type(circle_set), intent(inout) :: set  !! loads, radii, shifts, lists; gets field and terms
    real(real64), allocatable :: far(:, :)
    type(mutual_terms), allocatable :: batch(:)
    integer :: from, k, n, to

    n = size(set%x)
    set%shift_since = set%shift - set%listed(2:, :)
    ! The terms of as many pairs at a time as there are circles.
    allocate (far(6, n), batch(min(n, size(set%one))))
    call sum_sources(set%tree, set%load, hertz_spread(set%radius), far, set%shift_since)
    !$omp parallel do schedule(static) if(n > large_set)
    do k = 1, n
      call set_far_field(set, k, far(:, k))
    end do
    !$omp end parallel do
    set%energy = 0.5_real64 * sum(set%load * (far(1, :) + hertz_spread(set%radius) * far(2, :)))
    do from = 1, size(set%one), n
      to = min(from + n - 1, size(set%one))
      if (to - from <= large_set) then
        do k = from, to
          call find_terms(set, k, batch(k - from + 1))
          call add_displacements(set, k, batch(k - from + 1))
          call add_slopes(set, k, batch(k - from + 1))
        end do
        cycle
      end if
      !$omp parallel do schedule(static)
      do k = from, to
        call find_terms(set, k, batch(k - from + 1))
      end do
      !$omp end parallel do
      ! The order of summation does not depend on the number of threads.
      !$omp parallel sections private(k)
      do k = from, to
        call add_displacements(set, k, batch(k - from + 1))
      end do
      !$omp section
      do k = from, to
        call add_slopes(set, k, batch(k - from + 1))
      end do
      !$omp end parallel sections
    end do
  end subroutine find_field

  ! Sets the field of far circles at one circle from the sums over 1/r.
  subroutine set_far_field(set, k, far_field)
    type(circle_set), intent(inout) :: set
    integer, intent(in) :: k
    real(real64), intent(inout) :: far_field(6)

    far_field = far_field / pi
    associate (spread_term => flat_spread(set%radius(k)) * far_field(2))
      set%displacement(k) = far_field(1) + spread_term
      set%growth(k) = 2 * spread_term
      set%slope(:, k) = far_field(3:4)
      set%far_hessian(:, k) = [set%curvature(k) + 0.5_real64 * far_field(2) + far_field(5), &
                               far_field(6), &
                               set%curvature(k) + 0.5_real64 * far_field(2) - far_field(5)]
      if (allocated(set%outer_field)) call add_outer_field(set, k)
      set%hessian(:, k) = set%load(k) * set%far_hessian(:, k)
      set%flat_slope(:, k) = set%slope(:, k)
    end associate
  end subroutine set_far_field

  ! Adds the field from outside.
  subroutine add_outer_field(set, k)
    type(circle_set), intent(inout) :: set
    integer, intent(in) :: k
    real(real64) :: offset(2), slope(2)

    associate (outer => set%outer_field(:, k))
      offset = set%shift(:, k) - outer(4:5)
      slope = outer(1:2) * offset(1) + outer(2:3) * offset(2)
      set%displacement(k) = set%displacement(k) + 0.5_real64 * dot_product(slope, offset)
      set%slope(:, k) = set%slope(:, k) + slope
      set%far_hessian(:, k) = set%far_hessian(:, k) + outer(:3)
    end associate
  end subroutine add_outer_field

  ! Finds the terms of one near pair and keeps those that products need.
  subroutine find_terms(set, k, terms)
    type(circle_set), intent(inout) :: set
    integer, intent(in) :: k
    type(mutual_terms), intent(out) :: terms
    real(real64) :: offset(2), r

    associate (i => set%one(k), j => set%other(k))
      offset = relative_position(set, i, j)
      r = sqrt(sum(offset**2))
      call mutual_displacement(r, set%radius(i), set%radius(j), terms)
    end associate
    set%terms(compliance, k) = terms%compliance
    set%terms(first_slope, k) = terms%first_slope
    set%terms(second_slope, k) = terms%second_slope
    ! Concentric circles: the slope is zero and all directions are alike.
    set%terms(slope_over_distance, k) = terms%bend
    set%terms(hessian_anisotropy:direction_y, k) = 0.0_real64
    if (.not. r > 0.0_real64) return
    set%terms(slope_over_distance, k) = terms%slope / r
    set%terms(hessian_anisotropy, k) = terms%bend - terms%slope / r
    set%terms(direction_x:direction_y, k) = offset / r
  end subroutine find_terms

  ! Adds displacements and second derivatives of a near pair.
  subroutine add_displacements(set, k, terms)
    type(circle_set), intent(inout) :: set
    integer, intent(in) :: k
    type(mutual_terms), intent(in) :: terms
    real(real64) :: hessian(3)

    associate (i => set%one(k), j => set%other(k), load => set%load)
      set%energy = set%energy + load(i) * load(j) * terms%mean
      set%displacement(i) = set%displacement(i) + load(j) * terms%on_first
      set%displacement(j) = set%displacement(j) + load(i) * terms%on_second
      set%growth(i) = set%growth(i) + load(j) * terms%first_growth
      set%growth(j) = set%growth(j) + load(i) * terms%second_growth
      hessian = load(i) * load(j) * pair_hessian(set, k)
      set%hessian(:, i) = set%hessian(:, i) + hessian
      set%hessian(:, j) = set%hessian(:, j) + hessian
    end associate
  end subroutine add_displacements

  ! Adds the slopes of a near pair.
  subroutine add_slopes(set, k, terms)
    type(circle_set), intent(inout) :: set
    integer, intent(in) :: k
    type(mutual_terms), intent(in) :: terms

    associate (i => set%one(k), j => set%other(k), load => set%load, &
               direction => set%terms(direction_x:direction_y, k))
      set%slope(:, i) = set%slope(:, i) + load(j) * terms%slope * direction
      set%slope(:, j) = set%slope(:, j) - load(i) * terms%slope * direction
      set%flat_slope(:, i) = set%flat_slope(:, i) + load(j) * terms%first_slope * direction
      set%flat_slope(:, j) = set%flat_slope(:, j) - load(i) * terms%second_slope * direction
    end associate
  end subroutine add_slopes

  !> Whether the centres of two circles are nearer than a multiple of the sum of their radii.
  pure logical function are_close(set, one, other, sums)
    type(circle_set), intent(in) :: set   !! circles with centres and radii
    integer, intent(in) :: one, other     !! indices of the circles
    real(real64), intent(in) :: sums      !! multiple of the sum of radii

    are_close = sum(relative_position(set, one, other)**2) < &
                (sums * (set%radius(one) + set%radius(other)))**2
  end function are_close

  !> Position of the centre of a circle relative to that of another one.
  pure function relative_position(set, one, other) result(offset)
    type(circle_set), intent(in) :: set   !! circles with their centres
    integer, intent(in) :: one, other     !! indices of the circles
    real(real64) :: offset(2)

    offset = [set%x(one) - set%x(other), set%y(one) - set%y(other)] + &
             (set%shift(:, one) - set%shift(:, other))
  end function relative_position

  !> Second derivatives of the compliance G of a near pair by the relative shift: xx, xy, yy.
  pure function pair_hessian(set, k) result(hessian)
    type(circle_set), intent(in) :: set  !! circles with their field
    integer, intent(in) :: k             !! index of the pair
    real(real64) :: hessian(3)

    associate (x => set%terms(direction_x, k), y => set%terms(direction_y, k))
      hessian = set%terms(slope_over_distance, k) * [1, 0, 1] + &
                set%terms(hessian_anisotropy, k) * [x * x, x * y, y * y]
    end associate
  end function pair_hessian

end module asperity_circle_field
