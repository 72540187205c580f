!> Tests of the law of adhesion: slope, estimate, joints of the theories.
!>
!> Truths are closed forms. Loads, contact radii and pressures of the curves
!> are compared with mpmath in test/effects/test_adhesion.py.
module asperity_adhesion_suite
  use asperity_adhesion, only: new_adhesion
  use asperity_adhesion_law, only: adhering_contact, adheres_at, adhesion_law, adhesion_numbers, &
                                   answer_along_centres, central_answer, model_dmt, model_hertz, &
                                   model_jkr, model_maugis, new_adhering_contact, new_adhesion_law
  use asperity_contact_effect, only: contact_effect, effect_outcome
  use asperity_contact_law, only: contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: contact_state, start_state
  use asperity_effect_helpers, only: act, pair_of, values_of
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_scene_values, only: effect_on, scene
  use asperity_testing, only: check, run_test
  implicit none
  private

  public :: run_adhesion

  real(real64), parameter :: pi = acos(-1.0_real64)
  ! The contact of the tests: E, R, w.
  real(real64), parameter :: modulus = 1.5_real64, radius = 0.5_real64, work = 0.01_real64
  ! Some units of the last place, and what the slope of a curve makes of those of its argument.
  real(real64), parameter :: tolerance = 2.0e-13_real64

contains

  !> Runs the tests.
  subroutine run_adhesion
    call run_test('work of adhesion from 1e-50 to 1e-300 is nearly Hertz', little_work)
    call run_test('the stiffness is the slope of the vertical load', slopes)
    call run_test('the estimate is above the truth', estimates)
    call run_test('Maugis: nothing jumps where the contact circle is gone', maugis_gap)
    call run_test('Maugis: one turn at most on each curve', maugis_turns)
    call run_test('theories meet at the borders of the Tabor parameter', borders)
  end subroutine run_adhesion

  subroutine little_work
    type(contact_pairs) :: pairs
    type(adhesion_law) :: law
    type(hertz_law) :: hertz
    type(contact_response) :: answer, truth
    real(real64) :: p
    integer :: i, k

    hertz%modulus = modulus
    pairs = some_pairs(1, 0.7_real64)
    do k = 1, 6
      call new_adhesion_law(adhesion_numbers(modulus, 10.0_real64**(-50 * k), 1.0e-290_real64), &
                            pairs, law)
      do i = -12, 0
        p = 0.3_real64 * 10.0_real64**i
        call law%respond(pairs%list(1), 1, p, answer)
        call hertz%respond(pairs%list(1), 1, p, truth)
        call check(all(abs(values_of(answer) - values_of(truth)) <= 5.0e-15_real64 * &
                              abs(values_of(truth))), 'little work')
      end do
    end do
  end subroutine little_work

  subroutine slopes
    type(contact_pairs) :: pairs
    type(adhesion_law) :: law
    type(contact_response) :: middle, above, below
    real(real64) :: p
    integer :: i, k
    real(real64), parameter :: tabor(4) = [10.0_real64, 1.0_real64, 0.3_real64, 0.05_real64]
    real(real64), parameter :: step = 1.0e-6_real64

    pairs = some_pairs(1, 0.7_real64)
    do k = 1, size(tabor)
      call new_adhesion_law(numbers_of(tabor(k)), pairs, law)
      law%adhered = .true.
      do i = -2, 10
        p = 0.01_real64 * real(i, real64) + 0.001_real64
        call law%respond(pairs%list(1), 1, p, middle)
        call law%respond(pairs%list(1), 1, p + step, above)
        call law%respond(pairs%list(1), 1, p - step, below)
        call check(middle%stiffness, &
                   (above%vertical_load - below%vertical_load) / (2.0_real64 * step), &
                   1.0e-7_real64, 'slope')
        ! The overlap as a plain difference, and the cosine.
        call check(middle%overlap, 1.0_real64 * pairs%list(1)%s - &
                   sqrt(pairs%list(1)%d**2 + (pairs%list(1)%zc - p)**2), tolerance, 'overlap')
        call check(middle%vertical_load, middle%load * (pairs%list(1)%zc - p) / &
                   (pairs%list(1)%s - middle%overlap), tolerance, 'vertical load')
      end do
    end do
  end subroutine slopes

  subroutine estimates
    class(contact_effect), allocatable :: effect
    type(contact_pairs) :: pairs
    type(contact_state) :: state
    type(effect_outcome) :: outcome
    real(real64) :: share, before, after, area, change
    integer :: i, k
    real(real64), parameter :: tabor(5) = &
      [10.0_real64, 3.0_real64, 1.0_real64, 0.3_real64, 0.05_real64]

    pairs = some_pairs(4, 0.7_real64)
    do k = 1, size(tabor)
      call adhesion_of(work, distance_of(tabor(k)), effect)
      call effect%begin(pairs)
      do i = 1, 10
        call start_state(pairs, hertz_law(modulus=modulus), 0.02_real64 * i, state)
        share = effect%estimate(pairs, state)
        before = sum(state%answers%vertical_load)
        area = sum(state%answers%contact_radius**2)
        call act(effect, pairs, state, outcome)
        ! Relative to the load and the area with adhesion, which the tolerance bounds.
        after = sum(state%answers%vertical_load)
        change = max((before - after) / max(after, 0.5_real64 * before), &
                     1.0_real64 - area / sum(state%answers%contact_radius**2))
        call check(change > 0.3_real64 * share .and. &
                   change <= share * (1.0_real64 + 1.0e-14_real64), 'change and estimate')
      end do
    end do
    call adhesion_of(0.0_real64, 1.0_real64, effect)
    call start_state(pairs, hertz_law(modulus=modulus), 0.1_real64, state)
    call check(.not. effect%estimate(pairs, state) > 0.0_real64, 'none without work')
  end subroutine estimates

  subroutine maugis_gap
    type(adhering_contact) :: contact
    type(central_answer) :: above, below
    real(real64) :: touching
    integer :: i
    real(real64), parameter :: tabor(3) = [0.101_real64, 0.3_real64, 0.6_real64]

    do i = 1, size(tabor)
      contact = contact_of(tabor(i))
      touching = contact%snap_off * (contact%curve%touching / contact%curve%snap_off)
      above = answer_of(contact, touching * (1.0_real64 - 1.0e-9_real64))
      below = answer_of(contact, touching * (1.0_real64 + 1.0e-9_real64))
      call check(above%contact_radius > 0.0_real64 .and. .not. below%contact_radius > &
                 0.0_real64, 'a contact circle above only')
      call check(above%load, below%load, 1.0e-7_real64 * abs(below%load), 'load')
      call check(above%stiffness, below%stiffness, 1.0e-3_real64 * abs(below%stiffness), &
                 'stiffness')
    end do
  end subroutine maugis_gap

  ! The load of a curve falls and rises once, and the curve ends where its slope is endless.
  subroutine maugis_turns
    type(adhering_contact) :: contact
    type(central_answer) :: answer
    real(real64) :: before, share
    integer :: i, k, turns
    integer, parameter :: steps = 400

    do i = 0, 60
      contact = contact_of(0.1000001_real64 * 49.9999_real64**(real(i, real64) / 60.0_real64))
      call check(contact%snap_off < contact%snap_in, 'it snaps off later than in')
      turns = 0
      before = 0.0_real64
      do k = steps, 0, -1
        share = real(k, real64) / real(steps, real64)
        answer = answer_of(contact, contact%snap_off + share**2 * (0.1_real64 - contact%snap_off))
        if (answer%stiffness < 0.0_real64 .and. before > 0.0_real64) turns = turns + 1
        if (answer%stiffness > 0.0_real64 .and. before < 0.0_real64) turns = turns + 10
        before = answer%stiffness
      end do
      call check(turns, 1, 'times the load turns')
      call check(abs(answer%stiffness) > 1.0e3_real64, 'steep where it ends')
    end do
  end subroutine maugis_turns

  ! At the borders, where the theory changes, the largest pull does by 0.32 % and by 3.0 %.
  subroutine borders
    type(adhering_contact) :: above, below
    real(real64), parameter :: hair = 1.0e-9_real64

    above = contact_of(5.0_real64 * (1.0_real64 + hair))
    below = contact_of(5.0_real64 * (1.0_real64 - hair))
    call check(above%model, model_jkr, 'above 5')
    call check(below%model, model_maugis, 'below 5')
    call check(below%pull_off, above%pull_off, 0.0033_real64 * above%pull_off, 'pull at 5')
    call check(below%snap_off, above%snap_off, 0.01_real64 * abs(above%snap_off), 'snap-off at 5')
    above = contact_of(0.1_real64 * (1.0_real64 + hair))
    below = contact_of(0.1_real64 * (1.0_real64 - hair))
    call check(above%model, model_maugis, 'above 0.1')
    call check(below%model, model_dmt, 'below 0.1')
    call check(above%pull_off, below%pull_off, 0.031_real64 * below%pull_off, 'pull at 0.1')
    call check(above%snap_off, below%snap_off, 0.001_real64 * abs(below%snap_off), &
               'snap-off at 0.1')
    above = contact_with(0.0_real64, 1.0_real64)
    call check(above%model, model_hertz, 'no work')
    call check(.not. adheres_at(above, 1.0_real64, .true.), 'nothing adheres without work')
  end subroutine borders

  ! Adhesion as a scene names it.
  subroutine adhesion_of(work, distance, effect)
    real(real64), intent(in) :: work, distance
    class(contact_effect), allocatable, intent(out) :: effect
    type(scene) :: scene_in

    call scene_in%effects%call_for('adhesion', effect_on)
    call scene_in%effects%set('work_of_adhesion', work)
    call scene_in%effects%set('equilibrium_distance', distance)
    call new_adhesion(scene_in, effect)
  end subroutine adhesion_of

  ! Pairs that all touch at once, with the radius and modulus of the cases.
  function some_pairs(number, d) result(pairs)
    integer, intent(in) :: number
    real(real64), intent(in) :: d
    type(contact_pairs) :: pairs

    pairs%modulus = modulus
    allocate (pairs%list(number))
    pairs%list = pair_of(2.0_real64 * radius, 2.0_real64 * radius, d)
  end function some_pairs

  ! The equilibrium distance at which the contact of the cases has a Tabor parameter.
  pure real(real64) function distance_of(tabor)
    real(real64), intent(in) :: tabor

    distance_of = ((work / modulus)**2 * radius)**(1.0_real64 / 3.0_real64) / tabor
  end function distance_of

  ! The material at which the contact of the cases has a Tabor parameter.
  pure function numbers_of(tabor) result(numbers)
    real(real64), intent(in) :: tabor
    type(adhesion_numbers) :: numbers

    numbers = adhesion_numbers(modulus, work, distance_of(tabor))
  end function numbers_of

  ! The contact of the cases with a Tabor parameter.
  function contact_of(tabor) result(contact)
    real(real64), intent(in) :: tabor
    type(adhering_contact) :: contact

    contact = contact_with(work, distance_of(tabor))
  end function contact_of

  ! The contact of the cases with other numbers of adhesion.
  function contact_with(adhesion, distance) result(contact)
    real(real64), intent(in) :: adhesion, distance
    type(adhering_contact) :: contact

    call new_adhering_contact(adhesion_numbers(modulus, adhesion, distance), radius, contact)
  end function contact_with

  ! What a contact answers along its line of centres.
  function answer_of(contact, overlap) result(answer)
    type(adhering_contact), intent(in) :: contact
    real(real64), intent(in) :: overlap
    type(central_answer) :: answer

    ! The distance matters to the contact alone.
    call answer_along_centres(adhesion_numbers(modulus, work, 1.0_real64), contact, overlap, answer)
  end function answer_of

end module asperity_adhesion_suite
