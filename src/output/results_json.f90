!> A run in one file of JSON: the scene, where it comes from, the summary, and its tables by column,
!> with their units, under the names of the CSV files. `docs/results.schema.json` is its schema.
module asperity_results_json
  use asperity_printable, only: printable_text
  use asperity_kinds, only: int64
  use asperity_problems, only: problem_list, real_text
  use asperity_result_table, only: array_table, of_contacts, put_cell, table_names
  use asperity_scene_inputs, only: input_file
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: effect_words, scene
  use asperity_summary, only: write_summary
  use asperity_text_buffer, only: text_buffer
  use asperity_unit_names, only: has_units, unit_of
  use asperity_version, only: version
  implicit none
  private

  public :: write_json, write_json_scene, write_json_table

contains

  !> The whole file.
  subroutine write_json(scene_in, inputs, results, tables, warnings, buffer)
    type(scene), intent(in) :: scene_in                    !! what was solved
    type(input_file), intent(in) :: inputs(3)              !! the files that it is made of
    type(scene_results), intent(in) :: results             !! results of the run
    type(array_table), intent(in) :: tables(3)             !! positions, states, contacts of them
    type(problem_list), intent(in) :: warnings             !! a line a kind
    type(text_buffer), intent(inout) :: buffer             !! gets the text
    type(text_buffer) :: summary
    integer :: i

    call buffer%line('{')
    call put_scene(scene_in, inputs, results, buffer)
    call buffer%line(',')
    call write_summary(scene_in, results, summary)
    call buffer%line('"summary": ' // json_text(summary%text()) // ',')
    call put_lines('notes', scene_in%notes%text(), buffer)
    call put_lines('warnings', warnings%text(), buffer)
    call buffer%line('"units": {')
    do i = 1, of_contacts
      call put_column_units(trim(table_names(i)), scene_in, tables(i), buffer)
      call buffer%line(trim(merge(',', ' ', i < of_contacts)))
    end do
    call buffer%line('},')
    do i = 1, of_contacts
      call put_table(trim(table_names(i)), tables(i), buffer)
      call buffer%line(trim(merge(', ', '  ', i < of_contacts)))
    end do
    call buffer%line('}')
  end subroutine write_json

  !> Scene and provenance alone.
  subroutine write_json_scene(scene_in, inputs, results, buffer)
    type(scene), intent(in) :: scene_in         !! what was solved
    type(input_file), intent(in) :: inputs(3)   !! the files that it is made of
    type(scene_results), intent(in) :: results  !! results of the run
    type(text_buffer), intent(inout) :: buffer  !! gets the text

    call buffer%line('{')
    call put_scene(scene_in, inputs, results, buffer)
    call buffer%line('}')
  end subroutine write_json_scene

  ! The members `scene` and `provenance`, without a comma at the end.
  subroutine put_scene(scene_in, inputs, results, buffer)
    type(scene), intent(in) :: scene_in
    type(input_file), intent(in) :: inputs(3)
    type(scene_results), intent(in) :: results
    type(text_buffer), intent(inout) :: buffer
    integer :: i

    call buffer%line('"scene": {"file": ' // json_text(scene_in%file) // ',')
    call put_units(scene_in, buffer)
    call buffer%line('"text": ' // json_text(scene_in%text) // '},')
    call buffer%line('"provenance": {"version": "' // version // '",')
    call buffer%line('"arithmetic": "' // trim(results%arithmetic) // '",')
    call buffer%append('"effects": {')
    if (allocated(results%effects)) then
      do i = 1, size(results%effects%names)
        if (i > 1) call buffer%append(', ')
        call buffer%append('"' // trim(results%effects%names(i)) // '": "' // &
                           trim(effect_words(results%effects%modes(i))) // '"')
      end do
    end if
    call buffer%line('},')
    if (allocated(results%effects)) &
      call buffer%line('"tolerance": ' // real_text(results%effects%tolerance, 'es25.16e3') // ',')
    call buffer%append('"inputs": [')
    do i = 1, size(inputs)
      if (inputs(i)%path == '') cycle
      if (i > 1) call buffer%line(',')
      call buffer%append('{"file": ' // json_text(inputs(i)%path) // ', "checksum": "' // &
                         inputs(i)%checksum // '"}')
    end do
    call buffer%append(']}')
  end subroutine put_scene

  ! The unit of each column of a table.
  subroutine put_column_units(name, scene_in, table, buffer)
    character(len=*), intent(in) :: name
    type(scene), intent(in) :: scene_in
    type(array_table), intent(in) :: table
    type(text_buffer), intent(inout) :: buffer
    integer :: i

    call buffer%append('"' // name // '": {')
    do i = 1, size(table%columns)
      if (i > 1) call buffer%append(',')
      if (i > 1 .and. mod(i, 8) == 1) call buffer%append(new_line('a'))
      call buffer%append('"' // table%columns(i)%name // '": ' // &
                         json_text(trim(unit_of(scene_in, table%columns(i)%dimension))))
    end do
    call buffer%append('}')
  end subroutine put_column_units

  !> A table alone, with the units of the scene.
  subroutine write_json_table(scene_in, name, table, buffer)
    type(scene), intent(in) :: scene_in         !! what was solved
    character(len=*), intent(in) :: name        !! name of the table
    type(array_table), intent(in) :: table      !! table with columns
    type(text_buffer), intent(inout) :: buffer  !! gets the text

    call buffer%line('{')
    call put_units(scene_in, buffer)
    call put_table(name, table, buffer)
    call buffer%line('}')
  end subroutine write_json_table

  ! The units, where they are known.
  subroutine put_units(scene_in, buffer)
    type(scene), intent(in) :: scene_in
    type(text_buffer), intent(inout) :: buffer

    if (has_units(scene_in)) &
      call buffer%line('"units": {"length": ' // json_text(trim(scene_in%units(1))) // &
                       ', "force": ' // json_text(trim(scene_in%units(2))) // '},')
  end subroutine put_units

  ! Lines as a list of texts.
  subroutine put_lines(name, lines, buffer)
    character(len=*), intent(in) :: name, lines
    type(text_buffer), intent(inout) :: buffer
    integer :: first, last

    call buffer%append('"' // name // '": [')
    first = 1
    do while (first <= len(lines))
      last = first + index(lines(first:), new_line('a')) - 2
      if (first > 1) call buffer%line(',')
      call buffer%append(json_text(lines(first:last)))
      first = last + 2
    end do
    call buffer%line('],')
  end subroutine put_lines

  ! A table: a list a column.
  subroutine put_table(name, table, buffer)
    character(len=*), intent(in) :: name
    type(array_table), intent(in) :: table
    type(text_buffer), intent(inout) :: buffer
    integer(int64) :: row
    integer :: i

    call buffer%line('"' // name // '": {')
    do i = 1, size(table%columns)
      associate (column => table%columns(i))
        call buffer%append('"' // column%name // '": [')
        do row = 1_int64, table%rows
          if (row > 1_int64) call buffer%append(',')
          ! A line of bearable length, for editors.
          if (row > 1_int64 .and. mod(row, 8_int64) == 1_int64) call buffer%append(new_line('a'))
          if (allocated(column%letters)) then
            call buffer%append(json_text(trim(transfer(column%letters(:, row), &
                                                       repeat('a', size(column%letters, 1))))))
          else
            call put_cell(column, row, 'null', buffer)
          end if
        end do
        call buffer%append(']')
      end associate
      if (i < size(table%columns)) call buffer%line(',')
    end do
    call buffer%append('}')
  end subroutine put_table

  ! A text in quotes. Bytes that are no UTF-8 become question marks.
  pure function json_text(text) result(in_quotes)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: in_quotes
    type(text_buffer) :: buffer
    character(len=len(text)) :: shown
    character(len=6) :: escape
    integer :: i

    shown = printable_text(text)
    call buffer%append('"')
    do i = 1, len(text)
      select case (iachar(text(i:i)))
      case (10)
        call buffer%append('\n')
      case (0:9, 11:31)
        write (escape, '("\u", z4.4)') iachar(text(i:i))
        call buffer%append(escape)
      case (34, 92)
        call buffer%append('\' // text(i:i))
      case default
        call buffer%append(shown(i:i))
      end select
    end do
    call buffer%append('"')
    in_quotes = buffer%text()
  end function json_text

end module asperity_results_json
