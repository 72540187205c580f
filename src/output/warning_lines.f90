!> The warnings of a run: one line a kind, for the worst position.
module asperity_warning_lines
  use asperity_input_text, only: replaced_text
  use asperity_kinds, only: real64
  use asperity_library_turn, only: library_turn
  use asperity_number_format, only: count_text, percent_text
  use asperity_problems, only: decimal_text, problem_list, real_text
  use asperity_scene_results, only: scene_results
  use asperity_theory_warnings, only: class_names, theory_warning, warning_kinds
  implicit none
  private

  public :: list_warnings

contains

  !> Adds `FILE: warning: position N and M more: what, how much, what to do` for every kind that
  !> applies anywhere, in the order of the kinds; N is the position where it is worst. `kinds` gets
  !> `NAME CLASS` for each line.
  subroutine list_warnings(file, results, lines, kinds)
    character(len=*), intent(in) :: file         !! the scene, as the user named it
    type(scene_results), intent(in) :: results   !! results of a run
    type(problem_list), intent(inout) :: lines   !! gets a line a kind
    type(problem_list), intent(inout), optional :: kinds  !! gets their names
    type(theory_warning) :: worst
    character(len=:), allocatable :: more
    integer :: which, at, i, m, positions
    type(library_turn) :: turn

    call turn%begin()
    do which = 1, size(warning_kinds)
      at = 0
      positions = 0
      do m = 1, size(results%positions)
        if (.not. allocated(results%positions(m)%warnings)) cycle
        associate (found => results%positions(m)%warnings)
          do i = 1, size(found)
            if (found(i)%number /= which) cycle
            positions = positions + 1
            if (at > 0 .and. found(i)%magnitude <= worst%magnitude) cycle
            at = m
            worst = found(i)
          end do
        end associate
      end do
      if (positions == 0) cycle
      more = ''
      if (positions > 1) more = ' and ' // decimal_text(positions - 1) // ' more'
      call lines%add(file // ': warning: position ' // decimal_text(at) // more // ': ' // &
                     in_words(worst))
      if (present(kinds)) call kinds%add(trim(warning_kinds(which)%name) // ' ' // &
                                         trim(class_names(warning_kinds(which)%class)))
    end do
  end subroutine list_warnings

  ! `what, how much, what to do`.
  pure function in_words(warning) result(text)
    type(theory_warning), intent(in) :: warning
    character(len=:), allocatable :: text
    character(len=:), allocatable :: size_text

    associate (which => warning_kinds(warning%number))
      text = replaced_text(trim(which%what), '*', trim(warning%whose))
      if (warning%whose /= '' .and. index(which%what, '*') == 0) &
        text = text // ' (' // trim(warning%whose) // ')'
      if (which%is_share) then
        text = text // ', ' // percent_text(warning%magnitude)
      else if (which%measure /= '') then
        size_text = real_text(warning%magnitude, 'g12.3')
        if (abs(warning%magnitude - anint(warning%magnitude)) <= 0.0_real64 .and. &
            warning%magnitude < 1.0e6_real64) size_text = decimal_text(nint(warning%magnitude))
        text = text // ', ' // size_text
        if (text(len(text):) == '.') text = text(:len(text) - 1)
      end if
      if (which%measure /= '') text = text // ' ' // trim(which%measure)
      if (warning%contacts > 0) text = text // ' at ' // count_text(warning%contacts, 'contact')
      if (warning%whose /= '' .and. which%other_advice /= '') then
        text = text // ', ' // trim(which%other_advice)
      else
        text = text // ', ' // &
               replaced_text(trim(which%advice), '*', trim(warning%whose))
      end if
    end associate
  end function in_words

end module asperity_warning_lines
