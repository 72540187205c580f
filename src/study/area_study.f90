!> The study of the representative area: the surfaces of an ensemble, shared out over the images;
!> means and standard deviations over their sections, and the size that represents the whole.
module asperity_area_study
  use asperity_decimal, only: decimal_to_real64, decimal_value
  use asperity_generated_surface, only: generate_surface, generated_surface, plan_surface, &
                                        surface_plan
  use asperity_generation_values, only: exact_value
  use asperity_greenwood_integrals, only: area_per_area, contacts_per_area, densities_at, &
                                          greenwood_law, greenwood_law_of, load_per_area, &
                                          quantities, separation_at_pressure, vertical_per_area
  use asperity_images, only: image_number, mark_of_failure, read_mark, set_mark
  use asperity_kept_records, only: begin_work, checksum, close_work, is_due, keep_record, &
                                   kept_work, next_record, pieces_of_part, share_work, whole_number
  use asperity_kinds, only: int64, real64
  use asperity_numeral, only: rounded_decimal
  use asperity_problems, only: decimal_text, real_text
  use asperity_progress, only: progress_line
  use asperity_random_philox, only: philox_block
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: scene_results
  use asperity_scene_surfaces, only: plane_surface
  use asperity_scene_values, only: control_separation, criterion_none, scene, scene_surface
  use asperity_solve, only: solve
  use asperity_study_spec, only: against_plane, places_grid, reference_largest, study_spec
  use asperity_version, only: version
  implicit none
  private

  public :: area_study, size_result, study_plan, plan_study, run_area_study

  ! The studied numbers of a surface before those of its sections: asperities of the upper and of
  ! the lower surface in the studied region, on an area.
  integer, parameter :: leading_numbers = 2

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

  !> The sections of one size.
  type :: size_result
    real(real64) :: side = 0.0_real64             !! of a section
    integer :: sections = 0                       !! of all surfaces
    real(real64) :: mean(quantities) = 0.0_real64       !! on an area
    real(real64) :: deviation(quantities) = 0.0_real64  !! standard deviation of a section
    real(real64) :: error(quantities) = 0.0_real64      !! standard error of the mean
    real(real64) :: within(quantities) = 0.0_real64     !! share of sections within the tolerance
    real(real64) :: all_within = 0.0_real64             !! share of those within it in everything
  end type size_result

  !> The whole study.
  type :: area_study
    type(size_result), allocatable :: sizes(:)         !! from the largest down
    integer :: surfaces = 0                            !! of the ensemble
    real(real64) :: separation = 0.0_real64            !! of the reference planes
    type(study_plan) :: plan                           !! what the surfaces share
    real(real64) :: density(2) = 0.0_real64            !! asperities on an area, as found
    real(real64) :: integral(quantities) = 0.0_real64  !! large surfaces with these densities
    real(real64) :: shallow(quantities) = 0.0_real64   !! the same by Greenwood and Tripp's terms
    real(real64) :: reference(quantities) = 0.0_real64 !! what sections are compared with
    integer :: representative = 0                      !! which size; 0: none of them
    real(real64) :: estimated_side = 0.0_real64        !! the size by the spread's fall with it
    !> Processor time of this process when the first surface begins and when the last is done, s
    real(real64) :: begun = 0.0_real64, ended = 0.0_real64
  end type area_study

contains

  !> Runs the study: every image studies surfaces, image 1 gathers them in order and keeps them.
  !> Only there `study` is filled, and not by a part. `failure` is allocated on all images alike.
  subroutine run_area_study(spec, plan, options, study, failure)
    type(study_spec), intent(in) :: spec                   !! checked specification of the study
    type(study_plan), intent(in) :: plan                   !! plan of the study
    type(run_options), intent(in) :: options               !! its images, progress and kept file
    type(area_study), intent(out) :: study                 !! results of the study
    character(len=:), allocatable, intent(out) :: failure  !! reason of a failure
    type(surface_plan) :: plans(2)
    type(kept_work) :: kept
    type(progress_line) :: progress
    real(real64), allocatable :: numbers(:, :)
    real(real64) :: begun, ended
    integer :: members, m, pass, status, surface

    members = pieces_of_part(spec%surfaces%ensemble, options%part, options%parts)
    allocate (numbers(plan%numbers, members), source=0.0_real64, stat=status)
    if (status /= 0) then
      failure = 'not enough memory for the sections of ' // decimal_text(members) // ' surfaces'
      return
    end if
    kept%path = ''
    if (allocated(options%keep_file)) kept%path = options%keep_file
    kept%heading = 'asperity ' // version // ' study, specification ' // checksum(spec%text)
    kept%piece = 'surface'
    kept%of_what = 'this specification'
    kept%part = options%part
    kept%parts = options%parts
    if (allocated(options%more_files)) kept%more = options%more_files
    call begin_work(kept, members, options%all_images, failure)
    if (.not. allocated(failure)) call take_records(kept, numbers, failure)
    if (allocated(failure)) return
    do m = 1, 2
      call plan_surface(spec%surfaces, m, plans(m))
    end do
    call progress%begin(options%progress, 'surfaces', members, kept%done)
    call cpu_time(begun)
    passes: do pass = 1, 2
      do m = 1, members
        if (.not. is_due(kept, m)) cycle
        if (kept%is_shared) then
          if (read_mark(mark_of_failure) < m) exit
        end if
        surface = whole_number(m, options%part, options%parts)
        call study_surface(spec, plan, plans, surface, numbers(:, m), failure)
        if (allocated(failure)) failure = 'surface ' // decimal_text(surface) // ': ' // failure
        if (kept%is_packed .and. .not. allocated(failure)) &
          call keep_record(kept, m, transfer(numbers(:, m), [0_int64]), failure)
        if (allocated(failure)) exit
        call progress%step()
      end do
      if (.not. kept%is_shared) exit passes
      if (allocated(failure)) call set_mark(mark_of_failure, min(m, read_mark(mark_of_failure)))
      ! Image 1 takes the surfaces of the others, and studies those that are missing.
      call share_work(kept, failure)
      if (image_number() > 1 .or. allocated(failure)) exit passes
      call take_records(kept, numbers, failure)
    end do passes
    call progress%finish()
    call close_work(kept)
    call cpu_time(ended)
    if (allocated(failure)) then
      return
    else if (image_number() == 1 .and. options%parts == 1) then
      call evaluate_study(spec, plan, numbers, study)
      study%begun = begun
      study%ended = ended
      associate (area => max(study%integral(area_per_area), study%sizes(1)%mean(area_per_area)))
        if (area > 1.0_real64) failure = 'the contact area is ' // real_text(area) // &
          ' times the nominal area: increase the separation or reduce radii or density'
      end associate
    end if
  end subroutine run_area_study

  ! Studies one surface. `failure` is allocated when it cannot be made or solved.
  ! A contact counts for a section when its point lies in it, wherever the two asperities stand: the
  ! contacts of sections side by side add up to those of the whole.
  subroutine study_surface(spec, plan, plans, member, numbers, failure)
    type(study_spec), intent(in) :: spec
    type(study_plan), intent(in) :: plan
    type(surface_plan), intent(in) :: plans(2)
    integer, intent(in) :: member
    real(real64), intent(out) :: numbers(:)
    character(len=:), allocatable, intent(out) :: failure
    type(scene) :: pressed
    type(scene_results) :: results
    real(real64) :: corner(2)
    logical, allocatable :: inside(:)
    integer :: i, k, at

    numbers = 0.0_real64
    call make_side(1, pressed%upper)
    call make_side(2, pressed%lower)
    if (allocated(failure)) return
    numbers(:leading_numbers) = [asperities_on_area(pressed%upper), &
                                 asperities_on_area(pressed%lower)]
    pressed%file = spec%surfaces%file
    pressed%loading%control = control_separation
    pressed%loading%value = plan%separation
    pressed%limit%criterion = criterion_none
    call solve(pressed, results, failure)
    if (allocated(failure)) return
    do i = 1, size(plan%sizes)
      do k = 1, plan%sections(i)
        at = plan%first(i) + quantities * (k - 1)
        corner = section_corner(spec, plan, i, member, k)
        associate (contacts => results%positions(1)%rows)
          inside = contacts%x >= corner(1) .and. contacts%x < corner(1) + plan%sizes(i) .and. &
                   contacts%y >= corner(2) .and. contacts%y < corner(2) + plan%sizes(i)
          numbers(at + contacts_per_area) = count(inside)
          numbers(at + area_per_area) = sum(contacts%area, inside)
          numbers(at + load_per_area) = sum(contacts%load, inside)
          numbers(at + vertical_per_area) = sum(contacts%vertical_load, inside)
        end associate
        numbers(at + 1:at + quantities) = numbers(at + 1:at + quantities) / plan%sizes(i)**2
      end do
    end do
    if (.not. all(abs(numbers) <= huge(numbers)) .or. &
        any(numbers > 0.0_real64 .and. numbers < tiny(numbers))) &
      failure = 'a result is beyond the range of a double, expected other units'

  contains

    subroutine make_side(side, surface)
      integer, intent(in) :: side
      type(scene_surface), intent(inout) :: surface
      type(generated_surface) :: made

      if (allocated(failure)) return
      if (side == 2 .and. spec%against == against_plane) then
        surface = plane_surface()
      else
        call generate_surface(plans(side), member, made, failure)
        if (allocated(failure)) return
        call made%reals(surface%x, surface%y, surface%height, surface%radius)
      end if
      surface%file = spec%surfaces%file
      surface%elastic_modulus = spec%elastic_modulus(side)
      surface%poisson_ratio = spec%poisson_ratio(side)
    end subroutine make_side

    ! Asperities on an area, in the studied region.
    pure real(real64) function asperities_on_area(surface)
      type(scene_surface), intent(in) :: surface

      asperities_on_area = count(surface%x >= plan%corner(1) .and. surface%y >= plan%corner(2) &
                                 .and. surface%x < plan%corner(1) + plan%extent(1) .and. &
                                 surface%y < plan%corner(2) + plan%extent(2)) / product(plan%extent)
    end function asperities_on_area

  end subroutine study_surface

  ! Takes the surfaces of the file.
  subroutine take_records(kept, numbers, failure)
    type(kept_work), intent(inout) :: kept
    real(real64), intent(inout) :: numbers(:, :)
    character(len=:), allocatable, intent(out) :: failure
    integer(int64), allocatable :: words(:)
    integer :: m

    do
      call next_record(kept, m, words, failure)
      if (m == 0) exit
      numbers(:, m) = transfer(words, numbers, size(numbers, 1))
    end do
  end subroutine take_records

  !> Evaluates the numbers of all surfaces.
  pure subroutine evaluate_study(spec, plan, numbers, study)
    type(study_spec), intent(in) :: spec        !! checked specification of the study
    type(study_plan), intent(in) :: plan        !! plan of the study
    real(real64), intent(in) :: numbers(:, :)   !! a column a surface, from study_surface
    type(area_study), intent(out) :: study      !! results of the study
    type(greenwood_law) :: law
    real(real64), allocatable :: values(:, :, :)  ! quantity, section, surface
    logical, allocatable :: within(:, :, :)
    real(real64) :: of_surface(size(numbers, 2)), unit
    integer :: i, q

    study%surfaces = size(numbers, 2)
    study%separation = decimal_to_real64(plan%separation)
    study%plan = plan
    study%density = sum(numbers(:leading_numbers, :), 2) / study%surfaces
    law = plan%law
    law%density = study%density
    study%integral = densities_at(law, study%separation)
    study%shallow = densities_at(law, study%separation, shallow=.true.)
    allocate (study%sizes(size(plan%sizes)))
    study%reference = study%integral
    do i = 1, size(plan%sizes)
      associate (from => plan%first(i), found => study%sizes(i))
        found%side = plan%sizes(i)
        values = reshape(numbers(from + 1:from + quantities * plan%sections(i), :), &
                         [quantities, plan%sections(i), study%surfaces])
        found%sections = size(values, 2) * size(values, 3)
        do q = 1, quantities
          ! Sections of one surface are not independent, so the error comes from the means of the
          ! surfaces, which are.
          of_surface = sum(values(q, :, :), 1) / size(values, 2)
          found%mean(q) = sum(of_surface) / size(of_surface)
          ! A power of two near the largest: squares stay in range in any unit, and lose no digit.
          unit = set_exponent(1.0_real64, exponent(maxval(abs(values(q, :, :)))))
          found%deviation(q) = unit * sqrt(sum(((values(q, :, :) - found%mean(q)) / unit)**2) / &
                                           max(1, found%sections - 1))
          found%error(q) = unit * sqrt(sum(((of_surface - found%mean(q)) / unit)**2) / &
                                       max(1, size(of_surface) - 1) / size(of_surface))
        end do
        if (i == 1 .and. spec%reference == reference_largest) study%reference = found%mean
        ! Shares of the sections that are as near to the reference as wanted.
        associate (reference => spread(spread(study%reference, 2, size(values, 2)), 3, &
                                       size(values, 3)))
          within = abs(values - reference) <= spec%tolerance * reference
        end associate
        do q = 1, quantities
          found%within(q) = real(count(within(q, :, :)), real64) / found%sections
        end do
        found%all_within = real(count(all(within, 1)), real64) / found%sections
      end associate
    end do
    ! The least size from which on up all are good.
    do i = 1, size(plan%sizes)
      if (study%sizes(i)%all_within < spec%confidence) exit
      study%representative = i
    end do
    study%estimated_side = estimated_side(study, spec%tolerance, spec%confidence)
  end subroutine evaluate_study

  !> The side at which the quantity that spreads most would be within the tolerance: its deviation
  !> times the side is nearly the same for all sizes, as contacts far apart do not influence each
  !> other. Averaged over the sizes by their number of sections; errors taken as normal.
  pure real(real64) function estimated_side(study, tolerance, confidence)
    type(area_study), intent(in) :: study
    real(real64), intent(in) :: tolerance, confidence
    real(real64) :: constant(quantities), weight
    integer :: i

    estimated_side = 0.0_real64
    if (.not. minval(study%reference) > 0.0_real64) return
    constant = 0.0_real64
    weight = 0.0_real64
    do i = 1, size(study%sizes)
      constant = constant + study%sizes(i)%sections * &
                 (study%sizes(i)%deviation / study%reference * &
                  (study%sizes(i)%side / study%sizes(1)%side))**2
      weight = weight + study%sizes(i)%sections
    end do
    constant = sqrt(constant / weight)
    estimated_side = maxval(constant) * study%sizes(1)%side * two_sided(confidence) / tolerance
  end function estimated_side

  !> So many deviations around the mean hold the share of a normal law.
  pure real(real64) function two_sided(share)
    real(real64), intent(in) :: share
    real(real64) :: low, high
    integer :: i

    low = 0.0_real64
    high = 9.0_real64
    do i = 1, 60
      two_sided = (low + high) / 2
      if (erf(two_sided / sqrt(2.0_real64)) < share) then
        low = two_sided
      else
        high = two_sided
      end if
    end do
  end function two_sided

  !> Makes the plan. `failure` is allocated when the specification cannot be studied.
  subroutine plan_study(spec, plan, failure)
    type(study_spec), intent(in) :: spec                   !! checked specification of the study
    type(study_plan), intent(out) :: plan                  !! plan of the study
    character(len=:), allocatable, intent(out) :: failure  !! reason of a failure
    real(real64) :: separation, margin, depth, whole, along(2)
    integer :: i

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
  end subroutine plan_study

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

end module asperity_area_study
