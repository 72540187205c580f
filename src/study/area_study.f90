!> The study of the representative area: surfaces of an ensemble, shared out over the images.
module asperity_area_study
  use asperity_area_study_keep, only: keep_surfaces, resume_kept
  use asperity_area_study_plan, only: plan_study, study_plan
  use asperity_area_study_progress, only: progress_line
  use asperity_area_study_statistics, only: area_study, evaluate_study
  use asperity_area_study_surface, only: numbers_of_a_surface, prepare_surfaces, study_surface
  use asperity_generated_surface, only: surface_plan
  use asperity_images, only: gather_numbers, image_count, image_number, take_from_first
  use asperity_kinds, only: int64, real64
  use asperity_problems, only: decimal_text
  use asperity_process, only: has_memory
  use asperity_study_spec, only: study_spec
  implicit none
  private

  public :: run_area_study

  ! A failure travels between images as numbers: its letters.
  integer, parameter :: longest_failure = 500
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
    type(progress_line) :: progress
    real(real64), allocatable :: numbers(:, :)
    integer :: members, many, done, last, each
    integer(int64) :: start

    members = spec%surfaces%ensemble
    many = numbers_of_a_surface(plan)
    if (.not. has_memory(8_int64 * int(many, int64) * int(members, int64))) then
      failure = 'not enough memory for the sections of ' // decimal_text(members) // ' surfaces'
      return
    end if
    allocate (numbers(many, members), source=0.0_real64)
    done = 0
    if (kept_file /= '' .and. image_number() == 1) &
      call resume_kept(kept_file, spec%text, numbers, done, failure)
    each = 1
    call agree(done, each, failure)
    if (allocated(failure)) return
    call prepare_surfaces(spec, plans)
    if (image_number() == 1) call progress%begin('surfaces', done, members)
    do while (done < members)
      call system_clock(start)
      last = int(min(int(members, int64), done + int(each, int64) * image_count()))
      call study_round(spec, plan, plans, each, done + 1, numbers(:, done + 1:last), failure)
      if (image_number() == 1 .and. kept_file /= '' .and. .not. allocated(failure)) &
        call keep_surfaces(kept_file, done + 1, numbers(:, done + 1:last), failure)
      done = last
      each = next_number(each, start)
      call agree(done, each, failure)
      call progress%tell(done)
      if (allocated(failure)) exit
    end do
    call progress%finish()
    if (allocated(failure)) return
    if (image_number() == 1) call evaluate_study(spec, plan, numbers, study)
  end subroutine run_area_study

  !> How many surfaces an image shall study in the next round: what takes about a second. Results
  !> do not depend on it.
  integer function next_number(each, start)
    integer, intent(in) :: each
    integer(int64), intent(in) :: start
    integer(int64) :: now, rate

    call system_clock(now, rate)
    next_number = each
    if (2 * (now - start) < rate) next_number = min(2 * each, most_each)
    if (now - start > 2 * rate) next_number = max(each / 2, 1)
  end function next_number

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
    allocate (own(1 + max(many * each, longest_failure)), source=0.0_real64)
    allocate (all_numbers(size(own), image_count()))
    before = (image_number() - 1) * each
    do k = 1, min(each, size(numbers, 2) - before)
      call study_surface(spec, plan, plans, first + before + k - 1, &
                         own(many * (k - 1) + 2:many * k + 1), failure)
      if (.not. allocated(failure)) cycle
      failure = 'surface ' // decimal_text(first + before + k - 1) // ': ' // failure
      call to_letters(failure, own)
      exit
    end do
    call gather_numbers(own, all_numbers, lost)
    do k = 1, size(numbers, 2)
      i = (k - 1) / each
      numbers(:, k) = all_numbers(many * (k - 1 - i * each) + 2:many * (k - i * each) + 1, i + 1)
    end do
    ! The first surface that failed is told, as when one image does them all.
    do i = size(all_numbers, 2), 1, -1
      call from_letters(all_numbers(:, i), failure)
    end do
    if (allocated(lost)) call move_alloc(lost, failure)
  end subroutine study_round

  !> Brings what image 1 knows to all: how many surfaces are done, how many an image shall do next,
  !> or why it cannot go on.
  subroutine agree(done, each, failure)
    integer, intent(inout) :: done, each
    character(len=:), allocatable, intent(inout) :: failure
    character(len=:), allocatable :: lost
    real(real64) :: packet(3 + longest_failure)

    packet = 0.0_real64
    call to_letters(failure, packet(3:))
    packet(:2) = real([done, each], real64)
    call take_from_first(packet, lost)
    done = nint(packet(1))
    each = nint(packet(2))
    call from_letters(packet(3:), failure)
    if (allocated(lost)) call move_alloc(lost, failure)
  end subroutine agree

  !> A failure as numbers: how many letters, and these. Without one the numbers stay.
  pure subroutine to_letters(failure, numbers)
    character(len=:), allocatable, intent(in) :: failure
    real(real64), intent(inout) :: numbers(:)
    integer :: i, used

    if (.not. allocated(failure)) return
    used = min(len(failure), longest_failure)
    numbers(1) = real(used, real64)
    do i = 1, used
      numbers(1 + i) = real(iachar(failure(i:i)), real64)
    end do
  end subroutine to_letters

  !> The failure in such numbers; one that is known stays when they hold none.
  pure subroutine from_letters(numbers, failure)
    real(real64), intent(in) :: numbers(:)
    character(len=:), allocatable, intent(inout) :: failure
    integer :: i, used

    used = nint(numbers(1))
    if (used == 0) return
    if (allocated(failure)) deallocate (failure)
    allocate (character(len=used) :: failure)
    do i = 1, used
      failure(i:i) = achar(nint(numbers(1 + i)))
    end do
  end subroutine from_letters

end module asperity_area_study
