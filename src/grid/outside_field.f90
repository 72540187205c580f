!> Displacement of the elements of a cluster by the contacts outside it.
module asperity_outside_field
  use asperity_element_lattice, only: element_lattice
  use asperity_chebyshev_basis, only: lagrange_at_cells
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  implicit none
  private

  public :: outside_field, add_outside, beside_circle, field_of_elements, outside_at

  !> The field of the contacts outside. Lengths and loads in the units of the pairs.
  type :: outside_field
    real(real64) :: x0 = 0.0_real64               !! rectangle of the nodes, in plan
    real(real64) :: x1 = 0.0_real64               !! more than x0
    real(real64) :: y0 = 0.0_real64               !! rectangle of the nodes, in plan
    real(real64) :: y1 = 0.0_real64               !! more than y0
    !> displacement at the nodes of Chebyshev in x, y; not allocated: none
    real(real64), allocatable :: at_nodes(:, :)
    real(real64), allocatable :: x(:)             !! circles near by: centre; not allocated: none
    real(real64), allocatable :: y(:)             !! centre
    real(real64), allocatable :: radius(:)        !! radius; 0: a force at a point
    real(real64), allocatable :: load(:)          !! under the pressure of Hertz
    integer, allocatable :: pair(:)               !! place in the list of pairs
  end type outside_field

contains

  !> Opens the gaps of a lattice by the displacement at the centres of its elements.
  subroutine add_outside(outside, modulus, lattice)
    type(outside_field), intent(in) :: outside      !! field of the contacts outside
    real(real64), intent(in) :: modulus             !! combined modulus, > 0
    type(element_lattice), intent(inout) :: lattice  !! gets its gaps changed
    real(real64) :: x, y
    integer :: i, j

    x = lattice%x + lattice%left * lattice%side
    y = lattice%y + lattice%bottom * lattice%side
    if (allocated(outside%at_nodes)) lattice%gap = lattice%gap + between_nodes( &
      outside, x, y, lattice%side, shape(lattice%gap)) / lattice%depth
    if (.not. allocated(outside%x)) return
    do j = 1, size(lattice%gap, 2)
      do i = 1, size(lattice%gap, 1)
        if (lattice%owner(i, j) == 0) cycle
        lattice%gap(i, j) = lattice%gap(i, j) + sum(outside%load * beside_circle(outside%radius, &
          hypot(x + (i - 0.5_real64) * lattice%side - outside%x, &
                y + (j - 0.5_real64) * lattice%side - outside%y))) / (modulus * lattice%depth)
      end do
    end do
  end subroutine add_outside

  !> Displacement by the contacts outside at a place.
  pure real(real64) function outside_at(outside, modulus, x, y) result(field)
    type(outside_field), intent(in) :: outside      !! field of the contacts outside
    real(real64), intent(in) :: modulus             !! combined modulus, > 0
    real(real64), intent(in) :: x, y                !! the place, in plan

    field = 0.0_real64
    if (allocated(outside%at_nodes)) field = sum(between_nodes(outside, x, y, 0.0_real64, [1, 1]))
    if (allocated(outside%x)) field = field + sum(outside%load * &
      beside_circle(outside%radius, hypot(x - outside%x, y - outside%y))) / modulus
  end function outside_at

  ! Field interpolated between the nodes at the centres of columns and rows of elements.
  pure function between_nodes(outside, x, y, side, sizes) result(field)
    type(outside_field), intent(in) :: outside
    real(real64), intent(in) :: x, y, side    ! corner and side of the first element
    integer, intent(in) :: sizes(2)           ! number of columns and rows
    real(real64) :: field(sizes(1), sizes(2))

    associate (wide => 0.5_real64 * (outside%x1 - outside%x0), &
               high => 0.5_real64 * (outside%y1 - outside%y0))
      field = matmul(transpose(lagrange_at_cells( &
        size(outside%at_nodes, 1), sizes(1), (x - outside%x0) / wide - 1.0_real64, side / wide)), &
        matmul(outside%at_nodes, lagrange_at_cells( &
        size(outside%at_nodes, 2), sizes(2), (y - outside%y0) / high - 1.0_real64, side / high)))
    end associate
  end function between_nodes

  !> Displacement by the elements at a place outside them.
  elemental real(real64) function field_of_elements(lattice, x, y) result(field)
    type(element_lattice), intent(in) :: lattice       !! elements with their forces
    real(real64), intent(in) :: x, y                !! the place, in plan
    real(real64) :: across, along
    integer :: i, j

    field = 0.0_real64
    along = (y - lattice%y) / lattice%side - lattice%bottom
    across = (x - lattice%x) / lattice%side - lattice%left
    do j = 1, size(lattice%force, 2)
      do i = 1, size(lattice%force, 1)
        if (lattice%force(i, j) > 0.0_real64) field = field + lattice%force(i, j) / &
          hypot(across - i + 0.5_real64, along - j + 0.5_real64)
      end do
    end do
    field = lattice%depth * field / pi
  end function field_of_elements

  !> Displacement times modulus over load at a distance from the centre of a circle under the
  !> pressure of Hertz (Johnson, Contact Mechanics, 1985, eq. 3.41a and 3.42a).
  elemental real(real64) function beside_circle(a, r) result(u)
    real(real64), intent(in) :: a  !! radius, 0 or more; one of both more than 0
    real(real64), intent(in) :: r  !! distance from its centre

    if (r <= a) then
      u = 0.375_real64 * (2.0_real64 - (r / a)**2) / a
    else if (r > 100.0_real64 * a) then
      ! There the closed form loses ten digits, and the series' next term is 4e-10.
      u = (1.0_real64 + 0.1_real64 * (a / r)**2) / (pi * r)
    else
      u = 0.75_real64 / (pi * a) * ((2.0_real64 - (r / a)**2) * asin(a / r) + &
                                    sqrt((r / a)**2 - 1.0_real64))
    end if
  end function beside_circle

end module asperity_outside_field
