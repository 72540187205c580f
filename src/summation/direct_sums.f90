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
    real(real64), intent(in) :: source(:, :)                 !! columns, in the order of the boxes
    real(real64), allocatable, intent(inout) :: about(:, :)  !! the same as rows; grows
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
          j = n + last - this%source(1, b) + 1
          if (j > size(about, 1)) then
            allocate (more(2 * j, 7))
            more(:n, :) = about(:n, :)
            call move_alloc(more, about)
          end if
          do j = this%source(1, b), last
            n = n + 1
            about(n, :) = source(:, j)
          end do
        end do
        a = this%parent(a)
      end associate
    end do
  end subroutine gather_sources

  !> Adds what sources do at a target. What is near was told by the same sums when the tree was
  !> planted; nothing acts on its own place.
  pure subroutine add_direct(about, n, target, value)
    real(real64), contiguous, intent(in) :: about(:, :)  !! planted x, y and limit; x, y, charges
    integer, intent(in) :: n                             !! rows that count
    real(real64), intent(in) :: target(5)                !! planted x, y and limit; x, y
    real(real64), intent(inout) :: value(4)              !! potential, Laplacian, slopes
    real(real64), dimension(lanes) :: phi, lap, gx, gy
    integer :: k, l

    phi = 0.0_real64
    lap = 0.0_real64
    gx = 0.0_real64
    gy = 0.0_real64
    ! Side by side in lanes that are added at the end: the same bytes however it is compiled.
    do k = 0, n - lanes, lanes
      do l = 1, lanes
        call add_one(about(k + l, 1), about(k + l, 2), about(k + l, 3), about(k + l, 4), &
                     about(k + l, 5), about(k + l, 6), about(k + l, 7), phi(l), lap(l), gx(l), &
                     gy(l))
      end do
    end do
    do k = n - modulo(n, lanes) + 1, n
      call add_one(about(k, 1), about(k, 2), about(k, 3), about(k, 4), about(k, 5), about(k, 6), &
                   about(k, 7), phi(1), lap(1), gx(1), gy(1))
    end do
    value = value + [((phi(1) + phi(2)) + (phi(3) + phi(4))), &
                     ((lap(1) + lap(2)) + (lap(3) + lap(4))), &
                     ((gx(1) + gx(2)) + (gx(3) + gx(4))), ((gy(1) + gy(2)) + (gy(3) + gy(4)))]

  contains

    pure subroutine add_one(x, y, limit_there, moved_x, moved_y, charge_there, spread_there, phi, &
                            lap, gx, gy)
      real(real64), intent(in) :: x, y, limit_there, moved_x, moved_y, charge_there, spread_there
      real(real64), intent(inout) :: phi, lap, gx, gy
      real(real64) :: dx, dy, counts, limit, inverse, first, third, charge, spread

      limit = limit_there + target(3)
      ! 1, or 0 when they are near or, without reaches, coincide.
      counts = 0.5_real64 + sign(0.5_real64, (x - target(1))**2 + (y - target(2))**2 - &
                                 (limit * limit + tiny(limit)))
      dx = target(4) - moved_x
      dy = target(5) - moved_y
      inverse = 1.0_real64 / ((dx * dx + dy * dy) * counts + (1.0_real64 - counts))
      charge = charge_there * counts
      spread = spread_there * counts
      first = sqrt(inverse)
      third = first * inverse
      phi = phi + (charge * first + spread * third)
      lap = lap + (charge + 9.0_real64 * spread * inverse) * third
      third = (charge + 3.0_real64 * spread * inverse) * third
      gx = gx - third * dx
      gy = gy - third * dy
    end subroutine add_one

  end subroutine add_direct

end module asperity_direct_sums
