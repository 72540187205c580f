!> One state of a height map on its pixels, with all that acts there: a hardness, adhesion, creep.
!>
!> A state follows from the one before. Creep makes each step of time an elastic problem on a raised
!> map; adhesion solves it with the attraction (`map_adhesion`), else it is that of `map_contact`.
!> Pixels at the hardness are then lowered by the remaining overlap, at the same traction.
!>
!> Creep: the half-space is a viscoelastic solid.
!> The traction p of a pixel is the hereditary integral of its elastic traction pe, the one that has
!> the same displacements without relaxation, u = A pe (Lee and Radok 1960). Out of contact p is 0,
!> not pe: the area may shrink (Ting, J. Appl. Mech. 33 (1966) 845). Over a step of time the
!> recurrence of `viscoelastic_solid` is p = G pe + h with the gain G and the history h, so that
!>
!>     u = A p/G - A h/G
!>
!> This is the elastic contact problem with the modulus times G on the map raised by A h/G. The step
!> is implicit: p and the area at its end are those of the solution. Its error is of second order in
!> the step; it is exact for a constant area in a hold of the load or the separation.
module asperity_map_state
  use asperity_attraction_law, only: attraction_law
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: real64
  use asperity_map_adhesion, only: adhere_map, adhesion_history, find_pull_off
  use asperity_map_contact, only: displacement_by, map_answer, press_map
  use asperity_problems, only: real_text
  use asperity_viscoelastic_solid, only: history_of, keep_load, relaxing_solid, solid_step, &
                                         step_over
  implicit none
  private

  public :: creep_memory, map_history, map_laws, solve_map_state

  !> Memory of all pixels at a time, and the step to the next one.
  type :: creep_memory
    real(real64) :: time = 0.0_real64              !! time since the begin of loading
    real(real64), allocatable :: elastic(:, :)     !! elastic traction pe [pressure]
    real(real64), allocatable :: relaxing(:, :, :)  !! (term, pixel): parts that will relax
    type(solid_step) :: step                       !! coefficients of the step
    real(real64), allocatable :: history(:, :)     !! h of the step [pressure]
    real(real64), allocatable :: raised(:, :)      !! A h/G of the step [length]
  end type creep_memory

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
    real(real64) :: modulus, overlap
    logical :: is_loaded
    integer :: i, j

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
    if (.not. allocated(laws%hardness)) return
    ! Pixels at the hardness sink by the overlap of the surfaces there.
    associate (shape_left => history%deformed, work => history%plastic_work)
      do j = 1, map%rows
        do i = 1, map%columns
          if (answer%pressure(i, j) < laws%hardness) cycle
          overlap = max(0.0_real64, (shape_left%height(i, j) - answer%level) - &
                                    answer%displacement(i, j))
          shape_left%height(i, j) = shape_left%height(i, j) - overlap
          work = work + laws%hardness * overlap * product(map%pixel_spacing)
        end do
      end do
    end associate
  end subroutine solve_map_state

  ! Makes the elastic problem of a step of time. A step of no duration is elastic.
  subroutine begin_creep_step(map, modulus, solid, time, memory, raised_map, raised_modulus)
    type(height_map), intent(in) :: map  ! map with its residual shape
    real(real64), intent(in) :: modulus  ! instantaneous combined modulus, > 0
    type(relaxing_solid), intent(in) :: solid  ! material of both bodies
    real(real64), intent(in) :: time  ! time at the end of the step
    type(creep_memory), intent(inout) :: memory  ! memory of the last state
    type(height_map), intent(out) :: raised_map  ! map of the elastic problem
    real(real64), intent(out) :: raised_modulus  ! modulus of the elastic problem
    integer :: i, j

    if (.not. allocated(memory%elastic)) then
      allocate (memory%elastic(map%columns, map%rows), memory%history(map%columns, map%rows), &
                memory%relaxing(solid%terms, map%columns, map%rows))
      memory%elastic = 0.0_real64
      memory%relaxing = 0.0_real64
    end if
    memory%step = step_over(solid, memory%time, time)
    do j = 1, map%rows
      do i = 1, map%columns
        memory%history(i, j) = history_of(memory%step, memory%elastic(i, j), &
                                          memory%relaxing(:, i, j))
      end do
    end do
    memory%time = time
    raised_modulus = modulus * memory%step%gain
    raised_map = map
    memory%raised = displacement_by(map, raised_modulus, memory%history)
    where (is_measured(map%height)) raised_map%height = map%height + memory%raised
  end subroutine begin_creep_step

  ! Keeps the tractions of the solution of a step; the displacements become those of the map.
  subroutine end_creep_step(answer, memory)
    type(map_answer), intent(inout) :: answer  ! solution of the elastic problem
    type(creep_memory), intent(inout) :: memory  ! memory; gets that of the state
    integer :: i, j

    answer%displacement = answer%displacement - memory%raised
    do j = 1, size(memory%elastic, 2)
      do i = 1, size(memory%elastic, 1)
        call keep_load(memory%step, answer%pressure(i, j), memory%elastic(i, j), &
                       memory%relaxing(:, i, j))
      end do
    end do
  end subroutine end_creep_step

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

end module asperity_map_state
