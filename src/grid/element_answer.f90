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

  !> A contact on boundary elements. Loads, lengths and pressures in the units of the pairs.
  type :: element_contact
    real(real64) :: load = 0.0_real64      !! vertical
    real(real64) :: area = 0.0_real64      !! in plan
    real(real64) :: pressure = 0.0_real64  !! largest mean over an element
    !> centre of the pressure; of a member without any: first touch
    real(real64) :: x = 0.0_real64, y = 0.0_real64
    real(real64) :: error = 0.0_real64     !! of the load, root mean square
  end type element_contact

  !> Solution of a cluster on boundary elements.
  type :: element_answer
    type(element_contact), allocatable :: together(:)  !! by member
    type(element_contact), allocatable :: alone(:)     !! isolated, on the same elements
    logical, allocatable :: known_alone(:)          !! isolated load solved on them; else Hertz' law
    integer :: elements = 0                         !! number of elements of the lattice
    real(real64), allocatable :: beside(:)          !! displacement at each circle of the field
    real(real64) :: error = 0.0_real64              !! of the load, estimate
    real(real64) :: area_error = 0.0_real64         !! of the area, relative, root mean square
    !> of the solve; residual: largest violation of the gap over the deepest penetration
    type(solve_ending) :: ending
    type(element_pressures) :: loaded               !! where they are kept: the loaded elements
    character(:), allocatable :: failure            !! why it did not converge
  end type element_answer

contains

  !> Finds load, area, pressure and centre of each contact from the forces of a lattice.
  subroutine find_contacts(modulus, shapes, lattice, contacts)
    real(real64), intent(in) :: modulus               !! combined modulus, > 0
    type(gap_shape), intent(in) :: shapes(:)          !! the contacts that penetrate
    type(element_lattice), intent(in) :: lattice      !! elements with their forces
    type(element_contact), intent(inout) :: contacts(:)  !! by member; set for those that penetrate
    ! Forces times x, y in elements from first touch; sums of powers; largest force.
    real(real64) :: moment(2, size(shapes)), sums(3, size(shapes)), highest(size(shapes)), radius
    real(real64) :: x, y, slit(size(shapes))
    integer :: free(size(shapes))   ! number of sides on the rim
    integer :: i, j, k, columns, rows

    moment = 0.0_real64
    sums = 0.0_real64
    highest = 0.0_real64
    free = 0
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
          highest(k) = max(highest(k), force)
          free(k) = free(k) + count([ &
            lattice%force([max(1, i - 1), min(columns, i + 1)], j), &
            lattice%force(i, [max(1, j - 1), min(rows, j + 1)])] <= 0.0_real64)
        end associate
      end do
    end do
    call find_slits(shapes, lattice, sums, slit)
    do k = 1, size(shapes)
      if (.not. highest(k) > 0.0_real64) cycle
      associate (one => contacts(shapes(k)%pair), load => sums(2, k), h => lattice%side)
        one%load = modulus * lattice%depth * h * load
        one%pressure = modulus * (lattice%depth / h) * highest(k)
        one%area = h**2 * loaded_elements(sums(:, k)) * exp(-slit(k) / loaded_elements(sums(:, k)))
        one%x = shapes(k)%x + h * moment(1, k) / load
        one%y = shapes(k)%y + h * moment(2, k) / load
        ! The error of a load is at most half of that of the area, over n, as the pressure falls to
        ! zero at the rim: 3.0e-3, 5.3e-4, 9.7e-5, 1.3e-5 at n = 3, 6, 12, 24 in the root mean
        ! square. A circle has 8 sides a radius on its rim; where it lies in another it has none.
        radius = max(1.0_real64, sqrt(loaded_elements(sums(:, k)) / pi))
        one%error = 0.5_real64 * area_error * one%load / radius**2.5_real64 * &
                    min(1.0_real64, free(k) / (8 * radius))
      end associate
    end do
  end subroutine find_contacts

  !> Lists the loaded elements of a lattice.
  pure subroutine keep_elements(lattice, pair, loaded)
    type(element_lattice), intent(in) :: lattice        !! elements with their forces
    integer, intent(in) :: pair(:)                      !! place in the list of pairs, by owner
    type(element_pressures), intent(inout) :: loaded    !! gets them, in the unit of the pairs
    integer :: i, j, number

    number = count(lattice%force > 0.0_real64)
    allocate (loaded%pair(number), loaded%x(number), loaded%y(number), loaded%force(number))
    allocate (loaded%side(number), source=lattice%side)
    number = 0
    do j = 1, size(lattice%force, 2)
      do i = 1, size(lattice%force, 1)
        if (.not. lattice%force(i, j) > 0.0_real64) cycle
        number = number + 1
        loaded%pair(number) = pair(lattice%owner(i, j))
        loaded%x(number) = lattice%x + (lattice%left + i - 0.5_real64) * lattice%side
        loaded%y(number) = lattice%y + (lattice%bottom + j - 0.5_real64) * lattice%side
        loaded%force(number) = lattice%force(i, j)
      end do
    end do
  end subroutine keep_elements

  ! Number of elements in contact, from the sums of the powers 1/2, 1 and 2 of their forces. The
  ! pressure of Hertz has the integrals A p0**k/(1 + k/2) of its powers, whatever the ellipse. So
  ! the area is the value at k = 0 of the parabola through the logarithms of three of them, times (1
  ! + k/2). Elements at the rim, loaded or not by luck, hardly count.
  pure real(real64) function loaded_elements(sums)
    real(real64), intent(in) :: sums(:)

    loaded_elements = (1.25_real64 * sums(1))**(8.0_real64 / 3.0_real64) / &
                      (1.5_real64 * sums(2))**2 * (2.0_real64 * sums(3))**(1.0_real64 / 3.0_real64)
  end function loaded_elements

  ! Where two contacts meet the rigid surface has a crease, into which no body is pressed: along it
  ! a slit stays open, of a width w at which the pressure beside is that of the complement of a
  ! wedge, E s/pi arcosh(2 x/w), with s half the step of the slope and x from the crease. Where w is
  ! less than an element no element opens. Then w follows from the mean pressures of the elements on
  ! both sides, as E s/pi log(4 x/w), less the area that elements of little pressure count below 1.
  subroutine find_slits(shapes, lattice, sums, slit)
    type(gap_shape), intent(in) :: shapes(:)
    type(element_lattice), intent(in) :: lattice
    real(real64), intent(in) :: sums(:, :)   ! of powers of forces, by contact
    real(real64), intent(out) :: slit(:)     ! of each contact, in elements
    real(real64) :: x, y, middle, ends(2, 2), steps(2), bend, step, crease_distance(2), lost
    integer :: i, j, side, other(2)

    slit = 0.0_real64
    do j = 1, size(lattice%force, 2)
      do i = 1, size(lattice%force, 1)
        if (.not. lattice%force(i, j) > 0.0_real64) cycle
        do side = 1, 2
          other = [i, j]
          other(side) = other(side) + 1
          if (any(other > shape(lattice%force))) cycle
          associate (a => lattice%owner(i, j), b => lattice%owner(other(1), other(2)), &
                     force => [lattice%force(i, j), lattice%force(other(1), other(2))])
            if (a == b .or. .not. force(2) > 0.0_real64) cycle
            x = lattice%left + 0.5_real64 * (i + other(1) - 1)
            y = lattice%bottom + 0.5_real64 * (j + other(2) - 1)
            middle = rise_at(0, 0)
            ends = reshape([rise_at(-1, 0), rise_at(1, 0), rise_at(0, -1), rise_at(0, 1)], [2, 2])
            bend = 2 * (sum(ends) - 4 * middle)
            steps = ends(2, :) - ends(1, :)
            ! Step of the slope on the crease, which bends.
            step = sqrt(max(0.0_real64, sum(steps**2) - 2 * bend * middle))
            if (.not. step > 0.0_real64) cycle
            crease_distance = 2 * ends(:, side) / &
                       (step + sqrt(max(0.0_real64, step**2 + 2 * bend * ends(:, side))))
            lost = 4 * exp(0.5_real64 * sum(mean_log(crease_distance)) - &
                           pi * sum(force) * lattice%depth / step)
            lost = lost - (1 - area_share(force(1), sums(:, a))) - &
                   (1 - area_share(force(2), sums(:, b)))
            slit([a, b]) = slit([a, b]) + 0.5_real64 * max(0.0_real64, lost) * &
                           abs(steps(side)) / norm2(steps) * (step / (step + 2 * abs(bend)))
          end associate
        end do
      end do
    end do

  contains

    ! Height of the second surface above the first beside the middle of the side.
    real(real64) function rise_at(i_half, j_half)
      integer, intent(in) :: i_half, j_half    ! in halves of an element

      associate (a => shapes(lattice%owner(i, j)), &
                 b => shapes(lattice%owner(other(1), other(2))), &
                 px => lattice%x + (x + 0.5_real64 * i_half) * lattice%side, &
                 py => lattice%y + (y + 0.5_real64 * j_half) * lattice%side)
        rise_at = gap_at(b, px - b%x, py - b%y) - gap_at(a, px - a%x, py - a%y)
      end associate
    end function rise_at

  end subroutine find_slits

  ! Mean logarithm of the distance from a line over an element of width 1, from that of its middle.
  elemental real(real64) function mean_log(middle)
    real(real64), intent(in) :: middle
    real(real64) :: ends(2)

    ends = middle + [-0.5_real64, 0.5_real64]
    mean_log = dot_product([-1, 1], ends * log(max(tiny(middle), abs(ends)))) - 1
  end function mean_log

  ! Share of an element that counts in the area.
  pure real(real64) function area_share(force, sums)
    real(real64), intent(in) :: force, sums(:)

    area_share = min(1.0_real64, loaded_elements(sums) * (8 * sqrt(force) / sums(1) - &
                  6 * force / sums(2) + force**2 / sums(3)) / 3)
  end function area_share

end module asperity_element_answer
