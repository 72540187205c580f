!> The groups and names that a scene or another file of its form knows, and where they stand in one.
module asperity_scene_names
  use asperity_effect_names, only: effect_numbers, known_effects
  use asperity_input_text, only: in_quotes
  use asperity_namelist_text, only: a_group, a_name, namelist_text
  use asperity_problems, only: problem_list
  use asperity_word_hint, only: any_of, did_you_mean, nearest_word
  implicit none
  private

  public :: known_name, in_group, scene_table, find_names

  !> One name and its group. An array of them, the names of a group one behind the other, is what a
  !> kind of file knows.
  type :: known_name
    character(len=8) :: group = ''   !! its group
    character(len=23) :: name = ''   !! the name
    integer :: group_at = 0          !! item of the file's text; 0 when the group is not there
    integer :: at = 0                !! item of the file's text; 0 when the name is not there
  end type known_name

contains

  !> A name, or several, of a group.
  elemental type(known_name) function in_group(group, name)
    character(len=*), intent(in) :: group  !! name of the group
    character(len=*), intent(in) :: name   !! name in the group

    in_group = known_name(group, name)
  end function in_group

  !> The names of a scene; a new name needs its place here and a line in the reader. Those of
  !> &effects stand in `asperity_effect_names`.
  pure function scene_table() result(table)
    type(known_name), allocatable :: table(:)  !! all names

    table = [in_group('surfaces', [character(len=13) :: 'deck', 'upper', 'lower', 'radius', &
                                   'nominal_area', 'units', 'map_edge', 'map_level', 'map_unit', &
                                   'map_spacing', 'map_despike', 'form_radius', &
                                   'field_spacing']), &
             in_group('material', [character(len=15) :: 'elastic_modulus', 'poisson_ratio', &
                                   'contact_modulus']), &
             in_group('motion', [character(len=9) :: 'x_first', 'x_step', 'y_first', 'y_step', &
                                 'positions']), &
             in_group('tilt', [character(len=11) :: 'upper_slope', 'lower_slope', 'rotation']), &
             in_group('loading', [character(len=23) :: 'control', 'value', 'points', 'events', &
                                  'tangential_load', 'tangential_displacement']), &
             in_group('limit', [character(len=12) :: 'criterion', 'value', 'hardness', &
                                'yield_stress']), &
             in_group('effects', known_effects%name), in_group('effects', effect_numbers%name)]
  end function scene_table

  ! Long: unknown groups and names are reported with the same list at hand.
  !> Finds the places of the known names in a text. Unknown and repeated names are problems; of a
  !> repeated name the first counts. An unknown name is taken for the known name it resembles, so
  !> that this name is not reported as missing as well.
  pure subroutine find_names(list, known, problems)
    type(namelist_text), intent(in) :: list        !! text as groups, names and values
    type(known_name), intent(inout) :: known(:)    !! gets the items of names and groups
    type(problem_list), intent(inout) :: problems  !! all that is wrong
    character(len=len(known%name)) :: names(size(known)), groups(size(known))
    character(len=:), allocatable :: group, name
    integer :: i, k, near

    names = known%name
    groups = known%group
    do i = 1, list%item_count
      if (list%items(i)%item_kind /= a_group) cycle
      name = list%name_text(i)
      if (name == '') cycle
      if (all(known%group /= name)) then
        call problems%add_at_byte(list%text, list%items(i)%first - 1, 'unknown group: found ' // &
             in_quotes('&' // name) // ', expected ' // &
             any_of(pack(groups, groups /= eoshift(groups, -1)), before='&') // &
             did_you_mean(name, groups))
        near = nearest_word(name, groups)
        if (near == 0) cycle
        if (known(near)%group_at == 0 .and. &
            .not. any([(list%items(k)%item_kind == a_group .and. &
                        list%name_text(k) == known(near)%group, k=1, list%item_count)])) then
          where (known%group == known(near)%group) known%group_at = i
        end if
      else if (any(known%group == name .and. known%group_at > 0)) then
        call problems%add_at_byte(list%text, list%items(i)%first - 1, 'group &' // name // &
                                  ' occurs twice, expected once')
      else
        where (known%group == name) known%group_at = i
      end if
    end do
    do i = 1, list%item_count
      if (list%items(i)%item_kind /= a_name) cycle
      k = findloc(known%group_at, list%items(i)%group, 1)
      if (k > 0) then
        group = trim(known(k)%group)
      else
        group = list%name_text(list%items(i)%group)
        if (all(known%group /= group)) cycle
      end if
      name = list%name_text(i)
      k = findloc(known%group == group .and. known%name == name, .true., 1)
      if (k == 0) then
        near = nearest_word(name, pack(names, groups == group))
        if (near > 0) near = near + findloc(known%group == group, .true., 1) - 1
        if (near == 0) near = findloc(known%name == name, .true., 1)
        call problems%add_at_byte(list%text, list%items(i)%first, 'unknown name in &' // group // &
             ': found ' // in_quotes(name) // ', expected ' // &
             any_of(pack(names, groups == group)) // what_is_meant(near))
        if (near == 0) cycle
        if (known(near)%at == 0) known(near)%at = i
      else if (known(k)%group_at /= list%items(i)%group) then
        cycle
      else if (known(k)%at > 0) then
        call problems%add_at_byte(list%text, list%items(i)%first, name // ' occurs twice in &' // &
                                  group // ', expected once')
      else
        known(k)%at = i
      end if
    end do

  contains

    ! Meaning of an unknown name, for a message: one like it of this group, or one of another group.
    pure function what_is_meant(k) result(text)
      integer, intent(in) :: k
      character(len=:), allocatable :: text

      text = ''
      if (k == 0) return
      text = '; did you mean ''' // trim(known(k)%name) // '''?'
      if (known(k)%name == name) text = '; it is a name of &' // trim(known(k)%group)
    end function what_is_meant

  end subroutine find_names

end module asperity_scene_names
