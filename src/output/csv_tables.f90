!> Tables as CSV: results of a run, distribution of the pressure, stresses, summits and spectra of a
!> map; contacts and positions of the original program.
module asperity_csv_tables
  use asperity_contact_field, only: contact_field, pressure_histogram
  use asperity_kinds, only: int64, not_computed, real64
  use asperity_map_spectrum, only: power_spectrum, spectrum_names
  use asperity_map_stress, only: component_names, largest_shear, von_mises
  use asperity_original_records, only: contact_record, original_positions, original_records
  use asperity_result_table, only: add_reals, add_wholes, add_words, array_table, put_cell
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: stress_cells, stress_table, write_histogram, write_original_contacts, &
            write_original_positions, write_original_variance, write_spectrum_csv, write_table

  !> Columns of the table of stresses: places, then stresses from `first_stress` on.
  integer, parameter, public :: first_stress = 4, stress_columns = 5 + size(component_names)
  character(len=*), parameter, public :: stress_names(stress_columns) = [character(len=13) :: &
    'depth', 'x', 'y', 'stress_' // component_names, 'von_mises', 'largest_shear']

  ! Bins of the pressure between 0 and the greatest one.
  integer, parameter :: bins = 100

contains

  !> Writes one line a row, under the names of the columns.
  subroutine write_table(table, buffer, comment)
    type(array_table), intent(in) :: table      !! table with columns
    type(text_buffer), intent(inout) :: buffer  !! gets the text
    character(len=*), intent(in), optional :: comment  !! a line before the names
    integer(int64) :: row
    integer :: i

    if (present(comment)) call buffer%line('# ' // comment)
    do row = 0_int64, table%rows
      do i = 1, size(table%columns)
        if (i > 1) call buffer%append(',')
        if (row == 0_int64) call buffer%append(table%columns(i)%name)
        if (row > 0_int64) call put_cell(table%columns(i), row, '', buffer)
      end do
      call buffer%line('')
    end do
  end subroutine write_table

  !> Writes one line a bin: the pressure in its middle, and the density of the area over the
  !> pressure. The integral of the density is the contact area fraction of the pixels.
  subroutine write_histogram(field, buffer, comment)
    type(contact_field), intent(in) :: field    !! of one state
    type(text_buffer), intent(inout) :: buffer  !! gets the text
    character(len=*), intent(in), optional :: comment  !! a line before the names
    type(array_table) :: table
    real(real64) :: centre(bins), density(bins)

    call pressure_histogram(field, centre, density)
    call add_reals(table, 'pressure', centre)
    call add_reals(table, 'density', density)
    call write_table(table, buffer, comment)
  end subroutine write_histogram

  !> Writes one line a wave number: of the area, then of lines along x, then along y.
  subroutine write_spectrum_csv(spectra, buffer)
    type(power_spectrum), intent(in) :: spectra(3)  !! of a map
    type(text_buffer), intent(inout) :: buffer      !! gets the text
    type(array_table) :: table
    integer :: k

    call add_words(table, 'spectrum', [(spread(spectrum_names(k), 1, size(spectra(k)%q)), &
                                        k=1, size(spectra))])
    call add_reals(table, 'q', [(spectra(k)%q, k=1, size(spectra))])
    call add_reals(table, 'c_iso', [spectra(1)%c, spread(not_computed, 1, size(spectra(2)%q) + &
                                                         size(spectra(3)%q))])
    call add_reals(table, 'c_1d', [spread(not_computed, 1, size(spectra(1)%q)), spectra(2)%c, &
                                   spectra(3)%c])
    call add_wholes(table, 'number', [(spectra(k)%number, k=1, size(spectra))])
    call write_table(table, buffer)
  end subroutine write_spectrum_csv

  !> Table of stresses: a row a pixel at a depth.
  function stress_table(cells) result(table)
    real(real64), intent(in) :: cells(:, :)  !! (row, column) by `stress_cells`, of all depths
    type(array_table) :: table
    integer :: k

    do k = 1, stress_columns
      call add_reals(table, trim(stress_names(k)), cells(:, k))
    end do
  end function stress_table

  !> Cells of the table of stresses at one depth.
  pure function stress_cells(field, depth, stress) result(cells)
    type(contact_field), intent(in) :: field     !! with the places of its pixels
    real(real64), intent(in) :: depth            !! depth below the surface [length]
    real(real64), intent(in) :: stress(:, :, :)  !! (column, row, component)
    real(real64) :: cells(int(field%columns, int64) * field%rows, stress_columns)
    integer(int64) :: pixel
    integer :: i, j

    pixel = 0_int64
    do j = 1, field%rows
      do i = 1, field%columns
        pixel = pixel + 1_int64
        cells(pixel, :) = &
          [depth, field%origin + ([i, j] - 1) * field%pixel_spacing, stress(i, j, :), &
           von_mises(stress(i, j, :)), largest_shear(stress(i, j, :))]
      end do
    end do
  end function stress_cells

  !> One line a contact, over every approach of every position that was kept.
  subroutine write_original_contacts(records, buffer)
    type(original_records), intent(in) :: records  !! what was computed
    type(text_buffer), intent(inout) :: buffer     !! text to which the lines are added
    type(array_table) :: table
    type(contact_record), allocatable :: contacts(:)

    allocate (contacts(0))
    if (allocated(records%contacts)) contacts = records%contacts(:records%contacts_used)
    call add_wholes(table, 'position', contacts%position)
    call add_reals(table, 'x_displacement', records%positions(contacts%position)%x_displacement)
    call add_reals(table, 'y_displacement', records%positions(contacts%position)%y_displacement)
    call add_wholes(table, 'step', contacts%step)
    call add_reals(table, 'approach', contacts%approach)
    call add_wholes(table, 'area_no', contacts%area_no)
    call add_reals(table, 'x', contacts%x)
    call add_reals(table, 'y', contacts%y)
    call add_wholes(table, 'upper', contacts%upper)
    call add_wholes(table, 'lower', contacts%lower)
    call add_reals(table, 'area', contacts%area)
    call add_reals(table, 'projected_area', contacts%projected_area)
    call add_reals(table, 'slope', contacts%slope)
    call add_reals(table, 'load', contacts%load)
    call add_reals(table, 'average_pressure', contacts%average_pressure)
    call add_reals(table, 'maximum_pressure', contacts%maximum_pressure)
    call add_wholes(table, 'limit_exceeded', merge(1, 0, contacts%limit_exceeded))
    call write_table(table, buffer)
  end subroutine write_original_contacts

  !> One line a position: its last approach.
  subroutine write_original_positions(records, buffer)
    type(original_records), intent(in) :: records  !! what was computed
    type(text_buffer), intent(inout) :: buffer     !! text to which the lines are added
    type(array_table) :: table
    integer :: m

    call add_wholes(table, 'position', [(m, m=1, original_positions)])
    call add_reals(table, 'x_displacement', records%positions%x_displacement)
    call add_reals(table, 'y_displacement', records%positions%y_displacement)
    call add_wholes(table, 'steps', records%positions%steps)
    call add_reals(table, 'approach', records%positions%approach)
    call add_wholes(table, 'contacts', records%positions%contacts)
    call add_reals(table, 'load', records%positions%load)
    call add_reals(table, 'area', records%positions%area)
    call add_reals(table, 'projected_area', records%positions%projected_area)
    call add_wholes(table, 'limit_reached', merge(1, 0, records%positions%limit_reached))
    call write_table(table, buffer)
  end subroutine write_original_positions

  !> Table VI with all digits.
  subroutine write_original_variance(records, buffer)
    type(original_records), intent(in) :: records  !! what was computed
    type(text_buffer), intent(inout) :: buffer     !! text to which the lines are added
    character(len=*), parameter :: names(7) = [character(len=26) :: &
      'total_load', 'total_contact_area', 'contact_points', 'approach', 'slope', &
      'total_area_difference', 'individual_area_difference']
    type(array_table) :: table

    call add_words(table, 'quantity', names)
    call add_reals(table, 'maximum', records%variance(:, 1))
    call add_reals(table, 'minimum', records%variance(:, 2))
    call add_reals(table, 'average', records%variance(:, 3))
    call write_table(table, buffer)
  end subroutine write_original_variance

end module asperity_csv_tables
