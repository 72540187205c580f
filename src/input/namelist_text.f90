!> The syntax of a Fortran namelist file: text in, groups, names and values with their places out.
!>
!> Read by hand and not by a NAMELIST statement, so that every problem is told with its place.
!> Nothing is known here of what the groups mean.
module asperity_namelist_text
  use asperity_input_problems, only: binary_byte, input_problems, lower_case, quoted, text_start
  use asperity_namelist_cursor, only: blanks, line_end, name_end, next_character, quote_end, &
                                      skip_blanks, skip_item, word_end
  implicit none
  private

  public :: namelist_text, namelist_group, namelist_entry, namelist_value, parse_namelist

  !> One value, perhaps repeated. Its text is `first:last` of the file, without quotes.
  type :: namelist_value
    integer :: first = 1, last = 0      !! place in the file
    integer :: repeats = 1              !! how often it stands there, `r*value`
    logical :: is_quoted = .false.      !! a text between quotes
  end type namelist_value

  !> One `name = values`.
  type :: namelist_entry
    integer :: group = 0                !! number of its group
    integer :: first = 1, last = 0      !! place of the name
    integer :: first_value = 1, last_value = 0  !! its values
    logical :: is_broken = .false.      !! a problem of its values has been told already
  end type namelist_entry

  !> One `&name ... /`; the place is that of the name without `&`.
  type :: namelist_group
    integer :: first = 1, last = 0      !! place of the name
    logical :: is_broken = .false.      !! a problem has been told that may hide names
  end type namelist_group

  !> A whole file.
  type :: namelist_text
    character(len=:), allocatable :: text            !! its bytes
    type(namelist_group), allocatable :: groups(:)   !! in their order
    type(namelist_entry), allocatable :: entries(:)  !! of all groups, in their order
    type(namelist_value), allocatable :: values(:)   !! of all names, in their order
    integer :: group_count = 0                       !! so many of `groups` are there
    integer :: entry_count = 0                       !! so many of `entries`
    integer :: value_count = 0                       !! so many of `values`
  contains
    !> The text of a value; a doubled quote is one.
    procedure :: value_text
    !> A piece of the file in small letters: a name.
    procedure :: name_text
  end type namelist_text

  character(len=*), parameter :: digits = '0123456789'

contains

  !> Splits the text of a file. Problems are added to `problems`; what could be read is kept.
  pure subroutine parse_namelist(text, list, problems)
    character(len=*), intent(in) :: text            !! the whole file
    type(namelist_text), intent(out) :: list        !! its groups, names and values
    type(input_problems), intent(inout) :: problems !! all that is wrong
    integer :: at
    logical :: stray

    list%text = text
    allocate (list%groups(8), list%entries(32), list%values(64))
    at = binary_byte(text)
    if (at > 0) then
      call problems%add_at_byte(text, at, 'not a text file: found a control character, ' // &
                                'expected a scene')
      return
    end if
    at = text_start(text)
    stray = .false.
    do
      call skip_blanks(text, at)
      if (at > len(text)) exit
      if (text(at:at) == '&') then
        call read_group(list, at, problems)
        stray = .false.
      else
        ! One problem for all that stands between two groups.
        if (.not. stray) &
          call problems%add_at_byte(text, at, 'text outside a group: found ' // &
                                    quoted(text(at:word_end(text, at))) // &
                                    ', expected ''&'' and a group''s name')
        stray = .true.
        call skip_item(text, at)
      end if
    end do
  end subroutine parse_namelist

  !> The text of value number `i`.
  pure function value_text(self, i) result(text)
    class(namelist_text), intent(in) :: self  !! the file
    integer, intent(in) :: i                  !! number of the value
    character(len=:), allocatable :: text     !! without quotes; a doubled quote is one
    character(len=1) :: quote
    integer :: at, used

    text = self%text(self%values(i)%first:self%values(i)%last)
    if (.not. self%values(i)%is_quoted) return
    quote = self%text(self%values(i)%first - 1:self%values(i)%first - 1)
    used = 0
    at = 1
    do while (at <= len(text))
      used = used + 1
      text(used:used) = text(at:at)
      at = at + merge(2, 1, text(at:at) == quote)
    end do
    text = text(:used)
  end function value_text

  !> Bytes `first:last` of the file in small letters.
  pure function name_text(self, first, last) result(text)
    class(namelist_text), intent(in) :: self  !! the file
    integer, intent(in) :: first, last        !! place
    character(len=:), allocatable :: text     !! the name

    text = lower_case(self%text(first:last))
  end function name_text

  !> Reads a group from its `&` on; `at` is left behind its end.
  pure subroutine read_group(list, at, problems)
    type(namelist_text), intent(inout) :: list
    integer, intent(inout) :: at
    type(input_problems), intent(inout) :: problems
    type(namelist_group) :: group
    integer :: number, ampersand

    ampersand = at
    group%first = at + 1
    group%last = name_end(list%text, at + 1)
    if (group%last < group%first) then
      call problems%add_at_byte(list%text, at, 'a group without a name: found ''&'' alone, ' // &
                                'expected a group''s name right behind it')
      group%is_broken = .true.
    end if
    call grow_groups(list)
    list%group_count = list%group_count + 1
    number = list%group_count
    list%groups(number) = group
    at = group%last + 1
    do
      call skip_blanks(list%text, at)
      if (at > len(list%text)) then
        if (.not. list%groups(number)%is_broken) &
          call problems%add_at_byte(list%text, ampersand, 'group ' // &
                                    quoted(list%text(ampersand:group%last)) // ' has no end: ' // &
                                    'found the end of the file, expected ''/''')
        list%groups(number)%is_broken = .true.
        return
      end if
      select case (list%text(at:at))
      case ('/')
        at = at + 1
        return
      case ('&')
        if (.not. list%groups(number)%is_broken) &
          call problems%add_at_byte(list%text, at, 'group ' // &
                                    quoted(list%text(ampersand:group%last)) // ' has no end: ' // &
                                    'found another group, expected ''/''')
        list%groups(number)%is_broken = .true.
        return
      case default
        call read_entry(list, number, at, problems)
      end select
    end do
  end subroutine read_group

  !> Reads `name = values`; `at` is left at what is neither a value nor a comma.
  pure subroutine read_entry(list, group, at, problems)
    type(namelist_text), intent(inout) :: list
    integer, intent(in) :: group
    integer, intent(inout) :: at
    type(input_problems), intent(inout) :: problems
    type(namelist_entry) :: entry
    integer :: equals
    logical :: comma, is_value

    entry%group = group
    entry%first = at
    entry%last = name_end(list%text, at)
    equals = entry%last + 1
    call skip_blanks(list%text, equals)
    if (entry%last < entry%first .or. next_character(list%text, equals) /= '=') then
      call complain_of_name(list, entry, equals, at, problems)
      list%groups(group)%is_broken = .true.
      return
    end if
    entry%first_value = list%value_count + 1
    at = equals + 1
    comma = .true.
    do
      call skip_blanks(list%text, at)
      if (next_character(list%text, at) == ',') then
        ! A comma may stand behind the last value too; two in a row leave one out.
        if (comma .and. .not. entry%is_broken) then
          call problems%add_at_byte(list%text, at, 'a value is missing: found '','', expected ' // &
                                    'a value of ' // quoted(list%text(entry%first:entry%last)))
          entry%is_broken = .true.
        end if
        comma = .true.
        at = at + 1
        cycle
      end if
      call read_value(list, entry, at, is_value, problems)
      if (.not. is_value) exit
      comma = .false.
    end do
    entry%last_value = list%value_count
    if (entry%last_value < entry%first_value .and. .not. entry%is_broken) then
      call problems%add_at_byte(list%text, min(at, len(list%text) + 1), 'a value is missing: ' // &
                                'found none, expected a value of ' // &
                                quoted(list%text(entry%first:entry%last)))
      entry%is_broken = .true.
    end if
    call grow_entries(list)
    list%entry_count = list%entry_count + 1
    list%entries(list%entry_count) = entry
  end subroutine read_entry

  !> Tells why no `name =` stands at `entry%first` and steps over it.
  pure subroutine complain_of_name(list, entry, equals, at, problems)
    type(namelist_text), intent(in) :: list
    type(namelist_entry), intent(in) :: entry
    integer, intent(in) :: equals
    integer, intent(inout) :: at
    type(input_problems), intent(inout) :: problems
    character(len=:), allocatable :: found

    found = quoted(list%text(at:max(at, word_end(list%text, at))))
    if (entry%last >= entry%first .and. next_character(list%text, equals) == '(') then
      call problems%add_at_byte(list%text, equals, 'an index is not read: found ''('', ' // &
                                'expected ''='' and all values of ' // &
                                quoted(list%text(entry%first:entry%last)))
    else if (.not. list%groups(entry%group)%is_broken) then
      call problems%add_at_byte(list%text, at, 'no name with values: found ' // found // &
                                ', expected ''name = value'' or ''/''')
    end if
    call skip_item(list%text, at)
  end subroutine complain_of_name

  !> Reads one value. There is none at a slash, an ampersand, the end, or a name with `=`.
  pure subroutine read_value(list, entry, at, is_value, problems)
    type(namelist_text), intent(inout) :: list
    type(namelist_entry), intent(inout) :: entry
    integer, intent(inout) :: at
    logical, intent(out) :: is_value
    type(input_problems), intent(inout) :: problems
    type(namelist_value) :: value
    integer :: behind, last

    is_value = .false.
    if (scan(next_character(list%text, at), '/&=') > 0 .or. at > len(list%text)) return
    last = name_end(list%text, at)
    behind = last + 1
    call skip_blanks(list%text, behind)
    if (last >= at .and. scan(next_character(list%text, behind), '=(') > 0) return
    is_value = .true.
    call read_repeats(list%text, at, value%repeats)
    if (value%repeats < 1 .or. scan(next_character(list%text, at), blanks // ',/=!&') > 0 .or. &
        at > len(list%text)) then
      call problems%add_at_byte(list%text, at, 'a repeat count without a value, or not from 1 ' // &
                                'to 999999999: expected ''count*value''')
      entry%is_broken = .true.
    end if
    if (scan(next_character(list%text, at), '''"') > 0) then
      value%is_quoted = .true.
      value%first = at + 1
      value%last = quote_end(list%text, at)
      if (value%last < at) then
        call problems%add_at_byte(list%text, at, 'a text has no end: found the end of the ' // &
                                  'line, expected a second ' // list%text(at:at))
        entry%is_broken = .true.
        ! The lost part of the line may have held the group's end.
        list%groups(entry%group)%is_broken = .true.
        at = line_end(list%text, at) + 1
        return
      end if
      at = value%last + 2
    else
      value%first = at
      value%last = word_end(list%text, at)
      at = value%last + 1
    end if
    call grow_values(list)
    list%value_count = list%value_count + 1
    list%values(list%value_count) = value
  end subroutine read_value

  !> Reads `count*` when it stands there, and steps over it.
  pure subroutine read_repeats(text, at, repeats)
    character(len=*), intent(in) :: text
    integer, intent(inout) :: at
    integer, intent(out) :: repeats
    integer :: i, last

    repeats = 1
    last = at - 1
    do while (last < len(text))
      if (scan(text(last + 1:last + 1), digits) == 0) exit
      last = last + 1
    end do
    if (last < at .or. next_character(text, last + 1) /= '*') return
    repeats = 0
    do i = at, last
      if (repeats > 99999999) then
        repeats = -1
        exit
      end if
      repeats = 10 * repeats + iachar(text(i:i)) - iachar('0')
    end do
    at = last + 2
  end subroutine read_repeats

  !> Room for one more group.
  pure subroutine grow_groups(list)
    type(namelist_text), intent(inout) :: list
    type(namelist_group), allocatable :: larger(:)

    if (list%group_count < size(list%groups)) return
    allocate (larger(2 * size(list%groups)))
    larger(:size(list%groups)) = list%groups
    call move_alloc(larger, list%groups)
  end subroutine grow_groups

  !> Room for one more name.
  pure subroutine grow_entries(list)
    type(namelist_text), intent(inout) :: list
    type(namelist_entry), allocatable :: larger(:)

    if (list%entry_count < size(list%entries)) return
    allocate (larger(2 * size(list%entries)))
    larger(:size(list%entries)) = list%entries
    call move_alloc(larger, list%entries)
  end subroutine grow_entries

  !> Room for one more value.
  pure subroutine grow_values(list)
    type(namelist_text), intent(inout) :: list
    type(namelist_value), allocatable :: larger(:)

    if (list%value_count < size(list%values)) return
    allocate (larger(2 * size(list%values)))
    larger(:size(list%values)) = list%values
    call move_alloc(larger, list%values)
  end subroutine grow_values

end module asperity_namelist_text
