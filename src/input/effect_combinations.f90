!> Which effects go together, and why others do not.
module asperity_effect_combinations
  implicit none
  private

  public :: why_not_together

contains

  !> Why two effects are not computed together; empty when they are.
  pure function why_not_together(first, first_way, second, second_way) result(why)
    character(len=*), intent(in) :: first       !! an effect, as in &effects
    character(len=*), intent(in) :: first_way   !! how it is simulated
    character(len=*), intent(in) :: second      !! another one
    character(len=*), intent(in) :: second_way  !! how it is simulated
    character(len=:), allocatable :: why

    why = ''
    if (are('adhesion', 'plasticity')) then
      why = 'the theories of adhesion are elastic'
    else if (are('adhesion', 'creep')) then
      why = 'the theory of creep knows no attraction'
    else if (are('adhesion', 'interaction')) then
      why = 'neighbours are lowered by pressures of Hertz, not by those of adhesion'
    else if (are('adhesion', 'friction')) then
      why = 'shear changes adhesion, and Coulomb''s law knows no attraction'
    else if (are('creep', 'plasticity')) then
      why = 'creep here is that of an elastic contact'
    else if (are('creep', 'friction')) then
      why = 'slip and creep together have no closed theory'
    else if (are('plasticity', 'interaction') .and. &
             (on_cells(first, first_way) .or. on_cells(second, second_way))) then
      why = 'cells are elastic: plasticity goes with interaction = ''coupled'''
    end if
    if (why /= '') why = first // ' and ' // second // ' do not go together: ' // why

  contains

    pure logical function are(one, other)
      character(len=*), intent(in) :: one, other

      are = (first == one .and. second == other) .or. (first == other .and. second == one)
    end function are

    pure logical function on_cells(name, way)
      character(len=*), intent(in) :: name, way

      on_cells = name == 'interaction' .and. way == 'boundary'
    end function on_cells

  end function why_not_together

end module asperity_effect_combinations
