!> Outcome of a call of the library for C, as memory that C reads: texts that end with a null
!> character, tables, problems; how it is filled, what C reads of it, and its release.
!>
!> Calls may run at once in several threads, but texts are written by one at a time:
!> `asperity_library_turn` has the reason.
module asperity_c_outcome
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_int, c_int64_t, &
                                         c_loc, c_null_char, c_null_ptr, c_ptr
  use, intrinsic :: iso_fortran_env, only: int64, real64
  use asperity, only: add_reals, array_table, contact_field, is_measured, list_groups, &
                      not_enough_memory, problem_list, problem_place, scene, version
  use asperity_library_turn, only: library_turn
  use asperity_process, only: check_memory
  use asperity_system_calls, only: text_of
  implicit none
  private

  public :: outcome, begin_outcome, finish_outcome, add_pixels, finish_scene, look_at, set_text, &
            text_of
  public :: c_version, c_status, c_text, c_problems, c_get_problem
  public :: c_rows, c_columns, c_column_name, c_column_type, c_column_unit, c_column, c_free

  !> Numbers of the header: status of a call, texts, tables, types of columns.
  integer(c_int), parameter, public :: done = 0_c_int, not_computed = 1_c_int, bad_input = 2_c_int
  integer, parameter, public :: text_failure = 1, text_problems = 2, text_warnings = 3, &
                                text_notes = 4, text_report = 5, text_warning_kinds = 6, &
                                text_unit = 7, text_groups = 8, text_scene = 9, &
                                text_methods = 10, texts = 10
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

  !> Fields of the states of a position that keep them.
  type :: kept_fields
    type(contact_field), allocatable :: fields(:)  !! not allocated: none
  end type kept_fields

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
    type(kept_fields), allocatable :: kept(:)              !! by position
    character(len=:), allocatable :: failure               !! reason, when it was not computed
  contains
    procedure :: is_good                                   !! no problem was found, nothing failed
  end type outcome

  !> `asperity_problem` of the header.
  type, bind(c) :: c_problem
    type(c_ptr) :: file      !! empty: it has none
    integer(c_int) :: line, column  !! 0: it has none
    type(c_ptr) :: text      !! without file, line and column
  end type c_problem

  ! Texts that are always there: constants, which can have no address in Fortran.
  integer :: letter
  character(kind=c_char), target :: no_text_letters(1) = c_null_char
  character(kind=c_char), target :: no_memory_letters(len(not_enough_memory) + 1) = &
    [(not_enough_memory(letter:letter), letter = 1, len(not_enough_memory)), c_null_char]
  character(kind=c_char), target :: version_letters(len(version) + 1) = &
    [(version(letter:letter), letter = 1, len(version)), c_null_char]

contains

  !> Allocates an outcome, unless memory is short, and begins the turn of its thread.
  subroutine begin_outcome(new, handle, turn)
    type(outcome), pointer, intent(out) :: new  !! not associated: memory is short
    type(c_ptr), intent(out) :: handle          !! address of the outcome for C
    type(library_turn), intent(inout) :: turn   !! turn that has not begun
    integer :: status

    handle = c_null_ptr
    allocate (new, stat=status)
    if (status /= 0) nullify (new)
    if (.not. associated(new)) return
    handle = c_loc(new)
    call turn%begin()
  end subroutine begin_outcome

  !> Whether a call has found no problem and has not failed.
  pure logical function is_good(self)
    class(outcome), intent(in) :: self  !! outcome of the call

    is_good = self%problems%count() == 0 .and. .not. allocated(self%failure)
  end function is_good

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

  ! Finds the outcome that has a column in a table.
  subroutine find_column(handle, table, column, it)
    type(c_ptr), intent(in) :: handle            ! address of the outcome; null: none
    integer(c_int), intent(in) :: table, column  ! numbers as in C: a column counts from 0
    type(outcome), pointer, intent(out) :: it    ! outcome; not associated: no such column

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
    integer(int64) :: before
    integer :: j

    if (allocated(failure)) return
    ! The cells, their column, and one copy more.
    call check_memory('the pixels as arrays', failure, bytes=24_int64 * size(values, kind=int64))
    if (allocated(failure)) then
      if (allocated(table%columns)) deallocate (table%columns)
      table%rows = 0_int64
      return
    end if
    allocate (cells(size(values, kind=int64)))
    do j = 1, size(values, 2)
      before = (j - 1_int64) * size(values, 1)
      cells(before + 1_int64:before + size(values, 1)) = &
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

  !> `asperity_get_version`.
  type(c_ptr) function c_version() bind(c, name='asperity_get_version')
    c_version = c_loc(version_letters)
  end function c_version

  !> `asperity_status`.
  integer(c_int) function c_status(handle) bind(c, name='asperity_status') result(status)
    type(c_ptr), value :: handle  !! outcome
    type(outcome), pointer :: it

    call look_at(handle, it)
    status = not_computed
    if (associated(it)) status = it%status
  end function c_status

  !> `asperity_text`.
  type(c_ptr) function c_text(handle, which) bind(c, name='asperity_text') result(text)
    type(c_ptr), value :: handle    !! outcome
    integer(c_int), value :: which  !! one of the `text_` numbers
    type(outcome), pointer :: it

    call look_at(handle, it)
    text = c_loc(no_text_letters)
    if (.not. associated(it)) then
      if (which == text_failure) text = c_loc(no_memory_letters)
    else if (which >= 1 .and. which <= texts) then
      if (allocated(it%texts(which)%letters)) text = c_loc(it%texts(which)%letters)
    end if
  end function c_text

  !> `asperity_problem_count`.
  integer(c_int) function c_problems(handle) bind(c, name='asperity_problem_count') result(number)
    type(c_ptr), value :: handle  !! outcome
    type(outcome), pointer :: it

    call look_at(handle, it)
    number = 0_c_int
    if (associated(it)) number = size(it%messages, kind=c_int)
  end function c_problems

  !> `asperity_get_problem`.
  subroutine c_get_problem(handle, number, place) bind(c, name='asperity_get_problem')
    type(c_ptr), value :: handle              !! outcome
    integer(c_int), value :: number           !! of the problem, from 0
    type(c_ptr), value :: place               !! of the problem; empty when there is none
    type(outcome), pointer :: it
    type(c_problem), pointer :: problem

    if (.not. c_associated(place)) return
    call c_f_pointer(place, problem)
    call look_at(handle, it)
    problem = c_problem(c_loc(no_text_letters), 0_c_int, 0_c_int, c_loc(no_text_letters))
    if (.not. associated(it)) return
    if (number < 0_c_int .or. number >= size(it%messages)) return
    problem = c_problem(c_loc(it%files(number + 1)%letters), &
                        int(it%places(number + 1)%line, c_int), &
                        int(it%places(number + 1)%column, c_int), &
                        c_loc(it%messages(number + 1)%letters))
  end subroutine c_get_problem

  !> `asperity_rows`.
  integer(c_int64_t) function c_rows(handle, table) bind(c, name='asperity_rows') result(number)
    type(c_ptr), value :: handle    !! outcome
    integer(c_int), value :: table  !! one of the tables
    type(outcome), pointer :: it

    call find_column(handle, table, 0_c_int, it)
    number = 0_c_int64_t
    if (associated(it)) number = it%tables(table)%rows
  end function c_rows

  !> `asperity_columns`.
  integer(c_int) function c_columns(handle, table) bind(c, name='asperity_columns') result(number)
    type(c_ptr), value :: handle    !! outcome
    integer(c_int), value :: table  !! one of the tables
    type(outcome), pointer :: it

    call find_column(handle, table, 0_c_int, it)
    number = 0_c_int
    if (associated(it)) number = size(it%tables(table)%columns, kind=c_int)
  end function c_columns

  !> `asperity_column_name`.
  type(c_ptr) function c_column_name(handle, table, column) bind(c, name='asperity_column_name') &
    result(name)
    type(c_ptr), value :: handle     !! outcome
    integer(c_int), value :: table, column  !! one of the tables, and its column from 0
    type(outcome), pointer :: it

    call find_column(handle, table, column, it)
    name = c_null_ptr
    if (associated(it)) name = c_loc(it%names(column + 1, table)%letters)
  end function c_column_name

  !> `asperity_column_unit`.
  type(c_ptr) function c_column_unit(handle, table, column) bind(c, name='asperity_column_unit') &
    result(unit)
    type(c_ptr), value :: handle     !! outcome
    integer(c_int), value :: table, column  !! one of the tables, and its column from 0
    type(outcome), pointer :: it

    call find_column(handle, table, column, it)
    unit = c_loc(no_text_letters)
    if (.not. associated(it)) return
    if (allocated(it%units(column + 1, table)%letters)) &
      unit = c_loc(it%units(column + 1, table)%letters)
  end function c_column_unit

  !> `asperity_column_type`.
  integer(c_int) function c_column_type(handle, table, column) &
    bind(c, name='asperity_column_type') result(kind)
    type(c_ptr), value :: handle     !! outcome
    integer(c_int), value :: table, column  !! one of the tables, and its column from 0
    type(outcome), pointer :: it

    call find_column(handle, table, column, it)
    kind = 0_c_int
    if (.not. associated(it)) return
    associate (of => it%tables(table)%columns(column + 1))
      kind = type_double
      if (allocated(of%wholes)) kind = type_int
      if (allocated(of%letters)) kind = type_word
    end associate
  end function c_column_type

  !> `asperity_column`.
  type(c_ptr) function c_column(handle, table, column) bind(c, name='asperity_column') &
    result(cells)
    type(c_ptr), value :: handle     !! outcome
    integer(c_int), value :: table, column  !! one of the tables, and its column from 0
    type(outcome), pointer :: it

    call find_column(handle, table, column, it)
    cells = c_null_ptr
    if (.not. associated(it)) return
    if (it%tables(table)%rows == 0_int64) return
    if (allocated(it%tables(table)%columns(column + 1)%reals)) then
      cells = c_loc(it%tables(table)%columns(column + 1)%reals)
    else if (allocated(it%tables(table)%columns(column + 1)%wholes)) then
      cells = c_loc(it%tables(table)%columns(column + 1)%wholes)
    else
      cells = c_loc(it%tables(table)%columns(column + 1)%letters)
    end if
  end function c_column

  !> `asperity_free`.
  subroutine c_free(handle) bind(c, name='asperity_free')
    type(c_ptr), value :: handle  !! outcome, or null
    type(outcome), pointer :: it

    call look_at(handle, it)
    if (associated(it)) deallocate (it)
  end subroutine c_free

end module asperity_c_outcome
