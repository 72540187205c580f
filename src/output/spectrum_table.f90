!> Power spectra of a map as CSV.
module asperity_spectrum_table
  use asperity_csv, only: csv_line
  use asperity_kinds, only: not_computed
  use asperity_map_spectrum, only: power_spectrum, spectrum_names
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: write_spectrum_csv

contains

  !> A line a wave number: of the area, then of lines along x, then along y.
  subroutine write_spectrum_csv(spectra, buffer)
    type(power_spectrum), intent(in) :: spectra(3)  !! of a map
    type(text_buffer), intent(inout) :: buffer      !! the text
    type(csv_line) :: line
    integer :: i, k

    call buffer%line('spectrum,q,c_iso,c_1d,number')
    do k = 1, size(spectra)
      do i = 1, size(spectra(k)%q)
        call line%put(trim(spectrum_names(k)))
        call line%put(spectra(k)%q(i))
        call line%put(merge(spectra(k)%c(i), not_computed, k == 1))
        call line%put(merge(not_computed, spectra(k)%c(i), k == 1))
        call line%put(spectra(k)%number(i))
        call line%finish(buffer)
      end do
    end do
  end subroutine write_spectrum_csv

end module asperity_spectrum_table
