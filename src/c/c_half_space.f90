!> The library for C: bodies under arrays of pressures and tractions; `include/asperity.h` has what
!> each procedure does.
module asperity_c_half_space
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_ptr
  use asperity, only: add_reals, contact_field, decimal_text
  use asperity_c_outcome, only: begin_outcome, finish_outcome, outcome, table_fields
  use asperity_csv_tables, only: first_stress, stress_cells, stress_columns, stress_names
  use asperity_height_map, only: height_map, layered_body, longest_side
  use asperity_kinds, only: int64, real64
  use asperity_library_turn, only: library_turn
  use asperity_map_contact, only: displacement_by, room_to_press
  use asperity_map_stress, only: check_stress, stress_solver
  use asperity_numeral, only: above_zero, expected_numbers, in_range, not_negative, poisson_range
  use asperity_problems, only: problem_list, real_text
  use asperity_process, only: check_memory
  use asperity_scene_values, only: body_compliance
  use asperity_surface_pressure, only: find_pressure
  use asperity_traction_convolution, only: by_tractions, normal_by_tractions, &
                                           tangential_by_pressures, traction_convolution
  implicit none
  private

  public :: c_half_space, c_loaded

  ! Numbers of the requests in the header.
  integer(c_int), parameter :: displacements = 1_c_int, pressures = 2_c_int, stresses = 3_c_int

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

  !> `asperity_loaded`.
  type(c_ptr) function c_loaded(given, what, values, traction_x, traction_y, depth) &
    bind(c, name='asperity_loaded') result(handle)
    type(c_ptr), value :: given                   !! `c_half_space`
    integer(c_int), value :: what                 !! 1: displacements, 2: pressures, 3: stresses
    type(c_ptr), value :: values                  !! (column, row): pressures, or displacements
    type(c_ptr), value :: traction_x, traction_y  !! alike; both null: none
    real(c_double), value :: depth                !! of stresses, 0 or more
    type(library_turn) :: turn
    type(outcome), pointer :: new
    type(contact_field) :: field
    type(height_map) :: map
    type(stress_solver) :: solver
    character(len=14) :: names(stress_columns)
    real(real64), allocatable :: cells(:, :), pressure(:, :), stress(:, :, :)
    integer :: first, i

    call begin_outcome(new, handle, turn)
    if (.not. associated(new)) return
    call take_half_space(given, values, [traction_x, traction_y], field, map, new%problems, &
                         new%failure)
    if (all(what /= [displacements, pressures, stresses])) &
      call new%problems%add('what: found ' // decimal_text(what) // ', expected 1, 2 or 3')
    if (.not. new%is_good()) then
      continue
    else if (what == stresses) then
      call check_stress(field, depth, map%bodies(1), new%failure)
    else
      call check_surface(map, allocated(field%traction), new%problems, new%failure)
    end if
    call turn%finish()
    names = stress_names
    first = 1
    if (new%is_good()) then
      associate (modulus => 1.0_real64 / body_compliance(map%bodies(1)%modulus(1), &
                                                         map%bodies(1)%ratio(1)))
        select case (what)
        case (displacements)
          names(:3) = ['displacement_z', 'displacement_x', 'displacement_y']
          call find_displacements(map, field, modulus, cells)
        case (pressures)
          names(1) = 'pressure'
          call find_pressure(map, modulus, field%pressure, pressure, new%failure)
          if (.not. allocated(new%failure)) &
            allocate (cells, source=reshape(pressure, [size(pressure, kind=int64), 1_int64]))
        case default
          first = first_stress
          call solver%prepare(field, map%bodies(1), .false.)
          call solver%solve(depth, stress)
          allocate (cells, source=stress_cells(field, depth, stress))
        end select
      end associate
    end if
    call turn%begin()
    if (allocated(cells)) then
      do i = first, size(cells, 2)
        call add_reals(new%tables(table_fields), trim(names(i)), cells(:, i), '')
      end do
    end if
    call finish_outcome(new)
  end function c_loaded

  ! Displacements along z and, with tractions, along x and y.
  subroutine find_displacements(map, field, modulus, cells)
    type(height_map), intent(in) :: map
    type(contact_field), intent(in) :: field   ! pressures and tractions
    real(real64), intent(in) :: modulus
    real(real64), allocatable, intent(out) :: cells(:, :)  ! (pixel, direction)
    type(traction_convolution) :: tangential
    real(real64), dimension(map%columns, map%rows, 3) :: coupled, direct
    integer(int64) :: n

    n = size(map%height, kind=int64)
    if (.not. allocated(field%traction)) then
      allocate (cells, source=reshape(displacement_by(map, modulus, field%pressure), &
                                      [n, 1_int64]))
      return
    end if
    associate (nu => map%bodies(1)%ratio(1), sides => map%pixel_spacing, &
               traction => reshape([field%traction, field%traction_y], [map%columns, map%rows, 2]))
      call tangential%prepare(shape(map%height), sides(2) / sides(1), &
                              [map%repeats(1), map%repeats(2)], nu, &
                              (1.0_real64 - 2.0_real64 * nu) / (2.0_real64 * (1.0_real64 - nu)))
      call tangential%apply(traction, coupled(:, :, :1), normal_by_tractions)
      call tangential%apply(traction, direct(:, :, 2:), by_tractions)
      call tangential%apply(reshape(field%pressure, [map%columns, map%rows, 1]), &
                            coupled(:, :, 2:), tangential_by_pressures)
      direct(:, :, 2:) = direct(:, :, 2:) * (sides(1) / modulus)
      direct(:, :, 1) = displacement_by(map, modulus, field%pressure)
      allocate (cells, source=reshape(direct + coupled * (sides(1) / modulus), &
                                      [n, 3_int64]))
    end associate
  end subroutine find_displacements

  ! Refuses what has no displacements, and a lack of memory.
  subroutine check_surface(map, has_tractions, problems, failure)
    type(height_map), intent(in) :: map
    logical, intent(in) :: has_tractions
    type(problem_list), intent(inout) :: problems
    character(len=:), allocatable, intent(inout) :: failure

    if (map%bodies(1)%thickness > 0.0_real64 .and. has_tractions) &
      call problems%add('tractions on a layer: found them, expected pressures alone')
    if (map%bodies(1)%thickness > 0.0_real64 .and. map%strip_axis > 0) &
      call problems%add('body.layer: found one on a strip, expected both sides periodic or none')
    call check_memory('the pixels', failure, bytes=4 * room_to_press(map))
  end subroutine check_surface

  ! Takes the values of the pixels, their lattice, and as a map the body beside a rigid one.
  subroutine take_half_space(given, values, tractions, field, map, problems, failure)
    type(c_ptr), intent(in) :: given, values, tractions(2)
    type(contact_field), intent(inout) :: field
    type(height_map), intent(inout) :: map
    type(problem_list), intent(inout) :: problems
    character(len=:), allocatable, intent(inout) :: failure  ! set where memory is short
    type(c_half_space), pointer :: numbers
    integer :: i

    call require_fact(c_associated(given), 'body: found NULL, expected a half-space')
    call require_fact(c_associated(values), 'values: found NULL, expected numbers')
    call require_fact(c_associated(tractions(1)) .eqv. c_associated(tractions(2)), &
                 'tractions: found one of two, expected both or none')
    if (problems%count() > 0) return
    call c_f_pointer(given, numbers)
    call require_fact(min(numbers%columns, numbers%rows) > 0_c_int .and. &
                 max(numbers%columns, numbers%rows) <= longest_side, 'body: found ' // &
                 decimal_text(numbers%columns) // ' x ' // decimal_text(numbers%rows) // &
                 ' pixels, expected 1 to ' // decimal_text(longest_side) // ' a side')
    call require_fact(all([(in_range(numbers%pixel_spacing(i), above_zero), i=1, 2)]), &
                 'body.spacing: found ' // real_text(minval(numbers%pixel_spacing)) // ', ' // &
                 'expected numbers more than 0')
    call require_fact(in_range(numbers%thickness, not_negative), 'body.layer: found ' // &
                 real_text(numbers%thickness) // ', expected a number of 0 or more')
    call require_fact(in_range(numbers%modulus(1), above_zero) .and. &
                 in_range(numbers%modulus(2), not_negative), 'body.modulus: found ' // &
                 real_text(minval(numbers%modulus)) // ', expected numbers more than 0, or ' // &
                 '0 of a rigid base')
    call require_fact(all([(in_range(numbers%ratio(i), poisson_range), i=1, 2)]), &
                 'body.ratio: found ' // real_text(maxval(numbers%ratio)) // ', expected ' // &
                 trim(expected_numbers(poisson_range)))
    if (problems%count() > 0) return
    map%columns = numbers%columns
    map%rows = numbers%rows
    map%pixel_spacing = numbers%pixel_spacing
    map%periodic = all(numbers%periodic /= 0_c_int)
    if (.not. map%periodic) map%strip_axis = findloc(numbers%periodic /= 0_c_int, .true., 1)
    map%bodies(1) = layered_body(numbers%thickness, numbers%modulus, numbers%ratio)
    field%columns = map%columns
    field%rows = map%rows
    field%pixel_spacing = map%pixel_spacing
    field%periodic = map%periodic
    field%strip_axis = map%strip_axis
    call take_pixels(values, field%pressure)
    call take_pixels(tractions(1), field%traction)
    call take_pixels(tractions(2), field%traction_y)
    call take_pixels(values, map%height)
    if (.not. allocated(failure)) map%height = 0.0_real64

  contains

    subroutine require_fact(is_good, message)
      logical, intent(in) :: is_good
      character(len=*), intent(in) :: message

      if (.not. is_good) call problems%add(message)
    end subroutine require_fact

    ! Copies the values of pixels; 0 where one is missing.
    subroutine take_pixels(address, copy)
      type(c_ptr), intent(in) :: address
      real(real64), allocatable, intent(out) :: copy(:, :)
      real(c_double), pointer :: numbers_of(:, :)
      integer :: status

      if (.not. c_associated(address) .or. allocated(failure)) return
      call c_f_pointer(address, numbers_of, [field%columns, field%rows])
      allocate (copy(field%columns, field%rows), stat=status)
      call check_memory('the pixels', failure, status)
      if (.not. allocated(failure)) &
        copy(:, :) = merge(numbers_of, 0.0_real64, abs(numbers_of) <= huge(1.0_real64))
    end subroutine take_pixels

  end subroutine take_half_space

end module asperity_c_half_space
