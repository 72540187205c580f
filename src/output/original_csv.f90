!> The original program's contacts and positions as CSV.
module asperity_original_csv
  use asperity_csv_tables, only: write_table
  use asperity_original_records, only: contact_record, original_positions, original_records
  use asperity_result_table, only: add_reals, add_wholes, add_words, array_table
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

end module asperity_original_csv
