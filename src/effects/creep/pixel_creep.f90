!> Creep of both bodies on the pixels of a height map, as an effect of a scene.
!>
!> The half-space is a viscoelastic solid.
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
module asperity_pixel_creep
  use asperity_constants, only: pi
  use asperity_creep_limits, only: creep_limits, creep_share, limits_of_scene, warn_of_strain, &
                                   warn_of_time
  use asperity_effect_header, only: column_list, force, plain
  use asperity_height_map, only: is_measured
  use asperity_kinds, only: real64
  use asperity_map_contact, only: displacement_by
  use asperity_map_patches, only: find_patches, map_patch
  use asperity_pixel_law, only: pixel_law, pixel_state, unknown_influence
  use asperity_scene_values, only: scene
  use asperity_theory_warnings, only: theory_warning
  use asperity_viscoelastic_solid, only: history_of, keep_load, solid_step, step_over
  implicit none
  private

  public :: new_pixel_creep

  ! Elastic traction of open pixels over that of all, up to which no pixel has left the contact
  ! (chosen: that of a state without such pixels is 0).
  real(real64), parameter :: none_left = 1.0e-6_real64

  !> Creep with one viscoelastic solid for both bodies, and its memory.
  type, extends(pixel_law) :: pixel_creep
    type(creep_limits) :: limits                   !! material of both bodies, and the hold
    real(real64) :: time = 0.0_real64              !! time of the last state
    real(real64), allocatable :: elastic(:, :)     !! elastic traction pe [pressure]
    real(real64), allocatable :: relaxing(:, :, :)  !! (term, pixel): parts that will relax
    real(real64), allocatable :: raised(:, :)      !! A h/G of the step [length]
    type(solid_step) :: step                       !! coefficients of the step
  contains
    procedure :: estimate => estimate_creep
    procedure :: add_columns => add_creep_columns
    procedure :: begin_step => begin_creep_step
    procedure :: end_step => end_creep_step
    procedure :: add_warnings => warn_of_creep
    procedure :: coarsen => take_elastic
    procedure :: why_unknown
  end type pixel_creep

contains

  !> Makes the law of a scene.
  subroutine new_pixel_creep(scene_in, law)
    type(scene), intent(in) :: scene_in                !! scene with checked values
    class(pixel_law), allocatable, intent(out) :: law  !! law without memory
    type(pixel_creep) :: new

    new%acts_in_time = .true.
    new%limits = limits_of_scene(scene_in)
    call new%call_as('creep', scene_in%effects)
    allocate (law, source=new)
  end subroutine new_pixel_creep

  !> Change of the modulus up to the end of the hold: the area is at most inverse to it. Beside an
  !> attraction it is that of all tractions over the load.
  function estimate_creep(self, state) result(share)
    class(pixel_creep), intent(in) :: self
    type(pixel_state), intent(in) :: state
    real(real64) :: share

    associate (pressure => state%answer%pressure)
      share = min(unknown_influence, creep_share(self%limits) * &
                  (sum(abs(pressure)) / max(abs(sum(pressure)), tiny(share))))
    end associate
  end function estimate_creep

  !> Adds the time and the load without relaxation.
  subroutine add_creep_columns(self, state, columns)
    class(pixel_creep), intent(in) :: self
    type(pixel_state), intent(in) :: state
    type(column_list), intent(inout) :: columns
    real(real64) :: load

    load = state%answer%load
    if (allocated(self%elastic)) load = product(state%deformed%pixel_spacing) * sum(self%elastic)
    call columns%add('time', plain, state%time)
    call columns%add('elastic_load', force, load)
  end subroutine add_creep_columns

  ! Makes the elastic problem of a step of time. A step of no duration is elastic.
  subroutine begin_creep_step(self, state)
    class(pixel_creep), intent(inout) :: self
    type(pixel_state), intent(inout) :: state
    real(real64), allocatable :: history(:, :)
    integer :: i, j

    associate (map => state%deformed)
      if (.not. allocated(self%elastic)) then
        allocate (self%elastic(map%columns, map%rows), source=0.0_real64)
        allocate (self%relaxing(self%limits%solid%terms, map%columns, map%rows), source=0.0_real64)
      end if
      self%step = step_over(self%limits%solid, self%time, state%time)
      allocate (history, mold=self%elastic)
      do j = 1, map%rows
        do i = 1, map%columns
          history(i, j) = history_of(self%step, self%elastic(i, j), self%relaxing(:, i, j))
        end do
      end do
      self%time = state%time
      state%problem_modulus = state%modulus * self%step%gain
      self%raised = displacement_by(map, state%problem_modulus, history)
      where (is_measured(map%height)) state%problem_map%height = map%height + self%raised
    end associate
  end subroutine begin_creep_step

  ! Keeps the tractions of the solution of a step; the displacements become those of the map.
  subroutine end_creep_step(self, state)
    class(pixel_creep), intent(inout) :: self
    type(pixel_state), intent(inout) :: state
    integer :: i, j

    state%answer%displacement = state%answer%displacement - self%raised
    do j = 1, size(self%elastic, 2)
      do i = 1, size(self%elastic, 1)
        call keep_load(self%step, state%answer%pressure(i, j), self%elastic(i, j), &
                       self%relaxing(:, i, j))
      end do
    end do
  end subroutine end_creep_step

  !> Warns as on asperities. The sphere of a patch has its area and its elastic load W: a/R is
  !> 3 W/(4 E a**2) with the contact radius a (Hertz).
  subroutine warn_of_creep(self, state, warnings)
    class(pixel_creep), intent(in) :: self
    type(pixel_state), intent(in) :: state
    type(theory_warning), allocatable, intent(inout) :: warnings(:)
    type(map_patch), allocatable :: patches(:)
    integer, allocatable :: patch_of(:, :)
    real(real64) :: load(size(state%patches))
    integer :: i, j

    associate (map => state%deformed, answer => state%answer)
      if (allocated(answer%contact_pressure)) then
        call find_patches(map, answer%contact_pressure, patches, patch_of)
      else
        call find_patches(map, answer%pressure, patches, patch_of)
      end if
      load = 0.0_real64
      do j = 1, map%rows
        do i = 1, map%columns
          if (patch_of(i, j) > 0) load(patch_of(i, j)) = &
            load(patch_of(i, j)) + max(0.0_real64, self%elastic(i, j)) * product(map%pixel_spacing)
        end do
      end do
    end associate
    do i = 1, size(load)
      call warn_of_strain(self%limits, 3 * pi * load(i), &
                          4 * state%modulus * state%patches(i)%area, warnings)
    end do
    call warn_of_time(self%limits, state%time, warnings)
  end subroutine warn_of_creep

  !> Makes the state elastic, with the tractions pe: its errors are those of the state of the same
  !> displacements (Lee and Radok 1960).
  subroutine take_elastic(self, columns, rows, state)
    class(pixel_creep), intent(inout) :: self
    integer, intent(in) :: columns(:), rows(:)
    type(pixel_state), intent(inout) :: state

    associate (unused => columns, unused_too => rows)
    end associate
    self%is_simulated = .false.
    state%answer%pressure = self%elastic
    state%answer%load = sum(self%elastic) * product(state%deformed%pixel_spacing)
  end subroutine take_elastic

  !> The elastic state has the same errors where creep acts alone, and no pixel has left the
  !> contact, where the surface has not recovered.
  function why_unknown(self, state, is_alone) result(reason)
    class(pixel_creep), intent(in) :: self
    type(pixel_state), intent(in) :: state
    logical, intent(in) :: is_alone
    character(len=48) :: reason

    reason = ''
    if (sum(abs(self%elastic), mask=.not. state%answer%pressure > 0.0_real64) > &
        none_left * sum(abs(self%elastic))) reason = 'pixels that have left creeping contacts'
    if (.not. is_alone) reason = 'creep beside another effect'
  end function why_unknown

end module asperity_pixel_creep
