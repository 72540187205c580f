!> The displacement that forces on cells cause.
!>
!> Within a lattice the influence depends on the offset of two cells only. So rows act on rows
!> through one table, and no matrix is held. Patches far from each other act through a few nodes.
module asperity_boundary_products
  use asperity_boundary_far, only: add_far_displacement, couple_far_patches, far_coupling
  use asperity_boundary_influence, only: influence_table
  use asperity_boundary_patches, only: build_cells, cell_set, near, patch
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  implicit none
  private

  public :: half_space, prepare_half_space, displace, expected_work, table_reach

  !> Cells and all that is needed to find their displacement.
  type :: half_space
    type(cell_set) :: cells                      !! the cells
    real(real64), allocatable :: table(:, :)     !! influence by offset, lower bounds -reach and 0
    type(far_coupling) :: far                    !! between far patches
    integer, allocatable :: target(:)            !! of two near patches, each with itself too
    integer, allocatable :: source(:)            !! of two near patches
  end type half_space

contains

  !> Lays the cells of patches and prepares their coupling.
  subroutine prepare_half_space(lattices, halvings, space)
    type(patch), intent(in) :: lattices(:)   !! contacts with their lattices
    integer, intent(in) :: halvings          !! how often to halve the coarse cell
    type(half_space), intent(out) :: space   !! ready for `displace`
    integer :: i, k, pairs, round

    call build_cells(lattices, halvings, space%cells)
    call couple_far_patches(space%cells, space%far)
    call influence_table(table_reach(space%cells%patches), space%table)
    do round = 1, 2
      pairs = 0
      do i = 1, size(lattices)
        do k = 1, size(lattices)
          if (k /= i) then
            if (.not. near(lattices(i)%shape, lattices(k)%shape)) cycle
          end if
          pairs = pairs + 1
          if (round == 1) cycle
          space%target(pairs) = i
          space%source(pairs) = k
        end do
      end do
      if (round == 1) allocate (space%target(pairs), space%source(pairs))
    end do
  end subroutine prepare_half_space

  !> Largest offset, in cells, between two near patches.
  pure integer function table_reach(patches)
    type(patch), intent(in) :: patches(:)  !! patches with their cells
    integer :: i, k

    table_reach = 0
    do i = 1, size(patches)
      do k = 1, i
        if (k < i) then
          if (.not. near(patches(i)%shape, patches(k)%shape)) cycle
        end if
        associate (p => patches(i), q => patches(k))
          table_reach = max(table_reach, p%left + p%columns - q%left, q%left + q%columns - p%left, &
                            p%bottom + p%rows - q%bottom, q%bottom + q%rows - p%bottom)
        end associate
      end do
    end do
  end function table_reach

  !> Multiplications in one call of `displace` after a number of halvings, about.
  pure function expected_work(patches, halvings) result(work)
    type(patch), intent(in) :: patches(:)  !! with their lattices
    integer, intent(in) :: halvings        !! 0 or more
    real(real64) :: work, cells(size(patches))
    integer :: i, k

    do i = 1, size(patches)
      cells(i) = pi * (patches(i)%shape%cosine * patches(i)%shape%reach / patches(i)%coarse * &
                       2.0_real64**halvings)**2
    end do
    work = 0.5_real64 * sum(cells**2)
    do i = 2, size(patches)
      do k = 1, i - 1
        if (near(patches(i)%shape, patches(k)%shape)) work = work + cells(i) * cells(k)
      end do
    end do
  end function expected_work

  !> Mean displacement of every cell times the modulus; without meaning where a cell is not its
  !> patch's own.
  subroutine displace(space, force, displacement)
    type(half_space), intent(in) :: space           !! cells and their coupling
    real(real64), intent(in) :: force(:)            !! on every cell; 0 where not the patch's own
    real(real64), intent(out) :: displacement(:)    !! of every cell
    integer, allocatable :: first(:), last(:)
    integer :: i, reach

    displacement = 0.0_real64
    call loaded_spans(space%cells, force, first, last)
    reach = ubound(space%table, 2)
    do i = 1, size(space%target)
      associate (t => space%cells%patches(space%target(i)), &
                 s => space%cells%patches(space%source(i)))
        call add_patch(t, s, reach, space%table, force, first, last, space%cells%first, &
                       space%cells%last, displacement)
      end associate
    end do
    ! Until here mean(1/r) was over the side of the cell.
    do i = 1, size(space%cells%patches)
      associate (p => space%cells%patches(i))
        displacement(p%before + 1:p%before + p%columns * p%rows) = &
          displacement(p%before + 1:p%before + p%columns * p%rows) / p%cell
      end associate
    end do
    call add_far_displacement(space%far, space%cells, force, displacement)
    displacement = displacement / pi
  end subroutine displace

  ! First and last cell of every row that carries a force; 1 and 0: none.
  subroutine loaded_spans(cells, force, first, last)
    type(cell_set), intent(in) :: cells
    real(real64), intent(in) :: force(:)
    integer, allocatable, intent(out) :: first(:), last(:)
    integer :: i, j, k, row, at

    allocate (first(size(cells%first)), last(size(cells%first)))
    first = 1
    last = 0
    do k = 1, size(cells%patches)
      associate (p => cells%patches(k))
        do j = 1, p%rows
          row = p%rows_before + j
          at = p%before + (j - 1) * p%columns
          do i = cells%first(row), cells%last(row)
            if (.not. abs(force(at + i)) > 0.0_real64) cycle
            if (last(row) == 0) first(row) = i
            last(row) = i
          end do
        end do
      end associate
    end do
  end subroutine loaded_spans

  ! What one patch's forces do to another of the same lattice, or to itself.
  pure subroutine add_patch(t, s, reach, table, force, first, last, own_first, own_last, &
                            displacement)
    type(patch), intent(in) :: t, s
    integer, intent(in) :: reach
    real(real64), intent(in) :: table(-reach:reach, 0:reach), force(:)
    integer, intent(in) :: first(:), last(:)          ! loaded cells of every row
    integer, intent(in) :: own_first(:), own_last(:)  ! cells to be displaced
    real(real64), intent(inout) :: displacement(:)
    integer :: i, j, row, other, n, m, at, from, offset, up

    do j = 1, t%rows
      row = t%rows_before + j
      n = own_last(row) - own_first(row) + 1
      if (n < 1) cycle
      at = t%before + (j - 1) * t%columns + own_first(row) - 1
      do i = 1, s%rows
        other = s%rows_before + i
        m = last(other) - first(other) + 1
        if (m < 1) cycle
        from = s%before + (i - 1) * s%columns + first(other) - 1
        up = abs((t%bottom + j) - (s%bottom + i))
        ! From the last source to the first target.
        offset = (t%left + own_first(row)) - (s%left + last(other))
        call add_row(n, m, force(from + 1:from + m), table(offset:offset + n + m - 2, up), &
                     displacement(at + 1:at + n))
      end do
    end do
  end subroutine add_patch

  ! One row on another. Four sources at a time: so each target is fetched and stored once for
  ! four products.
  pure subroutine add_row(n, m, force, table, displacement)
    integer, intent(in) :: n, m
    real(real64), intent(in) :: force(m), table(n + m - 1)
    real(real64), intent(inout) :: displacement(n)
    integer :: i, k, l

    do k = 1, m - 3, 4
      l = m - k
      do i = 1, n
        displacement(i) = displacement(i) + &
          ((force(k) * table(i + l) + force(k + 1) * table(i + l - 1)) + &
           (force(k + 2) * table(i + l - 2) + force(k + 3) * table(i + l - 3)))
      end do
    end do
    do k = m - modulo(m, 4) + 1, m
      l = m - k
      do i = 1, n
        displacement(i) = displacement(i) + force(k) * table(i + l)
      end do
    end do
  end subroutine add_row

end module asperity_boundary_products
