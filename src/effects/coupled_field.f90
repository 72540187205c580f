!> The field that contacts spread over one another, and the matrix of their compliances.
!>
!> Near neighbours take the closed forms of mutual_displacement. Far ones take the first terms of
!> the same integral in powers of 1/r**2: pi E times a mean is the sum over k of
!> c(k) <tau**(2 k)> / r**(2 k + 1), c = 1, 1/2, 3/8, 5/16, 35/128 as in 1/sqrt(1 - z). The inner
!> loops run over the contacts that feel one source: no sum need be split to make them vectors.
module asperity_coupled_field
  use asperity_kinds, only: real32, real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms
  implicit none
  private

  public :: contact_field, spread_field

  !> Contacts side by side, those with load first, and what they feel of each other.
  type :: contact_field
    integer :: loaded = 0                     !! the first so many carry load
    integer :: count = 0                      !! all
    real(real64), allocatable :: x(:)         !! place in plan, shift included
    real(real64), allocatable :: y(:)         !! place in plan, shift included
    real(real64), allocatable :: circle(:)    !! radius of the contact circle; 0 where open
    real(real64), allocatable :: load(:)      !! vertical; 0 where open
    real(real64), allocatable :: lift(:)      !! displacement by the others
    real(real64), allocatable :: growth(:)    !! its change with the log of the own circle's radius
    real(real64), allocatable :: tilt_x(:)    !! slope of the others' surface
    real(real64), allocatable :: tilt_y(:)    !! slope of the others' surface
    real(real32), allocatable :: compliance(:, :)  !! between the loaded, zero on the diagonal
  end type contact_field

  real(real64), parameter :: pi = acos(-1.0_real64)
  ! Sums of radii from which on the series serves: its first term left out is 5e-13 of the
  ! penetration there, which is less than the closed form loses by rounding.
  real(real64), parameter :: far_from = 7.0_real64

contains

  !> Fills lift, growth, tilts and compliance.
  pure subroutine spread_field(field, modulus)
    type(contact_field), intent(inout) :: field !! the contacts
    real(real64), intent(in) :: modulus         !! combined
    real(real64) :: scale
    logical, allocatable :: near(:)
    integer :: i, j, n

    n = field%count
    scale = 1.0_real64 / modulus
    allocate (near(n))
    field%lift(1:n) = 0.0_real64
    field%growth(1:n) = 0.0_real64
    field%tilt_x(1:n) = 0.0_real64
    field%tilt_y(1:n) = 0.0_real64
    do j = 1, field%loaded
      call add_far(field, j, scale / pi, near)
      ! Loaded neighbours come twice and are taken once; open ones only feel.
      do i = 1, j - 1
        if (near(i)) call add_near(field, i, j, scale)
      end do
      field%compliance(j, j) = 0.0_real32
      do i = field%loaded + 1, n
        if (near(i)) call add_near(field, i, j, scale)
      end do
    end do
  end subroutine spread_field

  ! What all that are far from one source feel of it.
  pure subroutine add_far(field, source, scale, near)
    type(contact_field), intent(inout) :: field
    integer, intent(in) :: source
    real(real64), intent(in) :: scale
    logical, intent(out) :: near(:)
    real(real64) :: x, y, b, b2, load, hertz2, hertz4, hertz6, hertz8, flat4, flat6
    integer :: m, n

    m = field%loaded
    n = field%count
    x = field%x(source)
    y = field%y(source)
    load = field%load(source) * scale
    b = field%circle(source)
    ! Means of tau**2, 4, 6, 8 over the source.
    b2 = b * b
    hertz2 = b2 / 5
    hertz4 = 3 * b2**2 / 35
    hertz6 = b2**3 / 21
    hertz8 = b2**4 / 33
    flat4 = b2**2 / 5
    flat6 = b2**3 / 7
    call feel(field%x(:n), field%y(:n), field%circle(:n), field%lift(:n), field%growth(:n), &
              field%tilt_x(:n), field%tilt_y(:n), near(:n))
    if (m > 0) call comply(field%x(:m), field%y(:m), field%circle(:m), &
                           field%compliance(:m, source))

  contains

    pure subroutine feel(px, py, a, lift, growth, tilt_x, tilt_y, is_near)
      real(real64), contiguous, intent(in) :: px(:), py(:), a(:)
      real(real64), contiguous, intent(inout) :: lift(:), growth(:), tilt_x(:), tilt_y(:)
      logical, contiguous, intent(out) :: is_near(:)
      real(real64) :: dx, dy, rr, w, root, a2, t1, t2, t3, t4, slope, limit, part
      integer :: i

      do i = 1, size(px)
        dx = px(i) - x
        dy = py(i) - y
        rr = dx * dx + dy * dy
        limit = (far_from * (a(i) + b))**2
        is_near(i) = rr <= limit
        part = merge(0.0_real64, load, rr <= limit)
        w = 1.0_real64 / max(rr, limit)
        root = part * sqrt(w)
        a2 = a(i) * a(i)
        t1 = a2 / 3 + hertz2
        t2 = a2 * (a2 / 5 + 2 * hertz2) + hertz4
        t3 = a2 * (a2 * (a2 / 7 + 3 * hertz2) + 5 * hertz4) + hertz6
        t4 = a2 * (a2 * (a2 * (a2 / 9 + 4 * hertz2) + 14 * hertz4) + (28.0_real64 / 3) * hertz6) + &
             hertz8
        lift(i) = lift(i) + root * (1.0_real64 + w * (0.5_real64 * t1 + w * (0.375_real64 * t2 + &
                  w * (0.3125_real64 * t3 + w * 0.2734375_real64 * t4))))
        growth(i) = growth(i) + root * w * a2 / 3
        ! Here both circles have Hertz' weight.
        t1 = a2 / 5 + hertz2
        t2 = a2 * (3 * a2 / 35 + 1.2_real64 * hertz2) + hertz4
        t3 = a2 * (a2 * (a2 / 21 + (9.0_real64 / 7) * hertz2) + 3 * hertz4) + hertz6
        slope = root * w * (1.0_real64 + w * (1.5_real64 * t1 + w * (1.875_real64 * t2 + &
                w * 2.1875_real64 * t3)))
        tilt_x(i) = tilt_x(i) - slope * dx
        tilt_y(i) = tilt_y(i) - slope * dy
      end do
    end subroutine feel

    pure subroutine comply(px, py, a, compliance)
      real(real64), contiguous, intent(in) :: px(:), py(:), a(:)
      real(real32), contiguous, intent(out) :: compliance(:)
      real(real64) :: rr, w, a2, t1, t2, t3
      integer :: i

      do i = 1, size(px)
        rr = (px(i) - x)**2 + (py(i) - y)**2
        w = 1.0_real64 / max(rr, (far_from * (a(i) + b))**2)
        a2 = a(i) * a(i)
        t1 = (a2 + b2) / 3
        t2 = a2 * (a2 / 5 + (2.0_real64 / 3) * b2) + flat4
        t3 = a2 * (a2 * (a2 / 7 + b2) + b2 * b2) + flat6
        compliance(i) = real(scale * sqrt(w) * (1.0_real64 + w * (0.5_real64 * t1 + w * &
                        (0.375_real64 * t2 + w * 0.3125_real64 * t3))), real32)
      end do
    end subroutine comply

  end subroutine add_far

  ! What two near contacts do to each other; the source carries load.
  pure subroutine add_near(field, i, source, scale)
    type(contact_field), intent(inout) :: field
    integer, intent(in) :: i, source
    real(real64), intent(in) :: scale
    type(mutual_terms) :: terms
    real(real64) :: dx, dy, r, slope, load

    dx = field%x(i) - field%x(source)
    dy = field%y(i) - field%y(source)
    r = sqrt(dx * dx + dy * dy)
    call mutual_displacement(r, field%circle(i), field%circle(source), terms)
    slope = 0.0_real64
    if (r > 0.0_real64) slope = terms%slope / r
    load = field%load(source) * scale
    field%lift(i) = field%lift(i) + load * terms%on_first
    field%growth(i) = field%growth(i) + load * terms%first_growth
    field%tilt_x(i) = field%tilt_x(i) + load * slope * dx
    field%tilt_y(i) = field%tilt_y(i) + load * slope * dy
    if (i > field%loaded) return
    load = field%load(i) * scale
    field%lift(source) = field%lift(source) + load * terms%on_second
    field%growth(source) = field%growth(source) + load * terms%second_growth
    field%tilt_x(source) = field%tilt_x(source) - load * slope * dx
    field%tilt_y(source) = field%tilt_y(source) - load * slope * dy
    field%compliance(i, source) = real(scale * terms%compliance, real32)
    field%compliance(source, i) = field%compliance(i, source)
  end subroutine add_near

end module asperity_coupled_field
