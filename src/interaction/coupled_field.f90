!> The field that contacts spread over one another, and the matrix of their compliances.
!>
!> Near neighbours take the closed forms of mutual_displacement, far ones a short series, those
!> between a longer one.
module asperity_coupled_field
  use asperity_constants, only: pi
  use asperity_coupled_equations, only: comply
  use asperity_coupled_far, only: far_contact, feel_source, share_field
  use asperity_coupled_middle, only: middle_pairs
  use asperity_coupled_near, only: list_near
  use asperity_coupled_rough, only: feel_roughly, rough_contacts, rough_lift, rough_tilt, &
                                    set_out_roughly
  use asperity_kinds, only: real32, real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms
  implicit none
  private

  public :: contact_field, near_pair, make_room, spread_field

  !> Two near contacts, the second with load: derivatives by the place of the first, for a unit
  !> load.
  type :: near_pair
    integer :: first = 0                         !! contact
    integer :: second = 0                        !! contact with load
    real(real64) :: first_x = 0.0_real64         !! of the lift of the first
    real(real64) :: first_y = 0.0_real64         !! of the lift of the first
    real(real64) :: second_x = 0.0_real64        !! of the lift of the second
    real(real64) :: second_y = 0.0_real64        !! of the lift of the second
    real(real64) :: bend_xx = 0.0_real64         !! second derivatives of the mutual energy
    real(real64) :: bend_xy = 0.0_real64         !! the same
    real(real64) :: bend_yy = 0.0_real64         !! the same
  end type near_pair

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
    real(real64), allocatable :: lean_x(:)    !! slope of the lift less that of the surface
    real(real64), allocatable :: lean_y(:)    !! slope of the lift less that of the surface
    real(real64), allocatable :: bend_xx(:)   !! second derivatives of the surface, near part
    real(real64), allocatable :: bend_xy(:)   !! the same
    real(real64), allocatable :: bend_yy(:)   !! the same
    real(real64), allocatable :: strongest(:) !! largest compliance with a near loaded contact
    integer :: near_pairs = 0                 !! neighbours that are near
    type(near_pair), allocatable :: near(:)   !! they
    type(middle_pairs) :: middle              !! neighbours neither near nor far
    logical :: only_open = .false.            !! those with load are not asked what they feel
    logical :: roughly = .false.              !! single precision will do
    logical :: keep_compliance = .false.      !! the matrix below still serves
    real(real32), allocatable :: compliance(:, :)  !! between the loaded, zero on the diagonal
  end type contact_field

  ! Sums of radii up to which the closed forms serve.
  real(real64), parameter :: near_to = 4.0_real64

contains

  !> Makes room for so many contacts.
  pure subroutine make_room(field, room)
    type(contact_field), intent(out) :: field !! empty
    integer, intent(in) :: room               !! most contacts

    allocate (field%x(room), field%y(room), field%load(room))
    allocate (field%radius(room), field%circle(room))
    allocate (field%lift(room), field%growth(room), field%tilt_x(room), field%tilt_y(room))
    allocate (field%lean_x(room), field%lean_y(room))
    allocate (field%bend_xx(room), field%bend_xy(room), field%bend_yy(room))
    allocate (field%strongest(room), field%compliance(0, 0))
    allocate (field%near(4 * room))
  end subroutine make_room

  !> Fills lift, growth, tilts, leans, bends, near pairs and compliance.
  pure subroutine spread_field(field, modulus)
    type(contact_field), intent(inout) :: field !! the contacts
    real(real64), intent(in) :: modulus         !! combined
    integer :: k, n

    n = field%count
    field%lift(1:n) = 0.0_real64
    ! Far fields are level enough over a circle for Newton's method.
    field%growth(1:n) = 0.0_real64
    field%tilt_x(1:n) = 0.0_real64
    field%tilt_y(1:n) = 0.0_real64
    field%lean_x(1:n) = 0.0_real64
    field%lean_y(1:n) = 0.0_real64
    field%bend_xx(1:n) = 0.0_real64
    field%bend_xy(1:n) = 0.0_real64
    field%bend_yy(1:n) = 0.0_real64
    field%strongest(1:n) = 0.0_real64
    if (field%roughly) then
      call add_roughly(field, 1.0_real64 / (pi * modulus))
    else
      if (.not. field%keep_compliance) call fill_compliance(field, 1.0_real64 / (pi * modulus))
      call add_far(field, 1.0_real64 / (pi * modulus))
      call field%middle%add(field%x, field%y, field%circle, field%load, &
                            1.0_real64 / (pi * modulus), field%lift, field%tilt_x, field%tilt_y)
    end if
    do k = 1, field%near_pairs
      call add_near(field, k, 1.0_real64 / modulus)
    end do
  end subroutine spread_field

  ! The far part, and who is near.
  pure subroutine add_far(field, scale)
    type(contact_field), intent(inout) :: field
    real(real64), intent(in) :: scale
    real(real64) :: is_far(field%count)
    real(real64) :: load(field%loaded)
    integer :: near(field%count), number
    type(far_contact) :: one
    integer :: j, m, n

    m = field%loaded
    n = field%count
    load = scale * field%load(:m)
    field%near_pairs = 0
    field%middle%count = 0
    do j = 1, m
      one = far_contact(field%x(j), field%y(j), field%circle(j), load(j))
      if (.not. field%only_open) then
        call share_field(one, field%x(:j - 1), field%y(:j - 1), field%circle(:j - 1), &
                         load(:j - 1), field%lift(:j - 1), field%tilt_x(:j - 1), &
                         field%tilt_y(:j - 1), is_far(:j - 1))
        field%lift(j) = field%lift(j) + one%lift
        field%tilt_x(j) = field%tilt_x(j) + one%tilt_x
        field%tilt_y(j) = field%tilt_y(j) + one%tilt_y
        call list_near(is_far(:j - 1), near, number)
        call keep_near(field, j, near(:number), 0)
      end if
      if (m == n) cycle
      call feel_source(one, field%x(m + 1:n), field%y(m + 1:n), field%lift(m + 1:n), &
                       field%tilt_x(m + 1:n), field%tilt_y(m + 1:n), is_far(m + 1:n))
      call list_near(is_far(m + 1:n), near, number)
      call keep_near(field, j, near(:number), m)
    end do
  end subroutine add_far

  ! The far part and the compliances in single precision, and who is near.
  pure subroutine add_roughly(field, scale)
    type(contact_field), intent(inout) :: field
    real(real64), intent(in) :: scale
    type(rough_contacts) :: rough
    integer :: near(field%count), number
    real(real32) :: stiff
    integer :: first, j, m, n

    m = field%loaded
    n = field%count
    field%near_pairs = 0
    field%middle%count = 0
    call set_out_roughly(field%x(:n), field%y(:n), field%circle(:n), field%load(:m), rough)
    first = 1
    if (field%only_open) first = m + 1
    stiff = real(scale / rough%length, real32)
    do j = 1, m
      call feel_roughly(rough%x(j), rough%y(j), rough%circle(j), rough%load(j), &
                        real(near_to, real32), rough%x(first:), rough%y(first:), &
                        rough%circle(first:), rough%lift(first:), rough%tilt_x(first:), &
                        rough%tilt_y(first:), rough%is_far(first:), rough%compliance(first:))
      if (.not. field%only_open) then
        field%compliance(:, j) = stiff * rough%compliance(:m)
        field%compliance(j, j) = 0.0_real32
        call list_near(rough%is_far(:j - 1), near, number)
        call keep_near(field, j, near(:number), 0)
      end if
      call list_near(rough%is_far(m + 1:n), near, number)
      call keep_near(field, j, near(:number), m)
    end do
    field%lift(first:n) = scale * rough_lift(rough) * rough%lift(first:)
    field%tilt_x(first:n) = scale * rough_tilt(rough) * rough%tilt_x(first:)
    field%tilt_y(first:n) = scale * rough_tilt(rough) * rough%tilt_y(first:)
  end subroutine add_roughly

  ! Keeps the neighbours of one contact: the near, and those between near and far, which there are
  ! none of where it goes roughly.
  pure subroutine keep_near(field, j, near, before)
    type(contact_field), intent(inout) :: field
    integer, intent(in) :: j, near(:), before  ! near counts from the contact after `before`
    type(near_pair), allocatable :: longer(:)
    integer :: i, k, l

    call field%middle%make_room(size(near))
    k = field%near_pairs
    if (k + size(near) > size(field%near)) then
      allocate (longer(2 * (k + size(near))))
      longer(:k) = field%near(:k)
      call move_alloc(longer, field%near)
    end if
    do l = 1, size(near)
      i = near(l) + before
      if ((field%x(i) - field%x(j))**2 + (field%y(i) - field%y(j))**2 > &
          (near_to * (field%circle(i) + field%circle(j)))**2 .and. .not. field%roughly) then
        field%middle%count = field%middle%count + 1
        field%middle%first(field%middle%count) = i
        field%middle%second(field%middle%count) = j
      else
        k = k + 1
        field%near(k)%first = i
        field%near(k)%second = j
      end if
    end do
    field%near_pairs = k
  end subroutine keep_near

  ! Compliances of all pairs as those of points; add_near mends the near ones.
  pure subroutine fill_compliance(field, scale)
    type(contact_field), intent(inout) :: field
    real(real64), intent(in) :: scale
    integer :: j, m

    m = field%loaded
    do j = 1, m
      call comply(field%x(j), field%y(j), field%circle(j)**2, field%x(:m), field%y(:m), &
                  field%circle(:m), real(scale, real32), field%compliance(:m, j))
      field%compliance(j, j) = 0.0_real32
    end do
  end subroutine fill_compliance

  ! What two near contacts do to each other; the second carries load.
  pure subroutine add_near(field, number, scale)
    type(contact_field), intent(inout) :: field
    integer, intent(in) :: number
    real(real64), intent(in) :: scale
    type(near_pair) :: pair
    type(mutual_terms) :: terms
    real(real64) :: dx, dy, r, slope, along
    integer :: i, j

    i = field%near(number)%first
    j = field%near(number)%second
    pair%first = i
    pair%second = j
    dx = field%x(i) - field%x(j)
    dy = field%y(i) - field%y(j)
    r = sqrt(dx * dx + dy * dy)
    call mutual_displacement(r, field%circle(i), field%circle(j), terms)
    slope = scale * terms%bend
    along = 0.0_real64
    if (r > 0.0_real64) then
      pair%first_x = scale * (terms%first_slope / r) * dx
      pair%first_y = scale * (terms%first_slope / r) * dy
      pair%second_x = scale * (terms%second_slope / r) * dx
      pair%second_y = scale * (terms%second_slope / r) * dy
      slope = scale * (terms%slope / r)
      along = (scale * terms%bend - slope) / r**2
    end if
    pair%bend_xx = slope + along * dx * dx
    pair%bend_xy = along * dx * dy
    pair%bend_yy = slope + along * dy * dy
    if (.not. r > 0.0_real64) slope = 0.0_real64
    field%near(number) = pair
    call feel(field, i, pair, field%load(j), scale * terms%on_first, &
              scale * terms%first_growth, slope * dx, slope * dy, pair%first_x, pair%first_y)
    if (i > field%loaded) return
    call feel(field, j, pair, field%load(i), scale * terms%on_second, &
              scale * terms%second_growth, -slope * dx, -slope * dy, -pair%second_x, -pair%second_y)
    field%strongest(i) = max(field%strongest(i), scale * terms%compliance)
    field%strongest(j) = max(field%strongest(j), scale * terms%compliance)
    field%compliance(i, j) = real(scale * terms%compliance, real32)
    field%compliance(j, i) = field%compliance(i, j)
  end subroutine add_near

  ! What contact k feels of one of its neighbours.
  pure subroutine feel(field, k, pair, load, lift, growth, tilt_x, tilt_y, slope_x, slope_y)
    type(contact_field), intent(inout) :: field
    integer, intent(in) :: k
    type(near_pair), intent(in) :: pair
    real(real64), intent(in) :: load, lift, growth, tilt_x, tilt_y, slope_x, slope_y

    field%lift(k) = field%lift(k) + load * lift
    field%growth(k) = field%growth(k) + load * growth
    field%tilt_x(k) = field%tilt_x(k) + load * tilt_x
    field%tilt_y(k) = field%tilt_y(k) + load * tilt_y
    field%lean_x(k) = field%lean_x(k) + load * (slope_x - tilt_x)
    field%lean_y(k) = field%lean_y(k) + load * (slope_y - tilt_y)
    field%bend_xx(k) = field%bend_xx(k) + load * pair%bend_xx
    field%bend_xy(k) = field%bend_xy(k) + load * pair%bend_xy
    field%bend_yy(k) = field%bend_yy(k) + load * pair%bend_yy
  end subroutine feel

end module asperity_coupled_field
