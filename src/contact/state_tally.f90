!> The contacts of a state: their totals, rows and warnings, in the unit of the scene.
module asperity_state_tally
  use asperity_cell_grid, only: build_grid, cell_grid
  use asperity_cell_layer, only: any_height, margin_of_arithmetic
  use asperity_contact_pairs, only: scaled_to_real64
  use asperity_contact_records, only: add_rows, contact_row, no_contacts, position_result, state_row
  use asperity_kinds, only: real64
  use asperity_pair_search_layers, only: found_pairs, search_pairs
  use asperity_theory_limits, only: look_at_contact, look_at_state, seen_contact, theory_limits
  use asperity_theory_warnings, only: take_worse, theory_warning
  implicit none
  private

  public :: state_tally, add_contact, begin_tally, finish_tally, circles_overlap, &
            count_overlapping

  !> A state after some of its contacts, in the units of the solver.
  type :: state_tally
    integer :: length_power = 0   !! unit of length is 16**length_power
    integer :: modulus_power = 0  !! unit of the modulus is 16**modulus_power
    integer :: load_power = 0     !! unit of loads is 16**load_power
    type(state_row), private :: totals = no_contacts
    logical, private :: limit_reached = .false.
    type(contact_row), allocatable, private :: rows(:)  ! not allocated: not kept
    real(real64), allocatable, private :: circles(:, :)  ! not allocated: not compared
    type(theory_warning), allocatable, private :: warnings(:)
  end type state_tally

  integer, parameter :: few = 64  ! number of circles up to which all pairs are compared

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
      tally%limit_reached = tally%limit_reached .or. contact%at_limit
      call look_at_contact(limits, contact, tally%warnings)
      if (allocated(tally%circles)) &
        tally%circles(totals%contacts, :) = [contact%x, contact%y, contact%contact_radius]
      if (.not. allocated(tally%rows)) return
      tally%rows(totals%contacts) = contact_row( &
        contact%number, contact%upper, contact%lower, contact%at_limit, &
        scaled_to_real64(contact%x, length), scaled_to_real64(contact%y, length), &
        scaled_to_real64(contact%penetration, length), scaled_to_real64(contact%overlap, length), &
        scaled_to_real64(contact%area, 2 * length), &
        scaled_to_real64(contact%area * contact%cosine, 2 * length), contact%d / contact%z, &
        scaled_to_real64(contact%load, tally%load_power), &
        scaled_to_real64(contact%vertical_load, tally%load_power), &
        scaled_to_real64(contact%pressure, tally%modulus_power), &
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

  !> Number of pairs of circles that overlap. Circles without radius are left out. In large sets
  !> they are found by the search for pairs of asperities, at a cost proportional to the numbers of
  !> circles and of pairs; in small sets, without memory for the search, or with centres too far
  !> apart to be squared, all pairs are compared.
  integer function count_overlapping(x, y, radius) result(number)
    real(real64), intent(in) :: x(:), y(:)   !! centres of the circles
    real(real64), intent(in) :: radius(:)    !! radius of each circle, 0 or more
    type(found_pairs) :: near                ! each pair twice, as upper and lower
    integer, allocatable :: members(:)
    type(cell_grid) :: grid
    real(real64) :: unit, margin
    logical :: each_with_each
    integer :: i, j, k

    number = 0
    members = pack([(i, i=1, size(x))], radius > 0.0_real64)
    if (size(members) == 0) return
    ! The search squares lengths over the largest radius.
    unit = maxval(radius)
    each_with_each = size(x) <= few .or. &
                     max(maxval(abs(x(members))), maxval(abs(y(members)))) / sqrt(huge(unit)) > unit
    if (.not. each_with_each) then
      margin = margin_of_arithmetic(epsilon(unit), &
                                    2 * maxval(abs(x(members)) + abs(y(members))) / unit + 2)
      call build_grid(grid, x(members) / unit, y(members) / unit, &
                      spread(0.0_real64, 1, size(members)), radius(members) / unit, any_height)
      call search_pairs(grid, grid, 0.0_real64, 0.0_real64, any_height, margin, -huge(unit), near, &
                        each_with_each)
    end if
    if (each_with_each) then
      do i = 2, size(members)
        do j = 1, i - 1
          if (do_overlap(members(i), members(j))) number = number + 1
        end do
      end do
      return
    end if
    do k = 1, near%blocks
      associate (block => near%block(k))
        do i = 1, block%used
          if (block%upper(i) >= block%lower(i)) cycle
          if (do_overlap(members(block%upper(i)), members(block%lower(i)))) number = number + 1
        end do
      end associate
    end do

  contains

    pure logical function do_overlap(one, other)
      integer, intent(in) :: one, other

      do_overlap = circles_overlap(x(one) - x(other), y(one) - y(other), radius(one), radius(other))
    end function do_overlap

  end function count_overlapping

  !> Whether two circles overlap.
  pure logical function circles_overlap(dx, dy, first, second)
    real(real64), intent(in) :: dx, dy           !! distance of the centres along x and y
    real(real64), intent(in) :: first, second    !! radii of the circles

    circles_overlap = abs(dx) < first + second .and. abs(dy) < first + second
    if (.not. circles_overlap) return
    circles_overlap = first > 0.0_real64 .and. second > 0.0_real64 .and. &
                      dx * dx + dy * dy < (first + second)**2
  end function circles_overlap

end module asperity_state_tally
