!> The field of contacts that are neither near nor far: seven terms of the series of coupled_far.
!>
!> Pairs are taken some at a time, side by side, so that all becomes vectors.
module asperity_coupled_middle
  use asperity_kinds, only: real64
  use asperity_mutual_displacement, only: binomial, flat => flat_means, hertz => hertz_means, &
                                          root_terms, terms => terms_kept
  implicit none
  private

  public :: middle_pairs

  !> Pairs of contacts; the second of each carries load.
  type :: middle_pairs
    integer :: count = 0                  !! pairs
    integer, allocatable :: first(:)      !! contact
    integer, allocatable :: second(:)     !! contact with load
  contains
    procedure :: make_room
    procedure :: add
  end type middle_pairs

  integer, parameter :: lanes = 64

contains

  !> Makes room for more pairs.
  pure subroutine make_room(self, more)
    class(middle_pairs), intent(inout) :: self  !! the pairs
    integer, intent(in) :: more                 !! how many may be added
    integer, allocatable :: longer(:)

    if (.not. allocated(self%first)) allocate (self%first(0), self%second(0))
    if (self%count + more <= size(self%first)) return
    allocate (longer(2 * (self%count + more)))
    longer(:self%count) = self%first(:self%count)
    call move_alloc(longer, self%first)
    allocate (longer(2 * (self%count + more)))
    longer(:self%count) = self%second(:self%count)
    call move_alloc(longer, self%second)
  end subroutine make_room

  !> Adds what the two of each pair feel of each other.
  pure subroutine add(self, x, y, circle, load, scale, lift, tilt_x, tilt_y)
    class(middle_pairs), intent(in) :: self                   !! the pairs
    real(real64), contiguous, intent(in) :: x(:), y(:)        !! of all contacts
    real(real64), contiguous, intent(in) :: circle(:)         !! of all contacts
    real(real64), contiguous, intent(in) :: load(:)           !! vertical; 0 where open
    real(real64), intent(in) :: scale                         !! one over pi times the modulus
    real(real64), contiguous, intent(inout) :: lift(:)        !! gets more
    real(real64), contiguous, intent(inout) :: tilt_x(:)      !! gets more
    real(real64), contiguous, intent(inout) :: tilt_y(:)      !! gets more
    real(real64), dimension(lanes) :: dx, dy, a, b, on_first, on_second, slope
    integer :: i, j, k, l, used

    do k = 0, self%count - 1, lanes
      used = min(lanes, self%count - k)
      a = 0.0_real64
      b = 0.0_real64
      dx = 1.0_real64
      dy = 0.0_real64
      do l = 1, used
        i = self%first(k + l)
        j = self%second(k + l)
        dx(l) = x(i) - x(j)
        dy(l) = y(i) - y(j)
        a(l) = circle(i)
        b(l) = circle(j)
      end do
      call means(dx, dy, a, b, on_first, on_second, slope)
      do l = 1, used
        i = self%first(k + l)
        j = self%second(k + l)
        lift(i) = lift(i) + scale * load(j) * on_first(l)
        lift(j) = lift(j) + scale * load(i) * on_second(l)
        tilt_x(i) = tilt_x(i) - scale * load(j) * slope(l) * dx(l)
        tilt_y(i) = tilt_y(i) - scale * load(j) * slope(l) * dy(l)
        tilt_x(j) = tilt_x(j) + scale * load(i) * slope(l) * dx(l)
        tilt_y(j) = tilt_y(j) + scale * load(i) * slope(l) * dy(l)
      end do
    end do
  end subroutine add

  ! pi E times: the lift of each by the other, the slope over the distance.
  pure subroutine means(dx, dy, a, b, on_first, on_second, slope)
    real(real64), dimension(lanes), intent(in) :: dx, dy, a, b
    real(real64), dimension(lanes), intent(out) :: on_first, on_second, slope
    real(real64) :: a_power(lanes, 0:terms), b_power(lanes, 0:terms), w(lanes), part(lanes)
    integer :: k, m

    w = 1.0_real64 / (dx * dx + dy * dy)
    a_power(:, 0) = 1.0_real64
    b_power(:, 0) = 1.0_real64
    do k = 1, terms
      a_power(:, k) = a_power(:, k - 1) * (a * a * w)
      b_power(:, k) = b_power(:, k - 1) * (b * b * w)
    end do
    on_first = 0.0_real64
    on_second = 0.0_real64
    slope = 0.0_real64
    do k = terms, 0, -1
      do m = 0, k
        part = a_power(:, m) * b_power(:, k - m)
        on_first = on_first + (root_terms(k) * binomial(m, k) * flat(m) * hertz(k - m)) * part
        on_second = on_second + (root_terms(k) * binomial(m, k) * hertz(m) * flat(k - m)) * part
        slope = slope + &
                ((2 * k + 1) * root_terms(k) * binomial(m, k) * hertz(m) * hertz(k - m)) * part
      end do
    end do
    on_first = on_first * sqrt(w)
    on_second = on_second * sqrt(w)
    slope = slope * w * sqrt(w)
  end subroutine means

end module asperity_coupled_middle
