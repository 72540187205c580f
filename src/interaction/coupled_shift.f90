!> How far aside a contact finds its place on the tilted surface that its neighbours leave.
!>
!> A paraboloid of radius R on a surface of slope t touches aside by R t. That holds for a tilt that
!> is level over the contact. On the flank of a neighbour R t is larger than the circle and the
!> slope is not level: there the shift is a part of R t, half of the circle's radius where R t is
!> not much larger, about half of R t itself where the circle is small. So it goes over without a
!> jump into the shift of an open contact: what touches next is known, and no contact snaps.
module asperity_coupled_shift
  use asperity_kinds, only: real64
  implicit none
  private

  public :: shift_law, shift_by_tilt, moved_by

  !> A shift and its derivatives.
  type :: shift_law
    real(real64) :: x = 0.0_real64         !! the shift
    real(real64) :: y = 0.0_real64         !! the shift
    real(real64) :: turn_xx = 0.0_real64   !! minus its derivatives by the tilt
    real(real64) :: turn_xy = 0.0_real64   !! the same
    real(real64) :: turn_yy = 0.0_real64   !! the same
    real(real64) :: grown_x = 0.0_real64   !! its derivative by the log of the circle's radius
    real(real64) :: grown_y = 0.0_real64   !! the same
  end type shift_law

contains

  !> The shift s = -g R t with g = (1 + (R t/cap)**4)**(-1/4), cap = sqrt(a**2 + (R t)**2)/2.
  pure subroutine shift_by_tilt(radius, circle, tilt_x, tilt_y, law)
    real(real64), intent(in) :: radius   !! combined radius R
    real(real64), intent(in) :: circle   !! radius of the contact circle a; 0 where open
    real(real64), intent(in) :: tilt_x   !! slope t of the neighbours' surface
    real(real64), intent(in) :: tilt_y   !! slope t of the neighbours' surface
    type(shift_law), intent(out) :: law  !! the shift
    real(real64) :: x, y, qq, h, share, bent

    x = radius * tilt_x
    y = radius * tilt_y
    qq = x * x + y * y
    h = 0.0_real64
    if (qq > 0.0_real64) h = qq / (circle * circle + qq)
    share = 1.0_real64 / sqrt(sqrt(1.0_real64 + 16 * h * h))
    ! q dg/dq; by the log of the circle it is the same with the other sign.
    bent = -16 * h * h * (1.0_real64 - h) * share**5
    law%x = -share * x
    law%y = -share * y
    law%turn_xx = radius * share
    law%turn_yy = radius * share
    if (.not. qq > 0.0_real64) return
    law%turn_xx = radius * (share + bent * x * x / qq)
    law%turn_xy = radius * bent * x * y / qq
    law%turn_yy = radius * (share + bent * y * y / qq)
    law%grown_x = bent * x
    law%grown_y = bent * y
  end subroutine shift_by_tilt

  !> How far a circle moves when it is off by (x, y): Newton's method with the bend of the surface.
  pure subroutine moved_by(law, bend_xx, bend_xy, bend_yy, x, y, move_x, move_y)
    type(shift_law), intent(in) :: law     !! of its shift
    real(real64), intent(in) :: bend_xx    !! second derivatives of the surface
    real(real64), intent(in) :: bend_xy    !! the same
    real(real64), intent(in) :: bend_yy    !! the same
    real(real64), intent(in) :: x          !! the shift it should have less the one it has
    real(real64), intent(in) :: y          !! the same
    real(real64), intent(out) :: move_x    !! the move
    real(real64), intent(out) :: move_y    !! the move
    real(real64) :: xx, xy, yy, mean, half, most, more

    xx = 1.0_real64 + law%turn_xx * bend_xx + law%turn_xy * bend_xy
    yy = 1.0_real64 + law%turn_yy * bend_yy + law%turn_xy * bend_xy
    xy = 0.5_real64 * (law%turn_xx * bend_xy + law%turn_xy * (bend_xx + bend_yy) + &
                       law%turn_yy * bend_xy)
    mean = 0.5_real64 * (xx + yy)
    half = hypot(0.5_real64 * (xx - yy), xy)
    ! The lesser eigenvalue is kept away from zero.
    more = max(0.0_real64, 0.3_real64 - (mean - half))
    xx = xx + more
    yy = yy + more
    most = xx * yy - xy * xy
    move_x = (yy * x - xy * y) / most
    move_y = (xx * y - xy * x) / most
  end subroutine moved_by

end module asperity_coupled_shift
