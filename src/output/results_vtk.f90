!> Files for ParaView, in the XML of VTK. Stresses: a structured grid (.vts), ASCII. A contact
!> field: image data (.vti), values of cells, appended as raw bytes.
module asperity_results_vtk
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_c_binding, only: c_int
  use asperity_contact_field, only: contact_field, contact_marks
  use asperity_files, only: write_bytes
  use asperity_kinds, only: int64, int8, not_computed, real64
  use asperity_problems, only: decimal_text, not_enough_memory
  use asperity_result_table, only: array_table, place_of, put_cell
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: write_vti, write_vts

  ! Bytes before the values of an array, which count them; of a number.
  integer(int64), parameter :: count_bytes = 8_int64, real_bytes = 8_int64
  ! Bytes that are written at once, at least; chosen.
  integer(int64), parameter :: block_size = 65536_int64

contains

  !> A point a row. An empty cell is `nan`.
  subroutine write_vts(table, points, buffer)
    type(array_table), intent(in) :: table      !! stresses at all depths
    integer, intent(in) :: points(3)            !! along x, y and of depths; the first is fastest
    type(text_buffer), intent(inout) :: buffer  !! gets the text
    character(len=:), allocatable :: extent
    integer(int64) :: row
    integer :: at(3), i, k

    at = [place_of(table, 'x'), place_of(table, 'y'), place_of(table, 'depth')]
    extent = 'Extent="0 ' // decimal_text(points(1) - 1) // ' 0 ' // &
             decimal_text(points(2) - 1) // ' 0 ' // decimal_text(points(3) - 1) // '">'
    call buffer%line('<?xml version="1.0"?>')
    call buffer%line('<VTKFile type="StructuredGrid" version="1.0" byte_order="LittleEndian">')
    call buffer%line('<StructuredGrid Whole' // extent)
    call buffer%line('<Piece ' // extent)
    call buffer%line('<Points>')
    call buffer%line('<DataArray type="Float64" NumberOfComponents="3" format="ascii">')
    do row = 1_int64, table%rows
      do k = 1, size(at)
        call put_cell(table%columns(at(k)), row, 'nan', buffer)
        call buffer%append(merge(' ', new_line('a'), k < size(at)))
      end do
    end do
    call buffer%line('</DataArray>')
    call buffer%line('</Points>')
    call buffer%line('<PointData>')
    do i = 1, size(table%columns)
      if (any(i == at)) cycle
      call buffer%line(array_tag('Float64', table%columns(i)%name, 'format="ascii">'))
      do row = 1_int64, table%rows
        call put_cell(table%columns(i), row, 'nan', buffer)
        call buffer%line('')
      end do
      call buffer%line('</DataArray>')
    end do
    call buffer%line('</PointData>')
    call buffer%line('</Piece>')
    call buffer%line('</StructuredGrid>')
    call buffer%line('</VTKFile>')
  end subroutine write_vts

  !> One cell a pixel, x along a row; the centre of the first pixel of a map is at 0, 0. Arrays:
  !> pressure, gap, displacement (NaN where a pixel was not measured) and contact (1 or 0); with a
  !> tangential load tractions, slip and stick (1 or 0). On the grid of asperities two numbers state
  !> how many contacts have the pressure of boundary elements and of Hertz.
  subroutine write_vti(field, time, descriptor, failure)
    type(contact_field), intent(in) :: field    !! of one state
    real(real64), intent(in) :: time            !! of the state; `not_computed`: there is none
    integer(c_int), intent(in) :: descriptor    !! of the open file, which gets the bytes by rows
    character(len=:), allocatable, intent(out) :: failure   !! why it was not written
    type(text_buffer) :: buffer

    call put_head(field, time, buffer)
    call put_reals(field%pressure)
    call put_reals(field%gap)
    call put_reals(field%displacement)
    if (allocated(field%traction)) then
      call put_reals(field%traction)
      call put_reals(field%traction_y)
      call put_reals(field%slip_x)
      call put_reals(field%slip_y)
    end if
    call put_marks(contact_marks(field))
    if (allocated(field%traction)) call put_marks(field%sticks)
    call buffer%line(new_line('a') // '</AppendedData>')
    call buffer%line('</VTKFile>')
    call write_block(0_int64)

  contains

    ! Numbers of all pixels with the count of their bytes; NaN where one was not computed.
    subroutine put_reals(values)
      real(real64), intent(in) :: values(:, :)
      integer :: j

      call buffer%append(transfer(real_bytes * size(values, kind=int64), &
                                  repeat('a', int(count_bytes))))
      do j = 1, size(values, 2)
        associate (row => values(:, j))
          call buffer%append(transfer(merge(row, ieee_value(row(1), ieee_quiet_nan), &
                                            row > not_computed), &
                                      repeat('a', real_bytes * size(row))))
        end associate
        call write_block(block_size)
      end do
    end subroutine put_reals

    ! A byte a pixel, 1 where it is marked, with the count of the bytes.
    subroutine put_marks(marks)
      logical, intent(in) :: marks(:, :)
      integer :: j

      call buffer%append(transfer(size(marks, kind=int64), repeat('a', int(count_bytes))))
      do j = 1, size(marks, 2)
        call buffer%append(transfer(int(merge(1, 0, marks(:, j)), int8), &
                                    repeat('a', size(marks, 1))))
        call write_block(block_size)
      end do
    end subroutine put_marks

    ! Writes what has gathered, from so many bytes on.
    subroutine write_block(least)
      integer(int64), intent(in) :: least

      if (buffer%failed) failure = not_enough_memory // ' for its text'
      if (allocated(failure) .or. buffer%used < least) return
      call write_bytes(descriptor, buffer%store(:buffer%used), failure)
      buffer%used = 0_int64
    end subroutine write_block

  end subroutine write_vti

  ! All before the values: numbers of the file and of its arrays, whose sizes give their places.
  subroutine put_head(field, time, buffer)
    type(contact_field), intent(in) :: field
    real(real64), intent(in) :: time
    type(text_buffer), intent(inout) :: buffer
    character(len=*), parameter :: number = 'NumberOfTuples="1" format="ascii">'
    character(len=*), parameter :: names(7) = [character(len=12) :: 'pressure', 'gap', &
      'displacement', 'traction_x', 'traction_y', 'slip_x', 'slip_y']
    integer(int64) :: offset, pixels
    character(len=80) :: numbers
    character(len=:), allocatable :: extent
    integer :: i, kinds
    logical :: has_numbers

    pixels = int(field%columns, int64) * field%rows
    kinds = merge(size(names), 3, allocated(field%traction))
    extent = '"0 ' // decimal_text(field%columns) // ' 0 ' // decimal_text(field%rows) // ' 0 0"'
    call buffer%line('<?xml version="1.0"?>')
    call buffer%line('<VTKFile type="ImageData" version="1.0" byte_order="' // &
                     trim(merge('LittleEndian', 'BigEndian   ', &
                                transfer(1, 'a') == achar(1))) // '" header_type="UInt64">')
    write (numbers, '(2es25.16e3)') field%origin - 0.5_real64 * field%pixel_spacing
    call buffer%append('<ImageData WholeExtent=' // extent // ' Origin="' // &
                       trim(adjustl(numbers)) // ' 0"')
    write (numbers, '(2es25.16e3)') field%pixel_spacing
    call buffer%line(' Spacing="' // trim(adjustl(numbers)) // ' 1">')
    has_numbers = time > not_computed .or. field%hertz_contacts >= 0
    if (has_numbers) call buffer%line('<FieldData>')
    if (time > not_computed) then
      write (numbers, '(es25.16e3)') time
      call buffer%line(array_tag('Float64', 'TimeValue', number // trim(adjustl(numbers)) // &
                                 '</DataArray>'))
    end if
    if (field%hertz_contacts >= 0) then
      call buffer%line(array_tag('Int32', 'boundary_element_contacts', number // &
                                 decimal_text(field%boundary_contacts) // '</DataArray>'))
      call buffer%line(array_tag('Int32', 'hertz_contacts', number // &
                                 decimal_text(field%hertz_contacts) // '</DataArray>'))
    end if
    if (has_numbers) call buffer%line('</FieldData>')
    call buffer%line('<Piece Extent=' // extent // '>')
    call buffer%line('<CellData Scalars="pressure">')
    offset = 0_int64
    do i = 1, kinds
      call put_array('Float64', trim(names(i)))
      offset = offset + count_bytes + real_bytes * pixels
    end do
    call put_array('UInt8', 'contact')
    offset = offset + count_bytes + pixels
    if (kinds > 3) call put_array('UInt8', 'stick')
    call buffer%append('</CellData>' // new_line('a') // '</Piece>' // new_line('a'))
    call buffer%line('</ImageData>')
    call buffer%append('<AppendedData encoding="raw">_')

  contains

    subroutine put_array(type_name, name)
      character(len=*), intent(in) :: type_name, name

      call buffer%line(array_tag(type_name, name, 'format="appended" offset="' // &
                                 decimal_text(offset) // '"/>'))
    end subroutine put_array

  end subroutine put_head

  ! The tag of an array: its type, its name and what follows.
  pure function array_tag(type_name, name, rest) result(tag)
    character(len=*), intent(in) :: type_name, name, rest
    character(len=:), allocatable :: tag

    tag = '<DataArray type="' // trim(type_name) // '" Name="' // name // '" ' // rest
  end function array_tag

end module asperity_results_vtk
