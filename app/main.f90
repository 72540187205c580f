!> The program: reads the command line, runs the command, prints what went wrong, stops.
program asperity_main
  use asperity_command_line, only: command_line, is_shared, parse_command_line
  use asperity_files, only: write_standard_error
  use asperity_help, only: show_help, show_next_steps, show_version
  use asperity_images, only: image_number, wait_for_images
  use asperity_output_files, only: guard_files
  use asperity_problems, only: problem_list
  use asperity_process, only: end_process
  use asperity_run_accuracy, only: run_accuracy_command
  use asperity_run_generate, only: run_generate_command
  use asperity_run_original, only: run_original_command
  use asperity_run_solve, only: run_solve_command
  use asperity_run_study, only: run_study_command
  implicit none
  type(command_line) :: line
  type(problem_list) :: problems
  integer :: status

  call guard_files()
  call parse_command_line(line, problems)
  if (problems%count() > 0) then
    if (image_number() == 1) &
      call write_standard_error(problems%text() // 'Try: asperity --help' // new_line('a'))
    status = 2
  else if (image_number() > 1 .and. .not. is_shared(line)) then
    status = 0
  else
    select case (line%command)
    case ('')
      call show_next_steps(status)
    case ('help')
      call show_help(line%topic, status)
    case ('version')
      call show_version(status)
    case ('accuracy')
      call run_accuracy_command(line, status)
    case ('generate')
      call run_generate_command(line, status)
    case ('solve')
      call run_solve_command(line, status)
    case ('study')
      call run_study_command(line, status)
    case default
      call run_original_command(line, status)
    end select
  end if
  call wait_for_images()
  ! Images that have all ended well end together, by the end of the program.
  if (status /= 0) call end_process(status)
end program asperity_main
