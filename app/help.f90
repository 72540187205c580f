!> What the program says of itself.
module asperity_help
  use asperity_effect_help, only: describe_effects
  use asperity_text_buffer, only: text_buffer
  use asperity_version, only: version
  use, intrinsic :: iso_fortran_env, only: compiler_options, compiler_version
  implicit none
  private

  public :: describe

  ! The words after a bare `asperity`.
  character(len=*), parameter :: next_steps(*) = [character(len=82) :: &
    'asperity: contact between rough surfaces of spherical asperities', &
    '', &
    'Three ways to begin:', &
    '  asperity data/thesis.deck     the report of the 1976 program, as it was printed', &
    '  asperity solve SCENE          two surfaces of your own: data/examples has scenes', &
    '  asperity summits MAP          a measured height map: statistics and summits', &
    'Then:', &
    '  asperity accuracy             what accuracy costs in time', &
    '  asperity --help               all commands and options', &
    'With fpm: fpm run -- data/thesis.deck']

  ! Help for the program and for its commands.
  character(len=*), parameter :: usage(*) = [character(len=82) :: &
    'Usage: asperity [OPTIONS] DECK', &
    '       asperity solve [OPTIONS] SCENE', &
    '       asperity accuracy [OPTIONS] [DECK or SCENE]', &
    '       asperity generate [OPTIONS] SPEC', &
    '       asperity study [OPTIONS] SPEC', &
    '       asperity summits [OPTIONS] MAP', &
    '       asperity COMMAND --help', &
    '', &
    'asperity DECK runs the original program on a card deck and prints its report.', &
    '', &
    '  --arithmetic NAME   ibm370 (default), real32, real64 or real128', &
    '  --tables LIST       positions whose contact table is printed: none, all, or', &
    '                      numbers from 1 to 100 with commas (default 13,55,56)', &
    '  --contacts FILE     write every contact of every approach as CSV', &
    '  --positions FILE    write the last approach of every position as CSV', &
    '  --carriage-control  keep the line printer''s column one (1, 0, blank)', &
    '  --help, -h, --version']
  character(len=*), parameter :: solve_help(*) = [character(len=82) :: &
    'Usage: asperity solve [OPTIONS] SCENE', &
    '', &
    'Solves a scene, or the sweep of a card deck, and prints a summary.', &
    '', &
    '  --contacts FILE     write every contact of every state as CSV', &
    '  --positions FILE    write the last state of every position as CSV', &
    '  --curve FILE        write the totals of every state as CSV', &
    '  --json FILE         write scene, results and where they come from as JSON', &
    '  --vtk FILE          write contacts as points with values (.vtp, for ParaView)', &
    '  --arithmetic NAME   real64 (default), real32, real128 or ibm370;', &
    '                      effects and paths are computed in real64 only', &
    '  --accuracy ERROR    take the cheapest way with this relative error, as 1e-3;', &
    '                      not for effects and paths', &
    '  --budget            print the error of every total, by source', &
    '  --threads N         threads (default: one a core, or one for little work);', &
    '                      the same bytes for any', &
    '  --keep FILE         keep positions that are solved; a rerun goes on there', &
    '  --cost              tell what time and memory it will take, and end', &
    '  --quiet             print no summary', &
    '']
  character(len=*), parameter :: accuracy_help(*) = [character(len=82) :: &
    'Usage: asperity accuracy [OPTIONS] [DECK or SCENE]', &
    '', &
    'Computes a sweep to the limit load in every way, then with every model of', &
    'neighbouring contacts, and prints time and errors of each. Without a file it', &
    'takes data/thesis.deck of the current folder.', &
    '', &
    '  --seconds S         time that may be spent (default 60); ways that take longer', &
    '                      are left out', &
    '  --csv FILE          write the table with all digits', &
    '  --cost              tell what time and memory it will take, and end', &
    '  --quiet             print no table']
  character(len=*), parameter :: generate_help(*) = [character(len=82) :: &
    'Usage: asperity generate [OPTIONS] SPEC', &
    '', &
    'Makes random surfaces from a specification: CSV, or a card deck when it has a', &
    'group &deck. Without options the upper surface, or the deck, is printed. A %', &
    'in a file''s name stands for the surface''s number in the ensemble.', &
    '', &
    '  --output FILE       write the upper surface, or the deck, to a file', &
    '  --upper FILE        write the upper surface as CSV; not for a deck', &
    '  --lower FILE        write the lower surface as CSV; not for a deck', &
    '  --surface N         only surface N of the ensemble', &
    '  --cost              tell what time and memory it will take, and end']
  character(len=*), parameter :: study_help(*) = [character(len=82) :: &
    'Usage: asperity study [OPTIONS] SPEC', &
    '', &
    'Presses an ensemble of random surfaces together, cuts them into smaller and', &
    'smaller sections and tells which size speaks for the whole.', &
    '', &
    '  --csv FILE          write the table with all digits', &
    '  --keep FILE         keep surfaces that are done; a rerun goes on there', &
    '  --cost              tell what time and memory it will take, and end', &
    '  --quiet             print no table']
  character(len=*), parameter :: summits_help(*) = [character(len=82) :: &
    'Usage: asperity summits [OPTIONS] MAP', &
    '', &
    'Finds the summits of a measured height map and prints statistics. A map is a', &
    'surface data file (ISO 25178-71), a matrix of heights with --spacing, or x,y,z', &
    'lines of a full regular grid; its content tells which.', &
    '', &
    '  --output FILE       write the summits as CSV: x,y,height,radius', &
    '  --rule NAME         eight (default): higher than all eight neighbours; contact:', &
    '                      to be pressed: edges mirrored, ridges filled', &
    '  --level NAME        heights count from the plane of least squares: plane', &
    '                      (default), the mean: mean, or as they are: none', &
    '  --radius NAME       from second differences: neighbours (default of eight), 1', &
    '                      over their mean; geometric (default of contact), over', &
    '                      their geometric mean; paraboloid, over nine samples', &
    '  --despike           take single outliers out, and tell how many', &
    '  --spacing X,Y       from sample to sample of a matrix, in its unit', &
    '  --unit NAME         m, mm, um, nm, cm or in, for all that is written (default:', &
    '                      as in the file; metres of a surface data file)', &
    '  --picture FILE      draw the map and its summits (SVG)', &
    '  --cost              tell what time and memory it will take, and end', &
    '  --quiet             print no summary']

contains

  !> The text of `asperity`, `asperity --version` or a help.
  subroutine describe(command, topic, text)
    character(len=*), intent(in) :: command   !! empty, `help` or `version`
    character(len=*), intent(in) :: topic     !! the command whose help is asked for, or another
    type(text_buffer), intent(inout) :: text  !! gets it

    if (command == 'version') then
      call text%line('asperity ' // version)
      call text%line('built by ' // compiler_version() // ' with' // flags(compiler_options()))
      call text%line('arithmetics ibm370 (default for a deck), real32, real64 (default of ' // &
                     'solve), real128')
      return
    else if (command == '') then
      call add(next_steps)
      return
    end if
    select case (topic)
    case ('solve')
      call add(solve_help)
      call describe_effects(text)
    case ('accuracy')
      call add(accuracy_help)
    case ('generate')
      call add(generate_help)
    case ('study')
      call add(study_help)
    case ('summits')
      call add(summits_help)
    case default
      call add(usage)
    end select
    call text%line('')
    call text%line('Exit status: 0 done, 1 could not be computed, ' // &
                   '2 bad command line or bad input')

  contains

    subroutine add(lines)
      character(len=*), intent(in) :: lines(:)
      integer :: i

      do i = 1, size(lines)
        call text%line(lines(i))
      end do
    end subroutine add

  end subroutine describe

  ! Of the compiler's options those that may change a digit; no folder's name.
  pure function flags(options) result(text)
    character(len=*), intent(in) :: options
    character(len=:), allocatable :: text
    integer :: first, last

    text = ''
    first = 1
    do while (first <= len_trim(options))
      last = first + index(options(first:) // ' ', ' ') - 2
      if (index(options(first:last), '-') == 1 .and. index(options(first:last), '/') == 0 .and. &
          scan(options(min(first + 1, last):min(first + 1, last)), 'OfmDs') > 0) &
        text = text // ' ' // options(first:last)
      first = last + 2
    end do
  end function flags

end module asperity_help
