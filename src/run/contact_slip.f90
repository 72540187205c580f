!> Partial slip of surfaces of asperities under a tangential load at their last state.
!>
!> Principle of Ciavarella and Jaeger (see `asperity_partial_slip`) for all contacts together: with
!> the states at the normal load P and at P - T/mu, each contact has the tangential load
!> mu (N - N*) and sticks on its area at P - T/mu. It is exact for level contacts, nu = 0 and
!> Dundurs' beta = 0; the slopes of the contacts are neglected. One path leads through both states:
!> with plasticity the second one is elastic on the residual shape.
module asperity_contact_slip
  use asperity_contact_records, only: contact_row, position_result
  use asperity_effect_names, only: of_friction, of_plasticity
  use asperity_friction, only: slip_contact_columns, slip_state_columns, stiffness_ratio_of
  use asperity_kinds, only: not_computed, real64
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: name_columns, scene_results
  use asperity_scene_values, only: control_load, control_separation, effect_off, has_tangential, &
                                   scene
  use asperity_model_solve, only: solve_effects
  implicit none
  private

  public :: solve_with_slip

  ! Relative step of the load or compression for the stiffness: a central difference of Hertz' law
  ! is in error by 1e-7 (derived; test: spheres in test/effects/test_contact_slip.py).
  real(real64), parameter :: stiffness_step = 1.0e-3_real64
  ! Ratio of the load or displacement to that of sliding below which all is proportional to it, as
  ! in `asperity_partial_slip`.
  real(real64), parameter :: least_ratio = 1.0e-4_real64
  ! Relative error of a normal load, and of that of sliding (chosen: requested loads are met to
  ! 1e-11; test: mu times the requested load in test/effects/test_contact_slip.py).
  real(real64), parameter :: load_met = 1.0e-10_real64

  ! States of the path: at P, and below and above the state with the smaller load, which is at the
  ! third place.
  integer, parameter :: at_load = 1, deeper = 2, stuck = 3, higher = 4

contains

  !> Solves surfaces of asperities, and partial slip at the last state of each position.
  subroutine solve_with_slip(scene_in, options, results, failure)
    type(scene), intent(in) :: scene_in                    !! scene without a map, checked
    type(run_options), intent(in) :: options               !! options of the run
    type(scene_results), intent(inout) :: results          !! results of all positions
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is not solved
    integer :: m

    call solve_effects(scene_in, options, results, failure)
    if (allocated(failure) .or. .not. has_tangential(scene_in%loading)) return
    do m = 1, size(results%positions)
      ! Positions of other images have no states here.
      if (.not. allocated(results%positions(m)%states)) cycle
      call add_slip(scene_in, options, results%positions(m), failure)
      if (allocated(failure)) return
    end do
    call name_columns(results)
  end subroutine solve_with_slip

  ! Solves the states of partial slip of one position and adds its columns.
  subroutine add_slip(scene_in, options, position, failure)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    type(position_result), intent(inout) :: position
    character(len=:), allocatable, intent(out) :: failure
    type(scene_results) :: slip
    real(real64) :: given, kappa, most, mu, ratio, values(5)
    logical :: by_load

    mu = scene_in%effects%number('friction_coefficient')
    kappa = stiffness_ratio_of(scene_in)
    by_load = .not. any(abs(scene_in%loading%tangential_displacement) > 0.0_real64)
    ! Slopes being neglected, all directions are alike.
    given = norm2(scene_in%loading%tangential_load + scene_in%loading%tangential_displacement)
    associate (last => position%states(size(position%states)))
      if (scene_in%effects%modes(of_plasticity) /= effect_off .and. &
          last%load < maxval(position%states%load)) then
        failure = 'a tangential load with plasticity: the last normal load is not the largest ' // &
                  'of the path, expected the largest'
        return
      end if
      most = mu * last%load
      if (.not. by_load) most = mu / kappa * max(0.0_real64, last%compression)
      ! Complete sliding.
      values = [mu * last%load, merge(not_computed, given, by_load), 0.0_real64, 0.0_real64, &
                1.0_real64]
    end associate
    ratio = 1.0_real64
    if (given < most * (1.0_real64 - load_met)) then
      ratio = max(given / most, least_ratio)
      call solve_path(scene_in, options, position, by_load, ratio, slip, failure)
      if (allocated(failure)) then
        failure = 'partial slip: ' // failure
        return
      end if
      associate (states => slip%positions(1)%states)
        ratio = given / most / ratio
        values = [ratio * mu * (states(at_load)%load - states(stuck)%load), &
                  ratio * mu / kappa * (states(stuck)%approach - states(at_load)%approach), &
                  kappa * (states(deeper)%load - states(higher)%load) / &
                  (states(higher)%approach - states(deeper)%approach), &
                  states(stuck)%area, 0.0_real64]
      end associate
    end if
    position%state_values = [position%state_values, values]
    position%state_columns = [position%state_columns, slip_state_columns]
    position%contact_columns = [position%contact_columns, slip_contact_columns]
    call add_contact_columns(mu, ratio, position, slip)
  end subroutine add_slip

  ! Solves the path through the states at the normal load and at the smaller one, without friction.
  subroutine solve_path(scene_in, options, position, by_load, ratio, slip, failure)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    type(position_result), intent(in) :: position
    logical, intent(in) :: by_load             ! the tangential load is given
    real(real64), intent(in) :: ratio          ! of the load or displacement to that of sliding
    type(scene_results), intent(out) :: slip
    character(len=:), allocatable, intent(out) :: failure
    type(scene) :: other
    type(run_options) :: of_path
    real(real64) :: step, values(4)

    other = scene_in
    other%loading%tangential_load = 0.0_real64
    other%loading%tangential_displacement = 0.0_real64
    other%effects%modes(of_friction) = effect_off
    call other%effects%set('friction_coefficient', 0.0_real64)
    other%motion%positions = 1
    other%motion%x_first = position%x_displacement
    other%motion%y_first = position%y_displacement
    ! Within the state at the normal load.
    step = min(stiffness_step, 0.5_real64 * ratio / (1.0_real64 - ratio))
    values = [1.0_real64, (1.0_real64 - ratio) * (1.0_real64 + step), 1.0_real64 - ratio, &
              (1.0_real64 - ratio) * (1.0_real64 - step)]
    associate (last => position%states(size(position%states)))
      if (by_load) then
        other%loading%control = control_load
        values = values * last%load
      else
        other%loading%control = control_separation
        values = last%approach + (1.0_real64 - values) * last%compression
      end if
    end associate
    if (allocated(other%loading%path)) deallocate (other%loading%path)
    allocate (other%loading%path, source=values)
    other%loading%value = other%loading%path(1)
    other%loading%points = 0
    other%loading%events = .false.
    of_path%threads = options%threads
    of_path%interrupt = options%interrupt
    call solve_effects(other, of_path, slip, failure)
  end subroutine solve_path

  ! Adds the tangential load and the area that sticks of each contact of the last state.
  subroutine add_contact_columns(mu, ratio, position, slip)
    real(real64), intent(in) :: mu, ratio
    type(position_result), intent(inout) :: position
    type(scene_results), intent(in) :: slip          ! without positions: complete sliding
    real(real64), allocatable :: values(:, :)
    type(contact_row) :: before, found
    integer :: columns, i, place(2)

    if (.not. allocated(position%contact_values)) return
    columns = size(position%contact_values, 2)
    allocate (values(size(position%contact_values, 1), columns + 2), source=not_computed)
    values(:, :columns) = position%contact_values
    place = 0
    associate (last => position%states(size(position%states)))
      do i = last%first_row, min(last%last_row, size(values, 1))
        associate (row => position%rows(i))
          values(i, columns + 1:) = [mu * row%load, 0.0_real64]
          if (.not. allocated(slip%positions)) cycle
          call find_row(row, slip%positions(1), at_load, place(1), before)
          call find_row(row, slip%positions(1), stuck, place(2), found)
          values(i, columns + 1:) = [ratio * mu * (before%load - found%load), found%area]
        end associate
      end do
    end associate
    call move_alloc(values, position%contact_values)
  end subroutine add_contact_columns

  ! Finds a contact in a state of the path, from the one found last on: both lists have the same
  ! order. A contact that is open there has neither load nor area.
  subroutine find_row(row, position, number, place, found)
    type(contact_row), intent(in) :: row
    type(position_result), intent(in) :: position
    integer, intent(in) :: number           ! of the state
    integer, intent(inout) :: place         ! contacts of the state before the next one expected
    type(contact_row), intent(out) :: found
    integer :: i, k, rows

    found%load = 0.0_real64
    found%area = 0.0_real64
    associate (state => position%states(number))
      rows = state%last_row - state%first_row + 1
      do i = 0, rows - 1
        k = state%first_row + modulo(place + i, rows)
        if (position%rows(k)%upper /= row%upper .or. position%rows(k)%lower /= row%lower) cycle
        found = position%rows(k)
        place = place + i + 1
        return
      end do
    end associate
  end subroutine find_row

end module asperity_contact_slip
