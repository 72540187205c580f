!> The library for C: what its arguments hold, checked and copied.
module asperity_c_arguments
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_ptr
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity, only: decimal_text, height_map, most_samples, plain_unit, plane_surface, &
                      problem_list, scene_surface, take_map, take_surface
  use asperity_c_outcome, only: text_of
  implicit none
  private

  public :: c_surface, c_height_map, require_text, take_asperities, take_heights, take_word

  !> `asperity_surface` of the header.
  type, bind(c) :: c_surface
    integer(c_int) :: count             !! asperities; 0: a plane
    integer(c_int) :: radii             !! 1, or as many
    type(c_ptr) :: x, y, height, radius !! their numbers
  end type c_surface

  !> `asperity_height_map` of the header.
  type, bind(c) :: c_height_map
    integer(c_int) :: columns, rows  !! pixels along x and along y
    type(c_ptr) :: height            !! (column, row); NaN where missing
    real(c_double) :: spacing(2)     !! along x and y; 0, 0: not given
    type(c_ptr) :: unit              !! name; null or empty: none
    integer(c_int) :: periodic       !! 1: yes, 0: no, -1: not known
  end type c_height_map

contains

  !> The asperities of a surface, or a plane.
  subroutine take_asperities(which, given, surface, problems)
    character(len=*), intent(in) :: which          !! name of the surface, for the messages
    type(c_ptr), intent(in) :: given               !! `c_surface`
    type(scene_surface), intent(out) :: surface    !! a copy
    type(problem_list), intent(inout) :: problems  !! what is wrong
    type(c_surface), pointer :: numbers
    real(c_double), pointer :: x(:), y(:), height(:), radius(:)
    integer :: before

    if (.not. c_associated(given)) then
      call problems%add(which // ': found NULL beside a surface that is given as arrays, ' // &
                        'expected both, or a plane')
      return
    end if
    call c_f_pointer(given, numbers)
    if (numbers%count == 0_c_int) then
      surface = plane_surface()
      return
    end if
    before = problems%count()
    if (numbers%count < 0_c_int) then
      call problems%add(which // '.count: found ' // decimal_text(numbers%count) // &
                        ', expected 0 for a plane, or more')
    else if (all(numbers%radii /= [1_c_int, numbers%count])) then
      call problems%add(which // '.radii: found ' // decimal_text(numbers%radii) // &
                        ', expected 1 or ' // decimal_text(numbers%count) // ', as many as x')
    end if
    call require_numbers(which // '.x', numbers%x, problems)
    call require_numbers(which // '.y', numbers%y, problems)
    call require_numbers(which // '.height', numbers%height, problems)
    call require_numbers(which // '.radius', numbers%radius, problems)
    if (problems%count() == before) then
      call c_f_pointer(numbers%x, x, [numbers%count])
      call c_f_pointer(numbers%y, y, [numbers%count])
      call c_f_pointer(numbers%height, height, [numbers%count])
      call c_f_pointer(numbers%radius, radius, [numbers%radii])
      call take_surface(which, x, y, height, radius, surface, problems)
    end if
  end subroutine take_asperities

  !> A height map. `failure` is allocated when there is no memory for it.
  subroutine take_heights(which, given, map, problems, failure)
    character(len=*), intent(in) :: which          !! name of the map, for the messages
    type(c_ptr), intent(in) :: given               !! `c_height_map`
    type(height_map), intent(out) :: map           !! a copy
    type(problem_list), intent(inout) :: problems  !! what is wrong
    character(len=:), allocatable, intent(out) :: failure  !! why there is no map
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
    if (int(numbers%columns, int64) * numbers%rows > most_samples) then
      call problems%add(which // ': found ' // decimal_text(numbers%columns) // ' x ' // &
                        decimal_text(numbers%rows) // ' pixels, expected at most ' // &
                        decimal_text(most_samples))
      return
    end if
    call c_f_pointer(numbers%height, height, [numbers%columns, numbers%rows])
    call take_map(which, height, numbers%spacing, text_of(numbers%unit), &
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
    character(len=*), intent(in) :: name           !! of the argument
    type(c_ptr), intent(in) :: address             !! of the path
    type(problem_list), intent(inout) :: problems  !! what is wrong

    if (.not. c_associated(address)) then
      call problems%add(name // ': found NULL, expected a path')
    else if (text_of(address) == '') then
      call problems%add(name // ': found an empty text, expected a path')
    end if
  end subroutine require_text

  !> A word of a list; a null pointer leaves the choice as it is.
  subroutine take_word(name, word, known, choice, problems)
    character(len=*), intent(in) :: name           !! of the argument
    type(c_ptr), intent(in) :: word                !! its text
    character(len=*), intent(in) :: known(:)       !! the words
    integer, intent(inout) :: choice               !! which of them; 0: none
    type(problem_list), intent(inout) :: problems  !! what is wrong
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
