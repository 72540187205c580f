!> The distribution of the pressure in contact as CSV.
module asperity_histogram_csv
  use asperity_contact_field, only: contact_field, pressure_histogram
  use asperity_csv, only: csv_line
  use asperity_kinds, only: real64
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: write_histogram

  ! Bins between 0 and the greatest pressure.
  integer, parameter :: bins = 100

contains

  !> One line a bin: the pressure in its middle, and the density of the area over the pressure. The
  !> integral of the density is the contact area fraction of the pixels.
  subroutine write_histogram(field, buffer, comment)
    type(contact_field), intent(in) :: field    !! of one state
    type(text_buffer), intent(inout) :: buffer  !! gets the text
    character(len=*), intent(in), optional :: comment  !! a line before the names
    type(csv_line) :: line
    real(real64) :: centre(bins), density(bins)
    integer :: i

    if (present(comment)) call buffer%line('# ' // comment)
    call pressure_histogram(field, centre, density)
    call line%put('pressure')
    call line%put('density')
    call line%finish(buffer)
    do i = 1, bins
      call line%put(centre(i))
      call line%put(density(i))
      call line%finish(buffer)
    end do
  end subroutine write_histogram

end module asperity_histogram_csv
