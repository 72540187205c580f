!> The study of the representative area: surfaces of an ensemble, shared out over the images.
module asperity_area_study
  use asperity_area_study_plan, only: study_plan
  use asperity_area_study_statistics, only: area_study, evaluate_study
  use asperity_area_study_surface, only: numbers_of_a_surface, prepare_surfaces, study_surface
  use asperity_generated_surface, only: surface_plan
  use asperity_images, only: image_number
  use asperity_kept_records, only: checksum, kept_work, pieces_of_part, whole_number, word_record
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text
  use asperity_progress, only: progress_line
  use asperity_run_options, only: run_options
  use asperity_shared_work, only: add_failure, begin_round, begin_work, end_round, &
                                  gather_round, is_own, shared_work
  use asperity_study_spec, only: study_spec
  use asperity_version, only: version
  implicit none
  private

  public :: run_area_study

  ! Surfaces an image studies in one round at most.
  integer, parameter :: most_each = 64

contains

  !> Runs the study: every image studies surfaces, image 1 gathers them in order and keeps them.
  !> Only there `study` is filled, and not by a part. `failure` is allocated on all images alike.
  subroutine run_area_study(spec, plan, options, study, failure)
    type(study_spec), intent(in) :: spec                   !! checked
    type(study_plan), intent(in) :: plan                   !! its plan
    type(run_options), intent(in) :: options               !! its images, progress and kept file
    type(area_study), intent(out) :: study                 !! the results
    character(len=:), allocatable, intent(out) :: failure  !! why not
    type(surface_plan) :: plans(2)
    type(kept_work) :: kept
    type(shared_work) :: work
    type(progress_line) :: progress
    real(real64), allocatable :: numbers(:, :)
    real(real64) :: begun, ended
    logical :: going_on
    integer :: members, many, m, status, surface

    members = pieces_of_part(spec%surfaces%ensemble, options%part, options%parts)
    many = numbers_of_a_surface(plan)
    allocate (numbers(many, members), source=0.0_real64, stat=status)
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
    call begin_work(work, members, options%all_images, kept, most_each)
    do m = 1, work%done * merge(1, 0, image_number() == 1)
      call take_surface(work%records(m), numbers(:, m))
    end do
    call prepare_surfaces(spec, plans)
    call progress%begin(options%progress, 'surfaces', members, work%done)
    call cpu_time(begun)
    do
      call begin_round(work, going_on)
      if (.not. going_on) exit
      do m = work%first, work%last
        if (.not. is_own(work, m)) cycle
        surface = whole_number(m, options%part, options%parts)
        call study_surface(spec, plan, plans, surface, numbers(:, m), failure)
        if (allocated(failure)) then
          call add_failure(work, m, 'surface ' // decimal_text(surface) // ': ' // failure)
          exit
        end if
        if (work%packed) work%records(m)%words = transfer(numbers(:, m), [0_int64])
        call progress%step()
      end do
      call gather_round(work)
      do m = work%first, merge(work%last, 0, work%packed .and. image_number() == 1)
        call take_surface(work%records(m), numbers(:, m))
      end do
      call end_round(work)
      call progress%reach(work%done)
    end do
    call progress%finish()
    call cpu_time(ended)
    if (allocated(work%ending)) then
      failure = work%ending
    else if (image_number() == 1 .and. options%parts == 1) then
      call evaluate_study(spec, plan, numbers, study)
      study%begun = begun
      study%ended = ended
    end if
  end subroutine run_area_study

  ! A surface of a former run, or of another image.
  pure subroutine take_surface(record, numbers)
    type(word_record), intent(in) :: record
    real(real64), intent(inout) :: numbers(:)

    if (allocated(record%words)) numbers = transfer(record%words, numbers, size(numbers))
  end subroutine take_surface

end module asperity_area_study
