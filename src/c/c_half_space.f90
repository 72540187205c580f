!> The library for C: bodies under arrays of pressures and tractions; `include/asperity.h` has what
!> each procedure does.
module asperity_c_half_space
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_ptr
  use asperity, only: add_reals, contact_field, decimal_text
  use asperity_c_outcome, only: begin_outcome, finish_outcome, outcome, table_fields
  use asperity_csv_tables, only: first_stress, stress_cells, stress_columns, stress_names
  use asperity_height_map, only: layered_body, most_samples
  use asperity_kinds, only: int64, real64
  use asperity_library_turn, only: library_turn
  use asperity_map_stress, only: check_stress, stress_solver
  use asperity_numeral, only: expected_numbers, in_range, not_negative, poisson_range
  use asperity_problems, only: problem_list, real_text
  implicit none
  private

  public :: c_half_space, c_stress

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
    call take_half_space(given, field, body, new%problems)
    if (.not. (depth >= 0.0_real64 .and. depth <= huge(depth))) &
      call new%problems%add('depth: found ' // real_text(depth) // &
                            ', expected a number of 0 or more')
    if (.not. c_associated(pressure)) &
      call new%problems%add('pressure: found NULL, expected numbers')
    if (c_associated(traction_x) .neqv. c_associated(traction_y)) &
      call new%problems%add('traction_x and traction_y: found one of them, expected both or none')
    if (new%problems%count() == 0) then
      call take_pixels(pressure, field, field%pressure)
      call take_pixels(traction_x, field, field%traction)
      call check_stress(field, depth, body, new%failure)
    end if
    call turn%finish()
    if (new%problems%count() == 0 .and. .not. allocated(new%failure)) then
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
