!> Points with their values, for ParaView: VTK's XML files of poly data (.vtp) for contacts, and of
!> a structured grid (.vts) for stresses, ASCII.
module asperity_results_vtk
  use asperity_problems, only: decimal_text
  use asperity_result_table, only: array_table, place_of, put_cell
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: write_vtk

contains

  !> A point a row: z is the depth, or 0 without one. An empty cell is `nan`.
  subroutine write_vtk(table, buffer, points)
    type(array_table), intent(in) :: table      !! contacts of a run, or stresses
    type(text_buffer), intent(inout) :: buffer  !! gets the text
    !> numbers of points of a grid along x, y and z, the first changes fastest; absent: no grid
    integer, intent(in), optional :: points(3)
    character(len=:), allocatable :: data_kind, extent
    integer :: depth, i, k, x, y

    x = place_of(table, 'x')
    y = place_of(table, 'y')
    depth = place_of(table, 'depth')
    data_kind = 'PolyData'
    if (present(points)) data_kind = 'StructuredGrid'
    call buffer%line('<?xml version="1.0"?>')
    call buffer%line('<VTKFile type="' // data_kind // '" version="1.0" byte_order="LittleEndian">')
    if (present(points)) then
      extent = 'Extent="0 ' // decimal_text(points(1) - 1) // ' 0 ' // &
               decimal_text(points(2) - 1) // ' 0 ' // decimal_text(points(3) - 1) // '">'
      call buffer%line('<StructuredGrid Whole' // extent)
      call buffer%line('<Piece ' // extent)
    else
      call buffer%line('<PolyData>')
      call buffer%line('<Piece NumberOfPoints="' // decimal_text(table%rows) // &
                       '" NumberOfVerts="' // decimal_text(table%rows) // &
                       '" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="0">')
    end if
    call buffer%line('<Points>')
    call buffer%line('<DataArray type="Float64" NumberOfComponents="3" format="ascii">')
    do i = 1, table%rows
      call put_cell(table%columns(x), i, 'nan', buffer)
      call buffer%append(' ')
      call put_cell(table%columns(y), i, 'nan', buffer)
      call buffer%append(' ')
      if (depth == 0) call buffer%line('0')
      if (depth == 0) cycle
      call put_cell(table%columns(depth), i, 'nan', buffer)
      call buffer%line('')
    end do
    call buffer%line('</DataArray>')
    call buffer%line('</Points>')
    if (.not. present(points)) then
      call buffer%line('<Verts>')
      call put_counts('connectivity', 0)
      call put_counts('offsets', 1)
      call buffer%line('</Verts>')
    end if
    call buffer%line('<PointData>')
    do i = 1, size(table%columns)
      if (any(i == [depth, x, y])) cycle
      call buffer%line('<DataArray type="' // trim(merge('Float64', 'Int32  ', &
                       allocated(table%columns(i)%reals))) // '" Name="' // &
                       table%columns(i)%name // '" format="ascii">')
      do k = 1, table%rows
        call put_cell(table%columns(i), k, 'nan', buffer)
        call buffer%line('')
      end do
      call buffer%line('</DataArray>')
    end do
    call buffer%line('</PointData>')
    call buffer%line('</Piece>')
    call buffer%line('</' // data_kind // '>')
    call buffer%line('</VTKFile>')

  contains

    ! One point a vertex, counted from a first number.
    subroutine put_counts(name, first)
      character(len=*), intent(in) :: name
      integer, intent(in) :: first
      integer :: k

      call buffer%line('<DataArray type="Int32" Name="' // name // '" format="ascii">')
      do k = 1, table%rows
        call buffer%line(decimal_text(k - 1 + first))
      end do
      call buffer%line('</DataArray>')
    end subroutine put_counts

  end subroutine write_vtk

end module asperity_results_vtk
