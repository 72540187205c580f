!> The command `asperity summits MAP`: a height map, its summits, a surface and a picture.
module asperity_run_summits
  use asperity_command_line, only: command_line
  use asperity_command_outcome, only: command_outcome
  use asperity_height_map, only: change_unit, height_map
  use asperity_height_map_reader, only: read_height_map
  use asperity_kinds, only: int64, real64
  use asperity_map_despiking, only: despike_map
  use asperity_map_levelling, only: level_map, level_names
  use asperity_map_picture, only: draw_map
  use asperity_map_statistics, only: map_statistics, measure_map
  use asperity_map_summits, only: find_summits, map_summits, rule_names, usual_radius
  use asperity_printable, only: printable
  use asperity_summit_spheres, only: radius_names
  use asperity_summits_table, only: summits_heading, write_summits_csv, write_summits_table
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
    type(summits_heading) :: heading
    type(text_buffer) :: surface, picture
    integer :: radius

    call read_height_map(line%input, line%spacing, .true., map, outcome%problems, outcome%failure)
    if (outcome%problems%count() > 0 .or. allocated(outcome%failure)) return
    if (line%unit > 0) call take_unit(line, map, outcome)
    if (outcome%problems%count() > 0) return
    call level_map(map, line%level)
    if (line%despike) &
      call despike_map(map, line%level, .true., heading%spikes, outcome%failure)
    radius = line%radius
    if (radius == 0) radius = usual_radius(line%rule)
    if (.not. allocated(outcome%failure)) &
      call find_summits(map, line%rule, radius, summits, outcome%failure)
    if (allocated(outcome%failure)) then
      outcome%failure = line%input // ': ' // outcome%failure
      return
    end if
    if (.not. line%quiet) then
      heading%file = printable(line%input)
      heading%level = trim(level_names(line%level))
      heading%rule = trim(rule_names(line%rule))
      heading%radius = trim(radius_names(radius))
      call measure_map(map, summits, found)
      call write_summits_table(heading, map, summits, found, outcome%text)
    end if
    if (line%output('--output') /= '') call write_summits_csv(summits, surface)
    call outcome%stage(line%output('--output'), surface)
    if (line%output('--picture') /= '') &
      call draw_map(printable(line%input), map, summits, picture)
    call outcome%stage(line%output('--picture'), picture)
  end subroutine run_summits_command

  ! All lengths of a map in the unit asked for.
  subroutine take_unit(line, map, outcome)
    type(command_line), intent(in) :: line
    type(height_map), intent(inout) :: map
    type(command_outcome), intent(inout) :: outcome

    if (map%unit == '') then
      call outcome%problems%add('--unit: ' // line%input // ' has no unit, expected none: its ' // &
                                'lengths are written as they are')
      return
    end if
    call change_unit(map, line%unit)
  end subroutine take_unit

end module asperity_run_summits
