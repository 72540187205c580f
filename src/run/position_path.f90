!> The path of a position, for any model of the contact: state after state, each the history of the
!> next.
module asperity_position_path
  use asperity_contact_model, only: contact_model, path_step, placed_bodies
  use asperity_contact_records, only: most_rows, position_result
  use asperity_work_count, only: work_count
  implicit none
  private

  public :: follow_path, solve_position

contains

  !> Solves all states of a position. `failure` is allocated when its end cannot be reached.
  subroutine solve_position(model, m, result, failure)
    class(contact_model), intent(in), target :: model       !! bodies ready to be placed
    integer, intent(in) :: m                                !! position, from 1
    type(position_result), intent(out) :: result            !! states, ending with the last
    character(len=:), allocatable, intent(out) :: failure   !! set where the end is not reached
    class(placed_bodies), allocatable, target :: bodies
    logical :: is_repeat, must_repeat

    is_repeat = .false.
    do
      call model%place(m, is_repeat, bodies, result, failure)
      if (allocated(failure) .or. .not. allocated(bodies)) return
      bodies%keep_rows = model%keep_rows
      call follow_path(bodies, model%progress_count, result, must_repeat, failure)
      if (.not. must_repeat) exit
      call model%progress_count%add_work(-result%counted)
      is_repeat = .true.
    end do
  end subroutine solve_position

  !> Follows the path of placed bodies once.
  subroutine follow_path(bodies, progress_count, result, must_repeat, failure)
    class(placed_bodies), intent(inout), target :: bodies   !! bodies without contact
    type(work_count), intent(in) :: progress_count          !! progress of the run, in states
    type(position_result), intent(inout) :: result          !! without states; gets them
    logical, intent(out) :: must_repeat                     !! whether the path has to be repeated
    character(len=:), allocatable, intent(out) :: failure   !! set where the end is not reached
    type(path_step), allocatable :: steps(:)
    integer :: i

    must_repeat = .false.
    call bodies%list_steps(steps, failure)
    if (allocated(failure)) return
    allocate (result%states(size(steps)), result%rows(0))
    do i = 1, size(steps)
      call bodies%solve_step(steps(i), i, result, must_repeat, failure)
      if (allocated(failure) .or. must_repeat) return
      call progress_count%count_state(result%counted)
      ! The states end early when there are more contacts than can be kept.
      if (result%rows_used > most_rows) return
    end do
    call bodies%add_totals(steps, result, failure)
  end subroutine follow_path

end module asperity_position_path
