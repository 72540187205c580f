!> Numbers of units as text, and a generated surface as CSV.
!>
!> Every number is written exactly: all its digits, and no more.
module asperity_surface_text
  use asperity_generated_surface, only: generated_surface
  use asperity_kinds, only: int64
  implicit none
  private

  public :: surface_as_csv, write_decimal, field_length

  character(len=*), parameter :: header = 'x,y,height,radius' // achar(10)
  ! More digits than this behind the point are written with an exponent.
  integer, parameter :: most_decimals = 17

  !> Characters of a field: the longest number and its exponent have room.
  integer, parameter :: field_length = 32

contains

  !> A surface as CSV: a header, then one line an asperity.
  subroutine surface_as_csv(surface, text, used)
    type(generated_surface), intent(in) :: surface      !! the surface
    character(len=:), allocatable, intent(out) :: text  !! the whole file, and some room behind it
    integer(int64), intent(out) :: used                 !! bytes of the file
    integer :: i, longest

    longest = 4 + longest_of(surface%x, surface%position_decimals) + &
              longest_of(surface%y, surface%position_decimals) + &
              longest_of(surface%height, surface%height_decimals) + &
              longest_of(surface%radius, surface%radius_decimals)
    allocate (character(len=len(header) + size(surface%x, kind=int64) * longest) :: text)
    text(:len(header)) = header
    used = len(header, int64)
    do i = 1, size(surface%x)
      call put(surface%x(i), surface%position_decimals, ',')
      call put(surface%y(i), surface%position_decimals, ',')
      call put(surface%height(i), surface%height_decimals, ',')
      call put(surface%radius(min(i, size(surface%radius))), surface%radius_decimals, achar(10))
    end do

  contains

    subroutine put(value, decimals, separator)
      integer(int64), intent(in) :: value
      integer, intent(in) :: decimals
      character(len=1), intent(in) :: separator
      character(len=field_length) :: field
      integer(int64) :: last
      integer :: first

      call write_decimal(value, decimals, field, first)
      last = used + int(field_length - first + 1, int64)
      text(used + 1_int64:last) = field(first:)
      used = last + 1_int64
      text(used:used) = separator
    end subroutine put

    !> Characters that the longest number of a column may take.
    pure integer function longest_of(values, decimals)
      integer(int64), intent(in) :: values(:)
      integer, intent(in) :: decimals
      character(len=field_length) :: field
      integer :: first

      ! The sign of a smaller number is the one character more.
      call write_decimal(max(maxval(values), -minval(values)), decimals, field, first)
      longest_of = field_length - first + 2
    end function longest_of

  end subroutine surface_as_csv

  !> Writes `value * 10**(-decimals)`, as `-0.0123`, `12` or `5E3`, at the right of a field.
  pure subroutine write_decimal(value, decimals, field, first)
    integer(int64), intent(in) :: value                !! units, less than 10**18 in size
    integer, intent(in) :: decimals                    !! a unit is 10**(-decimals)
    character(len=field_length), intent(inout) :: field  !! blank before the number when it was
    integer, intent(out) :: first                      !! where in it the number begins
    character(len=12) :: exponent
    integer(int64) :: rest, above
    integer :: at, behind

    at = field_length
    behind = decimals
    if (decimals > most_decimals .or. decimals < 0) then
      write (exponent, '(i0)') -decimals
      at = at - len_trim(exponent)
      field(at + 1:) = exponent
      field(at:at) = 'E'
      at = at - 1
      behind = 0
    end if
    rest = abs(value)
    do
      above = rest / 10_int64
      field(at:at) = achar(iachar('0') + int(rest - 10_int64 * above))
      rest = above
      at = at - 1
      behind = behind - 1
      if (behind == 0) then
        field(at:at) = '.'
        at = at - 1
      end if
      ! One digit stands before the point.
      if (rest == 0_int64 .and. behind < 0) exit
    end do
    first = at + 1
    if (value < 0_int64) then
      first = at
      field(at:at) = '-'
    end if
  end subroutine write_decimal

end module asperity_surface_text
