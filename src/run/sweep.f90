!> Sweep over the positions of a scene: they are distributed to images and threads, and kept in a
!> file when they are solved. The result does not depend on the numbers of images and threads.
!>
!> The reported failure does not depend on the number of threads: it is that of the first position
!> in order that fails, or at which there are too many contacts. Later positions are left out.
!> Without OpenMP there is one thread.
module asperity_sweep
  use asperity_contact_model, only: contact_model
  use asperity_contact_records, only: are_finite, most_rows, position_result, room_of_a_state
  use asperity_decimal, only: decimal_to_real64
  use asperity_images, only: image_number
  use asperity_interruption, only: interruption
  use asperity_kept_records, only: kept_work, pieces_of_part, whole_number
  use asperity_kinds, only: int64, real64
  use asperity_loads_met, only: check_loads, check_meaning, compare_loads
  use asperity_position_packet, only: pack_position, unpack_position
  use asperity_position_path, only: solve_position
  use asperity_problems, only: decimal_text, not_enough_memory
  use asperity_process, only: has_memory, threads_with_memory
  use asperity_progress, only: progress_line
  use asperity_run_options, only: run_options
  use asperity_scene_inputs, only: input_file, list_inputs
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: scene
  use asperity_shared_work, only: add_failure, begin_round, begin_work, end_round, &
                                  gather_round, is_own, shared_work
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
    type(shared_work) :: work
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

    model%interrupt = options%interrupt
    model%reuse = options%reuse
    model%progress_count = options%counted_work
    model%progress_count%of_position = max(1, model%states)
    model%nominal_area = max(decimal_to_real64(scene_in%nominal_area), results%nominal_area)
    call name_work(scene_in, options, kept, failure)
    if (allocated(failure)) return
    if (results%begun < 0.0_real64) call cpu_time(results%begun)
    call run_sweep(model, options, kept, results%positions, failure)
  end subroutine sweep_scene

  ! Identifies the work of a file of kept positions: all input files of the scene, and all options
  ! that change the results. Every image reads the files, so that a failure occurs on all images and
  ! no image stays in a barrier.
  subroutine name_work(scene_in, options, kept, failure)
    type(scene), intent(in) :: scene_in
    type(run_options), intent(in) :: options
    type(kept_work), intent(out) :: kept
    character(len=:), allocatable, intent(out) :: failure
    type(input_file) :: inputs(3)
    integer :: i

    kept%path = ''
    if (allocated(options%keep_file)) kept%path = options%keep_file
    if (kept%path == '') return
    kept%piece = 'position'
    kept%part = options%part
    kept%parts = options%parts
    if (allocated(options%more_files)) kept%more = options%more_files
    kept%of_what = 'this scene and list of contacts'
    call list_inputs(scene_in, inputs, failure)
    kept%heading = 'asperity ' // version // ' solve, contacts ' // &
                   trim(merge('kept  ', 'summed', options%keep_contacts)) // ', input'
    do i = 1, size(inputs)
      kept%heading = kept%heading // ' ' // inputs(i)%checksum
    end do
  end subroutine name_work

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
    integer :: m, number, threads
    logical :: continues

    number = model%positions
    if (options%sample > 0) number = min(number, options%sample)
    if (number > 1) watch%stride = (model%positions - 1) / (number - 1)
    if (options%parts > 1) then
      number = pieces_of_part(number, options%part, options%parts)
      watch%start = options%part
      watch%stride = options%parts
    end if
    states = int(number, int64) * int(max(1, model%states), int64)
    if (.not. has_memory(states * int(room_of_a_state, int64))) then
      failure = not_enough_memory // ' for ' // decimal_text(number) // ' positions'
      return
    end if
    allocate (positions(number))
    threads = threads_for(model, options)
    watch%last = number
    watch%interrupt = options%interrupt
    call begin_work(watch%work, number, options%all_images, kept)
    do m = 1, watch%work%done * merge(1, 0, image_number() == 1)
      call unpack_position(watch%work%records(m)%words, positions(m))
    end do
    if (allocated(kept%more) .and. sum(int(positions%rows_used, int64)) > most_rows) &
      watch%work%ending = too_many()
    call watch%progress%begin(options%progress, 'positions', number, watch%work%done)
    call model%progress_count%begin_count(int(min(states, int(huge(number), int64))), &
                                  watch%work%done * model%progress_count%of_position)
    do
      call begin_round(watch%work, continues)
      if (.not. continues) exit
      if (threads > 1) then
        !$omp parallel do schedule(dynamic) num_threads(threads)
        do m = watch%work%first, watch%work%last
          if (is_due(watch, m)) call solve_one(model, m, options, positions(m), watch)
        end do
        !$omp end parallel do
      else
        ! Outside a parallel region: nested regions would start their threads at each position.
        do m = watch%work%first, watch%work%last
          if (is_due(watch, m)) call solve_one(model, m, options, positions(m), watch)
        end do
      end if
      call gather_round(watch%work)
      if (image_number() == 1) call take_round(watch, positions)
      call end_round(watch%work)
      call watch%progress%reach(watch%work%done)
    end do
    call watch%progress%finish()
    if (allocated(watch%work%ending)) failure = watch%work%ending
    if (watch%interrupt%is_asked()) failure = 'interrupted'
  end subroutine run_sweep

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
    threads = threads_with_memory(min(threads, model%positions))
  end function threads_for

  ! Whether a position of the round is to be solved by this image.
  logical function is_due(watch, m)
    type(sweep_watch), intent(in) :: watch
    integer, intent(in) :: m
    integer :: last

    !$omp atomic read
    last = watch%last
    is_due = m <= last .and. is_own(watch%work, m) .and. .not. watch%interrupt%is_asked()
  end function is_due

  ! Solves and checks one position in one thread.
  subroutine solve_one(model, m, options, position, watch)
    class(contact_model), intent(in), target :: model
    integer, intent(in) :: m
    type(run_options), intent(in) :: options
    type(position_result), intent(inout) :: position
    type(sweep_watch), intent(inout) :: watch
    character(len=:), allocatable :: failure
    integer(int64), allocatable :: words(:)
    integer :: last

    call solve_position(model, whole_number(m, watch%start, watch%stride), options%keep_contacts, &
                      position, failure)
    if (position%lacks_memory .and. .not. allocated(failure)) &
      failure = not_enough_memory // ' for the list of contacts'
    if (.not. allocated(failure)) then
      if (.not. are_finite(position)) &
        failure = 'a result is beyond the range of a double, expected other units'
    end if
    if (.not. allocated(failure)) then
      call check_meaning(position, model%nominal_area, failure)
      call check_loads(position, load_precision, failure)
      call compare_loads(position, model%loads_differ)
    end if
    if (watch%work%packed .and. .not. allocated(failure)) call pack_position(position, words)
    !$omp critical (asperity_positions)
    last = watch%last
    watch%highest = max(watch%highest, m)
    watch%rows = watch%rows + int(position%rows_used, int64)
    if (allocated(failure)) then
      call add_failure(watch%work, m, failure)
      last = min(last, m)
    else if (watch%work%packed) then
      call move_alloc(words, watch%work%records(m)%words)
    end if
    ! A position up to the highest one exceeds the limit. All before it are still solved.
    if (watch%rows > int(most_rows, int64)) last = min(last, watch%highest)
    !$omp atomic write
    watch%last = last
    call watch%progress%step()
    call model%progress_count%add_work(model%progress_count%of_position - position%counted)
    !$omp end critical (asperity_positions)
  end subroutine solve_one

  ! Collects the positions of other images on image 1, and finds the first failure in order.
  subroutine take_round(watch, positions)
    type(sweep_watch), intent(inout) :: watch
    type(position_result), intent(inout) :: positions(:)
    integer(int64) :: rows
    integer :: m

    if (allocated(watch%work%ending)) return
    associate (work => watch%work)
      do m = work%first, merge(work%last, 0, work%packed)
        if (is_own(work, m) .or. .not. allocated(work%records(m)%words)) cycle
        call unpack_position(work%records(m)%words, positions(m))
      end do
      rows = 0_int64
      do m = 1, min(work%last, work%failed)
        rows = rows + int(positions(m)%rows_used, int64)
        if (m == work%failed) work%ending = work%failure
        if (rows > int(most_rows, int64)) work%ending = too_many()
        if (.not. allocated(work%ending)) cycle
        work%ending = 'position ' // &
                      decimal_text(whole_number(m, watch%start, watch%stride)) // ': ' // &
                      work%ending
        return
      end do
    end associate
  end subroutine take_round

  pure function too_many() result(text)
    character(len=:), allocatable :: text

    text = 'more than ' // decimal_text(most_rows) // ' contacts to keep: expected fewer ' // &
           'positions or points, or no list of contacts'
  end function too_many

end module asperity_sweep
