!> A first guess for many coupled contacts: loads felt as by points, no shifts.
!>
!> The matrix of the compliances is made once, in single precision; Newton's method then finds who
!> touches at the cost of some products with it.
module asperity_coupled_coarse
  use asperity_constants, only: pi
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_equations, only: add_image, begin, comply, end_of_space, krylov_space, &
                                        make_room, multiply, next_direction
  use asperity_kinds, only: real32, real64
  implicit none
  private

  public :: refine_start

  ! Fewer contacts need no better guess; more would make the matrix too large.
  integer, parameter :: fewest = 64, most = 6000
  integer, parameter :: most_steps = 12, most_directions = 30
  ! What the first guess may be wrong by, as a share of the largest penetration.
  real(real64), parameter :: margin = 0.3_real64
  real(real64), parameter :: accuracy = 0.1_real64, good_enough = 3.0e-2_real64

contains

  !> Makes penetrations, and the closing where a load is given, better.
  pure subroutine refine_start(pairs, law, target, most_closing, closing, p)
    type(contact_pairs), intent(in) :: pairs       !! the contacts
    class(contact_law), intent(in) :: law          !! of each
    real(real64), intent(in) :: target             !! sum of the normal loads; below 0: not asked
    real(real64), intent(in) :: most_closing       !! not to be passed
    real(real64), intent(inout) :: closing         !! a guess where a load is given
    real(real64), intent(inout) :: p(:)            !! penetrations, a guess
    type(krylov_space) :: space
    type(contact_response) :: response
    real(real32), allocatable :: compliance(:, :)
    real(real64), allocatable, dimension(:) :: load, normal, stiffness, lift, own, x, y, circle, &
                                               image, direction, gap, change
    integer, allocatable :: chosen(:)
    real(real64) :: deepest, softness, left, residual, moved
    integer :: i, k, n, step

    deepest = maxval(p)
    n = count(p > -margin * deepest)
    if (n <= fewest .or. n > most .or. .not. deepest > 0.0_real64) return
    allocate (chosen(n), load(n), normal(n), stiffness(n), lift(n), own(n), x(n), y(n), circle(n), &
              gap(n), compliance(n, n), image(n + 1), direction(n + 1), change(n + 1))
    chosen = pack([(i, i=1, size(p))], p > -margin * deepest)
    x = pairs%list(chosen)%x
    y = pairs%list(chosen)%y
    gap = pairs%list(chosen)%gap
    own = p(chosen)
    circle = sqrt(0.5_real64 * deepest * pairs%list(chosen)%radius)
    do k = 1, n
      call comply(x(k), y(k), circle(k)**2, x, y, circle, &
                  real(1.0_real64 / (pi * pairs%modulus), real32), compliance(:, k))
      compliance(k, k) = 0.0_real32
    end do
    call make_room(space, n + 1, most_directions)
    do step = 1, most_steps
      do k = 1, n
        response = contact_response()
        call law%respond(pairs%list(chosen(k)), chosen(k), &
                         min(own(k), 0.999999_real64 * pairs%list(chosen(k))%zc), response)
        load(k) = response%vertical_load
        normal(k) = response%load
        stiffness(k) = response%stiffness
      end do
      softness = sum(stiffness)
      if (.not. softness > 0.0_real64) return
      call multiply(compliance, load, lift)
      image(:n) = closing - gap - lift - own
      residual = 0.0_real64
      do k = 1, n
        if (own(k) > 0.0_real64 .or. image(k) + own(k) > 0.0_real64) &
          residual = max(residual, abs(image(k)))
      end do
      image(n + 1) = 0.0_real64
      if (target > 0.0_real64) image(n + 1) = (target - sum(normal)) / softness
      residual = max(residual, abs(image(n + 1)))
      if (residual <= good_enough * maxval(own)) exit
      ! Open contacts follow the others: their load does not change.
      call begin(space, image, accuracy)
      do while (.not. space%done)
        call next_direction(space, direction)
        load = stiffness * direction(:n)
        call multiply(compliance, load, lift)
        image(:n) = direction(:n) + lift - direction(n + 1)
        image(n + 1) = direction(n + 1)
        if (target > 0.0_real64) image(n + 1) = sum(load) / softness
        call add_image(space, image)
      end do
      call end_of_space(space, change, left)
      moved = min(change(n + 1), most_closing - closing)
      if (target > 0.0_real64) closing = closing + moved
      own = own + change(:n)
    end do
    p(chosen) = own
  end subroutine refine_start

end module asperity_coupled_coarse
