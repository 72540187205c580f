!> The one table of commands and options: from it the command line is read, and help, manual page
!> and shell completion are written.
module asperity_option_table
  use asperity_height_map, only: edge_names, length_units, level_names
  use asperity_map_summits, only: rule_names
  use asperity_original, only: arithmetic_names
  use asperity_run_options, only: totals_of_accuracy
  use asperity_summit_spheres, only: radius_names
  implicit none
  private

  public :: command_entry, option_entry, commands, options
  public :: call_of, command_at

  !> A command.
  type :: command_entry
    character(len=8) :: name      !! the word; blank: the original program, which has none
    character(len=15) :: operand  !! its file, as a usage line has it
    character(len=13) :: called   !! the same in a sentence
    character(len=340) :: text    !! what it does
  end type command_entry

  !> An option of a command.
  type :: option_entry
    character(len=8) :: command   !! whose it is
    character(len=18) :: name     !! with its two dashes
    character(len=5) :: value     !! what stands behind it; FILE: an output; blank: nothing
    character(len=240) :: text    !! what it does
    character(len=19) :: format = 'csv'  !! endings of the output's name; blank: any
    integer :: most = 0           !! largest number of N
    character(len=11) :: words(6) = ''  !! values of WORD and NAME, in the order of their numbers
  end type option_entry

  character(len=11), parameter :: none(6) = ''

  !> The original program first.
  type(command_entry), parameter :: commands(*) = [ &
    command_entry('', 'DECK', 'card deck', &
      'asperity DECK runs the original program on a card deck and prints its report.'), &
    command_entry('solve', 'SCENE', 'scene', &
      'Solves a scene, or the sweep of a card deck, and prints a summary.'), &
    command_entry('accuracy', '[DECK or SCENE]', 'deck or scene', &
      'Solves a scene by every method that applies and prints run time and errors of each. A ' // &
      'sweep to the limit load is solved by more methods. Default: data/thesis.deck.'), &
    command_entry('generate', 'SPEC', 'specification', &
      'Generates random surfaces from a specification, as CSV, or as a card deck where it has ' // &
      'a group &deck, or a self-affine height map where it has a group &map. Without options ' // &
      'the upper surface, the deck or the map is printed. A % in a file name is replaced by ' // &
      'the number of the surface in the ensemble.'), &
    command_entry('summits', 'MAP', 'map', &
      'Finds the summits of a measured height map and prints statistics. Formats, recognised ' // &
      'by content: surface data file (ISO 25178-71), array of NumPy (.npy) or matrix of ' // &
      'heights with --spacing, x,y,z lines of a full regular grid.')]

  !> In the order of the help.
  type(option_entry), parameter :: options(*) = [ &
    option_entry('', '--arithmetic', 'NAME', 'ibm370 (default), real32, real64 or real128', &
      words=[character(len=11) :: arithmetic_names, none(:2)]), &
    option_entry('', '--tables', 'LIST', &
      'positions whose contact table is printed: none, all, or numbers from 1 to 100 ' // &
      'separated by commas (default 13,55,56)'), &
    option_entry('', '--contacts', 'FILE', 'write every contact of every approach as CSV'), &
    option_entry('', '--positions', 'FILE', 'write the last approach of every position as CSV'), &
    option_entry('', '--carriage-control', '', &
      'print the carriage control characters of column one (1, 0, blank)'), &
    option_entry('', '--variance', 'FILE', 'write Table VI with all digits as CSV'), &
    option_entry('solve', '--contacts', 'FILE', 'write every contact of every state as CSV'), &
    option_entry('solve', '--positions', 'FILE', 'write the last state of every position as CSV'), &
    option_entry('solve', '--curve', 'FILE', 'write the totals of every state as CSV'), &
    option_entry('solve', '--units', '', &
      'begin CSV files with a comment line (#) that lists the units'), &
    option_entry('solve', '--json', 'FILE', &
      'write scene, results and provenance as JSON', 'json'), &
    option_entry('solve', '--fields', 'FILE', &
      'write pressure, gap and displacement on the pixels of a map, or of asperities with ' // &
      'field_spacing (VTK image data, .vti, for ParaView)', 'vti'), &
    option_entry('solve', '--fields-of', 'WORD', &
      'states that --fields writes: last (default), or all, each in a file NAME_0001.vti', &
      words=[character(len=11) :: 'last', 'all', none(:4)]), &
    option_entry('solve', '--histogram', 'FILE', &
      'write the distribution of the pressure in contact on them at the last state as CSV'), &
    option_entry('solve', '--depths', 'LIST', &
      'print the largest stresses below these pixels at the last state: depths separated by ' // &
      'commas, or FIRST:LAST:NUMBER; 0 is the surface'), &
    option_entry('solve', '--body', 'WORD', 'body of these stresses: lower (default) or upper', &
      words=[character(len=11) :: 'lower', 'upper', none(:4)]), &
    option_entry('solve', '--stress', 'FILE', &
      'write all stresses at the depths of --depths as CSV, JSON (.json) or a grid for ' // &
      'ParaView (.vts)', 'csv, .json or .vts'), &
    option_entry('solve', '--accuracy', 'ERROR', &
      'choose the fastest method with an estimated relative error of the load below ERROR, ' // &
      'for instance 1e-3, including the estimated influence of effects that are off'), &
    option_entry('solve', '--of', 'WORD', &
      'results that --accuracy limits: load (default; under a load separation and ' // &
      'compression), area, pressure (greatest; of maps), or all (load and area)', &
      words=[character(len=11) :: totals_of_accuracy, none(:2)]), &
    option_entry('solve', '--threads', 'N', &
      'number of threads (default: all cores, 1 for small scenes); results do not depend on ' // &
      'it; on a busy machine set OMP_WAIT_POLICY=passive', &
      most=9999), &
    option_entry('solve', '--keep', 'FILE', &
      'save solved positions in FILE; a rerun continues from it', ''), &
    option_entry('solve', '--share', 'I/N', &
      'solve part I of N and save it with --keep, write no other output; a run with the ' // &
      '--keep files of all parts, one option each, writes the outputs'), &
    option_entry('solve', '--quiet', '', 'print no summary'), &
    option_entry('accuracy', '--seconds', 'S', &
      'time limit in seconds (default 60); slower methods are left out'), &
    option_entry('accuracy', '--finer', '', 'solve a height map on pixels half as wide too, ' // &
      'by its waves or by cubics'), &
    option_entry('accuracy', '--csv', 'FILE', 'write the table with all digits'), &
    option_entry('accuracy', '--quiet', '', 'print no table'), &
    option_entry('generate', '--output', 'FILE', &
      'write the upper surface, the deck, or the height map (.sdf, .npy or .txt)', ''), &
    option_entry('generate', '--upper', 'FILE', 'write the upper surface as CSV; not for a deck'), &
    option_entry('generate', '--lower', 'FILE', 'write the lower surface as CSV; not for a deck'), &
    option_entry('generate', '--surface', 'N', 'only surface N of the ensemble', &
      most=9999999), &
    option_entry('summits', '--output', 'FILE', 'write the summits as CSV: x,y,height,radius'), &
    option_entry('summits', '--rule', 'NAME', &
      'eight (default): higher than all eight neighbours; contact: summits for a contact ' // &
      'calculation, with mirrored edges and filled ridges', &
      words=[character(len=11) :: rule_names, none(:4)]), &
    option_entry('summits', '--level', 'NAME', &
      'subtract from the heights: plane (least squares; default of a free map), mean (default ' // &
      'of a periodic map), none', &
      words=[character(len=11) :: level_names, none(:3)]), &
    option_entry('summits', '--edge', 'NAME', &
      'edge of the map: free (default) or periodic', &
      words=[character(len=11) :: edge_names, none(:4)]), &
    option_entry('summits', '--radius', 'NAME', &
      'radius from second differences: neighbours (default of eight), inverse of their mean; ' // &
      'geometric (default of contact), inverse of their geometric mean; paraboloid, fit to ' // &
      'nine pixels', &
      words=[character(len=11) :: radius_names, none(:3)]), &
    option_entry('summits', '--despike', '', 'remove single outliers and print their number'), &
    option_entry('summits', '--spacing', 'X,Y', 'pixel spacing of a matrix or an array, in ' // &
        'its unit of length; one number: X = Y'), &
    option_entry('summits', '--unit', 'NAME', &
      'unit of length of all outputs, and of a map without a unit: m, mm, um, nm, cm or in ' // &
      '(default: that of the file; m for a surface data file)', &
      words=[character(len=11) :: length_units]), &
    option_entry('summits', '--spectrum', 'FILE', &
      'write power spectral densities as CSV: of the area, averaged over rings, and of lines ' // &
      'along x and along y'), &
    option_entry('summits', '--quiet', '', 'print no summary')]

contains

  !> Place of a command in `commands`; 1, the original program, for any other word.
  pure integer function command_at(name)
    character(len=*), intent(in) :: name  !! word of the command line

    command_at = max(1, findloc(commands%name == name, .true., 1))
  end function command_at

  !> `asperity solve [OPTIONS] SCENE`.
  pure function call_of(k) result(text)
    integer, intent(in) :: k               !! place in `commands`
    character(len=:), allocatable :: text  !! for a usage line

    text = 'asperity [OPTIONS] ' // trim(commands(k)%operand)
    if (k > 1) text = 'asperity ' // trim(commands(k)%name) // ' [OPTIONS] ' // &
                      trim(commands(k)%operand)
  end function call_of

end module asperity_option_table
