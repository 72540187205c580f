!> Pressure, gap and displacement of two surfaces of asperities, on the grid of the scene.
!>
!> A contact that is resolved on boundary elements has their pressure. Every other contact has the
!> pressure of Hertz on a circle of its area in plan. Both are means over the pixels of the
!> grid. The displacement is that of a half-space of the combined modulus under these pressures
!> (Love 1929, see element_influence), free of load beyond the grid.
module asperity_surface_fields
  use asperity_effect_names, only: known_effects, of_adhesion, of_creep, of_plasticity
  use asperity_lattice_convolution, only: lattice_convolution
  use asperity_element_influence, only: centre_influence
  use asperity_contact_field, only: contact_field, fields_all, fields_none, room_of_fields
  use asperity_contact_records, only: drop_rows, position_result
  use asperity_element_pressures, only: element_pressures
  use asperity_grid_pressures, only: add_circle, add_square, field_grid
  use asperity_constants, only: pi
  use asperity_height_map, only: height_map, is_measured, no_height
  use asperity_kinds, only: int64, not_computed, real64
  use asperity_library_turn, only: library_turn
  use asperity_map_contact, only: map_answer
  use asperity_map_fields, only: measure_fields, take_field
  use asperity_problems, only: decimal_text, problem_list
  use asperity_process, only: check_memory
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: combined_modulus, scene
  use asperity_surface_elevations, only: elevation_of, place_surface, placed_surface
  use asperity_contact_slip, only: solve_with_slip
  implicit none
  private

  public :: check_field_request, has_field_grid, solve_with_fields

  ! Effects under which the pressure of a contact is not that of Hertz.
  integer, parameter :: other_pressures(3) = [of_plasticity, of_adhesion, of_creep]

  ! Bytes of a pixel while the fields are computed: both spectra and the transform of the padded
  ! grid, the table of influence with its integral, forces and the two elevations (measured: 73,
  ! with 16 and with 76 million pixels).
  integer, parameter :: bytes_of_cell = 80
  ! Largest number of pixels along a side: their total is within 64 bits, and beyond any memory.
  integer, parameter :: most_cells = 100000000

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
    type(library_turn) :: turn

    call turn%begin()
    if (allocated(scene_in%map)) return
    if (scene_in%motion%positions > 1) then
      call problems%add(name // ': found ' // decimal_text(scene_in%motion%positions) // &
                        ' positions of asperities, expected one for fields')
    else if (.not. has_field_grid(scene_in)) then
      call problems%add(name // ': no grid for the fields of asperities, expected ' // &
                        'field_spacing, the side of a pixel, in &surfaces')
    end if
  end subroutine check_field_request

  !> Solves the one position of a scene and adds its fields to the results, where they are kept.
  subroutine solve_with_fields(scene_in, options, results, failure)
    type(scene), intent(in) :: scene_in                    !! surfaces of asperities
    type(run_options), intent(in) :: options               !! options of the run
    type(scene_results), intent(inout) :: results          !! results of the one position
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is not solved
    type(run_options) :: with_contacts  ! or without fields
    type(placed_surface) :: upper, lower
    type(field_grid) :: grid
    real(real64), allocatable :: mirror  ! not allocated: the lower surface is not mirrored
    integer :: i

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
    if (scene_in%lower_is_mirrored) mirror = scene_in%lower_mirror_width
    lower = place_surface(scene_in%lower, 1, mirror=mirror)
    call lay_grid(upper, lower, scene_in%number('surfaces', 'field_spacing'), grid, failure)
    if (allocated(failure)) return
    with_contacts = options
    with_contacts%keep_contacts = .true.
    call solve_with_slip(scene_in, with_contacts, results, failure)
    if (allocated(failure)) return
    ! Positions of other images and from files have no contacts here.
    if (.not. allocated(results%positions(1)%states)) return
    ! Some effects change the pressure of Hertz.
    if (allocated(results%effects) .and. allocated(results%positions(1)%effects)) then
      do i = 1, size(results%effects%names)
        associate (name => results%effects%names(i))
          if (results%positions(1)%effects(i)%simulated /= 'off' .and. &
              any(name == known_effects(other_pressures)%name)) &
            failure = 'fields: the pressure of contacts with ' // trim(name) // &
                      ' is not Hertz''s: found it simulated, expected ' // trim(name) // &
                      ' = ''off'' or no fields'
        end associate
      end do
    end if
    if (allocated(failure)) return
    call take_fields(scene_in, options%fields == fields_all, upper, lower, grid, &
                     results%positions(1), failure)
    if (options%keep_contacts) return
    ! Contacts were kept for the fields only.
    call drop_rows(results%positions(1))
  end subroutine solve_with_fields

  ! Computes the fields of the last state, or of all: a plane in contact with the sum of both
  ! elevations, as a map.
  subroutine take_fields(scene_in, of_all, upper, lower, grid, position, failure)
    type(scene), intent(in) :: scene_in
    logical, intent(in) :: of_all
    type(placed_surface), intent(in) :: upper, lower
    type(field_grid), intent(in) :: grid
    type(position_result), intent(inout) :: position
    character(len=:), allocatable, intent(inout) :: failure
    type(height_map) :: map, surfaces
    type(lattice_convolution) :: influence
    type(map_answer) :: answer
    integer :: i, first

    first = merge(1, size(position%states), of_all)
    call check_states(grid, size(position%states) - first + 1, failure)
    if (allocated(failure)) return
    surfaces%columns = grid%elements(1)
    surfaces%rows = grid%elements(2)
    surfaces%pixel_spacing = grid%side
    surfaces%height = sum_of(elevation_of(upper, grid), elevation_of(lower, grid))
    allocate (position%fields(size(position%states) - first + 1))
    allocate (answer%pressure, answer%displacement, mold=surfaces%height)
    call influence%prepare(centre_influence(surfaces%columns, surfaces%rows, 1.0_real64), &
                           1.0_real64)
    do i = first, size(position%states)
      associate (field => position%fields(i - first + 1), pressure => answer%pressure)
        map = surfaces
        answer%level = position%states(i)%approach
        pressure = 0.0_real64
        call add_loads(position, i, grid, pressure, field)
        pressure = pressure / grid%side**2
        call influence%apply(pressure, answer%displacement)
        answer%displacement = answer%displacement * (grid%side / combined_modulus(scene_in))
        ! Beside a small sphere the centre of a loaded pixel may have no surface.
        where (pressure > 0.0_real64 .and. .not. is_measured(map%height)) map%height = answer%level
        call take_field(map, answer, i, field)
        call measure_fields(map, answer, position%states(i))
        field%origin = grid%low + 0.5_real64 * grid%side
        field%unit = trim(scene_in%units(1))
      end associate
    end do
    if (allocated(position%pressures)) deallocate (position%pressures)
  end subroutine take_fields

  ! Sets a grid of whole pixels around the common rectangle of both surfaces.
  subroutine lay_grid(upper, lower, side, grid, failure)
    type(placed_surface), intent(in) :: upper, lower
    real(real64), intent(in) :: side
    type(field_grid), intent(out) :: grid
    character(len=:), allocatable, intent(inout) :: failure
    real(real64) :: high(2), numbers(2)

    grid%low = -huge(side)
    high = huge(side)
    call narrow_grid(upper)
    call narrow_grid(lower)
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
    call check_states(grid, 1, failure)
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
  subroutine check_states(grid, states, failure)
    type(field_grid), intent(in) :: grid
    integer, intent(in) :: states
    character(len=:), allocatable, intent(inout) :: failure
    integer(int64) :: cells

    cells = product(int(grid%elements, int64))
    call check_memory('the fields of ' // decimal_text(states) // trim(merge(' state ', &
                      ' states', states == 1)), failure, &
                      bytes=bytes_of_cell * cells + room_of_fields(cells, states))
    if (allocated(failure)) failure = failure // ', expected a larger field_spacing'
  end subroutine check_states

  ! Sum of two elevations; `no_height` where one is missing.
  elemental real(real64) function sum_of(first, second)
    real(real64), intent(in) :: first, second

    sum_of = no_height
    if (first > not_computed .and. second > not_computed) sum_of = first + second
  end function sum_of

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

end module asperity_surface_fields
