!> The study of the representative area: surfaces of an ensemble, shared out over the images.
module asperity_area_study
  use asperity_area_study_plan, only: plan_study, study_plan
  use asperity_area_study_statistics, only: area_study, evaluate_study
  use asperity_area_study_surface, only: numbers_of_a_surface, prepare_surfaces, study_surface
  use asperity_generated_surface, only: surface_plan
  use asperity_image_rounds, only: agree, begin_round, end_round, image_rounds
  use asperity_images, only: gather_numbers, image_count, image_number
  use asperity_kept_records, only: checksum, keep_records, kept_work, number_record, &
                                   resume_records
  use asperity_kinds, only: int64, real64
  use asperity_letters, only: message_numbers, message_to_numbers, numbers_to_message
  use asperity_problems, only: decimal_text
  use asperity_process, only: has_memory
  use asperity_progress, only: begin_progress, end_progress, show_progress
  use asperity_study_spec, only: study_spec
  use asperity_version, only: version
  implicit none
  private

  public :: run_area_study

  ! Surfaces an image studies in one round at most.
  integer, parameter :: most_each = 64

contains

  !> Runs the study. In each round every image studies some surfaces; image 1 gathers them in order
  !> and keeps them. Only there `study` is filled. `failure` is allocated on all images alike.
  subroutine run_area_study(spec, plan, kept_file, study, failure)
    type(study_spec), intent(in) :: spec                   !! checked
    type(study_plan), intent(in) :: plan                   !! its plan
    character(len=*), intent(in) :: kept_file              !! where to keep surfaces, or empty
    type(area_study), intent(out) :: study                 !! the results
    character(len=:), allocatable, intent(out) :: failure  !! why not
    type(surface_plan) :: plans(2)
    type(kept_work) :: kept
    real(real64), allocatable :: numbers(:, :)
    type(image_rounds) :: rounds
    integer :: members, many

    members = spec%surfaces%ensemble
    many = numbers_of_a_surface(plan)
    if (.not. has_memory(8_int64 * int(many, int64) * int(members, int64))) then
      failure = 'not enough memory for the sections of ' // decimal_text(members) // ' surfaces'
      return
    end if
    allocate (numbers(many, members), source=0.0_real64)
    rounds = image_rounds(total=members, most_each=most_each)
    if (kept_file /= '' .and. image_number() == 1) then
      kept = kept_work(kept_file, 'asperity ' // version // ' study, specification ' // &
                       checksum(spec%text), 'surface', 'this specification')
      call resume_surfaces(kept, numbers, rounds%done, failure)
    end if
    call agree(rounds, failure)
    if (allocated(failure)) return
    call prepare_surfaces(spec, plans)
    call begin_progress('surfaces', members, rounds%done)
    do while (rounds%done < members)
      call begin_round(rounds)
      associate (round => numbers(:, rounds%first:rounds%last))
        call study_round(spec, plan, plans, rounds%each, rounds%first, round, failure)
        if (image_number() == 1 .and. kept_file /= '' .and. .not. allocated(failure)) &
          call keep_surfaces(kept, rounds%first, round, failure)
      end associate
      call end_round(rounds, failure)
      call show_progress(rounds%done)
      if (allocated(failure)) exit
    end do
    call end_progress()
    if (allocated(failure)) return
    if (image_number() == 1) call evaluate_study(spec, plan, numbers, study)
  end subroutine run_area_study

  !> Reads the surfaces that a former run kept.
  subroutine resume_surfaces(kept, numbers, done, failure)
    type(kept_work), intent(in) :: kept
    real(real64), intent(inout) :: numbers(:, :)
    integer, intent(inout) :: done
    character(len=:), allocatable, intent(out) :: failure
    type(number_record), allocatable :: records(:)

    allocate (records(0))
    call resume_records(kept, size(numbers, 2), records, failure)
    if (allocated(failure)) return
    do done = 0, size(records) - 1
      if (size(records(done + 1)%numbers) /= size(numbers, 1)) exit
      numbers(:, done + 1) = records(done + 1)%numbers
    end do
  end subroutine resume_surfaces

  !> Keeps surfaces that are done.
  subroutine keep_surfaces(kept, first, numbers, failure)
    type(kept_work), intent(in) :: kept
    integer, intent(in) :: first
    real(real64), intent(in) :: numbers(:, :)
    character(len=:), allocatable, intent(inout) :: failure
    type(number_record) :: records(size(numbers, 2))
    integer :: i

    do i = 1, size(records)
      records(i)%numbers = numbers(:, i)
    end do
    call keep_records(kept, first, records, failure)
  end subroutine keep_surfaces

  !> So many surfaces an image; image 1 gets the numbers of all.
  subroutine study_round(spec, plan, plans, each, first, numbers, failure)
    type(study_spec), intent(in) :: spec
    type(study_plan), intent(in) :: plan
    type(surface_plan), intent(in) :: plans(2)
    integer, intent(in) :: each, first
    real(real64), intent(out) :: numbers(:, :)
    character(len=:), allocatable, intent(out) :: failure
    character(len=:), allocatable :: lost
    real(real64), allocatable :: own(:), all_numbers(:, :)
    integer :: i, k, many, before

    many = size(numbers, 1)
    allocate (own(message_numbers + many * each), source=0.0_real64)
    allocate (all_numbers(size(own), image_count()))
    before = (image_number() - 1) * each
    do k = 1, min(each, size(numbers, 2) - before)
      call study_surface(spec, plan, plans, first + before + k - 1, &
                         own(message_numbers + many * (k - 1) + 1:message_numbers + many * k), &
                         failure)
      if (.not. allocated(failure)) cycle
      failure = 'surface ' // decimal_text(first + before + k - 1) // ': ' // failure
      call message_to_numbers(failure, own(:message_numbers))
      exit
    end do
    call gather_numbers(own, all_numbers, lost)
    do k = 1, size(numbers, 2)
      i = (k - 1) / each
      before = message_numbers + many * (k - 1 - i * each)
      numbers(:, k) = all_numbers(before + 1:before + many, i + 1)
    end do
    ! The first surface that failed is told, as when one image does them all.
    do i = size(all_numbers, 2), 1, -1
      call numbers_to_message(all_numbers(:message_numbers, i), failure)
    end do
    if (allocated(lost)) call move_alloc(lost, failure)
  end subroutine study_round

end module asperity_area_study
