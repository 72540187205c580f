!> Tests of text that is shown on a terminal: which bytes of UTF-8 (RFC 3629) are kept, and whether
!> numbers of any size have room; names of units by powers; progress in words.
module asperity_printable_suite
  use, intrinsic :: iso_fortran_env, only: real64
  use asperity_printable, only: printable_text
  use asperity_problems, only: real_text
  use asperity_progress, only: progress_text
  use asperity_scene_values, only: scene
  use asperity_testing, only: check, has_failed, run_test
  use asperity_unit_names, only: is_length, is_moment, is_number, is_pressure, &
                                 powers_of, unit_of, unit_powers
  implicit none
  private

  public :: run_printable

  ! Letters at the ends of what two, three and four bytes hold, and some between.
  integer, parameter :: letters(14) = [161, 233, 1417, 2047, 2048, 2309, 2661, 8364, 55295, 64256, &
                                       65536, 68096, 85196, 128512]

contains

  !> Runs the tests.
  subroutine run_printable
    call run_test('letters of two to four bytes are kept', test_letters)
    call run_test('a letter in more bytes than it needs is not kept', test_too_long)
    call run_test('broken letters are not kept, those beside them are', test_broken)
    call run_test('a number of any size has room in any form', test_sizes)
    call run_test('a unit follows from powers, or is a word', test_units)
    call run_test('progress in words', test_progress)
  end subroutine run_printable

  subroutine test_progress
    call check(progress_text('positions', 50, 100, 0, 2.0_real64), &
               '50 of 100 positions, 25 a second, 2 s left', 'from the beginning')
    ! Half of it was done before: 25 in 2.5 s.
    call check(progress_text('positions', 75, 100, 50, 2.5_real64), &
               '75 of 100 positions, 10 a second, 3 s left', 'continued')
    call check(progress_text('surfaces', 3, 1003, 0, 90.0_real64), &
               '3 of 1003 surfaces, 2 a minute, 9 h left', 'hours')
  end subroutine test_progress

  subroutine test_units
    type(scene) :: named, bare

    named%units = [character(len=16) :: 'mm', 'lb']
    call check(unit_of(named, is_pressure), 'lb/mm2', 'pressure')
    call check(unit_of(named, is_moment), 'lb mm', 'moment')
    call check(unit_of(named, powers_of([0, -1])), '1/mm', 'curvature')
    call check(unit_of(named, powers_of([1, 0])), 'lb/mm2', 'power of the modulus')
    call check(unit_of(named, unit_powers(word='S')), 'S', 'siemens')
    call check(unit_of(named, is_number), '', 'number')
    call check(unit_of(bare, is_length), '', 'no names')
    call check(unit_of(bare, unit_powers(word='S')), 'S', 'siemens without names')
    named%units(2) = 'N'
    call check(unit_of(named, is_pressure), 'MPa', 'named pressure')
  end subroutine test_units

  subroutine test_letters
    character(len=:), allocatable :: text
    integer :: i

    do i = 1, size(letters)
      text = 'a' // encoded(letters(i), bytes_of(letters(i))) // 'z'
      call check(printable_text(text), text, 'letter of its own length')
    end do
  end subroutine test_letters

  subroutine test_too_long
    character(len=:), allocatable :: text
    integer :: bytes, i

    do i = 1, size(letters)
      do bytes = bytes_of(letters(i)) + 1, 4
        text = 'a' // encoded(letters(i), bytes) // 'z'
        call check(printable_text(text), 'a' // repeat('?', bytes) // 'z', 'longer than needed')
      end do
    end do
    call check(printable_text(encoded(127, 2)), '??', '127 in two bytes')
  end subroutine test_too_long

  ! The text reads back as the number, to half a unit of the digits that the form has at least.
  subroutine test_sizes
    character(len=*), parameter :: forms(14) = [character(len=11) :: 'es7.1e2', 'es8.1e2', &
      'es9.1e3', 'es10.3e2', 'es16.6e3', 'g10.3', 'g12.3', 'g15.7', 'sp, es8.1e2', 'f4.2', &
      'f6.3', 'f7.0', 'f9.1', 'f12.2']
    character(len=:), allocatable :: text
    real(real64) :: back, value
    integer :: i, power, sign

    call check(real_text(1.25_real64, 'es7.1e2'), '1.2E+00', 'a form with room')
    call check(real_text(1.5e-120_real64, 'es7.1e2'), '1.5E-120', 'three digits')
    do i = 1, size(forms)
      do power = -306, 307
        do sign = -1, 1, 2
          value = sign * 9.5_real64 * 10.0_real64**power
          text = real_text(value, trim(forms(i)))
          call check(scan(text, '*'), 0, 'no stars: ' // trim(forms(i)) // ' ' // text)
          if (has_failed()) return
          read (text, *) back
          call check(abs(back - value) <= 0.1_real64 * abs(value) .or. &
                     (forms(i)(1:1) == 'f' .and. abs(back - value) <= 0.5_real64), &
                     'reads back: ' // trim(forms(i)) // ' ' // text)
          if (has_failed()) return
        end do
      end do
    end do
  end subroutine test_sizes

  subroutine test_broken
    character(len=:), allocatable :: euro

    euro = encoded(8364, 3)
    call check(printable_text(euro(:2)), '??', 'end of the text')
    call check(printable_text(euro(:2) // 'a'), '??a', 'a letter instead of the last byte')
    call check(printable_text(euro(2:) // euro), '??' // euro, 'begins within a letter')
    call check(printable_text(achar(27) // '[1m'), '?[1m', 'escape')
    call check(printable_text(encoded(8238, 3)), '???', 'turns the direction')
  end subroutine test_broken

  ! Bytes a letter needs, by the table of RFC 3629, section 3.
  pure integer function bytes_of(code)
    integer, intent(in) :: code

    bytes_of = merge(2, merge(3, 4, code <= int(z'FFFF')), code <= int(z'7FF'))
  end function bytes_of

  ! A letter in so many bytes: six bits in each but the first, the highest come first.
  pure function encoded(code, bytes) result(text)
    integer, intent(in) :: code, bytes
    character(len=bytes) :: text
    integer, parameter :: marks(2:4) = [int(z'C0'), int(z'E0'), int(z'F0')]
    integer :: i, rest

    rest = code
    do i = bytes, 2, -1
      text(i:i) = achar(128 + mod(rest, 64))
      rest = rest / 64
    end do
    text(1:1) = achar(marks(bytes) + rest)
  end function encoded

end module asperity_printable_suite
