!> Tests of what one circle of pressure does to another.
!>
!> Truths: Johnson's displacement of a Hertz pressure (Contact Mechanics, 1985, eq. 3.41a, 3.42a)
!> and its mean by brute force; derivatives by differences.
module asperity_mutual_suite
  use asperity_kinds, only: real64
  use asperity_mutual_displacement, only: mutual_displacement, mutual_terms, oval_field
  use asperity_testing, only: check, run_test
  implicit none
  private

  public :: run_mutual

  real(real64), parameter :: pi = acos(-1.0_real64)

contains

  !> Runs the tests.
  subroutine run_mutual
    call run_test('the field at a point is that of Johnson, in and out', field_of_johnson)
    call run_test('means over a circle are those of that field', means_by_force)
    call run_test('oval fields are means of second derivatives', ovals_by_force)
    call run_test('closed forms, series, four times the digits and points meet', forms_meet)
    call run_test('derivatives are those of the means, through both rims', derivatives)
  end subroutine run_mutual

  ! Displacement at distance r by a unit load on a circle of radius a, modulus 1.
  pure function johnson(r, a) result(lift)
    real(real64), intent(in) :: r, a
    real(real64) :: lift, peak

    peak = 1.5_real64 / (pi * a**2)
    if (r <= a) then
      lift = peak * pi / (4 * a) * (2 * a**2 - r**2)
    else
      lift = peak / (2 * a) * ((2 * a**2 - r**2) * asin(a / r) + r * a * sqrt(1 - (a / r)**2))
    end if
  end function johnson

  subroutine field_of_johnson
    type(mutual_terms) :: terms
    real(real64) :: r, truth
    integer :: i

    do i = 0, 40
      r = 0.25_real64 * i
      call mutual_displacement(r, 0.0_real64, 1.3_real64, terms)
      truth = johnson(r, 1.3_real64)
      call check(terms%on_first / truth, 1.0_real64, 1.0e-11_real64, 'on a point')
      call check(terms%mean / truth, 1.0_real64, 1.0e-11_real64, 'mean on a point')
      call mutual_displacement(r, 1.3_real64, 0.0_real64, terms)
      call check(terms%on_second / truth, 1.0_real64, 1.0e-11_real64, 'exchanged')
    end do
  end subroutine field_of_johnson

  ! Outside the other circle, whose field is Johnson's and for a flat punch asin(b/r)/(pi b).
  subroutine ovals_by_force
    real(real64), parameter :: cases(3, 6) = reshape(real([ &
      27, 10, 10, 30, 5, 10, 140, 100, 10, 125, 10, 100, 90, 10, 10, 450, 10, 100], real64) / 10, &
      [3, 6])
    integer, parameter :: rings = 300, spokes = 200
    type(mutual_terms) :: terms
    real(real64) :: a, azimuth, b, d, offset(2), rho, truth(2)
    integer :: i, j, k

    do k = 1, size(cases, 2)
      a = cases(2, k)
      b = cases(3, k)
      truth = 0.0_real64
      do i = 1, rings
        ! Equal steps of the fifth power of the root of 1 - (rho/a)**2 have equal weights.
        rho = a * sqrt(1 - ((i - 0.5_real64) / rings)**0.4_real64)
        do j = 1, spokes
          azimuth = 2 * pi * (j - 0.5_real64) / spokes
          offset = [cases(1, k) + rho * cos(azimuth), rho * sin(azimuth)]
          d = norm2(offset)
          call mutual_displacement(d, 0.0_real64, b, terms)
          truth = truth + [terms%bend - terms%slope / d, &
                           (3 * d**2 - 2 * b**2) / (pi * d**2 * sqrt(d**2 - b**2)**3)] * &
                  (offset(1)**2 - offset(2)**2) / d**2
        end do
      end do
      truth = oval_field(cases(1, k), a, b) / (truth / (rings * spokes))
      call check(maxval(abs(truth - 1)), 0.0_real64, 1.0e-4_real64, 'oval')
    end do
  end subroutine ovals_by_force

  subroutine means_by_force
    real(real64), parameter :: cases(3, 8) = reshape(real([ &
      0, 10, 10, 3, 10, 7, 10, 10, 10, 17, 10, 10, 20, 10, 10, 25, 6, 12, 60, 10, 4, 95, 10, 10], &
      real64) / 10, [3, 8])
    integer, parameter :: rings = 400, spokes = 400
    type(mutual_terms) :: terms, exchanged
    real(real64) :: r, a, b, share, flat, hertz
    integer :: i, k

    do k = 1, size(cases, 2)
      r = cases(1, k)
      a = cases(2, k)
      b = cases(3, k)
      flat = 0.0_real64
      hertz = 0.0_real64
      do i = 1, rings
        share = (i - 0.5_real64) / rings
        ! A flat punch weighs equal steps of the root of 1 - (rho/a)**2 alike, Hertz' pressure of
        ! its third power.
        flat = flat + around(a * sqrt(1 - share**2)) / rings
        hertz = hertz + around(a * sqrt(1 - share**(2.0_real64 / 3.0_real64))) / rings
      end do
      call mutual_displacement(r, a, b, terms)
      call check(terms%on_first / flat, 1.0_real64, 1.0e-5_real64, 'mean on the first')
      call check(terms%mean / hertz, 1.0_real64, 2.0e-5_real64, 'mean with Hertz')
      call mutual_displacement(r, b, a, exchanged)
      call check(exchanged%on_second / terms%on_first, 1.0_real64, 1.0e-12_real64, &
                 'mean on the second')
    end do

  contains

    ! Mean over a circle about the first centre.
    real(real64) function around(rho)
      real(real64), intent(in) :: rho
      integer :: j

      around = 0.0_real64
      do j = 1, spokes
        around = around + johnson(sqrt(r**2 + rho**2 + 2 * r * rho * &
                                       cos(pi * (j - 0.5_real64) / spokes)), b) / spokes
      end do
    end function around

  end subroutine means_by_force

  ! All terms of two circles as one row.
  pure function row_of(r, first, second) result(row)
    real(real64), intent(in) :: r, first, second
    real(real64) :: row(10)
    type(mutual_terms) :: terms

    call mutual_displacement(r, first, second, terms)
    row = [terms%mean, terms%on_first, terms%on_second, terms%compliance, terms%slope, &
           terms%first_slope, terms%second_slope, terms%bend, terms%first_growth, &
           terms%second_growth]
  end function row_of

  subroutine forms_meet
    real(real64), parameter :: step = 1.0e-9_real64
    real(real64), dimension(10) :: before, after, size_of
    integer :: i

    ! Four sums of radii: the series begins.
    before = row_of(6.4_real64 * (1 - step), 1.0_real64, 0.6_real64)
    after = row_of(6.4_real64 * (1 + step), 1.0_real64, 0.6_real64)
    call check(maxval(abs(after(:8) / before(:8) - 1)), 0.0_real64, 2.0e-8_real64, 'series')
    call check(maxval(abs(after(9:) / before(9:) - 1)), 0.0_real64, 1.0e-7_real64, &
               'growth by series')
    ! Ratios at which the digits are doubled, and at which a circle is a point.
    do i = 0, 30
      before = row_of(0.11_real64 * i, 0.04_real64 * (1 - step), 1.0_real64)
      after = row_of(0.11_real64 * i, 0.04_real64 * (1 + step), 1.0_real64)
      call check(maxval(abs(after - before)), 0.0_real64, 2.0e-8_real64, 'twice the digits')
      before = row_of(0.11_real64 * i, 1.3e-8_real64, 1.0_real64)
      after = row_of(0.11_real64 * i, 1.7e-8_real64, 1.0_real64)
      size_of = max(abs(after), 1.0_real64)
      call check(maxval(abs(after - before) / size_of), 0.0_real64, 1.0e-6_real64, 'a point')
    end do
  end subroutine forms_meet

  ! Central differences of fourth order, by distance (0), first radius (1) or second (2).
  pure function difference(r, first, second, by, step) result(change)
    real(real64), intent(in) :: r, first, second, step
    integer, intent(in) :: by
    real(real64) :: change(10)

    change = (8 * (at(step) - at(-step)) - (at(2 * step) - at(-2 * step))) / (12 * step)

  contains

    pure function at(off) result(row)
      real(real64), intent(in) :: off
      real(real64) :: row(10)

      row = row_of(r + merge(off, 0.0_real64, by == 0), first + merge(off, 0.0_real64, by == 1), &
                   second + merge(off, 0.0_real64, by == 2))
    end function at

  end function difference

  ! Distances for two circles: inside, at both rims, between them, outside.
  pure function distances(first, second) result(r)
    real(real64), intent(in) :: first, second
    real(real64), parameter :: beside(6) = [-2.0_real64, -0.5_real64, -0.1_real64, 0.1_real64, &
                                            0.5_real64, 2.0_real64]
    real(real64) :: r(19), small

    small = min(first, second)
    r(:6) = abs(first - second) + small * beside
    r(7:12) = first + second + small * beside
    r(13:) = [0.03_real64, 0.3_real64, 0.9_real64, 1.5_real64, 3.0_real64, 3.9_real64, &
              6.0_real64] * (first + second)
  end function distances

  subroutine derivatives
    real(real64), parameter :: ratios(8) = [1.0_real64, 0.7_real64, 0.2_real64, 0.05_real64, &
                                            0.03_real64, 1.0e-3_real64, 1.0e-5_real64, &
                                            1.0e-6_real64]
    real(real64), dimension(10) :: row, by_r, by_first, by_second
    real(real64) :: r(19), first, second, step
    integer :: i, k

    do k = -size(ratios), size(ratios)
      if (k == 0) cycle
      first = merge(1.0_real64, ratios(abs(k)), k > 0)
      second = merge(ratios(abs(k)), 1.0_real64, k > 0)
      r = distances(first, second)
      do i = 1, size(r)
        if (.not. r(i) > 0.0_real64) cycle
        ! The terms are no polynomials at the rims.
        step = 0.01_real64 * min(abs(r(i) - first - second), abs(r(i) - abs(first - second)), &
                                 r(i), first, second)
        ! For some radii a distance beside one rim is at the other.
        if (step < 1.0e-5_real64 * min(first, second)) cycle
        row = row_of(r(i), first, second)
        by_r = difference(r(i), first, second, 0, step)
        by_first = first * difference(r(i), first, second, 1, step)
        by_second = second * difference(r(i), first, second, 2, step)
        call compare(row(5), by_r(1), 'slope')
        call compare(row(6), by_r(2), 'slope on the first')
        call compare(row(7), by_r(3), 'slope on the second')
        call compare(row(8), by_r(5), 'bend')
        call compare(row(9), by_first(2), 'growth of the first')
        call compare(row(10), by_second(3), 'growth of the second')
        ! A circle grows with the third root of its load.
        call compare(row(2), row(1) + by_first(1) / 3, 'V G by the first load')
        call compare(row(3), row(1) + by_second(1) / 3, 'V G by the second load')
        call compare(row(4), row(2) + by_second(2) / 3, 'u of the first by the second load')
        call compare(row(4), row(3) + by_first(3) / 3, 'u of the second by the first load')
      end do
    end do

  contains

    ! Rounding of terms near 1, over the step, is the limit.
    subroutine compare(found, expected, what)
      real(real64), intent(in) :: found, expected
      character(*), intent(in) :: what
      character(60) :: where_it_is

      write (where_it_is, '(a, 3es9.2)') ' at', r(i), first, second
      call check(found, expected, 1.0e-6_real64 * max(1.0_real64, abs(found)) + &
                 5.0e-15_real64 / step, what // where_it_is)
    end subroutine compare

  end subroutine derivatives

end module asperity_mutual_suite
