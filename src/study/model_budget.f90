!> The model's share of an error budget: what the scene's way of taking neighbouring contacts
!> together leaves out, against `boundary` at the same closing.
!>
!> At a given load the error is in the approach instead: the scene's way is closed on to the load
!> at which `boundary` would carry the one given.
module asperity_model_budget
  use asperity_decimal, only: decimal_to_real64
  use asperity_kinds, only: real64
  use asperity_model_run, only: model_run, run_model, too_many_for_cells
  use asperity_numeral, only: rounded_decimal
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: last_state, scene_results
  use asperity_scene_values, only: control_approach, effect_boundary, effect_off, is_load, &
                                   scene
  implicit none
  private

  public :: model_budget, measure_model
  public :: share_given, share_measured, share_unknown
  public :: of_load, of_vertical_load, of_area, of_approach

  ! What is known of the model's share in a total.
  integer, parameter :: share_unknown = 1   !! not estimated
  integer, parameter :: share_measured = 2  !! against `boundary`
  integer, parameter :: share_given = 3     !! the total is given: it has none

  ! Places of the totals.
  integer, parameter :: of_load = 1           !! sum of the normal forces
  integer, parameter :: of_vertical_load = 2  !! sum of their vertical parts
  integer, parameter :: of_area = 3           !! contact area
  integer, parameter :: of_approach = 4       !! approach

  !> The model's share in every total.
  type :: model_budget
    integer :: interaction = effect_off            !! how the scene takes contacts together
    integer :: known(4) = share_unknown            !! what is known of the share
    real(real64) :: error(4) = 0.0_real64          !! largest over the positions, the total's unit
    real(real64) :: cells_are_good_to = 0.0_real64 !! boundary_tolerance, a share of the load
    character(len=:), allocatable :: why_not       !! why nothing is measured
  end type model_budget

contains

  !> Measures the model's share. What cannot be measured stays unknown: that is no failure.
  subroutine measure_model(scene_in, options, results, model)
    type(scene), intent(in) :: scene_in         !! what was solved
    type(run_options), intent(in) :: options    !! of the runs beside, in doubles
    type(scene_results), intent(in) :: results  !! its results
    type(model_budget), intent(out) :: model    !! what the model leaves out
    type(run_options) :: doubles
    character(len=:), allocatable :: why

    doubles = options
    doubles%arithmetic = 'real64'
    model%interaction = scene_in%effects%mode('interaction')
    model%cells_are_good_to = scene_in%effects%number('boundary_tolerance')
    associate (effects => scene_in%effects)
      if (any([effects%mode('plasticity'), effects%mode('adhesion'), effects%mode('creep')] &
              /= effect_off)) then
        model%why_not = 'cells know elastic contacts only'
      else if (allocated(scene_in%loading%path)) then
        model%why_not = 'it depends on the state of a path'
      end if
    end associate
    if (.not. allocated(model%why_not)) then
      why = too_many_for_cells(results)
      if (why /= '') model%why_not = why
    end if
    if (allocated(model%why_not)) return
    if (model%interaction == effect_boundary) then
      call cells_themselves(scene_in, results, model)
    else if (is_load(scene_in%loading%control)) then
      call compare_at_load(scene_in, doubles, results, model)
    else
      call compare_at_approach(scene_in, doubles, results, model)
    end if
  end subroutine measure_model

  ! The scene's way is the reference: what is left is how far its cells have settled.
  subroutine cells_themselves(scene_in, results, model)
    type(scene), intent(in) :: scene_in
    type(scene_results), intent(in) :: results
    type(model_budget), intent(inout) :: model
    integer :: m

    do m = 1, size(results%positions)
      associate (last => last_state(results%positions(m)))
        model%error(of_load) = max(model%error(of_load), model%cells_are_good_to * last%load)
        model%error(of_vertical_load) = max(model%error(of_vertical_load), &
                                            model%cells_are_good_to * last%vertical_load)
      end associate
    end do
    model%known([of_load, of_vertical_load]) = share_measured
    model%known(of_approach) = share_given
    if (is_load(scene_in%loading%control)) model%known(of_approach) = share_unknown
  end subroutine cells_themselves

  ! Where the approach is the same in both ways.
  subroutine compare_at_approach(scene_in, options, results, model)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    type(scene_results), intent(in) :: results
    type(model_budget), intent(inout) :: model
    type(model_run) :: used, cells
    real(real64) :: share
    integer :: m

    call run_both(scene_in, options, used, cells, model%why_not)
    if (allocated(model%why_not)) return
    do m = 1, size(results%positions)
      associate (last => last_state(results%positions(m)))
        share = abs(used%factor(m) - cells%factor(m))
        if (used%factor(m) > 0.0_real64) share = share / used%factor(m)
        model%error(of_load) = max(model%error(of_load), share * last%load)
        model%error(of_vertical_load) = max(model%error(of_vertical_load), &
                                            share * last%vertical_load)
        if (.not. used%last(m)%projected_area > 0.0_real64) cycle
        share = abs(used%last(m)%projected_area - cells%last(m)%projected_area) / &
                used%last(m)%projected_area
        model%error(of_area) = max(model%error(of_area), share * last%area)
      end associate
    end do
    model%known = share_measured
    model%known(of_approach) = share_given
  end subroutine compare_at_approach

  ! The load is the same in both ways. At the approach found, position by position, cells carry
  ! less or more; the largest such share is made up for by closing on.
  subroutine compare_at_load(scene_in, options, results, model)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    type(scene_results), intent(in) :: results
    type(model_budget), intent(inout) :: model
    type(scene) :: one
    type(model_run) :: used, cells
    real(real64) :: share
    integer :: m

    model%known([of_load, of_vertical_load]) = share_given
    share = 0.0_real64
    do m = 1, size(results%positions)
      associate (position => results%positions(m), last => last_state(results%positions(m)))
        one = scene_in
        one%motion%positions = 1
        one%motion%x_first = rounded_decimal(position%x_displacement, 17)
        one%motion%y_first = rounded_decimal(position%y_displacement, 17)
        one%loading%control = control_approach
        one%loading%value = rounded_decimal(last%approach, 17)
      end associate
      call run_both(one, options, used, cells, model%why_not)
      if (allocated(model%why_not)) return
      if (cells%factor(1) > 0.0_real64) &
        share = max(share, abs(used%factor(1) - cells%factor(1)) / cells%factor(1))
    end do
    one = scene_in
    one%loading%value = rounded_decimal(decimal_to_real64(one%loading%value) * &
                                        (1.0_real64 + share), 17)
    call run_model(one, model%interaction, options, used, model%why_not)
    if (allocated(model%why_not)) return
    do m = 1, size(results%positions)
      associate (last => last_state(results%positions(m)))
        model%error(of_approach) = max(model%error(of_approach), &
                                       abs(used%last(m)%approach - last%approach))
      end associate
    end do
    model%known(of_approach) = share_measured
  end subroutine compare_at_load

  ! A scene in its own way and on cells.
  subroutine run_both(scene_in, options, used, cells, failure)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    type(model_run), intent(out) :: used, cells
    character(len=:), allocatable, intent(out) :: failure

    call run_model(scene_in, scene_in%effects%mode('interaction'), options, used, failure)
    if (.not. allocated(failure)) &
      call run_model(scene_in, effect_boundary, options, cells, failure)
  end subroutine run_both

end module asperity_model_budget
