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

  public :: multiply, shift_down

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

  !> The second derivatives of Phi times changes of loads and shifts. Those of far pairs by shifts
  !> are left out: they are of the order (circle/distance)**3.
  subroutine multiply(set, change, image)
    type(circle_set), intent(inout) :: set      !! its field is known; stays
    real(real64), intent(in) :: change(:, :)    !! (3, circle): of load, of shift along x and y
    real(real64), intent(out) :: image(:, :)    !! (3, circle)
    real(real64), allocatable :: far(:, :)
    real(real64) :: grows, mine(3), moved(2), slope_here, slope_there, way(2)
    integer :: i, j, k, l, n

    n = size(set%x)
    allocate (far(6, n))
    call sum_sources(set%tree, change(1, :), flat_spread * set%circle**2, far, set%moved, &
                     rough=.true.)
    !$omp parallel do schedule(static) if(n > many) &
    !$omp   private(grows, i, j, k, l, mine, moved, slope_here, slope_there, way)
    do i = 1, n
      grows = set%growth(i)
      if (set%held(i)) grows = max(grows, 0.0_real64)
      way = set%move(:, i) * set%curvature(i) + set%steer(:, i)
      mine(1) = far(1, i) / pi + &
                (1.0_real64 / set%stiffness(i) + grows / (3 * set%load(i))) * change(1, i) + &
                dot_product(way, change(2:, i))
      associate (b => set%bowl(:, i), more => set%stiffer(i) * set%curvature(i))
        mine(2:) = way * change(1, i) + set%load(i) * &
          (b(1:2) * change(2, i) + b(2:3) * change(3, i) + more * change(2:, i))
      end associate
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
      if (set%held(i)) mine(2:) = 0.0_real64
      image(:, i) = mine
    end do
    !$omp end parallel do
  end subroutine multiply

end module asperity_circle_products
