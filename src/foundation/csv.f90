!> Cells and lines of comma-separated values, in the C locale.
module asperity_csv
  use asperity_kinds, only: not_computed, real64
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: csv_line

  !> One line under construction.
  type :: csv_line
    private
    character(len=1600) :: text = ''
    integer :: used = 0
    logical :: begun = .false.  ! whether it has a cell, which may be empty
  contains
    procedure, private :: put_number
    procedure, private :: put_numbers
    procedure, private :: put_integer
    procedure, private :: put_logical
    procedure, private :: put_word
    !> Adds a cell: a double with 17 significant digits, an integer, a logical as 1 or 0, or a word
    !> without comma. An array of doubles has a cell for each. The cell of a number that was not
    !> computed is empty.
    generic :: put => put_number, put_numbers, put_integer, put_logical, put_word
    procedure :: finish => finish_line  !! appends the line to a text and clears it
  end type csv_line

contains

  subroutine put_number(self, value)
    class(csv_line), intent(inout) :: self
    real(real64), intent(in) :: value
    character(len=25) :: cell

    cell = ''
    if (value > not_computed) write (cell, '(es25.16e3)') value
    call put_word(self, adjustl(cell))
  end subroutine put_number

  subroutine put_numbers(self, values)
    class(csv_line), intent(inout) :: self
    real(real64), intent(in) :: values(:)
    integer :: i

    do i = 1, size(values)
      call put_number(self, values(i))
    end do
  end subroutine put_numbers

  subroutine put_integer(self, value)
    class(csv_line), intent(inout) :: self
    integer, intent(in) :: value
    character(len=12) :: cell

    write (cell, '(i0)') value
    call put_word(self, cell)
  end subroutine put_integer

  subroutine put_logical(self, value)
    class(csv_line), intent(inout) :: self
    logical, intent(in) :: value

    call put_word(self, merge('1', '0', value))
  end subroutine put_logical

  subroutine put_word(self, value)
    class(csv_line), intent(inout) :: self
    character(len=*), intent(in) :: value
    integer :: length

    length = len_trim(value)
    if (self%begun) then
      self%used = self%used + 1
      self%text(self%used:self%used) = ','
    end if
    self%begun = .true.
    self%text(self%used + 1:self%used + length) = value(:length)
    self%used = self%used + length
  end subroutine put_word

  !> Appends the line to a text and clears it.
  subroutine finish_line(self, buffer)
    class(csv_line), intent(inout) :: self      !! line; empty on exit
    type(text_buffer), intent(inout) :: buffer  !! text that is extended

    call buffer%line(self%text(:self%used))
    self%used = 0
    self%begun = .false.
  end subroutine finish_line

end module asperity_csv
