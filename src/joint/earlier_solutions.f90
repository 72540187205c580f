!> Starts of coupled contacts from earlier solutions of the same position.
!>
!> Penetrations and shifts at a load P, or at a compression c, are interpolated between earlier
!> solutions, with Lagrange's polynomials in P**(2/3) or c: isolated contacts of equal height are
!> linear in both. The start moves the first iterate alone: the equations and their tolerance are
!> those of a solve without it.
module asperity_earlier_solutions
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_state, only: coupled_solution, far_below
  use asperity_kinds, only: real64
  use asperity_solution_start, only: contact_solution, solution_start
  implicit none
  private

  public :: closing_expected, keep_solution, mark_crowded, start_from_earlier

  ! Solutions of a position that are kept, between which is interpolated (measured on 50 loads: 4
  ! save no more iterations; test: loads one after the other in
  ! test/regression/test_solve_again.py).
  integer, parameter :: most_kept = 3
  ! Load**(2/3) or compression over that of an earlier solution, or its inverse, at most (measured:
  ! beyond it a solve takes longer than one without a start; test: other changes in
  ! test/regression/test_solve_again.py).
  real(real64), parameter :: farthest = 1.5_real64

contains

  !> Sets a start from the earlier solutions of the position; without one that serves the solution
  !> stays as it is.
  subroutine start_from_earlier(pairs, solution, target)
    type(contact_pairs), intent(in) :: pairs            !! pairs of the position
    type(coupled_solution), intent(inout) :: solution   !! closing; gets penetrations and shifts
    real(real64), intent(in), optional :: target        !! load, more than 0
    real(real64), allocatable :: at(:), weight(:)
    integer, allocatable :: node(:)
    real(real64) :: here
    integer :: i, j, k, l, n

    if (.not. associated(pairs%start)) return
    if (.not. allocated(pairs%start%of)) return
    if (present(target)) then
      here = hertz_power(target / pairs%modulus)
      if (target / pairs%modulus >= pairs%start%crowded_load) return
    else
      here = solution%closing
      if (here >= pairs%start%crowded_from) return
    end if
    allocate (at(size(pairs%start%of)), node(0))
    associate (of => pairs%start%of)
      do k = 1, size(of)
        at(k) = of(k)%closing
        if (present(target)) at(k) = hertz_power(of(k)%load(merge(2, 1, pairs%vertical)))
        if (.not. (is_of(pairs, of(k)) .and. at(k) < farthest * here .and. &
                   here < farthest * at(k))) at(k) = -1.0_real64
      end do
      do while (any(at > 0.0_real64))
        k = minloc(abs(at - here), 1, at > 0.0_real64)
        node = [node, k]
        at(k) = -at(k)
      end do
      if (size(node) == 0) return
      at = -at(node)
      n = farthest_order(here, at)
      weight = lagrange_weights(here, at(:n))
      solution%is_near = .true.
      if (present(target)) then
        solution%closing = sum([(weight(k) * of(node(k))%closing, k=1, n)])
        if (n == 1) solution%closing = solution%closing * (here / at(1))
      end if
      ! Open pairs begin open: of their penetration an upper bound is known, and the solver finds
      ! those that touch now.
      allocate (solution%penetration(size(pairs%list)), source=far_below)
      allocate (solution%shift(2, size(pairs%list)), source=0.0_real64)
      do j = n, 1, -1
        weight = lagrange_weights(here, at(:j))
        do i = 1, min(size(pairs%list), size(of(node(1))%gap))
          if (.not. of(node(1))%penetration(i) > 0.0_real64) cycle
          ! Where a pair was open its shift may be another one than that with which it closed.
          if (known_in(i, far_below / 2) == j) solution%penetration(i) = &
            sum([(weight(k) * of(node(k))%penetration(i), k=1, j)])
          if (known_in(i, 0.0_real64) == j) solution%shift(:, i) = &
            [(sum([(weight(k) * of(node(k))%shift(l, i), k=1, j)]), l=1, 2)]
        end do
      end do
    end associate

  contains

    ! In how many nodes, from the nearest on, a penetration is more than a number.
    pure integer function known_in(i, least) result(number)
      integer, intent(in) :: i
      real(real64), intent(in) :: least

      do number = 0, n - 1
        associate (one => pairs%start%of(node(number + 1)))
          if (i > size(one%gap)) return
          if (.not. one%penetration(i) > least) return
        end associate
      end do
    end function known_in

  end subroutine start_from_earlier

  ! Nodes, the nearest first, that lie far enough apart for a value that is not between them.
  pure integer function farthest_order(here, at) result(n)
    real(real64), intent(in) :: here, at(:)

    do n = size(at), 2, -1
      if (abs(here - at(1)) <= 2 * (maxval(at(:n)) - minval(at(:n)))) return
    end do
  end function farthest_order

  ! Lagrange's weights of nodes in a value.
  pure function lagrange_weights(here, at) result(weight)
    real(real64), intent(in) :: here, at(:)
    real(real64) :: weight(size(at))
    integer :: j, k

    weight = 1.0_real64
    do k = 1, size(at)
      do j = 1, size(at)
        if (j /= k) weight(k) = weight(k) * (here - at(j)) / (at(k) - at(j))
      end do
    end do
  end function lagrange_weights

  !> Adds a solution to the earlier ones of its position, as far as these are of the same pairs.
  subroutine keep_solution(pairs, closing, load, penetration, move, start)
    type(contact_pairs), intent(in) :: pairs           !! pairs of the position
    real(real64), intent(in) :: closing                !! compression of the contacts
    real(real64), intent(in) :: load(2)                !! normal and vertical
    real(real64), intent(in) :: penetration(:)         !! penetrations by pair, <= 0 where open
    real(real64), intent(in) :: move(:, :)             !! shifts (2, pair)
    type(solution_start), intent(out) :: start         !! earlier solutions and this one
    logical, allocatable :: stays(:)
    integer :: k, n, used

    allocate (stays(0))
    if (associated(pairs%start)) then
      if (allocated(pairs%start%of)) then
        stays = [(is_of(pairs, pairs%start%of(k)) .and. &
                  abs(pairs%start%of(k)%closing - closing) > sqrt(epsilon(closing)) * closing, &
                  k=1, size(pairs%start%of))]
        if (count(stays) >= most_kept) &
          stays(maxloc(abs(pairs%start%of%closing - closing), 1, stays)) = .false.
      end if
    end if
    if (associated(pairs%start)) then
      start%crowded_from = pairs%start%crowded_from
      start%crowded_load = pairs%start%crowded_load
    end if
    allocate (start%of(count(stays) + 1))
    used = 1
    do k = 1, size(stays)
      if (.not. stays(k)) cycle
      used = used + 1
      start%of(used) = pairs%start%of(k)
    end do
    associate (new => start%of(1))
      n = count(pairs%list%gap < closing)
      new%closing = closing
      new%load = load / pairs%modulus
      new%upper = pairs%list(:n)%upper
      new%lower = pairs%list(:n)%lower
      new%gap = pairs%list(:n)%gap
      new%penetration = merge(penetration(:n), far_below, abs(penetration(:n)) > tiny(closing))
      new%shift = move(:, :n)
    end associate
  end subroutine keep_solution

  !> Keeps the earlier solutions, and the compression and load of one that depends on its start.
  subroutine mark_crowded(pairs, closing, load, start)
    type(contact_pairs), intent(in) :: pairs     !! pairs of the position
    real(real64), intent(in) :: closing          !! compression of the contacts
    real(real64), intent(in) :: load             !! prescribed load, normal or vertical
    type(solution_start), intent(out) :: start   !! earlier solutions, marked

    if (associated(pairs%start)) start = pairs%start
    start%crowded_from = min(start%crowded_from, closing)
    start%crowded_load = min(start%crowded_load, load / pairs%modulus)
  end subroutine mark_crowded

  !> Compression expected under the load of the pairs from the earlier solution under the nearest
  !> load, by Hertz' law; 0 where there is none.
  pure real(real64) function closing_expected(pairs) result(closing)
    type(contact_pairs), intent(in) :: pairs   !! pairs of the position
    real(real64), allocatable :: ratio(:)
    integer :: k

    closing = 0.0_real64
    if (.not. (associated(pairs%start) .and. pairs%target > 0.0_real64)) return
    if (.not. allocated(pairs%start%of)) return
    if (pairs%target / pairs%modulus >= pairs%start%crowded_load) return
    associate (of => pairs%start%of)
      allocate (ratio(size(of)))
      do k = 1, size(of)
        ratio(k) = hertz_power(pairs%target / &
                               (pairs%modulus * of(k)%load(merge(2, 1, pairs%vertical))))
      end do
      k = minloc(abs(log(ratio)), 1)
      if (ratio(k) < farthest) closing = of(k)%closing * ratio(k)
    end associate
  end function closing_expected

  ! Power of a load with which the compression of a Hertzian contact is linear.
  elemental real(real64) function hertz_power(load)
    real(real64), intent(in) :: load

    hertz_power = load**(2.0_real64 / 3.0_real64)
  end function hertz_power

  ! Whether a solution is one of these pairs: those that both have are the same.
  pure logical function is_of(pairs, one)
    type(contact_pairs), intent(in) :: pairs
    type(contact_solution), intent(in) :: one
    integer :: n

    n = min(size(pairs%list), count(one%gap <= pairs%complete_to))
    is_of = n > 0
    if (is_of) is_of = all(pairs%list(:n)%upper == one%upper(:n) .and. &
                           pairs%list(:n)%lower == one%lower(:n) .and. &
                           .not. abs(pairs%list(:n)%gap - one%gap(:n)) > 0.0_real64)
  end function is_of

end module asperity_earlier_solutions
