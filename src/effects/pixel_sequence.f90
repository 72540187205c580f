!> The effects of one state on the pixels of a map, one after the other.
!>
!> The laws change the elastic problem of a state, one of them or `map_contact` solves it, and they
!> keep in the opposite order what the solution leaves to the next state.
module asperity_pixel_sequence
  use asperity_effect_header, only: column_list
  use asperity_effect_sequence, only: leave_smallest
  use asperity_height_map, only: copy_map, height_map, move_map
  use asperity_kinds, only: real64
  use asperity_map_contact, only: press_map
  use asperity_map_interface, only: add_interface
  use asperity_map_top, only: find_top, first_contact
  use asperity_pixel_law, only: pixel_law_box, pixel_state
  use asperity_scene_values, only: effect_auto
  implicit none
  private

  public :: add_state_interface, choose_laws, solve_pixel_state

contains

  !> Solves a state at a load, or at the level of its answer, with the simulated laws.
  !> `state%answer%failure` is allocated where the load is not carried.
  subroutine solve_pixel_state(laws, state)
    type(pixel_law_box), intent(inout) :: laws(:)  !! laws with the memory of the state before
    type(pixel_state), intent(inout) :: state      !! state before; becomes this state
    integer :: i, solver
    logical :: is_elastic

    ! Laws may change the map of the problem; without them one map is enough.
    is_elastic = .not. any([(laws(i)%law%is_simulated, i=1, size(laws))])
    if (is_elastic) then
      call move_map(state%deformed, state%problem_map)
    else
      call copy_map(state%deformed, state%problem_map, state%answer%failure)
    end if
    if (allocated(state%answer%failure)) return
    state%problem_modulus = state%modulus
    if (allocated(state%hardness)) deallocate (state%hardness)
    solver = 0
    do i = 1, size(laws)
      if (.not. laws(i)%law%is_simulated) cycle
      call laws(i)%law%begin_step(state)
      if (laws(i)%law%solves) solver = i
    end do
    if (solver > 0) then
      call laws(solver)%law%act(state)
    else
      call press_state(state)
    end if
    if (is_elastic) call move_map(state%problem_map, state%deformed)
    call free_map(state%problem_map)
    if (allocated(state%answer%failure)) return
    do i = size(laws), 1, -1
      if (laws(i)%law%is_simulated) call laws(i)%law%end_step(state)
    end do
  end subroutine solve_pixel_state

  ! Frees a map: the next state makes its own. (gfortran 12 leaves it when the state is freed.)
  subroutine free_map(map)
    type(height_map), intent(out) :: map

    map%columns = 0
  end subroutine free_map

  ! Solves the elastic problem. Under no load the surfaces are at first contact, or where pixels
  ! that the hardness has lowered touch.
  subroutine press_state(state)
    type(pixel_state), intent(inout) :: state
    type(first_contact) :: found
    logical :: is_loaded

    is_loaded = allocated(state%load)
    if (is_loaded) is_loaded = state%load > 0.0_real64
    associate (map => state%problem_map, modulus => state%problem_modulus)
      if (is_loaded) then
        call press_map(map, modulus, state%answer, state%load, state%tolerance, state%hardness)
      else
        if (allocated(state%load)) then
          found = find_top(map)
          state%answer%level = found%height
        end if
        if (allocated(state%load) .and. allocated(state%hardness) .and. &
            state%largest_load > 0.0_real64) state%answer%level = maxval(map%height)
        call press_map(map, modulus, state%answer, tolerance=state%tolerance, &
                       hardness=state%hardness)
      end if
    end associate
  end subroutine press_state

  !> Adds the columns of the interface of a state.
  subroutine add_state_interface(state, material, conductivity, columns)
    type(pixel_state), intent(in), target :: state          !! solution of a state
    real(real64), intent(in) :: material(2), conductivity(:, :)  !! as of `add_interface`
    type(column_list), intent(inout) :: columns             !! gets the columns
    real(real64), allocatable, target :: in_contact(:, :)
    real(real64), pointer :: pressure(:, :)

    pressure => state%answer%pressure
    if (allocated(state%answer%touches)) then
      allocate (in_contact, source=merge(max(pressure, tiny(pressure)), 0.0_real64, &
                                         state%answer%touches))
      pressure => in_contact
    end if
    call add_interface(state%deformed, material, pressure, conductivity, columns, state%hardness)
  end subroutine add_state_interface

  !> Chooses the laws of `auto` that have to be simulated, from a solution without them. Those with
  !> the smallest estimates are left out while their sum is within the tolerance. One without an
  !> estimate is chosen, one with an obstacle is left out.
  subroutine choose_laws(laws, state, estimates, is_called)
    type(pixel_law_box), intent(inout) :: laws(:)   !! laws; the chosen ones become simulated
    type(pixel_state), intent(in) :: state          !! solution without the laws of `auto` left out
    !> largest estimate of each law over the states of the path; `unknown_influence`: none is known
    real(real64), intent(inout) :: estimates(:)
    logical, intent(out) :: is_called               !! a law is chosen: the path is to be repeated
    real(real64) :: tolerance
    logical, dimension(size(laws)) :: is_chosen, is_open
    integer :: i

    tolerance = 0.0_real64
    is_open = .false.
    do i = 1, size(laws)
      associate (law => laws(i)%law)
        if (law%mode /= effect_auto .or. law%is_simulated) cycle
        tolerance = law%tolerance
        is_open(i) = .not. allocated(law%obstacle)
        estimates(i) = max(estimates(i), law%estimate(state))
      end associate
    end do
    is_chosen = is_open
    call leave_smallest(estimates, is_open, tolerance, is_chosen)
    is_called = any(is_chosen)
    do i = 1, size(laws)
      if (is_chosen(i)) laws(i)%law%is_simulated = .true.
    end do
  end subroutine choose_laws

end module asperity_pixel_sequence
