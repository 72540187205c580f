!> Tables as arrays in memory, a column each: what other languages see, and writers that need a
!> column at once.
module asperity_result_arrays
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use asperity_kinds, only: int32, int64, not_computed, real64
  use asperity_process, only: has_memory
  use asperity_result_table, only: cell_whole, cell_word, of_contacts, result_table, table_names, &
                                   word_length
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: scene
  use asperity_unit_names, only: unit_of, unit_powers
  implicit none
  private

  public :: array_column, array_table, make_arrays, add_reals, add_wholes, name_units, place_of

  !> One column. One of the three arrays is allocated.
  type :: array_column
    character(len=:), allocatable :: name                    !! as in the files
    type(unit_powers) :: dimension                           !! powers in its unit
    character(len=:), allocatable :: unit                    !! `N/mm2`; not allocated: not known
    real(real64), allocatable :: reals(:)                    !! NaN where a cell is empty
    integer(int32), allocatable :: wholes(:)                 !! whole numbers; yes and no: 1 and 0
    character(len=1), allocatable :: letters(:, :)           !! words (letter, row), blanks behind
  end type array_column

  !> A table.
  type :: array_table
    integer :: rows = 0                           !! length of every column
    type(array_column), allocatable :: columns(:) !! not allocated: there is no such table
  end type array_table

contains

  !> One of the tables of a run. `failure` is allocated when there is no memory for it. Contacts
  !> that were not kept have no rows.
  subroutine make_arrays(which, results, arrays, failure)
    integer, intent(in) :: which                           !! table, one of the `of_` numbers
    type(scene_results), intent(in) :: results             !! results of a run
    type(array_table), intent(out) :: arrays               !! table of columns
    character(len=:), allocatable, intent(out) :: failure  !! reason of a failure
    type(result_table) :: table
    character(len=word_length) :: word
    integer :: column, i, row
    logical :: found

    call table%begin_rows(which, results)
    arrays%rows = table%rows
    if (.not. has_memory(8_int64 * size(table%names) * table%rows)) then
      failure = 'not enough memory for the ' // trim(table_names(which)) // ' as arrays'
      if (which == of_contacts) failure = failure // ', expected fewer, or none kept'
      return
    end if
    allocate (arrays%columns(size(table%names)))
    do column = 1, size(arrays%columns)
      associate (new => arrays%columns(column))
        new%name = trim(table%names(column))
        new%dimension = table%dimensions(column)
        select case (table%kinds(column))
        case (cell_whole)
          allocate (new%wholes(table%rows))
        case (cell_word)
          allocate (new%letters(word_length, table%rows))
        case default
          allocate (new%reals(table%rows))
        end select
      end associate
    end do
    do row = 1, table%rows
      call table%next_row(results, found)
      do column = 1, size(arrays%columns)
        associate (into => arrays%columns(column), value => table%numbers(column))
          select case (table%kinds(column))
          case (cell_whole)
            into%wholes(row) = nint(value, int32)
          case (cell_word)
            word = table%words(column)
            into%letters(:, row) = [(word(i:i), i = 1, word_length)]
          case default
            into%reals(row) = value
            if (.not. value > not_computed) &
              into%reals(row) = ieee_value(value, ieee_quiet_nan)
          end select
        end associate
      end do
    end do
  end subroutine make_arrays

  !> The place of a column in its table; 0: there is none.
  pure integer function place_of(table, name)
    type(array_table), intent(in) :: table  !! table with columns
    character(len=*), intent(in) :: name    !! of a column

    do place_of = size(table%columns), 1, -1
      if (table%columns(place_of)%name == name) return
    end do
  end function place_of

  !> Names the units of all columns of a table of a run.
  subroutine name_units(scene_in, arrays)
    type(scene), intent(in) :: scene_in            !! what was solved
    type(array_table), intent(inout) :: arrays     !! table by `make_arrays`
    integer :: i

    do i = 1, size(arrays%columns)
      arrays%columns(i)%unit = unit_of(scene_in, arrays%columns(i)%dimension)
    end do
  end subroutine name_units

  !> Adds a column of doubles to a table.
  subroutine add_reals(table, name, values, unit)
    type(array_table), intent(inout) :: table  !! without columns, or with some as long
    character(len=*), intent(in) :: name       !! of the column
    real(real64), intent(in) :: values(:)      !! cells of the column
    character(len=*), intent(in), optional :: unit  !! its unit; absent: not known

    call add_column(table, name)
    table%rows = size(values)
    associate (new => table%columns(size(table%columns)))
      new%reals = values
      if (present(unit)) new%unit = unit
    end associate
  end subroutine add_reals

  !> Adds a column of whole numbers to a table.
  subroutine add_wholes(table, name, values)
    type(array_table), intent(inout) :: table  !! without columns, or with some as long
    character(len=*), intent(in) :: name       !! of the column
    integer(int32), intent(in) :: values(:)    !! cells of the column

    call add_column(table, name)
    table%rows = size(values)
    table%columns(size(table%columns))%wholes = values
  end subroutine add_wholes

  ! Adds a column without cells.
  subroutine add_column(table, name)
    type(array_table), intent(inout) :: table
    character(len=*), intent(in) :: name
    type(array_column), allocatable :: more(:)
    integer :: i

    if (.not. allocated(table%columns)) allocate (table%columns(0))
    allocate (more(size(table%columns) + 1))
    do i = 1, size(table%columns)
      call move_alloc(table%columns(i)%name, more(i)%name)
      call move_alloc(table%columns(i)%unit, more(i)%unit)
      call move_alloc(table%columns(i)%reals, more(i)%reals)
      call move_alloc(table%columns(i)%wholes, more(i)%wholes)
    end do
    more(i)%name = name
    call move_alloc(more, table%columns)
  end subroutine add_column

end module asperity_result_arrays
