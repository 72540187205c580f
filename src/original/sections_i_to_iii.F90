#ifndef NUMBER
!> SECTION I to III of the original program, a part of sections.F90. See there why a module is
!> empty.
module asperity_sections_i_to_iii
  implicit none
end module asperity_sections_i_to_iii
#else
  ! SECTION I: constants and start values.
  subroutine section_i(s, request)
    type(program_state), intent(out) :: s
    type(original_request), intent(in) :: request

    s%half = constant(5, -1)
    s%c1p5 = constant(15, -1)
    s%c3p1416 = constant(31416, -4)
    s%cfl = constant(254, -2)
    s%cfp = constant(6894, -4)
    s%xuslop = constant(400, -5)
    s%yuslop = constant(-58, -5)
    s%xlslop = constant(-67, -5)
    s%ylslop = constant(-45, -5)
    ! Fault 7: one measured load, whatever the deck's material and radius.
    s%wlimit = whole_number(65) * constant(98, -1) / constant(2205, -3)
    s%dxdisp = constant(10, -2)
    s%dydisp = whole_number(0)
    ! Deviation g: NAPMX = 25 and the step of 0.001 cm stand in the request; no run has others.
    s%napmx = request%napmx
    s%dapprx = decimal_number(request%approach_step)
    ! Fault 14: these start values are printed where no position passes them.
    s%difamx = whole_number(0)
    s%difamn = whole_number(100)
    s%difcmx = whole_number(0)
    s%difcmn = whole_number(100)
    s%tlodmx = whole_number(0)
    s%tlodmn = whole_number(10000)
    s%tarmx = whole_number(0)
    s%tarmn = whole_number(100)
    s%ptmx = 0
    s%ptmn = 100
    s%apprmx = whole_number(0)
    s%apprmn = whole_number(100)
    s%slopmx = whole_number(0)
    s%slopmn = whole_number(100)
    s%cp = whole_number(0)
    s%sumlod = whole_number(0)
    s%sumar = whole_number(0)
    s%sumapp = whole_number(0)
    s%sumpos = whole_number(0)
    s%sumdfa = whole_number(0)
    s%sumdfc = whole_number(0)
    s%sumslo = whole_number(0)
    s%isumpt = 0
  end subroutine section_i

  ! SECTION II: cards to centres in cm; Table V and Table III.
  subroutine section_ii(s, deck, records)
    type(program_state), intent(inout) :: s
    type(card_deck), intent(in) :: deck
    type(original_records), intent(inout) :: records
    NUMBER :: x, y, z
    integer :: i

    s%nu = deck%upper%number
    s%nl = deck%lower%number
    s%ru = decimal_number(deck%upper%radius)
    s%rl = decimal_number(deck%lower%radius)
    s%zumax = decimal_number(deck%upper%height_max)
    s%zlmax = decimal_number(deck%lower%height_max)
    s%eu = decimal_number(deck%upper%elastic_modulus)
    s%el = decimal_number(deck%lower%elastic_modulus)
    s%muu = decimal_number(deck%upper%poisson_ratio)
    s%mul = decimal_number(deck%lower%poisson_ratio)
    s%elimtu = decimal_number(deck%upper%stress_max)
    s%elimtl = decimal_number(deck%lower%stress_max)
    s%widthl = decimal_number(deck%lower_width)
    s%thetau = decimal_number(deck%upper%angle)
    s%thetal = decimal_number(deck%lower%angle)
    s%xdispl = decimal_number(deck%x_displacement)
    s%ydispl = decimal_number(deck%y_displacement)
    ! Deviation h: the arrays are as large as the models.
    if (s%nu > list_places) call note_places(records, 'NU', s%nu, 'XSU', list_places)
    if (s%nl > lower_places) call note_places(records, 'NL', s%nl, 'XSL', lower_places)
    allocate (s%xsu(s%nu), s%ysu(s%nu), s%zsu(s%nu), s%xsl(s%nl), s%ysl(s%nl), s%zsl(s%nl))
    do i = 1, s%nu
      x = decimal_number(deck%upper%x(i))
      y = decimal_number(deck%upper%y(i))
      z = decimal_number(deck%upper%z(i))
      ! Deviation j: sine and cosine are rounded correctly; the library's are not known.
      s%xsu(i) = x * cos(s%thetau) - y * sin(s%thetau)
      s%ysu(i) = x * sin(s%thetau) + y * cos(s%thetau)
      ! Deviation a: the scan reads `.5 *RU`; only `.5 + RU` gives the printed approaches.
      s%zsu(i) = s%half + s%ru - z + s%xsu(i) * s%xuslop + s%ysu(i) * s%yuslop
      s%xsu(i) = s%xsu(i) * s%cfl
      s%ysu(i) = s%ysu(i) * s%cfl
      s%zsu(i) = s%zsu(i) * s%cfl
    end do
    do i = 1, s%nl
      x = decimal_number(deck%lower%x(i))
      y = decimal_number(deck%lower%y(i))
      z = decimal_number(deck%lower%z(i))
      s%xsl(i) = x * cos(s%thetal) - y * sin(s%thetal)
      s%ysl(i) = x * sin(s%thetal) + y * cos(s%thetal)
      s%ysl(i) = s%widthl - s%ysl(i)
      s%zsl(i) = z - s%rl + s%xsl(i) * s%xlslop + s%ysl(i) * s%ylslop
      s%xsl(i) = s%xsl(i) * s%cfl
      s%ysl(i) = s%ysl(i) * s%cfl
      s%zsl(i) = s%zsl(i) * s%cfl
    end do
    ! Fault 11: these shift the printed displacement only.
    s%xdispl = s%xdispl * s%cfl
    s%ydispl = s%ydispl * s%cfl
    s%ru = s%ru * s%cfl
    s%rl = s%rl * s%cfl
    s%zumax = s%zumax * s%cfl
    s%zlmax = s%zlmax * s%cfl
    s%eu = s%eu * s%cfp
    s%el = s%el * s%cfp
    s%elimtu = s%elimtu * s%cfp
    s%elimtl = s%elimtl * s%cfp

    records%word_no = deck%word_no
    records%word_yes = deck%word_yes
    records%upper = model_table(deck%upper, s%ru, s%zumax, s%eu, s%muu, s%elimtu, s%thetau, s%cfl)
    records%lower = model_table(deck%lower, s%rl, s%zlmax, s%el, s%mul, s%elimtl, s%thetal, s%cfl)
  end subroutine section_ii

  ! Notes that a model has more asperities than the arrays of the listing.
  subroutine note_places(records, name, number, array, places)
    type(original_records), intent(inout) :: records
    character(len=*), intent(in) :: name, array
    integer, intent(in) :: number, places

    call records%notes%add('note: ' // name // ' is ' // decimal_text(number) // ', DIMENSION ' // &
      array // '(' // decimal_text(places) // '): the original wrote beyond its arrays; here ' // &
      'they are as large as the models (deviation h)')
  end subroutine note_places

  ! Table V and Table III of one model. Deviation b: the listing prints the centres; the thesis
  ! shows the mold positions in cm, y not mirrored, and the heights: those are printed.
  function model_table(cards, radius, height_max, modulus, ratio, stress, angle, cfl) result(model)
    type(model_cards), intent(in) :: cards
    NUMBER, intent(in) :: radius, height_max, modulus, ratio, stress, angle, cfl
    type(model_record) :: model
    integer :: i

    model%number = cards%number
    model%radius = to_real64(radius)
    model%height_max = to_real64(height_max)
    model%elastic_modulus = to_real64(modulus)
    model%poisson_ratio = to_real64(ratio)
    model%stress_max = to_real64(stress)
    model%angle = to_real64(angle)
    allocate (model%x(cards%number), model%y(cards%number), model%height(cards%number))
    do i = 1, cards%number
      model%x(i) = to_real64(decimal_number(cards%x(i)) * cfl)
      model%y(i) = to_real64(decimal_number(cards%y(i)) * cfl)
      model%height(i) = to_real64(decimal_number(cards%z(i)) * cfl)
    end do
  end function model_table

  ! SECTION III: combined quantities and the candidate distance.
  subroutine section_iii(s)
    type(program_state), intent(inout) :: s
    NUMBER :: one, zmax

    one = whole_number(1)
    s%q = s%ru / (s%ru + s%rl)
    s%ep = one / ((one - s%mul * s%mul) / s%el + (one - s%muu * s%muu) / s%eu)
    s%r = s%rl * s%ru / (s%ru + s%rl)
    s%appr = s%half
    s%appr = s%appr * s%cfl
    zmax = s%zlmax
    if (s%zumax >= zmax) zmax = s%zumax
    ! ELIMIT, the larger of the two stresses, stands here and is never used (fault 7).
    ! Fault 7: RU alone, and the stated heights, which asperities may exceed.
    s%ofstmx = whole_number(2) * sqrt(s%ru * zmax)

    ! The list has 37 places whatever NU is (fault 5). Below 37 the rest stays at 100 and does no
    ! harm; above, the original ran over its arrays. Deviation h: here the list grows with NU.
    allocate (s%sepmin(max(s%nu, list_places)))
    allocate (s%mnu(max(s%nu, list_places)), s%mnl(max(s%nu, list_places)))
  end subroutine section_iii
#endif
