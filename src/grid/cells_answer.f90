!> What the pressures on the cells of a cluster mean for its contacts.
module asperity_cells_answer
  use asperity_cells_lattice, only: cell_lattice, gap_at, gap_shape
  use asperity_constants, only: pi
  use asperity_element_pressures, only: element_pressures
  use asperity_kinds, only: real64
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: cell_contact, cells_answer, keep_elements, tell

  ! Root mean square of the relative error of the area of a scene on n elements in the radius of its
  ! largest contact, times n**(3/2): the number of lattice points in a circle is in error by the
  ! root of the radius (Kendall 1948). Measured: 0.83, 0.29 and 0.10 % at 6, 12 and 24, five times
  ! that at most (178 scenes of 2 to 40 contacts against test/truth/dense_truth.py; test:
  ! estimates of areas in test/regression/test_dense.py).
  real(real64), parameter, public :: area_error = 0.12_real64

  !> A contact on cells. Loads, lengths and pressures in the units of the pairs.
  type :: cell_contact
    real(real64) :: load = 0.0_real64      !! vertical
    real(real64) :: area = 0.0_real64      !! in plan
    real(real64) :: pressure = 0.0_real64  !! greatest mean over a cell
    !> centre of the pressure; of a member without any: first touch
    real(real64) :: x = 0.0_real64, y = 0.0_real64
    real(real64) :: error = 0.0_real64     !! of the load by the cells, root mean square
  end type cell_contact

  !> What the cells answer.
  type :: cells_answer
    type(cell_contact), allocatable :: together(:)  !! by member
    type(cell_contact), allocatable :: alone(:)     !! each alone, nothing outside, same cells
    logical, allocatable :: known_alone(:)          !! isolated load solved on them; else Hertz' law
    integer :: cells = 0                            !! of the lattice
    real(real64), allocatable :: beside(:)          !! displacement at each circle of the field
    real(real64) :: error = 0.0_real64              !! of the load, estimate
    real(real64) :: area_error = 0.0_real64         !! of the area, relative, root mean square
    !> of the solve; residual: largest violation of the gap over the deepest penetration
    type(solve_ending) :: ending
    type(element_pressures) :: loaded               !! where they are kept: the loaded elements
    character(:), allocatable :: failure            !! why it did not converge
  end type cells_answer

contains

  !> What the forces of a lattice mean for every contact.
  subroutine tell(modulus, shapes, lattice, contacts)
    real(real64), intent(in) :: modulus               !! combined
    type(gap_shape), intent(in) :: shapes(:)          !! the contacts that penetrate
    type(cell_lattice), intent(in) :: lattice         !! solved
    type(cell_contact), intent(inout) :: contacts(:)  !! by member; set for those that penetrate
    ! Of force: means of x, y, places in cells from first touch; sums of its powers.
    real(real64) :: moment(2, size(shapes)), sums(3, size(shapes)), highest(size(shapes)), radius
    real(real64) :: x, y, slit(size(shapes))
    integer :: free(size(shapes))   ! sides on the rim
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
          x = lattice%left + i - 0.5_real64 + (lattice%x - shapes(k)%x) / lattice%cell
          y = lattice%bottom + j - 0.5_real64 + (lattice%y - shapes(k)%y) / lattice%cell
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
      associate (one => contacts(shapes(k)%pair), load => sums(2, k), h => lattice%cell)
        one%load = modulus * lattice%scale * h * load
        one%pressure = modulus * (lattice%scale / h) * highest(k)
        one%area = h**2 * cells_of(sums(:, k)) * exp(-slit(k) / cells_of(sums(:, k)))
        one%x = shapes(k)%x + h * moment(1, k) / load
        one%y = shapes(k)%y + h * moment(2, k) / load
        ! The error of a load is at most half of that of the area, over n, as the pressure falls to
        ! zero at the rim: 3.0e-3, 5.3e-4, 9.7e-5, 1.3e-5 at n = 3, 6, 12, 24 in the root mean
        ! square. A circle has 8 sides a radius on its rim; where it lies in another it has none.
        radius = max(1.0_real64, sqrt(cells_of(sums(:, k)) / pi))
        one%error = 0.5_real64 * area_error * one%load / radius**2.5_real64 * &
                    min(1.0_real64, free(k) / (8 * radius))
      end associate
    end do
  end subroutine tell

  !> Lists the loaded elements of a lattice.
  pure subroutine keep_elements(lattice, pair, loaded)
    type(cell_lattice), intent(in) :: lattice           !! solved
    integer, intent(in) :: pair(:)                      !! place in the list of pairs, by owner
    type(element_pressures), intent(inout) :: loaded    !! gets them, in the unit of the pairs
    integer :: i, j, number

    number = count(lattice%force > 0.0_real64)
    allocate (loaded%pair(number), loaded%x(number), loaded%y(number), loaded%force(number))
    allocate (loaded%side(number), source=lattice%cell)
    number = 0
    do j = 1, size(lattice%force, 2)
      do i = 1, size(lattice%force, 1)
        if (.not. lattice%force(i, j) > 0.0_real64) cycle
        number = number + 1
        loaded%pair(number) = pair(lattice%owner(i, j))
        loaded%x(number) = lattice%x + (lattice%left + i - 0.5_real64) * lattice%cell
        loaded%y(number) = lattice%y + (lattice%bottom + j - 0.5_real64) * lattice%cell
        loaded%force(number) = lattice%force(i, j)
      end do
    end do
  end subroutine keep_elements

  ! Cells in contact, from the sums of the powers 1/2, 1 and 2 of their forces. The pressure of
  ! Hertz has the integrals A p0**k/(1 + k/2) of its powers, whatever the ellipse. So the area is
  ! the value at k = 0 of the parabola through the logarithms of three of them, times (1 + k/2).
  ! Cells at the rim, which are loaded or not by luck, hardly count.
  pure real(real64) function cells_of(sums)
    real(real64), intent(in) :: sums(:)

    cells_of = (1.25_real64 * sums(1))**(8.0_real64 / 3.0_real64) / (1.5_real64 * sums(2))**2 * &
               (2.0_real64 * sums(3))**(1.0_real64 / 3.0_real64)
  end function cells_of

  ! Where two contacts meet the rigid surface has a crease, into which no body is pressed: along it
  ! a slit stays open, of a width w at which the pressure beside is that of the complement of a
  ! wedge, E s/pi arcosh(2 x/w), with s half the step of the slope and x from the crease. Where w is
  ! less than a cell no cell opens. Then w follows from the mean pressures of the cells on both
  ! sides, as E s/pi log(4 x/w); what cells of little pressure count less than whole is of it.
  subroutine find_slits(shapes, lattice, sums, slit)
    type(gap_shape), intent(in) :: shapes(:)
    type(cell_lattice), intent(in) :: lattice
    real(real64), intent(in) :: sums(:, :)   ! of powers of forces, by contact
    real(real64), intent(out) :: slit(:)     ! of each contact, in cells
    real(real64) :: x, y, middle, ends(2, 2), steps(2), bend, step, apart_by(2), lost
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
            middle = apart(0.0_real64, 0.0_real64)
            ends = reshape([apart(-0.5_real64, 0.0_real64), apart(0.5_real64, 0.0_real64), &
                            apart(0.0_real64, -0.5_real64), apart(0.0_real64, 0.5_real64)], [2, 2])
            bend = 2 * (sum(ends) - 4 * middle)
            steps = ends(2, :) - ends(1, :)
            ! On the crease, which bends.
            step = sqrt(max(0.0_real64, sum(steps**2) - 2 * bend * middle))
            if (.not. step > 0.0_real64) cycle
            apart_by = 2 * ends(:, side) / &
                       (step + sqrt(max(0.0_real64, step**2 + 2 * bend * ends(:, side))))
            lost = 4 * exp(0.5_real64 * sum(mean_log(apart_by)) - &
                           pi * sum(force) * lattice%scale / step)
            lost = lost - (1 - counted(force(1), sums(:, a))) - (1 - counted(force(2), sums(:, b)))
            slit([a, b]) = slit([a, b]) + 0.5_real64 * max(0.0_real64, lost) * &
                           abs(steps(side)) / norm2(steps) * (step / (step + 2 * abs(bend)))
          end associate
        end do
      end do
    end do

  contains

    ! How much farther up the second surface is beside the middle of the side.
    real(real64) function apart(dx, dy)
      real(real64), intent(in) :: dx, dy    ! in cells

      associate (h => lattice%cell, a => shapes(lattice%owner(i, j)), &
                 b => shapes(lattice%owner(other(1), other(2))))
        apart = gap_at(b, lattice%x - b%x + (x + dx) * h, lattice%y - b%y + (y + dy) * h) - &
                gap_at(a, lattice%x - a%x + (x + dx) * h, lattice%y - a%y + (y + dy) * h)
      end associate
    end function apart

  end subroutine find_slits

  ! Of the distance from a line over a cell of width 1 whose middle is so far from it.
  elemental real(real64) function mean_log(middle)
    real(real64), intent(in) :: middle
    real(real64) :: ends(2)

    ends = middle + [-0.5_real64, 0.5_real64]
    mean_log = dot_product([-1, 1], ends * log(max(tiny(middle), abs(ends)))) - 1
  end function mean_log

  ! What a cell counts in the area.
  pure real(real64) function counted(force, sums)
    real(real64), intent(in) :: force, sums(:)

    counted = min(1.0_real64, cells_of(sums) * (8 * sqrt(force) / sums(1) - &
                  6 * force / sums(2) + force**2 / sums(3)) / 3)
  end function counted

end module asperity_cells_answer
