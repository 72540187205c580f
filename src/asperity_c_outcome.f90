!> What a call of the library for C gave, as memory that C can look at: texts that end with a null
!> character, tables, problems.
module asperity_c_outcome
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_int, c_loc, &
                                         c_null_char, c_null_ptr, c_ptr
  use, intrinsic :: iso_fortran_env, only: real64
  use asperity, only: add_reals, array_table, contact_field, list_groups, problem_list, &
                      problem_place, scene, solution_start
  implicit none
  private

  public :: c_letters, outcome, begin, finish, finish_scene, look_at, has_column, &
            set_surface, set_text, text_of

  !> As in the header: what became of a call, its texts, its tables, types of columns.
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
    character(kind=c_char), allocatable :: letters(:)  !! the null character included
  end type c_letters

  !> What a call gave.
  type :: outcome
    integer(c_int) :: status = done                        !! what became of it
    type(scene), allocatable :: scene_in                   !! that it read or built
    type(c_letters) :: texts(texts)                        !! by the `text_` numbers
    type(array_table) :: tables(tables)                    !! by the `table_` numbers
    type(problem_list) :: problems                         !! what is wrong with the input
    type(c_letters), allocatable :: files(:), messages(:)  !! of each problem
    type(problem_place), allocatable :: places(:)          !! of each problem
    type(c_letters), allocatable :: names(:, :)            !! of columns (column, table)
    type(c_letters), allocatable :: units(:, :)            !! of columns (column, table)
    type(solution_start), allocatable :: solutions(:)      !! by position, for further solves
    type(contact_field), allocatable :: fields(:)          !! of the states that keep them
    character(len=:), allocatable :: failure               !! why it was not computed
  end type outcome

contains

  !> A new outcome; there is none where memory has ended.
  subroutine begin(new, handle)
    type(outcome), pointer, intent(out) :: new  !! not associated: there is no memory
    type(c_ptr), intent(out) :: handle          !! its address, for C
    integer :: status

    handle = c_null_ptr
    allocate (new, stat=status)
    if (status /= 0) nullify (new)
    if (associated(new)) handle = c_loc(new)
  end subroutine begin

  !> Fills what C reads of an outcome: status, messages, tables and texts.
  subroutine finish(new)
    type(outcome), intent(inout) :: new  !! whose work is done
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
  end subroutine finish

  !> The same for an outcome that has a scene, with the groups of the scene as text.
  subroutine finish_scene(new)
    type(outcome), intent(inout) :: new  !! whose scene is read or built

    if (new%problems%count() == 0) call set_text(new, text_groups, list_groups(new%scene_in))
    call finish(new)
  end subroutine finish_scene

  !> The outcome behind a handle.
  subroutine look_at(handle, it)
    type(c_ptr), intent(in) :: handle          !! null: there is none
    type(outcome), pointer, intent(out) :: it  !! not associated: there is none

    nullify (it)
    if (c_associated(handle)) call c_f_pointer(handle, it)
  end subroutine look_at

  !> Whether an outcome has a column, counted from 0, in a table.
  logical function has_column(it, table, column)
    type(outcome), pointer, intent(in) :: it     !! may be none
    integer(c_int), intent(in) :: table, column  !! as C counts them

    has_column = .false.
    if (.not. associated(it) .or. table < 1_c_int .or. table > tables) return
    has_column = column >= 0_c_int .and. column < columns_of(it%tables(table))
  end function has_column

  pure integer function columns_of(table)
    type(array_table), intent(in) :: table

    columns_of = 0
    if (allocated(table%columns)) columns_of = size(table%columns)
  end function columns_of

  !> The table of the summits or asperities of a surface.
  subroutine set_surface(x, y, height, radius, table, unit)
    real(real64), intent(in) :: x(:), y(:)             !! places
    real(real64), intent(in) :: height(:), radius(:)   !! as many
    type(array_table), intent(inout) :: table          !! gets its columns
    character(len=*), intent(in) :: unit               !! of length; empty: not known

    call add_reals(table, 'x', x, trim(unit))
    call add_reals(table, 'y', y, trim(unit))
    call add_reals(table, 'height', height, trim(unit))
    call add_reals(table, 'radius', radius, trim(unit))
  end subroutine set_surface

  !> Sets one of the texts.
  subroutine set_text(new, which, text)
    type(outcome), intent(inout) :: new   !! gets it
    integer, intent(in) :: which          !! one of the `text_` numbers
    character(len=*), intent(in) :: text  !! without a null character

    call set_letters(new%texts(which), text)
  end subroutine set_text

  subroutine set_letters(letters, text)
    type(c_letters), intent(inout) :: letters
    character(len=*), intent(in) :: text
    integer :: i

    allocate (letters%letters(len(text) + 1))
    do i = 1, len(text)
      letters%letters(i) = text(i:i)
    end do
    letters%letters(len(text) + 1) = c_null_char
  end subroutine set_letters

  !> A text of C; empty for a null pointer.
  function text_of(address) result(text)
    type(c_ptr), intent(in) :: address     !! of its first letter
    character(len=:), allocatable :: text  !! without the null character
    character(kind=c_char), pointer :: letters(:)
    integer :: i, length

    text = ''
    if (.not. c_associated(address)) return
    call c_f_pointer(address, letters, [huge(length)])
    length = 0
    do while (letters(length + 1) /= c_null_char)
      length = length + 1
    end do
    deallocate (text)
    allocate (character(len=length) :: text)
    do i = 1, length
      text(i:i) = letters(i)
    end do
  end function text_of

end module asperity_c_outcome
