!> Tests of circles and boundary elements together, and of the error estimate of their coupling.
!>
!> Truths: boundary elements (see coupled_scenes); one contact alone; all contacts on one lattice.
module asperity_joint_suite
  use asperity_element_answer, only: element_answer
  use asperity_outside_field, only: outside_field
  use asperity_element_solver, only: cluster_lattice, solve_elements
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_contacts, only: coupled_solution
  use asperity_coupled_scenes, only: depth, known_scene, known_scenes, lay_contacts, &
                                     share_of, solve_at, truth_noise
  use asperity_hertz_law, only: hertz_law
  use asperity_joint_contacts, only: joint_solution, resolve_all, resolve_called_for, &
                                     resolve_none, solve_joint
  use asperity_kinds, only: real64
  use asperity_testing, only: check, run_test
  implicit none
  private

  public :: run_joint

  ! The error reported is observed, not proved: of four circles in a square that overlap it is 5 %
  ! less.
  real(real64), parameter :: seen = 0.9_real64

contains

  !> Runs the tests.
  subroutine run_joint
    call run_test('circles: corrected, with an error between theirs and that without', circles)
    call run_test('cells: the loads are those known', cells)
    call run_test('a tolerance is kept, with cells where it calls for them', called_for)
    call run_test('near contacts of a small share of the load stay circles', small_share)
    call run_test('a load asked for is met', load_met)
    call run_test('error of the compression by the tangent', error_of_compression)
    call run_test('clusters far apart are as all on one lattice', clusters)
  end subroutine run_joint

  ! Solves at one depth, or at a load; reports what went wrong.
  subroutine solve(pairs, law, which, tolerance, solution, what, target, compression)
    type(contact_pairs), intent(in) :: pairs
    type(hertz_law), intent(in) :: law
    integer, intent(in) :: which
    real(real64), intent(in) :: tolerance
    type(joint_solution), intent(out) :: solution
    character(*), intent(in) :: what
    real(real64), intent(in), optional :: target, compression

    solution%coupled%compression = depth
    if (present(compression)) solution%coupled%compression = compression
    call solve_joint(pairs, law, which, tolerance, 0.2_real64 * tolerance, 0.005_real64, solution, &
                     target)
    call check(.not. allocated(solution%failure), trim(what) // ': failed')
  end subroutine solve

  ! Where circles are apart the correction takes most of the error, and its size is the estimate:
  ! above the error that is left, and about that without a correction.
  subroutine circles
    type(known_scene) :: scenes(18), scene
    type(joint_solution) :: solution
    type(coupled_solution) :: uncorrected
    real(real64) :: before, off
    integer :: i

    scenes = known_scenes()
    do i = 1, size(scenes)
      scene = scenes(i)
      call solve_at(scene%pairs, scene%law, uncorrected)
      before = abs(share_of(scene%pairs, uncorrected) / scene%truth - 1)
      call solve(scene%pairs, scene%law, resolve_none, 0.01_real64, solution, scene%name)
      off = abs(share_of(scene%pairs, solution%coupled) / scene%truth - 1)
      call check(.not. any(solution%is_resolved) .and. solution%elements == 0, 'cells')
      call check(solution%error >= seen * off - truth_noise, trim(scene%name) // ': below')
      call check(off <= before + truth_noise, trim(scene%name) // ': worse')
      if (scene%overlapping) cycle
      call check(off <= 0.2_real64 * before + truth_noise, &
                 trim(scene%name) // ': hardly better')
      call check(solution%error <= 1.5_real64 * (before + truth_noise), &
                 trim(scene%name) // ': far above')
    end do
  end subroutine circles

  subroutine cells
    type(known_scene) :: scenes(18), scene
    type(joint_solution) :: solution
    integer :: i

    scenes = known_scenes()
    do i = 1, size(scenes)
      scene = scenes(i)
      call solve(scene%pairs, scene%law, resolve_all, 0.005_real64, solution, scene%name)
      call check(all(solution%is_resolved), 'not all')
      call check(share_of(scene%pairs, solution%coupled) / scene%truth, 1.0_real64, &
                 0.001_real64, scene%name)
    end do
  end subroutine cells

  subroutine called_for
    real(real64), parameter :: tolerances(3) = [0.01_real64, 0.003_real64, 0.001_real64]
    type(known_scene) :: scenes(18), scene
    type(joint_solution) :: solution
    real(real64) :: off
    integer :: i, k, with_cells(3)

    scenes = known_scenes()
    with_cells = 0
    do k = 1, 3
      do i = 1, size(scenes)
        scene = scenes(i)
        call solve(scene%pairs, scene%law, resolve_called_for, tolerances(k), solution, scene%name)
        off = abs(share_of(scene%pairs, solution%coupled) / scene%truth - 1)
        call check(off, 0.0_real64, tolerances(k), scene%name)
        call check(solution%error >= seen * off - truth_noise, trim(scene%name) // ': below')
        ! On cells alone they are far better than asked.
        if (all(solution%is_resolved)) call check(solution%error < 0.5_real64 * &
                                                  tolerances(k), trim(scene%name) // ': above')
        if (any(solution%is_resolved)) with_cells(k) = with_cells(k) + 1
      end do
    end do
    ! Two at ten radii need none; the tighter the tolerance, the more.
    call check(with_cells(1) > 0 .and. with_cells(3) < size(scenes), 'all or none')
    call check(with_cells(1) < with_cells(3), 'no more for a tighter tolerance')
  end subroutine called_for

  ! Two contacts whose first touches are within the circle of one, with 2e-3 of the load.
  subroutine small_share
    type(contact_pairs) :: pairs
    type(hertz_law) :: law
    type(joint_solution) :: solution
    integer :: i

    call lay_contacts([(200.0_real64 * i, i=1, 30), 0.0_real64, 0.05_real64], &
                      spread(0.0_real64, 1, 32), &
                      [spread(0.0_real64, 1, 30), spread(0.9_real64, 1, 2)], pairs, law)
    call solve(pairs, law, resolve_called_for, 0.01_real64, solution, 'small share')
    call check(solution%elements, 0, 'elements')
    call check(solution%error > 0.0_real64 .and. solution%error < 0.01_real64, 'error')
  end subroutine small_share

  subroutine load_met
    type(known_scene) :: scenes(18), scene
    type(joint_solution) :: solution
    real(real64) :: target, alone
    integer :: i, which

    scenes = known_scenes()
    do i = 1, size(scenes)
      scene = scenes(i)
      alone = scene%law%modulus * 4.0_real64 / 3.0_real64 * sum(sqrt(scene%pairs%list%radius) * &
              (depth - scene%pairs%list%gap)**1.5_real64)
      target = scene%truth * alone
      do which = resolve_none, resolve_called_for
        call solve(scene%pairs, scene%law, which, 0.003_real64, solution, scene%name, target)
        associate (coupled => solution%coupled)
          call check(scene%law%modulus * sum(coupled%set%load) / target, 1.0_real64, &
                     1.0e-10_real64, trim(scene%name) // ': load')
          ! Two thirds of the error of a load.
          if (which /= resolve_none) &
            call check(coupled%compression / depth, 1.0_real64, 0.003_real64, &
                       trim(scene%name) // ': compression')
        end associate
      end do
    end do
  end subroutine load_met

  ! L/(c dL/dc) by differences: the share reported is within a tenth above, and not below by more
  ! than its conjugate gradients leave.
  subroutine error_of_compression
    real(real64), parameter :: aside = 1.0e-4_real64
    type(known_scene) :: scenes(18), scene
    type(joint_solution) :: here, at_load, nearby(2)
    real(real64) :: load, share, tangent
    integer :: i, k

    scenes = known_scenes()
    do i = 1, size(scenes)
      scene = scenes(i)
      call solve(scene%pairs, scene%law, resolve_none, 0.01_real64, here, scene%name)
      ! One contact has none, but for rounding.
      load = scene%law%modulus * sum(here%coupled%set%load)
      if (.not. here%error > 1.0e-12_real64) cycle
      do k = 1, 2
        call solve(scene%pairs, scene%law, resolve_none, 0.01_real64, nearby(k), scene%name, &
                   compression=depth * (1 + (2 * k - 3) * aside))
      end do
      tangent = scene%law%modulus * (sum(nearby(2)%coupled%set%load) - &
                sum(nearby(1)%coupled%set%load)) / (2 * aside)
      call solve(scene%pairs, scene%law, resolve_none, 0.01_real64, at_load, scene%name, load)
      share = at_load%error / here%error * tangent / load
      call check(share, 1.045_real64, 0.055_real64, scene%name)
    end do
  end subroutine error_of_compression

  subroutine clusters
    type(contact_pairs) :: pairs
    type(hertz_law) :: law
    type(joint_solution) :: solution
    type(element_answer) :: answer
    type(outside_field) :: nothing
    type(cluster_lattice) :: lattice
    real(real64) :: together
    integer :: i

    call lay_contacts([0.0_real64, 1.5_real64, 40.0_real64, 41.8_real64, 40.9_real64], &
                      [0.0_real64, 0.3_real64, 0.0_real64, 0.0_real64, 1.3_real64], &
                      [0.0_real64, 0.1_real64, 0.15_real64, 0.2_real64, 0.4_real64], pairs, law)
    call solve(pairs, law, resolve_all, 0.005_real64, solution, 'clusters')
    call check(solution%clusters, 2, 'clusters')
    call solve_elements(pairs, [(i, i=1, 5)], depth, nothing, reshape( &
                        [5.0e-4_real64, 0.005_real64, 0.0_real64, 0.0_real64], [2, 2]), lattice, &
                        answer)
    together = sum(answer%contacts%load) / (4.0_real64 / 3.0_real64 * law%modulus * &
               sum(sqrt(pairs%list%radius) * (depth - pairs%list%gap)**1.5_real64))
    call check(share_of(pairs, solution%coupled) / together, 1.0_real64, 1.0e-3_real64, 'load')
    ! Each of both is within half a percent.
    call check(sum(solution%area) / sum(answer%contacts%area), 1.0_real64, 0.01_real64, 'area')
  end subroutine clusters

end module asperity_joint_suite
