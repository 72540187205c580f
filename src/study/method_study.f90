!> Run time and error of every method that applies to a scene, against the most accurate one that
!> fits into the time.
module asperity_method_study
  use asperity_interruption, only: interruption
  use asperity_kinds, only: int64, not_computed, real64
  use asperity_method_totals, only: errors_of, method_errors, method_totals, original_totals, &
                                    totals_of
  use asperity_original, only: run_in_arithmetic
  use asperity_original_records, only: original_records
  use asperity_problems, only: real_text
  use asperity_progress, only: progress_line
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: effect_off, scene
  use asperity_study_methods, only: list_methods, most_methods, of_arithmetic, of_effects, &
                                    of_neighbours, of_steps, request_of, run_method, &
                                    simulated_effects, study_method
  implicit none
  private

  public :: error_against, fastest_within, on_front, study_scene, method_row, method_table

  ! The scene as it asks may take so much: the rest is for methods that are cheaper.
  real(real64), parameter :: share_of_scene = 0.5_real64
  ! Shares of the remaining time for one method with neighbours and for one by steps: others follow.
  real(real64), parameter :: share_of_neighbours = 0.75_real64, share_of_step = 0.25_real64

  character(len=*), parameter :: too_long = 'takes longer than --seconds'

  !> One method: its cost and its errors.
  type :: method_row
    type(study_method) :: method                     !! what it is
    real(real64) :: seconds = not_computed     !! all positions, median, from the scene read on
    type(method_errors) :: total = method_errors()   !! against the reference
    type(method_errors) :: own = method_errors()     !! against what differs in its family alone
    real(real64) :: own_estimate = not_computed  !! largest `error_estimate` of its run
    !> Largest estimates of its last states: of area, separation and greatest pressure.
    real(real64) :: estimates(3) = not_computed
    !> Load, approach, area and greatest pressure of the last states, mean over the positions.
    real(real64) :: ends(4) = not_computed
    logical :: is_reference = .false.          !! the others are compared with it
    logical :: on_front = .false.              !! no other is clearly better
    character(len=:), allocatable :: left_out  !! why it was not run; not allocated: it was
  end type method_row

  !> All methods.
  type :: method_table
    type(method_row), allocatable :: rows(:)          !! in a fixed order
    integer :: reference = 1                       !! the row that the others are compared with
    type(method_totals) :: truth                      !! its totals
    integer :: next_best = 0                       !! the row that is best but for it; 0: none
    real(real64) :: next_best_differs = 0.0_real64 !! from the reference, as an error
    character(len=:), allocatable :: no_neighbours !! why none takes neighbours; empty: some do
  end type method_table

  ! Two methods cost the same, or err the same, when they differ by less than this factor. It is
  ! wide so that the front does not depend on the noise of the clock.
  real(real64), parameter :: same_time = 1.5_real64, same_error = 1.1_real64

  ! At least so many passes are run, unless they take so many times the time to spend.
  integer, parameter :: least_passes = 3
  real(real64), parameter :: most_times = 3.0_real64

  ! Time spent on every method at most, s: enough for a steady median. Repetitions take a quarter of
  ! the time: the rest is for single runs that take longer.
  real(real64), parameter :: seconds_a_method = 0.2_real64
  integer, parameter :: share_of_repetitions = 4

contains

  !> Runs all methods of a scene. `failure` is allocated when the scene as it asks cannot be solved
  !> in the time.
  subroutine study_scene(scene_in, seconds, finest, shows_progress, table, failure)
    type(scene), intent(in) :: scene_in         !! scene with checked values
    real(real64), intent(in) :: seconds         !! time that may be spent, s
    real(real64), intent(in) :: finest          !! resolution of a map: 1, or 2: doubled too
    logical, intent(in) :: shows_progress       !! on a terminal; a piece is a method
    type(method_table), intent(out) :: table       !! all methods of a scene
    character(len=:), allocatable, intent(out) :: failure  !! reason of a failure
    type(interruption) :: allowance
    type(progress_line) :: progress
    integer :: pieces

    pieces = most_methods(scene_in)
    if (shows_progress) call progress%begin(.true., 'methods', pieces, 0)
    call allowance%end_within(seconds)
    call run_methods(scene_in, min(seconds_a_method, seconds / (share_of_repetitions * pieces)), &
                     finest, allowance, progress, table, failure)
    if (shows_progress) call progress%finish()
  end subroutine study_scene

  ! Runs the study.
  subroutine run_methods(scene_in, least_seconds, finest, allowance, progress, table, failure)
    type(scene), intent(in) :: scene_in               ! scene with checked values
    real(real64), intent(in) :: least_seconds         ! to spend on a method, s
    real(real64), intent(in) :: finest                ! resolution of a map: 1, or 2: doubled too
    type(interruption), intent(in) :: allowance       ! time that may be spent
    type(progress_line), intent(inout) :: progress    ! progress; a piece is a method
    type(method_table), intent(out) :: table             ! all methods of a scene
    character(len=:), allocatable, intent(out) :: failure  ! reason of a failure
    type(scene_results) :: results
    type(study_method), allocatable :: methods(:)
    type(method_totals), allocatable :: totals(:)
    type(method_row) :: row
    type(interruption) :: others
    real(real64) :: compression, left, most
    integer :: i, pass

    most = allowance%seconds_left()
    row%method = study_method(name='as in the scene')
    if (.not. allocated(scene_in%map)) row%method%typed = 'the scene as it is'
    allocate (totals(1))
    call time_method(scene_in, least_seconds, share_of_scene * most, row, totals(1), results)
    ! A scene that takes more than its share, as it cannot be interrupted everywhere, takes nothing
    ! from the other methods.
    others = allowance
    if (others%seconds_left() < (1.0_real64 - share_of_scene) * most) &
      call others%end_within((1.0_real64 - share_of_scene) * most)
    compression = 0.0_real64
    if (allocated(row%left_out)) then
      ! Where a map cannot be solved its coarser pixels may be.
      if (index(row%left_out, too_long) == 0 .and. .not. allocated(scene_in%map)) then
        failure = row%left_out
        return
      end if
      ! The results of an interrupted run are incomplete.
      results = scene_results()
      allocate (results%positions(0))
    else
      compression = maxval(totals(1)%states%compression)
    end if
    call list_methods(scene_in, simulated_effects(scene_in, results), compression, finest, &
                      methods, table%no_neighbours)
    deallocate (totals)
    allocate (table%rows(size(methods) + 1), totals(size(methods) + 1))
    table%rows(1) = row
    totals(1) = totals_of(results)
    call progress%step()
    ! The reference is one of those with neighbours: they have the time first.
    do pass = 1, 2
      do i = 1, size(methods)
        if ((methods(i)%family == of_neighbours) .neqv. pass == 1) cycle
        row = method_row(method=methods(i))
        left = others%seconds_left()
        if (row%method%family == of_steps) left = share_of_step * left
        if (row%method%family == of_neighbours) left = share_of_neighbours * left
        ! Methods with neighbours follow each other from the fastest on.
        if (row%method%family == of_neighbours .and. is_too_long(table%rows(i)) .and. ( &
            row%method%accuracy > 0.0_real64 .eqv. table%rows(i)%method%accuracy > 0.0_real64)) then
          row%left_out = too_long // ', as a faster method does'
        else if (.not. left > 0.0_real64) then
          row%left_out = too_long // ', ' // seconds_text(0.0_real64) // ' s were left'
        else
          call time_method(scene_in, least_seconds, left, row, totals(i + 1), results)
        end if
        table%rows(i + 1) = row
        call progress%step()
      end do
    end do
    call choose_reference(table, totals, allocated(scene_in%map))
    if (table%reference == 0) then
      failure = table%rows(1)%left_out
      if (index(failure, too_long) == 1) &
        failure = 'the scene ' // too_long // ': expected more of them, or fewer positions'
    else
      call measure_errors(table, totals)
      call mark_front(table%rows)
    end if
  end subroutine run_methods

  ! Whether a method was left out as it takes too long.
  pure logical function is_too_long(row)
    type(method_row), intent(in) :: row

    is_too_long = allocated(row%left_out)
    if (is_too_long) is_too_long = index(row%left_out, too_long) == 1
  end function is_too_long

  ! One method on the clock, again and again until the time is spent.
  subroutine time_method(scene_in, least_seconds, most_seconds, row, totals, results)
    type(scene), intent(in) :: scene_in
    real(real64), intent(in) :: least_seconds, most_seconds
    type(method_row), intent(inout) :: row
    type(method_totals), intent(out) :: totals
    type(scene_results), intent(inout) :: results
    type(scene_results) :: of_pass
    real(real64), allocatable :: samples(:)
    real(real64) :: seconds
    type(run_options) :: options
    type(original_records) :: records
    integer(int64) :: from, rate, until

    options = run_options(keep_contacts=.false., threads=1)
    call options%interrupt%end_within(most_seconds)
    allocate (samples(0))
    do while ((sum(samples) < least_seconds .or. size(samples) < least_passes) .and. &
              sum(samples) <= most_times * least_seconds)
      call system_clock(from, rate)
      if (row%method%is_original) then
        call run_in_arithmetic(row%method%arithmetic, scene_in%deck, &
                               request_of(row%method, .false.), records, row%left_out)
      else
        call run_method(scene_in, row%method, options, of_pass, row%left_out)
      end if
      call system_clock(until)
      if (allocated(row%left_out)) exit
      ! A pass that is ended early leaves neither results nor totals.
      if (.not. row%method%is_original) then
        results = of_pass
        totals = totals_of(results)
      end if
      seconds = real(until - from, real64) / real(rate, real64)
      ! They are ascending.
      samples = [pack(samples, samples <= seconds), seconds, pack(samples, samples > seconds)]
      if (options%interrupt%seconds_left() < 0.0_real64) exit
    end do
    if (size(samples) == 0) then
      if (index(row%left_out, 'interrupted') > 0 .or. &
          options%interrupt%seconds_left() < 0.0_real64) &
        row%left_out = too_long // ', ' // seconds_text(most_seconds) // ' s were left'
      return
    end if
    if (allocated(row%left_out)) deallocate (row%left_out)
    if (row%method%is_original) then
      ! It is timed without its contacts, which have the greatest pressure.
      call run_in_arithmetic(row%method%arithmetic, scene_in%deck, &
                             request_of(row%method, .true.), records, row%left_out)
      totals = original_totals(records)
    end if
    row%seconds = 0.5_real64 * (samples((size(samples) + 1) / 2) + samples(size(samples) / 2 + 1))
    row%own_estimate = totals%own_estimate
    row%estimates = totals%estimates
    associate (last => totals%states(totals%first(2:) - 1))
      row%ends = [sum(last%load), sum(last%approach), sum(last%area), &
                  sum(last%greatest_pressure)] / size(last)
    end associate
  end subroutine time_method

  ! Chooses the reference: the method with interaction whose own error estimate is the least, or the
  ! scene as it is. Coarser pixels of a map are the last choice.
  subroutine choose_reference(table, totals, is_map)
    type(method_table), intent(inout) :: table
    type(method_totals), intent(in) :: totals(:)
    logical, intent(in) :: is_map
    type(method_errors) :: errors
    real(real64) :: estimate, least
    integer :: best, i, plain, second

    best = merge(0, 1, allocated(table%rows(1)%left_out))
    second = 0
    least = huge(least)
    do i = 1, size(totals)
      associate (row => table%rows(i))
        if (allocated(row%left_out)) cycle
        if (row%method%family /= of_neighbours .or. row%method%interaction == effect_off) cycle
        estimate = row%own_estimate
        if (is_map .and. row%method%resolution < 1.0_real64) estimate = 1.0_real64 + estimate
        ! The last method without an estimate is the finest.
        if (.not. estimate > not_computed) estimate = least
        if (estimate > least) then
          second = i
        else
          second = best
          best = i
          least = estimate
        end if
      end associate
    end do
    ! Without effects rounding alone is left.
    plain = row_of_events(table%rows)
    if (best == 1 .and. plain > 0 .and. .not. table%rows(1)%own_estimate > not_computed) then
      errors = errors_of(totals(1), totals(plain))
      if (errors%largest <= epsilon(least)) best = plain
    end if
    if (second > 0 .and. second /= best) then
      table%next_best = second
      errors = errors_of(totals(second), totals(best))
      table%next_best_differs = errors%largest
    end if
    table%reference = best
    if (best == 0) return
    table%rows(best)%is_reference = .true.
    table%truth = totals(best)
  end subroutine choose_reference

  ! Measures the error of every method against the reference, and its own: against the same model
  ! without the approximation of its family.
  subroutine measure_errors(table, totals)
    type(method_table), intent(inout) :: table
    type(method_totals), intent(in) :: totals(:)
    integer :: i, plain

    plain = row_of_events(table%rows)
    do i = 1, size(totals)
      associate (row => table%rows(i))
        if (allocated(row%left_out)) cycle
        row%total = errors_of(totals(i), table%truth)
        select case (row%method%family)
        case (of_arithmetic, of_steps)
          if (plain > 0 .and. plain /= i) row%own = errors_of(totals(i), totals(plain))
        case (of_effects)
          if (allocated(totals(1)%states)) row%own = errors_of(totals(i), totals(1))
        case default
          row%own = row%total
        end select
      end associate
    end do
  end subroutine measure_errors

  ! The row of exact events; 0: it was not run.
  pure integer function row_of_events(rows) result(row)
    type(method_row), intent(in) :: rows(:)

    row = findloc(rows%method%family, of_arithmetic, 1)
    if (row == 0) return
    if (allocated(rows(row)%left_out)) row = 0
  end function row_of_events

  !> Error of a row: against the reference, at least the estimated error of the reference itself.
  pure real(real64) function error_against(table, i) result(error)
    type(method_table), intent(in) :: table  !! all methods of a scene
    integer, intent(in) :: i                 !! row that was run

    error = max(table%rows(i)%total%largest, table%rows(table%reference)%own_estimate, 0.0_real64)
  end function error_against

  !> The row to take for an error: of the fastest rows with it that can be typed the scene as
  !> it is, else that of the least error; 0: none has it. On a map the row with this accuracy.
  pure integer function fastest_within(table, goal) result(fastest)
    type(method_table), intent(in) :: table  !! all methods of a scene
    real(real64), intent(in) :: goal         !! largest relative error
    real(real64), dimension(size(table%rows)) :: error, seconds
    integer :: i

    error = huge(error)
    do i = 1, size(table%rows)
      associate (row => table%rows(i))
        if (allocated(row%left_out) .or. row%method%typed == '') cycle
        if (row%method%accuracy > 0.0_real64 .and. &
            .not. abs(row%method%accuracy - goal) < 0.5_real64 * goal) cycle
        error(i) = error_against(table, i)
      end associate
    end do
    seconds = merge(table%rows%seconds, huge(seconds), error <= goal)
    where (seconds > same_time * minval(seconds)) error = huge(error)
    fastest = 0
    if (minval(error) <= goal) fastest = merge(1, minloc(error, 1), error(1) <= goal)
  end function fastest_within

  ! Marks the Pareto front of the methods that were run: by the error against the reference, where
  ! what is below the error of the reference itself is no gain.
  pure subroutine mark_front(rows)
    type(method_row), intent(inout) :: rows(:)
    integer, allocatable :: run(:)
    real(real64) :: least_error
    integer :: i

    least_error = 0.0_real64
    if (any(rows%is_reference)) &
      least_error = max(0.0_real64, rows(findloc(rows%is_reference, .true., 1))%own_estimate)
    run = pack([(i, i=1, size(rows))], [(.not. allocated(rows(i)%left_out), i=1, size(rows))])
    rows(run)%on_front = on_front(rows(run)%seconds, max(rows(run)%total%largest, least_error))
  end subroutine mark_front

  ! Seconds with two digits.
  pure function seconds_text(seconds) result(text)
    real(real64), intent(in) :: seconds
    character(len=:), allocatable :: text

    text = real_text(seconds, 'es9.1e3')
    if (seconds < 1.0e5_real64) text = real_text(seconds, 'f9.2')
  end function seconds_text

  !> The methods that no other method of the front excels; each of the rest is excelled by one of
  !> the front. A method excels another that is clearly less accurate at no clearly higher cost, or
  !> as accurate at a clearly higher cost; of two that are equal in both, the one whose gain,
  !> relative to what counts as equal, is larger. So no method of the front excels another through a
  !> third. Methods of one error and equal times have the least of these times, and the first of
  !> them is taken: the clock does not choose between methods that are the same.
  pure function on_front(seconds, error) result(front)
    real(real64), intent(in) :: seconds(:)  !! run times [s], more than 0
    real(real64), intent(in) :: error(:)    !! relative errors, 0 or more; as many
    logical :: front(size(seconds))
    logical, dimension(size(seconds)) :: rest, new
    real(real64) :: least(size(seconds))
    integer :: i, j

    do i = 1, size(seconds)
      least(i) = minval(seconds, abs(error - error(i)) <= 0.0_real64 .and. &
                                 seconds(i) <= same_time * seconds)
    end do
    front = .false.
    rest = .true.
    do while (any(rest))
      do i = 1, size(rest)
        new(i) = rest(i) .and. .not. any([(rest(j) .and. is_better(j, i), j=1, size(rest))])
      end do
      front = front .or. new
      do i = 1, size(rest)
        rest(i) = rest(i) .and. .not. new(i) .and. &
                  .not. any([(new(j) .and. is_better(j, i), j=1, size(new))])
      end do
    end do

  contains

    pure logical function is_better(one, other)
      integer, intent(in) :: one, other
      real(real64) :: more(2)  ! error and time, of what counts as equal: up to 1

      if (min(error(one), error(other)) > 0.0_real64) then
        more(1) = log(error(one) / error(other)) / log(same_error)
      else
        more(1) = sign(2.0_real64, error(one) - error(other))
        if (max(error(one), error(other)) <= 0.0_real64) more(1) = 0.0_real64
      end if
      more(2) = log(least(one) / least(other)) / log(same_time)
      is_better = any(more < -1.0_real64) .and. all(more < 1.0_real64)
      if (all(abs(more) <= 1.0_real64)) &
        is_better = sum(more) < 0.0_real64 .or. (.not. sum(more) > 0.0_real64 .and. one < other)
    end function is_better

  end function on_front

end module asperity_method_study
