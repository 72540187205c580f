!> The one interface of all effects.
!>
!> An effect estimates, from what is cheap, how much it would change the total vertical load of a
!> state; when it is called for it changes the state. It knows its own numbers and nothing of the
!> others. What only it knows it hands over as named columns, so that writers need not know it.
module asperity_contact_effect
  use asperity_contact_law, only: contact_law
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_records, only: effect_record
  use asperity_contact_state, only: contact_state
  use asperity_kinds, only: real64
  use asperity_scene_values, only: effect_off
  implicit none
  private

  public :: contact_effect, effect_box, effect_outcome, column_name, set_columns

  !> Length of the name of a column.
  integer, parameter, private :: name_length = 20

  !> The name of a column of a CSV file.
  type :: column_name
    character(len=name_length) :: text = ''   !! as in the header
    integer :: modulus_power = 0              !! its unit holds the modulus to this power
    integer :: length_power = 0               !! and the length to this
    !> What it is where `auto` left the effect out: this times the vertical load, plus ...
    real(real64) :: of_load = 0.0_real64
    real(real64) :: otherwise = 0.0_real64    !! ... this
  end type column_name

  !> What one effect did to one state, and what it tells of it.
  type, extends(effect_record) :: effect_outcome
    character(len=:), allocatable :: failure      !! why it could not be simulated
    real(real64), allocatable :: of_contacts(:, :)  !! (pair, column), in the unit of the pairs
    real(real64), allocatable :: of_state(:)        !! (column), in the unit of the pairs
  end type effect_outcome

  !> An effect that a scene names.
  type, abstract :: contact_effect
    character(len=11) :: name = ''                      !! as in &effects
    integer :: mode = effect_off                        !! as in &effects
    real(real64) :: tolerance = 0.0_real64              !! share of the load that may be left out
    real(real64) :: load_tolerance = 1.0e-11_real64     !! how near a load asked for is met
    !> Where a load is reached; not associated: it knows no short way.
    procedure(find_closing), pointer :: closing_at_load => null()
    !> What is left of a load at a time, as a share of that at the same closing without this
    !> effect, when all contacts together are held at one load; associated: it acts in time.
    procedure(share_at_time), pointer :: held_share => null()
    !> Tells its columns again, when the effects after it have changed the state.
    procedure(apply_effect), pointer :: finish => null()
    !> Forgets the position before; not associated: it remembers nothing.
    procedure(begin_position), pointer :: begin => null()
    !> Keeps what the next state of the position needs to know of this one.
    procedure(keep_state), pointer :: keep => null()
    type(column_name), allocatable :: contact_columns(:)  !! what it tells of a contact
    type(column_name), allocatable :: state_columns(:)    !! what it tells of a position
  contains
    procedure(estimate_influence), deferred :: estimate  !! what it would change, cheaply
    procedure(apply_effect), deferred :: apply           !! changes the state
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

    !> A share that depends on time alone.
    function share_at_time(self, time) result(share)
      import :: contact_effect, real64
      implicit none
      class(contact_effect), intent(in) :: self  !! the effect
      real(real64), intent(in) :: time           !! since the end of loading
      real(real64) :: share
    end function share_at_time

    !> Begins a position at which nothing has touched yet.
    subroutine begin_position(self, pairs)
      import :: contact_effect, contact_pairs
      implicit none
      class(contact_effect), intent(inout) :: self  !! the effect
      type(contact_pairs), intent(in) :: pairs      !! the position
    end subroutine begin_position

    !> Keeps a state as the past of those that follow.
    subroutine keep_state(self, pairs, state)
      import :: contact_effect, contact_pairs, contact_state
      implicit none
      class(contact_effect), intent(inout) :: self  !! the effect
      type(contact_pairs), intent(in) :: pairs      !! the position
      type(contact_state), intent(in) :: state      !! all effects applied
    end subroutine keep_state

    !> Changes a closing to that at which the contacts with this effect alone carry a load; leaves
    !> it where the effect is not called for.
    subroutine find_closing(self, pairs, law, target, closing, found, failure)
      import :: contact_effect, contact_law, contact_pairs, real64
      implicit none
      class(contact_effect), intent(in) :: self                 !! the effect
      type(contact_pairs), intent(in) :: pairs                  !! the position
      class(contact_law), intent(in) :: law                     !! of every contact
      real(real64), intent(in) :: target                        !! sum of the normal forces
      real(real64), intent(inout) :: closing                    !! past first touch
      !> what the effect wants to know again when it acts there (pair, quantity); else as it was
      real(real64), allocatable, intent(inout) :: found(:, :)
      character(len=:), allocatable, intent(inout) :: failure   !! why the load cannot be reached
    end subroutine find_closing
  end interface

contains

  !> The names of columns, in one go; `of_what` is a power of the modulus and one of the length
  !> for each.
  pure subroutine set_columns(columns, names, of_what)
    type(column_name), allocatable, intent(out) :: columns(:)  !! one a name
    character(len=*), intent(in) :: names(:)                   !! as in the header
    integer, intent(in) :: of_what(:, :)                       !! (2, name)

    allocate (columns(size(names)))
    columns%text = names
    columns%modulus_power = of_what(1, :)
    columns%length_power = of_what(2, :)
  end subroutine set_columns

end module asperity_contact_effect
