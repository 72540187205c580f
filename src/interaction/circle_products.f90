!> The second derivatives of the potential of circles by loads and shifts: their products with a
!> change, and where they are not positive definite.
module asperity_circle_products
  use asperity_circle_field, only: bend, between, circle_set, comply, east, flat_spread, many, &
                                   north, steer_one, steer_other, turn
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  use asperity_source_tree, only: sum_sources
  implicit none
  private

  public :: hold_bent, multiply, shift_down

contains

  !> The shift that takes a slope away, downwards in any case: the lesser second derivative is kept
  !> above a tenth of that without neighbours.
  pure function shift_down(bends, alone, slope) result(shift)
    real(real64), intent(in) :: bends(3)   !! second derivatives: xx, xy, yy
    real(real64), intent(in) :: alone      !! without neighbours
    real(real64), intent(in) :: slope(2)   !! to be taken away
    real(real64) :: shift(2), b(3), s(2), more
    integer :: power

    ! In powers of two, which change no digit: products of small loads would be 0.
    power = exponent(alone)
    b = scale(bends, -power)
    s = scale(slope, -power)
    more = max(0.0_real64, 0.1_real64 * scale(alone, -power) - &
               0.5_real64 * (b(1) + b(3) - hypot(b(1) - b(3), 2 * b(2))))
    b([1, 3]) = b([1, 3]) + more
    shift = -[b(3) * s(1) - b(2) * s(2), b(1) * s(2) - b(2) * s(1)] / (b(1) * b(3) - b(2)**2)
  end function shift_down

  !> Stiffens the shifts of near pairs along whose loads and shifts the potential curves down, so
  !> that it does not, by no more than twice what that takes: a contact that may slide around one
  !> other must not creep. Where the curvature alone does not do, they are held.
  subroutine hold_bent(set, margin)
    type(circle_set), intent(inout) :: set  !! its field is known; gets who is stiffer or held
    real(real64), intent(in) :: margin      !! share of the second derivatives
    real(real64) :: stiffer(size(set%one))
    integer :: k

    set%stiffer = 0.0_real64
    if (all(set%held)) return
    !$omp parallel do schedule(static) if(size(stiffer) > many)
    do k = 1, size(stiffer)
      stiffer(k) = 0.0_real64
      do while (curves_down(set, k, margin, stiffer(k)))
        stiffer(k) = max(margin, 2 * stiffer(k))
        if (stiffer(k) > 1.0_real64) exit
      end do
    end do
    !$omp end parallel do
    do k = 1, size(stiffer)
      if (.not. stiffer(k) > 0.0_real64) cycle
      associate (two => [set%one(k), set%other(k)])
        set%stiffer(two) = max(set%stiffer(two), stiffer(k))
        if (stiffer(k) > 1.0_real64) set%held(two) = .true.
      end associate
    end do
  end subroutine hold_bent

  ! Whether the second derivatives by the loads and shifts of a near pair are not positive definite.
  pure logical function curves_down(set, k, margin, stiffer)
    type(circle_set), intent(in) :: set
    real(real64), intent(in) :: margin, stiffer
    integer, intent(in) :: k
    real(real64) :: h(6, 6), both(3), alone(6)
    integer :: i, j

    i = set%one(k)
    j = set%other(k)
    h(1:3, 1:3) = own(i)
    h(4:6, 4:6) = own(j)
    both = -set%load(i) * set%load(j) * between(set, k)
    h(4, 1) = set%terms(comply, k)
    h(5:6, 1) = -set%terms(steer_one, k) * set%load(j) * set%terms(east:north, k)
    h(4, 2:3) = set%terms(steer_other, k) * set%load(i) * set%terms(east:north, k)
    h(5:6, 2) = both(1:2)
    h(5:6, 3) = both(2:3)
    if (set%held(i)) h(4:6, 2:3) = 0.0_real64
    if (set%held(j)) h(5:6, 1:3) = 0.0_real64
    alone = [1 / set%stiffness(i), set%load(i) * set%curvature(i) * [1, 1], &
             1 / set%stiffness(j), set%load(j) * set%curvature(j) * [1, 1]]
    curves_down = .true.
    do j = 1, 6
      if (mod(j, 3) /= 1) h(j, j) = h(j, j) + stiffer * alone(j)
    end do
    do j = 1, 6
      if (.not. h(j, j) > margin * alone(j)) return
      do i = j + 1, 6
        h(i:, i) = h(i:, i) - h(i:, j) * (h(i, j) / h(j, j))
      end do
    end do
    curves_down = .false.

  contains

    pure function own(i)
      integer, intent(in) :: i
      real(real64) :: own(3, 3)

      own = 0.0_real64
      own(1, 1) = 1.0_real64 / set%stiffness(i) + set%growth(i) / (3 * set%load(i))
      own(2, 1) = set%move_x(i) * set%curvature(i) + set%steer_x(i)
      own(3, 1) = set%move_y(i) * set%curvature(i) + set%steer_y(i)
      own(2:3, 2) = set%bends(:2, i)
      own(3, 3) = set%bends(3, i)
      if (.not. set%held(i)) return
      own(1, 1) = max(own(1, 1), 1.0_real64 / set%stiffness(i))
      own(2:3, 1) = 0.0_real64
      own(2, 2) = 1.0_real64
      own(3, 2) = 0.0_real64
      own(3, 3) = 1.0_real64
    end function own

  end function curves_down

  !> The second derivatives of Phi times changes of loads and shifts. Those of far pairs by shifts
  !> are left out: they are of the order (circle/distance)**3.
  subroutine multiply(set, change, image)
    type(circle_set), intent(inout) :: set      !! its field is known; stays
    real(real64), intent(in) :: change(:, :)    !! (3, circle): of load, of shift along x and y
    real(real64), intent(out) :: image(:, :)    !! (3, circle)
    real(real64), allocatable :: lap(:), potential(:), spread(:)
    real(real64) :: along, grows, mine(3), moved_x, moved_y, sign_of, slope_here, slope_there, x, y
    integer :: i, j, k, l, n

    n = size(set%x)
    allocate (lap(n), potential(n))
    ! Of many those far off act as points: what that leaves out is below 1/150 of it.
    lap = 0.0_real64
    if (n <= many) spread = flat_spread * set%circle**2
    call sum_sources(set%tree, change(1, :), spread, potential, lap, move_x=set%move_x, &
                     move_y=set%move_y)
    !$omp parallel do schedule(static) if(n > many) &
    !$omp   private(grows, i, j, k, l, along, mine, moved_x, moved_y, sign_of, &
    !$omp   slope_here, slope_there, x, y)
    do i = 1, n
      grows = set%growth(i)
      if (set%held(i)) grows = max(grows, 0.0_real64)
      x = set%move_x(i) * set%curvature(i) + set%steer_x(i)
      y = set%move_y(i) * set%curvature(i) + set%steer_y(i)
      mine(1) = (potential(i) + flat_spread * set%circle(i)**2 * lap(i)) / pi + &
                (1.0_real64 / set%stiffness(i) + grows / (3 * set%load(i))) * &
                change(1, i) + x * change(2, i) + y * change(3, i)
      associate (b => set%bowl(:, i), more => set%stiffer(i) * set%curvature(i))
        mine(2) = x * change(1, i) + &
                  set%load(i) * ((b(1) + more) * change(2, i) + b(2) * change(3, i))
        mine(3) = y * change(1, i) + &
                  set%load(i) * (b(2) * change(2, i) + (b(3) + more) * change(3, i))
      end associate
      do l = set%tree%first(i), set%tree%first(i + 1) - 1
        j = set%tree%near(l)
        k = set%pair(l)
        sign_of = merge(1.0_real64, -1.0_real64, i < j)
        slope_here = set%terms(merge(steer_one, steer_other, i < j), k)
        slope_there = set%terms(merge(steer_other, steer_one, i < j), k)
        x = sign_of * set%terms(east, k)
        y = sign_of * set%terms(north, k)
        mine(1) = mine(1) + set%terms(comply, k) * change(1, j) - &
                  slope_here * set%load(j) * (x * change(2, j) + y * change(3, j))
        moved_x = change(2, i) - change(2, j)
        moved_y = change(3, i) - change(3, j)
        along = set%load(i) * slope_there * change(1, j) + &
                set%load(i) * set%load(j) * set%terms(bend, k) * (x * moved_x + y * moved_y)
        mine(2) = mine(2) + along * x + set%load(i) * set%load(j) * set%terms(turn, k) * moved_x
        mine(3) = mine(3) + along * y + set%load(i) * set%load(j) * set%terms(turn, k) * moved_y
      end do
      if (set%held(i)) mine(2:) = 0.0_real64
      image(:, i) = mine
    end do
    !$omp end parallel do
  end subroutine multiply

end module asperity_circle_products
