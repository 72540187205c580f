!> An effect that no release has: what it takes to write one, through the public interface alone.
!>
!> Every contact carries a share more than its law states, and that share again for each state kept
!> before.
module asperity_made_up_effect
  use asperity_contact_effect, only: contact_effect, effect_outcome, force, length, plain
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: contact_state
  use asperity_kinds, only: not_computed, real64
  implicit none
  private

  public :: made_up_effect, make_up

  !> It overrides what remembers; `finish` stays.
  type, extends(contact_effect) :: made_up_effect
    real(real64) :: share = 0.0_real64  !! more load, once and for each state kept
    integer :: kept = 0                 !! states since the position began
  contains
    procedure :: estimate
    procedure :: apply
    procedure :: leave_out
    procedure :: begin
    procedure :: keep
  end type made_up_effect

contains

  !> The effect, ready for a list.
  subroutine make_up(mode, share, tolerance, effect)
    integer, intent(in) :: mode  !! one of the `effect_` numbers
    real(real64), intent(in) :: share, tolerance  !! more load, and what may be left out of it
    class(contact_effect), allocatable, intent(out) :: effect  !! the effect
    type(made_up_effect) :: new

    new%name = 'made_up'
    new%mode = mode
    new%tolerance = tolerance
    new%share = share
    allocate (effect, source=new)
  end subroutine make_up

  !> The share itself.
  function estimate(self, pairs, state) result(share)
    class(made_up_effect), intent(in) :: self  !! the effect
    type(contact_pairs), intent(in) :: pairs   !! the position
    type(contact_state), intent(in) :: state   !! without this effect
    real(real64) :: share

    share = 0.0_real64
    if (size(pairs%list) > 0 .and. allocated(state%answers)) share = self%share * (1 + self%kept)
  end function estimate

  !> Multiplies the loads. Columns: what is added to each, and its penetration; the vertical load
  !> before, and how many states were kept.
  subroutine apply(self, pairs, state, outcome)
    class(made_up_effect), intent(in) :: self       !! the effect
    type(contact_pairs), intent(in) :: pairs        !! the position
    type(contact_state), intent(inout) :: state     !! without, then with this effect
    type(effect_outcome), intent(inout) :: outcome  !! what it did
    real(real64) :: factor

    factor = 1.0_real64 + self%estimate(pairs, state)
    call add_columns(outcome, (factor - 1.0_real64) * state%answers%load, state%penetration, &
                     sum(state%answers%vertical_load), real(self%kept, real64))
    state%answers%load = factor * state%answers%load
    state%answers%vertical_load = factor * state%answers%vertical_load
    outcome%simulated = 'on'
  end subroutine apply

  !> Columns without values.
  subroutine leave_out(self, pairs, state, outcome)
    class(made_up_effect), intent(in) :: self       !! the effect
    type(contact_pairs), intent(in) :: pairs        !! the position
    type(contact_state), intent(in) :: state        !! without this effect
    type(effect_outcome), intent(inout) :: outcome  !! gets the columns

    associate (unused => self, unused_too => state, &
               none => spread(not_computed, 1, size(pairs%list)))
      call add_columns(outcome, none, none, not_computed, not_computed)
    end associate
  end subroutine leave_out

  ! Adds the columns.
  subroutine add_columns(outcome, added, depth, bare, kept)
    type(effect_outcome), intent(inout) :: outcome
    real(real64), intent(in) :: added(:), depth(:), bare, kept

    call outcome%of_contacts%add('added_load', force, added)
    call outcome%of_contacts%add('depth', length, depth)
    call outcome%of_state%add('bare_load', force, bare)
    call outcome%of_state%add('kept', plain, kept)
  end subroutine add_columns

  !> Nothing was kept yet.
  subroutine begin(self, pairs)
    class(made_up_effect), intent(inout) :: self  !! the effect
    type(contact_pairs), intent(in) :: pairs      !! the position

    self%kept = 0 * size(pairs%list)
  end subroutine begin

  !> Counts a state.
  subroutine keep(self, pairs, state)
    class(made_up_effect), intent(inout) :: self  !! the effect
    type(contact_pairs), intent(in) :: pairs      !! the position
    type(contact_state), intent(in) :: state      !! all effects applied

    if (size(state%answers) == size(pairs%list)) self%kept = self%kept + 1
  end subroutine keep

end module asperity_made_up_effect
