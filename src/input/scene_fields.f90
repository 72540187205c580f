!> The values of a scene, taken from its text by group and name; or of another file of its form
!> with a table of its own.
!>
!> Each `take_` procedure leaves the value unchanged when the name does not occur in the scene, and
!> reports a problem, with its place, when the value there is not what is expected.
module asperity_scene_fields
  use asperity_decimal, only: decimal_value
  use asperity_file_kind, only: other_kind
  use asperity_height_map, only: plain_unit
  use asperity_input_text, only: check_text, lower_case, in_quotes, plain_text
  use asperity_kinds, only: int64
  use asperity_namelist_text, only: namelist_text, parse_namelist
  use asperity_numeral, only: expected_numbers, in_range, read_double_numeral, read_whole_number, &
                              without_kind
  use asperity_problems, only: decimal_text, problem_list
  use asperity_scene_names, only: find_names, known_name
  use asperity_word_hint, only: did_you_mean, one_of
  implicit none
  private

  public :: scene_fields, read_fields

  !> The text of a scene, sorted into the groups and names that are known.
  type :: scene_fields
    private
    type(namelist_text) :: list                  ! groups, names and values in their order
    type(known_name), allocatable :: known(:)    ! where those that are known stand in it
    logical, public :: is_text = .false.         !! otherwise nothing is to be taken from it
    logical, public :: given(2) = .false.        !! upper, lower: as arrays, beside the text
    logical, public :: surfaces_kept = .false.   !! of another scene: &surfaces is not looked at
    type(problem_list), public :: problems       !! what is wrong with the scene
    type(problem_list), public :: notes          !! what may be meant otherwise
  contains
    procedure :: has_group          !! whether a group stands in the scene
    procedure :: has_name           !! whether a name stands there, be its values good or not
    procedure :: value_count        !! how many values stand at a name, repeated ones counted
    procedure :: take_numbers       !! takes numbers, as many as there are places for them
    procedure :: take_pair          !! takes two numbers, or one that serves twice
    procedure :: take_number        !! takes one number
    procedure :: take_whole         !! takes one whole number of a given range
    procedure :: take_text          !! takes one text between quotes
    procedure :: take_names         !! takes short texts, as many as there are places for them
    procedure :: take_word          !! takes one of several words between quotes, as its number
    procedure :: take_units         !! takes names of units, as numbers
    procedure :: complain_of_group  !! reports a problem at a group
    procedure :: complain_of        !! reports a problem at a name
    procedure :: refuse_name        !! reports a problem at a name where it is given
    procedure :: require_name       !! reports that a name is missing
    procedure, private :: find_comma_pair, item_of, quoting_hint, refuse_units, refuse_value
    procedure, private :: find_values
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
    call fields%problems%start(file)
    call fields%notes%start(file)
    call check_text(text, expected_kind, fields%problems)
    other = other_kind(plain_text(text), kinds)
    if (other /= '') call fields%problems%add_at(1, 1, other // '; expected ' // expected_kind)
    fields%is_text = fields%problems%count() == 0
    if (.not. fields%is_text) return
    call parse_namelist(plain_text(text), fields%list, fields%problems)
    call find_names(fields%list, fields%known, fields%problems)
    ! Where no group is known, that nothing else is there goes without saying.
    if (fields%problems%count() == 0) return
    fields%is_text = any(fields%known%group_at > 0)
    if (.not. fields%is_text) call fields%problems%shorten(0)
  end subroutine read_fields

  !> Whether a group stands in the scene.
  pure logical function has_group(self, group)
    class(scene_fields), intent(in) :: self  !! the scene's text
    character(len=*), intent(in) :: group    !! a known group

    has_group = any(self%known%group == group .and. self%known%group_at > 0)
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

  !> Takes two numbers, or one that serves twice.
  subroutine take_pair(self, group, name, number_range, values)
    class(scene_fields), intent(inout) :: self         !! the scene's text
    character(len=*), intent(in) :: group, name  !! a known group, and a known name of it
    integer, intent(in) :: number_range                !! `any_number` or another range
    type(decimal_value), intent(inout) :: values(2)    !! numbers at the name

    if (self%value_count(group, name) == 1) then
      call self%take_numbers(group, name, number_range, values(:1))
      values(2) = values(1)
    else
      call self%take_numbers(group, name, number_range, values)
    end if
  end subroutine take_pair

  !> Takes numbers, as many as there are places for them.
  subroutine take_numbers(self, group, name, number_range, values)
    class(scene_fields), intent(inout) :: self        !! the scene's text
    character(len=*), intent(in) :: group, name  !! a known group, and a known name of it
    integer, intent(in) :: number_range               !! `any_number` or another range
    type(decimal_value), intent(inout) :: values(:)   !! numbers at the name
    character(len=:), allocatable :: pair
    integer, allocatable :: items(:)
    integer :: i, at
    logical :: good

    call self%refuse_units(group, name, at)
    if (at == 0) return
    call self%find_values(group, name, size(values), items)
    if (size(items) == 0) return
    call self%find_comma_pair(at, .false., pair, good)
    if (good) then
      call self%complain_of(group, name, 'found ' // pair // ', a decimal comma, expected a point')
    else if (pair /= '') then
      call self%notes%add_at_byte(self%list%text, self%list%items(at)%first, 'note: ' // pair // &
                                  ' in ' // name // ' of &' // group // ': two values, no ' // &
                                  'decimal comma; a blank behind the comma makes that sure')
    end if
    do i = 1, size(items)
      call read_double_numeral(self%list%value_text(items(i)), values(i), good)
      good = good .and. .not. self%list%items(items(i))%is_quoted
      if (good) good = in_range(values(i), number_range)
      if (.not. good) call self%refuse_value(name, items(i), trim(expected_numbers(number_range)))
    end do
  end subroutine take_numbers

  !> Takes one number.
  subroutine take_number(self, group, name, number_range, value)
    class(scene_fields), intent(inout) :: self    !! the scene's text
    character(len=*), intent(in) :: group, name  !! a known group, and a known name of it
    integer, intent(in) :: number_range           !! `any_number` or another range
    type(decimal_value), intent(inout) :: value   !! number at the name
    type(decimal_value) :: values(1)

    values = value
    call self%take_numbers(group, name, number_range, values)
    value = values(1)
  end subroutine take_number

  !> Takes one whole number of a given range.
  subroutine take_whole(self, group, name, least, most, value)
    class(scene_fields), intent(inout) :: self  !! the scene's text
    character(len=*), intent(in) :: group, name  !! a known group, and a known name of it
    integer, intent(in) :: least                !! smallest number allowed
    integer, intent(in) :: most                 !! largest number allowed
    integer, intent(inout) :: value             !! number at the name
    integer, allocatable :: items(:)
    integer :: found
    logical :: good

    call self%find_values(group, name, 1, items)
    if (size(items) == 0) return
    call read_whole_number(self%list%value_text(items(1)), found, good)
    if (good .and. found >= least .and. found <= most .and. &
        .not. self%list%items(items(1))%is_quoted) then
      value = found
    else
      call self%refuse_value(name, items(1), 'a whole number from ' // decimal_text(least) // &
                             ' to ' // decimal_text(most))
    end if
  end subroutine take_whole

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
  subroutine take_names(self, group, name, texts)
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
  end subroutine take_names

  !> Takes one of several words between quotes, as its number; 0 when it is none of them. For `on`
  !> and `off` true and false will do.
  subroutine take_word(self, group, name, words, number)
    class(scene_fields), intent(inout) :: self  !! the scene's text
    character(len=*), intent(in) :: group, name  !! a known group, and a known name of it
    character(len=*), intent(in) :: words(:)    !! words that are known
    integer, intent(inout) :: number            !! which of them; 0 when refused
    integer :: numbers(1)

    numbers = number
    call self%take_units(group, name, words, numbers)
    number = numbers(1)
  end subroutine take_word

  !> Takes names of units between quotes, as many as there are places for them, as their numbers; 0
  !> when one is refused.
  subroutine take_units(self, group, name, words, numbers)
    class(scene_fields), intent(inout) :: self  !! the scene's text
    character(len=*), intent(in) :: group, name  !! a known group, and a known name of it
    character(len=*), intent(in) :: words(:)    !! the known words
    integer, intent(inout) :: numbers(:)        !! which of them; 0 when refused
    character(len=:), allocatable :: word
    integer, allocatable :: items(:)
    integer :: i
    logical :: is_word

    if (.not. self%has_name(group, name)) return
    numbers = 0
    call self%find_values(group, name, size(numbers), items)
    do i = 1, size(items)
      word = plain_unit(lower_case(self%list%value_text(items(i))))
      is_word = self%list%items(items(i))%is_quoted
      if (.not. is_word) then
        ! A logical constant of a namelist.
        is_word = any(word == [character(len=7) :: 'true', '.true.', 'false', '.false.'])
        if (is_word) word = trim(merge('on ', 'off', index(word, 'true') > 0))
      end if
      numbers(i) = findloc(words == word, .true., 1)
      if (numbers(i) == 0) then
        call self%refuse_value(name, items(i), one_of(words) // did_you_mean(word, words))
      else if (.not. is_word) then
        call self%refuse_value(name, items(i), 'it in quotes' // self%quoting_hint(name, items(i)))
        numbers(i) = 0
      end if
    end do
  end subroutine take_units

  ! Two whole numbers among the values of a name with a comma between and no blank, where no value
  ! has a point: `12,5`, which may be meant as 12.5. Empty where there are none, where all are 0, or
  ! where more values stand without a blank and `all_pairs` is false: a list, no fraction.
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
          return
        end if
        if (i == size(items)) cycle
        if (items(i + 1)%first /= items(i)%last + 2 .or. items(i)%is_quoted .or. &
            text(items(i)%last + 1:items(i)%last + 1) /= ',' .or. &
            verify(text(items(i)%first:items(i)%last), figures // '+-') > 0 .or. &
            scan(text(items(i + 1)%first:items(i + 1)%first), figures) == 0) cycle
        joined = joined + 1
        if (verify(text(items(i)%first:items(i + 1)%last), '0,+-') == 0) cycle
        pair = text(items(i)%first:items(i + 1)%last)
        surely = surely .or. (text(items(i + 1)%first:items(i + 1)%first) == '0' .and. &
                              items(i + 1)%last > items(i + 1)%first)
      end do
      if (joined == size(items) - 1 .and. joined > 1 .and. .not. all_pairs) pair = ''
    end associate
  end subroutine find_comma_pair

  !> Reports a problem at a group; at &surfaces when that group does not occur; at the first byte of
  !> the text when neither occurs.
  subroutine complain_of_group(self, group, message)
    class(scene_fields), intent(inout) :: self  !! the scene's text
    character(len=*), intent(in) :: group       !! a known group
    character(len=*), intent(in) :: message     !! what is wrong, found, expected
    integer :: at, byte

    at = maxval(self%known%group_at, self%known%group == group)
    if (at == 0) at = maxval(self%known%group_at, self%known%group == 'surfaces')
    byte = 1
    if (at > 0) byte = self%list%items(at)%first - 1
    call self%problems%add_at_byte(self%list%text, byte, message)
  end subroutine complain_of_group

  !> Reports a problem at the place of a name in the scene; by group and name where it is absent.
  subroutine complain_of(self, group, name, message)
    class(scene_fields), intent(inout) :: self  !! the scene's text
    character(len=*), intent(in) :: group, name  !! a known group, and a known name of it
    character(len=*), intent(in) :: message     !! what is wrong, found, expected

    if (self%has_name(group, name)) then
      call self%problems%add_at_byte(self%list%text, &
           self%list%items(self%item_of(group, name))%first, name // ': ' // message)
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

  ! Refuses the first unit behind a number, since no number has one; `at` is 0 then, else the name's
  ! item, as far as it is there.
  subroutine refuse_units(self, group, name, at)
    class(scene_fields), intent(inout) :: self
    character(len=*), intent(in) :: group, name
    integer, intent(out) :: at
    character(len=:), allocatable :: word
    character(len=*), parameter :: no_units(3) = [character(len=8) :: 'nan', 'inf', 'infinity']
    integer :: i, begin

    at = self%item_of(group, name)
    if (at == 0) return
    do i = at + 1, at + self%list%items(at)%values
      if (self%list%items(i)%is_quoted) cycle
      word = lower_case(without_kind(self%list%value_text(i)))
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
      text = ': ' // name // ' = ''' // self%list%value_text(i) // ''''
  end function quoting_hint

  ! Number of a name's item in the text; 0 when the name does not stand there.
  pure integer function item_of(self, group, name)
    class(scene_fields), intent(in) :: self
    character(len=*), intent(in) :: group, name

    item_of = sum(self%known%at, self%known%group == group .and. self%known%name == name)
  end function item_of

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

  ! Reports, once, that value number `i` is not one of the expected values.
  subroutine refuse_value(self, name, i, expected)
    class(scene_fields), intent(inout) :: self
    character(len=*), intent(in) :: name, expected
    integer, intent(in) :: i
    integer :: first
    character(len=:), allocatable :: found

    if (self%list%items(i)%is_broken) return
    self%list%items(i)%is_broken = .true.
    first = self%list%items(i)%first
    found = in_quotes(without_kind(self%list%value_text(i)))
    if (self%list%items(i)%is_quoted) then
      first = first - 1
      found = 'the text ' // found
    end if
    call self%problems%add_at_byte(self%list%text, first, &
                                   name // ': found ' // found // ', expected ' // expected)
  end subroutine refuse_value

end module asperity_scene_fields
