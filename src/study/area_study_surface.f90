!> One surface of the ensemble: made, brought into contact, and cut into sections.
!>
!> A contact counts for a section when its point lies in it, wherever the two asperities stand: the
!> contacts of sections side by side add up to those of the whole.
module asperity_area_study_surface
  use asperity_area_study_plan, only: section_places, section_square, study_plan
  use asperity_constants, only: pi
  use asperity_contact_records, only: contact_row
  use asperity_decimal, only: decimal_to_real64
  use asperity_generated_surface, only: generate_surface, generated_surface, plan_surface, &
                                        surface_plan
  use asperity_greenwood_integrals, only: area_per_area, contacts_per_area, load_per_area, &
                                          quantities, vertical_per_area
  use asperity_kinds, only: real64
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: body_compliance, control_separation, criterion_none, scene, &
                                   scene_surface
  use asperity_solve, only: solve
  use asperity_study_spec, only: against_plane, study_spec
  implicit none
  private

  public :: numbers_of_a_surface, study_surface, prepare_surfaces

  !> The studied numbers of a surface before those of its sections: asperities of the upper and of
  !> the lower surface in the studied region, on an area.
  integer, parameter, public :: leading_numbers = 2

  character(len=*), parameter :: beyond_range = &
    'a result is beyond the range of a double, expected other units'

contains

  !> How many numbers a surface has: the leading ones, then `quantities` for every section.
  pure integer function numbers_of_a_surface(plan)
    type(study_plan), intent(in) :: plan  !! plan of the study

    numbers_of_a_surface = leading_numbers + quantities * plan%total
  end function numbers_of_a_surface

  !> Plans the surfaces of the ensemble.
  pure subroutine prepare_surfaces(spec, plans)
    type(study_spec), intent(in) :: spec            !! checked specification of the study
    type(surface_plan), intent(out) :: plans(2)     !! upper and lower side

    call plan_surface(spec%surfaces, 1, plans(1))
    call plan_surface(spec%surfaces, 2, plans(2))
  end subroutine prepare_surfaces

  !> Studies one surface. `failure` is allocated when it cannot be made or solved.
  subroutine study_surface(spec, plan, plans, member, numbers, failure)
    type(study_spec), intent(in) :: spec                   !! checked specification of the study
    type(study_plan), intent(in) :: plan                   !! plan of the study
    type(surface_plan), intent(in) :: plans(2)             !! plans by `prepare_surfaces`
    integer, intent(in) :: member                          !! which surface, from 1
    real(real64), intent(out) :: numbers(:)                !! leading ones, sections of all sizes
    character(len=:), allocatable, intent(out) :: failure  !! reason of a failure
    type(scene) :: pressed
    type(scene_results) :: results
    type(contact_row), allocatable :: contacts(:)
    type(section_square), allocatable :: squares(:)
    integer :: i, at

    numbers = 0.0_real64
    call make_side(1, pressed%upper)
    if (spec%against /= against_plane) call make_side(2, pressed%lower)
    if (allocated(failure)) return
    numbers(1) = asperities_on_area(pressed%upper)
    if (spec%against == against_plane) then
      call press_on_plane(spec, plan, pressed%upper, contacts)
      if (any(min(contacts%load, contacts%area) < tiny(numbers))) failure = beyond_range
    else
      numbers(2) = asperities_on_area(pressed%lower)
      pressed%file = spec%surfaces%file
      pressed%loading%control = control_separation
      pressed%loading%value = plan%separation
      pressed%limit%criterion = criterion_none
      call solve(pressed, results, failure)
      if (allocated(failure)) return
      call move_alloc(results%positions(1)%rows, contacts)
    end if
    at = leading_numbers
    do i = 1, size(plan%sizes)
      call section_places(spec, plan, i, member, squares)
      call cut_sections(contacts, squares, plan%sizes(i), &
                        numbers(at + 1:at + quantities * size(squares)))
      at = at + quantities * size(squares)
    end do
    if (.not. all(abs(numbers) <= huge(numbers)) .or. &
        any(numbers > 0.0_real64 .and. numbers < tiny(numbers))) failure = beyond_range

  contains

    subroutine make_side(side, surface)
      integer, intent(in) :: side
      type(scene_surface), intent(inout) :: surface
      type(generated_surface) :: made

      if (allocated(failure)) return
      call generate_surface(plans(side), member, made, failure)
      if (allocated(failure)) return
      call made%reals(surface%x, surface%y, surface%height, surface%radius)
      surface%file = spec%surfaces%file
      surface%elastic_modulus = spec%elastic_modulus(side)
      surface%poisson_ratio = spec%poisson_ratio(side)
    end subroutine make_side

    !> Asperities on an area, in the studied region.
    pure real(real64) function asperities_on_area(surface)
      type(scene_surface), intent(in) :: surface

      asperities_on_area = count(surface%x >= plan%corner(1) .and. surface%y >= plan%corner(2) &
                                 .and. surface%x < plan%corner(1) + plan%extent(1) .and. &
                                 surface%y < plan%corner(2) + plan%extent(2)) / &
                           product(plan%extent)
    end function asperities_on_area

  end subroutine study_surface

  !> Contacts of one rough surface with a plane: each asperity by Hertz's law (Greenwood and
  !> Williamson 1966).
  subroutine press_on_plane(spec, plan, surface, contacts)
    type(study_spec), intent(in) :: spec
    type(study_plan), intent(in) :: plan
    type(scene_surface), intent(in) :: surface
    type(contact_row), allocatable, intent(out) :: contacts(:)
    real(real64), allocatable :: overlap(:), radius(:)
    real(real64) :: separation, modulus

    separation = decimal_to_real64(plan%separation)
    modulus = 1 / sum(body_compliance(spec%elastic_modulus, spec%poisson_ratio))
    overlap = pack(surface%height - separation, surface%height > separation)
    radius = pack(surface%radius, surface%height > separation)
    allocate (contacts(size(overlap)))
    contacts%x = pack(surface%x, surface%height > separation)
    contacts%y = pack(surface%y, surface%height > separation)
    contacts%area = pi * radius * overlap
    contacts%load = 4 * modulus * (overlap * sqrt(overlap * radius)) / 3
    contacts%vertical_load = contacts%load
  end subroutine press_on_plane

  !> Sums over the contacts of each section, over its area.
  pure subroutine cut_sections(contacts, squares, side, numbers)
    type(contact_row), intent(in) :: contacts(:)
    type(section_square), intent(in) :: squares(:)
    real(real64), intent(in) :: side
    real(real64), intent(out) :: numbers(:)
    real(real64) :: sums(quantities)
    logical :: inside(size(contacts))
    integer :: k

    do k = 1, size(squares)
      inside = contacts%x >= squares(k)%x .and. contacts%x < squares(k)%x + side .and. &
               contacts%y >= squares(k)%y .and. contacts%y < squares(k)%y + side
      sums(contacts_per_area) = count(inside)
      sums(area_per_area) = sum(contacts%area, inside)
      sums(load_per_area) = sum(contacts%load, inside)
      sums(vertical_per_area) = sum(contacts%vertical_load, inside)
      numbers(quantities * (k - 1) + 1:quantities * k) = sums / side**2
    end do
  end subroutine cut_sections

end module asperity_area_study_surface
