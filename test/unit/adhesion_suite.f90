!> Tests of the law of adhesion in the solver: its slope, its work in cycles, many contacts at once,
!> units and estimate.
!>
!> Truths are closed forms, named where they stand, and balances of work.
module asperity_adhesion_suite
  use asperity_adhesion, only: new_adhesion
  use asperity_adhesion_cases, only: distance_of, modulus, near, numbers_of, pi, radius, work
  use asperity_adhesion_contact, only: adhering_contact, adhesion_numbers, answer_along_centres, &
                                       central_answer, new_adhering_contact
  use asperity_adhesion_law, only: adhesion_law, new_adhesion_law
  use asperity_contact_effect, only: contact_effect, effect_outcome
  use asperity_contact_law, only: contact_response
  use asperity_contact_pairs, only: contact_pairs
  use asperity_contact_state, only: contact_state, start_state, total_load
  use asperity_effect_helpers, only: act, pair_of, same, set_number, values_of
  use asperity_hertz_law, only: hertz_law
  use asperity_kinds, only: real64
  use asperity_scene_values, only: effect_on, scene
  use asperity_testing, only: check, error_type, new_unittest, unittest_type
  implicit none
  private

  public :: collect_adhesion

contains

  !> Lists the tests.
  subroutine collect_adhesion(suite)
    !> all tests
    type(unittest_type), allocatable, intent(out) :: suite(:)

    allocate (suite(0))
    suite = [ &
      new_unittest('no work of adhesion is Hertz bit for bit, little is Hertz nearly', no_work), &
      new_unittest('the stiffness is the slope of the vertical load', slopes), &
      new_unittest('a cycle without a snap returns its work', closed_cycles), &
      new_unittest('a cycle with snaps never returns more than it took', lossy_cycles), &
      new_unittest('many contacts snap in at once and off again, with memory', many_at_once), &
      new_unittest('units of the pairs and of the scene', units), &
      new_unittest('the estimate is above the truth', estimates)]
  end subroutine collect_adhesion

  subroutine no_work(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(adhesion_law) :: law
    type(hertz_law) :: hertz
    type(contact_response) :: answer, truth
    type(central_answer) :: central
    type(adhering_contact) :: contact
    real(real64) :: p
    integer :: i, k

    hertz%modulus = modulus
    pairs = some_pairs(1, 0.7_real64)
    do k = 0, 6
      ! None, then less and less: 1e-30 down to 1e-305.
      call new_adhesion_law(adhesion_numbers(modulus, merge(0.0_real64, 10.0_real64**(-50 * k), &
                                                            k == 0), 1.0e-290_real64), pairs, law)
      do i = -12, 0
        p = 0.3_real64 * 10.0_real64**i
        call law%respond(pairs%list(1), 1, p, answer)
        call hertz%respond(pairs%list(1), 1, p, truth)
        if (k == 0) then
          call check(error, same(answer, truth), 'bit for bit')
        else
          call check(error, all(abs(values_of(answer) - values_of(truth)) <= 5.0e-15_real64 * &
                                abs(values_of(truth))), 'little work')
        end if
      end do
    end do
    call new_adhering_contact(adhesion_numbers(1.0_real64, 1.0e-30_real64, 1.0e-290_real64), &
                              2.0_real64, contact)
    call answer_along_centres(adhesion_numbers(1.0_real64, 1.0e-30_real64, 1.0e-290_real64), &
                              contact, 0.125_real64, central)
    call near(error, central%load, 0.083333333333333333333_real64, 0.1_real64, 'w = 1e-30')
    call near(error, central%contact_radius, 0.50000000000000354491_real64, 0.005_real64, &
              'w = 1e-30: contact radius')
  end subroutine no_work

  subroutine slopes(error)
    type(error_type), allocatable, intent(out) :: error
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
        call check(error, middle%stiffness, &
                   (above%vertical_load - below%vertical_load) / (2.0_real64 * step), &
                   1.0e-7_real64, 'slope')
        ! The overlap as a plain difference, and the cosine.
        call near(error, middle%overlap, 1.0_real64 * pairs%list(1)%s - &
                  sqrt(pairs%list(1)%d**2 + (pairs%list(1)%zc - p)**2), 1.0_real64, 'overlap')
        call near(error, middle%vertical_load, middle%load * (pairs%list(1)%zc - p) / &
                  (pairs%list(1)%s - middle%overlap), 1.0_real64, 'vertical load')
      end do
    end do
  end subroutine slopes

  ! Down by one rule and up by another: what they differ by is their errors and the law's.
  subroutine closed_cycles(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(adhesion_law) :: law
    real(real64) :: down, up, low
    integer :: k
    real(real64), parameter :: tabor(4) = [10.0_real64, 1.0_real64, 0.3_real64, 0.05_real64]
    real(real64), parameter :: deep = 0.2_real64

    pairs = some_pairs(1, 0.7_real64)
    do k = 1, size(tabor)
      call new_adhesion_law(numbers_of(tabor(k)), pairs, law)
      law%adhered = .true.
      low = 0.0_real64
      if (k < 3) low = -0.01_real64
      down = work_between(law, pairs, low, deep, 60)
      up = work_between(law, pairs, deep, low, 83)
      call check(error, down > 0.0_real64, 'work is taken')
      call check(error, -up, down, 1.0e-10_real64 * down, 'work returned')
    end do
  end subroutine closed_cycles

  subroutine lossy_cycles(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pairs) :: pairs
    type(adhesion_law) :: law
    real(real64) :: taken, returned, loss, unit
    integer :: k
    real(real64), parameter :: tabor(5) = &
      [10.0_real64, 3.0_real64, 1.0_real64, 0.3_real64, 0.05_real64]
    real(real64), parameter :: deep = 0.2_real64

    pairs = some_pairs(1, 0.0_real64)
    do k = 1, size(tabor)
      call new_adhesion_law(numbers_of(tabor(k)), pairs, law)
      law%adhered = .false.
      taken = work_between(law, pairs, law%known(1)%snap_in, 0.0_real64, 400) + &
              work_between(law, pairs, 0.0_real64, deep, 400)
      law%adhered = .true.
      returned = -work_between(law, pairs, deep, 0.0_real64, 400) - &
                 work_between(law, pairs, 0.0_real64, law%known(1)%snap_in, 400) - &
                 work_between(law, pairs, law%known(1)%snap_in, law%known(1)%snap_off, 400)
      loss = taken - returned
      call check(error, loss > -1.0e-14_real64, 'no gain')
      if (k < 5) call check(error, loss > 1.0e-4_real64 * work * radius**2, 'a loss')
      ! Between the turn and first touch of the curve, with t**3 = 1/4 and 1:
      ! [8/15 t**10 - 4/3 t**7 + t**4/2] E L**5/R**2.
      unit = 2.0_real64 * pi * work * radius**2 / modulus
      unit = modulus * unit**(5.0_real64 / 3.0_real64) / radius**2
      if (k == 1) call check(error, loss, (0.3_real64 + 0.05_real64 * 0.25_real64**(1.0_real64 / &
                             3.0_real64)) * unit, 1.0e-9_real64 * unit, 'loss of JKR')
      if (k == 5) call check(error, abs(loss) < 1.0e-14_real64, 'DMT loses nothing')
    end do
  end subroutine lossy_cycles

  subroutine many_at_once(error)
    type(error_type), allocatable, intent(out) :: error
    class(contact_effect), allocatable :: effect
    type(contact_pairs) :: pairs
    type(contact_state) :: state
    type(effect_outcome) :: outcome
    real(real64) :: unit
    real(real64), parameter :: path(9) = [-0.01_real64, 0.0_real64, 0.05_real64, 0.0_real64, &
      -0.01_real64, -0.04_real64, -0.05_real64, -0.01_real64, 0.0_real64]
    integer, parameter :: many = 1000
    integer, parameter :: adhering(9) = [0, many, many, many, many, many, 0, 0, many]
    integer :: turn, i

    pairs = some_pairs(many, 0.0_real64)
    call adhesion_of(work, distance_of(10.0_real64), effect)
    unit = pi * work * radius
    do turn = 1, 2
      call effect%begin(pairs)
      do i = 1, size(path)
        call step_to(path(i))
        call check(error, nint(outcome%of_state(1)), adhering(i), 'adhering contacts')
        call check(error, count(outcome%of_contacts(:, 1) > 0.5_real64), adhering(i), 'column')
        call near(error, outcome%of_state(3), adhering(i) * 1.5_real64 * unit, many * unit, &
                  'sum of the largest pulls')
        if (i == 2 .or. i == 4) then
          call near(error, total_load(state), -many * 4.0_real64 / 3.0_real64 * unit, &
                    many * unit, 'load of all at first touch')
          call check(error, nint(outcome%of_state(2)), many, 'pulling contacts')
        end if
        if (i == 1 .or. i == 7 .or. i == 8) &
          call check(error, .not. abs(total_load(state)) > 0.0_real64, 'apart without load')
      end do
    end do

  contains

    subroutine step_to(closing)
      real(real64), intent(in) :: closing

      call start_state(pairs, hertz_law(modulus=modulus), closing, state)
      call act(effect, pairs, state, outcome)
      call effect%keep(pairs, state)
    end subroutine step_to

  end subroutine many_at_once

  ! The same contact in the units of the scene and in the solver's own.
  subroutine units(error)
    type(error_type), allocatable, intent(out) :: error
    class(contact_effect), allocatable :: effect
    type(contact_pairs) :: pairs
    type(contact_state) :: state
    type(effect_outcome) :: plain, scaled
    real(real64) :: load

    pairs = some_pairs(3, 0.7_real64)
    call adhesion_of(work, distance_of(1.0_real64), effect)
    call effect%begin(pairs)
    call start_state(pairs, hertz_law(modulus=modulus), 0.1_real64, state)
    call act(effect, pairs, state, plain)
    load = total_load(state)
    ! Modulus unit 16**3, length unit 16**-2.
    pairs%modulus_power = 3
    pairs%length_power = -2
    call adhesion_of(scale(work, 4), scale(distance_of(1.0_real64), -8), effect)
    call effect%begin(pairs)
    call start_state(pairs, hertz_law(modulus=modulus), 0.1_real64, state)
    call act(effect, pairs, state, scaled)
    call check(error, load < 100.0_real64 .and. .not. abs(total_load(state) - load) > 0.0_real64, &
               'load')
    call check(error, .not. any(abs(scaled%of_contacts - plain%of_contacts) > 0.0_real64), &
               'columns')
    call check(error, plain%of_contacts(1, 3), 1.0_real64, 1.0e-14_real64, 'Tabor parameter')
    call check(error, effect%contact_columns(2)%modulus_power == 1 .and. &
               effect%contact_columns(2)%length_power == 2, 'pull-off is a force')
  end subroutine units

  subroutine estimates(error)
    type(error_type), allocatable, intent(out) :: error
    class(contact_effect), allocatable :: effect
    type(contact_pairs) :: pairs
    type(contact_state) :: state
    type(effect_outcome) :: outcome
    real(real64) :: share, before, area, change
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
        change = max((before - sum(state%answers%vertical_load)) / before, &
                     sum(state%answers%contact_radius**2) / area - 1.0_real64)
        call check(error, change > 0.3_real64 * share .and. &
                   change <= share * (1.0_real64 + 1.0e-14_real64), 'change and estimate')
      end do
    end do
    call adhesion_of(0.0_real64, 1.0_real64, effect)
    call start_state(pairs, hertz_law(modulus=modulus), 0.1_real64, state)
    call check(error, .not. effect%estimate(pairs, state) > 0.0_real64, 'none without work')
  end subroutine estimates

  ! Work of the vertical load on the way from a penetration to another: Gauss' rule of three points
  ! on panels that are narrow near the start or end that is lower.
  function work_between(law, pairs, from, to, panels) result(total)
    type(adhesion_law), intent(in) :: law
    type(contact_pairs), intent(in) :: pairs
    real(real64), intent(in) :: from, to
    integer, intent(in) :: panels
    real(real64) :: total, t, low
    type(contact_response) :: response
    integer :: i, k
    real(real64), parameter :: node(3) = [-0.77459666924148337704_real64, 0.0_real64, &
                                          0.77459666924148337704_real64]
    real(real64), parameter :: weight(3) = [5.0_real64, 8.0_real64, 5.0_real64] / 18.0_real64

    low = min(from, to)
    total = 0.0_real64
    do i = 1, panels
      do k = 1, 3
        t = (real(i, real64) - 0.5_real64 + 0.5_real64 * node(k)) / real(panels, real64)
        call law%respond(pairs%list(1), 1, low + abs(to - from) * t**2, response)
        total = total + weight(k) * 2.0_real64 * t * response%vertical_load
      end do
    end do
    total = total * (to - from) / real(panels, real64)
  end function work_between

  ! Adhesion as a scene names it.
  subroutine adhesion_of(work, distance, effect)
    real(real64), intent(in) :: work, distance
    class(contact_effect), allocatable, intent(out) :: effect
    type(scene) :: scene_in

    call scene_in%effects%call_for('adhesion', effect_on)
    call set_number(scene_in, 'work_of_adhesion', work)
    call set_number(scene_in, 'equilibrium_distance', distance)
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

end module asperity_adhesion_suite
