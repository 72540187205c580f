!> The original program's contacts and positions as CSV.
module asperity_original_csv
  use asperity_csv, only: csv_line
  use asperity_original_records, only: contact_record, original_positions, original_records
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: write_original_variance
  public :: write_original_contacts, write_original_positions

contains

  !> One line a contact, over every approach of every position that was kept.
  subroutine write_original_contacts(records, buffer)
    type(original_records), intent(in) :: records  !! what was computed
    type(text_buffer), intent(inout) :: buffer     !! text to which the lines are added
    type(csv_line) :: line
    type(contact_record) :: contact
    integer :: i

    call buffer%line('position,x_displacement,y_displacement,step,approach,area_no,x,y,' // &
                     'upper,lower,area,projected_area,slope,load,average_pressure,' // &
                     'maximum_pressure,limit_exceeded')
    do i = 1, records%contacts_used
      contact = records%contacts(i)
      call line%put(contact%position)
      call line%put(records%positions(contact%position)%x_displacement)
      call line%put(records%positions(contact%position)%y_displacement)
      call line%put(contact%step)
      call line%put(contact%approach)
      call line%put(contact%area_no)
      call line%put(contact%x)
      call line%put(contact%y)
      call line%put(contact%upper)
      call line%put(contact%lower)
      call line%put(contact%area)
      call line%put(contact%projected_area)
      call line%put(contact%slope)
      call line%put(contact%load)
      call line%put(contact%average_pressure)
      call line%put(contact%maximum_pressure)
      call line%put(contact%limit_exceeded)
      call line%finish(buffer)
    end do
  end subroutine write_original_contacts

  !> One line a position: its last approach.
  subroutine write_original_positions(records, buffer)
    type(original_records), intent(in) :: records  !! what was computed
    type(text_buffer), intent(inout) :: buffer     !! text to which the lines are added
    type(csv_line) :: line
    integer :: m

    call buffer%line('position,x_displacement,y_displacement,steps,approach,contacts,load,' // &
                     'area,projected_area,limit_reached')
    do m = 1, original_positions
      call line%put(m)
      call line%put(records%positions(m)%x_displacement)
      call line%put(records%positions(m)%y_displacement)
      call line%put(records%positions(m)%steps)
      call line%put(records%positions(m)%approach)
      call line%put(records%positions(m)%contacts)
      call line%put(records%positions(m)%load)
      call line%put(records%positions(m)%area)
      call line%put(records%positions(m)%projected_area)
      call line%put(records%positions(m)%limit_reached)
      call line%finish(buffer)
    end do
  end subroutine write_original_positions

  !> Table VI with all digits.
  subroutine write_original_variance(records, buffer)
    type(original_records), intent(in) :: records  !! what was computed
    type(text_buffer), intent(inout) :: buffer     !! text to which the lines are added
    character(len=*), parameter :: names(7) = [character(len=26) :: &
      'total_load', 'total_contact_area', 'contact_points', 'approach', 'slope', &
      'total_area_difference', 'individual_area_difference']
    type(csv_line) :: line
    integer :: row

    call buffer%line('quantity,maximum,minimum,average')
    do row = 1, size(names)
      call line%put(trim(names(row)))
      call line%put(records%variance(row, :))
      call line%finish(buffer)
    end do
  end subroutine write_original_variance

end module asperity_original_csv
