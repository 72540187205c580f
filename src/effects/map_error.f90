!> Estimated error of the contact of a height map by the size of its pixels.
!>
!> The map is solved again on every m-th pixel along both sides: for m = 2 from two first pixels
!> along a diagonal through the highest pixel, and without adhesion from three for m = 3, 4 or 5,
!> the first one with which the map keeps its lengths. The former alone are mirror images of each
!> other on a symmetric map. A result with the error e h**p of pixels of the width h, of either sign
!> from one grid to another, differs on these by d with the variance e**2 (1 + m**(2 p)) h**(2 p).
!> The root mean square of the five d/sqrt(1 + m**(2 p)) times Student's t is the estimate. From two
!> differences alone it is 3 d/(m**p - 1) with their root mean square d and the safety factor of
!> two grids (Roache, J. Fluids Eng. 116 (1994) 405).
!>
!> The order p of separation, load and gap is 2, on a smooth map without free edges 5/2 (measured on
!> waves and random surfaces). On a rough map it is 3/2: displacements by waves of heights h**H, H
!> from 0 to 1, have errors of h**(1 + H). The order of the area is 3/2: the pixels along a rim, 1/h
!> of the spacing h, have independent errors of h**2. So is that of what depends on the rims: the
!> greatest pressure, stiffness, the area that sticks, and all where an edge cuts patches, along
!> which the load of pixels does not vanish.
!>
!> The error of the compression is at most the sum of those of the separation and of first contact
!> (`map_top`).
!>
!> The error of the area is at least half of the correction of the rim, and at least that of
!> straight rims: each straight piece of a rim along the pixels lies up to half a pixel from its
!> sides. The errors of pieces are independent, but those of grooves, which have no ends, add up. On
!> a map that is rough at the size of its pixels the slope grows on by the observed ratio to pixels
!> a quarter as wide, and the area is inverse to the slope (Persson, J. Chem. Phys. 115 (2001)
!> 3840).
!>
!> The greatest pressure of a ball is as its radius: half the relative error of the area by straight
!> rims, which all grids share, adds to that of the differences. It has no estimate where no limit
!> is in sight: on rough maps, and on others that are not smooth where it falls as fast as at the
!> apex of a cone. With it between four of N pixels that pressure is at most as ln(N**(1/2)) + 0.37,
!> the mean of -ln r over a pixel, and falls by 0.21 with pixels twice as wide, more than the share
!> ln 2/(2 ln N) (test: test/maps/test_pixel_errors.py).
!>
!> With creep they are those of the elastic state of the same displacements, with its own load (Lee
!> and Radok 1960), which holds as long as no pixel has left the contact.
module asperity_map_error
  use asperity_coarse_grid, only: coarse_grid, find_centre, grid_around, least_side, &
                                  step_beside_two
  use asperity_contact_records, only: state_row
  use asperity_effect_header, only: column_list, plain
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: int64, not_computed, real64
  use asperity_map_contact, only: most_load
  use asperity_map_fields, only: measure_fields
  use asperity_map_resolution, only: take_heights
  use asperity_map_rims, only: error_of_rims
  use asperity_map_top, only: find_top, first_contact
  use asperity_pixel_law, only: patches_in_contact, pixel_law_box, pixel_state
  use asperity_pixel_sequence, only: add_state_interface, solve_pixel_state
  implicit none
  private

  public :: add_column_errors, error_request, estimate_pixel_errors, find_first_contact

  ! Order of the errors of what depends on the rims of patches (derived: above; test: stiffness and
  ! area in test/maps/test_pixel_errors.py).
  real(real64), parameter :: order_of_rims = 1.5_real64
  ! Numbers of the last state that have an estimated error, and the begin of its column. It is the
  ! largest of those of one column, of `xy` relative to `xx`.
  character(len=*), parameter :: estimated(2, 8) = reshape([character(len=32) :: &
    'contact_stiffness', 'stiffness', 'interface_stiffness', 'interface', &
    'conductance_length', 'conductance', 'tangential_stiffness_xx', 'sticking', &
    'tangential_stiffness_xy', 'sticking', 'tangential_stiffness_yy', 'sticking', &
    'tangential_stiffness', 'slip', 'stick_area', 'stick'], [2, 8])
  ! Safety factor of the error of two grids (Roache 1994; test: rough maps in
  ! test/maps/test_pixel_errors.py).
  real(real64), parameter :: safety = 3.0_real64
  ! Student's t of the mean square of five differences, for 98 of 100, and of the three of numbers
  ! whose errors have a lower bound besides, for 95 (Abramowitz and Stegun 1964, table 26.10).
  real(real64), parameter :: of_five = 3.365_real64, of_three = 3.182_real64
  ! Share of the largest difference that mirror images differ by, at most (chosen: coarser maps are
  ! solved to less).
  real(real64), parameter :: of_mirrors = 0.01_real64
  ! Tolerance of the gaps over the range of heights, or of the attraction (chosen: the differences
  ! are larger by far).
  real(real64), parameter :: closed_halves = 1.0e-4_real64

  !> The map between its pixels, and the quantity that is prescribed.
  type :: error_request
    logical :: by_load = .false.               !! the load is prescribed, else the separation
    logical :: by_top = .false.                !! the compression is: the load has its error
    logical :: is_smooth = .true.              !! the map is smooth between its pixels
    logical :: is_cut = .false.                !! a free edge or a missing pixel cuts patches
    real(real64) :: order = 2.0_real64         !! of the errors of level, load and gap
    real(real64) :: top_error = 0.0_real64     !! error of first contact [length]
    !> Relative growth of the slope to pixels a quarter as wide; 0: the map is not rough.
    real(real64) :: growth = 0.0_real64
    real(real64), private :: lowered = 0.0_real64  !! the flat below its level, unless by load
    logical :: is_last = .false.               !! the last state: it has numbers of its own
    !> combined modulus and Poisson's ratio, conductivities as of `add_interface`
    real(real64) :: material(2) = 0.0_real64, conductivity(2, 2) = 0.0_real64
    !> contact area, open area of measured pixels, their error, and that by straight rims
    real(real64), private :: area = 0.0_real64, open_area = 0.0_real64
    real(real64), private :: of_area = 0.0_real64, of_rims = 0.0_real64
    !> numbers of the last state on coarser maps (number, map); not allocated: unknown
    real(real64), allocatable, private :: numbers(:, :)
    integer, allocatable, private :: steps(:)      !! width of their pixels in those of the map
  end type error_request

contains

  !> Estimates the errors of a solution. They are unchanged where a map is too small, or its halves
  !> cannot be solved.
  subroutine estimate_pixel_errors(map, laws, state, request, row, unsolved)
    type(height_map), intent(in) :: map            !! map without plastic deformation
    type(pixel_law_box), intent(in) :: laws(:)     !! laws with the memory of this solution
    type(pixel_state), intent(in) :: state         !! solution; under a load: > 0
    type(error_request), intent(inout) :: request  !! what is prescribed; gets coarser numbers
    type(state_row), intent(inout) :: row          !! totals of this solution; gets their errors
    !> Reason why a map of every second pixel could not be solved; not allocated: all were.
    character(len=:), allocatable, intent(out) :: unsolved
    type(pixel_state) :: elastic
    real(real64), allocatable :: error(:)
    real(real64) :: area, of_top, pressure

    elastic = state
    if (allocated(request%numbers)) deallocate (request%numbers)
    ! Coarser maps start from pressures alone.
    deallocate (elastic%deformed%height)
    if (allocated(elastic%answer%displacement)) deallocate (elastic%answer%displacement)
    call compare_coarser(map, laws, request, row, elastic, error, of_top, unsolved)
    if (.not. allocated(error)) return
    associate (answer => state%answer)
      if (allocated(answer%contact_pressure)) then
        request%of_rims = error_of_rims(map, answer%contact_pressure)
      else
        request%of_rims = error_of_rims(map, answer%pressure)
      end if
      area = max(error(3), request%of_rims, 0.5_real64 * sum(state%patches%rim), &
                 request%growth * row%area)
      request%area = row%area
      request%of_area = max(request%of_rims, error(3))
      request%open_area = product(map%pixel_spacing) * &
                          count(is_measured(map%height), kind=int64) - row%area
      row%area_error = area / row%area
      if (request%growth > 0.0_real64) row%area_error = area / (row%area + area)
      row%gap_error = error(4) / max(row%mean_gap, error(4), tiny(area))
      if (error(5) > not_computed) then
        pressure = row%greatest_pressure * &
                   hypot(0.5_real64 * request%of_rims / row%area, &
                         error(5) / max(maxval(elastic%answer%pressure), tiny(error)))
        ! All grids have the same one where it is the hardness.
        if (.not. error(5) > 0.0_real64) pressure = 0.0_real64
        row%pressure_error = max(0.0_real64, pressure) / &
                             max(row%greatest_pressure, pressure, tiny(area))
      end if
      if (request%by_load .and. row%compression > 0.0_real64) then
        row%separation_error = error(1) / row%compression
        row%error_estimate = (error(1) + request%top_error) / row%compression
      end if
      if (.not. request%by_load .and. abs(answer%load) > 0.0_real64) &
        row%error_estimate = (error(2) + of_top) * answer%load / elastic%answer%load / &
                             abs(answer%load)
    end associate
  end subroutine estimate_pixel_errors

  ! Solves the maps of every second and of fewer pixels of a map, and compares the totals: level,
  ! load, area, mean gap, greatest pressure.
  subroutine compare_coarser(map, laws, request, row, full, errors, of_top, unsolved)
    type(height_map), intent(in) :: map
    type(pixel_law_box), intent(in) :: laws(:)
    type(error_request), intent(inout) :: request  ! gets numbers of the last state
    type(state_row), intent(in) :: row
    type(pixel_state), intent(inout) :: full       ! solution on all pixels; gets the elastic one
    ! Not allocated: the map is too small, or one of its halves is not solved. The last one is
    ! `not_computed` where the greatest pressure has no limit in sight.
    real(real64), allocatable, intent(out) :: errors(:)
    real(real64), intent(out) :: of_top            ! change of the load by that of first contact
    character(len=:), allocatable, intent(out) :: unsolved  ! why one is not
    type(error_request) :: lowering
    real(real64) :: coarser(5, 5), fall, lower(5), order(5), total(5)
    type(coarse_grid) :: grid
    integer :: grids, i, offset, place(2), steps(5), turn
    logical :: has_solver, is_last

    of_top = 0.0_real64
    if (any(shape(map%height) < least_side)) return
    call find_centre(map, full%answer%pressure, place, turn)
    has_solver = any([(laws(i)%law%solves .and. laws(i)%law%is_simulated, i=1, size(laws))])
    steps(:2) = 2
    steps(3:) = merge(0, step_beside_two(map), has_solver)
    grids = merge(5, 2, steps(3) > 0)
    is_last = request%is_last
    do i = 1, grids
      request%is_last = is_last .and. i > grids - 3
      offset = merge(i - 1, i - 4, i <= 2)
      grid = grid_around(map, place, steps(i), [turn * offset, offset])
      call solve_coarser(map, laws, request, grid, full, coarser(:, i), unsolved)
      if (allocated(unsolved)) exit
    end do
    if (allocated(unsolved)) then
      if (allocated(request%numbers)) deallocate (request%numbers)
      if (i <= 2) return
      grids = 2
      deallocate (unsolved)
    end if
    request%steps = steps(max(1, grids - 2):grids)
    if (request%by_top .and. request%top_error > 0.0_real64 .and. .not. request%by_load) then
      lowering = request
      lowering%lowered = request%top_error
      lowering%is_last = .false.
      grid = grid_around(map, place, 2, [0, 0])
      call solve_coarser(map, laws, lowering, grid, full, lower, unsolved)
      if (allocated(unsolved)) return
      of_top = abs(lower(2) - coarser(2, 1))
    end if
    total = [full%answer%level, full%answer%load, row%area, row%mean_gap, &
             maxval(full%answer%pressure)]
    ! Attraction over the gaps is less smooth than the contact.
    order = request%order
    if (has_solver) order = min(order, 2.0_real64)
    if (request%is_cut) order = order_of_rims
    order([3, 5]) = order_of_rims
    errors = [(error_by(coarser(i, :grids) - total(i), steps(:grids), order(i)), i=1, 5)]
    fall = total(5) - 0.5_real64 * sum(coarser(5, :2))
    if (request%growth > 0.0_real64 .or. (.not. request%is_smooth .and. &
        2 * fall * log(real(size(map%height, kind=int64), real64)) > log(2.0_real64) * total(5))) &
      errors(5) = not_computed
  end subroutine compare_coarser

  ! Error by the differences from pixels that are wider by the factor of each step. No norm2: its
  ! last digit changes with the unit.
  pure real(real64) function error_by(differences, steps, order) result(error)
    real(real64), intent(in) :: differences(:), order
    integer, intent(in) :: steps(:)
    integer :: n

    if (size(steps) == 2) then
      error = safety * sqrt(sum(differences**2) / 2) / (steps(1)**order - 1.0_real64)
      return
    end if
    n = size(steps)
    error = merge(of_five, of_three, n == 5) * &
            sqrt(sum(differences**2 / (1.0_real64 + steps**(2 * order))) / n)
    ! Mirror images are one difference: the larger of both estimates from two grids.
    if (n == 5 .and. abs(differences(1) - differences(2)) <= &
        of_mirrors * maxval(abs(differences))) &
      error = max(error, safety * abs(differences(1)) / (2**order - 1.0_real64), &
                  safety * sqrt(sum(differences(3:)**2) / 3) / (steps(5)**order - 1.0_real64))
  end function error_by

  ! Solves the map on a coarser grid.
  subroutine solve_coarser(map, laws, request, grid, full, total, unsolved)
    type(height_map), intent(in) :: map
    type(pixel_law_box), intent(in) :: laws(:)
    type(error_request), intent(inout) :: request  ! gets numbers of the last state
    type(coarse_grid), intent(in) :: grid
    type(pixel_state), intent(inout) :: full    ! solution on all pixels; gets the elastic one
    real(real64), intent(out) :: total(5)       ! level, load, area, mean gap, greatest pressure
    character(len=:), allocatable, intent(out) :: unsolved  ! why there is none
    type(pixel_law_box) :: own(size(laws))
    type(pixel_state) :: coarse
    type(state_row) :: found
    integer :: i

    total = 0.0_real64
    call take_heights(map, real([grid%step, grid%step], real64), &
                      map%height(grid%columns, grid%rows), coarse%deformed)
    if (.not. any(is_measured(coarse%deformed%height))) then
      unsolved = 'it has no measured pixel'
      return
    end if
    do i = 1, size(laws)
      allocate (own(i)%law, source=laws(i)%law)
      if (own(i)%law%is_simulated) call own(i)%law%coarsen(grid%columns, grid%rows, full)
    end do
    coarse%modulus = full%modulus
    coarse%tolerance = closed_halves
    coarse%answer%level = full%answer%level - request%lowered
    coarse%answer%interrupt = full%answer%interrupt
    coarse%answer%pressure = full%answer%pressure(grid%columns, grid%rows)
    if (request%by_load) coarse%load = full%answer%load
    if (request%by_load .and. allocated(full%hardness)) &
      coarse%load = min(coarse%load, most_load(coarse%deformed, full%hardness))
    call solve_pixel_state(own, coarse)
    associate (answer => coarse%answer)
      if (allocated(answer%failure)) then
        unsolved = answer%failure
        return
      end if
      call patches_in_contact(coarse%deformed, answer, coarse%patches, coarse%hardness)
      call measure_fields(coarse%deformed, answer, found)
      total = [answer%level, answer%load, sum(coarse%patches%area), found%mean_gap, &
               maxval(answer%pressure)]
    end associate
    if (request%is_last) call list_numbers(own, coarse, request)
  end subroutine solve_coarser

  ! Adds the numbers of the last state on one coarser map.
  subroutine list_numbers(laws, state, request)
    type(pixel_law_box), intent(inout) :: laws(:)
    type(pixel_state), intent(in) :: state
    type(error_request), intent(inout) :: request
    type(column_list) :: columns
    character(len=:), allocatable :: failure
    real(real64) :: numbers(size(estimated, 2))
    integer :: i

    call add_state_interface(state, request%material, request%conductivity, columns)
    do i = 1, size(laws)
      if (.not. laws(i)%law%is_simulated) cycle
      call laws(i)%law%finish(state, failure=failure)
      if (.not. allocated(failure)) call laws(i)%law%add_columns(state, columns)
    end do
    numbers = [(number_of(columns, estimated(1, i)), i=1, size(numbers))]
    if (.not. allocated(request%numbers)) allocate (request%numbers(size(numbers), 0))
    request%numbers = reshape([request%numbers, numbers], shape(request%numbers) + [0, 1])
  end subroutine list_numbers

  ! Number of a column; `not_computed` where it has none.
  pure real(real64) function number_of(columns, name) result(number)
    type(column_list), intent(in) :: columns  ! of one row
    character(len=*), intent(in) :: name
    integer :: at

    number = not_computed
    at = findloc(columns%names%text, name, 1)
    if (at > 0) number = columns%values(1, at)
  end function number_of

  !> Adds the errors of numbers of the last state behind its columns. One is `not_computed` where
  !> the number is, here or on a coarser map. A stiffness is a length of the contact, and grows
  !> without limit where the open area is small: its relative error is at least half that of the
  !> area, of the part that sticks by straight rims.
  subroutine add_column_errors(request, columns)
    type(error_request), intent(in) :: request    !! numbers on coarser maps
    type(column_list), intent(inout) :: columns   !! columns of the last state
    character(len=*), parameter :: suffix = '_error_estimate'
    real(real64) :: by_rims, error, least, number, over
    integer :: i

    do i = 1, size(estimated, 2)
      if (.not. any(columns%names%text == estimated(1, i))) cycle
      number = number_of(columns, estimated(1, i))
      over = number
      if (estimated(1, i) == 'tangential_stiffness_xy') &
        over = number_of(columns, 'tangential_stiffness_xx')
      error = not_computed
      if (allocated(request%numbers)) error = minval(request%numbers(i, :))
      if (min(error, number, over) > not_computed) then
        least = 0.5_real64 * share_of(request%of_area, min(request%area, request%open_area))
        by_rims = share_of(request%of_rims, number_of(columns, 'stick_area'))
        if (estimated(2, i) == 'stick') least = by_rims
        if (estimated(2, i) == 'slip') least = 0.5_real64 * by_rims
        error = share_of(error_by(request%numbers(i, :) - number, request%steps, order_of_rims), &
                         over)
        if (abs(number) > 0.0_real64) error = max(error, least)
      else
        error = not_computed
      end if
      associate (last => size(columns%names))
        if (columns%names(last)%text == trim(estimated(2, i)) // suffix) then
          ! The largest of the errors of one name.
          number = columns%values(1, last)
          columns%values(1, last) = merge(max(error, number), not_computed, &
                                          min(error, number) > not_computed)
        else
          call columns%add(trim(estimated(2, i)) // suffix, plain, error)
        end if
      end associate
    end do

  contains

    ! An error over a number, at most 1.
    pure real(real64) function share_of(error, number) result(share)
      real(real64), intent(in) :: error, number

      share = error / max(number, error, tiny(error))
    end function share_of

  end subroutine add_column_errors

  !> Finds first contact, its estimated error, and whether the map is smooth or rough at the size
  !> of its pixels.
  pure subroutine find_first_contact(map, top, request)
    type(height_map), intent(in) :: map            !! levelled height map
    real(real64), intent(out) :: top               !! height of the top [length]
    type(error_request), intent(out) :: request    !! gets the properties of the map
    type(first_contact) :: found

    found = find_top(map)
    top = found%height
    request%top_error = found%error
    request%growth = found%growth
    request%is_smooth = found%is_smooth .or. found%is_vertex
    if (found%is_smooth .and. map%repeats(1) .and. map%repeats(2) .and. &
        all(is_measured(map%height))) request%order = 2.5_real64
    if (request%growth > 0.0_real64) request%order = 1.5_real64
  end subroutine find_first_contact

end module asperity_map_error
