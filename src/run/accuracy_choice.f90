!> Which way of taking effects has an accuracy asked for: what is chosen beforehand, what the run
!> had afterwards, what could be had.
!>
!> `auto` is the choice itself: it leaves out what it estimates below its tolerance, takes contacts
!> as circles where they are good enough, and on cells what is not. An accuracy sets its tolerance.
!> Effects that are off count with their estimated influence.
module asperity_accuracy_choice
  use asperity_accuracy_bound, only: error_bound
  use asperity_contact_records, only: asked_nothing, asked_vertical, state_row
  use asperity_decimal, only: decimal_to_real64
  use asperity_effect_names, only: known_effects
  use asperity_kinds, only: not_computed, real64
  use asperity_numeral, only: rounded_decimal
  use asperity_problems, only: real_text
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: effect_auto, effect_boundary, effect_coupled, &
                                   effect_off, scene
  implicit none
  private

  public :: accuracy_had, check_left_out, choose_model, first_tolerance, had_text, has_accuracy, &
            influence_left_out, may_go_on_cells, next_tolerance, tell_way, total_of, with_circles

  ! Smallest relative error for which boundary elements are chosen: areas are not more accurate.
  ! With finer elements the estimates 1.9e-3 and 9.3e-4 in two scenes of steep pairs were less than
  ! the errors 2.1e-3 and 1.5e-3.
  real(real64), parameter :: finest_on_cells = 3.0e-3_real64
  ! What the solves of effects are good to: docs/reference/exit-status.md.
  real(real64), parameter :: finest_of_effects = 1.0e-9_real64

  ! The truth was at most 1.41 times what is estimated of loads and areas, in 83 runs of 59 dense
  ! scenes (test/support/promise_judge.py).
  real(real64), parameter :: over_estimate = 1.5_real64

  ! A tolerance is aimed so much below what would just do; below this share of the accuracy it is
  ! not the tolerance that is to blame.
  real(real64), parameter :: nearly = 0.95_real64, least_tried = 0.25_real64

  !> What a run had: relative errors.
  type :: accuracy_had
    real(real64) :: model = 0.0_real64       !! of load or approach: left out or approximated
    real(real64) :: area = 0.0_real64        !! the same of the real area
    real(real64) :: arithmetic = 0.0_real64  !! of all totals
    real(real64) :: load = 0.0_real64        !! by which a load that was asked for is missed
  end type accuracy_had

contains

  !> The scene with its effects chosen by a tolerance. Without boundary elements all contacts are
  !> Hertzian, and their error is estimated. A map is solved on its pixels: this takes no longer
  !> than the comparison of its summits with them.
  subroutine choose_model(scene_in, tolerance, on_cells, chosen)
    type(scene), intent(in) :: scene_in       !! checked values, with effects
    real(real64), intent(in) :: tolerance     !! share of the totals
    logical, intent(in) :: on_cells           !! contacts go on cells where circles are no good
    type(scene), intent(out) :: chosen        !! the same to be solved
    integer :: mode

    chosen = scene_in
    mode = chosen%effects%mode('interaction')
    if (mode /= effect_off) then
      mode = effect_auto
      if (allocated(scene_in%map)) then
        if (count(scene_in%effects%modes /= effect_off) == 1) mode = effect_boundary
      else if (.not. on_cells) then
        mode = effect_coupled
      end if
    end if
    call chosen%effects%call_for('interaction', mode)
    call chosen%effects%set('tolerance', rounded_decimal(tolerance, 3))
    call chosen%effects%set('area_tolerance', rounded_decimal(tolerance, 3))
    if (tolerance < chosen%effects%number('boundary_tolerance')) &
      call chosen%effects%set('boundary_tolerance', rounded_decimal(tolerance, 3))
  end subroutine choose_model

  !> Estimated influence on the load of all effects that are off, at the worst positions.
  pure real(real64) function influence_left_out(results) result(influence)
    type(scene_results), intent(in) :: results  !! with positions
    integer :: e

    influence = sum([(max(0.0_real64, maxval(results%positions%left_out(e))), &
                      e=1, size(known_effects))])
  end function influence_left_out

  !> `failure` is allocated where an effect that is off has an estimated influence on the load above
  !> the accuracy: it names the largest.
  subroutine check_left_out(scene_in, accuracy, results, failure)
    type(scene), intent(in) :: scene_in                    !! as it was solved
    real(real64), intent(in) :: accuracy                   !! asked for
    type(scene_results), intent(in) :: results             !! with positions
    character(len=:), allocatable, intent(out) :: failure  !! which effect to turn on
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

  !> Whether cells are worth a try after circles: where neighbours count, and cells are as good.
  pure logical function may_go_on_cells(scene_in, accuracy)
    type(scene), intent(in) :: scene_in      !! checked values, with effects
    real(real64), intent(in) :: accuracy     !! asked for

    may_go_on_cells = scene_in%effects%mode('interaction') /= effect_off .and. &
                      .not. allocated(scene_in%map) .and. accuracy >= finest_on_cells
  end function may_go_on_cells

  !> The scene with Hertzian contacts only, to estimate their error.
  subroutine with_circles(scene_in, chosen)
    type(scene), intent(in) :: scene_in       !! checked values, with effects
    type(scene), intent(out) :: chosen        !! the same to be solved

    chosen = scene_in
    if (chosen%effects%mode('interaction') /= effect_off) &
      call chosen%effects%call_for('interaction', effect_coupled)
  end subroutine with_circles

  !> What a run had. A path is held to its tolerance: what is estimated is of its last state.
  function has_accuracy(scene_in, results) result(had)
    type(scene), intent(in) :: scene_in         !! as it was solved
    type(scene_results), intent(in) :: results  !! of it
    type(accuracy_had) :: had
    integer :: column, e, i, m

    had%arithmetic = error_bound('real64', scene_in, results%positions)
    do m = 1, size(results%positions)
      associate (position => results%positions(m))
        had%model = max(had%model, over_estimate * max(0.0_real64, position%error_estimate))
        do i = 1, size(position%states)
          had%load = max(had%load, missed(position%states(i)))
        end do
        if (allocated(position%effects)) then
          do e = 1, size(position%effects)
            if (position%effects(e)%simulated /= 'off') &
              had%arithmetic = max(had%arithmetic, finest_of_effects)
          end do
        end if
      end associate
    end do
    if (allocated(scene_in%loading%path) .and. &
        any(scene_in%effects%modes == effect_auto)) &
      had%model = max(had%model, scene_in%effects%number('tolerance'))
    if (.not. allocated(results%effects)) return
    column = findloc(results%effects%state_columns, 'area_error_estimate', 1)
    if (column == 0) return
    do m = 1, size(results%positions)
      if (.not. allocated(results%positions(m)%state_values)) cycle
      if (size(results%positions(m)%state_values) >= column) &
        had%area = max(had%area, &
                       over_estimate * max(0.0_real64, results%positions(m)%state_values(column)))
    end do
  end function has_accuracy

  ! The share by which a state misses the load asked for.
  pure real(real64) function missed(state)
    type(state_row), intent(in) :: state

    missed = 0.0_real64
    if (state%asked == asked_nothing .or. .not. abs(state%load_asked) > 0.0_real64) return
    missed = abs(merge(state%vertical_load, state%load, state%asked == asked_vertical) / &
                 state%load_asked - 1.0_real64)
  end function missed

  !> The total: of the loads and the approach, or of the area where that is worse.
  pure real(real64) function total_of(had)
    type(accuracy_had), intent(in) :: had   !! of a run

    total_of = max(had%model, had%area) + had%arithmetic + had%load
  end function total_of

  !> The first tolerance of boundary elements to try: their error estimate is about as large.
  pure real(real64) function first_tolerance(accuracy) result(first)
    real(real64), intent(in) :: accuracy        !! asked for

    first = accuracy / over_estimate
  end function first_tolerance

  !> Tolerance of boundary elements to try after one whose error estimate exceeded the accuracy: the
  !> estimate is taken as proportional to the tolerance. 0: none, a finer one would not help.
  pure real(real64) function next_tolerance(had, accuracy, tolerance) result(next)
    type(accuracy_had), intent(in) :: had       !! with the tolerance
    real(real64), intent(in) :: accuracy        !! asked for
    real(real64), intent(in) :: tolerance       !! that was tried
    real(real64) :: left

    left = accuracy - had%arithmetic - had%load
    next = nearly * tolerance * left / max(had%model, had%area)
    if (.not. (next > 0.0_real64 .and. tolerance > least_tried * accuracy)) next = 0.0_real64
  end function next_tolerance

  !> Reports the chosen method, and the cost of an error smaller by a factor of ten.
  subroutine tell_way(scene_in, accuracy, results)
    type(scene), intent(in) :: scene_in             !! as it was solved
    real(real64), intent(in) :: accuracy            !! asked for
    type(scene_results), intent(inout) :: results   !! of it, with the error bound
    integer :: mode

    mode = scene_in%effects%mode('interaction')
    results%way_taken = 'real64, effects as in the scene'
    if (any(scene_in%effects%modes == effect_auto)) results%way_taken = &
      'real64, ''auto'' with tolerance ' // real_text(scene_in%effects%number('tolerance'))
    if (mode == effect_coupled) results%way_taken = results%way_taken // ', Hertzian ' // &
        'contacts in the field of the others'
    if (mode == effect_boundary) results%way_taken = 'real64, pixels of the map'
    results%way_told = 'ten times better: '
    if (results%error_bound <= 0.1_real64 * accuracy) then
      results%way_told = results%way_told // 'reached by this run'
    else if (0.1_real64 * accuracy < finest_of_effects .or. mode == effect_boundary) then
      results%way_told = results%way_told // 'not possible, effects are computed to ' // &
                         real_text(finest_of_effects)
    else if (mode == effect_off) then
      results%way_told = results%way_told // 'by a smaller tolerance, in nearly the same run time'
    else if (0.1_real64 * accuracy >= finest_on_cells) then
      results%way_told = results%way_told // 'by boundary elements, in up to ten times the run time'
    else
      results%way_told = results%way_told // 'possible where Hertzian contacts suffice; areas ' // &
                         'of boundary elements have a relative error of ' // &
                             real_text(finest_on_cells)
    end if
  end subroutine tell_way

  !> What a run had, in words.
  pure function had_text(had) result(text)
    type(accuracy_had), intent(in) :: had   !! of the run
    character(len=:), allocatable :: text

    text = 'an estimated error of loads and separations of ' // &
        real_text(had%model + had%arithmetic + had%load)
    if (had%area > 0.0_real64) &
      text = text // ', of areas of ' // real_text(had%area + had%arithmetic + had%load)
  end function had_text

end module asperity_accuracy_choice
