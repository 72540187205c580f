!> A cluster of contacts resolved on cells, under the field of the contacts outside.
!>
!> The two bodies are one half-space of the combined modulus under a rigid surface, the sum of both
!> profiles; the gap is vertical, also where a pair is inclined. There are no periodic images and no
!> end of the half-space. The cells are halved until the load settles.
module asperity_cells_solver
  use asperity_cell_convolution, only: cell_convolution
  use asperity_cells_answer, only: area_error, cells_answer, load_error, make_room, tell
  use asperity_cells_gap, only: gap_shape, shape_of_gap
  use asperity_cells_influence, only: influence_table
  use asperity_cells_lattice, only: box_of, cell_frame, cell_lattice, cells_expected, frame_of, &
                                    lay_cells, refine_forces, start_forces
  use asperity_cells_outside, only: add_outside, field_of_cells, outside_field
  use asperity_cells_relax, only: relax
  use asperity_constants, only: pi
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_interruption, only: interruption
  use asperity_kinds, only: real64
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: reach_of_cluster, solve_cells

  ! Cells per radius of the contact that would bear most alone, before any halving: from that on, to
  ! twice as many.
  real(real64), parameter :: coarse_cells = 4.0_real64

  ! Bytes that may be held, and that are held for each cell.
  real(real64), parameter :: bytes_allowed = 2.0_real64**31, bytes_per_cell = 170.0_real64

  ! A penetration below this, over the radius, is not solved: its squares leave the range.
  real(real64), parameter :: shallowest = 1.0e-120_real64

  ! Over the standard deviation of an area: what it may be off by. Of a load: what halving the cells
  ! that give it may change.
  real(real64), parameter :: area_told = 5.0_real64, load_told = 1.5_real64
  ! An area may be off by so much more than a load's last halving.
  real(real64), parameter :: area_over_load = 4.0_real64
  !> And by this at least, unless another number is given.
  real(real64), parameter, public :: usual_area = 0.005_real64

  ! The gaps are closed to that times the tolerance, of the penetration. The load is then off by .44
  ! (rms; 1.1 at most) of it: measured on 3 times 130 circles.
  real(real64), parameter :: inner = 0.005_real64

  ! A load is told as exactly as if it were at least that of the largest contact alone, times this.
  real(real64), parameter :: least_share = 1.0e-3_real64

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
  subroutine solve_cells(pairs, members, closing, outside, tolerance, answer, worth, &
                         area_tolerance)
    type(contact_pairs), intent(in) :: pairs       !! the position
    integer, intent(in) :: members(:)              !! places of the contacts in the list of pairs
    real(real64), intent(in) :: closing            !! past first touch
    type(outside_field), intent(in) :: outside     !! of the contacts that are no members
    real(real64), intent(in) :: tolerance          !! relative change by the last halving
    type(cells_answer), intent(out) :: answer      !! the answer
    !> load, area: what is less is told as exactly as if it were this
    real(real64), intent(in), optional :: worth(2)
    real(real64), intent(in), optional :: area_tolerance  !! share; absent: `usual_area`
    type(gap_shape), allocatable :: shapes(:)
    real(real64) :: least_area

    least_area = usual_area
    if (present(area_tolerance)) least_area = area_tolerance
    call make_room(answer, size(members))
    answer%centre_x = pairs%list(members)%x
    answer%centre_y = pairs%list(members)%y
    call find_shapes(pairs, members, closing, shapes)
    if (size(shapes) == 0) then
      answer%change = 0.0_real64
      answer%ending = solve_ending(.true., 0.0_real64, 0)
    else if (.not. all(shapes%penetration < level_height(pairs%list(members(shapes%pair))))) then
      answer%failure = 'a penetration reaches the level of the centres'
    else if (.not. maxval(shapes%penetration / shapes%curvature_radius) > shallowest) then
      answer%failure = 'contacts too shallow for cells'
    else
      call halve_until_settled(pairs%modulus, shapes, outside, tolerance, least_area, &
                               pairs%interrupt, answer, worth)
    end if
    if (.not. allocated(answer%failure)) return
    answer%ending%converged = .false.
    if (pairs%interrupt%is_asked()) answer%failure = 'interrupted'
  end subroutine solve_cells

  ! Penetration at which the centres of a pair are level, or a centre comes to the plane.
  elemental real(real64) function level_height(pair)
    type(contact_pair), intent(in) :: pair

    level_height = pair%zc
    if (.not. min(pair%upper_radius, pair%lower_radius) > 0.0_real64) level_height = pair%radius
  end function level_height

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

  subroutine halve_until_settled(modulus, shapes, outside, tolerance, least_area, interrupt, &
                                 answer, least_worth)
    real(real64), intent(in) :: modulus, tolerance, least_area
    type(gap_shape), intent(in) :: shapes(:)
    type(outside_field), intent(in) :: outside
    type(interruption), intent(in) :: interrupt
    type(cells_answer), intent(inout) :: answer
    real(real64), intent(in), optional :: least_worth(2)
    type(cell_frame) :: frame
    type(cell_lattice) :: lattice, coarse
    type(cell_convolution), allocatable :: influence
    real(real64) :: before, total, worth, alone(2), allowed, finest
    integer :: i, needed

    ! Hertz.
    alone = [4.0_real64 / 3.0_real64 * modulus * sum(shapes%contact_radius * shapes%penetration * &
                                                     shapes%cosine), &
             pi * sum(shapes%contact_radius**2)]
    worth = least_share * alone(1)
    if (present(least_worth)) worth = max(worth, least_worth(1))
    ! Cells in a radius, such that the last halving is expected to change no more than it may; and
    ! for the area.
    allowed = tolerance * max(1.0_real64, worth / alone(1))
    finest = 2 * (load_told * load_error / allowed)**0.4_real64
    allowed = max(area_over_load * tolerance, least_area)
    if (present(least_worth)) allowed = allowed * max(1.0_real64, least_worth(2) / alone(2))
    finest = max(2 * coarse_cells, finest, &
                 (area_told * area_error / allowed)**(2.0_real64 / 3.0_real64))
    needed = int(log(finest / coarse_cells) / log(2.0_real64))
    frame = frame_of(shapes, finest * 0.5_real64**needed)
    total = 0.0_real64
    do
      if (.not. bytes_per_cell * cells_expected(frame, shapes, max(needed, answer%halvings)) < &
          bytes_allowed) then
        answer%failure = 'cells fine enough would need more than 2 GiB of memory'
        return
      end if
      call lay_cells(frame, shapes, answer%halvings, lattice)
      call add_outside(outside, frame, modulus, lattice)
      if (answer%halvings == 0) then
        call start_forces(frame, shapes, lattice)
      else
        call refine_forces(coarse, lattice)
      end if
      call solve_on(influence, lattice, tolerance, interrupt, answer%ending)
      if (.not. answer%ending%converged) then
        answer%failure = 'the pressures on the cells did not converge'
        return
      end if
      call tell(modulus, frame, shapes, lattice, answer)
      before = total
      total = sum(answer%vertical_load)
      if (answer%halvings > 0) answer%change = abs(before - total) / max(total, worth)
      if (answer%change <= tolerance .and. answer%halvings >= needed) exit
      answer%halvings = answer%halvings + 1
      coarse = lattice
    end do
    if (allocated(outside%x)) answer%beside = [(field_of_cells(frame, lattice, outside%x(i), &
                                                               outside%y(i)), i=1, size(outside%x))]
    if (size(shapes) == 1 .and. .not. (allocated(outside%at_nodes) .or. allocated(outside%x))) then
      answer%alone_load = answer%vertical_load
      answer%alone_area = answer%area
      answer%alone_pressure = answer%maximum_pressure
      return
    end if
    do i = 1, size(shapes)
      call solve_alone(modulus, frame, shapes(i:i), tolerance, interrupt, influence, answer)
      if (allocated(answer%failure)) return
    end do
  end subroutine halve_until_settled

  ! A contact by itself, on the same lattice, so that the cells' errors cancel in the ratio.
  subroutine solve_alone(modulus, frame, shape, tolerance, interrupt, influence, answer)
    real(real64), intent(in) :: modulus, tolerance
    type(cell_frame), intent(in) :: frame
    type(gap_shape), intent(in) :: shape(1)
    type(interruption), intent(in) :: interrupt
    type(cell_convolution), allocatable, intent(inout) :: influence
    type(cells_answer), intent(inout) :: answer
    type(cell_frame) :: own
    type(cell_lattice) :: lattice
    type(cells_answer) :: alone

    associate (m => shape(1)%pair)
      own = frame
      own%scale = shape(1)%penetration
      call lay_cells(own, shape, answer%halvings, lattice)
      call start_forces(own, shape, lattice)
      call solve_on(influence, lattice, tolerance, interrupt, alone%ending)
      if (.not. alone%ending%converged) &
        answer%failure = 'the pressures on the cells of a contact alone did not converge'
      call make_room(alone, size(answer%area))
      call tell(modulus, own, shape, lattice, alone)
      answer%alone_load(m) = alone%vertical_load(m)
      answer%alone_area(m) = alone%area(m)
      answer%alone_pressure(m) = alone%maximum_pressure(m)
    end associate
  end subroutine solve_alone

  ! With an influence that was prepared for a lattice that is not much larger, or a new one.
  subroutine solve_on(influence, lattice, tolerance, interrupt, ending)
    type(cell_convolution), allocatable, intent(inout) :: influence
    type(cell_lattice), intent(inout) :: lattice
    real(real64), intent(in) :: tolerance
    type(interruption), intent(in) :: interrupt
    type(solve_ending), intent(out) :: ending
    real(real64), allocatable :: table(:, :)

    if (allocated(influence)) then
      if (.not. influence%serves(shape(lattice%gap))) deallocate (influence)
    end if
    if (.not. allocated(influence)) then
      allocate (influence)
      allocate (table, mold=lattice%gap)
      call influence_table(table)
      call influence%prepare(table / pi)
      deallocate (table)
    end if
    call relax(influence, lattice%gap, max(1.0e-10_real64, inner * tolerance), &
               lattice%force, ending, interrupt)
  end subroutine solve_on

end module asperity_cells_solver
