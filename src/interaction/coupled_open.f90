!> Where open contacts would touch first on the surface that the loaded ones leave.
module asperity_coupled_open
  use asperity_circle_field, only: circle_set, many, near_factor
  use asperity_circle_products, only: shift_down
  use asperity_constants, only: pi
  use asperity_kinds, only: real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms
  use asperity_source_tree, only: plant_tree, source_tree, sum_sources
  implicit none
  private

  public :: open_places, look_around, stands_out

  !> Open contacts: places, and what the surface does there.
  type :: open_places
    real(real64), allocatable :: x(:), y(:)            !! without shift
    real(real64), allocatable :: radius(:)             !! R
    real(real64), allocatable :: gap(:)                !! without load
    real(real64), allocatable :: move_x(:), move_y(:)  !! the shifts: a guess, then the best
    real(real64), allocatable :: lift(:)               !! least of s**2/(2 R) + u(x + s)
    real(real64), allocatable :: start(:)              !! the same at the guess, if looked at
  end type open_places

  ! The field near one of them: value, slope, second derivatives.
  type :: local_field
    real(real64) :: lift = 0.0_real64
    real(real64) :: slope(2) = 0.0_real64
    real(real64) :: bend_xx = 0.0_real64, bend_xy = 0.0_real64, bend_yy = 0.0_real64
  end type local_field

  integer, parameter :: most_steps = 40, most_cuts = 40

  ! A cap that stands out of a loaded circle's own surface by no more than this share of the
  ! penetration is a part of that contact: as one of its own it would bear less than its 3/2th power
  ! of the load, nearly all of it taken from the circle.
  real(real64), parameter :: out_of_host = 0.02_real64

contains

  !> How far the surface of a pair stands out of another's, its host, within twice the host's
  !> circle: a share of the host's penetration. 2 where it is much blunter, or does not touch first
  !> inside the circle. Farther off the surfaces part by more than it can stand out. Paraboloids.
  pure real(real64) function stands_out(gap, x, y, curvature, host_gap, host_x, host_y, &
                                        host_curvature, circle, move_x, move_y) result(share)
    real(real64), intent(in) :: gap, x, y, curvature  !! of the pair: without load; place; 1/R
    real(real64), intent(in) :: host_gap, host_x, host_y, host_curvature  !! of the host
    real(real64), intent(in) :: circle                !! radius of the host's circle
    real(real64), intent(in) :: move_x, move_y        !! its centre, from `host_x`, `host_y`
    real(real64) :: dx, dy, rho, sharper, slope

    share = 2.0_real64
    dx = host_x + move_x - x
    dy = host_y + move_y - y
    sharper = curvature - host_curvature
    if (.not. (2 * sharper > -host_curvature .and. hypot(dx, dy) < circle)) return
    ! Along its steepest line it stands out by a parabola: as far as its top, or to the end.
    slope = hypot(curvature * dx - host_curvature * move_x, &
                  curvature * dy - host_curvature * move_y)
    rho = 2 * circle
    if (sharper * rho > slope) rho = slope / sharper
    share = (host_gap - gap + 0.5_real64 * (host_curvature * (move_x**2 + move_y**2) - &
             curvature * (dx**2 + dy**2)) + rho * (slope - 0.5_real64 * sharper * rho)) / &
            (circle**2 * host_curvature)
  end function stands_out

  !> For each open contact the shift at which it is lowest, s**2/(2 R) + u(x + s): near neighbours
  !> act exactly, the others by value and slope. Newton's method that only goes down. What is hidden
  !> in a circle touches nowhere else: its `lift` is out of reach.
  subroutine look_around(set, closing, gap, places, accuracy, failure)
    type(circle_set), intent(in) :: set          !! loaded contacts
    real(real64), intent(in) :: closing          !! past first touch of all
    real(real64), intent(in) :: gap(:)           !! theirs, without load
    type(open_places), intent(inout) :: places   !! open contacts
    real(real64), intent(in) :: accuracy         !! of `lift`
    character(len=:), allocatable, intent(out) :: failure  !! no memory
    type(source_tree) :: tree
    real(real64), allocatable :: potential(:), slope_x(:), slope_y(:), none(:), lap(:)
    real(real64) :: least
    integer :: i, n

    n = size(places%x)
    allocate (potential(n), slope_x(n), slope_y(n), lap(n))
    allocate (none(n), source=0.0_real64)
    if (allocated(places%start)) deallocate (places%start)
    allocate (places%start(n), source=0.5_real64 * huge(1.0_real64))
    ! Near where they are: far off a tilted surface moves them past many a circle.
    call plant_tree(tree, set%x, set%y, set%circle, near_factor, places%x + places%move_x, &
                    places%y + places%move_y, none)
    if (allocated(tree%failure)) then
      failure = tree%failure
      return
    end if
    call sum_sources(tree, set%load, 0.1_real64 * set%circle**2, potential, lap, slope_x, slope_y, &
                     set%move_x, set%move_y)
    !$omp parallel do schedule(dynamic, 64) private(least) if(n > many)
    do i = 1, n
      associate (near => tree%near(tree%first(i):tree%first(i + 1) - 1), r => places%radius(i), &
                 slope => [slope_x(i), slope_y(i)] / pi)
        ! Near circles only push down: without them it would not touch, by a shift's worth.
        least = potential(i) / pi - 0.5_real64 * r * dot_product(slope, slope) - &
                dot_product(slope, [places%move_x(i), places%move_y(i)])
        if (places%gap(i) + least - 0.5_real64 * r * dot_product(slope, slope) > closing) then
          places%lift(i) = least
        else if (is_hidden(set, gap, near, places, i)) then
          places%lift(i) = 0.5_real64 * huge(1.0_real64)
        else
          call settle(set, near, potential(i) / pi, slope, accuracy, places, i)
        end if
      end associate
    end do
    !$omp end parallel do
  end subroutine look_around

  ! Whether it is a part of one of these loaded contacts.
  pure logical function is_hidden(set, gap, near, places, i)
    type(circle_set), intent(in) :: set
    real(real64), intent(in) :: gap(:)
    integer, intent(in) :: near(:), i
    type(open_places), intent(in) :: places
    integer :: j, k

    is_hidden = .true.
    do k = 1, size(near)
      j = near(k)
      if (set%still(j)) cycle
      if (stands_out(places%gap(i), places%x(i), places%y(i), 1.0_real64 / places%radius(i), &
                     gap(j), set%x(j), set%y(j), set%curvature(j), set%circle(j), set%move_x(j), &
                     set%move_y(j)) <= out_of_host) return
    end do
    is_hidden = .false.
  end function is_hidden

  ! One contact.
  subroutine settle(set, near, far_lift, far_slope, accuracy, places, i)
    type(circle_set), intent(in) :: set
    integer, intent(in) :: near(:), i
    real(real64), intent(in) :: far_lift, far_slope(2), accuracy
    type(open_places), intent(inout) :: places
    type(local_field) :: here, there
    real(real64) :: first(2), s(2), trial(2), move(2), slope(2), height, least, part
    integer :: step, cut

    first = [places%move_x(i), places%move_y(i)]
    s = first
    call feel(set, near, places%x(i) + s(1), places%y(i) + s(2), far_lift, far_slope, s - first, &
              here)
    associate (r => places%radius(i))
      least = here%lift + dot_product(s, s) / (2 * r)
      places%start(i) = least
      do step = 1, most_steps
        slope = s / r + here%slope
        if (.not. r * dot_product(slope, slope) > accuracy) exit
        move = shift_down([1, 0, 1] / r + [here%bend_xx, here%bend_xy, here%bend_yy], &
                          1.0_real64 / r, slope)
        part = 1.0_real64
        do cut = 1, most_cuts
          trial = s + part * move
          call feel(set, near, places%x(i) + trial(1), places%y(i) + trial(2), far_lift, &
                    far_slope, trial - first, there)
          height = there%lift + dot_product(trial, trial) / (2 * r)
          ! Neighbours only push down: farther off their value and slope say nothing.
          if (there%lift >= 0.0_real64 .and. &
              height <= least + 1.0e-4_real64 * part * dot_product(slope, move)) exit
          part = part / 2
        end do
        if (cut > most_cuts) exit
        s = trial
        here = there
        least = height
      end do
    end associate
    places%move_x(i) = s(1)
    places%move_y(i) = s(2)
    places%lift(i) = least
  end subroutine settle

  ! The field at a place.
  pure subroutine feel(set, near, x, y, far_lift, far_slope, s, here)
    type(circle_set), intent(in) :: set
    integer, intent(in) :: near(:)
    real(real64), intent(in) :: x, y, far_lift, far_slope(2), s(2)
    type(local_field), intent(out) :: here
    type(mutual_terms) :: terms
    real(real64) :: dx, dy, r, turn, along
    integer :: j, k

    here%lift = far_lift + dot_product(far_slope, s)
    here%slope = far_slope
    do k = 1, size(near)
      j = near(k)
      dx = x - (set%x(j) + set%move_x(j))
      dy = y - (set%y(j) + set%move_y(j))
      r = hypot(dx, dy)
      call mutual_displacement(r, 0.0_real64, set%circle(j), terms)
      here%lift = here%lift + set%load(j) * terms%on_first
      turn = set%load(j) * terms%bend
      along = 0.0_real64
      if (r > 0.0_real64) then
        turn = set%load(j) * terms%slope / r
        along = (set%load(j) * terms%bend - turn) / r**2
      end if
      here%slope = here%slope + turn * [dx, dy]
      here%bend_xx = here%bend_xx + turn + along * dx * dx
      here%bend_xy = here%bend_xy + along * dx * dy
      here%bend_yy = here%bend_yy + turn + along * dy * dy
    end do
  end subroutine feel

end module asperity_coupled_open
