!> Plasticity on the pixels of a height map, as an effect of a scene: a perfectly plastic body with
!> a hardness.
!>
!> No traction is above the hardness. Pixels at the hardness are then lowered by the remaining
!> overlap, at the same traction. Pixels have no yield stress: its influence is 0 up to first yield,
!> and unknown beyond it.
module asperity_pixel_plasticity
  use asperity_contact_records, only: state_row
  use asperity_effect_header, only: area, column_list, moment
  use asperity_first_yield, only: yield_pressure
  use asperity_kinds, only: int64, real64
  use asperity_pixel_law, only: pixel_law, pixel_state, unknown_influence
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: new_pixel_plasticity

  ! Greatest over average pressure of a Hertzian contact (derived; test: test_pixel_laws.py).
  real(real64), parameter :: peak = 1.5_real64
  ! Tolerance of the largest load, for rounding (chosen; test: test_plastic_pixels.py).
  real(real64), parameter :: load_rounding = 1.0e-12_real64

  !> Plasticity with one hardness for all pixels.
  type, extends(pixel_law) :: pixel_plasticity
    real(real64) :: yields_at = 0.0_real64  !! greatest pressure at first yield
    real(real64) :: work = 0.0_real64       !! dissipated since first contact [force length]
    real(real64) :: plastic_area = 0.0_real64  !! area at the hardness in the last state
  contains
    procedure :: estimate => estimate_plasticity
    procedure :: add_columns => add_plastic_columns
    procedure :: fill_row => fill_plastic_row
    procedure :: begin_step => limit_pressure
    procedure :: end_step => lower_pixels
    procedure :: why_unknown
  end type pixel_plasticity

contains

  !> Makes the law of a scene.
  subroutine new_pixel_plasticity(scene_in, law)
    type(scene), intent(in) :: scene_in                !! scene with checked values
    class(pixel_law), allocatable, intent(out) :: law  !! law without history
    type(pixel_plasticity) :: new

    new%hardness = scene_in%effects%number('plastic_hardness')
    new%yields_at = peak * min(yield_pressure(scene_in), huge(peak) / peak)
    new%is_free = .true.
    if (.not. new%hardness > 0.0_real64) &
      new%obstacle = 'the pixels of a map yield at a hardness: expected plastic_hardness'
    call new%call_as('plasticity', scene_in%effects)
    allocate (law, source=new)
  end subroutine new_pixel_plasticity

  !> Load above the hardness over the load, or the pixels above it over those in contact.
  function estimate_plasticity(self, state) result(share)
    class(pixel_plasticity), intent(in) :: self
    type(pixel_state), intent(in) :: state
    real(real64) :: share

    share = 0.0_real64
    associate (pressure => state%answer%pressure)
      if (.not. maxval(pressure) > 0.0_real64) return
      if (self%hardness > 0.0_real64) then
        share = max(sum(max(0.0_real64, pressure - self%hardness)) / &
                    sum(max(0.0_real64, pressure)), real(count(pressure > self%hardness, &
                    kind=int64), real64) / count(pressure > 0.0_real64, kind=int64))
      else if (maxval(pressure) > self%yields_at) then
        share = unknown_influence
      end if
    end associate
  end function estimate_plasticity

  !> Adds the area at the hardness and the dissipated work.
  subroutine add_plastic_columns(self, state, columns)
    class(pixel_plasticity), intent(in) :: self
    type(pixel_state), intent(in) :: state
    type(column_list), intent(inout) :: columns

    associate (unused => state)
    end associate
    call columns%add('plastic_area', area, self%plastic_area)
    call columns%add('dissipated_work', moment, self%work)
  end subroutine add_plastic_columns

  !> Sets the area at the hardness and the dissipated work of a state.
  subroutine fill_plastic_row(self, state, row)
    class(pixel_plasticity), intent(in) :: self
    type(pixel_state), intent(in) :: state
    type(state_row), intent(inout) :: row

    associate (unused => state)
    end associate
    row%plastic_area = self%plastic_area
    row%dissipated_work = self%work
  end subroutine fill_plastic_row

  ! Limits the tractions of the elastic problem.
  subroutine limit_pressure(self, state)
    class(pixel_plasticity), intent(inout) :: self
    type(pixel_state), intent(inout) :: state

    state%hardness = self%hardness
  end subroutine limit_pressure

  ! Lowers pixels at the hardness by the overlap of the surfaces there.
  subroutine lower_pixels(self, state)
    class(pixel_plasticity), intent(inout) :: self
    type(pixel_state), intent(inout) :: state
    real(real64) :: overlap
    integer :: i, j

    associate (map => state%deformed, answer => state%answer)
      do j = 1, map%rows
        do i = 1, map%columns
          if (answer%pressure(i, j) < self%hardness) cycle
          overlap = max(0.0_real64, (map%height(i, j) - answer%level) - &
                                    answer%displacement(i, j))
          map%height(i, j) = map%height(i, j) - overlap
          self%work = self%work + self%hardness * overlap * product(map%pixel_spacing)
        end do
      end do
      self%plastic_area = product(map%pixel_spacing) * &
                          count(.not. answer%pressure < self%hardness, kind=int64)
    end associate
  end subroutine lower_pixels

  !> Below the largest load of the path its history matters.
  function why_unknown(self, state, is_alone) result(reason)
    class(pixel_plasticity), intent(in) :: self
    type(pixel_state), intent(in) :: state
    logical, intent(in) :: is_alone
    character(len=48) :: reason

    associate (unused => self, unused_too => is_alone)
    end associate
    reason = ''
    if (state%answer%load < state%largest_load * (1.0_real64 - load_rounding)) &
      reason = 'unloading after plasticity'
  end function why_unknown

end module asperity_pixel_plasticity
