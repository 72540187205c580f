!> Tests of the curves of plastic flow, one contact at a time: loading, unloading, onset, index.
!>
!> The truth of the published curves is test/truth/plastic_truth.py, evaluated by mpmath with
!> 40 digits. Run that file to print the values again.
module asperity_plastic_curves_suite
  use asperity_contact_law, only: contact_response
  use asperity_contact_pairs, only: contact_pair
  use asperity_effect_helpers, only: near, pair_of, penetration_of, plastic_law_with, same
  use asperity_kinds, only: real64
  use asperity_first_yield, only: constraint_factor
  use asperity_plastic_curves, only: departure, loading_curve, plastic_scale, &
                                     plasticity_index, set_scale, unloading_shape
  use asperity_plastic_law, only: past_of_contact, plastic_law, plastic_past
  use asperity_testing, only: check, error_type, new_unittest, unittest_type
  implicit none
  private

  public :: collect_plastic_curves

  real(real64), parameter :: pi = acos(-1.0_real64)
  real(real64), parameter :: tolerance = 2.0e-14_real64

contains

  !> Lists the tests.
  subroutine collect_plastic_curves(suite)
    !> all tests
    type(unittest_type), allocatable, intent(out) :: suite(:)

    allocate (suite(0))
    suite = [ &
      new_unittest('Jackson and Green at ten points, five between, against mpmath', published), &
      new_unittest('Kogut and Etsion: their load within 4 % up to 100', other_fit), &
      new_unittest('the area power within and beyond the range of its fit', area_powers), &
      new_unittest('Etsion and others: unloading, and the work lost, against mpmath', unloadings), &
      new_unittest('Hertz, bit for bit, up to the onset', hertz_below), &
      new_unittest('load, area, pressure go on through the onset and the joints', continuous), &
      new_unittest('load and area never fall with the approach, from soft to rigid', never_falls), &
      new_unittest('unloading lies below loading, and loses more the further it was', bounded), &
      new_unittest('plasticity index and critical overlap of the thesis', index_of_thesis)]
  end subroutine collect_plastic_curves

  ! A steel of 200 GPa, 0.32, 0.9115 GPa, radius 1.
  subroutine published(error)
    type(error_type), allocatable, intent(out) :: error
    real(real64), parameter :: x(15) = [6.0_real64, 8.0_real64, 10.0_real64, 15.0_real64, &
      20.0_real64, 30.0_real64, 50.0_real64, 70.0_real64, 100.0_real64, 150.0_real64, &
      1.95_real64, 2.5_real64, 3.0_real64, 4.0_real64, 5.5_real64]
    real(real64), parameter :: load(15) = [12.938989300865149509_real64, &
      19.097577621955443644_real64, 25.74495049679338161_real64, 43.943602618962898765_real64, &
      63.778105359571651717_real64, 106.67116185498921681_real64, 199.9257215332187112_real64, &
      298.37010121995412947_real64, 450.37729469025734232_real64, 707.20060182224560171_real64, &
      2.7168466685296892591_real64, 3.8541639498201574074_real64, 4.973937196849316337_real64, &
      7.4171819134032657636_real64, 11.491162723082429662_real64]
    real(real64), parameter :: area(15) = [7.1608504404197789111_real64, &
      9.9797673540157367144_real64, 12.910300573188717353_real64, 20.611640632038155643_real64, &
      28.725551525449858569_real64, 45.86111234538281583_real64, 82.683020672745588087_real64, &
      121.90474657837343335_real64, 183.97057118463037196_real64, 293.71394404273149419_real64, &
      1.9578065005523175259_real64, 2.6077881576727861733_real64, 3.2183448754174042184_real64, &
      4.4852679704579380954_real64, 6.4768480456808091244_real64]
    real(real64), parameter :: critical = 0.00011090941284170877067_real64, &
                               critical_load = 0.0003470072092352658366_real64, &
                               critical_area = 0.00034843219659746974769_real64
    type(contact_pair) :: pair
    type(plastic_law) :: law
    type(contact_response) :: answer
    integer :: i

    pair = pair_of(2.0_real64, 2.0_real64, 0.0_real64)
    law = steel_law(critical)
    call check(error, law%constraint, 1.6389088665776387255_real64, tolerance, 'C')
    ! The pair is aligned, so the overlap is the penetration.
    do i = 1, size(x)
      call law%respond(pair, 1, x(i) * critical, answer)
      call near(error, answer%load / critical_load, load(i), tolerance, 'load')
      call near(error, pi * answer%contact_radius**2 / critical_area, area(i), tolerance, 'area')
    end do
  end subroutine published

  ! Load of another finite element study: 1.40 x**1.263 from x = 6 to 110.
  subroutine other_fit(error)
    type(error_type), allocatable, intent(out) :: error
    type(plastic_scale) :: scale
    real(real64) :: ratio, slope, spread, peak, x
    integer :: i

    call set_scale(constraint_factor(0.32_real64), 0.0105_real64, scale)
    do i = 6, 100
      x = real(i, real64)
      call loading_curve(scale, x, ratio, slope, spread, peak)
      call check(error, ratio * x**1.5_real64 / (1.40_real64 * x**1.263_real64), 1.0_real64, &
                 0.043_real64, 'Kogut and Etsion')
    end do
  end subroutine other_fit

  ! B = 0.14 exp(23 Sy/E) up to Sy/E = 1.619 (1 - 0.32**2)/200 = 0.0072661, constant beyond.
  subroutine area_powers(error)
    type(error_type), allocatable, intent(out) :: error
    type(plastic_scale) :: inside, outside

    call set_scale(1.6_real64, 0.8_real64 * pi * 0.0072_real64, inside)
    call check(error, inside%area_power, 0.16521413536821808_real64, 1.0e-14_real64, 'inside')
    call set_scale(1.6_real64, 0.8_real64 * pi * 0.01_real64, outside)
    call check(error, outside%area_power, 0.1654653948859781_real64, 1.0e-14_real64, 'beyond')
  end subroutine area_powers

  subroutine unloadings(error)
    type(error_type), allocatable, intent(out) :: error
    real(real64), parameter :: x(7) = [1.1_real64, 1.9_real64, 3.0_real64, 6.0_real64, &
                                       10.0_real64, 50.0_real64, 100.0_real64]
    real(real64), parameter :: truth(4, 7) = reshape( &
      [0.0016761056646862470345_real64, 1.4974858415029706294_real64, &
       0.98862793480295417235_real64, 0.00034067484204757030249_real64, &
       0.058858855264508103093_real64, 1.4684680939817871776_real64, &
       0.9258690524832687067_real64, 0.093224815193333654514_real64, &
       0.14071878204715679409_real64, 1.4464337459144841019_real64, &
       0.87648694023035702614_real64, 0.88869877470007020438_real64, &
       0.27991288718007079647_real64, 1.4136257668456322725_real64, 0.80653245833395753603_real64, &
       9.3756968109198169546_real64, &
       0.37817067580703511123_real64, 1.3899246562406166646_real64, 0.75857757502918376875_real64, &
       42.267012780990116419_real64, &
       0.62082060845844830566_real64, 1.3178177471046145909_real64, 0.62535064119409872446_real64, &
       2819.1159944011532946_real64, &
       0.69437172753411864248_real64, 1.2879270333503976036_real64, 0.57543993733715693006_real64, &
       14638.159551947355469_real64], [4, 7])
    real(real64), parameter :: critical = 0.00011090941284170877067_real64, &
                               critical_load = 0.0003470072092352658366_real64
    type(contact_pair) :: pair
    type(plastic_law) :: law
    type(plastic_past) :: past
    type(contact_response) :: full, half
    real(real64) :: residual, load_power, area_power
    integer :: i

    pair = pair_of(2.0_real64, 2.0_real64, 0.0_real64)
    law = steel_law(critical)
    do i = 1, size(x)
      call unloading_shape(x(i), residual, load_power, area_power)
      call near(error, residual, truth(1, i), tolerance, 'residual overlap')
      call near(error, load_power, truth(2, i), tolerance, 'power of the load')
      call near(error, area_power, truth(3, i), tolerance, 'power of the area')
      call past_of_contact(law, pair, 1, x(i) * critical, past)
      call near(error, past%residual, truth(1, i) * x(i) * critical, tolerance, &
                'residual of the contact')
      call check(error, past%work_lost / (critical_load * critical), truth(4, i), &
                 1.0e-12_real64 * max(truth(4, i), 1.0_real64), 'work lost')
      ! Half way between the residual and the largest overlap.
      call law%respond(pair, 1, x(i) * critical, full)
      law%largest = x(i) * critical
      call law%respond(pair, 1, 0.5_real64 * (1.0_real64 + truth(1, i)) * x(i) * critical, half)
      call near(error, half%load / full%load, 0.5_real64**truth(2, i), tolerance, &
                'load, half way')
      call near(error, (half%contact_radius / full%contact_radius)**2, 0.5_real64**truth(3, i), &
                tolerance, 'area, half way')
      call law%respond(pair, 1, 0.999_real64 * past%residual, half)
      call check(error, .not. (half%load > 0.0_real64 .or. half%contact_radius > 0.0_real64 .or. &
                               abs(half%stiffness) > 0.0_real64), 'below the residual overlap')
      law%largest = 0.0_real64
    end do
  end subroutine unloadings

  subroutine hertz_below(error)
    type(error_type), allocatable, intent(out) :: error
    type(contact_pair) :: pair
    type(plastic_law) :: law
    type(contact_response) :: answer, elastic
    real(real64) :: p
    integer :: i

    pair = pair_of(1.0_real64, 1.5_real64, 1.2_real64)
    law = plastic_law_with(0.42_real64, 3.0_real64, 1.0e-3_real64)
    do i = -10, 1000
      p = 2.2e-3_real64 * i / 1000
      call law%respond(pair, 1, p, answer)
      call law%elastic%respond(pair, 1, p, elastic)
      if (elastic%overlap > departure * 1.0e-3_real64) exit
      call check(error, same(answer, elastic), 'not that of Hertz below the onset')
    end do
    call check(error, i > 500 .and. i < 1000, 'the onset is on the way')
    call check(error, .not. same(answer, elastic), 'that of Hertz past the onset')
    law%critical = huge(1.0_real64)
    call law%respond(pair, 1, 0.5_real64, answer)
    call law%elastic%respond(pair, 1, 0.5_real64, elastic)
    call check(error, same(answer, elastic), 'not that of Hertz without an onset')
  end subroutine hertz_below

  ! A step of 1e-13 of the overlap changes nothing by more than 1e-12.
  subroutine continuous(error)
    type(error_type), allocatable, intent(out) :: error
    real(real64), parameter :: at(4) = [departure, 6.0_real64, 9.0_real64, 40.0_real64]
    real(real64), parameter :: nu(3) = [-0.5_real64, 0.3_real64, 0.5_real64]
    real(real64), parameter :: critical = 1.0e-3_real64
    type(contact_pair) :: pair
    type(plastic_law) :: law
    type(contact_response) :: below, above
    real(real64) :: p
    integer :: i, j, k

    do j = 1, size(nu)
      do i = 1, size(at)
        do k = 0, 1
          law = plastic_law_with(nu(j), 2.0_real64, critical)
          ! First loading, then past 9 critical overlaps of an earlier loading.
          law%largest = 9.0_real64 * critical * k
          pair = pair_of(2.0_real64, 1.0_real64, 1.0_real64)
          p = penetration_of(pair, at(i) * critical)
          call law%respond(pair, 1, p * (1.0_real64 - 1.0e-13_real64), below)
          call law%respond(pair, 1, p * (1.0_real64 + 1.0e-13_real64), above)
          call check(error, above%load, below%load, 1.0e-12_real64 * above%load, 'load jumps')
          call check(error, above%contact_radius**2, below%contact_radius**2, &
                     1.0e-12_real64 * above%contact_radius**2, 'area jumps')
          call check(error, above%maximum_pressure, below%maximum_pressure, &
                     1.0e-12_real64 * above%maximum_pressure, 'greatest pressure jumps')
        end do
      end do
    end do
  end subroutine continuous

  ! On first loading, and up and down below an earlier one.
  subroutine never_falls(error)
    type(error_type), allocatable, intent(out) :: error
    real(real64), parameter :: nu(4) = [-1.0_real64, 0.0_real64, 0.32_real64, 0.5_real64]
    real(real64), parameter :: strain(5) = [1.0e-4_real64, 0.01_real64, 0.1_real64, 0.3_real64, &
                                            1.0_real64]
    integer, parameter :: steps = 4000
    type(plastic_scale) :: scale
    type(contact_pair) :: pair
    type(plastic_law) :: law
    type(contact_response) :: answer, before
    real(real64) :: x, ratio, slope, spread, peak, load, load_before, p
    integer :: i, j, k

    do j = 1, size(nu)
      do k = 1, size(strain)
        call set_scale(constraint_factor(nu(j)), strain(k), scale)
        load_before = 0.0_real64
        do i = 1, steps
          x = 1.5_real64 * 1000.0_real64**(real(i, real64) / steps)
          call loading_curve(scale, x, ratio, slope, spread, peak)
          load = ratio * x**1.5_real64
          call check(error, load > load_before, 'the load falls')
          call check(error, 1.5_real64 * ratio + x * slope > 0.0_real64, 'the slope is negative')
          call check(error, ratio <= 1.0_real64 + 1.0e-15_real64, 'the load is above that of Hertz')
          call check(error, spread >= 1.0_real64, 'the area is below that of Hertz')
          call check(error, peak > 1.0_real64, 'greatest pressure below the average')
          call check(error, peak, 1.25_real64, 0.25_real64, 'greatest over average pressure')
          load_before = load
        end do
      end do
    end do

    pair = pair_of(1.0_real64, 1.0_real64, 1.0_real64)
    law = plastic_law_with(0.42_real64, 1.0_real64, 1.0e-3_real64)
    do j = 0, 1
      law%largest = 8.0e-3_real64 * j
      before = contact_response()
      do i = 1, steps
        p = 0.03_real64 * i / steps
        call law%respond(pair, 1, p, answer)
        call check(error, answer%load >= before%load, 'the load falls with the approach')
        call check(error, answer%vertical_load >= before%vertical_load, 'the vertical load falls')
        call check(error, answer%contact_radius >= before%contact_radius, 'the area falls')
        before = answer
      end do
    end do
  end subroutine never_falls

  subroutine bounded(error)
    type(error_type), allocatable, intent(out) :: error
    real(real64), parameter :: nu(4) = [-1.0_real64, 0.0_real64, 0.32_real64, 0.5_real64]
    real(real64), parameter :: strain(4) = [1.0e-4_real64, 0.02_real64, 0.15_real64, 0.6_real64]
    type(contact_pair) :: pair
    type(plastic_law) :: law, virgin
    type(plastic_past) :: past
    type(contact_response) :: first, later
    real(real64) :: critical, work, residual, largest
    integer :: i, j, k, m

    pair = pair_of(2.0e6_real64, 2.0e6_real64, 0.0_real64)
    do j = 1, size(nu)
      do k = 1, size(strain)
        critical = strain(k)**2 * pair%radius
        law = plastic_law_with(nu(j), 1.0_real64, critical)
        virgin = law
        work = 0.0_real64
        residual = 0.0_real64
        do i = 1, 200
          largest = critical * (1.0_real64 + 1.0e-3_real64 * 1.05_real64**i)
          if (largest > 0.9_real64 * pair%s) exit
          call past_of_contact(law, pair, 1, largest, past)
          call check(error, past%flowed .eqv. largest > departure * critical, 'it has flowed')
          call check(error, past%work_lost > work, 'the work lost does not grow')
          call check(error, past%residual > residual, 'the residual overlap does not grow')
          work = past%work_lost
          residual = past%residual
          law%largest = largest
          do m = 1, 9
            call law%respond(pair, 1, largest * m / 10.0_real64, later)
            call virgin%respond(pair, 1, largest * m / 10.0_real64, first)
            call check(error, later%load < first%load, 'unloading is above loading')
          end do
        end do
        call check(error, i > 100, 'too few')
      end do
    end do
    call past_of_contact(law, pair, 1, critical, past)
    call check(error, .not. (past%flowed .or. past%work_lost > 0.0_real64 .or. &
                             past%residual > 0.0_real64), 'at first yield nothing has flowed')
  end subroutine bounded

  ! E0 of two spheres of 20000 kg/cm2 and 0.42, H = 22 kg/mm2, R = 0.635 cm.
  subroutine index_of_thesis(error)
    type(error_type), allocatable, intent(out) :: error
    real(real64), parameter :: hardness = 2200.0_real64, radius = 0.635_real64
    real(real64) :: modulus

    modulus = 2.0e4_real64 / (2.0_real64 * (1.0_real64 - 0.42_real64**2))
    ! The index is 1 where the deviation is the critical overlap, 0.021 cm in the thesis.
    call check(error, plasticity_index(0.02084739344864_real64, radius, modulus, hardness), &
               1.0_real64, 1.0e-12_real64, 'critical overlap')
    call check(error, radius * (hardness / modulus)**2, 0.021_real64, 0.0005_real64, 'W_p')
    ! The deviation in the text, 0.012 in, with the radius of one summit, 0.5 in.
    call check(error, plasticity_index(0.012_real64, 0.5_real64, modulus, hardness), &
               0.85500095947004655508_real64, 1.0e-13_real64, 'with the deviation in the text')
    ! The deviation over the radius that 0.92 stands for.
    call check(error, plasticity_index(0.0277877697872896_real64, 1.0_real64, modulus, hardness), &
               0.92_real64, 1.0e-13_real64, '0.92')
  end subroutine index_of_thesis

  function steel_law(critical) result(law)
    real(real64), intent(in) :: critical
    type(plastic_law) :: law

    law = plastic_law_with(0.32_real64, 200.0_real64 / (1.0_real64 - 0.32_real64**2), critical)
  end function steel_law

end module asperity_plastic_curves_suite
