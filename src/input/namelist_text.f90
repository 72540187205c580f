!> The syntax of a Fortran namelist file: text in, groups, names and values with their places out.
!>
!> The text is parsed here and not by a NAMELIST statement, so that problems have a place.
!> Nothing is known here of what the groups mean.
module asperity_namelist_text
  use asperity_input_text, only: blanks, line_end, lower_case, in_quotes
  use asperity_numeral, only: read_whole_number
  use asperity_problems, only: problem_list
  implicit none
  private

  public :: namelist_text, namelist_item, parse_namelist, a_group, a_name, a_value, &
            next_character, skip_blanks

  character(len=*), parameter :: digit_signs = '0123456789'
  character(len=*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ'
  character(len=*), parameter :: word_ends = blanks // ',/=!&''"'

  !> Kinds of items: `&name ... /`, `name = values`, or one of the values.
  integer, parameter :: a_group = 1, a_name = 2, a_value = 3

  !> A group, a name or a value.
  type :: namelist_item
    integer :: item_kind = a_value  !! which of them
    integer :: first = 1, last = 0  !! its place: without `&`, without quotes
    integer :: group = 0            !! of a name: number of its group's item
    integer :: values = 0           !! of a name: so many items that follow are its values
    integer :: repeats = 1          !! of a value: how often it stands there, `r*value`
    logical :: is_quoted = .false.  !! of a value: a text between quotes
    logical :: is_broken = .false.  !! a reported problem may hide others
  end type namelist_item

  !> A whole file.
  type :: namelist_text
    character(len=:), allocatable :: text            !! its bytes
    type(namelist_item), allocatable :: items(:)     !! in their order
    integer :: item_count = 0                        !! so many of `items` are there
  contains
    procedure :: value_text   !! the text of a value; a doubled quote is one
    procedure :: name_text    !! a name in small letters
    procedure, private :: add_item, refuse_item
  end type namelist_text

contains

  !> Splits the text of a file. Problems are added to `problems`; what could be read is kept.
  pure subroutine parse_namelist(text, list, problems)
    character(len=*), intent(in) :: text           !! the whole file
    type(namelist_text), intent(out) :: list       !! its groups, names and values
    type(problem_list), intent(inout) :: problems  !! all that is wrong
    integer :: at
    logical :: stray

    list%text = text
    allocate (list%items(64))
    at = 1
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
                                    in_quotes(text(at:max(at, word_end(text, at)))) // &
                                    ', expected ''&'' and a group''s name' // form_hint(text, at))
        stray = .true.
        call skip_item(text, at)
      end if
    end do
  end subroutine parse_namelist

  !> The text of value number `i`.
  pure function value_text(self, i) result(text)
    class(namelist_text), intent(in) :: self  !! file as groups, names and values
    integer, intent(in) :: i                  !! number of the item
    character(len=:), allocatable :: text     !! without quotes; a doubled quote is one
    character(len=1) :: quote
    integer :: at, used

    text = self%text(self%items(i)%first:self%items(i)%last)
    if (.not. self%items(i)%is_quoted) return
    quote = self%text(self%items(i)%first - 1:self%items(i)%first - 1)
    used = 0
    at = 1
    do while (at <= len(text))
      used = used + 1
      text(used:used) = text(at:at)
      at = at + merge(2, 1, text(at:at) == quote)
    end do
    text = text(:used)
  end function value_text

  !> The name of a group or of values, number `i`, in small letters.
  pure function name_text(self, i) result(text)
    class(namelist_text), intent(in) :: self  !! file as groups, names and values
    integer, intent(in) :: i                  !! number of the item
    character(len=:), allocatable :: text     !! empty for a group without a name

    text = lower_case(self%text(self%items(i)%first:self%items(i)%last))
  end function name_text

  ! Reads a group from its `&` on; `at` is left behind its end.
  pure subroutine read_group(list, at, problems)
    type(namelist_text), intent(inout) :: list
    integer, intent(inout) :: at
    type(problem_list), intent(inout) :: problems
    character(len=:), allocatable :: name
    integer :: number, ampersand

    ampersand = at
    at = name_end(list%text, ampersand + 1) + 1
    name = in_quotes(list%text(ampersand:at - 1))
    call list%add_item(namelist_item(a_group, ampersand + 1, at - 1))
    number = list%item_count
    if (at == ampersand + 1) &
      call list%refuse_item(number, ampersand, 'a group without a name: found ''&'' alone, ' // &
                            'expected a group''s name right behind it', problems)
    do
      call skip_blanks(list%text, at)
      if (at > len(list%text)) then
        call list%refuse_item(number, ampersand, 'group ' // name // ' has no end: found ' // &
                              'the end of the file, expected ''/''', problems)
        return
      end if
      select case (list%text(at:at))
      case ('/')
        at = at + 1
        return
      case ('&')
        call list%refuse_item(number, at, 'group ' // name // ' has no end: found ' // &
                              'another group, expected ''/''', problems)
        return
      case default
        call read_name(list, number, at, problems)
      end select
    end do
  end subroutine read_group

  ! Reads `name = values`; `at` is left at what is neither a value nor a comma.
  pure subroutine read_name(list, group, at, problems)
    type(namelist_text), intent(inout) :: list
    integer, intent(in) :: group
    integer, intent(inout) :: at
    type(problem_list), intent(inout) :: problems
    character(len=:), allocatable :: name
    integer :: number, last, equals
    logical :: comma

    last = name_end(list%text, at)
    name = in_quotes(list%text(at:last))
    equals = last + 1
    call skip_blanks(list%text, equals)
    if (last < at .or. next_character(list%text, equals) /= '=') then
      if (last >= at .and. next_character(list%text, equals) == '(') then
        call problems%add_at_byte(list%text, equals, 'an index is not read: found ''('', ' // &
                                  'expected ''='' and all values of ' // name)
        list%items(group)%is_broken = .true.
      end if
      call list%refuse_item(group, at, 'no name with values: found ' // &
                            in_quotes(list%text(at:max(at, word_end(list%text, at)))) // &
                            ', expected ''name = value'' or ''/''' // form_hint(list%text, at), &
                            problems)
      call skip_item(list%text, at)
      return
    end if
    call list%add_item(namelist_item(a_name, at, last, group))
    number = list%item_count
    at = equals + 1
    comma = .true.
    do
      call skip_blanks(list%text, at)
      if (next_character(list%text, at) == ',') then
        ! A comma may stand behind the last value too; two in a row leave one out.
        if (comma) call list%refuse_item(number, at, 'a value is missing: found '','', ' // &
                                         'expected a value of ' // name, problems)
        comma = .true.
        at = at + 1
      else if (value_stands(list%text, at)) then
        call read_value(list, number, at, problems)
        comma = .false.
      else
        exit
      end if
    end do
    list%items(number)%values = list%item_count - number
    if (list%item_count == number) &
      call list%refuse_item(number, at, 'a value is missing: found none, expected a value of ' // &
                            name, problems)
  end subroutine read_name

  ! Whether a value begins at a place. None does at a slash, an ampersand, the end, or a name with
  ! `=`.
  pure logical function value_stands(text, at)
    character(len=*), intent(in) :: text
    integer, intent(in) :: at
    integer :: behind

    value_stands = .false.
    if (scan(next_character(text, at), '/&=') > 0 .or. at > len(text)) return
    behind = name_end(text, at) + 1
    value_stands = behind == at
    if (value_stands) return
    call skip_blanks(text, behind)
    value_stands = scan(next_character(text, behind), '=(') == 0
  end function value_stands

  ! Reads one value of name number `name`; `at` is left behind it.
  pure subroutine read_value(list, name, at, problems)
    type(namelist_text), intent(inout) :: list
    integer, intent(in) :: name
    integer, intent(inout) :: at
    type(problem_list), intent(inout) :: problems
    type(namelist_item) :: value

    call read_repeats(list%text, at, value%repeats)
    if (value%repeats < 1 .or. scan(next_character(list%text, at), blanks // ',/=!&') > 0) then
      call problems%add_at_byte(list%text, at, 'a repeat count without a value, or not from 1 ' // &
                                'to 999999999: expected ''count*value''')
      list%items(name)%is_broken = .true.
    end if
    value%is_quoted = scan(next_character(list%text, at), '''"') > 0
    if (value%is_quoted) then
      value%first = at + 1
      value%last = quote_end(list%text, at)
      if (value%last < at) then
        call problems%add_at_byte(list%text, at, 'a text has no end: found the end of the ' // &
                                  'line, expected a second ' // list%text(at:at))
        list%items(name)%is_broken = .true.
        ! The lost part of the line may have held the group's end.
        list%items(list%items(name)%group)%is_broken = .true.
        at = line_end(list%text, at) + 1
        return
      end if
      at = value%last + 2
    else
      value%first = at
      value%last = word_end(list%text, at)
      at = value%last + 1
    end if
    call list%add_item(value)
  end subroutine read_value

  ! Reads `count*` when it stands there, and steps over it. Too large a count becomes -1.
  pure subroutine read_repeats(text, at, repeats)
    character(len=*), intent(in) :: text
    integer, intent(inout) :: at
    integer, intent(out) :: repeats
    integer :: last
    logical :: good

    repeats = 1
    last = place_before(text, at, verify(text(at:), digit_signs))
    if (last < at .or. next_character(text, last + 1) /= '*') return
    call read_whole_number(text(at:last), repeats, good)
    if (.not. good .or. repeats > 999999999) repeats = -1
    at = last + 2
  end subroutine read_repeats

  ! A remedy for comments and marks of other kinds of file; empty where there is none.
  pure function form_hint(text, at) result(hint)
    character(len=*), intent(in) :: text
    integer, intent(in) :: at
    character(len=:), allocatable :: hint
    integer :: last

    hint = ''
    last = max(at, word_end(text, at))
    if (scan(text(at:at), '#%') > 0 .or. text(at:min(len(text), at + 1)) == '//') then
      hint = '; a comment begins with ''!'''
    else if (scan(text(at:at), '{[]}"') > 0 .or. text(last:last) == ':' .or. &
             text(at:last) == '---') then
      hint = '; a scene is a Fortran namelist, as in &surfaces deck = ''a.deck'' /, not YAML, ' // &
             'JSON or TOML'
    end if
  end function form_hint

  ! Adds an item.
  pure subroutine add_item(self, item)
    class(namelist_text), intent(inout) :: self
    type(namelist_item), intent(in) :: item

    if (self%item_count == size(self%items)) self%items = [self%items, self%items]
    self%item_count = self%item_count + 1
    self%items(self%item_count) = item
  end subroutine add_item

  ! Reports a problem of an item, unless a problem that may be its cause has been reported.
  pure subroutine refuse_item(self, i, byte, message, problems)
    class(namelist_text), intent(inout) :: self
    integer, intent(in) :: i, byte
    character(len=*), intent(in) :: message
    type(problem_list), intent(inout) :: problems

    if (.not. self%items(i)%is_broken) call problems%add_at_byte(self%text, byte, message)
    self%items(i)%is_broken = .true.
  end subroutine refuse_item

  !> Steps over blanks, line ends and comments.
  pure subroutine skip_blanks(text, at)
    character(len=*), intent(in) :: text  !! the whole file
    integer, intent(inout) :: at          !! place; left behind what is stepped over

    do while (at <= len(text))
      if (text(at:at) == '!') then
        at = line_end(text, at) + 1
      else if (scan(text(at:at), blanks) > 0) then
        at = at + 1
      else
        return
      end if
    end do
  end subroutine skip_blanks

  !> Steps over one character or word or quoted text that has no place where it stands.
  pure subroutine skip_item(text, at)
    character(len=*), intent(in) :: text  !! the whole file
    integer, intent(inout) :: at          !! place; left behind what is stepped over
    integer :: last

    if (scan(text(at:at), '''"') > 0) then
      last = quote_end(text, at)
      at = merge(last + 2, line_end(text, at) + 1, last >= at)
    else
      at = max(at, word_end(text, at)) + 1
    end if
  end subroutine skip_item

  !> The character at a place, or a blank behind the end.
  pure character(len=1) function next_character(text, at)
    character(len=*), intent(in) :: text  !! the whole file
    integer, intent(in) :: at             !! place in the text

    next_character = ' '
    if (at <= len(text)) next_character = text(at:at)
  end function next_character

  !> Last letter of the name that begins at `first`; `first - 1` when none does.
  pure integer function name_end(text, first)
    character(len=*), intent(in) :: text  !! the whole file
    integer, intent(in) :: first          !! place where it begins

    name_end = first - 1
    if (scan(next_character(text, first), letters) > 0) &
      name_end = place_before(text, first, verify(text(first:), letters // digit_signs // '_'))
  end function name_end

  !> Last character of the word that begins at `first`; `first - 1` when none does.
  pure integer function word_end(text, first)
    character(len=*), intent(in) :: text  !! the whole file
    integer, intent(in) :: first          !! place where it begins

    word_end = place_before(text, first, scan(text(first:), word_ends))
  end function word_end

  !> Last character inside the quotes that open at `first`; `first - 1` when the line ends before.
  pure integer function quote_end(text, first)
    character(len=*), intent(in) :: text  !! the whole file
    integer, intent(in) :: first          !! place where it begins
    integer :: at

    quote_end = first - 1
    at = first + 1
    do while (at <= len(text))
      if (text(at:at) == achar(10)) return
      if (text(at:at) == text(first:first)) then
        if (next_character(text, at + 1) /= text(first:first)) then
          quote_end = at - 1
          return
        end if
        at = at + 1
      end if
      at = at + 1
    end do
  end function quote_end

  ! The place before the `found`-th character from `first` on; the last of the text when 0.
  pure integer function place_before(text, first, found)
    character(len=*), intent(in) :: text
    integer, intent(in) :: first, found

    place_before = merge(first + found - 2, len(text), found > 0)
  end function place_before

end module asperity_namelist_text
