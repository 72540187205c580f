!> Tables as CSV: results of a run, distribution of the pressure, summits and spectra of a map.
module asperity_csv_tables
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use asperity_contact_field, only: contact_field, pressure_histogram
  use asperity_csv, only: csv_line
  use asperity_kinds, only: not_computed, real64
  use asperity_map_stress, only: component_names, largest_shear, von_mises
  use asperity_map_spectrum, only: power_spectrum, spectrum_names
  use asperity_map_summits, only: map_summits
  use asperity_result_table, only: add_reals, add_surface, array_table
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: begin_stress_csv, write_histogram, write_spectrum_csv, write_stress_csv, &
            write_summits_csv, write_table

  ! Bins of the pressure between 0 and the greatest one.
  integer, parameter :: bins = 100

contains

  !> Writes one line a row, under the names of the columns.
  subroutine write_table(table, buffer, comment)
    type(array_table), intent(in) :: table      !! table with columns
    type(text_buffer), intent(inout) :: buffer  !! gets the text
    character(len=*), intent(in), optional :: comment  !! a line before the names
    type(csv_line) :: line
    integer :: i, row

    if (present(comment)) call buffer%line('# ' // comment)
    do i = 1, size(table%columns)
      call line%put(table%columns(i)%name)
    end do
    call line%finish(buffer)
    do row = 1, table%rows
      do i = 1, size(table%columns)
        associate (column => table%columns(i))
          if (allocated(column%wholes)) then
            call line%put(column%wholes(row))
          else if (allocated(column%letters)) then
            call line%put(transfer(column%letters(:, row), repeat('a', size(column%letters, 1))))
          else if (ieee_is_nan(column%reals(row))) then
            call line%put('')
          else if (column%is_count) then
            call line%put(nint(column%reals(row)))
          else
            call line%put(column%reals(row))
          end if
        end associate
      end do
      call line%finish(buffer)
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
    type(csv_line) :: line
    integer :: i, k

    call buffer%line('spectrum,q,c_iso,c_1d,number')
    do k = 1, size(spectra)
      do i = 1, size(spectra(k)%q)
        call line%put(trim(spectrum_names(k)))
        call line%put([spectra(k)%q(i), merge(spectra(k)%c(i), not_computed, k == 1), &
                       merge(not_computed, spectra(k)%c(i), k == 1)])
        call line%put(spectra(k)%number(i))
        call line%finish(buffer)
      end do
    end do
  end subroutine write_spectrum_csv

  !> Writes the names of the columns of stresses.
  subroutine begin_stress_csv(buffer, comment)
    type(text_buffer), intent(inout) :: buffer  !! gets the text
    character(len=*), intent(in), optional :: comment  !! a line before the names
    type(csv_line) :: line
    integer :: k

    if (present(comment)) call buffer%line('# ' // comment)
    call line%put('depth')
    call line%put('x')
    call line%put('y')
    do k = 1, size(component_names)
      call line%put('stress_' // component_names(k))
    end do
    call line%put('von_mises')
    call line%put('largest_shear')
    call line%finish(buffer)
  end subroutine begin_stress_csv

  !> Writes one line a pixel: the stresses below it at one depth.
  subroutine write_stress_csv(field, depth, stress, buffer)
    type(contact_field), intent(in) :: field     !! with the places of its pixels
    real(real64), intent(in) :: depth            !! depth below the surface [length]
    real(real64), intent(in) :: stress(:, :, :)  !! (column, row, component)
    type(text_buffer), intent(inout) :: buffer   !! gets the text
    type(csv_line) :: line
    integer :: i, j

    do j = 1, field%rows
      do i = 1, field%columns
        call line%put([depth, field%origin + ([i, j] - 1) * field%pixel_spacing, &
                       stress(i, j, :), von_mises(stress(i, j, :)), largest_shear(stress(i, j, :))])
        call line%finish(buffer)
      end do
    end do
  end subroutine write_stress_csv

  !> Writes the summits as a surface: what a scene reads.
  subroutine write_summits_csv(summits, buffer)
    type(map_summits), intent(in) :: summits    !! of a map
    type(text_buffer), intent(inout) :: buffer  !! gets the text
    type(array_table) :: table

    call add_surface(summits%x, summits%y, summits%height, summits%radius, table, '')
    call write_table(table, buffer)
  end subroutine write_summits_csv

end module asperity_csv_tables
