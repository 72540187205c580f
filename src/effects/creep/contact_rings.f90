!> Contact of two spheres of a viscoelastic solid whose area may shrink and grow again.
!>
!> The pressures of a round contact are those of rings a <= contact radius, each a flat punch. The
!> ring of the radius a, with w = a**2/R, has its contact at the overlap W = w, then the
!> displacement W - w, and a force f that is the hereditary integral of its displacement alone. It
!> leaves contact where f = 0, and recovers without force (Graham, Q. Appl. Math. 26 (1968) 167;
!> Popov and Hess, Method of Dimensionality Reduction, Springer 2015, chapter 8). On unloading the
!> rim of the contact has the a(t1) = a(t) of Ting (J. Appl. Mech. 33 (1966) 845):
!>
!>     integral from t1 to t of E(t - s) dW(s) = 0
!>
!> With the loads Pe(w) and the greatest pressures pe(w) of Hertz at the overlap w
!>
!>     P = -integral of df/dw dPe(w),     p = -integral of df/dw dpe(w)
!>
!> up to the rim, where f = 0: on loading the integral of E(t - s) dPe(s). Rings are kept at the
!> rims of the earlier states; f is linear in w between them, so that elastic loads are exact.
module asperity_contact_rings
  use asperity_kinds, only: real64
  use asperity_viscoelastic_solid, only: history_of, keep_load, solid_step
  implicit none
  private

  public :: contact_rings, has_shrunk, keep_rings, measure_rings

  ! Least distance of two rings, overlap over the largest one (chosen: it bounds their number, and
  ! its square is the error; test: test_ball_up_and_down of test_creep.py).
  real(real64), parameter :: least_distance = 4.0e-3_real64
  ! Decrease of an overlap by rounding, relative (chosen).
  real(real64), parameter :: rounding = 1.0e-9_real64

  !> Memory of the rings of one contact, from its centre to the largest rim.
  type :: contact_rings
    real(real64), allocatable :: overlap(:)      !! overlap w of first contact, ascending from 0
    !> (1, ring): displacement without force that recovers; then parts of the force that relax
    real(real64), allocatable :: memory(:, :)
    real(real64) :: last = 0.0_real64            !! overlap at the last state
  end type contact_rings

contains

  !> Whether an overlap is smaller than the last one, where there was a contact.
  pure logical function has_shrunk(rings, overlap)
    type(contact_rings), intent(in) :: rings  !! rings at the last state
    real(real64), intent(in) :: overlap       !! overlap at the end of a step

    has_shrunk = rings%last > 0.0_real64 .and. overlap < rings%last * (1.0_real64 - rounding)
  end function has_shrunk

  !> Finds load, greatest pressure and rim at the end of a step.
  pure subroutine measure_rings(rings, step, overlap, rim, shares)
    type(contact_rings), intent(in) :: rings  !! rings at the begin of the step
    type(solid_step), intent(in) :: step      !! coefficients of the step
    real(real64), intent(in) :: overlap       !! overlap W at its end, more than 0
    real(real64), intent(out) :: rim          !! overlap w of the rim over W; 0: open
    real(real64), intent(out) :: shares(2)    !! load and pressure over those of Hertz at W
    real(real64) :: forces(size(rings%overlap) + 1), ends(size(rings%overlap) + 1), before, slope
    integer :: j

    ! Beyond the last ring the surface has had no contact, and the rim is that of Hertz.
    ends = [rings%overlap, max(overlap, rings%overlap(size(rings%overlap)))] / overlap
    forces = [forces_of(rings, step, overlap) / overlap, 0.0_real64]
    rim = 0.0_real64
    shares = 0.0_real64
    do j = 1, size(rings%overlap)
      if (.not. forces(j) > 0.0_real64) return
      before = ends(j)
      rim = ends(j + 1)
      if (.not. rim > before) return
      slope = (forces(j) - forces(j + 1)) / (rim - before)
      if (forces(j + 1) < 0.0_real64) rim = before + forces(j) / slope
      shares = shares + slope * [rim * sqrt(rim) - before * sqrt(before), sqrt(rim) - sqrt(before)]
    end do
  end subroutine measure_rings

  !> Keeps the rings at the end of a step, with one at the new rim.
  pure subroutine keep_rings(rings, step, overlap)
    type(contact_rings), intent(inout) :: rings  !! rings at the begin, then at the end
    type(solid_step), intent(in) :: step         !! coefficients of the step
    real(real64), intent(in) :: overlap          !! overlap W at its end; 0: open
    real(real64), allocatable :: forces(:)
    real(real64) :: rim, shares(2)
    integer :: j, n

    if (.not. allocated(rings%overlap)) then
      if (.not. overlap > 0.0_real64) return
      allocate (rings%overlap(0), rings%memory(1 + step%terms, 0))
      call add_ring(rings, 0, 0.0_real64)
    end if
    n = size(rings%overlap)
    if (overlap > rings%overlap(n)) then
      if (n > 2) then
        if (overlap - rings%overlap(n - 1) < least_distance * overlap) n = n - 1
      end if
      call add_ring(rings, n, overlap)
    else if (overlap > 0.0_real64) then
      call measure_rings(rings, step, overlap, rim, shares)
      j = count(rings%overlap < rim * overlap)
      if (j > 0 .and. j < n) then
        if (min(rim * overlap - rings%overlap(j), rings%overlap(j + 1) - rim * overlap) > &
            least_distance * rings%overlap(n)) call add_ring(rings, j, rim * overlap)
      end if
    end if
    allocate (forces(size(rings%overlap)), source=0.0_real64)
    if (overlap > 0.0_real64) forces = max(0.0_real64, forces_of(rings, step, overlap))
    do j = 1, size(forces)
      call keep_load(step, forces(j), rings%memory(1, j), rings%memory(2:, j))
    end do
    rings%last = overlap
  end subroutine keep_rings

  ! Adds a ring after the first n: between two rings with the mean memory of both, else as the last
  ! one without memory, in the place of those beyond n.
  pure subroutine add_ring(rings, n, overlap)
    type(contact_rings), intent(inout) :: rings
    integer, intent(in) :: n
    real(real64), intent(in) :: overlap
    real(real64) :: memory(size(rings%memory, 1)), part
    integer :: last

    memory = 0.0_real64
    last = size(rings%overlap)
    if (n < last) then
      if (overlap < rings%overlap(last)) then
        part = (overlap - rings%overlap(n)) / (rings%overlap(n + 1) - rings%overlap(n))
        memory = rings%memory(:, n) + part * (rings%memory(:, n + 1) - rings%memory(:, n))
      else
        last = n
      end if
    end if
    rings%overlap = [rings%overlap(:n), overlap, rings%overlap(n + 1:last)]
    rings%memory = reshape([rings%memory(:, :n), memory, rings%memory(:, n + 1:last)], &
                           [size(memory), last + 1])
  end subroutine add_ring

  ! Forces of the rings at an overlap, below 0 where a ring has left contact.
  pure function forces_of(rings, step, overlap) result(forces)
    type(contact_rings), intent(in) :: rings
    type(solid_step), intent(in) :: step
    real(real64), intent(in) :: overlap
    real(real64) :: forces(size(rings%overlap))
    integer :: j

    do j = 1, size(forces)
      forces(j) = step%gain * (overlap - rings%overlap(j)) + &
                  history_of(step, rings%memory(1, j), rings%memory(2:, j))
    end do
  end function forces_of

end module asperity_contact_rings
