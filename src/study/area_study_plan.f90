!> The plan of a study of the representative area: separation, studied region, sections.
module asperity_area_study_plan
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_generation_values, only: exact_value
  use asperity_greenwood_integrals, only: greenwood_law, greenwood_law_of, quantities, &
                                          separation_at_pressure
  use asperity_kinds, only: int64, real64
  use asperity_numeral, only: rounded_decimal
  use asperity_problems, only: real_text
  use asperity_random_philox, only: philox_block
  use asperity_study_spec, only: against_plane, places_grid, study_spec
  implicit none
  private

  public :: study_plan, plan_study, section_corner

  !> The studied numbers of a surface before those of its sections: asperities of the upper and of
  !> the lower surface in the studied region, on an area.
  integer, parameter, public :: leading_numbers = 2

  !> The plan: all that the surfaces of the ensemble share.
  type :: study_plan
    type(greenwood_law) :: law                       !! the design's statistics
    type(decimal_value) :: separation                !! of the reference planes
    real(real64) :: corner(2) = 0.0_real64           !! lower left corner of the studied region
    real(real64) :: extent(2) = 0.0_real64           !! its sides
    real(real64), allocatable :: sizes(:)            !! sides of the sections, descending
    integer, allocatable :: sections(:)              !! how many of each on a surface
    integer, allocatable :: first(:)                 !! numbers of a surface before those of a size
    integer :: numbers = leading_numbers             !! then `quantities` for every section
  end type study_plan

  ! Stream of the generator for the places of sections: 1 to 6 make the surfaces.
  integer(int64), parameter :: place_stream = 7_int64
  ! A number in a message.
  character(len=*), parameter :: shown = 'g14.6'
  ! The whole may be so many times as long as the least section.
  real(real64), parameter :: most_along = 1.0e4_real64

contains

  !> Makes the plan. `failure` is allocated when the specification cannot be studied.
  subroutine plan_study(spec, plan, failure)
    type(study_spec), intent(in) :: spec                   !! checked specification of the study
    type(study_plan), intent(out) :: plan                  !! plan of the study
    character(len=:), allocatable, intent(out) :: failure  !! reason of a failure
    real(real64) :: separation, margin, depth

    plan%law = greenwood_law_of(spec%surfaces, spec%elastic_modulus, spec%poisson_ratio, &
                                spec%against == against_plane)
    if (spec%at_pressure) then
      call separation_at_pressure(plan%law, decimal_to_real64(spec%pressure), separation, failure)
      if (allocated(failure)) return
      plan%separation = rounded_decimal(separation, 15)
    else
      plan%separation = spec%separation
    end if
    depth = plan%law%highest - decimal_to_real64(plan%separation)
    if (.not. depth > 0.0_real64) then
      failure = 'no asperities can touch at the separation, expected less than ' // &
                real_text(plan%law%highest, shown)
    else if (depth >= plan%law%least_sum) then
      failure = 'the centres of two asperities may come level at the separation, expected ' // &
                'more than ' // real_text(plan%law%highest - plan%law%least_sum, shown)
    end if
    if (allocated(failure)) return
    margin = margin_at(spec, depth)
    plan%corner = margin
    associate (rough => spec%surfaces%sides(:merge(1, 2, spec%against == against_plane)))
      plan%extent = real([minval(exact_value(rough%length)), minval(exact_value(rough%width))], &
                         real64) - 2 * margin
    end associate
    if (minval(plan%extent) <= 0.0_real64) then
      failure = 'the surfaces are too small: expected length and width of more than ' // &
                real_text(2 * margin, shown) // ', as a margin of ' // real_text(margin, shown) // &
                ' is left out'
      return
    end if
    call plan_sizes(spec, plan, failure)
  end subroutine plan_study

  !> Sizes and numbers of sections.
  subroutine plan_sizes(spec, plan, failure)
    type(study_spec), intent(in) :: spec
    type(study_plan), intent(inout) :: plan
    character(len=:), allocatable, intent(out) :: failure
    real(real64) :: whole, along(2)
    integer :: i

    whole = minval(plan%extent)
    if (size(spec%sizes) > 0) then
      plan%sizes = spec%sizes
    else
      plan%sizes = [(whole / spec%factor**(i - 1), i=1, spec%steps)]
    end if
    if (plan%sizes(1) > whole) then
      failure = 'sizes: found ' // real_text(plan%sizes(1), shown) // ', expected at most ' // &
                real_text(whole, shown) // ', what the margin of ' // &
                real_text(plan%corner(1), shown) // ' leaves'
    else if (.not. plan%sizes(size(plan%sizes)) * most_along >= whole) then
      failure = 'sizes: found ' // real_text(plan%sizes(size(plan%sizes)), shown) // &
                ', expected at least ' // real_text(whole / most_along, shown)
    end if
    if (allocated(failure)) return
    allocate (plan%sections(size(plan%sizes)), plan%first(size(plan%sizes)))
    do i = 1, size(plan%sizes)
      plan%sections(i) = spec%sections
      if (spec%places == places_grid) then
        along = squares_along(plan, i)
        plan%sections(i) = int(min(real(spec%sections, real64), along(1) * along(2)))
      end if
      plan%first(i) = plan%numbers
      plan%numbers = plan%numbers + quantities * plan%sections(i)
    end do
  end subroutine plan_sizes

  !> Lower left corner of a section on a surface.
  pure function section_corner(spec, plan, size_number, member, k) result(corner)
    type(study_spec), intent(in) :: spec  !! checked specification of the study
    type(study_plan), intent(in) :: plan  !! plan of the study
    integer, intent(in) :: size_number    !! number of a size
    integer, intent(in) :: member         !! number of a surface
    integer, intent(in) :: k              !! number of the section, of this size
    real(real64) :: corner(2)
    integer(int64) :: words(4), cells(2), cell

    if (spec%places == places_grid) then
      ! When not all are taken, those that are lie all over the region.
      cells = int(squares_along(plan, size_number), int64)
      cell = (int(k - 1, int64) * product(cells)) / plan%sections(size_number)
      corner = [modulo(cell, cells(1)), cell / cells(1)] * plan%sizes(size_number)
    else
      words = philox_block([int(k, int64), int(size_number, int64), int(member, int64), &
                            place_stream], [int(spec%surfaces%seed, int64), 0_int64])
      corner = (plan%extent - plan%sizes(size_number)) * (real(words(:2), real64) / 2.0_real64**32)
    end if
    corner = corner + plan%corner
  end function section_corner

  !> How many squares of a size stand side by side in the region, along x and y.
  pure function squares_along(plan, size_number) result(along)
    type(study_plan), intent(in) :: plan
    integer, intent(in) :: size_number
    real(real64) :: along(2)

    ! A size that is a part of the whole must not lose a square to rounding.
    along = aint(plan%extent / plan%sizes(size_number) * (1 + 1.0e-12_real64))
  end function squares_along

  !> Width of the border that is left out. A contact needs both its asperities, so its reach; and
  !> near the border asperities that keep a distance stand denser, which twice the distance leaves
  !> out.
  pure real(real64) function margin_at(spec, depth)
    type(study_spec), intent(in) :: spec
    real(real64), intent(in) :: depth
    real(real64) :: largest_sum

    margin_at = 2 * decimal_to_real64(spec%surfaces%sides(1)%least_distance)
    if (spec%against == against_plane) return
    largest_sum = real(sum(spec%surfaces%sides%radius%highest), real64)
    margin_at = max(margin_at, 2 * decimal_to_real64(spec%surfaces%sides(2)%least_distance)) + &
                sqrt(depth * (2 * largest_sum - depth))
  end function margin_at

end module asperity_area_study_plan
