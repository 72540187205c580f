!> The one interface of all effects on the pixels of a height map.
!>
!> A law estimates its influence from a state without it; where it is simulated it changes the
!> elastic problem of a state, may solve it, and keeps what the state leaves to the next one. Its
!> columns are added with name, unit and value in one call.
!>
!> `estimate` and `add_columns` are deferred. A law with tractions that depend on the gap sets
!> `solves` and overrides `act`; one with a memory `begin_step` and `end_step`; one with results of
!> contact patches or fields, `finish`.
module asperity_pixel_law
  use asperity_contact_field, only: contact_field
  use asperity_contact_records, only: state_row
  use asperity_effect_header, only: column_list
  use asperity_height_map, only: height_map
  use asperity_kinds, only: real64
  use asperity_map_contact, only: map_answer
  use asperity_map_patches, only: find_patches, map_patch
  use asperity_scene_values, only: effect_auto, effect_off, scene_effects
  use asperity_theory_warnings, only: theory_warning
  implicit none
  private

  public :: patches_in_contact, pixel_law, pixel_law_box, pixel_state, unknown_influence

  real(real64), parameter :: unknown_influence = huge(1.0_real64)  !! no estimate can be made

  !> One state of a map: the elastic problem that the laws make of it, and its solution.
  type :: pixel_state
    real(real64) :: modulus = 0.0_real64      !! instantaneous combined modulus, > 0
    real(real64) :: time = 0.0_real64         !! time since the begin of loading
    real(real64), allocatable :: load         !! prescribed; not allocated: the level of `answer`
    real(real64), allocatable :: tolerance    !! as of `press_map` or `adhere_map`; else the least
    type(height_map) :: deformed              !! the map with its plastic deformation
    type(height_map) :: problem_map           !! map of the elastic problem
    real(real64) :: problem_modulus = 0.0_real64  !! modulus of the elastic problem
    real(real64), allocatable :: hardness     !! largest net traction; not allocated: elastic
    type(map_answer) :: answer                !! solution; before the solve that of the last state
    type(map_patch), allocatable :: patches(:)  !! contact patches of the solution
    integer :: number = 1                     !! of the state, from 1
    real(real64) :: largest_load = 0.0_real64  !! of the states so far, 0 or more
  end type pixel_state

  !> An effect on pixels.
  type, abstract :: pixel_law
    character(len=11) :: name = ''            !! name of the effect in &effects
    integer :: mode = effect_off              !! mode of the effect in &effects
    real(real64) :: tolerance = 0.0_real64    !! share that all may leave out together
    logical :: is_simulated = .false.         !! it acts on the states of this path
    logical :: is_free = .false.              !! `auto` simulates it: that costs no solve
    logical :: acts_in_time = .false.         !! acts while load or separation is held
    logical :: solves = .false.               !! `act` solves the elastic problem
    logical :: shapes = .true.                !! it changes pressures and gaps
    real(real64) :: hardness = 0.0_real64     !! largest net traction by this law; 0: none
    !> Why it cannot be simulated; not allocated: it can.
    character(len=:), allocatable :: obstacle
  contains
    procedure(estimate_on_pixels), deferred :: estimate
    procedure(add_pixel_columns), deferred :: add_columns
    procedure :: add_contact_columns
    procedure :: fill_row
    procedure :: begin_step
    procedure :: act => act_on_state
    procedure :: end_step
    procedure :: finish => finish_last_state
    procedure :: add_warnings
    procedure :: coarsen => coarsen_pixels
    procedure :: why_unknown
    procedure, non_overridable :: call_as
  end type pixel_law

  !> One law of a list.
  type :: pixel_law_box
    class(pixel_law), allocatable :: law  !! law of any type
  end type pixel_law_box

  abstract interface
    !> Estimated change of the load, or of the area if that is larger, as `relative_influence`
    !> defines it, in a state without it; `unknown_influence` where no estimate can be made.
    function estimate_on_pixels(self, state) result(share)
      import :: pixel_law, pixel_state, real64
      implicit none
      class(pixel_law), intent(in) :: self    !! law with its parameters
      type(pixel_state), intent(in) :: state  !! solution without this law
      real(real64) :: share
    end function estimate_on_pixels

    !> Adds the columns of a position; where the law is left out their values are not used.
    subroutine add_pixel_columns(self, state, columns)
      import :: column_list, pixel_law, pixel_state
      implicit none
      class(pixel_law), intent(in) :: self          !! law with its memory
      type(pixel_state), intent(in) :: state        !! last state of the path
      type(column_list), intent(inout) :: columns   !! gets the columns
    end subroutine add_pixel_columns
  end interface

contains

  !> Sets name, mode and tolerance of a law from the scene. What is `on`, and what is free, is
  !> simulated from the first state on.
  subroutine call_as(self, name, effects)
    class(pixel_law), intent(inout) :: self      !! law to be set
    character(len=*), intent(in) :: name         !! name of the effect in &effects
    type(scene_effects), intent(in) :: effects   !! effects of the scene

    self%name = name
    self%mode = effects%mode(name)
    self%tolerance = effects%number('tolerance')
    self%is_simulated = self%mode /= effect_off .and. .not. allocated(self%obstacle) .and. &
                        (self%is_free .or. self%mode /= effect_auto)
  end subroutine call_as

  !> Finds the patches of the pressure in contact, which beside an attraction is at most the
  !> hardness and that attraction.
  subroutine patches_in_contact(map, answer, patches, hardness)
    type(height_map), intent(in) :: map             !! map without deformation
    type(map_answer), intent(in) :: answer          !! solution of the state
    type(map_patch), allocatable, intent(out) :: patches(:)
    real(real64), intent(in), optional :: hardness  !! largest net traction; absent: elastic
    real(real64), allocatable :: limit

    if (present(hardness)) limit = hardness + answer%attraction
    if (allocated(answer%contact_pressure)) then
      call find_patches(map, answer%contact_pressure, patches, hardness=limit)
    else
      call find_patches(map, answer%pressure, patches, hardness=limit)
    end if
  end subroutine patches_in_contact

  !> Changes the elastic problem of the next state. This default changes nothing.
  subroutine begin_step(self, state)
    class(pixel_law), intent(inout) :: self     !! law with the memory of the last state
    type(pixel_state), intent(inout) :: state   !! gets hardness, map and modulus of the problem

    associate (unused => self, unused_too => state)
    end associate
  end subroutine begin_step

  !> Solves the elastic problem with the tractions of the law. This default solves nothing.
  subroutine act_on_state(self, state)
    class(pixel_law), intent(inout) :: self     !! law with the memory of the last state
    type(pixel_state), intent(inout) :: state   !! problem; gets the solution or its failure

    associate (unused => self, unused_too => state)
    end associate
  end subroutine act_on_state

  !> Keeps what the solution leaves to the next state. This default keeps nothing.
  subroutine end_step(self, state)
    class(pixel_law), intent(inout) :: self     !! law; gets the memory of this state
    type(pixel_state), intent(inout) :: state   !! solution of the problem; gets that of the map

    associate (unused => self, unused_too => state)
    end associate
  end subroutine end_step

  !> Sets what a state has in its row. This default sets nothing.
  subroutine fill_row(self, state, row)
    class(pixel_law), intent(in) :: self        !! law with its memory
    type(pixel_state), intent(in) :: state      !! solution of the state
    type(state_row), intent(inout) :: row       !! gets its values

    associate (unused => self, unused_too => state, as_it_is => row)
    end associate
  end subroutine fill_row

  !> Adds the columns of the contact patches of the last state. This default has none.
  subroutine add_contact_columns(self, state, columns)
    class(pixel_law), intent(in) :: self          !! law with its memory
    type(pixel_state), intent(in) :: state        !! last state of the path
    type(column_list), intent(inout) :: columns   !! gets the columns

    associate (unused => self, unused_too => state, as_it_is => columns)
    end associate
  end subroutine add_contact_columns

  !> Computes what needs the last state alone. This default computes nothing.
  subroutine finish_last_state(self, state, field, failure)
    class(pixel_law), intent(inout) :: self    !! law; gets the results
    type(pixel_state), intent(in) :: state     !! last state of the path
    type(contact_field), intent(inout), optional :: field  !! its fields, where they are kept
    character(len=:), allocatable, intent(inout) :: failure  !! reason, when it is not solved

    associate (unused => self, unused_too => state, unused_also => field, as_it_is => failure)
    end associate
  end subroutine finish_last_state

  !> Adds the warnings of a state. This default has none.
  subroutine add_warnings(self, state, warnings)
    class(pixel_law), intent(in) :: self        !! law with its memory
    type(pixel_state), intent(in) :: state      !! solution of the state
    type(theory_warning), allocatable, intent(inout) :: warnings(:)  !! of the state

    associate (unused => self, unused_too => state, as_it_is => warnings)
    end associate
  end subroutine add_warnings

  !> Prepares a copy of the law for every second pixel of the last state, or removes its part from
  !> the state where the elastic problem has the same errors. This default keeps the law.
  subroutine coarsen_pixels(self, columns, rows, state)
    class(pixel_law), intent(inout) :: self     !! simulated law; not simulated: it is removed
    integer, intent(in) :: columns(:), rows(:)  !! those of every second pixel
    type(pixel_state), intent(inout) :: state   !! solution on all pixels

    associate (unused => self, unused_too => columns, unused_also => rows, as_it_is => state)
    end associate
  end subroutine coarsen_pixels

  !> Why coarser pixels do not estimate the error of a state; blank: they do, as by default.
  function why_unknown(self, state, is_alone) result(reason)
    class(pixel_law), intent(in) :: self         !! law that is simulated
    type(pixel_state), intent(in) :: state       !! a state of the path
    logical, intent(in) :: is_alone              !! no other law changes pressures
    character(len=48) :: reason                  !! `error estimate: none with` it

    associate (unused => self, unused_too => state, unused_also => is_alone)
    end associate
    reason = ''
  end function why_unknown

end module asperity_pixel_law
