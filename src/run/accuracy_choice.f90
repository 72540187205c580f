!> Choice of the method for a requested accuracy: settings before a run, errors after it.
!>
!> The errors are those that a run prints. Methods are tried from the fastest on: on a map every
!> fourth and second pixel and its pixels, or others of its waves where it is known between them; on
!> asperities Hertzian contacts, then boundary elements where Hertz is inaccurate, by `auto`, whose
!> tolerance follows from the error of the last run. Effects that are off count with their estimated
!> influence.
module asperity_accuracy_choice
  use asperity_constants, only: pi
  use asperity_contact_field, only: fields_none
  use asperity_contact_records, only: position_result, prescribed_nothing, prescribed_vertical, &
                                      state_row
  use asperity_effect_names, only: effect_words, known_effects, of_interaction
  use asperity_kinds, only: not_computed, real64
  use asperity_map_scene, only: change_resolution, finest_resolution
  use asperity_numeral, only: rounded_decimal
  use asperity_problems, only: decimal_text, real_text
  use asperity_run_options, only: run_options, totals_of_accuracy
  use asperity_scene_results, only: last_state, scene_results
  use asperity_scene_values, only: combined_modulus, effect_auto, effect_boundary, effect_coupled, &
                                   effect_off, is_load, scene
  use asperity_theory_warnings, only: of_error, of_slope, warning_kinds
  implicit none
  private

  public :: check_accuracy, check_left_out, choose_model, compare_pixels, errors_of_run, &
            first_method, method_choice, proposed_accuracy, report_errors, report_method, &
            take_next, typed_number

  ! Relative error of the solvers of effects: docs/reference/exit-status.md.
  real(real64), parameter :: effect_error = 1.0e-9_real64

  ! The first tolerance of boundary elements over the accuracy of loads, whose error is often far
  ! less than the tolerance; the largest reduction of a tolerance, as a run takes six times as long
  ! then, and the part of the accuracy below which it is not reduced; the part of the accuracy that
  ! is aimed at (chosen; test: times in test/bench/accuracy_promises.py). Elements of a smaller
  ! tolerance than the finest one exceed the memory; areas on elements have a larger error than
  ! theirs (extrapolation_error of asperity_joint_contacts).
  real(real64), parameter :: first_share = 10.0_real64, largest_step = 0.1_real64, &
                             least_share = 0.25_real64, aimed_share = 0.95_real64, &
                             finest_tolerance = 1.0e-6_real64, finest_areas = 1.0e-3_real64

  ! Pixels along a side over those of a map: the coarsest ones, and the range for those after every
  ! second pixel of a map that is known between its pixels, which has no waves below 3 pixels.
  real(real64), parameter :: unknown = 0.0_real64, coarsest = 0.25_real64, &
                             around_whole(2) = [0.75_real64, 1.5_real64]
  ! Order of errors by the size of pixels: of loads on smooth maps, of other totals (map_error), of
  ! first contact, and the largest from every fourth to every second pixel (chosen; test: times in
  ! test/bench/accuracy_promises.py).
  real(real64), parameter :: order_of_load = 2.5_real64, order_of_others = 1.5_real64, &
                             order_of_top = 5.0_real64, steepest_order = 8.0_real64
  ! Least error of n pixels along a side is (fewest/n)**order_of_load (measured: balls of
  ! test/bench/accuracy_promises.py, the surfaces with the least errors; test: their times there).
  real(real64), parameter :: fewest = 3.0_real64
  ! Pixels above those that the order asks for (chosen: 1/8 of the error), and the least step.
  real(real64), parameter :: spare = 1.05_real64, least_step = 1.2_real64

  ! Smallest error bound: results are stored as doubles.
  real(real64), parameter :: finest_accuracy = 4 * epsilon(1.0_real64)

  ! Rounding errors of a position's coordinates and separations, in units of roundoff: placing (3),
  ! the difference in plan, its square and root, the separation and the gap, each at most 1.
  real(real64), parameter :: roundings = 12.0_real64

  ! A proposed accuracy is rounded to two digits, by less than 5 %.
  real(real64), parameter :: possible_share = 0.95_real64

  ! Words of `totals_of_accuracy` in messages.
  character(len=*), parameter :: quantities(4) = [character(len=21) :: &
    'loads and separations', 'areas', 'the greatest pressure', '']

  !> A method: what is changed in a scene.
  type :: method_choice
    real(real64) :: tolerance = 0.0_real64   !! relative error of the totals, by effects left out
    logical :: on_elements = .false.         !! boundary elements where Hertz is inaccurate
    !> Tolerance and error of the last run on elements; 0: there is none.
    real(real64) :: last(2) = 0.0_real64
    real(real64) :: resolution = 1.0_real64  !! pixels along a side over those of the map
    real(real64) :: finest = 1.0_real64      !! largest of these; `unknown`
    !> Total, its error and pixels along a side of the last run on pixels; 0: there is none.
    real(real64) :: before(3) = 0.0_real64
  end type method_choice

contains

  !> The fastest method. Other pixels are methods of a map at one position, without fields.
  pure type(method_choice) function first_method(scene_in, options) result(method)
    type(scene), intent(in) :: scene_in        !! scene, checked, with effects or a map
    type(run_options), intent(in) :: options   !! requested accuracy and fields
    integer :: pixels  ! along the shorter side

    ! Half of the accuracy is for other errors than those of effects left out.
    method%tolerance = 0.5_real64 * options%accuracy
    if (allocated(scene_in%map) .and. scene_in%motion%positions == 1 .and. &
        options%fields == fields_none) then
      method%finest = unknown
      associate (lower => scene_in%map%lower, upper => scene_in%map%upper)
        pixels = max(min(lower%columns, lower%rows), min(upper%columns, upper%rows))
      end associate
      method%resolution = coarsest
      do while (method%resolution < 1.0_real64 .and. (fewest / (method%resolution * pixels))** &
                order_of_load > options%accuracy)
        method%resolution = 2 * method%resolution
      end do
    end if
  end function first_method

  !> The next method after one whose error is above the accuracy; its tolerance is 0 where there is
  !> none.
  subroutine take_next(scene_in, options, results, error, method)
    type(scene), intent(in) :: scene_in           !! scene, checked, with effects or a map
    type(run_options), intent(in) :: options      !! requested accuracy and its total
    type(scene_results), intent(in) :: results    !! results with the method, if there are any
    real(real64), intent(in) :: error             !! relative error with the method
    type(method_choice), intent(inout) :: method  !! last method, then the next one
    real(real64) :: last(2), needed

    last = method%last
    associate (goal => options%accuracy)
      ! A part of the error does not depend on the tolerance.
      needed = method%tolerance * (aimed_share * goal / error)**2
      if (allocated(scene_in%map)) then
        if (method%finest < 1.0_real64 .and. .not. 2 * method%resolution < 1.0_real64) &
          method%finest = finest_resolution(scene_in)
        call take_pixels(goal, error, options%accuracy_of, results, method)
      else if (scene_in%effects%modes(of_interaction) == effect_off) then
        method%tolerance = 0.0_real64
      else if (.not. method%on_elements) then
        method%on_elements = .true.
        method%tolerance = min(aimed_share * error, max(largest_step * error, goal * merge( &
                               first_share, 1.0_real64, options%accuracy_of == 'load')))
      else if (.not. method%tolerance > least_share * goal .or. needed < finest_tolerance .or. &
               (method%tolerance < 0.3_real64 * last(1) .and. error > 0.7_real64 * last(2))) then
        ! Other errors prevail.
        method%tolerance = 0.0_real64
      else
        method%last = [method%tolerance, error]
        method%tolerance = max(largest_step * method%tolerance, needed)
      end if
    end associate
  end subroutine take_next

  !> Replaces an error of pixels that is within the accuracy by that of two grids (Roache, J. Fluids
  !> Eng. 116 (1994) 405), where the latter is not, and the load, or the compression under a load,
  !> has changed from the pixels before by more than their error: they did not resolve the map.
  !> The pixels of the map keep the error that a solve of the scene prints.
  pure subroutine compare_pixels(scene_in, results, goal, method, error)
    type(scene), intent(in) :: scene_in            !! scene with a map that was solved
    type(scene_results), intent(in) :: results     !! results of these pixels
    real(real64), intent(in) :: goal               !! accuracy of the load
    type(method_choice), intent(inout) :: method   !! method that was used; gets these results
    real(real64), intent(inout) :: error           !! estimated error of the load
    real(real64), parameter :: safety = 3.0_real64
    real(real64) :: change, of_grids, total
    type(state_row) :: last

    last = last_state(results%positions(1))
    total = merge(last%compression, last%load, is_load(scene_in%loading%control))
    change = abs(total - method%before(1))
    if (method%before(2) > 0.0_real64 .and. change > method%before(2) * abs(total)) then
      of_grids = safety * change / abs(total) / &
                 ((method%resolution / method%before(3))**order_of_load - 1.0_real64)
      if (of_grids > goal .and. abs(method%resolution - 1.0_real64) > 0.0_real64) &
        error = max(error, of_grids)
    end if
    method%before = [total, error, method%resolution]
  end subroutine compare_pixels

  ! The next pixels of a map: every fourth, every second, all; where it is known between them as
  ! many as its errors by the separation and by first contact take.
  pure subroutine take_pixels(goal, error, total, results, method)
    real(real64), intent(in) :: goal              ! accuracy
    real(real64), intent(in) :: error             ! error; `huge`: they could not be solved
    character(len=*), intent(in) :: total         ! of which, as `totals_of_accuracy`
    type(scene_results), intent(in) :: results    ! results with these pixels
    type(method_choice), intent(inout) :: method  ! its tolerance is 0 where there are none
    type(state_row) :: last
    real(real64) :: level, next, order, top

    associate (now => method%resolution, is_solved => error < huge(error))
      next = 2 * now
      if (is_solved .and. method%finest > 1.0_real64 .and. .not. next < 1.0_real64) then
        order = merge(order_of_load, order_of_others, total == 'load')
        last = last_state(results%positions(1))
        level = error
        if (total == 'load' .and. last%separation_error > 0.0_real64) &
          level = min(error, last%separation_error)
        top = sqrt((error - level) * (error + level))
        next = spare * now * max((level / goal)**(1.0_real64 / order), &
                                 (top / goal)**(1.0_real64 / order_of_top))
        next = min(max(next, around_whole(1), least_step * now), &
                   merge(around_whole(2), method%finest, now < around_whole(1)))
      else if (is_solved .and. error > goal * 2.0_real64**steepest_order) then
        next = max(next, 1.0_real64)
      end if
      if (.not. (now < around_whole(1) .or. (is_solved .and. now < method%finest))) &
        method%tolerance = 0.0_real64
    end associate
    method%resolution = next
  end subroutine take_pixels

  !> Sets the effects of a scene, or its pixels, for a method. Without boundary elements all
  !> contacts are Hertzian, and their error is estimated.
  subroutine choose_model(scene_in, method, total, chosen, failure)
    type(scene), intent(in) :: scene_in          !! scene, checked, with effects or a map
    type(method_choice), intent(in) :: method    !! tolerance, elements and pixels
    character(len=*), intent(in) :: total        !! which: one of `totals_of_accuracy`
    type(scene), intent(out) :: chosen           !! scene to be solved
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is impossible
    real(real64) :: tolerance
    integer :: mode

    chosen = scene_in
    mode = chosen%effects%modes(of_interaction)
    if (mode /= effect_off) then
      mode = effect_auto
      if (allocated(scene_in%map)) then
        if (count(scene_in%effects%modes /= effect_off) == 1) mode = effect_boundary
      else if (.not. method%on_elements) then
        mode = effect_coupled
      end if
    end if
    chosen%effects%modes(of_interaction) = mode
    tolerance = rounded_decimal(method%tolerance, 3)
    call chosen%effects%set('tolerance', tolerance)
    if (total /= 'load') call chosen%effects%set('area_tolerance', max(tolerance, finest_areas))
    if (tolerance < chosen%effects%number('boundary_tolerance')) &
      call chosen%effects%set('boundary_tolerance', tolerance)
    if (abs(method%resolution - 1.0_real64) > 0.0_real64) &
      call change_resolution(chosen, method%resolution, failure)
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
    if (results%error_bound <= accuracy) return
    failure = 'no method has this accuracy; the most accurate one, real64, has an error of ' // &
              real_text(results%error_bound, 'es7.1')
    call add_proposal(proposed_accuracy(results%error_bound), 'load', failure)
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

  !> Estimated relative errors of a run, by `totals_of_accuracy`: the largest printed estimates of
  !> its positions, with rounding and the difference to a requested load. Unknown errors are 1. That
  !> of a path is at least its tolerance, as estimates are those of its last state.
  function errors_of_run(scene_in, results) result(errors)
    type(scene), intent(in) :: scene_in              !! scene that was solved
    type(scene_results), intent(in) :: results       !! results of the scene
    real(real64) :: errors(size(totals_of_accuracy))
    real(real64) :: area, load, others, pressure
    integer :: i, m

    load = 0.0_real64
    others = 0.0_real64
    do m = 1, size(results%positions)
      associate (position => results%positions(m))
        load = max(load, position%error_estimate)
        if (allocated(scene_in%map) .and. .not. position%error_estimate > not_computed) &
          load = 1.0_real64
        do i = 1, size(position%states)
          associate (state => position%states(i))
            ! Relative difference of the load to the requested one.
            if (state%prescribed /= prescribed_nothing .and. &
                abs(state%prescribed_load) > 0.0_real64) others = max(others, &
              abs(merge(state%vertical_load, state%load, state%prescribed == prescribed_vertical) &
                  / state%prescribed_load - 1.0_real64))
          end associate
        end do
        if (.not. allocated(position%effects)) cycle
        if (any(position%effects%simulated /= 'off')) others = max(others, effect_error)
      end associate
    end do
    if (allocated(scene_in%loading%path) .and. any(scene_in%effects%modes == effect_auto)) &
      load = max(load, scene_in%effects%number('tolerance'))
    ! Effects left out change an area as much as a load.
    area = merge(1.0_real64, load, allocated(scene_in%map))
    pressure = 1.0_real64
    call take_largest('area_error_estimate', area)
    call take_largest('pressure_error_estimate', pressure)
    errors = [load, area, pressure, max(load, area)] + others + &
             error_bound(scene_in, results%positions)

  contains

    ! Largest estimate of a column over the positions, where there is one.
    pure subroutine take_largest(name, error)
      character(len=*), intent(in) :: name
      real(real64), intent(inout) :: error
      real(real64) :: largest
      integer :: column, m

      if (.not. allocated(results%effects)) return
      largest = not_computed
      column = findloc(results%effects%state_columns == name, .true., 1)
      do m = 1, merge(size(results%positions), 0, column > 0)
        if (.not. allocated(results%positions(m)%state_values)) cycle
        if (size(results%positions(m)%state_values) >= column) &
          largest = max(largest, results%positions(m)%state_values(column))
      end do
      if (largest > not_computed) error = largest
    end subroutine take_largest

  end function errors_of_run

  !> Sets the words of the chosen method: what a scene has for it. Its own tolerance is no limit of
  !> the error.
  subroutine report_method(scene_in, method, results)
    type(scene), intent(in) :: scene_in             !! scene that was solved
    type(method_choice), intent(in) :: method       !! method that was chosen
    type(scene_results), intent(inout) :: results   !! results with the error bound; get the text
    integer :: m

    do m = 1, size(results%positions)
      associate (position => results%positions(m))
        if (allocated(position%warnings)) position%warnings = pack( &
          position%warnings, position%warnings%number /= of_error .or. &
          position%warnings%magnitude > results%error_bound)
      end associate
    end do

    associate (effects => scene_in%effects, mode => scene_in%effects%modes(of_interaction))
      if (allocated(scene_in%map)) then
        results%way_taken = 'the pixels of the map'
        if (method%resolution < 1.0_real64) results%way_taken = 'every ' // &
          trim(merge('second', 'fourth', method%resolution > coarsest)) // ' pixel of the map'
        if (method%resolution >= around_whole(1) .and. method%finest > 1.0_real64) &
          results%way_taken = decimal_text(scene_in%map%lower%columns) // ' x ' // &
                              decimal_text(scene_in%map%lower%rows) // ' pixels'
      else if (mode == effect_off) then
        results%way_taken = 'the effects of the scene'
      else
        results%way_taken = 'interaction = ''' // trim(effect_words(mode)) // ''''
      end if
      if (any(effects%modes == effect_auto)) results%way_taken = results%way_taken // &
        ', tolerance = ' // trim(typed_number(effects%number('tolerance')))
    end associate
  end subroutine report_method

  !> A number of a scene, of three digits.
  pure function typed_number(value) result(text)
    real(real64), intent(in) :: value  !! 0 or more
    character(len=8) :: text           !! as 0.001 or 2.37E-05

    text = real_text(value, 'f6.4')
    text(verify(trim(text), '0', back=.true.) + 1:) = ''
    if (abs(1.0e4_real64 * value - nint(1.0e4_real64 * value)) > 1.0e-6_real64) &
      text = real_text(value, 'es8.2')
  end function typed_number

  !> Adds the errors of the most accurate run and an option that is met.
  subroutine report_errors(errors, on_pixels, accuracy, total, proposal, text)
    real(real64), intent(in) :: errors(:)      !! errors of the run, by `totals_of_accuracy`
    logical, intent(in) :: on_pixels           !! whether the pixels of a map are solved
    real(real64), intent(in) :: accuracy       !! requested relative error
    character(len=*), intent(in) :: total      !! of which, as `totals_of_accuracy`
    real(real64), intent(in) :: proposal       !! accuracy that is met; 1 or more: there is none
    character(len=:), allocatable, intent(inout) :: text  !! begin of the sentence
    integer :: k

    text = text // trim(merge('the pixels of the map have', 'the most accurate run has ', &
                              on_pixels)) // ' an estimated error of '
    k = findloc(totals_of_accuracy == total, .true., 1)
    if (total == 'all') then
      text = text // trim(quantities(1)) // ' of ' // real_text(errors(1), 'es7.1') // ', of ' // &
             trim(quantities(2)) // ' of ' // real_text(errors(2), 'es7.1')
    else
      text = text // trim(quantities(k)) // ' of ' // real_text(errors(k), 'es7.1')
    end if
    call add_proposal(proposal, total, text)
    if (on_pixels) text = text // ', or take a map of finer pixels'
    if (total == 'all' .and. errors(1) <= accuracy) &
      text = text // ', or take --of load where areas do not matter'
  end subroutine report_errors

  !> An accuracy of two digits that an error is within; 1: there is none.
  pure real(real64) function proposed_accuracy(error) result(accuracy)
    real(real64), intent(in) :: error  !! relative error that a run had
    character(len=7) :: text

    accuracy = 1.0_real64
    if (.not. error < possible_share) return
    text = real_text(error / possible_share, 'es7.1')
    read (text, *) accuracy
  end function proposed_accuracy

  ! Adds the option for an accuracy, where there is one.
  pure subroutine add_proposal(accuracy, total, text)
    real(real64), intent(in) :: accuracy     ! 1 or more: there is none
    character(len=*), intent(in) :: total    ! of which, as `totals_of_accuracy`
    character(len=:), allocatable, intent(inout) :: text  ! begin of the sentence

    if (.not. accuracy < 1.0_real64) return
    text = text // ': set --accuracy ' // real_text(accuracy, 'es7.1')
    if (total /= 'load') text = text // ' --of ' // trim(total)
  end subroutine add_proposal

end module asperity_accuracy_choice
