!> Reads a height map, whose format the content of the file determines, or copies one from memory.
module asperity_height_map_reader
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use asperity_delimited_text, only: line_reader
  use asperity_height_map, only: edge_names, expected_height, check_heights, check_spacing, &
                                 give_spacing, height_map, highest, known_units, largest_height, &
                                 make_room, map_request, no_height, plain_unit, unit_number
  use asperity_input_text, only: begin_file, check_text, first_control
  use asperity_kinds, only: int64, real64
  use asperity_library_turn, only: library_turn
  use asperity_npy_map, only: npy_magic, read_npy_map
  use asperity_problems, only: decimal_text, problem_list, real_text
  use asperity_sdf_map, only: is_sdf, magic_length, read_sdf_header, read_sdf_samples, sdf_header
  use asperity_text_map, only: is_text_map, read_text_map
  implicit none
  private

  public :: read_height_map, take_height_map, is_height_map, head_length, take_map

  integer, parameter :: head_length = 65536  !! bytes that show what a file is
  character(len=*), parameter :: expected = 'a surface data file (ISO 25178-71), a matrix of ' // &
    'heights, x,y,z lines, or an array (.npy)'

contains

  !> Whether a file in the place of a surface is a height map, by its beginning.
  pure logical function is_height_map(head, has_spacing)
    character(len=*), intent(in) :: head    !! its first `head_length` bytes
    logical, intent(in) :: has_spacing      !! a spacing is given

    is_height_map = is_sdf(head(:min(len(head), magic_length))) .or. index(head, npy_magic) == 1 &
                    .or. is_text_map(head, has_spacing)
  end function is_height_map

  !> Reads and checks a map. With problems, or when `failure` is allocated because there is no
  !> memory for it, the map is not to be used.
  subroutine read_height_map(path, pixel_spacing, progress, map, problems, failure, option, &
    unit)
    character(len=*), intent(in) :: path                    !! the file; `-` is standard input
    real(real64), intent(in) :: pixel_spacing(2)  !! of a matrix along x and y; 0 when not given
    logical, intent(in) :: progress                         !! report the progress
    type(height_map), intent(out) :: map                    !! map with its heights
    type(problem_list), intent(inout) :: problems           !! all that is wrong
    character(len=:), allocatable, intent(out) :: failure   !! why there is no memory for it
    character(len=*), intent(in), optional :: option        !! that gives the spacing; `spacing`
    !> which of `length_units` lengths without a unit have; 0 or absent: none
    integer, intent(in), optional :: unit
    type(line_reader) :: file
    type(map_request) :: request
    type(library_turn) :: turn

    call turn%begin()
    request%pixel_spacing = pixel_spacing
    request%progress = progress
    request%option = 'spacing'
    if (present(option)) request%option = option
    if (present(unit)) request%unit = unit
    call file%open(path)
    call take_height_map(path, file, request, map)
    call problems%append(file%problems)
    if (allocated(file%lack)) failure = file%lack
    call file%close()
  end subroutine read_height_map

  !> Reads and checks a map from a file that is open. With problems, or when there is no memory for
  !> it, the map is not to be used.
  subroutine take_height_map(path, file, request, map)
    character(len=*), intent(in) :: path       !! name for the messages
    type(line_reader), intent(inout) :: file   !! at its first byte; gets what is wrong
    type(map_request), intent(in) :: request   !! what is given beside the map
    type(height_map), intent(out) :: map       !! map with its heights
    type(sdf_header) :: header
    character(len=:), allocatable :: fault, magic

    call file%problems%start(path)
    map%unit = ''
    call map%notes%start(path)
    call check_spacing(request%pixel_spacing, request%option, fault)
    if (fault /= '') then
      call file%problems%add(fault)
      return
    end if
    call begin_file(file, expected, file%problems)
    if (file%problems%count() > 0) return
    call file%take(magic_length, magic)
    if (is_sdf(magic)) then
      call read_sdf_header(file, magic, header)
      map%pixel_spacing = header%scale_factor(:2)
      if (file%problems%count() == 0) call take_spacing()
      if (file%problems%count() == 0) call read_sdf_samples(file, header, request%progress, map)
    else if (index(magic, npy_magic) == 1) then
      call take_spacing()
      if (file%problems%count() == 0) call read_npy_map(file, magic, request%progress, map)
    else if (len(magic) == 0) then
      call file%problems%add_at(1, 1, 'the file is empty, expected ' // expected)
    else if (first_control(magic) > 0) then
      call file%problems%add_at(1, 1, 'found a control character, expected ' // expected // &
                                '; asperity.read_map in Python reads more formats')
    else
      ! A byte that no text has says enough.
      call check_text(file%block(:file%used), expected, file%problems)
      if (file%problems%count() > 0) return
      call read_text_map(file, request, map)
    end if
    if (allocated(file%failure) .and. file%problems%count() == 0) &
      call file%problems%add_in_file('byte ' // decimal_text(file%before + int(file%at, int64)) // &
                                     ': ' // file%failure)
    if (allocated(file%lack)) file%lack = path // ': ' // file%lack
    if (file%is_refused()) return
    call check_heights(map, fault)
    if (fault /= '') call file%problems%add_in_file(fault)

  contains

    subroutine take_spacing()
      call give_spacing(map, request%pixel_spacing, request%option, request%shared, fault)
      if (fault /= '') call file%problems%add_in_file(fault)
    end subroutine take_spacing

  end subroutine take_height_map

  !> Copies a map. With problems, or when `failure` is allocated because there is no memory for it,
  !> the map is not to be used.
  subroutine take_map(which, height, along, unit, edge, map, problems, failure)
    character(len=*), intent(in) :: which      !! name of the map, for the messages
    real(real64), intent(in) :: height(:, :)   !! by column (x) and row (y); NaN where missing
    real(real64), intent(in) :: along(2)       !! spacing along x and y; 0, 0: not given
    character(len=*), intent(in) :: unit       !! of all lengths; empty: none
    integer, intent(in) :: edge                !! which of `edge_names`; 0: not given
    type(height_map), intent(out) :: map       !! map with a copy of the heights
    type(problem_list), intent(inout) :: problems           !! what is wrong
    character(len=:), allocatable, intent(out) :: failure   !! why there is no map
    character(len=:), allocatable :: fault
    integer :: before, i, j
    type(library_turn) :: turn

    call turn%begin()
    before = problems%count()
    map%columns = size(height, 1)
    map%rows = size(height, 2)
    map%pixel_spacing = along
    map%unit = plain_unit(unit)
    map%edge = edge
    call map%notes%start(which)
    call check_spacing(along, which // '.spacing', fault)
    if (fault /= '') call problems%add(fault)
    if (map%unit /= '' .and. unit_number(map%unit) == 0) then
      call problems%add(which // '.unit: found ' // unit // ', expected one of ' // known_units // &
                        ', or none')
    end if
    if (edge < 0 .or. edge > size(edge_names)) &
      call problems%add(which // '.edge: found ' // decimal_text(edge) // &
                        ', expected a number from 0 to 2')
    call make_room(map, failure)
    if (allocated(failure)) failure = which // ': ' // failure
    if (allocated(failure)) return
    rows: do j = 1, map%rows
      do i = 1, map%columns
        map%height(i, j) = no_height
        if (ieee_is_nan(height(i, j))) cycle
        map%height(i, j) = height(i, j)
        if (abs(height(i, j)) <= highest) cycle
        call problems%add(which // '.height: found ' // real_text(height(i, j)) // ' at [' // &
                          decimal_text(j - 1) // '][' // decimal_text(i - 1) // '], expected ' // &
                          expected_height)
        exit rows
      end do
    end do rows
    if (problems%count() > before) return
    call check_heights(map, fault)
    if (fault /= '') call problems%add(which // ': ' // fault)
    map%digit = spacing(largest_height(map))
  end subroutine take_map

end module asperity_height_map_reader
