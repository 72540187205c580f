!> What accuracy costs in time: every way of computing a sweep, its errors and its time.
!>
!> Ways: four arithmetics; exact events, or marching with four steps; the original's overlap, or
!> the stable one; and the original program itself where the input is a deck. Errors are measured
!> against exact events with the stable overlap in real128.
module asperity_accuracy_study
  use asperity_arithmetics, only: solver_in
  use asperity_card_deck, only: card_deck
  use asperity_contact_records, only: by_events, by_marching, overlap_original, overlap_stable, &
                                      solve_method, state_row
  use asperity_front, only: on_front
  use asperity_kinds, only: int64, real64
  use asperity_decimal, only: decimal_value
  use asperity_original, only: arithmetic_names, run_in_arithmetic
  use asperity_original_records, only: original_positions, original_records, original_request
  use asperity_position_solver, only: position_solver
  use asperity_progress, only: progress_line
  use asperity_scene_results, only: last_state, scene_results
  use asperity_scene_values, only: scene
  use asperity_timing, only: time_allowance, time_solver, timing_samples
  implicit none
  private

  public :: accuracy_row, run_accuracy_study, number_of_ways
  public :: load_error, area_error, pressure_error, approach_error, count_error
  public :: way_events, way_marching, way_original

  ! Ways of computing.
  integer, parameter :: way_events = 1    !! exact events
  integer, parameter :: way_marching = 2  !! marching, nothing carried between positions
  integer, parameter :: way_original = 3  !! the original program, state carried

  ! Quantities whose error is measured, at the last state of every position but for the pressure.
  integer, parameter :: load_error = 1      !! total load
  integer, parameter :: area_error = 2      !! total area
  integer, parameter :: pressure_error = 3  !! of the first contact, one step past its touch
  integer, parameter :: approach_error = 4  !! approach
  integer, parameter :: count_error = 5     !! number of contacts

  !> Marching steps of the study, for a deck in cm, and their powers of ten.
  integer, parameter :: step_powers(4) = [-2, -3, -4, -5]
  real(real64), parameter :: deck_steps(4) = [1.0e-2_real64, 1.0e-3_real64, 1.0e-4_real64, &
                                              1.0e-5_real64]
  !> The step at which the pressure of exact events is taken: the original's.
  integer, parameter :: usual_step = 2

  !> One way of computing: its cost and its errors.
  type :: accuracy_row
    character(len=7) :: arithmetic = ''          !! one of `arithmetic_names`
    integer :: way = way_events                  !! one of the ways above
    real(real64) :: step = 0.0_real64            !! marching step; 0 for exact events
    integer :: overlap = overlap_stable          !! `overlap_stable` or `overlap_original`
    real(real64) :: seconds = 0.0_real64         !! a position, median
    real(real64) :: spread = 0.0_real64          !! half the quartile distance over the median
    real(real64) :: ratio = 1.0_real64           !! seconds over those of the fastest row
    real(real64) :: largest(5) = 0.0_real64      !! relative errors, largest over the positions
    real(real64) :: mean(5) = 0.0_real64         !! relative errors, mean over the positions
    real(real64) :: worst = 0.0_real64           !! largest of the errors but for the count
    logical :: on_front = .false.                !! the cheapest for its accuracy
  end type accuracy_row

contains

  !> How many ways there are to be measured.
  pure integer function number_of_ways(with_original)
    logical, intent(in) :: with_original  !! the original program is one of them

    number_of_ways = size(arithmetic_names) * &
                     (2 * (1 + size(deck_steps)) + merge(1, 0, with_original))
  end function number_of_ways

  !> Runs the study. The scene is a sweep to the limit; `deck` is allocated when it came from a
  !> deck alone, and the original program can be run on it.
  subroutine run_accuracy_study(scene_in, deck, least_seconds, allowance, progress, rows, &
                                left_out, failure)
    type(scene), intent(in) :: scene_in                         !! checked values
    type(card_deck), allocatable, intent(in) :: deck            !! its cards, or not allocated
    real(real64), intent(in) :: least_seconds                   !! time to spend on a row, s
    type(time_allowance), intent(in) :: allowance               !! time that may be spent
    type(progress_line), intent(inout) :: progress              !! begun; a piece is a way
    type(accuracy_row), allocatable, intent(out) :: rows(:)     !! in a fixed order
    integer, intent(out) :: left_out                            !! ways that took too long
    character(len=:), allocatable, intent(out) :: failure       !! why it cannot be run
    type(scene_results) :: reference(size(deck_steps)), results
    type(timing_samples) :: timing
    type(accuracy_row) :: row
    real(real64) :: steps(size(deck_steps))
    integer :: a, k, overlap

    allocate (rows(0))
    left_out = 0
    steps = step_unit(scene_in) * deck_steps
    do k = 1, size(steps)
      row = accuracy_row(arithmetic='real128', way=way_events)
      call run_row(row, scene_in, steps(k), 0.0_real64, allowance%left(), reference(k), timing, &
                   failure)
      if (allocated(failure)) return
      if (timing%passes() == 0) then
        failure = 'the reference, exact events in real128, takes longer than --seconds: ' // &
                  'expected more of them, or fewer positions'
        return
      end if
    end do
    do a = 1, size(arithmetic_names)
      do overlap = overlap_stable, overlap_original
        row = accuracy_row(arithmetic=arithmetic_names(a), way=way_events, overlap=overlap)
        call add_row(usual_step)
        if (allocated(failure)) return
        do k = 1, size(steps)
          row = accuracy_row(arithmetic=arithmetic_names(a), way=way_marching, step=steps(k), &
                             overlap=overlap)
          call add_row(k)
          if (allocated(failure)) return
        end do
      end do
      if (allocated(deck)) then
        row = accuracy_row(arithmetic=arithmetic_names(a), way=way_original, &
                           step=steps(usual_step), overlap=overlap_original)
        call run_original_row(row, deck, reference(usual_step), least_seconds, &
                              allowance%next(), failure)
        call progress%step()
        if (row%seconds < 0.0_real64) then
          left_out = left_out + 1
        else if (allocated(failure)) then
          ! The original goes astray on this deck: its row is left out, the study goes on.
          deallocate (failure)
        else
          rows = [rows, row]
        end if
      end if
    end do
    rows%ratio = rows%seconds / minval(rows%seconds)
    rows%on_front = on_front(rows%seconds, rows%worst)

  contains

    subroutine add_row(k)
      integer, intent(in) :: k

      call run_row(row, scene_in, steps(k), least_seconds, allowance%next(), results, timing, &
                   failure)
      if (allocated(failure)) return
      call progress%step()
      if (timing%passes() == 0) then
        left_out = left_out + 1
        return
      end if
      call measure(row, timing, results, reference(k))
      rows = [rows, row]
    end subroutine add_row

  end subroutine run_accuracy_study

  ! What the steps of a deck are times in the scene's unit of length: the power of ten that brings
  ! the largest radius near the thesis', so that the number of steps does not depend on the unit.
  pure real(real64) function step_unit(scene_in)
    type(scene), intent(in) :: scene_in
    real(real64), parameter :: thesis_radius = 1.27_real64

    step_unit = 1.0_real64
    if (scene_in%from_deck) return
    step_unit = 10.0_real64**nint(log10(max(maxval(scene_in%upper%radius), &
                                            maxval(scene_in%lower%radius)) / thesis_radius))
  end function step_unit

  !> Runs one row of the present-day kernel.
  subroutine run_row(row, scene_in, step, least_seconds, most_seconds, results, timing, failure)
    type(accuracy_row), intent(in) :: row
    type(scene), intent(in) :: scene_in
    real(real64), intent(in) :: step, least_seconds, most_seconds
    type(scene_results), intent(out) :: results
    type(timing_samples), intent(out) :: timing
    character(len=:), allocatable, intent(out) :: failure
    class(position_solver), allocatable :: solver
    type(solve_method) :: method

    method%path = merge(by_events, by_marching, row%way == way_events)
    method%overlap = row%overlap
    method%step = step
    call solver_in(trim(row%arithmetic), scene_in, method, solver, failure)
    if (.not. allocated(failure)) &
      call time_solver(solver, least_seconds, most_seconds, results%positions, timing, failure)
  end subroutine run_row

  !> Runs the original program as a row: timed without its contact rows, measured with them. It
  !> is not begun without time, and has a time below 0 then.
  subroutine run_original_row(row, deck, reference, least_seconds, most_seconds, failure)
    type(accuracy_row), intent(inout) :: row
    type(card_deck), intent(in) :: deck
    type(scene_results), intent(in) :: reference
    real(real64), intent(in) :: least_seconds, most_seconds
    character(len=:), allocatable, intent(out) :: failure
    type(original_request) :: request
    type(time_allowance) :: allowance
    type(original_records) :: records
    type(scene_results) :: results
    type(timing_samples) :: timing
    integer(int64) :: from, until, rate
    integer :: m

    request%approach_step = decimal_value(1_int64, step_powers(usual_step))
    call allowance%begin(most_seconds)
    if (allowance%left() < 0.0_real64) then
      row%seconds = -1.0_real64
      return
    end if
    do while (.not. timing%are_enough(least_seconds))
      if (allowance%left() < 0.0_real64 .and. timing%passes() > 0) exit
      call system_clock(from, rate)
      call run_in_arithmetic(row%arithmetic, deck, request, records, failure)
      call system_clock(until)
      if (allocated(failure)) return
      call timing%add(real(until - from, real64) / real(rate, real64), original_positions)
    end do
    request%keep_contacts = .true.
    call run_in_arithmetic(row%arithmetic, deck, request, records, failure)
    if (allocated(failure)) return
    allocate (results%positions(original_positions))
    do m = 1, original_positions
      associate (position => records%positions(m))
        allocate (results%positions(m)%states(1))
        results%positions(m)%states(1) = &
          state_row(load=position%load, area=position%area, approach=position%approach, &
                    contacts=position%contacts)
        results%positions(m)%first_step_pressure = first_pressure(m)
      end associate
    end do
    call measure(row, timing, results, reference)

  contains

    !> Pressure of the first contact one whole step past touch; -1 where the step was cut short by
    !> the next contact.
    real(real64) function first_pressure(m)
      integer, intent(in) :: m
      integer :: i

      first_pressure = -1.0_real64
      associate (first => records%positions(m)%first_contact, &
                 last => records%positions(m)%last_contact)
        do i = first, last
          if (records%contacts(i)%step /= 2) cycle
          if (abs(records%contacts(first)%approach - records%contacts(i)%approach - row%step) < &
              0.01_real64 * row%step) first_pressure = records%contacts(i)%average_pressure
          exit
        end do
      end associate
    end function first_pressure

  end subroutine run_original_row

  !> Median and spread of the time, and relative errors over all positions.
  pure subroutine measure(row, timing, results, reference)
    type(accuracy_row), intent(inout) :: row
    type(timing_samples), intent(in) :: timing
    type(scene_results), intent(in) :: results, reference
    real(real64) :: errors(5)
    type(state_row) :: have, want
    integer :: m, pressures

    row%seconds = timing%median()
    row%spread = timing%spread()
    pressures = 0
    do m = 1, size(reference%positions)
      have = last_state(results%positions(m))
      want = last_state(reference%positions(m))
      errors(load_error) = relative(have%load, want%load)
      errors(area_error) = relative(have%area, want%area)
      errors(approach_error) = relative(have%approach, want%approach)
      errors(count_error) = relative(real(have%contacts, real64), real(want%contacts, real64))
      errors(pressure_error) = 0.0_real64
      if (results%positions(m)%first_step_pressure >= 0.0_real64) then
        errors(pressure_error) = relative(results%positions(m)%first_step_pressure, &
                                          reference%positions(m)%first_step_pressure)
        pressures = pressures + 1
      end if
      row%largest = max(row%largest, errors)
      row%mean = row%mean + errors
    end do
    row%mean = row%mean / size(reference%positions)
    row%mean(pressure_error) = row%mean(pressure_error) * size(reference%positions) / &
                               max(1, pressures)
    row%worst = maxval(row%largest([load_error, area_error, pressure_error, approach_error]))
  end subroutine measure

  !> |have - want| over |want|; the difference itself where `want` is zero.
  elemental real(real64) function relative(have, want)
    real(real64), intent(in) :: have, want

    relative = abs(have - want)
    if (abs(want) > 0.0_real64) relative = relative / abs(want)
  end function relative

end module asperity_accuracy_study
