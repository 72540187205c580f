#ifndef NUMBER
!> The original program, SECTION I to V: the one text of the algorithm.
!>
!> The modules that include this file name the number type (NUMBER) and import the few functions in
!> which the arithmetics differ. The order of operations is the original's: printed digits depend
!> on it. Names are the original's, in lower case. "Fault n" refers to docs/theory/faults.md,
!> "Deviation x" to reference_output/faults/listing_port_scan.md.
!>
!> Without NUMBER this file is an empty module. fpm sees a change of a source file, not of an
!> included text: each module that includes this file uses this module and is compiled anew.
module asperity_sections
  use asperity_section_iv, only:
  use asperity_sections_i_to_iii, only:
  implicit none
end module asperity_sections
#else
  implicit none
  private

  public :: run_original

  integer, parameter :: list_places = 37   ! DIMENSION of SEPMIN, MNU, MNL, XSU, YSU, ZSU
  integer, parameter :: lower_places = 75  ! DIMENSION of XSL, YSL, ZSL

  ! The state of the program from one section to the next.
  type :: program_state
    ! Section I
    NUMBER :: half, c1p5, c3p1416  ! literals of the listing that are no integers
    NUMBER :: cfl, cfp, xuslop, yuslop, xlslop, ylslop, wlimit, dxdisp, dydisp, dapprx
    NUMBER :: difamx, difamn, difcmx, difcmn, tlodmx, tlodmn, tarmx, tarmn, apprmx, apprmn
    NUMBER :: slopmx, slopmn, cp, sumlod, sumar, sumapp, sumpos, sumdfa, sumdfc, sumslo
    integer :: ptmx, ptmn, isumpt, napmx
    ! Section II
    integer :: nu, nl
    NUMBER :: ru, rl, zumax, zlmax, eu, el, muu, mul, elimtu, elimtl, widthl
    NUMBER :: thetau, thetal, xdispl, ydispl
    NUMBER, allocatable :: xsu(:), ysu(:), zsu(:), xsl(:), ysl(:), zsl(:)
    ! Section III
    NUMBER :: q, ep, r, appr, ofstmx
    ! Section IV
    NUMBER, allocatable :: sepmin(:)
    integer, allocatable :: mnu(:), mnl(:)
    NUMBER :: dappr, tarea, tareap, tload, duma
    integer :: nctpt
    logical :: flag
    ! Not in the original: at how many positions a fault came to bear
    integer :: ran_out = 0, list_full = 0
  end type program_state

contains

  !> Runs the original program on a deck.
  !>
  !> `failure` is allocated, with the reason, where the original read past its arrays or took a
  !> root or power of a negative number: nothing it printed from there on had a meaning.
  subroutine run_original(deck, request, records, failure)
    type(card_deck), intent(in) :: deck                    !! the checked cards
    type(original_request), intent(in) :: request          !! what to keep
    type(original_records), intent(out) :: records         !! what it computes
    character(len=:), allocatable, intent(out) :: failure  !! why it had to stop
    type(program_state) :: s
    integer :: m

    call section_i(s, request)
    call section_ii(s, deck, records)
    call section_iii(s)
    do m = 1, original_positions
      call section_iv_a(s)
      call section_iv_b(s, m, failure)
      if (allocated(failure)) return
      call section_iv_c(s, m, records)
      call section_iv_d(s, m, request%keep_contacts(m), records, failure)
      if (allocated(failure)) return
      call section_iv_e(s, records%positions(m))
    end do
    call section_v(s, records)
    records%is_complete = .true.
  end subroutine run_original

#include "sections_i_to_iii.F90"
#include "section_iv.F90"

  ! SECTION V: averages; Table VI.
  subroutine section_v(s, records)
    type(program_state), intent(in) :: s
    type(original_records), intent(inout) :: records
    integer :: ptav

    ptav = cut_to_integer(whole_number(s%isumpt) / s%sumpos)
    records%variance(total_load_row, :) = &
      table_row(s%tlodmx, s%tlodmn, s%sumlod / s%sumpos)
    records%variance(total_area_row, :) = &
      table_row(s%tarmx, s%tarmn, s%sumar / s%sumpos)
    records%variance(points_row, :) = real([s%ptmx, s%ptmn, ptav], real64)
    ! Fault 15: the average is cut.
    records%variance(approach_row, :) = &
      table_row(s%apprmx, s%apprmn, s%sumapp / s%sumpos)
    records%variance(slope_row, :) = &
      table_row(s%slopmx, s%slopmn, quotient(s%sumslo, s%cp))
    ! Fault 1: a sum over positions divided by a count of contacts.
    records%variance(total_difference_row, :) = &
      table_row(s%difamx, s%difamn, quotient(s%sumdfa, s%cp))
    records%variance(individual_difference_row, :) = &
      table_row(s%difcmx, s%difcmn, quotient(s%sumdfc, s%cp))
    ! Fault 14: without a contact over the limit the start values are left.
    if (s%ran_out > 0) call records%notes%add('note: at ' // decimal_text(s%ran_out) // &
      ' positions the approaches ran out before a contact reached WLIMIT (fault 5)')
    if (s%list_full > 0) call records%notes%add('note: at ' // decimal_text(s%list_full) // &
      ' positions all places of the list of least separations are in contact; any further ' // &
      'contact is lost (fault 5)')
    if (.not. s%cp > whole_number(0)) call records%notes%add( &
      'note: no contact reached WLIMIT at any position: Table VI has no slopes (fault 5)')
  end subroutine section_v

  ! Three numbers of a row of Table VI.
  function table_row(maximum, minimum, average) result(row)
    NUMBER, intent(in) :: maximum, minimum, average
    real(real64) :: row(3)

    row = [to_real64(maximum), to_real64(minimum), to_real64(average)]
  end function table_row

  ! Distance in plan of two asperity centres, cm.
  elemental function plan_distance(s, j, k) result(dist)
    type(program_state), intent(in) :: s
    integer, intent(in) :: j, k
    NUMBER :: dist

    dist = sqrt((s%xsu(j) - s%xsl(k)) * (s%xsu(j) - s%xsl(k)) + &
                (s%ysu(j) - s%ysl(k)) * (s%ysu(j) - s%ysl(k)))
  end function plan_distance

  ! Deviation k: a quotient with the machine's way on after a division by zero: 0/0 is 0, else a
  ! number too large for any printed field.
  elemental function quotient(dividend, divisor) result(ratio)
    NUMBER, intent(in) :: dividend, divisor
    NUMBER :: ratio

    if (divisor > whole_number(0)) then
      ratio = dividend / divisor
    else if (dividend > whole_number(0)) then
      ratio = whole_number(10**9) * whole_number(10**9) * whole_number(10**9)
    else
      ratio = whole_number(0)
    end if
  end function quotient

  ! The constant digits * 10**exponent as the machine's compiler stored it.
  elemental function constant(digits, exponent) result(number)
    integer, intent(in) :: digits, exponent
    NUMBER :: number

    number = decimal_number(decimal_value(int(digits, int64), exponent))
  end function constant

  ! Start of a message that names a position.
  pure function place(m) result(text)
    integer, intent(in) :: m
    character(len=:), allocatable :: text

    text = 'position ' // decimal_text(m) // ': '
  end function place

  ! Two asperities in a message.
  pure function pair(j, k) result(text)
    integer, intent(in) :: j, k
    character(len=:), allocatable :: text

    text = decimal_text(j) // ' (upper) and ' // decimal_text(k) // ' (lower)'
  end function pair
#endif
