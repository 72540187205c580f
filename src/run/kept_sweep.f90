!> Sweep over the positions of a scene with the file in which they are kept.
module asperity_kept_sweep
  use asperity_decimal, only: decimal_to_real64
  use asperity_kept_records, only: kept_work
  use asperity_kinds, only: real64
  use asperity_position_solver, only: position_solver
  use asperity_run_options, only: run_options
  use asperity_scene_inputs, only: input_file, list_inputs
  use asperity_scene_results, only: scene_results
  use asperity_scene_values, only: scene
  use asperity_sweep, only: run_sweep
  use asperity_version, only: version
  implicit none
  private

  public :: sweep_scene

contains

  !> Solves the positions of a scene and keeps them in the file of the options.
  subroutine sweep_scene(scene_in, options, solver, results, failure)
    type(scene), intent(in) :: scene_in                    !! scene, checked for faults
    type(run_options), intent(in) :: options               !! options of the run
    class(position_solver), intent(inout) :: solver        !! solver; gets the options
    type(scene_results), intent(inout) :: results          !! results with all positions
    character(len=:), allocatable, intent(out) :: failure  !! reason, when a position is not solved
    type(kept_work) :: kept

    solver%interrupt = options%interrupt
    solver%reuse = options%reuse
    solver%progress_count = options%counted_work
    solver%progress_count%of_position = max(1, solver%states)
    solver%nominal_area = max(decimal_to_real64(scene_in%nominal_area), results%nominal_area)
    call name_work(scene_in, options, kept, failure)
    if (allocated(failure)) return
    if (results%begun < 0.0_real64) call cpu_time(results%begun)
    call run_sweep(solver, options, kept, results%positions, failure)
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
    kept%of_what = 'this scene, arithmetic and list of contacts'
    call list_inputs(scene_in, inputs, failure)
    kept%heading = 'asperity ' // version // ' solve, ' // trim(options%arithmetic) // &
                   ', contacts ' // trim(merge('kept  ', 'summed', options%keep_contacts)) // &
                   ', input'
    do i = 1, size(inputs)
      kept%heading = kept%heading // ' ' // inputs(i)%checksum
    end do
  end subroutine name_work

end module asperity_kept_sweep
