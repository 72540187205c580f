!> One surface of the ensemble: made, brought into contact, and cut into sections.
!>
!> A contact counts for a section when its point lies in it, wherever the two asperities stand: the
!> contacts of sections side by side add up to those of the whole.
module asperity_area_study_surface
  use asperity_area_study_plan, only: leading_numbers, section_corner, study_plan
  use asperity_contact_records, only: contact_row
  use asperity_generated_surface, only: generate_surface, generated_surface, plan_surface, &
                                        surface_plan
  use asperity_greenwood_integrals, only: area_per_area, contacts_per_area, load_per_area, &
                                          quantities, vertical_per_area
  use asperity_kinds, only: real64
  use asperity_scene_results, only: scene_results
  use asperity_scene_surfaces, only: plane_surface
  use asperity_scene_values, only: control_separation, criterion_none, scene, scene_surface
  use asperity_solve, only: solve
  use asperity_study_spec, only: against_plane, study_spec
  implicit none
  private

  public :: study_surface

contains

  !> Studies one surface. `failure` is allocated when it cannot be made or solved.
  subroutine study_surface(spec, plan, plans, member, numbers, failure)
    type(study_spec), intent(in) :: spec                   !! checked specification of the study
    type(study_plan), intent(in) :: plan                   !! plan of the study
    type(surface_plan), intent(in) :: plans(2)             !! of the upper and the lower side
    integer, intent(in) :: member                          !! which surface, from 1
    real(real64), intent(out) :: numbers(:)                !! leading ones, sections of all sizes
    character(len=:), allocatable, intent(out) :: failure  !! reason of a failure
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

    !> Asperities on an area, in the studied region.
    pure real(real64) function asperities_on_area(surface)
      type(scene_surface), intent(in) :: surface

      asperities_on_area = count(surface%x >= plan%corner(1) .and. surface%y >= plan%corner(2) &
                                 .and. surface%x < plan%corner(1) + plan%extent(1) .and. &
                                 surface%y < plan%corner(2) + plan%extent(2)) / &
                           product(plan%extent)
    end function asperities_on_area

  end subroutine study_surface

  !> Sums over the contacts of a section, over its area.
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

end module asperity_area_study_surface
