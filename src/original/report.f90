!> The printed report of the original program: Tables V, IIIA, IIIB, VII and VI.
!>
!> Columns, headings and page breaks are the original's. Column one of every line is the line
!> printer's carriage control. "Fault n" refers to docs/theory/faults.md, "Deviation x" to
!> reference_output/faults/listing_port_scan.md.
module asperity_report
  use asperity_kinds, only: real64
  use asperity_library_turn, only: library_turn
  use asperity_line_printer, only: apply_carriage_control, fixed_field, table_letters, new_page, &
    skip_lines
  use asperity_original_records, only: approach_row, contact_record, individual_difference_row, &
                                       model_record, original_positions, original_records, &
                                       points_row, position_record, slope_row, total_area_row, &
                                       total_difference_row, total_load_row
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: write_report

  ! Lines of a contact table before the next page begins (F2MAX).
  integer, parameter :: lines_a_page = 21
  ! Asperities on the first page of Table III, and on each further one.
  integer, parameter :: first_page = 38, further_page = 39

  ! FORMAT statements of the original, for cells that are already text.
  character(len=*), parameter :: contact_row = &
    '(13x, a7, i3, 2a8, i3, i4, 1x, 2a8, 2a6, 2a8, 3x, a4)'
  character(len=*), parameter :: totals_row = '(47x, 2a8, a12, 5x, "TOTAL")'
  character(len=*), parameter :: displacement_row = &
    '(22x, "RELATIVE DISPLACEMENT OF UPPER MODEL   X   ", a6, " CM   Y  ", a6, " CM")'
  character(len=*), parameter :: model_row = '(30x, "MODEL", i5, 2a7, a11, a7, a10)'
  ! Deviation c: FORMAT 20 and its WRITE, as scanned, name THETAU twice; the second is THETAL.
  character(len=*), parameter :: angle_row = &
    '(30x, "THETAU=", a5, 2x, "RADIANS", 10x, "THETAL=", a5, 2x, "RADIANS")'
  character(len=*), parameter :: asperity_row = '(31x, i5, 3x, 2a9, a10)'
  character(len=*), parameter :: variance_row = '(25x, a24, 3a10)'
  character(len=*), parameter :: count_row = '(25x, a24, 3i10)'

contains

  !> The whole report, or what the original had printed when it stopped. Without
  !> `carriage_control` column one is dropped and a new page is a form feed, a double space an
  !> empty line.
  subroutine write_report(records, printed, carriage_control, buffer)
    type(original_records), intent(in) :: records            !! what was computed
    logical, intent(in) :: printed(original_positions)       !! positions with a contact table
    logical, intent(in) :: carriage_control                  !! keep column one
    type(text_buffer), intent(inout) :: buffer               !! text to which the report is added
    type(text_buffer) :: lines
    integer :: m, number
    type(library_turn) :: turn

    call turn%begin()
    call input_table(lines, records%upper, records%lower)
    call asperity_table(lines, records%upper, 'IIIA', 'UPPER')
    call asperity_table(lines, records%lower, 'IIIB', 'LOWER')
    ! Deviation m: tables are lettered in the order of print, not by position.
    number = 0
    do m = 1, original_positions
      if (.not. printed(m) .or. m > records%last_heading) cycle
      number = number + 1
      call contact_table(lines, records, records%positions(m), 'TABLE VII' // table_letters(number))
    end do
    if (records%is_complete) call variance_table(lines, records%variance)
    if (carriage_control) then
      call buffer%append_text(lines)
    else
      call apply_carriage_control(lines%store(:lines%used), buffer)
      buffer%failed = buffer%failed .or. lines%failed
    end if
  end subroutine write_report

  !> Table V.
  subroutine input_table(lines, upper, lower)
    type(text_buffer), intent(inout) :: lines
    type(model_record), intent(in) :: upper, lower
    character(len=100) :: line

    call new_page(lines, 10)
    call lines%line(repeat(' ', 53) // 'TABLE V')
    call skip_lines(lines, 2)
    call lines%line(repeat(' ', 52) // 'INPUT DATA')
    call skip_lines(lines, 2)
    call lines%line(repeat(' ', 41) // 'ASPERITY                MATERIAL')
    call lines%line(repeat(' ', 40) // 'PROPERTIES              PROPERTIES')
    call skip_lines(lines, 2)
    call lines%line(repeat(' ', 37) // 'NO. SUMMIT  MAX     ELASTIC POISSONS    MAX')
    call lines%line(repeat(' ', 41) // 'RADIUS HEIGHT   MODULUS   RATIO    ALLOW.')
    call lines%line(repeat(' ', 76) // 'STRESS')
    call lines%line(repeat(' ', 42) // '(CM)   (CM)   (NT/CM2)          (NT/CM2)')
    call skip_lines(lines, 1)
    call lines%line(repeat(' ', 30) // 'UPPER')
    call model_line(upper)
    call skip_lines(lines, 1)
    call lines%line(repeat(' ', 30) // 'LOWER')
    call model_line(lower)
    call skip_lines(lines, 4)
    write (line, angle_row) fixed_field(upper%angle, 5, 3), fixed_field(lower%angle, 5, 3)
    call lines%line(line)

  contains

    subroutine model_line(model)
      type(model_record), intent(in) :: model

      write (line, model_row) model%number, fixed_field(model%radius, 7, 3), &
        fixed_field(model%height_max, 7, 4), fixed_field(model%elastic_modulus, 11, 0), &
        fixed_field(model%poisson_ratio, 7, 3), fixed_field(model%stress_max, 10, 0)
      call lines%line(line)
    end subroutine model_line

  end subroutine input_table

  !> Table III of one model. Fault 16, not kept: the listing of the lower model tests the upper
  !> model's number before it continues on a new page; both tables here test their own.
  subroutine asperity_table(lines, model, number, name)
    type(text_buffer), intent(inout) :: lines
    type(model_record), intent(in) :: model
    character(len=*), intent(in) :: number, name
    character(len=100) :: line
    integer :: i, page_end

    call new_page(lines, 6)
    call lines%line(repeat(' ', 44) // 'TABLE ' // number)
    call skip_lines(lines, 2)
    call lines%line(repeat(' ', 24) // 'LOCATIONS AND HEIGHTS OF ASPERITIES ON ' // name // &
                    ' MODEL')
    call put_headings()
    page_end = first_page
    do i = 1, model%number
      write (line, asperity_row) i, fixed_field(model%x(i), 9, 3), &
        fixed_field(model%y(i), 9, 3), fixed_field(model%height(i), 10, 4)
      call lines%line(line)
      if (i == model%number .or. i < page_end) cycle
      call new_page(lines, 6)
      call lines%line(repeat(' ', 44) // 'TABLE ' // number // ' (CONTINUED)')
      call put_headings()
      page_end = page_end + further_page
    end do

  contains

    subroutine put_headings()
      call skip_lines(lines, 2)
      call lines%line(repeat(' ', 31) // 'ASPERITY  SUMMIT LOCATION     HEIGHT')
      call lines%line(repeat(' ', 32) // 'INDEX    X-COORD  Y-COORD')
      call lines%line(repeat(' ', 32) // 'NUMBER')
      call lines%line(repeat(' ', 43) // '(CM)     (CM)      (CM)')
    end subroutine put_headings

  end subroutine asperity_table

  !> Table VII of one position. A page is full after 21 lines; the next page begins before the
  !> next line, but a total that follows the last place of the list stays on its page.
  subroutine contact_table(lines, records, position, title)
    type(text_buffer), intent(inout) :: lines
    type(original_records), intent(in) :: records
    type(position_record), intent(in) :: position
    character(len=*), intent(in) :: title
    character(len=100) :: line
    integer :: row, step, on_page

    call contact_heading(lines, title)
    write (line, displacement_row) fixed_field(position%x_displacement, 6, 3), &
      fixed_field(position%y_displacement, 6, 3)
    call lines%line(line)
    call skip_lines(lines, 2)
    call column_headings(lines)
    on_page = 0
    row = position%first_contact
    ! The rows of an approach at which the original stopped have no total.
    do step = 1, position%steps + 1
      do while (row <= position%last_contact)
        if (records%contacts(row)%step /= step) exit
        call break_full_page()
        call contact_line(lines, records%contacts(row), records)
        on_page = on_page + 1
        row = row + 1
      end do
      if (step > position%steps) exit
      if (records%contacts(row - 1)%area_no < records%upper%number) call break_full_page()
      write (line, totals_row) fixed_field(position%totals(1, step), 8, 5), &
        fixed_field(position%totals(2, step), 8, 5), fixed_field(position%totals(3, step), 12, 0)
      call lines%line(line)
      on_page = on_page + 1
    end do

  contains

    subroutine break_full_page()
      if (on_page < lines_a_page) return
      on_page = 0
      call contact_heading(lines, title)
      call column_headings(lines)
    end subroutine break_full_page

  end subroutine contact_table

  !> One contact: with load, or touching without. Deviation l: a touching contact prints `0.0` under
  !> both areas, as in every printed table of the thesis; FORMAT 12 leaves the second one blank.
  subroutine contact_line(lines, contact, records)
    type(text_buffer), intent(inout) :: lines
    type(contact_record), intent(in) :: contact
    type(original_records), intent(in) :: records
    character(len=8) :: pressures(2)
    character(len=4) :: word
    character(len=100) :: line

    pressures = ''
    word = ''
    if (contact%loaded) then
      pressures(1) = fixed_field(contact%average_pressure, 8, 0)
      pressures(2) = fixed_field(contact%maximum_pressure, 8, 0)
      word = merge(records%word_yes, records%word_no, contact%limit_exceeded)
    end if
    write (line, contact_row) fixed_field(contact%approach, 7, 4), contact%area_no, &
      fixed_field(contact%x, 8, 3), fixed_field(contact%y, 8, 3), contact%upper, contact%lower, &
      fixed_field(contact%area, 8, 5), fixed_field(contact%projected_area, 8, 5), &
      fixed_field(contact%slope, 6, 3), fixed_field(contact%load, 6, 0), pressures, word
    call lines%line(line)
  end subroutine contact_line

  !> Title of a page of Table VII.
  subroutine contact_heading(lines, title)
    type(text_buffer), intent(inout) :: lines
    character(len=*), intent(in) :: title

    call new_page(lines, 10)
    call lines%line(repeat(' ', 53) // title)
    call skip_lines(lines, 3)
    call lines%line(repeat(' ', 49) // 'CONTACT PARAMETERS')
    call skip_lines(lines, 1)
  end subroutine contact_heading

  !> Column headings of Table VII.
  subroutine column_headings(lines)
    type(text_buffer), intent(inout) :: lines

    call lines%line(repeat(' ', 15) // 'APPR AREA  CENTER COORD ASPERITY  CALC    PROJ  SLOPE' // &
                    '  LOAD    AVG    MAX    ELASTIC')
    call lines%line(repeat(' ', 15) // '     NO.     X       Y   INDEX   CONTACT  AREA      ' // &
                    repeat(' ', 10) // 'PRESS   PRESS  LIMIT')
    call lines%line(repeat(' ', 41) // 'U   L   AREA' // repeat(' ', 39) // 'EXCEEDED')
    call lines%line(repeat(' ', 15) // '(CM)' // repeat(' ', 8) // '(CM)   (CM)' // &
                    repeat(' ', 11) // '(CM2)   (CM2)' // repeat(' ', 8) // &
                    '(NT) (NT/CM2) (NT/CM2)')
  end subroutine column_headings

  !> Table VI.
  subroutine variance_table(lines, variance)
    type(text_buffer), intent(inout) :: lines
    real(real64), intent(in) :: variance(:, :)
    character(len=100) :: line

    call new_page(lines, 10)
    call lines%line(repeat(' ', 48) // 'TABLE VI')
    call skip_lines(lines, 2)
    call lines%line(repeat(' ', 37) // 'VARIANCE OF CONTACT PARAMETERS')
    call lines%line(repeat(' ', 39) // 'FOR MODEL POSITIONS TESTED')
    call skip_lines(lines, 2)
    call lines%line(repeat(' ', 25) // 'CONTACT PARAMETER   UNITS  MAXIMUM   MINIMUM   AVERAGE')
    call skip_lines(lines, 1)
    call number_row('TOTAL LOAD          (NT)', total_load_row, 0)
    call skip_lines(lines, 1)
    call number_row('TOTAL CONTACT AREA  (CM2)', total_area_row, 4)
    call skip_lines(lines, 2)
    call lines%line(repeat(' ', 25) // 'NUMBER OF CONTACT')
    write (line, count_row) 'POINTS' // repeat(' ', 18), nint(variance(points_row, :))
    call lines%line(line)
    call skip_lines(lines, 1)
    call number_row('APPROACH            (CM)', approach_row, 4)
    call skip_lines(lines, 2)
    call lines%line(repeat(' ', 25) // 'SLOPE OF CONTACT')
    call number_row('AREAS', slope_row, 3)
    call skip_lines(lines, 2)
    call lines%line(repeat(' ', 25) // 'DIFFERENCE IN CAL-')
    call lines%line(repeat(' ', 25) // 'CULATED AND PRO-')
    call number_row('JECTED CONTACT AREA (%)', total_difference_row, 1)
    call skip_lines(lines, 2)
    call lines%line(repeat(' ', 25) // 'DIFFERENCE IN CAL-')
    call lines%line(repeat(' ', 25) // 'CULATED AND PRO-')
    call lines%line(repeat(' ', 25) // 'JECTED INDIVIDUAL')
    call number_row('CONTACT AREAS       (%)', individual_difference_row, 1)
    call new_page(lines, 10)
    call skip_lines(lines, 1)

  contains

    subroutine number_row(name, row, decimals)
      character(len=*), intent(in) :: name
      integer, intent(in) :: row, decimals
      character(len=10) :: cells(3)
      integer :: i

      do i = 1, 3
        cells(i) = fixed_field(variance(row, i), 10, decimals)
      end do
      write (line, variance_row) name // repeat(' ', max(0, 24 - len(name))), cells
      ! A unit of five letters runs into the first column's blanks, as FORMAT 41 has it.
      if (len(name) == 25) line(26:50) = name
      call lines%line(line)
    end subroutine number_row

  end subroutine variance_table

end module asperity_report
