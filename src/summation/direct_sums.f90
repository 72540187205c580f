!> What sources in boxes close by do at a place, one by one.
module asperity_direct_sums
  use asperity_box_tree, only: box_tree
  use asperity_kinds, only: real64
  implicit none
  private

  public :: add_direct, gather_sources

  ! Sums side by side.
  integer, parameter :: lanes = 4

contains

  !> The sources that act place by place on what is in a box and in none of its children.
  pure subroutine gather_sources(boxes, depth, box, source, about, n)
    type(box_tree), intent(in) :: boxes                      !! all
    integer, intent(in) :: depth                             !! level of the box
    integer, intent(in) :: box                               !! its place in the level
    real(real64), intent(in) :: source(:, :)                 !! rows, in the order of the boxes
    real(real64), allocatable, intent(inout) :: about(:, :)  !! those of them; grows
    integer, intent(out) :: n                                !! how many rows count
    real(real64), allocatable :: more(:, :)
    integer :: l, a, b, k, j, last

    n = 0
    a = box
    do l = depth, 0, -1
      associate (this => boxes%level(l))
        do k = this%first(a), this%first(a + 1) - 1
          b = abs(this%near(k))
          last = this%source(3, b)
          ! What children of both boxes do was settled in the levels below.
          if (l < depth .and. this%near(k) < 0) last = this%source(2, b)
          associate (rows => source(this%source(1, b):last, :))
            if (n + size(rows, 1) + lanes > size(about, 1)) then
              allocate (more(2 * (n + size(rows, 1) + lanes), size(source, 2)))
              more(:n, :) = about(:n, :)
              call move_alloc(more, about)
            end if
            do j = 1, size(source, 2)
              about(n + 1:n + size(rows, 1), j) = rows(:, j)
            end do
            n = n + size(rows, 1)
          end associate
        end do
        a = this%parent(a)
      end associate
    end do
    ! Whole lanes: what is more has no charge.
    if (n == 0 .or. size(about, 2) < 7) return
    do j = 1, 7
      about(n + 1:n + lanes, j) = merge(0.0_real64, about(n, j), j > 5)
    end do
  end subroutine gather_sources

  !> Adds what sources do at a target. What is near was told by the same sums when the tree was
  !> planted; nothing acts on its own place.
  pure subroutine add_direct(about, n, target, rough, value)
    real(real64), contiguous, intent(in) :: about(:, :)  !! planted x, y and limit; x, y, charges
    integer, intent(in) :: n                             !! rows that count
    real(real64), intent(in) :: target(6)                !! planted x, y and limit; x, y, spread
    logical, intent(in) :: rough                         !! only the potential; spreads twice
    real(real64), intent(inout) :: value(4)              !! potential, Laplacian, slopes
    real(real64), dimension(lanes) :: phi, lap, gx, gy, counts, dx, dy, square
    real(real64) :: charge, limit, spread, third
    integer :: k, l

    phi = 0.0_real64
    lap = 0.0_real64
    gx = 0.0_real64
    gy = 0.0_real64
    ! Side by side in lanes that are added at the end: the same bytes however it is compiled.
    do k = 0, n - 1, lanes
      !$omp simd private(limit)
      do l = 1, lanes
        ! 1, or 0 when they are near or, without reaches, coincide.
        limit = about(k + l, 3) + target(3)
        counts(l) = 0.5_real64 + sign(0.5_real64, (about(k + l, 1) - target(1))**2 + &
          (about(k + l, 2) - target(2))**2 - (limit * limit + tiny(limit)))
        dx(l) = target(4) - about(k + l, 4)
        dy(l) = target(5) - about(k + l, 5)
        square(l) = (dx(l)**2 + dy(l)**2) * counts(l) + (1.0_real64 - counts(l))
      end do
      if (rough) then
        !$omp simd private(charge, spread, third)
        do l = 1, lanes
          ! 1/r + spread/r**3, but for terms in 1/r**5; a move may have made r small.
          phi(l) = phi(l) + about(k + l, 6) * counts(l) / &
                   sqrt(max(square(l) - (about(k + l, 7) + target(6)), 0.5_real64 * square(l)))
        end do
      else
        !$omp simd private(charge, spread, third)
        do l = 1, lanes
          square(l) = 1.0_real64 / square(l)
          charge = about(k + l, 6) * counts(l)
          spread = about(k + l, 7) * counts(l) * square(l)
          third = sqrt(square(l))
          phi(l) = phi(l) + (charge + spread) * third
          third = third * square(l)
          lap(l) = lap(l) + (charge + 9.0_real64 * spread) * third
          third = (charge + 3.0_real64 * spread) * third
          gx(l) = gx(l) - third * dx(l)
          gy(l) = gy(l) - third * dy(l)
        end do
      end if
    end do
    value = value + [((phi(1) + phi(2)) + (phi(3) + phi(4))), &
                     ((lap(1) + lap(2)) + (lap(3) + lap(4))), &
                     ((gx(1) + gx(2)) + (gx(3) + gx(4))), ((gy(1) + gy(2)) + (gy(3) + gy(4)))]
  end subroutine add_direct

end module asperity_direct_sums
