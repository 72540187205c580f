!> One state of a height map on its pixels, with all that acts there: a hardness, adhesion, creep.
!>
!> A state follows from the one before. Creep makes each step of time an elastic problem on a raised
!> map (`map_creep`); adhesion solves it with the attraction (`map_adhesion`), else it is that of
!> `map_contact`. Pixels at the hardness are then lowered by the remaining overlap, at the same
!> traction.
module asperity_map_state
  use asperity_attraction_law, only: attraction_law
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: real64
  use asperity_map_adhesion, only: adhere_map, adhesion_history, find_pull_off
  use asperity_map_contact, only: map_answer, press_map
  use asperity_map_creep, only: begin_creep_step, creep_memory, end_creep_step
  use asperity_problems, only: real_text
  use asperity_viscoelastic_solid, only: relaxing_solid
  implicit none
  private

  public :: map_history, map_laws, solve_map_state

  !> Laws on the pixels of a map; not allocated: it is left out.
  type :: map_laws
    real(real64) :: modulus = 0.0_real64               !! instantaneous combined modulus, > 0
    real(real64), allocatable :: hardness              !! largest net traction
    type(attraction_law), allocatable :: attraction    !! attraction across the gap
    type(relaxing_solid), allocatable :: solid         !! material of both bodies
  end type map_laws

  !> History that a state leaves to the next one.
  type :: map_history
    type(height_map) :: deformed               !! the map with its plastic deformation
    type(adhesion_history) :: adhesion
    type(creep_memory) :: creep
    real(real64) :: plastic_work = 0.0_real64  !! dissipated by plasticity [force length]
  end type map_history

contains

  !> Solves a state at a load, or at the level of `answer`. `answer%failure` has the largest tensile
  !> load where the load is not carried.
  subroutine solve_map_state(laws, time, history, answer, load, tolerance)
    type(map_laws), intent(in) :: laws              !! what acts on the pixels
    real(real64), intent(in) :: time                !! time of the state; without creep any
    type(map_history), intent(inout) :: history     !! state before; becomes this state
    type(map_answer), intent(inout) :: answer       !! solution of the state before; of this one
    real(real64), intent(in), optional :: load      !! normal load; absent: the level is given
    real(real64), intent(in), optional :: tolerance  !! as of `press_map` or `adhere_map`
    type(height_map) :: map
    real(real64) :: modulus
    logical :: is_loaded

    is_loaded = present(load)
    if (is_loaded) is_loaded = load > 0.0_real64
    map = history%deformed
    modulus = laws%modulus
    if (allocated(laws%solid)) &
      call begin_creep_step(history%deformed, laws%modulus, laws%solid, time, history%creep, map, &
                            modulus)
    if (allocated(laws%attraction)) then
      call solve_adhesion(map, modulus, laws, history%adhesion, answer, load, tolerance)
    else if (is_loaded) then
      call press_map(map, modulus, answer, load, tolerance, laws%hardness)
    else
      if (present(load)) answer%level = maxval(map%height)
      call press_map(map, modulus, answer, tolerance=tolerance, hardness=laws%hardness)
    end if
    if (allocated(answer%failure)) return
    if (allocated(laws%solid)) call end_creep_step(answer, history%creep)
    if (allocated(laws%hardness)) &
      call deform_map(laws%hardness, answer, history%deformed, history%plastic_work)
  end subroutine solve_map_state

  ! Solves a state with adhesion. A load that is not carried is a failure with the largest one.
  subroutine solve_adhesion(map, modulus, laws, history, answer, load, tolerance)
    type(height_map), intent(in) :: map
    real(real64), intent(in) :: modulus
    type(map_laws), intent(in) :: laws
    type(adhesion_history), intent(inout) :: history
    type(map_answer), intent(inout) :: answer
    real(real64), intent(in), optional :: load, tolerance
    type(adhesion_history) :: before
    real(real64) :: carried
    logical :: begins_open

    begins_open = .not. allocated(history%attraction)
    carried = answer%load
    before = history
    call adhere_map(map, modulus, laws%attraction, history, answer, load, laws%hardness, &
                    tolerance)
    if (allocated(answer%failure) .or. .not. (present(load) .and. history%is_separated)) return
    ! From open surfaces the first state is that at first touch.
    if (begins_open) then
      answer%level = maxval(map%height)
      call adhere_map(map, modulus, laws%attraction, before, answer, hardness=laws%hardness)
      carried = answer%load
    end if
    if (.not. allocated(answer%failure)) call find_pull_off(map, modulus, laws%attraction, before, &
                                                  answer, carried, load, laws%hardness)
    if (allocated(answer%failure)) return
    answer%failure = 'the pull is larger than the contacts carry: ' // real_text(-carried) // &
                     ' at most, a nominal pressure of ' // real_text(-carried / &
                     (count(is_measured(map%height)) * product(map%pixel_spacing)))
    if (begins_open) answer%failure = answer%failure // ' from first contact; after loading ' // &
                     'they may carry more: expected a path, value = LOAD, PULL'
  end subroutine solve_adhesion

  ! Lowers the pixels at the hardness by the overlap of the surfaces there, and adds its work.
  subroutine deform_map(hardness, answer, map, work)
    real(real64), intent(in) :: hardness      ! largest net traction
    type(map_answer), intent(in) :: answer    ! solution of this map with its displacement
    type(height_map), intent(inout) :: map    ! measured pixels may sink
    real(real64), intent(inout) :: work       ! [force length], grows
    real(real64) :: overlap
    integer :: i, j

    do j = 1, map%rows
      do i = 1, map%columns
        if (answer%pressure(i, j) < hardness) cycle
        overlap = max(0.0_real64, (map%height(i, j) - answer%level) - answer%displacement(i, j))
        map%height(i, j) = map%height(i, j) - overlap
        work = work + hardness * overlap * product(map%pixel_spacing)
      end do
    end do
  end subroutine deform_map

end module asperity_map_state
