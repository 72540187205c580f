!> Tests of the curves of one adhering contact: JKR, Maugis and DMT.
!>
!> The truth of the curves is test/truth/adhesion_truth.py, evaluated by mpmath with 40 digits
!> from the equations as the papers print them. Run that file to print the values again. The other
!> truths are closed forms, named where they stand.
module asperity_adhesion_curves_suite
  use asperity_adhesion_cases, only: answer_of, contact_at, contact_of, contact_with, distance_of, &
                                     modulus, near, pi, radius, work
  use asperity_adhesion_contact, only: adhering_contact, adheres_at, central_answer, model_dmt, &
                                       model_hertz, model_jkr, model_maugis
  use asperity_kinds, only: real64
  use asperity_testing, only: check, error_type, new_unittest, unittest_type
  implicit none
  private

  public :: collect_adhesion_curves

contains

  !> Lists the tests.
  subroutine collect_adhesion_curves(suite)
    !> all tests
    type(unittest_type), allocatable, intent(out) :: suite(:)

    allocate (suite(0))
    suite = [ &
      new_unittest('JKR: ten points of the curve, against mpmath', jkr_curve), &
      new_unittest('JKR: pull-off, snap-off, radius without load, touch', jkr_ends), &
      new_unittest('Maugis: curves of five Tabor parameters, against mpmath', maugis_curves), &
      new_unittest('Maugis: largest pull, against mpmath and a published fit', maugis_pulls), &
      new_unittest('Maugis: nothing jumps where the contact circle is gone', maugis_gap), &
      new_unittest('Maugis: one turn at most on each curve', maugis_turns), &
      new_unittest('DMT: pull-off, range, Hertz below it', dmt_curve), &
      new_unittest('theories meet at the borders of the Tabor parameter', borders)]
  end subroutine collect_adhesion_curves

  subroutine jkr_curve(error)
    type(error_type), allocatable, intent(out) :: error
    ! Overlap, contact radius, load, stiffness, pressure at the centre.
    real(real64) :: truth(5, 10)
    integer :: i

    truth(:, 1) = [-0.027_real64, 0.16903540352075452012_real64, -0.023351553915964497189_real64, &
                   -0.083749156193028658701_real64, 0.085151533615404865458_real64]
    truth(:, 2) = [-0.02_real64, 0.18416000349339451049_real64, -0.023541138951064554395_real64, &
                   0.023575283484702868721_real64, 0.12400658902252394372_real64]
    truth(:, 3) = [-0.01_real64, 0.20264907983714137893_real64, -0.022723709885300830023_real64, &
                   0.13407068124858213308_real64, 0.16995445217907585401_real64]
    truth(:, 4) = [0.0_real64, 0.21878096788957758768_real64, -0.020943951023931954923_real64, &
                   0.21878096788957758768_real64, 0.20892043496433301059_real64]
    truth(:, 5) = [0.005_real64, 0.22621008443105948329_real64, -0.019757642234178065586_real64, &
                   0.25520895945221946408_real64, 0.22656828950723458321_real64]
    truth(:, 6) = [0.01_real64, 0.23329710329099633907_real64, -0.018396660999081341682_real64, &
                   0.28875074667470952176_real64, 0.24324827936619120359_real64]
    truth(:, 7) = [0.03_real64, 0.258995655627600722_real64, -0.011436600473775805405_real64, &
                   0.40272492781549448019_real64, 0.30262836715296035773_real64]
    truth(:, 8) = [0.1_real64, 0.32979962714580429241_real64, 0.027196732287186631898_real64, &
                   0.68036743253805828884_real64, 0.45970966276716205252_real64]
    truth(:, 9) = [1.0_real64, 0.76790244396041731032_real64, 1.3980828693888843715_real64, &
                   2.1216174419139764674_real64, 1.3550707970920497902_real64]
    truth(:, 10) = [1.0e6_real64, 707.10870534933909336_real64, 1414213562.3573870713_real64, &
                   2121.3203435596425839_real64, 1350.4744742406590907_real64]
    do i = 1, size(truth, 2)
      call compare(error, contact_of(10.0_real64), truth(:, i), 'JKR')
    end do
  end subroutine jkr_curve

  ! Closed forms: Johnson, Kendall and Roberts 1971; Johnson 1985, section 5.5. a0**3 is
  ! 6 pi w R**2/K with K = 4/3 E.
  subroutine jkr_ends(error)
    type(error_type), allocatable, intent(out) :: error
    type(adhering_contact) :: contact
    type(central_answer) :: answer
    real(real64) :: unit, low, high, middle, least
    integer :: i

    contact = contact_of(10.0_real64)
    unit = pi * work * radius
    call check(error, contact%model, model_jkr, 'theory')
    call near(error, contact%pull_off, 1.5_real64 * unit, unit, 'pull-off')
    call near(error, contact%snap_off, -0.04522969653889891548_real64, 0.05_real64, 'snap-off')
    call check(error, .not. contact%snap_in < 0.0_real64, 'no range')
    ! The load's error at the turn is the root of that of the overlap.
    answer = answer_of(contact, contact%snap_off)
    call check(error, answer%load, -5.0_real64 / 6.0_real64 * unit, 1.0e-7_real64 * unit, &
               'load at the snap')
    answer = answer_of(contact, 0.0_real64)
    call near(error, answer%load, -4.0_real64 / 3.0_real64 * unit, unit, 'load at first touch')
    low = 0.0_real64
    high = 1.0_real64
    do i = 1, 60
      middle = 0.5_real64 * (low + high)
      answer = answer_of(contact, middle)
      if (answer%load > 0.0_real64) then
        high = middle
      else
        low = middle
      end if
    end do
    call near(error, answer%contact_radius**3, &
              6.0_real64 * pi * work * radius**2 / (4.0_real64 / 3.0_real64 * modulus), &
              answer%contact_radius**3, 'contact radius without load')
    ! The largest pull is met on the way.
    least = 0.0_real64
    do i = 0, 20000
      answer = answer_of(contact, contact%snap_off * real(i, real64) / 20000.0_real64)
      least = min(least, answer%load)
    end do
    call check(error, least, -contact%pull_off, 1.0e-7_real64 * unit, 'largest pull on the way')
  end subroutine jkr_ends

  subroutine maugis_curves(error)
    type(error_type), allocatable, intent(out) :: error
    ! Distance z0, overlap, contact radius, load, stiffness, pressure at the centre.
    real(real64) :: truth(6, 27)
    integer :: i

    truth(:, 1) = [0.2811439406233091_real64, -0.01_real64, 0.087645319339594942837_real64, &
                   -0.029264052968689361821_real64, 0.16880129828603536028_real64, &
                   0.1347554209671111711_real64]
    truth(:, 2) = [0.2811439406233091_real64, 0.0_real64, 0.11301894418745708046_real64, &
                   -0.0271478110674316483_real64, 0.25088419695503407449_real64, &
                   0.18427210185490934149_real64]
    truth(:, 3) = [0.2811439406233091_real64, 0.01_real64, 0.13363561661833899325_real64, &
                   -0.024297765481068427758_real64, 0.31721014463590499834_real64, &
                   0.22447536551775766425_real64]
    truth(:, 4) = [0.2811439406233091_real64, 0.1_real64, 0.2519227935425131557_real64, &
                   0.022922741082947762021_real64, 0.6920000951935584623_real64, &
                   0.4545603303262830781_real64]
    truth(:, 5) = [0.2811439406233091_real64, 1000.0_real64, 22.361729163933366966_real64, &
                   44721.343818512278552_real64, 67.082039340666398434_real64, &
                   42.705757597368228967_real64]
    truth(:, 6) = [0.2811439406233091_real64, -0.06_real64, 0.0_real64, &
                   -0.026234175876231207144_real64, -0.11853347991413529296_real64, &
                   0.0_real64]
    truth(:, 7) = [0.09371483430391755_real64, -0.01_real64, 0.1292182172536884767_real64, &
                   -0.026475113427286352776_real64, 0.17550627743597694872_real64, &
                   0.16586460207400361665_real64]
    truth(:, 8) = [0.09371483430391755_real64, 0.0_real64, 0.14846649967968964576_real64, &
                   -0.02433788008301859375_real64, 0.24971541509695506694_real64, &
                   0.2058952861079027247_real64]
    truth(:, 9) = [0.09371483430391755_real64, 0.01_real64, 0.16538557177535765598_real64, &
                   -0.021516775249897961307_real64, 0.31303509339984383689_real64, &
                   0.24087578763744102594_real64]
    truth(:, 10) = [0.09371483430391755_real64, 0.1_real64, 0.27264663772234423054_real64, &
                   0.025211923526500780033_real64, 0.68723057986247686369_real64, &
                   0.45899873447438475646_real64]
    truth(:, 11) = [0.09371483430391755_real64, 1000.0_real64, 22.362838894705078077_real64, &
                   44721.343830569559907_real64, 67.082039332661898643_real64, &
                   42.705757601021506494_real64]
    truth(:, 12) = [0.09371483430391755_real64, -0.06_real64, 0.0_real64, &
                   -0.018109774071024285776_real64, -0.43150906184158411589_real64, &
                   0.0_real64]
    truth(:, 13) = [0.028114450291175267_real64, -0.01_real64, 0.17508163470475405924_real64, &
                   -0.023769909128661041346_real64, 0.14835422534418328703_real64, &
                   0.17245232553734711268_real64]
    truth(:, 14) = [0.028114450291175267_real64, 0.0_real64, 0.19148071952437417466_real64, &
                   -0.021870713851969899546_real64, 0.22880454190364381_real64, &
                   0.21077208922319225084_real64]
    truth(:, 15) = [0.028114450291175267_real64, 0.01_real64, 0.20626634384095511482_real64, &
                   -0.019236634287793115802_real64, 0.29628313763011225035_real64, &
                   0.24469362594970255363_real64]
    truth(:, 16) = [0.028114450291175267_real64, 0.1_real64, 0.30460706060150130531_real64, &
                   0.026682938619523389183_real64, 0.68220944818830041506_real64, &
                   0.46010502231668681449_real64]
    truth(:, 17) = [0.028114450291175267_real64, 1000.0_real64, 22.365252226176147352_real64, &
                   44721.343836552621108_real64, 67.082039328716171839_real64, &
                   42.705757602534927335_real64]
    truth(:, 18) = [0.009371483430391755_real64, -0.01_real64, 0.19738739621816689864_real64, &
                   -0.022888582063329300281_real64, 0.13630514326820250991_real64, &
                   0.17055249539100323633_real64]
    truth(:, 19) = [0.009371483430391755_real64, 0.0_real64, 0.2134677987249467463_real64, &
                   -0.021090249921402751316_real64, 0.22033106527438443811_real64, &
                   0.2093737534151575475_real64]
    truth(:, 20) = [0.009371483430391755_real64, 0.01_real64, 0.22795252507990103311_real64, &
                   -0.018529585244382159717_real64, 0.28990773384019781123_real64, &
                   0.24360914487865847447_real64]
    truth(:, 21) = [0.009371483430391755_real64, 0.1_real64, 0.32440424490696882328_real64, &
                   0.027113550077384693273_real64, 0.68064769829964775858_real64, &
                   0.45982031858462507324_real64]
    truth(:, 22) = [0.009371483430391755_real64, 1000.0_real64, 22.368567201329762914_real64, &
                   44721.343838742237042_real64, 67.082039327322170886_real64, &
                   42.705757602739011382_real64]
    truth(:, 23) = [0.005622890058235053_real64, -0.01_real64, 0.20061410858406814689_real64, &
                   -0.022785599782972027984_real64, 0.13490423207403995589_real64, &
                   0.17018849165604098399_real64]
    truth(:, 24) = [0.005622890058235053_real64, 0.0_real64, 0.21671897079193603514_real64, &
                   -0.020998916425806878152_real64, 0.2193585621396825652_real64, &
                   0.20909846829285138727_real64]
    truth(:, 25) = [0.005622890058235053_real64, 0.01_real64, 0.23121689461979891845_real64, &
                   -0.018446644347756705331_real64, 0.28918160115778474227_real64, &
                   0.24339045063074141235_real64]
    truth(:, 26) = [0.005622890058235053_real64, 0.1_real64, 0.32766586626719349438_real64, &
                   0.027165265975500013524_real64, 0.6804718017222839596_real64, &
                   0.45975408418595274499_real64]
    truth(:, 27) = [0.005622890058235053_real64, 1000.0_real64, 22.369917795770483239_real64, &
                   44721.343839160923438_real64, 67.082039327075313184_real64, &
                   42.705757602693248187_real64]
    do i = 1, size(truth, 2)
      call compare(error, contact_at(truth(1, i)), truth(2:, i), 'Maugis')
    end do
  end subroutine maugis_curves

  subroutine maugis_pulls(error)
    type(error_type), allocatable, intent(out) :: error
    ! Distance z0, lambda, largest pull over pi w R.
    real(real64) :: truth(3, 5), power, fit
    type(adhering_contact) :: contact
    integer :: i

    truth(:, 1) = [0.2811439406233091_real64, 0.11570127918624342689_real64, &
                   1.9398592868732548102_real64]
    truth(:, 2) = [0.09371483430391755_real64, 0.34710314335174934393_real64, &
                   1.788721490401270508_real64]
    truth(:, 3) = [0.028114450291175267_real64, 1.1570104778391644512_real64, &
                   1.5822714007174218686_real64]
    truth(:, 4) = [0.009371483430391755_real64, 3.4710314335174935678_real64, &
                   1.512768816605353089_real64]
    truth(:, 5) = [0.005622890058235053_real64, 5.7850523891958224345_real64, &
                   1.5047802174152681122_real64]
    do i = 1, size(truth, 2)
      contact = contact_at(truth(1, i))
      call check(error, contact%model, model_maugis, 'theory')
      call near(error, contact%curve%lambda, truth(2, i), truth(2, i), 'lambda')
      call near(error, contact%pull_off, truth(3, i) * pi * work * radius, contact%pull_off, &
                'largest pull')
      ! Carpick, Ogletree and Salmeron, J. Colloid Interface Sci. 211 (1999) 395: a fit to Maugis'
      ! curve.
      power = 4.04_real64 * truth(2, i)**1.4_real64
      fit = 1.75_real64 - 0.25_real64 * (power - 1.0_real64) / (power + 1.0_real64)
      call check(error, truth(3, i), fit, 0.02_real64 * fit, 'the published fit')
    end do
  end subroutine maugis_pulls

  subroutine maugis_gap(error)
    type(error_type), allocatable, intent(out) :: error
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
      call check(error, above%contact_radius > 0.0_real64 .and. .not. below%contact_radius > &
                 0.0_real64, 'a contact circle above only')
      call check(error, above%load, below%load, 1.0e-7_real64 * abs(below%load), 'load')
      call check(error, above%stiffness, below%stiffness, 1.0e-3_real64 * abs(below%stiffness), &
                 'stiffness')
    end do
  end subroutine maugis_gap

  ! The load of a curve falls and rises once, and the curve ends where its slope is endless.
  subroutine maugis_turns(error)
    type(error_type), allocatable, intent(out) :: error
    type(adhering_contact) :: contact
    type(central_answer) :: answer
    real(real64) :: before, share
    integer :: i, k, turns
    integer, parameter :: steps = 400

    do i = 0, 60
      contact = contact_of(0.1000001_real64 * 49.9999_real64**(real(i, real64) / 60.0_real64))
      call check(error, contact%snap_off < contact%snap_in, 'it snaps off later than in')
      turns = 0
      before = 0.0_real64
      do k = steps, 0, -1
        share = real(k, real64) / real(steps, real64)
        answer = answer_of(contact, contact%snap_off + share**2 * (0.1_real64 - contact%snap_off))
        if (answer%stiffness < 0.0_real64 .and. before > 0.0_real64) turns = turns + 1
        if (answer%stiffness > 0.0_real64 .and. before < 0.0_real64) turns = turns + 10
        before = answer%stiffness
      end do
      call check(error, turns, 1, 'times the load turns')
      call check(error, abs(answer%stiffness) > 1.0e3_real64, 'steep where it ends')
    end do
  end subroutine maugis_turns

  ! Closed forms: Derjaguin, Muller and Toporov 1975 as Maugis 1992 writes them.
  subroutine dmt_curve(error)
    type(error_type), allocatable, intent(out) :: error
    type(adhering_contact) :: contact
    type(central_answer) :: answer
    real(real64) :: unit, load, range, cube
    integer :: i

    contact = contact_of(0.05_real64)
    unit = 2.0_real64 * pi * work * radius
    range = 9.0_real64 * sqrt(3.0_real64) / 16.0_real64 * distance_of(0.05_real64)
    call check(error, contact%model, model_dmt, 'theory')
    call near(error, contact%pull_off, unit, unit, 'pull-off')
    answer = answer_of(contact, 0.0_real64)
    call near(error, answer%load, -unit, unit, 'load at first touch')
    do i = 1, 10
      load = 0.01_real64 * real(i**3, real64)
      ! a**3 = 3/4 R (load + 2 pi w R)/E.
      cube = 0.75_real64 * radius * (load + unit) / modulus
      answer = answer_of(contact, cube**(2.0_real64 / 3.0_real64) / radius)
      call near(error, answer%load, load, load + unit, 'load')
      call near(error, answer%contact_radius**3, cube, cube, 'contact radius')
    end do
    call near(error, contact%snap_in, -range, range, 'range')
    call check(error, .not. contact%snap_off < contact%snap_in, 'nothing snaps')
    answer = answer_of(contact, -0.25_real64 * range)
    call near(error, answer%load, -0.75_real64 * unit, unit, 'load across a gap')
  end subroutine dmt_curve

  ! At the borders, where the theory changes, the largest pull does by 0.32 % and by 3.0 %.
  subroutine borders(error)
    type(error_type), allocatable, intent(out) :: error
    type(adhering_contact) :: above, below
    real(real64), parameter :: hair = 1.0e-9_real64

    above = contact_of(5.0_real64 * (1.0_real64 + hair))
    below = contact_of(5.0_real64 * (1.0_real64 - hair))
    call check(error, above%model, model_jkr, 'above 5')
    call check(error, below%model, model_maugis, 'below 5')
    call check(error, below%pull_off, above%pull_off, 0.0033_real64 * above%pull_off, 'pull at 5')
    call check(error, below%snap_off, above%snap_off, 0.01_real64 * abs(above%snap_off), &
               'snap-off at 5')
    above = contact_of(0.1_real64 * (1.0_real64 + hair))
    below = contact_of(0.1_real64 * (1.0_real64 - hair))
    call check(error, above%model, model_maugis, 'above 0.1')
    call check(error, below%model, model_dmt, 'below 0.1')
    call check(error, above%pull_off, below%pull_off, 0.031_real64 * below%pull_off, 'pull at 0.1')
    call check(error, above%snap_off, below%snap_off, 0.001_real64 * abs(below%snap_off), &
               'snap-off at 0.1')
    above = contact_with(0.0_real64, 1.0_real64)
    call check(error, above%model, model_hertz, 'no work')
    call check(error, .not. adheres_at(above, 1.0_real64, .true.), 'nothing adheres without work')
  end subroutine borders

  ! Overlap, contact radius, load, stiffness, pressure.
  subroutine compare(error, contact, truth, name)
    type(error_type), allocatable, intent(inout) :: error
    type(adhering_contact), intent(in) :: contact
    real(real64), intent(in) :: truth(5)
    character(*), intent(in) :: name
    type(central_answer) :: answer
    real(real64) :: load

    answer = answer_of(contact, truth(1))
    load = max(abs(truth(3)), work * radius)
    call near(error, answer%contact_radius, truth(2), truth(2), name//': contact radius')
    call near(error, answer%load, truth(3), load, name//': load')
    call near(error, answer%stiffness, truth(4), max(abs(truth(4)), modulus * truth(2)), &
              name//': stiffness')
    call near(error, answer%pressure, truth(5), max(abs(truth(5)), modulus), name//': pressure')
  end subroutine compare

end module asperity_adhesion_curves_suite
