!> Tangential tractions of least energy on elements that stick, or slip under Coulomb's friction.
!>
!> Problem: minimise q.A q/2 - q.b over all tractions with |q| <= g on each element, of a given sum,
!> or less delta.(sum of q) at a given displacement delta. A are the displacements by tractions
!> (`traction_convolution`), g = mu p, and b are the displacements A q0 of the tractions before. The
!> problem is convex (Duvaut and Lions 1976; Kalker 1990, chapter 4). With s = delta + b - A q, the
!> slip of the one body along the other, s = 0 where |q| < g, and s has the direction of q else.
!>
!> Method: semismooth Newton (Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92 (1991) 353;
!> Hintermueller, Ito and Kunisch, SIAM J. Optim. 13 (2002) 865). An element slides where
!> v = q + c s is outside its disc, with the normal n = v/|v|, and sticks elsewhere. Under a load,
!> delta is that of P(q + c s) with the given sum, P being the projection on the discs. In the
!> tangents of the discs the step is the solution of the positive definite system
!> A + (|v|/g - 1)/c, found by conjugate gradients (`solve_tangents`) up to a part of the residual
!> (Dembo, Eisenstat and Steihaug, SIAM J. Numer. Anal. 19 (1982) 400). It is projected on the discs
!> and the sum, and accepted if the energy falls by the part of its slope that Armijo asks for, or
!> changes by its rounding (near the minimum it falls by the square of the residual); else its exact
!> minimum on the way is taken, or that to P(q + c s). All tractions are allowed ones.
!>
!> Residual: the largest |q - P(q + c s)|/c over |delta|. Exits: converged, where it is at most the
!> tolerance or the rounding of the tractions, as in full periodic contact, where delta is 0 while
!> all sticks; not converged, after `turns_allowed` steps or where the run is interrupted.
module asperity_slip_solver
  use asperity_interruption, only: interruption
  use asperity_kinds, only: int64, real64
  use asperity_solve_ending, only: solve_ending
  use asperity_traction_convolution, only: by_tractions, element_set, inverse_of_tractions, &
                                           traction_convolution
  implicit none
  private

  public :: find_compliance, find_tractions, set_sticking, slip_problem, tangent_space

  !> Discs of the tractions, and what is prescribed. Arrays are by element in contact and component;
  !> lengths and tractions as of the convolution.
  type :: slip_problem
    type(element_set) :: set                      !! elements in contact
    real(real64), allocatable :: limit(:)         !! largest traction g of each, more than 0
    real(real64), allocatable :: base(:, :)       !! displacements b: with them nothing slips
    logical :: by_load = .true.                   !! whether the sum is given, else delta
    real(real64) :: given(2) = 0.0_real64         !! sum of the tractions, or displacement delta
    real(real64) :: reference = 0.0_real64  !! displacement of residuals; 0: that of delta
    real(real64) :: tolerance = 1.0e-7_real64     !! largest residual
  end type slip_problem

  !> Directions in which tractions can change: two where an element sticks, one where it slides.
  type :: tangent_space
    type(element_set) :: set                         !! elements in contact
    real(real64), allocatable :: normal(:, :)        !! n where an element slides, else 0
    real(real64), allocatable :: stiffening(:)       !! (|v|/g - 1)/c where it slides, else 0
    real(real64), allocatable :: conditioning(:)     !! of the inverse, beside the stiffening
    real(real64) :: inverse(2, 2) = 0.0_real64       !! of the sum of the projections
  end type tangent_space

  ! Step c of the projection over the displacement of an element by its own traction (chosen: 0.1
  ! needs as many steps, 1 alternates between both sides of a disc; test: random problems in
  ! test/unit/traction_suite.f90).
  real(real64), parameter :: projection_step = 0.3_real64
  ! Largest numbers of steps, of their conjugate gradients, of steps of the level, and of lengths of
  ! a step (chosen).
  integer, parameter :: turns_allowed = 60, inner_allowed = 80, level_steps = 60, line_steps = 10
  ! Largest and least residual of a step over that of the turn (chosen; over that of its own start,
  ! which sliding elements raise as they are put on their circles, a step could leave the turn's).
  real(real64), parameter :: inner_residual = 0.1_real64, least_inner = 0.03_real64
  ! Largest error of a compliance over that of equal tractions (chosen, below that by pixels; test:
  ! test/maps/test_partial_slip.py).
  real(real64), parameter :: compliance_error = 1.0e-5_real64
  ! Part of the slope that the energy falls by (Armijo 1966; chosen as usual), and the least length
  ! of a step to its minimum (chosen: else the projection is taken).
  real(real64), parameter :: least_decrease = 1.0e-4_real64, least_length = 0.05_real64
  ! Error of the sum of tractions over that of their sizes (chosen, above rounding). A mean of twice
  ! as much, of both sums compared, is rounding; so are displacements of the tractions before.
  real(real64), parameter :: sum_error = 1.0e-13_real64

contains

  !> Finds the tractions from a start (problem, method and exits: see the module).
  subroutine find_tractions(operator, problem, traction, slip, displacement, space, ending, &
                            interrupt)
    type(traction_convolution), intent(inout) :: operator  !! matrix A of displacements
    type(slip_problem), intent(in) :: problem      !! discs and load; under a load: not sliding
    real(real64), intent(inout) :: traction(:, :)   !! q: start and result
    real(real64), intent(out) :: slip(:, :)     !! s on the elements that slide, else 0
    real(real64), intent(out) :: displacement(2)   !! delta of the bodies
    type(tangent_space), intent(out) :: space      !! elements that stick and slide
    !> exit, residual, number of applications of A or its inverse
    type(solve_ending), intent(out) :: ending
    type(interruption), intent(in) :: interrupt    !! request to stop the iteration
    real(real64), allocatable, dimension(:, :) :: aimed, change, image, projected
    real(real64) :: before, c, level(2), reference, residual
    integer :: k, turn

    c = projection_step / operator%diagonal
    before = sum(hypot(traction(:, 1), traction(:, 2)))
    associate (limit => problem%limit)
      space%set = problem%set
      allocate (aimed, change, image, mold=traction)
      allocate (projected, space%normal, source=0.0_real64 * traction)
      allocate (space%stiffening, space%conditioning, mold=limit)
      ! A start in proportion to the discs has the sum nearly everywhere inside them.
      do k = 1, merge(2, 0, problem%by_load)
        traction(:, k) = traction(:, k) + limit * &
                            ((problem%given(k) - sum(traction(:, k))) / sum(limit))
      end do
      call project_tractions(problem, traction)
      call operator%apply_at(problem%set, traction, image, by_tractions)
      displacement = problem%given
      if (problem%by_load) then
        displacement = [(sum(limit * (image(:, k) - problem%base(:, k))), k=1, 2)] / &
                       sum(limit)
      end if
      slip = problem%base - image
      ending%iterations = 1
      do turn = 1, turns_allowed
        if (problem%by_load) then
          level = -c * displacement
          call find_level(traction + c * slip, limit, problem%given, level)
          displacement = -level / c
        end if
        do k = 1, 2
          aimed(:, k) = traction(:, k) + &
                           c * (slip(:, k) + displacement(k))
        end do
        projected = aimed
        call cut_tractions(limit, projected)
        residual = sqrt(maxval(sum((traction - projected)**2, 2))) / c
        reference = max(problem%reference, maxval(abs(displacement)), tiny(reference))
        ending%residual = residual / reference
        ending%converged = ending%residual <= problem%tolerance .or. &
                           c * residual * size(limit, kind=int64) <= &
                           2 * sum_error * max(before, sum(hypot(traction(:, 1), traction(:, 2))))
        call set_sliding(problem, aimed, c, operator%diagonal, space)
        if (ending%converged .or. interrupt%is_asked()) exit
        if (.not. (problem%by_load .or. any(space%stiffening > 0.0_real64))) &
          call raise_tractions(operator, problem, displacement, traction)
        ! All elements stick at the beginning of a first load.
        if (turn == 1 .and. .not. before > 0.0_real64) call set_sticking(problem%set, space)
        call take_newton_step(operator, problem, space, displacement, &
                              [ending%residual, reference], traction, change, ending%iterations)
        call search_line(operator, problem, displacement, projected, slip, change, traction, &
                         ending%iterations)
      end do
      traction = projected
      slip = (aimed - projected) / c
    end associate
  end subroutine find_tractions

  ! Adds equal tractions along the displacement, up to the first circle, if they displace nothing,
  ! as in full contact of a periodic lattice: the energy falls in proportion to them.
  subroutine raise_tractions(operator, problem, displacement, traction)
    type(traction_convolution), intent(inout) :: operator
    type(slip_problem), intent(in) :: problem
    real(real64), intent(in) :: displacement(2)
    real(real64), intent(inout) :: traction(:, :)
    real(real64) :: along(size(traction, 1)), direction(2), equal(size(traction, 1), 2), &
                    image(size(traction, 1), 2)

    direction = displacement / hypot(displacement(1), displacement(2))
    equal = spread(direction, 1, size(traction, 1))
    call operator%apply_at(problem%set, equal, image, by_tractions)
    if (maxval(abs(image)) > sqrt(epsilon(along)) * operator%diagonal) return
    along = matmul(traction, direction)
    traction = traction + equal * minval(sqrt(max(0.0_real64, along**2 + problem%limit**2 - &
                                                  sum(traction**2, 2))) - along)
  end subroutine raise_tractions

  ! Moves the tractions by a step, projected on discs and sum, or by the part of it at which the
  ! energy is least. At a given displacement nothing bounds the step before it is projected: shorter
  ! ones are tried.
  subroutine search_line(operator, problem, displacement, projected, slip, change, traction, &
                         applications)
    type(traction_convolution), intent(inout) :: operator
    type(slip_problem), intent(in) :: problem
    real(real64), intent(in) :: displacement(2), projected(:, :)
    real(real64), intent(inout) :: slip(:, :), traction(:, :)
    real(real64), intent(inout) :: change(:, :)  ! tractions after the step; becomes their change
    integer, intent(inout) :: applications
    real(real64), allocatable, dimension(:, :) :: image, newton
    real(real64) :: curvature, length, part, rounding, slope
    integer :: tries, turn

    allocate (image, mold=change)
    allocate (newton, source=change - traction)
    tries = merge(2, line_steps, problem%by_load)
    part = 1.0_real64
    ! Work of the errors of tractions on their circles: 2 epsilon of g each, in the old and new one.
    rounding = 4 * epsilon(length) * sum(problem%limit * hypot(slip(:, 1) + displacement(1), &
                                                               slip(:, 2) + displacement(2)))
    do turn = 1, tries
      if (turn > 1) change = traction + part * newton
      call project_tractions(problem, change)
      if (turn == tries .or. .not. part > 0.0_real64) change = projected
      change = change - traction
      length = 1.0_real64
      call operator%apply_at(problem%set, change, image, by_tractions)
      applications = applications + 1
      slope = -sum(change * slip) - sum([sum(change(:, 1)), sum(change(:, 2))] * displacement)
      curvature = sum(change * image)
      if (slope + 0.5_real64 * curvature < least_decrease * slope + rounding) exit
      length = 0.0_real64
      if (curvature > 0.0_real64) length = min(1.0_real64, -slope / curvature)
      if (problem%by_load .and. length >= least_length) exit
      part = part * min(length, 0.5_real64)
    end do
    length = max(length, 0.0_real64)
    slip = slip - length * image
    traction = traction + length * change
  end subroutine search_line

  ! Finds the tractions after a Newton step, which may be outside their discs.
  subroutine take_newton_step(operator, problem, space, displacement, residual, traction, change, &
                              applications)
    type(traction_convolution), intent(inout) :: operator
    type(slip_problem), intent(in) :: problem
    type(tangent_space), intent(in) :: space
    real(real64), intent(in) :: displacement(2)
    real(real64), intent(in) :: residual(2)   ! of the turn, over its reference; the reference
    real(real64), intent(in) :: traction(:, :)
    real(real64), intent(out) :: change(:, :)
    integer, intent(inout) :: applications
    real(real64), allocatable, dimension(:, :) :: aim, gradient, moved
    integer :: k

    allocate (aim, moved, mold=traction)
    allocate (gradient, source=0.0_real64 * traction)
    do k = 1, 2
      ! Sliding elements begin on their circles.
      aim(:, k) = merge(problem%limit * space%normal(:, k), traction(:, k), &
                           abs(space%normal(:, 1)) + abs(space%normal(:, 2)) > 0.0_real64)
      if (problem%by_load) gradient(:, k) = problem%given(k) - sum(aim(:, k))
    end do
    moved = gradient
    if (problem%by_load) call spread_sum(space, moved)
    call operator%apply_at(problem%set, aim + moved, gradient, by_tractions)
    applications = applications + 1
    do k = 1, 2
      gradient(:, k) = gradient(:, k) - problem%base(:, k) - displacement(k) + &
                          space%stiffening * moved(:, k)
    end do
    call solve_tangents(operator, space, problem%by_load, [residual(2) * &
                        max(max(least_inner, min(inner_residual, residual(1))) * residual(1), &
                            0.5_real64 * problem%tolerance), 0.0_real64], moved, gradient, &
                        applications)
    change = aim + moved
  end subroutine take_newton_step

  !> Finds the displacements of the bodies along and by small loads, while no element begins or
  !> ceases to slide: x.(A + stiffening) x of the tractions x of each load with the least energy.
  subroutine find_compliance(operator, space, loads, compliance)
    type(traction_convolution), intent(inout) :: operator  !! matrix A of displacements
    type(tangent_space), intent(in) :: space        !! elements that stick and slide
    real(real64), intent(in) :: loads(:, :)         !! (x and y, load): sums of the tractions
    real(real64), intent(out) :: compliance(:, :)   !! (load, load), symmetric; rounding is 0
    real(real64), allocatable :: gradient(:, :), x(:, :, :)
    integer :: applications, i, k

    applications = 0
    allocate (x(size(space%stiffening, kind=int64), 2, size(loads, 2)))
    allocate (gradient(size(x, 1, kind=int64), 2))
    do k = 1, size(loads, 2)
      x(:, :, k) = spread(loads(:, k), 1, size(x, 1, kind=int64))
      call spread_sum(space, x(:, :, k))
      call operator%apply_at(space%set, x(:, :, k), gradient, by_tractions)
      do i = 1, 2
        gradient(:, i) = gradient(:, i) + space%stiffening * x(:, i, k)
      end do
      call solve_tangents(operator, space, .true., [0.0_real64, compliance_error * &
                          abs(sum(x(:, :, k) * gradient))], x(:, :, k), gradient, applications)
      do i = 1, k
        compliance(i, k) = sum(x(:, :, i) * gradient)
        if (abs(compliance(i, k)) <= sqrt(epsilon(1.0_real64)) * operator%diagonal / &
            size(x, 1, kind=int64)) compliance(i, k) = 0.0_real64
        compliance(k, i) = compliance(i, k)
      end do
    end do
  end subroutine find_compliance

  ! Minimises x.(A + stiffening) x/2 + x.f in a tangent space, with the sum of x fixed or free, by
  ! conjugate gradients. The inverse of A is scaled from both sides by the root of 1 + stiffening
  ! over the displacement of an element by itself, which grows without limit at the rim. A residual
  ! r, of components in the tangents, counts in that of tractions, |q - P(q + c s)|/c, by g/|v| =
  ! 1/(1 + c stiffening), the derivative of P. Its error has the energy r.B r, with that inverse B,
  ! at most: the inverse of A on some elements is at most that of all of them there.
  subroutine solve_tangents(operator, space, fixes_sum, enough, x, gradient, applications)
    type(traction_convolution), intent(inout) :: operator  ! matrix A
    type(tangent_space), intent(in) :: space     ! tangents of the discs
    logical, intent(in) :: fixes_sum             ! whether the sum of x stays
    real(real64), intent(in) :: enough(2)        ! largest residual, or largest energy of its error
    real(real64), intent(inout) :: x(:, :)    ! start and result, in the tangent space
    real(real64), intent(inout) :: gradient(:, :)   ! (A + stiffening) x + f
    integer, intent(inout) :: applications       ! of A or its inverse; is increased
    real(real64), allocatable, dimension(:, :) :: direction, image, residual, scaled
    real(real64) :: curvature, step, product_before, product_now, weight(size(x, 1, kind=int64))
    integer :: k, turn

    weight = 1.0_real64 + projection_step / operator%diagonal * space%stiffening
    allocate (residual, source=-gradient)
    call take_tangents(space, fixes_sum, residual)
    allocate (direction, source=0.0_real64 * residual)
    allocate (image, scaled, mold=residual)
    product_before = 0.0_real64
    do turn = 1, inner_allowed
      if (maxval(maxval(abs(residual), 2) / weight) <= enough(1)) exit
      do k = 1, 2
        scaled(:, k) = space%conditioning * residual(:, k)
      end do
      call operator%apply_at(space%set, scaled, image, inverse_of_tractions)
      do k = 1, 2
        image(:, k) = space%conditioning * image(:, k)
      end do
      call take_tangents(space, fixes_sum, image)
      product_now = sum(residual * image)
      if (.not. product_now > enough(2)) exit
      step = 0.0_real64
      if (turn > 1) step = product_now / product_before
      direction = image + step * direction
      call operator%apply_at(space%set, direction, image, by_tractions)
      applications = applications + 2
      do k = 1, 2
        image(:, k) = image(:, k) + space%stiffening * direction(:, k)
      end do
      curvature = sum(direction * image)
      if (.not. curvature > 0.0_real64) exit
      step = product_now / curvature
      x = x + step * direction
      gradient = gradient + step * image
      call take_tangents(space, fixes_sum, image)
      residual = residual - step * image
      product_before = product_now
    end do
  end subroutine solve_tangents

  !> Sets the tangent space of elements that all stick.
  pure subroutine set_sticking(set, space)
    type(element_set), intent(in) :: set         !! elements in contact
    type(tangent_space), intent(out) :: space    !! both directions of each

    space%set = set
    allocate (space%normal(size(set%column, kind=int64), 2), source=0.0_real64)
    allocate (space%stiffening(size(set%column, kind=int64)), source=0.0_real64)
    allocate (space%conditioning(size(set%column, kind=int64)), source=1.0_real64)
    call invert_sum(space)
  end subroutine set_sticking

  ! Sets the elements that slide, where the aim is outside the disc.
  pure subroutine set_sliding(problem, aim, c, diagonal, space)
    type(slip_problem), intent(in) :: problem
    real(real64), intent(in) :: aim(:, :)      ! v
    real(real64), intent(in) :: c, diagonal       ! step; displacement of an element by itself
    type(tangent_space), intent(inout) :: space
    real(real64) :: distance
    integer(int64) :: i

    space%normal = 0.0_real64
    space%stiffening = 0.0_real64
    do i = 1, size(aim, 1, kind=int64)
      distance = hypot(aim(i, 1), aim(i, 2))
      if (.not. distance > problem%limit(i)) cycle
      space%normal(i, :) = aim(i, :) / distance
      space%stiffening(i) = (distance / problem%limit(i) - 1.0_real64) / c
    end do
    space%conditioning = 1.0_real64 / sqrt(1.0_real64 + space%stiffening / diagonal)
    call invert_sum(space)
  end subroutine set_sliding

  ! Sets the inverse of the sum of the projections on the tangents.
  pure subroutine invert_sum(space)
    type(tangent_space), intent(inout) :: space
    real(real64) :: total(2, 2), least
    integer :: i, k

    do k = 1, 2
      do i = 1, 2
        total(i, k) = merge(real(size(space%stiffening, kind=int64), real64), 0.0_real64, &
                            i == k) - sum(space%normal(:, i) * space%normal(:, k))
      end do
    end do
    ! Where all elements slide in one direction, no sum is free in it.
    least = epsilon(least) * max(1.0_real64, total(1, 1) + total(2, 2))
    total(1, 1) = total(1, 1) + least
    total(2, 2) = total(2, 2) + least
    space%inverse = reshape([total(2, 2), -total(2, 1), -total(1, 2), total(1, 1)], [2, 2]) / &
                    (total(1, 1) * total(2, 2) - total(1, 2) * total(2, 1))
  end subroutine invert_sum

  ! Projects on the tangents, and where the sum is fixed on those without a sum.
  pure subroutine take_tangents(space, fixes_sum, field)
    type(tangent_space), intent(in) :: space
    logical, intent(in) :: fixes_sum
    real(real64), intent(inout) :: field(:, :)
    real(real64) :: mean(2)

    call subtract_normal(space, [0.0_real64, 0.0_real64], field)
    if (.not. fixes_sum) return
    mean = matmul(space%inverse, [sum(field(:, 1)), sum(field(:, 2))])
    call subtract_normal(space, mean, field)
  end subroutine take_tangents

  ! Replaces a field that is the same everywhere by the field in the tangents with that sum.
  pure subroutine spread_sum(space, field)
    type(tangent_space), intent(in) :: space
    real(real64), intent(inout) :: field(:, :)
    real(real64) :: mean(2)

    mean = matmul(space%inverse, field(1, :))
    field = 0.0_real64
    call subtract_normal(space, -mean, field)
  end subroutine spread_sum

  ! Subtracts a constant from a field and leaves the part in the tangents.
  pure subroutine subtract_normal(space, constant, field)
    type(tangent_space), intent(in) :: space
    real(real64), intent(in) :: constant(2)
    real(real64), intent(inout) :: field(:, :)
    real(real64) :: along, x, y
    integer(int64) :: i

    do i = 1, size(field, 1, kind=int64)
      x = field(i, 1) - constant(1)
      y = field(i, 2) - constant(2)
      along = space%normal(i, 1) * x + space%normal(i, 2) * y
      field(i, 1) = x - along * space%normal(i, 1)
      field(i, 2) = y - along * space%normal(i, 2)
    end do
  end subroutine subtract_normal

  ! Projects tractions on the discs and, under a load, on their sum.
  pure subroutine project_tractions(problem, traction)
    type(slip_problem), intent(in) :: problem
    real(real64), intent(inout) :: traction(:, :)
    real(real64) :: level(2)
    integer :: k

    if (problem%by_load) then
      level = 0.0_real64
      call find_level(traction, problem%limit, problem%given, level)
      do k = 1, 2
        traction(:, k) = traction(:, k) - level(k)
      end do
    end if
    call cut_tractions(problem%limit, traction)
  end subroutine project_tractions

  ! Projects tractions on the discs.
  pure subroutine cut_tractions(limit, traction)
    real(real64), intent(in) :: limit(:)
    real(real64), intent(inout) :: traction(:, :)
    real(real64) :: size_of
    integer(int64) :: i

    do i = 1, size(limit, kind=int64)
      size_of = hypot(traction(i, 1), traction(i, 2))
      if (size_of > limit(i)) traction(i, :) = traction(i, :) * (limit(i) / size_of)
    end do
  end subroutine cut_tractions

  ! Finds the level with sum P(v - level) = total: the gradient of a convex function of two
  ! variables is 0 there; Newton's method with halved steps.
  pure subroutine find_level(v, limit, total, level)
    real(real64), intent(in) :: v(:, :), limit(:), total(2)
    real(real64), intent(inout) :: level(2)   ! start and result
    real(real64) :: enough, excess(2), length, next(2), next_excess(2), next_slope(2, 2), &
                    slope(2, 2), step(2)
    integer :: turn

    enough = sum_error * sum(min(limit, hypot(v(:, 1), v(:, 2))))
    call sum_cut(v, limit, level, excess, slope)
    excess = excess - total
    do turn = 1, level_steps
      if (maxval(abs(excess)) <= enough) return
      slope(1, 1) = slope(1, 1) + 1.0e-12_real64 * (slope(1, 1) + slope(2, 2))
      slope(2, 2) = slope(2, 2) + 1.0e-12_real64 * (slope(1, 1) + slope(2, 2))
      step = [slope(2, 2) * excess(1) - slope(1, 2) * excess(2), &
              slope(1, 1) * excess(2) - slope(2, 1) * excess(1)] / &
             max(slope(1, 1) * slope(2, 2) - slope(1, 2) * slope(2, 1), tiny(length))
      length = 1.0_real64
      do
        next = level + length * step
        call sum_cut(v, limit, next, next_excess, next_slope)
        next_excess = next_excess - total
        if (hypot(next_excess(1), next_excess(2)) < hypot(excess(1), excess(2)) * &
            (1.0_real64 - least_decrease * length)) exit
        length = 0.5_real64 * length
        if (length < epsilon(length)) return
      end do
      level = next
      excess = next_excess
      slope = next_slope
    end do
  end subroutine find_level

  ! Sums P(v - level), and less its derivative by the level.
  pure subroutine sum_cut(v, limit, level, total, slope)
    real(real64), intent(in) :: v(:, :), limit(:), level(2)
    real(real64), intent(out) :: total(2), slope(2, 2)
    real(real64) :: at(2), share, size_of
    integer(int64) :: i

    total = 0.0_real64
    slope = 0.0_real64
    do i = 1, size(limit, kind=int64)
      at = v(i, :) - level
      size_of = hypot(at(1), at(2))
      share = 1.0_real64
      if (size_of > limit(i)) then
        share = limit(i) / size_of
        slope(1, 1) = slope(1, 1) - share * (at(1) / size_of)**2
        slope(2, 2) = slope(2, 2) - share * (at(2) / size_of)**2
        slope(1, 2) = slope(1, 2) - share * (at(1) / size_of) * (at(2) / size_of)
      end if
      total = total + share * at
      slope(1, 1) = slope(1, 1) + share
      slope(2, 2) = slope(2, 2) + share
    end do
    slope(2, 1) = slope(1, 2)
  end subroutine sum_cut

end module asperity_slip_solver
