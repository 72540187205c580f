!> All pairs of two surfaces whose spheres can touch, and what follows from them: what the solver's
!> searches are compared with.
module asperity_all_pairs
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_records, only: position_result
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text
  use asperity_testing, only: check, error_type
  implicit none
  private

  public :: all_pairs
  public :: check_list, check_states, first_limit, pair_named

  !> By upper and lower index, in the solver's units.
  type :: all_pairs
    logical, allocatable :: can_touch(:, :)    !! the spheres overlap in plan
    real(real64), allocatable :: gap(:, :)     !! compression at which they touch; huge: they cannot
    real(real64), allocatable :: d(:, :)       !! distance of the centres in plan
    real(real64), allocatable :: s(:, :)       !! sum of the radii
    real(real64), allocatable :: zc(:, :)      !! height between the centres at first touch
    real(real64), allocatable :: radius(:, :)  !! combined radius
    real(real64) :: first_touch = 0.0_real64   !! largest approach at which a pair touches
    real(real64) :: compression = 0.0_real64       !! at the approach asked for
  end type all_pairs

contains

  !> Checks that a list holds every pair that touches up to a compression, each once, with the
  !> numbers of a comparison of all with all, and in the order of touch.
  subroutine check_list(error, truth, listed, compression, exactly, what)
    type(error_type), allocatable, intent(inout) :: error  !! the first failure
    type(all_pairs), intent(in) :: truth                     !! the truth
    type(contact_pairs), intent(in) :: listed              !! by the solver
    real(real64), intent(in) :: compression                    !! no pair up to it may be missing
    logical, intent(in) :: exactly                         !! and none beyond it listed
    character(len=*), intent(in) :: what                   !! told of a failure
    logical :: seen(size(truth%gap, 1), size(truth%gap, 2)), same
    integer :: i

    seen = .false.
    do i = 1, size(listed%list)
      associate (pair => listed%list(i))
        call check(error, .not. seen(pair%upper, pair%lower), what // ': a pair twice')
        seen(pair%upper, pair%lower) = .true.
        same = all(same_bits([pair%gap, pair%d, pair%s, pair%zc, pair%radius], &
                             [truth%gap(pair%upper, pair%lower), truth%d(pair%upper, pair%lower), &
                              truth%s(pair%upper, pair%lower), truth%zc(pair%upper, pair%lower), &
                              truth%radius(pair%upper, pair%lower)]))
        call check(error, same, what // ': other numbers of a pair')
        if (i > 1) call check(error, in_order(listed, i), what // ': another order')
      end associate
      if (allocated(error)) return
    end do
    call check(error, .not. any(truth%gap <= compression .and. .not. seen), &
               what // ': a pair is lost')
    if (exactly) call check(error, all(truth%gap <= compression .or. .not. seen), &
                            what // ': a pair too many')
  end subroutine check_list

  !> Checks the numbers of contacts of all states, and who touches in the last.
  subroutine check_states(error, truth, result, compression, unit, what)
    type(error_type), allocatable, intent(inout) :: error  !! the first failure
    type(all_pairs), intent(in) :: truth                     !! the truth
    type(position_result), intent(in) :: result            !! of the solver, with contacts
    real(real64), intent(in) :: compression                    !! where the position ends
    real(real64), intent(in) :: unit                       !! of length, in the scene's
    character(len=*), intent(in) :: what                   !! told of a failure
    integer :: i, first

    do i = 1, size(result%states)
      call check(error, result%states(i)%contacts, &
                 count(truth%gap <= result%states(i)%compression / unit), &
                 what // ': other contacts')
    end do
    if (allocated(error)) return
    first = result%rows_used - result%states(size(result%states))%contacts
    do i = first + 1, result%rows_used
      call check(error, truth%gap(result%rows(i)%upper, result%rows(i)%lower) <= compression, &
                 what // ': a contact that is none')
      if (i == first + 1) cycle
      call check(error, truth%gap(result%rows(i - 1)%upper, result%rows(i - 1)%lower) <= &
                        truth%gap(result%rows(i)%upper, result%rows(i)%lower), &
                 what // ': contacts in another order')
    end do
  end subroutine check_states

  !> The least compression at which a pair is at its limit; huge when none is before its centres are
  !> level. `listed` has all pairs.
  pure real(real64) function first_limit(listed)
    type(contact_pairs), intent(in) :: listed  !! with the penetration of each at its limit

    first_limit = huge(first_limit)
    if (any(listed%list%limit < huge(first_limit))) &
      first_limit = minval(listed%list%gap + listed%list%limit, &
                           mask=listed%list%limit < huge(first_limit))
  end function first_limit

  !> How a message names the pair with the least indices whose centres are level; empty: none is.
  pure function pair_named(truth, compression) result(text)
    type(all_pairs), intent(in) :: truth   !! the truth
    real(real64), intent(in) :: compression  !! where the position ends
    character(len=:), allocatable :: text
    integer :: i, k

    text = ''
    do i = 1, size(truth%gap, 1)
      do k = 1, size(truth%gap, 2)
        if (.not. truth%can_touch(i, k)) cycle
        if (compression - truth%gap(i, k) < truth%zc(i, k)) cycle
        text = 'the centres of asperities ' // decimal_text(i) // ' (upper) and ' // &
               decimal_text(k) // ' (lower) come level'
        return
      end do
    end do
  end function pair_named

  ! Gap, distance, sum of the radii, combined radius, indices: the first that differs decides.
  pure logical function in_order(listed, i)
    type(contact_pairs), intent(in) :: listed
    integer, intent(in) :: i
    real(real64) :: difference(6)
    integer :: k

    associate (a => listed%list(i - 1), b => listed%list(i))
      difference = [b%gap - a%gap, b%d - a%d, b%s - a%s, b%radius - a%radius, &
                    real(b%upper - a%upper, real64), real(b%lower - a%lower, real64)]
    end associate
    in_order = .false.
    do k = 1, size(difference)
      in_order = difference(k) > 0.0_real64
      if (abs(difference(k)) > 0.0_real64) return
    end do
  end function in_order

  elemental logical function same_bits(a, b)
    real(real64), intent(in) :: a, b

    same_bits = transfer(a, 0_int64) == transfer(b, 0_int64)
  end function same_bits

end module asperity_all_pairs
