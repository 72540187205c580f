!> A cluster of contacts resolved on cells, under the field of the contacts outside.
!>
!> The two bodies are one half-space of the combined modulus under a rigid surface, the sum of both
!> profiles; the gap is vertical, also where a pair is inclined. There are no periodic images and no
!> end of the half-space. The cells are as fine as the load and the area call for.
module asperity_cells_solver
  use asperity_cell_convolution, only: cell_convolution
  use asperity_cells_answer, only: area_error, cell_contact, cells_answer, keep_elements, &
                                   load_error, tell
  use asperity_cells_influence, only: mean_influence
  use asperity_cells_lattice, only: box_of, cell_lattice, gap_shape, lay_cells, shape_of_gap
  use asperity_cells_outside, only: add_outside, field_of_cells, outside_field
  use asperity_cells_relax, only: relax
  use asperity_constants, only: pi
  use asperity_contact_pairs, only: contact_pair, contact_pairs
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: not_enough_memory
  use asperity_process, only: has_memory
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: reach_of_cluster, solve_cells

  ! Least cells per radius of the contact that would bear most alone.
  real(real64), parameter :: least_cells = 8.0_real64

  ! Cells in a radius from which on cells know a contact alone, within 5 % (rms).
  real(real64), parameter :: least_alone = 1.0_real64

  ! Place of the lattice in that contact, in cells so often doubled that 4 to 8 are a radius. Any
  ! but a symmetric one: there the errors of many cells at the contact's edge are the same and add
  ! up. Counted in the cells themselves it left 1 area of 389 dense scenes off by 1.25 tolerances.
  real(real64), parameter :: lattice_x = 0.29_real64, lattice_y = 0.13_real64

  ! A lattice is kept as long as its cells are that large, over those called for. Laid anew its load
  ! is off by another error of cells, and rounds of circles and cells would not settle.
  real(real64), parameter :: least_kept = 0.5_real64, most_kept = 1.05_real64

  ! Bytes that may be held, and that are held for each cell.
  real(real64), parameter :: bytes_allowed = 2.0_real64**31, bytes_per_cell = 170.0_real64

  ! A penetration below this, over the radius, is not solved: its squares leave the range.
  real(real64), parameter :: shallowest = 1.0e-120_real64

  ! What is off by no more than its tolerance: an area and so many of its standard deviations; one
  ! and a half of those of a load on cells twice as large, so that halving those changes no more.
  real(real64), parameter :: area_told = 5.0_real64, load_told = 1.5_real64 * 2.0_real64**2.5_real64

  ! The gaps are closed to that times the tolerance, of the penetration. The load is then off by .44
  ! (rms; 1.1 at most) of it: measured on 3 times 130 circles.
  real(real64), parameter :: inner = 0.005_real64

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
  !> Members that touch at the same place share one contact: its load is stored at the first.
  subroutine solve_cells(pairs, members, closing, outside, tolerance, worth, place, answer)
    type(contact_pairs), intent(in) :: pairs       !! the position
    integer, intent(in) :: members(:)              !! places of the contacts in the list of pairs
    real(real64), intent(in) :: closing            !! past first touch
    type(outside_field), intent(in) :: outside     !! of the contacts that are no members
    !> shares of the load that halving may change, and of the area that may be off
    real(real64), intent(in) :: tolerance(2)
    real(real64), intent(in) :: worth(2)           !! load, area: smaller ones count as this
    !> of the lattice: x and y in plan, side of its cells; stays where it does, 0: none yet
    real(real64), intent(inout) :: place(3)
    type(cells_answer), intent(out) :: answer      !! the answer
    type(gap_shape), allocatable :: shapes(:)
    real(real64) :: cell, cells, low(2), high(2)
    integer :: i, k

    allocate (answer%together(size(members)), answer%alone(size(members)))
    answer%together%x = pairs%list(members)%x
    answer%together%y = pairs%list(members)%y
    call find_shapes(pairs, members, closing, shapes)
    if (size(shapes) == 0) then
      answer%ending = solve_ending(.true., 0.0_real64, 0)
      return
    end if
    ! The contact that would bear most alone.
    k = maxloc(shapes%contact_radius * shapes%penetration * shapes%cosine, 1)
    cells = cells_needed(pairs%modulus, shapes, tolerance, worth)
    cell = shapes(k)%contact_radius * shapes(k)%cosine / cells
    cells = 2.0_real64**int(log(cells / 4) / log(2.0_real64))
    if (place(3) < least_kept * cell .or. place(3) > most_kept * cell) &
      place = [shapes(k)%x - lattice_x * cell * cells, shapes(k)%y - lattice_y * cell * cells, cell]
    cell = place(3)
    call box_of(shapes, place(1), place(2), low, high)
    cells = product((high - low) / cell + 2.0_real64)
    if (.not. all(shapes%penetration < level_height(pairs%list(members(shapes%pair))))) then
      answer%failure = 'a penetration reaches the level of the centres'
    else if (.not. maxval(shapes%penetration / shapes%curvature_radius) > shallowest) then
      answer%failure = 'penetrations below the resolution of boundary elements'
    else if (.not. bytes_per_cell * cells < bytes_allowed) then
      answer%failure = 'the boundary elements would need more than 2 GiB of memory'
    else if (.not. has_memory(nint(bytes_per_cell * cells, int64))) then
      answer%failure = not_enough_memory // ' for the boundary elements of a group of contacts'
    else
      call press(shapes, answer%together, outside)
      answer%error = norm2(answer%together%error)
      if (answer%error > 0.0_real64) answer%area_error = area_error * &
        (pi * cell**2 / maxval(answer%together%area))**0.75_real64
      ! Each by itself on the same lattice, so that the errors of cells cancel in the ratio.
      do i = 1, size(shapes)
        if (allocated(answer%failure)) exit
        if (shapes(i)%contact_radius > least_alone * cell) then
          call press(shapes(i:i), answer%alone)
        else
          answer%alone(shapes(i)%pair) = hertz_contact(pairs%modulus, shapes(i))
        end if
      end do
    end if
    if (.not. allocated(answer%failure)) return
    answer%ending%converged = .false.
    if (pairs%interrupt%is_asked()) answer%failure = 'interrupted'

  contains

    ! Solves contacts on their cells, together.
    subroutine press(shapes, contacts, outside)
      type(gap_shape), intent(in) :: shapes(:)
      type(cell_contact), intent(inout) :: contacts(:)
      type(outside_field), intent(in), optional :: outside
      type(cell_lattice) :: lattice
      type(cell_convolution) :: influence
      type(solve_ending) :: ending
      integer :: i

      call lay_cells(shapes, place(1), place(2), cell, lattice)
      if (pairs%interrupt%is_asked()) answer%failure = 'interrupted'
      if (allocated(answer%failure)) return
      if (present(outside)) call add_outside(outside, pairs%modulus, lattice)
      call influence%prepare(mean_influence(size(lattice%gap, 1), size(lattice%gap, 2)))
      if (pairs%interrupt%is_asked()) answer%failure = 'interrupted'
      if (allocated(answer%failure)) return
      call relax(influence, lattice%gap, max(1.0e-10_real64, inner * tolerance(1)), lattice%force, &
                 ending, pairs%interrupt)
      if (.not. ending%converged) &
        answer%failure = 'the pressures on the boundary elements did not converge'
      call tell(pairs%modulus, shapes, lattice, contacts)
      if (.not. present(outside)) return
      answer%cells = size(lattice%force)
      if (associated(pairs%pressures)) &
        call keep_elements(lattice, members(shapes%pair), answer%loaded)
      answer%ending = ending
      if (allocated(outside%x)) answer%beside = [ &
        (field_of_cells(lattice, outside%x(i), outside%y(i)), i=1, size(outside%x))]
    end subroutine press

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

  ! A contact alone as Hertz has it. A sphere's slope curves it more, by 1/cosine across and by its
  ! third power along: the radius of a circle as large as the ellipse.
  pure type(cell_contact) function hertz_contact(modulus, shape) result(contact)
    real(real64), intent(in) :: modulus
    type(gap_shape), intent(in) :: shape

    associate (circle => shape%contact_radius * shape%cosine)
      contact%x = shape%x
      contact%y = shape%y
      contact%load = 4.0_real64 / 3.0_real64 * modulus * circle * shape%penetration
      contact%area = pi * circle**2
      if (circle > 0.0_real64) &
        contact%pressure = 2.0_real64 / pi * modulus * shape%penetration / circle
    end associate
  end function hertz_contact

  ! Cells in a radius of the largest contact, for the load and for the area.
  pure real(real64) function cells_needed(modulus, shapes, tolerance, worth)
    real(real64), intent(in) :: modulus, tolerance(2), worth(2)
    type(gap_shape), intent(in) :: shapes(:)
    real(real64) :: allowed(2)

    ! Over those of Hertz.
    allowed = tolerance * max(1.0_real64, worth / &
      [4.0_real64 / 3.0_real64 * modulus * sum(shapes%contact_radius * shapes%penetration * &
                                               shapes%cosine), pi * sum(shapes%contact_radius**2)])
    cells_needed = max(least_cells, (load_told * load_error / allowed(1))**0.4_real64, &
                       (area_told * area_error / allowed(2))**(2.0_real64 / 3.0_real64))
  end function cells_needed

end module asperity_cells_solver
