!> The library for C: bodies under arrays of pressures and tractions; `include/asperity.h` has what
!> each procedure does.
module asperity_c_half_space
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_null_ptr, &
                                         c_ptr
  use asperity, only: add_reals, contact_field, decimal_text
  use asperity_c_outcome, only: begin_outcome, finish_outcome, outcome, table_fields
  use asperity_csv_tables, only: first_stress, stress_cells, stress_columns, stress_names
  use asperity_height_map, only: height_map, layered_body, most_samples
  use asperity_kinds, only: int64, real64
  use asperity_library_turn, only: library_turn
  use asperity_map_contact, only: displacement_by, room_to_press
  use asperity_map_stress, only: check_stress, stress_solver
  use asperity_numeral, only: expected_numbers, in_range, not_negative, poisson_range
  use asperity_problems, only: not_enough_memory, problem_list, real_text
  use asperity_process, only: has_memory
  use asperity_scene_values, only: body_compliance
  use asperity_surface_pressure, only: find_pressure
  use asperity_traction_convolution, only: by_tractions, normal_by_tractions, &
                                           tangential_by_pressures, traction_convolution
  implicit none
  private

  public :: c_displacement, c_half_space, c_pressure, c_stress

  !> `asperity_half_space` of the header.
  type, bind(c) :: c_half_space
    integer(c_int) :: columns, rows     !! pixels along x and along y
    real(c_double) :: pixel_spacing(2)  !! along x and y
    integer(c_int) :: periodic(2)       !! along x and y: 1 or 0
    real(c_double) :: modulus(2)        !! Young's, of surface and base; 0: rigid
    real(c_double) :: ratio(2)          !! Poisson's, of both
    real(c_double) :: thickness         !! of the layer; 0: none
  end type c_half_space

contains

  !> `asperity_stress`.
  type(c_ptr) function c_stress(given, pressure, traction_x, traction_y, depth) &
    bind(c, name='asperity_stress') result(handle)
    type(c_ptr), value :: given                   !! `c_half_space`
    type(c_ptr), value :: pressure                !! (column, row); NaN: a missing pixel
    type(c_ptr), value :: traction_x, traction_y  !! on the body, alike; both null: none
    real(c_double), value :: depth                !! below the surface, 0 or more
    type(library_turn) :: turn
    type(outcome), pointer :: new
    type(contact_field) :: field
    type(layered_body) :: body
    type(stress_solver) :: solver
    real(real64), allocatable :: cells(:, :), stress(:, :, :)
    integer :: i

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    call turn%begin()
    call take_arrays(given, pressure, traction_x, traction_y, field, body, new)
    if (.not. (depth >= 0.0_real64 .and. depth <= huge(depth))) &
      call new%problems%add('depth: found ' // real_text(depth) // &
                            ', expected a number of 0 or more')
    if (new%problems%count() == 0) call check_stress(field, depth, body, new%failure)
    call turn%finish()
    if (has_work(new)) then
      call solver%prepare(field, body, .false.)
      call solver%solve(depth, stress)
    end if
    call turn%begin()
    if (allocated(stress)) then
      cells = stress_cells(field, depth, stress)
      do i = first_stress, stress_columns
        call add_reals(new%tables(table_fields), trim(stress_names(i)), cells(:, i), '')
      end do
    end if
    call finish_outcome(new)
  end function c_stress

  !> `asperity_displacement`.
  type(c_ptr) function c_displacement(given, pressure, traction_x, traction_y) &
    bind(c, name='asperity_displacement') result(handle)
    type(c_ptr), value :: given                   !! `c_half_space`
    type(c_ptr), value :: pressure                !! (column, row)
    type(c_ptr), value :: traction_x, traction_y  !! alike; both null: none
    type(library_turn) :: turn
    type(outcome), pointer :: new
    type(contact_field) :: field
    type(height_map) :: map
    type(layered_body) :: body
    type(traction_convolution) :: tangential
    real(real64), allocatable :: by_pressure(:, :, :), traction(:, :, :), u(:, :, :)

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    call turn%begin()
    call take_arrays(given, pressure, traction_x, traction_y, field, body, new)
    if (body%thickness > 0.0_real64 .and. allocated(field%traction)) &
      call new%problems%add('tractions on a layer: found them, expected pressures alone')
    if (has_work(new)) call make_map(field, body, map, new)
    call turn%finish()
    if (has_work(new)) then
      allocate (u(field%columns, field%rows, 3))
      u(:, :, 3) = displacement_by(map, surface_modulus(body), field%pressure)
      if (allocated(field%traction)) then
        associate (nu => body%ratio(1), sides => field%pixel_spacing)
          call tangential%prepare(shape(map%height), sides(2) / sides(1), &
                                  [map%repeats(1), map%repeats(2)], nu, &
                                  (1.0_real64 - 2.0_real64 * nu) / (2.0_real64 * (1.0_real64 - nu)))
          traction = reshape([field%traction, field%traction_y], [shape(map%height), 2])
          allocate (by_pressure, mold=u)
          call tangential%apply(traction, by_pressure(:, :, 3:), normal_by_tractions)
          call tangential%apply(traction, u(:, :, :2), by_tractions)
          traction = reshape(field%pressure, [shape(map%height), 1])
          call tangential%apply(traction, by_pressure(:, :, :2), tangential_by_pressures)
          by_pressure = by_pressure * (sides(1) / surface_modulus(body))
          u(:, :, :2) = u(:, :, :2) * (sides(1) / surface_modulus(body)) + by_pressure(:, :, :2)
          u(:, :, 3) = u(:, :, 3) + by_pressure(:, :, 3)
        end associate
      end if
    end if
    call turn%begin()
    if (allocated(u)) call add_reals(new%tables(table_fields), 'displacement_z', [u(:, :, 3)], '')
    if (allocated(by_pressure)) then
      call add_reals(new%tables(table_fields), 'displacement_x', [u(:, :, 1)], '')
      call add_reals(new%tables(table_fields), 'displacement_y', [u(:, :, 2)], '')
    end if
    call finish_outcome(new)
  end function c_displacement

  !> `asperity_pressure`.
  type(c_ptr) function c_pressure(given, displacement) bind(c, name='asperity_pressure') &
    result(handle)
    type(c_ptr), value :: given         !! `c_half_space`
    type(c_ptr), value :: displacement  !! (column, row)
    type(library_turn) :: turn
    type(outcome), pointer :: new
    type(contact_field) :: field
    type(height_map) :: map
    type(layered_body) :: body
    real(real64), allocatable :: pressure(:, :)

    call begin_outcome(new, handle)
    if (.not. associated(new)) return
    call turn%begin()
    call take_arrays(given, displacement, c_null_ptr, c_null_ptr, field, body, new)
    if (has_work(new)) call make_map(field, body, map, new)
    call turn%finish()
    if (has_work(new)) &
      call find_pressure(map, surface_modulus(body), field%pressure, pressure, new%failure)
    call turn%begin()
    if (has_work(new)) call add_reals(new%tables(table_fields), 'pressure', [pressure], '')
    call finish_outcome(new)
  end function c_pressure

  ! Whether nothing is wrong so far.
  logical function has_work(new)
    type(outcome), intent(in) :: new

    has_work = new%problems%count() == 0 .and. .not. allocated(new%failure)
  end function has_work

  ! The modulus of a surface beside a rigid one.
  pure real(real64) function surface_modulus(body)
    type(layered_body), intent(in) :: body

    surface_modulus = 1.0_real64 / body_compliance(body%modulus(1), body%ratio(1))
  end function surface_modulus

  ! Makes a map of the body, beside a rigid one.
  subroutine make_map(field, body, map, new)
    type(contact_field), intent(in) :: field
    type(layered_body), intent(in) :: body
    type(height_map), intent(out) :: map
    type(outcome), intent(inout) :: new

    map%columns = field%columns
    map%rows = field%rows
    map%pixel_spacing = field%pixel_spacing
    map%periodic = field%periodic
    map%strip_axis = field%strip_axis
    map%bodies(1) = body
    allocate (map%height, source=0.0_real64 * field%pressure)
    if (body%thickness > 0.0_real64 .and. map%strip_axis > 0) &
      call new%problems%add('body.layer: found one on a strip, expected both sides periodic or none')
    if (.not. has_memory(2 * room_to_press(map))) new%failure = not_enough_memory // &
                                                                ' for the pixels'
  end subroutine make_map

  ! Takes the body and the values of its pixels, pressures or displacements, and tractions.
  subroutine take_arrays(given, values, traction_x, traction_y, field, body, new)
    type(c_ptr), intent(in) :: given, values, traction_x, traction_y
    type(contact_field), intent(inout) :: field
    type(layered_body), intent(out) :: body
    type(outcome), intent(inout) :: new

    call take_half_space(given, field, body, new%problems)
    if (.not. c_associated(values)) call new%problems%add('pixels: found NULL, expected numbers')
    if (c_associated(traction_x) .neqv. c_associated(traction_y)) &
      call new%problems%add('traction_x and traction_y: found one of them, expected both or none')
    if (new%problems%count() > 0) return
    call take_pixels(values, field, field%pressure)
    call take_pixels(traction_x, field, field%traction)
    call take_pixels(traction_y, field, field%traction_y)
  end subroutine take_arrays

  ! Takes the pixels and the material of a body.
  subroutine take_half_space(given, field, body, problems)
    type(c_ptr), intent(in) :: given
    type(contact_field), intent(inout) :: field  ! gets the pixels
    type(layered_body), intent(out) :: body
    type(problem_list), intent(inout) :: problems
    type(c_half_space), pointer :: numbers
    integer :: i

    if (.not. c_associated(given)) then
      call problems%add('body: found NULL, expected a half-space')
      return
    end if
    call c_f_pointer(given, numbers)
    field%columns = numbers%columns
    field%rows = numbers%rows
    field%pixel_spacing = numbers%pixel_spacing
    field%periodic = all(numbers%periodic /= 0_c_int)
    if (.not. field%periodic) field%strip_axis = findloc(numbers%periodic /= 0_c_int, .true., 1)
    body = layered_body(numbers%thickness, numbers%modulus, numbers%ratio)
    if (min(field%columns, field%rows) < 1) then
      call problems%add('body: found ' // decimal_text(field%columns) // ' x ' // &
                        decimal_text(field%rows) // ' pixels, expected 1 or more along each side')
    else if (int(field%columns, int64) * field%rows > most_samples) then
      call problems%add('body: found more pixels than ' // decimal_text(int(most_samples)))
    end if
    if (.not. all(field%pixel_spacing > 0.0_real64 .and. field%pixel_spacing <= &
                  huge(1.0_real64))) &
      call problems%add('body.spacing: found ' // real_text(minval(field%pixel_spacing)) // &
                        ', expected numbers more than 0')
    if (.not. in_range(body%thickness, not_negative)) &
      call problems%add('body.layer: found ' // real_text(body%thickness) // ', expected ' // &
                        trim(expected_numbers(not_negative)))
    if (.not. (body%modulus(1) > 0.0_real64 .and. body%modulus(2) >= 0.0_real64 .and. &
               maxval(body%modulus) <= huge(1.0_real64))) &
      call problems%add('body.modulus: found ' // real_text(body%modulus(1)) // ' and ' // &
                        real_text(body%modulus(2)) // ', expected numbers more than 0, or 0 of a ' // &
                        'rigid base')
    do i = 1, 2
      if (.not. in_range(body%ratio(i), poisson_range)) &
        call problems%add('body.ratio: found ' // real_text(body%ratio(i)) // ', expected ' // &
                          trim(expected_numbers(poisson_range)))
    end do
  end subroutine take_half_space

  ! Copies the values of pixels; 0 where one is missing.
  subroutine take_pixels(address, field, values)
    type(c_ptr), intent(in) :: address
    type(contact_field), intent(in) :: field
    real(real64), allocatable, intent(out) :: values(:, :)
    real(c_double), pointer :: given(:, :)

    if (.not. c_associated(address)) return
    call c_f_pointer(address, given, [field%columns, field%rows])
    allocate (values, source=merge(given, 0.0_real64, abs(given) <= huge(1.0_real64)))
  end subroutine take_pixels

end module asperity_c_half_space
