!> A cluster of contacts resolved on cells, under the field of the contacts outside.
!>
!> The two bodies are one half-space of the combined modulus under a rigid surface, the sum of both
!> profiles; the gap is vertical, also where a pair is inclined. There are no periodic images and no
!> end of the half-space. The cells are halved until the load settles.
module asperity_cells_solver
  use asperity_cell_convolution, only: cell_convolution
  use asperity_cells_gap, only: gap_shape, shape_of_gap
  use asperity_cells_influence, only: influence_table
  use asperity_cells_lattice, only: box_of, cell_frame, cell_lattice, cells_expected, frame_of, &
                                    lay_cells
  use asperity_cells_outside, only: add_outside, outside_field
  use asperity_cells_relax, only: relax
  use asperity_constants, only: pi
  use asperity_contact_pairs, only: contact_pairs
  use asperity_kinds, only: real64
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: cells_answer, outside_field, reach_of_cluster, solve_cells

  ! Cells per radius of the contact that would bear most alone, before any halving.
  real(real64), parameter :: coarse_cells = 3.0_real64

  ! Bytes that may be held, and that are held for each cell.
  real(real64), parameter :: bytes_allowed = 2.0_real64**31, bytes_per_cell = 170.0_real64

  ! A penetration below this, over the radius, is not solved: its squares leave the range.
  real(real64), parameter :: shallowest = 1.0e-120_real64

  ! Cells over-count an area by that times the sides on their rim: measured on Hertz contacts, .032
  ! to .038 from 27 to 3.4 cells per radius, means over 64 places of the lattice. (Where pressures
  ! stand at points it is .118: Yastrebov, Anciaux and Molinari, Tribol. Int. 114 (2017) 161-171.)
  ! What is left scatters by 1 %, .25 % and .12 % of the area at 7, 13 and 27 cells per radius.
  real(real64), parameter :: rim = 1.0_real64 / 30.0_real64

  ! A load is told as exactly as if it were at least that of the largest contact alone, times this.
  real(real64), parameter :: least_share = 1.0e-3_real64

  !> What the cells answer, by member. Loads, lengths and pressures in the units of the pairs.
  type :: cells_answer
    real(real64), allocatable :: vertical_load(:)     !! all members together
    real(real64), allocatable :: alone_load(:)        !! of each alone, nothing outside, same cells
    real(real64), allocatable :: area(:)              !! in plan, corrected at the rim
    real(real64), allocatable :: maximum_pressure(:)  !! mean over a cell
    real(real64), allocatable :: centre_x(:)          !! of its pressure; unloaded: first touch
    real(real64), allocatable :: centre_y(:)          !! of its pressure; unloaded: first touch
    integer :: cells = 0                              !! of the finest lattice
    integer :: halvings = 0                           !! of the cells, from the coarsest
    real(real64) :: change = huge(1.0_real64)         !! relative, of the load by the last halving
    !> of the solve on the finest lattice; residual: largest violation of the gap over the deepest
    !> penetration
    type(solve_ending) :: ending
    character(:), allocatable :: failure              !! why it did not converge
  end type cells_answer

contains

  !> The rectangle in plan in which the cells of a cluster will lie; a point when nothing touches.
  pure subroutine reach_of_cluster(pairs, members, closing, x0, x1, y0, y1)
    type(contact_pairs), intent(in) :: pairs       !! the position
    integer, intent(in) :: members(:)              !! places of the contacts in the list of pairs
    real(real64), intent(in) :: closing            !! past first touch
    real(real64), intent(out) :: x0, x1, y0, y1    !! its sides
    type(gap_shape), allocatable :: shapes(:)
    real(real64) :: low(2), high(2)

    call find_shapes(pairs, members, closing, shapes)
    low = [pairs%list(members(1))%x, pairs%list(members(1))%y]
    high = low
    if (size(shapes) > 0) call box_of(shapes, 0.0_real64, 0.0_real64, low, high)
    x0 = low(1)
    y0 = low(2)
    x1 = high(1)
    y1 = high(2)
  end subroutine reach_of_cluster

  !> Solves a cluster at a closing.
  !>
  !> Members that touch at the same place share one contact: its load is told under the first.
  subroutine solve_cells(pairs, members, closing, outside, tolerance, answer)
    type(contact_pairs), intent(in) :: pairs       !! the position
    integer, intent(in) :: members(:)              !! places of the contacts in the list of pairs
    real(real64), intent(in) :: closing            !! past first touch
    type(outside_field), intent(in) :: outside     !! of the contacts that are no members
    real(real64), intent(in) :: tolerance          !! relative change by the last halving
    type(cells_answer), intent(out) :: answer      !! the answer
    type(gap_shape), allocatable :: shapes(:)
    real(real64), allocatable :: zero(:)

    allocate (zero(size(members)))
    zero = 0.0_real64
    allocate (answer%vertical_load, answer%alone_load, answer%area, answer%maximum_pressure, &
              answer%centre_x, answer%centre_y, source=zero)
    answer%centre_x = pairs%list(members)%x
    answer%centre_y = pairs%list(members)%y
    call find_shapes(pairs, members, closing, shapes)
    if (size(shapes) == 0) then
      answer%change = 0.0_real64
      answer%ending = solve_ending(.true., 0.0_real64, 0)
    else if (.not. all(shapes%penetration < pairs%list(members(shapes%pair))%zc)) then
      answer%failure = 'a penetration reaches the level of the centres'
    else if (.not. maxval(shapes%penetration / shapes%curvature_radius) > shallowest) then
      answer%failure = 'contacts too shallow for cells'
    else
      call halve_until_settled(pairs%modulus, shapes, outside, tolerance, answer)
    end if
    if (allocated(answer%failure)) answer%ending%converged = .false.
  end subroutine solve_cells

  ! The members that penetrate; a shape's pair is its place among the members.
  pure subroutine find_shapes(pairs, members, closing, shapes)
    type(contact_pairs), intent(in) :: pairs
    integer, intent(in) :: members(:)
    real(real64), intent(in) :: closing
    type(gap_shape), allocatable, intent(out) :: shapes(:)
    integer :: i, n

    allocate (shapes(count(closing - pairs%list(members)%gap > 0.0_real64)))
    n = 0
    do i = 1, size(members)
      associate (pair => pairs%list(members(i)))
        if (.not. closing - pair%gap > 0.0_real64) cycle
        n = n + 1
        shapes(n) = shape_of_gap(pair, i, closing - pair%gap)
      end associate
    end do
  end subroutine find_shapes

  subroutine halve_until_settled(modulus, shapes, outside, tolerance, answer)
    real(real64), intent(in) :: modulus, tolerance
    type(gap_shape), intent(in) :: shapes(:)
    type(outside_field), intent(in) :: outside
    type(cells_answer), intent(inout) :: answer
    type(cell_frame) :: frame
    type(cell_lattice) :: lattice, coarse
    real(real64), allocatable :: force(:, :), coarse_force(:, :)
    real(real64) :: before, total, worth
    integer :: i

    frame = frame_of(shapes, coarse_cells)
    ! Hertz.
    worth = least_share * 4.0_real64 / 3.0_real64 / frame%scale * &
            maxval(shapes%contact_radius * shapes%penetration * shapes%cosine)
    total = 0.0_real64
    do
      if (.not. bytes_per_cell * cells_expected(frame, shapes, answer%halvings) < &
          bytes_allowed) then
        answer%failure = 'cells fine enough would need more than 2 GiB of memory'
        return
      end if
      call lay_cells(frame, shapes, answer%halvings, lattice)
      call add_outside(outside, frame, modulus, lattice)
      allocate (force, mold=lattice%gap)
      if (answer%halvings == 0) then
        call start_forces(frame, shapes, lattice, force)
      else
        call refine_forces(coarse, coarse_force, lattice, force)
      end if
      call solve_on(lattice, tolerance, force, answer%ending)
      before = total
      total = sum(force) * lattice%cell
      if (answer%halvings > 0) answer%change = abs(before - total) / max(total, worth)
      if (.not. answer%ending%converged) then
        answer%failure = 'the pressures on the cells did not converge'
        return
      end if
      if (answer%change <= tolerance .and. expected_error(answer%halvings) <= tolerance) exit
      answer%halvings = answer%halvings + 1
      coarse = lattice
      call move_alloc(force, coarse_force)
    end do
    answer%cells = size(force)
    call tell(modulus, frame, shapes, lattice, force, answer)
    do i = 1, size(shapes)
      call solve_alone(modulus, frame, shapes(i:i), tolerance, answer)
    end do
  end subroutine halve_until_settled

  ! What the cells may be off in the load of a round contact: the largest over 64 places of the
  ! lattice was 9e-3, 1.2e-3, 2.7e-4 and 4.2e-5 at 3, 6, 12 and 24 cells per radius. A small change
  ! alone may be luck.
  pure real(real64) function expected_error(halvings)
    integer, intent(in) :: halvings

    expected_error = 0.13_real64 / (coarse_cells * 2.0_real64**halvings)**2.5_real64
  end function expected_error

  ! A contact by itself on cells as fine as the cluster's.
  subroutine solve_alone(modulus, frame, shape, tolerance, answer)
    real(real64), intent(in) :: modulus, tolerance
    type(cell_frame), intent(in) :: frame
    type(gap_shape), intent(in) :: shape(1)
    type(cells_answer), intent(inout) :: answer
    type(cell_lattice) :: lattice
    type(solve_ending) :: ending
    real(real64), allocatable :: force(:, :)

    call lay_cells(frame, shape, answer%halvings, lattice)
    allocate (force, mold=lattice%gap)
    call start_forces(frame, shape, lattice, force)
    call solve_on(lattice, tolerance, force, ending)
    answer%alone_load(shape(1)%pair) = modulus * frame%scale * lattice%cell * sum(force)
    if (.not. ending%converged) &
      answer%failure = 'the pressures on the cells of a contact alone did not converge'
  end subroutine solve_alone

  ! Forces are over the modulus, the scale and the side of a cell.
  subroutine solve_on(lattice, tolerance, force, ending)
    type(cell_lattice), intent(in) :: lattice
    real(real64), intent(in) :: tolerance
    real(real64), intent(inout) :: force(:, :)
    type(solve_ending), intent(out) :: ending
    type(cell_convolution) :: influence
    real(real64), allocatable :: table(:, :)

    allocate (table(size(force, 1), size(force, 2)))
    call influence_table(table)
    table = table / pi
    call influence%prepare(table)
    deallocate (table)
    call relax(influence, lattice%gap, max(1.0e-10_real64, 1.0e-2_real64 * tolerance), force, &
               ending)
  end subroutine solve_on

  ! The pressure of Hertz under every contact as if alone: 2/pi E (a/R) sqrt(1 - (r/a)**2), and its
  ! undeformed gap is p (r**2/(2 a**2) - 1).
  subroutine start_forces(frame, shapes, lattice, force)
    type(cell_frame), intent(in) :: frame
    type(gap_shape), intent(in) :: shapes(:)
    type(cell_lattice), intent(in) :: lattice
    real(real64), intent(out) :: force(:, :)
    integer :: i, j

    force = 0.0_real64
    do j = 1, size(force, 2)
      do i = 1, size(force, 1)
        if (lattice%owner(i, j) == 0) cycle
        associate (s => shapes(lattice%owner(i, j)))
          force(i, j) = 2.0_real64 / pi * (s%penetration / frame%scale) * &
                        (lattice%cell / s%contact_radius) * sqrt(max(0.0_real64, &
                        -1.0_real64 - 2.0_real64 * lattice%gap(i, j) * frame%scale / s%penetration))
        end associate
      end do
    end do
  end subroutine start_forces

  ! Forces on halved cells, interpolated in both directions from the cells before.
  subroutine refine_forces(coarse, coarse_force, fine, force)
    type(cell_lattice), intent(in) :: coarse, fine
    real(real64), intent(in) :: coarse_force(:, :)
    real(real64), intent(out) :: force(:, :)
    integer :: i, j, x, y, across, along

    force = 0.0_real64
    do j = 1, size(force, 2)
      y = floor_half(fine%bottom + j - 1) - coarse%bottom + 1
      along = 2 * modulo(fine%bottom + j - 1, 2) - 1
      do i = 1, size(force, 1)
        if (fine%owner(i, j) == 0) cycle
        x = floor_half(fine%left + i - 1) - coarse%left + 1
        across = 2 * modulo(fine%left + i - 1, 2) - 1
        ! The fine cell's centre is a quarter of a coarse cell from the coarse one's; its area a
        ! quarter; its unit of force a half.
        force(i, j) = (9.0_real64 * at(x, y) + 3.0_real64 * at(x + across, y) + &
                       3.0_real64 * at(x, y + along) + at(x + across, y + along)) / 32.0_real64
      end do
    end do

  contains

    pure real(real64) function at(x, y)
      integer, intent(in) :: x, y

      at = 0.0_real64
      if (min(x, y) < 1 .or. x > size(coarse_force, 1) .or. y > size(coarse_force, 2)) return
      at = coarse_force(x, y)
    end function at

  end subroutine refine_forces

  pure integer function floor_half(i)
    integer, intent(in) :: i

    floor_half = (i - modulo(i, 2)) / 2
  end function floor_half

  subroutine tell(modulus, frame, shapes, lattice, force, answer)
    real(real64), intent(in) :: modulus
    type(cell_frame), intent(in) :: frame
    type(gap_shape), intent(in) :: shapes(:)
    type(cell_lattice), intent(in) :: lattice
    real(real64), intent(in) :: force(:, :)
    type(cells_answer), intent(inout) :: answer
    real(real64) :: sums(3, size(shapes)), sides(size(shapes)), unit
    integer :: i, j, k

    sums = 0.0_real64
    sides = 0.0_real64
    do j = 1, size(force, 2)
      do i = 1, size(force, 1)
        if (.not. force(i, j) > 0.0_real64) cycle
        k = lattice%owner(i, j)
        sums(:, k) = sums(:, k) + force(i, j) * [1.0_real64, lattice%left + i - 0.5_real64, &
                                                 lattice%bottom + j - 0.5_real64]
        answer%area(shapes(k)%pair) = answer%area(shapes(k)%pair) + lattice%cell**2
        sides(k) = sides(k) + open_at(i - 1, j) + open_at(i + 1, j) + open_at(i, j - 1) + &
                   open_at(i, j + 1)
        answer%maximum_pressure(shapes(k)%pair) = max(answer%maximum_pressure(shapes(k)%pair), &
                                                      force(i, j))
      end do
    end do
    unit = modulus * frame%scale * lattice%cell
    do k = 1, size(shapes)
      i = shapes(k)%pair
      if (.not. sums(1, k) > 0.0_real64) cycle
      answer%vertical_load(i) = unit * sums(1, k)
      answer%maximum_pressure(i) = modulus * (frame%scale / lattice%cell) * &
                                   answer%maximum_pressure(i)
      answer%area(i) = answer%area(i) - rim * sides(k) * lattice%cell**2
      answer%centre_x(i) = frame%x + lattice%origin_x + lattice%cell * sums(2, k) / sums(1, k)
      answer%centre_y(i) = frame%y + lattice%origin_y + lattice%cell * sums(3, k) / sums(1, k)
    end do

  contains

    ! 1 for a cell without force.
    pure real(real64) function open_at(i, j)
      integer, intent(in) :: i, j

      open_at = 1.0_real64
      if (i < 1 .or. j < 1 .or. i > size(force, 1) .or. j > size(force, 2)) return
      if (force(i, j) > 0.0_real64) open_at = 0.0_real64
    end function open_at

  end subroutine tell

end module asperity_cells_solver
