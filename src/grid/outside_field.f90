!> Displacement of the elements of a cluster by the contacts outside it.
module asperity_outside_field
  use asperity_element_lattice, only: element_lattice
  use asperity_chebyshev_basis, only: lagrange_at_cells
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  implicit none
  private

  public :: outside_field, add_outside_field, circle_displacement, element_displacement, &
            outside_displacement

  !> Displacement of a cluster by the contacts outside it: that of far ones interpolated between
  !> nodes, that of near ones as circles. Lengths and loads in the units of the pairs.
  type :: outside_field
    real(real64) :: x0 = 0.0_real64               !! lower limit of the nodes in x
    real(real64) :: x1 = 0.0_real64               !! upper limit of the nodes in x, > x0
    real(real64) :: y0 = 0.0_real64               !! lower limit of the nodes in y
    real(real64) :: y1 = 0.0_real64               !! upper limit of the nodes in y, > y0
    !> displacement at the Chebyshev nodes (x, y); not allocated: no far contacts
    real(real64), allocatable :: node_displacement(:, :)
    real(real64), allocatable :: x(:)             !! centres of near circles; not allocated: none
    real(real64), allocatable :: y(:)             !! centres of near circles
    real(real64), allocatable :: radius(:)        !! their radii; 0: force at a point
    real(real64), allocatable :: load(:)          !! their loads, as the pressure of Hertz
    integer, allocatable :: pair(:)               !! their indices in the list of pairs
  end type outside_field

contains

  !> Adds the displacement at the centres of the elements of a lattice to their gaps.
  subroutine add_outside_field(outside, modulus, lattice)
    type(outside_field), intent(in) :: outside      !! field of the contacts outside
    real(real64), intent(in) :: modulus             !! combined modulus, > 0
    type(element_lattice), intent(inout) :: lattice  !! lattice; its gaps increase
    real(real64) :: x, y
    integer :: i, j

    x = lattice%x + lattice%left * lattice%side
    y = lattice%y + lattice%bottom * lattice%side
    if (allocated(outside%node_displacement)) lattice%gap = lattice%gap + interpolated_field( &
      outside, x, y, lattice%side, shape(lattice%gap)) / lattice%depth
    if (.not. allocated(outside%x)) return
    do j = 1, size(lattice%gap, 2)
      do i = 1, size(lattice%gap, 1)
        if (lattice%owner(i, j) == 0) cycle
        lattice%gap(i, j) = lattice%gap(i, j) + sum(outside%load * circle_displacement( &
          outside%radius, &
          hypot(x + (i - 0.5_real64) * lattice%side - outside%x, &
                y + (j - 0.5_real64) * lattice%side - outside%y))) / (modulus * lattice%depth)
      end do
    end do
  end subroutine add_outside_field

  !> Displacement by the contacts outside at a position.
  pure real(real64) function outside_displacement(outside, modulus, x, y) result(field)
    type(outside_field), intent(in) :: outside      !! field of the contacts outside
    real(real64), intent(in) :: modulus             !! combined modulus, > 0
    real(real64), intent(in) :: x, y                !! position in plan

    field = 0.0_real64
    if (allocated(outside%node_displacement)) &
      field = sum(interpolated_field(outside, x, y, 0.0_real64, [1, 1]))
    if (allocated(outside%x)) field = field + sum(outside%load * &
      circle_displacement(outside%radius, hypot(x - outside%x, y - outside%y))) / modulus
  end function outside_displacement

  ! Displacement at the centres of columns and rows of elements, interpolated between the nodes.
  pure function interpolated_field(outside, x, y, side, counts) result(field)
    type(outside_field), intent(in) :: outside
    real(real64), intent(in) :: x, y, side    ! corner and side of the first element
    integer, intent(in) :: counts(2)          ! number of columns and rows
    real(real64) :: field(counts(1), counts(2))

    associate (half_width_x => 0.5_real64 * (outside%x1 - outside%x0), &
               half_width_y => 0.5_real64 * (outside%y1 - outside%y0))
      field = matmul(transpose(lagrange_at_cells( &
        size(outside%node_displacement, 1), counts(1), &
        (x - outside%x0) / half_width_x - 1.0_real64, side / half_width_x)), &
        matmul(outside%node_displacement, lagrange_at_cells( &
        size(outside%node_displacement, 2), counts(2), &
        (y - outside%y0) / half_width_y - 1.0_real64, side / half_width_y)))
    end associate
  end function interpolated_field

  !> Displacement by the elements at a position outside them, by a force at each centre.
  elemental real(real64) function element_displacement(lattice, x, y) result(field)
    type(element_lattice), intent(in) :: lattice    !! elements with their forces
    real(real64), intent(in) :: x, y                !! position in plan
    real(real64) :: column_offset, row_offset
    integer :: i, j

    field = 0.0_real64
    row_offset = (y - lattice%y) / lattice%side - lattice%bottom
    column_offset = (x - lattice%x) / lattice%side - lattice%left
    do j = 1, size(lattice%force, 2)
      do i = 1, size(lattice%force, 1)
        if (lattice%force(i, j) > 0.0_real64) field = field + lattice%force(i, j) / &
          hypot(column_offset - i + 0.5_real64, row_offset - j + 0.5_real64)
      end do
    end do
    field = lattice%depth * field / pi
  end function element_displacement

  !> Displacement times modulus over load at a distance from the centre of a Hertzian contact
  !> (Johnson, Contact Mechanics, 1985, eq. 3.41a and 3.42a).
  elemental real(real64) function circle_displacement(a, r) result(u)
    real(real64), intent(in) :: a  !! radius of the contact, >= 0; a + r > 0
    real(real64), intent(in) :: r  !! distance from its centre

    if (r <= a) then
      u = 0.375_real64 * (2.0_real64 - (r / a)**2) / a
    else if (r > 100.0_real64 * a) then
      ! The closed form would lose ten digits; the next term of the series is 4e-10.
      u = (1.0_real64 + 0.1_real64 * (a / r)**2) / (pi * r)
    else
      u = 0.75_real64 / (pi * a) * ((2.0_real64 - (r / a)**2) * asin(a / r) + &
                                    sqrt((r / a)**2 - 1.0_real64))
    end if
  end function circle_displacement

end module asperity_outside_field
