!> Outcome of a call of the library for C, as memory that C reads: texts that end with a null
!> character, tables, problems; and the checks and copies of its arguments.
!>
!> Calls may run at once in several threads, but texts are written by one at a time, in
!> `critical (library_texts)`: gfortran keeps the length of a function's `character(len=:)` result
!> in static memory. What a solve does outside has no such function.
module asperity_c_outcome
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_pointer, c_int, &
                                         c_loc, c_null_char, c_null_ptr, c_ptr
  use, intrinsic :: iso_fortran_env, only: int64, real64
  use asperity, only: add_reals, array_table, contact_field, decimal_text, generation_spec, &
                      height_map, is_measured, list_groups, most_samples, not_enough_memory, &
                      parse_generation_spec, plain_unit, plane_surface, problem_list, &
                      problem_place, read_generation_spec, scene, scene_surface, solution_start, &
                      take_map, take_surface
  use asperity_system_calls, only: text_of
  implicit none
  private

  public :: c_height_map, c_letters, c_surface, outcome
  public :: add_pixels, begin_outcome, find_column, finish_outcome, finish_scene, look_at, &
            set_text, text_of
  public :: require_text, take_asperities, take_heights, take_spec, take_word

  !> Numbers of the header: status of a call, texts, tables, types of columns.
  integer(c_int), parameter, public :: done = 0_c_int, not_computed = 1_c_int, bad_input = 2_c_int
  integer, parameter, public :: text_failure = 1, text_problems = 2, text_warnings = 3, &
                                text_notes = 4, text_report = 5, text_warning_kinds = 6, &
                                text_unit = 7, text_groups = 8, texts = 8
  !> The first three are those of a run; the lower surface follows the upper one, the spectra of
  !> lines along x and along y that of the area.
  integer, parameter, public :: table_summits = 4, table_statistics = 5, table_upper = 6, &
                                table_map = 8, table_pixels = 9, table_fields = 10, &
                                table_spectra = 11, tables = 13
  integer(c_int), parameter, public :: type_double = 1_c_int, type_int = 2_c_int, &
                                       type_word = 3_c_int

  !> A text that ends with a null character.
  type :: c_letters
    character(kind=c_char), allocatable :: letters(:)  !! characters with the final null
  end type c_letters

  !> Outcome of a call.
  type :: outcome
    integer(c_int) :: status = done                        !! status of the call
    type(scene), allocatable :: scene_in                   !! scene that was read or built
    type(c_letters) :: texts(texts)                        !! texts by the `text_` numbers
    type(array_table) :: tables(tables)                    !! tables by the `table_` numbers
    type(problem_list) :: problems                         !! problems of the input
    type(c_letters), allocatable :: files(:), messages(:)  !! file and message of each problem
    type(problem_place), allocatable :: places(:)          !! place of each problem
    type(c_letters), allocatable :: names(:, :)            !! names of columns (column, table)
    type(c_letters), allocatable :: units(:, :)            !! units of columns (column, table)
    type(solution_start), allocatable :: solutions(:)      !! by position, for further solves
    type(contact_field), allocatable :: fields(:)          !! fields of the states that keep them
    real(real64), allocatable :: ratio                     !! Poisson's of the lower body, if known
    character(len=:), allocatable :: failure               !! reason, when it was not computed
  end type outcome

  !> `asperity_surface` of the header.
  type, bind(c) :: c_surface
    integer(c_int) :: asperities        !! number of asperities; 0: a plane
    integer(c_int) :: radii             !! number of radii: 1, or one for each
    type(c_ptr) :: x, y, height, radius !! addresses of their numbers
  end type c_surface

  !> `asperity_height_map` of the header.
  type, bind(c) :: c_height_map
    integer(c_int) :: columns, rows     !! pixels along x and along y
    type(c_ptr) :: height               !! (column, row); NaN where missing
    real(c_double) :: pixel_spacing(2)  !! along x and y; 0, 0: not given
    type(c_ptr) :: unit                 !! name; null or empty: none
    integer(c_int) :: periodic          !! 1: yes, 0: no, -1: unknown
  end type c_height_map

contains

  !> Allocates an outcome, unless memory is short.
  subroutine begin_outcome(new, handle)
    type(outcome), pointer, intent(out) :: new  !! not associated: memory is short
    type(c_ptr), intent(out) :: handle          !! address of the outcome for C
    integer :: status

    handle = c_null_ptr
    allocate (new, stat=status)
    if (status /= 0) nullify (new)
    if (associated(new)) handle = c_loc(new)
  end subroutine begin_outcome

  !> Fills the parts of an outcome that C reads: status, messages, tables and texts.
  subroutine finish_outcome(new)
    type(outcome), intent(inout) :: new  !! outcome of a finished call
    character(len=:), allocatable :: text
    integer :: column, first, i, last, table

    text = new%problems%text()
    if (new%problems%lacks_memory) new%failure = text(:len(text) - 1)
    call set_text(new, text_problems, text)
    associate (lines => count([(text(i:i) == new_line('a'), i = 1, len(text))]))
      allocate (new%files(lines), new%messages(lines), new%places(lines))
    end associate
    first = 1
    do i = 1, size(new%messages)
      last = first + index(text(first:), new_line('a')) - 2
      new%places(i) = new%problems%place(i)
      call set_letters(new%files(i), text(first:first + new%places(i)%file_length - 1))
      call set_letters(new%messages(i), text(first + new%places(i)%prefix:last))
      first = last + 2
    end do
    allocate (new%names(maxval([(columns_of(new%tables(i)), i = 1, tables)]), tables))
    allocate (new%units(size(new%names, 1), tables))
    do table = 1, tables
      do column = 1, columns_of(new%tables(table))
        associate (of => new%tables(table)%columns(column))
          call set_letters(new%names(column, table), of%name)
          if (allocated(of%unit)) call set_letters(new%units(column, table), of%unit)
        end associate
      end do
    end do
    if (allocated(new%failure)) then
      new%status = not_computed
      call set_text(new, text_failure, new%failure)
    end if
    if (size(new%messages) > 0 .and. .not. new%problems%lacks_memory) new%status = bad_input
  end subroutine finish_outcome

  !> Fills an outcome with a scene, including the groups of the scene as text.
  subroutine finish_scene(new)
    type(outcome), intent(inout) :: new  !! outcome with the scene

    if (new%problems%count() == 0) call set_text(new, text_groups, list_groups(new%scene_in))
    call finish_outcome(new)
  end subroutine finish_scene

  !> Finds the outcome of a handle.
  subroutine look_at(handle, it)
    type(c_ptr), intent(in) :: handle          !! address of the outcome; null: none
    type(outcome), pointer, intent(out) :: it  !! outcome; not associated: none

    nullify (it)
    if (c_associated(handle)) call c_f_pointer(handle, it)
  end subroutine look_at

  !> Finds the outcome that has a column in a table.
  subroutine find_column(handle, table, column, it)
    type(c_ptr), intent(in) :: handle            !! address of the outcome; null: none
    integer(c_int), intent(in) :: table, column  !! numbers as in C: a column counts from 0
    type(outcome), pointer, intent(out) :: it    !! outcome; not associated: no such column

    call look_at(handle, it)
    if (.not. associated(it)) return
    if (table >= 1_c_int .and. table <= tables .and. column >= 0_c_int) then
      if (column < columns_of(it%tables(table))) return
    end if
    nullify (it)
  end subroutine find_column

  pure integer function columns_of(table)
    type(array_table), intent(in) :: table

    columns_of = 0
    if (allocated(table%columns)) columns_of = size(table%columns)
  end function columns_of

  !> Adds the values of pixels to a table, row by row of the map; NaN where one is missing.
  !> `failure` is allocated when memory is short; the table has no columns then.
  subroutine add_pixels(table, name, values, unit, failure)
    type(array_table), intent(inout) :: table   !! table of pixels
    character(len=*), intent(in) :: name        !! of the column
    real(real64), intent(in) :: values(:, :)    !! by column and row of the map
    character(len=*), intent(in) :: unit        !! of the values; empty: none
    character(len=:), allocatable, intent(inout) :: failure  !! reason, when memory is short
    real(real64), allocatable :: cells(:)
    integer :: j, status

    if (allocated(failure)) return
    allocate (cells(size(values)), stat=status)
    if (status /= 0) then
      failure = not_enough_memory // ' for the pixels as arrays'
      if (allocated(table%columns)) deallocate (table%columns)
      table%rows = 0
      return
    end if
    do j = 1, size(values, 2)
      cells((j - 1) * size(values, 1) + 1:j * size(values, 1)) = &
        merge(values(:, j), ieee_value(0.0_real64, ieee_quiet_nan), is_measured(values(:, j)))
    end do
    call add_reals(table, name, cells, unit)
  end subroutine add_pixels

  !> Sets one of the texts.
  subroutine set_text(new, which, text)
    type(outcome), intent(inout) :: new   !! outcome with the text
    integer, intent(in) :: which          !! one of the `text_` numbers
    character(len=*), intent(in) :: text  !! text without a null character

    call set_letters(new%texts(which), text)
  end subroutine set_text

  subroutine set_letters(letters, text)
    type(c_letters), intent(inout) :: letters
    character(len=*), intent(in) :: text

    letters%letters = transfer(text // c_null_char, [c_null_char])
  end subroutine set_letters

  !> Takes the asperities of a surface, or a plane.
  subroutine take_asperities(which, given, surface, problems)
    character(len=*), intent(in) :: which          !! name of the surface, for the messages
    type(c_ptr), intent(in) :: given               !! address of a `c_surface`
    type(scene_surface), intent(out) :: surface    !! copy of the surface
    type(problem_list), intent(inout) :: problems  !! faults of the argument
    type(c_surface), pointer :: numbers
    real(c_double), pointer :: x(:), y(:), height(:), radius(:)
    integer :: before

    if (.not. c_associated(given)) then
      call problems%add(which // ': found NULL beside a surface that is given as arrays, ' // &
                        'expected both, or a plane')
      return
    end if
    call c_f_pointer(given, numbers)
    if (numbers%asperities == 0_c_int) then
      surface = plane_surface()
      return
    end if
    before = problems%count()
    if (numbers%asperities < 0_c_int) then
      call problems%add(which // '.count: found ' // decimal_text(numbers%asperities) // &
                        ', expected 0 for a plane, or more')
    else if (all(numbers%radii /= [1_c_int, numbers%asperities])) then
      call problems%add(which // '.radii: found ' // decimal_text(numbers%radii) // &
                        ', expected 1 or ' // decimal_text(numbers%asperities) // ', as many as x')
    end if
    call require_numbers(which // '.x', numbers%x, problems)
    call require_numbers(which // '.y', numbers%y, problems)
    call require_numbers(which // '.height', numbers%height, problems)
    call require_numbers(which // '.radius', numbers%radius, problems)
    if (problems%count() == before) then
      call c_f_pointer(numbers%x, x, [numbers%asperities])
      call c_f_pointer(numbers%y, y, [numbers%asperities])
      call c_f_pointer(numbers%height, height, [numbers%asperities])
      call c_f_pointer(numbers%radius, radius, [numbers%radii])
      call take_surface(which, x, y, height, radius, surface, problems)
    end if
  end subroutine take_asperities

  !> Takes a height map. `failure` is allocated when memory is short.
  subroutine take_heights(which, given, map, problems, failure)
    character(len=*), intent(in) :: which          !! name of the map, for the messages
    type(c_ptr), intent(in) :: given               !! address of a `c_height_map`
    type(height_map), intent(out) :: map           !! copy of the map
    type(problem_list), intent(inout) :: problems  !! faults of the argument
    character(len=:), allocatable, intent(out) :: failure  !! reason, when there is no map
    type(c_height_map), pointer :: numbers
    real(c_double), pointer :: height(:, :)
    integer :: before

    if (.not. c_associated(given)) then
      call problems%add(which // ': found NULL, expected a height map')
      return
    end if
    call c_f_pointer(given, numbers)
    before = problems%count()
    if (numbers%columns < 1_c_int) &
      call problems%add(which // '.columns: found ' // decimal_text(numbers%columns) // &
                        ', expected 3 or more')
    if (numbers%rows < 1_c_int) &
      call problems%add(which // '.rows: found ' // decimal_text(numbers%rows) // &
                        ', expected 3 or more')
    if (abs(numbers%periodic) > 1_c_int) &
      call problems%add(which // '.periodic: found ' // decimal_text(numbers%periodic) // &
                        ', expected 1, 0, or -1 where it is not known')
    call require_numbers(which // '.height', numbers%height, problems)
    if (problems%count() > before) return
    if (int(numbers%columns, int64) * numbers%rows > most_samples) then
      call problems%add(which // ': found ' // decimal_text(numbers%columns) // ' x ' // &
                        decimal_text(numbers%rows) // ' pixels, expected at most ' // &
                        decimal_text(most_samples))
      return
    end if
    call c_f_pointer(numbers%height, height, [numbers%columns, numbers%rows])
    call take_map(which, height, numbers%pixel_spacing, text_of(numbers%unit), &
                  int(numbers%periodic) + 1, map, problems, failure)
  end subroutine take_heights

  ! Refuses an array that is missing.
  subroutine require_numbers(name, address, problems)
    character(len=*), intent(in) :: name
    type(c_ptr), intent(in) :: address
    type(problem_list), intent(inout) :: problems

    if (.not. c_associated(address)) call problems%add(name // ': found NULL, expected numbers')
  end subroutine require_numbers

  !> Refuses a path that is missing.
  subroutine require_text(name, address, problems)
    character(len=*), intent(in) :: name           !! name of the argument
    type(c_ptr), intent(in) :: address             !! address of the path
    type(problem_list), intent(inout) :: problems  !! faults of the argument

    if (.not. c_associated(address)) then
      call problems%add(name // ': found NULL, expected a path')
    else if (text_of(address) == '') then
      call problems%add(name // ': found an empty text, expected a path')
    end if
  end subroutine require_text

  !> Reads a specification of surfaces or a map: a file, or the text of its groups.
  subroutine take_spec(path, groups, spec, problems)
    type(c_ptr), intent(in) :: path                !! path of the file, where `groups` is null
    type(c_ptr), intent(in) :: groups              !! text of its groups; may be null
    type(generation_spec), intent(out) :: spec     !! specification that was read
    type(problem_list), intent(inout) :: problems  !! faults of the argument

    if (c_associated(groups)) then
      call parse_generation_spec('specification', text_of(groups), spec, problems)
    else
      call require_text('specification', path, problems)
      if (problems%count() == 0) call read_generation_spec(text_of(path), spec, problems)
    end if
  end subroutine take_spec

  !> Finds a word in a list; a null pointer leaves the choice unchanged.
  subroutine take_word(name, word, known, choice, problems)
    character(len=*), intent(in) :: name           !! name of the argument
    type(c_ptr), intent(in) :: word                !! address of its text
    character(len=*), intent(in) :: known(:)       !! list of the words
    integer, intent(inout) :: choice               !! number of the word; 0: none
    type(problem_list), intent(inout) :: problems  !! faults of the argument
    character(len=:), allocatable :: list
    integer :: i

    if (.not. c_associated(word)) return
    choice = findloc(known == plain_unit(text_of(word)), .true., 1)
    if (choice > 0) return
    list = trim(known(1))
    do i = 2, size(known)
      list = list // ', ' // trim(known(i))
    end do
    call problems%add(name // ': found ' // text_of(word) // ', expected one of ' // list)
  end subroutine take_word

end module asperity_c_outcome
