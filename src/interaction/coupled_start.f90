!> First guess for coupled contacts, and the bound that tells whether coupling matters.
module asperity_coupled_start
  use asperity_constants, only: pi
  use asperity_contact_law, only: contact_law, contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_kinds, only: real64
  implicit none
  private

  public :: start_at_closing, start_at_load

  integer, parameter :: most_sampled = 48

contains

  !> Independent contacts at a closing lowered by the mean displacement that their loads cause.
  pure subroutine start_at_closing(pairs, law, closing, p)
    type(contact_pairs), intent(in) :: pairs   !! ascending gap
    class(contact_law), intent(in) :: law      !! of each contact
    real(real64), intent(in) :: closing        !! past first touch of all
    real(real64), intent(out) :: p(:)          !! penetrations
    real(real64) :: influence, lowered, load, normal, stiffness, off
    integer :: iteration, n

    n = touching(pairs, closing)
    lowered = closing
    if (n > 1) then
      influence = mean_influence(pairs, n)
      do iteration = 1, 30
        call totals(pairs, law, lowered, load, normal, stiffness)
        off = lowered + influence * load - closing
        ! The load is convex in the closing: Newton's method comes down to the root from above.
        if (.not. off > 0.01_real64 * lowered) exit
        lowered = lowered - off / (1.0_real64 + influence * stiffness)
      end do
    end if
    p = lowered - pairs%list%gap
  end subroutine start_at_closing

  !> The same where the load is given.
  pure subroutine start_at_load(pairs, law, target, most_closing, closing, p)
    type(contact_pairs), intent(in) :: pairs     !! ascending gap; one or more
    class(contact_law), intent(in) :: law        !! of each contact
    real(real64), intent(in) :: target           !! sum of the normal loads, more than 0
    real(real64), intent(in) :: most_closing     !! not to be passed
    real(real64), intent(out) :: closing         !! the guess
    real(real64), intent(out) :: p(:)            !! penetrations
    real(real64) :: lowered, load, normal, stiffness, most
    integer :: iteration

    most = min(most_closing, 0.5_real64 * pairs%list(1)%zc)
    lowered = min(1.0e-6_real64 * pairs%list(1)%zc, most)
    do
      call totals(pairs, law, lowered, load, normal, stiffness)
      if (normal >= target .or. .not. lowered < most) exit
      lowered = min(4 * lowered, most)
    end do
    do iteration = 1, 30
      if (.not. normal > 1.01_real64 * target) exit
      lowered = lowered - (normal - target) / stiffness
      call totals(pairs, law, lowered, load, normal, stiffness)
    end do
    closing = min(lowered + mean_influence(pairs, touching(pairs, lowered)) * load, most_closing)
    p = lowered - pairs%list%gap
  end subroutine start_at_load

  ! How many lie above a closing.
  pure function touching(pairs, closing) result(number)
    type(contact_pairs), intent(in) :: pairs
    real(real64), intent(in) :: closing
    integer :: number

    number = count(pairs%list%gap < closing)
  end function touching

  ! Loads and stiffness of independent contacts.
  pure subroutine totals(pairs, law, closing, load, normal, stiffness)
    type(contact_pairs), intent(in) :: pairs
    class(contact_law), intent(in) :: law
    real(real64), intent(in) :: closing
    real(real64), intent(out) :: load, normal, stiffness
    type(contact_response) :: response
    integer :: i

    load = 0.0_real64
    normal = 0.0_real64
    stiffness = 0.0_real64
    do i = 1, size(pairs%list)
      if (pairs%list(i)%gap >= closing) exit
      call law%respond(pairs%list(i), i, min(closing - pairs%list(i)%gap, &
                       0.999999_real64 * pairs%list(i)%zc), response)
      load = load + response%vertical_load
      normal = normal + response%load
      stiffness = stiffness + response%stiffness
    end do
  end subroutine totals

  ! Mean displacement by a unit load shared by the first n contacts, from a sample of them.
  pure function mean_influence(pairs, n) result(influence)
    type(contact_pairs), intent(in) :: pairs
    integer, intent(in) :: n
    real(real64) :: influence, x(most_sampled), y(most_sampled), least
    integer :: i, j, k, sampled

    influence = 0.0_real64
    if (n < 2) return
    sampled = min(n, most_sampled)
    do k = 1, sampled
      i = 1 + int((k - 1) * (real(n - 1, real64) / (sampled - 1)))
      x(k) = pairs%list(i)%x
      y(k) = pairs%list(i)%y
    end do
    ! Nearly coincident contacts must not stand for all.
    least = 0.05_real64 * max(maxval(x(:sampled)) - minval(x(:sampled)), &
                              maxval(y(:sampled)) - minval(y(:sampled)))
    if (.not. least > 0.0_real64) return
    do j = 2, sampled
      do i = 1, j - 1
        influence = influence + 1.0_real64 / max(least, hypot(x(i) - x(j), y(i) - y(j)))
      end do
    end do
    influence = influence / (0.5_real64 * sampled * (sampled - 1))
    influence = influence * (n - 1) / (n * pi * pairs%modulus)
  end function mean_influence

end module asperity_coupled_start
