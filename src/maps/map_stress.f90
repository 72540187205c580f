!> Stress in a half-space under the pressures and tractions of a field.
!>
!> Problem: the six components of the stress at a depth z >= 0 under each pixel, with pressures and
!> tractions that are uniform on each pixel. Tension is positive; x and y are those of the map, z
!> points into the body. `asperity_stress_kernels` has the formulas.
!>
!> On a free map the integrals over a rectangle are convolved with pressures and tractions on a
!> padded lattice, which is exact to rounding. On a map that is periodic along one axis they are
!> summed over `images_along` periods on each side; the others are an integral along the axis by the
!> midpoint rule. On a periodic map the stresses are sums of waves.
module asperity_map_stress
  use asperity_constants, only: pi
  use asperity_contact_field, only: contact_field
  use asperity_height_map, only: layered_body
  use asperity_kinds, only: int64, not_computed, real64
  use asperity_lattice_convolution, only: padded_length
  use asperity_layer_stress, only: add_free_layer, along_axes, layer_stress, tabulate_layer
  use asperity_plane_transform, only: plane_transform
  use asperity_problems, only: real_text
  use asperity_process, only: check_memory
  use asperity_scene_values, only: scene
  use asperity_stress_kernels, only: by_pressure, by_traction_x, by_traction_y, corner_factor, &
                                     corner_function, corner_parity, grid_correction, &
                                     stress_of_wave
  implicit none
  private

  public :: check_stress, component_names, largest_shear, largest_stress, look_for_largest, &
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
    logical :: on_rim = .false.            !! within a pixel of the rim of the contact
  end type largest_stress

  !> Solver for the stresses in one body under one field. It owns plans: it must not be copied.
  type :: stress_solver
    private
    logical :: periodic = .false.
    integer :: strip_axis = 0                     ! axis of the period of a strip; 0: none
    type(layered_body) :: body
    real(real64) :: side(2) = 0.0_real64          ! of a pixel
    integer :: columns = 0, rows = 0              ! of the field
    logical :: uses(3) = .false.                  ! whether there are pressures, tractions x and y
    type(plane_transform) :: transform
    complex(real64), allocatable :: waves(:, :, :)    ! of the sources
    real(real64), allocatable :: steps(:, :, :, :)    ! of `grid_correction`; (.., column, row)
  contains
    procedure :: prepare => prepare_solver  !! transforms pressures and tractions
    procedure :: solve => solve_depth       !! computes the stresses at a depth
  end type stress_solver

  ! Periods on each side of a strip; the error is 2e-5 of the mean pressure over a period (derived:
  ! midpoint rule of a stress that falls as 1/x**2; test: strips in
  ! test/maps/test_map_stress.py).
  integer, parameter :: images_along = 16

contains

  !> Stresses in a body under the pressures and tractions of a field.
  subroutine stress_below(scene_in, field, depth, stress, failure, is_upper)
    type(scene), intent(in) :: scene_in          !! scene that was solved
    type(contact_field), intent(in) :: field     !! pressures of one of its states
    real(real64), intent(in) :: depth            !! depth below the surface, 0 or more [length]
    real(real64), allocatable, intent(out) :: stress(:, :, :)  !! (column, row, component)
    character(len=:), allocatable, intent(out) :: failure      !! reason when it is not computed
    logical, intent(in), optional :: is_upper    !! in the upper body; absent: in the lower one
    type(stress_solver) :: solver
    integer :: body

    body = 2
    if (present(is_upper)) body = merge(1, 2, is_upper)
    call check_stress(field, depth, scene_in%bodies(body), failure)
    if (allocated(failure)) return
    call solver%prepare(field, scene_in%bodies(body), body == 1)
    call solver%solve(depth, stress)
  end subroutine stress_below

  !> Sets the failure where stresses cannot be computed.
  subroutine check_stress(field, depth, body, failure)
    type(contact_field), intent(in) :: field     !! pressures of one state
    real(real64), intent(in) :: depth            !! depth below the surface [length]
    type(layered_body), intent(in) :: body       !! moduli of 0: unknown
    character(len=:), allocatable, intent(out) :: failure  !! reason when it is not computed

    if (.not. (depth >= 0.0_real64 .and. depth <= huge(depth))) then
      failure = 'depth: found ' // real_text(depth) // ', expected a number of 0 or more'
    else if (.not. allocated(field%pressure)) then
      failure = 'no fields: expected those of a state that was solved with fields'
    else if (.not. any(body%modulus > 0.0_real64)) then
      failure = no_ratio
    else if (body%thickness > 0.0_real64 .and. field%strip_axis > 0) then
      failure = 'stress under a layer: found a strip, expected both sides periodic or free'
    else if (body%thickness > 0.0_real64 .and. allocated(field%traction)) then
      failure = 'stress under a layer: found tractions, expected pressures alone'
    else
      call check_memory('the stresses', failure, bytes=room_for_stress(field))
    end if
  end subroutine check_stress

  !> Memory of the stresses at one depth with their table, bytes: waves and kernels of the padded
  !> pixels; components, cells and columns (counted; test: limits in test_python_maps.py).
  pure integer(int64) function room_for_stress(field) result(bytes)
    type(contact_field), intent(in) :: field  !! pressures on pixels
    integer, parameter :: bytes_padded = 56, bytes_plain = 256
    integer(int64) :: padded

    padded = int(padded_length(2 * field%columns), int64) * padded_length(2 * field%rows)
    if (field%periodic) padded = int(field%columns, int64) * field%rows
    bytes = bytes_padded * padded + bytes_plain * int(field%columns, int64) * field%rows
    if (allocated(field%traction)) bytes = 2_int64 * bytes
  end function room_for_stress

  !> Prepares the stresses in a body under pressures and tractions.
  subroutine prepare_solver(self, field, body, is_upper)
    class(stress_solver), intent(inout) :: self  !! solver without plans
    type(contact_field), intent(in) :: field     !! pressures and tractions on pixels
    type(layered_body), intent(in) :: body       !! material of it
    logical, intent(in) :: is_upper              !! whose tractions are those of the field reversed
    real(real64), allocatable :: traction(:, :)
    integer :: axis, beside(2), i, j, padded(2)

    self%periodic = field%periodic
    self%strip_axis = field%strip_axis
    self%body = body
    self%side = field%pixel_spacing
    self%columns = field%columns
    self%rows = field%rows
    padded = [field%columns, field%rows]
    where (.not. [self%periodic .or. self%strip_axis == 1, self%periodic .or. &
                  self%strip_axis == 2]) padded = padded_length(2 * padded)
    call self%transform%prepare(padded(1), padded(2))
    self%uses = [.true., allocated(field%traction), allocated(field%traction_y)]
    allocate (self%waves(0:self%transform%rows - 1, 0:self%transform%columns / 2, &
                         merge(3, 1, any(self%uses(2:)))))
    call self%transform%make_waves(merge(field%pressure, 0.0_real64, &
                                        field%pressure > not_computed), self%waves(:, :, 1))
    if (.not. any(self%uses(2:))) return
    allocate (self%steps(2, 2, self%columns, self%rows), source=0.0_real64)
    do axis = 1, 2
      if (.not. self%uses(1 + axis)) cycle
      if (axis == 1) allocate (traction, source=field%traction)
      if (axis == 2) allocate (traction, source=field%traction_y)
      where (.not. traction > not_computed) traction = 0.0_real64
      if (is_upper) traction = -traction
      call self%transform%make_waves(traction, self%waves(:, :, 1 + axis))
      do j = 1, self%rows
        do i = 1, self%columns
          beside = places_beside(i, self%columns, 1)
          self%steps(axis, 1, i, j) = 0.5_real64 * (traction(beside(2), j) - traction(beside(1), j))
          beside = places_beside(j, self%rows, 2)
          self%steps(axis, 2, i, j) = 0.5_real64 * (traction(i, beside(2)) - traction(i, beside(1)))
        end do
      end do
      deallocate (traction)
    end do

  contains

    ! The places before and behind one; at the edge of a free map itself.
    pure function places_beside(place, number, axis) result(beside)
      integer, intent(in) :: place, number, axis
      integer :: beside(2)

      beside = [place - 1, place + 1]
      if (self%strip_axis == axis) beside = 1 + modulo(beside - 1, number)
      beside = max(1, min(number, beside))
    end function places_beside

  end subroutine prepare_solver

  !> Computes the components at a depth.
  subroutine solve_depth(self, depth, stress)
    class(stress_solver), intent(in) :: self         !! solver with the pressures
    real(real64), intent(in) :: depth                !! depth below the surface, 0 or more
    real(real64), allocatable, intent(out) :: stress(:, :, :)  !! (column, row, component)
    complex(real64), allocatable :: of_kernel(:, :), waves(:, :)
    real(real64), allocatable :: kernel(:, :), of_layer(:, :, :), tables(:, :)
    real(real64) :: step
    integer :: i, j, k, source

    if (self%body%thickness > 0.0_real64 .and. .not. self%periodic) then
      call tabulate_layer(self%body, depth, norm2(self%side * [self%columns, self%rows]), step, &
                          tables)
    else if (self%body%thickness > 0.0_real64) then
      allocate (of_layer(4, 0:self%rows / 2, 0:self%columns / 2), source=0.0_real64)
      !$omp parallel do private(j)
      do i = 0, self%columns / 2
        do j = merge(1, 0, i == 0), self%rows / 2
          of_layer(:, j, i) = layer_stress(self%body, 2.0_real64 * pi * norm2( &
            [i, j] / ([self%columns, self%rows] * self%side)), depth)
        end do
      end do
      !$omp end parallel do
    end if
    allocate (stress(self%columns, self%rows, size(component_names)))
    allocate (waves, mold=self%waves(:, :, 1))
    if (.not. self%periodic) allocate (kernel(self%transform%columns, self%transform%rows))
    if (.not. self%periodic) allocate (of_kernel, mold=waves)
    do k = 1, size(component_names)
      if (self%periodic) call multiply_waves(self, of_layer, depth, k, waves)
      do source = 1, merge(0, size(self%waves, 3), self%periodic)
        if (.not. self%uses(source)) cycle
        if (self%strip_axis > 0) then
          call fill_strip_kernel(self, depth, source, k, kernel)
        else
          call fill_kernel(self, depth, source, k, kernel)
          if (allocated(tables)) call add_free_layer( &
            tables, step, self%side / self%body%thickness, [self%columns, self%rows], k, kernel)
        end if
        call self%transform%make_waves(kernel, of_kernel)
        of_kernel = of_kernel * self%waves(:, :, source)
        if (source == by_pressure) waves = of_kernel
        if (source > by_pressure) waves = waves + of_kernel
      end do
      call self%transform%sum_waves(waves, stress(:, :, k))
      if (self%periodic .or. .not. allocated(self%steps)) cycle
      do j = 1, self%rows
        do i = 1, self%columns
          stress(i, j, k) = stress(i, j, k) + grid_correction( &
            k, depth, self%side, self%body%ratio(1), self%steps(:, :, i, j))
        end do
      end do
    end do
  end subroutine solve_depth

  ! The waves of a component on a periodic map.
  subroutine multiply_waves(self, of_layer, depth, component, waves)
    class(stress_solver), intent(in) :: self
    !> (stress, wave number in y, in x): `layer_stress`; not allocated: there is no layer
    real(real64), allocatable, intent(in) :: of_layer(:, :, :)
    real(real64), intent(in) :: depth
    integer, intent(in) :: component
    complex(real64), intent(out) :: waves(0:, 0:)
    real(real64) :: odd(2), wave(2)
    integer :: i, j, n, source

    n = self%transform%rows
    do i = 0, self%transform%columns / 2
      do j = 0, n - 1
        wave = 2.0_real64 * pi * [i, merge(j - n, j, 2 * j > n)] / &
               ([self%transform%columns, n] * self%side)
        odd = merge(0.0_real64, wave, 2 * [i, j] == [self%transform%columns, n])
        if (allocated(of_layer) .and. i + j > 0) then
          waves(j, i) = along_axes(component, wave, odd, of_layer(:, min(j, n - j), i)) * &
                        self%waves(j, i, by_pressure)
          cycle
        end if
        waves(j, i) = stress_of_wave(by_pressure, component, wave, odd, depth, &
                                     self%body%ratio(1)) * self%waves(j, i, by_pressure)
        do source = by_traction_x, merge(by_traction_y, 0, any(self%uses(by_traction_x:)))
          if (self%uses(source)) waves(j, i) = waves(j, i) + stress_of_wave( &
            source, component, wave, odd, depth, self%body%ratio(1)) * &
            self%waves(j, i, source)
        end do
      end do
    end do
  end subroutine multiply_waves

  ! The influence of a unit pressure of a pixel on a component, by the offset of the point, from the
  ! corner function in one quadrant.
  subroutine fill_kernel(self, depth, source, component, kernel)
    class(stress_solver), intent(in) :: self
    real(real64), intent(in) :: depth
    integer, intent(in) :: source, component
    real(real64), intent(out) :: kernel(:, :)
    real(real64), allocatable :: corner(:, :)
    integer :: i, j, mirrored(2)

    mirrored = corner_parity(source, component)
    allocate (corner(-self%columns:self%columns - 1, -self%rows:self%rows - 1))
    !$omp parallel do
    do j = 0, self%rows - 1
      do i = 0, self%columns - 1
        corner(i, j) = corner_function(source, component, (i + 0.5_real64) * self%side(1), &
                                       (j + 0.5_real64) * self%side(2), depth, self%body%ratio(1))
      end do
      corner(-1:-self%columns:-1, j) = mirrored(1) * corner(0:, j)
    end do
    !$omp end parallel do
    do j = 0, self%rows - 1
      corner(:, -1 - j) = mirrored(2) * corner(:, j)
    end do
    kernel = 0.0_real64
    do j = 1 - self%rows, self%rows - 1
      do i = 1 - self%columns, self%columns - 1
        kernel(1 + modulo(i, size(kernel, 1)), 1 + modulo(j, size(kernel, 2))) = &
          corner_factor(source) * (corner(i, j) - corner(i - 1, j) - corner(i, j - 1) + &
                                   corner(i - 1, j - 1)) / (2.0_real64 * pi)
      end do
    end do
  end subroutine fill_kernel

  ! The same for a strip: u is along its period, v across.
  subroutine fill_strip_kernel(self, depth, source, component, kernel)
    class(stress_solver), intent(in) :: self
    real(real64), intent(in) :: depth
    integer, intent(in) :: source, component
    real(real64), intent(out) :: kernel(:, :)
    real(real64), allocatable :: steps(:), sums(:)
    real(real64) :: far, right, left
    integer :: across, along, i, j, k, n, parities(2), top

    along = self%strip_axis
    across = 3 - along
    parities = corner_parity(source, component)
    parities = parities([along, across])
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
      sums = corner_factor(source) * sums / (2.0_real64 * pi)
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
        corner_along = corner_function(source, component, u, v, depth, self%body%ratio(1))
      else
        corner_along = corner_function(source, component, v, u, depth, self%body%ratio(1))
      end if
    end function corner_along

  end subroutine fill_strip_kernel

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
          associate (near => field%pressure(max(1, i - 1):min(i + 1, field%columns), &
                                            max(1, j - 1):min(j + 1, field%rows)) > 0.0_real64)
            largest(k)%on_rim = depth < minval(field%pixel_spacing) .and. any(near) .and. &
                                .not. all(near)
          end associate
        end do
      end do
    end do
  end subroutine look_for_largest

end module asperity_map_stress
