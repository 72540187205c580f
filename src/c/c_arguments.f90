!> The library for C: checks and copies of its arguments.
module asperity_c_arguments
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_ptr
  use asperity, only: decimal_text, generation_spec, height_map, longest_side, &
                      parse_generation_spec, plain_unit, plane_surface, problem_list, &
                      read_generation_spec, scene_surface, take_map, take_surface
  use asperity_c_outcome, only: text_of
  implicit none
  private

  public :: c_surface, c_height_map, require_text, take_asperities, take_heights, take_spec, &
            take_word

  !> `asperity_surface` of the header.
  type, bind(c) :: c_surface
    integer(c_int) :: asperities        !! number of asperities; 0: a plane
    integer(c_int) :: radii             !! number of radii: 1, or one for each
    type(c_ptr) :: numbers(4)           !! addresses of `array_names`
  end type c_surface

  !> `asperity_height_map` of the header.
  type, bind(c) :: c_height_map
    integer(c_int) :: columns, rows     !! pixels along x and along y
    type(c_ptr) :: height               !! (column, row); NaN where missing
    real(c_double) :: pixel_spacing(2)  !! along x and y; 0, 0: not given
    type(c_ptr) :: unit                 !! name; null or empty: none
    integer(c_int) :: periodic          !! 1: yes, 0: no, -1: unknown
  end type c_height_map

  character(len=*), parameter :: array_names(4) = [character(len=6) :: 'x', 'y', 'height', 'radius']

contains

  !> Takes the asperities of a surface, or a plane.
  subroutine take_asperities(which, given, surface, problems)
    character(len=*), intent(in) :: which          !! name of the surface, for the messages
    type(c_ptr), intent(in) :: given               !! address of a `c_surface`, not null
    type(scene_surface), intent(out) :: surface    !! copy of the surface
    type(problem_list), intent(inout) :: problems  !! faults of the argument
    type(c_surface), pointer :: numbers
    real(c_double), pointer :: x(:), y(:), height(:), radius(:)
    integer :: before, i

    call c_f_pointer(given, numbers)
    if (numbers%asperities == 0_c_int) then
      surface = plane_surface()
      return
    end if
    before = problems%count()
    if (numbers%asperities < 0_c_int) then
      call problems%add(which // '.count: found ' // decimal_text(numbers%asperities) // &
                        ', expected 0 for a plane, or more')
    else if (all(numbers%radii /= [1_c_int, numbers%asperities])) then
      call problems%add(which // '.radii: found ' // decimal_text(numbers%radii) // &
                        ', expected 1 or ' // decimal_text(numbers%asperities) // ', as many as x')
    end if
    do i = 1, size(array_names)
      call require_numbers(which // '.' // trim(array_names(i)), numbers%numbers(i), problems)
    end do
    if (problems%count() == before) then
      call c_f_pointer(numbers%numbers(1), x, [numbers%asperities])
      call c_f_pointer(numbers%numbers(2), y, [numbers%asperities])
      call c_f_pointer(numbers%numbers(3), height, [numbers%asperities])
      call c_f_pointer(numbers%numbers(4), radius, [numbers%radii])
      call take_surface(which, x, y, height, radius, surface, problems)
    end if
  end subroutine take_asperities

  !> Takes a height map. `failure` is allocated when memory is short.
  subroutine take_heights(which, given, map, problems, failure)
    character(len=*), intent(in) :: which          !! name of the map, for the messages
    type(c_ptr), intent(in) :: given               !! address of a `c_height_map`
    type(height_map), intent(out) :: map           !! copy of the map
    type(problem_list), intent(inout) :: problems  !! faults of the argument
    character(len=:), allocatable, intent(out) :: failure  !! reason, when there is no map
    type(c_height_map), pointer :: numbers
    real(c_double), pointer :: height(:, :)
    integer :: before

    if (.not. c_associated(given)) then
      call problems%add(which // ': found NULL, expected a height map')
      return
    end if
    call c_f_pointer(given, numbers)
    before = problems%count()
    if (numbers%columns < 1_c_int) &
      call problems%add(which // '.columns: found ' // decimal_text(numbers%columns) // &
                        ', expected 3 or more')
    if (numbers%rows < 1_c_int) &
      call problems%add(which // '.rows: found ' // decimal_text(numbers%rows) // &
                        ', expected 3 or more')
    if (abs(numbers%periodic) > 1_c_int) &
      call problems%add(which // '.periodic: found ' // decimal_text(numbers%periodic) // &
                        ', expected 1, 0, or -1 where it is not known')
    call require_numbers(which // '.height', numbers%height, problems)
    if (problems%count() > before) return
    if (max(numbers%columns, numbers%rows) > longest_side) then
      call problems%add(which // ': found ' // decimal_text(numbers%columns) // ' x ' // &
                        decimal_text(numbers%rows) // ' pixels, expected at most ' // &
                        decimal_text(longest_side) // ' a side')
      return
    end if
    call c_f_pointer(numbers%height, height, [numbers%columns, numbers%rows])
    call take_map(which, height, numbers%pixel_spacing, text_of(numbers%unit), &
                  int(numbers%periodic) + 1, map, problems, failure)
  end subroutine take_heights

  ! Refuses an array that is missing.
  subroutine require_numbers(name, address, problems)
    character(len=*), intent(in) :: name
    type(c_ptr), intent(in) :: address
    type(problem_list), intent(inout) :: problems

    if (.not. c_associated(address)) call problems%add(name // ': found NULL, expected numbers')
  end subroutine require_numbers

  !> Refuses a path that is missing.
  subroutine require_text(name, address, problems)
    character(len=*), intent(in) :: name           !! name of the argument
    type(c_ptr), intent(in) :: address             !! address of the path
    type(problem_list), intent(inout) :: problems  !! faults of the argument

    if (.not. c_associated(address)) then
      call problems%add(name // ': found NULL, expected a path')
    else if (text_of(address) == '') then
      call problems%add(name // ': found an empty text, expected a path')
    end if
  end subroutine require_text

  !> Reads a specification of surfaces or a map: a file, or the text of its groups.
  subroutine take_spec(path, groups, spec, problems)
    type(c_ptr), intent(in) :: path                !! path of the file, where `groups` is null
    type(c_ptr), intent(in) :: groups              !! text of its groups; may be null
    type(generation_spec), intent(out) :: spec     !! specification that was read
    type(problem_list), intent(inout) :: problems  !! faults of the argument

    if (c_associated(groups)) then
      call parse_generation_spec('specification', text_of(groups), spec, problems)
    else
      call require_text('specification', path, problems)
      if (problems%count() == 0) call read_generation_spec(text_of(path), spec, problems)
    end if
  end subroutine take_spec

  !> Finds a word in a list; a null pointer leaves the choice unchanged.
  subroutine take_word(name, word, known, choice, problems)
    character(len=*), intent(in) :: name           !! name of the argument
    type(c_ptr), intent(in) :: word                !! address of its text
    character(len=*), intent(in) :: known(:)       !! list of the words
    integer, intent(inout) :: choice               !! number of the word; 0: none
    type(problem_list), intent(inout) :: problems  !! faults of the argument
    character(len=:), allocatable :: list
    integer :: i

    if (.not. c_associated(word)) return
    choice = findloc(known == plain_unit(text_of(word)), .true., 1)
    if (choice > 0) return
    list = trim(known(1))
    do i = 2, size(known)
      list = list // ', ' // trim(known(i))
    end do
    call problems%add(name // ': found ' // text_of(word) // ', expected one of ' // list)
  end subroutine take_word

end module asperity_c_arguments
