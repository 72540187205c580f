!> The one interface of all effects.
!>
!> An effect estimates at low cost how much it changes the total vertical load of a state; where it
!> is simulated it changes the state. Its own quantities are columns that are added with name, unit
!> and value in one call, so that writers need no knowledge of the effect.
!>
!> `estimate`, `apply` and `leave_out` are deferred; the defaults of the other procedures change
!> nothing. An effect with a memory overrides `begin` and `keep`; one that acts during a hold sets
!> `acts_in_time` and overrides `held_share`; one with columns that later effects change, `finish`.
module asperity_contact_effect
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_records, only: effect_record
  use asperity_contact_state, only: contact_state
  use asperity_effect_header, only: column_list, column_name, force, length, moment, plain
  use asperity_kinds, only: not_computed, real64
  use asperity_scene_values, only: effect_off, scene_effects
  use asperity_theory_warnings, only: theory_warning
  implicit none
  private

  public :: contact_effect, effect_box, effect_outcome
  public :: relative_influence
  public :: column_name, plain, length, force, moment

  !> Outcome of one effect in one state: its change of the state, and the values of its columns.
  type, extends(effect_record) :: effect_outcome
    character(len=:), allocatable :: failure      !! error message; not allocated: simulated
    real(real64) :: load_jump = 0.0_real64   !! jumps of the load with the compression, relative
    real(real64) :: dissipated_work = not_computed  !! since first touch, in the unit of the pairs
    type(column_list) :: of_contacts  !! columns of a row a pair, in the unit of the pairs
    type(column_list) :: of_state     !! columns of one row, in the unit of the pairs
    type(theory_warning), allocatable :: warnings(:)  !! where it is outside its theory
  end type effect_outcome

  !> An effect that a scene names.
  type, abstract :: contact_effect
    character(len=11) :: name = ''                      !! name of the effect in &effects
    integer :: mode = effect_off                        !! mode of the effect in &effects
    real(real64) :: tolerance = 0.0_real64              !! share that all may leave out together
    logical :: acts_in_time = .false.                   !! acts while load or separation is held
    logical :: approximates = .false.                   !! its `auto` is an approximation itself
    real(real64) :: reach = 0.0_real64                  !! gap from which it attracts, scene's unit
  contains
    procedure(estimate_influence), deferred :: estimate  !! influence on the load
    procedure(apply_effect), deferred :: apply           !! changes the state
    procedure :: begin => begin_position   !! clears the memory of the last position
    procedure :: keep => keep_state        !! keeps a state for the next ones of the position
    procedure(leave_out_effect), deferred :: leave_out  !! adds its columns where it is left out
    procedure :: finish => finish_columns  !! adds columns after all effects
    procedure :: held_share                !! share of the load that remains in a hold
    procedure, non_overridable :: call_as  !! sets name, mode and tolerance
  end type contact_effect

  !> One effect of a list.
  type :: effect_box
    class(contact_effect), allocatable :: effect  !! effect of any type
  end type effect_box

  abstract interface
    !> Estimated change of the total vertical load, or of the area if that is larger, as
    !> `relative_influence` defines it; an upper bound while it is small.
    function estimate_influence(self, pairs, state) result(share)
      import :: contact_effect, contact_pairs, contact_state, real64
      implicit none
      class(contact_effect), intent(in) :: self  !! effect with its parameters
      type(contact_pairs), intent(in) :: pairs   !! pairs of the position
      type(contact_state), intent(in) :: state   !! contacts without this effect
      real(real64) :: share
    end function estimate_influence

    !> Simulates the effect. `outcome%failure` is allocated where that is impossible.
    subroutine apply_effect(self, pairs, state, outcome)
      import :: contact_effect, contact_pairs, contact_state, effect_outcome
      implicit none
      class(contact_effect), intent(in) :: self       !! effect with its parameters
      type(contact_pairs), intent(in) :: pairs        !! pairs of the position
      type(contact_state), intent(inout) :: state     !! contacts without, then with this effect
      type(effect_outcome), intent(inout) :: outcome  !! columns, influence, warnings
    end subroutine apply_effect

    !> Adds the columns of `apply` where the effect is left out, empty where they need simulation.
    subroutine leave_out_effect(self, pairs, state, outcome)
      import :: contact_effect, contact_pairs, contact_state, effect_outcome
      implicit none
      class(contact_effect), intent(in) :: self       !! effect with its parameters
      type(contact_pairs), intent(in) :: pairs        !! pairs of the position
      type(contact_state), intent(in) :: state        !! contacts without this effect
      type(effect_outcome), intent(inout) :: outcome  !! gets the columns
    end subroutine leave_out_effect
  end interface

contains

  !> Change of a total by an effect relative to the total with the effect, as the tolerance bounds
  !> the error of a result without it. Where the total falls below half, half of it is the
  !> reference: a share of 1 and more is above any tolerance and is an order of magnitude.
  elemental real(real64) function relative_influence(change, without, with)
    real(real64), intent(in) :: change   !! absolute change of the total, or its bound
    real(real64), intent(in) :: without  !! total without the effect, > 0
    real(real64), intent(in) :: with     !! total with the effect

    relative_influence = change / max(with, 0.5_real64 * without)
  end function relative_influence

  !> Sets name, mode and tolerance of an effect from the scene.
  subroutine call_as(self, name, effects)
    class(contact_effect), intent(inout) :: self  !! effect to be set
    character(len=*), intent(in) :: name          !! name of the effect in &effects
    type(scene_effects), intent(in) :: effects    !! effects of the scene

    self%name = name
    self%mode = effects%mode(name)
    self%tolerance = effects%number('tolerance')
  end subroutine call_as

  !> Begins a position without any contact so far. This default has no memory to clear.
  subroutine begin_position(self, pairs)
    class(contact_effect), intent(inout) :: self  !! effect, whose memory is cleared
    type(contact_pairs), intent(in) :: pairs      !! pairs of the position

    associate (unused => self, unused_too => pairs)
    end associate
  end subroutine begin_position

  !> Keeps a state as the history of the next ones. This default has no memory.
  subroutine keep_state(self, pairs, state)
    class(contact_effect), intent(inout) :: self  !! effect, whose memory is set
    type(contact_pairs), intent(in) :: pairs      !! pairs of the position
    type(contact_state), intent(in) :: state      !! contacts with all effects

    associate (unused => self, unused_too => pairs, unused_also => state)
    end associate
  end subroutine keep_state

  !> Adds columns when later effects have changed the state, also where this effect is left out.
  !> This default adds none.
  subroutine finish_columns(self, pairs, state, outcome)
    class(contact_effect), intent(in) :: self       !! effect with its parameters
    type(contact_pairs), intent(in) :: pairs        !! pairs of the position
    type(contact_state), intent(in) :: state        !! contacts with all effects
    type(effect_outcome), intent(inout) :: outcome  !! gets the columns

    associate (unused => self, unused_too => pairs, unused_also => state, as_it_is => outcome)
    end associate
  end subroutine finish_columns

  !> Total load at a time of a hold of the load, over the load without this effect at the same
  !> compression. This default: 1.
  function held_share(self, time) result(share)
    class(contact_effect), intent(in) :: self  !! effect with its parameters
    real(real64), intent(in) :: time           !! time since the begin of loading
    real(real64) :: share

    associate (unused => self, unused_too => time)
    end associate
    share = 1.0_real64
  end function held_share

end module asperity_contact_effect
