!> A height map from numbers in memory.
module asperity_height_map_array
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use asperity_height_map, only: edge_names, expected_height, fault_of_map, fault_of_spacing, &
                                 height_map, highest, largest_height, length_units, &
                                 make_room, no_height, plain_unit, unit_number
  use asperity_kinds, only: real64
  use asperity_problems, only: decimal_text, problem_list, real_text
  implicit none
  private

  public :: take_map

contains

  !> Copies a map. With problems, or when `failure` is allocated because there is no memory for it,
  !> the map is not to be used.
  subroutine take_map(which, height, along, unit, edge, map, problems, failure)
    character(len=*), intent(in) :: which      !! name of the map, for the messages
    real(real64), intent(in) :: height(:, :)   !! by column (x) and row (y); NaN where missing
    real(real64), intent(in) :: along(2)       !! spacing along x and y; 0, 0: not given
    character(len=*), intent(in) :: unit       !! of all lengths; empty: none
    integer, intent(in) :: edge                !! which of `edge_names`; 0: not given
    type(height_map), intent(out) :: map       !! the same
    type(problem_list), intent(inout) :: problems           !! what is wrong
    character(len=:), allocatable, intent(out) :: failure   !! why there is no map
    character(len=:), allocatable :: list, fault
    integer :: before, i, j

    before = problems%count()
    map%columns = size(height, 1)
    map%rows = size(height, 2)
    map%spacing = along
    map%unit = plain_unit(unit)
    map%edge = edge
    call map%notes%start(which)
    fault = fault_of_spacing(along, which // '.spacing')
    if (fault /= '') call problems%add(fault)
    if (map%unit /= '' .and. unit_number(map%unit) == 0) then
      list = trim(length_units(1))
      do i = 2, size(length_units)
        list = list // ', ' // trim(length_units(i))
      end do
      call problems%add(which // '.unit: found ' // unit // ', expected one of ' // list // &
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
    fault = fault_of_map(map)
    if (fault /= '') call problems%add(which // ': ' // fault)
    map%digit = spacing(largest_height(map))
  end subroutine take_map

end module asperity_height_map_array
