!> Closed forms in the place of a simulation: the theories of contact that the thesis reviews in its
!> chapter on the literature, on the statistics of the surfaces at hand.
!>
!> Those that give a load or an area become lines beside the methods of computing; those whose
!> equations lack a constant in the thesis are named with what they lack. The criteria of the
!> elastic limit are brought to one number: the least hardness with which contact stays elastic.
module asperity_reviewed_theories
  use asperity_constants, only: pi
  use asperity_contact_records, only: state_row
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_generation_values, only: generation_spec
  use asperity_greenwood_integrals, only: area_per_area, densities_at, greenwood_law, &
                                          greenwood_law_of, separation_at_pressure, &
                                          vertical_per_area
  use asperity_kinds, only: not_computed, real128, real64
  use asperity_method_totals, only: method_totals
  use asperity_numeral, only: rounded_decimal
  use asperity_plastic_surface, only: combined_radius, height_deviation, surface_hardness
  use asperity_scene_values, only: combined_modulus, is_load, scene, scene_surface
  implicit none
  private

  public :: elastic_criterion, reviewed_theory, evaluate_theories

  !> Fewer summits have no statistics.
  integer, parameter :: least_summits = 10
  ! Deviations beyond which a Gaussian of the theories is cut: less than 1e-14 is there.
  real(real128), parameter :: cut = 8.0_real128

  !> Errors of a theory.
  type :: reviewed_theory
    character(len=32) :: name = ''             !! of its authors
    real(real64) :: load = not_computed        !! error of the load, or at a given one of the
                                               !! approach over the compression
    real(real64) :: area = not_computed        !! error of the area, relative
    character(len=:), allocatable :: left_out  !! why it gives nothing
  end type reviewed_theory

  !> A criterion of the elastic limit.
  type :: elastic_criterion
    character(len=32) :: name = ''                !! of its authors
    real(real64) :: hardness = 0.0_real64         !! from which on contact is elastic
  end type elastic_criterion

  ! Both surfaces as the theories see them.
  type :: summit_statistics
    real(real64) :: area = 0.0_real64        ! nominal
    real(real64) :: density = 0.0_real64     ! of summits, the geometric mean of both
    real(real64) :: radius = 0.0_real64      ! of summits, the mean of both
    real(real64) :: mean = 0.0_real64        ! of the sum of both heights
    real(real64) :: deviation = 0.0_real64   ! of the sum
    real(real64) :: highest = 0.0_real64     ! summit above its plane
    real(real64) :: foot = 0.0_real64        ! slope of a cap where it meets its plane
    type(greenwood_law) :: law
  end type summit_statistics

contains

  !> The theories and criteria on the surfaces of a scene, compared with the totals of the reference
  !> solution. `why_not` is the reason why there are none; empty: there are.
  subroutine evaluate_theories(scene_in, truth, theories, criteria, why_not)
    type(scene), intent(in) :: scene_in                             !! scene without a map
    type(method_totals), intent(in) :: truth                        !! of the reference
    type(reviewed_theory), allocatable, intent(out) :: theories(:)  !! in the thesis' order
    type(elastic_criterion), allocatable, intent(out) :: criteria(:)  !! in the thesis' order
    character(len=:), allocatable, intent(out) :: why_not
    type(summit_statistics) :: summits
    character(len=32), parameter :: names(6) = [character(len=32) :: 'Bowden and Tabor', &
      'D''yachenko, cones', 'Greenwood and Tripp, plastic', 'Kragelskii, rods', &
      'Kragelskii, hemispheres', 'Greenwood and Tripp, elastic']
    character(len=*), parameter :: lacks = 'the thesis'' equation lacks a constant: ', &
      no_hardness = 'needs a hardness: expected &limit hardness, or plastic_yield_stress'
    type(state_row) :: deepest(size(truth%first) - 1)
    real(real64) :: hardness, modulus
    integer :: m

    allocate (theories(0), criteria(0))
    call measure_surfaces(scene_in, summits, why_not)
    if (why_not /= '') return
    hardness = surface_hardness(scene_in)
    modulus = combined_modulus(scene_in)
    deallocate (theories)
    allocate (theories(size(names)))
    theories%name = names
    theories(2)%left_out = lacks // 'alpha, "related to mean height", has no value'
    theories(4)%left_out = lacks // 'those of the height distribution have no value'
    theories(5)%left_out = lacks // 'K2, b and nu have no values'
    do m = 1, size(deepest)
      associate (states => truth%states(truth%first(m):truth%first(m + 1) - 1))
        deepest(m) = states(maxloc(states%compression, 1))
      end associate
    end do
    if (hardness > 0.0_real64) then
      ! Bowden and Tabor, A = W/p_m (II B 1): the mean yield pressure is the hardness.
      theories(1)%area = relative_error(sum(deepest%vertical_load) / hardness, sum(deepest%area))
      call apply_plastic_theory(summits, hardness, is_load(scene_in%loading%control), deepest, &
                                theories(3))
    else
      theories(1)%left_out = no_hardness
      theories(3)%left_out = no_hardness
    end if
    call apply_elastic_theory(scene_in, summits, deepest, theories(6))
    ! Blok: h/(2 l) < H/(pi E), h from peak to valley, l from peak to peak. Halliday: tan theta <
    ! 0.84 (1 - nu^2) H/E, for caps of one material, whose E/(1 - nu^2) is twice the combined
    ! modulus. Greenwood and Williamson: an index of 0.6. What was simulated: the greatest pressure
    ! at 0.6 H, Tabor's onset.
    criteria = [elastic_criterion('Blok, height over distance', &
                                  pi * modulus * summits%highest * sqrt(summits%density) / 2), &
                elastic_criterion('Halliday, slope', 2 * modulus * summits%foot / 0.84_real64), &
                elastic_criterion('Greenwood and Williamson, index', modulus / 0.6_real64 * &
                                  sqrt(summits%deviation / combined_radius(scene_in))), &
                elastic_criterion('as simulated, greatest pressure', &
                                  truth%greatest_pressure / 0.6_real64)]
  end subroutine evaluate_theories

  ! Statistics of the surfaces; the nominal area is that of the scene, else that of the smaller
  ! box about summits.
  subroutine measure_surfaces(scene_in, summits, why_not)
    type(scene), intent(in) :: scene_in
    type(summit_statistics), intent(out) :: summits
    character(len=:), allocatable, intent(out) :: why_not
    type(generation_spec) :: spec
    type(decimal_value) :: modulus(2), ratio(2)
    real(real64) :: box(2)
    integer :: sides

    why_not = ''
    sides = 0
    box = huge(box)
    if (.not. scene_in%upper%is_plane) call add_side(scene_in%upper)
    if (.not. scene_in%lower%is_plane) call add_side(scene_in%lower)
    if (why_not /= '') return
    summits%area = decimal_to_real64(scene_in%nominal_area)
    if (.not. summits%area > 0.0_real64) summits%area = minval(box)
    summits%density = summits%density**(1.0_real64 / sides)
    summits%radius = summits%radius / sides
    summits%deviation = sqrt(summits%deviation)
    ! Two alike bodies of half the compliance each have the modulus of the scene, whatever its
    ! method of naming it.
    modulus = rounded_decimal(2 * combined_modulus(scene_in), 17)
    ! The law has two sides; on a plane the second is not used.
    if (sides == 1) spec%sides(2) = spec%sides(1)
    summits%law = greenwood_law_of(spec, modulus, ratio, sides == 1)

  contains

    subroutine add_side(surface)
      type(scene_surface), intent(in) :: surface
      integer :: n
      real(real64) :: deviation, mean

      n = size(surface%x)
      sides = sides + 1
      if (n < least_summits) then
        why_not = 'a surface of fewer than 10 summits has no statistics'
        return
      end if
      box(sides) = (maxval(surface%x) - minval(surface%x)) * (maxval(surface%y) - minval(surface%y))
      mean = sum(surface%height) / n
      deviation = height_deviation(surface%height)
      if (.not. (box(sides) > 0.0_real64 .and. deviation > 0.0_real64)) then
        why_not = 'summits in a row, or of one height, have no statistics'
        return
      end if
      summits%density = merge(1.0_real64, summits%density, sides == 1) * n / box(sides)
      summits%radius = summits%radius + sum(surface%radius) / n
      summits%mean = summits%mean + mean
      summits%deviation = summits%deviation + deviation**2
      summits%highest = max(summits%highest, maxval(surface%height))
      summits%foot = max(summits%foot, sqrt(max(0.0_real64, 2 * mean * n / sum(surface%radius))))
      associate (side => spec%sides(sides))
        side%number = n
        side%length = rounded_decimal(sqrt(box(sides)), 17)
        side%width = side%length
        side%height%mean = rounded_decimal(mean, 17)
        side%height%deviation = rounded_decimal(deviation, 17)
        side%height%lowest = mean - cut * deviation
        side%height%highest = mean + cut * deviation
        side%radius%mean = rounded_decimal(sum(surface%radius) / n, 17)
        side%radius%lowest = decimal_to_real64(side%radius%mean)
        side%radius%highest = side%radius%lowest
      end associate
    end subroutine add_side

  end subroutine measure_surfaces

  ! A = pi^2 (eta beta sigma)^2 A_nom F2(h), P = 2 H A, as the thesis has them (II B 1), with F2 of
  ! the Gaussian in closed form.
  pure subroutine apply_plastic_theory(summits, hardness, by_load, deepest, theory)
    type(summit_statistics), intent(in) :: summits
    real(real64), intent(in) :: hardness
    logical, intent(in) :: by_load
    type(state_row), intent(in) :: deepest(:)
    type(reviewed_theory), intent(inout) :: theory
    real(real64) :: area, factor, u(size(deepest))

    if (by_load) then
      theory%area = relative_error(sum(deepest%vertical_load) / (2 * hardness), sum(deepest%area))
      return
    end if
    factor = (pi * summits%density * summits%radius * summits%deviation)**2 * summits%area
    u = (deepest%approach - summits%mean) / summits%deviation
    area = sum(factor * ((1 + u**2) * erfc(u / sqrt(2.0_real64)) / 2 - &
                         u * exp(-u**2 / 2) / sqrt(2 * pi)))
    theory%area = relative_error(area, sum(deepest%area))
    theory%load = relative_error(2 * hardness * area, sum(deepest%vertical_load))
  end subroutine apply_plastic_theory

  ! Greenwood and Tripp, or Greenwood and Williamson on a plane: A = pi^2 (eta beta sigma)^2 A_nom
  ! F2(h) (II B 2). The thesis has no equation of the load; it is that of their paper.
  subroutine apply_elastic_theory(scene_in, summits, deepest, theory)
    type(scene), intent(in) :: scene_in
    type(summit_statistics), intent(in) :: summits
    type(state_row), intent(in) :: deepest(:)
    type(reviewed_theory), intent(inout) :: theory
    integer :: i
    real(real64) :: area, load, missed, separation, values(4)

    if (scene_in%upper%is_plane .or. scene_in%lower%is_plane) &
      theory%name = 'Greenwood and Williamson'
    area = 0.0_real64
    load = 0.0_real64
    missed = 0.0_real64
    do i = 1, size(deepest)
      separation = deepest(i)%approach
      if (is_load(scene_in%loading%control)) then
        if (.not. deepest(i)%vertical_load > 0.0_real64) cycle
        call separation_at_pressure(summits%law, deepest(i)%vertical_load / summits%area, &
                                    separation, theory%left_out)
        if (allocated(theory%left_out)) return
        missed = missed + abs(separation - deepest(i)%approach)
      end if
      values = densities_at(summits%law, separation, shallow=.true.)
      area = area + values(area_per_area) * summits%area
      load = load + values(vertical_per_area) * summits%area
    end do
    theory%area = relative_error(area, sum(deepest%area))
    if (is_load(scene_in%loading%control)) then
      theory%load = relative_error(missed, 0.0_real64)
      if (sum(deepest%compression) > 0.0_real64) &
        theory%load = missed / sum(deepest%compression)
    else
      theory%load = relative_error(load, sum(deepest%vertical_load))
    end if
  end subroutine apply_elastic_theory

  ! A relative error; none is known of nothing.
  pure real(real64) function relative_error(have, want)
    real(real64), intent(in) :: have, want

    relative_error = not_computed
    if (want > 0.0_real64) relative_error = abs(have / want - 1.0_real64)
  end function relative_error

end module asperity_reviewed_theories
