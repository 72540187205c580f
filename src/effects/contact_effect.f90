!> The one interface of all effects.
!>
!> An effect estimates, from what is cheap, how much it would change the total vertical load of a
!> state; when it is called for it changes the state. It knows its own numbers and nothing of the
!> others. What only it knows it hands over as named columns, so that writers need not know it.
!>
!> `estimate` and `apply` must be written for each; the other procedures have a default, which does
!> nothing. An effect that remembers overrides `begin` and `keep`; one that acts while load or
!> approach is held sets `acts_in_time` and overrides `held_share`; one that knows some of its
!> columns without being simulated, `leave_out`; one whose columns depend on what later effects do,
!> `finish`; one that knows a short way to a load, `closing_at_load`; one that attracts,
!> `letting_go`.
module asperity_contact_effect
  use asperity_contact_law, only: contact_law
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_records, only: effect_record
  use asperity_contact_state, only: contact_state
  use asperity_effect_names, only: known_effects
  use asperity_kinds, only: real64
  use asperity_scene_values, only: by_word, effect_off, scene_effects
  use asperity_theory_warnings, only: theory_warning
  implicit none
  private

  public :: contact_effect, effect_box, effect_outcome
  public :: column_name, column, plain, length, force, moment

  !> The unit of a column is the modulus to the first power and the length to the second: a plain
  !> number, a length, a force, a moment or an energy.
  integer, parameter :: plain(2) = [0, 0], length(2) = [0, 1], force(2) = [1, 2], moment(2) = [1, 3]

  !> The name of a column of a CSV file, and its unit.
  type :: column_name
    character(len=20) :: text = ''            !! its name, as in the header
    integer :: modulus_power = 0              !! its unit holds the modulus to this power
    integer :: length_power = 0               !! and the length to this
  end type column_name

  !> Outcome of one effect in one state: its change of the state, and the values of its columns.
  type, extends(effect_record) :: effect_outcome
    character(len=:), allocatable :: failure      !! why it could not be simulated
    real(real64), allocatable :: of_contacts(:, :)  !! (pair, column), in the unit of the pairs
    real(real64), allocatable :: of_state(:)        !! (column), in the unit of the pairs
    type(theory_warning), allocatable :: warnings(:)  !! what of it lies outside its theory
  end type effect_outcome

  !> An effect that a scene names.
  type, abstract :: contact_effect
    character(len=11) :: name = ''                      !! as in &effects
    integer :: mode = effect_off                        !! as in &effects
    integer :: given = by_word                          !! by what: one of the `by_` numbers
    real(real64) :: tolerance = 0.0_real64              !! share that all may leave out together
    real(real64) :: load_tolerance = 1.0e-11_real64     !! how near a load asked for is met
    logical :: acts_in_time = .false.                   !! acts while load or approach is held
    logical :: approximates = .false.                   !! its `auto` leaves something out itself
    type(column_name), allocatable :: contact_columns(:)  !! its columns of a contact
    type(column_name), allocatable :: state_columns(:)    !! its columns of a position
  contains
    procedure(estimate_influence), deferred :: estimate  !! what it would change, cheaply
    procedure(apply_effect), deferred :: apply           !! changes the state
    procedure :: begin            !! forgets the position before
    procedure :: keep             !! remembers a state for those that follow
    procedure :: leave_out        !! sets its columns where `auto` left it out
    procedure :: finish           !! sets its columns again, after all effects
    procedure :: held_share       !! what it leaves of a load that is held
    procedure :: closing_at_load  !! where a load is reached
    procedure :: letting_go       !! where contacts part that were held by attraction
    procedure, non_overridable :: call_as  !! name, mode and tolerance
  end type contact_effect

  !> One effect of a list.
  type :: effect_box
    class(contact_effect), allocatable :: effect  !! the effect
  end type effect_box

  abstract interface
    !> Estimated change of the total vertical load, as a share of it; not below the true one as
    !> long as both are small.
    function estimate_influence(self, pairs, state) result(share)
      import :: contact_effect, contact_pairs, contact_state, real64
      implicit none
      class(contact_effect), intent(in) :: self  !! the effect
      type(contact_pairs), intent(in) :: pairs   !! the position
      type(contact_state), intent(in) :: state   !! without this effect
      real(real64) :: share
    end function estimate_influence

    !> Simulates the effect. `outcome%failure` is allocated when that cannot be done.
    subroutine apply_effect(self, pairs, state, outcome)
      import :: contact_effect, contact_pairs, contact_state, effect_outcome
      implicit none
      class(contact_effect), intent(in) :: self       !! the effect
      type(contact_pairs), intent(in) :: pairs        !! the position
      type(contact_state), intent(inout) :: state     !! without, then with this effect
      type(effect_outcome), intent(inout) :: outcome  !! what it did
    end subroutine apply_effect
  end interface

contains

  !> A column: its name and its unit.
  pure type(column_name) function column(name, unit)
    character(len=*), intent(in) :: name  !! as in the header
    integer, intent(in) :: unit(2)        !! `plain`, `length`, `force` or `moment`

    column%text = name
    column%modulus_power = unit(1)
    column%length_power = unit(2)
  end function column

  !> Name, mode and tolerance, as the scene has them.
  subroutine call_as(self, name, effects)
    class(contact_effect), intent(inout) :: self  !! the effect
    character(len=*), intent(in) :: name          !! as in &effects
    type(scene_effects), intent(in) :: effects    !! of the scene

    self%name = name
    self%mode = effects%mode(name)
    self%given = effects%given(findloc(known_effects%name, name, 1))
    self%tolerance = effects%number('tolerance')
  end subroutine call_as

  !> Begins a position at which nothing has touched yet. Here: there is nothing to forget.
  subroutine begin(self, pairs)
    class(contact_effect), intent(inout) :: self  !! the effect
    type(contact_pairs), intent(in) :: pairs      !! the position

    associate (unused => self, unused_too => pairs)
    end associate
  end subroutine begin

  !> Keeps a state as the past of those that follow. Here: nothing is remembered.
  subroutine keep(self, pairs, state)
    class(contact_effect), intent(inout) :: self  !! the effect
    type(contact_pairs), intent(in) :: pairs      !! the position
    type(contact_state), intent(in) :: state      !! all effects applied

    associate (unused => self, unused_too => pairs, unused_also => state)
    end associate
  end subroutine keep

  !> Sets the columns that need no simulation where `auto` left the effect out. This default sets
  !> none: the values of the columns are empty.
  subroutine leave_out(self, pairs, state, outcome)
    class(contact_effect), intent(in) :: self       !! the effect
    type(contact_pairs), intent(in) :: pairs        !! the position
    type(contact_state), intent(in) :: state        !! without this effect
    type(effect_outcome), intent(inout) :: outcome  !! gets the columns

    associate (unused => self, unused_too => pairs, unused_also => state, as_it_is => outcome)
    end associate
  end subroutine leave_out

  !> Sets the columns again when later effects have changed the state, also where this effect was
  !> left out. This default leaves them unchanged.
  subroutine finish(self, pairs, state, outcome)
    class(contact_effect), intent(in) :: self       !! the effect
    type(contact_pairs), intent(in) :: pairs        !! the position
    type(contact_state), intent(in) :: state        !! all effects applied
    type(effect_outcome), intent(inout) :: outcome  !! what it did

    associate (unused => self, unused_too => pairs, unused_also => state, as_it_is => outcome)
    end associate
  end subroutine finish

  !> What is left of a load at a time, as a share of that at the same closing without this effect,
  !> when all contacts together are held at one load. Here: all of it.
  function held_share(self, time) result(share)
    class(contact_effect), intent(in) :: self  !! the effect
    real(real64), intent(in) :: time           !! since the end of loading
    real(real64) :: share

    associate (unused => self, unused_too => time)
    end associate
    share = 1.0_real64
  end function held_share

  !> Changes a closing to that at which the contacts with this effect alone carry a load. Here: no
  !> way is known, it stays.
  subroutine closing_at_load(self, pairs, law, target, left, closing, found, failure)
    class(contact_effect), intent(in) :: self                 !! the effect
    type(contact_pairs), intent(in) :: pairs                  !! the position
    class(contact_law), intent(in) :: law                     !! of every contact
    real(real64), intent(in) :: target                        !! sum of the normal forces
    real(real64), intent(in) :: left                          !! of the tolerance, for this effect
    real(real64), intent(inout) :: closing                    !! past first touch
    !> what the effect wants to know again when it acts there (pair, quantity); else as it was
    real(real64), allocatable, intent(inout) :: found(:, :)
    character(len=:), allocatable, intent(inout) :: failure   !! why the load cannot be reached

    associate (unused => self, unused_too => pairs, unused_also => law, load => target, &
               share => left, as_it_is => closing)
      if (allocated(found) .or. allocated(failure)) return
    end associate
  end subroutine closing_at_load

  !> Closings below which a contact parts that attraction holds, one for each that may pull; the
  !> load jumps there. Here: nothing attracts.
  subroutine letting_go(self, pairs, closings)
    class(contact_effect), intent(in) :: self                 !! the effect
    type(contact_pairs), intent(in) :: pairs                  !! the position
    real(real64), allocatable, intent(out) :: closings(:)     !! none, or one for each pair

    associate (unused => self, unused_too => pairs)
    end associate
    allocate (closings(0))
  end subroutine letting_go

end module asperity_contact_effect
