!> Records of the results of the present-day solver, which the kernels fill and the writers read.
!>
!> Numbers are doubles in the units of the scene, for any arithmetic of the solver.
module asperity_contact_records
  use asperity_constants, only: pi
  use asperity_contact_field, only: contact_field
  use asperity_effect_names, only: known_effects
  use asperity_effect_header, only: column_name
  use asperity_element_pressures, only: element_pressures
  use asperity_kinds, only: not_computed, real64
  use asperity_solve_ending, only: solve_ending
  use asperity_theory_warnings, only: theory_warning
  implicit none
  private

  public :: contact_row, effect_record, no_contacts, position_result, solve_method, state_row, &
            prescribed_nothing, prescribed_normal, prescribed_vertical, by_events, by_marching, &
            overlap_stable, overlap_original, add_rows, all_finite, are_finite, contact_radius, &
            cut_rows, drop_rows, most_rows, room_of_a_state

  !> Largest number of contacts that is kept: a list in a file has up to 400 bytes a contact.
  integer, parameter :: most_rows = 5000000

  !> Memory of a state of a position, with its share of the position, bytes.
  integer, parameter :: room_of_a_state = 480

  !> Path to the end of a position: solved at first touches and at the end; or marching in equal
  !> steps until a limit is passed, as in the original.
  integer, parameter :: by_events = 1, by_marching = 2

  !> Overlap from the penetration, without cancellation; or RU + RL - SQRT(d**2 + z**2), as in the
  !> original.
  integer, parameter :: overlap_stable = 1, overlap_original = 2

  !> Load prescribed for a state: none, a sum of the normal forces, a sum of their vertical parts.
  integer, parameter :: prescribed_nothing = 0, prescribed_normal = 1, prescribed_vertical = 2

  !> Method of the solver. The default is that of every solve; others are for the accuracy study.
  type :: solve_method
    integer :: path = by_events               !! `by_events` or `by_marching`
    integer :: overlap = overlap_stable       !! `overlap_stable` or `overlap_original`
    real(real64) :: step = 0.0_real64         !! marching step, in the scene's unit of length
    logical :: past_the_end = .false.         !! find all pairs that may touch under a larger load
    logical :: keeps_first = .false.          !! keep the pair of first contact, though it is open
    real(real64) :: reach = 0.0_real64        !! gap up to which pairs attract [scene's length]
  end type solve_method

  !> One contact in one state of one position. It is created as not computed; a whole number is then
  !> negative.
  type :: contact_row
    integer :: area_no = -1                        !! from 1, in the order of first touch
    integer :: upper = -1                          !! index of the upper asperity; 0: a plane
    integer :: lower = -1                          !! index of the lower asperity; 0: a plane
    logical :: limit_exceeded = .false.            !! at or over its limit
    real(real64) :: x = not_computed               !! centre of the contact
    real(real64) :: y = not_computed               !! centre of the contact
    real(real64) :: penetration = not_computed     !! vertical, past first touch
    real(real64) :: overlap = not_computed         !! decrease of the distance of centres
    real(real64) :: area = not_computed            !! contact area
    real(real64) :: projected_area = not_computed  !! its projection on the plane
    real(real64) :: slope = not_computed           !! tangent of the contact's inclination
    real(real64) :: load = not_computed            !! force normal to the contact
    real(real64) :: vertical_load = not_computed   !! its vertical part
    real(real64) :: average_pressure = not_computed  !! load over area
    real(real64) :: maximum_pressure = not_computed  !! 1.5 times the average
  end type contact_row

  !> One state of one position: totals over its contacts, created as not computed. Whole numbers
  !> stand in pairs: a record is sent in words of 64 bits, without gaps.
  type :: state_row
    real(real64) :: approach = not_computed        !! separation of the reference planes
    real(real64) :: compression = not_computed         !! compression since first touch
    real(real64) :: time = not_computed            !! time since the begin of loading
    real(real64) :: load = not_computed            !! sum of the normal forces
    real(real64) :: vertical_load = not_computed   !! sum of their vertical parts
    real(real64) :: area = not_computed            !! sum of the areas
    real(real64) :: projected_area = not_computed  !! sum of the projected areas
    real(real64) :: greatest_pressure = not_computed  !! at any point of a contact
    !> Work dissipated by plasticity since first contact [force length]; `not_computed` without it.
    real(real64) :: dissipated_work = not_computed
    real(real64) :: prescribed_load = 0.0_real64  !! value of the prescribed load
    real(real64) :: load_rounding = 0.0_real64    !! rounding error of the found load
    integer :: prescribed = prescribed_nothing    !! kind of load: a `prescribed_` number
    integer :: contacts = -1                     !! touching ones included
    integer :: first_row = 1                     !! its contacts are rows(first_row ...
    integer :: last_row = 0                      !! ... last_row) of the position
    !> Mean gap and root mean square of the gap [length], length of the rims of the contact patches
    !> [length], elastic energy [force length]; `not_computed` where no pixels of a map were solved.
    real(real64) :: mean_gap = not_computed, rms_gap = not_computed
    real(real64) :: contact_perimeter = not_computed, elastic_energy = not_computed
    !> Area at the hardness [length**2]; `not_computed` without one.
    real(real64) :: plastic_area = not_computed
    !> Estimated errors; `not_computed`: unknown. Relative ones of the load, under a prescribed load
    !> of the compression; of area, mean gap and greatest pressure; of the separation under a
    !> prescribed load, over the compression.
    real(real64) :: error_estimate = not_computed
    real(real64) :: area_error = not_computed, gap_error = not_computed
    real(real64) :: pressure_error = not_computed, separation_error = not_computed
  end type state_row

  !> Totals of a state before its contacts are added; the compression is set apart.
  type(state_row), parameter :: no_contacts = state_row( &
    time=0.0_real64, load=0.0_real64, vertical_load=0.0_real64, area=0.0_real64, &
    projected_area=0.0_real64, greatest_pressure=0.0_real64, contacts=0)

  !> Outcome of one effect in one state. It is sent in words of 64 bits, without gaps: lengths of
  !> texts are multiples of 8.
  type :: effect_record
    character(len=16) :: simulated = 'off'    !! coupled, boundary, on; `off`: left out
    character(len=40) :: why = ''             !! reason, where the effect had a choice
    real(real64) :: estimate = not_computed   !! estimated share of the total vertical load
    real(real64) :: influence = not_computed  !! measured share, where simulated; with its sign
    real(real64) :: error = not_computed      !! estimated relative error of its own solve
    !> Measured relative change of the compression at the prescribed load, and of the area.
    real(real64) :: compression_change = not_computed, area_change = not_computed
    !> How its solve ended; a residual and iterations that were not computed: a closed form.
    type(solve_ending) :: ending = solve_ending(not_computed, -1, .true.)
  end type effect_record

  !> One position: its states in the order of compression; the last one is the end.
  type :: position_result
    real(real64) :: x_displacement = 0.0_real64        !! displacement of the upper surface
    real(real64) :: y_displacement = 0.0_real64        !! displacement of the upper surface
    logical :: limit_reached = .false.                 !! a contact is at its limit at the end
    integer :: counted = 0                             !! states that progress has counted
    integer :: overlapping_circles = -1  !! pairs of contact circles, at the end; < 0: no circles
    real(real64) :: nominal_area = 0.0_real64          !! of this position; 0: that of the scene
    !> `error_estimate` of the last state.
    real(real64) :: error_estimate = not_computed
    !> `none` or `unknown` and why the pixels have no error, in words of 64 bits; blank: they have.
    character(len=160) :: no_estimate = ''
    !> Estimated influence on the load of each known effect that is off, as a share of it.
    real(real64) :: left_out(size(known_effects)) = not_computed
    !> Warnings of all states, by kind; not allocated: none.
    type(theory_warning), allocatable :: warnings(:)
    type(state_row), allocatable :: states(:)          !! at least one
    type(contact_row), allocatable :: rows(:)          !! contacts of all states kept
    integer :: rows_used = 0                           !! number of rows in use
    logical :: lacks_memory = .false.                  !! not all contacts could be kept
    !> Outcome of each effect in the last state; not allocated: the scene has no effects.
    type(effect_record), allocatable :: effects(:)
    real(real64), allocatable :: contact_values(:, :)  !! of their columns (row, column)
    real(real64), allocatable :: state_values(:)       !! of the last state (column)
    !> Names and units of the columns of these values.
    type(column_name), allocatable :: contact_columns(:), state_columns(:)
    !> Pressures on boundary elements and shifts of contacts, by state, in the unit of the scene;
    !> not allocated: none were kept.
    type(element_pressures), allocatable :: pressures(:)
    !> Pressure and gap of its states, in their order; not allocated: none were kept.
    type(contact_field), allocatable :: fields(:)
  end type position_result

contains

  !> Adds the contacts of one state to those of its position.
  pure subroutine add_rows(result, rows, state)
    type(position_result), intent(inout) :: result  !! results of the position
    type(contact_row), intent(in) :: rows(:)        !! contacts in this state
    type(state_row), intent(inout) :: state         !! gets the places of its contacts
    type(contact_row), allocatable :: larger(:)
    integer :: needed, status

    if (result%lacks_memory) return
    needed = result%rows_used + size(rows)
    if (needed > size(result%rows)) then
      allocate (larger(max(needed, 2 * size(result%rows))), stat=status)
      result%lacks_memory = status /= 0
      if (result%lacks_memory) return
      larger(:result%rows_used) = result%rows(:result%rows_used)
      call move_alloc(larger, result%rows)
    end if
    result%rows(result%rows_used + 1:needed) = rows
    state%first_row = result%rows_used + 1
    state%last_row = needed
    result%rows_used = needed
  end subroutine add_rows

  !> Radius of the circle that has the area of a contact; `not_computed` without an area.
  pure real(real64) function contact_radius(row)
    type(contact_row), intent(in) :: row  !! contact in a state

    contact_radius = not_computed
    if (row%area > not_computed) contact_radius = sqrt(row%area / pi)
  end function contact_radius

  !> Frees the memory beyond the last contact.
  pure subroutine cut_rows(result)
    type(position_result), intent(inout) :: result  !! results of the position

    if (result%rows_used < size(result%rows)) result%rows = result%rows(:result%rows_used)
  end subroutine cut_rows

  !> Removes the contacts of all states, which were kept for something else.
  pure subroutine drop_rows(result)
    type(position_result), intent(inout) :: result  !! results of the position

    result%rows_used = 0
    result%rows = result%rows(:0)
    result%states%first_row = 1
    result%states%last_row = 0
    if (allocated(result%contact_values)) result%contact_values = result%contact_values(:0, :)
  end subroutine drop_rows

  !> Whether all results of a position are finite.
  pure logical function are_finite(result)
    type(position_result), intent(in) :: result  !! results of the position
    integer :: i

    are_finite = all_finite([result%x_displacement, result%y_displacement])
    if (allocated(result%state_values)) &
      are_finite = are_finite .and. all_finite(result%state_values)
    if (allocated(result%contact_values)) &
      are_finite = are_finite .and. all(abs(result%contact_values) <= huge(1.0_real64))
    associate (states => result%states)
      are_finite = are_finite .and. all_finite([ &
        states%approach, states%compression, states%load, states%vertical_load, states%area, &
        states%projected_area, states%greatest_pressure, states%mean_gap, states%rms_gap, &
        states%contact_perimeter, states%elastic_energy, states%error_estimate, &
        states%area_error, states%gap_error, states%pressure_error, states%separation_error])
    end associate
    do i = 1, result%rows_used
      associate (row => result%rows(i))
        are_finite = are_finite .and. &
                     all_finite([row%x, row%y, row%penetration, row%overlap, row%area, &
                             row%projected_area, row%slope, row%load, row%vertical_load, &
                             row%average_pressure, row%maximum_pressure])
      end associate
    end do
  end function are_finite

  !> Whether all numbers are finite.
  pure logical function all_finite(numbers)
    real(real64), intent(in) :: numbers(:)  !! of any size

    all_finite = all(abs(numbers) <= huge(numbers))
  end function all_finite

end module asperity_contact_records
