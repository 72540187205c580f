!> Root, power, sine and cosine of short hexadecimal numbers, in integers throughout.
submodule(asperity_hex32) asperity_hex32_functions
  use asperity_hex32_arithmetic, only: fraction_digits, int64_bits
  use asperity_hex32_conversions, only: limb_bits, limb_mask
  use asperity_kinds, only: int32, int64
  implicit none

  !> Limbs below the point of a fixed-point number; limb 0 stands above it.
  integer, parameter :: places = 4
  !> Terms that bring the series below the last bit of such a number for angles up to pi/4.
  integer, parameter :: series_terms = 17
  !> Below 16**exponent the sine rounds to its angle and the cosine to one.
  integer(int32), parameter :: series_exponent = -3_int32
  ! The library's constants 1.681595, 1.288973 and 0.8408065; cut or rounded they are the same.
  type(hex32), parameter :: c1 = hex32(1763280_int32, 1_int32)
  type(hex32), parameter :: c2 = hex32(1351586_int32, 1_int32)
  type(hex32), parameter :: c3 = hex32(14106392_int32, 0_int32)
  type(hex32), parameter :: half = hex32(8388608_int32, 0_int32)
  type(hex32), parameter :: quarter = hex32(4194304_int32, 0_int32)

contains

  elemental module function square_root(x) result(root)
    type(hex32), intent(in) :: x
    type(hex32) :: root
    type(hex32) :: m, reduced, y, quotient
    integer(int32) :: p, q
    integer(int64) :: total

    if (x%mantissa == 0_int32) then
      root = x
    else
      ! x = 16**(2p - q) * m, q = 0 or 1. The factor 16**p changes no digit and is applied last.
      p = shifta(x%power + 1_int32, 1)
      q = 2_int32*p - x%power
      m = hex32(abs(x%mantissa), 0_int32)
      reduced = hex32(m%mantissa, -q)
      y = c1 - c2/(m + c3)
      if (q == 1_int32) y = quarter*y
      y = half*(y + reduced/y)
      quotient = reduced/y
      ! The last sum keeps all its digits, in units of 16**(-7), until it is halved and rounded.
      total = at_seventh_place(y) + at_seventh_place(quotient)
      root = rounded_number(total, -4*(fraction_digits + 1) - 1)
      root%power = root%power + p
    end if
  end function square_root

  elemental module function three_halves_power(x) result(power)
    type(hex32), intent(in) :: x
    type(hex32) :: power
    integer(int64) :: mantissa, square, high, low, radicand
    integer(int32) :: drop

    if (x%mantissa == 0_int32) then
      power = x
    else
      ! The cube, high * 2**24 + low, has 61 to 72 bits and no overflow this way.
      mantissa = int(abs(x%mantissa), int64)
      square = mantissa*mantissa
      low = ibits(square, 0, 24)*mantissa
      high = shiftr(square, 24)*mantissa + shiftr(low, 24)
      low = ibits(low, 0, 24)
      ! Number of hex digits to drop: the root has six, and its exponent is a whole number.
      drop = modulo(x%power, 2_int32) + 4_int32
      if (shiftr(high, 4*drop + 24) /= 0_int64) drop = drop + 2_int32
      ! Four times the radicand has twice the root, whose last bit decides the rounding.
      if (4*drop - 2 >= 24) then
        radicand = shiftr(high, 4*drop - 26)
      else
        radicand = ior(shiftl(high, 26 - 4*drop), shiftr(low, 4*drop - 2))
      end if
      power = hex32_from_binary(shiftr(whole_root(radicand) + 1_int64, 1), &
                                2*(3*(x%power - fraction_digits) + drop))
    end if
  end function three_halves_power

  elemental module function sine(x) result(value)
    type(hex32), intent(in) :: x
    type(hex32) :: value

    if (x%power <= series_exponent .or. x%mantissa == 0_int32) then
      value = x
    else
      value = sine_of_turns(x, 0_int64)
      if (x%mantissa < 0_int32) value = -value
    end if
  end function sine

  elemental module function cosine(x) result(value)
    type(hex32), intent(in) :: x
    type(hex32) :: value

    if (x%power <= series_exponent .or. x%mantissa == 0_int32) then
      value = hex32_from_integer(1)
    else
      value = sine_of_turns(x, 1_int64)
    end if
  end function cosine

  !> The number in units of 16**(-7).
  elemental integer(int64) function at_seventh_place(x) result(units)
    !> exponent in [-1, 1], so that no digit is lost
    type(hex32), intent(in) :: x

    units = shiftl(int(x%mantissa, int64), 4*(x%power + 1))
  end function at_seventh_place

  !> magnitude * 2**power, normalised and rounded to 24 bits; a tie goes up.
  elemental type(hex32) function rounded_number(magnitude, power) result(x)
    !> in [0, 2**60)
    integer(int64), intent(in) :: magnitude
    integer, intent(in) :: power
    integer(int64) :: aligned
    integer :: excess

    ! Hex digits are counted with the point between two of them.
    aligned = shiftl(magnitude, iand(power, 3))
    excess = 4*((int64_bits - leadz(aligned) + 3)/4 - fraction_digits)
    if (excess > 0) aligned = aligned + shiftl(1_int64, excess - 1)
    ! After a carry into one more digit only zeros are cut.
    x = hex32_from_binary(aligned, 4*shifta(power, 2))
  end function rounded_number

  !> The whole part of a square root.
  elemental function whole_root(n) result(root)
    !> above zero
    integer(int64), intent(in) :: n
    integer(int64) :: root, next

    ! Newton's method from above decreases until it has converged.
    root = shiftl(1_int64, (int64_bits - leadz(n) + 1)/2)
    do
      next = shiftr(root + n/root, 1)
      if (next >= root) exit
      root = next
    end do
  end function whole_root

  !> The sine of the angle's magnitude plus a number of quarter turns.
  elemental type(hex32) function sine_of_turns(x, quarter_turns) result(value)
    !> magnitude 16**(-3) or more
    type(hex32), intent(in) :: x
    integer(int64), intent(in) :: quarter_turns
    integer(int64) :: angle(0:places), square(0:places), term(0:places)
    integer(int64) :: quadrant
    logical :: backwards, by_cosine
    integer :: i

    call reduce_angle(x, angle, quadrant, backwards)
    quadrant = quadrant + quarter_turns
    by_cosine = btest(quadrant, 0)
    square(:) = limb_product(angle, angle)
    term(:) = one_in_limbs()
    do i = 2*series_terms, 2, -2
      if (by_cosine) then
        term(:) = limb_quotient(limb_product(square, term), int(i*(i - 1), int64))
      else
        term(:) = limb_quotient(limb_product(square, term), int(i*(i + 1), int64))
      end if
      term(:) = one_minus(term)
    end do
    if (.not. by_cosine) term(:) = limb_product(angle, term)
    value = from_limbs(term)
    if (btest(quadrant, 1) .neqv. (backwards .and. .not. by_cosine)) value = -value
  end function sine_of_turns

  !> Reduces an angle by whole quarter turns; `angle` is the magnitude of the remainder.
  pure subroutine reduce_angle(x, angle, quadrant, backwards)
    type(hex32), intent(in) :: x
    !> at most pi/4, in fixed point
    integer(int64), intent(out) :: angle(0:places)
    !> whole quarter turns nearest to the angle
    integer(int64), intent(out) :: quadrant
    !> whether the remainder is below zero
    logical, intent(out) :: backwards
    !> 2/pi in limbs, as many as the largest number needs
    integer, parameter :: length = 13
    integer(int64), parameter :: two_over_pi(length) = [ &
                                 683565275_int64, 618938706_int64, 670080351_int64, &
                                 301282525_int64, 808900773_int64, 429114425_int64, &
                                 17299781_int64, 598466235_int64, 827878857_int64, &
                                 115581988_int64, 927694873_int64, 154069513_int64, &
                                 879003455_int64]
    !> pi/2 in limbs
    integer(int64), parameter :: half_pi(0:places) = [ &
                                 1_int64, 612887889_int64, 70064198_int64, &
                                 640037652_int64, 385988665_int64]
    integer(int64) :: turns(-2:length), carry
    integer :: i, last, limb

    turns(:) = 0_int64
    carry = 0_int64
    do i = length, 1, -1
      carry = two_over_pi(i)*int(abs(x%mantissa), int64) + carry
      turns(i) = iand(carry, limb_mask)
      carry = shiftr(carry, limb_bits)
    end do
    turns(0) = carry
    ! The point moves by the exponent; each limb is read from two of these.
    do i = 0, places
      last = limb_bits*i + 4*(x%power - fraction_digits)
      limb = ceiling_quotient(last, limb_bits)
      carry = shiftl(turns(limb - 1), limb_bits) + turns(limb)
      angle(i) = iand(shiftr(carry, limb_bits*limb - last), limb_mask)
    end do
    quadrant = angle(0)
    angle(0) = 0_int64
    backwards = angle(1) >= 2_int64**(limb_bits - 1)
    if (backwards) then
      quadrant = quadrant + 1_int64
      angle(:) = one_minus(angle)
    end if
    angle(:) = limb_product(angle, half_pi)
  end subroutine reduce_angle

  !> i/n rounded upwards.
  elemental integer function ceiling_quotient(i, n) result(quotient)
    integer, intent(in) :: i, n

    quotient = (i + modulo(-i, n))/n
  end function ceiling_quotient

  !> One in fixed point.
  pure function one_in_limbs() result(c)
    integer(int64) :: c(0:places)

    c(0) = 1_int64
    c(1:) = 0_int64
  end function one_in_limbs

  !> 1 - a for a in [0, 1].
  pure function one_minus(a) result(c)
    integer(int64), intent(in) :: a(0:places)
    integer(int64) :: c(0:places), borrow
    integer :: i

    c(:) = one_in_limbs() - a
    do i = places, 1, -1
      borrow = merge(1_int64, 0_int64, c(i) < 0_int64)
      c(i) = c(i) + shiftl(borrow, limb_bits)
      c(i - 1) = c(i - 1) - borrow
    end do
  end function one_minus

  !> Product of two fixed-point numbers, the smaller limbs dropped.
  pure function limb_product(a, b) result(c)
    integer(int64), intent(in) :: a(0:places), b(0:places)
    integer(int64) :: c(0:places), carry
    integer :: i, k

    carry = 0_int64
    do k = places, 0, -1
      ! Limb 0 is at most 1, so that at most three of the products reach 2**60.
      c(k) = carry
      do i = 0, k
        c(k) = c(k) + a(i)*b(k - i)
      end do
      carry = shiftr(c(k), limb_bits)
      if (k > 0) c(k) = iand(c(k), limb_mask)
    end do
  end function limb_product

  !> A fixed-point number divided by a small one, cut.
  pure function limb_quotient(a, n) result(c)
    integer(int64), intent(in) :: a(0:places)
    !> below 2**30
    integer(int64), intent(in) :: n
    integer(int64) :: c(0:places), rest
    integer :: i

    rest = 0_int64
    do i = 0, places
      rest = shiftl(rest, limb_bits) + a(i)
      c(i) = rest/n
      rest = rest - c(i)*n
    end do
  end function limb_quotient

  !> A fixed-point number in [0, 1], rounded to 24 bits.
  pure type(hex32) function from_limbs(a) result(x)
    integer(int64), intent(in) :: a(0:places)
    integer :: top

    top = 0
    do while (a(top) == 0_int64 .and. top < places - 1)
      top = top + 1
    end do
    ! Two limbs are sufficient: sines and cosines are never at a tie, so that lower bits do not
    ! matter.
    x = rounded_number(shiftl(a(top), limb_bits) + a(top + 1), -limb_bits*(top + 1))
  end function from_limbs

end submodule asperity_hex32_functions
