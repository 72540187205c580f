!> The search for the root of an increasing function by reverse communication: a bracket returns a
!> guess, and the caller passes the value of the function there. False position with the Illinois
!> rule (Dowell and Jarratt 1971), bisection where that is slow. The bracket never widens, so that
!> no search fails.
module asperity_root_bracket
  use asperity_kinds, only: real64
  implicit none
  private

  public :: root_bracket
  public :: guess_by_secant, guess_root, narrow_bracket

  !> Two places, 0 or more, on both sides of a zero of a function, and its values there.
  type :: root_bracket
    real(real64) :: low           !! place where the function is below zero
    real(real64) :: high          !! place where it is zero or above
    real(real64) :: low_miss      !! its value at `low`; halved while only `high` moves
    real(real64) :: high_miss     !! its value at `high`; below zero: unknown; halved as the other
    integer :: side = 0           !! end that moved last: -1 `low`, 1 `high`
    integer :: guesses = 0        !! number of guesses so far
    integer :: halving = 3        !! every guess of this number is a bisection
    integer :: known = 0          !! number of values so far
    real(real64) :: last = 0.0_real64         !! last place
    real(real64) :: last_miss = 0.0_real64    !! value there
    real(real64) :: former = 0.0_real64       !! place before the last one
    real(real64) :: former_miss = 0.0_real64  !! value there
  end type root_bracket

contains

  !> Guesses a place inside a bracket: the zero of the chord, or the middle, when that is outside
  !> and at each `halving`-th guess (by ratio where the ends differ by magnitudes). It is inside
  !> unless no number lies between the ends.
  pure subroutine guess_root(bracket, guess, inside)
    type(root_bracket), intent(inout) :: bracket  !! bracket with its number of guesses
    real(real64), intent(out) :: guess            !! next place of the function
    logical, intent(out) :: inside                !! false: the search has ended
    real(real64), parameter :: far = 2.0_real64**40

    bracket%guesses = bracket%guesses + 1
    associate (low => bracket%low, high => bracket%high)
      if (modulo(bracket%guesses, bracket%halving) > 0 .and. &
          bracket%high_miss > bracket%low_miss) then
        guess = low - (high - low) * (bracket%low_miss / (bracket%high_miss - bracket%low_miss))
        inside = guess > low .and. guess < high
        if (inside) return
      end if
      if (.not. high / 16 > low) then
        guess = low + (high - low) / 2
      else if (low > high / far / far) then
        guess = low * sqrt(high / low)
      else
        guess = high / far
      end if
      inside = guess > low .and. guess < high
    end associate
  end subroutine guess_root

  !> Guesses the zero of the secant through the last two places, or of the tangent at the only one:
  !> for smooth functions. Where the last guess did not halve the value, or the secant has no zero
  !> inside the bracket, the guess is that of `guess_root` (safeguard of Dekker 1969).
  pure subroutine guess_by_secant(bracket, slope, guess, inside)
    type(root_bracket), intent(inout) :: bracket  !! bracket with at least one value
    real(real64), intent(in) :: slope             !! of the function at the last place; 0: unknown
    real(real64), intent(out) :: guess            !! next place of the function
    logical, intent(out) :: inside                !! false: the search has ended
    real(real64) :: change

    inside = .false.
    change = slope
    if (bracket%known > 1) change = 0.0_real64
    if (bracket%known > 1 .and. abs(bracket%last - bracket%former) > 0.0_real64 .and. &
        abs(bracket%last_miss) <= 0.5_real64 * abs(bracket%former_miss)) &
      change = (bracket%last_miss - bracket%former_miss) / (bracket%last - bracket%former)
    if (change * (bracket%high - bracket%low) > abs(bracket%last_miss)) then
      guess = bracket%last - bracket%last_miss / change
      inside = guess > bracket%low .and. guess < bracket%high
    end if
    if (.not. inside) call guess_root(bracket, guess, inside)
  end subroutine guess_by_secant

  !> Moves one end of a bracket to a place. The value at an end that does not move twice is halved,
  !> so that both ends move.
  pure subroutine narrow_bracket(bracket, place, residual, is_low)
    type(root_bracket), intent(inout) :: bracket  !! bracket, narrowed on exit
    real(real64), intent(in) :: place              !! place inside the bracket
    real(real64), intent(in) :: residual           !! value of the function there
    logical, intent(in) :: is_low                 !! whether it is below zero before rounding

    bracket%known = bracket%known + 1
    bracket%former = bracket%last
    bracket%former_miss = bracket%last_miss
    bracket%last = place
    bracket%last_miss = residual
    if (is_low) then
      bracket%low = place
      bracket%low_miss = residual
      if (bracket%side < 0) bracket%high_miss = bracket%high_miss / 2
      bracket%side = -1
    else
      bracket%high = place
      bracket%high_miss = residual
      if (bracket%side > 0) bracket%low_miss = bracket%low_miss / 2
      bracket%side = 1
    end if
  end subroutine narrow_bracket

end module asperity_root_bracket
