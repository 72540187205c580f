!> Kind of file that a text is, for a user who named one where another kind is expected.
module asperity_file_kind
  use asperity_input_text, only: blanks, line_end, lower_case
  use asperity_namelist_text, only: next_character, skip_blanks
  use asperity_npy_map, only: npy_magic
  implicit none
  private

  public :: a_scene, a_specification, a_surface, group_start, other_kind

  !> Kinds of files that are recognised by their text. Card decks and maps of plain numbers are not.
  integer, parameter :: a_scene = 1, a_specification = 2, a_surface = 3, a_map = 4

  ! Name of each kind, and the command that takes it.
  character(len=*), parameter :: advice(4) = [character(len=76) :: 'a scene: asperity solve FILE', &
    'a specification of surfaces: asperity generate FILE', &
    'a surface: name it in &surfaces of a scene, then asperity solve SCENE', &
    'a height map: asperity summits FILE, or name it in &surfaces of a scene']

contains

  !> `found a surface: ...` when the text is plainly of another kind than those wanted, or nothing.
  pure function other_kind(text, wanted) result(message)
    character(len=*), intent(in) :: text      !! the file, or its beginning
    integer, intent(in) :: wanted(:)          !! kinds that may stand here
    character(len=:), allocatable :: message  !! what was found and what to do with it
    integer :: found_kind

    message = ''
    found_kind = kind_of(text)
    if (found_kind > 0 .and. all(wanted /= found_kind)) message = 'found ' // &
      trim(advice(found_kind))
  end function other_kind

  ! The kind, or 0.
  pure integer function kind_of(text)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: small, line
    integer :: at

    kind_of = 0
    at = 1
    small = lower_case(text(:min(len(text), 20000)))
    if (any(small(at:min(len(small), at + 3)) == ['abcr', 'bbcr', 'aiso', 'biso']) .or. &
        index(small, lower_case(npy_magic)) == 1) kind_of = a_map
    call skip_blanks(small, at)
    if (group_start(small) > 0) then
      if (any([index(small, '&heights'), index(small, '&radii'), index(small, '&map')] > 0)) &
        kind_of = a_specification
      if (any([index(small, '&loading'), index(small, '&effects'), index(small, '&motion'), &
               index(small, '&tilt'), index(small, '&limit')] > 0)) &
        kind_of = merge(a_scene, 0, kind_of == 0)
    else if (kind_of == 0 .and. at <= len(small)) then
      do while (next_character(small, at) == '#')
        at = line_end(small, at) + 1
        if (at <= len(small)) at = at + verify(small(at:), blanks) - 1
      end do
      if (at > len(small)) return
      line = small(at:line_end(small, at))
      if (all([index(line, 'x'), index(line, 'y'), index(line, 'height')] > 0) .and. &
          scan(line, ',;' // achar(9)) > 0) kind_of = a_surface
    end if
  end function kind_of

  !> The byte of the first `&` that begins a line, or 0: a card deck, a surface or a map has none.
  pure integer function group_start(text)
    character(len=*), intent(in) :: text  !! the file, or its beginning
    integer :: at, last

    at = 1
    do while (at <= len(text))
      last = line_end(text, at)
      group_start = at - 1 + verify(text(at:last), ' ' // achar(9))
      if (index(text(max(at, group_start):last), '&') == 1) return
      at = last + 2
    end do
    group_start = 0
  end function group_start

end module asperity_file_kind
