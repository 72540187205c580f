!> The program: reads the command line, runs the command, prints what went wrong, stops.
program asperity_main
  use asperity_command_line, only: command_line, is_shared, parse_command_line
  use asperity_command_outcome, only: command_outcome, finish_command
  use asperity_help, only: write_help, write_completion, write_manual_page
  use asperity_images, only: image_number, wait_for_images
  use asperity_option_table, only: command_at, commands
  use asperity_output_files, only: guard_files
  use asperity_process, only: check_stack
  use asperity_run_accuracy, only: run_accuracy_command
  use asperity_run_generate, only: run_generate_command
  use asperity_run_original, only: run_original_command
  use asperity_run_solve, only: run_solve_command
  use asperity_run_summits, only: run_summits_command
  use asperity_system_calls, only: posix_exit
  use asperity_waiting_threads, only: let_threads_sleep
  !$ use omp_lib, only: omp_set_num_threads
  use, intrinsic :: iso_c_binding, only: c_int
  implicit none
  type(command_line) :: line
  type(command_outcome) :: outcome
  integer :: status

  call guard_files()
  call check_stack(outcome%failure)
  if (.not. allocated(outcome%failure)) call parse_command_line(line, outcome%problems)
  if (allocated(outcome%failure)) then
    continue
  else if (outcome%problems%count() > 0) then
    call outcome%problems%add(trim('Try: asperity ' // &
                                   commands(command_at(line%command))%name) // ' --help')
  else if (image_number() == 1 .or. is_shared(line)) then
    !$ if (line%has('--threads')) call omp_set_num_threads(line%choice('--threads'))
    if (any(line%command == [character(len=8) :: 'accuracy', 'solve', 'summits'])) &
      call let_threads_sleep()
    select case (line%command)
    case ('', 'help', 'version')
      call write_help(line%command, line%topic, line%input, outcome%text)
    case ('man')
      call write_manual_page(outcome%text)
    case ('completion')
      call write_completion(outcome%text)
    case ('accuracy')
      call run_accuracy_command(line, outcome)
    case ('generate')
      call run_generate_command(line, outcome)
    case ('solve')
      call run_solve_command(line, outcome)
    case ('summits')
      call run_summits_command(line, outcome)
    case default
      call run_original_command(line, outcome)
    end select
  end if
  call finish_command(outcome, status)
  call wait_for_images()
  ! Images that have all ended well end together, by the end of the program.
  if (status /= 0) call posix_exit(int(status, c_int))
end program asperity_main
