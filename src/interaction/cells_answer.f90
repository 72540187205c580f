!> What the pressures on the cells of a cluster mean for its contacts.
module asperity_cells_answer
  use asperity_cells_gap, only: gap_shape
  use asperity_cells_lattice, only: cell_frame, cell_lattice
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  use asperity_solve_ending, only: solve_ending
  implicit none
  private

  public :: cells_answer, make_room, tell

  ! Cells over-count an area by that times the sides on their rim: measured on Hertz contacts, .032
  ! to .038 from 27 to 3.4 cells per radius, means over 64 places of the lattice. (Where pressures
  ! stand at points it is .118: Yastrebov, Anciaux and Molinari, Tribol. Int. 114 (2017) 161-171.)
  ! What is left scatters by 1 %, .25 % and .12 % of the area at 7, 13 and 27 cells per radius.
  real(real64), parameter :: rim = 1.0_real64 / 30.0_real64

  ! Root mean square of the relative error of a Hertz load on cells, this over n**2.5 with n cells
  ! in a radius: 3.0e-3, 5.3e-4, 9.7e-5, 1.3e-5 at 3, 6, 12, 24 (20 to 130 places of the lattice).
  real(real64), parameter :: load_error = 0.047_real64

  !> What the cells answer, by member. Loads, lengths and pressures in the units of the pairs.
  type :: cells_answer
    real(real64), allocatable :: vertical_load(:)     !! all members together
    real(real64), allocatable :: alone_load(:)        !! of each alone, nothing outside, same cells
    real(real64), allocatable :: area(:)              !! in plan, corrected at the rim
    real(real64), allocatable :: alone_area(:)        !! the same of each alone
    real(real64), allocatable :: maximum_pressure(:)  !! mean over a cell
    real(real64), allocatable :: alone_pressure(:)    !! the same of each alone
    real(real64), allocatable :: centre_x(:)          !! of its pressure; unloaded: first touch
    real(real64), allocatable :: centre_y(:)          !! of its pressure; unloaded: first touch
    integer :: cells = 0                              !! of the finest lattice
    integer :: halvings = 0                           !! of the cells, from the coarsest
    !> of the pressure, mean of xx, xy, yy about its centre (quantity, member)
    real(real64), allocatable :: spread(:, :)
    real(real64) :: error = 0.0_real64                !! of the load by the cells, root mean square
    real(real64) :: change = huge(1.0_real64)         !! relative, of the load by the last halving
    !> of the solve on the finest lattice; residual: largest violation of the gap over the deepest
    !> penetration
    type(solve_ending) :: ending
    character(:), allocatable :: failure              !! why it did not converge
  end type cells_answer

contains

  !> Makes room for the members of a cluster.
  pure subroutine make_room(answer, members)
    type(cells_answer), intent(inout) :: answer  !! zero for all
    integer, intent(in) :: members               !! how many
    real(real64) :: zero(members)

    zero = 0.0_real64
    allocate (answer%vertical_load, answer%alone_load, answer%area, answer%alone_area, &
              answer%maximum_pressure, answer%alone_pressure, answer%centre_x, answer%centre_y, &
              source=zero)
    allocate (answer%spread(3, members), source=0.0_real64)
  end subroutine make_room

  !> What the forces of a lattice mean for every contact, and all area taken off at the rim.
  subroutine tell(modulus, frame, shapes, lattice, answer, off)
    real(real64), intent(in) :: modulus             !! combined
    type(cell_frame), intent(in) :: frame           !! of the cluster
    type(gap_shape), intent(in) :: shapes(:)        !! the contacts that penetrate
    type(cell_lattice), intent(in) :: lattice       !! solved
    type(cells_answer), intent(inout) :: answer     !! gets what is of these contacts
    real(real64), intent(out) :: off                !! that area
    ! Of force: sum, means of x, y, then of xx, xy, yy; places in cells from first touch.
    real(real64) :: moment(6, size(shapes)), highest(size(shapes)), x, y
    integer :: cells(size(shapes)), sides(size(shapes)), i, j, k

    moment = 0.0_real64
    highest = 0.0_real64
    cells = 0
    sides = 0
    do j = 1, size(lattice%force, 2)
      do i = 1, size(lattice%force, 1)
        associate (force => lattice%force(i, j))
          if (.not. force > 0.0_real64) cycle
          k = lattice%owner(i, j)
          x = lattice%left + i - 0.5_real64 + &
              (frame%x - shapes(k)%x + lattice%origin_x) / lattice%cell
          y = lattice%bottom + j - 0.5_real64 + &
              (frame%y - shapes(k)%y + lattice%origin_y) / lattice%cell
          moment(:, k) = moment(:, k) + force * [1.0_real64, x, y, x * x, x * y, y * y]
          highest(k) = max(highest(k), force)
          cells(k) = cells(k) + 1
          sides(k) = sides(k) + count([unloaded(i - 1, j), unloaded(i + 1, j), &
                                       unloaded(i, j - 1), unloaded(i, j + 1)])
        end associate
      end do
    end do
    off = lattice%cell**2 * rim * sum(sides)
    answer%cells = size(lattice%force)
    answer%error = 0.0_real64
    do k = 1, size(shapes)
      if (cells(k) == 0) cycle
      associate (m => shapes(k)%pair, load => moment(1, k), h => lattice%cell, &
                 radius => sqrt(cells(k) / pi))
        moment(2:, k) = moment(2:, k) / load
        x = moment(2, k)
        y = moment(3, k)
        answer%vertical_load(m) = modulus * frame%scale * h * load
        answer%maximum_pressure(m) = modulus * (frame%scale / h) * highest(k)
        answer%area(m) = h**2 * (cells(k) - rim * sides(k))
        answer%centre_x(m) = shapes(k)%x + h * x
        answer%centre_y(m) = shapes(k)%y + h * y
        ! A cell has its own spread.
        answer%spread(:, m) = h**2 * (moment(4:, k) - [x * x, x * y, y * y] + &
                                      [1.0_real64, 0.0_real64, 1.0_real64] / 12)
        answer%error = hypot(answer%error, answer%vertical_load(m) * &
                             load_error * min(1.0_real64, radius**(-2.5_real64)) * &
                             min(1.0_real64, sides(k) / (8 * radius)))
      end associate
    end do

  contains

    pure logical function unloaded(i, j)
      integer, intent(in) :: i, j

      unloaded = .true.
      if (i < 1 .or. j < 1 .or. i > size(lattice%force, 1) .or. j > size(lattice%force, 2)) return
      unloaded = .not. lattice%force(i, j) > 0.0_real64
    end function unloaded

  end subroutine tell

end module asperity_cells_answer
