!> The present-day solver's contacts, positions and curves as CSV.
module asperity_results_csv
  use asperity_contact_records, only: contact_row, scene_results, state_row
  use asperity_csv, only: csv_line
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: write_contacts, write_positions, write_curve

contains

  !> One line a contact, over every state of every position.
  subroutine write_contacts(results, buffer)
    type(scene_results), intent(in) :: results  !! solved positions, with their rows
    type(text_buffer), intent(inout) :: buffer  !! the text
    type(csv_line) :: line
    type(contact_row) :: row
    integer :: i, m, step

    call buffer%line('position,x_displacement,y_displacement,step,approach,area_no,x,y,' // &
                     'upper,lower,area,projected_area,slope,load,average_pressure,' // &
                     'maximum_pressure,limit_exceeded,vertical_load,penetration,overlap')
    do m = 1, size(results%positions)
      associate (position => results%positions(m))
        do step = 1, size(position%states)
          do i = position%states(step)%first_row, position%states(step)%last_row
            row = position%rows(i)
            call line%put(m)
            call line%put(position%x_displacement)
            call line%put(position%y_displacement)
            call line%put(step)
            call line%put(position%states(step)%approach)
            call line%put(row%area_no)
            call line%put(row%x)
            call line%put(row%y)
            call line%put(row%upper)
            call line%put(row%lower)
            call line%put(row%area)
            call line%put(row%projected_area)
            call line%put(row%slope)
            call line%put(row%load)
            call line%put(row%average_pressure)
            call line%put(row%maximum_pressure)
            call line%put(row%limit_exceeded)
            call line%put(row%vertical_load)
            call line%put(row%penetration)
            call line%put(row%overlap)
            call line%finish(buffer)
          end do
        end do
      end associate
    end do
  end subroutine write_contacts

  !> One line a position: its last state.
  subroutine write_positions(results, buffer)
    type(scene_results), intent(in) :: results  !! solved positions
    type(text_buffer), intent(inout) :: buffer  !! the text
    type(csv_line) :: line
    type(state_row) :: last
    integer :: m

    call buffer%line('position,x_displacement,y_displacement,steps,approach,contacts,load,' // &
                     'area,projected_area,limit_reached,vertical_load')
    do m = 1, size(results%positions)
      associate (position => results%positions(m))
        last = position%states(size(position%states))
        call line%put(m)
        call line%put(position%x_displacement)
        call line%put(position%y_displacement)
        call line%put(size(position%states))
        call line%put(last%approach)
        call line%put(last%contacts)
        call line%put(last%load)
        call line%put(last%area)
        call line%put(last%projected_area)
        call line%put(position%limit_reached)
        call line%put(last%vertical_load)
        call line%finish(buffer)
      end associate
    end do
  end subroutine write_positions

  !> One line a state: the totals on the way to the end.
  subroutine write_curve(results, buffer)
    type(scene_results), intent(in) :: results  !! solved positions
    type(text_buffer), intent(inout) :: buffer  !! the text
    type(csv_line) :: line
    integer :: m, step

    call buffer%line('position,step,approach,decrease,contacts,load,area,projected_area,' // &
                     'vertical_load')
    do m = 1, size(results%positions)
      do step = 1, size(results%positions(m)%states)
        associate (state => results%positions(m)%states(step))
          call line%put(m)
          call line%put(step)
          call line%put(state%approach)
          call line%put(state%closing)
          call line%put(state%contacts)
          call line%put(state%load)
          call line%put(state%area)
          call line%put(state%projected_area)
          call line%put(state%vertical_load)
          call line%finish(buffer)
        end associate
      end do
    end do
  end subroutine write_curve

end module asperity_results_csv
