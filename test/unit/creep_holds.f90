!> Contacts under a hold, as the suite of creep tests them.
module asperity_creep_holds
  use asperity_contact_effect, only: contact_effect, effect_outcome
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: contact_state, start_state, total_load
  use asperity_creep, only: new_creep
  use asperity_effect_helpers, only: pair_of, set_number
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_scene_values, only: effect_on, scene
  use asperity_testing, only: check, error_type
  use asperity_viscoelastic_solid, only: hold_times, standard_linear_solid
  implicit none
  private

  public :: half, hold_load, start, creep_of, held_at, three_spheres

  !> A solid that keeps half its modulus.
  type(standard_linear_solid), parameter :: half = standard_linear_solid(0.5_real64, 1.0_real64)

contains

  !> Holds a load in so many states, ends with the last.
  subroutine hold_load(error, solid, pairs, load, hold_time, points, state, coupling)
    !> the test's failure
    type(error_type), allocatable, intent(inout) :: error
    !> what the bodies are made of
    type(standard_linear_solid), intent(in) :: solid
    !> the pairs
    type(contact_pairs), intent(in) :: pairs
    !> the load, and how long it is held
    real(real64), intent(in) :: load, hold_time
    !> number of states
    integer, intent(in) :: points
    !> the last state
    type(contact_state), intent(out) :: state
    !> interaction of the contacts; each alone without it
    class(contact_effect), intent(in), optional :: coupling
    class(contact_effect), allocatable :: creep
    type(effect_outcome) :: outcome
    real(real64), allocatable :: times(:)
    real(real64) :: low, high, middle, pressure
    integer :: i, try

    call start(solid, pairs, creep)
    call hold_times(hold_time, solid%relaxation_time, points, times)
    low = 0.0_real64
    pressure = 1.0_real64
    do i = 1, size(times)
      high = 1.0_real64
      do try = 1, 60
        middle = 0.5_real64 * (low + high)
        call held_at(pairs, creep, middle, times(i), state, outcome, coupling)
        if (total_load(state) < load) then
          low = middle
        else
          high = middle
        end if
      end do
      call held_at(pairs, creep, high, times(i), state, outcome, coupling)
      call check(error, .not. allocated(outcome%failure), 'held load')
      if (allocated(error)) return
      call creep%keep(pairs, state)
      call check(error, state%answers(1)%maximum_pressure <= pressure * (1.0_real64 + &
                 1.0e-14_real64), 'pressure rises')
      pressure = state%answers(1)%maximum_pressure
      low = high * (1.0_real64 - 1.0e-14_real64)
    end do
  end subroutine hold_load

  !> The effect at work, nothing touched yet.
  subroutine start(solid, pairs, creep)
    !> what the bodies are made of
    type(standard_linear_solid), intent(in) :: solid
    !> the pairs
    type(contact_pairs), intent(in) :: pairs
    !> the effect
    class(contact_effect), allocatable, intent(out) :: creep

    call creep_of(solid, 1.0_real64, creep)
    call creep%begin(pairs)
  end subroutine start

  !> Creep as a scene names it.
  subroutine creep_of(solid, hold_time, creep)
    !> what the bodies are made of
    type(standard_linear_solid), intent(in) :: solid
    !> how long the last state is held
    real(real64), intent(in) :: hold_time
    !> the effect
    class(contact_effect), allocatable, intent(out) :: creep
    type(scene) :: scene_in

    call scene_in%effects%call_for('creep', effect_on)
    call set_number(scene_in, 'relaxed_modulus_ratio', solid%relaxed_ratio)
    call set_number(scene_in, 'relaxation_time', solid%relaxation_time)
    call set_number(scene_in, 'hold_time', hold_time)
    call new_creep(scene_in, creep)
  end subroutine creep_of

  !> A state of a hold.
  subroutine held_at(pairs, creep, closing, time, state, outcome, coupling)
    !> the pairs
    type(contact_pairs), intent(in) :: pairs
    !> the effect, with what it remembers
    class(contact_effect), intent(in) :: creep
    !> how far the surfaces are closed, and when
    real(real64), intent(in) :: closing, time
    !> the state
    type(contact_state), intent(out) :: state
    !> what the effect says of it
    type(effect_outcome), intent(out) :: outcome
    !> interaction of the contacts; each alone without it
    class(contact_effect), intent(in), optional :: coupling
    type(effect_outcome) :: coupled

    call start_state(pairs, hertz_law(modulus=1.0_real64), closing, state)
    state%time = time
    if (present(coupling)) call coupling%apply(pairs, state, coupled)
    call creep%apply(pairs, state, outcome)
  end subroutine held_at

  !> Aligned spheres with combined radii 1, 2 and 0.5.
  subroutine three_spheres(pairs)
    !> the pairs
    type(contact_pairs), intent(out) :: pairs

    allocate (pairs%list(3))
    pairs%list(1) = pair_of(2.0_real64, 2.0_real64, 0.0_real64)
    pairs%list(2) = pair_of(4.0_real64, 4.0_real64, 0.0_real64)
    pairs%list(3) = pair_of(1.0_real64, 1.0_real64, 0.0_real64)
    pairs%list%gap = [0.0_real64, 0.01_real64, 0.03_real64]
    pairs%modulus = 1.0_real64
  end subroutine three_spheres

end module asperity_creep_holds
