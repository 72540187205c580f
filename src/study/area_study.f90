!> The study of the representative area: the surfaces of an ensemble, shared out over the images;
!> means and standard deviations over their sections, and the size that represents the whole.
module asperity_area_study
  use asperity_area_study_plan, only: leading_numbers, section_corner, study_plan
  use asperity_contact_records, only: contact_row
  use asperity_decimal, only: decimal_to_real64
  use asperity_generated_surface, only: generate_surface, generated_surface, plan_surface, &
                                        surface_plan
  use asperity_greenwood_integrals, only: area_per_area, contacts_per_area, densities_at, &
                                          greenwood_law, load_per_area, quantities, &
                                          vertical_per_area
  use asperity_images, only: image_number, mark_of_failure, read_mark, set_mark
  use asperity_kept_records, only: begin_work, checksum, close_work, is_due, keep_record, &
                                   kept_work, next_record, pieces_of_part, share_work, whole_number
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text, real_text
  use asperity_progress, only: progress_line
  use asperity_run_options, only: run_options
  use asperity_scene_results, only: scene_results
  use asperity_scene_surfaces, only: plane_surface
  use asperity_scene_values, only: control_separation, criterion_none, scene, scene_surface
  use asperity_solve, only: solve
  use asperity_study_spec, only: against_plane, reference_largest, study_spec
  use asperity_version, only: version
  implicit none
  private

  public :: area_study, size_result, evaluate_study, run_area_study

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
    real(real64) :: corner(2) = 0.0_real64             !! of the studied region
    real(real64) :: extent(2) = 0.0_real64             !! of the studied region
    real(real64) :: design_density(2) = 0.0_real64     !! asperities on an area, as specified
    real(real64) :: density(2) = 0.0_real64            !! the same, in the studied region
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
        numbers(at + 1:at + quantities) = add_section(results%positions(1)%rows, &
          section_corner(spec, plan, i, member, k), plan%sizes(i))
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

  ! Sums over the contacts of a section, over its area.
  pure function add_section(contacts, corner, side) result(sums)
    type(contact_row), intent(in) :: contacts(:)
    real(real64), intent(in) :: corner(2), side
    real(real64) :: sums(quantities)
    logical :: inside(size(contacts))

    inside = contacts%x >= corner(1) .and. contacts%x < corner(1) + side .and. &
             contacts%y >= corner(2) .and. contacts%y < corner(2) + side
    sums(contacts_per_area) = count(inside)
    sums(area_per_area) = sum(contacts%area, inside)
    sums(load_per_area) = sum(contacts%load, inside)
    sums(vertical_per_area) = sum(contacts%vertical_load, inside)
    sums = sums / side**2
  end function add_section

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
    integer :: i

    study%surfaces = size(numbers, 2)
    study%separation = decimal_to_real64(plan%separation)
    study%corner = plan%corner
    study%extent = plan%extent
    study%design_density = plan%law%density
    study%density = sum(numbers(:leading_numbers, :), 2) / study%surfaces
    law = plan%law
    law%density = study%density
    study%integral = densities_at(law, study%separation)
    study%shallow = densities_at(law, study%separation, shallow=.true.)
    allocate (study%sizes(size(plan%sizes)))
    do i = 1, size(plan%sizes)
      study%sizes(i)%side = plan%sizes(i)
      call take_means(sections_of(i), study%sizes(i))
    end do
    study%reference = study%integral
    if (spec%reference == reference_largest) study%reference = study%sizes(1)%mean
    do i = 1, size(plan%sizes)
      call count_within(sections_of(i), study%reference, spec%tolerance, study%sizes(i))
    end do
    ! The least size from which on up all are good.
    do i = 1, size(plan%sizes)
      if (study%sizes(i)%all_within < spec%confidence) exit
      study%representative = i
    end do
    study%estimated_side = estimated_side(study, spec%tolerance, spec%confidence)

  contains

    !> The sections of a size: quantity, section, surface.
    pure function sections_of(number) result(values)
      integer, intent(in) :: number
      real(real64) :: values(quantities, plan%sections(number), size(numbers, 2))

      associate (from => plan%first(number))
        values = reshape(numbers(from + 1:from + quantities * plan%sections(number), :), &
                         shape(values))
      end associate
    end function sections_of

  end subroutine evaluate_study

  ! Means, deviations and standard errors. Sections of one surface are not independent, so the
  ! error comes from the means of the surfaces, which are.
  pure subroutine take_means(values, result)
    real(real64), intent(in) :: values(:, :, :)
    type(size_result), intent(inout) :: result
    real(real64) :: of_surface(size(values, 3)), unit
    integer :: q

    result%sections = size(values, 2) * size(values, 3)
    do q = 1, quantities
      of_surface = sum(values(q, :, :), 1) / size(values, 2)
      result%mean(q) = sum(of_surface) / size(of_surface)
      ! A power of two near the largest: squares stay in range in any unit, and lose no digit.
      unit = set_exponent(1.0_real64, exponent(maxval(abs(values(q, :, :)))))
      result%deviation(q) = unit * sqrt(sum(((values(q, :, :) - result%mean(q)) / unit)**2) / &
                                        max(1, result%sections - 1))
      result%error(q) = unit * sqrt(sum(((of_surface - result%mean(q)) / unit)**2) / &
                                    max(1, size(of_surface) - 1) / size(of_surface))
    end do
  end subroutine take_means

  ! Shares of the sections that are as near to the reference as wanted.
  pure subroutine count_within(values, reference, tolerance, result)
    real(real64), intent(in) :: values(:, :, :), reference(quantities), tolerance
    type(size_result), intent(inout) :: result
    logical, allocatable :: within(:, :, :)
    integer :: q

    allocate (within(quantities, size(values, 2), size(values, 3)))
    do q = 1, quantities
      within(q, :, :) = abs(values(q, :, :) - reference(q)) <= tolerance * reference(q)
      result%within(q) = real(count(within(q, :, :)), real64) / result%sections
    end do
    result%all_within = real(count(all(within, 1)), real64) / result%sections
  end subroutine count_within

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

end module asperity_area_study
