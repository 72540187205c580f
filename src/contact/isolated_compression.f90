!> The last compression of a position of isolated contacts: at a limit, at a load, or by marching.
module asperity_isolated_compression
  use asperity_candidate_pairs, only: cube_root, limit_penetration, load_of_overlap, overlap_of
  use asperity_contact_pairs, only: scaled_to_real64
  use asperity_kinds, only: real64
  use asperity_placed_scene, only: candidate, is_on_plane, load_unit, placed_scene
  use asperity_problems, only: decimal_text, real_text
  use asperity_root_bracket, only: guess_root, narrow_bracket, root_bracket
  use asperity_scene_values, only: is_distance, is_load
  implicit none
  private

  public :: check_level, compression_at_load, first_at_limit, march_compression

contains

  !> The least compression at which a pair reaches its limit; `any_reachable` is false when no pair
  !> can reach it.
  subroutine first_at_limit(placed, found, compression, any_reachable)
    type(placed_scene), intent(in) :: placed  !! scene in solver units
    type(candidate), intent(in) :: found(:)  !! pairs of a position
    real(real64), intent(out) :: compression  !! compression at the end
    logical, intent(out) :: any_reachable  !! false when no pair can reach it
    real(real64) :: p
    logical :: reachable
    integer :: i

    any_reachable = .false.
    compression = 0.0_real64
    do i = 1, size(found)
      ! A pair that touches beyond the least compression so far is not the first at its limit.
      if (any_reachable) then
        if (found(i)%gap >= compression) cycle
      end if
      call limit_penetration(placed, found(i), p, reachable)
      if (.not. reachable) cycle
      if (any_reachable) then
        if (found(i)%gap + p >= compression) cycle
      end if
      compression = found(i)%gap + p
      any_reachable = .true.
    end do
  end subroutine first_at_limit

  !> Sets `failure` where centres are level or below: the spheres would move apart again. It names
  !> the pair with the least indices.
  subroutine check_level(placed, found, compression, failure)
    type(placed_scene), intent(in) :: placed  !! scene in solver units
    type(candidate), intent(in) :: found(:)  !! pairs of a position
    real(real64), intent(in) :: compression  !! compression at the end
    character(len=:), allocatable, intent(inout) :: failure  !! set where the end is not reached
    integer :: i, first

    first = 0
    do i = 1, size(found)
      if (compression - found(i)%gap < found(i)%zc) cycle
      if (first > 0) then
        if (found(i)%upper > found(first)%upper) cycle
        if (found(i)%upper == found(first)%upper .and. &
            found(i)%lower > found(first)%lower) cycle
      end if
      first = i
    end do
    if (first == 0) return
    if (is_on_plane(found(first))) then
      failure = 'the compression is more than ' // decimal_text(16**5) // &
                ' times the largest radius'
      return
    end if
    if (is_distance(placed%control)) then
      failure = 'at this ' // trim(placed%control%word) // ' the centres of asperities '
    else
      failure = 'before the limit is reached the centres of asperities '
    end if
    failure = failure // decimal_text(found(first)%upper) // ' (upper) and ' // &
              decimal_text(found(first)%lower) // ' (lower) come level'
  end subroutine check_level

  !> The compression at which the sum of the normal forces is the target: first between two first
  !> touches, then by bracketing load**(2/3), which is nearly linear, until no number lies between.
  subroutine compression_at_load(placed, found, overlap, compression, failure)
    type(placed_scene), intent(in) :: placed  !! scene in solver units
    type(candidate), intent(in) :: found(:)  !! pairs of a position
    integer, intent(in) :: overlap  !! `overlap_stable` or `overlap_original`
    real(real64), intent(out) :: compression  !! compression at the end
    character(len=:), allocatable, intent(inout) :: failure  !! set where the end is not reached
    type(root_bracket) :: bracket
    real(real64) :: target, middle, value, most, most_load, high_load
    logical :: inside
    integer :: i, first, last, iteration

    target = placed%target / placed%modulus
    compression = found(1)%gap
    ! Without a compressive target: first touch, from which effects begin.
    if (.not. target > 0.0_real64) return
    most = minval(found%gap + found%zc)
    most_load = load_at(placed, found, most, overlap)
    if (most_load < target .and. placed%control%is_vertical) &
      call find_greatest(placed, found, overlap, most, most_load)
    compression = most
    ! Level centres are excluded, as the slope is infinite.
    if (.not. most_load > target) then
      failure = 'the load is larger than the surfaces carry before the centres of two ' // &
                'asperities are level: ' // &
                real_text(scaled_to_real64(most_load * placed%modulus, load_unit(placed))) // &
                ' at most'
      return
    end if
    ! The last first touch below the target load.
    first = 1
    last = size(found)
    do while (first < last)
      i = (first + last + 1) / 2
      if (found(i)%gap < most) then
        if (load_at(placed, found, found(i)%gap, overlap) <= target) then
          first = i
          cycle
        end if
      end if
      last = i - 1
    end do
    bracket%low = found(first)%gap
    bracket%high = most
    if (first < size(found)) then
      if (found(first + 1)%gap < most) bracket%high = found(first + 1)%gap
    end if
    value = load_at(placed, found, bracket%low, overlap)
    compression = bracket%low
    if (.not. value < target) return
    high_load = load_at(placed, found, bracket%high, overlap)
    bracket%low_miss = load_distance(value)
    bracket%high_miss = load_distance(high_load)
    do iteration = 1, 20000
      call guess_root(bracket, middle, inside)
      if (.not. inside) exit
      value = load_at(placed, found, middle, overlap)
      call narrow_bracket(bracket, middle, load_distance(value), value < target)
      if (.not. (value < target .or. value > target)) exit
    end do
    compression = bracket%high

  contains

    ! Difference of a load and the target in the powers 2/3 of ratios, so that the iterates do not
    ! depend on the unit of length.
    pure real(real64) function load_distance(load)
      real(real64), intent(in) :: load

      load_distance = cube_root(load / high_load)**2 - cube_root(target / high_load)**2
    end function load_distance

  end subroutine compression_at_load

  ! The compression at which the vertical load is greatest, by golden section: the forces of
  ! contacts with nearly level centres are nearly horizontal.
  pure subroutine find_greatest(placed, found, overlap, compression, load)
    type(placed_scene), intent(in) :: placed
    type(candidate), intent(in) :: found(:)
    integer, intent(in) :: overlap
    real(real64), intent(inout) :: compression  ! upper bound, then that of the greatest load
    real(real64), intent(inout) :: load
    integer, parameter :: cuts = 80
    real(real64) :: low, high, place(2), value(2)
    ! Golden section.
    real(real64), parameter :: share = 0.618033988749894848_real64
    integer :: i

    low = 0.0_real64
    high = compression
    do i = 1, cuts
      place = [high - share * (high - low), low + share * (high - low)]
      value = [load_at(placed, found, place(1), overlap), load_at(placed, found, place(2), overlap)]
      if (maxval(value) > load) then
        load = maxval(value)
        compression = place(maxloc(value, 1))
      end if
      if (value(2) < value(1)) then
        high = place(2)
      else
        low = place(1)
      end if
    end do
  end subroutine find_greatest

  ! Sum of the normal forces, or of their vertical parts, over the combined modulus at a
  ! compression; the list is sorted by gap.
  pure function load_at(placed, found, compression, overlap) result(load)
    type(placed_scene), intent(in) :: placed
    type(candidate), intent(in) :: found(:)
    real(real64), intent(in) :: compression
    integer, intent(in) :: overlap
    real(real64) :: load, p, w, one_load
    integer :: i

    load = 0.0_real64
    do i = 1, size(found)
      if (.not. found(i)%gap < compression) exit
      p = compression - found(i)%gap
      w = overlap_of(found(i), p, overlap)
      one_load = load_of_overlap(found(i)%radius, w)
      ! Without an offset in plan the cosine is 1, also where the centres coincide.
      if (placed%control%is_vertical .and. found(i)%d > 0.0_real64) &
        one_load = one_load * ((found(i)%zc - p) / (found(i)%s - w))
      load = load + one_load
    end do
  end function load_at

  !> Equal steps until a pair is at its limit or the load is reached, with shorter steps to each
  !> first touch: the method of the original, for the accuracy study.
  subroutine march_compression(placed, found, step, overlap, compression)
    type(placed_scene), intent(in) :: placed  !! scene in solver units
    type(candidate), intent(in) :: found(:)  !! pairs of a position
    real(real64), intent(in) :: step  !! step of the compression
    integer, intent(in) :: overlap  !! `overlap_stable` or `overlap_original`
    real(real64), intent(out) :: compression  !! compression at the end
    real(real64) :: next, w
    integer :: contacts, i
    logical :: at_limit

    compression = 0.0_real64
    contacts = 1
    at_limit = .false.
    do while (.not. at_limit)
      do while (contacts < size(found))
        if (found(contacts + 1)%gap > compression) exit
        contacts = contacts + 1
      end do
      next = compression + step
      if (contacts < size(found)) then
        if (found(contacts + 1)%gap - compression < step) next = found(contacts + 1)%gap
      end if
      compression = next
      if (is_load(placed%control)) then
        at_limit = load_at(placed, found, compression, overlap) * placed%modulus >= placed%target
      else
        ! The load of each contact at each step, as in the original.
        do i = 1, contacts
          w = overlap_of(found(i), compression - found(i)%gap, overlap)
          if (placed%modulus * load_of_overlap(found(i)%radius, w) >= placed%limit) &
            at_limit = .true.
        end do
      end if
      if (.not. compression < found(1)%zc) exit
    end do
  end subroutine march_compression

end module asperity_isolated_compression
