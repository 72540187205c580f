!> The error budget as a table: plus-or-minus of every total, by source.
module asperity_budget_table
  use asperity_error_budget, only: budget_line, error_budget, model_budget, of_approach, of_area, &
                                   of_load, share_given, share_measured, share_unknown
  use asperity_problems, only: real_text
  use asperity_scene_values, only: effect_boundary, effect_words
  use asperity_text_buffer, only: text_buffer
  implicit none
  private

  public :: write_budget

contains

  !> One line a total, and what the columns mean.
  subroutine write_budget(budget, positions, buffer)
    type(error_budget), intent(in) :: budget    !! what was measured
    integer, intent(in) :: positions            !! number of positions
    type(text_buffer), intent(inout) :: buffer  !! gets the text
    type(budget_line) :: total
    character(len=100) :: line
    character(len=:), allocatable :: reference, share
    integer :: i

    call buffer%line('')
    if (positions == 1) then
      call buffer%line('Error budget            value   arithmetic +-         step +-  model +-')
    else
      call buffer%line('Error budget          average   arithmetic +-         step +-  model +-')
    end if
    do i = 1, size(budget%lines)
      total = budget%lines(i)
      share = 'not estimated'
      if (budget%model%known(i) == share_measured) &
        share = ' ' // real_text(budget%model%error(i), 'es9.1e3')
      if (budget%model%known(i) == share_given) share = 'given'
      write (line, '(2x, a14, a15, es14.1e3, es16.1e3, 4x, a)') total%name, &
        real_text(total%value, 'g15.7') // '   ', total%arithmetic, total%step, share
      call buffer%line(line)
    end do
    if (positions > 1) call buffer%line('+- is the largest over the positions.')
    reference = 'bound of the rounding of real64'
    if (budget%without_effects) reference = reference // ', without effects'
    call buffer%line('Arithmetic: ' // reference // '.')
    call buffer%line('Step: none, as events are solved exactly.')
    call write_model(budget%model, buffer)
  end subroutine write_budget

  ! The models that were compared, and the error of the reference.
  subroutine write_model(model, buffer)
    type(model_budget), intent(in) :: model
    type(text_buffer), intent(inout) :: buffer

    if (allocated(model%why_not)) then
      call buffer%line('Model: not estimated: ' // model%why_not // '.')
    else if (model%interaction == effect_boundary) then
      call buffer%line('Model: interaction ''boundary'' is the reference.')
    else
      call buffer%line('Model: interaction ''' // trim(effect_words(model%interaction)) // &
                       ''' against ''boundary'' at the same separation, by the load of')
      call buffer%line('all contacts over their load as isolated contacts, so that both ' // &
                       'include the inclination.')
    end if
    if (.not. allocated(model%why_not)) &
      call buffer%line('Load by boundary elements: relative error ' // &
                       real_text(model%cells_are_good_to, 'es9.1e3') // ' (boundary_tolerance).')
    if (model%known(of_area) == share_measured) &
      call buffer%line('Area: compared in plan; boundary elements with a rim correction, ' // &
                       'relative error about 0.3 %.')
    if (model%known(of_load) /= share_given .and. model%known(of_approach) == share_given) &
      call buffer%line('Separation: given, or that at which an isolated contact reaches its limit.')
    if (model%known(of_load) == share_given .and. model%known(of_approach) == share_measured) &
      call buffer%line('Separation: its change by the error of the model at the given load.')
    if (allocated(model%why_not) .or. all(model%known /= share_unknown)) return
    if (model%interaction == effect_boundary) then
      call buffer%line('Not estimated: no finer model to compare boundary elements with.')
    else
      call buffer%line('Not estimated: at a given load the areas of the two models belong to ' // &
                       'different separations.')
    end if
  end subroutine write_model

end module asperity_budget_table
