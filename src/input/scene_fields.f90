!> The values of a scene, taken from its text by group and name; or of another file of its form
!> with a table of its own.
!>
!> Each `take_` procedure leaves the value as it is when the name does not stand in the scene, and
!> tells a problem, with its place, when what stands there is not what is expected.
module asperity_scene_fields
  use asperity_decimal, only: decimal_value
  use asperity_input_problems, only: input_problems, lower_case, quoted
  use asperity_namelist_text, only: namelist_text, parse_namelist
  use asperity_numeral, only: nearest_double, read_numeral, read_whole_number
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text
  use asperity_scene_names, only: name_table, or_comma, place_in, scene_table
  implicit none
  private

  public :: scene_fields, read_fields
  public :: any_number, above_zero, share, poisson_range, not_negative, share_or_all

  !> Any finite number.
  integer, parameter :: any_number = 1
  !> More than 0.
  integer, parameter :: above_zero = 2
  !> More than 0 and less than 1.
  integer, parameter :: share = 3
  !> More than -1 and at most 0.5.
  integer, parameter :: poisson_range = 4
  !> 0 or more.
  integer, parameter :: not_negative = 5
  !> More than 0 and at most 1.
  integer, parameter :: share_or_all = 6

  ! What the messages say of them.
  character(len=*), parameter :: expected_numbers(6) = [character(len=50) :: &
    'a finite number within the range of a double', 'a number more than 0', &
    'a number more than 0 and less than 1', 'a number more than -1 and at most 0.5', &
    'a number of 0 or more', 'a number more than 0 and at most 1']

  !> The text of a scene, sorted into the groups and names that are known.
  type :: scene_fields
    private
    type(namelist_text) :: list
    type(name_table) :: table
    integer, allocatable :: group_at(:)  ! number in the list; 0 when it does not stand there
    integer, allocatable :: entry_at(:)  ! the same for the names
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
    integer, allocatable :: known(:)
    integer :: i, at
    character(len=:), allocatable :: name

    if (present(table)) then
      fields%table = table
    else
      fields%table = scene_table()
    end if
    allocate (fields%group_at(size(fields%table%groups)), source=0)
    allocate (fields%entry_at(size(fields%table%names)), source=0)
    call fields%problems%start(file)
    call parse_namelist(text, fields%list, fields%problems)
    ! The known group of each group of the text; negative when it stands there again.
    allocate (known(fields%list%group_count))
    known = 0
    do i = 1, size(known)
      associate (group => fields%list%groups(i))
        if (group%last < group%first) cycle
        name = fields%list%name_text(group%first, group%last)
        known(i) = place_in(fields%table%groups, name)
        if (known(i) == 0) then
          call fields%problems%add_at_byte(text, group%first - 1, 'unknown group: found ' // &
                                           quoted('&' // name) // ', expected ' // &
                                           fields%table%group_names())
        else if (fields%group_at(known(i)) > 0) then
          call fields%problems%add_at_byte(text, group%first - 1, 'group &' // name // &
                                           ' stands twice, expected once')
          known(i) = -known(i)
        else
          fields%group_at(known(i)) = i
        end if
      end associate
    end do
    do i = 1, fields%list%entry_count
      associate (entry => fields%list%entries(i))
        if (known(entry%group) == 0) cycle
        name = fields%list%name_text(entry%first, entry%last)
        at = fields%table%number_of(fields%table%groups(abs(known(entry%group))), name)
        if (at == 0) then
          call fields%problems%add_at_byte(text, entry%first, 'unknown name in &' // &
               trim(fields%table%groups(abs(known(entry%group)))) // ': found ' // &
               quoted(name) // ', expected ' // &
               fields%table%names_of(fields%table%groups(abs(known(entry%group)))))
        else if (known(entry%group) > 0) then
          if (fields%entry_at(at) > 0) then
            call fields%problems%add_at_byte(text, entry%first, name // ' stands twice in &' // &
                                             trim(fields%table%names(at)%group) // &
                                             ', expected once')
          else
            fields%entry_at(at) = i
          end if
        end if
      end associate
    end do
  end subroutine read_fields

  !> Whether a group stands in the scene.
  pure logical function has_group(self, group)
    class(scene_fields), intent(in) :: self  !! the scene's text
    character(len=*), intent(in) :: group    !! a known group

    has_group = self%group_at(place_in(self%table%groups, group)) > 0
  end function has_group

  !> Whether a name stands in the scene, be its values good or not.
  pure logical function has(self, group, name)
    class(scene_fields), intent(in) :: self  !! the scene's text
    character(len=*), intent(in) :: group    !! a known group
    character(len=*), intent(in) :: name     !! a known name of it

    has = self%entry_at(self%table%number_of(group, name)) > 0
  end function has

  !> How many values stand at a name, repeated ones counted; 0 when it does not stand there.
  pure integer function value_count(self, group, name)
    class(scene_fields), intent(in) :: self  !! the scene's text
    character(len=*), intent(in) :: group    !! a known group
    character(len=*), intent(in) :: name     !! a known name of it
    integer(int64) :: there

    value_count = 0
    if (.not. self%has(group, name)) return
    associate (entry => self%list%entries(self%entry_at(self%table%number_of(group, name))))
      there = sum(int(self%list%values(entry%first_value:entry%last_value)%repeats, int64))
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
    associate (entry => self%list%entries(self%entry_at(self%table%number_of(group, name))))
      do i = entry%first_value, entry%last_value
        call read_numeral(self%list%value_text(i), value, good)
        good = good .and. .not. self%list%values(i)%is_quoted
        if (good) good = in_range(value, range)
        if (.not. good) call complain_of_value(self, name, i, trim(expected_numbers(range)))
        repeats = self%list%values(i)%repeats
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
    integer :: i, found
    logical :: good

    if (.not. has_count(self, group, name, 1)) return
    i = self%list%entries(self%entry_at(self%table%number_of(group, name)))%first_value
    call read_whole_number(self%list%value_text(i), found, good)
    if (good .and. found >= least .and. found <= most .and. &
        .not. self%list%values(i)%is_quoted) then
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
    integer :: i

    if (.not. has_count(self, group, name, 1)) return
    i = self%list%entries(self%entry_at(self%table%number_of(group, name)))%first_value
    if (self%list%values(i)%is_quoted .and. len_trim(self%list%value_text(i)) > 0) then
      text = trim(self%list%value_text(i))
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
    character(len=:), allocatable :: word, expected
    integer :: i, found

    if (.not. self%has(group, name)) return
    number = 0
    if (.not. has_count(self, group, name, 1)) return
    i = self%list%entries(self%entry_at(self%table%number_of(group, name)))%first_value
    found = 0
    word = trim(lower_case(self%list%value_text(i)))
    if (self%list%values(i)%is_quoted) found = place_in(words, word)
    if (found > 0) then
      number = found
      return
    end if
    expected = quoted(trim(words(1)))
    do found = 2, size(words)
      expected = expected // or_comma(found, size(words)) // quoted(trim(words(found)))
    end do
    call complain_of_value(self, name, i, expected)
  end subroutine take_word

  !> Tells a problem at a group, or at the table's first when that does not stand there.
  subroutine complain_of_group(self, group, message)
    class(scene_fields), intent(inout) :: self  !! the scene's text
    character(len=*), intent(in) :: group       !! a known group
    character(len=*), intent(in) :: message     !! what is wrong, found, expected
    integer :: byte

    byte = 1
    if (self%group_at(1) > 0) byte = self%list%groups(self%group_at(1))%first - 1
    if (self%has_group(group)) &
      byte = self%list%groups(self%group_at(place_in(self%table%groups, group)))%first - 1
    call self%problems%add_at_byte(self%list%text, byte, message)
  end subroutine complain_of_group

  !> Tells a problem at a name that stands in the scene.
  subroutine complain_of(self, group, name, message)
    class(scene_fields), intent(inout) :: self  !! the scene's text
    character(len=*), intent(in) :: group       !! a known group
    character(len=*), intent(in) :: name        !! a known name of it
    character(len=*), intent(in) :: message     !! what is wrong, found, expected
    integer :: byte

    byte = self%list%entries(self%entry_at(self%table%number_of(group, name)))%first
    call self%problems%add_at_byte(self%list%text, byte, name // ': ' // message)
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
    associate (entry => self%list%entries(self%entry_at(self%table%number_of(group, name))))
      if (entry%is_broken) return
      there = sum(int(self%list%values(entry%first_value:entry%last_value)%repeats, int64))
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

    first = self%list%values(i)%first
    found = quoted(self%list%value_text(i))
    if (self%list%values(i)%is_quoted) then
      first = first - 1
      found = 'the text ' // found
    end if
    call self%problems%add_at_byte(self%list%text, first, name // ': found ' // found // &
                                   ', expected ' // expected)
  end subroutine complain_of_value

  !> Whether a number is in a range.
  pure logical function in_range(value, range)
    type(decimal_value), intent(in) :: value
    integer, intent(in) :: range
    real(real64) :: number

    number = nearest_double(value)
    select case (range)
    case (above_zero)
      in_range = value%digits > 0_int64
    case (share)
      in_range = value%digits > 0_int64 .and. number < 1.0_real64
    case (share_or_all)
      in_range = value%digits > 0_int64 .and. number <= 1.0_real64
    case (poisson_range)
      in_range = number > -1.0_real64 .and. number <= 0.5_real64
    case (not_negative)
      in_range = value%digits >= 0_int64
    case default
      in_range = .true.
    end select
  end function in_range

end module asperity_scene_fields
