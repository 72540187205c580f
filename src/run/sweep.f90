!> Sweep over the positions of a scene: they are distributed to images and threads, and kept in a
!> file when they are solved. The result does not depend on the numbers of images and threads.
!>
!> The reported failure does not depend on the number of threads: it is that of the first position
!> in order that fails, or at which there are too many contacts. Later positions are left out.
!> Without OpenMP there is one thread.
module asperity_sweep
  use asperity_contact_model, only: contact_model
  use asperity_contact_records, only: are_finite, most_rows, position_result, room_of_a_state
  use asperity_images, only: image_count, image_number, mark_of_failure, read_mark, set_mark
  use asperity_interruption, only: interruption
  use asperity_kept_records, only: begin_work, close_work, is_due, keep_record, kept_work, &
                                   next_record, pieces_of_part, share_work, whole_number
  use asperity_kinds, only: int64, real64
  use asperity_loads_met, only: check_loads, check_meaning, compare_loads
  use asperity_position_packet, only: pack_position, unpack_position
  use asperity_position_path, only: solve_position
  use asperity_problems, only: decimal_text, not_enough_memory
  use asperity_process, only: check_memory
  use asperity_progress, only: progress_line
  use asperity_run_options, only: run_options
  use asperity_scene_inputs, only: input_file, list_inputs
  use asperity_scene_results, only: name_columns, scene_results
  use asperity_scene_values, only: scene
  use asperity_version, only: version
  !$ use omp_lib, only: omp_get_max_threads
  implicit none
  private

  public :: sweep_scene

  ! Least work for threads, positions times asperities: less is done before they have started.
  integer(int64), parameter :: least_work = 30000_int64

  ! Largest relative difference of a load from the prescribed one.
  real(real64), parameter :: load_precision = 1.0e-6_real64

  ! State of the sweep, common to all threads.
  type :: sweep_watch
    integer :: last = 0            ! positions after this one are not solved
    integer :: highest = 0         ! highest position that is solved
    integer :: start = 1           ! first position of the part in the scene
    integer :: stride = 1          ! step to the next position of the part
    integer(int64) :: rows = 0_int64  ! contacts kept so far
    type(progress_line) :: progress
    type(kept_work) :: kept
    integer :: failed = huge(1)    ! first position that failed
    character(len=:), allocatable :: failure  ! reason of its failure
    character(len=:), allocatable :: ending   ! reason why no result can be kept
    type(interruption) :: interrupt
  end type sweep_watch

contains

  !> Solves the positions of a scene and keeps them in the file of the options.
  subroutine sweep_scene(scene_in, options, model, results, failure)
    type(scene), intent(in) :: scene_in                    !! scene, checked for faults
    type(run_options), intent(in) :: options               !! options of the run
    class(contact_model), intent(inout), target :: model   !! bodies; get the options
    type(scene_results), intent(inout) :: results          !! results with all positions
    character(len=:), allocatable, intent(out) :: failure  !! reason, when a position is not solved
    type(kept_work) :: kept
    type(input_file) :: inputs(3)
    integer :: i

    model%keep_rows = options%keep_contacts
    model%interrupt = options%interrupt
    model%progress_count = options%counted_work
    model%progress_count%of_position = max(1, model%states)
    model%nominal_area = max(scene_in%nominal_area, results%nominal_area)
    kept%path = ''
    if (allocated(options%keep_file)) kept%path = options%keep_file
    kept%piece = 'position'
    kept%heading = 'asperity ' // version
    if (kept%path /= '') then
      ! A file of kept positions is identified by all input files of the scene, and all options that
      ! change the results. Every image reads the files, so that a failure occurs on all images and
      ! no image stays in a barrier.
      kept%part = options%part
      kept%parts = options%parts
      if (allocated(options%more_files)) kept%more = options%more_files
      kept%of_what = 'this scene and list of contacts'
      call list_inputs(scene_in, inputs, failure)
      if (allocated(failure)) return
      kept%heading = kept%heading // ' solve, contacts ' // &
                     trim(merge('kept  ', 'summed', options%keep_contacts)) // ', input'
      do i = 1, size(inputs)
        kept%heading = kept%heading // ' ' // inputs(i)%checksum
      end do
    end if
    call run_sweep(model, options, kept, results%positions, failure)
    if (.not. allocated(failure)) call name_columns(results)
  end subroutine sweep_scene

  ! Solves every position. On image 1 `positions` has all of them, in order; on other images their
  ! own. `failure` is allocated, with the position, when one cannot be solved, or when an image
  ! fails.
  subroutine run_sweep(model, options, kept, positions, failure)
    class(contact_model), intent(in), target :: model
    type(run_options), intent(in) :: options
    type(kept_work), intent(in) :: kept
    type(position_result), allocatable, intent(out) :: positions(:)
    character(len=:), allocatable, intent(out) :: failure
    type(sweep_watch) :: watch
    integer(int64) :: states
    integer :: first, last, m, number, pass, threads

    number = model%positions
    if (options%parts > 1) then
      number = pieces_of_part(number, options%part, options%parts)
      watch%start = options%part
      watch%stride = options%parts
    end if
    states = int(number, int64) * int(max(1, model%states), int64)
    call check_memory(decimal_text(number) // ' positions', failure, &
                      bytes=states * int(room_of_a_state, int64))
    if (allocated(failure)) return
    allocate (positions(number))
    threads = threads_for(model, options)
    watch%last = number
    watch%interrupt = options%interrupt
    watch%kept = kept
    call begin_work(watch%kept, number, options%all_images, failure)
    if (.not. allocated(failure)) call take_records(watch%kept, positions, failure)
    if (allocated(failure)) return
    if (allocated(kept%more) .and. sum(int(positions%rows_used, int64)) > most_rows) then
      call refuse_rows(failure)
      return
    end if
    call watch%progress%begin(options%progress, 'positions', number, watch%kept%done)
    call model%progress_count%begin_count(int(min(states, int(huge(number), int64))), &
                                  watch%kept%done * model%progress_count%of_position)
    do pass = 1, 2
      last = 0
      do while (last < number)
        first = last + 1
        last = number
        if (watch%kept%is_shared) then
          if (read_mark(mark_of_failure) < first) exit
          last = min(number, last_of_chunk(first, threads))
        end if
        if (threads > 1) then
          !$omp parallel do schedule(dynamic) num_threads(threads)
          do m = first, last
            if (is_wanted(watch, m)) call solve_one(model, m, positions(m), watch)
          end do
          !$omp end parallel do
        else
          ! Outside a parallel region: nested regions would start their threads at each position.
          do m = first, last
            if (is_wanted(watch, m)) call solve_one(model, m, positions(m), watch)
          end do
        end if
        if (watch%kept%is_shared .and. watch%failed < huge(1)) &
          call set_mark(mark_of_failure, min(watch%failed, read_mark(mark_of_failure)))
      end do
      if (.not. watch%kept%is_shared .or. pass == 2) exit
      ! Image 1 takes the positions of the others, and solves those that are missing.
      call share_work(watch%kept, failure)
      if (image_number() == 1 .and. .not. allocated(failure)) &
        call take_records(watch%kept, positions, failure)
      if (image_number() > 1 .or. allocated(failure)) exit
    end do
    call watch%progress%finish()
    call close_work(watch%kept)
    if (allocated(failure)) return
    if (image_number() == 1) then
      call find_failure(watch, positions, failure)
    else if (watch%failed < huge(1)) then
      failure = watch%failure
    end if
    if (allocated(watch%ending)) failure = watch%ending
    if (watch%interrupt%is_asked()) failure = 'interrupted'
  end subroutine run_sweep

  ! Last position before images look whether another one has failed.
  pure integer function last_of_chunk(first, threads) result(last)
    integer, intent(in) :: first, threads
    integer, parameter :: pieces_of_thread = 16

    last = int(min(int(huge(1), int64), int(first, int64) - 1 + &
                   int(pieces_of_thread, int64) * threads * image_count()))
  end function last_of_chunk

  ! Takes the positions of the file.
  subroutine take_records(kept, positions, failure)
    type(kept_work), intent(inout) :: kept
    type(position_result), intent(inout) :: positions(:)
    character(len=:), allocatable, intent(out) :: failure
    integer(int64), allocatable :: words(:)
    integer :: m

    do
      call next_record(kept, m, words, failure)
      if (m == 0) exit
      if (image_number() == 1) call unpack_position(words, positions(m))
    end do
  end subroutine take_records

  ! Number of threads for the positions, at least one.
  integer function threads_for(model, options) result(threads)
    class(contact_model), intent(in), target :: model
    type(run_options), intent(in) :: options

    threads = 1
    if (options%threads > 0) then
      threads = options%threads
    else
      !$ if (model%work >= least_work / model%positions) threads = omp_get_max_threads()
    end if
    threads = min(threads, model%positions)
  end function threads_for

  ! Whether a position is to be solved by this image.
  logical function is_wanted(watch, m)
    type(sweep_watch), intent(in) :: watch
    integer, intent(in) :: m
    integer :: last

    !$omp atomic read
    last = watch%last
    is_wanted = m <= last .and. is_due(watch%kept, m) .and. .not. watch%interrupt%is_asked()
  end function is_wanted

  ! Solves and checks one position in one thread.
  subroutine solve_one(model, m, position, watch)
    class(contact_model), intent(in), target :: model
    integer, intent(in) :: m
    type(position_result), intent(inout) :: position
    type(sweep_watch), intent(inout) :: watch
    character(len=:), allocatable :: failure
    integer(int64), allocatable :: words(:)
    integer :: last

    call solve_position(model, whole_number(m, watch%start, watch%stride), position, failure)
    if (allocated(position%fields)) position%fields%position = m
    if (position%lacks_memory .and. .not. allocated(failure)) &
      failure = not_enough_memory // ' for the list of contacts'
    if (.not. allocated(failure)) then
      if (.not. are_finite(position)) &
        failure = 'a result is beyond the range of a double, expected other units'
    end if
    if (.not. allocated(failure)) then
      call check_meaning(position, max(model%nominal_area, position%nominal_area), &
                         failure)
      call check_loads(position, load_precision, failure)
      call compare_loads(position, model%loads_differ)
    end if
    if (watch%kept%is_packed .and. .not. allocated(failure)) call pack_position(position, words)
    !$omp critical (asperity_positions)
    last = watch%last
    watch%highest = max(watch%highest, m)
    watch%rows = watch%rows + int(position%rows_used, int64)
    if (allocated(failure)) then
      if (m < watch%failed) watch%failure = failure
      watch%failed = min(watch%failed, m)
      last = min(last, m)
    else if (watch%kept%is_packed) then
      call keep_record(watch%kept, m, words, failure)
      if (allocated(failure)) then
        watch%ending = failure
        last = 0
      end if
    end if
    ! A position up to the highest one exceeds the limit. All before it are still solved.
    if (watch%rows > int(most_rows, int64)) last = min(last, watch%highest)
    !$omp atomic write
    watch%last = last
    call watch%progress%step()
    call model%progress_count%add_work(model%progress_count%of_position - position%counted)
    !$omp end critical (asperity_positions)
  end subroutine solve_one

  ! Finds the first failure in order.
  subroutine find_failure(watch, positions, failure)
    type(sweep_watch), intent(in) :: watch
    type(position_result), intent(in) :: positions(:)
    character(len=:), allocatable, intent(out) :: failure
    integer(int64) :: rows
    integer :: m

    rows = 0_int64
    do m = 1, min(size(positions), watch%failed)
      rows = rows + int(positions(m)%rows_used, int64)
      if (m == watch%failed) failure = watch%failure
      if (rows > int(most_rows, int64)) call refuse_rows(failure)
      if (.not. allocated(failure)) cycle
      failure = 'position ' // decimal_text(whole_number(m, watch%start, watch%stride)) // ': ' // &
                failure
      return
    end do
  end subroutine find_failure

  subroutine refuse_rows(failure)
    character(len=:), allocatable, intent(out) :: failure

    failure = 'more than ' // decimal_text(most_rows) // ' contacts to keep: expected fewer ' // &
              'positions or points, or no list of contacts'
  end subroutine refuse_rows

end module asperity_sweep
