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
  use asperity_source_tree, only: plant_tree, source_tree, sum_sources
  implicit none
  private

  public :: are_close, circle_set, find_field, from_other, inclination_factor, plant_circles, &
            second_derivatives_between

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
  integer, parameter :: a_batch = 65536

  !> Circles under load, and their field. Sizes of all arrays: the number of circles.
  type :: circle_set
    integer, allocatable :: number(:)            !! place in the list of pairs
    real(real64), allocatable :: x(:), y(:)      !! places without shift
    real(real64), allocatable :: curvature(:)    !! 1/R; 0 where a circle may not shift
    logical, allocatable :: still(:)             !! may not shift
    real(real64), allocatable :: move(:, :)      !! the shifts
    real(real64), allocatable :: load(:)         !! over the modulus
    real(real64), allocatable :: counted(:)      !! load in the sum that is asked for, over `load`
    real(real64), allocatable :: circle(:)       !! radius of the contact
    real(real64), allocatable :: stiffness(:)    !! of the load by the penetration, over the modulus
    real(real64), allocatable :: lift(:)         !! u: displacement by the others
    real(real64), allocatable :: growth(:)       !! d(lift)/d(log of the own radius)
    real(real64), allocatable :: tilt(:, :)      !! slope with Hertz' weight
    real(real64), allocatable :: steer(:, :)     !! slope of `lift`
    real(real64), allocatable :: bends(:, :)     !! second derivatives by the own shift: xx, xy, yy
    !> field from outside: second derivatives xx, xy, yy, and the shift where it is zero
    real(real64), allocatable :: outer(:, :)
    !> second derivatives by the own shift over the load, without near circles: xx, xy, yy
    real(real64), allocatable :: bowl(:, :)
    real(real64) :: energy = 0.0_real64          !! 1/2 sum V V G
    type(source_tree) :: tree                    !! of the places
    real(real64), allocatable :: planted(:, :)   !! radii and shifts at planting (3, circle)
    real(real64), allocatable :: moved(:, :)     !! shifts since then, where the field is known
    integer, allocatable :: pair(:)              !! of each near neighbour
    integer, allocatable :: one(:), other(:)     !! circles of each near pair
    real(real64), allocatable :: terms(:, :)     !! (quantity, near pair), see the constants below
  contains
    procedure :: make_room                       !! for a number of circles
  end type circle_set

  !> Numbers, chosen, of the quantities of a near pair: compliance; slope of lift of one and of the
  !> other; slope over distance and the rest of the bend, for the tilt; direction from the other to
  !> the one.
  integer, parameter, public :: comply = 1, steer_one = 2, steer_other = 3, turn = 4, east = 6, &
                                north = 7
  !> Number, chosen, of the rest of the bend: second derivative along less that across the line of
  !> centres.
  integer, parameter, public :: bend = 5

contains

  !> Makes room for circles, without shift. The expansions of its tree are kept.
  subroutine make_room(self, n)
    class(circle_set), intent(inout) :: self  !! gets new arrays, all zero
    integer, intent(in) :: n                  !! number of circles

    if (allocated(self%outer)) deallocate (self%outer)
    if (allocated(self%one)) deallocate (self%pair, self%one, self%other, self%terms)
    self%number = spread(0, 1, n)
    self%still = spread(.false., 1, n)
    self%x = spread(0.0_real64, 1, n)
    self%y = self%x
    self%curvature = self%x
    self%load = self%x
    self%counted = self%x
    self%circle = self%x
    self%stiffness = self%x
    self%lift = self%x
    self%growth = self%x
    self%move = spread(self%x, 1, 2)
    self%tilt = self%move
    self%steer = self%move
    self%bends = spread(self%x, 1, 3)
    self%bowl = self%bends
  end subroutine make_room

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
  subroutine plant_circles(set)
    type(circle_set), intent(inout) :: set  !! places, shifts and radii are set
    real(real64), allocatable :: planted(:, :)
    integer, allocatable :: cursor(:), near(:)
    integer :: i, j, k, pairs

    allocate (planted(3, size(set%x)))
    planted(1, :) = set%circle
    planted(2:, :) = set%move
    call move_alloc(planted, set%planted)
    call plant_tree(set%tree, set%x + set%move(1, :), set%y + set%move(2, :), set%circle, &
                    near_factor)
    if (allocated(set%tree%failure)) return
    pairs = size(set%tree%near) / 2
    if (allocated(set%pair)) deallocate (set%pair, set%one, set%other, set%terms)
    if (.not. has_memory(bytes_of_pair * pairs + bytes_of_circle * size(set%x))) then
      set%tree%failure = not_enough_memory // ' for the near pairs of contacts'
      return
    end if
    allocate (set%pair(2 * pairs), set%one(pairs), set%other(pairs), set%terms(north, pairs))
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
  end subroutine plant_circles

  !> Finds the field at every circle by all others.
  subroutine find_field(set)
    type(circle_set), intent(inout) :: set  !! planted; loads, radii and shifts are set
    real(real64), allocatable :: far(:, :)
    type(mutual_terms), allocatable :: batch(:)
    integer :: from, k, n, to

    n = size(set%x)
    set%moved = set%move - set%planted(2:, :)
    allocate (far(6, n), batch(min(a_batch, size(set%one))))
    call sum_sources(set%tree, set%load, hertz_spread * set%circle**2, far, set%moved)
    !$omp parallel do schedule(static) if(n > many)
    do k = 1, n
      associate (of => far(:, k), square => set%circle(k)**2)
        of = of / pi
        set%lift(k) = of(1) + flat_spread * square * of(2)
        set%growth(k) = 2 * flat_spread * square * of(2)
        set%tilt(:, k) = of(3:4)
        set%bowl(:, k) = [set%curvature(k) + 0.5_real64 * of(2) + of(5), of(6), &
                          set%curvature(k) + 0.5_real64 * of(2) - of(5)]
        if (allocated(set%outer)) call add_outer(set, k)
        set%bends(:, k) = set%load(k) * set%bowl(:, k)
        set%steer(:, k) = set%tilt(:, k)
      end associate
    end do
    !$omp end parallel do
    set%energy = 0.5_real64 * sum(set%load * (far(1, :) + hertz_spread * set%circle**2 * far(2, :)))
    do from = 1, size(set%one), a_batch
      to = min(from + a_batch - 1, size(set%one))
      !$omp parallel do schedule(static) if(to - from > many)
      do k = from, to
        call find_terms(set, k, batch(k - from + 1))
      end do
      !$omp end parallel do
      ! The order of summation does not depend on the number of threads.
      !$omp parallel sections private(k) if(to - from > many)
      do k = from, to
        call add_lifts(set, k, batch(k - from + 1))
      end do
      !$omp section
      do k = from, to
        call add_slopes(set, k, batch(k - from + 1))
      end do
      !$omp end parallel sections
    end do
  end subroutine find_field

  ! Adds the field from outside.
  subroutine add_outer(set, k)
    type(circle_set), intent(inout) :: set
    integer, intent(in) :: k
    real(real64) :: from(2), tilt(2)

    associate (b => set%outer(:, k))
      from = set%move(:, k) - b(4:5)
      tilt = b(1:2) * from(1) + b(2:3) * from(2)
      set%lift(k) = set%lift(k) + 0.5_real64 * dot_product(tilt, from)
      set%tilt(:, k) = set%tilt(:, k) + tilt
      set%bowl(:, k) = set%bowl(:, k) + b(:3)
    end associate
  end subroutine add_outer

  ! The terms of one near pair, kept for products.
  subroutine find_terms(set, k, terms)
    type(circle_set), intent(inout) :: set
    integer, intent(in) :: k
    type(mutual_terms), intent(out) :: terms
    real(real64) :: from(2), r

    associate (i => set%one(k), j => set%other(k))
      from = from_other(set, i, j)
      r = sqrt(sum(from**2))
      call mutual_displacement(r, set%circle(i), set%circle(j), terms)
    end associate
    set%terms(comply, k) = terms%compliance
    set%terms(steer_one, k) = terms%first_slope
    set%terms(steer_other, k) = terms%second_slope
    ! In one place the slope is zero and all directions are alike.
    set%terms(turn, k) = terms%bend
    set%terms(bend:north, k) = 0.0_real64
    if (.not. r > 0.0_real64) return
    set%terms(turn, k) = terms%slope / r
    set%terms(bend, k) = terms%bend - terms%slope / r
    set%terms(east:north, k) = from / r
  end subroutine find_terms

  ! Adds what two near circles do to each other: heights and bends.
  subroutine add_lifts(set, k, terms)
    type(circle_set), intent(inout) :: set
    integer, intent(in) :: k
    type(mutual_terms), intent(in) :: terms
    real(real64) :: both(3)

    associate (i => set%one(k), j => set%other(k), load => set%load)
      set%energy = set%energy + load(i) * load(j) * terms%mean
      set%lift(i) = set%lift(i) + load(j) * terms%on_first
      set%lift(j) = set%lift(j) + load(i) * terms%on_second
      set%growth(i) = set%growth(i) + load(j) * terms%first_growth
      set%growth(j) = set%growth(j) + load(i) * terms%second_growth
      both = load(i) * load(j) * second_derivatives_between(set, k)
      set%bends(:, i) = set%bends(:, i) + both
      set%bends(:, j) = set%bends(:, j) + both
    end associate
  end subroutine add_lifts

  ! And slopes.
  subroutine add_slopes(set, k, terms)
    type(circle_set), intent(inout) :: set
    integer, intent(in) :: k
    type(mutual_terms), intent(in) :: terms

    associate (i => set%one(k), j => set%other(k), way => set%terms(east:north, k), &
               load => set%load)
      set%tilt(:, i) = set%tilt(:, i) + load(j) * terms%slope * way
      set%tilt(:, j) = set%tilt(:, j) - load(i) * terms%slope * way
      set%steer(:, i) = set%steer(:, i) + load(j) * terms%first_slope * way
      set%steer(:, j) = set%steer(:, j) - load(i) * terms%second_slope * way
    end associate
  end subroutine add_slopes

  !> Whether circles are nearer, where they stand now, than some sums of their radii.
  pure logical function are_close(set, a, b, sums)
    type(circle_set), intent(in) :: set   !! places, shifts and radii are set
    integer, intent(in) :: a, b           !! circles with their places
    real(real64), intent(in) :: sums      !! sums of radii

    are_close = sum(from_other(set, a, b)**2) < (sums * (set%circle(a) + set%circle(b)))**2
  end function are_close

  !> Where a circle stands now, from another one.
  pure function from_other(set, one, other) result(from)
    type(circle_set), intent(in) :: set   !! places and shifts are set
    integer, intent(in) :: one, other     !! circles with their places
    real(real64) :: from(2)

    from = [set%x(one) - set%x(other), set%y(one) - set%y(other)] + &
           (set%move(:, one) - set%move(:, other))
  end function from_other

  !> Second derivatives of a near pair's compliance: xx, xy, yy.
  pure function second_derivatives_between(set, k) result(bends)
    type(circle_set), intent(in) :: set  !! its field is known
    integer, intent(in) :: k             !! number of the pair
    real(real64) :: bends(3)             !! by the shift of one against the other

    associate (x => set%terms(east, k), y => set%terms(north, k))
      bends = set%terms(turn, k) * [1, 0, 1] + set%terms(bend, k) * [x * x, x * y, y * y]
    end associate
  end function second_derivatives_between

end module asperity_circle_field
