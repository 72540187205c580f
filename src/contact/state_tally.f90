!> The contacts of a state: their totals, rows and warnings, in the unit of the scene.
module asperity_state_tally
  use asperity_contact_pairs, only: scaled_to_real64
  use asperity_contact_records, only: add_rows, contact_row, no_contacts, position_result, state_row
  use asperity_kinds, only: real64
  use asperity_overlapping_circles, only: count_overlapping
  use asperity_theory_limits, only: look_at_contact, look_at_state, seen_contact, theory_limits
  use asperity_theory_warnings, only: take_worse, theory_warning
  implicit none
  private

  public :: state_tally, add_contact, begin_tally, finish_tally

  !> A state after some of its contacts, in the units of the solver.
  type :: state_tally
    integer :: length_power = 0   !! unit of length is 2**length_power
    integer :: modulus_power = 0  !! unit of the modulus is 2**modulus_power
    integer :: load_power = 0     !! unit of loads is 2**load_power
    type(state_row), private :: totals = no_contacts
    logical, private :: limit_reached = .false.
    type(contact_row), allocatable, private :: rows(:)  ! not allocated: not kept
    real(real64), allocatable, private :: circles(:, :)  ! not allocated: not compared
    type(theory_warning), allocatable, private :: warnings(:)
  end type state_tally

contains

  !> Begins a state. Circles are compared in the last state only.
  pure subroutine begin_tally(tally, most, keep_rows, is_last)
    type(state_tally), intent(inout) :: tally  !! state with the units of the solver
    integer, intent(in) :: most                !! largest number of contacts
    logical, intent(in) :: keep_rows           !! whether the contacts are kept
    logical, intent(in) :: is_last             !! whether it is the last state of its position

    if (keep_rows) allocate (tally%rows(most))
    if (is_last) allocate (tally%circles(most, 3))
  end subroutine begin_tally

  !> Adds a contact.
  pure subroutine add_contact(tally, limits, contact)
    type(state_tally), intent(inout) :: tally   !! state of the contact
    type(theory_limits), intent(in) :: limits   !! limits of the theories
    type(seen_contact), intent(in) :: contact   !! contact in the units of the solver

    associate (totals => tally%totals, length => tally%length_power)
      totals%contacts = totals%contacts + 1
      totals%load = totals%load + contact%load
      totals%vertical_load = totals%vertical_load + contact%vertical_load
      totals%area = totals%area + contact%area
      totals%projected_area = totals%projected_area + contact%area * contact%cosine
      totals%greatest_pressure = max(totals%greatest_pressure, contact%maximum_pressure)
      tally%limit_reached = tally%limit_reached .or. contact%limit_exceeded
      call look_at_contact(limits, contact, tally%warnings)
      if (allocated(tally%circles)) &
        tally%circles(totals%contacts, :) = [contact%x, contact%y, contact%contact_radius]
      if (.not. allocated(tally%rows)) return
      tally%rows(totals%contacts) = contact_row( &
        contact%area_no, contact%upper, contact%lower, contact%limit_exceeded, &
        scaled_to_real64(contact%x, length), scaled_to_real64(contact%y, length), &
        scaled_to_real64(contact%penetration, length), scaled_to_real64(contact%overlap, length), &
        scaled_to_real64(contact%area, 2 * length), &
        scaled_to_real64(contact%area * contact%cosine, 2 * length), contact%d / contact%z, &
        scaled_to_real64(contact%load, tally%load_power), &
        scaled_to_real64(contact%vertical_load, tally%load_power), &
        scaled_to_real64(contact%average_pressure, tally%modulus_power), &
        scaled_to_real64(contact%maximum_pressure, tally%modulus_power))
    end associate
  end subroutine add_contact

  !> Adds the state to its position.
  subroutine finish_tally(tally, limits, approach, compression, number, result)
    type(state_tally), intent(inout) :: tally        !! state with all its contacts
    type(theory_limits), intent(in) :: limits        !! limits of the theories
    real(real64), intent(in) :: approach             !! separation of the planes
    real(real64), intent(in) :: compression              !! compression since first touch
    integer, intent(in) :: number                    !! number of the state, from 1
    type(position_result), intent(inout) :: result   !! gets the state
    real(real64) :: projected_area

    associate (totals => tally%totals, length => tally%length_power)
      projected_area = totals%projected_area
      totals%approach = scaled_to_real64(approach, length)
      totals%compression = scaled_to_real64(compression, length)
      totals%load = scaled_to_real64(totals%load, tally%load_power)
      totals%vertical_load = scaled_to_real64(totals%vertical_load, tally%load_power)
      totals%area = scaled_to_real64(totals%area, 2 * length)
      totals%projected_area = scaled_to_real64(projected_area, 2 * length)
      totals%greatest_pressure = scaled_to_real64(totals%greatest_pressure, tally%modulus_power)
      if (allocated(tally%rows)) call add_rows(result, tally%rows(:totals%contacts), totals)
      result%states(number) = totals
      result%limit_reached = tally%limit_reached
      if (allocated(tally%circles)) result%overlapping_circles = &
        count_overlapping(tally%circles(:totals%contacts, 1), tally%circles(:totals%contacts, 2), &
                          tally%circles(:totals%contacts, 3))
    end associate
    call look_at_state(limits, projected_area, result%overlapping_circles, tally%warnings)
    call take_worse(result%warnings, tally%warnings, number)
  end subroutine finish_tally

end module asperity_state_tally
