!> The command `asperity summits MAP`: a height map, its summits and spectra.
module asperity_run_summits
  use asperity_command_line, only: command_line
  use asperity_command_outcome, only: command_outcome
  use asperity_csv_tables, only: write_spectrum_csv, write_table
  use asperity_height_map, only: height_map
  use asperity_kinds, only: int64
  use asperity_map_spectrum, only: measure_spectra, power_spectrum
  use asperity_map_statistics, only: map_statistics, measure_map
  use asperity_map_summits, only: map_summits, rule_eight
  use asperity_result_table, only: add_surface, array_table
  use asperity_summits_of_file, only: summit_choices, summits_of_file
  use asperity_summits_table, only: write_summits_table
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: run_summits_command

contains

  !> Runs the command. All is computed before the first byte is written.
  subroutine run_summits_command(line, outcome)
    type(command_line), intent(in) :: line           !! the user's choices
    type(command_outcome), intent(inout) :: outcome  !! messages, text and files
    type(height_map) :: map
    type(map_summits) :: summits
    type(map_statistics) :: found
    type(summit_choices) :: choices
    type(text_buffer) :: surface, spectrum
    type(power_spectrum) :: spectra(3)
    type(array_table) :: table
    integer(int64) :: spikes

    choices = summit_choices(rule=max(rule_eight, line%choice('--rule')), &
                             level=line%choice('--level'), &
                             periodic=line%choice('--edge') == 2, edge_of_file=.false., &
                             radius=line%choice('--radius'), unit=line%choice('--unit'), &
                             despike=line%has('--despike'), &
                             pixel_spacing=line%pixel_spacing, progress=.true., prefix='--')
    call summits_of_file(line%input, choices, map, summits, spikes, outcome%problems, &
                         outcome%failure)
    if (outcome%problems%count() > 0 .or. allocated(outcome%failure)) return
    if (line%has('--spectrum')) then
      call measure_spectra('--spectrum: ' // line%input, map, spectra, outcome%problems, &
                           outcome%failure)
      if (outcome%problems%count() > 0 .or. allocated(outcome%failure)) return
      call write_spectrum_csv(spectra, spectrum)
    end if
    call outcome%warnings%append(map%notes)
    if (.not. line%has('--quiet')) then
      call measure_map(map, summits, found)
      call write_summits_table(line%input, choices, spikes, map, summits, found, outcome%text)
    end if
    call add_surface(summits%x, summits%y, summits%height, summits%radius, table, '')
    if (line%has('--output')) call write_table(table, surface)
    call outcome%stage_text(line%output_path('--output'), surface)
    call outcome%stage_text(line%output_path('--spectrum'), spectrum)
  end subroutine run_summits_command

end module asperity_run_summits
