!> The values of a scene, taken from its text by group and name; or of another file of its form
!> with a table of its own.
!>
!> Each `take_` procedure leaves the value as it is when the name does not stand in the scene, and
!> tells a problem, with its place, when what stands there is not what is expected.
module asperity_scene_fields
  use asperity_decimal, only: decimal_value
  use asperity_input_problems, only: input_problems, lower_case, quoted
  use asperity_kinds, only: int64
  use asperity_namelist_text, only: namelist_entry
  use asperity_number_ranges, only: above_zero, any_number, expected_numbers, in_range, &
                                    not_negative, poisson_range, share
  use asperity_numeral, only: read_numeral, read_whole_number
  use asperity_problems, only: decimal_text
  use asperity_scene_names, only: name_table, one_of, place_in
  use asperity_scene_places, only: scene_places
  implicit none
  private

  public :: scene_fields, read_fields
  public :: any_number, above_zero, share, poisson_range, not_negative

  !> The text of a scene, sorted into the groups and names that are known.
  type :: scene_fields
    private
    type(scene_places) :: places              ! where they stand
    logical, public :: surfaces_given = .false.  !! as arrays, beside the text
    type(input_problems), public :: problems  !! what is wrong with the scene
  contains
    !> Whether a group stands in the scene.
    procedure :: has_group
    !> Whether a name stands in the scene, be its values good or not.
    procedure :: has
    !> How many values stand at a name, repeated ones counted.
    procedure :: value_count
    !> Takes numbers, as many as there are places for them.
    procedure :: take_numbers
    !> Takes two numbers, or one that serves twice.
    procedure :: take_pair
    !> Takes one number.
    procedure :: take_number
    !> Takes one whole number of a given range.
    procedure :: take_whole
    !> Takes one text between quotes.
    procedure :: take_text
    !> Takes one of several words between quotes, as its number.
    procedure :: take_word
    !> Tells a problem at a group, or at the table's first when that does not stand there.
    procedure :: complain_of_group
    !> Tells a problem at a name that stands in the scene.
    procedure :: complain_of
  end type scene_fields

contains

  !> Sorts the text of a scene; what is unknown or stands twice is told.
  subroutine read_fields(file, text, fields, table)
    character(len=*), intent(in) :: file       !! name for the messages
    character(len=*), intent(in) :: text       !! the whole scene
    type(scene_fields), intent(out) :: fields  !! its values and problems
    type(name_table), intent(in), optional :: table  !! what is known; the scene's by default

    call fields%problems%start(file)
    call fields%places%sort(text, fields%problems, table)
  end subroutine read_fields

  !> Whether a group stands in the scene.
  pure logical function has_group(self, group)
    class(scene_fields), intent(in) :: self  !! the scene's text
    character(len=*), intent(in) :: group    !! a known group

    has_group = self%places%has_group(group)
  end function has_group

  !> Whether a name stands in the scene, be its values good or not.
  pure logical function has(self, group, name)
    class(scene_fields), intent(in) :: self  !! the scene's text
    character(len=*), intent(in) :: group    !! a known group
    character(len=*), intent(in) :: name     !! a known name of it

    has = self%places%has(group, name)
  end function has

  !> How many values stand at a name, repeated ones counted; 0 when it does not stand there.
  pure integer function value_count(self, group, name)
    class(scene_fields), intent(in) :: self  !! the scene's text
    character(len=*), intent(in) :: group    !! a known group
    character(len=*), intent(in) :: name     !! a known name of it
    integer(int64) :: there

    value_count = 0
    if (.not. self%has(group, name)) return
    associate (entry => self%places%entry_of(group, name))
      there = sum(int(self%places%list%values(entry%first_value:entry%last_value)%repeats, int64))
    end associate
    value_count = int(min(there, int(huge(1), int64)))
  end function value_count

  !> Takes two numbers, or one that serves twice.
  subroutine take_pair(self, group, name, range, values)
    class(scene_fields), intent(inout) :: self         !! the scene's text
    character(len=*), intent(in) :: group              !! a known group
    character(len=*), intent(in) :: name               !! a known name of it
    integer, intent(in) :: range                       !! `any_number` or another range
    type(decimal_value), intent(inout) :: values(2)    !! the numbers

    if (self%value_count(group, name) == 1) then
      call self%take_numbers(group, name, range, values(:1))
      values(2) = values(1)
    else
      call self%take_numbers(group, name, range, values)
    end if
  end subroutine take_pair

  !> Takes numbers, as many as there are places for them.
  subroutine take_numbers(self, group, name, range, values)
    class(scene_fields), intent(inout) :: self        !! the scene's text
    character(len=*), intent(in) :: group             !! a known group
    character(len=*), intent(in) :: name              !! a known name of it
    integer, intent(in) :: range                      !! `any_number` or another range
    type(decimal_value), intent(inout) :: values(:)   !! the numbers
    type(decimal_value) :: value
    integer :: i, used, repeats
    logical :: good

    if (.not. has_count(self, group, name, size(values))) return
    used = 0
    associate (entry => self%places%entry_of(group, name))
      do i = entry%first_value, entry%last_value
        call read_numeral(self%places%list%value_text(i), value, good)
        good = good .and. .not. self%places%list%values(i)%is_quoted
        if (good) good = in_range(value, range)
        if (.not. good) call complain_of_value(self, name, i, trim(expected_numbers(range)))
        repeats = self%places%list%values(i)%repeats
        values(used + 1:used + repeats) = value
        used = used + repeats
      end do
    end associate
  end subroutine take_numbers

  !> Takes one number.
  subroutine take_number(self, group, name, range, value)
    class(scene_fields), intent(inout) :: self    !! the scene's text
    character(len=*), intent(in) :: group         !! a known group
    character(len=*), intent(in) :: name          !! a known name of it
    integer, intent(in) :: range                  !! `any_number` or another range
    type(decimal_value), intent(inout) :: value   !! the number
    type(decimal_value) :: values(1)

    values = value
    call self%take_numbers(group, name, range, values)
    value = values(1)
  end subroutine take_number

  !> Takes one whole number of a given range.
  subroutine take_whole(self, group, name, least, most, value)
    class(scene_fields), intent(inout) :: self  !! the scene's text
    character(len=*), intent(in) :: group       !! a known group
    character(len=*), intent(in) :: name        !! a known name of it
    integer, intent(in) :: least                !! smallest number allowed
    integer, intent(in) :: most                 !! largest number allowed
    integer, intent(inout) :: value             !! the number
    type(namelist_entry) :: entry
    integer :: i, found
    logical :: good

    if (.not. has_count(self, group, name, 1)) return
    entry = self%places%entry_of(group, name)
    i = entry%first_value
    call read_whole_number(self%places%list%value_text(i), found, good)
    if (good .and. found >= least .and. found <= most .and. &
        .not. self%places%list%values(i)%is_quoted) then
      value = found
    else
      call complain_of_value(self, name, i, 'a whole number from ' // decimal_text(least) // &
                             ' to ' // decimal_text(most))
    end if
  end subroutine take_whole

  !> Takes one text between quotes. It stays unallocated when there is no good one.
  subroutine take_text(self, group, name, text)
    class(scene_fields), intent(inout) :: self             !! the scene's text
    character(len=*), intent(in) :: group                  !! a known group
    character(len=*), intent(in) :: name                   !! a known name of it
    character(len=:), allocatable, intent(inout) :: text   !! the text
    type(namelist_entry) :: entry
    integer :: i

    if (.not. has_count(self, group, name, 1)) return
    entry = self%places%entry_of(group, name)
    i = entry%first_value
    if (self%places%list%values(i)%is_quoted .and. &
        len_trim(self%places%list%value_text(i)) > 0) then
      text = trim(self%places%list%value_text(i))
    else
      call complain_of_value(self, name, i, 'a text between quotes')
    end if
  end subroutine take_text

  !> Takes one of several words between quotes, as its number; 0 when it is none of them.
  subroutine take_word(self, group, name, words, number)
    class(scene_fields), intent(inout) :: self  !! the scene's text
    character(len=*), intent(in) :: group       !! a known group
    character(len=*), intent(in) :: name        !! a known name of it
    character(len=*), intent(in) :: words(:)    !! the words
    integer, intent(inout) :: number            !! which of them; 0 when refused
    character(len=:), allocatable :: word
    type(namelist_entry) :: entry
    integer :: i, found

    if (.not. self%has(group, name)) return
    number = 0
    if (.not. has_count(self, group, name, 1)) return
    entry = self%places%entry_of(group, name)
    i = entry%first_value
    found = 0
    word = trim(lower_case(self%places%list%value_text(i)))
    if (self%places%list%values(i)%is_quoted) found = place_in(words, word)
    if (found > 0) then
      number = found
      return
    end if
    call complain_of_value(self, name, i, one_of(words))
  end subroutine take_word

  !> Tells a problem at a group, or at the table's first when that does not stand there.
  subroutine complain_of_group(self, group, message)
    class(scene_fields), intent(inout) :: self  !! the scene's text
    character(len=*), intent(in) :: group       !! a known group
    character(len=*), intent(in) :: message     !! what is wrong, found, expected

    call self%problems%add_at_byte(self%places%list%text, self%places%group_byte(group), message)
  end subroutine complain_of_group

  !> Tells a problem at a name that stands in the scene.
  subroutine complain_of(self, group, name, message)
    class(scene_fields), intent(inout) :: self  !! the scene's text
    character(len=*), intent(in) :: group       !! a known group
    character(len=*), intent(in) :: name        !! a known name of it
    character(len=*), intent(in) :: message     !! what is wrong, found, expected
    type(namelist_entry) :: entry

    entry = self%places%entry_of(group, name)
    call self%problems%add_at_byte(self%places%list%text, entry%first, name // ': ' // message)
  end subroutine complain_of

  !> Whether a name stands in the scene with so many values; another count is told.
  logical function has_count(self, group, name, wanted)
    class(scene_fields), intent(inout) :: self
    character(len=*), intent(in) :: group, name
    integer, intent(in) :: wanted
    integer(int64) :: there
    character(len=20) :: digits

    has_count = .false.
    if (.not. self%has(group, name)) return
    associate (entry => self%places%entry_of(group, name))
      if (entry%is_broken) return
      there = sum(int(self%places%list%values(entry%first_value:entry%last_value)%repeats, int64))
    end associate
    has_count = there == int(wanted, int64)
    if (has_count) return
    write (digits, '(i0)') there
    call self%complain_of(group, name, 'wrong number of values: found ' // trim(digits) // &
                          ', expected ' // decimal_text(wanted))
  end function has_count

  subroutine complain_of_value(self, name, i, expected)
    class(scene_fields), intent(inout) :: self
    character(len=*), intent(in) :: name, expected
    integer, intent(in) :: i
    integer :: first
    character(len=:), allocatable :: found

    first = self%places%list%values(i)%first
    found = quoted(self%places%list%value_text(i))
    if (self%places%list%values(i)%is_quoted) then
      first = first - 1
      found = 'the text ' // found
    end if
    call self%problems%add_at_byte(self%places%list%text, first, &
                                   name // ': found ' // found // ', expected ' // expected)
  end subroutine complain_of_value

end module asperity_scene_fields
