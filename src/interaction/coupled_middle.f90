!> The field of contacts that are neither near nor far: seven terms of the series of coupled_far.
!>
!> Pairs are taken some at a time, side by side, so that all becomes vectors.
module asperity_coupled_middle
  use asperity_kinds, only: real64
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

  integer, parameter :: lanes = 64, terms = 6
  integer :: loop
  ! 1/sqrt(1 - z) in powers of z; means of t**(2 k) over a row of radius 1, flat and Hertz'.
  real(real64), parameter :: root_terms(0:terms) = &
    [1.0_real64, 0.5_real64, 0.375_real64, 0.3125_real64, 0.2734375_real64, 0.24609375_real64, &
     0.2255859375_real64]
  real(real64), parameter :: flat(0:terms) = [(1.0_real64 / (2 * loop + 1), loop=0, terms)]
  real(real64), parameter :: hertz(0:terms) = &
    [(3.0_real64 / ((2 * loop + 1) * (2 * loop + 3)), loop=0, terms)]
  ! Even places of Pascal's triangle, by 2 k and 2 m.
  real(real64), parameter :: binomial(0:terms, 0:terms) = reshape(real([ &
    1, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 1, 6, 1, 0, 0, 0, 0, 1, 15, 15, 1, 0, 0, 0, &
    1, 28, 70, 28, 1, 0, 0, 1, 45, 210, 210, 45, 1, 0, 1, 66, 495, 924, 495, 66, 1], real64), &
    [terms + 1, terms + 1])

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
