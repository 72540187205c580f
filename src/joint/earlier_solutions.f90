!> Starts of coupled contacts from earlier solutions of the same position.
!>
!> Penetrations and shifts at a load P, or at a compression c, are interpolated between earlier
!> solutions with Lagrange's polynomials in P**(2/3) or c, as the penetrations of isolated contacts
!> of equal height are linear in both. A start changes only the first iterate: the equations and
!> their tolerance are those of a solve without one.
module asperity_earlier_solutions
  use asperity_contact_pairs, only: contact_pairs
  use asperity_coupled_state, only: coupled_solution, open_penetration
  use asperity_kinds, only: real64
  use asperity_solution_start, only: contact_solution, solution_start
  implicit none
  private

  public :: expected_compression, keep_solution, mark_crowded, start_from_earlier

  ! Number of solutions of a position that are kept for the interpolation (measured on 50 loads: 4
  ! save no further iterations; test: loads one after the other in
  ! test/contact/test_solve_again.py).
  integer, parameter :: most_kept = 3
  ! Largest ratio of load**(2/3), or of compression, between a solve and the earlier solution it
  ! starts from, or its inverse (measured: beyond it a solve takes longer than one without a start;
  ! test: test_solve_again.py).
  real(real64), parameter :: farthest_ratio = 1.5_real64

contains

  !> Sets the start from the earlier solutions of the position. Without a solution of the same pairs
  !> at a similar load or compression the start is not changed.
  subroutine start_from_earlier(pairs, solution, target)
    type(contact_pairs), intent(in) :: pairs            !! pairs of the position
    type(coupled_solution), intent(inout) :: solution   !! compression, penetrations, shifts
    real(real64), intent(in), optional :: target        !! prescribed load, > 0
    real(real64), allocatable :: node_value(:), weight(:)
    integer, allocatable :: node_index(:)
    real(real64) :: value
    integer :: i, j, k, l, n

    if (.not. associated(pairs%start)) return
    if (.not. allocated(pairs%start%solutions)) return
    if (present(target)) then
      value = hertz_power(target / pairs%modulus)
      if (target / pairs%modulus >= pairs%start%crowded_load) return
    else
      value = solution%compression
      if (value >= pairs%start%crowded_compression) return
    end if
    allocate (node_value(size(pairs%start%solutions)), node_index(0))
    associate (solutions => pairs%start%solutions)
      do k = 1, size(solutions)
        node_value(k) = solutions(k)%compression
        if (present(target)) &
          node_value(k) = hertz_power(solutions(k)%load(merge(2, 1, pairs%vertical)))
        if (.not. (has_same_pairs(pairs, solutions(k)) .and. &
                   node_value(k) < farthest_ratio * value .and. &
                   value < farthest_ratio * node_value(k))) node_value(k) = -1.0_real64
      end do
      do while (any(node_value > 0.0_real64))
        k = minloc(abs(node_value - value), 1, node_value > 0.0_real64)
        node_index = [node_index, k]
        node_value(k) = -node_value(k)
      end do
      if (size(node_index) == 0) return
      node_value = -node_value(node_index)
      n = interpolation_order(value, node_value)
      weight = lagrange_weights(value, node_value(:n))
      if (present(target)) then
        solution%compression = sum([(weight(k) * solutions(node_index(k))%compression, k=1, n)])
        if (n == 1) solution%compression = solution%compression * (value / node_value(1))
      end if
      ! Pairs that were open start open: their penetration has an upper bound only, and the solver
      ! activates those that touch at this load.
      allocate (solution%penetration(size(pairs%list)), source=open_penetration)
      allocate (solution%shift(2, size(pairs%list)), source=0.0_real64)
      do j = n, 1, -1
        weight = lagrange_weights(value, node_value(:j))
        do i = 1, min(size(pairs%list), size(solutions(node_index(1))%gap))
          if (.not. solutions(node_index(1))%penetration(i) > 0.0_real64) cycle
          ! The shift of a pair that was open in an earlier solution may be different.
          if (known_count(i, open_penetration / 2) == j) solution%penetration(i) = &
            sum([(weight(k) * solutions(node_index(k))%penetration(i), k=1, j)])
          if (known_count(i, 0.0_real64) == j) solution%shift(:, i) = &
            [(sum([(weight(k) * solutions(node_index(k))%shift(l, i), k=1, j)]), l=1, 2)]
        end do
      end do
    end associate

  contains

    ! Number of solutions, from the nearest on, in which a penetration is above a limit.
    pure integer function known_count(i, lower_limit) result(number)
      integer, intent(in) :: i
      real(real64), intent(in) :: lower_limit

      do number = 0, n - 1
        associate (kept_solution => pairs%start%solutions(node_index(number + 1)))
          if (i > size(kept_solution%gap)) return
          if (.not. kept_solution%penetration(i) > lower_limit) return
        end associate
      end do
    end function known_count

  end subroutine start_from_earlier

  ! Number of nodes, the nearest first, of an interpolation: the distance of the value from the
  ! nearest one is at most twice their range.
  pure integer function interpolation_order(value, node_value) result(n)
    real(real64), intent(in) :: value, node_value(:)

    do n = size(node_value), 2, -1
      if (abs(value - node_value(1)) <= &
          2 * (maxval(node_value(:n)) - minval(node_value(:n)))) return
    end do
  end function interpolation_order

  ! Lagrange's weights of the nodes at a value.
  pure function lagrange_weights(value, node_value) result(weight)
    real(real64), intent(in) :: value, node_value(:)
    real(real64) :: weight(size(node_value))
    integer :: j, k

    weight = 1.0_real64
    do k = 1, size(node_value)
      do j = 1, size(node_value)
        if (j /= k) &
          weight(k) = weight(k) * (value - node_value(j)) / (node_value(k) - node_value(j))
      end do
    end do
  end function lagrange_weights

  !> Adds a solution to the earlier ones of its position. Earlier ones of other pairs, of the same
  !> compression, and the farthest of more than `most_kept` are dropped.
  subroutine keep_solution(pairs, compression, load, penetration, shift, start)
    type(contact_pairs), intent(in) :: pairs           !! pairs of the position
    real(real64), intent(in) :: compression            !! compression of the contacts
    real(real64), intent(in) :: load(2)                !! sum of normal and of vertical loads
    real(real64), intent(in) :: penetration(:)         !! penetrations by pair, <= 0 where open
    real(real64), intent(in) :: shift(:, :)            !! shifts (2, pair)
    type(solution_start), intent(out) :: start         !! earlier solutions and this one
    logical, allocatable :: is_kept(:)
    integer :: k, n, kept

    allocate (is_kept(0))
    if (associated(pairs%start)) then
      if (allocated(pairs%start%solutions)) then
        is_kept = [(has_same_pairs(pairs, pairs%start%solutions(k)) .and. &
                    abs(pairs%start%solutions(k)%compression - compression) > &
                    sqrt(epsilon(compression)) * compression, k=1, size(pairs%start%solutions))]
        if (count(is_kept) >= most_kept) &
          is_kept(maxloc(abs(pairs%start%solutions%compression - compression), 1, is_kept)) = &
            .false.
      end if
      start%crowded_compression = pairs%start%crowded_compression
      start%crowded_load = pairs%start%crowded_load
    end if
    allocate (start%solutions(count(is_kept) + 1))
    kept = 1
    do k = 1, size(is_kept)
      if (.not. is_kept(k)) cycle
      kept = kept + 1
      start%solutions(kept) = pairs%start%solutions(k)
    end do
    associate (new => start%solutions(1))
      n = count(pairs%list%gap < compression)
      new%compression = compression
      new%load = load / pairs%modulus
      new%upper = pairs%list(:n)%upper
      new%lower = pairs%list(:n)%lower
      new%gap = pairs%list(:n)%gap
      new%penetration = merge(penetration(:n), open_penetration, &
                              abs(penetration(:n)) > tiny(compression))
      new%shift = shift(:, :n)
    end associate
  end subroutine keep_solution

  !> Keeps the earlier solutions, and marks the compression and load of a solution that depends on
  !> its start: from the least of them on no start is set.
  subroutine mark_crowded(pairs, compression, load, start)
    type(contact_pairs), intent(in) :: pairs     !! pairs of the position
    real(real64), intent(in) :: compression      !! compression of the contacts
    real(real64), intent(in) :: load             !! prescribed load, normal or vertical
    type(solution_start), intent(out) :: start   !! earlier solutions, marked

    if (associated(pairs%start)) start = pairs%start
    start%crowded_compression = min(start%crowded_compression, compression)
    start%crowded_load = min(start%crowded_load, load / pairs%modulus)
  end subroutine mark_crowded

  !> Compression at the prescribed load of the pairs, extrapolated by Hertz' law from the earlier
  !> solution of the most similar load; 0 where there is none.
  pure real(real64) function expected_compression(pairs) result(compression)
    type(contact_pairs), intent(in) :: pairs   !! pairs of the position
    real(real64), allocatable :: ratio(:)
    integer :: k

    compression = 0.0_real64
    if (.not. (associated(pairs%start) .and. pairs%target > 0.0_real64)) return
    if (.not. allocated(pairs%start%solutions)) return
    if (pairs%target / pairs%modulus >= pairs%start%crowded_load) return
    associate (solutions => pairs%start%solutions)
      allocate (ratio(size(solutions)))
      do k = 1, size(solutions)
        ratio(k) = hertz_power(pairs%target / &
                               (pairs%modulus * solutions(k)%load(merge(2, 1, pairs%vertical))))
      end do
      k = minloc(abs(log(ratio)), 1)
      if (ratio(k) < farthest_ratio) compression = solutions(k)%compression * ratio(k)
    end associate
  end function expected_compression

  ! Power 2/3 of a load, proportional to the compression of a Hertzian contact.
  elemental real(real64) function hertz_power(load)
    real(real64), intent(in) :: load

    hertz_power = load**(2.0_real64 / 3.0_real64)
  end function hertz_power

  ! Whether an earlier solution is of the same pairs, as far as both lists reach.
  pure logical function has_same_pairs(pairs, kept_solution)
    type(contact_pairs), intent(in) :: pairs
    type(contact_solution), intent(in) :: kept_solution
    integer :: n

    n = min(size(pairs%list), count(kept_solution%gap <= pairs%complete_to))
    has_same_pairs = n > 0
    if (has_same_pairs) has_same_pairs = &
      all(pairs%list(:n)%upper == kept_solution%upper(:n) .and. &
          pairs%list(:n)%lower == kept_solution%lower(:n) .and. &
          .not. abs(pairs%list(:n)%gap - kept_solution%gap(:n)) > 0.0_real64)
  end function has_same_pairs

end module asperity_earlier_solutions
