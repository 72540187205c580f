!> Choice of the method for a requested accuracy: settings before a run, errors after it.
!>
!> With `auto` effects are left out below their tolerance, and contacts are Hertzian where that is
!> accurate enough, else resolved on boundary elements. The accuracy sets the tolerance. Effects
!> that are off count with their estimated influence.
module asperity_accuracy_choice
  use asperity_constants, only: pi
  use asperity_contact_records, only: position_result, prescribed_nothing, prescribed_vertical, &
                                      state_row
  use asperity_effect_names, only: known_effects, of_interaction
  use asperity_kinds, only: not_computed, real64
  use asperity_numeral, only: rounded_decimal
  use asperity_problems, only: real_text
  use asperity_scene_results, only: last_state, scene_results
  use asperity_scene_values, only: combined_modulus, effect_auto, effect_boundary, effect_coupled, &
                                   effect_off, is_load, scene
  use asperity_theory_warnings, only: of_slope, warning_kinds
  implicit none
  private

  public :: run_errors, add_possible_accuracy, check_accuracy, check_left_out, choose_model, &
            error_bound, errors_of_run, first_tolerance, next_tolerance, report_method, &
            total_error

  ! Smallest relative error of an area by boundary elements that is relied on.
  ! With finer elements the estimates 1.9e-3 and 9.3e-4 in two scenes of steep pairs were less than
  ! the errors 2.1e-3 and 1.5e-3.
  real(real64), parameter :: element_error = 3.0e-3_real64
  ! Relative error of the solvers of effects: docs/reference/exit-status.md.
  real(real64), parameter :: effect_error = 1.0e-9_real64

  ! Safety factor of estimated errors of loads and areas: the error was at most 1.41 times the
  ! estimate in 83 runs of 59 dense scenes (test/support/promise_judge.py).
  real(real64), parameter :: safety_factor = 1.5_real64

  ! Safety factor of a new tolerance; a tolerance below this share of the accuracy is not reduced,
  ! as other errors prevail.
  real(real64), parameter :: tolerance_factor = 0.95_real64, least_share = 0.25_real64

  ! Smallest error bound: results are stored as doubles.
  real(real64), parameter :: finest_accuracy = 4 * epsilon(1.0_real64)

  ! Rounding errors of a position's coordinates and separations, in units of roundoff: placing (3),
  ! the difference in plan, its square and root, the separation and the gap, each at most 1.
  real(real64), parameter :: roundings = 12.0_real64

  ! A proposed accuracy is rounded to two digits, by less than 5 %.
  real(real64), parameter :: possible_share = 0.95_real64

  !> Estimated relative errors of a run.
  type :: run_errors
    real(real64) :: model = 0.0_real64       !! load or separation, by omitted effects and methods
    real(real64) :: area = 0.0_real64        !! real area, by omitted effects and methods
    real(real64) :: pressure = 1.0_real64    !! greatest pressure; 1: unknown
    real(real64) :: arithmetic = 0.0_real64  !! all totals, by rounding
    real(real64) :: load = 0.0_real64        !! difference to a requested load
  end type run_errors

contains

  !> Sets the effects of a scene for a tolerance. Without boundary elements all contacts are
  !> Hertzian, and their error is estimated. A map is solved on its pixels: this takes no longer
  !> than the comparison of its summits with them.
  subroutine choose_model(scene_in, tolerance, total, on_cells, chosen)
    type(scene), intent(in) :: scene_in       !! scene, checked, with effects
    real(real64), intent(in) :: tolerance     !! relative error of the totals
    character(len=*), intent(in) :: total     !! which: one of `totals_of_accuracy`
    logical, intent(in) :: on_cells           !! boundary elements where Hertz is inaccurate
    type(scene), intent(out) :: chosen        !! scene to be solved
    integer :: mode

    chosen = scene_in
    mode = chosen%effects%modes(of_interaction)
    if (mode /= effect_off) then
      mode = effect_auto
      if (allocated(scene_in%map)) then
        if (count(scene_in%effects%modes /= effect_off) == 1) mode = effect_boundary
      else if (.not. on_cells) then
        mode = effect_coupled
      end if
    end if
    chosen%effects%modes(of_interaction) = mode
    call chosen%effects%set('tolerance', rounded_decimal(tolerance, 3))
    if (total /= 'load') &
      call chosen%effects%set('area_tolerance', rounded_decimal(tolerance, 3))
    if (tolerance < chosen%effects%number('boundary_tolerance')) &
      call chosen%effects%set('boundary_tolerance', rounded_decimal(tolerance, 3))
  end subroutine choose_model

  !> Reports the error of a scene without effects; `failure` is allocated where it exceeds the
  !> accuracy.
  subroutine check_accuracy(scene_in, accuracy, results, failure)
    type(scene), intent(in) :: scene_in                    !! scene that was solved
    real(real64), intent(in) :: accuracy                   !! requested relative error
    type(scene_results), intent(inout) :: results          !! results; get error and text
    character(len=:), allocatable, intent(out) :: failure  !! reason and the accuracy possible
    integer :: e

    call check_left_out(scene_in, accuracy, results, failure)
    if (allocated(failure)) return
    results%error_bound = error_bound(scene_in, results%positions) + sum([( &
      max(0.0_real64, maxval(results%positions%left_out(e))), e=1, size(known_effects))])
    results%way_taken = 'real64, exact events'
    results%way_told = 'ten times better: reached by this run'
    if (results%error_bound > 0.1_real64 * accuracy) &
      results%way_told = 'ten times better: not possible'
    if (results%error_bound <= accuracy) return
    failure = 'no method has this accuracy; the most accurate one, real64, has an error of ' // &
              real_text(results%error_bound, 'es7.1')
    call add_proposal(results%error_bound, 'all', failure)
  end subroutine check_accuracy

  !> Checks that no effect that is off has an estimated influence on the load above the accuracy;
  !> `failure` names the one with the largest.
  subroutine check_left_out(scene_in, accuracy, results, failure)
    type(scene), intent(in) :: scene_in                    !! scene that was solved
    real(real64), intent(in) :: accuracy                   !! requested relative error
    type(scene_results), intent(in) :: results             !! results with positions
    character(len=:), allocatable, intent(out) :: failure  !! effect to be turned on
    real(real64) :: share(size(known_effects))
    character(len=:), allocatable :: name
    integer :: e

    share = [(maxval(results%positions%left_out(e)), e=1, size(share))]
    e = maxloc(share, 1)
    if (.not. share(e) > accuracy) return
    name = trim(known_effects(e)%name)
    failure = name // ' is off, and its estimated influence on the load, ' // &
              real_text(share(e)) // ', is above the accuracy: '
    if (scene_in%effects%is_barred(name)) then
      failure = failure // 'it cannot be combined with the other effects of the scene'
    else
      failure = failure // 'set ' // name // ' = ''auto'' in &effects of a scene'
    end if
  end subroutine check_left_out

  !> Bound of the relative error of every total of the last state: load, vertical load, area,
  !> separation.
  !>
  !> Rounded heights e_z and plan coordinates e_d move an overlap by e_z + e_d sin(theta) and the
  !> separation of first touch by e_z + e_d tan(theta), tan(theta) the slope of the contact. The
  !> stiffness of N contacts of Hertz of total area A is 2 E sum(a) <= 2 E sqrt(N A/pi), and an area
  !> grows by pi R per overlap. The slope of every contact is below the limit of its warning, or
  !> that of the warning.
  real(real64) function error_bound(scene_in, positions) result(bound)
    type(scene), intent(in) :: scene_in                !! scene that was solved
    type(position_result), intent(in) :: positions(:)  !! results of all positions
    real(real64) :: roundoff, in_plan, in_height, tilt, least, widest, distance, slope, of_overlap
    real(real64) :: of_touch, per_overlap, modulus
    type(state_row) :: last
    integer :: m

    bound = finest_accuracy
    ! A map has no asperities to be rounded.
    if (allocated(scene_in%map)) return
    roundoff = 0.5_real64 * epsilon(1.0_real64)
    modulus = combined_modulus(scene_in)
    associate (upper => scene_in%upper, lower => scene_in%lower, motion => scene_in%motion)
      least = min(minval(upper%radius), minval(lower%radius))
      ! The effective radius of a pair is at most the smaller radius.
      widest = min(maxval(upper%radius), maxval(lower%radius))
      tilt = max(norm2(upper%slope), norm2(lower%slope))
      in_plan = max(maxval(abs(upper%x)), maxval(abs(upper%y)), maxval(abs(lower%x)), &
                    maxval(abs(lower%y)), abs(scene_in%lower_mirror_width), &
                    maxval(abs([motion%x_first, motion%y_first])) + (motion%positions - 1) * &
                    maxval(abs([motion%x_step, motion%y_step])))
      in_height = max(maxval(abs(upper%height)), maxval(abs(lower%height))) + 2 * tilt * in_plan
    end associate
    ! The distance of the summits of a pair in plan is less than the sum of their radii, and less
    ! than twice the largest coordinate along x and along y.
    distance = min(maxval(scene_in%upper%radius) + maxval(scene_in%lower%radius), 3 * in_plan)
    do m = 1, size(positions)
      last = last_state(positions(m))
      if (.not. (last%compression > 0.0_real64 .and. last%load > 0.0_real64)) cycle
      ! The offset in plan of a contact reduces its height by less than the summits exceed.
      slope = min(warning_kinds(of_slope)%limit, &
                  sqrt(4 * max(2 * in_height - last%approach, last%compression) / least))
      if (allocated(positions(m)%warnings)) &
        slope = max(slope, maxval(positions(m)%warnings%magnitude, &
                                  positions(m)%warnings%number == of_slope))
      of_overlap = roundings * roundoff * (in_height + min(slope, 1.0_real64) * &
                                           (in_plan + distance))
      of_touch = roundings * roundoff * (in_height + slope * (in_plan + distance))
      per_overlap = max(2 * modulus * sqrt(last%contacts / pi) * sqrt(last%area) / last%load, &
                        pi * last%contacts * widest / last%area)
      ! Under a load the error of the overlaps is added to the separation.
      if (is_load(scene_in%loading%control)) per_overlap = 2 * per_overlap
      bound = max(bound, finest_accuracy + of_overlap * per_overlap + of_touch * &
                         max(1.0_real64 / last%compression, 2 * hypot(1.0_real64, slope) / least))
      if (abs(last%approach) > 0.0_real64) &
        bound = max(bound, of_touch / abs(last%approach) + finest_accuracy)
    end do
  end function error_bound

  !> Estimated errors of a run. That of a path is at least its tolerance, as estimates are those of
  !> its last state.
  type(run_errors) function errors_of_run(scene_in, on_elements, results) result(errors)
    type(scene), intent(in) :: scene_in         !! scene that was solved
    logical, intent(in) :: on_elements          !! boundary elements where Hertz is inaccurate
    type(scene_results), intent(in) :: results  !! results of the scene
    integer :: i, m

    if (on_elements) errors%area = element_error
    errors%arithmetic = error_bound(scene_in, results%positions)
    do m = 1, size(results%positions)
      associate (position => results%positions(m))
        errors%model = max(errors%model, safety_factor * max(0.0_real64, position%error_estimate))
        ! An unknown error by the pixels of a map counts as 1.
        if (allocated(scene_in%map) .and. .not. position%error_estimate > not_computed) &
          errors%model = 1.0_real64
        do i = 1, size(position%states)
          associate (state => position%states(i))
            ! Relative difference of the load to the requested one.
            if (state%prescribed /= prescribed_nothing .and. &
                abs(state%prescribed_load) > 0.0_real64) errors%load = max(errors%load, &
              abs(merge(state%vertical_load, state%load, state%prescribed == prescribed_vertical) &
                  / state%prescribed_load - 1.0_real64))
          end associate
        end do
        if (allocated(position%effects)) then
          if (any(position%effects%simulated /= 'off')) &
            errors%arithmetic = max(errors%arithmetic, effect_error)
        end if
      end associate
    end do
    if (allocated(scene_in%loading%path) .and. &
        any(scene_in%effects%modes == effect_auto)) &
      errors%model = max(errors%model, scene_in%effects%number('tolerance'))
    if (.not. allocated(results%effects)) return
    errors%area = max(errors%area, largest_estimate('area_error_estimate'))
    if (largest_estimate('pressure_error_estimate') > 0.0_real64) &
      errors%pressure = largest_estimate('pressure_error_estimate')

  contains

    ! Largest estimate of a column over the positions, with the safety factor; 0: there is none.
    pure real(real64) function largest_estimate(name) result(largest)
      character(len=*), intent(in) :: name
      integer :: column, m

      largest = 0.0_real64
      column = findloc(results%effects%state_columns == name, .true., 1)
      do m = 1, merge(size(results%positions), 0, column > 0)
        if (.not. allocated(results%positions(m)%state_values)) cycle
        if (size(results%positions(m)%state_values) >= column) &
          largest = max(largest, results%positions(m)%state_values(column))
      end do
      largest = safety_factor * largest
    end function largest_estimate

  end function errors_of_run

  !> Total error of loads and separation, of the area, or the larger one.
  pure real(real64) function total_error(errors, total)
    type(run_errors), intent(in) :: errors   !! errors of a run
    character(len=*), intent(in) :: total    !! of which, as `totals_of_accuracy`

    total_error = model_error(errors, total) + errors%arithmetic + errors%load
  end function total_error

  ! Error by omitted effects and methods.
  pure real(real64) function model_error(errors, total)
    type(run_errors), intent(in) :: errors
    character(len=*), intent(in) :: total

    select case (total)
    case ('load')
      model_error = errors%model
    case ('area')
      model_error = errors%area
    case ('pressure')
      model_error = errors%pressure
    case default
      model_error = max(errors%model, errors%area)
    end select
  end function model_error

  !> First tolerance of boundary elements: their error estimate is about as large.
  pure real(real64) function first_tolerance(accuracy, total) result(first)
    real(real64), intent(in) :: accuracy        !! requested relative error
    character(len=*), intent(in) :: total       !! of which, as `totals_of_accuracy`

    first = accuracy
    if (total /= 'load') first = max(first, element_error)
    first = first / safety_factor
  end function first_tolerance

  !> Next tolerance of boundary elements after one whose error estimate exceeded the accuracy; the
  !> estimate is assumed proportional to the tolerance. 0: a smaller tolerance is of no use.
  pure real(real64) function next_tolerance(errors, accuracy, total, tolerance) result(next)
    type(run_errors), intent(in) :: errors      !! errors with the last tolerance
    real(real64), intent(in) :: accuracy        !! requested relative error
    character(len=*), intent(in) :: total       !! of which, as `totals_of_accuracy`
    real(real64), intent(in) :: tolerance       !! tolerance of the last run
    real(real64) :: left

    left = accuracy - errors%arithmetic - errors%load
    next = tolerance_factor * tolerance * left / model_error(errors, total)
    if (.not. (next > 0.0_real64 .and. tolerance > least_share * accuracy)) next = 0.0_real64
    if (total /= 'load' .and. left < element_error) next = 0.0_real64
  end function next_tolerance

  !> Reports the chosen method, and the cost of an error smaller by a factor of ten.
  subroutine report_method(scene_in, accuracy, results)
    type(scene), intent(in) :: scene_in             !! scene that was solved
    real(real64), intent(in) :: accuracy            !! requested relative error
    type(scene_results), intent(inout) :: results   !! results with the error bound; get the text
    integer :: mode

    mode = scene_in%effects%modes(of_interaction)
    results%way_taken = 'real64, effects as in the scene'
    if (any(scene_in%effects%modes == effect_auto)) results%way_taken = &
      'real64, ''auto'' with tolerance ' // real_text(scene_in%effects%number('tolerance'))
    if (mode == effect_coupled) results%way_taken = results%way_taken // ', Hertzian ' // &
        'contacts in the field of the others'
    if (mode == effect_boundary) results%way_taken = 'real64, pixels of the map'
    results%way_told = 'ten times better: '
    if (results%error_bound <= 0.1_real64 * accuracy) then
      results%way_told = results%way_told // 'reached by this run'
    else if (mode == effect_boundary) then
      results%way_told = results%way_told // 'by a map of finer pixels'
    else if (0.1_real64 * accuracy < effect_error) then
      results%way_told = results%way_told // 'not possible, effects are computed to ' // &
                         real_text(effect_error)
    else if (mode == effect_off) then
      results%way_told = results%way_told // 'by a smaller tolerance, in nearly the same run time'
    else if (0.1_real64 * accuracy >= element_error) then
      results%way_told = results%way_told // 'by boundary elements, in up to ten times the run time'
    else
      results%way_told = results%way_told // 'possible where Hertzian contacts suffice; areas ' // &
                         'of boundary elements have a relative error of ' // &
                             real_text(element_error)
    end if
  end subroutine report_method

  !> Adds the errors of the most accurate run and an option that is met.
  subroutine add_possible_accuracy(errors, on_pixels, accuracy, total, text)
    type(run_errors), intent(in) :: errors     !! errors of the run
    logical, intent(in) :: on_pixels           !! whether the pixels of a map are solved
    real(real64), intent(in) :: accuracy       !! requested relative error
    character(len=*), intent(in) :: total      !! of which, as `totals_of_accuracy`
    character(len=:), allocatable, intent(inout) :: text  !! begin of the sentence
    integer :: first  ! length of the sentence without advice

    text = text // &
           trim(merge('the pixels of the map have', 'the most accurate one has ', on_pixels)) // &
           ' an estimated error of loads and separations of ' // &
           real_text(total_error(errors, 'load'))
    if (errors%area > 0.0_real64) &
      text = text // ', of areas of ' // real_text(total_error(errors, 'area'))
    if (total == 'pressure') text = text // ', of the greatest pressure of ' // &
                                    real_text(total_error(errors, 'pressure'))
    first = len(text)
    call add_proposal(total_error(errors, total), total, text)
    if (len(text) == first .and. total == 'all') &
      call add_proposal(total_error(errors, 'load'), 'load', text)
    if (on_pixels) call add_advice('take a map of finer pixels')
    if (total == 'all' .and. total_error(errors, 'load') <= accuracy) &
      call add_advice('for --of load where areas do not matter')

  contains

    ! Adds an advice, the first one behind a colon.
    subroutine add_advice(advice)
      character(len=*), intent(in) :: advice

      if (len(text) == first) text = text // ': ' // advice
      if (index(text, advice) == 0) text = text // ', or ' // advice
    end subroutine add_advice

  end subroutine add_possible_accuracy

  ! Adds the option for an error, where one is possible.
  pure subroutine add_proposal(error, total, text)
    real(real64), intent(in) :: error        ! relative error that a run had
    character(len=*), intent(in) :: total    ! of which, as `totals_of_accuracy`
    character(len=:), allocatable, intent(inout) :: text  ! begin of the sentence

    if (.not. error < possible_share) return
    text = text // ': set --accuracy ' // real_text(error / possible_share, 'es7.1')
    if (total /= 'all') text = text // ' --of ' // trim(total)
  end subroutine add_proposal

end module asperity_accuracy_choice
