!> The command `asperity solve SCENE`: scene, present-day solver, summary and CSV files.
module asperity_run_solve
  use, intrinsic :: iso_c_binding, only: c_int
  use asperity_command_line, only: command_line, is_shared, refuse_input
  use asperity_command_outcome, only: command_outcome
  use asperity_contact_field, only: contact_field, fields_all, fields_last
  use asperity_csv_tables, only: stress_cells, stress_columns, stress_table, write_histogram, &
                                 write_table
  use asperity_files, only: same_name, write_standard_error
  use asperity_images, only: image_count, image_number, is_image_build
  use asperity_input_text, only: lower_case
  use asperity_kinds, only: int64, not_computed, real64
  use asperity_map_stress, only: check_stress, largest_stress, look_for_largest, no_ratio, &
                                 stress_solver
  use asperity_number_format, only: count_text, number_text
  use asperity_output_files, only: close_part, open_part
  use asperity_problems, only: decimal_text, problem_list
  use asperity_process, only: check_memory
  use asperity_result_table, only: array_table, make_arrays
  use asperity_results_json, only: write_json, write_json_table
  use asperity_results_vtk, only: write_vti, write_vts
  use asperity_run_options, only: run_options, totals_of_accuracy
  use asperity_scene_inputs, only: input_file, list_inputs
  use asperity_scene_reader, only: read_scene
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: scene
  use asperity_solve, only: solve
  use asperity_surface_fields, only: check_field_request
  use asperity_summary, only: write_choice, write_summary
  use asperity_text_buffer, only: text_buffer
  use asperity_unit_names, only: has_units, is_length, is_pressure, unit_of, units_in_words, &
                                 with_unit
  use asperity_warning_lines, only: list_warnings
  implicit none
  private

  public :: run_solve_command

  ! Options of files that have tables of the results, and whether they need the positions, the
  ! states and the contacts.
  character(len=*), parameter :: table_options(4) = [character(len=11) :: '--contacts', &
    '--positions', '--curve', '--json']
  logical, parameter :: tables_of(3, 4) = reshape([.false., .false., .true., .true., .false., &
    .false., .false., .true., .false., .true., .true., .true.], [3, 4])
  ! Options that need the pressure on the pixels of a map.
  character(len=*), parameter :: field_options(3) = [character(len=11) :: '--fields', &
    '--histogram', '--depths']
  ! States that --fields-of all writes at most: a file each.
  integer, parameter :: most_states = 1000

contains

  ! Long: its stages share the results and the outcome, in procedures of one call each.
  !> Runs the command. All is computed before the first byte is written, beside the positions that
  !> are kept. Image 1 has all results and writes for all.
  subroutine run_solve_command(line, outcome)
    type(command_line), intent(in) :: line           !! the user's choices
    type(command_outcome), intent(inout) :: outcome  !! messages, text and files
    type(scene) :: scene_in
    type(scene_results) :: results
    type(run_options) :: options
    type(array_table) :: tables(3)  ! positions, states, contacts; those that outputs need
    character(len=:), allocatable :: units  ! first line of CSV files; not allocated: none
    integer :: first, i, k, last, number

    call read_scene(line%input, scene_in, outcome%problems)
    if (outcome%problems%count() == 0) call check_choices(line, scene_in, outcome%problems)
    if (outcome%problems%count() > 0) return
    if (image_number() == 1) call write_standard_error(scene_in%notes%text())
    call note_copies(line%input, scene_in%motion%positions)
    options = options_of(line)
    if (line%has('--units')) units = 'units: ' // units_in_words(scene_in)
    call solve(scene_in, results, outcome%failure, options)
    if (image_number() > 1) return
    if (allocated(outcome%failure)) then
      outcome%failure = line%input // ': ' // outcome%failure
      return
    end if
    if (any(line%has(field_options))) then
      last = size(results%positions)
      first = merge(1, last, line%choice('--fields-of') == fields_all)
      number = sum([(size(results%positions(i)%fields), i=first, last)])
      if (number > most_states) then
        outcome%failure = line%input // ': --fields-of all: found ' // decimal_text(number) // &
          ' states, expected at most ' // decimal_text(most_states)
        return
      end if
    end if
    if (line%share(2) > 1) then
      if (.not. line%has('--quiet')) &
        call outcome%text%line('part ' // decimal_text(line%share(1)) // ' of ' // &
          decimal_text(line%share(2)) // ': ' // decimal_text(size(results%positions)) // &
          ' positions are saved in ' // line%output_path('--keep') // &
          '; the outputs come from a run with the files of all parts')
      return
    end if
    call list_warnings(line%input, results, outcome%warnings)
    if (.not. line%has('--quiet')) then
      call write_summary(scene_in, results, outcome%text)
      if (line%has('--accuracy')) &
        call write_choice(line%number('--accuracy'), results, outcome%text)
    end if
    do i = 1, size(tables)
      if (.not. allocated(outcome%failure) .and. any(tables_of(i, :) .and. &
                                                     line%has(table_options))) &
        call make_arrays(i, results, tables(i), outcome%failure)
    end do
    do i = 1, size(table_options)
      if (.not. allocated(outcome%failure) .and. line%has(table_options(i))) &
        call stage_tables(i)
    end do
    if (any(line%has(field_options))) then
      number = 0
      do i = first, last
        do k = 1, size(results%positions(i)%fields)
          number = number + 1
          call stage_field(results%positions(i)%fields(k), results%positions(i)%states%time)
        end do
      end do
      if (line%has('--histogram')) call stage_histogram(results%positions(last)%fields)
    end if
    if (allocated(line%depths)) call stage_stress()

  contains

    ! Stages the file of an option of `table_options`.
    subroutine stage_tables(option)
      integer, intent(in) :: option
      type(input_file) :: inputs(3)
      type(text_buffer) :: text

      select case (table_options(option))
      case ('--json')
        call list_inputs(scene_in, inputs, outcome%failure)
        if (allocated(outcome%failure)) return
        call write_json(scene_in, inputs, results, tables, outcome%warnings, text)
      case default
        call write_table(tables(findloc(tables_of(:, option), .true., 1)), text, units)
      end select
      call outcome%stage_text(line%output_path(trim(table_options(option))), text)
    end subroutine stage_tables

    ! One state as image data.
    subroutine stage_field(field, times)
      type(contact_field), intent(in) :: field
      real(real64), intent(in) :: times(:)  ! of all states of its position
      character(len=:), allocatable :: path
      integer(c_int) :: descriptor
      character(len=5) :: ending
      integer :: dot

      if (.not. line%has('--fields') .or. allocated(outcome%failure)) return
      path = line%output_path('--fields')
      if (line%choice('--fields-of') == fields_all) then
        ! `NAME_0001.vti`, by the row of the table of states.
        write (ending, '("_", i4.4)') number
        dot = index(path, '.', back=.true.)
        if (dot <= index(path, '/', back=.true.) + 1) dot = len(path) + 1
        path = path(:dot - 1) // ending // path(dot:)
      end if
      call open_part(path, descriptor, outcome%failure)
      if (allocated(outcome%failure)) return
      call write_vti(field, merge(times(field%state), not_computed, any(times > 0.0_real64)), &
                     descriptor, outcome%failure)
      call close_part(path, descriptor, outcome%failure)
    end subroutine stage_field

    ! The pressures of the last state as a histogram.
    subroutine stage_histogram(fields)
      type(contact_field), intent(in) :: fields(:)
      type(text_buffer) :: histogram

      call write_histogram(fields(size(fields)), histogram, units)
      call outcome%stage_text(line%output_path('--histogram'), histogram)
    end subroutine stage_histogram

    ! The largest stresses of the last state in a body as text, all of them as a file.
    subroutine stage_stress()
      character(len=*), parameter :: names(2) = [character(len=20) :: 'von Mises stress', &
        'largest shear stress']
      type(stress_solver) :: solver
      type(largest_stress) :: largest(2)
      type(text_buffer) :: file
      real(real64), allocatable :: cells(:, :), stress(:, :, :)
      character(len=:), allocatable :: path, text, under
      integer :: body

      path = lower_case(line%output_path('--stress'))
      body = merge(1, 2, line%choice('--body') == 2)
      under = 'the normal pressures'
      associate (field => results%positions(last)%fields(size(results%positions(last)%fields)), &
                 depths => size(line%depths))
        if (allocated(field%traction)) under = 'pressures and tractions'
        call check_stress(field, line%depths(1), scene_in%bodies(body), outcome%failure)
        ! Cells, their copy by columns of all depths.
        if (.not. allocated(outcome%failure)) call check_memory('the stresses', outcome%failure, &
            bytes=16_int64 * stress_columns * depths * field%columns * field%rows)
        if (allocated(outcome%failure)) outcome%failure = line%input // ': ' // outcome%failure
        if (allocated(outcome%failure)) return
        call solver%prepare(field, scene_in%bodies(body), body == 1)
        associate (pixels => field%columns * field%rows)
          allocate (cells(merge(0, pixels * depths, path == ''), stress_columns))
          do i = 1, depths
            call solver%solve(line%depths(i), stress)
            call look_for_largest(field, line%depths(i), stress, largest)
            if (path /= '') cells((i - 1) * pixels + 1:i * pixels, :) = &
              stress_cells(field, line%depths(i), stress)
          end do
        end associate
        select case (path(max(1, index(path, '.', back=.true.)):))
        case ('.json')
          call write_json_table(scene_in, 'stress', stress_table(cells), file)
        case ('.vts')
          call write_vts(stress_table(cells), [field%columns, field%rows, depths], file)
        case default
          call write_table(stress_table(cells), file, units)
        end select
      end associate
      call outcome%stage_text(line%output_path('--stress'), file)
      if (line%has('--quiet')) return
      call outcome%text%line('')
      call outcome%text%line('Stress in the ' // merge('upper', 'lower', body == 1) // &
                             ' body under ' // under // ', largest of the depths')
      do i = 1, size(largest)
        text = '  ' // with_unit(trim(names(i)), trim(unit_of(scene_in, is_pressure))) // ' ' // &
               number_text(largest(i)%value) // ' at depth ' // number_text(largest(i)%depth) // &
               ', x ' // number_text(largest(i)%x) // ', y ' // number_text(largest(i)%y)
        text = with_unit(text, trim(unit_of(scene_in, is_length)))
        if (largest(i)%on_rim) text = text // ': on the rim of the contact, grows with resolution'
        call outcome%text%line(text)
      end do
    end subroutine stage_stress

  end subroutine run_solve_command

  ! Notes copies of the program that a launcher has started in vain: images without a position, or
  ! without coarrays whole runs that share no work.
  subroutine note_copies(path, positions)
    character(len=*), intent(in) :: path  ! the scene
    integer, intent(in) :: positions      ! number of its positions
    character(len=*), parameter :: names(2, 3) = reshape([character(len=20) :: &
      'OMPI_COMM_WORLD_RANK', 'OMPI_COMM_WORLD_SIZE', 'PMI_RANK', 'PMI_SIZE', 'SLURM_PROCID', &
      'SLURM_STEP_NUM_TASKS'], [2, 3])
    character(len=12) :: found(2)
    integer :: copies, i, k, of_read, status(2)

    if (image_number() == 1 .and. image_count() > positions) &
      call write_standard_error(path // ': note: ' // decimal_text(image_count() - positions) // &
        ' of ' // decimal_text(image_count()) // ' images have no position to solve' // &
        new_line(path))
    if (is_image_build()) return
    do i = 1, size(names, 2)
      do k = 1, 2
        call get_environment_variable(names(k, i), found(k), status=status(k))
      end do
      copies = 0
      of_read = 0
      if (all(status == 0)) read (found(2), *, iostat=of_read) copies
      if (any(status /= 0) .or. of_read /= 0 .or. copies < 2 .or. found(1) /= '0') cycle
      call write_standard_error(path // ': note: a launcher has started this program ' // &
        decimal_text(copies) // ' times, each solves all of the scene, expected a build with' // &
        ' coarrays, or --share for a part of the positions' // new_line(path))
      exit
    end do
  end subroutine note_copies

  ! Checks that the command line and the scene agree.
  subroutine check_choices(line, scene_in, problems)
    type(command_line), intent(in) :: line
    type(scene), intent(in) :: scene_in
    type(problem_list), intent(inout) :: problems
    character(len=:), allocatable :: option
    integer :: i

    call refuse_input(line, scene_in%upper%file, problems)
    if (.not. same_name(scene_in%lower%file, scene_in%upper%file)) &
      call refuse_input(line, scene_in%lower%file, problems)
    if (line%has('--units') .and. .not. has_units(scene_in)) &
      call problems%add('--units: the scene does not name its units, expected for instance ' // &
                        'units = ''mm'', ''N'' in &surfaces')
    if (line%has('--depths') .and. scene_in%contact_modulus > 0.0_real64) &
      call problems%add('--depths: ' // no_ratio)
    ! Pressure on pixels is that of a height map solved on them, and is not kept in a file.
    do i = 1, size(field_options)
      if (.not. line%has(field_options(i))) cycle
      option = trim(field_options(i))
      call check_field_request(scene_in, option, problems)
      if (line%has('--keep')) &
        call problems%add(option // ': a file of --keep has no pressure on pixels, expected ' // &
                          'one of both')
    end do
    if (line%share(2) > scene_in%motion%positions) &
      call problems%add('--share: found ' // decimal_text(line%share(2)) // ' parts of ' // &
                        count_text(scene_in%motion%positions, 'position') // &
                        ', expected at most as many parts as positions')
  end subroutine check_choices

  ! How the user wants it done.
  function options_of(line) result(options)
    type(command_line), intent(in) :: line
    type(run_options) :: options

    options%accuracy = line%number('--accuracy')
    if (line%has('--of')) options%accuracy_of = totals_of_accuracy(line%choice('--of'))
    options%keep_contacts = any(line%has([character(len=11) :: &
      '--contacts', '--json', field_options]))
    if (any(line%has(field_options))) options%fields = max(fields_last, line%choice('--fields-of'))
    options%threads = line%choice('--threads')
    options%progress = image_number() == 1
    options%all_images = is_shared(line)
    options%keep_file = line%output_path('--keep')
    options%part = line%share(1)
    options%parts = line%share(2)
    if (allocated(line%parts)) allocate (options%more_files, source=line%parts)
  end function options_of

end module asperity_run_solve
