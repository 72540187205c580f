!> The values of a scene, taken from its text by group and name; or of another file of its form
!> with a table of its own.
!>
!> `take` reads the values of a name as its row of the table describes them. It sets the row's
!> default when the name does not occur, leaves the value unchanged where the row has none, and
!> reports a problem, with its place, when the value there is not what is expected.
module asperity_scene_fields
  use asperity_file_kind, only: other_kind
  use asperity_height_map, only: plain_unit
  use asperity_input_text, only: check_text, lower_case, in_quotes, plain_text
  use asperity_kinds, only: int64, real64
  use asperity_namelist_text, only: a_group, a_name, namelist_text, parse_namelist
  use asperity_numeral, only: any_number, expected_numbers, in_range, read_number
  use asperity_problems, only: decimal_text, problem_list
  use asperity_word_hint, only: any_of, did_you_mean, nearest_word, one_of
  implicit none
  private

  public :: known_name, scene_fields, read_fields, values_in_words
  public :: one_text, one_word, most_words, whole_number, whole_value, word_length

  !> Kinds of values beside the ranges of numbers of `asperity_numeral`: one of the words of the
  !> row, by its place; a whole number from `least` to `most`, of digits alone, or in any form; a
  !> text between quotes.
  integer, parameter :: one_word = -1, whole_number = -2, whole_value = -3, one_text = -4
  integer, parameter :: word_length = 20  !! bytes of a word at most
  integer, parameter :: most_words = 12   !! words of a row at most

  !> One name: a row of the table of a kind of file. The names of a group stand one behind the
  !> other.
  type :: known_name
    character(len=8) :: group = ''         !! its group
    character(len=23) :: name = ''         !! the name
    integer :: value_kind = any_number     !! range of `asperity_numeral`, or a kind of value
    character(len=80) :: meaning = ''     !! in a line
    integer :: counts(2) = 1               !! fewest and most values
    real(real64) :: default = 0.0_real64   !! value where the name does not occur
    !> Default in words, where it is no value of the table; blank: `default`.
    character(len=56) :: otherwise = ''
    character(len=20) :: unit = ''         !! in words; blank: none
    character(len=word_length) :: words(most_words) = ''  !! for `one_word`
    integer :: least = 0                   !! for `whole_number`
    integer :: most = 0                    !! for `whole_number`
    character(len=10) :: beside = ''       !! name in whose place it stands; refused beside it
    logical :: stored = .false.            !! the value is read by its row alone: `scene%number`
    character(len=11) :: effect = ''       !! in &effects: effect that it belongs to; blank: all
    !> In &effects: when the scene must have it. `on`: with its effect on; `no limit`: with its
    !> effect, on or auto, and no limit; `pixels`: with its effect on the pixels of a map; the name
    !> of a number: with its effect and that number not 0.
    character(len=21) :: needed_with = ''
    character(len=12) :: instead = ''      !! in &effects: another number that does for it
    character(len=48) :: synonyms = ''     !! other words for it, each between blanks
    character(len=18) :: in_words = ''     !! what exists when it is not 0, where others need that
  end type known_name

  !> The text of a scene, sorted into the groups and names that are known.
  type :: scene_fields
    private
    type(namelist_text) :: list                  ! groups, names and values in their order
    type(known_name), allocatable :: known(:)    ! the table
    integer, allocatable :: group_at(:), at(:)   ! items of group and name of each row; 0: absent
    logical, public :: is_text = .false.         !! otherwise nothing is to be taken from it
    logical, public :: given(2) = .false.        !! upper, lower: as arrays, beside the text
    logical, public :: surfaces_kept = .false.   !! of another scene: &surfaces is not looked at
    logical, public :: lacks_file = .false.  !! a file of a surface cannot be read
    type(problem_list), public :: problems       !! what is wrong with the scene
    type(problem_list), public :: notes          !! what may be meant otherwise
  contains
    procedure :: has_group          !! whether a group stands in the scene
    procedure :: has_name           !! whether a name stands there, be its values good or not
    procedure :: value_count        !! how many values stand at a name, repeated ones counted
    !> Takes values of a name: numbers, whole numbers, words by their places, texts.
    generic :: take => take_reals, take_real, take_integers, take_integer, take_text, take_texts
    procedure, private :: take_reals, take_real, take_integers, take_integer, take_text, take_texts
    procedure :: complain_of_group  !! reports a problem at a group
    procedure :: complain_of        !! reports a problem at a name
    procedure :: refuse_name        !! reports a problem at a name where it is given
    procedure :: require_name       !! reports that a name is missing
    procedure, private :: find_names, find_comma_pair, item_of, quoting_hint, refuse_units
    procedure, private :: find_values, read_value, refuse_item, refuse_value, row_of
  end type scene_fields

contains

  !> Sorts the text of a scene by group and name; unknown and repeated names are problems.
  subroutine read_fields(file, text, expected_kind, kinds, table, fields)
    character(len=*), intent(in) :: file       !! name for the messages
    character(len=*), intent(in) :: text       !! the whole scene
    character(len=*), intent(in) :: expected_kind  !! what it should be, for a message
    integer, intent(in) :: kinds(:)            !! kinds accepted, of `asperity_file_kind`
    type(known_name), intent(in) :: table(:)   !! what is known
    type(scene_fields), intent(out) :: fields  !! its values and problems
    character(len=:), allocatable :: other

    fields%known = table
    fields%at = spread(0, 1, size(table))
    fields%group_at = fields%at
    call fields%problems%start(file)
    call fields%notes%start(file)
    call check_text(text, expected_kind, fields%problems)
    other = other_kind(plain_text(text), kinds)
    if (other /= '') call fields%problems%add_at(1, 1, other // '; expected ' // expected_kind)
    fields%is_text = fields%problems%count() == 0
    if (.not. fields%is_text) return
    call parse_namelist(plain_text(text), fields%list, fields%problems)
    call fields%find_names()
    ! Where no group is known, that nothing else is there goes without saying.
    if (fields%problems%count() == 0) return
    fields%is_text = any(fields%group_at > 0)
    if (.not. fields%is_text) call fields%problems%shorten(0)
  end subroutine read_fields

  ! Long: unknown groups and names are reported with the same list at hand.
  ! Finds the places of the known names in a text. Unknown and repeated names are problems; of a
  ! repeated name the first counts. An unknown name is taken for the known name it resembles, so
  ! that this name is not reported as missing as well.
  pure subroutine find_names(self)
    class(scene_fields), intent(inout) :: self
    character(len=len(self%known%name)) :: names(size(self%known)), groups(size(self%known))
    character(len=:), allocatable :: group, hint, name
    integer :: i, k, near

    names = self%known%name
    groups = self%known%group
    do i = 1, self%list%item_count
      if (self%list%items(i)%item_kind /= a_group) cycle
      name = self%list%name_text(i)
      if (name == '') cycle
      if (all(groups /= name)) then
        call self%refuse_item(i, 'unknown group: found ' // in_quotes('&' // name) // &
             ', expected ' // any_of(pack(groups, groups /= eoshift(groups, -1)), before='&') // &
             did_you_mean(name, groups))
        near = nearest_word(name, groups)
        if (near == 0) cycle
        if (self%group_at(near) == 0 .and. &
            .not. any([(self%list%items(k)%item_kind == a_group .and. &
                        self%list%name_text(k) == groups(near), k=1, self%list%item_count)])) then
          where (groups == groups(near)) self%group_at = i
        end if
      else if (any(groups == name .and. self%group_at > 0)) then
        call self%refuse_item(i, 'group &' // name // ' occurs twice, expected once')
      else
        where (groups == name) self%group_at = i
      end if
    end do
    do i = 1, self%list%item_count
      if (self%list%items(i)%item_kind /= a_name) cycle
      k = findloc(self%group_at, self%list%items(i)%group, 1)
      if (k > 0) then
        group = trim(groups(k))
      else
        group = self%list%name_text(self%list%items(i)%group)
        if (all(groups /= group)) cycle
      end if
      name = self%list%name_text(i)
      k = self%row_of(group, name)
      if (k == 0) then
        near = nearest_word(name, pack(names, groups == group))
        if (near > 0) near = near + findloc(groups == group, .true., 1) - 1
        if (near == 0) near = findloc(names == name, .true., 1)
        if (near == 0) near = findloc(groups == group .and. &
                                      index(self%known%synonyms, ' ' // name // ' ') > 0, .true., 1)
        hint = ''
        if (near > 0) then
          hint = '; did you mean ''' // trim(names(near)) // '''?'
          if (names(near) == name) hint = '; it is a name of &' // trim(groups(near))
        end if
        call self%refuse_item(i, 'unknown name in &' // group // ': found ' // &
             in_quotes(name) // ', expected ' // any_of(pack(names, groups == group)) // hint)
        if (near == 0) cycle
        if (self%at(near) == 0) self%at(near) = i
      else if (self%group_at(k) /= self%list%items(i)%group) then
        cycle
      else if (self%at(k) > 0) then
        call self%refuse_item(i, name // ' occurs twice in &' // group // ', expected once')
      else
        self%at(k) = i
      end if
    end do

  end subroutine find_names

  !> Whether a group stands in the scene.
  pure logical function has_group(self, group)
    class(scene_fields), intent(in) :: self  !! the scene's text
    character(len=*), intent(in) :: group    !! a known group

    has_group = any(self%known%group == group .and. self%group_at > 0)
  end function has_group

  !> Whether a name stands in the scene, be its values good or not.
  pure logical function has_name(self, group, name)
    class(scene_fields), intent(in) :: self  !! the scene's text
    character(len=*), intent(in) :: group, name  !! a known group, and a known name of it

    has_name = self%item_of(group, name) > 0
  end function has_name

  !> How many values stand at a name, repeated ones counted; 0 when it does not stand there.
  pure integer function value_count(self, group, name)
    class(scene_fields), intent(in) :: self  !! the scene's text
    character(len=*), intent(in) :: group, name  !! a known group, and a known name of it

    value_count = 0
    if (self%has_name(group, name)) &
      value_count = int(min(values_at(self%list, self%item_of(group, name)), int(huge(1), int64)))
  end function value_count

  !> Takes numbers, as many as there are places for them, whole numbers, or places of words, 0 for
  !> one that is refused. Where the row allows a single value it serves for all.
  subroutine take_reals(self, group, name, values, number_range)
    class(scene_fields), intent(inout) :: self        !! the scene's text
    character(len=*), intent(in) :: group, name  !! a known group, and a known name of it
    real(real64), intent(inout) :: values(:)          !! nearest doubles of the numbers at the name
    integer, intent(in), optional :: number_range     !! in place of that of the row
    character(len=:), allocatable :: pair
    type(known_name) :: row
    integer, allocatable :: items(:)
    integer :: i, at, wanted
    logical :: surely

    row = self%known(self%row_of(group, name))
    if (present(number_range)) row%value_kind = number_range
    at = self%item_of(group, name)
    if (at == 0 .and. row%otherwise == '') values = row%default
    if (row%beside /= '' .and. self%has_name(group, row%beside)) &
      call self%refuse_name(group, name, 'found beside ' // trim(row%beside) // &
                            ', expected one of them')
    if (row%otherwise == 'needed') &
      call self%require_name(group, name, values_in_words(row) // &
                             trim(merge(', or two', '        ', row%counts(2) == 2)))
    if (at > 0 .and. all(row%value_kind /= [one_word, whole_number])) &
      call self%refuse_units(row%name, at)
    if (at == 0) return
    if (row%value_kind == one_word) values = 0.0_real64
    wanted = size(values)
    if (row%counts(1) == 1 .and. self%value_count(group, name) == 1) wanted = 1
    call self%find_values(group, name, wanted, items)
    if (size(items) == 0) return
    if (all(row%value_kind /= [one_word, whole_number])) then
      call self%find_comma_pair(at, .false., pair, surely)
      if (surely) then
        call self%complain_of(group, name, 'found ' // pair // &
                              ', a decimal comma, expected a point')
      else if (pair /= '') then
        call self%notes%add_at_byte(self%list%text, self%list%items(at)%first, 'note: ' // pair // &
                                    ' in ' // name // ' of &' // group // ': two values, no ' // &
                                    'decimal comma; a blank behind the comma makes that sure')
      end if
    end if
    do i = 1, wanted
      call self%read_value(row, items(i), values(i))
    end do
    values(wanted + 1:) = values(1)
  end subroutine take_reals

  !> Takes one number as the nearest double.
  subroutine take_real(self, group, name, value, number_range)
    class(scene_fields), intent(inout) :: self    !! the scene's text
    character(len=*), intent(in) :: group, name  !! a known group, and a known name of it
    real(real64), intent(inout) :: value          !! number at the name
    integer, intent(in), optional :: number_range !! in place of that of the row
    real(real64) :: values(1)

    values = value
    call self%take(group, name, values, number_range)
    value = values(1)
  end subroutine take_real

  !> Takes whole numbers, or places of words, as many as there are places for them.
  subroutine take_integers(self, group, name, numbers)
    class(scene_fields), intent(inout) :: self    !! the scene's text
    character(len=*), intent(in) :: group, name  !! a known group, and a known name of it
    integer, intent(inout) :: numbers(:)          !! numbers at the name; of words 0 when refused
    real(real64) :: values(size(numbers))

    values = numbers
    call self%take(group, name, values)
    numbers = nint(values)
  end subroutine take_integers

  !> Takes one whole number, or the place of one word.
  subroutine take_integer(self, group, name, number)
    class(scene_fields), intent(inout) :: self    !! the scene's text
    character(len=*), intent(in) :: group, name  !! a known group, and a known name of it
    integer, intent(inout) :: number              !! number at the name; of a word 0 when refused
    integer :: numbers(1)

    numbers = number
    call self%take(group, name, numbers)
    number = numbers(1)
  end subroutine take_integer

  !> Takes one text between quotes. It stays unallocated when there is no good one.
  subroutine take_text(self, group, name, text)
    class(scene_fields), intent(inout) :: self             !! the scene's text
    character(len=*), intent(in) :: group, name  !! a known group, and a known name of it
    character(len=:), allocatable, intent(inout) :: text   !! text at the name
    integer, allocatable :: items(:)

    call self%find_values(group, name, 1, items)
    if (size(items) == 0) return
    if (self%list%items(items(1))%is_quoted .and. self%list%value_text(items(1)) /= '') then
      text = self%list%value_text(items(1))
    else
      call self%refuse_value(name, items(1), 'a text between quotes' // &
                             self%quoting_hint(name, items(1)))
    end if
  end subroutine take_text

  !> Takes short texts between quotes, as many as there are places for them, or none.
  subroutine take_texts(self, group, name, texts)
    class(scene_fields), intent(inout) :: self      !! the scene's text
    character(len=*), intent(in) :: group, name  !! a known group, and a known name of it
    character(len=16), intent(inout) :: texts(:)    !! the texts, with u for a micro sign
    character(len=:), allocatable :: text
    integer, allocatable :: items(:)
    integer :: i

    call self%find_values(group, name, size(texts), items)
    do i = 1, size(items)
      text = self%list%value_text(items(i))
      if (.not. self%list%items(items(i))%is_quoted .or. text == '' .or. &
          len_trim(text) > len(texts)) then
        call self%refuse_value(name, items(i), 'a text of 1 to ' // decimal_text(len(texts)) // &
                               ' bytes between quotes' // self%quoting_hint(name, items(i)))
        return
      end if
      texts(i) = plain_unit(text)
    end do
  end subroutine take_texts

  ! Reads one value. For the words `on` and `off` true and false are accepted.
  subroutine read_value(self, row, item, value)
    class(scene_fields), intent(inout) :: self
    type(known_name), intent(in) :: row
    integer, intent(in) :: item
    real(real64), intent(inout) :: value
    character(len=:), allocatable :: text, remedy
    real(real64) :: found
    integer :: number
    logical :: good, is_quoted

    text = self%list%value_text(item)
    is_quoted = self%list%items(item)%is_quoted
    remedy = ''
    if (row%value_kind == one_word) then
      text = plain_unit(lower_case(text))
      if (.not. is_quoted) then
        ! A logical constant of a namelist.
        is_quoted = any(text == [character(len=7) :: 'true', '.true.', 'false', '.false.'])
        if (is_quoted) text = trim(merge('on ', 'off', index(text, 'true') > 0))
      end if
      number = findloc(row%words == text .and. row%words /= '', .true., 1)
      good = number > 0 .and. is_quoted
      if (good) value = number
      if (number == 0) remedy = did_you_mean(text, pack(row%words, row%words /= ''))
      if (number > 0 .and. .not. good) then
        call self%refuse_value(row%name, item, 'it in quotes' // self%quoting_hint(row%name, item))
        return
      end if
    else if (row%value_kind < 0) then
      call read_number(text, found, good)
      good = good .and. abs(found - anint(found)) <= 0.0_real64 .and. found >= row%least .and. &
             found <= row%most .and. .not. is_quoted .and. &
             (row%value_kind == whole_value .or. verify(text, '+-0123456789') == 0)
      if (good) value = found
    else
      call read_number(text, value, good)
      good = good .and. .not. is_quoted .and. in_range(value, row%value_kind)
    end if
    if (.not. good) call self%refuse_value(row%name, item, values_in_words(row) // remedy)
  end subroutine read_value

  !> Values that a name may have: `a number more than 0`, `'off', 'on' or 'auto'`.
  pure function values_in_words(row) result(text)
    type(known_name), intent(in) :: row    !! row of the name
    character(len=:), allocatable :: text  !! for a message or a table

    select case (row%value_kind)
    case (one_text)
      text = 'a text between quotes'
    case (one_word)
      text = one_of(pack(row%words, row%words /= ''))
    case (whole_number, whole_value)
      text = 'a whole number from ' // decimal_text(row%least) // ' to ' // decimal_text(row%most)
    case default
      text = trim(expected_numbers(row%value_kind))
    end select
  end function values_in_words

  ! Two whole numbers among the values of a name with a comma between and no blank, where no value
  ! has a point: `12,5`, which may be meant as 12.5. Empty where there are none, where all are 0, or
  ! where more values stand without a blank and `all_pairs` is false: a list, no fraction. The
  ! second may have a point where it begins with three figures or 0: `1,000.5`.
  pure subroutine find_comma_pair(self, at, all_pairs, pair, surely)
    class(scene_fields), intent(in) :: self
    integer, intent(in) :: at                ! the name's item
    logical, intent(in) :: all_pairs
    character(len=:), allocatable, intent(out) :: pair  ! as it is written
    logical, intent(out) :: surely           ! it is a fraction: 0,05
    character(len=*), parameter :: figures = '0123456789'
    integer :: i, joined

    pair = ''
    surely = .false.
    joined = 0
    associate (items => self%list%items(at + 1:at + self%list%items(at)%values), &
               text => self%list%text)
      do i = size(items), 1, -1
        if (verify(text(items(i)%first:items(i)%last), figures // '+-eEdD') > 0) then
          pair = ''
          surely = .false.
          if (i == 1) return
          if (is_joined(i - 1) .and. (text(items(i)%first:items(i)%first) == '0' .or. &
              verify(text(items(i)%first:items(i)%last), figures) == 4)) &
            pair = text(items(i - 1)%first:items(i)%last)
          return
        end if
        if (i == size(items)) cycle
        if (.not. is_joined(i)) cycle
        joined = joined + 1
        if (verify(text(items(i)%first:items(i + 1)%last), '0,+-') == 0) cycle
        pair = text(items(i)%first:items(i + 1)%last)
        surely = surely .or. (text(items(i + 1)%first:items(i + 1)%first) == '0' .and. &
                              items(i + 1)%last > items(i + 1)%first)
      end do
      if (joined == size(items) - 1 .and. joined > 1 .and. .not. all_pairs) pair = ''
    end associate

  contains

    ! Whether a value is a whole number with a comma and a figure right behind it.
    pure logical function is_joined(i)
      integer, intent(in) :: i

      associate (items => self%list%items(at + i:at + i + 1), text => self%list%text)
        is_joined = items(2)%first == items(1)%last + 2 .and. .not. items(1)%is_quoted .and. &
                    text(items(1)%last + 1:items(1)%last + 1) == ',' .and. &
                    verify(text(items(1)%first:items(1)%last), figures // '+-') == 0 .and. &
                    scan(text(items(2)%first:items(2)%first), figures) > 0
      end associate
    end function is_joined

  end subroutine find_comma_pair

  !> Reports a problem at a group; at &surfaces when that group does not occur; at the first byte of
  !> the text when neither occurs.
  subroutine complain_of_group(self, group, message)
    class(scene_fields), intent(inout) :: self  !! the scene's text
    character(len=*), intent(in) :: group       !! a known group
    character(len=*), intent(in) :: message     !! what is wrong, found, expected
    integer :: at

    at = maxval(self%group_at, self%known%group == group)
    if (at == 0) at = maxval(self%group_at, self%known%group == 'surfaces')
    if (at > 0) call self%refuse_item(at, message)
    if (at == 0) call self%problems%add_at_byte(self%list%text, 1, message)
  end subroutine complain_of_group

  !> Reports a problem at the place of a name in the scene; by group and name where it is absent.
  subroutine complain_of(self, group, name, message)
    class(scene_fields), intent(inout) :: self  !! the scene's text
    character(len=*), intent(in) :: group, name  !! a known group, and a known name of it
    character(len=*), intent(in) :: message     !! what is wrong, found, expected

    if (self%has_name(group, name)) then
      call self%refuse_item(self%item_of(group, name), name // ': ' // message)
    else
      call self%problems%add(group // '.' // name // ': ' // message)
    end if
  end subroutine complain_of

  !> Reports a problem at a name where that stands in the scene.
  subroutine refuse_name(self, group, name, message)
    class(scene_fields), intent(inout) :: self  !! the scene's text
    character(len=*), intent(in) :: group, name  !! a known group, and a known name of it
    character(len=*), intent(in) :: message     !! what is wrong, found, expected

    if (self%has_name(group, name)) call self%complain_of(group, name, message)
  end subroutine refuse_name

  !> Reports that a required name does not occur in the scene.
  subroutine require_name(self, group, name, expected)
    class(scene_fields), intent(inout) :: self  !! the scene's text
    character(len=*), intent(in) :: group, name  !! a known group, and a known name of it
    character(len=*), intent(in) :: expected    !! what is, for instance `one`

    if (.not. self%has_name(group, name)) &
      call self%complain_of_group(group, '&' // group // ' needs ' // name // ': found none, ' // &
                                  'expected ' // expected)
  end subroutine require_name

  ! Refuses the first unit behind a number of the name at item `at`, which is 0 then: no number has
  ! one.
  subroutine refuse_units(self, name, at)
    class(scene_fields), intent(inout) :: self
    character(len=*), intent(in) :: name
    integer, intent(inout) :: at
    character(len=:), allocatable :: word
    character(len=*), parameter :: no_units(3) = [character(len=8) :: 'nan', 'inf', 'infinity']
    integer :: i, begin

    do i = at + 1, at + self%list%items(at)%values
      if (self%list%items(i)%is_quoted) cycle
      word = lower_case(self%list%value_text(i))
      begin = verify(word, '+-.0123456789')
      ! A unit is a word of its own, or stands behind the digits.
      if (begin == 0 .or. (begin == 1 .and. i == at + 1)) cycle
      word = word(begin:)
      if (any(word == no_units) .or. scan(word(1:1), '*:;()[]{}') > 0) cycle
      ! An exponent.
      if (scan(word(1:1), 'ed') > 0 .and. verify(word(2:), '+-0123456789') == 0) cycle
      call self%refuse_value(name, i, 'numbers without a unit, in the one set of units of the ' // &
                             'scene')
      at = 0
      return
    end do
  end subroutine refuse_units

  ! A remedy for a word without quotes; empty for a text that has them.
  function quoting_hint(self, name, i) result(text)
    class(scene_fields), intent(in) :: self
    character(len=*), intent(in) :: name
    integer, intent(in) :: i
    character(len=:), allocatable :: text

    text = ''
    if (.not. self%list%items(i)%is_quoted) &
      text = ': ' // trim(name) // ' = ''' // self%list%value_text(i) // ''''
  end function quoting_hint

  ! Number of a name's item in the text; 0 when the name does not stand there.
  pure integer function item_of(self, group, name)
    class(scene_fields), intent(in) :: self
    character(len=*), intent(in) :: group, name

    item_of = sum(self%at, self%known%group == group .and. self%known%name == name)
  end function item_of

  ! Row of a name in the table; 0: it is not known.
  pure integer function row_of(self, group, name)
    class(scene_fields), intent(in) :: self
    character(len=*), intent(in) :: group, name

    row_of = findloc(self%known%group == group .and. self%known%name == name, .true., 1)
  end function row_of

  ! Numbers of the items of a name's values, a repeated one as often as it counts; none when the
  ! name is absent or another count than wanted stands there, which is a problem.
  subroutine find_values(self, group, name, wanted, items)
    class(scene_fields), intent(inout) :: self
    character(len=*), intent(in) :: group, name
    integer, intent(in) :: wanted
    integer, allocatable, intent(out) :: items(:)
    character(len=:), allocatable :: pair
    integer :: at, i
    logical :: surely

    allocate (items(0))
    at = self%item_of(group, name)
    if (at == 0) return
    if (self%list%items(at)%is_broken) return
    if (values_at(self%list, at) == int(wanted, int64)) then
      items = [(spread(i, 1, self%list%items(i)%repeats), i=at + 1, &
                at + self%list%items(at)%values)]
    else
      call self%find_comma_pair(at, .true., pair, surely)
      if (pair /= '') pair = '; ' // pair // ': a decimal comma? write a point'
      call self%complain_of(group, name, 'wrong number of values: found ' // &
                            decimal_text(values_at(self%list, at)) // ', expected ' // &
                            decimal_text(wanted) // pair)
    end if
  end subroutine find_values

  ! How many values stand at a name's item, repeated ones counted.
  pure integer(int64) function values_at(list, at)
    type(namelist_text), intent(in) :: list
    integer, intent(in) :: at

    values_at = sum(int(list%items(at + 1:at + list%items(at)%values)%repeats, int64))
  end function values_at

  ! Reports a problem at an item: at the sign before the name of a group or before a text.
  pure subroutine refuse_item(self, i, message)
    class(scene_fields), intent(inout) :: self
    integer, intent(in) :: i
    character(len=*), intent(in) :: message

    associate (item => self%list%items(i))
      call self%problems%add_at_byte(self%list%text, item%first - &
           merge(1, 0, item%item_kind == a_group .or. item%is_quoted), message)
    end associate
  end subroutine refuse_item

  ! Reports, once, that value number `i` is not one of the expected values.
  subroutine refuse_value(self, name, i, expected)
    class(scene_fields), intent(inout) :: self
    character(len=*), intent(in) :: name, expected
    integer, intent(in) :: i
    character(len=:), allocatable :: found

    if (self%list%items(i)%is_broken) return
    self%list%items(i)%is_broken = .true.
    found = in_quotes(self%list%value_text(i))
    if (self%list%items(i)%is_quoted) found = 'the text ' // found
    call self%refuse_item(i, trim(name) // ': found ' // found // ', expected ' // expected)
  end subroutine refuse_value

end module asperity_scene_fields
