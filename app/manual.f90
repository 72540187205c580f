!> The manual page and the completion for a shell, written from the table of options.
module asperity_manual
  use asperity_arguments, only: joined
  use asperity_option_table, only: call_of, commands, options
  use asperity_text_buffer, only: text_buffer
  use asperity_version, only: version
  implicit none
  private

  public :: write_manual_page, write_completion

contains

  !> A page for man(1), in troff.
  subroutine write_manual_page(text)
    type(text_buffer), intent(inout) :: text  !! gets it
    integer :: i, k

    call text%line('.TH ASPERITY 1 "" "asperity ' // version // '" "User Commands"')
    call text%line('.SH NAME')
    call text%line('asperity \- contact between rough surfaces of spherical asperities')
    call text%line('.SH SYNOPSIS')
    do k = 1, size(commands)
      call text%line('.B ' // plain(call_of(k)))
      call text%line('.br')
    end do
    do k = 1, size(commands)
      call text%line('.SH ' // merge('REPORT  ', commands(k)%name, k == 1))
      call text%line(plain(trim(commands(k)%text)))
      do i = 1, size(options)
        if (options(i)%command /= commands(k)%name) cycle
        call text%line('.TP')
        call text%line('.B ' // plain(trim(options(i)%name) // ' ' // trim(options(i)%value)))
        call text%line(plain(trim(options(i)%text)))
      end do
    end do
    call text%line('.SH EXIT STATUS')
    call text%line('0 the chosen model was solved to the stated tolerance, 1 could not be ' // &
                   'computed, 2 bad command line or bad input.')
  end subroutine write_manual_page

  !> Words after a Tab in bash: `source <(asperity --completion)`.
  subroutine write_completion(text)
    type(text_buffer), intent(inout) :: text  !! gets it
    integer :: k

    call text%line('_asperity() {')
    call text%line('  local words cur=${COMP_WORDS[COMP_CWORD]}')
    call text%line('  case ${COMP_WORDS[1]} in')
    do k = 2, size(commands)
      call text%line('    ' // trim(commands(k)%name) // ') words="--help' // &
                     joined(pack(options%name, options%command == commands(k)%name)) // '" ;;')
    end do
    call text%line('    *) words="--help --version --man --completion' // &
                   joined(pack(options%name, options%command == '')) // '" ;;')
    call text%line('  esac')
    call text%line('  COMPREPLY=()')
    call text%line('  if [[ $cur == -* ]]; then')
    call text%line('    COMPREPLY=($(compgen -W "$words" -- "$cur"))')
    call text%line('  elif [[ $COMP_CWORD -eq 1 ]]; then')
    call text%line('    COMPREPLY=($(compgen -W "' // joined(commands(2:)%name) // &
                   '" -- "$cur") $(compgen -f -- "$cur"))')
    call text%line('  else')
    call text%line('    COMPREPLY=($(compgen -f -- "$cur"))')
    call text%line('  fi')
    call text%line('}')
    call text%line('complete -o filenames -F _asperity asperity')
  end subroutine write_completion

  ! Text for troff, where a bare minus becomes a hyphen.
  pure function plain(words) result(text)
    character(len=*), intent(in) :: words
    character(len=:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, len(words)
      if (words(i:i) == '-') text = text // '\'
      text = text // words(i:i)
    end do
  end function plain

end module asperity_manual
