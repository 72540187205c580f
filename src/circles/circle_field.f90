!> Contacts under load as circles with Hertz' pressure, and what they do to each other.
!>
!> One potential has loads V and shifts s as its variables; g gap, R radius, p(V) penetration:
!>
!>     Phi = sum W(V_i) + 1/2 sum V_i V_j G_ij + sum V_i (g_i + s_i**2/(2 R_i)) - c sum V_i
!>
!> W' = p, and G_ij is the displacement by a unit load with Hertz' pressure on circle j, mean with
!> Hertz' pressure on circle i, at the shifted places. As a circle grows with the third root of its
!> load, d(V_i V_j G_ij)/dV_i = V_j M_ij, the mean with a flat punch on i, which is the exact loss
!> of approach to first order (reciprocal theorem). So dPhi/dV = p + u + g + s**2/(2 R) - c, and
!> dPhi/ds = V (s/R + slope of the field): equilibrium makes Phi stationary.
!>
!> Loads here are over the combined modulus. Near pairs act by closed forms; all others by two terms
!> of their series, which a tree sums: with five sums of radii as the least distance the rest is
!> below 7e-5 times the share of the area in contact, over the penetration.
module asperity_circle_field
  use asperity_constants, only: pi
  use asperity_kinds, only: int64, real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms
  use asperity_problems, only: not_enough_memory
  use asperity_process, only: has_memory
  use asperity_source_tree, only: build_tree, source_tree, sum_sources
  implicit none
  private

  public :: are_close, circle_set, find_field, relative_position, inclination_factor, &
    list_near_circles, &
            pair_hessian

  !> Sums of radii [1] below which a pair is near: farther off sums are by a tree; derived, the
  !> error of the Laplacian of 1/r there is 1e-4; test: summation_suite.f90.
  real(real64), parameter, public :: near_factor = 5.0_real64

  !> Mean squares of a Hertz row and of a flat one, halved [1]: what widens 1/r by its Laplacian;
  !> derived; test: potential_suite.f90.
  real(real64), parameter, public :: hertz_spread = 0.1_real64
  real(real64), parameter, public :: flat_spread = 1.0_real64 / 6  !! derived, as above

  !> Sums of radii [1] up to which circles are in one block or group; chosen: farther off a field
  !> bends little; with 1.5 dense caps take as many steps; test: coupled_suite.f90.
  real(real64), parameter, public :: close_by = 2.0_real64

  !> Share of a second derivative of a circle without neighbours [1] that is left of it at least, so
  !> that a model is convex; chosen, scenes need as many steps with 0.03 and 0.3; test:
  !> coupled_suite.f90.
  real(real64), parameter, public :: least_share = 0.1_real64

  !> Error of a sum over many circles [1], a share of the largest displacement; measured in
  !> summation_suite; test: coupled_suite.f90.
  real(real64), parameter, public :: sum_error = 1.0e-8_real64

  !> Rounds of conjugate gradients at most [1]; chosen, dense scenes need 60; and of iterations on a
  !> few unknowns: a group, a place of contact, squares; chosen, they need 10; test:
  !> coupled_suite.f90.
  integer, parameter, public :: most_rounds = 400, most_repeats = 40

  !> Circles or near pairs [1] from which on threads share the work, and sums are by a tree
  !> with kept near pairs; chosen: less takes microseconds; test: coupled_suite.f90.
  integer, parameter, public :: many = 1000

  ! Memory, bytes, an upper estimate that is compared with what is available. Near pair: 56 of its
  ! terms, 24 of its circles and places in lists, 56 of the lists that blocks are made from. Circle:
  ! 864 of a full block of 12, 440 of set and step, the rest for the tree; derived; test:
  ! test_cost.py.
  integer(int64), parameter :: bytes_of_pair = 136_int64, bytes_of_circle = 1600_int64

  ! Pairs [1] whose terms are found together; chosen, some MB; test: coupled_suite.f90.
  integer, parameter :: batch_size = 65536

  !> Circles under load, and their field. Sizes of all arrays: the number of circles.
  type :: circle_set
    integer, allocatable :: contact(:)           !! place in the list of pairs
    real(real64), allocatable :: x(:), y(:)      !! places without shift
    real(real64), allocatable :: curvature(:)    !! 1/R; 0 where a circle may not shift
    logical, allocatable :: shift_fixed(:)       !! may not shift
    real(real64), allocatable :: shift(:, :)     !! the shifts
    real(real64), allocatable :: load(:)         !! over the modulus
    real(real64), allocatable :: load_share(:)   !! load in the sum that is asked for, over `load`
    real(real64), allocatable :: radius(:)       !! radius of the contact
    real(real64), allocatable :: stiffness(:)    !! of the load by the penetration, over the modulus
    real(real64), allocatable :: displacement(:)  !! u: displacement by the others
    real(real64), allocatable :: displacement_growth(:)  !! d(lift)/d(log of the own radius)
    real(real64), allocatable :: slope(:, :)     !! slope with Hertz' weight
    real(real64), allocatable :: flat_slope(:, :)  !! slope of `lift`
    real(real64), allocatable :: hessian(:, :)   !! second derivatives by the own shift: xx, xy, yy
    !> field from outside: second derivatives xx, xy, yy, and the shift where it is zero
    real(real64), allocatable :: outer_field(:, :)
    !> second derivatives by the own shift over the load, without near circles: xx, xy, yy
    real(real64), allocatable :: far_hessian(:, :)
    real(real64) :: energy = 0.0_real64          !! 1/2 sum V V G
    type(source_tree) :: tree                    !! of the places
    real(real64), allocatable :: listed(:, :)    !! radii and shifts at planting (3, circle)
    real(real64), allocatable :: shift_since(:, :)  !! shifts since then, where the field is known
    integer, allocatable :: pair(:)              !! of each near neighbour
    integer, allocatable :: one(:), other(:)     !! circles of each near pair
    real(real64), allocatable :: terms(:, :)     !! (quantity, near pair), see the constants below
  contains
    procedure :: allocate_arrays                   !! for a number of circles
  end type circle_set

  !> Numbers, chosen, of the quantities of a near pair: compliance; slope of lift of one and of the
  !> other; slope over distance and the rest of the bend, for the tilt; direction from the other to
  !> the one.
  integer, parameter, public :: compliance = 1, first_slope = 2, second_slope = 3, &
    slope_over_distance = 4, direction_x = 6, &
                                direction_y = 7
  !> Number, chosen, of the rest of the bend: second derivative along less that across the line of
  !> centres.
  integer, parameter, public :: hessian_anisotropy = 5

contains

  !> Makes room for circles, without shift. The expansions of its tree are kept.
  subroutine allocate_arrays(self, n)
    class(circle_set), intent(inout) :: self  !! gets new arrays, all zero
    integer, intent(in) :: n                  !! number of circles

    if (allocated(self%outer_field)) deallocate (self%outer_field)
    if (allocated(self%one)) deallocate (self%pair, self%one, self%other, self%terms)
    self%contact = spread(0, 1, n)
    self%shift_fixed = spread(.false., 1, n)
    self%x = spread(0.0_real64, 1, n)
    self%y = self%x
    self%curvature = self%x
    self%load = self%x
    self%load_share = self%x
    self%radius = self%x
    self%stiffness = self%x
    self%displacement = self%x
    self%displacement_growth = self%x
    self%shift = spread(self%x, 1, 2)
    self%slope = self%shift
    self%flat_slope = self%shift
    self%hessian = spread(self%x, 1, 3)
    self%far_hessian = self%hessian
  end subroutine allocate_arrays

  !> Factor with which an inclined contact presses the surface down, over its vertical load.
  !>
  !> Seen through its vertical gap on a level half-space, as cells see it, a shallow pair of slope m
  !> carries (1 + m**2)**(1/4) of Hertz' load along the line of centres, which is (1 + m**2)**(3/4)
  !> of its vertical part. Circles and cells must press alike; the theory is good to the order m**2
  !> in either way.
  elemental real(real64) function inclination_factor(cosine)
    real(real64), intent(in) :: cosine  !! of the contact's inclination, more than 0

    inclination_factor = 1.0_real64 / (cosine * sqrt(cosine))
  end function inclination_factor

  !> Finds who is near whom. To be called when circles come, go or have grown.
  subroutine list_near_circles(set)
    type(circle_set), intent(inout) :: set  !! places, shifts and radii are set
    real(real64), allocatable :: planted(:, :)
    integer, allocatable :: cursor(:), near(:)
    integer :: i, j, k, pairs

    allocate (planted(3, size(set%x)))
    planted(1, :) = set%radius
    planted(2:, :) = set%shift
    call move_alloc(planted, set%listed)
    call build_tree(set%tree, set%x + set%shift(1, :), set%y + set%shift(2, :), set%radius, &
                    near_factor)
    if (allocated(set%tree%failure)) return
    pairs = size(set%tree%near) / 2
    if (allocated(set%pair)) deallocate (set%pair, set%one, set%other, set%terms)
    if (.not. has_memory(bytes_of_pair * pairs + bytes_of_circle * size(set%x))) then
      set%tree%failure = not_enough_memory // ' for the near pairs of contacts'
      return
    end if
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
        ! Each lists those before it first.
        set%pair(cursor([i, j])) = pairs
        set%tree%near(cursor([i, j])) = [j, i]
        cursor([i, j]) = cursor([i, j]) + 1
      end do
    end do
  end subroutine list_near_circles

  !> Finds the field at every circle by all others.
  subroutine find_field(set)
    type(circle_set), intent(inout) :: set  !! planted; loads, radii and shifts are set
    real(real64), allocatable :: far(:, :)
    type(mutual_terms), allocatable :: batch(:)
    integer :: from, k, n, to

    n = size(set%x)
    set%shift_since = set%shift - set%listed(2:, :)
    allocate (far(6, n), batch(min(batch_size, size(set%one))))
    call sum_sources(set%tree, set%load, hertz_spread * set%radius**2, far, set%shift_since)
    !$omp parallel do schedule(static) if(n > many)
    do k = 1, n
      associate (far_field => far(:, k), square => set%radius(k)**2)
        far_field = far_field / pi
        set%displacement(k) = far_field(1) + flat_spread * square * far_field(2)
        set%displacement_growth(k) = 2 * flat_spread * square * far_field(2)
        set%slope(:, k) = far_field(3:4)
        set%far_hessian(:, k) = [set%curvature(k) + 0.5_real64 * far_field(2) + far_field(5), &
                                 far_field(6), &
                                 set%curvature(k) + 0.5_real64 * far_field(2) - far_field(5)]
        if (allocated(set%outer_field)) call add_outer_field(set, k)
        set%hessian(:, k) = set%load(k) * set%far_hessian(:, k)
        set%flat_slope(:, k) = set%slope(:, k)
      end associate
    end do
    !$omp end parallel do
    set%energy = 0.5_real64 * sum(set%load * (far(1, :) + hertz_spread * set%radius**2 * far(2, :)))
    do from = 1, size(set%one), batch_size
      to = min(from + batch_size - 1, size(set%one))
      !$omp parallel do schedule(static) if(to - from > many)
      do k = from, to
        call find_terms(set, k, batch(k - from + 1))
      end do
      !$omp end parallel do
      ! The order of summation does not depend on the number of threads.
      !$omp parallel sections private(k) if(to - from > many)
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

  ! Adds the field from outside.
  subroutine add_outer_field(set, k)
    type(circle_set), intent(inout) :: set
    integer, intent(in) :: k
    real(real64) :: from(2), slope(2)

    associate (outer_field => set%outer_field(:, k))
      from = set%shift(:, k) - outer_field(4:5)
      slope = outer_field(1:2) * from(1) + outer_field(2:3) * from(2)
      set%displacement(k) = set%displacement(k) + 0.5_real64 * dot_product(slope, from)
      set%slope(:, k) = set%slope(:, k) + slope
      set%far_hessian(:, k) = set%far_hessian(:, k) + outer_field(:3)
    end associate
  end subroutine add_outer_field

  ! The terms of one near pair, kept for products.
  subroutine find_terms(set, k, terms)
    type(circle_set), intent(inout) :: set
    integer, intent(in) :: k
    type(mutual_terms), intent(out) :: terms
    real(real64) :: from(2), r

    associate (i => set%one(k), j => set%other(k))
      from = relative_position(set, i, j)
      r = sqrt(sum(from**2))
      call mutual_displacement(r, set%radius(i), set%radius(j), terms)
    end associate
    set%terms(compliance, k) = terms%compliance
    set%terms(first_slope, k) = terms%first_slope
    set%terms(second_slope, k) = terms%second_slope
    ! In one place the slope is zero and all directions are alike.
    set%terms(slope_over_distance, k) = terms%bend
    set%terms(hessian_anisotropy:direction_y, k) = 0.0_real64
    if (.not. r > 0.0_real64) return
    set%terms(slope_over_distance, k) = terms%slope / r
    set%terms(hessian_anisotropy, k) = terms%bend - terms%slope / r
    set%terms(direction_x:direction_y, k) = from / r
  end subroutine find_terms

  ! Adds what two near circles do to each other: heights and bends.
  subroutine add_displacements(set, k, terms)
    type(circle_set), intent(inout) :: set
    integer, intent(in) :: k
    type(mutual_terms), intent(in) :: terms
    real(real64) :: hessian(3)

    associate (i => set%one(k), j => set%other(k), load => set%load)
      set%energy = set%energy + load(i) * load(j) * terms%mean
      set%displacement(i) = set%displacement(i) + load(j) * terms%on_first
      set%displacement(j) = set%displacement(j) + load(i) * terms%on_second
      set%displacement_growth(i) = set%displacement_growth(i) + load(j) * terms%first_growth
      set%displacement_growth(j) = set%displacement_growth(j) + load(i) * terms%second_growth
      hessian = load(i) * load(j) * pair_hessian(set, k)
      set%hessian(:, i) = set%hessian(:, i) + hessian
      set%hessian(:, j) = set%hessian(:, j) + hessian
    end associate
  end subroutine add_displacements

  ! And slopes.
  subroutine add_slopes(set, k, terms)
    type(circle_set), intent(inout) :: set
    integer, intent(in) :: k
    type(mutual_terms), intent(in) :: terms

    associate (i => set%one(k), j => set%other(k), direction => &
               set%terms(direction_x:direction_y, k), &
               load => set%load)
      set%slope(:, i) = set%slope(:, i) + load(j) * terms%slope * direction
      set%slope(:, j) = set%slope(:, j) - load(i) * terms%slope * direction
      set%flat_slope(:, i) = set%flat_slope(:, i) + load(j) * terms%first_slope * direction
      set%flat_slope(:, j) = set%flat_slope(:, j) - load(i) * terms%second_slope * direction
    end associate
  end subroutine add_slopes

  !> Whether circles are nearer, where they stand now, than some sums of their radii.
  pure logical function are_close(set, a, outer_field, sums)
    type(circle_set), intent(in) :: set   !! places, shifts and radii are set
    integer, intent(in) :: a, outer_field  !! circles with their places
    real(real64), intent(in) :: sums      !! sums of radii

    are_close = sum(relative_position(set, a, outer_field)**2) < (sums * &
      (set%radius(a) + set%radius(outer_field)))**2
  end function are_close

  !> Where a circle stands now, from another one.
  pure function relative_position(set, one, other) result(from)
    type(circle_set), intent(in) :: set   !! places and shifts are set
    integer, intent(in) :: one, other     !! circles with their places
    real(real64) :: from(2)

    from = [set%x(one) - set%x(other), set%y(one) - set%y(other)] + &
           (set%shift(:, one) - set%shift(:, other))
  end function relative_position

  !> Second derivatives of a near pair's compliance: xx, xy, yy.
  pure function pair_hessian(set, k) result(bends)
    type(circle_set), intent(in) :: set  !! its field is known
    integer, intent(in) :: k             !! number of the pair
    real(real64) :: bends(3)             !! by the shift of one against the other

    associate (x => set%terms(direction_x, k), y => set%terms(direction_y, k))
      bends = set%terms(slope_over_distance, k) * [1, 0, 1] + set%terms(hessian_anisotropy, k) * &
        [x * x, x * y, y * y]
    end associate
  end function pair_hessian

end module asperity_circle_field
