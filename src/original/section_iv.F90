#ifndef NUMBER
!> SECTION IV of the original program, a part of sections.F90. See there why a module is empty.
module asperity_section_iv
  implicit none
end module asperity_section_iv
#else
  ! SECTION IV A: empties the list, moves the upper model.
  subroutine section_iv_a(s)
    type(program_state), intent(inout) :: s
    integer :: i

    s%mnu = 0
    s%mnl = 0
    ! Fault 6: a gap of 100 cm stands for none.
    s%sepmin = whole_number(100)
    ! Fault 2: displacements are sums of rounded steps.
    ! Fault 5, deviation h: the original's loop ran to 37, whatever NU.
    do i = 1, s%nu
      s%xsu(i) = s%xsu(i) + s%dxdisp
      s%ysu(i) = s%ysu(i) + s%dydisp
    end do
    s%xdispl = s%xdispl + s%dxdisp
    s%ydispl = s%ydispl + s%dydisp
  end subroutine section_iv_a

  ! SECTION IV B: the NU least separations in ascending order, with both index numbers.
  subroutine section_iv_b(s, m, failure)
    type(program_state), intent(inout) :: s
    integer, intent(in) :: m
    character(len=:), allocatable, intent(inout) :: failure
    NUMBER :: dist, du, dl, zu, zl, sep, ru2, rl2, zero
    integer :: j, k, l, lx

    zero = whole_number(0)
    do j = 1, s%nu
      do k = 1, s%nl
        dist = plan_distance(s, j, k)
        if (dist >= s%ofstmx) cycle
        ru2 = s%ru * s%ru - (dist * s%q) * (dist * s%q)
        rl2 = s%rl * s%rl - (dist * (whole_number(1) - s%q)) * (dist * (whole_number(1) - s%q))
        ! Deviation i, as at each failure below: the port stops where the original went astray.
        if (ru2 < zero .or. rl2 < zero) then
          failure = place(m) // 'asperities ' // pair(j, k) // ' are within OFSTMX but ' // &
                    'further apart than RU + RL: root of a negative number (fault 7)'
          return
        end if
        ! Deviation d: these four stand inside loop DO 210 in the listing, which changes none.
        du = sqrt(ru2)
        dl = sqrt(rl2)
        zu = s%zsu(j) - du
        zl = s%zsl(k) + dl
        sep = zu - zl
        do l = 1, s%nu
          if (.not. sep < s%sepmin(l)) cycle
          do lx = s%nu, l + 1, -1
            s%sepmin(lx) = s%sepmin(lx - 1)
            s%mnu(lx) = s%mnu(lx - 1)
            s%mnl(lx) = s%mnl(lx - 1)
          end do
          s%sepmin(l) = sep
          s%mnu(l) = j
          s%mnl(l) = k
          exit
        end do
      end do
    end do
    ! Fault 6: no candidate pair; SEPMIN(1) is still 100.
    if (s%mnu(1) == 0) &
      failure = place(m) // 'no pair of asperities is within OFSTMX and less than 100 cm ' // &
                'apart: the original ran on with separations of 100 and read past its arrays ' // &
                '(fault 6)'
  end subroutine section_iv_b

  ! SECTION IV C: the displacement for the headings, and the first decrement.
  ! Fault 9: the original prints headings and tables at positions 13, 55 and 56 only.
  ! Deviation e: J = MNU(1) and K = MNL(1) stand here, are not used, and are left out.
  ! Deviation f: every WRITE of SECTION IV, with its count of lines F2, stands in report.f90.
  subroutine section_iv_c(s, m, records)
    type(program_state), intent(inout) :: s
    integer, intent(in) :: m
    type(original_records), intent(inout) :: records

    records%last_heading = m
    s%dappr = s%sepmin(1)
    records%positions(m)%x_displacement = to_real64(s%xdispl)
    records%positions(m)%y_displacement = to_real64(s%ydispl)
    records%positions(m)%first_contact = records%contacts_used + 1
  end subroutine section_iv_c

  ! SECTION IV D: approaches until a load reaches WLIMIT.
  subroutine section_iv_d(s, m, keep, records, failure)
    type(program_state), intent(inout) :: s
    integer, intent(in) :: m
    logical, intent(in) :: keep
    type(original_records), intent(inout) :: records
    character(len=:), allocatable, intent(inout) :: failure
    integer :: nap

    s%flag = .false.
    if (keep) allocate (records%positions(m)%totals(3, s%napmx))
    ! Fault 4: the limit is looked for after it is passed. Fault 5: the approaches may run out.
    do nap = 1, s%napmx
      if (s%flag) exit
      call section_iv_d_1(s)
      call section_iv_d_2(s, m, nap, keep, records, failure)
      records%positions(m)%last_contact = records%contacts_used
      if (allocated(failure)) return
      records%positions(m)%steps = nap
      if (keep) records%positions(m)%totals(:, nap) = &
        [to_real64(s%tarea), to_real64(s%tareap), to_real64(s%tload)]
      call section_iv_d_3(s, m, nap, failure)
      if (allocated(failure)) return
    end do
    records%positions(m)%limit_reached = s%flag
    if (.not. s%flag) s%ran_out = s%ran_out + 1
    if (s%nctpt == s%nu .and. s%nl > 1) s%list_full = s%list_full + 1
  end subroutine section_iv_d

  ! SECTION IV D.1: lowers the upper model by the decrement.
  subroutine section_iv_d_1(s)
    type(program_state), intent(inout) :: s
    integer :: jj

    ! Fault 2: approach and heights carry their rounding to the next position.
    s%appr = s%appr - s%dappr
    do jj = 1, s%nu
      s%zsu(jj) = s%zsu(jj) - s%dappr
    end do
    s%nctpt = 0
    s%tarea = whole_number(0)
    s%tload = whole_number(0)
    s%tareap = whole_number(0)
  end subroutine section_iv_d_1

  ! SECTION IV D.2: all contacts at one approach. D.2.1 decides which pairs are in contact.
  subroutine section_iv_d_2(s, m, nap, keep, records, failure)
    type(program_state), intent(inout) :: s
    integer, intent(in) :: m, nap
    logical, intent(in) :: keep
    type(original_records), intent(inout) :: records
    character(len=:), allocatable, intent(inout) :: failure
    type(contact_record) :: contact
    NUMBER :: zero
    integer :: j, k, l

    zero = whole_number(0)
    do l = 1, s%nu
      k = s%mnl(l)
      j = s%mnu(l)
      s%sepmin(l) = s%sepmin(l) - s%dappr
      if (s%sepmin(l) > zero) cycle
      if (j == 0) then
        failure = place(m) // 'an empty place of the list of least separations came into ' // &
                  'contact: its 100 cm are used up (fault 6)'
        return
      end if
      contact = contact_record(position=m, step=nap, upper=j, lower=k)
      if (s%sepmin(l) < zero) then
        call section_iv_d_2_2(s, contact, failure)
        if (allocated(failure)) return
      else
        call section_iv_d_2_3(s, j, k, contact)
      end if
      if (keep) call append_contact(records, contact)
    end do
  end subroutine section_iv_d_2

  ! SECTION IV D.2.2: a contact that carries load.
  subroutine section_iv_d_2_2(s, contact, failure)
    type(program_state), intent(inout) :: s
    type(contact_record), intent(inout) :: contact
    character(len=:), allocatable, intent(inout) :: failure
    NUMBER :: dist, z, slope, w, xca, yca, carea, cload, ctavpr, ctmxpr, cf, careap, difca, one
    integer :: j, k

    one = whole_number(1)
    j = contact%upper
    k = contact%lower
    dist = plan_distance(s, j, k)
    z = s%zsu(j) - s%zsl(k)
    slope = dist / z
    ! Fault 3: a small difference of nearly equal numbers.
    w = s%rl + s%ru - sqrt(dist * dist + z * z)
    if (w < whole_number(0)) then
      failure = place(contact%position) // 'asperities ' // pair(j, k) // ' are in contact, ' // &
                'but rounding leaves them a negative overlap W: power of a negative number ' // &
                '(fault 3)'
      return
    end if
    ! Fault 10: Appendix 5 divides by Q; the listing multiplies, and is right.
    xca = s%xsu(j) + s%q * (s%xsl(k) - s%xsu(j))
    yca = s%ysu(j) + s%q * (s%ysl(k) - s%ysu(j))
    carea = s%c3p1416 * w * s%r
    ! Deviation j: the power is rounded correctly; so rounded, every printed load is met.
    cload = (whole_number(4) / whole_number(3)) * s%ep * sqrt(s%r) * three_halves_power(w)
    ctavpr = quotient(cload, carea)
    ctmxpr = s%c1p5 * ctavpr
    s%nctpt = s%nctpt + 1
    cf = one / sqrt(one + slope * slope)
    careap = cf * carea
    contact%limit_exceeded = cload >= s%wlimit
    if (contact%limit_exceeded) s%flag = .true.
    s%duma = s%appr
    s%tarea = s%tarea + carea
    s%tareap = s%tareap + careap
    ! Fault 8: forces normal to inclined contacts, not their vertical parts. Fault 12: contacts
    ! do not feel each other.
    s%tload = s%tload + cload
    contact%loaded = .true.
    contact%area_no = s%nctpt
    contact%approach = to_real64(s%duma)
    contact%x = to_real64(xca)
    contact%y = to_real64(yca)
    contact%area = to_real64(carea)
    contact%projected_area = to_real64(careap)
    contact%slope = to_real64(slope)
    contact%load = to_real64(cload)
    contact%average_pressure = to_real64(ctavpr)
    contact%maximum_pressure = to_real64(ctmxpr)
    ! Fault 13: contacts listed before the first one over the limit do not enter these.
    if (.not. s%flag) return
    if (slope > s%slopmx) s%slopmx = slope
    if (slope < s%slopmn) s%slopmn = slope
    difca = quotient(whole_number(100) * (carea - careap), carea)
    if (difca > s%difcmx) s%difcmx = difca
    if (difca < s%difcmn) s%difcmn = difca
    s%sumdfc = s%sumdfc + difca
    s%cp = s%cp + one
    s%sumslo = s%sumslo + slope
  end subroutine section_iv_d_2_2

  ! SECTION IV D.2.3: a contact that touches without load.
  subroutine section_iv_d_2_3(s, j, k, contact)
    type(program_state), intent(inout) :: s
    integer, intent(in) :: j, k
    type(contact_record), intent(inout) :: contact
    NUMBER :: z

    ! Fault 15: a contact without load counts as a point of Table VI.
    s%nctpt = s%nctpt + 1
    z = s%zsu(j) - s%zsl(k)
    s%duma = s%appr
    contact%area_no = s%nctpt
    contact%approach = to_real64(s%duma)
    contact%x = to_real64(s%xsu(j) + s%q * (s%xsl(k) - s%xsu(j)))
    contact%y = to_real64(s%ysu(j) + s%q * (s%ysl(k) - s%ysu(j)))
    contact%slope = to_real64(plan_distance(s, j, k) / z)
  end subroutine section_iv_d_2_3

  ! SECTION IV D.3: the next decrement.
  subroutine section_iv_d_3(s, m, nap, failure)
    type(program_state), intent(inout) :: s
    integer, intent(in) :: m, nap
    character(len=:), allocatable, intent(inout) :: failure

    if (s%nctpt + 1 > size(s%sepmin)) then
      ! The value is used only when another approach follows.
      if (.not. s%flag .and. nap < s%napmx) &
        failure = place(m) // 'all ' // decimal_text(s%nctpt) // ' places of the list of ' // &
                  'least separations are in contact: the original read past its end (fault 5)'
    else if (s%sepmin(s%nctpt + 1) < s%dapprx) then
      s%dappr = s%sepmin(s%nctpt + 1)
    else
      s%dappr = s%dapprx
    end if
  end subroutine section_iv_d_3

  ! SECTION IV E: maxima, minima and sums of the last approach.
  subroutine section_iv_e(s, position)
    type(program_state), intent(inout) :: s
    type(position_record), intent(inout) :: position
    NUMBER :: difa

    difa = quotient(whole_number(100) * (s%tarea - s%tareap), s%tarea)
    if (s%tload > s%tlodmx) s%tlodmx = s%tload
    if (s%tload < s%tlodmn) s%tlodmn = s%tload
    if (s%tarea > s%tarmx) s%tarmx = s%tarea
    if (s%tarea < s%tarmn) s%tarmn = s%tarea
    if (s%nctpt > s%ptmx) s%ptmx = s%nctpt
    if (s%nctpt < s%ptmn) s%ptmn = s%nctpt
    if (s%duma > s%apprmx) s%apprmx = s%duma
    if (s%duma < s%apprmn) s%apprmn = s%duma
    if (difa > s%difamx) s%difamx = difa
    if (difa < s%difamn) s%difamn = difa
    s%sumlod = s%sumlod + s%tload
    s%sumar = s%sumar + s%tarea
    s%sumapp = s%sumapp + s%duma
    s%sumpos = s%sumpos + whole_number(1)
    s%sumdfa = s%sumdfa + difa
    s%isumpt = s%isumpt + s%nctpt
    position%approach = to_real64(s%duma)
    position%load = to_real64(s%tload)
    position%area = to_real64(s%tarea)
    position%projected_area = to_real64(s%tareap)
    position%contacts = s%nctpt
  end subroutine section_iv_e
#endif
