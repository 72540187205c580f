!> Solves the positions of a scene with its effects: its contacts, then the effects called for.
!>
!> Effects are computed in doubles. A position at which `auto` leaves all effects out is that of the
!> solver without effects, byte for byte.
module asperity_effect_solver
  use asperity_contact_effect, only: effect_box
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_records, only: position_result, solve_method
  use asperity_effect_list, only: list_effects
  use asperity_effect_position, only: run_position
  use asperity_effect_rows, only: add_nothing, name_columns
  use asperity_kernel_real64, only: empty_state, list_pairs, place_scene, placed_scene, &
                                    solve_position
  use asperity_kinds, only: int64
  use asperity_plastic_surface, only: surface_index
  use asperity_position_solver, only: position_solver
  use asperity_scene_results, only: effect_header
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: make_effect_solver

  !> A scene with effects, made ready.
  type, extends(position_solver) :: effect_solver
    private
    type(scene), pointer :: scene_in => null()
    type(placed_scene) :: placed
    type(effect_box), allocatable :: effects(:)  ! as they are before a position
  contains
    procedure :: solve => solve_with_effects  !! one position
  end type effect_solver

contains

  !> Makes a scene ready to be solved with its effects. `failure` is allocated when a number is out
  !> of range.
  subroutine make_effect_solver(scene_in, solver, header, failure)
    type(scene), intent(in), target :: scene_in            !! checked; must outlive the solver
    class(position_solver), allocatable, intent(out) :: solver
    type(effect_header), intent(out) :: header             !! what the effects tell
    character(len=:), allocatable, intent(out) :: failure  !! why not
    type(effect_solver), allocatable :: new

    allocate (new)
    new%scene_in => scene_in
    call list_effects(scene_in, new%effects)
    call name_columns(new%effects, header)
    header%tolerance = scene_in%effects%number('tolerance')
    if (any(header%names == 'plasticity')) header%plasticity_index = surface_index(scene_in)
    call place_scene(scene_in, new%placed, failure)
    if (allocated(failure)) return
    new%positions = new%placed%positions
    new%loads_differ = new%placed%loads_differ
    ! Effects take long: a few positions are worth a thread each.
    new%work = huge(new%work)
    call move_alloc(new, solver)
  end subroutine make_effect_solver

  ! One position: its pairs, its states, or the solver without effects where none was called for.
  subroutine solve_with_effects(self, m, keep_rows, result, failure)
    class(effect_solver), intent(in) :: self
    integer, intent(in) :: m
    logical, intent(in) :: keep_rows
    type(position_result), intent(out) :: result
    character(len=:), allocatable, intent(out) :: failure
    type(contact_pairs) :: pairs
    type(position_result) :: told
    type(effect_box), allocatable :: effects(:)
    logical :: simulated, too_far

    call list_pairs(self%placed, m, .false., pairs, failure)
    if (allocated(failure)) return
    if (size(pairs%list) == 0) then
      call copy_effects(self%effects, effects)
      call add_nothing(pairs, effects, result)
      result%x_displacement = pairs%x_displacement
      result%y_displacement = pairs%y_displacement
      call empty_state(self%placed, result, failure)
      return
    end if
    call try(too_far)
    if (too_far) then
      ! Pairs outside the candidate distance can matter: take all that can touch at all.
      call list_pairs(self%placed, m, .true., pairs, failure)
      if (.not. allocated(failure)) call try(too_far)
    end if
    if (allocated(failure) .or. simulated) return
    told = result
    call solve_position(self%placed, m, solve_method(), keep_rows, result, failure)
    call move_alloc(told%effects, result%effects)
    call move_alloc(told%contact_values, result%contact_values)
    call move_alloc(told%state_values, result%state_values)
    result%error_estimate = told%error_estimate

  contains

    ! With effects of its own.
    subroutine try(too_far)
      logical, intent(out) :: too_far

      call copy_effects(self%effects, effects)
      pairs%interrupt = self%interrupt
      call run_position(self%scene_in, pairs, effects, keep_rows, result, simulated, too_far, &
                        failure)
    end subroutine try

  end subroutine solve_with_effects

  ! Effects of one position: they remember.
  subroutine copy_effects(from, effects)
    type(effect_box), intent(in) :: from(:)
    type(effect_box), allocatable, intent(out) :: effects(:)
    integer :: i

    allocate (effects(size(from)))
    do i = 1, size(effects)
      allocate (effects(i)%effect, source=from(i)%effect)
    end do
  end subroutine copy_effects

end module asperity_effect_solver
