!> The groups of a scene as a table in text, for programs that change some of them and solve again.
module asperity_scene_groups
  use asperity_decimal, only: decimal_value
  use asperity_file_kind, only: group_start
  use asperity_namelist_text, only: a_group, a_name, namelist_text, parse_namelist
  use asperity_problems, only: decimal_text, problem_list
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: list_groups

  character(len=1), parameter :: tabulator = achar(9)

contains

  !> A line a name: `GROUP, NAME, VALUES` with tabulators between, values as they stand in the text,
  !> commas between. A card deck has the lines of the scene that says the same.
  function list_groups(scene_in) result(lines)
    type(scene), intent(in) :: scene_in     !! read or built without problems
    character(len=:), allocatable :: lines  !! empty where there are none

    if (scene_in%from_deck .and. group_start(scene_in%text) == 0) then
      lines = lines_of_deck(scene_in)
    else
      lines = lines_of_text(scene_in%text)
    end if
  end function list_groups

  ! The names of a text and their values.
  function lines_of_text(text) result(lines)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: lines
    type(namelist_text) :: list
    type(problem_list) :: problems
    character(len=:), allocatable :: group
    integer :: i, value

    lines = ''
    group = ''
    call parse_namelist(text, list, problems)
    do i = 1, list%item_count
      if (list%items(i)%item_kind == a_group) group = list%name_text(i)
      if (list%items(i)%item_kind /= a_name) cycle
      lines = lines // group // tabulator // list%name_text(i) // tabulator
      do value = i + 1, i + list%items(i)%values
        if (value > i + 1) lines = lines // ', '
        lines = lines // as_it_stands(list, value)
      end do
      lines = lines // new_line('a')
    end do
  end function lines_of_text

  ! A value with its quotes and repeats.
  function as_it_stands(list, value) result(text)
    type(namelist_text), intent(in) :: list
    integer, intent(in) :: value
    character(len=:), allocatable :: text

    associate (item => list%items(value))
      if (item%is_quoted) then
        text = list%text(item%first - 1:item%last + 1)
      else
        text = list%text(item%first:item%last)
      end if
      if (item%repeats > 1) text = decimal_text(item%repeats) // '*' // text
    end associate
  end function as_it_stands

  ! A deck alone stands for its sweep without interaction. Its name is relative to its own folder,
  ! as names in a scene are.
  function lines_of_deck(scene_in) result(lines)
    type(scene), intent(in) :: scene_in
    character(len=:), allocatable :: lines

    associate (file => scene_in%file, motion => scene_in%motion)
      lines = lines_of_text('&surfaces deck = ' // &
        quoted_value(file(index(file, '/', back=.true.) + 1:)) // ' / &motion x_first = ' // &
        numeral_text(motion%x_first) // ', x_step = ' // numeral_text(motion%x_step) // &
        ', y_first = ' // numeral_text(motion%y_first) // ', y_step = ' // &
        numeral_text(motion%y_step) // ', positions = ' // decimal_text(motion%positions) // &
        ' / &effects interaction = ''off'' /')
    end associate
  end function lines_of_deck

  ! A number that is read as just this decimal.
  pure function numeral_text(value) result(text)
    type(decimal_value), intent(in) :: value
    character(len=:), allocatable :: text

    text = decimal_text(value%all_digits)
    if (value%all_digits /= 0 .and. value%power_of_ten /= 0) &
      text = text // 'e' // decimal_text(value%power_of_ten)
  end function numeral_text

  pure function quoted_value(word) result(text)
    character(len=*), intent(in) :: word
    character(len=:), allocatable :: text
    integer :: i

    text = ''''
    do i = 1, len(word)
      text = text // word(i:i)
      if (word(i:i) == '''') text = text // ''''
    end do
    text = text // ''''
  end function quoted_value

end module asperity_scene_groups
