!> Loads, areas and pressures of the contacts of a cluster from the forces on its elements.
module asperity_element_answer
  use asperity_element_lattice, only: element_lattice, gap_at, gap_shape
  use asperity_constants, only: pi
  use asperity_element_pressures, only: element_pressures
  use asperity_kinds, only: real64
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: element_contact, element_answer, find_contacts, keep_elements

  ! Root mean square of the relative error of the area of a scene on n elements in the radius of its
  ! largest contact, times n**(3/2): the number of lattice points in a circle is in error by the
  ! root of the radius (Kendall 1948). Measured: 0.83, 0.29 and 0.10 % at 6, 12 and 24, five times
  ! that at most (178 scenes of 2 to 40 contacts against test/truth/dense_truth.py; test: areas and
  ! their error estimates in test/unit/elements_suite.f90).
  real(real64), parameter, public :: area_error = 0.12_real64

  ! Area that the sums of powers of forces lack [1], in squares of the side by side of an element on
  ! the rim, as the rim cuts elements. Measured on 858 isolated contacts in numpy, circles and
  ! ellipses of 4 to 40 elements in the radius: 0.010, from 0.006 to 0.015 by size and shape (test:
  ! the area of a contact in test/unit/elements_suite.f90).
  real(real64), parameter :: rim_area = 0.01_real64

  !> A contact on boundary elements. Loads, lengths and pressures in the units of the pairs.
  type :: element_contact
    real(real64) :: load = 0.0_real64      !! vertical load, 0 or more
    real(real64) :: area = 0.0_real64      !! contact area in plan
    real(real64) :: pressure = 0.0_real64  !! largest mean pressure of an element
    !> centre of pressure in plan; without load the position of first touch
    real(real64) :: x = 0.0_real64, y = 0.0_real64
    real(real64) :: error = 0.0_real64     !! error of the load, root mean square
  end type element_contact

  !> Solution of a cluster on boundary elements.
  type :: element_answer
    type(element_contact), allocatable :: contacts(:)  !! members in the field of all contacts
    real(real64) :: compression = 0.0_real64           !! given, or of a given load [length]
    integer :: elements = 0                         !! number of elements of the lattice
    !> displacement by the elements at the centre of each circle of the outside field [length]
    real(real64), allocatable :: outside_displacement(:)
    real(real64) :: error = 0.0_real64              !! estimated error of the total load
    real(real64) :: area_error = 0.0_real64         !! relative error of the area, root mean square
    !> exit of the solve; residual: largest violation of the gap over the deepest penetration
    type(solve_ending) :: ending
    type(element_pressures) :: pressures            !! loaded elements, if the pairs keep pressures
    character(:), allocatable :: failure            !! error message; not allocated if solved
  end type element_answer

contains

  !> Finds load, area, pressure and centre of each contact from the forces of a lattice.
  subroutine find_contacts(modulus, shapes, lattice, contacts)
    real(real64), intent(in) :: modulus               !! combined modulus, > 0
    type(gap_shape), intent(in) :: shapes(:)          !! gaps of the contacts that penetrate
    type(element_lattice), intent(in) :: lattice      !! elements with their forces
    type(element_contact), intent(inout) :: contacts(:)  !! by member; set for those that penetrate
    ! Sum of forces times their x, y from first touch, in elements; sums of powers 1/2, 1, 2.
    real(real64) :: moment(2, size(shapes)), sums(3, size(shapes))
    real(real64) :: largest_force(size(shapes)), slit_area(size(shapes)), radius, x, y
    integer :: rim_sides(size(shapes))  ! number of sides of elements on the rim of the contact
    integer :: i, j, k, columns, rows

    moment = 0.0_real64
    sums = 0.0_real64
    largest_force = 0.0_real64
    rim_sides = 0
    columns = size(lattice%force, 1)
    rows = size(lattice%force, 2)
    do j = 1, rows
      do i = 1, columns
        associate (force => lattice%force(i, j))
          if (.not. force > 0.0_real64) cycle
          k = lattice%owner(i, j)
          x = lattice%left + i - 0.5_real64 + (lattice%x - shapes(k)%x) / lattice%side
          y = lattice%bottom + j - 0.5_real64 + (lattice%y - shapes(k)%y) / lattice%side
          moment(:, k) = moment(:, k) + force * [x, y]
          sums(:, k) = sums(:, k) + [sqrt(force), force, force**2]
          largest_force(k) = max(largest_force(k), force)
          rim_sides(k) = rim_sides(k) + count([ &
            lattice%force([max(1, i - 1), min(columns, i + 1)], j), &
            lattice%force(i, [max(1, j - 1), min(rows, j + 1)])] <= 0.0_real64)
        end associate
      end do
    end do
    call find_slit_areas(shapes, lattice, sums, slit_area)
    do k = 1, size(shapes)
      if (.not. largest_force(k) > 0.0_real64) cycle
      associate (contact => contacts(shapes(k)%pair), load => sums(2, k), h => lattice%side)
        contact%load = modulus * lattice%depth * h * load
        contact%pressure = modulus * (lattice%depth / h) * largest_force(k)
        contact%area = h**2 * (loaded_elements(sums(:, k)) * &
                       exp(-slit_area(k) / loaded_elements(sums(:, k))) + rim_area * rim_sides(k))
        contact%x = shapes(k)%x + h * moment(1, k) / load
        contact%y = shapes(k)%y + h * moment(2, k) / load
        ! The error of a load is at most half of that of the area, over n, as the pressure falls to
        ! zero at the rim (measured: 3.0e-3, 5.3e-4, 9.7e-5, 1.3e-5 at n = 3, 6, 12, 24 elements
        ! in the radius, root mean square). The rim of a circle has 8 n sides; inside another
        ! contact it has none.
        radius = max(1.0_real64, sqrt(loaded_elements(sums(:, k)) / pi))
        contact%error = 0.5_real64 * area_error * contact%load / radius**2.5_real64 * &
                        min(1.0_real64, rim_sides(k) / (8 * radius))
      end associate
    end do
  end subroutine find_contacts

  !> Stores the loaded elements of a lattice: pair, position, side and force of each.
  pure subroutine keep_elements(lattice, pair, pressures)
    type(element_lattice), intent(in) :: lattice        !! elements with their forces
    integer, intent(in) :: pair(:)                      !! index in the list of pairs, by owner
    type(element_pressures), intent(out) :: pressures   !! loaded elements, unit of the pairs
    integer :: i, j, number

    number = count(lattice%force > 0.0_real64)
    allocate (pressures%pair(number), pressures%x(number), pressures%y(number), &
              pressures%force(number))
    allocate (pressures%side(number), source=lattice%side)
    number = 0
    do j = 1, size(lattice%force, 2)
      do i = 1, size(lattice%force, 1)
        if (.not. lattice%force(i, j) > 0.0_real64) cycle
        number = number + 1
        pressures%pair(number) = pair(lattice%owner(i, j))
        pressures%x(number) = lattice%x + (lattice%left + i - 0.5_real64) * lattice%side
        pressures%y(number) = lattice%y + (lattice%bottom + j - 0.5_real64) * lattice%side
        pressures%force(number) = lattice%force(i, j)
      end do
    end do
  end subroutine keep_elements

  ! Number of elements in contact, from the sums of the powers 1/2, 1 and 2 of their forces. Over
  ! any ellipse of area A the power k of the pressure of Hertz has the integral A p0**k/(1 + k/2).
  ! The area is extrapolated to k = 0 by a parabola in k through the logarithms of (1 + k/2) times
  ! the three sums. Elements at the rim, which are loaded or open by chance, have little weight.
  pure real(real64) function loaded_elements(sums)
    real(real64), intent(in) :: sums(:)

    loaded_elements = (1.25_real64 * sums(1))**(8.0_real64 / 3.0_real64) / &
                      (1.5_real64 * sums(2))**2 * (2.0_real64 * sums(3))**(1.0_real64 / 3.0_real64)
  end function loaded_elements

  ! Area of the open slits between contacts that merge, in elements. Where two contacts meet the
  ! rigid surface has a crease, which no body fills: a slit of width w stays open along it. The
  ! pressure at the distance x from the crease is that of the complement of a wedge,
  ! E s/pi arcosh(2 x/w), with s half of the jump of the slope. Where w is less than an element, no
  ! element is open. Then w follows from the mean pressures of the elements on both sides, as
  ! E s/pi log(4 x/w), less the part of these elements that is not counted in the area.
  subroutine find_slit_areas(shapes, lattice, sums, slit_area)
    type(gap_shape), intent(in) :: shapes(:)
    type(element_lattice), intent(in) :: lattice
    real(real64), intent(in) :: sums(:, :)     ! (power, contact): sums of powers of forces
    real(real64), intent(out) :: slit_area(:)  ! by contact, in elements
    real(real64) :: x, y, middle_rise, side_rise(2, 2), slope_jump(2), second_difference
    real(real64) :: crease_jump, crease_distance(2), slit_width
    integer :: i, j, side, neighbour(2)

    slit_area = 0.0_real64
    do j = 1, size(lattice%force, 2)
      do i = 1, size(lattice%force, 1)
        if (.not. lattice%force(i, j) > 0.0_real64) cycle
        do side = 1, 2
          neighbour = [i, j]
          neighbour(side) = neighbour(side) + 1
          if (any(neighbour > shape(lattice%force))) cycle
          associate (a => lattice%owner(i, j), b => lattice%owner(neighbour(1), neighbour(2)), &
                     force => [lattice%force(i, j), lattice%force(neighbour(1), neighbour(2))])
            if (a == b .or. .not. force(2) > 0.0_real64) cycle
            x = lattice%left + 0.5_real64 * (i + neighbour(1) - 1)
            y = lattice%bottom + 0.5_real64 * (j + neighbour(2) - 1)
            middle_rise = rise_at(0, 0)
            side_rise = reshape([rise_at(-1, 0), rise_at(1, 0), rise_at(0, -1), rise_at(0, 1)], &
                                [2, 2])
            second_difference = 2 * (sum(side_rise) - 4 * middle_rise)
            slope_jump = side_rise(2, :) - side_rise(1, :)
            ! Jump of the slope at the crease itself, as the rise is curved.
            crease_jump = sqrt(max(0.0_real64, sum(slope_jump**2) - &
                                   2 * second_difference * middle_rise))
            if (.not. crease_jump > 0.0_real64) cycle
            crease_distance = 2 * side_rise(:, side) / (crease_jump + sqrt(max(0.0_real64, &
              crease_jump**2 + 2 * second_difference * side_rise(:, side))))
            slit_width = 4 * exp(0.5_real64 * sum(mean_log(crease_distance)) - &
                                 pi * sum(force) * lattice%depth / crease_jump)
            slit_width = slit_width - (1 - area_share(force(1), sums(:, a))) - &
                         (1 - area_share(force(2), sums(:, b)))
            slit_area([a, b]) = slit_area([a, b]) + 0.5_real64 * max(0.0_real64, slit_width) * &
                                abs(slope_jump(side)) / norm2(slope_jump) * &
                                (crease_jump / (crease_jump + 2 * abs(second_difference)))
          end associate
        end do
      end do
    end do

  contains

    ! Height of the second contact's surface above the first one's, near the side that separates
    ! their elements.
    real(real64) function rise_at(i_half, j_half)
      integer, intent(in) :: i_half, j_half  ! offset from the middle of the side, half elements

      associate (a => shapes(lattice%owner(i, j)), &
                 b => shapes(lattice%owner(neighbour(1), neighbour(2))), &
                 px => lattice%x + (x + 0.5_real64 * i_half) * lattice%side, &
                 py => lattice%y + (y + 0.5_real64 * j_half) * lattice%side)
        rise_at = gap_at(b, px - b%x, py - b%y) - gap_at(a, px - a%x, py - a%y)
      end associate
    end function rise_at

  end subroutine find_slit_areas

  ! Mean over an element of width 1 of the logarithm of the distance from a line.
  elemental real(real64) function mean_log(centre)
    real(real64), intent(in) :: centre  ! distance of the centre of the element
    real(real64) :: sides(2)

    sides = centre + [-0.5_real64, 0.5_real64]
    mean_log = dot_product([-1, 1], sides * log(max(tiny(centre), abs(sides)))) - 1
  end function mean_log

  ! Share of an element in the area: the derivative of `loaded_elements` by the number of elements
  ! of its force.
  pure real(real64) function area_share(force, sums)
    real(real64), intent(in) :: force    ! force on the element
    real(real64), intent(in) :: sums(:)  ! sums of powers of the forces of its contact

    area_share = min(1.0_real64, loaded_elements(sums) * (8 * sqrt(force) / sums(1) - &
                 6 * force / sums(2) + force**2 / sums(3)) / 3)
  end function area_share

end module asperity_element_answer
