!> How patches far from each other press each other down.
!>
!> Forces on the cells of a patch are replaced by forces at a few Chebyshev nodes, the
!> displacement is found at the nodes of the other patch and interpolated to its cells. The number
!> of nodes follows from the distance (Trefethen, Approximation Theory and Approximation Practice,
!> 2013, theorem 8.2: the error falls as rho**-n, rho from the nearest pole). Both ways use the
!> same numbers, so that the equations stay symmetric.
module asperity_boundary_far
  use asperity_boundary_patches, only: cell_set, near, patch
  use asperity_chebyshev_basis, only: chebyshev_nodes, lagrange_at_cells
  use asperity_kinds, only: real64
  implicit none
  private

  public :: far_coupling, couple_far_patches, add_far_displacement, far_memory

  ! Nodes in each direction that can be chosen.
  integer, parameter :: orders(4) = [3, 5, 8, 12]

  ! Error allowed in the displacement, over the penetration of a contact of the source's size.
  real(real64), parameter :: error_allowed = 1.0e-6_real64

  !> Far pairs of patches.
  type :: far_coupling
    private
    integer, allocatable :: one(:)           ! of a pair: place in the list of patches
    integer, allocatable :: other(:)
    integer, allocatable :: choice(:)        ! place of its number of nodes in `orders`
    integer, allocatable :: before(:)        ! numbers in `kernel` before its own
    real(real64), allocatable :: kernel(:)   ! 1/r from node to node
    integer, allocatable :: basis(:, :)      ! numbers in `values` before a patch's own; -1: none
    integer, allocatable :: nodes(:, :)      ! nodes before a patch's own
    real(real64), allocatable :: values(:)   ! Lagrange's polynomials at columns, then at rows
    integer :: all_nodes = 0
  end type far_coupling

contains

  !> Doubles that the coupling of patches will hold.
  pure function far_memory(patches) result(doubles)
    type(patch), intent(in) :: patches(:)  !! patches
    real(real64) :: doubles
    integer :: i, k

    doubles = 0.0_real64
    do i = 2, size(patches)
      do k = 1, i - 1
        if (near(patches(i)%shape, patches(k)%shape)) cycle
        doubles = doubles + real(orders(choice_of(patches(i), patches(k))), real64)**4
      end do
    end do
  end function far_memory

  !> Prepares the coupling of all patches that are not near each other.
  subroutine couple_far_patches(cells, far)
    type(cell_set), intent(in) :: cells      !! the cells
    type(far_coupling), intent(out) :: far   !! their coupling
    integer :: i, k, c, pairs, numbers

    associate (p => cells%patches)
      pairs = 0
      do i = 2, size(p)
        do k = 1, i - 1
          if (.not. near(p(i)%shape, p(k)%shape)) pairs = pairs + 1
        end do
      end do
      allocate (far%one(pairs), far%other(pairs), far%choice(pairs), far%before(pairs))
      allocate (far%basis(size(orders), size(p)), far%nodes(size(orders), size(p)))
      far%basis = -1
      far%nodes = -1
      pairs = 0
      numbers = 0
      do i = 2, size(p)
        do k = 1, i - 1
          if (near(p(i)%shape, p(k)%shape)) cycle
          c = choice_of(p(i), p(k))
          pairs = pairs + 1
          far%one(pairs) = i
          far%other(pairs) = k
          far%choice(pairs) = c
          far%before(pairs) = numbers
          numbers = numbers + orders(c)**4
          far%basis(c, [i, k]) = 0
        end do
      end do
      allocate (far%kernel(numbers))
      do i = 1, pairs
        call fill_kernel(p(far%one(i)), p(far%other(i)), orders(far%choice(i)), &
                         far%kernel(far%before(i) + 1:))
      end do
      numbers = 0
      do i = 1, size(p)
        do c = 1, size(orders)
          if (far%basis(c, i) < 0) cycle
          far%basis(c, i) = numbers
          far%nodes(c, i) = far%all_nodes
          numbers = numbers + orders(c) * (p(i)%columns + p(i)%rows)
          far%all_nodes = far%all_nodes + orders(c)**2
        end do
      end do
      allocate (far%values(numbers))
      do i = 1, size(p)
        do c = 1, size(orders)
          k = far%basis(c, i)
          if (k < 0) cycle
          call lagrange_at_cells(orders(c), p(i)%columns, &
                                 (p(i)%origin_x + p(i)%left * p(i)%cell) / p(i)%shape%reach, &
                                 p(i)%cell / p(i)%shape%reach, far%values(k + 1:))
          k = k + orders(c) * p(i)%columns
          call lagrange_at_cells(orders(c), p(i)%rows, &
                                 (p(i)%origin_y + p(i)%bottom * p(i)%cell) / p(i)%shape%reach, &
                                 p(i)%cell / p(i)%shape%reach, far%values(k + 1:))
        end do
      end do
    end associate
  end subroutine couple_far_patches

  ! Fewest nodes that will do.
  pure integer function choice_of(p, q)
    type(patch), intent(in) :: p, q
    real(real64) :: apart, pole, rho, field
    integer :: c

    apart = hypot(p%shape%x - q%shape%x, p%shape%y - q%shape%y)
    pole = min((apart - p%shape%reach) / q%shape%reach, (apart - q%shape%reach) / p%shape%reach)
    rho = pole + sqrt(pole * pole - 1.0_real64)
    ! A Hertz contact presses a far place down by 4/(3 pi) a/r of its own penetration.
    field = max(p%shape%contact_radius, q%shape%contact_radius) / apart
    choice_of = size(orders)
    do c = size(orders) - 1, 1, -1
      if (field * rho**(-orders(c)) > error_allowed) exit
      choice_of = c
    end do
  end function choice_of

  ! 1/r between nodes, with what the spread of the forces over cells and the mean over the
  ! receiving cells add: h**2/24 times the Laplacian each, 1/r**3.
  pure subroutine fill_kernel(p, q, n, kernel)
    type(patch), intent(in) :: p, q
    integer, intent(in) :: n
    real(real64), intent(inout) :: kernel(:)
    real(real64) :: node(n), x, y, spread, r2
    integer :: i, j, k, l, at

    node = chebyshev_nodes(n)
    spread = (p%cell**2 + q%cell**2) / 24.0_real64
    at = 0
    do l = 1, n
      do k = 1, n
        do j = 1, n
          do i = 1, n
            x = (p%shape%x - q%shape%x) + (node(i) * p%shape%reach - node(k) * q%shape%reach)
            y = (p%shape%y - q%shape%y) + (node(j) * p%shape%reach - node(l) * q%shape%reach)
            r2 = x * x + y * y
            at = at + 1
            kernel(at) = (1.0_real64 + spread / r2) / sqrt(r2)
          end do
        end do
      end do
    end do
  end subroutine fill_kernel

  !> Adds to every cell the displacement times pi E that far forces cause.
  subroutine add_far_displacement(far, cells, force, displacement)
    type(far_coupling), intent(in) :: far            !! the coupling
    type(cell_set), intent(in) :: cells              !! the cells it was prepared for
    real(real64), intent(in) :: force(:)             !! of every cell
    real(real64), intent(inout) :: displacement(:)   !! of every cell, mean over it
    real(real64), allocatable :: moment(:), field(:)
    integer :: i, c, n, a, b

    if (far%all_nodes == 0) return
    allocate (moment(far%all_nodes), field(far%all_nodes))
    do i = 1, size(cells%patches)
      do c = 1, size(orders)
        if (far%basis(c, i) < 0) cycle
        associate (p => cells%patches(i), n => orders(c))
          call gather(p%columns, p%rows, n, force(p%before + 1:p%before + p%columns * p%rows), &
                      far%values(far%basis(c, i) + 1:), &
                      moment(far%nodes(c, i) + 1:far%nodes(c, i) + n * n))
        end associate
      end do
    end do
    field = 0.0_real64
    do i = 1, size(far%one)
      c = far%choice(i)
      n = orders(c)**2
      a = far%nodes(c, far%one(i))
      b = far%nodes(c, far%other(i))
      call exchange(n, far%kernel(far%before(i) + 1:far%before(i) + n * n), &
                    moment(a + 1:a + n), moment(b + 1:b + n), field(a + 1:a + n), &
                    field(b + 1:b + n))
    end do
    do i = 1, size(cells%patches)
      do c = 1, size(orders)
        if (far%basis(c, i) < 0) cycle
        associate (p => cells%patches(i), n => orders(c))
          call spread_out(p%columns, p%rows, n, field(far%nodes(c, i) + 1:), &
                          far%values(far%basis(c, i) + 1:), &
                          displacement(p%before + 1:p%before + p%columns * p%rows))
        end associate
      end do
    end do
  end subroutine add_far_displacement

  pure subroutine exchange(n, kernel, moment_a, moment_b, field_a, field_b)
    integer, intent(in) :: n
    real(real64), intent(in) :: kernel(n, n), moment_a(n), moment_b(n)
    real(real64), intent(inout) :: field_a(n), field_b(n)
    integer :: k

    do k = 1, n
      field_a = field_a + moment_b(k) * kernel(:, k)
      field_b(k) = field_b(k) + dot_product(kernel(:, k), moment_a)
    end do
  end subroutine exchange

  pure subroutine gather(columns, rows, n, force, values, moment)
    integer, intent(in) :: columns, rows, n
    real(real64), intent(in) :: force(columns, rows), values(n, columns + rows)
    real(real64), intent(out) :: moment(n, n)
    real(real64) :: line(n)
    integer :: i, j, k

    moment = 0.0_real64
    do j = 1, rows
      line = 0.0_real64
      do i = 1, columns
        line = line + force(i, j) * values(:, i)
      end do
      do k = 1, n
        moment(:, k) = moment(:, k) + values(k, columns + j) * line
      end do
    end do
  end subroutine gather

  pure subroutine spread_out(columns, rows, n, field, values, displacement)
    integer, intent(in) :: columns, rows, n
    real(real64), intent(in) :: field(n, n), values(n, columns + rows)
    real(real64), intent(inout) :: displacement(columns, rows)
    real(real64) :: line(n)
    integer :: i, j

    do j = 1, rows
      line = matmul(field, values(:, columns + j))
      do i = 1, columns
        displacement(i, j) = displacement(i, j) + dot_product(line, values(:, i))
      end do
    end do
  end subroutine spread_out

end module asperity_boundary_far
