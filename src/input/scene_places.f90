!> Where the groups and names of a scene stand in its text; or of another file of its form with a
!> table of its own.
module asperity_scene_places
  use asperity_input_problems, only: input_problems, quoted
  use asperity_namelist_text, only: namelist_entry, namelist_text, parse_namelist
  use asperity_scene_names, only: name_table, place_in, scene_table
  implicit none
  private

  public :: scene_places

  !> The text of a scene, sorted into the groups and names that are known.
  type :: scene_places
    private
    type(namelist_text), public :: list  !! the text: groups, names and values in their order
    type(name_table) :: table
    integer, allocatable :: group_at(:)  ! number in the list; 0 when it does not stand there
    integer, allocatable :: entry_at(:)  ! the same for the names
  contains
    !> Sorts the text of a scene.
    procedure :: sort
    !> Whether a group stands in the scene.
    procedure :: has_group
    !> Whether a name stands in the scene.
    procedure :: has
    !> What stands at a name.
    procedure :: entry_of
    !> Where a group begins.
    procedure :: group_byte
  end type scene_places

contains

  !> Sorts the text of a scene; what is unknown or stands twice is told.
  subroutine sort(self, text, problems, table)
    class(scene_places), intent(out) :: self         !! the places
    character(len=*), intent(in) :: text             !! the whole scene
    type(input_problems), intent(inout) :: problems  !! all that is wrong
    type(name_table), intent(in), optional :: table  !! what is known; the scene's by default
    integer, allocatable :: known(:)
    integer :: i, at
    character(len=:), allocatable :: name

    if (present(table)) then
      self%table = table
    else
      self%table = scene_table()
    end if
    allocate (self%group_at(size(self%table%groups)), source=0)
    allocate (self%entry_at(size(self%table%names)), source=0)
    call parse_namelist(text, self%list, problems)
    ! The known group of each group of the text; negative when it stands there again.
    allocate (known(self%list%group_count))
    known = 0
    do i = 1, size(known)
      associate (group => self%list%groups(i))
        if (group%last < group%first) cycle
        name = self%list%name_text(group%first, group%last)
        known(i) = place_in(self%table%groups, name)
        if (known(i) == 0) then
          call problems%add_at_byte(text, group%first - 1, 'unknown group: found ' // &
                                    quoted('&' // name) // ', expected ' // &
                                    self%table%group_names())
        else if (self%group_at(known(i)) > 0) then
          call problems%add_at_byte(text, group%first - 1, 'group &' // name // &
                                    ' stands twice, expected once')
          known(i) = -known(i)
        else
          self%group_at(known(i)) = i
        end if
      end associate
    end do
    do i = 1, self%list%entry_count
      associate (entry => self%list%entries(i))
        if (known(entry%group) == 0) cycle
        name = self%list%name_text(entry%first, entry%last)
        at = self%table%number_of(self%table%groups(abs(known(entry%group))), name)
        if (at == 0) then
          call problems%add_at_byte(text, entry%first, 'unknown name in &' // &
               trim(self%table%groups(abs(known(entry%group)))) // ': found ' // &
               quoted(name) // ', expected ' // &
               self%table%names_of(self%table%groups(abs(known(entry%group)))))
        else if (known(entry%group) > 0) then
          if (self%entry_at(at) > 0) then
            call problems%add_at_byte(text, entry%first, name // ' stands twice in &' // &
                                      trim(self%table%names(at)%group) // ', expected once')
          else
            self%entry_at(at) = i
          end if
        end if
      end associate
    end do
  end subroutine sort

  !> Whether a group stands in the scene.
  pure logical function has_group(self, group)
    class(scene_places), intent(in) :: self  !! the places
    character(len=*), intent(in) :: group    !! a known group

    has_group = self%group_at(place_in(self%table%groups, group)) > 0
  end function has_group

  !> Whether a name stands in the scene, be its values good or not.
  pure logical function has(self, group, name)
    class(scene_places), intent(in) :: self  !! the places
    character(len=*), intent(in) :: group    !! a known group
    character(len=*), intent(in) :: name     !! a known name of it

    has = self%entry_at(self%table%number_of(group, name)) > 0
  end function has

  !> What stands at a name that stands in the scene.
  pure type(namelist_entry) function entry_of(self, group, name)
    class(scene_places), intent(in) :: self  !! the places
    character(len=*), intent(in) :: group    !! a known group
    character(len=*), intent(in) :: name     !! a known name of it

    entry_of = self%list%entries(self%entry_at(self%table%number_of(group, name)))
  end function entry_of

  !> Byte at which a group begins, from 1; that of the table's first when it does not stand there,
  !> and the first of the text when that does not either.
  pure integer function group_byte(self, group)
    class(scene_places), intent(in) :: self  !! the places
    character(len=*), intent(in) :: group    !! a known group

    group_byte = 1
    if (self%group_at(1) > 0) group_byte = self%list%groups(self%group_at(1))%first - 1
    if (self%has_group(group)) &
      group_byte = self%list%groups(self%group_at(place_in(self%table%groups, group)))%first - 1
  end function group_byte

end module asperity_scene_places
