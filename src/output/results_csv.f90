!> The present-day solver's contacts, positions and curves as CSV.
module asperity_results_csv
  use asperity_contact_records, only: contact_row, position_result, state_row
  use asperity_csv, only: csv_line
  use asperity_kinds, only: not_computed
  use asperity_scene_results, only: kinds_of_warnings, last_state, nominal_names, nominal_values, &
                                    scene_results
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
                     'maximum_pressure,limit_exceeded,vertical_load,penetration,overlap' // &
                     added_header(results, 'contacts'))
    do m = 1, size(results%positions)
      associate (position => results%positions(m))
        do step = 1, size(position%states)
          do i = position%states(step)%first_row, position%states(step)%last_row
            row = position%rows(i)
            call line%put(m)
            call line%put([position%x_displacement, position%y_displacement])
            call line%put(step)
            call line%put(position%states(step)%approach)
            call line%put(row%area_no)
            call line%put([row%x, row%y])
            call line%put(row%upper)
            call line%put(row%lower)
            call line%put([row%area, row%projected_area, row%slope, row%load, &
                           row%average_pressure, row%maximum_pressure])
            call line%put(row%limit_exceeded)
            call line%put([row%vertical_load, row%penetration, row%overlap])
            if (allocated(results%effects)) call line%put(position%contact_values(i, :))
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
                     'area,projected_area,limit_reached,vertical_load,overlapping_circles' // &
                     nominal_header(results) // added_header(results, 'positions') // &
                     ',warnings,error_estimate')
    do m = 1, size(results%positions)
      associate (position => results%positions(m))
        last = last_state(position)
        call line%put(m)
        call line%put([position%x_displacement, position%y_displacement])
        call line%put(size(position%states))
        call line%put(last%approach)
        call line%put(last%contacts)
        call line%put([last%load, last%area, last%projected_area])
        call line%put(position%limit_reached)
        call line%put(last%vertical_load)
        call line%put(position%overlapping_circles)
        call line%put(nominal_values(results, last))
        if (allocated(results%effects)) call put_effects(position, line)
        call line%put(kinds_of_warnings(position))
        call line%put(position%error_estimate)
        call line%finish(buffer)
      end associate
    end do
  end subroutine write_positions

  ! What a nominal area adds to a header.
  function nominal_header(results) result(header)
    type(scene_results), intent(in) :: results
    character(len=:), allocatable :: header

    header = ''
    if (results%nominal_area > 0) &
      header = ',' // trim(nominal_names(1)) // ',' // trim(nominal_names(2))
  end function nominal_header

  ! What the effects add to a header. A position tells of every effect how it was simulated (off:
  ! left out), the share of the vertical load that was estimated and that measured, and how its
  ! solve ended.
  function added_header(results, of_what) result(header)
    type(scene_results), intent(in) :: results
    character(len=*), intent(in) :: of_what
    character(len=:), allocatable :: header, name
    integer :: i

    header = ''
    if (.not. allocated(results%effects)) return
    associate (effects => results%effects)
      if (of_what == 'contacts') then
        do i = 1, size(effects%contact_columns)
          header = header // ',' // trim(effects%contact_columns(i))
        end do
        return
      end if
      do i = 1, size(effects%names)
        name = trim(effects%names(i))
        header = header // ',' // name // ',' // name // '_estimate,' // name // '_influence,' // &
                 name // '_residual,' // name // '_iterations'
      end do
      do i = 1, size(effects%state_columns)
        header = header // ',' // trim(effects%state_columns(i))
      end do
    end associate
  end function added_header

  ! What the effects did at a position.
  subroutine put_effects(position, line)
    type(position_result), intent(in) :: position
    type(csv_line), intent(inout) :: line
    integer :: i

    do i = 1, size(position%effects)
      call line%put(position%effects(i)%simulated)
      call line%put([position%effects(i)%estimate, position%effects(i)%influence])
      if (position%effects(i)%simulated == 'off') then
        call line%put([not_computed, not_computed])
      else
        call line%put(position%effects(i)%ending%residual)
        call line%put(position%effects(i)%ending%iterations)
      end if
    end do
    call line%put(position%state_values)
  end subroutine put_effects

  !> One line a state: the totals on the way to the end.
  subroutine write_curve(results, buffer)
    type(scene_results), intent(in) :: results  !! solved positions
    type(text_buffer), intent(inout) :: buffer  !! the text
    type(csv_line) :: line
    integer :: m, step

    call buffer%line('position,step,approach,decrease,contacts,load,area,projected_area,' // &
                     'vertical_load,time' // nominal_header(results))
    do m = 1, size(results%positions)
      do step = 1, size(results%positions(m)%states)
        associate (state => results%positions(m)%states(step))
          call line%put(m)
          call line%put(step)
          call line%put([state%approach, state%closing])
          call line%put(state%contacts)
          call line%put([state%load, state%area, state%projected_area, state%vertical_load, &
                         state%time])
          call line%put(nominal_values(results, state))
          call line%finish(buffer)
        end associate
      end do
    end do
  end subroutine write_curve

end module asperity_results_csv
