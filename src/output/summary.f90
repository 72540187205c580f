!> The summary that `asperity solve` prints.
module asperity_summary
  use asperity_contact_field, only: parts_in_words
  use asperity_contact_records, only: prescribed_nothing, state_row
  use asperity_effect_names, only: known_effects, of_interaction
  use asperity_effects_summary, only: effects_in_words, load_is_met, write_effects
  use asperity_kinds, only: not_computed, real64
  use asperity_library_turn, only: library_turn
  use asperity_number_format, only: count_text, percent_text, positions_listed, number_text
  use asperity_problems, only: decimal_text
  use asperity_result_table, only: array_table, make_arrays, numbers_of, of_states, place_of
  use asperity_scene_results, only: last_state, scene_results
  use asperity_scene_values, only: criterion_none, criterion_words, effect_off, is_limit, scene, &
                                   scene_map
  use asperity_text_buffer, only: text_buffer
  use asperity_totals_table, only: write_totals
  use asperity_unit_names, only: is_area, is_length, is_moment, is_pressure, unit_of, with_unit
  implicit none
  private

  public :: write_summary, write_choice

contains

  !> The scene and its model, the totals over its positions, their error estimate, the ends of a
  !> load path, what each effect changed.
  subroutine write_summary(scene_in, results, buffer)
    type(scene), intent(in) :: scene_in         !! scene that was solved
    type(scene_results), intent(in) :: results  !! results of a run
    type(text_buffer), intent(inout) :: buffer  !! gets the lines
    integer :: at
    type(library_turn) :: turn

    call turn%begin()
    call write_heading(scene_in, results, buffer)
    call buffer%line('')
    call write_totals(scene_in, results, buffer)
    call buffer%line('')
    if (errors_in_words(results) /= '') call buffer%line(errors_in_words(results))
    call write_remarks(scene_in, results, buffer)
    ! Hertz' contact of the smooth form under the roughness of a map.
    at = 0
    if (allocated(results%effects)) &
      at = findloc(results%effects%state_columns, 'hertz_pressure', 1)
    if (at > 0) then
      associate (smooth => results%positions(1)%state_values(at:at + 1))
        if (all(smooth > not_computed)) &
          call buffer%line('smooth form (Hertz): greatest pressure ' // &
                           trim(number_text(smooth(1)) // ' ' // &
                                unit_of(scene_in, is_pressure)) // ', contact area ' // &
                           trim(number_text(smooth(2)) // ' ' // unit_of(scene_in, is_area)))
      end associate
    end if
    ! Grid of the fields, and where the pressures on it come from.
    if (allocated(results%positions(1)%fields)) then
      associate (field => results%positions(1)%fields(size(results%positions(1)%fields)))
        if (parts_in_words(field) /= '') &
          call buffer%line('fields on ' // decimal_text(field%columns) // ' x ' // &
                           decimal_text(field%rows) // ' pixels of ' // &
                           trim(number_text(field%pixel_spacing(1)) // ' ' // &
                                unit_of(scene_in, is_length)) // &
                           '; pressures of contacts: ' // parts_in_words(field))
      end associate
    end if
    call write_path(scene_in, results, buffer)
    call write_effects(results, buffer)
  end subroutine write_summary

  !> Surfaces, model and control, in two lines.
  subroutine write_heading(scene_in, results, buffer)
    type(scene), intent(in) :: scene_in         !! scene that was solved
    type(scene_results), intent(in) :: results  !! results of a run
    type(text_buffer), intent(inout) :: buffer  !! gets the lines
    character(len=:), allocatable :: limit, model

    call buffer%line(scene_in%file // ': ' // surfaces_in_words(scene_in) // ', ' // &
                     count_text(size(results%positions), 'position'))
    model = effects_in_words(results)
    limit = ''
    if (asks_for_limit(scene_in)) &
      limit = '; limit: ' // trim(criterion_words(scene_in%limit%criterion))
    if (model == 'none') model = 'elastic, frictionless, non-interacting contacts (Hertz)'
    call buffer%line('model: ' // model // '; control: ' // &
                     trim(scene_in%loading%control%word) // limit // &
                     '; arithmetic: ' // trim(results%arithmetic) // &
                     trim(merge('; lengths without a unit', repeat(' ', 24), &
                                allocated(scene_in%map) .and. unit_of(scene_in, is_length) == '')))
  end subroutine write_heading

  !> `error estimate: load 1.2 %, contact area 0.9 %`, the largest over the positions; under load
  !> control it is that of the compression in place of the load, and on pixels that of the
  !> separation over the compression besides. Empty where none is known, or the reason.
  pure function errors_in_words(results) result(text)
    type(scene_results), intent(in) :: results  !! results of a run
    character(len=:), allocatable :: text       !! one line
    character(len=*), parameter :: columns(5) = [character(len=32) :: &
      'separation_error_estimate', 'area_error_estimate', 'pressure_error_estimate', &
      'slip_error_estimate', 'stick_error_estimate']
    character(len=*), parameter :: names(5) = [character(len=20) :: 'separation', 'contact area', &
      'greatest pressure', 'tangential stiffness', 'area that sticks']
    real(real64) :: error
    integer :: at, k, m

    text = ''
    if (any(results%positions%error_estimate > not_computed)) &
      text = trim(merge('load       ', 'compression', all([ &
             (results%positions(m)%states(size(results%positions(m)%states))%prescribed == &
              prescribed_nothing, m=1, size(results%positions))]))) // ' ' // &
             percent_text(maxval(results%positions%error_estimate))
    do k = 1, merge(size(columns), 0, allocated(results%effects))
      at = findloc(results%effects%state_columns, columns(k), 1)
      error = not_computed
      do m = 1, merge(size(results%positions), 0, at > 0)
        error = max(error, results%positions(m)%state_values(at))
      end do
      if (.not. error > not_computed) cycle
      if (text /= '') text = text // ', '
      text = text // trim(names(k)) // ' ' // percent_text(error)
    end do
    at = findloc(results%positions%no_estimate /= '', .true., 1)
    if (at > 0) then
      if (text /= '') text = text // ', '
      text = text // trim(results%positions(at)%no_estimate)
    end if
    if (text /= '') text = 'error estimate: ' // text
  end function errors_in_words

  !> Limits reached, positions without contact, overlapping circles.
  subroutine write_remarks(scene_in, results, buffer)
    type(scene), intent(in) :: scene_in         !! scene that was solved
    type(scene_results), intent(in) :: results  !! results of a run
    type(text_buffer), intent(inout) :: buffer  !! gets the lines
    type(state_row) :: last
    character(len=:), allocatable :: text
    integer :: m, without

    without = 0
    do m = 1, size(results%positions)
      last = last_state(results%positions(m))
      if (last%contacts == 0) without = without + 1
    end do
    if (asks_for_limit(scene_in) .or. any(results%positions%limit_reached)) &
      call buffer%line('limit reached at ' // &
                       decimal_text(count(results%positions%limit_reached)) // ' of ' // &
                       count_text(size(results%positions), 'position'))
    if (without > 0) call buffer%line('no contact at ' // count_text(without, 'position'))
    associate (circles => results%positions%overlapping_circles)
      if (.not. any(circles > 0)) return
      text = count_text(sum(circles), 'pair') // ' of contact circles overlap'
      if (sum(circles) == 1) text = text // 's'
      if (size(circles) > 1) text = text // ', at ' // &
        trim(merge('position ', 'positions', count(circles > 0) == 1)) // ' ' // &
        positions_listed(circles > 0)
      if (scene_in%effects%modes(of_interaction) == effect_off) &
        text = text // ': their interaction is off'
      call buffer%line(text)
    end associate
  end subroutine write_remarks

  !> The state at each value of a load path, and the state of the largest load.
  subroutine write_path(scene_in, results, buffer)
    type(scene), intent(in) :: scene_in         !! scene that was solved
    type(scene_results), intent(in) :: results  !! results of a run
    type(text_buffer), intent(inout) :: buffer  !! gets the lines; none without a load path
    character(len=*), parameter :: columns(5) = [character(len=16) :: 'vertical_load', 'area', &
      'separation', 'compression', 'contacts']
    character(len=*), parameter :: heads(5) = [character(len=18) :: 'vertical load', &
      'contact area', 'separation', 'compression', 'contacts']
    type(array_table) :: table
    character(len=120) :: line
    character(len=20) :: cell
    character(len=:), allocatable :: failure, text
    real(real64), dimension(size(results%positions(1)%states)) :: controlled, numbers
    real(real64), allocatable :: lost(:), values(:)
    real(real64) :: before
    integer :: at, i, k, last

    if (.not. allocated(scene_in%loading%path) .or. size(results%positions) /= 1) return
    call make_arrays(of_states, results, table, failure)
    if (allocated(failure)) return
    allocate (values(size(scene_in%loading%path)), lost(0))
    values(:) = scene_in%loading%path
    controlled = numbers_of(table, trim(scene_in%loading%control%column))
    call buffer%line('')
    line = 'load path'
    do k = 1, size(heads)
      associate (column => table%columns(place_of(table, trim(columns(k)))))
        cell = with_unit(trim(heads(k)), unit_of(scene_in, column%dimension))
      end associate
      line(20 * k - 7:) = adjustr(cell)
    end do
    call buffer%line(trim(line))
    associate (states => results%positions(1)%states)
      last = 0
      before = 0.0_real64
      do i = 1, size(values)
        at = last + findloc(abs(controlled(last + 1:) - values(i)) <= &
                            load_is_met * maxval(abs(values)), .true., 1)
        if (at == last) cycle
        call put_state('end ' // decimal_text(i), at)
        ! A cycle is closed by an end at less compression than the end before it.
        if (last > 0) then
          if (states(at)%compression < states(last)%compression) then
            lost = [lost, states(at)%dissipated_work - before]
            before = states(at)%dissipated_work
          end if
        end if
        last = at
      end do
      call put_state('largest load', maxloc(states%vertical_load, 1))
      if (size(lost) == 0 .or. .not. states(1)%dissipated_work > not_computed) return
    end associate
    text = with_unit('energy lost in each cycle', unit_of(scene_in, is_moment)) // ': '
    do i = 1, size(lost)
      if (i > 1) text = text // ', '
      text = text // number_text(lost(i))
    end do
    call buffer%line(text)

  contains

    subroutine put_state(name, at)
      character(len=*), intent(in) :: name
      integer, intent(in) :: at

      line = name
      do k = 1, size(columns)
        numbers = numbers_of(table, trim(columns(k)))
        cell = number_text(numbers(at))
        line(20 * k - 7:) = adjustr(cell)
      end do
      call buffer%line(trim(line))
    end subroutine put_state

  end subroutine write_path

  ! How many asperities there are, or on what plane.
  function surfaces_in_words(scene_in) result(text)
    type(scene), intent(in) :: scene_in
    character(len=:), allocatable :: text

    if (allocated(scene_in%map)) then
      text = maps_in_words(scene_in%map, size(scene_in%upper%x) + size(scene_in%lower%x))
    else if (scene_in%upper%is_plane) then
      text = 'upper plane on ' // decimal_text(size(scene_in%lower%x)) // ' lower asperities'
    else if (scene_in%lower%is_plane) then
      text = decimal_text(size(scene_in%upper%x)) // ' upper asperities on lower plane'
    else
      text = decimal_text(size(scene_in%upper%x)) // ' upper and ' // &
             decimal_text(size(scene_in%lower%x)) // ' lower asperities'
    end if
  end function surfaces_in_words

  ! The maps and their samples, and how many asperities are in contact with one.
  pure function maps_in_words(maps, asperities) result(text)
    type(scene_map), intent(in) :: maps
    integer, intent(in) :: asperities
    character(len=:), allocatable :: text

    associate (columns => max(maps%upper%columns, maps%lower%columns), &
               rows => max(maps%upper%rows, maps%lower%rows))
      text = decimal_text(columns) // ' x ' // decimal_text(rows) // ' pixels'
    end associate
    if (min(maps%upper%columns, maps%lower%columns) > 0) then
      text = 'two height maps of ' // text // ', their sum under a plane'
    else if (asperities > 0) then
      text = 'height map of ' // text // ' and ' // decimal_text(asperities) // ' asperities'
    else
      text = 'height map of ' // text // ' and a plane'
    end if
    associate (strip_axis => max(maps%upper%strip_axis, maps%lower%strip_axis))
      if (maps%periodic .and. strip_axis == 0) text = 'periodic ' // text
      if (strip_axis > 0) text = text // ', periodic along ' // 'xy'(strip_axis:strip_axis)
    end associate
  end function maps_in_words

  !> The method that was chosen for the accuracy asked for.
  subroutine write_choice(accuracy, results, buffer)
    real(real64), intent(in) :: accuracy        !! asked for, relative
    type(scene_results), intent(in) :: results  !! the way taken and its error bound
    type(text_buffer), intent(inout) :: buffer  !! gets the text
    character(len=9) :: requested, promised
    character(len=:), allocatable :: deviation
    real(real64) :: share
    integer :: e

    write (requested, '(es9.1e3)') accuracy
    write (promised, '(es9.1e3)') results%error_bound
    deviation = ''
    do e = 1, size(known_effects)
      share = maxval(results%positions%left_out(e))
      if (share > not_computed) deviation = deviation // ' (' // trim(known_effects(e)%name) // &
                                            ' off, estimated influence ' // percent_text(share) // &
                                              ')'
    end do
    call buffer%line('accuracy' // requested // ': fastest method ' // results%way_taken // &
                     ', ' // trim(merge('estimated error', 'error bound    ', &
                                allocated(results%effects))) // promised // deviation)
  end subroutine write_choice

  ! Whether the scene names a limit or goes to one. A deck brings one that may not be meant.
  pure logical function asks_for_limit(scene_in) result(asks)
    type(scene), intent(in) :: scene_in

    asks = scene_in%limit%criterion /= criterion_none .and. &
           (is_limit(scene_in%loading%control) .or. .not. scene_in%limit%from_thesis)
  end function asks_for_limit

end module asperity_summary
