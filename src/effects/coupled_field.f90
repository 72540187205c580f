!> The field that contacts spread over one another, and the matrix of their compliances.
!>
!> Near neighbours take the closed forms of mutual_displacement. Far ones take the first terms of
!> the same integral in powers of 1/r**2: pi E times a mean is the sum over k of
!> c(k) <tau**(2 k)> / r**(2 k + 1), c = 1, 1/2, 3/8, 5/16, ... as in 1/sqrt(1 - z). The inner
!> loops run over the contacts that feel one source: no sum need be split to make them vectors.
module asperity_coupled_field
  use asperity_coupled_equations, only: multiply
  use asperity_kinds, only: real32, real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms
  implicit none
  private

  public :: contact_field, make_room, spread_field

  !> Contacts side by side, those with load first, and what they feel of each other.
  type :: contact_field
    integer :: loaded = 0                     !! the first so many carry load
    integer :: count = 0                      !! all
    real(real64), allocatable :: x(:)         !! place in plan, shift included
    real(real64), allocatable :: y(:)         !! place in plan, shift included
    real(real64), allocatable :: radius(:)    !! combined
    real(real64), allocatable :: circle(:)    !! radius of the contact circle; 0 where open
    real(real64), allocatable :: load(:)      !! vertical; 0 where open
    real(real64), allocatable :: lift(:)      !! displacement by the others
    real(real64), allocatable :: growth(:)    !! its change with the log of the own circle's radius
    real(real64), allocatable :: tilt_x(:)    !! slope of the others' surface
    real(real64), allocatable :: tilt_y(:)    !! slope of the others' surface
    real(real64), allocatable :: bend_xx(:)   !! its second derivatives, near part
    real(real64), allocatable :: bend_xy(:)   !! the same
    real(real64), allocatable :: bend_yy(:)   !! the same
    real(real64), allocatable :: strongest(:) !! largest compliance with a near loaded contact
    real(real64), allocatable :: far(:, :)    !! far part of lift, tilt_x, tilt_y
    real(real64), allocatable :: far_place(:, :)  !! x and y it was found for
    real(real64), allocatable :: far_load(:)  !! loads it was found for
    integer :: near_pairs = 0                 !! neighbours that are not far
    integer, allocatable :: near(:, :)        !! both contacts of each; the second carries load
    logical :: keep_compliance = .false.      !! the matrix below still serves
    real(real32), allocatable :: compliance(:, :)  !! between the loaded, zero on the diagonal
  end type contact_field

  real(real64), parameter :: pi = acos(-1.0_real64)
  ! Sums of radii from which on the series serves: its first term left out is 3e-12 of the
  ! penetration there, which is less than the closed form loses by rounding.
  real(real64), parameter :: far_from = 9.0_real64

contains

  !> Makes room for so many contacts.
  pure subroutine make_room(field, room)
    type(contact_field), intent(out) :: field !! empty
    integer, intent(in) :: room               !! most contacts

    allocate (field%x(room), field%y(room), field%load(room))
    allocate (field%radius(room), field%circle(room))
    allocate (field%lift(room), field%growth(room), field%tilt_x(room), field%tilt_y(room))
    allocate (field%bend_xx(room), field%bend_xy(room), field%bend_yy(room))
    allocate (field%strongest(room), field%compliance(0, 0))
    allocate (field%far(room, 3), field%far_place(room, 2), field%far_load(room))
    allocate (field%near(2, 4 * room))
  end subroutine make_room

  !> Fills lift, growth, tilts, bends and compliance.
  pure subroutine spread_field(field, modulus, whole)
    type(contact_field), intent(inout) :: field !! the contacts
    real(real64), intent(in) :: modulus         !! combined
    !> false: the loads have changed little since the last whole one and are those of the same
    !> contacts; the far part follows by its derivative
    logical, intent(in) :: whole
    integer :: k, n

    n = field%count
    field%bend_xx(1:n) = 0.0_real64
    field%bend_xy(1:n) = 0.0_real64
    field%bend_yy(1:n) = 0.0_real64
    field%strongest(1:n) = 0.0_real64
    if (whole) call find_far(field, 1.0_real64 / modulus)
    field%lift(1:n) = field%far(1:n, 1)
    ! Far fields are level enough over a circle for Newton's method.
    field%growth(1:n) = 0.0_real64
    field%tilt_x(1:n) = field%far(1:n, 2)
    field%tilt_y(1:n) = field%far(1:n, 3)
    if (.not. whole) call follow_far(field)
    do k = 1, field%near_pairs
      call add_near(field, field%near(1, k), field%near(2, k), 1.0_real64 / modulus)
    end do
  end subroutine spread_field

  ! The far part, and who is near.
  pure subroutine find_far(field, scale)
    type(contact_field), intent(inout) :: field
    real(real64), intent(in) :: scale
    logical, allocatable :: is_near(:)
    integer, allocatable :: longer(:, :)
    integer :: i, j, n

    n = field%count
    allocate (is_near(n))
    field%near_pairs = 0
    field%lift(1:n) = 0.0_real64
    field%tilt_x(1:n) = 0.0_real64
    field%tilt_y(1:n) = 0.0_real64
    do j = 1, field%loaded
      call add_far(field, j, scale / pi, is_near)
      if (.not. field%keep_compliance) field%compliance(j, j) = 0.0_real32
      if (field%near_pairs + n > size(field%near, 2)) then
        allocate (longer(2, 2 * (field%near_pairs + n)))
        longer(:, :field%near_pairs) = field%near(:, :field%near_pairs)
        call move_alloc(longer, field%near)
      end if
      do i = 1, n
        ! Loaded neighbours come twice and are taken once; open ones only feel.
        if (.not. is_near(i) .or. (i >= j .and. i <= field%loaded)) cycle
        field%near_pairs = field%near_pairs + 1
        field%near(:, field%near_pairs) = [i, j]
      end do
    end do
    field%far(1:n, 1) = field%lift(1:n)
    field%far(1:n, 2) = field%tilt_x(1:n)
    field%far(1:n, 3) = field%tilt_y(1:n)
    field%far_load(1:n) = field%load(1:n)
    field%far_place(1:n, 1) = field%x(1:n)
    field%far_place(1:n, 2) = field%y(1:n)
  end subroutine find_far

  ! Moves the far lift on to the loads and places of now: the matrix without its near part.
  pure subroutine follow_far(field)
    type(contact_field), intent(inout) :: field
    real(real64) :: change(field%loaded), image(field%loaded)
    integer :: i, j, k, m

    m = field%loaded
    change = field%load(:m) - field%far_load(:m)
    call multiply(field%compliance, change, image)
    field%lift(:m) = field%lift(:m) + image + &
                     field%far(:m, 2) * (field%x(:m) - field%far_place(:m, 1)) + &
                     field%far(:m, 3) * (field%y(:m) - field%far_place(:m, 2))
    do k = 1, field%near_pairs
      i = field%near(1, k)
      j = field%near(2, k)
      if (i > m) cycle
      field%lift(i) = field%lift(i) - field%compliance(i, j) * change(j)
      field%lift(j) = field%lift(j) - field%compliance(i, j) * change(i)
    end do
  end subroutine follow_far

  ! What all that are far from one source feel of it.
  pure subroutine add_far(field, source, scale, near)
    type(contact_field), intent(inout) :: field
    integer, intent(in) :: source
    real(real64), intent(in) :: scale
    logical, contiguous, intent(out) :: near(:)
    real(real64) :: x, y, b, b2, load, hertz2, hertz4, hertz6, flat4
    integer :: m, n

    m = field%loaded
    n = field%count
    x = field%x(source)
    y = field%y(source)
    load = field%load(source) * scale
    b = field%circle(source)
    ! Means of tau**2, 4, 6 over the source.
    b2 = b * b
    hertz2 = b2 / 5
    hertz4 = 3 * b2**2 / 35
    hertz6 = b2**3 / 21
    flat4 = b2**2 / 5
    call feel(field%x(:n), field%y(:n), field%circle(:n), field%lift(:n), &
              field%tilt_x(:n), field%tilt_y(:n), near(:n))
    if (m > 0 .and. .not. field%keep_compliance) &
      call comply(field%x(:m), field%y(:m), field%circle(:m), &
                  field%compliance(:m, source))

  contains

    pure subroutine feel(px, py, a, lift, tilt_x, tilt_y, is_near)
      real(real64), contiguous, intent(in) :: px(:), py(:), a(:)
      real(real64), contiguous, intent(inout) :: lift(:), tilt_x(:), tilt_y(:)
      logical, contiguous, intent(out) :: is_near(:)
      real(real64) :: dx, dy, rr, w, root, a2, t1, t2, t3, slope, limit, part
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
        lift(i) = lift(i) + root * (1.0_real64 + w * (0.5_real64 * t1 + w * (0.375_real64 * t2 + &
                  w * 0.3125_real64 * t3)))
        ! Here both circles have Hertz' weight.
        t1 = a2 / 5 + hertz2
        t2 = a2 * (3 * a2 / 35 + 1.2_real64 * hertz2) + hertz4
        slope = root * w * (1.0_real64 + w * (1.5_real64 * t1 + w * 1.875_real64 * t2))
        tilt_x(i) = tilt_x(i) - slope * dx
        tilt_y(i) = tilt_y(i) - slope * dy
      end do
    end subroutine feel

    pure subroutine comply(px, py, a, compliance)
      real(real64), contiguous, intent(in) :: px(:), py(:), a(:)
      real(real32), contiguous, intent(out) :: compliance(:)
      real(real64) :: rr, w, a2, t1, t2
      integer :: i

      do i = 1, size(px)
        rr = (px(i) - x)**2 + (py(i) - y)**2
        w = 1.0_real64 / max(rr, (far_from * (a(i) + b))**2)
        a2 = a(i) * a(i)
        t1 = (a2 + b2) / 3
        t2 = a2 * (a2 / 5 + (2.0_real64 / 3) * b2) + flat4
        compliance(i) = real(scale * sqrt(w) * (1.0_real64 + w * (0.5_real64 * t1 + w * &
                        0.375_real64 * t2)), real32)
      end do
    end subroutine comply

  end subroutine add_far

  ! What two near contacts do to each other; the source carries load.
  pure subroutine add_near(field, i, source, scale)
    type(contact_field), intent(inout) :: field
    integer, intent(in) :: i, source
    real(real64), intent(in) :: scale
    type(mutual_terms) :: terms
    real(real64) :: dx, dy, r, slope, along, load

    dx = field%x(i) - field%x(source)
    dy = field%y(i) - field%y(source)
    r = sqrt(dx * dx + dy * dy)
    call mutual_displacement(r, field%circle(i), field%circle(source), terms)
    slope = 0.0_real64
    along = 0.0_real64
    if (r > 0.0_real64) then
      slope = terms%slope / r
      along = (terms%bend - slope) / r**2
    end if
    load = field%load(source) * scale
    field%lift(i) = field%lift(i) + load * terms%on_first
    field%growth(i) = field%growth(i) + load * terms%first_growth
    field%tilt_x(i) = field%tilt_x(i) + load * slope * dx
    field%tilt_y(i) = field%tilt_y(i) + load * slope * dy
    call add_bend(field, i, source, scale, dx, dy, slope, along)
    if (i > field%loaded) return
    load = field%load(i) * scale
    field%lift(source) = field%lift(source) + load * terms%on_second
    field%growth(source) = field%growth(source) + load * terms%second_growth
    field%tilt_x(source) = field%tilt_x(source) - load * slope * dx
    field%tilt_y(source) = field%tilt_y(source) - load * slope * dy
    call add_bend(field, source, i, scale, dx, dy, slope, along)
    field%strongest(i) = max(field%strongest(i), scale * terms%compliance)
    field%strongest(source) = max(field%strongest(source), scale * terms%compliance)
    if (field%keep_compliance) return
    field%compliance(i, source) = real(scale * terms%compliance, real32)
    field%compliance(source, i) = field%compliance(i, source)
  end subroutine add_near

  ! Adds to the second derivatives of the surface at contact k. Where k moves, the other moves
  ! the other way, by their loads and radii; that bends as much more.
  pure subroutine add_bend(field, k, other, scale, dx, dy, slope, along)
    type(contact_field), intent(inout) :: field
    integer, intent(in) :: k, other
    real(real64), intent(in) :: scale, dx, dy, slope, along
    real(real64) :: load

    load = scale * (field%load(other) + field%load(k) * (field%radius(other) / field%radius(k)))
    field%bend_xx(k) = field%bend_xx(k) + load * (slope + along * dx * dx)
    field%bend_xy(k) = field%bend_xy(k) + load * along * dx * dy
    field%bend_yy(k) = field%bend_yy(k) + load * (slope + along * dy * dy)
  end subroutine add_bend

end module asperity_coupled_field
