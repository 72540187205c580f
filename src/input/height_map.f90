!> A measured surface: heights on a regular grid.
module asperity_height_map
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_input_text, only: lower_case
  use asperity_kinds, only: int64, real64
  use asperity_numeral, only: a_length, expected_numbers, least_length, most_length, read_numeral
  use asperity_problems, only: decimal_text, problem_list, real_text
  use asperity_process, only: check_memory
  implicit none
  private

  public :: height_map, layered_body, map_request, change_unit, copy_map, move_map, put_in_unit, &
            give_spacing, check_heights, check_spacing, known_units, length_units, unit_number, &
            unit_ratio, plain_unit, no_height, is_measured, is_length, make_room, read_height, &
            expected_length, expected_height, highest, largest_height, &
            longest_side, digit_of, no_power, edge_names, index_beside, level_mean, level_names, &
            level_none, level_plane, free_edge, note_repeated_line, periodic_edge, usual_level

  !> Edges: the half-space goes on without load beyond a free map; a periodic map repeats itself.
  character(len=*), parameter :: edge_names(2) = [character(len=8) :: 'free', 'periodic']
  integer, parameter :: free_edge = 1, periodic_edge = 2  !! the first and the second of them
  !> Levels from which heights are measured: the plane of least squares, the mean height, or the
  !> heights as they are.
  integer, parameter :: level_plane = 1, level_mean = 2, level_none = 3
  !> Their names in scenes and on the command line.
  character(len=*), parameter :: level_names(3) = [character(len=5) :: 'plane', 'mean', 'none']

  !> Stands for the height of a sample that was not measured.
  real(real64), parameter :: no_height = -huge(1.0_real64)

  character(len=*), parameter :: known_units = 'm, mm, um, nm, cm, in'  !! units, for a message
  !> Units of length.
  character(len=*), parameter :: length_units(6) = [character(len=2) :: 'm', 'mm', 'um', 'nm', &
    'cm', 'in']
  ! How many of each are a metre.
  real(real64), parameter :: metre_in(6) = [1.0_real64, 1.0e3_real64, 1.0e6_real64, &
    1.0e9_real64, 1.0e2_real64, 1.0_real64 / 0.0254_real64]

  !> Most columns or rows. Derived: a padded side, up to 9/4 of it, is counted in 32 bits, and the
  !> bytes of a map of such sides in 64.
  integer, parameter :: longest_side = 2**29
  real(real64), parameter :: highest = 1.0e30_real64  !! larger heights are refused
  !> Heights that are accepted, for a message.
  character(len=*), parameter :: expected_height = 'a height of at most 1e30, or NaN where missing'
  integer, parameter :: fewest = 3  ! fewer pixels a side have no summit
  ! Squares of flatter maps would not fit in a double.
  real(real64), parameter :: least_range = 1.0e-60_real64
  integer, parameter :: longest_cell = 120  ! characters of a height at most: a number has fewer
  integer, parameter :: no_power = huge(0)  !! no digit was read yet
  !> Lengths that are accepted, for a message.
  character(len=*), parameter :: expected_length = trim(expected_numbers(a_length))

  !> A half-space under a bonded layer of another material.
  type :: layered_body
    real(real64) :: thickness = 0.0_real64   !! of the layer [length]; 0: none
    real(real64) :: modulus(2) = 0.0_real64  !! Young's, at the surface and of the base; 0: rigid
    real(real64) :: ratio(2) = 0.0_real64    !! Poisson's, at the surface and of the base
  end type layered_body

  !> The map. Lengths are in `unit`; y grows with the row.
  type :: height_map
    integer :: columns = 0                      !! samples of a profile, along x
    integer :: rows = 0                         !! profiles, along y
    real(real64) :: pixel_spacing(2) = 0.0_real64  !! of pixels along x and y; 0: not given
    real(real64), allocatable :: height(:, :)   !! by column and row; `no_height` where missing
    character(len=:), allocatable :: unit       !! of all lengths; empty where the file has none
    !> Height of one unit in the last digit of the file's heights; 0: not known.
    real(real64) :: digit = 0.0_real64
    real(real64) :: metre_spacing(2) = 0.0_real64  !! that of a file in metres; 0: of another file
    logical :: own_spacing = .true.             !! the spacing came with the heights
    integer :: edge = 0                         !! which of `edge_names` came with them; 0: none
    type(problem_list) :: notes                 !! what is odd about the file, no error
    logical :: periodic = .false.               !! it repeats itself along x and y: it has no edge
    integer :: strip_axis = 0                   !! axis along which alone it repeats itself; 0: none
    logical :: is_between = .false.             !! moved by a part of a pixel: waves in between
    type(layered_body) :: bodies(2)             !! upper and lower, with layers of their thickness
  contains
    procedure :: repeats => repeats_along       !! whether it repeats itself along an axis
  end type height_map

  !> Numbers and options that are given beside a map: in a scene, on the command line, as arguments.
  type :: map_request
    real(real64) :: pixel_spacing(2) = 0.0_real64   !! of a matrix along x and y; 0 when not given
    integer :: unit = 0  !! which of `length_units` lengths without a unit have; 0: none
    character(len=:), allocatable :: option  !! name of the spacing, for the messages
    logical :: shared = .false.              !! no spacing for a map that has its own
    logical :: progress = .false.            !! report the progress
  end type map_request

contains

  !> Whether a map repeats itself along an axis.
  pure logical function repeats_along(self, axis)
    class(height_map), intent(in) :: self  !! a height map
    integer, intent(in) :: axis            !! 1: x, 2: y

    repeats_along = self%periodic .or. self%strip_axis == axis
  end function repeats_along

  !> Whether a sample was measured.
  elemental logical function is_measured(height)
    real(real64), intent(in) :: height  !! of the sample

    is_measured = height > 0.5_real64 * no_height
  end function is_measured

  !> The level of a map for which none is asked: the plane of least squares of a free map, the mean
  !> of a periodic one, which an inclined plane would make discontinuous at its ends.
  elemental integer function usual_level(periodic) result(level)
    logical, intent(in) :: periodic  !! whether the map is

    level = merge(level_mean, level_plane, periodic)
  end function usual_level

  !> The column or row that a step leads to: beyond an end of a periodic map its other end, beyond
  !> the edge of a free one 0.
  elemental integer function index_beside(place, number, periodic) result(there)
    integer, intent(in) :: place      !! column or row, with the step; may lie beyond an end
    integer, intent(in) :: number     !! columns or rows of the map
    logical, intent(in) :: periodic   !! whether the map is

    there = place
    if (place >= 1 .and. place <= number) return
    there = 0
    if (periodic) there = 1 + modulo(place - 1, number)
  end function index_beside

  !> Whether a number will do as a spacing or a scale.
  elemental logical function is_length(value)
    real(real64), intent(in) :: value  !! any finite number

    is_length = value >= least_length .and. value <= most_length
  end function is_length

  !> Adds a note where the last column or row of a periodic map repeats its first, as a period then
  !> has it twice. Where all lines are alike along an axis none is repeated.
  subroutine note_repeated_line(map)
    type(height_map), intent(inout) :: map  !! with all heights; its notes are added to
    real(real64), parameter :: rounding = 1.0e-9_real64  ! of heights, over their range (chosen)
    real(real64) :: least

    if (.not. map%periodic) return
    least = rounding * (maxval(map%height) - minval(map%height, is_measured(map%height)))
    call check_line('column', map%height(1, :), map%height(map%columns, :), map%height(2, :))
    call check_line('row', map%height(:, 1), map%height(:, map%rows), map%height(:, 2))

  contains

    subroutine check_line(name, first, last, second)
      character(len=*), intent(in) :: name
      real(real64), intent(in) :: first(:), last(:), second(:)

      if (all(abs(first - last) <= least) .and. .not. all(abs(first - second) <= least)) &
        call map%notes%add_in_file('note: the map is periodic and its last ' // name // &
                                   ' repeats its first: a period has each ' // name // ' once')
    end subroutine check_line

  end subroutine note_repeated_line

  !> Moves a map without a copy of its heights.
  pure subroutine move_map(from, to)
    type(height_map), intent(inout) :: from  !! left without heights
    type(height_map), intent(out) :: to      !! map with all values but its heights
    real(real64), allocatable :: height(:, :)

    call move_alloc(from%height, height)
    to = from
    call move_alloc(height, to%height)
  end subroutine move_map

  !> Copies a map.
  subroutine copy_map(from, to, failure)
    type(height_map), intent(in) :: from                   !! a height map
    type(height_map), intent(out) :: to                    !! copy with its heights
    character(len=:), allocatable, intent(out) :: failure  !! why there is no memory for it

    to%columns = from%columns
    to%rows = from%rows
    call make_room(to, failure)
    if (.not. allocated(failure)) to = from
  end subroutine copy_map

  !> Converts all lengths of a map to another unit.
  pure subroutine change_unit(map, unit)
    type(height_map), intent(inout) :: map  !! its unit is one of `length_units`
    integer, intent(in) :: unit             !! the new one, which of `length_units`
    real(real64) :: factor

    factor = unit_ratio(map%unit, unit)
    map%unit = trim(length_units(unit))
    if (abs(factor - 1.0_real64) < epsilon(factor)) return
    map%pixel_spacing = map%pixel_spacing * factor
    map%digit = map%digit * factor
    where (is_measured(map%height)) map%height = map%height * factor
  end subroutine change_unit

  !> Converts all lengths of a map to a unit; a map without a unit has its numbers in this one.
  pure subroutine put_in_unit(map, unit)
    type(height_map), intent(inout) :: map  !! its unit is one of `length_units`, or empty
    integer, intent(in) :: unit             !! which of `length_units`; 0: that of its format

    if (unit > 0) then
      if (map%unit == '') map%unit = trim(length_units(unit))
      call change_unit(map, unit)
    else if (all(map%metre_spacing > 0.0_real64)) then
      call change_unit(map, 1)
      map%pixel_spacing = map%metre_spacing
    end if
  end subroutine put_in_unit

  !> Gives a map that came without a spacing the one that stands beside it.
  pure subroutine give_spacing(map, given_spacing, option, shared, fault)
    type(height_map), intent(inout) :: map  !! its spacing is 0, 0 where it came without
    real(real64), intent(in) :: given_spacing(2)  !! along x and y; 0, 0: none is given
    character(len=*), intent(in) :: option  !! name of the spacing, for the message
    logical, intent(in) :: shared           !! the spacing is that of another map, where not needed
    character(len=:), allocatable, intent(out) :: fault  !! what is wrong; empty: nothing

    fault = ''
    map%own_spacing = all(map%pixel_spacing > 0.0_real64)
    if (.not. map%own_spacing) map%pixel_spacing = given_spacing
    if (map%own_spacing .and. any(given_spacing > 0.0_real64) .and. .not. shared) then
      fault = option // ' given, but the map has its own, expected none'
    else if (.not. all(map%pixel_spacing > 0.0_real64)) then
      fault = 'found heights without a spacing, expected ' // option // ' along x and y'
    end if
  end subroutine give_spacing

  !> Finds what is wrong with a spacing that is given; empty: nothing.
  pure subroutine check_spacing(given_spacing, option, fault)
    real(real64), intent(in) :: given_spacing(2)  !! along x and y; 0, 0: none is given
    character(len=*), intent(in) :: option        !! name of the spacing, for the message
    character(len=:), allocatable, intent(out) :: fault  !! what was found and what is expected

    fault = ''
    if (all(abs(given_spacing) <= 0.0_real64) .or. all(is_length(given_spacing))) return
    fault = option // ': found ' // real_text(given_spacing(1)) // ', ' // &
            real_text(given_spacing(2)) // &
            ', expected two numbers, each ' // expected_length // ', or 0 for both'
  end subroutine check_spacing

  !> Finds what is wrong with a map of any source; empty: nothing.
  pure subroutine check_heights(map, fault)
    type(height_map), intent(in) :: map                  !! with its heights
    character(len=:), allocatable, intent(out) :: fault  !! what was found and what is expected
    real(real64) :: low, high
    integer(int64) :: measured
    integer :: row

    fault = ''
    if (min(map%columns, map%rows) < fewest) then
      fault = 'found ' // decimal_text(map%columns) // ' x ' // decimal_text(map%rows) // &
              ' pixels, expected at least 3 x 3'
      return
    end if
    low = huge(low)
    high = -huge(high)
    measured = 0_int64
    do row = 1, map%rows
      measured = measured + count(is_measured(map%height(:, row)), kind=int64)
      low = min(low, minval(map%height(:, row), mask=is_measured(map%height(:, row))))
      high = max(high, maxval(map%height(:, row), mask=is_measured(map%height(:, row))))
    end do
    if (measured == 0_int64) then
      fault = 'all pixels are missing, expected heights'
    else if (high > low .and. high - low < least_range) then
      fault = 'heights differ by less than 1e-60, expected more, or none'
    end if
  end subroutine check_heights

  !> The largest height without its sign; 0 where all pixels are missing.
  pure real(real64) function largest_height(map)
    type(height_map), intent(in) :: map  !! with its heights

    largest_height = max(0.0_real64, maxval(abs(map%height), mask=is_measured(map%height)))
  end function largest_height

  !> How many of a unit are one of another.
  pure real(real64) function unit_ratio(from, to)
    character(len=*), intent(in) :: from  !! the name of one of `length_units`
    integer, intent(in) :: to             !! which of `length_units`

    unit_ratio = metre_in(to) / metre_in(unit_number(from))
  end function unit_ratio

  !> The place of a unit in `length_units`; 0 when it is none of them.
  pure integer function unit_number(name)
    character(len=*), intent(in) :: name  !! as it is written, `um` with any micro sign

    unit_number = findloc(length_units == plain_unit(name), .true., 1)
  end function unit_number

  !> The name of a unit with `u` for a micro sign: U+00B5 or U+03BC in UTF-8, or the byte 181 of
  !> Latin-1; `um` for a micron.
  pure function plain_unit(name) result(plain)
    character(len=*), intent(in) :: name    !! as it is written
    character(len=:), allocatable :: plain  !! without blanks around it
    character(len=*), parameter :: micro = char(194) // char(181) // char(206) // char(188) // &
                                           char(181) // ' '
    integer :: i, at

    plain = trim(adjustl(name))
    do i = 1, 5, 2
      at = index(plain, trim(micro(i:i + 1)))
      if (at > 0) plain = plain(:at - 1) // 'u' // plain(at + len_trim(micro(i:i + 1)):)
    end do
    if (any(lower_case(plain) == [character(len=7) :: 'micron', 'microns'])) plain = 'um'
  end function plain_unit

  !> Allocates the heights. `failure` is allocated when there is no memory for them.
  subroutine make_room(map, failure)
    type(height_map), intent(inout) :: map                 !! its numbers of columns and rows set
    character(len=:), allocatable, intent(out) :: failure  !! why there is no memory for it

    integer(int64) :: bytes

    bytes = 8_int64 * map%columns * map%rows
    call check_memory('the map, ' // decimal_text(map%columns) // ' x ' // decimal_text(map%rows) &
                      // ' pixels, ' // decimal_text(bytes) // ' bytes', failure, bytes=bytes)
    if (.not. allocated(failure)) allocate (map%height(map%columns, map%rows))
  end subroutine make_room

  !> Reads a height, or a word for a missing one: `BAD` or `NaN`.
  pure subroutine read_height(word, height, good, power)
    character(len=*), intent(in) :: word   !! word without blanks around it
    real(real64), intent(out) :: height    !! `no_height` for a missing one
    logical, intent(out) :: good           !! whether it is a height
    !> of ten, of the last digit of all that were read; `no_power` before the first
    integer, intent(inout) :: power
    type(decimal_value) :: decimal

    height = no_height
    good = len(word) <= longest_cell
    if (.not. good) return
    call read_numeral(word, decimal, good)
    if (good) then
      height = decimal_to_real64(decimal)
      if (decimal%all_digits /= 0_int64) power = min(power, decimal%power_of_ten)
      return
    end if
    good = is_missing_word(lower_case(word))
  end subroutine read_height

  ! Whether a word in small letters stands for a missing height: `bad`, `nan` with or without a sign
  ! and what C writes behind it, `nan(ind)`, or `1.#qnan`, `1.#ind` of old libraries for Windows.
  pure logical function is_missing_word(word)
    character(len=*), intent(in) :: word
    integer :: first, last

    first = merge(2, 1, scan(word(:min(1, len(word))), '+-') == 1)
    last = verify(word, '0', back=.true.)
    is_missing_word = word == 'bad' .or. word(first:) == 'nan' .or. &
      (index(word(first:), 'nan(') == 1 .and. index(word, ')') == len(word)) .or. &
      any(word(first:last) == [character(len=7) :: '1.#qnan', '1.#snan', '1.#nan', '1.#ind'])
  end function is_missing_word

  !> Height of one unit in the last digit; 0 where there is none.
  pure real(real64) function digit_of(power)
    integer, intent(in) :: power  !! as `read_height` leaves it

    digit_of = 0.0_real64
    if (power < no_power) digit_of = 10.0_real64**power
  end function digit_of

end module asperity_height_map
