!> Parts of the outcome of a call that C reads: status, texts, problems, tables; and its release.
module asperity_c_answers
  use, intrinsic :: iso_c_binding, only: c_associated, c_f_pointer, c_char, c_int, c_loc, &
                                         c_null_char, c_null_ptr, c_ptr
  use asperity, only: version
  use asperity_c_outcome, only: find_column, look_at, not_computed, outcome, text_failure, texts, &
                                type_double, type_int, type_word
  implicit none
  private

  public :: c_version, c_status, c_text, c_problems, c_get_problem, c_problem
  public :: c_rows, c_columns, c_column_name, c_column_type, c_column_unit, c_column, c_free

  !> `asperity_problem` of the header.
  type, bind(c) :: c_problem
    type(c_ptr) :: file      !! empty: it has none
    integer(c_int) :: line, column  !! 0: it has none
    type(c_ptr) :: text      !! without file, line and column
  end type c_problem

  ! Texts that are always there: constants, which can have no address in Fortran.
  integer :: letter
  character(len=*), parameter :: no_memory = 'not enough memory'
  character(kind=c_char), target :: no_text_letters(1) = c_null_char
  character(kind=c_char), target :: no_memory_letters(len(no_memory) + 1) = &
    [(no_memory(letter:letter), letter = 1, len(no_memory)), c_null_char]
  character(kind=c_char), target :: version_letters(len(version) + 1) = &
    [(version(letter:letter), letter = 1, len(version)), c_null_char]

contains

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
  integer(c_int) function c_rows(handle, table) bind(c, name='asperity_rows') result(number)
    type(c_ptr), value :: handle    !! outcome
    integer(c_int), value :: table  !! one of the tables
    type(outcome), pointer :: it

    call find_column(handle, table, 0_c_int, it)
    number = 0_c_int
    if (associated(it)) number = int(it%tables(table)%rows, c_int)
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
    if (it%tables(table)%rows == 0) return
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

end module asperity_c_answers
