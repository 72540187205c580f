!> Partial slip of a height map: a tangential load that grows at a constant normal load.
!>
!> Problem: tractions q in one direction, 0 <= q <= mu p, with the tangential displacement A q/kappa
!> equal to delta where q < mu p and at most delta where q = mu p. A is the matrix of the normal
!> displacements, kappa = 4 G/E (see `tangential_stiffness_ratio`). The tangential displacement
!> across and the dependence of A on Poisson's ratio and direction are neglected: the solution is
!> exact for nu = 0 and Dundurs' beta = 0.
!>
!> Method: q = mu (p - p*), where p* are the pressures of the same shape under the normal load
!> P - T/mu, and delta = (mu/kappa) times the difference of the levels (Ciavarella, J. Appl. Mech.
!> 65 (1998) 998; Jaeger, J. Tribol. 120 (1998) 677). Pixels with p* > 0 stick.
module asperity_partial_slip
  use asperity_contact_field, only: contact_field
  use asperity_contact_stiffness, only: find_stiffness
  use asperity_height_map, only: height_map, is_measured
  use asperity_kinds, only: not_computed, real64
  use asperity_map_contact, only: map_answer, press_map
  use asperity_map_patches, only: find_patches, map_patch
  implicit none
  private

  public :: slip_answer, slip_of_patches, slip_request, solve_partial_slip, take_traction

  !> Tangential load or displacement of a map.
  type :: slip_request
    real(real64) :: coefficient = 0.0_real64    !! coefficient of friction mu, 0 or more
    real(real64) :: kappa = 1.0_real64          !! tangential over normal stiffness, more than 0
    logical :: by_load = .true.                 !! whether the load is given, else the displacement
    real(real64) :: given = 0.0_real64          !! load [force] or displacement [length], 0 or more
  end type slip_request

  !> Solution of partial slip.
  type :: slip_answer
    logical :: slides = .false.                 !! complete sliding: q = mu p
    real(real64) :: load = 0.0_real64           !! tangential load T [force]
    !> Tangential displacement of the bodies [length]; `not_computed` where they slide under a load.
    real(real64) :: displacement = 0.0_real64
    real(real64) :: stiffness = 0.0_real64      !! dT/d displacement [force/length]
    real(real64) :: stick_area = 0.0_real64     !! area that sticks [length**2]
    real(real64), allocatable :: traction(:, :) !! tangential traction q of each pixel, 0 or more
    type(map_answer) :: stuck                   !! solution p*; no pressures: nothing sticks
  end type slip_answer

  ! Ratio T/(mu P), or of the displacement to that of sliding at p* = 0, below which q is
  ! proportional to it: q is a difference of two solutions with the error of the pressures, 2e-9
  ! of the largest. The error of the displacement is then at most a sixth of this ratio (derived:
  ! Mindlin's sphere; test: small loads in test/maps/test_partial_slip.py).
  real(real64), parameter :: least_ratio = 1.0e-4_real64

contains

  !> Solves partial slip of a map that is in contact.
  subroutine solve_partial_slip(map, modulus, request, loaded, slip, failure)
    type(height_map), intent(in) :: map        !! shape; with a hardness the deformed one
    real(real64), intent(in) :: modulus        !! combined modulus, more than 0
    type(slip_request), intent(in) :: request  !! friction, and load or displacement
    type(map_answer), intent(in) :: loaded     !! elastic solution of this map at the normal load
    type(slip_answer), intent(out) :: slip     !! tractions, displacement, area that sticks
    character(len=:), allocatable, intent(out) :: failure  !! reason, when it is not solved
    type(map_patch), allocatable :: patches(:)
    real(real64) :: most, ratio, solved

    most = request%coefficient * loaded%load
    if (.not. request%by_load) most = request%coefficient / request%kappa * &
                                      max(0.0_real64, maxval(map%height) - loaded%level)
    slip%slides = .not. request%given < most
    slip%load = request%coefficient * loaded%load
    slip%traction = request%coefficient * loaded%pressure
    slip%displacement = request%given
    if (slip%slides .and. request%by_load) slip%displacement = not_computed
    if (slip%slides) return
    ratio = request%given / most
    slip%stuck = loaded
    if (ratio > 0.0_real64) then
      solved = max(ratio, least_ratio)
      slip%stuck%pressure = (1.0_real64 - solved) * loaded%pressure
      if (request%by_load) then
        call press_map(map, modulus, slip%stuck, (1.0_real64 - solved) * loaded%load)
      else
        slip%stuck%level = loaded%level + solved * (maxval(map%height) - loaded%level)
        call press_map(map, modulus, slip%stuck)
      end if
      if (allocated(slip%stuck%failure)) then
        failure = 'partial slip: ' // slip%stuck%failure
        return
      end if
      ratio = ratio / solved
    end if
    slip%traction = ratio * request%coefficient * &
                    max(0.0_real64, loaded%pressure - slip%stuck%pressure)
    slip%load = ratio * request%coefficient * (loaded%load - slip%stuck%load)
    if (request%by_load) slip%displacement = ratio * request%coefficient / request%kappa * &
                                             (slip%stuck%level - loaded%level)
    call find_patches(map, slip%stuck%pressure, patches)
    slip%stick_area = sum(patches%area)
    call find_stiffness(map, modulus, slip%stuck%pressure > 0.0_real64, slip%stiffness)
    if (slip%stiffness > 0.0_real64) slip%stiffness = request%kappa * slip%stiffness
  end subroutine solve_partial_slip

  !> Tangential load and area that sticks of each contact patch.
  subroutine slip_of_patches(map, loaded, slip, load, stick_area)
    type(height_map), intent(in) :: map            !! shape of the solution
    type(map_answer), intent(in) :: loaded         !! solution at the normal load
    type(slip_answer), intent(in) :: slip          !! solution of partial slip
    !> of each patch, in the order of `find_patches`
    real(real64), allocatable, intent(out) :: load(:), stick_area(:)
    type(map_patch), allocatable :: patches(:), stuck(:)
    integer, allocatable :: patch_of(:, :), stuck_of(:, :)
    integer :: i, j

    call find_patches(map, loaded%pressure, patches, patch_of)
    allocate (load(size(patches)), stick_area(size(patches)), source=0.0_real64)
    do j = 1, map%rows
      do i = 1, map%columns
        if (patch_of(i, j) > 0) load(patch_of(i, j)) = &
          load(patch_of(i, j)) + slip%traction(i, j) * product(map%pixel_spacing)
      end do
    end do
    if (slip%slides) return
    call find_patches(map, slip%stuck%pressure, stuck, stuck_of)
    ! Each patch that sticks is within one contact patch; its first pixel adds its area.
    do j = 1, map%rows
      do i = 1, map%columns
        if (stuck_of(i, j) == 0 .or. patch_of(i, j) == 0) cycle
        associate (area => stuck(stuck_of(i, j))%area)
          stick_area(patch_of(i, j)) = stick_area(patch_of(i, j)) + area
          area = 0.0_real64
        end associate
      end do
    end do
  end subroutine slip_of_patches

  !> Adds the traction and the pixels that stick to the fields of the state.
  pure subroutine take_traction(map, slip, field)
    type(height_map), intent(in) :: map          !! shape of the solution
    type(slip_answer), intent(in) :: slip        !! solution of partial slip
    type(contact_field), intent(inout) :: field  !! fields of the state

    field%traction = merge(slip%traction, not_computed, is_measured(map%height))
    field%sticks = field%pressure > 0.0_real64 .and. .not. slip%slides
    if (.not. slip%slides) field%sticks = field%sticks .and. slip%stuck%pressure > 0.0_real64
  end subroutine take_traction

end module asperity_partial_slip
