!> What the program says of itself.
module asperity_help
  use asperity_effect_help, only: describe_effects
  use asperity_text_buffer, only: text_buffer
  use asperity_version, only: version
  implicit none
  private

  public :: describe

contains

  !> The text of `asperity`, `asperity --version` or a help.
  subroutine describe(command, topic, text)
    character(len=*), intent(in) :: command   !! empty, `help` or `version`
    character(len=*), intent(in) :: topic     !! the command whose help is asked for, or another
    type(text_buffer), intent(inout) :: text  !! gets it

    if (command == 'version') then
      call text%line('asperity ' // version)
    else if (command == '') then
      call describe_next_steps(text)
    else
      select case (topic)
      case ('solve')
        call describe_solve(text)
      case ('accuracy')
        call describe_accuracy(text)
      case ('generate')
        call describe_generate(text)
      case ('study')
        call describe_study(text)
      case default
        call describe_all(text)
      end select
      call text%line('')
      call text%line('Exit status: 0 done, 1 could not be computed, ' // &
                     '2 bad command line or bad input')
    end if
  end subroutine describe

  ! The words after a bare `asperity`.
  subroutine describe_next_steps(text)
    type(text_buffer), intent(inout) :: text

    call text%line('asperity: contact between rough surfaces of spherical asperities')
    call text%line('')
    call text%line('Type next:')
    call text%line('  asperity data/thesis.deck           print the report of the original program')
    call text%line('  asperity solve data/thesis.deck     the same deck by the present-day solver')
    call text%line('  asperity accuracy data/thesis.deck  what accuracy costs in time')
    call text%line('  asperity --help                     all commands and options')
    call text%line('With fpm: fpm run -- data/thesis.deck')
  end subroutine describe_next_steps

  subroutine describe_all(text)
    type(text_buffer), intent(inout) :: text

    call text%line('Usage: asperity [OPTIONS] DECK')
    call text%line('       asperity solve [OPTIONS] SCENE')
    call text%line('       asperity accuracy [OPTIONS] [DECK or SCENE]')
    call text%line('       asperity generate [OPTIONS] SPEC')
    call text%line('       asperity study [OPTIONS] SPEC')
    call text%line('       asperity COMMAND --help')
    call text%line('')
    call text%line('asperity DECK runs the original program on a card deck and prints its report.')
    call text%line('')
    call text%line('  --arithmetic NAME   ibm370 (default), real32, real64 or real128')
    call text%line('  --tables LIST       positions whose contact table is printed: none, all, or')
    call text%line('                      numbers from 1 to 100 with commas (default 13,55,56)')
    call text%line('  --contacts FILE     write every contact of every approach as CSV')
    call text%line('  --positions FILE    write the last approach of every position as CSV')
    call text%line('  --carriage-control  keep the line printer''s column one (1, 0, blank)')
    call text%line('  --help, -h, --version')
  end subroutine describe_all

  subroutine describe_solve(text)
    type(text_buffer), intent(inout) :: text

    call text%line('Usage: asperity solve [OPTIONS] SCENE')
    call text%line('')
    call text%line('Solves a scene, or the sweep of a card deck, and prints a summary.')
    call text%line('')
    call text%line('  --contacts FILE     write every contact of every state as CSV')
    call text%line('  --positions FILE    write the last state of every position as CSV')
    call text%line('  --curve FILE        write the totals of every state as CSV')
    call text%line('  --arithmetic NAME   real64 (default), real32, real128 or ibm370;')
    call text%line('                      effects and paths are computed in real64 only')
    call text%line('  --accuracy ERROR    take the cheapest way with this relative error, as 1e-3;')
    call text%line('                      not for effects and paths')
    call text%line('  --budget            print the error of every total, by source')
    call text%line('  --threads N         threads (default: one a core, or one for little work);')
    call text%line('                      the same bytes for any')
    call text%line('  --keep FILE         keep positions that are solved; a rerun goes on there')
    call text%line('  --quiet             print no summary')
    call text%line('')
    call describe_effects(text)
  end subroutine describe_solve

  subroutine describe_accuracy(text)
    type(text_buffer), intent(inout) :: text

    call text%line('Usage: asperity accuracy [OPTIONS] [DECK or SCENE]')
    call text%line('')
    call text%line('Computes a sweep to the limit load in every way, then with every model of')
    call text%line('neighbouring contacts, and prints time and errors of each. Without a file it')
    call text%line('takes data/thesis.deck of the current folder.')
    call text%line('')
    call text%line('  --csv FILE          write the table with all digits')
    call text%line('  --quiet             print no table')
  end subroutine describe_accuracy

  subroutine describe_generate(text)
    type(text_buffer), intent(inout) :: text

    call text%line('Usage: asperity generate [OPTIONS] SPEC')
    call text%line('')
    call text%line('Makes random surfaces from a specification: CSV, or a card deck when it has a')
    call text%line('group &deck. Without options the upper surface, or the deck, is printed. A %')
    call text%line('in a file''s name stands for the surface''s number in the ensemble.')
    call text%line('')
    call text%line('  --output FILE       write the upper surface, or the deck, to a file')
    call text%line('  --upper FILE        write the upper surface as CSV; not for a deck')
    call text%line('  --lower FILE        write the lower surface as CSV; not for a deck')
    call text%line('  --surface N         only surface N of the ensemble')
  end subroutine describe_generate

  subroutine describe_study(text)
    type(text_buffer), intent(inout) :: text

    call text%line('Usage: asperity study [OPTIONS] SPEC')
    call text%line('')
    call text%line('Presses an ensemble of random surfaces together, cuts them into smaller and')
    call text%line('smaller sections and tells which size speaks for the whole.')
    call text%line('')
    call text%line('  --csv FILE          write the table with all digits')
    call text%line('  --keep FILE         keep surfaces that are done; a rerun goes on there')
    call text%line('  --quiet             print no table')
  end subroutine describe_study

end module asperity_help
