!> The warnings of a run: one line a kind, or an effect of it, for the worst position.
module asperity_warning_lines
  use asperity_input_text, only: replaced_text
  use asperity_kinds, only: real64
  use asperity_library_turn, only: library_turn
  use asperity_number_format, only: count_text, percent_text
  use asperity_problems, only: decimal_text, problem_list, real_text
  use asperity_scene_results, only: scene_results
  use asperity_theory_warnings, only: are_alike, class_names, take_worse, theory_warning, &
                                      warning_kinds
  implicit none
  private

  public :: list_warnings

contains

  !> Adds `FILE: warning: position N and M more: what, how much, what to do` for every warning that
  !> applies anywhere, in the order of the kinds; N is the position where it is worst. `kinds` gets
  !> `NAME CLASS` for each line.
  subroutine list_warnings(file, results, lines, kinds)
    character(len=*), intent(in) :: file         !! the scene, as the user named it
    type(scene_results), intent(in) :: results   !! results of a run
    type(problem_list), intent(inout) :: lines   !! gets a line a warning
    type(problem_list), intent(inout), optional :: kinds  !! gets their names
    type(theory_warning), allocatable :: worst(:)  ! with the position in place of the state
    character(len=:), allocatable :: more
    integer :: i, m, positions
    type(library_turn) :: turn

    call turn%begin()
    allocate (worst(0))
    do m = 1, size(results%positions)
      call take_worse(worst, results%positions(m)%warnings, m)
    end do
    do i = 1, size(worst)
      positions = 0
      do m = 1, size(results%positions)
        if (.not. allocated(results%positions(m)%warnings)) cycle
        if (any(are_alike(results%positions(m)%warnings, worst(i)))) positions = positions + 1
      end do
      more = ''
      if (positions > 1) more = ' and ' // decimal_text(positions - 1) // ' more'
      call lines%add(file // ': warning: position ' // decimal_text(worst(i)%state) // more // &
                     ': ' // in_words(worst(i)))
      if (present(kinds)) call kinds%add(trim(warning_kinds(worst(i)%number)%name) // ' ' // &
                                         trim(class_names(warning_kinds(worst(i)%number)%class)))
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
