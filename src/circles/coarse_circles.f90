!> Coarse level of many contacts: squares full of circles, coupled over long distances.
!>
!> Conjugate gradients on many contacts are slow for loads that vary slowly in space: the sum of 1/r
!> over n contacts of stiffness k per area has the eigenvalue 2 pi n k/q for waves of number q,
!> where an isolated contact has 1. On the coarse level the circles of a square of a grid share one
!> displacement: the mean of 1/r over two squares (Love 1929) times the loads. It is a
!> preconditioner and a start, and changes the number of steps, not the result.
module asperity_coarse_circles
  use asperity_lattice_convolution, only: lattice_convolution
  use asperity_element_influence, only: mean_influence
  use asperity_kinds, only: real64
  implicit none
  private

  public :: circles_per_square, coarse_circles, gather_squares, pressed_displacement, &
            shared_change, sum_of_squares

  !> Circles gathered in squares. It owns the plans of a transform: it must not be copied.
  type :: coarse_circles
    integer, allocatable :: square(:)             !! index of the square of each circle
    !> by the user: changes (3, circle) by a unit penetration of all circles of a square, and the
    !> sum of the changes of load by square
    real(real64), allocatable :: answer(:, :), stiffness(:)
    integer :: columns = 0, rows = 0              !! of squares
    type(lattice_convolution), private :: lattice    !! displacement of squares by loads on them
  end type coarse_circles

  !> Circles in a square. Within one, where they share nothing, waves are no longer than two sides:
  !> with a share f of the area in contact 2 pi n k/q is below 4/pi sqrt(16 f/pi), 1.6 at 30 %;
  !> derived; test: coupled_suite.f90.
  real(real64), parameter :: circles_per_square = 16.0_real64
  ! Share of the equations of squares that is left [1]: squares are a preconditioner; measured: with
  ! 0.001 1e5 caps take 5 % longer.
  real(real64), parameter :: coarse_residual = 0.01_real64

contains

  !> Gathers circles at their places.
  subroutine gather_squares(x, y, coarse)
    real(real64), intent(in) :: x(:), y(:)           !! centres of circles, one at least [length]
    type(coarse_circles), intent(out) :: coarse      !! squares without answer and stiffness
    real(real64) :: low(2), extent(2), side

    low = [minval(x), minval(y)]
    extent = [maxval(x), maxval(y)] - low
    side = max(sqrt(product(extent) * (circles_per_square / size(x))), &
               maxval(extent) * min(1.0_real64, circles_per_square / size(x)), tiny(side))
    coarse%columns = int(extent(1) / side) + 1
    coarse%rows = int(extent(2) / side) + 1
    coarse%square = int((x - low(1)) / side) + coarse%columns * int((y - low(2)) / side) + 1
    call coarse%lattice%prepare(mean_influence(coarse%columns, coarse%rows) / side, 1.0_real64)
  end subroutine gather_squares

  !> Displacement of squares by loads on squares.
  function pressed_displacement(coarse, loads) result(displacement)
    type(coarse_circles), intent(inout) :: coarse    !! squares of circles
    real(real64), intent(in) :: loads(:)             !! loads over the modulus by square
    real(real64) :: displacement(size(loads))
    real(real64) :: on_lattice(coarse%columns, coarse%rows)

    call coarse%lattice%apply(reshape(loads, shape(on_lattice)), on_lattice)
    displacement = reshape(on_lattice, shape(displacement))
  end function pressed_displacement

  !> Sums over the circles of each square.
  pure function sum_of_squares(coarse, values) result(sums)
    type(coarse_circles), intent(in) :: coarse   !! squares of circles
    real(real64), intent(in) :: values(:)        !! values by circle
    real(real64) :: sums(coarse%columns * coarse%rows)
    integer :: i

    sums = 0.0_real64
    do i = 1, size(values)
      sums(coarse%square(i)) = sums(coarse%square(i)) + values(i)
    end do
  end function sum_of_squares

  !> Solves the coarse equations (1 + P K) x = b, K stiffness and P displacement by loads, with
  !> conjugate gradients on (1 + sqrt(K) P sqrt(K)) sqrt(K) x = sqrt(K) b.
  function shared_change(coarse, right_side) result(change)
    type(coarse_circles), intent(inout) :: coarse  !! with stiffness; only its work space changes
    real(real64), intent(in) :: right_side(:)      !! by square; of those with stiffness
    real(real64) :: change(size(right_side))
    real(real64), dimension(size(right_side)) :: root, residual, direction, image
    real(real64) :: square, first_square, last_square, half
    integer :: power, round

    ! K is scaled by a power of two, so that its root has the same digits in any unit; half of the
    ! power does not overflow.
    power = exponent(maxval(coarse%stiffness))
    half = scale(0.5_real64, power)
    root = sqrt(scale(coarse%stiffness, -power))
    residual = root * right_side
    direction = residual
    change = 0.0_real64
    square = sum(residual**2)
    first_square = square
    do round = 1, size(residual)
      if (.not. square > coarse_residual**2 * first_square) exit
      image = direction + root * (2 * (half * pressed_displacement(coarse, root * direction)))
      last_square = square
      square = square / sum(direction * image)
      change = change + square * direction
      residual = residual - square * image
      square = sum(residual**2)
      direction = residual + (square / last_square) * direction
    end do
    where (root > 0.0_real64) change = change / root
  end function shared_change

end module asperity_coarse_circles
