!> The command `asperity summits MAP`: a height map, its summits, a surface and a picture.
module asperity_run_summits
  use asperity_command_line, only: command_line
  use asperity_command_outcome, only: command_outcome
  use asperity_height_map, only: height_map
  use asperity_kinds, only: int64
  use asperity_map_picture, only: draw_map
  use asperity_map_statistics, only: map_statistics, measure_map
  use asperity_map_summits, only: map_summits
  use asperity_printable, only: printable
  use asperity_summits_of_file, only: summit_choices, summits_of_file
  use asperity_summits_table, only: write_summits_csv, write_summits_table
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: run_summits_command

contains

  !> Runs the command. All is computed before the first byte is written.
  subroutine run_summits_command(line, outcome)
    type(command_line), intent(in) :: line           !! the user's choices
    type(command_outcome), intent(inout) :: outcome  !! what to tell and write
    type(height_map) :: map
    type(map_summits) :: summits
    type(map_statistics) :: found
    type(summit_choices) :: choices
    type(text_buffer) :: surface, picture
    integer(int64) :: spikes

    choices = summit_choices(rule=line%rule, level=line%level, radius=line%radius, &
                             unit=line%unit, despike=line%despike, spacing=line%spacing, &
                             progress=.true.)
    call summits_of_file(line%input, choices, map, summits, spikes, outcome%problems, &
                         outcome%failure)
    if (outcome%problems%count() > 0 .or. allocated(outcome%failure)) return
    if (.not. line%quiet) then
      call measure_map(map, summits, found)
      call write_summits_table(line%input, choices, spikes, map, summits, found, outcome%text)
    end if
    if (line%output('--output') /= '') call write_summits_csv(summits, surface)
    call outcome%stage(line%output('--output'), surface)
    if (line%output('--picture') /= '') &
      call draw_map(printable(line%input), map, summits, picture)
    call outcome%stage(line%output('--picture'), picture)
  end subroutine run_summits_command

end module asperity_run_summits
