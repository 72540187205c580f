!> Pressure, gap and displacement of two surfaces of asperities, on the grid of the scene.
!>
!> A contact that is resolved on boundary elements has their pressure. Every other contact has the
!> pressure of Hertz on a circle of its area in plan. Both are means over the pixels of the
!> grid. The displacement is that of a half-space of the combined modulus under these pressures
!> (Love 1929, see element_influence), free of load beyond the grid.
!>
!> A surface between its summits is the highest of its spheres and, where all its summits are above
!> it, its reference plane. Beside all spheres of a surface without that plane there is no surface.
module asperity_surface_fields
  use asperity_constants, only: pi
  use asperity_contact_field, only: contact_field, fields_all, fields_none, room_of_fields
  use asperity_contact_records, only: drop_rows, position_result
  use asperity_contact_slip, only: solve_with_slip
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_element_influence, only: centre_influence
  use asperity_element_pressures, only: element_pressures
  use asperity_grid_pressures, only: add_circle, add_square, field_grid
  use asperity_height_map, only: height_map, is_measured, no_height
  use asperity_kinds, only: int64, not_computed, real64
  use asperity_lattice_convolution, only: lattice_convolution
  use asperity_map_contact, only: map_answer
  use asperity_map_fields, only: measure_fields, take_field
  use asperity_problems, only: decimal_text, not_enough_memory, problem_list
  use asperity_process, only: has_memory
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: combined_modulus, effect_off, scene, scene_surface, solves_pixels
  implicit none
  private

  public :: check_field_request, has_field_grid, may_have_fields, solve_with_fields

  ! Effects under which the pressure of a contact is not that of Hertz.
  character(len=*), parameter :: other_pressures(3) = [character(len=11) :: 'plasticity', &
    'adhesion', 'creep']

  ! Bytes of a pixel while the fields are computed: both spectra and the transform of the padded
  ! grid, the table of influence with its integral, forces and the two elevations (measured: 73,
  ! with 16 and with 76 million pixels).
  integer, parameter :: bytes_of_cell = 80
  ! Largest number of pixels along a side: their total is within 64 bits, and beyond any memory.
  integer, parameter :: most_cells = 100000000

  ! Pixels along the side of a block. For each block the spheres that can be highest are selected.
  integer, parameter :: block = 32

  !> One surface at its position. Elevations are from its reference plane towards the other surface.
  type :: placed_surface
    logical :: has_base = .false.                    !! whether its reference plane is a part of it
    real(real64), allocatable :: x(:), y(:)          !! positions of the summits
    real(real64), allocatable :: level(:)            !! elevation of the summits, tilt included
    real(real64), allocatable :: radius(:)           !! radius of the spheres
    real(real64), allocatable :: reach(:)            !! radius in plan of the spherical cap
    real(real64) :: slope(2) = 0.0_real64            !! slope of the reference plane
    real(real64) :: displacement(2) = 0.0_real64     !! displacement in plan
  end type placed_surface

contains

  !> Whether a scene of asperities has a grid for its fields.
  pure logical function has_field_grid(scene_in)
    type(scene), intent(in) :: scene_in  !! scene, checked for faults

    has_field_grid = scene_in%number('surfaces', 'field_spacing') > 0.0_real64
  end function has_field_grid

  !> Reports a scene that has no fields although they are requested.
  subroutine check_field_request(scene_in, name, problems)
    type(scene), intent(in) :: scene_in            !! scene, checked for faults
    character(len=*), intent(in) :: name           !! option of the request, for the message
    type(problem_list), intent(inout) :: problems  !! list; gets a line for such a scene

    if (scene_in%motion%positions > 1) then
      call problems%add(name // ': found ' // decimal_text(scene_in%motion%positions) // &
                        ' positions, expected one for fields')
    else if (has_field_grid(scene_in)) then
      return
    else if (.not. allocated(scene_in%map)) then
      call problems%add(name // ': no grid for the fields of asperities, expected ' // &
                        'field_spacing, the side of a pixel, in &surfaces')
    else if (.not. solves_pixels(scene_in)) then
      call problems%add(name // ': only a height map solved on its pixels has pressure on ' // &
                        'pixels, expected interaction = ''boundary'' in &effects, or ' // &
                        'field_spacing in &surfaces for fields of its summits')
    end if
  end subroutine check_field_request

  !> Whether a scene of asperities certainly has fields: a grid, one position, Hertz' law.
  pure logical function may_have_fields(scene_in)
    type(scene), intent(in) :: scene_in  !! scene, checked for faults
    integer :: i

    may_have_fields = has_field_grid(scene_in) .and. scene_in%motion%positions == 1
    do i = 1, size(other_pressures)
      may_have_fields = may_have_fields .and. &
                        scene_in%effects%mode(trim(other_pressures(i))) == effect_off
    end do
  end function may_have_fields

  !> Solves the one position of a scene and adds its fields to the results, where they are kept.
  subroutine solve_with_fields(scene_in, options, results, failure, corners)
    type(scene), intent(in) :: scene_in                    !! surfaces of asperities
    type(run_options), intent(in) :: options               !! options of the run
    type(scene_results), intent(inout) :: results          !! results of the one position
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is not solved
    !> low and high corner of the grid in plan; absent: those of the common area of both surfaces
    real(real64), intent(in), optional :: corners(2, 2)
    type(run_options) :: with_contacts  ! or without fields
    type(placed_surface) :: upper, lower
    type(field_grid) :: grid
    real(real64), allocatable :: mirror  ! not allocated: the lower surface is not mirrored

    if (options%fields == fields_none .or. .not. has_field_grid(scene_in)) then
      with_contacts = options
      with_contacts%fields = fields_none
      call solve_with_slip(scene_in, with_contacts, results, failure)
      return
    end if
    if (scene_in%motion%positions > 1) then
      failure = 'fields: found ' // decimal_text(scene_in%motion%positions) // ' positions, ' // &
                'expected one for fields'
      return
    end if
    upper = place_surface(scene_in%upper, -1, [scene_in%motion%x_first, scene_in%motion%y_first])
    if (scene_in%lower_is_mirrored) mirror = decimal_to_real64(scene_in%lower_mirror_width)
    lower = place_surface(scene_in%lower, 1, mirror=mirror)
    call lay_grid(upper, lower, scene_in%number('surfaces', 'field_spacing'), grid, failure, &
                  corners)
    if (allocated(failure)) return
    with_contacts = options
    with_contacts%keep_contacts = .true.
    call solve_with_slip(scene_in, with_contacts, results, failure)
    if (allocated(failure)) return
    ! Positions of other images and from files have no contacts here.
    if (.not. allocated(results%positions(1)%states)) return
    call check_effects(results, failure)
    if (allocated(failure)) return
    call take_fields(scene_in, options%fields == fields_all, upper, lower, grid, &
                     results%positions(1), failure)
    if (options%keep_contacts) return
    ! Contacts were kept for the fields only.
    call drop_rows(results%positions(1))
  end subroutine solve_with_fields

  ! Computes the fields of the last state, or of all.
  subroutine take_fields(scene_in, of_all, upper, lower, grid, position, failure)
    type(scene), intent(in) :: scene_in
    logical, intent(in) :: of_all
    type(placed_surface), intent(in) :: upper, lower
    type(field_grid), intent(in) :: grid
    type(position_result), intent(inout) :: position
    character(len=:), allocatable, intent(inout) :: failure
    type(height_map) :: surfaces
    integer :: i, first

    first = merge(1, size(position%states), of_all)
    call check_memory(grid, size(position%states) - first + 1, failure)
    if (allocated(failure)) return
    surfaces%columns = grid%elements(1)
    surfaces%rows = grid%elements(2)
    surfaces%pixel_spacing = grid%side
    surfaces%height = sum_of(elevation_of(upper, grid), elevation_of(lower, grid))
    allocate (position%fields(size(position%states) - first + 1))
    do i = first, size(position%states)
      call fill_field(position, i, grid, combined_modulus(scene_in), surfaces, &
                      position%fields(i - first + 1))
      position%fields(i - first + 1)%unit = trim(scene_in%units(1))
    end do
    if (allocated(position%pressures)) deallocate (position%pressures)
  end subroutine take_fields

  ! Refuses effects that change the pressure of Hertz.
  subroutine check_effects(results, failure)
    type(scene_results), intent(in) :: results
    character(len=:), allocatable, intent(inout) :: failure
    integer :: i

    if (.not. allocated(results%effects) .or. .not. allocated(results%positions(1)%effects)) return
    do i = 1, size(results%effects%names)
      associate (name => results%effects%names(i))
        if (results%positions(1)%effects(i)%simulated /= 'off' .and. &
            any(name == other_pressures)) &
          failure = 'fields: the pressure of contacts with ' // trim(name) // &
                    ' is not Hertz''s: found it simulated, expected ' // trim(name) // &
                    ' = ''off'' or no fields'
      end associate
    end do
  end subroutine check_effects

  ! Sets a grid of whole pixels around the common rectangle of both surfaces.
  subroutine lay_grid(upper, lower, side, grid, failure, corners)
    type(placed_surface), intent(in) :: upper, lower
    real(real64), intent(in) :: side
    type(field_grid), intent(out) :: grid
    character(len=:), allocatable, intent(inout) :: failure
    real(real64), intent(in), optional :: corners(2, 2)
    real(real64) :: high(2), numbers(2)

    grid%low = -huge(side)
    high = huge(side)
    call narrow_grid(upper)
    call narrow_grid(lower)
    if (present(corners)) then
      grid%low = corners(:, 1)
      high = corners(:, 2)
    end if
    if (any(high < grid%low)) then
      failure = 'fields: the surfaces have no area in common in plan'
      return
    end if
    ! Rounding makes no further column.
    numbers = (high - grid%low) / side * (1.0_real64 - 1.0e-12_real64)
    ! As real numbers: they may be beyond the range of integers.
    numbers = max(1.0_real64, aint(numbers) + merge(1, 0, aint(numbers) < numbers))
    grid%elements = int(min(numbers, real(most_cells, real64)))
    grid%side = side
    call check_memory(grid, 1, failure)
    grid%low = 0.5_real64 * (grid%low + high) - 0.5_real64 * side * grid%elements

  contains

    ! Narrows the grid to a surface.
    subroutine narrow_grid(surface)
      type(placed_surface), intent(in) :: surface

      if (size(surface%x) == 0) return
      grid%low = max(grid%low, [minval(surface%x - surface%reach), &
                                minval(surface%y - surface%reach)])
      high = min(high, [maxval(surface%x + surface%reach), maxval(surface%y + surface%reach)])
    end subroutine narrow_grid

  end subroutine lay_grid

  ! Refuses states for which memory is short.
  subroutine check_memory(grid, states, failure)
    type(field_grid), intent(in) :: grid
    integer, intent(in) :: states
    character(len=:), allocatable, intent(inout) :: failure
    integer(int64) :: cells

    cells = product(int(grid%elements, int64))
    if (has_memory(bytes_of_cell * cells + room_of_fields(cells, states))) return
    failure = not_enough_memory // ' for the fields of ' // decimal_text(states) // ' states'
    if (states == 1) failure = failure(:len(failure) - 1)
    failure = failure // ', expected a larger field_spacing'
  end subroutine check_memory

  ! Sum of two elevations; `no_height` where one is missing.
  elemental real(real64) function sum_of(first, second)
    real(real64), intent(in) :: first, second

    sum_of = no_height
    if (first > not_computed .and. second > not_computed) sum_of = first + second
  end function sum_of

  ! Computes the fields of one state: a plane in contact with the sum of both elevations, as a map.
  subroutine fill_field(position, number, grid, modulus, surfaces, field)
    type(position_result), intent(inout) :: position  ! its state gets the gap
    integer, intent(in) :: number                     ! number of the state
    type(field_grid), intent(in) :: grid
    real(real64), intent(in) :: modulus               ! combined
    type(height_map), intent(in) :: surfaces          ! sum of both elevations
    type(contact_field), intent(inout) :: field
    type(lattice_convolution) :: influence
    type(map_answer) :: answer
    type(height_map) :: map

    map = surfaces
    answer%level = position%states(number)%approach
    allocate (answer%pressure(map%columns, map%rows), source=0.0_real64)
    allocate (answer%displacement, mold=answer%pressure)
    call add_loads(position, number, grid, answer%pressure, field)
    answer%pressure = answer%pressure / grid%side**2
    call influence%prepare(centre_influence(map%columns, map%rows, 1.0_real64))
    call influence%apply(answer%pressure, answer%displacement)
    answer%displacement = answer%displacement * (grid%side / modulus)
    ! Beside a small sphere the centre of a loaded pixel may have no surface.
    where (answer%pressure > 0.0_real64 .and. .not. is_measured(map%height)) &
      map%height = answer%level
    call take_field(map, answer, number, field)
    call measure_fields(map, answer, position%states(number))
    field%origin = grid%low + 0.5_real64 * grid%side
  end subroutine fill_field

  ! Adds the loads of all contacts of a state to the pixels.
  subroutine add_loads(position, number, grid, force, field)
    type(position_result), intent(in) :: position
    integer, intent(in) :: number
    type(field_grid), intent(in) :: grid
    real(real64), intent(inout) :: force(:, :)   ! force of each pixel, is increased
    type(contact_field), intent(inout) :: field  ! gets the numbers of contacts
    type(element_pressures) :: elements
    real(real64), allocatable :: total(:)        ! sum of the forces of the elements, by pair
    real(real64) :: shift(2)
    integer, allocatable :: row_of(:)            ! contact of each pair; 0: none
    integer :: i, row

    field%boundary_contacts = 0
    field%hertz_contacts = 0
    if (allocated(position%pressures)) elements = position%pressures(number)
    associate (rows => position%rows, first => position%states(number)%first_row, &
               last => position%states(number)%last_row)
      allocate (total(maxval([0, rows(first:last)%area_no])), source=0.0_real64)
      allocate (row_of(size(total)), source=0)
      row_of(rows(first:last)%area_no) = [(row, row=first, last)]
      if (allocated(elements%pair)) then
        do i = 1, size(elements%pair)
          associate (pair => elements%pair(i))
            if (pair <= size(total)) total(pair) = total(pair) + elements%force(i)
          end associate
        end do
        do i = 1, size(elements%pair)
          associate (pair => elements%pair(i))
            if (pair > size(total)) cycle
            if (row_of(pair) == 0) cycle
            call add_square(grid, elements%x(i), elements%y(i), elements%side(i), &
                            rows(row_of(pair))%vertical_load * (elements%force(i) / total(pair)), &
                            force)
          end associate
        end do
      end if
      do row = first, last
        associate (contact => rows(row))
          if (total(contact%area_no) > 0.0_real64) then
            field%boundary_contacts = field%boundary_contacts + 1
            cycle
          end if
          field%hertz_contacts = field%hertz_contacts + 1
          shift = 0.0_real64
          if (allocated(elements%shift)) shift = elements%shift(:, contact%area_no)
          call add_circle(grid, contact%x + shift(1), contact%y + shift(2), &
                          sqrt(contact%projected_area / pi), contact%vertical_load, force)
        end associate
      end do
    end associate
  end subroutine add_loads

  !> Places a surface in the order of a scene: rotation, mirror, slope, displacement.
  type(placed_surface) function place_surface(surface, side, displacement, mirror) result(placed)
    type(scene_surface), intent(in) :: surface  !! surface of the scene
    integer, intent(in) :: side                 !! sign of the slope: 1 lower, -1 upper surface
    type(decimal_value), intent(in), optional :: displacement(2)  !! displacement in plan [length]
    real(real64), intent(in), optional :: mirror  !! y becomes this number less y [length]
    real(real64) :: angle

    angle = decimal_to_real64(surface%rotation)
    allocate (placed%x, source=surface%x * cos(angle) - surface%y * sin(angle))
    allocate (placed%y, source=surface%x * sin(angle) + surface%y * cos(angle))
    if (present(mirror)) placed%y = mirror - placed%y
    placed%slope = side * decimal_to_real64(surface%slope)
    allocate (placed%level, source=surface%height + placed%slope(1) * placed%x + &
                                   placed%slope(2) * placed%y)
    allocate (placed%radius, source=surface%radius)
    allocate (placed%reach, source=surface%radius)
    placed%has_base = all(surface%height > 0.0_real64)
    if (placed%has_base) then
      associate (cap => min(surface%height, surface%radius))
        placed%reach = sqrt(cap) * sqrt(surface%radius + (surface%radius - cap))
      end associate
    end if
    if (present(displacement)) placed%displacement = decimal_to_real64(displacement)
    placed%x = placed%x + placed%displacement(1)
    placed%y = placed%y + placed%displacement(2)
  end function place_surface

  !> Elevation of a surface at the centres of the cells [length]; `not_computed` beside all of its
  !> spheres.
  function elevation_of(surface, grid) result(profile)
    type(placed_surface), intent(in) :: surface  !! surface at its position
    type(field_grid), intent(in) :: grid         !! grid of the pixels
    real(real64), allocatable :: profile(:, :)   !! elevation by column and row
    integer :: i, j

    allocate (profile(grid%elements(1), grid%elements(2)))
    !$omp parallel do schedule(dynamic) private(i)
    do j = 1, grid%elements(2), block
      do i = 1, grid%elements(1), block
        call fill_block([i, j], min([i, j] + block - 1, grid%elements))
      end do
    end do
    !$omp end parallel do

  contains

    ! Spheres that are everywhere below the lowest place of the others are left out.
    subroutine fill_block(first, last)
      integer, intent(in) :: first(2), last(2)
      real(real64) :: middle(2), half, lowest, x, y
      integer :: k, m, n

      middle = grid%low + 0.5_real64 * grid%side * (first + last - 1)
      half = 0.5_real64 * grid%side * norm2(real(last - first + 1, real64))
      lowest = not_computed
      do n = first(2), last(2)
        y = grid%low(2) + (n - 0.5_real64) * grid%side - surface%displacement(2)
        do m = first(1), last(1)
          x = grid%low(1) + (m - 0.5_real64) * grid%side - surface%displacement(1)
          profile(m, n) = not_computed
          if (surface%has_base) profile(m, n) = dot_product(surface%slope, [x, y])
        end do
      end do
      if (surface%has_base) lowest = minval(profile(first(1):last(1), first(2):last(2)))
      do k = 1, size(surface%x)
        lowest = max(lowest, sphere_elevation(k, plan_distance(k, middle) + half))
      end do
      do k = 1, size(surface%x)
        if (plan_distance(k, middle) - half >= surface%radius(k)) cycle
        if (sphere_elevation(k, max(0.0_real64, plan_distance(k, middle) - half)) < lowest) cycle
        do n = first(2), last(2)
          y = grid%low(2) + (n - 0.5_real64) * grid%side
          do m = first(1), last(1)
            x = grid%low(1) + (m - 0.5_real64) * grid%side
            profile(m, n) = max(profile(m, n), sphere_elevation(k, plan_distance(k, [x, y])))
          end do
        end do
      end do
    end subroutine fill_block

    pure real(real64) function plan_distance(k, place)
      integer, intent(in) :: k
      real(real64), intent(in) :: place(2)

      plan_distance = hypot(place(1) - surface%x(k), place(2) - surface%y(k))
    end function plan_distance

    ! Elevation of sphere k at a distance in plan; `not_computed` beyond its radius.
    pure real(real64) function sphere_elevation(k, from)
      integer, intent(in) :: k
      real(real64), intent(in) :: from

      sphere_elevation = not_computed
      associate (r => surface%radius(k))
        if (from < r) &
          sphere_elevation = surface%level(k) - from**2 / (r + sqrt((r - from) * (r + from)))
      end associate
    end function sphere_elevation

  end function elevation_of

end module asperity_surface_fields
