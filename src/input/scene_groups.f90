!> The groups of a scene as a table in text, for programs that change some of them and solve again.
module asperity_scene_groups
  use asperity_decimal, only: decimal_value
  use asperity_file_kind, only: group_start
  use asperity_input_text, only: replaced_text
  use asperity_kinds, only: real64
  use asperity_namelist_text, only: a_group, a_name, namelist_text, parse_namelist
  use asperity_numeral, only: read_numeral, rounded_decimal
  use asperity_problems, only: decimal_text, problem_list, real_text
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
    type(namelist_text) :: list
    type(problem_list) :: problems
    character(len=:), allocatable :: group, text
    integer :: i, quotes, value

    text = scene_in%text
    ! A deck alone stands for its sweep without interaction. Its name is relative to its own folder,
    ! as names in a scene are.
    associate (file => scene_in%file, motion => scene_in%motion)
      if (scene_in%from_deck .and. group_start(text) == 0) text = '&surfaces deck = ''' // &
        replaced_text(file(index(file, '/', back=.true.) + 1:), '''', '''''') // &
        ''' / &motion x_first = ' // numeral_text(motion%x_first) // ', x_step = ' // &
        numeral_text(motion%x_step) // ', y_first = ' // numeral_text(motion%y_first) // &
        ', y_step = ' // numeral_text(motion%y_step) // ', positions = ' // &
        decimal_text(motion%positions) // ' / &effects interaction = ''off'' /'
    end associate
    lines = ''
    group = ''
    call parse_namelist(text, list, problems)
    do i = 1, list%item_count
      if (list%items(i)%item_kind == a_group) group = list%name_text(i)
      if (list%items(i)%item_kind /= a_name) cycle
      lines = lines // group // tabulator // list%name_text(i) // tabulator
      do value = i + 1, i + list%items(i)%values
        if (value > i + 1) lines = lines // ', '
        ! With its quotes and repeats.
        associate (item => list%items(value))
          quotes = merge(1, 0, item%is_quoted)
          if (item%repeats > 1) lines = lines // decimal_text(item%repeats) // '*'
          lines = lines // list%text(item%first - quotes:item%last + quotes)
        end associate
      end do
      lines = lines // new_line('a')
    end do
  end function list_groups

  ! The shortest number that is read as just this double, for instance `1e-1`.
  pure function numeral_text(value) result(text)
    real(real64), intent(in) :: value
    character(len=:), allocatable :: text
    type(decimal_value) :: decimal
    integer :: digit_count
    logical :: good

    do digit_count = 1, 17
      if (.not. abs(rounded_decimal(value, digit_count) - value) > 0.0_real64) exit
    end do
    call read_numeral(real_text(value, 'es24.' // decimal_text(min(digit_count, 17) - 1) // 'e3'), &
                      decimal, good)
    text = decimal_text(decimal%all_digits)
    if (decimal%power_of_ten /= 0) text = text // 'e' // decimal_text(decimal%power_of_ten)
  end function numeral_text

end module asperity_scene_groups
