!> What the present-day solver computes, as records: the kernels fill them, the writers read them.
!>
!> Numbers are doubles in the units of the scene, whatever arithmetic computed them.
module asperity_contact_records
  use asperity_constants, only: pi
  use asperity_contact_field, only: contact_field
  use asperity_effect_names, only: known_effects
  use asperity_element_pressures, only: element_pressures
  use asperity_kinds, only: not_computed, real64
  use asperity_solve_ending, only: solve_ending
  use asperity_solution_start, only: solution_start
  use asperity_theory_warnings, only: theory_warning
  implicit none
  private

  public :: contact_row, effect_record, position_result, solve_method, state_row
  public :: asked_nothing, asked_normal, asked_vertical
  public :: by_events, by_marching, overlap_stable, overlap_original
  public :: add_rows, are_finite, contact_radius, cut_rows, most_rows, room_of_a_state

  !> So many contacts can be kept: their list in a file has up to 400 bytes each.
  integer, parameter :: most_rows = 5000000

  !> Memory that a state of a position takes, with its share of the position, bytes.
  integer, parameter :: room_of_a_state = 440

  !> Each position is solved at the closings at which something happens: no marching.
  integer, parameter :: by_events = 1
  !> Each position is closed in equal steps until a limit is passed, as the original does it.
  integer, parameter :: by_marching = 2

  !> Overlap from the penetration, without cancellation.
  integer, parameter :: overlap_stable = 1
  !> Overlap as RU + RL - SQRT(d**2 + z**2), as the original computes it.
  integer, parameter :: overlap_original = 2

  !> A state ends at no load.
  integer, parameter :: asked_nothing = 0
  !> A state ends at a sum of the normal forces.
  integer, parameter :: asked_normal = 1
  !> A state ends at a sum of their vertical parts.
  integer, parameter :: asked_vertical = 2

  !> How to compute: the solver proper is `solve_method()`; the rest serves the accuracy study.
  type :: solve_method
    integer :: path = by_events               !! `by_events` or `by_marching`
    integer :: overlap = overlap_stable       !! `overlap_stable` or `overlap_original`
    real(real64) :: step = 0.0_real64         !! marching step, in the scene's unit of length
    logical :: past_the_end = .false.         !! all pairs that may touch under a larger load, too
  end type solve_method

  !> One contact in one state of one position.
  type :: contact_row
    integer :: area_no = 0                         !! from 1, in the order of first touch
    integer :: upper = 0                           !! index of the upper asperity; 0: a plane
    integer :: lower = 0                           !! index of the lower asperity; 0: a plane
    logical :: limit_exceeded = .false.            !! at or over its limit
    real(real64) :: x = 0.0_real64                 !! centre of the contact
    real(real64) :: y = 0.0_real64                 !! centre of the contact
    real(real64) :: penetration = 0.0_real64       !! vertical, past first touch
    real(real64) :: overlap = 0.0_real64           !! decrease of the distance of centres
    real(real64) :: area = 0.0_real64              !! contact area
    real(real64) :: projected_area = 0.0_real64    !! its projection on the plane
    real(real64) :: slope = 0.0_real64             !! tangent of the contact's inclination
    real(real64) :: load = 0.0_real64              !! force normal to the contact
    real(real64) :: vertical_load = 0.0_real64     !! its vertical part
    real(real64) :: average_pressure = 0.0_real64  !! load over area
    real(real64) :: maximum_pressure = 0.0_real64  !! 1.5 times the average
  end type contact_row

  !> One state of one position: totals over its contacts.
  type :: state_row
    real(real64) :: approach = 0.0_real64        !! separation of the reference planes
    real(real64) :: closing = 0.0_real64         !! how far past first touch
    real(real64) :: time = 0.0_real64            !! since the end of loading
    integer :: contacts = 0                      !! touching ones included
    real(real64) :: load = 0.0_real64            !! sum of the normal forces
    real(real64) :: vertical_load = 0.0_real64   !! sum of their vertical parts
    real(real64) :: area = 0.0_real64            !! sum of the areas
    real(real64) :: projected_area = 0.0_real64  !! sum of the projected areas
    real(real64) :: greatest_pressure = 0.0_real64  !! at any point of a contact
    !> Work dissipated by plasticity since first contact [force length]; `not_computed` without it.
    real(real64) :: dissipated_work = not_computed
    integer :: asked = asked_nothing             !! which load was asked for
    real(real64) :: load_asked = 0.0_real64      !! how much of it
    integer :: first_row = 1                     !! its contacts are rows(first_row ...
    integer :: last_row = 0                      !! ... last_row) of the position
    !> Mean gap and root mean square of the gap [length], length of the rims of the contact patches
    !> [length], elastic energy [force length]; `not_computed` where no pixels of a map were solved.
    real(real64) :: mean_gap = not_computed, rms_gap = not_computed
    real(real64) :: contact_perimeter = not_computed, elastic_energy = not_computed
    !> Area at the hardness [length**2]; `not_computed` without one.
    real(real64) :: plastic_area = not_computed
  end type state_row

  !> What one effect did to one state. Words are in whole multiples of 8 letters: a record travels
  !> as words of 64 bits.
  type :: effect_record
    character(len=16) :: simulated = 'off'    !! how: coupled, boundary, on; `off`: left out
    character(len=40) :: why = ''             !! in a few words, where the effect had a choice
    real(real64) :: estimate = not_computed   !! estimated share of the total vertical load
    real(real64) :: influence = not_computed  !! measured share, where simulated; with its sign
    real(real64) :: error = not_computed      !! estimated relative error of its own solve
    !> Measured change of the closing at the load asked for, as a share of it; and of the area.
    real(real64) :: closing_change = not_computed, area_change = not_computed
    type(solve_ending) :: ending              !! how its solve ended
    logical :: influence_known = .false.      !! the effect measured it like with like
  end type effect_record

  !> One position: its states in the order of closing; the last one is the end.
  type :: position_result
    real(real64) :: x_displacement = 0.0_real64        !! of the upper surface
    real(real64) :: y_displacement = 0.0_real64        !! of the upper surface
    logical :: limit_reached = .false.                 !! a contact is at its limit at the end
    integer :: counted = 0                             !! states that progress has counted
    integer :: overlapping_circles = 0                 !! pairs of contact circles, at the end
    real(real64) :: first_step_pressure = 0.0_real64   !! of the first contact one step past touch
    !> Estimated relative error of the load or, under load control, of the approach over the
    !> closing; `not_computed`: nothing is known.
    real(real64) :: error_estimate = not_computed
    !> Estimated influence on the load of each known effect that is off, as a share of it.
    real(real64) :: left_out(size(known_effects)) = not_computed
    !> What lies outside a theory, at any state, by kind; not allocated: nothing.
    type(theory_warning), allocatable :: warnings(:)
    type(state_row), allocatable :: states(:)          !! at least one
    type(contact_row), allocatable :: rows(:)          !! contacts of all states kept
    integer :: rows_used = 0                           !! so many of them are filled
    logical :: lacks_memory = .false.                  !! there was none for all contacts
    !> What each effect of the scene did to the last state; not allocated: the scene has none.
    type(effect_record), allocatable :: effects(:)
    real(real64), allocatable :: contact_values(:, :)  !! of their columns (row, column)
    real(real64), allocatable :: state_values(:)       !! of the last state (column)
    type(solution_start) :: start = solution_start()   !! solutions for further runs, where kept
    !> Pressures on boundary elements and shifts of contacts, by state, in the unit of the scene;
    !> not allocated: none were kept.
    type(element_pressures), allocatable :: pressures(:)
    !> Pressure and gap of its states, in their order; not allocated: none were kept.
    type(contact_field), allocatable :: fields(:)
  end type position_result

contains

  !> Adds the contacts of one state to those of its position.
  pure subroutine add_rows(result, rows, state)
    type(position_result), intent(inout) :: result  !! the position
    type(contact_row), intent(in) :: rows(:)        !! its contacts in this state
    type(state_row), intent(inout) :: state         !! learns where they are
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

  !> Radius of the circle that has the area of a contact.
  pure real(real64) function contact_radius(row)
    type(contact_row), intent(in) :: row  !! the contact

    contact_radius = sqrt(row%area / pi)
  end function contact_radius

  !> Gives back the room beyond the last contact.
  pure subroutine cut_rows(result)
    type(position_result), intent(inout) :: result  !! the position

    if (result%rows_used < size(result%rows)) result%rows = result%rows(:result%rows_used)
  end subroutine cut_rows

  !> Whether all results of a position are numbers: a slope of 1E308 asks for more than a double.
  pure logical function are_finite(result)
    type(position_result), intent(in) :: result  !! the position
    integer :: i

    are_finite = finite([result%x_displacement, result%y_displacement])
    if (allocated(result%state_values)) are_finite = are_finite .and. finite(result%state_values)
    if (allocated(result%contact_values)) &
      are_finite = are_finite .and. all(abs(result%contact_values) <= huge(1.0_real64))
    do i = 1, size(result%states)
      associate (state => result%states(i))
        are_finite = are_finite .and. &
                     finite([state%approach, state%closing, state%load, state%vertical_load, &
                             state%area, state%projected_area, state%greatest_pressure, &
                             state%mean_gap, state%rms_gap, state%contact_perimeter, &
                             state%elastic_energy])
      end associate
    end do
    do i = 1, result%rows_used
      associate (row => result%rows(i))
        are_finite = are_finite .and. &
                     finite([row%x, row%y, row%penetration, row%overlap, row%area, &
                             row%projected_area, row%slope, row%load, row%vertical_load, &
                             row%average_pressure, row%maximum_pressure])
      end associate
    end do
  end function are_finite

  pure logical function finite(numbers)
    real(real64), intent(in) :: numbers(:)

    finite = all(abs(numbers) <= huge(numbers))
  end function finite

end module asperity_contact_records
