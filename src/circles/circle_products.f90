!> Products of the second derivatives of the circles' potential with changes of loads and shifts.
!>
!> `exact` takes all second derivatives of near pairs, and of far pairs those by loads: the rest is
!> of the order (circle/distance)**3. `convex` leaves out what may be negative: the decrease of a
!> load with its own radius, load with shift, and shift with shift of other circles; its second
!> derivatives by a circle's own shift are raised until they are positive.
module asperity_circle_products
  use asperity_circle_field, only: bend, circle_set, comply, east, flat_spread, least_share, many, &
                                   north, second_derivatives_between, steer_one, steer_other, turn
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  use asperity_source_tree, only: sum_sources
  implicit none
  private

  public :: lowest_shift, multiply, raised_bends

contains

  !> Shift to where a slope vanishes to first order, downwards in any case.
  pure function lowest_shift(bends, alone, slope) result(shift)
    real(real64), intent(in) :: bends(3)   !! second derivatives by the shift: xx, xy, yy
    real(real64), intent(in) :: alone      !! second derivative without neighbours, more than 0
    real(real64), intent(in) :: slope(2)   !! first derivatives along x and y
    real(real64) :: shift(2), b(3), s(2)
    integer :: power

    ! Powers of two change no digit; products of small loads would underflow.
    power = exponent(alone)
    b = raised_bends(scale(bends, -power), scale(alone, -power))
    s = scale(slope, -power)
    shift = -[b(3) * s(1) - b(2) * s(2), b(1) * s(2) - b(2) * s(1)] / (b(1) * b(3) - b(2)**2)
  end function lowest_shift

  !> Second derivatives by a shift with a share of the identity added so that they are positive.
  pure function raised_bends(bends, alone) result(raised)
    real(real64), intent(in) :: bends(3)   !! second derivatives: xx, xy, yy
    real(real64), intent(in) :: alone      !! second derivative without neighbours, more than 0
    real(real64) :: raised(3)

    raised = bends + [1, 0, 1] * max(0.0_real64, least_share * alone - &
             0.5_real64 * (bends(1) + bends(3) - hypot(bends(1) - bends(3), 2 * bends(2))))
  end function raised_bends

  !> Second derivatives of the potential times changes of loads and shifts.
  subroutine multiply(set, convex, change, image)
    type(circle_set), intent(inout) :: set      !! its field is known; not changed but for its tree
    logical, intent(in) :: convex               !! the convex model in place of the exact one
    real(real64), intent(in) :: change(:, :)    !! (3, circle): of load, of shift along x and y
    real(real64), intent(out) :: image(:, :)    !! product, load and shift (3, circle)
    real(real64), allocatable :: far(:, :)
    real(real64) :: mine(3), moved(2), slope_here, slope_there, way(2)
    integer :: i, j, k, l, n

    n = size(set%x)
    allocate (far(6, n))
    if (convex) then
      call sum_sources(set%tree, change(1, :), flat_spread * set%circle**2, far, set%moved, &
                       rough=.true.)
    else
      call sum_sources(set%tree, change(1, :), flat_spread * set%circle**2, far, set%moved, &
                       rough=.true., dipole=spread(set%load, 1, 2) * change(2:, :))
    end if
    !$omp parallel do schedule(static) if(n > many) &
    !$omp   private(i, j, k, l, mine, moved, slope_here, slope_there, way)
    do i = 1, n
      mine(1) = far(1, i) / pi + change(1, i) / set%stiffness(i)
      associate (grows => set%growth(i) / (3 * set%load(i)))
        mine(1) = mine(1) + merge(max(0.0_real64, grows), grows, convex) * change(1, i)
      end associate
      if (convex) then
        mine(2:) = own_bends(set, i, raised_bends(set%bends(:, i), &
                                                  set%load(i) * set%curvature(i)), change(2:, i))
        do l = set%tree%first(i), set%tree%first(i + 1) - 1
          mine(1) = mine(1) + set%terms(comply, set%pair(l)) * change(1, set%tree%near(l))
        end do
      else
        way = set%move(:, i) * set%curvature(i) + set%steer(:, i)
        mine(1) = mine(1) + dot_product(way, change(2:, i))
        mine(2:) = way * change(1, i) + set%load(i) * &
                   (far(3:4, i) / pi + own_bends(set, i, set%bowl(:, i), change(2:, i)))
        do l = set%tree%first(i), set%tree%first(i + 1) - 1
          j = set%tree%near(l)
          k = set%pair(l)
          slope_here = set%terms(merge(steer_one, steer_other, i < j), k)
          slope_there = set%terms(merge(steer_other, steer_one, i < j), k)
          way = merge(1.0_real64, -1.0_real64, i < j) * set%terms(east:north, k)
          moved = change(2:, i) - change(2:, j)
          mine(1) = mine(1) + set%terms(comply, k) * change(1, j) - &
                    slope_here * set%load(j) * dot_product(way, change(2:, j))
          mine(2:) = mine(2:) + set%load(i) * (way * (slope_there * change(1, j) + &
            set%load(j) * set%terms(bend, k) * dot_product(way, moved)) + &
            set%load(j) * set%terms(turn, k) * moved)
        end do
      end if
      if (set%still(i)) mine(2:) = 0.0_real64
      image(:, i) = mine
    end do
    !$omp end parallel do
  end subroutine multiply

  ! Second derivatives xx, xy, yy times a shift; none where a circle may not shift.
  pure function own_bends(set, i, bends, shift) result(slope)
    type(circle_set), intent(in) :: set
    integer, intent(in) :: i
    real(real64), intent(in) :: bends(3), shift(2)
    real(real64) :: slope(2)

    slope = 0.0_real64
    if (.not. set%still(i)) slope = [dot_product(bends(1:2), shift), dot_product(bends(2:3), shift)]
  end function own_bends

end module asperity_circle_products
