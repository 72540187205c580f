!> Creep on the pixels of a height map: the half-space is a viscoelastic solid.
!>
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
module asperity_map_creep
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: real64
  use asperity_map_contact, only: displacement_by, map_answer
  use asperity_viscoelastic_solid, only: history_of, keep_load, relaxing_solid, solid_step, &
                                         step_over
  implicit none
  private

  public :: begin_creep_step, creep_memory, end_creep_step

  !> Memory of all pixels at a time, and the step to the next one.
  type :: creep_memory
    real(real64) :: time = 0.0_real64              !! time since the begin of loading
    real(real64), allocatable :: elastic(:, :)     !! elastic traction pe [pressure]
    real(real64), allocatable :: relaxing(:, :, :)  !! (term, pixel): parts that will relax
    type(solid_step) :: step                       !! coefficients of the step
    real(real64), allocatable :: history(:, :)     !! h of the step [pressure]
    real(real64), allocatable :: raised(:, :)      !! A h/G of the step [length]
  end type creep_memory

contains

  !> Makes the elastic problem of a step of time. A step of no duration is elastic.
  subroutine begin_creep_step(map, modulus, solid, time, memory, raised_map, raised_modulus)
    type(height_map), intent(in) :: map                !! map with its residual shape
    real(real64), intent(in) :: modulus                !! instantaneous combined modulus, > 0
    type(relaxing_solid), intent(in) :: solid   !! material of both bodies
    real(real64), intent(in) :: time                   !! time at the end of the step
    type(creep_memory), intent(inout) :: memory        !! memory of the last state
    type(height_map), intent(out) :: raised_map        !! map of the elastic problem
    real(real64), intent(out) :: raised_modulus        !! modulus of the elastic problem
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

  !> Keeps the tractions of the solution of a step; the displacements become those of the map.
  subroutine end_creep_step(answer, memory)
    type(map_answer), intent(inout) :: answer      !! solution of the elastic problem
    type(creep_memory), intent(inout) :: memory    !! memory; gets that of the state

    integer :: i, j

    answer%displacement = answer%displacement - memory%raised
    do j = 1, size(memory%elastic, 2)
      do i = 1, size(memory%elastic, 1)
        call keep_load(memory%step, answer%pressure(i, j), memory%elastic(i, j), &
                       memory%relaxing(:, i, j))
      end do
    end do
  end subroutine end_creep_step

end module asperity_map_creep
