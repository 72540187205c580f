!> Where pressure can be: square cells on a patch around each contact.
!>
!> Pressure only opens the gap, so that there is none where the undeformed gap is not below zero:
!> outside a disc of radius sqrt(2) times the contact radius. Contacts near each other form a
!> cluster and share one lattice; the lattices of two clusters have nothing to do with each other.
!> A cell where the spheres of several pairs overlap belongs to the pair with the least gap.
module asperity_boundary_patches
  use asperity_boundary_gap, only: gap_at, gap_nowhere, gap_shape
  use asperity_kinds, only: real64
  implicit none
  private

  public :: patch, cell_set, form_clusters, build_cells, expected_cells, near

  !> Patches whose distance is less than this many times the sum of their radii are near: they
  !> share a lattice and act on each other cell by cell.
  real(real64), parameter :: nearness = 2.0_real64

  ! Place of the lattice in a cluster's largest contact, in coarse cells. Any but a symmetric one:
  ! there the errors of many cells at the contact's edge are the same and add up.
  real(real64), parameter :: lattice_x = 0.29_real64, lattice_y = 0.13_real64

  ! Gauss' two places in a cell, from its centre, over its side.
  real(real64), parameter :: gauss = 0.5_real64 / sqrt(3.0_real64)

  !> The cells of one contact: a rectangle of a lattice, not all of whose cells are its own.
  type :: patch
    type(gap_shape) :: shape               !! the contact
    integer :: cluster = 0                 !! contacts of one number share a lattice
    real(real64) :: origin_x = 0.0_real64  !! of the lattice, from the place of first touch
    real(real64) :: origin_y = 0.0_real64  !! of the lattice, from the place of first touch
    real(real64) :: coarse = 0.0_real64    !! side of a cell before any halving
    real(real64) :: cell = 0.0_real64      !! side of a cell
    integer :: left = 0                    !! first column; cell i is from i*cell to (i+1)*cell
    integer :: bottom = 0                  !! first row
    integer :: columns = 0                 !! number of columns
    integer :: rows = 0                    !! number of rows
    integer :: before = 0                  !! cells in the patches before this
    integer :: rows_before = 0             !! rows in the patches before this
  end type patch

  !> All cells, patch after patch, row after row.
  type :: cell_set
    type(patch), allocatable :: patches(:)
    real(real64), allocatable :: gap(:)  !! mean of the undeformed gap; huge where not the patch's
    !> own cells of every row: first and last column, counted from 1 in the patch; none: 1 and 0
    integer, allocatable :: first(:), last(:)
  end type cell_set

contains

  !> Whether two patches are near.
  pure logical function near(a, b)
    type(gap_shape), intent(in) :: a  !! one
    type(gap_shape), intent(in) :: b  !! the other

    near = hypot(a%x - b%x, a%y - b%y) < nearness * (a%reach + b%reach)
  end function near

  !> Puts contacts into clusters and gives every cluster its lattice.
  subroutine form_clusters(shapes, cells_per_radius, patches)
    type(gap_shape), intent(in) :: shapes(:)            !! the contacts
    !> for the contact of a cluster that would bear most alone, across its ellipse
    real(real64), intent(in) :: cells_per_radius
    type(patch), allocatable, intent(out) :: patches(:) !! the contacts with their lattices
    integer, allocatable :: largest(:)
    integer :: i, k, l

    allocate (patches(size(shapes)), largest(size(shapes)))
    do i = 1, size(shapes)
      patches(i)%shape = shapes(i)
      patches(i)%cluster = i
      do k = 1, i - 1
        if (.not. near(shapes(i), shapes(k))) cycle
        if (patches(i)%cluster == patches(k)%cluster) cycle
        l = patches(k)%cluster
        where (patches(:i)%cluster == l) patches(:i)%cluster = patches(i)%cluster
      end do
    end do
    largest = 0
    do i = 1, size(shapes)
      l = patches(i)%cluster
      if (largest(l) == 0) largest(l) = i
      if (size_of(shapes(i)) > size_of(shapes(largest(l)))) largest(l) = i
    end do
    do i = 1, size(shapes)
      k = largest(patches(i)%cluster)
      ! A sphere's slope curves it more: by 1/cosine across, by its third power along.
      patches(i)%coarse = shapes(k)%contact_radius * sqrt(shapes(k)%cosine)**3 / cells_per_radius
      patches(i)%origin_x = (shapes(k)%x - shapes(i)%x) - lattice_x * patches(i)%coarse
      patches(i)%origin_y = (shapes(k)%y - shapes(i)%y) - lattice_y * patches(i)%coarse
    end do
  end subroutine form_clusters

  ! The load of a contact alone, over 4/3 of the modulus.
  pure real(real64) function size_of(shape)
    type(gap_shape), intent(in) :: shape

    size_of = shape%contact_radius * shape%penetration * shape%cosine
  end function size_of

  !> Cells that patches will have, at most, after a number of halvings.
  pure function expected_cells(patches, halvings) result(cells)
    type(patch), intent(in) :: patches(:)  !! with their lattices
    integer, intent(in) :: halvings        !! 0 or more
    real(real64) :: cells
    integer :: i

    cells = 0.0_real64
    do i = 1, size(patches)
      cells = cells + (2.0_real64 * patches(i)%shape%reach / patches(i)%coarse * &
                       2.0_real64**halvings + 2.0_real64)**2
    end do
  end function expected_cells

  !> Lays the cells of patches.
  subroutine build_cells(lattices, halvings, cells)
    type(patch), intent(in) :: lattices(:)  !! contacts with their lattices
    integer, intent(in) :: halvings         !! how often to halve the coarse cell
    type(cell_set), intent(out) :: cells    !! the cells
    integer :: i, number, rows

    allocate (cells%patches(size(lattices)))
    cells%patches = lattices
    number = 0
    rows = 0
    do i = 1, size(lattices)
      associate (p => cells%patches(i))
        p%cell = p%coarse * 0.5_real64**halvings
        call span_of(p%shape%reach, p%origin_x, p%cell, p%left, p%columns)
        call span_of(p%shape%reach, p%origin_y, p%cell, p%bottom, p%rows)
        p%before = number
        p%rows_before = rows
        number = number + p%columns * p%rows
        rows = rows + p%rows
      end associate
    end do
    allocate (cells%gap(number), cells%first(rows), cells%last(rows))
    do i = 1, size(lattices)
      call fill_gaps(cells, i)
    end do
  end subroutine build_cells

  ! Cells of a lattice line that meet -reach..reach.
  pure subroutine span_of(reach, origin, cell, first, number)
    real(real64), intent(in) :: reach, origin, cell
    integer, intent(out) :: first, number

    first = floor((-reach - origin) / cell)
    number = floor((reach - origin) / cell) - first + 1
  end subroutine span_of

  ! Mean gaps of one patch, and which cells are its own.
  subroutine fill_gaps(cells, number)
    type(cell_set), intent(inout) :: cells
    integer, intent(in) :: number
    integer, allocatable :: rivals(:)
    logical :: own
    integer :: i, j, k, at, row
    real(real64) :: mean, apart

    allocate (rivals(0))
    associate (p => cells%patches(number))
      do k = 1, size(cells%patches)
        associate (q => cells%patches(k))
          if (k == number .or. q%cluster /= p%cluster) cycle
          apart = hypot(p%shape%x - q%shape%x, p%shape%y - q%shape%y)
          if (apart < p%shape%reach + q%shape%reach + 3.0_real64 * p%cell) rivals = [rivals, k]
        end associate
      end do
      do j = 1, p%rows
        row = p%rows_before + j
        cells%first(row) = 1
        cells%last(row) = 0
        do i = 1, p%columns
          at = p%before + (j - 1) * p%columns + i
          call judge_cell(cells%patches, number, rivals, p%left + i - 1, p%bottom + j - 1, &
                          own, mean)
          cells%gap(at) = gap_nowhere
          if (.not. own) cycle
          cells%gap(at) = mean
          if (cells%last(row) == 0) cells%first(row) = i
          cells%last(row) = i
        end do
      end do
    end associate
  end subroutine fill_gaps

  ! Mean over a cell of the least gap, and whether the cell is the patch's own: the mean is below
  ! zero, and no rival comes deeper. Four places of Gauss: exact for a cubic.
  subroutine judge_cell(patches, number, rivals, i, j, own, mean)
    type(patch), intent(in) :: patches(:)
    integer, intent(in) :: number, rivals(:), i, j
    logical, intent(out) :: own
    real(real64), intent(out) :: mean
    real(real64) :: least(4), gaps(4)
    integer :: k

    least = gaps_in_cell(patches(number), i, j)
    mean = 0.25_real64 * sum(least)
    own = minval(least) < 0.0_real64
    if (.not. own) return
    do k = 1, size(rivals)
      gaps = gaps_in_cell(patches(rivals(k)), i, j)
      if (rivals(k) < number) then
        own = minval(gaps) > minval(least)
      else
        own = minval(gaps) >= minval(least)
      end if
      if (.not. own) return
    end do
    do k = 1, size(rivals)
      least = min(least, gaps_in_cell(patches(rivals(k)), i, j))
    end do
    mean = 0.25_real64 * sum(least)
    own = mean < 0.0_real64
  end subroutine judge_cell

  pure function gaps_in_cell(p, i, j) result(gaps)
    type(patch), intent(in) :: p
    integer, intent(in) :: i, j
    real(real64) :: gaps(4), x, y, step

    x = p%origin_x + (i + 0.5_real64) * p%cell
    y = p%origin_y + (j + 0.5_real64) * p%cell
    step = gauss * p%cell
    gaps = [gap_at(p%shape, x - step, y - step), gap_at(p%shape, x + step, y - step), &
            gap_at(p%shape, x - step, y + step), gap_at(p%shape, x + step, y + step)]
  end function gaps_in_cell

end module asperity_boundary_patches
