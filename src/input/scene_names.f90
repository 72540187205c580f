!> The groups and names that a scene knows, and what any such table answers.
module asperity_scene_names
  use asperity_effect_names, only: effect_numbers, known_effects
  use asperity_input_problems, only: quoted
  implicit none
  private

  public :: known_name, name_table, scene_table
  public :: place_in, or_comma, one_of

  ! The groups of a scene.
  character(len=*), parameter :: groups(7) = [character(len=8) :: &
    'surfaces', 'material', 'motion', 'tilt', 'loading', 'limit', 'effects']

  !> One name and its group.
  type :: known_name
    character(len=8) :: group = ''   !! its group
    character(len=21) :: name = ''   !! the name
  end type known_name

  !> What a kind of file knows.
  type :: name_table
    character(len=8), allocatable :: groups(:)      !! its groups
    type(known_name), allocatable :: names(:)       !! all names
  contains
    !> Number of a name among all known ones.
    procedure :: number_of
    !> All groups, for a message.
    procedure :: group_names
    !> All names of a group, for a message.
    procedure :: names_of
  end type name_table

  ! The names of a scene but those of &effects; a new one needs a line here and one in the reader.
  type(known_name), parameter :: names(*) = [ &
    known_name('surfaces', 'deck'), known_name('surfaces', 'upper'), &
    known_name('surfaces', 'lower'), known_name('surfaces', 'radius'), &
    known_name('material', 'elastic_modulus'), known_name('material', 'poisson_ratio'), &
    known_name('motion', 'x_first'), known_name('motion', 'x_step'), &
    known_name('motion', 'y_first'), known_name('motion', 'y_step'), &
    known_name('motion', 'positions'), &
    known_name('tilt', 'upper_slope'), known_name('tilt', 'lower_slope'), &
    known_name('tilt', 'rotation'), &
    known_name('loading', 'control'), known_name('loading', 'value'), &
    known_name('loading', 'points'), &
    known_name('limit', 'criterion'), known_name('limit', 'value'), &
    known_name('limit', 'hardness'), known_name('limit', 'yield_stress')]

contains

  !> The table of a scene.
  pure function scene_table() result(table)
    type(name_table) :: table  !! its groups and names
    integer :: i, own, with_effects

    own = size(names)
    with_effects = own + size(known_effects)
    allocate (table%groups(size(groups)), table%names(with_effects + size(effect_numbers)))
    table%groups = groups
    table%names(:own) = names
    do i = 1, size(known_effects)
      table%names(own + i) = known_name('effects', known_effects(i)%name)
    end do
    do i = 1, size(effect_numbers)
      table%names(with_effects + i) = known_name('effects', effect_numbers(i)%name)
    end do
  end function scene_table

  !> Number of a name among all known ones; 0 when the group has none such.
  pure integer function number_of(self, group, name)
    class(name_table), intent(in) :: self  !! the table
    character(len=*), intent(in) :: group  !! a group
    character(len=*), intent(in) :: name   !! a name, known or not

    do number_of = size(self%names), 1, -1
      if (self%names(number_of)%group == group .and. self%names(number_of)%name == name) exit
    end do
  end function number_of

  !> Place of a word in a list; 0 when it is not there.
  pure integer function place_in(words, word)
    character(len=*), intent(in) :: words(:)  !! the list
    character(len=*), intent(in) :: word      !! the word

    do place_in = size(words), 1, -1
      if (words(place_in) == word) exit
    end do
  end function place_in

  !> `&surfaces, &material ... or &effects`.
  pure function group_names(self) result(text)
    class(name_table), intent(in) :: self  !! the table
    character(len=:), allocatable :: text  !! for a message
    integer :: i

    text = '&' // trim(self%groups(1))
    do i = 2, size(self%groups)
      text = text // or_comma(i, size(self%groups)) // '&' // trim(self%groups(i))
    end do
  end function group_names

  !> `x_first, x_step ... or positions`.
  pure function names_of(self, group) result(text)
    class(name_table), intent(in) :: self  !! the table
    character(len=*), intent(in) :: group  !! a known group
    character(len=:), allocatable :: text  !! for a message
    integer :: i, total, used

    total = 0
    do i = 1, size(self%names)
      if (self%names(i)%group == group) total = total + 1
    end do
    text = ''
    used = 0
    do i = 1, size(self%names)
      if (self%names(i)%group /= group) cycle
      used = used + 1
      if (used > 1) text = text // or_comma(used, total)
      text = text // trim(self%names(i)%name)
    end do
  end function names_of

  !> What stands before item `i` of `total` in a list.
  pure function or_comma(i, total) result(text)
    integer, intent(in) :: i      !! place in the list, from 2
    integer, intent(in) :: total  !! length of the list
    character(len=:), allocatable :: text  !! for a message

    text = ', '
    if (i == total) text = ' or '
  end function or_comma

  !> `'off', 'on' or 'auto'`.
  pure function one_of(words) result(text)
    character(len=*), intent(in) :: words(:)  !! at least one
    character(len=:), allocatable :: text     !! for a message
    integer :: i

    text = quoted(trim(words(1)))
    do i = 2, size(words)
      text = text // or_comma(i, size(words)) // quoted(trim(words(i)))
    end do
  end function one_of

end module asperity_scene_names
