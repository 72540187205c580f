!> What the program says of group &effects: its names, as the scene's reader knows them.
module asperity_effect_help
  use asperity_effect_names, only: effect_number, effect_numbers, effect_words, known_effects, &
                                   needed_for, one_word, whole_number
  use asperity_number_ranges, only: expected_numbers
  use asperity_problems, only: decimal_text
  use asperity_scene_names, only: one_of
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: describe_effects

contains

  !> Every effect with its numbers: values, default, meaning, and the unit between brackets.
  subroutine describe_effects(text)
    type(text_buffer), intent(inout) :: text  !! gets two lines a name
    integer :: i

    call text%line('Names of group &effects in a scene; [unit], in the units of the scene:')
    call text%line('')
    call describe_numbers('', text)
    do i = 1, size(known_effects)
      associate (effect => known_effects(i))
        call two_lines('  ' // effect%name, one_of(effect_words(pack(effect%ways, &
                       effect%ways > 0))) // '; default ' // &
                       trim(merge('''auto''                             ', &
                                  '''auto'' with its numbers, else ''off''', &
                                  effect%name == 'interaction')), effect%meaning, text)
        call describe_numbers(trim(effect%name), text)
      end associate
    end do
  end subroutine describe_effects

  ! The numbers of one effect, or those of all.
  subroutine describe_numbers(effect, text)
    character(len=*), intent(in) :: effect
    type(text_buffer), intent(inout) :: text
    character(len=:), allocatable :: values, unit
    integer :: i

    do i = 1, size(effect_numbers)
      associate (number => effect_numbers(i))
        if (number%effect /= effect) cycle
        values = values_of(number) // '; default ' // default_of(number)
        if (number%needed_with /= '') &
          values = values_of(number) // '; needed with ' // needed_for(number)
        unit = ''
        if (number%unit /= '') unit = ' [' // trim(number%unit) // ']'
        call two_lines('  ' // repeat(' ', min(2, len(effect))) // number%name, values, &
                       trim(number%meaning) // unit, text)
      end associate
    end do
  end subroutine describe_numbers

  ! What a number may be.
  pure function values_of(number) result(values)
    type(effect_number), intent(in) :: number
    character(len=:), allocatable :: values

    select case (number%range)
    case (one_word)
      values = one_of(pack(number%words, number%words /= ''))
    case (whole_number)
      values = 'a whole number from ' // decimal_text(number%least) // ' to ' // &
               decimal_text(number%most)
    case default
      values = trim(expected_numbers(number%range))
    end select
  end function values_of

  ! What it is when the scene does not have it.
  pure function default_of(number) result(default)
    type(effect_number), intent(in) :: number
    character(len=:), allocatable :: default

    default = decimal_text(int(number%default%digits))
    if (number%range == one_word) then
      default = 'none'
      if (number%default%digits > 0) &
        default = '''' // trim(number%words(number%default%digits)) // ''''
    end if
    if (number%default%exponent < 0) &
      default = '0.' // repeat('0', -number%default%exponent - len(default)) // default
  end function default_of

  subroutine two_lines(name, values, meaning, text)
    character(len=*), intent(in) :: name, values, meaning
    type(text_buffer), intent(inout) :: text
    character(len=26) :: margin

    margin = name
    call text%line(margin // values)
    call text%line(repeat(' ', len(margin)) // trim(meaning))
  end subroutine two_lines

end module asperity_effect_help
