!> Stress below the surface of a half-space under the pressures of a field.
!>
!> Problem: the six components of the stress at a depth z > 0 under each pixel, with pressures that
!> are uniform on each pixel. Tension is positive; x and y are those of the map, z points into the
!> body.
!>
!> On a free map: Love's integrals of Boussinesq's stresses over a rectangle (Love, Phil. Trans. R.
!> Soc. A 228 (1929) 377). With X, Y from the point to a corner, R**2 = X**2 + Y**2 + z**2 and
!> t = atan(X Y/(z R)), the stress is -p/(2 pi) times the differences over the four corners of
!>
!>   zz: t + X Y z/R (1/(X**2 + z**2) + 1/(Y**2 + z**2))
!>   xx: 2 nu t + (1 - 2 nu) (atan(Y/X) - atan(z Y/(X R))) - z X Y/(R (X**2 + z**2)); yy alike
!>   xy: (1 - 2 nu) ln(R + z) + z/R
!>   xz: -z**2 Y/(R (X**2 + z**2)); yz alike
!>
!> They are convolved with the pressures on a padded lattice, which is exact to rounding. On a map
!> that is periodic along one axis they are summed over `images_along` periods on each side; the
!> others are an integral along the axis by the midpoint rule.
!>
!> On a periodic map: for a wave of pressure of the numbers qx, qy, with q**2 = qx**2 + qy**2,
!> c = qx/q and s = qy/q, the stress is -p exp(-q z) times
!>
!>   zz: 1 + q z;  xx: 2 nu + (1 - 2 nu) c**2 - c**2 q z;  yy alike
!>   xy: c s (1 - 2 nu - q z);  xz: -i qx z;  yz: -i qy z
!>
!> (Johnson, Contact Mechanics, 1985, section 13.2, for one direction). The mean pressure has no
!> lateral strain: xx = yy = -p nu/(1 - nu).
module asperity_map_stress
  use asperity_constants, only: pi
  use asperity_contact_field, only: contact_field
  use asperity_kinds, only: int64, real64
  use asperity_lattice_convolution, only: padded_length
  use asperity_plane_transform, only: plane_transform
  use asperity_problems, only: not_enough_memory, real_text
  use asperity_process, only: has_memory
  use asperity_scene_values, only: scene
  implicit none
  private

  public :: component_names, largest_shear, largest_stress, look_for_largest, room_for_stress, &
            stress_below, stress_solver, von_mises

  !> Reason why a scene has no stresses.
  character(len=*), parameter, public :: no_ratio = 'stress needs poisson_ratio in &material: ' // &
    'found contact_modulus in its place'
  !> Components of a stress, in their order.
  character(len=*), parameter :: component_names(6) = &
    [character(len=2) :: 'xx', 'yy', 'zz', 'xy', 'xz', 'yz']

  !> The largest of some stresses, and its place.
  type :: largest_stress
    real(real64) :: value = 0.0_real64     !! von Mises or shear stress [pressure]
    real(real64) :: depth = 0.0_real64     !! depth below the surface [length]
    real(real64) :: x = 0.0_real64         !! place in plan [length]
    real(real64) :: y = 0.0_real64         !! place in plan [length]
  end type largest_stress

  !> Solver for the stresses under one field. It owns plans: it must not be copied.
  type :: stress_solver
    private
    logical :: periodic = .false.
    integer :: strip_axis = 0                     ! axis of the period of a strip; 0: none
    real(real64) :: ratio = 0.0_real64            ! Poisson's ratio
    real(real64) :: side(2) = 0.0_real64          ! of a pixel
    integer :: columns = 0, rows = 0              ! of the field
    type(plane_transform) :: transform
    complex(real64), allocatable :: pressure(:, :)  ! its waves
  contains
    procedure :: prepare => prepare_solver  !! transforms the pressures
    procedure :: solve => solve_depth       !! computes the stresses at a depth
  end type stress_solver

  ! Periods on each side of a strip; the error is 2e-5 of the mean pressure over a period (derived:
  ! midpoint rule of a stress that falls as 1/x**2; test: strips in
  ! test/maps/test_map_stress.py).
  integer, parameter :: images_along = 16

  ! Parity of the corner functions in X and in Y.
  integer, parameter :: corner_parity(2, 6) = reshape([-1, -1, -1, -1, -1, -1, 1, 1, 1, -1, &
                                                       -1, 1], [2, 6])

contains

  !> Stresses in the lower body under the pressures of a field.
  subroutine stress_below(scene_in, field, depth, stress, failure)
    type(scene), intent(in) :: scene_in          !! scene that was solved
    type(contact_field), intent(in) :: field     !! pressures of one of its states
    real(real64), intent(in) :: depth            !! depth below the surface, more than 0 [length]
    real(real64), allocatable, intent(out) :: stress(:, :, :)  !! (column, row, component)
    character(len=:), allocatable, intent(out) :: failure      !! reason when it is not computed
    type(stress_solver) :: solver

    if (.not. (depth > 0.0_real64 .and. depth <= huge(depth))) then
      failure = 'depth: found ' // real_text(depth) // ', expected a number more than 0'
    else if (.not. allocated(field%pressure)) then
      failure = 'no fields: expected those of a state that was solved with fields'
    else if (scene_in%contact_modulus > 0.0_real64) then
      failure = no_ratio
    else if (.not. has_memory(room_for_stress(field))) then
      failure = not_enough_memory // ' for the stresses'
    else
      call solver%prepare(field, scene_in%lower%poisson_ratio)
      call solver%solve(depth, stress)
    end if
  end subroutine stress_below

  !> Memory of the stresses at one depth with their table, bytes: waves and kernels of the padded
  !> pixels; components, cells and columns (counted; test: limits in test_python_maps.py).
  pure integer(int64) function room_for_stress(field) result(bytes)
    type(contact_field), intent(in) :: field  !! pressures on pixels
    integer, parameter :: bytes_padded = 56, bytes_plain = 256
    integer(int64) :: padded

    padded = int(padded_length(2 * field%columns), int64) * padded_length(2 * field%rows)
    if (field%periodic) padded = int(field%columns, int64) * field%rows
    bytes = bytes_padded * padded + bytes_plain * int(field%columns, int64) * field%rows
  end function room_for_stress

  !> Prepares the stresses under the pressures of a field.
  subroutine prepare_solver(self, field, ratio)
    class(stress_solver), intent(inout) :: self  !! solver without plans
    type(contact_field), intent(in) :: field     !! pressures on pixels
    real(real64), intent(in) :: ratio            !! Poisson's ratio of the body, -1 to 0.5
    integer :: padded(2)

    self%periodic = field%periodic
    self%strip_axis = field%strip_axis
    self%ratio = ratio
    self%side = field%pixel_spacing
    self%columns = field%columns
    self%rows = field%rows
    if (self%periodic) then
      call self%transform%prepare(field%columns, field%rows)
    else
      padded = [padded_length(2 * field%columns), padded_length(2 * field%rows)]
      if (self%strip_axis == 1) padded(1) = field%columns
      if (self%strip_axis == 2) padded(2) = field%rows
      call self%transform%prepare(padded(1), padded(2))
    end if
    allocate (self%pressure(0:self%transform%rows - 1, 0:self%transform%columns / 2))
    call self%transform%make_waves(max(0.0_real64, field%pressure), self%pressure)
  end subroutine prepare_solver

  !> Computes the components at a depth.
  subroutine solve_depth(self, depth, stress)
    class(stress_solver), intent(in) :: self         !! solver with the pressures
    real(real64), intent(in) :: depth                !! depth below the surface, more than 0
    real(real64), allocatable, intent(out) :: stress(:, :, :)  !! (column, row, component)
    complex(real64), allocatable :: waves(:, :)
    real(real64), allocatable :: kernel(:, :)
    integer :: k

    allocate (stress(self%columns, self%rows, size(component_names)))
    allocate (waves, mold=self%pressure)
    if (.not. self%periodic) allocate (kernel(self%transform%columns, self%transform%rows))
    do k = 1, size(component_names)
      if (self%periodic) then
        call multiply_wave(self, depth, k, waves)
      else
        if (self%strip_axis > 0) then
          call fill_strip_kernel(self, depth, k, kernel)
        else
          call fill_kernel(self, depth, k, kernel)
        end if
        call self%transform%make_waves(kernel, waves)
        waves = waves * self%pressure
      end if
      call self%transform%sum_waves(waves, stress(:, :, k))
    end do
  end subroutine solve_depth

  ! The waves of a component on a periodic map. The sign of the shortest wave along a side is not
  ! known: components that are odd in it have none.
  subroutine multiply_wave(self, depth, component, waves)
    class(stress_solver), intent(in) :: self
    real(real64), intent(in) :: depth
    integer, intent(in) :: component
    complex(real64), intent(out) :: waves(0:, 0:)
    complex(real64) :: factor
    real(real64) :: odd(2), q, wave(2)
    integer :: i, j, n

    n = self%transform%rows
    do i = 0, self%transform%columns / 2
      do j = 0, n - 1
        wave = 2.0_real64 * pi * [i, merge(j - n, j, 2 * j > n)] / &
               ([self%transform%columns, n] * self%side)
        odd = wave
        if (2 * i == self%transform%columns) odd(1) = 0.0_real64
        if (2 * j == n) odd(2) = 0.0_real64
        q = hypot(wave(1), wave(2))
        if (i + j == 0) then
          factor = merge(1.0_real64, 0.0_real64, component == 3)
          if (component < 3) factor = self%ratio / (1.0_real64 - self%ratio)
        else
          select case (component)
          case (1, 2)
            factor = 2.0_real64 * self%ratio + (wave(component) / q)**2 * &
                     (1.0_real64 - 2.0_real64 * self%ratio - q * depth)
          case (3)
            factor = 1.0_real64 + q * depth
          case (4)
            factor = odd(1) * odd(2) / q**2 * (1.0_real64 - 2.0_real64 * self%ratio - q * depth)
          case default
            factor = cmplx(0.0_real64, -odd(component - 4) * depth, real64)
          end select
        end if
        waves(j, i) = -exp(-q * depth) * factor * self%pressure(j, i)
      end do
    end do
  end subroutine multiply_wave

  ! The influence of a unit pressure of a pixel on a component, by the offset of the point, from the
  ! corner function in one quadrant.
  subroutine fill_kernel(self, depth, component, kernel)
    class(stress_solver), intent(in) :: self
    real(real64), intent(in) :: depth
    integer, intent(in) :: component
    real(real64), intent(out) :: kernel(:, :)
    real(real64), allocatable :: corner(:, :)
    integer :: i, j

    allocate (corner(-self%columns:self%columns - 1, -self%rows:self%rows - 1))
    !$omp parallel do
    do j = 0, self%rows - 1
      do i = 0, self%columns - 1
        corner(i, j) = corner_function(component, (i + 0.5_real64) * self%side(1), &
                                       (j + 0.5_real64) * self%side(2), depth, self%ratio)
      end do
      corner(-1:-self%columns:-1, j) = corner_parity(1, component) * corner(0:, j)
    end do
    !$omp end parallel do
    do j = 0, self%rows - 1
      corner(:, -1 - j) = corner_parity(2, component) * corner(:, j)
    end do
    kernel = 0.0_real64
    do j = 1 - self%rows, self%rows - 1
      do i = 1 - self%columns, self%columns - 1
        kernel(1 + modulo(i, size(kernel, 1)), 1 + modulo(j, size(kernel, 2))) = &
          -(corner(i, j) - corner(i - 1, j) - corner(i, j - 1) + corner(i - 1, j - 1)) / &
          (2.0_real64 * pi)
      end do
    end do
  end subroutine fill_kernel

  ! The same for a strip: u is along its period, v across.
  subroutine fill_strip_kernel(self, depth, component, kernel)
    class(stress_solver), intent(in) :: self
    real(real64), intent(in) :: depth
    integer, intent(in) :: component
    real(real64), intent(out) :: kernel(:, :)
    real(real64), allocatable :: steps(:), sums(:)
    real(real64) :: far, right, left
    integer :: across, along, i, j, k, n, parities(2), top

    along = self%strip_axis
    across = 3 - along
    parities = [corner_parity(along, component), corner_parity(across, component)]
    n = merge(self%columns, self%rows, along == 1)
    top = (images_along + 1) * n
    ! Beyond it the corner functions change by 1e-8 of themselves.
    far = 1.0e8_real64 * (n * self%side(along) + depth + &
                          self%side(across) * max(self%columns, self%rows))
    kernel = 0.0_real64
    !$omp parallel do private(steps, sums, i, k, left, right) schedule(dynamic)
    do j = 0, merge(self%rows, self%columns, along == 1) - 1
      allocate (steps(-top:top), sums(0:n - 1))
      do i = 0, top
        steps(i) = step_across((i + 0.5_real64) * self%side(along), j)
      end do
      steps(-1:-top:-1) = parities(1) * steps(0:top - 1)
      do i = 0, n - 1
        right = step_across((i + (images_along + 0.5_real64) * n) * self%side(along), j)
        left = parities(1) * step_across(((images_along + 0.5_real64) * n - i) * &
                                         self%side(along), j)
        sums(i) = ((1 - parities(1)) * step_across(far, j) - right + left) / n
        do k = -images_along, images_along
          sums(i) = sums(i) + steps(i + k * n) - steps(i + k * n - 1)
        end do
      end do
      sums = -sums / (2.0_real64 * pi)
      if (along == 1) then
        kernel(:, 1 + j) = sums
        if (j > 0) kernel(:, size(kernel, 2) + 1 - j) = -parities(2) * sums
      else
        kernel(1 + j, :) = sums
        if (j > 0) kernel(size(kernel, 1) + 1 - j, :) = -parities(2) * sums
      end if
      deallocate (steps, sums)
    end do
    !$omp end parallel do

  contains

    ! Difference of the corner function over a pixel across, at a place along.
    pure real(real64) function step_across(u, j)
      real(real64), intent(in) :: u
      integer, intent(in) :: j
      real(real64) :: v

      v = (j - 0.5_real64) * self%side(across)
      step_across = corner_along(u, v + self%side(across))
      if (j > 0) step_across = step_across - corner_along(u, v)
      if (j == 0) step_across = (1 - parities(2)) * step_across
    end function step_across

    pure real(real64) function corner_along(u, v)
      real(real64), intent(in) :: u, v

      if (along == 1) then
        corner_along = corner_function(component, u, v, depth, self%ratio)
      else
        corner_along = corner_function(component, v, u, depth, self%ratio)
      end if
    end function corner_along

  end subroutine fill_strip_kernel

  ! A corner function of the header, for X, Y and z more than 0.
  pure real(real64) function corner_function(component, x, y, z, ratio) result(corner)
    integer, intent(in) :: component
    real(real64), intent(in) :: x, y, z, ratio
    real(real64) :: r, solid

    r = sqrt(x**2 + y**2 + z**2)
    solid = atan(x * y / (z * r))
    select case (component)
    case (1)
      corner = lateral_corner(x, y)
    case (2)
      corner = lateral_corner(y, x)
    case (3)
      corner = solid + x * y * z / r * (1.0_real64 / (x**2 + z**2) + 1.0_real64 / (y**2 + z**2))
    case (4)
      corner = (1.0_real64 - 2.0_real64 * ratio) * log(r + z) + z / r
    case (5)
      corner = -z**2 * y / (r * (x**2 + z**2))
    case default
      corner = -z**2 * x / (r * (y**2 + z**2))
    end select

  contains

    pure real(real64) function lateral_corner(x, y)
      real(real64), intent(in) :: x, y

      lateral_corner = 2.0_real64 * ratio * solid + (1.0_real64 - 2.0_real64 * ratio) * &
                (atan(y / x) - atan(z * y / (x * r))) - z * x * y / (r * (x**2 + z**2))
    end function lateral_corner

  end function corner_function

  !> Equivalent stress of von Mises.
  pure real(real64) function von_mises(stress)
    real(real64), intent(in) :: stress(6)  !! the six components [pressure]

    von_mises = sqrt(0.5_real64 * ((stress(1) - stress(2))**2 + (stress(2) - stress(3))**2 + &
                                   (stress(3) - stress(1))**2) + &
                     3.0_real64 * sum(stress(4:)**2))
  end function von_mises

  !> Largest shear stress, half of the difference of the largest and the smallest principal stress:
  !> sqrt(J2) sin(theta + pi/3) with Lode's angle theta, cos(3 theta) = sqrt(27)/2 J3/J2**1.5.
  pure real(real64) function largest_shear(stress)
    real(real64), intent(in) :: stress(6)  !! the six components [pressure]
    real(real64) :: d(6), j2, j3, unit

    largest_shear = 0.0_real64
    unit = maxval(abs(stress))
    if (.not. unit > 0.0_real64) return
    d = stress / unit
    d(:3) = d(:3) - sum(d(:3)) / 3.0_real64
    j2 = 0.5_real64 * sum(d(:3)**2) + sum(d(4:)**2)
    if (.not. j2 > tiny(j2)**0.5_real64) return
    j3 = d(1) * d(2) * d(3) + 2.0_real64 * d(4) * d(5) * d(6) - d(1) * d(6)**2 - &
         d(2) * d(5)**2 - d(3) * d(4)**2
    largest_shear = unit * sqrt(j2) * sin((acos(max(-1.0_real64, min(1.0_real64, &
      sqrt(6.75_real64) * j3 / (j2 * sqrt(j2))))) + pi) / 3.0_real64)
  end function largest_shear

  !> Updates the largest von Mises and shear stresses with those of a depth.
  subroutine look_for_largest(field, depth, stress, largest)
    type(contact_field), intent(in) :: field             !! with the place of its first pixel
    real(real64), intent(in) :: depth                    !! depth below the surface [length]
    real(real64), intent(in) :: stress(:, :, :)          !! (column, row, component)
    type(largest_stress), intent(inout) :: largest(2)    !! of von Mises, of shear
    real(real64) :: found(2)
    integer :: i, j, k

    do j = 1, size(stress, 2)
      do i = 1, size(stress, 1)
        found = [von_mises(stress(i, j, :)), largest_shear(stress(i, j, :))]
        do k = 1, 2
          if (.not. found(k) > largest(k)%value) cycle
          largest(k)%value = found(k)
          largest(k)%depth = depth
          largest(k)%x = field%origin(1) + (i - 1) * field%pixel_spacing(1)
          largest(k)%y = field%origin(2) + (j - 1) * field%pixel_spacing(2)
        end do
      end do
    end do
  end subroutine look_for_largest

end module asperity_map_stress
